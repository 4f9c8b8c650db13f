//! Transmission error of a chain as tables for a terminal.

use super::number::{brief, percent, significant};
use super::table::{finish, plain};
use super::transmission::{ARCSEC, cause, phase, source, test};
use crate::machine::parts::Machine;
use crate::plan::transmission::run::Answer;

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
    if let Some(turns) = chain.turns(chain.ends.driver) {
        text += &format!(": {turns} turns of {} a turn", name(chain.ends.driver));
    }
    text += ". Orders per turn of the output.\n\n";
    let shown = shown(answer, all);
    let mut table = plain();
    let at_speed = answer.speed.is_some();
    let differs = answer.rows.iter().any(|row| {
        (row.loaded.norm() - answer.slow(row).norm()).abs() > 5e-4 * answer.slow(row).norm()
    });
    let mut head = vec!["order", "source", "cause", "amplitude"];
    let mut units = vec!["", "", "", "arcsec"];
    let mut column = |is: bool, name: &'static str, unit: &'static str| {
        if is {
            head.push(name);
            units.push(unit);
        }
    };
    column(answer.radius.is_some(), "arc", "µm");
    column(true, "phase", "deg");
    column(true, "share", "%");
    column(differs, "loaded", "arcsec");
    column(at_speed, "at speed", "arcsec");
    column(at_speed, "frequency", "Hz");
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
            brief(slow.norm() * ARCSEC),
        ];
        cells.extend(answer.radius.map(|r| brief(1e6 * r * slow.norm())));
        cells.push(phase(machine, row, slow).map_or("?".to_string(), |p| format!("{p:.0}")));
        cells.push(percent(row.share));
        if differs {
            cells.push(brief(row.loaded.norm() * ARCSEC));
        }
        if let (Some(z), Some(speed)) = (row.dynamic, answer.speed) {
            cells.push(brief(z.norm() * ARCSEC));
            cells.push(significant(
                row.line.order.value() * speed.abs() / std::f64::consts::TAU,
            ));
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
    text += &coincidences(machine, answer, &shown);
    text += &sums(answer);
    text
}

/// The largest lines, by rising order.
fn shown(answer: &Answer, all: bool) -> Vec<usize> {
    let mut shown: Vec<usize> = (0..answer.rows.len()).collect();
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

fn sums(answer: &Answer) -> String {
    let arc = |x: f64| {
        let um = answer
            .radius
            .map_or(String::new(), |r| format!(", {} µm", brief(1e6 * r * x)));
        format!("{} arcsec{um}", brief(x * ARCSEC))
    };
    let mut text = format!(
        "\nworst case {} (all crests together), root of sum of squares {}\n",
        arc(answer.worst_case()),
        arc(answer.rss())
    );
    if answer.wind_up != 0.0 {
        text += &format!("wind-up under the mean loads {}\n", arc(answer.wind_up));
    }
    if let Some(period) = &answer.period {
        text += &format!("everything repeats after {period} turns of the output\n");
    }
    text
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
