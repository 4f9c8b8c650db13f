//! Undeformed chips of the blades that cut a slot from the solid: in the plane of a blade the area `A = ∫∫ dρ dζ` of the metal that the
//! blade meets and the blades before it left.
//!
//! The plane is cut into lines along the cutter's axis, each from the blade's edge into its body. Of each line remains what lies within the
//! blank and outside the profiles of the blades before, all of them convex there. A pass removes `∫ A (ρ + x' v_θ) dθ`, `x' v_θ` being how
//! the work comes towards the blade. Blades are trapezoids: edge radius, profile arc and Toprem have no part.

use std::f64::consts::{FRAC_PI_2, TAU};

use super::cutter_head::{BladeFeed, BladeOffset};
use crate::gear::bevel::cutter::Cutter;
use crate::gear::bevel::frames::{CutterFrame, WorkFrame};
use crate::gear::kernel::motion::{Motion, MotionState};
use crate::gear::kernel::pose::Transform;
use crate::gear::kernel::vector::Vector;

/// Lines over each of the inside edge, the tip and the outside edge.
const LINES: [usize; 3] = [64, 24, 64];
/// Places of a blade while it crosses the slot.
const PLACES: usize = 48;
/// Most passes to either side of the middle of the roll: a face-mill load reads as many.
const MAX_PASSES: i64 = 1000;
/// Step at which the ends of the slot are sought round the cutter, rad.
const SEARCH: f64 = 0.01;
/// Furthest turn of the cradle from the middle of the flanks at which a blade may still cut, rad.
const FURTHEST: f64 = 2.0;
/// Least length of a line that counts as a chip, m: rounding of places on a machine.
const LEAST: f64 = 1e-12;

/// The blades of a head that cuts both flanks of a slot, the motion of the cutter and the blank.
#[derive(Debug, Clone)]
pub struct ChipCutter {
    /// Inside and outside point radius, m.
    radii: [f64; 2],
    /// Tangents of the inside and the outside blade angle.
    tangents: [f64; 2],
    motion: Motion<WorkFrame, CutterFrame>,
    /// Sides of the blank, `c_z z + c_ρ ρ = c₀`, the left less the right positive outside.
    blank: Vec<[f64; 3]>,
    /// Length of the blades, m.
    depth: f64,
    feed: BladeFeed,
    offsets: Vec<BladeOffset>,
    /// Cutter angle at which passes are counted, rad.
    start_angle: f64,
}

/// The chip of a blade at one place of its pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chip {
    /// Area in the plane of the blade, m².
    pub area: f64,
    /// Length of the edge that cuts, m.
    pub edge: f64,
    /// Volume removed for each radian of the cutter, m³.
    pub volume: f64,
}

impl Chip {
    /// Mean thickness, m.
    pub fn thickness(&self) -> f64 {
        match self.edge > 0.0 {
            true => self.area / self.edge,
            false => 0.0,
        }
    }
}

/// A place of a pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChipPlace {
    /// The pass, from 1.
    pub pass: usize,
    /// Blade of the pass.
    pub blade: usize,
    /// Turn of the cradle, rad.
    pub cradle: f64,
    /// Turn of the head from the first place of the first pass, rad.
    pub head: f64,
    /// Cutter angle from the middle of the slot, rad.
    pub theta: f64,
    /// The chip.
    pub chip: Chip,
}

/// The chips of a slot.
#[derive(Debug, Clone, PartialEq)]
pub struct Chips {
    /// Passes that cut a chip.
    pub passes: usize,
    /// Places pass by pass, from one before the first chip to one behind the last.
    pub places: Vec<ChipPlace>,
    /// Volume that they remove, m³.
    pub volume: f64,
}

/// Why there are no chips.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoChips {
    /// The inside point radius is not below the outside one.
    CrossedBlades,
    /// No blade reaches the blank in the middle of the roll.
    NotInBlank,
    /// The roll does not carry the blades out of the blank, or they meet it all round the cutter.
    NeverLeaves,
    /// The feed is so slow that more than a thousand passes lie to one side of the middle.
    TooManyPasses,
}

/// A blade at one place: lines are cut in its plane.
struct Plane {
    state: MotionState,
    theta: f64,
    offset: BladeOffset,
}

impl ChipCutter {
    /// A head by the cutters of the convex and the concave flank.
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

