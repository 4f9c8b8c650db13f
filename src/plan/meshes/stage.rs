//! Stage `meshes`: every mesh that names a gear file gets its stiffness and its flanks at its torque.
//!
//! In a loop torques follow from the stiffnesses: forces and meshes are computed in turn until the torques stay.

use std::borrow::Cow;
use std::sync::Arc;

use super::bevel_curves;
use super::curves::{MeshCurves, MeshSeat};
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

/// Decision and diagnostics of the stage.
#[derive(Debug, Clone)]
pub struct MeshStage {
    /// Decision with the meshes that were computed, or the reason why none was.
    pub decision: StageDecision,
    /// Some mesh names a gear file.
    pub is_named: bool,
    /// Warnings of the pairs, and on the ranges of stiffnesses.
    pub diagnostics: Vec<Diagnostic>,
    /// Pairs that a generator cuts, with the errors of its chain.
    pub works: Vec<Arc<WorkResult>>,
    /// Curves of the meshes that carry.
    curves: Vec<(MeshPlace, Arc<MeshCurves>)>,
}

/// Stiffness of a mesh by its face width before any is computed, Pa: that of steel teeth (ISO 6336-1).
const FIRST_STIFFNESS: f64 = 20e9;

/// Torques closer than this, relative, count as equal: ten times the tolerance of secants.
const SAME_TORQUE: f64 = 1e-7;

/// Maximum number of fixed-point iterations between forces and mesh stiffnesses.
const MOST_ROUNDS: usize = 20;

/// A mesh by the number of its pair or stage in the model.
#[derive(Debug, Clone, Copy)]
enum MeshPlace {
    Pair(usize),
    Sun(usize),
    Ring(usize),
}

impl MeshPlace {
    /// First words of the parts of its branches.
    fn part(self) -> &'static str {
        match self {
            MeshPlace::Pair(_) => "",
            MeshPlace::Sun(_) => "sun to",
            MeshPlace::Ring(_) => "ring to",
        }
    }
}

/// A mesh that names a gear file.
struct NamedMesh {
    name: Name,
    mesh: PairMesh,
    place: MeshPlace,
    seat: MeshSeat,
}

impl MeshStage {
    /// The meshes of a model under its torques.
    ///
    /// # Errors
    /// A mesh under no torque whose file states none; a load that the teeth cannot carry; those of the operating point.
    pub fn new(model: &Model) -> Result<MeshStage, Error> {
        let mut named = named_meshes(model)?;
        let cuts = cut_meshes(model, &mut named)?;
        match named.is_empty() {
            false => solve(model, &named, cuts),
            true => Ok(MeshStage {
                decision: StageDecision::LeftOut("no mesh names a gear file".into()),
                is_named: false,
                works: Vec::new(),
                diagnostics: Vec::new(),
                curves: Vec::new(),
            }),
        }
    }

    /// A model of these meshes, with their stiffnesses and flanks.
    pub fn filled<'m>(&self, model: &'m Model) -> Cow<'m, Model> {
        let mut model = Cow::Borrowed(model);
        for (place, curves) in &self.curves {
            fill(contact(model.to_mut(), *place), curves);
        }
        model
    }
}

/// A mesh one flank of which a generator cuts.
struct CutMesh {
    /// Place among the named meshes.
    at: usize,
    /// The mesh as designed.
    ideal: Arc<BevelMesh>,
    work: WorkResult,
}

/// Puts the flanks that generators cut in the place of the ideal ones.
fn cut_meshes(model: &Model, named: &mut [NamedMesh]) -> Result<Vec<CutMesh>, Error> {
    let mut cuts = Vec::new();
    for (number, one) in named.iter_mut().enumerate() {
        let MeshPlace::Pair(at) = one.place else {
            continue;
        };
        let (Some(cut_on), PairMesh::Bevel(mesh)) = (&model.gear_pairs[at].cut_on, &one.mesh)
        else {
            continue;
        };
        if mesh.file.torque.is_none() && model.loads.is_empty() {
            let message = format!(
                "`{}` is cut on {}, and no torque loads it",
                one.name.text, cut_on.source.path
            );
            return Err(Error::new(Code::MissingKey, message)
                .with_span(&cut_on.span)
                .with_hint("add a [[load]], or `torque` in [mesh] of the gear file"));
        }
        let work = WorkResult::on(cut_on, &mesh.file.source.text)?;
        let mut flanks = mesh.pair.flanks.clone();
        flanks[work.pair.member] = work.pair.flank.clone();
        let cut = BevelMesh::of_flanks(mesh.file.clone(), mesh.bevel.clone(), flanks)?;
        // The branch of the machine has the directions of the pair as designed.
        let cut = PairMesh::Bevel(Arc::new(BevelMesh {
            levers: mesh.levers,
            ..cut
        }));
        cuts.push(CutMesh {
            at: number,
            ideal: mesh.clone(),
            work,
        });
        one.mesh = cut;
    }
    Ok(cuts)
}

