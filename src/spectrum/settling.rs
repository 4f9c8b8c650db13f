//! Settling of the response on a dwell of a stepped sine; extrapolation of a decaying transient.

use std::ops::Range;

use super::sine::fit_amplitude;
use crate::base::error::Error;
use crate::numeric::Complex;

/// Samples over which the input holds one frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Dwell {
    /// Samples of it.
    pub range: Range<usize>,
    /// Frequency by zero crossings, Hz.
    pub frequency_hz: f64,
}

/// Parts of a dwell whose responses are compared.
const DWELL_PARTS: usize = 8;

/// A part is settled within this share of the response that the last half shows.
const SETTLING_TOLERANCE: f64 = 5e-4;

/// Or within so many times their scatter.
const SCATTER_FACTOR: f64 = 4.0;

/// The sample from which the response of a dwell stays where its last half is.
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
    let off = parts.iter().rposition(|h| (h - mean).norm() > limit);
    Ok(dwell.range.start + off.map_or(0, |at| at + 1) * length)
}

/// The response of a dwell that ends before it has settled.
#[derive(Debug, Clone, Copy)]
pub struct SteadyStateEstimate {
    /// Extrapolated steady state of the response.
    pub steady_state: Complex,
    /// `E|error|²` of that, next to noise.
    pub variance: f64,
}

/// From one quarter of a dwell to the next the response moves by this many variances of what noise moves it by where it rings.
const MIN_CHANGE_SIGMA2: f64 = 16.0;

/// Largest decay factor of ringing from quarter to quarter for which the steady state is determined.
const MAX_DECAY_RATIO: f64 = 0.9;

/// Share of the way from the last quarter to where the response goes by which that is uncertain: several modes ring, and noise is on it.
const EXTRAPOLATION_UNCERTAINTY: f64 = 0.2;

impl SteadyStateEstimate {
    /// Estimate of the steady state of a ringing dwell, if it rings beyond noise. The transient of one mode falls from quarter to
    /// quarter by one factor, so that three quarters determine the limit: `h₄ + d r/(1 − r)` with `d = h₄ − h₃` and `r = d/(h₃ − h₂)` (Aitken 1926).
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
            let (of_x, of_y) = (
                fit_amplitude(x, rate_hz, frequency_hz)?,
                fit_amplitude(y, rate_hz, frequency_hz)?,
            );
            let h = of_y.amplitude / of_x.amplitude;
            let noise =
                of_y.variance_near(y, rate_hz) + h.norm_sqr() * of_x.variance_near(x, rate_hz);
            Ok((h, noise / of_x.amplitude.norm_sqr()))
        };
        let [second, third, fourth] = [quarter(1)?, quarter(2)?, quarter(3)?];
        let moved = fourth.0 - third.0;
        // Rounding moves as well.
        let rounding = (SETTLING_TOLERANCE * fourth.0.norm()).powi(2);
        if moved.norm_sqr() < MIN_CHANGE_SIGMA2 * (third.1 + fourth.1) + rounding {
            return Ok(None);
        }
        let factor = moved / (third.0 - second.0);
        let way = match factor.norm() < MAX_DECAY_RATIO {
            true => moved * factor / (1.0 - factor),
            false => moved * MAX_DECAY_RATIO / (1.0 - MAX_DECAY_RATIO),
        };
        Ok(Some(match factor.norm() < MAX_DECAY_RATIO {
            true => SteadyStateEstimate {
                steady_state: fourth.0 + way,
                variance: (EXTRAPOLATION_UNCERTAINTY * way.norm()).powi(2) + fourth.1,
            },
            false => SteadyStateEstimate {
                steady_state: fourth.0,
                variance: way.norm_sqr(),
            },
        }))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// A mode that has fallen to a tenth by the end of the dwell: without noise the response is estimated where the mean of the last half
    /// is off by two tenths; in noise the error is as stated; one that has settled does not ring.
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
        let mut told = |noise: f64, left: f64| {
            let at = |j: usize| {
                let wave = exact * Complex::from_polar(1.0, TAU * f * j as f64);
                let ringing = left * (pole * j as f64).exp();
                (wave - ringing).re + noise * (random.f64() - 0.5)
            };
            let output: Vec<f64> = (0..COUNT).map(at).collect();
            SteadyStateEstimate::extrapolate(&dwell, f, 1.0, &input, &output).unwrap()
        };
        let off = |ringing: &SteadyStateEstimate| (ringing.steady_state - exact).norm();
        assert!(off(&told(0.0, 1.0).unwrap()) < 3e-3);
        let (mut square, mut stated) = (0.0, 0.0);
        for _ in 0..20 {
            let ringing = told(0.2, 1.0).unwrap();
            square += off(&ringing).powi(2);
            stated += ringing.variance;
        }
        assert!(
            square < 1.5 * stated && stated < 20.0 * square,
            "{square} {stated}"
        );
        let rings = (0..40).filter(|_| told(0.2, 0.0).is_some()).count();
        assert!(rings <= 1, "{rings}");
    }
}
