//! Peaks of a spectrum above a median noise floor, with interpolated frequency and amplitude.
//!
//! The floor is the median over a sliding range of lines, converted to a mean by the median of χ². Three highest lines with the ratios
//! of a tone under the window give its frequency and height; other peaks those of the parabola through the logarithms.

use super::spectra::Spectra;
use super::window::leakage;
use crate::numeric::parabola::log_vertex;
use crate::numeric::sorting::sort_descending;
use crate::numeric::statistics::chi_squared_quantile;

/// Options of the search for spectral peaks.
#[derive(Debug, Clone, PartialEq)]
pub struct PeakOptions {
    /// Half width of the median for the floor, lines; `None`: the larger of 64 and an eighth of the spectrum.
    pub floor_lines: Option<usize>,
    /// Expected number of false peaks per spectrum from noise alone.
    pub false_alarms: f64,
}

impl Default for PeakOptions {
    /// One false peak in a hundred spectra.
    fn default() -> PeakOptions {
        PeakOptions {
            floor_lines: None,
            false_alarms: 0.01,
        }
    }
}

/// Local maximum of a spectrum above the noise floor.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectralPeak {
    /// Line of the local maximum.
    pub line: usize,
    /// Interpolated frequency, Hz.
    pub frequency_hz: f64,
    /// Density at the peak, unit²/Hz.
    pub psd: f64,
    /// Amplitude (0 to peak) of a tone of this peak, in the unit of the channel.
    pub amplitude: f64,
    /// Ratio of the densities of peak and noise floor.
    pub signal_to_noise: f64,
}

/// Least ratio of a peak to the floor for any number of averages; accuracy of a sloping floor.
const MIN_PEAK_RATIO: f64 = 4.0;

/// Least ratio of a peak to the minimum between it and the next higher peak.
const MIN_DIP_RATIO: f64 = 2.0;

/// Probability of a random dip of the estimate that a valley between two peaks exceeds.
const RIPPLE_PROBABILITY: f64 = 1e-3;

/// Half width of a peak, lines. Beyond, up to the next higher value, the lowest median over a distance w to 2w gives the level between
/// peaks: the minimum of many single lines of few averages is low by chance.
const PEAK_GUARD_LINES: usize = 8;

/// Spectral peaks of a channel by descending signal-to-noise ratio.
pub fn find_peaks(spectra: &Spectra, channel: usize, options: &PeakOptions) -> Vec<SpectralPeak> {
    let psd = &spectra.psd[channel];
    let lines = psd.len();
    if lines < 3 {
        return Vec::new();
    }
    let dofs = 2.0 * spectra.averages.unwrap_or(spectra.blocks as f64);
    let multiple = |p: f64| chi_squared_quantile(p, dofs) / dofs;
    let ratio = multiple(1.0 - options.false_alarms / lines as f64).max(MIN_PEAK_RATIO);
    let dip =
        (multiple(1.0 - RIPPLE_PROBABILITY) / multiple(RIPPLE_PROBABILITY)).max(MIN_DIP_RATIO);
    let half = options.floor_lines.unwrap_or((lines / 8).max(64));
    let floor: Vec<f64> = wide_median(psd, half)
        .iter()
        .map(|m| m / multiple(0.5))
        .collect();
    let (left, right) = valleys(psd);
    let half_power = multiple(0.5);
    let median_level = |start: usize, end: usize| {
        let mut between = psd[start..end].to_vec();
        let middle = between.len() / 2;
        *between.select_nth_unstable_by(middle, f64::total_cmp).1 / half_power
    };
    let is_separated = |s: f64, valley: &Valley, range: &dyn Fn(usize) -> (usize, usize)| {
        let widths = std::iter::successors(Some(PEAK_GUARD_LINES), |w| Some(2 * w));
        let mut within = widths.take_while(|w| 2 * w <= valley.lines);
        let is_lower = |w: usize| {
            let (start, end) = range(w);
            s > ratio * median_level(start, end)
        };
        s > dip * valley.lowest || within.any(is_lower)
    };
    let is_peak = |&k: &usize| {
        let s = psd[k];
        s > psd[k - 1]
            && s >= psd[k + 1]
            && s > ratio * floor[k]
            && is_separated(s, &left[k], &|w| (k - 2 * w, k - w))
            && is_separated(s, &right[k], &|w| (k + w, k + 2 * w))
    };
    let spacing = spectra.frequency_hz[1] - spectra.frequency_hz[0];
    let window = spectra
        .window
        .map_or(Vec::new(), |w| w.samples(WINDOW_TABLE_LEN));
    let mut peaks: Vec<SpectralPeak> = (1..lines - 1)
        .filter(is_peak)
        .map(|k| {
            let neighbours = [psd[k - 1], psd[k], psd[k + 1]];
            let (shift, height) = fit_main_lobe(&window, neighbours, floor[k])
                .unwrap_or_else(|| log_vertex(neighbours));
            SpectralPeak {
                line: k,
                frequency_hz: spectra.frequency_hz[k] + shift * spacing,
                psd: height,
                amplitude: (2.0 * height * spectra.bandwidth_hz).sqrt(),
                signal_to_noise: height / floor[k],
            }
        })
        .collect();
    sort_descending(&mut peaks, |a| a.signal_to_noise);
    peaks
}

