//! `[[gear_pair]]`, `[[worm_pair]]` and `[[belt]]`.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use super::common::{self, HELIX, MOST, PRESSURE, USUAL_PRESSURE};
use super::friction;
use super::model::{Belt, GearPair, WormPair};
use crate::base::code::Code;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;

/// Tooth numbers; ones where they are missing or wrong.
fn teeth(f: &mut Fields) -> [u32; 2] {
    let teeth = f.optional_counts("teeth", 1, MOST);
    f.need("teeth");
    teeth.unwrap_or([1, 1])
}

/// The module, which a stiffness along the tooth needs for its lever.
fn module(f: &mut Fields) -> Option<f64> {
    let module = f.optional_quantity("module", Kind::Length, Range::Positive);
    if let (Some(key), false) = (
        ["k", "characteristic"].into_iter().find(|key| f.has(key)),
        f.has("module"),
    ) {
        let why = format!(", from which the lever of `{key}` follows");
        f.missing("module", &why);
    }
    module
}

/// Spur, helical, bevel and hypoid pairs.
pub fn gear_pair(f: &mut Fields) -> GearPair {
    let name = common::name(f);
    let between = common::bodies(f);
    let teeth = teeth(f);
    let internal = f.flag("internal");
    if internal && teeth[1] <= teeth[0] && teeth != [1, 1] {
        let message = format!(
            "a ring of {} teeth cannot hold a gear of {}",
            teeth[1], teeth[0]
        );
        f.refuse_key(
            Code::OutOfRange,
            "teeth",
            message,
            "the second gear is the ring",
        );
    }
    let contact = common::contact(f, "");
    let module = module(f);
    let pressure_angle = f.optional_quantity("pressure_angle", Kind::Angle, PRESSURE);
    let usual = if internal { [0.0, 0.0] } else { [0.0, PI] };
    let (cone_angles, spiral_angles) = angles(f, teeth);
    if internal && cone_angles != [0.0; 2] {
        let message = "an internal pair has parallel axes";
        f.refuse_key(
            Code::Conflict,
            "internal",
            message,
            "leave the cone angles out",
        );
    }
    let bevel = cone_angles != [0.0; 2];
    let friction = friction::of_teeth(f, spiral_angles != [0.0; 2], bevel);
    GearPair {
        friction,
        name,
        between,
        teeth,
        internal,
        module,
        pressure_angle: pressure_angle.unwrap_or(USUAL_PRESSURE),
        spiral_angles,
        cone_angles,
        hand: common::hand(f),
        mesh_angles: common::mesh_angles(f, usual),
        contact,
    }
}

/// Pitch cone angles and spiral angles, rad.
fn angles(f: &mut Fields, teeth: [u32; 2]) -> ([f64; 2], [f64; 2]) {
    const CONE: Range = Range::Between(0.0, PI, "above 0° and below 180°");
    let helix = f.optional_quantity("helix_angle", Kind::Angle, HELIX);
    let spiral = f.optional_pair("spiral_angle", Kind::Angle, HELIX);
    let cones = f.optional_quantities("cone_angles", Kind::Angle, CONE, Some(2));
    let between_axes = f.optional_quantity("shaft_angle", Kind::Angle, CONE);
    f.exclusive("cone_angles", "shaft_angle");
    f.exclusive("helix_angle", "spiral_angle");
    let bevel = f.has("cone_angles") || f.has("shaft_angle");
    if bevel && f.has("helix_angle") {
        let message = "`helix_angle` is of parallel axes";
        f.refuse_key(
            Code::Conflict,
            "helix_angle",
            message,
            "bevel gears have a `spiral_angle`",
        );
    }
    if !bevel && f.has("spiral_angle") {
        let message = "`spiral_angle` is of bevel gears, and no cone angles are given";
        let hint = "give `shaft_angle` or `cone_angles`; parallel axes have a `helix_angle`";
        f.refuse_key(Code::Conflict, "spiral_angle", message, hint);
    }
    if f.has("shaft_angle") && spiral.is_some_and(|[one, two]| one != two) {
        let message =
            "two spiral angles make a hypoid pair, whose cones do not follow from `shaft_angle`";
        f.refuse_key(Code::Conflict, "shaft_angle", message, "give `cone_angles`");
    }
    let cone_angles = cones
        .and_then(|cones| cones.try_into().ok())
        .or(between_axes.map(|angle| cones_of(teeth, angle)))
        .unwrap_or([0.0; 2]);
    let spiral_angles = spiral
        .or(helix.map(|beta| [beta, beta]))
        .unwrap_or([0.0; 2]);
    (cone_angles, spiral_angles)
}

