//! Output speed by pitch: pitch angle over its passage time.

use std::f64::consts::TAU;

/// Speed over a record.
#[derive(Debug, Clone)]
pub struct SpeedTrace {
    /// Middle of each pitch, turns of the output.
    pub turns: Vec<f64>,
    /// Speed of the output over that pitch, rad/s; negative where it turned back.
    pub speed: Vec<f64>,
}

impl SpeedTrace {
    /// Mean of the size, least and most, rad/s.
    pub fn range(&self) -> (f64, f64, f64) {
        let sizes = || self.speed.iter().map(|s| s.abs());
        (
            sizes().sum::<f64>() / self.speed.len().max(1) as f64,
            sizes().fold(f64::INFINITY, f64::min),
            sizes().fold(0.0, f64::max),
        )
    }
}

/// Passages of pitches, as rows come.
pub struct PitchTimer {
    rate_hz: f64,
    teeth: f64,
    before: Option<(usize, f64)>,
    passed: Option<(f64, f64)>,
    estimates: SpeedTrace,
}

impl PitchTimer {
    /// Rows a second, and pitches a turn.
    pub fn new(rate_hz: f64, teeth: usize) -> PitchTimer {
        PitchTimer {
            rate_hz,
            teeth: teeth as f64,
            before: None,
            passed: None,
            estimates: SpeedTrace {
                turns: Vec::new(),
                speed: Vec::new(),
            },
        }
    }

    /// Rows from `first` on, turns of the output.
    pub fn push(&mut self, first: usize, turns: &[f64]) {
        // The pitch that the row before lies in; rows inside it pass nothing.
        let mut inside = f64::NAN;
        for (i, x) in turns.iter().enumerate() {
            let (row, pitch) = (first + i, x * self.teeth);
            if (0.0..1.0).contains(&(pitch - inside)) {
                self.before = Some((row, pitch));
                continue;
            }
            if let Some((last, before)) = self.before
                && last + 1 == row
            {
                let (low, high) = (before.min(pitch), before.max(pitch));
                let edge = floor_pitch(low) + 1.0;
                // The border lies between these two rows; of several in one row the first is taken.
                if edge <= high {
                    let part = (edge - before) / (pitch - before);
                    self.pass(edge, last as f64 + part);
                }
            } else {
                self.passed = None;
            }
            self.before = Some((row, pitch));
            inside = floor_pitch(pitch);
        }
    }

    fn pass(&mut self, edge: f64, row: f64) {
        if let Some((from, at)) = self.passed
            && from != edge
            && row > at
        {
            let turns = (edge - from) / self.teeth;
            self.estimates.turns.push(0.5 * (edge + from) / self.teeth);
            self.estimates
                .speed
                .push(TAU * turns * self.rate_hz / (row - at));
        }
        self.passed = Some((edge, row));
    }

    /// The speeds; nothing where no pitch passed.
    pub fn finish(self) -> Option<SpeedTrace> {
        (!self.estimates.speed.is_empty()).then_some(self.estimates)
    }
}

/// The whole number at or below, of pitches that a record can hold.
fn floor_pitch(x: f64) -> f64 {
    let towards_zero = x as i64 as f64;
    match towards_zero > x {
        true => towards_zero - 1.0,
        false => towards_zero,
    }
}
