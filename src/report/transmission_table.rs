//! Transmission error of a chain as tables for a terminal.

use super::number::{brief, percent, significant};
use super::table::{finish, plain};
use super::transmission::{Unit, cause, phase, source, test};
use crate::machine::parts::Machine;
use crate::plan::transmission::run::Answer;
use crate::transmission::indexing::Mark;

/// Lines shown unless all are wanted: the largest.
const ROWS: usize = 25;

/// The order table, what coincides, the sums.
pub fn table(machine: &Machine, answer: &Answer, all: bool) -> String {
    let chain = &answer.chain;
    let name = |freedom: usize| machine.nodes[machine.freedoms[freedom].node].name.as_str();
    let mut text = format!(
        "{} driven by {}",
        name(chain.ends.output),
        name(chain.ends.driver)
    );
    if let Some(against) = chain.ends.against {
        text += &format!(", against {}", name(against));
    }
    let unit = Unit::of(machine, answer);
    let per = match chain.per == chain.ends.output {
        true => "the output".to_string(),
        false => format!("{}, which moves it", name(chain.per)),
    };
    if let (Some(turns), true) = (
        chain.turns(chain.ends.driver),
        chain.per != chain.ends.driver,
    ) {
        text += &format!(": {turns} turns of {} a turn", name(chain.ends.driver));
    }
    text += &format!(". Orders per turn of {per}.\n\n");
    let shown = shown(answer, all);
    let mut table = plain();
    let at_speed = answer.speed.is_some();
    let largest = (answer.rows.iter()).fold(0.0f64, |m, row| m.max(answer.slow(row).norm()));
    let differs = answer.rows.iter().any(|row| {
        let slow = answer.slow(row).norm();
        (row.loaded.norm() - slow).abs() > 5e-4 * slow + 1e-9 * largest
    });
    let mut head = vec!["order", "source", "cause", "amplitude"];
    let mut units = vec!["", "", "", unit.name];
    let mut column = |is: bool, name: &'static str, unit: &'static str| {
        if is {
            head.push(name);
            units.push(unit);
        }
    };
    column(answer.radius.is_some(), "arc", "µm");
    column(true, "phase", "deg");
    column(true, "share", "%");
    column(differs, "loaded", unit.name);
    column(at_speed, "at speed", unit.name);
    column(at_speed, "frequency", "Hz");
    column(answer.map.is_some(), "largest", unit.name);
    column(answer.map.is_some(), "at", "rpm");
    column(answer.marks.is_some(), "work", "");
    column(!answer.coincidences.is_empty(), "", "");
    table.add_row(head);
    table.add_row(units);
    for &k in &shown {
        let row = &answer.rows[k];
        let slow = answer.slow(row);
        let mut cells = vec![
            order(&row.line.order),
            source(machine, row),
            with_harmonic(cause(machine, row), row.line.harmonic),
            brief(slow.norm() * unit.times),
        ];
        cells.extend(answer.radius.map(|r| brief(1e6 * r * slow.norm())));
        cells.push(phase(machine, row, slow).map_or("?".to_string(), |p| format!("{p:.0}")));
        cells.push(percent(row.share));
        if differs {
            cells.push(brief(row.loaded.norm() * unit.times));
        }
        if let (Some(z), Some(speed)) = (row.dynamic, answer.speed) {
            cells.push(brief(z.norm() * unit.times));
            cells.push(significant(
                row.line.order.value() * speed.abs() / std::f64::consts::TAU,
            ));
        }
        if let Some(map) = &answer.map {
            let row = &map.amplitudes[k];
            let at = (0..row.len())
                .max_by(|&a, &b| row[a].total_cmp(&row[b]))
                .unwrap_or(0);
            cells.push(brief(row[at] * unit.times));
            cells.push(brief(map.speeds[at] * 30.0 / std::f64::consts::PI));
        }
        if let Some(marks) = &answer.marks {
            cells.push(match &marks[k] {
                Mark::Form => "form".to_string(),
                Mark::Pitch { adjacent, .. } => format!(
                    "pitch, {} from tooth to tooth",
                    brief(adjacent * slow.norm() * unit.times)
                ),
            });
        }
        if !answer.coincidences.is_empty() {
            let group = answer
                .coincidences
                .iter()
                .position(|c| c.lines.contains(&k));
            cells.push(group.map_or(String::new(), |g| format!("[{}]", g + 1)));
        }
        table.add_row(cells);
    }
    align(&mut table);
    text += &finish(&table);
    if shown.len() < answer.rows.len() {
        let hidden: f64 = (0..answer.rows.len())
            .filter(|k| !shown.contains(k))
            .map(|k| answer.rows[k].share)
            .sum();
        text += &format!(
            "{} smaller lines are not shown, {} % of the squares; --all shows them\n",
            answer.rows.len() - shown.len(),
            percent(hidden)
        );
    }
    text += &assumed(machine);
    text += &coincidences(machine, answer, &shown);
    text += &sums(answer, unit);
    text
}

