//! Reads a gear file of a bevel or hypoid pair by machine settings: `pair`, `pinion`, `gear`, `[assembly]`, `[tolerance]`, `[housing]`, `[contact]`,
//! `[mesh]`.

use std::f64::consts::{FRAC_PI_2, PI};
use std::sync::Arc;

use super::assembly::{AxisDepartures, SHIFT, assembly, housing};
use super::bevel_blank::{
    BlankTable, DESIGN_PRESSURE_ANGLE, MAX_BEVEL_TEETH, PRESSURE_ANGLE, blank, no_blanks, no_tooth,
};
use super::correction_study::{CorrectionStudy, correction};
use super::cut_study::{self, CutStudy};
use super::cutter_table;
use super::machine_settings::{FlankCut, FlankTable, Process, SettingsTable, settings};
use super::mesh_torques::torques;
use crate::base::code::Code;
use crate::base::error::{Error, Errors};
use crate::base::error_collector::{ErrorCollector, ValueRange};
use crate::base::flags::Flags;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::{SourceFile, SourceSpan};
use crate::base::table_reader::{TableReader, Word};
use crate::base::tables::{read_heading, read_table};
use crate::base::toml;
use crate::gear::bevel::blank::Blank;
use crate::gear::bevel::cutter::Blade;
use crate::gear::bevel::flank::BevelFlank;
use crate::gear::bevel::iso23509::BlankPair;
use crate::gear::bevel::straight::{StraightFlanks, StraightProfile};
use crate::gear::bevel::tooth::SIDES;
use crate::gear::bevel::tooth_section::ToothSection;
use crate::gear::contact::contact_path::PITCHES;
use crate::gear::contact::pair::Assembly;
use crate::gear::cylindrical::member::MEMBERS;
use crate::gear::hand::Hand;

/// A pair of bevel gears as its file describes it.
#[derive(Debug, Clone)]
pub struct BevelFile {
    /// Title in the file.
    pub title: String,
    /// Pinion and gear.
    pub members: [BevelMember; 2],
    /// Hand of the pinion.
    pub hand: Hand,
    /// Blanks by ISO 23509, where the file asks for them.
    pub design: Option<BlankPair>,
    /// Places of both axes without errors.
    pub nominal: Assembly,
    /// Errors E, P, G, ΔΣ of assembly, added to the nominal places.
    pub errors: Assembly,
    /// Departures of the axes under which the loaded contact is compared.
    pub stability: AxisDepartures,
    /// Requested contact.
    pub contact: ContactStudy,
    /// Cut by discrete blades, where the file describes it.
    pub cut: Option<CutStudy>,
    /// Load on the mesh.
    pub mesh: FlankMeshStudy,
    /// Values that the file leaves to their defaults, in words.
    pub defaults: Vec<String>,
    /// Place of `pair`.
    pub span: SourceSpan,
    /// The file.
    pub source: Arc<SourceFile>,
}

/// A member of the pair.
#[derive(Debug, Clone)]
pub struct BevelMember {
    /// Number of teeth.
    pub teeth: u32,
    /// Blank.
    pub blank: Blank,
    /// Axial section of a tooth.
    pub section: ToothSection,
    /// Process.
    pub process: Process,
    /// Mean normal thickness s_mn, m, where the file states it.
    pub thickness: Option<f64>,
    /// Concave and convex flank, where the file describes their settings.
    pub flanks: [Option<FlankCut>; 2],
    /// Both flanks of straight teeth.
    pub straight: Option<StraightFlanks>,
    /// Place of its table.
    pub span: SourceSpan,
}

/// Requested contact of two flanks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactStudy {
    /// Flanks that touch.
    pub side: ContactSide,
    /// Pitches each way.
    pub pitches: f64,
    /// Positions in one pitch.
    pub positions: usize,
    /// Thickness of the coating, m.
    pub coating: f64,
    /// V–H check.
    pub vh: bool,
}

/// Load on a mesh of flanks and its discretisation.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankMeshStudy {
    /// Torques at the pinion, N·m; the mesh is computed where there are any.
    pub torques: Vec<f64>,
    /// Positions in one pitch.
    pub positions: usize,
    /// Stations along the pinion's face.
    pub stations: usize,
    /// Torques at which strips begin or cease to carry.
    pub changes: bool,
}

