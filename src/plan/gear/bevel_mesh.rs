//! Bevel pair under load: transmission error, mesh stiffness, load sharing and contact pressure over one pitch at each torque.

use super::bevel_stability::{StabilityCase, stability};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::quantity::format_number;
use crate::base::text::pluralise;
use crate::gear::bevel::tooth::BevelTooth;
use crate::gear::contact::contact_path::ContactPath;
use crate::gear::contact::pair::FlankPair;
use crate::gear::contact::reference::ContactForces;
use crate::gear::load::bevel_teeth::BevelTeeth;
use crate::gear::load::flank_mesh::{FlankMesh, FlankMeshOptions, FlankSurplus, MIN_ASPECT};
use crate::gear::load::flank_position::ToothBending;
use crate::gear::load::flank_result::{FlankCycle, FlankLoad, FlankMeshResult, StripChange};
use crate::gear::load::load_table::{LoadInterpolation, LoadTable};
use crate::gear::load::material::Material;
use crate::plan::decision::StageDecision;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::{BevelFile, MAX_STATIONS};

/// Maximum contact half width relative to the cell length; a cell length of 1.2 to 2 half widths is recommended.
const COARSE: f64 = 1.0 / 1.2;
/// Minimum number of cells along a contact; with five, errors of pressure and approach are at most 2 %.
const MIN_CELLS: usize = 5;
/// Share of the torque carried by edge contact above which a warning is issued.
const EDGE_SHARE: f64 = 0.01;
/// Maximum tooth deflection relative to the transverse module.
const MAX_DEFLECTION: f64 = 0.05;

/// Mesh of a bevel pair under load.
#[derive(Debug, Clone)]
pub struct BevelMeshResult {
    /// Mesh over one pitch at each torque.
    pub mesh: FlankMeshResult,
    /// Lever of the contact force about the gear axis at the reference contact, m: displacement along the normal per radian.
    pub lever: f64,
    /// Model of the teeth.
    pub body: &'static str,
    /// Effects that the model neglects.
    pub left_out: Vec<&'static str>,
}

/// Studies of a loaded mesh that the file requests.
#[derive(Debug, Clone, Default)]
pub struct MeshStudies {
    /// Discretisation error of e(φ, T) by torque, rad; `None` if the mesh has no solution with half as many stations.
    pub te_errors: Option<Vec<f64>>,
    /// Interpolation errors between the torques, N·m and rad at the gear; `None` for a single torque.
    pub interpolation_error: Option<LoadInterpolation>,
    /// Torques at which strips gain or lose contact, by position, up to the largest torque; `None` unless requested.
    pub changes: Option<Vec<Vec<StripChange>>>,
    /// Contact over load and misalignment; empty unless the file states misalignments.
    pub stability: Vec<StabilityCase>,
}

/// Flanks of a file in contact, with the bending teeth.
pub struct LoadedPair<'a> {
    file: &'a BevelFile,
    pair: &'a FlankPair,
    path: &'a ContactPath,
    options: FlankMeshOptions,
    teeth: Option<BevelTeeth>,
    surplus: Option<&'a FlankSurplus<'a>>,
}

