//! Figures of gears of a varying ratio: centrodes with teeth, ratio over the angle of the pinion.

use super::figure::{Axis, PlotColumn};
use super::outline_file::NamedOutline;
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LineStyle, ORANGE, Point2, TITLE_SIZE, WIDTH,
    render_svg,
};
use crate::gear::plane::centrodes::{Centrodes, Member};
use crate::gear::plane::rolling::Centrode;

/// Greatest height of the drawing, points.
const HEIGHT: f64 = 640.0;
/// Space above the drawing, and around it, points.
const TOP: f64 = 56.0;
/// See [`TOP`].
const MARGIN: f64 = 24.0;
/// Longest bar of length, points.
const BAR: f64 = 120.0;
/// Points of a centrode.
const POINTS: usize = 720;

/// Draws both centrodes at φ₁ = 0, with the outlines or flanks where there are any.
pub fn draw_centrodes(
    title: &str,
    pair: &Centrodes,
    outlines: &[NamedOutline],
    flanks: &[Vec<Vec<[f64; 2]>>; 2],
) -> String {
    let curves = [Member::First, Member::Second].map(|member| centrode(pair, member));
    let all = || {
        let points = outlines.iter().flat_map(|outline| &outline.points);
        let points = points.chain(flanks.iter().flatten().flatten());
        curves.iter().flatten().chain(points)
    };
    let extreme = |k: usize, start: f64, pick: fn(f64, f64) -> f64| {
        all().map(|point| point[k]).fold(start, pick)
    };
    let low = [0, 1].map(|k| extreme(k, f64::INFINITY, f64::min));
    let high = [0, 1].map(|k| extreme(k, f64::NEG_INFINITY, f64::max));
    let size = [0, 1].map(|k| (high[k] - low[k]).max(f64::MIN_POSITIVE));
    let scale = ((WIDTH - 2.0 * MARGIN) / size[0]).min(HEIGHT / size[1]);
    let place = |[x, y]: [f64; 2]| -> Point2 {
        (
            MARGIN + scale * (x - low[0]) + 0.5 * (WIDTH - 2.0 * MARGIN - scale * size[0]),
            TOP + scale * (high[1] - y),
        )
    };
    render_svg(WIDTH, TOP + scale * size[1] + MARGIN, |canvas| {
        canvas.text(title, (MARGIN, 18.0), TITLE_SIZE, BLACK, Anchor::Start);
        canvas.length_bar(scale, BAR / scale, (WIDTH - MARGIN, 18.0));
        let mut right = MARGIN;
        for (name, ink) in [("pinion", BLUE), ("gear", ORANGE)] {
            right = canvas.key_entry((right, 36.0), name, ink, 1.2) + 16.0;
        }
        let closed = |canvas: &mut Canvas, points: &[[f64; 2]], ink: Colour, width: f64, line| {
            let line_points: Vec<Point2> = points
                .iter()
                .chain(points.first())
                .map(|p| place(*p))
                .collect();
            canvas.polyline(&line_points, ink, width, line);
        };
        for (of_member, ink) in flanks.iter().zip([BLUE, ORANGE]) {
            for flank in of_member {
                let line: Vec<Point2> = flank.iter().map(|p| place(*p)).collect();
                canvas.polyline(&line, ink, 2.0, LineStyle::Solid);
            }
        }
        let has_teeth = !outlines.is_empty() || flanks.iter().any(|flanks| !flanks.is_empty());
        if has_teeth {
            let place = (WIDTH - MARGIN, 36.0);
            canvas.text("centrodes dotted", place, 10.0, GREY, Anchor::End);
        }
        for (curve, ink) in curves.iter().zip([BLUE, ORANGE]) {
            let line: Vec<Point2> = curve.iter().map(|p| place(*p)).collect();
            let style = match has_teeth {
                true => LineStyle::Dotted,
                false => LineStyle::Solid,
            };
            canvas.polyline(
                &line,
                if outlines.is_empty() { ink } else { GREY },
                0.8,
                style,
            );
        }
        for (outline, ink) in outlines.iter().zip([BLUE, ORANGE]) {
            closed(canvas, &outline.points, ink, 1.0, LineStyle::Solid);
        }
        for member in [Member::First, Member::Second] {
            if let Some(x) = pair.mate_axis(member) {
                canvas.fill_circle(place([x, 0.0]), 2.5, BLACK);
            }
        }
    })
}

/// The centrode of a body at φ₁ = 0 in the fixed frame; all of it where it closes.
fn centrode(pair: &Centrodes, member: Member) -> Vec<[f64; 2]> {
    let Some(state) = pair.at(pair.period()[0].max(0.0)) else {
        return Vec::new();
    };
    let (origin, angle) = pair.pose(member, &state);
    let body = Centrode::Member {
        pair: pair.clone(),
        member,
    };
    let length = pair.closed_arc(member).unwrap_or(pair.arc_of_period());
    let at = |i: usize| {
        let point = body.at(length * i as f64 / POINTS as f64)?.point;
        let placed = origin + point * crate::numeric::Complex::cis(angle);
        Some([placed.re, placed.im])
    };
    (0..=POINTS).filter_map(at).collect()
}

/// The ratio over the angle of the pinion, deg.
pub fn ratio(title: &str, rows: impl Iterator<Item = (f64, f64)>) -> PlotColumn {
    let (angles, ratios): (Vec<f64>, Vec<f64>) = rows.unzip();
    let axes = (
        Axis::linear("pinion angle φ₁, deg"),
        Axis::linear("ratio ω₁/ω₂").from_zero(ratios.iter().copied()),
    );
    PlotColumn::of_lines(title, axes, [("ratio".to_string(), angles, ratios)])
}
