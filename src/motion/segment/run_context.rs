//! Data shared by all regimes of a run: model, mass factor, known inputs, duration.

use super::inputs::KnownInputs;
use super::mass_normalised::mass_factor;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::dynamic_model::{DynamicModel, ForceLaw};
use crate::numeric::mass_factor::MassFactor;

/// A machine, its inertia and what is known in time.
#[derive(Debug)]
pub struct RunContext<'a> {
    /// The machine.
    pub model: &'a DynamicModel,
    /// `M = L Lᵀ`.
    pub mass_factor: MassFactor,
    /// Inputs known in time.
    pub inputs: KnownInputs<'a>,
    /// Duration of the run, s.
    pub span: f64,
}

impl RunContext<'_> {
    /// Context of a run.
    ///
    /// # Errors
    /// A machine that is not linear between switches; a mass matrix that is not positive definite; friction on a motion imposed by harmonics.
    pub fn new(model: &DynamicModel, span: f64) -> Result<RunContext<'_>, Error> {
        if !model.is_piecewise_linear() {
            let message = "the machine is not linear between switches";
            return Err(Error::new(Code::OutOfRange, message).with_hint("take a method that steps"));
        }
        for branch in &model.elements {
            if let (ForceLaw::Friction(_), Some(e)) = (&branch.law, &branch.imposed_displacement)
                && !e.harmonics.is_empty()
            {
                let message = format!(
                    "`{}` has dry friction against a harmonic prescribed motion",
                    branch.name
                );
                return Err(Error::new(Code::OutOfRange, message)
                    .with_hint("prescribe it piecewise linearly, or take a time-stepping method"));
            }
        }
        Ok(RunContext {
            mass_factor: mass_factor(model)?,
            inputs: KnownInputs::new(model),
            model,
            span,
        })
    }
}
