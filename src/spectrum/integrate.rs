//! Conversion between acceleration, velocity and displacement: `Y = g(ω) (iω)^p X`, g a high-pass.
//!
//! `g` is zero up to the low cut, one from twice the low cut on, and half a cosine between them; a softer edge shortens the end
//! effects. The slice is taken as one period of a periodic signal. If its ends differ by a jump `J`, the samples near them are in
//! error: measured on tones of any end phase, the error of a displacement from an acceleration is up to 0.03 `J/(2πf)²` at the ends
//! (`f` the low cut), 1e-3 `J/(2πf)²` one period of the low cut from them, 1e-4 two and 1e-5 four periods from them. The error
//! of a derivative is the jump itself over a few samples. Drift causes such a jump: remove it first.

use std::f64::consts::{PI, TAU};

use super::validation::{check_positive, check_samples};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;

/// Ratio of frequency to low cut from which the gain is one.
pub const PASS_RATIO: f64 = 2.0;

/// Motion quantity of a signal, or of a response to a force: receptance, mobility, accelerance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MotionQuantity {
    /// Displacement, m or rad.
    Displacement,
    /// Velocity, m/s or rad/s.
    Velocity,
    /// Acceleration, m/s² or rad/s².
    Acceleration,
}

impl MotionQuantity {
    /// Order n of the time derivative of a displacement, factor `(iω)ⁿ`.
    pub fn derivative_order(self) -> i32 {
        match self {
            MotionQuantity::Displacement => 0,
            MotionQuantity::Velocity => 1,
            MotionQuantity::Acceleration => 2,
        }
    }
}

/// Conversion from one motion quantity to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionConversion {
    /// Motion quantity of the samples.
    pub from: MotionQuantity,
    /// Motion quantity to convert to.
    pub to: MotionQuantity,
    /// Low cut, Hz: content up to it is removed, content from twice the low cut on is unchanged. Zero removes the mean alone and is
    /// valid only without integration.
    pub low_cut_hz: f64,
}

/// Converts samples to another motion quantity, in their unit times or divided by powers of s.
///
/// # Errors
/// Fewer than two samples, non-finite samples, a low cut of a quarter of the rate or more, integration without a low cut.
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
            format!("the low cut of integration is {cut} Hz; it must be above zero and below a quarter of the rate of {rate_hz} Hz"),
        )
        .with_hint("use half the lowest frequency of interest; below it, integration mainly amplifies sensor drift"));
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

/// `(iω)^p`; zero at ω = 0, which the high-pass removes.
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

    const QUANTITIES: [MotionQuantity; 3] = [
        MotionQuantity::Displacement,
        MotionQuantity::Velocity,
        MotionQuantity::Acceleration,
    ];

    /// The p-th derivative of cos ωt.
    fn wave(omega: f64, t: f64, quantity: MotionQuantity) -> f64 {
        let p = quantity.derivative_order();
        omega.powi(p) * (omega * t + f64::from(p) * PI / 2.0).cos()
    }

    /// A periodic tone plus a constant is converted exactly in all nine cases, to the rounding of the tone's angle (1e-13) times the gain of
    /// two derivatives at half the rate (200).
    #[test]
    fn exact_tone() {
        let (n, rate, omega) = (2000, 1000.0, TAU * 35.0);
        for from in QUANTITIES {
            for to in QUANTITIES {
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

    /// Errors near the ends stated in the module documentation, for tones of any end phase.
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
            for (worst, distance) in worst.iter_mut().zip([0, 1000, 2000, 4000]) {
                let error = |j: usize| (y[j] + x[j] / (omega * omega)).abs() / unit;
                *worst = (distance..n - distance).map(error).fold(*worst, f64::max);
            }
        }
        let limits = [3e-2, 1e-3, 1e-4, 1e-5];
        assert!(worst.iter().zip(limits).all(|(w, s)| *w < s), "{worst:?}");
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
