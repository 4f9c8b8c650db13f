//! Measured gears as tables for a terminal: today's name next to the older one, value, limit, grades, marks.

use super::number_format::INTERVAL_FOOTNOTE;
use super::table::{Table, or_dash};
use crate::gear::measurement::deviation::GearDeviation;
use crate::gear::measurement::iso1328::Edition;
use crate::numeric::statistics::Z_95;
use crate::plan::measure::grading::{AchievedGrade, GradedValue};
use crate::plan::measure::run::MeasurementResult;
use crate::scene::measured_gear::{AccuracyRequirement, MeasuredGear};

/// The standard's name.
pub fn standard(requirement: &AccuracyRequirement) -> &'static str {
    requirement.edition.map_or("JB 179-60", Edition::name)
}

/// Whether limits come from the table of somebody's own.
fn uses_limit_table(gear: &MeasuredGear) -> bool {
    gear.requirement
        .as_ref()
        .is_some_and(|d| d.edition.is_none())
}

/// Grade reached by a row under the requested edition; by the newer edition by default.
pub fn required_grade_result(gear: &MeasuredGear, row: &GradedValue) -> Option<AchievedGrade> {
    match gear.requirement.as_ref().and_then(|d| d.edition) {
        Some(Edition::Y1995) => row.achieved[0],
        _ if uses_limit_table(gear) => row.table_grade,
        _ => row.achieved[1],
    }
}

/// Gear, requirements, and all values.
pub fn text(gear: &MeasuredGear, result: &MeasurementResult) -> String {
    let mut text = head(gear);
    let (measured, predicted): (Vec<&GradedValue>, Vec<&GradedValue>) =
        result.rows.iter().partition(|row| !row.predicted);
    text += "\n";
    text += &table(gear, &measured);
    if !predicted.is_empty() {
        text += "\nderived from the other charts\n";
        text += &table(gear, &predicted);
    }
    if !result.notes.is_empty() {
        text += "\n";
        for note in &result.notes {
            text += &(crate::base::text::wrap_lines(note) + "\n");
        }
    }
    text += "\n";
    if result.rows.iter().any(|row| row.estimate.std.is_some()) {
        text += INTERVAL_FOOTNOTE;
    }
    text + &verdict(gear, result)
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
    text += &format!(", d {} mm", short(1e3 * involute.reference_diameter()));
    if let Some(width) = gear.face_width {
        text += &format!(", b {} mm", short(1e3 * width));
    }
    text += "\n";
    match &gear.requirement {
        Some(requirement) => {
            text += &format!(
                "required: {}, {}\n",
                requirement.accuracy.describe(),
                standard(requirement)
            );
        }
        None => text += "no grade is required\n",
    }
    text
}

/// Without the zeros no digit needs.
fn short(x: f64) -> String {
    super::number_format::four_digits((x * 1e6).round() / 1e6)
}

fn table(gear: &MeasuredGear, rows: &[&GradedValue]) -> String {
    let by_table = rows.iter().any(|row| row.table_grade.is_some());
    let mut table =
        Table::new("||JB 179-60|flank|value [µm]|± [µm]|limit [µm]|grade [required]|:1995|:2013")
            .columns_if(by_table, "table")
            .columns("|")
            .words(&[0, 1, 2, 3]);
    for row in rows {
        let mut cells = vec![
            symbol(row.quantity),
            row.quantity.name().to_string(),
            row.quantity
                .jb179_name()
                .map_or(String::new(), |old| old.symbol.to_string()),
            row.side.name().to_string(),
            micro(row.estimate.value),
            or_dash(row.estimate.std, |u| micro(Z_95 * u)),
            or_dash(limit(row), |text| text),
            or_dash(row.required_grade, |grade| grade.to_string()),
            grade(row.achieved[0]),
            grade(row.achieved[1]),
        ];
        if by_table {
            cells.push(grade(row.table_grade));
        }
        cells.push(mark(row).to_string());
        cells.push(match row.limiting {
            true => format!(
                "{}  ◄ determines the grade, {}",
                row.location,
                grade(required_grade_result(gear, row))
            ),
            false => row.location.clone(),
        });
        table.row(cells);
    }
    table.text()
}

fn symbol(quantity: GearDeviation) -> String {
    match quantity {
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

fn limit(row: &GradedValue) -> Option<String> {
    let (low, high) = row.limits?;
    let one =
        |x: f64| super::number_format::four_digits((1e7 * x).round() / 10.0).replace('-', "−");
    Some(match low == -high {
        true => one(high),
        false => format!("{} to {}", one(low), one(high)),
    })
}

fn grade(reached: Option<AchievedGrade>) -> String {
    match reached {
        Some(AchievedGrade::Grade(grade)) => grade.to_string(),
        Some(AchievedGrade::Beyond(coarsest)) => format!(">{coarsest}"),
        None => "–".to_string(),
    }
}

fn mark(row: &GradedValue) -> &'static str {
    match (row.is_within_limits(), row.is_inconclusive()) {
        (None, _) => "",
        (Some(true), false) => "in",
        (Some(true), true) => "in?",
        (Some(false), false) => "OUT",
        (Some(false), true) => "OUT?",
    }
}

fn verdict(gear: &MeasuredGear, result: &MeasurementResult) -> String {
    let measured = || result.rows.iter().filter(|row| !row.predicted);
    let coarsest = measured()
        .filter_map(|row| required_grade_result(gear, row))
        .max();
    let by = match &gear.requirement {
        Some(requirement) => standard(requirement),
        None => "ISO 1328-1:2013",
    };
    let mut text = match coarsest {
        Some(AchievedGrade::Grade(grade)) => {
            format!("reached: grade {grade}, for values with a tolerance in {by}\n")
        }
        Some(AchievedGrade::Beyond(coarsest)) => {
            format!("coarser than grade {coarsest}, the coarsest of {by}\n")
        }
        None => String::new(),
    };
    let out = measured().filter(|row| row.is_within_limits() == Some(false));
    let out: Vec<String> = out
        .map(|row| {
            format!("{} {}", symbol(row.quantity), row.side.name())
                .trim_end()
                .to_string()
        })
        .collect();
    let all = measured().count();
    let held = measured().filter(|row| row.limits.is_some()).count();
    text += &match (held, out.is_empty()) {
        (0, _) => "no value has a limit\n".to_string(),
        (_, true) => format!("{held} of {all} values have a limit, all within it\n"),
        (_, false) => format!(
            "OUT of tolerance: {} ({held} of {all} values have a limit)\n",
            out.join(", ")
        ),
    };
    // Of what was asked by a standard, not of an allowance of thickness.
    let by_grade = measured()
        .filter(|row| row.required_grade.is_some())
        .count();
    if gear.requirement.is_some() && by_grade == 0 {
        text +=
            &format!("{by} has no limit for these values: the required grade is not assessed\n");
    }
    text
}
