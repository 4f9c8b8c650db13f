//! A crossed helical pair: geometry, path of contact, ellipse, backlash, limits.

use std::sync::LazyLock;

use super::axodes;
use super::geometry::{Quantities, QuantityUnit};
use super::sheet::{GearSheet, SheetPlot, table};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::gear::helicoid::crossed_pair::{CrossedPair, CrossedPath};
use crate::gear::kernel::crossed_axes::CrossedAxes;
use crate::plan::decision::StageDecision;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::crossed_file::CrossedFile;

/// Points of the path of contact.
const POINTS: u32 = 20;
/// Backlash below zero by less than this is rounding of the data, m.
const ROUNDING: f64 = 1e-6;
/// Depth of interference that is not mentioned, in centre distances: 0.1 µm at 100 mm.
const SLIGHT: f64 = 1e-6;

/// Computes what the file determines.
///
/// # Errors
/// Gears that never touch.
pub fn run(file: &CrossedFile) -> Result<GearSheet, Error> {
    let pair = &file.pair;
    let path = pair.path().ok_or_else(|| {
        let message = "the base helices have no common normal at this shaft angle";
        Error::new(Code::OutOfRange, message).with_span(&file.span)
    })?;
    let [first, last] = path.ends_on_flanks();
    if !(last > first) {
        let message = format!(
            "the tips of the gears do not touch: the contact would end {:.3} mm before it begins",
            1e3 * (first - last)
        );
        return Err(Error::new(Code::OutOfRange, message)
            .with_span(&file.span)
            .with_hint("check hands and shaft_angle (helix angles of one hand add up to it, those of opposite hands subtract), increase tip_diameter, or reduce centre_distance"));
    }
    let backlash = pair.normal_backlash();
    let pitch_place = pair.pitch_place(&path);
    let places = (0..=POINTS).map(|k| first + (last - first) * f64::from(k) / f64::from(POINTS));
    let rows: Vec<[f64; 9]> = places
        .filter_map(|place| {
            let contact = pair.contact(&path, place)?;
            let [long, short] = contact.ellipse(file.coating);
            Some([
                ((place - pitch_place) / path.advance).to_degrees(),
                1e3 * contact.point.x,
                1e3 * file.mirror * contact.point.y,
                1e3 * contact.point.z,
                1e3 * contact.radii[0],
                1e3 * contact.radii[1],
                1e3 * long,
                1e3 * short,
                1e3 * contact.sliding,
            ])
        })
        .collect();
    let heads = [
        ("pinion angle", "deg"),
        ("x", "mm"),
        ("y", "mm"),
        ("z", "mm"),
        ("curvature radius pinion", "mm"),
        ("curvature radius gear", "mm"),
        ("ellipse long", "mm"),
        ("ellipse short", "mm"),
        ("sliding", "mm/rad"),
    ];
    let column = |k: usize| -> Vec<f64> { rows.iter().map(|row| row[k]).collect() };
    let mut plots = vec![SheetPlot {
        suffix: "",
        axes: ["angle of the pinion, deg", "semi-axis of the ellipse, mm"],
        equal_scales: false,
        curves: vec![
            ("long".into(), column(0), column(6)),
            ("short".into(), column(0), column(7)),
        ],
        labels: Vec::new(),
    }];
    let reach = pair.gears[1].radius;
    plots.extend(axodes::picture(&axes(pair), [-reach, reach]));
    Ok(GearSheet {
        title: file.title.clone(),
        kind: "crossed",
        what: "crossed helical gears",
        teeth: Some(file.gears.map(|gear| gear.teeth)),
        members: MEMBERS,
        quantities: quantities(file, &path, backlash).0,
        tables: vec![table("contact", heads, rows)],
        plots,
        in_space: {
            let (pair, path, widths) = (*pair, path, face_widths(file, &path));
            let (coating, mirror) = (file.coating, file.mirror);
            let turning = move || Some(pair.turning_pair(&path, widths, coating)?.of_hand(mirror));
            LazyLock::new(Box::new(turning))
        },
        plan: plan(file),
        diagnostics: warnings(file, &path, backlash),
        source: file.source.clone(),
    })
}

fn quantities(file: &CrossedFile, path: &CrossedPath, backlash: Option<f64>) -> Quantities {
    use QuantityUnit::{Degree, Millimetre, One};
    let (pair, gears) = (&file.pair, &file.gears);
    let mut all = Quantities::default();
    let of = |value: &dyn Fn(usize) -> f64| [value(0), value(1)];
    all.each(
        "number of teeth",
        "z",
        One,
        of(&|k| f64::from(gears[k].teeth)),
    );
    all.each(
        "helix angle, right hand positive",
        "β",
        Degree,
        of(&|k| gears[k].helix),
    );
    all.each(
        "profile shift coefficient",
        "x",
        One,
        of(&|k| gears[k].profile_shift),
    );
    all.each(
        "reference diameter",
        "d",
        Millimetre,
        of(&|k| gears[k].reference_diameter()),
    );
    all.each(
        "base diameter",
        "d_b",
        Millimetre,
        of(&|k| gears[k].base_diameter()),
    );
    all.each(
        "tip diameter",
        "d_a",
        Millimetre,
        of(&|k| 2.0 * pair.gears[k].tip_radius),
    );
    all.each(
        "transverse pressure angle",
        "α_t",
        Degree,
        of(&|k| gears[k].transverse_pressure_angle()),
    );
    all.each(
        "face width that the contact needs",
        "b_min",
        Millimetre,
        pair.contact_widths(path),
    );
    all.pair("normal module", "m_n", Millimetre, file.module);
    all.pair("normal pressure angle", "α_n", Degree, pair.pressure_angle);
    all.pair("shaft angle", "Σ", Degree, pair.shaft_angle);
    all.pair("centre distance", "a", Millimetre, pair.centre_distance);
    all.pair(
        "reference centre distance",
        "a_0",
        Millimetre,
        pair.reference_centre_distance(),
    );
    if let Some(tight) = pair.tight_centre_distance() {
        all.pair("centre distance without backlash", "a_t", Millimetre, tight);
    }
    if let Some(backlash) = backlash {
        all.pair("normal backlash", "j_bn", Millimetre, backlash);
    }
    all.pair("base pitch", "p_bn", Millimetre, path.base_pitch);
    all.pair("contact ratio", "ε", One, CrossedPair::contact_ratio(path));
    if let Some(contact) = pair.contact(path, pair.pitch_place(path)) {
        let [long, short] = contact.ellipse(file.coating);
        all.pair(
            "ellipse at the pitch point, long semi-axis",
            "a_e",
            Millimetre,
            long,
        );
        all.pair(
            "ellipse at the pitch point, short semi-axis",
            "b_e",
            Millimetre,
            short,
        );
        all.pair(
            "sliding at the pitch point, a radian of the pinion",
            "v_g",
            Millimetre,
            contact.sliding,
        );
    }
    axodes::quantities(&axes(pair), &mut all);
    all
}

