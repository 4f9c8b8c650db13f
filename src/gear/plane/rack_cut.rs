//! Outlines of gears of any convex pitch curve cut by a rack that rolls on it, teeth at equal arcs: `p = S/z = π m`.
//!
//! At depth t below the pitch line a rack's flank, its half thickness `w = p/4 − t tan α`, touches at the arc `s = ± (w − t cot α)` from
//! the middle of the rack's tooth; its tip arc at the normal's angle β at `s = ± (y_c − t_c cot β)`, (t_c, y_c) the arc's centre.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use super::centrodes::{Centrodes, Mate, Member};
use super::pitch_curve::out_of_range;
use super::rolling::{Centrode, Rolling};
use crate::base::error::Error;
use crate::numeric::{Complex, small_dense};

/// Rack cutter, lengths in modules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RackCutter {
    /// Pressure angle α, rad.
    pub pressure_angle: f64,
    /// Height of the gear's tips above its pitch curve.
    pub addendum: f64,
    /// Height of the rack's tips above its pitch line: the depth of the gear's roots.
    pub dedendum: f64,
    /// Radius of the rack's tip edges.
    pub tip_radius: f64,
}

impl Default for RackCutter {
    /// Basic rack profile A of ISO 53:1998.
    fn default() -> RackCutter {
        RackCutter {
            pressure_angle: 20_f64.to_radians(),
            addendum: 1.0,
            dedendum: 1.25,
            tip_radius: 0.38,
        }
    }
}

/// Part of an outline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutlinePart {
    /// Tip land.
    Tip,
    /// Flank.
    Flank,
    /// Fillet.
    Fillet,
    /// Root land.
    Root,
}

/// Point of an outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutlinePoint {
    /// Position in the frame of the gear, m.
    pub point: Complex,
    /// Part it belongs to.
    pub part: OutlinePart,
    /// Number of the tooth space, from 0.
    pub space: usize,
}

/// Closed outline of a gear.
#[derive(Debug, Clone, PartialEq)]
pub struct Outline {
    /// Points in the order of the rolled arc; the last is followed by the first.
    pub points: Vec<OutlinePoint>,
    /// Module `S/(π z)`, m.
    pub module: f64,
    /// Tooth spaces where the rack's tip cuts away part of a flank.
    pub undercut_spaces: Vec<usize>,
}

/// A rack at one tooth space of the work.
struct Space<'a> {
    rolling: &'a Rolling,
    /// +1 for a body to the left of the common tangent, −1 to the right.
    side: f64,
    middle: f64,
    pitch: f64,
    tan: f64,
    alpha: f64,
    /// Depth and distance from the middle of the centre of the tip arc, and its radius, m.
    centre: [f64; 2],
    radius: f64,
    addendum: f64,
}

