//! State-space models, reduced models and condensation advice, in the document and as tables.

use serde_json::{Value, json};

use super::number_format::{column, percent};
use super::table::{Table, or_dash};
use crate::machine::components::Machine;
use crate::modes::reduction::{CondensableCoordinate, CondensationAdvice};
use crate::modes::state_space::StateSpace;
use crate::modes::state_space::participation::ModalParticipation;
use crate::numeric::{Complex, Matrix};
use crate::plan::modes_run::ReductionResult;

const TURN: f64 = std::f64::consts::TAU;

/// The `state_space` block of a document.
pub fn state_space_json(space: &StateSpace, parts: &[ModalParticipation]) -> Value {
    let mut value = space.to_json();
    value["participation"] = parts
        .iter()
        .map(|p| {
            json!({
                "eigenvalue_rad_s": { "re": p.eigenvalue.re, "im": p.eigenvalue.im },
                "controllability": p.controllability,
                "observability": p.observability,
                "multiplicity": p.multiplicity,
                "reachable": p.controllable,
                "visible": p.observable,
            })
        })
        .collect();
    value
}

/// The `reduction` block of a document: matrices by rows over the reduced coordinates.
pub fn reduction_json(found: &ReductionResult) -> Value {
    let e = &found.model.matrices;
    json!({
        "coordinates": e.names,
        "transform": rows(&e.transform),
        "mass": rows(&e.mass),
        "damping": rows(&e.damping),
        "stiffness": rows(&e.stiffness),
        "frequency_hz": found.omega.iter().map(|w| w / TURN).collect::<Vec<_>>(),
        "full_frequency_hz": found.full.iter().map(|w| w / TURN).collect::<Vec<_>>(),
        "error_measured": found.error.measured,
        "error_estimated": finite(found.error.estimate),
        "error_pointwise": found.error.pointwise,
        "worst_at_hz": found.error.worst_at_hz,
    })
}

/// Possible condensation, as the `advice` block of a plan.
pub fn advice_json(machine: &Machine, advice: &CondensationAdvice, f_max_hz: f64) -> Value {
    let entry = |left: &CondensableCoordinate| json!({ "dof": machine.dof_name(left.dof), "own_hz": finite(left.fixed_frequency_hz) });
    json!({
        "f_max_hz": f_max_hz,
        "leave_out": advice.coordinates.iter().map(entry).collect::<Vec<_>>(),
        "compared": advice.n_compared,
        "worst_change": advice.max_change,
    })
}

fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

fn rows(m: &Matrix) -> Vec<Vec<f64>> {
    (0..m.nrows())
        .map(|i| (0..m.ncols()).map(|j| m[(i, j)]).collect())
        .collect()
}

/// Participation of each mode at each input (controllability) and each output (observability), for few inputs and outputs.
pub fn participation_table(space: &StateSpace, parts: &[ModalParticipation]) -> String {
    const MAX_ROWS: usize = 4;
    let (inputs, outputs) = (
        space.inputs.len().min(MAX_ROWS),
        space.outputs.len().min(MAX_ROWS),
    );
    let from = (space.inputs[..inputs].iter()).map(|name| format!("from {name}"));
    let into = (space.outputs[..outputs].iter()).map(|name| format!("in {name}"));
    let mut table = (from.chain(into)).fold(Table::numeric("frequency [Hz]"), |table, name| {
        table.column(&name, "%")
    });
    let frequencies = column(
        &parts
            .iter()
            .map(|p| size(p.eigenvalue) / TURN)
            .collect::<Vec<_>>(),
    );
    let swings = |p: &ModalParticipation| p.eigenvalue.im != 0.0 || size(p.eigenvalue) == 0.0;
    for (p, frequency) in parts.iter().zip(frequencies) {
        let (reached, seen) = (&p.controllability[..inputs], &p.observability[..outputs]);
        let shares = reached.iter().chain(seen).map(|&x| percent(x));
        let frequency = or_dash(swings(p).then_some(frequency), |text| text);
        table.row(std::iter::once(frequency).chain(shares));
    }
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
    for p in parts.iter().filter(|p| !p.controllable || !p.observable) {
        let what = match (p.controllable, p.observable) {
            (false, false) => "neither controllable nor observable",
            (false, true) => "not controllable",
            _ => "not observable",
        };
        let at = match swings(p) {
            true => format!("{:.4} Hz", size(p.eigenvalue) / TURN),
            false => format!("time constant {:.4} s", -1.0 / p.eigenvalue.re),
        };
        text += &format!("the mode at {at} is {what}\n");
    }
    text + &table.text()
}

/// The reduced machine next to the full one.
pub fn reduction_table(found: &ReductionResult) -> String {
    let hertz = |omega: &[f64]| column(&omega.iter().map(|w| w / TURN).collect::<Vec<_>>());
    let rows = hertz(&found.omega)
        .into_iter()
        .zip(hertz(&found.full))
        .zip(found.omega.iter().zip(&found.full));
    let mut table = Table::numeric("reduced [Hz]|full [Hz]|relative error");
    for ((reduced, full), (r, f)) in rows {
        let change = (*f > 0.0).then(|| (r / f - 1.0).abs());
        table.row([reduced, full, or_dash(change, |x| format!("{x:.1e}"))]);
    }
    let e = &found.error;
    let mut text = format!(
        "\nreduction: {} of {} degrees of freedom\n",
        found.omega.len(),
        found.model.matrices.transform.nrows()
    );
    text += &table.text();
    text + &format!(
        "response between the kept degrees of freedom: error {:.1e} measured, {:.1e} estimated (of the largest response; worst at {:.4} Hz)\n",
        e.measured, e.estimate, e.worst_at_hz
    )
}

/// Possible condensation, and its error.
pub fn advice_table(machine: &Machine, advice: &CondensationAdvice, f_max_hz: f64) -> String {
    if advice.coordinates.is_empty() {
        return format!(
            "\nno degree of freedom can be condensed for the {} frequencies up to {f_max_hz} Hz\n",
            advice.n_compared
        );
    }
    let own = column(
        &advice
            .coordinates
            .iter()
            .map(|left| left.fixed_frequency_hz)
            .collect::<Vec<_>>(),
    );
    let mut table = Table::numeric("dof|local frequency [Hz]");
    for (left, own) in advice.coordinates.iter().zip(own) {
        table.row([machine.dof_name(left.dof), own]);
    }
    let mut text = format!(
        "\ncould be condensed statically: {} degrees of freedom; none is by default\n",
        table.row_count()
    );
    text += &table.text();
    text + &format!(
        "without them the {} frequencies up to {f_max_hz} Hz change by {:.1e} at most\n",
        advice.n_compared, advice.max_change
    )
}

fn size(z: Complex) -> f64 {
    z.re.hypot(z.im)
}
