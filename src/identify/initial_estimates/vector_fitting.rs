//! Vector fitting, relaxed (Gustavsen): poles moved to the zeros of `σ(s)` until σ is constant.
//!
//! Gustavsen & Semlyen, IEEE Trans. Power Delivery 14 (1999), pp. 1052–1061; relaxed, so that σ need not be 1 at infinity:
//! Gustavsen, IEEE Trans. Power Delivery 21 (2006), pp. 1587–1592, eqs. (7)–(9); own unknowns of each response eliminated:
//! Deschrijver et al. (2008), see `elimination`.

use super::elimination;
use super::partial_fractions::{self, PolynomialColumns};
use super::problem::{CommonPoleFit, CommonPoleOptions, CommonPoleProblem};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::{Complex, Matrix, eigen, least_squares};

/// Initial poles of the iteration.
#[derive(Debug, Clone, Copy)]
pub enum InitialPoles<'a> {
    /// So many poles, conjugates counted, spread over the lines.
    Order(usize),
    /// Given poles, rad/s, on and above the real axis; those above represent their conjugates too.
    Poles(&'a [Complex]),
}

/// Damping of the poles that begin: `−Re p / Im p`, as Gustavsen & Semlyen advise.
const INITIAL_DAMPING: f64 = 0.01;

/// Below this share of the band's largest σ the constant of σ is taken as 1 instead (Gustavsen 2006, §V, with another number).
const MIN_SIGMA_CONSTANT: f64 = 1e-8;

/// Largest relative pole shift that counts as converged: some digits above rounding of 40 poles. What is left is less by the rate of
/// convergence.
const CONVERGENCE_TOLERANCE: f64 = 1e-12;

/// Common poles of responses over lines, Hz, weighed by 1/σ; without weights each response counts by its own size.
///
/// # Errors
/// `OutOfRange`, `Conflict`, `NotANumber`, `NoSignal`, `TooShort` for what cannot be fitted; `IllPosed` for fewer values than
/// unknowns, or where they do not determine these; `NoConvergence` of eigenvalues.
pub fn vector_fit(
    frequency_hz: &[f64],
    responses: &[Vec<Complex>],
    weights: Option<&[Vec<f64>]>,
    start: InitialPoles,
    options: CommonPoleOptions,
) -> Result<CommonPoleFit, Error> {
    let order = match start {
        InitialPoles::Order(n) => n,
        InitialPoles::Poles(list) => list.iter().map(|p| if p.im > 0.0 { 2 } else { 1 }).sum(),
    };
    let problem = CommonPoleProblem::new(frequency_hz, responses, weights, order, options)?;
    let mut poles = match start {
        InitialPoles::Order(n) => spread_poles(&problem.omega, n),
        InitialPoles::Poles(list) => scaled(list, problem.scale)?,
    };
    let mut used = 0;
    while used < options.iterations {
        used += 1;
        let mut next = relocate_poles(&problem, &poles)?;
        problem.rescale_poles(&mut next);
        let moved = distance(&poles, &next);
        poles = next;
        if moved < CONVERGENCE_TOLERANCE {
            break;
        }
    }
    partial_fractions::fit(&problem, &poles, used)
}

/// Pairs at quantiles of the lines, weakly damped; one additional real pole for an odd order.
fn spread_poles(omega: &[f64], order: usize) -> Vec<Complex> {
    let pairs = order / 2;
    let floor = INITIAL_DAMPING * omega[omega.len() - 1]; // no pair at a line of 0 Hz
    let at = |k: usize| {
        let share = (k as f64 + 0.5) / pairs as f64;
        let place = share * (omega.len() - 1) as f64;
        let (low, part) = (place.floor() as usize, place.fract());
        let high = (low + 1).min(omega.len() - 1);
        let w = (omega[low] * (1.0 - part) + omega[high] * part).max(floor * share);
        Complex::new(-INITIAL_DAMPING * w, w)
    };
    let real = (order % 2 == 1).then(|| Complex::new(-0.5, 0.0));
    real.into_iter().chain((0..pairs).map(at)).collect()
}

