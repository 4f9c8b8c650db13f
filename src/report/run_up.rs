//! Run-ups: critical speeds with the element of highest strain energy, document, table over speed, map.

use std::f64::consts::TAU;

use serde_json::{Value, json};

use super::figure::{
    Axis, BLACK_INK, Curve, Figure, Guide, Ink, LevelMap, Mark, Plot, PlotColumn, PointLabel,
};
use super::mode_text::element_share;
use super::number_format::{choose_unit, four_digits, rpm, significant, with_minus_signs};
use super::plan::{step_lines, steps};
use super::presentation::{Presentation, Provenance, StudyReport};
use super::spectrum_table::decibels;
use super::svg::{LineStyle, truncate_label};
use super::table::{Table, decimal, or_dash};
use crate::base::error::Error;
use crate::base::text::pluralise;
use crate::numeric::sorting::sort_descending;
use crate::plan::response::run_up::RunUpResult;
use crate::response::excitation::OrderExcitation;

impl Presentation for StudyReport<'_, RunUpResult> {
    fn provenance(&self) -> Provenance<'_> {
        let result = &self.result;
        Provenance {
            effort: json!({ "run_time_s": result.seconds }),
            title: &self.scene.model.title,
            ..Provenance::of_plan(&self.scene.sources, &result.plan, &result.diagnostics)
        }
    }

    fn body(&self) -> Result<Value, Error> {
        let (machine, result) = (&self.machine.machine, &self.result);
        let output = |(at, (name, unit)): (usize, &(String, &str))| {
            json!({
                "name": name,
                "unit": unit,
                "most": { "speed_rpm": rpm(result.max_amplitudes[at].0), "value": result.max_amplitudes[at].1 },
                "total": (0..result.speeds.len()).map(|s| result.rss_amplitude(at, s)).collect::<Vec<_>>(),
                "by_excitation": result.amplitudes[at],
            })
        };
        Ok(json!({
            "node": result.node,
            "assumed_amplitude_m": result.assumed_amplitude,
            "fixed_dofs": result.fixed_dofs,
            "speed_rpm": result.speeds.iter().map(|&s| rpm(s)).collect::<Vec<_>>(),
            "excitations": result.excitations.iter().map(|e| json!({
                "order": e.fraction, "value": e.order, "source": e.source,
                "amplitude": (e.declared || result.assumed_amplitude.is_some()).then_some(e.amplitude), "declared": e.declared,
                "branches": e.branches.iter().map(|b| machine.branch_name(b.0)).collect::<Vec<_>>(),
            })).collect::<Vec<_>>(),
            "outputs": result.outputs.iter().enumerate().map(output).collect::<Vec<_>>(),
            "critical": result.critical.iter().map(|c| json!({
                "speed_rpm": rpm(c.speed), "frequency_hz": c.omega / TAU, "excitation": c.excitation,
                "order": result.excitations[c.excitation].fraction, "source": result.excitations[c.excitation].source,
                "amplitude": c.amplitude, "highest_strain_energy": c.highest_strain_energy.map(|d| machine.elements[d.0].name.clone()), "share": c.highest_strain_energy.map(|d| d.1),
            })).collect::<Vec<_>>(),
            "reason": result.choice.reason,
        }))
    }

    fn text(&self) -> String {
        let (machine, result) = (&self.machine.machine, &self.result);
        let (name, unit) = result
            .outputs
            .first()
            .map_or(("", ""), |(n, u)| (n.as_str(), *u));
        let mut text = driver(result);
        text += &match result.assumed_amplitude {
        Some(size) => format!(
            "no error is declared: every order has an assumed amplitude of {} µm, and responses are proportional to it\n",
            four_digits(1e6 * size)
        ),
        None => "orders have the amplitudes of the declared errors; without one only the critical speed is given\n".to_string(),
    };
        for ((name, unit), &(speed, total)) in result.outputs.iter().zip(&result.max_amplitudes) {
            let (factor, unit) = choose_unit(total, unit);
            text += &format!(
                "{name}: all orders together at most {} {unit}, at {} rpm\n",
                four_digits(factor * total),
                four_digits(rpm(speed))
            );
        }
        if result.critical.is_empty() {
            return text + "no order crosses a natural frequency with a response in this range\n";
        }
        let largest = result
            .critical
            .iter()
            .filter_map(|c| c.amplitude)
            .fold(0.0, f64::max);
        let (factor, unit) = choose_unit(largest, unit);
        text += &format!(
            "\n{} of {}\n",
            pluralise(result.critical.len(), "critical speed"),
            result.node
        );
        let mut table = Table::new("speed [rpm]|frequency [Hz]|order")
            .column(name, &unit)
            .columns("source|highest strain energy");
        for c in result.critical.iter().take(MAX_ROWS) {
            let e = &result.excitations[c.excitation];
            table.row([
                significant(rpm(c.speed)),
                significant(c.omega / TAU),
                e.fraction.clone(),
                match c.amplitude {
                    Some(size) => four_digits(factor * size),
                    None if !result.is_declared(c.excitation) => "not declared".to_string(),
                    None => "infinite".to_string(),
                },
                e.source.clone(),
                or_dash(c.highest_strain_energy, |(element, share)| {
                    element_share(machine, element, share)
                }),
            ]);
        }
        text += &table.text();
        if result.critical.len() > MAX_ROWS {
            text += &format!(
                "… and {} with smaller responses; all are in --json\n",
                result.critical.len() - MAX_ROWS
            );
        }
        with_minus_signs(&text)
    }

    fn table(&self) -> Table<'_> {
        let result = &self.result;
        let speeds: Vec<f64> = result.speeds.iter().map(|&s| rpm(s)).collect();
        let mut table = Table::default().numbers("speed", "rpm", speeds, decimal);
        for (at, (name, unit)) in result.outputs.iter().enumerate() {
            let total = (0..result.speeds.len()).map(|s| result.rss_amplitude(at, s));
            let total: Vec<f64> = total.collect();
            table = table.numbers(&format!("{name} together"), unit, total, decimal);
            let sizes = result.amplitudes[at].iter().flatten();
            for ((_, e), sizes) in sized_excitations(result).zip(sizes) {
                let name = format!("{name} by {} ({})", e.source, e.fraction);
                table = table.numbers(&name, unit, sizes, decimal);
            }
        }
        table
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        Ok(vec![Figure::first(map(
            &self.scene.model.title,
            &self.result,
        ))])
    }

    fn notes(&self) -> String {
        step_lines(steps(&self.result.plan))
    }
}