/// Face widths: those of the file, else what the contact needs.
fn face_widths(file: &CrossedFile, path: &CrossedPath) -> [f64; 2] {
    let needed = file.pair.contact_widths(path);
    [0, 1].map(|k| file.face_widths[k].unwrap_or(needed[k]))
}

/// The axes of the pair with its ratio.
fn axes(pair: &CrossedPair) -> CrossedAxes {
    let [z1, z2] = pair.gears.each_ref().map(|g| f64::from(g.teeth));
    CrossedAxes {
        offset: pair.centre_distance,
        shaft_angle: pair.shaft_angle,
        ratio: -z1 / z2,
    }
}

fn warnings(file: &CrossedFile, path: &CrossedPath, backlash: Option<f64>) -> Vec<Diagnostic> {
    let pair = &file.pair;
    let mut all = Vec::new();
    // Each end beyond a base cylinder belongs to the tip of the other gear.
    let beyond = [path.ends[1] - path.length, -path.ends[0]];
    for k in 0..2 {
        if beyond[k] > 0.0 {
            let longest = 2e3 * pair.longest_tip_radius(path, k);
            all.push(Diagnostic {
                code: "interference",
                message: format!(
                    "the tip of the {} reaches {:.3} mm below the base cylinder of the {} along the path of contact",
                    MEMBERS[k],
                    1e3 * beyond[k],
                    MEMBERS[1 - k]
                ),
                hint: Some(format!(
                    "take tip_diameter = {:.3} mm or less for the {}",
                    (longest * 1e3).floor() / 1e3,
                    MEMBERS[k]
                )),
            });
        }
    }
    if let Some(cut) =
        pair.interference(path, face_widths(file, path), SLIGHT * pair.centre_distance)
    {
        all.push(Diagnostic {
            code: "interference",
            message: format!(
                "the flank of the gear penetrates that of the pinion by {:.1} µm at radii of {:.3} and {:.3} mm, off the path of contact",
                1e6 * cut.depth,
                1e3 * cut.radii[0],
                1e3 * cut.radii[1]
            ),
            hint: Some("take smaller face widths or tip diameters".into()),
        });
    }
    let ratio = CrossedPair::contact_ratio(path);
    if ratio < 1.0 {
        all.push(Diagnostic {
            code: "contact-ratio",
            message: format!("the contact ratio is {ratio:.4}: the contact is interrupted"),
            hint: Some("take larger tip diameters, more teeth, or smaller helix angles".into()),
        });
    }
    if backlash.is_some_and(|b| b < -ROUNDING) {
        let overlap = -1e6 * backlash.unwrap_or(0.0);
        let hint = match pair.tight_centre_distance() {
            Some(tight) => format!(
                "increase centre_distance, or `offset` in [assembly], by {:.4} mm or more",
                (1e7 * (tight - pair.centre_distance)).ceil() / 1e4
            ),
            None => "increase centre_distance".into(),
        };
        all.push(Diagnostic {
            code: "no-backlash",
            message: format!("the teeth would overlap by {overlap:.1} µm along the normal"),
            hint: Some(hint),
        });
    }
    let needed = pair.contact_widths(path);
    for k in 0..2 {
        let Some(width) = file.face_widths[k].filter(|width| *width < needed[k]) else {
            continue;
        };
        all.push(Diagnostic {
            code: "contact-ends",
            message: format!(
                "the contact extends beyond the face of the {}: it needs {:.3} mm, face_width is {:.3} mm",
                MEMBERS[k],
                1e3 * needed[k],
                1e3 * width
            ),
            hint: Some("increase face_width; the contact ratio counts the whole path".into()),
        });
    }
    all
}

/// The stages that run, and those left out with the reason.
pub fn plan(file: &CrossedFile) -> Vec<(&'static str, StageDecision)> {
    let runs = |what: &str| StageDecision::Runs(what.into());
    let leaves = |why: &str| StageDecision::LeftOut(why.into());
    let mut plan = vec![("geometry", runs("involute helical gears on crossed axes"))];
    if !file.defaults.is_empty() {
        plan.push(("defaults", StageDecision::Runs(file.defaults.join("; "))));
    }
    plan.extend([
        (
            "contact",
            runs("path of contact, ellipse, sliding; the transmission error is zero at any centre distance and shaft angle"),
        ),
        ("limits", runs("interference at both base cylinders and off the path, contact ratio, backlash, face widths")),
        ("mesh", leaves("the load on a point of contact is not computed")),
        ("strength rating", leaves("geardyn rates no load capacity")),
    ]);
    plan
}
