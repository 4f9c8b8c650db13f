//! Measured FRFs validated and scaled: frequency by the highest line, each response by its maximum.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::{Complex, Matrix};

use super::basis::{ModelTerms, ScaledPole, WhitenedProblem, set_complex};
use super::scan::median_spacing;
use super::{FrfData, RationalOptions};

/// Lines within the band, responses that are not zero throughout.
#[derive(Debug, Clone)]
pub(super) struct ScaledResponses {
    /// Frequency over the highest.
    pub x: Vec<f64>,
    /// Median spacing of `x`.
    pub step: f64,
    /// Angular frequency of the highest line, rad/s.
    pub max_omega: f64,
    /// Which of the measured responses these are.
    pub response_indices: Vec<usize>,
    /// The largest absolute value of each.
    pub size: Vec<f64>,
    /// Responses over their size.
    pub h: Vec<Vec<Complex>>,
    /// Variances over the square of the size, where given.
    pub variance: Option<Vec<Vec<f64>>>,
    /// Power of s that turns a receptance into this kind of response.
    pub derivative: u8,
    /// Independent lines per line.
    pub independence: f64,
    /// Power of a fourth difference of neighbouring lines over that of their noise.
    pub fourth: f64,
    /// Responses that belong together, such as those of a hit; empty where each is of the same record.
    pub hits: Vec<Vec<usize>>,
    /// Neighbouring responses of one output to different hits, which share their weights; each alone where no hits are known.
    pub channels: Vec<Vec<usize>>,
    /// Hits that each of these joins, on average.
    pub joined: f64,
}

/// A fit of fewer lines says nothing.
const MIN_LINES: usize = 8;

/// Sum of the squared binomial coefficients 1, 4, 6, 4, 1: the variance of a fourth difference of unit noise.
pub(super) const FOURTH_DIFFERENCE_VARIANCE: f64 = 70.0;

/// A variance is taken as no smaller than rounding makes it: relative to the peak, to the value, and to the frequency.
const ROUNDING: (f64, f64, f64) = (1e-14, 3e-15, 1e-15);

impl ScaledResponses {
    /// The same hit by hit, each with responses of its own and a variance that is not known; `None` where there are fewer than two.
    ///
    /// # Errors
    /// As [`ScaledResponses::new`].
    pub fn split_by_hit(
        measured: &FrfData,
        options: &RationalOptions,
    ) -> Result<Option<ScaledResponses>, Error> {
        let Some(hits) = measured.hits.filter(|h| h.responses.len() > 1) else {
            return Ok(None);
        };
        let count = hits.responses.len();
        // Output by output, so that the hits of one lie next to each other.
        let responses: Vec<Vec<Complex>> = (0..measured.responses.len())
            .flat_map(|output| hits.responses.iter().map(move |hit| hit[output].clone()))
            .collect();
        let each = FrfData {
            responses: &responses,
            variance: None,
            hits: None,
            ..*measured
        };
        let mut lines = ScaledResponses::new(&each, options)?;
        (lines.fourth, lines.joined) = (hits.fourth, hits.joined);
        let grouped = |groups: usize, group: &dyn Fn(usize) -> usize| -> Vec<Vec<usize>> {
            let all = (0..groups).map(|g| {
                let of = |at: &usize| group(lines.response_indices[*at]) == g;
                (0..lines.response_indices.len()).filter(of).collect()
            });
            all.filter(|of: &Vec<usize>| !of.is_empty()).collect()
        };
        let by_hit = grouped(count, &|i| i % count);
        lines.channels = grouped(measured.responses.len(), &|i| i / count);
        lines.hits = by_hit;
        Ok(Some(lines))
    }

    /// The average of hits that are fitted one by one, of a variance that is not known.
    pub fn average_of(&self, hits: &ScaledResponses) -> ScaledResponses {
        ScaledResponses {
            variance: None,
            fourth: hits.fourth,
            ..self.clone()
        }
    }

