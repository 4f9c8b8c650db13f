//! Floquet multipliers of a harmonic-balance solution by Magnus steps over one period.
//!
//! Magnus expansion to second order: Hairer, Lubich & Wanner, Geometric Numerical Integration (2006), sec. IV.7.

use super::aft::PeriodSamples;
use super::family::SpeedFamily;
use super::linear_part::NonlinearElement;
use crate::base::error::Error;
use crate::motion::dynamic_model::{DynamicModel, ForceLaw};
use crate::motion::problem::OdeProblem;
use crate::numeric::expm::expm;
use crate::numeric::sorting::sort_descending;
use crate::numeric::{Complex, Matrix, eigen};

/// Steps a period is divided into.
const STEPS_PER_PERIOD: usize = 512;

/// The multipliers at ω by falling size, those of free motions left out; `periods` are the laws of the active branches.
///
/// # Errors
/// Those of the exponential and of the eigenvalues.
pub fn multipliers(
    family: &SpeedFamily,
    active: &[NonlinearElement],
    periods: &[PeriodSamples],
    omega: f64,
) -> Result<Vec<Complex>, Error> {
    let model = family.relative_at(omega);
    let all = model.len();
    let samples = periods
        .first()
        .map_or(STEPS_PER_PERIOD, |p| p.stiffness.len());
    let each = (samples / STEPS_PER_PERIOD).max(1);
    let steps = samples / each;
    let h = std::f64::consts::TAU / omega / steps as f64;
    let mut phi = Matrix::identity(all, all);
    let mut before: Option<(Vec<[f64; 2]>, Matrix)> = None;
    for step in 0..steps {
        let mean = |of: &[f64]| {
            // The trapezoidal rule over the step, whose ends are samples.
            let at = |j: usize| of[(step * each + j) % samples];
            ((1..each).map(at).sum::<f64>() + 0.5 * (at(0) + at(each))) / each as f64
        };
        let slopes: Vec<[f64; 2]> = periods
            .iter()
            .map(|p| [mean(&p.stiffness), mean(&p.damping)])
            .collect();
        let same = before.as_ref().is_some_and(|(known, _)| *known == slopes);
        if !same {
            let own = |at: usize| {
                active
                    .iter()
                    .position(|a| a.branch == at)
                    .map(|own| slopes[own])
            };
            let a = matrix(&model, &family.rates, &own);
            let grown = expm(&Matrix::from_fn(all, all, |i, j| h * a[(i, j)]))?;
            before = Some((slopes, grown));
        }
        if let Some((_, grown)) = &before {
            phi = grown * phi;
        }
    }
    let mut values = eigen::eigenvalues(&phi)?;
    for _ in 0..family.relative.neutral {
        let one = Complex::new(1.0, 0.0);
        let nearest = (0..values.len()).min_by(|&a, &b| {
            (values[a] - one)
                .norm()
                .total_cmp(&(values[b] - one).norm())
        });
        if let Some(nearest) = nearest {
            values.remove(nearest);
        }
    }
    sort_descending(&mut values, |a| a.norm());
    Ok(values)
}

/// `ẏ = A y`.
fn matrix(model: &DynamicModel, rates: &[f64], own: &dyn Fn(usize) -> Option<[f64; 2]>) -> Matrix {
    let (n, all) = (model.coordinate_count(), model.len());
    let mut a = Matrix::zeros(all, all);
    let mut inner = 2 * n;
    for (at, b) in model.elements.iter().enumerate() {
        let mut push = vec![0.0; n];
        b.force_direction()
            .entries()
            .for_each(|(i, u)| push[i] -= u);
        model.apply_inverse_mass(&mut push);
        let sees: Vec<(usize, f64)> = b.direction.entries().collect();
        let [k, c] = own(at).unwrap_or(match &b.law {
            ForceLaw::Linear { stiffness, damping } => [*stiffness, *damping],
            ForceLaw::Contact(contact) => [contact.stiffness, contact.damping],
            ForceLaw::TorqueSpeed(curve) => [0.0, -curve.slope(rates[at])],
            _ => [0.0, 0.0],
        });
        for (i, p) in push.iter().enumerate() {
            for &(j, w) in &sees {
                a[(n + i, j)] += p * k * w;
                a[(n + i, n + j)] += p * c * w;
            }
        }
        let state = match &b.law {
            ForceLaw::Maxwell { stiffness, damping } => {
                Some((1.0, *stiffness, -stiffness / damping))
            }
            ForceLaw::LaggedTorque { curve, lag } => {
                Some((-1.0, curve.slope(rates[at]) / lag, -lag.recip()))
            }
            _ => None,
        };
        if let Some((sign, by_rate, decay)) = state {
            push.iter()
                .enumerate()
                .for_each(|(i, p)| a[(n + i, inner)] += sign * p);
            sees.iter()
                .for_each(|&(j, w)| a[(inner, n + j)] += by_rate * w);
            a[(inner, inner)] += decay;
            inner += 1;
        }
    }
    if let Some((k, c)) = &model.global_matrices {
        for j in 0..n {
            let mut push = [
                (0..n).map(|i| -k[(i, j)]).collect::<Vec<f64>>(),
                (0..n).map(|i| -c[(i, j)]).collect(),
            ];
            push.iter_mut().for_each(|p| model.apply_inverse_mass(p));
            for i in 0..n {
                a[(n + i, j)] += push[0][i];
                a[(n + i, n + j)] += push[1][i];
            }
        }
    }
    for i in 0..n {
        a[(i, n + i)] = 1.0;
        a[(n + i, n + i)] -= model.mass_damping;
    }
    a
}
