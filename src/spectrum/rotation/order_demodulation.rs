//! Streaming order tracking by least squares per window: `x ≈ a + b φ + Σ Aₙ cos(n φ + ψₙ)`.
//!
//! The weight is a Hann window over the shaft angle, `sin²(πu)`, overlapping by half, times the speed, so that equal angles have equal
//! weight. The straight line separates mean and trend from the orders; a joint solution separates the orders of a window from each other.

use std::f64::consts::{PI, TAU};

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::{Complex, Matrix, symmetric};

/// Default maximum number of points; at the maximum, adjacent points are averaged.
const MAX_POINTS: usize = 4096;

/// Minimum number of samples in a window per unknown; fewer do not separate orders from their aliases.
const MIN_SAMPLES_PER_UNKNOWN: usize = 4;

/// Least-squares demodulator of orders in several channels over the angle of a shaft.
pub struct OrderDemodulator {
    orders: Vec<f64>,
    revolutions: f64,
    channels: usize,
    max_points: usize,
    windows: Vec<TrackWindow>,
    /// Shaft angle, rad, and sense of rotation at the last sample.
    last: Option<(f64, f64)>,
    /// Revolutions so far, in either sense.
    elapsed_revolutions: f64,
    /// Start of the next window, revolutions.
    next_start: f64,
    tracks: DemodulatedOrders,
}

/// Demodulated orders over time.
#[derive(Debug, Clone, PartialEq)]
pub struct DemodulatedOrders {
    /// Orders, cycles per revolution.
    pub orders: Vec<f64>,
    /// Averaging length of each point, revolutions.
    pub revolutions: f64,
    /// Points in order of time.
    pub points: Vec<OrderPoint>,
    /// Number of windows with too few samples.
    pub skipped_windows: usize,
}

/// Complex amplitudes of the orders in one window.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderPoint {
    /// Weighted mean time of the window, s.
    pub time_s: f64,
    /// Weighted mean speed of the shaft, rad/s.
    pub speed: f64,
    /// Complex amplitude `A e^{iψ}` by channel and order.
    pub values: Vec<Vec<Complex>>,
}

/// Normal equations of one window.
struct TrackWindow {
    start: f64,
    /// Shaft angle at the start, rad.
    start_angle: f64,
    samples: usize,
    gram: Matrix,
    right_side: Matrix,
    /// Sums of weight, weight × time and weight × speed.
    sums: [f64; 3],
}

impl OrderDemodulator {
    /// Demodulator of `orders` in `channels` channels over windows of `turns` revolutions.
    ///
    /// # Errors
    /// `OutOfRange`: no orders; orders not above zero, or closer than the order resolution 2/turns of the window; no window.
    pub fn new(orders: &[f64], turns: f64, channels: usize) -> Result<OrderDemodulator, Error> {
        let refuse = |message: String, hint: String| {
            Err(Error::new(Code::OutOfRange, message).with_hint(hint))
        };
        if !(turns > 0.0 && turns.is_finite()) {
            return refuse(
                format!("a window of {turns} revolutions is too short for orders"),
                "take 1 revolution or more".into(),
            );
        }
        let mut sorted = orders.to_vec();
        sorted.sort_by(f64::total_cmp);
        let Some(&first) = sorted.first() else {
            return refuse(
                "no orders were requested".into(),
                "give at least one order".into(),
            );
        };
        if !(first > 0.0 && sorted.iter().all(|n| n.is_finite())) {
            return refuse(
                format!("order {first} is not above zero"),
                "give orders above zero".into(),
            );
        }
        let gap = sorted.windows(2).map(|p| p[1] - p[0]).fold(first, f64::min);
        if gap * turns < 2.0 {
            return refuse(
                format!("orders {gap} apart (or from zero) are not separated over {turns} turns"),
                format!("take at least {} turns", (2.0 / gap).ceil()),
            );
        }
        Ok(OrderDemodulator {
            orders: orders.to_vec(),
            revolutions: turns,
            channels,
            max_points: MAX_POINTS,
            windows: Vec::new(),
            last: None,
            elapsed_revolutions: 0.0,
            next_start: 0.0,
            tracks: DemodulatedOrders {
                orders: orders.to_vec(),
                revolutions: turns,
                points: Vec::new(),
                skipped_windows: 0,
            },
        })
    }

