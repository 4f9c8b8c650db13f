//! Reversal: from spans, diameters and the helix angle of an unknown gear to module or diametral pitch, pressure angle and profile shift.
//!
//! `W_{k+1} − W_k = p_bn = π m_n cos α_n`, `sin β = z m_n tan β_a/d_a`; the level of the spans gives x_E, tip and root diameter the
//! coefficients `h_aP = ±(d_a − d)/(2 m_n) − x` and `h_fP = x_E ± (d − d_f)/(2 m_n)`.
//!
//! Gears of one base pitch, tooth number and span have the same flanks whatever module and pressure angle name them: such candidates
//! differ only in the coefficients their tip and root diameters stand for.

use std::f64::consts::PI;

use super::basic_rack::BasicRack;
use super::involute::{InvoluteGear, inv};
use super::member::Member;
use super::pair::profile_shift_sum;
use crate::base::code::Code;
use crate::base::error::Error;

/// A reading and its standard uncertainty.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Value, m or rad.
    pub value: f64,
    /// Standard uncertainty, of the same unit.
    pub std: f64,
}

/// Span over `k` teeth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpanReading {
    /// Teeth, of an internal gear spaces, spanned.
    pub k: u32,
    /// Size, m.
    pub size: Reading,
}

/// Readings of an unknown gear.
#[derive(Debug, Clone, PartialEq)]
pub struct GearReadings {
    /// Number of teeth.
    pub teeth: u32,
    /// Teeth point inward.
    pub internal: bool,
    /// Spans over at least two numbers of teeth.
    pub spans: Vec<SpanReading>,
    /// Tip diameter, m.
    pub tip_diameter: Option<Reading>,
    /// Root diameter, m.
    pub root_diameter: Option<Reading>,
    /// Helix angle at the tip cylinder, rad; `None` for a spur gear. It needs the tip diameter.
    pub tip_helix: Option<Reading>,
    /// Assumed deviation E_sn of the normal thickness, m, negative where the tooth was thinned: spans tell x_E, not x.
    pub thickness_deviation: f64,
    /// The mate, as far as it is known.
    pub mate: Option<MateReadings>,
}

/// What is known of the mate of an unknown gear.
#[derive(Debug, Clone, PartialEq)]
pub struct MateReadings {
    /// Number of teeth.
    pub teeth: u32,
    /// Teeth point inward.
    pub internal: bool,
    /// Spans; none where the mate was not measured.
    pub spans: Vec<SpanReading>,
    /// Centre distance, m.
    pub centre_distance: Option<Reading>,
}

/// The series a candidate's tooth size is from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ToothSize {
    /// Normal module, mm (ISO 54:1996 and older metric series).
    Module(f64),
    /// Normal diametral pitch, 1/in.
    DiametralPitch(f64),
}

/// A gear that the readings may come from.
#[derive(Debug, Clone, PartialEq)]
pub struct Candidate {
    /// Standard size.
    pub size: ToothSize,
    /// The gear, with the profile shift x under the assumed thickness deviation.
    pub gear: InvoluteGear,
    /// Generating profile shift coefficient x_E, and its standard uncertainty.
    pub generating_shift: Reading,
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
}

impl Candidate {
    /// Clearance coefficient c* = h_fP − h_aP of the usual coefficients; `None` where a diameter was not read.
    pub fn clearance(&self) -> Option<f64> {
        Some(self.dedendum?[1] - self.addendum?[1])
    }
}

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

/// Candidates, best first, and pairs of them that the readings leave open.
#[derive(Debug, Clone, PartialEq)]
pub struct Reversal {
    /// Candidates by rising misfit.
    pub candidates: Vec<Candidate>,
    /// Pairs of the candidates that the readings do not separate from the best.
    pub confusions: Vec<Confusion>,
}

/// Normal modules, mm: both series of ISO 54:1996, smaller ones, and 3.25, 3.75, 6.5 of older series.
const MODULES: &[f64] = &[
    0.1, 0.12, 0.15, 0.2, 0.25, 0.3, 0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.7, 0.75, 0.8, 0.9, 1.0,
    1.125, 1.25, 1.375, 1.5, 1.75, 2.0, 2.25, 2.5, 2.75, 3.0, 3.25, 3.5, 3.75, 4.0, 4.5, 5.0, 5.5,
    6.0, 6.5, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 14.0, 16.0, 18.0, 20.0, 22.0, 25.0, 28.0, 32.0,
    36.0, 40.0, 45.0, 50.0,
];

