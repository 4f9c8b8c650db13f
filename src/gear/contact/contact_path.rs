//! The path of contact and the unloaded transmission error `te = ±((φ₂ − φ₂₀) + (z₁/z₂)(φ₁ − φ₁₀))`, edges and hand-over included.
//!
//! The sign is that of the gear's drive: positive where the gear leads. No pair may overlap, so the leading pair places
//! the gear: the largest te of all pairs at an angle.

use super::contact_point::{ContactPoint, ContactUnknowns, Edge};
use super::pair::FlankPair;
use crate::gear::bevel::flank::is_cut_away;
use crate::gear::bevel::tooth_section::Side;
use crate::gear::kernel::root::{greatest, sign_change};
use crate::gear::kernel::vector::Vector;
use crate::numeric::statistics::peak_to_peak;

/// Pitches each way over which a pair is followed by default.
pub const PITCHES: f64 = 1.5;
/// A contact this far beyond an edge, in depths of the tooth, is on it: rounding of Newton's method.
const ON_EDGE: f64 = 1e-9;
/// Beyond the end of a path by this share of a pitch the pair has parted.
const BEYOND_END: f64 = 1e-9;

/// The contacts of one pair of teeth from where it meets to where it parts, over so many pitches each way at most.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPath {
    /// Contacts by rising pinion angle, on flanks and on edges: at equal steps, and where the kind of contact changes and the path ends.
    pub contacts: Vec<ContactPoint>,
    /// The contact whose ratio is that of the tooth numbers; the first one found where there is none.
    pub reference: ContactPoint,
    /// The pinion's angle below and above at which no contact was found on the teeth before the end of the march.
    pub stopped: [Option<f64>; 2],
}

/// One place of the leading curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeadingContact {
    /// Pinion angle φ₁, rad.
    pub pinion_angle: f64,
    /// Transmission error, rad.
    pub te: f64,
    /// The pair that leads: its contact is that of pair 0 this many pitches later.
    pub pair: i32,
    /// The contact of pair 0 at that later angle, on flanks or on an edge.
    pub contact: ContactPoint,
}

impl LeadingContact {
    /// Angle φ₂ of the gear, rad.
    pub fn gear_angle(&self, pair: &FlankPair) -> f64 {
        let turned = f64::from(self.pair) * pair.pitch();
        self.contact.gear_angle() - pair.ratio() * turned
    }
}

impl FlankPair {
    /// The path of contact through `first`, `positions` contacts a pitch over `pitches` each way.
    pub fn path(&self, first: ContactPoint, pitches: f64, positions: usize) -> ContactPath {
        let step = self.pitch() / positions as f64;
        let count = (pitches * positions as f64).ceil() as usize;
        let [(mut contacts, stop_below), (above, stop_above)] =
            [-step, step].map(|step| self.march(first, step, count));
        contacts.reverse();
        contacts.push(first);
        contacts.extend(above);
        let reference = self.reference(&contacts).unwrap_or(first);
        ContactPath {
            contacts,
            reference,
            stopped: [stop_below, stop_above],
        }
    }

    /// Transmission error of a contact against a reference, rad: positive where the gear leads in the sense in which the pinion pushes it.
    pub fn te(&self, contact: &ContactPoint, reference: &ContactPoint) -> f64 {
        let turned = contact.pinion_angle - reference.pinion_angle;
        let ahead = contact.gear_angle() - reference.gear_angle() - self.ratio() * turned;
        let push = self.turn(1).at(reference.point).dot(reference.normal);
        push.signum() * ahead
    }

    /// The leading pair at an angle; none where no pair touches.
    pub fn leading(&self, path: &ContactPath, pinion_angle: f64) -> Option<LeadingContact> {
        let pitches =
            |c: Option<&ContactPoint>| Some((c?.pinion_angle - pinion_angle) / self.pitch());
        let from = pitches(path.contacts.first())?.ceil() as i32;
        let to = pitches(path.contacts.last())?.floor() as i32;
        let candidates = (from..=to).filter_map(|pair| {
            let angle = pinion_angle + f64::from(pair) * self.pitch();
            let contact = self.on_path(path, angle)?;
            Some(LeadingContact {
                pinion_angle,
                te: self.te(&contact, &path.reference),
                pair,
                contact,
            })
        });
        candidates.max_by(|a, b| a.te.total_cmp(&b.te))
    }

