//! Quasi-static transmission error under load: mesh deflection `F̄ / k(φ)`.
//!
//! On a tree F̄ follows from the loads alone, and this is exact. In a loop F̄ itself changes a little with k(φ), and each mesh is
//! taken by itself with F̄ at the mean stiffness.

use std::f64::consts::PI;

use super::chain::TransmissionChain;
use super::dynamic::ErrorTransfer;
use super::order_lines::{LineOrigin, OrderLine, angle_sense};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::machine::components::{BranchLaw, Machine};
use crate::machine::mesh_cycle;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;
use crate::numeric::fraction::Fraction;
use crate::response::direct::DirectSolver;
use crate::response::frf::ResponseMethod;
use crate::response::ports::{Port, Ports, ResponseInput, ResponseOutput};
use crate::response::system::OperatingModel;
use crate::scene::laws::Waveform;
use crate::scene::model::StiffnessVariation;

/// Harmonics of a mesh that are kept.
const MESH_HARMONICS: u32 = 16;

/// A mesh whose stiffness changes over its cycle while it carries a force.
struct LoadedMesh<'a> {
    branch: usize,
    wave: &'a StiffnessVariation,
    /// Mesh cycles per turn that orders are counted by.
    cycles: Fraction,
    /// F̄/k, m.
    mean_deflection: f64,
}

/// Those that turn, under the mean loads.
fn loaded_meshes<'a>(
    model: &OperatingModel<'a>,
    chain: &TransmissionChain,
) -> Result<Vec<LoadedMesh<'a>>, Error> {
    let machine = model.machine;
    if machine.loads.is_empty() {
        return Ok(Vec::new());
    }
    let one = |index: usize| {
        let part = &machine.branches[index];
        let (Some(wave), BranchLaw::Linear { stiffness, .. }) =
            (&part.stiffness_variation, part.law)
        else {
            return None;
        };
        let cycle = *mesh_cycle::cycles(machine, index).first()?;
        let own = chain.ratio(cycle.turning)?;
        let carried = cycle.carrier.and_then(|c| chain.ratio(c));
        let relative = own - carried.unwrap_or(&Fraction::zero());
        let cycles = &relative * &Fraction::from_f64(cycle.teeth as f64);
        (!cycles.is_zero()).then_some(LoadedMesh {
            branch: index,
            wave,
            cycles,
            mean_deflection: 1.0 / stiffness,
        })
    };
    let branches = model.model.branches.iter();
    let mut all: Vec<LoadedMesh> = branches.filter_map(|b| one(b.index)).collect();
    if all.is_empty() {
        return Ok(all);
    }
    let branches: Vec<usize> = all.iter().map(|w| w.branch).collect();
    let forces = mean_forces(model, chain, &branches)?;
    all.iter_mut()
        .zip(forces)
        .for_each(|(w, f)| w.mean_deflection *= f);
    all.retain(|w| w.mean_deflection != 0.0);
    Ok(all)
}

/// Lines of meshes whose stiffness changes over the cycle, under the mean loads; their kinematic part is zero.
///
/// # Errors
/// A stiffness that goes to zero under load; those of the equations.
pub fn stiffness_lines(
    model: &OperatingModel,
    chain: &TransmissionChain,
) -> Result<Vec<OrderLine>, Error> {
    let mut all = Vec::new();
    for mesh in loaded_meshes(model, chain)? {
        let rising = angle_sense(chain, &mesh.cycles);
        for (n, a, phase) in compliance(model, &mesh)?.harmonics {
            let angle = phase + f64::from(n) * mesh.wave.phase;
            let e = Complex::new(angle.cos(), rising * angle.sin()) * (mesh.mean_deflection * a);
            all.push(OrderLine {
                order: mesh.cycles.abs().times(n),
                origin: LineOrigin::Stiffness(mesh.branch),
                harmonic: n,
                displacements: vec![(mesh.branch, e)],
                quasi_static: Complex::ZERO,
            });
        }
    }
    Ok(all)
}

/// Adds the lines of meshes under load to those of errors. A mesh of a gear file has one line for each order: its flanks' error without
/// load and what its teeth give way; beyond the harmonics that are kept of stiffnesses neither is listed alone.
pub fn join_mesh_lines(machine: &Machine, lines: &mut Vec<OrderLine>, stiffness: Vec<OrderLine>) {
    for mut line in stiffness {
        let of_flanks = |other: &OrderLine| {
            let flanks = other
                .declared(machine)
                .is_some_and(|e| e.averaged.is_some());
            flanks
                && other.order == line.order
                && other.displacements[0].0 == line.displacements[0].0
        };
        if let Some(at) = lines.iter().position(of_flanks) {
            let flanks = lines.remove(at);
            line.displacements[0].1 += flanks.displacements[0].1;
            line.quasi_static = flanks.quasi_static;
        }
        lines.push(line);
    }
    let alone = |line: &OrderLine| {
        let flanks = line.declared(machine).is_some_and(|e| e.averaged.is_some());
        flanks && line.harmonic > MESH_HARMONICS && !machine.loads.is_empty()
    };
    lines.retain(|line| !alone(line));
}

