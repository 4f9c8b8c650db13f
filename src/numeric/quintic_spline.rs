//! Interpolating quintic splines, C⁴: `y‴` and `y⁗` continuous at every knot (de Boor, A Practical Guide to Splines, rev. ed. 2001, ch. XIII).
//!
//! The error falls as h⁶, that of the k-th derivative as h⁶⁻ᵏ.

use super::small_dense;

/// Points that fix the slope and second derivative at an end.
const END_POINTS: usize = 7;
/// A disturbance at one knot of equal spacing decays by 0.43 a knot, so after 48 knots it is rounding.
const DECAY_KNOTS: usize = 48;

/// Quintic spline through given points.
#[derive(Debug, Clone)]
pub struct QuinticSpline {
    knots: Vec<f64>,
    /// Value, first and second derivative at each knot.
    jets: Vec<[f64; 3]>,
    period: Option<Period>,
}

/// Repetition of a periodic spline: `y(x + length) = y(x) + advance`.
#[derive(Debug, Clone, Copy)]
struct Period {
    length: f64,
    advance: f64,
}

impl QuinticSpline {
    /// The spline through (x, y), slope and second derivative at the ends those of the polynomial through seven points; `None` for fewer
    /// points, unequal lengths, x that do not rise or numbers that are not finite.
    pub fn interpolate(x: &[f64], y: &[f64]) -> Option<QuinticSpline> {
        if x.len() < END_POINTS || x.len() != y.len() || !rises(x) {
            return None;
        }
        if !y.iter().all(|y| y.is_finite()) {
            return None;
        }
        let n = x.len();
        let first = end_derivatives(&x[..END_POINTS], &y[..END_POINTS], x[0]);
        let tail = n - END_POINTS;
        let last = end_derivatives(&x[tail..], &y[tail..], x[n - 1]);
        Some(QuinticSpline {
            knots: x.to_vec(),
            jets: solve_knots(x, y, first, last),
            period: None,
        })
    }

    /// The spline with `y(x + L) = y(x) + y_n − y₀`, L from the first x to the last; `None` as for [`QuinticSpline::interpolate`], but from
    /// three points.
    pub fn periodic(x: &[f64], y: &[f64]) -> Option<QuinticSpline> {
        if x.len() < 3 || x.len() != y.len() || !rises(x) || !y.iter().all(|y| y.is_finite()) {
            return None;
        }
        let n = x.len() - 1;
        let period = Period {
            length: x[n] - x[0],
            advance: y[n] - y[0],
        };
        let row = |i: isize| {
            let (turn, at) = (
                i.div_euclid(n as isize) as f64,
                i.rem_euclid(n as isize) as usize,
            );
            (x[at] + turn * period.length, y[at] + turn * period.advance)
        };
        let reach = DECAY_KNOTS as isize;
        let (wide_x, wide_y): (Vec<f64>, Vec<f64>) = (-reach..=n as isize + reach).map(row).unzip();
        let wide = QuinticSpline::interpolate(&wide_x, &wide_y)?;
        Some(QuinticSpline {
            knots: x.to_vec(),
            jets: wide.jets[DECAY_KNOTS..=DECAY_KNOTS + n].to_vec(),
            period: Some(period),
        })
    }

    /// The knots.
    pub fn knots(&self) -> &[f64] {
        &self.knots
    }

    /// `[y, y′, y″, y‴]` at x; beyond the ends the last polynomial goes on.
    pub fn at(&self, x: f64) -> [f64; 4] {
        let (mut x, mut shift) = (x, 0.0);
        if let Some(period) = self.period {
            let turns = ((x - self.knots[0]) / period.length).floor();
            x -= turns * period.length;
            shift = turns * period.advance;
        }
        let i = self.knots.partition_point(|knot| *knot <= x);
        let i = i.clamp(1, self.knots.len() - 1) - 1;
        let h = self.knots[i + 1] - self.knots[i];
        let ([y0, d0, m0], [y1, d1, m1]) = (self.jets[i], self.jets[i + 1]);
        let (d0, d1, m0, m1) = (h * d0, h * d1, h * h * m0, h * h * m1);
        let (t, rise) = ((x - self.knots[i]) / h, y1 - y0);
        let a3 = 10.0 * rise - 6.0 * d0 - 4.0 * d1 - 1.5 * m0 + 0.5 * m1;
        let a4 = -15.0 * rise + 8.0 * d0 + 7.0 * d1 + 1.5 * m0 - m1;
        let a5 = 6.0 * rise - 3.0 * (d0 + d1) - 0.5 * (m0 - m1);
        [
            shift + y0 + t * (d0 + t * (0.5 * m0 + t * (a3 + t * (a4 + t * a5)))),
            (d0 + t * (m0 + t * (3.0 * a3 + t * (4.0 * a4 + t * 5.0 * a5)))) / h,
            (m0 + t * (6.0 * a3 + t * (12.0 * a4 + t * 20.0 * a5))) / (h * h),
            (6.0 * a3 + t * (24.0 * a4 + t * 60.0 * a5)) / (h * h * h),
        ]
    }
}

