//! Reads `[[load]]`, `[[motor]]`, `[[brake]]` and `[[clutch]]`.

use super::face_mill;
use super::factors::{self, points, read_interval};
use super::friction;
use super::laws::{
    FrictionLaw, LoadHistory, MotionProfile, MotorModel, Sinusoid, TorqueSpeedCurve,
};
use super::model::{Brake, BranchEnd, Load, Motor, Name};
use super::shared_keys;
use super::waveforms;
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;

/// Which way a load changes over time.
#[derive(Clone, Copy)]
enum LoadTag {
    Constant,
    Step,
    Ramp,
    Harmonic,
    Orders,
    Table,
    FaceMill,
    Product,
}

const LOADS: &[(&str, LoadTag)] = &[
    ("constant", LoadTag::Constant),
    ("step", LoadTag::Step),
    ("ramp", LoadTag::Ramp),
    ("harmonic", LoadTag::Harmonic),
    ("orders", LoadTag::Orders),
    ("table", LoadTag::Table),
    ("face-mill", LoadTag::FaceMill),
    ("product", LoadTag::Product),
];

/// A torque on a node over time; a force on one that slides.
pub fn load(f: &mut TableReader) -> Load {
    let at = shared_keys::read_node(f, "at");
    f.exclusive("torque", "force");
    let pushes = f.has("force");
    let word = f.choice("kind", LOADS).unwrap_or(LoadTag::Constant);
    let history = match word {
        LoadTag::Constant => LoadHistory::Constant(torque(f)),
        LoadTag::Step => LoadHistory::Step {
            torque: torque(f),
            time: f.quantity("time", QuantityKind::Time, ValueRange::Any),
        },
        LoadTag::Ramp => LoadHistory::Ramp {
            from: f
                .optional_quantity("from", load_kind(f), ValueRange::Any)
                .unwrap_or(0.0),
            to: torque(f),
            between: read_interval(f, "between"),
        },
        LoadTag::Harmonic => LoadHistory::Harmonic {
            mean: read_mean(f),
            amplitude: torque(f),
            omega: f.quantity("frequency", QuantityKind::Frequency, ValueRange::Positive),
            phase: f
                .optional_quantity("phase", QuantityKind::Angle, ValueRange::Any)
                .unwrap_or(0.0),
        },
        LoadTag::Orders => orders(f),
        LoadTag::Table => LoadHistory::Table(points(
            f,
            ("times", QuantityKind::Time),
            ("torques", QuantityKind::Torque),
        )),
        LoadTag::FaceMill => LoadHistory::FaceMill(face_mill::read(f)),
        LoadTag::Product => LoadHistory::Product {
            torque: torque(f),
            factors: factors::factors(f),
        },
    };
    Load {
        at,
        is_force: pushes,
        history,
    }
}

/// Kind of quantity of the load.
fn load_kind(f: &TableReader) -> QuantityKind {
    match f.has("force") {
        true => QuantityKind::Force,
        false => QuantityKind::Torque,
    }
}

fn torque(f: &mut TableReader) -> f64 {
    match load_kind(f) {
        QuantityKind::Force => f.quantity("force", QuantityKind::Force, ValueRange::Any),
        kind => f.quantity("torque", kind, ValueRange::Any),
    }
}

fn read_mean(f: &mut TableReader) -> f64 {
    f.optional_quantity("mean", load_kind(f), ValueRange::Any)
        .unwrap_or(0.0)
}

fn orders(f: &mut TableReader) -> LoadHistory {
    let mean = read_mean(f);
    let numbers = waveforms::read_number_list(f, "orders", ValueRange::Positive);
    // Where the orders themselves are wrong, nothing is said of the lists next to them.
    let count = numbers.as_ref().map(Vec::len);
    let numbers = numbers.unwrap_or_default();
    let torques = f.optional_quantities("torques", QuantityKind::Torque, ValueRange::Any, count);
    f.require("torques");
    let phases = f.optional_quantities("phases", QuantityKind::Angle, ValueRange::Any, count);
    let phase = |at: usize| {
        phases
            .as_ref()
            .and_then(|p| p.get(at))
            .copied()
            .unwrap_or(0.0)
    };
    let torques = torques.unwrap_or_default();
    let orders = numbers
        .iter()
        .zip(&torques)
        .enumerate()
        .map(|(at, (&n, &a))| (n, a, phase(at)));
    LoadHistory::Orders {
        mean,
        orders: orders.collect(),
    }
}

