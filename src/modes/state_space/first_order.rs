//! First-order form `ẋ = A x + B u` of `M r̈ + C ṙ + K r = f` with massless coordinates.
//!
//! The states are `x = [r_h, ṙ_h, y]`: the coordinates with inertia, their rates, and the damped combinations y of massless coordinates.
//! The other massless combinations z follow algebraically from `0 = C_z ṙ + K_z r − f_z`.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::modes::system_matrices::SystemMatrices;
use crate::numeric::{Matrix, symmetric};

/// First-order system with the coordinates r in terms of states and inputs.
pub struct FirstOrder {
    /// System matrix A.
    pub a: Matrix,
    /// Input matrix B.
    pub b: Matrix,
    /// Names of the states.
    pub states: Vec<String>,
    /// Coordinates from states: `r = r_from_x x + r_from_u u`.
    pub r_from_x: Matrix,
    /// Coordinates from inputs; nonzero only for massless coordinates with an input.
    pub r_from_u: Matrix,
}

/// Writes the equations in first order; the columns of `forces` are `Tᵀ f` of each input.
///
/// # Errors
/// `Conflict` with loss factors; `NotPositiveDefinite` if M is not, or if a massless coordinate has neither stiffness nor damper.
pub fn first_order(matrices: &SystemMatrices, forces: &Matrix) -> Result<FirstOrder, Error> {
    if matrices.hysteretic.is_some() {
        let message = "a loss factor is not causal and has no state-space form";
        let hint = "give the branches c or damping_ratio instead; the value equivalent to a loss factor depends on the frequency";
        return Err(Error::new(Code::Conflict, message).with_hint(hint));
    }
    let split = CoordinateSplit::new(matrices);
    let (h, y, m) = (split.inertial.len(), split.n_damped, forces.ncols());
    let n = matrices.len();
    let (left, from_z, states) = (split.left.transpose(), h + y, 2 * h + y);
    let c = left * &matrices.damping * &split.right;
    let k = left * &matrices.stiffness * &split.right;
    let f = left * forces;
    split.check(&c)?;

    // Right-hand side −(C ṙ + K r) + f of each equation over (r_h, ṙ_h, y | u), without z.
    let mut rhs = Matrix::zeros(n, states + m);
    for i in 0..n {
        for j in 0..h {
            rhs[(i, j)] = -k[(i, j)];
            rhs[(i, h + j)] = -c[(i, j)];
        }
        (0..y).for_each(|j| rhs[(i, 2 * h + j)] = -k[(i, h + j)]);
        (0..m).for_each(|j| rhs[(i, states + j)] = f[(i, j)]);
    }
    let rows = |a: &Matrix, from: usize, count: usize| {
        Matrix::from_fn(count, a.ncols(), |i, j| a[(from + i, j)])
    };
    let block = |a: &Matrix, i0: usize, rows: usize, j0: usize, columns: usize| {
        Matrix::from_fn(rows, columns, |i, j| a[(i0 + i, j0 + j)])
    };
    let z = n - from_z;
    let z_rows = if z > 0 {
        let z_rows = symmetric::lu_solve(&block(&k, from_z, z, from_z, z), &rows(&rhs, from_z, z))
            .map_err(singular_massless_error)?;
        rhs -= block(&k, 0, n, from_z, z) * &z_rows;
        z_rows
    } else {
        Matrix::zeros(0, states + m)
    };
    let y_rates = if y > 0 {
        let rate = symmetric::lu_solve(&block(&c, h, y, h, y), &rows(&rhs, h, y))?;
        rhs -= block(&c, 0, n, h, y) * &rate;
        rate
    } else {
        Matrix::zeros(0, states + m)
    };
    let accelerations = divide_by_mass(matrices, &split.inertial, &rows(&rhs, 0, h))?;

    let rates = Matrix::from_fn(states, states + m, |i, j| match i {
        _ if i < h => f64::from(u8::from(j == h + i)),
        _ if i < 2 * h => accelerations[(i - h, j)],
        _ => y_rates[(i - 2 * h, j)],
    });
    let split_rows = Matrix::from_fn(n, states + m, |i, j| match i {
        _ if i < h => f64::from(u8::from(j == i)),
        _ if i < from_z => f64::from(u8::from(j == h + i)),
        _ => z_rows[(i - from_z, j)],
    });
    let coordinates = &split.right * split_rows;
    Ok(FirstOrder {
        a: block(&rates, 0, states, 0, states),
        b: block(&rates, 0, states, states, m),
        states: split.names(matrices),
        r_from_x: block(&coordinates, 0, n, 0, states),
        r_from_u: block(&coordinates, 0, n, states, m),
    })
}

