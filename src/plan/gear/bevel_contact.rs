//! Unloaded contact of a bevel pair: transmission error with tooth-pair transfer, contact ellipses, contact pattern, ease-off, V–H check.

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

/// Rows and columns of the ease-off grid.
const EASE_OFF_GRID: [usize; 2] = [9, 15];
/// Positions of the V–H check with their names, as fractions of the face width from the toe.
pub const VH_POSITIONS: [(&str, f64); 3] = [("toe", 0.25), ("middle", 0.5), ("heel", 0.75)];
/// Reason for the end of the contact at the end of the computed range.
pub const END_OF_PITCHES: &str = "end of the requested pitches";
/// Number of points of the outline of an ellipse.
const OUTLINE: usize = 48;
/// Relative tolerance of the instantaneous ratio: less than 0.1 arcsec of the gear over a pitch.
const SAME_RATIO: f64 = 2e-5;
/// Deviation of the ratio from that of the tooth numbers above which wrong tooth numbers are reported, %.
const OTHER_RATIO: f64 = 1.5;
/// Undercut function D relative to that at the reference below which the undercut limit is reported.
const NEAR_UNDERCUT: f64 = 0.1;

/// Unloaded contact of two flanks.
#[derive(Debug, Clone)]
pub struct BevelContact {
    /// Pair of flanks.
    pub pair: FlankPair,
    /// Path of contact of one tooth pair.
    pub path: ContactPath,
    /// Contact of the leading tooth pair over the positions.
    pub points: Vec<BevelContactPoint>,
    /// Peak-to-peak transmission error over a pitch, rad; absent if no pair touches at some angle.
    pub peak_to_peak: Option<f64>,
    /// Contact ratio: angle of contact of a tooth pair on its flanks over the angular pitch.
    pub contact_ratio: f64,
    /// Start and end of the contact on the flanks with a driving pinion: angle of the pinion, rad, and limit reached.
    pub ends: [(f64, String); 2],
    /// Reference contact on pinion and gear as fractions of face and height.
    pub reference_position: [Option<[f64; 2]>; 2],
    /// Contact ellipse at the reference.
    pub ellipse: Option<ContactEllipse>,
    /// Local parameters at the reference.
    pub local: Option<LocalParameters>,
    /// Contact forces at the reference.
    pub forces: ContactForces,
    /// Extent of the pattern on each member: smallest and largest fraction of face, then of height.
    pub pattern: [Option<[[f64; 2]; 2]>; 2],
    /// Ease-off of the pinion and its terms.
    pub ease_off: (EaseOff, Option<EaseOffTerms>),
    /// V–H check at [`VH_POSITIONS`], if requested; absent where the flanks do not touch.
    pub vh: Option<[Option<PatternShift>; 3]>,
}

/// Contact of the pair at one position.
#[derive(Debug, Clone, Copy)]
pub struct BevelContactPoint {
    /// Angle of the pinion, rad.
    pub pinion_angle: f64,
    /// Angle of the gear, rad.
    pub gear_angle: f64,
    /// Transmission error, rad.
    pub te: f64,
    /// Number of the leading tooth pair.
    pub pair: i32,
    /// Contact of tooth pair 0, `pair` pitches later.
    pub contact: ContactPoint,
    /// Contact point in the frame of the pinion, m.
    pub in_pinion: Vector,
    /// Contact ellipse; absent on edges.
    pub ellipse: Option<ContactEllipse>,
}

