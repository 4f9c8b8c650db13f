//! Validation and scaling of measured FRFs: frequencies by the highest line, each response by its maximum magnitude.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::{Complex, Matrix};

use super::basis::{ModelTerms, ScaledPole, WhitenedProblem, set_complex};
use super::scan::median_spacing;
use super::{FrfData, RationalOptions};

/// Scaled FRFs on the lines of the band, without responses that are zero on all lines.
#[derive(Debug, Clone)]
pub(super) struct ScaledResponses {
    /// Frequencies relative to the highest line.
    pub x: Vec<f64>,
    /// Median spacing of `x`.
    pub step: f64,
    /// Angular frequency of the highest line, rad/s.
    pub max_omega: f64,
    /// Indices of the measured responses.
    pub response_indices: Vec<usize>,
    /// Maximum magnitude of each response, the scale.
    pub size: Vec<f64>,
    /// Responses divided by their maximum magnitude, by response and line.
    pub h: Vec<Vec<Complex>>,
    /// Variances of the scaled responses by response and line; `None` if unknown.
    pub variance: Option<Vec<Vec<f64>>>,
    /// Power of s that converts a receptance to this response quantity.
    pub derivative: u8,
    /// Number of independent lines per line, above 0 and at most 1.
    pub independence: f64,
    /// Power of the fourth difference of adjacent lines relative to their noise power.
    pub fourth_difference_gain: f64,
    /// Groups of responses with a common deviation, such as those of a hit; empty if all are of the same record.
    pub hits: Vec<Vec<usize>>,
    /// Groups of adjacent responses of one output to different hits, which share their weights; single responses without hits.
    pub channels: Vec<Vec<usize>>,
    /// Average number of hits joined in a group of `hits`.
    pub hits_per_group: f64,
}

/// Minimum number of lines of a fit.
const MIN_LINES: usize = 8;

/// Variance of the fourth difference of unit noise: sum of the squared binomial coefficients 1, 4, 6, 4, 1.
pub(super) const FOURTH_DIFFERENCE_VARIANCE: f64 = 70.0;

/// Rounding errors that limit the variance from below: relative to the peak, to the value, and to the frequency.
const ROUNDING: (f64, f64, f64) = (1e-14, 3e-15, 1e-15);

impl ScaledResponses {
    /// Scales the responses to each hit separately, with unknown variance; `None` with fewer than two hits.
    ///
    /// # Errors
    /// As [`ScaledResponses::new`].
    pub fn split_by_hit(
        frf: &FrfData,
        options: &RationalOptions,
    ) -> Result<Option<ScaledResponses>, Error> {
        let Some(hits) = frf.hits.filter(|h| h.responses.len() > 1) else {
            return Ok(None);
        };
        let count = hits.responses.len();
        // Responses of an output to all hits are adjacent.
        let responses: Vec<Vec<Complex>> = (0..frf.responses.len())
            .flat_map(|output| hits.responses.iter().map(move |hit| hit[output].clone()))
            .collect();
        let hit_frf = FrfData {
            responses: &responses,
            variance: None,
            hits: None,
            ..*frf
        };
        let mut lines = ScaledResponses::new(&hit_frf, options)?;
        (lines.fourth_difference_gain, lines.hits_per_group) =
            (hits.fourth_difference_gain, hits.hits_per_group);
        let group_by = |groups: usize, group: &dyn Fn(usize) -> usize| -> Vec<Vec<usize>> {
            let members = (0..groups).map(|g| {
                let in_group = |at: &usize| group(lines.response_indices[*at]) == g;
                (0..lines.response_indices.len()).filter(in_group).collect()
            });
            members.filter(|m: &Vec<usize>| !m.is_empty()).collect()
        };
        let by_hit = group_by(count, &|i| i % count);
        lines.channels = group_by(frf.responses.len(), &|i| i / count);
        lines.hits = by_hit;
        Ok(Some(lines))
    }

    /// Average of `hits` that are fitted separately, with unknown variance.
    pub fn average_of(&self, hits: &ScaledResponses) -> ScaledResponses {
        ScaledResponses {
            variance: None,
            fourth_difference_gain: hits.fourth_difference_gain,
            ..self.clone()
        }
    }