fn singular_massless_error(_: Error) -> Error {
    let message = "a massless coordinate has neither stiffness nor damper";
    Error::new(Code::NotPositiveDefinite, message)
        .with_hint("give its node an inertia, or join it by a branch with k")
}

/// Solution `M_hh⁻¹ B`, by division if M is diagonal.
fn divide_by_mass(matrices: &SystemMatrices, h: &[usize], b: &Matrix) -> Result<Matrix, Error> {
    let m = Matrix::from_fn(h.len(), h.len(), |i, j| matrices.mass[(h[i], h[j])]);
    let is_diagonal = (0..h.len()).all(|i| (0..h.len()).all(|j| i == j || m[(i, j)] == 0.0));
    if is_diagonal {
        return Ok(Matrix::from_fn(h.len(), b.ncols(), |i, j| {
            b[(i, j)] / m[(i, i)]
        }));
    }
    let l = symmetric::cholesky(&m)?;
    Ok(symmetric::solve_lower_transposed(
        &l,
        &symmetric::solve_lower(&l, b),
    ))
}

/// Split of the coordinates into (inertial, y, z): `r = right · (r_h, y, z)`; the equations are multiplied by `leftᵀ`.
struct CoordinateSplit {
    inertial: Vec<usize>,
    n_damped: usize,
    right: Matrix,
    left: Matrix,
    /// Combinations y as index and coefficient of the massless coordinates.
    combinations: Vec<Vec<(usize, f64)>>,
}

impl CoordinateSplit {
    fn new(matrices: &SystemMatrices) -> CoordinateSplit {
        let (n, massless) = (matrices.len(), &matrices.massless);
        let h: Vec<usize> = (0..n).filter(|i| !massless.contains(i)).collect();
        let c = Matrix::from_fn(massless.len(), massless.len(), |i, j| {
            matrices.damping[(massless[i], massless[j])]
        });
        let (row_space, column_space) = (Echelon::new(&c), Echelon::new(&c.transpose().to_owned()));
        let n_damped = row_space.pivots.len();
        let arrange = |echelon: &Echelon| {
            let mut a = Matrix::zeros(n, n);
            h.iter().enumerate().for_each(|(j, &i)| a[(i, j)] = 1.0);
            for (k, &pivot) in echelon.pivots.iter().enumerate() {
                a[(massless[pivot], h.len() + k)] = 1.0;
            }
            let others = (0..massless.len()).filter(|i| !echelon.pivots.contains(i));
            for (at, other) in others.enumerate() {
                let column = h.len() + n_damped + at;
                a[(massless[other], column)] = 1.0;
                for (k, &pivot) in echelon.pivots.iter().enumerate() {
                    a[(massless[pivot], column)] = -echelon.rows[(k, other)];
                }
            }
            a
        };
        let (right, left) = (arrange(&row_space), arrange(&column_space));
        let combination = |k: usize| {
            (0..massless.len())
                .map(|j| (massless[j], row_space.rows[(k, j)]))
                .filter(|t| t.1 != 0.0)
                .collect()
        };
        CoordinateSplit {
            n_damped,
            right,
            left,
            combinations: (0..n_damped).map(combination).collect(),
            inertial: h,
        }
    }

