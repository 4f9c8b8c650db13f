//! LU factorisation kept for several right-hand sides.

use faer::linalg::solvers::{PartialPivLu, SolveCore};
use faer::{Conj, Mat, MatMut};

use super::{Complex, ComplexMatrix, Matrix, registers};
use crate::base::code::Code;
use crate::base::error::Error;

/// Factors of a real matrix.
#[derive(Debug, Clone)]
pub struct Lu(PartialPivLu<f64>);

/// Factors of a complex matrix.
#[derive(Debug, Clone)]
pub struct ComplexLu(PartialPivLu<Complex>);

impl Lu {
    /// Factors `a`, with row exchanges.
    ///
    /// # Errors
    /// `NotPositiveDefinite` where it is singular to working precision.
    pub fn new(a: &Matrix) -> Result<Lu, Error> {
        let lu = a.partial_piv_lu();
        registers::zero_upper();
        check((0..a.nrows()).map(|i| lu.U()[(i, i)].abs()))?;
        Ok(Lu(lu))
    }

    /// `A⁻¹ b`, in place.
    pub fn solve(&self, b: &mut [f64]) {
        let rows = b.len();
        self.0
            .solve_in_place_with_conj(Conj::No, MatMut::from_column_major_slice_mut(b, rows, 1));
        registers::zero_upper();
    }

    /// `A⁻¹ B`.
    pub fn solve_matrix(&self, b: &Matrix) -> Matrix {
        let mut x: Mat<f64> = b.clone();
        self.0.solve_in_place_with_conj(Conj::No, x.as_mut());
        x
    }
}

impl ComplexLu {
    /// Factors `a`, with row exchanges.
    ///
    /// # Errors
    /// `NotPositiveDefinite` where it is singular to working precision.
    pub fn new(a: &ComplexMatrix) -> Result<ComplexLu, Error> {
        let lu = a.partial_piv_lu();
        registers::zero_upper();
        check((0..a.nrows()).map(|i| lu.U()[(i, i)].norm()))?;
        Ok(ComplexLu(lu))
    }

    /// `A⁻¹ b`, in place.
    pub fn solve(&self, b: &mut [Complex]) {
        let rows = b.len();
        self.0
            .solve_in_place_with_conj(Conj::No, MatMut::from_column_major_slice_mut(b, rows, 1));
        registers::zero_upper();
    }
}

fn check(pivots: impl Iterator<Item = f64>) -> Result<(), Error> {
    for (i, size) in pivots.enumerate() {
        if !(size > 0.0 && size.is_finite()) {
            return Err(Error::new(
                Code::NotPositiveDefinite,
                format!("a linear system is singular: pivot {i} is {size}"),
            ));
        }
    }
    Ok(())
}
