//! A machine against its free turning: `q = T x` with `rᵀ M T = 0` for every motion r that strains nothing, so that the mean
//! torques that accelerate it drop out; coordinates whose motion is prescribed stand still.

use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::motion::floquet::free_turning;
use crate::motion::train::{Branch, Drive, Law, Mass, Train};
use crate::numeric::{Matrix, definite};

/// A machine without its free turning.
pub struct Relative {
    /// Over x.
    pub train: Train,
    /// T, coordinates by x.
    pub transform: Matrix,
    /// Free motions over x that remain, since a damper, a brake or a motor acts on them.
    pub free: Vec<Vec<f64>>,
    /// Multipliers that are one whatever the motion does: of every free motion that is left its angle, and its speed where nothing but
    /// dry friction acts on it.
    pub neutral: usize,
}

/// Of the sum of sizes: a free motion moves a branch by no more than rounding.
const ROUNDING: f64 = 1e-9;

impl Relative {
    /// Takes the free turning out of a machine.
    ///
    /// # Errors
    /// Those of the symmetric eigenproblem, and of a mass matrix that is not positive.
    pub fn new(train: &Train) -> Result<Relative, Error> {
        let all = train.n();
        let keep: Vec<usize> = (0..all).filter(|&j| !is_prescribed(train, j)).collect();
        let n = keep.len();
        let mass = Matrix::from_fn(n, n, |i, j| train.mass.at(keep[i], keep[j]));
        let units: Vec<f64> = (0..n).map(|j| mass[(j, j)].sqrt().recip()).collect();
        let over = |d: &Direction| -> Vec<f64> {
            let mut row = vec![0.0; all];
            d.scaled().for_each(|(i, a)| row[i] += a);
            keep.iter().map(|&j| row[j]).collect()
        };
        let scaled = |row: Vec<f64>| -> Vec<f64> {
            row.iter().zip(&units).map(|(x, unit)| x * unit).collect()
        };
        let holds = train.branches.iter().filter(|b| is_elastic(&b.law));
        let mut rows: Vec<Vec<f64>> = holds.map(|b| scaled(over(&b.direction))).collect();
        if let Some((stiffness, _)) = &train.general {
            rows.extend(
                keep.iter()
                    .map(|&i| scaled(keep.iter().map(|&j| stiffness[(i, j)]).collect())),
            );
        }
        let (basis, rigid) = free_turning(&rows, n)?;
        let column = |k: usize| -> Vec<f64> { (0..n).map(|i| units[i] * basis[(i, k)]).collect() };
        let free: Vec<Vec<f64>> = (0..rigid).map(column).collect();
        let touches = |row: &[f64], r: &[f64]| {
            let sum: f64 = row.iter().zip(r).map(|(w, x)| w * x).sum();
            let size: f64 = row.iter().zip(r).map(|(w, x)| (w * x).abs()).sum();
            sum.abs() > ROUNDING * size
        };
        let felt = |r: &Vec<f64>, by: &dyn Fn(&Law) -> bool| {
            let acting = train.branches.iter().filter(|b| !b.acts().terms.is_empty());
            acting
                .filter(|b| by(&b.law))
                .any(|b| touches(&over(&b.direction), r) || touches(&over(b.acts()), r))
        };
        let damped = |r: &Vec<f64>| {
            train.general.as_ref().is_some_and(|(_, c)| {
                keep.iter().any(|&i| {
                    let row: Vec<f64> = keep.iter().map(|&j| c[(i, j)]).collect();
                    touches(&row, r)
                })
            })
        };
        let coupled = free.iter().any(|r| felt(r, &|_| true) || damped(r));
        // Dry friction that slides takes the same at any speed.
        let unheld = |r: &&Vec<f64>| !felt(r, &|law| !law.is_dry()) && !damped(r);
        let neutral = free.len() + free.iter().filter(unheld).count();
        let (columns, free) = match rigid == 0 || coupled {
            true => {
                let unit = |k: usize| (0..n).map(|i| f64::from(i == k)).collect::<Vec<f64>>();
                ((0..n).map(unit).collect(), free)
            }
            false => {
                let elastic = (rigid..n).map(column).collect();
                (beside(elastic, &free, &mass)?, Vec::new())
            }
        };
        let transform = Matrix::from_fn(all, columns.len(), |i, k| {
            keep.iter()
                .position(|&j| j == i)
                .map_or(0.0, |at| columns[k][at])
        });
        Ok(Relative {
            train: over_columns(train, &transform)?,
            transform,
            neutral: if free.is_empty() { 0 } else { neutral },
            free,
        })
    }

    /// `q = T x`.
    pub fn whole(&self, x: &[f64]) -> Vec<f64> {
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
fn is_prescribed(train: &Train, j: usize) -> bool {
    let touches = |d: &Direction| d.terms.iter().any(|t| t.0 == j);
    let mut along = train
        .branches
        .iter()
        .filter(|b| touches(&b.direction))
        .peekable();
    along.peek().is_some() && along.all(|b| !touches(b.acts()))
}

fn is_elastic(law: &Law) -> bool {
    match law {
        Law::Linear { stiffness, .. } => *stiffness != 0.0,
        Law::Nonlinear { .. } => true,
        Law::Contact(contact) => contact.stiffness != 0.0,
        _ => false,
    }
}

/// Columns less their shares of the free motions, `rᵀ M t = 0`.
fn beside(
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
    let shares = definite::solve(&inertia, &shares)?;
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

fn over_columns(train: &Train, transform: &Matrix) -> Result<Train, Error> {
    let (all, n) = (transform.nrows(), transform.ncols());
    let turned = |d: &Direction| {
        let terms = (0..n).map(|k| {
            let parts = d.scaled().map(|(i, a)| a * transform[(i, k)]);
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
    let whole = Matrix::from_fn(all, all, |i, j| train.mass.at(i, j));
    let matrix = between(&whole);
    let diagonal = (0..n).all(|i| (0..n).all(|j| i == j || matrix[(i, j)] == 0.0));
    let mass = match diagonal {
        true => Mass::Diagonal((0..n).map(|i| matrix[(i, i)]).collect()),
        false => {
            let inverse = definite::solve(&matrix, &Matrix::identity(n, n))?;
            Mass::Full { matrix, inverse }
        }
    };
    let branch = |b: &Branch| Branch {
        direction: turned(&b.direction),
        force: b.force.as_ref().map(turned),
        ..b.clone()
    };
    let drive = |d: &Drive| Drive {
        direction: turned(&d.direction),
        ..d.clone()
    };
    Ok(Train {
        coordinates: (0..n).map(|k| format!("x{}", k + 1)).collect(),
        mass,
        branches: train.branches.iter().map(branch).collect(),
        drives: train.drives.iter().map(drive).collect(),
        drag: train.drag,
        general: train
            .general
            .as_ref()
            .map(|(k, c)| (between(k), between(c))),
    })
}
