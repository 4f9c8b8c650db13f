//! Powers of s that go with real columns, rows and matrices.

use crate::numeric::Complex;

/// A power of s, and whether `i sgn(Im s)` goes with it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Factor {
    pub power: u8,
    pub lossy: bool,
}

impl Factor {
    pub const ONE: Factor = Factor {
        power: 0,
        lossy: false,
    };
    pub const S: Factor = Factor {
        power: 1,
        lossy: false,
    };
    pub const SS: Factor = Factor {
        power: 2,
        lossy: false,
    };
    pub const LOSSY: Factor = Factor {
        power: 0,
        lossy: true,
    };

    /// Its value at s.
    pub fn at(self, s: Complex) -> Complex {
        let power = (0..self.power).fold(Complex::new(1.0, 0.0), |z, _| z * s);
        match self.lossy {
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
