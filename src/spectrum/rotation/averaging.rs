//! Averages over turns: `a_i = 1/K Σ_k y_{i+kN}`, what repeats with a shaft; the rest falls by `1/√K`.
//!
//! S. Braun, The extraction of periodic waveforms by time domain averaging, Acustica 32 (1975), 69–77. For another shaft of the same train
//! take its own angle, `AngleCurve::geared` by the exact ratio of teeth, and resample over that.

use std::f64::consts::TAU;

use super::angle::AngleCurve;
use super::angular::AngularSignal;
use super::interpolation::{Interpolator, REACH};
use crate::base::error::Error;
use crate::spectrum::samples::{check, check_positive};

/// What repeats with every turn of a shaft.
#[derive(Debug, Clone)]
pub struct TurnAverage {
    /// One turn, the first value at angle zero.
    pub turn: Vec<f64>,
    /// Turns averaged, `K`.
    pub turns: usize,
    /// Number of the first turn's first value, as [`AngularSignal::first`].
    pub first: i64,
    /// What is left of the `K` turns without the average.
    pub residual: Vec<f64>,
    /// Standard deviation of what is left, free of bias (over `K − 1` of `K` turns).
    pub residual_rms: f64,
    /// Standard error of the average: `residual_rms/√K`, where what is left does not repeat.
    pub standard_error: f64,
}

impl TurnAverage {
    /// Of all whole turns of a signal.
    ///
    /// # Errors
    /// Fewer than two turns.
    pub fn new(signal: &AngularSignal) -> Result<TurnAverage, Error> {
        signal.check_turns(2)?;
        let (n, turns) = (signal.per_turn, signal.turns());
        let offset = signal.first.rem_euclid(n as i64) as usize;
        let values = &signal.values[..n * turns];
        let mut turn = vec![0.0; n];
        for block in values.chunks_exact(n) {
            let (late, early) = turn.split_at_mut(offset);
            let places = early.iter_mut().chain(late);
            places.zip(block).for_each(|(sum, x)| *sum += x);
        }
        turn.iter_mut().for_each(|x| *x /= turns as f64);
        let residual: Vec<f64> = values
            .iter()
            .enumerate()
            .map(|(i, x)| x - turn[(i + offset) % n])
            .collect();
        let square: f64 = residual.iter().map(|x| x * x).sum();
        let residual_rms = (square / (n * (turns - 1)) as f64).sqrt();
        Ok(TurnAverage {
            turn,
            turns,
            first: signal.first,
            residual,
            residual_rms,
            standard_error: residual_rms / (turns as f64).sqrt(),
        })
    }

    /// By how much noise that does not repeat is reduced, dB of power: `10 log₁₀ K`.
    pub fn noise_reduction_db(&self) -> f64 {
        10.0 * (self.turns as f64).log10()
    }

    /// The signal over time without what repeats with this shaft: the average, at each sample's angle, taken off. Outside the known
    /// angles the shaft is taken to go on at its last speed.
    ///
    /// # Errors
    /// Samples not finite, a rate that is not positive.
    pub fn remove_from(
        &self,
        samples: &[f64],
        rate_hz: f64,
        curve: &AngleCurve,
    ) -> Result<Vec<f64>, Error> {
        check(samples, 1)?;
        check_positive(rate_hz, "the sample rate, Hz,")?;
        let n = self.turn.len();
        let wrapped: Vec<f64> = (0..n + 2 * REACH)
            .map(|j| self.turn[(j + n - REACH % n) % n])
            .collect();
        let kernel = Interpolator::default();
        let rest = |(j, x): (usize, &f64)| {
            let turns = (curve.at(j as f64 / rate_hz) / TAU).rem_euclid(1.0);
            x - kernel.at(&wrapped, turns * n as f64 + REACH as f64, 1.0)
        };
        Ok(samples.iter().enumerate().map(rest).collect())
    }
}
