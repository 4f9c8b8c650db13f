//! Undeformed chips of face-mill blades that cut a slot from the solid: chip area `A = ∫∫ dρ dζ` in the plane of a blade, the
//! intersection of the blade with the metal remaining after the preceding blades.
//!
//! The plane is divided into lines along the cutter axis, from the cutting edge into the blade. Each line is clipped to the blank and
//! to the outside of the preceding blade profiles, all convex there. A pass removes the volume `∫ A (ρ + x' v_θ) dθ`, with the
//! feed velocity `x' v_θ` of the work. Blades are trapezoids without edge radius, profile arc and Toprem.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::cutter_head::{BladeFeed, BladeOffset};
use crate::gear::bevel::cutter::Cutter;
use crate::gear::bevel::frames::{CutterFrame, WorkFrame};
use crate::gear::kernel::motion::{Motion, MotionState};
use crate::gear::kernel::pose::Transform;
use crate::gear::kernel::vector::Vector;

/// Number of lines over inside edge, tip and outside edge.
const LINES: [usize; 3] = [64, 24, 64];
/// Number of positions of a blade in a pass through the slot.
const POSITIONS: usize = 48;
/// Largest number of passes on either side of the middle of the roll: the limit of a face-mill load.
const MAX_PASSES: i64 = 1000;
/// Step of the search for the slot ends about the cutter axis, rad.
const SEARCH_STEP: f64 = 0.01;
/// Largest cradle angle from the middle of the flanks at which a blade cuts, rad.
const MAX_CRADLE_ANGLE: f64 = 2.0;
/// Smallest chip thickness along a line, m: rounding of positions on a machine.
const MIN_LENGTH: f64 = 1e-12;

/// Face-mill head that cuts both flanks of a slot, with the cutter motion and the blank.
#[derive(Debug, Clone)]
pub struct ChipCutter {
    /// Inside and outside point radius, m.
    radii: [f64; 2],
    /// Tangents of the inside and the outside blade angle.
    tangents: [f64; 2],
    motion: Motion<WorkFrame, CutterFrame>,
    /// Sides of the blank, `c_z z + c_ρ ρ = c₀`; left side minus right side is positive outside.
    blank: Vec<[f64; 3]>,
    /// Length of the blades, m.
    depth: f64,
    feed: BladeFeed,
    offsets: Vec<BladeOffset>,
    /// Reference cutter angle θ₀ of the passes, rad.
    start_angle: f64,
}

/// Undeformed chip of a blade at one position of its pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chip {
    /// Chip area in the plane of the blade, m².
    pub area: f64,
    /// Length of the cutting edge in contact, m.
    pub edge: f64,
    /// Volume removed per radian of the cutter, m³.
    pub volume: f64,
}

impl Chip {
    /// Mean chip thickness, m.
    pub fn thickness(&self) -> f64 {
        match self.edge > 0.0 {
            true => self.area / self.edge,
            false => 0.0,
        }
    }
}

/// Blade position in a pass, with its chip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChipPlace {
    /// Pass number, from 1.
    pub pass: usize,
    /// Blade index of the pass.
    pub blade: usize,
    /// Cradle angle, rad.
    pub cradle: f64,
    /// Rotation of the head from the first position of the first pass, rad.
    pub head: f64,
    /// Cutter angle from the slot centre, rad.
    pub theta: f64,
    /// The chip.
    pub chip: Chip,
}

/// Undeformed chips of a slot.
#[derive(Debug, Clone, PartialEq)]
pub struct Chips {
    /// Number of passes with a chip.
    pub passes: usize,
    /// Positions of each pass, from one before the first chip to one after the last.
    pub places: Vec<ChipPlace>,
    /// Removed volume, m³.
    pub volume: f64,
}

/// Reason for the absence of chips.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoChips {
    /// The inside point radius is not below the outside one.
    CrossedBlades,
    /// No blade intersects the blank in the middle of the roll.
    NotInBlank,
    /// Blades remain in the blank over the whole roll, or intersect the blank at every cutter angle.
    NeverLeaves,
    /// Feed per pass too small: more than a thousand passes on one side of the middle.
    TooManyPasses,
}

