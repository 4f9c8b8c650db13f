//! Machine prepared for a study: rigid joints eliminated, operating point solved, equations linearised.

use std::sync::Arc;

use super::decision::StageDecision;
use super::meshes::stage::MeshStage;
use super::plausible;
use crate::base::error::{Diagnostic, Error};
use crate::machine::build::build;
use crate::machine::components::{BranchLaw, Machine};
use crate::machine::kinematics::Kinematics;
use crate::machine::linear::LinearModel;
use crate::machine::operating_point::{ActiveFlank, OperatingPoint};
use crate::machine::spin::spin_speeds;
use crate::modes::mode_subset;
use crate::numeric::forest::Forest;
use crate::response::system::OperatingModel;
use crate::scene::model::{BranchDamping, GeneratorWork, Model};

/// Machine with its operating point and its linear model.
pub struct PreparedMachine {
    /// Meshes defined by gear files.
    pub meshes: MeshStage,
    /// Workpiece of the machine if it is a gear generator, with the title of the machine.
    pub work: Option<(Arc<GeneratorWork>, String)>,
    /// Degrees of freedom, inertias and branches.
    pub machine: Machine,
    /// Kinematics of the rigid joints.
    pub kinematics: Kinematics,
    /// Operating point: active flanks of contacts with backlash, tangent stiffnesses.
    pub operating: OperatingPoint,
    /// Linear model of the independent degrees of freedom.
    pub model: LinearModel,
    /// Linear model as a forest of springs; `None` for a model of another form.
    pub forest: Option<Forest>,
    /// Warnings for implausible values of the model.
    pub implausible: Vec<Diagnostic>,
}

impl PreparedMachine {
    /// Builds and linearises a model.
    ///
    /// # Errors
    /// Faults of the machine: unknown nodes, contradicting ratios, unconnected parts, missing inertias, meshes of gear files that cannot
    /// carry their torques.
    pub fn new(model: &Model) -> Result<PreparedMachine, Error> {
        PreparedMachine::with_meshes(model, MeshStage::new(model)?)
    }

    /// Builds and linearises a model whose meshes are already computed.
    ///
    /// # Errors
    /// Errors of [`PreparedMachine::new`].
    pub fn with_meshes(model: &Model, meshes: MeshStage) -> Result<PreparedMachine, Error> {
        let model = meshes.with_curves(model);
        let machine = build(&model)?;
        let kinematics = Kinematics::new(&machine)?;
        let operating = OperatingPoint::solve(&machine, &kinematics)?;
        let linear_model = LinearModel::new(&machine, &kinematics, &operating)?;
        let forest = mode_subset::as_forest(&linear_model);
        let implausible = plausible::warnings(&model, &machine, &kinematics);
        Ok(PreparedMachine {
            work: (model.work.clone()).map(|work| (work, model.title.clone())),
            meshes,
            implausible,
            machine,
            kinematics,
            operating,
            model: linear_model,
            forest,
        })
    }

