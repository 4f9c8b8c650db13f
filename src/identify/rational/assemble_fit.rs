//! Conversion of a search result to SI: poles, residues, residual terms, misfit, accepted modes.

use std::f64::consts::TAU;

use crate::base::error::Diagnostic;
use crate::base::quantity::format_number;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::Complex;

use super::basis::{ScaledPole, residue};
use super::groups::{GroupMean, MIN_HITS};
use super::mode_acceptance::{
    AT_END, CANCELLED, ModeCandidate, UNREPEATED, may_explain_peak, rejection_reason,
};
use super::random_effects::{PooledMean, student_factor};
use super::scaled_responses::ScaledResponses;
use super::search::SearchResult;
use super::widening::{Smearing, estimated_weights_factor, leakage_shifts};
use super::{FrfData, ModelErrorShare, RationalFit, RejectedPole};
use crate::numeric::sorting::sort_rising;

/// A misfit this many standard deviations above that of noise is a model error.
const MODEL_ERROR_SIGMA: f64 = 4.0;

/// And this ratio to the noise is one that spoils weak modes.
const MODEL_ERROR_RATIO: f64 = 1.5;

/// From this ratio on nothing that the fit says of a pole holds.
const MAX_MISFIT_RATIO: f64 = 100.0;

/// Converts a search result into the reported fit. The second are places of poles that responses which depart from the model are fitted
/// better without: no modes, in the half-power band of another pole whose place they take.
pub(super) fn assemble_fit(
    measured: &FrfData,
    lines: &ScaledResponses,
    result: SearchResult,
) -> (RationalFit, Vec<usize>) {
    let per_dof = result.chi2 / result.dof;
    let departs = result.departures.is_some();
    // A variance with departures counts the lines of a resonance as one, so that its misfit is below 1: a large one is of lines that it
    // takes for exact.
    let beyond = match departs {
        true => per_dof > MODEL_ERROR_RATIO,
        false => per_dof > 1.0 + MODEL_ERROR_SIGMA * (2.0 / result.dof).sqrt(),
    };
    let scale = match beyond || (!departs && result.estimated) {
        true => per_dof,
        false => 1.0,
    };
    let numerators = result.structure.numerators();
    let certain = &result.covariance;
    let poles = &result.fit.model.poles;
    let mut order: Vec<usize> = (0..poles.len()).collect();
    order.sort_by(|&a, &b| {
        let size = |r: usize| poles[r].value().norm();
        size(a).total_cmp(&size(b))
    });
    let coefficients = coefficients(&result, lines.h.len());
    let responses = measured.responses.len();
    let zero = Complex::new(0.0, 0.0);
    let mut fit = RationalFit {
        modes: Vec::new(),
        poles: order
            .iter()
            .map(|&r| poles[r].value() * lines.max_omega)
            .collect(),
        residues: vec![vec![zero; poles.len()]; responses],
        residual_terms: vec![[0.0; 2]; responses],
        delay_s: per_measured_response(&result.fit.model.delays, lines, responses)
            .iter()
            .map(|d| d / lines.max_omega)
            .collect(),
        delay_std_s: per_measured_response(&certain.delays, lines, responses)
            .iter()
            .map(|v| v.map(|v| (scale * v.max(0.0)).sqrt() / lines.max_omega))
            .collect(),
        derivative: lines.derivative,
        fit_error: vec![0.0; responses],
        departures: Vec::new(),
        chi2: result.chi2,
        dof: result.dof,
        negative_log_likelihood: result.negative_log_likelihood,
        structure: result.structure,
        omitted: Vec::new(),
        departs,
        diagnostics: Vec::new(),
        evidence: result.evidence.clone(),
        effort: result.effort,
    };
    let q = i32::from(lines.derivative);
    // residues of the scaled responses over their size, by pole in order
    let mut scaled = vec![vec![zero; poles.len()]; responses];
    for (at, &i) in lines.response_indices.iter().enumerate() {
        let size = lines.size[at];
        for (place, &r) in order.iter().enumerate() {
            let residue = residue(&coefficients[at], &poles[r], r, numerators);
            scaled[i][place] = residue;
            fit.residues[i][place] = residue * lines.max_omega.powi(1 - q) * size;
        }
        let mut rest = coefficients[at][poles.len() * numerators..].iter();
        if result.structure.lower {
            fit.residual_terms[i][0] =
                rest.next().copied().unwrap_or(0.0) * lines.max_omega.powi(2 - q) * size;
        }
        if result.structure.upper {
            fit.residual_terms[i][1] =
                rest.next().copied().unwrap_or(0.0) * lines.max_omega.powi(-q) * size;
        }
        fit.fit_error[i] = fit_error(&result, lines, at);
    }
    let shifts = match measured.smearing_hz > 0.0 {
        true => {
            let averages = measured.variance_dof.unwrap_or(f64::INFINITY);
            let smearing = Smearing {
                spread: measured.smearing_hz * TAU / lines.max_omega,
                residual: 2.0 * lines.independence * averages,
            };
            leakage_shifts(&result.problems, &result.fit, numerators, smearing)
        }
        false => vec![(0.0, 0.0); poles.len()],
    };
    // What the estimation adds to the interval says nothing of whether a pole is a mode.
    let stated = |mode: ModalParameters, r: usize| {
        let across = lines.independence * 2.0 * poles[r].sigma / lines.step;
        let factor = match measured.variance_dof {
            Some(dof) => estimated_weights_factor(dof, across),
            None => Some(1.0),
        };
        // The shift by leakage has the same sign in every record, so that standard deviations add.
        let widened = |c: [f64; 3], factor: f64| {
            let [re, im, both] = c.map(|v| v * factor * factor);
            let wider =
                |v: f64, shift: f64| (v.max(0.0).sqrt() + shift.abs() * lines.max_omega).powi(2);
            [wider(re, shifts[r].1), wider(im, shifts[r].0), both]
        };
        ModalParameters {
            pole_covariance: (mode.pole_covariance.zip(factor)).map(|(c, f)| widened(c, f)),
            ..mode
        }
    };
    let model_error = departs || (beyond && per_dof > MODEL_ERROR_RATIO);
    let mut accepted: Vec<(ModalParameters, ModelErrorShare)> = Vec::new();
    let mut needless: Vec<(f64, usize)> = Vec::new();
    let mut cancelling: Vec<(ModalParameters, ModelErrorShare)> = Vec::new();
    let has_departures = departs || result.means.iter().any(Option::is_some);
    for (place, &r) in order.iter().enumerate() {
        let square = lines.max_omega * lines.max_omega;
        let mut mode = ModalParameters {
            pole: fit.poles[place],
            pole_covariance: certain.poles[r].map(|c| c.map(|v| scale * v * square)),
            shape: shape(
                &scaled.iter().map(|row| row[place]).collect::<Vec<_>>(),
                lines,
            ),
        };
        let mean = result.means.get(r).copied().flatten();
        let share = result.departures.as_ref().map_or(0.0, |d| d[r].share);
        let mut common = mode.clone();
        let departure = departure(
            &mut mode,
            share,
            mean.as_ref(),
            lines.max_omega,
            result.by_hit,
        );
        if let Some(own) = result.common_departures.get(r) {
            for mode in [&mut common, &mut mode] {
                widen(mode, *own, lines.h.len());
            }
        }
        // The difference of two hits says little of whether a pole is a mode.
        let judged = match departure.two_hit_factor > 1.0 {
            true => &common,
            false => &mode,
        };
        let candidate = ModeCandidate {
            mode: judged,
            band_hz: lines.band_limits_hz(),
            is_peak_at_end: lines.is_peak_at_end(&poles[r]),
            visibility: visibility(lines, &poles[r].value(), &scaled, place),
            model_error,
            departs,
            by_hit: result.by_hit,
            repeats: result.repeats.get(r).is_none_or(|repeats| *repeats),
            unexplained: departs && per_dof > MAX_MISFIT_RATIO,
        };
        match rejection_reason(&candidate) {
            None => accepted.push((stated(mode, r), departure)),
            Some(CANCELLED) if may_explain_peak(&candidate) => {
                cancelling.push((stated(mode, r), departure));
            }
            Some(reason) => {
                let others =
                    (poles.iter().enumerate()).filter(|(o, p)| *o != r && lines.may_be_mode(p));
                let is_adjacent = others.map(|o| o.1).any(|p| overlap(p, &poles[r]));
                if departs
                    && ![CANCELLED, UNREPEATED, AT_END].contains(&reason)
                    && lines.may_be_mode(&poles[r])
                    && is_adjacent
                {
                    needless.push((candidate.visibility, place));
                }
                fit.omitted.push(RejectedPole {
                    pole: mode.pole,
                    reason,
                });
            }
        }
    }
    // Of poles that cancel, those next to a mode are not one; without a mode there they are what the peak consists of.
    let modes: Vec<ModalParameters> = accepted.iter().map(|a| a.0.clone()).collect();
    for (mode, departure) in cancelling {
        let reach = |a: &ModalParameters| a.pole.re.abs() + mode.pole.re.abs();
        let is_adjacent = |a: &ModalParameters| (a.pole.im - mode.pole.im).abs() <= reach(a);
        match modes.iter().any(is_adjacent) {
            true => fit.omitted.push(RejectedPole {
                pole: mode.pole,
                reason: CANCELLED,
            }),
            false => accepted.push((mode, departure)),
        }
    }
    sort_rising(&mut fit.omitted, |a| a.pole.norm());
    sort_rising(&mut accepted, |a| a.0.frequency_hz());
    (fit.modes, fit.departures) = accepted.into_iter().unzip();
    if !has_departures {
        fit.departures.clear();
    }
    add_warnings(&mut fit, lines, &result, beyond, per_dof);
    // The least visible first: another that it overlaps may be a mode without it.
    sort_rising(&mut needless, |a| a.0);
    let mut places: Vec<usize> = Vec::new();
    for (_, place) in needless {
        let own = &poles[order[place]];
        if !places.iter().any(|&o| overlap(own, &poles[order[o]])) {
            places.push(place);
        }
    }
    (fit, places)
}

