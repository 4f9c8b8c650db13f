//! Linear system shared by regimes of equal stiffness, damping and sticking pairs.
//!
//! The flanks of a contact differ by a constant force alone, and so do the senses of a sliding pair: what is dear to make is made
//! once for all of them.

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

/// A linear machine.
#[derive(Debug)]
pub struct LinearSystem {
    /// Free and harmonically forced parts: the states σ are the cosines and sines of the harmonics, then those of the parts.
    pub parts: ForcedParts,
    /// The states of the parts from `(y, turns)`, harmonics as cosine and sine.
    pub to_parts: ColumnMatrix,
    /// y from σ.
    pub from_parts: ColumnMatrix,
    /// Push on σ per value and per rate of every input.
    pub pushes: Vec<[Vec<f64>; 2]>,
    /// Pairs that stick.
    pub stick: Option<StickConstraint>,
    /// Modes of the machine.
    pub modes: RegimeModes,
    /// Directions over them.
    pub rows: ModalRows,
    /// Modal parts in closed form, without harmonics.
    pub modal_parts: ModalParts,
    /// From modal states to these and back.
    pub transform: ModalTransform,
    /// σ of the parts under every harmonic: phasors.
    pub steady: Vec<Vec<Complex>>,
    /// Push of every harmonic that is not in these.
    pub residual_pushes: Vec<Vec<Complex>>,
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
        let seen = ModalRows::new(model, laws, &modes);
        let equations = equations(model, laws, &modes, &seen);

        let raw = input_columns(context, laws, &seen, &modes);
        let harmonics = harmonics(
            &context.inputs,
            &raw,
            2 * modes.count() + model.internal_count(),
        );
        let (spectrum, stage) = match uncoupled::decompose_uncoupled(&equations) {
            Some(found) => found,
            None => coupled::decompose_coupled(&equations, &harmonics)?,
        };
        let len = spectrum.count();
        let into = |modal: &[f64]| {
            let mut sigma = vec![0.0; len];
            stage.to_parts(modal, &mut sigma);
            sigma
        };
        let mut steady = Vec::new();
        let mut near = Vec::new();
        let mut left = Vec::new();
        for (at, (omega, push)) in harmonics.iter().enumerate() {
            let part = |of: fn(&Complex) -> f64| into(&push.iter().map(of).collect::<Vec<f64>>());
            let (re, im) = (part(|x| x.re), part(|x| x.im));
            let push: Vec<Complex> = re
                .iter()
                .zip(&im)
                .map(|(&re, &im)| Complex::new(re, im))
                .collect();
            let found = spectrum.steady_state(&push, (at, *omega), context.span);
            steady.push(found.phasors);
            near.extend(found.near);
            left.push(found.left);
        }
        let stuck: Vec<usize> = (0..laws.len()).filter(|&b| laws[b].sticks).collect();
        let method = match stuck.is_empty() {
            true => None,
            false => Some(StickConstraint::new(
                context, laws, &stuck, &modes, &stage, len,
            )?),
        };
        let (enter, leave) = transforms(&modes, &stage, &steady, (len, model.internal_count()));
        let turns = vec![0.0; 2 * harmonics.len()];
        let behind_turns = |modal: &[f64]| [&turns[..], &into(modal)].concat();
        let pushes = raw
            .iter()
            .map(|[value, rate]| [behind_turns(value), behind_turns(rate)])
            .collect();
        let linear_model = LinearSystem {
            parts: ForcedParts::new(spectrum.clone(), &context.inputs.frequencies, near),
            to_parts: ColumnMatrix::from_matrix(&enter),
            from_parts: ColumnMatrix::from_matrix(&leave),
            pushes,
            stick: method,
            modes,
            rows: seen,
            modal_parts: spectrum,
            transform: stage,
            steady,
            residual_pushes: left,
            laws: laws.to_vec(),
        };
        registers::zero_upper();
        Ok(linear_model)
    }

    /// Whether branches so held make the same machine.
    pub fn matches(&self, laws: &[LinearLaw]) -> bool {
        self.laws
            .iter()
            .zip(laws)
            .all(|(own, law)| own.same_dynamics(law))
    }

    /// Push on σ by the constant forces of branches.
    pub fn constant(&self, model: &DynamicModel, laws: &[LinearLaw]) -> Vec<f64> {
        let m = self.modes.count();
        let mut modal = vec![0.0; 2 * m + model.internal_count()];
        for (at, law) in laws.iter().enumerate() {
            axpy(
                &mut modal[m..2 * m],
                -law.force.constant,
                &self.rows.acts[at],
            );
            if let Some(own) = &law.inner {
                modal[2 * m + inner_before(model, at)] += own.constant;
            }
        }
        let turns = 2 * self.steady.len();
        let mut push = vec![0.0; turns + self.modal_parts.count()];
        self.transform.to_parts(&modal, &mut push[turns..]);
        push
    }
}

