//! Floquet stability: monodromy matrix `x(t + T) = Φ x(t)` of one period and its eigenvalues, the multipliers μ.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_time;
use crate::numeric::{Complex, Matrix, eigen, symmetric};

use super::contact::{ContactState, Flank};
use super::dynamic_model::{DynamicModel, ElementState, ForceLaw, Regime};
use super::methods::periodic::fundamental::{FundamentalSolutions, freeze_states, period_grid};
use super::methods::periodic::grid::PeriodGrid;
use super::methods::periodic::run::without_wave_pieces;
use super::taylor::TimeVaryingModel;
use crate::numeric::sorting::sort_descending;

pub mod multiplier_collision;

pub mod stability_chart;

pub mod orbit;

pub mod fold;

/// Excess of |μ| over one that still counts as stable: coincident multipliers are accurate to the square root of rounding.
pub const MULTIPLIER_TOLERANCE: f64 = 1e-7;

/// Monodromy matrix: map of the state over one period.
#[derive(Debug, Clone)]
pub struct Monodromy {
    /// Monodromy matrix Φ in SI units.
    pub matrix: Matrix,
    /// Period T, s.
    pub period: f64,
    /// Φ in units in which all states are of similar size.
    scaled: Matrix,
    /// Rigid-body directions, then the elastic ones, as orthonormal columns in those units.
    basis: Matrix,
    rigid: usize,
}

/// Eigenvalues μ of Φ, the Floquet multipliers.
#[derive(Debug, Clone)]
pub struct FloquetMultipliers {
    /// Multipliers of rigid-body rotation first, then the others by falling |μ|.
    pub values: Vec<Complex>,
    /// Number of multipliers of rigid-body rotation.
    pub rigid: usize,
    /// Largest |μ| of the other multipliers.
    pub largest: f64,
    /// Period T, s.
    pub period: f64,
}

impl FloquetMultipliers {
    /// Whether no perturbation grows: |μ| ≤ 1 within [`MULTIPLIER_TOLERANCE`].
    pub fn is_stable(&self) -> bool {
        self.largest <= 1.0 + MULTIPLIER_TOLERANCE
    }

    /// Stability margin `1 − |μ|` of the largest multiplier; negative if unstable.
    pub fn margin(&self) -> f64 {
        1.0 - self.largest
    }

    /// Largest Floquet exponent `ln|μ|/T`, 1/s.
    pub fn exponent(&self) -> f64 {
        self.largest.ln() / self.period
    }
}

/// Monodromy matrix of a model in a regime, by default with all contacts closed; the period starts at t = 0.
///
/// # Errors
/// Those of the periodic method; `BudgetExceeded` for too many pieces.
pub fn monodromy(model: &DynamicModel, regime: Option<&Regime>) -> Result<Monodromy, Error> {
    let states = match regime {
        Some(regime) => without_wave_pieces(regime.clone()).states,
        None => closed_states(model),
    };
    let from = 0.0;
    let (scale, grid) = period_grid(model, from)?;
    let (n, dim) = (model.coordinate_count(), scale.units.len());
    let work = grid.pieces.len() as f64 * (dim as f64).powi(3);
    if work > MAX_WORK {
        return Err(budget_exceeded(&grid, dim, work));
    }
    let by_rows = |flat: &[f64]| Matrix::from_fn(dim, dim, |i, j| flat[i * dim + j]);
    let mut scaled = Matrix::identity(dim, dim);
    let mut last: Option<(TimeVaryingModel, Matrix)> = None;
    for &piece in &grid.pieces {
        let ltv = freeze_states(model, from, &states, piece)?;
        // Pieces between the jumps of rectangular waves are equal.
        let equal =
            |b: &(TimeVaryingModel, Matrix)| b.0.half == ltv.half && b.0.branches == ltv.branches;
        let map = match last.take().filter(equal) {
            Some((_, map)) => map,
            None => {
                let fundamental = FundamentalSolutions::new(&ltv, &scale, &states)?;
                by_rows(&fundamental.to_end) * by_rows(&fundamental.from_start)
            }
        };
        scaled = &map * scaled;
        last = Some((ltv, map));
    }
    let units = &scale.units;
    let branches = last.map_or(Vec::new(), |(ltv, _)| ltv.branches);
    let elastic = model.elements.iter().zip(&branches);
    let mut rows: Vec<Vec<f64>> = elastic
        .filter(|(_, ltv)| ltv.is_elastic())
        .map(|(b, _)| {
            let mut row = vec![0.0; n];
            b.direction
                .entries()
                .for_each(|(i, w)| row[i] = w * units[i]);
            row
        })
        .collect();
    if let Some((stiffness, _)) = &model.global_matrices {
        rows.extend((0..n).map(|i| (0..n).map(|j| stiffness[(i, j)] * units[j]).collect()));
    }
    let (basis, rigid) = rigid_body_basis(&rows, n)?;
    Ok(Monodromy {
        matrix: Matrix::from_fn(dim, dim, |i, j| scaled[(i, j)] * (units[i] / units[j])),
        period: grid.period,
        scaled,
        basis,
        rigid,
    })
}