/// Whether the half-power bands of two poles overlap.
fn overlap(a: &ScaledPole, b: &ScaledPole) -> bool {
    (a.w - b.w).abs() <= a.sigma + b.sigma
}

/// A resonance is off its model by some four smooth terms; a shift of the pole, which the fit takes up, is as large as one of them.
const SHIFT_SHARE: f64 = 0.5;

/// Adds to the covariance of a pole the shift that a departure common to all hits hides, in each of the `outputs` anew.
fn widen(mode: &mut ModalParameters, departure: f64, outputs: usize) {
    let shift = SHIFT_SHARE * departure * mode.pole.re;
    if let Some([re, im, _]) = &mut mode.pole_covariance {
        *re += shift * shift / outputs as f64;
        *im += shift * shift / outputs as f64;
    }
}

/// Model error of a mode; where hits or responses differ about it, the mode becomes their mean.
fn departure(
    mode: &mut ModalParameters,
    share: f64,
    mean: Option<&GroupMean>,
    top: f64,
    by_hit: bool,
) -> ModelErrorShare {
    let mut departure = ModelErrorShare {
        model_error: share,
        groups: mean.map_or(0, |m| m.count),
        frequency_spread_hz: 0.0,
        damping_spread: 0.0,
        two_hit_factor: 1.0,
        by_hit,
    };
    let Some((w, sigma)) = mean.and_then(|m| m.mean) else {
        return departure;
    };
    if departure.groups == MIN_HITS {
        departure.two_hit_factor = student_factor(1.0);
    }
    let square = top * top;
    mode.pole = Complex::new(-sigma.mean, w.mean) * top;
    mode.pole_covariance = Some([sigma.variance * square, w.variance * square, 0.0]);
    // What estimates differ by is stated where it is more than the uncertainty of one: their mean has the variance of both.
    let free = departure.groups as f64 - 1.0;
    let stated = |mean: &PooledMean| {
        let between = mean.between_std.powi(2);
        let both = mean.variance * (free + 1.0) / student_factor(free).powi(2);
        if between > 0.5 * both { between } else { 0.0 }
    };
    let between = ModalParameters {
        pole_covariance: Some([stated(&sigma) * square, stated(&w) * square, 0.0]),
        ..mode.clone()
    };
    departure.frequency_spread_hz = between.frequency_std_hz().unwrap_or(0.0);
    departure.damping_spread = between.damping_std().unwrap_or(0.0);
    departure
}

