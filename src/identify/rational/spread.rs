//! Responses that disagree about a pole: sensors that load the structure, drift, a structure that is not linear. More common poles
//! beside it would fit that, and would be no modes; instead the lines around it are given the variance the disagreement causes.
//! Means and spreads are those of random effects (DerSimonian and Laird 1986).

use crate::numeric::statistics::{normal_quantile, student_quantile};
use crate::numeric::{Complex, Matrix};

use super::basis::{Pole, Problem};
use super::local::{cut, window};
use super::projection::{Fitted, Model, Stop, at, normal, refine};

/// Only lightly damped poles: a shift of a broad one can hardly be told from a neighbour.
const LIGHT: f64 = 0.05;

/// A pole beside another: within so many half-widths, and not much broader.
const BESIDE: f64 = 3.0;

/// Fewer responses cannot disagree.
pub(super) const FEWEST_RESPONSES: usize = 3;

/// Where two common poles do not fit either, poles of each response may fit this much worse and still be the better word for it,
/// if they lie within this share of the half-width.
const WORSE: f64 = 4.0;
const UNFITTED: f64 = 3.0;
const SHIFT: f64 = 0.25;

/// Where responses disagree about some poles, two poles nearer than this share of a half-width are one they disagree about.
pub(super) const ONE: f64 = 0.5;

/// With fewer responses, what stands on the skirts of a resonance is looked at: within so many half-widths, and lines.
const SKIRT: (f64, f64) = (20.0, 12.0);

const STOP: Stop = Stop {
    steps: 15,
    fall: 0.1,
    share: 1e-5,
};

/// A pole of the model whose lines no common pole fits.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scatter {
    /// Which.
    pub pole: usize,
    /// Spread of frequency and of real part over the responses, in units of the highest line.
    pub tau: (f64, f64),
    /// Misfit of each response as a share of the mode's own value: leakage, or a resonance that is not linear.
    pub share: f64,
}

/// Whether responses can be told to disagree about a pole.
pub(super) fn is_light(pole: &Pole) -> bool {
    pole.sigma < LIGHT * pole.w
}

/// The pole a place lies beside.
pub(super) fn beside(problem: &Problem, poles: &[Pole], place: &Pole) -> Option<usize> {
    let step = problem.step;
    let reach = |p: &Pole| {
        if problem.y.ncols() < FEWEST_RESPONSES {
            (SKIRT.0 * p.sigma).max(SKIRT.1 * step)
        } else {
            BESIDE * p.sigma
        }
    };
    (0..poles.len())
        .filter(|&r| {
            let p = &poles[r];
            let broad = BESIDE * p.sigma.max(step);
            is_light(p) && (p.w - place.w).abs() < reach(p) && place.sigma < broad
        })
        .min_by(|&a, &b| {
            let distance = |r: usize| (poles[r].w - place.w).abs();
            distance(a).total_cmp(&distance(b))
        })
}

/// Poles of each response by itself within the window of a common pole.
struct Own {
    poles: Vec<Pole>,
    /// Sampling variances of w and σ.
    variance: Vec<(f64, f64)>,
    chi2: f64,
}

fn own(local: &Problem, start: Pole, numerators: usize) -> Own {
    let mut own = Own {
        poles: Vec::new(),
        variance: Vec::new(),
        chi2: 0.0,
    };
    let mut problem = [Problem {
        y: Matrix::zeros(0, 0),
        ..local.clone()
    }];
    for i in 0..local.y.ncols() {
        problem[0].y = local.y.subcols(i, 1).to_owned();
        problem[0].first = i;
        let model = Model {
            poles: vec![start],
            delays: Vec::new(),
        };
        let fit = refine(&problem, at(&problem, &model, numerators), numerators, STOP);
        let a = normal(&problem, &fit.model, numerators, &fit.fits).a;
        let det = a[(0, 0)] * a[(1, 1)] - a[(0, 1)] * a[(1, 0)];
        let pole = fit.model.poles[0];
        let square = pole.sigma * pole.sigma;
        own.variance.push(if det > 0.0 {
            (a[(1, 1)] / det * square, a[(0, 0)] / det * square)
        } else {
            (f64::INFINITY, f64::INFINITY)
        });
        own.poles.push(pole);
        own.chi2 += fit.chi2;
    }
    own
}

