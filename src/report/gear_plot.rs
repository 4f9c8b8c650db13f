//! Figures of a gear pair: teeth in mesh at the pitch point, sliding over the path, stiffness and transmission error over a pitch, Harris map.

use std::f64::consts::TAU;

use super::spectrum_plot::{SpectrumPlot, draw_spectra};
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LIGHT_GREY, LineStyle, ORANGE, Point2, TITLE_SIZE,
    WIDTH, render_svg,
};
use crate::gear::cylindrical::outline::ToothOutline;
use crate::gear::cylindrical::pair::Pair;
use crate::gear::cylindrical::path_points::PathPoint;
use crate::gear::load::mesh_result::MeshResult;

/// Teeth shown on either side of the pitch point.
const NEIGHBOURS: i32 = 2;
/// Height of the drawing of teeth, points.
const HEIGHT: f64 = 520.0;
/// Points of a flank: fillet and involute.
const FLANK: [usize; 2] = [16, 24];
/// Intervals of the arc at a tip.
const TIP_ARC: usize = 6;
/// Points of a circle's arc.
const ARC: usize = 120;
/// Points along the path of contact.
const PATH: usize = 200;
/// Curves of one figure.
const CURVES: usize = 4;

/// A pair to be drawn where a tooth of the pinion touches the gear at the pitch point.
pub struct TeethInMesh<'a> {
    /// Title of the figure.
    pub title: &'a str,
    /// The pair.
    pub pair: &'a Pair,
    /// Points of the path of contact.
    pub path: &'a [(&'static str, PathPoint)],
}

/// Metres to canvas about the pitch point; the pinion's axis lies below, the gear's above, of an internal gear below as well.
struct Place {
    middle: Point2,
    scale: f64,
}

impl Place {
    fn at(&self, [x, y]: [f64; 2]) -> Point2 {
        (
            self.middle.0 + self.scale * x,
            self.middle.1 - self.scale * y,
        )
    }
}

/// Draws teeth in mesh at the pitch point with the circles of both gears and the path of contact.
pub fn draw_teeth(shown: &TeethInMesh) -> String {
    let pair = shown.pair;
    let [r1, r2] = pair.working_diameters().map(|d| 0.5 * d);
    let module = pair.members[0].gear.module;
    let wide = 2.6 * TAU * r1 / f64::from(pair.members[0].gear.teeth);
    let place = Place {
        middle: (0.5 * WIDTH, 0.5 * HEIGHT + 20.0),
        scale: (WIDTH / (2.0 * wide)).min(HEIGHT / (9.0 * module)),
    };
    let internal = pair.members[1].gear.internal;
    // Centres with the pitch point at the origin.
    let centres = [[0.0, -r1], [0.0, if internal { -r2 } else { r2 }]];
    render_svg(WIDTH, HEIGHT + 60.0, |canvas| {
        canvas.text(shown.title, (24.0, 18.0), TITLE_SIZE, BLACK, Anchor::Start);
        for (k, colour) in [(0, BLUE), (1, ORANGE)] {
            let up = if k == 0 || internal { 1.0 } else { -1.0 };
            let outline = &pair.outlines[k];
            let circles = [
                ("tip", outline.tip_radius),
                ("pitch", [r1, r2][k]),
                ("base", outline.base_radius),
            ];
            for (name, radius) in circles {
                draw_circle(canvas, &place, centres[k], up, radius, name);
            }
            draw_gear(canvas, &place, pair, k, centres[k], up, colour);
        }
        draw_path(canvas, &place, pair, shown.path);
        let label = |canvas: &mut Canvas, text: &str, y: f64, ink: Colour| {
            canvas.text(text, (24.0, y), 10.0, ink, Anchor::Start);
        };
        let [z1, z2] = pair.members.map(|m| m.gear.teeth);
        label(
            canvas,
            &format!("pinion, {z1} teeth (driving)"),
            HEIGHT + 44.0,
            BLUE,
        );
        label(canvas, &format!("gear, {z2} teeth"), HEIGHT + 28.0, ORANGE);
    })
}

/// Arc of a circle near the pitch point, dotted, with its name.
fn draw_circle(
    canvas: &mut Canvas,
    place: &Place,
    centre: [f64; 2],
    up: f64,
    radius: f64,
    name: &str,
) {
    let half = 0.5 * WIDTH / place.scale;
    let reach = (half / radius).min(1.0).asin();
    let arc: Vec<Point2> = (0..=ARC)
        .map(|i| reach * (2.0 * i as f64 / ARC as f64 - 1.0))
        .map(|a| {
            place.at([
                centre[0] + radius * a.sin(),
                centre[1] + up * radius * a.cos(),
            ])
        })
        .filter(|p| inside(*p))
        .collect();
    canvas.polyline(&arc, GREY, 0.6, LineStyle::Dotted);
    if let Some(end) = arc.last() {
        canvas.text(name, (end.0 - 4.0, end.1 - 6.0), 8.0, GREY, Anchor::End);
    }
}

fn inside((x, y): Point2) -> bool {
    (0.0..=WIDTH).contains(&x) && (26.0..=HEIGHT + 20.0).contains(&y)
}

