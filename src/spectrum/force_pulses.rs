//! Detection of force pulses of an impact hammer, and of clipping.

use std::cell::OnceCell;
use std::ops::Range;

use crate::numeric::statistics;

/// One pulse of the force.
#[derive(Debug, Clone, PartialEq)]
pub struct ForcePulse {
    /// Samples above the threshold.
    pub samples: Range<usize>,
    /// Sample of its largest force.
    pub peak: usize,
    /// Largest force over the level between pulses, with its sign.
    pub height: f64,
}

/// The pulses of a segment of force.
#[derive(Debug, Clone, PartialEq)]
pub struct ForcePulses {
    /// Level between pulses: the median.
    pub baseline: f64,
    /// Standard deviation of the noise between pulses, by the median deviation.
    pub noise: f64,
    /// Size a pulse must have.
    pub threshold: f64,
    /// In the order of time.
    pub pulses: Vec<ForcePulse>,
}

/// A pulse is this many standard deviations above the noise: once in 1e15 samples of normal noise.
const NOISE_THRESHOLD_SIGMA: f64 = 8.0;

/// And this share of the largest: below it are the ripples of anti-aliasing filters.
const PEAK_THRESHOLD_SHARE: f64 = 0.05;

/// Median deviation of normal noise to its standard deviation.
const MAD_TO_STD: f64 = 1.4826;

/// Medians are taken over about this many samples, evenly picked: their error, 0.4 % of the noise, does not matter here.
const MEDIAN_SAMPLES: usize = 100_000;

/// The median of a segment; 0 of nothing.
pub fn median(samples: &[f64]) -> f64 {
    let step = samples.len().div_ceil(MEDIAN_SAMPLES).max(1);
    let mut picked: Vec<f64> = samples.iter().step_by(step).copied().collect();
    statistics::median(&mut picked).unwrap_or(0.0)
}

/// The pulses of a force to the side of its largest.
pub fn find_force_pulses(force: &[f64]) -> ForcePulses {
    pulses_to(force, false)
}

/// The pulses of a force, to `both` sides or to that of its largest.
pub fn pulses_to(force: &[f64], both: bool) -> ForcePulses {
    let baseline = median(force);
    let step = force.len().div_ceil(MEDIAN_SAMPLES).max(1);
    let picked = force.iter().step_by(step);
    let deviations: Vec<f64> = picked.map(|f| (f - baseline).abs()).collect();
    let noise = MAD_TO_STD * median(&deviations);
    let largest = force.iter().fold(0.0_f64, |most, f| {
        if (f - baseline).abs() > most.abs() {
            f - baseline
        } else {
            most
        }
    });
    let threshold = (NOISE_THRESHOLD_SIGMA * noise).max(PEAK_THRESHOLD_SHARE * largest.abs());
    let mut found = ForcePulses {
        baseline,
        noise,
        threshold,
        pulses: Vec::new(),
    };
    let is_above = |f: f64| {
        let over = (f - baseline) * largest.signum();
        over > threshold || (both && -over > threshold)
    };
    let mut at = 0;
    while let Some(start) = (at..force.len()).find(|&j| is_above(force[j])) {
        let end = (start..force.len())
            .find(|&j| !is_above(force[j]))
            .unwrap_or(force.len());
        found.push_run(start..end, force);
        at = end;
    }
    found
}

