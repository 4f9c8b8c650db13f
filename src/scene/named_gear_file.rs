//! Gear files named by meshes of a model: the values they determine, and keys of the model that contradict them.

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

/// Tolerance of a negative backlash, m, for the rounding of the centre distance.
const BACKLASH_ROUNDING: f64 = 1e-6;

/// Keys of a gear pair that a gear file determines, each with its table and key there.
const CYLINDRICAL_FILE_KEYS: &[(&str, [&str; 2])] = &[
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
const BEVEL_FILE_KEYS: &[(&str, [&str; 2])] = &[
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
const WORM_FILE_KEYS: &[(&str, [&str; 2])] = &[
    ("teeth", ["worm", "starts"]),
    ("module", ["worm", "module"]),
    ("lead_angle", ["worm", "diameter_quotient"]),
    ("pressure_angle", ["worm", "pressure_angle"]),
    ("hand", ["worm", "hand"]),
];

/// Keys of a planetary stage that the gear file of a mesh determines.
pub const STAGE_FILE_KEYS: &[(&str, [&str; 2])] = &[
    ("teeth", ["pinion", "teeth"]),
    ("module", ["pair", "module"]),
    ("pressure_angle", ["pair", "pressure_angle"]),
    ("base_radii", ["pair", "module"]),
    ("carrier_radius", ["pair", "centre_distance"]),
    ("backlash_sun", ["pair", "centre_distance"]),
    ("backlash_ring", ["pair", "centre_distance"]),
];

/// Keys of the stiffness, which a gear file determines if a torque is known.
const STIFFNESS_KEYS: [&str; 3] = ["k", "k_wave", "characteristic"];

/// Reads the gear file of a pair under `gear`; reports keys of the table that it determines.
pub fn read_pair(f: &mut TableReader) -> Option<PairMesh> {
    let file = NamedFile::read(f, "gear")?;
    let kind = *file.collect(f, pair_kind(&file.source).map_err(|e| vec![e]))?;
    if kind == PairKind::Worm {
        let message = "a [[gear_pair]] takes the gear file of a cylindrical or a bevel pair";
        f.report_key(Code::Conflict, "gear", message, "make it a [[worm_pair]]");
        return None;
    }
    if kind != PairKind::Bevel {
        let mesh = read_cylindrical(f, "", file, CYLINDRICAL_FILE_KEYS)?;
        return Some(PairMesh::Cylindrical(mesh));
    }
    file.refuse_determined(f, BEVEL_FILE_KEYS);
    let stiffness_key = stated_stiffness(f, "");
    let mesh = bevel_file::read(&file.source, &Flags::default())
        .map_err(|errors| errors.as_slice().to_vec())
        .and_then(|bevel| {
            let mesh_file = file.mesh_file(&bevel.span, &bevel.mesh.torques, stiffness_key);
            BevelMesh::new(mesh_file, bevel).map_err(|e| vec![e])
        });
    Some(PairMesh::Bevel(file.collect(f, mesh)?))
}

/// Reads the gear file of a cylindrical worm with its wheel under `gear`; reports keys of the table that it determines. The wheel is
/// conjugate to the worm, so there is no transmission error.
pub fn read_worm(f: &mut TableReader) -> Option<Arc<WormFile>> {
    let file = NamedFile::read(f, "gear")?;
    let kind = *file.collect(f, pair_kind(&file.source).map_err(|e| vec![e]))?;
    let is_cylindrical = kind == PairKind::Worm && !plane_worm_file::is_plane_worm(&file.source);
    if !is_cylindrical {
        let message = "a [[worm_pair]] takes the gear file of a cylindrical worm with its wheel";
        let hint = "name a file with pair = { kind = \"worm\" } and another type than \"plane-enveloping\"";
        f.report_key(Code::Conflict, "gear", message, hint);
        return None;
    }
    file.refuse_determined(f, WORM_FILE_KEYS);
    let worm = worm_file::read(&file.source, &Flags::default());
    file.collect(f, worm.map_err(|errors| errors.as_slice().to_vec()))
}

/// Reads the generator under `cut_on`, on which a member of a bevel pair is cut.
pub fn read_generator(f: &mut TableReader, gear: Option<&PairMesh>) -> Option<CutOn> {
    let file = NamedFile::read(f, "cut_on")?;
    if !matches!(gear, Some(PairMesh::Bevel(_))) {
        let message = "`cut_on` applies to bevel gears with a gear file only";
        let hint = "give `gear`, the file named in [work] of the generator, or omit `cut_on`";
        f.report_key(Code::Conflict, "cut_on", message, hint);
    }
    Some(CutOn {
        source: file.source,
        span: file.span,
    })
}

/// Reads the gear file of cylindrical gears under `gear` with a suffix, such as `gear_sun`; reports keys that it determines.
pub fn read(
    f: &mut TableReader,
    suffix: &str,
    determined: &[(&str, [&str; 2])],
) -> Option<Arc<GearMesh>> {
    let file = NamedFile::read(f, &format!("gear{suffix}"))?;
    read_cylindrical(f, suffix, file, determined)
}

fn read_cylindrical(
    f: &mut TableReader,
    suffix: &str,
    file: NamedFile,
    determined: &[(&str, [&str; 2])],
) -> Option<Arc<GearMesh>> {
    file.refuse_determined(f, determined);
    let stiffness_key = stated_stiffness(f, suffix);
    let mesh = gear_file::read(&file.source, &Flags::default())
        .map_err(|errors| errors.as_slice().to_vec())
        .and_then(|gears| {
            let mesh_file = file.mesh_file(&gears.span, &gears.mesh.torques, stiffness_key);
            build_mesh(mesh_file, &gears).map_err(|e| vec![e])
        });
    file.collect(f, mesh)
}

/// Key that states a stiffness in addition to a gear file, and its position.
fn stated_stiffness(f: &TableReader, suffix: &str) -> Option<(String, SourceSpan)> {
    let keys = STIFFNESS_KEYS.map(|base| format!("{base}{suffix}"));
    let key = keys.into_iter().find(|key| f.has(key))?;
    let span = f.span_of(&key).clone();
    Some((key, span))
}

/// Gear file named by a key of a model.
pub(super) struct NamedFile {
    key: String,
    /// Source file.
    pub(super) source: Arc<SourceFile>,
    span: SourceSpan,
}

impl NamedFile {
    /// Loads the file named under a key.
    pub(super) fn read(f: &mut TableReader, key: &str) -> Option<NamedFile> {
        let name = f.optional_text(key)?;
        let span = f.span_of(key).clone();
        // The path is relative to the model, even if [set] of a scene states it.
        let folder = Path::new(&f.span.source().path).parent();
        let path = folder.unwrap_or(Path::new("")).join(name);
        match load::load(&path) {
            Ok(source) => Some(NamedFile {
                key: key.to_string(),
                source,
                span,
            }),
            Err(error) => {
                f.push(
                    error.with_hint("the path is relative to the folder of the model"),
                    &span,
                );
                None
            }
        }
    }

    /// Source of a mesh, with the position of `pair` in the file and its torque, N·m, if it states exactly one.
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

    /// Reports keys of the table that the file determines.
    fn refuse_determined(&self, f: &mut TableReader, determined: &[(&str, [&str; 2])]) {
        for (key, place) in determined {
            if f.has(key) {
                let place = locate_key(&self.source, *place);
                let message = format!(
                    "`{key}` is determined by the gear file {}, line {}",
                    self.source.path,
                    place.line()
                );
                let hint = format!("omit `{key}` or `{}`", self.key);
                f.report_key(Code::Conflict, key, message, &hint);
            }
        }
    }

    /// Reports the errors of the file at its name in the model; returns the value if there are none.
    fn collect<T>(&self, f: &mut TableReader, result: Result<T, Vec<Error>>) -> Option<Arc<T>> {
        let locate = |error: Error| {
            let (file, line) = (&self.span.source().path, self.span.line());
            let label = format!("gear file of {}, {file}, line {line}", f.title);
            match error.span {
                Some(_) => error.with_label(label),
                None => error
                    .with_span(&SourceSpan::whole_file(&self.source.path))
                    .with_label(label),
            }
        };
        match result {
            Ok(mesh) => Some(Arc::new(mesh)),
            Err(errors) => {
                let errors: Vec<Error> = errors.into_iter().map(locate).collect();
                errors.into_iter().for_each(|error| f.errors.push(error));
                None
            }
        }
    }
}

/// Position of a key in a gear file; that of `pair` where the file omits the key.
fn locate_key(source: &Arc<SourceFile>, [table, key]: [&str; 2]) -> SourceSpan {
    let root = toml::parse(source).root;
    let find = |table: &str, key: &str| match &root.get(table)?.item.value {
        Value::Table(table) => table.get(key).map(|entry| entry.key_span.clone()),
        _ => None,
    };
    find(table, key)
        .or(root.get("pair").map(|entry| entry.key_span.clone()))
        .unwrap_or(SourceSpan::new(source.clone(), 0..0))
}

/// Builds the mesh of a gear file at its mean centre distance and mean tooth thickness.
///
/// # Errors
/// Gears that cannot mesh, teeth that overlap.
fn build_mesh(source: MeshFile, file: &GearFile) -> Result<GearMesh, Error> {
    let pair = file.pair()?;
    let [low, high] = file.centre_deviation;
    let deviations = pair.members.map(|m| m.mean_thickness_deviation());
    let centre = pair.centre_distance + 0.5 * (low + high);
    let backlash = pair.backlash(centre, deviations).map(|b| b.normal);
    let Some(backlash) = backlash.filter(|play| *play > -BACKLASH_ROUNDING) else {
        let message = match backlash {
            Some(play) => format!("the teeth overlap by {:.1} µm", -1e6 * play),
            None => "the base circles do not touch".into(),
        };
        let side = match pair.members[1].gear.internal {
            false => "larger",
            true => "smaller",
        };
        let error = Error::new(Code::OutOfRange, message).with_key("centre_distance");
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
        file: source,
    })
}
