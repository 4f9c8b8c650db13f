//! A flank of a bevel gear on its blank, found without hints: a scan of the cutter and the cradle, then Newton's method.

use std::f64::consts::TAU;

use super::cutter::Cutter;
use super::frames::{CutterFrame, WorkFrame};
use super::settings::{Hand, MachineSettings};
use super::tooth_section::ToothSection;
use crate::gear::kernel::envelope::{Envelope, FlankPoint};
use crate::gear::kernel::jet::Surface;
use crate::gear::kernel::limits::{Limit, limit_curves};
use crate::gear::kernel::meeting::Meeting;
use crate::gear::kernel::tool::{Line, Tool};

/// Blade length in depths of the tooth: the cutter reaches beyond the work.
const BLADE_DEPTHS: f64 = 3.0;
/// Largest turn of the cradle from its middle, rad.
const CRADLE_RANGE: f64 = 1.0;
/// Places of the cutter and of the cradle that a scan compares.
const SCAN: [usize; 2] = [96, 33];
/// Best places of a scan from which Newton's method starts.
const STARTS: usize = 24;
/// Weight of the cradle's turn squared, in radii of the work, against the distance of a start: of two places the one near the middle of
/// the roll is the flank.
const TURN_WEIGHT: f64 = 0.3;
/// Cells along cradle and cutter angle in which limits are traced.
const LIMIT_CELLS: [usize; 2] = [48, 48];

/// A flank of a bevel gear: what a cutter leaves of the work within an axial section.
#[derive(Debug, Clone)]
pub struct BevelFlank {
    /// The cutter's cone and its motion.
    pub envelope: Envelope<Tool<Line, CutterFrame>, WorkFrame>,
    /// The part of the flank that is the tooth.
    pub section: ToothSection,
}

impl BevelFlank {
    /// The flank a cutter makes at the settings of a machine.
    pub fn new(
        cutter: &Cutter,
        settings: &MachineSettings,
        hand: Hand,
        section: ToothSection,
    ) -> BevelFlank {
        BevelFlank {
            envelope: Envelope {
                surface: cutter.cone(BLADE_DEPTHS * section.depth()),
                motion: settings.motion(hand),
                range: [-CRADLE_RANGE, CRADLE_RANGE],
            },
            section,
        }
    }

    /// Parameters `[s, θ, φ_c]` at the middle of the section, without hints; none where the cutter does not reach it.
    pub fn middle(&self) -> Option<[f64; 3]> {
        self.find(self.section.at(0.5, 0.5))
    }

    /// Parameters `[s, θ, φ_c]` of the flank at `[z, radius]`, without hints.
    pub fn find(&self, place: [f64; 2]) -> Option<[f64; 3]> {
        let mut starts = self.scan(place);
        starts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let [from, to] = self.envelope.surface.range();
        let on_blade = |at: &[f64; 3]| from <= at[0] && at[0] <= to && at[2].abs() <= CRADLE_RANGE;
        let tried = starts.iter().take(STARTS);
        let mut found = tried.filter_map(|(_, start)| self.envelope.on_circle(place, *start));
        found.find(on_blade)
    }

    /// The flank's point at shares of face and height, from parameters near it.
    pub fn point(&self, [face, height]: [f64; 2], near: [f64; 3]) -> Option<FlankPoint<WorkFrame>> {
        let at = self
            .envelope
            .on_circle(self.section.at(face, height), near)?;
        self.envelope.point(at)
    }

    /// Curves of a limit within the section, near the parameters of its middle.
    pub fn limits(&self, limit: Limit, middle: [f64; 3]) -> Vec<Vec<FlankPoint<WorkFrame>>> {
        let [_, theta, _] = middle;
        let domain = [[-CRADLE_RANGE, CRADLE_RANGE], [theta - 0.5, theta + 0.5]];
        let mut curves = limit_curves(&self.envelope, limit, domain, LIMIT_CELLS);
        for curve in &mut curves {
            curve.retain(|p| {
                let r = p.point.coordinates;
                self.section.contains([r.z, f64::hypot(r.x, r.y)])
            });
        }
        curves.retain(|curve| !curve.is_empty());
        curves
    }

    /// Places where the cone touches, with a distance from `[z, radius]` that grows with the turn of the cradle.
    fn scan(&self, [z, radius]: [f64; 2]) -> Vec<(f64, [f64; 3])> {
        let envelope = &self.envelope;
        let fixed = envelope.motion.is_fixed();
        let [from, to] = envelope.surface.range();
        let mut found = Vec::new();
        for i in 0..SCAN[1] {
            let share = i as f64 / (SCAN[1] - 1) as f64;
            let x = if fixed {
                0.0
            } else {
                CRADLE_RANGE * (2.0 * share - 1.0)
            };
            let state = envelope.motion.at(x);
            for j in 0..SCAN[0] {
                let theta = TAU * j as f64 / SCAN[0] as f64;
                let mut s = from + share * (to - from);
                if !fixed {
                    let Some(jet) = envelope.surface.jet([s, theta]) else {
                        continue;
                    };
                    // f is linear in s on a cone.
                    let meeting = Meeting::new(&jet, &state);
                    s -= meeting.f / meeting.gradient[0];
                }
                if !(from <= s && s <= to) {
                    continue;
                }
                if let Some(jet) = envelope.surface.jet([s, theta]) {
                    let r = state.pose.apply(jet.r);
                    let distance = f64::hypot(r.z - z, f64::hypot(r.x, r.y) - radius);
                    found.push((distance + TURN_WEIGHT * radius * x * x, [s, theta, x]));
                }
            }
        }
        found
    }
}
