//! Flank cut by discrete blades: the deviation of a point of the ideal flank is the smallest distance along its normal to the facets of the
//! nearest passes.
//!
//! A pass of a blade sweeps the facet `r(u, θ, x_k + drag (θ − θ₀))`, because the cradle rolls on during the pass. Two passes Δx apart
//! form a scallop of the height `h = |D| Δx²/8`: the spacing of contact lines is `D Δx/|p|` and the relative curvature across
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

/// Largest number of passes on either side of a point; a point near an undercut limit with more is excluded.
const MAX_PASSES: f64 = 500.0;
/// Safety factor for the change of D over the passes at a point.
const PASS_MARGIN: f64 = 1.3;
/// Number of phases of a mean over a scallop: error of the mean at most 4 % of the height, 1/(3 · 3²).
const PHASES: usize = 3;
/// Tolerance of the blade ends, in blade lengths.
const ON_BLADE: f64 = 1e-9;

/// Scallop height `|D| Δx²/8`, m, for passes with the cradle feed `step`, rad.
pub fn scallop_height(point: &SecondOrder, step: f64) -> f64 {
    point.undercut.abs() * step * step / 8.0
}

/// Cutting conditions: feed, blade offsets, generator errors.
#[derive(Debug, Clone)]
pub struct CutConditions {
    /// Feed of the roll.
    pub feed: BladeFeed,
    /// Offset of each blade; empty for a head without run-out.
    pub offsets: Vec<BladeOffset>,
    /// Angle errors of the generator.
    pub errors: AngleErrors,
}

impl CutConditions {
    /// Cutting conditions without blade offsets and generator errors.
    pub fn regular(feed: BladeFeed) -> CutConditions {
        CutConditions {
            feed,
            offsets: Vec::new(),
            errors: AngleErrors::default(),
        }
    }
}

/// Passes of the blades of a cutter head through a tooth space.
///
/// Pass k belongs to blade `k mod N` and crosses the cutter angle θ₀ at the cradle angle `x_k = (k + phase) · cradle_per_turn/N`.
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

/// Deviation of a flank point with the pass that finishes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutPoint {
    /// Distance from the ideal flank along its normal, m; positive: excess metal.
    pub deviation: f64,
    /// Number of the finishing pass.
    pub pass: i64,
    /// Blade index of that pass.
    pub blade: usize,
}

impl BladePasses {
    /// Blade passes of a cutter at machine settings; `start_angle` is the reference cutter angle θ₀ of the passes, and
    /// `depth` the tooth depth, m.
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

    /// Cut point at a point of the ideal flank; `phase` shifts all passes, in shares of a pass. `None` for a point outside all facets
    /// or near an undercut limit.
    pub fn cut(&self, point: &FlankPoint<WorkFrame>, phase: f64) -> Option<CutPoint> {
        if self.blades.is_empty() {
            return None;
        }
        let passes = match self.motion.is_fixed() {
            true => 0..=self.blades.len() as i64 - 1,
            false => {
                let middle = self.cradle_at_start(point) / self.cradle_at(1.0) - phase;
                let range = self.pass_range(point)?;
                (middle - range).floor() as i64..=(middle + range).ceil() as i64
            }
        };
        let cuts = passes.filter_map(|pass| {
            let blade = pass.rem_euclid(self.blades.len() as i64) as usize;
            Some(CutPoint {
                deviation: self.facet(blade, self.cradle_at(pass as f64 + phase), point)?,
                pass,
                blade,
            })
        });
        cuts.min_by(|a, b| a.deviation.total_cmp(&b.deviation))
    }

    /// Mean deviation over one scallop from a phase on, m: waves shorter than the contact width act by their mean. `None` as for `cut`.
    pub fn mean_deviation(&self, point: &FlankPoint<WorkFrame>, phase: f64) -> Option<f64> {
        let phase = |i: usize| phase + (i as f64 + 0.5) / PHASES as f64;
        let cuts = (0..PHASES).map(|i| Some(self.cut(point, phase(i))?.deviation));
        Some(cuts.sum::<Option<f64>>()? / PHASES as f64)
    }

    /// Largest scallop height at a point over all phases of the passes, m: intersection of the facets of two neighbouring passes of the
    /// first blade on the normal. 0 without generating roll.
    pub fn scallop(&self, point: &FlankPoint<WorkFrame>) -> Option<f64> {
        if self.motion.is_fixed() {
            return Some(0.0);
        }
        let facet = |share: f64| self.facet(0, self.cradle_near(point, share), point);
        let share = sign_change([-1.0, 0.0], |share| {
            Some(facet(share)? - facet(share + 1.0)?)
        })?;
        facet(share)
    }

    /// True if the neighbouring passes intersect the normal above Toprem and edge; the scallop formula applies there.
    pub fn is_on_blade_facet(&self, point: &FlankPoint<WorkFrame>) -> bool {
        let Some(surfaces) = self.blades.first() else {
            return false;
        };
        let [from, _] = surfaces.blade.range();
        [-1.0, 1.0].into_iter().all(|share| {
            let cradle = self.cradle_near(point, share);
            let hit = self.ray(&surfaces.blade, point.at[0], cradle, point);
            hit.is_some_and(|(u, _)| u >= from)
        })
    }

