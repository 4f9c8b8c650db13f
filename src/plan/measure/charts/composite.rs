//! Composite records of both flanks and of one.

use super::{Drawn, Evaluation};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::gear::measurement::composite::Record;
use crate::gear::measurement::estimate::Estimate;
use crate::gear::measurement::quantity::Quantity;
use crate::plan::measure::columns::Lever;
use crate::plan::measure::grading::Side;
use crate::scene::measured::Chart;

/// Samples recommended in a pitch for f_i′ to be told.
const DENSE: f64 = 10.0;

impl Evaluation<'_> {
    pub(super) fn double_flank(&mut self, chart: &Chart) -> Result<(), Errors> {
        let values = self.only(chart, &Lever { radius: None })?;
        let teeth = self.gear.gear.teeth as usize;
        let record = Record::new(&values, 1, teeth, true).map_err(|e| e.at(&chart.place))?;
        let split = record.split_by_order();
        let add = |value| Estimate::new(value, 2f64.sqrt(), chart.std);
        let (total, tooth) = (record.total(), record.by_pitch());
        self.add(
            Quantity::DoubleFlankTotal,
            Side::Both,
            "over a turn".into(),
            add(total),
        );
        self.add(
            Quantity::DoubleFlankTooth,
            Side::Both,
            "window slid".into(),
            add(tooth.sliding),
        );
        self.out.notes.push(format!(
            "double-flank: run-out (orders below z/2) {:.2} µm; in windows fixed to teeth f_i″ {:.2} µm",
            1e6 * split.long_range,
            1e6 * tooth.fixed
        ));
        self.sparse(&values, teeth);
        self.out.drawn.push(Drawn::Record {
            side: Side::Both,
            is_double: true,
            predicted: false,
            turns: 1,
            long: split.long,
            values,
        });
        Ok(())
    }

    fn sparse(&mut self, values: &[f64], pitches: usize) {
        let per_pitch = values.len() as f64 / pitches as f64;
        if per_pitch < DENSE {
            self.out.notes.push(format!(
                "{per_pitch:.1} samples a pitch: the values inside a pitch may be too small; {DENSE} or more tell them"
            ));
        }
    }

    pub(super) fn single_flank(
        &mut self,
        chart: &Chart,
        turns: usize,
        along_action: Option<bool>,
    ) -> Result<(), Errors> {
        let gear = &self.gear.gear;
        let lever = Lever {
            radius: Some(0.5 * gear.diameter()),
        };
        let (teeth, cosine) = (gear.teeth as usize, gear.transverse_angle().cos());
        for side in Side::ALL {
            let Some(mut column) = self.one(chart, side, &lever)? else {
                continue;
            };
            let scale = match (column.is_angle, along_action) {
                (true, _) | (false, Some(false)) => 1.0,
                (false, Some(true)) => 1.0 / cosine,
                (false, None) => {
                    let message = "it is not said along what this record's lengths lie";
                    return Err(Error::new(Code::MissingKey, message)
                        .at(&chart.place)
                        .hint("write on = \"line_of_action\" or on = \"reference_circle\"")
                        .into());
                }
            };
            column.values.iter_mut().for_each(|x| *x *= scale);
            self.single(
                side,
                column.values,
                turns,
                teeth,
                chart.std.map(|u| u * scale),
            )
            .map_err(|e| e.at(&chart.place))?;
        }
        Ok(())
    }

    fn single(
        &mut self,
        side: Side,
        values: Vec<f64>,
        turns: usize,
        teeth: usize,
        std: Option<f64>,
    ) -> Result<(), Error> {
        let record = Record::new(&values, turns, teeth, turns == 1)?;
        let (by_turn, tooth) = (record.by_turn(), record.by_pitch());
        let (split, averaged) = (record.split_by_order(), record.split_by_pitch_average());
        let add = |value| Estimate::new(value, 2f64.sqrt(), std);
        let over = match turns {
            1 => "over the turn".to_string(),
            n => format!("over a turn, worst of {n}"),
        };
        self.add(Quantity::SingleFlankTotal, side, over, add(by_turn.sliding));
        self.add(
            Quantity::SingleFlankTooth,
            side,
            "raw, window slid".into(),
            add(tooth.sliding),
        );
        let short = add(split.short_ranges.sliding);
        self.add(
            Quantity::SingleFlankShort,
            side,
            "orders from z/2, window slid".into(),
            short,
        );
        self.out.notes.push(
            format!(
                "single-flank {}: f_i′ {:.2} µm in windows fixed to teeth; long wave f_l′ {:.2} µm; by the mean over a pitch f_l′ {:.2} µm, f_k′ {:.2} µm",
                side.word(),
                1e6 * tooth.fixed,
                1e6 * split.long_range,
                1e6 * averaged.long_range,
                1e6 * averaged.short_ranges.sliding
            )
            .replace(" :", ":"),
        );
        self.sparse(&values, turns * teeth);
        self.out.drawn.push(Drawn::Record {
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
