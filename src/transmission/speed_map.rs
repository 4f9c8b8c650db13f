//! Order lines of a transmission error over the speed of the machine.

use super::dynamic::ErrorTransfer;
use super::order_lines::OrderLine;
use crate::base::error::Error;
use crate::numeric::statistics;
use crate::response::system::{OperatingModel, natural_frequencies};

/// Every line over the speed of the machine.
pub struct SpeedMap {
    /// Speeds of the first node of `[speed]`, rad/s.
    pub speeds: Vec<f64>,
    /// Amplitude A of every row at each speed, rad.
    pub amplitudes: Vec<Vec<f64>>,
    /// Speed of the largest amplitude of every row, rad/s, and A there, rad: of these speeds and of those between them at which the row's
    /// order meets a natural frequency.
    pub largest: Vec<(f64, f64)>,
    /// Some resonance between the speeds has no damping: lines are infinite there, and the largest are those of the speeds.
    pub is_undamped: bool,
}

impl SpeedMap {
    /// Lines at speeds of the machine, at each of which the node that orders are counted by turns at `reference_speeds`, `ratio` times as
    /// fast, rad/s.
    ///
    /// # Errors
    /// Those of the responses.
    pub fn new(
        (transfer, model): (&ErrorTransfer, &OperatingModel),
        lines: &[OrderLine],
        (speeds, reference_speeds): (Vec<f64>, &[f64]),
        ratio: f64,
    ) -> Result<SpeedMap, Error> {
        let mut amplitudes = vec![Vec::with_capacity(speeds.len()); lines.len()];
        for &speed in reference_speeds {
            let values = transfer.at_speed(speed, lines)?;
            let each = amplitudes.iter_mut().zip(values);
            each.for_each(|(row, z)| row.push(z.norm()));
        }
        let largest = amplitudes.iter().map(|row| {
            let both = speeds.iter().copied().zip(row.iter().copied());
            both.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or_default()
        });
        let mut map = SpeedMap {
            largest: largest.collect(),
            speeds,
            amplitudes,
            is_undamped: false,
        };
        map.raise_at_resonances(transfer, model, lines, ratio);
        Ok(map)
    }

    /// Raises the largest amplitudes to those at resonances between the speeds.
    fn raise_at_resonances(
        &mut self,
        transfer: &ErrorTransfer,
        model: &OperatingModel,
        lines: &[OrderLine],
        ratio: f64,
    ) {
        let (low, high) = statistics::extremes(self.speeds.iter().copied());
        let fastest = lines.iter().map(|line| line.order.to_f64());
        let fastest = fastest.fold(0.0, f64::max) * ratio * low.abs().max(high.abs());
        let all: Vec<&OrderLine> = lines.iter().collect();
        for omega in natural_frequencies(model, transfer.ports(), (0.0, fastest)) {
            let Ok(values) = transfer.response_at(omega, &all) else {
                self.is_undamped = true;
                continue;
            };
            for ((line, z), best) in lines.iter().zip(values).zip(&mut self.largest) {
                let speed = omega / (line.order.to_f64() * ratio);
                let inside = [speed, -speed]
                    .into_iter()
                    .find(|s| (low..=high).contains(s));
                if let Some(speed) = inside
                    && z.norm() > best.1
                {
                    *best = (speed, z.norm());
                }
            }
        }
    }
}
