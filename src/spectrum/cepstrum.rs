//! Real cepstrum `c(τ) = F⁻¹{ln |X|}`: harmonic families and echoes become single peaks.
//!
//! A. V. Oppenheim, R. W. Schafer, Discrete-Time Signal Processing, 3rd ed. (2010), chapter 13; the power cepstrum and its words
//! (quefrency, rahmonic, lifter) after B. P. Bogert, M. J. R. Healy, J. W. Tukey (1963); editing with unchanged phase after
//! R. B. Randall, N. Sawalhi, A new method for separating discrete components from a signal, Sound and Vibration 45 (2011), no. 5, 6–9.

use super::validation::{check_positive, check_samples};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;
use crate::numeric::parabola;

/// Lower limit of a power spectrum relative to its strongest line; the logarithm of smaller values is rounding.
const LOG_FLOOR: f64 = 1e-30;

/// Real cepstrum of a signal, for quefrencies from zero to half its length.
#[derive(Debug, Clone)]
pub struct Cepstrum {
    /// Quefrency step, s: the sample interval.
    pub step_s: f64,
    /// Real cepstrum `c(τ)`, neper.
    pub real: Vec<f64>,
}

/// Number of lines at 0 Hz distorted by removal of the mean and by the window, in an averaged spectrum.
const DC_LINES: usize = 3;

/// Rahmonic family: a cepstral peak and its multiples.
#[derive(Debug, Clone, PartialEq)]
pub struct Rahmonics {
    /// Interpolated quefrency of the first rahmonic, s: the inverse of the line spacing of the family.
    pub quefrency_s: f64,
    /// Heights of the first, second, … rahmonic, neper.
    pub height: Vec<f64>,
}

impl Cepstrum {
    /// Cepstrum of one period of a periodic signal.
    ///
    /// # Errors
    /// Fewer than four samples, samples not finite, a signal that is zero.
    pub fn new(samples: &[f64], rate_hz: f64) -> Result<Cepstrum, Error> {
        check_positive(rate_hz, "the sample rate, Hz,")?;
        let (mut fft, spectrum) = transform(samples)?;
        let mut values = log_amplitude(&spectrum)?;
        let mut real = vec![0.0; samples.len()];
        fft.inverse(&mut values, &mut real);
        real.truncate(samples.len() / 2 + 1);
        Ok(Cepstrum {
            step_s: 1.0 / rate_hz,
            real,
        })
    }

    /// Cepstrum of a one-sided power spectral density averaged over blocks of `samples` samples. Window and averages separate the lines of
    /// a family from the noise between them, which the logarithm of a single transform would raise to their height.
    ///
    /// # Errors
    /// Fewer than eight samples a block, a density that does not belong to them or is zero.
    pub fn from_psd(density: &[f64], samples: usize, rate_hz: f64) -> Result<Cepstrum, Error> {
        check_positive(rate_hz, "the sample rate, Hz,")?;
        if samples < 8 || density.len() != samples / 2 + 1 {
            let message = format!("{} lines of blocks of {samples} samples", density.len());
            return Err(Error::new(Code::TooShort, message).with_hint("take longer blocks"));
        }
        let replacement = density[DC_LINES];
        let amplitude = |(k, s): (usize, &f64)| {
            let density = if k < DC_LINES { replacement } else { *s };
            // The Nyquist line of an even number of samples is single; the other lines contain two sides.
            let factor = if 2 * k == samples { 1.0 } else { 0.5 };
            Complex::new((factor * density).sqrt(), 0.0)
        };
        let spectrum: Vec<Complex> = density.iter().enumerate().map(amplitude).collect();
        let mut values = log_amplitude(&spectrum)?;
        let mut real = vec![0.0; samples];
        RealFft::new(samples).inverse(&mut values, &mut real);
        real.truncate(samples / 2 + 1);
        Ok(Cepstrum {
            step_s: 1.0 / rate_hz,
            real,
        })
    }

    /// Noise level around a quefrency, neper: standard deviation by the median absolute value from half of it to twice it.
    pub fn noise_std(&self, quefrency_s: f64) -> f64 {
        /// Ratio of the median of |x| to the standard deviation of the normal distribution.
        const MEDIAN_TO_STD: f64 = 0.674_489_750_196_081_7;
        let index_at = |factor: f64| (factor * quefrency_s / self.step_s).round() as usize;
        let end = self.real.len();
        let range = &self.real[index_at(0.5).min(end)..(index_at(2.0) + 1).min(end)];
        let mut sizes: Vec<f64> = range.iter().map(|c| c.abs()).collect();
        let middle = sizes.len() / 2;
        match sizes.is_empty() {
            true => 0.0,
            false => *sizes.select_nth_unstable_by(middle, f64::total_cmp).1 / MEDIAN_TO_STD,
        }
    }

