//! Distribution of the peak-to-peak error over unknown phases and amplitudes.
//!
//! Read at even steps h, then refined by Newton at every crest that could be the highest: between two samples e stands above the nearer
//! one by no more than `h² Σ A (2π o)²/8`. Phases are uniform, amplitudes uniform within their tolerance, by lattice points; percentiles
//! carry the standard error that shifted lattices show.

use std::f64::consts::TAU;

use crate::numeric::Complex;
use crate::numeric::lattice::RankOneLattice;
use crate::numeric::sorting::sort_rising;

/// One harmonic at the output.
#[derive(Debug, Clone, Copy)]
pub struct HarmonicTerm {
    /// Which source it belongs to.
    pub source: usize,
    /// Cycles per turn of the output.
    pub order: f64,
    /// Cycles per turn of its source.
    pub harmonic: u32,
    /// A and ψ, rad.
    pub value: Complex,
}

/// An error source with its known parameters.
#[derive(Debug, Clone, Copy)]
pub struct ErrorSource {
    /// The element it belongs to.
    pub element: usize,
    /// True where the phase of the source is known.
    pub phase_known: bool,
    /// Half the width of what its amplitude may be, relative to it.
    pub tolerance: f64,
    /// It has a grade that could be better; what a mesh gives way has none.
    pub graded: bool,
}

/// A distribution by its percentiles.
#[derive(Debug, Clone)]
pub struct RangeDistribution {
    /// Turns of the output.
    pub window: f64,
    /// Sampled so often; once where nothing is unknown.
    pub samples: usize,
    /// Lines too fine for the samples of the window or too small: their ranges are added whole, rad.
    pub bound_added: f64,
    /// Per cent, value in rad, standard error.
    pub percentiles: Vec<(u32, f64, f64)>,
}

/// Percentiles reported.
const PERCENTILES: [u32; 3] = [5, 50, 95];

/// Shifts of the lattice.
const LATTICE_SHIFTS: usize = 8;

/// Steps of the fastest line's cycle, where they suffice the window.
const PER_CYCLE: f64 = 16.0;

/// Fewest steps of a cycle that are refined to its crest; faster lines are added whole.
const MIN_PER_CYCLE: f64 = 8.0;

/// Steps of a window times lines, for each point of the lattice: as many as some tenths of a second take.
const MAX_WORK: usize = 1 << 17;

/// The most steps of a window for each point of the lattice where lines are many and where they are few, and where nothing is unknown, so
/// that one point is all.
const STEPS: (usize, usize, usize) = (1 << 11, 1 << 14, 1 << 17);

/// Lines that together make less than this of the worst case are added whole, where something is unknown.
const SMALL_LINES: f64 = 1e-4;

/// Newton's steps to a crest: from a sixteenth of a cycle each makes the error its cube.
const NEWTON_STEPS: usize = 4;

/// The distribution of the range of `terms` over `window` turns; a lattice of `points` points is shifted eight times.
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
    sort_rising(&mut order, |a| a.value.norm());
    let (mut kept, mut added, mut sum) = (Vec::new(), 0.0, 0.0);
    for term in order {
        sum += size(term);
        if sum <= small || MIN_PER_CYCLE * term.order * window > steps as f64 {
            added += 2.0 * size(term);
        } else {
            kept.push(*term);
        }
    }
    let fastest = kept.iter().fold(0.0f64, |m, t| m.max(t.order * window));
    let count = ((PER_CYCLE * fastest).ceil() as usize).clamp(64, steps);
    let told = |samples, of: &dyn Fn(u32) -> (f64, f64)| RangeDistribution {
        window,
        samples,
        bound_added: added,
        percentiles: (PERCENTILES.iter())
            .map(|&p| (p, of(p).0, of(p).1))
            .collect(),
    };
    let wave = |term: &HarmonicTerm, i: usize| {
        Complex::cis(TAU * (term.order * window * i as f64 / count as f64).fract())
    };
    if !kept.iter().any(is_open) && small == 0.0 {
        let waves: Vec<(f64, Complex)> = kept.iter().map(|t| (t.order, t.value)).collect();
        let at = |i: usize| kept.iter().map(|t| (t.value * wave(t, i)).re).sum();
        let samples: Vec<f64> = (0..=count).map(at).collect();
        let range = peak_to_peak(&samples, window, &waves) + added;
        return told(1, &|_| (range, 0.0));
    }
    // Cosine and sine of every line over the window, once.
    let tables: Vec<Vec<Complex>> = (kept.iter())
        .map(|t| (0..=count).map(|i| wave(t, i)).collect())
        .collect();
    let lattice = RankOneLattice::new(2 * sources.len(), points, LATTICE_SHIFTS);
    let mut samples = vec![0.0; count + 1];
    let mut waves: Vec<(f64, Complex)> = Vec::with_capacity(kept.len());
    let mut shifted: Vec<Vec<f64>> = Vec::with_capacity(LATTICE_SHIFTS);
    for shift in 0..lattice.shifts() {
        let mut found: Vec<f64> = (0..lattice.points())
            .map(|i| {
                let u = lattice.point(shift, i);
                samples.fill(0.0);
                waves.clear();
                for (term, table) in kept.iter().zip(&tables) {
                    let known = source(term);
                    let turned = match known.phase_known {
                        true => 0.0,
                        false => TAU * u[2 * term.source] * f64::from(term.harmonic),
                    };
                    let factor = 1.0 + known.tolerance * (2.0 * u[2 * term.source + 1] - 1.0);
                    let z = term.value * Complex::cis(turned) * factor;
                    let both = samples.iter_mut().zip(table);
                    both.for_each(|(e, w)| *e += z.re * w.re - z.im * w.im);
                    waves.push((term.order, z));
                }
                peak_to_peak(&samples, window, &waves) + added
            })
            .collect();
        found.sort_by(f64::total_cmp);
        shifted.push(found);
    }
    let percentile = |p: u32| {
        let each: Vec<f64> = shifted
            .iter()
            .map(|found| quantile(found, f64::from(p) / 100.0))
            .collect();
        let n = each.len() as f64;
        let mean = each.iter().sum::<f64>() / n;
        let variance = each.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
        (mean, (variance / n).sqrt())
    };
    told(lattice.points() * lattice.shifts(), &percentile)
}

