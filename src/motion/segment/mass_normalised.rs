//! Mass-normalised coordinates `x = Lᵀ q`, `M = L Lᵀ`, and the modes in them.
//!
//! Frequencies are singular values of `√k W L⁻ᵀ`, or Rayleigh quotients of energies if their error bound is as small: both are relatively
//! accurate for slow and fast modes. Rigid motions come from the geometry alone and have frequency zero exactly.

use crate::base::error::Error;
use crate::machine::direction::Direction;
use crate::motion::dynamic_model::{DynamicModel, MassMatrix};
use crate::numeric::energy_modes::{Expansion, MAX_BOUND, Squares, energy_modes};
use crate::numeric::mass_factor::MassFactor;
use crate::numeric::vector_ops::axpy;
pub use crate::numeric::vector_ops::dot;
use crate::numeric::{Matrix, graded};

/// Cholesky factor `M = L Lᵀ` of the mass matrix.
///
/// # Errors
/// A mass matrix that is not positive definite.
pub fn mass_factor(model: &DynamicModel) -> Result<MassFactor, Error> {
    match &model.mass {
        MassMatrix::Diagonal(mass) => Ok(MassFactor::diagonal(mass.iter().copied())),
        MassMatrix::Full { matrix, .. } => MassFactor::full(matrix),
    }
}

/// Dense vector of a direction over all coordinates.
pub fn to_dense(direction: &Direction, n: usize) -> Vec<f64> {
    let mut w = vec![0.0; n];
    direction.entries().for_each(|(i, a)| w[i] += a);
    w
}

/// Strain rows over x; rigid motions lie in their null space.
#[derive(Debug, Default)]
pub struct StrainRows {
    /// Directions of springs with strain energy `½ k (wᵀx)²`, and √k.
    pub squares: Vec<(Vec<f64>, f64)>,
    /// Further strain and force directions of springs.
    pub springs: Vec<Vec<f64>>,
    /// Strain and force directions of dampers and all other elements.
    pub dampers: Vec<Vec<f64>>,
    /// Directions of sticking pairs, constrained to rest.
    pub stuck: Vec<Vec<f64>>,
}

/// Modes of a regime in the order: motions that strain no element, motions that strain dampers only, motions without strain
/// energy, elastic modes in ascending order of frequency.
#[derive(Debug)]
pub struct RegimeModes {
    /// Φ: mass-normalised shapes as columns over q.
    pub shapes: Matrix,
    /// Modal momenta MΦ, as columns over q.
    pub momenta: Matrix,
    /// Natural frequencies, rad/s.
    pub omega: Vec<f64>,
    /// Number of modes that strain no element.
    pub free: usize,
    /// Number of modes that strain no spring, including the free modes.
    pub rigid: usize,
}

impl RegimeModes {
    /// Modes over n coordinates from the strain rows.
    ///
    /// # Errors
    /// Numbers out of range; no convergence.
    pub fn new(factor: &MassFactor, rows: &StrainRows, n: usize) -> Result<RegimeModes, Error> {
        let allowed = constraint_null_space(&rows.stuck, n)?;
        let m = allowed.as_ref().map_or(n, Vec::len);
        let restrict = |row: &Vec<f64>| -> Vec<f64> {
            match &allowed {
                Some(allowed) => allowed.iter().map(|a| dot(a, row)).collect(),
                None => row.clone(),
            }
        };
        let restrict_all = |rows: &[Vec<f64>]| rows.iter().map(restrict).collect::<Vec<_>>();
        let squares: Vec<Vec<f64>> = rows.squares.iter().map(|(row, _)| restrict(row)).collect();
        let springs = restrict_all(&rows.springs);
        let dampers = restrict_all(&rows.dampers);

        let null = null_motions(&squares, m)?;
        let undamped = restrict_null_space(&null, &springs)?;
        let free = restrict_null_space(&undamped, &dampers)?;
        let mut zero: Vec<Vec<f64>> = Vec::new();
        extend(&mut zero, &free);
        let n_free = zero.len();
        extend(&mut zero, &undamped);
        let n_rigid = zero.len();
        extend(&mut zero, &null);

        let roots = rows.squares.iter().map(|(_, root)| *root);
        let weighted: Vec<Vec<f64>> = squares
            .iter()
            .zip(roots)
            .map(|(row, root)| row.iter().map(|a| root * a).collect())
            .collect();
        let (elastic, strained) = strained_modes(&weighted, &zero, m)?;
        let column = |j: usize, i: usize| match zero.get(j) {
            Some(rigid) => rigid[i],
            None => strained[(i, j - zero.len())],
        };
        let vectors = Matrix::from_fn(n, m, |i, j| match &allowed {
            Some(allowed) => (0..m).map(|k| allowed[k][i] * column(j, k)).sum(),
            None => column(j, i),
        });
        let omega = [vec![0.0; zero.len()], elastic].concat();
        Ok(RegimeModes {
            shapes: factor.solve_transposed(&vectors),
            momenta: factor.times(&vectors),
            omega,
            free: n_free,
            rigid: n_rigid,
        })
    }