    /// Validates and scales the FRFs on the lines of the band, without the line at zero frequency.
    pub fn new(frf: &FrfData, options: &RationalOptions) -> Result<ScaledResponses, Error> {
        check(frf, options)?;
        let (from, to) = options.band_hz.unwrap_or((0.0, f64::INFINITY));
        let rows: Vec<usize> = (0..frf.frequency_hz.len())
            .filter(|&k| frf.frequency_hz[k] > 0.0)
            .filter(|&k| (from..=to).contains(&frf.frequency_hz[k]))
            .collect();
        if rows.len() < MIN_LINES {
            return Err(Error::new(
                Code::TooShort,
                format!(
                    "{} lines above 0 Hz in the band are too few to fit a pole (minimum {MIN_LINES})",
                    rows.len()
                ),
            )
            .with_hint("widen the band, or measure with a finer frequency resolution"));
        }
        let highest = frf.frequency_hz[rows[rows.len() - 1]];
        let x: Vec<f64> = rows
            .iter()
            .map(|&k| frf.frequency_hz[k] / highest)
            .collect();
        let mut lines = ScaledResponses {
            step: median_spacing(&x),
            x,
            max_omega: TAU * highest,
            response_indices: Vec::new(),
            size: Vec::new(),
            h: Vec::new(),
            variance: frf.variance.map(|_| Vec::new()),
            derivative: frf.derivative,
            independence: frf.line_independence,
            fourth_difference_gain: FOURTH_DIFFERENCE_VARIANCE,
            hits: Vec::new(),
            channels: Vec::new(),
            hits_per_group: 1.0,
        };
        for (i, response) in frf.responses.iter().enumerate() {
            let size = rows.iter().map(|&k| response[k].norm()).fold(0.0, f64::max);
            if size == 0.0 {
                continue;
            }
            lines.response_indices.push(i);
            lines.size.push(size);
            lines
                .h
                .push(rows.iter().map(|&k| response[k] / size).collect());
            if let (Some(scaled), Some(v)) = (&mut lines.variance, frf.variance) {
                scaled.push(rows.iter().map(|&k| v[i][k] / size / size).collect());
            }
        }
        lines.channels = (0..lines.h.len()).map(|i| vec![i]).collect();
        if lines.h.is_empty() {
            return Err(Error::new(
                Code::NoSignal,
                "every response is zero on every line of the band",
            ));
        }
        Ok(lines)
    }

    /// Minimum variance of a value due to rounding of the value and, with the slope of the response, of the frequency.
    pub fn variance_floor(&self, response: usize, line: usize) -> f64 {
        let h = &self.h[response];
        let slope = [line.saturating_sub(1), (line + 1).min(h.len() - 1)]
            .into_iter()
            .filter(|&k| k != line)
            .map(|k| (h[k] - h[line]).norm_sqr().sqrt() / (self.x[k] - self.x[line]).abs())
            .fold(0.0, f64::max);
        let of_frequency = ROUNDING.2 * self.x[line] * slope;
        ROUNDING.0.powi(2) + ROUNDING.1.powi(2) * h[line].norm_sqr() + of_frequency.powi(2)
    }

    /// Limits a variance of the scaled responses from below by [`ScaledResponses::variance_floor`].
    pub fn with_variance_floor(&self, variance: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let response = |(i, v): (usize, &Vec<f64>)| {
            let limit = |(k, v): (usize, &f64)| v.max(self.variance_floor(i, k));
            v.iter().enumerate().map(limit).collect()
        };
        variance.iter().enumerate().map(response).collect()
    }

    /// Frequencies of the first and the last line, Hz.
    pub fn band_limits_hz(&self) -> (f64, f64) {
        (self.x[0] * self.max_omega / TAU, self.max_omega / TAU)
    }

    /// True if a pole lies in the band and is no background pole.
    pub fn may_be_mode(&self, pole: &ScaledPole) -> bool {
        /// Damping ratio above which a pole is background.
        const BACKGROUND_DAMPING: f64 = 0.3;
        (self.x[0]..=1.0).contains(&pole.w) && pole.sigma < BACKGROUND_DAMPING * pole.w
    }

    /// True if the lines cover only one side of the peak of a pole: it lies outside the band, or so close to a band limit that the response
    /// there exceeds 0.8 of the peak power.
    pub fn is_peak_at_end(&self, pole: &ScaledPole) -> bool {
        let reach = self.step.max(0.5 * pole.sigma.abs());
        pole.w < self.x[0] + reach || pole.w > 1.0 - reach
    }

