//! A helicoid with the disk tool that cuts it: sections, deviations from the involute helicoid, profile of the tool, limits.

use std::sync::LazyLock;

use super::geometry::{Quantities, QuantityUnit};
use super::sheet::{GearSheet, SheetPlot, table};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::gear::helicoid::axial_profile::Helicoid;
use crate::gear::helicoid::disk_tool::DiskPoint;
use crate::gear::helicoid::grinding_wheel::ToolAxis;
use crate::gear::helicoid::worm_thread::{FlankType, WormThread};
use crate::plan::decision::StageDecision;
use crate::scene::helicoid_file::HelicoidFile;

/// Points of the profile.
const POINTS: u32 = 40;
/// Depth of interference that is not mentioned, in modules: below what a measuring machine shows.
const SLIGHT: f64 = 1e-5;

/// Computes what the file determines.
///
/// # Errors
/// A flank without a point within its radii.
pub fn run(file: &HelicoidFile) -> Result<GearSheet, Error> {
    let thread = &file.thread;
    let reference = thread.reference_radius();
    let nothing = || {
        let message = "the wheel that grinds the thread does not reach its reference cylinder";
        Error::new(Code::OutOfRange, message)
            .with_span(&file.span)
            .with_hint("check tool_radius, arc_radius and starts")
    };
    let helicoid = thread.helicoid().ok_or_else(nothing)?;
    let involute = WormThread {
        flank: FlankType::Zi,
        ..*thread
    };
    let involute = involute.helicoid();
    let axis = ToolAxis {
        distance: file.tool_radius + reference,
        angle: file.axis_angle,
    };
    let [root, tip] = file.radii;
    let radii: Vec<f64> = (0..=POINTS)
        .map(|k| root + (tip - root) * f64::from(k) / f64::from(POINTS))
        .collect();
    let sections: Vec<[f64; 7]> = radii
        .iter()
        .filter_map(|radius| section(thread, &helicoid, involute.as_ref(), *radius))
        .collect();
    let profile = axis.disk_profile(&helicoid, &radii);
    let mut diagnostics = Vec::new();
    if sections.len() < radii.len() {
        let reached = |radius| section(thread, &helicoid, involute.as_ref(), radius).is_some();
        diagnostics.push(not_reached(&radii, reached));
    } else if profile.len() < radii.len() {
        let from = |radius: f64| {
            let apart = |p: &DiskPoint| (p.distance - radius).abs();
            profile.iter().min_by(|a, b| apart(a).total_cmp(&apart(b)))
        };
        let touched = |radius: f64| {
            let both = |near: &DiskPoint| axis.disk_profile(&helicoid, &[near.distance, radius]);
            from(radius).is_some_and(|near| both(near).len() == 2)
        };
        diagnostics.push(no_contact(&radii, touched));
    }
    if let Some(cut) = axis.interference(&helicoid, file.radii, SLIGHT * thread.module) {
        diagnostics.push(Diagnostic {
            code: "interference",
            message: format!(
                "the tool cuts up to {:.1} µm into the flank at a radius of {:.3} mm",
                1e6 * cut.depth,
                1e3 * cut.distance
            ),
            hint: Some("take a smaller tool, an axis angle nearer the lead angle of the middle of the flank, or less height".into()),
        });
    }
    let mut all = Quantities::default();
    use QuantityUnit::{Degree, Millimetre, One};
    all.pair("starts", "z", One, f64::from(thread.starts));
    all.pair("hand (1 right, −1 left)", "h", One, file.hand);
    all.pair("axial module", "m", Millimetre, thread.module);
    all.pair("reference diameter", "d", Millimetre, 2.0 * reference);
    all.pair(
        "lead",
        "p_z",
        Millimetre,
        std::f64::consts::TAU * thread.lead(),
    );
    all.pair("lead angle", "γ", Degree, thread.lead_angle());
    all.pair(
        "axial pressure angle",
        "α_x",
        Degree,
        thread.axial_pressure_angle(),
    );
    all.pair(
        "base diameter of the involute helicoid",
        "d_b",
        Millimetre,
        2.0 * thread.base_radius(),
    );
    all.pair(
        "centre distance of the tool",
        "A",
        Millimetre,
        axis.distance,
    );
    all.pair("axis angle of the tool", "S", Degree, axis.angle);
    let widest = profile.iter().map(|p| p.radius).fold(0.0, f64::max);
    all.pair("greatest radius of the tool", "R_max", Millimetre, widest);
    if let Some(edge) = profile.iter().max_by(|a, b| a.radius.total_cmp(&b.radius)) {
        let free = axis.angle_without_transition(thread.lead(), [edge.radius, edge.height]);
        if let Some(angle) = free {
            all.pair(
                "axis angle without transition surface",
                "S_0",
                Degree,
                angle,
            );
        }
    }
    let columns = |k: usize| -> Vec<f64> { sections.iter().map(|row| row[k]).collect() };
    let mut deviations = vec![("flank".to_string(), columns(6), columns(0))];
    let unreached = || {
        let message = "the dressed wheel does not reach the reference cylinder";
        Error::new(Code::OutOfRange, message)
            .with_span(&file.span)
            .with_hint("check tool.reground_radius")
    };
    let reground = (file.reground.as_ref()).map(|of| of.helicoid().ok_or_else(unreached));
    let mut regrinding = Vec::new();
    if let Some(other) = reground.transpose()? {
        regrinding.extend(radii.iter().filter_map(|&radius| {
            let of_flank = normal_deviation(thread, &other, &helicoid, radius)?;
            let of_involute = normal_deviation(thread, &other, involute.as_ref()?, radius);
            Some([
                1e3 * radius,
                1e6 * of_flank,
                1e6 * of_involute.unwrap_or(f64::NAN),
            ])
        }));
        if regrinding.len() < sections.len() {
            diagnostics.push(reground_short(&radii, |radius| other.at(radius).is_some()));
        }
        let column = |k: usize| regrinding.iter().map(|row: &[f64; 3]| row[k]).collect();
        deviations.push(("reground".to_string(), column(2), column(0)));
    }
    let mut tables = vec![
        table(
            "tool profile",
            [
                ("radius", "mm"),
                ("tool radius", "mm"),
                ("tool height", "mm"),
                ("tool profile angle", "deg"),
                ("contact azimuth", "deg"),
            ],
            profile.iter().map(|p| {
                [
                    1e3 * p.distance,
                    1e3 * p.radius,
                    1e3 * p.height,
                    p.slope.atan().to_degrees(),
                    file.hand * p.azimuth.to_degrees(),
                ]
            }),
        ),
        table(
            "flank sections",
            [
                ("radius", "mm"),
                ("axial z", "mm"),
                ("axial angle", "deg"),
                ("transverse azimuth", "deg"),
                ("normal x", "mm"),
                ("normal s", "mm"),
                ("off the involute helicoid", "µm"),
            ],
            sections.iter().map(|row| {
                let mut row = *row;
                row[3] *= file.hand;
                row
            }),
        ),
    ];
    if !regrinding.is_empty() {
        tables.push(table(
            "regrinding",
            [
                ("radius", "mm"),
                ("off the flank", "µm"),
                ("off the involute helicoid", "µm"),
            ],
            regrinding,
        ));
    }
    Ok(GearSheet {
        title: file.title.clone(),
        kind: "helicoid",
        what: "helicoid and disk tool",
        teeth: None,
        members: ["helicoid", ""],
        quantities: all.0,
        tables,
        plots: vec![
            SheetPlot {
                suffix: "",
                axes: ["height of the tool, mm", "radius of the tool, mm"],
                equal_scales: true,
                curves: vec![(
                    "tool".into(),
                    profile.iter().map(|p| 1e3 * p.height).collect(),
                    profile.iter().map(|p| 1e3 * p.radius).collect(),
                )],
                labels: Vec::new(),
            },
            SheetPlot {
                suffix: "deviation",
                axes: ["off the involute helicoid, µm", "radius, mm"],
                equal_scales: false,
                curves: deviations,
                labels: Vec::new(),
            },
        ],
        in_space: LazyLock::new(Box::new(|| None)),
        plan: plan(file),
        diagnostics,
        source: file.source.clone(),
    })
}