/// Kind of motor model.
#[derive(Clone, Copy)]
enum MotorTag {
    Induction,
    Direct,
    Table,
    Speed,
    Angle,
}

/// A motor.
pub fn motor(f: &mut TableReader) -> Motor {
    let name = shared_keys::name(f);
    let at = shared_keys::read_node(f, "at");
    let words = [
        ("induction", MotorTag::Induction),
        ("dc", MotorTag::Direct),
        ("table", MotorTag::Table),
        ("speed", MotorTag::Speed),
        ("angle", MotorTag::Angle),
    ];
    let word = f.choice("kind", &words);
    f.require("kind");
    let drive = match word {
        Some(MotorTag::Speed) => {
            let points = match f.has("times") {
                true => points(
                    f,
                    ("times", QuantityKind::Time),
                    ("speeds", QuantityKind::Speed),
                ),
                false => vec![(
                    0.0,
                    f.quantity("speed", QuantityKind::Speed, ValueRange::Any),
                )],
            };
            let swing = read_sinusoid(f, QuantityKind::Speed);
            MotorModel::Speed(MotionProfile {
                points,
                oscillation: swing,
            })
        }
        Some(MotorTag::Angle) => MotorModel::Angle(read_angle_profile(f)),
        Some(MotorTag::Induction) => {
            let curve = TorqueSpeedCurve::Induction {
                pull_out: f.quantity("pull_out", QuantityKind::Torque, ValueRange::Positive),
                slip: {
                    let slip = f.optional_number("pull_out_slip", ValueRange::Positive);
                    f.require("pull_out_slip");
                    slip.unwrap_or(f64::NAN)
                },
                synchronous: read_nonzero_speed(f, "synchronous"),
            };
            MotorModel::Curve { curve, lag: lag(f) }
        }
        Some(MotorTag::Table) => {
            let curve = TorqueSpeedCurve::Table(points(
                f,
                ("speeds", QuantityKind::Speed),
                ("torques", QuantityKind::Torque),
            ));
            MotorModel::Curve { curve, lag: lag(f) }
        }
        Some(MotorTag::Direct) | None => {
            let curve = TorqueSpeedCurve::Linear {
                stall: f.quantity("stall", QuantityKind::Torque, ValueRange::Any),
                idle: read_nonzero_speed(f, "idle"),
            };
            MotorModel::Curve { curve, lag: lag(f) }
        }
    };
    Motor { name, at, drive }
}

/// Reads the oscillation about a prescribed motion.
fn read_sinusoid(f: &mut TableReader, kind: QuantityKind) -> Option<Sinusoid> {
    let amplitude = f.optional_quantity("amplitude", kind, ValueRange::Any);
    let omega = f.optional_quantity("frequency", QuantityKind::Frequency, ValueRange::Positive);
    let phase = f.optional_quantity("phase", QuantityKind::Angle, ValueRange::Any);
    match f.has("amplitude") {
        true => f.require("frequency"),
        false if f.has("frequency") || f.has("phase") => {
            f.report_missing("amplitude", ", and `frequency` or `phase` is given");
        }
        false => {}
    }
    Some(Sinusoid {
        amplitude: amplitude?,
        omega: omega?,
        phase: phase.unwrap_or(0.0),
    })
}

/// An angle over time: points, an oscillation, or both.
fn read_angle_profile(f: &mut TableReader) -> MotionProfile {
    let swing = read_sinusoid(f, QuantityKind::Angle);
    if !f.has("times") && !f.has("angles") && !f.has("amplitude") {
        f.report_missing("amplitude", ", nor `times` and `angles`");
    }
    let points = match f.has("times") || f.has("angles") {
        true => points(
            f,
            ("times", QuantityKind::Time),
            ("angles", QuantityKind::Angle),
        ),
        false => vec![(0.0, 0.0)],
    };
    if points
        .windows(2)
        .any(|p| p[1].0 == p[0].0 && p[1].1 != p[0].1)
    {
        f.report_key(
            Code::OutOfRange,
            "angles",
            "the angle jumps",
            "replace the jump by a short ramp",
        );
    }
    MotionProfile {
        points,
        oscillation: swing,
    }
}

fn lag(f: &mut TableReader) -> f64 {
    f.optional_quantity("lag", QuantityKind::Time, ValueRange::NotNegative)
        .unwrap_or(0.0)
}

