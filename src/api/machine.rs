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

    /// Natural modes: frequencies, damping, shapes, energies and sensitivities, with the Campbell diagram, the state-space form and the
    /// reduced machine that the study requests.
    ///
    /// ```
    /// # use geardyn::prelude::*;
    /// let machine = Model::open("models/two_disc.toml")?.machine()?;
    /// let modes = machine.modes(&ModesStudy::default())?;
    /// assert!(modes[0].is_rigid && modes[1].frequency_hz > 0.0);
    /// # Ok::<(), Errors>(())
    /// ```
    ///
    /// # Errors
    /// A machine beyond the limits of the method; unknown names in the study.
    pub fn modes(&self, study: &ModesStudy) -> Result<Modes, Errors> {
        let plan = ModesPlan::plan_modes(&self.prepared, study);
        let result = modes_run::run(&self.prepared, study, &plan)?;
        Ok(Modes::new(&self.prepared, result))
    }

    /// Frequency responses of every output to every input over a band, rad/s.
    ///
    /// ```
    /// # use geardyn::prelude::*;
    /// let machine = Model::open("models/y2250.toml")?.machine()?;
    /// let response = machine.response(&ResponseStudy {
    ///     inputs: vec!["motor".into()],
    ///     outputs: vec!["workpiece".into()],
    ///     band: Some((6.3, 630.0)),
    ///     ..ResponseStudy::default()
    /// })?;
    /// assert!(!response.functions[0].peaks.is_empty());
    /// # Ok::<(), Errors>(())
    /// ```
    ///
    /// # Errors
    /// A study without a band, inputs or outputs; unknown names; a machine beyond the limits of the method.
    pub fn response(&self, study: &ResponseStudy) -> Result<Response, Errors> {
        let result = response::run::run(&self.prepared, study, false)?;
        Ok(Response::new(&self.prepared.machine, result))
    }

    /// Motion in time from the initial state of the scene, at rest by default. Sensitivity to the initial conditions and analyses during
    /// the run are of the command alone.
    ///
    /// ```
    /// # use geardyn::prelude::*;
    /// let machine = Model::open("examples/linear_chain.toml")?.machine()?;
    /// let motion = machine.simulate(&SimulateStudy {
    ///     end_time: Some(0.01),
    ///     outputs: vec!["chain.20.theta".into()],
    ///     ..SimulateStudy::default()
    /// })?;
    /// assert_eq!(motion.outputs[0].values.len(), motion.time_s.len());
    /// # Ok::<(), Errors>(())
    /// ```
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

    /// Transmission error of a chain by order, from the errors the model declares, over speed and over the angle where the study requests
    /// it. The flank of a generator's work is of the command alone.
    ///
    /// ```
    /// # use geardyn::prelude::*;
    /// let machine = Model::open("examples/y2250_te.toml")?.machine()?;
    /// let error = machine.transmission_error(&TransmissionStudy {
    ///     output: Some("work_spindle".into()),
    ///     ..TransmissionStudy::default()
    /// })?;
    /// assert!(error.rss < error.worst_case);
    /// # Ok::<(), Errors>(())
    /// ```
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
