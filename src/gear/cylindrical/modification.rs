//! Designed modifications of a flank: tip and root relief, profile and helix crowning, helix slope, as material removed along the normal
//! (ISO 21771-1:2024).
//!
//! A profile lies along the length of roll, a helix along the face width.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_number;

/// One modification along a profile or a helix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Modification {
    /// Grows linearly from `from` to `amount` at `to`, as at a tip (`to` above `from`) or a root (below).
    Relief {
        /// Start of the modification.
        from: f64,
        /// Place of the largest amount.
        to: f64,
        /// Amount at that place.
        amount: f64,
    },
    /// A parabola: nothing in the middle of `from` and `to`, `amount` off at both.
    Crowning {
        /// One end.
        from: f64,
        /// The other.
        to: f64,
        /// Amount at that place.
        amount: f64,
    },
}

impl Modification {
    /// The design's deviation from the plain flank at `x`.
    pub fn deviation_at(self, x: f64) -> f64 {
        match self {
            Modification::Relief { from, to, amount } => {
                -amount * ((x - from) / (to - from)).clamp(0.0, 1.0)
            }
            Modification::Crowning { from, to, amount } => {
                let u = (2.0 * x - from - to) / (to - from);
                -amount * u * u
            }
        }
    }
}

/// Relief that grows linearly along the length of roll to an end of the flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relief {
    /// Material removed at the end of the flank, m.
    pub amount: f64,
    /// Length of roll at which the relief begins, m.
    pub from: f64,
}

/// The modifications of a flank; by default none.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FlankModification {
    /// Tip relief C_αa.
    pub tip_relief: Option<Relief>,
    /// Root relief C_αf.
    pub root_relief: Option<Relief>,
    /// Profile crowning C_α at both ends of the flank, m.
    pub profile_crowning: f64,
    /// Helix crowning C_β at both ends of the face, m.
    pub helix_crowning: f64,
    /// Helix slope: material removed at the far end of the face, m; the near one keeps it. A negative slope leaves material there. The far
    /// end is that to which the axis of the driving pinion points, about which it turns by the right hand.
    pub helix_slope: f64,
}

impl FlankModification {
    /// Material removed at a length of roll and at a share of the face width from its near end, m. `ends` are the lengths of roll at the form and at the
    /// tip diameter.
    pub fn removed(&self, roll: f64, ends: [f64; 2], face: f64) -> f64 {
        let [root, tip] = ends;
        let relief = |relief: Option<Relief>, to: f64| {
            relief.map(|Relief { amount, from }| {
                Modification::Relief { from, to, amount }.deviation_at(roll)
            })
        };
        let crowning = |amount: f64, [from, to]: [f64; 2], x: f64| {
            Modification::Crowning { from, to, amount }.deviation_at(x)
        };
        let deviation = relief(self.tip_relief, tip).unwrap_or(0.0)
            + relief(self.root_relief, root).unwrap_or(0.0)
            + crowning(self.profile_crowning, ends, roll)
            + crowning(self.helix_crowning, [0.0, 1.0], face);
        self.helix_slope * face - deviation
    }

    /// # Errors
    /// `OutOfRange`: an amount that is not finite, or a relief that begins off the flank of lengths of roll `ends`.
    pub fn check(&self, ends: [f64; 2]) -> Result<(), Error> {
        let [root, tip] = ends;
        let reliefs = [
            ("tip relief", self.tip_relief, tip),
            ("root relief", self.root_relief, root),
        ];
        for (name, relief, end) in reliefs {
            let Some(Relief { amount, from }) = relief else {
                continue;
            };
            if !(amount.is_finite() && (from - root) * (from - tip) <= 0.0 && from != end) {
                let [amount, from, root, tip] = [1e6 * amount, 1e3 * from, 1e3 * root, 1e3 * tip];
                let message = format!(
                    "{name} of {amount:.3} µm begins at a length of roll of {from:.4} mm; the flank reaches from {root:.4} to {tip:.4} mm"
                );
                return Err(Error::new(Code::OutOfRange, message)
                    .with_hint("give a length of roll on the flank"));
            }
        }
        let amounts = [self.profile_crowning, self.helix_crowning, self.helix_slope];
        match amounts.iter().find(|amount| !amount.is_finite()) {
            None => Ok(()),
            Some(amount) => {
                let message = format!(
                    "a modification of a flank is {} µm; it is finite",
                    format_number(1e6 * amount)
                );
                Err(Error::new(Code::OutOfRange, message))
            }
        }
    }
}
