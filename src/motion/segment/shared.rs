//! What all regimes of a run share.

use super::frame::Root;
use super::inputs::Inputs;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::train::{Law, Train};

/// A machine, its inertia and what is known in time.
#[derive(Debug)]
pub struct Shared<'a> {
    /// The machine.
    pub train: &'a Train,
    /// `M = L Lᵀ`.
    pub root: Root,
    /// What is known in time.
    pub inputs: Inputs<'a>,
    /// How long the run is, s.
    pub span: f64,
}

impl Shared<'_> {
    /// Of a run.
    ///
    /// # Errors
    /// A machine that is not linear between switches; a mass matrix that is not positive definite; friction on a motion imposed by harmonics.
    pub fn new(train: &Train, span: f64) -> Result<Shared<'_>, Error> {
        if !train.is_piecewise_linear() {
            let message = "the machine is not linear between switches";
            return Err(Error::new(Code::OutOfRange, message).hint("take a method that steps"));
        }
        for branch in &train.branches {
            if let (Law::Friction(_), Some(e)) = (&branch.law, &branch.imposed)
                && !e.harmonics.is_empty()
            {
                let message = format!(
                    "`{}` is dry friction against a motion that is imposed as a harmonic",
                    branch.name
                );
                return Err(Error::new(Code::OutOfRange, message)
                    .hint("impose it by straight lines, or take a method that steps"));
            }
        }
        Ok(Shared {
            root: Root::new(train)?,
            inputs: Inputs::new(train),
            train,
            span,
        })
    }
}
