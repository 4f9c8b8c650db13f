//! Sine fits with three or four parameters (IEEE 1057): `x = Re(A e^{iωt}) + x₀`.
//!
//! IEEE Std 1057-2017, section 4.6 (sine fits of three and four parameters); white residuals of variance σ² over N samples give
//! `E|ΔA|² = 4σ²/N`.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::symmetric::lu_solve;
use crate::numeric::{Complex, Matrix};

/// Sine with offset fitted by least squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SineFit {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Complex amplitude (0 to peak), with the time origin at the middle of the samples.
    pub amplitude: Complex,
    /// Offset, the mean level of the sine.
    pub offset: f64,
    /// Variance `E|error|²` of the amplitude for a white residual.
    pub variance: f64,
}

impl SineFit {
    /// Subtracts the sine without its offset from the fitted samples.
    pub fn subtract_from(&self, samples: &mut [f64], rate_hz: f64) {
        self.add(samples, rate_hz, -1.0);
    }

    /// Adds the sine without its offset to the fitted samples.
    pub fn add_to(&self, samples: &mut [f64], rate_hz: f64) {
        self.add(samples, rate_hz, 1.0);
    }

    fn add(&self, samples: &mut [f64], rate_hz: f64, factor: f64) {
        let middle = 0.5 * (samples.len() as f64 - 1.0);
        let omega = TAU * self.frequency_hz / rate_hz;
        let amplitude = factor * self.amplitude;
        for (j, x) in samples.iter_mut().enumerate() {
            let (s, c) = (omega * (j as f64 - middle)).sin_cos();
            *x += amplitude.re * c - amplitude.im * s;
        }
    }

    /// Variance `E|error|²` of the amplitude by the residual on neighbouring lines; for a white residual if the band has none.
    pub fn variance_near(&self, samples: &[f64], rate_hz: f64) -> f64 {
        let n = samples.len() as f64;
        let line = rate_hz / n;
        let mut residual = samples.to_vec();
        self.subtract_from(&mut residual, rate_hz);
        residual.iter_mut().for_each(|x| *x -= self.offset);
        let neighbours =
            NOISE_LINES.flat_map(|k| [-1.0, 1.0].map(|s| self.frequency_hz + s * k as f64 * line));
        let in_band = |f: &f64| *f > line && *f < 0.5 * rate_hz - line;
        let powers: Vec<f64> = neighbours
            .filter(in_band)
            .map(|f| transform(&residual, TAU * f / rate_hz).norm_sqr())
            .collect();
        match powers.is_empty() {
            true => self.variance,
            false => 4.0 * powers.iter().sum::<f64>() / powers.len() as f64 / (n * n),
        }
    }
}

/// Line distances on either side of a sine for the noise estimate; the fit removes noise from the first line.
const NOISE_LINES: std::ops::RangeInclusive<usize> = 2..=9;

/// Fourier sum `Σ x_j e^{−iωj}` by Goertzel's recursion, up to a phase; `omega`: rad per sample.
fn transform(samples: &[f64], omega: f64) -> Complex {
    let c = 2.0 * omega.cos();
    let (last, before) = (samples.iter()).fold((0.0, 0.0), |(s, t), x| (x + c * s - t, s));
    let rotation = Complex::from_polar(1.0, omega);
    // The phase of the first sample is irrelevant to the power.
    rotation * last - before
}

/// Maximum number of Gauss–Newton steps of a fit from a start within half a line.
const MAX_ITERATIONS: usize = 30;

/// Convergence tolerance of the frequency, cycles over half the record.
const FREQUENCY_TOLERANCE: f64 = 1e-12;

/// Limit of rounding, cycles over half the record: a smaller change that exceeds half the previous one ends the iteration. The angle per
/// sample has a resolution of `2⁻⁵²` of the power of two below it. Slightly above one, as 1.13 at 180 Hz and 1 000 samples/s, it amounts
/// to more than [`FREQUENCY_TOLERANCE`] over a long record, and the steps would alternate between two adjacent values.
const ROUNDING_TOLERANCE: f64 = 1e-6;

