//! Curves of a loaded mesh as a branch takes them: tables over the mesh cycle and, for tooth pairs, over as many cycles as there are pairs.
//!
//! A branch pulls with `k(ψ) (δ + e₀(ψ))`, k the secant and e₀ the transmission error without load, or with the mean tangent
//! stiffness k̄ and `e(ψ, T) + W/k̄` in place of e₀: both deflect by −e(ψ, T) under W. The coast flanks are the mirror image of the drive
//! flanks: turned by the angle of a tooth of the pinion at the pitch circle, they touch there.

use std::f64::consts::TAU;

use crate::base::error::{Diagnostic, Error};
use crate::gear::load::mesh::LoadedMesh;
use crate::gear::load::mesh_result::{LoadedCycle, PairCurve};
use crate::scene::gear_mesh::GearMesh;
use crate::scene::laws::Waveform;
use crate::scene::model::{MeshFlanks, MeshSprings, PairSpring, StiffnessVariation, ToothPairs};

/// Place of a mesh on a branch of a machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshSeat {
    /// The mesh cycle goes forward as the pinion of the file turns with its drive flanks ahead.
    pub is_forward: bool,
    /// Place of the drive flanks in their cycle where that of the branch begins, in pitches.
    pub lead: f64,
    /// Displacement along the branch for a unit displacement along the line of action in the transverse section.
    pub projection: f64,
}

/// A mesh under one torque, as a branch takes it.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshCurves {
    /// Mean tangent stiffness along the branch, N/m.
    pub stiffness: f64,
    /// Secant stiffness over the mesh cycle.
    pub wave: StiffnessVariation,
    /// Transmission error, and tooth pairs where there is play.
    pub flanks: MeshFlanks,
    /// Peak-to-peak transmission error along the branch, m.
    pub peak_to_peak: f64,
    /// Errors of straight lines between the positions.
    pub interpolation: InterpolationError,
    /// Warnings on the ranges of the stiffness.
    pub warnings: Vec<Diagnostic>,
}

/// Bounds of what straight lines between the positions miss, by those between every second position: for curves that are smooth or have
/// one corner between two positions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterpolationError {
    /// Positions in a pitch.
    pub positions: usize,
    /// Bound for the transmission error under load, m.
    pub te: f64,
    /// Bound for the secant stiffness, as a share of its mean.
    pub stiffness: f64,
}

impl InterpolationError {
    /// Bounds of tables over one mesh cycle.
    pub(super) fn of(te: &[f64], stiffness: &[f64]) -> InterpolationError {
        InterpolationError {
            positions: te.len(),
            te: off_the_chord(te),
            stiffness: off_the_chord(stiffness) / mean(stiffness),
        }
    }
}

/// Largest distance of a value from the middle of its neighbours, of a periodic table.
fn off_the_chord(values: &[f64]) -> f64 {
    let n = values.len();
    let off = |i: usize| values[i] - 0.5 * (values[(i + n - 1) % n] + values[(i + 1) % n]);
    (0..n).fold(0.0, |most: f64, i| most.max(off(i).abs()))
}

impl MeshCurves {
    /// The mesh at a torque of the pinion, N·m above zero, on its drive or its coast flanks.
    ///
    /// # Errors
    /// As `LoadedMesh::map`.
    pub fn new(
        mesh: &GearMesh,
        torque: f64,
        is_coast: bool,
        seat: MeshSeat,
    ) -> Result<MeshCurves, Error> {
        let pair = &mesh.pair;
        let loaded = LoadedMesh::new(pair, mesh.options.clone())?;
        let result = loaded.map(&[torque])?;
        let cycle = &result.cycles[0];
        let mean = mean(&cycle.tangent);
        let load = torque / pair.outlines[0].base_radius;
        let along = seat.projection;
        let flank = seat.flank(mesh, is_coast);
        let averaged = cycle.te.iter().map(|e| along * (e + load / mean));
        let springs = match mesh.backlash > 0.0 {
            true => {
                let pairs = tooth_pairs(mesh, &loaded, cycle, mean, seat)?;
                Some(MeshSprings::ToothPairs(pairs))
            }
            false => None,
        };
        Ok(MeshCurves {
            stiffness: mean / (along * along),
            wave: StiffnessVariation {
                waveform: flank.table(cycle.secant.iter().map(|k| k / mean).collect()),
                phase: flank.phase,
            },
            flanks: MeshFlanks {
                unloaded_te: flank.table(scaled(&result.unloaded_te, along)),
                averaged_te: flank.table(averaged.collect()),
                phase: flank.phase,
                is_coast,
                springs,
            },
            peak_to_peak: along * cycle.peak_to_peak(),
            interpolation: InterpolationError::of(&scaled(&cycle.te, along), &cycle.secant),
            warnings: result.warnings,
        })
    }
}

