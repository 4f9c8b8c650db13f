//! Reads `[[point]]`, `[[line]]` and the place of a `[[channel]]` of a sidecar.

use crate::base::code::Code;
use crate::base::error_collector::ValueRange;
use crate::base::quantity::truncate;
use crate::base::quantity_kind::QuantityKind;
use crate::base::source_span::SourceSpan;
use crate::base::table_reader::TableReader;
use crate::base::tables::read_tables;
use crate::base::text::{quoted_list, suggestion};
use crate::base::toml::Value;
use crate::recording::geometry::{ChannelPlace, Geometry, GeometryPoint};

/// Values that `direction` takes.
const DIRECTION: &str =
    "\"+x\", \"-x\", \"+y\", \"-y\", \"+z\", \"-z\", or three components such as [0.0, 0.6, 0.8]";

/// Reads all `[[point]]` and `[[line]]`.
pub(super) fn read_geometry(f: &mut TableReader) -> Geometry {
    let points = read_tables(f, "point", point);
    for (k, (point, span)) in points.iter().enumerate() {
        if points[..k]
            .iter()
            .any(|(other, _)| other.name == point.name)
        {
            let message = format!("two [[point]] have the name \"{}\"", point.name);
            f.report(
                Code::DuplicateName,
                message,
                span,
                "give each a name of its own",
            );
        }
    }
    let points = points.into_iter().map(|(point, _)| point).collect();
    let mut geometry = Geometry {
        points,
        ..Geometry::default()
    };
    geometry.lines = read_tables(f, "line", |f| line(f, &geometry));
    geometry
}

fn point(f: &mut TableReader) -> (GeometryPoint, SourceSpan) {
    f.require("name");
    f.require("at");
    let name = f.optional_text("name").unwrap_or_default().to_string();
    let at = f.optional_quantities("at", QuantityKind::Length, ValueRange::Any, Some(3));
    let at = at.unwrap_or_default();
    let point = GeometryPoint {
        name,
        at: std::array::from_fn(|k| at.get(k).copied().unwrap_or(0.0)),
    };
    (point, f.span_of("name").clone())
}

fn line(f: &mut TableReader, geometry: &Geometry) -> Vec<usize> {
    f.require("between");
    let names = f.texts("between");
    if names.len() == 1 {
        let hint = "name two points, or more along one line: between = [\"1\", \"2\"]";
        f.report_key(Code::WrongType, "between", "a line has one point", hint);
    }
    let point = |name: &String| known_point(f, "between", name, geometry);
    names.iter().filter_map(point).collect()
}

/// Index of a point; reports a name that no `[[point]]` has.
fn known_point(f: &mut TableReader, key: &str, name: &str, geometry: &Geometry) -> Option<usize> {
    let point = geometry.point(name);
    if point.is_none() {
        let names = || geometry.points.iter().map(|p| p.name.as_str());
        let hint = match (suggestion(name, names()), geometry.is_empty()) {
            (Some(near), _) => format!("did you mean \"{near}\"?"),
            (None, true) => "state it: [[point]] with name and at".to_string(),
            (None, false) => format!("the points are {}", quoted_list(names())),
        };
        f.report_key(
            Code::UnknownPoint,
            key,
            format!("no [[point]] has the name \"{name}\""),
            &hint,
        );
    }
    point
}

/// Point and direction of the `[[channel]]` that is being read, under the name it has from here on.
pub(super) fn read_place(f: &mut TableReader, geometry: &Geometry) -> Option<ChannelPlace> {
    f.requires("point", "direction");
    let channel = f
        .optional_text("rename")
        .or_else(|| f.optional_text("name"));
    let channel = channel.unwrap_or_default().to_string();
    let direction = read_direction(f);
    let point = f.optional_text("point").map(str::to_string);
    let point = match &point {
        Some(name) => Some(known_point(f, "point", name, geometry)?),
        None => None,
    };
    Some(ChannelPlace {
        channel,
        point,
        direction: direction?,
    })
}

/// `direction` as a unit vector.
fn read_direction(f: &mut TableReader) -> Option<[f64; 3]> {
    let item = f.item("direction", DIRECTION)?;
    let vector = match &item.value {
        Value::String(word) => axis(word),
        Value::List(list) if list.len() == 3 => {
            let mut parts = list
                .iter()
                .map(|item| f.number_of("direction", item, ValueRange::Any));
            let mut next = || parts.next().flatten();
            Some([next()?, next()?, next()?])
        }
        _ => None,
    };
    let length = vector.map_or(0.0, |v| v.iter().map(|x| x * x).sum::<f64>().sqrt());
    match vector {
        Some(v) if length > 0.0 => Some(v.map(|x| x / length)),
        Some(_) => {
            let hint = "state the direction of positive values of the channel";
            f.report_key(
                Code::OutOfRange,
                "direction",
                "`direction` has no length",
                hint,
            );
            None
        }
        None => {
            let message = format!("`direction` cannot be {}", truncate(item.span.text()));
            let hint = format!("`direction` takes {DIRECTION}");
            f.report_key(Code::OutOfRange, "direction", message, &hint);
            None
        }
    }
}

/// The unit vector of a word such as `-z`; without a sign it is positive.
fn axis(word: &str) -> Option<[f64; 3]> {
    let (sign, letter) = match word.strip_prefix(['+', '-']) {
        Some(letter) => (if word.starts_with('-') { -1.0 } else { 1.0 }, letter),
        None => (1.0, word),
    };
    let at = ["x", "y", "z"]
        .iter()
        .position(|l| l.eq_ignore_ascii_case(letter))?;
    Some(std::array::from_fn(|k| if k == at { sign } else { 0.0 }))
}
