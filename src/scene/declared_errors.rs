//! Reads `[[error]]`: geometric errors as harmonics, table, file of values or tolerance grade.

use std::path::Path;

use super::model::{DeclaredError, ErrorCause, ErrorDefinition, Name};
use super::shared_keys;
use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::load;
use crate::base::quantity;
use crate::base::quantity_kind::QuantityKind;
use crate::base::table_reader::TableReader;
use crate::base::toml::Value;

/// The highest order per turn.
const MAX_ORDER: u32 = 1_000_000;

/// The highest harmonic of a mesh.
const MAX_OF_MESH: u32 = 1000;

/// The coarsest grade of ISO 1328-1:1995.
const MAX_GRADE: u32 = 12;

/// A tilt of a coupling's ends against each other.
const TILT: ValueRange = ValueRange::HalfOpen(0.0, 1.0, "at least 0 and below 1 rad");

/// A size: no gear errs by a metre, no coupling by a radian.
const SIZE: ValueRange =
    ValueRange::HalfOpen(0.0, 1.0, "at least 0 and below 1 m, of a coupling 1 rad");

/// Keys that say how large an error is.
const SIZES: [&str; 6] = ["amplitude", "amplitudes", "values", "file", "tilt", "grade"];

/// An error of a gear, a coupling, a belt or a screw.
pub fn read_declared_error(f: &mut TableReader) -> DeclaredError {
    let on = shared_keys::read_node(f, "on");
    let mesh = f.optional_text("mesh").map(|text| Name {
        text: text.to_string(),
        span: f.span_of("mesh").clone(),
    });
    let cause = f
        .choice("cause", ErrorCause::WORDS)
        .unwrap_or(ErrorCause::Form);
    let kind = match cause {
        ErrorCause::Misalignment => QuantityKind::Angle,
        _ => QuantityKind::Length,
    };
    let unknown =
        f.has("phase") && f.span_of("phase").text().trim_matches(['"', '\'']) == "unknown";
    let phase = match unknown {
        true => {
            f.item("phase", "an angle, or \"unknown\"");
            0.0
        }
        false => {
            (f.optional_quantity("phase", QuantityKind::Angle, ValueRange::Any)).unwrap_or(0.0)
        }
    };
    let tolerance = f.optional_number(
        "tolerance",
        ValueRange::HalfOpen(0.0, 1.0, "at least 0 and below 1"),
    );
    let given: Vec<&str> = SIZES.into_iter().filter(|key| f.has(key)).collect();
    if let [one, other, ..] = given[..] {
        f.exclusive(one, other);
        f.item(other, "");
    }
    let size = match given.first().copied().unwrap_or("amplitude") {
        "amplitudes" => read_harmonics(f, cause, kind),
        "values" => {
            let values = f.optional_quantities(
                "values",
                kind,
                ValueRange::Open(-1.0, 1.0, "within ±1 m, of a coupling ±1 rad"),
                None,
            );
            table(f, "values", values)
        }
        "file" => {
            let values = from_file(f, kind);
            table(f, "file", values)
        }
        "grade" => ErrorDefinition::Grade {
            grade: f.optional_count("grade", 0, MAX_GRADE).unwrap_or(MAX_GRADE),
            phase,
        },
        "tilt" => ErrorDefinition::Tilt {
            angle: f.quantity("tilt", QuantityKind::Angle, TILT),
            phase,
        },
        _ => single(f, cause, kind, phase),
    };
    check_combination(f, cause, &size);
    DeclaredError {
        on,
        mesh,
        cause,
        size,
        // What a grade allows says nothing of where it stands.
        phase_known: !unknown && (f.has("phase") || !f.has("grade")),
        tolerance: tolerance.unwrap_or(0.0),
    }
}

