//! Scan for one more pole: gain `Σ_i |φᴴ E_i|² / |φ|²` of Lorentzians `φ = W/(s − p)`.
//!
//! Wide Lorentzians are correlated with decimated residuals and truncated at a few widths, so that each width needs about the same
//! number of operations per line. The correlations of a run of frequencies with all responses are one matrix product. Close to an
//! existing pole, only the part of a Lorentzian that is not shared with it counts.

use crate::numeric::{Complex, Matrix, registers};

use super::basis::{ScaledPole, WhitenedProblem};

/// Candidate pole with its expected decrease of χ².
#[derive(Debug, Clone, Copy)]
pub(super) struct ScanPeak {
    /// Initial estimate of the pole.
    pub pole: ScaledPole,
    /// Expected decrease of χ².
    pub gain: f64,
}

/// Half-widths of the scan, in line spacings.
const WIDTHS: [f64; 10] = [0.12, 0.5, 1.2, 3.0, 7.5, 18.0, 45.0, 110.0, 270.0, 660.0];

/// Length of a group of lines, and truncation of a Lorentzian, in half-widths.
const GROUP_HALF_WIDTHS: f64 = 0.5;
const CUTOFF_HALF_WIDTHS: f64 = 6.0;

/// Maximum number of groups to either side of a Lorentzian; the widest ungrouped one has three lines per half-width.
const MAX_REACH: usize = 20;

/// Minimum and maximum number of frequencies in a run.
const RUN_LEN_RANGE: (usize, usize) = (16, 64);

/// Upper limit of the share of a Lorentzian that overlaps an existing pole, and the share below which an overlap is neglected.
const MAX_SHARED: f64 = 0.98;
const MIN_SHARED: f64 = 0.01;

/// Relative deviation from the median spacing below which lines are uniform; printed frequencies are rounded.
const SPACING_TOLERANCE: f64 = 1e-2;

/// Median spacing of lines.
pub(super) fn median_spacing(x: &[f64]) -> f64 {
    let mut steps: Vec<f64> = x.windows(2).map(|x| x[1] - x[0]).collect();
    steps.sort_by(f64::total_cmp);
    steps[steps.len() / 2]
}

fn is_uniform(x: &[f64], step: f64) -> bool {
    x.windows(2)
        .all(|x| (x[1] - x[0] - step).abs() < SPACING_TOLERANCE * step)
}

/// Local maxima of the gain over frequency for each width, largest first; `residual` is the residual of the fit with `poles`.
pub(super) fn scan(
    problem: &WhitenedProblem,
    residual: &Matrix,
    poles: &[ScaledPole],
) -> Vec<ScanPeak> {
    let n = problem.lines();
    let step = problem.line_spacing;
    let uniform = is_uniform(&problem.x, step);
    let band = problem.x[n - 1] - problem.x[0];
    registers::zero_upper();
    let single = LineGroups::ungrouped(problem, residual);
    let mut peaks = Vec::new();
    for width in WIDTHS {
        let sigma = width * step;
        if sigma > 0.6 * band {
            break;
        }
        let size = (width * GROUP_HALF_WIDTHS).floor().max(1.0) as usize;
        let grouped = (size > 1).then(|| single.sum_groups(size));
        let groups = grouped.as_ref().unwrap_or(&single);
        let offsets: &[f64] = if width < 0.8 { &[0.0, 0.5] } else { &[0.0] };
        for &offset in offsets {
            let gain = groups.gains(sigma, offset, uniform);
            push_local_maxima(&gain, poles, &mut peaks);
        }
    }
    peaks.sort_by(|a: &ScanPeak, b: &ScanPeak| b.gain.total_cmp(&a.gain));
    peaks
}

/// Adds the local maxima of one width.
fn push_local_maxima(gain: &[ScanPeak], poles: &[ScaledPole], peaks: &mut Vec<ScanPeak>) {
    let mut shared = vec![0.0_f64; gain.len()];
    for pole in poles {
        let reach = (4.0 * pole.sigma * gain[0].pole.sigma / MIN_SHARED).sqrt();
        let from = gain.partition_point(|p| p.pole.w < pole.w - reach);
        let to = gain.partition_point(|p| p.pole.w <= pole.w + reach);
        for c in from..to {
            shared[c] = shared[c].max(pole.overlap(&gain[c].pole));
        }
    }
    let unshared: Vec<f64> = gain
        .iter()
        .zip(&shared)
        .map(|(peak, shared)| peak.gain / (1.0 - shared.min(MAX_SHARED)))
        .collect();
    for c in 0..gain.len() {
        let left = c == 0 || unshared[c] >= unshared[c - 1];
        let right = c + 1 == gain.len() || unshared[c] > unshared[c + 1];
        if left && right {
            peaks.push(ScanPeak {
                pole: gain[c].pole,
                gain: unshared[c],
            });
        }
    }
}

/// Sums over groups of neighbouring lines.
struct LineGroups {
    /// Mean frequency of each group.
    x: Vec<f64>,
    /// Spacing of the groups.
    step: f64,
    /// `Σ |factor|²`, with zeros before and after as in `sums`.
    weight: Vec<f64>,
    /// `Σ |factor| E`: real parts by response, then imaginary parts; rows of zeros before ([`MAX_REACH`]) and after.
    sums: Matrix,
}

