//! The flank that discrete blades leave: every point of the ideal flank keeps the least distance along its normal over the facets of the
//! passes near it.
//!
//! A pass of a blade sweeps the facet `r(u, θ, x_k + drag (θ − θ₀))`, because the cradle rolls on while the blade crosses. Between two
//! passes Δx apart a scallop of the height `h = |D| Δx²/8` is left: contact lines lie `D Δx/|p|` apart and the relative curvature across
//! them is `|p|²/D`, D and p of `SecondOrder`.

use super::angle_errors::{self, AngleErrors};
use super::cutter_head::{BladeFeed, BladeOffset};
use crate::gear::bevel::cutter::{BladeSurface, BladeSurfaces, Cutter};
use crate::gear::bevel::flank::BLADE_DEPTHS;
use crate::gear::bevel::frames::{CutterFrame, WorkFrame};
use crate::gear::bevel::settings::MachineSettings;
use crate::gear::hand::Hand;
use crate::gear::kernel::envelope::FlankPoint;
use crate::gear::kernel::jet::Surface;
use crate::gear::kernel::law::Law;
use crate::gear::kernel::motion::Motion;
use crate::gear::kernel::newton::newton;
use crate::gear::kernel::root::sign_change;
use crate::gear::kernel::second_order::SecondOrder;
use crate::gear::kernel::vector::Vector;

/// Most passes each way that a point is compared with; where more may reach it, near an undercut limit, the point is left out.
const MOST_PASSES: f64 = 500.0;
/// Room for the change of D over the passes that reach a point.
const REACH_ROOM: f64 = 1.3;
/// Phases of a mean over a scallop: the mean of its parabola is off by at most 4 % of its height, 1/(3 · 3²).
const PHASES: usize = 3;
/// A facet this far beyond the end of a blade, in lengths of it, is on it.
const ON_BLADE: f64 = 1e-9;

/// Height of the scallop between passes `step` apart, `|D| Δx²/8`.
pub fn scallop_height(point: &SecondOrder, step: f64) -> f64 {
    point.undercut.abs() * step * step / 8.0
}

/// The conditions of a cut.
#[derive(Debug, Clone)]
pub struct CutConditions {
    /// Feed of the roll.
    pub feed: BladeFeed,
    /// Offsets of the blades, as many as there are blades; none of a true head.
    pub offsets: Vec<BladeOffset>,
    /// Angle errors of the generator.
    pub errors: AngleErrors,
}

impl CutConditions {
    /// A true head on a true generator.
    pub fn regular(feed: BladeFeed) -> CutConditions {
        CutConditions {
            feed,
            offsets: Vec::new(),
            errors: AngleErrors::default(),
        }
    }
}

/// The passes of the blades of a head over a tooth space.
///
/// Pass k is blade `k mod N`; it crosses the cutter angle θ₀ where the cradle has the turn `x_k = (k + phase) · cradle_per_turn/N`.
#[derive(Debug, Clone)]
pub struct BladePasses {
    blades: Vec<BladeSurfaces>,
    offsets: Vec<BladeOffset>,
    motion: Motion<WorkFrame, CutterFrame>,
    cutter_error: Option<Law>,
    /// Bounds of the errors of cradle and work, rad.
    bounds: [f64; 2],
    feed: BladeFeed,
    start_angle: f64,
}

/// A point of the flank as it is cut.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutPoint {
    /// Distance from the ideal flank along its normal, m: positive where metal is left.
    pub deviation: f64,
    /// The pass that finishes it.
    pub pass: i64,
    /// Blade of that pass.
    pub blade: usize,
}

impl BladePasses {
    /// The passes of a cutter at the settings of a machine; `start_angle` is the cutter angle θ₀ at which passes are counted, and
    /// `depth` the depth of the tooth.
    pub fn new(
        (cutter, settings, hand): (&Cutter, &MachineSettings, Hand),
        depth: f64,
        start_angle: f64,
        conditions: &CutConditions,
    ) -> BladePasses {
        let CutConditions {
            feed,
            offsets,
            errors,
        } = conditions;
        let offset = |blade: usize| offsets.get(blade).copied().unwrap_or_default();
        let offsets: Vec<BladeOffset> = (0..feed.blades as usize).map(offset).collect();
        let surfaces = cutter.surfaces(BLADE_DEPTHS * depth);
        BladePasses {
            blades: offsets.iter().map(|offset| surfaces.at(*offset)).collect(),
            offsets,
            motion: settings.motion_with_errors(hand, errors.laws()),
            cutter_error: angle_errors::law(&errors.cutter),
            bounds: [&errors.cradle, &errors.work].map(|e| angle_errors::bound(e)),
            feed: *feed,
            start_angle,
        }
    }

