//! Peak-to-peak values in sliding and adjacent windows of a record.
//!
//! Between samples the record is taken as straight, so that a window need not be a whole number of samples wide.

use crate::numeric::statistics::peak_to_peak;

/// Ranges of a record inside windows of one width.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowedRanges {
    /// The largest over every place the window can be slid to.
    pub sliding: f64,
    /// The largest over windows end to end, the first beginning at the first sample.
    pub fixed: f64,
    /// Those windows one by one.
    pub each: Vec<f64>,
}

/// Ranges in windows of which `count` end to end make the record; a `closed` record goes on at its start after its end.
///
/// An open record ends with its last sample, so its last window is one sample step short.
///
/// # Panics
/// No windows at all: a mistake of the caller.
pub fn windowed_ranges(values: &[f64], count: usize, closed: bool) -> WindowedRanges {
    assert!(count > 0, "at least one window");
    let each = end_to_end(values, count, closed);
    let fixed = each.iter().fold(0.0, |m: f64, &r| m.max(r));
    let sliding = match count == 1 {
        true => peak_to_peak(values),
        false => sliding(values, count, closed).max(fixed),
    };
    WindowedRanges {
        sliding,
        fixed,
        each,
    }
}

/// The record at `whole + part/of` samples.
fn interpolate_at(values: &[f64], whole: usize, part: usize, of: usize, closed: bool) -> f64 {
    let n = values.len();
    let at = |i: usize| match closed {
        true => values[i % n],
        false => values[i.min(n - 1)],
    };
    let share = part as f64 / of as f64;
    match part {
        0 => at(whole),
        _ => at(whole) + share * (at(whole + 1) - at(whole)),
    }
}

/// Least and greatest of nothing.
const NONE: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

/// Least and greatest with one more value, which is a number.
fn widen((low, high): (f64, f64), x: f64) -> (f64, f64) {
    (
        if x < low { x } else { low },
        if x > high { x } else { high },
    )
}

fn end_to_end(values: &[f64], count: usize, closed: bool) -> Vec<f64> {
    let n = values.len();
    if n == 0 {
        return vec![0.0; count];
    }
    // The border before window j lies at j·n/count samples; whole and broken part apart, so that nothing is rounded.
    let border = |j: usize| {
        let exact = j as u64 * n as u64;
        let (whole, part) = (exact / count as u64, exact % count as u64);
        (whole as usize, part as usize)
    };
    let window = |j: usize| {
        let ((from, from_part), (to, to_part)) = (border(j), border(j + 1));
        let ends = [
            interpolate_at(values, from, from_part, count, closed),
            interpolate_at(values, to, to_part, count, closed),
        ];
        let inside = &values[(from + usize::from(from_part > 0)).min(n)..(to + 1).min(n)];
        let range = ends.into_iter().chain(inside.iter().copied());
        let (low, high) = range.fold(NONE, widen);
        high - low
    };
    (0..count).map(window).collect()
}

/// The largest difference between two places at most one window apart. The record is straight between samples, so such a pair has
/// both places on samples, or one on a sample and the other a whole window away.
fn sliding(values: &[f64], count: usize, closed: bool) -> f64 {
    let n = values.len();
    let (whole, part) = (n / count, n % count);
    let share = part as f64 / count as f64;
    let last = if closed { n + whole } else { n };
    let at = |i: usize| values[if i < n { i } else { i - n }];
    // Extremes of whole + 1 samples: of the end of one block of that length and the beginning of the next (van Herk, Pattern Recognition
    // Letters 13 (1992) 517).
    let width = (whole + 1).min(last);
    // Extremes of each sample of the block before and of those after it there.
    let mut ends = vec![NONE; width + 1];
    let mut block = Vec::with_capacity(width);
    let mut largest = 0.0f64;
    for start in (0..last).step_by(width) {
        block.clear();
        block.extend((start..(start + width).min(last)).map(at));
        let mut seen = NONE;
        for (&x, end) in block.iter().zip(&ends[1..]) {
            seen = widen(seen, x);
            let low = if end.0 < seen.0 { end.0 } else { seen.0 };
            let high = if end.1 > seen.1 { end.1 } else { seen.1 };
            largest = largest.max(high - low);
        }
        let mut seen = NONE;
        for (&x, end) in block.iter().zip(&mut ends).rev() {
            seen = widen(seen, x);
            *end = seen;
        }
    }
    if part > 0 {
        let starts = if closed {
            n
        } else {
            n.saturating_sub(whole + 1)
        };
        let wrapped = |i: usize| values[i % n];
        for i in 0..starts {
            let (near, far) = (wrapped(i + whole), wrapped(i + whole + 1));
            // From sample i a window on, and from the sample beyond a window back.
            largest = largest.max((near + share * (far - near) - values[i]).abs());
            let back = wrapped(i + 1) + share * (values[i] - wrapped(i + 1));
            largest = largest.max((far - back).abs());
        }
    }
    largest
}
