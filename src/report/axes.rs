//! Plot axes: linear and logarithmic ranges, grids, clipping and thinning of curves.

use super::svg::{Canvas, Colour, LIGHT_GREY, LineStyle, Panel, Point2, ticks};
use crate::numeric::statistics::extremes;

/// Maximum number of decades of a logarithmic scale; smaller values are rounding errors.
const MAX_DECADES: f64 = 8.0;

/// Range of a logarithmic axis, exponents of ten, with margin; `None` without positive finite values.
pub fn log_range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let positive = values.filter(|x| *x > 0.0 && x.is_finite());
    let (low, high) = extremes(positive.map(f64::log10));
    if low > high {
        return None;
    }
    let low = low.max(high - MAX_DECADES);
    // The margin also prevents an empty range.
    let margin = (0.06 * (high - low)).max(0.1);
    Some((low - margin, high + margin))
}

/// Range of a linear axis with margin; `None` without finite values.
pub fn linear_range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (low, high) = extremes(values.filter(|x| x.is_finite()));
    if low > high {
        return None;
    }
    let margin = match high - low {
        0.0 => 0.05 * high.abs().max(1.0),
        span => 0.05 * span,
    };
    Some((low - margin, high + margin))
}

/// Grid positions (exponents of ten) and labels of a logarithmic axis over a range of exponents; with a unit, labels use its SI prefixes.
pub fn log_ticks((low, high): (f64, f64), prefixed_unit: Option<&str>) -> Vec<(f64, String)> {
    let (first, last) = (low.ceil() as i32, high.floor() as i32);
    let text = |digit: f64, decade: i32| match prefixed_unit {
        Some(unit) => with_prefix(digit * 10f64.powi(decade), unit),
        None if (-3..=4).contains(&decade) => {
            super::number_format::four_digits(digit * 10f64.powi(decade))
        }
        None => format!("{digit}e{decade}"),
    };
    if last - first < 3 {
        // A short axis has ticks at 1, 2 and 5 of each decade.
        let digits = (first - 1..=last).flat_map(|decade| [1.0, 2.0, 5.0].map(|d| (decade, d)));
        let marks = digits.map(|(decade, digit): (i32, f64)| {
            (f64::from(decade) + digit.log10(), text(digit, decade))
        });
        return marks.filter(|(at, _)| (low..=high).contains(at)).collect();
    }
    let step = ((last - first) / 8).max(1) as usize;
    let decades = (first..=last).step_by(step);
    decades
        .map(|decade| (f64::from(decade), text(1.0, decade)))
        .collect()
}

