//! Local fit of one new pole in a window of lines, with its neighbours and a smooth background.

use crate::numeric::thin_qr::rows;
use crate::numeric::{Complex, Matrix};

use super::basis::{ScaledPole, WhitenedProblem, set_complex};
use super::projection::{ModelFit, PoleModel, StopCriteria, fit_at, refine};
use super::scan::ScanPeak;

/// Half-width of a window in half-widths of the pole, and its minimum in lines.
const WINDOW_HALF_WIDTHS: f64 = 12.0;
const MIN_HALF_WINDOW_LINES: usize = 8;

/// Maximum share of the lines in a window; a larger window is replaced by a fit of all lines.
const MAX_WINDOW_SHARE: f64 = 0.7;

/// Stop criteria within a window; the local fit need not converge fully.
const STOP: StopCriteria = StopCriteria {
    steps: 15,
    min_decrease: 0.5,
    min_relative_decrease: 1e-4,
};

/// Refined pole of a peak.
#[derive(Debug, Clone)]
pub(super) struct LocalFit {
    /// The new pole.
    pub pole: ScaledPole,
    /// Refined neighbours: index in the model and new pole.
    pub neighbours: Vec<(usize, ScaledPole)>,
    /// Decrease of χ² within the window.
    pub gain: f64,
    /// Numerator coefficients of the new pole, one column per response (basis columns of unit norm).
    pub numerators: Matrix,
}

/// First and end line of the window around a pole; `None` if the window would cover most of the band.
pub(super) fn window(x: &[f64], pole: &ScaledPole, step: f64) -> Option<(usize, usize)> {
    let half = (WINDOW_HALF_WIDTHS * pole.sigma).max(MIN_HALF_WINDOW_LINES as f64 * step);
    let from = x.partition_point(|&v| v < pole.w - half);
    let to = x.partition_point(|&v| v <= pole.w + half);
    // at the ends of the band the window keeps its number of lines
    let min_lines = (2 * MIN_HALF_WINDOW_LINES).min(x.len());
    let from = from.min(x.len() - min_lines);
    let to = to.max(from + min_lines).min(x.len());
    ((to - from) as f64 <= MAX_WINDOW_SHARE * x.len() as f64).then_some((from, to))
}

/// Refines the pole of a peak within a window; `None` if the fit needs all lines or the window has too few.
pub(super) fn fit_locally(
    problem: &WhitenedProblem,
    fit: &ModelFit,
    numerators: usize,
    peak: &ScanPeak,
    unstable: bool,
) -> Option<LocalFit> {
    let step = problem.line_spacing;
    let (from, to) = window(&problem.x, &peak.pole, step)?;
    let poles = &fit.model.poles;
    let indices: Vec<usize> = (0..poles.len())
        .filter(|&r| (problem.x[from]..=problem.x[to - 1]).contains(&poles[r].w))
        .collect();
    let local = cut_window(problem, fit, &fit.fits[0].e, numerators, &indices, from, to);
    let initial: Vec<ScaledPole> = indices.iter().map(|&r| poles[r]).collect();
    let columns = (indices.len() + 1) * numerators + local.pole_free_columns.ncols();
    if 2 * (to - from) < columns + 4 {
        return None;
    }
    let local = [local];
    let without_peak = fit_at(
        &local,
        &PoleModel {
            poles: initial.clone(),
            delays: Vec::new(),
        },
        numerators,
    );
    let mut candidates = vec![peak.pole];
    candidates.extend(common_denominator(problem, fit, peak, step));
    if unstable {
        let mirrored = |p: &ScaledPole| ScaledPole {
            stable: !p.stable,
            ..*p
        };
        candidates.extend(candidates.iter().map(mirrored).collect::<Vec<_>>());
    }
    let best = candidates
        .into_iter()
        .map(|start| {
            let mut poles = initial.clone();
            poles.push(start);
            let model = PoleModel {
                poles,
                delays: Vec::new(),
            };
            refine(&local, fit_at(&local, &model, numerators), numerators, STOP)
        })
        .min_by(|a, b| a.chi2.total_cmp(&b.chi2))?;
    let first = indices.len() * numerators;
    let c = &best.fits[0].c;
    Some(LocalFit {
        pole: *best.model.poles.last()?,
        neighbours: indices.into_iter().zip(best.model.poles.clone()).collect(),
        gain: without_peak.chi2 - best.chi2,
        numerators: rows(c, first, first + numerators),
    })
}

