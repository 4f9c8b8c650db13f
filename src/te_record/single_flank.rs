//! Single-flank record e(φ): F_is, f_is, long and short wave, harmonics.
//!
//! `e(φ) = Σ a_k cos(kφ/T + ψ_k)` over T turns; orders below z/2 are the long wave (eccentricity, cumulative pitch), the others the
//! short wave (single pitch, profile), after VDI/VDE 2608. Every result is in the unit of the samples.

use super::windowed_ranges::{self, WindowedRanges};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;
use crate::numeric::statistics::peak_to_peak;

/// Fewest samples in a tooth pitch: with fewer the mesh order itself is beyond half the sampling.
const MIN_SAMPLES_PER_PITCH: usize = 2;

/// A transmission error sampled at even steps of angle.
#[derive(Debug, Clone, Copy)]
pub struct SingleFlankRecord<'a> {
    values: &'a [f64],
    turns: usize,
    teeth: usize,
    closed: bool,
}

/// A record parted in two; the parts add up to it.
#[derive(Debug, Clone)]
pub struct WaveSplit {
    /// Long-wave component over many teeth, including the mean.
    pub long: Vec<f64>,
    /// Short-wave component: the remainder.
    pub short: Vec<f64>,
    /// f_l′: range of the long wave over the record.
    pub long_range: f64,
    /// f_k′: ranges of the short wave inside one pitch.
    pub short_ranges: WindowedRanges,
}

/// One line: `amplitude · cos(order · φ + phase)`, φ the angle of the gear from the first sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TeHarmonic {
    /// Periods in the record; the order per turn is `line / turns`.
    pub line: usize,
    /// Turns of the record.
    pub turns: usize,
    /// Zero to peak; of line 0 the mean, with its sign.
    pub amplitude: f64,
    /// Rad, in (−π, π].
    pub phase: f64,
}

impl TeHarmonic {
    /// Periods per turn of the gear.
    pub fn order(&self) -> f64 {
        self.line as f64 / self.turns as f64
    }
}