/// A speed of either sense that is not zero.
fn read_nonzero_speed(f: &mut TableReader, key: &str) -> f64 {
    let speed = f.quantity(key, QuantityKind::Speed, ValueRange::Any);
    if speed == 0.0 {
        f.report_key(
            Code::OutOfRange,
            key,
            format!("`{key}` is zero"),
            "give the speed with its sign",
        );
    }
    speed
}

/// Dry friction between two nodes whose capacity changes over time.
pub fn clutch(f: &mut TableReader) -> Brake {
    let name = shared_keys::name(f);
    let between = shared_keys::read_ends_or_node(f);
    f.exclusive("torque", "torques");
    if f.has("factors") {
        return multiplied(f, name, between);
    }
    let points = match f.has("times") || f.has("torques") {
        true => points(
            f,
            ("times", QuantityKind::Time),
            ("torques", QuantityKind::Torque),
        ),
        false => vec![(
            0.0,
            f.quantity("torque", QuantityKind::Torque, ValueRange::NotNegative),
        )],
    };
    if points.iter().any(|p| p.1 < 0.0) {
        f.report_key(
            Code::OutOfRange,
            "torques",
            "a capacity below zero",
            "friction opposes the slip: give positive values",
        );
    }
    if points.windows(2).any(|p| p[1].0 == p[0].0) {
        f.report_key(
            Code::OutOfRange,
            "times",
            "the capacity jumps",
            "replace the jump by a short ramp",
        );
    }
    let law = friction::read_unit_capacity_law(f);
    let largest = points.iter().fold(0.0f64, |m, p| m.max(p.1));
    let capacity = (points.len() > 1 && largest > 0.0)
        .then(|| LoadHistory::Table(points.iter().map(|p| (p.0, p.1 / largest)).collect()));
    pressed(name, between, (law, largest), capacity)
}

/// Dry friction up to a largest capacity, of which there are shares over time.
fn pressed(
    name: Name,
    between: [BranchEnd; 2],
    (law, largest): (FrictionLaw, f64),
    capacity: Option<LoadHistory>,
) -> Brake {
    Brake {
        name,
        between,
        friction: FrictionLaw {
            sliding: largest,
            breakaway: law.breakaway * largest,
            ..law
        },
        capacity_history: capacity,
    }
}

/// A clutch whose capacity is a torque times factors, none of which jumps or falls below zero.
fn multiplied(f: &mut TableReader, name: Name, between: [BranchEnd; 2]) -> Brake {
    f.exclusive("factors", "torques");
    let torque = f.quantity("torque", QuantityKind::Torque, ValueRange::NotNegative);
    let factors = factors::factors(f);
    let jumps = |factor: &LoadHistory| match factor {
        LoadHistory::Step { .. } => true,
        LoadHistory::Table(points) => points.windows(2).any(|p| p[1].0 == p[0].0),
        _ => false,
    };
    if factors.iter().any(jumps) {
        let hint = "replace the jump by a short ramp";
        f.report_key(Code::OutOfRange, "factors", "the capacity jumps", hint);
    }
    if factors
        .iter()
        .any(|factor| factor.range().is_none_or(|r| r[0] < 0.0))
    {
        let message = "a factor of a capacity falls below zero";
        let hint = "friction opposes the slip: give a harmonic a `mean` of at least its `value`";
        f.report_key(Code::OutOfRange, "factors", message, hint);
    }
    let law = friction::read_unit_capacity_law(f);
    let whole = |torque: f64| LoadHistory::Product {
        torque,
        factors: factors.clone(),
    };
    let largest = whole(torque).range().map_or(0.0, |r| r[1]);
    let capacity = (largest > 0.0).then(|| whole(torque / largest));
    pressed(name, between, (law, largest), capacity)
}

/// A brake or a slipping clutch.
pub fn brake(f: &mut TableReader) -> Brake {
    let name = shared_keys::name(f);
    let between = shared_keys::read_ends_or_node(f);
    let sliding = f.quantity("torque", QuantityKind::Torque, ValueRange::NotNegative);
    let breakaway = f.optional_quantity("breakaway", QuantityKind::Torque, ValueRange::NotNegative);
    if breakaway.is_some_and(|b| b < sliding) {
        f.report_key(
            Code::OutOfRange,
            "breakaway",
            "the holding torque of the brake is below its sliding torque",
            "give at least the sliding torque, or omit it",
        );
    }
    Brake {
        name,
        between,
        friction: friction::read_stribeck_law(f, sliding, breakaway.unwrap_or(sliding)),
        capacity_history: None,
    }
}
