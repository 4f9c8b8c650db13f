//! Distribution of the peak-to-peak transmission error over unknown phases and amplitudes.
//!
//! Samples at equal steps h are refined by Newton at every possible global extreme: between two samples e exceeds the nearer
//! sample by at most `h² Σ A (2π o)²/8`. Phases are uniform, amplitudes uniform within their tolerance, by lattice points; percentiles
//! have a standard error from shifted lattices.

use std::f64::consts::TAU;

use crate::numeric::Complex;
use crate::numeric::lattice::RankOneLattice;
use crate::numeric::sorting::sort_ascending;

/// Harmonic of the transmission error at the output.
#[derive(Debug, Clone, Copy)]
pub struct HarmonicTerm {
    /// Index of the error source.
    pub source: usize,
    /// Order: cycles per revolution of the output.
    pub order: f64,
    /// Harmonic number: cycles per revolution of the source.
    pub harmonic: u32,
    /// Complex amplitude A e^{iψ}, rad.
    pub value: Complex,
}

/// Error source with known parameters and tolerance.
#[derive(Debug, Clone, Copy)]
pub struct ErrorSource {
    /// Element index.
    pub element: usize,
    /// True for a known phase.
    pub phase_known: bool,
    /// Relative tolerance ± of the amplitude.
    pub tolerance: f64,
    /// True for an error with a tolerance grade; mesh deflection has none.
    pub graded: bool,
}

/// Distribution of the peak-to-peak error, as percentiles.
#[derive(Debug, Clone)]
pub struct RangeDistribution {
    /// Window length, revolutions of the output.
    pub window: f64,
    /// Number of samples; 1 without unknown parameters.
    pub samples: usize,
    /// Sum of the peak-to-peak values of excluded terms, too fast for the sampling or too small, rad.
    pub bound_added: f64,
    /// Per cent, value, rad, standard error, rad.
    pub percentiles: Vec<(u32, f64, f64)>,
}

/// Percentiles reported.
const PERCENTILES: [u32; 3] = [5, 50, 95];

/// Shifts of the lattice.
const LATTICE_SHIFTS: usize = 8;

/// Samples per cycle of the fastest term.
const PER_CYCLE: f64 = 16.0;

/// Smallest number of samples per cycle for a refined term; faster terms enter as peak-to-peak sums.
const MIN_PER_CYCLE: f64 = 8.0;

/// Largest product of samples and terms per lattice point, for a run of some tenths of a second.
const MAX_WORK: usize = 1 << 17;

/// Largest number of samples of a window per lattice point for many terms, for few terms, and for a single point without unknown
/// parameters.
const STEPS: (usize, usize, usize) = (1 << 11, 1 << 14, 1 << 17);

/// Share of the worst case below which small terms enter as peak-to-peak sums, with unknown parameters.
const SMALL_LINES: f64 = 1e-4;

/// Number of Newton steps to an extreme: from a sixteenth of a cycle convergence is cubic.
const NEWTON_STEPS: usize = 4;

