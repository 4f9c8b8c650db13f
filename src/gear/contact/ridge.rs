//! Ridge of smallest gap at a pinion angle: for each station along the pinion face, the height of closest approach of the flanks.
//!
//! φ₂(P), the azimuth of a pinion point P about the gear axis less that of the gear flank at the same `[z, radius]`, is the gear
//! angle of contact at P. The contact is the extremum over the pinion flank inside the gear blank, so edges of
//! both blanks are bounds. The slope is `dφ₂/dh = n·t/(n·(k₂ × r))` with the gear normal n and the pinion tangent t along
//! the height h; its zero is the ridge. The gap of a station is arm × (maximum te − te of the station).

use super::contact_point::{ContactPoint, Edge};
use super::pair::FlankPair;
use crate::gear::bevel::flank::BevelFlank;
use crate::gear::bevel::tooth_section::Side;
use crate::gear::kernel::jet::Jet;
use crate::gear::kernel::meeting::MeshingState;
use crate::gear::kernel::second_order::SecondOrder;
use crate::gear::kernel::vector::Vector;

/// Number of neighbouring tooth pairs on either side in possible contact.
const NEIGHBOURS: i32 = 2;
/// Number of heights in the pinion-flank table of a station.
const HEIGHTS: usize = 13;
/// Largest number of Newton steps to the maximum te of a station.
const STEPS: usize = 30;
/// Smallest step of the height share; a smaller step only corrects te by half slope times step, with an error of third order.
const LAST_STEP: f64 = 1e-3;
/// Number of secant steps to the height of entry into the gear blank: the distance from an edge is nearly linear between nodes.
const SECANTS: usize = 2;

/// Stations along the pinion face, with tabulated flank points from root to tip.
#[derive(Debug, Clone)]
pub struct RidgeStations {
    stations: Vec<Station>,
    /// Reference contact of the transmission error.
    reference: ContactPoint,
    /// Sign of te for increasing φ₂, 1 or −1.
    sign: f64,
    /// Start parameters `[u, θ, x]` of the gear flank.
    gear_start: [f64; 3],
}

/// Section of the pinion flank at a station.
#[derive(Debug, Clone)]
struct Station {
    /// Position along the face, as a share.
    face: f64,
    /// Parameters and points at equal steps of the height; `None` without a flank point.
    nodes: Vec<Option<([f64; 3], Vector)>>,
}

/// Point of closest approach of the flanks at a station.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RidgePoint {
    /// Position along the pinion face, as a share.
    pub face: f64,
    /// Position over the pinion tooth height, as a share.
    pub height: f64,
    /// Transmission error of contact at this point, rad.
    pub te: f64,
    /// Lever arm of the normal force about the gear axis, m.
    pub arm: f64,
    /// Relative curvature along the height, 1/m.
    pub curvature: f64,
    /// Unit tangent of the pinion along the height, in the fixed frame.
    pub along_height: Vector,
    /// Point in the fixed frame, m.
    pub point: Vector,
    /// Outward normal of the pinion flank.
    pub normal: Vector,
    /// Edge of the contact; `None` within both flanks.
    pub edge: Option<Edge>,
    /// `[z, radius]` in the frames of pinion and gear, m.
    pub places: [[f64; 2]; 2],
    /// Parameters `[u, θ, x]` of both flanks.
    pub unknowns: [[f64; 3]; 2],
}

/// Trial point of a station with the derivatives of te over the height share.
struct TrialPoint {
    point: RidgePoint,
    /// First derivative dte/dh, rad.
    slope: f64,
    /// Second derivative d²te/dh², rad.
    slope_rate: f64,
}

impl TrialPoint {
    /// Parameters of the gear flank.
    fn gear(&self) -> [f64; 3] {
        self.point.unknowns[1]
    }

    /// Linear extrapolation of height and gear parameters to the next station.
    fn extrapolate(&self, before: &TrialPoint, face: f64) -> (f64, [f64; 3]) {
        let share = (face - self.point.face) / (self.point.face - before.point.face);
        let linear = |last: f64, before: f64| last + share * (last - before);
        let gear = std::array::from_fn(|i| linear(self.gear()[i], before.gear()[i]));
        (linear(self.point.height, before.point.height), gear)
    }
}

impl RidgeStations {
    /// Stations at equal steps from toe to heel, both ends included.
    pub fn over_face(pair: &FlankPair, reference: &ContactPoint, count: usize) -> RidgeStations {
        let faces: Vec<f64> = (0..count).map(|i| i as f64 / (count - 1) as f64).collect();
        RidgeStations::new(pair, reference, &faces)
    }

