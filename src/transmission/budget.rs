//! Error budget of a chain: worst case, root sum square, effect of each element.
//!
//! Sources are independent; the harmonics of one source share its unknown phase: a rotation by θ shifts the harmonic of n cycles by nθ.
//! Worst case `Σ A (1 + t)`: all crests coincide, and every amplitude is at the upper limit of its tolerance t. Root sum square `√Σ A²`
//! of the stated amplitudes. The peak-to-peak value over a window is F_i′.

use std::f64::consts::FRAC_1_SQRT_2;

use super::order_lines::{LineOrigin, OrderLine};
use super::range_distribution::{ErrorSource, HarmonicTerm, RangeDistribution, range_distribution};
use crate::machine::components::Machine;
use crate::numeric::Complex;
use crate::numeric::sorting::ascending_order;

/// Error budget over all sources.
#[derive(Debug, Clone)]
pub struct ErrorBudget {
    /// Worst case: all crests coincide at the upper tolerance limits, rad zero to peak.
    pub worst_case: f64,
    /// Root sum square, rad zero to peak.
    pub rss: f64,
    /// Distribution of the peak-to-peak value over the window.
    pub range: RangeDistribution,
    /// Contributions of the elements.
    pub elements: Vec<ElementSensitivity>,
}

/// Contribution of an element to the error budget.
#[derive(Debug, Clone, Copy)]
pub struct ElementSensitivity {
    /// Share of the sum of squares.
    pub share: f64,
    /// Relative reduction of the root sum square if the amplitudes are 1/√2 of their values, one ISO grade finer; absent if no error of
    /// the element has a grade.
    pub one_grade_finer: Option<f64>,
    /// Relative reduction of the root sum square without the element.
    pub rss_reduction: f64,
    /// Relative reduction of the worst case without the element.
    pub worst_case_reduction: f64,
}

/// Error budget of the `terms` of `sources` over `window` revolutions of the output; a lattice of `points` points is shifted eight times.
pub fn error_budget(
    terms: &[HarmonicTerm],
    sources: &[ErrorSource],
    window: f64,
    points: usize,
) -> ErrorBudget {
    let elements = sources.iter().map(|s| s.element + 1).max().unwrap_or(0);
    let mut squares = vec![0.0; elements];
    let mut graded = vec![None; elements];
    let mut sums = vec![0.0; elements];
    for term in terms {
        let source = sources[term.source];
        let square = term.value.norm_sqr();
        squares[source.element] += square;
        if source.graded {
            *graded[source.element].get_or_insert(0.0) += square;
        }
        sums[source.element] += term.value.norm() * (1.0 + source.tolerance);
    }
    let (total, worst): (f64, f64) = (squares.iter().sum(), sums.iter().sum());
    let ratio = |part: f64, whole: f64| if whole > 0.0 { part / whole } else { 0.0 };
    let sensitivity = |e: usize| {
        let share = ratio(squares[e], total);
        let loss = |share: f64, square: f64| 1.0 - (1.0 - share * (1.0 - square)).max(0.0).sqrt();
        let finer = |square| loss(ratio(square, total), FRAC_1_SQRT_2 * FRAC_1_SQRT_2);
        ElementSensitivity {
            share,
            one_grade_finer: graded[e].map(finer),
            rss_reduction: loss(share, 0.0),
            worst_case_reduction: ratio(sums[e], worst),
        }
    };
    ErrorBudget {
        worst_case: worst,
        rss: total.sqrt(),
        range: range_distribution(terms, sources, window, points),
        elements: (0..elements).map(sensitivity).collect(),
    }
}

/// Lattice points per shift for the percentiles.
const LATTICE_POINTS: usize = 61;

/// Error budget of the lines of a machine, with A and ψ in `values`, over `window` revolutions of the output, and the names of its elements.
/// Each declared error is a source; the errors on one node form one element.
pub fn line_budget(
    machine: &Machine,
    lines: &[OrderLine],
    values: &[Complex],
    window: f64,
) -> (ErrorBudget, Vec<String>) {
    let mut sources: Vec<(LineOrigin, ErrorSource)> = Vec::new();
    let mut elements: Vec<String> = Vec::new();
    let mut terms = Vec::new();
    for (line, &value) in lines.iter().zip(values) {
        let index = sources.iter().position(|s| s.0 == line.origin);
        let source = index.unwrap_or_else(|| {
            let name = match line.origin {
                LineOrigin::Declared(number) => machine.errors[number].element.clone(),
                LineOrigin::Stiffness(branch) => machine.branch_name(branch),
            };
            let index = elements.iter().position(|e| *e == name);
            let element = index.unwrap_or_else(|| {
                elements.push(name);
                elements.len() - 1
            });
            let source = ErrorSource {
                element,
                phase_known: line.phase_known(machine),
                tolerance: line.declared(machine).map_or(0.0, |error| error.tolerance),
                graded: (line.declared(machine)).is_some_and(|error| error.averaged.is_none()),
            };
            sources.push((line.origin, source));
            sources.len() - 1
        });
        terms.push(HarmonicTerm {
            source,
            order: line.order.to_f64(),
            harmonic: line.harmonic,
            value,
        });
    }
    let sources: Vec<ErrorSource> = sources.into_iter().map(|s| s.1).collect();
    (
        error_budget(&terms, &sources, window, LATTICE_POINTS),
        elements,
    )
}

