//! What matrices of all coordinates cost a method at least, known before any work.
//!
//! Methods that propagate go over all modes of the machine: a decomposition of order n, then the damped root of each mode. Implicit
//! methods factorise a matrix of the coordinates for every new step.

use crate::base::units::duration;
use crate::motion::methods::{Kin, Method};

/// The least that dense matrices of a method take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dense {
    /// Order of the matrices.
    pub coordinates: usize,
    /// Of what.
    pub what: &'static str,
    /// Seconds.
    pub seconds: f64,
    /// Bytes at a time.
    pub bytes: f64,
}

/// The room that matrices and histories may take, bytes.
pub const ROOM: f64 = 2e9;

impl Dense {
    /// Of a method and a machine of so many coordinates; nothing for methods without matrices.
    ///
    /// Seconds per n³ and bytes per n² as measured on chains of 500 to 2000 discs with unequal damping (docs/performance.md); another
    /// processor may be twice as fast.
    pub fn of(method: &Method, coordinates: usize) -> Option<Dense> {
        let (what, seconds, bytes) = match method.kin {
            Kin::Propagation => ("all modes", 2e-8, 300.0),
            Kin::Collocation => ("the first factors", 5e-10, 90.0),
            Kin::Newmark => ("the first factors", 3e-10, 50.0),
            #[cfg(feature = "bdf")]
            Kin::Multistep => ("the first factors", 5e-10, 90.0),
            Kin::Explicit => return None,
        };
        let n = coordinates as f64;
        Some(Dense {
            coordinates,
            what,
            seconds: seconds * n.powi(3),
            bytes: bytes * n * n,
        })
    }

    /// In words.
    pub fn told(&self) -> String {
        format!(
            "{} of {} coordinates would take about {} and {:.1} GB in dense matrices",
            self.what,
            self.coordinates,
            duration(self.seconds),
            1e-9 * self.bytes
        )
    }
}
