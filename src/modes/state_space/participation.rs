//! Modal controllability `|yᴴB|` and observability `|Cx|`, in energy units.
//!
//! In energy coordinates `(ω η, η̇)` with mass-normalised η every state has the unit √J. Controllability by input j is
//! `|yᴴ b_j| / (‖y‖ ‖b_j‖)`, times √2 for a conjugate pair: its square is the share of the energy of an impulse at that input which the
//! mode receives; without damping the squares sum to one over all modes. Observability is the same for `C x`, with displacements and
//! accelerations replaced by the velocity; forces (N) are used unchanged.

use super::signals::{self, OutputSignal};
use super::system::StateSpace;
use crate::base::error::Error;
use crate::modes::system_matrices::AnalysisContext;
use crate::numeric::{Complex, Matrix, eigen};

/// Controllability of one mode from each input and its observability at each output.
#[derive(Debug, Clone)]
pub struct ModalParticipation {
    /// Eigenvalue λ, rad/s; exactly zero for a rigid-body mode. Of a conjugate pair the one with positive imaginary part is listed.
    pub eigenvalue: Complex,
    /// Controllability by input, 0 to 1.
    pub controllability: Vec<f64>,
    /// Observability by output, 0 to 1.
    pub observability: Vec<f64>,
    /// Multiplicity of λ to working precision; for a repeated λ the values depend on the choice of the mode shapes.
    pub multiplicity: usize,
    /// `true` if the inputs together can excite every mode at λ; one input cannot if λ is repeated.
    pub controllable: bool,
    /// `true` if the outputs together distinguish every mode at λ.
    pub observable: bool,
}

/// Values below this are rounding of the eigenvectors: a few hundred ε on the machines of tests/machine/state_space.rs.
const NEGLIGIBLE: f64 = 1e-10;

/// Largest relative distance of eigenvalues that count as repeated.
const REPEATED_TOLERANCE: f64 = 1e-8;

/// Participation of every mode in the inputs and outputs, sorted by |λ|; the rigid-body modes first.
///
/// # Errors
/// Those of [`StateSpace::modal`] and of the eigenvalue iteration.
pub fn participation(
    context: &AnalysisContext,
    inputs: &[String],
    outputs: &[String],
) -> Result<Vec<ModalParticipation>, Error> {
    let speeds = outputs
        .iter()
        .map(|name| as_velocity_output(context, name))
        .collect::<Result<Vec<String>, Error>>()?;
    let space = StateSpace::modal(context, inputs, &speeds)?;
    let basis = context.basis;
    let (m, n) = (basis.omega.len(), space.a.nrows());
    let is_free = |j: usize| basis.omega[j] == 0.0 && (0..n).all(|i| space.a[(i, j)] == 0.0);
    let is_undamped = |j: usize| {
        (0..n).all(|i| i == j || (space.a[(i, m + j)] == 0.0 && space.a[(m + j, i)] == 0.0))
    };
    let is_uncoupled = |j: usize| is_free(j) && is_undamped(j);
    let retained: Vec<usize> = (0..n)
        .filter(|&s| {
            if s < m {
                !is_free(s)
            } else {
                s >= 2 * m || !is_uncoupled(s - m)
            }
        })
        .collect();
    let units = energy_units(&space.a, &basis.omega);
    let unit = |s: usize| units[s];
    let a = Matrix::from_fn(retained.len(), retained.len(), |i, j| {
        space.a[(retained[i], retained[j])] * unit(retained[i]) / unit(retained[j])
    });
    let b = Matrix::from_fn(n, space.b.ncols(), |i, j| unit(i) * space.b[(i, j)]);
    let c = Matrix::from_fn(space.c.nrows(), n, |i, j| space.c[(i, j)] / unit(j));
    let b_size: Vec<f64> = (0..b.ncols())
        .map(|j| norm((0..n).map(|i| b[(i, j)])))
        .collect();
    let c_size: Vec<f64> = (0..c.nrows())
        .map(|i| norm((0..n).map(|j| c[(i, j)])))
        .collect();
    let share = |value: f64, size: f64| if size > 0.0 { value / size } else { 0.0 };

    let mut rows: Vec<ModeProducts> = Vec::new();
    for j in (0..m).filter(|&j| is_free(j)) {
        let real_share = |x: f64, size: f64| Complex::new(share(x, size), 0.0);
        rows.push(ModeProducts {
            eigenvalue: Complex::ZERO,
            inputs: (0..b.ncols())
                .map(|k| real_share(b[(m + j, k)], b_size[k]))
                .collect(),
            outputs: (0..c.nrows())
                .map(|k| real_share(c[(k, m + j)], c_size[k]))
                .collect(),
        });
    }
    let rigid = rows.len();
    if !retained.is_empty() {
        let eigen = eigen::eigen(&a)?;
        for (k, &lambda) in eigen
            .values
            .iter()
            .enumerate()
            .filter(|(_, value)| value.im >= 0.0)
        {
            let pair = if lambda.im > 0.0 {
                std::f64::consts::SQRT_2
            } else {
                1.0
            };
            let left_norm = norm((0..retained.len()).map(|i| eigen.left_vectors[(i, k)].norm()));
            let right_norm = norm((0..retained.len()).map(|i| eigen.right[(i, k)].norm()));
            let input_product = |j: usize| -> Complex {
                (0..retained.len())
                    .map(|i| eigen.left_vectors[(i, k)].conj() * b[(retained[i], j)])
                    .sum()
            };
            let output_product = |i: usize| -> Complex {
                (0..retained.len())
                    .map(|j| eigen.right[(j, k)] * c[(i, retained[j])])
                    .sum()
            };
            rows.push(ModeProducts {
                eigenvalue: lambda,
                inputs: (0..b.ncols())
                    .map(|j| input_product(j) * share(pair, left_norm * b_size[j]))
                    .collect(),
                outputs: (0..c.nrows())
                    .map(|i| output_product(i) * share(pair, right_norm * c_size[i]))
                    .collect(),
            });
        }
    }
    Ok(classify(rows, rigid))
}

