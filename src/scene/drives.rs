//! `[[load]]`, `[[motor]]` and `[[brake]]`: what pushes and what rubs.

use std::f64::consts::TAU;

use super::common;
use super::factors::{self, between, points};
use super::friction;
use super::laws::{Course, Curve, Drive, FaceMill, Friction, History, Swing};
use super::model::{Brake, End, Load, Motor, Name};
use super::waves;
use crate::base::code::Code;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;

/// Which way a load changes over time.
#[derive(Clone, Copy)]
enum LoadWord {
    Constant,
    Step,
    Ramp,
    Harmonic,
    Orders,
    Table,
    FaceMill,
    Product,
}

const LOADS: &[(&str, LoadWord)] = &[
    ("constant", LoadWord::Constant),
    ("step", LoadWord::Step),
    ("ramp", LoadWord::Ramp),
    ("harmonic", LoadWord::Harmonic),
    ("orders", LoadWord::Orders),
    ("table", LoadWord::Table),
    ("face-mill", LoadWord::FaceMill),
    ("product", LoadWord::Product),
];

/// A torque on a node over time; a force on one that slides.
pub fn load(f: &mut Fields) -> Load {
    let at = common::one_node(f, "at");
    f.exclusive("torque", "force");
    let pushes = f.has("force");
    let word = f.choice("kind", LOADS).unwrap_or(LoadWord::Constant);
    let history = match word {
        LoadWord::Constant => History::Constant(torque(f)),
        LoadWord::Step => History::Step {
            torque: torque(f),
            time: f.quantity("time", Kind::Time, Range::Any),
        },
        LoadWord::Ramp => History::Ramp {
            from: f
                .optional_quantity("from", push(f), Range::Any)
                .unwrap_or(0.0),
            to: torque(f),
            between: between(f, "between"),
        },
        LoadWord::Harmonic => History::Harmonic {
            mean: mean(f),
            amplitude: torque(f),
            omega: f.quantity("frequency", Kind::Frequency, Range::Positive),
            phase: f
                .optional_quantity("phase", Kind::Angle, Range::Any)
                .unwrap_or(0.0),
        },
        LoadWord::Orders => orders(f),
        LoadWord::Table => {
            History::Table(points(f, ("times", Kind::Time), ("torques", Kind::Torque)))
        }
        LoadWord::FaceMill => History::FaceMill(face_mill(f)),
        LoadWord::Product => History::Product {
            torque: torque(f),
            factors: factors::factors(f),
        },
    };
    Load {
        at,
        pushes,
        history,
    }
}

/// What the load is measured in.
fn push(f: &Fields) -> Kind {
    match f.has("force") {
        true => Kind::Force,
        false => Kind::Torque,
    }
}

fn torque(f: &mut Fields) -> f64 {
    match push(f) {
        Kind::Force => f.quantity("force", Kind::Force, Range::Any),
        kind => f.quantity("torque", kind, Range::Any),
    }
}

fn mean(f: &mut Fields) -> f64 {
    f.optional_quantity("mean", push(f), Range::Any)
        .unwrap_or(0.0)
}

fn orders(f: &mut Fields) -> History {
    let mean = mean(f);
    let numbers = waves::numbers(f, "orders", Range::Positive);
    // Where the orders themselves are wrong, nothing is said of the lists beside them.
    let count = numbers.as_ref().map(Vec::len);
    let numbers = numbers.unwrap_or_default();
    let torques = f.optional_quantities("torques", Kind::Torque, Range::Any, count);
    f.need("torques");
    let phases = f.optional_quantities("phases", Kind::Angle, Range::Any, count);
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
    History::Orders {
        mean,
        orders: orders.collect(),
    }
}

