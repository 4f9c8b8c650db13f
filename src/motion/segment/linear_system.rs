//! Linear system `σ̇ = Λ σ + β` shared by regimes of equal stiffness, damping and sticking pairs.
//!
//! The flanks of a contact differ by a constant force alone, and so do the sliding directions of a friction pair: one costly
//! eigensolution serves all of them.

use super::equations::{InternalState, ModalDamping, ModalEquations};
use super::inputs::{InputTarget, KnownInputs};
use super::linear_law::LinearLaw;
use super::mass_normalised::{RegimeModes, StrainRows, to_dense};
use super::modal_parts::ModalParts;
use super::modal_transform::ModalTransform;
use super::run_context::RunContext;
use super::stick::StickConstraint;
use super::trajectory::ForcedParts;
use super::{coupled, uncoupled};
use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::motion::dynamic_model::DynamicModel;
use crate::numeric::products::ColumnMatrix;
use crate::numeric::vector_ops::{axpy, gemv};
use crate::numeric::{Complex, Matrix, registers};

/// Linear system of a regime in modal coordinates.
#[derive(Debug)]
pub struct LinearSystem {
    /// Modal parts and harmonics: the states σ are cosine and sine of every harmonic, then the states of the parts.
    pub parts: ForcedParts,
    /// Matrix from `(y, cosine and sine of every harmonic)` to the states of the parts.
    pub to_parts: ColumnMatrix,
    /// Matrix from σ to the state y.
    pub from_parts: ColumnMatrix,
    /// Forcing β of σ per value and per rate of every input.
    pub pushes: Vec<[Vec<f64>; 2]>,
    /// Stick constraint of the sticking pairs.
    pub stick: Option<StickConstraint>,
    /// Modes of the regime.
    pub modes: RegimeModes,
    /// Element directions in modal coordinates.
    pub rows: ModalRows,
    /// Modal parts in closed form, without harmonics.
    pub modal_parts: ModalParts,
    /// Transform between modal states and states of the parts.
    pub transform: ModalTransform,
    /// Steady-state phasors of the parts under every harmonic.
    pub steady: Vec<Vec<Complex>>,
    /// Forcing phasors of every harmonic without steady-state response.
    pub residual_inputs: Vec<Vec<Complex>>,
    /// Linear laws of the branches.
    laws: Vec<LinearLaw>,
}

impl LinearSystem {
    /// Linear system of the branches of a regime.
    ///
    /// # Errors
    /// Numbers out of range; no convergence.
    pub fn new(context: &RunContext, laws: &[LinearLaw]) -> Result<LinearSystem, Error> {
        let model = context.model;
        let modes = RegimeModes::new(
            &context.mass_factor,
            &rows(context, laws),
            model.coordinate_count(),
        )?;
        let rows = ModalRows::new(model, laws, &modes);
        let equations = equations(model, laws, &modes, &rows);

        let raw = input_columns(context, laws, &rows, &modes);
        let harmonics = harmonics(
            &context.inputs,
            &raw,
            2 * modes.count() + model.internal_count(),
        );
        let (spectrum, stage) = match uncoupled::decompose_uncoupled(&equations) {
            Some(response) => response,
            None => coupled::decompose_coupled(&equations, &harmonics)?,
        };
        let len = spectrum.count();
        let sigma = |modal: &[f64]| {
            let mut sigma = vec![0.0; len];
            stage.to_parts(modal, &mut sigma);
            sigma
        };
        let mut steady = Vec::new();
        let mut near = Vec::new();
        let mut residual = Vec::new();
        for (harmonic, (omega, push)) in harmonics.iter().enumerate() {
            let apply = |f: fn(&Complex) -> f64| sigma(&push.iter().map(f).collect::<Vec<f64>>());
            let (re, im) = (apply(|x| x.re), apply(|x| x.im));
            let push: Vec<Complex> = re
                .iter()
                .zip(&im)
                .map(|(&re, &im)| Complex::new(re, im))
                .collect();
            let response = spectrum.steady_state(&push, (harmonic, *omega), context.span);
            steady.push(response.phasors);
            near.extend(response.near);
            residual.push(response.residual);
        }
        let stuck: Vec<usize> = (0..laws.len()).filter(|&b| laws[b].sticks).collect();
        let stick = match stuck.is_empty() {
            true => None,
            false => Some(StickConstraint::new(
                context, laws, &stuck, &modes, &stage, len,
            )?),
        };
        let (into, back) = transforms(&modes, &stage, &steady, (len, model.internal_count()));
        let zeros = vec![0.0; 2 * harmonics.len()];
        let extended = |modal: &[f64]| [&zeros[..], &sigma(modal)].concat();
        let pushes = raw
            .iter()
            .map(|[value, rate]| [extended(value), extended(rate)])
            .collect();
        let linear_model = LinearSystem {
            parts: ForcedParts::new(spectrum.clone(), &context.inputs.frequencies, near),
            to_parts: ColumnMatrix::from_matrix(&into),
            from_parts: ColumnMatrix::from_matrix(&back),
            pushes,
            stick,
            modes,
            rows,
            modal_parts: spectrum,
            transform: stage,
            steady,
            residual_inputs: residual,
            laws: laws.to_vec(),
        };
        registers::zero_upper();
        Ok(linear_model)
    }

