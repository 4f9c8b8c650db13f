//! A pair one flank of which carries the errors of the roll of its generator: each to first order, together on the exact envelope.

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

/// A pair as its generator cuts it.
#[derive(Debug, Clone)]
pub struct CutPair {
    /// The member that is cut: 0 pinion, 1 gear.
    pub member: usize,
    /// Touching flank of the member: 0 concave, 1 convex.
    pub side: usize,
    /// Effect of each error alone, to first order.
    pub effects: Vec<ErrorEffect>,
    /// Rows and columns of the map.
    pub grid: [usize; 2],
    /// Surplus along the normals of the ideal flank, m, of the smooth errors together on the exact envelope.
    pub surplus: Vec<Option<f64>>,
    /// Largest difference of that from the first order, m.
    pub first_order_error: f64,
    /// Peak-to-peak transmission error without load of the ideal and of the cut pair, rad.
    pub peak_to_peak: [f64; 2],
    /// The same under load: at the torque of the file, or of the machine that runs the pair.
    pub loaded: Option<CutLoad>,
    /// The cut flank.
    pub flank: BevelFlank,
    /// Blades at the feed of the generator, which are not on the cut flank; none where head or feed is not known.
    pub blades: Result<BladeEffect, &'static str>,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Effect of an error of the roll.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErrorEffect {
    /// Largest surplus on the flank over all phases, m.
    pub flank: f64,
    /// Largest peak-to-peak transmission error over a pitch and all phases, rad.
    pub te: f64,
    /// It is smooth enough to be part of the exact envelope.
    pub is_smooth: bool,
}

/// Transmission error under load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CutLoad {
    /// Torque of the pinion, N·m.
    pub torque: f64,
    /// Peak-to-peak of the ideal and of the cut pair, rad.
    pub peak_to_peak: [f64; 2],
}

impl CutPair {
    /// The pair of a file with errors of the roll on the touching flank of a member; under a torque of the pinion, N·m, and with blades at
    /// a feed, rad of the cradle in a turn of the cutter, where they are given.
    ///
    /// # Errors
    /// A flank that does not roll or is not described; flanks that do not touch at every angle; as [`LoadedPair::mesh`].
    pub fn new(
        file: &BevelFile,
        member: usize,
        errors: &[RollError],
        (torque, cradle_per_turn): (Option<f64>, Option<f64>),
    ) -> Result<CutPair, Error> {
        let refused = |why: &str, hint: &str| {
            Error::new(Code::OutOfRange, why)
                .with_span(&file.span)
                .with_hint(hint)
        };
        let sides = file.contact.side.flanks();
        let [Some(pinion), Some(gear)] = [0, 1].map(|k| file.flank(k, sides[k])) else {
            let hint = "give the settings of both flanks that touch";
            return Err(refused(
                "the flanks that touch are not both described",
                hint,
            ));
        };
        let hand = file.hand_of(member);
        let cut = file.members[member].flanks[sides[member]].as_ref();
        let Some(settings) = cut.map(|c| &c.settings).filter(|s| s.roll.is_some()) else {
            let hint = "a generated flank with its ratio of roll takes errors of the roll";
            return Err(refused("the flank that is cut does not roll", hint));
        };
        let ideal = [pinion, gear];
        let [rows, columns] = GRID;
        let grid = FlankGrid::of(&ideal[member], rows, columns)
            .ok_or_else(|| bevel_member::unreached(&file.members[member], member, sides[member]))?;
        let nodes = || grid.nodes.iter().map(flank_node);
        let apart = || {
            let hint = "`geardyn gear` on this file shows the contact and where it ends";
            refused("the flanks do not touch at every angle", hint)
        };
        let (pair, path) = touching(file, ideal.clone()).ok_or_else(apart)?;
        let positions = file.contact.positions;
        let contacts =
            rolled_contacts(&pair, &path, (member, hand), positions).ok_or_else(apart)?;
        let lever = nodes().flatten().map(|p| surplus_of_work(p, hand).abs());
        let lever = lever.fold(0.0, f64::max);
        let is_smooth = smooth(errors, nodes().flatten());
        let effects = (errors.iter().zip(&is_smooth)).map(|(error, is_smooth)| ErrorEffect {
            flank: lever * error.value.norm(),
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
                Some(flank.envelope.on_ray(p.point, p.normal, p.at)?.1)
            })
            .collect();
        let first = nodes().map(|point| {
            let p = point?;
            let error: f64 = applied.iter().map(|e| e.at(p.at[2], 0.0)).sum();
            Some(surplus_of_work(p, hand) * error)
        });
        let off = first
            .zip(&surplus)
            .filter_map(|(a, b)| Some((a? - (*b)?).abs()));
        let mut changed = ideal;
        changed[member] = flank.clone();
        let (cut_pair, cut_path) = touching(file, changed).ok_or_else(apart)?;
        let both = [(&pair, &path), (&cut_pair, &cut_path)];
        let ranges = both.map(|(pair, path)| pair.peak_to_peak(path, positions));
        let [Some(a), Some(b)] = ranges else {
            return Err(apart());
        };
        let mut diagnostics = Vec::new();
        Ok(CutPair {
            member,
            side: sides[member],
            effects: effects.collect(),
            grid: GRID,
            first_order_error: off.fold(0.0, f64::max),
            surplus,
            peak_to_peak: [a, b],
            loaded: match torque {
                Some(torque) => Some(under_load(file, both, torque, &mut diagnostics)?),
                None => None,
            },
            flank,
            blades: (cradle_per_turn.ok_or("`cutter` of [work] is not named"))
                .and_then(|feed| BladeEffect::of(file, member, (&pair, &path), feed)),
            diagnostics,
        })
    }

    /// Lowest and highest surplus of the map, m.
    pub fn surplus_range(&self) -> [f64; 2] {
        extremes(self.surplus.iter().flatten().copied()).into()
    }
}

/// The pair of two flanks with its path of contact; none where they do not touch near the middle.
fn touching(file: &BevelFile, flanks: [BevelFlank; 2]) -> Option<(FlankPair, ContactPath)> {
    let teeth = file.members.each_ref().map(|m| m.teeth);
    let pair = FlankPair::new(flanks, teeth, file.hand, &file.assembly());
    let pitches = PITCHES.max(file.contact.pitches);
    let path = pair.path_near_teeth(pitches, file.contact.positions)?;
    Some((pair, path))
}

/// Both pairs under a torque of the pinion.
fn under_load(
    file: &BevelFile,
    both: [(&FlankPair, &ContactPath); 2],
    torque: f64,
    diagnostics: &mut Vec<Diagnostic>,
) -> Result<CutLoad, Error> {
    let teeth = [0, 1].map(|k| bevel_member::tooth(file, k));
    let range = |flanks, diagnostics: &mut Vec<Diagnostic>| {
        let teeth = teeth.each_ref().map(Option::as_ref);
        let result = LoadedPair::new(file, teeth, flanks)?.mesh(&[torque], diagnostics)?;
        let te = result.mesh.cycles[0].of(|p| p.te);
        Ok(peak_to_peak(&te))
    };
    let ideal = range(both[0], &mut Vec::new())?;
    Ok(CutLoad {
        torque,
        peak_to_peak: [ideal, range(both[1], diagnostics)?],
    })
}