/// Rows of zeros after the last group.
const TRAILING_ROWS: usize = MAX_REACH + RUN_LEN_RANGE.1;

impl LineGroups {
    /// Creates groups of single lines.
    fn ungrouped(problem: &WhitenedProblem, residual: &Matrix) -> LineGroups {
        let (n, responses) = (problem.lines(), residual.ncols());
        let size: Vec<f64> = problem.factor.iter().map(|f| f.norm_sqr().sqrt()).collect();
        let mut sums = Matrix::zeros(MAX_REACH + n + TRAILING_ROWS, 2 * responses);
        for column in 0..2 * responses {
            let half = if column < responses { 0 } else { n };
            let from = &residual.col_as_slice(column % responses)[half..half + n];
            let to = &mut sums.col_as_slice_mut(column)[MAX_REACH..MAX_REACH + n];
            for k in 0..n {
                to[k] = size[k] * from[k];
            }
        }
        let mut weight = vec![0.0; MAX_REACH + n + TRAILING_ROWS];
        for k in 0..n {
            weight[MAX_REACH + k] = size[k] * size[k];
        }
        LineGroups {
            x: problem.x.clone(),
            step: problem.line_spacing,
            weight,
            sums,
        }
    }

    /// Sums groups of `size` lines.
    fn sum_groups(&self, size: usize) -> LineGroups {
        let lines = self.x.len();
        let n = lines.div_ceil(size);
        let sum_chunks = |from: &[f64], to: &mut [f64]| {
            let groups = from[MAX_REACH..MAX_REACH + lines].chunks(size);
            for (to, group) in to[MAX_REACH..].iter_mut().zip(groups) {
                *to = group.iter().sum();
            }
        };
        let mut weight = vec![0.0; MAX_REACH + n + TRAILING_ROWS];
        sum_chunks(&self.weight, &mut weight);
        let mut sums = Matrix::zeros(MAX_REACH + n + TRAILING_ROWS, self.sums.ncols());
        for j in 0..sums.ncols() {
            sum_chunks(self.sums.col_as_slice(j), sums.col_as_slice_mut(j));
        }
        LineGroups {
            x: self
                .x
                .chunks(size)
                .map(|x| x.iter().sum::<f64>() / x.len() as f64)
                .collect(),
            step: self.step * size as f64,
            weight,
            sums,
        }
    }

    /// Gain of a pole of real part `−sigma` at each group, shifted up by `offset` group spacings.
    fn gains(&self, sigma: f64, offset: f64, uniform: bool) -> Vec<ScanPeak> {
        let n = self.x.len();
        let reach = ((CUTOFF_HALF_WIDTHS * sigma / self.step).ceil() as usize + 2).min(MAX_REACH);
        let run = (2 * reach).clamp(RUN_LEN_RANGE.0, RUN_LEN_RANGE.1);
        let span = run + 2 * reach;
        let responses = self.sums.ncols() / 2;
        let mut peaks = Vec::with_capacity(n);
        // conjugates of the Lorentzians of a run: real parts, then imaginary parts, by frequency
        let mut kernel = Matrix::zeros(2 * run, span);
        let mut square = Matrix::zeros(span, run);
        for first in (0..n).step_by(run) {
            if first == 0 || !uniform {
                for index in 0..run {
                    for tap in 0..=2 * reach {
                        let distance = if uniform {
                            (tap as f64 - reach as f64 - offset) * self.step
                        } else {
                            self.distance(first + index, tap as isize - reach as isize)
                                - offset * self.step
                        };
                        let z = lorentzian(distance, sigma);
                        kernel[(index, index + tap)] = z.re;
                        kernel[(run + index, index + tap)] = -z.im;
                        square[(index + tap, index)] = z.norm_sqr();
                    }
                }
            }
            let from = first + MAX_REACH - reach;
            let sums = &kernel * self.sums.subrows(from, span);
            registers::zero_upper();
            let weight = &self.weight[from..from + span];
            for index in 0..run.min(n - first) {
                let part = index..index + 2 * reach + 1;
                let norm: f64 = square.col_as_slice(index)[part.clone()]
                    .iter()
                    .zip(&weight[part])
                    .map(|(z, w)| z * w)
                    .sum();
                let gain: f64 = (0..responses)
                    .map(|i| {
                        let re = sums[(index, i)] - sums[(run + index, responses + i)];
                        let im = sums[(index, responses + i)] + sums[(run + index, i)];
                        re * re + im * im
                    })
                    .sum();
                peaks.push(ScanPeak {
                    pole: ScaledPole {
                        w: self.x[first + index] + offset * self.step,
                        sigma,
                        stable: true,
                    },
                    gain: if norm > 0.0 { gain / norm } else { 0.0 },
                });
            }
        }
        peaks
    }

    /// Distance from a group to the one `further` groups up, extrapolated with uniform spacing beyond the ends.
    fn distance(&self, group: usize, further: isize) -> f64 {
        let frequency = |k: isize| -> f64 {
            let last = self.x.len() as isize - 1;
            let clamped = k.clamp(0, last);
            self.x[clamped as usize] + (k - clamped) as f64 * self.step
        };
        frequency(group as isize + further) - frequency(group as isize)
    }
}

/// Lorentzian `1/(s − p)` at a distance above the pole frequency.
fn lorentzian(distance: f64, sigma: f64) -> Complex {
    Complex::new(sigma, -distance) / (sigma * sigma + distance * distance)
}
