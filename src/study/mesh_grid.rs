//! Error of e(φ, T) and k(φ, T) of a mesh against run time, over grids of positions, and slices or stations.
//!
//! Curves over a pitch are compared with those of a finer grid by linear interpolation, as a table of them is used; the distance of the
//! grid of half as many positions and slices is the error of the reference.

use super::comparison::{ComparedMethod, ComparisonResult, ModelSize};
use super::monitor::{Monitor, interrupted_error};
use super::timing::min_time;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_number;
use crate::gear::bevel::tooth::BevelTooth;
use crate::gear::load::flank_mesh::{FlankMesh, FlankMeshOptions};
use crate::gear::load::flank_position::ToothBending;
use crate::gear::load::mesh::{LoadedMesh, MeshOptions};
use crate::numeric::parallel;
use crate::numeric::statistics::peak_to_peak;
use crate::plan::gear::bevel_contact::BevelContact;
use crate::plan::gear::bevel_mesh;
use crate::scene::bevel_file::BevelFile;
use crate::scene::gear_file::GearFile;

/// Grids that are compared, and the reference.
struct Grids {
    /// In one pitch.
    positions: &'static [usize],
    /// Slices or stations along the face.
    along: &'static [usize],
    /// Positions, and slices or stations.
    reference: [usize; 2],
    /// The size of a method with such a grid.
    size: fn([usize; 2]) -> ModelSize,
    /// Name of the parts along the face.
    name: &'static str,
}

/// Teeth that differ along the face: slices enter contact one by one, so that errors fall with their number.
const SLICED: Grids = Grids {
    positions: &[15, 30, 60],
    along: &[5, 11, 21, 41, 81],
    reference: [240, 401],
    size: |[positions, slices]| ModelSize::MeshGrid { positions, slices },
    name: "slices",
};
/// Teeth alike along the face: the number of slices makes no difference.
const UNIFORM: Grids = Grids {
    positions: &[15, 30, 60, 120, 240],
    along: &[5],
    reference: [1920, 5],
    ..SLICED
};
/// Flanks in space: cells must stay longer than the contact is wide, which bounds the stations.
const STATIONS: Grids = Grids {
    positions: &[15, 30, 60],
    along: &[12, 16, 24, 32, 48],
    reference: [120, 64],
    size: |[positions, stations]| ModelSize::FlankGrid {
        positions,
        stations,
    },
    name: "stations",
};
/// Difference of e(φ, T) between two numbers of slices that is rounding, by its peak to peak.
const ROUNDING: f64 = 1e-6;

/// e(φ, T) and the tangent k(φ, T) over a pitch.
struct MeshCurves {
    te: Vec<f64>,
    stiffness: Vec<f64>,
}

/// Compares grids at the largest torque of the file: first e(φ, T), then k(φ, T).
///
/// # Errors
/// No torque; gears that cannot mesh; interrupted before anything was finished.
pub fn compare_grids(
    file: &GearFile,
    monitor: &mut Monitor,
) -> Result<Vec<ComparisonResult>, Error> {
    let at = |error: Error| file.locate(error);
    let Some(torque) = file.mesh.torques.last().copied() else {
        return Err(file.missing_torque_error());
    };
    let pair = file.pair()?;
    let options = file.mesh_options(&pair);
    let solve = |[positions, slices]: [usize; 2]| {
        let options = MeshOptions {
            positions,
            slices,
            ..options.clone()
        };
        let mesh = LoadedMesh::new(&pair, options)?.map(&[torque])?;
        let first = mesh.cycles.into_iter().next().ok_or_else(no_position)?;
        Ok(MeshCurves {
            te: first.te,
            stiffness: first.tangent,
        })
    };
    let coarse = [SLICED.along[0], SLICED.along[1]].map(|n| [SLICED.positions[0], n]);
    let coarse = parallel::try_map(&coarse, |&grid| solve(grid)).map_err(at)?;
    let (few, more) = (&coarse[0].te, &coarse[1].te);
    let grids = match rms_distance(few, more) <= ROUNDING * peak_to_peak(more) {
        true => UNIFORM,
        false => SLICED,
    };
    compare(&grids, torque, solve, monitor).map_err(at)
}

