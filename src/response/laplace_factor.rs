//! Powers of s, with or without `i sgn(Im s)`, that multiply real vectors and matrices.

use crate::numeric::Complex;

/// A power of s, and whether `i sgn(Im s)` goes with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct LaplaceFactor {
    pub power: u8,
    pub hysteretic: bool,
}

impl LaplaceFactor {
    pub const ONE: LaplaceFactor = LaplaceFactor {
        power: 0,
        hysteretic: false,
    };
    pub const S: LaplaceFactor = LaplaceFactor {
        power: 1,
        hysteretic: false,
    };
    pub const S_SQUARED: LaplaceFactor = LaplaceFactor {
        power: 2,
        hysteretic: false,
    };
    pub const HYSTERETIC: LaplaceFactor = LaplaceFactor {
        power: 0,
        hysteretic: true,
    };

    /// Value of the factor at s.
    pub fn value_at(self, s: Complex) -> Complex {
        let power = (0..self.power).fold(Complex::new(1.0, 0.0), |z, _| z * s);
        match self.hysteretic {
            true => power * Complex::new(0.0, sign(s)),
            false => power,
        }
    }
}

/// `sgn(Im s)`, zero at zero.
pub(super) fn sign(s: Complex) -> f64 {
    match s.im {
        0.0 => 0.0,
        im => im.signum(),
    }
}
