//! Streaming order tracking by least squares per window: `x ≈ a + b φ + Σ Aₙ cos(n φ + ψₙ)`.
//!
//! Weights are Hann's over the angle turned, `sin²(πu)`, half overlapping, times the speed, so that every bit of angle counts alike. The
//! straight line keeps means and the run of an angle out of the orders; orders of one window are distinguished by solving for
//! all of them.

use std::f64::consts::{PI, TAU};

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::{Complex, Matrix, symmetric};

/// Points kept; beyond them neighbours become one.
const MAX_POINTS: usize = 4096;

/// Samples in a window for each unknown at least: fewer tell orders from their aliases by chance.
const MIN_SAMPLES_PER_UNKNOWN: usize = 4;

/// Follows orders of some channels over the angle of a shaft.
pub struct OrderDemodulator {
    orders: Vec<f64>,
    revolutions: f64,
    channels: usize,
    max_rows: usize,
    windows: Vec<TrackWindow>,
    /// Angle of the last sample, rad, and the sense in which it was reached.
    last: Option<(f64, f64)>,
    /// Turns so far, either way.
    elapsed_revolutions: f64,
    /// Start of the next window.
    next: f64,
    tracks: DemodulatedOrders,
}

/// Demodulated orders over time.
#[derive(Debug, Clone, PartialEq)]
pub struct DemodulatedOrders {
    /// Orders: cycles a turn.
    pub orders: Vec<f64>,
    /// Revolutions over which each point is a mean.
    pub revolutions: f64,
    /// By rising time.
    pub points: Vec<OrderPoint>,
    /// Windows in which too few samples fell.
    pub skipped_windows: usize,
}

/// Orders about one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct OrderPoint {
    /// Middle of the window, s.
    pub time_s: f64,
    /// Mean speed of the shaft in it, rad/s.
    pub speed: f64,
    /// `A e^{iψ}` of every channel, order by order.
    pub values: Vec<Vec<Complex>>,
}

struct TrackWindow {
    from: f64,
    /// Angle where it begins, rad.
    base: f64,
    samples: usize,
    gram: Matrix,
    right: Matrix,
    /// Sums of the weights, with time, with speed.
    sums: [f64; 3],
}

impl OrderDemodulator {
    /// Follows `orders` of `channels` channels, each point over a window of `turns` revolutions.
    ///
    /// # Errors
    /// `OutOfRange`: no orders, orders that are not above zero or that the window does not resolve (two lines: 2/turns), no window.
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
        let Some(&least) = sorted.first() else {
            return refuse(
                "no orders to follow".into(),
                "give at least one order".into(),
            );
        };
        if !(least > 0.0 && sorted.iter().all(|n| n.is_finite())) {
            return refuse(
                format!("order {least} is not above zero"),
                "give orders above zero".into(),
            );
        }
        let apart = sorted.windows(2).map(|p| p[1] - p[0]).fold(least, f64::min);
        if apart * turns < 2.0 {
            return refuse(
                format!("over {turns} turns orders {apart} apart (or from zero) are not separated"),
                format!("take at least {} turns", (2.0 / apart).ceil()),
            );
        }
        Ok(OrderDemodulator {
            orders: orders.to_vec(),
            revolutions: turns,
            channels,
            max_rows: MAX_POINTS,
            windows: Vec::new(),
            last: None,
            elapsed_revolutions: 0.0,
            next: 0.0,
            tracks: DemodulatedOrders {
                orders: orders.to_vec(),
                revolutions: turns,
                points: Vec::new(),
                skipped_windows: 0,
            },
        })
    }

    /// Takes one sample: time, s, the angle of the shaft, rad, and its speed, rad/s, and every channel. Samples are equally spaced.
    ///
    /// # Errors
    /// Orders that the samples do not distinguish.
    pub fn push(&mut self, t: f64, angle: f64, speed: f64, values: &[f64]) -> Result<(), Error> {
        if let Some((last, sense)) = self.last {
            let step = angle - last;
            let now = if step == 0.0 { sense } else { step.signum() };
            if now * sense < 0.0 {
                // The direction reverses: open windows are discarded.
                self.windows.clear();
                self.next = self.elapsed_revolutions;
            }
            self.elapsed_revolutions += step.abs() / TAU;
            self.last = Some((angle, now));
        } else {
            self.last = Some((angle, speed.signum()));
        }
        while self.elapsed_revolutions >= self.next {
            let unknowns = 2 + 2 * self.orders.len();
            self.windows.push(TrackWindow {
                from: self.next,
                base: angle,
                samples: 0,
                gram: Matrix::zeros(unknowns, unknowns),
                right: Matrix::zeros(unknowns, self.channels),
                sums: [0.0; 3],
            });
            self.next += 0.5 * self.revolutions;
        }
        let done = self
            .windows
            .iter()
            .take_while(|w| self.elapsed_revolutions - w.from >= self.revolutions)
            .count();
        for window in self.windows.drain(..done).collect::<Vec<_>>() {
            self.close(window)?;
        }
        let row = self.row(angle);
        for window in &mut self.windows {
            let u = (self.elapsed_revolutions - window.from) / self.revolutions;
            window.add(
                t,
                speed,
                u,
                (angle - window.base) / (TAU * self.revolutions),
                &row,
                values,
            );
        }
        Ok(())
    }

    /// Keeps at most so many points, 2 or more; beyond them neighbours become one.
    pub fn limit_points(&mut self, points: usize) {
        self.max_rows = points.max(2);
    }

    /// Demodulated orders.
    pub fn finish(self) -> DemodulatedOrders {
        self.tracks
    }

    /// Numbers held at present.
    pub fn stored_values(&self) -> usize {
        let unknowns = 2 + 2 * self.orders.len();
        let window = unknowns * (unknowns + self.channels) + 6;
        let point = 2 + 2 * self.channels * self.orders.len();
        self.windows.len() * window + self.tracks.points.len() * point
    }

    /// `1, 0, cos nφ, sin nφ, …`: the second is the window's own.
    fn row(&self, angle: f64) -> Vec<f64> {
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
        let found = symmetric::lu_solve(&window.gram, &window.right)
            .map_err(|e| e.with_hint("take more samples, or more turns a point"))?;
        let value = |channel: usize, order: usize| {
            Complex::new(
                found[(2 + 2 * order, channel)],
                -found[(3 + 2 * order, channel)],
            )
        };
        let orders = self.orders.len();
        let values = (0..self.channels).map(|c| (0..orders).map(|n| value(c, n)).collect());
        self.tracks.points.push(OrderPoint {
            time_s: time / weight,
            speed: speed / weight,
            values: values.collect(),
        });
        if self.tracks.points.len() >= self.max_rows {
            self.tracks.merge_neighbours(self.revolutions);
        }
        Ok(())
    }
}