    /// Stages of a study, preceded by that of the meshes if the model names gear files.
    pub fn after_meshes(
        &self,
        stages: Vec<(&'static str, StageDecision)>,
    ) -> Vec<(&'static str, StageDecision)> {
        let mesh_stage = self
            .meshes
            .has_gear_files
            .then(|| ("meshes", self.meshes.decision.clone()));
        mesh_stage.into_iter().chain(stages).collect()
    }

    /// Mean speed of every degree of freedom, rad/s, for a speed of the first node of `[speed]`, rad/s; `None` without a request.
    ///
    /// # Errors
    /// Errors of [`spinning`].
    pub fn speeds_at(&self, speed: Option<f64>) -> Result<Option<Vec<f64>>, Error> {
        let at = |speed| spin_speeds(&self.machine, &self.kinematics, Some(speed));
        speed.map(at).transpose()
    }

    /// Operating model for frequency responses; `speeds`, the mean speed of every degree of freedom, rad/s, adds gyroscopic terms.
    pub fn operating_model<'a>(&'a self, speeds: Option<&'a [f64]>) -> OperatingModel<'a> {
        OperatingModel {
            machine: &self.machine,
            operating: &self.operating,
            model: &self.model,
            speeds,
        }
    }

    /// Warnings that do not depend on a study.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let mut warnings = self.machine.diagnostics.clone();
        let mut warn = |code, message: String, hint: Option<&str>| {
            warnings.push(Diagnostic {
                code,
                message,
                hint: hint.map(str::to_string),
            });
        };
        for (branch, state, _) in &self.operating.contacts {
            if *state == ActiveFlank::Open {
                let name = self.machine.branch_name(*branch);
                warn(
                    "contact-open",
                    format!("{name} is open under the mean loads: it has no stiffness here"),
                    None,
                );
            }
        }
        for tangent in &self.operating.tangents {
            let name = self.machine.branch_name(tangent.branch);
            let message = format!(
                "{name} is not linear: at a force of {:.4e} (SI) its tangent stiffness is {:.4e} (SI)",
                tangent.force, tangent.stiffness
            );
            let flat = "it has no stiffness there: state the mean torque in [[load]]";
            warn(
                "linearised",
                message,
                (tangent.stiffness == 0.0).then_some(flat),
            );
        }
        let playing = self.operating.contacts.len();
        if playing > 0 && self.machine.loads.is_empty() {
            let hint = "state mean torques in [[load]] to determine the loaded flanks";
            let message = format!(
                "no load is stated: {playing} contacts with play are assumed closed on their drive flanks"
            );
            warn("no-load", message, Some(hint));
        }
        if self.machine.motors.is_empty() && self.loads_accelerate() {
            let hint = "state the balancing torque if the machine runs at steady speed";
            let message = "the mean loads do not balance: contact states are those of the accelerating machine";
            warn("loads-accelerate", message.to_string(), Some(hint));
        }
        if self.machine.damping.mass != 0.0 && !self.model.rigid.is_empty() {
            let hint = "omit rayleigh_mass for a free machine, unless intended";
            warn(
                "rayleigh-brakes",
                "mass-proportional damping also brakes the rigid-body motion".to_string(),
                Some(hint),
            );
        }
        for (name, what) in self.idle_damping_ratios() {
            let message = format!("damping_ratio of {name} has no effect: {what}");
            warn(
                "idle-damping",
                message,
                Some("state c or loss_factor, or give the node an inertia"),
            );
        }
        if self.has_no_support() {
            let message = "a body has no lateral support: its lateral motion is an additional rigid-body mode";
            warn(
                "unsupported",
                message.to_string(),
                Some("give every body with lateral axes a bearing"),
            );
        }
        warnings.extend(self.meshes.diagnostics.iter().cloned());
        warnings.extend(self.implausible.iter().cloned());
        warnings
    }

    /// Branches whose damping ratio has no effect, since it requires an inertia at both ends.
    fn idle_damping_ratios(&self) -> Vec<(String, &'static str)> {
        let has_ratio = |b: &&crate::machine::linear::LinearBranch| matches!(self.machine.branches[b.index].law, BranchLaw::Linear { loss: BranchDamping::Ratio(zeta), .. } if zeta > 0.0);
        let idle = self
            .model
            .branches
            .iter()
            .filter(has_ratio)
            .filter(|b| b.damping == 0.0);
        idle.map(|b| {
            (
                self.machine.branch_name(b.index),
                "one of its ends is massless",
            )
        })
        .collect()
    }

    /// True if the loads do work on a rigid-body mode and accelerate the machine.
    fn loads_accelerate(&self) -> bool {
        // Relative to the sum of absolute works; torques are stated to a few digits.
        const POWER_TOLERANCE: f64 = 1e-3;
        self.model.rigid.iter().any(|r| {
            let q = self.model.expand(r);
            let works = self
                .machine
                .loads
                .iter()
                .map(|&(dof, torque)| torque * q[dof]);
            let (sum, size) = works.fold((0.0, 0.0), |(sum, size): (f64, f64), w| {
                (sum + w, size + w.abs())
            });
            sum.abs() > POWER_TOLERANCE * size
        })
    }

    fn has_no_support(&self) -> bool {
        let is_angle = |i: &usize| self.machine.dofs[*i].axis.is_rotation();
        self.model.rigid.iter().any(|r| {
            let largest = r.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let moving = self
                .model
                .independent_dofs
                .iter()
                .zip(r)
                .filter(|(_, x)| x.abs() > 1e-9 * largest);
            !moving.clone().any(|(i, _)| is_angle(i)) && moving.count() > 0
        })
    }
}
