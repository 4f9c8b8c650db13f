//! Bevel pair under load: loaded transmission error, stiffness, shares, pressure over one pitch for every torque.

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
use crate::gear::load::flank_mesh::{FlankMesh, FlankMeshOptions, FlankSurplus, LEAST_ASPECT};
use crate::gear::load::flank_position::ToothBending;
use crate::gear::load::flank_result::{FlankCycle, FlankLoad, FlankMeshResult, StripChange};
use crate::gear::load::load_table::{LoadInterpolation, LoadTable};
use crate::gear::load::material::Material;
use crate::plan::decision::StageDecision;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::{BevelFile, MAX_STATIONS};

/// Half widths of the contact in a length of its cells above which the cells are too short: recommended are 1.2 to 2 half widths.
const COARSE: f64 = 1.0 / 1.2;
/// Least cells of a contact: with five, pressure and approach are off by up to 2 %.
const LEAST_CELLS: usize = 5;
/// Share of the torque on edges that is worth a warning.
const EDGE_SHARE: f64 = 0.01;
/// Deflection in transverse modules that no tooth bears.
const LARGEST_DEFLECTION: f64 = 0.05;

/// A bevel pair under load.
#[derive(Debug, Clone)]
pub struct BevelMeshResult {
    /// The pitch at every torque.
    pub mesh: FlankMeshResult,
    /// Lever of the contact force about the gear's axis at the reference contact, m: turn times it is a displacement along the normal.
    pub lever: f64,
    /// Model of the teeth.
    pub body: &'static str,
    /// Effects that the model neglects.
    pub left_out: Vec<&'static str>,
}

/// Studies of a loaded mesh that the file asks for.
#[derive(Debug, Clone, Default)]
pub struct MeshStudies {
    /// Error of e(φ, T) from the stations by torque, rad; none where half as many do not carry.
    pub te_errors: Option<Vec<f64>>,
    /// Errors between the torques, N·m and rad at the gear; none of a single torque.
    pub between_torques: Option<LoadInterpolation>,
    /// Torques up to the largest at which strips begin or cease to carry, by position, where they are requested.
    pub changes: Option<Vec<Vec<StripChange>>>,
    /// The contact over load and misalignment, where departures of the axes are stated.
    pub stability: Vec<StabilityCase>,
}

/// Flanks of a file in contact, with the teeth that bend under load.
pub struct LoadedPair<'a> {
    file: &'a BevelFile,
    pair: &'a FlankPair,
    path: &'a ContactPath,
    options: FlankMeshOptions,
    teeth: Option<BevelTeeth>,
    surplus: Option<&'a FlankSurplus<'a>>,
}

impl<'a> LoadedPair<'a> {
    /// The flanks of a path of contact; a gear without its tooth makes both rigid.
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

    /// The same with flanks that carry a surplus.
    pub fn with_surplus(self, surplus: &'a FlankSurplus<'a>) -> LoadedPair<'a> {
        LoadedPair {
            surplus: Some(surplus),
            ..self
        }
    }

    /// The mesh at torques of the pinion, N·m.
    ///
    /// # Errors
    /// A load that the teeth cannot carry; as `FlankMesh::map`.
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

    /// The studies of the file, and the error of a mesh.
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
            // Half as many stations may be too few to solve: then the error is not known.
            te_errors: self.flank_mesh().te_errors(mesh).ok(),
            between_torques: LoadTable::of(mesh).map(|table| table.interpolation()),
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

/// The stage of the plan.
pub fn plan(file: &BevelFile) -> StageDecision {
    let study = &file.mesh;
    if study.torques.is_empty() {
        return StageDecision::LeftOut("no torque is given: [mesh] torque, or --torque".into());
    }
    if file.missing_flank().is_some() {
        return StageDecision::LeftOut("a flank of the contact is not described".into());
    }
    if file.is_conjugate() {
        return StageDecision::LeftOut(
            "conjugate flanks have no ridge of least gap: they touch along whole lines".into(),
        );
    }
    let has_teeth = file.members.iter().all(|m| m.lacks_tooth().is_none());
    StageDecision::Runs(format!(
        "{} × {} positions × {} stations; {}; steel of 206 GPa{}",
        pluralise(study.torques.len(), "torque"),
        study.positions,
        study.stations,
        body(has_teeth),
        if study.changes {
            "; torques at which strips begin or cease to carry"
        } else {
            ""
        }
    ))
}