fn rises(x: &[f64]) -> bool {
    x.iter().all(|x| x.is_finite()) && x.windows(2).all(|pair| pair[1] > pair[0])
}

/// First and second derivative at `at` of the polynomial through the points.
fn end_derivatives(x: &[f64], y: &[f64], at: f64) -> [f64; 2] {
    let n = x.len();
    let scale = x[n - 1] - x[0];
    let mut a = vec![0.0; n * n];
    for (i, x) in x.iter().enumerate() {
        let t = (x - at) / scale;
        (0..n).for_each(|j| a[i * n + j] = t.powi(j as i32));
    }
    let mut c = y.to_vec();
    small_dense::solve(&mut a, &mut c);
    [c[1] / scale, 2.0 * c[2] / (scale * scale)]
}

type Block = [[f64; 2]; 2];

/// Slopes and second derivatives at the knots by block elimination.
fn solve_knots(x: &[f64], y: &[f64], first: [f64; 2], last: [f64; 2]) -> Vec<[f64; 3]> {
    let n = x.len();
    let mut jets: Vec<[f64; 3]> = y.iter().map(|y| [*y, 0.0, 0.0]).collect();
    [jets[0][1], jets[0][2]] = first;
    [jets[n - 1][1], jets[n - 1][2]] = last;
    // After elimination: unknowns_i = rest_i − upper_i unknowns_{i+1}.
    let mut upper: Vec<Block> = vec![[[0.0; 2]; 2]];
    let mut rest: Vec<[f64; 2]> = vec![first];
    for i in 1..n - 1 {
        let (h0, h1) = (x[i] - x[i - 1], x[i + 1] - x[i]);
        let (rise0, rise1) = (y[i] - y[i - 1], y[i + 1] - y[i]);
        // Jumps of y‴ and y⁗, times h0² and h0³: zero.
        let q = h0 / h1;
        let (q2, q3) = (q * q, q * q * q);
        let lower = [[24.0, 3.0 * h0], [168.0, 24.0 * h0]];
        let mut middle = [
            [36.0 - 36.0 * q2, -9.0 * h0 * (1.0 + q)],
            [192.0 + 192.0 * q3, -36.0 * h0 + 36.0 * h0 * q2],
        ];
        let next = [[-24.0 * q2, 3.0 * h0 * q], [168.0 * q3, -24.0 * h0 * q2]];
        let mut right = [
            60.0 * (rise0 - rise1 * q3) / h0,
            360.0 * (rise0 + rise1 * q3 * q) / h0,
        ];
        for r in 0..2 {
            for k in 0..2 {
                right[r] -= lower[r][k] * rest[i - 1][k];
                for c in 0..2 {
                    middle[r][c] -= lower[r][k] * upper[i - 1][k][c];
                }
            }
        }
        let column = |c: usize| solve_block(middle, [next[0][c], next[1][c]]);
        let (left, second) = (column(0), column(1));
        upper.push([[left[0], second[0]], [left[1], second[1]]]);
        rest.push(solve_block(middle, right));
    }
    for i in (1..n - 1).rev() {
        let [_, d, m] = jets[i + 1];
        for r in 0..2 {
            jets[i][r + 1] = rest[i][r] - upper[i][r][0] * d - upper[i][r][1] * m;
        }
    }
    jets
}

fn solve_block(a: Block, b: [f64; 2]) -> [f64; 2] {
    let mut entries = [a[0][0], a[0][1], a[1][0], a[1][1]];
    let mut x = b;
    small_dense::solve(&mut entries, &mut x);
    x
}
