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
use crate::gear::load::relief::{OptimalRelief, optimal_tip_relief};
use crate::plan::decision::StageDecision;
use crate::plan::gear_limits as limits;
use crate::scene::gear_file::GearFile;

/// Results of a gear file.
#[derive(Debug, Clone)]
pub struct GearResult {
    /// Pair of gears.
    pub pair: Pair,
    /// Geometry of the pair.
    pub quantities: Vec<GearQuantity>,
    /// Limits that the pair exceeds, with remedies.
    pub limits: Vec<Warning>,
    /// Inspection dimensions of pinion and gear for the drawing.
    pub drawing: [Vec<DrawingReading>; 2],
    /// Backlash without deviations and at their limits; `None` if the base circles admit no line of action.
    pub backlash: Option<BacklashLimits>,
    /// Points A–E of the path of contact with the pinion driving, by letter.
    pub path: Vec<(&'static str, PathPoint)>,
    /// Stiffness by both methods; empty if no torque is given.
    pub stiffness: Vec<StiffnessRow>,
    /// Loaded mesh with its transmission error, if a torque is given.
    pub mesh: Option<MeshResult>,
    /// Tip relief of least peak-to-peak transmission error over the torques, on request.
    pub least_relief: Option<OptimalRelief>,
    /// Stages with their decisions.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Computes geometry, backlash, path of contact and loaded mesh of a gear file.
///
/// # Errors
/// Gears that cannot be manufactured or cannot mesh; a torque without a solution.
pub fn run(file: &GearFile) -> Result<GearResult, Error> {
    let locate = |error: Error| file.locate(error);
    let pair = file.pair()?;
    check_modifications(&pair, &file.modifications).map_err(locate)?;
    for (k, member) in pair.members.iter().enumerate() {
        let ball_check = check_ball(member, file.ball_diameters[k]);
        ball_check.map_err(|error| locate(error.with_part(MEMBERS[k])))?;
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
        let loaded = load(file, &pair).map_err(locate)?;
        (stiffness, mesh) = (loaded.0, Some(loaded.1));
        if file.mesh.least_relief {
            let options = file.mesh_options(&pair);
            let least = optimal_tip_relief(&pair, &options, [first, last]);
            least_relief = Some(least.map_err(locate)?);
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

/// Maximum change of the centre distance in the search for backlash, in modules.
const MAX_CHANGE: f64 = 3.0;

/// Negative backlash that counts as rounding of the data, m.
const ROUNDING: f64 = 1e-6;

/// Error of teeth that do not reach each other, with the nearest value at which they do.
fn no_contact(file: &GearFile, pair: &Pair) -> Error {
    let message = format!(
        "the teeth do not touch: transverse contact ratio {:.4}",
        pair.contact_ratios().transverse
    );
    let error = Error::new(Code::OutOfRange, message).with_span(&file.span);
    let length = |offset: f64| {
        let shifted = GearFile {
            offset,
            ..file.clone()
        };
        Some(shifted.pair().ok()?.path_length())
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
        None => error.with_hint(match standard_heights(file) {
            Some(hint) => hint,
            None => "give a smaller centre_distance or larger tip diameters".into(),
        }),
    }
}

/// Remedy by raising rack heights to those of profile A; `None` if the teeth still do not reach each other.
fn standard_heights(file: &GearFile) -> Option<String> {
    let (standard, mut raised) = (BasicRack::PROFILE_A, file.clone());
    for member in &mut raised.members {
        member.rack.addendum = member.rack.addendum.max(standard.addendum);
        member.rack.dedendum = member.rack.dedendum.max(standard.dedendum);
    }
    let rack = raised.members[0].rack;
    (raised.pair().ok()?.path_length() > 0.0).then(|| {
        format!(
            "give rack = {{ addendum = {}, dedendum = {} }}",
            rack.addendum, rack.dedendum
        )
    })
}

/// Warning of negative backlash, with the centre distance at which it is zero.
fn overlap(file: &GearFile, pair: &Pair, limits: &BacklashLimits) -> Option<Diagnostic> {
    let least = limits.least.circumferential;
    let backlash_at = |distance: f64| {
        let shifted = Pair {
            centre_distance: distance,
            working_pressure_angle: (pair.centre_distance * pair.working_pressure_angle.cos()
                / distance)
                .acos(),
            ..pair.clone()
        };
        let limits = shifted.backlash_limits(file.centre_deviation)?;
        Some(limits.least.circumferential)
    };
    let (a, module) = (pair.centre_distance, pair.members[0].gear.module);
    let (range, bound): (_, fn(f64) -> Bound) = match pair.members[1].gear.internal {
        false => ([a, a + MAX_CHANGE * module], Bound::AtLeast),
        true => ([a - MAX_CHANGE * module, a], Bound::AtMost),
    };
    let distance = sign_change(range, |a| Some(backlash_at(a).unwrap_or(-1.0)));
    let hint = match distance {
        Some(distance) => format!(
            "pair.centre_distance = \"{} mm\" avoids it",
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

/// Mesh stiffness by both methods, and the mesh at each torque by the requested method.
fn load(file: &GearFile, pair: &Pair) -> Result<(Vec<StiffnessRow>, MeshResult), Error> {
    let study = &file.mesh;
    let materials = [Material::default(); 2];
    let other = match study.method {
        StiffnessMethod::Energy { .. } => StiffnessMethod::Iso6336 { webs: [None; 2] },
        StiffnessMethod::Iso6336 { .. } => StiffnessMethod::default(),
    };
    let mut stiffness = compare_methods(pair, &[study.method, other], &materials)?;
    let mesh = LoadedMesh::new(pair, file.mesh_options(pair))?;
    let outside = mesh.below_iso_load(&study.torques);
    for row in stiffness.iter_mut().filter(|row| row.method == "iso-6336") {
        row.outside_range.extend(outside.clone());
    }
    let mesh = mesh.map(&study.torques)?;
    Ok((stiffness, mesh))
}

/// Stages of a gear file, and those left out with the reason.
pub fn plan(file: &GearFile) -> Vec<(&'static str, StageDecision)> {
    let runs = |text: String| StageDecision::Runs(text);
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
                true => "involutes with fillets cut by the rack".into(),
                false => "involutes with fillets cut by the rack; modifications are included in the mesh, but not in outlines and pictures".into(),
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
        let decision = match study.torques[..] {
            [] => StageDecision::LeftOut("no torque is given".into()),
            _ => runs("tip relief of least peak-to-peak over the torques".into()),
        };
        plan.push(("least relief", decision));
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
