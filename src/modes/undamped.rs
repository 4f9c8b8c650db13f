//! Real undamped modes over all degrees of freedom, with residuals.

use super::modal_basis::{ModalBasis, column};
use super::mode::{Mode, orient};
use crate::machine::linear::LinearModel;
use crate::numeric::Complex;

/// The modes of a basis as the machine's user knows them: every degree of freedom recovered, signs fixed, residuals measured.
pub fn modes(model: &LinearModel, basis: &ModalBasis) -> Vec<Mode> {
    (0..basis.omega.len())
        .map(|j| {
            mode(
                model,
                &column(&basis.shapes, j),
                basis.omega[j],
                j < basis.n_rigid,
                basis.digits[j],
            )
        })
        .collect()
}

/// One real mode from its shape over the independent coordinates.
pub fn mode(model: &LinearModel, p: &[f64], omega: f64, rigid: bool, digits: f64) -> Mode {
    let mut shape: Vec<Complex> = model
        .expand(p)
        .into_iter()
        .map(|x| Complex::new(x, 0.0))
        .collect();
    orient(&mut shape);
    let residual = residual(model, p, omega);
    Mode {
        eigenvalue: Complex::new(0.0, omega),
        rigid,
        damping_ratio: None,
        shape,
        residual,
        trusted_digits: digits,
    }
}

/// `max |K p − ω² M p| / (|K||p| + ω² |M||p|)`, entry by entry: the backward error of the pair.
pub fn residual(model: &LinearModel, p: &[f64], omega: f64) -> f64 {
    let (mut sum, mut size) = (vec![0.0; model.n], vec![0.0; model.n]);
    for branch in &model.branches {
        let force = branch.stiffness * branch.direction.dot(p);
        let bound: f64 = branch
            .direction
            .entries()
            .map(|(i, a)| (a * p[i]).abs())
            .sum();
        for (i, a) in branch.force_direction().entries() {
            sum[i] += a * force;
            size[i] += (a * branch.stiffness * bound).abs();
        }
    }
    let lambda = omega * omega;
    for mass in &model.masses {
        let momentum = lambda * mass.value * mass.direction.dot(p);
        let bound: f64 = mass
            .direction
            .entries()
            .map(|(i, a)| (a * p[i]).abs())
            .sum();
        for (i, a) in mass.direction.entries() {
            sum[i] -= a * momentum;
            size[i] += (a * lambda * mass.value * bound).abs();
        }
    }
    let worst = sum.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let scale = size.iter().fold(0.0f64, |m, x| m.max(*x));
    if scale > 0.0 { worst / scale } else { 0.0 }
}
