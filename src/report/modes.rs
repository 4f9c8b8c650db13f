//! Natural modes of a machine: document, table of modes, figures; its tables for a terminal are in `modes_table`.

use std::f64::consts::TAU;

use serde_json::{Map, Value, json};

use super::energy_matrix_plot::draw_energy_matrix;
use super::figure::{Figure, PlotColumn};
use super::json::complex;
use super::mode_shape_plot::draw_mode_shapes;
use super::mode_text::dominant_elements_text;
use super::mode_view::{MAX_NODES, mode_view};
use super::number_format::rpm;
use super::plan::step_lines;
use super::presentation::{Presentation, Provenance, step_times};
use super::table::{Table, decimal, or_blank, power};
use super::train::train;
use super::view::View;
use super::{campbell, modes_table, state_space};
use crate::base::error::Error;
use crate::machine::components::Machine;
use crate::machine::operating_point::{ActiveFlank, TangentStiffness};
use crate::modes::modal_basis::BasisSolution;
use crate::modes::mode::{Mode, modulus};
use crate::modes::sensitivity::{FrequencySensitivity, SensitivityParameter};
use crate::numeric::Complex;
use crate::numeric::sorting::sort_descending;
use crate::plan::modes_run::ModesResult;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::stages::{ModesPlan, StageDecision};
use crate::scene::Scene;

/// Number of components written for each mode.
#[derive(Debug, Clone, Copy, Default)]
pub struct ShapeDetail {
    /// Only so many of the largest components of each shape, energies and sensitivities; all where `None`.
    pub top: Option<usize>,
}

/// Modes drawn at once.
const PANELS: usize = 8;

/// Rows of the plot of energies.
const ROWS: usize = 20;

/// The modes of the machine of a scene.
pub struct ModesReport<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The machine of the scene.
    pub machine: &'a PreparedMachine,
    /// The plan.
    pub plan: ModesPlan,
    /// The modes.
    pub result: ModesResult,
    /// Components in the document.
    pub detail: ShapeDetail,
    /// The mode shown at length, counted from 0, in place of the table of all.
    pub mode: Option<usize>,
}

impl Presentation for ModesReport<'_> {
    fn provenance(&self) -> Provenance<'_> {
        let steps = self.result.trace.iter();
        Provenance {
            title: &self.scene.model.title,
            sources: &self.scene.sources,
            trace: steps.clone().map(|t| t.1).collect(),
            effort: step_times(steps.map(|t| (t.1, t.2))),
            warnings: &self.result.diagnostics,
            ..Provenance::default()
        }
    }

    fn body(&self) -> Result<Value, Error> {
        let (machine, result, detail) = (self.machine, &self.result, self.detail);
        let list: Vec<Value> = (0..result.modes.len())
            .map(|k| mode(machine, result, k, detail))
            .collect();
        Ok(json!({
            "train": train(machine, &self.scene.model),
            "modes": list,
            "contacts": contacts(machine),
            "tangents": tangents(machine),
            "eigensolver": result.solution.map(eigensolver),
            "campbell": result.campbell.as_ref().map(campbell::json),
            "state_space": result.state_space.as_ref().map(|(space, parts)| state_space::state_space_json(space, parts)),
            "reduction": result.reduction.as_ref().map(state_space::reduction_json),
        }))
    }

    fn text(&self) -> String {
        let (machine, result) = (self.machine, &self.result);
        let mut text = match (self.mode, &result.campbell) {
            (Some(k), _) => modes_table::mode(machine, result, k),
            (None, Some(found)) => modes_table::crossings(found, machine.model.rigid.len()),
            (None, None) => modes_table::modes(machine, result),
        };
        if let Some((space, parts)) = &result.state_space {
            text += &state_space::participation_table(space, parts);
        }
        text + &or_blank(result.reduction.as_ref(), state_space::reduction_table)
    }

    fn table(&self) -> Table<'_> {
        let (machine, result) = (&self.machine.machine, &self.result);
        let mut table = Table::new(
            "mode|frequency_hz|damped_frequency_hz|damping_ratio|time_constant_s|rigid|residual|digits_trusted|dominant_element",
        );
        for name in (0..machine.dofs.len()).map(|i| machine.dof_name(i)) {
            table = match result.complex {
                true => [" re", " im"]
                    .iter()
                    .fold(table, |t, part| t.column(&(name.clone() + part), "")),
                false => table.column(&name, ""),
            };
        }
        for (k, mode) in result.modes.iter().enumerate() {
            let swings = mode.rigid || mode.is_oscillatory();
            let cells = [
                (k + 1).to_string(),
                or_blank(swings.then(|| mode.frequency_hz()), decimal),
                or_blank(swings.then(|| mode.eigenvalue.im / TAU), decimal),
                or_blank(modes_table::damping(result, k), decimal),
                or_blank((!swings).then(|| -1.0 / mode.eigenvalue.re), decimal),
                mode.rigid.to_string(),
                power(mode.residual),
                or_blank(trusted_digits(mode), decimal),
                dominant_elements_text(machine, mode, &result.energies[k]),
            ];
            let parts = |z: &Complex| match result.complex {
                true => vec![decimal(z.re), decimal(z.im)],
                false => vec![decimal(z.re)],
            };
            table.row(cells.into_iter().chain(mode.shape.iter().flat_map(parts)));
        }
        table
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let (machine, result, title) = (self.machine, &self.result, &self.scene.model.title);
        if let Some(found) = &result.campbell {
            let operating = operating_rpm(&machine.machine, &found.reference);
            let figure = campbell::figure(found, machine.model.rigid.len(), operating);
            let title = title.clone();
            return Ok(vec![Figure::first(PlotColumn { title, ..figure })]);
        }
        Ok(vec![
            Figure::first(draw_mode_shapes(title, machine, result, PANELS)),
            Figure::new("energies", draw_energy_matrix(title, machine, result, ROWS)),
        ])
    }

    fn views(&self) -> Vec<View> {
        let is_too_long = self.machine.machine.nodes.len() > MAX_NODES;
        if self.result.campbell.is_some() || is_too_long {
            return Vec::new();
        }
        let modes = &self.result.modes;
        let elastic = modes.iter().position(|mode| !mode.rigid).unwrap_or(0);
        let first = self.mode.unwrap_or(elastic);
        vec![mode_view(
            self.machine,
            &self.result,
            &self.scene.model,
            first,
        )]
    }

    fn notes(&self) -> String {
        let steps = self.plan.rows().filter(|(name, decision)| match decision {
            StageDecision::Runs(_) => LISTED.contains(name) || SOLVED.contains(name),
            StageDecision::LeftOut(_) => LISTED.contains(name),
        });
        step_lines(steps)
    }
}

