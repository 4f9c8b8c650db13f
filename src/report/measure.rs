//! Measured gears: document, table of deviations, charts.

use serde_json::{Value, json};

use super::figure::Figure;
use super::measure_table::{self, required_grade_result, standard};
use super::presentation::{Presentation, Provenance};
use super::table::{Table, decimal, or_blank};
use super::{measure_plot, measure_polar_plot};
use crate::base::error::Error;
use crate::gear::measurement::deviation::GearDeviation;
use crate::plan::measure::grading::{AchievedGrade, GradedValue};
use crate::plan::measure::run::MeasurementResult;
use crate::scene::measured_gear::{AccuracyRequirement, MeasuredGear};

/// A measured gear with its graded deviations.
pub struct MeasurementReport<'a> {
    /// The gear.
    pub gear: &'a MeasuredGear,
    /// The deviations.
    pub result: MeasurementResult,
}

impl Presentation for MeasurementReport<'_> {
    fn provenance(&self) -> Provenance<'_> {
        let result = &self.result;
        Provenance::of_plan(&result.sources, &result.plan, &result.diagnostics)
    }

    fn body(&self) -> Result<Value, Error> {
        let (gear, result) = (self.gear, &self.result);
        Ok(json!({
            "title": gear.title,
            "required": gear.requirement.as_ref().map(requirement_json),
            "within": result.is_within_limits(),
            "deviations": result.rows.iter().map(|row| deviation(gear, row)).collect::<Vec<_>>(),
            "notes": result.notes,
        }))
    }

    fn text(&self) -> String {
        measure_table::text(self.gear, &self.result)
    }

    fn table(&self) -> Table<'_> {
        let (gear, result) = (self.gear, &self.result);
        let mut table = Table::new(
            "name|old_name|side|location|predicted|value [µm]|std [µm]|lower_limit [µm]|upper_limit [µm]|grade_requested|grade|within|limiting",
        );
        let micro = |x: Option<f64>| or_blank(x, |x| decimal(1e6 * x));
        for row in &result.rows {
            let old = row.quantity.jb179_name().map_or("", |old| old.symbol);
            let grade = or_blank(required_grade_result(gear, row), |reached| match reached {
                AchievedGrade::Grade(grade) => grade.to_string(),
                AchievedGrade::Beyond(coarsest) => format!(">{coarsest}"),
            });
            table.row([
                row.quantity.key().to_string(),
                old.to_string(),
                row.side.name().to_string(),
                row.location.clone(),
                row.predicted.to_string(),
                micro(Some(row.estimate.value)),
                micro(row.estimate.std),
                micro(row.limits.map(|l| l.0)),
                micro(row.limits.map(|l| l.1)),
                or_blank(row.required_grade, |grade| grade.to_string()),
                grade,
                or_blank(row.is_within_limits(), |within| within.to_string()),
                row.limiting.to_string(),
            ]);
        }
        table
    }

    fn figures(&self) -> Result<Vec<Figure>, Error> {
        let (title, plots) = (&self.gear.title, &self.result.plots);
        let unrolled = measure_plot::draw_charts(title, plots).map(Figure::first);
        let polar = measure_polar_plot::draw_polar(title, plots);
        let polar = polar.map(|plot| Figure::new("polar", plot));
        Ok(unrolled.into_iter().chain(polar).collect())
    }

    fn figure_notes(&self) -> String {
        match self.result.plots.is_empty() {
            true => "no plot: spans, chords, balls and base pitches are single values\n".into(),
            false => String::new(),
        }
    }

    fn exit_code(&self) -> u8 {
        u8::from(self.result.is_within_limits() == Some(false))
    }
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
        "location": row.location,
        "predicted": row.predicted,
        "value_um": micro(row.estimate.value),
        "std_um": row.estimate.std.map(micro),
        "lower_limit_um": row.limits.map(|limits| micro(limits.0)),
        "upper_limit_um": row.limits.map(|limits| micro(limits.1)),
        "grade_requested": row.required_grade,
        "grade": grade(required_grade_result(gear, row)),
        "grade_1995": grade(row.achieved[0]),
        "grade_2013": grade(row.achieved[1]),
        "coarser_than_all_grades": matches!(required_grade_result(gear, row), Some(AchievedGrade::Beyond(_))),
        "within": row.is_within_limits(),
        "is_inconclusive": row.is_inconclusive(),
        "limiting": row.limiting,
    })
}
