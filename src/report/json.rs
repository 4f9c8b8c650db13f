//! Results as JSON: units in the names, complex numbers as `{re, im}`, nonexistent values as null. See docs/json.md.

use std::sync::Arc;

use serde_json::{Map, Value, json};

use super::{campbell, state_space};
use crate::base::error::Diagnostic;
use crate::base::source_span::SourceFile;
use crate::machine::components::Machine;
use crate::machine::operating_point::{ActiveFlank, TangentStiffness};
use crate::modes::mode::{Mode, modulus};
use crate::modes::sensitivity::{FrequencySensitivity, SensitivityParameter};
use crate::numeric::Complex;
use crate::plan::modes_run::ModesResult;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::StageDecision;

/// Number of components written for each mode.
#[derive(Debug, Clone, Copy, Default)]
pub struct ShapeDetail {
    /// Only so many of the largest components of each shape, energies and sensitivities; all where `None`.
    pub top: Option<usize>,
}

/// The `geardyn` block every document has.
pub fn header(sources: &[Arc<SourceFile>], trace: &[&str]) -> Value {
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "model_hash": hash(sources),
        "trace": trace,
    })
}

/// The `geardyn` block of a document about a log.
pub fn log_header(trace: &[&str]) -> Value {
    json!({ "version": env!("CARGO_PKG_VERSION"), "model_hash": null, "trace": trace })
}

/// Warnings as a list.
pub fn warnings(list: &[Diagnostic]) -> Value {
    list.iter()
        .map(|w| json!({ "code": w.code, "message": w.message, "hint": w.hint }))
        .collect()
}

/// The modes of a machine.
pub fn modes(
    sources: &[Arc<SourceFile>],
    machine: &PreparedMachine,
    result: &ModesResult,
    detail: ShapeDetail,
) -> Value {
    let trace: Vec<&str> = result.trace.iter().map(|t| t.1).collect();
    let list: Vec<Value> = (0..result.modes.len())
        .map(|k| mode(machine, result, k, detail))
        .collect();
    json!({
        "geardyn": header(sources, &trace),
        "modes": list,
        "contacts": contacts(machine),
        "tangents": tangents(machine),
        "campbell": result.campbell.as_ref().map(campbell::json),
        "state_space": result.state_space.as_ref().map(|(space, parts)| state_space::state_space_json(space, parts)),
        "reduction": result.reduction.as_ref().map(state_space::reduction_json),
        "effort": result.trace.iter().map(|t| json!({ "stage": t.1, "time_s": t.2 })).collect::<Vec<_>>(),
        "warnings": warnings(&result.diagnostics),
    })
}

/// Operating point: the state of every contact with play, and its force, N or N·m.
fn contacts(machine: &PreparedMachine) -> Value {
    let contact = |(branch, state, force): &(usize, ActiveFlank, Option<f64>)| {
        json!({
            "branch": machine.machine.branch_name(*branch),
            "state": state.name(),
            "force_si": force,
        })
    };
    machine.operating.contacts.iter().map(contact).collect()
}

/// Nonlinear elements: the force at the operating point, N or N·m, and the tangent stiffness there, N/m or N·m/rad.
fn tangents(machine: &PreparedMachine) -> Value {
    let tangent = |t: &TangentStiffness| {
        json!({
            "branch": machine.machine.branch_name(t.branch),
            "force_si": t.force,
            "stiffness_si": t.stiffness,
        })
    };
    machine.operating.tangents.iter().map(tangent).collect()
}

/// A plan.
pub fn plan<'a>(
    sources: &[Arc<SourceFile>],
    steps: impl Iterator<Item = (&'a str, &'a StageDecision)> + Clone,
    doubts: &[Diagnostic],
) -> Value {
    let runs = steps
        .clone()
        .filter(|s| matches!(s.1, StageDecision::Runs(_)));
    let names: Vec<&str> = runs.map(|s| s.0).collect();
    json!({
        "geardyn": header(sources, &names),
        "stages": stages(steps),
        "warnings": warnings(doubts),
    })
}

