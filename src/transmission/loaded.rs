//! The slow machine under torque: a mesh that carries F̄ gives way by `F̄ / k(φ)`, which acts like a displacement of that mesh.
//!
//! On a tree F̄ follows from the loads alone, and this is exact. In a loop F̄ itself changes a little with k(φ), and each mesh is
//! taken by itself with F̄ at the mean stiffness.

use std::f64::consts::PI;

use super::chain::Chain;
use super::dynamic::Transfer;
use super::lines::{Line, Origin, rising};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::mesh_cycle;
use crate::machine::parts::Law;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;
use crate::numeric::fraction::Fraction;
use crate::response::direct::Direct;
use crate::response::frequency::Way;
use crate::response::ports::{Input, Output, Port, Ports};
use crate::response::system::Setting;
use crate::scene::laws::Shape;
use crate::scene::model::StiffnessWave;

/// Harmonics of a mesh that are kept.
const HARMONICS: u32 = 16;

/// A mesh whose stiffness changes over its cycle while it carries a force.
struct Waving<'a> {
    branch: usize,
    wave: &'a StiffnessWave,
    /// Its cycles per turn that orders are counted by.
    cycles: Fraction,
    /// F̄/k, m.
    given: f64,
}

/// Those that turn, under the mean loads.
fn waving<'a>(setting: &Setting<'a>, chain: &Chain) -> Result<Vec<Waving<'a>>, Error> {
    let machine = setting.machine;
    if machine.loads.is_empty() {
        return Ok(Vec::new());
    }
    let one = |index: usize| {
        let part = &machine.branches[index];
        let (Some(wave), Law::Linear { stiffness, .. }) = (&part.wave, part.law) else {
            return None;
        };
        let cycle = *mesh_cycle::cycles(machine, index).first()?;
        let own = chain.turns(cycle.turning)?;
        let carried = cycle.carrier.and_then(|c| chain.turns(c));
        let relative = own - carried.unwrap_or(&Fraction::zero());
        let cycles = &relative * &Fraction::of(cycle.teeth as f64);
        (!cycles.is_zero()).then_some(Waving {
            branch: index,
            wave,
            cycles,
            given: 1.0 / stiffness,
        })
    };
    let branches = setting.linear.branches.iter();
    let mut all: Vec<Waving> = branches.filter_map(|b| one(b.index)).collect();
    if all.is_empty() {
        return Ok(all);
    }
    let branches: Vec<usize> = all.iter().map(|w| w.branch).collect();
    let forces = forces(setting, chain, &branches)?;
    all.iter_mut().zip(forces).for_each(|(w, f)| w.given *= f);
    all.retain(|w| w.given != 0.0);
    Ok(all)
}

/// Lines of meshes whose stiffness changes over the cycle, under the mean loads; their kinematic part is zero.
///
/// # Errors
/// A stiffness that goes to zero under load; those of the equations.
pub fn lines(setting: &Setting, chain: &Chain) -> Result<Vec<Line>, Error> {
    let mut all = Vec::new();
    for mesh in waving(setting, chain)? {
        let rising = rising(chain, &mesh.cycles);
        for (n, a, phase) in compliance(setting, &mesh)?.harmonics {
            let angle = phase + f64::from(n) * mesh.wave.lead;
            let e = Complex::new(angle.cos(), rising * angle.sin()) * (mesh.given * a);
            all.push(Line {
                order: mesh.cycles.abs().times(n),
                origin: Origin::Stiffness(mesh.branch),
                harmonic: n,
                displacements: vec![(mesh.branch, e)],
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

/// By how much the loads wind the chain up at its end, in the mean over the mesh cycles, rad: `F̄ · mean(1/k)` of a mesh whose stiffness
/// changes, which is more than F̄ over its mean.
///
/// # Errors
/// Those of [`lines`].
pub fn wind_up(setting: &Setting, chain: &Chain) -> Result<f64, Error> {
    let output = Port {
        name: setting.machine.freedom_name(chain.ends.output),
        unit: "rad",
        what: Output::Sum(chain.combination.clone(), 0),
    };
    let at_k = chain.sense() * under_load(setting, chain, vec![output])?[0];
    let beyond = |mesh: &Waving| -> Result<(usize, Complex), Error> {
        let more = mesh.given * (compliance(setting, mesh)?.mean - 1.0);
        Ok((mesh.branch, Complex::new(more, 0.0)))
    };
    let still = Line {
        order: Fraction::zero(),
        origin: Origin::Stiffness(0),
        harmonic: 0,
        displacements: (waving(setting, chain)?.iter())
            .map(beyond)
            .collect::<Result<_, _>>()?,
        kinematic: Complex::ZERO,
    };
    if still.displacements.is_empty() {
        return Ok(at_k);
    }
    let still = [still];
    let transfer = Transfer::new(setting, chain, &still, Way::Direct)?;
    Ok(at_k + transfer.at_speed(0.0, &still)?[0].re)
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
    let at_rest = Direct::new(setting, &ports)?.at(0.0)?;
    let of = |row: usize| {
        loads
            .iter()
            .enumerate()
            .map(|(i, load)| at_rest[(row, i)].re * load.1)
            .sum()
    };
    Ok((0..ports.outputs.len()).map(of).collect())
}

/// One over a wave.
struct Compliance {
    mean: f64,
    /// n, a, φ.
    harmonics: Vec<(u32, f64, f64)>,
}

fn compliance(setting: &Setting, mesh: &Waving) -> Result<Compliance, Error> {
    /// Samples of a mesh cycle.
    const SAMPLES: usize = 4096;
    /// Of the compliance: below this stands rounding of the transform.
    const ROUNDING: f64 = 1e-13;
    let shape = &mesh.wave.shape;
    if shape.least() <= 0.0 {
        return Err(loses_contact(setting, mesh.branch));
    }
    let (mean, all): (f64, Vec<(u32, f64, f64)>) = match *shape {
        Shape::Rectangular { high, low, duty } => {
            let step = 1.0 / high - 1.0 / low;
            let term = |n: u32| {
                let half = PI * f64::from(n) * duty;
                (n, 2.0 * step * half.sin() / (PI * f64::from(n)), -half)
            };
            let mean = duty / high + (1.0 - duty) / low;
            (mean, (1..=HARMONICS).map(term).collect())
        }
        _ => {
            let mut samples: Vec<f64> = (0..SAMPLES)
                .map(|k| 1.0 / shape.value(k as f64 / SAMPLES as f64))
                .collect();
            let mut transform = RealFft::new(SAMPLES);
            let mut spectrum = vec![Complex::ZERO; transform.lines()];
            transform.forward(&mut samples, &mut spectrum);
            let term = |n: u32| {
                let z = spectrum[n as usize] * (2.0 / SAMPLES as f64);
                (n, z.norm(), z.arg())
            };
            let mean = spectrum[0].re / SAMPLES as f64;
            (mean, (1..=HARMONICS).map(term).collect())
        }
    };
    let counts = |term: &(u32, f64, f64)| term.1.abs() > ROUNDING * mean;
    Ok(Compliance {
        mean,
        harmonics: all.into_iter().filter(counts).collect(),
    })
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
