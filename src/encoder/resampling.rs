//! Resampling to equidistant angles with a Kaiser–Bessel kernel and its compensation filter.
//!
//! Orders up to a quarter of the cells per revolution are exact to `RESAMPLING_ERROR`, which also limits aliasing. Kernel K for twofold
//! oversampling: P. J. Beatty, D. G. Nishimura, J. M. Pauly, IEEE Trans. Med. Imaging 24 (2005), 799–808, eq. 5.

use std::f64::consts::PI;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::least_squares;
use crate::spectrum::kaiser_fir::kaiser;
use crate::spectrum::rotation::angular_resampling::AngularSignal;

/// Cells per revolution for each retained order.
pub const CELLS_PER_ORDER: usize = 4;

/// Relative error of a retained order with [`MIN_PER_CELL`] or more evenly spaced values per cell.
pub const RESAMPLING_ERROR: f64 = 5e-4;

/// Minimum number of values per cell.
pub const MIN_PER_CELL: f64 = 2.0;

/// Half-width of the kernel, cells.
const KERNEL_HALF_WIDTH: usize = 3;

/// Half-width of the compensation filter, cells.
const FILTER_HALF_WIDTH: usize = 16;

/// Number of cells per filter block.
const FILTER_BLOCK: usize = 1 << 10;

/// Number of cells filtered together.
const LANES: usize = 8;

/// Cells lost at each end.
pub const EDGE_CELLS: usize = KERNEL_HALF_WIDTH + FILTER_HALF_WIDTH;

/// Width of the kernel, cells.
const KERNEL_WIDTH: usize = 2 * KERNEL_HALF_WIDTH;

/// Degree of the polynomial that approximates K in each cell, with an error of 1e-5 of the peak.
const KERNEL_DEGREE: usize = 5;

/// Smallest cell weight relative to the mean weight; cells below it are gaps.
const MIN_WEIGHT: f64 = 1e-3;

/// Kernel sums in equidistant angular cells.
pub struct AngularResampler {
    per_turn: usize,
    first: i64,
    /// Σ K and Σ K e of each cell.
    sums: Vec<[f64; 2]>,
    kernel: [[f64; KERNEL_DEGREE + 1]; KERNEL_HALF_WIDTH],
    limits: (f64, f64),
}

/// Moments Σ p^d and Σ p^d e of the values e in one cell, by degree d; p is the distance from its centre, cells.
type CellMoments = [[f64; 2]; KERNEL_DEGREE + 1];

impl AngularResampler {
    /// Creates cells for angles from `low` to `high`, revolutions.
    ///
    /// # Errors
    /// Errors of the polynomial fit of the kernel.
    pub fn new(per_turn: usize, low: f64, high: f64) -> Result<AngularResampler, Error> {
        let n = per_turn as f64;
        let first = (low * n).floor() as i64 - KERNEL_HALF_WIDTH as i64;
        let last = (high * n).ceil() as i64 + KERNEL_HALF_WIDTH as i64 + 1;
        let count = (last - first + 1).max(1) as usize;
        Ok(AngularResampler {
            per_turn,
            first,
            sums: vec![[0.0; 2]; count],
            kernel: kernel_polynomials()?,
            limits: (f64::INFINITY, f64::NEG_INFINITY),
        })
    }

    /// Adds values at angles, revolutions; angles outside the cells are ignored.
    ///
    /// K is a polynomial in each cell, so that consecutive rows in one cell are added together by their moments.
    pub fn push(&mut self, turns: &[f64], values: &[f64]) {
        let (n, first) = (self.per_turn as f64, self.first as f64);
        let end = self.sums.len();
        let (mut low, mut high) = self.limits;
        // Centre of the cell of the preceding rows.
        let mut centre = f64::NAN;
        let mut moments = CellMoments::default();
        for (&x, &value) in turns.iter().zip(values) {
            let u = x * n - first;
            if !((u - centre).abs() <= 0.5) {
                self.spread(centre, moments);
                moments = CellMoments::default();
                let cell = u as usize;
                if cell < KERNEL_HALF_WIDTH || cell + KERNEL_HALF_WIDTH >= end {
                    centre = f64::NAN;
                    continue;
                }
                centre = cell as f64 + 0.5;
            }
            let offset = u - centre;
            let mut power = [1.0, value];
            for sum in &mut moments {
                *sum = [sum[0] + power[0], sum[1] + power[1]];
                power = power.map(|x| x * offset);
            }
            low = if u < low { u } else { low };
            high = if u > high { u } else { high };
        }
        self.spread(centre, moments);
        self.limits = (low, high);
    }

