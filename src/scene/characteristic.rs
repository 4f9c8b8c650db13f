//! `characteristic`: force over deflection of couplings and teeth that are not linear.

use super::laws::Characteristic;
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;

/// The most points of a curve.
const MAX_COUNT: usize = 10_000;

/// Which kind a characteristic is of.
#[derive(Clone, Copy)]
enum CharacteristicTag {
    Power,
    Table,
}

const WORDS: &[(&str, CharacteristicTag)] = &[
    ("power", CharacteristicTag::Power),
    ("table", CharacteristicTag::Table),
];

/// Torque over twist.
pub fn torque_twist(f: &mut TableReader) -> Option<Characteristic> {
    read(
        f,
        ["torque", "torques"],
        QuantityKind::Torque,
        QuantityKind::Angle,
    )
}

/// Force along the tooth normal over deflection.
pub fn force_deflection(f: &mut TableReader) -> Option<Characteristic> {
    read(
        f,
        ["force", "forces"],
        QuantityKind::Force,
        QuantityKind::Length,
    )
}

fn read(
    f: &mut TableReader,
    [one, many]: [&str; 2],
    force: QuantityKind,
    deflection: QuantityKind,
) -> Option<Characteristic> {
    const EXPONENT: ValueRange = ValueRange::HalfOpen(1.0, 20.0, "at least 1 and below 20");
    let word = f.choice("kind", WORDS);
    f.require("kind");
    match word? {
        CharacteristicTag::Power => {
            let at = f.quantity(one, force, ValueRange::Positive);
            let rated = f.quantity("deflection", deflection, ValueRange::Positive);
            let exponent = f.optional_number("exponent", EXPONENT);
            f.require("exponent");
            let exponent = exponent?;
            let factor = at / rated.powf(exponent);
            if at.is_finite() && rated.is_finite() && !(factor.is_normal() && rated.is_normal()) {
                let message = format!("`{one}` over `deflection` to this power overflows");
                f.report_key(
                    Code::OutOfRange,
                    one,
                    message,
                    "check the units and the exponent",
                );
            }
            Some(Characteristic::Power {
                factor,
                exponent,
                rated,
            })
        }
        CharacteristicTag::Table => {
            let deflections =
                f.optional_quantities("deflections", deflection, ValueRange::NotNegative, None);
            let forces = f.optional_quantities(many, force, ValueRange::NotNegative, None);
            f.require("deflections");
            f.require(many);
            points(f, many, deflections?, forces?)
        }
    }
}

/// Points from rest, rising: the same backward, so one side suffices.
fn points(
    f: &mut TableReader,
    many: &str,
    deflections: Vec<f64>,
    forces: Vec<f64>,
) -> Option<Characteristic> {
    let mut refuse = |key: &str, message: String, hint: &str| {
        f.report_key(Code::OutOfRange, key, message, hint);
        None
    };
    let (n, m) = (deflections.len(), forces.len());
    if n != m {
        let message = format!("{n} deflections and {m} {many}");
        return refuse(many, message, "give one for each");
    }
    if !(2..=MAX_COUNT).contains(&n) {
        return refuse(
            "deflections",
            format!("{n} points do not define a curve"),
            "give two to ten thousand",
        );
    }
    if deflections[0] != 0.0 || forces[0] != 0.0 {
        let hint = "the curve is odd and must pass through the origin: start both lists with 0";
        return refuse(
            "deflections",
            "the curve does not start at the origin".to_string(),
            hint,
        );
    }
    if let Some(at) = (1..n).find(|&i| !(deflections[i] > deflections[i - 1])) {
        let message = format!("deflection {} of {n} is not above the one before", at + 1);
        return refuse(
            "deflections",
            message,
            "give the points in order of increasing deflection",
        );
    }
    if let Some(at) = (1..n).find(|&i| forces[i] < forces[i - 1]) {
        let message = format!("value {} of `{many}` falls below the one before", at + 1);
        return refuse(
            many,
            message,
            "a spring of negative stiffness has no stable equilibrium: give values that do not decrease",
        );
    }
    if !(forces[n - 1] > forces[n - 2]) {
        let hint = "the curve is extrapolated linearly: give a last slope above zero";
        return refuse(many, "the curve ends flat".to_string(), hint);
    }
    Some(Characteristic::Table(
        deflections.into_iter().zip(forces).collect(),
    ))
}
