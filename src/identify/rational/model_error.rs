//! The variance of a value that departs from the model about resonances, by more than its noise `s²`:
//! `v = s² + Σ_r n_r (ε_r² min(|H_r|², M) + τ_r² min(|σ_r ∂H/∂ω_r|², M))`, with H_r the part of mode r, M the largest |H|² of the
//! neighbouring lines and n_r the lines across the resonance: a departure is smooth along it, so that all of them together are one
//! piece of evidence. Both shares fade beyond an octave of the pole.

use std::f64::consts::PI;
use std::ops::Range;

use crate::numeric::Complex;

use super::basis::ScaledPole;
use super::scaled_responses::ScaledResponses;

/// Beyond so many times the frequency of a pole, and below that part of it, its departure fades: there residual terms and other poles take
/// it up. Two poles at the lowest lines whose tails cancel would excuse the whole band.
const DEPARTURE_REACH: f64 = 2.0;

/// Lines to either side whose largest value bounds what a departure may be: two poles that cancel would make room for themselves.
const NEIGHBOURS: usize = 2;

/// By what a mode departs from the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ModeDeviation {
    /// Share of the mode's own value, ε.
    pub share: f64,
    /// Standard deviation of its frequency over hits or responses in half-widths, τ.
    pub scatter: f64,
    /// Half-width over which lines count as one, in units of the highest line.
    pub width: f64,
}

impl ModeDeviation {
    /// The mode obeys the model.
    pub const NONE: ModeDeviation = ModeDeviation {
        share: 0.0,
        scatter: 0.0,
        width: 0.0,
    };

    /// Lines across the resonance of a pole.
    fn lines(&self, pole: &ScaledPole, step: f64) -> f64 {
        (PI * pole.sigma.min(self.width) / step).max(1.0)
    }
}

/// Poles with what each response has of them: two coefficients a pole, of `|p|/D` and `s/D` in the scaled responses.
#[derive(Debug, Clone, Default)]
pub(super) struct PoleResidues {
    /// Pole pairs.
    pub poles: Vec<ScaledPole>,
    /// By response, two for each pole.
    pub coefficients: Vec<Vec<f64>>,
}

impl PoleResidues {
    /// Those of some poles.
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

    /// The part of mode r in a response over `s^q`, and `1/D`.
    pub fn part(&self, response: usize, r: usize, x: f64) -> (Complex, Complex) {
        let pole = &self.poles[r];
        let (s, p) = (Complex::new(0.0, x), pole.value());
        let c = &self.coefficients[response][2 * r..2 * r + 2];
        let inverse = 1.0 / ((s - p) * (s - p.conj()));
        ((c[0] * p.norm() + s * c[1]) * inverse, inverse)
    }
}

/// The variance of the scaled responses on the lines from `from` on, by response and line; that of the noise is of these lines alone.
pub(super) fn variance(
    lines: &ScaledResponses,
    from: usize,
    noise: &[Vec<f64>],
    modes: &PoleResidues,
    departures: &[ModeDeviation],
) -> Vec<Vec<f64>> {
    let to = from + noise[0].len();
    // Background and what lies outside the band are no modes that could depart.
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
            let most = largest_nearby(&lines.h[i], from, to);
            for (r, profile) in &departing {
                let c = [0, 1].map(|j| modes.coefficients[i][2 * r + j]);
                profile.add(c, &lines.x[from..to], &most, &mut v);
            }
            v
        })
        .collect()
}

