//! Conjugate profiles by normals: z(u) touches at the arc s where its normal passes through the pitch point, `f = (z − c(s))·t = 0`.
//!
//! Willis' law of gearing; Euler–Savary in the form `1/m_w = 1/m_t − (κ_w − κ_t)/f_s`, m the distance of a centre of curvature from the
//! pitch point along the normal and `f_s = ∂f/∂s = −sin α`, α the angle of the normal and the common tangent (Litvin & Fuentes 2004, ch. 6).

use super::pitch_curve::out_of_range;
use super::profile::{Profile, ProfileJet};
use super::rolling::{Centrode, Rolling};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;

/// Parameters at which the first contact is sought.
const START_SAMPLES: usize = 33;
/// Arcs of a general centrode at which roots are bracketed.
const ARC_SAMPLES: usize = 720;
/// Range of arcs, relative to the length of the profile, below which all points touch at one instant: well above the error of splines.
const SAME_INSTANT: f64 = 1e-7;
/// Relative distance below which a point lies on the pitch curve: rounding.
const SAME_PLACE: f64 = 1e-13;

/// Contact of a tool's profile and the profile it generates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Contact {
    /// Parameter on the tool's profile.
    pub parameter: f64,
    /// Arc rolled, m.
    pub arc: f64,
    /// Contact point in the frame of the tool, m.
    pub tool_point: Complex,
    /// Contact point in the frame of the work, m.
    pub work_point: Complex,
    /// Contact point in the pitch frame (origin in the pitch point, x along the common tangent), m: a point of the line of action.
    pub path_point: Complex,
    /// Unit tangent of the generated profile in the frame of the work.
    pub work_tangent: Complex,
    /// Distance of the contact from the pitch point along the normal `i t`, signed, m.
    pub normal_distance: f64,
    /// `f_s`: −sin of the angle between normal and common tangent; 0 is a limit of the second kind.
    pub second_limit: f64,
    /// Speed of the contact on the tool's profile, m, times a common factor.
    pub tool_speed: f64,
    /// Speed of the contact on the generated profile, m, times the same factor; 0 is a limit of the first kind.
    pub work_speed: f64,
    /// Curvature of the tool's profile, 1/m, positive to the left of its tangent.
    pub tool_curvature: f64,
    /// Curvature of the generated profile, 1/m.
    pub work_curvature: f64,
    /// `∂f/∂u`, m.
    pub(super) slope: f64,
    /// Turn of the tangent of the generated profile, with the factor of the speeds.
    work_turn: f64,
}

impl Contact {
    /// The contact of a profile's point at an arc where f vanishes; `None` outside the range of the motion.
    pub(super) fn new(rolling: &Rolling, u: f64, jet: &ProfileJet, arc: f64) -> Option<Contact> {
        let state = rolling.at(arc)?;
        let path_point = state.to_pitch_frame(jet.point);
        let tangent = jet.tangent * state.tool.tangent.conj();
        let normal_distance = (path_point * tangent.conj()).im;
        let relative = state.relative_curvature();
        let slope = jet.speed + jet.turn * normal_distance;
        let second_limit = -tangent.re;
        // du : ds = f_s : −f_u keeps both profiles in contact.
        let tool_speed = jet.speed * second_limit;
        let work_speed = tool_speed + relative * normal_distance * slope;
        let work_turn = jet.turn * second_limit - relative * slope;
        Some(Contact {
            parameter: u,
            arc,
            tool_point: jet.point,
            work_point: state.to_work(jet.point),
            path_point,
            work_tangent: tangent * state.work.tangent,
            normal_distance,
            second_limit,
            tool_speed,
            work_speed,
            tool_curvature: jet.curvature(),
            work_curvature: work_turn / work_speed,
            slope,
            work_turn,
        })
    }

    /// Arc at a near parameter, to first order.
    fn arc_near(&self, u: f64) -> f64 {
        self.arc - (u - self.parameter) * self.slope / self.second_limit
    }

    /// Specific sliding ζ of tool and work: `1 − (speed of the other)/(own speed)`.
    pub fn specific_sliding(&self) -> [f64; 2] {
        [
            1.0 - self.work_speed / self.tool_speed,
            1.0 - self.tool_speed / self.work_speed,
        ]
    }

    /// Sliding velocity for each m rolled: tool against work along the tool's tangent.
    pub fn sliding(&self) -> f64 {
        (self.tool_speed - self.work_speed) / self.slope
    }
}

/// Profile generated on the work by a tool's profile.
#[derive(Debug, Clone)]
pub struct ConjugateProfile<P> {
    rolling: Rolling,
    tool: P,
    contacts: Vec<Contact>,
}

