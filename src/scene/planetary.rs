//! `[[planetary]]`.

use std::sync::Arc;

use super::gear_mesh::GearMesh;
use super::model::{BranchEnd, ContactParameters, Planetary, PlanetaryGeometry};
use super::named_gear_file::{self, STAGE_FILE_KEYS};
use super::shared_keys::{self, DEFAULT_PRESSURE_ANGLE, MAX_COUNT, PRESSURE_ANGLE_RANGE};
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
use crate::gear::load::planet_phase::planet_phase;

/// Centre distances nearer than this, relative, are one: rounding of a conversion of units.
const SAME_DISTANCE: f64 = 1e-9;

/// The most planets of one stage.
const MAX_PLANETS: u32 = 100;

/// A planetary stage.
pub fn planetary(f: &mut TableReader) -> Planetary {
    let name = shared_keys::name(f);
    let [sun, ring, carrier] = members(f);
    let positions = positions(f);
    let gears = gear_files(f);
    let size = size(f);
    let pressure_angles =
        f.optional_pair("pressure_angle", QuantityKind::Angle, PRESSURE_ANGLE_RANGE);
    let planet_polar = f.quantity("planet_J", QuantityKind::Inertia, ValueRange::NotNegative);
    let planet_mass =
        f.optional_quantity("planet_mass", QuantityKind::Mass, ValueRange::NotNegative);
    let sun_contact = shared_keys::read_mesh_contact(f, "_sun");
    let ring_contact = shared_keys::read_mesh_contact(f, "_ring");
    let planet_bearing = f.optional_quantity(
        "k_bearing",
        QuantityKind::Stiffness,
        ValueRange::NotNegative,
    );
    let rigid = !f.has("k_bearing");
    let bearing_loss =
        shared_keys::read_damping(f, "_bearing", QuantityKind::Damping, "`k_bearing`", rigid);
    let lateral = f.flag("lateral");
    if lateral {
        for key in ["planet_mass", "k_bearing"] {
            if !f.has(key) {
                f.report_missing(key, ", which `lateral = true` needs");
            }
        }
    }
    let stage = Planetary {
        name,
        sun,
        ring,
        carrier,
        size,
        pressure_angles: pressure_angles.unwrap_or([DEFAULT_PRESSURE_ANGLE; 2]),
        positions,
        planet_polar,
        planet_mass,
        sun_contact,
        ring_contact,
        planet_bearing,
        bearing_loss,
        lateral,
        gears: None,
    };
    match gears {
        Some(gears) => of_gear_files(stage, gears),
        None => stage,
    }
}

/// Gear files of the sun's and of the ring's mesh: both or neither, with one planet and one centre distance.
fn gear_files(f: &mut TableReader) -> Option<[Arc<GearMesh>; 2]> {
    let sun = named_gear_file::read(f, "_sun", STAGE_FILE_KEYS);
    let ring = named_gear_file::read(f, "_ring", STAGE_FILE_KEYS);
    f.requires("gear_sun", "gear_ring");
    f.requires("gear_ring", "gear_sun");
    let (sun, ring) = (sun?, ring?);
    if sun.is_internal() {
        let message = format!("{} has an internal gear", sun.file.source.path);
        let hint = "use sun and planet for `gear_sun`, planet and ring for `gear_ring`";
        f.report_key(Code::Conflict, "gear_sun", message, hint);
        return None;
    }
    if let Err(error) = planet_phase(&sun.pair, &ring.pair) {
        let [one, other] = [&sun, &ring].map(|mesh| &mesh.file.source.path);
        let message = format!("{one} and {other}: {}", error.message);
        let hint = "`gear_sun` takes sun and planet, `gear_ring` the same planet and the ring with internal = true; state the planet's tip_diameter in both";
        f.report_key(error.code, "gear_ring", message, hint);
        return None;
    }
    let [a, b] = [&sun, &ring].map(|mesh| mesh.pair.centre_distance);
    if (a - b).abs() > SAME_DISTANCE * a {
        let message = format!(
            "the centre distances differ: {:.6} mm in {}, {:.6} mm in {}",
            1e3 * a,
            sun.file.source.path,
            1e3 * b,
            ring.file.source.path
        );
        let hint = "give both files the radius of the planets' centres as centre_distance";
        f.report_key(Code::Conflict, "gear_ring", message, hint);
        return None;
    }
    Some([sun, ring])
}

