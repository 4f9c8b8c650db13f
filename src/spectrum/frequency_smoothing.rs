//! Frequency-smoothed spectra of one record without a window (swept sine, transients).
//!
//! The whole record is one block without a window: where the structure is at rest at both ends nothing leaks, whatever its damping.
//! `S_xy = mean of X* Y over m lines` leaves H1 over each group of lines weighted by the power put in there; coherence and random
//! error come from the scatter over the m lines, `m` averages. Daniell's spectral window: Bendat & Piersol, Random Data, 4th ed.
//! (2010), section 11.5.5.

use super::spectra::{CrossSpectrum, Spectra, mean};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;

/// Spectra over groups of `group` lines of the transform of a whole record, mean taken off; lines `group · rate/n` apart, each at the
/// middle of its group. Groups must be narrow against the half-power width of what is resolved.
///
/// # Errors
/// `OutOfRange`: no line in a group, or a rate that is none. `TooShort`: the record has not two groups. `Overflow`: a sample that is not finite.
///
/// # Panics
/// Channels of unequal length: a mistake of the caller.
pub fn smoothed_spectra(
    rate_hz: f64,
    channels: &[&[f64]],
    pairs: &[(usize, usize)],
    group: usize,
) -> Result<Spectra, Error> {
    let n = channels.first().map_or(0, |c| c.len());
    assert!(channels.iter().all(|c| c.len() == n));
    if group == 0 || !(rate_hz > 0.0 && rate_hz.is_finite()) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("invalid group of {group} lines or sample rate of {rate_hz} Hz"),
        ));
    }
    // Lines 1 … (n − 1)/2: neither the mean nor half the rate.
    let groups = n.saturating_sub(1) / 2 / group;
    if groups < 2 {
        return Err(Error::new(
            Code::TooShort,
            format!("{n} samples are too few for two groups of {group} lines"),
        )
        .with_hint("use fewer lines per group, or a longer record"));
    }
    let mut fft = RealFft::new(n);
    let transforms = channels
        .iter()
        .map(|channel| transform(channel, &mut fft))
        .collect::<Result<Vec<_>, _>>()?;
    let scale = 2.0 / (rate_hz * n as f64 * group as f64);
    let mean = |x: &[Complex], y: &[Complex], at: usize| -> Complex {
        let lines = 1 + at * group..1 + (at + 1) * group;
        let products = x[lines.clone()].iter().zip(&y[lines]);
        products.map(|(x, y)| x.conj() * y).sum::<Complex>() * scale
    };
    let df = rate_hz / n as f64;
    let middle = |at: usize| (1.0 + at as f64 * group as f64 + 0.5 * (group as f64 - 1.0)) * df;
    Ok(Spectra {
        rate_hz,
        frequency_hz: (0..groups).map(middle).collect(),
        psd: transforms
            .iter()
            .map(|x| (0..groups).map(|at| mean(x, x, at).re).collect())
            .collect(),
        cross: pairs
            .iter()
            .map(|&(x, y)| CrossSpectrum {
                pair: (x, y),
                values: (0..groups)
                    .map(|at| mean(&transforms[x], &transforms[y], at))
                    .collect(),
            })
            .collect(),
        bandwidth_hz: group as f64 * df,
        blocks: group,
        averages: Some(group as f64),
        window_decay: 0.0,
        window: None,
    })
}

fn transform(channel: &[f64], fft: &mut RealFft) -> Result<Vec<Complex>, Error> {
    let mean = mean(channel)?;
    let mut samples: Vec<f64> = channel.iter().map(|x| x - mean).collect();
    let mut spectrum = vec![Complex::new(0.0, 0.0); fft.lines()];
    fft.forward(&mut samples, &mut spectrum);
    Ok(spectrum)
}
