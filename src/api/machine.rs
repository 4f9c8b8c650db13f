//! A machine at its operating point, and the analyses it takes.

use super::modes::Modes;
use super::motion::Motion;
use super::response::Response;
use super::transmission::TransmissionError;
use crate::base::error::Errors;
use crate::base::time_budget::CancelToken;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::simulate::SimulationResult;
use crate::plan::stages::ModesPlan;
use crate::plan::{modes_run, response, transmission};
use crate::scene::Scene;
use crate::scene::study::{ModesStudy, ResponseStudy, SimulateStudy, TransmissionStudy};

/// A machine, assembled and linearised at its operating point.
pub struct Machine {
    scene: Scene,
    prepared: PreparedMachine,
}

impl Machine {
    pub(super) fn new(scene: Scene) -> Result<Machine, Errors> {
        let prepared = PreparedMachine::new(&scene.model)?;
        Ok(Machine { scene, prepared })
    }

    /// Names of the degrees of freedom, `node.axis`, in the order of mode shapes.
    pub fn dofs(&self) -> Vec<String> {
        self.prepared.machine.dof_names()
    }

    /// Natural modes: frequencies, damping, shapes and energies.
    ///
    /// # Errors
    /// A machine beyond the limits of the method; unknown names in the study.
    pub fn modes(&self, study: &ModesStudy) -> Result<Modes, Errors> {
        let plan = ModesPlan::plan_modes(&self.prepared, study);
        let result = modes_run::run(&self.prepared, study, &plan)?;
        Ok(Modes::new(&self.prepared.machine, result))
    }

    /// Frequency responses of every output to every input over a band.
    ///
    /// # Errors
    /// A study without a band, inputs or outputs; unknown names; a machine beyond the limits of the method.
    pub fn response(&self, study: &ResponseStudy) -> Result<Response, Errors> {
        let result = response::run::run(&self.prepared, study, false)?;
        Ok(Response::new(&self.prepared.machine, result))
    }

    /// Motion in time from the initial state of the scene, at rest by default.
    ///
    /// # Errors
    /// A study without an end; unknown names; whatever stops the integration, with time and state.
    pub fn simulate(&self, study: &SimulateStudy) -> Result<Motion, Errors> {
        let result = SimulationResult::simulate(
            &self.scene,
            &self.prepared,
            study,
            &CancelToken::default(),
            &|_| (),
        )?;
        Ok(Motion::new(result))
    }

    /// Transmission error of a chain by order, from the errors the model declares.
    ///
    /// # Errors
    /// A study without an output; a model without declared errors; unknown names.
    pub fn transmission_error(
        &self,
        study: &TransmissionStudy,
    ) -> Result<TransmissionError, Errors> {
        let result = transmission::run::run(&self.prepared, study)?;
        Ok(TransmissionError::new(&self.prepared.machine, result))
    }
}
