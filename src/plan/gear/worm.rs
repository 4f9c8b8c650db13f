//! A worm pair: geometry, lines of contact on the wheel, limits of both kinds.

use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::LazyLock;

use super::axodes;
use super::geometry::{Quantities, QuantityUnit};
use super::sheet::{GearSheet, SheetPlot, table};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::gear::helicoid::axial_profile::Helicoid;
use crate::gear::helicoid::worm_pair::{WormContact, WormPair};
use crate::gear::helicoid::worm_thread::FlankType;
use crate::gear::helicoid::worm_zone::{ContactLine, WormZone};
use crate::plan::decision::StageDecision;
use crate::scene::worm_file::WormFile;

/// Lines of contact in a pitch.
const LINES: u32 = 4;
/// Steps of the profile shift in the search for a wheel without undercut.
const SHIFT_STEP: f64 = 0.05;
/// Every so many points of a line are tried for interference.
const TRIED: usize = 8;
/// Depth of interference that is not mentioned, in modules: below what a measuring machine shows.
const SLIGHT: f64 = 1e-5;
/// Largest profile shift tried.
const LARGEST_SHIFT: f64 = 2.0;

/// Computes what the file determines.
///
/// # Errors
/// Flanks that do not reach the zone of contact; a worm and a wheel that never touch.
pub fn run(file: &WormFile) -> Result<GearSheet, Error> {
    let located = |error: Error| error.with_span(&file.span);
    let pair = WormPair {
        worm: flank(file).map_err(located)?,
        ratio: f64::from(file.thread.starts) / f64::from(file.teeth),
        centre_distance: file.centre_distance(),
    };
    let zone = file.zone();
    let never = || {
        let message =
            "the worm does not touch the wheel within length, face width and tip diameters";
        let hint = "increase length or face_width, or check tip_diameter";
        located(Error::new(Code::OutOfRange, message).with_hint(hint))
    };
    let turns = zone.turns(&pair).ok_or_else(never)?;
    let pitch = TAU / f64::from(file.thread.starts);
    let lines = zone.lines(&pair, turns, pitch / f64::from(LINES));
    let undercut = zone.undercut(&pair);
    let second = zone.second_limit(&pair);
    let contact_ratio = (turns[1] - turns[0]) / pitch;
    let cut_away = (!undercut.is_empty()).then(|| undercut_warning(file, &pair, &undercut));
    let cut_into = interference(file, &pair, &zone, &lines, turns);
    let interrupted = (contact_ratio < 1.0).then(|| Diagnostic {
        code: "contact-ratio",
        message: format!("the contact ratio is {contact_ratio:.4}: the contact is interrupted"),
        hint: Some("increase length, face_width or the tip diameters".into()),
    });
    let y = |contact: &WormContact| file.hand * contact.from_wheel.y;
    let place = |c: &WormContact| (1e3 * y(c), 1e3 * c.wheel_radius());
    let mut curves: Vec<(String, Vec<f64>, Vec<f64>)> = lines
        .iter()
        .map(|line| {
            let gap = (f64::NAN, f64::NAN);
            let pieces = line.pieces(zone.radii[0]);
            let (x, y) = (pieces.flat_map(|piece| piece.iter().map(place).chain([gap]))).unzip();
            (
                format!("φ {:.0}°", line.worm_turn.to_degrees()).replace('-', "−"),
                x,
                y,
            )
        })
        .collect();
    for (name, points) in [("undercut", &undercut), ("second limit", &second)] {
        if !points.is_empty() {
            let (x, y) = points.iter().map(place).unzip();
            curves.push((name.to_string(), x, y));
        }
    }
    let row = |c: &WormContact| {
        let again = pair.second_contact(c).filter(|again| zone.holds(again));
        [
            c.worm_turn.to_degrees(),
            1e3 * c.radius,
            1e3 * c.from_wheel.z,
            1e3 * y(c),
            1e3 * c.wheel_radius(),
            c.lubrication_angle().to_degrees(),
            1e3 * c.sliding,
            1e-3 * c.relative_curvature().abs(),
            again.map_or(f64::NAN, |c| c.worm_turn.to_degrees()),
        ]
    };
    let heads = [
        ("worm turn", "deg"),
        ("worm radius", "mm"),
        ("z worm", "mm"),
        ("y wheel", "mm"),
        ("wheel radius", "mm"),
        ("line to sliding", "deg"),
        ("sliding", "mm/rad"),
        ("relative curvature", "1/mm"),
        ("second contact", "deg"),
    ];
    let contacts = lines.iter().flat_map(|line| &line.points).map(row);
    let mut tables = vec![table("contact", heads, contacts)];
    for (name, points) in [("undercut", &undercut), ("second limit", &second)] {
        if !points.is_empty() {
            let mut rows: Vec<[f64; 9]> = points.iter().map(row).collect();
            if name == "undercut" {
                // The flank is singular there: its curvature has no bound.
                rows.iter_mut().for_each(|row| row[7] = f64::NAN);
            }
            tables.push(table(name, heads, rows));
        }
    }
    let reach = [-0.5, 0.5].map(|share| share * file.length);
    Ok(GearSheet {
        title: file.title.clone(),
        kind: "worm",
        what: "worm and wheel",
        teeth: Some([file.thread.starts, file.teeth]),
        members: ["worm", "wheel"],
        quantities: quantities(file, &pair, contact_ratio).0,
        tables,
        plots: [SheetPlot {
            suffix: "",
            axes: ["along the wheel's axis y, mm", "radius on the wheel, mm"],
            equal_scales: true,
            curves,
            labels: Vec::new(),
        }]
        .into_iter()
        .chain(axodes::picture(
            &axodes::worm_axes(pair.centre_distance, pair.ratio),
            reach,
        ))
        .collect(),
        in_space: {
            let (teeth, hand) = ([file.thread.starts, file.teeth], file.hand);
            let turning = move || Some(pair.turning_pair(&zone, teeth)?.of_hand(hand));
            LazyLock::new(Box::new(turning))
        },
        plan: plan(file),
        diagnostics: (cut_away.into_iter())
            .chain(cut_into)
            .chain(interrupted)
            .collect(),
        source: file.source.clone(),
    })
}

