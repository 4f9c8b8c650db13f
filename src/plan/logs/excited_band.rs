//! Frequency band excited by an input: its power is near the plateau, and the responses exceed their noise.

use crate::numeric::Complex;
use crate::numeric::statistics::median;
use crate::spectrum::frf::FrfEstimate;
use crate::spectrum::spectra::Spectra;

/// Power of hits and steps relative to the maximum at which the band ends, −30 dB; near a null of the pulse, noise over force forms peaks.
const HIT_POWER_SHARE: f64 = 1e-3;

/// Minimum ratio of response power to variance, median over neighbouring lines; noise alone has about 1.
const MIN_SIGNIFICANCE: f64 = 3.0;

/// Divisor of the number of lines for the width of a median, and its minimum width, lines.
const MEDIAN_LINES: (usize, usize) = (32, 16);

/// Excited band of hits or steps, Hz, from the power of the force by line: it ends where the power falls below [`HIT_POWER_SHARE`] of its
/// maximum, or after the last lines on which a response exceeds its noise.
pub fn of_hits(power: &[f64], estimate: &FrfEstimate) -> Option<(f64, f64)> {
    let largest = power.iter().copied().fold(0.0, f64::max);
    let is_weak = |p: &f64| *p < HIT_POWER_SHARE * largest;
    let lines = power.iter().position(is_weak).unwrap_or(power.len());
    let step = (lines / MEDIAN_LINES.0).max(MEDIAN_LINES.1);
    let is_significant = |from: usize| {
        let lines = from..(from + step).min(lines);
        let ratio = |values: &[Complex], variance: &[f64]| {
            let significance = |k: usize| match variance[k] > 0.0 {
                true => values[k].norm_sqr() / variance[k],
                false => f64::INFINITY,
            };
            median(&mut lines.clone().map(significance).collect::<Vec<f64>>())
        };
        estimate.functions.iter().any(|f| match &f.variance {
            Some(variance) => ratio(&f.values, variance).is_some_and(|r| r > MIN_SIGNIFICANCE),
            None => true,
        })
    };
    let mut starts = (1..lines).step_by(step);
    let end = match starts.rfind(|&from| is_significant(from)) {
        Some(from) => (from + step).min(lines),
        None => lines,
    };
    Some((
        *estimate.frequency_hz.get(1)?,
        *estimate.frequency_hz.get(end.checked_sub(1)?)?,
    ))
}

/// Power relative to the plateau below which an input does not excite, −40 dB.
pub const PLATEAU_POWER_SHARE: f64 = 1e-4;

/// Band excited by all inputs, Hz: the lines around the maximum on which the smoothed power of each exceeds [`PLATEAU_POWER_SHARE`] of its
/// plateau; narrow dips are ignored.
pub fn of_inputs(spectra: &Spectra, inputs: &[usize]) -> Option<(f64, f64)> {
    /// Width of the running median, lines; it removes single lines such as those of the mains.
    const MEDIAN_LINES: usize = 9;
    /// Divisor of the number of lines for the width of an ignored dip.
    const DIP_DIVISOR: usize = 20;
    let lines = spectra.frequency_hz.len();
    let medians = (0..lines).map(|line| {
        let median_power = |&c: &usize| -> f64 {
            let psd = &spectra.psd[c];
            let mut window = psd
                [line.saturating_sub(MEDIAN_LINES / 2)..(line + MEDIAN_LINES / 2 + 1).min(lines)]
                .to_vec();
            window.sort_by(f64::total_cmp);
            window[window.len() / 2]
        };
        inputs.iter().map(median_power).collect::<Vec<f64>>()
    });
    let smooth: Vec<Vec<f64>> = medians.collect();
    let plateau: Vec<f64> = (0..inputs.len())
        .map(|j| smooth.iter().map(|s| s[j]).fold(0.0, f64::max))
        .collect();
    let share = |line: usize| {
        let ratio = |(s, p): (&f64, &f64)| if *p > 0.0 { s / p } else { 0.0 };
        (smooth[line].iter().zip(&plateau).map(ratio)).fold(1.0, f64::min)
    };
    let shares: Vec<f64> = (0..lines).map(share).collect();
    let top = (0..lines).max_by(|&a, &b| shares[a].total_cmp(&shares[b]))?;
    let dip = lines / DIP_DIVISOR;
    let band_edge = |from: usize, step: isize| -> usize {
        let (mut last, mut line) = (from as isize, from as isize);
        while line >= 0 && (line as usize) < lines && (line - last).unsigned_abs() <= dip {
            if shares[line as usize] >= PLATEAU_POWER_SHARE {
                last = line;
            }
            line += step;
        }
        last as usize
    };
    let (low, high) = (band_edge(top, -1), band_edge(top, 1));
    (shares[top] >= PLATEAU_POWER_SHARE && low < high)
        .then(|| (spectra.frequency_hz[low], spectra.frequency_hz[high]))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::spectrum::impact::{ImpactOptions, estimate_from_hits};

    /// Five half-sine hits with a spectral null at 964 Hz on a structure with noise: the band ends below the null, where lines are noise
    /// over force. With more noise the band ends where the response falls below its noise.
    #[test]
    fn law_band_ends_before_the_null_and_the_noise() {
        const RATE: f64 = 5000.0;
        let end = |noise: f64| {
            let mut rng = fastrand::Rng::with_seed(3);
            let mut normal = || (0..12).map(|_| rng.f64()).sum::<f64>() - 6.0;
            let width = 1.5 / 964.0;
            let (mut force, mut response) = (Vec::new(), Vec::new());
            for _ in 0..5 {
                let mut state = Complex::new(0.0, 0.0);
                let pole = Complex::new(-0.01, 1.0) * TAU * 200.0;
                let step = (pole / RATE).exp();
                for j in 0..10_000 {
                    let t = f64::from(j) / RATE - 0.1;
                    let hit = match (0.0..width).contains(&t) {
                        true => 1000.0 * (PI * t / width).sin(),
                        false => 0.0,
                    };
                    state = state * step + hit / RATE;
                    force.push(hit + 0.01 * normal());
                    response.push(state.im + noise * normal());
                }
            }
            let segment = 0..force.len();
            let result = estimate_from_hits(
                RATE,
                &force,
                &[&response],
                std::slice::from_ref(&segment),
                &ImpactOptions::default(),
            )
            .unwrap();
            of_hits(&result.force_power, &result.estimate).unwrap().1
        };
        let quiet = end(1e-6);
        assert!((850.0..950.0).contains(&quiet), "{quiet}");
        let noisy = end(0.02);
        assert!((210.0..800.0).contains(&noisy), "{noisy}");
    }
}
