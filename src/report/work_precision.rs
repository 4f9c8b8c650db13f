//! Error over run time as a picture.

use super::axes::{decades, rule_decades};
use super::style::{
    Anchor, BLACK, BLUE, Canvas, FAINT, GREY, Ink, ORANGE, Panel, SMALL, Spot, Stroke, TITLE,
    WIDTH, paler, picture,
};

const LEFT: f64 = 70.0;
const RIGHT: f64 = 190.0;
const TOP: f64 = 40.0;
const HIGH: f64 = 420.0;

/// Errors below this are rounding of the reference.
const FLOOR: f64 = 1e-17;

/// One run in the picture.
#[derive(Debug, Clone, Copy)]
pub struct Point {
    /// The method, whose points are joined.
    pub method: &'static str,
    /// Run time, s.
    pub seconds: f64,
    /// Relative error.
    pub error: f64,
}

/// Error over run time, both logarithmic, a line for each method; below the floor no error can be told.
pub fn draw(title: &str, points: &[Point], (floor, called): (f64, &str)) -> String {
    let ended: Vec<Point> = points
        .iter()
        .map(|p| Point {
            error: p.error.max(FLOOR),
            ..*p
        })
        .collect();
    picture(WIDTH, TOP + HIGH + 52.0, |canvas| {
        canvas.text(title, (LEFT, 16.0), TITLE, BLACK, Anchor::Start);
        let x = decades(ended.iter().map(|p| p.seconds));
        let low = ended
            .iter()
            .map(|p| p.error.log10())
            .fold(f64::INFINITY, f64::min);
        let high = ended
            .iter()
            .map(|p| p.error.log10())
            .fold(f64::NEG_INFINITY, f64::max);
        let Some(x) = x else {
            canvas.text(
                "no run came to its end",
                (WIDTH / 2.0, TOP + HIGH / 2.0),
                TITLE,
                GREY,
                Anchor::Middle,
            );
            return;
        };
        // At least one decade is ruled.
        let x = match x.0.ceil() > x.1 {
            true => (x.0.floor(), x.1.ceil()),
            false => x,
        };
        let panel = Panel {
            across: (LEFT, WIDTH - RIGHT),
            down: (TOP, TOP + HIGH),
            x,
            y: (low - 0.5, high.min(3.0) + 0.5),
        };
        rule_decades(&panel, canvas);
        rule_times(&panel, canvas);
        canvas.frame(
            (panel.across.0, panel.down.0),
            (panel.across.1, panel.down.1),
            GREY,
            0.6,
        );
        canvas.upright(
            "error",
            (14.0, TOP + HIGH / 2.0),
            SMALL,
            BLACK,
            Anchor::Middle,
        );
        canvas.text(
            "run time, s",
            (0.5 * (LEFT + WIDTH - RIGHT), TOP + HIGH + 30.0),
            SMALL,
            BLACK,
            Anchor::Middle,
        );
        if floor > 0.0 && floor.is_finite() && floor.log10() > panel.y.0 {
            let height = panel.height_of(floor.log10());
            canvas.path(
                &[(panel.across.0, height), (panel.across.1, height)],
                GREY,
                0.8,
                Stroke::Dotted,
            );
            // Beside the axis: on the line it would meet the runs that reach it.
            canvas.text(
                &format!("dotted: {called}, {floor:.1e}"),
                (panel.across.1, TOP + HIGH + 30.0),
                SMALL,
                GREY,
                Anchor::End,
            );
        }
        let mut methods: Vec<&str> = Vec::new();
        for point in &ended {
            if !methods.contains(&point.method) {
                methods.push(point.method);
            }
        }
        let ends: Vec<Spot> = methods.iter().map(|m| end_of(&panel, &ended, m)).collect();
        let heights = super::style::push_apart(
            &ends.iter().map(|e| e.1).collect::<Vec<_>>(),
            14.0,
            panel.down,
        );
        for (at, (method, (end, height))) in
            methods.iter().zip(ends.iter().zip(heights)).enumerate()
        {
            let (ink, stroke) = look(at);
            let spots: Vec<Spot> = ended
                .iter()
                .filter(|p| p.method == *method && p.error.log10() <= panel.y.1)
                .map(|p| panel.at(p.seconds.log10(), p.error.log10()))
                .collect();
            canvas.path(&spots, ink, 1.4, stroke);
            spots.iter().for_each(|&s| canvas.disc(s, 3.0, ink));
            let label = (panel.across.1 + 14.0, height);
            canvas.line(*end, (label.0 - 3.0, label.1), FAINT, 0.7);
            canvas.text(method, label, SMALL, ink, Anchor::Start);
        }
    })
}

/// Where the line of a method is to be labelled: at its slowest point.
fn end_of(panel: &Panel, ended: &[Point], method: &str) -> Spot {
    let own = ended.iter().filter(|p| p.method == method);
    let slowest = own.max_by(|a, b| a.seconds.total_cmp(&b.seconds));
    slowest.map_or((panel.across.1, panel.down.0), |p| {
        panel.at(p.seconds.log10(), p.error.log10().min(panel.y.1))
    })
}

fn look(at: usize) -> (Ink, Stroke) {
    let inks = [BLUE, ORANGE, BLACK, GREY, paler(BLUE), paler(ORANGE)];
    let strokes = [Stroke::Solid, Stroke::Dashed, Stroke::Dotted];
    (
        inks[at % inks.len()],
        strokes[(at / inks.len()) % strokes.len()],
    )
}

fn rule_times(panel: &Panel, canvas: &mut Canvas) {
    let (first, last) = (panel.x.0.ceil() as i32, panel.x.1.floor() as i32);
    for decade in first..=last {
        let right = panel.right_of(f64::from(decade));
        canvas.line((right, panel.down.0), (right, panel.down.1), FAINT, 0.5);
        let text = match decade {
            -6..=-4 => format!("{} µs", 10i64.pow((decade + 6) as u32)),
            -3..=-1 => format!("{} ms", 10i64.pow((decade + 3) as u32)),
            0..=3 => format!("{} s", 10i64.pow(decade as u32)),
            _ => format!("1e{decade} s"),
        };
        canvas.text(
            &text,
            (right, panel.down.1 + 11.0),
            SMALL,
            BLACK,
            Anchor::Middle,
        );
    }
}
