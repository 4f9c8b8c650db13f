//! Transmission error of a chain as tables for a terminal.

use super::number::{brief, percent, significant, with_minus_signs};
use super::table::{finish, plain};
use super::transmission::{Unit, cause, phase, source, test};
use crate::base::words::counted;
use crate::machine::parts::Machine;
use crate::plan::transmission::run::Answer;
use crate::transmission::budget::Budget;
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
    text += &format!(
        ". Orders per turn of {per}. The angle of {} is prescribed and answers nothing.\n\n",
        name(chain.ends.driver)
    );
    let shown = shown(answer, all);
    let mut table = plain();
    let at_speed = answer.speed.is_some();
    let differs = answer.differs_under_load();
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
    column(differs, "kinematic", unit.name);
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
        let turned = phase(machine, row, slow).map(f64::round);
        let half = |p: f64| if p <= -180.0 { 180.0 } else { p };
        cells.push(turned.map_or("?".to_string(), |p| format!("{:.0}", half(p))));
        cells.push(percent(row.share));
        if differs {
            let rigid = row.kinematic.map(|z| brief(z.norm() * unit.times));
            cells.push(rigid.unwrap_or("–".to_string()));
            cells.push(brief(row.loaded.norm() * unit.times));
        }
        if let (Some(z), Some(speed)) = (row.dynamic, answer.speed) {
            cells.push(brief(z.norm() * unit.times));
            cells.push(significant(
                row.line.order.value() * speed.abs() / std::f64::consts::TAU,
            ));
        }
        if let Some(map) = &answer.map {
            let (speed, most) = map.largest[k];
            cells.push(brief(most * unit.times));
            cells.push(brief(speed * 30.0 / std::f64::consts::PI));
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
    let still = answer.rows.len() - shown.len();
    if all && still > 0 {
        text += &format!(
            "{} not shown: both ends move alike, or neither does\n",
            counted(still, "line")
        );
    } else if still > 0 {
        let hidden = |size: &dyn Fn(usize) -> f64| {
            let all = 0..answer.rows.len();
            let (mut out, mut sum) = (0.0, 0.0);
            for k in all {
                let square = size(k).powi(2);
                sum += square;
                out += if shown.contains(&k) { 0.0 } else { square };
            }
            percent(if sum > 0.0 { out / sum } else { 0.0 })
        };
        let slow = hidden(&|k| answer.slow(&answer.rows[k]).norm());
        let fast = match at_speed {
            true => format!(
                ", {} % of those at speed",
                hidden(&|k| answer.rows[k].dynamic.map_or(0.0, |z| z.norm()))
            ),
            false => String::new(),
        };
        text += &format!(
            "{} smaller lines are not shown, {slow} % of the squares{fast}; --all shows them\n",
            answer.rows.len() - shown.len(),
        );
    }
    text += match differs {
        true if answer.rows.iter().any(|row| row.kinematic.is_none()) => {
            "kinematic: with rigid joints; –: these would lock, for a loop does not fit the line alone\n"
        }
        true => "kinematic: with rigid joints\n",
        false => {
            "kinematic and loaded amplitudes are alike: no loop shares errors out, and no stiffness changes under load\n"
        }
    };
    text += &assumed(machine);
    text += &coincidences(machine, answer, &shown);
    text += &sums(machine, answer, unit);
    with_minus_signs(&text)
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
        shown.sort_by(|&a, &b| answer.most(b).total_cmp(&answer.most(a)));
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

fn sums(machine: &Machine, answer: &Answer, unit: Unit) -> String {
    let arc = |x: f64| {
        let um = (answer.radius).map_or(String::new(), |r| format!(", {} µm", brief(1e6 * r * x)));
        format!("{} {}{um}", brief(x * unit.times), unit.name)
    };
    let both = |budget: &Budget, when: &str| {
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
            .is_some_and(|p| range.added > 1e-3 * p.1);
        let added = match counts {
            true => format!(
                "; lines too fine or too small for the samples are added whole, {} in all",
                arc(range.added)
            ),
            false => String::new(),
        };
        if range.samples == 1 {
            let value = range.percentiles.first().map_or(0.0, |p| p.1);
            return text
                + &format!(
                    "range over {turns}, every phase known: {}{added}\n",
                    arc(value)
                );
        }
        let each = range.percentiles.iter().map(|&(p, value, error)| {
            // Closer than any amplitude is meant.
            let error = if error > 1e-6 * value { error } else { 0.0 };
            let value = super::number::with_deviation(value * unit.times, error * unit.times);
            format!("{p} % {value}")
        });
        text + &format!(
            "range over {turns}, over unknown phases and tolerances, {}: {}{added}\n",
            unit.name,
            each.collect::<Vec<_>>().join(", ")
        )
    };
    let mut text = match &answer.at_speed {
        Some(fast) => both(&answer.budget, "slowly: ") + &both(&fast.budget, "at speed: "),
        None => both(&answer.budget, ""),
    };
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
        let unit = if shown == "1" { "turn" } else { "turns" };
        text += &format!("everything repeats after {shown} {unit}\n");
    }
    text += &elements(answer);
    text += &record(answer, unit);
    text
}

