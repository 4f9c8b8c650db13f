//! Non-circular gear pair: centrodes, conjugate flanks with their limits, law of gearing, outlines.

use std::f64::consts::{PI, TAU};

use super::geometry::{GearQuantity, Quantities, QuantityUnit};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::gear::plane::centrodes::{Centrodes, Member};
use crate::gear::plane::conjugate::conjugate;
use crate::gear::plane::conjugate_flank::{ConjugateFlank, ConjugateRoute, FLANK_POINTS};
use crate::gear::plane::convexity::CurvatureExtremes;
use crate::gear::plane::given_profiles::{self, GivenContact};
use crate::gear::plane::limits::{LimitKind, LimitPoint};
use crate::gear::plane::profile::Shape;
use crate::gear::plane::rack_cut::{Outline, cut_pair};
use crate::gear::plane::rack_cutter::RackCutter;
use crate::gear::plane::rack_flank::rack_flank;
use crate::gear::plane::rack_remedy::RackRemedy;
use crate::gear::plane::rolling::{Centrode, Rolling};
use crate::numeric::statistics::extremes;
use crate::plan::decision::StageDecision;
use crate::scene::non_circular_file::{GearProfile, MAX_CUT_TEETH, NonCircularFile, PinionProfile};

/// Centrodes, flank and outlines of a non-circular gear pair.
#[derive(Debug, Clone)]
pub struct NonCircularResult {
    /// Centrodes of pinion and gear.
    pub centrodes: Centrodes,
    /// Quantities of the data sheet.
    pub quantities: Vec<GearQuantity>,
    /// Curvature extremes of both centrodes.
    pub curvatures: [CurvatureExtremes; 2],
    /// Angles of gear 1 over a period or the range, rad.
    pub angles: Vec<f64>,
    /// The flank in contact nearest to φ₁ = 0; `None` for a rack without tooth numbers and for a given pair.
    pub flank: Option<ConjugateFlank>,
    /// Contacts of two given profiles; empty if the gear profile is the conjugate.
    pub given: Vec<GivenContact>,
    /// Outlines of pinion and gear at φ₁ = 0, the gear outline in the frame of the gear; empty without tooth numbers.
    pub outlines: Vec<Outline>,
    /// Stages that run, and omitted stages with the reason.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Computes centrodes, flank, contacts and outlines of the pair of a file.
///
/// # Errors
/// The ratio law has no centrodes, the profile has no conjugate, or the rack cannot cut the gears.
pub fn run(file: &NonCircularFile) -> Result<NonCircularResult, Error> {
    let at = |error: Error| match error.span {
        Some(_) => error,
        None => error.with_span(&file.span),
    };
    let centrodes = Centrodes::of_gears(&file.law, file.centre_distance, file.mate).map_err(at)?;
    let curvatures = [Member::First, Member::Second].map(|m| centrodes.curvature_extremes(m));
    let at_profile = |error: Error| match error.span {
        Some(_) => error,
        None => error.with_span(&file.profile_span),
    };
    if file.teeth.is_some() && matches!(file.profile, PinionProfile::Rack(_)) {
        let closed = centrodes.closed_arc(Member::First);
        closed.map_err(|error| error.with_span(&file.ratio_span))?;
    }
    let flank = flank(file, &centrodes).map_err(at_profile)?;
    let outlines = match (file.teeth, &file.profile) {
        (Some(teeth), PinionProfile::Rack(cutter)) => {
            let cut_outlines = cut_pair(&centrodes, teeth, cutter);
            let cut_outlines = cut_outlines.map_err(|error| match error.code {
                Code::Conflict => at(error),
                _ => at_profile(error),
            });
            cut_outlines?.to_vec()
        }
        _ => Vec::new(),
    };
    let given = match (&file.profile, &file.gear_profile) {
        (PinionProfile::Curve(pinion), GearProfile::Given(gear)) => {
            given_profiles::contacts(&centrodes, pinion, gear).map_err(at_profile)?
        }
        _ => Vec::new(),
    };
    let limits = flank.iter().flat_map(|flank| &flank.limits);
    let mut diagnostics: Vec<Diagnostic> = limits.map(limit_warning).collect();
    diagnostics.extend(flank.iter().flat_map(flank_warnings));
    diagnostics.extend(outlines.iter().zip(["pinion", "gear"]).filter_map(undercut));
    diagnostics.extend(given_warning(&given));
    if let PinionProfile::Rack(cutter) = &file.profile {
        let is_limit = |d: &Diagnostic| matches!(d.code, "undercut" | "contact-ends" | "folded");
        if diagnostics.iter().any(is_limit) {
            let hint = rack_hint(file, &centrodes, cutter);
            let cut_warnings = diagnostics.iter_mut().filter(|d| is_limit(d));
            cut_warnings.for_each(|diagnostic| diagnostic.hint = Some(hint.clone()));
        }
    }
    Ok(NonCircularResult {
        quantities: quantities(file, &centrodes, flank.as_ref()),
        curvatures,
        angles: centrodes.angles().collect(),
        flank,
        given,
        outlines,
        plan: plan(file),
        centrodes,
        diagnostics,
    })
}

/// Pinion flank nearest to φ₁ = 0 and its conjugate.
fn flank(file: &NonCircularFile, pair: &Centrodes) -> Result<Option<ConjugateFlank>, Error> {
    let generated_by = |tool: Centrode, shape: Shape| {
        let work = Centrode::Member {
            pair: pair.clone(),
            member: Member::First,
        };
        conjugate(&Rolling { tool, work }, shape, FLANK_POINTS)
    };
    let GearProfile::Conjugate(route) = file.gear_profile else {
        return Ok(None);
    };
    let flank = match &file.profile {
        PinionProfile::Curve(shape) => ConjugateFlank::of(pair, shape.clone(), route),
        PinionProfile::Rack(cutter) => {
            let Some([teeth, _]) = file.teeth else {
                return Ok(None);
            };
            let module = pair.closed_arc(Member::First)? / (PI * f64::from(teeth));
            let flank = rack_flank(pair, cutter, module)?;
            ConjugateFlank::of(pair, generated_by(Centrode::Line, flank)?, route)
        }
        PinionProfile::Rolling { radius, curve } => {
            let circle = Centrode::circle(-radius)?;
            ConjugateFlank::of(pair, generated_by(circle, curve.clone())?, route)
        }
    };
    flank.map(Some)
}

/// Error against the ratio law above which a warning is issued, rad: 0.01 arcsec.
const LARGEST_LAW_ERROR: f64 = 5e-8;

/// Warnings for cusps of the flanks and for violations of the law of gearing.
fn flank_warnings(flank: &ConjugateFlank) -> Vec<Diagnostic> {
    let cusps = ["pinion", "gear"].into_iter().zip(flank.cusps);
    let cusp_warnings = cusps.filter_map(|(name, cusp)| {
        let radius = 1e3 * cusp?.norm();
        Some(Diagnostic {
            code: "folded",
            message: format!("the {name}'s flank folds back at the radius {radius:.4} mm, which is impossible for a tooth"),
            hint: Some("end the pinion's flank before that place".into()),
        })
    });
    let error = flank.law_error().unwrap_or(0.0);
    let law_warning = (error > LARGEST_LAW_ERROR).then(|| Diagnostic {
        code: "law-of-gearing",
        message: format!(
            "the flanks break the law of gearing: the gear is off by up to {:.3} arcsec",
            error.to_degrees() * 3600.0
        ),
        hint: Some("shorten the pinion's flank, or give more points of it".into()),
    });
    cusp_warnings.chain(law_warning).collect()
}

/// Warning for given flanks that violate the ratio law, apart from a constant offset of the gear angle.
fn given_warning(given: &[GivenContact]) -> Option<Diagnostic> {
    let errors = given.iter().map(|contact| contact.check.error);
    let (low, high) = extremes(errors);
    let pitch_point_deviation = given
        .iter()
        .map(|contact| contact.check.pitch_point_deviation.abs());
    let pitch_point_deviation = pitch_point_deviation.fold(0.0, f64::max);
    let arcsec = |angle: f64| angle.to_degrees() * 3600.0;
    (high - low > LARGEST_LAW_ERROR).then(|| Diagnostic {
        code: "law-of-gearing",
        message: format!(
            "the given flanks break the law of gearing: the gear is off by {:.3} to {:.3} arcsec, and the common normal misses the pitch point by up to {:.4} mm",
            arcsec(low),
            arcsec(high),
            1e3 * pitch_point_deviation
        ),
        hint: Some("omit `gear.profile` for the flank that satisfies the law".into()),
    })
}

/// Hint with the tooth numbers and the dedendum that avoid undercut by the rack.
fn rack_hint(file: &NonCircularFile, pair: &Centrodes, cutter: &RackCutter) -> String {
    let remedy = file
        .teeth
        .and_then(|teeth| RackRemedy::of(pair, teeth, cutter, MAX_CUT_TEETH));
    let teeth = remedy.and_then(|r| {
        let [n, of_gear] = r.teeth?;
        Some(format!("teeth = {n} (pinion) and {of_gear} (gear)"))
    });
    let dedendum = remedy.and_then(|r| Some(format!("rack = {{ dedendum = {} }}", r.dedendum?)));
    let hints: Vec<String> = teeth.into_iter().chain(dedendum).collect();
    match hints.is_empty() {
        true => "use more teeth, a larger pressure angle or a smaller dedendum".into(),
        false => format!("{} avoids it", hints.join(", or ")),
    }
}

/// Warning for a limit point of the flank.
fn limit_warning(point: &LimitPoint) -> Diagnostic {
    let radius = 1e3 * point.work_point.norm();
    let on_tool = 1e3 * point.tool_point.norm();
    let (code, message) = match point.kind {
        LimitKind::Undercut => (
            "undercut",
            format!(
                "the pinion's flank undercuts the gear beyond the radius {radius:.4} mm of the gear"
            ),
        ),
        LimitKind::EndOfContact => (
            "contact-ends",
            format!("the pinion's flank has no contact beyond its radius {on_tool:.4} mm"),
        ),
    };
    Diagnostic {
        code,
        message,
        hint: Some(format!(
            "end the pinion's flank at the radius {on_tool:.4} mm"
        )),
    }
}

/// Warning for tooth spaces in which the rack tip undercuts a flank.
fn undercut((outline, name): (&Outline, &str)) -> Option<Diagnostic> {
    let spaces = &outline.undercut_spaces;
    (!spaces.is_empty()).then(|| Diagnostic {
        code: "undercut",
        message: format!(
            "{} tooth spaces of the {name} are undercut by the rack",
            spaces.len()
        ),
        hint: Some("use more teeth, a larger pressure angle or a smaller dedendum".into()),
    })
}

fn quantities(
    file: &NonCircularFile,
    pair: &Centrodes,
    flank: Option<&ConjugateFlank>,
) -> Vec<GearQuantity> {
    use QuantityUnit::{Degree, Millimetre, One};
    let mut list = Quantities::default();
    let ratios = pair.extremes(|x| file.law.at(x).map(|s| s.ratio));
    list.pair("centre distance", "a", Millimetre, file.centre_distance);
    list.pair("least ratio", "i_12", One, ratios[0]);
    list.pair("largest ratio", "i_12", One, ratios[1]);
    let radius = |k: usize| {
        pair.extremes(|x| {
            let radius = pair.at(x)?.radius_1;
            Some([radius, radius * file.law.at(x)?.ratio][k])
        })
    };
    let radii = [radius(0), radius(1)];
    list.each(
        "least centrode radius",
        "r",
        Millimetre,
        radii.map(|r| r[0]),
    );
    list.each(
        "largest centrode radius",
        "r",
        Millimetre,
        radii.map(|r| r[1]),
    );
    let arc = |m| pair.closed_arc(m).unwrap_or(f64::NAN);
    let arcs = [arc(Member::First), arc(Member::Second)];
    match arcs.iter().all(|s| s.is_finite()) {
        true => list.each("arc of the centrode", "S", Millimetre, arcs),
        false => list.pair("rolled arc", "s", Millimetre, pair.arc_of_period()),
    }
    if let Some(teeth) = file.teeth {
        list.each("number of teeth", "z", One, teeth.map(f64::from));
        if arcs[0].is_finite() {
            let pitch = arcs[0] / f64::from(teeth[0]);
            list.pair("module", "m", Millimetre, pitch / PI);
            let ends = flank.and_then(|f| f.contacts.first().zip(f.contacts.last()));
            if let Some((a, b)) = ends {
                let ratio = (b.arc - a.arc).abs() / pitch;
                list.pair("contact ratio of the flank", "ε_α", One, ratio);
            }
        }
    }
    if let Some(state) = file.law.at(TAU) {
        let name = "turn of the gear in one of the pinion";
        list.pair(name, "φ_2", Degree, state.angle_2);
    }
    list.0
}

/// Stages that run, and omitted stages with the reason.
pub fn plan(file: &NonCircularFile) -> Vec<(&'static str, StageDecision)> {
    use StageDecision::{LeftOut, Runs};
    let is_rack = matches!(file.profile, PinionProfile::Rack(_));
    let flanks = match &file.gear_profile {
        GearProfile::Given(_) => "both flanks as given".into(),
        GearProfile::Conjugate(route) => {
            let route = match route {
                ConjugateRoute::Normals => "normals through the pitch point",
                ConjugateRoute::Envelope => "the equation of meshing",
                ConjugateRoute::LineOfAction => "the path of contact",
            };
            format!("one flank of the pinion and its conjugate by {route}")
        }
    };
    let is_given = matches!(file.gear_profile, GearProfile::Given(_));
    let flank_stage = |name: &'static str, text: String| match is_rack && file.teeth.is_none() {
        true => (
            name,
            LeftOut("a rack needs teeth of pinion and gear".into()),
        ),
        false => (name, Runs(text)),
    };
    vec![
        ("geometry", Runs("ratio law at the centre distance".into())),
        flank_stage("flanks", flanks),
        match is_given {
            true => (
                "limits",
                LeftOut("they need a flank with its conjugate".into()),
            ),
            false => flank_stage("limits", "undercut and end of contact of the flank".into()),
        },
        flank_stage("contact", "law of gearing along the flank".into()),
        match is_given {
            true => (
                "second contact",
                LeftOut("it needs a flank with its conjugate".into()),
            ),
            false => flank_stage(
                "second contact",
                "places where the gear's flank touches the body of the pinion again".into(),
            ),
        },
        (
            "outlines",
            match (is_rack, file.teeth.is_some()) {
                (true, true) => Runs("teeth at equal arcs, cut by the rack".into()),
                (false, _) => LeftOut("outlines are cut by a rack only".into()),
                (_, false) => LeftOut("teeth of pinion and gear are not given".into()),
            },
        ),
        (
            "mesh",
            LeftOut("loads are shared between cylindrical gears only".into()),
        ),
    ]
}
