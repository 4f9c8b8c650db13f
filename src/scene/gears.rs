//! `[[gear_pair]]`, `[[worm_pair]]` and `[[belt]]`.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};
use std::sync::Arc;

use super::bevel_mesh::BevelMesh;
use super::friction;
use super::gear_mesh::GearMesh;
use super::laws::{ToothFriction, Waveform};
use super::model::{Belt, ContactParameters, GearPair, MeshFlanks, WormPair};
use super::named_gear_file;
use super::pair_mesh::PairMesh;
use super::shared_keys::{
    self, DEFAULT_PRESSURE_ANGLE, HELIX_ANGLE_RANGE, MAX_COUNT, PRESSURE_ANGLE_RANGE,
};
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
use crate::gear::hand::Hand;

/// Tooth numbers; ones where they are missing or wrong.
fn teeth(f: &mut TableReader) -> [u32; 2] {
    let teeth = f.optional_counts("teeth", 1, MAX_COUNT);
    if !f.has("gear") {
        f.require("teeth");
    }
    teeth.unwrap_or([1, 1])
}

/// The module, which a stiffness along the tooth needs for its lever.
fn module(f: &mut TableReader) -> Option<f64> {
    let module = f.optional_quantity("module", QuantityKind::Length, ValueRange::Positive);
    if let (Some(key), false) = (
        ["k", "characteristic"].into_iter().find(|key| f.has(key)),
        f.has("module") || f.has("gear"),
    ) {
        let why = format!(", which gives the lever arm of `{key}`");
        f.report_missing("module", &why);
    }
    module
}

/// Spur, helical, bevel and hypoid pairs.
pub fn gear_pair(f: &mut TableReader) -> GearPair {
    let name = shared_keys::name(f);
    let between = shared_keys::read_body_pair(f);
    let gear = named_gear_file::read_pair(f);
    let cut_on = named_gear_file::read_generator(f, gear.as_ref());
    let teeth = teeth(f);
    let internal = f.flag("internal");
    if internal && teeth[1] <= teeth[0] && teeth != [1, 1] {
        let message = format!(
            "a ring of {} teeth cannot contain a gear of {}",
            teeth[1], teeth[0]
        );
        f.report_key(
            Code::OutOfRange,
            "teeth",
            message,
            "the second gear is the ring",
        );
    }
    let contact = shared_keys::read_mesh_contact(f, "");
    let module = module(f);
    let pressure_angle =
        f.optional_quantity("pressure_angle", QuantityKind::Angle, PRESSURE_ANGLE_RANGE);
    let usual = if internal { [0.0, 0.0] } else { [0.0, PI] };
    let (cone_angles, stated) = angles(f, teeth);
    let (cone_angles, spiral_angles) = match &gear {
        None => (cone_angles, stated),
        Some(PairMesh::Cylindrical(gear)) => (cone_angles, [gear.helix_angle(); 2]),
        Some(PairMesh::Bevel(gear)) => (gear.cone_angles(), gear.spiral_angles),
    };
    if internal && cone_angles != [0.0; 2] {
        let message = "an internal pair has parallel axes";
        f.report_key(Code::Conflict, "internal", message, "omit the cone angles");
    }
    let bevel = cone_angles != [0.0; 2];
    let friction = friction::read_tooth_friction(f, spiral_angles != [0.0; 2], bevel);
    let pair = GearPair {
        friction,
        gear: None,
        cut_on,
        name,
        between,
        teeth,
        internal,
        module,
        pressure_angle: pressure_angle.unwrap_or(DEFAULT_PRESSURE_ANGLE),
        spiral_angles,
        cone_angles,
        hand: shared_keys::hand(f),
        mesh_angles: shared_keys::mesh_angles(f, usual),
        contact,
    };
    match gear {
        Some(PairMesh::Cylindrical(gear)) => of_gear_file(pair, gear, f.has("mesh_angles")),
        Some(PairMesh::Bevel(gear)) => of_bevel_file(pair, gear),
        None => pair,
    }
}

/// The pair with what the gear file of bevel gears determines.
fn of_bevel_file(pair: GearPair, gear: Arc<BevelMesh>) -> GearPair {
    let te = Waveform::Table(gear.te.clone());
    GearPair {
        teeth: gear.teeth(),
        module: Some(gear.module),
        pressure_angle: gear.pressure_angle,
        hand: gear.hand,
        contact: ContactParameters {
            flanks: Some(MeshFlanks {
                unloaded_te: te.clone(),
                averaged_te: te,
                phase: 0.0,
                is_coast: gear.is_backward,
                springs: None,
            }),
            ..pair.contact
        },
        gear: Some(PairMesh::Bevel(gear)),
        ..pair
    }
}

/// The pair with what its gear file determines.
fn of_gear_file(pair: GearPair, gear: Arc<GearMesh>, placed: bool) -> GearPair {
    GearPair {
        teeth: gear.teeth(),
        internal: gear.is_internal(),
        module: Some(gear.normal_module()),
        pressure_angle: gear.pressure_angle(),
        hand: gear.hand,
        mesh_angles: match gear.is_internal() && !placed {
            true => [0.0; 2],
            false => pair.mesh_angles,
        },
        contact: ContactParameters {
            backlash: gear.backlash,
            ..pair.contact
        },
        friction: pair.friction.map(|friction| ToothFriction {
            tips: Some(gear.tip_radii()),
            path: friction.path.map(|_| gear.path_phase()),
            ..friction
        }),
        gear: Some(PairMesh::Cylindrical(gear)),
        ..pair
    }
}