fn scaled(list: &[Complex], scale: f64) -> Result<Vec<Complex>, Error> {
    if let Some(p) = list
        .iter()
        .find(|p| !(p.re.is_finite() && p.im.is_finite() && p.im >= 0.0))
    {
        let message = format!("a start at {p} rad/s is not finite or lies below the real axis");
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("give its conjugate, which represents both"));
    }
    Ok(list.iter().map(|p| p / scale).collect())
}

/// The zeros of σ.
fn relocate_poles(problem: &CommonPoleProblem, poles: &[Complex]) -> Result<Vec<Complex>, Error> {
    let numerator = partial_fractions::columns(poles, &problem.omega, problem.options.into());
    let shared = partial_fractions::columns(
        poles,
        &problem.omega,
        PolynomialColumns {
            constant: true,
            slope: false,
        },
    );
    let n = shared.ncols() - 1;
    let lines = problem.omega.len();
    let common = elimination::common_rows(problem, &numerator, &shared)?;
    // Σ_k Re σ(iω_k) = K forbids σ = 0, and weighs like all responses together.
    let mut relaxed = Matrix::zeros(1, n + 1);
    for j in 0..=n {
        relaxed[(0, j)] = shared.col_as_slice(j)[..lines].iter().sum::<f64>() / lines as f64;
    }
    let weight = data_size(problem);
    (0..=n).for_each(|j| relaxed[(0, j)] *= weight);
    let all = elimination::vstack(&common, &[relaxed]);
    let last = all.nrows() - 1;
    let right = Matrix::from_fn(last + 1, 1, |i, _| if i == last { weight } else { 0.0 });
    let found = least_squares::solve(&all, &right)?;
    let mut unknowns = found.col_as_slice(0).to_vec();
    let mut constant = unknowns.pop().unwrap_or(1.0);
    let largest = unknowns.iter().fold(0.0_f64, |l, c| l.max(c.abs()));
    if constant.abs() < MIN_SIGMA_CONSTANT * largest.max(1.0) {
        let (left, right) = (
            Matrix::from_fn(common.nrows(), n, |i, j| common[(i, j)]),
            Matrix::from_fn(common.nrows(), 1, |i, _| -common[(i, n)]),
        );
        unknowns = least_squares::solve(&left, &right)?
            .col_as_slice(0)
            .to_vec();
        constant = 1.0;
    }
    let mut closed = Matrix::zeros(n, n);
    let mut at = 0;
    for p in poles {
        closed[(at, at)] += p.re;
        let input = if p.im > 0.0 { 2.0 } else { 1.0 };
        for j in 0..n {
            closed[(at, j)] -= input * unknowns[j] / constant;
        }
        if p.im > 0.0 {
            closed[(at, at + 1)] += p.im;
            closed[(at + 1, at)] -= p.im;
            closed[(at + 1, at + 1)] += p.re;
        }
        at += if p.im > 0.0 { 2 } else { 1 };
    }
    Ok(eigen::eigen(&closed)?.values)
}

/// Root of the weighed squares of all data.
fn data_size(problem: &CommonPoleProblem) -> f64 {
    let of = |q: usize| {
        let factor = problem.factors[q];
        let terms = problem.responses[q].iter().zip(problem.weight(q));
        terms
            .map(|(f, w)| (f * (w * factor)).norm_sqr())
            .sum::<f64>()
    };
    (0..problem.responses.len()).map(of).sum::<f64>().sqrt()
}

/// The largest relative change of poles by rank of size; infinite where their kinds differ.
fn distance(old: &[Complex], new: &[Complex]) -> f64 {
    if old.len() != new.len() {
        return f64::INFINITY;
    }
    let of = |(a, b): (&Complex, &Complex)| (a - b).norm() / b.norm().max(f64::MIN_POSITIVE);
    old.iter().zip(new).map(of).fold(0.0, f64::max)
}
