//! Stage `meshes`: computes stiffness and flanks, at the operating torque, of every mesh that names a gear file.
//!
//! In a closed loop the torques depend on the stiffnesses: a fixed-point iteration between forces and meshes determines them.

use std::borrow::Cow;
use std::sync::Arc;

use super::bevel_curves;
use super::curves::{MeshCurves, MeshPlacement};
use super::rows::{loaded_row, unloaded_row};
use super::torques::{mean_force, static_forces};
use super::work::WorkResult;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::gear::cylindrical::warnings::Warning;
use crate::gear::load::planet_phase::planet_phase;
use crate::plan::decision::StageDecision;
use crate::plan::gear_limits;
use crate::scene::bevel_mesh::BevelMesh;
use crate::scene::model::{BranchEnd, ContactParameters, Model, Name};
use crate::scene::pair_mesh::PairMesh;

/// Computed meshes with the decision and the diagnostics of the stage.
#[derive(Debug, Clone)]
pub struct MeshStage {
    /// Decision with the computed meshes, or the reason why none was computed.
    pub decision: StageDecision,
    /// True if a mesh names a gear file.
    pub has_gear_files: bool,
    /// Warnings on the gear pairs and on the validity of the stiffnesses.
    pub diagnostics: Vec<Diagnostic>,
    /// Pairs with a flank cut on a generator, with the errors of its gear train.
    pub workpieces: Vec<Arc<WorkResult>>,
    /// Curves of the loaded meshes.
    curves: Vec<(MeshIndex, Arc<MeshCurves>)>,
}

/// Initial mesh stiffness per face width, Pa: that of steel teeth (ISO 6336-1).
const INITIAL_STIFFNESS: f64 = 20e9;

/// Relative difference below which torques count as equal: ten times the tolerance of the secant method.
const SAME_TORQUE: f64 = 1e-7;

/// Maximum number of fixed-point iterations between forces and mesh stiffnesses.
const MAX_ITERATIONS: usize = 20;

/// Mesh by the index of its gear pair or planetary stage in the model.
#[derive(Debug, Clone, Copy)]
enum MeshIndex {
    Pair(usize),
    Sun(usize),
    Ring(usize),
}

impl MeshIndex {
    /// Prefix of the part names of its branches.
    fn part(self) -> &'static str {
        match self {
            MeshIndex::Pair(_) => "",
            MeshIndex::Sun(_) => "sun to",
            MeshIndex::Ring(_) => "ring to",
        }
    }
}

/// A mesh that names a gear file.
struct NamedMesh {
    name: Name,
    mesh: PairMesh,
    index: MeshIndex,
    seat: MeshPlacement,
}

impl MeshStage {
    /// Computes the meshes of a model at its torques.
    ///
    /// # Errors
    /// An unloaded mesh whose file states no torque; a load that the teeth cannot carry; those of the operating point.
    pub fn new(model: &Model) -> Result<MeshStage, Error> {
        let mut named = named_meshes(model)?;
        let cuts = cut_meshes(model, &mut named)?;
        match named.is_empty() {
            false => solve(model, &named, cuts),
            true => Ok(MeshStage {
                decision: StageDecision::LeftOut("no mesh names a gear file".into()),
                has_gear_files: false,
                workpieces: Vec::new(),
                diagnostics: Vec::new(),
                curves: Vec::new(),
            }),
        }
    }

    /// Model with the stiffnesses and flanks of the computed meshes.
    pub fn with_curves<'m>(&self, model: &'m Model) -> Cow<'m, Model> {
        let mut model = Cow::Borrowed(model);
        for (index, curves) in &self.curves {
            set_curves(contact(model.to_mut(), *index), curves);
        }
        model
    }
}

/// Mesh with a flank cut on a generator.
struct CutMesh {
    /// Index of the named mesh.
    index: usize,
    /// Mesh with the design flanks.
    ideal: Arc<BevelMesh>,
    work: WorkResult,
}

