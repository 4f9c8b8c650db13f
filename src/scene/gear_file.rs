//! Reads a gear file: `pair`, `rack`, `pinion` and `gear`, `[assembly]`, `[mesh]`.

use std::f64::consts::PI;
use std::sync::Arc;

use super::laws::Hand;
use super::mesh_torques::torques;
use super::shared_keys::{
    self, DEFAULT_PRESSURE_ANGLE, MAX_TEETH, PRESSURE_ANGLE_RANGE, read_profile_shift,
    read_thickness,
};
use crate::base::bound::Bound;
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::{ErrorCollector, ValueRange};
use crate::base::flags::Flags;
use crate::base::quantity::format_number;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::{TableReader, Word};
use crate::base::tables::{read_heading, read_table};
use crate::base::toml::{self, Table, Value};
use crate::gear::cylindrical::basic_rack::BasicRack;
use crate::gear::cylindrical::involute::InvoluteGear;
use crate::gear::cylindrical::member::Member;
use crate::gear::cylindrical::modification::{FlankModification, Relief};
use crate::gear::cylindrical::pair::Pair;
use crate::gear::cylindrical::remedy::Design;
use crate::gear::load::body::Body;
use crate::gear::load::compliance::StiffnessMethod;
use crate::gear::load::hertz::ContactModel;
use crate::gear::load::material::Material;
use crate::gear::load::mesh::{MAX_POSITIONS, MAX_SLICES, MeshOptions, default_slices};

/// A pair of cylindrical gears as its file describes it, with the requested load.
#[derive(Debug, Clone)]
pub struct GearFile {
    /// Title in the file.
    pub title: String,
    /// Pinion and gear.
    pub members: [Member; 2],
    /// Hand of the pinion.
    pub hand: Hand,
    /// Modifications of their flanks.
    pub modifications: [FlankModification; 2],
    /// Centre distance, m; without backlash by default.
    pub centre_distance: Option<f64>,
    /// Lower and upper deviation of the centre distance, m.
    pub centre_deviation: [f64; 2],
    /// Ball for the dimension over balls of each gear, m.
    pub ball_diameters: [Option<f64>; 2],
    /// Error of the centre distance, m: `[assembly]` `offset`.
    pub offset: f64,
    /// Error ΔΣ of the shaft angle, rad.
    pub shaft_angle_error: f64,
    /// Load on the mesh and how it is shared.
    pub mesh: MeshStudy,
    /// Values that the file leaves to their defaults, in words.
    pub defaults: Vec<String>,
    /// Place of `pair`.
    pub span: SourceSpan,
    /// The file.
    pub source: Arc<SourceFile>,
}

/// Load on a mesh and its discretisation.
#[derive(Debug, Clone)]
pub struct MeshStudy {
    /// Torques at the pinion, N·m; the mesh is computed where there are any.
    pub torques: Vec<f64>,
    /// Stiffness of the tooth pairs.
    pub method: StiffnessMethod,
    /// Positions in one pitch.
    pub positions: usize,
    /// Slices along the face width.
    pub slices: usize,
    /// Seek the tip relief of least peak-to-peak over the torques.
    pub least_relief: bool,
}

impl GearFile {
    /// The gears in mesh, with the error of the centre distance: tips are those of the nominal one.
    ///
    /// # Errors
    /// Gears that cannot be made or cannot mesh, at the place of the value.
    pub fn pair(&self) -> Result<Pair, Error> {
        let at = |error: Error| self.locate(error);
        let nominal = Pair::new(self.members, self.centre_distance).map_err(at)?;
        if self.offset == 0.0 {
            return Ok(nominal);
        }
        let made = nominal.members.map(|member| Member {
            tip_diameter: Some(member.tip_diameter()),
            ..member
        });
        Pair::new(made, Some(nominal.centre_distance + self.offset)).map_err(at)
    }