/// Elements that together change the root sum square by at most the share `threshold`, the smallest first, and the relative reductions
/// of the root sum square and of the worst case without them.
pub fn negligible(elements: &[ElementSensitivity], threshold: f64) -> (Vec<usize>, f64, f64) {
    let order = ascending_order(elements.iter().map(|e| e.share));
    let (mut omitted, mut share, mut worst) = (Vec::new(), 0.0, 0.0);
    for e in order {
        let sum = share + elements[e].share;
        if 1.0 - (1.0 - sum).max(0.0).sqrt() > threshold {
            break;
        }
        share = sum;
        worst += elements[e].worst_case_reduction;
        omitted.push(e);
    }
    (omitted, 1.0 - (1.0 - share).max(0.0).sqrt(), worst)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::Complex;

    fn term(source: usize, order: f64, value: f64) -> HarmonicTerm {
        HarmonicTerm {
            source,
            order,
            harmonic: 1,
            value: Complex::new(value, 0.0),
        }
    }

    fn unknown(element: usize) -> ErrorSource {
        ErrorSource {
            element,
            phase_known: false,
            tolerance: 0.0,
            graded: true,
        }
    }

    /// Two sources of one order, amplitudes 1 and phases uniform: the resultant is 2 |cos(Δ/2)|, whose quantile p is
    /// 2 sin(πp/2), and the range twice that.
    #[test]
    fn exact_two_unknown_phases() {
        let budget = error_budget(
            &[term(0, 1.0, 1.0), term(1, 1.0, 1.0)],
            &[0, 1].map(unknown),
            1.0,
            1000,
        );
        for (p, value, error) in &budget.range.percentiles {
            let exact = 4.0 * (std::f64::consts::FRAC_PI_2 * f64::from(*p) / 100.0).sin();
            assert!(
                (value - exact).abs() < 0.01 && *error < 0.01,
                "{p}: {value} {exact} {error}"
            );
        }
        assert_eq!((budget.worst_case, budget.rss), (2.0, 2f64.sqrt()));
        assert!((budget.elements[0].share - 0.5).abs() < 1e-15);
        assert!(
            (budget.elements[0].one_grade_finer.unwrap() - (1.0 - 0.75f64.sqrt())).abs() < 1e-15
        );
    }

    /// One line with an amplitude tolerance of a half: the range is uniform between 1 and 3.
    #[test]
    fn exact_tolerance() {
        let source = ErrorSource {
            element: 0,
            phase_known: true,
            tolerance: 0.5,
            graded: false,
        };
        let budget = error_budget(&[term(0, 3.0, 1.0)], &[source], 1.0, 1000);
        for (p, value, _) in &budget.range.percentiles {
            assert!(
                (value - (1.0 + 2.0 * f64::from(*p) / 100.0)).abs() < 0.02,
                "{p}: {value}"
            );
        }
        assert_eq!(budget.worst_case, 1.5);
        assert_eq!(budget.elements[0].one_grade_finer, None);
    }

    /// Omitting elements costs no more than the reported loss.
    #[test]
    fn law_what_is_left_out_costs_what_is_said() {
        let terms = [term(0, 1.0, 10.0), term(1, 5.0, 1.0), term(2, 7.0, 0.5)];
        let full = error_budget(&terms, &[0, 1, 2].map(unknown), 1.0, 61);
        let (omitted, loss, worst) = negligible(&full.elements, 0.01);
        assert_eq!(omitted, [2, 1]);
        let reduced = error_budget(&terms[..1], &[0, 1, 2].map(unknown), 1.0, 61);
        assert!((reduced.rss - full.rss * (1.0 - loss)).abs() < 1e-12);
        assert!((reduced.worst_case - full.worst_case * (1.0 - worst)).abs() < 1e-12);
    }
}