/// Flanks that touch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ContactSide {
    /// Concave pinion, convex gear.
    #[default]
    Drive,
    /// Convex pinion, concave gear.
    Coast,
}

impl Word for ContactSide {
    const WORDS: &'static [(&'static str, ContactSide, &'static str)] = &[
        (
            "drive",
            ContactSide::Drive,
            "Concave pinion flank on convex gear flank",
        ),
        (
            "coast",
            ContactSide::Coast,
            "Convex pinion flank on concave gear flank",
        ),
    ];
}

impl ContactSide {
    /// Indices of the flanks of pinion and gear: 0 concave, 1 convex.
    pub fn flanks(self) -> [usize; 2] {
        match self {
            ContactSide::Drive => [0, 1],
            ContactSide::Coast => [1, 0],
        }
    }

    /// The other side.
    pub fn other(self) -> ContactSide {
        match self {
            ContactSide::Drive => ContactSide::Coast,
            ContactSide::Coast => ContactSide::Drive,
        }
    }

    /// The word of the file.
    pub fn name(self) -> &'static str {
        match self {
            ContactSide::Drive => "drive",
            ContactSide::Coast => "coast",
        }
    }
}

impl BevelMember {
    /// Whether the file describes a flank.
    pub fn describes(&self, side: usize) -> bool {
        self.straight.is_some() || self.flanks[side].is_some()
    }

    /// Why its flanks do not make a tooth; none where they do.
    pub fn lacks_tooth(&self) -> Option<&'static str> {
        if self.straight.is_some() {
            let why = "its straight flanks have no `mean_normal_thickness`";
            return self.thickness.is_none().then_some(why);
        }
        match &self.flanks {
            [Some(a), Some(b)] if a.settings != b.settings && self.thickness.is_none() => {
                Some("its flanks have settings of their own and no `mean_normal_thickness`")
            }
            [Some(_), Some(_)] => None,
            _ => Some("one of its flanks is not described"),
        }
    }
}

impl BevelFile {
    /// Hand of a member.
    pub fn hand_of(&self, member: usize) -> Hand {
        match (member, self.hand) {
            (0, hand) => hand,
            (_, Hand::Right) => Hand::Left,
            (_, Hand::Left) => Hand::Right,
        }
    }

    /// A flank of a member; none where the file does not describe it.
    pub fn flank(&self, member: usize, side: usize) -> Option<BevelFlank> {
        let of = &self.members[member];
        let hand = self.hand_of(member);
        if let Some(straight) = &of.straight {
            let blade = [Blade::Outside, Blade::Inside][side];
            return Some(straight.flank(blade, hand, of.section));
        }
        let cut = of.flanks[side].as_ref()?;
        Some(BevelFlank::new(
            &cut.cutter,
            &cut.settings,
            hand,
            of.section,
        ))
    }

    /// The first flank of the requested contact that the file does not describe, as member and side.
    pub fn missing_flank(&self) -> Option<[usize; 2]> {
        let sides = self.contact.side.flanks();
        let lacks = (0..2).find(|k| !self.members[*k].describes(sides[*k]))?;
        Some([lacks, sides[lacks]])
    }

    /// Whether both gears have straight teeth, whose flanks are conjugate and touch along lines.
    pub fn is_conjugate(&self) -> bool {
        self.members.iter().all(|m| m.straight.is_some())
    }

    /// Places of both axes with their errors.
    pub fn assembly(&self) -> Assembly {
        self.nominal.changed(&self.errors, 1.0)
    }
}

/// Most positions in a pitch.
const MAX_CONTACT_POSITIONS: u32 = 2000;
/// Coating by default: 0.00025 in.
const COATING: f64 = 6.35e-6;
/// Positions by default.
const POSITIONS: u32 = 60;

