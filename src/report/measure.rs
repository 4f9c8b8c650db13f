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
        "deviations": result.values.iter().map(|value| deviation(gear, value)).collect::<Vec<_>>(),
        "notes": result.notes,
        "stages": super::json::stages(steps),
        "warnings": super::json::warnings(&result.diagnostics),
    })
}

fn requirement_json(requirement: &AccuracyRequirement) -> Value {
    let accuracy = &requirement.grades;
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

/// The grade a row reached by what was asked; by the newer edition where nothing was.
pub fn required_grade_result(gear: &MeasuredGear, value: &GradedValue) -> Option<AchievedGrade> {
    match gear.requirement.as_ref().and_then(|d| d.edition) {
        Some(Edition::Y1995) => value.achieved[0],
        _ if uses_limit_table(gear) => value.reached_by_table,
        _ => value.achieved[1],
    }
}

fn deviation(gear: &MeasuredGear, value: &GradedValue) -> Value {
    let micro = |x: f64| 1e6 * x;
    let old = value.deviation.jb179_name();
    let grade = |achieved_grade: Option<AchievedGrade>| match achieved_grade {
        Some(AchievedGrade::Grade(grade)) => json!(grade),
        _ => Value::Null,
    };
    let over = match value.deviation {
        GearDeviation::OverPitches(k) => Some(k),
        _ => None,
    };
    json!({
        "name": value.deviation.key(),
        "title": value.deviation.name(),
        "old_name": old.map(|old| old.symbol),
        "over_pitches": over,
        "side": value.side.name(),
        "found": value.location,
        "predicted": value.predicted,
        "value_um": micro(value.estimate.value),
        "std_um": value.estimate.std.map(micro),
        "lower_limit_um": value.limits.map(|limits| micro(limits.0)),
        "upper_limit_um": value.limits.map(|limits| micro(limits.1)),
        "grade_asked": value.required_grade,
        "grade": grade(required_grade_result(gear, value)),
        "grade_1995": grade(value.achieved[0]),
        "grade_2013": grade(value.achieved[1]),
        "coarser_than_all_grades": matches!(required_grade_result(gear, value), Some(AchievedGrade::Beyond(_))),
        "within": value.is_within_limits(),
        "in_doubt": value.is_inconclusive(),
        "limiting": value.limiting,
    })
}

/// One line a value.
pub fn csv(gear: &MeasuredGear, result: &MeasurementResult) -> String {
    let mut text = String::from(
        "name,old_name,side,found,predicted,value [µm],std [µm],lower_limit [µm],upper_limit [µm],grade_asked,grade,within,limiting\n",
    );
    let number = |x: Option<f64>| x.map_or(String::new(), |x| format!("{}", 1e6 * x));
    for graded_value in &result.values {
        let grade = match required_grade_result(gear, graded_value) {
            Some(AchievedGrade::Grade(grade)) => grade.to_string(),
            Some(AchievedGrade::Beyond(coarsest)) => format!(">{coarsest}"),
            None => String::new(),
        };
        let cells = [
            graded_value.deviation.key().to_string(),
            graded_value
                .deviation
                .jb179_name()
                .map_or("", |old| old.symbol)
                .to_string(),
            graded_value.side.name().to_string(),
            csv_field(&graded_value.location),
            graded_value.predicted.to_string(),
            number(Some(graded_value.estimate.value)),
            number(graded_value.estimate.std),
            number(graded_value.limits.map(|l| l.0)),
            number(graded_value.limits.map(|l| l.1)),
            graded_value
                .required_grade
                .map_or(String::new(), |grade| grade.to_string()),
            grade,
            graded_value
                .is_within_limits()
                .map_or(String::new(), |w| w.to_string()),
            graded_value.limiting.to_string(),
        ];
        text += &(cells.join(",") + "\n");
    }
    text
}