/// Replaces the design flanks of meshes by those cut on a generator.
fn cut_meshes(model: &Model, named: &mut [NamedMesh]) -> Result<Vec<CutMesh>, Error> {
    let mut cuts = Vec::new();
    for (index, item) in named.iter_mut().enumerate() {
        let MeshIndex::Pair(pair) = item.index else {
            continue;
        };
        let (Some(cut_on), PairMesh::Bevel(mesh)) = (&model.gear_pairs[pair].cut_on, &item.mesh)
        else {
            continue;
        };
        if mesh.file.torque.is_none() && model.loads.is_empty() {
            let message = format!(
                "`{}` is cut on {} and has no torque",
                item.name.text, cut_on.source.path
            );
            return Err(Error::new(Code::MissingKey, message)
                .with_span(&cut_on.span)
                .with_hint("add a [[load]], or `torque` in [mesh] of the gear file"));
        }
        let work = WorkResult::on(cut_on, &mesh.file.source.text)?;
        let mut flanks = mesh.pair.flanks.clone();
        flanks[work.pair.member] = work.pair.flank.clone();
        let cut = BevelMesh::of_flanks(mesh.file.clone(), mesh.bevel.clone(), flanks)?;
        // The branch of the machine keeps the directions of the design pair.
        let cut = PairMesh::Bevel(Arc::new(BevelMesh {
            levers: mesh.levers,
            ..cut
        }));
        cuts.push(CutMesh {
            index,
            ideal: mesh.clone(),
            work,
        });
        item.mesh = cut;
    }
    Ok(cuts)
}

/// Iterates between forces and meshes until all torques converge.
fn solve(model: &Model, named: &[NamedMesh], cuts: Vec<CutMesh>) -> Result<MeshStage, Error> {
    let mut loaded = model.clone();
    if !model.loads.is_empty() {
        for item in named {
            let stiffness = INITIAL_STIFFNESS * item.mesh.face_width();
            contact(&mut loaded, item.index).stiffness = Some(stiffness);
        }
    }
    // Meshes of the same file, seat and torque are computed once.
    let mut computed: Vec<ComputedMesh> = Vec::new();
    let mut current: Vec<Option<usize>> = vec![None; named.len()];
    for _ in 0..MAX_ITERATIONS {
        let mut is_converged = true;
        for (mesh, torque) in torques(&loaded, named)?.into_iter().enumerate() {
            let Some(torque) = torque else { continue };
            let cached = computed.iter().position(|c| c.is_for(&named[mesh], torque));
            let number = match cached {
                Some(number) => number,
                None => {
                    computed.push(ComputedMesh::new(&named[mesh], torque)?);
                    computed.len() - 1
                }
            };
            if current[mesh] != Some(number) {
                is_converged = false;
                current[mesh] = Some(number);
                set_curves(
                    contact(&mut loaded, named[mesh].index),
                    &computed[number].curves,
                );
            }
        }
        if is_converged {
            let works = cuts.into_iter().map(|cut| {
                let mesh = current[cut.index].map(|number| &computed[number]);
                let load = mesh.map(|c| (c.torque, c.curves.peak_to_peak));
                cut.work.under_load(&cut.ideal, load).map(Arc::new)
            });
            return Ok(MeshStage {
                workpieces: works.collect::<Result<_, Error>>()?,
                ..describe(named, &current, &computed)
            });
        }
    }
    let message = "the iteration of mesh torques and stiffnesses does not converge";
    Err(Error::new(Code::NoConvergence, message)
        .with_span(&named[0].name.span)
        .with_hint("give one mesh of the loop a stiffness k in place of its gear file"))
}

/// Curves of a mesh at a torque.
struct ComputedMesh {
    mesh: PairMesh,
    seat: MeshPlacement,
    /// Torque at the pinion, N·m, negative on the coast flanks.
    torque: f64,
    curves: Arc<MeshCurves>,
}