    /// The error at the place of its key: of the member, else of what both share, else of its table, else of `pair`.
    pub fn locate(&self, error: Error) -> Error {
        if error.span.is_some() {
            return error;
        }
        let root = toml::parse(&self.source).root;
        let key = error.key.as_deref().unwrap_or_default();
        let (part, shared) = key.split_once('.').unwrap_or((key, key));
        let tables = ["", "pair.", "mesh.", "assembly."];
        let shared = tables.map(|table| format!("{table}{shared}"));
        let place = std::iter::once(key)
            .chain(shared.iter().map(String::as_str))
            .chain([part])
            .find_map(|path| root.place(path).cloned());
        error.with_span(&place.unwrap_or(self.span.clone()))
    }

    /// The gears as the file describes them.
    pub fn design(&self) -> Design {
        Design {
            members: self.members,
            centre_distance: self.centre_distance,
        }
    }

    /// The error of a mesh without a load.
    pub fn no_torque(&self) -> Error {
        let message = "no torque is given, and without a load the mesh has no stiffness";
        Error::new(Code::MissingKey, message)
            .with_span(&self.span)
            .with_hint("write [mesh] with torque = \"100 N·m\" into the file")
    }

    /// Options of the loaded mesh of its pair.
    pub fn mesh_options(&self, pair: &Pair) -> MeshOptions {
        MeshOptions {
            method: self.mesh.method,
            materials: [Material::default(); 2],
            modifications: self.modifications,
            misalignment: self.shaft_angle_error * pair.working_pressure_angle.cos(),
            // The far end lies where the driving pinion's axis points, about which it turns by the right hand: there the teeth of a
            // right-hand pinion are ahead.
            far_end_leads: self.hand == Hand::Right,
            positions: self.mesh.positions,
            slices: self.mesh.slices,
        }
    }
}

/// Face width by default, in modules.
const DEFAULT_WIDTH: f64 = 10.0;

/// Whether a TOML file describes gears.
pub fn is_gear_file(source: &Arc<SourceFile>) -> bool {
    let root = toml::parse(source).root;
    ["pair", "helicoid"]
        .iter()
        .any(|key| root.get(key).is_some())
}

/// Refuses a file without any table of a gear file, naming the command that takes it.
///
/// # Errors
/// `Syntax`, or `Usage` at the head of the file.
pub fn check_is_gear_file(source: &Arc<SourceFile>) -> Result<(), Error> {
    let toml::Document {
        root, syntax_error, ..
    } = toml::parse(source);
    if let Some(error) = syntax_error {
        return Err(error);
    }
    if ["pair", "pinion", "gear", "helicoid"]
        .iter()
        .any(|key| root.get(key).is_some())
    {
        return Ok(());
    }
    let path = &source.path;
    let (what, hint) = match root.table("measured_gear") {
        Some((gear, _)) if gear.get("spans").is_some() => (
            "a gear given by readings",
            format!("run `geardyn gear reverse {path}`"),
        ),
        Some(_) => ("a measured gear", format!("run `geardyn measure {path}`")),
        None => (
            "not a gear file",
            format!(
                "a gear file has `pair`, `pinion` and `gear`, or `helicoid`; `geardyn check {path}` says whether it is a machine model"
            ),
        ),
    };
    let error = Error::new(Code::Usage, format!("the file has no `pair`: it is {what}"));
    Err(error
        .with_span(&SourceSpan::new(source.clone(), 0..0))
        .with_hint(hint))
}

/// Kinds of pairs that a gear file describes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PairKind {
    /// Involute gears on parallel axes.
    Cylindrical,
    /// Gears of a varying ratio.
    NonCircular,
    /// Bevel and hypoid gears by machine settings.
    Bevel,
    /// A worm with its wheel.
    Worm,
    /// Helical gears on crossed axes.
    Crossed,
    /// A helicoid with the tool that cuts it.
    Helicoid,
}

/// The kind of pair in a gear file; cylindrical where it states no other kind that is known.
pub fn pair_kind(source: &Arc<SourceFile>) -> PairKind {
    let root = toml::parse(source).root;
    if root.get("helicoid").is_some() {
        return PairKind::Helicoid;
    }
    let kind = root.table("pair").and_then(|(pair, _)| pair.get("kind"));
    match kind.map(|entry| &entry.item.value) {
        Some(Value::String(kind)) if kind == "non-circular" => PairKind::NonCircular,
        Some(Value::String(kind)) if kind == "bevel" => PairKind::Bevel,
        Some(Value::String(kind)) if kind == "worm" => PairKind::Worm,
        Some(Value::String(kind)) if kind == "crossed" => PairKind::Crossed,
        _ => PairKind::Cylindrical,
    }
}

