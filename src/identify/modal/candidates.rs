//! Poles of one model order, with shape and participation where the method gives them.

use std::f64::consts::TAU;

use crate::numeric::Complex;
use crate::numeric::sorting::sort_ascending;

/// A pole that may be a mode or may model noise.
#[derive(Debug, Clone)]
pub struct CandidatePole {
    /// Pole in the upper half plane, left of the imaginary axis, rad/s.
    pub pole: Complex,
    /// Shape over the outputs, the largest component 1; empty where the method gives none.
    pub shape: Vec<Complex>,
    /// Modal participation over the inputs, the largest component 1; empty where the method gives none.
    pub participation: Vec<Complex>,
}

impl CandidatePole {
    /// Without shape or participation.
    pub fn from_pole(pole: Complex) -> CandidatePole {
        CandidatePole {
            pole,
            shape: Vec::new(),
            participation: Vec::new(),
        }
    }

    /// Damping ratio `−Re p/|p|`.
    pub fn damping_ratio(&self) -> f64 {
        -self.pole.re / self.pole.norm()
    }
}

/// All poles of one order inside the band, by rising |p|.
#[derive(Debug, Clone)]
pub struct OrderPoles {
    /// Order of the denominator.
    pub order: usize,
    /// Candidate poles of this order.
    pub poles: Vec<CandidatePole>,
}

impl OrderPoles {
    /// Sorts the poles.
    pub fn new(order: usize, mut poles: Vec<CandidatePole>) -> OrderPoles {
        sort_ascending(&mut poles, |a| a.pole.norm());
        OrderPoles { order, poles }
    }
}

/// Whether a pole is oscillatory, decays and has its half-power points inside the band: those at the ends model what lies beyond.
pub fn half_power_band_is_inside(pole: Complex, (low_hz, high_hz): (f64, f64)) -> bool {
    let half_band = pole.re.abs();
    pole.re < 0.0 && pole.im - half_band >= TAU * low_hz && pole.im + half_band <= TAU * high_hz
}

/// Divides by the component of largest modulus; a zero vector stays.
pub fn normalize_to_largest(mut shape: Vec<Complex>) -> Vec<Complex> {
    let mut largest = Complex::ZERO;
    for &z in &shape {
        if z.norm_sqr() > largest.norm_sqr() {
            largest = z;
        }
    }
    if largest != Complex::ZERO {
        shape.iter_mut().for_each(|z| *z /= largest);
    }
    shape
}
