//! `characteristic`: force over deflection of couplings and teeth that are not linear.

use super::laws::Characteristic;
use crate::base::code::Code;
use crate::base::fields::Fields;
use crate::base::kind::Kind;
use crate::base::notes::Range;

/// The most points of a curve.
const MOST: usize = 10_000;

/// Which kind a characteristic is of.
#[derive(Clone, Copy)]
enum Word {
    Power,
    Table,
}

const WORDS: &[(&str, Word)] = &[("power", Word::Power), ("table", Word::Table)];

/// Torque over twist.
pub fn torsional(f: &mut Fields) -> Option<Characteristic> {
    read(f, ["torque", "torques"], Kind::Torque, Kind::Angle)
}

/// Force along the tooth normal over deflection.
pub fn along_tooth(f: &mut Fields) -> Option<Characteristic> {
    read(f, ["force", "forces"], Kind::Force, Kind::Length)
}

fn read(
    f: &mut Fields,
    [one, many]: [&str; 2],
    force: Kind,
    deflection: Kind,
) -> Option<Characteristic> {
    const EXPONENT: Range = Range::Within(1.0, 20.0, "at least 1 and below 20");
    let word = f.choice("kind", WORDS);
    f.need("kind");
    match word? {
        Word::Power => {
            let at = f.quantity(one, force, Range::Positive);
            let rated = f.quantity("deflection", deflection, Range::Positive);
            let exponent = f.optional_number("exponent", EXPONENT);
            f.need("exponent");
            let exponent = exponent?;
            let factor = at / rated.powf(exponent);
            if at.is_finite() && rated.is_finite() && !(factor.is_normal() && rated.is_normal()) {
                let message =
                    format!("`{one}` over `deflection` to this power leaves the range of numbers");
                f.refuse_key(
                    Code::OutOfRange,
                    one,
                    message,
                    "look at the units and the exponent",
                );
            }
            Some(Characteristic::Power {
                factor,
                exponent,
                rated,
            })
        }
        Word::Table => {
            let deflections =
                f.optional_quantities("deflections", deflection, Range::NotNegative, None);
            let forces = f.optional_quantities(many, force, Range::NotNegative, None);
            f.need("deflections");
            f.need(many);
            points(f, many, deflections?, forces?)
        }
    }
}

/// Points from rest, rising: the same backward, so one side suffices.
fn points(
    f: &mut Fields,
    many: &str,
    deflections: Vec<f64>,
    forces: Vec<f64>,
) -> Option<Characteristic> {
    let mut refuse = |key: &str, message: String, hint: &str| {
        f.refuse_key(Code::OutOfRange, key, message, hint);
        None
    };
    let (n, m) = (deflections.len(), forces.len());
    if n != m {
        let message = format!("{n} deflections and {m} {many}");
        return refuse(many, message, "give one for each");
    }
    if !(2..=MOST).contains(&n) {
        return refuse(
            "deflections",
            format!("{n} points make no curve"),
            "give two to ten thousand",
        );
    }
    if deflections[0] != 0.0 || forces[0] != 0.0 {
        let hint = "the same curve holds backward, so that it passes through rest: begin both lists with 0";
        return refuse(
            "deflections",
            "the curve does not begin at rest".to_string(),
            hint,
        );
    }
    if let Some(at) = (1..n).find(|&i| !(deflections[i] > deflections[i - 1])) {
        let message = format!("deflection {} of {n} is not above the one before", at + 1);
        return refuse(
            "deflections",
            message,
            "write the points by rising deflection",
        );
    }
    if let Some(at) = (1..n).find(|&i| forces[i] < forces[i - 1]) {
        let message = format!("value {} of `{many}` falls below the one before", at + 1);
        return refuse(
            many,
            message,
            "a spring that yields as it is pressed has no stable rest: let the values rise or stay",
        );
    }
    if !(forces[n - 1] > forces[n - 2]) {
        let hint = "beyond the last point the curve goes on straight: let it rise there";
        return refuse(many, "the curve ends flat".to_string(), hint);
    }
    Some(Characteristic::Table(
        deflections.into_iter().zip(forces).collect(),
    ))
}
