//! Conjugate flank of a pinion profile by three methods: contacts, limit points, second contacts, and verification by the law of gearing.

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

/// Number of contact points on a flank.
pub const FLANK_POINTS: usize = 41;
/// Contacts at each end of a flank that are not verified, because the contact search may leave the flank there.
const END_CONTACTS: usize = 2;
/// Minimum distance of a path point from the pitch point, relative to the largest; below it the line of action has no direction.
const PITCH_DISTANCE: f64 = 1e-6;
/// Extension of the envelope's motion range beyond the contact angles at each end, relative to their range.
const RANGE_MARGIN: f64 = 0.05;

/// Method for the conjugate profile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ConjugateRoute {
    /// Willis' law: the normal passes through the pitch point.
    Normals,
    /// Equation of meshing of the gear kernel.
    Envelope,
    /// Integration along the path of contact.
    LineOfAction,
}

/// Flank of the pinion with its conjugate on the gear.
#[derive(Debug, Clone)]
pub struct ConjugateFlank {
    /// Contacts in the order of the pinion flank.
    pub contacts: Vec<Contact>,
    /// Angle of gear 1 at each contact, rad.
    pub angles: Vec<f64>,
    /// Gear flank points by the requested method, m.
    pub gear_points: Vec<Complex>,
    /// Largest distance between these and the points by `ConjugateRoute::Normals`, m.
    pub route_deviation: f64,
    /// First cusp of the pinion flank and of the gear flank, m; `None` for a regular flank.
    pub cusps: [Option<Complex>; 2],
    /// Limit points of the flank.
    pub limits: Vec<LimitPoint>,
    /// Deviations of the flank pair from the ratio law; empty for flanks with a cusp.
    pub checks: Vec<GearingCheck>,
    /// Second contacts of the gear flank with the pinion flank.
    pub second: Vec<SecondContact>,
}

impl ConjugateFlank {
    /// Conjugate of a pinion profile on the gear.
    ///
    /// # Errors
    /// No conjugate exists, or the method does not converge.
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
        let distances = gear_points.iter().zip(&contacts);
        let route_deviation = distances
            .map(|(point, contact)| (point - contact.work_point).norm())
            .fold(0.0, f64::max);
        let interior = END_CONTACTS..contacts.len().saturating_sub(END_CONTACTS);
        let pinion_points: Vec<Complex> = contacts.iter().map(|c| c.tool_point).collect();
        let folds = [cusp(&pinion_points), cusp(&gear_points)];
        let checks = match angles.get(interior) {
            Some(angles) if folds == [None; 2] => {
                check_gearing(pair, generated.tool(), &generated, angles)?
            }
            _ => Vec::new(),
        };
        Ok(ConjugateFlank {
            cusps: folds,
            limits: limits(&generated).points,
            second: second_contacts(&generated).unwrap_or_default(),
            contacts,
            angles,
            gear_points,
            route_deviation,
            checks,
        })
    }

    /// Largest transmission error relative to the ratio law, rad; `None` for flanks with a cusp, which are not verified.
    pub fn law_error(&self) -> Option<f64> {
        let errors = self.checks.iter().map(|check| check.error.abs());
        errors.reduce(f64::max)
    }

    /// Number of second contacts between the smallest and largest radius of the pinion flank; those outside lie on no tooth.
    pub fn n_second_contacts(&self) -> usize {
        let (low, high) = extremes(self.contacts.iter().map(|c| c.tool_point.norm()));
        let is_on = |s: &&SecondContact| (low..=high).contains(&s.tool_point.norm());
        self.second.iter().filter(is_on).count()
    }
}

/// Gear flank points from the roots of the equation of meshing nearest to the contact angles.
fn by_envelope<P: Profile + Clone>(
    generated: &ConjugateProfile<P>,
    angles: &[f64],
) -> Result<Vec<Complex>, Error> {
    let (low, high) = extremes(angles.iter().copied());
    let margin = RANGE_MARGIN * (high - low);
    let tool = generated.tool().clone();
    let kernel = envelope(generated.rolling(), tool, [low - margin, high + margin])?;
    let point = |(contact, angle): (&Contact, &f64)| {
        let roots = kernel.motion_parameters([contact.parameter, 0.0]);
        let gap = |root: &f64| (root - angle).abs();
        let root = roots.into_iter().min_by(|a, b| gap(a).total_cmp(&gap(b)));
        let flank = root.and_then(|root| kernel.point([contact.parameter, 0.0, root]));
        flank.map_or(Complex::new(f64::NAN, f64::NAN), |flank| {
            let [x, y] = flank.profile().point;
            Complex::new(x, y)
        })
    };
    let points: Vec<Complex> = generated.contacts().iter().zip(angles).map(point).collect();
    match points.iter().all(|z| z.norm().is_finite()) {
        true => Ok(points),
        false => Err(method_failed(
            "the equation of meshing has no root near a contact",
        )),
    }
}

/// Gear flank points by integration along the path of contact from its first point.
fn by_line_of_action<P: Profile>(generated: &ConjugateProfile<P>) -> Result<Vec<Complex>, Error> {
    let contacts = generated.contacts();
    let path: Vec<Complex> = contacts.iter().map(|c| c.path_point).collect();
    let longest = path.iter().map(|z| z.norm()).fold(0.0, f64::max);
    if path.iter().any(|z| z.norm() <= PITCH_DISTANCE * longest) {
        return Err(method_failed(
            "a point of the path of contact is the pitch point",
        ));
    }
    let line = LineOfAction::points(&path)?;
    let index: Vec<f64> = (0..path.len()).map(|i| i as f64).collect();
    let on_line = line.contacts(generated.rolling(), &index, contacts[0].arc)?;
    Ok(on_line.iter().map(|c| c.work_point).collect())
}

fn method_failed(reason: &str) -> Error {
    Error::new(Code::NoConvergence, reason).with_hint("take by = \"normals\", or another route")
}

/// First cusp of a polyline: consecutive chords turn by more than 90°.
fn cusp(points: &[Complex]) -> Option<Complex> {
    let is_cusp = |p: &&[Complex]| ((p[1] - p[0]).conj() * (p[2] - p[1])).re < 0.0;
    points.windows(3).find(is_cusp).map(|p| p[1])
}
