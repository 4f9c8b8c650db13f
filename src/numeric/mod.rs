//! Linear algebra; the only module that uses faer, rayon, rustfft and statrs.

use crate::base::code::Code;
use crate::base::error::Error;

/// Dense real matrix, column-major.
pub type Matrix = faer::Mat<f64>;

/// Dense complex matrix, column-major.
pub type ComplexMatrix = faer::Mat<Complex>;

/// A complex number.
pub type Complex = faer::c64;

pub mod parallel;

pub mod fft;

pub mod band_limited;

pub mod sorting;

pub mod statistics;

pub mod fraction;

pub mod lattice;

pub mod exact_constraints;

pub mod vector_ops;

pub mod integer_least_squares;

mod pivoted_qr;

mod rank_revealing;

mod jacobi;

pub mod graded;

pub mod assignment;

pub mod mac;

pub mod parabola;

pub mod hermite_cubic;

pub mod registers;

pub mod products;

pub mod symmetric;

pub mod mass_factor;

pub mod lu;

pub mod lstsq;

mod balance;

pub mod eigen;

pub mod expm;

pub mod small_dense;

pub mod quadrature;

pub mod quintic_spline;

pub mod discretisation;

pub mod least_squares;

pub mod profile_matrix;

pub mod complementarity;

pub mod quadratic;

pub mod thin_qr;

pub mod factorisations;

pub mod sparse;

pub mod sparse_lu;

pub mod forest;

pub mod forest_factor;

pub mod shift_invert;

pub mod lanczos;

mod forest_lanes;

pub mod forest_modes;

pub mod energy_modes;

/// The entries of a matrix, row by row.
pub fn to_rows(a: &Matrix) -> Vec<Vec<f64>> {
    let row = |i| (0..a.ncols()).map(|j| a[(i, j)]).collect();
    (0..a.nrows()).map(row).collect()
}

/// Refuses a matrix with an entry that is not a number or not finite; `what` names it.
fn check_finite(a: &Matrix, what: &str) -> Result<(), Error> {
    for j in 0..a.ncols() {
        if let Some(i) = a.col_as_slice(j).iter().position(|x| !x.is_finite()) {
            return Err(Error::new(
                Code::Overflow,
                format!("entry ({i}, {j}) of {what} is {}", a[(i, j)]),
            ));
        }
    }
    Ok(())
}
