//! Unloaded contact of a bevel pair: transmission error with hand-over, ellipses, pattern, ease-off, V–H check.

use std::f64::consts::{FRAC_PI_2, PI};

use crate::base::error::Diagnostic;
use crate::gear::bevel::flank::BevelFlank;
use crate::gear::bevel::tooth_section::Side;
use crate::gear::contact::contact_path::{ContactPath, PITCHES};
use crate::gear::contact::contact_point::{ContactPoint, Edge};
use crate::gear::contact::ease_off::{EaseOff, EaseOffTerms};
use crate::gear::contact::ellipse::ContactEllipse;
use crate::gear::contact::pair::FlankPair;
use crate::gear::contact::reference::{
    ContactForces, LocalParameters, PatternShift, shift_pattern,
};
use crate::gear::kernel::vector::Vector;
use crate::plan::gear_limits::MEMBERS;
use crate::scene::bevel_file::BevelFile;

/// Rows and columns of the ease-off.
const EASE_OFF_GRID: [usize; 2] = [9, 15];
/// Shares of the face to which the V–H check moves the contact, with their names.
pub const VH_PLACES: [(&str, f64); 3] = [("toe", 0.25), ("middle", 0.5), ("heel", 0.75)];
/// Limit where the path was followed no further.
pub const END_OF_PITCHES: &str = "end of the requested pitches";
/// Points of an ellipse's outline.
const OUTLINE: usize = 48;
/// Ratios this near that of the tooth numbers differ by less than 0.1 arcsec of the gear over a pitch.
const SAME_RATIO: f64 = 2e-5;
/// A ratio on the teeth this far from that of the tooth numbers, %, is that of other teeth.
const OTHER_RATIO: f64 = 1.5;
/// D of a flank below this share of that at the reference: the undercut limit is near.
const NEAR_UNDERCUT: f64 = 0.1;

/// Unloaded contact of two flanks.
#[derive(Debug, Clone)]
pub struct BevelContact {
    /// The pair.
    pub pair: FlankPair,
    /// The path of one pair of teeth.
    pub path: ContactPath,
    /// The leading pair over the positions.
    pub points: Vec<BevelContactPoint>,
    /// Peak-to-peak of the transmission error over a pitch, rad; none where at some angle no pair touches.
    pub peak_to_peak: Option<f64>,
    /// Angle over which a pair touches on its flanks, over the pitch.
    pub contact_ratio: f64,
    /// Angle of the pinion and limit met at which the contact on the flanks begins and ends, where the pinion drives.
    pub ends: [(f64, String); 2],
    /// Shares of face and height of the reference contact on pinion and gear.
    pub reference_shares: [Option<[f64; 2]>; 2],
    /// Ellipse at the reference.
    pub ellipse: Option<ContactEllipse>,
    /// Local parameters at the reference.
    pub local: Option<LocalParameters>,
    /// Force at the reference.
    pub forces: ContactForces,
    /// Ends of the pattern on each member: least and largest share of face, of height.
    pub pattern: [Option<[[f64; 2]; 2]>; 2],
    /// Ease-off of the pinion and its terms.
    pub ease_off: (EaseOff, Option<EaseOffTerms>),
    /// V–H check at [`VH_PLACES`], where it is requested and the flanks touch there.
    pub vh: Option<[Option<PatternShift>; 3]>,
}

/// One position of the pair.
#[derive(Debug, Clone, Copy)]
pub struct BevelContactPoint {
    /// Angle of the pinion, rad.
    pub pinion_angle: f64,
    /// Angle of the gear, rad.
    pub gear_angle: f64,
    /// Transmission error, rad.
    pub te: f64,
    /// The pair that leads.
    pub pair: i32,
    /// Contact of pair 0 that many pitches later.
    pub contact: ContactPoint,
    /// Contact in the frame of the pinion, m.
    pub in_pinion: Vector,
    /// Ellipse; none on edges.
    pub ellipse: Option<ContactEllipse>,
}

