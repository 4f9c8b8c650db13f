//! Stick constraints `W q̇ = ė`: velocity imposed by sticking pairs, and their constraint forces λ.

use super::inputs::InputTarget;
use super::linear_law::LinearLaw;
use super::mass_normalised::{RegimeModes, dot, to_dense};
use super::modal_transform::ModalTransform;
use super::run_context::RunContext;
use crate::base::error::Error;
use crate::motion::friction::FrictionState;
use crate::numeric::vector_ops::axpy;
use crate::numeric::{Matrix, symmetric};

/// Constraint of the sticking friction pairs.
#[derive(Debug)]
pub struct StickConstraint {
    /// Indices of the sticking branches.
    branches: Vec<usize>,
    /// Velocities q̇ per unit relative velocity of each pair, in columns: `M⁻¹Wᵀ(W M⁻¹Wᵀ)⁺`.
    velocities: Matrix,
    /// Constraint force of each pair per force on q, in rows: `(W M⁻¹Wᵀ)⁺ W M⁻¹`.
    reactions: Vec<Vec<f64>>,
    /// Input of σ per imposed displacement q.
    pub from_displacement: Matrix,
    /// Input of σ per imposed velocity q̇.
    pub from_velocity: Matrix,
}

/// Breakaway reserve of a sticking pair as a linear function of the state, N or N·m.
#[derive(Debug)]
pub struct StickReserve {
    /// Constant term.
    pub constant: f64,
    /// Coefficients of q.
    pub displacement: Vec<f64>,
    /// Coefficients of q̇.
    pub velocity: Vec<f64>,
    /// Coefficients of z.
    pub inner: Vec<f64>,
    /// Input indices with the coefficients of their value and rate.
    pub direct: Vec<(usize, [f64; 2])>,
}

impl StickConstraint {
    /// Constraint of the given sticking branches.
    ///
    /// # Errors
    /// Overflow of the constraint matrix.
    pub fn new(
        context: &RunContext,
        laws: &[LinearLaw],
        branches: &[usize],
        modes: &RegimeModes,
        transform: &ModalTransform,
        len: usize,
    ) -> Result<StickConstraint, Error> {
        let model = context.model;
        let (n, s) = (model.coordinate_count(), branches.len());
        let rows: Vec<Vec<f64>> = branches
            .iter()
            .map(|&index| to_dense(&model.elements[index].direction, n))
            .collect();
        let inverse_mass_w: Vec<Vec<f64>> = rows
            .iter()
            .map(|row| {
                let mut w = row.clone();
                model.apply_inverse_mass(&mut w);
                w
            })
            .collect();
        let mobility = Matrix::from_fn(s, s, |i, j| dot(&rows[i], &inverse_mass_w[j]));
        let mut inverse = Matrix::zeros(s, s);
        for j in 0..s {
            let unit: Vec<f64> = (0..s).map(|i| f64::from(u8::from(i == j))).collect();
            let column = symmetric::solve_semidefinite(&mobility, &unit)?;
            (0..s).for_each(|i| inverse[(i, j)] = column[i]);
        }
        let reactions: Vec<Vec<f64>> = (0..s)
            .map(|i| {
                (0..n)
                    .map(|k| (0..s).map(|j| inverse[(i, j)] * inverse_mass_w[j][k]).sum())
                    .collect()
            })
            .collect();
        let velocities = Matrix::from_fn(n, s, |k, i| reactions[i][k]);

        let (stiffness, damping, internal) = forces(context, laws);
        let m = modes.count();
        let modal = |matrix: &Matrix, internal: Option<&Matrix>| {
            let projected = modes.shapes.transpose() * matrix;
            let mut out = Matrix::zeros(len, n);
            for k in 0..n {
                let mut input = vec![0.0; 2 * m + model.internal_count()];
                (0..m).for_each(|j| input[m + j] = -projected[(j, k)]);
                if let Some(internal) = internal {
                    (0..model.internal_count()).for_each(|z| input[2 * m + z] = internal[(z, k)]);
                }
                let mut sigma = vec![0.0; len];
                transform.to_parts(&input, &mut sigma);
                (0..len).for_each(|i| out[(i, k)] = sigma[i]);
            }
            out
        };
        Ok(StickConstraint {
            branches: branches.to_vec(),
            from_displacement: modal(&stiffness, None),
            from_velocity: modal(&damping, Some(&internal)),
            velocities,
            reactions,
        })
    }