/// Distribution of the peak-to-peak value of `terms` over `window` revolutions, by eight shifts of a lattice of `points` points.
pub fn range_distribution(
    terms: &[HarmonicTerm],
    sources: &[ErrorSource],
    window: f64,
    points: usize,
) -> RangeDistribution {
    let source = |t: &HarmonicTerm| sources[t.source];
    let size = |t: &HarmonicTerm| t.value.norm() * (1.0 + source(t).tolerance);
    let worst: f64 = terms.iter().map(size).sum();
    let is_open = |t: &HarmonicTerm| !source(t).phase_known || source(t).tolerance > 0.0;
    let (small, steps) = match terms.iter().any(is_open) {
        true => {
            let steps = (MAX_WORK / terms.len().max(1)).clamp(STEPS.0, STEPS.1);
            (SMALL_LINES * worst, steps)
        }
        false => (0.0, STEPS.2),
    };
    let mut order: Vec<&HarmonicTerm> = terms.iter().collect();
    sort_ascending(&mut order, |a| a.value.norm());
    let (mut resolved, mut bound, mut sum) = (Vec::new(), 0.0, 0.0);
    for term in order {
        sum += size(term);
        if sum <= small || MIN_PER_CYCLE * term.order * window > steps as f64 {
            bound += 2.0 * size(term);
        } else {
            resolved.push(*term);
        }
    }
    let fastest = resolved.iter().fold(0.0f64, |m, t| m.max(t.order * window));
    let count = ((PER_CYCLE * fastest).ceil() as usize).clamp(64, steps);
    let result = |samples, percentile: &dyn Fn(u32) -> (f64, f64)| RangeDistribution {
        window,
        samples,
        bound_added: bound,
        percentiles: (PERCENTILES.iter())
            .map(|&p| (p, percentile(p).0, percentile(p).1))
            .collect(),
    };
    let wave = |term: &HarmonicTerm, i: usize| {
        Complex::cis(TAU * (term.order * window * i as f64 / count as f64).fract())
    };
    if !resolved.iter().any(is_open) && small == 0.0 {
        let waves: Vec<(f64, Complex)> = resolved.iter().map(|t| (t.order, t.value)).collect();
        let sum_at = |i: usize| resolved.iter().map(|t| (t.value * wave(t, i)).re).sum();
        let samples: Vec<f64> = (0..=count).map(sum_at).collect();
        let range = peak_to_peak(&samples, window, &waves) + bound;
        return result(1, &|_| (range, 0.0));
    }
    // Cosine and sine of every term over the window.
    let tables: Vec<Vec<Complex>> = (resolved.iter())
        .map(|t| (0..=count).map(|i| wave(t, i)).collect())
        .collect();
    let lattice = RankOneLattice::new(2 * sources.len(), points, LATTICE_SHIFTS);
    let mut samples = vec![0.0; count + 1];
    let mut waves: Vec<(f64, Complex)> = Vec::with_capacity(resolved.len());
    let mut shifted: Vec<Vec<f64>> = Vec::with_capacity(LATTICE_SHIFTS);
    for shift in 0..lattice.shifts() {
        let mut ranges: Vec<f64> = (0..lattice.points())
            .map(|i| {
                let u = lattice.point(shift, i);
                samples.fill(0.0);
                waves.clear();
                for (term, table) in resolved.iter().zip(&tables) {
                    let error = source(term);
                    let phase = match error.phase_known {
                        true => 0.0,
                        false => TAU * u[2 * term.source] * f64::from(term.harmonic),
                    };
                    let factor = 1.0 + error.tolerance * (2.0 * u[2 * term.source + 1] - 1.0);
                    let z = term.value * Complex::cis(phase) * factor;
                    let pairs = samples.iter_mut().zip(table);
                    pairs.for_each(|(e, w)| *e += z.re * w.re - z.im * w.im);
                    waves.push((term.order, z));
                }
                peak_to_peak(&samples, window, &waves) + bound
            })
            .collect();
        ranges.sort_by(f64::total_cmp);
        shifted.push(ranges);
    }
    let percentile = |p: u32| {
        let values: Vec<f64> = shifted
            .iter()
            .map(|ranges| quantile(ranges, f64::from(p) / 100.0))
            .collect();
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let variance = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, (variance / n).sqrt())
    };
    result(lattice.points() * lattice.shifts(), &percentile)
}

