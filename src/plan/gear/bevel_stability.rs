//! Stability of the loaded contact of a bevel pair: pattern, transmission error and pressure over load and misalignment.

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

/// The loaded contact under one departure of the axes.
#[derive(Debug, Clone, PartialEq)]
pub struct StabilityCase {
    /// The departure in words.
    pub name: String,
    /// Departure from the places of the file.
    pub change: Assembly,
    /// Torque at the pinion, N·m.
    pub torque: f64,
    /// The contact; none where the flanks do not touch near the middle of their teeth.
    pub contact: Option<LoadedPattern>,
}

/// Pattern, transmission error and pressure over one pitch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedPattern {
    /// Centre of the pattern, the places weighted with their forces, as shares of face and height of the pinion.
    pub centre: [f64; 2],
    /// Shift from the centre of the file at the same torque along face and height, m.
    pub shift: [f64; 2],
    /// Peak-to-peak transmission error, rad at the gear.
    pub peak_to_peak: f64,
    /// Greatest pressure within the flanks, Pa.
    pub pressure: Option<f64>,
    /// Largest share of the torque on edges.
    pub edge_share: f64,
}

/// The contact of the file at its least and largest torque, then under each tolerance both ways and under the deflection of the housing.
///
/// # Errors
/// As `FlankMesh::map`.
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
        for (name, change) in departures(file, torque) {
            cases.push((name, change, torque));
        }
    }
    let results = parallel::try_map(&cases, |(_, change, torque)| {
        state(file, pair, change, *torque, (options, teeth))
    })?;
    let nominal = |torque: f64| {
        let found = cases.iter().zip(&results);
        let mut found =
            found.filter(|((_, change, of), _)| *of == torque && *change == Assembly::default());
        found.next().and_then(|(_, state)| state.map(|s| s.centre))
    };
    let lengths = pair.flanks[0].section.mean_lengths();
    let named = cases.iter().zip(&results);
    let case =
        |((name, change, torque), state): (&(String, Assembly, f64), &Option<LoadedPattern>)| {
            let from = nominal(*torque);
            let shifted = |state: LoadedPattern| LoadedPattern {
                shift: [0, 1].map(|k| {
                    from.map_or(f64::NAN, |from| lengths[k] * (state.centre[k] - from[k]))
                }),
                ..state
            };
            StabilityCase {
                name: name.clone(),
                change: *change,
                torque: *torque,
                contact: state.map(shifted),
            }
        };
    Ok(named.map(case).collect())
}

/// The stage of the plan; none where nothing is requested.
pub fn plan(file: &BevelFile) -> Option<StageDecision> {
    if file.stability.is_empty() {
        return None;
    }
    let torques = torques(file);
    let cases: usize = torques.iter().map(|t| departures(file, *t).len()).sum();
    Some(match cases {
        0 => StageDecision::LeftOut("no torque is given: [mesh] torque, or --torque".into()),
        _ if file.missing_flank().is_some() || file.is_conjugate() => {
            StageDecision::LeftOut("without a loaded contact nothing is compared".into())
        }
        n => StageDecision::Runs(format!(
            "{n} loaded contacts: tolerances both ways, housing"
        )),
    })
}

/// Least and largest torque of the file.
fn torques(file: &BevelFile) -> Vec<f64> {
    match file.mesh.torques[..] {
        [] => Vec::new(),
        [only] => vec![only],
        [first, .., last] => vec![first, last],
    }
}

/// Departures with their names, none first.
fn departures(file: &BevelFile, torque: f64) -> Vec<(String, Assembly)> {
    let t = &file.stability.tolerance;
    let none = Assembly::default();
    let single = [
        (
            "E",
            t.offset,
            Assembly {
                offset: t.offset,
                ..none
            },
        ),
        (
            "P",
            t.pinion_axial,
            Assembly {
                pinion_axial: t.pinion_axial,
                ..none
            },
        ),
        (
            "G",
            t.gear_axial,
            Assembly {
                gear_axial: t.gear_axial,
                ..none
            },
        ),
        (
            "ΔΣ",
            t.shaft_angle,
            Assembly {
                shaft_angle: t.shaft_angle,
                ..none
            },
        ),
    ];
    let mut all = vec![("as in the file".to_string(), none)];
    for (symbol, size, change) in single {
        if size != 0.0 {
            let shown = match symbol {
                "ΔΣ" => format!("{}′", format_number(60.0 * size.to_degrees())),
                _ => format!("{} µm", format_number(1e6 * size)),
            };
            all.push((format!("{symbol} +{shown}"), change));
            all.push((format!("{symbol} −{shown}"), none.changed(&change, -1.0)));
        }
    }
    if let Some(housing) = &file.stability.housing {
        let change = none.changed(&housing.change, torque / housing.torque);
        all.push(("housing".to_string(), change));
    }
    all
}

/// The contact under a departure.
fn state(
    file: &BevelFile,
    pair: &FlankPair,
    change: &Assembly,
    torque: f64,
    (options, teeth): (FlankMeshOptions, Option<&dyn ToothBending>),
) -> Result<Option<LoadedPattern>, Error> {
    let assembly = file.assembly().changed(change, 1.0);
    let moved = FlankPair::new(pair.flanks.clone(), pair.teeth, file.hand, &assembly);
    let path = moved.path_near_teeth(file.contact.pitches, file.contact.positions);
    let Some(path) = path else {
        return Ok(None);
    };
    let result = FlankMesh::new(&moved, &path, options, teeth).map(&[torque])?;
    Ok(result
        .cycles
        .first()
        .and_then(|cycle| of_cycle(pair, cycle)))
}

fn of_cycle(pair: &FlankPair, cycle: &FlankCycle) -> Option<LoadedPattern> {
    Some(LoadedPattern {
        centre: pair.flanks[0].section.shares(cycle.centre(0)?)?,
        shift: [0.0; 2],
        peak_to_peak: peak_to_peak(&cycle.of(|p| p.te)),
        pressure: cycle.most_pressed().and_then(|p| p.pressure),
        edge_share: cycle.of(|p| p.edge_share).into_iter().fold(0.0, f64::max),
    })
}