/// Whether the responses disagree about pole `r` rather than share one more pole at `place`. Two common poles must fit better than those of
/// each response by `margin`, in units of the noise.
pub(super) fn disagreement(
    problem: &Problem,
    fitted: &Fitted,
    numerators: usize,
    r: usize,
    place: Pole,
    margin: f64,
) -> Option<Scatter> {
    let pole = fitted.model.poles[r];
    let (from, to) = window(&problem.x, &pole, problem.step)?;
    let local = cut(problem, fitted, numerators, &[r], from, to);
    if local.y.ncols() < FEWEST_RESPONSES {
        return skirts(local, pole, numerators, r, place);
    }
    let responses = local.y.ncols() as f64;
    let separate = own(&local, pole, numerators);
    let model = Model {
        poles: vec![pole, place],
        delays: Vec::new(),
    };
    let both = [local];
    let pair = refine(&both, at(&both, &model, numerators), numerators, STOP);
    let parameters = 4.0 + responses * (2 * numerators + both[0].fixed.ncols()) as f64;
    let freedom = (2.0 * (to - from) as f64 * responses - parameters).max(1.0);
    let mut shifts: Vec<f64> = separate
        .poles
        .iter()
        .map(|p| (p.w - pole.w).abs())
        .collect();
    shifts.sort_by(f64::total_cmp);
    let shift = shifts[shifts.len() / 2];
    let noise = (pair.chi2 / freedom).max(1.0);
    let better = separate.chi2 < pair.chi2 + margin * noise;
    let likely = separate.chi2 < WORSE * pair.chi2
        && pair.chi2 > UNFITTED * freedom
        && shift < SHIFT * pole.sigma;
    if !(better || likely) {
        return None;
    }
    // what is left is not noise; sampling variances are those of what is left
    let unit = (separate.chi2 / freedom).max(1.0);
    let mean = random_effects(&separate, unit);
    let least = 0.02 * pole.sigma;
    Some(Scatter {
        pole: r,
        tau: (mean.tau.0.max(least), mean.tau.1.max(least)),
        share: 0.0,
    })
}

/// One more pole, and two more, leave the window unfitted: then it is not a pole that is missing.
fn skirts(local: Problem, pole: Pole, numerators: usize, r: usize, place: Pole) -> Option<Scatter> {
    let lines = local.lines();
    let local = [local];
    let fitted = |poles: Vec<Pole>| {
        let count = poles.len();
        let model = Model {
            poles,
            delays: Vec::new(),
        };
        let fit = refine(&local, at(&local, &model, numerators), numerators, STOP);
        let columns = count * numerators + local[0].fixed.ncols();
        let parameters = 2 * count + local[0].y.ncols() * columns;
        let freedom = (2 * lines * local[0].y.ncols()) as f64 - parameters as f64;
        (fit.chi2 / freedom.max(1.0), fit)
    };
    let mirrored = Pole {
        w: 2.0 * pole.w - place.w,
        ..place
    };
    if fitted(vec![pole, place]).0 < UNFITTED || fitted(vec![pole, place, mirrored]).0 < UNFITTED {
        return None;
    }
    // the misfit over the mode's own share, by line
    let alone = at(
        &local,
        &Model {
            poles: vec![pole],
            delays: Vec::new(),
        },
        numerators,
    );
    let fit = &alone.fits[0];
    let basis = local[0].basis(&[pole], numerators);
    let mut ratios: Vec<f64> = Vec::new();
    for i in 0..local[0].y.ncols() {
        for k in 0..lines {
            let own = |row: usize| -> f64 {
                (0..numerators)
                    .map(|b| basis[(row, b)] * fit.c[(b, i)] / fit.length[b])
                    .sum()
            };
            let (re, im) = (own(k), own(lines + k));
            let left = fit.e[(k, i)].powi(2) + fit.e[(lines + k, i)].powi(2);
            ratios.push(left / (re * re + im * im).max(f64::MIN_POSITIVE));
        }
    }
    ratios.sort_by(f64::total_cmp);
    let share = (ratios[ratios.len() / 2] / std::f64::consts::LN_2).sqrt();
    Some(Scatter {
        pole: r,
        tau: (0.0, 0.0),
        share,
    })
}

/// Mean and spread over the responses.
pub(super) struct Mean {
    /// The mean pole.
    pub pole: Pole,
    /// Variances of the mean's w and σ.
    pub variance: (f64, f64),
    /// Spreads.
    pub tau: (f64, f64),
}

impl Mean {
    /// Whether there was something to take a mean of.
    pub fn is_finite(&self) -> bool {
        let all = [
            self.pole.w,
            self.pole.sigma,
            self.variance.0,
            self.variance.1,
            self.tau.0,
            self.tau.1,
        ];
        all.iter().all(|v| v.is_finite())
    }
}

