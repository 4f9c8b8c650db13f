//! Resampling to even angles with a Kaiser–Bessel kernel and its compensation filter.
//!
//! Kept within `RESAMPLING_ERROR` are orders up to a quarter of the cells a turn; what would fold onto them is as far down. K and its shape for
//! twice as many cells as needed: P. J. Beatty, D. G. Nishimura, J. M. Pauly, IEEE Trans. Med. Imaging 24 (2005), 799–808, eq. 5.

use std::f64::consts::PI;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Matrix;
use crate::numeric::least_squares;
use crate::spectrum::kaiser_fir::kaiser;
use crate::spectrum::rotation::angular_resampling::AngularSignal;

/// Cells for each order kept.
pub const CELLS_PER_ORDER: usize = 4;

/// Relative error of a retained order, where two or more values fall into each cell evenly.
pub const RESAMPLING_ERROR: f64 = 5e-4;

/// Values that fall into a cell at least.
pub const MIN_PER_CELL: f64 = 2.0;

/// Cells on either side that a value is spread over.
const KERNEL_HALF_WIDTH: usize = 3;

/// Cells that the filter reaches on either side.
const FILTER_HALF_WIDTH: usize = 16;

/// Cells filtered from one quotient of sums, and at a time.
const FILTERED: usize = 1 << 10;

/// See [`FILTERED`].
const LANES: usize = 8;

/// Cells lost at either end.
pub const EDGE_CELLS: usize = KERNEL_HALF_WIDTH + FILTER_HALF_WIDTH;

/// Cells that a value is spread over.
const KERNEL_WIDTH: usize = 2 * KERNEL_HALF_WIDTH;

/// Degree of the polynomial that K is in each cell, off by 1e-5 of the peak.
const KERNEL_DEGREE: usize = 5;

/// A cell with less than this share of the mean weight is a hole.
const MIN_WEIGHT: f64 = 1e-3;

/// Sums in even cells.
pub struct AngularResampler {
    per_turn: usize,
    first: i64,
    /// Σ K and Σ K e.
    sums: Vec<[f64; 2]>,
    kernel: [[f64; KERNEL_DEGREE + 1]; KERNEL_HALF_WIDTH],
    within: (f64, f64),
}

/// Σ p^d and Σ p^d e of the values in one cell, by degree d; p is their place in cells from its middle.
type CellMoments = [[f64; 2]; KERNEL_DEGREE + 1];

