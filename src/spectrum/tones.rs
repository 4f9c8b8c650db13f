//! Detection of sines in noise by Thomson's F test on sine tapers.
//!
//! The harmonic test of Thomson, Spectrum estimation and harmonic analysis, Proc. IEEE 70 (1982), section XIII, with the tapers of
//! [`multitaper`](crate::spectrum::multitaper). It asks for a density that is even over K lines: a resonance as narrow as a line of the whole
//! record cannot be told from a sine. Two sines of like size within about four lines of each other stay unseen.

use super::multitaper::{line_value, transform};
use super::sine::{self, SineFit};
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::{RealFft, prev_fast_len};
use crate::numeric::sorting::{sort_falling, sort_rising};

/// A sine of constant amplitude and frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Tone {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// 0 to peak, by channel.
    pub amplitude: Vec<f64>,
    /// Probability that noise alone exceeds its level so far anywhere.
    pub probability: f64,
}

/// Tapers: many tell weak tones, few tell strong ones that lie close together or near the ends of the band.
const TAPERS: [usize; 2] = [12, 4];

/// Places looked at per half line. At half lines alone a sine midway between two has F of about 50 however strong it is, no more than
/// noise reaches somewhere in a long record.
const GRID_PER_HALF_LINE: usize = 2;

/// Probability that noise alone shows one tone, in a record.
const FALSE_ALARM: f64 = 1e-3;

/// Strong tones hide weak ones next to them: looked at again without, so often at most.
const MAX_ROUNDS: usize = 4;

/// Tones taken out in a round, at most.
const MAX_TONES_PER_ROUND: usize = 64;

/// Lines: what is left of a tone that is none to the last digit lies within this of it, and is no second one.
const SAME_TONE_LINES: f64 = 2.0;

/// Lines: tones nearer than this are fitted again without each other.
const NEIGHBOUR_LINES: f64 = 12.0;

/// Convergence tolerance of tones near each other, in lines; and maximum number of refits.
const REFIT_TOLERANCE_LINES: f64 = 1e-5;
const MAX_REFITS: usize = 20;

/// Refits of a search, at most: a line that wanders is many tones near each other, which are put back later in any case.
const MAX_TOTAL_REFITS: usize = 500;