/// A response whose own pole shares less than this with the common one hardly sees it, and has gone elsewhere.
const STAYS: f64 = 0.3;

/// The mean pole over the responses that see it, by fits of its window alone; `independence` is how many independent lines a line holds.
pub(super) fn mean(
    problem: &Problem,
    fitted: &Fitted,
    numerators: usize,
    r: usize,
    independence: f64,
) -> Option<Mean> {
    let pole = fitted.model.poles[r];
    let (from, to) = window(&problem.x, &pole, problem.step)?;
    let local = cut(problem, fitted, numerators, &[r], from, to);
    let mut separate = own(&local, pole, numerators);
    let stayed: Vec<bool> = (separate.poles.iter())
        .map(|own| own.overlap(&pole) > STAYS)
        .collect();
    if !stayed.contains(&true) {
        return None;
    }
    let mut keep = stayed.iter().copied();
    separate.poles.retain(|_| keep.next().unwrap_or(false));
    let mut keep = stayed.iter().copied();
    separate.variance.retain(|_| keep.next().unwrap_or(false));
    let rows = 2.0 * (to - from) as f64 * independence;
    let freedom = local.y.ncols() as f64 * (rows - 2.0 - (numerators + 4) as f64).max(1.0);
    Some(random_effects(
        &separate,
        (separate.chi2 / freedom).max(1.0),
    ))
}

fn random_effects(own: &Own, unit: f64) -> Mean {
    let one = |value: &dyn Fn(&Pole) -> f64, variance: &dyn Fn(&(f64, f64)) -> f64| {
        let y: Vec<f64> = own.poles.iter().map(value).collect();
        let v: Vec<f64> = own.variance.iter().map(|v| variance(v) * unit).collect();
        pooled(&y, &v)
    };
    let (w, w_variance, w_tau) = one(&|p| p.w, &|v| v.0);
    let (sigma, sigma_variance, sigma_tau) = one(&|p| p.sigma, &|v| v.1);
    Mean {
        pole: Pole {
            w,
            sigma,
            stable: true,
        },
        variance: (w_variance, sigma_variance),
        tau: (w_tau, sigma_tau),
    }
}

/// Mean, its variance, and the spread beyond the sampling variances. Where there is such a spread the variance is the one for which
/// 1.96 standard deviations are the 95 % interval of Hartung and Knapp (2001).
fn pooled(y: &[f64], v: &[f64]) -> (f64, f64, f64) {
    let weighted = |tau2: f64| {
        let weights: Vec<f64> = v.iter().map(|v| 1.0 / (v + tau2)).collect();
        let total: f64 = weights.iter().sum();
        let mean = y.iter().zip(&weights).map(|(y, w)| y * w).sum::<f64>() / total;
        (mean, total, weights)
    };
    let (mean, total, weights) = weighted(0.0);
    let q: f64 = y
        .iter()
        .zip(&weights)
        .map(|(y, w)| w * (y - mean).powi(2))
        .sum();
    let squares: f64 = weights.iter().map(|w| w * w).sum();
    let surplus = q - (y.len() as f64 - 1.0);
    let tau2 = (surplus / (total - squares / total)).max(0.0);
    let tau2 = if tau2.is_finite() { tau2 } else { 0.0 };
    let (mean, total, weights) = weighted(tau2);
    if tau2 == 0.0 {
        return (mean, 1.0 / total, 0.0);
    }
    // the spread is itself an estimate from few: the variance is that seen between the responses, for an interval by Student's law
    let free = y.len() as f64 - 1.0;
    let seen: f64 = y
        .iter()
        .zip(&weights)
        .map(|(y, w)| w * (y - mean).powi(2))
        .sum();
    let widened = student_quantile(0.975, free) / normal_quantile(0.975);
    let variance = (seen / free).max(1.0) / total * widened * widened;
    (mean, variance, tau2.sqrt())
}

/// Variance this causes on a line, over the square of the residue: `(τ_w² + τ_σ²)/|s − p|⁴ + share²/|s − p|²`.
pub(super) fn variance(scatter: &Scatter, pole: &Pole, x: f64) -> f64 {
    let square = (Complex::new(0.0, x) - pole.value()).norm_sqr();
    let spread = scatter.tau.0.powi(2) + scatter.tau.1.powi(2);
    spread / (square * square) + scatter.share.powi(2) / square
}