/// Energy unit (√J) of each state: ω for positions, 1 for rates; for states of massless coordinates the unit that balances the coupling
/// in both directions, as in energy coordinates of a reciprocal machine.
fn energy_units(a: &Matrix, omega: &[f64]) -> Vec<f64> {
    let m = omega.len();
    let mut units: Vec<f64> = omega
        .iter()
        .map(|&w| if w > 0.0 { w } else { 1.0 })
        .collect();
    units.resize(2 * m, 1.0);
    for y in 2 * m..a.nrows() {
        let column_norm = norm((0..2 * m).map(|j| a[(j, y)] * units[j]));
        let row_norm = norm((0..2 * m).map(|j| a[(y, j)] / units[j]));
        units.push(if column_norm > 0.0 && row_norm > 0.0 {
            (column_norm / row_norm).sqrt()
        } else {
            1.0
        });
    }
    units
}

/// Complex products of one mode with all inputs and outputs.
struct ModeProducts {
    eigenvalue: Complex,
    inputs: Vec<Complex>,
    outputs: Vec<Complex>,
}

fn classify(rows: Vec<ModeProducts>, rigid: usize) -> Vec<ModalParticipation> {
    let largest = rows.iter().map(|s| s.eigenvalue.norm()).fold(0.0, f64::max);
    let is_repeated = |a: usize, b: usize| {
        let (x, y) = (rows[a].eigenvalue, rows[b].eigenvalue);
        (a < rigid) == (b < rigid)
            && (x - y).norm() <= REPEATED_TOLERANCE * x.norm().max(f64::EPSILON * largest)
    };
    let mode_participation = |k: usize| {
        let group: Vec<usize> = (0..rows.len())
            .filter(|&other| is_repeated(k, other))
            .collect();
        let has_full_rank = |products: fn(&ModeProducts) -> &Vec<Complex>| {
            rank(group.iter().map(|&g| products(&rows[g]).clone()).collect()) == group.len()
        };
        ModalParticipation {
            eigenvalue: rows[k].eigenvalue,
            controllability: rows[k].inputs.iter().map(|z| z.norm().min(1.0)).collect(),
            observability: rows[k].outputs.iter().map(|z| z.norm().min(1.0)).collect(),
            multiplicity: group.len(),
            controllable: has_full_rank(|s| &s.inputs),
            observable: has_full_rank(|s| &s.outputs),
        }
    };
    (0..rows.len()).map(mode_participation).collect()
}

/// Numerical rank of complex rows by Gram–Schmidt with pivoting.
fn rank(mut rows: Vec<Vec<Complex>>) -> usize {
    let size = |row: &Vec<Complex>| norm(row.iter().map(|z| z.norm()));
    let mut rank = 0;
    while let Some(at) = (0..rows.len()).max_by(|&i, &j| size(&rows[i]).total_cmp(&size(&rows[j])))
    {
        let pivot = rows.swap_remove(at);
        let length = size(&pivot);
        if length <= NEGLIGIBLE {
            break;
        }
        rank += 1;
        for row in &mut rows {
            let product = pivot
                .iter()
                .zip(row.iter())
                .map(|(l, r)| l.conj() * r)
                .fold(Complex::ZERO, |s, t| s + t);
            row.iter_mut()
                .zip(&pivot)
                .for_each(|(r, l)| *r -= l * product / (length * length));
        }
    }
    rank
}

/// Name of the velocity output for the degree of freedom of an output; force outputs are unchanged.
fn as_velocity_output(context: &AnalysisContext, name: &str) -> Result<String, Error> {
    Ok(match signals::parse_output(context.machine, name)? {
        OutputSignal::Dof(dof, _) => format!("{}.speed", context.machine.dof_name(dof)),
        OutputSignal::Force(_) | OutputSignal::Support(_) => name.to_string(),
    })
}

fn norm(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::hypot)
}