    /// Ridges of pair 0 and of two pairs on either side at a pinion angle, rad.
    pub fn ridges(&self, pair: &FlankPair, pinion_angle: f64) -> Vec<RidgePoint> {
        let angles = (-NEIGHBOURS..=NEIGHBOURS).map(|k| pinion_angle + f64::from(k) * pair.pitch());
        angles.flat_map(|angle| self.ridge(pair, angle)).collect()
    }

    /// Stations of a pair at the face shares `faces`.
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

    /// Ridge of pair 0 at a pinion angle, rad: its stations inside both blanks.
    pub fn ridge(&self, pair: &FlankPair, pinion_angle: f64) -> Vec<RidgePoint> {
        let mut points = Vec::new();
        let mut previous: [Option<TrialPoint>; 2] = [None, None];
        for station in &self.stations {
            let Some((bounds, edges)) = self.bounds(pair, station, pinion_angle) else {
                continue;
            };
            let (height, gear) = match &previous {
                [Some(before), Some(last)] => last.extrapolate(before, station.face),
                [_, Some(last)] => (last.point.height, last.gear()),
                _ => (0.5 * (bounds[0] + bounds[1]), self.gear_start),
            };
            let evaluate =
                |height: f64, gear: [f64; 3]| self.trial(pair, station, pinion_angle, height, gear);
            if let Some(mut maximum) = maximise_te(bounds, height, gear, evaluate) {
                let is_on = |k: usize| maximum.point.height == bounds[k];
                maximum.point.edge = match (is_on(0), is_on(1)) {
                    (true, _) => edges[0],
                    (_, true) => edges[1],
                    _ => None,
                };
                points.push(maximum.point);
                previous = [previous[1].take(), Some(maximum)];
            }
        }
        points
    }