    /// Number of modes.
    pub fn count(&self) -> usize {
        self.omega.len()
    }

    /// Modal participation `wᵀΦ` of a direction, exactly zero for the first `blind` modes.
    pub fn project(&self, w: &Direction, blind: usize) -> Vec<f64> {
        let column = |j: usize| w.dot(self.shapes.col_as_slice(j));
        (0..self.count())
            .map(|j| if j < blind { 0.0 } else { column(j) })
            .collect()
    }
}

/// Frequencies in ascending order and orthonormal shapes of the elastic modes; `zero` spans the motions without strain. Energy quotients
/// give the frequencies; the factored form replaces them if their error bound is too large.
fn strained_modes(
    rows: &[Vec<f64>],
    zero: &[Vec<f64>],
    m: usize,
) -> Result<(Vec<f64>, Matrix), Error> {
    /// Largest cosine between the strains of two modes: contamination of a shape is an error of every propagated state.
    const SHAPES: f64 = 1e-13;
    let mut springs = Squares::default();
    for row in rows {
        let terms = row.iter().copied().enumerate();
        springs.push(1.0, terms.filter(|(_, a)| *a != 0.0));
    }
    let expansion = Expansion::Diagonal(vec![1.0; m]);
    if zero.len() == m {
        return Ok((Vec::new(), Matrix::zeros(m, 0)));
    }
    // Squares may overflow if their roots do not.
    if let Ok(Some(modes)) = energy_modes(&springs, &expansion, zero, SHAPES)
        && modes.bounds.iter().all(|bound| *bound <= MAX_BOUND)
    {
        return Ok((modes.omega, modes.vectors));
    }
    let a = Matrix::from_fn(rows.len(), m, |i, j| rows[i][j]);
    let svd = graded::svd(&a, Some(m - zero.len()))?;
    let vectors = Matrix::from_fn(m, m - zero.len(), |i, j| svd.vectors[(i, zero.len() + j)]);
    Ok((svd.values[zero.len()..].to_vec(), vectors))
}

/// Orthonormal basis over x of the null space of the sticking directions; none without sticking pairs.
fn constraint_null_space(stuck: &[Vec<f64>], n: usize) -> Result<Option<Vec<Vec<f64>>>, Error> {
    if stuck.is_empty() {
        return Ok(None);
    }
    let mut basis = Vec::new();
    extend(&mut basis, &null_motions(stuck, n)?);
    Ok(Some(basis))
}

/// Extends an orthonormal basis by a list of motions (Gram–Schmidt).
fn extend(basis: &mut Vec<Vec<f64>>, motions: &[Vec<f64>]) {
    const DEPENDENT: f64 = 1e-9; // of a unit vector; a dependent one is rounding
    for motion in motions {
        let norm = dot(motion, motion).sqrt();
        let mut v: Vec<f64> = motion.iter().map(|x| x / norm).collect();
        let mut remaining = 1.0;
        // Twice is enough (Giraud, Langou & Rozložník 2005, Numer. Math. 101, 87).
        for _ in 0..2 {
            for b in basis.iter() {
                let share = dot(b, &v);
                v.iter_mut().zip(b).for_each(|(x, b)| *x -= share * b);
            }
            remaining *= dot(&v, &v).sqrt();
            let norm = dot(&v, &v).sqrt();
            v.iter_mut().for_each(|x| *x /= norm);
        }
        if remaining > DEPENDENT {
            basis.push(v);
        }
    }
}