/// Stages with what they do or why they are left out.
pub fn stages<'a>(steps: impl Iterator<Item = (&'a str, &'a StageDecision)>) -> Value {
    let stage = |(name, decision): (&str, &StageDecision)| match decision {
        StageDecision::Runs(what) => json!({ "stage": name, "runs": true, "what": what }),
        StageDecision::LeftOut(why) => json!({ "stage": name, "runs": false, "why": why }),
    };
    steps.map(stage).collect()
}

fn mode(
    prepared_machine: &PreparedMachine,
    result: &ModesResult,
    k: usize,
    detail: ShapeDetail,
) -> Value {
    let machine = &prepared_machine.machine;
    let mode = &result.modes[k];
    let energies = &result.energies[k];
    let sensitivities = result
        .sensitivities
        .as_ref()
        .map(|all| sensitivities(machine, &all[k], detail));
    let swings = mode.rigid || mode.is_oscillatory();
    let time_constants = (!swings).then(|| vec![-1.0 / mode.eigenvalue.re]);
    json!({
        "mode": k + 1,
        "frequency_hz": swings.then(|| mode.frequency_hz()),
        "damped_frequency_hz": swings.then(|| mode.eigenvalue.im / std::f64::consts::TAU),
        "time_constants_s": time_constants,
        "damping_ratio": mode.damping_ratio,
        "light_damping_ratio": energies.estimated_damping_ratio.filter(|_| !result.complex),
        "rigid": mode.rigid,
        "eigenvalue_rad_s": complex(mode.eigenvalue),
        "residual": mode.residual,
        "digits_trusted": mode.trusted_digits.is_finite().then_some((mode.trusted_digits * 10.0).floor() / 10.0),
        "shape": shape(machine, mode, result.complex, detail),
        "kinetic_energy": shares(machine, &energies.kinetic, detail),
        "strain_energy": energies.strain.as_ref().map(|s| shares(machine, s, detail)),
        "dissipation": energies.dissipated.as_ref().map(|s| shares(machine, s, detail)),
        "sensitivities": sensitivities,
    })
}

/// `{re, im}`.
pub fn complex(z: Complex) -> Value {
    json!({ "re": z.re, "im": z.im })
}

fn shape(machine: &Machine, mode: &Mode, is_complex: bool, detail: ShapeDetail) -> Value {
    let mut order: Vec<usize> = (0..mode.shape.len()).collect();
    if let Some(top) = detail.top {
        order.sort_by(|&a, &b| modulus(mode.shape[b]).total_cmp(&modulus(mode.shape[a])));
        order.truncate(top);
        order.sort_unstable();
    }
    let value = |z: Complex| if is_complex { complex(z) } else { json!(z.re) };
    let entries = order
        .into_iter()
        .map(|i| (machine.dof_name(i), value(mode.shape[i])));
    Value::Object(entries.collect())
}

fn shares(machine: &Machine, shares: &[(usize, f64)], detail: ShapeDetail) -> Value {
    let mut sorted = shares.to_vec();
    sorted.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
    sorted.truncate(detail.top.unwrap_or(usize::MAX));
    let entries = sorted
        .into_iter()
        .map(|(e, share)| (machine.elements[e].name.clone(), json!(share)));
    Value::Object(entries.collect::<Map<String, Value>>())
}

fn sensitivities(machine: &Machine, list: &[FrequencySensitivity], detail: ShapeDetail) -> Value {
    let entry = |s: &FrequencySensitivity| {
        json!({
            "element": machine.elements[s.element].name,
            "parameter": match s.parameter { SensitivityParameter::Stiffness => "stiffness", SensitivityParameter::Inertia => "inertia" },
            "relative": s.relative,
            "domega_dparameter": s.absolute,
        })
    };
    list.iter()
        .take(detail.top.unwrap_or(usize::MAX))
        .map(entry)
        .collect()
}

/// FNV-1a, 64 bits (Fowler, Noll & Vo), of every text read: the same input has the same hash on every machine.
fn hash(sources: &[Arc<SourceFile>]) -> String {
    let bytes = sources.iter().flat_map(|source| source.text.bytes());
    let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |h, b| {
        (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3)
    });
    format!("{hash:016x}")
}
