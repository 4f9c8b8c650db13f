//! Gear files that meshes of a model name: what they determine of a pair, and where a key next to them contradicts it.
//!
//! Lengths and angles are those of the working pitch circles: `m_w = 2 r_w cos β_w/z`, `tan β_w = tan β r_w/r`, so that the normal of the
//! mesh is that of the teeth at their centre distance.

use std::f64::consts::TAU;
use std::path::Path;
use std::sync::Arc;

use super::gear_file::{self, GearFile};
use super::model::Hand;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::flags::Flags;
use crate::base::load;
use crate::base::source_span::SourceSpan;
use crate::base::table_reader::TableReader;
use crate::base::toml::{self, Value};
use crate::gear::cylindrical::pair::Pair;

/// Backlash below zero by less than this is rounding of a centre distance, m.
const BACKLASH_ROUNDING: f64 = 1e-6;

/// A pair of cylindrical gears as a mesh of a model takes it from its gear file.
#[derive(Debug)]
pub struct GearMesh {
    /// The file.
    pub file: GearFile,
    /// Its gears in mesh.
    pub pair: Pair,
    /// Normal backlash at mean thicknesses and mean centre distance, m.
    pub backlash: f64,
    /// Place of the file's name in the model.
    pub span: SourceSpan,
    /// Key of the model that states a stiffness next to the file, and its place.
    pub stated_stiffness: Option<(String, SourceSpan)>,
}

/// Keys that a gear file determines, each with its table and key there.
pub const DETERMINED_OF_PAIR: &[(&str, [&str; 2])] = &[
    ("teeth", ["pinion", "teeth"]),
    ("internal", ["gear", "internal"]),
    ("module", ["pair", "module"]),
    ("pressure_angle", ["pair", "pressure_angle"]),
    ("helix_angle", ["pair", "helix_angle"]),
    ("spiral_angle", ["pair", "kind"]),
    ("cone_angles", ["pair", "kind"]),
    ("shaft_angle", ["pair", "kind"]),
    ("hand", ["pinion", "hand"]),
    ("backlash", ["pair", "centre_distance"]),
    ("tip_diameters", ["pinion", "tip_diameter"]),
    ("path_phase", ["pinion", "tip_diameter"]),
];

/// Keys of a planetary stage that the gear file of a mesh determines.
pub const DETERMINED_OF_STAGE: &[(&str, [&str; 2])] = &[
    ("teeth", ["pinion", "teeth"]),
    ("module", ["pair", "module"]),
    ("pressure_angle", ["pair", "pressure_angle"]),
    ("base_radii", ["pair", "module"]),
    ("carrier_radius", ["pair", "centre_distance"]),
    ("backlash_sun", ["pair", "centre_distance"]),
    ("backlash_ring", ["pair", "centre_distance"]),
];

/// Keys of a stiffness, which a gear file determines where a torque is known.
const STIFFNESS_KEYS: [&str; 3] = ["k", "k_wave", "characteristic"];

/// The gear file under `gear` with a suffix, such as `gear_sun`; keys of the table that it determines are errors.
pub fn read(
    f: &mut TableReader,
    suffix: &str,
    determined: &[(&str, [&str; 2])],
) -> Option<Arc<GearMesh>> {
    let key = format!("gear{suffix}");
    let named = f.optional_text(&key)?;
    let span = f.span_of(&key).clone();
    // The path starts at the model, wherever [set] writes it.
    let folder = Path::new(&f.span.source().path).parent();
    let path = folder.unwrap_or(Path::new("")).join(named);
    let source = match load::load(&path) {
        Ok(source) => source,
        Err(error) => {
            f.push(
                error.with_hint("the path starts from the folder of the model"),
                &span,
            );
            return None;
        }
    };
    for (own, place) in determined {
        if f.has(own) {
            let place = place_of(&source, *place);
            let message = format!(
                "`{own}` is determined by the gear file {}, line {}",
                source.path,
                place.line()
            );
            let hint = format!("leave `{own}` out, or leave `{key}` out");
            f.report_key(Code::Conflict, own, message, &hint);
        }
    }
    let stated = STIFFNESS_KEYS
        .map(|base| format!("{base}{suffix}"))
        .into_iter()
        .find(|key| f.has(key));
    let stated_stiffness = stated.map(|key| (key.clone(), f.span_of(&key).clone()));
    let told = |error: Error| {
        let name = f.title.clone();
        let (file, line) = (&span.source().path, span.line());
        let label = format!("gear file of {name}, {file}, line {line}");
        match error.span {
            Some(_) => error.with_label(label),
            None => error
                .with_span(&SourceSpan::whole_file(&source.path))
                .with_label(label),
        }
    };
    let made = gear_file::read(&source, &Flags::default())
        .map_err(|errors| errors.as_slice().to_vec())
        .and_then(|file| GearMesh::new(file, &span, stated_stiffness).map_err(|e| vec![e]));
    match made {
        Ok(mesh) => Some(Arc::new(mesh)),
        Err(errors) => {
            let errors: Vec<Error> = errors.into_iter().map(told).collect();
            errors.into_iter().for_each(|error| f.errors.push(error));
            None
        }
    }
}

