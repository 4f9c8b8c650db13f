//! `pair`, `rack`, `pinion` and `gear` of a file of cylindrical gears.

use std::f64::consts::PI;

use super::shared_keys::{
    self, DEFAULT_PRESSURE_ANGLE, MAX_TEETH, PRESSURE_ANGLE_RANGE, read_profile_shift,
    read_thickness,
};
use crate::base::bound::Bound;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::error_collector::ValueRange;
use crate::base::quantity::format_number;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::SourceSpan;
use crate::base::table_reader::TableReader;
use crate::base::tables::read_table;
use crate::base::toml::Table;
use crate::gear::cylindrical::basic_rack::BasicRack;
use crate::gear::cylindrical::involute::InvoluteGear;
use crate::gear::cylindrical::member::Member;
use crate::gear::cylindrical::modification::{FlankModification, Relief};
use crate::gear::hand::Hand;

/// Face width by default, in modules.
const DEFAULT_WIDTH: f64 = 10.0;

/// Helix angle of cylindrical gears: beyond it the transverse module is six times the normal one.
const HELIX_ANGLE: ValueRange =
    ValueRange::HalfOpen(0.0, 4.0 / 9.0 * PI, "at least 0° and below 80°");

/// `pair`: what both gears share.
pub(super) struct PairTable {
    module: f64,
    pressure_angle: Option<f64>,
    helix_angle: Option<f64>,
    pub(super) centre_distance: Option<f64>,
    pub(super) centre_deviation: [f64; 2],
}

/// Reads `pair`.
pub(super) fn pair(f: &mut TableReader) -> PairTable {
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
        let hint = "give the lower deviation first: [\"-20 µm\", \"20 µm\"]";
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
pub(super) fn default_rack(pressure_angle: f64, defaults: &mut Vec<String>) -> BasicRack {
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
pub(super) fn rack_defaults(rack: &Table, name: &str) -> Option<String> {
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
    pub(super) fn pressure_angle(&self) -> f64 {
        self.pressure_angle.unwrap_or(DEFAULT_PRESSURE_ANGLE)
    }

    fn helix_angle(&self) -> f64 {
        self.helix_angle.unwrap_or(0.0)
    }

    /// Notes what `pair` leaves out.
    pub(super) fn name_defaults(&self, defaults: &mut Vec<String>) {
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
    pub(super) fn pinion_hand(
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
    pub(super) fn member(
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
pub(super) struct MemberTable {
    teeth: u32,
    hand: Option<Hand>,
    hand_span: SourceSpan,
    internal: bool,
    profile_shift: Option<f64>,
    face_width: Option<f64>,
    tip_diameter: Option<f64>,
    pub(super) bore_diameter: Option<f64>,
    shaper_teeth: Option<u32>,
    pub(super) ball_diameter: Option<f64>,
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
    pub(super) fn modification(&self, gear: &InvoluteGear) -> FlankModification {
        FlankModification {
            tip_relief: self.tip_relief.map(|relief| relief.on(gear)),
            root_relief: self.root_relief.map(|relief| relief.on(gear)),
            ..self.modification
        }
    }
}

/// Reads `pinion` or `gear`.
pub(super) fn member(f: &mut TableReader) -> MemberTable {
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
        let message = "`shaper_teeth` applies to internal gears only; a rack cuts external teeth";
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
