//! A flank of a bevel gear on its blank, found without hints: a scan of the cutter and the cradle, then Newton's method.

use std::f64::consts::TAU;

use super::cutter::{BladeSurface, BladeSurfaces, Cutter};
use super::frames::{CutterFrame, WorkFrame};
use super::settings::MachineSettings;
use super::tooth_section::ToothSection;
use crate::gear::hand::Hand;
use crate::gear::kernel::envelope::{Envelope, FlankPoint};
use crate::gear::kernel::jet::Surface;
use crate::gear::kernel::meeting::Meeting;
use crate::gear::kernel::motion::Motion;
use crate::gear::kernel::root::sign_change;
use crate::numeric::sorting::sort_rising;

/// Blade length in depths of the tooth: the cutter reaches beyond the work.
pub const BLADE_DEPTHS: f64 = 3.0;
/// Largest turn of the cradle from its middle, rad.
const CRADLE_RANGE: f64 = 1.0;
/// Places of the cutter and of the cradle that a scan compares.
const SCAN: [usize; 2] = [96, 33];
/// Best places of a scan from which Newton's method starts.
const STARTS: usize = 24;
/// Weight of the cradle's turn squared, in radii of the work, against the distance of a start: of two places the one near the middle of
/// the roll is the flank.
const TURN_WEIGHT: f64 = 0.3;
/// Weight of the height of a start on the blade, in lengths of the blade, against its distance: of two places on the cutter the one nearer
/// its tip is the flank.
const HEIGHT_WEIGHT: f64 = 0.5;
/// Weight of the distance of a start on fixed work from the plane of its axis in which the machine cuts, as far as it lies behind it: the
/// cutter passes each circle of the work twice.
const BEHIND_WEIGHT: f64 = 1.0;
/// Steps along the blade in which the limit of undercut is sought.
const BLADE_STEPS: usize = 24;

/// Steps from one place to another where one step fails.
const SMALL_STEPS: u32 = 16;

/// A point this far beyond the end of a part of the blade, in lengths of it, is on it.
const ON_BLADE: f64 = 1e-9;
/// Shares of a part of the blade below the flank from which its points are sought.
const PART_STARTS: [f64; 3] = [0.7, 0.3, 0.95];

/// The envelope of a part of the blade, or of the plane of a crown gear, on the work.
pub type FlankEnvelope = Envelope<BladeSurface, WorkFrame>;

/// A flank of a bevel gear: what a cutter leaves of the work within an axial section.
#[derive(Debug, Clone)]
pub struct BevelFlank {
    /// The blade and its motion.
    pub envelope: FlankEnvelope,
    /// The Toprem with the same motion.
    pub toprem: Option<FlankEnvelope>,
    /// The edge with the same motion; none for a sharp edge.
    pub edge: Option<FlankEnvelope>,
    /// The part of the flank that is the tooth.
    pub section: ToothSection,
}

/// A point of the tooth: on the flank or in the fillet.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ToothPoint {
    /// The point.
    pub point: FlankPoint<WorkFrame>,
    /// The Toprem or the edge of the cutter makes it.
    pub in_fillet: bool,
}

impl ToothPoint {
    /// Whether the point lies beyond the limit of undercut: `D > 0`, the tool would be within the metal there.
    pub fn is_cut_away(&self) -> bool {
        is_cut_away(&self.point)
    }
}

/// See [`ToothPoint::is_cut_away`]; normals point out of the metal, so that the tool's curvature exceeds the flank's, `p²/D < 0`.
pub fn is_cut_away(point: &FlankPoint<WorkFrame>) -> bool {
    point.second_order.undercut > 0.0
}

impl BevelFlank {
    /// The flank a cutter makes at the settings of a machine.
    pub fn new(
        cutter: &Cutter,
        settings: &MachineSettings,
        hand: Hand,
        section: ToothSection,
    ) -> BevelFlank {
        let surfaces = cutter.surfaces(BLADE_DEPTHS * section.depth());
        BevelFlank::of_blade(surfaces, settings.motion(hand), section)
    }

