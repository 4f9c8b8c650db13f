//! A pair of varying ratio: centrodes, conjugate flanks with their limits, law of gearing, outlines.

use std::f64::consts::{PI, TAU};

use super::geometry::{GearQuantity, Quantities, QuantityUnit};
use super::given_profiles::{self, FLANK_POINTS, GivenContact};
use crate::base::bound::Bound;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::gear::plane::centrodes::{Centrodes, Member};
use crate::gear::plane::conjugate::{ConjugateProfile, conjugate};
use crate::gear::plane::contact::Contact;
use crate::gear::plane::convexity::CurvatureExtremes;
use crate::gear::plane::envelope::envelope;
use crate::gear::plane::law_of_gearing::{GearingCheck, check_gearing};
use crate::gear::plane::limits::{LimitKind, LimitPoint, limits};
use crate::gear::plane::line_of_action::LineOfAction;
use crate::gear::plane::profile::{Profile, Shape};
use crate::gear::plane::rack_cut::{Outline, cut_outline};
use crate::gear::plane::rack_cutter::RackCutter;
use crate::gear::plane::rack_flank::rack_flank;
use crate::gear::plane::rolling::{Centrode, Rolling};
use crate::gear::plane::second_contact::{SecondContact, second_contacts};
use crate::numeric::Complex;
use crate::plan::decision::StageDecision;
use crate::scene::non_circular_file::{
    ConjugateRoute, GearProfile, MAX_CUT_TEETH, NonCircularFile, PinionProfile,
};

/// Contacts at either end of a flank that the law of gearing is not checked at: there the search for contact may leave the flank.
const END_CONTACTS: usize = 2;
/// Steps of each part of an outline: chords lie within 1e-4 modules of the curves of the shipped pair, 16 steps leave 2.6e-4.
const OUTLINE_STEPS: usize = 32;
/// Positions of the table of centrodes over a period.
const POSITIONS: usize = 360;
/// Distance from the pitch point, relative to the longest of the path, below which a point has no direction for a line of action.
const NEAR_PITCH_POINT: f64 = 1e-6;
/// Share of a flank's length by which the range of the envelope exceeds that of the contacts.
const REACH: f64 = 0.05;

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

/// A flank of the pinion with its conjugate on the gear.
#[derive(Debug, Clone)]
pub struct ConjugateFlank {
    /// Contacts in the order of the pinion's flank.
    pub contacts: Vec<Contact>,
    /// Angle of gear 1 at each, rad.
    pub angles: Vec<f64>,
    /// Points of the gear by the requested route, m.
    pub gear_points: Vec<Complex>,
    /// Largest distance of these from the points by normals, m.
    pub route_deviation: f64,
    /// Points at which the flanks of pinion and gear fold back.
    pub folds: [Option<Complex>; 2],
    /// Limits of the flank.
    pub limits: Vec<LimitPoint>,
    /// Both flanks compared with the ratio law.
    pub checks: Vec<GearingCheck>,
    /// Second contacts of the gear's flank with the body of the pinion; empty where there are none.
    pub second: Vec<SecondContact>,
}

impl ConjugateFlank {
    /// Largest error of the gear against the ratio law, rad; `None` for flanks that fold back, which are not checked.
    pub fn law_error(&self) -> Option<f64> {
        let errors = self.checks.iter().map(|check| check.error.abs());
        errors.reduce(f64::max)
    }

    /// Number of second contacts between the least and the greatest radius of the pinion's flank; the others lie on no tooth of it.
    pub fn second_on_flank(&self) -> usize {
        let radii = || self.contacts.iter().map(|c| c.tool_point.norm());
        let [low, high] = [
            radii().fold(f64::INFINITY, f64::min),
            radii().fold(0.0, f64::max),
        ];
        let is_on = |s: &&SecondContact| (low..=high).contains(&s.tool_point.norm());
        self.second.iter().filter(is_on).count()
    }
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
    let outlines = outlines(file, &centrodes).map_err(in_profile)?;
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
            let hint = rack_remedy(file, &centrodes, &curvatures, cutter);
            let cut = diagnostics.iter_mut().filter(|d| of_cut(d));
            cut.for_each(|diagnostic| diagnostic.hint = Some(hint.clone()));
        }
    }
    let [first, last] = centrodes.period();
    let angle = |i: usize| first + (last - first) * i as f64 / POSITIONS as f64;
    Ok(NonCircularResult {
        quantities: quantities(file, &centrodes, flank.as_ref()),
        curvatures,
        angles: (0..=POSITIONS).map(angle).collect(),
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
        PinionProfile::Curve(shape) => mate(pair, shape.clone(), route),
        PinionProfile::Rack(cutter) => {
            let Some([teeth, _]) = file.teeth else {
                return Ok(None);
            };
            let module = pair.closed_arc(Member::First)? / (PI * f64::from(teeth));
            let flank = rack_flank(pair, cutter, module)?;
            mate(pair, made_by(Centrode::Line, flank)?, route)
        }
        PinionProfile::Rolling { radius, curve } => {
            let circle = Centrode::circle(-radius)?;
            mate(pair, made_by(circle, curve.clone())?, route)
        }
    };
    flank.map(Some)
}