impl<'a> SingleFlankRecord<'a> {
    /// `values` cover exactly `turns` turns of a gear of `teeth` teeth; sample i lies at `2π turns i / n`, so the end of the last turn is
    /// not sampled again. `closed`: after the last sample the first follows, as after one turn of a gear against a master
    /// that does not err, or after the full hunting cycle of a pair.
    ///
    /// # Errors
    /// `OutOfRange`: no turn, no tooth. `NotANumber`: a sample that is not finite. `TooShort`: fewer than two samples a pitch.
    pub fn new(
        values: &'a [f64],
        turns: usize,
        teeth: usize,
        closed: bool,
    ) -> Result<SingleFlankRecord<'a>, Error> {
        let pitches = turns.checked_mul(teeth).filter(|&n| n > 0);
        let Some(pitches) = pitches else {
            let message = format!("a record over {turns} turns of {teeth} teeth has no pitch");
            return Err(Error::new(Code::OutOfRange, message));
        };
        // All are looked at, which is quicker than to stop at the first.
        let finite = values.iter().fold(true, |all, x| all & x.is_finite());
        if !finite && let Some(i) = values.iter().position(|x| !x.is_finite()) {
            let message = format!(
                "sample {} of the transmission error is {}",
                i + 1,
                values[i]
            );
            return Err(Error::new(Code::NotANumber, message));
        }
        if values.len() / MIN_SAMPLES_PER_PITCH < pitches {
            let per_pitch = values.len() as f64 / pitches as f64;
            let message = format!(
                "{} samples over {pitches} pitches are {per_pitch:.2} a pitch",
                values.len()
            );
            return Err(Error::new(Code::TooShort, message).with_hint(
                "at least 2 are needed to separate the mesh order from its aliases, 20 or more for the form of a tooth",
            ));
        }
        Ok(SingleFlankRecord {
            values,
            turns,
            teeth,
            closed,
        })
    }

    /// Turns until a gear of `teeth` teeth meets its mate of `mate` teeth as at first: the full hunting cycle.
    pub fn hunting_turns(teeth: usize, mate: usize) -> usize {
        mate / gcd(teeth, mate).max(1)
    }

    /// F_i′ over the whole record.
    pub fn total_deviation(&self) -> f64 {
        peak_to_peak(self.values)
    }

    /// F_i′ over one turn, wherever it begins, and turn by turn.
    pub fn ranges_per_rev(&self) -> WindowedRanges {
        windowed_ranges::windowed_ranges(self.values, self.turns, self.closed)
    }

    /// f_i′ of the raw record, as ISO 1328-1:1995 reads it: the window of one pitch slid freely, and tooth by tooth.
    pub fn ranges_per_pitch(&self) -> WindowedRanges {
        self.pitches_of(self.values)
    }

    fn pitches_of(&self, values: &[f64]) -> WindowedRanges {
        windowed_ranges::windowed_ranges(values, self.turns * self.teeth, self.closed)
    }

    /// Long wave: orders below z/2 by Fourier's sum, exactly. An open record is mirrored at its ends first, so that the step from
    /// its end to its start is no part of either wave.
    pub fn split_by_order(&self) -> WaveSplit {
        self.split_with(self.long_wave_by_order())
    }

    /// The long wave of [`SingleFlankRecord::split_by_order`] alone.
    pub fn long_wave_by_order(&self) -> Vec<f64> {
        let n = self.values.len();
        let mut samples = self.values.to_vec();
        if !self.closed {
            samples.extend(self.values.iter().rev());
        }
        let mut fft = RealFft::new(samples.len());
        let mut spectrum = vec![Complex::new(0.0, 0.0); fft.lines()];
        fft.forward(&mut samples, &mut spectrum);
        // A line of the record itself has order line/turns; mirrored, it is twice as long.
        let length = if self.closed { 1 } else { 2 };
        let first_short = (self.turns * self.teeth * length).div_ceil(2);
        let cut = first_short.min(spectrum.len());
        spectrum[cut..].fill(Complex::new(0.0, 0.0));
        fft.inverse(&mut spectrum, &mut samples);
        samples.truncate(n);
        samples
    }

    /// Long wave: the mean over one pitch about each place. Near the ends of an open record the pitch is the first or last whole
    /// one. Passes the order z/2 by 64 %; tooth meshing it stops.
    pub fn split_by_pitch_average(&self) -> WaveSplit {
        self.split_with(self.long_wave_by_pitch_average())
    }

    /// The long wave of [`SingleFlankRecord::split_by_pitch_average`] alone.
    pub fn long_wave_by_pitch_average(&self) -> Vec<f64> {
        let n = self.values.len();
        let width = n as f64 / (self.turns * self.teeth) as f64;
        let (whole, part) = ((0.5 * width) as usize, (0.5 * width).fract());
        // Straight between samples, the record passes into the integral over a pitch with the weight 1 inside, at its ends with these.
        let (outer, inner) = (0.5 * part * part, 0.5 * (1.0 - part) * (1.0 - part));
        let reach = whole + 1;
        let v = |i: usize| self.values[if i < n { i } else { i % n }];
        // From sample `reach` on; the places before and after are those of a closed record beyond its ends.
        let mut sum: f64 = (1..2 * reach).map(v).sum();
        let mut long = Vec::with_capacity(n);
        for i in 0..if self.closed {
            n
        } else {
            n.saturating_sub(2 * reach)
        } {
            let (a, b, c, d) = (v(i), v(i + 1), v(i + 2 * reach - 1), v(i + 2 * reach));
            long.push((sum - inner * (b + c) + outer * (a + d)) / width);
            sum += d - b;
        }
        if self.closed {
            long.rotate_right(reach);
            return long;
        }
        // The first and the last whole pitch.
        let end = |v: &dyn Fn(usize) -> f64| {
            let (whole, part) = (width as usize, width.fract());
            let last = part * v(whole) + 0.5 * part * part * (v(whole + 1) - v(whole));
            let inside: f64 = (0..whole).map(|i| 0.5 * (v(i) + v(i + 1))).sum();
            (inside + last) / width
        };
        let ends = [
            end(&|i| self.values[i.min(n - 1)]),
            end(&|i| self.values[(n - 1).saturating_sub(i)]),
        ];
        let before = vec![ends[0]; reach.min(n)];
        let after = vec![ends[1]; n - before.len() - long.len()];
        [before, long, after].concat()
    }

    fn split_with(&self, long: Vec<f64>) -> WaveSplit {
        let short: Vec<f64> = self.values.iter().zip(&long).map(|(e, l)| e - l).collect();
        WaveSplit {
            long_range: peak_to_peak(&long),
            short_ranges: self.pitches_of(&short),
            long,
            short,
        }
    }

    /// Lines up to an order per turn, the mean first. Of an open record, orders that are no whole number of periods in it spread over
    /// their neighbours.
    pub fn harmonics(&self, highest_order: f64) -> Vec<TeHarmonic> {
        let n = self.values.len();
        let mut samples = self.values.to_vec();
        let mut fft = RealFft::new(n);
        let mut spectrum = vec![Complex::new(0.0, 0.0); fft.lines()];
        fft.forward(&mut samples, &mut spectrum);
        let harmonic = |(line, z): (usize, &Complex)| {
            // The mean and the line at half the sampling have no mirror image to share with.
            let alone = line == 0 || 2 * line == n;
            let scale = if alone { 1.0 } else { 2.0 } / n as f64;
            TeHarmonic {
                line,
                turns: self.turns,
                amplitude: scale * if line == 0 { z.re } else { z.norm() },
                phase: if line == 0 { 0.0 } else { z.im.atan2(z.re) },
            }
        };
        spectrum
            .iter()
            .enumerate()
            .take_while(|(line, _)| *line as f64 <= highest_order * self.turns as f64)
            .map(harmonic)
            .collect()
    }
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}
