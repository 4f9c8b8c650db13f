//! Figures of a bevel pair: blanks in the plane of the axes, transmission error, pattern with path and ellipses, ease-off.

use super::figure::{Axis, PlotColumn};
use super::gear::ARCSEC;
use super::svg::{
    Anchor, BLACK, BLUE, Canvas, GREY, LIGHT_GREY, LineStyle, ORANGE, Point2, WIDTH, lighten,
    render_svg,
};
use crate::gear::bevel::tooth_section::ToothSection;
use crate::plan::gear::bevel_contact::{BevelContact, one_pitch, outline};
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::BevelFile;

/// Greatest height of a drawing at scale, points.
const HEIGHT: f64 = 560.0;
/// Greatest height of one flank in a drawing of both, points.
pub(super) const PATTERN_HEIGHT: f64 = 0.45 * HEIGHT;
/// Space above it and around it, points.
pub(super) const TOP: f64 = 56.0;
/// See [`TOP`].
pub(super) const MARGIN: f64 = 30.0;
/// Longest bar of length, points.
const BAR: f64 = 120.0;
/// Curve points of one pair of teeth.
const PAIRS: i32 = 2;

/// Points in metres to the canvas, at one scale.
pub(super) struct Scale {
    low: [f64; 2],
    high: [f64; 2],
    scale: f64,
}

impl Scale {
    /// The scale at which points fit `width` by `height`.
    pub(super) fn of<'a>(
        points: impl Iterator<Item = &'a [f64; 2]>,
        width: f64,
        height: f64,
    ) -> Scale {
        let none = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        let (low, high) = points.fold(none, |(low, high), p| {
            (
                [0, 1].map(|k| low[k].min(p[k])),
                [0, 1].map(|k| high[k].max(p[k])),
            )
        });
        let size = [0, 1].map(|k| (high[k] - low[k]).max(f64::MIN_POSITIVE));
        Scale {
            low,
            high,
            scale: (width / size[0]).min(height / size[1]),
        }
    }

    pub(super) fn at(&self, [x, y]: [f64; 2], top: f64) -> Point2 {
        (
            MARGIN + self.scale * (x - self.low[0]),
            top + self.scale * (self.high[1] - y),
        )
    }

    pub(super) fn height(&self) -> f64 {
        self.scale * (self.high[1] - self.low[1])
    }
}

/// Draws both blanks in the plane of the axes with their teeth and pitch cones; of a hypoid pair along the common perpendicular.
pub fn draw_blanks(title: &str, file: &BevelFile) -> String {
    let (sin, cos) = file.nominal.shaft_angle.sin_cos();
    // Axis and the direction across it towards the other axis.
    let frames = [[[1.0, 0.0], [0.0, 1.0]], [[cos, sin], [sin, -cos]]];
    let place = |member: usize, [z, r]: [f64; 2]| {
        let [axis, across] = frames[member];
        [0, 1].map(|k| z * axis[k] + r * across[k])
    };
    let mut teeth: Vec<(usize, Vec<[f64; 2]>)> = Vec::new();
    let mut pitch_lines = Vec::new();
    let mut axes = Vec::new();
    for (member, of) in file.members.iter().enumerate() {
        let [[a, d], [b, c]] = of.section.corners;
        for side in [1.0, -1.0] {
            let half = |[z, r]: [f64; 2]| place(member, [z, side * r]);
            teeth.push((member, [a, b, c, d, a].map(half).to_vec()));
            let cone = [0.0, of.blank.cone_distances()[1]].map(|l| half(of.blank.on_pitch_cone(l)));
            pitch_lines.push((member, cone));
        }
        axes.push((
            member,
            [0.0, 1.25 * b[0].max(c[0])].map(|z| place(member, [z, 0.0])),
        ));
    }
    let points: Vec<[f64; 2]> = (teeth.iter().flat_map(|t| t.1.iter()))
        .chain(pitch_lines.iter().flat_map(|l| l.1.iter()))
        .chain(axes.iter().flat_map(|l| l.1.iter()))
        .copied()
        .collect();
    let scale = Scale::of(points.iter(), WIDTH - 2.0 * MARGIN, HEIGHT);
    let ink = |member: usize| [BLUE, ORANGE][member];
    render_svg(WIDTH, TOP + scale.height() + MARGIN, |canvas| {
        canvas.title(title, MARGIN);
        canvas.length_bar(scale.scale, BAR / scale.scale, (WIDTH - MARGIN, 18.0));
        key(
            canvas,
            &[("pinion", BLUE), ("gear", ORANGE), ("pitch cones", GREY)],
        );
        for (member, ends) in &axes {
            let line = ends.map(|p| scale.at(p, TOP));
            canvas.polyline(&line, ink(*member), 0.7, LineStyle::Dashed);
        }
        for (_, ends) in &pitch_lines {
            canvas.polyline(
                &ends.map(|p| scale.at(p, TOP)),
                GREY,
                0.6,
                LineStyle::Dotted,
            );
        }
        for (member, outline) in &teeth {
            let line: Vec<Point2> = outline.iter().map(|p| scale.at(*p, TOP)).collect();
            canvas.polyline(&line, ink(*member), 1.4, LineStyle::Solid);
        }
    })
}

