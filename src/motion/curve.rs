//! Torque over speed: motors, brakes, fans.

pub use crate::scene::laws::TorqueSpeedCurve;

impl TorqueSpeedCurve {
    /// The torque at a speed.
    pub fn torque(&self, speed: f64) -> f64 {
        match self {
            TorqueSpeedCurve::Linear { stall, idle } => stall * (1.0 - speed / idle),
            TorqueSpeedCurve::Induction {
                pull_out,
                slip,
                synchronous,
            } => {
                let s = 1.0 - speed / synchronous;
                2.0 * pull_out * s * slip / (s * s + slip * slip)
            }
            TorqueSpeedCurve::Table(points) => {
                let (first, last) = (points[0], points[points.len() - 1]);
                if speed <= first.0 {
                    return first.1;
                }
                if speed >= last.0 {
                    return last.1;
                }
                let at = points.partition_point(|p| p.0 <= speed);
                let ((x, y), (u, v)) = (points[at - 1], points[at]);
                y + (v - y) * (speed - x) / (u - x)
            }
        }
    }

    /// dT/dω.
    pub fn slope(&self, speed: f64) -> f64 {
        match self {
            TorqueSpeedCurve::Linear { stall, idle } => -stall / idle,
            TorqueSpeedCurve::Induction {
                pull_out,
                slip,
                synchronous,
            } => {
                let s = 1.0 - speed / synchronous;
                let sum = s * s + slip * slip;
                -2.0 * pull_out * slip * (slip * slip - s * s) / (sum * sum) / synchronous
            }
            TorqueSpeedCurve::Table(points) => {
                if speed < points[0].0 || speed >= points[points.len() - 1].0 {
                    return 0.0;
                }
                let at = points.partition_point(|p| p.0 <= speed);
                let ((x, y), (u, v)) = (points[at - 1], points[at]);
                (v - y) / (u - x)
            }
        }
    }
}
