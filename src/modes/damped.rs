//! Complex modes of `λ² I + λ C̃ + K̃ + i sgn(Im λ) H̃` over modal coordinates.
//!
//! First-order form over `(Ω η, η̇, d)`: the positions of rigid motions are left out, since their root is exactly zero, as
//! are the rates of those that nothing brakes. Each root is then polished on the quadratic itself, which gives small roots
//! alongside large ones their digits back and takes loss factors in.

use super::companion::{CompanionForm, is_free};
use super::conserved::CyclicCoordinates;
use super::gyroscopic::{self, GyroscopicMode};
use super::massless::MasslessReduction;
use super::modal_basis::ModalBasis;
use super::modal_matrices::ModalMatrices;
use super::mode::{Mode, modulus, orient};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::linear::LinearModel;
use crate::numeric::quadratic::QuadraticEigenproblem;
use crate::numeric::sorting::{sort_falling, sort_rising};
use crate::numeric::{Complex, ComplexMatrix, eigen};

/// Complex modes, sorted by |λ|: rigid ones first, then each pair once, overdamped roots singly.
///
/// # Errors
/// No convergence of the eigenvalue iteration; numbers out of range.
pub fn modes(
    model: &LinearModel,
    basis: &ModalBasis,
    modal: &ModalMatrices,
) -> Result<Vec<Mode>, Error> {
    let light = MasslessReduction::new(modal)?;
    let whole = light.condense(modal)?;
    let conserved = CyclicCoordinates::new(&whole, model.n_undamped_rigid);
    let eigenproblem = conserved.without(whole);
    let state = CompanionForm::new(&eigenproblem, basis, model.n_undamped_rigid);
    let symmetric = model
        .branches
        .iter()
        .all(|b| b.force.is_none() || b.stiffness == 0.0);
    let lossless = symmetric && !modal.is_dissipative() && state.n_damped_massless == 0;
    let swings = match lossless {
        true => gyroscopic::gyroscopic_modes(
            &eigenproblem.damping,
            &eigenproblem.stiffness,
            &state.positions,
            &state.rates,
        )?,
        false => None,
    };
    let mut found = match swings {
        Some((swings, error)) => undamped_roots(&eigenproblem, swings, error),
        None => complex_roots(&eigenproblem, &state)?,
    };
    if let Some(lost) = found
        .iter()
        .find(|root| !(modulus(root.value) > 0.0 && modulus(root.value).is_finite()))
    {
        let message = format!(
            "a root that is not of a rigid-body mode came out as {}: its numbers are too far apart",
            lost.value
        );
        return Err(Error::new(Code::Overflow, message)
            .with_hint("check for a damping or a speed of absurd size"));
    }
    sort_rising(&mut found, |a| modulus(a.value));
    let rigid = (0..basis.n_rigid).filter(|&j| is_free(&eigenproblem, j));
    let rigid = rigid.map(|j| {
        let mut shape: Vec<Complex> = model
            .expand(&super::modal_basis::column(&modal.shapes, j))
            .iter()
            .map(|&x| Complex::new(x, 0.0))
            .collect();
        orient(&mut shape);
        let zero = Complex::ZERO;
        Mode {
            eigenvalue: zero,
            rigid: true,
            damping_ratio: None,
            shape,
            residual: 0.0,
            trusted_digits: f64::INFINITY,
        }
    });
    let damped = modal.is_dissipative();
    let elastic = found.iter().map(|polished| {
        let mut x = polished.x.clone();
        conserved.recover(polished.value, &mut x);
        let z = light.expand(&x);
        let p: Vec<Complex> = (0..modal.shapes.nrows())
            .map(|i| {
                z.iter()
                    .enumerate()
                    .map(|(j, &x)| x * modal.shapes[(i, j)])
                    .fold(Complex::ZERO, |s, t| s + t)
            })
            .collect();
        let mut shape = recover(model, &p);
        orient(&mut shape);
        let lambda = polished.value;
        let damping_ratio =
            (damped && lambda.im != 0.0 && lambda.re != 0.0).then(|| -lambda.re / modulus(lambda));
        Mode {
            eigenvalue: lambda,
            rigid: false,
            damping_ratio,
            shape,
            residual: polished.residual,
            trusted_digits: polished.digits,
        }
    });
    Ok(rigid.chain(elastic).collect())
}

