//! Designed modifications of a flank as material removed from the involute helicoid, along its normal in the transverse section.
//!
//! Tip relief `C_αa (L − L_a)/(L_tip − L_a)` over the length of roll L, root relief likewise, profile crowning and helix crowning as
//! parabolas, helix slope as a line (ISO 21771-1:2024, clause 8).

use crate::base::code::Code;
use crate::base::error::Error;

/// Relief that grows in a line along the length of roll to an end of the flank.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Relief {
    /// Material removed at the end of the flank, m.
    pub amount: f64,
    /// Length of roll at which the relief begins, m.
    pub from: f64,
}

/// Modifications of both flanks of a gear.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Modification {
    /// Tip relief C_αa.
    pub tip_relief: Option<Relief>,
    /// Root relief C_αf.
    pub root_relief: Option<Relief>,
    /// Profile crowning C_α at both ends of the flank, m.
    pub profile_crowning: f64,
    /// Helix crowning C_β at both ends of the face, m.
    pub helix_crowning: f64,
    /// Helix slope: material removed at the face that leaves mesh last, m; the other keeps it. Negative turns the slope about.
    pub helix_slope: f64,
}

impl Modification {
    /// Material removed at a length of roll and at a share of the face width, 0 where the teeth enter mesh, 1 where they leave it, m.
    ///
    /// `ends` are the lengths of roll at the form and at the tip diameter.
    pub fn removed(&self, roll: f64, ends: [f64; 2], face: f64) -> f64 {
        let [root, tip] = ends;
        let relief = |relief: &Option<Relief>, end: f64| {
            relief.map_or(0.0, |r| {
                r.amount * ((roll - r.from) / (end - r.from)).clamp(0.0, 1.0)
            })
        };
        let across = 2.0 * (roll - root) / (tip - root) - 1.0;
        let along = 2.0 * face - 1.0;
        relief(&self.tip_relief, tip)
            + relief(&self.root_relief, root)
            + self.profile_crowning * across * across
            + self.helix_crowning * along * along
            + self.helix_slope * face
    }

    /// # Errors
    /// `OutOfRange`: an amount that is not finite, or a relief that begins off the flank of lengths of roll `ends`.
    pub fn check(&self, ends: [f64; 2]) -> Result<(), Error> {
        let [root, tip] = ends;
        for (name, relief, end) in [
            ("tip relief", &self.tip_relief, tip),
            ("root relief", &self.root_relief, root),
        ] {
            let Some(Relief { amount, from }) = relief else {
                continue;
            };
            let inside = (from - root) * (from - tip) <= 0.0 && *from != end;
            if !(amount.is_finite() && inside) {
                let message = format!(
                    "{name} of {:.3} µm begins at a length of roll of {:.4} mm; the flank reaches from {:.4} to {:.4} mm",
                    1e6 * amount,
                    1e3 * from,
                    1e3 * root,
                    1e3 * tip
                );
                return Err(Error::new(Code::OutOfRange, message)
                    .with_hint("give a length of roll on the flank"));
            }
        }
        let amounts = [self.profile_crowning, self.helix_crowning, self.helix_slope];
        match amounts.iter().find(|a| !a.is_finite()) {
            None => Ok(()),
            Some(amount) => {
                let message = format!("a modification of a flank is {amount} m; it is finite");
                Err(Error::new(Code::OutOfRange, message))
            }
        }
    }
}