/// One harmonic.
fn single(
    f: &mut TableReader,
    cause: ErrorCause,
    kind: QuantityKind,
    phase: f64,
) -> ErrorDefinition {
    let amplitude = f.quantity("amplitude", kind, SIZE);
    f.exclusive("order", "harmonic");
    let order = f.optional_count("order", 1, MAX_ORDER);
    let harmonic = f.optional_count("harmonic", 1, MAX_OF_MESH);
    let of_teeth = matches!(cause, ErrorCause::Profile | ErrorCause::ToothForm) && order.is_none();
    if cause == ErrorCause::BeltJoint {
        let length = f.quantity("length", QuantityKind::Length, ValueRange::Positive);
        return ErrorDefinition::Joint {
            amplitude,
            length,
            phase,
        };
    }
    match (harmonic, order) {
        (Some(n), _) => ErrorDefinition::Mesh(vec![(n, amplitude, phase)]),
        (None, None) if of_teeth => ErrorDefinition::Mesh(vec![(1, amplitude, phase)]),
        (None, None) if cause == ErrorCause::Misalignment => {
            ErrorDefinition::Orders(vec![(2, amplitude, phase)])
        }
        (None, order) => ErrorDefinition::Orders(vec![(order.unwrap_or(1), amplitude, phase)]),
    }
}

/// Several harmonics: `amplitudes`, with `orders` or `harmonics` and perhaps `phases`.
fn read_harmonics(f: &mut TableReader, cause: ErrorCause, kind: QuantityKind) -> ErrorDefinition {
    let amplitudes = f
        .optional_quantities("amplitudes", kind, SIZE, None)
        .unwrap_or_default();
    let n = amplitudes.len();
    let phases = f.optional_quantities("phases", QuantityKind::Angle, ValueRange::Any, Some(n));
    f.exclusive("orders", "harmonics");
    let counts = |f: &mut TableReader, key: &str, high: u32| -> Option<Vec<u32>> {
        let item = f.item(key, "a list of whole numbers")?;
        let Value::List(list) = &item.value else {
            return f.wrong_type(key, item, "a list of whole numbers");
        };
        let whole = |item: &crate::base::toml::Item| match item.value {
            Value::Integer(n) => u32::try_from(n).ok().filter(|n| (1..=high).contains(n)),
            _ => None,
        };
        let all: Vec<u32> = list.iter().filter_map(whole).collect();
        if all.len() != list.len() || all.len() != n {
            let message = format!("`{key}` does not go with {n} amplitudes");
            let hint = format!("give one whole number from 1 to {high} for each amplitude");
            f.report_key(Code::OutOfRange, key, message, &hint);
            return None;
        }
        Some(all)
    };
    let orders = counts(f, "orders", MAX_ORDER);
    let harmonics = counts(f, "harmonics", MAX_OF_MESH);
    let of_teeth = harmonics.is_some()
        || (orders.is_none() && matches!(cause, ErrorCause::Profile | ErrorCause::ToothForm));
    let numbers = harmonics.or(orders).unwrap_or((1..=n as u32).collect());
    let terms = (0..n.min(numbers.len()))
        .map(|k| {
            (
                numbers[k],
                amplitudes[k],
                phases.as_ref().map_or(0.0, |p| p[k]),
            )
        })
        .collect();
    match of_teeth {
        true => ErrorDefinition::Mesh(terms),
        false => ErrorDefinition::Orders(terms),
    }
}

/// An error by its values; `None` where they could not be read, which is reported already.
fn table(f: &mut TableReader, key: &str, values: Option<Vec<f64>>) -> ErrorDefinition {
    if values.as_ref().is_some_and(|values| values.len() < 2) {
        f.report_key(
            Code::OutOfRange,
            key,
            "a table needs two values at least",
            "give one value a tooth, cumulative; of a screw one at every step of its `travel`",
        );
    }
    let values = values.unwrap_or_default();
    match f.optional_quantity("travel", QuantityKind::Length, ValueRange::Positive) {
        Some(travel) => ErrorDefinition::Travel { values, travel },
        None => ErrorDefinition::Table(values),
    }
}

