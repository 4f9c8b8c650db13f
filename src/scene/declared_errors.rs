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

/// Maximum order per revolution.
const MAX_ORDER: u32 = 1_000_000;

/// Maximum harmonic of the mesh frequency.
const MAX_MESH_HARMONIC: u32 = 1000;

/// The coarsest grade of ISO 1328-1:1995.
const MAX_GRADE: u32 = 12;

/// Range of the misalignment angle of a coupling.
const TILT_RANGE: ValueRange = ValueRange::HalfOpen(0.0, 1.0, "at least 0 and below 1 rad");

/// Range of amplitudes, m, of couplings rad.
const AMPLITUDE_RANGE: ValueRange =
    ValueRange::HalfOpen(0.0, 1.0, "at least 0 and below 1 m, of a coupling 1 rad");

/// Keys of the magnitude of an error; at most one may be stated.
const MAGNITUDES: [&str; 6] = ["amplitude", "amplitudes", "values", "file", "tilt", "grade"];

/// Reads an error of a gear, a coupling, a belt or a screw.
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
    let is_phase_unknown =
        f.has("phase") && f.span_of("phase").text().trim_matches(['"', '\'']) == "unknown";
    let phase = match is_phase_unknown {
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
    let keys: Vec<&str> = MAGNITUDES.into_iter().filter(|key| f.has(key)).collect();
    if let [first, second, ..] = keys[..] {
        f.exclusive(first, second);
        f.item(second, "");
    }
    let size = match keys.first().copied().unwrap_or("amplitude") {
        "amplitudes" => read_harmonics(f, cause, kind),
        "values" => {
            let values = f.optional_quantities(
                "values",
                kind,
                ValueRange::Open(-1.0, 1.0, "within ±1 m, of a coupling ±1 rad"),
                None,
            );
            tabulated_error(f, "values", values)
        }
        "file" => {
            let values = read_value_file(f, kind);
            tabulated_error(f, "file", values)
        }
        "grade" => ErrorDefinition::Grade {
            grade: f.optional_count("grade", 0, MAX_GRADE).unwrap_or(MAX_GRADE),
            phase,
        },
        "tilt" => ErrorDefinition::Tilt {
            angle: f.quantity("tilt", QuantityKind::Angle, TILT_RANGE),
            phase,
        },
        _ => read_harmonic(f, cause, kind, phase),
    };
    check_combination(f, cause, &size);
    DeclaredError {
        on,
        mesh,
        cause,
        size,
        // A grade limits the amplitude and leaves the phase open.
        phase_known: !is_phase_unknown && (f.has("phase") || !f.has("grade")),
        tolerance: tolerance.unwrap_or(0.0),
    }
}

/// Reads an error of one harmonic.
fn read_harmonic(
    f: &mut TableReader,
    cause: ErrorCause,
    kind: QuantityKind,
    phase: f64,
) -> ErrorDefinition {
    let amplitude = f.quantity("amplitude", kind, AMPLITUDE_RANGE);
    f.exclusive("order", "harmonic");
    let order = f.optional_count("order", 1, MAX_ORDER);
    let harmonic = f.optional_count("harmonic", 1, MAX_MESH_HARMONIC);
    let is_mesh = matches!(cause, ErrorCause::Profile | ErrorCause::ToothForm) && order.is_none();
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
        (None, None) if is_mesh => ErrorDefinition::Mesh(vec![(1, amplitude, phase)]),
        (None, None) if cause == ErrorCause::Misalignment => {
            ErrorDefinition::Orders(vec![(2, amplitude, phase)])
        }
        (None, order) => ErrorDefinition::Orders(vec![(order.unwrap_or(1), amplitude, phase)]),
    }
}

/// Reads an error of several harmonics: `amplitudes`, with `orders` or `harmonics` and optional `phases`.
fn read_harmonics(f: &mut TableReader, cause: ErrorCause, kind: QuantityKind) -> ErrorDefinition {
    let amplitudes = f
        .optional_quantities("amplitudes", kind, AMPLITUDE_RANGE, None)
        .unwrap_or_default();
    let n = amplitudes.len();
    let phases = f.optional_quantities("phases", QuantityKind::Angle, ValueRange::Any, Some(n));
    f.exclusive("orders", "harmonics");
    let read_counts = |f: &mut TableReader, key: &str, max: u32| -> Option<Vec<u32>> {
        let item = f.item(key, "a list of whole numbers")?;
        let Value::List(list) = &item.value else {
            return f.wrong_type(key, item, "a list of whole numbers");
        };
        let count = |item: &crate::base::toml::Item| match item.value {
            Value::Integer(n) => u32::try_from(n).ok().filter(|n| (1..=max).contains(n)),
            _ => None,
        };
        let counts: Vec<u32> = list.iter().filter_map(count).collect();
        if counts.len() != list.len() || counts.len() != n {
            let message = format!("the length of `{key}` does not match {n} amplitudes");
            let hint = format!("give one whole number from 1 to {max} for each amplitude");
            f.report_key(Code::OutOfRange, key, message, &hint);
            return None;
        }
        Some(counts)
    };
    let orders = read_counts(f, "orders", MAX_ORDER);
    let harmonics = read_counts(f, "harmonics", MAX_MESH_HARMONIC);
    let is_mesh = harmonics.is_some()
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
    match is_mesh {
        true => ErrorDefinition::Mesh(terms),
        false => ErrorDefinition::Orders(terms),
    }
}

