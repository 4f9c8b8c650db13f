//! `M r̈ + C ṙ + K r = f` as `ẋ = A x + B u`, where some coordinates have no inertia.
//!
//! States are `x = [r_h, ṙ_h, y]`: the coordinates with inertia, their rates, and the combinations y of massless ones that a
//! damper brakes. The other massless combinations z follow the rest at once, through `0 = C_z ṙ + K_z r − f_z`.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::modes::system_matrices::SystemMatrices;
use crate::numeric::{Matrix, symmetric};

/// The dynamics, and every coordinate in states and inputs.
pub struct FirstOrder {
    /// A.
    pub a: Matrix,
    /// B.
    pub b: Matrix,
    /// Names of the states.
    pub states: Vec<String>,
    /// `r = r_from_x x + r_from_u u`.
    pub r_from_x: Matrix,
    /// Second half of r from u: zero but for massless coordinates that an input acts on.
    pub r_from_u: Matrix,
}

/// Writes the equations in first order; the columns of `forces` are `Tᵀ f` of each input.
///
/// # Errors
/// `Conflict` with loss factors; `NotPositiveDefinite` where M is, or where a massless coordinate is held by nothing.
pub fn first_order(matrices: &SystemMatrices, forces: &Matrix) -> Result<FirstOrder, Error> {
    if matrices.hysteretic.is_some() {
        let message =
            "a loss factor has no state-space form: its force would have to know the future";
        let hint = "give the branches c or damping_ratio instead; the value equivalent to a loss factor depends on the frequency";
        return Err(Error::new(Code::Conflict, message).with_hint(hint));
    }
    let split = CoordinateSplit::new(matrices);
    let (h, y, m) = (split.heavy.len(), split.braked, forces.ncols());
    let n = matrices.len();
    let (from, from_z, states) = (split.left.transpose(), h + y, 2 * h + y);
    let c = from * &matrices.damping * &split.right;
    let k = from * &matrices.stiffness * &split.right;
    let f = from * forces;
    split.check(&c)?;

    // What acts on each equation, over (r_h, ṙ_h, y | u), before z: −(C ṙ + K r) + f.
    let mut acts = Matrix::zeros(n, states + m);
    for i in 0..n {
        for j in 0..h {
            acts[(i, j)] = -k[(i, j)];
            acts[(i, h + j)] = -c[(i, j)];
        }
        (0..y).for_each(|j| acts[(i, 2 * h + j)] = -k[(i, h + j)]);
        (0..m).for_each(|j| acts[(i, states + j)] = f[(i, j)]);
    }
    let rows = |a: &Matrix, from: usize, count: usize| {
        Matrix::from_fn(count, a.ncols(), |i, j| a[(from + i, j)])
    };
    let block = |a: &Matrix, i0: usize, rows: usize, j0: usize, columns: usize| {
        Matrix::from_fn(rows, columns, |i, j| a[(i0 + i, j0 + j)])
    };
    let z = n - from_z;
    let follows = if z > 0 {
        let held = symmetric::lu_solve(&block(&k, from_z, z, from_z, z), &rows(&acts, from_z, z))
            .map_err(singular_massless_error)?;
        acts -= block(&k, 0, n, from_z, z) * &held;
        held
    } else {
        Matrix::zeros(0, states + m)
    };
    let creeps = if y > 0 {
        let rate = symmetric::lu_solve(&block(&c, h, y, h, y), &rows(&acts, h, y))?;
        acts -= block(&c, 0, n, h, y) * &rate;
        rate
    } else {
        Matrix::zeros(0, states + m)
    };
    let accelerates = divide_by_mass(matrices, &split.heavy, &rows(&acts, 0, h))?;

    let over = Matrix::from_fn(states, states + m, |i, j| match i {
        _ if i < h => f64::from(u8::from(j == h + i)),
        _ if i < 2 * h => accelerates[(i - h, j)],
        _ => creeps[(i - 2 * h, j)],
    });
    let parts = Matrix::from_fn(n, states + m, |i, j| match i {
        _ if i < h => f64::from(u8::from(j == i)),
        _ if i < from_z => f64::from(u8::from(j == h + i)),
        _ => follows[(i - from_z, j)],
    });
    let all = &split.right * parts;
    Ok(FirstOrder {
        a: block(&over, 0, states, 0, states),
        b: block(&over, 0, states, states, m),
        states: split.names(matrices),
        r_from_x: block(&all, 0, n, 0, states),
        r_from_u: block(&all, 0, n, states, m),
    })
}

fn singular_massless_error(_: Error) -> Error {
    let message = "a massless coordinate is held by neither a stiffness nor a damper";
    Error::new(Code::NotPositiveDefinite, message)
        .with_hint("give its node an inertia, or join it by a branch with k")
}

/// `M_hh⁻¹ B`, entry by entry where M is diagonal.
fn divide_by_mass(matrices: &SystemMatrices, heavy: &[usize], b: &Matrix) -> Result<Matrix, Error> {
    let m = Matrix::from_fn(heavy.len(), heavy.len(), |i, j| {
        matrices.mass[(heavy[i], heavy[j])]
    });
    let diagonal = (0..heavy.len()).all(|i| (0..heavy.len()).all(|j| i == j || m[(i, j)] == 0.0));
    if diagonal {
        return Ok(Matrix::from_fn(heavy.len(), b.ncols(), |i, j| {
            b[(i, j)] / m[(i, i)]
        }));
    }
    let l = symmetric::cholesky(&m)?;
    Ok(symmetric::solve_lower_transposed(
        &l,
        &symmetric::solve_lower(&l, b),
    ))
}