/// Stations along the face by default: peak-to-peak of the loaded transmission error to 1 % on the shipped pair.
const STATIONS: u32 = 32;
/// Least stations: a contact of fewer cells is no line.
const MIN_STATIONS: u32 = 8;
/// Most stations: the load sharing grows with their cube.
pub const MAX_STATIONS: u32 = 256;
/// Flags of the load.
const LOAD_FLAGS: [&str; 4] = ["torque", "torques", "stations", "changes"];

const SHAFT_ANGLE: ValueRange = ValueRange::Open(0.0, PI, "above 0° and below 180°");

/// Reads one with the flags laid over its `[contact]`.
///
/// # Errors
/// Everything wrong in it and in the flags.
pub fn read(source: &Arc<SourceFile>, flags: &Flags) -> Result<BevelFile, Errors> {
    let document = toml::parse(source);
    let mut errors = ErrorCollector::default();
    errors.record_units(&document);
    let span = SourceSpan::new(source.clone(), 0..0);
    let mut f = TableReader::new(&document.root, span, "the gear file", &mut errors);
    let title = read_heading(&mut f);
    let span = f.span_of("pair").clone();
    let nominal = read_table(&mut f, "pair", pair);
    let first = read_table(&mut f, "pinion", member).flatten();
    f.require("pinion");
    let second = read_table(&mut f, "gear", member).flatten();
    f.require("gear");
    let position_errors = read_table(&mut f, "assembly", assembly).unwrap_or_default();
    let stability = AxisDepartures {
        tolerance: read_table(&mut f, "tolerance", assembly).unwrap_or_default(),
        housing: read_table(&mut f, "housing", housing).flatten(),
    };
    let study = read_table(&mut f, "contact", contact).unwrap_or_default();
    read_table(&mut f, "correction", correction);
    let cut = read_table(&mut f, "cut", cut_study::cut).flatten();
    let load = read_table(&mut f, "mesh", mesh).unwrap_or_default();
    f.finish();
    let ErrorCollector {
        bare_si,
        mut errors,
        ..
    } = errors;
    errors.extend(document.syntax_error.clone());
    Errors::into_result(errors, || ())?;
    let (Some(nominal), Some(first), Some(second)) = (nominal, first, second) else {
        let missing = Error::new(Code::MissingKey, "the gears are not described").with_span(&span);
        return Err(missing.into());
    };
    let (of_contact, of_mesh) = (
        flags.without_all(&LOAD_FLAGS),
        flags.without_all(&["side", "vh"]),
    );
    let study = of_contact.read_over(&document, "contact", &bare_si, study, contact)?;
    let load = of_mesh.read_over(&document, "mesh", &bare_si, load, mesh)?;
    let idle = ["stations", "changes"].into_iter();
    let mut idle = idle.filter(|flag| flags.text(flag).is_some());
    if load.torques.is_empty()
        && let Some(flag) = idle.next()
    {
        let message = format!("--{flag} does nothing without a torque");
        let error = Error::new(Code::Usage, message);
        return Err(error
            .with_hint("add --torque, or `torque` in [mesh]")
            .into());
    }
    if let (Some(a), Some(b)) = (first.straight, second.straight)
        && a != b
    {
        let message = "pinion and gear have different profiles, pressure or skew angles";
        let hint =
            "straight teeth mesh with teeth of the same process, pressure_angle and skew_angle";
        return Err(Error::new(Code::Conflict, message)
            .with_span(&second.span)
            .with_hint(hint)
            .into());
    }
    let hand = match (first.hand, second.hand) {
        // Without a skew the hand only names the flanks.
        (None, None) if first.straight.is_some_and(|s| s.skew_angle == 0.0) => Hand::Right,
        (Some(a), Some(b)) if a == b => {
            return Err(
                Error::new(Code::Conflict, "pinion and gear have the same hand")
                    .with_span(&second.span)
                    .with_hint(
                        "the hands of a bevel pair are opposite: leave `hand` of the gear out",
                    )
                    .into(),
            );
        }
        (Some(hand), _) => hand,
        (None, Some(Hand::Right)) => Hand::Left,
        (None, Some(Hand::Left)) => Hand::Right,
        (None, None) => {
            return Err(Error::new(Code::MissingKey, "no `hand` is given")
                .with_span(&first.span)
                .with_hint("`hand` of the pinion is \"right\" or \"left\"")
                .into());
        }
    };
    let (blanks, design) = blanks(&first, &second, &nominal)?;
    let is_hobbed = design.is_some_and(|d| d.method.is_face_hobbed());
    for table in [&first, &second] {
        if is_hobbed && (table.straight.is_some() || table.flanks.iter().any(Option::is_some)) {
            let message =
                "blanks by method 2 or 3 are of face-hobbed pairs, whose flanks are not computed";
            return Err(Error::new(Code::Conflict, message)
                .with_span(&table.span)
                .with_hint("leave the flanks out, or take method = 0 or 1")
                .into());
        }
    }
    let mut defaults = Vec::new();
    for (name, table) in [("pinion", &first), ("gear", &second)] {
        defaults.extend(table.defaults.iter().map(|text| format!("{name}.{text}")));
    }
    let positions = study.positions.unwrap_or(POSITIONS);
    Ok(BevelFile {
        title,
        members: [
            first.with_blank(0, blanks[0])?,
            second.with_blank(1, blanks[1])?,
        ],
        design,
        hand,
        nominal,
        errors: position_errors,
        stability,
        contact: ContactStudy {
            side: study.side.unwrap_or_default(),
            pitches: study.pitches.unwrap_or(PITCHES),
            positions: positions as usize,
            coating: study.coating.unwrap_or(COATING),
            vh: study.vh,
        },
        cut,
        mesh: FlankMeshStudy {
            torques: load.torques,
            positions: load.positions.unwrap_or(positions) as usize,
            stations: load.stations.unwrap_or(STATIONS) as usize,
            changes: load.changes,
        },
        defaults,
        span,
        source: source.clone(),
    })
}