/// The stage with what its gear files determine.
fn of_gear_files(stage: Planetary, gears: [Arc<GearMesh>; 2]) -> Planetary {
    let ([sun, planet], [_, ring]) = (gears[0].teeth(), gears[1].teeth());
    // A stage describes its meshes in the transverse plane.
    let play = |mesh: &GearMesh| mesh.backlash / mesh.base_helix_angle().cos();
    let contact = |contact: ContactParameters, mesh: &GearMesh| ContactParameters {
        backlash: play(mesh),
        ..contact
    };
    Planetary {
        size: PlanetaryGeometry::Teeth {
            teeth: [sun, planet, ring],
            modules: Some([0, 1].map(|i| gears[i].transverse_module())),
        },
        pressure_angles: [0, 1].map(|i| gears[i].pair.working_pressure_angle),
        sun_contact: contact(stage.sun_contact, &gears[0]),
        ring_contact: contact(stage.ring_contact, &gears[1]),
        gears: Some(gears),
        ..stage
    }
}

/// Sun, ring and carrier: different nodes, at most one of them ground.
fn members(f: &mut TableReader) -> [BranchEnd; 3] {
    let keys = ["sun", "ring", "carrier"];
    let members = keys.map(|key| shared_keys::read_end(f, key));
    let words = [0, 1, 2].map(|i| match &members[i] {
        BranchEnd::Ground => "ground",
        BranchEnd::Node(name) => name.text.as_str(),
    });
    for (one, two) in [(0, 1), (0, 2), (1, 2)] {
        if words[one] == words[two] && !words[one].is_empty() {
            let message = format!("{} and {} are both `{}`", keys[one], keys[two], words[one]);
            let hint = "a planetary stage has three members, of which one may be ground";
            f.report_key(Code::Conflict, keys[two], message, hint);
        }
    }
    members
}

/// Angular positions of the planets, rad.
fn positions(f: &mut TableReader) -> Vec<f64> {
    let count = f.optional_count("planets", 1, MAX_PLANETS);
    let positions = f.optional_quantities("positions", QuantityKind::Angle, ValueRange::Any, None);
    f.exclusive("planets", "positions");
    if !f.has("positions") {
        f.require("planets");
    }
    let most = MAX_PLANETS as usize;
    if positions
        .as_ref()
        .is_some_and(|p| !(1..=most).contains(&p.len()))
    {
        let message = format!("`positions` must be 1 to {most} angles");
        f.report_key(
            Code::OutOfRange,
            "positions",
            message,
            "give one angle per planet",
        );
    }
    positions.unwrap_or_else(|| shared_keys::equally_spaced(count.unwrap_or(0)))
}

/// Teeth and module, or radii.
fn size(f: &mut TableReader) -> PlanetaryGeometry {
    let teeth = f.optional_counts::<3>("teeth", 1, MAX_COUNT);
    let module = f.optional_quantity("module", QuantityKind::Length, ValueRange::Positive);
    let base = f.optional_quantities(
        "base_radii",
        QuantityKind::Length,
        ValueRange::Positive,
        Some(3),
    );
    let carrier = f.optional_quantity("carrier_radius", QuantityKind::Length, ValueRange::Positive);
    f.exclusive("teeth", "base_radii");
    f.exclusive("module", "base_radii");
    f.exclusive("teeth", "carrier_radius");
    if f.has("gear_sun") || f.has("gear_ring") {
        // The files have the sizes.
    } else if f.has("base_radii") {
        f.require("carrier_radius");
    } else if !f.has("teeth") {
        f.report_missing("teeth", " or `base_radii`");
    } else if !f.has("module")
        && ["k_sun", "k_ring", "k_bearing"]
            .iter()
            .any(|key| f.has(key))
    {
        f.report_missing("module", ", which gives the lever arm of the stiffness");
    }
    if let Some([sun, planet, ring]) = teeth
        && (ring <= planet || ring <= sun)
    {
        let message =
            format!("a ring of {ring} teeth cannot contain a sun of {sun} and planets of {planet}");
        f.report_key(
            Code::OutOfRange,
            "teeth",
            message,
            "`teeth` takes [sun, planet, ring]",
        );
    }
    match (base.as_deref(), teeth) {
        (Some(&[sun, planet, ring]), _) => {
            if ring <= planet {
                let message = "the ring's base radius must be above the planet's";
                let hint = "`base_radii` takes [sun, planet, ring]";
                f.report_key(Code::OutOfRange, "base_radii", message, hint);
            }
            PlanetaryGeometry::Radii {
                base: [sun, planet, ring],
                carrier: carrier.unwrap_or(f64::NAN),
            }
        }
        (_, teeth) => PlanetaryGeometry::Teeth {
            teeth: teeth.unwrap_or([1, 1, 3]),
            modules: module.map(|module| [module; 2]),
        },
    }
}