/// Fits amplitude and offset at a known frequency.
///
/// # Errors
/// `IllPosed`: fewer than five samples, or a frequency at which sine, cosine and offset are linearly dependent.
pub fn fit_amplitude(samples: &[f64], rate_hz: f64, frequency_hz: f64) -> Result<SineFit, Error> {
    Ok(step(samples, rate_hz, frequency_hz, None)?.0)
}

/// Fits amplitude, offset and frequency, from an initial frequency within about half a line, `rate/n`.
///
/// # Errors
/// As [`fit_amplitude`]; `NoConvergence`: the frequency diverges.
pub fn fit(samples: &[f64], rate_hz: f64, start_hz: f64) -> Result<SineFit, Error> {
    let half = 0.5 * samples.len() as f64 / rate_hz;
    let mut frequency = start_hz;
    let (mut fitted, _) = step(samples, rate_hz, frequency, None)?;
    let mut last = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        let change;
        (fitted, change) = step(samples, rate_hz, frequency, Some(fitted.amplitude))?;
        frequency += change;
        let cycles = change.abs() * half;
        if cycles < FREQUENCY_TOLERANCE || (cycles < ROUNDING_TOLERANCE && cycles > 0.5 * last) {
            return Ok(fitted);
        }
        last = cycles;
        if (frequency - start_hz).abs() * half > 1.0 || !frequency.is_finite() {
            break;
        }
    }
    Err(Error::new(
        Code::NoConvergence,
        format!("the fit of a sine near {start_hz} Hz diverged: its frequency is {frequency} Hz"),
    ))
}