    /// Adds the moments of the cell centred at `centre` to the cells within the kernel; no cell if `centre` is NaN.
    fn spread(&mut self, centre: f64, moments: CellMoments) {
        if centre.is_nan() {
            return;
        }
        let first = centre as usize + 1 - KERNEL_HALF_WIDTH;
        let (lower, upper) = self.sums[first..first + KERNEL_WIDTH].split_at_mut(KERNEL_HALF_WIDTH);
        for (j, (below, above)) in lower.iter_mut().zip(upper.iter_mut().rev()).enumerate() {
            // K is even: the mirrored cell has the same polynomial of −p.
            let [a, b, c, d, e, f] = self.kernel[j];
            let [m0, m1, m2, m3, m4, m5] = moments;
            for k in 0..2 {
                let even = a * m0[k] + c * m2[k] + e * m4[k];
                let odd = b * m1[k] + d * m3[k] + f * m5[k];
                below[k] += even + odd;
                above[k] += even - odd;
            }
        }
    }

    /// Returns the longest segment without gaps, at equidistant angles.
    ///
    /// # Errors
    /// `TooShort`: no segment is longer than its ends.
    pub fn finish(self) -> Result<AngularSignal, Error> {
        let filter = compensation_filter()?;
        let low = (self.limits.0.ceil().max(0.0) as usize).saturating_add(KERNEL_HALF_WIDTH);
        let high = (self.limits.1.floor().max(0.0) as usize)
            .saturating_sub(KERNEL_HALF_WIDTH)
            .min(self.sums.len() - 1);
        let too_short = || {
            let message = "the record has no segment of angle without a gap";
            Error::new(Code::TooShort, message).with_hint("take a longer segment of the record")
        };
        if low >= high {
            return Err(too_short());
        }
        let cells = &self.sums[low..=high];
        let minimum = MIN_WEIGHT * cells.iter().map(|s| s[0]).sum::<f64>() / cells.len() as f64;
        let (mut longest, mut start) = (low..low, low);
        for m in low..=high + 1 {
            if m > high || self.sums[m][0] <= minimum {
                if m - start > longest.len() {
                    longest = start..m;
                }
                start = m + 1;
            }
        }
        if longest.len() <= 2 * FILTER_HALF_WIDTH {
            return Err(too_short());
        }
        let count = longest.len() - 2 * FILTER_HALF_WIDTH;
        let first = self.first + (longest.start + FILTER_HALF_WIDTH) as i64;
        let mut values = Vec::with_capacity(count + LANES);
        let mut raw = Vec::new();
        for start in (0..count).step_by(FILTER_BLOCK) {
            let block = FILTER_BLOCK.min(count - start).next_multiple_of(LANES);
            let sums = &self.sums[longest.start + start..];
            raw.clear();
            raw.extend((sums.iter().take(block + 2 * FILTER_HALF_WIDTH)).map(|s| s[1] / s[0]));
            raw.resize(block + 2 * FILTER_HALF_WIDTH, 0.0);
            for i in (0..block).step_by(LANES) {
                let mut filtered = [0.0; LANES];
                for (j, weight) in filter.iter().enumerate() {
                    let lower = &raw[i + FILTER_HALF_WIDTH - j..][..LANES];
                    let upper = &raw[i + FILTER_HALF_WIDTH + j..][..LANES];
                    for k in 0..LANES {
                        filtered[k] += weight * (lower[k] + upper[k]);
                    }
                }
                values.extend(filtered);
            }
        }
        values.truncate(count);
        Ok(AngularSignal {
            samples_per_rev: self.per_turn,
            first,
            values,
        })
    }
}

/// Shape parameter of the Kaiser window for six cells and twofold oversampling.
fn kaiser_beta() -> f64 {
    let width = 2.0 * KERNEL_HALF_WIDTH as f64;
    PI * ((0.5 * width * 1.5).powi(2) - 0.8).sqrt()
}

/// Polynomials `Σ_d k_dj p^d` of K in the cells j up to that of a value; p is the distance of the value from the centre of its cell.
fn kernel_polynomials() -> Result<[[f64; KERNEL_DEGREE + 1]; KERNEL_HALF_WIDTH], Error> {
    let count = KERNEL_DEGREE + 1;
    // Chebyshev nodes within half a cell on each side.
    let node = |i: usize| 0.5 * (PI * (i as f64 + 0.5) / count as f64).cos();
    let distance = |i: usize, j: usize| node(i) + KERNEL_HALF_WIDTH as f64 - 0.5 - j as f64;
    let powers = Matrix::from_fn(count, count, |i, d| node(i).powi(d as i32));
    let kernel = Matrix::from_fn(count, KERNEL_HALF_WIDTH, |i, j| {
        kaiser(distance(i, j) / KERNEL_HALF_WIDTH as f64, kaiser_beta())
    });
    let x = least_squares::solve(&powers, &kernel)?;
    Ok(std::array::from_fn(|j| std::array::from_fn(|d| x[(d, j)])))
}

