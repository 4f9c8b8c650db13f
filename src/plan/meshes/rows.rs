//! Rows of stage `meshes` in words: a mesh with and without a torque, with the errors of its curves.

use super::curves::{InterpolationError, MeshCurves};
use crate::base::quantity::format_number;
use crate::gear::bevel::flank_theory::ContactSide;
use crate::gear::load::load_table::{LoadInterpolation, LoadTable};
use crate::scene::model::MeshSprings;
use crate::scene::pair_mesh::PairMesh;

/// A mesh under no torque, in words.
pub fn unloaded_row(mesh: &PairMesh) -> String {
    match mesh {
        PairMesh::Cylindrical(_) => {
            "geometry alone, since no load is stated and the file has no torque".into()
        }
        PairMesh::Bevel(mesh) => format!(
            "directions at the reference contact, unloaded transmission error {} µm peak to peak{}; stiffness of the model, since no load is stated and the file has no torque",
            format_number(1e6 * mesh.peak_to_peak),
            coast_words(mesh.bevel.contact.side == ContactSide::Coast),
        ),
    }
}

fn coast_words(is_coast: bool) -> &'static str {
    if is_coast { " on coast flanks" } else { "" }
}

/// A mesh under its torque at the pinion, N·m, in words; cylindrical gears carry a torque below zero on their coast flanks.
pub fn loaded_row(mesh: &PairMesh, torque: f64, curves: &MeshCurves) -> String {
    let springs = match (&curves.flanks.springs, mesh) {
        (Some(MeshSprings::ToothPairs(pairs)), _) => {
            format!("{} tooth pairs for methods that locate events", pairs.count)
        }
        (Some(MeshSprings::LoadTable(table)), _) => {
            load_table_text(table, curves.stiffness * mesh.lever())
        }
        (None, PairMesh::Bevel(_)) => "one spring for all tooth pairs".into(),
        (None, _) => "no separate tooth pairs, because there is no play".into(),
    };
    let InterpolationError {
        positions,
        te,
        stiffness,
    } = curves.interpolation;
    format!(
        "at {} N·m of the pinion{}: along the normal of the teeth mean tangent k {} N/µm, transmission error {} µm peak to peak, {springs}; straight lines between {positions} positions are off by at most {} µm and {} % of k",
        format_number(torque.abs()),
        coast_words(match mesh {
            PairMesh::Cylindrical(_) => torque < 0.0,
            PairMesh::Bevel(mesh) => mesh.bevel.contact.side == ContactSide::Coast,
        }),
        format_number(1e-6 * curves.stiffness),
        format_number(1e6 * curves.peak_to_peak),
        format_number(1e6 * te),
        format_number(100.0 * stiffness),
    )
}

/// The load table of a mesh, in words; its loads times `to_torque` are N·m of the pinion.
fn load_table_text(table: &LoadTable, to_torque: f64) -> String {
    let loads = table.loads();
    let LoadInterpolation {
        deflection,
        secant,
        tangent,
    } = table.interpolation();
    format!(
        "one spring for all tooth pairs, which for methods that locate events follows e(φ, T) of {} torques from {} to {} N·m (between them e is off by at most {} µm, secant k by {} %, tangent k by {} % in the mean over the pitch)",
        loads.len(),
        format_number(to_torque * loads[0]),
        format_number(to_torque * loads[loads.len() - 1]),
        format_number(1e6 * deflection),
        format_number(100.0 * secant),
        format_number(100.0 * tangent),
    )
}
