//! Charts of pitch, run-out and base pitch.

use super::{Drawn, Evaluation, finite};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::gear::measurement::estimate::Estimate;
use crate::gear::measurement::pitch::{Found, Method, Pitches, usual_reach};
use crate::gear::measurement::quantity::Quantity;
use crate::gear::measurement::runout::{self, Runout};
use crate::plan::measure::columns::Lever;
use crate::plan::measure::grading::Side;
use crate::scene::measured::Chart;

impl Evaluation<'_> {
    pub(super) fn pitch(
        &mut self,
        chart: &Chart,
        method: Method,
        k: Option<u32>,
    ) -> Result<(), Errors> {
        let teeth = self.gear.gear.teeth as usize;
        let lever = Lever {
            radius: Some(0.5 * self.gear.gear.diameter()),
        };
        let k = k.map_or(usual_reach(teeth), |k| k as usize);
        if k >= teeth {
            let message = format!("`k` is {k} on a gear of {teeth} teeth");
            return Err(Error::new(Code::OutOfRange, message)
                .at(&chart.place)
                .hint("F_pk is taken over z/8 pitches where `k` is left out")
                .into());
        }
        let mut sides = Vec::new();
        for side in Side::ALL {
            let Some(column) = self.one(chart, side, &lever)? else {
                continue;
            };
            let values = self.in_order_of_teeth(chart, column.values)?;
            let pitches =
                Pitches::new(&values, method, teeth, chart.std).map_err(|e| e.at(&chart.place))?;
            let span = |found: &Found| match found.end - found.first {
                0 => "all alike".to_string(),
                1 => format!("pitch {}", found.first + 1),
                _ => format!(
                    "pitches {} to {}",
                    found.first + 1,
                    (found.end - 1) % teeth + 1
                ),
            };
            for (quantity, found) in [
                (Quantity::SinglePitch, pitches.single()),
                (Quantity::CumulativePitch, pitches.total()),
                (Quantity::OverPitches(k as u32), pitches.over(k)),
                (Quantity::AdjacentPitch, pitches.adjacent()),
            ] {
                self.add(quantity, side, span(&found), found.estimate);
            }
            if pitches.drift != 0.0 {
                let note = format!(
                    "{} the first flank had drifted by {:.2} µm when it was read again; taken off evenly",
                    side.word(),
                    1e6 * pitches.drift
                );
                self.out.notes.push(note.trim_start().to_string());
            }
            self.out.drawn.push(Drawn::Pitch {
                side,
                pitches: pitches.clone(),
            });
            sides.push((side, pitches));
        }
        let of = |wanted: Side| sides.iter().find(|(side, _)| *side == wanted).map(|s| &s.1);
        if let (Some(left), Some(right)) = (of(Side::Left), of(Side::Right)) {
            let angle = self.gear.gear.transverse_angle();
            let found = runout::from_pitches(left, right, angle).map_err(|e| e.at(&chart.place))?;
            self.run_out(found, "from both sides' pitch");
        }
        Ok(())
    }

    pub(super) fn run_out(&mut self, runout: Runout, found: &'static str) {
        self.add(
            Quantity::Runout,
            Side::Both,
            found.to_string(),
            runout.range,
        );
        let place = runout.phase.to_degrees().rem_euclid(360.0);
        let found_at = format!("{found}, highest at {place:.1} deg");
        self.add(
            Quantity::Eccentricity,
            Side::Both,
            found_at,
            runout.eccentricity,
        );
        self.out.notes.push(format!(
            "run-out {found}: {:.2} µm are left without the eccentricity",
            1e6 * runout.remainder
        ));
        self.out.drawn.push(Drawn::Runout { found, runout });
    }

    pub(super) fn runout(&mut self, chart: &Chart) -> Result<(), Errors> {
        let readings = self.only(chart, &Lever { radius: None })?;
        let readings = self.in_order_of_teeth(chart, readings)?;
        let found = runout::from_ball(&readings, self.gear.gear.teeth as usize, chart.std)
            .map_err(|e| e.at(&chart.place))?;
        self.run_out(found, "by ball");
        Ok(())
    }

    pub(super) fn base_pitch(&mut self, chart: &Chart) -> Result<(), Errors> {
        for side in Side::ALL {
            for column in self
                .files
                .side(chart, side as usize, &Lever { radius: None })?
            {
                finite(&column, chart)?;
                let size = |i: &usize| column.values[*i].abs();
                let worst = (0..column.values.len()).max_by(|a, b| size(a).total_cmp(&size(b)));
                if let Some(i) = worst {
                    let estimate = Estimate::new(column.values[i], 1.0, chart.std);
                    self.add(
                        Quantity::BasePitch,
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
