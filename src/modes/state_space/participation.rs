//! Modal controllability `|yᴴB|` and observability `|Cx|`, in energy units.
//!
//! In energy coordinates `(ω η, η̇)` with mass-normalised η every state is √J. Controllability by input j is
//! `|yᴴ b_j| / (‖y‖ ‖b_j‖)`, √2 of it for a conjugate pair: the square is the share of the energy of a blow at that input
//! which the mode receives, and without damping the squares sum to one over all modes. Observability is the same of `C x`,
//! an output being referred to its speed: displacements times λ, accelerations by λ, forces (N) as they are.

use super::signals::{self, OutputSignal};
use super::system::StateSpace;
use crate::base::error::Error;
use crate::modes::system_matrices::AnalysisContext;
use crate::numeric::{Complex, Matrix, eigen};

/// Controllability of one mode from each input and its observability at each output.
#[derive(Debug, Clone)]
pub struct ModalParticipation {
    /// λ, rad/s; exactly zero for a rigid motion, with imaginary part where it oscillates (its conjugate is not listed).
    pub eigenvalue: Complex,
    /// By input, 0 to 1.
    pub controllability: Vec<f64>,
    /// By output, 0 to 1.
    pub observability: Vec<f64>,
    /// Multiplicity of λ to working precision; the figures of each such mode are then those of one choice of shapes among many.
    pub multiplicity: usize,
    /// Every motion at λ can be excited by these inputs together. Never by one input, where several modes share λ.
    pub reachable: bool,
    /// Every motion at λ shows in these outputs together.
    pub visible: bool,
}

/// Below this, a figure is rounding: of the eigenvectors, a few hundred ε on the machines of tests/machine/state_space.rs.
const NEGLIGIBLE: f64 = 1e-10;

/// Modes closer than this, relatively, are taken as one λ.
const REPEATED_TOLERANCE: f64 = 1e-8;

/// Participation of every mode in the inputs and outputs, sorted by |λ|; the rigid motions first.
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
    let free = |j: usize| basis.omega[j] == 0.0 && (0..n).all(|i| space.a[(i, j)] == 0.0);
    let unbraked = |j: usize| {
        (0..n).all(|i| i == j || (space.a[(i, m + j)] == 0.0 && space.a[(m + j, i)] == 0.0))
    };
    let alone = |j: usize| free(j) && unbraked(j);
    let kept: Vec<usize> = (0..n)
        .filter(|&s| {
            if s < m {
                !free(s)
            } else {
                s >= 2 * m || !alone(s - m)
            }
        })
        .collect();
    let units = energy_units(&space.a, &basis.omega);
    let unit = |s: usize| units[s];
    let a = Matrix::from_fn(kept.len(), kept.len(), |i, j| {
        space.a[(kept[i], kept[j])] * unit(kept[i]) / unit(kept[j])
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
    for j in (0..m).filter(|&j| free(j)) {
        let by = |x: f64, size: f64| Complex::new(share(x, size), 0.0);
        rows.push(ModeProducts {
            eigenvalue: Complex::ZERO,
            inputs: (0..b.ncols())
                .map(|k| by(b[(m + j, k)], b_size[k]))
                .collect(),
            outputs: (0..c.nrows())
                .map(|k| by(c[(k, m + j)], c_size[k]))
                .collect(),
        });
    }
    let rigid = rows.len();
    if !kept.is_empty() {
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
            let left = norm((0..kept.len()).map(|i| eigen.left_vectors[(i, k)].norm()));
            let right = norm((0..kept.len()).map(|i| eigen.right[(i, k)].norm()));
            let reach = |j: usize| -> Complex {
                (0..kept.len())
                    .map(|i| eigen.left_vectors[(i, k)].conj() * b[(kept[i], j)])
                    .sum()
            };
            let show = |i: usize| -> Complex {
                (0..kept.len())
                    .map(|j| eigen.right[(j, k)] * c[(i, kept[j])])
                    .sum()
            };
            rows.push(ModeProducts {
                eigenvalue: lambda,
                inputs: (0..b.ncols())
                    .map(|j| reach(j) * share(pair, left * b_size[j]))
                    .collect(),
                outputs: (0..c.nrows())
                    .map(|i| show(i) * share(pair, right * c_size[i]))
                    .collect(),
            });
        }
    }
    Ok(classify(rows, rigid))
}

