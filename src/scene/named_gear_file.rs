//! Gear files that meshes of a model name: what they determine of a pair, and where a key next to them contradicts it.

use std::path::Path;
use std::sync::Arc;

use super::bevel_file;
use super::bevel_mesh::BevelMesh;
use super::gear_file::{self, GearFile};
use super::gear_kind::{PairKind, pair_kind};
use super::gear_mesh::{GearMesh, MeshFile};
use super::model::CutOn;
use super::pair_mesh::PairMesh;
use super::plane_worm_file;
use super::worm_file::{self, WormFile};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::flags::Flags;
use crate::base::load;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::TableReader;
use crate::base::toml::{self, Value};

/// Backlash below zero by less than this is rounding of a centre distance, m.
const BACKLASH_ROUNDING: f64 = 1e-6;

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

/// Keys that the gear file of a bevel pair determines.
pub const DETERMINED_OF_BEVEL: &[(&str, [&str; 2])] = &[
    ("teeth", ["pinion", "teeth"]),
    ("internal", ["pair", "kind"]),
    ("module", ["pinion", "blank"]),
    ("pressure_angle", ["pair", "kind"]),
    ("helix_angle", ["pair", "kind"]),
    ("spiral_angle", ["pair", "kind"]),
    ("cone_angles", ["pinion", "blank"]),
    ("shaft_angle", ["pair", "shaft_angle"]),
    ("hand", ["pinion", "hand"]),
    ("tip_diameters", ["pinion", "blank"]),
    ("path_phase", ["pair", "kind"]),
];

