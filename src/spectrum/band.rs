//! Band-pass, analytic signal and zoom by one transform of a record: `z(t) = Σ 2 X_k/n e^{2πi f_k t}`.
//!
//! The analytic signal after D. Gabor, Theory of communication, J. IEE 93 (1946), 429–457; by discrete transforms after
//! S. L. Marple, IEEE Trans. Signal Processing 47 (1999), 2600–2603. The edges of the band are sharp and the slice is taken as one period of a
//! periodic signal: a jump between its ends rings near both, over a few times `1/(high − low)`.

use super::validation::{check_positive, check_samples};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::{ComplexFft, RealFft, next_fast_len};

/// A band of frequencies, Hz.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrequencyBand {
    /// Lower edge, kept.
    pub low_hz: f64,
    /// Upper edge, kept.
    pub high_hz: f64,
}

/// A band moved down to zero frequency: the signal is `Re z e^{2πi f₀ t}`.
#[derive(Debug, Clone)]
pub struct BasebandSignal {
    /// Frequency that became zero, `f₀`, Hz.
    pub origin_hz: f64,
    /// Samples a second of `values`, Hz.
    pub rate_hz: f64,
    /// The complex envelope, from the first sample's time on.
    pub values: Vec<Complex>,
}

/// The lines of the analytic signal from `first` on: twice those of the signal, the first (zero) and last (half the rate) once.
struct AnalyticSpectrum {
    first: usize,
    values: Vec<Complex>,
}

fn analytic_spectrum(
    samples: &[f64],
    rate_hz: f64,
    band: Option<FrequencyBand>,
) -> Result<AnalyticSpectrum, Error> {
    check_samples(samples, 2)?;
    check_positive(rate_hz, "the sample rate, Hz,")?;
    let n = samples.len();
    let mut fft = RealFft::new(n);
    let mut spectrum = vec![Complex::new(0.0, 0.0); fft.lines()];
    fft.forward(&mut samples.to_vec(), &mut spectrum);
    let scale = 1.0 / n as f64;
    for (k, z) in spectrum.iter_mut().enumerate() {
        *z *= if k == 0 || 2 * k == n {
            scale
        } else {
            2.0 * scale
        };
    }
    let Some(FrequencyBand { low_hz, high_hz }) = band else {
        return Ok(AnalyticSpectrum {
            first: 0,
            values: spectrum,
        });
    };
    let step = rate_hz / n as f64;
    if !(low_hz >= 0.0 && low_hz < high_hz && low_hz < rate_hz / 2.0) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("the band from {low_hz} to {high_hz} Hz is invalid for a signal sampled at {rate_hz} Hz"),
        )
        .with_hint("choose both edges between 0 and half the rate, the lower one first"));
    }
    let first = (low_hz / step).ceil() as usize;
    let last = ((high_hz / step).floor() as usize).min(spectrum.len() - 1);
    if last < first {
        return Err(Error::new(
            Code::TooShort,
            format!("no line of a spectrum with {step} Hz between lines falls into {low_hz} to {high_hz} Hz"),
        )
        .with_hint("a wider band, or a longer record"));
    }
    Ok(AnalyticSpectrum {
        first,
        values: spectrum[first..=last].to_vec(),
    })
}

/// The analytic signal `x + i H{x}` at the rate of the samples, of the band alone where one is given.
///
/// # Errors
/// Fewer than two samples, samples that are not finite, a band that holds no line.
pub fn analytic_signal(
    samples: &[f64],
    rate_hz: f64,
    band: Option<FrequencyBand>,
) -> Result<Vec<Complex>, Error> {
    let lines = analytic_spectrum(samples, rate_hz, band)?;
    let n = samples.len();
    let mut values = vec![Complex::new(0.0, 0.0); n];
    values[lines.first..lines.first + lines.values.len()].copy_from_slice(&lines.values);
    synthesise(&mut values);
    Ok(values)
}

/// The signal without anything outside the band.
///
/// # Errors
/// As [`analytic_signal`].
pub fn band_pass(samples: &[f64], rate_hz: f64, band: FrequencyBand) -> Result<Vec<f64>, Error> {
    let values = analytic_signal(samples, rate_hz, Some(band))?;
    Ok(values.iter().map(|z| z.re).collect())
}

/// The band alone, at the lowest rate (a little above twice its width) at which also the square of its envelope has no aliases.
///
/// # Errors
/// As [`analytic_signal`].
pub fn baseband(
    samples: &[f64],
    rate_hz: f64,
    band: FrequencyBand,
) -> Result<BasebandSignal, Error> {
    let lines = analytic_spectrum(samples, rate_hz, Some(band))?;
    let n = samples.len() as f64;
    let m = next_fast_len(2 * lines.values.len());
    let mut values = lines.values;
    values.resize(m, Complex::new(0.0, 0.0));
    synthesise(&mut values);
    Ok(BasebandSignal {
        origin_hz: lines.first as f64 * rate_hz / n,
        rate_hz: rate_hz * m as f64 / n,
        values,
    })
}

/// `Σ_k z_k e^{2πi jk/n}`.
fn synthesise(values: &mut [Complex]) {
    let n = values.len();
    ComplexFft::new(n).inverse(values);
    values.iter_mut().for_each(|z| *z *= n as f64);
}
