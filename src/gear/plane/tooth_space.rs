//! A tooth space cut by one tooth of a rack that rolls on a pitch curve.
//!
//! At depth t below the pitch line a rack's flank, its half thickness `w = p/4 − t tan α`, touches at the arc `s = ± (w − t cot α)` from
//! the middle of the rack's tooth; its tip arc at the normal's angle β at `s = ± (y_c − t_c cot β)`, (t_c, y_c) the arc's centre.

use std::f64::consts::FRAC_PI_2;

use super::pitch_curve::out_of_range;
use super::rolling::Rolling;
use crate::base::error::Error;
use crate::gear::kernel::root::sign_change;
use crate::numeric::{Complex, small_dense};

/// A rack at one tooth space of the work.
pub(super) struct ToothSpace<'a> {
    pub(super) rolling: &'a Rolling,
    /// +1 for a body to the left of the common tangent, −1 to the right.
    pub(super) side: f64,
    pub(super) middle: f64,
    pub(super) pitch: f64,
    pub(super) tan: f64,
    pub(super) alpha: f64,
    /// Depth and distance from the middle of the centre of the tip arc, and its radius, m.
    pub(super) centre: [f64; 2],
    pub(super) radius: f64,
    pub(super) addendum: f64,
}

pub(super) fn lost() -> Error {
    out_of_range("the outline ends outside the flanks of the rack: the teeth are too high for their pressure angle".into())
}

impl ToothSpace<'_> {
    /// The work's point under the rack's point at a depth and a distance along the pitch line, when the rack has rolled to an arc.
    fn work_point(&self, depth: f64, along: f64, arc: f64) -> Option<Complex> {
        let point = Complex::new(-self.side * depth, along);
        Some(self.rolling.at(arc)?.to_work(point))
    }

    /// Point of the flank before (−1) or behind (+1) the space, at a depth.
    pub(super) fn flank(&self, hand: f64, depth: f64) -> Option<Complex> {
        let width = 0.25 * self.pitch - depth * self.tan;
        let arc = self.middle + hand * (width - depth / self.tan);
        self.work_point(depth, self.middle + hand * width, arc)
    }

    /// Point of the fillet where the rack's normal makes β with the pitch line.
    pub(super) fn fillet(&self, hand: f64, beta: f64) -> Option<Complex> {
        let ([depth, along], (sin, cos)) = (self.centre, beta.sin_cos());
        let arc = self.middle + hand * (along - depth * cos / sin);
        let (t, y) = (depth + self.radius * sin, along + self.radius * cos);
        self.work_point(t, self.middle + hand * y, arc)
    }

    /// Point at a depth below the pitch curve at an arc.
    pub(super) fn parallel(&self, arc: f64, depth: f64) -> Option<Complex> {
        self.work_point(depth, arc, arc)
    }

    /// Depth on the rack and arc of the foot where each flank meets the tip curve.
    pub(super) fn tip_ends(&self) -> Option<[(f64, f64); 2]> {
        let end = |hand: f64| {
            let height = |depth: f64| {
                self.foot(
                    self.flank(hand, depth)?,
                    self.middle + hand * 0.25 * self.pitch,
                )
            };
            let depth = sign_change([-self.addendum, 0.0], |t| {
                Some(height(t)?.0 - self.addendum)
            })?;
            Some((depth, height(depth)?.1))
        };
        Some([end(-1.0)?, end(1.0)?])
    }

    /// Height of a point of the work above its pitch curve, and the arc of its foot.
    fn foot(&self, point: Complex, near: f64) -> Option<(f64, f64)> {
        let (left, arc) = self.rolling.work.foot(point, near, self.pitch)?;
        Some((-self.side * left, arc))
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
                return sign_change([at(i - 1), at(i)], excess);
            }
        }
        Some(deepest)
    }

    /// Depth on the flank and angle on the fillet at which both meet: the common point of a tooth without undercut, or the crossing.
    pub(super) fn root_form(&self, hand: f64, from: f64) -> Result<(f64, f64, bool), Error> {
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
                .with_hint("use more teeth, a larger pressure angle or a smaller dedendum")
        };
        let [depth, beta] = start.ok_or_else(error)?;
        Ok((depth, beta, true))
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
