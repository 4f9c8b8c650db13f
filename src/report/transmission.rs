//! Transmission error of a chain: document, table of lines, record over the angle.

use std::f64::consts::PI;

use serde_json::{Value, json};

use super::figure::Figure;
use super::presentation::{Presentation, Provenance};
use super::surface_view::work_view;
use super::table::{Table, decimal, or_blank};
use super::te_lines::{TeUnit, separation_test_text};
use super::transmission_plots::draw_all;
use super::view::View;
use super::{transmission_table, work};
use crate::base::error::Error;
use crate::machine::components::Machine;
use crate::numeric::Complex;
use crate::plan::prepared_machine::PreparedMachine;
use crate::plan::transmission::error_record::TransmissionErrorRecord;
use crate::plan::transmission::result::TransmissionResult;
use crate::scene::Scene;
use crate::transmission::budget::{ElementSensitivity, ErrorBudget};
use crate::transmission::indexing::IndexingEffect;

/// The transmission error of a chain in the machine of a scene.
pub struct TransmissionReport<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The machine of the scene.
    pub machine: &'a PreparedMachine,
    /// The lines and what they add up to.
    pub result: TransmissionResult,
    /// Every line is shown, not the largest only.
    pub all: bool,
}

impl Presentation for TransmissionReport<'_> {
    fn provenance(&self) -> Provenance<'_> {
        let result = &self.result;
        Provenance {
            title: &self.scene.model.title,
            ..Provenance::of_plan(&self.scene.sources, &result.plan, &result.diagnostics)
        }
    }

    fn body(&self) -> Result<Value, Error> {
        Ok(body(&self.machine.machine, &self.result))
    }

    fn text(&self) -> String {
        let works = self
            .result
            .workpieces
            .iter()
            .map(|w| work::text(w, self.all));
        let table = transmission_table::text(&self.machine.machine, &self.result, self.all);
        table + &works.collect::<String>()
    }

    fn table(&self) -> Table<'_> {
        let (machine, result) = (&self.machine.machine, &self.result);
        let unit = TeUnit::for_output(machine, result);
        let (key, turns) = (unit.key, unit.key != "um");
        let mut table = Table::new("order|order_value|source|cause|harmonic")
            .columns(&format!("amplitude_{key}"))
            .columns_if(turns, "amplitude_um")
            .columns(&format!(
                "phase_deg|share|kinematic_{key}|loaded_{key}|dynamic_{key}"
            ))
            .columns("coincides_with_rows");
        let sized = |z: Complex| decimal(z.norm() * unit.times);
        for (k, row) in result.lines.iter().enumerate() {
            let slow = result.quasi_static(row);
            let group = result.coincidences.iter().find(|c| c.lines.contains(&k));
            let others = group.map_or(&[][..], |group| &group.lines);
            let others = others.iter().filter(|line| **line != k);
            let others: Vec<String> = others.map(|line| (line + 1).to_string()).collect();
            let mut cells = vec![
                row.line.order.to_string(),
                decimal(row.line.order.to_f64()),
                row.source(machine),
                row.cause(machine).to_string(),
                row.line.harmonic.to_string(),
                sized(slow),
            ];
            if turns {
                cells.push(or_blank(result.radius, |r| decimal(1e6 * r * slow.norm())));
            }
            cells.extend([
                or_blank(row.phase(machine, slow), decimal),
                decimal(row.share),
                or_blank(row.kinematic, sized),
                sized(row.loaded),
                or_blank(row.dynamic, sized),
                others.join(" "),
            ]);
            table.row(cells);
        }
        table
    }

    fn views(&self) -> Vec<View> {
        let works = &self.result.workpieces;
        let view = (!works.is_empty()).then(|| work_view(works));
        view.into_iter().collect()
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let title = &self.scene.model.title;
        Ok(draw_all(title, &self.machine.machine, &self.result))
    }
}

