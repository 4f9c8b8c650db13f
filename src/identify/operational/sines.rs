//! Detection of sines of constant amplitude, and their removal from a record before the identification of modes.
//!
//! Long records are searched in blocks, which limits memory and time and follows a drifting speed. A resonance narrower than the line
//! spacing passes the sine test, but its amplitude and phase vary between the quarters of a block: such a component is restored.

use std::f64::consts::{PI, TAU};

use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::sorting::sort_ascending;
use crate::spectrum::sine;
use crate::spectrum::tones::{Tone, remove_tones};

/// Maximum number of samples in a block.
const MAX_BLOCK_LEN: usize = 1 << 20;

/// Number of equal segments of a block whose amplitudes are compared.
const QUARTERS: usize = 4;

/// Residual power at the frequency of a component, relative to its removed power, above which the component is no sine, …
const MAX_RESIDUAL_POWER: f64 = 0.25;

/// … if it exceeds this multiple of that on neighbouring lines: four exponential variates exceed four times their mean 1 in 12 000 times.
const MIN_RATIO_TO_NEIGHBOURS: f64 = 4.0;

/// Offsets of the neighbouring lines, in line spacings of a quarter to either side of the sine: beyond the main lobe of the window.
const NEIGHBOUR_LINES: std::ops::RangeInclusive<usize> = 4..=7;

/// Sines of two blocks closer than this are the same sine; in line spacings of a block.
const SAME_SINE_LINES: f64 = 2.0;

/// Removes constant sines from channels of equal length; sorted by frequency, amplitudes averaged over the blocks that contain the sine.
///
/// # Errors
/// Errors of [`remove_tones`]: samples that are not finite.
pub fn remove_constant_sines(rate_hz: f64, channels: &mut [Vec<f64>]) -> Result<Vec<Tone>, Error> {
    let n = channels.first().map_or(0, Vec::len);
    let blocks = n.div_ceil(MAX_BLOCK_LEN).max(1);
    let mut detected: Vec<(Tone, usize)> = Vec::new();
    for k in 0..blocks {
        let (from, to) = (k * n / blocks, (k + 1) * n / blocks);
        let before: Vec<Vec<f64>> = channels.iter().map(|c| c[from..to].to_vec()).collect();
        let mut after = before.clone();
        let tones = remove_tones(rate_hz, &mut after)?;
        let line_spacing = rate_hz / (to - from).max(1) as f64;
        for tone in tones {
            if varies(rate_hz, &before, &after, &tone) {
                restore(rate_hz, &before, &mut after, &tone)?;
                continue;
            }
            let is_same_sine = |t: &&mut (Tone, usize)| {
                (t.0.frequency_hz - tone.frequency_hz).abs() < SAME_SINE_LINES * line_spacing
                    && t.1 < blocks
            };
            match detected.iter_mut().find(is_same_sine) {
                Some((average, count)) if k > 0 => {
                    let share = 1.0 / (*count as f64 + 1.0);
                    average.frequency_hz += share * (tone.frequency_hz - average.frequency_hz);
                    for (a, b) in average.amplitude.iter_mut().zip(&tone.amplitude) {
                        *a += share * (b - *a);
                    }
                    average.probability = average.probability.min(tone.probability);
                    *count += 1;
                }
                _ => detected.push((tone, 1)),
            }
        }
        for (channel, block) in channels.iter_mut().zip(&after) {
            channel[from..to].copy_from_slice(block);
        }
    }
    let mut tones: Vec<Tone> = detected.into_iter().map(|t| t.0).collect();
    sort_ascending(&mut tones, |a| a.frequency_hz);
    Ok(tones)
}

/// True if the amplitude or phase of a removed component varies between the quarters of a block.
fn varies(rate_hz: f64, before: &[Vec<f64>], after: &[Vec<f64>], tone: &Tone) -> bool {
    let strongest = (0..tone.amplitude.len())
        .max_by(|&a, &b| tone.amplitude[a].total_cmp(&tone.amplitude[b]))
        .unwrap_or(0);
    let n_samples = after[strongest].len() / QUARTERS;
    let line_spacing = rate_hz / n_samples as f64;
    let (mut removed_power, mut residual_power, mut neighbour_power) = (0.0, 0.0, 0.0);
    for quarter in 0..QUARTERS {
        let range = quarter * n_samples..(quarter + 1) * n_samples;
        let residual = &after[strongest][range.clone()];
        let removed: Vec<f64> = (before[strongest][range].iter().zip(residual))
            .map(|(b, a)| b - a)
            .collect();
        let power = |samples: &[f64], f: f64| hann_transform(samples, f / rate_hz).norm_sqr();
        removed_power += power(&removed, tone.frequency_hz);
        residual_power += power(residual, tone.frequency_hz);
        let neighbours = NEIGHBOUR_LINES
            .flat_map(|k| [-1.0, 1.0].map(|s| tone.frequency_hz + s * k as f64 * line_spacing));
        neighbour_power += neighbours.map(|f| power(residual, f)).sum::<f64>()
            / (2 * NEIGHBOUR_LINES.count()) as f64;
    }
    residual_power > MAX_RESIDUAL_POWER * removed_power
        && residual_power > MIN_RATIO_TO_NEIGHBOURS * neighbour_power
}

/// Restores a removed component: adds the part of the removed signal at its frequency.
fn restore(
    rate_hz: f64,
    before: &[Vec<f64>],
    after: &mut [Vec<f64>],
    tone: &Tone,
) -> Result<(), Error> {
    for (b, a) in before.iter().zip(after) {
        let removed: Vec<f64> = b.iter().zip(a.iter()).map(|(b, a)| b - a).collect();
        sine::fit_amplitude(&removed, rate_hz, tone.frequency_hz)?.add_to(a, rate_hz);
    }
    Ok(())
}

/// Hann-windowed Fourier transform at a frequency in cycles per sample.
fn hann_transform(samples: &[f64], cycles_per_sample: f64) -> Complex {
    let n = samples.len() as f64;
    let rotation = Complex::from_polar(1.0, -TAU * cycles_per_sample);
    let mut phasor = Complex::new(1.0, 0.0);
    let mut sum = Complex::ZERO;
    for (t, x) in samples.iter().enumerate() {
        let window = (PI * (t as f64 + 0.5) / n).sin().powi(2);
        sum += phasor * (window * x);
        phasor *= rotation;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A resonance as narrow as the line spacing is retained in most cases (of 200 that pass the sine test 87 % vary), a sine is removed.
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
                    let sample = (t - 200_000) as f64;
                    y.push(x + 50.0 * noise() + 300.0 * (TAU * 17.7 / rate * sample).sin());
                }
            }
            let found = remove_constant_sines(rate, &mut [y]).unwrap();
            let is_removed = |f: f64| found.iter().any(|t| (t.frequency_hz - f).abs() < 0.05);
            assert!(is_removed(17.7), "{found:?}");
            stayed += usize::from(!is_removed(31.3));
        }
        assert!(stayed >= 5, "{stayed} of 8");
    }
}
