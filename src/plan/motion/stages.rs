//! The stages of a motion: what runs, what is left out and why.

use super::choice::Choice;
use super::scene::MotionScene;
use super::structure::structure;
use crate::base::words::counted;
use crate::motion::methods::Ladder;
use crate::motion::prescribed::Motion;
use crate::motion::train::Train;
use crate::plan::stages::Verdict;
use crate::scene::study::SimulateStudy;

/// The plan of a motion, row by row.
pub fn plan(
    scene: &MotionScene,
    choice: &Choice,
    study: &SimulateStudy,
) -> Vec<(&'static str, Verdict)> {
    let train = &scene.moving.train;
    let branches = match train.branches.len() {
        1 => "1 branch".to_string(),
        n => format!("{n} branches"),
    };
    let outputs = scene.outputs.list.len();
    let mut rows = vec![
        (
            "equations",
            Verdict::Runs(format!(
                "{}, {}, {}",
                counted(train.n(), "coordinate"),
                branches,
                counted(train.drives.len(), "load")
            )),
        ),
        ("structure", Verdict::Runs(structure(train))),
    ];
    if let Some(known) = &scene.moving.prescribed {
        let moved = |m: &Motion| {
            let name = &known.whole.coordinates[m.coordinate];
            format!("{name} by {}", m.name)
        };
        let moved: Vec<String> = known.motions.iter().map(moved).collect();
        let message = format!("{}: known in time, so no unknown", moved.join(", "));
        rows.push(("prescribed motion", Verdict::LeftOut(message)));
    }
    rows.extend([
        (
            "method",
            Verdict::Runs(format!("{}: {}", choice.method.name, choice.reason)),
        ),
        (
            "outputs",
            Verdict::Runs(format!(
                "{} {} at {} instants, every {}; of {} no history",
                counted(outputs, "signal"),
                if study.running.history {
                    "kept"
                } else {
                    "seen, none kept,"
                },
                scene.samples + 1,
                crate::base::units::seconds(scene.until / scene.samples as f64),
                counted(2 * train.n() + train.inner(), "state")
            )),
        ),
    ]);
    let lateral = train.coordinates.iter().any(|c| !c.ends_with(".theta"));
    if !lateral {
        rows.push((
            "lateral motion",
            Verdict::LeftOut("no bearing supports a lateral freedom".to_string()),
        ));
    }
    if train.is_linear() {
        rows.push(("events", Verdict::LeftOut("nothing can switch".to_string())));
        rows.push((
            "Newton iterations",
            Verdict::LeftOut("the equations are linear".to_string()),
        ));
    }
    rows.push(("sensitivity", sensitivity(train, choice, study)));
    rows.push((
        "energy balance",
        match study.energy {
            true => Verdict::Runs(
                "powers added up along the motion, between switches and kinks".to_string(),
            ),
            false => Verdict::LeftOut("not asked for".to_string()),
        },
    ));
    rows
}

/// What is compared to tell how a motion amplifies a change of its start, and at what cost.
fn sensitivity(train: &Train, choice: &Choice, study: &SimulateStudy) -> Verdict {
    if study.no_sensitivity {
        return Verdict::LeftOut("not requested".to_string());
    }
    if train.superposes() {
        let why = "the equations are linear in the state: differences of motions do not depend on the motion";
        return Verdict::LeftOut(why.to_string());
    }
    Verdict::Runs(match choice.method.ladder {
        Ladder::Exact => "a second run from a changed start, for as much time again".to_string(),
        Ladder::Tolerance => {
            "a second run from a changed start with ten times the tolerance, for 0.6 to 1 times the time; where digits are lost, a third for as much time again".to_string()
        }
        Ladder::Step => {
            "a second run from a changed start with 0.8 times the step, for 1.25 times the time; where digits are lost, a third for as much time again".to_string()
        }
    })
}
