//! Incremental encoders: unwrapping of counter readings, decoding of quadrature tracks.

use std::f64::consts::TAU;

use super::angle_curve::AngleCurve;
use super::level_crossings::{LevelCrossing, StateLevels, level_crossings};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::sorting::sort_ascending;
use crate::spectrum::validation::{check_count, check_positive, check_samples};

/// Unwrapped readings of a counter with overflow at `modulus`, by the shorter direction of each step.
///
/// # Errors
/// Readings not finite, a modulus below 2.
pub fn unwrap_counts(readings: &[f64], modulus: f64) -> Result<Vec<f64>, Error> {
    check_samples(readings, 1)?;
    if !(modulus >= 2.0 && modulus.is_finite()) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("the counter wraps after {modulus} counts (minimum 2)"),
        ));
    }
    let mut overflows = 0.0;
    let mut previous = readings[0];
    let unwrap = |&reading: &f64| {
        overflows -= ((reading - previous) / modulus).round();
        previous = reading;
        reading + overflows * modulus
    };
    Ok(readings.iter().map(unwrap).collect())
}

/// Angle curve of a counter read at every sample (unwrapped, increasing).
///
/// At a reading `c` the angle lies between counts `c` and `c + 1`. A counter that changes from `c` to `c′` between two samples passes
/// `(c + c′ + 1)/2` about half-way between them, which is a point of the curve: accurate to half a sample for one count per sample,
/// to a fraction of one for several.
///
/// # Errors
/// A counter that does not increase, zero counts per revolution.
pub fn angle_curve_from_counts(
    counts: &[f64],
    rate_hz: f64,
    counts_per_turn: usize,
) -> Result<AngleCurve, Error> {
    check_samples(counts, 2)?;
    check_positive(rate_hz, "the sample rate, Hz,")?;
    check_count(counts_per_turn, 1, "the number of counts per turn")?;
    let step = TAU / counts_per_turn as f64;
    let moves = counts.windows(2).enumerate().filter(|(_, w)| w[0] != w[1]);
    let points = moves.map(|(j, w)| ((j as f64 + 0.5) / rate_hz, step * 0.5 * (w[0] + w[1] + 1.0)));
    let (time_s, angle) = points.unzip();
    AngleCurve::new(time_s, angle)
}

/// Quadrature decoding of two encoder tracks.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Quadrature {
    /// Times of the passages of boundaries between two counts, s.
    pub time_s: Vec<f64>,
    /// Passed boundary: the higher of its two counts, four per line, zero before the first edge; increasing with track A leading.
    pub boundary: Vec<i64>,
    /// Number of edge pairs of both tracks within one sample interval, whose order and direction depend on interpolation.
    pub ambiguous_edges: usize,
}

/// Decodes two tracks, with the state levels of each signal.
///
/// # Errors
/// A dead track, samples not finite, tracks of different lengths.
pub fn quadrature(a: &[f64], b: &[f64], rate_hz: f64) -> Result<Quadrature, Error> {
    check_samples(b, a.len())?;
    check_samples(a, b.len())?;
    let track =
        |samples: &[f64]| level_crossings(samples, rate_hz, StateLevels::from_samples(samples)?);
    let (a, b) = (track(a)?, track(b)?);
    let mut edges: Vec<(LevelCrossing, bool)> = a.iter().map(|&e| (e, true)).collect();
    edges.extend(b.iter().map(|&e| (e, false)));
    sort_ascending(&mut edges, |x| x.0.time_s);
    // Before an upward first edge a track is low, before a downward one high.
    let initial_state = |edges: &[LevelCrossing]| edges.first().is_some_and(|e| !e.rising);
    let (mut high_a, mut high_b) = (initial_state(&a), initial_state(&b));
    let mut quad = Quadrature::default();
    let mut count = 0;
    for (edge, on_a) in &edges {
        // Forward: A rises while B is low, then B rises while A is high, A falls, B falls.
        let forward = if *on_a {
            high_a = edge.rising;
            high_a != high_b
        } else {
            high_b = edge.rising;
            high_a == high_b
        };
        quad.time_s.push(edge.time_s);
        quad.boundary.push(if forward { count + 1 } else { count });
        count += if forward { 1 } else { -1 };
    }
    let sample = |e: &LevelCrossing| (e.time_s * rate_hz).floor();
    let is_ambiguous =
        |w: &&[(LevelCrossing, bool)]| w[0].1 != w[1].1 && sample(&w[0].0) == sample(&w[1].0);
    quad.ambiguous_edges = edges.windows(2).filter(is_ambiguous).count();
    Ok(quad)
}

impl Quadrature {
    /// Angle curve of a shaft that rotates in one direction only.
    ///
    /// # Errors
    /// Zero lines per revolution, a reversal of the shaft.
    pub fn angle_curve(&self, lines_per_turn: usize) -> Result<AngleCurve, Error> {
        check_count(lines_per_turn, 1, "the number of lines per turn")?;
        let step = TAU / (4.0 * lines_per_turn as f64);
        let (time_s, angle) = self
            .passages()
            .into_iter()
            .map(|(time, boundary)| (time, step * boundary as f64))
            .unzip();
        AngleCurve::new(time_s, angle)
    }

