//! Maps of deviations as coordinate-measuring machines draw them: each node lifted above its flank, before and after.

use super::number_format::four_digits;
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LIGHT_GREY, LineStyle, ORANGE, Point2, WIDTH,
    render_svg, ticks,
};
use crate::gear::bevel::tooth::SIDES;
use crate::gear::cut::measured_flank::{Deviations, FlankNode};
use crate::plan::gear::correction::CorrectionResult;
use crate::plan::gear_limits::MEMBERS;

/// Width and height of a flank in perspective, points.
const PLAN: [f64; 2] = [300.0, 120.0];
/// Shear of its height, points.
const SHEAR: f64 = 60.0;
/// Height of the largest deviation, points.
const LIFT: f64 = 90.0;
/// Height of a row of maps, points.
const ROW: f64 = 370.0;
/// Top of the first row, points.
const TOP: f64 = 60.0;
/// Left edges of both columns, points.
const COLUMNS: [f64; 2] = [60.0, 490.0];

/// Draws the maps of each flank, measured and expected of the next cut, at one scale.
pub fn draw(title: &str, result: &CorrectionResult) -> String {
    let after = &result.next.deviations;
    let all = result.before.iter().chain(after).flatten().flatten();
    let before = if result.contact.is_some() {
        "now"
    } else {
        "measured"
    };
    let largest = all.fold(0f64, |most, x| most.max(x.abs()));
    let height = TOP + ROW * result.sides.len() as f64;
    render_svg(WIDTH, height, |canvas| {
        canvas.title(title, COLUMNS[0]);
        let right = canvas.key_entry((COLUMNS[0], 36.0), "more metal", ORANGE, 1.6) + 16.0;
        let right = canvas.key_entry((right, 36.0), "less metal", BLUE, 1.6) + 16.0;
        canvas.key_entry((right, 36.0), "nominal flank", LIGHT_GREY, 1.6);
        draw_scale(canvas, largest);
        for (f, side) in result.sides.iter().enumerate() {
            let bottom = TOP + ROW * (f + 1) as f64 - LIFT - 15.0;
            let nodes = &result.problem.flanks[f].nodes;
            let name = format!("{} flank of the {}", SIDES[*side], MEMBERS[result.member]);
            let maps = [
                (&result.before[f], before),
                (&after[f], "next cut, expected"),
            ];
            for ((values, when), left) in maps.into_iter().zip(COLUMNS) {
                let map = Map {
                    nodes,
                    values,
                    left,
                    bottom,
                    largest,
                };
                map.draw(canvas);
                let text = format!("{name}, {when}: {}", sizes(values));
                canvas.note(&text, (left, bottom - PLAN[1] - LIFT - 16.0), Anchor::Start);
            }
        }
    })
}

fn sizes(values: &[Option<f64>]) -> String {
    let found = Deviations::of(values);
    format!(
        "rms {:.2} µm, largest {:.2} µm",
        1e6 * found.rms,
        1e6 * found.largest
    )
}

struct Map<'a> {
    nodes: &'a [FlankNode],
    values: &'a [Option<f64>],
    left: f64,
    bottom: f64,
    largest: f64,
}

impl Map<'_> {
    fn at(&self, [face, height]: [f64; 2], deviation: f64) -> Point2 {
        let lift = if self.largest > 0.0 {
            LIFT * deviation / self.largest
        } else {
            0.0
        };
        (
            self.left + PLAN[0] * face + SHEAR * height,
            self.bottom - PLAN[1] * height - lift,
        )
    }

    fn draw(&self, canvas: &mut Canvas) {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]];
        let frame = corners.map(|shares| self.at(shares, 0.0));
        canvas.polyline(&frame, LIGHT_GREY, 1.0, LineStyle::Solid);
        for line in lines(self.nodes) {
            let base: Vec<Point2> = line
                .iter()
                .map(|k| self.at(self.nodes[*k].shares, 0.0))
                .collect();
            canvas.polyline(&base, LIGHT_GREY, 0.6, LineStyle::Solid);
            for run in line.split(|k| self.values[*k].is_none()) {
                let lifted =
                    |k: &usize| self.at(self.nodes[*k].shares, self.values[*k].unwrap_or(0.0));
                let run: Vec<Point2> = run.iter().map(lifted).collect();
                canvas.polyline(&run, GREY, 0.9, LineStyle::Solid);
            }
        }
        for (node, value) in self.nodes.iter().zip(self.values) {
            let Some(value) = value else { continue };
            let (from, to) = (self.at(node.shares, 0.0), self.at(node.shares, *value));
            let ink: Colour = if *value > 0.0 { ORANGE } else { BLUE };
            canvas.line(from, to, ink, 1.4);
        }
        let ends = [
            (0.0, "toe", -8.0, Anchor::End),
            (1.0, "heel", 8.0, Anchor::Start),
        ];
        for (face, name, aside, anchor) in ends {
            let (x, y) = self.at([face, 0.5], 0.0);
            canvas.label(name, (x + aside, y + 4.0), anchor);
        }
        for (height, name, below) in [(0.0, "root", 14.0), (1.0, "tip", -10.0)] {
            let (x, y) = self.at([0.5, height], 0.0);
            canvas.label(name, (x, y + below), Anchor::Middle);
        }
    }
}

/// A round deviation as an upright bar, at the scale of the maps.
fn draw_scale(canvas: &mut Canvas, largest: f64) {
    let round = ticks((0.0, 0.7e6 * largest), 2);
    let Some(deviation) = round.last().copied().filter(|d| *d > 0.0) else {
        return;
    };
    let length = LIFT * deviation / (1e6 * largest);
    let (x, foot) = (WIDTH - 90.0, 24.0 + length);
    canvas.line((x, foot), (x, foot - length), BLACK, 1.6);
    for end in [foot, foot - length] {
        canvas.line((x - 4.0, end), (x + 4.0, end), BLACK, 1.2);
    }
    let text = format!("{} µm", four_digits(deviation));
    canvas.label(&text, (x + 9.0, foot - 0.5 * length), Anchor::Start);
}

/// Runs of nodes in one direction, in the order of the file, and those across where all runs have one length.
fn lines(nodes: &[FlankNode]) -> Vec<Vec<usize>> {
    let step = |k: usize| [0, 1].map(|i| nodes[k + 1].shares[i] - nodes[k].shares[i]);
    let mut runs: Vec<Vec<usize>> = Vec::new();
    let mut before: Option<[f64; 2]> = None;
    for k in 0..nodes.len() {
        let turned = k > 0 && before.is_some_and(|b| cosine(b, step(k - 1)) < SAME_LINE);
        match runs.last_mut() {
            Some(run) if !turned => run.push(k),
            _ => runs.push(vec![k]),
        }
        before = (k > 0 && !turned).then(|| step(k - 1));
    }
    let length = runs.first().map_or(0, Vec::len);
    let is_grid = length > 1 && runs.iter().all(|run| run.len() == length);
    if is_grid {
        let across: Vec<Vec<usize>> = (0..length)
            .map(|i| runs.iter().map(|run| run[i]).collect())
            .collect();
        runs.extend(across);
    }
    runs
}

/// Least cosine between steps of one line of nodes.
const SAME_LINE: f64 = 0.5;

fn cosine(a: [f64; 2], b: [f64; 2]) -> f64 {
    let dot = a[0] * b[0] + a[1] * b[1];
    dot / (f64::hypot(a[0], a[1]) * f64::hypot(b[0], b[1])).max(f64::MIN_POSITIVE)
}
