//! Floquet stability: the monodromy matrix Φ of one period and its eigenvalues.

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
use crate::numeric::sorting::sort_falling;

pub mod multiplier_collision;

pub mod stability_chart;

pub mod orbit;

pub mod fold;

/// Multipliers may be above one by this much: on the circle two that meet are found to the square root of rounding.
pub const MULTIPLIER_TOLERANCE: f64 = 1e-7;

/// Monodromy matrix: the map of a state over a period.
#[derive(Debug, Clone)]
pub struct Monodromy {
    /// Φ, in the machine's units.
    pub matrix: Matrix,
    /// T, s.
    pub period: f64,
    /// Φ in units in which all states are of like size.
    scaled: Matrix,
    /// Coordinates along which nothing resists, then the ones that do, orthonormal columns in those units.
    basis: Matrix,
    rigid: usize,
}

/// Eigenvalues of Φ.
#[derive(Debug, Clone)]
pub struct FloquetMultipliers {
    /// Those of free turning first, then the others by falling size.
    pub values: Vec<Complex>,
    /// Number of multipliers that belong to free turning.
    pub rigid: usize,
    /// The largest size of the others.
    pub largest: f64,
    /// T, s.
    pub period: f64,
}

impl FloquetMultipliers {
    /// No motion grows.
    pub fn is_stable(&self) -> bool {
        self.largest <= 1.0 + MULTIPLIER_TOLERANCE
    }

    /// Stability margin: `1 − |μ|`.
    pub fn margin(&self) -> f64 {
        1.0 - self.largest
    }

    /// Growth of the fastest motion, 1/s: `ln|μ|/T`.
    pub fn exponent(&self) -> f64 {
        self.largest.ln() / self.period
    }
}

/// Φ of a machine in a regime, with all contacts closed where none is given; the period starts at t = 0.
///
/// # Errors
/// What the periodic method refuses.
pub fn monodromy(model: &DynamicModel, regime: Option<&Regime>) -> Result<Monodromy, Error> {
    let states = match regime {
        Some(regime) => without_wave_pieces(regime.clone()).states,
        None => closed_states(model),
    };
    let from = 0.0;
    let (scale, grid) = period_grid(model, from)?;
    let (n, all) = (model.coordinate_count(), scale.units.len());
    let work = grid.pieces.len() as f64 * (all as f64).powi(3);
    if work > MAX_WORK {
        return Err(budget_exceeded(&grid, all, work));
    }
    let by_rows = |flat: &[f64]| Matrix::from_fn(all, all, |i, j| flat[i * all + j]);
    let mut scaled = Matrix::identity(all, all);
    let mut before: Option<(TimeVaryingModel, Matrix)> = None;
    for &piece in &grid.pieces {
        let held = freeze_states(model, from, &states, piece)?;
        // Between the jumps of rectangular waves pieces are alike.
        let alike =
            |b: &(TimeVaryingModel, Matrix)| b.0.half == held.half && b.0.branches == held.branches;
        let over = match before.take().filter(alike) {
            Some((_, over)) => over,
            None => {
                let free = FundamentalSolutions::new(&held, &scale, &states)?;
                by_rows(&free.to_end) * by_rows(&free.from_start)
            }
        };
        scaled = &over * scaled;
        before = Some((held, over));
    }
    let units = &scale.units;
    let branches = before.map_or(Vec::new(), |(held, _)| held.branches);
    let elastic = model.elements.iter().zip(&branches);
    let mut rows: Vec<Vec<f64>> = elastic
        .filter(|(_, held)| held.is_elastic())
        .map(|(b, _)| {
            let mut row = vec![0.0; n];
            b.direction
                .entries()
                .for_each(|(i, w)| row[i] = w * units[i]);
            row
        })
        .collect();
    if let Some((stiffness, _)) = &model.unattached {
        rows.extend((0..n).map(|i| (0..n).map(|j| stiffness[(i, j)] * units[j]).collect()));
    }
    let (basis, rigid) = rigid_body_basis(&rows, n)?;
    Ok(Monodromy {
        matrix: Matrix::from_fn(all, all, |i, j| scaled[(i, j)] * (units[i] / units[j])),
        period: grid.period,
        scaled,
        basis,
        rigid,
    })
}

/// Work that makes sense, in pieces times multiplications of a product of matrices: minutes.
const MAX_WORK: f64 = 1e11;

fn budget_exceeded(grid: &PeriodGrid, states: usize, work: f64) -> Error {
    let message = format!(
        "what a period of {} does takes {} pieces of {states} states, {work:.0e} multiplications; {MAX_WORK:.0e} are allowed",
        format_time(grid.period),
        grid.pieces.len(),
    );
    Error::new(Code::BudgetExceeded, message)
        .with_hint("the fastest motion is far from the period: make what is so stiff rigid")
}

fn closed_states(model: &DynamicModel) -> Vec<ElementState> {
    let stand = |law: &ForceLaw| match law {
        ForceLaw::Contact(_) => ElementState::Contact(ContactState::Closed(Flank::Drive), 0),
        _ => ElementState::Smooth,
    };
    model.elements.iter().map(|b| stand(&b.law)).collect()
}

/// Directions no row resists, then the others, and how many the first are.
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

/// A direction is free where the unit rows see less of it than this, squared: chains of hundred inertias are seen by 1e-4.
const NULL_SPACE_TOLERANCE: f64 = 1e-11;

impl Monodromy {
    /// The eigenvalues of Φ; those of free turning apart, since two that meet at one are only found to the square root of rounding.
    ///
    /// # Errors
    /// `NoConvergence` where the eigenvalues are not found.
    pub fn multipliers(&self) -> Result<FloquetMultipliers, Error> {
        let n = self.basis.nrows();
        let all = self.scaled.nrows();
        let turned = |both: bool| -> Vec<usize> {
            let count = if both { 2 } else { 1 };
            (0..count)
                .flat_map(|part| (0..self.rigid).map(move |i| part * n + i))
                .collect()
        };
        // Φ in the basis of free turning and the rest, once for coordinates and once for speeds.
        let wide = Matrix::from_fn(all, all, |i, j| match (i / n, j / n) {
            (0, 0) => self.basis[(i, j)],
            (1, 1) => self.basis[(i - n, j - n)],
            (a, b) if a >= 2 && b >= 2 => f64::from(i == j),
            _ => 0.0,
        });
        let phi = wide.transpose() * &self.scaled * &wide;
        let both = turned(true);
        let others =
            |apart: &[usize]| -> Vec<usize> { (0..all).filter(|i| !apart.contains(i)).collect() };
        let leaks = |apart: &[usize]| {
            let rest = others(apart);
            let sizes = rest
                .iter()
                .flat_map(|&i| apart.iter().map(move |&j| (i, j)));
            sizes.map(|at| phi[at].abs()).fold(0.0, f64::max) > COUPLING_TOLERANCE
        };
        let apart = if leaks(&both) { turned(false) } else { both };
        let rest = others(&apart);
        let block = |at: &[usize]| Matrix::from_fn(at.len(), at.len(), |i, j| phi[(at[i], at[j])]);
        let mut elastic = eigen::eigenvalues(&block(&rest))?;
        sort_falling(&mut elastic, |a| a.norm());
        let mut values = vec![Complex::new(1.0, 0.0); self.rigid];
        if apart.len() > self.rigid {
            values.extend(eigen::eigenvalues(&block(&apart[self.rigid..]))?);
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

/// Free turning keeps to itself where what leaks out of it in a period is rounding.
const COUPLING_TOLERANCE: f64 = 1e-9;
