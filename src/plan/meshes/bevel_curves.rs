//! Curves of a loaded bevel mesh along the normal of its reference contact: `e = r₂ te`, `k = K/r₂²`, r₂ the lever about the gear's axis.
//!
//! The mesh is one spring: with play it closes where its leading pair touches, and the coast flanks have the stiffness of the drive flanks
//! and no error. Where the file has a range of torques, its load over deflection goes through the range and the torque of the
//! mesh.

use std::sync::Arc;

use super::curves::{FlankCycle, InterpolationError, MeshCurves, mean, scaled};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::load::load_table::LoadTable;
use crate::numeric::sorting::sort_rising;
use crate::numeric::statistics::peak_to_peak;
use crate::plan::gear::bevel_member;
use crate::plan::gear::bevel_mesh::LoadedPair;
use crate::scene::bevel_mesh::BevelMesh;
use crate::scene::model::{MeshFlanks, MeshSprings, StiffnessVariation};

/// Torques of the range closer than this, relative, to that of the mesh give way to it: the table has no piece so short.
const SAME_TORQUE: f64 = 0.01;

/// The mesh at a torque of the pinion, N·m above zero, on its drive or its coast flanks.
///
/// # Errors
/// Flanks that the file does not ask for; as [`LoadedPair::mesh`].
pub fn curves(mesh: &BevelMesh, torque: f64, is_coast: bool) -> Result<MeshCurves, Error> {
    let side = ["drive", "coast"];
    let wanted = side[usize::from(is_coast)];
    if mesh.is_coast() != is_coast {
        let message = format!(
            "the mean loads carry the {wanted} flanks, and the file describes the contact of its {} flanks",
            side[usize::from(mesh.is_coast())]
        );
        return Err(Error::new(Code::Conflict, message).with_hint(format!(
            "set `side = \"{wanted}\"` in [contact] of the gear file, or turn the loads round"
        )));
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
    let given_way = torque / mesh.levers[0] / stiffness;
    let flank = FlankCycle {
        is_forward: mesh.is_forward,
        phase: 0.0,
    };
    let table = LoadTable::of(&result.mesh).map(|table| {
        let table = table.scaled((lever * stiffness).recip(), lever);
        MeshSprings::LoadTable(Arc::new(match mesh.is_forward {
            true => table,
            false => table.reversed(),
        }))
    });
    Ok(MeshCurves {
        stiffness,
        wave: StiffnessVariation {
            waveform: flank.table(scaled(&secant, stiffness.recip())),
            phase: flank.phase,
        },
        flanks: MeshFlanks {
            unloaded_te: flank.table(scaled(&result.mesh.unloaded_te, lever)),
            averaged_te: flank.table(te.iter().map(|e| e + given_way).collect()),
            phase: flank.phase,
            is_coast,
            springs: table,
        },
        peak_to_peak: peak_to_peak(&te),
        interpolation: InterpolationError::of(&te, &secant),
        warnings,
    })
}

/// The torque of the mesh and, where the file has several, as many from the first to the last, rising: in equal ratios, since the stiffness
/// varies most where the first teeth begin to carry.
fn table_torques(of_file: &[f64], torque: f64) -> Vec<f64> {
    let mut all = vec![torque];
    if let [first, .., last] = of_file {
        let step = (last / first).ln() / (of_file.len() - 1) as f64;
        let geometric = (0..of_file.len()).map(|k| first * (step * k as f64).exp());
        all.extend(geometric.filter(|t| (t / torque - 1.0).abs() > SAME_TORQUE));
    }
    sort_rising(&mut all, |t| *t);
    all
}
