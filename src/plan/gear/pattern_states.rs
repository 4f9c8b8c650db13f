//! Contacts of a bevel pair moved by V (offset) and H (pinion along its axis), over a grid of both.

use super::bevel_contact::{BevelContact, BevelContactPoint, leading};
use crate::gear::contact::pair::{Assembly, FlankPair};
use crate::gear::contact::reference::PatternShift;
use crate::scene::bevel_file::BevelFile;

/// Values of V and of H, the middle one 0.
const VALUES: usize = 7;
/// Positions in a pitch of each state.
const POSITIONS: usize = 24;

/// Contacts over a grid of V and H.
#[derive(Debug, Clone)]
pub struct PatternStates {
    /// Changes V of the offset, m.
    pub offsets: Vec<f64>,
    /// Changes H of the pinion's axial place, m.
    pub axials: Vec<f64>,
    /// For each V every H; none where the flanks do not touch on their teeth.
    pub states: Vec<Option<PatternState>>,
}

/// The contact at one V and H.
#[derive(Debug, Clone)]
pub struct PatternState {
    /// The pair in its places.
    pub pair: FlankPair,
    /// The leading pair over one pitch.
    pub points: Vec<BevelContactPoint>,
    /// Peak-to-peak of the transmission error over a pitch, rad; none where at some angle no pair touches.
    pub peak_to_peak: Option<f64>,
}

impl PatternStates {
    /// The states within the shifts of a V–H check, each way; none where it was not requested or finds none.
    pub fn of(file: &BevelFile, contact: &BevelContact) -> Option<PatternStates> {
        let check = contact.vh.as_ref()?;
        let most = |of: fn(&PatternShift) -> f64| {
            let sizes = check.iter().flatten().map(|shift| of(shift).abs());
            sizes.fold(0.0, f64::max)
        };
        let values = |most: f64| -> Vec<f64> {
            let half = (VALUES / 2) as f64;
            (0..VALUES)
                .map(|i| most * (i as f64 - half) / half)
                .collect()
        };
        let (v, h) = (most(|s| s.offset), most(|s| s.pinion_axial));
        if v == 0.0 || h == 0.0 {
            return None;
        }
        let (offsets, axials) = (values(v), values(h));
        let state = |offset: f64, axial: f64| moved(file, contact, [offset, axial]);
        Some(PatternStates {
            states: (offsets.iter())
                .flat_map(|v| axials.iter().map(|h| state(*v, *h)))
                .collect(),
            offsets,
            axials,
        })
    }
}

/// The state at `[V, H]`, its contact followed from the reference in parts.
fn moved(file: &BevelFile, contact: &BevelContact, shift: [f64; 2]) -> Option<PatternState> {
    const PARTS: usize = 4;
    let (assembly, study) = (file.assembly(), &file.contact);
    let at = |share: f64| {
        let moved = Assembly {
            offset: assembly.offset + share * shift[0],
            pinion_axial: assembly.pinion_axial + share * shift[1],
            ..assembly
        };
        FlankPair::new(
            contact.pair.flanks.clone(),
            contact.pair.teeth,
            file.hand,
            &moved,
        )
    };
    let mut near = contact.path.reference;
    for part in 1..=PARTS {
        let moved = at(part as f64 / PARTS as f64);
        let touched = moved.contact(near.pinion_angle, near.unknowns)?;
        // Without a place of the nominal ratio the contact at this angle is followed.
        near = moved.reference_near(&touched).unwrap_or(touched);
    }
    let moved = at(1.0);
    if !moved.is_near_teeth(&near) {
        return None;
    }
    let path = moved.path(near, study.pitches, POSITIONS);
    let points = leading(&moved, &path, 0.5, POSITIONS, study.coating);
    (!points.is_empty()).then(|| PatternState {
        peak_to_peak: moved.peak_to_peak(&path, POSITIONS),
        points,
        pair: moved,
    })
}
