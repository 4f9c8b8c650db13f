//! A harmonic that begins and ends: `(a + b τ) cos(ω t + φ)` from one instant to another, τ the time since the first.

use std::f64::consts::FRAC_PI_2;

/// See the module.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Burst {
    /// From this instant, s; −∞ for what always was so.
    pub from: f64,
    /// To this one, s; ∞ for what never ends.
    pub to: f64,
    /// Amplitude at the first instant, at time zero where that lies at −∞.
    pub amplitude: f64,
    /// Growth of the amplitude per second.
    pub growth: f64,
    /// rad/s.
    pub omega: f64,
    /// rad.
    pub phase: f64,
}

impl Burst {
    /// It lasts over the piece of a signal that begins at `time`.
    pub fn lasts(&self, time: f64) -> bool {
        self.from <= time && time < self.to
    }

    fn size(&self, t: f64) -> f64 {
        match self.from.is_finite() {
            true => self.amplitude + self.growth * (t - self.from),
            false => self.amplitude + self.growth * t,
        }
    }

    /// Value, slope and second derivative at `t`, carried on beyond both ends.
    pub fn value_at(&self, t: f64) -> [f64; 3] {
        let (size, omega) = (self.size(t), self.omega);
        let (sin, cos) = (omega * t + self.phase).sin_cos();
        [
            size * cos,
            self.growth * cos - size * omega * sin,
            -2.0 * self.growth * omega * sin - size * omega * omega * cos,
        ]
    }

    /// The largest size between two instants.
    pub fn largest(&self, [from, to]: [f64; 2]) -> f64 {
        let (from, to) = (self.from.max(from), self.to.min(to));
        match from < to {
            true => self.size(from).abs().max(self.size(to).abs()),
            false => 0.0,
        }
    }

    /// This times a number.
    #[must_use]
    pub fn times(&self, factor: f64) -> Burst {
        Burst {
            amplitude: factor * self.amplitude,
            growth: factor * self.growth,
            ..*self
        }
    }

    /// Rate of the burst: two bursts.
    pub fn rate(&self) -> [Burst; 2] {
        let grown = Burst {
            amplitude: self.growth,
            growth: 0.0,
            ..*self
        };
        let turned = Burst {
            phase: self.phase + FRAC_PI_2,
            ..self.times(self.omega)
        };
        [grown, turned]
    }
}