/// Excitations that have a size, with their numbers.
fn sized_excitations(result: &RunUpResult) -> impl Iterator<Item = (usize, &OrderExcitation)> {
    let all = result.excitations.iter().enumerate();
    all.filter(|(number, _)| result.is_declared(*number))
}

/// Rows of a map by frequency.
const LINES: usize = 400;

/// Response of the first output over speed and frequency.
fn map(title: &str, result: &RunUpResult) -> PlotColumn {
    let (name, unit) = result
        .outputs
        .first()
        .map_or(("", ""), |(n, u)| (n.as_str(), u));
    // Beyond the highest critical frequency nothing answers; without one all is shown.
    let top = result
        .excitations
        .iter()
        .map(|e| e.order)
        .fold(0.0, f64::max)
        * result.speeds.iter().fold(0.0f64, |m, s| m.max(s.abs()))
        / TAU;
    let highest = result
        .critical
        .iter()
        .map(|c| 1.3 * c.omega / TAU)
        .fold(0.0, f64::max);
    let top = if highest > 0.0 { top.min(highest) } else { top };
    let step = top / LINES as f64;
    let speeds = map_speeds(&result.speeds);
    let row = |at: usize| {
        let mut row = vec![0.0; LINES];
        // An order passes all frequencies between the speeds half way to the neighbours.
        let [before, after] = [at.saturating_sub(1), (at + 1).min(speeds.len() - 1)];
        let ends = [before, after].map(|other| 0.5 * (speeds[at] + speeds[other]).abs());
        for (number, e) in sized_excitations(result) {
            let line = |speed: f64| (e.order * speed / TAU / step) as usize;
            let (low, high) = (line(ends[0].min(ends[1])), line(ends[0].max(ends[1])));
            if let Some(Some(column)) = result.amplitudes.first().map(|t| &t[number]) {
                let amplitude = between(&result.speeds, column, speeds[at]);
                let cells = row.iter_mut().take(high.saturating_add(1)).skip(low);
                cells.for_each(|cell| *cell += amplitude.powi(2));
            }
        }
        row.into_iter().map(decibels).collect::<Vec<f64>>()
    };
    let map = LevelMap {
        label: format!("amplitude, dB re 1 {unit}"),
        x: speeds.iter().map(|&s| rpm(s)).collect(),
        y: (0..LINES).map(|k| (k as f64 + 0.5) * step).collect(),
        columns: (0..speeds.len()).map(row).collect(),
        sparse: true,
    };
    let speed = format!("speed of {}, rpm", result.node);
    let orders = order_lines(result, top);
    let (orders, labels) = orders.into_iter().unzip();
    let modes = result
        .critical
        .iter()
        .map(|c| c.omega / TAU)
        .filter(|f| *f < top);
    let mut modes: Vec<f64> = modes.take(MODE_LINES).collect();
    modes.sort_by(f64::total_cmp);
    modes.dedup_by(|a, b| (*a - *b).abs() < 0.5 * step);
    let mut named = f64::NEG_INFINITY;
    let guide = |f: f64| {
        // Names nearer than a line of text would cover each other.
        let has_room = f - named > 0.03 * top;
        if has_room {
            named = f;
        }
        let name = format!("mode at {} Hz", four_digits(f));
        Guide {
            name: if has_room { name } else { String::new() },
            ..Guide::horizontal(f)
        }
    };
    let ends = (rpm(speeds[0]), rpm(speeds[speeds.len() - 1]));
    let across = match ends.0 < ends.1 {
        true => Axis::linear(speed).over(ends.0, ends.1),
        false => Axis::linear(speed),
    };
    let plot = Plot {
        map: Some(map),
        guides: modes.into_iter().map(guide).collect(),
        curves: orders,
        labels,
        upright_labels: true,
        ..Plot::new(across.clone(), Axis::linear("frequency, Hz").over(0.0, top))
    };
    let title = format!("{title}: {name} over the speed of {}", result.node);
    PlotColumn {
        title,
        note: "amplitudes between computed speeds interpolated; dotted: orders, natural frequencies of the highest critical speeds".into(),
        linked: true,
        plots: vec![plot, order_cuts(result, across, unit)],
        ..PlotColumn::default()
    }
}

