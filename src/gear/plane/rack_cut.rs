//! Outlines of gears with a convex pitch curve, cut by a rack that rolls on it; the teeth lie at equal arcs `p = S/z = π m`.

use std::f64::consts::{FRAC_PI_2, PI};

use super::centrodes::{Centrodes, Mate, Member};
use super::pitch_curve::{degrees, millimetres, out_of_range};
use super::rack_cutter::RackCutter;
use super::rolling::{Centrode, Rolling};
use super::tooth_space::{ToothSpace, lost};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::gear::kernel::root::sign_change;
use crate::numeric::Complex;

/// Steps of each outline part in [`cut_pair`]: the chord error is 1e-4 modules for the pair in models/ (2.6e-4 with 16 steps).
const OUTLINE_STEPS: usize = 32;
/// Relative difference up to which the pitches of both gears count as equal: rounding of the arcs.
const SAME_PITCH: f64 = 1e-9;

/// Part of a tooth outline.
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

/// Point of a tooth outline.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OutlinePoint {
    /// Position in the frame of the gear, m.
    pub point: Complex,
    /// Part of the outline the point belongs to.
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
    /// Indices of the tooth spaces whose flanks are undercut by the tip of the rack.
    pub undercut_spaces: Vec<usize>,
}

/// Cuts the outline of a gear with a rack; each flank, fillet and land is divided into `points` steps, and the first tooth space lies at
/// the arc `first_space` (m) from φ₁ = 0.
///
/// A mate meshes without backlash if its first space lies half a pitch further.
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
                "a rack cannot cut an internal gear; use a shaper".into(),
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
    let [min_curvature, angle] = extremes.least;
    if !(min_curvature > 0.0) {
        return Err(out_of_range(format!(
            "the pitch curve is concave at {} of gear 1 (radius of curvature {}); a rack cannot cut it", degrees(angle), millimetres(1.0 / min_curvature)
        ))
        .with_hint("use a shaper, or a smaller variation of the ratio"));
    }
    let module = turn / (PI * f64::from(teeth));
    let (pitch, alpha) = (PI * module, cutter.pressure_angle);
    cutter.check()?;
    let rolling = Rolling {
        tool: Centrode::Line,
        work: Centrode::Member {
            pair: pair.clone(),
            member,
        },
    };
    let (depth, radius) = (module * cutter.dedendum, module * cutter.tip_radius);
    let tangent_depth = depth - radius * (1.0 - alpha.sin());
    let centre_offset = 0.25 * pitch - tangent_depth * alpha.tan() - radius * alpha.cos();
    let mut outline = Outline {
        points: vec![],
        module,
        undercut_spaces: vec![],
    };
    let space_at = |k: u32| ToothSpace {
        rolling: &rolling,
        side,
        middle: first_space + f64::from(k) * pitch,
        pitch,
        tan: alpha.tan(),
        alpha,
        centre: [depth - radius, centre_offset],
        radius,
        addendum: module * cutter.addendum,
    };
    for k in 0..teeth {
        let space = space_at(k);
        let tip = space.tip_ends().ok_or_else(lost)?;
        let next = space_at((k + 1) % teeth).tip_ends().ok_or_else(lost)?;
        // The tip land of the tooth behind this space extends from the arc tip[1].1 to `land_end`.
        let land_end = next[0].1 + if k + 1 == teeth { turn } else { 0.0 };
        if !(land_end > tip[1].1) {
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
        let is_undercut = push_points(&space, &mut outline.points, k as usize, points, tip)?;
        let steps = points.max(1);
        let arc = |i: usize| tip[1].1 + (land_end - tip[1].1) * i as f64 / steps as f64;
        for i in 1..steps {
            let point = space.parallel(arc(i), -space.addendum).ok_or_else(lost)?;
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

/// Cuts both gears of a pair with a rack; the first space of gear 2 lies at half a pitch, so that they mesh at φ₁ = 0.
///
/// # Errors
/// `Conflict` if the tooth numbers give different pitches; else those of [`cut_outline`].
pub fn cut_pair(
    pair: &Centrodes,
    teeth: [u32; 2],
    cutter: &RackCutter,
) -> Result<[Outline; 2], Error> {
    let closed_arc = |member| pair.closed_arc(member);
    let arcs = [closed_arc(Member::First)?, closed_arc(Member::Second)?];
    let [pitch_1, pitch_2] = [0, 1].map(|k| arcs[k] / f64::from(teeth[k]));
    if (pitch_1 / pitch_2 - 1.0).abs() > SAME_PITCH {
        let [z1, z2] = teeth;
        let message = format!("{z1} and {z2} teeth have different pitches on these centrodes");
        let hint = format!("the gear takes {:.4} teeth", arcs[1] / pitch_1);
        return Err(Error::new(Code::Conflict, message).with_hint(hint));
    }
    let cut = |member, z, start| cut_outline(pair, member, z, cutter, OUTLINE_STEPS, start);
    Ok([
        cut(Member::First, teeth[0], 0.0)?,
        cut(Member::Second, teeth[1], 0.5 * pitch_1)?,
    ])
}

/// Largest addendum (m) at which the tooth behind a space has a tip land.
fn largest_addendum<'a>(
    space_at: &impl Fn(u32) -> ToothSpace<'a>,
    k: u32,
    teeth: u32,
    turn: f64,
) -> Option<f64> {
    let land_length = |addendum: f64| {
        let tooth_space = |k| ToothSpace {
            addendum,
            ..space_at(k)
        };
        let ends = tooth_space(k).tip_ends()?;
        let next = tooth_space((k + 1) % teeth).tip_ends()?;
        let period = if k + 1 == teeth { turn } else { 0.0 };
        Some(next[0].1 + period - ends[1].1)
    };
    sign_change([0.0, space_at(k).addendum], land_length)
}

/// Appends flank, fillet, root, fillet and flank of the space; returns `true` if it is undercut.
fn push_points(
    rack: &ToothSpace,
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
    let interpolate = |a: f64, b: f64, i: usize| a + (b - a) * i as f64 / steps as f64;
    let form_1 = rack.root_form(-1.0, tip[0].0)?;
    let form_2 = rack.root_form(1.0, tip[1].0)?;
    for i in 0..=steps {
        let depth = interpolate(tip[0].0, form_1.0, i);
        push(OutlinePart::Flank, rack.flank(-1.0, depth))?;
    }
    for i in 1..=steps {
        let beta = interpolate(form_1.1, FRAC_PI_2, i);
        push(OutlinePart::Fillet, rack.fillet(-1.0, beta))?;
    }
    let root = [rack.middle - rack.centre[1], rack.middle + rack.centre[1]];
    for i in 1..steps {
        let arc = interpolate(root[0], root[1], i);
        let depth = rack.centre[0] + rack.radius;
        push(OutlinePart::Root, rack.parallel(arc, depth))?;
    }
    for i in 0..steps {
        let beta = interpolate(FRAC_PI_2, form_2.1, i);
        push(OutlinePart::Fillet, rack.fillet(1.0, beta))?;
    }
    for i in 0..=steps {
        let depth = interpolate(form_2.0, tip[1].0, i);
        push(OutlinePart::Flank, rack.flank(1.0, depth))?;
    }
    Ok(form_1.2 || form_2.2)
}
