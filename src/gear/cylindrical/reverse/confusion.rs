//! Candidates that readings leave open, and the readings that would part them.

use std::f64::consts::PI;

use super::candidate::Candidate;
use super::readings::GearReadings;
use super::standard_sizes::{ADDENDA, DEDENDA};

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
    /// Tip diameter: by so much, m, the usual tooth heights of the candidates differ at least.
    TipDiameter(f64),
    /// Root diameter, likewise.
    RootDiameter(f64),
    /// Spans over `teeth` more teeth than each other, whose difference the candidates see `difference` apart, m.
    Spans {
        /// Teeth between the two spans.
        teeth: u32,
        /// Difference, m.
        difference: f64,
    },
}

/// Two misfits nearer than this are not separated: 3 standard uncertainties of one reading.
const SEPARATED: f64 = 9.0;

/// Standard uncertainty of a diameter that was not read, m: a caliper's.
const DIAMETER_STD: f64 = 20e-6;

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
        let diameters = |c: &Candidate, coefficients: &[f64], sign: f64, shift: f64| -> Vec<f64> {
            let height = |h: &f64| sign * outward * 2.0 * c.gear.module * (h + sign * shift);
            coefficients
                .iter()
                .map(|h| c.gear.reference_diameter() + height(h))
                .collect()
        };
        let apart = |here: Vec<f64>, there: Vec<f64>| {
            let all = here
                .iter()
                .flat_map(|a| there.iter().map(move |b| (a - b).abs()));
            all.fold(f64::INFINITY, f64::min)
        };
        if self.tip_diameter.is_none() {
            let [here, there] =
                [best, other].map(|c| diameters(c, ADDENDA, 1.0, c.gear.profile_shift));
            remedies.push((
                apart(here, there) / DIAMETER_STD,
                Remedy::TipDiameter as fn(f64) -> Remedy,
            ));
        }
        if self.root_diameter.is_none() {
            let [here, there] =
                [best, other].map(|c| diameters(c, DEDENDA, -1.0, c.generating_shift.value));
            remedies.push((
                apart(here, there) / DIAMETER_STD,
                Remedy::RootDiameter as fn(f64) -> Remedy,
            ));
        }
        remedies.retain(|(strength, _)| *strength * *strength > SEPARATED);
        remedies.sort_by(|a, b| b.0.total_cmp(&a.0));
        let mut remedies: Vec<Remedy> = remedies
            .into_iter()
            .map(|(strength, remedy)| remedy(strength * DIAMETER_STD))
            .collect();
        // Spans reach from the first space to flanks a third of the teeth away.
        let teeth = (self.teeth / 3).max(1);
        let difference = f64::from(teeth) * base_pitch_difference;
        let std = self
            .spans
            .iter()
            .map(|span| span.size.std)
            .fold(0.0, f64::max);
        if difference > SEPARATED.sqrt() * std * std::f64::consts::SQRT_2 {
            remedies.push(Remedy::Spans { teeth, difference });
        }
        Confusion {
            candidates,
            base_pitch_difference,
            remedies,
        }
    }
}
