//! What repeats with every tooth or every turn: mesh stiffness over the mesh cycle, transmission error over the angle.

use std::f64::consts::TAU;

use crate::machine::direction::Direction;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;
pub use crate::scene::laws::Shape;

/// A periodic function of a phase.
#[derive(Debug, Clone, PartialEq)]
pub struct Wave {
    /// One period.
    pub shape: Shape,
    /// What carries it on.
    pub phase: Phase,
}

/// Where in its period a wave is.
#[derive(Debug, Clone, PartialEq)]
pub enum Phase {
    /// `ψ = (ω t + start) / 2π`: the speed is imposed.
    Imposed {
        /// rad/s.
        omega: f64,
        /// rad.
        start: f64,
    },
    /// `ψ = (aᵀq + start) / 2π`: it follows an angle.
    Followed {
        /// a, in radians of the wave's period per unit of q.
        angle: Direction,
        /// rad.
        start: f64,
    },
}

impl Phase {
    /// ψ, in periods.
    pub fn at(&self, t: f64, q: &[f64]) -> f64 {
        match self {
            Phase::Imposed { omega, start } => (omega * t + start) / TAU,
            Phase::Followed { angle, start } => (angle.dot(q) + start) / TAU,
        }
    }

    /// dψ/dt, periods per second.
    pub fn rate(&self, v: &[f64]) -> f64 {
        match self {
            Phase::Imposed { omega, .. } => omega / TAU,
            Phase::Followed { angle, .. } => angle.dot(v) / TAU,
        }
    }

    /// The angle it follows, where it follows one.
    pub fn angle(&self) -> Option<&Direction> {
        match self {
            Phase::Imposed { .. } => None,
            Phase::Followed { angle, .. } => Some(angle),
        }
    }
}

impl Shape {
    /// The value at ψ; at a jump the one that follows.
    pub fn value(&self, psi: f64) -> f64 {
        self.value_in(psi, self.piece(psi))
    }

    /// Which smooth piece of the period holds ψ, counted from zero.
    pub fn piece(&self, psi: f64) -> usize {
        let psi = psi.rem_euclid(1.0);
        match self {
            Shape::Rectangular { duty, .. } => usize::from(psi >= *duty),
            Shape::Fourier { .. } => 0,
            Shape::Table(values) => ((psi * values.len() as f64) as usize).min(values.len() - 1),
        }
    }

    /// The value with the piece `piece` carried on beyond its ends.
    pub fn value_in(&self, psi: f64, piece: usize) -> f64 {
        match self {
            Shape::Rectangular { high, low, .. } => [*high, *low][piece],
            Shape::Fourier { mean, terms } => {
                mean + terms
                    .iter()
                    .map(|&(n, a, phi)| a * (TAU * f64::from(n) * psi + phi).cos())
                    .sum::<f64>()
            }
            Shape::Table(values) => {
                let (a, b) = (values[piece], values[(piece + 1) % values.len()]);
                a + (b - a) * into_piece(psi, piece, values.len())
            }
        }
    }

    /// d/dψ on the piece `piece`.
    pub fn slope_in(&self, psi: f64, piece: usize) -> f64 {
        match self {
            Shape::Rectangular { .. } => 0.0,
            Shape::Fourier { terms, .. } => terms
                .iter()
                .map(|&(n, a, phi)| {
                    -a * TAU * f64::from(n) * (TAU * f64::from(n) * psi + phi).sin()
                })
                .sum(),
            Shape::Table(values) => {
                (values[(piece + 1) % values.len()] - values[piece]) * values.len() as f64
            }
        }
    }

    /// Where the next piece begins: the least ψ above the given one at which the piece changes; ∞ where the period is one piece.
    pub fn next_piece(&self, psi: f64) -> f64 {
        let whole = psi.floor();
        match self {
            Shape::Rectangular { duty, .. } => match psi - whole < *duty {
                true => whole + duty,
                false => whole + 1.0,
            },
            Shape::Fourier { .. } => f64::INFINITY,
            Shape::Table(values) => {
                let n = values.len() as f64;
                whole + (((psi - whole) * n).floor() + 1.0) / n
            }
        }
    }

    /// The same, so many times as large.
    pub fn times(&self, factor: f64) -> Shape {
        match self {
            Shape::Rectangular { high, low, duty } => Shape::Rectangular {
                high: factor * high,
                low: factor * low,
                duty: *duty,
            },
            Shape::Fourier { mean, terms } => Shape::Fourier {
                mean: factor * mean,
                terms: terms.iter().map(|&(n, a, p)| (n, factor * a, p)).collect(),
            },
            Shape::Table(values) => Shape::Table(values.iter().map(|v| factor * v).collect()),
        }
    }

    /// n, a, φ of what is not constant; a table as the trigonometric polynomial through its points. A wave of steps has no end of
    /// them and gives none.
    pub fn harmonics(&self) -> Vec<(u32, f64, f64)> {
        match self {
            Shape::Rectangular { .. } => Vec::new(),
            Shape::Fourier { terms, .. } => terms.clone(),
            Shape::Table(values) => through(values),
        }
    }

    /// The mean over a period.
    pub fn mean(&self) -> f64 {
        match self {
            Shape::Rectangular { high, low, duty } => high * duty + low * (1.0 - duty),
            Shape::Fourier { mean, .. } => *mean,
            Shape::Table(values) => values.iter().sum::<f64>() / values.len() as f64,
        }
    }

    /// No value is below this.
    pub fn least(&self) -> f64 {
        match self {
            Shape::Rectangular { high, low, .. } => high.min(*low),
            Shape::Fourier { mean, terms } => mean - terms.iter().map(|t| t.1.abs()).sum::<f64>(),
            Shape::Table(values) => values.iter().copied().fold(f64::INFINITY, f64::min),
        }
    }

    /// No value is above this.
    pub fn greatest(&self) -> f64 {
        match self {
            Shape::Rectangular { high, low, .. } => high.max(*low),
            Shape::Fourier { mean, terms } => mean + terms.iter().map(|t| t.1.abs()).sum::<f64>(),
            Shape::Table(values) => values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        }
    }

    /// Constant between jumps.
    pub fn is_steps(&self) -> bool {
        matches!(self, Shape::Rectangular { .. })
    }
}

/// How far ψ is into a piece of a table, in pieces; beyond its ends below zero or above one.
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
fn through(values: &[f64]) -> Vec<(u32, f64, f64)> {
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