/// Pitch cone angles and spiral angles, rad.
fn angles(f: &mut TableReader, teeth: [u32; 2]) -> ([f64; 2], [f64; 2]) {
    const CONE: ValueRange = ValueRange::Open(0.0, PI, "above 0° and below 180°");
    let helix = f.optional_quantity("helix_angle", QuantityKind::Angle, HELIX_ANGLE_RANGE);
    let spiral = f.optional_pair("spiral_angle", QuantityKind::Angle, HELIX_ANGLE_RANGE);
    let cones = f.optional_quantities("cone_angles", QuantityKind::Angle, CONE, Some(2));
    let between_axes = f.optional_quantity("shaft_angle", QuantityKind::Angle, CONE);
    f.exclusive("cone_angles", "shaft_angle");
    f.exclusive("helix_angle", "spiral_angle");
    let bevel = f.has("cone_angles") || f.has("shaft_angle");
    if bevel && f.has("helix_angle") {
        let message = "`helix_angle` applies to parallel axes only";
        f.report_key(
            Code::Conflict,
            "helix_angle",
            message,
            "use `spiral_angle` for bevel gears",
        );
    }
    if !bevel && f.has("spiral_angle") {
        let message = "`spiral_angle` applies to bevel gears, and no cone angles are given";
        let hint = "give `shaft_angle` or `cone_angles`; use `helix_angle` for parallel axes";
        f.report_key(Code::Conflict, "spiral_angle", message, hint);
    }
    if f.has("shaft_angle") && spiral.is_some_and(|[one, two]| one != two) {
        let message = "two spiral angles define a hypoid pair, whose cones are not determined by `shaft_angle`";
        f.report_key(Code::Conflict, "shaft_angle", message, "give `cone_angles`");
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
pub fn worm_pair(f: &mut TableReader) -> WormPair {
    const LEAD: ValueRange = ValueRange::Open(0.0, FRAC_PI_2, "above 0° and below 90°");
    let name = shared_keys::name(f);
    let between = shared_keys::read_body_pair(f);
    let gear = named_gear_file::read_worm(f);
    let teeth = teeth(f);
    let contact = shared_keys::read_mesh_contact(f, "");
    let module = module(f);
    let lead_angle = f.optional_quantity("lead_angle", QuantityKind::Angle, LEAD);
    if !f.has("gear") {
        f.require("lead_angle");
    }
    let pressure_angle =
        f.optional_quantity("pressure_angle", QuantityKind::Angle, PRESSURE_ANGLE_RANGE);
    let hand = shared_keys::hand(f);
    let [lead_of_gear, pressure_of_gear] = match &gear {
        Some(gear) => gear.pitch_angles().map(Some),
        None => [None; 2],
    };
    WormPair {
        name,
        between,
        teeth: gear.as_ref().map_or(teeth, |g| [g.thread.starts, g.teeth]),
        module: gear.as_ref().map(|g| g.thread.module).or(module),
        lead_angle: lead_of_gear.or(lead_angle).unwrap_or(FRAC_PI_4),
        pressure_angle: (pressure_of_gear.or(pressure_angle)).unwrap_or(DEFAULT_PRESSURE_ANGLE),
        hand: match &gear {
            Some(gear) if gear.hand < 0.0 => Hand::Left,
            Some(_) => Hand::Right,
            None => hand,
        },
        gear: gear.map(|gear| gear.source.clone()),
        friction: f.optional_number("friction", ValueRange::NotNegative),
        mesh_angles: shared_keys::mesh_angles(f, [0.0, PI]),
        contact,
    }
}

/// A belt or a chain between pulleys.
pub fn belt(f: &mut TableReader) -> Belt {
    /// Pitch where only the ratio matters, m.
    const ANY_PITCH: f64 = 1e-3;
    const SIZE: ValueRange = ValueRange::Open(1e-6, 1e6, "above 1 µm and below 1000 km");
    let name = shared_keys::name(f);
    let between = shared_keys::read_body_pair(f);
    let diameters = f.optional_quantities("diameters", QuantityKind::Length, SIZE, Some(2));
    let teeth = f.optional_counts::<2>("teeth", 1, MAX_COUNT);
    let pitch = f.optional_quantity("pitch", QuantityKind::Length, ValueRange::Positive);
    f.exclusive("diameters", "teeth");
    f.exclusive("diameters", "pitch");
    let crossed = f.flag("crossed");
    let stiffness = f.optional_quantity("k", QuantityKind::Stiffness, ValueRange::NotNegative);
    if !f.has("diameters") {
        if !f.has("teeth") {
            f.report_missing("diameters", " or `teeth`");
        } else if f.has("k") && !f.has("pitch") {
            f.report_missing("pitch", ", which gives the lever arm of `k`");
        }
    }
    let rigid = !f.has("k");
    let loss = shared_keys::read_damping(f, "", QuantityKind::Damping, "`k`", rigid);
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
        ratio_integers: exact,
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
