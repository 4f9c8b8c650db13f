//! Warnings of a cylindrical pair: undercut, interference, contact ratio below 1, pointed tip, clearance; with the nearest valid value.
//!
//! Interference in an internal pair: involute (ring tip beyond the tangent point of the pinion base circle), trochoid (tip
//! corners collide as the pinion leaves a space) and trimming (tip corners collide in radial assembly).

use std::f64::consts::FRAC_PI_2;

use super::involute::inv;
use super::pair::Pair;
use crate::base::bound::Bound;
use crate::gear::kernel::root::sign_change;

/// Warning kind, in the order of the list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum WarningKind {
    /// Undercut: the tool removes a segment of the involute.
    Undercut,
    /// Involute interference: the mate's tip enters the base circle.
    InvoluteInterference,
    /// Fillet interference: contact of the mate's tip with the fillet.
    FilletInterference,
    /// Trochoid interference: tip corners of an internal pair collide outside the path of contact.
    TrochoidInterference,
    /// Trimming interference: radial assembly of pinion and ring is impossible, axial assembly possible.
    TrimmingInterference,
    /// Total contact ratio below 1.
    ContactRatio,
    /// Pointed tooth: the flanks intersect below the tip cylinder.
    PointedTip,
    /// No bottom clearance: the mate's tip touches the root circle.
    Clearance,
}

/// Nearest value without the warning; lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NearestValue {
    /// Profile shift coefficient of a member.
    ProfileShift {
        /// Index of the member.
        member: usize,
        /// Bound of the profile shift coefficient.
        value: Bound,
    },
    /// Tip diameter of a member, m.
    TipDiameter {
        /// Index of the member.
        member: usize,
        /// Bound of the tip diameter, m.
        value: Bound,
    },
    /// Tip diameters of both members, m, with equal outward displacement of both tips.
    TipDiameters([Bound; 2]),
    /// Face width of both members, m.
    FaceWidth(Bound),
    /// Centre distance, m.
    CentreDistance(Bound),
    /// Tooth numbers and profile shift coefficients, with tips of the basic rack and backlash-free centre distance.
    Teeth {
        /// Tooth numbers.
        teeth: [u32; 2],
        /// Profile shift coefficients.
        shifts: [f64; 2],
        /// True if only axial assembly remains possible.
        axial_assembly: bool,
    },
}

/// Warning of a pair with its member, amount and nearest valid value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Warning {
    /// Warning kind.
    pub kind: WarningKind,
    /// Index of the affected member.
    pub member: Option<usize>,
    /// Amount beyond the limit: profile shift coefficient (undercut), m along the path (involute, fillet), rad of the ring
    /// (trochoid) or the pinion (trimming), contact ratio, m of the diameter (pointed), m (clearance).
    pub by: f64,
    /// Nearest value without the warning; `None` without a valid value of that kind.
    pub nearest: Option<NearestValue>,
}

/// Clearance angle between the tip corners of a pinion and a ring of a given tip radius, rad.
type CornerClearance = fn(&Pair, f64) -> Option<f64>;

/// Number of bracketing steps over the ring tooth height for a limit of the tip diameter.
const TIP_STEPS: usize = 64;

/// Largest tip extension in the search for a contact ratio of 1, in modules.
const MAX_EXTENSION: f64 = 3.0;

/// Number of tip-corner positions below the form circle of the mate in the fillet comparison.
const CORNER_STEPS: usize = 128;

/// Rounding tolerance of involute and fillet angles, rad.
const ANGLE_ROUNDING: f64 = 1e-12;