/// Orders drawn as curves over speed.
const CUTS: usize = 5;

/// Amplitudes of all orders together and of the strongest ones over speed, first output.
fn order_cuts(result: &RunUpResult, across: Axis, unit: &str) -> Plot {
    let speeds: Vec<f64> = result.speeds.iter().map(|&s| rpm(s)).collect();
    let total = (0..speeds.len())
        .map(|s| result.rss_amplitude(0, s))
        .collect();
    let total = Curve::line("all orders together", BLACK_INK, speeds.clone(), total);
    let strongest = strongest_excitations(result).into_iter().take(CUTS);
    let inks = [0, 1, 4, 5, 3].map(Ink::Series);
    let cuts = strongest.zip(inks).filter_map(|((number, e), ink)| {
        let amplitudes = result.amplitudes.first()?[number].clone()?;
        Some(Curve::line(order_name(e), ink, speeds.clone(), amplitudes))
    });
    let curves: Vec<Curve> = cuts.chain([total]).collect();
    let sizes = curves.iter().flat_map(|c| c.y.iter().copied());
    let y = Axis::of_magnitudes(format!("amplitude, {unit}"), sizes);
    Plot {
        height: 200.0,
        curves,
        ..Plot::new(across, y)
    }
}

/// Excitations that have a size, those with the largest amplitudes of the first output first.
fn strongest_excitations(result: &RunUpResult) -> Vec<(usize, &OrderExcitation)> {
    let peak = |number: usize| {
        let column = result.amplitudes.first().and_then(|t| t[number].as_ref());
        column.map_or(0.0, |c| c.iter().copied().fold(0.0, f64::max))
    };
    let mut strongest: Vec<(usize, &OrderExcitation)> = sized_excitations(result).collect();
    sort_descending(&mut strongest, |a| peak(a.0));
    strongest
}