/// Finds tones and takes them out of the channels, which are of equal length; by rising frequency. None where a record is shorter than
/// eight samples a taper.
///
/// # Errors
/// `Overflow`: a sample that is not finite.
pub fn remove_tones(rate_hz: f64, channels: &mut [Vec<f64>]) -> Result<Vec<Tone>, Error> {
    let samples = channels.first().map_or(0, Vec::len);
    if samples < 8 * TAPERS[0] {
        return Ok(Vec::new());
    }
    let whole = prev_fast_len(samples + 1);
    let mut search = ToneSearch {
        rate_hz,
        transform_len: whole,
        channels,
        fft: RealFft::new(2 * GRID_PER_HALF_LINE * whole),
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
    let mut found = search.tones;
    sort_rising(&mut found, |a| a.frequency_hz());
    Ok(found.iter().map(ToneFit::tone).collect())
}

/// One tone in every channel.
struct ToneFit {
    fits: Vec<SineFit>,
    /// The channel that tells its frequency.
    reference_channel: usize,
    probability: f64,
    /// True once a fit without the tones near it moved it no further.
    is_settled: bool,
}

impl ToneFit {
    /// Fitted at its frequency, and taken out.
    fn new(
        rate_hz: f64,
        channels: &mut [Vec<f64>],
        clearest: usize,
        start_hz: f64,
        probability: f64,
    ) -> Result<ToneFit, Error> {
        let frequency_hz = sine::fit(&channels[clearest], rate_hz, start_hz)?.frequency_hz;
        let fits = channels
            .iter()
            .map(|channel| sine::fit_amplitude(channel, rate_hz, frequency_hz))
            .collect::<Result<Vec<_>, Error>>()?;
        for (channel, fit) in channels.iter_mut().zip(&fits) {
            fit.subtract_from(channel, rate_hz);
        }
        Ok(ToneFit {
            fits,
            reference_channel: clearest,
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

/// Channels that tones are taken out of, one after another.
struct ToneSearch<'a> {
    rate_hz: f64,
    /// Samples of a transform and one more.
    transform_len: usize,
    channels: &'a mut [Vec<f64>],
    fft: RealFft,
    tones: Vec<ToneFit>,
    /// Fits of tones without those near them, so far.
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
        let looked_at = (self.channels.len() * self.transform_len * TAPERS.len()) as f64;
        let mut is_new = false;
        for &(m, clearest) in peaks(&tests, looked_at, tapers)
            .iter()
            .take(MAX_TONES_PER_ROUND)
        {
            let start = m as f64 * 0.5 / GRID_PER_HALF_LINE as f64 * self.line_hz();
            let probability =
                (false_alarm_probability(tests[clearest][m], tapers) * looked_at).min(1.0);
            let fitted = ToneFit::new(self.rate_hz, self.channels, clearest, start, probability);
            // What runs away from where it stands out is no sine there.
            let Ok(tone) = fitted else {
                continue;
            };
            let apart = |t: &ToneFit| (t.frequency_hz() - tone.frequency_hz()).abs();
            if self
                .tones
                .iter()
                .all(|t| apart(t) > SAME_TONE_LINES * self.line_hz())
            {
                is_new = true;
                self.tones.push(tone);
            }
        }
        Ok(is_new)
    }

    /// Fits tones near each other again, each without the others, until they converge: those that moved, and their neighbours.
    fn refine_neighbours(&mut self) -> Result<(), Error> {
        let line_hz = self.line_hz();
        for _ in 0..MAX_REFITS {
            let mut is_settled = true;
            for at in 0..self.tones.len() {
                let is_moving = |other: usize| {
                    let (one, other) = (&self.tones[at], &self.tones[other]);
                    let apart = (other.frequency_hz() - one.frequency_hz()).abs();
                    let is_settled = one.is_settled && other.is_settled;
                    !is_settled && apart > 0.0 && apart < NEIGHBOUR_LINES * line_hz
                };
                if self.refits >= MAX_TOTAL_REFITS || !(0..self.tones.len()).any(is_moving) {
                    continue;
                }
                self.refits += 1;
                let old = &self.tones[at];
                for (channel, fit) in self.channels.iter_mut().zip(&old.fits) {
                    fit.add_to(channel, self.rate_hz);
                }
                let (start, clearest) = (old.frequency_hz(), old.reference_channel);
                match ToneFit::new(
                    self.rate_hz,
                    self.channels,
                    clearest,
                    start,
                    old.probability,
                ) {
                    Ok(mut new) => {
                        let moved = (new.frequency_hz() - start).abs() / line_hz;
                        new.is_settled = moved < REFIT_TOLERANCE_LINES;
                        is_settled &= new.is_settled;
                        self.tones[at] = new;
                    }
                    Err(_) => {
                        for (channel, fit) in self.channels.iter_mut().zip(&old.fits) {
                            fit.subtract_from(channel, self.rate_hz);
                        }
                        self.tones[at].is_settled = true;
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

/// F at every place.
fn f_statistics(transform: &[Complex], whole: usize, tapers: usize) -> Vec<f64> {
    let weight = |k: usize| match k % 2 {
        1 => 1.0 / (std::f64::consts::PI * k as f64 / (2 * whole) as f64).tan(),
        _ => 0.0,
    };
    let weights: Vec<f64> = (1..=tapers).map(weight).collect();
    let square: f64 = weights.iter().map(|u| u * u).sum();
    let one = |m: usize| {
        if m <= GRID_PER_HALF_LINE * tapers
            || m + GRID_PER_HALF_LINE * tapers >= GRID_PER_HALF_LINE * whole
        {
            return 0.0;
        }
        let (m, half_line) = (m as isize, GRID_PER_HALF_LINE as isize);
        let mut along = Complex::new(0.0, 0.0);
        let mut power = 0.0;
        for (k, u) in (1..).zip(&weights) {
            let y =
                line_value(transform, m - k * half_line) - line_value(transform, m + k * half_line);
            along += y * *u;
            power += y.norm_sqr();
        }
        let tone = along.norm_sqr() / square;
        let left = (power - tone).max(f64::EPSILON * power);
        match left > 0.0 {
            true => residual_dof(tapers) * tone / left,
            false => 0.0,
        }
    };
    (0..GRID_PER_HALF_LINE * whole).map(one).collect()
}

/// Pairs of degrees of freedom of what is left.
fn residual_dof(tapers: usize) -> f64 {
    (tapers - 1) as f64
}

/// The probability that F is above a value by noise alone: of 2 and 2ν degrees of freedom, `(1 + F/ν)^−ν`.
fn false_alarm_probability(f: f64, tapers: usize) -> f64 {
    (1.0 + f / residual_dof(tapers)).powf(-residual_dof(tapers))
}

/// Significant maxima of the test statistic, each the largest of all channels within the tapers' resolution, with its channel; the
/// clearest first.
fn peaks(tests: &[Vec<f64>], looked_at: f64, tapers: usize) -> Vec<(usize, usize)> {
    let count = tests.first().map_or(0, Vec::len);
    let best = |m: usize| {
        let of = |c: usize| tests[c][m];
        let strongest = (0..tests.len()).max_by(|&a, &b| of(a).total_cmp(&of(b)));
        strongest.map_or((0.0, 0), |c| (of(c), c))
    };
    let all: Vec<(f64, usize)> = (0..count).map(best).collect();
    let mut peaks: Vec<(usize, usize)> = (0..count)
        .filter(|&m| false_alarm_probability(all[m].0, tapers) * looked_at < FALSE_ALARM)
        .filter(|&m| {
            let reach = GRID_PER_HALF_LINE * tapers;
            let near = m.saturating_sub(reach)..(m + reach + 1).min(count);
            all[near].iter().all(|other| other.0 <= all[m].0)
        })
        .map(|m| (m, all[m].1))
        .collect();
    sort_falling(&mut peaks, |a| all[a.0].0);
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

    /// A strong tone, one that is weaker than the noise next to it, and one near the strong one: found and taken out.
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
            // Of white noise a line of 20 s holds an amplitude of 2 √(1/12 · 1/20 000).
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

    /// White noise shows a tone as seldom as promised: none in forty records.
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