/// The contact of the requested flanks; what it lacks becomes a warning.
pub fn contact(
    file: &BevelFile,
    flanks: [BevelFlank; 2],
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<BevelContact> {
    let (study, teeth) = (&file.contact, file.members.each_ref().map(|m| m.teeth));
    let assembly = file.assembly();
    let pair = FlankPair::new(flanks, teeth, file.hand, &assembly);
    // A pair is followed until the next ones have taken over, whatever the positions shown.
    let pitches = PITCHES.max(study.pitches);
    let Some(path) = pair.path_near_teeth(pitches, study.positions) else {
        diagnostics.push(Diagnostic {
            code: "no-contact",
            message: "the flanks do not touch near the middle of their teeth".into(),
            hint: Some("check hands, flanks, ratios of roll and [assembly]; one wrong setting moves the contact off the teeth".into()),
        });
        return None;
    };
    let reference = path.reference;
    if let Some(member) = pair.removed_at(&reference) {
        diagnostics.push(Diagnostic {
            code: "no-contact",
            message: format!(
                "undercut removes the flank of the {} where the flanks would touch",
                MEMBERS[member]
            ),
            hint: Some("mend the undercut first".into()),
        });
        return None;
    }
    let shift = |face: f64| shift_pattern(&pair, (&assembly, file.hand), &reference, face);
    if (reference.ratio() / pair.ratio() - 1.0).abs() > SAME_RATIO {
        diagnostics.push(no_reference(&pair, &reference, || shift(0.5)));
    }
    let points = leading(&pair, &path, study.pitches, study.positions, study.coating);
    let peak_to_peak = pair.peak_to_peak(&path, study.positions);
    if peak_to_peak.is_none() {
        diagnostics.push(Diagnostic {
            code: "no-contact",
            message: "between two pairs of teeth there are angles at which none touches".into(),
            hint: Some("the rows `contact on the flanks` say where the contact of a pair begins and ends; more `pitches` in [contact] follow it further".into()),
        });
    }
    let (contact_ratio, ends) = ends(&pair, &path);
    fillet_warning(&pair, &path, diagnostics);
    overlap_warning(&pair, &path, diagnostics);
    let [rows, columns] = EASE_OFF_GRID;
    let ease_off = pair.ease_off(&reference, rows, columns);
    let terms = ease_off.terms();
    let vh = study.vh.then(|| VH_PLACES.map(|(_, face)| shift(face)));
    diagnostics.extend(vh.as_ref().and_then(shift_warning));
    Some(BevelContact {
        reference_shares: [0, 1].map(|k| pair.shares(k, &reference)),
        ellipse: pair.ellipse(&reference, study.coating),
        local: pair.local_parameters(&reference),
        forces: ContactForces::of(&pair, &reference),
        pattern: [0, 1].map(|k| pattern(&pair, one_pitch(&points, study.positions), k)),
        ease_off: (ease_off, terms),
        vh,
        contact_ratio,
        ends,
        peak_to_peak,
        points,
        path,
        pair,
    })
}

/// A ratio that nowhere is that of the tooth numbers.
fn no_reference(
    pair: &FlankPair,
    reference: &ContactPoint,
    to_middle: impl FnOnce() -> Option<PatternShift>,
) -> Diagnostic {
    let percent = 100.0 * (reference.ratio() / pair.ratio() - 1.0);
    let hint = if percent.abs() > OTHER_RATIO && pair.is_on_teeth(reference) {
        format!(
            "check `teeth`: the flanks suit a ratio of {:.3}, the tooth numbers have {:.3}",
            1.0 / reference.ratio().abs(),
            1.0 / pair.ratio().abs()
        )
    } else {
        match to_middle() {
            Some(shift) => format!(
                "change `offset` by {:+.3} mm and `pinion_axial` by {:+.3} mm in [assembly]: the flanks then touch at this ratio in the middle of the gear's flank",
                1e3 * shift.offset,
                1e3 * shift.pinion_axial
            ),
            None => "check [assembly], settings and ratios of roll of both members, and teeth: no change of offset and pinion position was found that gives this ratio".into(),
        }
    };
    Diagnostic {
        code: "no-reference",
        message: format!(
            "nowhere on the flanks is the ratio that of the tooth numbers: it is {percent:+.3} % off at the contact that is taken as reference"
        ),
        hint: Some(hint),
    }
}

/// Places on the face to which no V and H move the contact.
fn shift_warning(shifts: &[Option<PatternShift>; 3]) -> Option<Diagnostic> {
    let places = VH_PLACES.iter().zip(shifts);
    let missing = places.filter(|(_, shift)| shift.is_none());
    let missing: Vec<String> = missing
        .map(|((_, face), _)| format!("{:.0} %", 100.0 * face))
        .collect();
    (!missing.is_empty()).then(|| Diagnostic {
        code: "no-contact",
        message: format!(
            "no V and H were found that move the contact to {} of the gear's face: on the way there the flanks lose contact",
            missing.join(" and ")
        ),
        hint: Some("change spiral angle or crowning until the ease-off has a top on the face".into()),
    })
}

/// The leading pair at equal steps about the reference.
pub(super) fn leading(
    pair: &FlankPair,
    path: &ContactPath,
    pitches: f64,
    positions: usize,
    coating: f64,
) -> Vec<BevelContactPoint> {
    let step = pair.pitch() / positions as f64;
    let count = (pitches * positions as f64).floor() as i64;
    let found = (-count..=count).filter_map(|i| {
        let angle = path.reference.pinion_angle + step * i as f64;
        let leading = pair.leading(path, angle)?;
        let contact = leading.contact;
        Some(BevelContactPoint {
            pinion_angle: angle,
            gear_angle: leading.gear_angle(pair),
            te: leading.te,
            pair: leading.pair,
            in_pinion: pair
                .pose(0, contact.pinion_angle)
                .inverse()
                .apply(contact.point),
            ellipse: match contact.edge {
                None => pair.ellipse(&contact, coating),
                Some(_) => None,
            },
            contact,
        })
    });
    found.collect()
}

/// Contact ratio on the flanks, and where and why the contact on them begins and ends in the sense in which the pinion drives.
fn ends(pair: &FlankPair, path: &ContactPath) -> (f64, [(f64, String); 2]) {
    let contacts = &path.contacts;
    let middle = contacts.partition_point(|c| c.pinion_angle < path.reference.pinion_angle);
    let middle = middle.min(contacts.len() - 1);
    let below = contacts[..middle]
        .iter()
        .rev()
        .take_while(|c| c.edge.is_none())
        .count();
    let above = contacts[middle..]
        .iter()
        .take_while(|c| c.edge.is_none())
        .count();
    let first = middle - below;
    let last = (middle + above).saturating_sub(1).max(first);
    let reason = |end: usize, next: Option<&ContactPoint>, stopped: Option<f64>| {
        if let Some(edge) = next.and_then(|c| c.edge) {
            return edge_name(&edge);
        }
        let undercut = pair.undercut_shares(&contacts[end], &path.reference);
        let near = undercut.and_then(|d| (0..2).find(|k| d[*k] < NEAR_UNDERCUT));
        match (near, stopped) {
            (Some(k), _) => format!("undercut limit of the {}", MEMBERS[k]),
            (None, Some(_)) => "no contact on the teeth beyond".into(),
            (None, None) => END_OF_PITCHES.into(),
        }
    };
    let before = first.checked_sub(1).map(|i| &contacts[i]);
    let ends = [
        (
            contacts[first].pinion_angle,
            reason(first, before, path.stopped[0]),
        ),
        (
            contacts[last].pinion_angle,
            reason(last, contacts.get(last + 1), path.stopped[1]),
        ),
    ];
    let ratio = (ends[1].0 - ends[0].0) / pair.pitch();
    let [below, above] = ends;
    match ContactForces::of(pair, &path.reference).pinion_turn > 0.0 {
        true => (ratio, [below, above]),
        false => (ratio, [above, below]),
    }
}

/// An edge in words.
pub fn edge_name(edge: &Edge) -> String {
    let side = match edge.side {
        Side::Tip => "tip",
        Side::Toe => "toe",
        Side::Heel => "heel",
    };
    format!("{side} of the {}", MEMBERS[edge.member])
}

/// Contacts below the part of a flank that the blade cuts above Toprem and edge.
fn fillet_warning(pair: &FlankPair, path: &ContactPath, diagnostics: &mut Vec<Diagnostic>) {
    for k in 0..2 {
        let [from, _] = pair.flanks[k].envelope.surface.curve.range;
        let depth = |c: &ContactPoint| from - c.unknowns[3 * k];
        let deepest = path.contacts.iter().map(depth).fold(0.0, f64::max);
        if deepest > 1e-9 {
            let (mate, name, deepest) = (MEMBERS[1 - k], MEMBERS[k], 1e3 * deepest);
            let (message, hint) = match pair.flanks[k].toprem.is_some() {
                true => (
                    format!(
                        "the contact goes on up to {deepest:.3} mm along the blade below the flank of the {name}, which the Toprem has relieved there"
                    ),
                    "take a smaller toprem_depth; the contact there is that of the blade without Toprem",
                ),
                false => (
                    format!(
                        "the {mate} touches the fillet of the {name}, up to {deepest:.3} mm along the blade below the flank"
                    ),
                    "take a smaller edge radius or a smaller face angle of the mate",
                ),
            };
            diagnostics.push(Diagnostic {
                code: "interference",
                message,
                hint: Some(hint.into()),
            });
        }
    }
}

/// Places that touch before the contact of the path.
fn overlap_warning(pair: &FlankPair, path: &ContactPath, diagnostics: &mut Vec<Diagnostic>) {
    let Some(found) = pair.overlap(path) else {
        return;
    };
    let [face, height] = found.shares.map(|share| 100.0 * share);
    let (depth, te) = (1e6 * found.depth, found.te.to_degrees() * 3600.0);
    diagnostics.push(Diagnostic {
        code: "overlap",
        message: format!(
            "the teeth overlap by {depth:.2} µm at {face:.0} % of the face and {height:.0} % of the height of the pinion; the transmission error there exceeds that of the path of contact by {te:.2} arcsec"
        ),
        hint: Some("change spiral angle, pressure angle or crowning where the ease-off falls; --torque covers the whole flank".into()),
    });
}

/// The positions of one pitch in the middle of all: the others repeat them.
pub fn one_pitch(points: &[BevelContactPoint], positions: usize) -> &[BevelContactPoint] {
    let count = points.len().min(positions + 1);
    let first = (points.len() - count) / 2;
    &points[first..first + count]
}

/// Outline of an ellipse in shares of face and height of a member.
pub fn outline(
    pair: &FlankPair,
    point: &BevelContactPoint,
    member: usize,
) -> Option<Vec<[f64; 2]>> {
    (0..OUTLINE)
        .map(|i| {
            let angle = std::f64::consts::TAU * i as f64 / OUTLINE as f64;
            on_ellipse(pair, point, member, angle)
        })
        .collect()
}

/// Half axes of an ellipse in shares of face and height of a member, the longer one first.
pub fn half_axes(
    pair: &FlankPair,
    point: &BevelContactPoint,
    member: usize,
) -> Option<[[f64; 2]; 2]> {
    let half = |angle: f64| -> Option<[f64; 2]> {
        let ends = [angle, angle + PI].map(|at| on_ellipse(pair, point, member, at));
        let [Some(a), Some(b)] = ends else {
            return None;
        };
        Some([0, 1].map(|k| 0.5 * (a[k] - b[k])))
    };
    Some([half(0.0)?, half(FRAC_PI_2)?])
}

/// A point of an ellipse's outline at a parameter, rad, in shares of face and height of a member.
fn on_ellipse(
    pair: &FlankPair,
    point: &BevelContactPoint,
    member: usize,
    angle: f64,
) -> Option<[f64; 2]> {
    let (contact, ellipse) = (&point.contact, point.ellipse.as_ref()?);
    let across = contact.normal.cross(ellipse.direction);
    let [long, short] = ellipse.semi_axes;
    let (sin, cos) = angle.sin_cos();
    let at = contact.point + ellipse.direction * (long * cos) + across * (short * sin);
    let (off, axis) = (at - pair.centre(member), pair.turn(member).w);
    let place = [off.dot(axis), axis.cross(off).norm()];
    pair.flanks[member].section.shares(place)
}

/// Ends of the pattern on a member.
fn pattern(pair: &FlankPair, points: &[BevelContactPoint], member: usize) -> Option<[[f64; 2]; 2]> {
    let outlines = points.iter().filter_map(|p| outline(pair, p, member));
    let places: Vec<[f64; 2]> = outlines.flatten().collect();
    if places.is_empty() {
        return None;
    }
    let ends = |k: usize| {
        let shares = places.iter().map(|p| p[k].clamp(0.0, 1.0));
        shares.fold([1.0, 0.0], |[low, high]: [f64; 2], x| {
            [low.min(x), high.max(x)]
        })
    };
    Some([ends(0), ends(1)])
}
