//! SDOF methods (Ewins): peak picking, half-power bandwidth, circle fit.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::sorting::sort_falling;
use crate::numeric::{Complex, Matrix, lstsq, parabola};
use crate::spectrum::integrate::MotionQuantity;

/// Lines a circle is laid through, at least.
const ARC_LINES: usize = 7;

/// Lines of the local maxima of `|H|` that exceed `share` of the largest value, by rising frequency.
pub fn pick_peaks(response: &[Complex], share: f64) -> Vec<usize> {
    let size: Vec<f64> = response.iter().map(|z| z.norm()).collect();
    let least = share * size.iter().copied().fold(0.0, f64::max);
    (1..size.len().saturating_sub(1))
        .filter(|&k| size[k] >= least && size[k] > size[k - 1] && size[k] >= size[k + 1])
        .collect()
}

/// Root of the sum of squares over the responses, each by its own largest value.
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

/// Peaks above `share` of the largest value with the first and last of the lines within half power, by rising frequency; those inside the
/// lines of a higher one are left out.
pub fn separate_peaks(level: &[f64], share: f64) -> Vec<(usize, (usize, usize))> {
    let curve: Vec<Complex> = level.iter().map(|&l| Complex::new(l, 0.0)).collect();
    let mut by_height = pick_peaks(&curve, share);
    sort_falling(&mut by_height, |&a| level[a]);
    let mut found: Vec<(usize, (usize, usize))> = Vec::new();
    for peak in by_height {
        if found.iter().any(|(_, (a, b))| (*a..=*b).contains(&peak)) {
            continue;
        }
        let least = level[peak] / 2f64.sqrt();
        let (mut from, mut to) = (peak, peak);
        while from > 0 && level[from - 1] >= least {
            from -= 1;
        }
        while to + 1 < level.len() && level[to + 1] >= least {
            to += 1;
        }
        while to - from + 1 < ARC_LINES && (from > 0 || to + 1 < level.len()) {
            from = from.saturating_sub(1);
            to = (to + 1).min(level.len() - 1);
        }
        found.push((peak, (from, to)));
    }
    found.sort_by_key(|f| f.0);
    found
}

/// The mode of a peak by the two frequencies where `|H|²` is half of the peak's.
///
/// For any damping below `1/√8`, where a receptance still falls to half power on both sides: with
/// `tan 2α = (f₂² − f₁²)/(f₂² + f₁²)`, `ζ = sin α`, since `|H|²` of one mode takes half its largest value at
/// `f² = f_n² (1 − 2ζ² ± 2ζ√(1 − ζ²)) = f_n² (cos 2α ± sin 2α)`. An accelerance is the same in 1/f; for a mobility
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
    let below = (0..peak).rev().find(|&k| power[k] <= half);
    let above = (peak + 1..power.len()).find(|&k| power[k] <= half);
    let (Some(below), Some(above)) = (below, above) else {
        return Err(Error::new(
            Code::IllPosed,
            format!(
                "the peak at {} Hz does not fall to half power on both sides",
                frequency_hz[peak]
            ),
        )
        .with_hint("fit it together with its neighbours"));
    };
    let crossing = |inside: usize, outside: usize| {
        let share = (power[inside] - half) / (power[inside] - power[outside]);
        frequency_hz[inside] + share * (frequency_hz[outside] - frequency_hz[inside])
    };
    let (f1, f2) = (crossing(below + 1, below), crossing(above - 1, above));
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
    Error::new(Code::IllPosed, format!("line {} is no peak", peak + 1))
        .with_hint("take a peak with a line on either side")
}

/// Turns of the reference direction: each squares what is left of it.
const DIRECTION_ITERATIONS: usize = 50;