/// Generates the profile conjugate to a tool's profile, at `count` parameters at equal steps.
///
/// The contact nearest to the pitch point is found by a scan; its neighbours follow by continuation, until a point has no contact. A pin
/// centred on the pitch circle touches along its path; a flank of that shape, whose normals are steeper, at one instant only.
///
/// # Errors
/// `OutOfRange` where the profile touches at one instant only (Wildhaber–Novikov), or nowhere.
pub fn conjugate<P: Profile>(
    rolling: &Rolling,
    tool: P,
    count: usize,
) -> Result<ConjugateProfile<P>, Error> {
    let [low, high] = tool.range();
    let last = count.max(3) - 1;
    let parameter = |i: usize| match i == last {
        true => high,
        false => low + (high - low) * i as f64 / last as f64,
    };
    let grid = ArcGrid::new(&rolling.tool);
    let mut roots: Vec<Vec<f64>> = vec![];
    let mut nearest: Option<(usize, f64, f64)> = None;
    let mut length = 0.0;
    let mut before: Option<Complex> = None;
    for k in 0..START_SAMPLES.min(last + 1) {
        let i = (k * last).div_ceil(START_SAMPLES.min(last + 1) - 1);
        let Some(jet) = tool.jet(parameter(i)) else {
            continue;
        };
        length += before.map_or(0.0, |before| (jet.point - before).norm());
        before = Some(jet.point);
        let arcs = grid.contact_arcs(&rolling.tool, &jet);
        for arc in &arcs {
            let Some(state) = rolling.tool.at(*arc) else {
                continue;
            };
            let distance = (jet.point - state.point).norm();
            // A point on the pitch curve itself has every normal there; its path is the other root.
            if jet.speed == 0.0 && distance <= SAME_PLACE * jet.point.norm() {
                continue;
            }
            if nearest.is_none_or(|(_, _, least)| distance < least) {
                nearest = Some((i, *arc, distance));
            }
        }
        roots.push(arcs);
    }
    let Some((start, arc, _)) = nearest else {
        return Err(out_of_range(
            "no normal of the profile meets the pitch curve; the profile has no conjugate".into(),
        )
        .with_hint("move the profile nearer to the pitch curve"));
    };
    if touch_together(&roots, arc, SAME_INSTANT * length) {
        return Err(out_of_range(format!(
            "all points of the profile touch at one instant (arc {arc} m), since its centre of curvature lies on the pitch curve (Wildhaber–Novikov); the transverse contact ratio is 0"
        ))
        .with_hint("move the centre off the pitch curve, or make the gear helical"));
    }
    let follow = |rows: &mut dyn Iterator<Item = usize>| {
        let mut contacts: Vec<Contact> = vec![];
        for i in rows {
            let near = contacts.last().map_or(arc, |c| c.arc_near(parameter(i)));
            match contact_near(rolling, &tool, parameter(i), near) {
                Some(contact) => contacts.push(contact),
                None => break,
            }
        }
        contacts
    };
    let mut contacts = follow(&mut (0..=start).rev());
    contacts.reverse();
    contacts.extend(follow(&mut (start..=last)).into_iter().skip(1));
    if contacts.len() < 2 {
        return Err(Error::new(
            Code::NoConvergence,
            format!(
                "the contact of the profile at parameter {} cannot be continued",
                parameter(start)
            ),
        ));
    }
    Ok(ConjugateProfile {
        rolling: rolling.clone(),
        tool,
        contacts,
    })
}

impl<P: Profile> ConjugateProfile<P> {
    /// Contacts by rising parameter.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts
    }

    /// The motion that generates the profile.
    pub fn rolling(&self) -> &Rolling {
        &self.rolling
    }

    /// The tool's profile.
    pub fn tool(&self) -> &P {
        &self.tool
    }

    /// The contact at a parameter; `None` where the tool's point touches nothing.
    pub fn at(&self, u: f64) -> Option<Contact> {
        let i = self.contacts.partition_point(|c| c.parameter <= u);
        let before = &self.contacts[i.clamp(1, self.contacts.len()) - 1];
        let after = &self.contacts[i.min(self.contacts.len() - 1)];
        let near = match (u - before.parameter).abs() <= (after.parameter - u).abs() {
            true => before,
            false => after,
        };
        contact_near(&self.rolling, &self.tool, u, near.arc_near(u))
    }
}

impl<P: Profile> Profile for ConjugateProfile<P> {
    fn range(&self) -> [f64; 2] {
        let last = self.contacts.len() - 1;
        [self.contacts[0].parameter, self.contacts[last].parameter]
    }

    fn jet(&self, u: f64) -> Option<ProfileJet> {
        let [low, high] = self.range();
        if !(low..=high).contains(&u) {
            return None;
        }
        let contact = self.at(u)?;
        Some(ProfileJet {
            point: contact.work_point,
            tangent: contact.work_tangent,
            speed: contact.work_speed / contact.second_limit,
            turn: contact.work_turn / contact.second_limit,
        })
    }
}

/// The contact of the tool's point u at the root nearest to an arc.
fn contact_near(rolling: &Rolling, tool: &impl Profile, u: f64, arc: f64) -> Option<Contact> {
    let jet = tool.jet(u)?;
    let arc = nearest_arc(&rolling.tool, &jet, arc)?;
    let contact = Contact::new(rolling, u, &jet, arc)?;
    contact.work_point.norm().is_finite().then_some(contact)
}