fn body(has_teeth: bool) -> &'static str {
    match has_teeth {
        true => "half spaces, teeth as plates with shear on an elastic root line",
        false => "half spaces alone, rigid teeth",
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

/// The teeth that bend; none where a flank is not described or does not exist over the whole face.
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

/// The teeth are taken as rigid, with the reason.
fn rigid_teeth(file: &BevelFile) -> Diagnostic {
    let lacks = (0..2).find_map(|k| Some((k, file.members[k].lacks_tooth()?)));
    let why = match lacks {
        Some((k, reason)) => format!("of the {}: {reason}", MEMBERS[k]),
        None => "a flank does not exist over the whole face".into(),
    };
    Diagnostic {
        code: "rigid-teeth",
        message: format!("the teeth do not bend in the loaded contact ({why}): it is too stiff"),
        hint: Some("describe both flanks and `mean_normal_thickness`".into()),
    }
}

/// Refuses a torque under which the teeth would deflect by more than they bear.
fn check_deflection(file: &BevelFile, mesh: &FlankMeshResult, lever: f64) -> Result<(), Error> {
    let mean = file.members[1].blank.mean_point()[1];
    let module = 2.0 * mean / f64::from(file.members[1].teeth);
    for cycle in &mesh.cycles {
        let turns = (cycle.positions.iter().zip(&mesh.unloaded_te)).map(|(p, te)| te - p.te);
        let deflection = lever * turns.fold(0.0, f64::max);
        if deflection > LARGEST_DEFLECTION * module {
            let message = format!(
                "the teeth deflect by {} mm at {} N·m: more than a twentieth of the module, which no tooth bears",
                format_number(1e3 * deflection),
                format_number(cycle.torque)
            );
            let least = cycle.torque * LARGEST_DEFLECTION * module / deflection;
            return Err(Error::new(Code::OutOfRange, message)
                .with_span(&file.span)
                .with_hint(format!(
                    "give a torque of at most about {} N·m",
                    format_number(0.9 * least)
                )));
        }
    }
    Ok(())
}

/// Warnings on the pitch, each of the torque at which it is worst.
fn warnings(cycles: &[FlankCycle], stations: usize) -> Vec<Diagnostic> {
    let mut all = Vec::new();
    let mut warn = |code, message: String, hint: String| {
        let hint = Some(hint);
        all.push(Diagnostic {
            code,
            message,
            hint,
        });
    };
    let worst = |of: fn(&FlankLoad) -> f64| {
        let most = |cycle: &FlankCycle| cycle.of(of).into_iter().fold(0.0, f64::max);
        let all = cycles.iter().map(|c| (most(c), format_number(c.torque)));
        all.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
    };
    let (edges, torque) = worst(|p| p.edge_share);
    if edges > EDGE_SHARE {
        warn(
            "edge-contact",
            format!(
                "edges of the teeth carry up to {:.0} % of {torque} N·m: the pressure there has no bound and is not in the table",
                100.0 * edges
            ),
            "more crowning, or another [assembly], keeps the contact on the flanks".into(),
        );
    }
    let (coarse, torque) = worst(|p| p.coarse);
    if coarse > COARSE {
        warn(
            "short-cells",
            format!(
                "the contact at {torque} N·m is up to {coarse:.1} half widths wide on a cell's length (limit {COARSE:.2}): its pressure is not resolved"
            ),
            format!(
                "give fewer `stations` in [mesh] than {stations}, or the largest torques in a run of their own"
            ),
        );
    }
    let (overhang, torque) = worst(|p| p.overhang);
    if overhang > 1.0 {
        warn(
            "ellipse-beyond-teeth",
            format!(
                "the contact ellipse at {torque} N·m is {overhang:.1} times as long as the teeth have room for: approach and pressure are those of a whole ellipse"
            ),
            format!(
                "give a smaller torque, or less crowning: strips resolve ellipses from a/b {LEAST_ASPECT}"
            ),
        );
    }
    let cells = cycles.iter().filter_map(|cycle| {
        let least = cycle
            .positions
            .iter()
            .filter_map(|p| p.longest_contact())
            .min()?;
        Some((least, format_number(cycle.torque)))
    });
    let least = cells.min_by_key(|(cells, _)| *cells);
    if let Some((cells, torque)) = least.filter(|(cells, _)| *cells < LEAST_CELLS) {
        let enough = (stations * LEAST_CELLS).div_ceil(cells.max(1));
        let enough = enough.min(MAX_STATIONS as usize);
        warn(
            "short-contact",
            format!(
                "at some position no contact at {torque} N·m covers more than {} (limit {LEAST_CELLS}): approach and pressure are off by more than 2 %",
                pluralise(cells, "station")
            ),
            format!(
                "give about {enough} `stations` in [mesh], there are {stations}; or a larger torque"
            ),
        );
    }
    all
}
