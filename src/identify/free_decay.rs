//! Modes of free decays by maximum likelihood.
//!
//! On its own lines `z_k = exp(2πik/N)` the transform of N samples of damped sinusoids is
//! `Y(z_k) = Σ_r A_r (1 − λ_r^N)/(1 − λ_r/z_k)`, `λ_r = exp(p_r Δt)`: rational without leakage, whether they have decayed or not. With
//! Tustin's `s = (2/Δt)(z − 1)/(z + 1)` every term is one pole `(2/Δt) tanh(p_r Δt/2)` and a constant, the model of frequency
//! responses. White noise of the samples is independent noise on the lines. Initial conditions are arbitrary; several decays of one
//! structure have their poles in common, as in the eigensystem realization algorithm (Juang & Pappa, J. Guidance 8 (1985)).

use std::f64::consts::PI;

use super::modal_parameters::ModalParameters;
use super::rational::{self, FrfData, RationalFit, RationalOptions};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;

/// Top of the lines used over the rate: filters of loggers end there.
pub const TOP: f64 = 0.4;

/// Fits common poles to `decays[d][c]`, decay d in channel c, all of one length; shapes are over channels, then decays.
///
/// # Errors
/// `Conflict` for unequal lengths; those of [`rational::fit`].
pub fn fit(
    rate_hz: f64,
    decays: &[Vec<&[f64]>],
    options: &RationalOptions,
) -> Result<RationalFit, Error> {
    let length = decays
        .first()
        .and_then(|d| d.first())
        .map_or(0, |y| y.len());
    if decays.iter().flatten().any(|y| y.len() != length) || length < 2 {
        let message = "free decays are fitted over one number of samples, two or more";
        return Err(Error::new(Code::Conflict, message).with_hint("cut them to the shortest"));
    }
    let mut fft = RealFft::new(length);
    let lines = ((TOP * length as f64).floor() as usize).min(fft.lines() - 1);
    let frequency_hz: Vec<f64> = (1..=lines)
        .map(|k| warped(k as f64 * rate_hz / length as f64, rate_hz))
        .collect();
    let channels = decays.first().map_or(0, Vec::len);
    let mut responses = Vec::new();
    let mut spectrum = vec![Complex::ZERO; fft.lines()];
    for c in 0..channels {
        for decay in decays {
            let mut samples = decay[c].to_vec();
            fft.forward(&mut samples, &mut spectrum);
            responses.push(spectrum[1..=lines].iter().map(|z| z / rate_hz).collect());
        }
    }
    let measured = FrfData {
        frequency_hz: &frequency_hz,
        responses: &responses,
        variance: None,
        variance_dof: None,
        smearing_hz: 0.0,
        line_independence: 1.0,
        derivative: 0,
        hits: None,
    };
    let top = TOP * rate_hz;
    let options = RationalOptions {
        band_hz: (options.band_hz).map(|(low, high)| {
            (
                warped(low.min(top), rate_hz),
                warped(high.min(top), rate_hz),
            )
        }),
        ..*options
    };
    Ok(unwarped(rational::fit(&measured, &options)?, rate_hz))
}

/// A frequency on the axis of Tustin's s, Hz.
fn warped(frequency_hz: f64, rate_hz: f64) -> f64 {
    rate_hz / PI * (PI * frequency_hz / rate_hz).tan()
}

/// The pole in s of one in Tustin's s, and its derivative: `p = (2/Δt) artanh(qΔt/2)`.
fn pole(warped: Complex, rate_hz: f64) -> (Complex, Complex) {
    let half = warped / (2.0 * rate_hz);
    let one = Complex::new(1.0, 0.0);
    let pole = ((one + half) / (one - half)).ln() * rate_hz;
    (pole, one / (one - half * half))
}

fn unwarped(mut fit: RationalFit, rate_hz: f64) -> RationalFit {
    for (k, mode) in fit.modes.iter_mut().enumerate() {
        let (own, slope) = pole(mode.pole, rate_hz);
        if let Some(departure) = fit.departures.get_mut(k) {
            departure.frequency_spread_hz *= slope.norm();
        }
        *mode = ModalParameters {
            pole: own,
            pole_covariance: mode.pole_covariance.map(|c| turned(c, slope)),
            shape: std::mem::take(&mut mode.shape),
        };
    }
    for one in &mut fit.poles {
        *one = pole(*one, rate_hz).0;
    }
    for one in &mut fit.omitted {
        one.pole = pole(one.pole, rate_hz).0;
    }
    fit
}

/// Covariance of real and imaginary part under `δp = g δq`.
fn turned([rr, ii, ri]: [f64; 3], g: Complex) -> [f64; 3] {
    let (a, b) = (g.re, g.im);
    [
        a * a * rr + b * b * ii - 2.0 * a * b * ri,
        b * b * rr + a * a * ii + 2.0 * a * b * ri,
        a * b * (rr - ii) + (a * a - b * b) * ri,
    ]
}
