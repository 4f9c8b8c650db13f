//! Massless coordinates as algebraic unknowns of an index-1 DAE, `0 = g(t, q, v, z)`.
//!
//! A damped massless coordinate has its rate as unknown: `q̇ = v`, `0 = g`. An undamped one has its position and rate as unknowns:
//! `0 = g`, `0 = ġ`. Both are of index one if the damping, or the stiffness, of these coordinates is a regular matrix (Hairer and
//! Wanner, Solving Ordinary Differential Equations II, 2nd edition 1996, VI.1); higher index is rejected.

use super::dynamic_model::{DynamicModel, ElementState, ForceElement, ForceLaw, Regime};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_instant;
use crate::machine::direction::Direction;
use crate::numeric::lu::Lu;
use crate::numeric::{Matrix, symmetric};

/// Maximum number of Newton iterations for positions.
const MAX_NEWTON: usize = 60;

/// Newton correction, relative to the largest coordinate, that is rounding.
const ROUNDING: f64 = 1e-15;

/// Last Newton correction, relative to the largest coordinate, of a converged position.
const CONVERGED: f64 = 1e-9;

/// Maximum number of halvings of a Newton correction that does not reduce the residual force.
const MAX_HALVINGS: u32 = 40;

/// Maximum number of contact-state updates while positions are solved.
const MAX_UPDATES: usize = 20;

/// Smallest eigenvalue of a regular matrix with unit diagonal: the rounding of sums of squares.
const ROUNDING_TOLERANCE: f64 = 1e-13;

/// Massless coordinates by their algebraic unknown.
struct MasslessCoordinates {
    /// Coordinates with unknown rate.
    damped: Vec<usize>,
    /// Coordinates with unknown position and rate.
    undamped: Vec<usize>,
}

/// Reason against a method that requires inertia at all coordinates; absent if the model has it.
pub fn inertia_requirement(model: &DynamicModel) -> Option<String> {
    let first = (0..model.coordinate_count()).find(|&i| model.is_massless(i))?;
    Some(format!(
        "{} has no inertia and could not be eliminated from the equations",
        model.coordinates[first]
    ))
}

/// Whether an element may act on a retained coordinate without inertia.
pub fn allows_massless(b: &ForceElement) -> bool {
    let law = matches!(
        b.law,
        ForceLaw::Linear { .. }
            | ForceLaw::Nonlinear { .. }
            | ForceLaw::Maxwell { .. }
            | ForceLaw::Contact(_)
    );
    law && b.force_direction.is_none() && b.stiffness_wave.is_none() && b.angle_waves.is_empty()
}

/// Whether the element's force depends on its rate in the present state.
fn damps(b: &ForceElement, state: ElementState) -> bool {
    match (&b.law, state) {
        (ForceLaw::Linear { damping, .. } | ForceLaw::Nonlinear { damping, .. }, _) => {
            *damping > 0.0
        }
        (ForceLaw::Contact(contact), ElementState::Contact(state, _)) => {
            contact.force(state, 1.0).rate != 0.0
        }
        _ => false,
    }
}

fn component(direction: &Direction, coordinate: usize) -> f64 {
    let terms = direction.entries().filter(|x| x.0 == coordinate);
    terms.map(|x| x.1).sum()
}

impl DynamicModel {
    /// Whether the given coordinate has no inertia.
    pub fn is_massless(&self, coordinate: usize) -> bool {
        self.mass.entry(coordinate, coordinate) == 0.0
    }

    /// Whether a coordinate has no inertia.
    pub fn has_massless(&self) -> bool {
        (0..self.coordinate_count()).any(|i| self.is_massless(i))
    }

    fn massless(&self, states: &[ElementState]) -> MasslessCoordinates {
        let is_damped = |&i: &usize| {
            let mut acting = self.elements.iter().zip(states);
            acting.any(|(b, &state)| damps(b, state) && component(&b.direction, i) != 0.0)
        };
        let massless = (0..self.coordinate_count()).filter(|&i| self.is_massless(i));
        let (damped, undamped) = massless.partition(is_damped);
        MasslessCoordinates { damped, undamped }
    }

    /// Mask of differential states; the rows of all other states are algebraic residuals.
    pub fn differential_states(&self, regime: &Regime) -> Vec<bool> {
        let n = self.coordinate_count();
        let MasslessCoordinates { damped, undamped } = self.massless(&regime.states);
        let mut moves = vec![true; 2 * n + self.internal_count()];
        for &i in damped.iter().chain(&undamped) {
            moves[n + i] = false;
        }
        for i in undamped {
            moves[i] = false;
        }
        moves
    }