/// Amplitudes that were assumed from grades.
fn assumed(machine: &Machine) -> String {
    let each = machine
        .errors
        .iter()
        .filter_map(|error| Some((error, error.assumed.as_ref()?)));
    let lines: String = each
        .map(|(error, how)| format!("    {}: {how}\n", error.on))
        .collect();
    match lines.is_empty() {
        true => lines,
        false => format!("\nAssumed:\n{lines}"),
    }
}

/// The largest lines, by rising order.
fn shown(answer: &Answer, all: bool) -> Vec<usize> {
    let moves = |k: &usize| {
        let row = &answer.rows[*k];
        answer.map.is_some() || row.dynamic.is_some() || answer.slow(row).norm() > 0.0
    };
    let mut shown: Vec<usize> = (0..answer.rows.len()).filter(moves).collect();
    if !all && shown.len() > ROWS {
        shown.sort_by(|&a, &b| answer.rows[b].share.total_cmp(&answer.rows[a].share));
        shown.truncate(ROWS);
        shown.sort_unstable();
    }
    shown
}

/// A fraction with its value where it is no whole number: `225/2 = 112.5`.
fn order(order: &crate::numeric::fraction::Fraction) -> String {
    let text = order.to_string();
    match order.is_whole() {
        true => text,
        false if text.len() > 15 => significant(order.value()),
        false => format!("{text} = {}", significant(order.value())),
    }
}

fn with_harmonic(cause: &str, harmonic: u32) -> String {
    match harmonic {
        1 => cause.to_string(),
        n => format!("{cause}, order {n}"),
    }
}

fn coincidences(machine: &Machine, answer: &Answer, shown: &[usize]) -> String {
    let mut text = String::new();
    for (g, group) in answer.coincidences.iter().enumerate() {
        if !group.lines.iter().any(|k| shown.contains(k)) {
            continue;
        }
        if text.is_empty() {
            text += "\nOne record cannot tell these apart:\n";
        }
        let name = |k: usize| {
            format!(
                "{} ({})",
                source(machine, &answer.rows[k]),
                cause(machine, &answer.rows[k])
            )
        };
        text += &format!(
            "[{}] order {}: {}\n",
            g + 1,
            order(&answer.rows[group.lines[0]].line.order),
            name(group.lines[0])
        );
        for (&k, how) in group.lines[1..].iter().zip(&group.tests) {
            text += &format!("    and {}; {}\n", name(k), test(machine, how));
        }
    }
    text
}

/// Elements of the budget shown, the largest.
const ELEMENTS: usize = 12;

