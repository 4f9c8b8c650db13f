//! The plan of a scene as it is shown by `plan`: modes, every study of motion, possible condensation.

use serde_json::{Value, json};

use super::plan::{stages, steps, text};
use super::presentation::{Presentation, Provenance};
use super::state_space::{advice_json, advice_table};
use crate::base::error::{Diagnostic, Error};
use crate::modes::reduction::CondensationAdvice;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::{ModesPlan, StageDecision};
use crate::scene::Scene;

/// The kind of a study of motion and its plan.
pub type MotionPlan = (&'static str, Vec<(&'static str, StageDecision)>);

/// The plan of everything that a scene asks for.
pub struct PlanReport<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The machine of the scene.
    pub machine: PreparedMachine,
    /// The plan of a study of modes.
    pub modes: ModesPlan,
    /// It is shown at a terminal.
    pub modes_shown: bool,
    /// The plan of every study of motion.
    pub motions: Vec<MotionPlan>,
    /// A band, Hz, and the condensation that is possible in it.
    pub advice: Option<(f64, CondensationAdvice)>,
    /// Warnings about the machine.
    pub warnings: Vec<Diagnostic>,
}

impl Presentation for PlanReport<'_> {
    fn provenance(&self) -> Provenance<'_> {
        let runs = |s: &(&str, &StageDecision)| matches!(s.1, StageDecision::Runs(_));
        Provenance {
            title: &self.scene.model.title,
            sources: &self.scene.sources,
            trace: self.modes.rows().filter(runs).map(|s| s.0).collect(),
            warnings: &self.warnings,
            ..Provenance::default()
        }
    }

    fn body(&self) -> Result<Value, Error> {
        let motion =
            |(kind, plan): &MotionPlan| json!({ "kind": kind, "stages": stages(steps(plan)) });
        let mut body = json!({
            "stages": stages(self.modes.rows()),
            "motions": self.motions.iter().map(motion).collect::<Vec<_>>(),
        });
        if let Some((hz, advice)) = &self.advice {
            body["advice"] = advice_json(&self.machine.machine, advice, *hz);
        }
        Ok(body)
    }

    fn text(&self) -> String {
        let mut shown = match self.modes_shown {
            true => text(self.modes.rows()),
            false => String::new(),
        };
        for (kind, plan) in &self.motions {
            let gap = if shown.is_empty() { "" } else { "\n" };
            shown += &format!("{gap}── {kind}\n{}", text(steps(plan)));
        }
        if let Some((hz, advice)) = &self.advice {
            shown += &advice_table(&self.machine.machine, advice, *hz);
        }
        shown
    }
}