/// Keys that the gear file of a worm pair determines.
const DETERMINED_OF_WORM: &[(&str, [&str; 2])] = &[
    ("teeth", ["worm", "starts"]),
    ("module", ["worm", "module"]),
    ("lead_angle", ["worm", "diameter_quotient"]),
    ("pressure_angle", ["worm", "pressure_angle"]),
    ("hand", ["worm", "hand"]),
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

/// The gear file of a pair under `gear`; keys of the table that it determines are errors.
pub fn read_pair(f: &mut TableReader) -> Option<PairMesh> {
    let named = NamedFile::read(f, "gear")?;
    let kind = *named.collect(f, pair_kind(&named.source).map_err(|e| vec![e]))?;
    if kind == PairKind::Worm {
        let message = "a [[gear_pair]] takes the gear file of a cylindrical or a bevel pair";
        f.report_key(Code::Conflict, "gear", message, "make it a [[worm_pair]]");
        return None;
    }
    if kind != PairKind::Bevel {
        let mesh = cylindrical(f, "", named, DETERMINED_OF_PAIR)?;
        return Some(PairMesh::Cylindrical(mesh));
    }
    named.refuse_determined(f, DETERMINED_OF_BEVEL);
    let stated = stated_stiffness(f, "");
    let made = bevel_file::read(&named.source, &Flags::default())
        .map_err(|errors| errors.as_slice().to_vec())
        .and_then(|bevel| {
            let file = named.mesh_file(&bevel.span, &bevel.mesh.torques, stated);
            BevelMesh::new(file, bevel).map_err(|e| vec![e])
        });
    Some(PairMesh::Bevel(named.collect(f, made)?))
}

/// The gear file of a cylindrical worm with its wheel under `gear`; keys of the table that it determines are errors. The wheel is conjugate
/// to the worm: there is no transmission error.
pub fn read_worm(f: &mut TableReader) -> Option<Arc<WormFile>> {
    let named = NamedFile::read(f, "gear")?;
    let kind = *named.collect(f, pair_kind(&named.source).map_err(|e| vec![e]))?;
    let is_cylindrical = kind == PairKind::Worm && !plane_worm_file::is_plane_worm(&named.source);
    if !is_cylindrical {
        let message = "a [[worm_pair]] takes the gear file of a cylindrical worm with its wheel";
        let hint = "name a file with pair = { kind = \"worm\" } and another type than \"plane-enveloping\"";
        f.report_key(Code::Conflict, "gear", message, hint);
        return None;
    }
    named.refuse_determined(f, DETERMINED_OF_WORM);
    let read = worm_file::read(&named.source, &Flags::default());
    named.collect(f, read.map_err(|errors| errors.as_slice().to_vec()))
}

/// The generator under `cut_on`, which cuts a member of a bevel pair.
pub fn read_generator(f: &mut TableReader, gear: Option<&PairMesh>) -> Option<CutOn> {
    let named = NamedFile::read(f, "cut_on")?;
    if !matches!(gear, Some(PairMesh::Bevel(_))) {
        let message = "`cut_on` is of bevel gears that follow a gear file";
        let hint =
            "give `gear`, the file that [work] of the generator names, or leave `cut_on` out";
        f.report_key(Code::Conflict, "cut_on", message, hint);
    }
    Some(CutOn {
        source: named.source,
        span: named.span,
    })
}

/// The gear file of cylindrical gears under `gear` with a suffix, such as `gear_sun`; keys of the table that it determines are errors.
pub fn read(
    f: &mut TableReader,
    suffix: &str,
    determined: &[(&str, [&str; 2])],
) -> Option<Arc<GearMesh>> {
    let named = NamedFile::read(f, &format!("gear{suffix}"))?;
    cylindrical(f, suffix, named, determined)
}

fn cylindrical(
    f: &mut TableReader,
    suffix: &str,
    named: NamedFile,
    determined: &[(&str, [&str; 2])],
) -> Option<Arc<GearMesh>> {
    named.refuse_determined(f, determined);
    let stated = stated_stiffness(f, suffix);
    let made = gear_file::read(&named.source, &Flags::default())
        .map_err(|errors| errors.as_slice().to_vec())
        .and_then(|file| {
            let of = named.mesh_file(&file.span, &file.mesh.torques, stated);
            mesh_of(of, &file).map_err(|e| vec![e])
        });
    named.collect(f, made)
}

/// The key that states a stiffness next to a gear file, and its place.
fn stated_stiffness(f: &TableReader, suffix: &str) -> Option<(String, SourceSpan)> {
    let keys = STIFFNESS_KEYS.map(|base| format!("{base}{suffix}"));
    let key = keys.into_iter().find(|key| f.has(key))?;
    let span = f.span_of(&key).clone();
    Some((key, span))
}

/// A file that a key of a model names.
pub(super) struct NamedFile {
    key: String,
    /// The file.
    pub(super) source: Arc<SourceFile>,
    span: SourceSpan,
}

impl NamedFile {
    /// The file under a key.
    pub(super) fn read(f: &mut TableReader, key: &str) -> Option<NamedFile> {
        let named = f.optional_text(key)?;
        let span = f.span_of(key).clone();
        // The path starts at the model, wherever [set] writes it.
        let folder = Path::new(&f.span.source().path).parent();
        let path = folder.unwrap_or(Path::new("")).join(named);
        match load::load(&path) {
            Ok(source) => Some(NamedFile {
                key: key.to_string(),
                source,
                span,
            }),
            Err(error) => {
                f.push(
                    error.with_hint("the path starts from the folder of the model"),
                    &span,
                );
                None
            }
        }
    }

    /// The file as a mesh names it, with the place of `pair` in it and its torques.
    fn mesh_file(
        &self,
        place: &SourceSpan,
        torques: &[f64],
        stated_stiffness: Option<(String, SourceSpan)>,
    ) -> MeshFile {
        MeshFile {
            source: self.source.clone(),
            place: place.clone(),
            span: self.span.clone(),
            torque: match *torques {
                [torque] => Some(torque),
                _ => None,
            },
            stated_stiffness,
        }
    }

    /// Notes keys of the table that the file determines.
    fn refuse_determined(&self, f: &mut TableReader, determined: &[(&str, [&str; 2])]) {
        for (own, place) in determined {
            if f.has(own) {
                let place = place_of(&self.source, *place);
                let message = format!(
                    "`{own}` is determined by the gear file {}, line {}",
                    self.source.path,
                    place.line()
                );
                let hint = format!("leave `{own}` out, or leave `{}` out", self.key);
                f.report_key(Code::Conflict, own, message, &hint);
            }
        }
    }

    /// Notes the errors of the file with the place of its name; the mesh where there are none.
    fn collect<T>(&self, f: &mut TableReader, made: Result<T, Vec<Error>>) -> Option<Arc<T>> {
        let located = |error: Error| {
            let (file, line) = (&self.span.source().path, self.span.line());
            let label = format!("gear file of {}, {file}, line {line}", f.title);
            match error.span {
                Some(_) => error.with_label(label),
                None => error
                    .with_span(&SourceSpan::whole_file(&self.source.path))
                    .with_label(label),
            }
        };
        match made {
            Ok(mesh) => Some(Arc::new(mesh)),
            Err(errors) => {
                let errors: Vec<Error> = errors.into_iter().map(located).collect();
                errors.into_iter().for_each(|error| f.errors.push(error));
                None
            }
        }
    }
}

/// Place of a key of a gear file; that of `pair` where the file leaves it to its default.
fn place_of(source: &Arc<SourceFile>, [table, key]: [&str; 2]) -> SourceSpan {
    let root = toml::parse(source).root;
    let inner = |table: &str, key: &str| match &root.get(table)?.item.value {
        Value::Table(inner) => inner.get(key).map(|entry| entry.key_place.clone()),
        _ => None,
    };
    inner(table, key)
        .or(root.get("pair").map(|entry| entry.key_place.clone()))
        .unwrap_or(SourceSpan::new(source.clone(), 0..0))
}

/// The mesh of a gear file.
///
/// # Errors
/// Gears that cannot mesh, teeth that overlap.
fn mesh_of(of: MeshFile, file: &GearFile) -> Result<GearMesh, Error> {
    let pair = file.pair()?;
    let [low, high] = file.centre_deviation;
    let deviations = pair.members.map(|m| m.mean_thickness_deviation());
    let centre = pair.centre_distance + 0.5 * (low + high);
    let backlash = pair.backlash(centre, deviations).map(|b| b.normal);
    let Some(backlash) = backlash.filter(|play| *play > -BACKLASH_ROUNDING) else {
        let message = match backlash {
            Some(play) => format!("the teeth overlap by {:.1} µm", -1e6 * play),
            None => "the base circles do not reach each other".into(),
        };
        let side = match pair.members[1].gear.internal {
            false => "larger",
            true => "smaller",
        };
        let error = Error::new(Code::OutOfRange, message).about("centre_distance");
        return Err(file.locate(error.with_hint(format!(
            "give a {side} centre_distance, or thickness = [\"lower\", \"upper\"] below zero"
        ))));
    };
    Ok(GearMesh {
        backlash: if backlash < BACKLASH_ROUNDING {
            0.0
        } else {
            backlash
        },
        options: file.mesh_options(&pair),
        pair,
        hand: file.hand,
        file: of,
    })
}
