//! Stages of a gear file: geometry, path of contact, stiffness, mesh under load.

use super::drawing::{DrawingReading, readings};
use super::geometry::{GearQuantity, quantities};
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::gear::cylindrical::backlash::BacklashLimits;
use crate::gear::cylindrical::pair::Pair;
use crate::gear::cylindrical::path_points::PathPoint;
use crate::gear::cylindrical::warnings::Warning;
use crate::gear::load::compliance::{StiffnessMethod, StiffnessRow, compare_methods};
use crate::gear::load::material::Material;
use crate::gear::load::mesh::LoadedMesh;
use crate::gear::load::mesh_result::MeshResult;
use crate::plan::gear_limits as limits;
use crate::plan::stages::StageDecision;
use crate::scene::gear_file::GearFile;

/// Results of a gear file.
#[derive(Debug, Clone)]
pub struct GearResult {
    /// The pair.
    pub pair: Pair,
    /// Geometry of the pair.
    pub quantities: Vec<GearQuantity>,
    /// Limits that the pair meets, with what avoids them.
    pub limits: Vec<Warning>,
    /// Readings of the drawing of pinion and gear.
    pub drawing: [Vec<DrawingReading>; 2],
    /// Backlash without deviations and at their limits; `None` where the base circles do not reach each other.
    pub backlash: Option<BacklashLimits>,
    /// Points A–E of the path of contact, the pinion driving, with their letters.
    pub path: Vec<(&'static str, PathPoint)>,
    /// Stiffness by both methods side by side; empty where no load is requested.
    pub stiffness: Vec<StiffnessRow>,
    /// Loaded transmission error, where a torque is given.
    pub mesh: Option<MeshResult>,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Computes what a gear file determines.
///
/// # Errors
/// Gears that cannot be made or cannot mesh; a load that cannot be carried.
pub fn run(file: &GearFile) -> Result<GearResult, Error> {
    let at = |error: Error| match error.span {
        Some(_) => error,
        None => error.with_span(&file.span),
    };
    let pair = file.pair()?;
    let limits = pair.warnings();
    let mut diagnostics: Vec<Diagnostic> = limits.iter().map(limits::diagnostic).collect();
    let backlash = pair.backlash_limits(file.centre_deviation);
    diagnostics.extend(backlash.as_ref().and_then(overlap));
    let reaches = pair.path_length() > 0.0;
    let path = match reaches {
        true => pair.path_points().named().to_vec(),
        false => Vec::new(),
    };
    let loaded = !file.mesh.torques.is_empty();
    let (stiffness, mesh) = match loaded {
        true => {
            let (stiffness, mesh) = load(file, &pair).map_err(at)?;
            (stiffness, Some(mesh))
        }
        false => (Vec::new(), None),
    };
    diagnostics.extend(mesh.iter().flat_map(|mesh| mesh.warnings.iter().cloned()));
    Ok(GearResult {
        quantities: quantities(&pair),
        limits,
        drawing: [0, 1].map(|k| readings(&pair.members[k], file.ball_diameters[k])),
        backlash,
        plan: plan(file),
        pair,
        path,
        stiffness,
        mesh,
        diagnostics,
    })
}

/// Backlash below zero by less than this is rounding of the data, m.
const ROUNDING: f64 = 1e-6;

/// Teeth that would have to overlap.
fn overlap(limits: &BacklashLimits) -> Option<Diagnostic> {
    let least = limits.least.circumferential;
    (least < -ROUNDING).then(|| Diagnostic {
        code: "no-backlash",
        message: format!(
            "the least backlash is {:.1} µm at the pitch circle: the teeth would overlap",
            1e6 * least
        ),
        hint: Some(
            "increase the centre distance, decrease the profile shifts, or give thickness = [\"lower\", \"upper\"] below zero"
                .into(),
        ),
    })
}

/// The stiffness by both methods, and the mesh at every torque by the requested one.
fn load(file: &GearFile, pair: &Pair) -> Result<(Vec<StiffnessRow>, MeshResult), Error> {
    let study = &file.mesh;
    let materials = [Material::default(); 2];
    let other = match study.method {
        StiffnessMethod::Energy { .. } => StiffnessMethod::Iso6336 { webs: [None; 2] },
        StiffnessMethod::Iso6336 { .. } => StiffnessMethod::default(),
    };
    let stiffness = compare_methods(pair, &[study.method, other], &materials)?;
    let mesh = LoadedMesh::new(pair, file.mesh_options(pair))?.map(&study.torques)?;
    Ok((stiffness, mesh))
}

/// The stages that run, and those left out with the reason.
pub fn plan(file: &GearFile) -> Vec<(&'static str, StageDecision)> {
    let runs = |what: String| StageDecision::Runs(what);
    let mut plan = vec![(
        "geometry",
        runs("pair with parallel axes, ISO 21771".into()),
    )];
    if !file.defaults.is_empty() {
        plan.push(("defaults", runs(file.defaults.join("; "))));
    }
    plan.extend([
        (
            "flanks",
            runs("involutes with the fillets that the rack leaves".into()),
        ),
        (
            "limits",
            runs("undercut, interference, pointed tips, clearance, contact ratio".into()),
        ),
        (
            "contact",
            runs("points A to E of the path of contact, sliding, backlash".into()),
        ),
    ]);
    let study = &file.mesh;
    plan.push(match study.torques.len() {
        0 => (
            "mesh",
            StageDecision::LeftOut("no torque is given: [mesh] torque, or --torque".into()),
        ),
        n => (
            "mesh",
            runs(format!(
                "{} × {} positions × {} slices; stiffness by {}, bodies: {}; steel of 206 GPa",
                pluralise(n, "torque"),
                study.positions,
                study.slices,
                study.method.name(),
                study.method.bodies().join(", ")
            )),
        ),
    });
    plan.push((
        "strength rating",
        StageDecision::LeftOut("geardyn rates no load capacity".into()),
    ));
    plan
}
