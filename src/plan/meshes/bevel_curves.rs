//! Curves of a loaded bevel mesh along the normal of its reference contact: `e = r₂ te`, `k = K/r₂²` with the lever r₂ about the gear axis.
//!
//! The mesh is one spring. With backlash it closes at the contact of its leading pair, and the coast flanks have the stiffness of the
//! drive flanks and no error. If the file states a range of torques, the load–deflection table contains the range and the torque of the
//! mesh.

use std::sync::Arc;

use super::curves::{InterpolationError, MeshCurves, mean, scaled};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::load::load_table::LoadTable;
use crate::numeric::sorting::sort_ascending;
use crate::numeric::statistics::peak_to_peak;
use crate::plan::gear::bevel::hand_name;
use crate::plan::gear::bevel_member;
use crate::plan::gear::bevel_mesh::LoadedPair;
use crate::scene::bevel_mesh::BevelMesh;
use crate::scene::laws::Waveform;
use crate::scene::model::{MeshFlanks, MeshSprings, StiffnessVariation};

/// Relative distance below which a torque of the range is replaced by the torque of the mesh: the table has no shorter interval.
const SAME_TORQUE: f64 = 0.01;

/// Curves of the mesh at a pinion torque of absolute value `torque`, N·m; `is_coast` if the pinion torque is negative.
///
/// # Errors
/// The flanks of the file do not carry the torque; errors of [`LoadedPair::mesh`].
pub fn curves(mesh: &BevelMesh, torque: f64, is_coast: bool) -> Result<MeshCurves, Error> {
    if mesh.is_backward != is_coast {
        return Err(flank_error(mesh));
    }
    let file = &mesh.bevel;
    let teeth = [0, 1].map(|k| bevel_member::tooth(file, k));
    let mut warnings = Vec::new();
    let teeth = teeth.each_ref().map(Option::as_ref);
    let loaded = LoadedPair::new(file, teeth, (&mesh.pair, &mesh.path))?;
    let torques = table_torques(&file.mesh.torques, torque);
    let result = loaded.mesh(&torques, &mut warnings)?;
    let lever = mesh.levers[1];
    let to_newton_per_metre = lever.powi(-2);
    let cycle = &result.mesh.cycles[torques.partition_point(|t| *t < torque)];
    let te = scaled(&cycle.of(|p| p.te), lever);
    let secant = scaled(&cycle.of(|p| p.secant), to_newton_per_metre);
    let stiffness = mean(&scaled(&cycle.of(|p| p.tangent), to_newton_per_metre));
    let deflection = torque / mesh.levers[0] / stiffness;
    let springs = LoadTable::of(&result.mesh).map(|table| {
        MeshSprings::LoadTable(Arc::new(table.scaled((lever * stiffness).recip(), lever)))
    });
    Ok(MeshCurves {
        stiffness,
        wave: StiffnessVariation {
            waveform: Waveform::Table(scaled(&secant, stiffness.recip())),
            phase: 0.0,
        },
        flanks: MeshFlanks {
            unloaded_te: Waveform::Table(scaled(&result.mesh.unloaded_te, lever)),
            averaged_te: Waveform::Table(te.iter().map(|e| e + deflection).collect()),
            phase: 0.0,
            is_coast,
            springs,
        },
        peak_to_peak: peak_to_peak(&te),
        interpolation: InterpolationError::of(&te, &secant),
        warnings,
    })
}

/// Error for mean loads carried by the flanks that the file does not describe.
fn flank_error(mesh: &BevelMesh) -> Error {
    let side = mesh.bevel.contact.side;
    let other = side.other();
    let hand = hand_name(mesh.bevel.hand);
    let [carried, pressed] = match mesh.is_backward {
        true => ["below", "above"],
        false => ["above", "below"],
    };
    let message = format!(
        "the mean torque on the {hand}-hand pinion is {pressed} zero and loads its {} flanks; the file describes the contact of its {} flanks, which take a torque {carried} zero",
        other.name(),
        side.name()
    );
    Error::new(Code::Conflict, message).with_hint(format!(
        "reverse loads and speeds, or set `side = \"{}\"` in [contact] of the gear file",
        other.name()
    ))
}

/// Torques of the load table, N·m, ascending: the torque of the mesh and, if the file states several, as many from the first to the last
/// in a geometric sequence, since the stiffness varies most at small loads.
fn table_torques(file_torques: &[f64], torque: f64) -> Vec<f64> {
    let mut torques = vec![torque];
    if let [first, .., last] = file_torques {
        let step = (last / first).ln() / (file_torques.len() - 1) as f64;
        let geometric = (0..file_torques.len()).map(|k| first * (step * k as f64).exp());
        torques.extend(geometric.filter(|t| (t / torque - 1.0).abs() > SAME_TORQUE));
    }
    sort_ascending(&mut torques, |t| *t);
    torques
}