/// Formats a value with the SI prefix of its magnitude: `10 µs`.
fn with_prefix(value: f64, unit: &str) -> String {
    const PREFIXES: [(f64, &str); 5] =
        [(1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"), (0.0, "p")];
    let (size, prefix) = PREFIXES
        .into_iter()
        .find(|p| value >= p.0 * 0.9999)
        .unwrap_or(PREFIXES[0]);
    let size = if size > 0.0 { size } else { 1e-12 };
    format!("{:.0} {prefix}{unit}", value / size)
}

/// Draws the frame, the horizontal axis and the name of the vertical axis of a panel; `below` names the axis of the lowest one.
pub fn draw_frame(panel: &Panel, canvas: &mut Canvas, name: &str, below: Option<&str>) {
    let values = ticks(panel.x, 8);
    match below {
        Some(axis) => {
            panel.draw_x_grid(canvas, &values);
            panel.draw_x_name(canvas, axis, 28.0);
        }
        None => {
            for &value in &values {
                panel.draw_vertical(canvas, panel.canvas_x(value), LIGHT_GREY, 0.5);
            }
        }
    }
    panel.draw_outline(canvas);
    panel.draw_y_name(canvas, name);
}

/// Draws a curve as a line, clipped by [`clip_to_panel`].
pub fn draw_curve(
    canvas: &mut Canvas,
    panel: &Panel,
    points: impl Iterator<Item = (f64, f64)>,
    ink: Colour,
    width: f64,
) {
    for run in clip_to_panel(panel, points) {
        canvas.polyline(&run, ink, width, LineStyle::Solid);
    }
}

/// Clips a curve to a panel and converts it to canvas points, one run per connected part with finite values.
pub fn clip_to_panel(panel: &Panel, points: impl Iterator<Item = (f64, f64)>) -> Vec<Vec<Point2>> {
    let mut runs: Vec<Vec<Point2>> = vec![Vec::new()];
    let mut previous: Option<(f64, f64)> = None;
    for (x, y) in points {
        let is_shown = x >= panel.x.0 && x <= panel.x.1 && y.is_finite();
        let ends = previous
            .filter(|_| is_shown)
            .and_then(|from| clip(panel.y, from, (x, y)));
        let is_inside = (panel.y.0..=panel.y.1).contains(&y);
        let drawn = match ends {
            Some((from, to)) => {
                let starts_run = runs.last().is_none_or(Vec::is_empty);
                vec![starts_run.then_some(from), Some(to)]
            }
            None if is_shown && is_inside => vec![Some((x, y))],
            None => Vec::new(),
        };
        let drawn = drawn
            .into_iter()
            .flatten()
            .map(|(x, y)| panel.to_canvas(x, y));
        if let Some(run) = runs.last_mut() {
            run.extend(drawn);
        }
        if !(is_shown && is_inside) && runs.last().is_some_and(|run| !run.is_empty()) {
            runs.push(Vec::new());
        }
        previous = is_shown.then_some((x, y));
    }
    runs.into_iter().map(thin).collect()
}

/// Clips a line segment to a range of ordinates; `None` if it lies outside.
fn clip(
    (low, high): (f64, f64),
    from: (f64, f64),
    to: (f64, f64),
) -> Option<((f64, f64), (f64, f64))> {
    if from.1.max(to.1) < low || from.1.min(to.1) > high {
        return None;
    }
    let at = |(x, y): (f64, f64)| {
        let height = y.clamp(low, high);
        match height == y {
            true => (x, y),
            false => {
                let share = (height - from.1) / (to.1 - from.1);
                (from.0 + share * (to.0 - from.0), height)
            }
        }
    };
    Some((at(from), at(to)))
}

/// Thins a dense run to the highest and the lowest point of each column, a fifth of a point wide, in their order.
fn thin(run: Vec<Point2>) -> Vec<Point2> {
    const COLUMN: f64 = 0.2;
    const MIN_POINTS: usize = 3000;
    if run.len() < MIN_POINTS {
        return run;
    }
    let mut points: Vec<Point2> = Vec::new();
    for column in run.chunk_by(|a, b| (a.0 / COLUMN).floor() == (b.0 / COLUMN).floor()) {
        let by_height = |a: &(usize, &Point2), b: &(usize, &Point2)| a.1.1.total_cmp(&b.1.1);
        let (low, high) = (
            column.iter().enumerate().min_by(by_height),
            column.iter().enumerate().max_by(by_height),
        );
        let mut pair: Vec<(usize, &Point2)> = low.into_iter().chain(high).collect();
        pair.sort_by_key(|p| p.0);
        pair.dedup_by_key(|p| p.0);
        points.extend(pair.into_iter().map(|p| *p.1));
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A curve that leaves the panel ends at the edge and continues there; no part runs along the edge.
    #[test]
    fn exact_clipping() {
        let panel = Panel::new((0.0, 10.0), (10.0, 0.0), (0.0, 10.0), (0.0, 10.0));
        let clipped = |points: &[(f64, f64)]| -> Vec<Vec<Point2>> {
            let runs = clip_to_panel(&panel, points.iter().copied());
            runs.into_iter().filter(|run| run.len() > 1).collect()
        };
        let crossing = clipped(&[
            (0.0, 5.0),
            (1.0, -5.0),
            (3.0, -8.0),
            (4.0, -2.0),
            (6.0, 2.0),
        ]);
        assert_eq!(
            crossing,
            [vec![(0.0, 5.0), (0.5, 0.0)], vec![(5.0, 0.0), (6.0, 2.0)]]
        );
        assert_eq!(
            clipped(&[(2.0, -10.0), (6.0, 30.0)]),
            [vec![(3.0, 0.0), (4.0, 10.0)]]
        );
        let gap = clipped(&[
            (0.0, 1.0),
            (1.0, 1.0),
            (2.0, f64::NAN),
            (3.0, 1.0),
            (4.0, 1.0),
        ]);
        assert_eq!(gap.len(), 2);
    }

    #[test]
    fn exact_texts_of_decades() {
        let texts = |range| {
            log_ticks(range, None)
                .into_iter()
                .map(|t| t.1)
                .collect::<Vec<_>>()
        };
        assert_eq!(texts((-13.2, -12.9)), ["1e-13"]);
        assert_eq!(texts((-0.1, 0.8)), ["1", "2", "5"]);
    }
}
