//! Noise for tests. Neighbouring seeds of fastrand give numbers that are correlated by a quarter: multiply them first.

use std::f64::consts::TAU;

/// A standard normal number by Box and Muller.
pub fn normal(rng: &mut fastrand::Rng) -> f64 {
    (-2.0 * (1.0 - rng.f64()).ln()).sqrt() * (TAU * rng.f64()).cos()
}
