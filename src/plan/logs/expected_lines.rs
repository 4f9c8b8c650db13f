//! Expected spectral lines of a machine: shafts, meshes with sidebands, rolling bearings.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text::{quoted_list, suggestion};
use crate::machine::kinematics::mean_speeds;
use crate::modes::excitation_orders::{
    ExcitationCause, ExcitationSource, OrderOptions, excitation_orders, reference_dof,
};
use crate::numeric::sorting::sort_rising;
use crate::plan::prepared_machine::PreparedMachine;
use crate::scene::model::Axis;
use crate::spectrum::line_labels::{ExpectedLine, HarmonicFamily, RollingBearing};

/// Relative tolerance of a stated speed: slip of motors and readings of hand-held tachometers.
const SPEED_TOLERANCE: f64 = 2e-3;

/// Relative tolerance of the kinematic frequencies of a rolling bearing: one or two per cent of slip.
const BEARING_TOLERANCE: f64 = 0.02;

/// Harmonics of rotations.
const MAX_SHAFT_HARMONICS: usize = 20;

/// Harmonics of bearings: bursts that ring in one band have so many.
const MAX_BEARING_HARMONICS: usize = 12;

/// Harmonics of meshes.
const MAX_MESH_HARMONICS: usize = 6;

/// Sidebands to either side of each.
const MAX_SIDEBANDS: usize = 8;

/// Lines of every shaft and mesh of a machine, Hz, whose node `at` turns at `speed`, rad/s; in turns of that node where `in_orders`.
///
/// # Errors
/// A node that is not there or does not turn, speeds that do not follow from one.
pub fn machine_lines(
    prepared_machine: &PreparedMachine,
    at: &str,
    speed: f64,
    in_orders: bool,
) -> Result<Vec<ExpectedLine>, Error> {
    let (machine, kinematics) = (&prepared_machine.machine, &prepared_machine.kinematics);
    let dof = (0..machine.dofs.len()).find(|&i| {
        let found = &machine.dofs[i];
        machine.nodes[found.node].name == at && found.axis == Axis::Theta
    });
    let Some(dof) = dof else {
        let names = || machine.nodes.iter().map(|n| n.name.as_str());
        let hint = match suggestion(at, names()) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None => format!("it has {}", quoted_list(names())),
        };
        let message = format!("the model has no node \"{at}\" that turns");
        return Err(Error::new(Code::UnknownNode, message).with_hint(hint));
    };
    let held = |e: Error| {
        match e.code {
        Code::UndeterminedSpeed => e.with_hint("a support with k_theta, or a shaft to ground, holds it: name a model of the drive, such as models/spindle_drive.toml, or omit --model: --speed or --tacho alone define the rotation"),
        _ => e,
    }
    };
    let unit = mean_speeds(machine, kinematics, Some(1.0)).map_err(held)?;
    let ratio = (unit[dof] / unit[reference_dof(machine).map_err(held)?]).abs();
    if !(ratio > 0.0 && ratio.is_finite()) {
        let message = format!("{at} does not turn while the machine runs");
        return Err(
            Error::new(Code::UndeterminedSpeed, message).with_hint("name a node that turns")
        );
    }
    let scale = match in_orders {
        true => 1.0 / ratio,
        false => speed.abs() / TAU / ratio,
    };
    let options = OrderOptions {
        rotation_multiples: 1,
        mesh_multiples: 1,
    };
    let (mut rotations, mut meshes) = (Vec::new(), Vec::new());
    for order in excitation_orders(machine, kinematics, &options)? {
        let family = |name: String, harmonics| HarmonicFamily {
            name,
            fundamental: order.value * scale,
            relative_tolerance: SPEED_TOLERANCE,
            harmonics,
        };
        for source in &order.sources {
            match source.cause {
                ExcitationCause::Rotation => {
                    let name = format!("rotation of {}", source.member);
                    push_family(&mut rotations, source, family(name, MAX_SHAFT_HARMONICS));
                }
                ExcitationCause::Mesh => {
                    let name = format!("mesh {}", source.element);
                    push_family(&mut meshes, source, family(name, MAX_MESH_HARMONICS));
                }
            }
        }
    }
    // What is counted in each name: the fewer, the likelier it is meant.
    let counted =
        |family: &HarmonicFamily| family.harmonics().into_iter().zip(1..).collect::<Vec<_>>();
    let mut all: Vec<(ExpectedLine, usize)> =
        rotations.iter().flat_map(|(_, f)| counted(f)).collect();
    for (element, mesh) in &meshes {
        all.extend(counted(mesh));
        for (_, rotation) in rotations.iter().filter(|(of, _)| of == element) {
            for (carrier, h) in counted(mesh) {
                for (side, k) in counted(rotation).into_iter().take(MAX_SIDEBANDS) {
                    let pair = single_line_family(&carrier, mesh)
                        .sidebands(&single_line_family(&side, rotation));
                    all.extend(pair.into_iter().map(|line| (line, h + k)));
                }
            }
        }
    }
    Ok(remove_aliases(all))
}