    /// Adds one sample: time, s, shaft angle, rad, shaft speed, rad/s, and channel values. Samples are equally spaced.
    ///
    /// # Errors
    /// Orders that the samples do not separate.
    pub fn push(&mut self, t: f64, angle: f64, speed: f64, values: &[f64]) -> Result<(), Error> {
        if let Some((last, previous)) = self.last {
            let step = angle - last;
            let sense = if step == 0.0 { previous } else { step.signum() };
            if sense * previous < 0.0 {
                // The sense of rotation reverses: open windows are discarded.
                self.windows.clear();
                self.next_start = self.elapsed_revolutions;
            }
            self.elapsed_revolutions += step.abs() / TAU;
            self.last = Some((angle, sense));
        } else {
            self.last = Some((angle, speed.signum()));
        }
        while self.elapsed_revolutions >= self.next_start {
            let unknowns = 2 + 2 * self.orders.len();
            self.windows.push(TrackWindow {
                start: self.next_start,
                start_angle: angle,
                samples: 0,
                gram: Matrix::zeros(unknowns, unknowns),
                right_side: Matrix::zeros(unknowns, self.channels),
                sums: [0.0; 3],
            });
            self.next_start += 0.5 * self.revolutions;
        }
        let n_complete = self
            .windows
            .iter()
            .take_while(|w| self.elapsed_revolutions - w.start >= self.revolutions)
            .count();
        for window in self.windows.drain(..n_complete).collect::<Vec<_>>() {
            self.close(window)?;
        }
        let row = self.regressors(angle);
        for window in &mut self.windows {
            let u = (self.elapsed_revolutions - window.start) / self.revolutions;
            window.add(
                t,
                speed,
                u,
                (angle - window.start_angle) / (TAU * self.revolutions),
                &row,
                values,
            );
        }
        Ok(())
    }

    /// Sets the maximum number of points, at least 2; at the maximum, adjacent points are averaged.
    pub fn limit_points(&mut self, points: usize) {
        self.max_points = points.max(2);
    }

    /// Demodulated orders.
    pub fn finish(self) -> DemodulatedOrders {
        self.tracks
    }

    /// Number of values stored at present.
    pub fn stored_values(&self) -> usize {
        let unknowns = 2 + 2 * self.orders.len();
        let window = unknowns * (unknowns + self.channels) + 6;
        let point = 2 + 2 * self.channels * self.orders.len();
        self.windows.len() * window + self.tracks.points.len() * point
    }

    /// Regressors `1, 0, cos nφ, sin nφ, …`; each window sets the second, its trend.
    fn regressors(&self, angle: f64) -> Vec<f64> {
        let waves = self.orders.iter().flat_map(|n| {
            let (sin, cos) = (n * angle).sin_cos();
            [cos, sin]
        });
        [1.0, 0.0].into_iter().chain(waves).collect()
    }

    fn close(&mut self, window: TrackWindow) -> Result<(), Error> {
        let [weight, time, speed] = window.sums;
        if window.samples < MIN_SAMPLES_PER_UNKNOWN * window.gram.nrows() || weight <= 0.0 {
            self.tracks.skipped_windows += 1;
            return Ok(());
        }
        let solution = symmetric::lu_solve(&window.gram, &window.right_side)
            .map_err(|e| e.with_hint("take more samples, or more turns per point"))?;
        let value = |channel: usize, order: usize| {
            Complex::new(
                solution[(2 + 2 * order, channel)],
                -solution[(3 + 2 * order, channel)],
            )
        };
        let orders = self.orders.len();
        let values = (0..self.channels).map(|c| (0..orders).map(|n| value(c, n)).collect());
        self.tracks.points.push(OrderPoint {
            time_s: time / weight,
            speed: speed / weight,
            values: values.collect(),
        });
        if self.tracks.points.len() >= self.max_points {
            self.tracks.merge_neighbours(self.revolutions);
        }
        Ok(())
    }
}

