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
use crate::gear::bevel::flank_theory::ContactSide;
use crate::gear::bevel::iso23509::BlankPair;
use crate::gear::bevel::straight::{StraightFlanks, StraightProfile};
use crate::gear::bevel::tooth::SIDES;
use crate::gear::bevel::tooth_section::ToothSection;
use crate::gear::contact::contact_path::PITCHES;
use crate::gear::contact::pair::Assembly;
use crate::gear::cylindrical::member::MEMBERS;
use crate::gear::hand::Hand;

/// Bevel or hypoid gear pair described by a gear file.
#[derive(Debug, Clone)]
pub struct BevelFile {
    /// Title in the file.
    pub title: String,
    /// Pinion and gear.
    pub members: [BevelMember; 2],
    /// Hand of the pinion.
    pub hand: Hand,
    /// Blanks by ISO 23509; absent where the file states the cones.
    pub design: Option<BlankPair>,
    /// Nominal positions of both axes, without assembly errors.
    pub nominal: Assembly,
    /// Assembly errors E, P, G, m, and ΔΣ, rad, added to the nominal positions.
    pub errors: Assembly,
    /// Axis deviations at which the loaded contact is compared.
    pub stability: AxisDepartures,
    /// Requested contact analysis.
    pub contact: ContactStudy,
    /// Cut by discrete blades; absent where the file has no `[cut]`.
    pub cut: Option<CutStudy>,
    /// Load on the mesh and its discretisation.
    pub mesh: FlankMeshStudy,
    /// Values that the file leaves to their defaults, in words.
    pub defaults: Vec<String>,
    /// Position of `pair` in the file.
    pub span: SourceSpan,
    /// Source file.
    pub source: Arc<SourceFile>,
}

/// Pinion or gear of a bevel pair.
#[derive(Debug, Clone)]
pub struct BevelMember {
    /// Number of teeth.
    pub teeth: u32,
    /// Blank.
    pub blank: Blank,
    /// Axial section of a tooth.
    pub section: ToothSection,
    /// Machining process of the flanks.
    pub process: Process,
    /// Mean normal thickness s_mn, m; absent where the file omits it.
    pub thickness: Option<f64>,
    /// Concave and convex flank; absent where the file has no settings for it.
    pub flanks: [Option<FlankCut>; 2],
    /// Flanks of straight teeth; absent for other teeth.
    pub straight: Option<StraightFlanks>,
    /// Position of the member's table in the file.
    pub span: SourceSpan,
}

/// Requested contact analysis of two flanks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactStudy {
    /// Flank pair in contact.
    pub side: ContactSide,
    /// Range of positions to each side, in pitches.
    pub pitches: f64,
    /// Number of positions per pitch.
    pub positions: usize,
    /// Thickness of the marking coating, m.
    pub coating: f64,
    /// True if the V–H check is requested.
    pub vh: bool,
}

/// Load on a mesh of flanks and its discretisation.
#[derive(Debug, Clone, PartialEq)]
pub struct FlankMeshStudy {
    /// Pinion torques, N·m; without any the loaded mesh is not computed.
    pub torques: Vec<f64>,
    /// Number of positions per pitch.
    pub positions: usize,
    /// Number of stations along the pinion's face.
    pub stations: usize,
    /// True if the torques at which strips begin or cease to carry are requested.
    pub changes: bool,
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

impl BevelMember {
    /// True if the file describes a flank.
    pub fn describes(&self, side: usize) -> bool {
        self.straight.is_some() || self.flanks[side].is_some()
    }

    /// Reason that the flanks do not form a tooth; none if they do.
    pub fn missing_tooth_reason(&self) -> Option<&'static str> {
        if self.straight.is_some() {
            let reason = "its straight flanks have no `mean_normal_thickness`";
            return self.thickness.is_none().then_some(reason);
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
        let gear = &self.members[member];
        let hand = self.hand_of(member);
        if let Some(straight) = &gear.straight {
            let blade = [Blade::Outside, Blade::Inside][side];
            return Some(straight.flank(blade, hand, gear.section));
        }
        let cut = gear.flanks[side].as_ref()?;
        Some(BevelFlank::new(
            &cut.cutter,
            &cut.settings,
            hand,
            gear.section,
        ))
    }

