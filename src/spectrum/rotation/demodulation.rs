//! Orders of signals while they arrive: `x ≈ a + b φ + Σ Aₙ cos(n φ + ψₙ)` by least squares over windows of whole turns.
//!
//! Weights are Hann's over the angle turned, `sin²(πu)`, half overlapping, times the speed, so that every bit of angle counts alike. The
//! straight line keeps means and the run of an angle out of the orders; orders of one window are told apart by solving for all of them.

use std::f64::consts::{PI, TAU};

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::{Complex, Matrix, definite};

/// Points kept; beyond them neighbours become one.
const MOST_POINTS: usize = 4096;

/// Samples in a window for each unknown at least: fewer tell orders from their aliases by chance.
const LEAST_PER_UNKNOWN: usize = 4;

/// Follows orders of some channels over the angle of a shaft.
pub struct Demodulator {
    orders: Vec<f64>,
    turns: f64,
    channels: usize,
    most: usize,
    windows: Vec<Window>,
    /// Angle of the last sample, rad, and the sense in which it was reached.
    last: Option<(f64, f64)>,
    /// Turns so far, either way.
    travelled: f64,
    /// Where the next window begins.
    next: f64,
    tracks: Tracks,
}

/// What was followed.
#[derive(Debug, Clone, PartialEq)]
pub struct Tracks {
    /// Orders: cycles a turn.
    pub orders: Vec<f64>,
    /// Over so many turns each point is a mean.
    pub turns: f64,
    /// By rising time.
    pub points: Vec<Point>,
    /// Windows in which too few samples fell.
    pub coarse: usize,
}

/// Orders about one instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Middle of the window, s.
    pub time_s: f64,
    /// Mean speed of the shaft in it, rad/s.
    pub speed: f64,
    /// `A e^{iψ}` of every channel, order by order.
    pub values: Vec<Vec<Complex>>,
}

struct Window {
    from: f64,
    /// Angle where it begins, rad.
    base: f64,
    samples: usize,
    gram: Matrix,
    right: Matrix,
    /// Sums of the weights, with time, with speed.
    sums: [f64; 3],
}

impl Demodulator {
    /// Follows `orders` of `channels` channels, each point over `turns` turns.
    ///
    /// # Errors
    /// `OutOfRange`: no orders, orders that are not above zero or that so many turns do not part (two lines: 2/turns), no turns.
    pub fn new(orders: &[f64], turns: f64, channels: usize) -> Result<Demodulator, Error> {
        let refuse =
            |message: String, hint: String| Err(Error::new(Code::OutOfRange, message).hint(hint));
        if !(turns > 0.0 && turns.is_finite()) {
            return refuse(
                format!("{turns} turns hold no order"),
                "take 1 or more".into(),
            );
        }
        let mut sorted = orders.to_vec();
        sorted.sort_by(f64::total_cmp);
        let Some(&least) = sorted.first() else {
            return refuse("no orders to follow".into(), "state one or more".into());
        };
        if !(least > 0.0 && sorted.iter().all(|n| n.is_finite())) {
            return refuse(
                format!("{least} is no order"),
                "orders are above zero".into(),
            );
        }
        let apart = sorted.windows(2).map(|p| p[1] - p[0]).fold(least, f64::min);
        if apart * turns < 2.0 {
            return refuse(
                format!(
                    "over {turns} turns orders {apart} apart (or from zero) are not told apart"
                ),
                format!("take at least {} turns", (2.0 / apart).ceil()),
            );
        }
        Ok(Demodulator {
            orders: orders.to_vec(),
            turns,
            channels,
            most: MOST_POINTS,
            windows: Vec::new(),
            last: None,
            travelled: 0.0,
            next: 0.0,
            tracks: Tracks {
                orders: orders.to_vec(),
                turns,
                points: Vec::new(),
                coarse: 0,
            },
        })
    }