/// Departure of a mode along the spectral lines, for a response of its coefficients.
struct DepartureProfile {
    /// `|p|²`.
    pole_size: f64,
    /// `n ε²` and `n τ²`.
    squares: [f64; 2],
    /// `|s^q/D|²`, fading far from the pole.
    own: Vec<f64>,
    /// `|2wσ s^q/D²|²`, likewise; empty where τ is zero.
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
        let of_line = |(k, inverse): (usize, &f64)| {
            inverse * lines.power_size(k) * nearness(pole, lines.x[k])
        };
        let own: Vec<f64> = range.zip(&inverse).map(of_line).collect();
        let steep = (2.0 * pole.w * pole.sigma).powi(2);
        let slope = match departure.scatter > 0.0 {
            true => (own.iter().zip(&inverse))
                .map(|(o, i)| steep * o * i)
                .collect(),
            false => Vec::new(),
        };
        let count = departure.lines(pole, lines.step);
        DepartureProfile {
            pole_size: p.norm_sqr(),
            squares: [departure.share, departure.scatter].map(|d| count * d * d),
            own,
            slope,
        }
    }

    /// Adds the departure of a response with the coefficients `c` to its variance `v`; `most` bounds it on each line.
    fn add(&self, c: [f64; 2], x: &[f64], most: &[f64], v: &mut [f64]) {
        let (fixed, turned) = (c[0] * c[0] * self.pole_size, c[1] * c[1]);
        for (square, profile) in self.squares.iter().zip([&self.own, &self.slope]) {
            for (k, profile) in profile.iter().enumerate() {
                let size = (fixed + turned * x[k] * x[k]) * profile;
                v[k] += square * size.min(most[k]);
            }
        }
    }
}

/// One within [`DEPARTURE_REACH`] of a pole, beyond it the fourth power of what is left of that reach.
fn nearness(pole: &ScaledPole, x: f64) -> f64 {
    let reach = DEPARTURE_REACH * (x / pole.w).min(pole.w / x);
    reach.min(1.0).powi(4)
}

/// The largest `|H|²` within a few lines of each.
fn largest_nearby(h: &[Complex], from: usize, to: usize) -> Vec<f64> {
    let first = from.saturating_sub(NEIGHBOURS);
    let last = (to + NEIGHBOURS).min(h.len());
    let squares: Vec<f64> = h[first..last].iter().map(|z| z.norm_sqr()).collect();
    let nearby = |k: usize| {
        let near = k.saturating_sub(NEIGHBOURS).max(first)..(k + NEIGHBOURS + 1).min(last);
        let near = &squares[near.start - first..near.end - first];
        near.iter().copied().fold(0.0, f64::max)
    };
    (from..to).map(nearby).collect()
}

/// The departure of a mode is what is left within so many half-widths, and at least so many lines to either side.
const MODE_HALF_WIDTHS: (f64, f64) = (1.5, 3.0);

/// Standard deviations of the noise's power below which nothing is a departure.
const NOISE_SIGMA: f64 = 2.0;

/// Residual at a mode beyond the noise as a share of the mode's own value, responses weighed by their share of the mode.
pub(super) fn misfit(
    lines: &ScaledResponses,
    from: usize,
    of: &[usize],
    residual: &[Vec<Complex>],
    noise: &[Vec<f64>],
    modes: &PoleResidues,
    r: usize,
) -> f64 {
    let pole = &modes.poles[r];
    let reach = (MODE_HALF_WIDTHS.0 * pole.sigma).max(MODE_HALF_WIDTHS.1 * lines.step);
    let (mut left, mut own, mut chance, mut least) = (0.0, 0.0, 0.0, 0.0);
    let m = noise[0].len();
    let first = lines.x[from..from + m].partition_point(|&x| x < pole.w - reach);
    let end = lines.x[from..from + m].partition_point(|&x| x <= pole.w + reach);
    for (at, &i) in of.iter().enumerate() {
        for k in first..end {
            let x = lines.x[from + k];
            let part = modes.part(i, r, x).0.norm_sqr() * lines.power_size(from + k);
            let whole = lines.h[i][from + k].norm_sqr().max(f64::MIN_POSITIVE);
            let weight = (part / whole).min(1.0) / whole;
            left += weight * residual[at][k].norm_sqr();
            own += weight * part;
            least += weight * noise[i][k];
            chance += (weight * noise[i][k]).powi(2);
        }
    }
    let count = (end - first) as f64;
    // The mode's own residue and place have taken their part of what was left.
    let taken = 1.0 + 1.0 / of.len() as f64;
    let free = (1.0 - taken / count.max(1.0)).max(0.2);
    let beyond = left / free - least - NOISE_SIGMA * chance.sqrt();
    if own > 0.0 && beyond > 0.0 {
        (beyond / own).sqrt().min(1.0)
    } else {
        0.0
    }
}
