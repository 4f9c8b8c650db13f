//! Detection of sines in noise by Thomson's F test on sine tapers.
//!
//! The harmonic test of Thomson, Spectrum estimation and harmonic analysis, Proc. IEEE 70 (1982), section XIII, with the tapers of
//! [`multitaper`](crate::spectrum::multitaper). It requires a density that is flat over K lines: a resonance as narrow as a line of the
//! record is indistinguishable from a sine. Two sines of similar amplitude within about four lines of each other are not detected.

use super::multitaper::{line_value, transform};
use super::sine::{self, SineFit};
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::{RealFft, prev_fast_len};
use crate::numeric::sorting::{sort_ascending, sort_descending};

/// Sine of constant amplitude and frequency in all channels.
#[derive(Debug, Clone, PartialEq)]
pub struct Tone {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Amplitude (0 to peak) by channel, in the unit of the channel.
    pub amplitude: Vec<f64>,
    /// False-alarm probability over the record: that noise alone exceeds the test statistic at any frequency.
    pub probability: f64,
}

/// Numbers of tapers: many detect weak tones, few resolve strong ones near each other or near the ends of the band.
const TAPERS: [usize; 2] = [12, 4];

/// Test frequencies per half line. At half lines alone a sine midway between two has F of about 50 at any amplitude, no more than
/// the maximum of noise in a long record.
const GRID_PER_HALF_LINE: usize = 2;

/// False-alarm probability of a tone, per record.
const FALSE_ALARM: f64 = 1e-3;

/// Maximum number of rounds: strong tones mask weak neighbours until they are removed.
const MAX_ROUNDS: usize = 4;

/// Maximum number of tones removed per round.
const MAX_TONES_PER_ROUND: usize = 64;

/// Distance, lines, within which a detection is the residual of a removed tone, not a second tone.
const SAME_TONE_LINES: f64 = 2.0;

/// Distance, lines, within which tones are refitted without each other.
const NEIGHBOUR_LINES: f64 = 12.0;

/// Convergence tolerance of neighbouring tones, lines; and maximum number of refits.
const REFIT_TOLERANCE_LINES: f64 = 1e-5;
const MAX_REFITS: usize = 20;

/// Maximum number of refits of a search: a line of variable frequency appears as many neighbouring tones, restored later in any case.
const MAX_TOTAL_REFITS: usize = 500;

/// Detects tones and subtracts them from the channels of equal length; in order of frequency. No tones in records of less than eight
/// samples per taper.
///
/// # Errors
/// `Overflow`: a sample that is not finite.
pub fn remove_tones(rate_hz: f64, channels: &mut [Vec<f64>]) -> Result<Vec<Tone>, Error> {
    let samples = channels.first().map_or(0, Vec::len);
    if samples < 8 * TAPERS[0] {
        return Ok(Vec::new());
    }
    let transform_len = prev_fast_len(samples + 1);
    let mut search = ToneSearch {
        rate_hz,
        transform_len,
        channels,
        fft: RealFft::new(2 * GRID_PER_HALF_LINE * transform_len),
        tones: Vec::new(),
        refits: 0,
    };
    for tapers in TAPERS {
        for _ in 0..MAX_ROUNDS {
            if !search.round(tapers)? {
                break;
            }
            search.refine_neighbours()?;
        }
    }
    let mut tones = search.tones;
    sort_ascending(&mut tones, |a| a.frequency_hz());
    Ok(tones.iter().map(ToneFit::tone).collect())
}

/// Sine fits of one tone in all channels.
struct ToneFit {
    fits: Vec<SineFit>,
    /// Channel of the frequency estimate, with the largest test statistic.
    reference_channel: usize,
    probability: f64,
    /// True after convergence of the frequency in refits without the neighbours.
    is_settled: bool,
}

impl ToneFit {
    /// Fits a tone near `start_hz` and subtracts it from the channels.
    fn new(
        rate_hz: f64,
        channels: &mut [Vec<f64>],
        reference_channel: usize,
        start_hz: f64,
        probability: f64,
    ) -> Result<ToneFit, Error> {
        let frequency_hz = sine::fit(&channels[reference_channel], rate_hz, start_hz)?.frequency_hz;
        let fits = channels
            .iter()
            .map(|channel| sine::fit_amplitude(channel, rate_hz, frequency_hz))
            .collect::<Result<Vec<_>, Error>>()?;
        for (channel, fit) in channels.iter_mut().zip(&fits) {
            fit.subtract_from(channel, rate_hz);
        }
        Ok(ToneFit {
            fits,
            reference_channel,
            probability,
            is_settled: false,
        })
    }

    fn frequency_hz(&self) -> f64 {
        self.fits[self.reference_channel].frequency_hz
    }