/// Names of inks above a drawing.
pub(super) fn key(canvas: &mut Canvas, entries: &[(&str, super::svg::Colour)]) {
    let mut right = MARGIN;
    for (name, ink) in entries {
        right = canvas.key_entry((right, 36.0), name, *ink, 1.6) + 16.0;
    }
}

/// The transmission error of the leading pair and of each pair over the angle of the pinion.
pub fn te(title: &str, contact: &BevelContact) -> PlotColumn {
    let degrees = |angle: f64| angle.to_degrees();
    let (pair, path) = (&contact.pair, &contact.path);
    let leading = contact
        .points
        .iter()
        .map(|p| (degrees(p.pinion_angle), ARCSEC * p.te));
    let (angles, errors): (Vec<f64>, Vec<f64>) = leading.unzip();
    let (from, to) = match (contact.points.first(), contact.points.last()) {
        (Some(a), Some(b)) => (a.pinion_angle, b.pinion_angle),
        _ => (0.0, 0.0),
    };
    // A pair far behind the leading one is out of the picture.
    let ends = |[low, high]: [f64; 2], te: &f64| [low.min(*te), high.max(*te)];
    let [least, greatest] = errors.iter().fold([0.0; 2], ends);
    let lowest = least - 0.5 * (greatest - least);
    let (mut each_angle, mut each) = (Vec::new(), Vec::new());
    for shift in -PAIRS..=PAIRS {
        for c in &path.contacts {
            let angle = c.pinion_angle - f64::from(shift) * pair.pitch();
            let shown = (from..=to).contains(&angle);
            each_angle.push(degrees(angle.clamp(from, to)));
            let te = ARCSEC * pair.te(c, &path.reference);
            each.push(if shown && te >= lowest { te } else { f64::NAN });
        }
        each_angle.push(degrees(to));
        each.push(f64::NAN);
    }
    let axes = (
        Axis::linear("pinion angle φ₁, deg"),
        Axis::linear("transmission error, arcsec")
            .from_zero(each.iter().copied().filter(|te| te.is_finite())),
    );
    let curves = [
        ("each pair".to_string(), each_angle, each),
        ("leading pair".to_string(), angles, errors),
    ];
    PlotColumn::of_lines(title, axes, curves)
}

/// Draws the flanks that touch in axial section with path, ellipses and reference contact, toe to the left.
pub fn draw_pattern(title: &str, contact: &BevelContact, positions: usize) -> String {
    let pair = &contact.pair;
    let points = one_pitch(&contact.points, positions);
    let flat = [0, 1].map(|k| Flat::of(&pair.flanks[k].section));
    let scales = [0, 1].map(|k| {
        let corners = flat[k].corners();
        Scale::of(corners.iter(), WIDTH - 2.0 * MARGIN, PATTERN_HEIGHT)
    });
    let spacing = 46.0;
    let tops = [TOP + 14.0, TOP + 14.0 + scales[0].height() + spacing];
    let height = tops[1] + scales[1].height() + MARGIN;
    render_svg(WIDTH, height, |canvas| {
        canvas.title(title, MARGIN);
        key(
            canvas,
            &[("path", ORANGE), ("ellipses", BLUE), ("flank", BLACK)],
        );
        for k in 0..2 {
            let at = |shares: [f64; 2]| scales[k].at(flat[k].at(shares), tops[k]);
            let name = format!("{}: toe left, heel right, root below", MEMBERS[k]);
            canvas.note(&name, (MARGIN, tops[k] - 10.0), Anchor::Start);
            for point in points {
                let Some(outline) = outline(pair, point, k) else {
                    continue;
                };
                for run in inside(&outline) {
                    let line: Vec<Point2> = run.into_iter().map(at).collect();
                    canvas.polyline(&line, lighten(BLUE), 0.5, LineStyle::Solid);
                }
            }
            let path: Vec<[f64; 2]> = (contact.path.contacts.iter())
                .filter_map(|c| pair.shares(k, c))
                .collect();
            for run in inside(&path) {
                let line: Vec<Point2> = run.into_iter().map(at).collect();
                canvas.polyline(&line, ORANGE, 1.6, LineStyle::Solid);
            }
            if let Some(shares) = contact.reference_position[k] {
                canvas.fill_circle(at(shares), 3.0, BLACK);
            }
            let frame = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]].map(at);
            canvas.polyline(&frame, BLACK, 1.0, LineStyle::Solid);
        }
    })
}

