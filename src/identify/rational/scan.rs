//! Where one more pole would explain most: `Σ_i |φᴴ E_i|² / |φ|²` for Lorentzians `φ = W/(s − p)` of many widths at every place.
//!
//! Wide Lorentzians are correlated with decimated residuals and cut off at a few widths, so that every width costs about the same
//! few operations per line. Near a pole that is already there, what a new one can explain is judged by what is not shared.

use crate::numeric::Complex;

use super::basis::{Pole, Problem};
use super::projection::Projection;

/// A place for a new pole, with the fall of χ² it promises.
#[derive(Debug, Clone, Copy)]
pub(super) struct Peak {
    /// Start values.
    pub pole: Pole,
    /// Expected fall of χ².
    pub gain: f64,
}

/// Half-widths tried, in line spacings.
const WIDTHS: [f64; 10] = [0.12, 0.5, 1.2, 3.0, 7.5, 18.0, 45.0, 110.0, 270.0, 660.0];

/// Lines of a group, in half-widths; a Lorentzian is cut off at this many half-widths.
const GROUP: f64 = 0.5;
const REACH: f64 = 6.0;

/// A Lorentzian that shares more than this with a pole at hand is judged as if it shared this much.
const MOST_SHARED: f64 = 0.98;

/// Spacings that differ by less than this share of their median are uniform; printed frequencies are rounded.
const UNIFORM: f64 = 1e-2;