    fn tone(&self) -> Tone {
        Tone {
            frequency_hz: self.frequency_hz(),
            amplitude: self.fits.iter().map(|f| f.amplitude.norm()).collect(),
            probability: self.probability,
        }
    }
}

/// Successive detection and removal of tones.
struct ToneSearch<'a> {
    rate_hz: f64,
    /// Number of samples of a transform plus one.
    transform_len: usize,
    channels: &'a mut [Vec<f64>],
    fft: RealFft,
    tones: Vec<ToneFit>,
    /// Number of refits without neighbouring tones.
    refits: usize,
}

impl ToneSearch<'_> {
    fn line_hz(&self) -> f64 {
        self.rate_hz / self.transform_len as f64
    }

    /// Removes the tones found in this round; returns whether any of them is new.
    fn round(&mut self, tapers: usize) -> Result<bool, Error> {
        let mut tests = Vec::with_capacity(self.channels.len());
        for channel in self.channels.iter() {
            let lines = transform(&channel[..self.transform_len - 1], &mut self.fft)?;
            tests.push(f_statistics(&lines, self.transform_len, tapers));
        }
        let n_tests = (self.channels.len() * self.transform_len * TAPERS.len()) as f64;
        let mut is_new = false;
        for &(m, channel) in peaks(&tests, n_tests, tapers)
            .iter()
            .take(MAX_TONES_PER_ROUND)
        {
            let start = m as f64 * 0.5 / GRID_PER_HALF_LINE as f64 * self.line_hz();
            let probability =
                (false_alarm_probability(tests[channel][m], tapers) * n_tests).min(1.0);
            let fitted = ToneFit::new(self.rate_hz, self.channels, channel, start, probability);
            // A fit whose frequency diverges from the detection is no sine.
            let Ok(tone) = fitted else {
                continue;
            };
            let distance = |t: &ToneFit| (t.frequency_hz() - tone.frequency_hz()).abs();
            if self
                .tones
                .iter()
                .all(|t| distance(t) > SAME_TONE_LINES * self.line_hz())
            {
                is_new = true;
                self.tones.push(tone);
            }
        }
        Ok(is_new)
    }

    /// Refits neighbouring tones, each without the others, until all frequencies converge.
    fn refine_neighbours(&mut self) -> Result<(), Error> {
        let line_hz = self.line_hz();
        for _ in 0..MAX_REFITS {
            let mut is_settled = true;
            for k in 0..self.tones.len() {
                let is_moving = |other: usize| {
                    let (tone, other) = (&self.tones[k], &self.tones[other]);
                    let distance = (other.frequency_hz() - tone.frequency_hz()).abs();
                    let is_settled = tone.is_settled && other.is_settled;
                    !is_settled && distance > 0.0 && distance < NEIGHBOUR_LINES * line_hz
                };
                if self.refits >= MAX_TOTAL_REFITS || !(0..self.tones.len()).any(is_moving) {
                    continue;
                }
                self.refits += 1;
                let old = &self.tones[k];
                for (channel, fit) in self.channels.iter_mut().zip(&old.fits) {
                    fit.add_to(channel, self.rate_hz);
                }
                let (start, channel) = (old.frequency_hz(), old.reference_channel);
                match ToneFit::new(self.rate_hz, self.channels, channel, start, old.probability) {
                    Ok(mut new) => {
                        let moved = (new.frequency_hz() - start).abs() / line_hz;
                        new.is_settled = moved < REFIT_TOLERANCE_LINES;
                        is_settled &= new.is_settled;
                        self.tones[k] = new;
                    }
                    Err(_) => {
                        for (channel, fit) in self.channels.iter_mut().zip(&old.fits) {
                            fit.subtract_from(channel, self.rate_hz);
                        }
                        self.tones[k].is_settled = true;
                    }
                }
            }
            if is_settled {
                break;
            }
        }
        Ok(())
    }
}

/// F statistic at every test frequency.
fn f_statistics(transform: &[Complex], transform_len: usize, tapers: usize) -> Vec<f64> {
    let weight = |k: usize| match k % 2 {
        1 => 1.0 / (std::f64::consts::PI * k as f64 / (2 * transform_len) as f64).tan(),
        _ => 0.0,
    };
    let weights: Vec<f64> = (1..=tapers).map(weight).collect();
    let squares: f64 = weights.iter().map(|u| u * u).sum();
    let f_at = |m: usize| {
        if m <= GRID_PER_HALF_LINE * tapers
            || m + GRID_PER_HALF_LINE * tapers >= GRID_PER_HALF_LINE * transform_len
        {
            return 0.0;
        }
        let (m, half_line) = (m as isize, GRID_PER_HALF_LINE as isize);
        let mut projection = Complex::new(0.0, 0.0);
        let mut power = 0.0;
        for (k, u) in (1..).zip(&weights) {
            let y =
                line_value(transform, m - k * half_line) - line_value(transform, m + k * half_line);
            projection += y * *u;
            power += y.norm_sqr();
        }
        let tone = projection.norm_sqr() / squares;
        let residual = (power - tone).max(f64::EPSILON * power);
        match residual > 0.0 {
            true => residual_dof(tapers) * tone / residual,
            false => 0.0,
        }
    };
    (0..GRID_PER_HALF_LINE * transform_len).map(f_at).collect()
}

