//! Detection of clipped samples: flat tops of slow signals, excess counts at the limits of fast ones.

/// Minimum number of equal samples of a flat top.
const MIN_FLAT_SAMPLES: usize = 3;

/// Minimum jump into a clipped flat top, in resolution steps of the signal.
const MIN_JUMP_STEPS: f64 = 4.0;

/// Maximum number of histogram bins between the extremes.
const MAX_BINS: f64 = 100.0;

/// Minimum width of a bin, resolution steps. At the crest of a smooth wave the last step has at most half the samples of the eight
/// steps below it: `√q` of `√(9q) − √q`; at a flat crest, `1 − x⁴`, 1.4 times as many.
const MIN_STEPS_PER_BIN: f64 = 8.0;

/// Number of bins below an extreme, and the minimum of them that are filled: a synchronously sampled signal repeats a few values, the
/// highest as often as the others.
const NEIGHBOUR_BINS: usize = 10;
const MIN_FILLED_BINS: usize = 5;

/// Number of bins next to the extreme that give the expected count there.
const ADJACENT_BINS: usize = 2;

/// Minimum ratio of the count at a clipped extreme to the largest adjacent count, minimum number of visits, and minimum count in the
/// bins below.
const MIN_EXCESS_RATIO: f64 = 3.0;
const MIN_VISITS: usize = 8;
const MIN_SAMPLES_BELOW: usize = 10;

/// Maximum share of samples on one extreme (above: a state of rest) and on both (above: a two-level signal).
const MAX_IDLE_SHARE: f64 = 0.4;
const TWO_LEVEL_SHARE: f64 = 0.7;

/// Histogram of a channel with the counts at its extremes.
pub struct ClippingDetector {
    range: (f64, f64),
    resolution: f64,
    /// Number of samples.
    count: usize,
    /// Low and high extreme.
    limits: [LimitLevel; 2],
    /// Counts in equal bins from low to high.
    bins: Vec<usize>,
    last: f64,
}

#[derive(Default, Clone, Copy)]
struct LimitLevel {
    samples: usize,
    visits: usize,
    /// Visits of at least [`MIN_FLAT_SAMPLES`] samples after a jump.
    flat_tops: usize,
    /// Length of the current visit, samples, and the jump into it.
    run: (usize, f64),
}

impl ClippingDetector {
    /// Detector for a channel with its range and resolution.
    pub fn new(range: (f64, f64), resolution: f64) -> ClippingDetector {
        let width = range.1 - range.0;
        let n_bins = (width / (MIN_STEPS_PER_BIN * resolution))
            .min(MAX_BINS)
            .floor();
        ClippingDetector {
            range,
            resolution,
            count: 0,
            limits: [LimitLevel::default(); 2],
            bins: vec![0; n_bins as usize],
            last: f64::NAN,
        }
    }

    /// Adds the next samples.
    pub fn push(&mut self, samples: &[f64]) {
        let (low, high) = self.range;
        let n_bins = self.bins.len();
        let per_unit = n_bins as f64 / (high - low);
        for &x in samples {
            self.count += 1;
            for (extreme, level) in self.limits.iter_mut().zip([low, high]) {
                if x != level {
                    extreme.run = (0, 0.0);
                    continue;
                }
                if extreme.run.0 == 0 {
                    extreme.run.1 = (x - self.last).abs();
                    extreme.visits += 1;
                }
                extreme.run.0 += 1;
                extreme.samples += 1;
                extreme.flat_tops += usize::from(
                    extreme.run.0 == MIN_FLAT_SAMPLES
                        && extreme.run.1 > MIN_JUMP_STEPS * self.resolution,
                );
            }
            if n_bins > 0 && x > low && x < high {
                self.bins[(((x - low) * per_unit) as usize).min(n_bins - 1)] += 1;
            }
            self.last = x;
        }
    }

    /// True if the count at an extreme exceeds the trend of the bins next to it, in order from the extreme.
    fn is_excess(&self, extreme: &LimitLevel, bins: &mut dyn Iterator<Item = &usize>) -> bool {
        let below: Vec<usize> = bins.take(NEIGHBOUR_BINS).copied().collect();
        let filled = below.iter().filter(|&&n| n > 0).count();
        let fullest = below.iter().take(ADJACENT_BINS).copied().max().unwrap_or(0) as f64;
        extreme.visits >= MIN_VISITS
            && below.iter().sum::<usize>() >= MIN_SAMPLES_BELOW
            && filled >= MIN_FILLED_BINS
            && extreme.samples as f64 > MIN_EXCESS_RATIO * fullest
    }
}

/// Number of clipped peaks at both extremes, and the level with more of them; `None` without clipping.
pub fn clipped_tops(detector: &ClippingDetector) -> Option<(usize, f64)> {
    let sides = clipping_by_side(detector);
    let count: usize = sides.iter().flatten().map(|side| side.0).sum();
    let fullest = sides
        .into_iter()
        .flatten()
        .reduce(|a, b| if a.0 > b.0 { a } else { b });
    fullest.map(|(_, level)| (count, level))
}