    /// The flank that the surfaces of a blade make in a motion.
    pub fn of_blade(
        surfaces: BladeSurfaces,
        motion: Motion<WorkFrame, CutterFrame>,
        section: ToothSection,
    ) -> BevelFlank {
        let of = |surface| Envelope {
            surface,
            motion: motion.clone(),
            range: [-CRADLE_RANGE, CRADLE_RANGE],
        };
        BevelFlank {
            envelope: of(surfaces.blade),
            toprem: surfaces.toprem.map(of),
            edge: surfaces.edge.map(of),
            section,
        }
    }

    /// The flank that the same blade makes in another motion.
    pub fn in_motion(&self, motion: Motion<WorkFrame, CutterFrame>) -> BevelFlank {
        let surface = |part: &FlankEnvelope| part.surface;
        let surfaces = BladeSurfaces {
            blade: surface(&self.envelope),
            toprem: self.toprem.as_ref().map(surface),
            edge: self.edge.as_ref().map(surface),
        };
        BevelFlank::of_blade(surfaces, motion, self.section)
    }

    /// Parameters `[s, θ, φ_c]` at the middle of the section, without hints; none where the cutter does not reach it.
    pub fn middle(&self) -> Option<[f64; 3]> {
        self.find(self.section.at(0.5, 0.5))
    }

    /// Parameters `[s, θ, φ_c]` of the flank at `[z, radius]`, without hints; of several the part that no undercut removes.
    pub fn find(&self, place: [f64; 2]) -> Option<[f64; 3]> {
        let mut starts = self.scan(place);
        sort_rising(&mut starts, |a| a.0);
        let [from, to] = self.envelope.surface.range();
        let on_blade = |at: &[f64; 3]| from <= at[0] && at[0] <= to && at[2].abs() <= CRADLE_RANGE;
        let tried = starts.iter().take(STARTS);
        let mut cut_away = None;
        for at in tried.filter_map(|(_, start)| self.envelope.on_circle(place, *start)) {
            let point = self.envelope.point(at);
            if on_blade(&at) && point.is_some_and(|point| !is_cut_away(&point)) {
                return Some(at);
            }
            cut_away = cut_away.or(Some(at).filter(on_blade));
        }
        cut_away
    }

    /// The flank's point at shares of face and height, from parameters near it.
    pub fn point(&self, [face, height]: [f64; 2], near: [f64; 3]) -> Option<FlankPoint<WorkFrame>> {
        let at = self
            .envelope
            .on_circle(self.section.at(face, height), near)?;
        self.envelope.point(at)
    }

    /// The tooth's point at `[z, radius]`, from parameters of the flank near it: on the flank above the end of the blade, else where Toprem
    /// or edge make it. None where the cutter leaves neither.
    ///
    /// Blade and Toprem meet in a hollow corner, about which both may reach a place; the one that cuts deeper makes the tooth.
    pub fn tooth_point(&self, place: [f64; 2], near: [f64; 3]) -> Option<ToothPoint> {
        let at = self.envelope.on_circle(place, near);
        let [_, theta, x] = at.unwrap_or(near);
        let [from, to] = self.envelope.surface.range();
        let on_blade = at.filter(|at| at[0] >= from - ON_BLADE * (to - from));
        let mut deepest = match on_blade {
            Some(at) => Some(ToothPoint {
                point: self.envelope.point(at)?,
                in_fillet: false,
            }),
            None => None,
        };
        for part in self.toprem.iter().chain(&self.edge) {
            // An edge goes on in the tangent of the blade: the two reach no place twice.
            if deepest.is_some() && self.toprem.is_none() {
                break;
            }
            let [first, last] = part.surface.range();
            let room = ON_BLADE * (last - first);
            let starts = PART_STARTS.map(|share| first + share * (last - first));
            let mut found = (starts.iter()).filter_map(|u| part.on_circle(place, [*u, theta, x]));
            let on_part = |at: &[f64; 3]| first - room <= at[0] && at[0] <= last + room;
            let Some(point) = found.find(on_part).and_then(|at| part.point(at)) else {
                continue;
            };
            let above = |other: &ToothPoint| {
                let apart = point.point.coordinates - other.point.point.coordinates;
                apart.dot(other.point.normal.components) >= 0.0
            };
            if !deepest.as_ref().is_some_and(above) {
                deepest = Some(ToothPoint {
                    point,
                    in_fillet: true,
                });
            }
        }
        deepest
    }

