//! Detection of force pulses of an impact hammer, and of clipping.

use std::cell::OnceCell;
use std::ops::Range;

use crate::numeric::statistics;

/// Force pulse of an impact hammer.
#[derive(Debug, Clone, PartialEq)]
pub struct ForcePulse {
    /// Range of samples above the threshold.
    pub samples: Range<usize>,
    /// Index of the sample of largest force.
    pub peak: usize,
    /// Signed peak force relative to the baseline, in the unit of the force.
    pub height: f64,
}

/// Detected force pulses of a segment, with baseline, noise and threshold in the unit of the force.
#[derive(Debug, Clone, PartialEq)]
pub struct ForcePulses {
    /// Baseline between pulses: the median.
    pub baseline: f64,
    /// Standard deviation of the noise between pulses, by the median absolute deviation.
    pub noise: f64,
    /// Detection threshold relative to the baseline.
    pub threshold: f64,
    /// Pulses in the order of time.
    pub pulses: Vec<ForcePulse>,
}

/// Detection threshold in standard deviations of the noise: one false alarm in 1e15 samples of normal noise.
const NOISE_THRESHOLD_SIGMA: f64 = 8.0;

/// Detection threshold relative to the largest pulse, above the ripples of anti-aliasing filters.
const PEAK_THRESHOLD_SHARE: f64 = 0.05;

/// Ratio of standard deviation to median absolute deviation of normal noise.
const MAD_TO_STD: f64 = 1.4826;

/// Approximate number of equally spaced samples for a median: its error, 0.4 % of the noise, is negligible.
const MEDIAN_SAMPLES: usize = 100_000;

/// Median of a segment by decimation; 0 for an empty segment.
pub fn median(samples: &[f64]) -> f64 {
    let step = samples.len().div_ceil(MEDIAN_SAMPLES).max(1);
    let mut picked: Vec<f64> = samples.iter().step_by(step).copied().collect();
    statistics::median(&mut picked).unwrap_or(0.0)
}

/// Pulses of a force with the sign of the largest.
pub fn find_force_pulses(force: &[f64]) -> ForcePulses {
    pulses_to(force, false)
}

/// Pulses of a force with `both` signs or with that of the largest.
pub fn pulses_to(force: &[f64], both: bool) -> ForcePulses {
    let baseline = median(force);
    let step = force.len().div_ceil(MEDIAN_SAMPLES).max(1);
    let picked = force.iter().step_by(step);
    let deviations: Vec<f64> = picked.map(|f| (f - baseline).abs()).collect();
    let noise = MAD_TO_STD * median(&deviations);
    let largest = force.iter().fold(0.0_f64, |max, f| {
        if (f - baseline).abs() > max.abs() {
            f - baseline
        } else {
            max
        }
    });
    let threshold = (NOISE_THRESHOLD_SIGMA * noise).max(PEAK_THRESHOLD_SHARE * largest.abs());
    let mut result = ForcePulses {
        baseline,
        noise,
        threshold,
        pulses: Vec::new(),
    };
    let is_above = |f: f64| {
        let excess = (f - baseline) * largest.signum();
        excess > threshold || (both && -excess > threshold)
    };
    let mut next = 0;
    while let Some(start) = (next..force.len()).find(|&j| is_above(force[j])) {
        let end = (start..force.len())
            .find(|&j| !is_above(force[j]))
            .unwrap_or(force.len());
        result.push_run(start..end, force);
        next = end;
    }
    result
}

impl ForcePulses {
    /// Adds a run above the threshold; a gap shorter than the last pulse merges the run with that pulse.
    fn push_run(&mut self, run: Range<usize>, force: &[f64]) {
        let joined = match self.pulses.last() {
            Some(last) if run.start - last.samples.end < last.samples.len() => {
                let start = last.samples.start;
                self.pulses.pop();
                start..run.end
            }
            _ => run,
        };
        let size = |j: usize| (force[j] - self.baseline).abs();
        let peak = joined
            .clone()
            .max_by(|&i, &j| size(i).total_cmp(&size(j)))
            .unwrap_or(joined.start);
        self.pulses.push(ForcePulse {
            height: force[peak] - self.baseline,
            samples: joined,
            peak,
        });
    }
}

/// Least share of the energy of an impact force in its pulses.
const MIN_ENERGY_IN_PULSES: f64 = 0.8;