/// The mode of the lines around a peak by the circle their mobility describes.
///
/// Kennedy & Pancu, J. Aeronaut. Sci. 14 (1947), 603–625; Ewins, Modal Testing, 2nd ed. (2000), §4.3. About the centre, the mobility of one
/// viscously damped mode stands at the angle θ with `tan(θ/2) = (ω_n² − ω²)/(2ζω_n ω)`; a constant from other modes moves the centre,
/// a complex residue turns the reference. Lines are those given: a segment of the arc around one peak, three at least.
///
/// # Errors
/// `TooShort` with fewer than five lines; `IllPosed` where they describe no circle of a damped mode.
pub fn circle_fit(
    frequency_hz: &[f64],
    response: &[Complex],
    quantity: MotionQuantity,
) -> Result<ModalParameters, Error> {
    const MIN_CIRCLE_LINES: usize = 5;
    let n = frequency_hz.len().min(response.len());
    let is_bad = |k: usize| {
        !(frequency_hz[k] > 0.0
            && frequency_hz[k].is_finite()
            && response[k].norm_sqr().is_finite())
    };
    if n < MIN_CIRCLE_LINES || (0..n).any(is_bad) {
        return Err(Error::new(
            Code::TooShort,
            format!("a circle needs {MIN_CIRCLE_LINES} finite values at frequencies above 0, of {n} given"),
        )
        .with_hint("take more lines around the peak"));
    }
    let unit = frequency_hz[n / 2]; // frequencies in units of one inside the arc
    let x: Vec<f64> = frequency_hz[..n].iter().map(|f| f / unit).collect();
    let mobility: Vec<Complex> = (0..n)
        .map(|k| response[k] * Complex::new(0.0, x[k]).powi(1 - quantity.derivative_order()))
        .collect();
    let centre = circle_centre(&mobility)?;
    // the line that sweeps fastest is nearest the natural frequency
    let angle = |k: usize| {
        ((mobility[k + 1] - centre) / (mobility[k] - centre))
            .arg()
            .abs()
            / (x[k + 1] - x[k])
    };
    let fastest = (0..n - 1).fold(0, |best, k| if angle(k) > angle(best) { k } else { best });
    let mut reference = mobility[fastest] - centre;
    let (mut a, mut b) = (0.0, 0.0);
    for _ in 0..DIRECTION_ITERATIONS {
        let t: Vec<f64> = mobility
            .iter()
            .map(|&y| (((y - centre) / reference).arg() / 2.0).tan())
            .collect();
        // t ω = A − B ω² + d (ω + …), A = ω_n/2ζ, B = 1/(2ζω_n), and the reference to be turned by d
        let columns = Matrix::from_fn(n, 3, |k, j| match j {
            0 => 1.0,
            1 => -x[k] * x[k],
            _ => x[k] * (1.0 + t[k] * t[k]),
        });
        let right = Matrix::from_fn(n, 1, |k, _| t[k] * x[k]);
        let found = lstsq::lstsq(&columns, &right)?;
        (a, b) = (found[(0, 0)], found[(1, 0)]);
        let turn = 2.0 * found[(2, 0)].atan();
        reference *= Complex::new(0.0, turn).exp();
        if turn.abs() < 1e-14 {
            break; // rounding of the angles
        }
    }
    from_frequency_and_damping((a / b).sqrt() * unit, 1.0 / (2.0 * (a * b).sqrt()))
}

/// Centre of the circle nearest in the algebraic sense: `2 c·y + e = |y|²`.
fn circle_centre(points: &[Complex]) -> Result<Complex, Error> {
    let size = points.iter().fold(0.0_f64, |m, z| m.max(z.norm()));
    if size == 0.0 {
        return Err(
            Error::new(Code::NoSignal, "the response is zero around the peak")
                .with_hint("take another output"),
        );
    }
    let y: Vec<Complex> = points.iter().map(|z| z / size).collect();
    let columns = Matrix::from_fn(y.len(), 3, |k, j| [2.0 * y[k].re, 2.0 * y[k].im, 1.0][j]);
    let right = Matrix::from_fn(y.len(), 1, |k, _| y[k].norm_sqr());
    let found = lstsq::lstsq(&columns, &right)?;
    Ok(Complex::new(found[(0, 0)], found[(1, 0)]) * size)
}