    /// Peak-to-peak of the transmission error over a pitch, rad, its extremes sought between `positions` places; none where at some
    /// place no pair touches.
    ///
    /// Where a pair parts while it leads, the error jumps: both sides of its ends count.
    pub fn peak_to_peak(&self, path: &ContactPath, positions: usize) -> Option<f64> {
        let step = self.pitch() / positions as f64;
        let place = |i: usize| path.reference.pinion_angle + step * i as f64;
        let te = |angle: f64| Some(self.leading(path, angle)?.te);
        let values: Option<Vec<f64>> = (0..positions).map(|i| te(place(i))).collect();
        let mut values = values?;
        for sign in [1.0, -1.0] {
            let by_size =
                |a: &usize, b: &usize| (sign * values[*a]).total_cmp(&(sign * values[*b]));
            let at = place((0..positions).max_by(by_size)?);
            let found = greatest([at - step, at + step], 2, |x| Some(sign * te(x)?));
            values.extend(found.map(|[_, te]| sign * te));
        }
        let beyond = BEYOND_END * self.pitch();
        for (end, outwards, stopped) in [
            (path.contacts.first()?, -beyond, path.stopped[0]),
            (path.contacts.last()?, beyond, path.stopped[1]),
        ] {
            if stopped.is_some() {
                values.extend(te(end.pinion_angle));
                values.push(te(end.pinion_angle + outwards)?);
            }
        }
        Some(peak_to_peak(&values))
    }

