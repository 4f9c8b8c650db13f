//! A plane double-enveloping worm pair: geometry, both lines of contact, the curve between both parts of the tooth, undercut of the worm.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::axodes;
use super::geometry::{Quantities, QuantityUnit};
use super::sheet::{GearSheet, SheetPlot, SheetTable, table};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::gear::helicoid::plane_worm::{PlaneWorm, PlaneWormContact};
use crate::gear::helicoid::plane_worm_interference::GeneratingPlane;
use crate::plan::decision::StageDecision;
use crate::scene::plane_worm_file::PlaneWormFile;

/// Positions of the wheel in a pitch at which the lines are computed.
const LINES: u32 = 2;
/// Most positions of the wheel.
const MOST_POSITIONS: f64 = 16.0;
/// Points of a line across the tooth.
const ROWS: u32 = 120;
/// Points across the tooth in the search for the zone of contact.
const COARSE_ROWS: u32 = 40;
/// Turns of the wheel each way, over 90°, at which the zone of contact is sought.
const TURNS: i32 = 360;

/// Computes what the file determines.
///
/// # Errors
/// A worm and a wheel that never touch.
pub fn run(file: &PlaneWormFile) -> Result<GearSheet, Error> {
    let pair = &file.pair;
    let turns = turns(file).ok_or_else(|| {
        let message =
            "the plane does not touch the worm within length, face_width and tip diameters";
        let hint = "increase length or face_width, or check tip_diameter and base_radius";
        Error::new(Code::OutOfRange, message)
            .with_span(&file.span)
            .with_hint(hint)
    })?;
    let pitch = TAU / f64::from(file.teeth[1]);
    let step = pitch / f64::from(LINES);
    let step = step
        * ((turns[1] - turns[0]) / (MOST_POSITIONS * step))
            .ceil()
            .max(1.0);
    let positions: Vec<f64> = ((turns[0] / step).ceil() as i64..=(turns[1] / step).floor() as i64)
        .map(|k| k as f64 * step)
        .collect();
    let [first, second] = [first_line, second_line]
        .map(|line| -> Vec<Line> { positions.iter().map(|turn| line(file, *turn)).collect() });
    let limit = limit(file, turns);
    let undercut: Vec<PlaneWormContact> = positions
        .iter()
        .filter_map(|t| undercut(file, *t))
        .collect();
    let contact_ratio = (turns[1] - turns[0]) / pitch;
    let mut diagnostics: Vec<Diagnostic> = undercut_warning(&undercut).into_iter().collect();
    diagnostics.extend(interference(file, [&first, &second], turns));
    diagnostics.extend((contact_ratio < 1.0).then(|| Diagnostic {
        code: "contact-ratio",
        message: format!("the contact ratio is {contact_ratio:.4}: the contact is interrupted"),
        hint: Some("increase length, face_width or the tip diameters".into()),
    }));
    let mut tables = vec![contacts(file, "contact", first.iter().flatten())];
    for (name, points) in [
        (
            "second contact",
            second.iter().flatten().collect::<Vec<_>>(),
        ),
        ("curve between both parts", limit.iter().collect()),
        ("undercut", undercut.iter().collect()),
    ] {
        if !points.is_empty() {
            tables.push(contacts(file, name, points));
        }
    }
    let axes = axodes::worm_axes(pair.centre_distance, pair.ratio);
    let mut plots = vec![lines_plot(file, &positions, [&first, &second], &limit)];
    plots.extend(axodes::picture(
        &axes,
        [-0.5, 0.5].map(|share| share * file.length),
    ));
    Ok(GearSheet {
        title: file.title.clone(),
        kind: "worm",
        what: "plane double-enveloping worm and wheel",
        teeth: Some(file.teeth),
        members: ["worm", "wheel"],
        quantities: quantities(file, contact_ratio, turns).0,
        tables,
        plots,
        plan: plan(file),
        diagnostics,
        source: file.source.clone(),
    })
}

/// Points of one line of contact.
type Line = Vec<PlaneWormContact>;

/// Whether a contact lies on worm and wheel; the tip of the worm is a torus about the axis of the wheel.
fn reaches(file: &PlaneWormFile, contact: &PlaneWormContact) -> bool {
    let (a, [worm_tip, wheel_tip]) = (file.pair.centre_distance, file.tip_diameters);
    let from_worm = f64::hypot(contact.point.x, contact.point.y);
    let torus = f64::hypot(a - from_worm, contact.point.z);
    contact.point.z.abs() <= 0.5 * file.length
        && contact.point.y.abs() <= 0.5 * file.face_width
        && torus >= a - 0.5 * worm_tip
        && wheel_radius(contact) <= 0.5 * wheel_tip
}

fn wheel_radius(contact: &PlaneWormContact) -> f64 {
    f64::hypot(contact.in_wheel.x, contact.in_wheel.z)
}

