//! Gear charts in polar form: runout, cumulative pitch, composite records.

use std::f64::consts::TAU;

use super::svg::{
    Anchor, BLACK, BLUE, Canvas, LIGHT_GREY, LineStyle, Point2, WIDTH, lighten, render_svg, ticks,
};
use crate::numeric::statistics::extremes;
use crate::plan::measure::charts::ChartPlot;

/// Side of the square a chart has, three in a row.
const SIDE: f64 = WIDTH / 3.0;
/// Radii between which values lie.
const RADII: (f64, f64) = (46.0, 104.0);

/// One closed curve and its slow part, µm.
struct PolarCurve {
    title: String,
    values: Vec<f64>,
    slow: Vec<f64>,
}

/// Everything that goes round, three in a row; `None` where nothing does.
pub fn draw_polar(title: &str, plots: &[ChartPlot]) -> Option<String> {
    let rounds: Vec<PolarCurve> = plots.iter().filter_map(round).collect();
    let rows = rounds.len().div_ceil(3);
    (!rounds.is_empty()).then(|| {
        render_svg(WIDTH, rows as f64 * SIDE + 30.0, |canvas| {
            canvas.title(title, 16.0);
            for (i, round) in rounds.iter().enumerate() {
                let (row, column) = (i / 3, i % 3);
                let centre = (
                    (column as f64 + 0.5) * SIDE,
                    30.0 + (row as f64 + 0.5) * SIDE + 10.0,
                );
                draw(canvas, round, centre);
            }
        })
    })
}

fn round(plots: &ChartPlot) -> Option<PolarCurve> {
    let micro = |values: &[f64]| values.iter().map(|x| 1e6 * x).collect();
    let of = |title: String, values: &[f64], slow: &[f64]| PolarCurve {
        title,
        values: micro(values),
        slow: micro(slow),
    };
    Some(match plots {
        ChartPlot::Runout {
            method_text: found,
            runout,
        } => of(
            format!("run-out {found}"),
            &runout.readings,
            &runout.first_order(),
        ),
        ChartPlot::Pitch { side, pitches } => of(
            format!("places of {} flanks", side.name()),
            &pitches.flank_positions(),
            &[],
        ),
        ChartPlot::Record {
            is_double,
            predicted: false,
            turns: 1,
            values,
            long,
            side,
        } => match is_double {
            true => of("double-flank".to_string(), values, long),
            false => of(format!("single-flank {}", side.name()), values, long),
        },
        _ => return None,
    })
}

fn draw(canvas: &mut Canvas, round: &PolarCurve, centre: Point2) {
    let (low, high) = extremes(round.values.iter().copied());
    let high = if high > low { high } else { low + 1.0 };
    let radius = |x: f64| RADII.0 + (RADII.1 - RADII.0) * (x - low) / (high - low);
    let at = |turn: f64, r: f64| {
        // From the top, clockwise, as teeth are counted.
        let angle = TAU * turn;
        (centre.0 + r * angle.sin(), centre.1 - r * angle.cos())
    };
    for tick in ticks((low, high), 3) {
        canvas.stroke_circle(centre, radius(tick), LIGHT_GREY, 0.8);
        let (x, y) = at(0.0, radius(tick));
        let text = super::number_format::four_digits((tick * 1e6).round() / 1e6).replace('-', "−");
        canvas.label(&text, (x + 3.0, y), Anchor::Start);
    }
    for quarter in 0..4 {
        let turn = f64::from(quarter) / 4.0;
        canvas.line(centre, at(turn, RADII.1), LIGHT_GREY, 0.6);
        let (x, y) = at(turn, RADII.1 + 16.0);
        let degrees = format!("{}°", 90 * quarter);
        canvas.label(&degrees, (x, y), Anchor::Middle);
    }
    let n = round.values.len();
    let closed = |values: &[f64]| -> Vec<Point2> {
        let spot = |(i, x): (usize, &f64)| at(i as f64 / n as f64, radius(*x));
        values
            .iter()
            .chain(values.first())
            .enumerate()
            .map(spot)
            .collect()
    };
    if !round.slow.is_empty() {
        canvas.polyline(&closed(&round.slow), lighten(BLUE), 2.4, LineStyle::Solid);
    }
    let few = n <= 400;
    let curve = closed(&round.values);
    canvas.polyline(&curve, BLACK, if few { 1.1 } else { 0.7 }, LineStyle::Solid);
    if few {
        curve
            .iter()
            .for_each(|&spot| canvas.fill_circle(spot, 1.6, BLACK));
    }
    let slow = match (round.slow.is_empty(), few) {
        (true, _) => "",
        (_, true) => "; pale: eccentricity",
        (_, false) => "; pale: orders below z/2",
    };
    let range = format!("range {:.2} µm{slow}", high - low);
    let top = centre.1 - SIDE / 2.0;
    let below = |by: f64| (centre.0, top + by);
    canvas.label(&round.title, below(2.0), Anchor::Middle);
    canvas.note(&range, below(16.0), Anchor::Middle);
}
