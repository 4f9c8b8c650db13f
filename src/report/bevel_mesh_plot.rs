//! Figures of a bevel pair under load: transmission error over the pitch, pattern, load sharing, Harris map.

use super::bevel_plot::{Flat, MARGIN, PATTERN_HEIGHT, Scale, TOP, key};
use super::figure::{Axis, PlotColumn, closed};
use super::gear::ARCSEC;
use super::number_format::with_minus_signs;
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, LIGHT_GREY, LineStyle, ORANGE, WIDTH, lighten, render_svg,
};
use crate::gear::contact::pair::FlankPair;
use crate::gear::load::flank_result::{FlankMeshResult, LoadedCell};
use crate::numeric::sorting::sort_ascending;
use crate::numeric::statistics::peak_to_peak;
use crate::plan::gear_limits::MEMBERS;

/// Torques shown over the pitch.
const CURVES: usize = 4;

/// Torques shown: first, last and some between.
fn shown(mesh: &FlankMeshResult) -> impl Iterator<Item = usize> {
    let last = mesh.cycles.len().saturating_sub(1);
    let count = CURVES.min(mesh.cycles.len());
    (0..count).map(move |k| last * k / count.saturating_sub(1).max(1))
}

fn degrees(mesh: &FlankMeshResult) -> Vec<f64> {
    mesh.pinion_angles.iter().map(|a| a.to_degrees()).collect()
}

/// Transmission error less its mean over the pitch, without load and at up to four torques.
pub fn te(title: &str, mesh: &FlankMeshResult) -> PlotColumn {
    let less_mean = |te: &[f64]| -> Vec<f64> {
        let mean = te.iter().sum::<f64>() / te.len().max(1) as f64;
        te.iter().map(|e| ARCSEC * (e - mean)).collect()
    };
    let loaded = shown(mesh).map(|k| {
        let cycle = &mesh.cycles[k];
        (
            format!("{} N·m", cycle.torque),
            less_mean(&cycle.of(|p| p.te)),
        )
    });
    let unloaded = ("no load".to_string(), less_mean(&mesh.unloaded_te));
    let curves: Vec<(String, Vec<f64>)> = std::iter::once(unloaded).chain(loaded).collect();
    let values = curves.iter().flat_map(|(_, e)| e.iter().copied());
    let axes = (
        Axis::linear("pinion angle φ₁, deg"),
        Axis::linear("transmission error less its mean, arcsec").from_zero(values),
    );
    let lines = curves.into_iter().map(|(name, e)| {
        let (angles, e) = closed(degrees(mesh), e);
        (name, angles, e)
    });
    PlotColumn::of_lines(title, axes, lines)
}

/// Greatest line load over the pitch along the pinion's face at up to four torques.
pub fn lengthwise(title: &str, mesh: &FlankMeshResult) -> PlotColumn {
    let lines = shown(mesh).map(|k| {
        let cycle = &mesh.cycles[k];
        let rows = cycle.lengthwise();
        let face = rows.iter().map(|[face, _]| 100.0 * face).collect();
        let load = rows.iter().map(|[_, load]| 1e-3 * load).collect();
        (format!("{} N·m", cycle.torque), face, load)
    });
    let lines: Vec<(String, Vec<f64>, Vec<f64>)> = lines.collect();
    let loads = lines.iter().flat_map(|(_, _, load)| load.iter().copied());
    let axes = (
        Axis::linear("place along the pinion's face from toe to heel, %").over(0.0, 100.0),
        Axis::linear("greatest line load, N/mm").from_zero(loads),
    );
    PlotColumn::of_lines(title, axes, lines)
}

/// Share of each pair of teeth in the largest torque over the pitch.
pub fn sharing(title: &str, mesh: &FlankMeshResult) -> PlotColumn {
    let Some(cycle) = mesh.cycles.last() else {
        return PlotColumn::default();
    };
    let line = |pair: i32| {
        let name = with_minus_signs(&format!("pair {pair}"));
        (name, degrees(mesh), cycle.of(|p| 100.0 * p.share(pair)))
    };
    let axes = (
        Axis::linear("pinion angle φ₁, deg"),
        Axis::linear(format!("share of {} N·m, %", cycle.torque)).over(0.0, 105.0),
    );
    PlotColumn::of_lines(title, axes, mesh.pairs().into_iter().map(line))
}

/// Peak-to-peak transmission error over torque.
pub fn harris_map(title: &str, mesh: &FlankMeshResult) -> PlotColumn {
    let torques = mesh.cycles.iter().map(|c| c.torque).collect();
    let peaks: Vec<f64> = mesh
        .cycles
        .iter()
        .map(|c| ARCSEC * peak_to_peak(&c.of(|p| p.te)))
        .collect();
    let te = Axis::linear("peak-to-peak transmission error, arcsec");
    let axes = (
        Axis::linear("torque at the pinion, N·m"),
        te.from_zero(peaks.iter().copied()),
    );
    PlotColumn::of_lines(title, axes, [(String::new(), torques, peaks)])
}

/// Draws where the flanks carry the largest torque over the pitch, in axial section, by the pressure there.
pub fn draw_pattern(title: &str, pair: &FlankPair, mesh: &FlankMeshResult) -> String {
    let Some(cycle) = mesh.cycles.last() else {
        return String::new();
    };
    let places = || cycle.positions.iter().flat_map(|p| &p.places);
    let most = places()
        .filter(|p| !p.on_edge)
        .map(|p| p.pressure)
        .fold(0.0, f64::max);
    let flat = [0, 1].map(|k| Flat::of(&pair.flanks[k].section));
    let scales = [0, 1].map(|k| {
        Scale::of(
            flat[k].corners().iter(),
            WIDTH - 2.0 * MARGIN,
            PATTERN_HEIGHT,
        )
    });
    let tops = [TOP + 14.0, TOP + 60.0 + scales[0].height()];
    let name = |share: f64| format!("to {:.0} N/mm²", 1e-6 * share * most);
    let names = [name(1.0 / 3.0), name(2.0 / 3.0), name(1.0)];
    let inks = [LIGHT_GREY, lighten(BLUE), BLUE];
    render_svg(WIDTH, tops[1] + scales[1].height() + MARGIN, |canvas| {
        canvas.title(&format!("{title}: pattern at {} N·m", cycle.torque), MARGIN);
        key(
            canvas,
            &[
                (&names[0], inks[0]),
                (&names[1], inks[1]),
                (&names[2], inks[2]),
                ("on an edge", ORANGE),
            ],
        );
        for k in 0..2 {
            let section = &pair.flanks[k].section;
            let at = |shares: [f64; 2]| scales[k].at(flat[k].at(shares), tops[k]);
            let note = format!("{}: toe left, heel right, root below", MEMBERS[k]);
            canvas.note(&note, (MARGIN, tops[k] - 10.0), Anchor::Start);
            let dot = |canvas: &mut Canvas, place: &LoadedCell| {
                let Some(shares) = section.shares(place.at[k]) else {
                    return;
                };
                let third = (3.0 * place.pressure / most).floor().clamp(0.0, 2.0) as usize;
                let ink = if place.on_edge { ORANGE } else { inks[third] };
                canvas.fill_circle(at(shares), 2.2, ink);
            };
            // The most pressed places lie on top.
            let mut all: Vec<&LoadedCell> = places().collect();
            sort_ascending(&mut all, |a| a.pressure);
            all.iter().for_each(|place| dot(canvas, place));
            let frame = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]].map(at);
            canvas.polyline(&frame, BLACK, 1.0, LineStyle::Solid);
        }
    })
}
