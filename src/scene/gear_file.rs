//! Reads a gear file: `pair`, `rack`, `pinion` and `gear`, `[assembly]`, `[mesh]`.

use std::f64::consts::PI;
use std::sync::Arc;

use super::gear_kind::{PairKind, pair_kind};
use super::gear_member::{default_rack, member, pair, rack, rack_defaults};
use super::mesh_table::{MeshMethod, MeshStudy, mesh};
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::{ErrorCollector, ValueRange};
use crate::base::flags::Flags;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::TableReader;
use crate::base::tables::{read_heading, read_table};
use crate::base::toml;
use crate::gear::cylindrical::member::Member;
use crate::gear::cylindrical::modification::FlankModification;
use crate::gear::cylindrical::pair::Pair;
use crate::gear::cylindrical::remedy::Design;
use crate::gear::hand::Hand;
use crate::gear::load::material::Material;
use crate::gear::load::mesh::{MeshOptions, default_slices};

/// Cylindrical gear pair described by a gear file, with the requested load.
#[derive(Debug, Clone)]
pub struct GearFile {
    /// Title in the file.
    pub title: String,
    /// Pinion and gear.
    pub members: [Member; 2],
    /// Hand of the pinion.
    pub hand: Hand,
    /// Flank modifications of pinion and gear.
    pub modifications: [FlankModification; 2],
    /// Centre distance, m; by default that without backlash.
    pub centre_distance: Option<f64>,
    /// Lower and upper deviation of the centre distance, m.
    pub centre_deviation: [f64; 2],
    /// Ball diameter for the dimension over balls of each gear, m.
    pub ball_diameters: [Option<f64>; 2],
    /// Error of the centre distance, m: `[assembly]` `offset`.
    pub offset: f64,
    /// Error ΔΣ of the shaft angle, rad.
    pub shaft_angle_error: f64,
    /// Load on the mesh and method of load sharing.
    pub mesh: MeshStudy,
    /// Values that the file leaves to their defaults, in words.
    pub defaults: Vec<String>,
    /// Position of `pair` in the file.
    pub span: SourceSpan,
    /// Source file.
    pub source: Arc<SourceFile>,
}

impl GearFile {
    /// Gear pair at the centre distance with its error; tip diameters are those at the nominal distance.
    ///
    /// # Errors
    /// Gears that cannot be made or cannot mesh, at the position of the value.
    pub fn pair(&self) -> Result<Pair, Error> {
        let locate = |error: Error| self.locate(error);
        let nominal = Pair::new(self.members, self.centre_distance).map_err(locate)?;
        if self.offset == 0.0 {
            return Ok(nominal);
        }
        let members = nominal.members.map(|member| Member {
            tip_diameter: Some(member.tip_diameter()),
            ..member
        });
        Pair::new(members, Some(nominal.centre_distance + self.offset)).map_err(locate)
    }

    /// Adds the position of the error's key: that in the member, else that of the shared key, else its table, else `pair`.
    pub fn locate(&self, error: Error) -> Error {
        if error.span.is_some() {
            return error;
        }
        let root = toml::parse(&self.source).root;
        let key = error.key.as_deref().unwrap_or_default();
        let (part, shared) = key.split_once('.').unwrap_or((key, key));
        let tables = ["", "pair.", "mesh.", "assembly."];
        let shared = tables.map(|table| format!("{table}{shared}"));
        let span = std::iter::once(key)
            .chain(shared.iter().map(String::as_str))
            .chain([part])
            .find_map(|path| root.place(path).cloned());
        error.with_span(&span.unwrap_or(self.span.clone()))
    }

    /// Design parameters of the pair.
    pub fn design(&self) -> Design {
        Design {
            members: self.members,
            centre_distance: self.centre_distance,
        }
    }

    /// Error for a mesh without a torque.
    pub fn missing_torque_error(&self) -> Error {
        let message = "no torque is given, and an unloaded mesh has no stiffness";
        Error::new(Code::MissingKey, message)
            .with_span(&self.span)
            .with_hint("write [mesh] with torque = \"100 N·m\" into the file")
    }

    /// Options of the loaded mesh of the pair.
    pub fn mesh_options(&self, pair: &Pair) -> MeshOptions {
        MeshOptions {
            method: self.mesh.method,
            materials: [Material::default(); 2],
            modifications: self.modifications,
            misalignment: self.shaft_angle_error * pair.working_pressure_angle.cos(),
            // The axis of the driving pinion, about which it turns by the right-hand rule, points to the far end; there the teeth of
            // a right-hand pinion lead.
            far_end_leads: self.hand == Hand::Right,
            positions: self.mesh.positions,
            slices: self.mesh.slices,
        }
    }
}

