//! Spectral lines expected of a machine: shaft and mesh harmonics, their sidebands, rolling-bearing frequencies.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text::{quoted_list, suggestion};
use crate::machine::kinematics::mean_speeds;
use crate::modes::excitation_orders::{
    ExcitationCause, ExcitationSource, OrderOptions, excitation_orders, reference_dof,
};
use crate::numeric::sorting::sort_ascending;
use crate::plan::prepared_machine::PreparedMachine;
use crate::scene::model::Axis;
use crate::spectrum::line_labels::{ExpectedLine, HarmonicFamily, RollingBearing};

/// Relative tolerance of a stated speed: motor slip and the error of hand-held tachometers.
const SPEED_TOLERANCE: f64 = 2e-3;

/// Relative tolerance of the kinematic frequencies of a rolling bearing: slip of one to two per cent.
const BEARING_TOLERANCE: f64 = 0.02;

/// Number of harmonics of a shaft rotation.
const MAX_SHAFT_HARMONICS: usize = 20;

/// Number of harmonics of a bearing frequency, as in bursts that excite one resonance.
const MAX_BEARING_HARMONICS: usize = 12;

/// Number of harmonics of a mesh frequency.
const MAX_MESH_HARMONICS: usize = 6;

/// Number of sidebands on either side of a mesh harmonic.
const MAX_SIDEBANDS: usize = 8;

/// Lines of all shafts and meshes of a machine, Hz, when node `node` rotates at `speed`, rad/s; orders of that node if `in_orders`.
///
/// # Errors
/// An unknown node, a node that does not rotate, speeds that do not follow from one input speed.
pub fn machine_lines(
    prepared_machine: &PreparedMachine,
    node: &str,
    speed: f64,
    in_orders: bool,
) -> Result<Vec<ExpectedLine>, Error> {
    let (machine, kinematics) = (&prepared_machine.machine, &prepared_machine.kinematics);
    let dof = (0..machine.dofs.len()).find(|&i| {
        let dof = &machine.dofs[i];
        machine.nodes[dof.node].name == node && dof.axis == Axis::Theta
    });
    let Some(dof) = dof else {
        let names = || machine.nodes.iter().map(|n| n.name.as_str());
        let hint = match suggestion(node, names()) {
            Some(nearest) => format!("did you mean \"{nearest}\"?"),
            None => format!("it has {}", quoted_list(names())),
        };
        let message = format!("the model has no node \"{node}\" that turns");
        return Err(Error::new(Code::UnknownNode, message).with_hint(hint));
    };
    let with_hint = |e: Error| {
        match e.code {
        Code::UndeterminedSpeed => e.with_hint("a support with k_theta or a shaft to ground prevents rotation: name a model of the drive, such as models/spindle_drive.toml, or omit --model: --speed or --tacho alone define the rotation"),
        _ => e,
    }
    };
    let unit = mean_speeds(machine, kinematics, Some(1.0)).map_err(with_hint)?;
    let ratio = (unit[dof] / unit[reference_dof(machine).map_err(with_hint)?]).abs();
    if !(ratio > 0.0 && ratio.is_finite()) {
        let message = format!("{node} does not turn while the machine runs");
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
    // Harmonic numbers in each name: a line with lower numbers is the more likely origin.
    let ranked =
        |family: &HarmonicFamily| family.harmonics().into_iter().zip(1..).collect::<Vec<_>>();
    let mut lines: Vec<(ExpectedLine, usize)> =
        rotations.iter().flat_map(|(_, f)| ranked(f)).collect();
    for (element, mesh) in &meshes {
        lines.extend(ranked(mesh));
        for (_, rotation) in rotations.iter().filter(|(parent, _)| parent == element) {
            for (carrier, h) in ranked(mesh) {
                for (spacing, k) in ranked(rotation).into_iter().take(MAX_SIDEBANDS) {
                    let sidebands = single_line_family(&carrier, mesh)
                        .sidebands(&single_line_family(&spacing, rotation));
                    lines.extend(sidebands.into_iter().map(|line| (line, h + k)));
                }
            }
        }
    }
    Ok(remove_aliases(lines))
}

/// Family of a single line, with the tolerance of its parent family.
fn single_line_family(line: &ExpectedLine, family: &HarmonicFamily) -> HarmonicFamily {
    HarmonicFamily {
        name: line.name.clone(),
        fundamental: line.position,
        relative_tolerance: family.relative_tolerance,
        harmonics: 1,
    }
}

/// Keeps, of coincident lines, those with the lowest harmonic numbers: a mesh frequency is a multiple of a rotation, hence a sideband of
/// one mesh harmonic is also a sideband of the next and a high multiple of the rotation.
fn remove_aliases(mut lines: Vec<(ExpectedLine, usize)>) -> Vec<ExpectedLine> {
    /// Relative rounding of sums and multiples of one speed.
    const ROUNDING: f64 = 1e-9;
    sort_ascending(&mut lines, |a| a.0.position);
    let coincide = |a: &(ExpectedLine, usize), b: &(ExpectedLine, usize)| {
        (b.0.position - a.0.position).abs() <= ROUNDING * b.0.position
    };
    let mut unique = Vec::new();
    for group in lines.chunk_by(coincide) {
        let least = group.iter().map(|(_, rank)| *rank).min();
        let lowest = group.iter().filter(|(_, rank)| Some(*rank) == least);
        unique.extend(lowest.map(|(line, _)| line.clone()));
    }
    unique
}

/// Adds a family with its element, unless the element has one of this name.
fn push_family(
    families: &mut Vec<(String, HarmonicFamily)>,
    source: &ExcitationSource,
    family: HarmonicFamily,
) {
    let is_equal = |(element, known): &(String, HarmonicFamily)| {
        *element == source.element && known.name == family.name
    };
    if !families.iter().any(is_equal) {
        families.push((source.element.clone(), family));
    }
}

/// Harmonics of a shaft rotation, Hz; orders for `turns_per_s` = 1.
pub fn shaft_lines(turns_per_s: f64) -> Vec<ExpectedLine> {
    HarmonicFamily {
        name: "rotation".into(),
        fundamental: turns_per_s,
        relative_tolerance: SPEED_TOLERANCE,
        harmonics: MAX_SHAFT_HARMONICS,
    }
    .harmonics()
}

/// Lines of a rolling bearing on a shaft at `turns_per_s`, Hz; orders for `turns_per_s` = 1.
///
/// # Errors
/// Dimensions that are not those of a bearing.
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
