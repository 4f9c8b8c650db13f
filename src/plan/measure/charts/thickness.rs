//! Readings of tooth thickness, span, chords and balls.

use super::{Evaluation, finite};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::gear::measurement::estimate::Estimate;
use crate::gear::measurement::quantity::Quantity;
use crate::gear::measurement::sizes::Way;
use crate::plan::measure::columns::Lever;
use crate::plan::measure::grading::Side;
use crate::scene::measured::Chart;

impl Evaluation<'_> {
    pub(super) fn tip(&self, chart: &Chart) -> Result<f64, Error> {
        self.gear.tip_diameter.ok_or_else(|| {
            Error::new(
                Code::MissingKey,
                "a chord is set from the tip, and [measured_gear] has no `tip_diameter`",
            )
            .at(&chart.place)
            .hint("write tip_diameter = \"78 mm\", as measured")
        })
    }

    pub(super) fn thickness(&mut self, chart: &Chart, way: Way, what: &str) -> Result<(), Errors> {
        let column = self.column_of_both(chart, &Lever { radius: None })?;
        finite(&column, chart)?;
        let gear = &self.gear.gear;
        let nominal = way.nominal(gear).map_err(|e| e.at(&chart.place))?;
        let told: Vec<Estimate> = column
            .values
            .iter()
            .map(|&reading| way.thickness(gear, reading, chart.std))
            .collect::<Result<_, Error>>()
            .map_err(|e| e.at(&chart.place))?;
        let by = |a: &usize, b: &usize| told[*a].value.total_cmp(&told[*b].value);
        let (thin, thick) = ((0..told.len()).min_by(by), (0..told.len()).max_by(by));
        if let (Some(thin), Some(thick)) = (thin, thick) {
            for (word, i) in [("thinnest", thin), ("thickest", thick)] {
                let found = format!("{what}, {word}, reading {}", i + 1);
                self.add(Quantity::Thickness, Side::Both, found, told[i]);
            }
            if matches!(way, Way::Span(_)) {
                let range = column.values[thick] - column.values[thin];
                let estimate = Estimate::new(range, 2f64.sqrt(), chart.std);
                self.add(
                    Quantity::SpanVariation,
                    Side::Both,
                    what.to_string(),
                    estimate,
                );
            }
        }
        let height = nominal.height.map_or(String::new(), |height| {
            format!(", set {:.4} mm below the tip", 1e3 * height)
        });
        self.out.notes.push(format!(
            "{what}: {:.4} mm without backlash{height}",
            1e3 * nominal.size
        ));
        Ok(())
    }
}