/// Teeth of one gear about the pitch point. The pinion's right flank touches there, so its tooth is turned by its half angle at the pitch
/// circle; the gear's flank that faces it likewise.
fn draw_gear(
    canvas: &mut Canvas,
    place: &Place,
    pair: &Pair,
    k: usize,
    centre: [f64; 2],
    up: f64,
    colour: Colour,
) {
    let outline: &ToothOutline = &pair.outlines[k];
    let pitch_radius = 0.5 * pair.working_diameters()[k];
    let Some(half) = outline.half_angle(pitch_radius) else {
        return;
    };
    let pitch = TAU / f64::from(outline.teeth);
    // Where the flank that touches at the pitch point lies right of the tooth's middle, the tooth turns to the left.
    let sense = if k == 0 { -1.0 } else { 1.0 };
    let flank = outline.flank(FLANK[0], FLANK[1]);
    let mut line: Vec<Point2> = Vec::new();
    for tooth in -NEIGHBOURS..=NEIGHBOURS {
        let turn = sense * half + pitch * f64::from(tooth);
        let at = |radius: f64, angle: f64| {
            place.at([
                centre[0] + radius * angle.sin(),
                centre[1] + up * radius * angle.cos(),
            ])
        };
        let point = |[x, y]: [f64; 2], side: f64| at(x.hypot(y), turn + side * x.atan2(y));
        let tip = outline.half_angle(outline.tip_radius).unwrap_or(0.0);
        let along_tip = (1..TIP_ARC).map(|i| tip * (2.0 * i as f64 / TIP_ARC as f64 - 1.0));
        line.extend(flank.iter().map(|p| point(*p, -1.0)));
        line.extend(along_tip.map(|angle| at(outline.tip_radius, turn + angle)));
        line.extend(flank.iter().rev().map(|p| point(*p, 1.0)));
    }
    for run in line.split(|p| !inside(*p)) {
        canvas.polyline(run, colour, 1.2, LineStyle::Solid);
    }
}

/// Path of contact on the line of action with its points.
fn draw_path(canvas: &mut Canvas, place: &Place, pair: &Pair, path: &[(&'static str, PathPoint)]) {
    let (sin, cos) = pair.working_pressure_angle.sin_cos();
    let at = |distance: f64| place.at([distance * cos, distance * sin]);
    let (Some(first), Some(last)) = (path.first(), path.last()) else {
        return;
    };
    let pitch = 0.8 * pair.base_pitch();
    let [from, to] = [first.1.distance, last.1.distance];
    canvas.line(at(from - pitch), at(to + pitch), LIGHT_GREY, 0.8);
    canvas.line(at(from), at(to), BLACK, 1.6);
    for (name, point) in path {
        let spot = at(point.distance);
        canvas.fill_circle(spot, 2.2, BLACK);
        canvas.text(
            name,
            (spot.0 + 4.0, spot.1 + 9.0),
            9.0,
            BLACK,
            Anchor::Start,
        );
    }
}

/// Draws the specific sliding of both gears over the path of contact.
pub fn draw_sliding(title: &str, pair: &Pair) -> String {
    let [approach, recess] = pair.path_ends();
    let at = |i: usize| recess.mul_add(i as f64, -approach * (PATH - i) as f64) / PATH as f64;
    let points: Vec<PathPoint> = (0..=PATH).map(|i| pair.path_point(at(i))).collect();
    let curve = |name: &str, k: usize| {
        let (x, y): (Vec<f64>, Vec<f64>) = (points.iter())
            .filter(|p| p.specific_sliding[k].is_finite())
            .map(|p| (1e3 * p.distance, p.specific_sliding[k]))
            .unzip();
        (name.to_string(), x, y)
    };
    let named = pair.path_points().named();
    draw_spectra(&SpectrumPlot {
        title: title.to_string(),
        across: "distance from the pitch point along the path of contact, mm".into(),
        up: "specific sliding".into(),
        curves: vec![curve("pinion", 0), curve("gear", 1)],
        labels: (named.iter())
            .map(|(name, p)| {
                (
                    1e3 * p.distance,
                    p.specific_sliding[0].max(-10.0),
                    name.to_string(),
                )
            })
            .collect(),
        logarithmic: false,
    })
}

/// Torques of the figure over a pitch: first, last and some between.
fn shown_cycles(mesh: &MeshResult) -> impl Iterator<Item = usize> {
    let last = mesh.cycles.len().saturating_sub(1);
    let count = CURVES.min(mesh.cycles.len());
    (0..count).map(move |k| last * k / count.saturating_sub(1).max(1))
}

/// Draws e over the pinion angle at up to four torques.
pub fn draw_mesh(title: &str, mesh: &MeshResult) -> String {
    let degrees: Vec<f64> = mesh.pinion_angles.iter().map(|a| a.to_degrees()).collect();
    let curve = |k: usize| {
        let cycle = &mesh.cycles[k];
        let micro = cycle.te.iter().map(|e| 1e6 * e).collect();
        (format!("{} N·m", cycle.torque), degrees.clone(), micro)
    };
    draw_spectra(&SpectrumPlot {
        title: title.to_string(),
        across: "pinion angle, deg".into(),
        up: "transmission error, µm".into(),
        curves: shown_cycles(mesh).map(curve).collect(),
        labels: Vec::new(),
        logarithmic: false,
    })
}

/// Draws the peak-to-peak transmission error over torque.
pub fn draw_harris_map(title: &str, mesh: &MeshResult) -> String {
    let torques = mesh.cycles.iter().map(|c| c.torque).collect();
    let peaks = mesh.cycles.iter().map(|c| 1e6 * c.peak_to_peak()).collect();
    draw_spectra(&SpectrumPlot {
        title: title.to_string(),
        across: "torque at the pinion, N·m".into(),
        up: "peak-to-peak transmission error, µm".into(),
        curves: vec![(mesh.method.to_string(), torques, peaks)],
        labels: Vec::new(),
        logarithmic: false,
    })
}
