//! Transform between modal states `(η, η̇, z)` and the states σ of the modal parts.
//!
//! A modal state is `(η, η̇, z)`: modes, their rates, inner states.

use crate::numeric::Matrix;
use crate::numeric::vector_ops::gemv;

/// Transform between modal states and the states σ of the parts.
#[derive(Debug)]
pub enum ModalTransform {
    /// Every mode is a part of its own, with two states.
    Pairs(Vec<ModePair>),
    /// All are mixed.
    Full {
        /// Modal state of σ.
        out: Matrix,
        /// σ of a modal state.
        into: Matrix,
    },
}

/// A mode: its two states in σ, and two-by-two matrices by rows.
#[derive(Debug, Clone, Copy)]
pub struct ModePair {
    /// Index of the first of its states; the other is the next.
    pub at: usize,
    /// (η, η̇) of the two.
    pub out: [f64; 4],
    /// The two of (η, η̇).
    pub into: [f64; 4],
}

impl ModalTransform {
    /// The modal state of σ, and σ of a modal state, as matrices; σ has `len` states.
    pub fn matrices(&self, len: usize) -> (Matrix, Matrix) {
        match self {
            ModalTransform::Full { out, into } => (out.clone(), into.clone()),
            ModalTransform::Pairs(pairs) => {
                let m = pairs.len();
                let (mut out, mut into) = (Matrix::zeros(2 * m, len), Matrix::zeros(len, 2 * m));
                for (j, pair) in pairs.iter().enumerate() {
                    for (i, (row, column)) in [(j, 0), (j, 1), (m + j, 0), (m + j, 1)]
                        .into_iter()
                        .enumerate()
                    {
                        out[(row, pair.at + column)] = pair.out[i];
                    }
                    for (i, (row, column)) in [(0, j), (0, m + j), (1, j), (1, m + j)]
                        .into_iter()
                        .enumerate()
                    {
                        into[(pair.at + row, column)] = pair.into[i];
                    }
                }
                (out, into)
            }
        }
    }

    /// σ of a modal state.
    pub fn to_parts(&self, modal: &[f64], sigma: &mut [f64]) {
        match self {
            ModalTransform::Pairs(pairs) => {
                for (j, pair) in pairs.iter().enumerate() {
                    let (eta, rate) = (modal[j], modal[pairs.len() + j]);
                    sigma[pair.at] = pair.into[0] * eta + pair.into[1] * rate;
                    sigma[pair.at + 1] = pair.into[2] * eta + pair.into[3] * rate;
                }
            }
            ModalTransform::Full { into, .. } => product(into, modal, sigma),
        }
    }

    /// A row over modal states as a row over σ.
    pub fn row(&self, modal: &[f64], len: usize) -> Vec<f64> {
        match self {
            ModalTransform::Pairs(pairs) => {
                let mut row = vec![0.0; len];
                for (j, pair) in pairs.iter().enumerate() {
                    let (eta, rate) = (modal[j], modal[pairs.len() + j]);
                    row[pair.at] = pair.out[0] * eta + pair.out[2] * rate;
                    row[pair.at + 1] = pair.out[1] * eta + pair.out[3] * rate;
                }
                row
            }
            ModalTransform::Full { out, .. } => (0..len)
                .map(|j| super::mass_normalised::dot(out.col_as_slice(j), modal))
                .collect(),
        }
    }
}

/// `A x`.
fn product(a: &Matrix, x: &[f64], out: &mut [f64]) {
    out.fill(0.0);
    gemv(out, x, |j| a.col_as_slice(j));
}
