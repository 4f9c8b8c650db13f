//! Candidates that the readings do not separate, and readings that would separate them.

use std::f64::consts::PI;

use super::candidate::Candidate;
use super::readings::GearReadings;
use super::standard_sizes::{ADDENDA, DEDENDA};
use crate::gear::cylindrical::basic_rack::BasicRack;
use crate::gear::cylindrical::member::Member;

/// Two candidates that the readings do not separate, with readings that would separate them.
#[derive(Debug, Clone, PartialEq)]
pub struct Ambiguity {
    /// Indices into the candidates.
    pub candidates: [usize; 2],
    /// Difference of the normal base pitches, m: resolution required of a difference of two spans, per tooth.
    pub base_pitch_difference: f64,
    /// Readings that would separate the candidates, in the order of their separation.
    pub remedies: Vec<Remedy>,
}

/// Reading that would separate two candidates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Remedy {
    /// Tip diameter: smallest and largest distance between the usual diameters of both candidates, m. A smallest distance of 0 means that
    /// only some values of the reading separate them, because the tolerance ranges overlap.
    TipDiameter([f64; 2]),
    /// Root diameter: distances as for the tip diameter, m.
    RootDiameter([f64; 2]),
    /// Spans over the smallest and the largest number of teeth that the flanks allow.
    Spans {
        /// Numbers of teeth spanned (internal gears: spaces).
        teeth: [u32; 2],
        /// Difference of the candidates in the difference of the two spans, m.
        difference: f64,
        /// Largest standard uncertainty of a span that separates the candidates, m.
        std: f64,
    },
}

/// Smallest difference of two misfits that separates candidates: 3 standard uncertainties of one reading.
const MISFIT_GAP: f64 = 9.0;

/// Standard uncertainty assumed for a diameter, m: caliper.
const DIAMETER_STD: f64 = 20e-6;

/// Smallest difference of diameters that a reading resolves, m: 3 standard uncertainties.
const RESOLUTION: f64 = 3.0 * DIAMETER_STD;

/// Smallest achievable standard uncertainty of a span, m: disc micrometer.
const MIN_SPAN_STD: f64 = 1e-6;

impl GearReadings {
    /// Pairs of the best candidate with the candidates that the readings do not separate from it.
    pub(super) fn ambiguities(&self, candidates: &[Candidate]) -> Vec<Ambiguity> {
        let Some(best) = candidates.first() else {
            return Vec::new();
        };
        let confusion = |(i, other): (usize, &Candidate)| {
            (other.misfit - best.misfit < MISFIT_GAP).then(|| self.confusion(best, other, [0, i]))
        };
        candidates
            .iter()
            .enumerate()
            .skip(1)
            .filter_map(confusion)
            .collect()
    }