/// Error tabulated by `values`; empty where they could not be read, which is already reported.
fn tabulated_error(f: &mut TableReader, key: &str, values: Option<Vec<f64>>) -> ErrorDefinition {
    if values.as_ref().is_some_and(|values| values.len() < 2) {
        f.report_key(
            Code::OutOfRange,
            key,
            "a table needs at least two values",
            "give one cumulative value per tooth; for a screw one at every step of its `travel`",
        );
    }
    let values = values.unwrap_or_default();
    match f.optional_quantity("travel", QuantityKind::Length, ValueRange::Positive) {
        Some(travel) => ErrorDefinition::Travel { values, travel },
        None => ErrorDefinition::Table(values),
    }
}

/// Reads the values of a text file: the last cell of each line; lines before the first number are its header.
fn read_value_file(f: &mut TableReader, kind: QuantityKind) -> Option<Vec<f64>> {
    let unit = f.optional_text("file_unit");
    f.require("file_unit");
    let (Some(name), Some(unit)) = (f.optional_text("file"), unit) else {
        return None;
    };
    let span = f.span_of("file").clone();
    let folder = Path::new(&span.source().path)
        .parent()
        .unwrap_or(Path::new(""));
    let path = folder.join(name);
    let read = || {
        let factor = quantity::parse(&format!("1 {unit}"), kind, "`file_unit`")?;
        let source = load::load(&path).map_err(|error| match error.code {
            Code::FileMissing => error
                .with_hint("the path is relative to the folder of the file that has the [[error]]"),
            _ => error,
        })?;
        let mut values: Vec<f64> = Vec::new();
        for (index, line) in source.text.lines().enumerate() {
            let cell = line.rsplit([',', ';', '\t']).next().unwrap_or("").trim();
            match cell.parse::<f64>() {
                Ok(value) if value.is_finite() => values.push(factor * value),
                Err(_) if values.is_empty() || line.trim().is_empty() => {}
                _ => {
                    let message = format!(
                        "line {} of {} does not end in a number: \"{}\"",
                        index + 1,
                        path.display(),
                        quantity::truncate(line)
                    );
                    return Err(crate::base::error::Error::new(Code::NotANumber, message)
                        .with_hint("the last cell of each line must be a value; the values cover one turn, equally spaced"));
                }
            }
        }
        Ok(values)
    };
    read()
        .map_err(|error| f.errors.push(error.with_span(&span)))
        .ok()
}

/// Reports magnitudes that do not apply to the cause.
fn check_combination(f: &mut TableReader, cause: ErrorCause, size: &ErrorDefinition) {
    let refuse = |f: &mut TableReader, key: &str, hint: &str| {
        let message = format!("`{key}` does not apply to cause = \"{}\"", cause.name());
        f.report_key(Code::Conflict, key, message, hint);
    };
    let is_offset = cause.is_offset();
    let is_graded = matches!(size, ErrorDefinition::Grade { .. });
    let is_first = matches!(size, ErrorDefinition::Orders(terms) if terms.iter().all(|t| t.0 == 1));
    let graded_causes = [
        ErrorCause::Eccentricity,
        ErrorCause::CumulativePitch,
        ErrorCause::SinglePitch,
        ErrorCause::Profile,
    ];
    if is_graded && !graded_causes.contains(&cause) {
        refuse(
            f,
            "grade",
            "a grade applies to an eccentricity, a cumulative pitch, a single pitch or a profile",
        );
    }
    if is_offset && !is_first && !is_graded {
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
            "an offset has order 1; use cause = \"form\" for other orders",
        );
    }
    if matches!(size, ErrorDefinition::Travel { .. }) && cause != ErrorCause::Lead {
        refuse(f, "travel", "a travel needs a screw: cause = \"lead\"");
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
        refuse(f, "tilt", "a tilt applies to misaligned couplings only");
    }
    if cause == ErrorCause::BeltJoint && !matches!(size, ErrorDefinition::Joint { .. }) {
        refuse(
            f,
            "cause",
            "a belt's joint needs an `amplitude` and the belt's `length`",
        );
    }
}
