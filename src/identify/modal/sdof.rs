//! SDOF modal parameter estimation (Ewins): peak picking, half-power bandwidth `ζ = sin α`, circle fit.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::sorting::sort_descending;
use crate::numeric::{Complex, Matrix, lstsq, parabola};
use crate::spectrum::integrate::MotionQuantity;

/// Minimum number of spectral lines of a peak, for the circle fit.
const ARC_LINES: usize = 7;

/// Line indices of the local maxima of `|H|` of at least `share` (0 to 1) of the largest value, in ascending order.
pub fn pick_peaks(response: &[Complex], share: f64) -> Vec<usize> {
    let h: Vec<f64> = response.iter().map(|z| z.norm()).collect();
    let threshold = share * h.iter().copied().fold(0.0, f64::max);
    (1..h.len().saturating_sub(1))
        .filter(|&k| h[k] >= threshold && h[k] > h[k - 1] && h[k] >= h[k + 1])
        .collect()
}

/// Root of the sum of squares over the responses, each normalised by its largest magnitude, by line.
pub fn summed_response(values: &[Vec<Complex>]) -> Vec<f64> {
    let lines = values.first().map_or(0, Vec::len);
    let mut sum = vec![0.0; lines];
    for response in values {
        let largest = response.iter().map(|z| z.norm_sqr()).fold(0.0, f64::max);
        if largest > 0.0 {
            (sum.iter_mut().zip(response)).for_each(|(s, z)| *s += z.norm_sqr() / largest);
        }
    }
    sum.iter().map(|s| s.sqrt()).collect()
}

/// Peaks of at least `share` (0 to 1) of the largest value with the first and last line of their half-power band, in ascending order; peaks
/// inside the band of a higher peak are excluded. A band has at least seven lines.
pub fn separate_peaks(level: &[f64], share: f64) -> Vec<(usize, (usize, usize))> {
    let curve: Vec<Complex> = level.iter().map(|&l| Complex::new(l, 0.0)).collect();
    let mut by_height = pick_peaks(&curve, share);
    sort_descending(&mut by_height, |&a| level[a]);
    let mut peaks: Vec<(usize, (usize, usize))> = Vec::new();
    for peak in by_height {
        if peaks.iter().any(|(_, (a, b))| (*a..=*b).contains(&peak)) {
            continue;
        }
        let half_power = level[peak] / 2f64.sqrt();
        let (mut from, mut to) = (peak, peak);
        while from > 0 && level[from - 1] >= half_power {
            from -= 1;
        }
        while to + 1 < level.len() && level[to + 1] >= half_power {
            to += 1;
        }
        while to - from + 1 < ARC_LINES && (from > 0 || to + 1 < level.len()) {
            from = from.saturating_sub(1);
            to = (to + 1).min(level.len() - 1);
        }
        peaks.push((peak, (from, to)));
    }
    peaks.sort_by_key(|f| f.0);
    peaks
}

/// Mode of a peak from its half-power frequencies f₁, f₂, at which `|H|²` is half of its peak value; the mode has no shape.
///
/// Exact for damping ratios below `1/√8`, where a receptance falls to half power on both sides: with
/// `tan 2α = (f₂² − f₁²)/(f₂² + f₁²)`, `ζ = sin α`, since `|H|²` of one mode takes half its largest value at
/// `f² = f_n² (1 − 2ζ² ± 2ζ√(1 − ζ²)) = f_n² (cos 2α ± sin 2α)`. An accelerance obeys the same equations in 1/f; for a mobility
/// `f₁ f₂ = f_n²` and `f₂ − f₁ = 2ζ f_n`.
///
/// # Errors
/// `IllPosed` where the response does not fall to half power on both sides.
pub fn half_power(
    frequency_hz: &[f64],
    response: &[Complex],
    peak: usize,
    quantity: MotionQuantity,
) -> Result<ModalParameters, Error> {
    let power: Vec<f64> = response.iter().map(Complex::norm_sqr).collect();
    if power.len() != frequency_hz.len() || peak == 0 || peak + 1 >= power.len() {
        return Err(not_a_peak(peak));
    }
    let half = parabola::vertex([power[peak - 1], power[peak], power[peak + 1]]).1 / 2.0;
    let left = (0..peak).rev().find(|&k| power[k] <= half);
    let right = (peak + 1..power.len()).find(|&k| power[k] <= half);
    let (Some(left), Some(right)) = (left, right) else {
        return Err(Error::new(
            Code::IllPosed,
            format!(
                "the peak at {} Hz does not fall to half power on both sides",
                frequency_hz[peak]
            ),
        )
        .with_hint("fit it together with its neighbours"));
    };
    let crossing = |inner: usize, outer: usize| {
        let share = (power[inner] - half) / (power[inner] - power[outer]);
        frequency_hz[inner] + share * (frequency_hz[outer] - frequency_hz[inner])
    };
    let (f1, f2) = (crossing(left + 1, left), crossing(right - 1, right));
    let (sum, difference) = (f2 * f2 + f1 * f1, f2 * f2 - f1 * f1);
    let alpha = difference.atan2(sum) / 2.0;
    let (natural, damping) = match quantity {
        MotionQuantity::Displacement => ((sum / (2.0 * (2.0 * alpha).cos())).sqrt(), alpha.sin()),
        MotionQuantity::Acceleration => {
            let inverse = 1.0 / (f1 * f1) + 1.0 / (f2 * f2);
            ((2.0 * (2.0 * alpha).cos() / inverse).sqrt(), alpha.sin())
        }
        MotionQuantity::Velocity => ((f1 * f2).sqrt(), (f2 - f1) / (2.0 * (f1 * f2).sqrt())),
    };
    from_frequency_and_damping(natural, damping)
}