    /// Replaces the equations of motion of massless coordinates by algebraic residuals; `g` are the forces on all coordinates, N·m
    /// or N. `dy` contains the rates of internal states.
    pub fn algebraic_rows(
        &self,
        regime: Option<&Regime>,
        (t, y): (f64, &[f64]),
        g: &[f64],
        dy: &mut [f64],
    ) {
        let n = self.coordinate_count();
        let regime = self.output_regime(regime, t, y);
        let MasslessCoordinates { damped, undamped } = self.massless(&regime.states);
        for i in damped {
            dy[n + i] = g[i];
        }
        for i in undamped {
            dy[n + i] = self.force_rate(i, &regime, (t, y), dy);
            dy[i] = g[i];
        }
    }

    /// Force rate ġ, N·m/s or N/s, of an undamped massless coordinate.
    fn force_rate(
        &self,
        coordinate: usize,
        regime: &Regime,
        (t, y): (f64, &[f64]),
        dy: &[f64],
    ) -> f64 {
        let n = self.coordinate_count();
        let mut sum = 0.0;
        for (index, drive) in self.forces.iter().enumerate() {
            let entry = component(&drive.direction, coordinate);
            if entry != 0.0 {
                sum += entry * drive.signal.slope(t, regime.pieces[index] as usize);
            }
        }
        let mut inner = 2 * n;
        for (index, b) in self.elements.iter().enumerate() {
            let entry = component(&b.direction, coordinate);
            if entry != 0.0 {
                let piece = self.error_pieces(Some(regime), index, t);
                let change = match b.law {
                    ForceLaw::Maxwell { .. } => dy[inner],
                    _ => {
                        let (_, rate) = b.deflection(t, &y[..n], &y[n..2 * n], piece);
                        self.element_force(index, Some(regime), t, y, 0.0).1 * rate
                    }
                };
                sum -= entry * change;
            }
            inner += b.internal_count();
        }
        sum
    }

    /// Matrix `Σ x w wᵀ` over some coordinates, with a coefficient x per element.
    fn assemble_rows(&self, coordinates: &[usize], x: impl Fn(usize) -> f64) -> Matrix {
        let m = coordinates.len();
        let mut sum = Matrix::zeros(m, m);
        for (element, b) in self.elements.iter().enumerate() {
            let row: Vec<f64> = coordinates
                .iter()
                .map(|&i| component(&b.direction, i))
                .collect();
            if row.iter().all(|a| *a == 0.0) {
                continue;
            }
            let x = x(element);
            for i in 0..m {
                for j in 0..m {
                    sum[(i, j)] += x * row[i] * row[j];
                }
            }
        }
        sum
    }

    /// Checks that the equations are of index one in every contact state: with all contacts open, the remaining elements determine
    /// every massless coordinate.
    ///
    /// # Errors
    /// The first undetermined coordinate.
    pub fn check_index_one(&self) -> Result<(), usize> {
        let open = |b: &ForceElement| match &b.law {
            ForceLaw::Contact(contact) => ElementState::Contact(contact.state(0.0, 0.0, 1.0), 0),
            _ => ElementState::Smooth,
        };
        let states: Vec<ElementState> = self.elements.iter().map(open).collect();
        let MasslessCoordinates { damped, undamped } = self.massless(&states);
        let contact_force = |element: usize| match (&self.elements[element].law, states[element]) {
            (ForceLaw::Contact(contact), ElementState::Contact(state, _)) => {
                contact.force(state, 1.0)
            }
            _ => Default::default(),
        };
        let damper = |element: usize| match &self.elements[element].law {
            ForceLaw::Linear { damping, .. } | ForceLaw::Nonlinear { damping, .. } => *damping,
            _ => contact_force(element).rate,
        };
        let spring = |element: usize| match &self.elements[element].law {
            ForceLaw::Linear { stiffness, .. } => *stiffness,
            ForceLaw::Nonlinear { characteristic, .. } => characteristic.rated_secant(),
            _ => contact_force(element).deflection,
        };
        regular(&self.assemble_rows(&damped, damper), &damped)?;
        regular(&self.assemble_rows(&undamped, spring), &undamped)
    }

    /// Consistent state: solves the algebraic unknowns for given differential states.
    ///
    /// # Errors
    /// `NoConvergence` for undetermined unknowns.
    pub fn consistent_state(&self, regime: &Regime, t: f64, y: &[f64]) -> Result<Vec<f64>, Error> {
        let n = self.coordinate_count();
        let MasslessCoordinates { damped, undamped } = self.massless(&regime.states);
        let mut y = y.to_vec();
        self.solve_positions(&undamped, regime, t, &mut y)?;
        let undetermined = |_: Error| self.undetermined_error(t);
        if !damped.is_empty() {
            let rates = self.assemble_rows(&damped, |element| {
                self.element_force(element, Some(regime), t, &y, 0.0).2
            });
            let rates = Lu::new(&rates).map_err(undetermined)?;
            // The second solution removes the rounding error of the first.
            for _ in 0..2 {
                let g = self.applied_forces(Some(regime), t, &y);
                let mut change: Vec<f64> = damped.iter().map(|&i| g[i]).collect();
                rates.solve(&mut change);
                damped.iter().zip(change).for_each(|(&i, x)| y[n + i] += x);
            }
        }
        if !undamped.is_empty() {
            let stiffness =
                self.assemble_rows(&undamped, |element| match self.elements[element].law {
                    ForceLaw::Maxwell { stiffness, .. } => stiffness,
                    _ => self.element_force(element, Some(regime), t, &y, 0.0).1,
                });
            let stiffness = Lu::new(&stiffness).map_err(undetermined)?;
            for _ in 0..2 {
                let mut dy = vec![0.0; y.len()];
                self.derivative_in(Some(regime), t, &y, &mut dy);
                let mut change: Vec<f64> = undamped.iter().map(|&i| dy[n + i]).collect();
                stiffness.solve(&mut change);
                undamped
                    .iter()
                    .zip(change)
                    .for_each(|(&i, x)| y[n + i] += x);
            }
        }
        Ok(y)
    }

