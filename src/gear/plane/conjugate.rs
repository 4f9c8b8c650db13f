//! Conjugate profiles by normals: z(u) touches at the arc s where its normal passes through the pitch point, `f = (z − c(s))·t = 0`.
//!
//! Willis' law of gearing (Litvin & Fuentes, Gear Geometry and Applied Theory, 2nd ed. 2004, ch. 6).

use super::contact::Contact;
use super::contact_arcs::{ArcGrid, nearest_arc};
use super::pitch_curve::{millimetres, out_of_range};
use super::profile::{Profile, ProfileJet};
use super::rolling::Rolling;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;

/// Parameters at which the first contact is sought.
const START_SAMPLES: usize = 33;
/// Range of arcs, relative to the length of the profile, below which all points touch at one instant: well above the error of splines.
const SAME_INSTANT: f64 = 1e-7;
/// Relative distance below which a point lies on the pitch curve: rounding.
const SAME_PLACE: f64 = 1e-13;

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
            "all points of the profile touch at one instant (arc {}), since its centre of curvature lies on the pitch curve (Wildhaber–Novikov); the transverse contact ratio is 0",
            millimetres(arc)
        ))
        .with_hint("move the centre off the pitch curve"));
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
