//! Encoder readings in blocks, unwrapped to angles `θ = unit (reading + wrap turns)`.

use crate::base::code::Code;
use crate::base::error::Error;

/// Number of rows per block.
pub const BLOCK: usize = 1 << 10;

/// Readings of both encoders, taken at the same instants.
pub trait EncoderReadings {
    /// Number of rows.
    fn n_rows(&self) -> usize;

    /// Fills both blocks with the readings that start at row `from`.
    ///
    /// # Errors
    /// The readings cannot be read.
    fn read(&self, from: usize, input: &mut [f64], output: &mut [f64]) -> Result<(), Error>;
}

/// Readings of input and output in memory.
#[derive(Debug, Clone, Copy)]
pub struct MemoryReadings<'a>(pub &'a [f64], pub &'a [f64]);

impl EncoderReadings for MemoryReadings<'_> {
    fn n_rows(&self) -> usize {
        self.0.len().min(self.1.len())
    }

    fn read(&self, from: usize, input: &mut [f64], output: &mut [f64]) -> Result<(), Error> {
        input.copy_from_slice(&self.0[from..from + input.len()]);
        output.copy_from_slice(&self.1[from..from + output.len()]);
        Ok(())
    }
}

/// Contiguous rows of readings.
pub struct ReadingsRange<'a> {
    /// Complete readings.
    pub rows: &'a dyn EncoderReadings,
    /// Index of the first row.
    pub first: usize,
    /// Number of rows.
    pub count: usize,
}

impl EncoderReadings for ReadingsRange<'_> {
    fn n_rows(&self) -> usize {
        self.count
    }

    fn read(&self, from: usize, input: &mut [f64], output: &mut [f64]) -> Result<(), Error> {
        self.rows.read(self.first + from, input, output)
    }
}

/// Scale of an encoder's readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EncoderScale {
    /// Angle per unit of the readings, rad; negative if the encoder counts against the other shaft.
    pub unit: f64,
    /// Period of the readings, units; `None` for readings without wrap.
    pub wrap: Option<f64>,
    /// Quantisation step, rad; 0 without quantisation.
    pub step: f64,
}

impl EncoderScale {
    /// Angles in rad without wrap and quantisation.
    pub const RAD: EncoderScale = EncoderScale {
        unit: 1.0,
        wrap: None,
        step: 0.0,
    };
}

/// Scales of the encoders of both shafts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EncoderScales {
    /// Scale of the input encoder.
    pub input: EncoderScale,
    /// Scale of the output encoder.
    pub output: EncoderScale,
}

/// Calls `visit(first row, input, output)` for every block of rows, with unwrapped angles in rad.
///
/// # Errors
/// The readings cannot be read; `NotANumber`.
pub fn for_each_block(
    rows: &dyn EncoderReadings,
    scales: EncoderScales,
    mut visit: impl FnMut(usize, &[f64], &[f64]),
) -> Result<(), Error> {
    let count = rows.n_rows();
    let (mut a, mut b) = (vec![0.0; BLOCK.min(count)], vec![0.0; BLOCK.min(count)]);
    let (mut input, mut output) = (Unwrapper::new(scales.input), Unwrapper::new(scales.output));
    let mut from = 0;
    while from < count {
        let n = BLOCK.min(count - from);
        rows.read(from, &mut a[..n], &mut b[..n])?;
        input.unwrap_block(&mut a[..n]);
        output.unwrap_block(&mut b[..n]);
        let pairs = a[..n].iter().zip(&b[..n]);
        let is_finite = pairs.fold(true, |is_finite, (x, y)| is_finite & (x + y).is_finite());
        if !is_finite {
            let i = (0..n).find(|&i| !(a[i] + b[i]).is_finite()).unwrap_or(0);
            let shaft = if a[i].is_finite() { "output" } else { "input" };
            let message = format!("row {} of the {shaft} is not a finite number", from + i + 1);
            return Err(Error::new(Code::NotANumber, message)
                .with_hint("choose a segment without it, or interpolate it: --fill-gaps"));
        }
        visit(from, &a[..n], &b[..n]);
        from += n;
    }
    Ok(())
}

/// Unwrapping state of an encoder; `wraps` is the number of periods passed.
struct Unwrapper {
    scale: EncoderScale,
    previous: Option<f64>,
    wraps: f64,
}

impl Unwrapper {
    fn new(scale: EncoderScale) -> Unwrapper {
        Unwrapper {
            scale,
            previous: None,
            wraps: 0.0,
        }
    }

    fn unwrap_block(&mut self, block: &mut [f64]) {
        let unit = self.scale.unit;
        let Some(wrap) = self.scale.wrap else {
            block.iter_mut().for_each(|x| *x *= unit);
            return;
        };
        for x in block {
            let previous = self.previous.replace(*x).unwrap_or(*x);
            let step = *x - previous;
            // Most rows do not wrap.
            if step.abs() > 0.5 * wrap {
                self.wraps -= (step / wrap).round();
            }
            *x = unit * (*x + self.wraps * wrap);
        }
    }
}