/// Plane of a blade at one position of its pass.
struct Plane {
    state: MotionState,
    theta: f64,
    offset: BladeOffset,
}

impl ChipCutter {
    /// Face-mill head from the cutters of the convex and of the concave flank.
    pub fn new(
        [inside, outside]: [&Cutter; 2],
        motion: Motion<WorkFrame, CutterFrame>,
        (blank, depth): (Vec<[f64; 3]>, f64),
        (feed, offsets): (BladeFeed, &[BladeOffset]),
        start_angle: f64,
    ) -> ChipCutter {
        ChipCutter {
            radii: [inside.point_radius, outside.point_radius],
            tangents: [inside.blade_angle.tan(), outside.blade_angle.tan()],
            motion,
            blank,
            depth,
            feed,
            offsets: offsets.to_vec(),
            start_angle,
        }
    }

    /// Chips of all passes of the roll, from the entry of the blades into the blank to their exit; unequal blades count over a full
    /// revolution of the head. `middle` is a cradle angle with a blade in the slot, rad.
    ///
    /// # Errors
    /// Reason for the absence of chips.
    pub fn chips(&self, middle: f64) -> Result<Chips, NoChips> {
        if self.radii[0] >= self.radii[1] {
            return Err(NoChips::CrossedBlades);
        }
        let [enter, leave] = self.slot(middle).ok_or(NoChips::NeverLeaves)?;
        let thetas: Vec<f64> = (0..POSITIONS)
            .map(|i| enter + (leave - enter) * (i as f64 + 0.5) / POSITIONS as f64)
            .collect();
        let first = (middle / self.cradle_at_start(1)).round() as i64;
        let (start, end) = (self.end(first, -1, &thetas)?, self.end(first, 1, &thetas)?);
        if end == start {
            return Err(NoChips::NotInBlank);
        }
        let blades = i64::from(self.feed.blades);
        let (mut positions, mut with_chips) = (Vec::<ChipPlace>::new(), 0);
        for pass in start + 1..end {
            let index = pass - start - 1;
            let place = |theta: &f64| ChipPlace {
                pass: index as usize + 1,
                blade: pass.rem_euclid(blades) as usize,
                cradle: self.cradle_angle(pass, *theta),
                head: index as f64 * TAU / blades as f64 + theta - enter,
                theta: theta - 0.5 * (enter + leave),
                chip: self.chip(pass, *theta),
            };
            let pass_positions: Vec<ChipPlace> = thetas.iter().map(place).collect();
            let has_chip = |p: &ChipPlace| p.chip.area > 0.0;
            let ends = (
                pass_positions.iter().position(has_chip),
                pass_positions.iter().rposition(has_chip),
            );
            if let (Some(first), Some(last)) = ends {
                positions.extend(&pass_positions[first.saturating_sub(1)..POSITIONS.min(last + 2)]);
                with_chips += 1;
            }
        }
        let step = (leave - enter) / POSITIONS as f64;
        Ok(Chips {
            passes: with_chips,
            volume: positions.iter().map(|p| p.chip.volume * step).sum(),
            places: positions,
        })
    }

    /// First pass from `first` on outside the blank; for unequal blades the first of a full revolution of the head outside.
    fn end(&self, first: i64, sense: i64, thetas: &[f64]) -> Result<i64, NoChips> {
        let count = (MAX_CRADLE_ANGLE / self.feed.step()) as i64;
        let mut missed = 0;
        for k in 0..count.min(MAX_PASSES) {
            let pass = first + sense * k;
            if thetas.iter().any(|theta| self.is_in_blank(pass, *theta)) {
                missed = 0;
                continue;
            }
            missed += 1;
            if missed == self.n_preceding() {
                return Ok(pass - sense * (missed - 1));
            }
        }
        Err(match count > MAX_PASSES {
            true => NoChips::TooManyPasses,
            false => NoChips::NeverLeaves,
        })
    }

