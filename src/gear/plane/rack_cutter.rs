//! Rack cutters: the basic rack with rounded tip edges, lengths in modules.

use std::f64::consts::FRAC_PI_4;

use super::pitch_curve::out_of_range;
use crate::base::error::Error;

/// Rack cutter, lengths in modules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RackCutter {
    /// Pressure angle α, rad.
    pub pressure_angle: f64,
    /// Height of the gear's tips above its pitch curve.
    pub addendum: f64,
    /// Height of the rack's tips above its pitch line: the depth of the gear's roots.
    pub dedendum: f64,
    /// Radius of the rack's tip edges.
    pub tip_radius: f64,
}

impl Default for RackCutter {
    /// Basic rack profile A of ISO 53:1998.
    fn default() -> RackCutter {
        RackCutter {
            pressure_angle: 20_f64.to_radians(),
            addendum: 1.0,
            dedendum: 1.25,
            tip_radius: 0.38,
        }
    }
}

impl RackCutter {
    /// Refuses a cutter whose tip edges do not fit its tooth.
    ///
    /// # Errors
    /// `OutOfRange` with the largest tip radius.
    pub fn check(&self) -> Result<(), Error> {
        let cutter = self;
        let alpha = cutter.pressure_angle;
        if !(alpha > 0.0 && alpha < FRAC_PI_4) {
            return Err(out_of_range(format!(
                "pressure angle of the rack is {} deg; it must lie between 0 and 45 deg",
                alpha.to_degrees()
            )));
        }
        let heights = [cutter.addendum, cutter.dedendum, cutter.tip_radius];
        if !heights.iter().all(|h| *h >= 0.0 && h.is_finite()) {
            return Err(out_of_range(format!(
                "addendum, dedendum and tip radius of the rack are {heights:?} modules; none may be negative"
            )));
        }
        // Half width of the rack's tip: p/4 − h tan α − ρ (cos α − (1 − sin α) tan α) ≥ 0.
        let tip = FRAC_PI_4 - cutter.dedendum * alpha.tan();
        let taken = alpha.cos() - (1.0 - alpha.sin()) * alpha.tan();
        if !(tip >= cutter.tip_radius * taken) {
            return Err(out_of_range(format!(
                "tip edges of radius {} modules do not fit the tip of the rack, {:.4} modules wide",
                cutter.tip_radius,
                2.0 * tip
            ))
            .with_hint(format!(
                "take a tip radius of at most {:.4} modules",
                (tip / taken).max(0.0)
            )));
        }
        if cutter.tip_radius > cutter.dedendum {
            return Err(out_of_range(format!(
                "tip radius {} exceeds the dedendum {} of the rack, both in modules",
                cutter.tip_radius, cutter.dedendum
            )));
        }
        Ok(())
    }
}