/// Order and source of an excitation.
fn order_name(excitation: &OrderExcitation) -> String {
    let order = (excitation.order * 1e4).round() / 1e4;
    truncate_label(&format!("{order}× {}", excitation.source), 28)
}

/// Columns of a map at least.
const COLUMNS: usize = 480;

/// Even speeds from the first to the last, at least as many as there are.
fn map_speeds(speeds: &[f64]) -> Vec<f64> {
    let (first, last) = (speeds[0], speeds[speeds.len() - 1]);
    let count = match speeds.len() {
        1 => 1,
        n => n.max(COLUMNS),
    };
    let share = |k: usize| k as f64 / (count - 1).max(1) as f64;
    (0..count)
        .map(|k| first + (last - first) * share(k))
        .collect()
}

/// A value on the straight lines between the points of a curve over rising speeds.
fn between(speeds: &[f64], values: &[f64], speed: f64) -> f64 {
    let after = speeds
        .partition_point(|s| *s <= speed)
        .min(speeds.len() - 1);
    let before = after.saturating_sub(1);
    let width = speeds[after] - speeds[before];
    let share = if width > 0.0 {
        (speed - speeds[before]) / width
    } else {
        0.0
    };
    values[before] + share * (values[after] - values[before])
}

/// Orders named on a map: those with the largest amplitudes of the first output.
const ORDER_LINES: usize = 8;

/// Least relative distance of an order from a stronger one: nearer names would cover each other.
const NEAR: f64 = 0.08;

/// Natural frequencies drawn on a map.
const MODE_LINES: usize = 8;

/// The orders with the largest amplitudes as lines `f = order n/60` up to a frequency.
fn order_lines(result: &RunUpResult, top: f64) -> Vec<(Curve, PointLabel)> {
    let mut drawn: Vec<(usize, &OrderExcitation)> = Vec::new();
    for excitation in strongest_excitations(result) {
        let order = excitation.1.order;
        let is_near =
            |other: &(usize, &OrderExcitation)| (other.1.order - order).abs() < NEAR * order;
        if !drawn.iter().any(is_near) {
            drawn.push(excitation);
        }
    }
    drawn.truncate(ORDER_LINES);
    let speeds = || result.speeds.iter().map(|s| s.abs());
    let (first, last) = (
        speeds().fold(f64::INFINITY, f64::min),
        speeds().fold(0.0, f64::max),
    );
    let lines = drawn
        .into_iter()
        .filter(|(_, e)| e.order * first / TAU < top);
    lines
        .map(|(_, e)| {
            let end = last.min(top * TAU / e.order);
            let mark = Mark::Line(0.7, LineStyle::Dotted);
            let [from, to] = [first, end].map(|s| e.order * s / TAU);
            let x = vec![rpm(first), rpm(end)];
            let curve = Curve::new("", Ink::Faint, mark, x, vec![from, to]);
            let label = PointLabel {
                x: rpm(end),
                y: to,
                text: order_name(e),
            };
            (curve, label)
        })
        .collect()
}

/// Maximum number of critical speeds shown: those with the largest responses.
const MAX_ROWS: usize = 24;

/// Driver's angle: prescribed or free.
fn driver(result: &RunUpResult) -> String {
    match &result.fixed_dofs[..] {
        [] => format!(
            "run-up of {}: no angle is prescribed; the driver is free and responds to the orders (--hold {} prescribes its angle)\n",
            result.node, result.node
        ),
        held => format!(
            "run-up of {}: {} prescribed\n",
            result.node,
            match held {
                [one] => format!("{one} is"),
                many => format!("{} are", many.join(", ")),
            }
        ),
    }
}