/// What each element counts for, and what could be left out; at speed beside it where one is asked for.
fn elements(answer: &Answer) -> String {
    let fast = answer.at_speed.as_ref();
    let share = |e: usize| {
        let fast = fast.map_or(0.0, |f| f.budget.elements[e].share);
        answer.budget.elements[e].share.max(fast)
    };
    let mut order: Vec<usize> = (0..answer.elements.len()).collect();
    order.sort_by(|&a, &b| share(b).total_cmp(&share(a)));
    order.truncate(ELEMENTS);
    let mut table = plain();
    let mut head = vec!["element", "share", "one grade better", "without it"];
    let mut units = vec!["", "%", "% off", "% off"];
    if fast.is_some() {
        head.extend(["at speed: share", "one grade better", "without it"]);
        units.extend(["%", "% off", "% off"]);
    }
    table.add_row(head);
    table.add_row(units);
    for &e in order.iter().filter(|&&e| share(e) > 0.0) {
        let mut cells = vec![answer.elements[e].clone()];
        for budget in [Some(&answer.budget), fast.map(|f| &f.budget)] {
            cells.extend(budget.into_iter().flat_map(|b| {
                let found = &b.elements[e];
                let better = found.one_grade.map_or(String::new(), percent);
                [percent(found.share), better, percent(found.without)]
            }));
        }
        table.add_row(cells);
    }
    super::table::right_but_first(&mut table);
    let mut text = format!(
        "\nOff the root of the sum of squares (one grade: amplitudes 1/√2 of what they are):\n{}",
        finish(&table)
    );
    let out = |when: &str, (out, off, worst): &(Vec<usize>, f64, f64)| {
        if out.is_empty() {
            return String::new();
        }
        let names: Vec<&str> = out.iter().map(|&e| answer.elements[e].as_str()).collect();
        format!(
            "could be left out{when}: {}; together {} % of the root of the sum of squares, {} % of the worst case\n",
            names.join(", "),
            percent(*off),
            percent(*worst)
        )
    };
    match fast {
        Some(fast) => {
            text += &out(" as far as slow turning goes", &answer.negligible);
            text += &out(" as far as this speed goes", &fast.negligible);
        }
        None => text += &out("", &answer.negligible),
    }
    text
}

fn record(answer: &Answer, unit: Unit) -> String {
    let Some(made) = &answer.record else {
        return String::new();
    };
    let arc = |x: f64| brief(x * unit.times);
    let mut text = format!(
        "\nrecord over {}, {} samples, {}: F_i′ {} over all, {} over a turn",
        counted(made.record.turns, "turn"),
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
