//! Warnings of a pair: undercut, interference, contact ratio below 1, pointed tip, clearance; each with the nearest value that avoids it.
//!
//! Interference inside a ring: involute (the ring's tip reaches beyond the tangent point of the pinion's base circle), trochoid (tip
//! corners meet as the pinion leaves a space) and trimming (tip corners meet as the pinion is put in radially).

use std::f64::consts::FRAC_PI_2;

use super::involute::inv;
use super::pair::Pair;
use crate::base::bound::Bound;
use crate::gear::kernel::root::sign_change;

/// Kind of a warning, in the order in which they are listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum WarningKind {
    /// The tool cuts off part of the involute.
    Undercut,
    /// The mate's tip reaches inside the base circle, where no involute is.
    InvoluteInterference,
    /// The mate's tip reaches the fillet.
    FilletInterference,
    /// Inside a ring the tip corners meet outside the path of contact.
    TrochoidInterference,
    /// A pinion cannot be put into the ring radially; along the axis it can.
    TrimmingInterference,
    /// Total contact ratio below 1.
    ContactRatio,
    /// The flanks meet before the tip cylinder.
    PointedTip,
    /// The mate's tip touches the root circle.
    Clearance,
}

/// The value nearest to the present one that avoids what is warned of; lengths in m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NearestValue {
    /// Profile shift coefficient of a member.
    ProfileShift {
        /// Index of the member.
        member: usize,
        /// The coefficient.
        value: Bound,
    },
    /// Tip diameter of a member, m.
    TipDiameter {
        /// Index of the member.
        member: usize,
        /// The diameter.
        value: Bound,
    },
    /// Tip diameters of both members, m, both tips moved outward by the same amount.
    TipDiameters([Bound; 2]),
    /// Face width of both members, m.
    FaceWidth(Bound),
    /// Centre distance, m.
    CentreDistance(Bound),
    /// Tooth numbers and profile shift coefficients, with the rack's tips and the centre distance without backlash.
    Teeth {
        /// Tooth numbers.
        teeth: [u32; 2],
        /// Profile shift coefficients.
        shifts: [f64; 2],
        /// A pinion that can be put into its ring along the axis only stays so.
        axial_assembly: bool,
    },
}

/// A warning of a pair.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Warning {
    /// Kind.
    pub kind: WarningKind,
    /// The member it concerns: whose flank is undercut, reached or pointed.
    pub member: Option<usize>,
    /// By how much the limit is missed: a profile shift coefficient (undercut), m along the path (involute, fillet), rad of the ring
    /// (trochoid) or the pinion (trimming), a contact ratio, m of the diameter (pointed), m (clearance).
    pub by: f64,
    /// Value that avoids it; `None` where no value of that kind does.
    pub nearest: Option<NearestValue>,
}

/// Angle by which the tip corners of a pinion and a ring of given tip radius clear each other.
type Room = fn(&Pair, f64) -> Option<f64>;

/// Parts into which the height of a ring's tooth is divided to bracket a limit of its tip diameter.
const TIP_PARTS: usize = 64;

/// By how many modules both tips are lengthened at most in search of a contact ratio of 1.
const LONGEST_TIP: f64 = 3.0;

/// Parts of the path of a tip corner below the form circle of its mate at which it is compared with the fillet.
const CORNER_PARTS: usize = 128;

/// Angles nearer than this are equal: rounding of involutes and fillets, rad.
const ANGLE_ROUNDING: f64 = 1e-12;

impl WarningKind {
    /// The kinds that a pair can have, in their order; tip corners meet inside a ring only.
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
    /// The warnings, in the order of their kinds.
    pub fn warnings(&self) -> Vec<Warning> {
        let each =
            |f: fn(&Pair, usize) -> Option<Warning>| [f(self, 0), f(self, 1)].into_iter().flatten();
        let mut found: Vec<Warning> = each(Pair::undercut).collect();
        let mut interference: Vec<Warning> = each(Pair::flank_interference).collect();
        interference.extend(self.corner_interference());
        interference.sort_by_key(|warning| warning.kind);
        found.extend(interference);
        found.extend(self.short_contact());
        found.extend(each(Pair::pointed));
        found.extend(each(Pair::no_clearance));
        found
    }

    /// Tip diameters of a member that end its teeth at a diameter or before it.
    fn shortened(&self, member: usize, diameter: f64) -> Bound {
        match self.members[member].gear.internal {
            false => Bound::AtMost(diameter),
            true => Bound::AtLeast(diameter),
        }
    }

    /// Tip diameters of a member that end its teeth at a diameter or beyond it.
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

    /// The mate's tip against the flank of a member.
    fn flank_interference(&self, member: usize) -> Option<Warning> {
        let geometry = self.path_geometry();
        let ([c1, c2], tips) = (geometry.pitch_point(), geometry.tip_roll());
        let (outline, mate) = (&self.outlines[member], 1 - member);
        let form = outline.roll_length(outline.form_radius);
        // Inside an undercut the tool has made room down to the base circle.
        let allowed = if outline.undercut { 0.0 } else { form };
        // Length of roll at which the mate's tip meets the member, and that of the tip which would meet it at the allowed place.
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
        // Rounding of a tip that ends exactly at the limit is no interference.
        let is_real = by > 1e-12 * self.centre_distance;
        let has_room = kind == WarningKind::FilletInterference
            && self.members[member].rack.protuberance > 0.0
            && !self.outlines.iter().any(|outline| outline.internal)
            && !self.corner_cuts_fillet(member);
        (is_real && !has_room).then_some(Warning {
            kind,
            member: Some(member),
            by,
            nearest: (tip_roll > 0.0).then_some(NearestValue::TipDiameter {
                member: mate,
                value,
            }),
        })
    }