/// Usual normal diametral pitches, 1/in.
const DIAMETRAL_PITCHES: &[f64] = &[
    0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.25, 2.5, 2.75, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0,
    10.0, 11.0, 12.0, 14.0, 16.0, 18.0, 20.0, 22.0, 24.0, 26.0, 28.0, 30.0, 32.0, 36.0, 40.0, 48.0,
    64.0, 72.0, 80.0, 96.0, 120.0, 200.0,
];

/// Usual normal pressure angles, deg.
const PRESSURE_ANGLES: &[f64] = &[14.5, 15.0, 16.0, 17.5, 20.0, 22.5, 25.0, 27.0, 28.0, 30.0];

/// Usual addendum coefficients: stub and full teeth.
const ADDENDA: &[f64] = &[0.8, 1.0];

/// Usual dedendum coefficients: stub, 14.5° full depth, full, for shaving or grinding.
const DEDENDA: &[f64] = &[1.0, 1.1, 1.157, 1.167, 1.2, 1.25, 1.3, 1.35, 1.4];

/// Largest deviation of a span in its standard uncertainties at which a candidate is kept. Tip and root diameters only rank: tips are
/// altered, and tools are not always of the usual depth.
const WIDEST: f64 = 5.0;

/// Two misfits nearer than this are not separated: 3 standard uncertainties of one reading.
const SEPARATED: f64 = 9.0;

/// Standard uncertainty of a diameter that was not read, m: a caliper's.
const DIAMETER_STD: f64 = 20e-6;

/// A gear of given size fitted to the spans.
struct FlankFit {
    /// With the shift x under the assumed thickness deviation.
    gear: InvoluteGear,
    /// x_E.
    shift: Reading,
    /// Of the spans, in standard uncertainties.
    deviations: Vec<f64>,
    /// Addendum and dedendum coefficients that the diameters stand for.
    heights: [Option<f64>; 2],
}

impl GearReadings {
    /// The standard gears that agree with the readings, and what the readings leave open.
    ///
    /// # Errors
    /// `OutOfRange`: a reading no gear has. `IllPosed`: spans over one number of teeth only, or a helix angle without the tip diameter.
    /// `NoConvergence`: no standard gear agrees; the nearest is named.
    pub fn reverse(&self) -> Result<Reversal, Error> {
        self.check()?;
        let modules = MODULES.iter().map(|m| (ToothSize::Module(*m), 1e-3 * m));
        let pitches = DIAMETRAL_PITCHES
            .iter()
            .map(|p| (ToothSize::DiametralPitch(*p), 0.0254 / p));
        let mut nearest: Option<(f64, Candidate)> = None;
        let mut candidates = Vec::new();
        for (size, module) in modules.chain(pitches) {
            for angle in PRESSURE_ANGLES {
                let Some((widest, candidate)) = self.fit(size, module, angle.to_radians()) else {
                    continue;
                };
                if nearest.as_ref().is_none_or(|(least, _)| widest < *least) {
                    nearest = Some((widest, candidate.clone()));
                }
                if widest <= WIDEST {
                    candidates.push(candidate);
                }
            }
        }
        if candidates.is_empty() {
            return Err(self.no_candidate(nearest));
        }
        candidates.sort_by(|a, b| a.misfit.total_cmp(&b.misfit));
        let confusions = self.confusions(&candidates);
        Ok(Reversal {
            candidates,
            confusions,
        })
    }

    fn no_candidate(&self, nearest: Option<(f64, Candidate)>) -> Error {
        let Some((widest, candidate)) = nearest else {
            let message = "no standard gear has these readings";
            return Error::new(Code::NoConvergence, message)
                .with_hint("check the helix angle and the tip diameter");
        };
        let size = match candidate.size {
            ToothSize::Module(m) => format!("m {m} mm"),
            ToothSize::DiametralPitch(p) => format!("P {p} 1/in"),
        };
        let message = format!(
            "no standard gear agrees with the readings; the nearest, {size} / {:.1} deg, misses one by {widest:.1} standard uncertainties",
            candidate.gear.pressure_angle.to_degrees()
        );
        Error::new(Code::NoConvergence, message).with_hint(
            "check the teeth spanned and the uncertainties, or measure spans farther apart",
        )
    }

