//! Relative coordinates `q = T x`, `rᵀ M T = 0`: rigid-body motion eliminated.

use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::motion::dynamic_model::{
    AppliedForce, DynamicModel, ForceElement, ForceLaw, MassMatrix,
};
use crate::motion::floquet::rigid_body_basis;
use crate::numeric::{Matrix, symmetric};

/// A machine without its free turning.
pub struct RelativeModel {
    /// Over x.
    pub model: DynamicModel,
    /// T, coordinates by x.
    pub transform: Matrix,
    /// Free motions over x that remain, since a damper, a brake or a motor acts on them.
    pub free: Vec<Vec<f64>>,
    /// Multipliers that are one whatever the motion does: of every free motion that is left its angle, and its speed where nothing but
    /// dry friction acts on it.
    pub neutral: usize,
}

/// Rounding tolerance relative to the sum of sizes: a free motion moves a branch by no more than this.
const ROUNDING: f64 = 1e-9;

impl RelativeModel {
    /// Takes the free turning out of a machine.
    ///
    /// # Errors
    /// Those of the symmetric eigenproblem, and of a mass matrix that is not positive.
    pub fn new(model: &DynamicModel) -> Result<RelativeModel, Error> {
        let all = model.coordinate_count();
        let keep: Vec<usize> = (0..all).filter(|&j| !is_prescribed(model, j)).collect();
        let n = keep.len();
        let mass = Matrix::from_fn(n, n, |i, j| model.mass.entry(keep[i], keep[j]));
        let units: Vec<f64> = (0..n).map(|j| mass[(j, j)].sqrt().recip()).collect();
        let over = |d: &Direction| -> Vec<f64> {
            let mut row = vec![0.0; all];
            d.entries().for_each(|(i, a)| row[i] += a);
            keep.iter().map(|&j| row[j]).collect()
        };
        let scaled = |row: Vec<f64>| -> Vec<f64> {
            row.iter().zip(&units).map(|(x, unit)| x * unit).collect()
        };
        let holds = model.elements.iter().filter(|b| is_elastic(&b.law));
        let mut rows: Vec<Vec<f64>> = holds.map(|b| scaled(over(&b.direction))).collect();
        if let Some((stiffness, _)) = &model.global_matrices {
            rows.extend(
                keep.iter()
                    .map(|&i| scaled(keep.iter().map(|&j| stiffness[(i, j)]).collect())),
            );
        }
        let (basis, rigid) = rigid_body_basis(&rows, n)?;
        let column = |k: usize| -> Vec<f64> { (0..n).map(|i| units[i] * basis[(i, k)]).collect() };
        let free: Vec<Vec<f64>> = (0..rigid).map(column).collect();
        let touches = |row: &[f64], r: &[f64]| {
            let sum: f64 = row.iter().zip(r).map(|(w, x)| w * x).sum();
            let size: f64 = row.iter().zip(r).map(|(w, x)| (w * x).abs()).sum();
            sum.abs() > ROUNDING * size
        };
        let felt = |r: &Vec<f64>, by: &dyn Fn(&ForceLaw) -> bool| {
            let acting = model
                .elements
                .iter()
                .filter(|b| !b.force_direction().terms.is_empty());
            acting
                .filter(|b| by(&b.law))
                .any(|b| touches(&over(&b.direction), r) || touches(&over(b.force_direction()), r))
        };
        let damped = |r: &Vec<f64>| {
            model.global_matrices.as_ref().is_some_and(|(_, c)| {
                keep.iter().any(|&i| {
                    let row: Vec<f64> = keep.iter().map(|&j| c[(i, j)]).collect();
                    touches(&row, r)
                })
            })
        };
        let coupled = free.iter().any(|r| felt(r, &|_| true) || damped(r));
        // Dry friction that slides takes the same at any speed.
        let unheld = |r: &&Vec<f64>| !felt(r, &|law| !law.is_dry_friction()) && !damped(r);
        let neutral = free.len() + free.iter().filter(unheld).count();
        let (columns, free) = match rigid == 0 || coupled {
            true => {
                let unit = |k: usize| (0..n).map(|i| f64::from(i == k)).collect::<Vec<f64>>();
                ((0..n).map(unit).collect(), free)
            }
            false => {
                let elastic = (rigid..n).map(column).collect();
                (remove_rigid_motions(elastic, &free, &mass)?, Vec::new())
            }
        };
        let transform = Matrix::from_fn(all, columns.len(), |i, k| {
            keep.iter()
                .position(|&j| j == i)
                .map_or(0.0, |at| columns[k][at])
        });
        Ok(RelativeModel {
            model: transform_model(model, &transform)?,
            transform,
            neutral: if free.is_empty() { 0 } else { neutral },
            free,
        })
    }

