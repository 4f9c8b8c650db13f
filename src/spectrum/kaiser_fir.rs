//! Linear-phase low-pass FIR design by the Kaiser window: `h_j = 2f_c sinc(2f_c j) w(j/m)`.
//!
//! J. F. Kaiser, Nonrecursive digital filter design using the I₀-sinh window function, IEEE Int. Symp. Circuits and Systems (1974),
//! 20–23: the empirical formulas for the window's shape and for its length. Pass-band ripple and stop-band attenuation of such a
//! filter are the same number: −80 dB in the stop band is a ripple of 10⁻⁴ (0.0009 dB) in the pass band.

use std::f64::consts::PI;

use super::validation::check_positive;
use super::window::bessel_i0;
use crate::base::code::Code;
use crate::base::error::Error;

/// Kaiser's formulas hold within a few decibels (short filters least); designs begin this much deeper, dB, and grow until the bands are met.
const DESIGN_MARGIN_DB: f64 = 1.5;

/// Kaiser's formulas begin here, dB.
const MIN_ATTENUATION_DB: f64 = 21.0;

/// Shape β of Kaiser's window for an attenuation in dB.
pub fn kaiser_beta(attenuation_db: f64) -> f64 {
    if attenuation_db > 50.0 {
        0.1102 * (attenuation_db - 8.7)
    } else if attenuation_db > MIN_ATTENUATION_DB {
        0.5842 * (attenuation_db - 21.0).powf(0.4) + 0.07886 * (attenuation_db - 21.0)
    } else {
        0.0
    }
}

/// Kaiser's window at `−1 ≤ x ≤ 1`, 1 in the middle.
pub fn kaiser(x: f64, beta: f64) -> f64 {
    bessel_i0(beta * ((1.0 - x) * (1.0 + x)).max(0.0).sqrt()) / bessel_i0(beta)
}

/// `sin(πx)/(πx)`.
pub fn sinc(x: f64) -> f64 {
    if x == 0.0 {
        return 1.0;
    }
    (PI * x).sin() / (PI * x)
}

/// A low-pass filter: an odd number of weights, symmetric about the middle, their sum one.
///
/// `pass` and `stop` are the edges of the bands over the sample rate, `0 < pass < stop ≤ ½`.
///
/// # Errors
/// Edges that are no bands, an attenuation below 21 dB.
pub fn low_pass(pass: f64, stop: f64, attenuation_db: f64) -> Result<Vec<f64>, Error> {
    check_positive(pass, "the edge of the pass band over the rate")?;
    if !(pass < stop && stop <= 0.5) {
        return Err(Error::new(
            Code::OutOfRange,
            format!(
                "the stop band begins at {stop} of the rate; it must be above the pass-band edge {pass} and at most 0.5"
            ),
        ));
    }
    if !(MIN_ATTENUATION_DB..=200.0).contains(&attenuation_db) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("a stop band of {attenuation_db} dB; the range is 21 to 200 dB"),
        ));
    }
    let depth = attenuation_db + DESIGN_MARGIN_DB;
    let beta = kaiser_beta(depth);
    let least = ((depth - 7.95) / (2.285 * 2.0 * PI * (stop - pass)) / 2.0).ceil() as i64;
    let cut = pass + stop; // twice the middle of the transition, over the rate
    let ripple = 10.0_f64.powf(-attenuation_db / 20.0);
    let mut half = least;
    loop {
        let weight = |j: i64| sinc(cut * j as f64) * kaiser(j as f64 / (half as f64 + 1.0), beta);
        let mut weights: Vec<f64> = (-half..=half).map(weight).collect();
        let sum: f64 = weights.iter().sum();
        weights.iter_mut().for_each(|w| *w /= sum);
        if meets_ripple(&weights, pass, stop, ripple) || half >= 2 * least {
            return Ok(weights);
        }
        half += 1;
    }
}

/// Whether the bands keep their ripple: looked at where it is largest, in the pass band and over one more transition above the stop band's edge.
fn meets_ripple(weights: &[f64], pass: f64, stop: f64, ripple: f64) -> bool {
    const POINTS: u32 = 24;
    (0..=POINTS).all(|i| {
        let part = f64::from(i) / f64::from(POINTS);
        let above = (stop + (stop - pass) * part).min(0.5);
        (gain(weights, pass * part) - 1.0).abs() < ripple && gain(weights, above).abs() < ripple
    })
}

/// Gain of symmetric weights at a frequency over the rate.
fn gain(weights: &[f64], frequency: f64) -> f64 {
    let middle = (weights.len() / 2) as f64;
    let term = |(j, w): (usize, &f64)| w * (2.0 * PI * frequency * (j as f64 - middle)).cos();
    weights.iter().enumerate().map(term).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// I₀(1), I₀(10): Abramowitz & Stegun, table 9.8 (1.26606 58778, and e⁻¹⁰ I₀(10) = 0.12783 33371 6).
    #[test]
    fn ref_bessel() {
        assert!((bessel_i0(1.0) - 1.266_065_877_8).abs() < 1e-10);
        assert!((bessel_i0(10.0) * (-10.0_f64).exp() - 0.127_833_337_2).abs() < 1e-10);
    }

    /// Specifications of ripple and attenuation are met at every frequency of both bands.
    #[test]
    fn law_bands_are_met() {
        for (pass, stop, db) in [
            (0.2, 0.25, 40.0),
            (0.05, 0.09, 60.0),
            (0.1, 0.12, 80.0),
            (0.02, 0.2, 100.0),
            (0.01, 0.45, 80.0),
            (0.1, 0.4, 120.0),
            (0.008, 0.115, 86.0),
        ] {
            let weights = low_pass(pass, stop, db).unwrap();
            let ripple = 10.0_f64.powf(-db / 20.0);
            for i in 0..=400 {
                let x = f64::from(i) / 400.0;
                assert!((gain(&weights, pass * x) - 1.0).abs() < ripple);
                assert!(gain(&weights, stop + (0.5 - stop) * x).abs() < ripple);
            }
        }
    }

    #[test]
    fn refuses_no_bands() {
        assert_eq!(low_pass(0.3, 0.2, 60.0).unwrap_err().code, Code::OutOfRange);
        assert_eq!(
            low_pass(f64::NAN, 0.2, 60.0).unwrap_err().code,
            Code::OutOfRange
        );
        assert_eq!(low_pass(0.1, 0.2, 5.0).unwrap_err().code, Code::OutOfRange);
    }
}