impl TrackWindow {
    fn add(&mut self, t: f64, speed: f64, u: f64, along: f64, row: &[f64], values: &[f64]) {
        let weight = (PI * u).sin().powi(2) * speed.abs();
        if weight == 0.0 {
            return;
        }
        self.samples += 1;
        for (sum, x) in self.sums.iter_mut().zip([1.0, t, speed]) {
            *sum += weight * x;
        }
        let own = |i: usize| if i == 1 { along } else { row[i] };
        for i in 0..row.len() {
            let left = weight * own(i);
            for j in 0..row.len() {
                self.gram[(i, j)] += left * own(j);
            }
            for (c, x) in values.iter().enumerate() {
                self.right[(i, c)] += left * x;
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

    /// A run-up with a mean, a line and three orders, one of them no whole number: what was put in, at every point.
    #[test]
    fn exact_orders_of_a_run_up() {
        let orders = [1.0, 37.0 / 12.0, 21.0];
        let mut track = OrderDemodulator::new(&orders, 12.0, 1).unwrap();
        let put = [(0.3, 0.4), (0.02, -1.0), (1e-4, 2.0)];
        for k in 0..200_000 {
            let t = k as f64 * 1e-4;
            let (angle, speed) = (50.0 * t + 4.0 * t * t, 50.0 + 8.0 * t);
            let waves = orders.iter().zip(&put);
            let sum: f64 = waves.map(|(n, (a, p))| a * (n * angle + p).cos()).sum();
            track
                .push(t, angle, speed, &[7.0 + 0.1 * angle + sum])
                .unwrap();
        }
        let found = track.finish();
        assert!(found.points.len() > 40 && found.skipped_windows == 0);
        for point in &found.points {
            assert!((point.speed - 50.0 - 8.0 * point.time_s).abs() < 0.2);
            for (value, (a, p)) in point.values[0].iter().zip(&put) {
                let exact = Complex::from_polar(*a, *p);
                assert!((value - exact).norm() < 1e-10, "{value} {exact}");
            }
        }
    }

    /// A hundred times the turns hold no more.
    #[test]
    fn law_memory_stays() {
        let held = |turns: usize| {
            let mut track = OrderDemodulator::new(&[1.0], 2.0, 1).unwrap();
            track.limit_points(64);
            let mut most = 0;
            for k in 0..turns * 40 {
                let angle = TAU * k as f64 / 40.0;
                track.push(k as f64, angle, 1.0, &[angle.cos()]).unwrap();
                most = most.max(track.stored_values());
            }
            let found = track.finish();
            assert!(
                found
                    .points
                    .iter()
                    .all(|p| (p.values[0][0] - 1.0).norm() < 1e-9)
            );
            most
        };
        assert_eq!(held(200), held(20_000));
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
