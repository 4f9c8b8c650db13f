//! A contact with play: where it stands, what it carries there, and at which borders it changes.
//!
//! Every stand is affine in the deflection δ and its rate, and so is every border: between two switches a contact is linear.

pub use crate::scene::laws::Losses;

/// A force or a border: `constant + deflection δ + rate δ̇`.
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
    /// Its value.
    pub fn at(&self, delta: f64, rate: f64) -> f64 {
        self.constant + self.deflection * delta + self.rate * rate
    }
}

/// Teeth, splines or dogs that touch beyond half their play on either side.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// k, N/m or N·m/rad; its wave, if any, is a factor.
    pub stiffness: f64,
    /// c, N·s/m or N·m·s/rad.
    pub damping: f64,
    /// Half the play; zero: always closed.
    pub half: f64,
    /// What the damper does where the contact opens and closes.
    pub losses: Losses,
    /// Which flanks can touch.
    pub flanks: Flanks,
}

/// Which flanks can touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Flanks {
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

/// How a contact stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Stand {
    /// In the gap.
    Open,
    /// Touching, with its whole law.
    Closed(Flank),
    /// Touching, with the damper held to the force of the spring.
    Limited(Flank),
    /// The bodies still overlap, but the flank has let go.
    Free(Flank),
}

impl Contact {
    /// Whether it can open at all.
    pub fn opens(&self) -> bool {
        self.half > 0.0 || self.flanks != Flanks::Both
    }

    /// Where it stands at a deflection and rate; `factor` is the value of its stiffness wave.
    pub fn stand(&self, delta: f64, rate: f64, factor: f64) -> Stand {
        if !self.opens() {
            return Stand::Closed(Flank::Drive);
        }
        let flank = if delta > self.half && self.flanks != Flanks::Coast {
            Flank::Drive
        } else if delta < -self.half && self.flanks != Flanks::Drive {
            Flank::Coast
        } else {
            return Stand::Open;
        };
        self.touching(flank, delta, rate, factor)
    }

    /// The stand on a flank that overlaps.
    fn touching(&self, flank: Flank, delta: f64, rate: f64, factor: f64) -> Stand {
        let s = flank.sign();
        let spring = factor * self.stiffness * (s * delta - self.half);
        let damper = self.damping * s * rate;
        match self.law() {
            Losses::Throughout | Losses::Adhesive => Stand::Closed(flank),
            _ if spring + damper < 0.0 => Stand::Free(flank),
            Losses::Continuous if damper > spring => Stand::Limited(flank),
            Losses::NoPull | Losses::Continuous => Stand::Closed(flank),
        }
    }

    /// The stand on touching `flank` from the gap.
    pub fn touched(&self, flank: Flank) -> Stand {
        match self.law() {
            Losses::Continuous => Stand::Limited(flank),
            _ => Stand::Closed(flank),
        }
    }

    /// Without a damper all conventions are one.
    fn law(&self) -> Losses {
        match self.damping {
            0.0 => Losses::Adhesive,
            _ => self.losses,
        }
    }

    /// What it carries.
    pub fn force(&self, stand: Stand, factor: f64) -> Affine {
        let k = factor * self.stiffness;
        let gap_damping = if self.law() == Losses::Throughout {
            self.damping
        } else {
            0.0
        };
        if !self.opens() {
            return Affine {
                constant: 0.0,
                deflection: k,
                rate: self.damping,
            };
        }
        match stand {
            Stand::Open => Affine {
                rate: gap_damping,
                ..Affine::default()
            },
            Stand::Free(_) => Affine::default(),
            Stand::Closed(flank) => Affine {
                constant: -k * flank.sign() * self.half,
                deflection: k,
                rate: self.damping,
            },
            Stand::Limited(flank) => Affine {
                constant: -2.0 * k * flank.sign() * self.half,
                deflection: 2.0 * k,
                rate: 0.0,
            },
        }
    }

    /// The potential energy beyond the play.
    pub fn stored(&self, stand: Stand, factor: f64, delta: f64) -> f64 {
        let beyond = self.beyond(stand, delta);
        match stand {
            Stand::Open => 0.0,
            _ => 0.5 * factor * self.stiffness * beyond * beyond,
        }
    }

    /// g: the deflection beyond the play.
    pub fn beyond(&self, stand: Stand, delta: f64) -> f64 {
        if !self.opens() {
            return delta;
        }
        match stand {
            Stand::Open => 0.0,
            Stand::Closed(flank) | Stand::Limited(flank) | Stand::Free(flank) => {
                delta - flank.sign() * self.half
            }
        }
    }

    /// The borders of a stand: it holds while all are above zero, and gives way to the stand beside the first that is not.
    pub fn borders(&self, stand: Stand, factor: f64) -> Vec<(Affine, Stand)> {
        if !self.opens() {
            return Vec::new();
        }
        let k = factor * self.stiffness;
        let apart = |flank: Flank| Affine {
            constant: -self.half,
            deflection: flank.sign(),
            rate: 0.0,
        };
        let within = |flank: Flank| Affine {
            constant: self.half,
            deflection: -flank.sign(),
            rate: 0.0,
        };
        let sum = |flank: Flank, sign: f64| Affine {
            constant: -sign * k * self.half,
            deflection: sign * k * flank.sign(),
            rate: sign * self.damping * flank.sign(),
        };
        let surplus = |flank: Flank, sign: f64| Affine {
            constant: -sign * k * self.half,
            deflection: sign * k * flank.sign(),
            rate: -sign * self.damping * flank.sign(),
        };
        match (stand, self.law()) {
            (Stand::Open, _) => {
                let mut all = Vec::new();
                if self.flanks != Flanks::Coast {
                    all.push((within(Flank::Drive), self.touched(Flank::Drive)));
                }
                if self.flanks != Flanks::Drive {
                    all.push((within(Flank::Coast), self.touched(Flank::Coast)));
                }
                all
            }
            (Stand::Closed(flank), Losses::Throughout | Losses::Adhesive) => {
                vec![(apart(flank), Stand::Open)]
            }
            (Stand::Closed(flank), Losses::NoPull) => vec![
                (sum(flank, 1.0), Stand::Free(flank)),
                (apart(flank), Stand::Open),
            ],
            (Stand::Closed(flank), Losses::Continuous) => {
                vec![
                    (sum(flank, 1.0), Stand::Free(flank)),
                    (surplus(flank, 1.0), Stand::Limited(flank)),
                ]
            }
            (Stand::Limited(flank), _) => vec![
                (surplus(flank, -1.0), Stand::Closed(flank)),
                (apart(flank), Stand::Open),
            ],
            (Stand::Free(flank), _) => vec![
                (sum(flank, -1.0), Stand::Closed(flank)),
                (apart(flank), Stand::Open),
            ],
        }
    }
}