    /// Takes one sample: time, s, the angle of the shaft, rad, and its speed, rad/s, and every channel. Samples are equally spaced.
    ///
    /// # Errors
    /// Orders that the samples do not tell apart.
    pub fn push(&mut self, t: f64, angle: f64, speed: f64, values: &[f64]) -> Result<(), Error> {
        if let Some((last, sense)) = self.last {
            let step = angle - last;
            let now = if step == 0.0 { sense } else { step.signum() };
            if now * sense < 0.0 {
                // It turns back: what was begun is not comparable.
                self.windows.clear();
                self.next = self.travelled;
            }
            self.travelled += step.abs() / TAU;
            self.last = Some((angle, now));
        } else {
            self.last = Some((angle, speed.signum()));
        }
        while self.travelled >= self.next {
            let unknowns = 2 + 2 * self.orders.len();
            self.windows.push(Window {
                from: self.next,
                base: angle,
                samples: 0,
                gram: Matrix::zeros(unknowns, unknowns),
                right: Matrix::zeros(unknowns, self.channels),
                sums: [0.0; 3],
            });
            self.next += 0.5 * self.turns;
        }
        let done = self
            .windows
            .iter()
            .take_while(|w| self.travelled - w.from >= self.turns)
            .count();
        for window in self.windows.drain(..done).collect::<Vec<_>>() {
            self.close(window)?;
        }
        let row = self.row(angle);
        for window in &mut self.windows {
            let u = (self.travelled - window.from) / self.turns;
            window.add(
                t,
                speed,
                u,
                (angle - window.base) / (TAU * self.turns),
                &row,
                values,
            );
        }
        Ok(())
    }

    /// Keeps at most so many points, 2 or more; beyond them neighbours become one.
    pub fn keep(&mut self, points: usize) {
        self.most = points.max(2);
    }

    /// What was followed.
    pub fn finish(self) -> Tracks {
        self.tracks
    }

    /// Numbers held at present.
    pub fn held(&self) -> usize {
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

    fn close(&mut self, window: Window) -> Result<(), Error> {
        let [weight, time, speed] = window.sums;
        if window.samples < LEAST_PER_UNKNOWN * window.gram.nrows() || weight <= 0.0 {
            self.tracks.coarse += 1;
            return Ok(());
        }
        let found = definite::solve(&window.gram, &window.right)
            .map_err(|e| e.hint("take more samples, or more turns a point"))?;
        let value = |channel: usize, order: usize| {
            Complex::new(
                found[(2 + 2 * order, channel)],
                -found[(3 + 2 * order, channel)],
            )
        };
        let orders = self.orders.len();
        let values = (0..self.channels).map(|c| (0..orders).map(|n| value(c, n)).collect());
        self.tracks.points.push(Point {
            time_s: time / weight,
            speed: speed / weight,
            values: values.collect(),
        });
        if self.tracks.points.len() >= self.most {
            self.tracks.halve();
        }
        Ok(())
    }
}

impl Window {
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

impl Tracks {
    /// Neighbours become one.
    fn halve(&mut self) {
        let mean = |pair: &[Point]| {
            let [a, b] = pair else {
                return pair[0].clone();
            };
            let lists = a.values.iter().zip(&b.values);
            let mean = |(x, y): (&Complex, &Complex)| (x + y) * 0.5;
            Point {
                time_s: 0.5 * (a.time_s + b.time_s),
                speed: 0.5 * (a.speed + b.speed),
                values: lists
                    .map(|(x, y)| x.iter().zip(y).map(mean).collect())
                    .collect(),
            }
        };
        self.points = self.points.chunks(2).map(mean).collect();
        self.turns *= 2.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A run-up with a mean, a line and three orders, one of them no whole number: what was put in, at every point.
    #[test]
    fn exact_orders_of_a_run_up() {
        let orders = [1.0, 37.0 / 12.0, 21.0];
        let mut track = Demodulator::new(&orders, 12.0, 1).unwrap();
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
        assert!(found.points.len() > 40 && found.coarse == 0);
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
            let mut track = Demodulator::new(&[1.0], 2.0, 1).unwrap();
            track.keep(64);
            let mut most = 0;
            for k in 0..turns * 40 {
                let angle = TAU * k as f64 / 40.0;
                track.push(k as f64, angle, 1.0, &[angle.cos()]).unwrap();
                most = most.max(track.held());
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
            assert!(Demodulator::new(orders, turns, 1).is_err());
        }
        assert!(Demodulator::new(&[1.0, 1.25], 8.0, 1).is_ok());
    }
}