    /// Converts a variance to separable weights of a search.
    pub fn weights(&self, variance: &[Vec<f64>]) -> SeparableWeights {
        SeparableWeights::new(variance, self.variance.is_some())
    }

    /// Number of independent real data values.
    pub fn data_count(&self) -> f64 {
        2.0 * self.x.len() as f64 * self.h.len() as f64 * self.independence
    }

    /// Factor `s^q` on a line.
    pub fn power(&self, line: usize) -> Complex {
        (0..self.derivative).fold(Complex::new(1.0, 0.0), |z, _| {
            z * Complex::new(0.0, self.x[line])
        })
    }

    /// Factor `|s^q|²` on a line.
    pub fn power_size(&self, line: usize) -> f64 {
        self.x[line].powi(2 * i32::from(self.derivative))
    }

    /// Problem of all responses with common weights by line.
    pub fn shared_problem(
        &self,
        weights: &SeparableWeights,
        structure: ModelTerms,
    ) -> WhitenedProblem {
        let indices: Vec<usize> = (0..self.h.len()).collect();
        self.problem(&indices, &weights.by_response, &weights.by_line, structure)
    }

    /// Problems for each output with separate weights by line; the weights of its hits differ by a factor.
    pub fn separate_problems(
        &self,
        weights: &SeparableWeights,
        variance: &[Vec<f64>],
        structure: ModelTerms,
    ) -> Vec<WhitenedProblem> {
        let problem = |responses: &Vec<usize>| {
            let mean = |k: usize| {
                let logs = responses
                    .iter()
                    .map(|&i| (variance[i][k] / weights.by_response[i]).ln());
                (logs.sum::<f64>() / responses.len() as f64).exp()
            };
            let by_line: Vec<f64> = (0..self.x.len()).map(mean).collect();
            self.problem(responses, &weights.by_response, &by_line, structure)
        };
        self.channels.iter().map(problem).collect()
    }

    fn problem(
        &self,
        responses: &[usize],
        by_response: &[f64],
        by_line: &[f64],
        structure: ModelTerms,
    ) -> WhitenedProblem {
        let n = self.x.len();
        let weight: Vec<f64> = by_line
            .iter()
            .map(|v| (2.0 * self.independence / v).sqrt())
            .collect();
        let factor: Vec<Complex> = (0..n).map(|k| self.power(k) * weight[k]).collect();
        let mut y = Matrix::zeros(2 * n, responses.len());
        for (j, &i) in responses.iter().enumerate() {
            let scale = 1.0 / by_response[i].sqrt();
            let column = y.col_as_slice_mut(j);
            for k in 0..n {
                set_complex(column, k, n, self.h[i][k] * (weight[k] * scale));
            }
        }
        WhitenedProblem {
            pole_free_columns: WhitenedProblem::residual_terms(&self.x, &factor, structure),
            x: self.x.clone(),
            factor,
            y,
            first: responses[0],
            line_spacing: self.step,
            omitted_energy: 0.0,
        }
    }
}

/// Separable approximation `by_response × by_line` of a variance, for searches over all responses.
#[derive(Debug, Clone)]
pub(super) struct SeparableWeights {
    /// Geometric mean variance of each response.
    pub by_response: Vec<f64>,
    /// Mean over the responses of the variance relative to `by_response`, by line.
    pub by_line: Vec<f64>,
    /// True if the product equals the variance.
    pub exact: bool,
}

/// Maximum deviation of the logarithm of a separable variance from the product.
const SEPARABLE: f64 = 0.02;

/// Exponent of the power mean, over the responses, of an estimated variance. A value close to the maximum avoids that noise proportional to
/// one response is identified as a pole on lines where the other responses have an antiresonance. For a measured variance the geometric
/// mean is used, which is least sensitive to its scatter.
const MEAN_POWER: f64 = 4.0;

impl SeparableWeights {
    /// Geometric mean over the responses, for a variance with the model error of each response.
    pub fn mean(variance: &[Vec<f64>]) -> SeparableWeights {
        SeparableWeights::new(variance, true)
    }

