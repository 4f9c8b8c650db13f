//! Transmission error of a chain as JSON and CSV.

use std::f64::consts::PI;
use std::io::Write;
use std::sync::Arc;

use serde_json::{Value, json};

use super::json::{header, stages, warnings};
use super::modes_csv::csv_field;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::source_span::SourceFile;
use crate::machine::components::Machine;
use crate::numeric::Complex;
use crate::plan::stages::StageDecision;
use crate::plan::transmission::error_record::TransmissionErrorRecord;
use crate::plan::transmission::run::{OrderLineResult, TransmissionResult};
use crate::transmission::budget::{ElementSensitivity, ErrorBudget};
use crate::transmission::coincidence::SeparationTest;
use crate::transmission::indexing::IndexingEffect;
use crate::transmission::order_lines::LineOrigin;

/// Arc seconds in a radian.
pub const ARCSEC: f64 = 648_000.0 / PI;

/// Unit of an output's errors.
#[derive(Debug, Clone, Copy)]
pub struct TeUnit {
    /// Number of these units in a rad, or in a m.
    pub times: f64,
    /// In words.
    pub name: &'static str,
    /// At the end of keys.
    pub key: &'static str,
}

impl TeUnit {
    /// Arc seconds of what turns, µm of what slides.
    pub fn for_output(machine: &Machine, result: &TransmissionResult) -> TeUnit {
        match machine.dofs[result.chain.ends.output].axis.is_rotation() {
            true => TeUnit {
                times: ARCSEC,
                name: "arcsec",
                key: "arcsec",
            },
            false => TeUnit {
                times: 1e6,
                name: "µm",
                key: "um",
            },
        }
    }

    /// Object whose numbers, rad or m, are under keys that end in the unit, with `others` behind them.
    fn object(self, values: &[(&str, Option<f64>)], others: Value) -> Value {
        let mut object = serde_json::Map::new();
        for &(key, value) in values {
            let value = value.map(|x| x * self.times);
            object.insert(format!("{key}_{}", self.key), json!(value));
        }
        if let Value::Object(others) = others {
            object.extend(others);
        }
        Value::Object(object)
    }
}

/// The element a line comes from.
pub fn source(machine: &Machine, row: &OrderLineResult) -> String {
    match row.line.origin {
        LineOrigin::Declared(number) => machine.errors[number].location.clone(),
        LineOrigin::Stiffness(branch) => machine.branch_name(branch),
    }
}

/// Cause of a line.
pub fn cause(machine: &Machine, row: &OrderLineResult) -> &'static str {
    match row.line.origin {
        LineOrigin::Declared(number) => machine.errors[number].cause.name(),
        LineOrigin::Stiffness(_) => "mesh stiffness",
    }
}

/// The phase of a line, degrees in (−180, 180], where it is known.
pub fn phase(machine: &Machine, row: &OrderLineResult, value: Complex) -> Option<f64> {
    /// Rounding of a half turn backward, as a share of a turn.
    const ROUNDING: f64 = 1e-9;
    let turned = match value.arg().to_degrees() {
        half if half <= -180.0 + ROUNDING => half + 360.0,
        other => other,
    };
    (row.line.phase_known(machine) && value.norm() > 0.0).then_some(turned)
}

/// A second record, as text.
pub fn separation_test_text(machine: &Machine, test: &SeparationTest) -> String {
    let degrees = |turns: f64| (360.0 * turns).round();
    match test {
        SeparationTest::Remesh { pair, teeth, shift } => format!(
            "put {} together {teeth} {} further on: their phases part by {}°",
            machine.elements[*pair].name,
            if *teeth == 1 { "tooth" } else { "teeth" },
            degrees(*shift)
        ),
        SeparationTest::Reseat => "turn the gear on its seat".to_string(),
        SeparationTest::Reversal(shift) => format!(
            "run it backward, on the other flanks: their phases part by {}°",
            degrees(*shift)
        ),
        SeparationTest::Torque => {
            "another torque: what comes from stiffness goes with it".to_string()
        }
        SeparationTest::SpeedOrTester => {
            "another speed, if the machine passes them on differently; else each alone on a tester"
                .to_string()
        }
    }
}