    /// Times of the final passages of the boundaries. Repeated passages by a count or two are noise at an edge: the first boundary has the
    /// time of its last passage, after the rest; the last boundary that of its first passage; the others the mean of first and last
    /// passage. Events of a shaft with a larger reversal are returned unchanged.
    fn passages(&self) -> Vec<(f64, i64)> {
        /// Least number of counts of a reversal; fewer are noise.
        const MIN_COUNTS_BACK: i64 = 3;
        struct EdgePassage {
            first: f64,
            last: f64,
            boundary: i64,
            times: usize,
        }
        let mut passages: Vec<EdgePassage> = Vec::new();
        let mut highest = i64::MIN;
        for (&time, &boundary) in self.time_s.iter().zip(&self.boundary) {
            highest = highest.max(boundary);
            if highest - boundary >= MIN_COUNTS_BACK {
                return self
                    .time_s
                    .iter()
                    .copied()
                    .zip(self.boundary.iter().copied())
                    .collect();
            }
            // The boundaries above the current one were passed backward.
            while passages.last().is_some_and(|p| p.boundary > boundary) {
                passages.pop();
            }
            match passages.last_mut() {
                Some(passage) if passage.boundary == boundary => {
                    passage.last = time;
                    passage.times += 1;
                }
                _ => passages.push(EdgePassage {
                    first: time,
                    last: time,
                    boundary,
                    times: 1,
                }),
            }
        }
        // After an even number of passages the shaft is on the initial side of the boundary.
        passages.retain(|p| p.times % 2 == 1);
        let end = passages.len().saturating_sub(1);
        let time = |(k, p): (usize, &EdgePassage)| match k {
            0 => p.last,
            k if k == end => p.first,
            _ => 0.5 * (p.first + p.last),
        };
        let times: Vec<f64> = passages.iter().enumerate().map(time).collect();
        times
            .into_iter()
            .zip(passages.iter().map(|p| p.boundary))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tracks of a shaft that rotates forward, backward and forward again: all passages of the boundaries are decoded.
    #[test]
    fn exact_quadrature() {
        let rate = 10_000.0;
        let periods = |t: f64| 6.0 * t - 2.0 * (TAU * t).cos() + 2.0; // lines passed
        let track = |shift: f64| -> Vec<f64> {
            let value = |j: i32| (TAU * (periods(f64::from(j) / rate) + 0.1 - shift)).sin();
            (0..10_000).map(value).collect()
        };
        let found = quadrature(&track(0.0), &track(0.25), rate).unwrap();
        // A crosses zero at whole and half periods, B a quarter later: boundary c at (c/4) periods − 0.1, the first passed is 0.25
        assert_eq!(found.ambiguous_edges, 0);
        for (t, c) in found.time_s.iter().zip(&found.boundary) {
            let expected = 4.0 * (periods(*t) + 0.1);
            assert!((expected - *c as f64).abs() < 2e-3, "{expected} {c}");
        }
        assert!(found.angle_curve(100).is_err()); // it turned back
        // A single count back at a boundary is noise.
        let noisy = Quadrature {
            time_s: vec![0.0, 0.1, 0.2, 1.0, 2.0, 2.2, 2.4, 3.0, 3.1],
            boundary: vec![1, 1, 1, 2, 3, 3, 3, 4, 4],
            ambiguous_edges: 0,
        };
        assert_eq!(noisy.passages(), [(0.2, 1), (1.0, 2), (2.0, 3)]);
        let steady = |shift: f64| -> Vec<f64> {
            (0..2000)
                .map(|j| (0.1 * f64::from(j) - TAU * shift).sin())
                .collect()
        };
        let curve = quadrature(&steady(0.0), &steady(0.25), 1.0)
            .unwrap()
            .angle_curve(10)
            .unwrap();
        assert!((curve.speed(1000.0) - 0.01).abs() < 1e-5);
        let back = quadrature(&steady(0.25), &steady(0.0), 1.0).unwrap();
        assert!(back.boundary.windows(2).all(|w| w[1] == w[0] - 1));
    }

    /// A counter of 12 bits at constant speed: the angle within a count, the speed nearly exact.
    #[test]
    fn exact_counter() {
        for speed in [0.3, 40.7] {
            // counts a sample
            let reading = |j: u32| (f64::from(j) * speed).floor() % 4096.0;
            let readings: Vec<f64> = (0..5000).map(reading).collect();
            let counts = unwrap_counts(&readings, 4096.0).unwrap();
            assert!(
                counts
                    .iter()
                    .enumerate()
                    .all(|(j, c)| *c == (j as f64 * speed).floor())
            );
            let curve = angle_curve_from_counts(&counts, 1.0, 1024).unwrap();
            let count = |t: f64| curve.angle_at(t) / TAU * 1024.0;
            assert!((1..4900).all(|j| (count(f64::from(j)) - speed * f64::from(j)).abs() < 1.0));
        }
    }

    #[test]
    fn refuses_nonsense() {
        assert!(unwrap_counts(&[1.0], 1.0).is_err());
        assert_eq!(
            angle_curve_from_counts(&[3.0, 2.0, 1.0], 1.0, 4)
                .unwrap_err()
                .code,
            Code::OutOfRange
        );
        assert!(quadrature(&[0.0, 1.0], &[0.0], 1.0).is_err());
        assert!(quadrature(&[0.0, 1.0], &[0.0, 0.0], 1.0).is_err());
    }
}
