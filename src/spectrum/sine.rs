//! Sine fits with three or four parameters (IEEE 1057): `x = Re(A e^{iωt}) + x₀`.
//!
//! IEEE Std 1057-2017, section 4.6 (sine fits of three and four parameters); white residuals of variance σ² over N samples give
//! `E|ΔA|² = 4σ²/N`.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::symmetric::lu_solve;
use crate::numeric::{Complex, Matrix};

/// A sine fitted by least squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SineFit {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Complex amplitude (0 to peak) with the time taken from the middle of the samples.
    pub amplitude: Complex,
    /// Offset about which the sine oscillates.
    pub offset: f64,
    /// `E|error|²` of the amplitude where what is left is white.
    pub variance: f64,
}

impl SineFit {
    /// Takes the sine, not its level, out of the samples it was fitted to.
    pub fn subtract_from(&self, samples: &mut [f64], rate_hz: f64) {
        self.add(samples, rate_hz, -1.0);
    }

    /// Puts the sine back into the samples it was taken out of.
    pub fn add_to(&self, samples: &mut [f64], rate_hz: f64) {
        self.add(samples, rate_hz, 1.0);
    }

    fn add(&self, samples: &mut [f64], rate_hz: f64, times: f64) {
        let middle = 0.5 * (samples.len() as f64 - 1.0);
        let turn = TAU * self.frequency_hz / rate_hz;
        let amplitude = times * self.amplitude;
        for (j, x) in samples.iter_mut().enumerate() {
            let (s, c) = (turn * (j as f64 - middle)).sin_cos();
            *x += amplitude.re * c - amplitude.im * s;
        }
    }

    /// `E|error|²` of an amplitude by what the fit leaves on lines near it; by all that it leaves where there are none.
    pub fn variance_near(&self, samples: &[f64], rate_hz: f64) -> f64 {
        let n = samples.len() as f64;
        let line = rate_hz / n;
        let mut left = samples.to_vec();
        self.subtract_from(&mut left, rate_hz);
        left.iter_mut().for_each(|x| *x -= self.offset);
        let sides =
            NOISE_LINES.flat_map(|k| [-1.0, 1.0].map(|s| self.frequency_hz + s * k as f64 * line));
        let is_line = |f: &f64| *f > line && *f < 0.5 * rate_hz - line;
        let powers: Vec<f64> = sides
            .filter(is_line)
            .map(|f| transform(&left, TAU * f / rate_hz).norm_sqr())
            .collect();
        match powers.is_empty() {
            true => self.variance,
            false => 4.0 * powers.iter().sum::<f64>() / powers.len() as f64 / (n * n),
        }
    }
}

/// Lines either side of a sine whose residual is the noise on it, from the second on: the fit takes from the first.
const NOISE_LINES: std::ops::RangeInclusive<usize> = 2..=9;

/// `Σ x_j e^{−iωj}`, by Goertzel's recursion.
fn transform(samples: &[f64], turn: f64) -> Complex {
    let c = 2.0 * turn.cos();
    let (last, before) = (samples.iter()).fold((0.0, 0.0), |(s, t), x| (x + c * s - t, s));
    let back = Complex::from_polar(1.0, turn);
    // The phase of the first sample does not count.
    back * last - before
}

/// Steps of Gauss and Newton that a fit from a start within half a line takes at most.
const MAX_ITERATIONS: usize = 30;

/// Convergence tolerance of the frequency: turns over half the record.
const FREQUENCY_TOLERANCE: f64 = 1e-12;

/// A change of less than this that is not half the last one is rounding: turns over half the record. The angle from one sample to the
/// next is known to `2⁻⁵²` of the power of two below it; where it lies little above one, as 1.13 at 180 Hz of 1 000 Hz, a long record
/// turns by more than [`FREQUENCY_TOLERANCE`] from one such angle to its neighbour, and the steps go back and forth between them without end.
const ROUNDING_TOLERANCE: f64 = 1e-6;

/// Fits amplitude and offset at a known frequency.
///
/// # Errors
/// `IllPosed`: fewer than five samples, or a frequency at which sine, cosine and level are not distinguished.
pub fn fit_amplitude(samples: &[f64], rate_hz: f64, frequency_hz: f64) -> Result<SineFit, Error> {
    Ok(step(samples, rate_hz, frequency_hz, None)?.0)
}

/// Fits amplitude, offset and frequency, from a start within about half of `rate/n` of it.
///
/// # Errors
/// As [`fit_amplitude`]; `NoConvergence` where the frequency runs away.
pub fn fit(samples: &[f64], rate_hz: f64, start_hz: f64) -> Result<SineFit, Error> {
    let half = 0.5 * samples.len() as f64 / rate_hz;
    let mut frequency = start_hz;
    let (mut found, _) = step(samples, rate_hz, frequency, None)?;
    let mut last = f64::INFINITY;
    for _ in 0..MAX_ITERATIONS {
        let change;
        (found, change) = step(samples, rate_hz, frequency, Some(found.amplitude))?;
        frequency += change;
        let turns = change.abs() * half;
        if turns < FREQUENCY_TOLERANCE || (turns < ROUNDING_TOLERANCE && turns > 0.5 * last) {
            return Ok(found);
        }
        last = turns;
        if (frequency - start_hz).abs() * half > 1.0 || !frequency.is_finite() {
            break;
        }
    }
    Err(Error::new(
        Code::NoConvergence,
        format!("a sine near {start_hz} Hz does not fit: its frequency runs off to {frequency} Hz"),
    ))
}

/// One least-squares fit; with an amplitude also of the change of frequency, Hz.
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
    let turn = TAU * frequency_hz / rate_hz;
    let rows = |j: usize| {
        let t = j as f64 - middle;
        let (s, c) = (turn * t).sin_cos();
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
    let found = lu_solve(&normal, &right).map_err(|_| {
        Error::new(
            Code::IllPosed,
            format!("{n} samples do not determine a sine of {frequency_hz} Hz at {rate_hz} Hz"),
        )
    })?;
    let left = |(j, x): (usize, &f64)| {
        let row = rows(j);
        let model: f64 = (0..unknowns).map(|p| row[p] * found[(p, 0)]).sum();
        (x - model).powi(2)
    };
    let square: f64 = samples.iter().enumerate().map(left).sum();
    let fitted = SineFit {
        frequency_hz,
        amplitude: Complex::new(found[(0, 0)], -found[(1, 0)]),
        offset: found[(2, 0)],
        variance: 4.0 * square / (n - unknowns) as f64 / n as f64,
    };
    let change = if unknowns == 4 {
        found[(3, 0)] / middle * rate_hz / TAU
    } else {
        0.0
    };
    Ok((fitted, change))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize, f: f64, a: f64, phase: f64) -> Vec<f64> {
        let at = |j: usize| 0.7 + a * (TAU * f * j as f64 + phase).cos();
        (0..n).map(at).collect()
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

    /// Long records of sines whose angle from sample to sample is known worst, in noise: steps of one rounding went back and forth at
    /// some of them, and they counted as no sines.
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

    /// In noise the stated variance of the amplitude is its scatter.
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

    /// Noise that is louder at the frequency than elsewhere: the stated variance of the amplitude is its scatter all the same.
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
