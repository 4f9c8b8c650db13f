//! Sparse symmetric matrices, and their factorisation `A = Pᵀ L D Lᵀ P` with a count of negative eigenvalues.
//!
//! For machines that are no forest. K stands assembled here, so a lowest eigenvalue keeps as many digits as the spread of the springs
//! leaves it: about 16 less the decades of λ_max/λ_min.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::cholesky::ldlt::factor::LdltRegularization;
use faer::sparse::linalg::SupernodalThreshold;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, LdltRef, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMatRef};
use faer::{Conj, MatMut, Par, Side};

use crate::base::code::Code;
use crate::base::error::Error;

/// Growth of the pivots above this leaves fewer than half the digits: the shift is then moved.
const MAX_PIVOT_GROWTH: f64 = 1e8;

/// By how much a shift is moved, relative, each time twice as far.
const SHIFT_PERTURBATION: f64 = 1e-7;

/// Maximum number of shift moves.
const MAX_MOVES: usize = 8;

/// A sparse symmetric matrix, its lower triangle by columns, rows ascending, the diagonal always stored.
#[derive(Debug, Clone, PartialEq)]
pub struct SparseSymmetric {
    start: Vec<usize>,
    rows: Vec<usize>,
    values: Vec<f64>,
}

impl SparseSymmetric {
    /// From entries (row, column, value), repeated ones summed in the order given.
    ///
    /// Each pair of degrees of freedom is given once, in either triangle.
    pub fn from_entries(n: usize, entries: &[(usize, usize, f64)]) -> SparseSymmetric {
        let mut all: Vec<(usize, usize, f64)> = (0..n).map(|i| (i, i, 0.0)).collect();
        all.extend(
            entries
                .iter()
                .filter(|e| e.0 < n && e.1 < n)
                .map(|&(i, j, v)| (i.max(j), i.min(j), v)),
        );
        all.sort_by_key(|&(i, j, _)| (j, i));
        all.dedup_by(|next, kept| {
            let same = (next.0, next.1) == (kept.0, kept.1);
            if same {
                kept.2 += next.2;
            }
            same
        });
        let mut start = vec![0; n + 1];
        all.iter().for_each(|e| start[e.1 + 1] += 1);
        for j in 0..n {
            start[j + 1] += start[j];
        }
        let (rows, values) = all.into_iter().map(|(i, _, v)| (i, v)).unzip();
        SparseSymmetric {
            start,
            rows,
            values,
        }
    }

    /// A diagonal matrix.
    pub fn diagonal(values: &[f64]) -> SparseSymmetric {
        let n = values.len();
        SparseSymmetric {
            start: (0..=n).collect(),
            rows: (0..n).collect(),
            values: values.to_vec(),
        }
    }

    /// The number of rows.
    pub fn len(&self) -> usize {
        self.start.len() - 1
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// `y = A x`.
    pub fn mul_vec(&self, x: &[f64], y: &mut [f64]) {
        if self.rows.len() == self.len() {
            y.iter_mut()
                .zip(x)
                .zip(&self.values)
                .for_each(|((y, x), v)| *y = v * x);
            return;
        }
        y.fill(0.0);
        for j in 0..self.len() {
            let first = self.start[j];
            y[j] += self.values[first] * x[j];
            for at in first + 1..self.start[j + 1] {
                let i = self.rows[at];
                y[i] += self.values[at] * x[j];
                y[j] += self.values[at] * x[i];
            }
        }
    }

    /// `A − σ B`.
    pub fn sub_scaled(&self, sigma: f64, other: &SparseSymmetric) -> SparseSymmetric {
        let mut entries: Vec<(usize, usize, f64)> = self.entries().collect();
        entries.extend(other.entries().map(|(i, j, v)| (i, j, -sigma * v)));
        SparseSymmetric::from_entries(self.len(), &entries)
    }

    /// The stored entries (row, column, value), row ≥ column.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> {
        (0..self.len()).flat_map(move |j| {
            (self.start[j]..self.start[j + 1]).map(move |at| (self.rows[at], j, self.values[at]))
        })
    }
}

/// A factorised sparse symmetric matrix.
pub struct LdlFactor {
    matrix: SparseSymmetric,
    /// Powers of two that bring the diagonal near one, so that units do not decide.
    scale: Vec<f64>,
    symbolic: SymbolicCholesky<usize>,
    values: Vec<f64>,
    negative: usize,
    shift: f64,
}