/// Greatest less least of waves, order and A e^{iψ}, over a window from 0 on, from samples at even steps with both ends.
fn peak_to_peak(samples: &[f64], window: f64, waves: &[(f64, Complex)]) -> f64 {
    let step = window / (samples.len() - 1) as f64;
    let bend: f64 = waves
        .iter()
        .map(|(o, z)| z.norm() * (TAU * o).powi(2))
        .sum();
    let missed = bend * step * step / 8.0;
    // e, e′ and e″.
    let at = |x: f64| {
        let one = |sums: [f64; 3], &(order, z): &(f64, Complex)| {
            let (z, k) = (z * Complex::cis(TAU * (order * x).fract()), TAU * order);
            [sums[0] + z.re, sums[1] - k * z.im, sums[2] - k * k * z.re]
        };
        waves.iter().fold([0.0; 3], one)
    };
    let top = |sign: f64| {
        let best = samples
            .iter()
            .fold(f64::NEG_INFINITY, |m, s| m.max(sign * s));
        let crest = |i: usize| {
            let side = |j: Option<&f64>| j.map_or(f64::NEG_INFINITY, |s| sign * s);
            let here = sign * samples[i];
            let before = i.checked_sub(1).and_then(|j| samples.get(j));
            here >= best - missed && here >= side(before) && here >= side(samples.get(i + 1))
        };
        let refined = |i: usize| {
            let middle = i as f64 * step;
            let (low, high) = ((middle - step).max(0.0), (middle + step).min(window));
            let mut x = middle;
            for _ in 0..NEWTON_STEPS {
                let [_, slope, bend] = at(x);
                if sign * bend >= 0.0 {
                    break;
                }
                x = (x - slope / bend).clamp(low, high);
            }
            sign * at(x)[0]
        };
        let crests = (0..samples.len()).filter(|&i| crest(i));
        crests.map(refined).fold(best, f64::max)
    };
    top(1.0) + top(-1.0)
}

/// The value below which a share of sorted values lies, between neighbours in proportion.
fn quantile(sorted: &[f64], share: f64) -> f64 {
    let at = share * (sorted.len() - 1) as f64;
    let (low, part) = (at.floor() as usize, at.fract());
    let next = sorted[(low + 1).min(sorted.len() - 1)];
    sorted[low] + part * (next - sorted[low])
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

    /// Known lines have one range, to rounding, wherever their crests lie: of one line 2A, of three the range by brute force at a million
    /// steps, over part of a cycle what the ends allow.
    #[test]
    fn exact_range_of_known_lines() {
        let one = from_samples(&[(1.0, 109.76, 37.0)], &[KNOWN], 1.0);
        assert_eq!(one.samples, 1);
        for (_, value, error) in &one.percentiles {
            assert!((value - 219.52).abs() < 1e-10 && *error == 0.0, "{value}");
        }
        let lines = [
            (3.0, 12.91, 0.0),
            (9.0, 4.304, 160.0),
            (64.0 / 21.0, 5.0, 20.0),
        ];
        for (lines, window) in [(&lines[..2], 1.0), (&lines[..], 7.0), (&lines[2..], 0.1)] {
            let found = from_samples(lines, &[KNOWN; 3], window).percentiles[1].1;
            let at = |i: u32| {
                let x = window * f64::from(i) / 1e6;
                let wave = |&(o, a, d): &(f64, f64, f64)| a * (TAU * o * x + d.to_radians()).cos();
                lines.iter().map(wave).sum::<f64>()
            };
            let ends = (0..=1_000_000).map(at);
            let (low, high) = ends.fold((f64::MAX, f64::MIN), |(l, h), e| (l.min(e), h.max(e)));
            assert!(
                (found - (high - low)).abs() < 1e-6 && found >= high - low - 1e-12,
                "{found} {}",
                high - low
            );
        }
    }

    /// A single line whose phase alone is unknown has the range 2A over whole turns, whatever the phase.
    #[test]
    fn exact_range_of_an_unknown_phase() {
        let open = ErrorSource {
            phase_known: false,
            ..KNOWN
        };
        for (_, value, error) in from_samples(&[(7.0, 3.0, 0.0)], &[open], 1.0).percentiles {
            assert!((value - 6.0).abs() < 1e-9 && error < 1e-9, "{value}");
        }
    }
}
