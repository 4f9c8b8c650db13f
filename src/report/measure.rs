//! Measured gears as JSON and CSV.

use serde_json::{Value, json};

use super::modes_csv::csv_field;
use crate::gear::measurement::deviation::GearDeviation;
use crate::gear::measurement::iso1328::Edition;
use crate::plan::measure::grading::{AchievedGrade, GradedValue};
use crate::plan::measure::run::MeasurementResult;
use crate::plan::stages::StageDecision;
use crate::scene::measured_gear::{AccuracyRequirement, MeasuredGear};

/// The document.
pub fn json(gear: &MeasuredGear, result: &MeasurementResult) -> Value {
    let ran = result.plan.iter();
    let ran = ran.filter(|(_, decision)| matches!(decision, StageDecision::Runs(_)));
    let trace: Vec<&str> = ran.map(|(name, _)| *name).collect();
    let steps = result.plan.iter().map(|(name, decision)| (*name, decision));
    json!({
        "geardyn": super::json::header(&result.sources, &trace),
        "title": gear.title,
        "asked": gear.requirement.as_ref().map(requirement_json),
        "within": result.is_within_limits(),
        "deviations": result.rows.iter().map(|row| deviation(gear, row)).collect::<Vec<_>>(),
        "notes": result.notes,
        "stages": super::json::stages(steps),
        "warnings": super::json::warnings(&result.diagnostics),
    })
}

fn requirement_json(requirement: &AccuracyRequirement) -> Value {
    let accuracy = &requirement.accuracy;
    json!({
        "standard": standard(requirement),
        "motion": accuracy.motion,
        "smoothness": accuracy.smoothness,
        "contact": accuracy.contact,
        "meaning": accuracy.describe(),
    })
}

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
        _ if uses_limit_table(gear) => row.reached_by_table,
        _ => row.achieved[1],
    }
}

fn deviation(gear: &MeasuredGear, row: &GradedValue) -> Value {
    let micro = |x: f64| 1e6 * x;
    let old = row.quantity.jb179_name();
    let grade = |reached: Option<AchievedGrade>| match reached {
        Some(AchievedGrade::Grade(grade)) => json!(grade),
        _ => Value::Null,
    };
    let over = match row.quantity {
        GearDeviation::OverPitches(k) => Some(k),
        _ => None,
    };
    json!({
        "name": row.quantity.key(),
        "title": row.quantity.name(),
        "old_name": old.map(|old| old.symbol),
        "over_pitches": over,
        "side": row.side.name(),
        "found": row.location,
        "predicted": row.predicted,
        "value_um": micro(row.estimate.value),
        "std_um": row.estimate.std.map(micro),
        "lower_limit_um": row.limits.map(|limits| micro(limits.0)),
        "upper_limit_um": row.limits.map(|limits| micro(limits.1)),
        "grade_asked": row.required_grade,
        "grade": grade(required_grade_result(gear, row)),
        "grade_1995": grade(row.achieved[0]),
        "grade_2013": grade(row.achieved[1]),
        "coarser_than_all_grades": matches!(required_grade_result(gear, row), Some(AchievedGrade::Beyond(_))),
        "within": row.is_within_limits(),
        "in_doubt": row.is_inconclusive(),
        "limiting": row.limiting,
    })
}

/// One line a value.
pub fn csv(gear: &MeasuredGear, result: &MeasurementResult) -> String {
    let mut text = String::from(
        "name,old_name,side,found,predicted,value [µm],std [µm],lower_limit [µm],upper_limit [µm],grade_asked,grade,within,limiting\n",
    );
    let number = |x: Option<f64>| x.map_or(String::new(), |x| format!("{}", 1e6 * x));
    for row in &result.rows {
        let grade = match required_grade_result(gear, row) {
            Some(AchievedGrade::Grade(grade)) => grade.to_string(),
            Some(AchievedGrade::Beyond(coarsest)) => format!(">{coarsest}"),
            None => String::new(),
        };
        let cells = [
            row.quantity.key().to_string(),
            row.quantity
                .jb179_name()
                .map_or("", |old| old.symbol)
                .to_string(),
            row.side.name().to_string(),
            csv_field(&row.location),
            row.predicted.to_string(),
            number(Some(row.estimate.value)),
            number(row.estimate.std),
            number(row.limits.map(|l| l.0)),
            number(row.limits.map(|l| l.1)),
            row.required_grade
                .map_or(String::new(), |grade| grade.to_string()),
            grade,
            row.is_within_limits()
                .map_or(String::new(), |w| w.to_string()),
            row.limiting.to_string(),
        ];
        text += &(cells.join(",") + "\n");
    }
    text
}
