//! Work–precision plot: error over run time, both logarithmic, one curve per method.

use super::axes::{draw_log_grid, log_range};
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LABEL_SIZE, LIGHT_GREY, LineStyle, ORANGE, Panel,
    Point2, WIDTH, lighten, render_svg,
};

const MARGIN_LEFT: f64 = 70.0;
const MARGIN_RIGHT: f64 = 190.0;
const MARGIN_TOP: f64 = 40.0;
const HEIGHT: f64 = 420.0;

/// Errors below this are rounding of the reference.
const FLOOR: f64 = 1e-17;

/// One run in the plot.
#[derive(Debug, Clone, Copy)]
pub struct WorkPrecisionPoint {
    /// The method, whose points are joined.
    pub method: &'static str,
    /// Run time, s.
    pub seconds: f64,
    /// Relative error.
    pub error: f64,
}

/// Work–precision plot: error over run time, both logarithmic, a line for each method; below the floor no error is measurable.
pub fn draw(title: &str, points: &[WorkPrecisionPoint], (floor, called): (f64, &str)) -> String {
    let ended: Vec<WorkPrecisionPoint> = points
        .iter()
        .map(|p| WorkPrecisionPoint {
            error: p.error.max(FLOOR),
            ..*p
        })
        .collect();
    render_svg(WIDTH, MARGIN_TOP + HEIGHT + 52.0, |canvas| {
        canvas.title(title, MARGIN_LEFT);
        let x = log_range(ended.iter().map(|p| p.seconds));
        let low = ended
            .iter()
            .map(|p| p.error.log10())
            .fold(f64::INFINITY, f64::min);
        let high = ended
            .iter()
            .map(|p| p.error.log10())
            .fold(f64::NEG_INFINITY, f64::max);
        let Some(x) = x else {
            canvas.placeholder(
                "no run came to its end",
                (WIDTH / 2.0, MARGIN_TOP + HEIGHT / 2.0),
            );
            return;
        };
        // At least one decade is ruled.
        let x = match x.0.ceil() > x.1 {
            true => (x.0.floor(), x.1.ceil()),
            false => x,
        };
        let panel = Panel::new(
            (MARGIN_LEFT, WIDTH - MARGIN_RIGHT),
            (MARGIN_TOP, MARGIN_TOP + HEIGHT),
            x,
            (low - 0.5, high.min(3.0) + 0.5),
        );
        draw_log_grid(&panel, canvas);
        rule_times(&panel, canvas);
        panel.draw_outline(canvas);
        panel.draw_y_name(canvas, "error");
        panel.draw_x_name(canvas, "run time, s", 30.0);
        if floor > 0.0 && floor.is_finite() && floor.log10() > panel.y.0 {
            let height = panel.canvas_y(floor.log10());
            canvas.polyline(
                &[(panel.across.0, height), (panel.across.1, height)],
                GREY,
                0.8,
                LineStyle::Dotted,
            );
            // Next to the axis: on the line it would meet the runs that reach it.
            canvas.note(
                &format!("dotted: {called}, {floor:.1e}"),
                (panel.across.1, MARGIN_TOP + HEIGHT + 30.0),
                Anchor::End,
            );
        }
        let mut methods: Vec<&str> = Vec::new();
        for point in &ended {
            if !methods.contains(&point.method) {
                methods.push(point.method);
            }
        }
        let ends: Vec<Point2> = methods.iter().map(|m| end_of(&panel, &ended, m)).collect();
        let heights = super::svg::spread_labels(
            &ends.iter().map(|e| e.1).collect::<Vec<_>>(),
            14.0,
            panel.down,
        );
        for (at, (method, (end, height))) in
            methods.iter().zip(ends.iter().zip(heights)).enumerate()
        {
            let (ink, stroke) = line_style(at);
            let spots: Vec<Point2> = ended
                .iter()
                .filter(|p| p.method == *method && p.error.log10() <= panel.y.1)
                .map(|p| panel.to_canvas(p.seconds.log10(), p.error.log10()))
                .collect();
            canvas.polyline(&spots, ink, 1.4, stroke);
            spots.iter().for_each(|&s| canvas.fill_circle(s, 3.0, ink));
            let label = (panel.across.1 + 14.0, height);
            canvas.line(*end, (label.0 - 3.0, label.1), LIGHT_GREY, 0.7);
            canvas.text(method, label, LABEL_SIZE, ink, Anchor::Start);
        }
    })
}

/// Label position of a method's line: its slowest point.
fn end_of(panel: &Panel, ended: &[WorkPrecisionPoint], method: &str) -> Point2 {
    let own = ended.iter().filter(|p| p.method == method);
    let slowest = own.max_by(|a, b| a.seconds.total_cmp(&b.seconds));
    slowest.map_or((panel.across.1, panel.down.0), |p| {
        panel.to_canvas(p.seconds.log10(), p.error.log10().min(panel.y.1))
    })
}

fn line_style(at: usize) -> (Colour, LineStyle) {
    let inks = [BLUE, ORANGE, BLACK, GREY, lighten(BLUE), lighten(ORANGE)];
    let strokes = [LineStyle::Solid, LineStyle::Dashed, LineStyle::Dotted];
    (
        inks[at % inks.len()],
        strokes[(at / inks.len()) % strokes.len()],
    )
}

fn rule_times(panel: &Panel, canvas: &mut Canvas) {
    let (first, last) = (panel.x.0.ceil() as i32, panel.x.1.floor() as i32);
    for decade in first..=last {
        let text = match decade {
            -6..=-4 => format!("{} µs", 10i64.pow((decade + 6) as u32)),
            -3..=-1 => format!("{} ms", 10i64.pow((decade + 3) as u32)),
            0..=3 => format!("{} s", 10i64.pow(decade as u32)),
            _ => format!("1e{decade} s"),
        };
        panel.draw_x_mark(canvas, f64::from(decade), &text);
    }
}
