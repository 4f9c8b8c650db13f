//! Composite deviations: double-flank and single-flank records.

use super::{ChartEvaluation, ChartPlot};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::gear::measurement::deviation::GearDeviation;
use crate::gear::measurement::estimate::Estimate;
use crate::plan::measure::chart_columns::AngleScale;
use crate::plan::measure::grading::GradedFlanks;
use crate::scene::measured_gear::MeasuredChart;
use crate::te_record::single_flank::SingleFlankRecord;

/// Samples recommended in a pitch for the evaluation of f_i′.
const MIN_SAMPLES_PER_PITCH: f64 = 10.0;

impl ChartEvaluation<'_> {
    pub(super) fn double_flank(&mut self, chart: &MeasuredChart) -> Result<(), Errors> {
        let values = self.single_column(chart, &AngleScale { radius: None })?;
        let teeth = self.gear.gear.teeth as usize;
        let record = SingleFlankRecord::new(&values, 1, teeth, true)
            .map_err(|e| e.with_span(&chart.span))?;
        let split = record.split_by_order();
        let add = |value| Estimate::new(value, 2f64.sqrt(), chart.std);
        let (total, tooth) = (record.total_deviation(), record.ranges_per_pitch());
        self.add(
            GearDeviation::DoubleFlankTotal,
            GradedFlanks::Both,
            "over a turn".into(),
            add(total),
        );
        self.add(
            GearDeviation::DoubleFlankTooth,
            GradedFlanks::Both,
            "sliding window".into(),
            add(tooth.sliding),
        );
        self.results.notes.push(format!(
            "double-flank: run-out (orders below z/2) {:.2} µm; in windows fixed to teeth f_i″ {:.2} µm",
            1e6 * split.long_range,
            1e6 * tooth.fixed
        ));
        self.warn_sparse(&values, teeth);
        self.results.plots.push(ChartPlot::Record {
            side: GradedFlanks::Both,
            is_double: true,
            predicted: false,
            turns: 1,
            long: split.long,
            values,
        });
        Ok(())
    }

    fn warn_sparse(&mut self, values: &[f64], pitches: usize) {
        let per_pitch = values.len() as f64 / pitches as f64;
        if per_pitch < MIN_SAMPLES_PER_PITCH {
            self.results.notes.push(format!(
                "{per_pitch:.1} samples per pitch (minimum {MIN_SAMPLES_PER_PITCH}): the values inside a pitch may be too small"
            ));
        }
    }

    pub(super) fn single_flank(
        &mut self,
        chart: &MeasuredChart,
        turns: usize,
        along_action: Option<bool>,
    ) -> Result<(), Errors> {
        let gear = &self.gear.gear;
        let lever = AngleScale {
            radius: Some(0.5 * gear.reference_diameter()),
        };
        let (teeth, cosine) = (gear.teeth as usize, gear.transverse_pressure_angle().cos());
        for side in GradedFlanks::ALL {
            let Some(mut column) = self.optional_column(chart, side, &lever)? else {
                continue;
            };
            let scale = match (column.is_angle, along_action) {
                (true, _) | (false, Some(false)) => 1.0,
                (false, Some(true)) => 1.0 / cosine,
                (false, None) => {
                    let message = "the abscissa of this record's lengths is not stated";
                    return Err(Error::new(Code::MissingKey, message)
                        .with_span(&chart.span)
                        .with_hint("write on = \"line_of_action\" or on = \"reference_circle\"")
                        .into());
                }
            };
            column.values.iter_mut().for_each(|x| *x *= scale);
            self.single_flank_side(
                side,
                column.values,
                turns,
                teeth,
                chart.std.map(|u| u * scale),
            )
            .map_err(|e| e.with_span(&chart.span))?;
        }
        Ok(())
    }

    fn single_flank_side(
        &mut self,
        side: GradedFlanks,
        values: Vec<f64>,
        turns: usize,
        teeth: usize,
        std: Option<f64>,
    ) -> Result<(), Error> {
        let record = SingleFlankRecord::new(&values, turns, teeth, turns == 1)?;
        let (by_turn, tooth) = (record.ranges_per_rev(), record.ranges_per_pitch());
        let (split, averaged) = (record.split_by_order(), record.split_by_pitch_average());
        let add = |value| Estimate::new(value, 2f64.sqrt(), std);
        let over = match turns {
            1 => "over the turn".to_string(),
            n => format!("over a turn, worst of {n}"),
        };
        self.add(
            GearDeviation::SingleFlankTotal,
            side,
            over,
            add(by_turn.sliding),
        );
        self.add(
            GearDeviation::SingleFlankTooth,
            side,
            "unfiltered, sliding window".into(),
            add(tooth.sliding),
        );
        let short = add(split.short_ranges.sliding);
        self.add(
            GearDeviation::SingleFlankShort,
            side,
            "orders from z/2, sliding window".into(),
            short,
        );
        self.results.notes.push(
            format!(
                "single-flank {}: f_i′ {:.2} µm in windows fixed to teeth; long wave f_l′ {:.2} µm; by the mean over a pitch f_l′ {:.2} µm, f_k′ {:.2} µm",
                side.name(),
                1e6 * tooth.fixed,
                1e6 * split.long_range,
                1e6 * averaged.long_range,
                1e6 * averaged.short_ranges.sliding
            )
            .replace(" :", ":"),
        );
        self.warn_sparse(&values, turns * teeth);
        self.results.plots.push(ChartPlot::Record {
            side,
            is_double: false,
            predicted: false,
            turns,
            long: split.long,
            values,
        });
        Ok(())
    }
}
