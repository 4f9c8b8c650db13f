//! The budget of a chain: how far it can err, how far it is likely to, and what a better element buys.
//!
//! Sources are independent; the harmonics of one source share its unknown phase: turned by θ, the one of n cycles moves on by nθ.
//! Worst case `Σ A (1 + t)`, all crests together; root of sum of squares `√Σ A²`. The range over a window, F_i′, is distributed over
//! unknown phases, uniform, and amplitudes, uniform within their tolerance t, by lattice points; percentiles carry the standard error
//! that shifted lattices show.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use crate::numeric::Complex;
use crate::numeric::lattice::Lattice;

/// One harmonic at the output.
#[derive(Debug, Clone, Copy)]
pub struct Term {
    /// Which source it belongs to.
    pub source: usize,
    /// Cycles per turn of the output.
    pub order: f64,
    /// Cycles per turn of its source.
    pub harmonic: u32,
    /// A and ψ, rad.
    pub value: Complex,
}

/// What is known of a source.
#[derive(Debug, Clone, Copy)]
pub struct Source {
    /// The element it belongs to.
    pub element: usize,
    /// Its phase is known.
    pub phase_known: bool,
    /// Half the width of what its amplitude may be, relative to it.
    pub tolerance: f64,
}

/// Sums over all sources.
#[derive(Debug, Clone)]
pub struct Budget {
    /// Every crest at once, at the end of every tolerance, rad zero to peak.
    pub worst_case: f64,
    /// rad zero to peak.
    pub rss: f64,
    /// The range over the window.
    pub range: Distribution,
    /// What each element counts for.
    pub elements: Vec<Sensitivity>,
}

/// A distribution by its percentiles.
#[derive(Debug, Clone)]
pub struct Distribution {
    /// Turns of the output.
    pub window: f64,
    /// Sampled so often.
    pub samples: usize,
    /// Lines too fine for the samples of the window or too small: their ranges are added whole, rad.
    pub added: f64,
    /// Per cent, value in rad, standard error.
    pub percentiles: Vec<(u32, f64, f64)>,
}

/// What an element counts for.
#[derive(Debug, Clone, Copy)]
pub struct Sensitivity {
    /// Of the sum of squares.
    pub share: f64,
    /// Off the root of the sum of squares, as a share of it, with amplitudes 1/√2 of what they are: one ISO grade better.
    pub one_grade: f64,
    /// The same without the element.
    pub without: f64,
    /// Off the worst case without the element.
    pub worst_without: f64,
}

/// Percentiles told.
const PERCENTILES: [u32; 3] = [5, 50, 95];

/// Shifts of the lattice.
const SHIFTS: usize = 8;

/// The most samples of a window; lines with fewer than eight of them a cycle are added whole.
const GRID: usize = 2048;

/// Lines that together make less than this of the worst case are added whole.
const SMALL: f64 = 1e-3;

/// Adds up `terms` of `sources` over `window` turns of the output; a lattice of `points` points is shifted eight times.
pub fn budget(terms: &[Term], sources: &[Source], window: f64, points: usize) -> Budget {
    let elements = sources.iter().map(|s| s.element + 1).max().unwrap_or(0);
    let mut squares = vec![0.0; elements];
    let mut sums = vec![0.0; elements];
    for term in terms {
        let source = sources[term.source];
        squares[source.element] += term.value.norm_sqr();
        sums[source.element] += term.value.norm() * (1.0 + source.tolerance);
    }
    let (total, worst): (f64, f64) = (squares.iter().sum(), sums.iter().sum());
    let of = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
    let sensitivity = |e: usize| {
        let share = of(squares[e], total);
        let off = |kept: f64| 1.0 - (1.0 - share * (1.0 - kept)).max(0.0).sqrt();
        Sensitivity {
            share,
            one_grade: off(FRAC_1_SQRT_2 * FRAC_1_SQRT_2),
            without: off(0.0),
            worst_without: of(sums[e], worst),
        }
    };
    Budget {
        worst_case: worst,
        rss: total.sqrt(),
        range: range(terms, sources, window, points, worst),
        elements: (0..elements).map(sensitivity).collect(),
    }
}

/// Elements that together change the root of the sum of squares by no more than `threshold` of it, the smallest first, and what leaving
/// them out takes off the root of the sum of squares and off the worst case.
pub fn negligible(elements: &[Sensitivity], threshold: f64) -> (Vec<usize>, f64, f64) {
    let mut order: Vec<usize> = (0..elements.len()).collect();
    order.sort_by(|&a, &b| elements[a].share.total_cmp(&elements[b].share));
    let (mut out, mut share, mut worst) = (Vec::new(), 0.0, 0.0);
    for e in order {
        let with = share + elements[e].share;
        if 1.0 - (1.0 - with).max(0.0).sqrt() > threshold {
            break;
        }
        share = with;
        worst += elements[e].worst_without;
        out.push(e);
    }
    (out, 1.0 - (1.0 - share).max(0.0).sqrt(), worst)
}

