//! Settings of a generator from the spiral angle and the blank: a start for a pair that has none.
//!
//! The cradle's axis passes through the pitch apex at right angles to the root cone, `R_a = cos θ_f/sin δ`: then the pitch element is the
//! instantaneous axis. Litvin and Fuentes, Gear Geometry and Applied Theory, 2nd ed. 2004, section 21.2. The cutter stands so that its cone
//! has the spiral angle and the pressure angle α of the blade on the pitch cone at the mean point, and its tip circle touches the root cone
//! there. Its axis is tilted, by about `θ_f sin β`: without the tilt the pressure angles of both gears part by the sum of these angles.

use super::blank::Blank;
use super::cutter::Cutter;
use super::settings::{MachineSettings, Roll};
use crate::gear::kernel::vector::Vector;

/// Tilt, rad, below which it is rounding.
const NO_TILT: f64 = 1e-12;

/// Settings at which a cutter leaves a spiral angle, rad, and its blade angle as pressure angle in the middle of the face of a blank.
///
/// Of two gears cut so with the same angles the mating flanks touch at their mean points, at the ratio of the tooth numbers.
pub fn rough_settings(blank: &Blank, cutter: &Cutter, spiral_angle: f64) -> MachineSettings {
    let (sin_beta, cos_beta) = spiral_angle.sin_cos();
    let (sin_alpha, cos_alpha) = cutter.blade_angle.sin_cos();
    let (sin_theta, cos_theta) = (blank.pitch_angle - blank.root_angle).sin_cos();
    let side = cutter.outwards();
    // In the machine's frame of right-hand work: x along the root cone, z into the work, the pitch apex at the origin.
    let element = Vector::new(cos_theta, 0.0, -sin_theta);
    let across = element * sin_beta - Vector::Y * cos_beta;
    let into_work = Vector::new(sin_theta, 0.0, cos_theta);
    let mean = element * blank.mean_cone_distance;
    let normal = across * cos_alpha + into_work * (side * sin_alpha);
    // Of the tangents of the flank, the one down the blade is perpendicular to that along the root cone.
    let along = normal.cross(Vector::Z);
    let along = along * (1.0 / along.norm());
    let down = normal.cross(along);
    let down = down * down.z.signum();
    let axis = normal * (side * sin_alpha) + down * cos_alpha;
    let outward = normal * cos_alpha - down * (side * sin_alpha);
    let root = (blank.pitch_apex - blank.root_apex) * blank.root_angle.sin();
    let tip = mean + down * ((root - mean.z) / down.z);
    let centre = tip - outward * cutter.point_radius;
    let tilt = f64::hypot(axis.x, axis.y).atan2(axis.z);
    MachineSettings {
        radial_distance: f64::hypot(centre.x, centre.y),
        cradle_angle: centre.y.atan2(centre.x),
        blank_offset: 0.0,
        sliding_base: -centre.z,
        helical_motion: 0.0,
        centre_to_back: blank.pitch_apex,
        machine_root_angle: blank.root_angle,
        tilt,
        swivel: match tilt > NO_TILT {
            true => axis.y.atan2(axis.x),
            false => 0.0,
        },
        roll: Some(Roll::constant(cos_theta / blank.pitch_angle.sin())),
    }
}