/// Reads one with the flags laid over its `[correction]`.
///
/// # Errors
/// Everything wrong in it and in the flags.
pub fn read_for_correction(
    source: &Arc<SourceFile>,
    flags: &Flags,
) -> Result<(BevelFile, CorrectionStudy), Errors> {
    let file = read(source, &Flags::default())?;
    let document = toml::parse(source);
    let mut errors = ErrorCollector::default();
    errors.record_units(&document);
    let base = document.root.table("correction");
    let study = flags.read("[correction]", base, &errors.bare_si, correction)?;
    Ok((file, study))
}

fn pair(f: &mut TableReader) -> Assembly {
    f.choice("kind", &[("bevel", ())]);
    f.require("kind");
    let shaft_angle = f.optional_quantity("shaft_angle", QuantityKind::Angle, SHAFT_ANGLE);
    let offset = f.optional_quantity("offset", QuantityKind::Length, SHIFT);
    Assembly {
        shaft_angle: shaft_angle.unwrap_or(FRAC_PI_2),
        offset: offset.unwrap_or(0.0),
        ..Assembly::default()
    }
}

/// `[contact]` as written.
#[derive(Debug, Default)]
pub struct ContactTable {
    side: Option<ContactSide>,
    pitches: Option<f64>,
    positions: Option<u32>,
    coating: Option<f64>,
    vh: bool,
}

/// Keys of `[contact]`, each with a flag.
pub fn contact(f: &mut TableReader) -> ContactTable {
    const PITCH_RANGE: ValueRange = ValueRange::Open(0.5, 5.0, "above 0.5 and below 5");
    const COATING_RANGE: ValueRange = ValueRange::Open(1e-9, 1e-3, "above 1 nm and below 1 mm");
    ContactTable {
        side: f.word("side"),
        pitches: f.optional_number("pitches", PITCH_RANGE),
        positions: f.optional_count("positions", 4, MAX_CONTACT_POSITIONS),
        coating: f.optional_quantity("coating", QuantityKind::Length, COATING_RANGE),
        vh: f.flag("vh"),
    }
}

/// `[mesh]` as written.
#[derive(Debug, Default)]
pub struct FlankMeshTable {
    torques: Vec<f64>,
    positions: Option<u32>,
    stations: Option<u32>,
    changes: bool,
}