/// Reads one with the flags laid over its `[mesh]`.
///
/// # Errors
/// Everything wrong in it and in the flags.
pub fn read(source: &Arc<SourceFile>, flags: &Flags) -> Result<GearFile, Errors> {
    if pair_kind(source) != PairKind::Cylindrical {
        let message = "a machine takes no mesh from a gear file of this kind";
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
    let first = read_table(&mut f, "pinion", member);
    f.require("pinion");
    let second = read_table(&mut f, "gear", member);
    f.require("gear");
    let [offset, shaft_angle_error] = read_table(&mut f, "assembly", assembly).unwrap_or_default();
    if f.has("contact") {
        f.item("contact", "nothing");
        let message = "[contact] belongs to flanks that touch in a point";
        let hint = "cylindrical gears touch along lines: [mesh] has `positions` and `slices`";
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
    let (Some(pair), Some(first), Some(second)) = (pair, first, second) else {
        let missing = Error::new(Code::MissingKey, "the gears are not described").with_span(&span);
        return Err(missing.into());
    };
    let study = flags.read_over(&document, "mesh", &bare_si, study, mesh)?;
    if let (true, Some(flag)) = (study.torques.is_empty(), flags.names().next()) {
        let message = format!("{flag} does nothing without a torque");
        let error = Error::new(Code::Usage, message);
        return Err(error
            .with_hint("add --torque, or `torque` in [mesh]")
            .into());
    }
    let method = study.method([first.bore_diameter, second.bore_diameter], &span)?;
    let mut defaults = Vec::new();
    pair.name_defaults(&mut defaults);
    let shared = rack.unwrap_or_else(|| default_rack(pair.pressure_angle(), &mut defaults));
    let members = [("pinion", &first), ("gear", &second)]
        .map(|(name, member)| pair.member(name, member, shared, &mut defaults));
    let tables = [first, second];
    for (table, name) in [
        ("", "rack"),
        ("pinion", "pinion.rack"),
        ("gear", "gear.rack"),
    ] {
        let of = match table {
            "" => Some(&document.root),
            _ => document.root.table(table).map(|(table, _)| table),
        };
        let rack = of.and_then(|of| of.table("rack"));
        defaults.extend(rack.and_then(|(rack, _)| rack_defaults(rack, name)));
    }
    let hand = pair.pinion_hand(&tables, &mut defaults)?;
    let usual = MeshOptions::default();
    let width = members[0].face_width.min(members[1].face_width);
    let overlap = width * members[0].gear.helix.sin().abs() / (PI * members[0].gear.module);
    let slices = study.slices.map_or(default_slices(overlap), |n| n as usize);
    if !study.torques.is_empty() {
        let all = [
            (
                study.positions.is_none(),
                format!("positions: {} in a pitch", usual.positions),
            ),
            (study.slices.is_none(), format!("slices: {slices}")),
            (study.method.is_none(), "method: energy".into()),
            (
                study.body.is_none() && !matches!(study.method, Some(MeshMethod::Iso6336)),
                "body: half-plane".into(),
            ),
        ];
        let missing = all.into_iter().filter(|(is_missing, _)| *is_missing);
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
            positions: study.positions.map_or(usual.positions, |n| n as usize),
            slices,
            least_relief: study.least_relief,
        },
        defaults,
        span,
        source: source.clone(),
    })
}

/// Errors of the shaft angle for which flanks still meet along their lines.
const SHAFT_ANGLE_ERROR: ValueRange =
    ValueRange::Open(-PI / 180.0, PI / 180.0, "between −1° and 1°");
/// Helix angle of cylindrical gears: beyond it the transverse module is six times the normal one.
const HELIX_ANGLE: ValueRange =
    ValueRange::HalfOpen(0.0, 4.0 / 9.0 * PI, "at least 0° and below 80°");

