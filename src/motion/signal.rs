//! Known function of time: piecewise linear or quadratic with jumps, plus harmonics.

use std::f64::consts::FRAC_PI_2;

use super::burst::Burst;
use crate::base::code::Code;
use crate::base::error::Error;

/// `x(t)`: the last knot at or before t carries a line or a parabola; harmonics add to it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Signal {
    /// By rising time. Before the first one the value is zero.
    pub knots: Vec<Knot>,
    /// `Σ a cos(ω t + φ)`, everlasting.
    pub harmonics: Vec<Harmonic>,
    /// Harmonics that begin and end, both at knots.
    pub bursts: Vec<Burst>,
}

/// From `time` on the signal is `value + slope (t − time) + ½ curvature (t − time)²`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knot {
    /// s; −∞ for what always was so.
    pub time: f64,
    /// Value at the knot (or at time zero where the knot lies at −∞).
    pub value: f64,
    /// Change per second.
    pub slope: f64,
    /// The change of that per second; zero for a straight line.
    pub curvature: f64,
}

/// Lines meet where they differ by no more than this share: the rounding of their computed ends.
const KINK: f64 = 1e-12;

/// `amplitude · cos(omega t + phase)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Harmonic {
    /// 0-to-peak.
    pub amplitude: f64,
    /// rad/s.
    pub omega: f64,
    /// rad.
    pub phase: f64,
}

impl Knot {
    /// A straight line.
    pub fn line(time: f64, value: f64, slope: f64) -> Knot {
        Knot {
            time,
            value,
            slope,
            curvature: 0.0,
        }
    }

    /// Seconds since it, since time zero where it lies at −∞.
    fn since(&self, t: f64) -> f64 {
        match self.time.is_finite() {
            true => t - self.time,
            false => t,
        }
    }

    /// Value of the line at `t`.
    pub fn value_at(&self, t: f64) -> f64 {
        match (self.slope, self.curvature) {
            (0.0, 0.0) => self.value,
            (slope, bend) => {
                let since = self.since(t);
                self.value + (slope + 0.5 * bend * since) * since
            }
        }
    }

    /// The slope of its line at `t`.
    pub fn slope_at(&self, t: f64) -> f64 {
        match self.curvature {
            0.0 => self.slope,
            bend => self.slope + bend * self.since(t),
        }
    }
}

impl Signal {
    /// The same at all times.
    pub fn constant(value: f64) -> Signal {
        Signal {
            knots: vec![Knot::line(f64::NEG_INFINITY, value, 0.0)],
            ..Signal::default()
        }
    }

    /// Zero before `time`, `size` from then on.
    pub fn step(size: f64, time: f64) -> Signal {
        Signal {
            knots: vec![Knot::line(time, size, 0.0)],
            ..Signal::default()
        }
    }

    /// `from` before the first instant, `to` after the second, a straight line between.
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

    /// One harmonic.
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

