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

/// Cells lost at either end.
pub const EDGE_CELLS: usize = KERNEL_HALF_WIDTH + FILTER_HALF_WIDTH;

/// Steps of the table to a cell; straight lines between them are off by 1e-5 of the peak.
const TABLE_STEPS: usize = 512;

/// A cell with less than this share of the mean weight is a hole.
const MIN_WEIGHT: f64 = 1e-3;

/// Sums in even cells.
pub struct AngularResampler {
    per_turn: usize,
    first: i64,
    /// Σ K and Σ K e.
    sums: Vec<[f64; 2]>,
    table: Vec<[f64; 2 * KERNEL_HALF_WIDTH]>,
    within: (f64, f64),
}

impl AngularResampler {
    /// Room for angles from `low` to `high`, turns.
    pub fn new(per_turn: usize, low: f64, high: f64) -> AngularResampler {
        let n = per_turn as f64;
        let first = (low * n).floor() as i64 - KERNEL_HALF_WIDTH as i64;
        let last = (high * n).ceil() as i64 + KERNEL_HALF_WIDTH as i64 + 1;
        let count = (last - first + 1).max(1) as usize;
        let shape = kaiser_beta();
        let row = |k: usize| {
            let part = k as f64 / TABLE_STEPS as f64;
            std::array::from_fn(|j| {
                let distance =
                    (part + (KERNEL_HALF_WIDTH - 1) as f64 - j as f64) / KERNEL_HALF_WIDTH as f64;
                if distance.abs() < 1.0 {
                    kaiser(distance, shape)
                } else {
                    0.0
                }
            })
        };
        AngularResampler {
            per_turn,
            first,
            sums: vec![[0.0; 2]; count],
            table: (0..=TABLE_STEPS).map(row).collect(),
            within: (f64::INFINITY, f64::NEG_INFINITY),
        }
    }

    /// Adds values at angles, turns; those outside the room are passed over.
    pub fn push(&mut self, turns: impl Iterator<Item = f64>, values: &[f64]) {
        let (n, first) = (self.per_turn as f64, self.first as f64);
        let end = self.sums.len();
        for (x, &value) in turns.zip(values) {
            let u = x * n - first;
            // Whole cells: u is no less than REACH where it counts.
            let cell = u as usize;
            let from = cell + 1;
            if cell < KERNEL_HALF_WIDTH || from + KERNEL_HALF_WIDTH > end {
                continue;
            }
            let fine = (u - cell as f64) * TABLE_STEPS as f64;
            let at = fine as usize;
            let part = fine - at as f64;
            let (low, high) = (&self.table[at], &self.table[at + 1]);
            let sums = &mut self.sums[from - KERNEL_HALF_WIDTH..from + KERNEL_HALF_WIDTH];
            for ((low, high), [weight, sum]) in low.iter().zip(high).zip(sums) {
                let w = low + part * (high - low);
                *weight += w;
                *sum += w * value;
            }
            self.within.0 = self.within.0.min(u);
            self.within.1 = self.within.1.max(u);
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
        let raw: Vec<f64> = best
            .clone()
            .map(|m| self.sums[m][1] / self.sums[m][0])
            .collect();
        let value = |i: usize| {
            let middle = filter[0] * raw[i];
            let sides = (1..=FILTER_HALF_WIDTH).map(|j| filter[j] * (raw[i - j] + raw[i + j]));
            middle + sides.sum::<f64>()
        };
        Ok(AngularSignal {
            samples_per_rev: self.per_turn,
            first: self.first + (best.start + FILTER_HALF_WIDTH) as i64,
            values: (FILTER_HALF_WIDTH..raw.len() - FILTER_HALF_WIDTH)
                .map(value)
                .collect(),
        })
    }
}

/// Shape of the window for six cells and twice the cells needed.
fn kaiser_beta() -> f64 {
    let width = 2.0 * KERNEL_HALF_WIDTH as f64;
    PI * ((0.5 * width * 1.5).powi(2) - 0.8).sqrt()
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

/// Weights of the symmetric filter that undoes [`window_gain`] up to a quarter of a cycle a cell and leaves little above three eighths.
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
        let wave = match j {
            0 => 1.0,
            j => 2.0 * (2.0 * PI * points[i].0 * j as f64).cos(),
        };
        scale(points[i]) * wave
    });
    let b = Matrix::from_fn(points.len(), 1, |i, _| if points[i].1 { 1.0 } else { 0.0 });
    let x = least_squares::solve(&a, &b)?;
    let mut weights: Vec<f64> = (0..=FILTER_HALF_WIDTH).map(|j| x[(j, 0)]).collect();
    // A constant stays what it is, exactly.
    let sum = weights[0] + 2.0 * weights[1..].iter().sum::<f64>();
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
                let mut cells = AngularResampler::new(per_turn, 0.0, 3.0);
                cells.push(turns.iter().copied(), &values);
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
        let mut cells = AngularResampler::new(per_turn, 0.0, 3.0);
        cells.push(turns.iter().copied(), &values);
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
        let cells = AngularResampler::new(100, 0.0, 1.0);
        assert_eq!(cells.finish().unwrap_err().code, Code::TooShort);
        let mut cells = AngularResampler::new(100, 0.0, 1.0);
        cells.push([0.5, f64::NAN, 7.0].into_iter(), &[1.0; 3]);
        assert_eq!(cells.finish().unwrap_err().code, Code::TooShort);
    }
}
