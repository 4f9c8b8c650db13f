//! The answer in SI: poles, residues, residual terms, what is left, and which poles are modes.

use crate::base::error::Warning;
use crate::identify::mode::IdentifiedMode;
use crate::numeric::Complex;

use super::groups::GroupMean;
use super::lines::Lines;
use super::reported::{Candidate, objection};
use super::search::Found;
use super::{Departure, Measured, Omitted, RationalFit};

/// A misfit this many standard deviations above that of noise is a model error.
const BEYOND_NOISE: f64 = 4.0;

/// And this ratio to the noise is one that spoils weak modes.
const SPOILS: f64 = 1.5;

/// Turns what a search found into the answer.
pub(super) fn answer(measured: &Measured, lines: &Lines, found: Found) -> RationalFit {
    let per_dof = found.chi2 / found.dof;
    let departs = found.departures.is_some();
    let beyond = !departs && per_dof > 1.0 + BEYOND_NOISE * (2.0 / found.dof).sqrt();
    // A variance with departures counts the lines of a resonance as one: it is no measure of its own misfit.
    let scale = match !departs && (found.estimated || beyond) {
        true => per_dof,
        false => 1.0,
    };
    let numerators = found.structure.numerators();
    let certain = &found.covariance;
    let poles = &found.fitted.model.poles;
    let mut order: Vec<usize> = (0..poles.len()).collect();
    order.sort_by(|&a, &b| {
        let size = |r: usize| poles[r].value().norm();
        size(a).total_cmp(&size(b))
    });
    let coefficients = coefficients(&found, lines.h.len());
    let responses = measured.responses.len();
    let zero = Complex::new(0.0, 0.0);
    let mut fit = RationalFit {
        modes: Vec::new(),
        poles: order
            .iter()
            .map(|&r| poles[r].value() * lines.top)
            .collect(),
        residues: vec![vec![zero; poles.len()]; responses],
        residual_terms: vec![[0.0; 2]; responses],
        delay_s: by_measured(&found.fitted.model.delays, lines, responses)
            .iter()
            .map(|d| d / lines.top)
            .collect(),
        delay_std_s: by_measured(&certain.delays, lines, responses)
            .iter()
            .map(|v| v.map(|v| (scale * v.max(0.0)).sqrt() / lines.top))
            .collect(),
        derivative: lines.derivative,
        fit_error: vec![0.0; responses],
        departures: Vec::new(),
        chi2: found.chi2,
        dof: found.dof,
        surprise: found.surprise,
        structure: found.structure,
        omitted: Vec::new(),
        departs,
        warnings: Vec::new(),
        evidence: found.evidence.clone(),
        effort: found.effort,
    };
    let q = i32::from(lines.derivative);
    // residues of the scaled responses over their size, by pole in order
    let mut scaled = vec![vec![zero; poles.len()]; responses];
    for (at, &i) in lines.kept.iter().enumerate() {
        let size = lines.size[at];
        for (place, &r) in order.iter().enumerate() {
            let residue = residue(&coefficients[at], &poles[r], r, numerators);
            scaled[i][place] = residue;
            fit.residues[i][place] = residue * lines.top.powi(1 - q) * size;
        }
        let mut rest = coefficients[at][poles.len() * numerators..].iter();
        if found.structure.lower {
            fit.residual_terms[i][0] =
                rest.next().copied().unwrap_or(0.0) * lines.top.powi(2 - q) * size;
        }
        if found.structure.upper {
            fit.residual_terms[i][1] =
                rest.next().copied().unwrap_or(0.0) * lines.top.powi(-q) * size;
        }
        fit.fit_error[i] = fit_error(&found, lines, at);
    }
    let model_error = departs || (beyond && per_dof > SPOILS);
    for (place, &r) in order.iter().enumerate() {
        let square = lines.top * lines.top;
        let mut mode = IdentifiedMode {
            pole: fit.poles[place],
            pole_covariance: certain.poles[r].map(|c| c.map(|v| scale * v * square)),
            shape: shape(
                &scaled.iter().map(|row| row[place]).collect::<Vec<_>>(),
                lines,
            ),
        };
        let mean = found.means.get(r).copied().flatten();
        let share = found.departures.as_ref().map_or(0.0, |d| d[r].share);
        let departure = departure(&mut mode, share, mean.as_ref(), lines.top);
        let candidate = Candidate {
            mode: &mode,
            band_hz: lines.ends_hz(),
            visibility: visibility(lines, &poles[r].value(), &scaled, place),
            model_error,
            departs,
        };
        match objection(&candidate) {
            None => {
                fit.modes.push(mode);
                if departs || mean.is_some() {
                    fit.departures.push(departure);
                }
            }
            Some(reason) => fit.omitted.push(Omitted {
                pole: mode.pole,
                reason,
            }),
        }
    }
    warn(&mut fit, lines, &found, beyond, per_dof);
    fit
}

/// What a mode departs by; where hits or responses differ about it, it becomes their mean.
fn departure(
    mode: &mut IdentifiedMode,
    share: f64,
    mean: Option<&GroupMean>,
    top: f64,
) -> Departure {
    let mut departure = Departure {
        model_error: share,
        groups: mean.map_or(0, |m| m.count),
        frequency_spread_hz: 0.0,
        damping_spread: 0.0,
    };
    let Some((w, sigma)) = mean.and_then(|m| m.mean) else {
        return departure;
    };
    let square = top * top;
    mode.pole = Complex::new(-sigma.mean, w.mean) * top;
    mode.pole_covariance = Some([sigma.variance * square, w.variance * square, 0.0]);
    let between = IdentifiedMode {
        pole_covariance: Some([
            sigma.between.powi(2) * square,
            w.between.powi(2) * square,
            0.0,
        ]),
        ..mode.clone()
    };
    departure.frequency_spread_hz = between.frequency_std_hz().unwrap_or(0.0);
    departure.damping_spread = between.damping_std().unwrap_or(0.0);
    departure
}

