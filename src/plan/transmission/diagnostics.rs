//! Warnings of a transmission-error study.

use super::result::TransmissionResult;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::machine::components::Machine;
use crate::transmission::coincidence;
use crate::transmission::order_lines::LineOrigin;

/// Rigid joints whose errors do not fit the loop they close.
pub(super) fn inconsistent_loop_error(machine: &Machine, loop_of: &[usize]) -> Error {
    let names: Vec<String> = loop_of
        .iter()
        .map(|&b| format!("`{}`", machine.branch_name(b)))
        .collect();
    let message = format!(
        "the errors of {} do not fit: these rigid joints close a loop, which would have to break",
        names.join(", ")
    );
    let element = machine.branches[loop_of[0]].element;
    Error::new(Code::ContradictoryRatios, message)
        .with_span(&machine.elements[element].span)
        .with_hint("give the joints of the loop their stiffness k: it shares the errors out")
}

/// Warnings about lines.
pub(super) fn diagnostics(machine: &Machine, result: &TransmissionResult) -> Vec<Diagnostic> {
    let mut all = Vec::new();
    let mut warn = |code, message: String, hint: &str| {
        all.push(Diagnostic {
            code,
            message,
            hint: Some(hint.to_string()),
        });
    };
    if let Some(names) = &result.inconsistent_loop {
        let message = format!(
            "the errors do not fit the loop through {}: with rigid joints it could not turn",
            names.join(", ")
        );
        warn(
            "loop-misfit",
            message,
            "the table is that of the elastic joints, which share the errors out",
        );
    }
    let still: Vec<&str> = (machine.errors.iter().enumerate())
        .filter(|(number, error)| {
            let has_line = result
                .lines
                .iter()
                .any(|row| row.line.origin == LineOrigin::Declared(*number));
            // Flanks of gear files may have joined the lines of their meshes.
            let own = error.averaged.is_none();
            own && !has_line && !error.waveform.harmonics().iter().all(|h| h.1 == 0.0)
        })
        .map(|(_, error)| error.location.as_str())
        .collect();
    if !still.is_empty() {
        let message = format!(
            "errors of elements that do not turn with the output have no line: {}",
            still.join(", ")
        );
        warn(
            "still",
            message,
            "they do not turn, or their speed is not tied to the output's",
        );
    }
    // What lies on the far side of a friction belt, and still has a line.
    let slips = |at: usize| {
        let pulley = machine
            .gears
            .iter()
            .any(|g| g.element == at && g.teeth.is_none());
        let near = coincidence::connected_side(machine, at, result.chain.ends.output);
        let across = result.lines.iter().any(|row| {
            let far = row
                .line
                .declared(machine)
                .is_some_and(|error| !near[error.rotation_dof]);
            far && row.share > 0.0
        });
        machine.elements[at].kind == "belt" && pulley && across
    };
    if let Some(at) = (0..machine.elements.len()).find(|&at| slips(at)) {
        let name = &machine.elements[at].name;
        let message =
            format!("{name} is no gear: if it slips, the orders of what lies beyond it wander");
        warn(
            "belt",
            message,
            "orders across a belt hold to its slip; a timing belt does not slip",
        );
    }
    all
}
