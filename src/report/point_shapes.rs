//! Shapes on the points of a test: document, moving view, drawing.

use serde_json::{Map, Value, json};

use super::json::complex;
use super::number_format::percent;
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, GREY, LABEL_SIZE, LineStyle, Point2, TITLE_SIZE, WIDTH, hertz,
    render_svg, truncate_label,
};
use super::view::{View, ViewKind};
use crate::identify::point_shape::Displacement;
use crate::numeric::Complex;
use crate::numeric::statistics::extremes;
use crate::plan::logs::identification_result::{IdentificationResult, IdentifiedMode, PointShapes};

/// Modes drawn at most.
const MAX_MODES: usize = 8;

/// Largest number of points that are named.
const MAX_NAMED: usize = 40;

/// Largest displacement relative to the size of the structure.
const AMPLITUDE: f64 = 0.12;

/// Direction of view: azimuth about z and elevation, degrees. The script of the page begins with the same.
const VIEW_DEG: (f64, f64) = (30.0, 25.0);

const MARGIN: f64 = 24.0;
const HEADING: f64 = 26.0;
const PANEL_HEIGHT: f64 = 230.0;

/// Points, lines and channels as in documents.
pub fn geometry_json(shapes: &PointShapes) -> Value {
    let geometry = &shapes.geometry;
    let name = |k: &usize| geometry.points[*k].name.as_str();
    json!({
        "points": geometry.points.iter().map(|p| json!({ "name": p.name, "at_m": p.at })).collect::<Vec<_>>(),
        "lines": geometry.lines.iter().map(|line| line.iter().map(name).collect()).collect::<Vec<Vec<_>>>(),
        "channels": (geometry.channels.iter())
            .filter_map(|c| Some(json!({ "channel": c.channel, "point": name(&c.point?), "direction": c.direction })))
            .collect::<Vec<_>>(),
    })
}

/// The shape of a mode by point: components along x, y and z.
pub fn shape_json(shapes: &PointShapes, mode: usize) -> Value {
    let points = shapes
        .geometry
        .points
        .iter()
        .zip(&shapes.displacements[mode]);
    let moving: Map<String, Value> = points
        .filter_map(|(p, u)| Some((p.name.clone(), json!(u.as_ref()?.map(complex)))))
        .collect();
    Value::Object(moving)
}

/// The moving view.
pub fn view(result: &IdentificationResult, shapes: &PointShapes) -> View {
    let geometry = &shapes.geometry;
    let mode = |(k, m): (usize, &IdentifiedMode)| json!({ "mode": k + 1, "frequency_hz": m.frequency_hz(), "damping_ratio": m.damping_ratio() });
    let parts = |part: fn(&Complex) -> f64| -> Vec<f64> {
        let all = shapes.displacements.iter().flatten();
        all.flat_map(|u| {
            u.as_ref()
                .map_or([0.0; 3], |u| [0, 1, 2].map(|k| part(&u[k])))
        })
        .collect()
    };
    let measured = shapes.displacements.first();
    let measured: Vec<bool> = measured
        .into_iter()
        .flatten()
        .map(Option::is_some)
        .collect();
    View {
        kind: ViewKind::Points,
        replaces: &[],
        title: "Mode shapes".into(),
        data: json!({
            "points": geometry.points.iter().map(|p| &p.name).collect::<Vec<_>>(),
            "at_m": geometry.points.iter().flat_map(|p| p.at).collect::<Vec<f64>>(),
            "lines": geometry.lines,
            "measured": measured,
            "modes": result.modes.iter().enumerate().map(mode).collect::<Vec<_>>(),
            "real": parts(|z| z.re),
            "imaginary": parts(|z| z.im),
        }),
    }
}

/// Draws the shapes of the first modes.
pub fn draw(result: &IdentificationResult, shapes: &PointShapes, title: &str) -> String {
    let modes = &result.modes[..result.modes.len().min(MAX_MODES)];
    let columns = if modes.len() > 1 { 2 } else { 1 };
    let rows = modes.len().div_ceil(columns);
    let top = 48.0;
    let height = top + rows as f64 * (PANEL_HEIGHT + HEADING) + 8.0;
    let width = (WIDTH - MARGIN * (columns as f64 + 1.0)) / columns as f64;
    let drawing = ShapeDrawing::new(shapes, (width, PANEL_HEIGHT));
    render_svg(WIDTH, height, |canvas| {
        canvas.title(title, MARGIN);
        let key = "grey: at rest; blue: at the instant of the largest displacement; rings: points that were not measured";
        canvas.note(key, (MARGIN, 34.0), Anchor::Start);
        if result.modes.len() > modes.len() {
            let more = format!("{} more modes: --html", result.modes.len() - modes.len());
            canvas.note(&more, (WIDTH - MARGIN, 16.0), Anchor::End);
        }
        for (k, mode) in modes.iter().enumerate() {
            let left = MARGIN + (k % columns) as f64 * (width + MARGIN);
            let head = top + (k / columns) as f64 * (PANEL_HEIGHT + HEADING) + 12.0;
            let damping = mode.damping_ratio();
            let damping = damping.map_or(String::new(), |d| format!(" · damping {} %", percent(d)));
            let text = format!("mode {} · {}{damping}", k + 1, hertz(mode.frequency_hz()));
            canvas.text(&text, (left, head), TITLE_SIZE, BLACK, Anchor::Start);
            let corner = (left, head + 12.0);
            drawing.mode(canvas, corner, &shapes.displacements[k], k == 0);
        }
    })
}

