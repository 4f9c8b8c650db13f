//! The path of contact and the unloaded transmission error `te = −(φ₂ − φ₂₀) − (z₁/z₂)(φ₁ − φ₁₀)`, with hand-over between tooth pairs.

use super::contact_point::{ContactPoint, ContactUnknowns};
use super::pair::FlankPair;
use crate::gear::kernel::root::sign_change;

/// Points of a march between two pitches' ends, over which contacts are continued.
const PITCHES: f64 = 1.5;

/// The path of contact of one pair of teeth.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPath {
    /// Contacts by rising pinion angle.
    pub contacts: Vec<ContactPoint>,
    /// The contact whose ratio is that of the tooth numbers; the middle one where there is none.
    pub reference: ContactPoint,
    /// The pinion's angle beyond which a march found no contact, below and above: a limit or the end of a flank's surface.
    pub stopped: [Option<f64>; 2],
}

/// Where one pair hands over to the next, and how far the transmission error then has fallen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HandOver {
    /// Pinion angle at which this pair leads no longer, rad; the next pair has led since a pitch before.
    pub pinion_angle: f64,
    /// Transmission error there, rad.
    pub te: f64,
    /// Peak-to-peak transmission error of the leading curve, rad.
    pub peak_to_peak: f64,
}

impl FlankPair {
    /// The path of contact through `first`, `positions` contacts a pitch, a pitch and a half each way.
    pub fn path(&self, first: ContactPoint, positions: usize) -> ContactPath {
        let step = self.pitch() / positions as f64;
        let count = (PITCHES * positions as f64).ceil() as usize;
        let [(mut below, stop_below), (above, stop_above)] =
            [-step, step].map(|step| self.march(first, step, count));
        below.reverse();
        below.push(first);
        below.extend(above);
        let contacts = below;
        let reference = self.reference(&contacts).unwrap_or(first);
        ContactPath {
            contacts,
            reference,
            stopped: [stop_below, stop_above],
        }
    }

    /// Transmission error of a contact against a reference, rad: positive where the gear leads.
    pub fn te(&self, contact: &ContactPoint, reference: &ContactPoint) -> f64 {
        let turned = contact.pinion_angle - reference.pinion_angle;
        -(contact.gear_angle() - reference.gear_angle()) + self.ratio() * turned
    }

    /// The hand-over from a pair to the next: where the curve of the next pair, a pitch later, rises above this one. None where the path
    /// is too short: contact ratio below 1 without edges.
    pub fn hand_over(&self, path: &ContactPath) -> Option<HandOver> {
        let pitch = self.pitch();
        let te = |angle: f64| {
            let contact = self.near(path, angle)?;
            Some(self.te(&contact, &path.reference))
        };
        let middle = path.reference.pinion_angle;
        let lead = |angle: f64| Some(te(angle)? - te(angle - pitch)?);
        let angle = sign_change([middle, middle + pitch], lead)?;
        let at_change = te(angle)?;
        let within = path
            .contacts
            .iter()
            .filter(|c| angle - pitch <= c.pinion_angle && c.pinion_angle <= angle);
        let all = within.map(|c| self.te(c, &path.reference));
        let (low, high) = all.fold((at_change, at_change.max(0.0)), |(low, high), te| {
            (low.min(te), high.max(te))
        });
        Some(HandOver {
            pinion_angle: angle,
            te: at_change,
            peak_to_peak: high - low,
        })
    }

    /// The contact at an angle from the nearest one of a path.
    fn near(&self, path: &ContactPath, angle: f64) -> Option<ContactPoint> {
        let apart = |c: &ContactPoint| (c.pinion_angle - angle).abs();
        let nearest = path
            .contacts
            .iter()
            .min_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        let step = angle - nearest.pinion_angle;
        self.contact(angle, linear(nearest, step))
    }

    /// Contacts at equal steps from the first, which is left out, and the angle at which none was found.
    fn march(
        &self,
        first: ContactPoint,
        step: f64,
        count: usize,
    ) -> (Vec<ContactPoint>, Option<f64>) {
        let mut found: Vec<ContactPoint> = Vec::with_capacity(count);
        let mut before: Option<ContactPoint> = None;
        let mut last = first;
        for i in 1..=count {
            let angle = first.pinion_angle + step * i as f64;
            let start = match &before {
                Some(before) => cubic(before, &last),
                None => linear(&last, step),
            };
            let Some(next) = self.contact(angle, start) else {
                return (found, Some(angle));
            };
            found.push(next);
            (before, last) = (Some(last), next);
        }
        (found, None)
    }

    /// The contact whose ratio is that of the tooth numbers.
    fn reference(&self, contacts: &[ContactPoint]) -> Option<ContactPoint> {
        let off = |c: &ContactPoint| c.ratio() - self.ratio();
        let (a, b) = contacts
            .iter()
            .zip(contacts.iter().skip(1))
            .find(|(a, b)| (off(a) < 0.0) != (off(b) < 0.0))?;
        let at = |angle: f64| self.contact(angle, linear(a, angle - a.pinion_angle));
        let angle = sign_change([a.pinion_angle, b.pinion_angle], |x| Some(off(&at(x)?)))?;
        at(angle)
    }
}

/// Unknowns a step after a contact by its rates.
fn linear(contact: &ContactPoint, step: f64) -> ContactUnknowns {
    std::array::from_fn(|j| contact.unknowns[j] + step * contact.rates[j])
}

/// Unknowns one step beyond two contacts, by the cubic through both and their rates.
fn cubic(a: &ContactPoint, b: &ContactPoint) -> ContactUnknowns {
    let step = b.pinion_angle - a.pinion_angle;
    std::array::from_fn(|j| {
        5.0 * a.unknowns[j] - 4.0 * b.unknowns[j] + step * (2.0 * a.rates[j] + 4.0 * b.rates[j])
    })
}