/// A value per delay; where each response has its own, zero or nothing for those that were left out.
fn by_measured<T: Copy + Default>(values: &[T], lines: &Lines, responses: usize) -> Vec<T> {
    if values.len() < 2 {
        return values.to_vec();
    }
    let mut all = vec![T::default(); responses];
    for (&i, &v) in lines.kept.iter().zip(values) {
        all[i] = v;
    }
    all
}

/// Coefficients of the unscaled basis, by response.
fn coefficients(found: &Found, responses: usize) -> Vec<Vec<f64>> {
    let mut all = vec![Vec::new(); responses];
    for (problem, fit) in found.problems.iter().zip(&found.fitted.fits) {
        for i in 0..fit.c.ncols() {
            let at = problem.first + i;
            let unit = found.by_response[at].sqrt();
            all[at] = (0..fit.c.nrows())
                .map(|j| fit.c[(j, i)] / fit.length[j] * unit)
                .collect();
        }
    }
    all
}

/// `(a|p| + b p)/(2j Im p)` in units of the highest line.
pub(super) fn residue(
    c: &[f64],
    pole: &super::basis::Pole,
    r: usize,
    numerators: usize,
) -> Complex {
    let p = pole.value();
    let mut top = Complex::new(c[r * numerators] * p.norm(), 0.0);
    if numerators == 2 {
        top += p * c[r * numerators + 1];
    }
    top / Complex::new(0.0, 2.0 * p.im)
}

/// The largest component is 1.
pub(super) fn shape(residues: &[Complex], lines: &Lines) -> Vec<Complex> {
    let largest_size = lines.size.iter().copied().fold(0.0, f64::max);
    let mut shape = residues.to_vec();
    for (at, &i) in lines.kept.iter().enumerate() {
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
pub(super) fn visibility(lines: &Lines, p: &Complex, scaled: &[Vec<Complex>], place: usize) -> f64 {
    let step = lines.step;
    let half = p.re.abs().max(step);
    let (mut own, mut all) = (0.0, 0.0);
    for k in 0..lines.x.len() {
        if (lines.x[k] - p.im).abs() > half {
            continue;
        }
        let s = Complex::new(0.0, lines.x[k]);
        let power = lines.x[k].powi(i32::from(lines.derivative));
        for (at, &i) in lines.kept.iter().enumerate() {
            let r = scaled[i][place];
            let h = (r / (s - p) + r.conj() / (s - p.conj())) * power;
            own += h.norm_sqr();
            all += lines.h[at][k].norm_sqr();
        }
    }
    if all > 0.0 { own / all } else { 0.0 }
}

/// Root mean square misfit over that of the response, unweighted.
fn fit_error(found: &Found, lines: &Lines, response: usize) -> f64 {
    let n = lines.x.len();
    let Some((problem, left)) = found
        .problems
        .iter()
        .zip(&found.left)
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
    (left * found.by_response[response] / all).sqrt()
}

fn warn(fit: &mut RationalFit, lines: &Lines, found: &Found, beyond: bool, per_dof: f64) {
    let mut say = |code: &'static str, message: String, hint: &str| {
        fit.warnings.push(Warning {
            code,
            message,
            hint: (!hint.is_empty()).then(|| hint.to_string()),
        });
    };
    if lines.kept.len() < fit.residues.len() {
        say(
            "zero-response",
            format!(
                "{} of {} responses are zero throughout and were left out",
                fit.residues.len() - lines.kept.len(),
                fit.residues.len()
            ),
            "",
        );
    }
    if beyond && !found.estimated {
        say(
            "misfit",
            format!(
                "the misfit is {per_dof:.2} times what the variance explains; intervals were widened to it"
            ),
            "look for drift between measurements, nonlinearity, leakage, or a variance that is too small",
        );
    }
    if found.departures.is_some() {
        let most =
            |pick: fn(&Departure) -> f64| fit.departures.iter().map(pick).fold(0.0, f64::max);
        let (share, spread) = (most(|d| d.model_error), most(|d| d.frequency_spread_hz));
        let of = match (spread > 0.0, found.by_hit) {
            (false, _) => String::new(),
            (true, true) => format!(
                ", and hits differ about a frequency by up to {spread:.2e} Hz (standard deviation)"
            ),
            (true, false) => format!(
                ", and responses differ about a frequency by up to {spread:.2e} Hz (standard deviation)"
            ),
        };
        say(
            "departs",
            format!(
                "noise alone does not explain the responses: they depart from the linear model by up to {:.1} % of a mode{of}",
                100.0 * share
            ),
            "intervals hold it; mounting, mass of sensors, amplitude and temperature are usual causes",
        );
    }
    if found.at_limit {
        say(
            "pole-limit",
            format!(
                "the search ended at the most pole pairs allowed, {}",
                fit.poles.len()
            ),
            "narrow the band, or allow more poles",
        );
    }
    if fit.modes.is_empty() {
        say(
            "no-mode",
            "no pole stands out of the noise as a mode".to_string(),
            "more averages, a longer record, or another band",
        );
    }
}
