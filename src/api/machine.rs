//! A machine at its operating point, and the analyses it takes.

use super::modes::Modes;
use super::motion::Motion;
use super::response::Response;
use super::transmission::TransmissionError;
use crate::base::error::Errors;
use crate::base::stop::Stop;
use crate::plan::prepared::Prepared;
use crate::plan::simulate::Moved;
use crate::plan::stages::Plan;
use crate::plan::{response, run, transmission};
use crate::scene::Scene;
use crate::scene::study::{ModesStudy, ResponseStudy, SimulateStudy, TransmissionStudy};

/// A machine, assembled and linearised at its operating point.
pub struct Machine {
    scene: Scene,
    prepared: Prepared,
}

impl Machine {
    pub(super) fn new(scene: Scene) -> Result<Machine, Errors> {
        let prepared = Prepared::new(&scene.model)?;
        Ok(Machine { scene, prepared })
    }

    /// Names of the degrees of freedom, `node.axis`, in the order of mode shapes.
    pub fn dofs(&self) -> Vec<String> {
        let machine = &self.prepared.machine;
        (0..machine.freedoms.len())
            .map(|k| machine.freedom_name(k))
            .collect()
    }

    /// Natural modes: frequencies, damping, shapes and energies.
    ///
    /// # Errors
    /// A machine beyond the limits of the method; unknown names in the study.
    pub fn modes(&self, study: &ModesStudy) -> Result<Modes, Errors> {
        let plan = Plan::modes(&self.prepared, study);
        let answer = run::run(&self.prepared, study, &plan)?;
        Ok(Modes::new(&self.prepared.machine, answer))
    }

    /// Frequency responses of every output to every input over a band.
    ///
    /// # Errors
    /// A study without a band, inputs or outputs; unknown names; a machine beyond the limits of the method.
    pub fn response(&self, study: &ResponseStudy) -> Result<Response, Errors> {
        let answer = response::run::run(&self.prepared, study, false)?;
        Ok(Response::new(&self.prepared.machine, answer))
    }

    /// Motion in time from the initial state of the scene, at rest by default.
    ///
    /// # Errors
    /// A study without an end; unknown names; whatever stops the integration, with time and state.
    pub fn simulate(&self, study: &SimulateStudy) -> Result<Motion, Errors> {
        let moved = Moved::new(&self.scene, study, &Stop::default(), &|_| ())?;
        Ok(Motion::new(moved))
    }

    /// Transmission error of a chain by order, from the errors the model declares.
    ///
    /// # Errors
    /// A study without an output; a model without declared errors; unknown names.
    pub fn transmission_error(
        &self,
        study: &TransmissionStudy,
    ) -> Result<TransmissionError, Errors> {
        let answer = transmission::run::run(&self.prepared, study)?;
        Ok(TransmissionError::new(&self.prepared.machine, answer))
    }
}