impl WarningKind {
    /// Possible warning kinds of a pair, in order; tip-corner interference only for internal pairs.
    pub fn of(pair: &Pair) -> impl Iterator<Item = WarningKind> {
        use WarningKind::{
            Clearance, ContactRatio, FilletInterference, InvoluteInterference, PointedTip,
            TrimmingInterference, TrochoidInterference, Undercut,
        };
        let in_ring = |kind| matches!(kind, TrochoidInterference | TrimmingInterference);
        let is_ring = pair.members[1].gear.internal;
        let all = [
            Undercut,
            InvoluteInterference,
            FilletInterference,
            TrochoidInterference,
            TrimmingInterference,
            ContactRatio,
            PointedTip,
            Clearance,
        ];
        all.into_iter()
            .filter(move |kind| is_ring || !in_ring(*kind))
    }
}

impl Pair {
    /// Warnings of the pair, in the order of kinds.
    pub fn warnings(&self) -> Vec<Warning> {
        let both =
            |f: fn(&Pair, usize) -> Option<Warning>| [f(self, 0), f(self, 1)].into_iter().flatten();
        let mut warnings: Vec<Warning> = both(Pair::undercut).collect();
        let mut interference: Vec<Warning> = both(Pair::flank_interference).collect();
        interference.extend(self.corner_interference());
        interference.sort_by_key(|warning| warning.kind);
        warnings.extend(interference);
        warnings.extend(self.short_contact());
        warnings.extend(both(Pair::pointed));
        warnings.extend(both(Pair::no_clearance));
        warnings
    }

    /// Bound of the tip diameter of a member for teeth no longer than to a diameter, m.
    fn shortened(&self, member: usize, diameter: f64) -> Bound {
        match self.members[member].gear.internal {
            false => Bound::AtMost(diameter),
            true => Bound::AtLeast(diameter),
        }
    }

    /// Bound of the tip diameter of a member for teeth no shorter than to a diameter, m.
    fn lengthened(&self, member: usize, diameter: f64) -> Bound {
        match self.members[member].gear.internal {
            false => Bound::AtLeast(diameter),
            true => Bound::AtMost(diameter),
        }
    }

    fn undercut(&self, member: usize) -> Option<Warning> {
        let (gear, outline) = (&self.members[member], &self.outlines[member]);
        let by = gear.least_shift_without_undercut() - outline.generating_shift;
        let value = Bound::AtLeast(gear.gear.profile_shift + by);
        outline.undercut.then_some(Warning {
            kind: WarningKind::Undercut,
            member: Some(member),
            by,
            nearest: Some(NearestValue::ProfileShift { member, value }),
        })
    }

    /// Interference of the mate's tip with the flank of a member.
    fn flank_interference(&self, member: usize) -> Option<Warning> {
        let geometry = self.path_geometry();
        let ([c1, c2], tips) = (geometry.pitch_point(), geometry.tip_roll());
        let (outline, mate) = (&self.outlines[member], 1 - member);
        let form = outline.roll_length(outline.form_radius);
        // With undercut the tool has removed metal down to the base circle.
        let allowed = if outline.undercut { 0.0 } else { form };
        // Length of roll of the member at contact with the mate's tip, and length of roll of the tip for contact at the limit.
        let (roll, tip_roll) = match (geometry.internal, member) {
            (false, _) => (c1 + c2 - tips[mate], c1 + c2 - allowed),
            (true, 0) => (tips[1] - (c2 - c1), c2 - c1 + allowed),
            (true, _) => (tips[0] + (c2 - c1), allowed - (c2 - c1)),
        };
        let (kind, by) = match outline.internal {
            true => (WarningKind::FilletInterference, roll - allowed),
            false if roll < 0.0 => (WarningKind::InvoluteInterference, -roll),
            false => (WarningKind::FilletInterference, allowed - roll),
        };
        let value = self.shortened(mate, self.members[mate].gear.diameter_at_roll(tip_roll));
        // Tolerance for a tip exactly at the limit.
        let is_real = by > 1e-12 * self.centre_distance;
        let is_relieved = kind == WarningKind::FilletInterference
            && self.members[member].rack.protuberance > 0.0
            && !self.outlines.iter().any(|outline| outline.internal)
            && !self.corner_cuts_fillet(member);
        (is_real && !is_relieved).then_some(Warning {
            kind,
            member: Some(member),
            by,
            nearest: (tip_roll > 0.0).then_some(NearestValue::TipDiameter {
                member: mate,
                value,
            }),
        })
    }

