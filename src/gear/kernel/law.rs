//! Laws of joints: the amount q(x) of a joint over the parameter of the motion, with its first two derivatives.

use std::sync::Arc;

/// Coefficients of a polynomial law: up to the fifth power, as sheets of modified roll go.
const COEFFICIENTS: usize = 6;

/// The amount q(x) of a joint.
#[derive(Clone)]
pub enum Law {
    /// `q = Σ cᵢ xⁱ`: constant ratio, modified roll, helical motion.
    Polynomial([f64; COEFFICIENTS]),
    /// `q = amplitude cos(order x + phase)`: a periodic error of a drive.
    Cosine {
        /// Amplitude.
        amplitude: f64,
        /// Cycles in 2π of x.
        order: f64,
        /// Phase, rad.
        phase: f64,
    },
    /// `[q, q′, q″]` of a function: the ratio of non-circular gears.
    Function(Arc<dyn Fn(f64) -> [f64; 3] + Send + Sync>),
}

impl Law {
    /// `q = rate x`.
    pub fn linear(rate: f64) -> Law {
        Law::Polynomial([0.0, rate, 0.0, 0.0, 0.0, 0.0])
    }

    /// `q = f(x)`, f giving `[q, q′, q″]`.
    pub fn function(f: impl Fn(f64) -> [f64; 3] + Send + Sync + 'static) -> Law {
        Law::Function(Arc::new(f))
    }

    /// The sum of laws; none of no laws.
    pub fn sum(mut laws: Vec<Law>) -> Option<Law> {
        let last = laws.pop()?;
        if laws.is_empty() {
            return Some(last);
        }
        laws.push(last);
        Some(Law::function(move |x| {
            laws.iter().fold([0.0; 3], |sum, law| {
                let of = law.at(x);
                [0, 1, 2].map(|i| sum[i] + of[i])
            })
        }))
    }

    /// `[q, q′, q″]` at x.
    pub fn at(&self, x: f64) -> [f64; 3] {
        match self {
            Law::Polynomial(coefficients) => horner(coefficients, x),
            Law::Cosine {
                amplitude,
                order,
                phase,
            } => {
                let (sin, cos) = (order * x + phase).sin_cos();
                let q = amplitude * cos;
                [q, -amplitude * order * sin, -order * order * q]
            }
            Law::Function(f) => f(x),
        }
    }
}

impl std::fmt::Debug for Law {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Law::Polynomial(c) => f.debug_tuple("Polynomial").field(c).finish(),
            Law::Cosine {
                amplitude,
                order,
                phase,
            } => write!(f, "Cosine({amplitude} cos({order} x + {phase}))"),
            Law::Function(_) => f.write_str("Function"),
        }
    }
}

/// A polynomial with its first two derivatives.
#[inline]
fn horner(coefficients: &[f64; COEFFICIENTS], x: f64) -> [f64; 3] {
    let [mut q, mut d, mut half_dd] = [0.0; 3];
    for c in coefficients.iter().rev() {
        half_dd = half_dd * x + d;
        d = d * x + q;
        q = q * x + c;
    }
    [q, d, 2.0 * half_dd]
}
