//! A plane double-enveloping worm pair: geometry, both lines of contact, the curve between both parts of the tooth, undercut of the worm.

use std::f64::consts::TAU;
use std::sync::LazyLock;

use super::axodes;
use super::geometry::{Quantities, QuantityUnit};
use super::sheet::{GearSheet, SheetPlot, SheetTable, table};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::gear::helicoid::plane_worm::{PlaneWorm, PlaneWormContact};
use crate::gear::helicoid::plane_worm_zone::PlaneWormZone;
use crate::plan::decision::StageDecision;
use crate::scene::plane_worm_file::PlaneWormFile;

/// Positions of the wheel in a pitch at which the lines are computed.
const LINES: u32 = 2;
/// Most positions of the wheel.
const MOST_POSITIONS: f64 = 16.0;

/// Computes what the file determines.
///
/// # Errors
/// A worm and a wheel that never touch.
pub fn run(file: &PlaneWormFile) -> Result<GearSheet, Error> {
    let pair = &file.pair;
    let zone = file.zone();
    let turns = zone.turns(pair).ok_or_else(|| {
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
    let lines: Vec<[Line; 2]> = positions
        .iter()
        .map(|turn| [zone.first_line(pair, *turn), zone.second_line(pair, *turn)])
        .collect();
    let of = |k: usize| lines.iter().flat_map(move |both| &both[k]);
    let limit = zone.limit(pair, turns);
    let undercut: Vec<PlaneWormContact> = positions
        .iter()
        .filter_map(|turn| zone.undercut(pair, *turn))
        .collect();
    let contact_ratio = (turns[1] - turns[0]) / pitch;
    let mut diagnostics: Vec<Diagnostic> = undercut_warning(&undercut).into_iter().collect();
    diagnostics.extend(interference(file, &zone, &lines, turns));
    diagnostics.extend((contact_ratio < 1.0).then(|| Diagnostic {
        code: "contact-ratio",
        message: format!("the contact ratio is {contact_ratio:.4}: the contact is interrupted"),
        hint: Some("increase length, face_width or the tip diameters".into()),
    }));
    let mut tables = vec![contacts(file, "contact", of(0))];
    for (name, points) in [
        ("second contact", of(1).collect::<Vec<_>>()),
        ("curve between both parts", limit.iter().collect()),
        ("undercut", undercut.iter().collect()),
    ] {
        if !points.is_empty() {
            tables.push(contacts(file, name, points));
        }
    }
    let axes = axodes::worm_axes(pair.centre_distance, pair.ratio);
    let mut plots = vec![lines_plot(file, &positions, &lines, &limit)];
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
        in_space: {
            let (pair, teeth, hand) = (*pair, file.teeth, file.hand);
            let turning = move || Some(pair.turning_pair(&zone, teeth)?.of_hand(hand));
            LazyLock::new(Box::new(turning))
        },
        plan: plan(file),
        diagnostics,
        source: file.source.clone(),
    })
}

/// Points of one line of contact.
type Line = Vec<PlaneWormContact>;

/// Depth of interference that is not mentioned, in centre distances: 0.1 µm at 100 mm.
const SLIGHT: f64 = 1e-6;
/// Every so many points of a line are tried for interference.
const TRIED: usize = 16;

/// The deepest cut of the worm into the tooth whose flank the lines of contact give.
fn interference(
    file: &PlaneWormFile,
    zone: &PlaneWormZone,
    lines: &[[Line; 2]],
    turns: [f64; 2],
) -> Option<Diagnostic> {
    let points = (lines.as_flattened().iter())
        .flat_map(|line| line.iter().step_by(TRIED))
        .map(|c| c.in_wheel);
    let slight = SLIGHT * file.pair.centre_distance;
    let cut = file.pair.interference(zone, points, turns, slight)?;
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

fn undercut_warning(points: &[PlaneWormContact]) -> Option<Diagnostic> {
    let highest = points
        .iter()
        .max_by(|a, b| a.worm_radius().total_cmp(&b.worm_radius()))?;
    Some(Diagnostic {
        code: "undercut",
        message: format!(
            "the worm is undercut up to {:.3} mm from its axis at {:+.3} mm along it: its flank ends in an edge of regression",
            1e3 * highest.worm_radius(),
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
            1e3 * c.wheel_radius(),
            1e3 * c.worm_radius(),
            1e3 * c.point.z,
            1e3 * c.height,
            c.lubrication_angle().to_degrees(),
            1e3 * c.sliding,
            1e-3 * c.relative_curvature.abs(),
        ]
    });
    table(name, heads, rows)
}

/// Both lines of contact on the tooth of the wheel at each turn, named by it at the tip, with the curve between its parts.
fn lines_plot(
    file: &PlaneWormFile,
    positions: &[f64],
    lines: &[[Line; 2]],
    limit: &[PlaneWormContact],
) -> SheetPlot {
    let place = |c: &PlaneWormContact| [1e3 * file.hand * c.in_wheel.y, 1e3 * c.wheel_radius()];
    let curve = |name: &str, lines: &mut dyn Iterator<Item = &[PlaneWormContact]>| {
        let gap = [[f64::NAN; 2]];
        let places = lines.flat_map(|line| line.iter().map(place).chain(gap));
        let (x, y): (Vec<f64>, Vec<f64>) = places.map(|[x, y]| (x, y)).unzip();
        (name.to_string(), x, y)
    };
    let both = ["first line of contact", "second line of contact"];
    let mut curves = Vec::new();
    for (k, name) in both.into_iter().enumerate() {
        curves.push(curve(name, &mut lines.iter().map(|l| l[k].as_slice())));
    }
    curves.push(curve("curve between both parts", &mut [limit].into_iter()));
    curves.retain(|(_, x, _)| x.len() > 1);
    let tip = |(turn, both): (&f64, &[Line; 2])| {
        let highest = |line: &Line| {
            let tip = (line.iter()).max_by(|a, b| a.wheel_radius().total_cmp(&b.wheel_radius()))?;
            Some((place(tip), format!("{:.1}°", turn.to_degrees())))
        };
        both.each_ref().map(highest)
    };
    let tips = positions.iter().zip(lines).flat_map(tip);
    SheetPlot {
        suffix: "",
        axes: ["along the wheel's axis y, mm", "radius on the wheel, mm"],
        equal_scales: true,
        curves,
        labels: tips.flatten().collect(),
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
