//! `[[planetary]]`.

use super::common::{self, MOST, PRESSURE, USUAL_PRESSURE};
use super::model::{End, Planetary, PlanetarySize};
use crate::base::code::Code;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;

/// The most planets of one stage.
const MOST_PLANETS: u32 = 100;

/// A planetary stage.
pub fn planetary(f: &mut Fields) -> Planetary {
    let name = common::name(f);
    let [sun, ring, carrier] = members(f);
    let positions = positions(f);
    let size = size(f);
    let pressure_angles = f.optional_pair("pressure_angle", Kind::Angle, PRESSURE);
    let planet_polar = f.quantity("planet_J", Kind::Inertia, Range::NotNegative);
    let planet_mass = f.optional_quantity("planet_mass", Kind::Mass, Range::NotNegative);
    let sun_contact = common::contact(f, "_sun");
    let ring_contact = common::contact(f, "_ring");
    let planet_bearing = f.optional_quantity("k_bearing", Kind::Stiffness, Range::NotNegative);
    let rigid = !f.has("k_bearing");
    let bearing_loss = common::loss(f, "_bearing", Kind::Damping, "`k_bearing`", rigid);
    let lateral = f.flag("lateral");
    if lateral {
        for key in ["planet_mass", "k_bearing"] {
            if !f.has(key) {
                f.missing(key, ", which `lateral = true` needs");
            }
        }
    }
    Planetary {
        name,
        sun,
        ring,
        carrier,
        size,
        pressure_angles: pressure_angles.unwrap_or([USUAL_PRESSURE; 2]),
        positions,
        planet_polar,
        planet_mass,
        sun_contact,
        ring_contact,
        planet_bearing,
        bearing_loss,
        lateral,
    }
}

/// Sun, ring and carrier: different nodes, at most one of them ground.
fn members(f: &mut Fields) -> [End; 3] {
    let keys = ["sun", "ring", "carrier"];
    let members = keys.map(|key| common::one_end(f, key));
    let words = [0, 1, 2].map(|i| match &members[i] {
        End::Ground => "ground",
        End::Node(name) => name.text.as_str(),
    });
    for (one, two) in [(0, 1), (0, 2), (1, 2)] {
        if words[one] == words[two] && !words[one].is_empty() {
            let message = format!("{} and {} are both `{}`", keys[one], keys[two], words[one]);
            let hint = "a planetary stage has three members, of which one may be ground";
            f.refuse_key(Code::Conflict, keys[two], message, hint);
        }
    }
    members
}

/// Where the planets stand, rad.
fn positions(f: &mut Fields) -> Vec<f64> {
    let count = f.optional_count("planets", 1, MOST_PLANETS);
    let positions = f.optional_quantities("positions", Kind::Angle, Range::Any, None);
    f.exclusive("planets", "positions");
    if !f.has("positions") {
        f.need("planets");
    }
    let most = MOST_PLANETS as usize;
    if positions
        .as_ref()
        .is_some_and(|p| !(1..=most).contains(&p.len()))
    {
        let message = format!("`positions` must be 1 to {most} angles");
        f.refuse_key(
            Code::OutOfRange,
            "positions",
            message,
            "one angle for each planet",
        );
    }
    positions.unwrap_or_else(|| common::equally_spaced(count.unwrap_or(0)))
}

/// Teeth and module, or radii.
fn size(f: &mut Fields) -> PlanetarySize {
    let teeth = f.optional_counts::<3>("teeth", 1, MOST);
    let module = f.optional_quantity("module", Kind::Length, Range::Positive);
    let base = f.optional_quantities("base_radii", Kind::Length, Range::Positive, Some(3));
    let carrier = f.optional_quantity("carrier_radius", Kind::Length, Range::Positive);
    f.exclusive("teeth", "base_radii");
    f.exclusive("module", "base_radii");
    f.exclusive("teeth", "carrier_radius");
    if f.has("base_radii") {
        f.need("carrier_radius");
    } else if !f.has("teeth") {
        f.missing("teeth", " or `base_radii`");
    } else if !f.has("module")
        && ["k_sun", "k_ring", "k_bearing"]
            .iter()
            .any(|key| f.has(key))
    {
        f.missing("module", ", from which the lever of the stiffness follows");
    }
    if let Some([sun, planet, ring]) = teeth
        && (ring <= planet || ring <= sun)
    {
        let message =
            format!("a ring of {ring} teeth cannot hold a sun of {sun} and planets of {planet}");
        f.refuse_key(
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
                f.refuse_key(Code::OutOfRange, "base_radii", message, hint);
            }
            PlanetarySize::Radii {
                base: [sun, planet, ring],
                carrier: carrier.unwrap_or(f64::NAN),
            }
        }
        (_, teeth) => PlanetarySize::Teeth {
            teeth: teeth.unwrap_or([1, 1, 3]),
            module,
        },
    }
}
