//! Figure of the flanks of a bevel pair in axial section with their contact lines and the limits that cross them.

use super::bevel_plot::{Flat, MARGIN, Scale, TOP, key};
use super::svg::{Anchor, BLACK, BLUE, Canvas, GREY, LineStyle, ORANGE, Point2, WIDTH, render_svg};
use crate::gear::bevel::flank_lines::ContactLines;
use crate::gear::bevel::tooth::SIDES;
use crate::gear::bevel::zero_curves::SharesLine;
use crate::plan::gear::bevel_member::{FlankResult, MemberResult};
use crate::plan::gear_limits::MEMBERS;

/// Greatest height of a flank, points.
const HEIGHT: f64 = 180.0;
/// Space above a flank for its name, points.
const NAME: f64 = 34.0;
/// Space between the flanks of a gear, points.
const GAP: f64 = 36.0;

/// Draws the flanks that a file describes: gears one below the other, concave and convex side by side; none where it describes none.
pub fn draw_flanks(title: &str, members: &[MemberResult; 2]) -> Option<String> {
    let rows = members
        .each_ref()
        .map(|m| m.flanks.each_ref().map(Option::as_ref));
    let all = || rows.iter().flatten().flatten();
    all().next()?;
    let width = 0.5 * (WIDTH - 2.0 * MARGIN - GAP);
    let scale = |of: &FlankResult| {
        let corners = Flat::of(&of.flank.section).corners();
        Scale::of(corners.iter(), width, HEIGHT)
    };
    let heights = rows.each_ref().map(|row| {
        let heights = row.iter().flatten().map(|of| NAME + scale(of).height());
        heights.fold(0.0, f64::max)
    });
    let mut entries = vec![("contact lines", BLUE)];
    let limits = [("limit of undercut", ORANGE), ("end of contact", BLACK)];
    for (k, entry) in limits.into_iter().enumerate() {
        entries.extend(
            all()
                .any(|of| !of.limits.curves[k].is_empty())
                .then_some(entry),
        );
    }
    let height = TOP + heights.iter().sum::<f64>() + MARGIN;
    Some(render_svg(WIDTH, height, |canvas| {
        canvas.title(title, MARGIN);
        key(canvas, &entries);
        let mut top = TOP;
        for (member, row) in rows.iter().enumerate() {
            for (side, of) in row.iter().enumerate() {
                let Some(of) = of else { continue };
                let left = side as f64 * (width + GAP);
                let name = format!("{} {}: toe left, root below", MEMBERS[member], SIDES[side]);
                let flat = Flat::of(&of.flank.section);
                let scale = scale(of);
                let at = |shares: [f64; 2]| {
                    let (x, y) = scale.at(flat.at(shares), top + NAME);
                    (x + left, y)
                };
                draw_flank(canvas, of, &name, (MARGIN + left, top + NAME - 12.0), at);
            }
            top += heights[member];
        }
    }))
}

/// One flank with its name.
fn draw_flank(
    canvas: &mut Canvas,
    of: &FlankResult,
    name: &str,
    spot: Point2,
    at: impl Fn([f64; 2]) -> Point2,
) {
    let mut draw = |line: &SharesLine, ink, width, style| {
        let line: Vec<Point2> = line.iter().map(|p| at(*p)).collect();
        canvas.polyline(&line, ink, width, style);
    };
    let frame = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
    draw(&frame.to_vec(), GREY, 1.0, LineStyle::Solid);
    let contact = ContactLines::of(&of.flank, &of.grid);
    for line in contact.iter().flat_map(|c| &c.lines) {
        draw(line, BLUE, 0.9, LineStyle::Solid);
    }
    let [undercut, second] = &of.limits.curves;
    for line in undercut {
        draw(line, ORANGE, 2.0, LineStyle::Solid);
    }
    for line in second {
        draw(line, BLACK, 2.0, LineStyle::Solid);
    }
    let lines = match contact {
        Some(contact) => format!("a line every {:.2}° of roll", contact.step.to_degrees()),
        None => "formate: the surface of the cutter".into(),
    };
    canvas.note(&format!("{name}; {lines}"), spot, Anchor::Start);
}
