//! Dry friction: Coulomb's law with a breakaway force and the Stribeck effect.

pub use crate::scene::laws::FrictionLaw;

/// State of a friction pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum FrictionState {
    /// δ̇ > 0.
    Forward,
    /// δ̇ < 0.
    Backward,
    /// δ̇ = 0, held by any force up to the breakaway force.
    Stick,
}

impl FrictionState {
    /// The sign of δ̇.
    pub fn sign(self) -> f64 {
        match self {
            FrictionState::Forward => 1.0,
            FrictionState::Backward => -1.0,
            FrictionState::Stick => 0.0,
        }
    }
}

impl FrictionLaw {
    /// The force while sliding in the sense of `slip`, carried on smoothly beyond δ̇ = 0.
    pub fn sliding_force(&self, slip: FrictionState, rate: f64) -> f64 {
        slip.sign() * self.size(self.stribeck_velocity, rate).0
    }

    /// dF/dδ̇ while sliding.
    pub fn slope(&self, slip: FrictionState, rate: f64) -> f64 {
        slip.sign() * self.size(self.stribeck_velocity, rate).1
    }

    /// The size of the force while sliding, falling over a speed, and its derivative to δ̇.
    fn size(&self, over: f64, rate: f64) -> (f64, f64) {
        let more = self.breakaway - self.sliding;
        if more == 0.0 || over == 0.0 {
            return (self.sliding, 0.0);
        }
        let fall = (-(rate / over).powi(2)).exp();
        let slope = -more * fall * 2.0 * rate / (over * over);
        (self.sliding + more * fall, slope)
    }

    /// The same at a share of its capacity.
    pub fn scaled(&self, share: f64) -> FrictionLaw {
        let share = share.max(0.0);
        FrictionLaw {
            sliding: share * self.sliding,
            breakaway: share * self.breakaway,
            ..*self
        }
    }

    /// Sliding costs the same force at every rate: piecewise linear.
    pub fn is_coulomb(&self) -> bool {
        self.breakaway == self.sliding || self.stribeck_velocity == 0.0
    }

    /// The law with its step spread over the creep speed, `tanh(δ̇/regularisation_velocity)`, for methods without events; and its derivative. A force
    /// that falls at once falls over ten creep speeds here, so that the pair still holds nearly its breakaway force.
    pub fn regularised(&self, rate: f64) -> (f64, f64) {
        let over = match self.stribeck_velocity > 0.0 {
            true => self.stribeck_velocity,
            false => FALL * self.regularisation_velocity,
        };
        let step = (rate / self.regularisation_velocity).tanh();
        let (size, fall) = self.size(over, rate);
        let slope = (1.0 - step * step) / self.regularisation_velocity * size + step * fall;
        (step * size, slope)
    }
}

/// The largest smoothed force is then 0.98 F_s at F_s = 1.2 F_c, 0.96 at twice and 0.94 at five times F_c.
const FALL: f64 = 10.0;
