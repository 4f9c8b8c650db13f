//! Error of e(φ, T) and k(φ, T) of a mesh against run time, over grids of positions and slices.
//!
//! Curves over a pitch are compared with those of a finer grid by linear interpolation, as a table of them is used; the distance of the
//! grid of half as many positions and slices is the error of the reference.

use super::comparison::{ComparedMethod, ComparisonResult, ModelSize};
use super::monitor::{Monitor, interrupted_error};
use super::timing::min_time;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_number;
use crate::gear::load::mesh::{LoadedMesh, MeshOptions};
use crate::gear::load::mesh_result::{LoadedCycle, peak_to_peak};
use crate::numeric::parallel;
use crate::scene::gear_file::GearFile;

/// Grids that are compared, and the reference.
struct Grids {
    /// In one pitch.
    positions: &'static [usize],
    /// Along the face.
    slices: &'static [usize],
    /// Positions and slices.
    reference: [usize; 2],
}

/// Teeth that differ along the face: slices enter contact one by one, so that errors fall with their number.
const SLICED: Grids = Grids {
    positions: &[15, 30, 60],
    slices: &[5, 11, 21, 41, 81],
    reference: [240, 401],
};
/// Teeth alike along the face: the number of slices makes no difference.
const UNIFORM: Grids = Grids {
    positions: &[15, 30, 60, 120, 240],
    slices: &[5],
    reference: [1920, 5],
};
/// Difference of e(φ, T) between two numbers of slices that is rounding, by its peak to peak.
const ROUNDING: f64 = 1e-6;

/// Compares grids at the largest torque of the file: first e(φ, T), then k(φ, T).
///
/// # Errors
/// No torque; gears that cannot mesh; interrupted before anything was finished.
pub fn compare_grids(
    file: &GearFile,
    monitor: &mut Monitor,
) -> Result<[ComparisonResult; 2], Error> {
    let at = |error: Error| file.locate(error);
    let Some(torque) = file.mesh.torques.last().copied() else {
        return Err(file.no_torque());
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
        let first = mesh.cycles.into_iter().next();
        first.ok_or_else(|| Error::new(Code::NoConvergence, "the mesh has no position"))
    };
    if !monitor.proceed("reference") {
        return Err(interrupted_error());
    }
    let solve_all =
        |grids: &[[usize; 2]]| parallel::try_map(grids, |&grid| solve(grid)).map_err(at);
    let coarse = [SLICED.slices[0], SLICED.slices[1]].map(|n| [SLICED.positions[0], n]);
    let coarse = solve_all(&coarse)?;
    let (few, more) = (&coarse[0].te, &coarse[1].te);
    let grids = match rms_distance(few, more) <= ROUNDING * peak_to_peak(more) {
        true => UNIFORM,
        false => SLICED,
    };
    let fine = solve_all(&[grids.reference, grids.reference.map(|n| n.div_ceil(2))])?;
    let (reference, half) = (&fine[0], &fine[1]);
    let [te_scale, stiffness_scale] = [
        peak_to_peak(&reference.te),
        reference.tangent.iter().sum::<f64>() / reference.tangent.len() as f64,
    ];
    let errors = |cycle: &LoadedCycle| {
        [
            rms_distance(&cycle.te, &reference.te) / te_scale,
            rms_distance(&cycle.tangent, &reference.tangent) / stiffness_scale,
        ]
    };
    let of_reference = errors(half);
    let mut methods = [Vec::new(), Vec::new()];
    let mut interrupted = false;
    'grids: for &slices in grids.slices {
        for &positions in grids.positions {
            if !monitor.proceed(&format!("{positions} positions × {slices} slices")) {
                interrupted = true;
                break 'grids;
            }
            let size = Some(ModelSize::MeshGrid { positions, slices });
            let (outcome, seconds) = min_time(|| solve([positions, slices]));
            for (k, methods) in methods.iter_mut().enumerate() {
                let outcome = outcome.as_ref().map_err(Clone::clone);
                let judge = |cycle: &LoadedCycle| match errors(cycle)[k] {
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
    let [positions, slices] = grids.reference;
    let [te, stiffness] = methods;
    let result = |k: usize, methods: Vec<ComparedMethod>| ComparisonResult {
        quantity: format!("{} at {} N·m", [TE, STIFFNESS][k], format_number(torque)),
        norm: [
            "rms over a pitch, by its peak to peak",
            "rms over a pitch, by its mean",
        ][k],
        dofs: None,
        reference: format!("{positions} positions × {slices} slices"),
        reference_error: of_reference[k],
        methods,
        interrupted,
    };
    Ok([result(0, te), result(1, stiffness)])
}

const TE: &str = "e(φ, T)";
const STIFFNESS: &str = "k(φ, T)";

/// Root mean square of a curve, interpolated linearly between equal steps of a period, less a finer one.
fn rms_distance(curve: &[f64], fine: &[f64]) -> f64 {
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
