//! What excites a running machine, order by order: `e = a cos(n Ω t)` in the branches of a gear; declared errors with their
//! amplitudes, and a unit amplitude for whatever turns or meshes and is not declared.

use crate::base::error::Error;
use crate::machine::kinematics::{Kinematics, mean_speeds};
use crate::machine::operating::{ContactState, Operating};
use crate::machine::parts::{Acting, Machine};
use crate::modes::orders::{Cause, Order, OrderOptions, Source, orders};
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;
use crate::scene::laws::Shape;

/// One order of one source.
#[derive(Debug, Clone, PartialEq)]
pub struct Excitation {
    /// Per turn of the reference.
    pub order: f64,
    /// The same as a fraction, where it is one.
    pub fraction: String,
    /// What excites, in words.
    pub source: String,
    /// The branches it acts in, each with its share of the amplitude and its phase.
    pub branches: Vec<(usize, Complex)>,
    /// Of the displacement, m or rad.
    pub amplitude: f64,
    /// The amplitude is declared, not assumed.
    pub declared: bool,
}

/// What is taken where no amplitude is declared, m.
pub const UNIT: f64 = 1e-6;

/// Harmonics of a mesh that are looked at.
const MESH: u32 = 3;

/// Two orders are one to this, relative: products of ratios of teeth.
const SAME: f64 = 1e-9;

/// All excitations of a machine, by rising order.
///
/// # Errors
/// Those of the mean speeds.
pub fn excitations(
    machine: &Machine,
    kinematics: &Kinematics,
    operating: &Operating,
) -> Result<Vec<Excitation>, Error> {
    let options = OrderOptions {
        rotation_multiples: 1,
        mesh_multiples: MESH,
    };
    let unit = mean_speeds(machine, kinematics, Some(1.0))?;
    let known = orders(machine, kinematics, &options)?;
    let mut all = declared(machine, operating, &unit, &known);
    let first = all.len();
    let mut put = |order: f64, fraction: String, source: String, branches: &[usize]| {
        let same = |e: &Excitation| {
            (e.order - order).abs() <= SAME * order
                && e.branches.iter().any(|b| branches.contains(&b.0))
        };
        if order > 0.0 && !branches.is_empty() && !all[..first].iter().any(same) {
            all.push(Excitation {
                order,
                fraction,
                source,
                branches: branches
                    .iter()
                    .map(|&b| (b, Complex::new(1.0, 0.0)))
                    .collect(),
                amplitude: UNIT,
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
                (Cause::Rotation, _) => format!("{}: {} turns", source.element, source.member),
                (Cause::Mesh, multiple) => {
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
            if source.cause != Cause::Mesh || source.multiple != 1 {
                continue;
            }
            for turning in &known {
                for member in turning
                    .sources
                    .iter()
                    .filter(|m| m.cause == Cause::Rotation && m.element == source.element)
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
    all.sort_by(|a, b| a.order.total_cmp(&b.order));
    Ok(all)
}

/// The errors a scene declares, harmonic by harmonic, on the flanks that carry.
fn declared(
    machine: &Machine,
    operating: &Operating,
    unit: &[f64],
    known: &[Order],
) -> Vec<Excitation> {
    let flank = |branch: usize| {
        let state = operating.contacts.iter().find(|c| c.0 == branch);
        usize::from(state.is_some_and(|c| c.1 == ContactState::Coast))
    };
    let mut all = Vec::new();
    for error in &machine.errors {
        let carried = error.carrier.map_or(0.0, |c| unit[c]);
        let turns = (unit[error.turning] - carried).abs();
        let node = machine.freedoms[error.turning].node;
        let rotation = known.iter().find(|o| {
            let turns = |s: &Source| s.cause == Cause::Rotation && s.node == node;
            error.carrier.is_none() && o.sources.iter().any(turns)
        });
        for (n, amplitude) in harmonics(&error.shape) {
            let order = f64::from(n) * turns * error.pace.0 as f64 / error.pace.1 as f64;
            let exact = rotation.and_then(|o| o.exact.as_ref());
            let text = exact
                .map(|turn| &turn.times(n) * &Fraction::new(error.pace.0, error.pace.1))
                .map_or_else(|| format!("{order:.9}"), |f| f.to_string());
            if order == 0.0 || amplitude == 0.0 {
                continue;
            }
            let share = |act: &Acting| {
                let reach = act.flanks[flank(act.branch)];
                let phase = f64::from(n) * reach.turn;
                (
                    act.branch,
                    Complex::new(phase.cos(), phase.sin()) * reach.gain,
                )
            };
            all.push(Excitation {
                order,
                fraction: text,
                source: format!("{}: {}", error.on, error.cause.name()),
                branches: error.acts.iter().map(share).collect(),
                amplitude: amplitude.abs(),
                declared: true,
            });
        }
    }
    all
}

/// Harmonics of a shape per period with their amplitudes; of a table as many as it can tell, of steps as many as of a mesh.
fn harmonics(shape: &Shape) -> Vec<(u32, f64)> {
    let known = |(n, a, _): (u32, f64, f64)| (n, a);
    match shape {
        Shape::Fourier { .. } => shape.harmonics().into_iter().map(known).collect(),
        Shape::Table(values) => {
            let size = values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            // What is left below is rounding of the transform.
            let all = shape.harmonics().into_iter().map(known);
            all.filter(|t| t.1 > 1e-12 * size).collect()
        }
        Shape::Rectangular { high, low, duty } => (1..=MESH)
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