/// Gain of the window, its Fourier transform normalised to 1 at zero; `frequency` in cycles per cell.
fn window_gain(frequency: f64) -> f64 {
    let shape = |f: f64| {
        let z = (PI * 2.0 * KERNEL_HALF_WIDTH as f64 * f).powi(2) - kaiser_beta().powi(2);
        let root = z.abs().sqrt();
        match z < 0.0 {
            true => root.sinh() / root,
            false => root.sin() / root,
        }
    };
    shape(frequency) / shape(0.0)
}

/// One side of the symmetric filter that compensates [`window_gain`] up to 1/4 cycle per cell and attenuates above 3/8; the first weight
/// is half the central one.
fn compensation_filter() -> Result<Vec<f64>, Error> {
    const POINTS: usize = 160;
    /// Relative weight of the stop band.
    const STOP_BAND: f64 = 0.03;
    let points: Vec<(f64, bool)> = (0..=POINTS)
        .map(|i| 0.5 * i as f64 / POINTS as f64)
        .filter(|f| !(0.25..0.375).contains(f) || *f == 0.25)
        .map(|f| (f, f <= 0.25))
        .collect();
    let scale = |(f, is_pass): (f64, bool)| window_gain(f) * if is_pass { 1.0 } else { STOP_BAND };
    let a = Matrix::from_fn(points.len(), FILTER_HALF_WIDTH + 1, |i, j| {
        scale(points[i]) * 2.0 * (2.0 * PI * points[i].0 * j as f64).cos()
    });
    let b = Matrix::from_fn(points.len(), 1, |i, _| if points[i].1 { 1.0 } else { 0.0 });
    let x = least_squares::solve(&a, &b)?;
    let mut weights: Vec<f64> = (0..=FILTER_HALF_WIDTH).map(|j| x[(j, 0)]).collect();
    // The gain at zero is exactly 1.
    let sum = 2.0 * weights.iter().sum::<f64>();
    weights.iter_mut().for_each(|w| *w /= sum);
    Ok(weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Waves of orders up to a quarter of the cells have the stated error at varying speed, from two values per cell.
    #[test]
    fn law_orders_are_kept() {
        let per_turn = 240;
        for per_cell in [2.2, 3.7, 11.0] {
            for order in [1.0, 17.3, 40.0, 60.0] {
                let rows = (3.0 * per_cell * per_turn as f64) as usize;
                let turns: Vec<f64> = (0..rows)
                    .map(|i| {
                        let t = i as f64 / (per_cell * per_turn as f64);
                        t + 2e-3 * (TAU * 1.3 * t).sin()
                    })
                    .collect();
                let wave = |x: f64| (TAU * order * x + 0.7).cos();
                let values: Vec<f64> = turns.iter().map(|&x| wave(x)).collect();
                let mut cells = AngularResampler::new(per_turn, 0.0, 3.0).unwrap();
                cells.push(&turns, &values);
                let signal = cells.finish().unwrap();
                assert!(signal.values.len() > 2 * per_turn);
                for (i, v) in signal.values.iter().enumerate() {
                    let error = (v - wave(signal.angle(i) / TAU)).abs();
                    assert!(
                        error < RESAMPLING_ERROR,
                        "{order} at {per_cell} a cell: {error:e}"
                    );
                }
            }
        }
    }

    /// Orders above three quarters of the cells do not alias onto the retained ones.
    #[test]
    fn law_high_orders_do_not_fold() {
        let (per_turn, order) = (240, 203.0);
        let turns: Vec<f64> = (0..9000).map(|i| f64::from(i) / 3000.0).collect();
        let values: Vec<f64> = turns.iter().map(|x| (TAU * order * x).cos()).collect();
        let mut cells = AngularResampler::new(per_turn, 0.0, 3.0).unwrap();
        cells.push(&turns, &values);
        let signal = cells.finish().unwrap();
        let count = 2 * per_turn;
        let folded_order = (per_turn as f64 - order) / per_turn as f64;
        let (mut re, mut im) = (0.0, 0.0);
        for (i, v) in signal.values[..count].iter().enumerate() {
            let (s, c) = (TAU * folded_order * i as f64).sin_cos();
            (re, im) = (re + v * c, im + v * s);
        }
        let alias = 2.0 * f64::hypot(re, im) / count as f64;
        assert!(alias < RESAMPLING_ERROR, "{alias:e}");
    }

    #[test]
    fn refuses_nothing() {
        let cells = AngularResampler::new(100, 0.0, 1.0).unwrap();
        assert_eq!(cells.finish().unwrap_err().code, Code::TooShort);
        let mut cells = AngularResampler::new(100, 0.0, 1.0).unwrap();
        cells.push(&[0.5, f64::NAN, 7.0], &[1.0; 3]);
        assert_eq!(cells.finish().unwrap_err().code, Code::TooShort);
    }
}
