//! Frequency response by superposition of real or complex modes, with a static term.
//!
//! All modes are included, so the sum is exact up to rounding.

use super::system::InputOutputSystem;
use crate::base::error::Error;
use crate::modes::modal_basis::ModalBasis;
use crate::modes::state_space::first_order::first_order;
use crate::modes::system_matrices::SystemMatrices;
use crate::numeric::vector_ops::dot;
use crate::numeric::{Complex, ComplexMatrix, Matrix, eigen, symmetric};

/// Modal superposition of an input–output system.
pub struct ModalSum {
    system: InputOutputSystem,
    real: RealModes,
    complex: Option<ComplexModes>,
    /// Static term `c K⁻¹ b` of the massless coordinates, outputs by inputs.
    static_term: Matrix,
}

/// Real modes with the response `Σ_k r_k / (K_k − ω² + i (d_k ω + h_k sgn ω))`.
struct RealModes {
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    hysteretic: Vec<f64>,
    /// Residues `r_k` of every output row and input column, column by column.
    residues: Vec<Vec<f64>>,
}

/// Complex modes with the response `Σ_k r_k / (s − λ_k)`.
struct ComplexModes {
    roots: Vec<Complex>,
    /// Residues `r_k` of every output row and input column, column by column.
    residues: Vec<Vec<Complex>>,
}

impl RealModes {
    /// Modes of the first `modes` coordinates with output rows and input columns.
    fn new(
        (outputs, inputs): (&Matrix, &Matrix),
        e: &SystemMatrices,
        basis: &ModalBasis,
        modes: usize,
    ) -> RealModes {
        RealModes {
            stiffness: (0..modes).map(|k| stiffness(e, basis, k, k)).collect(),
            damping: (0..modes).map(|k| e.damping[(k, k)]).collect(),
            hysteretic: (0..modes)
                .map(|k| e.hysteretic.as_ref().map_or(0.0, |h| h[(k, k)]))
                .collect(),
            residues: residues(outputs.nrows(), inputs.ncols(), |row, column| {
                (0..modes)
                    .map(|k| outputs[(row, k)] * inputs[(k, column)])
                    .collect()
            }),
        }
    }

    /// Real and imaginary parts of the modal receptances `1 / (K_k − ω² + i (d_k ω + h_k sgn ω))`.
    fn weights(&self, omega: f64) -> (Vec<f64>, Vec<f64>) {
        let sign = if omega == 0.0 { 0.0 } else { omega.signum() };
        (0..self.stiffness.len())
            .map(|k| {
                let re = self.stiffness[k] - omega * omega;
                let im = self.damping[k] * omega + self.hysteretic[k] * sign;
                let square = re * re + im * im;
                (re / square, -im / square)
            })
            .unzip()
    }
}

/// Evaluates `terms` for every output row and input column, column by column.
fn residues<T>(rows: usize, columns: usize, terms: impl Fn(usize, usize) -> Vec<T>) -> Vec<Vec<T>> {
    (0..columns)
        .flat_map(|column| (0..rows).map(move |row| (row, column)))
        .map(|(row, column)| terms(row, column))
        .collect()
}

impl ModalSum {
    /// Decouples a system in the modal coordinates of [`InputOutputSystem::modal_system`]; `None` if that fails: a rigid-body mode coupled
    /// by damping, or non-proportional hysteretic damping.
    ///
    /// # Errors
    /// Errors of the eigenvalue problem.
    pub(super) fn new(
        system: InputOutputSystem,
        matrices: &SystemMatrices,
        basis: &ModalBasis,
    ) -> Result<Option<ModalSum>, Error> {
        let modes = basis.omega.len();
        if is_proportional(matrices, modes) {
            return ModalSum::from_real_modes(system, matrices, basis).map(Some);
        }
        if matrices.hysteretic.is_some() {
            return Ok(None);
        }
        ModalSum::from_complex_modes(system, matrices, basis)
    }

    /// Whether the modes are complex.
    pub fn is_complex(&self) -> bool {
        self.complex.is_some()
    }

    fn from_real_modes(
        system: InputOutputSystem,
        e: &SystemMatrices,
        basis: &ModalBasis,
    ) -> Result<ModalSum, Error> {
        let modes = basis.omega.len();
        let (outputs, inputs) = (system.output_matrix(), system.input_matrix());
        let real = RealModes::new((&outputs, &inputs), e, basis, modes);
        let count = system.len() - modes;
        let static_term = match count {
            0 => Matrix::zeros(outputs.nrows(), inputs.ncols()),
            _ => {
                let block =
                    Matrix::from_fn(count, count, |i, j| e.stiffness[(modes + i, modes + j)]);
                let loads = Matrix::from_fn(count, inputs.ncols(), |i, j| inputs[(modes + i, j)]);
                let reads = Matrix::from_fn(outputs.nrows(), count, |i, j| outputs[(i, modes + j)]);
                reads * symmetric::lu_solve(&block, &loads)?
            }
        };
        Ok(ModalSum {
            system,
            real,
            complex: None,
            static_term,
        })
    }