/// From y to the parts and back.
fn transforms(
    modes: &RegimeModes,
    stage: &ModalTransform,
    phasors: &[Vec<Complex>],
    (len, inner): (usize, usize),
) -> (Matrix, Matrix) {
    let (n, m) = (modes.shapes.nrows(), modes.count());
    let (out, into) = stage.matrices(len);
    let states = 2 * n + inner;
    let turns = 2 * phasors.len();
    // Re(a e^{iωt}) = Re a cos − Im a sin, and σ is without it.
    let steady = |turn: usize, i: usize| match turn % 2 {
        0 => phasors[turn / 2][i].re,
        _ => -phasors[turn / 2][i].im,
    };
    let (shapes, momenta) = (&modes.shapes, &modes.momenta);
    let mut enter = Matrix::zeros(len, states + turns);
    let mut leave = Matrix::zeros(states, turns + len);
    // Places, then speeds: each of them by the same modes.
    for half in 0..2 {
        let parts = into.subcols(half * m, m) * momenta.transpose();
        let back = shapes * out.subrows(half * m, m);
        for i in 0..n {
            let column = enter.col_as_slice_mut(half * n + i);
            column.copy_from_slice(parts.col_as_slice(i));
        }
        for k in 0..len {
            let column = &mut leave.col_as_slice_mut(turns + k)[half * n..][..n];
            column.copy_from_slice(back.col_as_slice(k));
        }
    }
    for z in 0..inner {
        let column = enter.col_as_slice_mut(2 * n + z);
        column.copy_from_slice(into.col_as_slice(2 * m + z));
        for k in 0..len {
            leave[(2 * n + z, turns + k)] = out[(2 * m + z, k)];
        }
    }
    for turn in 0..turns {
        let answer: Vec<f64> = (0..len).map(|k| steady(turn, k)).collect();
        axpy(enter.col_as_slice_mut(states + turn), -1.0, &answer);
        let mut sum = vec![0.0; states];
        gemv(&mut sum, &answer, |k| leave.col_as_slice(turns + k));
        leave.col_as_slice_mut(turn).copy_from_slice(&sum);
    }
    (enter, leave)
}

/// The rows that decide which motions are rigid.
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
    if let Some((k, c)) = &model.unattached {
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

/// Directions over the modes.
#[derive(Debug)]
pub struct ModalRows {
    /// wᵀΦ of every branch.
    pub sees: Vec<Vec<f64>>,
    /// uᵀΦ.
    pub acts: Vec<Vec<f64>>,
}

impl ModalRows {
    fn new(model: &DynamicModel, laws: &[LinearLaw], modes: &RegimeModes) -> ModalRows {
        let blind = |law: &LinearLaw, acting: bool| match law {
            // What a spring sees is not rigid, and where it acts along what it sees nothing rigid is pushed.
            law if law.force.deflection != 0.0 && !acting => modes.rigid,
            law if law.force.deflection != 0.0 || law.force.rate != 0.0 || law.inner.is_some() => {
                modes.free
            }
            _ => 0,
        };
        let of = |direction, blind| modes.project(direction, blind);
        let both = model.elements.iter().zip(laws);
        let sees = both
            .clone()
            .map(|(b, law)| of(&b.direction, blind(law, false)));
        let acts =
            both.map(|(b, law)| of(b.force_direction(), blind(law, b.force_direction.is_some())));
        ModalRows {
            sees: sees.collect(),
            acts: acts.collect(),
        }
    }
}

fn equations(
    model: &DynamicModel,
    laws: &[LinearLaw],
    modes: &RegimeModes,
    seen: &ModalRows,
) -> ModalEquations {
    let m = modes.count();
    let mut stiffness = Matrix::zeros(m, m);
    let mut beside = false;
    let mut inner = Vec::new();
    for (at, (branch, law)) in model.elements.iter().zip(laws).enumerate() {
        let (sees, acts) = (&seen.sees[at], &seen.acts[at]);
        let k = law.force.deflection;
        if k != 0.0 && (k < 0.0 || branch.force_direction.is_some()) {
            beside = true;
            for (i, j) in (0..m).flat_map(|i| (0..m).map(move |j| (i, j))) {
                stiffness[(i, j)] += k * acts[i] * sees[j];
            }
        }
        if let Some(own) = &law.inner {
            inner.push(InternalState {
                decay: own.decay,
                velocity_row: sees.iter().map(|w| own.seen * w).collect(),
                force_column: acts.iter().map(|u| -own.force * u).collect(),
                scale: own.scale,
            });
        }
    }
    if let Some((k, _)) = &model.unattached
        && k.norm_max() > 0.0
    {
        beside = true;
        let over = modes.shapes.transpose() * k * &modes.shapes;
        for (i, j) in (0..m).flat_map(|i| (modes.rigid..m).map(move |j| (i, j))) {
            stiffness[(i, j)] += over[(i, j)];
        }
    }
    ModalEquations {
        omega: modes.omega.clone(),
        free: modes.free,
        rigid: modes.rigid,
        drag: model.mass_damping,
        damping: damping(model, laws, modes, seen),
        stiffness: beside.then_some(stiffness),
        inner,
    }
}

/// D: by its diagonal where that is all of it.
fn damping(
    model: &DynamicModel,
    laws: &[LinearLaw],
    modes: &RegimeModes,
    seen: &ModalRows,
) -> ModalDamping {
    if let Some(beta) = rayleigh(model, laws) {
        let own = modes
            .omega
            .iter()
            .map(|w| model.mass_damping + beta * w * w);
        return ModalDamping::Diagonal(own.collect());
    }
    let (n, m) = (model.coordinate_count(), modes.count());
    let pairs = || (0..m).flat_map(|i| (0..m).map(move |j| (i, j)));
    let mut d = Matrix::zeros(m, m);
    // What each entry sums, without signs.
    let mut size = Matrix::zeros(m, m);
    let large = |w: &Direction| -> Vec<f64> {
        let whole = |j: usize| {
            let shape = modes.shapes.col_as_slice(j);
            w.entries().map(|(i, a)| (a * shape[i]).abs()).sum()
        };
        (0..m).map(whole).collect()
    };
    for (at, (branch, law)) in model.elements.iter().zip(laws).enumerate() {
        let c = law.force.rate;
        if c == 0.0 {
            continue;
        }
        let (sees, acts) = (&seen.sees[at], &seen.acts[at]);
        let (large_w, large_u) = (large(&branch.direction), large(branch.force_direction()));
        for j in 0..m {
            axpy(d.col_as_slice_mut(j), c * sees[j], acts);
            axpy(size.col_as_slice_mut(j), c.abs() * large_w[j], &large_u);
        }
    }
    if let Some((_, c)) = &model.unattached {
        let over = modes.shapes.transpose() * c * &modes.shapes;
        let plain = |a: &Matrix| Matrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)].abs());
        let shapes = plain(&modes.shapes);
        let large = shapes.transpose() * plain(c) * &shapes;
        for (i, j) in pairs().filter(|&(i, j)| i >= modes.free && j >= modes.free) {
            d[(i, j)] += over[(i, j)];
            size[(i, j)] += large[(i, j)];
        }
    }
    (0..m).for_each(|j| d[(j, j)] += model.mass_damping);
    let rounding = 4.0 * n as f64 * f64::EPSILON;
    let beside = pairs().any(|(i, j)| i != j && d[(i, j)].abs() > rounding * size[(i, j)]);
    match beside {
        true => ModalDamping::Full(d),
        false => ModalDamping::Diagonal((0..m).map(|j| d[(j, j)]).collect()),
    }
}

