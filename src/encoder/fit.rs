//! Joint least-squares fit of known orders, `e = c + Σ a_k cos o_k φ + b_k sin o_k φ`.
//!
//! About the middle of the record cosines and sines are orthogonal to each other, and their products have closed sums:
//! `Σ cos(θm) = sin(Nθ/2)/sin(θ/2)`; the number of revolutions need not be an integer. The sums of an order p/q run over the record
//! folded to q revolutions.

use std::f64::consts::TAU;
use std::ops::Range;

use super::orders::CandidateOrder;
use crate::base::error::Error;
use crate::numeric::fraction::Fraction;
use crate::numeric::symmetric::lu_solve;
use crate::numeric::{Complex, Matrix};
use crate::spectrum::rotation::angular_resampling::AngularSignal;

/// Fitted mean and harmonic amplitudes, with the residual.
#[derive(Debug, Clone)]
pub struct HarmonicFit {
    /// Mean of the signal, rad.
    pub mean: f64,
    /// Complex amplitudes `A e^{iψ}` of `A cos(o φ + ψ)`, φ the output angle from zero, rad.
    pub waves: Vec<Complex>,
    /// Variance of each quadrature of an amplitude, relative to the variance of the noise per sample.
    pub variance_factor: Vec<f64>,
    /// Residual of the fit, rad.
    pub residual: Vec<f64>,
}

/// Samples between exact evaluations of a recursive phasor.
const PHASOR_RESTART: usize = 256;

/// Least-squares fit of the mean and of all orders.
///
/// # Errors
/// Orders that the record does not distinguish.
pub fn fit_orders(signal: &AngularSignal, orders: &[CandidateOrder]) -> Result<HarmonicFit, Error> {
    let (count, per_turn) = (signal.values.len(), signal.samples_per_rev as f64);
    let middle = signal.first as f64 + 0.5 * (count as f64 - 1.0);
    let mut folds = FoldedRecord::new(signal);
    // Correlations with phasors about the middle of the record; order zero is the mean.
    let sums: Vec<Complex> = std::iter::once(Complex::new(signal.values.iter().sum(), 0.0))
        .chain(orders.iter().map(|o| {
            let turns = (o.value * middle / per_turn).rem_euclid(1.0);
            folds.sum(o) * Complex::from_polar(1.0, TAU * turns)
        }))
        .collect();
    let value = |k: usize| if k == 0 { 0.0 } else { orders[k - 1].value };
    let kernel = |order: f64| {
        let half = 0.5 * TAU * order / per_turn;
        match half.sin() {
            s if s.abs() < 1e-300 => count as f64,
            s => (count as f64 * half).sin() / s,
        }
    };
    let product = |i: usize, j: usize, sign: f64| {
        let (a, b) = (value(i), value(j));
        0.5 * (kernel(a - b) + sign * kernel(a + b))
    };
    let n = orders.len() + 1;
    let cosines = Matrix::from_fn(n, n, |i, j| product(i, j, 1.0));
    let sines = Matrix::from_fn(n - 1, n - 1, |i, j| product(i + 1, j + 1, -1.0));
    let c = solve_with_inverse_diagonal(&cosines, |i| sums[i].re)?;
    let s = solve_with_inverse_diagonal(&sines, |i| -sums[i + 1].im)?;
    let waves: Vec<Complex> = orders
        .iter()
        .enumerate()
        .map(|(k, o)| {
            let turns = (o.value * middle / per_turn).rem_euclid(1.0);
            Complex::new(c.0[k + 1], -s.0[k]) * Complex::from_polar(1.0, -TAU * turns)
        })
        .collect();
    let spread = (0..orders.len())
        .map(|k| 0.5 * (c.1[k + 1] + s.1[k]))
        .collect();
    let mut residual: Vec<f64> = signal.values.iter().map(|e| e - c.0[0]).collect();
    folds.subtract_waves(orders, &waves, &mut residual);
    Ok(HarmonicFit {
        mean: c.0[0],
        waves,
        variance_factor: spread,
        residual,
    })
}

