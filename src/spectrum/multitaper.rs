//! Multitaper spectra with K sine tapers: `S = 2/f_s · mean_k |Σ_j h_k(j) x_j e^{−iωj}|²`.
//!
//! Thomson, Spectrum estimation and harmonic analysis, Proc. IEEE 70 (1982), pp. 1055–1096, with the sine tapers
//! `h_k(j) = √(2/(n+1)) sin(πkj/(n+1))` of Riedel & Sidorenko, Minimum bias multiple taper spectral estimation, IEEE Trans. Signal
//! Process. 43 (1995), pp. 188–195, equally weighted. Their bandwidth is `±(K+1)/2` lines of `f_s/(n+1)`. A sine is two exponentials: each
//! tapered transform is the difference of two lines of one transform of twice the length, common to all tapers.

use std::f64::consts::PI;

use super::spectra::{CrossSpectrum, Spectra, mean};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::fft::RealFft;
use crate::numeric::{Complex, parallel};

/// Spectra of a record without gaps, means removed: auto spectra of all channels, cross spectra of `pairs`, line spacing `rate/(n+1)`.
///
/// Each density has 2K degrees of freedom; more tapers reduce the random error and the frequency resolution.
///
/// # Errors
/// `TooShort`: fewer than four samples for each taper. `OutOfRange`: no taper, or an invalid rate. `Overflow`: a sample that is not finite.
///
/// # Panics
/// If channels differ in length.
pub fn multitaper(
    rate_hz: f64,
    channels: &[&[f64]],
    pairs: &[(usize, usize)],
    tapers: usize,
) -> Result<Spectra, Error> {
    let n = channels.first().map_or(0, |c| c.len());
    assert!(channels.iter().all(|c| c.len() == n));
    if tapers == 0 || !(rate_hz > 0.0 && rate_hz.is_finite()) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("invalid number of tapers {tapers} or sample rate {rate_hz} Hz"),
        ));
    }
    if n / 4 < tapers {
        return Err(Error::new(
            Code::TooShort,
            format!("{n} samples are too few for {tapers} tapers"),
        )
        .with_hint(format!(
            "use at most {} tapers, or a longer record",
            (n / 4).max(1)
        )));
    }
    let fft = RealFft::new(2 * (n + 1));
    let transforms = parallel::try_map(channels, |channel| transform(channel, &mut fft.clone()))?;
    let size = n + 1;
    let lines = size / 2 + 1;
    let scale = 2.0 / (rate_hz * 2.0 * size as f64 * tapers as f64);
    let mean = |x: &[Complex], y: &[Complex], line: usize| {
        let tapered = |z: &[Complex], k: usize| {
            let m = 2 * line as isize;
            line_value(z, m - k as isize) - line_value(z, m + k as isize)
        };
        let sum: Complex = (1..=tapers)
            .map(|k| tapered(x, k).conj() * tapered(y, k))
            .sum();
        let is_edge = line == 0 || 2 * line == size;
        sum * if is_edge { 0.5 * scale } else { scale }
    };
    let psd = |x: &Vec<Complex>| (0..lines).map(|line| mean(x, x, line).re).collect();
    let cross = |&pair: &(usize, usize)| CrossSpectrum {
        pair,
        values: (0..lines)
            .map(|line| mean(&transforms[pair.0], &transforms[pair.1], line))
            .collect(),
    };
    Ok(Spectra {
        rate_hz,
        frequency_hz: (0..lines)
            .map(|k| rate_hz * (k as f64 / size as f64))
            .collect(),
        psd: parallel::map(&transforms, psd),
        cross: pairs.iter().map(cross).collect(),
        bandwidth_hz: rate_hz / mean_square_sum(size, tapers),
        blocks: tapers,
        averages: Some(tapers as f64),
        window_decay: 0.0,
        window: None,
    })
}

/// `Σ_j x_j exp(−2πi mj/2(n+1))`, `j = 1 … n`, `m = 0 … n+1`, after removal of the mean of x.
pub(super) fn transform(channel: &[f64], fft: &mut RealFft) -> Result<Vec<Complex>, Error> {
    let mean = mean(channel)?;
    let mut samples = vec![0.0; fft.samples()];
    for (z, x) in samples[1..].iter_mut().zip(channel) {
        *z = x - mean;
    }
    let mut spectrum = vec![Complex::new(0.0, 0.0); fft.lines()];
    fft.forward(&mut samples, &mut spectrum);
    Ok(spectrum)
}

