//! Ridges of least gap: at an angle, for each station along the pinion's face, the height at which the flanks come nearest.
//!
//! φ₂(P), the azimuth of a pinion point P about the gear's axis less that of the gear's flank at the same `[z, radius]`, is the gear's
//! angle at which P alone would touch. Contact is its extremum over the part of the pinion that lies inside the gear's blank, so edges of
//! both blanks are bounds. No normal is matched: `dφ₂/dh = n·t/(n·(k₂ × r))` with the gear's normal n and the pinion's tangent t along
//! the height h, and its zero is the ridge. A station's gap is arm × (highest te − its te).

use super::contact_point::{ContactPoint, Edge};
use super::pair::FlankPair;
use crate::gear::bevel::flank::BevelFlank;
use crate::gear::bevel::tooth_section::Side;
use crate::gear::kernel::jet::Jet;
use crate::gear::kernel::meeting::Meeting;
use crate::gear::kernel::second_order::SecondOrder;
use crate::gear::kernel::vector::Vector;

/// Pairs of teeth before and after one that may touch next to it.
const NEIGHBOURS: i32 = 2;
/// Heights of a station at which the pinion's flank is tabulated.
const HEIGHTS: usize = 13;
/// Newton steps towards the top of a station.
const STEPS: usize = 30;
/// A step of the height below this share is not taken but counted in te, by half slope times step: the rest is of its third power.
const LAST_STEP: f64 = 1e-3;
/// Secants towards the height at which a station enters the gear's blank: the distance from an edge is nearly straight between nodes.
const SECANTS: usize = 2;

/// Stations along the pinion's face, each with its flank from root to tip.
#[derive(Debug, Clone)]
pub struct RidgeStations {
    stations: Vec<Station>,
    /// Transmission error is counted from this contact.
    reference: ContactPoint,
    /// 1 where the gear leads at growing φ₂, else −1.
    sign: f64,
    /// Parameters `[u, θ, x]` of the gear's flank from which it is sought.
    gear_start: [f64; 3],
}

/// A section of the pinion's flank by a station.
#[derive(Debug, Clone)]
struct Station {
    /// Share of the face.
    face: f64,
    /// Parameters and points at equal steps of the height; none where the flank does not exist.
    nodes: Vec<Option<([f64; 3], Vector)>>,
}

/// The place of a station at which the flanks come nearest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RidgePoint {
    /// Share of the pinion's face.
    pub face: f64,
    /// Share of the pinion's height.
    pub height: f64,
    /// Transmission error if the flanks touched here, rad.
    pub te: f64,
    /// Arm of the normal force about the gear's axis, m.
    pub arm: f64,
    /// Relative curvature along the height, 1/m.
    pub curvature: f64,
    /// Unit tangent of the pinion along the height, in the fixed frame.
    pub along_height: Vector,
    /// Point in the fixed frame, m.
    pub point: Vector,
    /// Normal of the pinion, out of its metal.
    pub normal: Vector,
    /// The edge on which it lies; none within both flanks.
    pub edge: Option<Edge>,
    /// `[z, radius]` in the frames of pinion and gear, m.
    pub places: [[f64; 2]; 2],
    /// Parameters `[u, θ, x]` of both flanks.
    pub unknowns: [[f64; 3]; 2],
}

/// A place of a station with what the search needs.
struct Place {
    point: RidgePoint,
    /// dte/dh.
    slope: f64,
    /// d²te/dh².
    bend: f64,
}

impl Place {
    /// Parameters of the gear's flank.
    fn gear(&self) -> [f64; 3] {
        self.point.unknowns[1]
    }

    /// Height and gear parameters at the next station, from the one before and this one.
    fn beyond(&self, before: &Place, face: f64) -> (f64, [f64; 3]) {
        let share = (face - self.point.face) / (self.point.face - before.point.face);
        let on = |last: f64, before: f64| last + share * (last - before);
        let gear = std::array::from_fn(|i| on(self.gear()[i], before.gear()[i]));
        (on(self.point.height, before.point.height), gear)
    }
}

impl RidgeStations {
    /// Stations at equal steps from toe to heel, both ends included.
    pub fn over_face(pair: &FlankPair, reference: &ContactPoint, count: usize) -> RidgeStations {
        let faces: Vec<f64> = (0..count).map(|i| i as f64 / (count - 1) as f64).collect();
        RidgeStations::new(pair, reference, &faces)
    }

    /// The ridges of pair 0 and of two pairs to either side, at an angle of the pinion.
    pub fn ridges(&self, pair: &FlankPair, pinion_angle: f64) -> Vec<RidgePoint> {
        let angles = (-NEIGHBOURS..=NEIGHBOURS).map(|k| pinion_angle + f64::from(k) * pair.pitch());
        angles.flat_map(|angle| self.ridge(pair, angle)).collect()
    }

