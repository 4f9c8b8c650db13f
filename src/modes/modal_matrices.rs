//! Damping, gyroscopic and unsymmetric terms projected on the undamped modes.
//!
//! With `p = Φ η + E d`, Φ the undamped modes (massless coordinates following statically) and d what the massless
//! coordinates move beyond that, the elastic energy is `½ Σ ω² η² + ½ dᵀ K₀₀ d` without coupling, so that small
//! frequencies keep their digits. Then `I η̈ + C̃ (η̇, ḋ) + (K̃ + i sgn(Im λ) H̃)(η, d) = 0`.

use super::modal_basis::{ModalBasis, project_direction, project_with_zeros};
use crate::machine::components::Machine;
use crate::machine::direction::Direction;
use crate::machine::linear::LinearModel;
use crate::machine::spin::SpinTerms;
use crate::numeric::vector_ops::add_outer;
use crate::numeric::{Matrix, symmetric};

/// Matrices over `(η, d)`.
#[derive(Debug, Clone)]
pub struct ModalMatrices {
    /// Modes.
    pub n_modes: usize,
    /// Coordinates without inertia.
    pub n_massless: usize,
    /// C̃ + G̃.
    pub damping: Matrix,
    /// K̃.
    pub stiffness: Matrix,
    /// H̃ of loss factors, where there are any.
    pub hysteretic: Option<Matrix>,
    /// `Z = [Φ, E]`, over the independent coordinates.
    pub shapes: Matrix,
}

/// Projects a machine on its undamped modes, at the mean speeds given (rad/s by degree of freedom).
pub fn project(
    machine: &Machine,
    model: &LinearModel,
    basis: &ModalBasis,
    speeds: Option<&[f64]>,
    damped: bool,
) -> ModalMatrices {
    let (n_modes, n_light) = (basis.omega.len(), model.massless.len());
    let n = n_modes + n_light;
    let mut shapes = Matrix::zeros(model.n, n);
    for j in 0..n_modes {
        (0..model.n).for_each(|i| shapes[(i, j)] = basis.shapes[(i, j)]);
    }
    for (at, &i) in model.massless.iter().enumerate() {
        shapes[(i, n_modes + at)] = 1.0;
    }
    let mut modal = ModalMatrices {
        n_modes,
        n_massless: n_light,
        damping: Matrix::zeros(n, n),
        stiffness: Matrix::zeros(n, n),
        hysteretic: None,
        shapes,
    };
    for (j, omega) in basis.omega.iter().enumerate() {
        modal.stiffness[(j, j)] = omega * omega;
    }
    let terms = speeds.map(|speeds| SpinTerms::new(machine, model, speeds, damped));
    let n_turning = match &terms {
        Some(terms) => modal.split_rigid(&terms.centripetal, model.n_undamped_rigid),
        None => 0,
    };
    modal.add_branches(model, basis, damped);
    if damped {
        modal.add_global(machine, basis);
    }
    if let Some(terms) = &terms {
        modal.add_spins(terms, basis.n_rigid, n_turning);
    }
    modal
}

/// `(|G_j| + |K_j|/ω_j) / 2 ω_j` of the mode where it is largest: the share of its frequency that pairs of modes may shift by.
pub fn largest_spin_shift(terms: &SpinTerms, basis: &ModalBasis) -> f64 {
    let n = basis.omega.len();
    let (mut turning, mut pulling) = (vec![0.0f64; n], vec![0.0f64; n]);
    for (a, b, g) in &terms.gyroscopic {
        let (a, b) = (
            project_direction(a, &basis.shapes),
            project_direction(b, &basis.shapes),
        );
        let length = |v: &[f64]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        let (long_a, long_b) = (length(&a), length(&b));
        for j in 0..n {
            turning[j] += g.abs() * (a[j].abs() * long_b).max(b[j].abs() * long_a);
        }
    }
    for (v, m) in &terms.centripetal {
        for (j, x) in project_direction(v, &basis.shapes).into_iter().enumerate() {
            pulling[j] += m * x * x;
        }
    }
    let share = |j: usize| (turning[j] + pulling[j] / basis.omega[j]) / (2.0 * basis.omega[j]);
    (basis.n_rigid..n).map(share).fold(0.0, f64::max)
}

impl ModalMatrices {
    /// Something loses energy: the symmetric part of C̃, or H̃, is not nil.
    pub fn is_dissipative(&self) -> bool {
        let n = self.damping.nrows();
        let braked =
            (0..n).any(|i| (0..n).any(|j| self.damping[(i, j)] + self.damping[(j, i)] != 0.0));
        braked || self.hysteretic.is_some()
    }