/// Adds harmonics to a signal.
pub fn add(signal: &mut AngularSignal, orders: &[CandidateOrder], waves: &[Complex]) {
    let waves: Vec<Complex> = waves.iter().map(|w| -w).collect();
    let mut values = std::mem::take(&mut signal.values);
    let zeros = AngularSignal {
        values: vec![0.0; values.len()],
        ..*signal
    };
    FoldedRecord::new(&zeros).subtract_waves(orders, &waves, &mut values);
    signal.values = values;
}

/// Solution of the linear system, and the diagonal of the inverse.
fn solve_with_inverse_diagonal(
    a: &Matrix,
    right: impl Fn(usize) -> f64,
) -> Result<(Vec<f64>, Vec<f64>), Error> {
    let n = a.nrows();
    if n == 0 {
        return Ok((Vec::new(), Vec::new()));
    }
    let b = Matrix::from_fn(n, n + 1, |i, j| match j {
        0 => right(i),
        j => f64::from(u8::from(i + 1 == j)),
    });
    let x = lu_solve(a, &b)?;
    Ok((
        (0..n).map(|i| x[(i, 0)]).collect(),
        (0..n).map(|i| x[(i, i + 1)]).collect(),
    ))
}

/// Record folded over a period of so many samples: the sum at each position, the first at angle zero.
pub fn fold(values: &[f64], first: i64, period: usize) -> Vec<f64> {
    let mut sums = vec![0.0; period];
    for (segment, start) in period_segments(values.len(), first, period) {
        (sums[start..].iter_mut().zip(&values[segment])).for_each(|(s, e)| *s += e);
    }
    sums
}

/// Segments of a record between ends of periods, each with the position of its first sample in the period.
fn period_segments(
    count: usize,
    first: i64,
    period: usize,
) -> impl Iterator<Item = (Range<usize>, usize)> {
    let start = first.rem_euclid(period as i64) as usize;
    (0..(start + count).div_ceil(period)).map(move |k| {
        let (low, high) = (
            (k * period).max(start),
            ((k + 1) * period).min(start + count),
        );
        (low - start..high - start, low % period)
    })
}

/// Record with its folded sums by period.
struct FoldedRecord<'a> {
    signal: &'a AngularSignal,
    /// Period, samples, and the sum at each position of the period.
    folded: Vec<(usize, Vec<f64>)>,
}