/// Place of a key of a gear file; that of `pair` where the file leaves it to its default.
fn place_of(
    source: &Arc<crate::base::source_span::SourceFile>,
    [table, key]: [&str; 2],
) -> SourceSpan {
    let root = toml::parse(source).root;
    let inner = |table: &str, key: &str| match &root.get(table)?.item.value {
        Value::Table(inner) => inner.get(key).map(|entry| entry.key_place.clone()),
        _ => None,
    };
    inner(table, key)
        .or(root.get("pair").map(|entry| entry.key_place.clone()))
        .unwrap_or(SourceSpan::new(source.clone(), 0..0))
}

impl GearMesh {
    fn new(
        file: GearFile,
        span: &SourceSpan,
        stated_stiffness: Option<(String, SourceSpan)>,
    ) -> Result<GearMesh, Error> {
        let at = |error: Error| match error.span {
            Some(_) => error,
            None => error.with_span(&file.span),
        };
        let pair = Pair::new(file.members, file.centre_distance).map_err(at)?;
        let [low, high] = file.centre_deviation;
        let deviations = pair.members.map(|m| m.mean_thickness_deviation());
        let centre = pair.centre_distance + 0.5 * (low + high);
        let backlash = pair.backlash(centre, deviations).map(|b| b.normal);
        let Some(backlash) = backlash.filter(|play| *play > -BACKLASH_ROUNDING) else {
            let message = match backlash {
                Some(play) => format!("the teeth overlap by {:.1} µm", -1e6 * play),
                None => "the base circles do not reach each other".into(),
            };
            let hint =
                "give a larger centre_distance, or thickness = [\"lower\", \"upper\"] below zero";
            return Err(at(Error::new(Code::OutOfRange, message).with_hint(hint)));
        };
        Ok(GearMesh {
            backlash: if backlash < BACKLASH_ROUNDING {
                0.0
            } else {
                backlash
            },
            pair,
            span: span.clone(),
            stated_stiffness,
            file,
        })
    }

    /// Tooth numbers of pinion and gear.
    pub fn teeth(&self) -> [u32; 2] {
        self.pair.members.map(|m| m.gear.teeth)
    }

    /// The second gear is internal.
    pub fn is_internal(&self) -> bool {
        self.pair.members[1].gear.internal
    }

    /// Hand of the pinion.
    pub fn hand(&self) -> Hand {
        self.file.hand
    }

    /// Helix angle on the working pitch cylinders, rad.
    pub fn helix_angle(&self) -> f64 {
        let base = self.base_helix_angle().tan();
        (base / self.pair.working_pressure_angle.cos()).atan()
    }

    /// Base helix angle β_b, rad, without sign.
    pub fn base_helix_angle(&self) -> f64 {
        self.pair.members[0].gear.base_helix_angle().abs()
    }

    /// Normal pressure angle on the working pitch cylinders, rad.
    pub fn pressure_angle(&self) -> f64 {
        (self.pair.working_pressure_angle.tan() * self.helix_angle().cos()).atan()
    }

    /// Transverse module on the working pitch cylinders, m.
    pub fn transverse_module(&self) -> f64 {
        let [diameter, _] = self.pair.working_diameters();
        diameter / f64::from(self.teeth()[0])
    }

    /// Normal module on the working pitch cylinders, m.
    pub fn normal_module(&self) -> f64 {
        self.transverse_module() * self.helix_angle().cos()
    }

    /// Radii of the tip circles, m.
    pub fn tip_radii(&self) -> [f64; 2] {
        self.pair.outlines.map(|outline| outline.tip_radius)
    }

    /// Phase of the cycle of friction at the pitch point, rad: that cycle begins where a pair comes into contact.
    pub fn path_phase(&self) -> f64 {
        TAU * self.pair.path_ends()[0] / self.pair.base_pitch()
    }

    /// The one torque of `[mesh]`, N·m at the pinion.
    pub fn torque(&self) -> Option<f64> {
        match self.file.mesh.torques[..] {
            [torque] => Some(torque),
            _ => None,
        }
    }
}
