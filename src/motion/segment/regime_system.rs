//! System of one regime: linear system, constant forces, event functions.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::event_evaluator::{EventEvaluator, prune_unused_parts};
use super::event_function::{EventFunction, EventQuantity};
use super::inputs::{InputTarget, KnownInput, KnownInputs};
use super::linear_law::LinearLaw;
use super::linear_system::LinearSystem;
use super::mass_normalised::{dot, to_dense};
use super::piece_load::PieceLoad;
use super::run_context::RunContext;
use crate::base::error::Error;
use crate::motion::contact::Affine;
use crate::motion::dynamic_model::{ElementState, ForceLaw};
use crate::motion::friction::FrictionState;
use crate::numeric::Complex;

/// Linear system of a model in one regime, with its inputs and event functions.
#[derive(Debug)]
pub struct RegimeSystem {
    /// Linear system shared with other regimes.
    pub linear: Rc<LinearSystem>,
    /// Constant input of σ.
    constant: Vec<f64>,
    /// Present load.
    pub load: PieceLoad,
    /// Event functions that end the regime.
    pub events: Vec<EventFunction>,
    /// Evaluators of the event functions.
    pub evaluators: Vec<EventEvaluator>,
    /// True for the non-oscillatory parts that no evaluator depends on.
    pub unused_parts: Vec<bool>,
}

impl RegimeSystem {
    /// System of a regime with the linear laws of its branches.
    ///
    /// # Errors
    /// Overflow of an event function.
    pub fn new(
        context: &RunContext,
        linear_model: Rc<LinearSystem>,
        laws: &[LinearLaw],
        states: &[ElementState],
    ) -> Result<RegimeSystem, Error> {
        let mut evaluators = Vec::new();
        let events = linear_model.events(context, laws, states, &mut evaluators)?;
        let parts = &linear_model.parts;
        let unused = match parts.is_resonant() {
            true => vec![false; parts.others.len()],
            false => prune_unused_parts(&mut evaluators, parts.eigenvalues.len(), &parts.others),
        };
        Ok(RegimeSystem {
            constant: linear_model.constant(context.model, laws),
            load: PieceLoad::default(),
            events,
            evaluators,
            unused_parts: unused,
            linear: linear_model,
        })
    }

    /// Updates the load to the active pieces of the inputs.
    pub fn set_pieces(&mut self, inputs: &KnownInputs, pieces: &[u32]) {
        if self.load.push.is_empty() || !self.load.matches(pieces) {
            let system = (&*self.linear, &self.constant[..]);
            self.load = PieceLoad::new(inputs, pieces, system, &self.events);
        }
    }
}

impl LinearSystem {
    fn events(
        &self,
        context: &RunContext,
        laws: &[LinearLaw],
        states: &[ElementState],
        evaluators: &mut Vec<EventEvaluator>,
    ) -> Result<Vec<EventFunction>, Error> {
        let mut events = Vec::new();
        for (i, branch) in context.model.elements.iter().enumerate() {
            match (&branch.law, states[i]) {
                (ForceLaw::Contact(contact), ElementState::Contact(state, piece)) => {
                    let factor = branch.factor(0.0, &[], piece).0;
                    for (affine, to) in contact.switching_functions(state, factor) {
                        let kind = EventQuantity::Deflection(affine);
                        let next = ElementState::Contact(to, piece);
                        events.push(self.event(context, (i, kind, next), evaluators));
                    }
                }
                (ForceLaw::Friction(_), ElementState::Friction(slip))
                    if slip != FrictionState::Stick =>
                {
                    let affine = Affine {
                        rate: slip.sign(),
                        ..Default::default()
                    };
                    let kind = EventQuantity::Deflection(affine);
                    let next = ElementState::Friction(FrictionState::Stick);
                    events.push(self.event(context, (i, kind, next), evaluators));
                }
                (ForceLaw::Friction(friction), ElementState::Friction(_)) => {
                    let Some(stick) = &self.stick else { continue };
                    for slip in [FrictionState::Forward, FrictionState::Backward] {
                        let reserve =
                            stick.breakaway_reserve(context, laws, i, friction.breakaway, slip)?;
                        let next = ElementState::Friction(slip);
                        let kind = EventQuantity::Reaction(reserve);
                        events.push(self.event(context, (i, kind, next), evaluators));
                    }
                }
                _ => {}
            }
        }
        Ok(events)
    }