/// Depth of interference that is not mentioned, in centre distances: 0.1 µm at 100 mm.
const SLIGHT: f64 = 1e-6;
/// Every so many points of a line are tried for interference.
const TRIED: usize = 16;

/// The deepest cut of the worm into the tooth whose flank the lines of contact give.
fn interference(file: &PlaneWormFile, lines: [&[Line]; 2], turns: [f64; 2]) -> Option<Diagnostic> {
    let plane = GeneratingPlane {
        face_width: file.face_width,
        tip_radius: 0.5 * file.tip_diameters[1],
    };
    let points = (lines.into_iter().flatten())
        .flat_map(|line| line.iter().step_by(TRIED))
        .map(|c| c.in_wheel);
    let slight = SLIGHT * file.pair.centre_distance;
    let cut = file.pair.interference(&plane, points, turns, slight)?;
    Some(Diagnostic {
        code: "interference",
        message: format!(
            "the worm cuts up to {:.1} µm into the tooth at a wheel radius of {:.3} mm and y = {:+.3} mm",
            1e6 * cut.depth,
            1e3 * f64::hypot(cut.in_wheel.x, cut.in_wheel.z),
            1e3 * file.hand * cut.in_wheel.y
        ),
        hint: Some(
            "take a smaller length of the worm, a larger plane_angle or a smaller face_width"
                .into(),
        ),
    })
}

/// Places across the tooth.
fn across(file: &PlaneWormFile, rows: u32) -> impl Iterator<Item = f64> + use<> {
    let half = 0.5 * file.face_width;
    (0..=rows).map(move |k| half * (2.0 * f64::from(k) / f64::from(rows) - 1.0))
}

/// First and last turn of the wheel at which the plane touches on worm and wheel; D > 0 where the worm has a flank.
fn turns(file: &PlaneWormFile) -> Option<[f64; 2]> {
    let places = (-TURNS..=TURNS).map(|k| FRAC_PI_2 * f64::from(k) / f64::from(TURNS));
    let touching = places.filter(|turn| {
        let mut contacts =
            across(file, COARSE_ROWS).filter_map(|eta| file.pair.first_contact(*turn, eta));
        contacts.any(|c| c.relative_curvature < 0.0 && reaches(file, &c))
    });
    touching.fold(None, |range: Option<[f64; 2]>, turn| {
        let [first, last] = range.unwrap_or([turn; 2]);
        Some([first.min(turn), last.max(turn)])
    })
}

fn first_line(file: &PlaneWormFile, turn: f64) -> Line {
    let contacts = across(file, ROWS).filter_map(|eta| file.pair.first_contact(turn, eta));
    let carries = |c: &PlaneWormContact| c.relative_curvature < 0.0 && reaches(file, c);
    contacts.filter(carries).collect()
}

/// The second line: real where wheel and worm touch from outside, as at the first.
fn second_line(file: &PlaneWormFile, turn: f64) -> Line {
    let contacts = across(file, ROWS).flat_map(|eta| file.pair.second_contacts(turn, eta));
    let carries = |c: &PlaneWormContact| c.relative_curvature < 0.0 && reaches(file, c);
    let mut line: Line = contacts.filter(carries).collect();
    line.sort_by(|a, b| a.in_wheel.y.total_cmp(&b.in_wheel.y));
    line
}

/// The curve between the plane part and the enveloped part.
fn limit(file: &PlaneWormFile, turns: [f64; 2]) -> Line {
    let places =
        (0..=ROWS).map(|k| turns[0] + (turns[1] - turns[0]) * f64::from(k) / f64::from(ROWS));
    let contacts = places.filter_map(|turn| {
        let [_, eta] = file.pair.limit(turn)?;
        file.pair.first_contact(turn, eta)
    });
    contacts.filter(|c| reaches(file, c)).collect()
}

/// The worm's edge of regression on a line, where it lies on the teeth.
fn undercut(file: &PlaneWormFile, turn: f64) -> Option<PlaneWormContact> {
    let half = 0.5 * file.face_width;
    let eta = file.pair.undercut(turn, [-half, half])?;
    file.pair
        .first_contact(turn, eta)
        .filter(|c| reaches(file, c))
}

fn undercut_warning(points: &[PlaneWormContact]) -> Option<Diagnostic> {
    let from_worm = |c: &PlaneWormContact| f64::hypot(c.point.x, c.point.y);
    let highest = points
        .iter()
        .max_by(|a, b| from_worm(a).total_cmp(&from_worm(b)))?;
    Some(Diagnostic {
        code: "undercut",
        message: format!(
            "the worm is undercut up to {:.3} mm from its axis at {:+.3} mm along it: its flank ends in an edge of regression",
            1e3 * from_worm(highest),
            1e3 * highest.point.z
        ),
        hint: Some(
            "take a smaller length of the worm, a larger plane_angle or a larger base_radius"
                .into(),
        ),
    })
}

