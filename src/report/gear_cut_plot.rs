//! Figures of a cut: maps of the deviations over the flanks, profiles with their scallops, shares of the blades.

use super::figure::{Axis, Curve, Ink, Mark, Plot, PlotColumn};
use super::heatmap::{colour_step, draw_colour_bar, ink};
use super::svg::{Anchor, BLACK, Canvas, Panel, WIDTH, render_svg};
use crate::gear::bevel::tooth::SIDES;
use crate::numeric::statistics::extremes;
use crate::plan::gear::cut_flank::{CauseResult, CutFlankResult};
use crate::plan::gear_limits::MEMBERS;

/// Width of a map from its left edge, points.
const ACROSS: (f64, f64) = (60.0, 780.0);
/// Height of a map and the space above it, points.
const MAP: [f64; 2] = [170.0, 40.0];
/// Space of the title, points.
const TOP: f64 = 34.0;
/// Cells reach under those drawn after them, so that no paper shines through.
const OVERLAP: f64 = 0.6;

/// Name of a flank: member and side.
pub fn flank_name(flank: &CutFlankResult) -> String {
    format!("{} {}", MEMBERS[flank.member], SIDES[flank.side])
}

/// Deviations over a flank, row by row from the root, toe first.
pub struct FlankMap<'a> {
    /// Name of the flank and of what deviates it.
    pub name: String,
    /// Rows and columns of nodes.
    pub size: [usize; 2],
    /// Deviations at the nodes, m.
    pub deviations: &'a [Option<f64>],
}

/// Draws every flank with all causes.
pub fn draw_flanks(title: &str, flanks: &[CutFlankResult]) -> String {
    let maps = flanks
        .iter()
        .filter_map(|flank| Some(cause_map(flank, flank.causes.last()?)));
    draw_maps(title, &maps.collect::<Vec<_>>())
}

/// Draws a flank for each of its causes.
pub fn draw_causes(title: &str, flank: &CutFlankResult) -> String {
    let maps = flank.causes.iter().map(|cause| cause_map(flank, cause));
    draw_maps(title, &maps.collect::<Vec<_>>())
}

fn cause_map<'a>(flank: &CutFlankResult, cause: &'a CauseResult) -> FlankMap<'a> {
    FlankMap {
        name: format!("{}, {}", flank_name(flank), cause.name),
        size: [flank.grid.rows, flank.grid.columns],
        deviations: &cause.map.deviations,
    }
}

/// Draws maps one below the other, toe left and root below, each with its own scale.
pub fn draw_maps(title: &str, maps: &[FlankMap]) -> String {
    let [height, above] = MAP;
    let total = TOP + maps.len() as f64 * (height + above) + 24.0;
    render_svg(WIDTH, total, |canvas| {
        canvas.title(title, 30.0);
        for (k, map) in maps.iter().enumerate() {
            let top = TOP + k as f64 * (height + above) + above;
            draw_map(canvas, top, map);
        }
    })
}

fn draw_map(canvas: &mut Canvas, top: f64, map: &FlankMap) {
    let down = (top, top + MAP[0]);
    let name = format!("{}: toe left, heel right, root below", map.name);
    canvas.note(&name, (ACROSS.0, top - 10.0), Anchor::Start);
    let (low, high) = extremes(map.deviations.iter().flatten().copied());
    if low > high {
        return;
    }
    let (unit, times) = match high.max(-low) < 1e-6 {
        true => ("nm", 1e9),
        false => ("µm", 1e6),
    };
    let (low, high) = (times * low, times * high);
    let scale = (low, high.max(low + 1e-9 * times));
    let [rows, columns] = map.size;
    let panel = Panel::new(ACROSS, down, (0.0, columns as f64), (0.0, rows as f64));
    for (k, deviation) in map.deviations.iter().enumerate() {
        let Some(deviation) = deviation else {
            continue;
        };
        let (row, column) = ((k / columns) as f64, (k % columns) as f64);
        let one = panel.to_canvas(column, row);
        let other = panel.to_canvas(column + 1.0, row + 1.0);
        let corner = (
            (other.0 + OVERLAP).min(ACROSS.1),
            (other.1 - OVERLAP).max(down.0),
        );
        canvas.fill_rect(one, corner, ink(colour_step(times * deviation, scale)));
    }
    canvas.stroke_rect((ACROSS.0, down.0), (ACROSS.1, down.1), BLACK, 0.8);
    draw_colour_bar(canvas, (ACROSS.1, down), scale, unit);
}

/// Profiles from root to tip at the middle of the face.
pub fn profiles(title: &str, flanks: &[CutFlankResult]) -> PlotColumn {
    let names = ["regular blades", "all causes"];
    let plot = |flank: &CutFlankResult| {
        let places: Vec<f64> = flank.profile.distances.iter().map(|x| 1e3 * x).collect();
        let count = flank.causes.len().min(2);
        let curves = (0..count).rev().map(|k| {
            let y = flank.profile.curves[k].iter();
            let y = y.map(|d| d.map_or(f64::NAN, |d| 1e6 * d)).collect();
            Curve::line(names[k], Ink::Series(k), places.clone(), y)
        });
        Plot {
            curves: curves.collect(),
            height: PROFILE_HEIGHT,
            heading: format!("{}, middle of the face", flank_name(flank)),
            ..Plot::new(
                Axis::linear("distance from the root, mm"),
                Axis::linear("deviation, µm"),
            )
        }
    };
    PlotColumn {
        title: title.into(),
        plots: flanks.iter().map(plot).collect(),
        ..PlotColumn::default()
    }
}

/// Height of a profile, points.
const PROFILE_HEIGHT: f64 = 240.0;

/// Shares of the flanks that each blade finishes with all causes.
pub fn blade_shares(title: &str, flanks: &[CutFlankResult]) -> PlotColumn {
    let plot = |flank: &CutFlankResult| {
        let shares = flank
            .causes
            .last()
            .map_or(&[][..], |cause| &cause.blade_shares);
        let numbers = (1..=shares.len()).map(|k| k as f64).collect();
        let percent: Vec<f64> = shares.iter().map(|share| 100.0 * share).collect();
        let most = percent.iter().copied().fold(0.0, f64::max);
        Plot {
            curves: vec![Curve::new(
                "",
                Ink::Series(0),
                Mark::Stems,
                numbers,
                percent,
            )],
            height: PROFILE_HEIGHT,
            heading: flank_name(flank),
            ..Plot::new(
                Axis::linear("blade").over(0.0, shares.len() as f64 + 1.0),
                Axis::linear("share of the flank, %").over(0.0, 1.1 * most),
            )
        }
    };
    PlotColumn {
        title: title.into(),
        plots: flanks.iter().map(plot).collect(),
        ..PlotColumn::default()
    }
}