/// Reads a gear file of a cylindrical pair; flags override its `[mesh]`.
///
/// # Errors
/// All errors of the file and of the flags.
pub fn read(source: &Arc<SourceFile>, flags: &Flags) -> Result<GearFile, Errors> {
    if pair_kind(source)? != PairKind::Cylindrical {
        let message = "a machine cannot use the mesh of this kind of gear file";
        let hint = "name a file of a cylindrical or bevel pair, or state k, backlash and mesh_angles of the pair";
        let span = SourceSpan::new(source.clone(), 0..0);
        let error = Error::new(Code::Conflict, message).with_span(&span);
        return Err(error.with_hint(hint).into());
    }
    let document = toml::parse(source);
    let mut errors = ErrorCollector::default();
    errors.record_units(&document);
    let span = SourceSpan::new(source.clone(), 0..0);
    let mut f = TableReader::new(&document.root, span, "the gear file", &mut errors);
    let title = read_heading(&mut f);
    let span = f.span_of("pair").clone();
    let pair = read_table(&mut f, "pair", pair);
    f.require("pair");
    let rack = read_table(&mut f, "rack", rack);
    let pinion = read_table(&mut f, "pinion", member);
    f.require("pinion");
    let gear = read_table(&mut f, "gear", member);
    f.require("gear");
    let [offset, shaft_angle_error] = read_table(&mut f, "assembly", assembly).unwrap_or_default();
    if f.has("contact") {
        f.item("contact", "nothing");
        let message = "[contact] applies to point contact only";
        let hint = "cylindrical gears have line contact: use `positions` and `slices` of [mesh]";
        f.report_key(Code::Conflict, "contact", message, hint);
    }
    let study = read_table(&mut f, "mesh", mesh).unwrap_or_default();
    f.finish();
    let ErrorCollector {
        bare_si,
        mut errors,
        ..
    } = errors;
    errors.extend(document.syntax_error.clone());
    Errors::into_result(errors, || ())?;
    let (Some(pair), Some(pinion), Some(gear)) = (pair, pinion, gear) else {
        let missing = Error::new(Code::MissingKey, "the gears are not described").with_span(&span);
        return Err(missing.into());
    };
    let study = flags.read_over(&document, "mesh", &bare_si, study, mesh)?;
    if let (true, Some(flag)) = (study.torques.is_empty(), flags.names().next()) {
        let message = format!("{flag} has no effect without a torque");
        let error = Error::new(Code::Usage, message);
        return Err(error
            .with_hint("add --torque, or `torque` in [mesh]")
            .into());
    }
    let method = study.method([pinion.bore_diameter, gear.bore_diameter], &span)?;
    let mut defaults = Vec::new();
    pair.name_defaults(&mut defaults);
    let shared = rack.unwrap_or_else(|| default_rack(pair.pressure_angle(), &mut defaults));
    let members = [("pinion", &pinion), ("gear", &gear)]
        .map(|(name, member)| pair.member(name, member, shared, &mut defaults));
    let tables = [pinion, gear];
    for (table, name) in [
        ("", "rack"),
        ("pinion", "pinion.rack"),
        ("gear", "gear.rack"),
    ] {
        let parent = match table {
            "" => Some(&document.root),
            _ => document.root.table(table).map(|(table, _)| table),
        };
        let rack = parent.and_then(|parent| parent.table("rack"));
        defaults.extend(rack.and_then(|(rack, _)| rack_defaults(rack, name)));
    }
    let hand = pair.pinion_hand(&tables, &mut defaults)?;
    let default = MeshOptions::default();
    let width = members[0].face_width.min(members[1].face_width);
    let overlap = width * members[0].gear.helix.sin().abs() / (PI * members[0].gear.module);
    let slices = study.slices.map_or(default_slices(overlap), |n| n as usize);
    if !study.torques.is_empty() {
        let options = [
            (
                study.positions.is_none(),
                format!("positions: {} in a pitch", default.positions),
            ),
            (study.slices.is_none(), format!("slices: {slices}")),
            (study.method.is_none(), "method: energy".into()),
            (
                study.body.is_none() && !matches!(study.method, Some(MeshMethod::Iso6336)),
                "body: half-plane".into(),
            ),
        ];
        let missing = options.into_iter().filter(|(is_missing, _)| *is_missing);
        defaults.extend(missing.map(|(_, text)| format!("mesh.{text}")));
    }
    Ok(GearFile {
        title,
        members,
        hand,
        ball_diameters: [tables[0].ball_diameter, tables[1].ball_diameter],
        modifications: [0, 1].map(|i| tables[i].modification(&members[i].gear)),
        centre_distance: pair.centre_distance,
        centre_deviation: pair.centre_deviation,
        offset,
        shaft_angle_error,
        mesh: MeshStudy {
            torques: study.torques,
            method,
            positions: study.positions.map_or(default.positions, |n| n as usize),
            slices,
            least_relief: study.least_relief,
        },
        defaults,
        span,
        source: source.clone(),
    })
}

/// Range of the shaft angle error for which flanks still touch along lines.
const SHAFT_ANGLE_ERROR: ValueRange =
    ValueRange::Open(-PI / 180.0, PI / 180.0, "between −1° and 1°");
/// Reads the errors of centre distance, m, and shaft angle, rad.
fn assembly(f: &mut TableReader) -> [f64; 2] {
    for key in ["pinion_axial", "gear_axial"] {
        if f.has(key) {
            f.item(key, "nothing");
            let message = format!("`{key}` has no effect on the mesh of cylindrical gears");
            f.report_key(
                Code::Conflict,
                key,
                message,
                "omit it; `face_width` is the common width",
            );
        }
    }
    let offset = f.optional_quantity("offset", QuantityKind::Length, ValueRange::Any);
    let angle = f.optional_quantity("shaft_angle_error", QuantityKind::Angle, SHAFT_ANGLE_ERROR);
    [offset.unwrap_or(0.0), angle.unwrap_or(0.0)]
}