    fn event(
        &self,
        context: &RunContext,
        (branch, kind, to): (usize, EventQuantity, ElementState),
        evaluators: &mut Vec<EventEvaluator>,
    ) -> EventFunction {
        let (m, len) = (self.modes.count(), self.modal_parts.count());
        let rows = &self.rows;
        let mut modal = vec![0.0; 2 * m + context.model.internal_count()];
        let mut direct: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
        let (constant, dense) = match &kind {
            EventQuantity::Deflection(affine) => {
                for j in 0..m {
                    modal[j] = affine.deflection * rows.deflection_rows[branch][j];
                    modal[m + j] = affine.rate * rows.deflection_rows[branch][j];
                }
                let is_imposed = |input: &KnownInput| input.entry == InputTarget::Imposed(branch);
                if let Some(i) = context.inputs.list.iter().position(is_imposed) {
                    direct.insert(i, [-affine.deflection, -affine.rate]);
                }
                let dense = self.stick.as_ref().map(|_| {
                    let w = to_dense(
                        &context.model.elements[branch].direction,
                        context.model.coordinate_count(),
                    );
                    let scale = |a: f64| w.iter().map(|w| a * w).collect::<Vec<f64>>();
                    [scale(affine.deflection), scale(affine.rate)]
                });
                (affine.constant, dense)
            }
            EventQuantity::Reaction(reserve) => {
                for j in 0..m {
                    let shape = self.modes.shapes.col_as_slice(j);
                    modal[j] = dot(&reserve.displacement, shape);
                    modal[m + j] = dot(&reserve.velocity, shape);
                }
                modal[2 * m..].copy_from_slice(&reserve.inner);
                direct.extend(reserve.direct.iter().copied());
                let weights = [reserve.displacement.clone(), reserve.velocity.clone()];
                (reserve.constant, Some(weights))
            }
        };
        let row = self.transform.row(&modal, len);
        let rate = self.modal_parts.rate_row(&row);
        let phasors = context.inputs.frequencies.iter().enumerate();
        let phasors = phasors.map(|(f, &omega)| {
            let s = Complex::new(0.0, omega);
            let project = |vector: &[Complex]| {
                let pairs = row.iter().zip(vector);
                pairs.fold(Complex::ZERO, |sum, (c, x)| sum + x * *c)
            };
            let input_part = direct
                .iter()
                .fold(Complex::ZERO, |sum, (&input, [value, rate])| {
                    let list = context.inputs.list[input].harmonics.iter();
                    list.filter(|(i, _)| *i == f)
                        .fold(sum, |sum, (_, phasor)| sum + phasor * (s * rate + *value))
                });
            let value = project(&self.steady[f]) + input_part;
            [value, value * s + project(&self.residual_inputs[f])]
        });
        let phasors: Vec<[Complex; 2]> = phasors.collect();
        let real_parts = |which: usize| {
            phasors
                .iter()
                .flat_map(move |p| [p[which].re, -p[which].im])
        };
        let sizes = phasors.iter().map(|[p, _]| p.norm());
        let sizes: Vec<f64> = sizes.chain(self.modal_parts.part_sizes(&row)).collect();
        let rate: Vec<f64> = real_parts(1).chain(rate).collect();
        let row: Vec<f64> = real_parts(0).chain(row.iter().copied()).collect();
        let new = EventEvaluator::new(&self.parts.eigenvalues, &row, &rate, &sizes);
        let duplicate = evaluators.iter().map(|known| new.sign(known)).enumerate();
        let duplicate = duplicate.filter_map(|(i, sign)| Some((i, sign?))).next();
        let (evaluator, sign) = duplicate.unwrap_or_else(|| {
            evaluators.push(new);
            (evaluators.len() - 1, 1.0)
        });
        EventFunction {
            branch,
            to,
            evaluator,
            sign,
            sizes,
            row,
            constant,
            direct: direct.into_iter().collect(),
            dense,
            kind,
        }
    }
}
