//! Known function of time: piecewise linear or quadratic with jumps, plus harmonics.

use std::f64::consts::FRAC_PI_2;

use super::burst::Burst;
use crate::base::code::Code;
use crate::base::error::Error;

/// Signal x(t): the polynomial of the last knot at or before t, plus harmonics and bursts.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Signal {
    /// Knots in order of time; the polynomial is zero before the first one.
    pub knots: Vec<Knot>,
    /// Harmonics `Σ a cos(ω t + φ)` at all times.
    pub harmonics: Vec<Harmonic>,
    /// Harmonics that begin and end at knots.
    pub bursts: Vec<Burst>,
}

/// Start of the piece `value + slope (t − time) + ½ curvature (t − time)²`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knot {
    /// Time of the knot, s; −∞ for a piece without a start.
    pub time: f64,
    /// Value at the knot (at time zero for a knot at −∞).
    pub value: f64,
    /// First derivative, 1/s.
    pub slope: f64,
    /// Second derivative, 1/s²; zero for a straight line.
    pub curvature: f64,
}

/// Relative tolerance of a jump of value or slope: the rounding error of the computed ends of a piece.
const JUMP_TOLERANCE: f64 = 1e-12;

/// Harmonic `amplitude · cos(omega t + phase)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// Amplitude, zero to peak.
    pub amplitude: f64,
    /// Angular frequency, rad/s.
    pub omega: f64,
    /// Phase, rad.
    pub phase: f64,
}

impl Knot {
    /// Knot of a straight line.
    pub fn line(time: f64, value: f64, slope: f64) -> Knot {
        Knot {
            time,
            value,
            slope,
            curvature: 0.0,
        }
    }

    /// Time since the knot, s; since time zero for a knot at −∞.
    fn elapsed(&self, t: f64) -> f64 {
        match self.time.is_finite() {
            true => t - self.time,
            false => t,
        }
    }

    /// Value of the piece at the time t, s.
    pub fn value_at(&self, t: f64) -> f64 {
        match (self.slope, self.curvature) {
            (0.0, 0.0) => self.value,
            (slope, curvature) => {
                let dt = self.elapsed(t);
                self.value + (slope + 0.5 * curvature * dt) * dt
            }
        }
    }

    /// First derivative of the piece at the time t, s.
    pub fn slope_at(&self, t: f64) -> f64 {
        match self.curvature {
            0.0 => self.slope,
            curvature => self.slope + curvature * self.elapsed(t),
        }
    }
}

impl Signal {
    /// Constant signal.
    pub fn constant(value: f64) -> Signal {
        Signal {
            knots: vec![Knot::line(f64::NEG_INFINITY, value, 0.0)],
            ..Signal::default()
        }
    }

    /// Step from zero to `size` at `time`, s.
    pub fn step(size: f64, time: f64) -> Signal {
        Signal {
            knots: vec![Knot::line(time, size, 0.0)],
            ..Signal::default()
        }
    }

    /// Ramp from the value `from` at the start to the value `to` at the end, s.
    pub fn ramp(from: f64, to: f64, [start, end]: [f64; 2]) -> Signal {
        let slope = (to - from) / (end - start);
        let knots = vec![
            Knot::line(f64::NEG_INFINITY, from, 0.0),
            Knot::line(start, from, slope),
            Knot::line(end, to, 0.0),
        ];
        Signal {
            knots,
            ..Signal::default()
        }
    }

    /// Signal of one harmonic.
    pub fn harmonic(amplitude: f64, omega: f64, phase: f64) -> Signal {
        Signal {
            harmonics: vec![Harmonic {
                amplitude,
                omega,
                phase,
            }],
            ..Signal::default()
        }
    }