/// The flank of the worm; it passes z = 0 on the reference cylinder.
fn flank(file: &WormFile) -> Result<Helicoid, Error> {
    let flank = file.thread.helicoid();
    let flank = flank.and_then(|h| h.through(file.thread.reference_radius(), 0.0));
    let tip = 0.5 * file.tip_diameters[0];
    let lowest = file.centre_distance() - 0.5 * file.tip_diameters[1];
    let missed = |radius: f64| {
        let message = format!(
            "the flank of the worm does not reach a radius of {:.3} mm",
            1e3 * radius
        );
        let hint = match file.thread.flank {
            FlankType::Zi => format!(
                "its base radius is {:.3} mm: reduce the throat diameter, or take fewer starts",
                1e3 * file.thread.base_radius()
            ),
            _ => "the grinding wheel ends above it: take a smaller tool_radius or fewer starts"
                .into(),
        };
        Error::new(Code::OutOfRange, message).with_hint(hint)
    };
    let flank = flank.ok_or_else(|| missed(file.thread.reference_radius()))?;
    match [lowest, tip].into_iter().find(|r| flank.at(*r).is_none()) {
        Some(radius) => Err(missed(radius)),
        None => Ok(flank),
    }
}

/// The deepest cut of the worm, at other turns, into the flank that it leaves.
fn interference(
    file: &WormFile,
    pair: &WormPair,
    zone: &WormZone,
    lines: &[ContactLine],
    turns: [f64; 2],
) -> Option<Diagnostic> {
    let module = file.thread.module;
    let tried = lines
        .iter()
        .flat_map(|line| line.points.iter().step_by(TRIED));
    let limits = [FRAC_PI_2 * module, SLIGHT * module];
    let cut = zone.interference(pair, tried, turns, limits)?;
    Some(Diagnostic {
        code: "interference",
        message: format!(
            "the worm cuts up to {:.1} µm into the flank that it has generated, at a wheel radius of {:.3} mm and y = {:+.3} mm",
            1e6 * cut.depth,
            1e3 * cut.contact.wheel_radius(),
            1e3 * file.hand * cut.contact.from_wheel.y
        ),
        hint: Some(
            "take a larger profile_shift, a larger pressure angle or a smaller face_width".into(),
        ),
    })
}

