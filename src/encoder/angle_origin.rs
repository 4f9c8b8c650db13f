//! Origin of the angles of a record, taken from index pulses.

use std::f64::consts::TAU;

use super::flank::FlankEvaluation;
use super::gear_train::GearTrain;
use super::index_pulses::IndexEvaluation;
use super::survey::DirectionRun;

/// Origin of the angles of both shafts.
pub struct AngleOrigin {
    /// Origin of the output angle, turns as the ratio makes them of the input's readings; 0 without an index.
    pub output_origin: f64,
    has_output: bool,
    /// Origin of the input angle, turns of the output from there.
    pub input: Option<f64>,
}

impl AngleOrigin {
    /// The output's mark in the direction with more turns.
    pub fn new(
        index: &[Option<IndexEvaluation>; 2],
        runs: &[DirectionRun],
        ratio: f64,
    ) -> AngleOrigin {
        let reach = |forward: bool| -> f64 {
            let of_way = runs.iter().filter(|run| run.forward == forward);
            of_way.map(DirectionRun::travel).sum()
        };
        let forward = reach(true) >= reach(false);
        let output = index[1].as_ref();
        let zero = output.and_then(|o| o.output_angle(ratio, forward));
        AngleOrigin {
            output_origin: zero.unwrap_or(0.0),
            has_output: zero.is_some(),
            input: (index[0].as_ref()).map(|i| i.mark_angle * ratio - zero.unwrap_or(0.0)),
        }
    }

    /// Phases over the angle from the mark of the shaft that an order repeats with.
    pub fn set_mark_phases(&self, flank: &mut FlankEvaluation, teeth: &GearTrain) {
        let ratio = teeth.ratio();
        for line in &mut flank.lines {
            let order = &line.order.fraction;
            let with_input = self.input.filter(|_| (order * &ratio).is_integer());
            line.mark_phase = match with_input {
                _ if self.has_output && order.is_integer() => Some((line.phase, "output")),
                Some(at) => Some((line.phase + order.to_f64() * at * TAU, "input")),
                None => None,
            };
        }
    }
}