    /// Separates a variance that is measured or estimated from the responses.
    fn new(variance: &[Vec<f64>], is_measured: bool) -> SeparableWeights {
        let mean = |values: &mut dyn Iterator<Item = f64>, n: usize| values.sum::<f64>() / n as f64;
        let lines = variance[0].len();
        if variance.iter().all(|v| v.iter().all(|x| *x == v[0])) {
            return SeparableWeights {
                by_response: variance.iter().map(|v| v[0]).collect(),
                by_line: vec![1.0; lines],
                exact: true,
            };
        }
        let response_logs: Vec<f64> = variance
            .iter()
            .map(|v| mean(&mut v.iter().map(|v| v.ln()), lines))
            .collect();
        let line_logs: Vec<f64> = (0..lines)
            .map(|k| {
                let logs = variance
                    .iter()
                    .zip(&response_logs)
                    .map(|(v, g)| v[k].ln() - g);
                if is_measured {
                    return mean(&mut logs.clone(), variance.len());
                }
                let largest = logs.clone().fold(f64::NEG_INFINITY, f64::max);
                let mut powers = logs.map(|l| (MEAN_POWER * (l - largest)).exp());
                largest + mean(&mut powers, variance.len()).ln() / MEAN_POWER
            })
            .collect();
        let exact = variance.iter().zip(&response_logs).all(|(v, g)| {
            v.iter()
                .zip(&line_logs)
                .all(|(v, b)| (v.ln() - g - b).abs() < SEPARABLE)
        });
        SeparableWeights {
            by_response: response_logs.iter().map(|g| g.exp()).collect(),
            by_line: line_logs.iter().map(|b| b.exp()).collect(),
            exact,
        }
    }
}

fn check(frf: &FrfData, options: &RationalOptions) -> Result<(), Error> {
    let f = frf.frequency_hz;
    if let Some(k) = (0..f.len()).find(|&k| !f[k].is_finite()) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("frequency {} is {} Hz", k + 1, f[k]),
        ));
    }
    if let Some(k) = (1..f.len()).find(|&k| f[k] <= f[k - 1]) {
        return Err(Error::new(
            Code::OutOfRange,
            format!(
                "frequencies must increase, but {} Hz follows {} Hz",
                f[k],
                f[k - 1]
            ),
        ));
    }
    if let Some((from, to)) = options.band_hz
        && !(from < to && from >= 0.0)
    {
        return Err(Error::new(
            Code::OutOfRange,
            format!("the band from {from} Hz to {to} Hz is empty"),
        ));
    }
    if !(frf.line_independence > 0.0 && frf.line_independence <= 1.0) {
        return Err(Error::new(
            Code::OutOfRange,
            format!(
                "{} independent lines per line; it must be above 0 and at most 1",
                frf.line_independence
            ),
        ));
    }
    if frf.responses.is_empty() {
        return Err(Error::new(Code::NoSignal, "there is no response to fit"));
    }
    let length_error = |what: &str, i: usize, n: usize| {
        (n != f.len()).then(|| {
            Error::new(
                Code::Conflict,
                format!("{what} {} has {n} values at {} frequencies", i + 1, f.len()),
            )
        })
    };
    for (i, h) in frf.responses.iter().enumerate() {
        if let Some(error) = length_error("response", i, h.len()) {
            return Err(error);
        }
        if let Some(k) = h
            .iter()
            .position(|z| !(z.re.is_finite() && z.im.is_finite()))
        {
            return Err(Error::new(
                Code::OutOfRange,
                format!("response {} at {} Hz is {}", i + 1, f[k], h[k]),
            )
            .with_hint("omit lines that were not measured"));
        }
    }
    let Some(variance) = frf.variance else {
        return Ok(());
    };
    if variance.len() != frf.responses.len() {
        return Err(Error::new(
            Code::Conflict,
            format!(
                "{} variances are given for {} responses",
                variance.len(),
                frf.responses.len()
            ),
        ));
    }
    for (i, v) in variance.iter().enumerate() {
        if let Some(error) = length_error("variance", i, v.len()) {
            return Err(error);
        }
        if let Some(k) = v.iter().position(|v| !(v.is_finite() && *v >= 0.0)) {
            return Err(Error::new(
                Code::OutOfRange,
                format!(
                    "the variance of response {} at {} Hz is {}",
                    i + 1,
                    f[k],
                    v[k]
                ),
            ));
        }
    }
    Ok(())
}
