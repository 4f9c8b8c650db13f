//! A standard gear fitted to readings: x_E from the spans by least squares, tooth heights from the diameters, backlash from the mate.
//!
//! Spans over more teeth grow by base pitches, which do not depend on the helix, so they leave the uncertainty of the helix angle as it is;
//! by z m inv α_t cos α_n it moves the level of all of them, and x_E with it: u²(x_E) = u²(spans) + u²(helix).

use std::f64::consts::PI;

use super::readings::{GearReadings, Reading, SpanReading};
use super::standard_sizes::{ADDENDA, DEDENDA, ToothSize, nearest};
use crate::gear::cylindrical::basic_rack::BasicRack;
use crate::gear::cylindrical::involute::{InvoluteGear, inv};
use crate::gear::cylindrical::member::Member;
use crate::gear::cylindrical::pair::{base_distance, profile_shift_sum};

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
    /// Largest deviation of a reading.
    pub largest_deviation: Deviation,
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
    /// x_E, with the standard uncertainty that the spans leave.
    shift: Reading,
    /// Deviations of the spans.
    deviations: Vec<Deviation>,
    /// Coefficients of the diameters as heights over the profile shifted by x_E: h_aP + x − x_E and h_fP.
    heights: [Option<f64>; 2],
    /// Generating shift of the mate.
    mate_shift: Option<Reading>,
    /// Normal backlash with the mate at the centre distance, m.
    backlash: Option<f64>,
}

/// A flank by the readings, and by the readings with one of those that determine the helix moved by its standard uncertainty.
struct SpreadFit {
    fit: FlankFit,
    moved: Vec<FlankFit>,
}

impl SpreadFit {
    /// Standard uncertainty of a value of the fit by the helix angle and the tip diameter.
    fn spread(&self, value: impl Fn(&FlankFit) -> f64) -> f64 {
        let here = value(&self.fit);
        let squares = self.moved.iter().map(|moved| (value(moved) - here).powi(2));
        squares.sum::<f64>().sqrt()
    }
}

impl GearReadings {
    /// The gear of a standard size fitted to the readings, with the largest deviations: of a span, and of a span or the centre distance.
    pub(super) fn fit(
        &self,
        size: ToothSize,
        pressure_angle: f64,
    ) -> Option<([Deviation; 2], Candidate)> {
        let module = size.module();
        let all = self.spread_fit(module, pressure_angle)?;
        let (fit, mut deviations) = (&all.fit, all.fit.deviations.clone());
        deviations.extend(self.backlash_deviation(&all));
        let is_span = |d: &&Deviation| d.reading != CENTRE_DISTANCE;
        let spans: Vec<Deviation> = deviations.iter().filter(is_span).cloned().collect();
        let widest = [largest(&spans)?, largest(&deviations)?];
        // x_E − x at the limits of the thickness deviation: only the tip is turned with x, the root is cut with x_E.
        let per_shift = 2.0 * module * pressure_angle.tan();
        let allowances = self.thickness_deviations(module).map(|e| e / per_shift);
        let (usual, unknown) = ([ADDENDA, DEDENDA], [allowances, [0.0; 2]]);
        let names = ["the tip diameter", "the root diameter"];
        // The tip diameter is moved with the readings of the helix.
        let own = [None, self.root_diameter];
        let [addendum, dedendum] = [0, 1].map(|i| {
            let height = fit.heights[i]?;
            let [value, nearest] = nearest(usual[i], unknown[i].map(|shift| height + shift));
            let of_reading = own[i].map_or(0.0, |reading| reading.std / (2.0 * module));
            let moved = all.spread(|fit| fit.heights[i].unwrap_or(f64::NAN));
            let std = of_reading.hypot(fit.shift.std).hypot(moved);
            deviations.push(Deviation::of(names[i], (value - nearest) / std));
            Some([value, nearest])
        });
        let of_tip = addendum.zip(fit.heights[0]);
        let of_tip = of_tip.map(|([value, _], height)| per_shift * (value - height));
        let thickness_deviation = self.thickness_deviation.or(of_tip);
        let mut gear = fit.gear;
        gear.profile_shift -= thickness_deviation.unwrap_or(0.0) / per_shift;
        let candidate = Candidate {
            size,
            gear,
            generating_shift: Reading {
                value: fit.shift.value,
                std: fit.shift.std.hypot(all.spread(|fit| fit.shift.value)),
            },
            thickness_deviation,
            addendum,
            dedendum,
            mate_shift: fit.mate_shift.map(|shift| shift.value),
            backlash: fit.backlash,
            misfit: deviations.iter().map(|d| d.value * d.value).sum(),
            largest_deviation: largest(&deviations)?,
        };
        candidate.misfit.is_finite().then_some((widest, candidate))
    }

    /// The flank by the readings as they are and as their uncertainties move it; `None` where it has no helix angle.
    fn spread_fit(&self, module: f64, pressure_angle: f64) -> Option<SpreadFit> {
        let moved = |reading: &Option<Reading>| {
            reading.map(|r| Reading {
                value: r.value + r.std,
                ..r
            })
        };
        let turned = self.tip_helix.map(|_| GearReadings {
            tip_helix: moved(&self.tip_helix),
            ..self.clone()
        });
        let grown = self.tip_diameter.map(|_| GearReadings {
            tip_diameter: moved(&self.tip_diameter),
            ..self.clone()
        });
        let all = [turned, grown].into_iter().flatten();
        Some(SpreadFit {
            fit: self.fit_flank(module, pressure_angle)?,
            moved: all
                .map(|readings| readings.fit_flank(module, pressure_angle))
                .collect::<Option<_>>()?,
        })
    }