/// Keys of `[mesh]`, each with a flag.
pub fn mesh(f: &mut TableReader) -> FlankMeshTable {
    FlankMeshTable {
        torques: torques(f),
        positions: f.optional_count("positions", 4, MAX_CONTACT_POSITIONS),
        stations: f.optional_count("stations", MIN_STATIONS, MAX_STATIONS),
        changes: f.flag("changes"),
    }
}

/// `pinion` or `gear` as written.
struct MemberTable {
    teeth: u32,
    hand: Option<Hand>,
    blank: Option<BlankTable>,
    process: Process,
    thickness: Option<f64>,
    flanks: [Option<FlankTable>; 2],
    straight: Option<StraightTable>,
    defaults: Vec<String>,
    span: SourceSpan,
}

/// Profile and angles of straight teeth.
#[derive(Debug, Clone, Copy, PartialEq)]
struct StraightTable {
    profile: StraightProfile,
    pressure_angle: f64,
    skew_angle: f64,
}

impl MemberTable {
    /// The member on its blank.
    fn with_blank(self, member: usize, blank: Blank) -> Result<BevelMember, Error> {
        let section = (blank.section()).map_err(|fault| no_tooth(&fault, &self.span, member))?;
        let straight = self.straight.map(|straight| StraightFlanks {
            profile: straight.profile,
            pressure_angle: straight.pressure_angle,
            skew_angle: straight.skew_angle,
            pitch_angle: blank.pitch_angle,
            mean_cone_distance: blank.mean_cone_distance,
            pitch_apex: blank.pitch_apex,
        });
        let flanks = self.flanks.map(|flank| Some(flank?.on(&blank)));
        for (flank, side) in flanks.iter().zip(SIDES) {
            if let Some(cut) = flank {
                let place = (side, MEMBERS[member]);
                cutter_table::check(&cut.cutter, section.depth(), place, &self.span)?;
            }
        }
        Ok(BevelMember {
            straight,
            teeth: self.teeth,
            blank,
            section,
            process: self.process,
            thickness: self.thickness,
            flanks,
            span: self.span,
        })
    }
}

/// Both blanks, with the design that gives them.
fn blanks(
    first: &MemberTable,
    second: &MemberTable,
    nominal: &Assembly,
) -> Result<([Blank; 2], Option<BlankPair>), Error> {
    let missing = |table: &MemberTable, name: &str| {
        Error::new(Code::MissingKey, format!("`{name}` has no `blank`"))
            .with_span(&table.span)
            .with_hint("give its cones, or the blank of the gear by standard = \"ISO 23509\"")
    };
    match (&first.blank, &second.blank) {
        (Some(BlankTable::Cones(a)), Some(BlankTable::Cones(b))) => Ok(([*a, *b], None)),
        (Some(BlankTable::Standard(_)), _) | (Some(_), Some(BlankTable::Standard(_))) => {
            let message =
                "a blank by ISO 23509 is given in `gear`, and that of the pinion follows from it";
            Err(Error::new(Code::Conflict, message)
                .with_span(&first.span)
                .with_hint("leave `blank` of the pinion out"))
        }
        (None, Some(BlankTable::Standard(table))) => {
            let design = table
                .design([first.teeth, second.teeth], nominal)
                .map_err(|e| e.with_span(&second.span))?;
            let found = (design.blanks())
                .map_err(|fault| no_blanks(&design, &fault).with_span(&second.span))?;
            Ok((found.blanks, Some(found)))
        }
        (None, _) => Err(missing(first, "pinion")),
        (_, None) => Err(missing(second, "gear")),
    }
}

