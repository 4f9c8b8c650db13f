//! Candidates that readings leave open, and the readings that would part them.

use std::f64::consts::PI;

use super::candidate::Candidate;
use super::readings::GearReadings;
use super::standard_sizes::{ADDENDA, DEDENDA};
use crate::gear::cylindrical::basic_rack::BasicRack;
use crate::gear::cylindrical::member::Member;

/// Two candidates that the readings do not separate, and what would.
#[derive(Debug, Clone, PartialEq)]
pub struct Confusion {
    /// Indices into the candidates.
    pub candidates: [usize; 2],
    /// Difference of their normal base pitches, m: what a difference of two spans would have to resolve for each tooth between them.
    pub base_pitch_difference: f64,
    /// Readings that would separate them, the strongest first.
    pub remedies: Vec<Remedy>,
}

/// A reading that would separate two candidates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Remedy {
    /// Tip diameter: least and greatest distance of a usual height of the first candidate from those of the other, m. A least of 0 says that
    /// the reading separates them by its value: some heights with their allowances have both.
    TipDiameter([f64; 2]),
    /// Root diameter, likewise.
    RootDiameter([f64; 2]),
    /// Spans over the fewest and the most teeth that the flanks allow, whose difference the candidates see `difference` apart, m.
    Spans {
        /// Teeth, of internal gears spaces, spanned.
        teeth: [u32; 2],
        /// Difference, m.
        difference: f64,
        /// Largest standard uncertainty of a span with which they are separated, m.
        std: f64,
    },
}

/// Two misfits nearer than this are not separated: 3 standard uncertainties of one reading.
const SEPARATED: f64 = 9.0;

/// Standard uncertainty of a diameter that was not read, m: a caliper's.
const DIAMETER_STD: f64 = 20e-6;

/// Least distance of two diameters that a reading separates, m: 3 standard uncertainties.
const RESOLVED: f64 = 3.0 * DIAMETER_STD;

/// Smallest standard uncertainty of a span that a reading can be expected to have, m: a disc micrometer's.
const FINEST_SPAN_STD: f64 = 1e-6;

impl GearReadings {
    /// Pairs of the best candidate with others, and readings that would part them.
    pub(super) fn confusions(&self, candidates: &[Candidate]) -> Vec<Confusion> {
        let Some(best) = candidates.first() else {
            return Vec::new();
        };
        let confused = |(i, other): (usize, &Candidate)| {
            (other.misfit - best.misfit < SEPARATED).then(|| self.confusion(best, other, [0, i]))
        };
        candidates
            .iter()
            .enumerate()
            .skip(1)
            .filter_map(confused)
            .collect()
    }

    fn confusion(&self, best: &Candidate, other: &Candidate, candidates: [usize; 2]) -> Confusion {
        let base_pitch = |c: &Candidate| PI * c.gear.module * c.gear.pressure_angle.cos();
        let base_pitch_difference = (base_pitch(best) - base_pitch(other)).abs();
        let mut remedies = Vec::new();
        let outward = if self.internal { -1.0 } else { 1.0 };
        // Limits of a diameter of height h·m over the profile shifted by the limits of a coefficient.
        let diameters = |c: &Candidate, coefficients: &[f64], sign: f64, shifts: [f64; 2]| {
            let height = |h: f64, shift| sign * outward * 2.0 * c.gear.module * (h + sign * shift);
            let at = |h: f64| shifts.map(|shift| c.gear.reference_diameter() + height(h, shift));
            coefficients.iter().map(|h| at(*h)).collect::<Vec<_>>()
        };
        // A distance below what a diameter resolves counts as none.
        let apart = |here: Vec<[f64; 2]>, there: Vec<[f64; 2]>| {
            let all = here
                .iter()
                .flat_map(|a| there.iter().map(move |b| interval_gap(*a, *b)));
            let least = all.fold(f64::INFINITY, f64::min);
            let resolved = if least > RESOLVED { least } else { 0.0 };
            [resolved, farthest(&here, &there)]
        };
        let mut add = |read: bool, here, there, remedy: fn([f64; 2]) -> Remedy| {
            let distances = apart(here, there);
            if !read && distances[1] > RESOLVED {
                remedies.push((distances, remedy));
            }
        };
        let tips = |c: &Candidate| diameters(c, ADDENDA, 1.0, self.profile_shifts(c));
        let read = self.tip_diameter.is_some();
        add(read, tips(best), tips(other), Remedy::TipDiameter);
        let roots = |c: &Candidate| diameters(c, DEDENDA, -1.0, [c.generating_shift.value; 2]);
        let read = self.root_diameter.is_some();
        add(read, roots(best), roots(other), Remedy::RootDiameter);
        remedies.sort_by(|a, b| (b.0[0].total_cmp(&a.0[0])).then(b.0[1].total_cmp(&a.0[1])));
        // Readings that separate by their value only come last.
        let certain = remedies.partition_point(|(distances, _)| distances[0] > 0.0);
        let mut remedies: Vec<Remedy> = remedies
            .into_iter()
            .map(|(distances, remedy)| remedy(distances))
            .collect();
        let teeth = self.span_limits(best);
        let difference = f64::from(teeth[1] - teeth[0]) * base_pitch_difference;
        let std = difference / (SEPARATED.sqrt() * std::f64::consts::SQRT_2);
        if std >= FINEST_SPAN_STD {
            let spans = Remedy::Spans {
                teeth,
                difference,
                std,
            };
            remedies.insert(certain, spans);
        }
        Confusion {
            candidates,
            base_pitch_difference,
            remedies,
        }
    }

    /// Least and greatest profile shift coefficient x of a candidate.
    fn profile_shifts(&self, candidate: &Candidate) -> [f64; 2] {
        let gear = &candidate.gear;
        let per_shift = 2.0 * gear.module * gear.pressure_angle.tan();
        let [thinnest, thickest] = self.thickness_deviations(gear.module);
        [thickest, thinnest].map(|e| candidate.generating_shift.value - e / per_shift)
    }

    /// Fewest and most teeth over which anvils touch the flanks of a candidate.
    fn span_limits(&self, candidate: &Candidate) -> [u32; 2] {
        let mut member = Member::new(candidate.gear, BasicRack::PROFILE_A, candidate.gear.module);
        member.tip_diameter = self.tip_diameter.map(|tip| tip.value);
        let touches = |k: &u32| member.span(*k).is_some();
        let usual = candidate.gear.default_span_teeth();
        let fewest = (1..usual).rev().take_while(touches).last();
        let most = (usual + 1..=self.teeth).take_while(touches).last();
        [fewest.unwrap_or(usual), most.unwrap_or(usual)]
    }
}

/// Greatest distance of an end or middle of the intervals `here` from the nearest of those `there`.
fn farthest(here: &[[f64; 2]], there: &[[f64; 2]]) -> f64 {
    let from_nearest = |x: f64| {
        let gaps = there.iter().map(|b| interval_gap([x; 2], *b));
        gaps.fold(f64::INFINITY, f64::min)
    };
    let places = here.iter().flat_map(|[a, b]| [*a, 0.5 * (a + b), *b]);
    places.map(from_nearest).fold(0.0, f64::max)
}

/// Distance of two intervals, whose limits come in either order; 0 where they overlap.
fn interval_gap(one: [f64; 2], other: [f64; 2]) -> f64 {
    let [[low1, high1], [low2, high2]] =
        [one, other].map(|[a, b]| [f64::min(a, b), f64::max(a, b)]);
    (low1 - high2).max(low2 - high1).max(0.0)
}
