//! A standard gear fitted to readings: x_E from the spans by least squares, tooth heights from the diameters, backlash from the mate.

use std::f64::consts::PI;

use super::readings::{GearReadings, Reading, SpanReading};
use super::standard_sizes::{ADDENDA, DEDENDA, ToothSize, nearest};
use crate::gear::cylindrical::basic_rack::BasicRack;
use crate::gear::cylindrical::involute::{InvoluteGear, inv};
use crate::gear::cylindrical::member::Member;
use crate::gear::cylindrical::pair::profile_shift_sum;

/// A gear that the readings may come from.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Standard size.
    pub size: ToothSize,
    /// The gear, with the profile shift coefficient x where it is known, else with x_E.
    pub gear: InvoluteGear,
    /// Generating profile shift coefficient x_E, and its standard uncertainty.
    pub generating_shift: Reading,
    /// Deviation E_sn of the normal thickness, m: as stated, else that with which the tip diameter comes nearest to a usual addendum;
    /// `None` where neither is given.
    pub thickness_deviation: Option<f64>,
    /// Addendum coefficient h_aP + k of the tip diameter, and the usual coefficient nearest to it.
    pub addendum: Option<[f64; 2]>,
    /// Dedendum coefficient h_fP of the root diameter, and the usual coefficient nearest to it.
    pub dedendum: Option<[f64; 2]>,
    /// Generating profile shift coefficient of the mate: from its spans, else from the centre distance without backlash.
    pub mate_shift: Option<f64>,
    /// Normal backlash at the centre distance where the mate's spans are known, m.
    pub backlash: Option<f64>,
    /// Sum of the squares of the deviations of all readings in their standard uncertainties.
    pub misfit: f64,
    /// Largest deviation of a reading in its standard uncertainty.
    pub largest_deviation: f64,
}

impl Candidate {
    /// Clearance coefficient c* = h_fP − h_aP of the usual coefficients; `None` where a diameter was not read.
    pub fn clearance(&self) -> Option<f64> {
        Some(self.dedendum?[1] - self.addendum?[1])
    }

    /// Profile shift coefficient x; `None` where the thickness deviation is not known.
    pub fn profile_shift(&self) -> Option<f64> {
        self.thickness_deviation.map(|_| self.gear.profile_shift)
    }
}

/// A gear of given size fitted to the spans.
struct FlankFit {
    /// With the shift x_E.
    gear: InvoluteGear,
    /// x_E.
    shift: Reading,
    /// Deviations of the spans, in standard uncertainties.
    deviations: Vec<f64>,
    /// Coefficients of the diameters as heights over the profile shifted by x_E: h_aP + x − x_E and h_fP.
    heights: [Option<f64>; 2],
}

impl GearReadings {
    /// The gear of a standard size fitted to the readings, and the largest deviation of a span, in standard uncertainties.
    pub(super) fn fit(&self, size: ToothSize, pressure_angle: f64) -> Option<(f64, Candidate)> {
        let module = size.module();
        let fit = self.fit_flank(module, pressure_angle, 0.0)?;
        let (mut gear, mut deviations) = (fit.gear, fit.deviations);
        let (mate_shift, backlash) = self.fit_mate(&gear, fit.shift, &mut deviations);
        let widest = largest(&deviations);
        // What the uncertainty of the helix angle makes of the coefficients.
        let turned = match self.tip_helix {
            Some(helix) => self.fit_flank(module, pressure_angle, helix.std)?.heights,
            None => fit.heights,
        };
        // x_E − x at the limits of the thickness deviation: only the tip is turned with x, the root is cut with x_E.
        let per_shift = 2.0 * module * pressure_angle.tan();
        let allowances = self.thickness_deviations(module).map(|e| e / per_shift);
        let diameters = [self.tip_diameter, self.root_diameter];
        let usual = [ADDENDA, DEDENDA];
        let unknown = [allowances, [0.0; 2]];
        let [addendum, dedendum] = [0, 1].map(|i| {
            let (reading, height) = (diameters[i]?, fit.heights[i]?);
            let [value, nearest] = nearest(usual[i], unknown[i].map(|shift| height + shift));
            let of_helix = height - turned[i]?;
            let std = (reading.std / (2.0 * module))
                .hypot(fit.shift.std)
                .hypot(of_helix);
            deviations.push((value - nearest) / std);
            Some([value, nearest])
        });
        let of_tip = addendum.zip(fit.heights[0]);
        let of_tip = of_tip.map(|([value, _], height)| per_shift * (value - height));
        let thickness_deviation = self.thickness_deviation.or(of_tip);
        gear.profile_shift -= thickness_deviation.unwrap_or(0.0) / per_shift;
        let candidate = Candidate {
            size,
            gear,
            generating_shift: fit.shift,
            thickness_deviation,
            addendum,
            dedendum,
            mate_shift,
            backlash,
            misfit: deviations.iter().map(|d| d * d).sum(),
            largest_deviation: largest(&deviations),
        };
        (widest.is_finite() && candidate.misfit.is_finite()).then_some((widest, candidate))
    }

