//! Variance of FRF values with a model error at resonances in addition to the noise variance `s²`:
//! `v = s² + Σ_r n_r (ε_r² min(|H_r|², M) + τ_r² min(|σ_r ∂H/∂ω_r|², M))`, with H_r the part of mode r, M the largest |H|² of the
//! neighbouring lines and n_r the number of lines across the resonance: a model error is smooth across it, so that these lines count as
//! one observation. Both terms decrease beyond an octave from the pole.

use std::f64::consts::PI;
use std::ops::Range;

use crate::numeric::Complex;

use super::basis::ScaledPole;
use super::scaled_responses::ScaledResponses;

/// Frequency ratio to a pole beyond which its model error decreases: residual terms and other poles absorb it there. Without the limit, two
/// poles at the lowest lines with cancelling tails would raise the variance of the whole band.
const DEPARTURE_REACH: f64 = 2.0;

/// Number of lines to either side whose maximum limits the model error; otherwise two cancelling poles would raise their own variance.
const NEIGHBOURS: usize = 2;

/// Deviation of a mode from the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ModeDeviation {
    /// Model error relative to the response of the mode, ε.
    pub share: f64,
    /// Standard deviation of its frequency over hits or responses, in half-widths, τ.
    pub scatter: f64,
    /// Half-width of the range whose lines count as one observation, in units of the highest line.
    pub width: f64,
}

impl ModeDeviation {
    /// Mode without model error.
    pub const NONE: ModeDeviation = ModeDeviation {
        share: 0.0,
        scatter: 0.0,
        width: 0.0,
    };

    /// Number of lines across the resonance of a pole, at least 1.
    fn lines(&self, pole: &ScaledPole, step: f64) -> f64 {
        (PI * pole.sigma.min(self.width) / step).max(1.0)
    }
}

/// Poles with two coefficients per response and pole, of `|p|/D` and `s/D` in the scaled responses.
#[derive(Debug, Clone, Default)]
pub(super) struct PoleResidues {
    /// Pole pairs.
    pub poles: Vec<ScaledPole>,
    /// Coefficients by response, two for each pole.
    pub coefficients: Vec<Vec<f64>>,
}

impl PoleResidues {
    /// Selects poles by index, with their coefficients.
    pub fn select(&self, places: &[usize]) -> PoleResidues {
        let row = |c: &Vec<f64>| {
            let pairs = places.iter().flat_map(|&r| [c[2 * r], c[2 * r + 1]]);
            pairs.collect()
        };
        PoleResidues {
            poles: places.iter().map(|&r| self.poles[r]).collect(),
            coefficients: self.coefficients.iter().map(row).collect(),
        }
    }

    /// Part of mode r in a response divided by `s^q`, and `1/D`, at the scaled frequency `x`.
    pub fn part(&self, response: usize, r: usize, x: f64) -> (Complex, Complex) {
        let pole = &self.poles[r];
        let (s, p) = (Complex::new(0.0, x), pole.value());
        let c = &self.coefficients[response][2 * r..2 * r + 2];
        let inverse = 1.0 / ((s - p) * (s - p.conj()));
        ((c[0] * p.norm() + s * c[1]) * inverse, inverse)
    }
}

/// Variance of the scaled responses by response and line, from line `from` on; `noise` is the noise variance of these lines.
pub(super) fn variance(
    lines: &ScaledResponses,
    from: usize,
    noise: &[Vec<f64>],
    modes: &PoleResidues,
    departures: &[ModeDeviation],
) -> Vec<Vec<f64>> {
    let to = from + noise[0].len();
    // Background poles and poles outside the band have no model error.
    let departing: Vec<(usize, DepartureProfile)> = (departures.iter().enumerate())
        .filter(|(r, d)| (d.share > 0.0 || d.scatter > 0.0) && lines.may_be_mode(&modes.poles[*r]))
        .map(|(r, d)| {
            (
                r,
                DepartureProfile::new(lines, from..to, &modes.poles[r], d),
            )
        })
        .collect();
    (0..lines.h.len())
        .map(|i| {
            let mut v = noise[i].clone();
            let bound = largest_nearby(&lines.h[i], from, to);
            for (r, profile) in &departing {
                let c = [0, 1].map(|j| modes.coefficients[i][2 * r + j]);
                profile.add(c, &lines.x[from..to], &bound, &mut v);
            }
            v
        })
        .collect()
}

/// Variance profile of the model error of a mode along the spectral lines, for unit coefficients.
struct DepartureProfile {
    /// `|p|²`.
    pole_size: f64,
    /// `n ε²` and `n τ²`.
    squares: [f64; 2],
    /// `|s^q/D|²`, tapered beyond [`DEPARTURE_REACH`].
    gain: Vec<f64>,
    /// `|2wσ s^q/D²|²` with the same taper; empty if τ is zero.
    slope: Vec<f64>,
}

