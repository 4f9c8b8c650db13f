//! Output speed by pitch: pitch angle over passage time.

use std::f64::consts::TAU;

/// Output speed over a record.
#[derive(Debug, Clone)]
pub struct SpeedTrace {
    /// Angle at the middle of each pitch, revolutions of the output.
    pub turns: Vec<f64>,
    /// Mean output speed over each pitch, rad/s; negative in reverse rotation.
    pub speed: Vec<f64>,
}

impl SpeedTrace {
    /// Mean, minimum and maximum of the absolute speed, rad/s.
    pub fn range(&self) -> (f64, f64, f64) {
        let sizes = || self.speed.iter().map(|s| s.abs());
        (
            sizes().sum::<f64>() / self.speed.len().max(1) as f64,
            sizes().fold(f64::INFINITY, f64::min),
            sizes().fold(0.0, f64::max),
        )
    }
}

/// Timer of pitch passages, fed row by row.
pub struct PitchTimer {
    rate_hz: f64,
    teeth: f64,
    previous: Option<(usize, f64)>,
    last_edge: Option<(f64, f64)>,
    estimates: SpeedTrace,
}

impl PitchTimer {
    /// Timer for a sample rate, Hz, and a number of pitches per revolution.
    pub fn new(rate_hz: f64, teeth: usize) -> PitchTimer {
        PitchTimer {
            rate_hz,
            teeth: teeth as f64,
            previous: None,
            last_edge: None,
            estimates: SpeedTrace {
                turns: Vec::new(),
                speed: Vec::new(),
            },
        }
    }

    /// Adds the rows from index `first` on: output angles in revolutions.
    pub fn push(&mut self, first: usize, turns: &[f64]) {
        // Pitch of the previous row; rows in the same pitch pass no boundary.
        let mut current = f64::NAN;
        for (i, x) in turns.iter().enumerate() {
            let (row, pitch) = (first + i, x * self.teeth);
            if (0.0..1.0).contains(&(pitch - current)) {
                self.previous = Some((row, pitch));
                continue;
            }
            if let Some((last, previous)) = self.previous
                && last + 1 == row
            {
                let (low, high) = (previous.min(pitch), previous.max(pitch));
                let edge = floor_pitch(low) + 1.0;
                // The pitch boundary lies between these two rows; of several, the first is used.
                if edge <= high {
                    let part = (edge - previous) / (pitch - previous);
                    self.pass(edge, last as f64 + part);
                }
            } else {
                self.last_edge = None;
            }
            self.previous = Some((row, pitch));
            current = floor_pitch(pitch);
        }
    }

    fn pass(&mut self, edge: f64, row: f64) {
        if let Some((start, start_row)) = self.last_edge
            && start != edge
            && row > start_row
        {
            let turns = (edge - start) / self.teeth;
            self.estimates.turns.push(0.5 * (edge + start) / self.teeth);
            self.estimates
                .speed
                .push(TAU * turns * self.rate_hz / (row - start_row));
        }
        self.last_edge = Some((edge, row));
    }

    /// Speeds of the pitches; `None` without a complete pitch.
    pub fn finish(self) -> Option<SpeedTrace> {
        (!self.estimates.speed.is_empty()).then_some(self.estimates)
    }
}

/// Floor of a pitch number, within the range of `i64`.
fn floor_pitch(x: f64) -> f64 {
    let truncated = x as i64 as f64;
    match truncated > x {
        true => truncated - 1.0,
        false => truncated,
    }
}