impl TransmissionReport<'_> {
    /// The error over the angle: turns that orders are counted by, the error, its time where the speed is given.
    pub fn record(&self) -> Table<'_> {
        let (result, unit) = (
            &self.result,
            TeUnit::for_output(&self.machine.machine, &self.result),
        );
        let Some(made) = &result.record else {
            return Table::default();
        };
        let all = |of: &dyn Fn(usize, f64) -> f64| -> Vec<f64> {
            made.record
                .values
                .iter()
                .enumerate()
                .map(|(i, e)| of(i, *e))
                .collect()
        };
        let count = made.record.values.len() as f64;
        let turns = |i: usize| made.record.turns as f64 * i as f64 / count;
        let mut table = Table::default()
            .numbers("turns", "", all(&|i, _| turns(i)), decimal)
            .numbers("te", unit.name, all(&|_, e| e * unit.times), decimal);
        if let Some(r) = result.radius {
            table = table.numbers("te", "µm", all(&|_, e| 1e6 * r * e), decimal);
        }
        let seconds = result.speed.map(|speed| 2.0 * PI / speed.abs());
        if let Some(s) = seconds.filter(|s| s.is_finite()) {
            table = table.numbers("time", "s", all(&|i, _| s * turns(i)), decimal);
        }
        table
    }
}

/// The document.
fn body(machine: &Machine, result: &TransmissionResult) -> Value {
    let chain = &result.chain;
    let unit = TeUnit::for_output(machine, result);
    let name = |dof: usize| machine.nodes[machine.dofs[dof].node].name.clone();
    let sums = [
        ("wind_up", Some(result.wind_up)),
        ("second_order", Some(result.second_order)),
    ];
    let others = json!({
        "driver": name(chain.ends.driver),
        "output": name(chain.ends.output),
        "against": chain.ends.relative_to.map(name),
        "orders_per_turn_of": name(chain.order_reference),
        "driver_turns": chain.ratio(chain.ends.driver).map(ToString::to_string),
        "period_turns": result.period.as_ref().map(ToString::to_string),
        "joints": if result.has_rigid_solution() { "rigid" } else { "elastic" },
        "radius_m": result.radius,
        "output_speed_rad_s": result.speed,
        "orders": (0..result.lines.len()).map(|k| order(machine, result, k, unit)).collect::<Vec<_>>(),
        "budget": budget(result, &result.budget, &result.negligible, unit),
        "budget_at_speed": result.dynamic_budget.as_ref().map(|fast| budget(result, &fast.budget, &fast.negligible, unit)),
        "map": result.map.as_ref().map(|map| json!({
            "speed_rad_s": map.speeds,
            "largest": map.largest.iter().map(|l| unit.object(&[("amplitude", Some(l.1))], json!({ "speed_rad_s": l.0 }))).collect::<Vec<_>>(),
            (format!("amplitude_{}", unit.key)): map.amplitudes.iter().map(|row| row.iter().map(|a| a * unit.times).collect()).collect::<Vec<Vec<f64>>>(),
        })),
        "works": result.workpieces.iter().map(|w| work::json(w)).collect::<Vec<_>>(),
        "record": result.record.as_ref().map(|made| recorded(made, unit)),
    });
    unit.object(&sums, others)
}

fn recorded(made: &TransmissionErrorRecord, unit: TeUnit) -> Value {
    let by_tooth = |at: usize| made.per_tooth.map(|t| t[at]);
    let ranges = [
        ("total", Some(made.total)),
        ("one_turn", Some(made.per_revolution)),
        ("tooth_to_tooth", by_tooth(0)),
        ("long_wave", by_tooth(1)),
        ("short_wave", by_tooth(2)),
    ];
    let line = |z: &Complex| {
        let phase = json!({ "phase_deg": z.arg().to_degrees() });
        unit.object(&[("amplitude", Some(z.norm()))], phase)
    };
    let others = json!({
        "turns": made.record.turns,
        "samples": made.record.values.len(),
        "closed": made.record.closed,
        "teeth": made.teeth,
        "lines": made.lines.iter().map(line).collect::<Vec<_>>(),
    });
    unit.object(&ranges, others)
}