/// Complex degrees of freedom of the residual.
fn residual_dof(tapers: usize) -> f64 {
    (tapers - 1) as f64
}

/// False-alarm probability of a value of F with 2 and 2ν degrees of freedom, `(1 + F/ν)^−ν`.
fn false_alarm_probability(f: f64, tapers: usize) -> f64 {
    (1.0 + f / residual_dof(tapers)).powf(-residual_dof(tapers))
}

/// Significant maxima of the test statistic over all channels and the tapers' resolution, each with its channel, in descending
/// order.
fn peaks(tests: &[Vec<f64>], n_tests: f64, tapers: usize) -> Vec<(usize, usize)> {
    let count = tests.first().map_or(0, Vec::len);
    let strongest_at = |m: usize| {
        let f_of = |c: usize| tests[c][m];
        let strongest = (0..tests.len()).max_by(|&a, &b| f_of(a).total_cmp(&f_of(b)));
        strongest.map_or((0.0, 0), |c| (f_of(c), c))
    };
    let maxima: Vec<(f64, usize)> = (0..count).map(strongest_at).collect();
    let mut peaks: Vec<(usize, usize)> = (0..count)
        .filter(|&m| false_alarm_probability(maxima[m].0, tapers) * n_tests < FALSE_ALARM)
        .filter(|&m| {
            let resolution = GRID_PER_HALF_LINE * tapers;
            let window = m.saturating_sub(resolution)..(m + resolution + 1).min(count);
            maxima[window].iter().all(|other| other.0 <= maxima[m].0)
        })
        .map(|m| (m, maxima[m].1))
        .collect();
    sort_descending(&mut peaks, |a| maxima[a.0].0);
    peaks
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn noise(samples: usize, seed: u64) -> Vec<f64> {
        let mut rng = fastrand::Rng::with_seed(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        (0..samples).map(|_| rng.f64() - 0.5).collect()
    }

    /// A strong tone, a weak neighbour of it, and a tone below the noise level are detected and removed.
    #[test]
    fn exact_tones_in_noise() {
        let tones = [(101.37, 20.0), (104.0, 0.1), (250.0, 0.05)];
        let mut channels = [noise(20_000, 1), noise(20_000, 2)].to_vec();
        let clean = channels.clone();
        for (c, channel) in channels.iter_mut().enumerate() {
            for (j, x) in channel.iter_mut().enumerate() {
                let t = j as f64 / 1000.0;
                let sum = tones.map(|(f, a)| a * (TAU * f * t + c as f64).sin());
                *x += sum.iter().sum::<f64>() / (c + 1) as f64;
            }
        }
        let found = remove_tones(1000.0, &mut channels).unwrap();
        assert_eq!(found.len(), 3, "{found:?}");
        for (tone, (f, a)) in found.iter().zip(tones) {
            // The amplitude of white noise on a line of 20 s is 2 √(1/12 · 1/20 000).
            assert!((tone.frequency_hz - f).abs() < 2e-3, "{tone:?}");
            assert!((tone.amplitude[0] - a).abs() < 0.015, "{tone:?}");
            assert!((tone.amplitude[1] - 0.5 * a).abs() < 0.015, "{tone:?}");
            assert!(tone.probability < FALSE_ALARM, "{tone:?}");
        }
        for (left, clean) in channels.iter().zip(&clean) {
            let off = left.iter().zip(clean).map(|(a, b)| (a - b).powi(2));
            assert!(off.sum::<f64>() < 0.005 * 20_000.0 / 12.0);
        }
    }

    /// White noise has no false tones in forty records, by the false-alarm probability.
    #[test]
    fn law_noise_has_no_tones() {
        for seed in 0..40 {
            let found = remove_tones(1.0, &mut [noise(3000, seed)]).unwrap();
            assert!(found.is_empty(), "{found:?}");
        }
    }

    #[test]
    fn survives_little() {
        assert!(remove_tones(1.0, &mut []).unwrap().is_empty());
        assert!(remove_tones(1.0, &mut [vec![1.0; 20]]).unwrap().is_empty());
        assert!(remove_tones(1.0, &mut [vec![1.0; 500]]).unwrap().is_empty());
        assert!(remove_tones(1.0, &mut [vec![f64::NAN; 500]]).is_err());
    }
}
