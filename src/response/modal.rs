//! Frequency response as a sum over real or complex modes, with a static term.
//!
//! Every mode counts, so that the sum is exact but for rounding.

use super::system::InputOutputSystem;
use crate::base::error::Error;
use crate::modes::modal_basis::ModalBasis;
use crate::modes::state_space::first_order::first_order;
use crate::modes::system_matrices::SystemMatrices;
use crate::numeric::vector_ops::dot;
use crate::numeric::{Complex, ComplexMatrix, Matrix, eigen, symmetric};

/// A system taken apart into modes.
pub struct ModalSum {
    system: InputOutputSystem,
    real: RealModes,
    complex: Option<ComplexModes>,
    /// c D⁻¹ b of what follows statically.
    static_term: Matrix,
}

/// Real modes: `Σ_k r_k / (K_k − ω² + i (d_k ω + h_k sgn ω))`.
struct RealModes {
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    lossy: Vec<f64>,
    /// `r_k` of every row and column, column by column.
    residues: Vec<Vec<f64>>,
}

/// Complex modes: `Σ_k r_k / (s − λ_k)`.
struct ComplexModes {
    roots: Vec<Complex>,
    /// `r_k` of every row and column, column by column.
    residues: Vec<Vec<Complex>>,
}

impl RealModes {
    /// The first `modes` coordinates, read by rows and loaded by columns.
    fn new(
        (reads, loads): (&Matrix, &Matrix),
        e: &SystemMatrices,
        basis: &ModalBasis,
        modes: usize,
    ) -> RealModes {
        RealModes {
            stiffness: (0..modes).map(|k| stiffness(e, basis, k, k)).collect(),
            damping: (0..modes).map(|k| e.damping[(k, k)]).collect(),
            lossy: (0..modes)
                .map(|k| e.hysteretic.as_ref().map_or(0.0, |h| h[(k, k)]))
                .collect(),
            residues: residues(reads.nrows(), loads.ncols(), |row, column| {
                (0..modes)
                    .map(|k| reads[(row, k)] * loads[(k, column)])
                    .collect()
            }),
        }
    }

    /// Real and imaginary parts of `1 / (K_k − ω² + i (d_k ω + h_k sgn ω))`.
    fn weights(&self, omega: f64) -> (Vec<f64>, Vec<f64>) {
        let sign = if omega == 0.0 { 0.0 } else { omega.signum() };
        (0..self.stiffness.len())
            .map(|k| {
                let re = self.stiffness[k] - omega * omega;
                let im = self.damping[k] * omega + self.lossy[k] * sign;
                let square = re * re + im * im;
                (re / square, -im / square)
            })
            .unzip()
    }
}

/// Terms of every row and column, column by column.
fn residues<T>(rows: usize, columns: usize, terms: impl Fn(usize, usize) -> Vec<T>) -> Vec<Vec<T>> {
    (0..columns)
        .flat_map(|column| (0..rows).map(move |row| (row, column)))
        .map(|(row, column)| terms(row, column))
        .collect()
}

impl ModalSum {
    /// The modes of a system over modal coordinates, those of [`InputOutputSystem::modal_system`]; `None` where they do not come apart: a rigid
    /// motion that damping couples to others, loss factors that are not proportional.
    ///
    /// # Errors
    /// Those of the eigenvalue problem.
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

    /// The modes are complex.
    pub fn is_complex(&self) -> bool {
        self.complex.is_some()
    }

    fn from_real_modes(
        system: InputOutputSystem,
        e: &SystemMatrices,
        basis: &ModalBasis,
    ) -> Result<ModalSum, Error> {
        let modes = basis.omega.len();
        let (all_reads, all_loads) = (system.read_rows(), system.load_columns());
        let real = RealModes::new((&all_reads, &all_loads), e, basis, modes);
        let light = system.len() - modes;
        let still = match light {
            0 => Matrix::zeros(all_reads.nrows(), all_loads.ncols()),
            _ => {
                let block =
                    Matrix::from_fn(light, light, |i, j| e.stiffness[(modes + i, modes + j)]);
                let loads =
                    Matrix::from_fn(light, all_loads.ncols(), |i, j| all_loads[(modes + i, j)]);
                let reads =
                    Matrix::from_fn(all_reads.nrows(), light, |i, j| all_reads[(i, modes + j)]);
                reads * symmetric::lu_solve(&block, &loads)?
            }
        };
        Ok(ModalSum {
            system,
            real,
            complex: None,
            static_term: still,
        })
    }

