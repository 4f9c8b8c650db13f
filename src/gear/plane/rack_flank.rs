//! Flank of a rack between the tips of both gears it cuts: a point t (1, tan α) touches at the arc `s = t/(sin α cos α)`, and contact ends
//! where the point of either gear lies higher than the addendum above its centrode.

use super::centrodes::{Centrodes, Member};
use super::profile::Shape;
use super::rack_cutter::RackCutter;
use super::rolling::{Centrode, Rolling};
use crate::base::error::Error;
use crate::gear::kernel::root::sign_change;
use crate::numeric::Complex;

/// The flank through the pitch point at φ₁ = 0 of a rack of a module (m), from the gear's tips to the pinion's, x > 0 towards the tips of the
/// pinion.
///
/// # Errors
/// As `RackCutter::check`; `OutOfRange` for a rack without height.
pub fn rack_flank(pair: &Centrodes, cutter: &RackCutter, module: f64) -> Result<Shape, Error> {
    cutter.check()?;
    let (sin, cos) = cutter.pressure_angle.sin_cos();
    let along = Complex::new(1.0, sin / cos);
    let straight = module * (cutter.dedendum - cutter.tip_radius * (1.0 - sin));
    let addendum = module * cutter.addendum;
    let height = |member: Member, t: f64| {
        let work = Centrode::Member {
            pair: pair.clone(),
            member,
        };
        let rolling = Rolling {
            tool: Centrode::Line,
            work,
        };
        let arc = t / (sin * cos);
        let point = rolling.at(arc)?.to_work(along * t);
        Some(rolling.work.foot(point, arc, module)?.0)
    };
    // The body of gear 1 lies to the left of the common tangent, that of gear 2 to the right.
    let tip = |member: Member, sign: f64| {
        let beyond = |t: f64| Some(-sign * height(member, sign * t)? - addendum);
        sign_change([0.0, addendum], beyond)
            .unwrap_or(addendum)
            .min(straight)
    };
    let [of_pinion, of_gear] = [tip(Member::First, 1.0), tip(Member::Second, -1.0)];
    Shape::line(-along * of_gear, along * of_pinion)
}
