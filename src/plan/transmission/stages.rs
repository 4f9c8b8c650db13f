//! Stages of a transmission-error study.

use crate::machine::components::Machine;
use crate::plan::stages::StageDecision;
use crate::scene::study::TransmissionStudy;

/// Stages of a study, run and left out.
pub fn plan(machine: &Machine, study: &TransmissionStudy) -> Vec<(&'static str, StageDecision)> {
    let runs = |text: &str| StageDecision::Runs(text.to_string());
    let out = |text: &str| StageDecision::LeftOut(text.to_string());
    let waves = machine
        .branches
        .iter()
        .any(|b| b.stiffness_variation.is_some());
    vec![
        ("ratios", runs("exact fractions of tooth numbers")),
        (
            "rigid joints",
            StageDecision::Runs(format!(
                "{} declared errors to the output",
                machine.errors.len()
            )),
        ),
        (
            "static transmission",
            runs("elastic joints at rest, the driver's angle held"),
        ),
        (
            "mesh stiffness under load",
            match (waves, machine.loads.is_empty()) {
                (true, false) => runs("what carries a torque gives way as its stiffness changes"),
                (true, true) => out("no load is stated"),
                (false, _) => out("no mesh has a stiffness wave"),
            },
        ),
        (
            "at speed",
            match (study.speed, study.speeds) {
                (None, None) => out("no speed was requested"),
                _ => runs("the dynamic stiffness solved at every order"),
            },
        ),
        (
            "budget",
            runs("sums, and percentiles of the range over unknown phases and tolerances"),
        ),
        (
            "second order of offsets",
            out("given as a sum, not line by line"),
        ),
        (
            "flank form and pitch",
            match study.index {
                Some(_) => runs("what repeats from tooth to tooth and what does not"),
                None => out("the work is not indexed"),
            },
        ),
        (
            "record",
            match study.record {
                true => runs("the error over the angle, with its ranges"),
                false => out("no record was requested"),
            },
        ),
    ]
}