fn face_mill(f: &mut Fields) -> FaceMill {
    let blades = f.optional_count("blade_groups", 1, 1000);
    f.need("blade_groups");
    let forward = f.choice("sense", &[("forward", 1.0), ("backward", -1.0)]);
    f.need("sense");
    FaceMill {
        blades: blades.unwrap_or(1),
        radius: f.quantity("radius", Kind::Length, Range::Positive),
        arc: f.quantity(
            "arc",
            Kind::Angle,
            Range::Between(0.0, TAU, "above 0° and below 360°"),
        ),
        specific_force: f.quantity("specific_force", Kind::Pressure, Range::Positive),
        exponent: f
            .optional_number(
                "exponent",
                Range::Within(0.0, 1.0, "at least 0 and below 1"),
            )
            .unwrap_or(0.25),
        width: f.quantity("chip_width", Kind::Length, Range::Positive),
        chip: f.quantity("chip_thickness", Kind::Length, Range::Positive),
        runout: f
            .optional_quantity("runout", Kind::Length, Range::NotNegative)
            .unwrap_or(0.0),
        roll: between(f, "roll"),
        sense: forward.unwrap_or(1.0),
        slot: f.optional_quantity("slot", Kind::Angle, Range::Any),
        radial: f.optional_number("radial_share", Range::Any).unwrap_or(0.0),
        axial: f.optional_number("axial_share", Range::Any).unwrap_or(0.0),
    }
}

/// What drives a motor.
#[derive(Clone, Copy)]
enum MotorWord {
    Induction,
    Direct,
    Table,
    Speed,
    Angle,
}

/// A motor.
pub fn motor(f: &mut Fields) -> Motor {
    let name = common::name(f);
    let at = common::one_node(f, "at");
    let words = [
        ("induction", MotorWord::Induction),
        ("dc", MotorWord::Direct),
        ("table", MotorWord::Table),
        ("speed", MotorWord::Speed),
        ("angle", MotorWord::Angle),
    ];
    let word = f.choice("kind", &words);
    f.need("kind");
    let drive = match word {
        Some(MotorWord::Speed) => {
            let points = match f.has("times") {
                true => points(f, ("times", Kind::Time), ("speeds", Kind::Speed)),
                false => vec![(0.0, f.quantity("speed", Kind::Speed, Range::Any))],
            };
            let swing = swing(f, Kind::Speed);
            Drive::Speed(Course { points, swing })
        }
        Some(MotorWord::Angle) => Drive::Angle(angle(f)),
        Some(MotorWord::Induction) => {
            let curve = Curve::Induction {
                pull_out: f.quantity("pull_out", Kind::Torque, Range::Positive),
                slip: {
                    let slip = f.optional_number("pull_out_slip", Range::Positive);
                    f.need("pull_out_slip");
                    slip.unwrap_or(f64::NAN)
                },
                synchronous: turning(f, "synchronous"),
            };
            Drive::Curve { curve, lag: lag(f) }
        }
        Some(MotorWord::Table) => {
            let curve = Curve::Table(points(
                f,
                ("speeds", Kind::Speed),
                ("torques", Kind::Torque),
            ));
            Drive::Curve { curve, lag: lag(f) }
        }
        Some(MotorWord::Direct) | None => {
            let curve = Curve::Straight {
                stall: f.quantity("stall", Kind::Torque, Range::Any),
                idle: turning(f, "idle"),
            };
            Drive::Curve { curve, lag: lag(f) }
        }
    };
    Motor { name, at, drive }
}

/// What swings about a prescribed motion.
fn swing(f: &mut Fields, kind: Kind) -> Option<Swing> {
    let amplitude = f.optional_quantity("amplitude", kind, Range::Any);
    let omega = f.optional_quantity("frequency", Kind::Frequency, Range::Positive);
    let phase = f.optional_quantity("phase", Kind::Angle, Range::Any);
    match f.has("amplitude") {
        true => f.need("frequency"),
        false if f.has("frequency") || f.has("phase") => {
            f.missing("amplitude", ", and `frequency` or `phase` is given");
        }
        false => {}
    }
    Some(Swing {
        amplitude: amplitude?,
        omega: omega?,
        phase: phase.unwrap_or(0.0),
    })
}

/// An angle over time: points, a swing, or both.
fn angle(f: &mut Fields) -> Course {
    let swing = swing(f, Kind::Angle);
    if !f.has("times") && !f.has("angles") && !f.has("amplitude") {
        f.missing("amplitude", ", and no `times` and `angles` either");
    }
    let points = match f.has("times") || f.has("angles") {
        true => points(f, ("times", Kind::Time), ("angles", Kind::Angle)),
        false => vec![(0.0, 0.0)],
    };
    if points
        .windows(2)
        .any(|p| p[1].0 == p[0].0 && p[1].1 != p[0].1)
    {
        f.refuse_key(
            Code::OutOfRange,
            "angles",
            "the angle jumps",
            "let it rise over a short time in place of the jump",
        );
    }
    Course { points, swing }
}

