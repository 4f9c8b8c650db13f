//! Energy shares of a mode: kinetic, strain and dissipated energy by element.
//!
//! Shares of `Σ m |vᵀφ|²`, `Σ k W` and `Σ (c + ηk/|λ|) W` with `W = Re(conj(uᵀφ) wᵀφ)`, w the direction of the deflection and u that of the
//! force; each sums to 1. A negative stiffness has a negative share.

use super::mode::{Mode, modulus};
use crate::machine::components::Machine;
use crate::machine::linear::{LinearBranch, LinearModel};
use crate::numeric::Complex;

/// Energy shares of a mode by element index; elements without energy are omitted.
#[derive(Debug, Clone, Default)]
pub struct EnergyShares {
    /// Shares of the kinetic energy.
    pub kinetic: Vec<(usize, f64)>,
    /// Shares of the strain energy; `None` for rigid-body modes.
    pub strain: Option<Vec<(usize, f64)>>,
    /// Shares of the energy dissipated in a period; `None` where no element dissipates energy.
    pub dissipated: Option<Vec<(usize, f64)>>,
    /// Estimate `ζ ≈ (Σ (c + ηk/ω) W + φᵀCφ)/(2ω φᵀMφ)` from the undamped shape with Rayleigh damping C; `None` for rigid-body modes or without losses.
    pub estimated_damping_ratio: Option<f64>,
}

/// Shares of kinetic, strain and dissipated energy of a mode by element. Rayleigh damping affects only the estimate of ζ; modal damping is ignored.
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
    let (mut strain, mut loss) = (vec![0.0; n], vec![0.0; n]);
    for branch in &model.branches {
        let element = machine.branches[branch.index].element;
        let product = work(branch, &p);
        strain[element] += branch.stiffness * product;
        loss[element] += (branch.damping + branch.loss_factor * branch.stiffness / omega) * product;
    }
    result.strain = Some(shares(strain));
    let element_loss: f64 = loss.iter().sum();
    let total_loss = element_loss + rayleigh_damping(machine, omega) * total;
    if total_loss > 0.0 && total > 0.0 {
        result.estimated_damping_ratio = Some(total_loss / (2.0 * omega * total));
    }
    result.dissipated = (element_loss > 0.0).then(|| shares(loss));
    result
}

/// Product `W = Re(conj(uᵀφ) wᵀφ)` of a branch's force direction and deflection.
fn work(branch: &LinearBranch, p: &[Complex]) -> f64 {
    let (u, w) = (
        branch.force_direction().dot_complex(p),
        branch.direction.dot_complex(p),
    );
    u.re * w.re + u.im * w.im
}

/// Modal damping `φᵀCφ / φᵀMφ` of Rayleigh damping at ω, 1/s.
fn rayleigh_damping(machine: &Machine, omega: f64) -> f64 {
    machine.damping.mass + machine.damping.stiffness * omega * omega
}

/// Nonzero values divided by their sum, by element index.
fn shares(values: Vec<f64>) -> Vec<(usize, f64)> {
    let total: f64 = values.iter().sum();
    values
        .into_iter()
        .enumerate()
        .filter(|&(_, v)| v != 0.0 && total != 0.0)
        .map(|(e, v)| (e, v / total))
        .collect()
}

/// Index and share of the element with the largest share.
pub fn dominant_element(shares: &[(usize, f64)]) -> Option<(usize, f64)> {
    shares.iter().copied().max_by(|a, b| a.1.total_cmp(&b.1))
}