    /// All passes while the cradle rolls from where the blades reach the blank to where they leave it; where blades differ, for a whole turn
    /// of the head. `middle` is a turn of the cradle at which a blade is in the slot, rad.
    ///
    /// # Errors
    /// The reason why there are none.
    pub fn chips(&self, middle: f64) -> Result<Chips, NoChips> {
        if self.radii[0] >= self.radii[1] {
            return Err(NoChips::CrossedBlades);
        }
        let [from, to] = self.slot(middle).ok_or(NoChips::NeverLeaves)?;
        let thetas: Vec<f64> = (0..PLACES)
            .map(|i| from + (to - from) * (i as f64 + 0.5) / PLACES as f64)
            .collect();
        let first = (middle / self.turn_of(1)).round() as i64;
        let (start, end) = (self.end(first, -1, &thetas)?, self.end(first, 1, &thetas)?);
        if end == start {
            return Err(NoChips::NotInBlank);
        }
        let blades = i64::from(self.feed.blades);
        let (mut all, mut with_chips) = (Vec::<ChipPlace>::new(), 0);
        for pass in start + 1..end {
            let before = pass - start - 1;
            let place = |theta: &f64| ChipPlace {
                pass: before as usize + 1,
                blade: pass.rem_euclid(blades) as usize,
                cradle: self.turn(pass, *theta),
                head: before as f64 * TAU / blades as f64 + theta - from,
                theta: theta - 0.5 * (from + to),
                chip: self.chip(pass, *theta),
            };
            let places: Vec<ChipPlace> = thetas.iter().map(place).collect();
            let has_chip = |p: &ChipPlace| p.chip.area > 0.0;
            let ends = (
                places.iter().position(has_chip),
                places.iter().rposition(has_chip),
            );
            if let (Some(first), Some(last)) = ends {
                all.extend(&places[first.saturating_sub(1)..PLACES.min(last + 2)]);
                with_chips += 1;
            }
        }
        let step = (to - from) / PLACES as f64;
        Ok(Chips {
            passes: with_chips,
            volume: all.iter().map(|p| p.chip.volume * step).sum(),
            places: all,
        })
    }

    /// The first pass from `first` on that misses the blank; where blades differ, of a whole turn of the head that does.
    fn end(&self, first: i64, way: i64, thetas: &[f64]) -> Result<i64, NoChips> {
        let most = (FURTHEST / self.feed.step()) as i64;
        let mut missed = 0;
        for k in 0..most.min(MAX_PASSES) {
            let pass = first + way * k;
            if thetas.iter().any(|theta| self.meets(pass, *theta)) {
                missed = 0;
                continue;
            }
            missed += 1;
            if missed == self.passes_back() {
                return Ok(pass - way * (missed - 1));
            }
        }
        Err(match most > MAX_PASSES {
            true => NoChips::TooManyPasses,
            false => NoChips::NeverLeaves,
        })
    }

