//! Order excitations of a running machine, `e = a cos(n Ω t)`, declared or of unit amplitude.

use crate::base::error::Error;
use crate::machine::components::{ErrorAction, Machine};
use crate::machine::kinematics::{Kinematics, mean_speeds};
use crate::machine::operating_point::{ActiveFlank, OperatingPoint};
use crate::modes::excitation_orders::{
    ExcitationCause, ExcitationOrder, ExcitationSource, OrderOptions, excitation_orders,
};
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;
use crate::numeric::sorting::sort_rising;
use crate::scene::laws::Waveform;

/// One order of one source.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderExcitation {
    /// Per turn of the reference.
    pub order: f64,
    /// The same as a fraction, where it is one.
    pub fraction: String,
    /// Description of the excitation source.
    pub source: String,
    /// The branches it acts in, each with its share of the amplitude and its phase.
    pub branches: Vec<(usize, Complex)>,
    /// Displacement amplitude, m or rad.
    pub amplitude: f64,
    /// The amplitude is declared, not assumed.
    pub declared: bool,
}

/// Default amplitude where none is declared, m.
pub const UNIT_AMPLITUDE: f64 = 1e-6;

/// Harmonics of a mesh that are looked at.
const MESH_HARMONICS: u32 = 3;

/// Two orders are one to this, relative: products of ratios of teeth.
const ORDER_TOLERANCE: f64 = 1e-9;

/// All excitations of a machine, by rising order.
///
/// # Errors
/// Those of the mean speeds.
pub fn excitations(
    machine: &Machine,
    kinematics: &Kinematics,
    operating: &OperatingPoint,
) -> Result<Vec<OrderExcitation>, Error> {
    let options = OrderOptions {
        rotation_multiples: 1,
        mesh_multiples: MESH_HARMONICS,
    };
    let unit = mean_speeds(machine, kinematics, Some(1.0))?;
    let known = excitation_orders(machine, kinematics, &options)?;
    let mut all = declared_errors(machine, operating, &unit, &known);
    let first = all.len();
    let mut put = |order: f64, fraction: String, source: String, branches: &[usize]| {
        let same = |e: &OrderExcitation| {
            (e.order - order).abs() <= ORDER_TOLERANCE * order
                && e.branches.iter().any(|b| branches.contains(&b.0))
        };
        if order > 0.0 && !branches.is_empty() && !all[..first].iter().any(same) {
            all.push(OrderExcitation {
                order,
                fraction,
                source,
                branches: branches
                    .iter()
                    .map(|&b| (b, Complex::new(1.0, 0.0)))
                    .collect(),
                amplitude: UNIT_AMPLITUDE,
                declared: false,
            });
        }
    };
    let mut seen: Vec<(String, Vec<usize>)> = Vec::new();
    for order in &known {
        for source in &order.sources {
            let Some(gear) = source.gear else { continue };
            let branches = &machine.gears[gear].branches;
            let what = match (source.cause, source.multiple) {
                (ExcitationCause::Rotation, _) => {
                    format!("{}: {} turns", source.element, source.member)
                }
                (ExcitationCause::Mesh, multiple) => {
                    // Both gears of a pair name its mesh.
                    let mesh = (order.fraction.clone(), branches.clone());
                    if seen.contains(&mesh) {
                        continue;
                    }
                    seen.push(mesh);
                    match multiple {
                        1 => format!("{}: mesh", source.element),
                        n => format!("{}: mesh × {n}", source.element),
                    }
                }
            };
            put(order.value, order.fraction.clone(), what, branches);
            if source.cause != ExcitationCause::Mesh || source.multiple != 1 {
                continue;
            }
            for turning in &known {
                for member in turning
                    .sources
                    .iter()
                    .filter(|m| m.cause == ExcitationCause::Rotation && m.element == source.element)
                {
                    for (sign, word) in [(-1.0, "−"), (1.0, "+")] {
                        let value = order.value + sign * turning.value;
                        let exact = order.exact.as_ref().zip(turning.exact.as_ref());
                        let text = exact.map(|(mesh, turn)| match sign < 0.0 {
                            true => mesh - turn,
                            false => mesh + turn,
                        });
                        let text = text.map_or_else(|| format!("{value:.9}"), |f| f.to_string());
                        put(
                            value,
                            text,
                            format!("{}: mesh {word} {}", source.element, member.member),
                            branches,
                        );
                    }
                }
            }
        }
    }
    sort_rising(&mut all, |a| a.order);
    Ok(all)
}

/// The errors a scene declares, harmonic by harmonic, on the flanks that carry.
fn declared_errors(
    machine: &Machine,
    operating: &OperatingPoint,
    unit: &[f64],
    known: &[ExcitationOrder],
) -> Vec<OrderExcitation> {
    let flank = |branch: usize| usize::from(operating.state(branch) == ActiveFlank::Coast);
    let mut all = Vec::new();
    for error in &machine.errors {
        let carried = error.carrier.map_or(0.0, |c| unit[c]);
        let turns = (unit[error.rotation_dof] - carried).abs();
        let node = machine.dofs[error.rotation_dof].node;
        let rotation = known.iter().find(|o| {
            let turns =
                |s: &ExcitationSource| s.cause == ExcitationCause::Rotation && s.node == node;
            error.carrier.is_none() && o.sources.iter().any(turns)
        });
        let waveform = error.averaged.as_ref().unwrap_or(&error.waveform);
        for (n, amplitude) in harmonics(waveform) {
            let order = f64::from(n) * turns * error.periods_per_rev.0 as f64
                / error.periods_per_rev.1 as f64;
            let exact = rotation.and_then(|o| o.exact.as_ref());
            let text = exact
                .map(|turn| {
                    &turn.times(n)
                        * &Fraction::new(error.periods_per_rev.0, error.periods_per_rev.1)
                })
                .map_or_else(|| format!("{order:.9}"), |f| f.to_string());
            if order == 0.0 || amplitude == 0.0 {
                continue;
            }
            let share = |act: &ErrorAction| {
                let reach = act.flanks[flank(act.branch)];
                let phase = f64::from(n) * reach.phase;
                (
                    act.branch,
                    Complex::new(phase.cos(), phase.sin()) * reach.gain,
                )
            };
            all.push(OrderExcitation {
                order,
                fraction: text,
                source: format!("{}: {}", error.location, error.cause.name()),
                branches: error.acts.iter().map(share).collect(),
                amplitude: amplitude.abs(),
                declared: true,
            });
        }
    }
    all
}

/// Harmonics of a shape per period with their amplitudes; of a table as many as it can tell, of steps as many as of a mesh.
fn harmonics(waveform: &Waveform) -> Vec<(u32, f64)> {
    let known = |(n, a, _): (u32, f64, f64)| (n, a);
    match waveform {
        Waveform::Fourier { .. } => waveform.harmonics().into_iter().map(known).collect(),
        Waveform::Table(values) => {
            let size = values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            // What is left below is rounding of the transform.
            let all = waveform.harmonics().into_iter().map(known);
            all.filter(|t| t.1 > 1e-12 * size).collect()
        }
        Waveform::Rectangular { high, low, duty } => (1..=MESH_HARMONICS)
            .map(|n| {
                let angle = std::f64::consts::PI * f64::from(n);
                (
                    n,
                    2.0 * (high - low).abs() * (angle * duty).sin().abs() / angle,
                )
            })
            .collect(),
    }
}