/// Errors of centre distance, m, and shaft angle, rad.
fn assembly(f: &mut TableReader) -> [f64; 2] {
    for key in ["pinion_axial", "gear_axial"] {
        if f.has(key) {
            f.item(key, "nothing");
            let message = format!("`{key}` does not change the mesh of cylindrical gears");
            f.report_key(
                Code::Conflict,
                key,
                message,
                "leave it out; `face_width` is the common width",
            );
        }
    }
    let offset = f.optional_quantity("offset", QuantityKind::Length, ValueRange::Any);
    let angle = f.optional_quantity("shaft_angle_error", QuantityKind::Angle, SHAFT_ANGLE_ERROR);
    [offset.unwrap_or(0.0), angle.unwrap_or(0.0)]
}

/// `pair`: what both gears share.
struct PairTable {
    module: f64,
    pressure_angle: Option<f64>,
    helix_angle: Option<f64>,
    centre_distance: Option<f64>,
    centre_deviation: [f64; 2],
}

fn pair(f: &mut TableReader) -> PairTable {
    let kinds = ["cylindrical", "non-circular", "bevel", "worm", "crossed"];
    f.choice("kind", &kinds.map(|kind| (kind, kind)));
    f.require("kind");
    let length = |f: &mut TableReader, key| {
        f.optional_quantity(key, QuantityKind::Length, ValueRange::Positive)
    };
    let module = length(f, "module");
    f.require("module");
    let pressure_angle =
        f.optional_quantity("pressure_angle", QuantityKind::Angle, PRESSURE_ANGLE_RANGE);
    let helix_angle = f.optional_quantity("helix_angle", QuantityKind::Angle, HELIX_ANGLE);
    let deviation = f.optional_quantities(
        "centre_distance_deviation",
        QuantityKind::Length,
        ValueRange::Any,
        Some(2),
    );
    let deviation: Option<[f64; 2]> = deviation.and_then(|d| d.try_into().ok());
    if deviation.is_some_and(|[low, high]| low > high) {
        let key = "centre_distance_deviation";
        let hint = "it takes the lower deviation first: [\"-20 µm\", \"20 µm\"]";
        f.report_key(Code::OutOfRange, key, format!("`{key}` falls"), hint);
    }
    PairTable {
        module: module.unwrap_or(f64::NAN),
        pressure_angle,
        helix_angle,
        centre_distance: length(f, "centre_distance"),
        centre_deviation: deviation.unwrap_or([0.0; 2]),
    }
}

/// Profile A of ISO 53, its tip rounded as far as the tool's tooth allows where the pressure angle leaves less.
fn default_rack(pressure_angle: f64, defaults: &mut Vec<String>) -> BasicRack {
    let usual = BasicRack::PROFILE_A;
    let full = Bound::AtMost(usual.full_tip_radius(pressure_angle)).text(4);
    match full.parse::<f64>() {
        Ok(tip_radius) if (0.0..usual.tip_radius).contains(&tip_radius) => {
            defaults.push(format!(
                "rack: ISO 53 profile A with tip_radius {full}, the full rounding"
            ));
            BasicRack {
                tip_radius,
                ..usual
            }
        }
        _ => {
            defaults.push("rack: ISO 53 profile A".into());
            usual
        }
    }
}

/// The keys of profile A that a rack leaves out.
fn rack_defaults(rack: &Table, name: &str) -> Option<String> {
    let usual = BasicRack::PROFILE_A;
    let all = [
        ("addendum", usual.addendum),
        ("dedendum", usual.dedendum),
        ("tip_radius", usual.tip_radius),
        ("protuberance", usual.protuberance),
    ];
    let missing = all.iter().filter(|(key, _)| rack.get(key).is_none());
    let texts: Vec<String> = missing
        .map(|(key, value)| format!("{key} {value}"))
        .collect();
    (!texts.is_empty()).then(|| format!("{name}: {} of ISO 53 profile A", texts.join(", ")))
}

impl PairTable {
    fn pressure_angle(&self) -> f64 {
        self.pressure_angle.unwrap_or(DEFAULT_PRESSURE_ANGLE)
    }