/// Number of clipped peaks and level at the low and at the high extreme.
pub fn clipping_by_side(counts: &ClippingDetector) -> [Option<(usize, f64)>; 2] {
    let [low, high] = &counts.limits;
    let share = |extreme: &LimitLevel| extreme.samples as f64 / counts.count.max(1) as f64;
    if share(low) + share(high) > TWO_LEVEL_SHARE {
        return [None, None];
    }
    let tops = |extreme: &LimitLevel, bins: &mut dyn Iterator<Item = &usize>| match () {
        () if share(extreme) > MAX_IDLE_SHARE => 0,
        () if counts.is_excess(extreme, bins) => extreme.visits,
        () => extreme.flat_tops,
    };
    let low = (tops(low, &mut counts.bins.iter()), counts.range.0);
    let high = (tops(high, &mut counts.bins.iter().rev()), counts.range.1);
    [low, high].map(|side| Some(side).filter(|s| s.0 > 0))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Clipping of samples written to a resolution.
    fn clipping_with_resolution(
        samples: impl Iterator<Item = f64>,
        resolution: f64,
    ) -> Option<(usize, f64)> {
        let written: Vec<f64> = samples.map(|x| (x / resolution).round()).collect();
        let low = written.iter().copied().fold(f64::INFINITY, f64::min);
        let high = written.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut extremes = ClippingDetector::new((low, high), 1.0);
        extremes.push(&written);
        clipped_tops(&extremes).map(|(count, level)| (count, level * resolution))
    }

    fn sine(count: usize, per_period: f64) -> impl Iterator<Item = f64> {
        (0..count).map(move |k| (std::f64::consts::TAU * k as f64 / per_period + 0.3).sin())
    }

    fn noise(count: usize) -> impl Iterator<Item = f64> {
        let mut random = fastrand::Rng::with_seed(11);
        // The sum of twelve uniform numbers is nearly normal with variance 1.
        (0..count).map(move |_| (0..12).map(|_| random.f64()).sum::<f64>() - 6.0)
    }

    /// A slow sine cut at ±0.8 is clipped at every half wave; an uncut one and one in coarse steps are not.
    #[test]
    fn exact_slow() {
        let slow = || (0..314).map(|k| (0.2 * f64::from(k)).sin());
        let cut = clipping_with_resolution(slow().map(|x| x.clamp(-0.8, 0.8)), 1e-6);
        assert!(cut.is_some_and(|c| c.0 == 20 && (c.1 - 0.8).abs() < 1e-12));
        assert_eq!(clipping_with_resolution(slow(), 1e-6), None);
        let coarse = (0..3140).map(|k| (0.002 * f64::from(k)).sin());
        assert_eq!(clipping_with_resolution(coarse, 0.02), None);
    }

    /// Eight samples a period, one or two of them on the limit at a time: clipped by the excess count, at both limits alike.
    #[test]
    fn exact_fast() {
        for (gain, bits) in [(1.1, 1e-3), (1.25, 1e-6), (2.0, 1.0 / 128.0)] {
            let cut = sine(4000, 8.13).map(|x| (gain * x).clamp(-1.0, 1.0));
            let clipped = clipping_with_resolution(cut, bits).unwrap();
            assert!((900..=986).contains(&clipped.0), "gain {gain}: {clipped:?}");
            assert_eq!(clipped.1.abs(), 1.0);
        }
        // Noise cut at two deviations on one side: one sample in fifty.
        let clipped = clipping_with_resolution(noise(100_000).map(|x| x.min(2.0)), 1e-3).unwrap();
        assert!(
            (1900..2500).contains(&clipped.0) && clipped.1 == 2.0,
            "{clipped:?}"
        );
    }

    /// Signals that stay on their extremes, or repeat them, without having been clipped.
    #[test]
    fn exact_unclipped() {
        for per_period in [8.0, 16.0, 50.0, 8.001, 8.13, 4.0, 3.0, 40.3] {
            for resolution in [1e-9, 1e-4, 0.01, 0.03, 0.3, 0.7] {
                let clipped = clipping_with_resolution(sine(16_000, per_period), resolution);
                assert_eq!(
                    clipped, None,
                    "{per_period} a period in steps of {resolution}"
                );
            }
        }
        for resolution in [1e-9, 0.01, 0.1, 0.5, 2.0] {
            assert_eq!(
                clipping_with_resolution(noise(50_000), resolution),
                None,
                "noise in {resolution}"
            );
        }
        let square = |edge: f64| sine(8000, 37.3).map(move |x| (x * edge).clamp(-1.0, 1.0));
        // Two states with edges of some samples; a pulse train that rests on one level.
        assert_eq!(clipping_with_resolution(square(8.0), 1e-4), None);
        assert_eq!(clipping_with_resolution(square(1e9), 1e-4), None);
        let pulses = sine(8000, 41.7).map(|x| ((x - 0.9) * 30.0).clamp(0.0, 5.0));
        assert_eq!(clipping_with_resolution(pulses, 1e-3), None);
        // A flat-topped wave, and a speed that rests at both ends of its ramp.
        let flat = sine(20_000, 23.17).map(|x| x + (3.0 * x.asin()).sin() / 9.0);
        assert_eq!(clipping_with_resolution(flat, 1e-4), None);
        let ramp = (0..4000).map(|k| (0.001 * (f64::from(k) - 1000.0)).clamp(0.0, 1.0));
        assert_eq!(clipping_with_resolution(ramp, 1e-3), None);
    }
}
