//! What excites a running machine, order by order: `e = a cos(n Ω t)` in the branches of a gear; declared errors with their
//! amplitudes, and a unit amplitude for whatever turns or meshes and is not declared.

use std::f64::consts::TAU;

use crate::base::error::Error;
use crate::machine::kinematics::{Kinematics, mean_speeds};
use crate::machine::operating::{ContactState, Operating};
use crate::machine::parts::{Acting, Machine};
use crate::modes::orders::{Cause, Order, OrderOptions, Source, orders};
use crate::numeric::Complex;
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
                        let text = sum(&order.fraction, &turning.fraction, sign)
                            .unwrap_or_else(|| format!("{value:.9}"));
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
            let text = rotation
                .and_then(|o| times(&o.fraction, n, error.pace))
                .unwrap_or_else(|| format!("{order:.9}"));
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

/// Harmonics of a shape per period with their amplitudes; of a table as many as it can tell.
fn harmonics(shape: &Shape) -> Vec<(u32, f64)> {
    let term = |n: usize, values: &[f64]| {
        let count = values.len();
        let (mut re, mut im) = (0.0, 0.0);
        for (k, v) in values.iter().enumerate() {
            let angle = TAU * (n * k % count) as f64 / count as f64;
            re += v * angle.cos();
            im -= v * angle.sin();
        }
        let share = if 2 * n == count { 1.0 } else { 2.0 } / count as f64;
        (n as u32, share * re.hypot(im))
    };
    match shape {
        Shape::Fourier { terms, .. } => terms.iter().map(|&(n, a, _)| (n, a)).collect(),
        Shape::Table(values) => {
            let size = values.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            // What is left below is rounding of the transform.
            let all = (1..=values.len() / 2).map(|n| term(n, values));
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

/// `37/12` as whole numbers.
fn parts(text: &str) -> Option<(i128, i128)> {
    let (top, bottom) = text.split_once('/').unwrap_or((text, "1"));
    Some((top.parse().ok()?, bottom.parse().ok()?))
}

fn written(top: i128, bottom: i128) -> String {
    let mut pair = (top.abs(), bottom.abs());
    while pair.1 != 0 {
        pair = (pair.1, pair.0 % pair.1);
    }
    let divisor = pair.0.max(1);
    match bottom / divisor {
        1 => format!("{}", top / divisor),
        below => format!("{}/{below}", top / divisor),
    }
}

fn sum(one: &str, other: &str, sign: f64) -> Option<String> {
    let ((a, b), (c, d)) = (parts(one)?, parts(other)?);
    let second = if sign < 0.0 { -c } else { c };
    let top = a.checked_mul(d)?.checked_add(second.checked_mul(b)?)?;
    Some(written(top, b.checked_mul(d)?))
}

fn times(fraction: &str, n: u32, pace: (i64, i64)) -> Option<String> {
    let (a, b) = parts(fraction)?;
    let top = a
        .checked_mul(i128::from(n))?
        .checked_mul(i128::from(pace.0))?;
    Some(written(top, b.checked_mul(i128::from(pace.1))?))
}
