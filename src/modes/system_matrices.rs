//! System matrices over chosen coordinates: `M r̈ + C ṙ + K r = Tᵀ f`, `p = T r`.
//!
//! Every matrix is the sum of the projected terms of masses and branches, `Σ k (Tᵀu)(Tᵀw)ᵀ`. No full matrix is formed and
//! projected: K stays a sum of squares, and its rigid-body terms are zero to rounding.

use super::modal_basis::{ModalBasis, column, project_direction, project_with_zeros};
use super::modal_matrices;
use crate::machine::components::Machine;
use crate::machine::linear::LinearModel;
use crate::machine::spin::SpinTerms;
use crate::numeric::vector_ops::add_outer;
use crate::numeric::{Complex, ComplexMatrix, Matrix};

/// Linear machine with the undamped modes and the mean speeds that its system matrices depend on.
#[derive(Clone, Copy)]
pub struct AnalysisContext<'a> {
    /// Machine with its components.
    pub machine: &'a Machine,
    /// Linear model of the machine.
    pub model: &'a LinearModel,
    /// Undamped modes; modal damping refers to them.
    pub basis: &'a ModalBasis,
    /// Mean speed of every degree of freedom, rad/s, for the gyroscopic terms; absent at rest.
    pub speeds: Option<&'a [f64]>,
}

/// Dense matrices of the equations of motion in the coordinates r.
#[derive(Debug, Clone)]
pub struct SystemMatrices {
    /// Transformation T to the independent coordinates, `p = T r`.
    pub transform: Matrix,
    /// Mass matrix M.
    pub mass: Matrix,
    /// Damping matrix C, with the gyroscopic terms.
    pub damping: Matrix,
    /// Stiffness matrix K, with the centripetal and circulatory terms.
    pub stiffness: Matrix,
    /// Hysteretic matrix H of the loss factors, `K + i sgn(ω) H`; absent without loss factors.
    pub hysteretic: Option<Matrix>,
    /// Names of the coordinates.
    pub names: Vec<String>,
    /// Indices of the coordinates without inertia.
    pub massless: Vec<usize>,
}

impl SystemMatrices {
    /// Matrices in the physical displacements of the degrees of freedom of [`reference_dofs`].
    pub fn physical(context: &AnalysisContext) -> SystemMatrices {
        let dofs = reference_dofs(context.model);
        let names = dofs
            .iter()
            .map(|&(dof, _)| context.machine.dof_name(dof))
            .collect();
        let n = context.model.n;
        let transform = Matrix::from_fn(n, n, |i, j| if i == j { 1.0 / dofs[j].1 } else { 0.0 });
        SystemMatrices::in_basis(context, transform, names, 0)
    }

    /// Matrices in mass-normalised modal and massless coordinates; low natural frequencies keep their relative accuracy.
    pub fn modal(context: &AnalysisContext) -> SystemMatrices {
        let modal = modal_matrices::project(
            context.machine,
            context.model,
            context.basis,
            context.speeds,
            true,
        );
        let n = modal.n_modes + modal.n_massless;
        let massless_names = context
            .model
            .massless
            .iter()
            .map(|&j| context.machine.dof_name(context.model.independent_dofs[j]));
        SystemMatrices {
            transform: modal.shapes,
            mass: Matrix::from_fn(n, n, |i, j| {
                if i == j && i < modal.n_modes {
                    1.0
                } else {
                    0.0
                }
            }),
            damping: modal.damping,
            stiffness: modal.stiffness,
            hysteretic: modal.hysteretic,
            names: (1..=modal.n_modes)
                .map(|k| format!("mode {k}"))
                .chain(massless_names.map(|name| format!("{name} beyond modes")))
                .collect(),
            massless: (modal.n_modes..n).collect(),
        }
    }

    /// Matrices in the columns of T, the first `n_rigid` of which are rigid-body modes. Their rows of K are exactly zero, and
    /// those of C for the modes without damping.
    pub fn in_basis(
        context: &AnalysisContext,
        transform: Matrix,
        names: Vec<String>,
        n_rigid: usize,
    ) -> SystemMatrices {
        let n = transform.ncols();
        let mut matrices = SystemMatrices {
            mass: Matrix::zeros(n, n),
            damping: Matrix::zeros(n, n),
            stiffness: Matrix::zeros(n, n),
            hysteretic: None,
            names,
            massless: Vec::new(),
            transform,
        };
        for mass in &context.model.masses {
            let v = project_direction(&mass.direction, &matrices.transform);
            add_outer(&mut matrices.mass, mass.value, &v, &v, 0);
        }
        matrices.massless = (0..n).filter(|&i| matrices.mass[(i, i)] == 0.0).collect();
        matrices.add_branches(context, n_rigid);
        matrices.add_global(context);
        if let Some(speeds) = context.speeds {
            let terms = SpinTerms::new(context.machine, context.model, speeds, true);
            matrices.add_gyroscopic(&terms, n_rigid);
        }
        matrices
    }

    /// Number of coordinates.
    pub fn len(&self) -> usize {
        self.mass.nrows()
    }