/// The conjugate of the pinion's profile on the gear.
fn mate<P: Profile + Clone>(
    pair: &Centrodes,
    pinion: P,
    route: ConjugateRoute,
) -> Result<ConjugateFlank, Error> {
    let rolling = Rolling::of_pair(pair);
    let generated = conjugate(&rolling, pinion, FLANK_POINTS)?;
    let contacts = generated.contacts().to_vec();
    let angles: Vec<f64> = (contacts.iter())
        .map(|c| pair.angle_at_arc(c.arc).unwrap_or(f64::NAN))
        .collect();
    let gear_points = match route {
        ConjugateRoute::Normals => contacts.iter().map(|c| c.work_point).collect(),
        ConjugateRoute::Envelope => by_envelope(&generated, &angles)?,
        ConjugateRoute::LineOfAction => by_line_of_action(&generated)?,
    };
    let apart = gear_points.iter().zip(&contacts);
    let route_deviation = apart
        .map(|(point, contact)| (point - contact.work_point).norm())
        .fold(0.0, f64::max);
    let inner = END_CONTACTS..contacts.len().saturating_sub(END_CONTACTS);
    let pinion_points: Vec<Complex> = contacts.iter().map(|c| c.tool_point).collect();
    let folds = [fold(&pinion_points), fold(&gear_points)];
    let checks = match angles.get(inner) {
        Some(angles) if folds == [None; 2] => {
            check_gearing(pair, generated.tool(), &generated, angles)?
        }
        _ => Vec::new(),
    };
    Ok(ConjugateFlank {
        folds,
        limits: limits(&generated).points,
        second: second_contacts(&generated).unwrap_or_default(),
        contacts,
        angles,
        gear_points,
        route_deviation,
        checks,
    })
}

/// Points of the gear where the equation of meshing holds, at the roots nearest to the angles of contact.
fn by_envelope<P: Profile + Clone>(
    generated: &ConjugateProfile<P>,
    angles: &[f64],
) -> Result<Vec<Complex>, Error> {
    let low = angles.iter().copied().fold(f64::INFINITY, f64::min);
    let high = angles.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let reach = REACH * (high - low);
    let tool = generated.tool().clone();
    let by_kernel = envelope(generated.rolling(), tool, [low - reach, high + reach])?;
    let point = |(contact, angle): (&Contact, &f64)| {
        let roots = by_kernel.motion_parameters([contact.parameter, 0.0]);
        let off = |root: &f64| (root - angle).abs();
        let root = roots.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)));
        let found = root.and_then(|root| by_kernel.point([contact.parameter, 0.0, root]));
        found.map_or(Complex::new(f64::NAN, f64::NAN), |found| {
            let [x, y] = found.profile().point;
            Complex::new(x, y)
        })
    };
    let points: Vec<Complex> = generated.contacts().iter().zip(angles).map(point).collect();
    match points.iter().all(|z| z.norm().is_finite()) {
        true => Ok(points),
        false => Err(no_route(
            "the equation of meshing has no root near a contact",
        )),
    }
}

/// Points of the gear integrated along the path of contact, from its first point.
fn by_line_of_action<P: Profile>(generated: &ConjugateProfile<P>) -> Result<Vec<Complex>, Error> {
    let contacts = generated.contacts();
    let path: Vec<Complex> = contacts.iter().map(|c| c.path_point).collect();
    let longest = path.iter().map(|z| z.norm()).fold(0.0, f64::max);
    if path.iter().any(|z| z.norm() <= NEAR_PITCH_POINT * longest) {
        return Err(no_route(
            "a point of the path of contact is the pitch point",
        ));
    }
    let line = LineOfAction::points(&path)?;
    let rows: Vec<f64> = (0..path.len()).map(|i| i as f64).collect();
    let on_line = line.contacts(generated.rolling(), &rows, contacts[0].arc)?;
    Ok(on_line.iter().map(|c| c.work_point).collect())
}

fn no_route(why: &str) -> Error {
    Error::new(Code::NoConvergence, why).with_hint("take by = \"normals\", or another route")
}

