//! Single-flank composite deviation e(φ): F_is, f_is, long-wave and short-wave components, harmonics.
//!
//! `e(φ) = Σ a_k cos(kφ/T + ψ_k)` over T revolutions; orders below z/2 are the long wave (eccentricity, cumulative pitch), the others the
//! short wave (single pitch, profile), after VDI/VDE 2608. Results are in the unit of the samples.

use super::windowed_ranges::{self, WindowedRanges};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;
use crate::numeric::statistics::peak_to_peak;

/// Minimum number of samples per pitch: the mesh order must not exceed the Nyquist order.
const MIN_SAMPLES_PER_PITCH: usize = 2;

/// Transmission error sampled at equal angle steps.
#[derive(Debug, Clone, Copy)]
pub struct SingleFlankRecord<'a> {
    values: &'a [f64],
    turns: usize,
    teeth: usize,
    closed: bool,
}

/// Long-wave and short-wave components of a record; their sum is the record.
#[derive(Debug, Clone)]
pub struct WaveSplit {
    /// Long-wave component over many teeth, including the mean.
    pub long: Vec<f64>,
    /// Short-wave component: the remainder.
    pub short: Vec<f64>,
    /// f_l′: peak-to-peak value of the long wave over the record.
    pub long_range: f64,
    /// f_k′: peak-to-peak values of the short wave within one pitch.
    pub short_ranges: WindowedRanges,
}

/// Harmonic `amplitude · cos(order · φ + phase)`, φ the rotation of the gear from the first sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TeHarmonic {
    /// Number of periods in the record; the order is `line / turns`.
    pub line: usize,
    /// Number of revolutions of the record.
    pub turns: usize,
    /// Amplitude, 0 to peak; for line 0 the signed mean.
    pub amplitude: f64,
    /// Phase in (−π, π], rad.
    pub phase: f64,
}

impl TeHarmonic {
    /// Order: periods per revolution of the gear.
    pub fn order(&self) -> f64 {
        self.line as f64 / self.turns as f64
    }
}