    /// Checks what was measured and takes what lies in the band; the line at zero frequency is left out.
    pub fn new(measured: &FrfData, options: &RationalOptions) -> Result<ScaledResponses, Error> {
        check(measured, options)?;
        let (from, to) = options.band_hz.unwrap_or((0.0, f64::INFINITY));
        let taken: Vec<usize> = (0..measured.frequency_hz.len())
            .filter(|&k| measured.frequency_hz[k] > 0.0)
            .filter(|&k| (from..=to).contains(&measured.frequency_hz[k]))
            .collect();
        if taken.len() < MIN_LINES {
            return Err(Error::new(
                Code::TooShort,
                format!(
                    "{} lines above 0 Hz lie in the band, {MIN_LINES} are the least a pole can be fitted to",
                    taken.len()
                ),
            )
            .with_hint("widen the band, or measure with a finer frequency step"));
        }
        let highest = measured.frequency_hz[taken[taken.len() - 1]];
        let x: Vec<f64> = taken
            .iter()
            .map(|&k| measured.frequency_hz[k] / highest)
            .collect();
        let mut lines = ScaledResponses {
            step: median_spacing(&x),
            x,
            max_omega: TAU * highest,
            response_indices: Vec::new(),
            size: Vec::new(),
            h: Vec::new(),
            variance: measured.variance.map(|_| Vec::new()),
            derivative: measured.derivative,
            independence: measured.line_independence,
            fourth: FOURTH_DIFFERENCE_VARIANCE,
            hits: Vec::new(),
            channels: Vec::new(),
            joined: 1.0,
        };
        for (i, response) in measured.responses.iter().enumerate() {
            let size = taken
                .iter()
                .map(|&k| response[k].norm())
                .fold(0.0, f64::max);
            if size == 0.0 {
                continue;
            }
            lines.response_indices.push(i);
            lines.size.push(size);
            lines
                .h
                .push(taken.iter().map(|&k| response[k] / size).collect());
            if let (Some(all), Some(mine)) = (&mut lines.variance, measured.variance) {
                all.push(taken.iter().map(|&k| mine[i][k] / size / size).collect());
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

    /// Least variance of a value: what rounding leaves of it, and of the frequency where the response is steep.
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

    /// A variance over the scaled responses, nowhere below what rounding makes it.
    pub fn with_variance_floor(&self, variance: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let of = |(i, v): (usize, &Vec<f64>)| {
            let line = |(k, v): (usize, &f64)| v.max(self.variance_floor(i, k));
            v.iter().enumerate().map(line).collect()
        };
        variance.iter().enumerate().map(of).collect()
    }

    /// The first line and the last, Hz.
    pub fn band_limits_hz(&self) -> (f64, f64) {
        (self.x[0] * self.max_omega / TAU, self.max_omega / TAU)
    }

    /// Whether a pole lies in the band and is no background.
    pub fn may_be_mode(&self, pole: &ScaledPole) -> bool {
        /// Damping ratio from which on a pole is background.
        const BACKGROUND_DAMPING: f64 = 0.3;
        (self.x[0]..=1.0).contains(&pole.w) && pole.sigma < BACKGROUND_DAMPING * pole.w
    }

    /// Whether the lines show one side of a pole's peak alone: it lies outside of them, at an end, or so near to one that the response
    /// there is more than 0.8 of the power of the peak.
    pub fn is_peak_at_end(&self, pole: &ScaledPole) -> bool {
        let reach = self.step.max(0.5 * pole.sigma.abs());
        pole.w < self.x[0] + reach || pole.w > 1.0 - reach
    }

    /// A variance as weights of a search.
    pub fn weights(&self, variance: &[Vec<f64>]) -> SeparableWeights {
        SeparableWeights::new(variance, self.variance.is_some())
    }

    /// Real numbers of data, by what the lines hold independently.
    pub fn data_count(&self) -> f64 {
        2.0 * self.x.len() as f64 * self.h.len() as f64 * self.independence
    }

    /// `s^q` on a line.
    pub fn power(&self, line: usize) -> Complex {
        (0..self.derivative).fold(Complex::new(1.0, 0.0), |z, _| {
            z * Complex::new(0.0, self.x[line])
        })
    }

    /// `|s^q|²` on a line.
    pub fn power_size(&self, line: usize) -> f64 {
        self.x[line].powi(2 * i32::from(self.derivative))
    }

    /// All responses with one weight profile.
    pub fn shared_problem(
        &self,
        weights: &SeparableWeights,
        structure: ModelTerms,
    ) -> WhitenedProblem {
        let all: Vec<usize> = (0..self.h.len()).collect();
        self.problem(&all, &weights.by_response, &weights.by_line, structure)
    }

    /// One problem per output, each with its own weights: those of its hits differ by a factor.
    pub fn separate_problems(
        &self,
        weights: &SeparableWeights,
        variance: &[Vec<f64>],
        structure: ModelTerms,
    ) -> Vec<WhitenedProblem> {
        let one = |of: &Vec<usize>| {
            let mean = |k: usize| {
                let logs = of
                    .iter()
                    .map(|&i| (variance[i][k] / weights.by_response[i]).ln());
                (logs.sum::<f64>() / of.len() as f64).exp()
            };
            let own: Vec<f64> = (0..self.x.len()).map(mean).collect();
            self.problem(of, &weights.by_response, &own, structure)
        };
        self.channels.iter().map(one).collect()
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
        for (at, &i) in responses.iter().enumerate() {
            let scale = 1.0 / by_response[i].sqrt();
            let column = y.col_as_slice_mut(at);
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

/// A variance as a product `by_response × by_line`, for searches over all responses at once.
#[derive(Debug, Clone)]
pub(super) struct SeparableWeights {
    /// Geometric mean of each response.
    pub by_response: Vec<f64>,
    /// Mean over the responses, by line, once those are set apart.
    pub by_line: Vec<f64>,
    /// The product is the variance.
    pub exact: bool,
}

/// Variances within this ratio of the product are taken as the product.
const SEPARABLE: f64 = 0.02;

/// Power of the mean, over the responses, of a variance estimated from them: near to the largest, so that the noise of the one response
/// that has most on a line is not taken for a pole, where noise is proportional to the response and others are at an antiresonance. The
/// mean of a measured variance is the geometric one, which its scatter moves least.
const MEAN_POWER: f64 = 4.0;

impl SeparableWeights {
    /// The mean over the responses, for a variance whose departures go with each response.
    pub fn mean(variance: &[Vec<f64>]) -> SeparableWeights {
        SeparableWeights::new(variance, true)
    }

    /// Splits a variance, measured or estimated from the responses.
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
        let of_response: Vec<f64> = variance
            .iter()
            .map(|v| mean(&mut v.iter().map(|v| v.ln()), lines))
            .collect();
        let of_line: Vec<f64> = (0..lines)
            .map(|k| {
                let logs = variance
                    .iter()
                    .zip(&of_response)
                    .map(|(v, g)| v[k].ln() - g);
                if is_measured {
                    return mean(&mut logs.clone(), variance.len());
                }
                let largest = logs.clone().fold(f64::NEG_INFINITY, f64::max);
                let mut powers = logs.map(|l| (MEAN_POWER * (l - largest)).exp());
                largest + mean(&mut powers, variance.len()).ln() / MEAN_POWER
            })
            .collect();
        let exact = variance.iter().zip(&of_response).all(|(v, g)| {
            v.iter()
                .zip(&of_line)
                .all(|(v, b)| (v.ln() - g - b).abs() < SEPARABLE)
        });
        SeparableWeights {
            by_response: of_response.iter().map(|g| g.exp()).collect(),
            by_line: of_line.iter().map(|b| b.exp()).collect(),
            exact,
        }
    }
}

fn check(measured: &FrfData, options: &RationalOptions) -> Result<(), Error> {
    let f = measured.frequency_hz;
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
                "frequencies must rise, and {} Hz follows {} Hz",
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
    if !(measured.line_independence > 0.0 && measured.line_independence <= 1.0) {
        return Err(Error::new(
            Code::OutOfRange,
            format!(
                "{} independent lines per line; it must lie above 0 and at most at 1",
                measured.line_independence
            ),
        ));
    }
    if measured.responses.is_empty() {
        return Err(Error::new(Code::NoSignal, "there is no response to fit"));
    }
    let lengths = |what: &str, i: usize, n: usize| {
        (n != f.len()).then(|| {
            Error::new(
                Code::Conflict,
                format!("{what} {} has {n} values at {} frequencies", i + 1, f.len()),
            )
        })
    };
    for (i, h) in measured.responses.iter().enumerate() {
        if let Some(error) = lengths("response", i, h.len()) {
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
            .with_hint("leave out lines that were not measured"));
        }
    }
    let Some(variance) = measured.variance else {
        return Ok(());
    };
    if variance.len() != measured.responses.len() {
        return Err(Error::new(
            Code::Conflict,
            format!(
                "{} variances are given for {} responses",
                variance.len(),
                measured.responses.len()
            ),
        ));
    }
    for (i, v) in variance.iter().enumerate() {
        if let Some(error) = lengths("variance", i, v.len()) {
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
