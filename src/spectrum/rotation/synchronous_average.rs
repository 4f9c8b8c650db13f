//! Synchronous average over revolutions: `a_i = 1/K Σ_k y_{i+kN}`; random parts fall by `1/√K`.
//!
//! S. Braun, The extraction of periodic waveforms by time domain averaging, Acustica 32 (1975), 69–77. For another shaft of the drive
//! train, resample over its angle, [`AngleCurve::scaled_by_ratio`] with the exact ratio of teeth.

use std::f64::consts::TAU;

use super::angle_curve::AngleCurve;
use super::angular_resampling::AngularSignal;
use super::interpolation::{HALF_KERNEL, SincInterpolator};
use crate::base::error::Error;
use crate::spectrum::validation::{check_positive, check_samples};

/// Synchronous average over the revolutions of a shaft.
#[derive(Debug, Clone)]
pub struct SynchronousAverage {
    /// Average over one revolution, the first value at angle zero.
    pub values: Vec<f64>,
    /// Number of revolutions averaged, `K`.
    pub revolutions: usize,
    /// Index of the first averaged sample, as [`AngularSignal::first`].
    pub first: i64,
    /// Signal of the `K` revolutions less the average.
    pub residual: Vec<f64>,
    /// Unbiased standard deviation of the residual (`K − 1` instead of `K` revolutions).
    pub residual_rms: f64,
    /// Standard error of the average, `residual_rms/√K`, if the residual is random.
    pub standard_error: f64,
}

impl SynchronousAverage {
    /// Averages all complete revolutions of a signal.
    ///
    /// # Errors
    /// Fewer than two revolutions.
    pub fn new(signal: &AngularSignal) -> Result<SynchronousAverage, Error> {
        signal.check_revolutions(2)?;
        let (n, turns) = (signal.samples_per_rev, signal.revolutions());
        let offset = signal.first.rem_euclid(n as i64) as usize;
        let values = &signal.values[..n * turns];
        let mut average = vec![0.0; n];
        for block in values.chunks_exact(n) {
            let (late, early) = average.split_at_mut(offset);
            let sums = early.iter_mut().chain(late);
            sums.zip(block).for_each(|(sum, x)| *sum += x);
        }
        average.iter_mut().for_each(|x| *x /= turns as f64);
        let residual: Vec<f64> = values
            .iter()
            .enumerate()
            .map(|(i, x)| x - average[(i + offset) % n])
            .collect();
        let square: f64 = residual.iter().map(|x| x * x).sum();
        let residual_rms = (square / (n * (turns - 1)) as f64).sqrt();
        Ok(SynchronousAverage {
            values: average,
            revolutions: turns,
            first: signal.first,
            residual,
            residual_rms,
            standard_error: residual_rms / (turns as f64).sqrt(),
        })
    }

    /// Reduction of random noise, dB of power: `10 log₁₀ K`.
    pub fn noise_reduction_db(&self) -> f64 {
        10.0 * (self.revolutions as f64).log10()
    }

    /// Samples less the average at the angle of each sample. Outside the angle curve the shaft is extrapolated at constant
    /// speed.
    ///
    /// # Errors
    /// Non-finite samples, a rate that is not positive.
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
        let residual = |(j, x): (usize, &f64)| {
            let turns = (curve.angle_at(j as f64 / rate_hz) / TAU).rem_euclid(1.0);
            x - kernel.value_at(&wrapped, turns * n as f64 + HALF_KERNEL as f64, 1.0)
        };
        Ok(samples.iter().enumerate().map(residual).collect())
    }
}
