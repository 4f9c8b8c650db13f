//! Lower bound of the cost of dense matrices of a method.
//!
//! Methods that propagate go over all modes of the machine: a decomposition of order n, then the damped root of each mode. Implicit
//! methods factorise a matrix of the coordinates for every new step.

use crate::base::quantity::format_duration;
use crate::motion::methods::{IntegrationMethod, MethodFamily};

/// The least that dense matrices of a method take.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DenseCost {
    /// Order of the matrices.
    pub coordinates: usize,
    /// Name of the computation in the message.
    pub subject: &'static str,
    /// Seconds.
    pub seconds: f64,
    /// Bytes at a time.
    pub bytes: f64,
}

/// The room that matrices and histories may take, bytes.
pub const MAX_BYTES: f64 = 2e9;

impl DenseCost {
    /// Dense cost of a method and a machine of so many coordinates; nothing for methods without matrices.
    ///
    /// Seconds per n³ and bytes per n² as measured on chains of 500 to 2000 discs with unequal damping (docs/performance.md); another
    /// processor may be twice as fast.
    pub fn for_method(method: &IntegrationMethod, coordinates: usize) -> Option<DenseCost> {
        let (what, seconds, bytes) = match method.family {
            MethodFamily::Propagation => ("all modes", 2e-8, 300.0),
            MethodFamily::Collocation => ("the first factors", 5e-10, 90.0),
            MethodFamily::Newmark => ("the first factors", 3e-10, 50.0),
            MethodFamily::Explicit => return None,
        };
        let n = coordinates as f64;
        Some(DenseCost {
            coordinates,
            subject: what,
            seconds: seconds * n.powi(3),
            bytes: bytes * n * n,
        })
    }

    /// In words.
    pub fn text(&self) -> String {
        format!(
            "{} of {} coordinates would take about {} and {:.1} GB in dense matrices",
            self.subject,
            self.coordinates,
            format_duration(self.seconds),
            1e-9 * self.bytes
        )
    }
}