impl DepartureProfile {
    fn new(
        lines: &ScaledResponses,
        range: Range<usize>,
        pole: &ScaledPole,
        departure: &ModeDeviation,
    ) -> DepartureProfile {
        let p = pole.value();
        let inverse = |k: usize| {
            let s = Complex::new(0.0, lines.x[k]);
            1.0 / ((s - p) * (s - p.conj())).norm_sqr()
        };
        let inverse: Vec<f64> = range.clone().map(inverse).collect();
        let line_gain =
            |(k, inverse): (usize, &f64)| inverse * lines.power_size(k) * taper(pole, lines.x[k]);
        let gain: Vec<f64> = range.zip(&inverse).map(line_gain).collect();
        let factor = (2.0 * pole.w * pole.sigma).powi(2);
        let slope = match departure.scatter > 0.0 {
            true => (gain.iter().zip(&inverse))
                .map(|(o, i)| factor * o * i)
                .collect(),
            false => Vec::new(),
        };
        let count = departure.lines(pole, lines.step);
        DepartureProfile {
            pole_size: p.norm_sqr(),
            squares: [departure.share, departure.scatter].map(|d| count * d * d),
            gain,
            slope,
        }
    }

    /// Adds the model error of a response with the coefficients `c` to its variance `v`; `bound` limits it on each line.
    fn add(&self, c: [f64; 2], x: &[f64], bound: &[f64], v: &mut [f64]) {
        let (constant, linear) = (c[0] * c[0] * self.pole_size, c[1] * c[1]);
        for (square, profile) in self.squares.iter().zip([&self.gain, &self.slope]) {
            for (k, profile) in profile.iter().enumerate() {
                let size = (constant + linear * x[k] * x[k]) * profile;
                v[k] += square * size.min(bound[k]);
            }
        }
    }
}

/// Taper of the model error: 1 within [`DEPARTURE_REACH`] of a pole, beyond it the fourth power of the reach over the frequency ratio.
fn taper(pole: &ScaledPole, x: f64) -> f64 {
    let reach = DEPARTURE_REACH * (x / pole.w).min(pole.w / x);
    reach.min(1.0).powi(4)
}

/// Largest `|H|²` within [`NEIGHBOURS`] lines of each line.
fn largest_nearby(h: &[Complex], from: usize, to: usize) -> Vec<f64> {
    let first = from.saturating_sub(NEIGHBOURS);
    let last = (to + NEIGHBOURS).min(h.len());
    let squares: Vec<f64> = h[first..last].iter().map(|z| z.norm_sqr()).collect();
    let nearby = |k: usize| {
        let range = k.saturating_sub(NEIGHBOURS).max(first)..(k + NEIGHBOURS + 1).min(last);
        let values = &squares[range.start - first..range.end - first];
        values.iter().copied().fold(0.0, f64::max)
    };
    (from..to).map(nearby).collect()
}

/// Range of the residual of a mode to either side of the pole: half-widths, and minimum number of lines.
const MODE_HALF_WIDTHS: (f64, f64) = (1.5, 3.0);

/// Minimum excess of a model error over the noise power, in standard deviations of the noise power.
const NOISE_SIGMA: f64 = 2.0;

/// Model error of mode r: residual in excess of the noise relative to the response of the mode; responses weighted by its share in them.
pub(super) fn misfit(
    lines: &ScaledResponses,
    from: usize,
    responses: &[usize],
    residual: &[Vec<Complex>],
    noise: &[Vec<f64>],
    modes: &PoleResidues,
    r: usize,
) -> f64 {
    let pole = &modes.poles[r];
    let reach = (MODE_HALF_WIDTHS.0 * pole.sigma).max(MODE_HALF_WIDTHS.1 * lines.step);
    let (mut total, mut modal, mut noise_sq, mut expected) = (0.0, 0.0, 0.0, 0.0);
    let m = noise[0].len();
    let first = lines.x[from..from + m].partition_point(|&x| x < pole.w - reach);
    let end = lines.x[from..from + m].partition_point(|&x| x <= pole.w + reach);
    for (column, &i) in responses.iter().enumerate() {
        for k in first..end {
            let x = lines.x[from + k];
            let part = modes.part(i, r, x).0.norm_sqr() * lines.power_size(from + k);
            let power = lines.h[i][from + k].norm_sqr().max(f64::MIN_POSITIVE);
            let weight = (part / power).min(1.0) / power;
            total += weight * residual[column][k].norm_sqr();
            modal += weight * part;
            expected += weight * noise[i][k];
            noise_sq += (weight * noise[i][k]).powi(2);
        }
    }
    let count = (end - first) as f64;
    // The fitted residue and pole of the mode have reduced the residual.
    let fitted = 1.0 + 1.0 / responses.len() as f64;
    let dof = (1.0 - fitted / count.max(1.0)).max(0.2);
    let excess = total / dof - expected - NOISE_SIGMA * noise_sq.sqrt();
    if modal > 0.0 && excess > 0.0 {
        (excess / modal).sqrt().min(1.0)
    } else {
        0.0
    }
}
