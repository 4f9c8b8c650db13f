//! Nodes of a measured grid on the nominal flanks: measured flanks, points and normals of the nodes, signed normal deviations.

use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::gear::bevel::flank::BevelFlank;
use crate::gear::bevel::tooth::SIDES;
use crate::gear::cut::measured_flank::{FlankNode, MeasuredFlank};
use crate::gear::cut::outliers::outliers;
use crate::gear::cut::setting::FlankSetup;
use crate::numeric::statistics::peak_to_peak;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::BevelFile;
use crate::scene::correction_study::CorrectionStudy;
use crate::scene::measured_grid::{GridNode, MeasuredGrid};

/// Indices of the measured flanks.
pub(super) fn sides(
    file: &BevelFile,
    study: &CorrectionStudy,
    grid: &MeasuredGrid,
) -> Result<Vec<usize>, Error> {
    let member = study.member.index();
    let gear = &file.members[member];
    let has_nodes = |side: &usize| grid.nodes.iter().any(|node| node.side == Some(*side));
    let has_settings = |side: &usize| gear.flanks[*side].is_some();
    let sides: Vec<usize> = match (study.flank, grid.nodes[0].side) {
        (Some(flank), None) => vec![flank.index()],
        (Some(flank), Some(_)) => [flank.index()].into_iter().filter(has_nodes).collect(),
        (None, Some(_)) => [0, 1].into_iter().filter(has_nodes).collect(),
        (None, None) => [0, 1].into_iter().filter(has_settings).collect(),
    };
    if study.flank.is_none() && grid.nodes[0].side.is_none() && sides.len() == 2 {
        let message = format!(
            "the {} has two flanks and the grid does not name them",
            MEMBERS[member]
        );
        return Err(Error::new(Code::MissingKey, message)
            .with_span(&grid.nodes[0].span)
            .with_hint("give --flank concave or convex, or a column `flank` in the grid"));
    }
    if sides.is_empty() {
        let message = "the grid has no node of the requested flank";
        return Err(Error::new(Code::Conflict, message)
            .with_span(&grid.nodes[0].span)
            .with_hint("omit --flank, or correct the column `flank`"));
    }
    match sides.iter().find(|side| !has_settings(side)) {
        None => Ok(sides),
        Some(side) => {
            let message = format!(
                "the {} flank of the {} is measured, but the file has no settings for it",
                SIDES[*side], MEMBERS[member]
            );
            Err(Error::new(Code::MissingKey, message)
                .with_span(&gear.span)
                .with_hint("describe the flank, or name the measured member by --member"))
        }
    }
}

/// Maximum difference of the nominal unit normals of grid and flank, in axial and radial components.
const MAX_NORMAL_DIFFERENCE: f64 = 0.1;

/// Maximum share of the nodes off the flank; a larger share indicates the grid of another gear.
const MAX_OFF_FLANK: f64 = 0.25;