/// Compares grids of a bevel pair at a torque: first e(φ, T), then k(φ, T).
///
/// # Errors
/// A load that the teeth cannot carry; interrupted before anything was finished.
pub(super) fn compare_flank_grids(
    file: &BevelFile,
    teeth: [Option<&BevelTooth>; 2],
    contact: &BevelContact,
    torque: f64,
    monitor: &mut Monitor,
) -> Result<Vec<ComparisonResult>, Error> {
    let options = FlankMeshOptions::default();
    let teeth = bevel_mesh::bending_teeth(file, teeth, &options.materials)?;
    let bending = teeth.as_ref().map(|teeth| teeth as &dyn ToothBending);
    let solve = |[positions, stations]: [usize; 2]| {
        let options = FlankMeshOptions {
            positions,
            stations,
            ..options
        };
        let mesh = FlankMesh::new(&contact.pair, &contact.path, options, bending);
        let mesh = mesh.map(&[torque])?;
        let first = mesh.cycles.first().ok_or_else(no_position)?;
        Ok(MeshCurves {
            te: first.of(|p| p.te),
            stiffness: first.of(|p| p.tangent),
        })
    };
    compare(&STATIONS, torque, solve, monitor)
}

pub(super) fn no_position() -> Error {
    Error::new(Code::NoConvergence, "the mesh has no position")
}

/// Compares grids by what `solve` makes of positions, and slices or stations.
fn compare(
    grids: &Grids,
    torque: f64,
    solve: impl Fn([usize; 2]) -> Result<MeshCurves, Error> + Sync + Send,
    monitor: &mut Monitor,
) -> Result<Vec<ComparisonResult>, Error> {
    if !monitor.proceed("reference") {
        return Err(interrupted_error());
    }
    let fine = [grids.reference, grids.reference.map(|n| n.div_ceil(2))];
    let fine = parallel::try_map(&fine, |&grid| solve(grid))?;
    let (reference, half) = (&fine[0], &fine[1]);
    let [te_scale, stiffness_scale] = [
        peak_to_peak(&reference.te),
        reference.stiffness.iter().sum::<f64>() / reference.stiffness.len() as f64,
    ];
    let errors = |curves: &MeshCurves| {
        [
            rms_distance(&curves.te, &reference.te) / te_scale,
            rms_distance(&curves.stiffness, &reference.stiffness) / stiffness_scale,
        ]
    };
    let of_reference = errors(half);
    let mut methods = [Vec::new(), Vec::new()];
    let mut interrupted = false;
    'grids: for &along in grids.along {
        for &positions in grids.positions {
            let step = format!("{positions} positions × {along} {}", grids.name);
            if !monitor.proceed(&step) {
                interrupted = true;
                break 'grids;
            }
            let size = Some((grids.size)([positions, along]));
            let (outcome, seconds) = min_time(|| solve([positions, along]));
            for (k, methods) in methods.iter_mut().enumerate() {
                let outcome = outcome.as_ref().map_err(Clone::clone);
                let judge = |curves: &MeshCurves| match errors(curves)[k] {
                    error if error.is_finite() => Ok(error.max(of_reference[k])),
                    _ => Err("the curve does not vary".to_string()),
                };
                let name = [TE, STIFFNESS][k];
                let method = ComparedMethod::with_error(name, size, outcome, seconds, judge);
                methods.push(method);
            }
        }
    }
    if methods[0].is_empty() {
        return Err(interrupted_error());
    }
    let [positions, along] = grids.reference;
    let [te, stiffness] = methods;
    let result = |k: usize, methods: Vec<ComparedMethod>| ComparisonResult {
        quantity: format!("{} at {} N·m", [TE, STIFFNESS][k], format_number(torque)),
        norm: [
            "rms over a pitch, by its peak to peak",
            "rms over a pitch, by its mean",
        ][k],
        dofs: None,
        reference: format!("{positions} positions × {along} {}", grids.name),
        reference_error: of_reference[k],
        methods,
        interrupted,
    };
    Ok(vec![result(0, te), result(1, stiffness)])
}

const TE: &str = "e(φ, T)";
const STIFFNESS: &str = "k(φ, T)";

/// Root mean square of a curve, interpolated linearly between equal steps of a period, less a finer one.
pub(super) fn rms_distance(curve: &[f64], fine: &[f64]) -> f64 {
    let step = curve.len() as f64 / fine.len() as f64;
    let off = |(i, reference): (usize, &f64)| {
        let place = i as f64 * step;
        let before = place.floor() as usize;
        let share = place - before as f64;
        let [low, high] = [before, before + 1].map(|k| curve[k % curve.len()]);
        (low + share * (high - low) - reference).powi(2)
    };
    let sum: f64 = fine.iter().enumerate().map(off).sum();
    (sum / fine.len() as f64).sqrt()
}
