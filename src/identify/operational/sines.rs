//! Sines of constant amplitude, found and taken out of a record before modes are sought.
//!
//! Long records are searched in blocks, which bounds memory and time and follows a speed that drifts. A resonance no wider than a line
//! passes the test for a sine; its amplitude and phase wander from quarter to quarter of the record, those of a sine do not: what wanders
//! is put back.

use std::f64::consts::{PI, TAU};

use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::sorting::sort_rising;
use crate::spectrum::sine;
use crate::spectrum::tones::{Tone, remove_tones};

/// Samples of a block, at most.
const MAX_BLOCK_LEN: usize = 1 << 20;

/// Quarters of a block that are compared.
const QUARTERS: usize = 4;

/// Power that is left at a sine's place in the quarters, over the sine's own, from which on it was none, …
const MAX_RESIDUAL_POWER: f64 = 0.25;

/// … where it also exceeds what is left on lines near it so many times: four exponential numbers exceed four times their mean once in
/// 12 000 cases.
const MIN_RATIO_TO_NEIGHBOURS: f64 = 4.0;

/// Lines of a quarter away from the sine, on either side, at which the power near it is taken: beyond the main lobe of the window.
const NEIGHBOUR_LINES: std::ops::RangeInclusive<usize> = 4..=7;

/// Sines of two blocks nearer than this are one, lines of a block.
const SAME_SINE_LINES: f64 = 2.0;

/// Takes constant sines out of channels of equal length; by rising frequency, amplitudes those of the blocks that have the sine.
///
/// # Errors
/// Those of the search: samples that are not finite.
pub fn take_out_constant(rate_hz: f64, channels: &mut [Vec<f64>]) -> Result<Vec<Tone>, Error> {
    let n = channels.first().map_or(0, Vec::len);
    let blocks = n.div_ceil(MAX_BLOCK_LEN).max(1);
    let mut all: Vec<(Tone, usize)> = Vec::new();
    for k in 0..blocks {
        let (from, to) = (k * n / blocks, (k + 1) * n / blocks);
        let before: Vec<Vec<f64>> = channels.iter().map(|c| c[from..to].to_vec()).collect();
        let mut after = before.clone();
        let tones = remove_tones(rate_hz, &mut after)?;
        let line = rate_hz / (to - from).max(1) as f64;
        for tone in tones {
            if wanders(rate_hz, &before, &after, &tone) {
                put_back(rate_hz, &before, &mut after, &tone)?;
                continue;
            }
            let is_same = |t: &&mut (Tone, usize)| {
                (t.0.frequency_hz - tone.frequency_hz).abs() < SAME_SINE_LINES * line
                    && t.1 < blocks
            };
            match all.iter_mut().find(is_same) {
                Some((known, count)) if k > 0 => {
                    let share = 1.0 / (*count as f64 + 1.0);
                    known.frequency_hz += share * (tone.frequency_hz - known.frequency_hz);
                    for (a, b) in known.amplitude.iter_mut().zip(&tone.amplitude) {
                        *a += share * (b - *a);
                    }
                    known.probability = known.probability.min(tone.probability);
                    *count += 1;
                }
                _ => all.push((tone, 1)),
            }
        }
        for (channel, block) in channels.iter_mut().zip(&after) {
            channel[from..to].copy_from_slice(block);
        }
    }
    let mut tones: Vec<Tone> = all.into_iter().map(|t| t.0).collect();
    sort_rising(&mut tones, |a| a.frequency_hz);
    Ok(tones)
}

/// Whether what was taken for a sine changes from quarter to quarter.
fn wanders(rate_hz: f64, before: &[Vec<f64>], after: &[Vec<f64>], tone: &Tone) -> bool {
    let strongest = (0..tone.amplitude.len())
        .max_by(|&a, &b| tone.amplitude[a].total_cmp(&tone.amplitude[b]))
        .unwrap_or(0);
    let length = after[strongest].len() / QUARTERS;
    let line = rate_hz / length as f64;
    let (mut own, mut left, mut near) = (0.0, 0.0, 0.0);
    for q in 0..QUARTERS {
        let part = q * length..(q + 1) * length;
        let rest = &after[strongest][part.clone()];
        let taken: Vec<f64> = (before[strongest][part].iter().zip(rest))
            .map(|(b, a)| b - a)
            .collect();
        let power = |samples: &[f64], f: f64| hann_transform(samples, f / rate_hz).norm_sqr();
        own += power(&taken, tone.frequency_hz);
        left += power(rest, tone.frequency_hz);
        let sides = NEIGHBOUR_LINES
            .flat_map(|k| [-1.0, 1.0].map(|s| tone.frequency_hz + s * k as f64 * line));
        near += sides.map(|f| power(rest, f)).sum::<f64>() / (2 * NEIGHBOUR_LINES.count()) as f64;
    }
    left > MAX_RESIDUAL_POWER * own && left > MIN_RATIO_TO_NEIGHBOURS * near
}

/// Puts a sine back: that part of what was taken out.
fn put_back(
    rate_hz: f64,
    before: &[Vec<f64>],
    after: &mut [Vec<f64>],
    tone: &Tone,
) -> Result<(), Error> {
    for (b, a) in before.iter().zip(after) {
        let taken: Vec<f64> = b.iter().zip(a.iter()).map(|(b, a)| b - a).collect();
        sine::fit_amplitude(&taken, rate_hz, tone.frequency_hz)?.add_to(a, rate_hz);
    }
    Ok(())
}

/// Transform under Hann's window at a frequency in turns a sample.
fn hann_transform(samples: &[f64], turns: f64) -> Complex {
    let n = samples.len() as f64;
    let step = Complex::from_polar(1.0, -TAU * turns);
    let mut turn = Complex::new(1.0, 0.0);
    let mut sum = Complex::ZERO;
    for (t, x) in samples.iter().enumerate() {
        let window = (PI * (t as f64 + 0.5) / n).sin().powi(2);
        sum += turn * (window * x);
        turn *= step;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A resonance as narrow as a line of the record stays in it in most cases (of 200 that pass for a sine 87 % wander), a sine does not.
    #[test]
    fn law_a_narrow_resonance_is_no_sine() {
        let (rate, n) = (200.0, 20_000);
        let mut stayed = 0;
        for seed in 0..8_u64 {
            let mut rng = fastrand::Rng::with_seed(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15));
            let mut noise = || (0..12).map(|_| rng.f64()).sum::<f64>() - 6.0;
            let (w, decay) = (TAU * 31.3 / rate, TAU * 0.01 / rate);
            let (a, b) = (2.0 * (-decay).exp() * w.cos(), (-2.0 * decay).exp());
            let (mut x1, mut x2) = (0.0, 0.0);
            let mut y = Vec::with_capacity(n);
            for t in 0..200_000 + n {
                let x = a * x1 - b * x2 + noise();
                (x1, x2) = (x, x1);
                if t >= 200_000 {
                    let at = (t - 200_000) as f64;
                    y.push(x + 50.0 * noise() + 300.0 * (TAU * 17.7 / rate * at).sin());
                }
            }
            let found = take_out_constant(rate, &mut [y]).unwrap();
            let near = |f: f64| found.iter().any(|t| (t.frequency_hz - f).abs() < 0.05);
            assert!(near(17.7), "{found:?}");
            stayed += usize::from(!near(31.3));
        }
        assert!(stayed >= 5, "{stayed} of 8");
    }
}
