//! Encoder readings in blocks, unwrapped to angles `θ = unit (reading + wrap turns)`.

use crate::base::code::Code;
use crate::base::error::Error;

/// Rows handed on at a time.
pub const BLOCK: usize = 1 << 10;

/// Readings of both encoders, taken at the same instants.
pub trait EncoderReadings {
    /// Number of rows.
    fn n_rows(&self) -> usize;

    /// Fills both blocks with the readings from row `from` on.
    ///
    /// # Errors
    /// They cannot be read.
    fn read(&self, from: usize, input: &mut [f64], output: &mut [f64]) -> Result<(), Error>;
}

/// Readings in memory, of the input and of the output.
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

/// Some of the rows.
pub struct ReadingsRange<'a> {
    /// All.
    pub rows: &'a dyn EncoderReadings,
    /// The first of them.
    pub from: usize,
    /// So many.
    pub count: usize,
}

impl EncoderReadings for ReadingsRange<'_> {
    fn n_rows(&self) -> usize {
        self.count
    }

    fn read(&self, from: usize, input: &mut [f64], output: &mut [f64]) -> Result<(), Error> {
        self.rows.read(self.from + from, input, output)
    }
}

/// Scale of an encoder's readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EncoderScale {
    /// Rad a unit of the readings; negative where it counts against the other shaft.
    pub unit: f64,
    /// The readings begin again after so many units.
    pub wrap: Option<f64>,
    /// From one reading to the next that it can give, rad; 0 where it is not quantised.
    pub step: f64,
}

impl EncoderScale {
    /// Angles in rad without steps.
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

/// Hands all rows on as angles in rad, block by block: `see(first row, input, output)`.
///
/// # Errors
/// The readings cannot be read; `NotANumber`.
pub fn for_each_block(
    rows: &dyn EncoderReadings,
    scales: EncoderScales,
    mut see: impl FnMut(usize, &[f64], &[f64]),
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
        let sound = pairs.fold(true, |sound, (x, y)| sound & (x + y).is_finite());
        if !sound {
            let at = (0..n).find(|&i| !(a[i] + b[i]).is_finite()).unwrap_or(0);
            let which = if a[at].is_finite() { "output" } else { "input" };
            let message = format!("row {} of the {which} is no finite number", from + at + 1);
            return Err(Error::new(Code::NotANumber, message)
                .with_hint("take a segment without it, or bridge it: --fill-gaps"));
        }
        see(from, &a[..n], &b[..n]);
        from += n;
    }
    Ok(())
}

/// Readings made to go on.
struct Unwrapper {
    scale: EncoderScale,
    before: Option<f64>,
    turns: f64,
}

impl Unwrapper {
    fn new(scale: EncoderScale) -> Unwrapper {
        Unwrapper {
            scale,
            before: None,
            turns: 0.0,
        }
    }

    fn unwrap_block(&mut self, block: &mut [f64]) {
        let unit = self.scale.unit;
        let Some(wrap) = self.scale.wrap else {
            block.iter_mut().for_each(|x| *x *= unit);
            return;
        };
        for x in block {
            let before = self.before.replace(*x).unwrap_or(*x);
            let step = *x - before;
            // Far more rows go on than wrap.
            if step.abs() > 0.5 * wrap {
                self.turns -= (step / wrap).round();
            }
            *x = unit * (*x + self.turns * wrap);
        }
    }
}

/// The period after which readings begin again, one of `known`: far more than what they move from row to row is a jump, and all jumps are
/// of about that size. Nothing where no reading jumps.
///
/// # Errors
/// `LostCounts`: readings that jump by something else.
pub fn detect_wrap(
    rows: &dyn EncoderReadings,
    is_output: bool,
    name: &str,
    known: &[f64],
) -> Result<Option<f64>, Error> {
    let smallest = known.iter().copied().fold(f64::INFINITY, f64::min);
    let usual = typical_step(rows, is_output)?;
    let least = 2.0 * usual + 0.02 * smallest;
    let (mut before, mut jumps) = (None, Vec::new());
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
            let step: f64 = x - before.replace(x).unwrap_or(x);
            if step.abs() > least {
                jumps.push((from + i, step));
            }
        }
        from += n;
    }
    if jumps.is_empty() {
        return Ok(None);
    }
    // The step that the shaft makes meanwhile is taken off the jump or added to it.
    let fits = |w: f64| {
        jumps
            .iter()
            .all(|j| (j.1.abs() - w).abs() <= 1.5 * usual + 0.02 * w)
    };
    if let Some(&found) = known.iter().find(|w| fits(**w)) {
        return Ok(Some(found));
    }
    // Single jumps of another size are lost counts, which are told by their effect on the error.
    const MIN_ROWS: usize = 64;
    let largest = jumps.iter().map(|j| j.1.abs()).fold(0.0, f64::max);
    if jumps.len() <= MIN_ROWS && largest < 0.25 * smallest {
        return Ok(None);
    }
    let (row, step) = jumps[0];
    let message = format!("{name} jumps by {step:.6} at row {}", row + 1);
    Err(Error::new(Code::LostCounts, message)
        .with_hint("no counter or angle begins again after that: take the segment before or after it (--after, --before), or state what the readings are (--unit, --lines)"))
}

/// Typical step of the readings from row to row: the 99th percentile over rows here and there.
fn typical_step(rows: &dyn EncoderReadings, is_output: bool) -> Result<f64, Error> {
    const PLACES: usize = 64;
    const LENGTH: usize = 256;
    let count = rows.n_rows();
    let length = LENGTH.min(count);
    let (mut a, mut b) = (vec![0.0; length], vec![0.0; length]);
    let mut steps = Vec::with_capacity(PLACES * LENGTH);
    for place in 0..PLACES {
        let from = (count - length) * place / (PLACES - 1);
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

    /// A counter of 16 bits up, an angle in degrees down, over several blocks.
    #[test]
    fn exact_wrapped_readings() {
        let up = ramp(37.3, 65536.0);
        let down: Vec<f64> = ramp(0.7, 360.0).iter().map(|x| 359.0 - x).collect();
        let rows = MemoryReadings(&up, &down);
        let known = [256.0, 65536.0];
        assert_eq!(
            detect_wrap(&rows, false, "a", &known).unwrap(),
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
