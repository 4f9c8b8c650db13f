//! State-space forms and reduced machines as tables for a terminal.

use comfy_table::CellAlignment;

use super::modes_table::{finish, plain};
use super::number_format::{column, percent};
use crate::machine::components::Machine;
use crate::modes::reduction::CondensationAdvice;
use crate::modes::state_space::StateSpace;
use crate::modes::state_space::participation::ModalParticipation;
use crate::numeric::Complex;
use crate::plan::modes_run::ReductionResult;

const TURN: f64 = std::f64::consts::TAU;

/// Participation of each mode at each input (controllability) and each output (observability), for few inputs and outputs.
pub fn participation(space: &StateSpace, parts: &[ModalParticipation]) -> String {
    const MAX_ROWS: usize = 4;
    let (inputs, outputs) = (
        space.inputs.len().min(MAX_ROWS),
        space.outputs.len().min(MAX_ROWS),
    );
    let mut heads = vec!["frequency".to_string()];
    heads.extend(
        space.inputs[..inputs]
            .iter()
            .map(|name| format!("from {name}")),
    );
    heads.extend(
        space.outputs[..outputs]
            .iter()
            .map(|name| format!("in {name}")),
    );
    let mut units = vec!["Hz".to_string()];
    units.resize(heads.len(), "%".to_string());
    let frequencies = column(
        &parts
            .iter()
            .map(|p| size(p.eigenvalue) / TURN)
            .collect::<Vec<_>>(),
    );
    let swings = |p: &ModalParticipation| p.eigenvalue.im != 0.0 || size(p.eigenvalue) == 0.0;
    let row = |(p, frequency): (&ModalParticipation, String)| {
        let shares = p.controllability[..inputs]
            .iter()
            .chain(&p.observability[..outputs]);
        let frequency = if swings(p) {
            frequency
        } else {
            "–".to_string()
        };
        std::iter::once(frequency)
            .chain(shares.map(|&x| percent(x)))
            .collect()
    };
    let rows: Vec<Vec<String>> = parts.iter().zip(frequencies).map(row).collect();
    let mut text = format!(
        "\nstate space: states {}, inputs {}, outputs {}; ",
        space.states.len(),
        space.inputs.len(),
        space.outputs.len()
    );
    text += &match space.sample_time {
        Some(h) => format!(
            "sampled every {h} s, {} hold\n",
            space.method.map_or("", |hold| hold.name())
        ),
        None => "continuous\n".to_string(),
    };
    for p in parts.iter().filter(|p| !p.reachable || !p.visible) {
        let what = match (p.reachable, p.visible) {
            (false, false) => "neither reached by the inputs nor seen in the outputs",
            (false, true) => "not reached by the inputs",
            _ => "not seen in the outputs",
        };
        let at = match swings(p) {
            true => format!("{:.4} Hz", size(p.eigenvalue) / TURN),
            false => format!("time constant {:.4} s", -1.0 / p.eigenvalue.re),
        };
        text += &format!("the mode at {at} is {what}\n");
    }
    text + &aligned(&heads, &units, &rows)
}

/// The reduced machine next to the full one.
pub fn reduction(found: &ReductionResult) -> String {
    let hertz = |omega: &[f64]| column(&omega.iter().map(|w| w / TURN).collect::<Vec<_>>());
    let rows = hertz(&found.omega)
        .into_iter()
        .zip(hertz(&found.full))
        .zip(found.omega.iter().zip(&found.full));
    let row = |((reduced, full), (r, f)): ((String, String), (&f64, &f64))| {
        let change = if *f > 0.0 {
            format!("{:.1e}", (r / f - 1.0).abs())
        } else {
            "–".to_string()
        };
        vec![reduced, full, change]
    };
    let rows: Vec<Vec<String>> = rows.map(row).collect();
    let heads = ["reduced", "full", "relative error"].map(str::to_string);
    let units = ["Hz", "Hz", ""].map(str::to_string);
    let e = &found.error;
    let mut text = format!(
        "\nreduction: {} of {} freedoms\n",
        found.omega.len(),
        found.model.matrices.transform.nrows()
    );
    text += &aligned(&heads, &units, &rows);
    text + &format!(
        "response between the kept freedoms: error {:.1e} measured, {:.1e} estimated (of the largest response; worst at {:.4} Hz)\n",
        e.measured, e.estimate, e.worst_at_hz
    )
}

/// Possible condensation, and its error.
pub fn advice(machine: &Machine, advice: &CondensationAdvice, f_max_hz: f64) -> String {
    if advice.leave_out.is_empty() {
        return format!(
            "\nnothing could be left out of the {} frequencies up to {f_max_hz} Hz\n",
            advice.compared
        );
    }
    let own = column(
        &advice
            .leave_out
            .iter()
            .map(|left| left.fixed_frequency_hz)
            .collect::<Vec<_>>(),
    );
    let rows: Vec<Vec<String>> = advice
        .leave_out
        .iter()
        .zip(own)
        .map(|(left, own)| vec![machine.dof_name(left.dof), own])
        .collect();
    let mut text = format!(
        "\ncould follow statically: {} freedoms; nothing is left out by itself\n",
        rows.len()
    );
    text += &aligned(
        &["freedom", "alone at"].map(str::to_string),
        &["", "Hz"].map(str::to_string),
        &rows,
    );
    text + &format!(
        "without them the {} frequencies up to {f_max_hz} Hz change by {:.1e} at most\n",
        advice.compared, advice.worst_change
    )
}

fn aligned(heads: &[String], units: &[String], rows: &[Vec<String>]) -> String {
    let mut table = plain();
    table.add_row(heads);
    table.add_row(units);
    for row in rows {
        table.add_row(row);
    }
    for column in table.column_iter_mut() {
        column.set_cell_alignment(CellAlignment::Right);
    }
    finish(&table)
}

fn size(z: Complex) -> f64 {
    z.re.hypot(z.im)
}