/// Coordinates as (heavy, y, z): `r = right · (r_h, y, z)`, and the equations taken as `leftᵀ (…)`.
struct CoordinateSplit {
    heavy: Vec<usize>,
    braked: usize,
    right: Matrix,
    left: Matrix,
    /// y in the massless coordinates: number and coefficient.
    combinations: Vec<Vec<(usize, f64)>>,
}

impl CoordinateSplit {
    fn new(matrices: &SystemMatrices) -> CoordinateSplit {
        let (n, light) = (matrices.len(), &matrices.massless);
        let heavy: Vec<usize> = (0..n).filter(|i| !light.contains(i)).collect();
        let c = Matrix::from_fn(light.len(), light.len(), |i, j| {
            matrices.damping[(light[i], light[j])]
        });
        let (seen, acted) = (Echelon::new(&c), Echelon::new(&c.transpose().to_owned()));
        let braked = seen.pivots.len();
        let arrange = |echelon: &Echelon| {
            let mut a = Matrix::zeros(n, n);
            heavy.iter().enumerate().for_each(|(j, &i)| a[(i, j)] = 1.0);
            for (k, &pivot) in echelon.pivots.iter().enumerate() {
                a[(light[pivot], heavy.len() + k)] = 1.0;
            }
            let others = (0..light.len()).filter(|i| !echelon.pivots.contains(i));
            for (at, other) in others.enumerate() {
                let column = heavy.len() + braked + at;
                a[(light[other], column)] = 1.0;
                for (k, &pivot) in echelon.pivots.iter().enumerate() {
                    a[(light[pivot], column)] = -echelon.rows[(k, other)];
                }
            }
            a
        };
        let (right, left) = (arrange(&seen), arrange(&acted));
        let combination = |k: usize| {
            (0..light.len())
                .map(|j| (light[j], seen.rows[(k, j)]))
                .filter(|t| t.1 != 0.0)
                .collect()
        };
        CoordinateSplit {
            braked,
            right,
            left,
            combinations: (0..braked).map(combination).collect(),
            heavy,
        }
    }

    /// The rate of z must act on nothing: dampers that are squares never let it.
    fn check(&self, c: &Matrix) -> Result<(), Error> {
        let from = self.heavy.len() + self.braked;
        let n = c.nrows();
        let largest = c.norm_max();
        let acts = (0..from)
            .flat_map(|i| (from..n).map(move |j| (i, j)))
            .any(|at| c[at].abs() > 1e-12 * largest);
        if acts {
            let message =
                "a damper's force follows the rate of a massless coordinate that it does not brake";
            return Err(Error::new(Code::NotPositiveDefinite, message)
                .with_hint("give the massless nodes at that damper an inertia"));
        }
        Ok(())
    }

    fn names(&self, matrices: &SystemMatrices) -> Vec<String> {
        let heavy = || self.heavy.iter().map(|&i| matrices.names[i].clone());
        let braked = self.combinations.iter().map(|terms| {
            let text = terms.iter().enumerate().map(|(at, &(i, a))| {
                let sign = if a < 0.0 { "-" } else { "+" };
                let lead = if at == 0 {
                    sign.trim_start_matches('+').to_string()
                } else {
                    format!(" {sign} ")
                };
                let size = if a.abs() == 1.0 {
                    String::new()
                } else {
                    format!("{} ", a.abs())
                };
                format!("{lead}{size}{}", matrices.names[i])
            });
            text.collect::<String>()
        });
        heavy()
            .chain(heavy().map(|name| format!("{name}.speed")))
            .chain(braked)
            .collect()
    }
}

/// The row space of a matrix in reduced echelon form: independent combinations, each with a coordinate of its own.
struct Echelon {
    pivots: Vec<usize>,
    rows: Matrix,
}

impl Echelon {
    fn new(c: &Matrix) -> Echelon {
        let n = c.nrows();
        // Unit size first, so that rotations and displacements count alike.
        let size = |j: usize| {
            (0..n)
                .map(|i| c[(i, j)].abs().max(c[(j, i)].abs()))
                .fold(0.0, f64::max)
        };
        let unit: Vec<f64> = (0..n)
            .map(|j| {
                if size(j) > 0.0 {
                    size(j).sqrt().recip()
                } else {
                    1.0
                }
            })
            .collect();
        let mut a = Matrix::from_fn(n, n, |i, j| c[(i, j)] * unit[i] * unit[j]);
        let (mut pivots, mut taken): (Vec<usize>, Vec<usize>) = (Vec::new(), Vec::new());
        loop {
            let rows = (0..n).filter(|i| !taken.contains(i));
            let free = rows
                .flat_map(|i| (0..n).map(move |j| (i, j)))
                .filter(|at| !pivots.contains(&at.1));
            let better = |best: (usize, usize), at: (usize, usize)| {
                let (x, y) = (a[best].abs(), a[at].abs());
                if y > x || (y == x && at.0 == at.1 && best.0 != best.1) {
                    at
                } else {
                    best
                }
            };
            let Some((row, column)) = free.reduce(better) else {
                break;
            };
            if a[(row, column)].abs() <= 1e-13 {
                break; // rounding of the rank-one sums a damper matrix is made of
            }
            let pivot = a[(row, column)];
            (0..n).for_each(|j| a[(row, j)] /= pivot);
            for i in (0..n).filter(|&i| i != row) {
                let factor = a[(i, column)];
                (0..n).for_each(|j| a[(i, j)] -= factor * a[(row, j)]);
                a[(i, column)] = 0.0;
            }
            pivots.push(column);
            taken.push(row);
        }
        let coefficient = |k: usize, j: usize| {
            let value: f64 = a[(taken[k], j)];
            if value.abs() > 1e-13 {
                value * unit[pivots[k]] / unit[j]
            } else {
                0.0
            }
        };
        let rows = Matrix::from_fn(pivots.len(), n, coefficient);
        Echelon { rows, pivots }
    }
}
