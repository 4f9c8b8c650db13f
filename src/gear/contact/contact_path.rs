//! Path of contact and unloaded transmission error `te = ±((φ₂ − φ₂₀) + (z₁/z₂)(φ₁ − φ₁₀))`, with edge contact and pair transfer.
//!
//! Positive te: the gear leads. Flanks cannot interpenetrate, so the leading pair determines
//! the gear angle: te is the maximum over all pairs at a pinion angle.

use super::contact_point::{ContactPoint, ContactUnknowns, Edge};
use super::pair::FlankPair;
use crate::gear::bevel::flank::is_cut_away;
use crate::gear::bevel::tooth_section::Side;
use crate::gear::kernel::root::{greatest, sign_change};
use crate::gear::kernel::vector::Vector;
use crate::numeric::statistics::peak_to_peak;

/// Default length of a path on either side, in pitches.
pub const PITCHES: f64 = 1.5;
/// Tolerance of the tooth edges, in tooth depths: rounding of Newton's method.
const ON_EDGE: f64 = 1e-9;
/// Distance beyond a path end for the evaluation after separation, in pitches.
const BEYOND_END: f64 = 1e-9;

/// Path of contact of one tooth pair from the start to the end of contact, limited to a number of pitches.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPath {
    /// Contacts in ascending order of pinion angle, on flanks and edges: at equal steps, at changes of contact kind and at the path ends.
    pub contacts: Vec<ContactPoint>,
    /// Contact with the ratio of the tooth numbers; the start of the path if there is none.
    pub reference: ContactPoint,
    /// Pinion angles below and above without contact on the teeth, rad; `None` for a path limited by the number of pitches.
    pub stopped: [Option<f64>; 2],
}

/// Contact of the leading pair at a pinion angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeadingContact {
    /// Pinion angle φ₁, rad.
    pub pinion_angle: f64,
    /// Transmission error, rad.
    pub te: f64,
    /// Number of the leading pair: its contact equals that of pair 0 as many pitches later.
    pub pair: i32,
    /// Contact of pair 0 at that later angle, on flanks or on an edge.
    pub contact: ContactPoint,
}

impl LeadingContact {
    /// Gear angle φ₂, rad.
    pub fn gear_angle(&self, pair: &FlankPair) -> f64 {
        let rotation = f64::from(self.pair) * pair.pitch();
        self.contact.gear_angle() - pair.ratio() * rotation
    }
}

impl FlankPair {
    /// Path of contact through `first`, with `positions` contacts per pitch over `pitches` on either side.
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

    /// Transmission error of a contact relative to a reference, rad: positive with the gear ahead in the driven sense.
    pub fn te(&self, contact: &ContactPoint, reference: &ContactPoint) -> f64 {
        let rotation = contact.pinion_angle - reference.pinion_angle;
        let lead = contact.gear_angle() - reference.gear_angle() - self.ratio() * rotation;
        let drive = self.turn(1).at(reference.point).dot(reference.normal);
        drive.signum() * lead
    }

    /// Contact of the leading pair at a pinion angle; `None` without contact.
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