/// Detects the wrap period of readings among the candidates `periods`: a jump is a step far above the typical one, and all jumps must have
/// about the size of the period. `None` without jumps.
///
/// # Errors
/// `LostCounts`: jumps of another size.
pub fn detect_wrap(
    rows: &dyn EncoderReadings,
    is_output: bool,
    name: &str,
    periods: &[f64],
) -> Result<Option<f64>, Error> {
    let smallest = periods.iter().copied().fold(f64::INFINITY, f64::min);
    let typical = typical_step(rows, is_output)?;
    let threshold = 2.0 * typical + 0.02 * smallest;
    let (mut previous, mut jumps) = (None, Vec::new());
    let count = rows.n_rows();
    let (mut a, mut b) = (vec![0.0; BLOCK.min(count)], vec![0.0; BLOCK.min(count)]);
    let mut from = 0;
    while from < count {
        let n = BLOCK.min(count - from);
        rows.read(from, &mut a[..n], &mut b[..n])?;
        for (i, &x) in (if is_output { &b[..n] } else { &a[..n] })
            .iter()
            .enumerate()
        {
            let step: f64 = x - previous.replace(x).unwrap_or(x);
            if step.abs() > threshold {
                jumps.push((from + i, step));
            }
        }
        from += n;
    }
    if jumps.is_empty() {
        return Ok(None);
    }
    // The rotation within the row adds to the jump or reduces it.
    let fits = |w: f64| {
        jumps
            .iter()
            .all(|j| (j.1.abs() - w).abs() <= 1.5 * typical + 0.02 * w)
    };
    if let Some(&wrap) = periods.iter().find(|w| fits(**w)) {
        return Ok(Some(wrap));
    }
    // Isolated jumps of another size are lost counts, which the error analysis detects.
    const MIN_ROWS: usize = 64;
    let largest = jumps.iter().map(|j| j.1.abs()).fold(0.0, f64::max);
    if jumps.len() <= MIN_ROWS && largest < 0.25 * smallest {
        return Ok(None);
    }
    let (row, step) = jumps[0];
    let message = format!("{name} jumps by {step:.6} at row {}", row + 1);
    Err(Error::new(Code::LostCounts, message)
        .with_hint("no counter or angle wraps there: choose the segment before or after it (--after, --before), or state what the readings are (--unit, --lines)"))
}

/// Typical step of the readings from row to row: 99th percentile over evenly spaced blocks.
fn typical_step(rows: &dyn EncoderReadings, is_output: bool) -> Result<f64, Error> {
    const N_BLOCKS: usize = 64;
    const LENGTH: usize = 256;
    let count = rows.n_rows();
    let length = LENGTH.min(count);
    let (mut a, mut b) = (vec![0.0; length], vec![0.0; length]);
    let mut steps = Vec::with_capacity(N_BLOCKS * LENGTH);
    for k in 0..N_BLOCKS {
        let from = (count - length) * k / (N_BLOCKS - 1);
        rows.read(from, &mut a, &mut b)?;
        let block = if is_output { &b } else { &a };
        steps.extend(block.windows(2).map(|w| (w[1] - w[0]).abs()));
    }
    steps.sort_by(f64::total_cmp);
    Ok(steps.get(steps.len() * 99 / 100).copied().unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(step: f64, wrap: f64) -> Vec<f64> {
        (0..40_000)
            .map(|i| (step * f64::from(i)).rem_euclid(wrap).floor())
            .collect()
    }

    /// A rising 16-bit counter and a falling angle in degrees, over several blocks.
    #[test]
    fn exact_wrapped_readings() {
        let up = ramp(37.3, 65536.0);
        let down: Vec<f64> = ramp(0.7, 360.0).iter().map(|x| 359.0 - x).collect();
        let rows = MemoryReadings(&up, &down);
        let periods = [256.0, 65536.0];
        assert_eq!(
            detect_wrap(&rows, false, "a", &periods).unwrap(),
            Some(65536.0)
        );
        assert_eq!(
            detect_wrap(&rows, true, "b", &[360.0]).unwrap(),
            Some(360.0)
        );
        let scale = |unit, w| EncoderScale {
            unit,
            wrap: Some(w),
            step: 0.0,
        };
        let scales = EncoderScales {
            input: scale(1.0, 65536.0),
            output: scale(-1.0, 360.0),
        };
        let mut last = (0.0, 0.0);
        for_each_block(&rows, scales, |_, a, b| {
            last = (a[a.len() - 1], b[b.len() - 1]);
        })
        .unwrap();
        assert_eq!(last.0, (37.3_f64 * 39_999.0).floor());
        assert!((last.1 + 359.0 - (0.7_f64 * 39_999.0).floor()).abs() < 1.5);
    }

    #[test]
    fn refuses_jumps_and_gaps() {
        let mut a = ramp(3.0, 1e9);
        a[500..].iter_mut().for_each(|x| *x += 5000.0);
        let rows = MemoryReadings(&a, &a);
        let error = detect_wrap(&rows, false, "a", &[4096.0]).unwrap_err();
        assert!(error.message.contains("row 501"), "{error}");
        let b = [0.0, f64::NAN, 1.0];
        let scales = EncoderScales {
            input: EncoderScale::RAD,
            output: EncoderScale::RAD,
        };
        let error =
            for_each_block(&MemoryReadings(&b[..], &[0.0; 3]), scales, |_, _, _| {}).unwrap_err();
        assert_eq!(error.code, Code::NotANumber);
        assert!(error.message.contains("row 2 of the input"), "{error}");
    }
}