    /// `q = T x`.
    pub fn full_coordinates(&self, x: &[f64]) -> Vec<f64> {
        (0..self.transform.nrows())
            .map(|i| {
                x.iter()
                    .enumerate()
                    .map(|(k, x)| self.transform[(i, k)] * x)
                    .sum()
            })
            .collect()
    }
}

/// Branches see the coordinate and none acts on it.
fn is_prescribed(model: &DynamicModel, j: usize) -> bool {
    let touches = |d: &Direction| d.terms.iter().any(|t| t.0 == j);
    let mut along = model
        .elements
        .iter()
        .filter(|b| touches(&b.direction))
        .peekable();
    along.peek().is_some() && along.all(|b| !touches(b.force_direction()))
}

fn is_elastic(law: &ForceLaw) -> bool {
    match law {
        ForceLaw::Linear { stiffness, .. } => *stiffness != 0.0,
        ForceLaw::Nonlinear { .. } => true,
        ForceLaw::Contact(contact) => contact.stiffness != 0.0,
        _ => false,
    }
}

/// Columns less their shares of the free motions, `rᵀ M t = 0`.
fn remove_rigid_motions(
    columns: Vec<Vec<f64>>,
    free: &[Vec<f64>],
    mass: &Matrix,
) -> Result<Vec<Vec<f64>>, Error> {
    let n = mass.nrows();
    let momenta: Vec<Vec<f64>> = free
        .iter()
        .map(|r| {
            (0..n)
                .map(|i| (0..n).map(|j| mass[(i, j)] * r[j]).sum())
                .collect()
        })
        .collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let inertia = Matrix::from_fn(free.len(), free.len(), |i, j| dot(&free[i], &momenta[j]));
    let shares = Matrix::from_fn(free.len(), columns.len(), |i, k| {
        dot(&momenta[i], &columns[k])
    });
    let shares = symmetric::lu_solve(&inertia, &shares)?;
    let less = |(k, mut column): (usize, Vec<f64>)| {
        for (i, r) in free.iter().enumerate() {
            column
                .iter_mut()
                .zip(r)
                .for_each(|(c, r)| *c -= shares[(i, k)] * r);
        }
        column
    };
    Ok(columns.into_iter().enumerate().map(less).collect())
}

fn transform_model(model: &DynamicModel, transform: &Matrix) -> Result<DynamicModel, Error> {
    let (all, n) = (transform.nrows(), transform.ncols());
    let turned = |d: &Direction| {
        let terms = (0..n).map(|k| {
            let parts = d.entries().map(|(i, a)| a * transform[(i, k)]);
            let (sum, size) = parts.fold((0.0, 0.0), |(s, z): (f64, f64), x| (s + x, z + x.abs()));
            (
                k,
                if sum.abs() > f64::EPSILON * 8.0 * size {
                    sum
                } else {
                    0.0
                },
            )
        });
        Direction::new(1.0, terms)
    };
    let between = |a: &Matrix| transform.transpose() * a * transform;
    let whole = Matrix::from_fn(all, all, |i, j| model.mass.entry(i, j));
    let matrix = between(&whole);
    let diagonal = (0..n).all(|i| (0..n).all(|j| i == j || matrix[(i, j)] == 0.0));
    let mass = match diagonal {
        true => MassMatrix::Diagonal((0..n).map(|i| matrix[(i, i)]).collect()),
        false => {
            let inverse = symmetric::lu_solve(&matrix, &Matrix::identity(n, n))?;
            MassMatrix::Full { matrix, inverse }
        }
    };
    let branch = |b: &ForceElement| ForceElement {
        direction: turned(&b.direction),
        force_direction: b.force_direction.as_ref().map(turned),
        ..b.clone()
    };
    let drive = |d: &AppliedForce| AppliedForce {
        direction: turned(&d.direction),
        ..d.clone()
    };
    Ok(DynamicModel {
        coordinates: (0..n).map(|k| format!("x{}", k + 1)).collect(),
        mass,
        elements: model.elements.iter().map(branch).collect(),
        forces: model.forces.iter().map(drive).collect(),
        mass_damping: model.mass_damping,
        global_matrices: model
            .global_matrices
            .as_ref()
            .map(|(k, c)| (between(k), between(c))),
    })
}