/// Number of window samples for the shape of its main lobe.
const WINDOW_TABLE_LEN: usize = 256;

/// Frequency of a tone by three lines, in lines from the middle, and its height at its exact frequency; `None` for lines of another
/// shape, with too high a line on the far side, and without a window.
fn fit_main_lobe(
    window: &[f64],
    [before, middle, after]: [f64; 3],
    floor: f64,
) -> Option<(f64, f64)> {
    const MAX_LOBE_RATIO: f64 = 1.5;
    if window.is_empty() {
        return None;
    }
    let above = |s: f64| (s - floor).max(0.0);
    let (near, far) = (above(before.max(after)), above(before.min(after)));
    let ratio = near / above(middle);
    // The ratio of the nearer line to the middle increases from a tone on the middle line to one half-way.
    let share = |d: f64| leakage(window, 1.0 - d) / leakage(window, d);
    if !(ratio <= 1.0 && ratio >= share(0.0)) {
        return None;
    }
    let (mut low, mut high) = (0.0, 0.5);
    for _ in 0..24 {
        let d = 0.5 * (low + high);
        if share(d) < ratio {
            low = d;
        } else {
            high = d;
        }
    }
    let d = 0.5 * (low + high);
    let height = above(middle) / leakage(window, d);
    let expected = leakage(window, 1.0 + d) * height + floor;
    let is_tone = far <= MAX_LOBE_RATIO * expected;
    let side = if after > before { 1.0 } else { -1.0 };
    is_tone.then_some((side * d, height))
}

/// Valley between a line and the next larger line on one side, or the end of the spectrum.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Valley {
    /// Minimum density, unit²/Hz.
    lowest: f64,
    /// Distance to the larger line or to the end, lines.
    lines: usize,
}

/// Valleys on the left and on the right of each line.
fn valleys(psd: &[f64]) -> (Vec<Valley>, Vec<Valley>) {
    let left = valleys_on_one_side(psd.iter());
    let mut right = valleys_on_one_side(psd.iter().rev());
    right.reverse();
    (left, right)
}

fn valleys_on_one_side<'a>(values: impl Iterator<Item = &'a f64>) -> Vec<Valley> {
    // Values not yet exceeded, each with the minimum since the preceding one, and their lines.
    let mut open: Vec<(f64, f64, usize)> = Vec::new();
    values
        .enumerate()
        .map(|(line, &value)| {
            let mut lowest = value;
            while let Some(&(_, low, _)) = open.last().filter(|(height, ..)| *height <= value) {
                lowest = lowest.min(low);
                open.pop();
            }
            let lines = line - open.last().map_or(0, |o| o.2);
            open.push((value, lowest, line));
            Valley { lowest, lines }
        })
        .collect()
}

