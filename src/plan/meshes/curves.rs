//! Curves of a loaded mesh for a branch: tables over the mesh cycle and, for tooth pairs, over as many cycles as there are pairs.
//!
//! The force of a branch is `k(ψ) (δ + e₀(ψ))` with the secant stiffness k and the unloaded transmission error e₀, or has the mean
//! tangent stiffness k̄ and `e(ψ, T) + W/k̄` in place of e₀: both deflect by −e(ψ, T) under the load W. The coast flanks are the mirror
//! image of the drive flanks, rotated by the angle of a pinion tooth at the pitch circle.

use std::f64::consts::TAU;

use crate::base::error::{Diagnostic, Error};
use crate::gear::load::mesh::LoadedMesh;
use crate::gear::load::mesh_result::{LoadedCycle, PairCurve};
use crate::scene::gear_mesh::GearMesh;
use crate::scene::laws::Waveform;
use crate::scene::model::{MeshFlanks, MeshSprings, PairSpring, StiffnessVariation, ToothPairs};

/// Direction, phase and projection of a mesh on a branch of a machine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeshPlacement {
    /// True if the mesh cycle advances as the pinion of the file turns with its drive flanks ahead.
    pub is_forward: bool,
    /// Position of the drive flanks in their cycle at the beginning of the cycle of the branch, pitches.
    pub lead: f64,
    /// Displacement along the branch for a unit displacement along the line of action in the transverse section.
    pub projection: f64,
}

/// Stiffness and transmission error of a mesh under one torque, along a branch.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshCurves {
    /// Mean tangent stiffness along the branch, N/m.
    pub stiffness: f64,
    /// Secant stiffness over the mesh cycle, relative to `stiffness`.
    pub wave: StiffnessVariation,
    /// Transmission error, and tooth pairs of a mesh with backlash.
    pub flanks: MeshFlanks,
    /// Peak-to-peak transmission error along the branch, m.
    pub peak_to_peak: f64,
    /// Errors of linear interpolation between the positions.
    pub interpolation: InterpolationError,
    /// Warnings on the ranges of the stiffness.
    pub warnings: Vec<Diagnostic>,
}

/// Bounds of the error of linear interpolation, estimated from every second position: valid for curves that are smooth or have one
/// corner between two positions.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct InterpolationError {
    /// Positions per pitch.
    pub positions: usize,
    /// Bound for the transmission error under load, m.
    pub te: f64,
    /// Bound for the secant stiffness, relative to its mean.
    pub stiffness: f64,
}

impl InterpolationError {
    /// Error bounds of tables over one mesh cycle.
    pub(super) fn of(te: &[f64], stiffness: &[f64]) -> InterpolationError {
        InterpolationError {
            positions: te.len(),
            te: max_midpoint_error(te),
            stiffness: max_midpoint_error(stiffness) / mean(stiffness),
        }
    }
}

/// Largest deviation of a value of a periodic table from the mean of its two neighbours.
fn max_midpoint_error(values: &[f64]) -> f64 {
    let n = values.len();
    let error = |i: usize| values[i] - 0.5 * (values[(i + n - 1) % n] + values[(i + 1) % n]);
    (0..n).fold(0.0, |largest: f64, i| largest.max(error(i).abs()))
}

impl MeshCurves {
    /// Curves of the mesh at a pinion torque above zero, N·m, on its drive or its coast flanks.
    ///
    /// # Errors
    /// Errors of `LoadedMesh::map`.
    pub fn new(
        mesh: &GearMesh,
        torque: f64,
        is_coast: bool,
        placement: MeshPlacement,
    ) -> Result<MeshCurves, Error> {
        let pair = &mesh.pair;
        let loaded = LoadedMesh::new(pair, mesh.options.clone())?;
        let result = loaded.map(&[torque])?;
        let cycle = &result.cycles[0];
        let k_mean = mean(&cycle.tangent);
        let load = torque / pair.outlines[0].base_radius;
        let projection = placement.projection;
        let flank = placement.flank(mesh, is_coast);
        let averaged = cycle.te.iter().map(|e| projection * (e + load / k_mean));
        let springs = match mesh.backlash > 0.0 {
            true => {
                let pairs = tooth_pairs(mesh, &loaded, cycle, k_mean, placement)?;
                Some(MeshSprings::ToothPairs(pairs))
            }
            false => None,
        };
        Ok(MeshCurves {
            stiffness: k_mean / (projection * projection),
            wave: StiffnessVariation {
                waveform: flank.table(cycle.secant.iter().map(|k| k / k_mean).collect()),
                phase: flank.phase,
            },
            flanks: MeshFlanks {
                unloaded_te: flank.table(scaled(&result.unloaded_te, projection)),
                averaged_te: flank.table(averaged.collect()),
                phase: flank.phase,
                is_coast,
                springs,
            },
            peak_to_peak: projection * cycle.peak_to_peak(),
            interpolation: InterpolationError::of(&scaled(&cycle.te, projection), &cycle.secant),
            warnings: result.warnings,
        })
    }
}