/// Each mesh at its torque, in turn with the forces until the torques stay.
fn solve(model: &Model, named: &[NamedMesh], cuts: Vec<CutMesh>) -> Result<MeshStage, Error> {
    let mut filled = model.clone();
    if !model.loads.is_empty() {
        for one in named {
            let stiffness = FIRST_STIFFNESS * one.mesh.face_width();
            contact(&mut filled, one.place).stiffness = Some(stiffness);
        }
    }
    // Each mesh of one file, seat and torque is computed once.
    let mut computed: Vec<ComputedMesh> = Vec::new();
    let mut carried: Vec<Option<usize>> = vec![None; named.len()];
    for _ in 0..MOST_ROUNDS {
        let mut settled = true;
        for (at, torque) in torques(&filled, named)?.into_iter().enumerate() {
            let Some(torque) = torque else { continue };
            let known = computed.iter().position(|c| c.is_of(&named[at], torque));
            let number = match known {
                Some(number) => number,
                None => {
                    computed.push(ComputedMesh::new(&named[at], torque)?);
                    computed.len() - 1
                }
            };
            if carried[at] != Some(number) {
                settled = false;
                carried[at] = Some(number);
                fill(
                    contact(&mut filled, named[at].place),
                    &computed[number].curves,
                );
            }
        }
        if settled {
            let works = cuts.into_iter().map(|cut| {
                let carried = carried[cut.at].map(|number| &computed[number]);
                let load = carried.map(|c| (c.torque, c.curves.peak_to_peak));
                cut.work.under_load(&cut.ideal, load).map(Arc::new)
            });
            return Ok(MeshStage {
                works: works.collect::<Result<_, Error>>()?,
                ..describe(named, &carried, &computed)
            });
        }
    }
    let message = "the torques of the meshes do not settle with their stiffnesses";
    Err(Error::new(Code::NoConvergence, message)
        .with_span(&named[0].name.span)
        .with_hint("state the stiffness k of one mesh of the loop in place of its gear file"))
}

/// The curves of a mesh at a torque.
struct ComputedMesh {
    mesh: PairMesh,
    seat: MeshSeat,
    /// N·m at the pinion, below zero on the coast flanks.
    torque: f64,
    curves: Arc<MeshCurves>,
}

impl ComputedMesh {
    fn new(one: &NamedMesh, torque: f64) -> Result<ComputedMesh, Error> {
        let (mesh, seat) = (one.mesh.clone(), one.seat);
        let (size, is_coast) = (torque.abs(), torque < 0.0);
        let curves = match &mesh {
            PairMesh::Cylindrical(mesh) => MeshCurves::new(mesh, size, is_coast, seat),
            PairMesh::Bevel(mesh) => bevel_curves::curves(mesh, size, is_coast),
        };
        let curves = curves.map_err(|e| {
            let file = &mesh.file().source.path;
            let message = format!("`{}` by {file}: {}", one.name.text, e.message);
            Error { message, ..e }.with_span(&mesh.file().span)
        })?;
        Ok(ComputedMesh {
            mesh,
            seat,
            torque,
            curves: Arc::new(curves),
        })
    }

    fn is_of(&self, one: &NamedMesh, torque: f64) -> bool {
        self.mesh.file().source == one.mesh.file().source
            && self.seat == one.seat
            && (self.torque - torque).abs() <= SAME_TORQUE * torque.abs()
    }
}