    /// Imposed velocity q̇ from the relative velocity of each pair.
    pub fn imposed_velocity(&self, rates: impl Fn(usize) -> f64, out: &mut [f64]) {
        out.fill(0.0);
        for (i, &branch) in self.branches.iter().enumerate() {
            axpy(out, rates(branch), self.velocities.col_as_slice(i));
        }
    }

    /// Remaining breakaway force of a sticking pair in the slip direction `slip`.
    ///
    /// # Errors
    /// None at present.
    pub fn breakaway_reserve(
        &self,
        context: &RunContext,
        laws: &[LinearLaw],
        branch: usize,
        breakaway: f64,
        slip: FrictionState,
    ) -> Result<StickReserve, Error> {
        let model = context.model;
        let n = model.coordinate_count();
        let zero = vec![0.0; n];
        let index = self.branches.iter().position(|&i| i == branch);
        let reactions = index.map_or(&zero, |i| &self.reactions[i]);
        let sign = -slip.sign();
        let (stiffness, damping, _) = forces(context, laws);
        // λ = reactions · (d f − u F − α M q̇)
        let weights = |a: &Matrix| -> Vec<f64> {
            (0..n)
                .map(|j| -sign * (0..n).map(|i| reactions[i] * a[(i, j)]).sum::<f64>())
                .collect()
        };
        let (displacement, mut velocity) = (weights(&stiffness), weights(&damping));
        let momentum = model.momentum(reactions);
        (0..n).for_each(|j| velocity[j] -= sign * model.mass_damping * momentum[j]);
        let p = |i: usize| model.elements[i].force_direction().dot(reactions);
        let mut constant = breakaway;
        let mut internal = Vec::new();
        for (i, law) in laws.iter().enumerate() {
            constant -= sign * law.force.constant * p(i);
            internal.extend(law.inner.iter().map(|z| -sign * z.force * p(i)));
        }
        let direct = context.inputs.list.iter().enumerate();
        let direct = direct.map(|(number, input)| match input.entry {
            InputTarget::Drive(i) => {
                let factor = sign * model.forces[i].direction.dot(reactions);
                (number, [factor, 0.0])
            }
            InputTarget::Imposed(i) => {
                let law = &laws[i].force;
                let factor = sign * p(i);
                (number, [factor * law.deflection, factor * law.rate])
            }
        });
        Ok(StickReserve {
            constant,
            displacement,
            velocity,
            inner: internal,
            direct: direct.collect(),
        })
    }
}

/// Matrices K and C with the global terms, without mass-proportional damping, and the input matrix of the internal states over q̇.
fn forces(context: &RunContext, laws: &[LinearLaw]) -> (Matrix, Matrix, Matrix) {
    let model = context.model;
    let n = model.coordinate_count();
    let (mut stiffness, mut damping) = match &model.global_matrices {
        Some((k, c)) => (k.clone(), c.clone()),
        None => (Matrix::zeros(n, n), Matrix::zeros(n, n)),
    };
    let mut internal = Matrix::zeros(model.internal_count(), n);
    let mut next = 0;
    for (branch, law) in model.elements.iter().zip(laws) {
        for (i, u) in branch.force_direction().entries() {
            for (j, w) in branch.direction.entries() {
                stiffness[(i, j)] += law.force.deflection * u * w;
                damping[(i, j)] += law.force.rate * u * w;
            }
        }
        if let Some(state) = &law.inner {
            branch
                .direction
                .entries()
                .for_each(|(j, w)| internal[(next, j)] += state.seen * w);
            next += 1;
        }
    }
    (stiffness, damping, internal)
}