    fn confusion(&self, best: &Candidate, other: &Candidate, candidates: [usize; 2]) -> Ambiguity {
        let base_pitch = |c: &Candidate| PI * c.gear.module * c.gear.pressure_angle.cos();
        let base_pitch_difference = (base_pitch(best) - base_pitch(other)).abs();
        let mut remedies = Vec::new();
        let outward = if self.internal { -1.0 } else { 1.0 };
        // Limits of a diameter with the height h·m over the reference profile, at the limits of the profile shift.
        let diameters = |c: &Candidate, coefficients: &[f64], sign: f64, shifts: [f64; 2]| {
            let height = |h: f64, shift| sign * outward * 2.0 * c.gear.module * (h + sign * shift);
            let limits = |h: f64| shifts.map(|x| c.gear.reference_diameter() + height(h, x));
            coefficients.iter().map(|h| limits(*h)).collect::<Vec<_>>()
        };
        // A distance below the resolution counts as zero.
        let distance_range = |first: Vec<[f64; 2]>, second: Vec<[f64; 2]>| {
            let gaps = first
                .iter()
                .flat_map(|a| second.iter().map(move |b| interval_gap(*a, *b)));
            let minimum = gaps.fold(f64::INFINITY, f64::min);
            let resolved = if minimum > RESOLUTION { minimum } else { 0.0 };
            [resolved, largest_distance(&first, &second)]
        };
        let mut add_remedy = |is_known: bool, first, second, remedy: fn([f64; 2]) -> Remedy| {
            let distances = distance_range(first, second);
            if !is_known && distances[1] > RESOLUTION {
                remedies.push((distances, remedy));
            }
        };
        let tips = |c: &Candidate| diameters(c, ADDENDA, 1.0, self.profile_shifts(c));
        let is_known = self.tip_diameter.is_some();
        add_remedy(is_known, tips(best), tips(other), Remedy::TipDiameter);
        let roots = |c: &Candidate| diameters(c, DEDENDA, -1.0, [c.generating_shift.value; 2]);
        let is_known = self.root_diameter.is_some();
        add_remedy(is_known, roots(best), roots(other), Remedy::RootDiameter);
        remedies.sort_by(|a, b| (b.0[0].total_cmp(&a.0[0])).then(b.0[1].total_cmp(&a.0[1])));
        // Readings that separate by some values only are last.
        let n_certain = remedies.partition_point(|(distances, _)| distances[0] > 0.0);
        let mut remedies: Vec<Remedy> = remedies
            .into_iter()
            .map(|(distances, remedy)| remedy(distances))
            .collect();
        let teeth = self.span_limits(best);
        let difference = f64::from(teeth[1] - teeth[0]) * base_pitch_difference;
        let std = difference / (MISFIT_GAP.sqrt() * std::f64::consts::SQRT_2);
        if std >= MIN_SPAN_STD {
            let spans = Remedy::Spans {
                teeth,
                difference,
                std,
            };
            remedies.insert(n_certain, spans);
        }
        Ambiguity {
            candidates,
            base_pitch_difference,
            remedies,
        }
    }

    /// Smallest and largest profile shift coefficient x of a candidate.
    fn profile_shifts(&self, candidate: &Candidate) -> [f64; 2] {
        let gear = &candidate.gear;
        let per_shift = 2.0 * gear.module * gear.pressure_angle.tan();
        let [thinnest, thickest] = self.thickness_deviations(gear.module);
        [thickest, thinnest].map(|e| candidate.generating_shift.value - e / per_shift)
    }

    /// Smallest and largest number of teeth over which the anvils touch the flanks of a candidate.
    fn span_limits(&self, candidate: &Candidate) -> [u32; 2] {
        let mut member = Member::new(candidate.gear, BasicRack::PROFILE_A, candidate.gear.module);
        member.tip_diameter = self.tip_diameter.map(|tip| tip.value);
        let touches = |k: &u32| member.span(*k).is_some();
        let default = candidate.gear.default_span_teeth();
        let min = (1..default).rev().take_while(touches).last();
        let max = (default + 1..=self.teeth).take_while(touches).last();
        [min.unwrap_or(default), max.unwrap_or(default)]
    }
}

/// Largest distance of an end or centre of the intervals `first` from the nearest interval of `second`.
fn largest_distance(first: &[[f64; 2]], second: &[[f64; 2]]) -> f64 {
    let distance = |x: f64| {
        let gaps = second.iter().map(|b| interval_gap([x; 2], *b));
        gaps.fold(f64::INFINITY, f64::min)
    };
    let points = first.iter().flat_map(|[a, b]| [*a, 0.5 * (a + b), *b]);
    points.map(distance).fold(0.0, f64::max)
}

/// Gap between two intervals with limits in any order; 0 if they overlap.
fn interval_gap(first: [f64; 2], second: [f64; 2]) -> f64 {
    let [[low1, high1], [low2, high2]] =
        [first, second].map(|[a, b]| [f64::min(a, b), f64::max(a, b)]);
    (low1 - high2).max(low2 - high1).max(0.0)
}
