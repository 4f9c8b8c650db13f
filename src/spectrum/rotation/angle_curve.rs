//! Shaft angle over time: monotone cubic spline through counted pulses (Fritsch & Carlson).
//!
//! The slopes are those of the spline with continuous curvature (end slopes by the cubic through four points), limited so that every piece
//! is monotone: J. M. Hyman, SIAM J. Sci. Stat. Comput. 4 (1983), 645–654. Constant acceleration is reproduced exactly.

use std::f64::consts::TAU;

use super::tacho::TachoPulses;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::spectrum::validation::{check_count, check_positive, check_samples};

/// Maximum ratio of slope to the smaller neighbouring chord for a monotone cubic (Fritsch & Carlson, SIAM J. Numer. Anal. 17 (1980), 238–246).
const MAX_SLOPE_RATIO: f64 = 3.0;

/// Maximum number of Newton steps and bisections of an inverse; 53 bisections exhaust a double.
const MAX_ITERATIONS: usize = 60;

/// Convergence tolerance of an inverse relative to its piece: a few roundings.
const INVERSE_TOLERANCE: f64 = 4.0 * f64::EPSILON;

/// Shaft angle over time, strictly increasing.
#[derive(Debug, Clone)]
pub struct AngleCurve {
    time_s: Vec<f64>,
    angle: Vec<f64>,
    slope: Vec<f64>,
}

impl AngleCurve {
    /// Interpolates at least two points at rising times, s, with rising angles, rad.
    ///
    /// # Errors
    /// Fewer than two points, non-finite numbers, a time or an angle that does not rise.
    pub fn new(time_s: Vec<f64>, angle: Vec<f64>) -> Result<AngleCurve, Error> {
        check_samples(&time_s, 2)?;
        check_samples(&angle, time_s.len())?;
        if let Some(index) = time_s.windows(2).position(|w| w[0] >= w[1]) {
            return Err(Error::new(
                Code::InvalidTimeStamps,
                format!(
                    "times of angles must increase, but {} s follows {} s",
                    time_s[index + 1],
                    time_s[index]
                ),
            ));
        }
        if let Some(index) = angle.windows(2).position(|w| w[0] >= w[1]) {
            return Err(Error::new(
                Code::OutOfRange,
                format!("the shaft stops or turns back at {} s: {} rad, then {} rad", time_s[index], angle[index], angle[index + 1]),
            )
            .with_hint("choose a segment with one direction of rotation; swap the tracks of an encoder that counts down"));
        }
        let slope = slopes(&time_s, &angle);
        Ok(AngleCurve {
            time_s,
            angle,
            slope,
        })
    }

    /// Angle curve of tacho pulses, zero at the first: `2π index / pulses_per_turn`, rad.
    ///
    /// # Errors
    /// Zero pulses per turn, fewer than two pulses.
    pub fn from_pulses(pulses: &TachoPulses, pulses_per_turn: usize) -> Result<AngleCurve, Error> {
        check_count(pulses_per_turn, 1, "the number of pulses per turn")?;
        let step = TAU / pulses_per_turn as f64;
        let list = &pulses.pulses;
        AngleCurve::new(
            list.iter().map(|p| p.time_s).collect(),
            list.iter().map(|p| step * p.index as f64).collect(),
        )
    }

    /// Angle curve of a constant speed, rad/s, zero at the first sample.
    ///
    /// # Errors
    /// A speed or a duration that is not positive.
    pub fn constant_speed(speed: f64, duration_s: f64) -> Result<AngleCurve, Error> {
        check_positive(speed, "the speed, rad/s,")?;
        check_positive(duration_s, "the duration, s,")?;
        AngleCurve::new(vec![0.0, duration_s], vec![0.0, speed * duration_s])
    }

    /// Angle curve of a geared shaft, which makes `turns` revolutions per `base` revolutions of this one.
    ///
    /// # Errors
    /// Zero turns.
    pub fn scaled_by_ratio(&self, turns: usize, base: usize) -> Result<AngleCurve, Error> {
        check_count(turns.min(base), 1, "the smaller number of turns of a ratio")?;
        let ratio = |x: &f64| x * turns as f64 / base as f64;
        Ok(AngleCurve {
            time_s: self.time_s.clone(),
            angle: self.angle.iter().map(ratio).collect(),
            slope: self.slope.iter().map(ratio).collect(),
        })
    }

    /// First and last time of the curve, s.
    pub fn time_range_s(&self) -> (f64, f64) {
        (self.time_s[0], self.time_s[self.time_s.len() - 1])
    }

