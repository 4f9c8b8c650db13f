//! Curves of a loaded bevel mesh along the normal of its reference contact: `e = r₂ te`, `k = K/r₂²`, r₂ the lever about the gear's axis.
//!
//! The mesh is one spring: with play it closes where its leading pair touches, and the coast flanks have the stiffness of the drive flanks
//! and no error. Where the file has a range of torques, its load over deflection goes through the range and the torque of the
//! mesh.

use std::sync::Arc;

use super::curves::{InterpolationError, MeshCurves, mean, scaled};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::load::load_table::LoadTable;
use crate::numeric::sorting::sort_rising;
use crate::numeric::statistics::peak_to_peak;
use crate::plan::gear::bevel::hand_name;
use crate::plan::gear::bevel_member;
use crate::plan::gear::bevel_mesh::LoadedPair;
use crate::scene::bevel_file::ContactSide;
use crate::scene::bevel_mesh::BevelMesh;
use crate::scene::laws::Waveform;
use crate::scene::model::{MeshFlanks, MeshSprings, StiffnessVariation};

/// Torques of the range closer than this, relative, to that of the mesh give way to it: the table has no piece so short.
const SAME_TORQUE: f64 = 0.01;

/// The mesh at the size of a torque of the pinion, N·m, that is above zero or `is_coast`.
///
/// # Errors
/// A torque that the flanks of the file do not carry; as [`LoadedPair::mesh`].
pub fn curves(mesh: &BevelMesh, torque: f64, is_coast: bool) -> Result<MeshCurves, Error> {
    if mesh.is_backward != is_coast {
        return Err(other_flanks(mesh));
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
    let table = LoadTable::of(&result.mesh).map(|table| {
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
            averaged_te: Waveform::Table(te.iter().map(|e| e + given_way).collect()),
            phase: 0.0,
            is_coast,
            springs: table,
        },
        peak_to_peak: peak_to_peak(&te),
        interpolation: InterpolationError::of(&te, &secant),
        warnings,
    })
}

/// The error of mean loads that press the other flanks than those of the file.
fn other_flanks(mesh: &BevelMesh) -> Error {
    let here = mesh.bevel.contact.side;
    let other = match here {
        ContactSide::Drive => ContactSide::Coast,
        ContactSide::Coast => ContactSide::Drive,
    };
    let hand = hand_name(mesh.bevel.hand);
    let [carried, pressed] = match mesh.is_backward {
        true => ["below", "above"],
        false => ["above", "below"],
    };
    let message = format!(
        "the mean loads put a torque {pressed} zero on the {hand}-hand pinion, which its {} flanks carry; the file describes the contact of its {} flanks, which carry a torque {carried} zero",
        other.name(),
        here.name()
    );
    Error::new(Code::Conflict, message).with_hint(format!(
        "turn loads and speeds round, or set `side = \"{}\"` in [contact] of the gear file",
        other.name()
    ))
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