/// Strain relative to its terms below which a motion has no strain: geometry is known to 1e-16.
const NULL_TOLERANCE: f64 = 1e-10;

/// Null space of strain rows from the geometry, independent of stiffness and inertia.
fn null_motions(rows: &[Vec<f64>], n: usize) -> Result<Vec<Vec<f64>>, Error> {
    match null_space_by_ratios(rows, n) {
        Some(motions) => Ok(motions),
        None => null_space_by_svd(rows, n),
    }
}

/// Restricts motions to the null space of further rows.
fn restrict_null_space(motions: &[Vec<f64>], rows: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, Error> {
    let strain = |row: &Vec<f64>, motion: &Vec<f64>| -> f64 {
        let terms = || row.iter().zip(motion).map(|(a, x)| a * x);
        let sum: f64 = terms().sum();
        let size: f64 = terms().map(f64::abs).sum();
        if sum.abs() <= NULL_TOLERANCE * size {
            0.0
        } else {
            sum
        }
    };
    let restrict = |row: &Vec<f64>| motions.iter().map(|x| strain(row, x)).collect::<Vec<f64>>();
    let mut restricted: Vec<Vec<f64>> = rows.iter().map(restrict).collect();
    restricted.retain(|row| row.iter().any(|x| *x != 0.0));
    if restricted.is_empty() || motions.is_empty() {
        return Ok(motions.to_vec());
    }
    let shares = null_motions(&restricted, motions.len())?;
    let sum = |share: &Vec<f64>| {
        let mut combined = vec![0.0; motions[0].len()];
        let pairs = share.iter().zip(motions);
        pairs.for_each(|(a, motion)| axpy(&mut combined, *a, motion));
        combined
    };
    Ok(shares.iter().map(sum).collect())
}

/// Null space by transmission ratios if every row joins two coordinates at most: one motion per ungrounded component of the graph, from its
/// first coordinate on. None if a row joins more coordinates.
fn null_space_by_ratios(rows: &[Vec<f64>], n: usize) -> Option<Vec<Vec<f64>>> {
    let mut joins: Vec<Vec<(usize, f64, f64)>> = vec![Vec::new(); n];
    let mut grounded = vec![false; n];
    for row in rows {
        let entries = row.iter().enumerate().filter(|(_, a)| **a != 0.0);
        match entries.map(|(i, &a)| (i, a)).collect::<Vec<_>>()[..] {
            [] => {}
            [(i, _)] => grounded[i] = true,
            [(i, a), (j, b)] => {
                joins[i].push((j, a, b));
                joins[j].push((i, b, a));
            }
            _ => return None,
        }
    }
    let mut motions = Vec::new();
    let mut visited = vec![false; n];
    for first in 0..n {
        if visited[first] {
            continue;
        }
        let mut motion = vec![0.0; n];
        motion[first] = 1.0;
        visited[first] = true;
        let (mut component, mut next, mut free) = (vec![first], 0, true);
        while let Some(&i) = component.get(next) {
            next += 1;
            free &= !grounded[i];
            for &(j, a, b) in &joins[i] {
                if visited[j] {
                    let (term, joined) = (a * motion[i], b * motion[j]);
                    free &= (term + joined).abs() <= NULL_TOLERANCE * (term.abs() + joined.abs());
                } else {
                    visited[j] = true;
                    motion[j] = -a * motion[i] / b;
                    component.push(j);
                }
            }
        }
        if free {
            motions.push(motion);
        }
    }
    Some(motions)
}

/// Null space of any rows by singular value decomposition after equilibration of rows and columns.
fn null_space_by_svd(rows: &[Vec<f64>], n: usize) -> Result<Vec<Vec<f64>>, Error> {
    let mut units: Vec<Vec<f64>> = Vec::new();
    for row in rows {
        let size = row.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
        if size > 0.0 {
            units.push(row.iter().map(|x| x / size).collect());
        }
    }
    // Columns first differ by the roots of the inertias; a few sweeps equilibrate rows and columns.
    let mut size = vec![1.0; n];
    for _ in 0..3 {
        for j in 0..n {
            let largest_entry = units.iter().fold(0.0, |m: f64, row| m.max(row[j].abs()));
            if largest_entry > 0.0 {
                size[j] *= largest_entry;
                units.iter_mut().for_each(|row| row[j] /= largest_entry);
            }
        }
        for row in &mut units {
            let largest_entry = row.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            row.iter_mut().for_each(|x| *x /= largest_entry);
        }
    }
    let a = Matrix::from_fn(units.len().max(1), n, |i, j| {
        units.get(i).map_or(0.0, |row| row[j])
    });
    let svd = graded::svd(&a, None)?;
    let largest = svd.values.last().copied().unwrap_or(0.0);
    let null = (0..n).filter(|&k| svd.values[k] <= NULL_TOLERANCE * largest);
    Ok(null
        .map(|k| (0..n).map(|j| svd.vectors[(j, k)] / size[j]).collect())
        .collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three discs of very different inertia on two springs, one damper to ground: one motion strains the damper only.
    #[test]
    fn exact_rigid_motion_with_a_brake() {
        let root = MassFactor::Diagonal(vec![1e-4, 1.0, 1e5]);
        let row = |w: [f64; 3], k: f64| (root.solve(&w), f64::sqrt(k));
        let rows = StrainRows {
            squares: vec![row([-1.0, 1.0, 0.0], 1e9), row([0.0, -1.0, 1.0], 1.0)],
            dampers: vec![root.solve(&[1.0, 0.0, 0.0])],
            ..StrainRows::default()
        };
        let modes = RegimeModes::new(&root, &rows, 3).unwrap();
        assert_eq!((modes.free, modes.rigid, modes.omega[0]), (0, 1, 0.0));
        let shape = modes.shapes.col_as_slice(0);
        assert!((shape[0] / shape[2] - 1.0).abs() < 1e-13, "{shape:?}");
        let gram = modes.shapes.transpose() * &modes.momenta;
        assert!((gram - Matrix::identity(3, 3)).norm_max() < 1e-14);
    }

    /// A geared loop whose ratios multiply to one rotates freely, any other is locked; singular values agree.
    #[test]
    fn exact_loops_by_ratios() {
        for (last, free) in [(6.0, 2), (7.0, 1)] {
            let rows = [
                vec![1.0, -2.0, 0.0, 0.0],
                vec![0.0, 1.0, -3.0, 0.0],
                vec![1.0, 0.0, -last, 0.0],
            ];
            let motions = null_space_by_ratios(&rows, 4).unwrap();
            assert_eq!(motions.len(), free);
            assert_eq!(null_space_by_svd(&rows, 4).unwrap().len(), free);
            if free == 2 {
                assert_eq!(motions[0], [1.0, 0.5, 0.5 / 3.0, 0.0]);
            }
        }
        assert!(null_space_by_ratios(&[vec![1.0, 1.0, 1.0]], 3).is_none());
    }

    /// The two ends oscillate alone with the middle disc held.
    #[test]
    fn exact_stuck_middle() {
        let root = MassFactor::Diagonal(vec![1.0; 3]);
        let rows = StrainRows {
            squares: vec![(vec![-1.0, 1.0, 0.0], 2.0), (vec![0.0, -1.0, 1.0], 3.0)],
            stuck: vec![vec![0.0, 1.0, 0.0]],
            ..StrainRows::default()
        };
        let modes = RegimeModes::new(&root, &rows, 3).unwrap();
        assert_eq!(modes.count(), 2);
        assert!((modes.omega[0] - 2.0).abs() < 1e-14 && (modes.omega[1] - 3.0).abs() < 1e-14);
    }
}
