//! Backlash: at the working circles `j_wt = p_wt − s_wt1 − s_wt2`, normal `j_bn = j_wt cos α_wt cos β_b`, radial `j_r = j_wt/(2 tan α_wt)`
//! (ISO 21771-2:2025).

use std::f64::consts::TAU;

use super::pair::Pair;

/// Backlash of a pair at one centre distance, m; negative where the teeth would have to overlap.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Backlash {
    /// Circumferential backlash j_wt at the working pitch circles, transverse.
    pub circumferential: f64,
    /// Normal backlash j_bn.
    pub normal: f64,
    /// Radial backlash j_r.
    pub radial: f64,
}

/// Backlash without deviations and at the limits of centre distance and thickness.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BacklashLimits {
    /// At the nominal centre distance and thicknesses.
    pub nominal: Backlash,
    /// At the mean centre distance and mean thicknesses: what a machine takes.
    pub mean: Backlash,
    /// Smallest.
    pub least: Backlash,
    /// Largest.
    pub greatest: Backlash,
}

impl Pair {
    /// Backlash at a centre distance, with deviations of the normal thicknesses at the reference cylinders; `None` where the base
    /// circles do not touch.
    pub fn backlash(&self, centre_distance: f64, deviations: [f64; 2]) -> Option<Backlash> {
        let geometry = self.path_geometry();
        let angle = (self.centre_distance * geometry.angle.cos() / centre_distance).acos();
        if !(angle > 0.0) {
            return None;
        }
        let [s1, s2] = [0, 1].map(|i| {
            let gear = &self.members[i].gear;
            let working = 2.0 * geometry.base[i] / angle.cos();
            gear.thickness_at(working, gear.nominal_thickness() + deviations[i])
        });
        let pitch = TAU * geometry.base[0] / (angle.cos() * f64::from(geometry.teeth));
        let circumferential = pitch - s1 - s2;
        let helix = self.members[0].gear.base_helix_angle();
        Some(Backlash {
            circumferential,
            normal: circumferential * angle.cos() * helix.cos(),
            radial: circumferential / (2.0 * angle.tan()),
        })
    }

    /// Backlash at nominal values and at the limits of centre distance (lower and upper deviation, m) and thickness.
    pub fn backlash_limits(&self, centre_deviation: [f64; 2]) -> Option<BacklashLimits> {
        let deviations = self.members.map(|m| m.thickness_deviation);
        let [thin, thick] = [0, 1].map(|limit| deviations.map(|d| d[limit]));
        let at = |centre: f64, thickness| self.backlash(self.centre_distance + centre, thickness);
        // Farther apart an external pair has more backlash, an internal one less.
        let [near, far] = centre_deviation;
        let mean = self.members.map(|m| m.mean_thickness_deviation());
        let (tight, loose) = match self.members[1].gear.internal {
            false => (near, far),
            true => (far, near),
        };
        Some(BacklashLimits {
            nominal: at(0.0, [0.0; 2])?,
            mean: at(0.5 * (near + far), mean)?,
            least: at(tight, thick)?,
            greatest: at(loose, thin)?,
        })
    }
}