    /// Whether linear laws of the branches give the same system.
    pub fn matches(&self, laws: &[LinearLaw]) -> bool {
        self.laws
            .iter()
            .zip(laws)
            .all(|(known, law)| known.same_dynamics(law))
    }

    /// Forcing β of σ by the constant forces of branches.
    pub fn constant(&self, model: &DynamicModel, laws: &[LinearLaw]) -> Vec<f64> {
        let m = self.modes.count();
        let mut modal = vec![0.0; 2 * m + model.internal_count()];
        for (branch, law) in laws.iter().enumerate() {
            axpy(
                &mut modal[m..2 * m],
                -law.force.constant,
                &self.rows.force_rows[branch],
            );
            if let Some(inner) = &law.inner {
                modal[2 * m + inner_before(model, branch)] += inner.constant;
            }
        }
        let n_harmonic = 2 * self.steady.len();
        let mut push = vec![0.0; n_harmonic + self.modal_parts.count()];
        self.transform.to_parts(&modal, &mut push[n_harmonic..]);
        push
    }
}

/// Matrices from `(y, harmonics)` to the states of the parts, and from σ to y.
fn transforms(
    modes: &RegimeModes,
    stage: &ModalTransform,
    phasors: &[Vec<Complex>],
    (len, inner): (usize, usize),
) -> (Matrix, Matrix) {
    let (n, m) = (modes.shapes.nrows(), modes.count());
    let (out, inverse) = stage.matrices(len);
    let states = 2 * n + inner;
    let n_h = 2 * phasors.len();
    // Re(a e^{iωt}) = Re a cos − Im a sin; σ excludes this response.
    let steady = |h: usize, i: usize| match h % 2 {
        0 => phasors[h / 2][i].re,
        _ => -phasors[h / 2][i].im,
    };
    let (shapes, momenta) = (&modes.shapes, &modes.momenta);
    let mut to_parts = Matrix::zeros(len, states + n_h);
    let mut from_parts = Matrix::zeros(states, n_h + len);
    // Positions, then speeds: both by the same modes.
    for half in 0..2 {
        let parts = inverse.subcols(half * m, m) * momenta.transpose();
        let back = shapes * out.subrows(half * m, m);
        for i in 0..n {
            let column = to_parts.col_as_slice_mut(half * n + i);
            column.copy_from_slice(parts.col_as_slice(i));
        }
        for k in 0..len {
            let column = &mut from_parts.col_as_slice_mut(n_h + k)[half * n..][..n];
            column.copy_from_slice(back.col_as_slice(k));
        }
    }
    for z in 0..inner {
        let column = to_parts.col_as_slice_mut(2 * n + z);
        column.copy_from_slice(inverse.col_as_slice(2 * m + z));
        for k in 0..len {
            from_parts[(2 * n + z, n_h + k)] = out[(2 * m + z, k)];
        }
    }
    for h in 0..n_h {
        let response: Vec<f64> = (0..len).map(|k| steady(h, k)).collect();
        axpy(to_parts.col_as_slice_mut(states + h), -1.0, &response);
        let mut sum = vec![0.0; states];
        gemv(&mut sum, &response, |k| from_parts.col_as_slice(n_h + k));
        from_parts.col_as_slice_mut(h).copy_from_slice(&sum);
    }
    (to_parts, from_parts)
}

/// Strain rows of the branches, which determine the rigid motions.
fn rows(context: &RunContext, laws: &[LinearLaw]) -> StrainRows {
    let model = context.model;
    let n = model.coordinate_count();
    let mut rows = StrainRows::default();
    for (branch, law) in model.elements.iter().zip(laws) {
        let w = context.mass_factor.solve(&to_dense(&branch.direction, n));
        let u = branch
            .force_direction
            .as_ref()
            .map(|u| context.mass_factor.solve(&to_dense(u, n)));
        if law.sticks {
            rows.stuck.push(w);
            continue;
        }
        let (k, c) = (law.force.deflection, law.force.rate);
        if k > 0.0 && u.is_none() {
            rows.squares.push((w, k.sqrt()));
        } else if k != 0.0 {
            rows.springs.extend(std::iter::once(w).chain(u));
        } else if c != 0.0 || law.inner.is_some() {
            rows.dampers.extend(std::iter::once(w).chain(u));
        }
    }
    if let Some((k, c)) = &model.global_matrices {
        let row = |a: &Matrix, i: usize| {
            context
                .mass_factor
                .solve(&(0..n).map(|j| a[(i, j)]).collect::<Vec<_>>())
        };
        rows.springs.extend((0..n).map(|i| row(k, i)));
        rows.dampers.extend((0..n).map(|i| row(c, i)));
        let transposed = |a: &Matrix| a.transpose().to_owned();
        let (k, c) = (transposed(k), transposed(c));
        rows.dampers
            .extend((0..n).flat_map(|i| [row(&k, i), row(&c, i)]));
    }
    rows.springs.retain(|row| row.iter().any(|x| *x != 0.0));
    rows.dampers.retain(|row| row.iter().any(|x| *x != 0.0));
    rows
}

