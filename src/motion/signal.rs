//! A known function of time: straight pieces with jumps, and harmonics that never end.

use crate::base::code::Code;
use crate::base::error::Error;

/// `x(t)`: the last knot at or before t carries a straight line; harmonics add to it.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Signal {
    /// By rising time. Before the first one the value is zero.
    pub knots: Vec<Knot>,
    /// `Σ a cos(ω t + φ)`, everlasting.
    pub harmonics: Vec<Harmonic>,
}

/// From `time` on the signal is `value + slope (t − time)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Knot {
    /// s; −∞ for what always was so.
    pub time: f64,
    /// Value at the knot (or at time zero where the knot lies at −∞).
    pub value: f64,
    /// Its change per second.
    pub slope: f64,
}

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
    /// Its line at `t`.
    pub fn line(&self, t: f64) -> f64 {
        match self.slope {
            0.0 => self.value,
            slope if self.time.is_finite() => self.value + slope * (t - self.time),
            slope => self.value + slope * t,
        }
    }
}

impl Signal {
    /// The same at all times.
    pub fn constant(value: f64) -> Signal {
        Signal {
            knots: vec![Knot {
                time: f64::NEG_INFINITY,
                value,
                slope: 0.0,
            }],
            harmonics: Vec::new(),
        }
    }

    /// Zero before `time`, `size` from then on.
    pub fn step(size: f64, time: f64) -> Signal {
        Signal {
            knots: vec![Knot {
                time,
                value: size,
                slope: 0.0,
            }],
            harmonics: Vec::new(),
        }
    }

    /// `from` before the first instant, `to` after the second, a straight line between.
    pub fn ramp(from: f64, to: f64, [start, end]: [f64; 2]) -> Signal {
        let slope = (to - from) / (end - start);
        let knots = vec![
            Knot {
                time: f64::NEG_INFINITY,
                value: from,
                slope: 0.0,
            },
            Knot {
                time: start,
                value: from,
                slope,
            },
            Knot {
                time: end,
                value: to,
                slope: 0.0,
            },
        ];
        Signal {
            knots,
            harmonics: Vec::new(),
        }
    }

    /// One harmonic.
    pub fn harmonic(amplitude: f64, omega: f64, phase: f64) -> Signal {
        Signal {
            knots: Vec::new(),
            harmonics: vec![Harmonic {
                amplitude,
                omega,
                phase,
            }],
        }
    }

    /// Straight lines through points of rising time, constant before and after; two points of one time are a jump.
    ///
    /// # Errors
    /// Times that fall, or numbers that are not finite.
    pub fn table(points: &[(f64, f64)]) -> Result<Signal, Error> {
        let bad = |message: &str| {
            Err(Error::new(Code::OutOfRange, message)
                .hint("give time and value in rising order of time"))
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
        let mut knots = vec![Knot {
            time: f64::NEG_INFINITY,
            value: first.1,
            slope: 0.0,
        }];
        for pair in points.windows(2) {
            let ((t, x), (u, y)) = (pair[0], pair[1]);
            if u > t {
                knots.push(Knot {
                    time: t,
                    value: x,
                    slope: (y - x) / (u - t),
                });
            }
        }
        if let Some(&(time, value)) = points.last() {
            knots.push(Knot {
                time,
                value,
                slope: 0.0,
            });
        }
        Ok(Signal {
            knots,
            harmonics: Vec::new(),
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
            at => self.knots[at - 1].line(t),
        };
        line + self
            .harmonics
            .iter()
            .map(|h| h.amplitude * (h.omega * t + h.phase).cos())
            .sum::<f64>()
    }

    /// The derivative at `t` on the piece `piece`.
    pub fn slope(&self, t: f64, piece: usize) -> f64 {
        let line = match piece {
            0 => 0.0,
            at => self.knots[at - 1].slope,
        };
        line - self
            .harmonics
            .iter()
            .map(|h| h.amplitude * h.omega * (h.omega * t + h.phase).sin())
            .sum::<f64>()
    }

    /// The second derivative at `t`, between knots.
    pub fn curvature(&self, t: f64) -> f64 {
        -self
            .harmonics
            .iter()
            .map(|h| h.amplitude * h.omega * h.omega * (h.omega * t + h.phase).cos())
            .sum::<f64>()
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
            0 => (0.0, 0.0),
            at => (
                signal.knots[at - 1].line(if time.is_finite() { time } else { 0.0 }),
                signal.knots[at - 1].slope,
            ),
        };
        let knot = |&time: &f64| {
            let (a, b) = (part(self, time), part(other, time));
            Knot {
                time,
                value: a.0 + b.0,
                slope: a.1 + b.1,
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
        }
    }

    /// This times a number.
    #[must_use]
    pub fn times(&self, factor: f64) -> Signal {
        let knots = self.knots.iter().map(|k| Knot {
            value: factor * k.value,
            slope: factor * k.slope,
            ..*k
        });
        let harmonics = self.harmonics.iter().map(|h| Harmonic {
            amplitude: factor * h.amplitude,
            ..*h
        });
        Signal {
            knots: knots.collect(),
            harmonics: harmonics.collect(),
        }
    }

    /// Zero at all times.
    pub fn is_zero(&self) -> bool {
        self.knots.iter().all(|k| k.value == 0.0 && k.slope == 0.0)
            && self.harmonics.iter().all(|h| h.amplitude == 0.0)
    }
}
