//! System matrices over chosen coordinates: `M r̈ + C ṙ + K r = Tᵀ f`, `p = T r`.
//!
//! Every matrix is summed from what masses and branches see of the coordinates, `Σ k (Tᵀu)(Tᵀw)ᵀ`; no large matrix is
//! formed and then projected, so that K stays a sum of squares and rigid motions cost it nothing but rounding.

use super::modal_basis::{ModalBasis, column, project_direction, seen_by_rigid};
use super::modal_matrices;
use crate::machine::components::Machine;
use crate::machine::linear::LinearModel;
use crate::machine::spin::SpinTerms;
use crate::numeric::vector_ops::add_outer;
use crate::numeric::{Complex, ComplexMatrix, Matrix};

/// A linear machine with all that its equations depend on.
#[derive(Clone, Copy)]
pub struct AnalysisContext<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// The same, linear.
    pub model: &'a LinearModel,
    /// Undamped modes of the machine; modal damping refers to them.
    pub basis: &'a ModalBasis,
    /// Mean speed of every degree of freedom, rad/s, for gyroscopic terms; absent: at rest.
    pub speeds: Option<&'a [f64]>,
}

/// Dense equations of motion.
#[derive(Debug, Clone)]
pub struct SystemMatrices {
    /// T: the independent coordinates, `p = T r`.
    pub transform: Matrix,
    /// M.
    pub mass: Matrix,
    /// C, with gyroscopic terms.
    pub damping: Matrix,
    /// K, with centripetal and circulatory terms.
    pub stiffness: Matrix,
    /// H of loss factors, `K + i sgn(ω) H`, where there are any.
    pub hysteretic: Option<Matrix>,
    /// Names of the coordinates.
    pub names: Vec<String>,
    /// Coordinates without inertia.
    pub massless: Vec<usize>,
}

impl SystemMatrices {
    /// Over the degrees of freedom of [`reference_dofs`], as displacements of the machine.
    pub fn physical(context: &AnalysisContext) -> SystemMatrices {
        let chosen = reference_dofs(context.model);
        let names = chosen
            .iter()
            .map(|&(dof, _)| context.machine.dof_name(dof))
            .collect();
        let n = context.model.n;
        let transform = Matrix::from_fn(n, n, |i, j| if i == j { 1.0 / chosen[j].1 } else { 0.0 });
        SystemMatrices::in_basis(context, transform, names, 0)
    }

    /// Over mass-normalised modes, and what massless coordinates move beyond them. Small frequencies keep their digits.
    pub fn modal(context: &AnalysisContext) -> SystemMatrices {
        let modal = modal_matrices::project(
            context.machine,
            context.model,
            context.basis,
            context.speeds,
            true,
        );
        let n = modal.n_modes + modal.n_massless;
        let light = context
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
                .chain(light.map(|name| format!("{name} beyond modes")))
                .collect(),
            massless: (modal.n_modes..n).collect(),
        }
    }

    /// Over the columns of T, the first `n_rigid` of which are the machine's rigid motions: what strains nothing is exactly
    /// zero in K, and in C for those that no damper resists.
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

    /// There are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Something loses energy.
    pub fn is_dissipative(&self) -> bool {
        let n = self.len();
        let braked =
            (0..n).any(|i| (0..n).any(|j| self.damping[(i, j)] + self.damping[(j, i)] != 0.0));
        braked || self.hysteretic.is_some()
    }

    /// `s² M + s C + K + i sgn(Im s) H`.
    pub fn dynamic_stiffness(&self, s: Complex) -> ComplexMatrix {
        let sign = if s.im == 0.0 { 0.0 } else { s.im.signum() };
        ComplexMatrix::from_fn(self.len(), self.len(), |i, j| {
            let lossy = self.hysteretic.as_ref().map_or(0.0, |h| sign * h[(i, j)]);
            s * s * self.mass[(i, j)]
                + s * self.damping[(i, j)]
                + Complex::new(self.stiffness[(i, j)], lossy)
        })
    }

    /// A direction over the independent coordinates, seen by the columns of T.
    pub fn project(&self, p: &[(usize, f64)]) -> Vec<f64> {
        (0..self.len())
            .map(|j| p.iter().map(|&(i, a)| a * self.transform[(i, j)]).sum())
            .collect()
    }

    fn add_branches(&mut self, context: &AnalysisContext, n_rigid: usize) {
        for branch in &context.model.branches {
            let mut along = project_direction(&branch.direction, &self.transform);
            let still = if branch.stiffness != 0.0 {
                n_rigid
            } else {
                n_rigid.min(context.model.n_undamped_rigid)
            };
            along.iter_mut().take(still).for_each(|x| *x = 0.0);
            let acts = match &branch.force {
                Some(force) => project_direction(force, &self.transform),
                None => along.clone(),
            };
            add_outer(&mut self.stiffness, branch.stiffness, &acts, &along, 0);
            add_outer(&mut self.damping, branch.damping, &acts, &along, 0);
            if branch.loss_factor != 0.0 {
                let n = along.len();
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

    /// Adds the terms of mean speeds; the first `n_rigid` coordinates are rigid motions.
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
            let v = seen_by_rigid(v, &self.transform, n_rigid);
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

/// For each coordinate that stays the first degree of freedom of the file that follows it alone, and `a` in `q = a p`: of a
/// rigid gear pair the first gear.
pub fn reference_dofs(model: &LinearModel) -> Vec<(usize, f64)> {
    let of = |j: usize| {
        let alone = |row: &Vec<(usize, f64)>| matches!(row[..], [(i, _)] if i == j);
        let first = model
            .transform
            .iter()
            .position(alone)
            .unwrap_or(model.independent_dofs[j]);
        (first, model.transform[first].first().map_or(1.0, |t| t.1))
    };
    (0..model.n).map(of).collect()
}
