//! Energy shares of a mode: kinetic, strain and dissipated energy by element.
//!
//! Shares of `Σ m |vᵀφ|²`, `Σ k W` and `Σ (c + ηk/|λ|) W` with `W = Re(conj(uᵀφ) wᵀφ)`, w the direction of the deflection and u that of the
//! force; each sums to 1. A negative stiffness has a negative share.

use super::mode::{Mode, modulus};
use crate::machine::components::Machine;
use crate::machine::linear::{LinearBranch, LinearModel};
use crate::numeric::Complex;

/// Shares by element number; elements that take no part are left out.
#[derive(Debug, Clone, Default)]
pub struct EnergyShares {
    /// Shares of the kinetic energy.
    pub kinetic: Vec<(usize, f64)>,
    /// Shares of the strain energy; `None` for rigid-body modes.
    pub strain: Option<Vec<(usize, f64)>>,
    /// Shares of the energy lost in a period by elements; `None` where none loses any.
    pub dissipated: Option<Vec<(usize, f64)>>,
    /// `ζ` estimated from the loss of the undamped shape, `(Σ (c + ηk/ω) W + φᵀCφ)/(2ω φᵀMφ)` with the Rayleigh damping C; `None` for rigid modes or without losses.
    pub estimated_damping_ratio: Option<f64>,
}

/// Shares of kinetic, strain and dissipated energy of a mode by element. Rayleigh damping enters the estimate of ζ alone, modal damping neither.
pub fn energy_shares(machine: &Machine, model: &LinearModel, mode: &Mode) -> EnergyShares {
    let p = model.select_independent(&mode.shape);
    let n = machine.elements.len();
    let omega = mode.omega();
    let mut kinetic = vec![0.0; n];
    for mass in &model.masses {
        kinetic[mass.element] += mass.value * modulus(mass.direction.dot_complex(&p)).powi(2);
    }
    let total: f64 = kinetic.iter().sum();
    let mut result = EnergyShares {
        kinetic: shares(kinetic),
        ..EnergyShares::default()
    };
    if mode.rigid {
        return result;
    }
    let (mut strain, mut lost) = (vec![0.0; n], vec![0.0; n]);
    for branch in &model.branches {
        let element = machine.branches[branch.index].element;
        let product = work(branch, &p);
        strain[element] += branch.stiffness * product;
        lost[element] += (branch.damping + branch.loss_factor * branch.stiffness / omega) * product;
    }
    result.strain = Some(shares(strain));
    let by_elements: f64 = lost.iter().sum();
    let everywhere = global_loss(machine, omega) * total;
    if by_elements + everywhere > 0.0 && total > 0.0 {
        result.estimated_damping_ratio = Some((by_elements + everywhere) / (2.0 * omega * total));
    }
    result.dissipated = (by_elements > 0.0).then(|| shares(lost));
    result
}

/// `Re(conj(uᵀφ) wᵀφ)`: what the branch's force does per cycle along its own direction.
fn work(branch: &LinearBranch, p: &[Complex]) -> f64 {
    let (u, w) = (
        branch.force_direction().dot_complex(p),
        branch.direction.dot_complex(p),
    );
    u.re * w.re + u.im * w.im
}

/// `φᵀCφ / φᵀMφ` of Rayleigh damping at ω; modal damping is per mode and added by the caller.
fn global_loss(machine: &Machine, omega: f64) -> f64 {
    machine.damping.mass + machine.damping.stiffness * omega * omega
}

/// Each element's part of the sum.
fn shares(values: Vec<f64>) -> Vec<(usize, f64)> {
    let total: f64 = values.iter().sum();
    values
        .into_iter()
        .enumerate()
        .filter(|&(_, v)| v != 0.0 && total != 0.0)
        .map(|(e, v)| (e, v / total))
        .collect()
}

/// The element with the largest share.
pub fn dominant_element(shares: &[(usize, f64)]) -> Option<(usize, f64)> {
    shares.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))
}
