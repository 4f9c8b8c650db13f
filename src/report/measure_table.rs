//! Measured gears as tables for a terminal: today's name beside the older one, value, limit, grades, marks.

use super::measure::{judged, standard};
use super::number::INTERVAL;
use super::table::{finish, plain, right_but_last};
use crate::gear::measurement::quantity::Quantity;
use crate::numeric::statistics::HALF_INTERVAL;
use crate::plan::measure::grading::{Reached, Row};
use crate::plan::measure::run::Answer;
use crate::scene::measured::MeasuredGear;

/// The gear, what was asked, and all values.
pub fn deviations(gear: &MeasuredGear, answer: &Answer) -> String {
    let mut text = head(gear);
    let (measured, predicted): (Vec<&Row>, Vec<&Row>) =
        answer.rows.iter().partition(|row| !row.predicted);
    text += "\n";
    text += &table(gear, &measured);
    if !predicted.is_empty() {
        text += "\nnot measured, from the other charts\n";
        text += &table(gear, &predicted);
    }
    if !answer.notes.is_empty() {
        text += "\n";
        for note in &answer.notes {
            text += &(crate::base::words::wrapped(note) + "\n");
        }
    }
    text += "\n";
    if answer.rows.iter().any(|row| row.estimate.std.is_some()) {
        text += INTERVAL;
    }
    text + &verdict(gear, answer)
}

fn head(gear: &MeasuredGear) -> String {
    let involute = &gear.gear;
    let mut text = format!("{}\n", gear.title);
    text += &format!(
        "z {}, m {} mm, α {} deg",
        involute.teeth,
        short(1e3 * involute.module),
        short(involute.pressure_angle.to_degrees())
    );
    if involute.helix != 0.0 {
        text += &format!(", β {} deg", short(involute.helix.to_degrees()));
    }
    if involute.profile_shift != 0.0 {
        text += &format!(", x {}", short(involute.profile_shift));
    }
    text += &format!(", d {} mm", short(1e3 * involute.diameter()));
    if let Some(width) = gear.face_width {
        text += &format!(", b {} mm", short(1e3 * width));
    }
    text += "\n";
    match &gear.demand {
        Some(demand) => {
            text += &format!(
                "asked: {}, {}\n",
                demand.accuracy.explained(),
                standard(demand)
            );
        }
        None => text += "no accuracy is asked\n",
    }
    text
}

/// Without the zeros no digit needs.
fn short(x: f64) -> String {
    super::number::brief((x * 1e6).round() / 1e6)
}

fn table(gear: &MeasuredGear, rows: &[&Row]) -> String {
    let by_table = rows.iter().any(|row| row.reached_by_table.is_some());
    let mut table = plain();
    let mut heads = vec![
        "",
        "",
        "JB 179-60",
        "flank",
        "value",
        "±",
        "limit",
        "grade",
        ":1995",
        ":2013",
    ];
    let mut units = vec!["", "", "", "", "µm", "µm", "µm", "asked", "", ""];
    if by_table {
        heads.push("table");
        units.push("");
    }
    heads.extend(["", ""]);
    units.extend(["", ""]);
    table.add_row(heads);
    table.add_row(units);
    for row in rows {
        let dash = || "–".to_string();
        let mut cells = vec![
            symbol(row.quantity),
            row.quantity.name().to_string(),
            row.quantity
                .old()
                .map_or(String::new(), |old| old.symbol.to_string()),
            row.side.word().to_string(),
            micro(row.estimate.value),
            row.estimate
                .std
                .map_or(dash(), |u| micro(HALF_INTERVAL * u)),
            limit(row).unwrap_or_else(dash),
            row.asked.map_or(dash(), |grade| grade.to_string()),
            grade(row.reached[0]),
            grade(row.reached[1]),
        ];
        if by_table {
            cells.push(grade(row.reached_by_table));
        }
        cells.push(mark(row).to_string());
        cells.push(match row.limiting {
            true => format!(
                "{}  ◄ sets the grade, {}",
                row.found,
                grade(judged(gear, row))
            ),
            false => row.found.clone(),
        });
        table.add_row(cells);
    }
    right_but_last(&mut table);
    for at in [0, 1, 2, 3] {
        if let Some(column) = table.column_mut(at) {
            column.set_cell_alignment(comfy_table::CellAlignment::Left);
        }
    }
    finish(&table)
}

fn symbol(quantity: Quantity) -> String {
    match quantity {
        Quantity::OverPitches(k) => format!("F_p{k}"),
        other => other.symbol().to_string(),
    }
}

fn micro(x: f64) -> String {
    // No minus before nothing.
    let text = format!("{:.2}", 1e6 * x);
    match text.trim_start_matches(['-', '0', '.']).is_empty() {
        true => "0.00".to_string(),
        false => text.replace('-', "−"),
    }
}

fn limit(row: &Row) -> Option<String> {
    let (low, high) = row.limits?;
    let one = |x: f64| super::number::brief((1e7 * x).round() / 10.0).replace('-', "−");
    Some(match low == -high {
        true => one(high),
        false => format!("{} to {}", one(low), one(high)),
    })
}

fn grade(reached: Option<Reached>) -> String {
    match reached {
        Some(Reached::Grade(grade)) => grade.to_string(),
        Some(Reached::Beyond(coarsest)) => format!(">{coarsest}"),
        None => "–".to_string(),
    }
}

fn mark(row: &Row) -> &'static str {
    match (row.within(), row.in_doubt()) {
        (None, _) => "",
        (Some(true), false) => "in",
        (Some(true), true) => "in?",
        (Some(false), false) => "OUT",
        (Some(false), true) => "OUT?",
    }
}

fn verdict(gear: &MeasuredGear, answer: &Answer) -> String {
    let measured = || answer.rows.iter().filter(|row| !row.predicted);
    let coarsest = measured().filter_map(|row| judged(gear, row)).max();
    let by = match &gear.demand {
        Some(demand) => standard(demand),
        None => "ISO 1328-1:2013",
    };
    let mut text = match coarsest {
        Some(Reached::Grade(grade)) => {
            format!("reached: grade {grade}, of what {by} has tolerances for\n")
        }
        Some(Reached::Beyond(coarsest)) => {
            format!("coarser than grade {coarsest}, the coarsest of {by}\n")
        }
        None => String::new(),
    };
    let out = measured().filter(|row| row.within() == Some(false));
    let out: Vec<String> = out
        .map(|row| {
            format!("{} {}", symbol(row.quantity), row.side.word())
                .trim_end()
                .to_string()
        })
        .collect();
    let all = measured().count();
    let held = measured().filter(|row| row.limits.is_some()).count();
    text += &match (held, out.is_empty()) {
        (0, _) => "nothing is held against a limit\n".to_string(),
        (_, true) => format!("{held} of {all} values have a limit, all within it\n"),
        (_, false) => format!(
            "OUT of what was asked: {} ({held} of {all} values have a limit)\n",
            out.join(", ")
        ),
    };
    // Of what was asked by a standard, not of an allowance of thickness.
    let by_grade = measured().filter(|row| row.asked.is_some()).count();
    if gear.demand.is_some() && by_grade == 0 {
        text +=
            &format!("{by} gives none of these values a limit: the grade asked is not judged\n");
    }
    text
}
