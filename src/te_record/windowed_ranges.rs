//! Peak-to-peak values in sliding and adjacent windows of a record.
//!
//! The record is interpolated linearly, so that the window width need not be a whole number of samples.

use crate::numeric::statistics::peak_to_peak;

/// Peak-to-peak values of a record in windows of one width.
#[derive(Debug, Clone, PartialEq)]
pub struct WindowedRanges {
    /// Maximum over all positions of a sliding window.
    pub sliding: f64,
    /// Maximum over adjacent windows, the first of which begins at the first sample.
    pub fixed: f64,
    /// Peak-to-peak value of each adjacent window.
    pub each: Vec<f64>,
}

/// Peak-to-peak values in windows of which `count` adjacent ones make the record; a `closed` record is periodic.
///
/// An open record ends with its last sample, so its last window is one sample step short.
///
/// # Panics
/// If `count` is zero.
pub fn windowed_ranges(values: &[f64], count: usize, closed: bool) -> WindowedRanges {
    assert!(count > 0, "at least one window");
    let each = adjacent_ranges(values, count, closed);
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

/// Record at `index + part/count` samples, by linear interpolation.
fn interpolate(values: &[f64], index: usize, part: usize, count: usize, closed: bool) -> f64 {
    let n = values.len();
    let sample = |i: usize| match closed {
        true => values[i % n],
        false => values[i.min(n - 1)],
    };
    let share = part as f64 / count as f64;
    match part {
        0 => sample(index),
        _ => sample(index) + share * (sample(index + 1) - sample(index)),
    }
}

/// Minimum and maximum of an empty set.
const EMPTY: (f64, f64) = (f64::INFINITY, f64::NEG_INFINITY);

/// Minimum and maximum with one more value, which is not NaN.
fn widen((low, high): (f64, f64), x: f64) -> (f64, f64) {
    (
        if x < low { x } else { low },
        if x > high { x } else { high },
    )
}

fn adjacent_ranges(values: &[f64], count: usize, closed: bool) -> Vec<f64> {
    let n = values.len();
    if n == 0 {
        return vec![0.0; count];
    }
    // Window j begins at j·n/count samples; integer quotient and remainder avoid rounding.
    let boundary = |j: usize| {
        let product = j as u64 * n as u64;
        let (index, remainder) = (product / count as u64, product % count as u64);
        (index as usize, remainder as usize)
    };
    let window = |j: usize| {
        let ((from, from_part), (to, to_part)) = (boundary(j), boundary(j + 1));
        let ends = [
            interpolate(values, from, from_part, count, closed),
            interpolate(values, to, to_part, count, closed),
        ];
        let inside = &values[(from + usize::from(from_part > 0)).min(n)..(to + 1).min(n)];
        let range = ends.into_iter().chain(inside.iter().copied());
        let (low, high) = range.fold(EMPTY, widen);
        high - low
    };
    (0..count).map(window).collect()
}

/// Largest difference between two positions at most one window apart. Since the record is linear between samples, both positions lie on
/// samples, or one on a sample and the other exactly one window away.
fn sliding(values: &[f64], count: usize, closed: bool) -> f64 {
    let n = values.len();
    let (quotient, remainder) = (n / count, n % count);
    let share = remainder as f64 / count as f64;
    let last = if closed { n + quotient } else { n };
    let sample = |i: usize| values[if i < n { i } else { i - n }];
    // Extremes of quotient + 1 samples, from the suffix of one block of that length and the prefix of the next (van Herk, Pattern
    // Recognition Letters 13 (1992) 517).
    let width = (quotient + 1).min(last);
    // Extremes from each sample of the previous block to its end.
    let mut suffixes = vec![EMPTY; width + 1];
    let mut block = Vec::with_capacity(width);
    let mut largest = 0.0f64;
    for start in (0..last).step_by(width) {
        block.clear();
        block.extend((start..(start + width).min(last)).map(sample));
        let mut prefix = EMPTY;
        for (&x, tail) in block.iter().zip(&suffixes[1..]) {
            prefix = widen(prefix, x);
            let low = if tail.0 < prefix.0 { tail.0 } else { prefix.0 };
            let high = if tail.1 > prefix.1 { tail.1 } else { prefix.1 };
            largest = largest.max(high - low);
        }
        let mut suffix = EMPTY;
        for (&x, tail) in block.iter().zip(&mut suffixes).rev() {
            suffix = widen(suffix, x);
            *tail = suffix;
        }
    }
    if remainder > 0 {
        let starts = if closed {
            n
        } else {
            n.saturating_sub(quotient + 1)
        };
        let wrapped = |i: usize| values[i % n];
        for i in 0..starts {
            let (before, after) = (wrapped(i + quotient), wrapped(i + quotient + 1));
            // One window forward from sample i, and one window back from the next sample after it.
            largest = largest.max((before + share * (after - before) - values[i]).abs());
            let back = wrapped(i + 1) + share * (values[i] - wrapped(i + 1));
            largest = largest.max((after - back).abs());
        }
    }
    largest
}