/// Sliding median over `half` values on either side, fewer at the ends.
pub fn sliding_median(values: &[f64], half: usize) -> Vec<f64> {
    let mut sorted: Vec<f64> = Vec::with_capacity(2 * half + 2);
    let position = |sorted: &[f64], x: f64| sorted.partition_point(|y| y.total_cmp(&x).is_lt());
    let insert = |sorted: &mut Vec<f64>, x: f64| sorted.insert(position(sorted, x), x);
    values
        .iter()
        .take(half)
        .for_each(|&x| insert(&mut sorted, x));
    (0..values.len())
        .map(|k| {
            if let Some(&x) = values.get(k + half) {
                insert(&mut sorted, x);
            }
            if k > half {
                let expired = position(&sorted, values[k - half - 1]);
                sorted.remove(expired);
            }
            let middle = sorted.len() / 2;
            if sorted.len() % 2 == 1 {
                sorted[middle]
            } else {
                0.5 * (sorted[middle - 1] + sorted[middle])
            }
        })
        .collect()
}

/// Sliding median for large `half` from the medians of short blocks, each of an odd number of values.
fn wide_median(values: &[f64], half: usize) -> Vec<f64> {
    const DIRECT_MEDIAN_LEN: usize = 8192;
    if half <= DIRECT_MEDIAN_LEN {
        return sliding_median(values, half);
    }
    let short = half / DIRECT_MEDIAN_LEN * 2 + 1;
    let block_median = |block: &[f64]| {
        let mut block = block.to_vec();
        block.sort_by(f64::total_cmp);
        block[block.len() / 2]
    };
    let medians: Vec<f64> = values.chunks(short).map(block_median).collect();
    let coarse = sliding_median(&medians, half / short);
    (0..values.len()).map(|k| coarse[k / short]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::welch::{WelchEstimator, WelchOptions};
    use std::f64::consts::TAU;

    #[test]
    fn exact_sliding_median() {
        let values = [5.0, 1.0, 4.0, 2.0, 3.0, 9.0];
        assert_eq!(sliding_median(&values, 1), [3.0, 4.0, 2.0, 3.0, 3.0, 6.0]);
        assert_eq!(sliding_median(&values, 0), values);
        assert_eq!(sliding_median(&values, 100), [3.5; 6]);
    }

    /// The floor of a long spectrum from block medians equals that of all lines within the random error.
    #[test]
    fn law_wide_median() {
        let mut rng = fastrand::Rng::with_seed(2);
        let noise: Vec<f64> = (0..200_000).map(|_| -rng.f64().ln()).collect();
        let floor = wide_median(&noise, 25_000);
        assert_eq!(floor.len(), noise.len());
        assert!(floor.iter().all(|m| (m / 2f64.ln() - 1.0).abs() < 0.05));
    }

    #[test]
    fn exact_valleys() {
        let (left, right) = valleys(&[3.0, 1.0, 2.0, 0.5, 4.0, 2.0]);
        let lowest = |side: &[Valley]| side.iter().map(|v| v.lowest).collect::<Vec<_>>();
        assert_eq!(lowest(&left), [3.0, 1.0, 1.0, 0.5, 0.5, 2.0]);
        assert_eq!(lowest(&right), [0.5, 1.0, 0.5, 0.5, 2.0, 2.0]);
        let lines = |side: &[Valley]| side.iter().map(|v| v.lines).collect::<Vec<_>>();
        assert_eq!(lines(&left), [0, 1, 2, 1, 4, 1]);
        assert_eq!(lines(&right), [4, 1, 2, 1, 1, 0]);
    }

    fn spectrum(samples: &[f64]) -> Spectra {
        let options = WelchOptions {
            block: 1024,
            ..WelchOptions::default()
        };
        let mut estimator = WelchEstimator::new(1024.0, 1, &[], &options).unwrap();
        estimator.push(&[samples]);
        estimator.finish().unwrap()
    }

    /// Tones between lines: accurate to 1e-3 of a line and of the amplitude, without false peaks.
    #[test]
    fn law_tones_in_noise() {
        let mut rng = fastrand::Rng::with_seed(7);
        for step in 0..10 {
            let (f1, f2) = (
                100.0 + 0.1 * f64::from(step),
                311.0 - 0.07 * f64::from(step),
            );
            let samples: Vec<f64> = (0..20_000)
                .map(|j| {
                    let t = f64::from(j) / 1024.0;
                    3.0 * (TAU * f1 * t).sin() + 0.5 * (TAU * f2 * t).cos() + 0.01 * rng.f64()
                })
                .collect();
            let found = find_peaks(&spectrum(&samples), 0, &PeakOptions::default());
            assert_eq!(found.len(), 2, "{found:?}");
            for (peak, (f, a)) in found.iter().zip([(f1, 3.0), (f2, 0.5)]) {
                assert!((peak.frequency_hz - f).abs() < 1e-3, "{peak:?} {f}");
                assert!((peak.amplitude / a - 1.0).abs() < 1e-3, "{peak:?}");
            }
        }
    }

    /// A resonance with small ripples, 900 lines from a larger one with a valley of 30 dB, is one peak at any width.
    #[test]
    fn law_wide_peak_of_one_average() {
        let resonance = |k: f64, at: f64| 1.0 / (1.0 + ((k - at) / 5.0).powi(2));
        let mut rng = fastrand::Rng::with_seed(4);
        let psd: Vec<f64> = (0..8000)
            .map(|k| {
                let k = f64::from(k);
                let smooth = 1e4 * resonance(k, 3000.0) + 1e2 * resonance(k, 3900.0) + 1e-2;
                smooth * (0.95 + 0.1 * rng.f64())
            })
            .collect();
        let spectra = Spectra {
            frequency_hz: (0..psd.len()).map(|k| k as f64).collect(),
            psd: vec![psd],
            blocks: 1,
            bandwidth_hz: 1.0,
            ..Spectra::default()
        };
        let found = find_peaks(&spectra, 0, &PeakOptions::default());
        let near = |f: f64| {
            found
                .iter()
                .filter(|p| (p.frequency_hz - f).abs() < 2.0)
                .count()
        };
        assert_eq!(
            (found.len(), near(3000.0), near(3900.0)),
            (2, 1, 1),
            "{found:?}"
        );
    }

    /// A tone 20 dB above the noise of a single transform and far below another: both are detected, without false peaks.
    #[test]
    fn law_weak_tone_of_one_average() {
        let mut found = Vec::new();
        for seed in 0..20 {
            let mut rng = fastrand::Rng::with_seed(seed);
            let mut psd: Vec<f64> = (0..20_000).map(|_| -rng.f64().ln()).collect();
            psd[3000] = 1e6;
            psd[9000] = 100.0;
            let spectra = Spectra {
                frequency_hz: (0..psd.len()).map(|k| k as f64).collect(),
                psd: vec![psd],
                blocks: 1,
                bandwidth_hz: 1.0,
                ..Spectra::default()
            };
            let lines = find_peaks(&spectra, 0, &PeakOptions::default());
            found.push(lines.iter().map(|p| p.line).collect::<Vec<_>>());
        }
        let wrong = found.iter().filter(|f| **f != [3000, 9000]).count();
        assert!(wrong <= 2, "{found:?}");
    }

    /// Noise alone shows no peak in 50 spectra, each allowed 0.01.
    #[test]
    fn law_noise_has_no_peaks() {
        let mut rng = fastrand::Rng::with_seed(3);
        let found: usize = (0..50)
            .map(|_| {
                let samples: Vec<f64> = (0..8192).map(|_| rng.f64() - 0.5).collect();
                find_peaks(&spectrum(&samples), 0, &PeakOptions::default()).len()
            })
            .sum();
        assert!(found <= 3, "{found}");
    }
}
