//! Envelope `|z(t)|` of a band and the spectrum of its square.
//!
//! R. B. Randall, J. Antoni, Rolling element bearing diagnostics – a tutorial, Mech. Syst. Signal Process. 25 (2011), 485–520:
//! the square of the envelope, since it has no lines beyond the width of the band and therefore no aliases.

use super::band::{FrequencyBand, analytic_signal, baseband};
use super::validation::mean;
use super::window::Window;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;

/// Lines of a squared envelope.
#[derive(Debug, Clone)]
pub struct EnvelopeSpectrum {
    /// Mean of the squared envelope: twice the mean square of the signal in the band, unit².
    pub mean: f64,
    /// Lines, Hz, from zero to the width of the band.
    pub frequency_hz: Vec<f64>,
    /// Amplitude (zero to peak) of each line of the squared envelope, unit²; with Hann's window, the mean taken off first, so that a
    /// line between two of the spectrum's shows up to 15 % low.
    pub amplitude: Vec<f64>,
}

/// `|x + i H{x}|` at the rate of the samples, of the band alone where one is given. The ends are doubtful over a few times the
/// inverse of the band's width, since the slice is taken as periodic.
///
/// # Errors
/// Fewer than two samples, samples that are not finite, a band that holds no line.
pub fn envelope(
    samples: &[f64],
    rate_hz: f64,
    band: Option<FrequencyBand>,
) -> Result<Vec<f64>, Error> {
    let values = analytic_signal(samples, rate_hz, band)?;
    Ok(values.iter().map(|z| z.norm()).collect())
}

/// The lines of the squared envelope of a band.
///
/// # Errors
/// As [`envelope`].
pub fn squared_envelope_spectrum(
    samples: &[f64],
    rate_hz: f64,
    band: FrequencyBand,
) -> Result<EnvelopeSpectrum, Error> {
    let base = baseband(samples, rate_hz, band)?;
    let mut square: Vec<f64> = base.values.iter().map(|z| z.norm_sqr()).collect();
    let n = square.len();
    let mean = mean(&square);
    let weights = Window::Hann.samples(n);
    square
        .iter_mut()
        .zip(&weights)
        .for_each(|(x, w)| *x = (*x - mean) * w);
    let mut fft = RealFft::new(n);
    let mut spectrum = vec![Complex::new(0.0, 0.0); fft.lines()];
    fft.forward(&mut square, &mut spectrum);
    let scale = 2.0 / weights.iter().sum::<f64>();
    let step = base.rate_hz / n as f64;
    Ok(EnvelopeSpectrum {
        mean,
        frequency_hz: (0..spectrum.len()).map(|k| k as f64 * step).collect(),
        amplitude: spectrum.iter().map(|z| scale * z.norm()).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::code::Code;
    use std::f64::consts::TAU;

    /// (1 + m cos Ωt) cos ωt: envelope 1 + m cos Ωt, its square 1 + m²/2 + 2m cos Ωt + m²/2 cos 2Ωt; a strong tone outside the
    /// band leaves no trace.
    #[test]
    fn exact_modulated_carrier() {
        let (n, rate, m) = (1000, 1000.0, 0.4);
        let modulation = |j: usize| 1.0 + m * (TAU * 7.0 * j as f64 / rate).cos();
        let x: Vec<f64> = (0..n)
            .map(|j| {
                let t = j as f64 / rate;
                modulation(j) * (TAU * 200.0 * t + 0.3).cos() + 5.0 * (TAU * 50.0 * t).sin()
            })
            .collect();
        let band = FrequencyBand {
            low_hz: 150.0,
            high_hz: 250.0,
        };
        let e = envelope(&x, rate, Some(band)).unwrap();
        assert!((0..n).all(|j| (e[j] - modulation(j)).abs() < 1e-12));
        let lines = squared_envelope_spectrum(&x, rate, band).unwrap();
        assert!((lines.mean - (1.0 + m * m / 2.0)).abs() < 1e-12);
        let at = |f: f64| {
            lines
                .frequency_hz
                .iter()
                .position(|&g| (g - f).abs() < 1e-9)
                .unwrap()
        };
        assert!((lines.amplitude[at(7.0)] - 2.0 * m).abs() < 1e-12);
        assert!((lines.amplitude[at(14.0)] - m * m / 2.0).abs() < 1e-12);
        assert!(lines.amplitude[at(20.0)..].iter().all(|a| *a < 1e-12));
    }

    #[test]
    fn refuses_no_band_and_no_number() {
        let x = [1.0, -1.0, 1.0, -1.0];
        let band = |low_hz, high_hz| Some(FrequencyBand { low_hz, high_hz });
        assert_eq!(
            envelope(&x, 10.0, band(3.0, 1.0)).unwrap_err().code,
            Code::OutOfRange
        );
        assert_eq!(
            envelope(&x, 10.0, band(1.0, 1.1)).unwrap_err().code,
            Code::TooShort
        );
        assert_eq!(envelope(&x, 0.0, None).unwrap_err().code, Code::OutOfRange);
        assert_eq!(
            envelope(&[1.0, f64::NAN], 10.0, None).unwrap_err().code,
            Code::NotANumber
        );
        assert_eq!(envelope(&[], 10.0, None).unwrap_err().code, Code::TooShort);
    }
}
