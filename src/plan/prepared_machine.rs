//! Machine prepared for a study: rigid joints eliminated, operating point found, linearised.

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
use crate::machine::spin::spinning;
use crate::modes::mode_subset;
use crate::numeric::forest::Forest;
use crate::response::system::OperatingModel;
use crate::scene::model::{BranchDamping, GeneratorWork, Model};

/// Machine assembled for analysis.
pub struct PreparedMachine {
    /// Meshes that name gear files.
    pub meshes: MeshStage,
    /// Work that the machine cuts, where it is a generator, with the title of the machine.
    pub work: Option<(Arc<GeneratorWork>, String)>,
    /// Masses and branches.
    pub machine: Machine,
    /// Rigid joints, solved.
    pub kinematics: Kinematics,
    /// Contacts with play.
    pub operating: OperatingPoint,
    /// Linear model of the remaining degrees of freedom.
    pub model: LinearModel,
    /// The linear machine as a forest of springs, where it is one.
    pub forest: Option<Forest>,
    /// Values of the model far outside what machines have.
    pub implausible: Vec<Diagnostic>,
}

impl PreparedMachine {
    /// Builds and linearises a model.
    ///
    /// # Errors
    /// Whatever is wrong with the machine: unknown nodes, contradicting ratios, parts joined to nothing, masses missing; meshes of gear files
    /// that cannot carry their torques.
    pub fn new(model: &Model) -> Result<PreparedMachine, Error> {
        PreparedMachine::with_meshes(model, MeshStage::new(model)?)
    }

    /// A model whose meshes are computed already.
    ///
    /// # Errors
    /// As [`PreparedMachine::new`].
    pub fn with_meshes(model: &Model, meshes: MeshStage) -> Result<PreparedMachine, Error> {
        let model = meshes.filled(model);
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

    /// Stages of a study behind that of the meshes, where the model names gear files.
    pub fn after_meshes(
        &self,
        stages: Vec<(&'static str, StageDecision)>,
    ) -> Vec<(&'static str, StageDecision)> {
        let own = self
            .meshes
            .is_named
            .then(|| ("meshes", self.meshes.decision.clone()));
        own.into_iter().chain(stages).collect()
    }

    /// Mean speed of every degree of freedom, rad/s, at a speed of the first node of `[speed]`; none where none is requested.
    ///
    /// # Errors
    /// Those of [`spinning`].
    pub fn speeds_at(&self, speed: Option<f64>) -> Result<Option<Vec<f64>>, Error> {
        let at = |speed| spinning(&self.machine, &self.kinematics, Some(speed));
        speed.map(at).transpose()
    }

    /// Operating model for frequency responses; with the mean speed of every degree of freedom, rad/s, where gyroscopic terms are
    /// requested.
    pub fn frequency_setting<'a>(&'a self, speeds: Option<&'a [f64]>) -> OperatingModel<'a> {
        OperatingModel {
            machine: &self.machine,
            operating: &self.operating,
            model: &self.model,
            speeds,
        }
    }

    /// Warnings that need no solution.
    pub fn warnings(&self) -> Vec<Diagnostic> {
        let mut all = self.machine.diagnostics.clone();
        let mut warn = |code, message: String, hint: Option<&str>| {
            all.push(Diagnostic {
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
                "{name} is not linear: small motions about a force of {:.4e} (SI) find its tangent stiffness {:.4e} (SI)",
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
            let hint = "state mean torques in [[load]] to find the flanks that carry";
            let message = format!(
                "no load is stated: {playing} contacts with play are taken as closed on their drive flanks"
            );
            warn("no-load", message, Some(hint));
        }
        if self.machine.motors.is_empty() && self.loads_accelerate() {
            let hint =
                "state the torque that holds against them, if the machine is meant to run steadily";
            let message = "the mean loads do not balance: contacts are taken as the train accelerates under them";
            warn("loads-accelerate", message.to_string(), Some(hint));
        }
        if self.machine.damping.mass != 0.0 && !self.model.rigid.is_empty() {
            let hint = "leave rayleigh_mass out of a free machine, or mean it";
            warn(
                "rayleigh-brakes",
                "mass-proportional damping also brakes the rigid-body motion".to_string(),
                Some(hint),
            );
        }
        for (name, what) in self.idle_damping_ratios() {
            let message = format!("damping_ratio of {name} damps nothing: {what}");
            warn(
                "idle-damping",
                message,
                Some("give c or loss_factor, or the node an inertia"),
            );
        }
        if self.has_no_support() {
            let message = "some body moves sideways without any support: that motion is a rigid-body mode too";
            warn(
                "unsupported",
                message.to_string(),
                Some("give every body with lateral axes a bearing"),
            );
        }
        all.extend(self.meshes.diagnostics.iter().cloned());
        all.extend(self.implausible.iter().cloned());
        all
    }

    /// A damping ratio needs a mass on both sides of its branch.
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

    /// The loads do work on a rigid-body motion, so that the train speeds up.
    fn loads_accelerate(&self) -> bool {
        // Of the sum of their works; torques are stated to a few digits.
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
        let turns = |i: &usize| self.machine.dofs[*i].axis.is_rotation();
        self.model.rigid.iter().any(|r| {
            let largest = r.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let moving = self
                .model
                .independent_dofs
                .iter()
                .zip(r)
                .filter(|(_, x)| x.abs() > 1e-9 * largest);
            !moving.clone().any(|(i, _)| turns(i)) && moving.count() > 0
        })
    }
}
