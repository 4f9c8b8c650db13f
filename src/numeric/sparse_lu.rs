//! Sparse complex LU with a fixed pattern: one symbolic factorisation, many values.

use faer::linalg::solvers::Solve;
use faer::sparse::linalg::solvers::{Lu, SymbolicLu};
use faer::sparse::{SparseColMatRef, SymbolicSparseColMat};

use super::{Complex, ComplexMatrix};
use crate::base::code::Code;
use crate::base::error::Error;

/// A pattern, and the order its systems are eliminated in.
pub struct SymbolicFactor {
    layout: SymbolicSparseColMat<usize>,
    order: SymbolicLu<usize>,
}

impl SymbolicFactor {
    /// Builds the pattern from the entries (row, column) that may differ from zero, by columns, rows rising, none twice.
    ///
    /// # Errors
    /// `BudgetExceeded` where memory runs out.
    pub fn new(
        n: usize,
        entries: impl IntoIterator<Item = (usize, usize)>,
    ) -> Result<SymbolicFactor, Error> {
        let (mut start, mut rows) = (vec![0; n + 1], Vec::new());
        for (row, column) in entries {
            start[column + 1] += 1;
            rows.push(row);
        }
        (0..n).for_each(|j| start[j + 1] += start[j]);
        let layout = SymbolicSparseColMat::new_checked(n, n, start, None, rows);
        let memory = format!("no memory to factorise a matrix of {n} rows");
        let order = SymbolicLu::try_new(layout.as_ref())
            .map_err(|_| Error::new(Code::BudgetExceeded, memory))?;
        Ok(SymbolicFactor { layout, order })
    }

    /// `A⁻¹ B` for the values of the entries, in their order.
    ///
    /// # Errors
    /// `NotPositiveDefinite` where A is singular to working precision.
    pub fn solve(&self, values: &[Complex], b: &ComplexMatrix) -> Result<ComplexMatrix, Error> {
        let singular = || {
            Error::new(
                Code::NotPositiveDefinite,
                "a sparse linear system is singular",
            )
        };
        let matrix = SparseColMatRef::new(self.layout.as_ref(), values);
        let lu = Lu::try_new_with_symbolic(self.order.clone(), matrix).map_err(|_| singular())?;
        let x: ComplexMatrix = lu.solve(b);
        let finite = |j: usize| {
            x.col_as_slice(j)
                .iter()
                .all(|z| z.re.is_finite() && z.im.is_finite())
        };
        match (0..x.ncols()).all(finite) {
            true => Ok(x),
            false => Err(singular()),
        }
    }
}