/// Direction and phase of the cycle of a flank relative to the cycle of its branch.
pub(super) struct FlankCycle {
    pub is_forward: bool,
    /// Phase in the cycle of the branch, rad.
    pub phase: f64,
}

impl MeshPlacement {
    /// Drive flanks are at `c = ±ψ/2π + lead` in their cycle, coast flanks at `κ − c`, κ the tooth thickness in pitches.
    fn flank(&self, mesh: &GearMesh, is_coast: bool) -> FlankCycle {
        let (is_forward, lead) = match is_coast {
            false => (self.is_forward, self.lead),
            true => (!self.is_forward, tooth_thickness(mesh) - self.lead),
        };
        let sign = if is_forward { 1.0 } else { -1.0 };
        FlankCycle {
            is_forward,
            phase: sign * TAU * lead,
        }
    }
}

impl FlankCycle {
    /// Converts a table over one or more cycles of the flank to the cycle of the branch.
    pub fn table(&self, values: Vec<f64>) -> Waveform {
        let n = values.len();
        Waveform::Table(match self.is_forward {
            true => values,
            false => (0..n).map(|i| values[(n - i) % n]).collect(),
        })
    }
}

/// Thickness of a pinion tooth at the working pitch circle, in pitches.
fn tooth_thickness(mesh: &GearMesh) -> f64 {
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
    mean_stiffness: f64,
    placement: MeshPlacement,
) -> Result<ToothPairs, Error> {
    let curve = loaded.pair_curve(cycle.torque)?;
    let carrying = mesh.pair.contact_ratios().total.max(1.0);
    let count = carrying.ceil() as usize + 1;
    let (stiffness, gap) = periodic(&curve, cycle.te.len(), count);
    let spring = |is_coast: bool| {
        let flank = placement.flank(mesh, is_coast);
        PairSpring {
            stiffness: flank.table(scaled(&stiffness, 1.0 / mean_stiffness)),
            gap: flank.table(scaled(&gap, placement.projection)),
            phase: flank.phase,
        }
    };
    Ok(ToothPairs {
        count: count as u32,
        carrying,
        flanks: [spring(false), spring(true)],
    })
}

/// Stiffness and gap of one pair over a period of `pitches` pitches from contact at the pitch point on. Positions an integer number of
/// periods apart take the smaller gap; positions without contact take the largest gap, which no load closes.
fn periodic(curve: &PairCurve, per_pitch: usize, pitches: usize) -> (Vec<f64>, Vec<f64>) {
    let period = pitches * per_pitch;
    let is_finite = |gap: &&f64| gap.is_finite();
    let widest = curve
        .gap
        .iter()
        .filter(is_finite)
        .fold(0.0f64, |m, g| m.max(*g));
    let stiffest = curve.stiffness.iter().fold(0.0f64, |m, k| m.max(*k));
    let (mut stiffness, mut gap) = (vec![stiffest; period], vec![widest; period]);
    // The curve begins an integer number of pitches from the pitch point.
    let pitch = (curve.angles[curve.angles.len() - 1] - curve.angles[0])
        / (curve.angles.len() - 1) as f64
        * per_pitch as f64;
    let start = (curve.angles[0] / pitch).round() as i64 * per_pitch as i64;
    for (i, (k, g)) in curve.stiffness.iter().zip(&curve.gap).enumerate() {
        let index = (start + i as i64).rem_euclid(period as i64) as usize;
        if *g <= gap[index] {
            (stiffness[index], gap[index]) = (*k, *g);
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