    /// True if the tip corner of the mate intersects the fillet of a member of an external pair, which a protuberance can relieve.
    fn corner_cuts_fillet(&self, member: usize) -> bool {
        let (gear, mate) = (&self.outlines[member], &self.outlines[1 - member]);
        let a = self.centre_distance;
        let [r1, r2] =
            [gear, mate].map(|outline| outline.base_radius / self.working_pressure_angle.cos());
        let (tip, form) = (mate.tip_radius, gear.form_radius);
        // The corner angle from the line of centres is ψ_2w − ψ_a2 + φ₁/u at the member rotation φ₁ from contact at the pitch point.
        let corner = mate.involute_half_angle(r2) - mate.involute_half_angle(tip);
        let max_angle = ((a * a + tip * tip - form * form) / (2.0 * a * tip))
            .min(1.0)
            .acos();
        let is_inside = |step: usize| {
            let angle = max_angle * (2.0 * step as f64 / CORNER_STEPS as f64 - 1.0);
            let (x, y) = (tip * angle.sin(), a - tip * angle.cos());
            let rotation = (angle - corner) * r2 / r1;
            let polar = x.atan2(y) - rotation + gear.involute_half_angle(r1);
            let flank = gear.half_angle(x.hypot(y));
            flank.is_some_and(|flank| flank - polar > ANGLE_ROUNDING)
        };
        (1..CORNER_STEPS).any(is_inside)
    }

    /// Trochoid and trimming interference of a pinion in a ring.
    fn corner_interference(&self) -> Vec<Warning> {
        if !self.members[1].gear.internal {
            return Vec::new();
        }
        let kinds: [(WarningKind, CornerClearance); 2] = [
            (WarningKind::TrochoidInterference, Pair::trochoid_clearance),
            (WarningKind::TrimmingInterference, Pair::trimming_clearance),
        ];
        let warning = |(kind, clearance): (WarningKind, CornerClearance)| {
            let tip = self.outlines[1].tip_radius;
            let by = -clearance(self, tip).filter(|clearance| *clearance < 0.0)?;
            // Nearest limit for shortened ring teeth; corners without intersection have positive clearance.
            let step = (self.outlines[1].form_radius - tip) / TIP_STEPS as f64;
            let clearance_at = |radius: f64| clearance(self, radius).unwrap_or(1.0);
            let nearest = (0..TIP_STEPS).find_map(|i| {
                let [low, high] = [i, i + 1].map(|i| tip + step * i as f64);
                let radius = sign_change([low, high], |radius| Some(clearance_at(radius)))?;
                let value = self.shortened(1, 2.0 * radius);
                Some(NearestValue::TipDiameter { member: 1, value })
            });
            Some(Warning {
                kind,
                member: Some(1),
                by,
                nearest,
            })
        };
        kinds.into_iter().filter_map(warning).collect()
    }

    /// Clearance angle of the ring between the tip corners at the intersection of the tip circles, rad; `None` without an
    /// intersection.
    fn trochoid_clearance(&self, ring_tip: f64) -> Option<f64> {
        let (a, tip) = (self.centre_distance, self.outlines[0].tip_radius);
        let [to_first, to_second] = [
            (ring_tip * ring_tip - tip * tip - a * a) / (2.0 * a * tip),
            (a * a + ring_tip * ring_tip - tip * tip) / (2.0 * a * ring_tip),
        ];
        if to_first.abs() > 1.0 || to_second.abs() > 1.0 {
            return None;
        }
        let (working, [involute1, involute2]) = self.tip_involutes(ring_tip);
        let first = to_first.acos() + involute1 - working;
        Some(first / self.ratio() + working - involute2 - to_second.acos())
    }