    /// A point of the ideal flank as the passes cut it; `phase` moves all of them, in shares of a pass. None where no blade reaches it
    /// and near an undercut limit.
    pub fn cut(&self, point: &FlankPoint<WorkFrame>, phase: f64) -> Option<CutPoint> {
        if self.blades.is_empty() {
            return None;
        }
        let passes = match self.motion.is_fixed() {
            true => 0..=self.blades.len() as i64 - 1,
            false => {
                let middle = self.turn_at_start(point) / self.turn_of(1.0) - phase;
                let reach = self.reach(point)?;
                (middle - reach).floor() as i64..=(middle + reach).ceil() as i64
            }
        };
        let cuts = passes.filter_map(|pass| {
            let blade = pass.rem_euclid(self.blades.len() as i64) as usize;
            Some(CutPoint {
                deviation: self.facet(blade, self.turn_of(pass as f64 + phase), point)?,
                pass,
                blade,
            })
        });
        cuts.min_by(|a, b| a.deviation.total_cmp(&b.deviation))
    }

    /// Mean deviation over the scallop that follows a phase, m: waves shorter than a contact is wide act by their mean. None as of `cut`.
    pub fn mean_deviation(&self, point: &FlankPoint<WorkFrame>, phase: f64) -> Option<f64> {
        let phase = |i: usize| phase + (i as f64 + 0.5) / PHASES as f64;
        let cuts = (0..PHASES).map(|i| Some(self.cut(point, phase(i))?.deviation));
        Some(cuts.sum::<Option<f64>>()? / PHASES as f64)
    }

    /// The highest scallop at a point over all phases of the passes, m: where the facets of two neighbouring passes of the first blade
    /// meet on its normal. 0 where the work does not roll.
    pub fn scallop(&self, point: &FlankPoint<WorkFrame>) -> Option<f64> {
        if self.motion.is_fixed() {
            return Some(0.0);
        }
        let facet = |share: f64| self.facet(0, self.turn_near(point, share), point);
        let share = sign_change([-1.0, 0.0], |share| {
            Some(facet(share)? - facet(share + 1.0)?)
        })?;
        facet(share)
    }

    /// Whether the passes next to that of a point touch its normal above Toprem and edge, so that the law of scallops counts there.
    pub fn is_of_blade(&self, point: &FlankPoint<WorkFrame>) -> bool {
        let Some(surfaces) = self.blades.first() else {
            return false;
        };
        let [from, _] = surfaces.blade.range();
        [-1.0, 1.0].into_iter().all(|share| {
            let turn = self.turn_near(point, share);
            let met = self.ray(&surfaces.blade, point.at[0], turn, point);
            met.is_some_and(|(u, _)| u >= from)
        })
    }

    /// Turn of the cradle at θ₀ of a pass so many blades after the one that would touch a point.
    fn turn_near(&self, point: &FlankPoint<WorkFrame>, blades: f64) -> f64 {
        self.turn_at_start(point) + blades * self.feed.step()
    }

    /// Distance of the facet of a blade along the normal of a point, `turn` being that of the cradle as the blade crosses θ₀.
    pub fn facet(&self, blade: usize, turn: f64, point: &FlankPoint<WorkFrame>) -> Option<f64> {
        let surfaces = self.blades.get(blade)?;
        let [from, to] = surfaces.blade.range();
        let (u, distance) = self.ray(&surfaces.blade, point.at[0], turn, point)?;
        let room = ON_BLADE * (to - from);
        let on_blade = (from - room <= u && u <= to + room).then_some(distance);
        // Blade and Toprem meet in a hollow corner, about which both may lie on the normal.
        let is_below = u < from - room || surfaces.toprem.is_some();
        let below = surfaces.toprem.iter().chain(&surfaces.edge);
        let below = below.filter(|_| is_below).filter_map(|part| {
            let [first, last] = part.range();
            let (u, distance) = self.ray(part, 0.5 * (first + last), turn, point)?;
            (first <= u && u <= last).then_some(distance)
        });
        let facets = on_blade.into_iter().chain(below);
        facets.min_by(f64::total_cmp)
    }