    /// Returns an error if the rate of z enters an equation, which a symmetric damper matrix excludes.
    fn check(&self, c: &Matrix) -> Result<(), Error> {
        let from = self.inertial.len() + self.n_damped;
        let n = c.nrows();
        let largest = c.norm_max();
        let has_rate_of_z = (0..from)
            .flat_map(|i| (from..n).map(move |j| (i, j)))
            .any(|at| c[at].abs() > 1e-12 * largest);
        if has_rate_of_z {
            let message = "a damper's force depends on the rate of a massless coordinate that it does not act on";
            return Err(Error::new(Code::NotPositiveDefinite, message)
                .with_hint("give the massless nodes at that damper an inertia"));
        }
        Ok(())
    }

    fn names(&self, matrices: &SystemMatrices) -> Vec<String> {
        let inertial = || self.inertial.iter().map(|&i| matrices.names[i].clone());
        let damped = self.combinations.iter().map(|terms| {
            let text = terms.iter().enumerate().map(|(at, &(i, a))| {
                let sign = if a < 0.0 { "-" } else { "+" };
                let prefix = if at == 0 {
                    sign.trim_start_matches('+').to_string()
                } else {
                    format!(" {sign} ")
                };
                let size = if a.abs() == 1.0 {
                    String::new()
                } else {
                    format!("{} ", a.abs())
                };
                format!("{prefix}{size}{}", matrices.names[i])
            });
            text.collect::<String>()
        });
        inertial()
            .chain(inertial().map(|name| format!("{name}.speed")))
            .chain(damped)
            .collect()
    }
}

/// Row space of a matrix in reduced echelon form: independent rows, each with its own pivot column.
struct Echelon {
    pivots: Vec<usize>,
    rows: Matrix,
}

impl Echelon {
    fn new(c: &Matrix) -> Echelon {
        let n = c.nrows();
        // The matrix is scaled first so that rotations and displacements are comparable.
        let size = |j: usize| {
            (0..n)
                .map(|i| c[(i, j)].abs().max(c[(j, i)].abs()))
                .fold(0.0, f64::max)
        };
        let scales: Vec<f64> = (0..n)
            .map(|j| {
                if size(j) > 0.0 {
                    size(j).sqrt().recip()
                } else {
                    1.0
                }
            })
            .collect();
        let mut a = Matrix::from_fn(n, n, |i, j| c[(i, j)] * scales[i] * scales[j]);
        let (mut pivots, mut pivot_rows): (Vec<usize>, Vec<usize>) = (Vec::new(), Vec::new());
        loop {
            let rows = (0..n).filter(|i| !pivot_rows.contains(i));
            let entries = rows
                .flat_map(|i| (0..n).map(move |j| (i, j)))
                .filter(|at| !pivots.contains(&at.1));
            let larger = |best: (usize, usize), at: (usize, usize)| {
                let (x, y) = (a[best].abs(), a[at].abs());
                if y > x || (y == x && at.0 == at.1 && best.0 != best.1) {
                    at
                } else {
                    best
                }
            };
            let Some((row, column)) = entries.reduce(larger) else {
                break;
            };
            if a[(row, column)].abs() <= 1e-13 {
                break; // rounding of the rank-one sum of the damper matrix
            }
            let pivot = a[(row, column)];
            (0..n).for_each(|j| a[(row, j)] /= pivot);
            for i in (0..n).filter(|&i| i != row) {
                let factor = a[(i, column)];
                (0..n).for_each(|j| a[(i, j)] -= factor * a[(row, j)]);
                a[(i, column)] = 0.0;
            }
            pivots.push(column);
            pivot_rows.push(row);
        }
        let coefficient = |k: usize, j: usize| {
            let value: f64 = a[(pivot_rows[k], j)];
            if value.abs() > 1e-13 {
                value * scales[pivots[k]] / scales[j]
            } else {
                0.0
            }
        };
        let rows = Matrix::from_fn(pivots.len(), n, coefficient);
        Echelon { rows, pivots }
    }
}