/// √J of a unit of each state: ω for positions, 1 for rates; for what creeps, the unit that makes it act on the others as
/// they act on it, as energy coordinates of a reciprocal machine do.
fn energy_units(a: &Matrix, omega: &[f64]) -> Vec<f64> {
    let m = omega.len();
    let mut units: Vec<f64> = omega
        .iter()
        .map(|&w| if w > 0.0 { w } else { 1.0 })
        .collect();
    units.resize(2 * m, 1.0);
    for y in 2 * m..a.nrows() {
        let acted = norm((0..2 * m).map(|j| a[(j, y)] * units[j]));
        let acts = norm((0..2 * m).map(|j| a[(y, j)] / units[j]));
        units.push(if acted > 0.0 && acts > 0.0 {
            (acted / acts).sqrt()
        } else {
            1.0
        });
    }
    units
}

/// One mode's products before their phase is dropped.
struct ModeProducts {
    eigenvalue: Complex,
    inputs: Vec<Complex>,
    outputs: Vec<Complex>,
}

fn classify(rows: Vec<ModeProducts>, rigid: usize) -> Vec<ModalParticipation> {
    let largest = rows.iter().map(|s| s.eigenvalue.norm()).fold(0.0, f64::max);
    let together = |a: usize, b: usize| {
        let (x, y) = (rows[a].eigenvalue, rows[b].eigenvalue);
        (a < rigid) == (b < rigid)
            && (x - y).norm() <= REPEATED_TOLERANCE * x.norm().max(f64::EPSILON * largest)
    };
    let judge = |k: usize| {
        let group: Vec<usize> = (0..rows.len())
            .filter(|&other| together(k, other))
            .collect();
        let all = |of: fn(&ModeProducts) -> &Vec<Complex>| {
            rank(group.iter().map(|&g| of(&rows[g]).clone()).collect()) == group.len()
        };
        ModalParticipation {
            eigenvalue: rows[k].eigenvalue,
            controllability: rows[k].inputs.iter().map(|z| z.norm().min(1.0)).collect(),
            observability: rows[k].outputs.iter().map(|z| z.norm().min(1.0)).collect(),
            multiplicity: group.len(),
            reachable: all(|s| &s.inputs),
            visible: all(|s| &s.outputs),
        }
    };
    (0..rows.len()).map(judge).collect()
}

/// Rank of rows of figures, the largest rest first.
fn rank(mut rows: Vec<Vec<Complex>>) -> usize {
    let size = |row: &Vec<Complex>| norm(row.iter().map(|z| z.norm()));
    let mut rank = 0;
    while let Some(at) = (0..rows.len()).max_by(|&i, &j| size(&rows[i]).total_cmp(&size(&rows[j])))
    {
        let lead = rows.swap_remove(at);
        let length = size(&lead);
        if length <= NEGLIGIBLE {
            break;
        }
        rank += 1;
        for row in &mut rows {
            let along = lead
                .iter()
                .zip(row.iter())
                .map(|(l, r)| l.conj() * r)
                .fold(Complex::ZERO, |s, t| s + t);
            row.iter_mut()
                .zip(&lead)
                .for_each(|(r, l)| *r -= l * along / (length * length));
        }
    }
    rank
}

/// The speed of the degree of freedom an output measures; forces as they are.
fn as_velocity_output(context: &AnalysisContext, name: &str) -> Result<String, Error> {
    Ok(match signals::parse_output(context.machine, name)? {
        OutputSignal::Dof(dof, _) => format!("{}.speed", context.machine.dof_name(dof)),
        OutputSignal::Force(_) | OutputSignal::Support(_) => name.to_string(),
    })
}

fn norm(of: impl Iterator<Item = f64>) -> f64 {
    of.fold(0.0, f64::hypot)
}