    /// Power cepstrum `|F⁻¹{ln |X|²}|² = 4c²`.
    pub fn power(&self) -> Vec<f64> {
        self.real.iter().map(|c| 4.0 * c * c).collect()
    }

    /// Quefrency axis, s.
    pub fn quefrency_s(&self) -> Vec<f64> {
        (0..self.real.len())
            .map(|j| j as f64 * self.step_s)
            .collect()
    }

    /// Highest peak between two quefrencies, s, with up to `number` of its multiples; `None` without a peak in the range.
    ///
    /// Each multiple is searched at the quefrency predicted by the last one. The uncertainty of the first quefrency is a sample over the
    /// number of multiples.
    pub fn rahmonics(&self, low_s: f64, high_s: f64, number: usize) -> Option<Rahmonics> {
        let c = &self.real;
        let peak = |start: usize, end: usize| {
            (start.max(1)..(end + 1).min(c.len().saturating_sub(1)))
                .filter(|&j| c[j] >= c[j - 1] && c[j] >= c[j + 1] && c[j] > 0.0)
                .max_by(|&a, &b| c[a].total_cmp(&c[b]))
        };
        let low = (low_s / self.step_s).ceil().max(1.0) as usize;
        let mut first = refined(c, peak(low, (high_s / self.step_s).floor() as usize)?);
        let mut height = vec![first.1];
        for k in 2..=number {
            let expected = first.0 * k as f64;
            let margin = 1.0; // samples: the last one is known to half a sample, scaled by k/(k − 1)
            let position = peak(
                (expected - margin).round() as usize,
                (expected + margin).round() as usize,
            );
            let Some(j) = position else { break };
            let (quefrency, peak_height) = refined(c, j);
            first.0 = quefrency / k as f64;
            height.push(peak_height);
        }
        Some(Rahmonics {
            quefrency_s: first.0 * self.step_s,
            height,
        })
    }
}

/// Liftered signal: the cepstrum of `samples` is multiplied by `gain(quefrency)`, s, with unchanged phases. A gain of zero except
/// at quefrency zero whitens the spectrum; a gain of zero at one family of rahmonics removes that family of lines.
///
/// # Errors
/// As [`Cepstrum::new`].
pub fn lifter(samples: &[f64], rate_hz: f64, gain: impl Fn(f64) -> f64) -> Result<Vec<f64>, Error> {
    check_positive(rate_hz, "the sample rate, Hz,")?;
    let n = samples.len();
    let (mut fft, spectrum) = transform(samples)?;
    let mut values = log_amplitude(&spectrum)?;
    let log_before: Vec<f64> = values.iter().map(|z| z.re).collect();
    let mut cepstrum = vec![0.0; n];
    fft.inverse(&mut values, &mut cepstrum);
    for (j, c) in cepstrum.iter_mut().enumerate() {
        *c *= gain(j.min(n - j) as f64 / rate_hz);
    }
    fft.forward(&mut cepstrum, &mut values);
    for ((z, x), log_before) in values.iter_mut().zip(&spectrum).zip(log_before) {
        *z = x * (z.re - log_before).exp();
    }
    let mut liftered = vec![0.0; n];
    fft.inverse(&mut values, &mut liftered);
    Ok(liftered)
}

fn transform(samples: &[f64]) -> Result<(RealFft, Vec<Complex>), Error> {
    check_samples(samples, 4)?;
    let mut fft = RealFft::new(samples.len());
    let mut spectrum = vec![Complex::new(0.0, 0.0); fft.lines()];
    fft.forward(&mut samples.to_vec(), &mut spectrum);
    Ok((fft, spectrum))
}

/// Log amplitude `ln |X|`, limited to the floor.
fn log_amplitude(spectrum: &[Complex]) -> Result<Vec<Complex>, Error> {
    let strongest = spectrum.iter().fold(0.0_f64, |s, z| s.max(z.norm_sqr()));
    if strongest == 0.0 {
        return Err(Error::new(
            Code::NoSignal,
            "the signal is zero throughout, and zero has no logarithm",
        ));
    }
    let log = |z: &Complex| 0.5 * z.norm_sqr().max(LOG_FLOOR * strongest).ln();
    Ok(spectrum.iter().map(|z| Complex::new(log(z), 0.0)).collect())
}

