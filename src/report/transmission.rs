//! Transmission error of a chain as JSON and CSV.

use std::f64::consts::PI;
use std::io::Write;
use std::sync::Arc;

use serde_json::{Value, json};

use super::csv::quoted;
use super::json::{header, stages, warnings};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::place::Source;
use crate::machine::parts::Machine;
use crate::numeric::Complex;
use crate::plan::stages::Verdict;
use crate::plan::transmission::recorded::Recorded;
use crate::plan::transmission::run::{Answer, Row};
use crate::transmission::budget::{Budget, Sensitivity};
use crate::transmission::coincidence::Test;
use crate::transmission::indexing::Mark;
use crate::transmission::lines::Origin;

/// Arc seconds in a radian.
pub const ARCSEC: f64 = 648_000.0 / PI;

/// What the errors of an output are told in.
#[derive(Debug, Clone, Copy)]
pub struct Unit {
    /// Of it in a rad, or in a m.
    pub times: f64,
    /// In words.
    pub name: &'static str,
    /// At the end of keys.
    pub key: &'static str,
}

impl Unit {
    /// Arc seconds of what turns, µm of what slides.
    pub fn of(machine: &Machine, answer: &Answer) -> Unit {
        match machine.freedoms[answer.chain.ends.output].axis.turns() {
            true => Unit {
                times: ARCSEC,
                name: "arcsec",
                key: "arcsec",
            },
            false => Unit {
                times: 1e6,
                name: "µm",
                key: "um",
            },
        }
    }

    /// An object whose numbers, rad or m, stand under keys that end in the unit, with `others` behind them.
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
pub fn source(machine: &Machine, row: &Row) -> String {
    match row.line.origin {
        Origin::Declared(number) => machine.errors[number].on.clone(),
        Origin::Stiffness(branch) => machine.branch_name(branch),
    }
}

/// What of it.
pub fn cause(machine: &Machine, row: &Row) -> &'static str {
    match row.line.origin {
        Origin::Declared(number) => machine.errors[number].cause.name(),
        Origin::Stiffness(_) => "mesh stiffness",
    }
}

/// The phase of a line, degrees in (−180, 180], where it is known.
pub fn phase(machine: &Machine, row: &Row, value: Complex) -> Option<f64> {
    /// Of a turn: rounding of a half turn backward.
    const ROUNDING: f64 = 1e-9;
    let turned = match value.arg().to_degrees() {
        half if half <= -180.0 + ROUNDING => half + 360.0,
        other => other,
    };
    (row.line.phase_known(machine) && value.norm() > 0.0).then_some(turned)
}

/// A second record, in words.
pub fn test(machine: &Machine, test: &Test) -> String {
    let degrees = |turns: f64| (360.0 * turns).round();
    match test {
        Test::Remesh { pair, teeth, shift } => format!(
            "put {} together {teeth} {} further on: their phases part by {}°",
            machine.elements[*pair].name,
            if *teeth == 1 { "tooth" } else { "teeth" },
            degrees(*shift)
        ),
        Test::Reseat => "turn the gear on its seat".to_string(),
        Test::Reversal(shift) => format!(
            "run it backward, on the other flanks: their phases part by {}°",
            degrees(*shift)
        ),
        Test::Torque => "another torque: what comes from stiffness goes with it".to_string(),
        Test::SpeedOrTester => {
            "another speed, if the machine passes them on differently; else each alone on a tester"
                .to_string()
        }
    }
}

/// The document.
pub fn json(sources: &[Arc<Source>], machine: &Machine, answer: &Answer) -> Value {
    let trace: Vec<&str> = (answer.plan.iter())
        .filter(|row| matches!(row.1, Verdict::Runs(_)))
        .map(|row| row.0)
        .collect();
    let chain = &answer.chain;
    let unit = Unit::of(machine, answer);
    let name = |freedom: usize| machine.nodes[machine.freedoms[freedom].node].name.clone();
    let sums = [
        ("wind_up", Some(answer.wind_up)),
        ("second_order", Some(answer.second_order)),
    ];
    let others = json!({
        "geardyn": header(sources, &trace),
        "driver": name(chain.ends.driver),
        "output": name(chain.ends.output),
        "against": chain.ends.against.map(name),
        "orders_per_turn_of": name(chain.per),
        "driver_turns": chain.turns(chain.ends.driver).map(ToString::to_string),
        "period_turns": answer.period.as_ref().map(ToString::to_string),
        "joints": if answer.is_rigid() { "rigid" } else { "elastic" },
        "radius_m": answer.radius,
        "output_speed_rad_s": answer.speed,
        "orders": (0..answer.rows.len()).map(|k| order(machine, answer, k, unit)).collect::<Vec<_>>(),
        "budget": budget(answer, &answer.budget, &answer.negligible, unit),
        "budget_at_speed": answer.at_speed.as_ref().map(|fast| budget(answer, &fast.budget, &fast.negligible, unit)),
        "map": answer.map.as_ref().map(|map| json!({
            "speed_rad_s": map.speeds,
            "largest": map.largest.iter().map(|l| unit.object(&[("amplitude", Some(l.1))], json!({ "speed_rad_s": l.0 }))).collect::<Vec<_>>(),
            (format!("amplitude_{}", unit.key)): map.amplitudes.iter().map(|row| row.iter().map(|a| a * unit.times).collect()).collect::<Vec<Vec<f64>>>(),
        })),
        "record": answer.record.as_ref().map(|made| recorded(made, unit)),
        "stages": stages(answer.plan.iter().map(|(name, verdict)| (*name, verdict))),
        "warnings": warnings(&answer.warnings),
    });
    unit.object(&sums, others)
}