    /// Height range of a station inside the gear blank, with the edges at its ends; `None` outside.
    fn bounds(
        &self,
        pair: &FlankPair,
        station: &Station,
        pinion_angle: f64,
    ) -> Option<([f64; 2], [Option<Edge>; 2])> {
        let pose = pair.pose(0, pinion_angle);
        let outside = |r: Vector| pair.beyond_gear(pose.apply(r));
        let node = |i: usize| Some(outside(station.nodes[i]?.1));
        let is_inside = |i: &usize| node(*i).is_some_and(|(beyond, _)| beyond <= 0.0);
        let first = (0..HEIGHTS).find(is_inside)?;
        let last = (first..HEIGHTS).take_while(is_inside).last()?;
        let height = |i: usize| i as f64 / (HEIGHTS - 1) as f64;
        // With the next node outside, the bound lies between both; the secant steps use the exact flank.
        let bound = |inner: usize, outer: Option<usize>, edge: Option<Edge>| {
            let Some(outer) = outer else {
                return (height(inner), edge);
            };
            let (Some((far, side)), Some((near, _))) = (node(outer), station.nodes[inner]) else {
                return (height(inner), None);
            };
            let (mut a, mut b) = (
                (height(inner), node(inner).map_or(0.0, |n| n.0)),
                (height(outer), far),
            );
            for _ in 0..SECANTS {
                let h = a.0 + (b.0 - a.0) * a.1 / (a.1 - b.1);
                let Some((_, meeting)) = station.point(&pair.flanks[0], h, near) else {
                    break;
                };
                let next = (h, outside(meeting.jet.r).0);
                *(if next.1 <= 0.0 { &mut a } else { &mut b }) = next;
            }
            let h = a.0 + (b.0 - a.0) * a.1 / (a.1 - b.1);
            (h, Some(Edge { member: 1, side }))
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

    /// Trial point at a height of a station, against the gear flank.
    fn trial(
        &self,
        pair: &FlankPair,
        station: &Station,
        pinion_angle: f64,
        height: f64,
        gear_start: [f64; 3],
    ) -> Option<TrialPoint> {
        let (pinion_at, pinion) = station.point(&pair.flanks[0], height, station.near(height)?)?;
        let tangent = along_section(&pinion.jet, pair.flanks[0].section.up(station.face));
        let pose = pair.pose(0, pinion_angle);
        let (point, normal) = (pose.apply(pinion.jet.r), pose.rotate(pinion.jet.n));
        let (length, along_height) = (tangent.norm(), pose.rotate(tangent.unit()?));
        let in_gear = pair.pose(1, 0.0).inverse().apply(point);
        let position = [in_gear.z, f64::hypot(in_gear.x, in_gear.y)];
        let gear = pair.flanks[1]
            .envelope
            .intersect_circle(position, gear_start)?;
        let meeting = pair.flanks[1].envelope.meeting(gear)?;
        let gear_point = meeting.jet.r;
        let gear_angle = in_gear.y.atan2(in_gear.x) - gear_point.y.atan2(gear_point.x);
        let gear_pose = pair.pose(1, gear_angle);
        let gear_normal = gear_pose.rotate(meeting.jet.n);
        let arm = gear_normal.dot(pair.turn(1).at(point));
        let rotation = pinion_angle - self.reference.pinion_angle;
        let lead = gear_angle - self.reference.gear_angle() - pair.ratio() * rotation;
        let te =
            self.sign * (lead - std::f64::consts::TAU * (lead / std::f64::consts::TAU).round());
        // The gear normal is opposite, which reverses the sign of the gear curvature.
        let side = normal.dot(gear_normal).signum();
        let relative = side * curvature(&meeting, gear_pose.inverse().rotate(along_height))?
            - curvature(&pinion, tangent.unit()?)?;
        Some(TrialPoint {
            slope: self.sign * length * gear_normal.dot(along_height) / arm,
            slope_rate: -relative * length * length / arm.abs(),
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
                places: [pair.flanks[0].section.at(station.face, height), position],
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
            let node = station.point(flank, height, near);
            let node = node.or_else(|| station.point(flank, height, middle));
            // Beyond the undercut limit D has the opposite sign: that branch of the envelope is removed.
            let node =
                node.filter(|(at, _)| point(*at).map(|p| p.second_order.undercut.signum()) == side);
            if let Some((at, meeting)) = node {
                near = at;
                station.nodes[i] = Some((at, meeting.jet.r));
            }
        }
        station
    }

    /// Start parameters at a height, interpolated between two nodes, or those of a single node.
    fn near(&self, height: f64) -> Option<[f64; 3]> {
        let index = height * (HEIGHTS - 1) as f64;
        let before = index.floor().clamp(0.0, (HEIGHTS - 2) as f64);
        let node = |i: usize| self.nodes[i].map(|(at, _)| at);
        let (low, high) = (node(before as usize), node(before as usize + 1));
        let (Some(low), Some(high)) = (low, high) else {
            return low.or(high);
        };
        let share = index - before;
        Some(std::array::from_fn(|i| low[i] + share * (high[i] - low[i])))
    }

    /// Flank point at a height of the station, in the pinion frame; `near` are start parameters.
    fn point(
        &self,
        flank: &BevelFlank,
        height: f64,
        near: [f64; 3],
    ) -> Option<([f64; 3], MeshingState)> {
        let at = flank
            .envelope
            .intersect_circle(flank.section.at(self.face, height), near)?;
        Some((at, flank.envelope.meeting(at)?))
    }
}

/// Flank tangent with the axial-section components `[dz, dρ]`; `n·t = 0` gives the third component.
fn along_section(jet: &Jet, [dz, dr]: [f64; 2]) -> Vector {
    let rho = f64::hypot(jet.r.x, jet.r.y);
    let out = Vector::new(jet.r.x / rho, jet.r.y / rho, 0.0);
    let around = Vector::Z.cross(out);
    let in_section = Vector::Z * dz + out * dr;
    in_section - around * (jet.n.dot(in_section) / jet.n.dot(around))
}

/// Normal curvature of a flank along a unit tangent, 1/m.
fn curvature(meeting: &MeshingState, along: Vector) -> Option<f64> {
    Some(SecondOrder::of(meeting)?.envelope()?.normal(along))
}

/// Maximum of te between two heights by Newton's method on the slope within a bracket; at a bound if the slope points outwards.
fn maximise_te(
    bounds: [f64; 2],
    start: f64,
    gear: [f64; 3],
    evaluate: impl Fn(f64, [f64; 3]) -> Option<TrialPoint>,
) -> Option<TrialPoint> {
    let [mut low, mut high] = bounds;
    let mut trial = evaluate(start.clamp(low, high), gear)?;
    for _ in 0..STEPS {
        let h = trial.point.height;
        if trial.slope > 0.0 {
            low = h;
        } else {
            high = h;
        }
        if low >= bounds[1] || high <= bounds[0] {
            break;
        }
        let newton = h - trial.slope / trial.slope_rate;
        let next = match trial.slope_rate < 0.0 {
            true if low < newton && newton < high => newton,
            true if newton >= high && h < high => high,
            true if newton <= low && h > low => low,
            _ => 0.5 * (low + high),
        };
        let is_bound = next == bounds[0] || next == bounds[1];
        if (next - h).abs() <= LAST_STEP && !is_bound {
            trial.point.te += 0.5 * trial.slope * (next - h);
            break;
        }
        trial = evaluate(next, trial.gear())?;
    }
    Some(trial)
}