/// Element directions in modal coordinates.
#[derive(Debug)]
pub struct ModalRows {
    /// Deflection rows wᵀΦ of every branch.
    pub deflection_rows: Vec<Vec<f64>>,
    /// Force rows uᵀΦ of every branch.
    pub force_rows: Vec<Vec<f64>>,
}

impl ModalRows {
    fn new(model: &DynamicModel, laws: &[LinearLaw], modes: &RegimeModes) -> ModalRows {
        let blind = |law: &LinearLaw, acting: bool| match law {
            // A spring has no deflection in rigid modes, nor a force if it acts along its deflection.
            law if law.force.deflection != 0.0 && !acting => modes.rigid,
            law if law.force.deflection != 0.0 || law.force.rate != 0.0 || law.inner.is_some() => {
                modes.free
            }
            _ => 0,
        };
        let project = |direction, blind| modes.project(direction, blind);
        let pairs = model.elements.iter().zip(laws);
        let sees = pairs
            .clone()
            .map(|(b, law)| project(&b.direction, blind(law, false)));
        let acts = pairs
            .map(|(b, law)| project(b.force_direction(), blind(law, b.force_direction.is_some())));
        ModalRows {
            deflection_rows: sees.collect(),
            force_rows: acts.collect(),
        }
    }
}

fn equations(
    model: &DynamicModel,
    laws: &[LinearLaw],
    modes: &RegimeModes,
    rows: &ModalRows,
) -> ModalEquations {
    let m = modes.count();
    let mut stiffness = Matrix::zeros(m, m);
    let mut has_stiffness = false;
    let mut inner = Vec::new();
    for (element, (branch, law)) in model.elements.iter().zip(laws).enumerate() {
        let (sees, acts) = (&rows.deflection_rows[element], &rows.force_rows[element]);
        let k = law.force.deflection;
        if k != 0.0 && (k < 0.0 || branch.force_direction.is_some()) {
            has_stiffness = true;
            for (i, j) in (0..m).flat_map(|i| (0..m).map(move |j| (i, j))) {
                stiffness[(i, j)] += k * acts[i] * sees[j];
            }
        }
        if let Some(state) = &law.inner {
            inner.push(InternalState {
                decay: state.decay,
                velocity_row: sees.iter().map(|w| state.seen * w).collect(),
                force_column: acts.iter().map(|u| -state.force * u).collect(),
                scale: state.scale,
            });
        }
    }
    if let Some((k, _)) = &model.global_matrices
        && k.norm_max() > 0.0
    {
        has_stiffness = true;
        let modal = modes.shapes.transpose() * k * &modes.shapes;
        for (i, j) in (0..m).flat_map(|i| (modes.rigid..m).map(move |j| (i, j))) {
            stiffness[(i, j)] += modal[(i, j)];
        }
    }
    ModalEquations {
        omega: modes.omega.clone(),
        free: modes.free,
        rigid: modes.rigid,
        drag: model.mass_damping,
        damping: damping(model, laws, modes, rows),
        stiffness: has_stiffness.then_some(stiffness),
        inner,
    }
}