/// The document.
pub fn json(sources: &[Arc<SourceFile>], machine: &Machine, result: &TransmissionResult) -> Value {
    let trace: Vec<&str> = (result.plan.iter())
        .filter(|row| matches!(row.1, StageDecision::Runs(_)))
        .map(|row| row.0)
        .collect();
    let chain = &result.chain;
    let unit = TeUnit::for_output(machine, result);
    let name = |dof: usize| machine.nodes[machine.dofs[dof].node].name.clone();
    let sums = [
        ("wind_up", Some(result.wind_up)),
        ("second_order", Some(result.second_order)),
    ];
    let others = json!({
        "geardyn": header(sources, &trace),
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
        "budget_at_speed": result.at_speed.as_ref().map(|fast| budget(result, &fast.budget, &fast.negligible, unit)),
        "map": result.map.as_ref().map(|map| json!({
            "speed_rad_s": map.speeds,
            "largest": map.largest.iter().map(|l| unit.object(&[("amplitude", Some(l.1))], json!({ "speed_rad_s": l.0 }))).collect::<Vec<_>>(),
            (format!("amplitude_{}", unit.key)): map.amplitudes.iter().map(|row| row.iter().map(|a| a * unit.times).collect()).collect::<Vec<Vec<f64>>>(),
        })),
        "record": result.record.as_ref().map(|made| recorded(made, unit)),
        "stages": stages(result.plan.iter().map(|(name, decision)| (*name, decision))),
        "warnings": warnings(&result.diagnostics),
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
            "one_grade_better": e.one_grade_finer,
            "without": e.rss_without,
            "worst_case_without": e.worst_without,
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

/// A record: turns that orders are counted by, the error, its time where the speed is given; after a line of names.
///
/// # Errors
/// The file cannot be written.
pub fn write_record(
    machine: &Machine,
    result: &TransmissionResult,
    to: &mut dyn Write,
) -> Result<(), Error> {
    let failed = |e: std::io::Error| {
        Error::new(
            Code::OutputFailed,
            format!("the record could not be written: {e}"),
        )
    };
    let Some(made) = &result.record else {
        return Ok(());
    };
    let seconds = result
        .speed
        .map(|speed| 2.0 * PI / speed.abs())
        .filter(|s| s.is_finite());
    let unit = TeUnit::for_output(machine, result);
    let mut head = format!("turns,te [{}]", unit.name);
    if result.radius.is_some() {
        head += ",te [µm]";
    }
    if seconds.is_some() {
        head += ",time [s]";
    }
    writeln!(to, "{head}").map_err(failed)?;
    let count = made.record.values.len() as f64;
    for (i, e) in made.record.values.iter().enumerate() {
        let turns = made.record.turns as f64 * i as f64 / count;
        write!(to, "{turns},{}", e * unit.times).map_err(failed)?;
        if let Some(r) = result.radius {
            write!(to, ",{}", 1e6 * r * e).map_err(failed)?;
        }
        if let Some(s) = seconds {
            write!(to, ",{}", s * turns).map_err(failed)?;
        }
        writeln!(to).map_err(failed)?;
    }
    Ok(())
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
                "source": source(machine, &result.lines[line]),
                "cause": cause(machine, &result.lines[line]),
                "test": (line == first || k == first).then(|| separation_test_text(machine, &group.tests[between - 1])),
            })
        };
        group.lines.iter().enumerate().filter(|(_, line)| **line != k).map(other).collect()
    });
    let mut others = json!({
        "row": k,
        "order": row.line.order.to_string(),
        "order_value": row.line.order.to_f64(),
        "source": source(machine, row),
        "cause": cause(machine, row),
        "harmonic": row.line.harmonic,
        "assumed": row.line.declared(machine).and_then(|error| error.assumed.clone()),
        "phase_deg": phase(machine, row, slow),
        "share": row.share,
        "dynamic_phase_deg": row.dynamic.and_then(|z| phase(machine, row, z)),
        "frequency_hz": result.speed.map(|speed| row.line.order.to_f64() * speed.abs() / (2.0 * PI)),
        "mark": result.marks.as_ref().map(|marks| match &marks[k] {
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

/// One row a line.
pub fn csv(machine: &Machine, result: &TransmissionResult) -> String {
    let unit = TeUnit::for_output(machine, result);
    let (key, turns) = (unit.key, unit.key != "um");
    let arc = if turns { ",amplitude_um" } else { "" };
    let mut text = format!(
        "order,order_value,source,cause,harmonic,amplitude_{key}{arc},phase_deg,share,kinematic_{key},loaded_{key},dynamic_{key},coincides_with_rows\n"
    );
    let blank = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x}"));
    for (k, row) in result.lines.iter().enumerate() {
        let slow = result.quasi_static(row);
        let group = result.coincidences.iter().find(|c| c.lines.contains(&k));
        let others: Vec<String> = group.map_or(Vec::new(), |group| {
            group
                .lines
                .iter()
                .filter(|line| **line != k)
                .map(|line| (line + 1).to_string())
                .collect()
        });
        let mut fields = vec![
            row.line.order.to_string(),
            format!("{}", row.line.order.to_f64()),
            csv_field(&source(machine, row)),
            cause(machine, row).to_string(),
            row.line.harmonic.to_string(),
            format!("{}", slow.norm() * unit.times),
        ];
        if turns {
            fields.push(blank(result.radius.map(|r| 1e6 * r * slow.norm())));
        }
        fields.extend([
            blank(phase(machine, row, slow)),
            format!("{}", row.share),
            blank(row.kinematic.map(|z| z.norm() * unit.times)),
            format!("{}", row.loaded.norm() * unit.times),
            blank(row.dynamic.map(|z| z.norm() * unit.times)),
            others.join(" "),
        ]);
        text += &(fields.join(",") + "\n");
    }
    text
}