    /// The chip of a pass at a cutter angle.
    pub fn chip(&self, pass: i64, theta: f64) -> Chip {
        let plane = self.plane(pass, theta);
        let before: Vec<(Plane, Transform)> = (1..=self.passes_back())
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
                let at = |j: usize| ends[0][j] + share * (ends[1][j] - ends[0][j]);
                let (rho, tip) = (at(0) + plane.offset.radial, at(1) + plane.offset.axial);
                let on_line = |down: f64| {
                    let moved = Vector::new(rho * cos, rho * sin, tip - down);
                    plane.state.pose.apply(moved)
                };
                let left = self.metal(on_line, &before);
                if left <= LEAST {
                    continue;
                }
                let wide = (ends[1][0] - ends[0][0]) / count as f64;
                let long = f64::hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]);
                let velocity = plane.state.velocity.at(on_line(0.0));
                let velocity = plane.state.pose.inverse().rotate(velocity);
                let towards = self.feed.drag() * (velocity.y * cos - velocity.x * sin);
                chip.area += wide * left;
                chip.edge += long / count as f64;
                chip.volume += wide * left * (rho + towards);
            }
        }
        chip
    }

    /// Passes back whose blades may have left less than the one before: a turn of the head where blades differ.
    fn passes_back(&self) -> i64 {
        match self.offsets.is_empty() {
            true => 1,
            false => i64::from(self.feed.blades),
        }
    }

    /// Ends `[ρ, ζ]` of inside edge, tip and outside edge.
    fn ends(&self, part: usize) -> [[f64; 2]; 2] {
        let [inner, outer] = self.radii;
        let top = |k: usize| self.depth * self.tangents[k];
        match part {
            0 => [[inner - top(0), -self.depth], [inner, 0.0]],
            1 => [[inner, 0.0], [outer, 0.0]],
            _ => [[outer, 0.0], [outer + top(1), -self.depth]],
        }
    }

    /// Length of a line that is metal, m.
    fn metal(&self, on_line: impl Fn(f64) -> Vector, before: &[(Plane, Transform)]) -> f64 {
        let inside = |limits: &dyn Fn(Vector) -> [f64; 3], count: usize, range: [f64; 2]| {
            let ends = range.map(|down| limits(on_line(down)));
            let mut kept = range;
            for i in 0..count {
                let [a, b] = [ends[0][i], ends[1][i]];
                if a > 0.0 && b > 0.0 {
                    return None;
                }
                if a <= 0.0 && b <= 0.0 {
                    continue;
                }
                let slope = (b - a) / (range[1] - range[0]);
                let straight = range[0] - a / slope;
                let end = straight - limits(on_line(straight))[i] / slope;
                match a > 0.0 {
                    true => kept[0] = kept[0].max(end),
                    false => kept[1] = kept[1].min(end),
                }
            }
            (kept[1] > kept[0]).then_some(kept)
        };
        let blank = |r: Vector| {
            let place = f64::hypot(r.x, r.y);
            [0, 1, 2].map(|i| {
                let side = self.blank.get(i);
                side.map_or(-1.0, |[z, rho, c]| z * r.z + rho * place - c)
            })
        };
        let Some(whole) = inside(&blank, 3, [0.0, self.depth]) else {
            return 0.0;
        };
        let mut left = vec![whole];
        for (plane, inverse) in before {
            let profile = |r: Vector| self.beyond(plane, inverse, r);
            left = left
                .into_iter()
                .flat_map(|[a, b]| match inside(&profile, 3, [a, b]) {
                    Some([from, to]) => [[a, from], [to, b]],
                    None => [[a, b], [b, b]],
                })
                .filter(|[a, b]| b - a > LEAST)
                .collect();
            if left.is_empty() {
                break;
            }
        }
        left.iter().map(|[a, b]| b - a).sum()
    }

    /// Radial excess of a point of the work beyond inside and outside edge of a blade as it crosses that point, and its height above the tip,
    /// tip first, m.
    fn beyond(&self, plane: &Plane, inverse: &Transform, r: Vector) -> [f64; 3] {
        let nominal = inverse.apply(r);
        let (sin, cos) = plane.theta.sin_cos();
        let ahead = f64::atan2(
            nominal.y * cos - nominal.x * sin,
            nominal.x * cos + nominal.y * sin,
        );
        let late = self.feed.drag() * ahead;
        // The cradle rolls on until the blade is there.
        let q = nominal - inverse.rotate(plane.state.velocity.at(r)) * late;
        let rho = f64::hypot(q.x, q.y) - plane.offset.radial;
        let zeta = q.z - plane.offset.axial;
        [
            zeta,
            self.radii[0] + zeta * self.tangents[0] - rho,
            rho - self.radii[1] + zeta * self.tangents[1],
        ]
    }

    /// Whether the blade of a pass reaches into the blank at a cutter angle.
    fn meets(&self, pass: i64, theta: f64) -> bool {
        let plane = self.plane(pass, theta);
        self.reaches(&plane)
    }

    fn reaches(&self, plane: &Plane) -> bool {
        let (sin, cos) = plane.theta.sin_cos();
        (0..LINES.len())
            .flat_map(|k| self.ends(k))
            .any(|[rho, tip]| {
                let point = |down: f64| {
                    let at = Vector::new(rho * cos, rho * sin, tip - down);
                    plane.state.pose.apply(at)
                };
                self.metal(point, &[]) > LEAST
            })
    }

    /// Cutter angles between which blades meet the blank at some turn of the cradle.
    fn slot(&self, middle: f64) -> Option<[f64; 2]> {
        let step = self.feed.step().max(SEARCH);
        let count = (FURTHEST / step) as i64;
        let meets = |theta: f64| {
            (-count..=count).any(|k| {
                let turn = middle + k as f64 * step;
                let plane = self.plane_at(turn, theta, BladeOffset::default());
                self.reaches(&plane)
            })
        };
        let most = (FRAC_PI_2 / SEARCH) as i64;
        let end = |way: f64| {
            let angles = (0..most).map(|k| self.start_angle + way * k as f64 * SEARCH);
            angles.into_iter().find(|theta| !meets(*theta))
        };
        let ends = [end(-1.0)?, end(1.0)?];
        (ends[1] - ends[0] > 1.5 * SEARCH).then_some(ends)
    }

    fn plane(&self, pass: i64, theta: f64) -> Plane {
        let blade = pass.rem_euclid(i64::from(self.feed.blades)) as usize;
        let offset = self.offsets.get(blade).copied().unwrap_or_default();
        self.plane_at(self.turn(pass, theta), theta, offset)
    }

    fn plane_at(&self, turn: f64, theta: f64, offset: BladeOffset) -> Plane {
        Plane {
            state: self.motion.at(turn),
            theta,
            offset,
        }
    }

    /// Turn of the cradle as a pass crosses the cutter angle θ₀.
    fn turn_of(&self, pass: i64) -> f64 {
        pass as f64 * self.feed.cradle_per_turn / f64::from(self.feed.blades)
    }

    /// Turn of the cradle as a pass crosses a cutter angle.
    fn turn(&self, pass: i64, theta: f64) -> f64 {
        self.turn_of(pass) + self.feed.drag() * (theta - self.start_angle)
    }
}