fn undercut_warning(file: &WormFile, pair: &WormPair, limit: &[WormContact]) -> Diagnostic {
    let highest = limit.iter().map(WormContact::wheel_radius);
    let highest = highest.fold(0.0, f64::max);
    let steps = ((LARGEST_SHIFT - file.profile_shift) / SHIFT_STEP)
        .floor()
        .max(0.0) as u32;
    let step = file.thread.module * SHIFT_STEP;
    let moves = (1..=steps).map(|k| step * f64::from(k));
    let free = file.zone().free_of_undercut(pair, moves);
    Diagnostic {
        code: "undercut",
        message: format!(
            "the wheel is undercut up to a radius of {:.3} mm: the worm removes flank that it has generated",
            1e3 * highest
        ),
        hint: Some(match free {
            Some(by) => format!(
                "take profile_shift = {:.2} or more, a larger pressure angle or more teeth",
                file.profile_shift + by / file.thread.module
            ),
            None => "take a larger pressure angle or more teeth".into(),
        }),
    }
}

fn quantities(file: &WormFile, pair: &WormPair, contact_ratio: f64) -> Quantities {
    use QuantityUnit::{Degree, Millimetre, One};
    let thread = &file.thread;
    let nothing = f64::NAN;
    let mut all = Quantities::default();
    let counts = [f64::from(thread.starts), f64::from(file.teeth)];
    all.each("starts, teeth", "z", One, counts);
    let module = thread.module;
    let references = [2.0 * thread.reference_radius(), module * counts[1]];
    all.each("reference diameter", "d", Millimetre, references);
    let pitch = [
        2.0 * pair.worm_pitch_radius(),
        2.0 * pair.wheel_pitch_radius(),
    ];
    all.each("working pitch diameter", "d_w", Millimetre, pitch);
    all.each(
        "tip diameter, throat",
        "d_a",
        Millimetre,
        file.tip_diameters,
    );
    let outer = [nothing, file.outer_diameter];
    all.each("outer diameter", "d_e", Millimetre, outer);
    let base = match thread.flank {
        FlankType::Zi => 2.0 * thread.base_radius(),
        _ => nothing,
    };
    all.each("base diameter", "d_b", Millimetre, [base, nothing]);
    all.each(
        "length, face width",
        "b",
        Millimetre,
        [file.length, file.face_width],
    );
    all.pair("centre distance", "a", Millimetre, pair.centre_distance);
    all.pair("ratio", "u", One, 1.0 / pair.ratio);
    all.pair("axial module", "m", Millimetre, module);
    all.pair("lead", "p_z", Millimetre, TAU * thread.lead());
    all.pair("lead angle", "γ", Degree, thread.lead_angle());
    all.pair(
        "axial pressure angle",
        "α_x",
        Degree,
        thread.axial_pressure_angle(),
    );
    all.pair("contact ratio", "ε", One, contact_ratio);
    axodes::quantities(
        &axodes::worm_axes(pair.centre_distance, pair.ratio),
        &mut all,
    );
    all
}

/// The stages that run, and those left out with the reason.
pub fn plan(file: &WormFile) -> Vec<(&'static str, StageDecision)> {
    let runs = |what: &str| StageDecision::Runs(what.into());
    let leaves = |why: &str| StageDecision::LeftOut(why.into());
    let mut plan = vec![("geometry", runs("worm and wheel at 90°"))];
    if !file.defaults.is_empty() {
        plan.push(("defaults", StageDecision::Runs(file.defaults.join("; "))));
    }
    plan.extend([
        (
            "flanks",
            runs("the wheel is the envelope of the worm; both flanks are mirror images"),
        ),
        ("limits", runs("limits of the first and second kind on the wheel, second contacts, interference at every turn of the worm")),
        (
            "contact",
            runs("lines of contact, angle to sliding, relative curvature; the transmission error of a conjugate pair is zero"),
        ),
        ("errors of assembly", leaves("contact of a worm with a displaced wheel is not computed")),
        ("mesh", leaves("the load on lines of contact of a worm is not computed")),
        ("strength rating", leaves("geardyn rates no load capacity")),
    ]);
    plan
}