impl ComputedMesh {
    fn new(named: &NamedMesh, torque: f64) -> Result<ComputedMesh, Error> {
        let (mesh, seat) = (named.mesh.clone(), named.seat);
        let (magnitude, is_coast) = (torque.abs(), torque < 0.0);
        let curves = match &mesh {
            PairMesh::Cylindrical(mesh) => MeshCurves::new(mesh, magnitude, is_coast, seat),
            PairMesh::Bevel(mesh) => bevel_curves::curves(mesh, magnitude, is_coast),
        };
        let curves = curves.map_err(|e| {
            let file = &mesh.file().source.path;
            let message = format!("`{}` by {file}: {}", named.name.text, e.message);
            Error { message, ..e }.with_span(&mesh.file().span)
        })?;
        Ok(ComputedMesh {
            mesh,
            seat,
            torque,
            curves: Arc::new(curves),
        })
    }

    fn is_for(&self, named: &NamedMesh, torque: f64) -> bool {
        self.mesh.file().source == named.mesh.file().source
            && self.seat == named.seat
            && (self.torque - torque).abs() <= SAME_TORQUE * torque.abs()
    }
}

/// Pairs and stages that name gear files, in the order of the model.
fn named_meshes(model: &Model) -> Result<Vec<NamedMesh>, Error> {
    let mut meshes = Vec::new();
    for (index, pair) in model.gear_pairs.iter().enumerate() {
        if let Some(mesh) = &pair.gear {
            meshes.push(NamedMesh {
                name: pair.name.clone(),
                mesh: mesh.clone(),
                index: MeshIndex::Pair(index),
                seat: MeshPlacement {
                    is_forward: true,
                    lead: 0.0,
                    projection: match mesh {
                        PairMesh::Cylindrical(mesh) => mesh.base_helix_angle().cos(),
                        PairMesh::Bevel(_) => 1.0,
                    },
                },
            });
        }
    }
    for (index, stage) in model.planetaries.iter().enumerate() {
        let Some([sun, ring]) = &stage.gears else {
            continue;
        };
        // The mesh cycle of the ring advances with the ring; the planet then leads with its coast flanks; see docs/signs.md.
        let is_fixed = [&stage.sun, &stage.ring].map(|end| matches!(end, BranchEnd::Ground));
        let lead = planet_phase(&sun.pair, &ring.pair).map_err(|e| e.with_span(&ring.file.span))?;
        let seat = |is_forward: bool, lead: f64| MeshPlacement {
            is_forward,
            lead,
            projection: 1.0,
        };
        for (mesh, index, seat) in [
            (sun, MeshIndex::Sun(index), seat(!is_fixed[0], 0.0)),
            (ring, MeshIndex::Ring(index), seat(is_fixed[1], lead)),
        ] {
            meshes.push(NamedMesh {
                name: stage.name.clone(),
                mesh: PairMesh::Cylindrical(mesh.clone()),
                index,
                seat,
            });
        }
    }
    Ok(meshes)
}

/// Torques at the pinions, N·m, negative on coast flanks: those of the operating point, by default those of `[mesh]`; `None` if
/// neither is given.
fn torques(model: &Model, named: &[NamedMesh]) -> Result<Vec<Option<f64>>, Error> {
    if model.loads.is_empty() {
        return Ok(named.iter().map(|item| item.mesh.stated_torque()).collect());
    }
    let (machine, forces) = static_forces(model)?;
    let largest = forces.forces.iter().fold(0.0f64, |m, f| m.max(f.1.abs()));
    let torque = |item: &NamedMesh| {
        let force = mean_force(&machine, &forces, &item.name.text, item.index.part());
        let torque = force * item.seat.projection * item.mesh.lever();
        match force.abs() > UNLOADED * largest {
            true => Ok(Some(torque)),
            false => (item.mesh.stated_torque().map(Some)).ok_or_else(|| unloaded_error(item)),
        }
    };
    named.iter().map(torque).collect()
}