    /// Clearance angle of the pinion between tip corners in radial assembly along the line of centres, rad, at the tooth of closest
    /// approach; `None` without one.
    fn trimming_clearance(&self, ring_tip: f64) -> Option<f64> {
        let (u, tip) = (self.ratio(), self.outlines[0].tip_radius);
        // cos α_a1/cos α_a2 of the tip circles.
        let cosines = ring_tip / (u * tip);
        if cosines >= 1.0 {
            return None;
        }
        let first = (1.0 - cosines * cosines) / (1.0 - 1.0 / (u * u));
        let second = (1.0 / (cosines * cosines) - 1.0) / (u * u - 1.0);
        // Closest approach of a pinion wider than the ring opening is at the widest position of the opening.
        let [at_first, at_second] = match second < 1.0 {
            true => [first, second].map(|sine_squared| sine_squared.sqrt().asin()),
            false => [(ring_tip / tip).min(1.0).asin(), FRAC_PI_2],
        };
        let (working, [involute1, involute2]) = self.tip_involutes(ring_tip);
        let ring = at_second + involute2 - working;
        Some(at_first + involute1 - working - u * ring)
    }

    /// Involute angles inv α_wt, and inv α of the pinion tip and of a ring tip, rad.
    fn tip_involutes(&self, ring_tip: f64) -> (f64, [f64; 2]) {
        let [pinion, ring] = [&self.outlines[0], &self.outlines[1]];
        let involute = |base: f64, radius: f64| inv((base / radius).acos());
        (
            inv(self.working_pressure_angle),
            [
                involute(pinion.base_radius, pinion.tip_radius),
                involute(ring.base_radius, ring_tip),
            ],
        )
    }

    fn short_contact(&self) -> Option<Warning> {
        let total = self.contact_ratios().total;
        if total >= 1.0 {
            return None;
        }
        let tips = |extension: f64| {
            self.members
                .map(|member| member.tip_diameter() + 2.0 * member.sense() * extension)
        };
        let lengthened = |extension: f64| {
            let mut members = self.members;
            for (member, tip) in members.iter_mut().zip(tips(extension)) {
                member.tip_diameter = Some(tip);
            }
            let pair = Pair::new(members, Some(self.centre_distance)).ok()?;
            Some(pair.contact_ratios().total - 1.0)
        };
        let max_extension = MAX_EXTENSION * self.members[0].gear.module;
        let extension = sign_change([0.0, max_extension], |extension| {
            Some(lengthened(extension).unwrap_or(-1.0))
        });
        Some(Warning {
            kind: WarningKind::ContactRatio,
            member: None,
            by: 1.0 - total,
            nearest: extension.map(|extension| {
                let [first, second] = tips(extension);
                NearestValue::TipDiameters([self.lengthened(0, first), self.lengthened(1, second)])
            }),
        })
    }

    fn pointed(&self, member: usize) -> Option<Warning> {
        let (point, sense) = (
            2.0 * self.outlines[member].tip_radius,
            self.members[member].sense(),
        );
        let by = sense * (self.members[member].tip_diameter() - point);
        let value = self.shortened(member, point);
        (by > 0.0).then_some(Warning {
            kind: WarningKind::PointedTip,
            member: Some(member),
            by,
            nearest: Some(NearestValue::TipDiameter { member, value }),
        })
    }

    fn no_clearance(&self, member: usize) -> Option<Warning> {
        let by = -self.bottom_clearances()[member];
        let mate = 1 - member;
        let tip = self.members[mate].tip_diameter() - 2.0 * self.members[mate].sense() * by;
        let value = self.shortened(mate, tip);
        (by >= 0.0).then_some(Warning {
            kind: WarningKind::Clearance,
            member: Some(member),
            by,
            nearest: Some(NearestValue::TipDiameter {
                member: mate,
                value,
            }),
        })
    }
}