/// Cuts the outline of a gear with a rack; each flank, fillet and land gets `points` steps, and the first tooth space lies at `first_space`,
/// an arc (m) from φ₁ = 0.
///
/// A mate meshes without backlash where its first space lies half a pitch further.
///
/// # Errors
/// `OutOfRange` for an open or concave pitch curve, an internal gear or a rack, a tip edge that does not fit the rack's tooth, or pointed
/// teeth (with the largest addendum).
pub fn cut_outline(
    pair: &Centrodes,
    member: Member,
    teeth: u32,
    cutter: &RackCutter,
    points: usize,
    first_space: f64,
) -> Result<Outline, Error> {
    let side = match (member, pair.mate()) {
        (Member::First, _) => 1.0,
        (Member::Second, Some(Mate::External)) => -1.0,
        (Member::Second, Some(Mate::Internal)) => {
            return Err(out_of_range(
                "a rack cannot cut an internal gear; take a shaper".into(),
            ));
        }
        (Member::Second, None) => {
            return Err(out_of_range(
                "the mate is a rack and has no closed outline".into(),
            ));
        }
    };
    let turn = pair.closed_arc(member)?;
    if teeth < 3 {
        return Err(out_of_range(format!("{teeth} teeth; give 3 or more")));
    }
    let extremes = pair.curvature_extremes(member);
    let [least, angle] = extremes.least;
    if !(least > 0.0) {
        return Err(out_of_range(format!(
            "the pitch curve is concave at {angle} rad of gear 1 (curvature {least} 1/m); a rack cannot cut it"
        ))
        .with_hint("take a shaper, or a smaller change of the ratio"));
    }
    let module = turn / (PI * f64::from(teeth));
    let (pitch, alpha) = (PI * module, cutter.pressure_angle);
    check_cutter(cutter)?;
    let rolling = Rolling {
        tool: Centrode::Line,
        work: Centrode::Member {
            pair: pair.clone(),
            member,
        },
    };
    let (depth, radius) = (module * cutter.dedendum, module * cutter.tip_radius);
    let tangent_depth = depth - radius * (1.0 - alpha.sin());
    let reach = 0.25 * pitch - tangent_depth * alpha.tan() - radius * alpha.cos();
    let mut outline = Outline {
        points: vec![],
        module,
        undercut_spaces: vec![],
    };
    let space_at = |k: u32| Space {
        rolling: &rolling,
        side,
        middle: first_space + f64::from(k) * pitch,
        pitch,
        tan: alpha.tan(),
        alpha,
        centre: [depth - radius, reach],
        radius,
        addendum: module * cutter.addendum,
    };
    for k in 0..teeth {
        let space = space_at(k);
        let tip = space.tip_ends().ok_or_else(lost)?;
        let next = space_at((k + 1) % teeth).tip_ends().ok_or_else(lost)?;
        // Arcs at which the tip land of the tooth behind this space begins and ends.
        let after = next[0].1 + if k + 1 == teeth { turn } else { 0.0 };
        if !(after > tip[1].1) {
            let largest = largest_addendum(&space_at, k, teeth, turn).unwrap_or(f64::NAN);
            return Err(out_of_range(format!(
                "the tooth behind space {k} is pointed below an addendum of {} modules",
                cutter.addendum
            ))
            .with_hint(format!(
                "take an addendum of at most {:.4} modules",
                largest / module
            )));
        }
        let is_undercut = space.push_points(&mut outline.points, k as usize, points, tip)?;
        let steps = points.max(1);
        let land = |i: usize| tip[1].1 + (after - tip[1].1) * i as f64 / steps as f64;
        for i in 1..steps {
            let point = space.parallel(land(i), -space.addendum).ok_or_else(lost)?;
            outline.points.push(OutlinePoint {
                point,
                part: OutlinePart::Tip,
                space: k as usize,
            });
        }
        if is_undercut {
            outline.undercut_spaces.push(k as usize);
        }
    }
    Ok(outline)
}

fn lost() -> Error {
    out_of_range("the outline leaves the flanks of the rack: the teeth are too high for their pressure angle".into())
}

fn check_cutter(cutter: &RackCutter) -> Result<(), Error> {
    let alpha = cutter.pressure_angle;
    if !(alpha > 0.0 && alpha < FRAC_PI_4) {
        return Err(out_of_range(format!(
            "pressure angle of the rack is {} deg; it must lie between 0 and 45 deg",
            alpha.to_degrees()
        )));
    }
    let heights = [cutter.addendum, cutter.dedendum, cutter.tip_radius];
    if !heights.iter().all(|h| *h >= 0.0 && h.is_finite()) {
        return Err(out_of_range(format!(
            "addendum, dedendum and tip radius of the rack are {heights:?} modules; none may be negative"
        )));
    }
    // Half width of the rack's tip: p/4 − h tan α − ρ (cos α − (1 − sin α) tan α) ≥ 0.
    let tip = FRAC_PI_4 - cutter.dedendum * alpha.tan();
    let taken = alpha.cos() - (1.0 - alpha.sin()) * alpha.tan();
    if !(tip >= cutter.tip_radius * taken) {
        return Err(out_of_range(format!(
            "tip edges of radius {} modules do not fit the tip of the rack, {:.4} modules wide",
            cutter.tip_radius,
            2.0 * tip
        ))
        .with_hint(format!(
            "take a tip radius of at most {:.4} modules",
            (tip / taken).max(0.0)
        )));
    }
    if cutter.tip_radius > cutter.dedendum {
        return Err(out_of_range(format!(
            "tip radius {} exceeds the dedendum {} of the rack, both in modules",
            cutter.tip_radius, cutter.dedendum
        )));
    }
    Ok(())
}

/// Largest addendum (m) at which the tooth behind a space has a tip land.
fn largest_addendum<'a>(
    space_at: &impl Fn(u32) -> Space<'a>,
    k: u32,
    teeth: u32,
    turn: f64,
) -> Option<f64> {
    let land = |addendum: f64| {
        let with = |k| Space {
            addendum,
            ..space_at(k)
        };
        let ends = with(k).tip_ends()?;
        let next = with((k + 1) % teeth).tip_ends()?;
        let behind = if k + 1 == teeth { turn } else { 0.0 };
        Some(next[0].1 + behind - ends[1].1)
    };
    let (mut low, mut high) = (0.0, space_at(k).addendum);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        match land(middle)? > 0.0 {
            true => low = middle,
            false => high = middle,
        }
    }
    Some(low)
}