    /// Undeformed chip of a pass at a cutter angle.
    pub fn chip(&self, pass: i64, theta: f64) -> Chip {
        let plane = self.plane(pass, theta);
        let preceding: Vec<(Plane, Transform)> = (1..=self.n_preceding())
            .map(|back| {
                let plane = self.plane(pass - back, theta);
                let inverse = plane.state.pose.inverse();
                (plane, inverse)
            })
            .collect();
        let mut chip = Chip {
            area: 0.0,
            edge: 0.0,
            volume: 0.0,
        };
        let (sin, cos) = theta.sin_cos();
        for (k, count) in LINES.into_iter().enumerate() {
            let ends = self.ends(k);
            for i in 0..count {
                let share = (i as f64 + 0.5) / count as f64;
                let lerp = |j: usize| ends[0][j] + share * (ends[1][j] - ends[0][j]);
                let (rho, tip) = (lerp(0) + plane.offset.radial, lerp(1) + plane.offset.axial);
                let on_line = |depth: f64| {
                    let p_cutter = Vector::new(rho * cos, rho * sin, tip - depth);
                    plane.state.pose.apply(p_cutter)
                };
                let length = self.metal(on_line, &preceding);
                if length <= MIN_LENGTH {
                    continue;
                }
                let width = (ends[1][0] - ends[0][0]) / count as f64;
                let edge = f64::hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]);
                let velocity = plane.state.velocity.at(on_line(0.0));
                let velocity = plane.state.pose.inverse().rotate(velocity);
                let feed = self.feed.drag() * (velocity.y * cos - velocity.x * sin);
                chip.area += width * length;
                chip.edge += edge / count as f64;
                chip.volume += width * length * (rho + feed);
            }
        }
        chip
    }

    /// Number of preceding passes that can bound a chip: one, or a revolution of the head for unequal blades.
    fn n_preceding(&self) -> i64 {
        match self.offsets.is_empty() {
            true => 1,
            false => i64::from(self.feed.blades),
        }
    }

    /// End points `[ρ, ζ]` of inside edge (0), tip (1) or outside edge (2), m.
    fn ends(&self, edge: usize) -> [[f64; 2]; 2] {
        let [inner, outer] = self.radii;
        let top = |k: usize| self.depth * self.tangents[k];
        match edge {
            0 => [[inner - top(0), -self.depth], [inner, 0.0]],
            1 => [[inner, 0.0], [outer, 0.0]],
            _ => [[outer, 0.0], [outer + top(1), -self.depth]],
        }
    }

    /// Length of a line within the metal, m.
    fn metal(&self, on_line: impl Fn(f64) -> Vector, preceding: &[(Plane, Transform)]) -> f64 {
        let clip = |limits: &dyn Fn(Vector) -> [f64; 3], count: usize, range: [f64; 2]| {
            let ends = range.map(|depth| limits(on_line(depth)));
            let mut interval = range;
            for i in 0..count {
                let [a, b] = [ends[0][i], ends[1][i]];
                if a > 0.0 && b > 0.0 {
                    return None;
                }
                if a <= 0.0 && b <= 0.0 {
                    continue;
                }
                let slope = (b - a) / (range[1] - range[0]);
                let secant = range[0] - a / slope;
                let end = secant - limits(on_line(secant))[i] / slope;
                match a > 0.0 {
                    true => interval[0] = interval[0].max(end),
                    false => interval[1] = interval[1].min(end),
                }
            }
            (interval[1] > interval[0]).then_some(interval)
        };
        let blank = |r: Vector| {
            let rho_point = f64::hypot(r.x, r.y);
            [0, 1, 2].map(|i| {
                let side = self.blank.get(i);
                side.map_or(-1.0, |[z, rho, c]| z * r.z + rho * rho_point - c)
            })
        };
        let Some(in_blank) = clip(&blank, 3, [0.0, self.depth]) else {
            return 0.0;
        };
        let mut intervals = vec![in_blank];
        for (plane, inverse) in preceding {
            let profile = |r: Vector| self.distances(plane, inverse, r);
            intervals = intervals
                .into_iter()
                .flat_map(|[a, b]| match clip(&profile, 3, [a, b]) {
                    Some([from, to]) => [[a, from], [to, b]],
                    None => [[a, b], [b, b]],
                })
                .filter(|[a, b]| b - a > MIN_LENGTH)
                .collect();
            if intervals.is_empty() {
                break;
            }
        }
        intervals.iter().map(|[a, b]| b - a).sum()
    }

    /// Signed distances of a work point outside the profile of a blade at the passage of that point: axially beyond the tip, radially
    /// beyond the inside edge and the outside edge, m.
    fn distances(&self, plane: &Plane, inverse: &Transform, r: Vector) -> [f64; 3] {
        let nominal = inverse.apply(r);
        let (sin, cos) = plane.theta.sin_cos();
        let angle = f64::atan2(
            nominal.y * cos - nominal.x * sin,
            nominal.x * cos + nominal.y * sin,
        );
        let cradle = self.feed.drag() * angle;
        // The cradle rolls on until the blade is at the point.
        let q = nominal - inverse.rotate(plane.state.velocity.at(r)) * cradle;
        let rho = f64::hypot(q.x, q.y) - plane.offset.radial;
        let zeta = q.z - plane.offset.axial;
        [
            zeta,
            self.radii[0] + zeta * self.tangents[0] - rho,
            rho - self.radii[1] + zeta * self.tangents[1],
        ]
    }

    /// True if the blade of a pass intersects the blank at a cutter angle.
    fn is_in_blank(&self, pass: i64, theta: f64) -> bool {
        let plane = self.plane(pass, theta);
        self.intersects_blank(&plane)
    }

    fn intersects_blank(&self, plane: &Plane) -> bool {
        let (sin, cos) = plane.theta.sin_cos();
        (0..LINES.len())
            .flat_map(|k| self.ends(k))
            .any(|[rho, tip]| {
                let point = |depth: f64| {
                    let p_cutter = Vector::new(rho * cos, rho * sin, tip - depth);
                    plane.state.pose.apply(p_cutter)
                };
                self.metal(point, &[]) > MIN_LENGTH
            })
    }

    /// Range of cutter angles with blade and blank in intersection at any cradle angle, rad.
    fn slot(&self, middle: f64) -> Option<[f64; 2]> {
        let step = self.feed.step().max(SEARCH_STEP);
        let count = (MAX_CRADLE_ANGLE / step) as i64;
        let is_cutting = |theta: f64| {
            (-count..=count).any(|k| {
                let cradle = middle + k as f64 * step;
                let plane = self.plane_at(cradle, theta, BladeOffset::default());
                self.intersects_blank(&plane)
            })
        };
        let n_angles = (FRAC_PI_2 / SEARCH_STEP) as i64;
        let end = |sense: f64| {
            let angles = (0..n_angles).map(|k| self.start_angle + sense * k as f64 * SEARCH_STEP);
            angles.into_iter().find(|theta| !is_cutting(*theta))
        };
        let ends = [end(-1.0)?, end(1.0)?];
        (ends[1] - ends[0] > 1.5 * SEARCH_STEP).then_some(ends)
    }

    fn plane(&self, pass: i64, theta: f64) -> Plane {
        let blade = pass.rem_euclid(i64::from(self.feed.blades)) as usize;
        let offset = self.offsets.get(blade).copied().unwrap_or_default();
        self.plane_at(self.cradle_angle(pass, theta), theta, offset)
    }

    fn plane_at(&self, cradle: f64, theta: f64, offset: BladeOffset) -> Plane {
        Plane {
            state: self.motion.at(cradle),
            theta,
            offset,
        }
    }

    /// Cradle angle at the passage of the cutter angle θ₀, rad.
    fn cradle_at_start(&self, pass: i64) -> f64 {
        pass as f64 * self.feed.cradle_per_turn / f64::from(self.feed.blades)
    }

    /// Cradle angle at the passage of a cutter angle, rad.
    fn cradle_angle(&self, pass: i64, theta: f64) -> f64 {
        self.cradle_at_start(pass) + self.feed.drag() * (theta - self.start_angle)
    }
}
