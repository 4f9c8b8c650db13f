//! A helical gear and its hob: profile error of the hob's flank type, the hob's flank for the exact gear, feed marks.

use std::sync::LazyLock;

use super::geometry::{Quantities, QuantityUnit};
use super::sheet::{GearSheet, SheetPlot, table};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::helicoid::hob::{HobbedPoint, Hobbing};
use crate::plan::decision::StageDecision;
use crate::scene::hob_file::HobFile;

/// Radii of the hob over its working depth.
const ROWS: u32 = 40;

/// Computes what the file determines.
///
/// # Errors
/// A hob that makes no flank of the gear.
pub fn run(file: &HobFile) -> Result<GearSheet, Error> {
    let fails = || {
        let message = "the hob generates no flank at its reference cylinder";
        Error::new(Code::OutOfRange, message)
            .with_span(&file.span)
            .with_hint("check starts, diameter and the hands: base helices of hob and gear have a common normal")
    };
    let hobbing = file.hobbing(&file.hob).ok_or_else(fails)?;
    let exact = file.hobbing(&file.involute_hob).ok_or_else(fails)?;
    let reference = 0.5 * file.hob_diameter;
    let pitch = hobbing.point(reference).ok_or_else(fails)?;
    let base_radius = 0.5 * file.gear.base_diameter();
    let module = file.gear.module;
    let radii =
        (0..=ROWS).map(|k| reference + module * (2.0 * f64::from(k) / f64::from(ROWS) - 1.0));
    let rows: Vec<[f64; 7]> = radii
        .filter_map(|radius| {
            let point = hobbing.point(radius)?;
            let relief =
                point.involute_deviation(base_radius)? - pitch.involute_deviation(base_radius)?;
            let heights = [hobbing.thread_height(radius)?, exact.thread_height(radius)?];
            let height = file
                .feed
                .and_then(|feed| Some(hobbing.feed_marks(&point)?.height(feed)));
            Some([
                1e3 * point.gear_radius,
                1e6 * relief,
                1e3 * radius,
                1e3 * heights[1],
                1e6 * (heights[0] - heights[1]),
                (point.hob_turn - pitch.hob_turn).to_degrees(),
                1e6 * height.unwrap_or(f64::NAN),
            ])
        })
        .collect();
    if rows.is_empty() {
        return Err(fails());
    }
    let heads = [
        ("gear radius", "mm"),
        ("off the involute", "µm"),
        ("hob radius", "mm"),
        ("z of the involute hob", "mm"),
        ("z off the involute hob", "µm"),
        ("hob turn", "deg"),
        ("feed mark", "µm"),
    ];
    let column = |k: usize| -> Vec<f64> { rows.iter().map(|row| row[k]).collect() };
    let mut plots = vec![SheetPlot {
        suffix: "",
        axes: [
            "off the involute, positive into the metal, µm",
            "radius of the gear, mm",
        ],
        equal_scales: false,
        curves: vec![(String::new(), column(1), column(0))],
        labels: Vec::new(),
    }];
    if file.feed.is_some() {
        plots.push(SheetPlot {
            suffix: FIGURES[1],
            axes: ["height of the feed marks, µm", "radius of the gear, mm"],
            equal_scales: false,
            curves: vec![(String::new(), column(6), column(0))],
            labels: Vec::new(),
        });
    }
    Ok(GearSheet {
        title: file.title.clone(),
        kind: "helicoid",
        what: "gear and hob",
        teeth: Some([file.hob.starts, file.gear.teeth]),
        members: ["hob", "gear"],
        quantities: quantities(file, &hobbing, &pitch).0,
        tables: vec![table("hobbed profile", heads, rows)],
        plots,
        in_space: LazyLock::new(Box::new(|| None)),
        plan: plan(file),
        diagnostics: Vec::new(),
        source: file.source.clone(),
    })
}

/// Suffixes of the figures.
pub const FIGURES: [&str; 2] = ["", "feed-marks"];

fn quantities(file: &HobFile, hobbing: &Hobbing, pitch: &HobbedPoint) -> Quantities {
    use QuantityUnit::{Degree, Millimetre, One};
    let nothing = f64::NAN;
    let (gear, hob) = (&file.gear, &file.hob);
    let mut all = Quantities::default();
    let counts = [f64::from(hob.starts), f64::from(gear.teeth)];
    all.each("starts, teeth", "z", One, counts);
    let diameters = [file.hob_diameter, gear.reference_diameter()];
    all.each("reference diameter", "d", Millimetre, diameters);
    let base = [2.0 * file.involute_hob.base_radius(), gear.base_diameter()];
    all.each("base diameter of involute flanks", "d_b", Millimetre, base);
    all.each("lead angle", "γ", Degree, [hob.lead_angle(), nothing]);
    all.each(
        "helix angle",
        "β",
        Degree,
        [nothing, file.hand * gear.helix],
    );
    let modules = [hob.module, gear.module];
    all.each(
        "axial module of the hob, normal module",
        "m",
        Millimetre,
        modules,
    );
    all.pair("axis angle", "Σ", Degree, hobbing.axes.shaft_angle);
    all.pair("centre distance", "a", Millimetre, hobbing.axes.offset);
    if let (Some(feed), Some(marks)) = (file.feed, hobbing.feed_marks(pitch)) {
        all.pair("feed a turn of the gear", "f", Millimetre, feed);
        all.pair(
            "height of feed marks at the pitch point",
            "δ_f",
            Millimetre,
            marks.height(feed),
        );
    }
    all
}

/// The stages that run, and those left out with the reason.
pub fn plan(file: &HobFile) -> Vec<(&'static str, StageDecision)> {
    let runs = |what: &str| StageDecision::Runs(what.into());
    let leaves = |why: &str| StageDecision::LeftOut(why.into());
    let mut plan = vec![(
        "geometry",
        runs("a helical gear under roll and feed of a hob of its hand"),
    )];
    if !file.defaults.is_empty() {
        plan.push(("defaults", StageDecision::Runs(file.defaults.join("; "))));
    }
    plan.extend([
        (
            "flanks",
            runs("profile cut by the hob, compared with the involute over the working depth of one module each way"),
        ),
        (
            "feed marks",
            match file.feed {
                Some(_) => runs("height between two feed steps, the roll free"),
                None => leaves("no feed is given: tool.feed"),
            },
        ),
        ("gashes", leaves("the hob is a continuous thread: facets of its gashes are not computed")),
    ]);
    plan
}
