//! Periodic functions of a phase: mesh stiffness and transmission error.

use std::f64::consts::TAU;
use std::sync::Arc;

use super::signal::Signal;
use crate::gear::load::load_table::{LoadCurve, LoadTable};
use crate::machine::direction::Direction;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;
pub use crate::scene::laws::Waveform;

/// A periodic function of a phase.
#[derive(Debug, Clone, PartialEq)]
pub struct PeriodicFunction {
    /// One period.
    pub waveform: Waveform,
    /// Load over deflection along the period, where a stiffness follows its load: then the waveform is the secant at the mean load.
    pub load_table: Option<Arc<LoadTable>>,
    /// Phase of the function.
    pub phase: WavePhase,
}

/// Phase of a wave in its period.
#[derive(Debug, Clone, PartialEq)]
pub enum WavePhase {
    /// `ψ = (ω t + start) / 2π`: the speed is imposed.
    Imposed {
        /// rad/s.
        omega: f64,
        /// rad.
        start: f64,
    },
    /// `ψ = (aᵀq + x(t) + start) / 2π`: it follows an angle.
    FollowsAngle {
        /// a, in radians of the wave's period per unit of q.
        angle: Direction,
        /// rad.
        start: f64,
        /// x: the part of the angle whose motion is prescribed, rad.
        known: Option<Signal>,
    },
}

impl PeriodicFunction {
    /// The function at imposed speed, in the sense of rising phase: run backward, a period is its mirror image.
    pub fn imposed(self, omega: f64, start: f64) -> PeriodicFunction {
        if omega >= 0.0 {
            return PeriodicFunction {
                phase: WavePhase::Imposed { omega, start },
                ..self
            };
        }
        let waveform = self.waveform;
        let (waveform, start) = match waveform {
            // High for 0 ≤ ψ < duty backward is high for 0 ≤ ψ + duty < duty forward.
            Waveform::Rectangular { duty, .. } => (waveform, TAU * duty - start),
            Waveform::Fourier { mean, terms } => {
                let terms = terms.into_iter().map(|(n, a, phase)| (n, a, -phase));
                let terms = terms.collect();
                (Waveform::Fourier { mean, terms }, -start)
            }
            Waveform::Table(values) => {
                let n = values.len();
                let mirrored = (0..n).map(|i| values[(n - i) % n]).collect();
                (Waveform::Table(mirrored), -start)
            }
        };
        PeriodicFunction {
            waveform,
            load_table: self.load_table.map(|table| Arc::new(table.reversed())),
            phase: WavePhase::Imposed {
                omega: -omega,
                start,
            },
        }
    }

    /// Load over deflection at ψ on a piece of the period, where the function has it.
    pub fn load_curve(&self, psi: f64, piece: usize) -> Option<LoadCurve<'_>> {
        let table = self.load_table.as_ref()?;
        let share = into_piece(psi, piece, table.position_count());
        Some(table.curve(piece, share))
    }
}

impl WavePhase {
    /// ψ, in periods.
    pub fn phase_at(&self, t: f64, q: &[f64]) -> f64 {
        match self {
            WavePhase::Imposed { omega, start } => (omega * t + start) / TAU,
            WavePhase::FollowsAngle {
                angle,
                start,
                known,
            } => {
                let known = known.as_ref().map_or(0.0, |x| x.value(t, x.piece(t)));
                (angle.dot(q) + known + start) / TAU
            }
        }
    }

    /// dψ/dt, periods per second.
    pub fn rate(&self, t: f64, v: &[f64]) -> f64 {
        match self.angle() {
            None => self.imposed_rate(t),
            Some(angle) => angle.dot(v) / TAU + self.imposed_rate(t),
        }
    }

    /// Part of dψ/dt imposed in time, periods per second.
    pub fn imposed_rate(&self, t: f64) -> f64 {
        match self {
            WavePhase::Imposed { omega, .. } => omega / TAU,
            WavePhase::FollowsAngle { known, .. } => {
                known.as_ref().map_or(0.0, |x| x.slope(t, x.piece(t))) / TAU
            }
        }
    }

    /// The angle it follows, where it follows one.
    pub fn angle(&self) -> Option<&Direction> {
        match self {
            WavePhase::Imposed { .. } => None,
            WavePhase::FollowsAngle { angle, .. } => Some(angle),
        }
    }
}

impl Waveform {
    /// The value at ψ; at a jump the one that follows.
    pub fn value(&self, psi: f64) -> f64 {
        self.value_in(psi, self.piece(psi))
    }

    /// Which smooth piece of the period holds ψ, counted from zero.
    pub fn piece(&self, psi: f64) -> usize {
        let psi = psi.rem_euclid(1.0);
        match self {
            Waveform::Rectangular { duty, .. } => usize::from(psi >= *duty),
            Waveform::Fourier { .. } => 0,
            Waveform::Table(values) => ((psi * values.len() as f64) as usize).min(values.len() - 1),
        }
    }

    /// The value with the piece `piece` carried on beyond its ends.
    pub fn value_in(&self, psi: f64, piece: usize) -> f64 {
        match self {
            Waveform::Rectangular { high, low, .. } => [*high, *low][piece],
            Waveform::Fourier { mean, terms } => {
                mean + terms
                    .iter()
                    .map(|&(n, a, phi)| a * (TAU * f64::from(n) * psi + phi).cos())
                    .sum::<f64>()
            }
            Waveform::Table(values) => {
                let (a, b) = (values[piece], values[(piece + 1) % values.len()]);
                a + (b - a) * into_piece(psi, piece, values.len())
            }
        }
    }

