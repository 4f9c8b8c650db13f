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

/// Largest modification, modules: usual ones are a fiftieth, and a flank that loses more has no involute left to speak of.
const LARGEST_AMOUNT: f64 = 0.1;

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
    /// `OutOfRange`: an amount that is not finite or beyond a tenth of the module (m), a relief that begins off the flank of lengths of roll
    /// `ends`, a root relief that begins beyond the tip relief.
    pub fn check(&self, ends: [f64; 2], module: f64) -> Result<(), Error> {
        let [root, tip] = ends;
        let amount_of = |relief: Option<Relief>| relief.map_or(0.0, |relief| relief.amount);
        let amounts = [
            ("tip_relief", amount_of(self.tip_relief)),
            ("root_relief", amount_of(self.root_relief)),
            ("profile_crowning", self.profile_crowning),
            ("crowning", self.helix_crowning),
            ("helix_slope", self.helix_slope),
        ];
        for (key, amount) in amounts {
            if !(amount.abs() <= LARGEST_AMOUNT * module) {
                let (name, most) = (key.replace('_', " "), LARGEST_AMOUNT * module);
                let [amount, most] = [amount, most].map(|x| format_number(1e6 * x));
                let message = format!("{name} of {amount} µm exceeds a tenth of the module");
                let error = Error::new(Code::OutOfRange, message).with_key(key);
                return Err(error.with_hint(format!("give at most {most} µm")));
            }
        }
        let reliefs = [
            ("tip_relief", "relief_from", self.tip_relief, tip),
            ("root_relief", "root_relief_from", self.root_relief, root),
        ];
        for (name, key, relief, end) in reliefs {
            let Some(Relief { amount, from }) = relief else {
                continue;
            };
            if !((from - root) * (from - tip) <= 0.0 && from != end) {
                let name = name.replace('_', " ");
                let [amount, from, root, tip] = [1e6 * amount, 1e3 * from, 1e3 * root, 1e3 * tip];
                let message = format!(
                    "{name} of {amount:.3} µm begins at a length of roll of {from:.4} mm; the flank reaches from {root:.4} to {tip:.4} mm"
                );
                return Err(Error::new(Code::OutOfRange, message)
                    .with_key(key)
                    .with_hint("give a length of roll on the flank"));
            }
        }
        if let (Some(at_tip), Some(at_root)) = (self.tip_relief, self.root_relief)
            && (at_root.from - at_tip.from) * (tip - root) > 0.0
        {
            let [at_tip, at_root] = [at_tip.from, at_root.from].map(|x| format_number(1e3 * x));
            let message = format!(
                "root relief begins at a length of roll of {at_root} mm, beyond the start of tip relief ({at_tip} mm)"
            );
            return Err(Error::new(Code::OutOfRange, message)
                .with_key("root_relief_from")
                .with_hint("start both at the same place, or root relief nearer to the root"));
        }
        Ok(())
    }
}