/// Largest share of the time in pulses of an impact force; random bursts have both signs and fail the energy criterion.
const MAX_PULSE_DUTY: f64 = 0.05;

/// Whether a force is that of an impact hammer: nearly all its energy is in few short pulses of one sign.
pub fn is_impact(force: &[f64]) -> bool {
    let hits = find_force_pulses(force);
    let energy = |samples: &[f64]| {
        let square = |f: &f64| (f - hits.baseline).powi(2);
        samples.iter().map(square).sum::<f64>()
    };
    // The noise between the pulses does not count.
    let noise = force.len() as f64 * hits.noise * hits.noise;
    let n_samples: usize = hits.pulses.iter().map(|p| p.samples.len()).sum();
    let energy_of_sign = |p: &ForcePulse| {
        let samples = force[p.samples.clone()].iter().map(|f| f - hits.baseline);
        let square = |f: f64| if f * p.height > 0.0 { f * f } else { 0.0 };
        samples.map(square).sum::<f64>()
    };
    let pulse_energy: f64 = hits.pulses.iter().map(energy_of_sign).sum();
    !hits.pulses.is_empty()
        && !hits.pulses.iter().any(|p| is_level(p, force))
        && n_samples as f64 <= MAX_PULSE_DUTY * force.len() as f64
        && pulse_energy >= MIN_ENERGY_IN_PULSES * (energy(force) - noise)
}

/// Whether a pulse at an end of the record is a level, before a release or after a step: half of its samples lie within a tenth of its
/// height of the peak, against 30 % for half a sine truncated at its peak.
fn is_level(pulse: &ForcePulse, force: &[f64]) -> bool {
    const MIN_COUNT: usize = 16;
    const NEAR: f64 = 0.1;
    const SHARE: f64 = 0.5;
    let at_end = pulse.samples.start == 0 || pulse.samples.end == force.len();
    let near = |f: &&f64| (**f - force[pulse.peak]).abs() <= NEAR * pulse.height.abs();
    let count = force[pulse.samples.clone()].iter().filter(near).count();
    at_end && count >= MIN_COUNT && count as f64 > SHARE * pulse.samples.len() as f64
}

/// Maximum number of steps of a force; a signal of more steps, such as a random binary one, is continuous excitation.
const MAX_STEPS: usize = 20;

/// Least change of level over a step relative to the range of the force within it: a zero-phase filter overshoots by 9 % on both
/// sides; a pulse returns to its level.
const MIN_LEVEL_CHANGE: f64 = 0.5;

/// Distance of pulses of the differences, relative to the longest, within which they are ripples of one step.
const RIPPLE_DISTANCE: usize = 2;

/// First differences of samples; 0 for the first sample.
pub fn differences(samples: &[f64]) -> Vec<f64> {
    let first = samples.iter().take(1).map(|_| 0.0);
    first
        .chain(samples.windows(2).map(|w| w[1] - w[0]))
        .collect()
}

/// Whether a force consists of steps between levels, as on a release: nearly all the energy of its differences is in few short pulses,
/// and the level differs across each. Ripples of an anti-aliasing filter before and after a step belong to it.
pub fn is_stepwise(force: &[f64]) -> bool {
    let changes = differences(force);
    let detected = pulses_to(&changes, true);
    let energy = |samples: &[f64]| samples.iter().map(|d| d * d).sum::<f64>();
    let noise = changes.len() as f64 * detected.noise * detected.noise;
    let n_samples: usize = detected.pulses.iter().map(|p| p.samples.len()).sum();
    let pulse_energy: f64 = (detected.pulses.iter())
        .map(|p| energy(&changes[p.samples.clone()]))
        .sum();
    let steps = joined_pulses(&detected.pulses);
    (1..=MAX_STEPS).contains(&steps.len())
        && n_samples as f64 <= MAX_PULSE_DUTY * force.len() as f64
        && pulse_energy >= MIN_ENERGY_IN_PULSES * (energy(&changes) - noise)
        && (0..steps.len()).all(|k| changes_level(force, &steps, k))
}

/// Sample ranges of steps: pulses of the differences merged with the filter ripples around them.
fn joined_pulses(pulses: &[ForcePulse]) -> Vec<Range<usize>> {
    let longest = pulses.iter().map(|p| p.samples.len()).max().unwrap_or(0);
    let mut joined: Vec<Range<usize>> = Vec::new();
    for pulse in pulses {
        match joined.last_mut() {
            Some(last) if pulse.samples.start - last.end <= RIPPLE_DISTANCE * longest => {
                last.end = pulse.samples.end;
            }
            _ => joined.push(pulse.samples.clone()),
        }
    }
    joined
}