fn recorded(made: &Recorded, unit: Unit) -> Value {
    let by_tooth = |at: usize| made.by_tooth.map(|t| t[at]);
    let ranges = [
        ("total", Some(made.total)),
        ("one_turn", Some(made.by_turn)),
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
    answer: &Answer,
    budget: &Budget,
    (out, off, worst): &(Vec<usize>, f64, f64),
    unit: Unit,
) -> Value {
    let element = |(name, e): (&String, &Sensitivity)| {
        json!({
            "element": name,
            "share": e.share,
            "one_grade_better": e.one_grade,
            "without": e.without,
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
        "elements": answer.elements.iter().zip(&budget.elements).map(element).collect::<Vec<_>>(),
        "could_be_left_out": {
            "elements": out.iter().map(|&e| answer.elements[e].clone()).collect::<Vec<_>>(),
            "rss_off": off,
            "worst_case_off": worst,
        },
    });
    let sums = [
        ("worst_case", Some(budget.worst_case)),
        ("rss", Some(budget.rss)),
        ("range_added", Some(budget.range.added)),
    ];
    unit.object(&sums, others)
}

/// A record: turns that orders are counted by, the error, its time where the speed is given; after a line of names.
///
/// # Errors
/// The file cannot be written.
pub fn record(machine: &Machine, answer: &Answer, to: &mut dyn Write) -> Result<(), Error> {
    let failed = |e: std::io::Error| {
        Error::new(
            Code::OutputFailed,
            format!("the record could not be written: {e}"),
        )
    };
    let Some(made) = &answer.record else {
        return Ok(());
    };
    let seconds = answer
        .speed
        .map(|speed| 2.0 * PI / speed.abs())
        .filter(|s| s.is_finite());
    let unit = Unit::of(machine, answer);
    let mut head = format!("turns,te [{}]", unit.name);
    if answer.radius.is_some() {
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
        if let Some(r) = answer.radius {
            write!(to, ",{}", 1e6 * r * e).map_err(failed)?;
        }
        if let Some(s) = seconds {
            write!(to, ",{}", s * turns).map_err(failed)?;
        }
        writeln!(to).map_err(failed)?;
    }
    Ok(())
}

fn order(machine: &Machine, answer: &Answer, k: usize, unit: Unit) -> Value {
    let row = &answer.rows[k];
    let slow = answer.slow(row);
    let group = answer.coincidences.iter().find(|c| c.lines.contains(&k));
    let others = group.map_or(Vec::new(), |group| {
        let first = group.lines[0];
        let other = |(at, &line): (usize, &usize)| {
            let between = if line == first { group.lines.iter().position(|l| *l == k).unwrap_or(1) } else { at };
            json!({
                "row": line,
                "source": source(machine, &answer.rows[line]),
                "cause": cause(machine, &answer.rows[line]),
                "test": (line == first || k == first).then(|| test(machine, &group.tests[between - 1])),
            })
        };
        group.lines.iter().enumerate().filter(|(_, line)| **line != k).map(other).collect()
    });
    let mut others = json!({
        "row": k,
        "order": row.line.order.to_string(),
        "order_value": row.line.order.value(),
        "source": source(machine, row),
        "cause": cause(machine, row),
        "harmonic": row.line.harmonic,
        "assumed": row.line.declared(machine).and_then(|error| error.assumed.clone()),
        "phase_deg": phase(machine, row, slow),
        "share": row.share,
        "dynamic_phase_deg": row.dynamic.and_then(|z| phase(machine, row, z)),
        "frequency_hz": answer.speed.map(|speed| row.line.order.value() * speed.abs() / (2.0 * PI)),
        "mark": answer.marks.as_ref().map(|marks| match &marks[k] {
            Mark::Form => json!({ "kind": "form" }),
            Mark::Pitch { advance, adjacent } => {
                let kind = json!({ "kind": "pitch", "advance": advance.to_string() });
                unit.object(&[("adjacent", Some(adjacent * slow.norm()))], kind)
            }
        }),
        "coincides_with": others,
    });
    if unit.key != "um" {
        others["amplitude_um"] = json!(answer.radius.map(|r| 1e6 * r * slow.norm()));
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
pub fn csv(machine: &Machine, answer: &Answer) -> String {
    let unit = Unit::of(machine, answer);
    let (key, turns) = (unit.key, unit.key != "um");
    let arc = if turns { ",amplitude_um" } else { "" };
    let mut text = format!(
        "order,order_value,source,cause,harmonic,amplitude_{key}{arc},phase_deg,share,kinematic_{key},loaded_{key},dynamic_{key},coincides_with_rows\n"
    );
    let blank = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x}"));
    for (k, row) in answer.rows.iter().enumerate() {
        let slow = answer.slow(row);
        let group = answer.coincidences.iter().find(|c| c.lines.contains(&k));
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
            format!("{}", row.line.order.value()),
            quoted(&source(machine, row)),
            cause(machine, row).to_string(),
            row.line.harmonic.to_string(),
            format!("{}", slow.norm() * unit.times),
        ];
        if turns {
            fields.push(blank(answer.radius.map(|r| 1e6 * r * slow.norm())));
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