/// Sense and phase of a flank's cycle in the cycle of its branch.
pub(super) struct FlankCycle {
    pub is_forward: bool,
    /// rad of the cycle of the branch.
    pub phase: f64,
}

impl MeshSeat {
    /// Drive flanks are at `c = ±ψ/2π + lead` in their cycle, coast flanks at `κ − c`, κ the tooth thickness in pitches.
    fn flank(&self, mesh: &GearMesh, is_coast: bool) -> FlankCycle {
        let (is_forward, lead) = match is_coast {
            false => (self.is_forward, self.lead),
            true => (!self.is_forward, tooth_in_pitches(mesh) - self.lead),
        };
        let sense = if is_forward { 1.0 } else { -1.0 };
        FlankCycle {
            is_forward,
            phase: sense * TAU * lead,
        }
    }
}

impl FlankCycle {
    /// A table over the flank's own cycle, or several, as one over that of the branch.
    pub fn table(&self, values: Vec<f64>) -> Waveform {
        let n = values.len();
        Waveform::Table(match self.is_forward {
            true => values,
            false => (0..n).map(|i| values[(n - i) % n]).collect(),
        })
    }
}

/// Thickness of a pinion tooth at the working pitch circle, in pitches.
fn tooth_in_pitches(mesh: &GearMesh) -> f64 {
    let outline = &mesh.pair.outlines[0];
    let radius = 0.5 * mesh.pair.working_diameters()[0];
    let half = outline.half_angle(radius).unwrap_or(0.0);
    f64::from(outline.teeth) * 2.0 * half / TAU
}

/// Springs of the tooth pairs on both flanks.
fn tooth_pairs(
    mesh: &GearMesh,
    loaded: &LoadedMesh,
    cycle: &LoadedCycle,
    mean: f64,
    seat: MeshSeat,
) -> Result<ToothPairs, Error> {
    let curve = loaded.pair_curve(cycle.torque)?;
    let carrying = mesh.pair.contact_ratios().total.max(1.0);
    let count = carrying.ceil() as usize + 1;
    let (stiffness, gap) = folded(&curve, cycle.te.len(), count);
    let spring = |is_coast: bool| {
        let flank = seat.flank(mesh, is_coast);
        PairSpring {
            stiffness: flank.table(scaled(&stiffness, 1.0 / mean)),
            gap: flank.table(scaled(&gap, seat.projection)),
            phase: flank.phase,
        }
    };
    Ok(ToothPairs {
        count: count as u32,
        carrying,
        flanks: [spring(false), spring(true)],
    })
}

/// Stiffness and gap of one pair over `pitches` pitches from contact at the pitch point on. Places of the curve that are whole periods
/// apart have the smaller gap; places out of reach have the widest, which no load closes.
fn folded(curve: &PairCurve, per_pitch: usize, pitches: usize) -> (Vec<f64>, Vec<f64>) {
    let period = pitches * per_pitch;
    let finite = |gap: &&f64| gap.is_finite();
    let widest = curve
        .gap
        .iter()
        .filter(finite)
        .fold(0.0f64, |m, g| m.max(*g));
    let stiffest = curve.stiffness.iter().fold(0.0f64, |m, k| m.max(*k));
    let (mut stiffness, mut gap) = (vec![stiffest; period], vec![widest; period]);
    // The curve begins a whole number of pitches from the pitch point.
    let pitch = (curve.angles[curve.angles.len() - 1] - curve.angles[0])
        / (curve.angles.len() - 1) as f64
        * per_pitch as f64;
    let start = (curve.angles[0] / pitch).round() as i64 * per_pitch as i64;
    for (i, (k, g)) in curve.stiffness.iter().zip(&curve.gap).enumerate() {
        let at = (start + i as i64).rem_euclid(period as i64) as usize;
        if *g <= gap[at] {
            (stiffness[at], gap[at]) = (*k, *g);
        }
    }
    (stiffness, gap)
}

pub(super) fn scaled(values: &[f64], factor: f64) -> Vec<f64> {
    values.iter().map(|v| factor * v).collect()
}

pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