/// Whether the level of the force, by medians between neighbouring steps, differs before and after the k-th of `steps`.
fn changes_level(force: &[f64], steps: &[Range<usize>], k: usize) -> bool {
    let step = &steps[k];
    let start = if k == 0 { 0 } else { steps[k - 1].end };
    let end = steps.get(k + 1).map_or(force.len(), |next| next.start);
    let level = |samples: &[f64], edge: f64| match samples {
        [] => edge,
        _ => median(samples),
    };
    let first = step.start.saturating_sub(1);
    let before = level(&force[start..first.max(start)], force[first]);
    let after = level(&force[step.end..end], force[step.end - 1]);
    let ends = (before.min(after), before.max(after));
    let (low, high) =
        (force[step.clone()].iter()).fold(ends, |(low, high), &f| (low.min(f), high.max(f)));
    (after - before).abs() >= MIN_LEVEL_CHANGE * (high - low)
}

/// Minimum number of equal samples at the extreme of a clipped signal.
const MIN_CLIPPED_RUN: usize = 3;

/// Least fall after a clipped run, relative to the largest fall of a smooth peak.
const CURVATURE_MARGIN: f64 = 1.2;

/// Largest fall of a parabola rounded to steps of 1, at the sample after `run` equal samples at its peak. These lie within one step,
/// which limits the quadratic coefficient to `4/(run − 1)²`.
fn expected_fall(run: usize) -> f64 {
    let m = run as f64;
    1.0 + ((m + 1.0) / (m - 1.0)).powi(2)
}

/// Minimum number of distinct values for an estimate of the converter's step by their differences.
const MIN_DISTINCT_VALUES: usize = 64;

/// Default step of the converter relative to the range: 8 bits.
const DEFAULT_RESOLUTION: f64 = 1.0 / 256.0;

/// Converter step: the least difference of distinct values.
fn resolution(samples: &[f64]) -> f64 {
    let mut values = samples.to_vec();
    values.sort_unstable_by(f64::total_cmp);
    values.dedup();
    match values[..] {
        [lowest, .., highest] if values.len() < MIN_DISTINCT_VALUES => {
            DEFAULT_RESOLUTION * (highest - lowest)
        }
        _ => values
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .fold(f64::INFINITY, f64::min),
    }
}