/// Peak-to-peak value of harmonics, order and A e^{iψ}, over a window from 0 on, from samples at equal steps including both ends.
fn peak_to_peak(samples: &[f64], window: f64, waves: &[(f64, Complex)]) -> f64 {
    let step = window / (samples.len() - 1) as f64;
    let curvature: f64 = waves
        .iter()
        .map(|(o, z)| z.norm() * (TAU * o).powi(2))
        .sum();
    let bound = curvature * step * step / 8.0;
    // e, e′ and e″.
    let derivatives = |x: f64| {
        let add = |sums: [f64; 3], &(order, z): &(f64, Complex)| {
            let (z, k) = (z * Complex::cis(TAU * (order * x).fract()), TAU * order);
            [sums[0] + z.re, sums[1] - k * z.im, sums[2] - k * k * z.re]
        };
        waves.iter().fold([0.0; 3], add)
    };
    let maximum = |sign: f64| {
        let best = samples
            .iter()
            .fold(f64::NEG_INFINITY, |m, s| m.max(sign * s));
        let is_candidate = |i: usize| {
            let value = |j: Option<&f64>| j.map_or(f64::NEG_INFINITY, |s| sign * s);
            let sample = sign * samples[i];
            let before = i.checked_sub(1).and_then(|j| samples.get(j));
            sample >= best - bound && sample >= value(before) && sample >= value(samples.get(i + 1))
        };
        let refined = |i: usize| {
            let middle = i as f64 * step;
            let (low, high) = ((middle - step).max(0.0), (middle + step).min(window));
            let mut x = middle;
            for _ in 0..NEWTON_STEPS {
                let [_, slope, curvature] = derivatives(x);
                if sign * curvature >= 0.0 {
                    break;
                }
                x = (x - slope / curvature).clamp(low, high);
            }
            sign * derivatives(x)[0]
        };
        let candidates = (0..samples.len()).filter(|&i| is_candidate(i));
        candidates.map(refined).fold(best, f64::max)
    };
    maximum(1.0) + maximum(-1.0)
}

/// Quantile of sorted values, with linear interpolation.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let index = share * (sorted.len() - 1) as f64;
    let (low, fraction) = (index.floor() as usize, index.fract());
    let next = sorted[(low + 1).min(sorted.len() - 1)];
    sorted[low] + fraction * (next - sorted[low])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from_samples(
        lines: &[(f64, f64, f64)],
        sources: &[ErrorSource],
        window: f64,
    ) -> RangeDistribution {
        let term = |(k, &(order, a, degrees)): (usize, &(f64, f64, f64))| HarmonicTerm {
            source: k,
            order,
            harmonic: 1,
            value: Complex::from_polar(a, f64::to_radians(degrees)),
        };
        let terms: Vec<HarmonicTerm> = lines.iter().enumerate().map(term).collect();
        range_distribution(&terms, sources, window, 61)
    }

    const KNOWN: ErrorSource = ErrorSource {
        element: 0,
        phase_known: true,
        tolerance: 0.0,
        graded: true,
    };

    /// Known terms have one range, to rounding, for any position of the extremes: 2A for one term, the range of a million samples
    /// for three terms, the range between the ends for a fraction of a cycle.
    #[test]
    fn exact_range_of_known_lines() {
        let single = from_samples(&[(1.0, 109.76, 37.0)], &[KNOWN], 1.0);
        assert_eq!(single.samples, 1);
        for (_, value, error) in &single.percentiles {
            assert!((value - 219.52).abs() < 1e-10 && *error == 0.0, "{value}");
        }
        let lines = [
            (3.0, 12.91, 0.0),
            (9.0, 4.304, 160.0),
            (64.0 / 21.0, 5.0, 20.0),
        ];
        for (lines, window) in [(&lines[..2], 1.0), (&lines[..], 7.0), (&lines[2..], 0.1)] {
            let range = from_samples(lines, &[KNOWN; 3], window).percentiles[1].1;
            let sum_at = |i: u32| {
                let x = window * f64::from(i) / 1e6;
                let wave = |&(o, a, d): &(f64, f64, f64)| a * (TAU * o * x + d.to_radians()).cos();
                lines.iter().map(wave).sum::<f64>()
            };
            let samples = (0..=1_000_000).map(sum_at);
            let (low, high) = samples.fold((f64::MAX, f64::MIN), |(l, h), e| (l.min(e), h.max(e)));
            assert!(
                (range - (high - low)).abs() < 1e-6 && range >= high - low - 1e-12,
                "{range} {}",
                high - low
            );
        }
    }

    /// A single term of unknown phase has the range 2A over full revolutions.
    #[test]
    fn exact_range_of_an_unknown_phase() {
        let unknown = ErrorSource {
            phase_known: false,
            ..KNOWN
        };
        for (_, value, error) in from_samples(&[(7.0, 3.0, 0.0)], &[unknown], 1.0).percentiles {
            assert!((value - 6.0).abs() < 1e-9 && error < 1e-9, "{value}");
        }
    }
}
