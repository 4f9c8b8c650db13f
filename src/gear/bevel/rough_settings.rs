//! Settings of a generator from the spiral angle and the blank: a start for a pair that has none.
//!
//! The crown gear of the pitch cone is cut in the plane of the root cone: centre of the cutter at `(R_m − r sin β, r cos β)` from the root
//! apex, `R_a = cos θ_f/sin δ`: then the pitch element is the instantaneous axis. Litvin and Fuentes, Gear Geometry and Applied Theory,
//! 2nd ed. 2004, section 21.2.

use super::blank::Blank;
use super::settings::{MachineSettings, Roll};

/// Settings at which a cutter of a point radius leaves a spiral angle in the middle of the face of a blank.
pub fn rough_settings(blank: &Blank, point_radius: f64, spiral_angle: f64) -> MachineSettings {
    let (sin, cos) = spiral_angle.sin_cos();
    let dedendum_angle = blank.pitch_angle - blank.root_angle;
    let [z, radius] = blank.mean_point();
    // Along the root cone, from its apex to the foot of the mean point.
    let along = (z + blank.root_apex) * blank.root_angle.cos() + radius * blank.root_angle.sin();
    let centre = [along - point_radius * sin, point_radius * cos];
    MachineSettings {
        radial_distance: f64::hypot(centre[0], centre[1]),
        cradle_angle: centre[1].atan2(centre[0]),
        blank_offset: 0.0,
        sliding_base: 0.0,
        helical_motion: 0.0,
        centre_to_back: blank.root_apex,
        machine_root_angle: blank.root_angle,
        tilt: 0.0,
        swivel: 0.0,
        roll: Some(Roll::constant(
            dedendum_angle.cos() / blank.pitch_angle.sin(),
        )),
    }
}