    /// Piecewise linear signal through points (t in s, x) in order of time, constant before and after; two points at one time are a jump.
    ///
    /// # Errors
    /// Times that decrease, or numbers that are not finite.
    pub fn table(points: &[(f64, f64)]) -> Result<Signal, Error> {
        let invalid = |message: &str| {
            Err(Error::new(Code::OutOfRange, message)
                .with_hint("give time and value in increasing order of time"))
        };
        if points.iter().any(|p| !p.0.is_finite() || !p.1.is_finite()) {
            return invalid("a table over time has a value that is not finite");
        }
        if points.windows(2).any(|p| p[1].0 < p[0].0) {
            return invalid("the times of a table decrease");
        }
        let Some(first) = points.first() else {
            return invalid("a table over time is empty");
        };
        let mut knots = vec![Knot::line(f64::NEG_INFINITY, first.1, 0.0)];
        for ends in points.windows(2) {
            let ((t, x), (u, y)) = (ends[0], ends[1]);
            if u > t {
                knots.push(Knot::line(t, x, (y - x) / (u - t)));
            }
        }
        if let (Some(&(time, value)), true) = (points.last(), points.len() > 1) {
            knots.push(Knot::line(time, value, 0.0));
        }
        Ok(Signal {
            knots,
            ..Signal::default()
        })
    }

    /// Number of the active piece at the time t, s, counted from one; zero before the first knot.
    pub fn piece(&self, t: f64) -> usize {
        self.knots.partition_point(|knot| knot.time <= t)
    }

    /// Value at the time t, s, with the piece `piece` (see [`Signal::piece`]) extrapolated if needed.
    pub fn value(&self, t: f64, piece: usize) -> f64 {
        let line = match piece {
            0 => 0.0,
            k => self.knots[k - 1].value_at(t),
        };
        let harmonics = self.harmonics.iter();
        let harmonics = harmonics.map(|h| h.amplitude * (h.omega * t + h.phase).cos());
        line + harmonics.sum::<f64>() + self.bursts(t, piece, 0)
    }

    /// Sum of the derivatives of a given order of the bursts active on a piece.
    fn bursts(&self, t: f64, piece: usize, order: usize) -> f64 {
        if self.bursts.is_empty() {
            return 0.0;
        }
        let start = piece
            .checked_sub(1)
            .map_or(f64::NEG_INFINITY, |k| self.knots[k].time);
        let active = self.bursts.iter().filter(|b| b.lasts(start));
        active.map(|b| b.value_at(t)[order]).sum()
    }

    /// First derivative at the time t, s, on the piece `piece`.
    pub fn slope(&self, t: f64, piece: usize) -> f64 {
        let line = match piece {
            0 => 0.0,
            k => self.knots[k - 1].slope_at(t),
        };
        line - self
            .harmonics
            .iter()
            .map(|h| h.amplitude * h.omega * (h.omega * t + h.phase).sin())
            .sum::<f64>()
            + self.bursts(t, piece, 1)
    }

    /// Second derivative at the time t, s, on the piece `piece`.
    pub fn curvature(&self, t: f64, piece: usize) -> f64 {
        let line = match piece {
            0 => 0.0,
            k => self.knots[k - 1].curvature,
        };
        line - self
            .harmonics
            .iter()
            .map(|h| h.amplitude * h.omega * h.omega * (h.omega * t + h.phase).cos())
            .sum::<f64>()
            + self.bursts(t, piece, 2)
    }

    /// Time of the first knot after t, s; ∞ without one.
    pub fn next_knot(&self, t: f64) -> f64 {
        self.knots
            .get(self.piece(t))
            .map_or(f64::INFINITY, |knot| knot.time)
    }

