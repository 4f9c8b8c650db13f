//! Geometry as UFF: data sets 15 and 2411 (nodes, single and double precision) and 82 (trace lines).

use std::io::{self, Write};

use crate::base::code::Code;
use crate::base::error::Error;
use crate::recording::geometry::Geometry;

/// Digits of a coordinate of data set 15, and of 2411.
const DIGITS: (usize, usize) = (5, 16);

/// Nodes of a trace line in a row.
const TRACE_ROW: usize = 8;

/// Numbers of the nodes of all points: their names where these are numbers above zero, each another; else 1, 2, 3, …
fn node_numbers(geometry: &Geometry) -> Vec<i32> {
    let named: Option<Vec<i32>> = (geometry.points.iter())
        .map(|p| {
            p.name
                .parse()
                .ok()
                .filter(|n: &i32| *n > 0 && n.to_string() == p.name)
        })
        .collect();
    named.unwrap_or_else(|| (1..).take(geometry.points.len()).collect())
}

/// Node and direction code of a channel in the header of a data set 58; zeros where the geometry does not place it.
///
/// # Errors
/// `conflict` for a direction that is not along an axis, which data set 58 cannot hold.
pub(super) fn node_and_direction(geometry: &Geometry, channel: &str) -> Result<(i32, i32), Error> {
    let Some((point, direction)) = geometry.place(channel) else {
        return Ok((0, 0));
    };
    let code = (1..=3).find_map(|code| {
        let along = direction[code as usize - 1];
        (along.abs() == 1.0).then_some(code * along as i32)
    });
    let code = code.ok_or_else(|| {
        let message = format!(
            "channel {channel} points between the axes, and a data set 58 takes the axes alone"
        );
        Error::new(Code::Conflict, message)
            .with_hint("rotate the axes of the geometry, or write JSON or CSV")
    })?;
    Ok((node_numbers(geometry)[point], code))
}

/// Writes the data sets; nothing where there is no point.
pub(super) fn write_geometry(geometry: &Geometry, to: &mut impl Write) -> io::Result<()> {
    if geometry.is_empty() {
        return Ok(());
    }
    let numbers = node_numbers(geometry);
    let nodes = || numbers.iter().zip(&geometry.points);
    writeln!(to, "    -1\n    15")?;
    for (number, point) in nodes() {
        let [x, y, z] = point.at.map(|x| format_exponent(x, DIGITS.0));
        writeln!(
            to,
            "{number:10}{:10}{:10}{:10}{x:>13}{y:>13}{z:>13}",
            0, 0, 8
        )?;
    }
    writeln!(to, "    -1\n    -1\n  2411")?;
    for (number, point) in nodes() {
        let [x, y, z] = point
            .at
            .map(|x| format_exponent(x, DIGITS.1).replace('E', "D"));
        writeln!(
            to,
            "{number:10}{:10}{:10}{:10}\n{x:>25}{y:>25}{z:>25}",
            0, 0, 8
        )?;
    }
    writeln!(to, "    -1")?;
    if geometry.lines.is_empty() {
        return Ok(());
    }
    writeln!(to, "    -1\n    82")?;
    for (k, line) in geometry.lines.iter().enumerate() {
        writeln!(to, "{:10}{:10}{:10}\nNONE", k + 1, line.len(), 0)?;
        for row in line.chunks(TRACE_ROW) {
            let nodes: String = row.iter().map(|p| format!("{:10}", numbers[*p])).collect();
            writeln!(to, "{nodes}")?;
        }
    }
    writeln!(to, "    -1")
}

/// `d.ddddE±dd`, as Fortran and C write it.
pub(super) fn format_exponent(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "NaN".to_string();
    }
    let text = format!("{value:.digits$E}");
    let (mantissa, exponent) = text.split_once('E').unwrap_or((&text, "0"));
    let (sign, size) = match exponent.strip_prefix('-') {
        Some(size) => ('-', size),
        None => ('+', exponent),
    };
    format!("{mantissa}E{sign}{size:0>2}")
}