/// Locates the grid points on the nominal flank and collects their normal deviations, positive out of the metal; points off the flank are
/// omitted with a warning.
pub(super) fn measured_flank(
    file: &BevelFile,
    (member, side): (usize, usize),
    grid: &MeasuredGrid,
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<MeasuredFlank, Error> {
    let gear = &file.members[member];
    let name = format!("{} flank of the {}", SIDES[side], MEMBERS[member]);
    let missing = || {
        Error::new(
            Code::OutOfRange,
            format!("the cutter of the {name} does not reach the middle of its tooth"),
        )
        .with_span(&gear.span)
        .with_hint("check the settings with `geardyn gear`")
    };
    let flank = file.flank(member, side).ok_or_else(missing)?;
    let cut = gear.flanks[side].as_ref().ok_or_else(missing)?;
    let middle = flank.middle().ok_or_else(missing)?;
    let rows: Vec<&GridNode> = (grid.nodes.iter())
        .filter(|node| node.side.is_none_or(|s| s == side))
        .collect();
    let (mut nodes, mut deviations, mut off_flank) = (Vec::new(), Vec::new(), None);
    let mut on_flank = Vec::new();
    for row in &rows {
        check_size(row, flank.section.depth())?;
        let Some(node) = FlankNode::of(&flank, row.place, middle) else {
            off_flank = off_flank.or(Some(*row));
            continue;
        };
        deviations.push(row.deviation * deviation_sign(row, &node, &name)?);
        nodes.push(node);
        on_flank.push(*row);
    }
    let shares: Vec<[f64; 2]> = nodes.iter().map(|node| node.shares).collect();
    diagnostics.extend(narrow_grid(&shares, &name));
    for (k, departure) in outliers(&shares, &deviations) {
        diagnostics.push(Diagnostic {
            code: "outlier",
            message: format!(
                "line {}: a deviation of {:.1} µm departs by {:.1} µm from those around it on the {name}",
                on_flank[k].span.line(),
                1e6 * on_flank[k].deviation,
                1e6 * departure.abs()
            ),
            hint: Some("clean the flank and measure the node again, or omit it".into()),
        });
    }
    if let Some(row) = off_flank {
        let count = rows.len() - nodes.len();
        let location = location_text(&flank, row);
        let line = row.span.line();
        if count as f64 > MAX_OFF_FLANK * rows.len() as f64 {
            let message = format!(
                "{} of {} are not on the {name} (limit {:.0} %): the first {location}",
                count,
                pluralise(rows.len(), "node"),
                100.0 * MAX_OFF_FLANK
            );
            return Err(Error::new(Code::OutOfRange, message)
                .with_span(&row.span)
                .with_hint("the grid may be that of another gear; z is counted along the axis from the apex to the heel; check units, --member and --flank"));
        }
        diagnostics.push(Diagnostic {
            code: "nodes-off-flank",
            message: format!(
                "{} left out: outside the flank (line {line}: {location})",
                pluralise(count, "node")
            ),
            hint: Some("measure above the fillet and within the blank".into()),
        });
    }
    Ok(MeasuredFlank {
        setup: FlankSetup {
            cutter: cut.cutter,
            machine: cut.settings,
        },
        hand: file.hand_of(member),
        section: gear.section,
        nodes,
        deviations,
        roots: Vec::new(),
    })
}

/// Maximum deviation relative to the tooth depth; a larger one indicates a wrong unit.
const MAX_DEVIATION: f64 = 0.1;

/// Checks a deviation against the tooth depth.
fn check_size(row: &GridNode, depth: f64) -> Result<(), Error> {
    if row.deviation.abs() <= MAX_DEVIATION * depth {
        return Ok(());
    }
    let message = format!(
        "a deviation of {:.3} mm on a tooth {:.3} mm deep: more than {:.0} % of it",
        1e3 * row.deviation,
        1e3 * depth,
        100.0 * MAX_DEVIATION
    );
    Err(Error::new(Code::OutOfRange, message)
        .with_span(&row.span)
        .with_hint("check the unit in the head of the column, as in `deviation [µm]`"))
}

/// Minimum span of the nodes, relative to face width or tooth height, that determines deviations along it.
const MIN_SPAN: f64 = 0.25;

/// Warning of a grid that spans too little of the face width or of the tooth height.
fn narrow_grid(shares: &[[f64; 2]], name: &str) -> Option<Diagnostic> {
    let span = |k: usize| peak_to_peak(&shares.iter().map(|s| s[k]).collect::<Vec<_>>());
    let (direction, span) = [("face", span(0)), ("height", span(1))]
        .into_iter()
        .find(|(_, span)| *span < MIN_SPAN)?;
    Some(Diagnostic {
        code: "narrow-grid",
        message: format!(
            "the nodes span {:.0} % of the {direction} of the {name}: deviations along it are not determined, and the settings that change them only poorly",
            100.0 * span
        ),
        hint: Some("measure a grid over the whole flank, such as 5 × 9 nodes".into()),
    })
}

/// Position of a node off the flank, as text.
fn location_text(flank: &BevelFlank, row: &GridNode) -> String {
    let [z, radius] = row.place.map(|x| 1e3 * x);
    let position = format!("lies at z {z:.3} mm, radius {radius:.3} mm");
    match flank.section.shares(row.place) {
        Some([face, height]) => format!(
            "{position}, {:.0} % of the face from the toe and {:.0} % of the height from the root",
            100.0 * face,
            100.0 * height
        ),
        None => position,
    }
}

/// Sign of a deviation: −1 for a deviation along a normal into the metal, else 1.
fn deviation_sign(row: &GridNode, node: &FlankNode, name: &str) -> Result<f64, Error> {
    let Some(nominal) = row.normal else {
        return Ok(1.0);
    };
    let (r, n) = (node.point.coordinates, node.normal.components);
    let flank = [n.z, (n.x * r.x + n.y * r.y) / row.place[1]];
    let error = |sign: f64| f64::hypot(nominal[0] - sign * flank[0], nominal[1] - sign * flank[1]);
    let sign = if error(1.0) <= error(-1.0) { 1.0 } else { -1.0 };
    if error(sign) > MAX_NORMAL_DIFFERENCE {
        let message = format!(
            "the nominal normal is not that of the {name}: axial {:.3} and radial {:.3}, the flank has {:.3} and {:.3}",
            nominal[0],
            nominal[1],
            sign * flank[0],
            sign * flank[1]
        );
        return Err(Error::new(Code::Conflict, message)
            .with_span(&row.span)
            .with_hint("check --member and --flank, and that z points from the apex to the heel"));
    }
    Ok(if row.is_along_normal { sign } else { 1.0 })
}
