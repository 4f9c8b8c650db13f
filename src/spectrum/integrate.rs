//! Conversion between acceleration, velocity and displacement: `Y = g(ω) (iω)^p X`, g a high-pass.
//!
//! `g` is zero up to the low cut, one from twice the low cut on, and half a cosine between them: the softer the edge, the sooner
//! what the ends spoil dies away. The slice is taken as one period of a periodic signal. Where its ends do not meet, a
//! jump `J` between them spoils what is near: measured on tones that end anywhere, the displacement of an acceleration is wrong by up to
//! 0.03 `J/(2πf)²` at the ends (`f` the low cut), 1e-3 of that unit one period of the low cut away from them, 1e-4 two and 1e-5
//! four periods away; a derivative is wrong by the jump itself over a few samples. Drift has such a jump: take it off first.

use std::f64::consts::{PI, TAU};

use super::validation::{check_positive, check_samples};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;

/// Ratio of frequency to the low cut from which signals pass undiminished.
pub const PASS_RATIO: f64 = 2.0;

/// Motion quantity of a signal, or of a response to a force: receptance, mobility, accelerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionQuantity {
    /// Metres or radians.
    Displacement,
    /// A second's change of them.
    Velocity,
    /// A second's change of that.
    Acceleration,
}

impl MotionQuantity {
    /// n of the factor `(iω)ⁿ` that makes it of a displacement.
    pub fn derivative_order(self) -> i32 {
        match self {
            MotionQuantity::Displacement => 0,
            MotionQuantity::Velocity => 1,
            MotionQuantity::Acceleration => 2,
        }
    }
}

/// One motion from another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionConversion {
    /// Motion quantity of the samples.
    pub from: MotionQuantity,
    /// Motion quantity to convert to.
    pub to: MotionQuantity,
    /// Nothing up to this frequency is kept, Hz; what has twice of it or more is kept whole. Zero takes off the mean alone, and only
    /// where nothing is integrated.
    pub low_cut_hz: f64,
}

/// The motion wanted, in the unit of the samples times s or over s.
///
/// # Errors
/// Fewer than two samples, samples not finite, a low cut that leaves nothing, integration without a low cut.
pub fn convert(
    samples: &[f64],
    rate_hz: f64,
    conversion: MotionConversion,
) -> Result<Vec<f64>, Error> {
    check_samples(samples, 2)?;
    check_positive(rate_hz, "the sample rate, Hz,")?;
    let cut = conversion.low_cut_hz;
    let power = conversion.to.derivative_order() - conversion.from.derivative_order();
    if !(cut >= 0.0 && PASS_RATIO * cut < rate_hz / 2.0) || (cut == 0.0 && power < 0) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("a low cut of {cut} Hz, where integration needs one above zero and below a quarter of the rate of {rate_hz} Hz"),
        )
        .with_hint("half the lowest frequency of interest; content below is mainly sensor drift, which integration magnifies"));
    }
    let n = samples.len();
    let mut fft = RealFft::new(n);
    let mut values = vec![Complex::new(0.0, 0.0); fft.lines()];
    let mut out = samples.to_vec();
    fft.forward(&mut out, &mut values);
    for (k, z) in values.iter_mut().enumerate() {
        let frequency = rate_hz * k as f64 / n as f64;
        *z *= high_pass_gain(frequency, cut) * power_of_iomega(TAU * frequency, power);
    }
    fft.inverse(&mut values, &mut out);
    Ok(out)
}

/// `(iω)^p`; at zero only where nothing is divided.
fn power_of_iomega(omega: f64, power: i32) -> Complex {
    match power {
        _ if omega == 0.0 => Complex::new(0.0, 0.0),
        0 => Complex::new(1.0, 0.0),
        1 | -1 => Complex::new(0.0, f64::from(power) * omega.powi(power)),
        _ => Complex::new(-omega.powi(power), 0.0),
    }
}

fn high_pass_gain(frequency: f64, cut: f64) -> f64 {
    if frequency <= cut {
        0.0
    } else if frequency >= PASS_RATIO * cut {
        1.0
    } else {
        0.5 - 0.5 * (PI * (frequency - cut) / ((PASS_RATIO - 1.0) * cut)).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [MotionQuantity; 3] = [
        MotionQuantity::Displacement,
        MotionQuantity::Velocity,
        MotionQuantity::Acceleration,
    ];

    /// The p-th derivative of cos ωt.
    fn wave(omega: f64, t: f64, history: MotionQuantity) -> f64 {
        let p = history.derivative_order();
        omega.powi(p) * (omega * t + f64::from(p) * PI / 2.0).cos()
    }

    /// A tone that fits the slice, on a constant: exact in all nine conversions, to the rounding of the tone's own angle (1e-13) times what two
    /// derivatives magnify it by at half the rate (200).
    #[test]
    fn exact_tone() {
        let (n, rate, omega) = (2000, 1000.0, TAU * 35.0);
        for from in ALL {
            for to in ALL {
                let t = |j: usize| j as f64 / rate;
                let x: Vec<f64> = (0..n).map(|j| wave(omega, t(j), from) + 3.0).collect();
                let conversion = MotionConversion {
                    from,
                    to,
                    low_cut_hz: 10.0,
                };
                let y = convert(&x, rate, conversion).unwrap();
                let size = omega.powi(to.derivative_order());
                assert!((0..n).all(|j| (y[j] - wave(omega, t(j), to)).abs() < 1e-10 * size));
            }
        }
    }

    /// The errors near the ends that the top of this file states, for tones that end anywhere.
    #[test]
    fn law_ends() {
        let (n, rate, cut) = (20_000, 1000.0, 1.0);
        let mut rng = fastrand::Rng::with_seed(3);
        let mut worst = [0.0_f64; 4];
        for _ in 0..30 {
            let omega = TAU * (2.0 + 40.0 * rng.f64());
            let phase = TAU * rng.f64();
            let x: Vec<f64> = (0..n)
                .map(|j| (omega * j as f64 / rate + phase).cos())
                .collect();
            let conversion = MotionConversion {
                from: MotionQuantity::Acceleration,
                to: MotionQuantity::Displacement,
                low_cut_hz: cut,
            };
            let y = convert(&x, rate, conversion).unwrap();
            let unit = 2.0 / (TAU * cut).powi(2); // a jump of at most two
            for (worst, away) in worst.iter_mut().zip([0, 1000, 2000, 4000]) {
                let wrong = |j: usize| (y[j] + x[j] / (omega * omega)).abs() / unit;
                *worst = (away..n - away).map(wrong).fold(*worst, f64::max);
            }
        }
        let stated = [3e-2, 1e-3, 1e-4, 1e-5];
        assert!(worst.iter().zip(stated).all(|(w, s)| *w < s), "{worst:?}");
    }

    #[test]
    fn refuses_integration_without_a_cut() {
        let x = [0.0, 1.0, 0.0, -1.0];
        let conversion = |low_cut_hz| MotionConversion {
            from: MotionQuantity::Acceleration,
            to: MotionQuantity::Velocity,
            low_cut_hz,
        };
        assert_eq!(
            convert(&x, 4.0, conversion(0.0)).unwrap_err().code,
            Code::OutOfRange
        );
        assert_eq!(
            convert(&x, 4.0, conversion(2.0)).unwrap_err().code,
            Code::OutOfRange
        );
        assert_eq!(
            convert(&x[..1], 4.0, conversion(0.1)).unwrap_err().code,
            Code::TooShort
        );
    }
}