impl TrackWindow {
    fn add(&mut self, t: f64, speed: f64, u: f64, trend: f64, row: &[f64], values: &[f64]) {
        let weight = (PI * u).sin().powi(2) * speed.abs();
        if weight == 0.0 {
            return;
        }
        self.samples += 1;
        for (sum, x) in self.sums.iter_mut().zip([1.0, t, speed]) {
            *sum += weight * x;
        }
        let regressor = |i: usize| if i == 1 { trend } else { row[i] };
        for i in 0..row.len() {
            let weighted = weight * regressor(i);
            for j in 0..row.len() {
                self.gram[(i, j)] += weighted * regressor(j);
            }
            for (c, x) in values.iter().enumerate() {
                self.right_side[(i, c)] += weighted * x;
            }
        }
    }
}

impl DemodulatedOrders {
    /// Averages adjacent points, whose windows of `window` revolutions overlap by half.
    fn merge_neighbours(&mut self, window: f64) {
        let mean = |pair: &[OrderPoint]| {
            let [a, b] = pair else {
                return pair[0].clone();
            };
            let lists = a.values.iter().zip(&b.values);
            let mean = |(x, y): (&Complex, &Complex)| (x + y) * 0.5;
            OrderPoint {
                time_s: 0.5 * (a.time_s + b.time_s),
                speed: 0.5 * (a.speed + b.speed),
                values: lists
                    .map(|(x, y)| x.iter().zip(y).map(mean).collect())
                    .collect(),
            }
        };
        self.points = self.points.chunks(2).map(mean).collect();
        self.revolutions = 2.0 * self.revolutions - 0.5 * window;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Run-up with mean, trend and three orders, one of them not an integer: exact amplitudes and phases at every point.
    #[test]
    fn exact_orders_of_a_run_up() {
        let orders = [1.0, 37.0 / 12.0, 21.0];
        let mut track = OrderDemodulator::new(&orders, 12.0, 1).unwrap();
        let exact = [(0.3, 0.4), (0.02, -1.0), (1e-4, 2.0)];
        for k in 0..200_000 {
            let t = k as f64 * 1e-4;
            let (angle, speed) = (50.0 * t + 4.0 * t * t, 50.0 + 8.0 * t);
            let waves = orders.iter().zip(&exact);
            let sum: f64 = waves.map(|(n, (a, p))| a * (n * angle + p).cos()).sum();
            track
                .push(t, angle, speed, &[7.0 + 0.1 * angle + sum])
                .unwrap();
        }
        let tracks = track.finish();
        assert!(tracks.points.len() > 40 && tracks.skipped_windows == 0);
        for point in &tracks.points {
            assert!((point.speed - 50.0 - 8.0 * point.time_s).abs() < 0.2);
            for (value, (a, p)) in point.values[0].iter().zip(&exact) {
                let error = value - Complex::from_polar(*a, *p);
                assert!(error.norm() < 1e-10, "{value} {error}");
            }
        }
    }

    /// The number of stored values does not increase over a hundred times the revolutions.
    #[test]
    fn law_memory_stays() {
        let peak = |turns: usize| {
            let mut track = OrderDemodulator::new(&[1.0], 2.0, 1).unwrap();
            track.limit_points(64);
            let mut largest = 0;
            for k in 0..turns * 40 {
                let angle = TAU * k as f64 / 40.0;
                track.push(k as f64, angle, 1.0, &[angle.cos()]).unwrap();
                largest = largest.max(track.stored_values());
            }
            let tracks = track.finish();
            assert!(
                tracks
                    .points
                    .iter()
                    .all(|p| (p.values[0][0] - 1.0).norm() < 1e-9)
            );
            largest
        };
        assert_eq!(peak(200), peak(20_000));
    }

    #[test]
    fn refuses_orders_too_near() {
        for (orders, turns) in [
            (&[1.0, 1.1][..], 8.0),
            (&[0.1], 8.0),
            (&[], 8.0),
            (&[-1.0], 8.0),
            (&[1.0], 0.0),
        ] {
            assert!(OrderDemodulator::new(orders, turns, 1).is_err());
        }
        assert!(OrderDemodulator::new(&[1.0, 1.25], 8.0, 1).is_ok());
    }
}
