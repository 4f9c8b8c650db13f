//! A pair of varying ratio: centrodes, conjugate flanks with their limits, law of gearing, outlines.

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

/// Centrodes, flank and outlines of a pair of varying ratio.
#[derive(Debug, Clone)]
pub struct NonCircularResult {
    /// The centrodes.
    pub centrodes: Centrodes,
    /// Quantities of the pair.
    pub quantities: Vec<GearQuantity>,
    /// Extremes of the curvatures of both centrodes.
    pub curvatures: [CurvatureExtremes; 2],
    /// Angles of gear 1 over a period or the range, rad.
    pub angles: Vec<f64>,
    /// The flank in contact nearest to φ₁ = 0; `None` for a rack without tooth numbers and for a given pair.
    pub flank: Option<ConjugateFlank>,
    /// Contacts of a given pair of profiles; empty where the gear's is the conjugate.
    pub given: Vec<GivenContact>,
    /// Outlines of pinion and gear at φ₁ = 0, the gear's in its own frame; empty without tooth numbers.
    pub outlines: Vec<Outline>,
    /// Stages that run and that are left out.
    pub plan: Vec<(&'static str, StageDecision)>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Computes what the file determines.
///
/// # Errors
/// Laws without centrodes, profiles without a conjugate, gears that a rack cannot cut.
pub fn run(file: &NonCircularFile) -> Result<NonCircularResult, Error> {
    let at = |error: Error| match error.span {
        Some(_) => error,
        None => error.with_span(&file.span),
    };
    let centrodes = Centrodes::of_gears(&file.law, file.centre_distance, file.mate).map_err(at)?;
    let curvatures = [Member::First, Member::Second].map(|m| centrodes.curvature_extremes(m));
    let in_profile = |error: Error| match error.span {
        Some(_) => error,
        None => error.with_span(&file.profile_span),
    };
    if file.teeth.is_some() && matches!(file.profile, PinionProfile::Rack(_)) {
        let closed = centrodes.closed_arc(Member::First);
        closed.map_err(|error| error.with_span(&file.ratio_span))?;
    }
    let flank = flank(file, &centrodes).map_err(in_profile)?;
    let outlines = match (file.teeth, &file.profile) {
        (Some(teeth), PinionProfile::Rack(cutter)) => {
            let both = cut_pair(&centrodes, teeth, cutter);
            let both = both.map_err(|error| match error.code {
                Code::Conflict => at(error),
                _ => in_profile(error),
            });
            both?.to_vec()
        }
        _ => Vec::new(),
    };
    let given = match (&file.profile, &file.gear_profile) {
        (PinionProfile::Curve(pinion), GearProfile::Given(gear)) => {
            given_profiles::contacts(&centrodes, pinion, gear).map_err(in_profile)?
        }
        _ => Vec::new(),
    };
    let limits = flank.iter().flat_map(|flank| &flank.limits);
    let mut diagnostics: Vec<Diagnostic> = limits.map(limit).collect();
    diagnostics.extend(flank.iter().flat_map(flank_warnings));
    diagnostics.extend(outlines.iter().zip(["pinion", "gear"]).filter_map(undercut));
    diagnostics.extend(given_warning(&given));
    if let PinionProfile::Rack(cutter) = &file.profile {
        let of_cut = |d: &Diagnostic| matches!(d.code, "undercut" | "contact-ends" | "folded");
        if diagnostics.iter().any(of_cut) {
            let hint = rack_hint(file, &centrodes, cutter);
            let cut = diagnostics.iter_mut().filter(|d| of_cut(d));
            cut.for_each(|diagnostic| diagnostic.hint = Some(hint.clone()));
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

/// The pinion's flank nearest to φ₁ = 0 and its conjugate.
fn flank(file: &NonCircularFile, pair: &Centrodes) -> Result<Option<ConjugateFlank>, Error> {
    let made_by = |tool: Centrode, shape: Shape| {
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
            ConjugateFlank::of(pair, made_by(Centrode::Line, flank)?, route)
        }
        PinionProfile::Rolling { radius, curve } => {
            let circle = Centrode::circle(-radius)?;
            ConjugateFlank::of(pair, made_by(circle, curve.clone())?, route)
        }
    };
    flank.map(Some)
}

/// Error of a flank against the ratio law above which a warning says so, rad: a hundredth of a second of arc.
const LARGEST_LAW_ERROR: f64 = 5e-8;

/// Flanks that fold back on themselves, and flanks that break the law of gearing.
fn flank_warnings(flank: &ConjugateFlank) -> Vec<Diagnostic> {
    let folds = ["pinion", "gear"].into_iter().zip(flank.folds);
    let folded = folds.filter_map(|(name, place)| {
        let radius = 1e3 * place?.norm();
        Some(Diagnostic {
            code: "folded",
            message: format!("the {name}'s flank folds back at the radius {radius:.4} mm: no tooth has such a flank"),
            hint: Some("end the pinion's flank before that place".into()),
        })
    });
    let error = flank.law_error().unwrap_or(0.0);
    let breaks = (error > LARGEST_LAW_ERROR).then(|| Diagnostic {
        code: "law-of-gearing",
        message: format!(
            "the flanks break the law of gearing: the gear is off by up to {:.3} arcsec",
            error.to_degrees() * 3600.0
        ),
        hint: Some("shorten the pinion's flank, or give more points of it".into()),
    });
    folded.chain(breaks).collect()
}

/// Given flanks whose gear is not as far as the law puts it, a constant lead aside.
fn given_warning(given: &[GivenContact]) -> Option<Diagnostic> {
    let errors = given.iter().map(|contact| contact.check.error);
    let (low, high) = extremes(errors);
    let miss = given.iter().map(|contact| contact.check.miss.abs());
    let miss = miss.fold(0.0, f64::max);
    let arcsec = |angle: f64| angle.to_degrees() * 3600.0;
    (high - low > LARGEST_LAW_ERROR).then(|| Diagnostic {
        code: "law-of-gearing",
        message: format!(
            "the given flanks break the law of gearing: the gear is off by {:.3} to {:.3} arcsec, and the common normal misses the pitch point by up to {:.4} mm",
            arcsec(low),
            arcsec(high),
            1e3 * miss
        ),
        hint: Some("omit `gear.profile` for the flank that keeps the law".into()),
    })
}

/// Hint at the tooth numbers and the dedendum that avoid an undercut by the rack.
fn rack_hint(file: &NonCircularFile, pair: &Centrodes, cutter: &RackCutter) -> String {
    let remedy = file
        .teeth
        .and_then(|teeth| RackRemedy::of(pair, teeth, cutter, MAX_CUT_TEETH));
    let more = remedy.and_then(|r| {
        let [n, of_gear] = r.teeth?;
        Some(format!("teeth = {n} (pinion) and {of_gear} (gear)"))
    });
    let less = remedy.and_then(|r| Some(format!("rack = {{ dedendum = {} }}", r.dedendum?)));
    let all: Vec<String> = more.into_iter().chain(less).collect();
    match all.is_empty() {
        true => "take more teeth, a larger pressure angle or a smaller dedendum".into(),
        false => format!("{} avoids it", all.join(", or ")),
    }
}

/// A limit of the flank as a warning.
fn limit(point: &LimitPoint) -> Diagnostic {
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
            format!("the pinion's flank touches nothing beyond its radius {on_tool:.4} mm"),
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

/// Spaces in which the rack's tip cuts away a part of a flank.
fn undercut((outline, name): (&Outline, &str)) -> Option<Diagnostic> {
    let spaces = &outline.undercut_spaces;
    (!spaces.is_empty()).then(|| Diagnostic {
        code: "undercut",
        message: format!(
            "{} tooth spaces of the {name} are undercut by the rack",
            spaces.len()
        ),
        hint: Some("take more teeth, a larger pressure angle or a smaller dedendum".into()),
    })
}

fn quantities(
    file: &NonCircularFile,
    pair: &Centrodes,
    flank: Option<&ConjugateFlank>,
) -> Vec<GearQuantity> {
    use QuantityUnit::{Degree, Millimetre, One};
    let mut all = Quantities::default();
    let ratios = pair.extremes(|x| file.law.at(x).map(|s| s.ratio));
    all.pair("centre distance", "a", Millimetre, file.centre_distance);
    all.pair("least ratio", "i_12", One, ratios[0]);
    all.pair("largest ratio", "i_12", One, ratios[1]);
    let radius = |k: usize| {
        pair.extremes(|x| {
            let radius = pair.at(x)?.radius_1;
            Some([radius, radius * file.law.at(x)?.ratio][k])
        })
    };
    let radii = [radius(0), radius(1)];
    all.each(
        "least centrode radius",
        "r",
        Millimetre,
        radii.map(|r| r[0]),
    );
    all.each(
        "largest centrode radius",
        "r",
        Millimetre,
        radii.map(|r| r[1]),
    );
    let arc = |m| pair.closed_arc(m).unwrap_or(f64::NAN);
    let arcs = [arc(Member::First), arc(Member::Second)];
    match arcs.iter().all(|s| s.is_finite()) {
        true => all.each("arc of the centrode", "S", Millimetre, arcs),
        false => all.pair("rolled arc", "s", Millimetre, pair.arc_of_period()),
    }
    if let Some(teeth) = file.teeth {
        all.each("number of teeth", "z", One, teeth.map(f64::from));
        if arcs[0].is_finite() {
            let pitch = arcs[0] / f64::from(teeth[0]);
            all.pair("module", "m", Millimetre, pitch / PI);
            let ends = flank.and_then(|f| f.contacts.first().zip(f.contacts.last()));
            if let Some((a, b)) = ends {
                let ratio = (b.arc - a.arc).abs() / pitch;
                all.pair("contact ratio of the flank", "ε_α", One, ratio);
            }
        }
    }
    if let Some(state) = file.law.at(TAU) {
        let name = "turn of the gear in one of the pinion";
        all.pair(name, "φ_2", Degree, state.angle_2);
    }
    all.0
}

/// Stages that run, and those left out with the reason.
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
    let flank_stage = |name: &'static str, what: String| match is_rack && file.teeth.is_none() {
        true => (
            name,
            LeftOut("a rack needs teeth of pinion and gear".into()),
        ),
        false => (name, Runs(what)),
    };
    vec![
        ("geometry", Runs("ratio law at the centre distance".into())),
        flank_stage("flanks", flanks),
        match is_given {
            true => (
                "limits",
                LeftOut("they belong to a flank with its conjugate".into()),
            ),
            false => flank_stage("limits", "undercut and end of contact of the flank".into()),
        },
        flank_stage("contact", "law of gearing along the flank".into()),
        match is_given {
            true => (
                "second contact",
                LeftOut("it belongs to a flank with its conjugate".into()),
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
