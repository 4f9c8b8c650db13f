//! Standard gear fitted to readings: x_E from the spans by least squares, tooth heights from the diameters, backlash from the mate.
//!
//! Differences of spans are base pitches and do not depend on the helix angle, so that they do not reduce its uncertainty. The helix angle
//! shifts all spans by z m inv α_t cos α_n, and x_E with them: u²(x_E) = u²(spans) + u²(helix).

use std::f64::consts::PI;

use super::readings::{GearReadings, Reading, SpanReading};
use super::standard_sizes::{ADDENDA, DEDENDA, ToothSize, nearest};
use crate::gear::cylindrical::basic_rack::BasicRack;
use crate::gear::cylindrical::involute::{InvoluteGear, inv};
use crate::gear::cylindrical::member::Member;
use crate::gear::cylindrical::pair::{base_distance, profile_shift_sum};

/// Standard gear compatible with the readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Standard tooth size.
    pub size: ToothSize,
    /// Gear with the profile shift coefficient x if it is known, else with x_E.
    pub gear: InvoluteGear,
    /// Generating profile shift coefficient x_E with its standard uncertainty.
    pub generating_shift: Reading,
    /// Deviation E_sn of the normal thickness, m: as stated, else from the tip diameter with the nearest standard addendum; `None` without
    /// either.
    pub thickness_deviation: Option<f64>,
    /// Addendum coefficient h_aP + k of the tip diameter and the nearest standard coefficient.
    pub addendum: Option<[f64; 2]>,
    /// Dedendum coefficient h_fP of the root diameter and the nearest standard coefficient.
    pub dedendum: Option<[f64; 2]>,
    /// Generating profile shift coefficient of the mate, from its spans, else from the centre distance without backlash.
    pub mate_shift: Option<f64>,
    /// Normal backlash at the centre distance, m; `None` without spans of the mate.
    pub backlash: Option<f64>,
    /// Sum of the squared deviations of all readings, relative to their standard uncertainties.
    pub misfit: f64,
    /// Largest deviation of a reading.
    pub largest_deviation: Deviation,
}

impl Candidate {
    /// Clearance coefficient c* = h_fP − h_aP of the standard coefficients; `None` without both diameters.
    pub fn clearance(&self) -> Option<f64> {
        Some(self.dedendum?[1] - self.addendum?[1])
    }

    /// Profile shift coefficient x; `None` without the thickness deviation.
    pub fn profile_shift(&self) -> Option<f64> {
        self.thickness_deviation.map(|_| self.gear.profile_shift)
    }
}

/// Gear of a given size fitted to the spans.
struct FlankFit {
    /// Gear with the profile shift x_E.
    gear: InvoluteGear,
    /// x_E with its standard uncertainty from the spans.
    shift: Reading,
    /// Deviations of the spans.
    deviations: Vec<Deviation>,
    /// Height coefficients of tip and root diameter over the profile shifted by x_E: h_aP + x − x_E and h_fP.
    heights: [Option<f64>; 2],
    /// Generating shift of the mate.
    mate_shift: Option<Reading>,
    /// Normal backlash with the mate at the centre distance, m.
    backlash: Option<f64>,
}

/// Fit to the readings, with fits in which a reading that determines the helix is increased by its standard uncertainty.
struct PerturbedFit {
    fit: FlankFit,
    perturbed: Vec<FlankFit>,
}

impl PerturbedFit {
    /// Standard uncertainty of a value of the fit from those of the helix angle and the tip diameter.
    fn uncertainty(&self, value: impl Fn(&FlankFit) -> f64) -> f64 {
        let base = value(&self.fit);
        let squares = self.perturbed.iter().map(|f| (value(f) - base).powi(2));
        squares.sum::<f64>().sqrt()
    }
}