    /// True if the tip corner of the mate runs through the fillet of a member of an external pair: a protuberance may have made room there.
    fn corner_cuts_fillet(&self, member: usize) -> bool {
        let (own, mate) = (&self.outlines[member], &self.outlines[1 - member]);
        let a = self.centre_distance;
        let [r1, r2] =
            [own, mate].map(|outline| outline.base_radius / self.working_pressure_angle.cos());
        let (tip, form) = (mate.tip_radius, own.form_radius);
        // The corner lies at ψ_2w − ψ_a2 + φ₁/u from the line of centres where the member has turned by φ₁ from contact at the pitch point.
        let corner = mate.involute_half_angle(r2) - mate.involute_half_angle(tip);
        let farthest = ((a * a + tip * tip - form * form) / (2.0 * a * tip))
            .min(1.0)
            .acos();
        let is_inside = |part: usize| {
            let angle = farthest * (2.0 * part as f64 / CORNER_PARTS as f64 - 1.0);
            let (x, y) = (tip * angle.sin(), a - tip * angle.cos());
            let turn = (angle - corner) * r2 / r1;
            let from_middle = x.atan2(y) - turn + own.involute_half_angle(r1);
            let flank = own.half_angle(x.hypot(y));
            flank.is_some_and(|flank| flank - from_middle > ANGLE_ROUNDING)
        };
        (1..CORNER_PARTS).any(is_inside)
    }

    /// Trochoid and trimming interference of a pinion in a ring.
    fn corner_interference(&self) -> Vec<Warning> {
        if !self.members[1].gear.internal {
            return Vec::new();
        }
        let kinds: [(WarningKind, Room); 2] = [
            (WarningKind::TrochoidInterference, Pair::trochoid_room),
            (WarningKind::TrimmingInterference, Pair::trimming_room),
        ];
        let warning = |(kind, room): (WarningKind, Room)| {
            let tip = self.outlines[1].tip_radius;
            let by = -room(self, tip).filter(|room| *room < 0.0)?;
            // The limit nearest to the tip as the ring's teeth are shortened; where the corners do not meet at all there is room.
            let step = (self.outlines[1].form_radius - tip) / TIP_PARTS as f64;
            let free = |radius: f64| room(self, radius).unwrap_or(1.0);
            let nearest = (0..TIP_PARTS).find_map(|i| {
                let [low, high] = [i, i + 1].map(|i| tip + step * i as f64);
                let radius = sign_change([low, high], |radius| Some(free(radius)))?;
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

    /// Angle, of the ring, by which the pinion's tip corner passes clear of the ring's where the tip circles cross; `None` where they do
    /// not cross.
    fn trochoid_room(&self, ring_tip: f64) -> Option<f64> {
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

    /// Angle, of the pinion, by which its tip corners clear those of the ring as it moves along the line of centres, at the tooth where
    /// they come nearest; `None` where they never do.
    fn trimming_room(&self, ring_tip: f64) -> Option<f64> {
        let (u, tip) = (self.ratio(), self.outlines[0].tip_radius);
        // cos α_a1/cos α_a2 of the tip circles.
        let cosines = ring_tip / (u * tip);
        if cosines >= 1.0 {
            return None;
        }
        let first = (1.0 - cosines * cosines) / (1.0 - 1.0 / (u * u));
        let second = (1.0 / (cosines * cosines) - 1.0) / (u * u - 1.0);
        // A pinion wider than the ring's opening comes nearest where the opening is widest.
        let [at_first, at_second] = match second < 1.0 {
            true => [first, second].map(|sine_squared| sine_squared.sqrt().asin()),
            false => [(ring_tip / tip).min(1.0).asin(), FRAC_PI_2],
        };
        let (working, [involute1, involute2]) = self.tip_involutes(ring_tip);
        let of_ring = at_second + involute2 - working;
        Some(at_first + involute1 - working - u * of_ring)
    }

    /// inv α_wt, and inv α of the pinion's tip and of a ring's tip.
    fn tip_involutes(&self, ring_tip: f64) -> (f64, [f64; 2]) {
        let [pinion, ring] = [&self.outlines[0], &self.outlines[1]];
        let at = |base: f64, radius: f64| inv((base / radius).acos());
        (
            inv(self.working_pressure_angle),
            [
                at(pinion.base_radius, pinion.tip_radius),
                at(ring.base_radius, ring_tip),
            ],
        )
    }

    fn short_contact(&self) -> Option<Warning> {
        let total = self.contact_ratios().total;
        if total >= 1.0 {
            return None;
        }
        let tips = |longer: f64| {
            self.members
                .map(|member| member.tip_diameter() + 2.0 * member.sense() * longer)
        };
        let lengthened = |longer: f64| {
            let mut members = self.members;
            for (member, tip) in members.iter_mut().zip(tips(longer)) {
                member.tip_diameter = Some(tip);
            }
            let pair = Pair::new(members, Some(self.centre_distance)).ok()?;
            Some(pair.contact_ratios().total - 1.0)
        };
        let most = LONGEST_TIP * self.members[0].gear.module;
        let longer = sign_change([0.0, most], |longer| {
            Some(lengthened(longer).unwrap_or(-1.0))
        });
        Some(Warning {
            kind: WarningKind::ContactRatio,
            member: None,
            by: 1.0 - total,
            nearest: longer.map(|longer| {
                let [first, second] = tips(longer);
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
