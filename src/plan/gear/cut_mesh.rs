//! Transmission error and pattern of a pair as its flanks are cut, for each cause: deviations along the normals of the ideal flanks turn
//! the gear ahead by deviation over arm.

use super::bevel_contact::BevelContact;
use super::bevel_member;
use super::bevel_mesh::LoadedPair;
use super::cut_causes::{ALL, REGULAR};
use super::cut_flank::{CauseResult, CutFlankResult};
use crate::base::error::{Diagnostic, Error};
use crate::numeric::statistics::peak_to_peak;
use crate::scene::bevel_file::BevelFile;

/// The mesh of a pair with one cause of deviations.
#[derive(Debug, Clone)]
pub struct CutMesh {
    /// The cause; none of the ideal flanks.
    pub cause: Option<String>,
    /// Peak-to-peak transmission error without load, rad at the gear.
    pub unloaded: f64,
    /// Under the largest torque of the file, where it has one.
    pub loaded: Option<LoadedCut>,
}

/// A cut pair under load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadedCut {
    /// Torque of the pinion, N·m.
    pub torque: f64,
    /// Peak-to-peak transmission error, rad at the gear.
    pub peak_to_peak: f64,
    /// Centre of the pattern, the places weighted with their forces, as shares of face and height of the pinion.
    pub centre: Option<[f64; 2]>,
}

/// The mesh of the ideal flanks, and with each cause on the touching flanks that are cut; empty where they do not touch at every angle.
///
/// # Errors
/// As [`LoadedPair::mesh`].
pub fn meshes(
    file: &BevelFile,
    ideal: &BevelContact,
    flanks: &[CutFlankResult],
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<Vec<CutMesh>, Error> {
    if ideal.peak_to_peak.is_none() {
        return Ok(Vec::new());
    }
    let sides = file.contact.side.flanks();
    let cut = [0, 1].map(|k| {
        let mut of_member = flanks
            .iter()
            .filter(|f| f.member == k && f.side == sides[k]);
        of_member.next()
    });
    let causes = cut.iter().flatten().map(|f| &f.causes);
    let names = causes.max_by_key(|causes| causes.len());
    let names = names.into_iter().flatten().map(|c| Some(c.name.clone()));
    let teeth = [0, 1].map(|k| bevel_member::tooth(file, k));
    let torque: Vec<f64> = file
        .mesh
        .torques
        .iter()
        .copied()
        .reduce(f64::max)
        .into_iter()
        .collect();
    let mesh = |cause: Option<String>, diagnostics: &mut Vec<Diagnostic>| {
        let of = cut.map(|flank| with_cause(flank?, cause.as_deref()?));
        let deviation = |member: usize, at: [f64; 3]| {
            let point = ideal.pair.flanks[member].envelope.point(at)?;
            of[member]?.passes.mean_deviation(&point, 0.0)
        };
        // Where no blade reaches, the warning of the flank says so.
        let surplus = |member: usize, at: [f64; 3]| deviation(member, at).unwrap_or(0.0);
        let teeth = teeth.each_ref().map(Option::as_ref);
        let pair = LoadedPair::new(file, teeth, (&ideal.pair, &ideal.path))?;
        let result = pair.with_surplus(&surplus).mesh(&torque, diagnostics)?.mesh;
        let section = &ideal.pair.flanks[0].section;
        let loaded = result.cycles.first().map(|cycle| LoadedCut {
            torque: cycle.torque,
            peak_to_peak: peak_to_peak(&cycle.of(|p| p.te)),
            centre: cycle.centre(0).and_then(|place| section.shares(place)),
        });
        Ok(CutMesh {
            cause,
            unloaded: peak_to_peak(&result.unloaded_te),
            loaded,
        })
    };
    let mut warnings = Vec::new();
    let mut all = vec![mesh(None, &mut warnings)?];
    if !torque.is_empty() {
        diagnostics.extend(warnings);
    }
    for name in names {
        all.push(mesh(name, &mut Vec::new())?);
    }
    Ok(all)
}

/// The cut of a flank by a cause of the pair: a flank that the cause does not reach is that of regular blades.
fn with_cause<'a>(flank: &'a CutFlankResult, name: &str) -> Option<&'a CauseResult> {
    let by_name = |name: &str| flank.causes.iter().find(|c| c.name == name);
    let last = flank.causes.last().filter(|_| name == ALL);
    by_name(name).or(last).or_else(|| by_name(REGULAR))
}
