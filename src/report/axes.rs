//! Plot axes: linear and logarithmic ranges, grids, thinning of dense curves.

use super::svg::{Canvas, Colour, LIGHT_GREY, LineStyle, Panel, Point2, ticks};
use crate::numeric::statistics::extremes;

/// Decades a logarithmic scale shows below its top; what lies deeper is noise of the arithmetic.
const MAX_DECADES: f64 = 8.0;

/// The range of a logarithmic scale over positive values, in powers of ten; absent where no value is positive.
pub fn log_range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let positive = values.filter(|x| *x > 0.0 && x.is_finite());
    let (low, high) = extremes(positive.map(f64::log10));
    if low > high {
        return None;
    }
    let low = low.max(high - MAX_DECADES);
    // A little room, and never an empty range.
    let room = (0.06 * (high - low)).max(0.1);
    Some((low - room, high + room))
}

/// The range of a linear scale with a little room; absent where no value is finite.
pub fn linear_range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let (low, high) = extremes(values.filter(|x| x.is_finite()));
    if low > high {
        return None;
    }
    let room = match high - low {
        0.0 => 0.05 * high.abs().max(1.0),
        wide => 0.05 * wide,
    };
    Some((low - room, high + room))
}

/// Positions and texts of the grid of a logarithmic axis, its range in powers of ten; with a unit, texts have its prefix.
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
        // Few whole decades: 1, 2 and 5 of each.
        let all = (first - 1..=last).flat_map(|decade| [1.0, 2.0, 5.0].map(|d| (decade, d)));
        let each = all.map(|(decade, digit): (i32, f64)| {
            (f64::from(decade) + digit.log10(), text(digit, decade))
        });
        return each.filter(|(at, _)| (low..=high).contains(at)).collect();
    }
    let step = ((last - first) / 8).max(1) as usize;
    let decades = (first..=last).step_by(step);
    decades
        .map(|decade| (f64::from(decade), text(1.0, decade)))
        .collect()
}

/// A value of a unit with the prefix of its size: `10 µs`.
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

/// Frame, frequency axis and the name of the vertical axis of one panel; numbers below only where it is the lowest.
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

/// Draws a curve as a line inside a panel, as [`clip_to_panel`] cuts it.
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

/// A curve as spots, cut where it leaves the panel's height; runs of finite values only.
pub fn clip_to_panel(panel: &Panel, points: impl Iterator<Item = (f64, f64)>) -> Vec<Vec<Point2>> {
    let mut all: Vec<Vec<Point2>> = vec![Vec::new()];
    let mut before: Option<(f64, f64)> = None;
    for (x, y) in points {
        let is_shown = x >= panel.x.0 && x <= panel.x.1 && y.is_finite();
        let ends = before
            .filter(|_| is_shown)
            .and_then(|from| clip(panel.y, from, (x, y)));
        let is_inside = (panel.y.0..=panel.y.1).contains(&y);
        let spots = match ends {
            Some((from, to)) => {
                let begins = all.last().is_none_or(Vec::is_empty);
                vec![begins.then_some(from), Some(to)]
            }
            None if is_shown && is_inside => vec![Some((x, y))],
            None => Vec::new(),
        };
        let spots = spots
            .into_iter()
            .flatten()
            .map(|(x, y)| panel.to_canvas(x, y));
        if let Some(run) = all.last_mut() {
            run.extend(spots);
        }
        if !(is_shown && is_inside) && all.last().is_some_and(|run| !run.is_empty()) {
            all.push(Vec::new());
        }
        before = is_shown.then_some((x, y));
    }
    all.into_iter().map(thin).collect()
}

/// The part of a straight line between two heights; absent where it lies outside.
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

/// Keeps, of the points that share a fifth of a point of width, only the highest and the lowest, in their order.
fn thin(run: Vec<Point2>) -> Vec<Point2> {
    const COLUMN: f64 = 0.2;
    const MIN_POINTS: usize = 3000;
    if run.len() < MIN_POINTS {
        return run;
    }
    let mut kept: Vec<Point2> = Vec::new();
    for column in run.chunk_by(|a, b| (a.0 / COLUMN).floor() == (b.0 / COLUMN).floor()) {
        let by_height = |a: &(usize, &Point2), b: &(usize, &Point2)| a.1.1.total_cmp(&b.1.1);
        let (low, high) = (
            column.iter().enumerate().min_by(by_height),
            column.iter().enumerate().max_by(by_height),
        );
        let mut pair: Vec<(usize, &Point2)> = low.into_iter().chain(high).collect();
        pair.sort_by_key(|p| p.0);
        pair.dedup_by_key(|p| p.0);
        kept.extend(pair.into_iter().map(|p| *p.1));
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A curve that leaves the panel ends at the edge and begins there again; none of it runs along the edge.
    #[test]
    fn exact_clipping() {
        let panel = Panel::new((0.0, 10.0), (10.0, 0.0), (0.0, 10.0), (0.0, 10.0));
        let clipped = |points: &[(f64, f64)]| -> Vec<Vec<Point2>> {
            let runs = clip_to_panel(&panel, points.iter().copied());
            runs.into_iter().filter(|run| run.len() > 1).collect()
        };
        let all = clipped(&[
            (0.0, 5.0),
            (1.0, -5.0),
            (3.0, -8.0),
            (4.0, -2.0),
            (6.0, 2.0),
        ]);
        assert_eq!(
            all,
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
