//! Bevel pair with roll errors of the generator on one flank: each error to first order, the smooth errors together on the exact envelope.

use super::bevel_member::{self, GRID};
use super::bevel_mesh::LoadedPair;
use super::blade_effect::BladeEffect;
use super::cut_flank::flank_node;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::gear::bevel::flank::BevelFlank;
use crate::gear::bevel::flank_grid::FlankGrid;
use crate::gear::contact::contact_path::{ContactPath, PITCHES};
use crate::gear::contact::pair::FlankPair;
use crate::gear::cut::roll_errors::{RollError, rolled_contacts, smooth, surplus_of_work};
use crate::gear::kernel::law::Law;
use crate::numeric::statistics::{extremes, peak_to_peak};
use crate::scene::bevel_file::BevelFile;

/// Bevel pair with the roll errors of its generator on one flank.
#[derive(Debug, Clone)]
pub struct CutPair {
    /// Member with the roll errors: 0 pinion, 1 gear.
    pub member: usize,
    /// Contacting flank of the member: 0 concave, 1 convex.
    pub side: usize,
    /// First-order effect of each error.
    pub effects: Vec<ErrorEffect>,
    /// Rows and columns of the map.
    pub grid: [usize; 2],
    /// Excess metal along the normals of the ideal flank, m, by the exact envelope of all smooth errors.
    pub surplus: Vec<Option<f64>>,
    /// Largest difference between `surplus` and its first-order estimate, m.
    pub first_order_error: f64,
    /// Peak-to-peak transmission error without load of the ideal and of the cut pair, rad.
    pub peak_to_peak: [f64; 2],
    /// Peak-to-peak transmission error under load: at the torque of the file, or of the machine that contains the pair.
    pub loaded: Option<CutLoad>,
    /// The cut flank.
    pub flank: BevelFlank,
    /// Effect of the discrete blades at the feed of the generator, not contained in `flank`; the reason if head or feed is unknown.
    pub blades: Result<BladeEffect, &'static str>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// First-order effect of a roll error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorEffect {
    /// Largest excess metal on the flank over all phases of the error, m.
    pub flank: f64,
    /// Largest peak-to-peak transmission error over one pitch and all phases of the error, rad.
    pub te: f64,
    /// True if the error is smooth enough for the exact envelope.
    pub is_smooth: bool,
}

/// Transmission error under load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutLoad {
    /// Torque of the pinion, N·m.
    pub torque: f64,
    /// Peak-to-peak transmission error of the ideal and of the cut pair, rad.
    pub peak_to_peak: [f64; 2],
}

