//! Diagnostics of a transmission-error study: incompatible loops, errors without an order line, slipping belts.

use super::result::TransmissionResult;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::machine::components::Machine;
use crate::transmission::coincidence;
use crate::transmission::order_lines::LineOrigin;

/// Error for rigid joints that close a loop with incompatible errors.
pub(super) fn inconsistent_loop_error(machine: &Machine, loop_branches: &[usize]) -> Error {
    let names: Vec<String> = loop_branches
        .iter()
        .map(|&b| format!("`{}`", machine.branch_name(b)))
        .collect();
    let message = format!(
        "the errors of {} do not fit: these rigid joints close a loop, which would have to break",
        names.join(", ")
    );
    let element = machine.branches[loop_branches[0]].element;
    Error::new(Code::ContradictoryRatios, message)
        .with_span(&machine.elements[element].span)
        .with_hint("give the joints of the loop a stiffness k, which distributes the errors")
}

/// Warnings about the order lines of a result.
pub(super) fn diagnostics(machine: &Machine, result: &TransmissionResult) -> Vec<Diagnostic> {
    let mut list = Vec::new();
    let mut warn = |code, message: String, hint: &str| {
        list.push(Diagnostic {
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
    let without_line: Vec<&str> = (machine.errors.iter().enumerate())
        .filter(|(number, error)| {
            let has_line = result
                .lines
                .iter()
                .any(|row| row.line.origin == LineOrigin::Declared(*number));
            // Errors of flanks of gear files may be merged into the lines of their meshes.
            let is_declared = error.averaged.is_none();
            is_declared && !has_line && !error.waveform.harmonics().iter().all(|h| h.1 == 0.0)
        })
        .map(|(_, error)| error.location.as_str())
        .collect();
    if !without_line.is_empty() {
        let message = format!(
            "errors of elements that do not turn with the output have no line: {}",
            without_line.join(", ")
        );
        warn(
            "still",
            message,
            "they do not turn, or their speed is not tied to the output's",
        );
    }
    // A friction belt between the output and an error source that has a line.
    let may_slip = |element: usize| {
        let pulley = machine
            .gears
            .iter()
            .any(|g| g.element == element && g.teeth.is_none());
        let output_side = coincidence::connected_side(machine, element, result.chain.ends.output);
        let across = result.lines.iter().any(|row| {
            let is_across = row
                .line
                .declared(machine)
                .is_some_and(|error| !output_side[error.rotation_dof]);
            is_across && row.share > 0.0
        });
        machine.elements[element].kind == "belt" && pulley && across
    };
    if let Some(element) = (0..machine.elements.len()).find(|&element| may_slip(element)) {
        let name = &machine.elements[element].name;
        let message =
            format!("{name} is no gear: if it slips, the orders of what lies beyond it wander");
        warn(
            "belt",
            message,
            "orders across a belt are valid to within its slip; a timing belt does not slip",
        );
    }
    list
}
