//! Measured gears as JSON and CSV.

use serde_json::{Value, json};

use super::csv::quoted;
use crate::gear::measurement::iso::Edition;
use crate::gear::measurement::quantity::Quantity;
use crate::plan::measure::grading::{Reached, Row};
use crate::plan::measure::run::Answer;
use crate::plan::stages::Verdict;
use crate::scene::measured::{Demand, MeasuredGear};

/// The document.
pub fn json(gear: &MeasuredGear, answer: &Answer) -> Value {
    let ran = answer.plan.iter();
    let ran = ran.filter(|(_, verdict)| matches!(verdict, Verdict::Runs(_)));
    let trace: Vec<&str> = ran.map(|(name, _)| *name).collect();
    let steps = answer.plan.iter().map(|(name, verdict)| (*name, verdict));
    json!({
        "geardyn": super::json::header(&answer.sources, &trace),
        "title": gear.title,
        "asked": gear.demand.as_ref().map(asked),
        "within": answer.within(),
        "deviations": answer.rows.iter().map(|row| deviation(gear, row)).collect::<Vec<_>>(),
        "notes": answer.notes,
        "stages": super::json::stages(steps),
        "warnings": super::json::warnings(&answer.warnings),
    })
}

fn asked(demand: &Demand) -> Value {
    let accuracy = &demand.accuracy;
    json!({
        "standard": standard(demand),
        "motion": accuracy.motion,
        "smoothness": accuracy.smoothness,
        "contact": accuracy.contact,
        "meaning": accuracy.explained(),
    })
}

/// The standard's name.
pub fn standard(demand: &Demand) -> &'static str {
    demand.edition.map_or("JB 179-60", Edition::name)
}

/// Whether limits come from the table of somebody's own.
fn by_table(gear: &MeasuredGear) -> bool {
    gear.demand.as_ref().is_some_and(|d| d.edition.is_none())
}

/// The grade a row reached by what was asked; by the newer edition where nothing was.
pub fn judged(gear: &MeasuredGear, row: &Row) -> Option<Reached> {
    match gear.demand.as_ref().and_then(|d| d.edition) {
        Some(Edition::Y1995) => row.reached[0],
        _ if by_table(gear) => row.reached_by_table,
        _ => row.reached[1],
    }
}

fn deviation(gear: &MeasuredGear, row: &Row) -> Value {
    let micro = |x: f64| 1e6 * x;
    let old = row.quantity.old();
    let grade = |reached: Option<Reached>| match reached {
        Some(Reached::Grade(grade)) => json!(grade),
        _ => Value::Null,
    };
    let over = match row.quantity {
        Quantity::OverPitches(k) => Some(k),
        _ => None,
    };
    json!({
        "name": row.quantity.key(),
        "title": row.quantity.name(),
        "old_name": old.map(|old| old.symbol),
        "over_pitches": over,
        "side": row.side.word(),
        "found": row.found,
        "predicted": row.predicted,
        "value_um": micro(row.estimate.value),
        "std_um": row.estimate.std.map(micro),
        "lower_limit_um": row.limits.map(|limits| micro(limits.0)),
        "upper_limit_um": row.limits.map(|limits| micro(limits.1)),
        "grade_asked": row.asked,
        "grade": grade(judged(gear, row)),
        "grade_1995": grade(row.reached[0]),
        "grade_2013": grade(row.reached[1]),
        "coarser_than_all_grades": matches!(judged(gear, row), Some(Reached::Beyond(_))),
        "within": row.within(),
        "in_doubt": row.in_doubt(),
        "limiting": row.limiting,
    })
}

/// One line a value.
pub fn csv(gear: &MeasuredGear, answer: &Answer) -> String {
    let mut text = String::from(
        "name,old_name,side,found,predicted,value [µm],std [µm],lower_limit [µm],upper_limit [µm],grade_asked,grade,within,limiting\n",
    );
    let number = |x: Option<f64>| x.map_or(String::new(), |x| format!("{}", 1e6 * x));
    for row in &answer.rows {
        let grade = match judged(gear, row) {
            Some(Reached::Grade(grade)) => grade.to_string(),
            Some(Reached::Beyond(coarsest)) => format!(">{coarsest}"),
            None => String::new(),
        };
        let cells = [
            row.quantity.key().to_string(),
            row.quantity.old().map_or("", |old| old.symbol).to_string(),
            row.side.word().to_string(),
            quoted(&row.found),
            row.predicted.to_string(),
            number(Some(row.estimate.value)),
            number(row.estimate.std),
            number(row.limits.map(|l| l.0)),
            number(row.limits.map(|l| l.1)),
            row.asked.map_or(String::new(), |grade| grade.to_string()),
            grade,
            row.within().map_or(String::new(), |w| w.to_string()),
            row.limiting.to_string(),
        ];
        text += &(cells.join(",") + "\n");
    }
    text
}
