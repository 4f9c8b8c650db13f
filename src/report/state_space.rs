//! State-space models, reduced models and condensation advice as JSON.

use serde_json::{Value, json};

use crate::machine::components::Machine;
use crate::modes::reduction::{CondensableCoordinate, CondensationAdvice};
use crate::modes::state_space::StateSpace;
use crate::modes::state_space::participation::ModalParticipation;
use crate::numeric::Matrix;
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
                "reachable": p.reachable,
                "visible": p.visible,
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
    let entry = |left: &CondensableCoordinate| json!({ "freedom": machine.dof_name(left.dof), "own_hz": finite(left.fixed_frequency_hz) });
    json!({
        "f_max_hz": f_max_hz,
        "leave_out": advice.leave_out.iter().map(entry).collect::<Vec<_>>(),
        "compared": advice.compared,
        "worst_change": advice.worst_change,
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