/// A line as a family of its own.
fn single_line_family(line: &ExpectedLine, of: &HarmonicFamily) -> HarmonicFamily {
    HarmonicFamily {
        name: line.name.clone(),
        fundamental: line.position,
        relative_tolerance: of.relative_tolerance,
        harmonics: 1,
    }
}

/// Keeps, of the lines at one place, those with the lowest multiples in their names: multiples of a rotation make up a mesh, so that a
/// sideband of one harmonic is also one of the next, and a high multiple of the rotation.
fn remove_aliases(all: Vec<(ExpectedLine, usize)>) -> Vec<ExpectedLine> {
    /// Relative rounding of sums and multiples of one speed.
    const ROUNDING: f64 = 1e-9;
    let mut all = all;
    sort_rising(&mut all, |a| a.0.position);
    let alike = |a: &(ExpectedLine, usize), b: &(ExpectedLine, usize)| {
        (b.0.position - a.0.position).abs() <= ROUNDING * b.0.position
    };
    let mut kept = Vec::new();
    for group in all.chunk_by(alike) {
        let least = group.iter().map(|(_, counted)| *counted).min();
        let short = group.iter().filter(|(_, counted)| Some(*counted) == least);
        kept.extend(short.map(|(line, _)| line.clone()));
    }
    kept
}

/// Each name once, with the element it belongs to.
fn push_family(
    all: &mut Vec<(String, HarmonicFamily)>,
    source: &ExcitationSource,
    family: HarmonicFamily,
) {
    let is_same =
        |(of, known): &(String, HarmonicFamily)| *of == source.element && known.name == family.name;
    if !all.iter().any(is_same) {
        all.push((source.element.clone(), family));
    }
}

/// Harmonics of a shaft, Hz or orders.
pub fn shaft_lines(turns_per_s: f64) -> Vec<ExpectedLine> {
    HarmonicFamily {
        name: "rotation".into(),
        fundamental: turns_per_s,
        relative_tolerance: SPEED_TOLERANCE,
        harmonics: MAX_SHAFT_HARMONICS,
    }
    .harmonics()
}

/// Lines of a rolling bearing on a shaft that turns so often a second (1 for orders).
///
/// # Errors
/// Dimensions that make no bearing.
pub fn bearing_lines(
    bearing: &RollingBearing,
    turns_per_s: f64,
) -> Result<Vec<ExpectedLine>, Error> {
    let orders = bearing.orders()?;
    let family = |name: &str, order: f64| HarmonicFamily {
        name: name.into(),
        fundamental: order * turns_per_s,
        relative_tolerance: BEARING_TOLERANCE,
        harmonics: MAX_BEARING_HARMONICS,
    };
    Ok([
        family("BPFO", orders.outer_ring),
        family("BPFI", orders.inner_ring),
        family("BSF", orders.roller),
        family("FTF", orders.cage),
    ]
    .iter()
    .flat_map(HarmonicFamily::harmonics)
    .collect())
}
