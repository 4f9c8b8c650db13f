//! The slow machine under torque: a mesh that carries F̄ gives way by `F̄ / k(φ)`, which acts like a displacement of that mesh.
//!
//! On a tree F̄ follows from the loads alone, and this is exact. In a loop F̄ itself changes a little with k(φ), and each mesh is
//! taken by itself with F̄ at the mean stiffness.

use std::f64::consts::PI;

use super::chain::Chain;
use super::lines::{Line, Origin, rising};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::parts::{Gear, Law};
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;
use crate::numeric::fraction::Fraction;
use crate::response::direct::Direct;
use crate::response::ports::{Input, Output, Port, Ports};
use crate::response::system::{Setting, System};
use crate::scene::laws::Shape;

/// Harmonics of a mesh that are kept.
const HARMONICS: u32 = 16;

/// Lines of meshes whose stiffness changes over the cycle, under the mean loads; their kinematic part is zero.
///
/// # Errors
/// A stiffness that goes to zero under load; those of the equations.
pub fn lines(setting: &Setting, chain: &Chain) -> Result<Vec<Line>, Error> {
    let machine = setting.machine;
    let waving: Vec<(usize, &Gear)> = setting
        .linear
        .branches
        .iter()
        .filter(|b| machine.branches[b.index].wave.is_some())
        .filter_map(|b| {
            let gear = machine
                .gears
                .iter()
                .find(|g| g.branches.contains(&b.index) && g.teeth.is_some());
            Some((b.index, gear?))
        })
        .collect();
    if waving.is_empty() || machine.loads.is_empty() {
        return Ok(Vec::new());
    }
    let branches: Vec<usize> = waving.iter().map(|w| w.0).collect();
    let forces = forces(setting, chain, &branches)?;
    let mut all = Vec::new();
    for (&(branch, gear), force) in waving.iter().zip(forces) {
        let (Some(wave), Law::Linear { stiffness, .. }) =
            (&machine.branches[branch].wave, machine.branches[branch].law)
        else {
            continue;
        };
        let (Some(own), carried) = (
            chain.turns(gear.turning),
            gear.carrier.and_then(|c| chain.turns(c)),
        ) else {
            continue;
        };
        let relative = own - carried.unwrap_or(&Fraction::zero());
        if force == 0.0 || relative.is_zero() {
            continue;
        }
        let rising = rising(chain, &relative);
        for (n, a, phase) in
            compliance(&wave.shape).ok_or_else(|| loses_contact(setting, branch))?
        {
            let angle = phase + f64::from(n) * wave.lead;
            let e = Complex::new(angle.cos(), rising * angle.sin()) * (force / stiffness * a);
            all.push(Line {
                order: relative.abs().times(n * gear.teeth.unwrap_or(1)),
                origin: Origin::Stiffness(branch),
                harmonic: n,
                displacements: vec![(branch, e)],
                kinematic: Complex::ZERO,
            });
        }
    }
    Ok(all)
}

/// Mean forces of branches under the lasting loads, N or N·m, the driver's angle held.
///
/// # Errors
/// Those of the equations.
pub fn forces(setting: &Setting, chain: &Chain, branches: &[usize]) -> Result<Vec<f64>, Error> {
    let port = |branch: &usize| Port {
        name: setting.machine.branch_name(*branch),
        unit: "N",
        what: Output::Force(*branch),
    };
    under_load(setting, chain, branches.iter().map(port).collect())
}

/// By how much the loads wind the chain up at its end, rad.
///
/// # Errors
/// Those of the equations.
pub fn wind_up(setting: &Setting, chain: &Chain) -> Result<f64, Error> {
    let output = Port {
        name: setting.machine.freedom_name(chain.ends.output),
        unit: "rad",
        what: Output::Sum(chain.combination.clone(), 0),
    };
    Ok(chain.sense() * under_load(setting, chain, vec![output])?[0])
}

fn under_load(
    setting: &Setting,
    chain: &Chain,
    outputs: Vec<Port<Output>>,
) -> Result<Vec<f64>, Error> {
    let loads = &setting.machine.loads;
    if loads.is_empty() {
        return Ok(vec![0.0; outputs.len()]);
    }
    let input = |load: &(usize, f64)| Port {
        name: setting.machine.freedom_name(load.0),
        unit: "N·m",
        what: Input::Torque(load.0),
    };
    let ports = Ports {
        inputs: loads.iter().map(input).collect(),
        outputs,
        held: chain.held.clone(),
    };
    let at_rest = Direct::new(System::plain(setting, &ports)?)?.at(0.0)?;
    let of = |row: usize| {
        loads
            .iter()
            .enumerate()
            .map(|(i, load)| at_rest[(row, i)].re * load.1)
            .sum()
    };
    Ok((0..ports.outputs.len()).map(of).collect())
}

/// Harmonics of one over a wave; nothing where the wave goes to zero.
fn compliance(shape: &Shape) -> Option<Vec<(u32, f64, f64)>> {
    /// Samples of a mesh cycle.
    const SAMPLES: usize = 4096;
    if shape.least() <= 0.0 {
        return None;
    }
    if let &Shape::Rectangular { high, low, duty } = shape {
        let step = 1.0 / high - 1.0 / low;
        let term = |n: u32| {
            let half = PI * f64::from(n) * duty;
            (n, 2.0 * step * half.sin() / (PI * f64::from(n)), -half)
        };
        return Some((1..=HARMONICS).map(term).collect());
    }
    let mut samples: Vec<f64> = (0..SAMPLES)
        .map(|k| 1.0 / shape.value(k as f64 / SAMPLES as f64))
        .collect();
    let largest = samples.iter().fold(0.0f64, |m, x| m.max(*x));
    let mut transform = RealFft::new(SAMPLES);
    let mut spectrum = vec![Complex::ZERO; transform.lines()];
    transform.forward(&mut samples, &mut spectrum);
    let term = |n: u32| {
        let z = spectrum[n as usize] * (2.0 / SAMPLES as f64);
        (n, z.norm(), z.arg())
    };
    // Of the compliance: below this stands rounding of the transform.
    Some(
        (1..=HARMONICS)
            .map(term)
            .filter(|t| t.1 > 1e-13 * largest)
            .collect(),
    )
}

fn loses_contact(setting: &Setting, branch: usize) -> Error {
    let element = &setting.machine.elements[setting.machine.branches[branch].element];
    let message = format!(
        "the stiffness of `{}` goes to zero in its cycle, so that it cannot carry its load",
        element.name
    );
    Error::new(Code::Conflict, message)
        .at(&element.place)
        .hint("raise the lower value of its `k_wave`, or leave out the loads")
}