/// The distribution of the range.
fn range(
    terms: &[Term],
    sources: &[Source],
    window: f64,
    points: usize,
    worst: f64,
) -> Distribution {
    let mut order: Vec<usize> = (0..terms.len()).collect();
    order.sort_by(|&a, &b| terms[a].value.norm().total_cmp(&terms[b].value.norm()));
    let (mut kept, mut added, mut small) = (Vec::new(), 0.0, 0.0);
    for k in order {
        let size = terms[k].value.norm() * (1.0 + sources[terms[k].source].tolerance);
        small += size;
        if small <= SMALL * worst || 8.0 * terms[k].order * window > GRID as f64 {
            added += 2.0 * size;
        } else {
            kept.push(terms[k]);
        }
    }
    let fastest = kept.iter().fold(0.0f64, |m, t| m.max(t.order * window));
    let grid = ((16.0 * fastest).ceil() as usize).clamp(64, GRID);
    // Cosine and sine of every line over the window, once.
    let waves: Vec<Vec<Complex>> = kept
        .iter()
        .map(|t| {
            (0..grid)
                .map(|i| Complex::cis(TAU * t.order * window * i as f64 / grid as f64))
                .collect()
        })
        .collect();
    let lattice = Lattice::new(2 * sources.len(), points, SHIFTS);
    let mut record = vec![0.0; grid];
    let mut shifted: Vec<Vec<f64>> = Vec::with_capacity(SHIFTS);
    for shift in 0..lattice.shifts() {
        let mut found: Vec<f64> = (0..lattice.points())
            .map(|i| {
                let u = lattice.point(shift, i);
                record.fill(0.0);
                for (term, wave) in kept.iter().zip(&waves) {
                    let source = sources[term.source];
                    let turned = match source.phase_known {
                        true => 0.0,
                        false => TAU * u[2 * term.source] * f64::from(term.harmonic),
                    };
                    let factor = 1.0 + source.tolerance * (2.0 * u[2 * term.source + 1] - 1.0);
                    let z = term.value * Complex::cis(turned) * factor;
                    record
                        .iter_mut()
                        .zip(wave)
                        .for_each(|(r, w)| *r += z.re * w.re - z.im * w.im);
                }
                let (low, high) = record
                    .iter()
                    .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| {
                        (l.min(x), h.max(x))
                    });
                high - low + added
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
        (p, mean, (variance / n).sqrt())
    };
    Distribution {
        window,
        samples: lattice.points() * lattice.shifts(),
        added,
        percentiles: PERCENTILES.into_iter().map(percentile).collect(),
    }
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

    fn term(source: usize, order: f64, value: f64) -> Term {
        Term {
            source,
            order,
            harmonic: 1,
            value: Complex::new(value, 0.0),
        }
    }

    fn unknown(element: usize) -> Source {
        Source {
            element,
            phase_known: false,
            tolerance: 0.0,
        }
    }

    /// Two sources of one order, amplitudes 1 and phases uniform: the resultant is 2 |cos(Δ/2)|, whose quantile p is
    /// 2 sin(πp/2), and the range twice that.
    #[test]
    fn exact_two_unknown_phases() {
        let found = budget(
            &[term(0, 1.0, 1.0), term(1, 1.0, 1.0)],
            &[0, 1].map(unknown),
            1.0,
            1000,
        );
        for (p, value, error) in &found.range.percentiles {
            let exact = 4.0 * (std::f64::consts::FRAC_PI_2 * f64::from(*p) / 100.0).sin();
            assert!(
                (value - exact).abs() < 0.01 && *error < 0.01,
                "{p}: {value} {exact} {error}"
            );
        }
        assert_eq!((found.worst_case, found.rss), (2.0, 2f64.sqrt()));
        assert!((found.elements[0].share - 0.5).abs() < 1e-15);
        assert!((found.elements[0].one_grade - (1.0 - 0.75f64.sqrt())).abs() < 1e-15);
    }

    /// One line whose amplitude lies anywhere within a half of it: the range is uniform between 1 and 3.
    #[test]
    fn exact_tolerance() {
        let source = Source {
            element: 0,
            phase_known: true,
            tolerance: 0.5,
        };
        let found = budget(&[term(0, 3.0, 1.0)], &[source], 1.0, 1000);
        for (p, value, _) in &found.range.percentiles {
            assert!(
                (value - (1.0 + 2.0 * f64::from(*p) / 100.0)).abs() < 0.02,
                "{p}: {value}"
            );
        }
        assert_eq!(found.worst_case, 1.5);
    }

    /// Whatever is left out costs no more than is said.
    #[test]
    fn law_what_is_left_out_costs_what_is_said() {
        let terms = [term(0, 1.0, 10.0), term(1, 5.0, 1.0), term(2, 7.0, 0.5)];
        let full = budget(&terms, &[0, 1, 2].map(unknown), 1.0, 61);
        let (out, off, worst) = negligible(&full.elements, 0.01);
        assert_eq!(out, [2, 1]);
        let kept = budget(&terms[..1], &[0, 1, 2].map(unknown), 1.0, 61);
        assert!((kept.rss - full.rss * (1.0 - off)).abs() < 1e-12);
        assert!((kept.worst_case - full.worst_case * (1.0 - worst)).abs() < 1e-12);
    }
}