    /// The first flank of the requested contact that the file does not describe, as member and side.
    pub fn missing_flank(&self) -> Option<[usize; 2]> {
        let sides = self.contact.side.flanks();
        let member = (0..2).find(|k| !self.members[*k].describes(sides[*k]))?;
        Some([member, sides[member]])
    }

    /// True if both gears have straight teeth, whose flanks are conjugate and touch along lines.
    pub fn is_conjugate(&self) -> bool {
        self.members.iter().all(|m| m.straight.is_some())
    }

    /// Positions of both axes with the assembly errors.
    pub fn assembly(&self) -> Assembly {
        self.nominal.changed(&self.errors, 1.0)
    }
}

/// Maximum number of positions per pitch.
const MAX_CONTACT_POSITIONS: u32 = 2000;
/// Default thickness of the marking coating, m: 0.00025 in.
const COATING: f64 = 6.35e-6;
/// Default number of positions per pitch.
const POSITIONS: u32 = 60;

/// Default number of stations along the face: gives the peak-to-peak loaded transmission error to 1 % on the shipped pair.
const STATIONS: u32 = 32;
/// Minimum number of stations: fewer cells do not resolve the contact line.
const MIN_STATIONS: u32 = 8;
/// Maximum number of stations: the effort of load sharing grows with their cube.
pub const MAX_STATIONS: u32 = 256;
/// Flags of `[mesh]` that `[contact]` does not have.
const LOAD_FLAGS: [&str; 4] = ["torque", "torques", "stations", "changes"];

const SHAFT_ANGLE: ValueRange = ValueRange::Open(0.0, PI, "above 0° and below 180°");

/// Reads a bevel gear file; flags override its `[contact]` and `[mesh]`.
///
/// # Errors
/// All errors of the file and of the flags.
pub fn read(source: &Arc<SourceFile>, flags: &Flags) -> Result<BevelFile, Errors> {
    let document = toml::parse(source);
    let mut errors = ErrorCollector::default();
    errors.record_units(&document);
    let span = SourceSpan::new(source.clone(), 0..0);
    let mut f = TableReader::new(&document.root, span, "the gear file", &mut errors);
    let title = read_heading(&mut f);
    let span = f.span_of("pair").clone();
    let nominal = read_table(&mut f, "pair", pair);
    let pinion = read_table(&mut f, "pinion", member).flatten();
    f.require("pinion");
    let gear = read_table(&mut f, "gear", member).flatten();
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
    let (Some(nominal), Some(pinion), Some(gear)) = (nominal, pinion, gear) else {
        let missing = Error::new(Code::MissingKey, "the gears are not described").with_span(&span);
        return Err(missing.into());
    };
    let (contact_flags, mesh_flags) = (
        flags.without_all(&LOAD_FLAGS),
        flags.without_all(&["side", "vh"]),
    );
    let study = contact_flags.read_over(&document, "contact", &bare_si, study, contact)?;
    let load = mesh_flags.read_over(&document, "mesh", &bare_si, load, mesh)?;
    let load_flags = ["stations", "changes"].into_iter();
    let mut load_flags = load_flags.filter(|flag| flags.text(flag).is_some());
    if load.torques.is_empty()
        && let Some(flag) = load_flags.next()
    {
        let message = format!("--{flag} has no effect without a torque");
        let error = Error::new(Code::Usage, message);
        return Err(error
            .with_hint("add --torque, or `torque` in [mesh]")
            .into());
    }
    if let (Some(a), Some(b)) = (pinion.straight, gear.straight)
        && a != b
    {
        let message = "pinion and gear have different profiles, pressure or skew angles";
        let hint =
            "straight teeth mesh with teeth of the same process, pressure_angle and skew_angle";
        return Err(Error::new(Code::Conflict, message)
            .with_span(&gear.span)
            .with_hint(hint)
            .into());
    }
    let hand = match (pinion.hand, gear.hand) {
        // At zero skew angle the hand only names the flanks.
        (None, None) if pinion.straight.is_some_and(|s| s.skew_angle == 0.0) => Hand::Right,
        (Some(a), Some(b)) if a == b => {
            return Err(
                Error::new(Code::Conflict, "pinion and gear have the same hand")
                    .with_span(&gear.span)
                    .with_hint("the hands of a bevel pair are opposite: omit `hand` of the gear")
                    .into(),
            );
        }
        (Some(hand), _) => hand,
        (None, Some(Hand::Right)) => Hand::Left,
        (None, Some(Hand::Left)) => Hand::Right,
        (None, None) => {
            return Err(Error::new(Code::MissingKey, "no `hand` is given")
                .with_span(&pinion.span)
                .with_hint("`hand` of the pinion is \"right\" or \"left\"")
                .into());
        }
    };
    let (blanks, design) = blanks(&pinion, &gear, &nominal)?;
    let is_hobbed = design.is_some_and(|d| d.method.is_face_hobbed());
    for table in [&pinion, &gear] {
        if is_hobbed && (table.straight.is_some() || table.flanks.iter().any(Option::is_some)) {
            let message =
                "blanks by method 2 or 3 are for face-hobbed pairs, whose flanks are not computed";
            return Err(Error::new(Code::Conflict, message)
                .with_span(&table.span)
                .with_hint("omit the flanks, or use method = 0 or 1")
                .into());
        }
    }
    let mut defaults = Vec::new();
    for (name, table) in [("pinion", &pinion), ("gear", &gear)] {
        defaults.extend(table.defaults.iter().map(|text| format!("{name}.{text}")));
    }
    let positions = study.positions.unwrap_or(POSITIONS);
    Ok(BevelFile {
        title,
        members: [
            pinion.with_blank(0, blanks[0])?,
            gear.with_blank(1, blanks[1])?,
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

/// Reads a bevel gear file and its `[correction]`, which flags override.
///
/// # Errors
/// All errors of the file and of the flags.
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

/// Values stated in `[contact]`, without defaults.
#[derive(Debug, Default)]
pub struct ContactTable {
    side: Option<ContactSide>,
    pitches: Option<f64>,
    positions: Option<u32>,
    coating: Option<f64>,
    vh: bool,
}

/// Reads `[contact]`; each key has a flag.
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

/// Values stated in `[mesh]`, without defaults.
#[derive(Debug, Default)]
pub struct FlankMeshTable {
    torques: Vec<f64>,
    positions: Option<u32>,
    stations: Option<u32>,
    changes: bool,
}

/// Reads `[mesh]`; each key has a flag.
pub fn mesh(f: &mut TableReader) -> FlankMeshTable {
    FlankMeshTable {
        torques: torques(f),
        positions: f.optional_count("positions", 4, MAX_CONTACT_POSITIONS),
        stations: f.optional_count("stations", MIN_STATIONS, MAX_STATIONS),
        changes: f.flag("changes"),
    }
}

/// Values stated in `pinion` or `gear`, without defaults.
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

/// Profile and angles, rad, of straight teeth.
#[derive(Debug, Clone, Copy, PartialEq)]
struct StraightTable {
    profile: StraightProfile,
    pressure_angle: f64,
    skew_angle: f64,
}

impl MemberTable {
    /// Combines the stated values with the blank.
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

/// Blanks of pinion and gear, and their ISO 23509 design if one is stated.
fn blanks(
    pinion: &MemberTable,
    gear: &MemberTable,
    nominal: &Assembly,
) -> Result<([Blank; 2], Option<BlankPair>), Error> {
    let missing = |table: &MemberTable, name: &str| {
        Error::new(Code::MissingKey, format!("`{name}` has no `blank`"))
            .with_span(&table.span)
            .with_hint("give its cones, or the blank of the gear by standard = \"ISO 23509\"")
    };
    match (&pinion.blank, &gear.blank) {
        (Some(BlankTable::Cones(a)), Some(BlankTable::Cones(b))) => Ok(([*a, *b], None)),
        (Some(BlankTable::Standard(_)), _) | (Some(_), Some(BlankTable::Standard(_))) => {
            let message =
                "a blank by ISO 23509 is given in `gear` and determines that of the pinion";
            Err(Error::new(Code::Conflict, message)
                .with_span(&pinion.span)
                .with_hint("omit `blank` of the pinion"))
        }
        (None, Some(BlankTable::Standard(table))) => {
            let design = table
                .design([pinion.teeth, gear.teeth], nominal)
                .map_err(|e| e.with_span(&gear.span))?;
            let blank_pair = (design.blanks())
                .map_err(|fault| no_blanks(&design, &fault).with_span(&gear.span))?;
            Ok((blank_pair.blanks, Some(blank_pair)))
        }
        (None, _) => Err(missing(pinion, "pinion")),
        (_, None) => Err(missing(gear, "gear")),
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
    let error_count = f.errors.errors.len();
    let straight = straight(f, process, &mut defaults);
    let (mut common, mut sides) = (SettingsTable::default(), [None, None]);
    if straight.is_none() {
        common = settings(f);
        for (k, side) in SIDES.into_iter().enumerate() {
            sides[k] = read_table(f, side, settings);
        }
    }
    let root_angle = match &blank {
        Some(BlankTable::Cones(blank)) => Some(blank.root_angle),
        _ => None,
    };
    if common != SettingsTable::default() && sides.iter().all(Option::is_none) {
        f.report_missing("concave", ", the flank that its settings cut");
    }
    // A key with an invalid value is not reported as missing too.
    let is_valid = f.errors.errors.len() == error_count;
    let flanks = [0, 1].map(|k| {
        let side = sides[k].filter(|_| is_valid)?;
        side.over(common).cut(f, SIDES[k], process?, root_angle)
    });
    if let (Some(_), [Some(FlankTable::Settings(a)), Some(FlankTable::Settings(b))]) =
        (thickness, flanks)
        && a.settings == b.settings
    {
        let message = "both flanks are cut at one setting, which determines their thickness";
        let hint = "omit `mean_normal_thickness`, or give separate settings of the flanks";
        f.report_key(Code::Conflict, "mean_normal_thickness", message, hint);
    }
    let has_flank = sides.iter().any(Option::is_some);
    let is_rough = |t: &SettingsTable| t.has_spiral_angle();
    if is_rough(&common) || sides.iter().flatten().any(is_rough) {
        defaults.push("settings: rough, from spiral_angle and blank".to_string());
    } else if has_flank && root_angle.is_some() && common.machine_root_angle_is_default(&sides) {
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

/// Reads the keys of straight teeth; none for another process.
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
        let hint = "omit skew_angle, or use process = \"octoid\"";
        f.report_key(Code::Conflict, "skew_angle", message, hint);
    }
    Some(StraightTable {
        profile,
        pressure_angle,
        skew_angle: skew.unwrap_or(0.0),
    })
}

fn process(f: &mut TableReader) -> Option<Process> {
    let processes = [
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
        true => f.choice("process", &processes)?,
        false => {
            f.item(
                "process",
                "\"generated\", \"formate\", \"octoid\", \"spherical-involute\"",
            );
            Some(Process::Generated)
        }
    };
    if process.is_none() {
        let message = "face hobbing is not supported: its indexing is continuous";
        let hint = "use a face-milled flank: \"generated\" or \"formate\"";
        f.report_key(Code::OutOfRange, "process", message, hint);
    }
    process
}
