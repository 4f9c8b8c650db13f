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

/// A machine in one regime.
#[derive(Debug)]
pub struct RegimeSystem {
    /// Linear system shared with other regimes.
    pub linear: Rc<LinearSystem>,
    /// Constant push on σ.
    constant: Vec<f64>,
    /// Present load.
    pub load: PieceLoad,
    /// Event functions that end the regime.
    pub events: Vec<EventFunction>,
    /// Evaluators of the event functions.
    pub evaluators: Vec<EventEvaluator>,
    /// Which non-oscillatory parts no evaluator depends on.
    pub unused_parts: Vec<bool>,
}

impl RegimeSystem {
    /// System of a regime, whose branches are held by `laws`.
    ///
    /// # Errors
    /// Numbers out of range.
    pub fn new(
        context: &RunContext,
        linear_model: Rc<LinearSystem>,
        laws: &[LinearLaw],
        states: &[ElementState],
    ) -> Result<RegimeSystem, Error> {
        let mut evaluators = Vec::new();
        let events = linear_model.events(context, laws, states, &mut evaluators)?;
        let parts = &linear_model.parts;
        let unseen = match parts.is_resonant() {
            true => vec![false; parts.others.len()],
            false => prune_unused_parts(&mut evaluators, parts.eigenvalues.len(), &parts.others),
        };
        Ok(RegimeSystem {
            constant: linear_model.constant(context.model, laws),
            load: PieceLoad::default(),
            events,
            evaluators,
            unused_parts: unseen,
            linear: linear_model,
        })
    }

    /// Takes up the lines that carry the inputs now.
    pub fn set_pieces(&mut self, inputs: &KnownInputs, pieces: &[u32]) {
        if self.load.push.is_empty() || !self.load.matches(pieces) {
            let own = (&*self.linear, &self.constant[..]);
            self.load = PieceLoad::new(inputs, pieces, own, &self.events);
        }
    }
}

impl LinearSystem {
    /// Event functions of every branch state.
    fn events(
        &self,
        context: &RunContext,
        laws: &[LinearLaw],
        states: &[ElementState],
        evaluators: &mut Vec<EventEvaluator>,
    ) -> Result<Vec<EventFunction>, Error> {
        let mut found = Vec::new();
        for (at, branch) in context.model.elements.iter().enumerate() {
            match (&branch.law, states[at]) {
                (ForceLaw::Contact(contact), ElementState::Contact(state, piece)) => {
                    let factor = branch.factor(0.0, &[], piece).0;
                    for (affine, to) in contact.switching_functions(state, factor) {
                        let kind = EventQuantity::Deflection(affine);
                        let next = ElementState::Contact(to, piece);
                        found.push(self.event(context, (at, kind, next), evaluators));
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
                    found.push(self.event(context, (at, kind, next), evaluators));
                }
                (ForceLaw::Friction(friction), ElementState::Friction(_)) => {
                    let Some(hold) = &self.stick else { continue };
                    for slip in [FrictionState::Forward, FrictionState::Backward] {
                        let held =
                            hold.breakaway_reserve(context, laws, at, friction.breakaway, slip)?;
                        let next = ElementState::Friction(slip);
                        let kind = EventQuantity::Reaction(held);
                        found.push(self.event(context, (at, kind, next), evaluators));
                    }
                }
                _ => {}
            }
        }
        Ok(found)
    }

    fn event(
        &self,
        context: &RunContext,
        (branch, kind, to): (usize, EventQuantity, ElementState),
        evaluators: &mut Vec<EventEvaluator>,
    ) -> EventFunction {
        let (m, len) = (self.modes.count(), self.modal_parts.count());
        let seen = &self.rows;
        let mut modal = vec![0.0; 2 * m + context.model.internal_count()];
        let mut direct: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
        let (constant, dense) = match &kind {
            EventQuantity::Deflection(affine) => {
                for j in 0..m {
                    modal[j] = affine.deflection * seen.sees[branch][j];
                    modal[m + j] = affine.rate * seen.sees[branch][j];
                }
                let own = |input: &KnownInput| input.entry == InputTarget::Imposed(branch);
                if let Some(at) = context.inputs.list.iter().position(own) {
                    direct.insert(at, [-affine.deflection, -affine.rate]);
                }
                let dense = self.stick.as_ref().map(|_| {
                    let w = to_dense(
                        &context.model.elements[branch].direction,
                        context.model.coordinate_count(),
                    );
                    let times = |a: f64| w.iter().map(|w| a * w).collect::<Vec<f64>>();
                    [times(affine.deflection), times(affine.rate)]
                });
                (affine.constant, dense)
            }
            EventQuantity::Reaction(held) => {
                for j in 0..m {
                    let shape = self.modes.shapes.col_as_slice(j);
                    modal[j] = dot(&held.place, shape);
                    modal[m + j] = dot(&held.rate, shape);
                }
                modal[2 * m..].copy_from_slice(&held.inner);
                direct.extend(held.direct.iter().copied());
                (held.constant, Some([held.place.clone(), held.rate.clone()]))
            }
        };
        let row = self.transform.row(&modal, len);
        let rate = self.modal_parts.rate_row(&row);
        let phasors = context.inputs.frequencies.iter().enumerate();
        let phasors = phasors.map(|(f, &omega)| {
            let s = Complex::new(0.0, omega);
            let along = |of: &[Complex]| {
                let both = row.iter().zip(of);
                both.fold(Complex::ZERO, |sum, (c, x)| sum + x * *c)
            };
            let fed = direct
                .iter()
                .fold(Complex::ZERO, |sum, (&input, [value, rate])| {
                    let own = context.inputs.list[input].harmonics.iter();
                    own.filter(|(at, _)| *at == f)
                        .fold(sum, |sum, (_, phasor)| sum + phasor * (s * rate + *value))
                });
            let value = along(&self.steady[f]) + fed;
            [value, value * s + along(&self.residual_pushes[f])]
        });
        let phasors: Vec<[Complex; 2]> = phasors.collect();
        let turning = |which: usize| {
            phasors
                .iter()
                .flat_map(move |p| [p[which].re, -p[which].im])
        };
        let sizes = phasors.iter().map(|[p, _]| p.norm());
        let sizes: Vec<f64> = sizes.chain(self.modal_parts.part_sizes(&row)).collect();
        let rate: Vec<f64> = turning(1).chain(rate).collect();
        let row: Vec<f64> = turning(0).chain(row.iter().copied()).collect();
        let own = EventEvaluator::new(&self.parts.eigenvalues, &row, &rate, &sizes);
        let alike = evaluators.iter().map(|known| own.sign(known)).enumerate();
        let alike = alike.filter_map(|(at, sign)| Some((at, sign?))).next();
        let (evaluator, sign) = alike.unwrap_or_else(|| {
            evaluators.push(own);
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
