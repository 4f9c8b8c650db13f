//! Error of a bevel pair's transmission error against run time: loaded over grids, or unloaded by the path of contact and by ridges of least
//! gap.
//!
//! Newton's method runs to rounding in both, so that no tolerance is left to choose: the error is that of straight lines between
//! positions, and of stations along the face between which a ridge has its crest.

use super::comparison::{ComparedMethod, ComparisonResult, ModelSize};
use super::mesh_grid::{compare_flank_grids, no_position, rms_distance};
use super::monitor::{Monitor, interrupted_error};
use super::timing::min_time;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::contact::contact_path::{ContactPath, PITCHES};
use crate::gear::contact::pair::FlankPair;
use crate::gear::contact::ridge::RidgeStations;
use crate::numeric::statistics::peak_to_peak;
use crate::plan::gear::bevel;
use crate::scene::bevel_file::BevelFile;

/// Positions of a pitch along the path.
const PATHS: [usize; 5] = [15, 30, 60, 120, 240];
/// Positions and stations of the ridges.
const RIDGES: [[usize; 2]; 6] = [[15, 17], [15, 65], [60, 17], [60, 65], [240, 17], [240, 65]];
/// Positions of the reference.
const REFERENCE: usize = 1920;

/// Compares grids at the largest torque of a file, first e(φ, T), then k(φ, T); without a torque the unloaded transmission error alone.
///
/// # Errors
/// No contact; a load that the teeth cannot carry; interrupted before anything was finished.
pub fn compare_bevel_grids(
    file: &BevelFile,
    monitor: &mut Monitor,
) -> Result<Vec<ComparisonResult>, Error> {
    let at = |error: Error| error.with_span(&file.span);
    let mut bare = file.clone();
    bare.mesh.torques.clear();
    let result = bevel::run(&bare)?;
    let Some(contact) = &result.contact else {
        let (message, hint) = match file.missing_flank() {
            Some(_) => (
                "there is no contact to compare: a flank is not described",
                "give the settings of pinion and gear",
            ),
            None => (
                "no flanks are in contact: nothing to compare",
                "run `geardyn gear` on this file for the reason",
            ),
        };
        return Err(at(Error::new(Code::OutOfRange, message).with_hint(hint)));
    };
    let compared = match file.mesh.torques.last() {
        Some(&torque) => {
            let teeth = result.members.each_ref().map(|m| m.tooth.as_ref());
            compare_flank_grids(file, teeth, contact, torque, monitor)
        }
        None if contact.pair.overlap(&contact.path).is_some() => {
            let message = "teeth interfere away from the path of contact: its transmission error is not that of the pair";
            Err(Error::new(Code::OutOfRange, message)
                .with_hint("add [mesh] with torque = \"100 N·m\" to the file to compare the whole flank under load"))
        }
        None => compare_unloaded(&contact.pair, &contact.path, monitor).map(|one| vec![one]),
    };
    compared.map_err(at)
}

/// Compares grids for the transmission error without a load.
fn compare_unloaded(
    pair: &FlankPair,
    path: &ContactPath,
    monitor: &mut Monitor,
) -> Result<ComparisonResult, Error> {
    if !monitor.proceed("reference") {
        return Err(interrupted_error());
    }
    let fine = by_path(pair, path, REFERENCE)?;
    let scale = peak_to_peak(&fine);
    let error = |curve: &[f64]| rms_distance(curve, &fine) / scale;
    let reference_error = error(&by_path(pair, path, REFERENCE / 2)?);
    let judge = |curve: Vec<f64>| match error(&curve) {
        error if error.is_finite() => Ok(error.max(reference_error)),
        _ => Err("the transmission error does not vary".to_string()),
    };
    let mut methods = Vec::new();
    let mut interrupted = false;
    let paths = PATHS.map(|positions| (positions, None));
    let ridges = RIDGES.map(|[positions, stations]| (positions, Some(stations)));
    for (positions, stations) in paths.into_iter().chain(ridges) {
        if !monitor.proceed(&format!("{positions} positions")) {
            interrupted = true;
            break;
        }
        let (name, size) = match stations {
            None => ("path of contact", ModelSize::Positions(positions)),
            Some(stations) => (
                "ridges of least gap",
                ModelSize::FlankGrid {
                    positions,
                    stations,
                },
            ),
        };
        let (outcome, seconds) = min_time(|| match stations {
            None => by_path(pair, path, positions),
            Some(stations) => by_ridges(pair, path, [positions, stations]),
        });
        methods.push(ComparedMethod::with_error(
            name,
            Some(size),
            outcome,
            seconds,
            judge,
        ));
    }
    if methods.is_empty() {
        return Err(interrupted_error());
    }
    Ok(ComparisonResult {
        quantity: "unloaded transmission error".to_string(),
        norm: "rms over a pitch, by its peak to peak",
        dofs: None,
        reference: format!("path of contact at {REFERENCE} positions"),
        reference_error,
        methods,
        interrupted,
    })
}

/// The leading pair along the path of contact, rad.
fn by_path(pair: &FlankPair, path: &ContactPath, positions: usize) -> Result<Vec<f64>, Error> {
    let path = pair.path(path.reference, PITCHES, positions);
    over_pitch(pair, &path, positions, |angle| {
        Some(pair.leading(&path, angle)?.te)
    })
}

/// The highest station of all pairs, rad.
fn by_ridges(
    pair: &FlankPair,
    path: &ContactPath,
    [positions, stations]: [usize; 2],
) -> Result<Vec<f64>, Error> {
    let stations = RidgeStations::over_face(pair, &path.reference, stations);
    over_pitch(pair, path, positions, |angle| {
        let ridges = stations.ridges(pair, angle).into_iter();
        ridges.map(|place| place.te).reduce(f64::max)
    })
}

fn over_pitch(
    pair: &FlankPair,
    path: &ContactPath,
    positions: usize,
    te: impl Fn(f64) -> Option<f64>,
) -> Result<Vec<f64>, Error> {
    let step = pair.pitch() / positions as f64;
    (0..positions)
        .map(|i| te(path.reference.pinion_angle + step * i as f64).ok_or_else(no_position))
        .collect()
}