impl GearReadings {
    /// Gear of a standard size fitted to the readings, with the largest deviations: of the spans, and of the spans and the centre distance.
    pub(super) fn fit(
        &self,
        size: ToothSize,
        pressure_angle: f64,
    ) -> Option<([Deviation; 2], Candidate)> {
        let module = size.module();
        let fits = self.perturbed_fit(module, pressure_angle)?;
        let (fit, mut deviations) = (&fits.fit, fits.fit.deviations.clone());
        deviations.extend(self.backlash_deviation(&fits));
        let is_span = |d: &&Deviation| d.reading != CENTRE_DISTANCE;
        let spans: Vec<Deviation> = deviations.iter().filter(is_span).cloned().collect();
        let maxima = [largest(&spans)?, largest(&deviations)?];
        // x_E − x at the limits of the thickness deviation: the tip diameter depends on x, the root diameter on x_E.
        let per_shift = 2.0 * module * pressure_angle.tan();
        let allowances = self.thickness_deviations(module).map(|e| e / per_shift);
        let (standard, ranges) = ([ADDENDA, DEDENDA], [allowances, [0.0; 2]]);
        let names = ["the tip diameter", "the root diameter"];
        // The tip diameter is perturbed with the readings of the helix.
        let independent = [None, self.root_diameter];
        let [addendum, dedendum] = [0, 1].map(|i| {
            let height = fit.heights[i]?;
            let [value, nearest] = nearest(standard[i], ranges[i].map(|shift| height + shift));
            let reading_std = independent[i].map_or(0.0, |reading| reading.std / (2.0 * module));
            let helix_std = fits.uncertainty(|fit| fit.heights[i].unwrap_or(f64::NAN));
            let std = reading_std.hypot(fit.shift.std).hypot(helix_std);
            deviations.push(Deviation::new(names[i], (value - nearest) / std));
            Some([value, nearest])
        });
        let tip_deviation = addendum.zip(fit.heights[0]);
        let tip_deviation = tip_deviation.map(|([value, _], height)| per_shift * (value - height));
        let thickness_deviation = self.thickness_deviation.or(tip_deviation);
        let mut gear = fit.gear;
        gear.profile_shift -= thickness_deviation.unwrap_or(0.0) / per_shift;
        let candidate = Candidate {
            size,
            gear,
            generating_shift: Reading {
                value: fit.shift.value,
                std: fit.shift.std.hypot(fits.uncertainty(|f| f.shift.value)),
            },
            thickness_deviation,
            addendum,
            dedendum,
            mate_shift: fit.mate_shift.map(|shift| shift.value),
            backlash: fit.backlash,
            misfit: deviations.iter().map(|d| d.value * d.value).sum(),
            largest_deviation: largest(&deviations)?,
        };
        candidate.misfit.is_finite().then_some((maxima, candidate))
    }

    /// Fits with the nominal and the perturbed readings; `None` without a valid helix angle.
    fn perturbed_fit(&self, module: f64, pressure_angle: f64) -> Option<PerturbedFit> {
        let increased = |reading: &Option<Reading>| {
            reading.map(|r| Reading {
                value: r.value + r.std,
                ..r
            })
        };
        let helix_varied = self.tip_helix.map(|_| GearReadings {
            tip_helix: increased(&self.tip_helix),
            ..self.clone()
        });
        let tip_varied = self.tip_diameter.map(|_| GearReadings {
            tip_diameter: increased(&self.tip_diameter),
            ..self.clone()
        });
        let variants = [helix_varied, tip_varied].into_iter().flatten();
        Some(PerturbedFit {
            fit: self.fit_flank(module, pressure_angle)?,
            perturbed: variants
                .map(|readings| readings.fit_flank(module, pressure_angle))
                .collect::<Option<_>>()?,
        })
    }

    /// Fit to the spans, the diameters and the mate; `None` without a valid helix angle.
    fn fit_flank(&self, module: f64, pressure_angle: f64) -> Option<FlankFit> {
        let helix = self.helix(module);
        let unshifted = InvoluteGear {
            teeth: self.teeth,
            module,
            pressure_angle,
            helix,
            profile_shift: 0.0,
            internal: self.internal,
        };
        let (shift, mut deviations) = fit_shift(&unshifted, &self.spans, "");
        // Height of a diameter over the reference circle towards the tip, modules.
        let outward = if self.internal { -1.0 } else { 1.0 };
        let height = |reading: Reading| {
            outward * 0.5 * (reading.value - unshifted.reference_diameter()) / module
        };
        let heights = [
            self.tip_diameter.map(|tip| height(tip) - shift.value),
            self.root_diameter.map(|root| shift.value - height(root)),
        ];
        let (mate_shift, backlash) = self.fit_mate(&unshifted, shift, &mut deviations);
        helix.is_finite().then_some(FlankFit {
            gear: InvoluteGear {
                profile_shift: shift.value,
                ..unshifted
            },
            shift,
            deviations,
            heights,
            mate_shift,
            backlash,
        })
    }

    /// Helix angle at the reference cylinder for a module, rad; 0 without its readings, NaN if it does not exist.
    fn helix(&self, module: f64) -> f64 {
        let (Some(helix), Some(tip)) = (self.tip_helix, self.tip_diameter) else {
            return 0.0;
        };
        (f64::from(self.teeth) * module * helix.value.tan() / tip.value).asin()
    }