impl<'a> LoadedPair<'a> {
    /// Pairs the flanks of a path of contact with their teeth; if either tooth is missing, both are rigid.
    ///
    /// # Errors
    /// As `BevelTeeth::new`.
    pub fn new(
        file: &'a BevelFile,
        teeth: [Option<&BevelTooth>; 2],
        (pair, path): (&'a FlankPair, &'a ContactPath),
    ) -> Result<LoadedPair<'a>, Error> {
        let options = FlankMeshOptions {
            positions: file.mesh.positions,
            stations: file.mesh.stations,
            ..FlankMeshOptions::default()
        };
        let teeth = bending_teeth(file, teeth, &options.materials)?;
        Ok(LoadedPair {
            file,
            pair,
            path,
            options,
            teeth,
            surplus: None,
        })
    }

    /// Adds a surplus to the flanks.
    pub fn with_surplus(self, surplus: &'a FlankSurplus<'a>) -> LoadedPair<'a> {
        LoadedPair {
            surplus: Some(surplus),
            ..self
        }
    }

    /// Computes the mesh at torques of the pinion, N·m.
    ///
    /// # Errors
    /// A tooth deflection above the limit; those of `FlankMesh::map`.
    pub fn mesh(
        &self,
        torques: &[f64],
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Result<BevelMeshResult, Error> {
        let has_teeth = self.teeth.is_some();
        if !has_teeth {
            diagnostics.push(rigid_teeth(self.file));
        }
        let result = self.flank_mesh().map(torques);
        let result = result.map_err(|e| e.with_span(&self.file.span))?;
        let lever = ContactForces::of(self.pair, &self.path.reference).levers[1];
        check_deflection(self.file, &result, lever)?;
        diagnostics.extend(warnings(&result.cycles, self.file.mesh.stations));
        Ok(BevelMeshResult {
            mesh: result,
            lever,
            body: body(has_teeth),
            left_out: left_out(has_teeth),
        })
    }

    /// Runs the studies of the file, and estimates the discretisation error of a mesh.
    ///
    /// # Errors
    /// As `FlankMesh::map`.
    pub fn studies(&self, mesh: &FlankMeshResult) -> Result<MeshStudies, Error> {
        let located = |e: Error| e.with_span(&self.file.span);
        let study = &self.file.mesh;
        let largest = study.torques.iter().copied().fold(0.0, f64::max);
        let changes = study.changes.then(|| self.flank_mesh().changes(largest));
        let stability = stability(self.file, self.pair, self.options, self.bending());
        Ok(MeshStudies {
            // Half as many stations may be too few to solve; the error is then unknown.
            te_errors: self.flank_mesh().te_errors(mesh).ok(),
            interpolation_error: LoadTable::of(mesh).map(|table| table.interpolation()),
            changes: changes.transpose().map_err(located)?,
            stability: stability.map_err(located)?,
        })
    }

    fn flank_mesh(&self) -> FlankMesh<'_> {
        let ideal = FlankMesh::new(self.pair, self.path, self.options, self.bending());
        match self.surplus {
            Some(surplus) => ideal.with_surplus(surplus),
            None => ideal,
        }
    }

    fn bending(&self) -> Option<&dyn ToothBending> {
        self.teeth.as_ref().map(|teeth| teeth as &dyn ToothBending)
    }
}

/// Decides whether the loaded mesh is computed.
pub fn plan(file: &BevelFile) -> StageDecision {
    let study = &file.mesh;
    if study.torques.is_empty() {
        return StageDecision::LeftOut("no torque is given: [mesh] torque, or --torque".into());
    }
    if file.missing_flank().is_some() {
        return StageDecision::LeftOut("a flank of the contact is not described".into());
    }
    if file.is_conjugate() {
        return StageDecision::LeftOut("conjugate flanks touch along whole lines".into());
    }
    let has_teeth = file
        .members
        .iter()
        .all(|m| m.missing_tooth_reason().is_none());
    StageDecision::Runs(format!(
        "{} × {} positions × {} stations; {}; steel of 206 GPa{}",
        pluralise(study.torques.len(), "torque"),
        study.positions,
        study.stations,
        body(has_teeth),
        if study.changes {
            "; torques at which strips gain or lose contact"
        } else {
            ""
        }
    ))
}

fn body(has_teeth: bool) -> &'static str {
    match has_teeth {
        true => "half spaces, teeth as plates with shear on an elastic root line",
        false => "half spaces only, rigid teeth",
    }
}

fn left_out(has_teeth: bool) -> Vec<&'static str> {
    let teeth = (!has_teeth).then_some("bending of the teeth");
    let always = [
        "shafts, bearings and housing",
        "coupling of neighbouring teeth through the rim",
        "compression along the height of the tooth",
        "friction",
    ];
    teeth.into_iter().chain(always).collect()
}

/// Bending model of the teeth; `None` if a flank is not described or does not exist over the whole face width.
///
/// # Errors
/// As `BevelTeeth::new`.
pub fn bending_teeth(
    file: &BevelFile,
    teeth: [Option<&BevelTooth>; 2],
    materials: &[Material; 2],
) -> Result<Option<BevelTeeth>, Error> {
    let [Some(pinion), Some(gear)] = teeth else {
        return Ok(None);
    };
    BevelTeeth::new([pinion, gear], file.contact.side.flanks(), materials)
        .map_err(|e| e.with_span(&file.span))
}

