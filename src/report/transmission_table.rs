//! Transmission error of a chain as tables for a terminal.

use super::number_format::{four_digits, percent, significant, with_minus_signs};
use super::table::{Table, or_dash};
use super::te_lines::{TeUnit, separation_test_text};
use crate::base::text::pluralise;
use crate::machine::components::Machine;
use crate::numeric::sorting::{falling_order, sort_descending};
use crate::plan::transmission::result::TransmissionResult;
use crate::transmission::budget::ErrorBudget;
use crate::transmission::indexing::IndexingEffect;

/// Lines shown unless all are wanted: the largest.
const MAX_ROWS: usize = 25;

/// The order table, what coincides, the sums.
pub fn text(machine: &Machine, result: &TransmissionResult, all: bool) -> String {
    let chain = &result.chain;
    let name = |dof: usize| machine.nodes[machine.dofs[dof].node].name.as_str();
    let mut text = format!(
        "{} driven by {}",
        name(chain.ends.output),
        name(chain.ends.driver)
    );
    if let Some(against) = chain.ends.relative_to {
        text += &format!(", against {}", name(against));
    }
    let unit = TeUnit::for_output(machine, result);
    let per = match chain.order_reference == chain.ends.output {
        true => "the output".to_string(),
        false => format!("{}, which moves it", name(chain.order_reference)),
    };
    if let (Some(turns), true) = (
        chain.ratio(chain.ends.driver),
        chain.order_reference != chain.ends.driver,
    ) {
        text += &format!(": {turns} turns of {} a turn", name(chain.ends.driver));
    }
    text += &format!(
        ". Orders per turn of {per}. The angle of {} is prescribed and does not respond.\n\n",
        name(chain.ends.driver)
    );
    let shown = largest_lines(result, all);
    let at_speed = result.speed.is_some();
    let differs = result.load_changes_lines();
    let of = unit.name;
    let mut table = Table::new(&format!("order|source|cause|amplitude [{of}]"))
        .columns_if(result.radius.is_some(), "arc [µm]")
        .columns("phase [deg]|share [%]")
        .columns_if(differs, &format!("kinematic [{of}]|loaded [{of}]"))
        .columns_if(at_speed, &format!("at speed [{of}]|frequency [Hz]"))
        .columns_if(result.map.is_some(), &format!("largest [{of}]|at [rpm]"))
        .columns_if(result.indexing_effects.is_some(), "work")
        .columns_if(!result.coincidences.is_empty(), "")
        .words(&[1, 2]);
    for &k in &shown {
        let row = &result.lines[k];
        let slow = result.quasi_static(row);
        let mut cells = vec![
            order(&row.line.order),
            row.source(machine),
            with_harmonic(row.cause(machine), row.line.harmonic),
            four_digits(slow.norm() * unit.times),
        ];
        cells.extend(result.radius.map(|r| four_digits(1e6 * r * slow.norm())));
        let turned = row.phase(machine, slow).map(f64::round);
        let half = |p: f64| if p <= -180.0 { 180.0 } else { p };
        cells.push(turned.map_or("?".to_string(), |p| format!("{:.0}", half(p))));
        cells.push(percent(row.share));
        if differs {
            cells.push(or_dash(row.kinematic, |z| {
                four_digits(z.norm() * unit.times)
            }));
            cells.push(four_digits(row.loaded.norm() * unit.times));
        }
        if let (Some(z), Some(speed)) = (row.dynamic, result.speed) {
            cells.push(four_digits(z.norm() * unit.times));
            cells.push(significant(
                row.line.order.to_f64() * speed.abs() / std::f64::consts::TAU,
            ));
        }
        if let Some(map) = &result.map {
            let (speed, most) = map.largest[k];
            cells.push(four_digits(most * unit.times));
            cells.push(four_digits(speed * 30.0 / std::f64::consts::PI));
        }
        if let Some(marks) = &result.indexing_effects {
            cells.push(match &marks[k] {
                IndexingEffect::Form => "form".to_string(),
                IndexingEffect::Pitch { adjacent, .. } => format!(
                    "pitch, {} from tooth to tooth",
                    four_digits(adjacent * slow.norm() * unit.times)
                ),
            });
        }
        if !result.coincidences.is_empty() {
            let group = result
                .coincidences
                .iter()
                .position(|c| c.lines.contains(&k));
            cells.push(group.map_or(String::new(), |g| format!("[{}]", g + 1)));
        }
        table.row(cells);
    }
    text += &table.text();
    let still = result.lines.len() - shown.len();
    if all && still > 0 {
        text += &format!(
            "{} not shown: both ends move alike, or neither moves\n",
            pluralise(still, "line")
        );
    } else if still > 0 {
        let hidden = |size: &dyn Fn(usize) -> f64| {
            let all = 0..result.lines.len();
            let (mut out, mut sum) = (0.0, 0.0);
            for k in all {
                let square = size(k).powi(2);
                sum += square;
                out += if shown.contains(&k) { 0.0 } else { square };
            }
            percent(if sum > 0.0 { out / sum } else { 0.0 })
        };
        let slow = hidden(&|k| result.quasi_static(&result.lines[k]).norm());
        let fast = match at_speed {
            true => format!(
                ", {} % of those at speed",
                hidden(&|k| result.lines[k].dynamic.map_or(0.0, |z| z.norm()))
            ),
            false => String::new(),
        };
        text += &format!(
            "{} smaller lines are not shown, {slow} % of the squares{fast}; --all shows them\n",
            result.lines.len() - shown.len(),
        );
    }
    text += match differs {
        true if result.lines.iter().any(|row| row.kinematic.is_none()) => {
            "kinematic: with rigid joints; –: locked by a closed loop\n"
        }
        true => "kinematic: with rigid joints\n",
        false => {
            "kinematic and loaded amplitudes are equal: no closed loops and no load-dependent stiffness\n"
        }
    };
    text += &assumed_amplitudes_text(machine);
    text += &coincidences(machine, result, &shown);
    text += &sums(machine, result, unit);
    with_minus_signs(&text)
}

