//! Stick constraints: velocity kept by sticking pairs, and their constraint forces.

use super::inputs::InputTarget;
use super::linear_law::LinearLaw;
use super::mass_normalised::{RegimeModes, dot, to_dense};
use super::modal_transform::ModalTransform;
use super::run_context::RunContext;
use crate::base::error::Error;
use crate::motion::friction::FrictionState;
use crate::numeric::vector_ops::axpy;
use crate::numeric::{Matrix, symmetric};

/// Pairs that stick.
#[derive(Debug)]
pub struct StickConstraint {
    /// Their branches.
    stuck: Vec<usize>,
    /// `M⁻¹Wᵀ(W M⁻¹Wᵀ)⁺`, a column for each: the rates of q that they are carried along with.
    carried: Matrix,
    /// `(W M⁻¹Wᵀ)⁺ W M⁻¹`, a row for each: what they hold per force on q.
    holds: Vec<Vec<f64>>,
    /// Push on σ per kept q and per kept q̇.
    pub from_place: Matrix,
    /// The same per kept q̇.
    pub from_rate: Matrix,
}

/// A switching surface of a stuck pair over the state: what is left before it breaks away.
#[derive(Debug)]
pub struct StickReserve {
    /// Constant term.
    pub constant: f64,
    /// Over q.
    pub place: Vec<f64>,
    /// Over q̇.
    pub rate: Vec<f64>,
    /// Over z.
    pub inner: Vec<f64>,
    /// Inputs, with what their value and their rate count.
    pub direct: Vec<(usize, [f64; 2])>,
}

impl StickConstraint {
    /// Stick constraint of the sticking branches.
    ///
    /// # Errors
    /// Numbers out of range.
    pub fn new(
        context: &RunContext,
        laws: &[LinearLaw],
        stuck: &[usize],
        modes: &RegimeModes,
        stage: &ModalTransform,
        len: usize,
    ) -> Result<StickConstraint, Error> {
        let model = context.model;
        let (n, s) = (model.coordinate_count(), stuck.len());
        let rows: Vec<Vec<f64>> = stuck
            .iter()
            .map(|&at| to_dense(&model.elements[at].direction, n))
            .collect();
        let lighter: Vec<Vec<f64>> = rows
            .iter()
            .map(|row| {
                let mut w = row.clone();
                model.apply_inverse_mass(&mut w);
                w
            })
            .collect();
        let mobility = Matrix::from_fn(s, s, |i, j| dot(&rows[i], &lighter[j]));
        let mut inverse = Matrix::zeros(s, s);
        for j in 0..s {
            let unit: Vec<f64> = (0..s).map(|i| f64::from(u8::from(i == j))).collect();
            let column = symmetric::solve_semidefinite(&mobility, &unit)?;
            (0..s).for_each(|i| inverse[(i, j)] = column[i]);
        }
        let holds: Vec<Vec<f64>> = (0..s)
            .map(|i| {
                (0..n)
                    .map(|k| (0..s).map(|j| inverse[(i, j)] * lighter[j][k]).sum())
                    .collect()
            })
            .collect();
        let carried = Matrix::from_fn(n, s, |k, i| holds[i][k]);

        let (stiffness, damping, inner) = forces(context, laws);
        let m = modes.count();
        let modal = |matrix: &Matrix, inner: Option<&Matrix>| {
            let over = modes.shapes.transpose() * matrix;
            let mut out = Matrix::zeros(len, n);
            for k in 0..n {
                let mut push = vec![0.0; 2 * m + model.internal_count()];
                (0..m).for_each(|j| push[m + j] = -over[(j, k)]);
                if let Some(inner) = inner {
                    (0..model.internal_count()).for_each(|z| push[2 * m + z] = inner[(z, k)]);
                }
                let mut sigma = vec![0.0; len];
                stage.to_parts(&push, &mut sigma);
                (0..len).for_each(|i| out[(i, k)] = sigma[i]);
            }
            out
        };
        Ok(StickConstraint {
            stuck: stuck.to_vec(),
            from_place: modal(&stiffness, None),
            from_rate: modal(&damping, Some(&inner)),
            carried,
            holds,
        })
    }

    /// The rates of q that are kept, from the rates imposed on each pair.
    pub fn imposed_velocity(&self, rates: impl Fn(usize) -> f64, out: &mut [f64]) {
        out.fill(0.0);
        for (i, &at) in self.stuck.iter().enumerate() {
            axpy(out, rates(at), self.carried.col_as_slice(i));
        }
    }

    /// Remaining breakaway force of a stuck pair in the sense of `slip`.
    ///
    /// # Errors
    /// None; laws were read before.
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
        let own = self.stuck.iter().position(|&at| at == branch);
        let holds = own.map_or(&zero, |i| &self.holds[i]);
        let sign = -slip.sign();
        let (stiffness, damping, _) = forces(context, laws);
        // λ = holds · (d f − u F − α M q̇)
        let over = |a: &Matrix| -> Vec<f64> {
            (0..n)
                .map(|j| -sign * (0..n).map(|i| holds[i] * a[(i, j)]).sum::<f64>())
                .collect()
        };
        let (place, mut rate) = (over(&stiffness), over(&damping));
        let momentum = model.momentum(holds);
        (0..n).for_each(|j| rate[j] -= sign * model.mass_damping * momentum[j]);
        let along = |at: usize| model.elements[at].force_direction().dot(holds);
        let mut constant = breakaway;
        let mut inner = Vec::new();
        for (at, law) in laws.iter().enumerate() {
            constant -= sign * law.force.constant * along(at);
            inner.extend(law.inner.iter().map(|own| -sign * own.force * along(at)));
        }
        let direct = context.inputs.list.iter().enumerate();
        let direct = direct.map(|(number, input)| match input.entry {
            InputTarget::Drive(at) => {
                let per = sign * model.forces[at].direction.dot(holds);
                (number, [per, 0.0])
            }
            InputTarget::Imposed(at) => {
                let law = &laws[at].force;
                let per = sign * along(at);
                (number, [per * law.deflection, per * law.rate])
            }
        });
        Ok(StickReserve {
            constant,
            place,
            rate,
            inner,
            direct: direct.collect(),
        })
    }
}

/// K, C over q with what belongs to no branch, drag left out, and what inner states see of q̇.
fn forces(context: &RunContext, laws: &[LinearLaw]) -> (Matrix, Matrix, Matrix) {
    let model = context.model;
    let n = model.coordinate_count();
    let (mut stiffness, mut damping) = match &model.unattached {
        Some((k, c)) => (k.clone(), c.clone()),
        None => (Matrix::zeros(n, n), Matrix::zeros(n, n)),
    };
    let mut inner = Matrix::zeros(model.internal_count(), n);
    let mut next = 0;
    for (branch, law) in model.elements.iter().zip(laws) {
        for (i, u) in branch.force_direction().entries() {
            for (j, w) in branch.direction.entries() {
                stiffness[(i, j)] += law.force.deflection * u * w;
                damping[(i, j)] += law.force.rate * u * w;
            }
        }
        if let Some(own) = &law.inner {
            branch
                .direction
                .entries()
                .for_each(|(j, w)| inner[(next, j)] += own.seen * w);
            next += 1;
        }
    }
    (stiffness, damping, inner)
}
