//! Quasi-static transmission error under load: mesh deflection `F̄ / k(φ)`.
//!
//! On a tree F̄ follows from the loads alone, and the result is exact. In a loop F̄ varies slightly with k(φ); each mesh is treated
//! separately with F̄ at the mean stiffness.

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

/// Number of mesh harmonics retained.
const MESH_HARMONICS: u32 = 16;

/// Loaded mesh whose stiffness varies over the mesh cycle.
struct LoadedMesh<'a> {
    branch: usize,
    wave: &'a StiffnessVariation,
    /// Mesh cycles per revolution of the order reference.
    cycles: Fraction,
    /// Mean deflection F̄/k, m.
    mean_deflection: f64,
}

/// Rotating meshes of varying stiffness under the mean loads.
fn loaded_meshes<'a>(
    model: &OperatingModel<'a>,
    chain: &TransmissionChain,
) -> Result<Vec<LoadedMesh<'a>>, Error> {
    let machine = model.machine;
    if machine.loads.is_empty() {
        return Ok(Vec::new());
    }
    let loaded_mesh = |index: usize| {
        let branch = &machine.branches[index];
        let (Some(wave), BranchLaw::Linear { stiffness, .. }) =
            (&branch.stiffness_variation, branch.law)
        else {
            return None;
        };
        let cycle = *mesh_cycle::cycles(machine, index).first()?;
        let ratio = chain.ratio(cycle.rotation)?;
        let carrier = cycle.carrier.and_then(|c| chain.ratio(c));
        let relative = ratio - carrier.unwrap_or(&Fraction::zero());
        let cycles = &relative * &Fraction::from_f64(cycle.teeth as f64);
        (!cycles.is_zero()).then_some(LoadedMesh {
            branch: index,
            wave,
            cycles,
            mean_deflection: 1.0 / stiffness,
        })
    };
    let branches = model.model.branches.iter();
    let mut meshes: Vec<LoadedMesh> = branches.filter_map(|b| loaded_mesh(b.index)).collect();
    if meshes.is_empty() {
        return Ok(meshes);
    }
    let branches: Vec<usize> = meshes.iter().map(|w| w.branch).collect();
    let forces = mean_forces(model, chain, &branches)?;
    for (mesh, force) in meshes.iter_mut().zip(forces) {
        mesh.mean_deflection *= force;
    }
    meshes.retain(|w| w.mean_deflection != 0.0);
    Ok(meshes)
}

/// Order lines of meshes whose stiffness varies over the cycle, under the mean loads; their kinematic part is zero.
///
/// # Errors
/// A stiffness that falls to zero under load; errors of the equations.
pub fn stiffness_lines(
    model: &OperatingModel,
    chain: &TransmissionChain,
) -> Result<Vec<OrderLine>, Error> {
    let mut lines = Vec::new();
    for mesh in loaded_meshes(model, chain)? {
        let sense = angle_sense(chain, &mesh.cycles);
        for (n, a, phase) in compliance(model, &mesh)?.harmonics {
            let angle = phase + f64::from(n) * mesh.wave.phase;
            let e = Complex::new(angle.cos(), sense * angle.sin()) * (mesh.mean_deflection * a);
            lines.push(OrderLine {
                order: mesh.cycles.abs().times(n),
                origin: LineOrigin::Stiffness(mesh.branch),
                harmonic: n,
                displacements: vec![(mesh.branch, e)],
                quasi_static: Complex::ZERO,
            });
        }
    }
    Ok(lines)
}

/// Adds the lines of loaded meshes to those of errors. A mesh of a gear file has one line per order, the sum of its unloaded flank error
/// and its deflection; flank errors beyond the retained harmonics of the stiffness are removed.
pub fn join_mesh_lines(machine: &Machine, lines: &mut Vec<OrderLine>, stiffness: Vec<OrderLine>) {
    for mut line in stiffness {
        let is_same_line = |other: &OrderLine| {
            let is_flank_error = other
                .declared(machine)
                .is_some_and(|e| e.averaged.is_some());
            is_flank_error
                && other.order == line.order
                && other.displacements[0].0 == line.displacements[0].0
        };
        if let Some(index) = lines.iter().position(is_same_line) {
            let flanks = lines.remove(index);
            line.displacements[0].1 += flanks.displacements[0].1;
            line.quasi_static = flanks.quasi_static;
        }
        lines.push(line);
    }
    let is_alone = |line: &OrderLine| {
        let is_flank = line.declared(machine).is_some_and(|e| e.averaged.is_some());
        is_flank && line.harmonic > MESH_HARMONICS && !machine.loads.is_empty()
    };
    lines.retain(|line| !is_alone(line));
}

/// Mean forces of branches under the constant loads, N or N·m, with the driver fixed.
///
/// # Errors
/// Errors of the equations.
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
    static_response(model, chain, branches.iter().map(port).collect())
}

/// Wind-up of the output under the loads, mean over the mesh cycles, rad. A mesh of varying stiffness contributes `F̄ · mean(1/k)`, which
/// exceeds F̄ over its mean stiffness.
///
/// # Errors
/// Errors of [`stiffness_lines`].
pub fn windup(model: &OperatingModel, chain: &TransmissionChain) -> Result<f64, Error> {
    let output = Port {
        name: model.machine.dof_name(chain.ends.output),
        unit: "rad",
        kind: ResponseOutput::Sum(chain.combination.clone(), 0),
    };
    let windup = chain.output_sense() * static_response(model, chain, vec![output])?[0];
    let excess = |mesh: &LoadedMesh| -> Result<(usize, Complex), Error> {
        let deflection = mesh.mean_deflection * (compliance(model, mesh)?.mean - 1.0);
        Ok((mesh.branch, Complex::new(deflection, 0.0)))
    };
    let line = OrderLine {
        order: Fraction::zero(),
        origin: LineOrigin::Stiffness(0),
        harmonic: 0,
        displacements: (loaded_meshes(model, chain)?.iter())
            .map(excess)
            .collect::<Result<_, _>>()?,
        quasi_static: Complex::ZERO,
    };
    if line.displacements.is_empty() {
        return Ok(windup);
    }
    let lines = [line];
    let transfer = ErrorTransfer::new(model, chain, &lines, ResponseMethod::Direct)?;
    Ok(windup + transfer.at_speed(0.0, &lines)?[0].re)
}

fn static_response(
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
    let response = DirectSolver::new(model, &ports)?.response_at(0.0)?;
    let output = |row: usize| {
        loads
            .iter()
            .enumerate()
            .map(|(i, load)| response[(row, i)].re * load.1)
            .sum()
    };
    Ok((0..ports.outputs.len()).map(output).collect())
}

/// Fourier series of the reciprocal of a stiffness waveform.
struct MeshCompliance {
    mean: f64,
    /// Harmonic n, amplitude a and phase φ, rad.
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
    let (mean, harmonics): (f64, Vec<(u32, f64, f64)>) = match *waveform {
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
    let is_significant = |term: &(u32, f64, f64)| term.1.abs() > ROUNDING * mean;
    Ok(MeshCompliance {
        mean,
        harmonics: harmonics.into_iter().filter(is_significant).collect(),
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
