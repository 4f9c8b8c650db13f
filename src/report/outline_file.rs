//! Outlines of gears at scale, closed polygons by name: CSV, DXF (release 12, millimetres), SVG.

use std::io::{self, Write};

use super::table::{Table, decimal};

/// Closed outline of a member.
#[derive(Debug, Clone, PartialEq)]
pub struct NamedOutline {
    /// Name of the member: layer, group or first column.
    pub name: &'static str,
    /// Points, m; the last is followed by the first.
    pub points: Vec<[f64; 2]>,
}

/// File formats of outlines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutlineFormat {
    /// Rows of member and point, the first point of a member repeated at its end.
    Csv,
    /// A closed polyline on a layer for each member.
    Dxf,
    /// A path for each member, 1 mm long where 1 mm is meant.
    Svg,
}

impl OutlineFormat {
    /// Suffixes of file names.
    pub const SUFFIXES: [&str; 3] = ["csv", "dxf", "svg"];

    /// The format of a suffix of [`OutlineFormat::SUFFIXES`].
    pub fn of_suffix(suffix: &str) -> OutlineFormat {
        match suffix {
            "dxf" => OutlineFormat::Dxf,
            "svg" => OutlineFormat::Svg,
            _ => OutlineFormat::Csv,
        }
    }

    /// Writes the outlines.
    ///
    /// # Errors
    /// `to` cannot be written.
    pub fn write(self, outlines: &[NamedOutline], to: &mut dyn Write) -> io::Result<()> {
        match self {
            OutlineFormat::Csv => table(outlines).write_csv(to),
            OutlineFormat::Dxf => write_dxf(outlines, to),
            OutlineFormat::Svg => write_svg(outlines, to),
        }
    }
}

fn table(outlines: &[NamedOutline]) -> Table<'static> {
    let mut table = Table::named("member|x [mm]|y [mm]");
    for outline in outlines {
        for point in outline.points.iter().chain(outline.points.first()) {
            let [x, y] = point.map(|x| decimal(1e3 * x));
            table.row([outline.name.to_string(), x, y]);
        }
    }
    table
}

/// Groups of code and value, a line each (DXF reference, release 12).
fn write_dxf(outlines: &[NamedOutline], to: &mut dyn Write) -> io::Result<()> {
    let [low, high] = corners(outlines);
    let mut group = |code: u32, value: &str| writeln!(to, "{code}\n{value}");
    let millimetres = |x: f64| format!("{:.9}", 1e3 * x);
    for (code, value) in [
        (0, "SECTION"),
        (2, "HEADER"),
        (9, "$ACADVER"),
        (1, "AC1009"),
    ] {
        group(code, value)?;
    }
    for (name, corner) in [("$EXTMIN", low), ("$EXTMAX", high)] {
        group(9, name)?;
        group(10, &millimetres(corner[0]))?;
        group(20, &millimetres(corner[1]))?;
    }
    // Lengths in millimetres.
    for (code, value) in [
        (9, "$INSUNITS"),
        (70, "4"),
        (9, "$MEASUREMENT"),
        (70, "1"),
        (0, "ENDSEC"),
    ] {
        group(code, value)?;
    }
    for (code, value) in [(0, "SECTION"), (2, "TABLES"), (0, "TABLE"), (2, "LAYER")] {
        group(code, value)?;
    }
    group(70, &outlines.len().to_string())?;
    for (k, outline) in outlines.iter().enumerate() {
        group(0, "LAYER")?;
        group(2, outline.name)?;
        group(70, "0")?;
        // Colours 5 (blue) and 30 (orange), as in the figures.
        group(62, if k == 0 { "5" } else { "30" })?;
        group(6, "CONTINUOUS")?;
    }
    for (code, value) in [
        (0, "ENDTAB"),
        (0, "ENDSEC"),
        (0, "SECTION"),
        (2, "ENTITIES"),
    ] {
        group(code, value)?;
    }
    for outline in outlines {
        // 66: vertices follow; 70: closed.
        for (code, value) in [(0, "POLYLINE"), (8, outline.name), (66, "1"), (70, "1")] {
            group(code, value)?;
        }
        for [x, y] in &outline.points {
            group(0, "VERTEX")?;
            group(8, outline.name)?;
            group(10, &millimetres(*x))?;
            group(20, &millimetres(*y))?;
        }
        group(0, "SEQEND")?;
        group(8, outline.name)?;
    }
    group(0, "ENDSEC")?;
    group(0, "EOF")
}

/// Frame of the drawing, mm on each side.
const MARGIN: f64 = 2.0;

fn write_svg(outlines: &[NamedOutline], to: &mut dyn Write) -> io::Result<()> {
    let [low, high] = corners(outlines).map(|corner| corner.map(|x| 1e3 * x));
    let [width, height] = [0, 1].map(|k| high[k] - low[k] + 2.0 * MARGIN);
    // y points up in the outlines, down in SVG.
    let [left, top] = [low[0] - MARGIN, -high[1] - MARGIN];
    writeln!(
        to,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width:.6}mm\" height=\"{height:.6}mm\" viewBox=\"{left:.6} {top:.6} {width:.6} {height:.6}\">"
    )?;
    for (outline, ink) in outlines.iter().zip(["#005aa0", "#d06a00"]) {
        write!(
            to,
            "<path id=\"{}\" fill=\"none\" stroke=\"{ink}\" stroke-width=\"0.1\" d=\"",
            outline.name
        )?;
        for (k, [x, y]) in outline.points.iter().enumerate() {
            let word = if k == 0 { "M" } else { "L" };
            write!(to, "{word}{:.6},{:.6}", 1e3 * x, -1e3 * y)?;
        }
        writeln!(to, "Z\"/>")?;
    }
    writeln!(to, "</svg>")
}

/// Least and greatest coordinates, m.
fn corners(outlines: &[NamedOutline]) -> [[f64; 2]; 2] {
    let points = || outlines.iter().flat_map(|outline| &outline.points);
    let extreme = |k: usize, start: f64, pick: fn(f64, f64) -> f64| {
        points().map(|point| point[k]).fold(start, pick)
    };
    [
        [0, 1].map(|k| extreme(k, f64::INFINITY, f64::min)),
        [0, 1].map(|k| extreme(k, f64::NEG_INFINITY, f64::max)),
    ]
}
