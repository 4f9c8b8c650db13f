//! Profile and helix traces: total `F = max − min` of the deviation from the design, slope `f_H` of the straight line of least squares
//! over a reach, form `f_f = max − min` about that line.
//!
//! A profile lies along the length of roll, a helix along the face width; surplus material is positive.

use super::estimate::{Estimate, check_finite};
use super::pitch::arg_min_max;
use crate::base::code::Code;
use crate::base::error::Error;

/// Fewest points a line is laid through.
const MIN_POINTS: usize = 3;

/// The straight line through part of a trace, and what is read about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanLine {
    /// F: range of the trace.
    pub total: Estimate,
    /// f_f: range about the line.
    pub form: Estimate,
    /// f_H: rise of the line over the reach.
    pub slope: Estimate,
    /// The middle of the points, where the line has `level`.
    pub middle: f64,
    /// The line's height there.
    pub level: f64,
    /// Slope: rise per length.
    pub gradient: f64,
    points: f64,
    spread: f64,
}

impl MeanLine {
    /// Height at `x`.
    pub fn height_at(&self, x: f64) -> f64 {
        self.level + self.gradient * (x - self.middle)
    }

    /// Mutual leverage of two points on the height of the line.
    fn leverage(&self, a: f64, b: f64) -> f64 {
        1.0 / self.points + (a - self.middle) * (b - self.middle) / self.spread
    }
}

/// Evaluates the points of a trace between `from` and `to`; the slope is given over `reach`, the length it is extrapolated to. `std`:
/// the standard uncertainty of one point, independent of the others.
///
/// # Errors
/// `OutOfRange`: lengths that differ or do not rise. `NotANumber`: a point that is not finite. `TooShort`: fewer than 3 points in
/// the range.
pub fn fit_mean_line(
    along: &[f64],
    deviation: &[f64],
    (from, to): (f64, f64),
    reach: f64,
    std: Option<f64>,
) -> Result<MeanLine, Error> {
    check(along, deviation)?;
    // A border that was meant to be on a point may miss it by rounding.
    let slack = 1e-9 * (to - from).abs();
    let first = along.partition_point(|&x| x < from - slack);
    let end = along.partition_point(|&x| x <= to + slack);
    if end < first + MIN_POINTS {
        let message = format!(
            "{} points of the trace lie in its evaluation range, {:.4} to {:.4} mm",
            end.saturating_sub(first),
            1e3 * from,
            1e3 * to
        );
        return Err(Error::new(Code::TooShort, message).with_hint(
            "at least 3 are needed; does the range belong to this trace and its unit?",
        ));
    }
    let (x, y) = (&along[first..end], &deviation[first..end]);
    let n = x.len() as f64;
    let middle = x.iter().sum::<f64>() / n;
    let level = y.iter().sum::<f64>() / n;
    let spread: f64 = x.iter().map(|x| (x - middle).powi(2)).sum();
    let product: f64 = x
        .iter()
        .zip(y)
        .map(|(x, y)| (x - middle) * (y - level))
        .sum();
    let gradient = product / spread;
    let rest: Vec<f64> = x
        .iter()
        .zip(y)
        .map(|(x, y)| y - level - gradient * (x - middle))
        .collect();
    let ((low, high), (under, above)) = (arg_min_max(y), arg_min_max(&rest));
    let mut line = MeanLine {
        total: Estimate::new(y[high] - y[low], 2f64.sqrt(), std),
        form: Estimate::new(0.0, 0.0, std),
        slope: Estimate::new(gradient * reach, reach / spread.sqrt(), std),
        middle,
        level,
        gradient,
        points: n,
        spread,
    };
    let (a, b) = (x[under], x[above]);
    let gain = 2.0 - line.leverage(a, a) - line.leverage(b, b) + 2.0 * line.leverage(a, b);
    line.form = Estimate::new(rest[above] - rest[under], gain.max(0.0).sqrt(), std);
    Ok(line)
}