/// Warning that the teeth are taken as rigid, with the reason.
fn rigid_teeth(file: &BevelFile) -> Diagnostic {
    let missing = (0..2).find_map(|k| Some((k, file.members[k].missing_tooth_reason()?)));
    let cause = match missing {
        Some((k, reason)) => format!("of the {}: {reason}", MEMBERS[k]),
        None => "a flank does not exist over the whole face".into(),
    };
    Diagnostic {
        code: "rigid-teeth",
        message: format!("the teeth do not bend in the loaded contact ({cause}): it is too stiff"),
        hint: Some("describe both flanks and `mean_normal_thickness`".into()),
    }
}

/// Refuses a torque at which the tooth deflection exceeds [`MAX_DEFLECTION`].
fn check_deflection(file: &BevelFile, mesh: &FlankMeshResult, lever: f64) -> Result<(), Error> {
    let mean_radius = file.members[1].blank.mean_point()[1];
    let module = 2.0 * mean_radius / f64::from(file.members[1].teeth);
    for cycle in &mesh.cycles {
        let rotations = (cycle.positions.iter().zip(&mesh.unloaded_te)).map(|(p, te)| te - p.te);
        let deflection = lever * rotations.fold(0.0, f64::max);
        if deflection > MAX_DEFLECTION * module {
            let message = format!(
                "the teeth deflect by {} mm at {} N·m: more than a twentieth of the module",
                format_number(1e3 * deflection),
                format_number(cycle.torque)
            );
            let limit = cycle.torque * MAX_DEFLECTION * module / deflection;
            return Err(Error::new(Code::OutOfRange, message)
                .with_span(&file.span)
                .with_hint(format!(
                    "give a torque of at most about {} N·m",
                    format_number(0.9 * limit)
                )));
        }
    }
    Ok(())
}

/// Warnings on the contact, each at the torque where it is worst.
fn warnings(cycles: &[FlankCycle], stations: usize) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    let mut warn = |code, message: String, hint: String| {
        let hint = Some(hint);
        diagnostics.push(Diagnostic {
            code,
            message,
            hint,
        });
    };
    let worst = |quantity: fn(&FlankLoad) -> f64| {
        let maximum = |cycle: &FlankCycle| cycle.of(quantity).into_iter().fold(0.0, f64::max);
        let rows = cycles.iter().map(|c| (maximum(c), format_number(c.torque)));
        rows.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
    };
    let (edges, torque) = worst(|p| p.edge_share);
    if edges > EDGE_SHARE {
        warn(
            "edge-contact",
            format!(
                "edges of the teeth carry up to {:.0} % of {torque} N·m: the pressure there is unbounded and not in the table",
                100.0 * edges
            ),
            "more crowning, or another [assembly], keeps the contact on the flanks".into(),
        );
    }
    let (coarse, torque) = worst(|p| p.cell_width_ratio);
    if coarse > COARSE {
        warn(
            "short-cells",
            format!(
                "the contact at {torque} N·m is up to {coarse:.1} half widths per cell length (limit {COARSE:.2}): its pressure is not resolved"
            ),
            format!(
                "give fewer `stations` in [mesh] than {stations}, or run the largest torques separately"
            ),
        );
    }
    let (overhang, torque) = worst(|p| p.overhang);
    if overhang > 1.0 {
        warn(
            "ellipse-beyond-teeth",
            format!(
                "the contact ellipse at {torque} N·m is {overhang:.1} times as long as the available face: approach and pressure are those of a whole ellipse"
            ),
            format!(
                "give a smaller torque, or less crowning: strips resolve ellipses from a/b {MIN_ASPECT}"
            ),
        );
    }
    let cells = cycles.iter().filter_map(|cycle| {
        let shortest = cycle
            .positions
            .iter()
            .filter_map(|p| p.longest_contact())
            .min()?;
        Some((shortest, format_number(cycle.torque)))
    });
    let shortest = cells.min_by_key(|(cells, _)| *cells);
    if let Some((cells, torque)) = shortest.filter(|(cells, _)| *cells < MIN_CELLS) {
        let needed = (stations * MIN_CELLS).div_ceil(cells.max(1));
        let needed = needed.min(MAX_STATIONS as usize);
        warn(
            "short-contact",
            format!(
                "at some position no contact at {torque} N·m covers more than {} (limit {MIN_CELLS}): approach and pressure are off by more than 2 %",
                pluralise(cells, "station")
            ),
            format!(
                "give about {needed} `stations` in [mesh], there are {stations}; or a larger torque"
            ),
        );
    }
    diagnostics
}