/// Computes the unloaded contact of two flanks, with warnings about missing or incomplete contact.
pub fn contact(
    file: &BevelFile,
    flanks: [BevelFlank; 2],
    diagnostics: &mut Vec<Diagnostic>,
) -> Option<BevelContact> {
    let (study, teeth) = (&file.contact, file.members.each_ref().map(|m| m.teeth));
    let assembly = file.assembly();
    let pair = FlankPair::new(flanks, teeth, file.hand, &assembly);
    // The path covers the transfer to the next pairs for any number of reported positions.
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
                "undercut removes the flank of the {} at the contact",
                MEMBERS[member]
            ),
            hint: Some("remove the undercut first".into()),
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
            message: "at some angles between two tooth pairs no teeth touch".into(),
            hint: Some("the rows `contact on the flanks` say where the contact of a pair begins and ends; more `pitches` in [contact] follow it further".into()),
        });
    }
    let (contact_ratio, ends) = ends(&pair, &path);
    fillet_warning(&pair, &path, diagnostics);
    overlap_warning(&pair, &path, diagnostics);
    let [rows, columns] = EASE_OFF_GRID;
    let ease_off = pair.ease_off(&reference, rows, columns);
    let terms = ease_off.terms();
    let vh = study.vh.then(|| VH_POSITIONS.map(|(_, face)| shift(face)));
    diagnostics.extend(vh.as_ref().and_then(shift_warning));
    Some(BevelContact {
        reference_position: [0, 1].map(|k| pair.shares(k, &reference)),
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

/// Warning about an instantaneous ratio that differs from that of the tooth numbers everywhere.
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

/// Warning about positions on the face that no V and H reach.
fn shift_warning(shifts: &[Option<PatternShift>; 3]) -> Option<Diagnostic> {
    let places = VH_POSITIONS.iter().zip(shifts);
    let missing = places.filter(|(_, shift)| shift.is_none());
    let missing: Vec<String> = missing
        .map(|((_, face), _)| format!("{:.0} %", 100.0 * face))
        .collect();
    (!missing.is_empty()).then(|| Diagnostic {
        code: "no-contact",
        message: format!(
            "no V and H were found that move the contact to {} of the gear's face: the flanks lose contact before",
            missing.join(" and ")
        ),
        hint: Some("change spiral angle or crowning until the ease-off has a top on the face".into()),
    })
}

/// Contacts of the leading pair at equal steps of the pinion about the reference.
pub(super) fn leading(
    pair: &FlankPair,
    path: &ContactPath,
    pitches: f64,
    positions: usize,
    coating: f64,
) -> Vec<BevelContactPoint> {
    let step = pair.pitch() / positions as f64;
    let count = (pitches * positions as f64).floor() as i64;
    let points = (-count..=count).filter_map(|i| {
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
    points.collect()
}

/// Contact ratio on the flanks, and start and end of the contact (angle of the pinion, rad, and limit) with a driving pinion.
fn ends(pair: &FlankPair, path: &ContactPath) -> (f64, [(f64, String); 2]) {
    let contacts = &path.contacts;
    let reference = contacts.partition_point(|c| c.pinion_angle < path.reference.pinion_angle);
    let reference = reference.min(contacts.len() - 1);
    let n_before = contacts[..reference]
        .iter()
        .rev()
        .take_while(|c| c.edge.is_none())
        .count();
    let n_after = contacts[reference..]
        .iter()
        .take_while(|c| c.edge.is_none())
        .count();
    let first = reference - n_before;
    let last = (reference + n_after).saturating_sub(1).max(first);
    let reason = |end: usize, next: Option<&ContactPoint>, stopped: Option<f64>| {
        if let Some(edge) = next.and_then(|c| c.edge) {
            return edge_name(&edge);
        }
        let undercut = pair.undercut_shares(&contacts[end], &path.reference);
        let member = undercut.and_then(|d| (0..2).find(|k| d[*k] < NEAR_UNDERCUT));
        match (member, stopped) {
            (Some(k), _) => format!("undercut limit of the {}", MEMBERS[k]),
            (None, Some(_)) => "no contact on the teeth beyond".into(),
            (None, None) => END_OF_PITCHES.into(),
        }
    };
    let previous = first.checked_sub(1).map(|i| &contacts[i]);
    let ends = [
        (
            contacts[first].pinion_angle,
            reason(first, previous, path.stopped[0]),
        ),
        (
            contacts[last].pinion_angle,
            reason(last, contacts.get(last + 1), path.stopped[1]),
        ),
    ];
    let ratio = (ends[1].0 - ends[0].0) / pair.pitch();
    let [start, end] = ends;
    match ContactForces::of(pair, &path.reference).pinion_turn > 0.0 {
        true => (ratio, [start, end]),
        false => (ratio, [end, start]),
    }
}

/// Name of an edge for reports.
pub fn edge_name(edge: &Edge) -> String {
    let side = match edge.side {
        Side::Tip => "tip",
        Side::Toe => "toe",
        Side::Heel => "heel",
    };
    format!("{side} of the {}", MEMBERS[edge.member])
}

/// Warning about contact below the active part of a flank, on its Toprem or fillet.
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

/// Warning about flank points that interfere before the path of contact is reached.
fn overlap_warning(pair: &FlankPair, path: &ContactPath, diagnostics: &mut Vec<Diagnostic>) {
    let Some(overlap) = pair.overlap(path) else {
        return;
    };
    let [face, height] = overlap.shares.map(|share| 100.0 * share);
    let (depth, te) = (1e6 * overlap.depth, overlap.te.to_degrees() * 3600.0);
    diagnostics.push(Diagnostic {
        code: "overlap",
        message: format!(
            "the teeth overlap by {depth:.2} µm at {face:.0} % of the face and {height:.0} % of the height of the pinion; the transmission error there exceeds that of the path of contact by {te:.2} arcsec"
        ),
        hint: Some("change spiral angle, pressure angle or crowning where the ease-off falls; --torque covers the whole flank".into()),
    });
}

/// Positions of the middle pitch; the others repeat them.
pub fn one_pitch(points: &[BevelContactPoint], positions: usize) -> &[BevelContactPoint] {
    let count = points.len().min(positions + 1);
    let first = (points.len() - count) / 2;
    &points[first..first + count]
}

/// Outline of a contact ellipse in fractions of face and height of a member.
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

/// Semi-axes of a contact ellipse in fractions of face and height of a member, the major one first.
pub fn half_axes(
    pair: &FlankPair,
    point: &BevelContactPoint,
    member: usize,
) -> Option<[[f64; 2]; 2]> {
    let semi_axis = |angle: f64| -> Option<[f64; 2]> {
        let ends = [angle, angle + PI].map(|t| on_ellipse(pair, point, member, t));
        let [Some(a), Some(b)] = ends else {
            return None;
        };
        Some([0, 1].map(|k| 0.5 * (a[k] - b[k])))
    };
    Some([semi_axis(0.0)?, semi_axis(FRAC_PI_2)?])
}

/// Point of the outline of an ellipse at a parameter, rad, in fractions of face and height of a member.
fn on_ellipse(
    pair: &FlankPair,
    point: &BevelContactPoint,
    member: usize,
    angle: f64,
) -> Option<[f64; 2]> {
    let (contact, ellipse) = (&point.contact, point.ellipse.as_ref()?);
    let minor = contact.normal.cross(ellipse.direction);
    let [long, short] = ellipse.semi_axes;
    let (sin, cos) = angle.sin_cos();
    let p = contact.point + ellipse.direction * (long * cos) + minor * (short * sin);
    let (r, axis) = (p - pair.centre(member), pair.turn(member).w);
    let meridian = [r.dot(axis), axis.cross(r).norm()];
    pair.flanks[member].section.shares(meridian)
}

/// Extent of the pattern on a member.
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