/// Share of the largest force below which a mesh is unloaded: rounding of the equilibrium.
const UNLOADED: f64 = 1e-9;

fn unloaded_error(item: &NamedMesh) -> Error {
    let message = format!(
        "the mean torque on `{}` is zero, and {} states none",
        item.name.text,
        item.mesh.file().source.path
    );
    Error::new(Code::MissingKey, message)
        .with_span(&item.mesh.file().span)
        .with_hint("give `torque` in [mesh] of the gear file, or a [[load]] that loads the mesh")
}

/// Contact parameters of a mesh in a model.
fn contact(model: &mut Model, index: MeshIndex) -> &mut ContactParameters {
    match index {
        MeshIndex::Pair(i) => &mut model.gear_pairs[i].contact,
        MeshIndex::Sun(i) => &mut model.planetaries[i].sun_contact,
        MeshIndex::Ring(i) => &mut model.planetaries[i].ring_contact,
    }
}

fn set_curves(contact: &mut ContactParameters, curves: &MeshCurves) {
    contact.stiffness = Some(curves.stiffness);
    contact.wave = Some(curves.wave.clone());
    contact.flanks = Some(curves.flanks.clone());
}

/// Result of the stage, with a description of each mesh.
fn describe(
    named: &[NamedMesh],
    current: &[Option<usize>],
    computed: &[ComputedMesh],
) -> MeshStage {
    let label = |item: &NamedMesh| match item.index {
        MeshIndex::Pair(_) => item.name.text.clone(),
        MeshIndex::Sun(_) => format!("{} at the sun", item.name.text),
        MeshIndex::Ring(_) => format!("{} at the ring", item.name.text),
    };
    let row = |(item, number): (&NamedMesh, &Option<usize>)| {
        let (label, file) = (label(item), &item.mesh.file().source.path);
        match *number {
            None => format!("{label} by {file}: {}", unloaded_row(&item.mesh)),
            Some(number) => {
                let ComputedMesh { torque, curves, .. } = &computed[number];
                format!(
                    "{label} by {file} {}",
                    loaded_row(&item.mesh, *torque, curves)
                )
            }
        }
    };
    let rows: Vec<String> = named.iter().zip(current).map(row).collect();
    let text = rows.join("; ");
    let pair_warnings = |item: &NamedMesh| {
        let PairMesh::Cylindrical(mesh) = &item.mesh else {
            return Vec::new();
        };
        let (pair, file) = (&mesh.pair, &mesh.file.source.path);
        let warning = |w: &Warning| {
            let diagnostic = gear_limits::diagnostic(w);
            Diagnostic {
                message: format!("{file}: {}", diagnostic.message),
                ..diagnostic
            }
        };
        pair.warnings().iter().map(warning).collect::<Vec<_>>()
    };
    let mesh_warnings = computed.iter().flat_map(|c| c.curves.warnings.clone());
    let mut diagnostics: Vec<Diagnostic> = Vec::new();
    for warning in named.iter().flat_map(pair_warnings).chain(mesh_warnings) {
        if !diagnostics.contains(&warning) {
            diagnostics.push(warning);
        }
    }
    let is_bevel = |item: &NamedMesh| matches!(item.mesh, PairMesh::Bevel(_));
    let curves = |(item, number): (&NamedMesh, &Option<usize>)| {
        Some((item.index, computed[(*number)?].curves.clone()))
    };
    MeshStage {
        curves: named.iter().zip(current).filter_map(curves).collect(),
        decision: match computed.is_empty() && !named.iter().any(is_bevel) {
            true => StageDecision::LeftOut(text),
            false => StageDecision::Runs(text),
        },
        has_gear_files: true,
        workpieces: Vec::new(),
        diagnostics,
    }
}