    /// Newton's iteration for the positions of undamped massless coordinates.
    fn solve_positions(
        &self,
        undamped: &[usize],
        regime: &Regime,
        t: f64,
        y: &mut [f64],
    ) -> Result<(), Error> {
        if undamped.is_empty() {
            return Ok(());
        }
        let n = self.coordinate_count();
        let forces = |y: &[f64]| -> Vec<f64> {
            let g = self.applied_forces(Some(regime), t, y);
            undamped.iter().map(|&i| g[i]).collect()
        };
        let size = |g: &[f64]| g.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let mut current = forces(y);
        let mut last = f64::INFINITY;
        for _ in 0..MAX_NEWTON {
            let stiffness = self.assemble_rows(undamped, |element| {
                self.element_force(element, Some(regime), t, y, 0.0).1
            });
            let lu = Lu::new(&stiffness).map_err(|_| self.undetermined_error(t))?;
            let mut change = current.clone();
            lu.solve(&mut change);
            let largest = y[..n].iter().fold(0.0f64, |m, x| m.max(x.abs()));
            last = size(&change) / largest.max(f64::MIN_POSITIVE);
            let start = y.to_vec();
            let reduced = (0..MAX_HALVINGS).any(|halving| {
                let share = f64::from(halving).exp2().recip();
                undamped
                    .iter()
                    .zip(&change)
                    .for_each(|(&i, x)| y[i] = start[i] + share * x);
                let residual = forces(y);
                let reduced = size(&residual) < size(&current);
                if reduced {
                    current = residual;
                }
                reduced
            });
            if !reduced {
                y.copy_from_slice(&start);
            }
            if !reduced || last <= ROUNDING {
                break;
            }
        }
        match last <= CONVERGED || size(&current) == 0.0 {
            true => Ok(()),
            false => Err(self.undetermined_error(t)),
        }
    }

    /// Regime at a state and the consistent state.
    ///
    /// # Errors
    /// As [`DynamicModel::consistent_state`].
    pub fn consistent_regime(&self, t: f64, y: &[f64]) -> Result<(Regime, Vec<f64>), Error> {
        let mut regime = self.regime(t, y);
        if !self.has_massless() {
            return Ok((regime, y.to_vec()));
        }
        let mut y = y.to_vec();
        for _ in 0..MAX_UPDATES {
            y = self.consistent_state(&regime, t, &y)?;
            let next = self.regime(t, &y);
            if next == regime {
                break;
            }
            regime = next;
        }
        Ok((regime, y))
    }

    fn undetermined_error(&self, t: f64) -> Error {
        let massless = (0..self.coordinate_count()).filter(|&i| self.is_massless(i));
        let names: Vec<&str> = massless.map(|i| &self.coordinates[i][..]).collect();
        let message = format!(
            "at t = {} neither stiffness nor dampers determine {}, which has no inertia",
            format_instant(t),
            names.join(", ")
        );
        Error::new(Code::NoConvergence, message).with_hint(
            "give the node its inertia, or a spring parallel to the element without stiffness there",
        )
    }
}

/// Checks that a sum of squares is regular; the error is the first undetermined coordinate.
fn regular(a: &Matrix, coordinates: &[usize]) -> Result<(), usize> {
    let Some(&first) = coordinates.first() else {
        return Ok(());
    };
    let undetermined = (0..coordinates.len()).find(|&i| a[(i, i)] <= 0.0);
    if let Some(index) = undetermined {
        return Err(coordinates[index]);
    }
    // Scaled to unit diagonal, so that the stiffness ratio does not matter.
    let unit = |i: usize| a[(i, i)].sqrt().recip();
    let scaled = Matrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * unit(i) * unit(j));
    let smallest = symmetric::symmetric_eigen(&scaled)
        .map(|eigen| eigen.values.into_iter().fold(f64::INFINITY, f64::min));
    match smallest.is_ok_and(|x| x > ROUNDING_TOLERANCE) {
        true => Ok(()),
        false => Err(first),
    }
}