impl AngularResampler {
    /// Room for angles from `low` to `high`, turns.
    ///
    /// # Errors
    /// Those of the fit of the kernel.
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
            within: (f64::INFINITY, f64::NEG_INFINITY),
        })
    }

    /// Adds values at angles, turns; those outside the room are passed over.
    ///
    /// K is a polynomial in each cell, so that neighbouring rows in one cell are spread together by their moments.
    pub fn push(&mut self, turns: &[f64], values: &[f64]) {
        let (n, first) = (self.per_turn as f64, self.first as f64);
        let end = self.sums.len();
        let (mut low, mut high) = self.within;
        // The middle of the cell that the rows before lie in.
        let mut middle = f64::NAN;
        let mut moments = CellMoments::default();
        for (&x, &value) in turns.iter().zip(values) {
            let u = x * n - first;
            if !((u - middle).abs() <= 0.5) {
                self.spread(middle, moments);
                moments = CellMoments::default();
                let cell = u as usize;
                if cell < KERNEL_HALF_WIDTH || cell + KERNEL_HALF_WIDTH >= end {
                    middle = f64::NAN;
                    continue;
                }
                middle = cell as f64 + 0.5;
            }
            let place = u - middle;
            let mut power = [1.0, value];
            for sum in &mut moments {
                *sum = [sum[0] + power[0], sum[1] + power[1]];
                power = power.map(|x| x * place);
            }
            low = if u < low { u } else { low };
            high = if u > high { u } else { high };
        }
        self.spread(middle, moments);
        self.within = (low, high);
    }

    /// Adds the values of the cell about `middle`, if there is one, to the cells that the kernel reaches.
    fn spread(&mut self, middle: f64, moments: CellMoments) {
        if middle.is_nan() {
            return;
        }
        let from = middle as usize + 1 - KERNEL_HALF_WIDTH;
        let (before, after) = self.sums[from..from + KERNEL_WIDTH].split_at_mut(KERNEL_HALF_WIDTH);
        for (j, (near, far)) in before.iter_mut().zip(after.iter_mut().rev()).enumerate() {
            // K is even: the cell as far on the other side has the same polynomial of −p.
            let [a, b, c, d, e, f] = self.kernel[j];
            let [m0, m1, m2, m3, m4, m5] = moments;
            for k in 0..2 {
                let even = a * m0[k] + c * m2[k] + e * m4[k];
                let odd = b * m1[k] + d * m3[k] + f * m5[k];
                near[k] += even + odd;
                far[k] += even - odd;
            }
        }
    }

    /// The longest piece without a hole, at even angles.
    ///
    /// # Errors
    /// `TooShort`: nothing is left between the ends.
    pub fn finish(self) -> Result<AngularSignal, Error> {
        let filter = compensation_filter()?;
        let low = (self.within.0.ceil().max(0.0) as usize).saturating_add(KERNEL_HALF_WIDTH);
        let high = (self.within.1.floor().max(0.0) as usize)
            .saturating_sub(KERNEL_HALF_WIDTH)
            .min(self.sums.len() - 1);
        let empty = || {
            let message = "the record covers no segment of angle without a hole";
            Error::new(Code::TooShort, message).with_hint("take a longer segment of the record")
        };
        if low >= high {
            return Err(empty());
        }
        let inside = &self.sums[low..=high];
        let least = MIN_WEIGHT * inside.iter().map(|s| s[0]).sum::<f64>() / inside.len() as f64;
        let (mut best, mut start) = (low..low, low);
        for m in low..=high + 1 {
            if m > high || self.sums[m][0] <= least {
                if m - start > best.len() {
                    best = start..m;
                }
                start = m + 1;
            }
        }
        if best.len() <= 2 * FILTER_HALF_WIDTH {
            return Err(empty());
        }
        let count = best.len() - 2 * FILTER_HALF_WIDTH;
        let first = self.first + (best.start + FILTER_HALF_WIDTH) as i64;
        let mut values = Vec::with_capacity(count + LANES);
        let mut raw = Vec::new();
        for start in (0..count).step_by(FILTERED) {
            let block = FILTERED.min(count - start).next_multiple_of(LANES);
            let sums = &self.sums[best.start + start..];
            raw.clear();
            raw.extend((sums.iter().take(block + 2 * FILTER_HALF_WIDTH)).map(|s| s[1] / s[0]));
            raw.resize(block + 2 * FILTER_HALF_WIDTH, 0.0);
            for i in (0..block).step_by(LANES) {
                let mut filtered = [0.0; LANES];
                for (j, weight) in filter.iter().enumerate() {
                    let before = &raw[i + FILTER_HALF_WIDTH - j..][..LANES];
                    let after = &raw[i + FILTER_HALF_WIDTH + j..][..LANES];
                    for k in 0..LANES {
                        filtered[k] += weight * (before[k] + after[k]);
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

/// Shape of the window for six cells and twice the cells needed.
fn kaiser_beta() -> f64 {
    let width = 2.0 * KERNEL_HALF_WIDTH as f64;
    PI * ((0.5 * width * 1.5).powi(2) - 0.8).sqrt()
}

/// K in the cells before that of a value and in its own, `Σ_d k_dj p^d` in cell j, p being the place of the value from the middle of its own.
fn kernel_polynomials() -> Result<[[f64; KERNEL_DEGREE + 1]; KERNEL_HALF_WIDTH], Error> {
    let count = KERNEL_DEGREE + 1;
    // Chebyshev's points of half a cell on either side.
    let place = |i: usize| 0.5 * (PI * (i as f64 + 0.5) / count as f64).cos();
    let distance = |i: usize, j: usize| place(i) + KERNEL_HALF_WIDTH as f64 - 0.5 - j as f64;
    let powers = Matrix::from_fn(count, count, |i, d| place(i).powi(d as i32));
    let kernel = Matrix::from_fn(count, KERNEL_HALF_WIDTH, |i, j| {
        kaiser(distance(i, j) / KERNEL_HALF_WIDTH as f64, kaiser_beta())
    });
    let x = least_squares::solve(&powers, &kernel)?;
    Ok(std::array::from_fn(|j| std::array::from_fn(|d| x[(d, j)])))
}

/// Window gain for a wave, by cycles a cell: its Fourier transform, 1 at zero.
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

/// Weights of the symmetric filter that undoes [`window_gain`] up to a quarter of a cycle a cell and leaves little above three eighths; of
/// either side, half of the middle one to each.
fn compensation_filter() -> Result<Vec<f64>, Error> {
    const POINTS: usize = 160;
    /// Relative weight of the orders above.
    const ABOVE: f64 = 0.03;
    let points: Vec<(f64, bool)> = (0..=POINTS)
        .map(|i| 0.5 * i as f64 / POINTS as f64)
        .filter(|f| !(0.25..0.375).contains(f) || *f == 0.25)
        .map(|f| (f, f <= 0.25))
        .collect();
    let scale = |(f, kept): (f64, bool)| window_gain(f) * if kept { 1.0 } else { ABOVE };
    let a = Matrix::from_fn(points.len(), FILTER_HALF_WIDTH + 1, |i, j| {
        scale(points[i]) * 2.0 * (2.0 * PI * points[i].0 * j as f64).cos()
    });
    let b = Matrix::from_fn(points.len(), 1, |i, _| if points[i].1 { 1.0 } else { 0.0 });
    let x = least_squares::solve(&a, &b)?;
    let mut weights: Vec<f64> = (0..=FILTER_HALF_WIDTH).map(|j| x[(j, 0)]).collect();
    // A constant stays what it is, exactly.
    let sum = 2.0 * weights.iter().sum::<f64>();
    weights.iter_mut().for_each(|w| *w /= sum);
    Ok(weights)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// Waves up to a quarter of the cells come out within the stated error, at an uneven speed, from two values a cell on.
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
                    let off = (v - wave(signal.angle(i) / TAU)).abs();
                    assert!(
                        off < RESAMPLING_ERROR,
                        "{order} at {per_cell} a cell: {off:e}"
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
        let whole = 2 * per_turn;
        let folded = (per_turn as f64 - order) / per_turn as f64;
        let (mut re, mut im) = (0.0, 0.0);
        for (i, v) in signal.values[..whole].iter().enumerate() {
            let (s, c) = (TAU * folded * i as f64).sin_cos();
            (re, im) = (re + v * c, im + v * s);
        }
        let left = 2.0 * f64::hypot(re, im) / whole as f64;
        assert!(left < RESAMPLING_ERROR, "{left:e}");
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
