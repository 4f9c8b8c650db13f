//! What every study of a machine starts from: its freedoms without rigid joints, at its operating point.

use super::plausible;
use crate::base::error::{Error, Warning};
use crate::machine::build::build;
use crate::machine::kinematics::Kinematics;
use crate::machine::linear::Linear;
use crate::machine::operating::{ContactState, Operating};
use crate::machine::parts::{Law, Machine};
use crate::machine::spin::spinning;
use crate::modes::lowest;
use crate::numeric::forest::Forest;
use crate::response::system::Setting;
use crate::scene::model::{Loss, Model};

/// A machine ready to be asked.
pub struct Prepared {
    /// Masses and branches.
    pub machine: Machine,
    /// Rigid joints, solved.
    pub kinematics: Kinematics,
    /// Contacts with play.
    pub operating: Operating,
    /// What is left, linear.
    pub linear: Linear,
    /// The linear machine as a forest of springs, where it is one.
    pub forest: Option<Forest>,
    /// Values of the model far outside what machines have.
    pub implausible: Vec<Warning>,
}

impl Prepared {
    /// Builds and linearises a model.
    ///
    /// # Errors
    /// Whatever is wrong with the machine: unknown nodes, contradicting ratios, parts joined to nothing, masses missing.
    pub fn new(model: &Model) -> Result<Prepared, Error> {
        let machine = build(model)?;
        let kinematics = Kinematics::new(&machine)?;
        let operating = Operating::find(&machine, &kinematics)?;
        let linear = Linear::new(&machine, &kinematics, &operating)?;
        let forest = lowest::forest(&linear);
        let implausible = plausible::warnings(model, &machine, &kinematics);
        Ok(Prepared {
            implausible,
            machine,
            kinematics,
            operating,
            linear,
            forest,
        })
    }

    /// Mean speed of every freedom, rad/s, at a speed of the first node of `[speed]`; none where none is asked.
    ///
    /// # Errors
    /// Those of [`spinning`].
    pub fn speeds_at(&self, speed: Option<f64>) -> Result<Option<Vec<f64>>, Error> {
        let at = |speed| spinning(&self.machine, &self.kinematics, Some(speed));
        speed.map(at).transpose()
    }

    /// The same as frequency responses need it; mean speed of every freedom, rad/s, where gyroscopic terms are asked.
    pub fn setting<'a>(&'a self, speeds: Option<&'a [f64]>) -> Setting<'a> {
        Setting {
            machine: &self.machine,
            operating: &self.operating,
            linear: &self.linear,
            speeds,
        }
    }

    /// What is doubtful before anything is solved.
    pub fn warnings(&self) -> Vec<Warning> {
        let mut all = Vec::new();
        let mut warn = |code, message: String, hint: Option<&str>| {
            all.push(Warning {
                code,
                message,
                hint: hint.map(str::to_string),
            });
        };
        for note in &self.machine.notes {
            warn(note.code, note.text.clone(), None);
        }
        for (branch, state, _) in &self.operating.contacts {
            if *state == ContactState::Open {
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
        if self.machine.motors.is_empty() && self.accelerates() {
            let hint =
                "state the torque that holds against them, if the machine is meant to run steadily";
            let message = "the mean loads do not balance: contacts are taken as the train accelerates under them";
            warn("loads-accelerate", message.to_string(), Some(hint));
        }
        if self.machine.damping.mass != 0.0 && !self.linear.rigid.is_empty() {
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
        if self.unsupported() {
            let message = "some body moves sideways without any support: that motion is a rigid-body mode too";
            warn(
                "unsupported",
                message.to_string(),
                Some("give every body with lateral axes a bearing"),
            );
        }
        all.extend(self.implausible.iter().cloned());
        all
    }

    /// A damping ratio needs a mass on both sides of its branch.
    fn idle_damping_ratios(&self) -> Vec<(String, &'static str)> {
        let has_ratio = |b: &&crate::machine::linear::LinearBranch| matches!(self.machine.branches[b.index].law, Law::Linear { loss: Loss::Ratio(zeta), .. } if zeta > 0.0);
        let idle = self
            .linear
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
    fn accelerates(&self) -> bool {
        // Of the sum of their works; torques are stated to a few digits.
        const BALANCED: f64 = 1e-3;
        self.linear.rigid.iter().any(|r| {
            let q = self.linear.recover(r);
            let works = self
                .machine
                .loads
                .iter()
                .map(|&(freedom, torque)| torque * q[freedom]);
            let (sum, size) = works.fold((0.0, 0.0), |(sum, size): (f64, f64), w| {
                (sum + w, size + w.abs())
            });
            sum.abs() > BALANCED * size
        })
    }

    fn unsupported(&self) -> bool {
        let turns = |i: &usize| self.machine.freedoms[*i].axis.turns();
        self.linear.rigid.iter().any(|r| {
            let largest = r.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let moving = self
                .linear
                .free
                .iter()
                .zip(r)
                .filter(|(_, x)| x.abs() > 1e-9 * largest);
            !moving.clone().any(|(i, _)| turns(i)) && moving.count() > 0
        })
    }
}