/// Modal damping matrix D, as a diagonal if it has no other entries.
fn damping(
    model: &DynamicModel,
    laws: &[LinearLaw],
    modes: &RegimeModes,
    rows: &ModalRows,
) -> ModalDamping {
    if let Some(beta) = rayleigh(model, laws) {
        let diagonal = modes
            .omega
            .iter()
            .map(|w| model.mass_damping + beta * w * w);
        return ModalDamping::Diagonal(diagonal.collect());
    }
    let (n, m) = (model.coordinate_count(), modes.count());
    let pairs = || (0..m).flat_map(|i| (0..m).map(move |j| (i, j)));
    let mut d = Matrix::zeros(m, m);
    // Sum of absolute values of the terms of each entry.
    let mut size = Matrix::zeros(m, m);
    let large = |w: &Direction| -> Vec<f64> {
        let sum = |j: usize| {
            let shape = modes.shapes.col_as_slice(j);
            w.entries().map(|(i, a)| (a * shape[i]).abs()).sum()
        };
        (0..m).map(sum).collect()
    };
    for (element, (branch, law)) in model.elements.iter().zip(laws).enumerate() {
        let c = law.force.rate;
        if c == 0.0 {
            continue;
        }
        let (sees, acts) = (&rows.deflection_rows[element], &rows.force_rows[element]);
        let (large_w, large_u) = (large(&branch.direction), large(branch.force_direction()));
        for j in 0..m {
            axpy(d.col_as_slice_mut(j), c * sees[j], acts);
            axpy(size.col_as_slice_mut(j), c.abs() * large_w[j], &large_u);
        }
    }
    if let Some((_, c)) = &model.global_matrices {
        let modal = modes.shapes.transpose() * c * &modes.shapes;
        let abs = |a: &Matrix| Matrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)].abs());
        let shapes = abs(&modes.shapes);
        let large = shapes.transpose() * abs(c) * &shapes;
        for (i, j) in pairs().filter(|&(i, j)| i >= modes.free && j >= modes.free) {
            d[(i, j)] += modal[(i, j)];
            size[(i, j)] += large[(i, j)];
        }
    }
    (0..m).for_each(|j| d[(j, j)] += model.mass_damping);
    let rounding = 4.0 * n as f64 * f64::EPSILON;
    let coupled = pairs().any(|(i, j)| i != j && d[(i, j)].abs() > rounding * size[(i, j)]);
    match coupled {
        true => ModalDamping::Full(d),
        false => ModalDamping::Diagonal((0..m).map(|j| d[(j, j)]).collect()),
    }
}

/// Rayleigh coefficient β, s, if every damper is β times its spring; none if another element but drag damps.
fn rayleigh(model: &DynamicModel, laws: &[LinearLaw]) -> Option<f64> {
    if model.global_matrices.is_some() {
        return None;
    }
    let mut beta: Option<f64> = None;
    for (branch, law) in model.elements.iter().zip(laws) {
        let (k, c) = (law.force.deflection, law.force.rate);
        if law.sticks || (k == 0.0 && c == 0.0) {
            continue;
        }
        if !(k > 0.0) || branch.force_direction.is_some() {
            return None;
        }
        let ratio = c / k;
        let known = *beta.get_or_insert(ratio);
        if (ratio - known).abs() > 8.0 * f64::EPSILON * known.abs() {
            return None;
        }
    }
    Some(beta.unwrap_or(0.0))
}

/// Forcing of modal states per value and per rate of every input.
fn input_columns(
    context: &RunContext,
    laws: &[LinearLaw],
    rows: &ModalRows,
    modes: &RegimeModes,
) -> Vec<[Vec<f64>; 2]> {
    let model = context.model;
    let m = modes.count();
    let zeros = vec![0.0; 2 * m + model.internal_count()];
    let inputs = context.inputs.list.iter().map(|input| {
        let (mut value, mut rate) = (zeros.clone(), zeros.clone());
        match input.entry {
            InputTarget::Drive(index) => {
                let d = modes.project(&model.forces[index].direction, 0);
                value[m..2 * m].copy_from_slice(&d);
            }
            InputTarget::Imposed(index) => {
                let law = &laws[index];
                for j in 0..m {
                    value[m + j] = law.force.deflection * rows.force_rows[index][j];
                    rate[m + j] = law.force.rate * rows.force_rows[index][j];
                }
                if let Some(inner) = &law.inner {
                    rate[2 * m + inner_before(model, index)] = -inner.imposed;
                }
            }
        }
        [value, rate]
    });
    inputs.collect()
}

/// Number of internal states of the branches before a branch.
fn inner_before(model: &DynamicModel, branch: usize) -> usize {
    model.elements[..branch]
        .iter()
        .map(|b| b.internal_count())
        .sum()
}

/// Frequency ω, rad/s, and forcing phasors of the `states` modal states for every harmonic.
fn harmonics(
    inputs: &KnownInputs,
    pushes: &[[Vec<f64>; 2]],
    states: usize,
) -> Vec<(f64, Vec<Complex>)> {
    let phasors = |(f, &omega): (usize, &f64)| {
        let mut push = vec![Complex::ZERO; states];
        for (input, [value, rate]) in inputs.list.iter().zip(pushes) {
            for (_, phasor) in input.harmonics.iter().filter(|(index, _)| *index == f) {
                for (i, push) in push.iter_mut().enumerate() {
                    *push += phasor * Complex::new(value[i], omega * rate[i]);
                }
            }
        }
        (omega, push)
    };
    inputs.frequencies.iter().enumerate().map(phasors).collect()
}