impl CutPair {
    /// Pair of a file with roll errors on the contacting flank of a member; optionally loaded by a pinion torque, N·m, and with discrete
    /// blades at a feed, rad of the cradle per revolution of the cutter.
    ///
    /// # Errors
    /// A flank is not generated or not described; the flanks lose contact at some angle; errors of [`LoadedPair::mesh`].
    pub fn new(
        file: &BevelFile,
        member: usize,
        errors: &[RollError],
        (torque, cradle_per_turn): (Option<f64>, Option<f64>),
    ) -> Result<CutPair, Error> {
        let out_of_range = |why: &str, hint: &str| {
            Error::new(Code::OutOfRange, why)
                .with_span(&file.span)
                .with_hint(hint)
        };
        let sides = file.contact.side.flanks();
        let [Some(pinion), Some(gear)] = [0, 1].map(|k| file.flank(k, sides[k])) else {
            let hint = "give the settings of both flanks that touch";
            return Err(out_of_range(
                "the flanks that touch are not both described",
                hint,
            ));
        };
        let hand = file.hand_of(member);
        let flank_cut = file.members[member].flanks[sides[member]].as_ref();
        let Some(settings) = flank_cut.map(|c| &c.settings).filter(|s| s.roll.is_some()) else {
            let hint = "errors of the roll need a generated flank with its ratio of roll";
            return Err(out_of_range("the flank that is cut has no roll", hint));
        };
        let ideal = [pinion, gear];
        let [rows, columns] = GRID;
        let grid = FlankGrid::of(&ideal[member], rows, columns)
            .ok_or_else(|| bevel_member::unreached(&file.members[member], member, sides[member]))?;
        let nodes = || grid.nodes.iter().map(flank_node);
        let no_contact = || {
            let hint = "`geardyn gear` on this file shows the contact and where it ends";
            out_of_range("the flanks do not touch at every angle", hint)
        };
        let (pair, path) = pair_in_contact(file, ideal.clone()).ok_or_else(no_contact)?;
        let positions = file.contact.positions;
        let contacts =
            rolled_contacts(&pair, &path, (member, hand), positions).ok_or_else(no_contact)?;
        let max_gain = nodes().flatten().map(|p| surplus_of_work(p, hand).abs());
        let max_gain = max_gain.fold(0.0, f64::max);
        let is_smooth = smooth(errors, nodes().flatten());
        let effects = (errors.iter().zip(&is_smooth)).map(|(error, is_smooth)| ErrorEffect {
            flank: max_gain * error.value.norm(),
            te: error.largest_range(&contacts),
            is_smooth: *is_smooth,
        });
        let applied: Vec<&RollError> = (errors.iter().zip(&is_smooth))
            .filter_map(|(error, is_smooth)| is_smooth.then_some(error))
            .collect();
        let mut flank = ideal[member].clone();
        if let Some(law) = Law::sum(applied.iter().map(|e| e.law()).collect()) {
            let motion = settings.motion_with_errors(hand, [None, Some(law)]);
            flank = flank.in_motion(motion);
        }
        let surplus: Vec<Option<f64>> = nodes()
            .map(|point| {
                let p = point?;
                Some(flank.envelope.intersect_ray(p.point, p.normal, p.at)?.1)
            })
            .collect();
        let first_order_surplus = nodes().map(|point| {
            let p = point?;
            let error: f64 = applied.iter().map(|e| e.at(p.at[2], 0.0)).sum();
            Some(surplus_of_work(p, hand) * error)
        });
        let differences = first_order_surplus
            .zip(&surplus)
            .filter_map(|(a, b)| Some((a? - (*b)?).abs()));
        let mut cut_flanks = ideal;
        cut_flanks[member] = flank.clone();
        let (cut_pair, cut_path) = pair_in_contact(file, cut_flanks).ok_or_else(no_contact)?;
        let pairs = [(&pair, &path), (&cut_pair, &cut_path)];
        let ranges = pairs.map(|(pair, path)| pair.peak_to_peak(path, positions));
        let [Some(a), Some(b)] = ranges else {
            return Err(no_contact());
        };
        let mut diagnostics = Vec::new();
        Ok(CutPair {
            member,
            side: sides[member],
            effects: effects.collect(),
            grid: GRID,
            first_order_error: differences.fold(0.0, f64::max),
            surplus,
            peak_to_peak: [a, b],
            loaded: match torque {
                Some(torque) => Some(under_load(file, pairs, torque, &mut diagnostics)?),
                None => None,
            },
            flank,
            blades: (cradle_per_turn.ok_or("`cutter` of [work] is not named"))
                .and_then(|feed| BladeEffect::of(file, member, (&pair, &path), feed)),
            diagnostics,
        })
    }

    /// Minimum and maximum excess metal of the map, m.
    pub fn surplus_range(&self) -> [f64; 2] {
        extremes(self.surplus.iter().flatten().copied()).into()
    }
}

/// Pair of two flanks with its path of contact; `None` if they do not touch near the middle.
fn pair_in_contact(file: &BevelFile, flanks: [BevelFlank; 2]) -> Option<(FlankPair, ContactPath)> {
    let teeth = file.members.each_ref().map(|m| m.teeth);
    let pair = FlankPair::new(flanks, teeth, file.hand, &file.assembly());
    let pitches = PITCHES.max(file.contact.pitches);
    let path = pair.path_near_teeth(pitches, file.contact.positions)?;
    Some((pair, path))
}

/// Transmission error of the ideal and of the cut pair under a pinion torque, N·m.
fn under_load(
    file: &BevelFile,
    pairs: [(&FlankPair, &ContactPath); 2],
    torque: f64,
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<CutLoad, Error> {
    let teeth = [0, 1].map(|k| bevel_member::tooth(file, k));
    let te_range = |flanks, diagnostics: &mut Vec<Diagnostic>| {
        let teeth = teeth.each_ref().map(Option::as_ref);
        let result = LoadedPair::new(file, teeth, flanks)?.mesh(&[torque], diagnostics)?;
        let te = result.mesh.cycles[0].of(|p| p.te);
        Ok(peak_to_peak(&te))
    };
    let ideal = te_range(pairs[0], &mut Vec::new())?;
    Ok(CutLoad {
        torque,
        peak_to_peak: [ideal, te_range(pairs[1], diagnostics)?],
    })
}