    fn from_complex_modes(
        system: InputOutputSystem,
        e: &SystemMatrices,
        basis: &ModalBasis,
    ) -> Result<Option<ModalSum>, Error> {
        let (rigid, n) = (system.rigid, system.len());
        let (outputs, inputs) = (system.output_matrix(), system.input_matrix());
        let is_coupled = |i: usize| {
            (0..n).any(|j| {
                j != i
                    && (e.damping[(i, j)] != 0.0
                        || e.damping[(j, i)] != 0.0
                        || e.stiffness[(i, j)] != 0.0
                        || e.stiffness[(j, i)] != 0.0)
            })
        };
        if (0..rigid).any(is_coupled) {
            return Ok(None);
        }
        let size = n - rigid;
        let block = |a: &Matrix| Matrix::from_fn(size, size, |i, j| a[(rigid + i, rigid + j)]);
        let elastic = SystemMatrices {
            mass: Matrix::from_fn(size, size, |i, j| {
                if i == j && rigid + i < basis.omega.len() {
                    1.0
                } else {
                    0.0
                }
            }),
            damping: block(&e.damping),
            stiffness: Matrix::from_fn(size, size, |i, j| {
                stiffness(e, basis, rigid + i, rigid + j)
            }),
            hysteretic: None,
            massless: (basis.omega.len() - rigid..size).collect(),
            names: e.names[rigid..].to_vec(),
            transform: Matrix::zeros(0, size),
        };
        let forces = Matrix::from_fn(size, inputs.ncols(), |i, j| inputs[(rigid + i, j)]);
        let state_space = first_order(&elastic, &forces)?;
        let reads = Matrix::from_fn(outputs.nrows(), size, |i, j| outputs[(i, rigid + j)]);
        let static_term = &reads * &state_space.r_from_u;
        let states = state_space.a.nrows();
        let mut complex = None;
        if states > 0 {
            let eigen = eigen::eigen(&state_space.a)?;
            let state_outputs = &reads * &state_space.r_from_x;
            let real = |a: &Matrix| {
                ComplexMatrix::from_fn(a.nrows(), a.ncols(), |i, j| Complex::new(a[(i, j)], 0.0))
            };
            let c = real(&state_outputs) * &eigen.right;
            let b = symmetric::lu_solve_complex(&eigen.right, &real(&state_space.b))?;
            complex = Some(ComplexModes {
                residues: residues(c.nrows(), b.ncols(), |row, column| {
                    (0..states).map(|k| c[(row, k)] * b[(k, column)]).collect()
                }),
                roots: eigen.values,
            });
        }
        Ok(Some(ModalSum {
            real: RealModes::new((&outputs, &inputs), e, basis, rigid),
            system,
            complex,
            static_term,
        }))
    }

    /// Frequency response, outputs by inputs, at `s = iω`, ω in rad/s; infinite or NaN at an undamped resonance.
    pub fn response_at(&self, omega: f64) -> ComplexMatrix {
        let s = Complex::new(0.0, omega);
        let (re, im) = self.real.weights(omega);
        let complex = self.complex.as_ref().map(|modes| {
            let weights = modes.roots.iter().map(|root| (s - root).inv());
            (modes, weights.collect::<Vec<_>>())
        });
        let rows = self.static_term.nrows();
        self.system.combine(s, |read, load| {
            let at = load * rows + read;
            let residues = &self.real.residues[at];
            let real = Complex::new(
                self.static_term[(read, load)] + dot(residues, &re),
                dot(residues, &im),
            );
            match &complex {
                None => real,
                Some((modes, weights)) => (modes.residues[at].iter().zip(weights))
                    .fold(real, |sum, (residue, weight)| sum + residue * weight),
            }
        })
    }
}

/// Modal stiffness; a diagonal entry equal to ω² up to rounding is replaced by the more accurate ω².
fn stiffness(e: &SystemMatrices, basis: &ModalBasis, i: usize, j: usize) -> f64 {
    match basis.omega.get(i) {
        Some(omega)
            if i == j
                && (e.stiffness[(i, i)] - omega * omega).abs()
                    <= SQUARE_TOLERANCE * e.stiffness[(i, i)].abs() =>
        {
            omega * omega
        }
        _ => e.stiffness[(i, j)],
    }
}

/// Relative difference of K and ω² attributed to rounding.
const SQUARE_TOLERANCE: f64 = 1e-9;

/// Tolerance of off-diagonal entries relative to the geometric mean of the diagonal; smaller ones are rounding.
const ROUNDING: f64 = 1e-11;

/// Whether damping and stiffness couple no modes, and the massless coordinates are undamped.
fn is_proportional(e: &SystemMatrices, modes: usize) -> bool {
    let n = e.len();
    let diagonal = |a: &Matrix| {
        let is_small =
            |i: usize, j: usize| a[(i, j)].abs() <= ROUNDING * (a[(i, i)] * a[(j, j)]).abs().sqrt();
        (0..n).all(|i| (0..n).all(|j| i == j || (i >= modes && j >= modes) || is_small(i, j)))
    };
    let zero = |a: &Matrix| (modes..n).all(|i| (modes..n).all(|j| a[(i, j)] == 0.0));
    let k_diagonal = {
        let is_small = |i: usize, j: usize| {
            e.stiffness[(i, j)].abs()
                <= ROUNDING * (e.stiffness[(i, i)] * e.stiffness[(j, j)]).abs().sqrt()
        };
        (0..n).all(|i| (0..n).all(|j| i == j || (i >= modes && j >= modes) || is_small(i, j)))
    };
    k_diagonal
        && diagonal(&e.damping)
        && zero(&e.damping)
        && e.hysteretic.as_ref().is_none_or(|h| diagonal(h) && zero(h))
}