    fn add_branches(&mut self, model: &LinearModel, basis: &ModalBasis, damped: bool) {
        let undamped_rigid = model.n_undamped_rigid;
        for branch in &model.branches {
            let squared = branch.stiffness >= 0.0 && branch.force.is_none();
            let mut along = project_direction(&branch.direction, &self.shapes);
            // What strains nothing is exactly zero, not rounding.
            let still = if branch.stiffness != 0.0 {
                basis.n_rigid
            } else {
                undamped_rigid
            };
            along.iter_mut().take(still).for_each(|x| *x = 0.0);
            let acts = match &branch.force {
                Some(force) => project_direction(force, &self.shapes),
                None => along.clone(),
            };
            let light = self.n_modes;
            if squared {
                add_outer(&mut self.stiffness, branch.stiffness, &acts, &along, light);
            } else {
                add_outer(&mut self.stiffness, branch.stiffness, &acts, &along, 0);
            }
            if damped && branch.damping != 0.0 {
                add_outer(&mut self.damping, branch.damping, &acts, &along, 0);
            }
            if damped && branch.loss_factor != 0.0 {
                let n = self.n_modes + self.n_massless;
                let hysteretic = self.hysteretic.get_or_insert_with(|| Matrix::zeros(n, n));
                add_outer(
                    hysteretic,
                    branch.loss_factor * branch.stiffness,
                    &acts,
                    &along,
                    0,
                );
            }
        }
    }

    /// Combines the first `n` rigid modes so that those without a centripetal term come first; how many these are.
    ///
    /// Any combination of rigid modes is one; where bodies float, a turn mixed with a translation would share its terms.
    fn split_rigid(&mut self, terms: &[(Direction, f64)], n: usize) -> usize {
        const NONE: f64 = 1e-12; // of the largest; rigid modes are known to some ε
        let mut form = Matrix::zeros(n, n);
        for (v, m) in terms {
            let v = project_with_zeros(v, &self.shapes, n);
            add_outer(&mut form, *m, &v[..n], &v[..n], 0);
        }
        let without = (0..n).filter(|&i| form[(i, i)] == 0.0).count();
        let Ok(split) = symmetric::symmetric_eigen(&form) else {
            return 0;
        };
        let largest = split.values.last().copied().unwrap_or(0.0);
        let null = split.values.iter().take_while(|x| **x <= NONE * largest);
        let n_turning = null.count();
        if without < n_turning {
            let rigid = self.shapes.subcols(0, n) * &split.vectors;
            self.shapes.subcols_mut(0, n).copy_from(rigid);
            return n_turning;
        }
        0
    }

    fn add_spins(&mut self, terms: &SpinTerms, n_rigid: usize, n_turning: usize) {
        for (a, b, g) in &terms.gyroscopic {
            let (a, b) = (
                project_direction(a, &self.shapes),
                project_direction(b, &self.shapes),
            );
            add_skew(&mut self.damping, *g, &a, &b);
        }
        for (v, m) in &terms.centripetal {
            let mut v = project_with_zeros(v, &self.shapes, n_rigid);
            v[..n_turning].fill(0.0);
            add_outer(&mut self.stiffness, -m, &v, &v, 0);
        }
        for (u, w, c) in &terms.circulatory {
            let (u, w) = (
                project_direction(u, &self.shapes),
                project_direction(w, &self.shapes),
            );
            add_outer(&mut self.stiffness, *c, &u, &w, 0);
        }
    }

    /// Rayleigh damping `αM + βK` and modal damping `2ζω`.
    fn add_global(&mut self, machine: &Machine, basis: &ModalBasis) {
        let global = &machine.damping;
        let n = self.n_modes + self.n_massless;
        for j in 0..self.n_modes {
            self.damping[(j, j)] += global.mass;
            let elastic = j.checked_sub(basis.n_rigid);
            let zeta = elastic
                .and_then(|k| global.modal.get(k).or(global.modal.last()))
                .copied()
                .unwrap_or(0.0);
            self.damping[(j, j)] += 2.0 * zeta * basis.omega[j];
        }
        if global.stiffness != 0.0 {
            for i in 0..n {
                for j in 0..n {
                    self.damping[(i, j)] +=
                        global.stiffness * (self.stiffness[(i, j)] + self.stiffness[(j, i)]) / 2.0;
                }
            }
        }
    }
}

/// `A += value · (a bᵀ − b aᵀ)`, skew to the last bit: what gyrates loses no energy.
fn add_skew(matrix: &mut Matrix, value: f64, a: &[f64], b: &[f64]) {
    for j in 0..a.len() {
        for i in 0..j {
            let entry = value * (a[i] * b[j] - b[i] * a[j]);
            matrix[(i, j)] += entry;
            matrix[(j, i)] -= entry;
        }
    }
}