    fn helix_angle(&self) -> f64 {
        self.helix_angle.unwrap_or(0.0)
    }

    /// Notes what `pair` leaves out.
    fn name_defaults(&self, defaults: &mut Vec<String>) {
        let angle = DEFAULT_PRESSURE_ANGLE.to_degrees();
        let missing = [
            (
                self.pressure_angle.is_none(),
                format!("pair.pressure_angle: {angle:.0} deg"),
            ),
            (self.helix_angle.is_none(), "pair.helix_angle: 0".into()),
            (
                self.centre_distance.is_none(),
                "pair.centre_distance: without backlash at nominal thickness".into(),
            ),
        ];
        defaults.extend(
            missing
                .into_iter()
                .filter(|(is_missing, _)| *is_missing)
                .map(|(_, text)| text),
        );
    }

    /// Hand of the pinion: external helical gears in mesh have opposite hands, a pinion has that of its ring.
    fn pinion_hand(
        &self,
        [pinion, gear]: &[MemberTable; 2],
        defaults: &mut Vec<String>,
    ) -> Result<Hand, Error> {
        if self.helix_angle() == 0.0 {
            return Ok(pinion.hand.unwrap_or_default());
        }
        let mate_of = |hand: Hand| match (hand, gear.internal) {
            (hand, true) => hand,
            (Hand::Right, false) => Hand::Left,
            (Hand::Left, false) => Hand::Right,
        };
        let from_gear = gear.hand.map(mate_of);
        if let (Some(own), Some(needed)) = (pinion.hand, from_gear)
            && own != needed
        {
            let (message, hint) = match gear.internal {
                false => (
                    "pinion.hand and gear.hand are the same: helical gears of an external pair have opposite hands",
                    "give one of them only, or opposite hands",
                ),
                true => (
                    "pinion.hand and gear.hand differ: a helical pinion has the hand of its ring",
                    "give one of them only, or the same hand",
                ),
            };
            let error = Error::new(Code::Conflict, message).with_span(&gear.hand_span);
            return Err(error.with_hint(hint));
        }
        Ok(pinion.hand.or(from_gear).unwrap_or_else(|| {
            defaults.push("pinion.hand: right".into());
            Hand::Right
        }))
    }

    /// A gear of the pair; what its table leaves out is noted in `defaults`.
    fn member(
        &self,
        name: &str,
        table: &MemberTable,
        shared: BasicRack,
        defaults: &mut Vec<String>,
    ) -> Member {
        let face_width = table.face_width.unwrap_or_else(|| {
            let width = DEFAULT_WIDTH * self.module;
            let shown = format_number(1e3 * width);
            defaults.push(format!("{name}.face_width: {shown} mm, ten modules"));
            width
        });
        let profile_shift = table.profile_shift.unwrap_or_else(|| {
            defaults.push(format!("{name}.profile_shift: 0"));
            0.0
        });
        if table.thickness.is_none() {
            defaults.push(format!("{name}.thickness: no deviation"));
        }
        if table.internal && table.shaper_teeth.is_none() {
            let half = (table.teeth / 2).max(1);
            defaults.push(format!("{name}.shaper_teeth: {half}, half of the teeth"));
        }
        if table.tip_diameter.is_none() {
            defaults.push(format!(
                "{name}.tip_diameter: of the rack and the clearance"
            ));
        }
        let gear = InvoluteGear {
            teeth: table.teeth,
            module: self.module,
            pressure_angle: self.pressure_angle(),
            helix: self.helix_angle(),
            profile_shift,
            internal: table.internal,
        };
        Member {
            tip_diameter: table.tip_diameter,
            thickness_deviation: table.thickness.unwrap_or([0.0; 2]),
            shaper_teeth: table.shaper_teeth,
            ..Member::new(gear, table.rack.unwrap_or(shared), face_width)
        }
    }
}

