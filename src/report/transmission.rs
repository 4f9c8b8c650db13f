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
use crate::plan::transmission::run::{Answer, Row};
use crate::transmission::budget::Sensitivity;
use crate::transmission::coincidence::Test;
use crate::transmission::indexing::Mark;
use crate::transmission::lines::Origin;

/// Arc seconds in a radian.
pub const ARCSEC: f64 = 648_000.0 / PI;

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

/// The phase of a line, degrees, where it is known.
pub fn phase(machine: &Machine, row: &Row, value: Complex) -> Option<f64> {
    (row.line.phase_known(machine) && value.norm() > 0.0).then(|| value.arg().to_degrees())
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
    let name = |freedom: usize| machine.nodes[machine.freedoms[freedom].node].name.clone();
    json!({
        "geardyn": header(sources, &trace),
        "driver": name(chain.ends.driver),
        "output": name(chain.ends.output),
        "against": chain.ends.against.map(name),
        "driver_turns": chain.turns(chain.ends.driver).map(ToString::to_string),
        "period_turns": answer.period.as_ref().map(ToString::to_string),
        "joints": if answer.is_rigid() { "rigid" } else { "elastic" },
        "wind_up_arcsec": answer.wind_up * ARCSEC,
        "radius_m": answer.radius,
        "output_speed_rad_s": answer.speed,
        "orders": (0..answer.rows.len()).map(|k| order(machine, answer, k)).collect::<Vec<_>>(),
        "budget": budget(answer),
        "second_order_arcsec": answer.second_order * ARCSEC,
        "map": answer.map.as_ref().map(|map| json!({
            "speed_rad_s": map.speeds,
            "amplitude_arcsec": map.amplitudes.iter().map(|row| row.iter().map(|a| a * ARCSEC).collect()).collect::<Vec<Vec<f64>>>(),
        })),
        "record": answer.record.as_ref().map(|made| json!({
            "turns": made.record.turns,
            "samples": made.record.values.len(),
            "closed": made.record.closed,
            "teeth": made.teeth,
            "total_arcsec": made.total * ARCSEC,
            "one_turn_arcsec": made.by_turn * ARCSEC,
            "tooth_to_tooth_arcsec": made.by_tooth.map(|t| t[0] * ARCSEC),
            "long_wave_arcsec": made.by_tooth.map(|t| t[1] * ARCSEC),
            "short_wave_arcsec": made.by_tooth.map(|t| t[2] * ARCSEC),
            "lines": made.lines.iter().map(|z| json!({ "amplitude_arcsec": z.norm() * ARCSEC, "phase_deg": z.arg().to_degrees() })).collect::<Vec<_>>(),
        })),
        "stages": stages(answer.plan.iter().map(|(name, verdict)| (*name, verdict))),
        "warnings": warnings(&answer.warnings),
    })
}

fn budget(answer: &Answer) -> Value {
    let budget = &answer.budget;
    let element = |(name, e): (&String, &Sensitivity)| {
        json!({
            "element": name,
            "share": e.share,
            "one_grade_better": e.one_grade,
            "without": e.without,
            "worst_case_without": e.worst_without,
        })
    };
    let (out, off, worst) = &answer.negligible;
    json!({
        "worst_case_arcsec": budget.worst_case * ARCSEC,
        "rss_arcsec": budget.rss * ARCSEC,
        "window_turns": budget.range.window,
        "samples": budget.range.samples,
        "percentiles": budget.range.percentiles.iter().map(|(p, value, error)| json!({
            "percent": p,
            "range_arcsec": value * ARCSEC,
            "std_arcsec": error * ARCSEC,
        })).collect::<Vec<_>>(),
        "elements": answer.elements.iter().zip(&budget.elements).map(element).collect::<Vec<_>>(),
        "could_be_left_out": {
            "elements": out.iter().map(|&e| answer.elements[e].clone()).collect::<Vec<_>>(),
            "rss_off": off,
            "worst_case_off": worst,
        },
    })
}

/// A record: turns of the output, the error, its time where the speed is given; after a line of names.
///
/// # Errors
/// The file cannot be written.
pub fn record(answer: &Answer, to: &mut dyn Write) -> Result<(), Error> {
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
    let mut head = String::from("turns,te [arcsec]");
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
        write!(to, "{turns},{}", e * ARCSEC).map_err(failed)?;
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

fn order(machine: &Machine, answer: &Answer, k: usize) -> Value {
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
    json!({
        "row": k,
        "order": row.line.order.to_string(),
        "order_value": row.line.order.value(),
        "source": source(machine, row),
        "cause": cause(machine, row),
        "harmonic": row.line.harmonic,
        "amplitude_arcsec": slow.norm() * ARCSEC,
        "amplitude_um": answer.radius.map(|r| 1e6 * r * slow.norm()),
        "phase_deg": phase(machine, row, slow),
        "share": row.share,
        "loaded_arcsec": row.loaded.norm() * ARCSEC,
        "dynamic_arcsec": row.dynamic.map(|z| z.norm() * ARCSEC),
        "dynamic_phase_deg": row.dynamic.and_then(|z| phase(machine, row, z)),
        "frequency_hz": answer.speed.map(|speed| row.line.order.value() * speed.abs() / (2.0 * PI)),
        "mark": answer.marks.as_ref().map(|marks| match &marks[k] {
            Mark::Form => json!({ "kind": "form" }),
            Mark::Pitch { advance, adjacent } => json!({
                "kind": "pitch",
                "advance": advance.to_string(),
                "adjacent_arcsec": adjacent * slow.norm() * ARCSEC,
            }),
        }),
        "coincides_with": others,
    })
}

/// One row a line.
pub fn csv(machine: &Machine, answer: &Answer) -> String {
    let mut text = String::from(
        "order,order_value,source,cause,harmonic,amplitude_arcsec,amplitude_um,phase_deg,share,loaded_arcsec,dynamic_arcsec,coincides_with_rows\n",
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
        let fields = [
            row.line.order.to_string(),
            format!("{}", row.line.order.value()),
            quoted(&source(machine, row)),
            cause(machine, row).to_string(),
            row.line.harmonic.to_string(),
            format!("{}", slow.norm() * ARCSEC),
            blank(answer.radius.map(|r| 1e6 * r * slow.norm())),
            blank(phase(machine, row, slow)),
            format!("{}", row.share),
            format!("{}", row.loaded.norm() * ARCSEC),
            blank(row.dynamic.map(|z| z.norm() * ARCSEC)),
            others.join(" "),
        ];
        text += &(fields.join(",") + "\n");
    }
    text
}