/// The mean speed that the file states for a node, rpm.
fn operating_rpm(machine: &Machine, node: &str) -> Option<f64> {
    let own = |&&(dof, _): &&(usize, f64)| {
        machine.nodes[machine.dofs[dof].node].name == node || machine.dof_name(dof) == node
    };
    machine.speeds.iter().find(own).map(|s| rpm(s.1))
}

/// Steps listed in the notes, done or left out.
const LISTED: [&str; 2] = ["operating point", "complex modes"];

/// Steps listed where they were done.
const SOLVED: [&str; 3] = ["undamped modes", "few modes", "rigid joints"];

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
        "damped_frequency_hz": swings.then(|| mode.eigenvalue.im / TAU),
        "time_constants_s": time_constants,
        "damping_ratio": mode.damping_ratio,
        "light_damping_ratio": energies.estimated_damping_ratio.filter(|_| !result.complex),
        "rigid": mode.rigid,
        "eigenvalue_rad_s": complex(mode.eigenvalue),
        "residual": mode.residual,
        "digits_trusted": trusted_digits(mode),
        "shape": shape(machine, mode, result.complex, detail),
        "kinetic_energy": shares(machine, &energies.kinetic, detail),
        "strain_energy": energies.strain.as_ref().map(|s| shares(machine, s, detail)),
        "dissipation": energies.dissipated.as_ref().map(|s| shares(machine, s, detail)),
        "sensitivities": sensitivities,
    })
}

fn shape(machine: &Machine, mode: &Mode, is_complex: bool, detail: ShapeDetail) -> Value {
    let mut order: Vec<usize> = (0..mode.shape.len()).collect();
    if let Some(top) = detail.top {
        sort_descending(&mut order, |&a| modulus(mode.shape[a]));
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
    sort_descending(&mut sorted, |a| a.1.abs());
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

/// Digits that hold, to a tenth.
fn trusted_digits(mode: &Mode) -> Option<f64> {
    let digits = mode.trusted_digits;
    digits.is_finite().then_some((digits * 10.0).floor() / 10.0)
}

/// Solver of all undamped modes and what it says of their frequencies.
fn eigensolver(solution: BasisSolution) -> Value {
    match solution {
        BasisSolution::Symmetric { bound, n_rotated } => json!({
            "method": "energies", "relative_error_bound": bound, "rotated_modes": n_rotated,
        }),
        BasisSolution::Factored => json!({ "method": "factored form" }),
    }
}
