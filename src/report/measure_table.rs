//! Measured gears as tables for a terminal: today's name next to the older one, value, limit, grades, marks.

use super::measure::{required_grade_result, standard};
use super::modes_table::{finish, plain, right_but_last};
use super::number_format::INTERVAL_FOOTNOTE;
use crate::gear::measurement::deviation::GearDeviation;
use crate::numeric::statistics::Z_95;
use crate::plan::measure::grading::{AchievedGrade, GradedValue};
use crate::plan::measure::run::MeasurementResult;
use crate::scene::measured_gear::MeasuredGear;

/// The gear, what was asked, and all values.
pub fn deviations(gear: &MeasuredGear, result: &MeasurementResult) -> String {
    let mut text = head(gear);
    let (measured, predicted): (Vec<&GradedValue>, Vec<&GradedValue>) =
        result.values.iter().partition(|value| !value.predicted);
    text += "\n";
    text += &table(gear, &measured);
    if !predicted.is_empty() {
        text += "\nnot measured, from the other charts\n";
        text += &table(gear, &predicted);
    }
    if !result.notes.is_empty() {
        text += "\n";
        for note in &result.notes {
            text += &(crate::base::text::wrap_lines(note) + "\n");
        }
    }
    text += "\n";
    if result
        .values
        .iter()
        .any(|value| value.estimate.std.is_some())
    {
        text += INTERVAL_FOOTNOTE;
    }
    text + &verdict(gear, result)
}

fn head(gear: &MeasuredGear) -> String {
    let involute_gear = &gear.gear;
    let mut text = format!("{}\n", gear.title);
    text += &format!(
        "z {}, m {} mm, α {} deg",
        involute_gear.teeth,
        short(1e3 * involute_gear.module),
        short(involute_gear.pressure_angle.to_degrees())
    );
    if involute_gear.helix != 0.0 {
        text += &format!(", β {} deg", short(involute_gear.helix.to_degrees()));
    }
    if involute_gear.profile_shift != 0.0 {
        text += &format!(", x {}", short(involute_gear.profile_shift));
    }
    text += &format!(", d {} mm", short(1e3 * involute_gear.reference_diameter()));
    if let Some(width) = gear.face_width {
        text += &format!(", b {} mm", short(1e3 * width));
    }
    text += "\n";
    match &gear.requirement {
        Some(requirement) => {
            text += &format!(
                "asked: {}, {}\n",
                requirement.grades.describe(),
                standard(requirement)
            );
        }
        None => text += "no accuracy is asked\n",
    }
    text
}

/// Without the zeros no digit needs.
fn short(x: f64) -> String {
    super::number_format::four_digits((x * 1e6).round() / 1e6)
}

fn table(gear: &MeasuredGear, values: &[&GradedValue]) -> String {
    let by_table = values
        .iter()
        .any(|graded_value| graded_value.reached_by_table.is_some());
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
    for graded_value in values {
        let dash = || "–".to_string();
        let mut cells = vec![
            symbol(graded_value.deviation),
            graded_value.deviation.name().to_string(),
            graded_value
                .deviation
                .jb179_name()
                .map_or(String::new(), |old| old.symbol.to_string()),
            graded_value.side.name().to_string(),
            micro(graded_value.estimate.value),
            graded_value
                .estimate
                .std
                .map_or(dash(), |u| micro(Z_95 * u)),
            limit(graded_value).unwrap_or_else(dash),
            graded_value
                .required_grade
                .map_or(dash(), |grade| grade.to_string()),
            grade(graded_value.achieved[0]),
            grade(graded_value.achieved[1]),
        ];
        if by_table {
            cells.push(grade(graded_value.reached_by_table));
        }
        cells.push(mark(graded_value).to_string());
        cells.push(match graded_value.limiting {
            true => format!(
                "{}  ◄ sets the grade, {}",
                graded_value.location,
                grade(required_grade_result(gear, graded_value))
            ),
            false => graded_value.location.clone(),
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

fn symbol(deviation: GearDeviation) -> String {
    match deviation {
        GearDeviation::OverPitches(k) => format!("F_p{k}"),
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

fn limit(value: &GradedValue) -> Option<String> {
    let (low, high) = value.limits?;
    let one =
        |x: f64| super::number_format::four_digits((1e7 * x).round() / 10.0).replace('-', "−");
    Some(match low == -high {
        true => one(high),
        false => format!("{} to {}", one(low), one(high)),
    })
}

fn grade(achieved_grade: Option<AchievedGrade>) -> String {
    match achieved_grade {
        Some(AchievedGrade::Grade(grade)) => grade.to_string(),
        Some(AchievedGrade::Beyond(coarsest)) => format!(">{coarsest}"),
        None => "–".to_string(),
    }
}

fn mark(value: &GradedValue) -> &'static str {
    match (value.is_within_limits(), value.is_inconclusive()) {
        (None, _) => "",
        (Some(true), false) => "in",
        (Some(true), true) => "in?",
        (Some(false), false) => "OUT",
        (Some(false), true) => "OUT?",
    }
}

fn verdict(gear: &MeasuredGear, result: &MeasurementResult) -> String {
    let measured = || result.values.iter().filter(|value| !value.predicted);
    let coarsest = measured()
        .filter_map(|value| required_grade_result(gear, value))
        .max();
    let by = match &gear.requirement {
        Some(requirement) => standard(requirement),
        None => "ISO 1328-1:2013",
    };
    let mut text = match coarsest {
        Some(AchievedGrade::Grade(grade)) => {
            format!("reached: grade {grade}, of what {by} has tolerances for\n")
        }
        Some(AchievedGrade::Beyond(coarsest)) => {
            format!("coarser than grade {coarsest}, the coarsest of {by}\n")
        }
        None => String::new(),
    };
    let out = measured().filter(|value| value.is_within_limits() == Some(false));
    let out: Vec<String> = out
        .map(|value| {
            format!("{} {}", symbol(value.deviation), value.side.name())
                .trim_end()
                .to_string()
        })
        .collect();
    let all = measured().count();
    let held = measured().filter(|value| value.limits.is_some()).count();
    text += &match (held, out.is_empty()) {
        (0, _) => "nothing is held against a limit\n".to_string(),
        (_, true) => format!("{held} of {all} values have a limit, all within it\n"),
        (_, false) => format!(
            "OUT of what was asked: {} ({held} of {all} values have a limit)\n",
            out.join(", ")
        ),
    };
    // Of what was asked by a standard, not of an allowance of thickness.
    let by_grade = measured()
        .filter(|value| value.required_grade.is_some())
        .count();
    if gear.requirement.is_some() && by_grade == 0 {
        text +=
            &format!("{by} gives none of these values a limit: the grade asked is not judged\n");
    }
    text
}