/// A section with its root line level.
pub(super) struct Flat<'a> {
    section: &'a ToothSection,
    along: [f64; 2],
}

impl Flat<'_> {
    pub(super) fn of(section: &ToothSection) -> Flat<'_> {
        let [[toe, _], [heel, _]] = section.corners;
        let (dz, dr) = (heel[0] - toe[0], heel[1] - toe[1]);
        let length = f64::hypot(dz, dr);
        Flat {
            section,
            along: [dz / length, dr / length],
        }
    }

    pub(super) fn at(&self, [face, height]: [f64; 2]) -> [f64; 2] {
        let [z, r] = self.section.at(face, height);
        let [c, s] = self.along;
        [z * c + r * s, r * c - z * s]
    }

    pub(super) fn corners(&self) -> [[f64; 2]; 4] {
        [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|shares| self.at(shares))
    }
}

/// Runs of places within the flank.
fn inside(places: &[[f64; 2]]) -> Vec<Vec<[f64; 2]>> {
    let is_inside = |p: &[f64; 2]| p.iter().all(|x| (-1e-6..=1.0 + 1e-6).contains(x));
    let runs = places.split(|p| !is_inside(p));
    runs.filter(|run| run.len() > 1)
        .map(<[[f64; 2]]>::to_vec)
        .collect()
}

/// Draws the ease-off above its flank, the height exaggerated; the largest gap and those at the corners are written.
pub fn draw_ease_off(title: &str, contact: &BevelContact) -> String {
    let (grid, _) = &contact.ease_off;
    let gaps = || grid.gaps.iter().flatten().copied();
    let largest = gaps().map(f64::abs).fold(0.0, f64::max);
    let (rows, columns) = (grid.rows, grid.columns);
    /// Plan of the flank and the height of the largest gap, points.
    const PLAN: [f64; 3] = [620.0, 190.0, 170.0];
    /// Shear of the height.
    const SHEAR: f64 = 130.0;
    let bottom = TOP + PLAN[2] + PLAN[1] + 30.0;
    let at = |row: usize, column: usize, gap: f64| {
        let face = column as f64 / (columns - 1) as f64;
        let height = row as f64 / (rows - 1) as f64;
        let lift = if largest > 0.0 {
            PLAN[2] * gap / largest
        } else {
            0.0
        };
        (
            60.0 + PLAN[0] * face + SHEAR * height,
            bottom - PLAN[1] * height - lift,
        )
    };
    render_svg(WIDTH, bottom + 52.0, |canvas| {
        canvas.title(title, MARGIN);
        key(
            canvas,
            &[("conjugate pinion", LIGHT_GREY), ("cut pinion", BLUE)],
        );
        let mut line = |along: &mut dyn Iterator<Item = (usize, usize)>| {
            let cells: Vec<(usize, usize)> = along.collect();
            let base: Vec<Point2> = cells.iter().map(|(i, j)| at(*i, *j, 0.0)).collect();
            canvas.polyline(&base, LIGHT_GREY, 0.6, LineStyle::Solid);
            let values = cells.iter().map(|(i, j)| {
                let gap = grid.gaps[i * columns + j]?;
                Some(at(*i, *j, gap))
            });
            let values: Vec<Option<Point2>> = values.collect();
            for run in values.split(Option::is_none) {
                let run: Vec<Point2> = run.iter().flatten().copied().collect();
                canvas.polyline(&run, BLUE, 0.9, LineStyle::Solid);
            }
        };
        for i in 0..rows {
            line(&mut (0..columns).map(move |j| (i, j)));
        }
        for j in 0..columns {
            line(&mut (0..rows).map(move |i| (i, j)));
        }
        let corners = [
            (0, 0, "toe, root"),
            (0, columns - 1, "heel, root"),
            (rows - 1, 0, "toe, tip"),
            (rows - 1, columns - 1, "heel, tip"),
        ];
        for (i, j, name) in corners {
            let Some(gap) = grid.gaps[i * columns + j] else {
                continue;
            };
            let (x, y) = at(i, j, gap);
            let below = if i == 0 { 14.0 } else { -12.0 };
            canvas.label(
                &format!("{name}: {:.1} µm", 1e6 * gap),
                (x, y + below),
                Anchor::Middle,
            );
        }
        let note = "ease-off: gap of the cut pinion from the pinion conjugate to the gear, along its normals";
        canvas.note(note, (60.0, bottom + 40.0), Anchor::Start);
    })
}