    /// True without coordinates.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// True if the symmetric part of C or H is not zero.
    pub fn is_dissipative(&self) -> bool {
        let n = self.len();
        let is_damped =
            (0..n).any(|i| (0..n).any(|j| self.damping[(i, j)] + self.damping[(j, i)] != 0.0));
        is_damped || self.hysteretic.is_some()
    }

    /// Dynamic stiffness `s² M + s C + K + i sgn(Im s) H`.
    pub fn dynamic_stiffness(&self, s: Complex) -> ComplexMatrix {
        let sign = if s.im == 0.0 { 0.0 } else { s.im.signum() };
        ComplexMatrix::from_fn(self.len(), self.len(), |i, j| {
            let hysteretic_stiffness = self.hysteretic.as_ref().map_or(0.0, |h| sign * h[(i, j)]);
            s * s * self.mass[(i, j)]
                + s * self.damping[(i, j)]
                + Complex::new(self.stiffness[(i, j)], hysteretic_stiffness)
        })
    }

    /// Projection `Tᵀ p` of a direction in the independent coordinates.
    pub fn project(&self, p: &[(usize, f64)]) -> Vec<f64> {
        (0..self.len())
            .map(|j| p.iter().map(|&(i, a)| a * self.transform[(i, j)]).sum())
            .collect()
    }

    fn add_branches(&mut self, context: &AnalysisContext, n_rigid: usize) {
        for branch in &context.model.branches {
            let mut w = project_direction(&branch.direction, &self.transform);
            let n_zero = if branch.stiffness != 0.0 {
                n_rigid
            } else {
                n_rigid.min(context.model.n_undamped_rigid)
            };
            w.iter_mut().take(n_zero).for_each(|x| *x = 0.0);
            let u = match &branch.force {
                Some(force) => project_direction(force, &self.transform),
                None => w.clone(),
            };
            add_outer(&mut self.stiffness, branch.stiffness, &u, &w, 0);
            add_outer(&mut self.damping, branch.damping, &u, &w, 0);
            if branch.loss_factor != 0.0 {
                let n = w.len();
                let hysteretic = self.hysteretic.get_or_insert_with(|| Matrix::zeros(n, n));
                add_outer(hysteretic, branch.loss_factor * branch.stiffness, &u, &w, 0);
            }
        }
    }

    /// Adds the gyroscopic, centripetal and circulatory terms; the first `n_rigid` coordinates are rigid-body modes.
    pub fn add_gyroscopic(&mut self, terms: &SpinTerms, n_rigid: usize) {
        for (a, b, g) in &terms.gyroscopic {
            let (a, b) = (
                project_direction(a, &self.transform),
                project_direction(b, &self.transform),
            );
            add_outer(&mut self.damping, *g, &a, &b, 0);
            add_outer(&mut self.damping, -g, &b, &a, 0);
        }
        for (v, m) in &terms.centripetal {
            let v = project_with_zeros(v, &self.transform, n_rigid);
            add_outer(&mut self.stiffness, -m, &v, &v, 0);
        }
        for (u, w, c) in &terms.circulatory {
            let (u, w) = (
                project_direction(u, &self.transform),
                project_direction(w, &self.transform),
            );
            add_outer(&mut self.stiffness, *c, &u, &w, 0);
        }
    }

    /// Rayleigh damping `αM + βK`, and modal damping `Σ 2ζω (Mφ)(Mφ)ᵀ`.
    fn add_global(&mut self, context: &AnalysisContext) {
        let global = &context.machine.damping;
        let n = self.len();
        for i in 0..n {
            for j in 0..n {
                let symmetric = (self.stiffness[(i, j)] + self.stiffness[(j, i)]) / 2.0;
                self.damping[(i, j)] +=
                    global.mass * self.mass[(i, j)] + global.stiffness * symmetric;
            }
        }
        for (k, mode) in (context.basis.n_rigid..context.basis.omega.len()).enumerate() {
            let zeta = global
                .modal
                .get(k)
                .or(global.modal.last())
                .copied()
                .unwrap_or(0.0);
            if zeta == 0.0 {
                continue;
            }
            let shape = column(&context.basis.shapes, mode);
            let mut momentum = vec![0.0; n];
            for mass in &context.model.masses {
                let p = mass.value * mass.direction.dot(&shape);
                momentum
                    .iter_mut()
                    .zip(project_direction(&mass.direction, &self.transform))
                    .for_each(|(m, v)| *m += p * v);
            }
            add_outer(
                &mut self.damping,
                2.0 * zeta * context.basis.omega[mode],
                &momentum,
                &momentum,
                0,
            );
        }
    }
}

/// Reference degree of freedom of each independent coordinate p, with the factor a of `q = a p`: the first one that depends on p
/// alone; in a rigid gear pair the first gear.
pub fn reference_dofs(model: &LinearModel) -> Vec<(usize, f64)> {
    let reference = |j: usize| {
        let follows_only = |row: &Vec<(usize, f64)>| matches!(row[..], [(i, _)] if i == j);
        let dof = model
            .transform
            .iter()
            .position(follows_only)
            .unwrap_or(model.independent_dofs[j]);
        (dof, model.transform[dof].first().map_or(1.0, |t| t.1))
    };
    (0..model.n).map(reference).collect()
}
