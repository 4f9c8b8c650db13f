//! The band that an input excites: where its power is near its plateau, and responses rise above their noise.

use crate::numeric::Complex;
use crate::numeric::statistics::median;
use crate::spectrum::frf::FrfEstimate;
use crate::spectrum::spectra::Spectra;

/// Power of hits and steps below their largest that no longer drives: 30 dB. About the null of a pulse noise over force is a peak by itself.
const HIT_POWER_SHARE: f64 = 1e-3;

/// Power of a response over its variance, as medians over neighbouring lines, below which it is noise: that of noise alone is about 1.
const MIN_SIGNIFICANCE: f64 = 3.0;

/// Share of the lines that a median is taken over, and fewest lines.
const MEDIAN_LINES: (usize, usize) = (32, 16);

/// Excited band of hits or steps, from the power of the force by line: up to where it falls [`HIT_POWER_SHARE`] below its largest, and no
/// further than the last lines on which a response rises above its noise.
pub fn of_hits(power: &[f64], estimate: &FrfEstimate) -> Option<(f64, f64)> {
    let largest = power.iter().copied().fold(0.0, f64::max);
    let is_lost = |p: &f64| *p < HIT_POWER_SHARE * largest;
    let lines = power.iter().position(is_lost).unwrap_or(power.len());
    let step = (lines / MEDIAN_LINES.0).max(MEDIAN_LINES.1);
    let rises = |from: usize| {
        let lines = from..(from + step).min(lines);
        let ratio = |values: &[Complex], variance: &[f64]| {
            let of_line = |k: usize| match variance[k] > 0.0 {
                true => values[k].norm_sqr() / variance[k],
                false => f64::INFINITY,
            };
            median(&mut lines.clone().map(of_line).collect::<Vec<f64>>())
        };
        estimate.functions.iter().any(|f| match &f.variance {
            Some(variance) => ratio(&f.values, variance).is_some_and(|r| r > MIN_SIGNIFICANCE),
            None => true,
        })
    };
    let mut starts = (1..lines).step_by(step);
    let end = match starts.rfind(|&from| rises(from)) {
        Some(from) => (from + step).min(lines),
        None => lines,
    };
    Some((
        *estimate.frequency_hz.get(1)?,
        *estimate.frequency_hz.get(end.checked_sub(1)?)?,
    ))
}

/// Power below the plateau that no longer drives: 40 dB.
pub const PLATEAU_POWER_SHARE: f64 = 1e-4;

/// Band excited by every input: the segment of lines around its largest, single lines passed over, where it is within
/// [`PLATEAU_POWER_SHARE`] of its plateau.
pub fn of_inputs(spectra: &Spectra, inputs: &[usize]) -> Option<(f64, f64)> {
    /// Lines of the running median, which lines of the mains do not reach.
    const MEDIAN_LINES: usize = 9;
    /// Dips narrower than this share of the spectrum are passed over.
    const MAX_DIP_SHARE: usize = 20;
    let lines = spectra.frequency_hz.len();
    let least = (0..lines).map(|at| {
        let of = |&c: &usize| -> f64 {
            let psd = &spectra.psd[c];
            let mut near = psd
                [at.saturating_sub(MEDIAN_LINES / 2)..(at + MEDIAN_LINES / 2 + 1).min(lines)]
                .to_vec();
            near.sort_by(f64::total_cmp);
            near[near.len() / 2]
        };
        inputs.iter().map(of).collect::<Vec<f64>>()
    });
    let smooth: Vec<Vec<f64>> = least.collect();
    let plateau: Vec<f64> = (0..inputs.len())
        .map(|j| smooth.iter().map(|s| s[j]).fold(0.0, f64::max))
        .collect();
    let share = |at: usize| {
        let of = |(s, p): (&f64, &f64)| if *p > 0.0 { s / p } else { 0.0 };
        smooth[at].iter().zip(&plateau).map(of).fold(1.0, f64::min)
    };
    let shares: Vec<f64> = (0..lines).map(share).collect();
    let top = (0..lines).max_by(|&a, &b| shares[a].total_cmp(&shares[b]))?;
    let dip = lines / MAX_DIP_SHARE;
    let reach = |from: usize, step: isize| -> usize {
        let (mut last, mut at) = (from as isize, from as isize);
        while at >= 0 && (at as usize) < lines && (at - last).unsigned_abs() <= dip {
            if shares[at as usize] >= PLATEAU_POWER_SHARE {
                last = at;
            }
            at += step;
        }
        last as usize
    };
    let (low, high) = (reach(top, -1), reach(top, 1));
    (shares[top] >= PLATEAU_POWER_SHARE && low < high)
        .then(|| (spectra.frequency_hz[low], spectra.frequency_hz[high]))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use super::*;
    use crate::spectrum::impact::{ImpactOptions, estimate_from_hits};

    /// Five hits of half a sine whose spectrum has its null at 964 Hz, on a structure with noise: the band ends before the null, and about
    /// it no line is noise over force. Where the response sinks into its noise sooner, it ends there.
    #[test]
    fn law_band_ends_before_the_null_and_the_noise() {
        const RATE: f64 = 5000.0;
        let end = |noise: f64| {
            let mut rng = fastrand::Rng::with_seed(3);
            let mut normal = || (0..12).map(|_| rng.f64()).sum::<f64>() - 6.0;
            let width = 1.5 / 964.0;
            let (mut force, mut motion) = (Vec::new(), Vec::new());
            for _ in 0..5 {
                let mut state = Complex::new(0.0, 0.0);
                let pole = Complex::new(-0.01, 1.0) * TAU * 200.0;
                let step = (pole / RATE).exp();
                for j in 0..10_000 {
                    let t = f64::from(j) / RATE - 0.1;
                    let own = match (0.0..width).contains(&t) {
                        true => 1000.0 * (PI * t / width).sin(),
                        false => 0.0,
                    };
                    state = state * step + own / RATE;
                    force.push(own + 0.01 * normal());
                    motion.push(state.im + noise * normal());
                }
            }
            let whole = 0..force.len();
            let found = estimate_from_hits(
                RATE,
                &force,
                &[&motion],
                std::slice::from_ref(&whole),
                &ImpactOptions::default(),
            )
            .unwrap();
            of_hits(&found.force_power, &found.estimate).unwrap().1
        };
        let quiet = end(1e-6);
        assert!((850.0..950.0).contains(&quiet), "{quiet}");
        let noisy = end(0.02);
        assert!((210.0..800.0).contains(&noisy), "{noisy}");
    }
}