impl<'a> SingleFlankRecord<'a> {
    /// Record of exactly `turns` revolutions of a gear of `teeth` teeth; sample i is at `2π turns i / n`, so the end of the last
    /// revolution is not sampled again. `closed`: periodic, as after one revolution against an error-free master gear, or after the
    /// full hunting cycle of a pair.
    ///
    /// # Errors
    /// `OutOfRange`: no revolution, no tooth. `NotANumber`: a sample that is not finite. `TooShort`: fewer than two samples a pitch.
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
        // A loop over all samples is faster than one with an early exit.
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
                "{} samples over {pitches} pitches are {per_pitch:.2} per pitch",
                values.len()
            );
            return Err(Error::new(Code::TooShort, message).with_hint(
                "record at least 2 to separate the mesh order from its aliases, 20 or more for the form of a tooth",
            ));
        }
        Ok(SingleFlankRecord {
            values,
            turns,
            teeth,
            closed,
        })
    }

    /// Revolutions of a gear of `teeth` teeth in the hunting cycle with its mate of `mate` teeth.
    pub fn hunting_turns(teeth: usize, mate: usize) -> usize {
        mate / gcd(teeth, mate).max(1)
    }

    /// F_i′ over the record.
    pub fn total_deviation(&self) -> f64 {
        peak_to_peak(self.values)
    }

    /// F_i′ over one revolution, for every start and revolution by revolution.
    pub fn ranges_per_rev(&self) -> WindowedRanges {
        windowed_ranges::windowed_ranges(self.values, self.turns, self.closed)
    }

    /// f_i′ of the unfiltered record by ISO 1328-1:1995: in a sliding window of one pitch, and tooth by tooth.
    pub fn ranges_per_pitch(&self) -> WindowedRanges {
        self.pitches_of(self.values)
    }

    fn pitches_of(&self, values: &[f64]) -> WindowedRanges {
        windowed_ranges::windowed_ranges(values, self.turns * self.teeth, self.closed)
    }

    /// Split at order z/2 by Fourier series. An open record is first mirrored at its ends, which removes the step from its end to
    /// its start.
    pub fn split_by_order(&self) -> WaveSplit {
        self.split_with(self.long_wave_by_order())
    }

    /// Long wave of [`SingleFlankRecord::split_by_order`].
    pub fn long_wave_by_order(&self) -> Vec<f64> {
        let n = self.values.len();
        let mut samples = self.values.to_vec();
        if !self.closed {
            samples.extend(self.values.iter().rev());
        }
        let mut fft = RealFft::new(samples.len());
        let mut spectrum = vec![Complex::new(0.0, 0.0); fft.lines()];
        fft.forward(&mut samples, &mut spectrum);
        // A mirrored record has twice the length.
        let length = if self.closed { 1 } else { 2 };
        let first_short = (self.turns * self.teeth * length).div_ceil(2);
        let first_removed = first_short.min(spectrum.len());
        spectrum[first_removed..].fill(Complex::new(0.0, 0.0));
        fft.inverse(&mut spectrum, &mut samples);
        samples.truncate(n);
        samples
    }

    /// Split by a moving average over one pitch about each sample. Near the ends of an open record the window is the first or last
    /// full pitch. The gain is 64 % at order z/2 and zero at the mesh order.
    pub fn split_by_pitch_average(&self) -> WaveSplit {
        self.split_with(self.long_wave_by_pitch_average())
    }

    /// Long wave of [`SingleFlankRecord::split_by_pitch_average`].
    pub fn long_wave_by_pitch_average(&self) -> Vec<f64> {
        let n = self.values.len();
        let width = n as f64 / (self.turns * self.teeth) as f64;
        let (full, frac) = ((0.5 * width) as usize, (0.5 * width).fract());
        // Linear interpolation between samples: the weights in the integral over a pitch are 1 inside and these at the ends.
        let (outer, inner) = (0.5 * frac * frac, 0.5 * (1.0 - frac) * (1.0 - frac));
        let half = full + 1;
        let v = |i: usize| self.values[if i < n { i } else { i % n }];
        // Starts at sample `half`; a closed record continues periodically at its ends.
        let mut sum: f64 = (1..2 * half).map(v).sum();
        let mut long = Vec::with_capacity(n);
        for i in 0..if self.closed {
            n
        } else {
            n.saturating_sub(2 * half)
        } {
            let (a, b, c, d) = (v(i), v(i + 1), v(i + 2 * half - 1), v(i + 2 * half));
            long.push((sum - inner * (b + c) + outer * (a + d)) / width);
            sum += d - b;
        }
        if self.closed {
            long.rotate_right(half);
            return long;
        }
        // First and last full pitch.
        let end_average = |v: &dyn Fn(usize) -> f64| {
            let (full, frac) = (width as usize, width.fract());
            let last = frac * v(full) + 0.5 * frac * frac * (v(full + 1) - v(full));
            let sum: f64 = (0..full).map(|i| 0.5 * (v(i) + v(i + 1))).sum();
            (sum + last) / width
        };
        let ends = [
            end_average(&|i| self.values[i.min(n - 1)]),
            end_average(&|i| self.values[(n - 1).saturating_sub(i)]),
        ];
        let head = vec![ends[0]; half.min(n)];
        let tail = vec![ends[1]; n - head.len() - long.len()];
        [head, long, tail].concat()
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

    /// Harmonics up to an order per revolution, the mean first. In an open record, orders with a non-integer number of periods leak into
    /// neighbouring lines.
    pub fn harmonics(&self, highest_order: f64) -> Vec<TeHarmonic> {
        let n = self.values.len();
        let mut samples = self.values.to_vec();
        let mut fft = RealFft::new(n);
        let mut spectrum = vec![Complex::new(0.0, 0.0); fft.lines()];
        fft.forward(&mut samples, &mut spectrum);
        let harmonic = |(line, z): (usize, &Complex)| {
            // The mean and the Nyquist line have no line at the negative order.
            let is_unpaired = line == 0 || 2 * line == n;
            let scale = if is_unpaired { 1.0 } else { 2.0 } / n as f64;
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