impl LdlFactor {
    /// Factorises A by LDLᵀ in an order that keeps it sparse, without exchanging rows for the sake of size.
    ///
    /// Refused where a pivot vanishes, or is so small that D outgrows A by 1e8: then the count of negative pivots could not be trusted.
    pub fn new(matrix: &SparseSymmetric) -> Result<LdlFactor, Error> {
        let n = matrix.len();
        if !matrix.values.iter().all(|v| v.is_finite()) {
            return Err(Error::new(
                Code::Overflow,
                "an entry of a sparse matrix is not finite",
            ));
        }
        let mut largest = vec![0.0_f64; n];
        for (i, j, v) in matrix.entries() {
            let square = if i == j { v.abs() } else { 0.0 };
            largest[i] = largest[i].max(square);
        }
        let scale: Vec<f64> = largest
            .iter()
            .map(|&d| {
                if d > 0.0 {
                    (-0.5 * d.log2()).round().exp2()
                } else {
                    1.0
                }
            })
            .collect();
        let scaled: Vec<f64> = matrix
            .entries()
            .map(|(i, j, v)| v * scale[i] * scale[j])
            .collect();
        let pattern = SymbolicSparseColMatRef::new_checked(n, n, &matrix.start, None, &matrix.rows);
        let params = CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SIMPLICIAL,
            ..Default::default()
        };
        let memory = |_| {
            Error::new(
                Code::BudgetExceeded,
                format!("no memory to factorise a matrix of {n} rows"),
            )
        };
        let symbolic =
            factorize_symbolic_cholesky(pattern, Side::Lower, SymmetricOrdering::Amd, params)
                .map_err(|_| memory(()))?;
        let mut values = vec![0.0; symbolic.len_val()];
        let need = symbolic.factorize_numeric_ldlt_scratch::<f64>(Par::Seq, Default::default());
        let mut buffer = MemBuffer::try_new(need).map_err(|_| memory(()))?;
        symbolic
            .factorize_numeric_ldlt(
                &mut values,
                SparseColMatRef::new(pattern, &scaled),
                Side::Lower,
                LdltRegularization::default(),
                Par::Seq,
                MemStack::new(&mut buffer),
                Default::default(),
            )
            .map_err(|_| vanishing(0.0))?;
        let size = scaled.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
        let (negative, growth) = pivots(&symbolic, &values);
        if growth > MAX_PIVOT_GROWTH * size || !growth.is_finite() {
            return Err(vanishing(growth / size));
        }
        Ok(LdlFactor {
            matrix: matrix.clone(),
            scale,
            symbolic,
            values,
            negative,
            shift: 0.0,
        })
    }

    /// Factorises `K − σM`, with σ moved by some 1e-7 of itself where it falls on an eigenvalue; [`LdlFactor::shift`] is the one used.
    pub fn shifted(
        stiffness: &SparseSymmetric,
        mass: &SparseSymmetric,
        sigma: f64,
    ) -> Result<LdlFactor, Error> {
        let mut moved = sigma;
        for attempt in 0..MAX_MOVES {
            match LdlFactor::new(&stiffness.sub_scaled(moved, mass)) {
                Ok(factor) => {
                    return Ok(LdlFactor {
                        shift: moved,
                        ..factor
                    });
                }
                Err(error) if error.code != Code::NoConvergence || sigma == 0.0 => {
                    return Err(error);
                }
                Err(_) => moved = sigma * (1.0 + SHIFT_PERTURBATION * (1 << attempt) as f64),
            }
        }
        LdlFactor::new(&stiffness.sub_scaled(moved, mass))
    }

    /// Overwrites f by `A⁻¹ f`, refined once.
    pub fn solve_in_place(&self, f: &mut [f64]) {
        let mut x = f.to_vec();
        self.solve_once(&mut x);
        let mut residual = vec![0.0; f.len()];
        self.matrix.mul_vec(&x, &mut residual);
        residual
            .iter_mut()
            .zip(f.iter())
            .for_each(|(r, f)| *r = f - *r);
        self.solve_once(&mut residual);
        f.iter_mut()
            .zip(x.iter().zip(&residual))
            .for_each(|(f, (x, r))| *f = x + r);
    }

    fn solve_once(&self, f: &mut [f64]) {
        let n = f.len();
        f.iter_mut().zip(&self.scale).for_each(|(f, s)| *f *= s);
        let mut buffer = MemBuffer::new(self.symbolic.solve_in_place_scratch::<f64>(1, Par::Seq));
        LdltRef::new(&self.symbolic, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(f, n, 1),
            Par::Seq,
            MemStack::new(&mut buffer),
        );
        f.iter_mut().zip(&self.scale).for_each(|(f, s)| *f *= s);
    }

    /// Number of negative eigenvalues: for `K − σM`, of eigenvalues of (K, M) below σ.
    pub fn n_negative(&self) -> usize {
        self.negative
    }

    /// The shift after any moving.
    pub fn shift(&self) -> f64 {
        self.shift
    }
}

/// Negative pivots, and the largest `|d| l²` of any column: what LDLᵀ carries next to the matrix.
fn pivots(symbolic: &SymbolicCholesky<usize>, values: &[f64]) -> (usize, f64) {
    let SymbolicCholeskyRaw::Simplicial(simplicial) = symbolic.raw() else {
        return (0, f64::INFINITY);
    };
    let start = simplicial.col_ptr();
    let columns = start.windows(2).map(|span| &values[span[0]..span[1]]);
    columns.fold((0, 0.0), |(negative, growth), column| {
        let largest = column[1..].iter().fold(1.0_f64, |m, l| m.max(l.abs()));
        (
            negative + usize::from(column[0] < 0.0),
            f64::max(growth, column[0].abs() * largest * largest),
        )
    })
}

fn vanishing(growth: f64) -> Error {
    let message = match growth {
        0.0 => "a pivot of the sparse factorisation is zero".to_owned(),
        _ => format!("the sparse factorisation grows {growth:.1e} times above its matrix"),
    };
    Error::new(Code::NoConvergence, message).with_hint(
        "the shift is an eigenvalue, or a degree of freedom has no stiffness; move the shift",
    )
}