/// Amplitudes that were assumed from grades.
fn assumed_amplitudes_text(machine: &Machine) -> String {
    let each = machine
        .errors
        .iter()
        .filter_map(|error| Some((error, error.assumed.as_ref()?)));
    let lines: String = each
        .map(|(error, how)| format!("    {}: {how}\n", error.location))
        .collect();
    match lines.is_empty() {
        true => lines,
        false => format!("\nAssumed:\n{lines}"),
    }
}

/// The largest lines, by rising order.
fn largest_lines(result: &TransmissionResult, all: bool) -> Vec<usize> {
    let moves = |k: &usize| {
        let row = &result.lines[*k];
        result.map.is_some() || row.dynamic.is_some() || result.quasi_static(row).norm() > 0.0
    };
    let mut shown: Vec<usize> = (0..result.lines.len()).filter(moves).collect();
    if !all && shown.len() > MAX_ROWS {
        sort_descending(&mut shown, |&a| result.max_amplitude(a));
        shown.truncate(MAX_ROWS);
        shown.sort_unstable();
    }
    shown
}

/// A fraction with its value where it is no whole number: `225/2 = 112.5`.
fn order(order: &crate::numeric::fraction::Fraction) -> String {
    let text = order.to_string();
    match order.is_integer() {
        true => text,
        false if text.len() > 15 => significant(order.to_f64()),
        false => format!("{text} = {}", significant(order.to_f64())),
    }
}

fn with_harmonic(cause: &str, harmonic: u32) -> String {
    match harmonic {
        1 => cause.to_string(),
        n => format!("{cause}, order {n}"),
    }
}

fn coincidences(machine: &Machine, result: &TransmissionResult, shown: &[usize]) -> String {
    let mut text = String::new();
    for (g, group) in result.coincidences.iter().enumerate() {
        if !group.lines.iter().any(|k| shown.contains(k)) {
            continue;
        }
        if text.is_empty() {
            text += "\nOne record cannot separate these:\n";
        }
        let name = |k: usize| {
            format!(
                "{} ({})",
                result.lines[k].source(machine),
                result.lines[k].cause(machine)
            )
        };
        text += &format!(
            "[{}] order {}: {}\n",
            g + 1,
            order(&result.lines[group.lines[0]].line.order),
            name(group.lines[0])
        );
        for (&k, how) in group.lines[1..].iter().zip(&group.tests) {
            text += &format!(
                "    and {}; {}\n",
                name(k),
                separation_test_text(machine, how)
            );
        }
    }
    text
}

/// Elements of the budget shown, the largest.
const ELEMENTS: usize = 12;

