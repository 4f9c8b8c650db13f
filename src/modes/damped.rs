//! Complex modes of `λ² I + λ C̃ + K̃ + i sgn(Im λ) H̃` over modal coordinates.
//!
//! The first-order form is over `(Ω η, η̇, d)`. It omits the positions of rigid-body motions, whose root is exactly zero, and the rates of
//! undamped rigid-body motions. Newton's iteration on the quadratic eigenproblem then refines each root: this restores the digits of small
//! roots next to large ones and includes loss factors.

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
use crate::numeric::sorting::{sort_ascending, sort_descending};
use crate::numeric::{Complex, ComplexMatrix, eigen};

/// Complex modes sorted by |λ|: rigid-body modes first, one mode per conjugate pair, one per overdamped root.
///
/// # Errors
/// `NoConvergence` of the eigenvalue iteration; `Overflow` for a root that is zero or not finite.
pub fn modes(
    model: &LinearModel,
    basis: &ModalBasis,
    modal: &ModalMatrices,
) -> Result<Vec<Mode>, Error> {
    let massless = MasslessReduction::new(modal)?;
    let condensed = massless.condense(modal)?;
    let cyclic = CyclicCoordinates::new(&condensed, model.n_undamped_rigid);
    let eigenproblem = cyclic.eliminate(condensed);
    let companion = CompanionForm::new(&eigenproblem, basis, model.n_undamped_rigid);
    let symmetric = model
        .branches
        .iter()
        .all(|b| b.force.is_none() || b.stiffness == 0.0);
    let lossless = symmetric && !modal.is_dissipative() && companion.n_damped_massless == 0;
    let oscillatory = match lossless {
        true => gyroscopic::gyroscopic_modes(
            &eigenproblem.damping,
            &eigenproblem.stiffness,
            &companion.positions,
            &companion.rates,
        )?,
        false => None,
    };
    let mut roots = match oscillatory {
        Some((oscillatory, error)) => undamped_roots(&eigenproblem, oscillatory, error),
        None => complex_roots(&eigenproblem, &companion)?,
    };
    if let Some(invalid) = roots
        .iter()
        .find(|root| !(modulus(root.value) > 0.0 && modulus(root.value).is_finite()))
    {
        let message = format!(
            "a root that is not of a rigid-body mode was computed as {}: its values differ too much in size",
            invalid.value
        );
        return Err(Error::new(Code::Overflow, message)
            .with_hint("check the order of magnitude of dampings and speeds"));
    }
    sort_ascending(&mut roots, |a| modulus(a.value));
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
    let elastic = roots.iter().map(|root| {
        let mut x = root.x.clone();
        cyclic.recover(root.value, &mut x);
        let z = massless.expand(&x);
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
        let lambda = root.value;
        let damping_ratio =
            (damped && lambda.im != 0.0 && lambda.re != 0.0).then(|| -lambda.re / modulus(lambda));
        Mode {
            eigenvalue: lambda,
            rigid: false,
            damping_ratio,
            shape,
            residual: root.residual,
            trusted_digits: root.digits,
        }
    });
    Ok(rigid.chain(elastic).collect())
}

/// Roots of a lossless model, on the imaginary axis; Newton refines only isolated roots whose error exceeds [`POLISH_THRESHOLD`].
fn undamped_roots(
    eigenproblem: &QuadraticEigenproblem,
    modes: Vec<GyroscopicMode>,
    error: f64,
) -> Vec<PolishedRoot> {
    let omega: Vec<Complex> = modes
        .iter()
        .map(|mode| Complex::new(0.0, mode.omega))
        .collect();
    let modes = modes.into_iter().enumerate().map(|(k, mode)| {
        let refine = is_isolated(k, &omega) && error > POLISH_THRESHOLD * mode.omega;
        let estimate = RootEstimate {
            value: omega[k],
            vector: mode.shape,
            error,
        };
        polish(eigenproblem, estimate, refine, RootLocation::OnAxis)
    });
    modes.collect()
}

/// Roots of the first-order form with Im λ ≥ 0, refined on the quadratic.
fn complex_roots(
    eigenproblem: &QuadraticEigenproblem,
    companion: &CompanionForm,
) -> Result<Vec<PolishedRoot>, Error> {
    let mut roots = Vec::new();
    if companion.is_empty() {
        return Ok(roots);
    }
    let matrix = companion.matrix(eigenproblem)?;
    let eigen = eigen::eigen(&matrix)?;
    let n_pairs = eigen.values.iter().filter(|value| value.im > 0.0).count();
    for k in (0..eigen.values.len()).filter(|&k| eigen.values[k].im >= 0.0) {
        let value = eigen.values[k];
        if eigenproblem.hysteretic.is_some() && value.im > 0.0 {
            continue;
        }
        let right: Vec<Complex> = (0..companion.len()).map(|i| eigen.right[(i, k)]).collect();
        let vector = companion.positions(eigenproblem, value, &right);
        let error = f64::EPSILON * eigen.norm * eigen.condition[k];
        let refine = is_isolated(k, &eigen.values);
        roots.push(polish(
            eigenproblem,
            RootEstimate {
                value,
                vector,
                error,
            },
            refine,
            RootLocation::ComplexPlane,
        ));
    }
    if let Some(h) = &eigenproblem.hysteretic {
        let imaginary = companion.hysteretic(eigenproblem, h)?;
        let matrix = ComplexMatrix::from_fn(companion.len(), companion.len(), |i, j| {
            Complex::new(matrix[(i, j)], imaginary[(i, j)])
        });
        roots.extend(hysteretic_roots(eigenproblem, companion, &matrix, n_pairs)?);
    }
    Ok(roots)
}

