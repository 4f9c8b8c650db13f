//! Harmonic errors of the roll of a generator, work against cradle, on a flank and its pair to first order.
//!
//! `ε(φ_c) = Re[a e^{i o φ_c}]`. The envelope moves along its normal by `δ = h n·(k×r) ε` (envelope theorem), n out of the metal, k the
//! axis of the work; a surplus δ where flanks touch turns the gear ahead by `δ/r₂`, r₂ the lever of the normal about the gear's axis.

use std::f64::consts::TAU;

use super::blade_passes::angle_lever;
use crate::gear::bevel::frames::WorkFrame;
use crate::gear::contact::contact_path::ContactPath;
use crate::gear::contact::pair::FlankPair;
use crate::gear::hand::Hand;
use crate::gear::kernel::envelope::FlankPoint;
use crate::gear::kernel::law::Law;
use crate::numeric::Complex;
use crate::numeric::sorting::ascending_order;
use crate::numeric::statistics::extremes;

/// Phases over which a range is compared.
const PHASES: usize = 72;
/// Share of D that the curvature of errors may take: with all of it the changed flank has an edge.
const SMOOTH: f64 = 0.5;

/// A harmonic error of the roll.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RollError {
    /// Amplitude and phase at φ_c = 0, rad of the work, ahead in the sense of its turn.
    pub value: Complex,
    /// Cycles in a turn of the cradle.
    pub order: f64,
}

/// A place of contact with what an error of the roll does there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RolledContact {
    /// Angle of the pinion, rad.
    pub pinion_angle: f64,
    /// Turn φ_c of the cradle as this place was cut, rad.
    pub turn: f64,
    /// Transmission error for a radian of error of the work.
    pub gain: f64,
}

impl RollError {
    /// The error at a turn of the cradle, rad; `ahead` shifts its phase.
    pub fn at(&self, turn: f64, ahead: f64) -> f64 {
        self.value.norm() * (self.order * turn + self.value.arg() + ahead).cos()
    }

    /// The error as a law of the cradle's turn.
    pub fn law(&self) -> Law {
        Law::Cosine {
            amplitude: self.value.norm(),
            order: self.order,
            phase: self.value.arg(),
        }
    }

    /// Second derivative over the cradle's turn, rad.
    fn waviness(&self) -> f64 {
        self.value.norm() * self.order * self.order
    }

    /// Largest peak-to-peak transmission error over contacts of any phase, rad.
    pub fn largest_range(&self, contacts: &[RolledContact]) -> f64 {
        let range = |ahead: f64| {
            let all = contacts.iter().map(|c| c.gain * self.at(c.turn, ahead));
            let (low, high) = extremes(all);
            high - low
        };
        let phases = (0..PHASES).map(|i| range(TAU * i as f64 / PHASES as f64));
        phases.fold(0.0, f64::max)
    }
}

/// Surplus of a flank along its normal for a radian of error of the work, m.
pub fn surplus_of_work(point: &FlankPoint<WorkFrame>, hand: Hand) -> f64 {
    hand.sign() * angle_lever(point)
}

/// The errors, from the smoothest on, whose flank has no edges together: their second derivatives stay within a share of D.
pub fn smooth<'a>(
    errors: &[RollError],
    points: impl Iterator<Item = &'a FlankPoint<WorkFrame>>,
) -> Vec<bool> {
    let room = points.map(|p| (p.second_order.undercut / angle_lever(p)).abs());
    let mut room = SMOOTH * room.fold(f64::INFINITY, f64::min);
    let order = ascending_order(errors.iter().map(RollError::waviness));
    let mut smooth = vec![false; errors.len()];
    for k in order {
        room -= errors[k].waviness();
        if room < 0.0 {
            break;
        }
        smooth[k] = true;
    }
    smooth
}

/// Leading contacts at equal steps over a pitch; none where at some angle no pair touches.
pub fn rolled_contacts(
    pair: &FlankPair,
    path: &ContactPath,
    (member, hand): (usize, Hand),
    positions: usize,
) -> Option<Vec<RolledContact>> {
    let out_of_metal = if member == 0 { 1.0 } else { -1.0 };
    let at = |i: usize| {
        let pinion_angle = path.reference.pinion_angle + pair.pitch() * i as f64 / positions as f64;
        let contact = pair.leading(path, pinion_angle)?.contact;
        let lever = |k: usize| pair.turn(k).at(contact.point).dot(contact.normal);
        Some(RolledContact {
            pinion_angle,
            turn: contact.unknowns[3 * member + 2],
            gain: hand.sign() * out_of_metal * lever(member) / lever(1).abs(),
        })
    };
    (0..positions).map(at).collect()
}