/// Work limit in multiplications, pieces × n³; it corresponds to minutes.
const MAX_WORK: f64 = 1e11;

fn budget_exceeded(grid: &PeriodGrid, states: usize, work: f64) -> Error {
    let message = format!(
        "a period of {} takes {} segments of {states} states, {work:.0e} multiplications (limit {MAX_WORK:.0e})",
        format_time(grid.period),
        grid.pieces.len(),
    );
    Error::new(Code::BudgetExceeded, message)
        .with_hint("the period is too long for the fastest mode: make the stiffest element rigid")
}

fn closed_states(model: &DynamicModel) -> Vec<ElementState> {
    let closed = |law: &ForceLaw| match law {
        ForceLaw::Contact(_) => ElementState::Contact(ContactState::Closed(Flank::Drive), 0),
        _ => ElementState::Smooth,
    };
    model.elements.iter().map(|b| closed(&b.law)).collect()
}

/// Orthonormal basis with the null space of the rows first, and the dimension of the null space.
pub(crate) fn rigid_body_basis(rows: &[Vec<f64>], n: usize) -> Result<(Matrix, usize), Error> {
    let mut gram = Matrix::zeros(n, n);
    for row in rows {
        let size: f64 = row.iter().map(|x| x * x).sum();
        if size > 0.0 {
            for i in 0..n {
                for j in 0..n {
                    gram[(i, j)] += row[i] * row[j] / size;
                }
            }
        }
    }
    let eigen = symmetric::symmetric_eigen(&gram)?;
    let rigid = eigen
        .values
        .iter()
        .filter(|&&x| x < NULL_SPACE_TOLERANCE)
        .count();
    Ok((eigen.vectors, rigid))
}

/// Eigenvalue of the Gram matrix of the unit rows below which a direction is free; elastic ones of chains of 100 inertias exceed 1e-8.
const NULL_SPACE_TOLERANCE: f64 = 1e-11;

impl Monodromy {
    /// Eigenvalues of Φ; those of rigid-body rotation separately, as double eigenvalues are accurate to the square root of rounding only.
    ///
    /// # Errors
    /// `NoConvergence` of the eigenvalue iteration.
    pub fn multipliers(&self) -> Result<FloquetMultipliers, Error> {
        let n = self.basis.nrows();
        let dim = self.scaled.nrows();
        let rigid = |both: bool| -> Vec<usize> {
            let count = if both { 2 } else { 1 };
            (0..count)
                .flat_map(|part| (0..self.rigid).map(move |i| part * n + i))
                .collect()
        };
        // Φ in the basis of rigid-body and elastic directions, for coordinates and for speeds.
        let transform = Matrix::from_fn(dim, dim, |i, j| match (i / n, j / n) {
            (0, 0) => self.basis[(i, j)],
            (1, 1) => self.basis[(i - n, j - n)],
            (a, b) if a >= 2 && b >= 2 => f64::from(i == j),
            _ => 0.0,
        });
        let phi = transform.transpose() * &self.scaled * &transform;
        let both = rigid(true);
        let others =
            |set: &[usize]| -> Vec<usize> { (0..dim).filter(|i| !set.contains(i)).collect() };
        let mixes = |set: &[usize]| {
            let rows = others(set);
            let sizes = rows.iter().flat_map(|&i| set.iter().map(move |&j| (i, j)));
            sizes.map(|at| phi[at].abs()).fold(0.0, f64::max) > COUPLING_TOLERANCE
        };
        let set = if mixes(&both) { rigid(false) } else { both };
        let rows = others(&set);
        let block = |at: &[usize]| Matrix::from_fn(at.len(), at.len(), |i, j| phi[(at[i], at[j])]);
        let mut elastic = eigen::eigenvalues(&block(&rows))?;
        sort_descending(&mut elastic, |a| a.norm());
        let mut values = vec![Complex::new(1.0, 0.0); self.rigid];
        if set.len() > self.rigid {
            values.extend(eigen::eigenvalues(&block(&set[self.rigid..]))?);
        }
        let largest = elastic.first().map_or(0.0, |z| z.norm());
        let rigid = values.len();
        values.extend(elastic);
        Ok(FloquetMultipliers {
            values,
            rigid,
            largest,
            period: self.period,
        })
    }
}

/// Coupling of rigid-body rotation to the other states over one period that counts as rounding.
const COUPLING_TOLERANCE: f64 = 1e-9;