    fn from_complex_modes(
        system: InputOutputSystem,
        e: &SystemMatrices,
        basis: &ModalBasis,
    ) -> Result<Option<ModalSum>, Error> {
        let (rigid, n) = (system.rigid, system.len());
        let (all_reads, all_loads) = (system.read_rows(), system.load_columns());
        let couples = |i: usize| {
            (0..n).any(|j| {
                j != i
                    && (e.damping[(i, j)] != 0.0
                        || e.damping[(j, i)] != 0.0
                        || e.stiffness[(i, j)] != 0.0
                        || e.stiffness[(j, i)] != 0.0)
            })
        };
        if (0..rigid).any(couples) {
            return Ok(None);
        }
        let rest = n - rigid;
        let cut = |a: &Matrix| Matrix::from_fn(rest, rest, |i, j| a[(rigid + i, rigid + j)]);
        let elastic = SystemMatrices {
            mass: Matrix::from_fn(rest, rest, |i, j| {
                if i == j && rigid + i < basis.omega.len() {
                    1.0
                } else {
                    0.0
                }
            }),
            damping: cut(&e.damping),
            stiffness: Matrix::from_fn(rest, rest, |i, j| {
                stiffness(e, basis, rigid + i, rigid + j)
            }),
            hysteretic: None,
            massless: (basis.omega.len() - rigid..rest).collect(),
            names: e.names[rigid..].to_vec(),
            transform: Matrix::zeros(0, rest),
        };
        let forces = Matrix::from_fn(rest, all_loads.ncols(), |i, j| all_loads[(rigid + i, j)]);
        let first = first_order(&elastic, &forces)?;
        let reads = Matrix::from_fn(all_reads.nrows(), rest, |i, j| all_reads[(i, rigid + j)]);
        let still = &reads * &first.r_from_u;
        let states = first.a.nrows();
        let mut complex = None;
        if states > 0 {
            let eigen = eigen::eigen(&first.a)?;
            let seen = &reads * &first.r_from_x;
            let real = |a: &Matrix| {
                ComplexMatrix::from_fn(a.nrows(), a.ncols(), |i, j| Complex::new(a[(i, j)], 0.0))
            };
            let shown = real(&seen) * &eigen.right;
            let reached = symmetric::lu_solve_complex(&eigen.right, &real(&first.b))?;
            complex = Some(ComplexModes {
                residues: residues(shown.nrows(), reached.ncols(), |row, column| {
                    (0..states)
                        .map(|k| shown[(row, k)] * reached[(k, column)])
                        .collect()
                }),
                roots: eigen.values,
            });
        }
        Ok(Some(ModalSum {
            real: RealModes::new((&all_reads, &all_loads), e, basis, rigid),
            system,
            complex,
            static_term: still,
        }))
    }

    /// Outputs by inputs at `s = iω`, ω in rad/s; infinite or no number where nothing damps a resonance at ω.
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

/// `K` of modal coordinates: squares of the frequencies, which keep their digits, and what is no square next to them.
fn stiffness(e: &SystemMatrices, basis: &ModalBasis, i: usize, j: usize) -> f64 {
    match basis.omega.get(i) {
        Some(omega)
            if i == j
                && (e.stiffness[(i, i)] - omega * omega).abs()
                    <= SQUARE * e.stiffness[(i, i)].abs() =>
        {
            omega * omega
        }
        _ => e.stiffness[(i, j)],
    }
}

/// Relative: K summed from branches differs so from ω² of their squares by rounding, not by terms that are no squares.
const SQUARE: f64 = 1e-9;

/// Rounding tolerance relative to the geometric mean of the diagonal: smaller entries next to it are rounding of the sums.
const ROUNDING: f64 = 1e-11;

/// Nothing couples the modes to each other, nor to coordinates without inertia, and these only follow statically.
fn is_proportional(e: &SystemMatrices, modes: usize) -> bool {
    let n = e.len();
    let apart = |a: &Matrix| {
        let small =
            |i: usize, j: usize| a[(i, j)].abs() <= ROUNDING * (a[(i, i)] * a[(j, j)]).abs().sqrt();
        (0..n).all(|i| (0..n).all(|j| i == j || (i >= modes && j >= modes) || small(i, j)))
    };
    let at_rest = |a: &Matrix| (modes..n).all(|i| (modes..n).all(|j| a[(i, j)] == 0.0));
    let springs = {
        let small = |i: usize, j: usize| {
            e.stiffness[(i, j)].abs()
                <= ROUNDING * (e.stiffness[(i, i)] * e.stiffness[(j, j)]).abs().sqrt()
        };
        (0..n).all(|i| (0..n).all(|j| i == j || (i >= modes && j >= modes) || small(i, j)))
    };
    springs
        && apart(&e.damping)
        && at_rest(&e.damping)
        && e.hysteretic.as_ref().is_none_or(|h| apart(h) && at_rest(h))
}