/// `pinion` or `gear`.
struct MemberTable {
    teeth: u32,
    hand: Option<Hand>,
    hand_span: SourceSpan,
    internal: bool,
    profile_shift: Option<f64>,
    face_width: Option<f64>,
    tip_diameter: Option<f64>,
    bore_diameter: Option<f64>,
    shaper_teeth: Option<u32>,
    ball_diameter: Option<f64>,
    thickness: Option<[f64; 2]>,
    rack: Option<BasicRack>,
    tip_relief: Option<ReliefTable>,
    root_relief: Option<ReliefTable>,
    /// The other modifications of its flanks.
    modification: FlankModification,
}

/// A relief as written.
#[derive(Clone, Copy)]
struct ReliefTable {
    amount: f64,
    from: RollPlace,
}

/// A place of the involute.
#[derive(Clone, Copy)]
enum RollPlace {
    /// Length of roll, m.
    Length(f64),
    /// Roll angle ξ, rad.
    Angle(f64),
}

impl ReliefTable {
    /// The relief on a gear: `L = r_b ξ`.
    fn on(self, gear: &InvoluteGear) -> Relief {
        Relief {
            amount: self.amount,
            from: match self.from {
                RollPlace::Length(length) => length,
                RollPlace::Angle(angle) => 0.5 * gear.base_diameter() * angle,
            },
        }
    }
}

impl MemberTable {
    /// All modifications of its flanks.
    fn modification(&self, gear: &InvoluteGear) -> FlankModification {
        FlankModification {
            tip_relief: self.tip_relief.map(|relief| relief.on(gear)),
            root_relief: self.root_relief.map(|relief| relief.on(gear)),
            ..self.modification
        }
    }
}

fn member(f: &mut TableReader) -> MemberTable {
    let teeth = f.optional_count("teeth", 2, MAX_TEETH);
    f.require("teeth");
    let hand = shared_keys::stated_hand(f);
    let hand_span = f.span_of("hand").clone();
    let positive = |f: &mut TableReader, key| {
        f.optional_quantity(key, QuantityKind::Length, ValueRange::Positive)
    };
    let internal = f.flag("internal");
    let shaper_teeth = f.optional_count("shaper_teeth", 1, MAX_TEETH);
    if shaper_teeth.is_some() && !internal {
        let message = "`shaper_teeth` belongs to an internal gear; a rack cuts external teeth";
        f.report_key(Code::Conflict, "shaper_teeth", message, "leave it out");
    }
    MemberTable {
        teeth: teeth.unwrap_or(2),
        hand,
        hand_span,
        internal,
        shaper_teeth,
        profile_shift: read_profile_shift(f),
        face_width: positive(f, "face_width"),
        tip_diameter: positive(f, "tip_diameter"),
        bore_diameter: positive(f, "bore_diameter"),
        ball_diameter: positive(f, "ball_diameter"),
        thickness: read_thickness(f),
        rack: read_table(f, "rack", rack),
        tip_relief: relief(f, "tip_relief", "relief_from"),
        root_relief: relief(f, "root_relief", "root_relief_from"),
        modification: FlankModification {
            profile_crowning: amount(f, "profile_crowning"),
            helix_crowning: amount(f, "crowning"),
            helix_slope: amount(f, "helix_slope"),
            ..FlankModification::default()
        },
    }
}

fn amount(f: &mut TableReader, key: &str) -> f64 {
    f.optional_quantity(key, QuantityKind::Length, ValueRange::Any)
        .unwrap_or(0.0)
}

/// A relief and the length of roll or roll angle where it begins; both or neither.
fn relief(f: &mut TableReader, key: &str, start: &str) -> Option<ReliefTable> {
    let amount = f.optional_quantity(key, QuantityKind::Length, ValueRange::NotNegative);
    let kind = match f.holds(start, QuantityKind::Angle) {
        true => QuantityKind::Angle,
        false => QuantityKind::Length,
    };
    let from = f.optional_quantity(start, kind, ValueRange::NotNegative);
    match (f.has(key), f.has(start)) {
        (true, false) => f.report_missing(start, ", the length of roll where the relief begins"),
        (false, true) => f.report_missing(key, ", the material removed at the end of the flank"),
        _ => {}
    }
    Some(ReliefTable {
        amount: amount?,
        from: match kind {
            QuantityKind::Angle => RollPlace::Angle(from?),
            _ => RollPlace::Length(from?),
        },
    })
}

