//! Order excitations of a rotating machine, `e = a cos(n Ω t)`, with declared or unit amplitude.

use crate::base::error::Error;
use crate::machine::components::{ErrorAction, Machine};
use crate::machine::kinematics::{Kinematics, mean_speeds};
use crate::machine::operating_point::{ActiveFlank, OperatingPoint};
use crate::modes::excitation_orders::{
    ExcitationCause, ExcitationOrder, ExcitationSource, OrderOptions, excitation_orders,
};
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;
use crate::numeric::sorting::sort_ascending;
use crate::scene::laws::Waveform;

/// Displacement excitation at one order of one source.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderExcitation {
    /// Order, cycles per revolution of the reference.
    pub order: f64,
    /// Order as a fraction, else as a decimal number.
    pub fraction: String,
    /// Source: element and cause.
    pub source: String,
    /// Excited branches, each with its complex factor of the amplitude.
    pub branches: Vec<(usize, Complex)>,
    /// Displacement amplitude, m or rad.
    pub amplitude: f64,
    /// Whether the amplitude is declared in the scene; otherwise it is [`UNIT_AMPLITUDE`].
    pub declared: bool,
}

/// Default amplitude of an undeclared excitation, m.
pub const UNIT_AMPLITUDE: f64 = 1e-6;

/// Number of mesh harmonics.
const MESH_HARMONICS: u32 = 3;

/// Relative tolerance of equal orders, above the rounding of products of tooth ratios.
const ORDER_TOLERANCE: f64 = 1e-9;

/// Excitations of a machine, by rising order.
///
/// # Errors
/// Errors of the mean speeds.
pub fn excitations(
    machine: &Machine,
    kinematics: &Kinematics,
    operating: &OperatingPoint,
) -> Result<Vec<OrderExcitation>, Error> {
    let options = OrderOptions {
        rotation_multiples: 1,
        mesh_multiples: MESH_HARMONICS,
    };
    let speeds = mean_speeds(machine, kinematics, Some(1.0))?;
    let orders = excitation_orders(machine, kinematics, &options)?;
    let mut excitations = declared_errors(machine, operating, &speeds, &orders);
    let n_declared = excitations.len();
    let mut add = |order: f64, fraction: String, source: String, branches: &[usize]| {
        let same = |e: &OrderExcitation| {
            (e.order - order).abs() <= ORDER_TOLERANCE * order
                && e.branches.iter().any(|b| branches.contains(&b.0))
        };
        if order > 0.0 && !branches.is_empty() && !excitations[..n_declared].iter().any(same) {
            excitations.push(OrderExcitation {
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
    let mut meshes: Vec<(String, Vec<usize>)> = Vec::new();
    for order in &orders {
        for source in &order.sources {
            let Some(gear) = source.gear else { continue };
            let branches = &machine.gears[gear].branches;
            let name = match (source.cause, source.multiple) {
                (ExcitationCause::Rotation, _) => {
                    format!("{}: {} turns", source.element, source.member)
                }
                (ExcitationCause::Mesh, multiple) => {
                    // Both gears of a pair list its mesh.
                    let mesh = (order.fraction.clone(), branches.clone());
                    if meshes.contains(&mesh) {
                        continue;
                    }
                    meshes.push(mesh);
                    match multiple {
                        1 => format!("{}: mesh", source.element),
                        n => format!("{}: mesh × {n}", source.element),
                    }
                }
            };
            add(order.value, order.fraction.clone(), name, branches);
            if source.cause != ExcitationCause::Mesh || source.multiple != 1 {
                continue;
            }
            for rotation in &orders {
                for member in rotation
                    .sources
                    .iter()
                    .filter(|m| m.cause == ExcitationCause::Rotation && m.element == source.element)
                {
                    for (sign, symbol) in [(-1.0, "−"), (1.0, "+")] {
                        let value = order.value + sign * rotation.value;
                        let exact = order.exact.as_ref().zip(rotation.exact.as_ref());
                        let text = exact.map(|(mesh, turn)| match sign < 0.0 {
                            true => mesh - turn,
                            false => mesh + turn,
                        });
                        let text = text.map_or_else(|| format!("{value:.9}"), |f| f.to_string());
                        add(
                            value,
                            text,
                            format!("{}: mesh {symbol} {}", source.element, member.member),
                            branches,
                        );
                    }
                }
            }
        }
    }
    sort_ascending(&mut excitations, |a| a.order);
    Ok(excitations)
}

/// Declared errors of the scene by harmonic, on the active flanks.
fn declared_errors(
    machine: &Machine,
    operating: &OperatingPoint,
    speeds: &[f64],
    orders: &[ExcitationOrder],
) -> Vec<OrderExcitation> {
    let flank = |branch: usize| usize::from(operating.state(branch) == ActiveFlank::Coast);
    let mut excitations = Vec::new();
    for error in &machine.errors {
        let carrier_speed = error.carrier.map_or(0.0, |c| speeds[c]);
        let speed = (speeds[error.rotation_dof] - carrier_speed).abs();
        let node = machine.dofs[error.rotation_dof].node;
        let rotation = orders.iter().find(|o| {
            let turns =
                |s: &ExcitationSource| s.cause == ExcitationCause::Rotation && s.node == node;
            error.carrier.is_none() && o.sources.iter().any(turns)
        });
        let waveform = error.averaged.as_ref().unwrap_or(&error.waveform);
        for (n, amplitude) in harmonics(waveform) {
            let order = f64::from(n) * speed * error.periods_per_rev.0 as f64
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
                let action = act.flanks[flank(act.branch)];
                let phase = f64::from(n) * action.phase;
                (
                    act.branch,
                    Complex::new(phase.cos(), phase.sin()) * action.gain,
                )
            };
            excitations.push(OrderExcitation {
                order,
                fraction: text,
                source: format!("{}: {}", error.location, error.cause.name()),
                branches: error.acts.iter().map(share).collect(),
                amplitude: amplitude.abs(),
                declared: true,
            });
        }
    }
    excitations
}

/// Harmonics per period with their amplitudes: all of a Fourier series or a table, [`MESH_HARMONICS`] of a rectangular wave.
fn harmonics(waveform: &Waveform) -> Vec<(u32, f64)> {
    let amplitude = |(n, a, _): (u32, f64, f64)| (n, a);
    match waveform {
        Waveform::Fourier { .. } => waveform.harmonics().into_iter().map(amplitude).collect(),
        Waveform::Table(values) => {
            let size = values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            // Smaller amplitudes are rounding of the transform.
            let terms = waveform.harmonics().into_iter().map(amplitude);
            terms.filter(|t| t.1 > 1e-12 * size).collect()
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
