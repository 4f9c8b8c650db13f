//! Synchronous average over revolutions: `a_i = 1/K Σ_k y_{i+kN}`; random parts fall by `1/√K`.
//!
//! S. Braun, The extraction of periodic waveforms by time domain averaging, Acustica 32 (1975), 69–77. For another shaft of the same train
//! take its own angle, `AngleCurve::geared` by the exact ratio of teeth, and resample over that.

use std::f64::consts::TAU;

use super::angle_curve::AngleCurve;
use super::angular_resampling::AngularSignal;
use super::interpolation::{HALF_KERNEL, SincInterpolator};
use crate::base::error::Error;
use crate::spectrum::validation::{check_positive, check_samples};

/// Synchronous average over the turns of a shaft.
#[derive(Debug, Clone)]
pub struct SynchronousAverage {
    /// One turn, the first value at angle zero.
    pub values: Vec<f64>,
    /// Turns averaged, `K`.
    pub revolutions: usize,
    /// Number of the first turn's first value, as [`AngularSignal::first`].
    pub first: i64,
    /// Residual of the `K` turns without the average.
    pub residual: Vec<f64>,
    /// Standard deviation of what is left, free of bias (over `K − 1` of `K` turns).
    pub residual_rms: f64,
    /// Standard error of the average: `residual_rms/√K`, where what is left does not repeat.
    pub standard_error: f64,
}

impl SynchronousAverage {
    /// Average over all whole turns of a signal.
    ///
    /// # Errors
    /// Fewer than two turns.
    pub fn new(signal: &AngularSignal) -> Result<SynchronousAverage, Error> {
        signal.check_revolutions(2)?;
        let (n, turns) = (signal.samples_per_rev, signal.revolutions());
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
        Ok(SynchronousAverage {
            values: turn,
            revolutions: turns,
            first: signal.first,
            residual,
            residual_rms,
            standard_error: residual_rms / (turns as f64).sqrt(),
        })
    }

    /// By how much noise that does not repeat is reduced, dB of power: `10 log₁₀ K`.
    pub fn noise_reduction_db(&self) -> f64 {
        10.0 * (self.revolutions as f64).log10()
    }

    /// The signal over time without what repeats with this shaft: the average, at each sample's angle, taken off. Outside the known
    /// angles the shaft is taken to go on at its last speed.
    ///
    /// # Errors
    /// Samples not finite, a rate that is not positive.
    pub fn subtract_from(
        &self,
        samples: &[f64],
        rate_hz: f64,
        curve: &AngleCurve,
    ) -> Result<Vec<f64>, Error> {
        check_samples(samples, 1)?;
        check_positive(rate_hz, "the sample rate, Hz,")?;
        let n = self.values.len();
        let wrapped: Vec<f64> = (0..n + 2 * HALF_KERNEL)
            .map(|j| self.values[(j + n - HALF_KERNEL % n) % n])
            .collect();
        let kernel = SincInterpolator::default();
        let rest = |(j, x): (usize, &f64)| {
            let turns = (curve.angle_at(j as f64 / rate_hz) / TAU).rem_euclid(1.0);
            x - kernel.value_at(&wrapped, turns * n as f64 + HALF_KERNEL as f64, 1.0)
        };
        Ok(samples.iter().enumerate().map(rest).collect())
    }
}