    /// A gear fitted to the spans, with the helix angle of the tip turned by `turn`; `None` where it has no helix angle.
    fn fit_flank(&self, module: f64, pressure_angle: f64, turn: f64) -> Option<FlankFit> {
        let helix = self.helix(module, turn);
        let plain = InvoluteGear {
            teeth: self.teeth,
            module,
            pressure_angle,
            helix,
            profile_shift: 0.0,
            internal: self.internal,
        };
        let (shift, deviations) = fit_shift(&plain, &self.spans);
        // Heights outward and inward from the reference circle, in modules.
        let outward = if self.internal { -1.0 } else { 1.0 };
        let height = |reading: Reading| {
            outward * 0.5 * (reading.value - plain.reference_diameter()) / module
        };
        helix.is_finite().then_some(FlankFit {
            gear: InvoluteGear {
                profile_shift: shift.value,
                ..plain
            },
            shift,
            deviations,
            heights: [
                self.tip_diameter.map(|tip| height(tip) - shift.value),
                self.root_diameter.map(|root| shift.value - height(root)),
            ],
        })
    }

    /// Helix angle at the reference cylinder for a module, with that of the tip turned by `turn`; NaN where the gear would have none.
    fn helix(&self, module: f64, turn: f64) -> f64 {
        let (Some(helix), Some(tip)) = (self.tip_helix, self.tip_diameter) else {
            return 0.0;
        };
        (f64::from(self.teeth) * module * (helix.value + turn).tan() / tip.value).asin()
    }

    /// Generating shift of the mate and the normal backlash; adds the deviations of the mate's spans, and of a negative backlash.
    fn fit_mate(
        &self,
        gear: &InvoluteGear,
        own: Reading,
        deviations: &mut Vec<f64>,
    ) -> (Option<f64>, Option<f64>) {
        let Some(mate) = &self.mate else {
            return (None, None);
        };
        let other = InvoluteGear {
            teeth: mate.teeth,
            internal: mate.internal,
            profile_shift: 0.0,
            ..*gear
        };
        let mut members =
            [*gear, other].map(|gear| Member::new(gear, BasicRack::PROFILE_A, gear.module));
        if gear.internal {
            members.reverse();
        }
        let sum = |centre: Reading| profile_shift_sum(&members, centre.value);
        if mate.spans.is_empty() {
            let shift = mate.centre_distance.map(|centre| sum(centre) - own.value);
            return (shift.filter(|x| x.is_finite()), None);
        }
        let (shift, of_spans) = fit_shift(&other, &mate.spans);
        deviations.extend(of_spans);
        let backlash = mate.centre_distance.and_then(|centre| {
            // Shifts below those without backlash thin the teeth: j_bn = 2 m (Σx − x₁ − x₂) sin α_n.
            let sine = 2.0 * gear.pressure_angle.sin();
            let backlash = sine * gear.module * (sum(centre) - own.value - shift.value);
            let of_shifts = sine * gear.module * own.std.hypot(shift.std);
            // Teeth cannot overlap; how much backlash was wanted is not known.
            deviations.push(backlash.min(0.0) / of_shifts.hypot(sine * centre.std));
            backlash.is_finite().then_some(backlash)
        });
        (Some(shift.value), backlash)
    }
}

/// The largest deviation without its sign.
fn largest(deviations: &[f64]) -> f64 {
    let larger = |most: f64, deviation: &f64| most.max(deviation.abs());
    deviations.iter().fold(0.0, larger)
}

/// x_E of a gear of known size from spans by least squares, and their deviations in standard uncertainties.
fn fit_shift(gear: &InvoluteGear, spans: &[SpanReading]) -> (Reading, Vec<f64>) {
    // W = π m (k − 1) cos α + (z inv α_t m + s) cos α: of internal gears the space in place of the tooth.
    let sense = if gear.internal { -1.0 } else { 1.0 };
    let (sine, cosine) = gear.pressure_angle.sin_cos();
    let plain = |k: u32| {
        let involute = f64::from(gear.teeth) * inv(gear.transverse_pressure_angle());
        gear.module * cosine * (PI * (f64::from(k) - 0.5) + involute)
    };
    let slope = 2.0 * sense * gear.module * sine;
    let weight = |span: &SpanReading| span.size.std.powi(-2);
    let weights: f64 = spans.iter().map(weight).sum();
    let level: f64 = spans
        .iter()
        .map(|span| weight(span) * (span.size.value - plain(span.k)))
        .sum();
    let level = level / weights;
    let deviation = |span: &SpanReading| (span.size.value - plain(span.k) - level) / span.size.std;
    let shift = Reading {
        value: level / slope,
        std: 1.0 / (weights.sqrt() * slope.abs()),
    };
    (shift, spans.iter().map(deviation).collect())
}