/// Roots without losses: Newton only where the small ones want digits back, and never off the imaginary axis.
fn undamped_roots(
    eigenproblem: &QuadraticEigenproblem,
    swings: Vec<GyroscopicMode>,
    error: f64,
) -> Vec<PolishedRoot> {
    let omega: Vec<Complex> = swings
        .iter()
        .map(|swing| Complex::new(0.0, swing.omega))
        .collect();
    let swings = swings.into_iter().enumerate().map(|(k, swing)| {
        let wants = is_isolated(k, &omega) && error > POLISH_THRESHOLD * swing.omega;
        let start = RootEstimate {
            value: omega[k],
            vector: swing.shape,
            error,
        };
        polish(eigenproblem, start, wants, RootLocation::OnAxis)
    });
    swings.collect()
}

/// Roots of the first-order form.
fn complex_roots(
    eigenproblem: &QuadraticEigenproblem,
    state: &CompanionForm,
) -> Result<Vec<PolishedRoot>, Error> {
    let mut found = Vec::new();
    if state.is_empty() {
        return Ok(found);
    }
    let matrix = state.matrix(eigenproblem)?;
    let eigen = eigen::eigen(&matrix)?;
    let swings = eigen.values.iter().filter(|value| value.im > 0.0).count();
    for k in (0..eigen.values.len()).filter(|&k| eigen.values[k].im >= 0.0) {
        let value = eigen.values[k];
        if eigenproblem.hysteretic.is_some() && value.im > 0.0 {
            continue;
        }
        let right: Vec<Complex> = (0..state.len()).map(|i| eigen.right[(i, k)]).collect();
        let vector = state.positions(eigenproblem, value, &right);
        let error = f64::EPSILON * eigen.norm * eigen.condition[k];
        let wants = is_isolated(k, &eigen.values);
        found.push(polish(
            eigenproblem,
            RootEstimate {
                value,
                vector,
                error,
            },
            wants,
            RootLocation::Anywhere,
        ));
    }
    if let Some(h) = &eigenproblem.hysteretic {
        let extra = state.hysteretic(eigenproblem, h)?;
        let full = ComplexMatrix::from_fn(state.len(), state.len(), |i, j| {
            Complex::new(matrix[(i, j)], extra[(i, j)])
        });
        found.extend(with_loss_factors(eigenproblem, state, &full, swings)?);
    }
    Ok(found)
}

/// Eigenvalues above the real axis, where H acts as an imaginary stiffness: as many as are oscillatory without it.
fn with_loss_factors(
    eigenproblem: &QuadraticEigenproblem,
    state: &CompanionForm,
    matrix: &ComplexMatrix,
    swings: usize,
) -> Result<Vec<PolishedRoot>, Error> {
    let (values, right) = eigen::eigen_complex(matrix)?;
    let mut above: Vec<usize> = (0..values.len()).filter(|&k| values[k].im > 0.0).collect();
    // Roots that are real without H stand next to the axis here; where H has no meaning they are taken without it.
    sort_falling(&mut above, |&a| values[a].im);
    above.truncate(swings);
    if above.len() < swings {
        let message = format!(
            "only {} of {swings} modes are still oscillatory with these loss factors",
            above.len()
        );
        return Err(
            Error::new(Code::NoConvergence, message).with_hint("give viscous damping c instead")
        );
    }
    let size = modulus(values[values.len() - 1]);
    let polished = above.iter().map(|&k| {
        let vector: Vec<Complex> = (0..state.len()).map(|i| right[(i, k)]).collect();
        let vector = state.positions(eigenproblem, values[k], &vector);
        // Without the condition of each root a backward error of some ε of the matrix is taken tenfold.
        let error = 10.0 * f64::EPSILON * size;
        polish(
            eigenproblem,
            RootEstimate {
                value: values[k],
                vector,
                error,
            },
            is_isolated(k, &values),
            RootLocation::Anywhere,
        )
    });
    Ok(polished.collect())
}

/// Relative error of a root that needs no polishing.
const POLISH_THRESHOLD: f64 = 1e-13;

