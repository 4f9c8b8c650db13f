//! Frequency response as a sum over real or complex modes, with a static term.
//!
//! Every mode counts, so that the sum is exact but for rounding.

use super::system::InputOutputSystem;
use crate::base::error::Error;
use crate::modes::modal_basis::ModalBasis;
use crate::modes::state_space::first_order::first_order;
use crate::modes::system_matrices::SystemMatrices;
use crate::numeric::{Complex, ComplexMatrix, Matrix, eigen, symmetric};

/// A system taken apart into modes.
pub struct ModalSum {
    system: InputOutputSystem,
    terms: Vec<ModalTerm>,
    /// c D⁻¹ b of what follows statically.
    static_term: Matrix,
    complex: bool,
}

/// One mode between rows and columns: `c_k b_k / denominator(s)`.
struct ModalTerm {
    output_row: Vec<Complex>,
    input_column: Vec<Complex>,
    root: ModalDenominator,
}

enum ModalDenominator {
    /// `s² + 2 d s + ω² + i sgn h`.
    SecondOrder {
        damping: f64,
        stiffness: f64,
        lossy: f64,
    },
    /// `s − λ`.
    FirstOrder(Complex),
}

impl ModalDenominator {
    fn response_at(&self, s: Complex) -> Complex {
        match *self {
            ModalDenominator::SecondOrder {
                damping,
                stiffness,
                lossy,
            } => {
                let sign = if s.im == 0.0 { 0.0 } else { s.im.signum() };
                s * s + s * damping + Complex::new(stiffness, sign * lossy)
            }
            ModalDenominator::FirstOrder(lambda) => s - lambda,
        }
    }
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
        self.complex
    }

    fn from_real_modes(
        system: InputOutputSystem,
        e: &SystemMatrices,
        basis: &ModalBasis,
    ) -> Result<ModalSum, Error> {
        let modes = basis.omega.len();
        let (all_reads, all_loads) = (system.read_rows(), system.load_columns());
        let ports = (&all_reads, &all_loads);
        let terms = (0..modes)
            .map(|k| second_order_term(ports, e, basis, k))
            .collect();
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
            terms,
            static_term: still,
            complex: false,
        })
    }

    fn from_complex_modes(
        system: InputOutputSystem,
        e: &SystemMatrices,
        basis: &ModalBasis,
    ) -> Result<Option<ModalSum>, Error> {
        let (rigid, n) = (system.rigid, system.len());
        let (all_reads, all_loads) = (system.read_rows(), system.load_columns());
        let ports = (&all_reads, &all_loads);
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
        let mut terms: Vec<ModalTerm> = (0..rigid)
            .map(|k| second_order_term(ports, e, basis, k))
            .collect();
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
        if states > 0 {
            let eigen = eigen::eigen(&first.a)?;
            let seen = &reads * &first.r_from_x;
            let real = |a: &Matrix| {
                ComplexMatrix::from_fn(a.nrows(), a.ncols(), |i, j| Complex::new(a[(i, j)], 0.0))
            };
            let shown = real(&seen) * &eigen.right;
            let reached = symmetric::lu_solve_complex(&eigen.right, &real(&first.b))?;
            terms.extend((0..states).map(|k| ModalTerm {
                output_row: (0..shown.nrows()).map(|i| shown[(i, k)]).collect(),
                input_column: (0..reached.ncols()).map(|j| reached[(k, j)]).collect(),
                root: ModalDenominator::FirstOrder(eigen.values[k]),
            }));
        }
        Ok(Some(ModalSum {
            system,
            terms,
            static_term: still,
            complex: true,
        }))
    }

    /// Outputs by inputs at `s = iω`, ω in rad/s; infinite or no number where nothing damps a resonance at ω.
    pub fn response_at(&self, omega: f64) -> ComplexMatrix {
        let s = Complex::new(0.0, omega);
        let weights: Vec<Complex> = self
            .terms
            .iter()
            .map(|t| Complex::new(1.0, 0.0) / t.root.response_at(s))
            .collect();
        self.system.combine(s, |read, load| {
            let start = Complex::new(self.static_term[(read, load)], 0.0);
            self.terms.iter().zip(&weights).fold(start, |sum, (t, w)| {
                sum + t.output_row[read] * t.input_column[load] * w
            })
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

fn second_order_term(
    (reads, loads): (&Matrix, &Matrix),
    e: &SystemMatrices,
    basis: &ModalBasis,
    k: usize,
) -> ModalTerm {
    let real = |x: f64| Complex::new(x, 0.0);
    ModalTerm {
        output_row: (0..reads.nrows()).map(|i| real(reads[(i, k)])).collect(),
        input_column: (0..loads.ncols()).map(|j| real(loads[(k, j)])).collect(),
        root: ModalDenominator::SecondOrder {
            damping: e.damping[(k, k)],
            stiffness: stiffness(e, basis, k, k),
            lossy: e.hysteretic.as_ref().map_or(0.0, |h| h[(k, k)]),
        },
    }
}

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
