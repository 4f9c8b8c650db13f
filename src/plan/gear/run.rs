//! Stages of a gear file: geometry, path of contact, stiffness, mesh under load.

use super::drawing::{DrawingReading, check_ball, readings};
use super::geometry::{GearQuantity, quantities};
use crate::base::bound::Bound;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::gear::cylindrical::backlash::BacklashLimits;
use crate::gear::cylindrical::basic_rack::BasicRack;
use crate::gear::cylindrical::member::MEMBERS;
use crate::gear::cylindrical::modification::FlankModification;
use crate::gear::cylindrical::pair::Pair;
use crate::gear::cylindrical::path_points::PathPoint;
use crate::gear::cylindrical::warnings::{Warning, WarningKind};
use crate::gear::kernel::root::sign_change;
use crate::gear::load::compliance::{StiffnessMethod, StiffnessRow, compare_methods};
use crate::gear::load::material::Material;
use crate::gear::load::mesh::{LoadedMesh, check_modifications};
use crate::gear::load::mesh_result::MeshResult;
use crate::gear::load::relief::{LeastRelief, least_peak_to_peak};
use crate::plan::decision::StageDecision;
use crate::plan::gear_limits as limits;
use crate::scene::gear_file::GearFile;

/// Results of a gear file.
#[derive(Debug, Clone)]
pub struct GearResult {
    /// The pair.
    pub pair: Pair,
    /// Geometry of the pair.
    pub quantities: Vec<GearQuantity>,
    /// Limits that the pair meets, with what avoids them.
    pub limits: Vec<Warning>,
    /// Readings of the drawing of pinion and gear.
    pub drawing: [Vec<DrawingReading>; 2],
    /// Backlash without deviations and at their limits; `None` where the base circles do not reach each other.
    pub backlash: Option<BacklashLimits>,
    /// Points A–E of the path of contact, the pinion driving, with their letters.
    pub path: Vec<(&'static str, PathPoint)>,
    /// Stiffness by both methods side by side; empty where no load is requested.
    pub stiffness: Vec<StiffnessRow>,
    /// Loaded transmission error, where a torque is given.
    pub mesh: Option<MeshResult>,
    /// Tip relief of least peak-to-peak over the torques, where it is requested.
    pub least_relief: Option<LeastRelief>,
    /// Stages with what they do.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Computes what a gear file determines.
///
/// # Errors
/// Gears that cannot be made or cannot mesh; a load that cannot be carried.
pub fn run(file: &GearFile) -> Result<GearResult, Error> {
    let at = |error: Error| file.locate(error);
    let pair = file.pair()?;
    check_modifications(&pair, &file.modifications).map_err(at)?;
    for (k, member) in pair.members.iter().enumerate() {
        let checked = check_ball(member, file.ball_diameters[k]);
        checked.map_err(|error| at(error.in_part(MEMBERS[k])))?;
    }
    if !(pair.path_length() > 0.0) {
        return Err(no_contact(file, &pair));
    }
    let limits = file.design().warnings(&pair);
    let mut diagnostics: Vec<Diagnostic> = limits.iter().map(limits::diagnostic).collect();
    let backlash = pair.backlash_limits(file.centre_deviation);
    diagnostics.extend(
        backlash
            .as_ref()
            .and_then(|limits| overlap(file, &pair, limits)),
    );
    let path = pair.path_points().named();
    let (mut stiffness, mut mesh, mut least_relief) = (Vec::new(), None, None);
    if let [first, .., last] | [first @ last] = file.mesh.torques[..] {
        let loaded = load(file, &pair).map_err(at)?;
        (stiffness, mesh) = (loaded.0, Some(loaded.1));
        if file.mesh.least_relief {
            let options = file.mesh_options(&pair);
            let least = least_peak_to_peak(&pair, &options, [first, last]);
            least_relief = Some(least.map_err(at)?);
        }
    }
    diagnostics.extend(mesh.iter().flat_map(|mesh| mesh.warnings.iter().cloned()));
    Ok(GearResult {
        quantities: quantities(&pair),
        limits,
        drawing: [0, 1].map(|k| readings(&pair.members[k], file.ball_diameters[k])),
        backlash,
        plan: plan(file),
        pair,
        path,
        stiffness,
        mesh,
        least_relief,
        diagnostics,
    })
}

/// By how many modules the centre distance is moved at most in search of backlash.
const FARTHEST: f64 = 3.0;

/// Backlash below zero by less than this is rounding of the data, m.
const ROUNDING: f64 = 1e-6;

/// Gears whose teeth do not reach each other, with the nearest value that lets them.
fn no_contact(file: &GearFile, pair: &Pair) -> Error {
    let message = format!(
        "the teeth do not reach each other: transverse contact ratio {:.4}",
        pair.contact_ratios().transverse
    );
    let error = Error::new(Code::OutOfRange, message).with_span(&file.span);
    let length = |offset: f64| {
        let made = GearFile {
            offset,
            ..file.clone()
        };
        Some(made.pair().ok()?.path_length())
    };
    if let Some(offset) = sign_change([0.0, file.offset], length) {
        let bound = match offset > 0.0 {
            true => ("most", Bound::AtMost(1e3 * offset)),
            false => ("least", Bound::AtLeast(1e3 * offset)),
        };
        let (side, value) = (bound.0, bound.1.text(3));
        return error.with_hint(format!("give an offset of at {side} {value} mm"));
    }
    let design = file.design();
    let warnings = design.warnings(pair).into_iter();
    let short = warnings.filter(|w| w.kind == WarningKind::ContactRatio);
    let nearest = short.filter_map(|w| w.nearest).next();
    match nearest.or_else(|| design.without_warnings(pair)) {
        Some(nearest) => error.with_hint(limits::hint(nearest)),
        None => error.with_hint(match usual_heights(file) {
            Some(hint) => hint,
            None => "give a smaller centre_distance or larger tip diameters".into(),
        }),
    }
}

/// The heights of the rack, those below the usual ones raised to them, with which the teeth reach each other.
fn usual_heights(file: &GearFile) -> Option<String> {
    let (usual, mut raised) = (BasicRack::PROFILE_A, file.clone());
    for member in &mut raised.members {
        member.rack.addendum = member.rack.addendum.max(usual.addendum);
        member.rack.dedendum = member.rack.dedendum.max(usual.dedendum);
    }
    let rack = raised.members[0].rack;
    (raised.pair().ok()?.path_length() > 0.0).then(|| {
        format!(
            "give rack = {{ addendum = {}, dedendum = {} }}",
            rack.addendum, rack.dedendum
        )
    })
}

/// Teeth that would have to overlap, with the centre distance at which they do not.
fn overlap(file: &GearFile, pair: &Pair, limits: &BacklashLimits) -> Option<Diagnostic> {
    let least = limits.least.circumferential;
    let beyond = |distance: f64| {
        let moved = Pair {
            centre_distance: distance,
            working_pressure_angle: (pair.centre_distance * pair.working_pressure_angle.cos()
                / distance)
                .acos(),
            ..pair.clone()
        };
        let limits = moved.backlash_limits(file.centre_deviation)?;
        Some(limits.least.circumferential)
    };
    let (a, reach) = (pair.centre_distance, FARTHEST * pair.members[0].gear.module);
    let (range, bound): (_, fn(f64) -> Bound) = match pair.members[1].gear.internal {
        false => ([a, a + reach], Bound::AtLeast),
        true => ([a - reach, a], Bound::AtMost),
    };
    let distance = sign_change(range, |a| Some(beyond(a).unwrap_or(-1.0)));
    let hint = match distance {
        Some(distance) => format!(
            "pair.centre_distance = \"{} mm\" leaves none below zero",
            bound(1e3 * (distance - file.offset)).text(4)
        ),
        None => "give thickness = [\"lower\", \"upper\"] below zero".into(),
    };
    (least < -ROUNDING).then(|| Diagnostic {
        code: "no-backlash",
        message: format!(
            "the least backlash is {:.1} µm at the pitch circle: the teeth would overlap",
            1e6 * least
        ),
        hint: Some(hint),
    })
}

/// The stiffness by both methods, and the mesh at every torque by the requested one.
fn load(file: &GearFile, pair: &Pair) -> Result<(Vec<StiffnessRow>, MeshResult), Error> {
    let study = &file.mesh;
    let materials = [Material::default(); 2];
    let other = match study.method {
        StiffnessMethod::Energy { .. } => StiffnessMethod::Iso6336 { webs: [None; 2] },
        StiffnessMethod::Iso6336 { .. } => StiffnessMethod::default(),
    };
    let mut stiffness = compare_methods(pair, &[study.method, other], &materials)?;
    let mesh = LoadedMesh::new(pair, file.mesh_options(pair))?;
    let below = mesh.below_iso_load(&study.torques);
    for row in stiffness.iter_mut().filter(|row| row.method == "iso-6336") {
        row.outside_range.extend(below.clone());
    }
    let mesh = mesh.map(&study.torques)?;
    Ok((stiffness, mesh))
}

/// The stages that run, and those left out with the reason.
pub fn plan(file: &GearFile) -> Vec<(&'static str, StageDecision)> {
    let runs = |what: String| StageDecision::Runs(what);
    let mut plan = vec![(
        "geometry",
        runs("pair with parallel axes, ISO 21771".into()),
    )];
    if !file.defaults.is_empty() {
        plan.push(("defaults", runs(file.defaults.join("; "))));
    }
    plan.extend([
        (
            "flanks",
            runs(match file.modifications == [FlankModification::default(); 2] {
                true => "involutes with the fillets that the rack leaves".into(),
                false => "involutes with the fillets that the rack leaves; modifications count in the mesh, outlines and pictures of teeth are without them".into(),
            }),
        ),
        (
            "limits",
            runs("undercut, interference, pointed tips, clearance, contact ratio".into()),
        ),
        (
            "contact",
            runs(
                "points A to E of the path of contact (B and D with a contact ratio from 1 to 2), sliding, backlash"
                    .into(),
            ),
        ),
    ]);
    let study = &file.mesh;
    if study.least_relief {
        let range = match study.torques[..] {
            [] => StageDecision::LeftOut("no torque is given".into()),
            _ => runs("tip relief of least peak-to-peak over the torques".into()),
        };
        plan.push(("least relief", range));
    }
    plan.push(match study.torques.len() {
        0 => (
            "mesh",
            StageDecision::LeftOut("no torque is given: [mesh] torque, or --torque".into()),
        ),
        n => (
            "mesh",
            runs(format!(
                "{} × {} positions × {} slices; stiffness by {}, bodies: {}; steel of 206 GPa",
                pluralise(n, "torque"),
                study.positions,
                study.slices,
                study.method.name(),
                study.method.bodies().join(", ")
            )),
        ),
    });
    plan.push((
        "strength rating",
        StageDecision::LeftOut("geardyn rates no load capacity".into()),
    ));
    plan
}
