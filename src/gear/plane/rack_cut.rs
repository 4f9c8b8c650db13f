//! Outlines of gears of any convex pitch curve cut by a rack that rolls on it, teeth at equal arcs: `p = S/z = π m`.

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

/// Steps of each part of an outline of a pair: chords lie within 1e-4 modules of the curves of the shipped pair, 16 steps leave 2.6e-4.
const OUTLINE_STEPS: usize = 32;
/// Pitches of both gears that differ by less, relative, are one: rounding of the arcs.
const SAME_PITCH: f64 = 1e-9;

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
            "the pitch curve is concave at {} of gear 1 (radius of curvature {}); a rack cannot cut it", degrees(angle), millimetres(1.0 / least)
        ))
        .with_hint("take a shaper, or a smaller change of the ratio"));
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
    let reach = 0.25 * pitch - tangent_depth * alpha.tan() - radius * alpha.cos();
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
        let is_undercut = push_points(&space, &mut outline.points, k as usize, points, tip)?;
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

/// Cuts both gears of a pair with a rack; the gear's first space lies half a pitch on, so that they mesh at φ₁ = 0.
///
/// # Errors
/// `Conflict` for tooth numbers of different pitches; else those of [`cut_outline`].
pub fn cut_pair(
    pair: &Centrodes,
    teeth: [u32; 2],
    cutter: &RackCutter,
) -> Result<[Outline; 2], Error> {
    let closed = |member| pair.closed_arc(member);
    let arcs = [closed(Member::First)?, closed(Member::Second)?];
    let [pitch, of_gear] = [0, 1].map(|k| arcs[k] / f64::from(teeth[k]));
    if (pitch / of_gear - 1.0).abs() > SAME_PITCH {
        let [z1, z2] = teeth;
        let message = format!("{z1} and {z2} teeth have different pitches on these centrodes");
        let hint = format!("the gear takes {:.4} teeth", arcs[1] / pitch);
        return Err(Error::new(Code::Conflict, message).with_hint(hint));
    }
    let cut = |member, z, start| cut_outline(pair, member, z, cutter, OUTLINE_STEPS, start);
    Ok([
        cut(Member::First, teeth[0], 0.0)?,
        cut(Member::Second, teeth[1], 0.5 * pitch)?,
    ])
}

/// Largest addendum (m) at which the tooth behind a space has a tip land.
fn largest_addendum<'a>(
    space_at: &impl Fn(u32) -> ToothSpace<'a>,
    k: u32,
    teeth: u32,
    turn: f64,
) -> Option<f64> {
    let land = |addendum: f64| {
        let with = |k| ToothSpace {
            addendum,
            ..space_at(k)
        };
        let ends = with(k).tip_ends()?;
        let next = with((k + 1) % teeth).tip_ends()?;
        let behind = if k + 1 == teeth { turn } else { 0.0 };
        Some(next[0].1 + behind - ends[1].1)
    };
    sign_change([0.0, space_at(k).addendum], land)
}

/// Appends flank, fillet, root, fillet and flank of the space; tells whether it is undercut.
fn push_points(
    cut: &ToothSpace,
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
    let before = cut.root_form(-1.0, tip[0].0)?;
    let behind = cut.root_form(1.0, tip[1].0)?;
    for i in 0..=steps {
        let depth = share(tip[0].0, before.0, i);
        push(OutlinePart::Flank, cut.flank(-1.0, depth))?;
    }
    for i in 1..=steps {
        let beta = share(before.1, FRAC_PI_2, i);
        push(OutlinePart::Fillet, cut.fillet(-1.0, beta))?;
    }
    let root = [cut.middle - cut.centre[1], cut.middle + cut.centre[1]];
    for i in 1..steps {
        let arc = share(root[0], root[1], i);
        let depth = cut.centre[0] + cut.radius;
        push(OutlinePart::Root, cut.parallel(arc, depth))?;
    }
    for i in 0..steps {
        let beta = share(FRAC_PI_2, behind.1, i);
        push(OutlinePart::Fillet, cut.fillet(1.0, beta))?;
    }
    for i in 0..=steps {
        let depth = share(behind.0, tip[1].0, i);
        push(OutlinePart::Flank, cut.flank(1.0, depth))?;
    }
    Ok(before.2 || behind.2)
}