/// Suffixes of the figures.
pub const FIGURES: [&str; 2] = ["", "deviation"];

/// A row of the table of sections; the deviation is normal, positive where the flank lies in the metal of the involute helicoid.
fn section(
    thread: &WormThread,
    helicoid: &Helicoid,
    involute: Option<&Helicoid>,
    radius: f64,
) -> Option<[f64; 7]> {
    let at = helicoid.at(radius)?;
    let [x, s] = helicoid.normal_section(thread.lead_angle(), radius)?;
    let off = involute.and_then(|h| normal_deviation(thread, helicoid, h, radius));
    Some([
        1e3 * radius,
        1e3 * at.height,
        at.slope.atan().to_degrees(),
        helicoid.transverse_azimuth(radius)?.to_degrees(),
        1e3 * x,
        1e3 * s,
        1e6 * off.unwrap_or(f64::NAN),
    ])
}

/// Deviation of a flank from another along the normal, m, positive into the metal: the axial difference times cos γ cos α_n.
fn normal_deviation(
    thread: &WormThread,
    flank: &Helicoid,
    from: &Helicoid,
    radius: f64,
) -> Option<f64> {
    let normal = thread.lead_angle().cos() * thread.pressure_angle.cos();
    Some((flank.at(radius)?.height - from.at(radius)?.height) * normal)
}