    /// Parameters at a place from those at another, in small steps between both; none where Newton's method fails at one.
    pub fn follow(&self, (at, from): ([f64; 3], [f64; 2]), to: [f64; 2]) -> Option<[f64; 3]> {
        (1..=SMALL_STEPS).try_fold(at, |at, k| {
            let share = f64::from(k) / f64::from(SMALL_STEPS);
            let place = [0, 1].map(|i| from[i] + share * (to[i] - from[i]));
            self.envelope.on_circle(place, at)
        })
    }

    /// The limit of undercut on the line from tip to root at a share of the face: the first point with D = 0 between a point of the flank
    /// near that line and the end of the blade. None where D keeps its sign.
    ///
    /// The flank turns back on the line there, so that a place has two points above the limit and none below; the blade has one at each s.
    pub fn undercut_limit(&self, face: f64, near: [f64; 3]) -> Option<FlankPoint<WorkFrame>> {
        let line = self.section.profile(face);
        let point = |s: f64, [_, theta, x]: [f64; 3]| {
            let at = self.envelope.on_section_line(s, line, [theta, x])?;
            self.envelope.point(at)
        };
        let [end, _] = self.envelope.surface.range();
        let mut before = point(near[0], near)?;
        for k in 1..=BLADE_STEPS {
            let s = near[0] + (end - near[0]) * k as f64 / BLADE_STEPS as f64;
            let here = point(s, before.at)?;
            if !is_cut_away(&before) && is_cut_away(&here) {
                let undercut = |s: f64| Some(point(s, before.at)?.second_order.undercut);
                return point(sign_change([before.at[0], s], undercut)?, before.at);
            }
            before = here;
        }
        None
    }

    /// Whether the end of the blade undercuts the flank at a share of the face, from a point of the flank near there.
    pub fn is_undercut(&self, face: f64, [_, theta, x]: [f64; 3]) -> bool {
        let [end, _] = self.envelope.surface.range();
        let line = self.section.profile(face);
        let at_end = self.envelope.on_section_line(end, line, [theta, x]);
        let point = at_end.and_then(|at| self.envelope.point(at));
        point.is_none_or(|point| is_cut_away(&point))
    }

    /// Places where the cone touches, with a distance from `[z, radius]` that grows with the turn of the cradle and the height on the blade, of fixed
    /// work with the azimuth.
    fn scan(&self, [z, radius]: [f64; 2]) -> Vec<(f64, [f64; 3])> {
        let envelope = &self.envelope;
        let fixed = envelope.motion.is_fixed();
        // The plane of a crown gear has no tip.
        let height_weight = if envelope.surface.is_turned() {
            HEIGHT_WEIGHT
        } else {
            0.0
        };
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
                    // f is linear in s on a cone, and nearly so on an arc.
                    let meeting = Meeting::new(&jet, &state);
                    s -= meeting.f / meeting.gradient[0];
                }
                if !(from <= s && s <= to) {
                    continue;
                }
                if let Some(jet) = envelope.surface.jet([s, theta]) {
                    let r = state.pose.apply(jet.r);
                    let distance = f64::hypot(r.z - z, f64::hypot(r.x, r.y) - radius);
                    let aside = match fixed {
                        true => BEHIND_WEIGHT * (f64::hypot(r.x, r.y) - r.x),
                        false => TURN_WEIGHT * radius * x * x + height_weight * (s - from),
                    };
                    found.push((distance + aside, [s, theta, x]));
                }
            }
        }
        found
    }
}