/// A trace without what is shorter than a cut-off: means under Gauss's weight `exp(−π (x/αλ_c)²)`, `α = √(ln 2/π)`, which passes half of a
/// wave of the length λ_c (ISO 16610-21). Points stand for the length about them; near an end the weight that is left is brought to one.
///
/// # Errors
/// `OutOfRange`: lengths that differ or do not rise; a cut-off that holds fewer than two steps of the trace. `NotANumber`.
pub fn gaussian_filter(along: &[f64], deviation: &[f64], cutoff: f64) -> Result<Vec<f64>, Error> {
    /// Beyond this the weight is e^(−2π·…) < 1e-6 of its crest, in cut-offs.
    const KERNEL_HALF_WIDTH: f64 = 1.0;
    check(along, deviation)?;
    let alpha = (std::f64::consts::LN_2 / std::f64::consts::PI).sqrt();
    let n = along.len();
    let span = |i: usize| 0.5 * (along[(i + 1).min(n - 1)] - along[i.saturating_sub(1)]);
    let widest = (1..n).map(|i| along[i] - along[i - 1]).fold(0.0, f64::max);
    if !(cutoff.is_finite() && cutoff >= 2.0 * widest) {
        let message = format!(
            "a filter of {:.4} mm is shorter than two steps of the trace, of {:.4} mm",
            1e3 * cutoff,
            1e3 * widest
        );
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("leave the filter out, or take the trace at nearer points"));
    }
    let mean = |i: usize| {
        let near = along.partition_point(|&x| x < along[i] - KERNEL_HALF_WIDTH * cutoff)
            ..along.partition_point(|&x| x <= along[i] + KERNEL_HALF_WIDTH * cutoff);
        let (mut weights, mut sum) = (0.0, 0.0);
        for j in near {
            let u = (along[j] - along[i]) / (alpha * cutoff);
            let w = span(j) * (-std::f64::consts::PI * u * u).exp();
            weights += w;
            sum += w * deviation[j];
        }
        sum / weights
    };
    Ok((0..n).map(mean).collect())
}

/// Tip relief of a trace below the line through the points of a range: at its last point, of an internal gear at its first.
///
/// # Errors
/// Those of [`fit_mean_line()`].
pub fn tip_relief(
    along: &[f64],
    deviation: &[f64],
    range: (f64, f64),
    internal: bool,
    std: Option<f64>,
) -> Result<Estimate, Error> {
    let line = fit_mean_line(along, deviation, range, range.1 - range.0, std)?;
    let tip = if internal { 0 } else { along.len() - 1 };
    let gain = (1.0 + line.leverage(along[tip], along[tip])).sqrt();
    Ok(Estimate::new(
        line.height_at(along[tip]) - deviation[tip],
        gain,
        std,
    ))
}

fn check(along: &[f64], deviation: &[f64]) -> Result<(), Error> {
    if along.len() != deviation.len() {
        let message = format!(
            "{} places and {} deviations of one trace",
            along.len(),
            deviation.len()
        );
        return Err(Error::new(Code::OutOfRange, message));
    }
    check_finite(along, "the places of the trace")?;
    check_finite(deviation, "the trace")?;
    match along.windows(2).position(|w| w[1] <= w[0]) {
        None => Ok(()),
        Some(i) => Err(Error::new(
            Code::OutOfRange,
            format!("places of the trace do not rise at point {}", i + 2),
        )
        .with_hint(
            "a profile runs outward, with the length of roll; a helix from one face to the other",
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{LN_2, TAU};

    /// A wave of length λ passes `exp(−ln 2 (λ_c/λ)²)`, half of it at the cut-off; a straight line as it is, and both on uneven points.
    #[test]
    fn exact_gaussian_filter() {
        let uneven = |k: usize| 1e-5 * (k as f64 + 0.3 * (0.7 * k as f64).sin());
        let along: Vec<f64> = (0..2000).map(uneven).collect();
        let cutoff = 0.8e-3;
        for length in [0.4e-3, 0.8e-3, 1.6e-3, 8e-3] {
            let wave: Vec<f64> = along.iter().map(|x| (TAU * x / length).cos()).collect();
            let found = gaussian_filter(&along, &wave, cutoff).unwrap();
            let passes = (-LN_2 * (cutoff / length).powi(2)).exp();
            for k in 200..1800 {
                assert!(
                    (found[k] - passes * wave[k]).abs() < 1e-5,
                    "{length} {k}: {} {}",
                    found[k],
                    passes * wave[k]
                );
            }
        }
        let line: Vec<f64> = along.iter().map(|x| 3.0 * x - 0.01).collect();
        let found = gaussian_filter(&along, &line, cutoff).unwrap();
        assert!((200..1800).all(|k| (found[k] - line[k]).abs() < 1e-9));
    }

    #[test]
    fn refuses_filters_finer_than_the_trace() {
        let along = [0.0, 1e-4, 2e-4, 3e-4];
        let error = gaussian_filter(&along, &[0.0; 4], 1.5e-4).unwrap_err();
        assert_eq!(error.code, Code::OutOfRange);
        assert!(gaussian_filter(&along, &[0.0; 4], f64::NAN).is_err());
    }
}
