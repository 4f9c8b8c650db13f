//! Limits of a generated profile: undercut, where the contact is stationary on the work (first kind, D = 0), and the end of contact,
//! where it is stationary on the tool (second kind, Φ = 0).
//!
//! With `f_u du + f_s ds = 0` the speeds of the contact on tool and work are `speed · f_s` and `D = speed · f_s + (κ_w − κ_t) λ f_u`, with
//! the distance λ from the pitch point along the normal and Φ = f_s (Litvin & Fuentes 2004, §6.3).

use super::conjugate::ConjugateProfile;
use super::contact::Contact;
use super::pitch_curve::{millimetres, out_of_range};
use super::profile::Profile;
use crate::base::error::Error;
use crate::gear::kernel::root::sign_change;
use crate::numeric::Complex;

/// Bisections between neighbouring contacts, to rounding of the parameter.
const HALVINGS: usize = 60;

/// Kind of a limit point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LimitKind {
    /// First kind: cusp of the generated profile, with undercut beyond.
    Undercut,
    /// Second kind: no contact of the tool profile beyond.
    EndOfContact,
}

/// Limit point of a generated profile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LimitPoint {
    /// Kind of the limit.
    pub kind: LimitKind,
    /// Parameter of the tool profile.
    pub parameter: f64,
    /// Rolled arc, m.
    pub arc: f64,
    /// Limit point in the frame of the tool, m: end of the largest tool that does not undercut.
    pub tool_point: Complex,
    /// Limit point in the frame of the work, m: a blank that begins here needs no larger tool.
    pub work_point: Complex,
}

/// Limit points of a generated profile, with the usable part of the tool.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Limit points by ascending parameter.
    pub points: Vec<LimitPoint>,
    /// Range of parameters of the tool profile without a limit, around the contact nearest to the pitch point.
    pub usable: [f64; 2],
}

/// Determines the undercut points between the contacts of a generated profile, and the ends of contact.
pub fn limits<P: Profile>(generated: &ConjugateProfile<P>) -> Limits {
    let contacts = generated.contacts();
    let mut points = vec![];
    let [low, high] = generated.tool().range();
    let last = contacts.len() - 1;
    if contacts[0].parameter > low {
        points.push(end_of_contact(generated, &contacts[0], low));
    }
    for pair in contacts.windows(2) {
        if pair[0].work_speed * pair[1].work_speed < 0.0 {
            points.extend(undercut(generated, &pair[0], &pair[1]));
        }
    }
    if contacts[last].parameter < high {
        points.push(end_of_contact(generated, &contacts[last], high));
    }
    let nearest = contacts
        .iter()
        .min_by(|a, b| a.path_point.norm().total_cmp(&b.path_point.norm()))
        .map_or(low, |c| c.parameter);
    let below = points.iter().map(|p| p.parameter).filter(|u| *u <= nearest);
    let above = points.iter().map(|p| p.parameter).filter(|u| *u > nearest);
    let usable = [below.fold(low, f64::max), above.fold(high, f64::min)];
    Limits { points, usable }
}

fn undercut<P: Profile>(
    generated: &ConjugateProfile<P>,
    before: &Contact,
    after: &Contact,
) -> Option<LimitPoint> {
    let speed = |u: f64| Some(generated.at(u)?.work_speed);
    let u = sign_change([before.parameter, after.parameter], speed)?;
    Some(limit_at(LimitKind::Undercut, &generated.at(u)?))
}

/// End of contact by bisection between the last contact and a parameter without contact.
fn end_of_contact<P: Profile>(
    generated: &ConjugateProfile<P>,
    last: &Contact,
    end: f64,
) -> LimitPoint {
    let (mut inner, mut outer) = (*last, end);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (inner.parameter + outer);
        match generated.at(middle) {
            Some(contact) => inner = contact,
            None => outer = middle,
        }
    }
    limit_at(LimitKind::EndOfContact, &inner)
}

fn limit_at(kind: LimitKind, contact: &Contact) -> LimitPoint {
    LimitPoint {
        kind,
        parameter: contact.parameter,
        arc: contact.arc,
        tool_point: contact.tool_point,
        work_point: contact.work_point,
    }
}

/// Curvature of the work centrode, 1/m, at which the tool point of a contact is the undercut limit: a blank of smaller curvature is not
/// undercut there.
///
/// # Errors
/// `OutOfRange` for a contact at the pitch point, where no blank is undercut.
pub fn limiting_curvature<P: Profile>(
    generated: &ConjugateProfile<P>,
    contact: &Contact,
) -> Result<f64, Error> {
    let reach = contact.normal_distance * contact.slope;
    let state = generated.rolling().at(contact.arc);
    match state {
        Some(state) if reach != 0.0 => Ok(state.tool.curvature - contact.tool_speed / reach),
        _ => Err(out_of_range(
            "the contact is at the pitch point, where no undercut occurs".into(),
        )),
    }
}

/// Checks that a generated profile is not undercut and that the full tool profile has contact.
///
/// # Errors
/// `OutOfRange` with the limit, the usable part of the tool and the pitch-curve radius for the full tool.
pub fn check_limits<P: Profile>(generated: &ConjugateProfile<P>) -> Result<(), Error> {
    let limits = limits(generated);
    let [low, high] = limits.usable;
    let Some(limit) = limits
        .points
        .iter()
        .find(|p| p.parameter == low || p.parameter == high)
    else {
        return Ok(());
    };
    let tool = limit.tool_point;
    let place = format!(
        "parameter {} of the tool, at ({}, {}) and {} from the work's axis",
        limit.parameter,
        millimetres(tool.re),
        millimetres(tool.im),
        millimetres(limit.work_point.norm())
    );
    let message = match limit.kind {
        LimitKind::Undercut => format!("the tool undercuts the work beyond {place}"),
        LimitKind::EndOfContact => format!("the tool's profile has no contact beyond {place}"),
    };
    let mut hint = format!("end the tool's profile at parameters {low} to {high}");
    let [first, last] = generated.range();
    let end = if limit.parameter == low { first } else { last };
    let blank = generated.at(end).map(|c| limiting_curvature(generated, &c));
    if let (LimitKind::Undercut, Some(Ok(curvature))) = (limit.kind, blank) {
        let radius = curvature.recip();
        hint += &format!(
            ", or give the work's pitch curve the radius {}",
            millimetres(radius)
        );
    }
    Err(out_of_range(message).with_hint(hint))
}