    /// Cradle angle at θ₀, rad, of a pass `blades` after the pass that touches a point.
    fn cradle_near(&self, point: &FlankPoint<WorkFrame>, blades: f64) -> f64 {
        self.cradle_at_start(point) + blades * self.feed.step()
    }

    /// Distance of a blade facet along the normal of a point, m; `cradle` is the cradle angle at θ₀, rad.
    pub fn facet(&self, blade: usize, cradle: f64, point: &FlankPoint<WorkFrame>) -> Option<f64> {
        let surfaces = self.blades.get(blade)?;
        let [from, to] = surfaces.blade.range();
        let (u, distance) = self.ray(&surfaces.blade, point.at[0], cradle, point)?;
        let tolerance = ON_BLADE * (to - from);
        let on_blade = (from - tolerance <= u && u <= to + tolerance).then_some(distance);
        // Blade and Toprem form a concave corner; near the corner the normal can intersect both.
        let is_below = u < from - tolerance || surfaces.toprem.is_some();
        let lower = surfaces.toprem.iter().chain(&surfaces.edge);
        let lower = lower.filter(|_| is_below).filter_map(|segment| {
            let [first, last] = segment.range();
            let (u, distance) = self.ray(segment, 0.5 * (first + last), cradle, point)?;
            (first <= u && u <= last).then_some(distance)
        });
        let facets = on_blade.into_iter().chain(lower);
        facets.min_by(f64::total_cmp)
    }

    /// Intersection of the normal of a point with a blade surface: u and distance, m.
    fn ray(
        &self,
        surface: &BladeSurface,
        u: f64,
        cradle: f64,
        point: &FlankPoint<WorkFrame>,
    ) -> Option<(f64, f64)> {
        let (from, along) = (point.point.coordinates, point.normal.components);
        let (drag, [su, st]) = (self.drag(), surface.scales());
        let start = [u, point.at[1], 0.0];
        let solution = newton(start, [su, st, su], |[u, theta, d]| {
            let nominal = cradle + drag * (theta - self.start_angle);
            let cutter_error = self.cutter_error.as_ref().map_or(0.0, |e| e.at(nominal)[0]);
            let state = self.motion.at(nominal - drag * cutter_error);
            let jet = surface.jet([u, theta])?.moved(&state.pose);
            let residual = (jet.r - from - along * d).array();
            let by_theta = jet.dr[1] + state.velocity.at(jet.r) * drag;
            let columns = [jet.dr[0], by_theta, -along].map(Vector::array);
            Some((residual, [0, 1, 2].map(|i| columns.map(|c| c[i]))))
        });
        solution.map(|[u, _, d]| (u, d))
    }

    /// Cradle rotation per radian of the cutter; 0 without generating roll.
    fn drag(&self) -> f64 {
        match self.motion.is_fixed() {
            true => 0.0,
            false => self.feed.drag(),
        }
    }

    /// Cradle angle at θ₀ for a pass number, rad; fractions lie between passes.
    fn cradle_at(&self, pass: f64) -> f64 {
        pass * self.feed.cradle_per_turn / f64::from(self.feed.blades)
    }

    /// Cradle angle at θ₀ of the pass that touches a point, rad.
    fn cradle_at_start(&self, point: &FlankPoint<WorkFrame>) -> f64 {
        let [_, theta, x] = point.at;
        x - self.drag() * (theta - self.start_angle)
    }

    /// Number of passes on either side that can finish a point: run-out and errors compensate `|D| x²/2`. Without errors a revolution
    /// of the head suffices.
    fn pass_range(&self, point: &FlankPoint<WorkFrame>) -> Option<f64> {
        let error = self.error_spread(point);
        let spread = error + self.offset_spread(point);
        let cradle = PASS_MARGIN * (2.0 * spread / point.second_order.undercut.abs()).sqrt();
        let passes = 1.0 + cradle / self.feed.step();
        let passes = match error > 0.0 {
            true => passes,
            false => passes.min(1.0 + f64::from(self.feed.blades)),
        };
        (passes <= MAX_PASSES).then_some(passes)
    }

    /// Range of the blade offsets along the normal of a point, m.
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

    /// Bound of the effect of cradle and work errors along the normal of a point, m, as a difference between two passes.
    fn error_spread(&self, point: &FlankPoint<WorkFrame>) -> f64 {
        // The axis of the cradle passes near the apex of the work.
        let [cradle, work] = self.bounds;
        2.0 * (work * angle_lever(point).abs() + cradle * point.point.coordinates.norm())
    }
}

/// Lever `n·(k×r)`, m: normal displacement of a flank point per radian of the work about its axis k. A small error ε of the work
/// displaces the cut flank by `n·(k×r) ε`.
pub fn angle_lever(point: &FlankPoint<WorkFrame>) -> f64 {
    let (r, n) = (point.point.coordinates, point.normal.components);
    n.dot(Vector::Z.cross(r))
}