impl ForcePulses {
    /// Adds a run above the threshold; one that comes sooner after the last than that lasted is part of it.
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

/// Least share of the energy of an impact force that lies in its pulses …
const MIN_ENERGY_IN_PULSES: f64 = 0.8;

/// … and they take this share of the time at most; random bursts lie on both sides and fail the first.
const MAX_PULSE_DUTY: f64 = 0.05;

/// Whether a force is a record of hits: nearly all its energy in few short pulses to one side.
pub fn is_impact(force: &[f64]) -> bool {
    let found = find_force_pulses(force);
    let energy = |samples: &[f64]| {
        let square = |f: &f64| (f - found.baseline).powi(2);
        samples.iter().map(square).sum::<f64>()
    };
    // The noise outside the pulses says nothing of what the force is for.
    let noise = force.len() as f64 * found.noise * found.noise;
    let time: usize = found.pulses.iter().map(|p| p.samples.len()).sum();
    let to_its_side = |p: &ForcePulse| {
        let samples = force[p.samples.clone()].iter().map(|f| f - found.baseline);
        let square = |f: f64| if f * p.height > 0.0 { f * f } else { 0.0 };
        samples.map(square).sum::<f64>()
    };
    let inside: f64 = found.pulses.iter().map(to_its_side).sum();
    !found.pulses.is_empty()
        && !found.pulses.iter().any(|p| is_level(p, force))
        && time as f64 <= MAX_PULSE_DUTY * force.len() as f64
        && inside >= MIN_ENERGY_IN_PULSES * (energy(force) - noise)
}

/// A pulse at an end of the record is a level, held before a release or after a step, where half of its samples lie within a tenth of its
/// height; of half a sine that is cut off at its top they are three in ten.
fn is_level(pulse: &ForcePulse, force: &[f64]) -> bool {
    const MIN_COUNT: usize = 16;
    const NEAR: f64 = 0.1;
    const SHARE: f64 = 0.5;
    let at_end = pulse.samples.start == 0 || pulse.samples.end == force.len();
    let near = |f: &&f64| (**f - force[pulse.peak]).abs() <= NEAR * pulse.height.abs();
    let count = force[pulse.samples.clone()].iter().filter(near).count();
    at_end && count >= MIN_COUNT && count as f64 > SHARE * pulse.samples.len() as f64
}

/// Steps of a force at most: what steps more often, such as a random binary signal, drives all the time.
const MAX_STEPS: usize = 20;

/// Least change of level over a step as a share of the range of the force within it: a filter without phase error overshoots by 9 % before
/// and after; a pulse returns to its level.
const MIN_LEVEL_CHANGE: f64 = 0.5;

/// Pulses of the differences within so many times the longest of them are ripples of one step.
const RIPPLE_DISTANCE: usize = 2;

/// The change of each sample from the one before; 0 of the first.
pub fn differences(samples: &[f64]) -> Vec<f64> {
    let first = samples.iter().take(1).map(|_| 0.0);
    first
        .chain(samples.windows(2).map(|w| w[1] - w[0]))
        .collect()
}

/// Whether a force steps from level to level, as on a release: nearly all the energy of its differences lies in few short pulses, and each
/// leaves the force on another level. Ripples of an anti-aliasing filter before and after it belong to a step.
pub fn is_stepwise(force: &[f64]) -> bool {
    let changes = differences(force);
    let found = pulses_to(&changes, true);
    let energy = |samples: &[f64]| samples.iter().map(|d| d * d).sum::<f64>();
    let noise = changes.len() as f64 * found.noise * found.noise;
    let time: usize = found.pulses.iter().map(|p| p.samples.len()).sum();
    let inside: f64 = (found.pulses.iter())
        .map(|p| energy(&changes[p.samples.clone()]))
        .sum();
    let steps = joined_pulses(&found.pulses);
    (1..=MAX_STEPS).contains(&steps.len())
        && time as f64 <= MAX_PULSE_DUTY * force.len() as f64
        && inside >= MIN_ENERGY_IN_PULSES * (energy(&changes) - noise)
        && (0..steps.len()).all(|k| changes_level(force, &steps, k))
}

/// Pulses of the differences with the ripples that a filter makes before and after them.
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

/// Whether the force stays on another level after the k-th of `steps` than before: medians up to the steps next to it.
fn changes_level(force: &[f64], steps: &[Range<usize>], k: usize) -> bool {
    let own = &steps[k];
    let from = if k == 0 { 0 } else { steps[k - 1].end };
    let to = steps.get(k + 1).map_or(force.len(), |next| next.start);
    let level = |samples: &[f64], edge: f64| match samples {
        [] => edge,
        _ => median(samples),
    };
    let first = own.start.saturating_sub(1);
    let before = level(&force[from..first.max(from)], force[first]);
    let after = level(&force[own.end..to], force[own.end - 1]);
    let ends = (before.min(after), before.max(after));
    let (low, high) =
        (force[own.clone()].iter()).fold(ends, |(low, high), &f| (low.min(f), high.max(f)));
    (after - before).abs() >= MIN_LEVEL_CHANGE * (high - low)
}

/// A run of equal samples at the extreme counts as clipped from this length on.
const MIN_CLIPPED_RUN: usize = 3;

/// Beyond how far a smooth top can fall behind its run.
const CURVATURE_MARGIN: f64 = 1.2;

/// Largest fall of a parabola rounded to steps of 1, at the sample after `run` equal ones on its top: they lie within one step, so that it
/// bends by at most `4/(run − 1)²` a sample squared.
fn expected_fall(run: usize) -> f64 {
    let m = run as f64;
    1.0 + ((m + 1.0) / (m - 1.0)).powi(2)
}

/// With fewer different values than this their distances do not tell the converter's step.
const MIN_DISTINCT_VALUES: usize = 64;

/// The step is then taken to be this share of the range: 8 bits.
const DEFAULT_RESOLUTION: f64 = 1.0 / 256.0;

/// The least distance of different values.
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

/// Whether samples rest on their largest or smallest value as an overloaded amplifier does.
pub fn is_clipped(samples: &[f64]) -> bool {
    let step = OnceCell::new();
    let rests_on = |extreme: f64| {
        let mut at = 0;
        while let Some(start) = (at..samples.len()).find(|&j| samples[j] == extreme) {
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
            at = end;
        }
        false
    };
    let largest = samples.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let smallest = samples.iter().copied().fold(f64::INFINITY, f64::min);
    // What a signal rests on between events is an extreme too, but not a far one.
    let level = median(samples);
    let is_far = |extreme: f64| 2.0 * (extreme - level).abs() >= largest - smallest;
    [largest, smallest]
        .into_iter()
        .any(|extreme| largest > smallest && is_far(extreme) && rests_on(extreme))
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

    /// Hits, also downward and under noise; not a sine, not noise, not a burst of noise, not silence.
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

    /// Steps up and down, and a release soon after the record begins; not hits, and hits no steps.
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
