//! Evaluation of profile and helix traces: total deviation `F = max − min`, slope deviation `f_H` of the least-squares line over the
//! evaluation length, form deviation `f_f = max − min` about the line.
//!
//! A profile trace is a function of the length of roll, a helix trace of the position along the face width; excess material is positive.

use super::estimate::{Estimate, check_finite};
use super::pitch::arg_min_max;
use crate::base::code::Code;
use crate::base::error::Error;

/// Minimum number of points of a mean line.
const MIN_POINTS: usize = 3;

/// Mean line through part of a trace, with total, form and slope deviations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MeanLine {
    /// Total deviation F: range of the trace, m.
    pub total: Estimate,
    /// Form deviation f_f: range about the line, m.
    pub form: Estimate,
    /// Slope deviation f_H: rise of the line over the reach, m.
    pub slope: Estimate,
    /// Mean position of the points, m, where the height of the line is `level`.
    pub middle: f64,
    /// Height of the line at `middle`, m.
    pub level: f64,
    /// Slope of the line, m/m.
    pub gradient: f64,
    points: f64,
    spread: f64,
}

impl MeanLine {
    /// Height of the line at position `x`, m.
    pub fn height_at(&self, x: f64) -> f64 {
        self.level + self.gradient * (x - self.middle)
    }

    /// Element of the hat matrix for the positions `a` and `b`.
    fn leverage(&self, a: f64, b: f64) -> f64 {
        1.0 / self.points + (a - self.middle) * (b - self.middle) / self.spread
    }
}

/// Evaluates the points of a trace between `from` and `to`, m. `reach`: length over which the slope deviation is stated, m; `std`: standard
/// uncertainty of a point, m, independent of the other points.
///
/// # Errors
/// `OutOfRange` for different lengths or positions not ascending, `NotANumber` for a point that is not finite, `TooShort` for fewer than 3
/// points in the range.
pub fn fit_mean_line(
    along: &[f64],
    deviation: &[f64],
    (from, to): (f64, f64),
    reach: f64,
    std: Option<f64>,
) -> Result<MeanLine, Error> {
    check(along, deviation)?;
    // A limit of the range that coincides with a point may miss it by rounding.
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
        return Err(Error::new(Code::TooShort, message)
            .with_hint("at least 3 are needed; check the range and its unit"));
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
    let residuals: Vec<f64> = x
        .iter()
        .zip(y)
        .map(|(x, y)| y - level - gradient * (x - middle))
        .collect();
    let ((low, high), (min, max)) = (arg_min_max(y), arg_min_max(&residuals));
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
    let (a, b) = (x[min], x[max]);
    let gain = 2.0 - line.leverage(a, a) - line.leverage(b, b) + 2.0 * line.leverage(a, b);
    line.form = Estimate::new(residuals[max] - residuals[min], gain.max(0.0).sqrt(), std);
    Ok(line)
}

/// Gaussian low-pass filter of a trace: weighting function `exp(−π (x/αλ_c)²)`, `α = √(ln 2/π)`, with a transmission of one half at the
/// cut-off wavelength λ_c (ISO 16610-21). Points are weighted by their spacing; near an end the weights are normalised to one.
///
/// # Errors
/// `OutOfRange` for different lengths, positions not ascending or a cut-off below two point spacings; `NotANumber`.
pub fn gaussian_filter(along: &[f64], deviation: &[f64], cutoff: f64) -> Result<Vec<f64>, Error> {
    /// Half width of the kernel in cut-offs, beyond which the weight is below 1e-6 of its maximum.
    const KERNEL_HALF_WIDTH: f64 = 1.0;
    check(along, deviation)?;
    let alpha = (std::f64::consts::LN_2 / std::f64::consts::PI).sqrt();
    let n = along.len();
    let spacing = |i: usize| 0.5 * (along[(i + 1).min(n - 1)] - along[i.saturating_sub(1)]);
    let max_spacing = (1..n).map(|i| along[i] - along[i - 1]).fold(0.0, f64::max);
    if !(cutoff.is_finite() && cutoff >= 2.0 * max_spacing) {
        let message = format!(
            "a filter of {:.4} mm is shorter than two steps of the trace, of {:.4} mm",
            1e3 * cutoff,
            1e3 * max_spacing
        );
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("omit the filter, or measure the trace at a smaller spacing"));
    }
    let mean = |i: usize| {
        let window = along.partition_point(|&x| x < along[i] - KERNEL_HALF_WIDTH * cutoff)
            ..along.partition_point(|&x| x <= along[i] + KERNEL_HALF_WIDTH * cutoff);
        let (mut weights, mut sum) = (0.0, 0.0);
        for j in window {
            let u = (along[j] - along[i]) / (alpha * cutoff);
            let w = spacing(j) * (-std::f64::consts::PI * u * u).exp();
            weights += w;
            sum += w * deviation[j];
        }
        sum / weights
    };
    Ok((0..n).map(mean).collect())
}

/// Tip relief, m: depth of the last point (first point for an internal gear) below the mean line through the points of a range, m.
///
/// # Errors
/// Errors of [`fit_mean_line()`].
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
            "{} places and {} deviations in one trace",
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
            format!("places of the trace do not increase at point {}", i + 2),
        )
        .with_hint("order a profile by length of roll, a helix from one face to the other")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{LN_2, TAU};

    /// The transmission at a wavelength λ is `exp(−ln 2 (λ_c/λ)²)`, one half at the cut-off; a straight line is unchanged.
    #[test]
    fn exact_gaussian_filter() {
        let position = |k: usize| 1e-5 * (k as f64 + 0.3 * (0.7 * k as f64).sin());
        let along: Vec<f64> = (0..2000).map(position).collect();
        let cutoff = 0.8e-3;
        for length in [0.4e-3, 0.8e-3, 1.6e-3, 8e-3] {
            let wave: Vec<f64> = along.iter().map(|x| (TAU * x / length).cos()).collect();
            let filtered = gaussian_filter(&along, &wave, cutoff).unwrap();
            let transmission = (-LN_2 * (cutoff / length).powi(2)).exp();
            for k in 200..1800 {
                assert!(
                    (filtered[k] - transmission * wave[k]).abs() < 1e-5,
                    "{length} {k}: {} {}",
                    filtered[k],
                    transmission * wave[k]
                );
            }
        }
        let line: Vec<f64> = along.iter().map(|x| 3.0 * x - 0.01).collect();
        let filtered = gaussian_filter(&along, &line, cutoff).unwrap();
        assert!((200..1800).all(|k| (filtered[k] - line[k]).abs() < 1e-9));
    }

    #[test]
    fn refuses_filters_finer_than_the_trace() {
        let along = [0.0, 1e-4, 2e-4, 3e-4];
        let error = gaussian_filter(&along, &[0.0; 4], 1.5e-4).unwrap_err();
        assert_eq!(error.code, Code::OutOfRange);
        assert!(gaussian_filter(&along, &[0.0; 4], f64::NAN).is_err());
    }
}