/// Local problem of a window: residual of the fit plus the terms of the `neighbours`, with a background `1, j, t, jt`.
pub(super) fn cut_window(
    problem: &WhitenedProblem,
    fitted: &ModelFit,
    residual: &Matrix,
    numerators: usize,
    neighbours: &[usize],
    from: usize,
    to: usize,
) -> WhitenedProblem {
    let (n, m) = (problem.lines(), to - from);
    let fit = &fitted.fits[0];
    let rows_in_window = |a: &Matrix| {
        Matrix::from_fn(2 * m, a.ncols(), |k, j| {
            a[(if k < m { from + k } else { n + from + k - m }, j)]
        })
    };
    let x = problem.x[from..to].to_vec();
    let factor = problem.factor[from..to].to_vec();
    let middle = 0.5 * (x[0] + x[m - 1]);
    let reach = 0.5 * (x[m - 1] - x[0]);
    let mut background = Matrix::zeros(2 * m, 4);
    for k in 0..m {
        let t = (x[k] - middle) / reach;
        let j = Complex::new(0.0, 1.0);
        for (at, z) in [factor[k], factor[k] * j, factor[k] * t, factor[k] * j * t]
            .into_iter()
            .enumerate()
        {
            set_complex(background.col_as_slice_mut(at), k, m, z);
        }
    }
    let mut local = WhitenedProblem {
        y: rows_in_window(residual),
        x,
        factor,
        pole_free_columns: Matrix::zeros(2 * m, 0),
        first: problem.first,
        line_spacing: problem.line_spacing,
        omitted_energy: 0.0,
    };
    if !neighbours.is_empty() {
        let poles: Vec<ScaledPole> = neighbours.iter().map(|&r| fitted.model.poles[r]).collect();
        let basis = local.basis(&poles, numerators);
        let shares = Matrix::from_fn(poles.len() * numerators, fit.c.ncols(), |row, i| {
            let column = neighbours[row / numerators] * numerators + row % numerators;
            fit.c[(column, i)] / fit.column_norms[column]
        });
        local.y = &local.y + &basis * &shares;
    }
    local.pole_free_columns = background;
    local
}

/// Half-range of the common-denominator fit: minimum number of lines, and half-widths of the pole.
const DENOMINATOR: (usize, f64) = (3, 3.0);

/// Fits `(s − p) E = c + d s` on the adjacent lines in three iterations weighted by the last denominator (Sanathanan and Koerner 1963);
/// resolves poles between two lines.
fn common_denominator(
    problem: &WhitenedProblem,
    fit: &ModelFit,
    peak: &ScanPeak,
    step: f64,
) -> Option<ScaledPole> {
    let n = problem.lines();
    let e = &fit.fits[0].e;
    let reach = DENOMINATOR
        .0
        .max((DENOMINATOR.1 * peak.pole.sigma / step).ceil() as usize);
    let centre = problem.x.partition_point(|&x| x < peak.pole.w).min(n - 1);
    let range = centre.saturating_sub(reach)..(centre + reach + 1).min(n);
    let mut p = peak.pole.value();
    for _ in 0..3 {
        let weight: Vec<f64> = range
            .clone()
            .map(|k| {
                problem.factor[k].norm_sqr() / (Complex::new(0.0, problem.x[k]) - p).norm_sqr()
            })
            .collect();
        let (mut numerator, mut denominator) = (Complex::new(0.0, 0.0), 0.0);
        for i in 0..e.ncols() {
            let column = e.col_as_slice(i);
            let values: Vec<Complex> = range
                .clone()
                .map(|k| Complex::new(column[k], column[n + k]) / problem.factor[k])
                .collect();
            let products: Vec<Complex> = range
                .clone()
                .zip(&values)
                .map(|(k, v)| v * Complex::new(0.0, problem.x[k]))
                .collect();
            let b = detrend(&problem.x[range.clone()], &weight, &values);
            let a = detrend(&problem.x[range.clone()], &weight, &products);
            for k in 0..a.len() {
                numerator += b[k].conj() * a[k] * weight[k];
                denominator += b[k].norm_sqr() * weight[k];
            }
        }
        if denominator <= 0.0 {
            return None;
        }
        p = numerator / denominator;
        if !(p.re.is_finite() && p.im.is_finite() && p.re < 0.0 && p.im > 0.0) {
            return None;
        }
    }
    let interval = problem.x[range.start] - step..=problem.x[range.end - 1] + step;
    interval.contains(&p.im).then_some(ScaledPole {
        w: p.im,
        sigma: -p.re,
        stable: true,
    })
}

/// Subtracts the weighted regression line from complex values.
fn detrend(x: &[f64], weight: &[f64], values: &[Complex]) -> Vec<Complex> {
    let total: f64 = weight.iter().sum();
    let mean_x = x.iter().zip(weight).map(|(x, w)| x * w).sum::<f64>() / total;
    let mean: Complex = values
        .iter()
        .zip(weight)
        .map(|(v, w)| v * w)
        .sum::<Complex>()
        / total;
    let (mut slope, mut spread) = (Complex::new(0.0, 0.0), 0.0);
    for k in 0..x.len() {
        let t = x[k] - mean_x;
        slope += (values[k] - mean) * (weight[k] * t);
        spread += weight[k] * t * t;
    }
    if spread > 0.0 {
        slope /= spread;
    }
    (0..x.len())
        .map(|k| values[k] - mean - slope * (x[k] - mean_x))
        .collect()
}