    /// First and last angle of the curve, rad.
    pub fn angle_range(&self) -> (f64, f64) {
        (self.angle[0], self.angle[self.angle.len() - 1])
    }

    /// Number of points between two times, s.
    pub fn points_within(&self, from_s: f64, to_s: f64) -> usize {
        let before = |t: f64| self.time_s.partition_point(|&x| x < t);
        self.time_s.partition_point(|&x| x <= to_s) - before(from_s).min(self.time_s.len())
    }

    /// Angle at a time, rad; extrapolated at constant speed beyond the ends.
    pub fn angle_at(&self, time_s: f64) -> f64 {
        self.evaluate(time_s).0
    }

    /// Speed at a time, rad/s.
    pub fn speed(&self, time_s: f64) -> f64 {
        self.evaluate(time_s).1
    }

    /// Angle, rad, and speed, rad/s, at a time.
    fn evaluate(&self, time_s: f64) -> (f64, f64) {
        let (first, last) = self.time_range_s();
        let end = self.time_s.len() - 1;
        if time_s <= first {
            return (
                self.angle[0] + self.slope[0] * (time_s - first),
                self.slope[0],
            );
        }
        if time_s >= last {
            let slope = self.slope[end];
            return (self.angle[end] + slope * (time_s - last), slope);
        }
        let i = self.time_s.partition_point(|&t| t <= time_s) - 1;
        let h = self.time_s[i + 1] - self.time_s[i];
        let (rise, derivative) = self.piece(i, (time_s - self.time_s[i]) / h);
        (self.angle[i] + rise, derivative / h)
    }

    /// Hermite cubic of piece `i` relative to its start, and its derivative by `u`, at `0 ≤ u ≤ 1`.
    fn piece(&self, i: usize, u: f64) -> (f64, f64) {
        let h = self.time_s[i + 1] - self.time_s[i];
        let rise = self.angle[i + 1] - self.angle[i];
        let (a, b) = (h * self.slope[i], h * self.slope[i + 1]);
        let (square, cube) = (3.0 * rise - 2.0 * a - b, a + b - 2.0 * rise);
        (
            u * (a + u * (square + u * cube)),
            a + u * (2.0 * square + u * 3.0 * cube),
        )
    }

    /// Time at which an angle is reached, s; none outside the curve.
    pub fn time_at(&self, angle: f64) -> Option<f64> {
        let (first, last) = self.angle_range();
        if !(first <= angle && angle <= last) {
            return None;
        }
        let i = self
            .angle
            .partition_point(|&a| a <= angle)
            .clamp(1, self.angle.len() - 1)
            - 1;
        let target = angle - self.angle[i];
        let (mut low, mut high) = (0.0, 1.0);
        let mut u = target / (self.angle[i + 1] - self.angle[i]);
        for _ in 0..MAX_ITERATIONS {
            let (rise, derivative) = self.piece(i, u);
            if rise > target {
                high = u;
            } else {
                low = u;
            }
            let newton = u - (rise - target) / derivative;
            let next = if newton >= low && newton <= high {
                newton
            } else {
                0.5 * (low + high)
            };
            let step = (next - u).abs();
            u = next;
            if step < INVERSE_TOLERANCE {
                break;
            }
        }
        Some(self.time_s[i] + u * (self.time_s[i + 1] - self.time_s[i]))
    }
}

/// Slopes of the spline, limited for monotonicity.
fn slopes(t: &[f64], y: &[f64]) -> Vec<f64> {
    let n = t.len();
    let h: Vec<f64> = t.windows(2).map(|w| w[1] - w[0]).collect();
    let chord: Vec<f64> = (0..n - 1).map(|i| (y[i + 1] - y[i]) / h[i]).collect();
    if n == 2 {
        return vec![chord[0]; 2];
    }
    // Interior slopes make the curvature continuous: tridiagonal system, solved by the Thomas algorithm.
    let mut slope = vec![0.0; n];
    let mut ratio = vec![0.0; n];
    let points = n.min(4);
    slope[0] = end_slope(&t[..points], &y[..points], 0);
    for i in 1..n - 1 {
        let (before, after) = (1.0 / h[i - 1], 1.0 / h[i]);
        let pivot = 2.0 * (before + after) - before * ratio[i - 1];
        ratio[i] = after / pivot;
        slope[i] =
            (3.0 * (chord[i - 1] * before + chord[i] * after) - before * slope[i - 1]) / pivot;
    }
    slope[n - 1] = end_slope(&t[n - points..], &y[n - points..], points - 1);
    for i in (1..n - 1).rev() {
        slope[i] -= ratio[i] * slope[i + 1];
    }
    for i in 0..n {
        let min_chord = chord[i.saturating_sub(1)].min(chord[i.min(n - 2)]);
        slope[i] = slope[i].clamp(0.0, MAX_SLOPE_RATIO * min_chord);
    }
    slope
}

