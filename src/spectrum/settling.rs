//! Settling of the response during a dwell of a stepped sine; extrapolation of a decaying transient to the steady state.

use std::ops::Range;

use super::sine::fit_amplitude;
use crate::base::error::Error;
use crate::numeric::Complex;

/// Segment of a stepped sine with constant input frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Dwell {
    /// Range of its samples.
    pub range: Range<usize>,
    /// Frequency from zero crossings, Hz.
    pub frequency_hz: f64,
}

/// Number of parts of a dwell whose responses are compared.
const DWELL_PARTS: usize = 8;

/// Settling tolerance relative to the mean response of the last half.
const SETTLING_TOLERANCE: f64 = 5e-4;

/// Settling tolerance in standard deviations of the parts of the last half; the larger tolerance applies.
const SCATTER_FACTOR: f64 = 4.0;

/// Index of the sample from which the response of a dwell stays within the tolerance of its mean over the last half.
pub fn settled_from(
    dwell: &Dwell,
    frequency_hz: f64,
    rate_hz: f64,
    input: &[f64],
    output: &[f64],
) -> Result<usize, Error> {
    let length = dwell.range.len() / DWELL_PARTS;
    let mut parts = Vec::with_capacity(DWELL_PARTS);
    for part in 0..DWELL_PARTS {
        let start = dwell.range.start + part * length;
        let range = start..start + length;
        let x = fit_amplitude(&input[range.clone()], rate_hz, frequency_hz)?;
        let y = fit_amplitude(&output[range], rate_hz, frequency_hz)?;
        parts.push(y.amplitude / x.amplitude);
    }
    let last = &parts[DWELL_PARTS / 2..];
    let mean = last.iter().sum::<Complex>() / last.len() as f64;
    let square: f64 = last.iter().map(|h| (h - mean).norm_sqr()).sum();
    let scatter = (square / (last.len() - 1) as f64).sqrt();
    let limit = (SETTLING_TOLERANCE * mean.norm()).max(SCATTER_FACTOR * scatter);
    let last_unsettled = parts.iter().rposition(|h| (h - mean).norm() > limit);
    Ok(dwell.range.start + last_unsettled.map_or(0, |at| at + 1) * length)
}

/// Steady-state estimate from a dwell that ends before the response has settled.
#[derive(Debug, Clone, Copy)]
pub struct SteadyStateEstimate {
    /// Extrapolated steady state of the response.
    pub steady_state: Complex,
    /// Variance `E|error|²` of the steady state.
    pub variance: f64,
}

/// Minimum squared change of the response from the third to the fourth quarter of a dwell that rings, in noise variances.
const MIN_CHANGE_SIGMA2: f64 = 16.0;

/// Maximum decay factor of the transient from quarter to quarter for which the steady state is extrapolated.
const MAX_DECAY_RATIO: f64 = 0.9;

/// Relative uncertainty of the extrapolated change, due to several ringing modes and to noise.
const EXTRAPOLATION_UNCERTAINTY: f64 = 0.2;

impl SteadyStateEstimate {
    /// Estimates the steady state of a dwell whose response still changes more than by noise, else `None`. The transient of one
    /// mode decays by a constant factor per quarter, so that the limit is `h₄ + d r/(1−r)`, `d = h₄ − h₃`, `r = d/(h₃ − h₂)` (Aitken 1926).
    ///
    /// # Errors
    /// As [`fit_amplitude`].
    pub fn extrapolate(
        dwell: &Dwell,
        frequency_hz: f64,
        rate_hz: f64,
        input: &[f64],
        output: &[f64],
    ) -> Result<Option<SteadyStateEstimate>, Error> {
        let length = dwell.range.len() / 4;
        let quarter = |part: usize| -> Result<(Complex, f64), Error> {
            let start = dwell.range.start + part * length;
            let (x, y) = (
                &input[start..start + length],
                &output[start..start + length],
            );
            let (x_fit, y_fit) = (
                fit_amplitude(x, rate_hz, frequency_hz)?,
                fit_amplitude(y, rate_hz, frequency_hz)?,
            );
            let h = y_fit.amplitude / x_fit.amplitude;
            let noise =
                y_fit.variance_near(y, rate_hz) + h.norm_sqr() * x_fit.variance_near(x, rate_hz);
            Ok((h, noise / x_fit.amplitude.norm_sqr()))
        };
        let [second, third, fourth] = [quarter(1)?, quarter(2)?, quarter(3)?];
        let change = fourth.0 - third.0;
        // Tolerance for rounding errors.
        let rounding = (SETTLING_TOLERANCE * fourth.0.norm()).powi(2);
        if change.norm_sqr() < MIN_CHANGE_SIGMA2 * (third.1 + fourth.1) + rounding {
            return Ok(None);
        }
        let factor = change / (third.0 - second.0);
        let extrapolation = match factor.norm() < MAX_DECAY_RATIO {
            true => change * factor / (1.0 - factor),
            false => change * MAX_DECAY_RATIO / (1.0 - MAX_DECAY_RATIO),
        };
        Ok(Some(match factor.norm() < MAX_DECAY_RATIO {
            true => SteadyStateEstimate {
                steady_state: fourth.0 + extrapolation,
                variance: (EXTRAPOLATION_UNCERTAINTY * extrapolation.norm()).powi(2) + fourth.1,
            },
            false => SteadyStateEstimate {
                steady_state: fourth.0,
                variance: extrapolation.norm_sqr(),
            },
        }))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Transient of one mode that decays to a tenth in a dwell: the error is small without noise, that of the mean of the last half is 0.2;
    /// with noise the error agrees with the variance; a settled response is not extrapolated.
    #[test]
    fn law_ringing_goes_where_it_settles() {
        const COUNT: usize = 3000;
        let mut random = fastrand::Rng::with_seed(4);
        let (f, pole) = (0.04, Complex::new(-7.7e-4, TAU * 0.0401));
        let input: Vec<f64> = (0..COUNT).map(|j| (TAU * f * j as f64).cos()).collect();
        let exact = Complex::new(0.6, -0.8);
        let dwell = Dwell {
            range: 0..COUNT,
            frequency_hz: f,
        };
        let mut estimate = |noise: f64, transient: f64| {
            let sample = |j: usize| {
                let wave = exact * Complex::from_polar(1.0, TAU * f * j as f64);
                let ringing = transient * (pole * j as f64).exp();
                (wave - ringing).re + noise * (random.f64() - 0.5)
            };
            let output: Vec<f64> = (0..COUNT).map(sample).collect();
            SteadyStateEstimate::extrapolate(&dwell, f, 1.0, &input, &output).unwrap()
        };
        let error = |ringing: &SteadyStateEstimate| (ringing.steady_state - exact).norm();
        assert!(error(&estimate(0.0, 1.0).unwrap()) < 3e-3);
        let (mut square, mut stated) = (0.0, 0.0);
        for _ in 0..20 {
            let ringing = estimate(0.2, 1.0).unwrap();
            square += error(&ringing).powi(2);
            stated += ringing.variance;
        }
        assert!(
            square < 1.5 * stated && stated < 20.0 * square,
            "{square} {stated}"
        );
        let rings = (0..40).filter(|_| estimate(0.2, 0.0).is_some()).count();
        assert!(rings <= 1, "{rings}");
    }
}