/// β where every spring's damper is β times the spring and nothing else damps but drag.
fn rayleigh(model: &DynamicModel, laws: &[LinearLaw]) -> Option<f64> {
    if model.unattached.is_some() {
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
        let own = c / k;
        let known = *beta.get_or_insert(own);
        if (own - known).abs() > 8.0 * f64::EPSILON * known.abs() {
            return None;
        }
    }
    Some(beta.unwrap_or(0.0))
}

/// Pushes on modal states per value and per rate of every input.
fn input_columns(
    context: &RunContext,
    laws: &[LinearLaw],
    seen: &ModalRows,
    modes: &RegimeModes,
) -> Vec<[Vec<f64>; 2]> {
    let model = context.model;
    let m = modes.count();
    let nothing = vec![0.0; 2 * m + model.internal_count()];
    let inputs = context.inputs.list.iter().map(|input| {
        let (mut value, mut rate) = (nothing.clone(), nothing.clone());
        match input.entry {
            InputTarget::Drive(at) => {
                let d = modes.project(&model.forces[at].direction, 0);
                value[m..2 * m].copy_from_slice(&d);
            }
            InputTarget::Imposed(at) => {
                let law = &laws[at];
                for j in 0..m {
                    value[m + j] = law.force.deflection * seen.acts[at][j];
                    rate[m + j] = law.force.rate * seen.acts[at][j];
                }
                if let Some(own) = &law.inner {
                    rate[2 * m + inner_before(model, at)] = -own.imposed;
                }
            }
        }
        [value, rate]
    });
    inputs.collect()
}

/// Inner states of the branches before one.
fn inner_before(model: &DynamicModel, branch: usize) -> usize {
    model.elements[..branch]
        .iter()
        .map(|b| b.internal_count())
        .sum()
}

/// ω and phasors of the push on modal states, of which there are `states`.
fn harmonics(
    inputs: &KnownInputs,
    pushes: &[[Vec<f64>; 2]],
    states: usize,
) -> Vec<(f64, Vec<Complex>)> {
    let of = |(f, &omega): (usize, &f64)| {
        let mut push = vec![Complex::ZERO; states];
        for (input, [value, rate]) in inputs.list.iter().zip(pushes) {
            for (_, phasor) in input.harmonics.iter().filter(|(at, _)| *at == f) {
                for (i, push) in push.iter_mut().enumerate() {
                    *push += phasor * Complex::new(value[i], omega * rate[i]);
                }
            }
        }
        (omega, push)
    };
    inputs.frequencies.iter().enumerate().map(of).collect()
}
