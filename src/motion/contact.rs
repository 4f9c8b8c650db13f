//! Contact law with backlash: contact states, force `F = c₀ + k δ + c δ̇`, switching functions.
//!
//! Every stand is affine in the deflection δ and its rate, and so is every switching surface: between two switches a contact is
//! linear.

pub use crate::scene::laws::ContactDamping;

/// A force or a switching surface: `constant + deflection δ + rate δ̇`.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Affine {
    /// At rest in the middle.
    pub constant: f64,
    /// Per deflection.
    pub deflection: f64,
    /// Per rate of deflection.
    pub rate: f64,
}

impl Affine {
    /// Value of the affine function.
    pub fn value_at(&self, delta: f64, rate: f64) -> f64 {
        self.constant + self.deflection * delta + self.rate * rate
    }
}

/// Teeth, splines or dogs that touch beyond half their play on either side.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactLaw {
    /// k, N/m or N·m/rad; its wave, if any, is a factor.
    pub stiffness: f64,
    /// c, N·s/m or N·m·s/rad.
    pub damping: f64,
    /// Half the play; zero: always closed.
    pub half_play: f64,
    /// Damper behaviour where the contact opens and closes.
    pub contact_damping: ContactDamping,
    /// Which flanks can touch.
    pub flanks: ActiveFlanks,
}

/// Which flanks can touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ActiveFlanks {
    /// Either.
    Both,
    /// Only δ > 0.
    Drive,
    /// Only δ < 0.
    Coast,
}

/// A flank: the sign of δ where it touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Flank {
    /// δ > 0.
    Drive,
    /// δ < 0.
    Coast,
}

impl Flank {
    /// +1 or −1.
    pub fn sign(self) -> f64 {
        match self {
            Flank::Drive => 1.0,
            Flank::Coast => -1.0,
        }
    }
}

/// State of a contact with play: open, or closed on a flank.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum ContactState {
    /// In the gap.
    Open,
    /// Touching, with its whole law.
    Closed(Flank),
    /// Touching, with the damper held to the force of the spring.
    DamperLimited(Flank),
    /// The bodies still overlap, but the flank has let go.
    Released(Flank),
}

impl ContactLaw {
    /// Whether it can open at all.
    pub fn can_open(&self) -> bool {
        self.half_play > 0.0 || self.flanks != ActiveFlanks::Both
    }

    /// Contact state at a deflection and rate; `factor` is the secant stiffness there over that of the law.
    pub fn state(&self, delta: f64, rate: f64, factor: f64) -> ContactState {
        if !self.can_open() {
            return ContactState::Closed(Flank::Drive);
        }
        let flank = if delta > self.half_play && self.flanks != ActiveFlanks::Coast {
            Flank::Drive
        } else if delta < -self.half_play && self.flanks != ActiveFlanks::Drive {
            Flank::Coast
        } else {
            return ContactState::Open;
        };
        self.state_on_flank(flank, delta, rate, factor)
    }

    /// Contact state on a flank that overlaps.
    fn state_on_flank(&self, flank: Flank, delta: f64, rate: f64, factor: f64) -> ContactState {
        let s = flank.sign();
        let spring = factor * self.stiffness * (s * delta - self.half_play);
        let damper = self.damping * s * rate;
        match self.damping_convention() {
            ContactDamping::ActsInGap | ContactDamping::Adhesive => ContactState::Closed(flank),
            _ if spring + damper < 0.0 => ContactState::Released(flank),
            ContactDamping::Continuous if damper > spring => ContactState::DamperLimited(flank),
            ContactDamping::NoPull | ContactDamping::Continuous => ContactState::Closed(flank),
        }
    }

    /// Contact state on touching `flank` from the gap.
    pub fn state_at_impact(&self, flank: Flank) -> ContactState {
        match self.damping_convention() {
            ContactDamping::Continuous => ContactState::DamperLimited(flank),
            _ => ContactState::Closed(flank),
        }
    }