/// Outlines cut by a rack, where both tooth numbers are given.
fn outlines(file: &NonCircularFile, pair: &Centrodes) -> Result<Vec<Outline>, Error> {
    let (Some(teeth), PinionProfile::Rack(cutter)) = (file.teeth, &file.profile) else {
        return Ok(Vec::new());
    };
    let arcs = [
        pair.closed_arc(Member::First)?,
        pair.closed_arc(Member::Second)?,
    ];
    let [module, of_gear] = [0, 1].map(|k| arcs[k] / f64::from(teeth[k]));
    if (module / of_gear - 1.0).abs() > 1e-9 {
        let fitting = arcs[1] / module;
        let message = format!(
            "{} and {} teeth have different pitches on these centrodes",
            teeth[0], teeth[1]
        );
        let error = Error::new(Code::Conflict, message).with_span(&file.span);
        return Err(error.with_hint(format!("the gear takes {fitting:.4} teeth")));
    }
    let half = 0.5 * module;
    [(Member::First, 0.0), (Member::Second, half)]
        .into_iter()
        .zip(teeth)
        .map(|((member, start), z)| cut_outline(pair, member, z, cutter, OUTLINE_STEPS, start))
        .collect()
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
    let [low, high] = errors.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], e| {
        [low.min(e), high.max(e)]
    });
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

/// Most teeth added in search of a number without undercut.
const MOST_TEETH: u32 = 5;

/// Least tooth numbers and greatest dedendum with which the rack undercuts no space, each proved by cutting both gears.
///
/// A rack undercuts where its straight flank reaches below `ρ sin² α`, ρ the least radius of curvature of the centrode.
fn rack_remedy(
    file: &NonCircularFile,
    pair: &Centrodes,
    curvatures: &[CurvatureExtremes; 2],
    cutter: &RackCutter,
) -> String {
    let is_free = |file: &NonCircularFile| {
        outlines(file, pair).is_ok_and(|both| {
            !both.is_empty()
                && both
                    .iter()
                    .all(|outline| outline.undercut_spaces.is_empty())
        })
    };
    let found = || {
        let [z1, z2] = file.teeth?;
        let module = pair.closed_arc(Member::First).ok()? / (PI * f64::from(z1));
        let sharpest = curvatures[0].largest[0].max(curvatures[1].largest[0]);
        let sine = cutter.pressure_angle.sin();
        let reach = sine * sine / (sharpest * module);
        let rounding = cutter.tip_radius * (1.0 - sine);
        let least = (f64::from(z1) * (cutter.dedendum - rounding) / reach).ceil();
        let whole = |n: &u32| (u64::from(*n) * u64::from(z2)).is_multiple_of(u64::from(z1));
        let first = (least as u32).max(z1 + 1);
        let with_teeth = |n: u32| NonCircularFile {
            teeth: Some([n, (u64::from(n) * u64::from(z2) / u64::from(z1)) as u32]),
            ..file.clone()
        };
        let mut numbers = (first..).filter(whole).take(MOST_TEETH as usize);
        let teeth = numbers.find(|n| *n <= MAX_CUT_TEETH && is_free(&with_teeth(*n)));
        let dedendum = Bound::AtMost(reach + rounding).text(3);
        let shallow = dedendum.parse().ok().filter(|d| *d > cutter.addendum);
        let shallow = shallow.filter(|dedendum| {
            is_free(&NonCircularFile {
                profile: PinionProfile::Rack(RackCutter {
                    dedendum: *dedendum,
                    ..*cutter
                }),
                ..file.clone()
            })
        });
        let more = teeth.map(|n| {
            let [_, of_gear] = with_teeth(n).teeth.unwrap_or([n, n]);
            format!("teeth = {n} (pinion) and {of_gear} (gear)")
        });
        let less = shallow.map(|dedendum| format!("rack = {{ dedendum = {dedendum} }}"));
        let all: Vec<String> = more.into_iter().chain(less).collect();
        (!all.is_empty()).then(|| format!("{} avoids it", all.join(", or ")))
    };
    found()
        .unwrap_or_else(|| "take more teeth, a larger pressure angle or a smaller dedendum".into())
}

/// First point at which the chords of a curve turn by more than a right angle.
fn fold(points: &[Complex]) -> Option<Complex> {
    let turns_back = |p: &&[Complex]| ((p[1] - p[0]).conj() * (p[2] - p[1])).re < 0.0;
    points.windows(3).find(turns_back).map(|p| p[1])
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

/// Largest and least of a value over a period.
fn extremes(pair: &Centrodes, value: impl Fn(f64) -> Option<f64>) -> [f64; 2] {
    let [first, last] = pair.period();
    let at = |i: usize| first + (last - first) * i as f64 / POSITIONS as f64;
    let values = (0..=POSITIONS).filter_map(|i| value(at(i)));
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| {
        [low.min(x), high.max(x)]
    })
}

fn quantities(
    file: &NonCircularFile,
    pair: &Centrodes,
    flank: Option<&ConjugateFlank>,
) -> Vec<GearQuantity> {
    use QuantityUnit::{Degree, Millimetre, One};
    let mut all = Quantities::default();
    let ratios = extremes(pair, |x| file.law.at(x).map(|s| s.ratio));
    all.pair("centre distance", "a", Millimetre, file.centre_distance);
    all.pair("least ratio", "i_12", One, ratios[0]);
    all.pair("largest ratio", "i_12", One, ratios[1]);
    let radius = |k: usize| {
        extremes(pair, |x| {
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