    fn check(&self) -> Result<(), Error> {
        let mate_spans = self.mate.iter().flat_map(|mate| &mate.spans);
        let sizes = self.spans.iter().chain(mate_spans).map(|span| span.size);
        let diameters = [self.tip_diameter, self.root_diameter]
            .into_iter()
            .flatten();
        let distance = self.mate.iter().filter_map(|mate| mate.centre_distance);
        for reading in sizes.chain(diameters).chain(distance).chain(self.tip_helix) {
            let sensible = reading.value > 0.0
                && reading.std > 0.0
                && (reading.value + reading.std).is_finite();
            if !sensible {
                let message = format!(
                    "a reading is {} with a standard uncertainty of {}; both are positive",
                    reading.value, reading.std
                );
                return Err(Error::new(Code::OutOfRange, message));
            }
        }
        if self.teeth < 3 {
            return Err(Error::new(
                Code::OutOfRange,
                format!("{} teeth; give 3 or more", self.teeth),
            ));
        }
        if !self.thickness_deviation.is_finite() {
            return Err(Error::new(
                Code::OutOfRange,
                "the assumed thickness deviation is not finite",
            ));
        }
        let first = self.spans.first().map(|span| span.k);
        if self.spans.iter().all(|span| Some(span.k) == first) {
            let message = "the spans are over one number of teeth, so the base pitch is unknown";
            return Err(Error::new(Code::IllPosed, message)
                .with_hint("measure over k and over k + 1 teeth"));
        }
        if self.tip_helix.is_some() && (self.tip_diameter.is_none() || self.internal) {
            let message = "the helix angle at the tip is of use with the tip diameter of an external gear only";
            return Err(Error::new(Code::IllPosed, message).with_hint("measure the tip diameter"));
        }
        Ok(())
    }

    /// The gear of a standard size fitted to the readings, and the largest deviation of a span, in standard uncertainties.
    fn fit(&self, size: ToothSize, module: f64, pressure_angle: f64) -> Option<(f64, Candidate)> {
        let fit = self.fit_flank(module, pressure_angle, 0.0)?;
        let (gear, mut deviations) = (fit.gear, fit.deviations);
        let (mate_shift, backlash) = self.fit_mate(&gear, fit.shift, &mut deviations);
        let widest = deviations
            .iter()
            .fold(0.0, |most: f64, d| most.max(d.abs()));
        // What the uncertainty of the helix angle makes of the coefficients.
        let turned = match self.tip_helix {
            Some(helix) => self.fit_flank(module, pressure_angle, helix.std)?.heights,
            None => fit.heights,
        };
        let diameters = [self.tip_diameter, self.root_diameter];
        let usual = [ADDENDA, DEDENDA];
        let [addendum, dedendum] = [0, 1].map(|i| {
            let (reading, height) = (diameters[i]?, fit.heights[i]?);
            let nearest = nearest(usual[i], height);
            let of_helix = height - turned[i]?;
            let std = (reading.std / (2.0 * module))
                .hypot(fit.shift.std)
                .hypot(of_helix);
            deviations.push((height - nearest) / std);
            Some([height, nearest])
        });
        let candidate = Candidate {
            size,
            gear,
            generating_shift: fit.shift,
            addendum,
            dedendum,
            mate_shift,
            backlash,
            misfit: deviations.iter().map(|d| d * d).sum(),
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
        let profile_shift =
            shift.value - self.thickness_deviation / (2.0 * module * pressure_angle.tan());
        // Heights outward and inward from the reference circle, in modules.
        let outward = if self.internal { -1.0 } else { 1.0 };
        let height = |reading: Reading| {
            outward * 0.5 * (reading.value - plain.reference_diameter()) / module
        };
        helix.is_finite().then_some(FlankFit {
            gear: InvoluteGear {
                profile_shift,
                ..plain
            },
            shift,
            deviations,
            heights: [
                self.tip_diameter.map(|tip| height(tip) - profile_shift),
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

    /// Pairs of the best candidate with others, and readings that would part them.
    fn confusions(&self, candidates: &[Candidate]) -> Vec<Confusion> {
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

/// The value of a list nearest to `x`.
fn nearest(list: &[f64], x: f64) -> f64 {
    let distance = |a: &f64| (a - x).abs();
    let by_distance = |a: &&f64, b: &&f64| distance(a).total_cmp(&distance(b));
    list.iter().min_by(by_distance).copied().unwrap_or(x)
}