/// Least and greatest of rising radii that are `reached`, m, by bisection towards their neighbours that are not.
fn reached_range(radii: &[f64], reached: impl Fn(f64) -> bool) -> [f64; 2] {
    const BISECTIONS: usize = 40;
    let is_in: Vec<bool> = radii.iter().map(|radius| reached(*radius)).collect();
    let first = is_in.iter().position(|is_in| *is_in).unwrap_or(0);
    let last = is_in.iter().rposition(|is_in| *is_in).unwrap_or(first);
    let ends = [
        (first, first.checked_sub(1)),
        (last, (last + 1 < radii.len()).then_some(last + 1)),
    ];
    ends.map(|(here, beyond)| {
        let (mut inside, mut outside) = (radii[here], radii[beyond.unwrap_or(here)]);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (inside + outside);
            match reached(middle) {
                true => inside = middle,
                false => outside = middle,
            }
        }
        inside
    })
}

fn not_reached(radii: &[f64], reached: impl Fn(f64) -> bool) -> Diagnostic {
    let [least, _] = reached_range(radii, reached);
    Diagnostic {
        code: "undercut",
        message: format!(
            "the flank does not reach below a radius of {:.3} mm; the thread goes down to {:.3} mm",
            1e3 * least,
            1e3 * radii[0]
        ),
        hint: Some("take fewer starts, a larger pressure angle or a larger root_diameter".into()),
    }
}

fn no_contact(radii: &[f64], touched: impl Fn(f64) -> bool) -> Diagnostic {
    let [least, greatest] = reached_range(radii, touched);
    Diagnostic {
        code: "no-contact",
        message: format!(
            "the tool touches the flank between radii of {:.3} and {:.3} mm only",
            1e3 * least,
            1e3 * greatest
        ),
        hint: Some("take an axis angle nearer the lead angle of the middle of the flank, or a smaller tool".into()),
    }
}

fn reground_short(radii: &[f64], ground: impl Fn(f64) -> bool) -> Diagnostic {
    let [least, greatest] = reached_range(radii, ground);
    Diagnostic {
        code: "undercut",
        message: format!(
            "the dressed wheel grinds radii between {:.3} and {:.3} mm only",
            1e3 * least,
            1e3 * greatest
        ),
        hint: Some("take a reground_radius nearer the radius of the tool".into()),
    }
}

/// The stages that run, and those left out with the reason.
pub fn plan(file: &HelicoidFile) -> Vec<(&'static str, StageDecision)> {
    let runs = |what: &str| StageDecision::Runs(what.into());
    let mut plan = vec![(
        "geometry",
        runs("axial, transverse and normal section, deviation from the involute helicoid"),
    )];
    if !file.defaults.is_empty() {
        plan.push(("defaults", StageDecision::Runs(file.defaults.join("; "))));
    }
    plan.extend([
        (
            "tool",
            runs("profile of the disk tool whose normals meet its axis"),
        ),
        (
            "limits",
            runs("interference of the tool along the helix, axis angle without transition surface"),
        ),
    ]);
    plan
}