/// Pitch cones of gears whose axes meet: `tan δ₁ = sin Σ / (z₂/z₁ + cos Σ)`, `δ₂ = Σ − δ₁`.
fn cones_of(teeth: [u32; 2], sigma: f64) -> [f64; 2] {
    let [z1, z2] = teeth.map(f64::from);
    let first = (z1 * sigma.sin()).atan2(z2 + z1 * sigma.cos());
    [first, sigma - first]
}

/// A worm and its wheel.
pub fn worm_pair(f: &mut Fields) -> WormPair {
    const LEAD: Range = Range::Between(0.0, FRAC_PI_2, "above 0° and below 90°");
    let name = common::name(f);
    let between = common::bodies(f);
    let teeth = teeth(f);
    let contact = common::contact(f, "");
    let module = module(f);
    let lead_angle = f.quantity("lead_angle", Kind::Angle, LEAD);
    let pressure_angle = f.optional_quantity("pressure_angle", Kind::Angle, PRESSURE);
    WormPair {
        name,
        between,
        teeth,
        module,
        lead_angle,
        pressure_angle: pressure_angle.unwrap_or(USUAL_PRESSURE),
        hand: common::hand(f),
        friction: f.optional_number("friction", Range::NotNegative),
        mesh_angles: common::mesh_angles(f, [0.0, PI]),
        contact,
    }
}

/// A belt or a chain between pulleys.
pub fn belt(f: &mut Fields) -> Belt {
    /// Pitch where only the ratio matters, m.
    const ANY_PITCH: f64 = 1e-3;
    const SIZE: Range = Range::Between(1e-6, 1e6, "above 1 µm and below 1000 km");
    let name = common::name(f);
    let between = common::bodies(f);
    let diameters = f.optional_quantities("diameters", Kind::Length, SIZE, Some(2));
    let teeth = f.optional_counts::<2>("teeth", 1, MOST);
    let pitch = f.optional_quantity("pitch", Kind::Length, Range::Positive);
    f.exclusive("diameters", "teeth");
    f.exclusive("diameters", "pitch");
    let crossed = f.flag("crossed");
    let stiffness = f.optional_quantity("k", Kind::Stiffness, Range::NotNegative);
    if !f.has("diameters") {
        if !f.has("teeth") {
            f.missing("diameters", " or `teeth`");
        } else if f.has("k") && !f.has("pitch") {
            f.missing("pitch", ", from which the lever of `k` follows");
        }
    }
    let rigid = !f.has("k");
    let loss = common::loss(f, "", Kind::Damping, "`k`", rigid);
    let (radii, exact) = match (diameters.as_deref(), teeth) {
        (Some(&[one, two]), _) => {
            let radii = [one / 2.0, two / 2.0];
            (radii, radii.map(nanometres))
        }
        (_, Some(teeth)) => {
            let pitch = pitch.unwrap_or(ANY_PITCH);
            (
                teeth.map(|z| f64::from(z) * pitch / TAU),
                teeth.map(u64::from),
            )
        }
        _ => ([1.0, 1.0], [1, 1]),
    };
    Belt {
        name,
        between,
        radii,
        exact,
        crossed,
        stiffness,
        loss,
    }
}

/// A length in whole nanometres.
fn nanometres(length: f64) -> u64 {
    (1e9 * length).round() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mitre pair halves the right angle.
    #[test]
    fn exact_cones_of_meeting_axes() {
        let [one, two] = cones_of([20, 20], FRAC_PI_2);
        assert!((one - PI / 4.0).abs() < 1e-15 && (two - PI / 4.0).abs() < 1e-15);
        let [one, two] = cones_of([10, 30], FRAC_PI_2);
        assert!((one.tan() - 1.0 / 3.0).abs() < 1e-15);
        assert!((one.sin() / two.sin() - 1.0 / 3.0).abs() < 1e-15);
    }
}