impl<'a> FoldedRecord<'a> {
    fn new(signal: &'a AngularSignal) -> FoldedRecord<'a> {
        FoldedRecord {
            signal,
            folded: Vec::new(),
        }
    }

    /// Common period of an order and the output revolution, samples; `None` for records of less than two periods.
    fn period(&self, order: &CandidateOrder) -> Option<usize> {
        let divisor =
            Fraction::greatest_common_divisor([&Fraction::one(), &order.fraction].into_iter())?;
        let samples = self.signal.samples_per_rev as f64 / divisor.to_f64();
        (samples <= 0.5 * self.signal.values.len() as f64).then_some(samples.round() as usize)
    }

    /// Correlation `Σ e_m e^{−i o φ_m}`, angles from zero.
    fn sum(&mut self, order: &CandidateOrder) -> Complex {
        let step = order.value / self.signal.samples_per_rev as f64;
        let Some(period) = self.period(order) else {
            return correlate(&self.signal.values, step, self.signal.first as f64);
        };
        let index = self.folded.iter().position(|f| f.0 == period);
        let index = index.unwrap_or_else(|| {
            let sums = fold(&self.signal.values, self.signal.first, period);
            self.folded.push((period, sums));
            self.folded.len() - 1
        });
        correlate(&self.folded[index].1, step, 0.0)
    }

    /// Subtracts harmonics.
    fn subtract_waves(&self, orders: &[CandidateOrder], waves: &[Complex], values: &mut [f64]) {
        let mut tables: Vec<(usize, Vec<f64>)> = Vec::new();
        for (order, &wave) in orders.iter().zip(waves) {
            let step = order.value / self.signal.samples_per_rev as f64;
            let Some(period) = self.period(order) else {
                subtract(values, wave, step, self.signal.first as f64);
                continue;
            };
            let index = tables.iter().position(|t| t.0 == period);
            let index = index.unwrap_or_else(|| {
                tables.push((period, vec![0.0; period]));
                tables.len() - 1
            });
            subtract(&mut tables[index].1, wave, step, 0.0);
        }
        // A table whose period divides a longer one is added to the longer one, which saves a pass over the record.
        tables.sort_by_key(|t| t.0);
        let mut merged: Vec<(usize, Vec<f64>)> = Vec::new();
        for (period, table) in tables.into_iter().rev() {
            match merged
                .iter_mut()
                .find(|longer| longer.0.is_multiple_of(period))
            {
                Some((_, sums)) => sums.chunks_mut(period).for_each(|segment| {
                    segment.iter_mut().zip(&table).for_each(|(s, t)| *s += t);
                }),
                None => merged.push((period, table)),
            }
        }
        for (period, table) in merged {
            for (segment, start) in period_segments(values.len(), self.signal.first, period) {
                (values[segment].iter_mut().zip(&table[start..])).for_each(|(e, t)| *e += t);
            }
        }
    }
}

/// Phasors `e^{i 2π step (first + m)}` for m = 0, 1, …: exact at intervals, by recursive rotation between.
fn phasors(count: usize, step: f64, first: f64) -> impl Iterator<Item = Complex> {
    let rotation = Complex::from_polar(1.0, TAU * step);
    let mut phasor = Complex::ONE;
    (0..count).map(move |m| {
        phasor = match m % PHASOR_RESTART {
            0 => Complex::from_polar(1.0, TAU * (step * (first + m as f64)).rem_euclid(1.0)),
            _ => phasor * rotation,
        };
        phasor
    })
}

fn correlate(values: &[f64], step: f64, first: f64) -> Complex {
    let mut sum = Complex::ZERO;
    for (e, p) in values.iter().zip(phasors(values.len(), step, first)) {
        sum.re += e * p.re;
        sum.im -= e * p.im;
    }
    sum
}

fn subtract(values: &mut [f64], wave: Complex, step: f64, first: f64) {
    let count = values.len();
    for (e, p) in values.iter_mut().zip(phasors(count, step, first)) {
        *e -= wave.re * p.re - wave.im * p.im;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order(top: i64, bottom: i64) -> CandidateOrder {
        let exact = Fraction::new(top, bottom);
        CandidateOrder {
            value: exact.to_f64(),
            fraction: exact,
            names: Vec::new(),
            unresolved: Vec::new(),
        }
    }

    /// Waves of integer and fractional orders are recovered to rounding for any number of revolutions and any start.
    #[test]
    fn exact_waves() {
        let orders = [
            order(1, 1),
            order(3, 1),
            order(64, 21),
            order(64, 1),
            order(5, 3),
        ];
        for (count, first) in [(5000, -317), (40_013, 91_000), (2117, 0)] {
            let mut signal = AngularSignal {
                samples_per_rev: 96,
                first,
                values: vec![0.0; count],
            };
            let truth: Vec<Complex> = (0..orders.len())
                .map(|k| Complex::from_polar(1.0 + k as f64, 0.9 * k as f64 - 2.0))
                .collect();
            for m in 0..count {
                let angle = signal.angle(m);
                let wave = |(o, z): (&CandidateOrder, &Complex)| {
                    (z * Complex::from_polar(1.0, o.value * angle)).re
                };
                signal.values[m] = 7.0 + orders.iter().zip(&truth).map(wave).sum::<f64>();
            }
            let found = fit_orders(&signal, &orders).unwrap();
            assert!((found.mean - 7.0).abs() < 1e-9);
            for (z, t) in found.waves.iter().zip(&truth) {
                assert!((z - t).norm() < 1e-8, "{z} {t}");
            }
            assert!(found.residual.iter().all(|r| r.abs() < 1e-8));
            for spread in &found.variance_factor {
                assert!(spread * count as f64 > 1.9 && spread * (count as f64) < 4.0);
            }
        }
    }
}
