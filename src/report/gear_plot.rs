//! Figures of a gear pair: teeth in mesh, specific sliding, designed profile, stiffness and transmission error over a pitch, Harris map.

use std::f64::consts::TAU;

use super::figure::{Axis, PlotColumn, PointLabel, closed};
use super::number_format::with_minus_signs;
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, Colour, GREY, LIGHT_GREY, LineStyle, ORANGE, Point2, TITLE_SIZE,
    WIDTH, render_svg,
};
use crate::gear::cylindrical::gear_outline::OutlineSteps;
use crate::gear::cylindrical::modification::FlankModification;
use crate::gear::cylindrical::pair::Pair;
use crate::gear::cylindrical::path_points::PathPoint;
use crate::gear::load::contact_path::ContactPath;
use crate::gear::load::mesh_result::{LoadedCycle, MeshResult};

/// Teeth drawn on either side of the pitch point.
const NEIGHBOURS: i32 = 2;
/// Height of the drawing of teeth, points.
const HEIGHT: f64 = 520.0;
/// Number of outline points of a drawn tooth.
const STEPS: OutlineSteps = OutlineSteps {
    fillet: 16,
    involute: 24,
    land: 6,
};
/// Number of intervals of a drawn arc.
const ARC: usize = 120;
/// Number of intervals along the path of contact.
const PATH: usize = 200;
/// Largest number of curves in one figure.
const CURVES: usize = 4;

/// Map from metres to canvas points about the pitch point; the pinion axis lies below, the gear axis above (below if internal).
struct Scale {
    middle: Point2,
    scale: f64,
}

impl Scale {
    fn map(&self, [x, y]: [f64; 2]) -> Point2 {
        (
            self.middle.0 + self.scale * x,
            self.middle.1 - self.scale * y,
        )
    }
}

/// Gear on the canvas with its axis on the line of centres; angles are measured from the pitch point.
struct PlacedGear<'a> {
    transform: &'a Scale,
    centre: f64,
    /// Direction from the axis to the pitch point: 1 up, −1 down.
    up: f64,
    ink: Colour,
}

impl PlacedGear<'_> {
    fn polar(&self, radius: f64, angle: f64) -> Point2 {
        let (sin, cos) = angle.sin_cos();
        self.transform
            .map([radius * sin, self.centre + self.up * radius * cos])
    }
}