impl Space<'_> {
    /// The work's point under the rack's point at a depth and a distance along the pitch line, when the rack has rolled to an arc.
    fn work_point(&self, depth: f64, along: f64, arc: f64) -> Option<Complex> {
        let point = Complex::new(-self.side * depth, along);
        Some(self.rolling.at(arc)?.to_work(point))
    }

    /// Point of the flank before (−1) or behind (+1) the space, at a depth.
    fn flank(&self, hand: f64, depth: f64) -> Option<Complex> {
        let width = 0.25 * self.pitch - depth * self.tan;
        let arc = self.middle + hand * (width - depth / self.tan);
        self.work_point(depth, self.middle + hand * width, arc)
    }

    /// Point of the fillet where the rack's normal makes β with the pitch line.
    fn fillet(&self, hand: f64, beta: f64) -> Option<Complex> {
        let ([depth, along], (sin, cos)) = (self.centre, beta.sin_cos());
        let arc = self.middle + hand * (along - depth * cos / sin);
        let (t, y) = (depth + self.radius * sin, along + self.radius * cos);
        self.work_point(t, self.middle + hand * y, arc)
    }

    /// Point at a depth below the pitch curve at an arc.
    fn parallel(&self, arc: f64, depth: f64) -> Option<Complex> {
        self.work_point(depth, arc, arc)
    }

    /// Depth on the rack and arc of the foot where each flank meets the tip curve.
    fn tip_ends(&self) -> Option<[(f64, f64); 2]> {
        let end = |hand: f64| {
            let height = |depth: f64| {
                self.foot(
                    self.flank(hand, depth)?,
                    self.middle + hand * 0.25 * self.pitch,
                )
            };
            let (mut low, mut high) = (-self.addendum, 0.0);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                match height(middle)?.0 > self.addendum {
                    true => low = middle,
                    false => high = middle,
                }
            }
            let depth = 0.5 * (low + high);
            Some((depth, height(depth)?.1))
        };
        Some([end(-1.0)?, end(1.0)?])
    }

    /// Height of a point of the work above its pitch curve, and the arc of its foot, by Newton's method from a near arc.
    fn foot(&self, point: Complex, near: f64) -> Option<(f64, f64)> {
        let mut arc = near;
        for _ in 0..30 {
            let at = self.rolling.work.at(arc)?;
            let local = (point - at.point) * at.tangent.conj();
            // In the frame of the tangent, x along it: the left is y > 0.
            let step = local.re / (1.0 - at.curvature * local.im);
            arc += step;
            if step.abs() <= 1e-14 * self.pitch {
                break;
            }
        }
        let at = self.rolling.work.at(arc)?;
        let local = (point - at.point) * at.tangent.conj();
        Some((-self.side * local.im, arc))
    }

    /// Largest depth on a flank that the rack generates without undercut: `t side·κ ≤ sin²α` along it.
    fn flank_limit(&self, hand: f64, deepest: f64, from: f64) -> Option<f64> {
        const STEPS: usize = 40;
        let excess = |depth: f64| {
            let arc =
                self.middle + hand * (0.25 * self.pitch - depth * self.tan - depth / self.tan);
            let curvature = self.side * self.rolling.work.at(arc)?.curvature;
            Some(depth * curvature - self.alpha.sin().powi(2))
        };
        let at = |i: usize| from + (deepest - from) * i as f64 / STEPS as f64;
        for i in 1..=STEPS {
            if excess(at(i))? > 0.0 {
                let (mut low, mut high) = (at(i - 1), at(i));
                for _ in 0..50 {
                    let middle = 0.5 * (low + high);
                    match excess(middle)? > 0.0 {
                        true => high = middle,
                        false => low = middle,
                    }
                }
                return Some(low);
            }
        }
        Some(deepest)
    }

    /// Depth on the flank and angle on the fillet at which both meet: the common point of a tooth without undercut, or the crossing.
    fn root_form(&self, hand: f64, from: f64) -> Result<(f64, f64, bool), Error> {
        let deepest = self.centre[0] + self.radius * self.alpha.sin();
        let limit = self.flank_limit(hand, deepest, from).ok_or_else(lost)?;
        if limit == deepest {
            return Ok((deepest, self.alpha, false));
        }
        let (flank, fillet) = (
            |t: f64| self.flank(hand, t),
            |beta: f64| self.fillet(hand, beta),
        );
        let start = crossing(flank, [from, limit], fillet, [self.alpha, FRAC_PI_2]);
        let error = || {
            out_of_range("the rack's tip cuts off the whole flank of a tooth".into())
                .with_hint("take more teeth, a larger pressure angle or a smaller dedendum")
        };
        let [depth, beta] = start.ok_or_else(error)?;
        Ok((depth, beta, true))
    }

    /// Appends flank, fillet, root, fillet and flank of the space; tells whether it is undercut.
    fn push_points(
        &self,
        outline: &mut Vec<OutlinePoint>,
        space: usize,
        points: usize,
        tip: [(f64, f64); 2],
    ) -> Result<bool, Error> {
        let steps = points.max(1);
        let mut push = |part: OutlinePart, point: Option<Complex>| match point {
            Some(point) if point.norm().is_finite() => {
                outline.push(OutlinePoint { point, part, space });
                Ok(())
            }
            _ => Err(lost()),
        };
        let share = |a: f64, b: f64, i: usize| a + (b - a) * i as f64 / steps as f64;
        let before = self.root_form(-1.0, tip[0].0)?;
        let behind = self.root_form(1.0, tip[1].0)?;
        for i in 0..=steps {
            let depth = share(tip[0].0, before.0, i);
            push(OutlinePart::Flank, self.flank(-1.0, depth))?;
        }
        for i in 1..=steps {
            let beta = share(before.1, FRAC_PI_2, i);
            push(OutlinePart::Fillet, self.fillet(-1.0, beta))?;
        }
        let root = [self.middle - self.centre[1], self.middle + self.centre[1]];
        for i in 1..steps {
            let arc = share(root[0], root[1], i);
            let depth = self.centre[0] + self.radius;
            push(OutlinePart::Root, self.parallel(arc, depth))?;
        }
        for i in 0..steps {
            let beta = share(FRAC_PI_2, behind.1, i);
            push(OutlinePart::Fillet, self.fillet(1.0, beta))?;
        }
        for i in 0..=steps {
            let depth = share(behind.0, tip[1].0, i);
            push(OutlinePart::Flank, self.flank(1.0, depth))?;
        }
        Ok(before.2 || behind.2)
    }
}