/// Whether the roots of all parameters hold one arc.
fn touch_together(roots: &[Vec<f64>], arc: f64, tolerance: f64) -> bool {
    let touches = |arcs: &Vec<f64>| arcs.iter().any(|s| (s - arc).abs() <= tolerance);
    tolerance > 0.0 && roots.iter().all(touches)
}

/// `f` and `f_s` at an arc.
fn residual(centrode: &Centrode, jet: &ProfileJet, arc: f64) -> Option<[f64; 2]> {
    let state = centrode.at(arc)?;
    let dot = |a: Complex, b: Complex| (a * b.conj()).re;
    Some([
        dot(jet.point - state.point, jet.tangent),
        -dot(state.tangent, jet.tangent),
    ])
}

/// The arc nearest to a given one at which the normal of a profile's point passes through the pitch point.
fn nearest_arc(centrode: &Centrode, jet: &ProfileJet, near: f64) -> Option<f64> {
    match centrode {
        Centrode::Line => line_root(jet),
        Centrode::Circle { radius } => {
            let roots = circle_roots(*radius, jet)?;
            let turn = std::f64::consts::TAU * radius.abs();
            let [a, b] = roots.map(|s| s + ((near - s) / turn).round() * turn);
            Some(if (a - near).abs() <= (b - near).abs() {
                a
            } else {
                b
            })
        }
        Centrode::Member { .. } => newton(centrode, jet, near),
    }
}

/// The normal passes through (0, s): `s = z·t / t_y`.
fn line_root(jet: &ProfileJet) -> Option<f64> {
    let arc = (jet.point * jet.tangent.conj()).re / jet.tangent.im;
    arc.is_finite().then_some(arc)
}

/// `R cos(s/R − μ) = z·t`, μ the angle of the tangent.
fn circle_roots(radius: f64, jet: &ProfileJet) -> Option<[f64; 2]> {
    let along = (jet.point * jet.tangent.conj()).re;
    let across = (radius - along) * (radius + along);
    if !(across >= 0.0) {
        return None;
    }
    let (angle, reach) = (
        jet.tangent.arg(),
        across.sqrt().atan2(along * radius.signum()),
    );
    Some([radius * (angle - reach), radius * (angle + reach)])
}

fn newton(centrode: &Centrode, jet: &ProfileJet, near: f64) -> Option<f64> {
    let scale = jet.point.norm().max(near.abs());
    let mut arc = near;
    for _ in 0..30 {
        let [f, slope] = residual(centrode, jet, arc)?;
        let step = (-f / slope).clamp(-0.1 * scale, 0.1 * scale);
        if !step.is_finite() {
            return None;
        }
        arc += step;
        if step.abs() <= 4.0 * f64::EPSILON * scale {
            return Some(arc);
        }
    }
    let [f, _] = residual(centrode, jet, arc)?;
    (f.abs() <= 1e-13 * scale).then_some(arc)
}

/// Points of a centrode at equal arcs, where roots are bracketed; empty for lines and circles, whose roots are closed forms.
pub(super) struct ArcGrid(Vec<(f64, Complex)>);

impl ArcGrid {
    pub(super) fn new(centrode: &Centrode) -> ArcGrid {
        let Centrode::Member { pair, .. } = centrode else {
            return ArcGrid(vec![]);
        };
        let (first, total) = match centrode.arc_of_turn() {
            Some(turn) => (-0.5 * turn, turn),
            None => (pair.arc(pair.period()[0]), pair.arc_of_period()),
        };
        let arc = |i: usize| first + total * i as f64 / ARC_SAMPLES as f64;
        let point = |i: usize| centrode.at(arc(i)).map(|at| (arc(i), at.point));
        ArcGrid((0..=ARC_SAMPLES).filter_map(point).collect())
    }

    /// Every arc of a turn at which a profile's point touches.
    pub(super) fn contact_arcs(&self, centrode: &Centrode, jet: &ProfileJet) -> Vec<f64> {
        match centrode {
            Centrode::Line => line_root(jet).into_iter().collect(),
            Centrode::Circle { radius } => {
                let turn = std::f64::consts::TAU * radius.abs();
                let roots = circle_roots(*radius, jet).into_iter().flatten();
                roots.map(|s| s - (s / turn).round() * turn).collect()
            }
            Centrode::Member { .. } => {
                let f = |c: Complex| ((jet.point - c) * jet.tangent.conj()).re;
                let brackets = self.0.windows(2).filter_map(|pair| {
                    let (f0, f1) = (f(pair[0].1), f(pair[1].1));
                    let share = f0 / (f0 - f1);
                    (f0 * f1 <= 0.0).then(|| pair[0].0 + share * (pair[1].0 - pair[0].0))
                });
                brackets
                    .filter_map(|arc| newton(centrode, jet, arc))
                    .collect()
            }
        }
    }
}