fn budget(
    result: &TransmissionResult,
    budget: &ErrorBudget,
    (out, off, worst): &(Vec<usize>, f64, f64),
    unit: TeUnit,
) -> Value {
    let element = |(name, e): (&String, &ElementSensitivity)| {
        json!({
            "element": name,
            "share": e.share,
            "one_grade_finer": e.one_grade_finer,
            "without": e.rss_reduction,
            "worst_case_without": e.worst_case_reduction,
        })
    };
    let percentile = |&(p, value, error): &(u32, f64, f64)| {
        let values = [("range", Some(value)), ("std", Some(error))];
        unit.object(&values, json!({ "percent": p }))
    };
    let others = json!({
        "window_turns": budget.range.window,
        "samples": budget.range.samples,
        "percentiles": budget.range.percentiles.iter().map(percentile).collect::<Vec<_>>(),
        "elements": result.elements.iter().zip(&budget.elements).map(element).collect::<Vec<_>>(),
        "could_be_left_out": {
            "elements": out.iter().map(|&e| result.elements[e].clone()).collect::<Vec<_>>(),
            "rss_off": off,
            "worst_case_off": worst,
        },
    });
    let sums = [
        ("worst_case", Some(budget.worst_case)),
        ("rss", Some(budget.rss)),
        ("range_added", Some(budget.range.bound_added)),
    ];
    unit.object(&sums, others)
}

fn order(machine: &Machine, result: &TransmissionResult, k: usize, unit: TeUnit) -> Value {
    let row = &result.lines[k];
    let slow = result.quasi_static(row);
    let group = result.coincidences.iter().find(|c| c.lines.contains(&k));
    let others = group.map_or(Vec::new(), |group| {
        let first = group.lines[0];
        let other = |(at, &line): (usize, &usize)| {
            let between = if line == first { group.lines.iter().position(|l| *l == k).unwrap_or(1) } else { at };
            json!({
                "row": line,
                "source": result.lines[line].source(machine),
                "cause": result.lines[line].cause(machine),
                "test": (line == first || k == first).then(|| separation_test_text(machine, &group.tests[between - 1])),
            })
        };
        group.lines.iter().enumerate().filter(|(_, line)| **line != k).map(other).collect()
    });
    let mut others = json!({
        "row": k,
        "order": row.line.order.to_string(),
        "order_value": row.line.order.to_f64(),
        "source": row.source(machine),
        "cause": row.cause(machine),
        "harmonic": row.line.harmonic,
        "assumed": row.line.declared(machine).and_then(|error| error.assumed.clone()),
        "phase_deg": row.phase(machine, slow),
        "share": row.share,
        "dynamic_phase_deg": row.dynamic.and_then(|z| row.phase(machine, z)),
        "frequency_hz": result.speed.map(|speed| row.line.order.to_f64() * speed.abs() / (2.0 * PI)),
        "mark": result.indexing_effects.as_ref().map(|marks| match &marks[k] {
            IndexingEffect::Form => json!({ "kind": "form" }),
            IndexingEffect::Pitch { advance, adjacent } => {
                let kind = json!({ "kind": "pitch", "advance": advance.to_string() });
                unit.object(&[("adjacent", Some(adjacent * slow.norm()))], kind)
            }
        }),
        "coincides_with": others,
    });
    if unit.key != "um" {
        others["amplitude_um"] = json!(result.radius.map(|r| 1e6 * r * slow.norm()));
    }
    let values = [
        ("amplitude", Some(slow.norm())),
        ("kinematic", row.kinematic.map(|z| z.norm())),
        ("loaded", Some(row.loaded.norm())),
        ("dynamic", row.dynamic.map(|z| z.norm())),
    ];
    unit.object(&values, others)
}
