//! Dry friction on a deflection's rate: Coulomb's law with a breakaway force and Stribeck's fall between them.

pub use crate::scene::laws::Friction;

/// How a friction pair stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Slip {
    /// δ̇ > 0.
    Forward,
    /// δ̇ < 0.
    Backward,
    /// δ̇ = 0, held by any force up to the breakaway force.
    Stick,
}

impl Slip {
    /// The sign of δ̇.
    pub fn sign(self) -> f64 {
        match self {
            Slip::Forward => 1.0,
            Slip::Backward => -1.0,
            Slip::Stick => 0.0,
        }
    }
}

impl Friction {
    /// The force while sliding in the sense of `slip`, carried on smoothly beyond δ̇ = 0.
    pub fn sliding(&self, slip: Slip, rate: f64) -> f64 {
        slip.sign() * (self.sliding + (self.breakaway - self.sliding) * self.fall(rate))
    }

    /// dF/dδ̇ while sliding.
    pub fn slope(&self, slip: Slip, rate: f64) -> f64 {
        match self.is_coulomb() {
            true => 0.0,
            false => {
                -slip.sign() * (self.breakaway - self.sliding) * self.fall(rate) * 2.0 * rate
                    / (self.stribeck * self.stribeck)
            }
        }
    }

    /// The same at a share of its capacity.
    pub fn gripped(&self, share: f64) -> Friction {
        let share = share.max(0.0);
        Friction {
            sliding: share * self.sliding,
            breakaway: share * self.breakaway,
            ..*self
        }
    }

    fn fall(&self, rate: f64) -> f64 {
        match self.is_coulomb() {
            true => 0.0,
            false => (-(rate / self.stribeck).powi(2)).exp(),
        }
    }

    /// Sliding costs the same force at every rate: piecewise linear.
    pub fn is_coulomb(&self) -> bool {
        self.breakaway == self.sliding
    }

    /// The law with its step spread over the creep speed, `tanh(δ̇/creep)`, for methods without events; and its derivative.
    pub fn smoothed(&self, rate: f64) -> (f64, f64) {
        let step = (rate / self.creep).tanh();
        let size = self.sliding(Slip::Forward, rate);
        let slope =
            (1.0 - step * step) / self.creep * size + step * self.slope(Slip::Forward, rate);
        (step * size, slope)
    }
}