/// No other root is so near that polishing would mix their shapes.
fn is_isolated(k: usize, roots: &[Complex]) -> bool {
    const REPEATED: f64 = 1e-8; // relative: √ε, where the shapes of a pair keep half their digits
    roots
        .iter()
        .enumerate()
        .all(|(i, &root)| i == k || modulus(root - roots[k]) > REPEATED * modulus(roots[k]))
}

fn recover(model: &LinearModel, p: &[Complex]) -> Vec<Complex> {
    model
        .transform
        .iter()
        .map(|row| {
            row.iter()
                .map(|&(j, a)| p[j] * a)
                .fold(Complex::ZERO, |s, t| s + t)
        })
        .collect()
}

struct PolishedRoot {
    value: Complex,
    x: Vec<Complex>,
    residual: f64,
    digits: f64,
}

/// A root as the first solution left it, with its absolute error.
struct RootEstimate {
    value: Complex,
    vector: Vec<Complex>,
    error: f64,
}

/// Knowledge of an eigenvalue's location.
#[derive(Clone, Copy, PartialEq)]
enum RootLocation {
    /// Nothing.
    Anywhere,
    /// It is imaginary: nothing loses energy.
    OnAxis,
}

/// A residual up to here is rounding of the equation's own terms.
const ROUNDING: f64 = 1e-12;

/// Largest order for which every root is polished: a step is a complex LU of that order.
const MAX_POLISH_ORDER: usize = 160;

/// Safety factor of a polished eigenvalue's error: ε times its condition times this.
const POLISH_SAFETY: f64 = 10.0;

/// Polishes a root where that is wanted; keeps the start where polishing leads elsewhere.
fn polish(
    eigenproblem: &QuadraticEigenproblem,
    start: RootEstimate,
    wanted: bool,
    known: RootLocation,
) -> PolishedRoot {
    let reach = 1e3 * start.error;
    let tries = wanted && eigenproblem.len() <= MAX_POLISH_ORDER;
    let polished = tries
        .then(|| eigenproblem.polish(start.value, &start.vector).ok())
        .flatten();
    let near = polished.filter(|root| modulus(root.value - start.value) <= reach);
    let (mut value, mut x, residual, lost) = match near {
        Some(root) => {
            let lost = POLISH_SAFETY * f64::EPSILON * eigenproblem.condition(&root);
            (root.value, root.right, root.residual, lost)
        }
        None => {
            let residual = eigenproblem.residual(start.value, &start.vector);
            (
                start.value,
                start.vector,
                residual,
                POLISH_SAFETY * start.error / modulus(start.value),
            )
        }
    };
    if known == RootLocation::OnAxis {
        value = Complex::new(0.0, value.im);
    }
    if value.im != 0.0 && value.re.abs() <= lost * modulus(value) {
        // Less than what is certain of λ: no damper sees this mode.
        value = Complex::new(0.0, value.im);
    }
    normalise(eigenproblem, value, &mut x);
    // No root is better than what is left of its equation.
    let digits = match lost.max(residual.min(1.0) - ROUNDING) {
        lost if lost.is_nan() => 0.0,
        lost => (-lost.log10()).clamp(0.0, 15.0),
    };
    PolishedRoot {
        value,
        x,
        residual,
        digits,
    }
}

/// `xᵀ (2λ I_η + C) x = 1`; where that product vanishes (defective, or with gyroscopic terms) `xᴴx = 1`.
fn normalise(eigenproblem: &QuadraticEigenproblem, value: Complex, x: &mut [Complex]) {
    let slope = eigenproblem.derivative_times(value, x, false);
    let product = x
        .iter()
        .zip(&slope)
        .map(|(x, s)| x * s)
        .fold(Complex::ZERO, |s, t| s + t);
    let size: f64 = x
        .iter()
        .zip(&slope)
        .map(|(x, s)| modulus(*x) * modulus(*s))
        .sum();
    let factor = if modulus(product) > 1e-8 * size {
        product.sqrt()
    } else {
        Complex::new(
            x.iter().map(|x| modulus(*x).powi(2)).sum::<f64>().sqrt(),
            0.0,
        )
    };
    if modulus(factor) > 0.0 {
        x.iter_mut().for_each(|x| *x /= factor);
    }
}
