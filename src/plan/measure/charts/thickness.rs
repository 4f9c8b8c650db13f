//! Readings of tooth thickness, span, chordal thickness and dimension over balls.

use super::{ChartEvaluation, check_finite};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::gear::measurement::deviation::GearDeviation;
use crate::gear::measurement::estimate::Estimate;
use crate::gear::measurement::tooth_thickness::ThicknessMethod;
use crate::plan::measure::chart_columns::AngleScale;
use crate::plan::measure::grading::GradedFlanks;
use crate::scene::measured_gear::MeasuredChart;

impl ChartEvaluation<'_> {
    pub(super) fn tip_radius(&self, chart: &MeasuredChart) -> Result<f64, Error> {
        self.gear.tip_diameter.ok_or_else(|| {
            Error::new(
                Code::MissingKey,
                "a chord is set from the tip, but [measured_gear] has no `tip_diameter`",
            )
            .with_span(&chart.span)
            .with_hint("write tip_diameter = \"78 mm\", as measured")
        })
    }

    pub(super) fn thickness(
        &mut self,
        chart: &MeasuredChart,
        method: ThicknessMethod,
        what: &str,
    ) -> Result<(), Errors> {
        let column = self.column_without_side(chart, &AngleScale { radius: None })?;
        check_finite(&column, chart)?;
        let gear = &self.gear.gear;
        let nominal = method.nominal(gear).map_err(|e| e.with_span(&chart.span))?;
        let told: Vec<Estimate> = column
            .values
            .iter()
            .map(|&reading| method.thickness_deviation(gear, reading, chart.std))
            .collect::<Result<_, Error>>()
            .map_err(|e| e.with_span(&chart.span))?;
        let by = |a: &usize, b: &usize| told[*a].value.total_cmp(&told[*b].value);
        let (thin, thick) = ((0..told.len()).min_by(by), (0..told.len()).max_by(by));
        if let (Some(thin), Some(thick)) = (thin, thick) {
            for (word, i) in [("thinnest", thin), ("thickest", thick)] {
                let found = format!("{what}, {word}, reading {}", i + 1);
                self.add(GearDeviation::Thickness, GradedFlanks::Both, found, told[i]);
            }
            if matches!(method, ThicknessMethod::Span(_)) {
                let range = column.values[thick] - column.values[thin];
                let estimate = Estimate::new(range, 2f64.sqrt(), chart.std);
                self.add(
                    GearDeviation::SpanVariation,
                    GradedFlanks::Both,
                    what.to_string(),
                    estimate,
                );
            }
        }
        let height = nominal.height.map_or(String::new(), |height| {
            format!(", set {:.4} mm below the tip", 1e3 * height)
        });
        self.results.notes.push(format!(
            "{what}: {:.4} mm without backlash{height}",
            1e3 * nominal.size
        ));
        Ok(())
    }
}