    /// Stations of a pair at these shares of the face; none where the flanks are not found.
    pub fn new(pair: &FlankPair, reference: &ContactPoint, faces: &[f64]) -> RidgeStations {
        let y = &reference.unknowns;
        let middle = [y[0], y[1], y[2]];
        let push = pair.turn(1).at(reference.point).dot(reference.normal);
        let stations = faces
            .iter()
            .map(|face| Station::new(&pair.flanks[0], *face, middle));
        RidgeStations {
            stations: stations.collect(),
            reference: *reference,
            sign: push.signum(),
            gear_start: [y[3], y[4], y[5]],
        }
    }

    /// The ridge of pair 0 at an angle of the pinion: its stations that lie inside both blanks.
    pub fn ridge(&self, pair: &FlankPair, pinion_angle: f64) -> Vec<RidgePoint> {
        let mut found = Vec::new();
        let mut near: [Option<Place>; 2] = [None, None];
        for station in &self.stations {
            let Some((bounds, edges)) = self.bounds(pair, station, pinion_angle) else {
                continue;
            };
            let (height, gear) = match &near {
                [Some(before), Some(last)] => last.beyond(before, station.face),
                [_, Some(last)] => (last.point.height, last.gear()),
                _ => (0.5 * (bounds[0] + bounds[1]), self.gear_start),
            };
            let at =
                |height: f64, gear: [f64; 3]| self.place(pair, station, pinion_angle, height, gear);
            if let Some(mut top) = highest(bounds, height, gear, at) {
                let on = |k: usize| top.point.height == bounds[k];
                top.point.edge = match (on(0), on(1)) {
                    (true, _) => edges[0],
                    (_, true) => edges[1],
                    _ => None,
                };
                found.push(top.point);
                near = [near[1].take(), Some(top)];
            }
        }
        found
    }

    /// Heights between which a station lies inside the gear's blank, and the edges there; none where it does not.
    fn bounds(
        &self,
        pair: &FlankPair,
        station: &Station,
        pinion_angle: f64,
    ) -> Option<([f64; 2], [Option<Edge>; 2])> {
        let pose = pair.pose(0, pinion_angle);
        let outside = |r: Vector| pair.beyond_gear(pose.apply(r));
        let node = |i: usize| Some(outside(station.nodes[i]?.1));
        let inside = |i: &usize| node(*i).is_some_and(|(beyond, _)| beyond <= 0.0);
        let first = (0..HEIGHTS).find(inside)?;
        let last = (first..HEIGHTS).take_while(inside).last()?;
        let height = |i: usize| i as f64 / (HEIGHTS - 1) as f64;
        // Where the next node is outside, the bound lies between; the flank is exact there.
        let bound = |inner: usize, outer: Option<usize>, own: Option<Edge>| {
            let Some(outer) = outer else {
                return (height(inner), own);
            };
            let (Some((far, side)), Some((near, _))) = (node(outer), station.nodes[inner]) else {
                return (height(inner), None);
            };
            let (mut a, mut b) = (
                (height(inner), node(inner).map_or(0.0, |n| n.0)),
                (height(outer), far),
            );
            for _ in 0..SECANTS {
                let at = a.0 + (b.0 - a.0) * a.1 / (a.1 - b.1);
                let Some((_, meeting)) = station.point(&pair.flanks[0], at, near) else {
                    break;
                };
                let next = (at, outside(meeting.jet.r).0);
                *(if next.1 <= 0.0 { &mut a } else { &mut b }) = next;
            }
            let at = a.0 + (b.0 - a.0) * a.1 / (a.1 - b.1);
            (at, Some(Edge { member: 1, side }))
        };
        let tip = Edge {
            member: 0,
            side: Side::Tip,
        };
        let (low, low_edge) = bound(first, first.checked_sub(1), None);
        let next = (last + 1 < HEIGHTS).then_some(last + 1);
        let (high, high_edge) = bound(last, next, Some(tip));
        Some(([low, high], [low_edge, high_edge]))
    }

    /// A height of a station against the gear's flank.
    fn place(
        &self,
        pair: &FlankPair,
        station: &Station,
        pinion_angle: f64,
        height: f64,
        gear_start: [f64; 3],
    ) -> Option<Place> {
        let (pinion_at, pinion) = station.point(&pair.flanks[0], height, station.near(height)?)?;
        let tangent = along_section(&pinion.jet, pair.flanks[0].section.up(station.face));
        let pose = pair.pose(0, pinion_angle);
        let (point, normal) = (pose.apply(pinion.jet.r), pose.rotate(pinion.jet.n));
        let (length, along_height) = (tangent.norm(), pose.rotate(tangent.unit()?));
        let in_gear = pair.pose(1, 0.0).inverse().apply(point);
        let place = [in_gear.z, f64::hypot(in_gear.x, in_gear.y)];
        let gear = pair.flanks[1].envelope.on_circle(place, gear_start)?;
        let meeting = pair.flanks[1].envelope.meeting(gear)?;
        let own = meeting.jet.r;
        let turn = in_gear.y.atan2(in_gear.x) - own.y.atan2(own.x);
        let gear_pose = pair.pose(1, turn);
        let gear_normal = gear_pose.rotate(meeting.jet.n);
        let arm = gear_normal.dot(pair.turn(1).at(point));
        let turned = pinion_angle - self.reference.pinion_angle;
        let ahead = turn - self.reference.gear_angle() - pair.ratio() * turned;
        let te =
            self.sign * (ahead - std::f64::consts::TAU * (ahead / std::f64::consts::TAU).round());
        // The gear's normal points the other way, which turns the sign of its curvature.
        let side = normal.dot(gear_normal).signum();
        let relative = side * curvature(&meeting, gear_pose.inverse().rotate(along_height))?
            - curvature(&pinion, tangent.unit()?)?;
        Some(Place {
            slope: self.sign * length * gear_normal.dot(along_height) / arm,
            bend: -relative * length * length / arm.abs(),
            point: RidgePoint {
                face: station.face,
                height,
                te,
                arm: arm.abs(),
                curvature: relative,
                along_height,
                point,
                normal,
                edge: None,
                places: [pair.flanks[0].section.at(station.face, height), place],
                unknowns: [pinion_at, gear],
            },
        })
    }
}