/// Whether samples are clipped at their largest or smallest value, as by an overloaded amplifier.
pub fn is_clipped(samples: &[f64]) -> bool {
    let step = OnceCell::new();
    let is_clipped_at = |extreme: f64| {
        let mut next = 0;
        while let Some(start) = (next..samples.len()).find(|&j| samples[j] == extreme) {
            let end = (start..samples.len())
                .find(|&j| samples[j] != extreme)
                .unwrap_or(samples.len());
            let fall = |j: Option<&f64>| j.map_or(0.0, |x| (x - extreme).abs());
            let before = start.checked_sub(1).and_then(|j| samples.get(j));
            let steepest = fall(before).max(fall(samples.get(end)));
            let expected = || step.get_or_init(|| resolution(samples)) * expected_fall(end - start);
            if end - start >= MIN_CLIPPED_RUN && steepest > CURVATURE_MARGIN * expected() {
                return true;
            }
            next = end;
        }
        false
    };
    let largest = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let smallest = samples.iter().copied().fold(f64::INFINITY, f64::min);
    // The baseline between events may be an extreme too, but is close to the median.
    let level = median(samples);
    let is_far = |extreme: f64| 2.0 * (extreme - level).abs() >= largest - smallest;
    [largest, smallest]
        .into_iter()
        .any(|extreme| largest > smallest && is_far(extreme) && is_clipped_at(extreme))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Half a sine of `width` samples at each of `starts`.
    fn blows(n: usize, starts: &[usize], width: usize) -> Vec<f64> {
        let mut force = vec![0.0; n];
        for &start in starts {
            for j in 0..width {
                force[start + j] += (PI * (j as f64 + 0.5) / width as f64).sin();
            }
        }
        force
    }

    #[test]
    fn exact_pulses_without_noise() {
        let found = find_force_pulses(&blows(1000, &[100, 500], 9));
        let tops: Vec<usize> = found.pulses.iter().map(|p| p.peak).collect();
        assert_eq!(tops, [104, 504]);
        assert_eq!(found.pulses[0].samples, 100..109);
    }

    /// Impacts of both signs and in noise; no sine, noise, burst of noise or zero signal.
    #[test]
    fn law_what_is_impact() {
        let mut rng = fastrand::Rng::with_seed(1);
        let mut noise = |size: f64| size * (rng.f64() - 0.5);
        let hits = blows(20_000, &[3000, 9000, 15_000], 20);
        assert!(is_impact(&hits));
        let down: Vec<f64> = hits.iter().map(|f| 3.0 - f + noise(0.05)).collect();
        assert!(is_impact(&down));
        let sine: Vec<f64> = (0..20_000).map(|j| (f64::from(j) * 0.1).sin()).collect();
        let random: Vec<f64> = (0..20_000).map(|_| noise(1.0)).collect();
        let burst: Vec<f64> = (0..20_000)
            .map(|j| noise(if j < 600 { 1.0 } else { 0.001 }))
            .collect();
        for force in [&sine, &random, &burst, &vec![0.0; 100], &Vec::new()] {
            assert!(!is_impact(force));
        }
    }

    /// Steps up and down, and a release soon after the start of the record, are no impacts; impacts are no steps.
    #[test]
    fn law_what_is_a_step() {
        let mut rng = fastrand::Rng::with_seed(2);
        let mut noise = |size: f64| size * (rng.f64() - 0.5);
        let levels = |from: usize, to: usize| {
            let rise = move |j: usize| ((j as f64 - from as f64) / 6.0).clamp(0.0, 1.0);
            let fall = move |j: usize| ((j as f64 - to as f64) / 6.0).clamp(0.0, 1.0);
            (0..20_000).map(move |j| rise(j) - fall(j))
        };
        let plain: Vec<f64> = levels(5000, 12_000).collect();
        let noisy: Vec<f64> = plain.iter().map(|f| 2.0 - f + noise(0.01)).collect();
        let held: Vec<f64> = levels(0, 500).skip(6).collect();
        let release: Vec<f64> = held.iter().map(|f| f + noise(0.01)).collect();
        // A linear-phase filter at 0.4 of the rate: ripples of 9 % before and after each step.
        let filtered = |force: &[f64]| -> Vec<f64> {
            let tap = |k: i32| match k {
                0 => 0.4,
                _ => (0.4 * PI * f64::from(k)).sin() / (PI * f64::from(k)),
            };
            let at = |j: usize| {
                let near = |k: i32| force[(j as i32 + k).clamp(0, force.len() as i32 - 1) as usize];
                (-64..=64).map(|k| tap(k) * near(k)).sum()
            };
            (0..force.len()).map(at).collect()
        };
        let sharp: Vec<f64> = (0..20_000)
            .map(|j| f64::from(u8::from((5000..12_000).contains(&j))))
            .collect();
        let rippled = filtered(&sharp);
        let dropped: Vec<f64> = (filtered(&sharp[4000..11_000]).iter())
            .map(|f| 300.0 * (1.0 - f) + noise(0.1))
            .collect();
        for force in [&plain, &noisy, &release, &rippled, &dropped] {
            assert!(is_stepwise(force) && !is_impact(force));
        }
        let hits = blows(20_000, &[3000, 9000, 15_000], 20);
        assert!(!is_stepwise(&filtered(&blows(20_000, &[3000, 9000], 3))));
        let random: Vec<f64> = (0..20_000).map(|_| noise(1.0)).collect();
        let binary: Vec<f64> = (0..20_000).map(|j| f64::from((j / 50) % 3 % 2)).collect();
        for force in [&hits, &random, &binary, &vec![0.0; 100], &Vec::new()] {
            assert!(!is_stepwise(force));
        }
    }

    #[test]
    fn law_clipping_is_a_flat_top_and_a_round_one_is_not() {
        let force = blows(200, &[100], 40);
        let cut: Vec<f64> = force.iter().map(|f| f.min(0.8)).collect();
        let coarse: Vec<f64> = force.iter().map(|f| (f * 64.0).round() / 64.0).collect();
        assert!(is_clipped(&cut) && !is_clipped(&force) && !is_clipped(&coarse));
        let down: Vec<f64> = cut.iter().map(|f| -f).collect();
        assert!(is_clipped(&down));
    }
}