fn member(f: &mut TableReader) -> Option<MemberTable> {
    let teeth = f.optional_count("teeth", 2, MAX_BEVEL_TEETH);
    f.require("teeth");
    let hand = f.choice("hand", &[("right", Hand::Right), ("left", Hand::Left)]);
    let blank = read_table(f, "blank", blank).flatten();
    let process = process(f);
    let thickness = f.optional_quantity(
        "mean_normal_thickness",
        QuantityKind::Length,
        ValueRange::Positive,
    );
    let mut defaults = Vec::new();
    let errors = f.errors.errors.len();
    let straight = straight(f, process, &mut defaults);
    let (mut own, mut sides) = (SettingsTable::default(), [None, None]);
    if straight.is_none() {
        own = settings(f);
        for (k, side) in SIDES.into_iter().enumerate() {
            sides[k] = read_table(f, side, settings);
        }
    }
    let root_angle = match &blank {
        Some(BlankTable::Cones(blank)) => Some(blank.root_angle),
        _ => None,
    };
    if own != SettingsTable::default() && sides.iter().all(Option::is_none) {
        f.report_missing("concave", ", the flank that its settings cut");
    }
    // A key whose value is wrong is not missing as well.
    let is_sound = f.errors.errors.len() == errors;
    let flanks = [0, 1].map(|k| {
        let side = sides[k].filter(|_| is_sound)?;
        side.over(own).cut(f, SIDES[k], process?, root_angle)
    });
    if let (Some(_), [Some(FlankTable::Settings(a)), Some(FlankTable::Settings(b))]) =
        (thickness, flanks)
        && a.settings == b.settings
    {
        let message = "both flanks are cut at one setting, which makes their thickness";
        let hint = "leave `mean_normal_thickness` out, or give the flanks settings of their own";
        f.report_key(Code::Conflict, "mean_normal_thickness", message, hint);
    }
    let has_flank = sides.iter().any(Option::is_some);
    let is_rough = |t: &SettingsTable| t.has_spiral_angle();
    if is_rough(&own) || sides.iter().flatten().any(is_rough) {
        defaults.push("settings: rough, from spiral_angle and blank".to_string());
    } else if has_flank && root_angle.is_some() && own.machine_root_angle_is_default(&sides) {
        defaults.push("machine_root_angle: the root angle of the blank".to_string());
    }
    Some(MemberTable {
        teeth: teeth?,
        hand,
        blank,
        process: process?,
        thickness,
        flanks,
        straight,
        defaults,
        span: f.span.clone(),
    })
}

/// Keys of straight teeth; none for another process.
fn straight(
    f: &mut TableReader,
    process: Option<Process>,
    defaults: &mut Vec<String>,
) -> Option<StraightTable> {
    const SKEW: ValueRange = ValueRange::HalfOpen(0.0, 0.8, "at least 0° and below 46°");
    let Some(Process::Straight(profile)) = process else {
        return None;
    };
    let angle = f.optional_quantity("pressure_angle", QuantityKind::Angle, PRESSURE_ANGLE);
    let pressure_angle = angle.unwrap_or_else(|| {
        defaults.push("pressure_angle: 20 deg".to_string());
        DESIGN_PRESSURE_ANGLE
    });
    let skew = f.optional_quantity("skew_angle", QuantityKind::Angle, SKEW);
    if profile == StraightProfile::SphericalInvolute && skew.is_some_and(|s| s != 0.0) {
        let message = "spherical involutes are straight: their teeth run to the apex";
        let hint = "leave skew_angle out, or take process = \"octoid\"";
        f.report_key(Code::Conflict, "skew_angle", message, hint);
    }
    Some(StraightTable {
        profile,
        pressure_angle,
        skew_angle: skew.unwrap_or(0.0),
    })
}

fn process(f: &mut TableReader) -> Option<Process> {
    let known = [
        ("generated", Some(Process::Generated)),
        ("formate", Some(Process::Formate)),
        ("octoid", Some(Process::Straight(StraightProfile::Octoid))),
        (
            "spherical-involute",
            Some(Process::Straight(StraightProfile::SphericalInvolute)),
        ),
        ("face-hobbed", None),
    ];
    let process = match f.has("process") {
        true => f.choice("process", &known)?,
        false => {
            f.item(
                "process",
                "\"generated\", \"formate\", \"octoid\", \"spherical-involute\"",
            );
            Some(Process::Generated)
        }
    };
    if process.is_none() {
        let message = "face hobbing is not taken: its indexing is continuous";
        let hint = "flanks are face-milled, tooth by tooth: \"generated\" or \"formate\"";
        f.report_key(Code::OutOfRange, "process", message, hint);
    }
    process
}