    /// Contacts at equal steps from `first`, which is left out, and the angle at which none was found on the teeth.
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
                Some(before) if before.edge == last.edge => cubic(before, &last),
                _ => linear(&last, angle - last.pinion_angle),
            };
            let Some(next) = self.next(angle, start, last.edge) else {
                found.extend(self.last_of_kind(&last, angle));
                return (found, Some(angle));
            };
            if next.edge != last.edge {
                found.extend(self.last_of_kind(&last, angle));
            }
            found.push(next);
            (before, last) = (Some(last), next);
        }
        (found, None)
    }

    /// The last contact of the kind of one on the way to an angle at which that kind is off the teeth.
    fn last_of_kind(&self, last: &ContactPoint, angle: f64) -> Option<ContactPoint> {
        let at = |x: f64| self.contact_of(x, linear(last, x - last.pinion_angle), last.edge);
        let others = || edges().filter(|e| Some(*e) != last.edge);
        let beyond = |c: &ContactPoint| {
            let each = others().map(|e| self.beyond(e, c.point));
            each.fold(f64::MIN, f64::max)
        };
        at(sign_change([last.pinion_angle, angle], |x| {
            Some(beyond(&at(x)?))
        })?)
    }

    /// The contact at an angle on the teeth: of the same kind as the one before it, else on an edge that it has passed.
    fn next(&self, angle: f64, start: ContactUnknowns, edge: Option<Edge>) -> Option<ContactPoint> {
        let same = self.contact_of(angle, start, edge);
        if let Some(contact) = &same
            && self.is_on_teeth(contact)
        {
            return same;
        }
        let near = same.as_ref().map_or(start, |contact| contact.unknowns);
        let is_passed = |e: &Edge| match &same {
            Some(contact) => self.beyond(*e, contact.point) > 0.0,
            None => true,
        };
        let others = edges().filter(|e| Some(*e) != edge && is_passed(e));
        let contacts = others.filter_map(|e| self.edge_contact(angle, near, e));
        let mut on_teeth = contacts.filter(|c| self.is_on_teeth(c));
        on_teeth.next()
    }

    /// The contact of pair 0 at an angle, of the kinds of its neighbours on the path; the one that leads where there are two.
    fn on_path(&self, path: &ContactPath, angle: f64) -> Option<ContactPoint> {
        let [first, last] = [path.contacts.first()?, path.contacts.last()?];
        if !(first.pinion_angle <= angle && angle <= last.pinion_angle) {
            return None;
        }
        let after = path.contacts.partition_point(|c| c.pinion_angle < angle);
        let neighbours = [after.checked_sub(1), Some(after)].into_iter().flatten();
        let contacts = neighbours.filter_map(|i| {
            let near = path.contacts.get(i)?;
            let contact =
                self.contact_of(angle, linear(near, angle - near.pinion_angle), near.edge)?;
            self.is_on_teeth(&contact).then_some(contact)
        });
        let te = |c: &ContactPoint| self.te(c, &path.reference);
        contacts.max_by(|a, b| te(a).total_cmp(&te(b)))
    }

    fn contact_of(
        &self,
        angle: f64,
        start: ContactUnknowns,
        edge: Option<Edge>,
    ) -> Option<ContactPoint> {
        match edge {
            Some(edge) => self.edge_contact(angle, start, edge),
            None => self.contact(angle, start),
        }
    }

    /// Whether a contact lies within the edges of both teeth.
    pub fn is_on_teeth(&self, contact: &ContactPoint) -> bool {
        edges().all(|edge| {
            let depth = self.flanks[edge.member].section.depth();
            self.beyond(edge, contact.point) <= ON_EDGE * depth
        })
    }

    /// The path of contact through the middle of the teeth, `pitches` each way; none where the flanks do not touch there.
    pub fn path_near_teeth(&self, pitches: f64, positions: usize) -> Option<ContactPath> {
        let first = self.first_contact().filter(|c| self.is_near_teeth(c))?;
        Some(self.path(first, pitches, positions))
    }

    /// The member whose generated flank undercut removes at a contact.
    pub fn removed_at(&self, contact: &ContactPoint) -> Option<usize> {
        (0..2).find(|member| {
            let envelope = &self.flanks[*member].envelope;
            let at = std::array::from_fn(|j| contact.unknowns[3 * member + j]);
            let point = envelope.point(at).filter(|_| !envelope.motion.is_fixed());
            point.is_some_and(|point| is_cut_away(&point))
        })
    }

    /// Whether a contact lies within a tooth depth of both teeth: beyond that it belongs to another branch of the flanks.
    pub fn is_near_teeth(&self, contact: &ContactPoint) -> bool {
        edges().all(|edge| {
            let depth = self.flanks[edge.member].section.depth();
            self.beyond(edge, contact.point) <= depth
        })
    }

    /// Distance of a point of the fixed frame beyond an edge of a member, m; negative on the tooth.
    fn beyond(&self, edge: Edge, point: Vector) -> f64 {
        let [c_z, c_rho, c_0] = self.flanks[edge.member].section.side(edge.side);
        let off = point - self.centre(edge.member);
        let axis = self.turn(edge.member).w;
        c_z * off.dot(axis) + c_rho * axis.cross(off).norm() - c_0
    }

    /// Distance of a point of the fixed frame beyond the edges of the gear, m, and the side it is furthest beyond; negative on the tooth.
    pub(super) fn beyond_gear(&self, point: Vector) -> (f64, Side) {
        let beyond = |side| (self.beyond(Edge { member: 1, side }, point), side);
        let [tip, ends @ ..] = [Side::Tip, Side::Toe, Side::Heel].map(beyond);
        ends.into_iter()
            .fold(tip, |most, next| if next.0 > most.0 { next } else { most })
    }

    /// The contact whose ratio is that of the tooth numbers; of several the one nearest the middle of the gear's tooth.
    fn reference(&self, contacts: &[ContactPoint]) -> Option<ContactPoint> {
        let off = |c: &ContactPoint| c.ratio() - self.ratio();
        let pairs = contacts.iter().zip(contacts.iter().skip(1));
        let flanks = pairs.filter(|(a, b)| a.edge.is_none() && b.edge.is_none());
        let crossings = flanks.filter(|(a, b)| (off(a) < 0.0) != (off(b) < 0.0));
        let references = crossings.filter_map(|(a, b)| {
            let at = |angle: f64| self.contact(angle, linear(a, angle - a.pinion_angle));
            at(sign_change([a.pinion_angle, b.pinion_angle], |x| {
                Some(off(&at(x)?))
            })?)
        });
        let from_middle = |c: &ContactPoint| {
            let [face, height] = self.shares(1, c).unwrap_or([f64::INFINITY; 2]);
            f64::hypot(face - 0.5, height - 0.5)
        };
        references.min_by(|a, b| from_middle(a).total_cmp(&from_middle(b)))
    }
}

/// The edges of both members.
fn edges() -> impl Iterator<Item = Edge> {
    [0, 1].into_iter().flat_map(|member| {
        let sides = [Side::Tip, Side::Toe, Side::Heel];
        sides.into_iter().map(move |side| Edge { member, side })
    })
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
