//! Torque over speed: motors, brakes, fans.

/// A torque as a function of speed. It is what the machine receives: positive drives forward.
#[derive(Debug, Clone, PartialEq)]
pub enum Curve {
    /// `T = T₀ (1 − ω/ω₀)`: a DC motor at constant voltage.
    Straight {
        /// T₀, at standstill, N·m.
        stall: f64,
        /// ω₀, without load, rad/s.
        idle: f64,
    },
    /// Kloss's formula `T = 2 T_k / (s/s_k + s_k/s)`, `s = (ω_s − ω)/ω_s`: an induction motor at constant frequency.
    Induction {
        /// T_k, the pull-out torque, N·m.
        pull_out: f64,
        /// s_k, the slip at which it acts.
        slip: f64,
        /// ω_s, rad/s.
        synchronous: f64,
    },
    /// Straight lines through points, constant beyond them: speed, torque; by rising speed.
    Table(Vec<(f64, f64)>),
}

impl Curve {
    /// The torque at a speed.
    pub fn torque(&self, speed: f64) -> f64 {
        match self {
            Curve::Straight { stall, idle } => stall * (1.0 - speed / idle),
            Curve::Induction {
                pull_out,
                slip,
                synchronous,
            } => {
                let s = 1.0 - speed / synchronous;
                2.0 * pull_out * s * slip / (s * s + slip * slip)
            }
            Curve::Table(points) => {
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
            Curve::Straight { stall, idle } => -stall / idle,
            Curve::Induction {
                pull_out,
                slip,
                synchronous,
            } => {
                let s = 1.0 - speed / synchronous;
                let sum = s * s + slip * slip;
                -2.0 * pull_out * slip * (slip * slip - s * s) / (sum * sum) / synchronous
            }
            Curve::Table(points) => {
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