/// Draws teeth in mesh at the pitch point with the circles of both gears and the path of contact.
pub fn draw_teeth(title: &str, pair: &Pair, path: &[(&'static str, PathPoint)]) -> String {
    let [r1, r2] = pair.working_diameters().map(|d| 0.5 * d);
    let module = pair.members[0].gear.module;
    let half_width = 2.6 * TAU * r1 / f64::from(pair.members[0].gear.teeth);
    let transform = Scale {
        middle: (0.5 * WIDTH, 0.5 * HEIGHT + 20.0),
        scale: (WIDTH / (2.0 * half_width)).min(HEIGHT / (9.0 * module)),
    };
    // Centres with the pitch point at the origin.
    let (gear_centre, gear_up) = match pair.members[1].gear.internal {
        true => (-r2, 1.0),
        false => (r2, -1.0),
    };
    let gears = [(-r1, 1.0, BLUE), (gear_centre, gear_up, ORANGE)].map(|(centre, up, ink)| {
        let transform = &transform;
        PlacedGear {
            transform,
            centre,
            up,
            ink,
        }
    });
    render_svg(WIDTH, HEIGHT + 60.0, |canvas| {
        canvas.text(title, (24.0, 18.0), TITLE_SIZE, BLACK, Anchor::Start);
        for (k, gear) in gears.iter().enumerate() {
            for (rank, (name, radius)) in circles(pair, k).into_iter().enumerate() {
                draw_circle(canvas, gear, radius, (name, rank, k == 0));
            }
        }
        let tooth_range = -NEIGHBOURS..NEIGHBOURS + 1;
        let polygons = pair.polygons_in_mesh([tooth_range.clone(), tooth_range], STEPS);
        for (polygon, gear) in polygons.iter().zip(&gears) {
            let line: Vec<Point2> = (polygon.iter())
                .map(|[x, y]| transform.map([-y, x - r1]))
                .collect();
            for run in line.split(|p| !inside(*p)) {
                canvas.polyline(run, gear.ink, 1.2, LineStyle::Solid);
            }
        }
        draw_path(canvas, &transform, pair, path);
        let names = ["pinion (driving)", "gear"];
        for ((k, gear), y) in gears.iter().enumerate().zip([44.0, 28.0]) {
            let text = format!("{}, {}", names[k], circle_text(pair, k));
            canvas.text(&text, (24.0, HEIGHT + y), 10.0, gear.ink, Anchor::Start);
        }
        canvas.length_bar(transform.scale, 2.0 * module, (WIDTH - 24.0, 18.0));
    })
}

/// Names and radii, m, of the circles of a gear.
fn circles(pair: &Pair, k: usize) -> [(&'static str, f64); 5] {
    let (outline, gear) = (&pair.outlines[k], &pair.members[k].gear);
    [
        ("tip", outline.tip_radius),
        ("pitch", 0.5 * pair.working_diameters()[k]),
        ("reference", 0.5 * gear.reference_diameter()),
        ("base", outline.base_radius),
        ("root", outline.root_radius),
    ]
}

/// Number of teeth, circle diameters and, outside the base circle, the pressure angles.
fn circle_text(pair: &Pair, k: usize) -> String {
    let gear = &pair.members[k].gear;
    let circle = |(name, radius): (&str, f64)| {
        let angle = gear.pressure_angle_at(2.0 * radius).to_degrees();
        let angle_text = match angle > 0.0 {
            true => format!(" ({angle:.2}°)"),
            false => String::new(),
        };
        format!("{name} {:.3}{angle_text}", 2e3 * radius)
    };
    let list: Vec<String> = circles(pair, k).into_iter().map(circle).collect();
    format!("{} teeth, diameters in mm: {}", gear.teeth, list.join(", "))
}

/// Arc points between the labels of two circles of a gear.
const NAME_STEP: usize = 8;

/// Draws a dotted arc near the pitch point with its label, at the right end for the pinion, at the left end for the gear; labels of higher
/// rank lie further inside.
fn draw_circle(
    canvas: &mut Canvas,
    gear: &PlacedGear,
    radius: f64,
    (name, rank, at_right): (&str, usize, bool),
) {
    let half_width = 0.5 * WIDTH / gear.transform.scale;
    let max_angle = (half_width / radius).min(1.0).asin();
    let arc: Vec<Point2> = (0..=ARC)
        .map(|i| gear.polar(radius, max_angle * (2.0 * i as f64 / ARC as f64 - 1.0)))
        .filter(|p| inside(*p))
        .collect();
    canvas.polyline(&arc, GREY, 0.6, LineStyle::Dotted);
    let point = match at_right {
        true => arc.iter().rev().nth(NAME_STEP * rank + 1),
        false => arc.get(NAME_STEP * rank + 1),
    };
    if let Some(point) = point {
        let anchor = match at_right {
            true => Anchor::End,
            false => Anchor::Start,
        };
        canvas.text(name, (point.0, point.1 - 4.0), 10.0, gear.ink, anchor);
    }
}

fn inside((x, y): Point2) -> bool {
    (0.0..=WIDTH).contains(&x) && (26.0..=HEIGHT + 20.0).contains(&y)
}

/// Draws the path of contact on the line of action with its labelled points.
fn draw_path(canvas: &mut Canvas, frame: &Scale, pair: &Pair, path: &[(&'static str, PathPoint)]) {
    let (sin, cos) = pair.working_pressure_angle.sin_cos();
    let at = |distance: f64| frame.map([distance * cos, distance * sin]);
    let (Some(first), Some(last)) = (path.first(), path.last()) else {
        return;
    };
    let pitch = 0.8 * pair.base_pitch();
    let [from, to] = [first.1.distance, last.1.distance];
    canvas.line(at(from - pitch), at(to + pitch), LIGHT_GREY, 0.8);
    canvas.line(at(from), at(to), BLACK, 1.6);
    // A letter too close to the previous one goes on the other side of the line.
    let mut below_until = f64::NEG_INFINITY;
    for (name, point) in path {
        let marker = at(point.distance);
        canvas.fill_circle(marker, 2.2, BLACK);
        let (label, anchor) = match marker.0 >= below_until {
            true => ((marker.0 + 4.0, marker.1 + 11.0), Anchor::Start),
            false => ((marker.0 - 4.0, marker.1 - 5.0), Anchor::End),
        };
        if marker.0 >= below_until {
            below_until = marker.0 + 14.0;
        }
        canvas.text(name, label, 10.0, BLACK, anchor);
    }
}

/// Plot of the specific sliding of both gears over the path of contact.
pub fn sliding(title: &str, pair: &Pair, path: &[(&'static str, PathPoint)]) -> PlotColumn {
    /// Lower limit of the plot; specific sliding diverges toward the base circles.
    const LOWEST: f64 = -10.0;
    let [approach, recess] = pair.path_ends();
    let distance = |i: usize| recess.mul_add(i as f64, -approach * (PATH - i) as f64) / PATH as f64;
    let points: Vec<PathPoint> = (0..=PATH).map(|i| pair.path_point(distance(i))).collect();
    let line = |name: &str, k: usize| {
        let plotted = points.iter().filter(|p| p.specific_sliding[k] >= LOWEST);
        let (x, y) = plotted
            .map(|p| (1e3 * p.distance, p.specific_sliding[k]))
            .unzip();
        (name.to_string(), x, y)
    };
    let axes = (
        Axis::linear("distance from the pitch point along the path of contact, mm"),
        Axis::linear("specific sliding"),
    );
    let mut figure = PlotColumn::of_lines(title, axes, [line("pinion", 0), line("gear", 1)]);
    let label = |(name, p): &(&'static str, PathPoint)| PointLabel {
        x: 1e3 * p.distance,
        y: 0.0,
        text: name.to_string(),
    };
    for plot in &mut figure.plots {
        plot.labels = path.iter().map(label).collect();
    }
    figure
}

/// Plot of the designed profile of both flanks over the length of roll; removed material is negative, as on an inspection chart.
pub fn profile(title: &str, pair: &Pair, modifications: &[FlankModification; 2]) -> PlotColumn {
    let path = ContactPath::new(pair);
    let line = |k: usize| {
        let [root, tip] = path.flank_ends[k];
        let roll_at = |i: usize| root + (tip - root) * i as f64 / PATH as f64;
        let rolls = (0..=PATH).map(roll_at);
        // At mid-face, helix modifications do not enter the profile.
        let removed = |roll: f64| -1e6 * modifications[k].removed(roll, [root, tip], 0.5);
        let (x, y) = rolls.map(|roll| (1e3 * roll, removed(roll) + 0.0)).unzip();
        (["pinion", "gear"][k].to_string(), x, y)
    };
    let axes = (
        Axis::linear("length of roll, mm"),
        Axis::linear("designed profile, µm"),
    );
    let mut figure = PlotColumn::of_lines(title, axes, [line(0), line(1)]);
    let points = pair.path_points();
    let names = [
        ("pinion, start of contact", 0, points.a.roll[0]),
        ("pinion, end", 0, points.e.roll[0]),
        ("gear, start of contact", 1, points.e.roll[1]),
        ("gear, end", 1, points.a.roll[1]),
    ];
    let label = |(name, k, roll): &(&str, usize, f64)| PointLabel {
        x: 1e3 * roll,
        y: -1e6 * modifications[*k].removed(*roll, path.flank_ends[*k], 0.5) + 0.0,
        text: name.to_string(),
    };
    for plot in &mut figure.plots {
        plot.labels = names.iter().map(label).collect();
    }
    figure
}

/// Indices of the plotted torques: first, last and some between.
fn shown_cycles(mesh: &MeshResult) -> impl Iterator<Item = usize> {
    let last = mesh.cycles.len().saturating_sub(1);
    let count = CURVES.min(mesh.cycles.len());
    (0..count).map(move |k| last * k / count.saturating_sub(1).max(1))
}

/// Plot of the transmission error over the pinion angle at up to four torques.
pub fn te_over_pitch(title: &str, mesh: &MeshResult) -> PlotColumn {
    over_pitch(
        title,
        mesh,
        "transmission error less its mean, µm",
        |cycle| {
            let mean = cycle.te.iter().sum::<f64>() / cycle.te.len().max(1) as f64;
            cycle.te.iter().map(|e| 1e6 * (e - mean)).collect()
        },
    )
}

/// Plot of the tangent stiffness over the pinion angle at up to four torques.
pub fn stiffness(title: &str, mesh: &MeshResult) -> PlotColumn {
    over_pitch(title, mesh, "tangent stiffness, N/µm", |cycle| {
        cycle.tangent.iter().map(|k| 1e-6 * k).collect()
    })
}

/// Pinion angles of a pitch, deg.
fn degrees(mesh: &MeshResult) -> Vec<f64> {
    mesh.pinion_angles.iter().map(|a| a.to_degrees()).collect()
}

fn over_pitch(
    title: &str,
    mesh: &MeshResult,
    label: &str,
    values: fn(&LoadedCycle) -> Vec<f64>,
) -> PlotColumn {
    let axes = (Axis::linear("pinion angle, deg"), Axis::linear(label));
    let axes = (
        axes.0,
        axes.1
            .from_zero(shown_cycles(mesh).flat_map(|k| values(&mesh.cycles[k]))),
    );
    let line = |k: usize| {
        let cycle = &mesh.cycles[k];
        let (angles, values) = closed(degrees(mesh), values(cycle));
        (format!("{} N·m", cycle.torque), angles, values)
    };
    PlotColumn::of_lines(title, axes, shown_cycles(mesh).map(line))
}

/// Plot of the load share of each tooth pair over the pinion angle at the largest torque.
pub fn sharing(title: &str, mesh: &MeshResult) -> PlotColumn {
    let Some(cycle) = mesh.cycles.last() else {
        return PlotColumn::default();
    };
    let carries = |pair: &usize| cycle.shares.iter().any(|shares| shares[*pair] > 0.0);
    let line = |pair: usize| {
        let percent = cycle.shares.iter().map(|shares| 100.0 * shares[pair]);
        let name = with_minus_signs(&format!("pair {}", mesh.pairs[pair]));
        (name, degrees(mesh), percent.collect())
    };
    let share = format!("share of {} N·m, %", cycle.torque);
    let axes = (
        Axis::linear("pinion angle, deg"),
        Axis::linear(share).over(0.0, 105.0),
    );
    PlotColumn::of_lines(title, axes, (0..mesh.pairs.len()).filter(carries).map(line))
}

/// Plot of the peak-to-peak transmission error over torque.
pub fn harris_map(title: &str, mesh: &MeshResult) -> PlotColumn {
    let torques = mesh.cycles.iter().map(|c| c.torque).collect();
    let peaks: Vec<f64> = mesh.cycles.iter().map(|c| 1e6 * c.peak_to_peak()).collect();
    let te = Axis::linear("peak-to-peak transmission error, µm");
    let axes = (
        Axis::linear("torque at the pinion, N·m"),
        te.from_zero(peaks.iter().copied()),
    );
    PlotColumn::of_lines(title, axes, [(String::new(), torques, peaks)])
}