/// Derivative at point `index` of the polynomial through all points (Lagrange form).
fn end_slope(t: &[f64], y: &[f64], index: usize) -> f64 {
    let others = |i: usize, k: usize| (0..t.len()).filter(move |&j| j != i && j != k);
    let mut sum = 0.0;
    for i in (0..t.len()).filter(|&i| i != index) {
        let numerator: f64 = others(i, index).map(|j| t[index] - t[j]).product();
        let denominator: f64 = others(i, i).map(|j| t[i] - t[j]).product();
        sum += (y[i] - y[index]) * numerator / denominator;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Constant acceleration is exact at uneven points, also inverted.
    #[test]
    fn exact_constant_acceleration() {
        let angle = |t: f64| 3.0 * t + 7.0 * t * t;
        let t: Vec<f64> = (0..40)
            .map(|i| f64::from(i) * 0.1 + 0.03 * f64::from(i % 3))
            .collect();
        let curve = AngleCurve::new(t.clone(), t.iter().map(|&t| angle(t)).collect()).unwrap();
        for i in 0..=1000 {
            let time = curve.time_range_s().1 * f64::from(i) / 1000.0;
            assert!((curve.angle_at(time) - angle(time)).abs() < 1e-12);
            assert!((curve.speed(time) - 3.0 - 14.0 * time).abs() < 1e-10);
            assert!(
                (curve
                    .time_at(angle(time).min(curve.angle_range().1))
                    .unwrap()
                    - time)
                    .abs()
                    < 1e-13
            );
        }
        assert!(curve.time_at(-1.0).is_none());
    }

    /// The error is of fourth order in the spacing of the points.
    #[test]
    fn order_of_interpolation() {
        let angle = |t: f64| 10.0 * t + t.sin();
        let error = |n: usize| {
            let t: Vec<f64> = (0..=n).map(|i| 6.0 * i as f64 / n as f64).collect();
            let curve = AngleCurve::new(t.clone(), t.iter().map(|&t| angle(t)).collect()).unwrap();
            (0..6000)
                .map(|i| f64::from(i) / 1000.0)
                .map(|t| (curve.angle_at(t) - angle(t)).abs())
                .fold(0.0, f64::max)
        };
        let order = (error(160) / error(320)).log2();
        assert!((order - 4.0).abs() < 0.2, "{order}");
    }

    /// The curve is monotone at any speed variation, and the inverse recovers the angle.
    #[test]
    fn law_never_turns_back() {
        let mut rng = fastrand::Rng::with_seed(6);
        for _ in 0..20 {
            let (mut t, mut a) = (vec![0.0], vec![0.0]);
            for i in 0..60 {
                t.push(t[i] + 0.01 + rng.f64());
                a.push(a[i] + 10.0_f64.powf(-6.0 * rng.f64()));
            }
            let curve = AngleCurve::new(t, a).unwrap();
            let end = curve.time_range_s().1;
            let mut previous = -1e-300;
            for i in 0..=3000 {
                let time = end * f64::from(i) / 3000.0;
                let angle = curve.angle_at(time);
                assert!(angle >= previous);
                previous = angle;
                let inverse = curve.time_at(angle.min(curve.angle_range().1)).unwrap();
                assert!((curve.angle_at(inverse) - angle).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn refuses_what_does_not_turn() {
        let curve =
            |t: &[f64], a: &[f64]| AngleCurve::new(t.to_vec(), a.to_vec()).unwrap_err().code;
        assert_eq!(curve(&[0.0], &[0.0]), Code::TooShort);
        assert_eq!(curve(&[0.0, 0.0], &[0.0, 1.0]), Code::InvalidTimeStamps);
        assert_eq!(curve(&[0.0, 1.0], &[1.0, 1.0]), Code::OutOfRange);
        assert_eq!(curve(&[0.0, 1.0], &[1.0, f64::NAN]), Code::NotANumber);
        assert!(AngleCurve::constant_speed(0.0, 1.0).is_err());
        assert!(
            AngleCurve::constant_speed(1.0, 1.0)
                .unwrap()
                .scaled_by_ratio(0, 3)
                .is_err()
        );
    }
}