/// A value per delay; where each response has its own, zero or nothing for those that were left out.
fn per_measured_response<T: Copy + Default>(
    values: &[T],
    lines: &ScaledResponses,
    responses: usize,
) -> Vec<T> {
    if values.len() < 2 {
        return values.to_vec();
    }
    let mut all = vec![T::default(); responses];
    for (&i, &v) in lines.response_indices.iter().zip(values) {
        all[i] = v;
    }
    all
}

/// Coefficients of the unscaled basis, by response.
pub(super) fn coefficients(result: &SearchResult, responses: usize) -> Vec<Vec<f64>> {
    let mut all = vec![Vec::new(); responses];
    for (problem, fit) in result.problems.iter().zip(&result.fit.fits) {
        for i in 0..fit.c.ncols() {
            let at = problem.first + i;
            let unit = result.by_response[at].sqrt();
            all[at] = (0..fit.c.nrows())
                .map(|j| fit.c[(j, i)] / fit.column_norms[j] * unit)
                .collect();
        }
    }
    all
}

/// The largest component is 1.
pub(super) fn shape(residues: &[Complex], lines: &ScaledResponses) -> Vec<Complex> {
    let largest_size = lines.size.iter().copied().fold(0.0, f64::max);
    let mut shape = residues.to_vec();
    for (at, &i) in lines.response_indices.iter().enumerate() {
        shape[i] *= lines.size[at] / largest_size;
    }
    let largest = shape
        .iter()
        .copied()
        .max_by(|a, b| a.norm().total_cmp(&b.norm()))
        .unwrap_or_default();
    if largest.norm() > 0.0 {
        shape.iter_mut().for_each(|z| *z /= largest);
    }
    shape
}