    /// u and distance at which the normal of a point meets the surface of a blade.
    fn ray(
        &self,
        surface: &BladeSurface,
        u: f64,
        turn: f64,
        point: &FlankPoint<WorkFrame>,
    ) -> Option<(f64, f64)> {
        let (from, along) = (point.point.coordinates, point.normal.components);
        let (drag, [su, st]) = (self.drag(), surface.scales());
        let start = [u, point.at[1], 0.0];
        let found = newton(start, [su, st, su], |[u, theta, d]| {
            let nominal = turn + drag * (theta - self.start_angle);
            let late = self.cutter_error.as_ref().map_or(0.0, |e| e.at(nominal)[0]);
            let state = self.motion.at(nominal - drag * late);
            let jet = surface.jet([u, theta])?.moved(&state.pose);
            let off = (jet.r - from - along * d).array();
            let by_theta = jet.dr[1] + state.velocity.at(jet.r) * drag;
            let columns = [jet.dr[0], by_theta, -along].map(Vector::array);
            Some((off, [0, 1, 2].map(|i| columns.map(|c| c[i]))))
        });
        found.map(|[u, _, d]| (u, d))
    }

    /// Turn of the cradle while a blade moves on by a radian; 0 where it does not roll.
    fn drag(&self) -> f64 {
        match self.motion.is_fixed() {
            true => 0.0,
            false => self.feed.drag(),
        }
    }

    /// Turn of the cradle as a pass, or a place between passes, crosses θ₀.
    fn turn_of(&self, pass: f64) -> f64 {
        pass * self.feed.cradle_per_turn / f64::from(self.feed.blades)
    }

    /// Turn of the cradle at θ₀ of the pass that would touch a point.
    fn turn_at_start(&self, point: &FlankPoint<WorkFrame>) -> f64 {
        let [_, theta, x] = point.at;
        x - self.drag() * (theta - self.start_angle)
    }

    /// Passes each way that may cut deepest at a point: `|D| x²/2` is made up by run-out and errors. The blade that stands out most
    /// returns after a turn.
    fn reach(&self, point: &FlankPoint<WorkFrame>) -> Option<f64> {
        let error = self.error_spread(point);
        let spread = error + self.offset_spread(point);
        let turn = REACH_ROOM * (2.0 * spread / point.second_order.undercut.abs()).sqrt();
        let passes = 1.0 + turn / self.feed.step();
        let passes = match error > 0.0 {
            true => passes,
            false => passes.min(1.0 + f64::from(self.feed.blades)),
        };
        (passes <= MOST_PASSES).then_some(passes)
    }

    /// Difference between the deepest and the shallowest blade along the normal of a point, m.
    fn offset_spread(&self, point: &FlankPoint<WorkFrame>) -> f64 {
        let cutter_from_work = self.motion.at(point.at[2]).pose.inverse();
        let n = cutter_from_work.rotate(point.normal.components);
        let (sin, cos) = point.at[1].sin_cos();
        let along = |o: &BladeOffset| o.radial * (n.x * cos + n.y * sin) + o.axial * n.z;
        let along = self.offsets.iter().map(along);
        let ends = along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], e| {
            [low.min(e), high.max(e)]
        });
        (ends[1] - ends[0]).max(0.0)
    }

    /// Bound of the difference that errors of cradle and work make between two passes along the normal of a point, m.
    fn error_spread(&self, point: &FlankPoint<WorkFrame>) -> f64 {
        // The axis of the cradle passes near the apex of the work.
        let [cradle, work] = self.bounds;
        2.0 * (work * angle_lever(point).abs() + cradle * point.point.coordinates.norm())
    }
}

/// `n·(k×r)`: normal displacement of a point of the flank for a radian of the work about its axis k, m. A small error ε of the work
/// moves the flank it cuts by `n·(k×r) ε`.
pub fn angle_lever(point: &FlankPoint<WorkFrame>) -> f64 {
    let (r, n) = (point.point.coordinates, point.normal.components);
    n.dot(Vector::Z.cross(r))
}
