//! Charts of pitch, runout and base pitch.

use super::{ChartEvaluation, ChartPlot, check_finite};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::gear::measurement::deviation::GearDeviation;
use crate::gear::measurement::estimate::Estimate;
use crate::gear::measurement::pitch::{
    LocatedDeviation, PitchDeviations, PitchMethod, default_span,
};
use crate::gear::measurement::runout::{self, Runout};
use crate::plan::measure::chart_columns::AngleScale;
use crate::plan::measure::grading::GradedFlanks;
use crate::scene::measured_gear::MeasuredChart;

impl ChartEvaluation<'_> {
    pub(super) fn pitch(
        &mut self,
        chart: &MeasuredChart,
        method: PitchMethod,
        k: Option<u32>,
    ) -> Result<(), Errors> {
        let teeth = self.gear.gear.teeth as usize;
        let lever = AngleScale {
            radius: Some(0.5 * self.gear.gear.reference_diameter()),
        };
        let k = k.map_or(default_span(teeth), |k| k as usize);
        if k >= teeth {
            let message = format!("`k` is {k} on a gear of {teeth} teeth");
            return Err(Error::new(Code::OutOfRange, message)
                .with_span(&chart.span)
                .with_hint("F_pk is taken over z/8 pitches where `k` is left out")
                .into());
        }
        let mut sides = Vec::new();
        for side in GradedFlanks::ALL {
            let Some(column) = self.optional_column(chart, side, &lever)? else {
                continue;
            };
            let values = self.sorted_by_tooth(chart, column.values)?;
            let pitches = PitchDeviations::new(&values, method, teeth, chart.std)
                .map_err(|e| e.with_span(&chart.span))?;
            let span = |result: &LocatedDeviation| match result.end - result.first {
                0 => "all alike".to_string(),
                1 => format!("pitch {}", result.first + 1),
                _ => format!(
                    "pitches {} to {}",
                    result.first + 1,
                    (result.end - 1) % teeth + 1
                ),
            };
            for (quantity, result) in [
                (GearDeviation::SinglePitch, pitches.single_pitch()),
                (GearDeviation::CumulativePitch, pitches.cumulative_total()),
                (
                    GearDeviation::OverPitches(k as u32),
                    pitches.span_deviation(k),
                ),
                (GearDeviation::AdjacentPitch, pitches.adjacent()),
            ] {
                self.add(quantity, side, span(&result), result.estimate);
            }
            if pitches.drift != 0.0 {
                let note = format!(
                    "{} drift of {:.2} µm between both readings of the first flank; removed linearly",
                    side.name(),
                    1e6 * pitches.drift
                );
                self.results.notes.push(note.trim_start().to_string());
            }
            self.results.plots.push(ChartPlot::Pitch {
                side,
                pitches: pitches.clone(),
            });
            sides.push((side, pitches));
        }
        let of =
            |wanted: GradedFlanks| sides.iter().find(|(side, _)| *side == wanted).map(|s| &s.1);
        if let (Some(left), Some(right)) = (of(GradedFlanks::Left), of(GradedFlanks::Right)) {
            let angle = self.gear.gear.transverse_pressure_angle();
            let result =
                runout::from_pitches(left, right, angle).map_err(|e| e.with_span(&chart.span))?;
            self.push_runout(result, "from both sides' pitch");
        }
        Ok(())
    }

    pub(super) fn push_runout(&mut self, runout: Runout, found: &'static str) {
        self.add(
            GearDeviation::Runout,
            GradedFlanks::Both,
            found.to_string(),
            runout.range,
        );
        let place = runout.phase.to_degrees().rem_euclid(360.0);
        let found_at = format!("{found}, highest at {place:.1} deg");
        self.add(
            GearDeviation::Eccentricity,
            GradedFlanks::Both,
            found_at,
            runout.eccentricity,
        );
        self.results.notes.push(format!(
            "run-out {found}: {:.2} µm without the eccentricity",
            1e6 * runout.remainder
        ));
        self.results.plots.push(ChartPlot::Runout {
            method_text: found,
            runout,
        });
    }

    pub(super) fn runout(&mut self, chart: &MeasuredChart) -> Result<(), Errors> {
        let readings = self.single_column(chart, &AngleScale { radius: None })?;
        let readings = self.sorted_by_tooth(chart, readings)?;
        let found = runout::from_ball(&readings, self.gear.gear.teeth as usize, chart.std)
            .map_err(|e| e.with_span(&chart.span))?;
        self.push_runout(found, "by ball");
        Ok(())
    }

    pub(super) fn base_pitch(&mut self, chart: &MeasuredChart) -> Result<(), Errors> {
        for side in GradedFlanks::ALL {
            for column in self.chart_files.columns_of_side(
                chart,
                side as usize,
                &AngleScale { radius: None },
            )? {
                check_finite(&column, chart)?;
                let size = |i: &usize| column.values[*i].abs();
                let worst = (0..column.values.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
                if let Some(i) = worst {
                    let estimate = Estimate::new(column.values[i], 1.0, chart.std);
                    self.add(
                        GearDeviation::BasePitch,
                        side,
                        format!("reading {}", i + 1),
                        estimate,
                    );
                }
            }
        }
        Ok(())
    }
}