fn sums(machine: &Machine, result: &TransmissionResult, unit: TeUnit) -> String {
    let arc = |x: f64| {
        let um = (result.radius).map_or(String::new(), |r| {
            format!(", {} µm", four_digits(1e6 * r * x))
        });
        format!("{} {}{um}", four_digits(x * unit.times), unit.name)
    };
    let both = |budget: &ErrorBudget, when: &str| {
        let at_ends = match machine.errors.iter().any(|error| error.tolerance > 0.0) {
            true => ", amplitudes at the upper ends of their tolerances",
            false => "",
        };
        let text = format!(
            "\n{when}worst case {} (all crests together{at_ends}), root of sum of squares {}{}\n",
            arc(budget.worst_case),
            arc(budget.rss),
            if at_ends.is_empty() {
                ""
            } else {
                " (of the amplitudes as stated)"
            }
        );
        let range = &budget.range;
        let turns = match range.window {
            1.0 => "one turn".to_string(),
            window => format!("{window} turns"),
        };
        // Of the median: less than the percentiles are meant to.
        let counts = range
            .percentiles
            .get(1)
            .is_some_and(|p| range.bound_added > 1e-3 * p.1);
        let added = match counts {
            true => format!(
                "; lines too high or too small for the samples are added in full, {} in total",
                arc(range.bound_added)
            ),
            false => String::new(),
        };
        if range.samples == 1 {
            let value = range.percentiles.first().map_or(0.0, |p| p.1);
            return text
                + &format!(
                    "peak to peak over {turns}, all phases known: {}{added}\n",
                    arc(value)
                );
        }
        let each = range.percentiles.iter().map(|&(p, value, error)| {
            // Closer than any amplitude is meant.
            let error = if error > 1e-6 * value { error } else { 0.0 };
            let value =
                super::number_format::with_deviation(value * unit.times, error * unit.times);
            format!("{p} % {value}")
        });
        text + &format!(
            "peak to peak over {turns}, over unknown phases and tolerances, {}: {}{added}\n",
            unit.name,
            each.collect::<Vec<_>>().join(", ")
        )
    };
    let mut text = match &result.dynamic_budget {
        Some(fast) => both(&result.budget, "quasi-static: ") + &both(&fast.budget, "at speed: "),
        None => both(&result.budget, ""),
    };
    if result.wind_up != 0.0 {
        text += &format!("wind-up under the mean loads {}\n", arc(result.wind_up));
    }
    if result.second_order > 0.0 {
        text += &format!(
            "second order of offsets, not in the lines: {} at most\n",
            arc(result.second_order)
        );
    }
    if let Some(period) = &result.period {
        let exact = period.to_string();
        let shown = if exact.len() > 20 {
            format!("{:.3e}", period.to_f64())
        } else {
            exact
        };
        let unit = if shown == "1" { "turn" } else { "turns" };
        text += &format!("common period: {shown} {unit}\n");
    }
    text += &elements(result);
    text += &record(result, unit);
    text
}

/// Contribution of each element, and the negligible ones; with the values at speed on request.
fn elements(result: &TransmissionResult) -> String {
    let fast = result.dynamic_budget.as_ref();
    let share = |e: usize| {
        let fast = fast.map_or(0.0, |f| f.budget.elements[e].share);
        result.budget.elements[e].share.max(fast)
    };
    let mut order = falling_order((0..result.elements.len()).map(share));
    order.truncate(ELEMENTS);
    const AT_SPEED: &str = "at speed: share [%]|one grade finer [% less]|without it [% less]";
    let mut table = Table::named("element|share [%]|one grade finer [% less]|without it [% less]")
        .columns_if(fast.is_some(), AT_SPEED);
    for &e in order.iter().filter(|&&e| share(e) > 0.0) {
        let mut cells = vec![result.elements[e].clone()];
        for budget in [Some(&result.budget), fast.map(|f| &f.budget)] {
            cells.extend(budget.into_iter().flat_map(|b| {
                let found = &b.elements[e];
                let better = found.one_grade_finer.map_or(String::new(), percent);
                [percent(found.share), better, percent(found.rss_reduction)]
            }));
        }
        table.row(cells);
    }
    let mut text = format!(
        "\nReduction of the root of the sum of squares (one grade: amplitudes divided by √2):\n{}",
        table.text()
    );
    let out = |when: &str, (out, off, worst): &(Vec<usize>, f64, f64)| {
        if out.is_empty() {
            return String::new();
        }
        let names: Vec<&str> = out.iter().map(|&e| result.elements[e].as_str()).collect();
        format!(
            "negligible{when}: {}; together {} % of the root of the sum of squares, {} % of the worst case\n",
            names.join(", "),
            percent(*off),
            percent(*worst)
        )
    };
    match fast {
        Some(fast) => {
            text += &out(" for slow rotation", &result.negligible);
            text += &out(" at this speed", &fast.negligible);
        }
        None => text += &out("", &result.negligible),
    }
    text
}

fn record(result: &TransmissionResult, unit: TeUnit) -> String {
    let Some(made) = &result.record else {
        return String::new();
    };
    let arc = |x: f64| four_digits(x * unit.times);
    let mut text = format!(
        "\nrecord over {}, {} samples, {}: F_i′ {} over all, {} over a turn",
        pluralise(made.record.turns, "turn"),
        made.record.values.len(),
        unit.name,
        arc(made.total),
        arc(made.per_revolution)
    );
    if let (Some([tooth, long, short]), Some(teeth)) = (made.per_tooth, made.teeth) {
        text += &format!(
            "; by {teeth} teeth f_i′ {}, long wave {}, short wave {}",
            arc(tooth),
            arc(long),
            arc(short)
        );
    }
    text + "\n"
}