impl Station {
    fn new(flank: &BevelFlank, face: f64, middle: [f64; 3]) -> Station {
        let mut station = Station {
            face,
            nodes: vec![None; HEIGHTS],
        };
        let point = |at| flank.envelope.point(at);
        let side = point(middle).map(|p| p.second_order.undercut.signum());
        let mut near = middle;
        for i in (0..HEIGHTS).rev() {
            let height = i as f64 / (HEIGHTS - 1) as f64;
            let found = station.point(flank, height, near);
            let found = found.or_else(|| station.point(flank, height, middle));
            // Beyond the undercut limit D has the other sign: that part of the envelope is cut away.
            let found = found
                .filter(|(at, _)| point(*at).map(|p| p.second_order.undercut.signum()) == side);
            if let Some((at, meeting)) = found {
                near = at;
                station.nodes[i] = Some((at, meeting.jet.r));
            }
        }
        station
    }

    /// Parameters at a height between those of its nodes, or of the one that exists.
    fn near(&self, height: f64) -> Option<[f64; 3]> {
        let place = height * (HEIGHTS - 1) as f64;
        let before = place.floor().clamp(0.0, (HEIGHTS - 2) as f64);
        let node = |i: usize| self.nodes[i].map(|(at, _)| at);
        let (low, high) = (node(before as usize), node(before as usize + 1));
        let (Some(low), Some(high)) = (low, high) else {
            return low.or(high);
        };
        let share = place - before;
        Some(std::array::from_fn(|i| low[i] + share * (high[i] - low[i])))
    }

    /// The flank at a height of the station, in the pinion's frame, from parameters near it.
    fn point(
        &self,
        flank: &BevelFlank,
        height: f64,
        near: [f64; 3],
    ) -> Option<([f64; 3], Meeting)> {
        let at = flank
            .envelope
            .on_circle(flank.section.at(self.face, height), near)?;
        Some((at, flank.envelope.meeting(at)?))
    }
}

/// The tangent of a flank whose axial section it follows at the rates `[dz, dρ]`: `n·t = 0` gives its third component.
fn along_section(jet: &Jet, [dz, dr]: [f64; 2]) -> Vector {
    let rho = f64::hypot(jet.r.x, jet.r.y);
    let out = Vector::new(jet.r.x / rho, jet.r.y / rho, 0.0);
    let around = Vector::Z.cross(out);
    let in_section = Vector::Z * dz + out * dr;
    in_section - around * (jet.n.dot(in_section) / jet.n.dot(around))
}

/// Normal curvature of a flank along a unit tangent.
fn curvature(meeting: &Meeting, along: Vector) -> Option<f64> {
    Some(SecondOrder::of(meeting)?.envelope()?.normal(along))
}

/// The highest place between two heights by Newton's method on the slope within its bracket; at a bound where the slope points out of it.
fn highest(
    bounds: [f64; 2],
    start: f64,
    gear: [f64; 3],
    at: impl Fn(f64, [f64; 3]) -> Option<Place>,
) -> Option<Place> {
    let [mut low, mut high] = bounds;
    let mut place = at(start.clamp(low, high), gear)?;
    for _ in 0..STEPS {
        let here = place.point.height;
        if place.slope > 0.0 {
            low = here;
        } else {
            high = here;
        }
        if low >= bounds[1] || high <= bounds[0] {
            break;
        }
        let newton = here - place.slope / place.bend;
        let next = match place.bend < 0.0 {
            true if low < newton && newton < high => newton,
            true if newton >= high && here < high => high,
            true if newton <= low && here > low => low,
            _ => 0.5 * (low + high),
        };
        let is_bound = next == bounds[0] || next == bounds[1];
        if (next - here).abs() <= LAST_STEP && !is_bound {
            place.point.te += 0.5 * place.slope * (next - here);
            break;
        }
        place = at(next, place.gear())?;
    }
    Some(place)
}