/// Eigenvalues with Im λ > 0, for which H acts as an imaginary stiffness; their number is that of the oscillatory modes without H.
fn hysteretic_roots(
    eigenproblem: &QuadraticEigenproblem,
    companion: &CompanionForm,
    matrix: &ComplexMatrix,
    n_pairs: usize,
) -> Result<Vec<PolishedRoot>, Error> {
    let (values, right) = eigen::eigen_complex(matrix)?;
    let mut upper: Vec<usize> = (0..values.len()).filter(|&k| values[k].im > 0.0).collect();
    // Roots that are real without H lie near the real axis here, where H is not defined: they are computed without H.
    sort_descending(&mut upper, |&a| values[a].im);
    upper.truncate(n_pairs);
    if upper.len() < n_pairs {
        let message = format!(
            "only {} of {n_pairs} modes are still oscillatory with these loss factors",
            upper.len()
        );
        return Err(
            Error::new(Code::NoConvergence, message).with_hint("give viscous damping c instead")
        );
    }
    let largest = modulus(values[values.len() - 1]);
    let roots = upper.iter().map(|&k| {
        let vector: Vec<Complex> = (0..companion.len()).map(|i| right[(i, k)]).collect();
        let vector = companion.positions(eigenproblem, values[k], &vector);
        // The condition numbers are unknown here: error bound 10 ε |λ|max.
        let error = 10.0 * f64::EPSILON * largest;
        polish(
            eigenproblem,
            RootEstimate {
                value: values[k],
                vector,
                error,
            },
            is_isolated(k, &values),
            RootLocation::ComplexPlane,
        )
    });
    Ok(roots.collect())
}

/// Relative error below which a root is not refined.
const POLISH_THRESHOLD: f64 = 1e-13;

/// Whether no other root is close enough for the refinement to mix their shapes.
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

/// Root of the first-order form with its absolute error.
struct RootEstimate {
    value: Complex,
    vector: Vec<Complex>,
    error: f64,
}

/// Set in the complex plane on which a root lies.
#[derive(Clone, Copy, PartialEq)]
enum RootLocation {
    /// Complex plane.
    ComplexPlane,
    /// Imaginary axis: the model is lossless.
    OnAxis,
}

/// Relative residual that rounding of the terms of the equation explains.
const ROUNDING: f64 = 1e-12;

/// Largest order for which roots are refined: each Newton step is a complex LU factorisation of that order.
const MAX_POLISH_ORDER: usize = 160;

/// Safety factor of the error bound of a refined eigenvalue: error = factor × ε × condition number.
const POLISH_SAFETY: f64 = 10.0;

/// Refines a root if `refine` is set; keeps the estimate if the refined root lies more than 1000 error bounds away.
fn polish(
    eigenproblem: &QuadraticEigenproblem,
    estimate: RootEstimate,
    refine: bool,
    location: RootLocation,
) -> PolishedRoot {
    let max_shift = 1e3 * estimate.error;
    let iterate = refine && eigenproblem.len() <= MAX_POLISH_ORDER;
    let polished = iterate
        .then(|| eigenproblem.polish(estimate.value, &estimate.vector).ok())
        .flatten();
    let accepted = polished.filter(|root| modulus(root.value - estimate.value) <= max_shift);
    let (mut value, mut x, residual, relative_error) = match accepted {
        Some(root) => {
            let relative_error = POLISH_SAFETY * f64::EPSILON * eigenproblem.condition(&root);
            (root.value, root.right, root.residual, relative_error)
        }
        None => {
            let residual = eigenproblem.residual(estimate.value, &estimate.vector);
            (
                estimate.value,
                estimate.vector,
                residual,
                POLISH_SAFETY * estimate.error / modulus(estimate.value),
            )
        }
    };
    if location == RootLocation::OnAxis {
        value = Complex::new(0.0, value.im);
    }
    if value.im != 0.0 && value.re.abs() <= relative_error * modulus(value) {
        // Re λ is within the error of λ: the mode is undamped.
        value = Complex::new(0.0, value.im);
    }
    normalise(eigenproblem, value, &mut x);
    // The residual limits the digits.
    let digits = match relative_error.max(residual.min(1.0) - ROUNDING) {
        relative_error if relative_error.is_nan() => 0.0,
        relative_error => (-relative_error.log10()).clamp(0.0, 15.0),
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
    let derivative = eigenproblem.derivative_times(value, x, false);
    let product = x
        .iter()
        .zip(&derivative)
        .map(|(x, s)| x * s)
        .fold(Complex::ZERO, |s, t| s + t);
    let size: f64 = x
        .iter()
        .zip(&derivative)
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