    /// Generating shift of the mate and normal backlash, m. Appends the deviations of the mate's spans and of a centre distance below the
    /// contact of the base circles.
    fn fit_mate(
        &self,
        gear: &InvoluteGear,
        gear_shift: Reading,
        deviations: &mut Vec<Deviation>,
    ) -> (Option<Reading>, Option<f64>) {
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
        if let Some(centre) = mate.centre_distance {
            let shortfall = (base_distance(&members) - centre.value).max(0.0);
            deviations.push(Deviation::new(CENTRE_DISTANCE, shortfall / centre.std));
        }
        let sum = |centre: Reading| Some(profile_shift_sum(&members, centre.value));
        let sum = (mate.centre_distance.and_then(sum)).filter(|sum| sum.is_finite());
        if mate.spans.is_empty() {
            let shift = sum.map(|sum| Reading {
                value: sum - gear_shift.value,
                std: gear_shift.std,
            });
            return (shift, None);
        }
        let (shift, span_deviations) = fit_shift(&other, &mate.spans, " of the mate");
        deviations.extend(span_deviations);
        // Backlash from the profile shifts: j_bn = 2 m (Σx − x₁ − x₂) sin α_n.
        let per_shift = 2.0 * gear.module * gear.pressure_angle.sin();
        let backlash = sum.map(|sum| per_shift * (sum - gear_shift.value - shift.value));
        (Some(shift), backlash)
    }

    /// Negative backlash as a deviation of the centre distance; positive backlash is no deviation, since its design value is unknown.
    fn backlash_deviation(&self, fits: &PerturbedFit) -> Option<Deviation> {
        let (fit, backlash) = (&fits.fit, fits.fit.backlash?);
        let centre = self.mate.as_ref()?.centre_distance?;
        let sine = 2.0 * fit.gear.pressure_angle.sin();
        let shift_std = sine * fit.gear.module * fit.shift.std.hypot(fit.mate_shift?.std);
        let helix_std = fits.uncertainty(|fit| fit.backlash.unwrap_or(f64::NAN));
        let std = shift_std.hypot(sine * centre.std).hypot(helix_std);
        Some(Deviation::new(CENTRE_DISTANCE, backlash.min(0.0) / std))
    }
}

/// Name of the centre distance among the readings.
pub(super) const CENTRE_DISTANCE: &str = "the centre distance";

/// Deviation of a reading from a candidate.
#[derive(Debug, Clone, PartialEq)]
pub struct Deviation {
    /// Name of the reading.
    pub reading: String,
    /// Reading minus the value of the candidate, relative to its standard uncertainty.
    pub value: f64,
}

impl Deviation {
    fn new(reading: &str, value: f64) -> Deviation {
        Deviation {
            reading: reading.to_string(),
            value,
        }
    }
}

/// Largest absolute deviation; `None` if a deviation is not finite.
fn largest(deviations: &[Deviation]) -> Option<Deviation> {
    let is_finite = deviations.iter().all(|d| d.value.is_finite());
    let cmp = |a: &&Deviation, b: &&Deviation| a.value.abs().total_cmp(&b.value.abs());
    is_finite.then(|| deviations.iter().max_by(cmp))?.cloned()
}

/// Fits x_E of a gear of known size to spans by least squares; returns x_E and the deviations, with `owner` appended to their names.
fn fit_shift(gear: &InvoluteGear, spans: &[SpanReading], owner: &str) -> (Reading, Vec<Deviation>) {
    // W = π m (k − 1) cos α + (z inv α_t m + s) cos α; internal gears: space width in place of s.
    let sense = if gear.internal { -1.0 } else { 1.0 };
    let (sine, cosine) = gear.pressure_angle.sin_cos();
    let unshifted = |k: u32| {
        let involute = f64::from(gear.teeth) * inv(gear.transverse_pressure_angle());
        gear.module * cosine * (PI * (f64::from(k) - 0.5) + involute)
    };
    let slope = 2.0 * sense * gear.module * sine;
    let weight = |span: &SpanReading| span.size.std.powi(-2);
    let weights: f64 = spans.iter().map(weight).sum();
    let level: f64 = spans
        .iter()
        .map(|span| weight(span) * (span.size.value - unshifted(span.k)))
        .sum();
    let level = level / weights;
    let unit = if gear.internal { "spaces" } else { "teeth" };
    let deviation = |span: &SpanReading| Deviation {
        reading: format!("the span over {} {unit}{owner}", span.k),
        value: (span.size.value - unshifted(span.k) - level) / span.size.std,
    };
    let shift = Reading {
        value: level / slope,
        std: 1.0 / (weights.sqrt() * slope.abs()),
    };
    (shift, spans.iter().map(deviation).collect())
}