fn from_frequency_and_damping(natural_hz: f64, damping: f64) -> Result<ModalParameters, Error> {
    if !(natural_hz.is_finite() && damping.is_finite()) {
        return Err(Error::new(Code::IllPosed, "no circle fits the lines")
            .with_hint("take other lines around the peak"));
    }
    if !(natural_hz > 0.0 && damping > 0.0 && damping < 1.0) {
        return Err(Error::new(
            Code::IllPosed,
            format!("the fit gives {natural_hz} Hz with a damping ratio of {damping}"),
        )
        .with_hint("take other lines around the peak"));
    }
    let omega = TAU * natural_hz;
    Ok(ModalParameters {
        pole: Complex::new(-damping * omega, omega * (1.0 - damping * damping).sqrt()),
        pole_covariance: None,
        shape: Vec::new(),
    })
}

fn not_a_peak(peak: usize) -> Error {
    Error::new(Code::IllPosed, format!("line {} is not a peak", peak + 1))
        .with_hint("choose a peak with a line on either side")
}

/// Maximum iterations of the reference direction; convergence is quadratic.
const DIRECTION_ITERATIONS: usize = 50;

/// Mode of the lines around a peak by a circle fit of the mobility in the Nyquist plane; the mode has no shape.
///
/// Kennedy & Pancu, J. Aeronaut. Sci. 14 (1947), 603–625; Ewins, Modal Testing, 2nd ed. (2000), §4.3. The mobility of a viscously damped
/// mode has the angle θ about the centre, `tan(θ/2) = (ω_n² − ω²)/(2ζω_n ω)`; a constant residual of other modes shifts the centre, a
/// complex residue rotates the reference direction. All lines given are used; select a segment of the arc around one peak.
///
/// # Errors
/// `TooShort` with fewer than five lines; `IllPosed` if they do not fit the circle of a damped mode.
pub fn circle_fit(
    frequency_hz: &[f64],
    response: &[Complex],
    quantity: MotionQuantity,
) -> Result<ModalParameters, Error> {
    const MIN_CIRCLE_LINES: usize = 5;
    let n = frequency_hz.len().min(response.len());
    let is_invalid = |k: usize| {
        !(frequency_hz[k] > 0.0
            && frequency_hz[k].is_finite()
            && response[k].norm_sqr().is_finite())
    };
    if n < MIN_CIRCLE_LINES || (0..n).any(is_invalid) {
        return Err(Error::new(
            Code::TooShort,
            format!("a circle needs {MIN_CIRCLE_LINES} finite values at frequencies above 0, of {n} given"),
        )
        .with_hint("use more lines around the peak"));
    }
    let unit = frequency_hz[n / 2]; // frequencies are normalised by one inside the arc
    let x: Vec<f64> = frequency_hz[..n].iter().map(|f| f / unit).collect();
    let mobility: Vec<Complex> = (0..n)
        .map(|k| response[k] * Complex::new(0.0, x[k]).powi(1 - quantity.derivative_order()))
        .collect();
    let centre = circle_centre(&mobility)?;
    // the angular sweep rate is largest near the natural frequency
    let sweep = |k: usize| {
        ((mobility[k + 1] - centre) / (mobility[k] - centre))
            .arg()
            .abs()
            / (x[k + 1] - x[k])
    };
    let fastest = (0..n - 1).fold(0, |m, k| if sweep(k) > sweep(m) { k } else { m });
    let mut reference = mobility[fastest] - centre;
    let (mut a, mut b) = (0.0, 0.0);
    for _ in 0..DIRECTION_ITERATIONS {
        let t: Vec<f64> = mobility
            .iter()
            .map(|&y| (((y - centre) / reference).arg() / 2.0).tan())
            .collect();
        // t ω = A − B ω² + d ω (1 + t²), A = ω_n/2ζ, B = 1/(2ζω_n); d corrects the reference direction
        let columns = Matrix::from_fn(n, 3, |k, j| match j {
            0 => 1.0,
            1 => -x[k] * x[k],
            _ => x[k] * (1.0 + t[k] * t[k]),
        });
        let right = Matrix::from_fn(n, 1, |k, _| t[k] * x[k]);
        let solution = lstsq::lstsq(&columns, &right)?;
        (a, b) = (solution[(0, 0)], solution[(1, 0)]);
        let rotation = 2.0 * solution[(2, 0)].atan();
        reference *= Complex::new(0.0, rotation).exp();
        if rotation.abs() < 1e-14 {
            break; // level of rounding
        }
    }
    from_frequency_and_damping((a / b).sqrt() * unit, 1.0 / (2.0 * (a * b).sqrt()))
}

/// Centre c of the algebraic least-squares circle, `2 c·y + e = |y|²`.
fn circle_centre(points: &[Complex]) -> Result<Complex, Error> {
    let scale = points.iter().fold(0.0_f64, |m, z| m.max(z.norm()));
    if scale == 0.0 {
        return Err(
            Error::new(Code::NoSignal, "the response is zero around the peak")
                .with_hint("choose another output"),
        );
    }
    let y: Vec<Complex> = points.iter().map(|z| z / scale).collect();
    let columns = Matrix::from_fn(y.len(), 3, |k, j| [2.0 * y[k].re, 2.0 * y[k].im, 1.0][j]);
    let right = Matrix::from_fn(y.len(), 1, |k, _| y[k].norm_sqr());
    let solution = lstsq::lstsq(&columns, &right)?;
    Ok(Complex::new(solution[(0, 0)], solution[(1, 0)]) * scale)
}