/// Line `m` of the transform of a real signal, also below 0 and above half the length.
pub(super) fn line_value(z: &[Complex], m: isize) -> Complex {
    let last = z.len() as isize - 1;
    if m < 0 {
        z[-m as usize].conj()
    } else if m > last {
        z[(2 * last - m) as usize].conj()
    } else {
        z[m as usize]
    }
}

/// Mean over tapers of `(Σ_j h_k(j))²`: `2/(n+1) cot²(πk/2(n+1))` for odd k, 0 for even ones.
fn mean_square_sum(size: usize, tapers: usize) -> f64 {
    let square = |k: usize| {
        let tangent = (PI * k as f64 / (2 * size) as f64).tan();
        2.0 / (size as f64 * tangent * tangent)
    };
    (1..=tapers).step_by(2).map(square).sum::<f64>() / tapers as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Spectra agree with direct sums over the tapered samples, for even and odd lengths.
    #[test]
    fn exact_against_direct_sums() {
        for n in [40, 41] {
            let x: Vec<f64> = (0..n).map(|j| f64::from(j * j % 17) - 3.0).collect();
            let mean = x.iter().sum::<f64>() / f64::from(n);
            let spectra = multitaper(10.0, &[&x], &[(0, 0)], 3).unwrap();
            let size = f64::from(n + 1);
            assert_eq!(spectra.frequency_hz.len(), (n as usize).div_ceil(2) + 1);
            for (line, &f) in spectra.frequency_hz.iter().enumerate() {
                let tapered = |k: i32| -> Complex {
                    let term = |j: i32| {
                        let h = (2.0 / size).sqrt() * (PI * f64::from(k * (j + 1)) / size).sin();
                        let (s, c) = (2.0 * PI * f / 10.0 * f64::from(j)).sin_cos();
                        Complex::new(c, -s) * h * (x[j as usize] - mean)
                    };
                    (0..n).map(term).sum()
                };
                let power = (1..=3).map(|k| tapered(k).norm_sqr()).sum::<f64>() / 3.0;
                let factor = if spectra.is_real_line(line) { 1.0 } else { 2.0 };
                let exact = factor * power / 10.0;
                assert!((spectra.psd[0][line] - exact).abs() < 1e-12, "{n} {line}");
                assert!((spectra.cross[0].values[line].re - exact).abs() < 1e-12);
            }
        }
    }

    /// White noise has the exact mean density and the variance of χ² with 2K degrees of freedom; a tone has its amplitude.
    #[test]
    fn law_white_noise_and_tone() {
        let mut rng = fastrand::Rng::with_seed(5);
        let x: Vec<f64> = (0..4096).map(|_| rng.f64() - 0.5).collect();
        let spectra = multitaper(2.0, &[&x], &[], 8).unwrap();
        let inner = &spectra.psd[0][10..2000];
        let mean = inner.iter().sum::<f64>() / inner.len() as f64;
        let square = |s: &f64| (s - mean).powi(2);
        let spread = inner.iter().map(square).sum::<f64>() / inner.len() as f64;
        assert!((mean * 12.0 - 1.0).abs() < 0.05, "{mean}");
        assert!((spread / (mean * mean) * 8.0 - 1.0).abs() < 0.2, "{spread}");
        let tone: Vec<f64> = (0..999)
            .map(|j| 3.0 * (2.0 * PI * f64::from(j) * 0.1).cos())
            .collect();
        let spectra = multitaper(1.0, &[&tone], &[], 5).unwrap();
        assert!((spectra.amplitude(0)[100] - 3.0).abs() < 1e-3);
    }

    #[test]
    fn refuses_and_survives() {
        let code = |n: usize, k: usize| multitaper(1.0, &[&vec![1.0; n]], &[], k).unwrap_err().code;
        assert_eq!(code(10, 3), Code::TooShort);
        assert_eq!(code(10, 0), Code::OutOfRange);
        assert_eq!(code(0, 1), Code::TooShort);
        let gapped = multitaper(1.0, &[&[1.0, f64::NAN, 2.0, 3.0]], &[], 1);
        assert_eq!(gapped.unwrap_err().code, Code::Overflow);
    }
}