    /// Peak-to-peak transmission error over a pitch, rad, from `positions` samples with refined extremes; `None` for a cycle
    /// with a gap in contact.
    ///
    /// The error is discontinuous at the separation of a leading pair: both sides of the path ends count.
    pub fn peak_to_peak(&self, path: &ContactPath, positions: usize) -> Option<f64> {
        let step = self.pitch() / positions as f64;
        let angle_at = |i: usize| path.reference.pinion_angle + step * i as f64;
        let te = |angle: f64| Some(self.leading(path, angle)?.te);
        let values: Option<Vec<f64>> = (0..positions).map(|i| te(angle_at(i))).collect();
        let mut values = values?;
        for sign in [1.0, -1.0] {
            let by_size =
                |a: &usize, b: &usize| (sign * values[*a]).total_cmp(&(sign * values[*b]));
            let centre = angle_at((0..positions).max_by(by_size)?);
            let extreme = greatest([centre - step, centre + step], 2, |x| Some(sign * te(x)?));
            values.extend(extreme.map(|[_, te]| sign * te));
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

    /// Contacts at equal steps after `first`, and the first angle without contact on the teeth, rad.
    fn march(
        &self,
        first: ContactPoint,
        step: f64,
        count: usize,
    ) -> (Vec<ContactPoint>, Option<f64>) {
        let mut contacts: Vec<ContactPoint> = Vec::with_capacity(count);
        let mut before: Option<ContactPoint> = None;
        let mut last = first;
        for i in 1..=count {
            let angle = first.pinion_angle + step * i as f64;
            let start = match &before {
                Some(before) if before.edge == last.edge => cubic(before, &last),
                _ => linear(&last, angle - last.pinion_angle),
            };
            let Some(next) = self.next(angle, start, last.edge) else {
                contacts.extend(self.last_of_kind(&last, angle));
                return (contacts, Some(angle));
            };
            if next.edge != last.edge {
                contacts.extend(self.last_of_kind(&last, angle));
            }
            contacts.push(next);
            (before, last) = (Some(last), next);
        }
        (contacts, None)
    }

    /// Last contact of the kind of `last` before an angle with that kind off the teeth.
    fn last_of_kind(&self, last: &ContactPoint, angle: f64) -> Option<ContactPoint> {
        let solve = |x: f64| self.contact_of(x, linear(last, x - last.pinion_angle), last.edge);
        let others = || edges().filter(|e| Some(*e) != last.edge);
        let excess = |c: &ContactPoint| {
            let distances = others().map(|e| self.beyond(e, c.point));
            distances.fold(f64::MIN, f64::max)
        };
        solve(sign_change([last.pinion_angle, angle], |x| {
            Some(excess(&solve(x)?))
        })?)
    }

    /// Contact on the teeth at an angle: of the same kind as the preceding contact, else on an edge already passed.
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

    /// Contact of pair 0 at an angle, of the kind of a neighbour on the path; the leading one of two solutions.
    fn on_path(&self, path: &ContactPath, angle: f64) -> Option<ContactPoint> {
        let [first, last] = [path.contacts.first()?, path.contacts.last()?];
        if !(first.pinion_angle <= angle && angle <= last.pinion_angle) {
            return None;
        }
        let after = path.contacts.partition_point(|c| c.pinion_angle < angle);
        let neighbours = [after.checked_sub(1), Some(after)].into_iter().flatten();
        let contacts = neighbours.filter_map(|i| {
            let start = path.contacts.get(i)?;
            let contact =
                self.contact_of(angle, linear(start, angle - start.pinion_angle), start.edge)?;
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

    /// True for a contact within the edges of both teeth.
    pub fn is_on_teeth(&self, contact: &ContactPoint) -> bool {
        edges().all(|edge| {
            let depth = self.flanks[edge.member].section.depth();
            self.beyond(edge, contact.point) <= ON_EDGE * depth
        })
    }

    /// Path of contact near the middle of the teeth, over `pitches` on either side; `None` without contact of the flanks there.
    pub fn path_near_teeth(&self, pitches: f64, positions: usize) -> Option<ContactPath> {
        let first = self.first_contact().filter(|c| self.is_near_teeth(c))?;
        Some(self.path(first, pitches, positions))
    }

    /// Index of the member with a generated flank removed by undercut at a contact.
    pub fn removed_at(&self, contact: &ContactPoint) -> Option<usize> {
        (0..2).find(|member| {
            let envelope = &self.flanks[*member].envelope;
            let at = std::array::from_fn(|j| contact.unknowns[3 * member + j]);
            let point = envelope.point(at).filter(|_| !envelope.motion.is_fixed());
            point.is_some_and(|point| is_cut_away(&point))
        })
    }

    /// True for a contact within a tooth depth of both teeth; others belong to another branch of the envelope.
    pub fn is_near_teeth(&self, contact: &ContactPoint) -> bool {
        edges().all(|edge| {
            let depth = self.flanks[edge.member].section.depth();
            self.beyond(edge, contact.point) <= depth
        })
    }

    /// Distance of a point of the fixed frame beyond an edge of a member, m; negative on the tooth.
    fn beyond(&self, edge: Edge, point: Vector) -> f64 {
        let [c_z, c_rho, c_0] = self.flanks[edge.member].section.side(edge.side);
        let offset = point - self.centre(edge.member);
        let axis = self.turn(edge.member).w;
        c_z * offset.dot(axis) + c_rho * axis.cross(offset).norm() - c_0
    }

    /// Largest distance of a point of the fixed frame beyond the edges of the gear, m, with the side; negative on the tooth.
    pub(super) fn beyond_gear(&self, point: Vector) -> (f64, Side) {
        let beyond = |side| (self.beyond(Edge { member: 1, side }, point), side);
        let [tip, ends @ ..] = [Side::Tip, Side::Toe, Side::Heel].map(beyond);
        ends.into_iter()
            .fold(tip, |max, next| if next.0 > max.0 { next } else { max })
    }

    /// Contact with the ratio of the tooth numbers; of several the nearest to the middle of the gear tooth.
    fn reference(&self, contacts: &[ContactPoint]) -> Option<ContactPoint> {
        let ratio_error = |c: &ContactPoint| c.ratio() - self.ratio();
        let pairs = contacts.iter().zip(contacts.iter().skip(1));
        let flanks = pairs.filter(|(a, b)| a.edge.is_none() && b.edge.is_none());
        let crossings = flanks.filter(|(a, b)| (ratio_error(a) < 0.0) != (ratio_error(b) < 0.0));
        let references = crossings.filter_map(|(a, b)| {
            let contact_at = |angle: f64| self.contact(angle, linear(a, angle - a.pinion_angle));
            contact_at(sign_change([a.pinion_angle, b.pinion_angle], |x| {
                Some(ratio_error(&contact_at(x)?))
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

/// Linear extrapolation of the unknowns by a step from a contact.
fn linear(contact: &ContactPoint, step: f64) -> ContactUnknowns {
    std::array::from_fn(|j| contact.unknowns[j] + step * contact.rates[j])
}

/// Hermite extrapolation of the unknowns one step beyond two contacts, by the cubic through both with rates.
fn cubic(a: &ContactPoint, b: &ContactPoint) -> ContactUnknowns {
    let step = b.pinion_angle - a.pinion_angle;
    std::array::from_fn(|j| {
        5.0 * a.unknowns[j] - 4.0 * b.unknowns[j] + step * (2.0 * a.rates[j] + 4.0 * b.rates[j])
    })
}
