//! Conversion of a search result to SI units: poles, residues, residual terms, misfit and accepted modes.

use std::f64::consts::TAU;

use crate::base::error::Diagnostic;
use crate::base::quantity::format_number;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::Complex;

use super::basis::{ScaledPole, residue};
use super::groups::{GroupMean, MIN_HITS};
use super::mode_acceptance::{
    BAND_LIMIT, ModeCandidate, NOT_REPEATABLE, POLE_CANCELLATION, may_explain_peak,
    rejection_reason,
};
use super::random_effects::{PooledMean, student_factor};
use super::scaled_responses::ScaledResponses;
use super::search::SearchResult;
use super::widening::{Smearing, estimated_weights_factor, leakage_shifts};
use super::{FrfData, ModelErrorShare, RationalFit, RejectedPole};
use crate::numeric::sorting::sort_ascending;

/// Number of standard deviations above the misfit of noise that indicates a model error.
const MODEL_ERROR_SIGMA: f64 = 4.0;

/// Misfit per degree of freedom above which a model error makes weak modes unreliable.
const MODEL_ERROR_RATIO: f64 = 1.5;

/// Misfit per degree of freedom above which no pole of the fit is reliable.
const MAX_MISFIT_RATIO: f64 = 100.0;

/// Converts a search result into the reported fit and indices of redundant poles. A redundant pole is no mode and lies in the half-power
/// band of another pole; responses that deviate from the model are fitted better without it.
pub(super) fn assemble_fit(
    frf: &FrfData,
    lines: &ScaledResponses,
    result: SearchResult,
) -> (RationalFit, Vec<usize>) {
    let per_dof = result.chi2 / result.dof;
    let departs = result.departures.is_some();
    // A variance with model errors counts the lines across a resonance as one observation, so that the misfit is below 1. A larger misfit
    // comes from lines whose variance is too small.
    let is_misfit = match departs {
        true => per_dof > MODEL_ERROR_RATIO,
        false => per_dof > 1.0 + MODEL_ERROR_SIGMA * (2.0 / result.dof).sqrt(),
    };
    let scale = match is_misfit || (!departs && result.estimated) {
        true => per_dof,
        false => 1.0,
    };
    let numerators = result.structure.numerators();
    let covariance = &result.covariance;
    let poles = &result.fit.model.poles;
    let mut order: Vec<usize> = (0..poles.len()).collect();
    order.sort_by(|&a, &b| {
        let size = |r: usize| poles[r].value().norm();
        size(a).total_cmp(&size(b))
    });
    let coefficients = coefficients(&result, lines.h.len());
    let responses = frf.responses.len();
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
        delay_std_s: per_measured_response(&covariance.delays, lines, responses)
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
    // residues of the scaled responses, by response and sorted pole
    let mut scaled = vec![vec![zero; poles.len()]; responses];
    for (column, &i) in lines.response_indices.iter().enumerate() {
        let size = lines.size[column];
        for (index, &r) in order.iter().enumerate() {
            let residue = residue(&coefficients[column], &poles[r], r, numerators);
            scaled[i][index] = residue;
            fit.residues[i][index] = residue * lines.max_omega.powi(1 - q) * size;
        }
        let mut terms = coefficients[column][poles.len() * numerators..].iter();
        if result.structure.lower {
            fit.residual_terms[i][0] =
                terms.next().copied().unwrap_or(0.0) * lines.max_omega.powi(2 - q) * size;
        }
        if result.structure.upper {
            fit.residual_terms[i][1] =
                terms.next().copied().unwrap_or(0.0) * lines.max_omega.powi(-q) * size;
        }
        fit.fit_error[i] = fit_error(&result, lines, column);
    }
    let shifts = match frf.smearing_hz > 0.0 {
        true => {
            let averages = frf.variance_dof.unwrap_or(f64::INFINITY);
            let smearing = Smearing {
                spread: frf.smearing_hz * TAU / lines.max_omega,
                residual: 2.0 * lines.independence * averages,
            };
            leakage_shifts(&result.problems, &result.fit, numerators, smearing)
        }
        false => vec![(0.0, 0.0); poles.len()],
    };
    // Estimated weights and leakage widen only the reported interval; the acceptance of modes does not use them.
    let reported_mode = |mode: ModalParameters, r: usize| {
        let across = lines.independence * 2.0 * poles[r].sigma / lines.step;
        let factor = match frf.variance_dof {
            Some(dof) => estimated_weights_factor(dof, across),
            None => Some(1.0),
        };
        // The leakage shift has the same sign in every record, so that it adds to the standard deviation.
        let inflate = |c: [f64; 3], factor: f64| {
            let [re, im, both] = c.map(|v| v * factor * factor);
            let total =
                |v: f64, shift: f64| (v.max(0.0).sqrt() + shift.abs() * lines.max_omega).powi(2);
            [total(re, shifts[r].1), total(im, shifts[r].0), both]
        };
        ModalParameters {
            pole_covariance: (mode.pole_covariance.zip(factor)).map(|(c, f)| inflate(c, f)),
            ..mode
        }
    };
    let model_error = departs || (is_misfit && per_dof > MODEL_ERROR_RATIO);
    let mut accepted: Vec<(ModalParameters, ModelErrorShare)> = Vec::new();
    let mut redundant: Vec<(f64, usize)> = Vec::new();
    let mut cancelling_modes: Vec<(ModalParameters, ModelErrorShare)> = Vec::new();
    let has_departures = departs || result.means.iter().any(Option::is_some);
    for (index, &r) in order.iter().enumerate() {
        let omega_squared = lines.max_omega * lines.max_omega;
        let mut mode = ModalParameters {
            pole: fit.poles[index],
            pole_covariance: covariance.poles[r].map(|c| c.map(|v| scale * v * omega_squared)),
            shape: shape(
                &scaled.iter().map(|row| row[index]).collect::<Vec<_>>(),
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
        if let Some(common_departure) = result.common_departures.get(r) {
            for mode in [&mut common, &mut mode] {
                widen(mode, *common_departure, lines.h.len());
            }
        }
        // The difference of two hits is too uncertain for the acceptance of a mode.
        let criterion_mode = match departure.two_hit_factor > 1.0 {
            true => &common,
            false => &mode,
        };
        let candidate = ModeCandidate {
            mode: criterion_mode,
            band_hz: lines.band_limits_hz(),
            is_peak_at_end: lines.is_peak_at_end(&poles[r]),
            visibility: visibility(lines, &poles[r].value(), &scaled, index),
            model_error,
            has_departures: departs,
            by_hit: result.by_hit,
            is_repeatable: result.repeats.get(r).is_none_or(|repeats| *repeats),
            has_unexplained_misfit: departs && per_dof > MAX_MISFIT_RATIO,
        };
        match rejection_reason(&candidate) {
            None => accepted.push((reported_mode(mode, r), departure)),
            Some(POLE_CANCELLATION) if may_explain_peak(&candidate) => {
                cancelling_modes.push((reported_mode(mode, r), departure));
            }
            Some(reason) => {
                let others =
                    (poles.iter().enumerate()).filter(|(o, p)| *o != r && lines.may_be_mode(p));
                let is_adjacent = others.map(|o| o.1).any(|p| overlap(p, &poles[r]));
                if departs
                    && ![POLE_CANCELLATION, NOT_REPEATABLE, BAND_LIMIT].contains(&reason)
                    && lines.may_be_mode(&poles[r])
                    && is_adjacent
                {
                    redundant.push((candidate.visibility, index));
                }
                fit.omitted.push(RejectedPole {
                    pole: mode.pole,
                    reason,
                });
            }
        }
    }
    // Cancelling poles next to a mode are rejected; without a mode there they explain the peak and are accepted.
    let modes: Vec<ModalParameters> = accepted.iter().map(|a| a.0.clone()).collect();
    for (mode, departure) in cancelling_modes {
        let reach = |a: &ModalParameters| a.pole.re.abs() + mode.pole.re.abs();
        let is_adjacent = |a: &ModalParameters| (a.pole.im - mode.pole.im).abs() <= reach(a);
        match modes.iter().any(is_adjacent) {
            true => fit.omitted.push(RejectedPole {
                pole: mode.pole,
                reason: POLE_CANCELLATION,
            }),
            false => accepted.push((mode, departure)),
        }
    }
    sort_ascending(&mut fit.omitted, |a| a.pole.norm());
    sort_ascending(&mut accepted, |a| a.0.frequency_hz());
    (fit.modes, fit.departures) = accepted.into_iter().unzip();
    if !has_departures {
        fit.departures.clear();
    }
    add_warnings(&mut fit, lines, &result, is_misfit, per_dof);
    // Sorted by visibility: without the least visible pole, a pole that it overlaps may be a mode.
    sort_ascending(&mut redundant, |a| a.0);
    let mut indices: Vec<usize> = Vec::new();
    for (_, index) in redundant {
        let pole = &poles[order[index]];
        if !indices.iter().any(|&o| overlap(pole, &poles[order[o]])) {
            indices.push(index);
        }
    }
    (fit, indices)
}

/// True if the half-power bands of two poles overlap.
fn overlap(a: &ScaledPole, b: &ScaledPole) -> bool {
    (a.w - b.w).abs() <= a.sigma + b.sigma
}

/// Pole shift relative to the model error, which has about four smooth terms of equal size; the fit absorbs one of them as a pole shift.
const SHIFT_SHARE: f64 = 0.5;

/// Adds to the pole covariance the shift due to a model error that is common to all hits and independent between the `outputs`.
fn widen(mode: &mut ModalParameters, departure: f64, outputs: usize) {
    let shift = SHIFT_SHARE * departure * mode.pole.re;
    if let Some([re, im, _]) = &mut mode.pole_covariance {
        *re += shift * shift / outputs as f64;
        *im += shift * shift / outputs as f64;
    }
}

/// Model error of a mode; if the hits or responses differ, the mode is replaced by their mean.
fn departure(
    mode: &mut ModalParameters,
    share: f64,
    mean: Option<&GroupMean>,
    max_omega: f64,
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
    let square = max_omega * max_omega;
    mode.pole = Complex::new(-sigma.mean, w.mean) * max_omega;
    mode.pole_covariance = Some([sigma.variance * square, w.variance * square, 0.0]);
    // The scatter is reported if it exceeds the uncertainty of one estimate; the variance of the mean contains both.
    let dof = departure.groups as f64 - 1.0;
    let scatter = |mean: &PooledMean| {
        let between = mean.between_std.powi(2);
        let total = mean.variance * (dof + 1.0) / student_factor(dof).powi(2);
        if between > 0.5 * total { between } else { 0.0 }
    };
    let between = ModalParameters {
        pole_covariance: Some([scatter(&sigma) * square, scatter(&w) * square, 0.0]),
        ..mode.clone()
    };
    departure.frequency_spread_hz = between.frequency_std_hz().unwrap_or(0.0);
    departure.damping_spread = between.damping_std().unwrap_or(0.0);
    departure
}

/// Values for each delay; with one delay per response, default values for responses without a fit.
fn per_measured_response<T: Copy + Default>(
    values: &[T],
    lines: &ScaledResponses,
    responses: usize,
) -> Vec<T> {
    if values.len() < 2 {
        return values.to_vec();
    }
    let mut expanded = vec![T::default(); responses];
    for (&i, &v) in lines.response_indices.iter().zip(values) {
        expanded[i] = v;
    }
    expanded
}

/// Coefficients of the unscaled basis for each response.
pub(super) fn coefficients(result: &SearchResult, responses: usize) -> Vec<Vec<f64>> {
    let mut coefficients = vec![Vec::new(); responses];
    for (problem, fit) in result.problems.iter().zip(&result.fit.fits) {
        for i in 0..fit.c.ncols() {
            let response = problem.first + i;
            let unit = result.by_response[response].sqrt();
            coefficients[response] = (0..fit.c.nrows())
                .map(|j| fit.c[(j, i)] / fit.column_norms[j] * unit)
                .collect();
        }
    }
    coefficients
}

/// Mode shape from the scaled residues, normalised to a largest component of 1.
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

/// Ratio of the power of a pole pair to the measured power within its half-power band (at least the adjacent lines).
pub(super) fn visibility(
    lines: &ScaledResponses,
    p: &Complex,
    scaled: &[Vec<Complex>],
    index: usize,
) -> f64 {
    let step = lines.step;
    let half = p.re.abs().max(step);
    let (mut modal, mut total) = (0.0, 0.0);
    for k in 0..lines.x.len() {
        if (lines.x[k] - p.im).abs() > half {
            continue;
        }
        let s = Complex::new(0.0, lines.x[k]);
        let power = lines.x[k].powi(i32::from(lines.derivative));
        for (column, &i) in lines.response_indices.iter().enumerate() {
            let r = scaled[i][index];
            let h = (r / (s - p) + r.conj() / (s - p.conj())) * power;
            modal += h.norm_sqr();
            total += lines.h[column][k].norm_sqr();
        }
    }
    if total > 0.0 { modal / total } else { 0.0 }
}

/// Unweighted rms residual relative to the rms of the response.
fn fit_error(result: &SearchResult, lines: &ScaledResponses, response: usize) -> f64 {
    let n = lines.x.len();
    let Some((problem, residual)) = result
        .problems
        .iter()
        .zip(&result.residuals)
        .find(|(p, e)| (p.first..p.first + e.ncols()).contains(&response))
    else {
        return 0.0;
    };
    let e = residual.col_as_slice(response - problem.first);
    let (mut residual_power, mut response_power) = (0.0, 0.0);
    for k in 0..n {
        let weight = problem.factor[k].norm() / lines.x[k].powi(i32::from(lines.derivative));
        residual_power += (e[k] * e[k] + e[n + k] * e[n + k]) / (weight * weight);
        response_power += lines.h[response][k].norm_sqr();
    }
    (residual_power * result.by_response[response] / response_power).sqrt()
}

/// Formats a number with three significant digits and without an exponent.
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
    is_misfit: bool,
    per_dof: f64,
) {
    let departs = result.departures.is_some();
    let mut warn = |code: &'static str, message: String, hint: &str| {
        fit.diagnostics.push(Diagnostic {
            code,
            message,
            hint: (!hint.is_empty()).then(|| hint.to_string()),
        });
    };
    if lines.response_indices.len() < fit.residues.len() {
        warn(
            "zero-response",
            format!(
                "{} of {} responses are zero throughout and were left out",
                fit.residues.len() - lines.response_indices.len(),
                fit.residues.len()
            ),
            "",
        );
    }
    if is_misfit && (departs || !result.estimated) {
        warn(
            "misfit",
            format!(
                "the misfit is {} times what the variance explains; intervals were widened to it",
                format_number(per_dof)
            ),
            "check for drift between measurements, nonlinearity, leakage, or a variance that is too small",
        );
    }
    if departs {
        let max =
            |pick: fn(&ModelErrorShare) -> f64| fit.departures.iter().map(pick).fold(0.0, f64::max);
        let (share, spread) = (max(|d| d.model_error), max(|d| d.frequency_spread_hz));
        let groups = if result.by_hit { "hits" } else { "responses" };
        let of = match spread > 0.0 {
            false => String::new(),
            true => format!(
                ", and frequencies differ between {groups} by up to {} Hz (standard deviation)",
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
        warn(
            "departs",
            format!(
                "noise alone does not explain the responses: they depart from the linear model{by}{of}"
            ),
            &format!("{hint}; usual causes: mounting, sensor mass, amplitude, temperature"),
        );
    }
    if result.at_limit {
        warn(
            "pole-limit",
            format!(
                "the search ended at {} pole pairs, the most allowed or all that its time is for: modes may be missing",
                fit.poles.len()
            ),
            "narrow the band: --band",
        );
    }
    if fit.modes.is_empty() {
        warn(
            "no-mode",
            "no pole rises above the noise as a mode".to_string(),
            "use more averages, a longer record, or another band",
        );
    }
}