    /// d/dψ on the piece `piece`.
    pub fn slope_in(&self, psi: f64, piece: usize) -> f64 {
        match self {
            Waveform::Rectangular { .. } => 0.0,
            Waveform::Fourier { terms, .. } => terms
                .iter()
                .map(|&(n, a, phi)| {
                    -a * TAU * f64::from(n) * (TAU * f64::from(n) * psi + phi).sin()
                })
                .sum(),
            Waveform::Table(values) => {
                (values[(piece + 1) % values.len()] - values[piece]) * values.len() as f64
            }
        }
    }

    /// Start of the next piece: the least ψ above the given one at which the piece changes; ∞ where the period is one piece.
    pub fn next_piece(&self, psi: f64) -> f64 {
        let whole = psi.floor();
        // An edge computed from a phase may lie at that very phase, or one rounding before it.
        let first = |edges: [f64; 3]| {
            let mut ahead = edges.into_iter().filter(|&edge| edge > psi);
            ahead.next().unwrap_or(f64::INFINITY)
        };
        match self {
            Waveform::Rectangular { duty, .. } => {
                first([whole + duty, whole + 1.0, whole + 1.0 + duty])
            }
            Waveform::Fourier { .. } => f64::INFINITY,
            Waveform::Table(values) => {
                let n = values.len() as f64;
                let at = ((psi - whole) * n).floor();
                first([1.0, 2.0, 3.0].map(|ahead| whole + (at + ahead) / n))
            }
        }
    }

    /// The same, so many times as large.
    pub fn scaled(&self, factor: f64) -> Waveform {
        match self {
            Waveform::Rectangular { high, low, duty } => Waveform::Rectangular {
                high: factor * high,
                low: factor * low,
                duty: *duty,
            },
            Waveform::Fourier { mean, terms } => Waveform::Fourier {
                mean: factor * mean,
                terms: terms.iter().map(|&(n, a, p)| (n, factor * a, p)).collect(),
            },
            Waveform::Table(values) => Waveform::Table(values.iter().map(|v| factor * v).collect()),
        }
    }

    /// n, a, φ of what is not constant; a table as the trigonometric polynomial through its points. A wave of steps has no end of
    /// them and gives none.
    pub fn harmonics(&self) -> Vec<(u32, f64, f64)> {
        match self {
            Waveform::Rectangular { .. } => Vec::new(),
            Waveform::Fourier { terms, .. } => terms.clone(),
            Waveform::Table(values) => trigonometric_interpolant(values),
        }
    }

    /// The mean over a period.
    pub fn mean(&self) -> f64 {
        match self {
            Waveform::Rectangular { high, low, duty } => high * duty + low * (1.0 - duty),
            Waveform::Fourier { mean, .. } => *mean,
            Waveform::Table(values) => values.iter().sum::<f64>() / values.len() as f64,
        }
    }

    /// No value is above this.
    pub fn max(&self) -> f64 {
        match self {
            Waveform::Rectangular { high, low, .. } => high.max(*low),
            Waveform::Fourier { mean, terms } => {
                mean + terms.iter().map(|t| t.1.abs()).sum::<f64>()
            }
            Waveform::Table(values) => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// A wave at imposed speed as harmonics in time. A table becomes as many as it can tell: the smooth curve through its points.
    pub fn to_signal(&self, omega: f64, start: f64) -> Signal {
        let mean = Signal::constant(self.mean());
        self.harmonics().iter().fold(mean, |sum, &(n, a, phase)| {
            let n = f64::from(n);
            sum.plus(&Signal::harmonic(a, n * omega, n * start + phase))
        })
    }

    /// Constant between jumps.
    pub fn is_piecewise_constant(&self) -> bool {
        matches!(self, Waveform::Rectangular { .. })
    }
}

/// Position of ψ in a piece of a table, in pieces; beyond its ends below zero or above one.
fn into_piece(psi: f64, piece: usize, pieces: usize) -> f64 {
    let into = psi.rem_euclid(1.0) * pieces as f64 - piece as f64;
    let half = pieces as f64 / 2.0;
    if into > half {
        into - pieces as f64
    } else if into < -half {
        into + pieces as f64
    } else {
        into
    }
}

/// The trigonometric polynomial through equally spaced values: n, a, φ.
fn trigonometric_interpolant(values: &[f64]) -> Vec<(u32, f64, f64)> {
    let count = values.len();
    let mut transform = RealFft::new(count);
    let mut spectrum = vec![Complex::ZERO; transform.lines()];
    transform.forward(&mut values.to_vec(), &mut spectrum);
    let term = |n: usize| {
        let share = if 2 * n == count { 1.0 } else { 2.0 } / count as f64;
        (n as u32, share * spectrum[n].norm(), spectrum[n].arg())
    };
    (1..=count / 2).map(term).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From edge to edge, whatever rounding does to them.
    #[test]
    fn law_pieces_go_on() {
        let steps = Waveform::Rectangular {
            high: 1.0,
            low: 0.0,
            duty: 0.4,
        };
        let table = Waveform::Table(vec![0.0; 7]);
        for (waveform, count) in [(steps, 2.0), (table, 7.0)] {
            let mut psi = 1000.2;
            for _ in 0..7000 {
                let next = waveform.next_piece(psi);
                assert!(next > psi && next < psi + 1.0, "{psi} {next}");
                psi = next;
            }
            assert!((psi - 1000.2 - 7000.0 / count).abs() < 1.0, "{psi}");
        }
    }
}