    /// Straight lines through points of rising time, constant before and after; two points of one time are a jump.
    ///
    /// # Errors
    /// Times that fall, or numbers that are not finite.
    pub fn table(points: &[(f64, f64)]) -> Result<Signal, Error> {
        let bad = |message: &str| {
            Err(Error::new(Code::OutOfRange, message)
                .with_hint("give time and value in rising order of time"))
        };
        if points.iter().any(|p| !p.0.is_finite() || !p.1.is_finite()) {
            return bad("a table over time holds a number that is not finite");
        }
        if points.windows(2).any(|p| p[1].0 < p[0].0) {
            return bad("the times of a table run backward");
        }
        let Some(first) = points.first() else {
            return bad("a table over time is empty");
        };
        let mut knots = vec![Knot::line(f64::NEG_INFINITY, first.1, 0.0)];
        for pair in points.windows(2) {
            let ((t, x), (u, y)) = (pair[0], pair[1]);
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

    /// Which knot carries the line at `t`, counted from one; zero before the first.
    pub fn piece(&self, t: f64) -> usize {
        self.knots.partition_point(|knot| knot.time <= t)
    }

    /// The value at `t` with the line of the piece `piece` (see [`Signal::piece`]) carried on.
    pub fn value(&self, t: f64, piece: usize) -> f64 {
        let line = match piece {
            0 => 0.0,
            at => self.knots[at - 1].value_at(t),
        };
        let harmonics = self.harmonics.iter();
        let harmonics = harmonics.map(|h| h.amplitude * (h.omega * t + h.phase).cos());
        line + harmonics.sum::<f64>() + self.bursts(t, piece, 0)
    }

    /// The sum of a derivative, by its order, of what lasts over a piece for a while.
    fn bursts(&self, t: f64, piece: usize, order: usize) -> f64 {
        if self.bursts.is_empty() {
            return 0.0;
        }
        let begins = piece
            .checked_sub(1)
            .map_or(f64::NEG_INFINITY, |at| self.knots[at].time);
        let lasting = self.bursts.iter().filter(|b| b.lasts(begins));
        lasting.map(|b| b.value_at(t)[order]).sum()
    }

    /// The derivative at `t` on the piece `piece`.
    pub fn slope(&self, t: f64, piece: usize) -> f64 {
        let line = match piece {
            0 => 0.0,
            at => self.knots[at - 1].slope_at(t),
        };
        line - self
            .harmonics
            .iter()
            .map(|h| h.amplitude * h.omega * (h.omega * t + h.phase).sin())
            .sum::<f64>()
            + self.bursts(t, piece, 1)
    }

    /// The second derivative at `t` on the piece `piece`.
    pub fn curvature(&self, t: f64, piece: usize) -> f64 {
        let line = match piece {
            0 => 0.0,
            at => self.knots[at - 1].curvature,
        };
        line - self
            .harmonics
            .iter()
            .map(|h| h.amplitude * h.omega * h.omega * (h.omega * t + h.phase).cos())
            .sum::<f64>()
            + self.bursts(t, piece, 2)
    }

    /// The first knot after `t`; ∞ where none comes.
    pub fn next_knot(&self, t: f64) -> f64 {
        self.knots
            .get(self.piece(t))
            .map_or(f64::INFINITY, |knot| knot.time)
    }

    /// This and another.
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
        let part = |signal: &Signal, time: f64| match signal.piece(time) {
            0 => [0.0; 3],
            at => {
                let (knot, t) = (
                    signal.knots[at - 1],
                    if time.is_finite() { time } else { 0.0 },
                );
                [knot.value_at(t), knot.slope_at(t), knot.curvature]
            }
        };
        let knot = |&time: &f64| {
            let (a, b) = (part(self, time), part(other, time));
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

    /// This times a number.
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

    /// Rate of the signal; jumps of the value leave nothing.
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

    /// Integral of the signal since time zero, of straight lines that always were and of harmonics that never end.
    #[must_use]
    pub fn integral(&self) -> Signal {
        let mut knots: Vec<Knot> = Vec::with_capacity(self.knots.len());
        for k in &self.knots {
            let value = knots.last().map_or(0.0, |before| before.value_at(k.time));
            knots.push(Knot {
                time: k.time,
                value,
                slope: k.value,
                curvature: k.slope,
            });
        }
        let swings = self.harmonics.iter().map(|h| Harmonic {
            amplitude: h.amplitude / h.omega,
            omega: h.omega,
            phase: h.phase - FRAC_PI_2,
        });
        let sum = Signal {
            knots,
            harmonics: swings.collect(),
            ..Signal::default()
        };
        let at_zero = sum.value(0.0, sum.piece(0.0));
        sum.plus(&Signal::constant(-at_zero))
    }

    /// Nothing but lines and harmonics that never end: no piece is a parabola.
    pub fn is_piecewise_linear(&self) -> bool {
        self.knots.iter().all(|k| k.curvature == 0.0) && self.bursts.is_empty()
    }

    /// The value or the rate jumps at a knot.
    pub fn has_kinks(&self) -> bool {
        let largest =
            |of: fn(&Knot) -> f64| self.knots.iter().fold(0.0f64, |m, k| m.max(of(k).abs()));
        let (value, slope) = (largest(|k| k.value), largest(|k| k.slope));
        self.knots.windows(2).any(|pair| {
            let t = pair[1].time;
            (pair[0].value_at(t) - pair[1].value).abs() > KINK * value
                || (pair[0].slope_at(t) - pair[1].slope).abs() > KINK * slope
        })
    }

    /// Zero at all times.
    pub fn is_zero(&self) -> bool {
        self.knots
            .iter()
            .all(|k| k.value == 0.0 && k.slope == 0.0 && k.curvature == 0.0)
            && self.harmonics.iter().all(|h| h.amplitude == 0.0)
            && self.bursts.is_empty()
    }
}