fn sums(answer: &Answer, unit: Unit) -> String {
    let arc = |x: f64| {
        let um = (answer.radius).map_or(String::new(), |r| format!(", {} µm", brief(1e6 * r * x)));
        format!("{} {}{um}", brief(x * unit.times), unit.name)
    };
    let budget = &answer.budget;
    let mut text = format!(
        "\nworst case {} (all crests together), root of sum of squares {}\n",
        arc(budget.worst_case),
        arc(budget.rss)
    );
    let range = &budget.range;
    let turns = if range.window == 1.0 {
        "one turn".to_string()
    } else {
        format!("{} turns", range.window)
    };
    let each = range.percentiles.iter().map(|(p, value, error)| {
        let value = super::number::with_deviation(value * unit.times, error * unit.times);
        format!("{p} % {value}")
    });
    text += &format!(
        "range over {turns}, over unknown phases and tolerances, {}: {}\n",
        unit.name,
        each.collect::<Vec<_>>().join(", ")
    );
    if answer.wind_up != 0.0 {
        text += &format!("wind-up under the mean loads {}\n", arc(answer.wind_up));
    }
    if answer.second_order > 0.0 {
        text += &format!(
            "second order of offsets, left out of the lines: {} at most\n",
            arc(answer.second_order)
        );
    }
    if let Some(period) = &answer.period {
        let exact = period.to_string();
        let shown = if exact.len() > 20 {
            format!("{:.3e}", period.value())
        } else {
            exact
        };
        text += &format!("everything repeats after {shown} turns\n");
    }
    text += &elements(answer);
    text += &record(answer, unit);
    text
}

/// What each element counts for, and what could be left out.
fn elements(answer: &Answer) -> String {
    let mut order: Vec<usize> = (0..answer.elements.len()).collect();
    order.sort_by(|&a, &b| {
        answer.budget.elements[b]
            .share
            .total_cmp(&answer.budget.elements[a].share)
    });
    order.truncate(ELEMENTS);
    let mut table = plain();
    table.add_row(vec!["element", "share", "one grade better", "without it"]);
    table.add_row(vec!["", "%", "% off", "% off"]);
    for &e in order
        .iter()
        .filter(|&&e| answer.budget.elements[e].share > 0.0)
    {
        let found = &answer.budget.elements[e];
        table.add_row(vec![
            answer.elements[e].clone(),
            percent(found.share),
            percent(found.one_grade),
            percent(found.without),
        ]);
    }
    super::table::right_but_first(&mut table);
    let mut text = format!(
        "\nOff the root of the sum of squares (one grade: amplitudes 1/√2 of what they are):\n{}",
        finish(&table)
    );
    let (out, off, worst) = &answer.negligible;
    if !out.is_empty() {
        let names: Vec<&str> = out.iter().map(|&e| answer.elements[e].as_str()).collect();
        text += &format!(
            "could be left out: {}; together {} % of the root of the sum of squares, {} % of the worst case\n",
            names.join(", "),
            percent(*off),
            percent(*worst)
        );
    }
    text
}

fn record(answer: &Answer, unit: Unit) -> String {
    let Some(made) = &answer.record else {
        return String::new();
    };
    let arc = |x: f64| brief(x * unit.times);
    let mut text = format!(
        "\nrecord over {} turns, {} samples, {}: F_i′ {} over all, {} over a turn",
        made.record.turns,
        made.record.values.len(),
        unit.name,
        arc(made.total),
        arc(made.by_turn)
    );
    if let (Some([tooth, long, short]), Some(teeth)) = (made.by_tooth, made.teeth) {
        text += &format!(
            "; by {teeth} teeth f_i′ {}, long wave {}, short wave {}",
            arc(tooth),
            arc(long),
            arc(short)
        );
    }
    text + "\n"
}

/// Words to the left, numbers to the right.
fn align(table: &mut comfy_table::Table) {
    use comfy_table::CellAlignment::{Left, Right};
    let last = table.column_count().saturating_sub(1);
    for (at, column) in table.column_iter_mut().enumerate() {
        let words = matches!(at, 1 | 2) || at == last;
        column.set_cell_alignment(if words { Left } else { Right });
    }
}
