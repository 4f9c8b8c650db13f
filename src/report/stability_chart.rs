//! Chart of unstable speeds over a second parameter.

use std::f64::consts::TAU;

use super::axes::draw_frame;
use super::svg::{Anchor, Colour, ORANGE, Panel, WIDTH, lighten, render_svg, ticks};
use crate::motion::floquet::stability_chart::InstabilityTongue;
use crate::study::parametric::StabilityChart;

const MARGIN_LEFT: f64 = 70.0;
const MARGIN_TOP: f64 = 56.0;
const HEIGHT: f64 = 460.0;

/// Unstable speeds over the second parameter; the colour is growth per period.
pub fn draw_stability_chart(title: &str, chart: &StabilityChart, speed: f64) -> String {
    const MARGIN_RIGHT: f64 = 96.0;
    let rpm = |factor: f64| factor * speed * 60.0 / TAU;
    let (Some(first), Some(last)) = (chart.rows.first(), chart.rows.last()) else {
        return render_svg(WIDTH, MARGIN_TOP, |_| {});
    };
    let half = 0.5 * (last.factor - first.factor) / (chart.rows.len().max(2) - 1) as f64;
    let grown = |t: &InstabilityTongue| (t.growth - 1.0).log10();
    let all = || chart.rows.iter().flat_map(|r| &r.tongues);
    let high = all().map(grown).fold(f64::NEG_INFINITY, f64::max);
    let scale = (high - SHADES as f64, high);
    render_svg(WIDTH, MARGIN_TOP + HEIGHT + 52.0, |canvas| {
        canvas.title(title, MARGIN_LEFT);
        let panel = Panel::new(
            (MARGIN_LEFT, WIDTH - MARGIN_RIGHT),
            (MARGIN_TOP, MARGIN_TOP + HEIGHT),
            (rpm(chart.span[0]), rpm(chart.span[1])),
            (first.factor - half, last.factor + half),
        );
        for row in &chart.rows {
            for t in &row.tongues {
                let shade = ((high - grown(t)) as usize).min(SHADES - 1);
                let low = (
                    panel.canvas_x(rpm(t.from / chart.base)),
                    panel.canvas_y(row.factor - half),
                );
                let top = (
                    panel.canvas_x(rpm(t.to / chart.base)),
                    panel.canvas_y(row.factor + half),
                );
                canvas.fill_rect(low, top, shaded(shade));
            }
        }
        panel.draw_y_grid(canvas, &ticks(panel.y, 8));
        let over = chart.parameter.map_or("", |p| p.name());
        draw_frame(
            &panel,
            canvas,
            &format!("{over}, times the scene's"),
            Some("speed, rpm"),
        );
        // Every tongue is named once, where it is widest.
        let mut named: Vec<&str> = Vec::new();
        for t in all() {
            if named.contains(&t.name.as_str()) {
                continue;
            }
            named.push(&t.name);
            let widest = all()
                .filter(|other| other.name == t.name)
                .fold(t, |a, b| if b.to - b.from > a.to - a.from { b } else { a });
            let at = panel.canvas_x(rpm(0.5 * (widest.from + widest.to) / chart.base));
            canvas.label(&t.name, (at, MARGIN_TOP - 8.0), Anchor::Middle);
        }
        canvas.label(
            "growth",
            (WIDTH - MARGIN_RIGHT + 14.0, MARGIN_TOP - 8.0),
            Anchor::Start,
        );
        for shade in 0..SHADES {
            let down = MARGIN_TOP + 8.0 + 22.0 * shade as f64;
            let left = WIDTH - MARGIN_RIGHT + 14.0;
            canvas.fill_rect((left, down + 14.0), (left + 14.0, down), shaded(shade));
            let per_cent = 100.0 * 10f64.powf(scale.1 - shade as f64);
            let text = format!("{} %", super::svg::significant(per_cent, 2));
            canvas.label(&text, (left + 20.0, down + 7.0), Anchor::Start);
        }
    })
}

/// Decades of growth distinguished.
const SHADES: usize = 4;

fn shaded(shade: usize) -> Colour {
    (0..shade).fold(ORANGE, |ink, _| lighten(ink))
}