/// Linear least-squares fit; with an amplitude `around` also of the change of frequency, Hz.
fn step(
    samples: &[f64],
    rate_hz: f64,
    frequency_hz: f64,
    around: Option<Complex>,
) -> Result<(SineFit, f64), Error> {
    let unknowns = if around.is_some() { 4 } else { 3 };
    let n = samples.len();
    if n <= unknowns {
        return Err(Error::new(
            Code::IllPosed,
            format!("{n} samples do not determine a sine"),
        ));
    }
    let middle = 0.5 * (n as f64 - 1.0);
    let omega = TAU * frequency_hz / rate_hz;
    let rows = |j: usize| {
        let t = j as f64 - middle;
        let (s, c) = (omega * t).sin_cos();
        // a cos θ + b sin θ, A = a − ib; the last column by ω, over half the record.
        let slope = around.map_or(0.0, |a| (-a.re * s - a.im * c) * t / middle);
        [c, s, 1.0, slope]
    };
    let mut normal = Matrix::zeros(unknowns, unknowns);
    let mut right = Matrix::zeros(unknowns, 1);
    for (j, x) in samples.iter().enumerate() {
        let row = rows(j);
        for (p, a) in row[..unknowns].iter().enumerate() {
            right[(p, 0)] += a * x;
            for (q, b) in row[..unknowns].iter().enumerate() {
                normal[(p, q)] += a * b;
            }
        }
    }
    let solution = lu_solve(&normal, &right).map_err(|_| {
        Error::new(
            Code::IllPosed,
            format!("{n} samples do not determine a sine of {frequency_hz} Hz at {rate_hz} Hz"),
        )
    })?;
    let squared_residual = |(j, x): (usize, &f64)| {
        let row = rows(j);
        let model: f64 = (0..unknowns).map(|p| row[p] * solution[(p, 0)]).sum();
        (x - model).powi(2)
    };
    let squares: f64 = samples.iter().enumerate().map(squared_residual).sum();
    let fitted = SineFit {
        frequency_hz,
        amplitude: Complex::new(solution[(0, 0)], -solution[(1, 0)]),
        offset: solution[(2, 0)],
        variance: 4.0 * squares / (n - unknowns) as f64 / n as f64,
    };
    let change = if unknowns == 4 {
        solution[(3, 0)] / middle * rate_hz / TAU
    } else {
        0.0
    };
    Ok((fitted, change))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize, f: f64, a: f64, phase: f64) -> Vec<f64> {
        let value = |j: usize| 0.7 + a * (TAU * f * j as f64 + phase).cos();
        (0..n).map(value).collect()
    }

    #[test]
    fn exact_fit_of_four() {
        for f in [0.0123, 0.1, 0.37] {
            let found = fit(&wave(700, f, 2.0, 0.5), 1.0, f + 0.4 / 700.0).unwrap();
            assert!((found.frequency_hz - f).abs() < 1e-14, "{found:?}");
            let phase = TAU * f * 349.5 + 0.5;
            let exact = Complex::new(phase.cos(), phase.sin()) * 2.0;
            assert!((found.amplitude - exact).norm() < 1e-11, "{found:?}");
            assert!((found.offset - 0.7).abs() < 1e-12 && found.variance < 1e-24);
        }
    }

    /// Long noisy records of sines at the coarsest resolution of the angle per sample: the iteration converges although its last steps
    /// alternate by one rounding.
    #[test]
    fn survives_rounding_of_the_angle() {
        const SAMPLES: usize = 60_000;
        let mut rng = fastrand::Rng::with_seed(11);
        for k in 0..60 {
            let f = [0.1793, 0.18, 0.1671, 0.3333, 0.36][k % 5];
            let noisy: Vec<f64> = wave(SAMPLES, f, 2.0, k as f64)
                .iter()
                .map(|x| x + 3.0 * (rng.f64() - 0.5))
                .collect();
            let found = fit(&noisy, 1.0, f).unwrap();
            // Standard deviation √(6σ²/N)/(πNA) of the frequency, σ² = 9/12 (IEEE Std 1057-2017, annex).
            let std = (6.0 * 0.75 / SAMPLES as f64).sqrt()
                / (std::f64::consts::PI * SAMPLES as f64 * 2.0);
            assert!((found.frequency_hz - f).abs() < 5.0 * std, "{found:?}");
        }
    }

    /// The stated variance of the amplitude equals its scatter in white noise.
    #[test]
    fn law_variance_of_the_amplitude() {
        let mut rng = fastrand::Rng::with_seed(2);
        let (mut scatter, mut stated) = (0.0, 0.0);
        let exact = Complex::new((TAU * 0.11 * 99.5).cos(), (TAU * 0.11 * 99.5).sin());
        for _ in 0..2000 {
            let noisy: Vec<f64> = wave(200, 0.11, 1.0, 0.0)
                .iter()
                .map(|x| x + rng.f64() - 0.5)
                .collect();
            let found = fit_amplitude(&noisy, 1.0, 0.11).unwrap();
            scatter += (found.amplitude - exact).norm_sqr();
            stated += found.variance;
        }
        assert!((stated / scatter - 1.0).abs() < 0.08, "{stated} {scatter}");
    }

    /// The stated variance of the amplitude equals its scatter in noise with a peak at the frequency.
    #[test]
    fn law_variance_in_coloured_noise() {
        let mut rng = fastrand::Rng::with_seed(7);
        let (mut scatter, mut stated, mut white) = (0.0, 0.0, 0.0);
        for _ in 0..400 {
            let (mut a, mut b) = (0.0, 0.0);
            let step = |t: i32| {
                // A resonance at 0.1 of the rate, a tenth as wide.
                let next = 1.52 * a - 0.885 * b + rng.f64() - 0.5;
                (b, a) = (a, next);
                (TAU * 0.1 * f64::from(t)).cos() + next
            };
            let noisy: Vec<f64> = (-100..2000).map(step).collect();
            let noisy = &noisy[100..];
            let found = fit_amplitude(noisy, 1.0, 0.1).unwrap();
            let exact = Complex::from_polar(1.0, TAU * 0.1 * 999.5);
            scatter += (found.amplitude - exact).norm_sqr();
            stated += found.variance_near(noisy, 1.0);
            white += found.variance;
        }
        assert!((stated / scatter - 1.0).abs() < 0.15, "{stated} {scatter}");
        assert!(white < 0.5 * scatter, "{white} {scatter}");
    }

    #[test]
    fn refuses_too_little() {
        assert_eq!(
            fit_amplitude(&[1.0; 3], 1.0, 0.1).unwrap_err().code,
            Code::IllPosed
        );
        assert_eq!(
            fit_amplitude(&[1.0; 30], 1.0, 0.0).unwrap_err().code,
            Code::IllPosed
        );
    }
}