fn lag(f: &mut Fields) -> f64 {
    f.optional_quantity("lag", Kind::Time, Range::NotNegative)
        .unwrap_or(0.0)
}

/// A speed of either sense that is not zero.
fn turning(f: &mut Fields, key: &str) -> f64 {
    let speed = f.quantity(key, Kind::Speed, Range::Any);
    if speed == 0.0 {
        f.refuse_key(
            Code::OutOfRange,
            key,
            format!("`{key}` is zero"),
            "give the speed with its sense",
        );
    }
    speed
}

/// Dry friction between two nodes whose capacity changes over time.
pub fn clutch(f: &mut Fields) -> Brake {
    let name = common::name(f);
    let between = common::ends_or_at(f);
    f.exclusive("torque", "torques");
    if f.has("factors") {
        return multiplied(f, name, between);
    }
    let points = match f.has("times") || f.has("torques") {
        true => points(f, ("times", Kind::Time), ("torques", Kind::Torque)),
        false => vec![(0.0, f.quantity("torque", Kind::Torque, Range::NotNegative))],
    };
    if points.iter().any(|p| p.1 < 0.0) {
        f.refuse_key(
            Code::OutOfRange,
            "torques",
            "a capacity below zero",
            "friction acts against the slip by itself: give sizes",
        );
    }
    if points.windows(2).any(|p| p[1].0 == p[0].0) {
        f.refuse_key(
            Code::OutOfRange,
            "times",
            "the capacity jumps",
            "let it rise over a short time in place of the jump",
        );
    }
    let law = friction::of_one(f);
    let largest = points.iter().fold(0.0f64, |m, p| m.max(p.1));
    let grip = (points.len() > 1 && largest > 0.0)
        .then(|| History::Table(points.iter().map(|p| (p.0, p.1 / largest)).collect()));
    pressed(name, between, (law, largest), grip)
}

/// Dry friction up to a largest capacity, of which there are shares over time.
fn pressed(
    name: Name,
    between: [End; 2],
    (law, largest): (Friction, f64),
    grip: Option<History>,
) -> Brake {
    Brake {
        name,
        between,
        friction: Friction {
            sliding: largest,
            breakaway: law.breakaway * largest,
            ..law
        },
        grip,
    }
}

/// A clutch whose capacity is a torque times factors, none of which jumps or falls below zero.
fn multiplied(f: &mut Fields, name: Name, between: [End; 2]) -> Brake {
    f.exclusive("factors", "torques");
    let torque = f.quantity("torque", Kind::Torque, Range::NotNegative);
    let factors = factors::factors(f);
    let jumps = |factor: &History| match factor {
        History::Step { .. } => true,
        History::Table(points) => points.windows(2).any(|p| p[1].0 == p[0].0),
        _ => false,
    };
    if factors.iter().any(jumps) {
        let hint = "take a ramp over a short time in place of the jump";
        f.refuse_key(Code::OutOfRange, "factors", "the capacity jumps", hint);
    }
    if factors
        .iter()
        .any(|factor| factor.range().is_none_or(|r| r[0] < 0.0))
    {
        let message = "a factor of a capacity falls below zero";
        let hint = "friction acts against the slip by itself: give a harmonic a `mean` of its `value` at least";
        f.refuse_key(Code::OutOfRange, "factors", message, hint);
    }
    let law = friction::of_one(f);
    let whole = |torque: f64| History::Product {
        torque,
        factors: factors.clone(),
    };
    let largest = whole(torque).range().map_or(0.0, |r| r[1]);
    let grip = (largest > 0.0).then(|| whole(torque / largest));
    pressed(name, between, (law, largest), grip)
}

/// A brake or a slipping clutch.
pub fn brake(f: &mut Fields) -> Brake {
    let name = common::name(f);
    let between = common::ends_or_at(f);
    let sliding = f.quantity("torque", Kind::Torque, Range::NotNegative);
    let breakaway = f.optional_quantity("breakaway", Kind::Torque, Range::NotNegative);
    if breakaway.is_some_and(|b| b < sliding) {
        f.refuse_key(
            Code::OutOfRange,
            "breakaway",
            "a brake that holds less than it rubs",
            "give at least the sliding torque, or leave it out",
        );
    }
    Brake {
        name,
        between,
        friction: friction::falling(f, sliding, breakaway.unwrap_or(sliding)),
        grip: None,
    }
}
