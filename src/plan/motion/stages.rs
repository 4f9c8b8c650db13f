//! The stages of a motion: what runs, what is left out and why.

use super::method_choice::MethodChoice;
use super::simulation_setup::SimulationSetup;
use super::structure::structure_text;
use crate::base::text::pluralise;
use crate::motion::dynamic_model::DynamicModel;
use crate::motion::methods::StepControl;
use crate::motion::prescribed::PrescribedMotion;
use crate::plan::stages::StageDecision;
use crate::scene::study::SimulateStudy;

/// The plan of a motion, row by row.
pub fn plan(
    setup: &SimulationSetup,
    choice: &MethodChoice,
    study: &SimulateStudy,
) -> Vec<(&'static str, StageDecision)> {
    let model = &setup.model.model;
    let branches = match model.elements.len() {
        1 => "1 branch".to_string(),
        n => format!("{n} branches"),
    };
    let outputs = setup.outputs.list.len();
    let mut rows = vec![
        (
            "equations",
            StageDecision::Runs(format!(
                "{}, {}, {}",
                pluralise(model.coordinate_count(), "coordinate"),
                branches,
                pluralise(model.forces.len(), "load")
            )),
        ),
        ("structure", StageDecision::Runs(structure_text(model))),
    ];
    if let Some(known) = &setup.model.prescribed {
        let moved = |m: &PrescribedMotion| {
            let name = &known.full_model.coordinates[m.coordinate];
            format!("{name} by {}", m.name)
        };
        let moved: Vec<String> = known.motions.iter().map(moved).collect();
        let message = format!("{}: prescribed, not an unknown", moved.join(", "));
        rows.push(("prescribed motion", StageDecision::LeftOut(message)));
    }
    rows.extend([
        (
            "method",
            StageDecision::Runs(format!("{}: {}", choice.method.name, choice.reason)),
        ),
        (
            "outputs",
            StageDecision::Runs(format!(
                "{} {} at {} instants, every {}; of {} no history",
                pluralise(outputs, "signal"),
                if study.running.history {
                    "kept"
                } else {
                    "computed, not stored,"
                },
                setup.samples + 1,
                crate::base::quantity::format_time(setup.end_time / setup.samples as f64),
                pluralise(
                    2 * model.coordinate_count() + model.internal_count(),
                    "state"
                )
            )),
        ),
    ]);
    let lateral = model.coordinates.iter().any(|c| !c.ends_with(".theta"));
    if !lateral {
        rows.push((
            "lateral motion",
            StageDecision::LeftOut("no bearing supports a lateral degree of freedom".to_string()),
        ));
    }
    if model.is_linear() {
        rows.push((
            "events",
            StageDecision::LeftOut("nothing can switch".to_string()),
        ));
        rows.push((
            "Newton iterations",
            StageDecision::LeftOut("the equations are linear".to_string()),
        ));
    }
    rows.push(("sensitivity", sensitivity(model, choice, study)));
    rows.push((
        "energy balance",
        match study.energy {
            true => StageDecision::Runs(
                "powers integrated over the motion, between switches and kinks".to_string(),
            ),
            false => StageDecision::LeftOut("not requested".to_string()),
        },
    ));
    rows
}

/// Comparison that measures the sensitivity to initial conditions, and its cost.
fn sensitivity(
    model: &DynamicModel,
    choice: &MethodChoice,
    study: &SimulateStudy,
) -> StageDecision {
    if study.no_sensitivity {
        return StageDecision::LeftOut("not requested".to_string());
    }
    if model.is_linear_in_state() {
        let why = "the equations are linear in the state: differences of motions do not depend on the motion";
        return StageDecision::LeftOut(why.to_string());
    }
    StageDecision::Runs(match choice.method.step_control {
        StepControl::Exact => "a second run from a perturbed initial state, for the same time again".to_string(),
        StepControl::Adaptive => {
            "a second run from a perturbed initial state with ten times the tolerance, for 0.6 to 1 times the time; if digits are lost, a third for the same time again".to_string()
        }
        StepControl::Fixed => {
            "a second run from a perturbed initial state with 0.8 times the step, for 1.25 times the time; if digits are lost, a third for the same time again".to_string()
        }
    })
}