fn contacts<'a>(
    file: &PlaneWormFile,
    name: &'static str,
    points: impl IntoIterator<Item = &'a PlaneWormContact>,
) -> SheetTable {
    let heads = [
        ("wheel turn", "deg"),
        ("y wheel", "mm"),
        ("wheel radius", "mm"),
        ("worm radius", "mm"),
        ("z worm", "mm"),
        ("height over the plane", "mm"),
        ("line to sliding", "deg"),
        ("sliding", "mm/rad"),
        ("relative curvature", "1/mm"),
    ];
    let rows = points.into_iter().map(|c| {
        [
            c.wheel_turn.to_degrees(),
            1e3 * file.hand * c.in_wheel.y,
            1e3 * wheel_radius(c),
            1e3 * f64::hypot(c.point.x, c.point.y),
            1e3 * c.point.z,
            1e3 * c.height,
            c.lubrication_angle.to_degrees(),
            1e3 * c.sliding,
            1e-3 * c.relative_curvature.abs(),
        ]
    });
    table(name, heads, rows)
}

/// Both lines of contact on the tooth of the wheel with the curve between its parts.
fn lines_plot(
    file: &PlaneWormFile,
    positions: &[f64],
    [first, second]: [&[Line]; 2],
    limit: &[PlaneWormContact],
) -> SheetPlot {
    let curve = |name: String, points: &[PlaneWormContact]| {
        let places = points.iter();
        let (x, y) = places
            .map(|c| (1e3 * file.hand * c.in_wheel.y, 1e3 * wheel_radius(c)))
            .unzip();
        (name, x, y)
    };
    let mut curves = Vec::new();
    for (k, turn) in positions.iter().enumerate() {
        for (name, line) in [("first", &first[k]), ("second", &second[k])] {
            if line.len() > 1 {
                curves.push(curve(format!("{name}, {:.1}°", turn.to_degrees()), line));
            }
        }
    }
    if !limit.is_empty() {
        curves.push(curve("curve between both parts".into(), limit));
    }
    SheetPlot {
        suffix: "",
        axes: ["along the wheel's axis y [mm]", "radius on the wheel [mm]"],
        equal_scales: true,
        curves,
    }
}

fn quantities(file: &PlaneWormFile, contact_ratio: f64, turns: [f64; 2]) -> Quantities {
    use QuantityUnit::{Degree, Millimetre, One};
    let PlaneWorm {
        centre_distance,
        ratio,
        base_radius,
        plane_angle,
    } = file.pair;
    let mut all = Quantities::default();
    all.each("starts, teeth", "z", One, file.teeth.map(f64::from));
    all.each(
        "tip diameter, throat",
        "d_a",
        Millimetre,
        file.tip_diameters,
    );
    let widths = [file.length, file.face_width];
    all.each("length, face width", "b", Millimetre, widths);
    all.pair("centre distance", "a", Millimetre, centre_distance);
    all.pair("ratio", "u", One, 1.0 / ratio);
    all.pair(
        "base circle radius of the plane",
        "r_b",
        Millimetre,
        base_radius,
    );
    all.pair("inclination of the plane", "β", Degree, plane_angle);
    all.pair("contact ratio", "ε", One, contact_ratio);
    all.pair("first contact, turn of the wheel", "φ_2", Degree, turns[0]);
    all.pair("last contact, turn of the wheel", "φ_2e", Degree, turns[1]);
    axodes::quantities(&axodes::worm_axes(centre_distance, ratio), &mut all);
    all
}

/// The stages that run, and those left out with the reason.
pub fn plan(file: &PlaneWormFile) -> Vec<(&'static str, StageDecision)> {
    let runs = |what: &str| StageDecision::Runs(what.into());
    let leaves = |why: &str| StageDecision::LeftOut(why.into());
    let mut plan = vec![(
        "geometry",
        runs("hourglass worm generated by a plane, wheel at 90°"),
    )];
    if !file.defaults.is_empty() {
        plan.push(("defaults", StageDecision::Runs(file.defaults.join("; "))));
    }
    plan.extend([
        (
            "flanks",
            runs("plane part and enveloped part of the wheel's tooth; both flanks are mirror images"),
        ),
        ("limits", runs("curve between both parts, edge of regression of the worm, interference at every turn")),
        (
            "contact",
            runs("first and second line of contact, angle to sliding, relative curvature; the transmission error of a conjugate pair is zero"),
        ),
        ("errors of assembly", leaves("contact of a displaced worm is not computed")),
        ("mesh", leaves("the load on lines of contact of a worm is not computed")),
        ("strength rating", leaves("geardyn rates no load capacity")),
    ]);
    plan
}