/// Pairs and stages that name gear files, in the order of the model.
fn named_meshes(model: &Model) -> Result<Vec<NamedMesh>, Error> {
    let mut all = Vec::new();
    for (at, pair) in model.gear_pairs.iter().enumerate() {
        if let Some(mesh) = &pair.gear {
            all.push(NamedMesh {
                name: pair.name.clone(),
                mesh: mesh.clone(),
                place: MeshPlace::Pair(at),
                seat: MeshSeat {
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
    for (at, stage) in model.planetaries.iter().enumerate() {
        let Some([sun, ring]) = &stage.gears else {
            continue;
        };
        // The ring's cycle goes forward with the ring, and its planet then turns its coast flanks ahead; see docs/signs.md.
        let is_fixed = [&stage.sun, &stage.ring].map(|end| matches!(end, BranchEnd::Ground));
        let lead = planet_phase(&sun.pair, &ring.pair).map_err(|e| e.with_span(&ring.file.span))?;
        let seat = |is_forward: bool, lead: f64| MeshSeat {
            is_forward,
            lead,
            projection: 1.0,
        };
        for (mesh, place, seat) in [
            (sun, MeshPlace::Sun(at), seat(!is_fixed[0], 0.0)),
            (ring, MeshPlace::Ring(at), seat(is_fixed[1], lead)),
        ] {
            all.push(NamedMesh {
                name: stage.name.clone(),
                mesh: PairMesh::Cylindrical(mesh.clone()),
                place,
                seat,
            });
        }
    }
    Ok(all)
}

/// Torques at the pinions, N·m, below zero where coast flanks carry: of the operating point, by default of `[mesh]`; `None` where
/// neither is known.
fn torques(model: &Model, named: &[NamedMesh]) -> Result<Vec<Option<f64>>, Error> {
    if model.loads.is_empty() {
        return Ok(named.iter().map(|one| one.mesh.stated_torque()).collect());
    }
    let (machine, forces) = static_forces(model)?;
    let largest = forces.forces.iter().fold(0.0f64, |m, f| m.max(f.1.abs()));
    let torque = |one: &NamedMesh| {
        let force = mean_force(&machine, &forces, &one.name.text, one.place.part());
        let torque = force * one.seat.projection * one.mesh.lever();
        match force.abs() > IDLE * largest {
            true => Ok(Some(torque)),
            false => (one.mesh.stated_torque().map(Some)).ok_or_else(|| unloaded_error(one)),
        }
    };
    named.iter().map(torque).collect()
}

/// Share of the largest force below which a mesh carries nothing: rounding of the equilibrium.
const IDLE: f64 = 1e-9;

fn unloaded_error(one: &NamedMesh) -> Error {
    let message = format!(
        "the mean loads put no torque on `{}`, and {} states none",
        one.name.text,
        one.mesh.file().source.path
    );
    Error::new(Code::MissingKey, message)
        .with_span(&one.mesh.file().span)
        .with_hint("give `torque` in [mesh] of the gear file, or a [[load]] that the mesh carries")
}

/// The contact of a mesh in a model.
fn contact(model: &mut Model, place: MeshPlace) -> &mut ContactParameters {
    match place {
        MeshPlace::Pair(at) => &mut model.gear_pairs[at].contact,
        MeshPlace::Sun(at) => &mut model.planetaries[at].sun_contact,
        MeshPlace::Ring(at) => &mut model.planetaries[at].ring_contact,
    }
}

fn fill(contact: &mut ContactParameters, curves: &MeshCurves) {
    contact.stiffness = Some(curves.stiffness);
    contact.wave = Some(curves.wave.clone());
    contact.flanks = Some(curves.flanks.clone());
}

/// Description of the stage, mesh by mesh.
fn describe(
    named: &[NamedMesh],
    carried: &[Option<usize>],
    computed: &[ComputedMesh],
) -> MeshStage {
    let label = |one: &NamedMesh| match one.place {
        MeshPlace::Pair(_) => one.name.text.clone(),
        MeshPlace::Sun(_) => format!("{} at the sun", one.name.text),
        MeshPlace::Ring(_) => format!("{} at the ring", one.name.text),
    };
    let row = |(one, number): (&NamedMesh, &Option<usize>)| {
        let (label, file) = (label(one), &one.mesh.file().source.path);
        match *number {
            None => format!("{label} by {file}: {}", unloaded_row(&one.mesh)),
            Some(number) => {
                let ComputedMesh { torque, curves, .. } = &computed[number];
                format!(
                    "{label} by {file} {}",
                    loaded_row(&one.mesh, *torque, curves)
                )
            }
        }
    };
    let rows: Vec<String> = named.iter().zip(carried).map(row).collect();
    let text = rows.join("; ");
    let of_pair = |one: &NamedMesh| {
        let PairMesh::Cylindrical(mesh) = &one.mesh else {
            return Vec::new();
        };
        let (pair, file) = (&mesh.pair, &mesh.file.source.path);
        let warning = |w: &Warning| {
            let found = gear_limits::diagnostic(w);
            Diagnostic {
                message: format!("{file}: {}", found.message),
                ..found
            }
        };
        pair.warnings().iter().map(warning).collect::<Vec<_>>()
    };
    let of_mesh = computed.iter().flat_map(|c| c.curves.warnings.clone());
    let mut diagnostics: Vec<Diagnostic> = Vec::new();
    for warning in named.iter().flat_map(of_pair).chain(of_mesh) {
        if !diagnostics.contains(&warning) {
            diagnostics.push(warning);
        }
    }
    let is_bevel = |one: &NamedMesh| matches!(one.mesh, PairMesh::Bevel(_));
    let curves = |(one, number): (&NamedMesh, &Option<usize>)| {
        Some((one.place, computed[(*number)?].curves.clone()))
    };
    MeshStage {
        curves: named.iter().zip(carried).filter_map(curves).collect(),
        decision: match computed.is_empty() && !named.iter().any(is_bevel) {
            true => StageDecision::LeftOut(text),
            false => StageDecision::Runs(text),
        },
        is_named: true,
        works: Vec::new(),
        diagnostics,
    }
}