/// The projection that all panels share.
struct ShapeDrawing<'a> {
    shapes: &'a PointShapes,
    panel: (f64, f64),
    /// Length of the diagonal of the structure, m.
    size: f64,
    /// Middle of the projected structure, m, and points of the drawing per metre.
    middle: Point2,
    scale: f64,
}

/// Position in the plane of view, to the right and upwards.
fn project([x, y, z]: [f64; 3]) -> Point2 {
    let (a, e) = (VIEW_DEG.0.to_radians(), VIEW_DEG.1.to_radians());
    let away = -x * a.sin() + y * a.cos();
    (x * a.cos() + y * a.sin(), away * e.sin() + z * e.cos())
}

impl<'a> ShapeDrawing<'a> {
    fn new(shapes: &'a PointShapes, panel: (f64, f64)) -> ShapeDrawing<'a> {
        let points = &shapes.geometry.points;
        let extent = |of: &dyn Fn(&[f64; 3]) -> f64| {
            let ends = extremes(points.iter().map(|p| of(&p.at)));
            (0.5 * (ends.0 + ends.1), ends.1 - ends.0)
        };
        let sides = [0, 1, 2].map(|k| extent(&|at| at[k]).1);
        let size = sides.iter().map(|s| s * s).sum::<f64>().sqrt();
        let size = if size > 0.0 { size } else { 1.0 };
        let (across, up) = (extent(&|at| project(*at).0), extent(&|at| project(*at).1));
        let room = 2.0 * AMPLITUDE * size;
        let scale = (panel.0 / (across.1 + room)).min(panel.1 / (up.1 + room));
        ShapeDrawing {
            shapes,
            panel,
            size,
            middle: (across.0, up.0),
            scale,
        }
    }

    fn mode(
        &self,
        canvas: &mut Canvas,
        corner: Point2,
        displacements: &[Option<Displacement>],
        is_first: bool,
    ) {
        let geometry = &self.shapes.geometry;
        let spot = |at: [f64; 3]| {
            let (x, y) = project(at);
            (
                corner.0 + 0.5 * self.panel.0 + (x - self.middle.0) * self.scale,
                corner.1 + 0.5 * self.panel.1 - (y - self.middle.1) * self.scale,
            )
        };
        let largest = displacements.iter().flatten().flatten();
        let largest = largest.fold(Complex::ZERO, |most, z| match z.norm() > most.norm() {
            true => *z,
            false => most,
        });
        let turned = |z: &Complex| match largest.norm() > 0.0 {
            true => (z / largest).re * AMPLITUDE * self.size,
            false => 0.0,
        };
        let rest: Vec<Point2> = geometry.points.iter().map(|p| spot(p.at)).collect();
        let moved = |(p, u): (&[f64; 3], &Option<Displacement>)| {
            let u = u
                .as_ref()
                .map_or([0.0; 3], |u| [0, 1, 2].map(|k| turned(&u[k])));
            spot(std::array::from_fn(|k| p[k] + u[k]))
        };
        let points = geometry.points.iter().map(|p| &p.at);
        let moved: Vec<Point2> = points.zip(displacements).map(moved).collect();
        for line in &geometry.lines {
            let path = |spots: &[Point2]| line.iter().map(|k| spots[*k]).collect::<Vec<_>>();
            canvas.polyline(&path(&rest), GREY, 0.8, LineStyle::Solid);
            canvas.polyline(&path(&moved), BLUE, 1.8, LineStyle::Solid);
        }
        for (k, u) in displacements.iter().enumerate() {
            if geometry.lines.is_empty() {
                canvas.line(rest[k], moved[k], BLUE, 1.2);
            }
            canvas.fill_circle(rest[k], 1.6, GREY);
            match u {
                Some(_) => canvas.fill_circle(moved[k], 2.8, BLUE),
                None => canvas.stroke_circle(rest[k], 3.2, GREY, 1.0),
            }
        }
        if is_first {
            self.name_points(canvas, &rest, &moved);
            axes(canvas, (corner.0 + 26.0, corner.1 + self.panel.1 - 26.0));
        }
    }

    /// Names of the points, each on the side of its rest that the displaced point is not on.
    fn name_points(&self, canvas: &mut Canvas, rest: &[Point2], moved: &[Point2]) {
        let points = &self.shapes.geometry.points;
        if points.len() > MAX_NAMED {
            return;
        }
        for ((point, at), to) in points.iter().zip(rest).zip(moved) {
            let below = if to.1 > at.1 + 1.0 { -9.0 } else { 10.0 };
            let name = truncate_label(&point.name, 12);
            canvas.text(
                &name,
                (at.0, at.1 + below),
                LABEL_SIZE - 2.0,
                GREY,
                Anchor::Middle,
            );
        }
    }
}

/// Directions of the axes.
fn axes(canvas: &mut Canvas, origin: Point2) {
    const LENGTH: f64 = 20.0;
    for (k, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (x, y) = project(std::array::from_fn(|i| if i == k { 1.0 } else { 0.0 }));
        let end = |length: f64| (origin.0 + x * length, origin.1 - y * length);
        canvas.line(origin, end(LENGTH), GREY, 1.0);
        canvas.note(name, end(LENGTH + 7.0), Anchor::Middle);
    }
}
