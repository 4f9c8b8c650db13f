//! Sines told from noise, line by line: of the transforms `Y_k` under K sine tapers a sine makes `μ U_k`, `U_k = Σ_j h_k(j)`, and
//! `F = (K − 1) |μ|² Σ U_k²/Σ |Y_k − μ U_k|²`, `μ = Σ U_k Y_k/Σ U_k²`, has 2 and 2(K − 1) freedoms where there is none.
//!
//! The harmonic test of Thomson, Spectrum estimation and harmonic analysis, Proc. IEEE 70 (1982), section XIII, with the tapers of
//! [`multitaper`](crate::spectrum::multitaper). It asks for a density that is even over K lines: a resonance as narrow as a line of the whole
//! record cannot be told from a sine.

use super::multitaper::{at, transform};
use super::sine;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::{RealFft, quick_within};

/// A sine of constant amplitude and frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Tone {
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// 0 to peak, by channel.
    pub amplitude: Vec<f64>,
    /// How probably noise alone stands out so far anywhere.
    pub probability: f64,
}

/// Tapers.
const TAPERS: usize = 12;

/// How often noise alone may show one tone, in a record.
const FALSE_ALARM: f64 = 1e-3;

/// Strong tones hide weak ones beside them: looked at again without, so often at most.
const ROUNDS: usize = 4;

/// Tones taken out in a round, at most.
const MOST: usize = 64;

/// Finds tones and takes them out of the channels, which are of equal length; by rising frequency. None where a record is shorter than
/// eight samples a taper.
///
/// # Errors
/// `Overflow`: a sample that is not finite.
pub fn take_out(rate_hz: f64, channels: &mut [Vec<f64>]) -> Result<Vec<Tone>, Error> {
    let samples = channels.first().map_or(0, Vec::len);
    if samples < 8 * TAPERS {
        return Ok(Vec::new());
    }
    let whole = quick_within(samples + 1);
    let line = rate_hz / whole as f64;
    let mut fft = RealFft::new(2 * whole);
    let mut found: Vec<Tone> = Vec::new();
    for _ in 0..ROUNDS {
        let mut tests = Vec::with_capacity(channels.len());
        for channel in channels.iter() {
            tests.push(test(&transform(&channel[..whole - 1], &mut fft)?, whole));
        }
        let looked_at = (channels.len() * whole) as f64;
        let peaks = peaks(&tests, looked_at);
        let mut is_new = false;
        for &(m, strongest) in peaks.iter().take(MOST) {
            let start = m as f64 * 0.5 * line;
            let Ok(tone) = sine::fit(&channels[strongest], rate_hz, start) else {
                continue;
            };
            let frequency_hz = tone.frequency_hz;
            let amplitude = channels.iter_mut().map(|channel| {
                let tone = sine::fit_at(channel, rate_hz, frequency_hz)?;
                tone.take_out(channel, rate_hz);
                Ok(tone.amplitude.norm())
            });
            let amplitude = amplitude.collect::<Result<Vec<f64>, Error>>()?;
            // What is left of a tone that is none to the last digit is no second one.
            let same = |t: &&Tone| (t.frequency_hz - frequency_hz).abs() < TAPERS as f64 * line;
            if found.iter().any(|t| same(&t)) {
                continue;
            }
            is_new = true;
            found.push(Tone {
                frequency_hz,
                amplitude,
                probability: (above(tests[strongest][m]) * looked_at).min(1.0),
            });
        }
        if !is_new {
            break;
        }
    }
    found.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    Ok(found)
}

/// F at every half line.
fn test(transform: &[Complex], whole: usize) -> Vec<f64> {
    let weight = |k: usize| match k % 2 {
        1 => 1.0 / (std::f64::consts::PI * k as f64 / (2 * whole) as f64).tan(),
        _ => 0.0,
    };
    let weights: Vec<f64> = (1..=TAPERS).map(weight).collect();
    let square: f64 = weights.iter().map(|u| u * u).sum();
    let one = |m: usize| {
        if m <= TAPERS || m + TAPERS >= whole {
            return 0.0;
        }
        let m = m as isize;
        let mut along = Complex::new(0.0, 0.0);
        let mut power = 0.0;
        for (k, u) in (1..).zip(&weights) {
            let y = at(transform, m - k) - at(transform, m + k);
            along += y * *u;
            power += y.norm_sqr();
        }
        let tone = along.norm_sqr() / square;
        let left = (power - tone).max(f64::EPSILON * power);
        match left > 0.0 {
            true => FREEDOMS * tone / left,
            false => 0.0,
        }
    };
    (0..whole).map(one).collect()
}

/// Pairs of freedoms of what is left.
const FREEDOMS: f64 = (TAPERS - 1) as f64;

/// The probability that F is above a value by noise alone: of 2 and 2ν freedoms, `(1 + F/ν)^−ν`.
fn above(f: f64) -> f64 {
    (1.0 + f / FREEDOMS).powf(-FREEDOMS)
}

/// Half lines where a tone stands out in some channel, farther than in any as near as the tapers see, with that channel; the clearest
/// first.
fn peaks(tests: &[Vec<f64>], looked_at: f64) -> Vec<(usize, usize)> {
    let count = tests.first().map_or(0, Vec::len);
    let best = |m: usize| {
        let of = |c: usize| tests[c][m];
        let strongest = (0..tests.len()).max_by(|&a, &b| of(a).total_cmp(&of(b)));
        strongest.map_or((0.0, 0), |c| (of(c), c))
    };
    let all: Vec<(f64, usize)> = (0..count).map(best).collect();
    let mut peaks: Vec<(usize, usize)> = (0..count)
        .filter(|&m| above(all[m].0) * looked_at < FALSE_ALARM)
        .filter(|&m| {
            let near = m.saturating_sub(TAPERS)..(m + TAPERS + 1).min(count);
            all[near].iter().all(|other| other.0 <= all[m].0)
        })
        .map(|m| (m, all[m].1))
        .collect();
    peaks.sort_by(|a, b| all[b.0].0.total_cmp(&all[a.0].0));
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

    /// A strong tone, one that is weaker than the noise beside it, and one near the strong one: found and taken out.
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
        let found = take_out(1000.0, &mut channels).unwrap();
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
            let found = take_out(1.0, &mut [noise(3000, seed)]).unwrap();
            assert!(found.is_empty(), "{found:?}");
        }
    }

    #[test]
    fn survives_little() {
        assert!(take_out(1.0, &mut []).unwrap().is_empty());
        assert!(take_out(1.0, &mut [vec![1.0; 20]]).unwrap().is_empty());
        assert!(take_out(1.0, &mut [vec![1.0; 500]]).unwrap().is_empty());
        assert!(take_out(1.0, &mut [vec![f64::NAN; 500]]).is_err());
    }
}