    /// Sum of two signals.
    #[must_use]
    pub fn plus(&self, other: &Signal) -> Signal {
        let mut times: Vec<f64> = self
            .knots
            .iter()
            .chain(&other.knots)
            .map(|k| k.time)
            .collect();
        times.sort_by(f64::total_cmp);
        times.dedup();
        let derivatives = |signal: &Signal, time: f64| match signal.piece(time) {
            0 => [0.0; 3],
            k => {
                let (knot, t) = (
                    signal.knots[k - 1],
                    if time.is_finite() { time } else { 0.0 },
                );
                [knot.value_at(t), knot.slope_at(t), knot.curvature]
            }
        };
        let knot = |&time: &f64| {
            let (a, b) = (derivatives(self, time), derivatives(other, time));
            Knot {
                time,
                value: a[0] + b[0],
                slope: a[1] + b[1],
                curvature: a[2] + b[2],
            }
        };
        let harmonics = self
            .harmonics
            .iter()
            .chain(&other.harmonics)
            .copied()
            .collect();
        Signal {
            knots: times.iter().map(knot).collect(),
            harmonics,
            bursts: self.bursts.iter().chain(&other.bursts).copied().collect(),
        }
    }

    /// Signal multiplied by a factor.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Signal {
        let knots = self.knots.iter().map(|k| Knot {
            time: k.time,
            value: factor * k.value,
            slope: factor * k.slope,
            curvature: factor * k.curvature,
        });
        let harmonics = self.harmonics.iter().map(|h| Harmonic {
            amplitude: factor * h.amplitude,
            ..*h
        });
        Signal {
            knots: knots.collect(),
            harmonics: harmonics.collect(),
            bursts: self.bursts.iter().map(|b| b.times(factor)).collect(),
        }
    }

    /// Time derivative of the signal, without the impulses of its jumps.
    #[must_use]
    pub fn rate(&self) -> Signal {
        let knots = self.knots.iter().map(|k| Knot {
            time: k.time,
            value: k.slope,
            slope: k.curvature,
            curvature: 0.0,
        });
        let harmonics = self.harmonics.iter().map(|h| Harmonic {
            amplitude: h.amplitude * h.omega,
            omega: h.omega,
            phase: h.phase + FRAC_PI_2,
        });
        Signal {
            knots: knots.collect(),
            harmonics: harmonics.collect(),
            bursts: self.bursts.iter().flat_map(Burst::rate).collect(),
        }
    }

    /// Integral of the signal from time zero. The signal must be piecewise linear plus harmonics, without bursts.
    #[must_use]
    pub fn integral(&self) -> Signal {
        let mut knots: Vec<Knot> = Vec::with_capacity(self.knots.len());
        for k in &self.knots {
            let value = knots.last().map_or(0.0, |last| last.value_at(k.time));
            knots.push(Knot {
                time: k.time,
                value,
                slope: k.value,
                curvature: k.slope,
            });
        }
        let harmonics = self.harmonics.iter().map(|h| Harmonic {
            amplitude: h.amplitude / h.omega,
            omega: h.omega,
            phase: h.phase - FRAC_PI_2,
        });
        let sum = Signal {
            knots,
            harmonics: harmonics.collect(),
            ..Signal::default()
        };
        let at_zero = sum.value(0.0, sum.piece(0.0));
        sum.plus(&Signal::constant(-at_zero))
    }

    /// True for a piecewise linear signal plus harmonics, without bursts.
    pub fn is_piecewise_linear(&self) -> bool {
        self.knots.iter().all(|k| k.curvature == 0.0) && self.bursts.is_empty()
    }

    /// True if the value or the slope jumps at a knot.
    pub fn has_kinks(&self) -> bool {
        let largest =
            |f: fn(&Knot) -> f64| self.knots.iter().fold(0.0f64, |m, k| m.max(f(k).abs()));
        let (value, slope) = (largest(|k| k.value), largest(|k| k.slope));
        self.knots.windows(2).any(|pair| {
            let t = pair[1].time;
            (pair[0].value_at(t) - pair[1].value).abs() > JUMP_TOLERANCE * value
                || (pair[0].slope_at(t) - pair[1].slope).abs() > JUMP_TOLERANCE * slope
        })
    }

    /// True if the signal is zero at all times.
    pub fn is_zero(&self) -> bool {
        self.knots
            .iter()
            .all(|k| k.value == 0.0 && k.slope == 0.0 && k.curvature == 0.0)
            && self.harmonics.iter().all(|h| h.amplitude == 0.0)
            && self.bursts.is_empty()
    }
}