    /// Without a damper all conventions are one.
    fn damping_convention(&self) -> ContactDamping {
        match self.damping {
            0.0 => ContactDamping::Adhesive,
            _ => self.contact_damping,
        }
    }

    /// Contact force in a state; `factor` is the secant stiffness over that of the law.
    pub fn force(&self, state: ContactState, factor: f64) -> Affine {
        let k = factor * self.stiffness;
        let gap_damping = if self.damping_convention() == ContactDamping::ActsInGap {
            self.damping
        } else {
            0.0
        };
        if !self.can_open() {
            return Affine {
                constant: 0.0,
                deflection: k,
                rate: self.damping,
            };
        }
        match state {
            ContactState::Open => Affine {
                rate: gap_damping,
                ..Affine::default()
            },
            ContactState::Released(_) => Affine::default(),
            ContactState::Closed(flank) => Affine {
                constant: -k * flank.sign() * self.half_play,
                deflection: k,
                rate: self.damping,
            },
            ContactState::DamperLimited(flank) => Affine {
                constant: -2.0 * k * flank.sign() * self.half_play,
                deflection: 2.0 * k,
                rate: 0.0,
            },
        }
    }

    /// g: the deflection beyond the play.
    pub fn penetration(&self, state: ContactState, delta: f64) -> f64 {
        if !self.can_open() {
            return delta;
        }
        match state {
            ContactState::Open => 0.0,
            ContactState::Closed(flank)
            | ContactState::DamperLimited(flank)
            | ContactState::Released(flank) => delta - flank.sign() * self.half_play,
        }
    }

    /// Switching functions of a contact state: it holds while all are above zero, and changes to the state across the first that is not.
    pub fn switching_functions(
        &self,
        state: ContactState,
        factor: f64,
    ) -> Vec<(Affine, ContactState)> {
        if !self.can_open() {
            return Vec::new();
        }
        let k = factor * self.stiffness;
        let apart = |flank: Flank| Affine {
            constant: -self.half_play,
            deflection: flank.sign(),
            rate: 0.0,
        };
        let within = |flank: Flank| Affine {
            constant: self.half_play,
            deflection: -flank.sign(),
            rate: 0.0,
        };
        let sum = |flank: Flank, sign: f64| Affine {
            constant: -sign * k * self.half_play,
            deflection: sign * k * flank.sign(),
            rate: sign * self.damping * flank.sign(),
        };
        let surplus = |flank: Flank, sign: f64| Affine {
            constant: -sign * k * self.half_play,
            deflection: sign * k * flank.sign(),
            rate: -sign * self.damping * flank.sign(),
        };
        match (state, self.damping_convention()) {
            (ContactState::Open, _) => {
                let mut all = Vec::new();
                if self.flanks != ActiveFlanks::Coast {
                    all.push((within(Flank::Drive), self.state_at_impact(Flank::Drive)));
                }
                if self.flanks != ActiveFlanks::Drive {
                    all.push((within(Flank::Coast), self.state_at_impact(Flank::Coast)));
                }
                all
            }
            (ContactState::Closed(flank), ContactDamping::ActsInGap | ContactDamping::Adhesive) => {
                vec![(apart(flank), ContactState::Open)]
            }
            (ContactState::Closed(flank), ContactDamping::NoPull) => vec![
                (sum(flank, 1.0), ContactState::Released(flank)),
                (apart(flank), ContactState::Open),
            ],
            (ContactState::Closed(flank), ContactDamping::Continuous) => {
                vec![
                    (sum(flank, 1.0), ContactState::Released(flank)),
                    (surplus(flank, 1.0), ContactState::DamperLimited(flank)),
                ]
            }
            (ContactState::DamperLimited(flank), _) => vec![
                (surplus(flank, -1.0), ContactState::Closed(flank)),
                (apart(flank), ContactState::Open),
            ],
            (ContactState::Released(flank), _) => vec![
                (sum(flank, -1.0), ContactState::Closed(flank)),
                (apart(flank), ContactState::Open),
            ],
        }
    }
}