/// Vertex of the parabola through a peak and its neighbours: position, samples, and height.
fn refined(c: &[f64], j: usize) -> (f64, f64) {
    let (shift, height) = parabola::vertex([c[j - 1], c[j], c[j + 1]]);
    (j as f64 + shift, height)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// An impulse and its echo a at delay τ: ln|1 + a e^{−iωτ}| = Σ (−1)^{k+1} aᵏ/k cos kωτ, so c(kτ) = (−1)^{k+1} aᵏ/(2k).
    #[test]
    fn exact_echo() {
        let (n, delay, a) = (1024, 40, 0.5_f64);
        let mut x = vec![0.0; n];
        x[0] = 1.0;
        x[delay] = a;
        let cepstrum = Cepstrum::new(&x, 1000.0).unwrap();
        for k in 1..=10_i32 {
            let sign = if k % 2 == 1 { 1.0 } else { -1.0 };
            let expected = sign * a.powi(k) / (2.0 * f64::from(k));
            assert!((cepstrum.real[delay * k as usize] - expected).abs() < 1e-9);
            assert!(
                (cepstrum.power()[delay * k as usize] - 4.0 * expected * expected).abs() < 1e-9
            );
        }
        assert!(cepstrum.real[1..delay].iter().all(|c| c.abs() < 1e-9));
        // Without its rahmonics the signal has the flat spectrum of an impulse, with unchanged phases.
        let alone = lifter(&x, 1000.0, |q| f64::from(u8::from(q == 0.0))).unwrap();
        let energy: f64 = alone.iter().map(|v| v * v).sum();
        assert!((energy - 1.0).abs() < 1e-9, "{energy}");
    }

    /// Pulses every 50.25 samples: the rahmonics give the period.
    #[test]
    fn exact_rahmonics_of_a_family() {
        let (n, rate, spacing) = (8040, 1000.0, 160); // 160 periods of 50.25 samples
        let mut spectrum = vec![Complex::new(1e-3, 0.0); n / 2 + 1];
        (0..n / 2)
            .step_by(spacing)
            .for_each(|k| spectrum[k].re = 1.0);
        let mut x = vec![0.0; n];
        RealFft::new(n).inverse(&mut spectrum, &mut x);
        let cepstrum = Cepstrum::new(&x, rate).unwrap();
        let family = cepstrum.rahmonics(0.03, 0.07, 12).unwrap();
        assert_eq!(family.height.len(), 12);
        assert!((family.quefrency_s - 0.05025).abs() < 2e-5, "{family:?}");
        assert!(cepstrum.rahmonics(0.07, 0.03, 2).is_none());
    }

    /// A density of the shape `exp(2 a cos ωτ)` has the cepstrum a/2 at τ, whatever its value at 0 Hz.
    #[test]
    fn exact_cepstrum_of_a_density() {
        for n in [1024, 1025] {
            let wave = |k: usize| (TAU * (k * 40) as f64 / n as f64).cos();
            let mut density: Vec<f64> = (0..=n / 2).map(|k| 2.0 * (0.6 * wave(k)).exp()).collect();
            if n % 2 == 0 {
                density[n / 2] *= 0.5;
            }
            density[0] = 0.0;
            let found = Cepstrum::from_psd(&density, n, 1000.0).unwrap();
            assert!((found.real[40] - 0.15).abs() < 1e-3, "{}", found.real[40]);
            let others = (10..n / 2).filter(|j| *j != 40);
            assert!(others.map(|j| found.real[j].abs()).fold(0.0, f64::max) < 1e-3);
        }
        assert!(Cepstrum::from_psd(&[1.0; 4], 9, 1.0).is_err());
    }

    #[test]
    fn law_lifter_of_ones_changes_nothing() {
        let mut rng = fastrand::Rng::with_seed(2);
        let x: Vec<f64> = (0..501).map(|_| rng.f64() - 0.3).collect();
        let y = lifter(&x, 10.0, |_| 1.0).unwrap();
        assert!(x.iter().zip(&y).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn refuses_silence() {
        assert_eq!(
            Cepstrum::new(&[0.0; 9], 1.0).unwrap_err().code,
            Code::NoSignal
        );
        assert_eq!(
            Cepstrum::new(&[1.0; 3], 1.0).unwrap_err().code,
            Code::TooShort
        );
    }
}
