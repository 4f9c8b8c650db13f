//! A flank of the pinion with its conjugate on the gear: contacts by a route, limits, second contacts, check by the law of gearing.

use super::centrodes::Centrodes;
use super::conjugate::{ConjugateProfile, conjugate};
use super::contact::Contact;
use super::envelope::envelope;
use super::law_of_gearing::{GearingCheck, check_gearing};
use super::limits::{LimitPoint, limits};
use super::line_of_action::LineOfAction;
use super::profile::Profile;
use super::rolling::Rolling;
use super::second_contact::{SecondContact, second_contacts};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::statistics::extremes;

/// Points of a flank.
pub const FLANK_POINTS: usize = 41;
/// Contacts at either end of a flank that the law of gearing is not checked at: there the search for contact may leave the flank.
const END_CONTACTS: usize = 2;
/// Distance from the pitch point, relative to the longest of the path, below which a point has no direction for a line of action.
const NEAR_PITCH_POINT: f64 = 1e-6;
/// Share of a flank's length by which the range of the envelope exceeds that of the contacts.
const REACH: f64 = 0.05;

/// Routes to a conjugate profile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConjugateRoute {
    /// Willis' law: the normal passes through the pitch point.
    Normals,
    /// The kernel's equation of meshing.
    Envelope,
    /// Points of the path of contact, integrated.
    LineOfAction,
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
    /// The conjugate of a profile of the pinion on the gear.
    ///
    /// # Errors
    /// A profile without a conjugate; a route that does not lead to it.
    pub fn of<P: Profile + Clone>(
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

    /// Largest error of the gear against the ratio law, rad; `None` for flanks that fold back, which are not checked.
    pub fn law_error(&self) -> Option<f64> {
        let errors = self.checks.iter().map(|check| check.error.abs());
        errors.reduce(f64::max)
    }

    /// Number of second contacts between the least and the greatest radius of the pinion's flank; the others lie on no tooth of it.
    pub fn second_on_flank(&self) -> usize {
        let (low, high) = extremes(self.contacts.iter().map(|c| c.tool_point.norm()));
        let is_on = |s: &&SecondContact| (low..=high).contains(&s.tool_point.norm());
        self.second.iter().filter(is_on).count()
    }
}

/// Points of the gear where the equation of meshing holds, at the roots nearest to the angles of contact.
fn by_envelope<P: Profile + Clone>(
    generated: &ConjugateProfile<P>,
    angles: &[f64],
) -> Result<Vec<Complex>, Error> {
    let (low, high) = extremes(angles.iter().copied());
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

/// First point at which the chords of a curve turn by more than a right angle.
fn fold(points: &[Complex]) -> Option<Complex> {
    let turns_back = |p: &&[Complex]| ((p[1] - p[0]).conj() * (p[2] - p[1])).re < 0.0;
    points.windows(3).find(turns_back).map(|p| p[1])
}