/// Parameters at which two curves cross first, by their chords and Newton's method.
fn crossing(
    a: impl Fn(f64) -> Option<Complex>,
    [a0, a1]: [f64; 2],
    b: impl Fn(f64) -> Option<Complex>,
    [b0, b1]: [f64; 2],
) -> Option<[f64; 2]> {
    const CHORDS: usize = 60;
    let at = |low: f64, high: f64, i: usize| low + (high - low) * i as f64 / CHORDS as f64;
    let first: Option<Vec<Complex>> = (0..=CHORDS).map(|i| a(at(a0, a1, i))).collect();
    let second: Option<Vec<Complex>> = (0..=CHORDS).map(|j| b(at(b0, b1, j))).collect();
    let (first, second) = (first?, second?);
    let mut start = None;
    'search: for i in 0..CHORDS {
        let (p0, p1) = (first[i], first[i + 1]);
        for j in 0..CHORDS {
            let (q0, q1) = (second[j], second[j + 1]);
            let cross = |u: Complex, v: Complex| (u.conj() * v).im;
            let (d, e) = (p1 - p0, q1 - q0);
            let (x, y) = (
                cross(q0 - p0, e) / cross(d, e),
                cross(q0 - p0, d) / cross(d, e),
            );
            if (0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y) {
                let inside = |low: f64, high: f64, i: usize, x: f64| {
                    at(low, high, i) + x * (high - low) / CHORDS as f64
                };
                start = Some([inside(a0, a1, i, x), inside(b0, b1, j, y)]);
                break 'search;
            }
        }
    }
    let [mut x, mut y] = start?;
    // Slopes by differences: the residual alone decides the digits.
    let (hx, hy) = (1e-6 * (a1 - a0), 1e-6 * (b1 - b0));
    for _ in 0..20 {
        let gap = a(x)? - b(y)?;
        let da = (a(x + hx)? - a(x - hx)?) / (2.0 * hx);
        let db = (b(y + hy)? - b(y - hy)?) / (2.0 * hy);
        let mut rows = [da.re, -db.re, da.im, -db.im];
        let mut step = [-gap.re, -gap.im];
        small_dense::solve(&mut rows, &mut step);
        x += step[0];
        y += step[1];
        if step[0].abs() <= 1e-9 * (a1 - a0).abs() && step[1].abs() <= 1e-9 * (b1 - b0).abs() {
            break;
        }
    }
    (x.is_finite() && y.is_finite()).then_some([x, y])
}