/// Power of a pole pair over that measured, within its half-power band (at least the nearest lines).
pub(super) fn visibility(
    lines: &ScaledResponses,
    p: &Complex,
    scaled: &[Vec<Complex>],
    place: usize,
) -> f64 {
    let step = lines.step;
    let half = p.re.abs().max(step);
    let (mut own, mut all) = (0.0, 0.0);
    for k in 0..lines.x.len() {
        if (lines.x[k] - p.im).abs() > half {
            continue;
        }
        let s = Complex::new(0.0, lines.x[k]);
        let power = lines.x[k].powi(i32::from(lines.derivative));
        for (at, &i) in lines.response_indices.iter().enumerate() {
            let r = scaled[i][place];
            let h = (r / (s - p) + r.conj() / (s - p.conj())) * power;
            own += h.norm_sqr();
            all += lines.h[at][k].norm_sqr();
        }
    }
    if all > 0.0 { own / all } else { 0.0 }
}

/// Root mean square misfit over that of the response, unweighted.
fn fit_error(result: &SearchResult, lines: &ScaledResponses, response: usize) -> f64 {
    let n = lines.x.len();
    let Some((problem, left)) = result
        .problems
        .iter()
        .zip(&result.residuals)
        .find(|(p, left)| (p.first..p.first + left.ncols()).contains(&response))
    else {
        return 0.0;
    };
    let e = left.col_as_slice(response - problem.first);
    let (mut left, mut all) = (0.0, 0.0);
    for k in 0..n {
        let weight = problem.factor[k].norm() / lines.x[k].powi(i32::from(lines.derivative));
        left += (e[k] * e[k] + e[n + k] * e[n + k]) / (weight * weight);
        all += lines.h[response][k].norm_sqr();
    }
    (left * result.by_response[response] / all).sqrt()
}

/// A number in decimals to three significant digits.
fn three_digits(value: f64) -> String {
    let places = match value > 0.0 {
        true => (2.0 - value.log10().floor()).clamp(0.0, 12.0) as usize,
        false => 0,
    };
    format!("{value:.places$}")
}

fn add_warnings(
    fit: &mut RationalFit,
    lines: &ScaledResponses,
    result: &SearchResult,
    beyond: bool,
    per_dof: f64,
) {
    let departs = result.departures.is_some();
    let mut say = |code: &'static str, message: String, hint: &str| {
        fit.diagnostics.push(Diagnostic {
            code,
            message,
            hint: (!hint.is_empty()).then(|| hint.to_string()),
        });
    };
    if lines.response_indices.len() < fit.residues.len() {
        say(
            "zero-response",
            format!(
                "{} of {} responses are zero throughout and were left out",
                fit.residues.len() - lines.response_indices.len(),
                fit.residues.len()
            ),
            "",
        );
    }
    if beyond && (departs || !result.estimated) {
        say(
            "misfit",
            format!(
                "the misfit is {} times what the variance explains; intervals were widened to it",
                format_number(per_dof)
            ),
            "look for drift between measurements, nonlinearity, leakage, or a variance that is too small",
        );
    }
    if departs {
        let most =
            |pick: fn(&ModelErrorShare) -> f64| fit.departures.iter().map(pick).fold(0.0, f64::max);
        let (share, spread) = (most(|d| d.model_error), most(|d| d.frequency_spread_hz));
        let groups = if result.by_hit { "hits" } else { "responses" };
        let of = match spread > 0.0 {
            false => String::new(),
            true => format!(
                ", and {groups} differ about a frequency by up to {} Hz (standard deviation)",
                three_digits(spread)
            ),
        };
        let by = match share > 0.0 {
            true => format!(" by up to {} % of a mode", three_digits(100.0 * share)),
            false => String::new(),
        };
        let hint = match spread > 0.0 {
            true => format!("intervals include the misfit and what {groups} differ by"),
            false => "intervals include the misfit".to_string(),
        };
        say(
            "departs",
            format!(
                "noise alone does not explain the responses: they depart from the linear model{by}{of}"
            ),
            &format!(
                "{hint}; mounting, mass of sensors, amplitude and temperature are usual causes"
            ),
        );
    }
    if result.at_limit {
        say(
            "pole-limit",
            format!(
                "the search ended at {} pole pairs, the most allowed or all that its time is for: modes may be missing",
                fit.poles.len()
            ),
            "narrow the band: --band",
        );
    }
    if fit.modes.is_empty() {
        say(
            "no-mode",
            "no pole rises above the noise as a mode".to_string(),
            "more averages, a longer record, or another band",
        );
    }
}
