//! Sensitivity of the loaded contact of a bevel pair: pattern, transmission error and pressure over load and misalignment.

use crate::base::error::Error;
use crate::base::quantity::format_number;
use crate::gear::contact::pair::{Assembly, FlankPair};
use crate::gear::load::flank_mesh::{FlankMesh, FlankMeshOptions};
use crate::gear::load::flank_position::ToothBending;
use crate::gear::load::flank_result::FlankCycle;
use crate::numeric::parallel;
use crate::numeric::statistics::peak_to_peak;
use crate::plan::decision::StageDecision;
use crate::scene::bevel_file::BevelFile;

/// Loaded contact under one misalignment.
#[derive(Debug, Clone, PartialEq)]
pub struct StabilityCase {
    /// Name of the misalignment.
    pub name: String,
    /// Misalignment relative to the assembly of the file.
    pub change: Assembly,
    /// Torque at the pinion, N·m.
    pub torque: f64,
    /// Contact; absent if the flanks do not touch near the middle of the teeth.
    pub contact: Option<LoadedPattern>,
}

/// Pattern, transmission error and pressure over one pitch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedPattern {
    /// Force-weighted centre of the pattern as fractions of face and height of the pinion.
    pub centre: [f64; 2],
    /// Shift from the centre without misalignment at the same torque along face and height, m.
    pub shift: [f64; 2],
    /// Peak-to-peak transmission error, rad at the gear.
    pub peak_to_peak: f64,
    /// Maximum pressure within the flanks, Pa.
    pub pressure: Option<f64>,
    /// Maximum share of the torque on edges, 0 to 1.
    pub edge_share: f64,
}

/// Loaded contact at the smallest and largest torque: without misalignment, with each tolerance in both directions, with housing deflection.
///
/// # Errors
/// Those of `FlankMesh::map`.
pub fn stability(
    file: &BevelFile,
    pair: &FlankPair,
    options: FlankMeshOptions,
    teeth: Option<&dyn ToothBending>,
) -> Result<Vec<StabilityCase>, Error> {
    if file.stability.is_empty() {
        return Ok(Vec::new());
    }
    let mut cases = Vec::new();
    for torque in torques(file) {
        for (name, change) in misalignments(file, torque) {
            cases.push((name, change, torque));
        }
    }
    let results = parallel::try_map(&cases, |(_, change, torque)| {
        loaded_contact(file, pair, change, *torque, (options, teeth))
    })?;
    let nominal = |torque: f64| {
        let pairs = cases.iter().zip(&results);
        let mut pairs =
            pairs.filter(|((_, change, t), _)| *t == torque && *change == Assembly::default());
        pairs.next().and_then(|(_, c)| c.map(|s| s.centre))
    };
    let lengths = pair.flanks[0].section.mean_lengths();
    let pairs = cases.iter().zip(&results);
    let case =
        |((name, change, torque), contact): (&(String, Assembly, f64), &Option<LoadedPattern>)| {
            let base = nominal(*torque);
            let shifted = |contact: LoadedPattern| LoadedPattern {
                shift: [0, 1].map(|k| {
                    base.map_or(f64::NAN, |base| lengths[k] * (contact.centre[k] - base[k]))
                }),
                ..contact
            };
            StabilityCase {
                name: name.clone(),
                change: *change,
                torque: *torque,
                contact: contact.map(shifted),
            }
        };
    Ok(pairs.map(case).collect())
}

/// Stage of the plan; `None` if the study is not requested.
pub fn plan(file: &BevelFile) -> Option<StageDecision> {
    if file.stability.is_empty() {
        return None;
    }
    let torques = torques(file);
    let cases: usize = torques.iter().map(|t| misalignments(file, *t).len()).sum();
    Some(match cases {
        0 => StageDecision::LeftOut("no torque is given: [mesh] torque, or --torque".into()),
        _ if file.missing_flank().is_some() || file.is_conjugate() => {
            StageDecision::LeftOut("there is no loaded contact to compare".into())
        }
        n => StageDecision::Runs(format!(
            "{n} loaded contacts: tolerances both ways, housing"
        )),
    })
}

/// Smallest and largest torque of the file, N·m.
fn torques(file: &BevelFile) -> Vec<f64> {
    match file.mesh.torques[..] {
        [] => Vec::new(),
        [torque] => vec![torque],
        [first, .., last] => vec![first, last],
    }
}

/// Misalignments with their names, the zero misalignment first.
fn misalignments(file: &BevelFile, torque: f64) -> Vec<(String, Assembly)> {
    let t = &file.stability.tolerance;
    let zero = Assembly::default();
    let tolerances = [
        (
            "E",
            t.offset,
            Assembly {
                offset: t.offset,
                ..zero
            },
        ),
        (
            "P",
            t.pinion_axial,
            Assembly {
                pinion_axial: t.pinion_axial,
                ..zero
            },
        ),
        (
            "G",
            t.gear_axial,
            Assembly {
                gear_axial: t.gear_axial,
                ..zero
            },
        ),
        (
            "ΔΣ",
            t.shaft_angle,
            Assembly {
                shaft_angle: t.shaft_angle,
                ..zero
            },
        ),
    ];
    let mut cases = vec![("as in the file".to_string(), zero)];
    for (symbol, size, change) in tolerances {
        if size != 0.0 {
            let value = match symbol {
                "ΔΣ" => format!("{}′", format_number(60.0 * size.to_degrees())),
                _ => format!("{} µm", format_number(1e6 * size)),
            };
            cases.push((format!("{symbol} +{value}"), change));
            cases.push((format!("{symbol} −{value}"), zero.changed(&change, -1.0)));
        }
    }
    if let Some(housing) = &file.stability.housing {
        let change = zero.changed(&housing.change, torque / housing.torque);
        cases.push(("housing".to_string(), change));
    }
    cases
}

/// Loaded contact under a misalignment.
fn loaded_contact(
    file: &BevelFile,
    pair: &FlankPair,
    change: &Assembly,
    torque: f64,
    (options, teeth): (FlankMeshOptions, Option<&dyn ToothBending>),
) -> Result<Option<LoadedPattern>, Error> {
    let assembly = file.assembly().changed(change, 1.0);
    let misaligned = FlankPair::new(pair.flanks.clone(), pair.teeth, file.hand, &assembly);
    let path = misaligned.path_near_teeth(file.contact.pitches, file.contact.positions);
    let Some(path) = path else {
        return Ok(None);
    };
    let result = FlankMesh::new(&misaligned, &path, options, teeth).map(&[torque])?;
    Ok(result
        .cycles
        .first()
        .and_then(|cycle| loaded_pattern(pair, cycle)))
}

fn loaded_pattern(pair: &FlankPair, cycle: &FlankCycle) -> Option<LoadedPattern> {
    Some(LoadedPattern {
        centre: pair.flanks[0].section.shares(cycle.centre(0)?)?,
        shift: [0.0; 2],
        peak_to_peak: peak_to_peak(&cycle.of(|p| p.te)),
        pressure: cycle.max_pressure_position().and_then(|p| p.pressure),
        edge_share: cycle.of(|p| p.edge_share).into_iter().fold(0.0, f64::max),
    })
}