/// Values of a text file: one a line, the last of its cells; lines before the first number are its head.
fn from_file(f: &mut TableReader, kind: QuantityKind) -> Option<Vec<f64>> {
    let unit = f.optional_text("file_unit");
    f.require("file_unit");
    let (Some(name), Some(unit)) = (f.optional_text("file"), unit) else {
        return None;
    };
    let place = f.span_of("file").clone();
    let beside = Path::new(&place.source().path)
        .parent()
        .unwrap_or(Path::new(""));
    let path = beside.join(name);
    let read = || {
        let factor = quantity::parse(&format!("1 {unit}"), kind, "`file_unit`")?;
        let source = load::load(&path).map_err(|error| match error.code {
            Code::FileMissing => error
                .with_hint("the path starts from the folder of the file that has the [[error]]"),
            _ => error,
        })?;
        let mut values: Vec<f64> = Vec::new();
        for (at, line) in source.text.lines().enumerate() {
            let cell = line.rsplit([',', ';', '\t']).next().unwrap_or("").trim();
            match cell.parse::<f64>() {
                Ok(value) if value.is_finite() => values.push(factor * value),
                Err(_) if values.is_empty() || line.trim().is_empty() => {}
                _ => {
                    let message = format!(
                        "line {} of {} ends in no number: \"{}\"",
                        at + 1,
                        path.display(),
                        quantity::truncate(line)
                    );
                    return Err(crate::base::error::Error::new(Code::NotANumber, message)
                        .with_hint("the last cell of each line is a value; the values cover one turn, equally spaced"));
                }
            }
        }
        Ok(values)
    };
    read()
        .map_err(|error| f.errors.push(error.with_span(&place)))
        .ok()
}

/// Sizes that do not go with a cause.
fn check_combination(f: &mut TableReader, cause: ErrorCause, size: &ErrorDefinition) {
    let refuse = |f: &mut TableReader, key: &str, hint: &str| {
        let message = format!("`{key}` does not go with cause = \"{}\"", cause.name());
        f.report_key(Code::Conflict, key, message, hint);
    };
    let is_offset = cause.is_offset();
    let graded = matches!(size, ErrorDefinition::Grade { .. });
    let once = matches!(size, ErrorDefinition::Orders(terms) if terms.iter().all(|t| t.0 == 1));
    let known = [
        ErrorCause::Eccentricity,
        ErrorCause::CumulativePitch,
        ErrorCause::SinglePitch,
        ErrorCause::Profile,
    ];
    if graded && !known.contains(&cause) {
        refuse(
            f,
            "grade",
            "a grade limits an eccentricity, a cumulative pitch, a single pitch or a profile",
        );
    }
    if is_offset && !once && !graded {
        let key = [
            "order",
            "orders",
            "harmonic",
            "harmonics",
            "values",
            "file",
            "tilt",
            "amplitudes",
        ];
        let key = key
            .into_iter()
            .find(|key| f.has(key))
            .unwrap_or("amplitude");
        refuse(
            f,
            key,
            "an offset turns once a turn; other orders have cause = \"form\"",
        );
    }
    if matches!(size, ErrorDefinition::Travel { .. }) && cause != ErrorCause::Lead {
        refuse(f, "travel", "a travel is of a screw: cause = \"lead\"");
    }
    if matches!(size, ErrorDefinition::Mesh(_)) && cause == ErrorCause::Lead {
        let key = ["harmonic", "harmonics"].into_iter().find(|k| f.has(k));
        refuse(
            f,
            key.unwrap_or("amplitude"),
            "a screw has no teeth: give `order` or `orders`, per turn of it",
        );
    }
    if matches!(size, ErrorDefinition::Tilt { .. }) && cause != ErrorCause::Misalignment {
        refuse(f, "tilt", "a tilt is of a misaligned coupling");
    }
    if cause == ErrorCause::BeltJoint && !matches!(size, ErrorDefinition::Joint { .. }) {
        refuse(
            f,
            "cause",
            "a belt's joint has an `amplitude` and the belt's `length`",
        );
    }
}
