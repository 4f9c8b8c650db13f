//! Pairs that turn in space: one pitch of each member and the curves of contact of the moment.
//!
//! Both flanks of a tooth change places by half a turn about the line of centres: with one at the azimuth `θ(ρ, h)` the other is at
//! `δ − θ(ρ, −h)`.

use crate::gear::bevel::solid::Sector;
use crate::gear::kernel::vector::Vector;

/// Clearance at both roots, in working depths.
pub(super) const CLEARANCE: f64 = 0.1;
/// Positions in a pitch.
pub(super) const POSITIONS: u32 = 60;

/// A pair over one pitch, lengths in the unit of the input.
#[derive(Debug, Clone, PartialEq)]
pub struct TurningPair {
    /// Worm and wheel, or pinion and gear.
    pub members: [TurningMember; 2],
    /// The members touch along lines, else at points.
    pub is_line_contact: bool,
    /// Direction out of the flank of the first member, where there is one at all contacts.
    pub facing: Option<Vector>,
    /// Contact at equal steps over one pitch.
    pub positions: Vec<ContactPosition>,
}

/// A member that turns about the third of its axes.
#[derive(Debug, Clone, PartialEq)]
pub struct TurningMember {
    /// Number of teeth or starts.
    pub teeth: u32,
    /// One pitch in the axes of the member.
    pub sector: Sector,
    /// Directions of the axes at rest.
    pub axes: [Vector; 3],
    /// Their origin.
    pub centre: Vector,
}

/// Contact at an angle.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPosition {
    /// Angles of both members about their axes, rad.
    pub angles: [f64; 2],
    /// Curves of contact in space: lines, or outlines of ellipses.
    pub curves: Vec<Vec<Vector>>,
}

impl TurningPair {
    /// The pair itself, or its mirror image at the plane y = 0 where `hand` is negative.
    pub fn of_hand(mut self, hand: f64) -> TurningPair {
        if hand > 0.0 {
            return self;
        }
        let mirror = |v: Vector| Vector::new(v.x, -v.y, v.z);
        for member in &mut self.members {
            let [x, y, z] = member.axes.map(mirror);
            member.axes = [x, -y, z];
            member.centre = mirror(member.centre);
            member.sector.points.iter_mut().for_each(|p| p[1] = -p[1]);
            // A ring goes on to the next tooth at growing azimuth.
            let around = member.sector.points.len() / member.sector.rings;
            let rings = member.sector.points.chunks_mut(around);
            rings.for_each(<[_]>::reverse);
        }
        self.facing = self.facing.map(mirror);
        for position in &mut self.positions {
            position.angles = position.angles.map(|angle| -angle);
            let points = position.curves.iter_mut().flatten();
            points.for_each(|p| *p = mirror(*p));
        }
        self
    }
}

/// Teeth of a body of which one flank is given.
pub(super) struct Teeth<F, E> {
    /// Number of teeth or starts.
    pub count: u32,
    /// Azimuth of the flank at a radius and a height, rad.
    pub flank: F,
    /// δ, to whole pitches.
    pub opposite_flank: f64,
    /// 1 where the tooth lies at azimuths above the flank, otherwise −1.
    pub sense: f64,
    /// Radii of root and tip at a height.
    pub ends: E,
    /// Radius of the bore.
    pub bore: f64,
    /// Width of the body.
    pub width: f64,
    /// Steps along the width, along the flank, and of a land.
    pub steps: [usize; 3],
}

/// Bisections of the radius at which a flank begins.
const BISECTIONS: usize = 40;

impl<F: Fn(f64, f64) -> Option<f64>, E: Fn(f64) -> [f64; 2]> Teeth<F, E> {
    /// One pitch of the body; none where the flank does not reach the tip, or the tooth is pointed or fills the pitch.
    pub fn sector(&self) -> Option<Sector> {
        let [slices, rows, land] = self.steps;
        let pitch = std::f64::consts::TAU / f64::from(self.count);
        let height = |slice: usize| self.width * (slice as f64 / slices as f64 - 0.5);
        let mut points = Vec::new();
        let mut shift = None;
        for h in (0..=slices).map(height) {
            let [root, tip] = (self.ends)(h);
            let [own, other] = [self.side(h, [root, tip])?, self.side(-h, [root, tip])?];
            let other: Vec<f64> = other.iter().map(|a| self.opposite_flank - a).collect();
            // The tooth is the part of a pitch behind the flank, chosen once.
            let middle = rows / 2;
            let from = *shift.get_or_insert_with(|| {
                let wide = self.sense * (other[middle] - own[middle]);
                self.sense * (wide.rem_euclid(pitch) - wide)
            });
            let other: Vec<f64> = other.iter().map(|a| a + from).collect();
            let (low, high) = if self.sense > 0.0 {
                (own, other)
            } else {
                (other, own)
            };
            let last = low.len() - 1;
            if high[last] < low[last] || low[0] + pitch < high[0] {
                return None;
            }
            let radius = |row: usize| root + (tip - root) * row as f64 / rows as f64;
            let lands = |from: f64, to: f64, radius: f64| {
                let parts = land + 1;
                (1..parts).map(move |k| (radius, from + (to - from) * k as f64 / parts as f64))
            };
            let ring = (low.iter().enumerate())
                .map(|(row, a)| (radius(row), *a))
                .chain(lands(low[last], high[last], tip))
                .chain(
                    high.iter()
                        .enumerate()
                        .rev()
                        .map(|(row, a)| (radius(row), *a)),
                )
                .chain(lands(high[0], low[0] + pitch, root));
            points.extend(ring.map(|(r, a)| [r * a.cos(), r * a.sin(), h]));
        }
        // The bore, from the last ring back to the first.
        let around = points.len() / (slices + 1);
        for first in [slices * around, 0] {
            for k in first..first + around {
                let [x, y, h] = points[k];
                let share = self.bore / x.hypot(y);
                points.push([share * x, share * y, h]);
            }
        }
        Some(Sector {
            points,
            rings: slices + 3,
        })
    }

    /// Azimuths of the flank at a height from root to tip; below the radius at which it begins it goes on along a radius.
    fn side(&self, h: f64, [root, tip]: [f64; 2]) -> Option<Vec<f64>> {
        let at = |radius: f64| (self.flank)(radius, h);
        let mut bottom = root;
        if at(root).is_none() {
            let (mut missing, mut found) = (root, tip);
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (missing + found);
                match at(middle) {
                    Some(_) => found = middle,
                    None => missing = middle,
                }
            }
            bottom = found;
        }
        let rows = self.steps[1];
        (0..=rows)
            .map(|row| at((root + (tip - root) * row as f64 / rows as f64).max(bottom)))
            .collect()
    }
}