/// Median spacing of lines.
pub(super) fn spacing(x: &[f64]) -> f64 {
    let mut steps: Vec<f64> = x.windows(2).map(|x| x[1] - x[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps[steps.len() / 2]
}

fn is_uniform(x: &[f64], step: f64) -> bool {
    x.windows(2)
        .all(|x| (x[1] - x[0] - step).abs() < UNIFORM * step)
}

/// Local maxima over place, for every width, largest first.
pub(super) fn scan(problem: &Problem, fit: &Projection, poles: &[Pole]) -> Vec<Peak> {
    let n = problem.lines();
    let step = spacing(&problem.x);
    let uniform = is_uniform(&problem.x, step);
    let band = problem.x[n - 1] - problem.x[0];
    let mut peaks = Vec::new();
    for width in WIDTHS {
        let sigma = width * step;
        if sigma > 0.6 * band {
            break;
        }
        let groups = Groups::new(problem, fit, (width * GROUP).floor().max(1.0) as usize);
        let offsets: &[f64] = if width < 0.8 { &[0.0, 0.5] } else { &[0.0] };
        for &offset in offsets {
            let gain = groups.gains(sigma, offset, uniform);
            pick(&gain, poles, &mut peaks);
        }
    }
    peaks.sort_by(|a: &Peak, b: &Peak| b.gain.total_cmp(&a.gain));
    peaks
}

/// Adds the local maxima of one width.
fn pick(gain: &[Peak], poles: &[Pole], peaks: &mut Vec<Peak>) {
    let free: Vec<f64> = gain
        .iter()
        .map(|peak| {
            let shared = poles
                .iter()
                .map(|p| p.overlap(&peak.pole))
                .fold(0.0, f64::max);
            peak.gain / (1.0 - shared.min(MOST_SHARED))
        })
        .collect();
    for c in 0..gain.len() {
        let left = c == 0 || free[c] >= free[c - 1];
        let right = c + 1 == gain.len() || free[c] > free[c + 1];
        if left && right {
            peaks.push(Peak {
                pole: gain[c].pole,
                gain: free[c],
            });
        }
    }
}

/// Sums over groups of neighbouring lines.
struct Groups {
    /// Mean frequency of each.
    x: Vec<f64>,
    /// `Σ |factor|²`.
    weight: Vec<f64>,
    /// `Σ factor* E`, by response: real and imaginary parts.
    re: Vec<Vec<f64>>,
    im: Vec<Vec<f64>>,
}

impl Groups {
    fn new(problem: &Problem, fit: &Projection, size: usize) -> Groups {
        let n = problem.lines();
        let starts: Vec<usize> = (0..n).step_by(size).collect();
        let end = |from: usize| (from + size).min(n);
        let sum = |f: &dyn Fn(usize) -> f64| -> Vec<f64> {
            starts
                .iter()
                .map(|&from| (from..end(from)).map(f).sum())
                .collect()
        };
        let (mut re, mut im) = (Vec::new(), Vec::new());
        for i in 0..fit.e.ncols() {
            let e = fit.e.col_as_slice(i);
            let f = &problem.factor;
            re.push(sum(&|k| f[k].re * e[k] + f[k].im * e[n + k]));
            im.push(sum(&|k| f[k].re * e[n + k] - f[k].im * e[k]));
        }
        Groups {
            x: starts
                .iter()
                .map(|&from| {
                    problem.x[from..end(from)].iter().sum::<f64>() / (end(from) - from) as f64
                })
                .collect(),
            weight: sum(&|k| problem.factor[k].norm_sqr()),
            re,
            im,
        }
    }

    /// Gain with a pole of real part `−sigma` at every group, `offset` of a group further up.
    fn gains(&self, sigma: f64, offset: f64, uniform: bool) -> Vec<Peak> {
        let n = self.x.len();
        let step = if n > 1 { self.x[1] - self.x[0] } else { sigma };
        let reach = (REACH * sigma / step).ceil() as usize + 2;
        let place: Vec<f64> = self.x.iter().map(|x| x + offset * step).collect();
        let gain = if uniform {
            self.correlate(sigma, offset * step, step, reach)
        } else {
            self.correlate_unevenly(sigma, &place, reach)
        };
        (0..n)
            .map(|c| Peak {
                pole: Pole {
                    w: place[c],
                    sigma,
                    stable: true,
                },
                gain: gain[c],
            })
            .collect()
    }

    /// With one table of the Lorentzian, moved along.
    fn correlate(&self, sigma: f64, offset: f64, step: f64, reach: usize) -> Vec<f64> {
        let n = self.x.len();
        let taps: Vec<(isize, Complex)> = (-(reach as isize)..=reach as isize)
            .map(|t| (t, lorentzian(t as f64 * step - offset, sigma)))
            .collect();
        let mut norm = vec![0.0; n];
        let mut gain = vec![0.0; n];
        for &(t, z) in &taps {
            let (to, from, count) = overlap(n, t);
            let square = z.norm_sqr();
            add(
                &mut norm[to..to + count],
                &self.weight[from..from + count],
                square,
            );
        }
        let (mut sum_re, mut sum_im) = (vec![0.0; n], vec![0.0; n]);
        for (re, im) in self.re.iter().zip(&self.im) {
            sum_re.fill(0.0);
            sum_im.fill(0.0);
            for &(t, z) in &taps {
                let (to, from, count) = overlap(n, t);
                let (re, im) = (&re[from..from + count], &im[from..from + count]);
                // conj(z) times the residual
                add(&mut sum_re[to..to + count], re, z.re);
                add(&mut sum_re[to..to + count], im, z.im);
                add(&mut sum_im[to..to + count], im, z.re);
                add(&mut sum_im[to..to + count], re, -z.im);
            }
            for c in 0..n {
                gain[c] += sum_re[c] * sum_re[c] + sum_im[c] * sum_im[c];
            }
        }
        gain.iter_mut()
            .zip(&norm)
            .for_each(|(g, n)| *g = if *n > 0.0 { *g / n } else { 0.0 });
        gain
    }

    /// Line by line, for uneven spacing.
    fn correlate_unevenly(&self, sigma: f64, place: &[f64], reach: usize) -> Vec<f64> {
        let n = self.x.len();
        place
            .iter()
            .enumerate()
            .map(|(c, &w)| {
                let range = c.saturating_sub(reach)..(c + reach + 1).min(n);
                let z: Vec<Complex> = range
                    .clone()
                    .map(|k| lorentzian(self.x[k] - w, sigma))
                    .collect();
                let norm: f64 = range
                    .clone()
                    .zip(&z)
                    .map(|(k, z)| self.weight[k] * z.norm_sqr())
                    .sum();
                let gain: f64 = (0..self.re.len())
                    .map(|i| {
                        let sum: Complex = range
                            .clone()
                            .zip(&z)
                            .map(|(k, z)| z.conj() * Complex::new(self.re[i][k], self.im[i][k]))
                            .sum();
                        sum.norm_sqr()
                    })
                    .sum();
                if norm > 0.0 { gain / norm } else { 0.0 }
            })
            .collect()
    }
}

/// `1/(s − p)` at a distance above the pole.
fn lorentzian(distance: f64, sigma: f64) -> Complex {
    Complex::new(sigma, -distance) / (sigma * sigma + distance * distance)
}

/// Where a shift by `t` keeps both slices inside: start of the sum, start of the data, count.
fn overlap(n: usize, t: isize) -> (usize, usize, usize) {
    let shift = t.unsigned_abs().min(n);
    if t >= 0 {
        (0, shift, n - shift)
    } else {
        (shift, 0, n - shift)
    }
}

fn add(sum: &mut [f64], data: &[f64], factor: f64) {
    sum.iter_mut().zip(data).for_each(|(s, d)| *s += factor * d);
}