/// Mean forces of branches under the lasting loads, N or N·m, the driver's angle held.
///
/// # Errors
/// Those of the equations.
pub fn mean_forces(
    model: &OperatingModel,
    chain: &TransmissionChain,
    branches: &[usize],
) -> Result<Vec<f64>, Error> {
    let port = |branch: &usize| Port {
        name: model.machine.branch_name(*branch),
        unit: "N",
        kind: ResponseOutput::Force(*branch),
    };
    under_load(model, chain, branches.iter().map(port).collect())
}

/// By how much the loads wind the chain up at its end, in the mean over the mesh cycles, rad: `F̄ · mean(1/k)` of a mesh whose stiffness
/// changes, which is more than F̄ over its mean.
///
/// # Errors
/// Those of [`stiffness_lines`].
pub fn windup(model: &OperatingModel, chain: &TransmissionChain) -> Result<f64, Error> {
    let output = Port {
        name: model.machine.dof_name(chain.ends.output),
        unit: "rad",
        kind: ResponseOutput::Sum(chain.combination.clone(), 0),
    };
    let at_k = chain.output_sense() * under_load(model, chain, vec![output])?[0];
    let beyond = |mesh: &LoadedMesh| -> Result<(usize, Complex), Error> {
        let more = mesh.mean_deflection * (compliance(model, mesh)?.mean - 1.0);
        Ok((mesh.branch, Complex::new(more, 0.0)))
    };
    let still = OrderLine {
        order: Fraction::zero(),
        origin: LineOrigin::Stiffness(0),
        harmonic: 0,
        displacements: (loaded_meshes(model, chain)?.iter())
            .map(beyond)
            .collect::<Result<_, _>>()?,
        quasi_static: Complex::ZERO,
    };
    if still.displacements.is_empty() {
        return Ok(at_k);
    }
    let still = [still];
    let transfer = ErrorTransfer::new(model, chain, &still, ResponseMethod::Direct)?;
    Ok(at_k + transfer.at_speed(0.0, &still)?[0].re)
}

fn under_load(
    model: &OperatingModel,
    chain: &TransmissionChain,
    outputs: Vec<Port<ResponseOutput>>,
) -> Result<Vec<f64>, Error> {
    let loads = &model.machine.loads;
    if loads.is_empty() {
        return Ok(vec![0.0; outputs.len()]);
    }
    let input = |load: &(usize, f64)| Port {
        name: model.machine.dof_name(load.0),
        unit: "N·m",
        kind: ResponseInput::Torque(load.0),
    };
    let ports = Ports {
        inputs: loads.iter().map(input).collect(),
        outputs,
        fixed: chain.fixed.clone(),
    };
    let at_rest = DirectSolver::new(model, &ports)?.response_at(0.0)?;
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
struct MeshCompliance {
    mean: f64,
    /// n, a, φ.
    harmonics: Vec<(u32, f64, f64)>,
}

fn compliance(model: &OperatingModel, mesh: &LoadedMesh) -> Result<MeshCompliance, Error> {
    /// Samples of a mesh cycle.
    const SAMPLES: usize = 4096;
    /// Rounding level of the transform, relative to the compliance.
    const ROUNDING: f64 = 1e-13;
    let waveform = &mesh.wave.waveform;
    if waveform.lower_bound() <= 0.0 {
        return Err(contact_loss_error(model, mesh.branch));
    }
    let (mean, all): (f64, Vec<(u32, f64, f64)>) = match *waveform {
        Waveform::Rectangular { high, low, duty } => {
            let step = 1.0 / high - 1.0 / low;
            let term = |n: u32| {
                let half = PI * f64::from(n) * duty;
                (n, 2.0 * step * half.sin() / (PI * f64::from(n)), -half)
            };
            let mean = duty / high + (1.0 - duty) / low;
            (mean, (1..=MESH_HARMONICS).map(term).collect())
        }
        _ => {
            let mut samples: Vec<f64> = (0..SAMPLES)
                .map(|k| 1.0 / waveform.value(k as f64 / SAMPLES as f64))
                .collect();
            let mut transform = RealFft::new(SAMPLES);
            let mut spectrum = vec![Complex::ZERO; transform.lines()];
            transform.forward(&mut samples, &mut spectrum);
            let term = |n: u32| {
                let z = spectrum[n as usize] * (2.0 / SAMPLES as f64);
                (n, z.norm(), z.arg())
            };
            let mean = spectrum[0].re / SAMPLES as f64;
            (mean, (1..=MESH_HARMONICS).map(term).collect())
        }
    };
    let counts = |term: &(u32, f64, f64)| term.1.abs() > ROUNDING * mean;
    Ok(MeshCompliance {
        mean,
        harmonics: all.into_iter().filter(counts).collect(),
    })
}

fn contact_loss_error(model: &OperatingModel, branch: usize) -> Error {
    let element = &model.machine.elements[model.machine.branches[branch].element];
    let message = format!(
        "the stiffness of `{}` goes to zero in its cycle, so that it cannot carry its load",
        element.name
    );
    Error::new(Code::Conflict, message)
        .with_span(&element.span)
        .with_hint("raise the lower value of its `k_wave`, or omit the loads")
}