/// Reads a basic rack, in modules; profile A of ISO 53 by default.
pub(super) fn rack(f: &mut TableReader) -> BasicRack {
    let usual = BasicRack::PROFILE_A;
    let number = |f: &mut TableReader, key, usual| {
        f.optional_number(key, ValueRange::NotNegative)
            .unwrap_or(usual)
    };
    BasicRack {
        addendum: number(f, "addendum", usual.addendum),
        dedendum: number(f, "dedendum", usual.dedendum),
        tip_radius: number(f, "tip_radius", usual.tip_radius),
        protuberance: number(f, "protuberance", usual.protuberance),
    }
}

/// `[mesh]` as written.
#[derive(Debug, Default)]
pub struct MeshTable {
    torques: Vec<f64>,
    positions: Option<u32>,
    slices: Option<u32>,
    method: Option<MeshMethod>,
    body: Option<BodyModel>,
    least_relief: bool,
}

/// Stiffness of tooth pairs.
#[derive(Debug, Clone, Copy)]
pub enum MeshMethod {
    /// Potential energy of the teeth.
    Energy,
    /// c′ of ISO 6336-1.
    Iso6336,
}

impl Word for MeshMethod {
    const WORDS: &'static [(&'static str, MeshMethod, &'static str)] = &[
        (
            "energy",
            MeshMethod::Energy,
            "Potential energy of teeth with their fillets",
        ),
        (
            "iso-6336",
            MeshMethod::Iso6336,
            "c′ of ISO 6336-1:2006, constant along the flank",
        ),
    ];
}

/// Model of the gear bodies.
#[derive(Debug, Clone, Copy)]
pub enum BodyModel {
    /// No deflection below the root circle.
    Rigid,
    /// Half plane.
    HalfPlane,
    /// Elastic ring on a rigid shaft.
    Ring,
}

impl Word for BodyModel {
    const WORDS: &'static [(&'static str, BodyModel, &'static str)] = &[
        (
            "half-plane",
            BodyModel::HalfPlane,
            "Half plane in plane strain",
        ),
        (
            "ring",
            BodyModel::Ring,
            "Elastic ring on a rigid shaft; needs bore_diameter",
        ),
        (
            "rigid",
            BodyModel::Rigid,
            "No deflection below the root circle",
        ),
    ];
}

/// Reads `[mesh]`.
pub fn mesh(f: &mut TableReader) -> MeshTable {
    MeshTable {
        torques: torques(f),
        positions: f.optional_count("positions", 2, MAX_POSITIONS),
        slices: f.optional_count("slices", 1, MAX_SLICES),
        method: f.word("method"),
        body: f.word("body"),
        least_relief: f.flag("least_relief"),
    }
}

impl MeshTable {
    /// The stiffness method with bodies of the bores.
    fn method(&self, bores: [Option<f64>; 2], span: &SourceSpan) -> Result<StiffnessMethod, Error> {
        if let Some(MeshMethod::Iso6336) = self.method {
            return match self.body {
                None => Ok(StiffnessMethod::Iso6336 { webs: [None; 2] }),
                Some(_) => Err(Error::new(
                    Code::Conflict,
                    "`body` belongs to the energy method; ISO 6336-1 has solid discs",
                )
                .with_span(span)
                .with_hint("leave `body` out")),
            };
        }
        let body = |bore: Option<f64>| match (self.body, bore) {
            (Some(BodyModel::Rigid), _) => Ok(Body::Rigid),
            (None | Some(BodyModel::HalfPlane), _) => Ok(Body::HalfPlane),
            (Some(BodyModel::Ring), Some(bore)) => Ok(Body::Ring {
                bore_radius: 0.5 * bore,
            }),
            (Some(BodyModel::Ring), None) => Err(Error::new(
                Code::MissingKey,
                "the elastic ring needs the bore of each gear",
            )
            .with_span(span)
            .with_hint("give `bore_diameter` in `pinion` and in `gear`")),
        };
        Ok(StiffnessMethod::Energy {
            bodies: [body(bores[0])?, body(bores[1])?],
            contact: ContactModel::default(),
        })
    }
}