    /// A gear fitted to the spans, its heights and its mate; `None` where it has no helix angle.
    fn fit_flank(&self, module: f64, pressure_angle: f64) -> Option<FlankFit> {
        let helix = self.helix(module);
        let plain = InvoluteGear {
            teeth: self.teeth,
            module,
            pressure_angle,
            helix,
            profile_shift: 0.0,
            internal: self.internal,
        };
        let (shift, mut deviations) = fit_shift(&plain, &self.spans, "");
        // Heights outward and inward from the reference circle, in modules.
        let outward = if self.internal { -1.0 } else { 1.0 };
        let height = |reading: Reading| {
            outward * 0.5 * (reading.value - plain.reference_diameter()) / module
        };
        let heights = [
            self.tip_diameter.map(|tip| height(tip) - shift.value),
            self.root_diameter.map(|root| shift.value - height(root)),
        ];
        let (mate_shift, backlash) = self.fit_mate(&plain, shift, &mut deviations);
        helix.is_finite().then_some(FlankFit {
            gear: InvoluteGear {
                profile_shift: shift.value,
                ..plain
            },
            shift,
            deviations,
            heights,
            mate_shift,
            backlash,
        })
    }

    /// Helix angle at the reference cylinder for a module; NaN where the gear would have none.
    fn helix(&self, module: f64) -> f64 {
        let (Some(helix), Some(tip)) = (self.tip_helix, self.tip_diameter) else {
            return 0.0;
        };
        (f64::from(self.teeth) * module * helix.value.tan() / tip.value).asin()
    }

    /// Generating shift of the mate and the normal backlash; adds the deviations of the mate's spans, and of a centre distance below that
    /// at which the base circles touch.
    fn fit_mate(
        &self,
        gear: &InvoluteGear,
        own: Reading,
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
            let below = (base_distance(&members) - centre.value).max(0.0);
            deviations.push(Deviation::of(CENTRE_DISTANCE, below / centre.std));
        }
        let sum = |centre: Reading| Some(profile_shift_sum(&members, centre.value));
        let sum = (mate.centre_distance.and_then(sum)).filter(|sum| sum.is_finite());
        if mate.spans.is_empty() {
            let shift = sum.map(|sum| Reading {
                value: sum - own.value,
                std: own.std,
            });
            return (shift, None);
        }
        let (shift, of_spans) = fit_shift(&other, &mate.spans, " of the mate");
        deviations.extend(of_spans);
        // Shifts below those without backlash thin the teeth: j_bn = 2 m (Σx − x₁ − x₂) sin α_n.
        let per_shift = 2.0 * gear.module * gear.pressure_angle.sin();
        let backlash = sum.map(|sum| per_shift * (sum - own.value - shift.value));
        (Some(shift), backlash)
    }

    /// A backlash below zero as a deviation of the centre distance: teeth cannot overlap; how much backlash was wanted is not known.
    fn backlash_deviation(&self, all: &SpreadFit) -> Option<Deviation> {
        let (fit, backlash) = (&all.fit, all.fit.backlash?);
        let centre = self.mate.as_ref()?.centre_distance?;
        let sine = 2.0 * fit.gear.pressure_angle.sin();
        let of_shifts = sine * fit.gear.module * fit.shift.std.hypot(fit.mate_shift?.std);
        let moved = all.spread(|fit| fit.backlash.unwrap_or(f64::NAN));
        let std = of_shifts.hypot(sine * centre.std).hypot(moved);
        Some(Deviation::of(CENTRE_DISTANCE, backlash.min(0.0) / std))
    }
}

/// Name of the centre distance among the readings.
pub(super) const CENTRE_DISTANCE: &str = "the centre distance";

/// Deviation of a reading from a candidate.
#[derive(Debug, Clone, PartialEq)]
pub struct Deviation {
    /// The reading in words.
    pub reading: String,
    /// Reading less that of the candidate, in its standard uncertainty.
    pub value: f64,
}

impl Deviation {
    fn of(reading: &str, value: f64) -> Deviation {
        Deviation {
            reading: reading.to_string(),
            value,
        }
    }
}

/// The largest deviation; `None` where one is not finite.
fn largest(deviations: &[Deviation]) -> Option<Deviation> {
    let finite = deviations.iter().all(|d| d.value.is_finite());
    let by_size = |a: &&Deviation, b: &&Deviation| a.value.abs().total_cmp(&b.value.abs());
    finite.then(|| deviations.iter().max_by(by_size))?.cloned()
}

/// x_E of a gear of known size from spans by least squares, and their deviations; `owner` is added to their names.
fn fit_shift(gear: &InvoluteGear, spans: &[SpanReading], owner: &str) -> (Reading, Vec<Deviation>) {
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
    let what = if gear.internal { "spaces" } else { "teeth" };
    let deviation = |span: &SpanReading| Deviation {
        reading: format!("the span over {} {what}{owner}", span.k),
        value: (span.size.value - plain(span.k) - level) / span.size.std,
    };
    let shift = Reading {
        value: level / slope,
        std: 1.0 / (weights.sqrt() * slope.abs()),
    };
    (shift, spans.iter().map(deviation).collect())
}
