//! Massless coordinates kept as algebraic unknowns `0 = g(t, q, v, z)` (index-1 DAE).
//!
//! Where a damper acts on one, its row gives the rate: `q̇ = v`, `0 = g`. Else it gives the place, and what keeps it zero the rate:
//! `0 = g`, `0 = ġ`. Both are of index one while the dampers there, or the stiffness there, form a regular matrix (Hairer and Wanner,
//! Solving Ordinary Differential Equations II, 2nd edition 1996, VI.1); what is of higher index is refused.

use super::dynamic_model::{DynamicModel, ElementState, ForceElement, ForceLaw, Regime};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_instant;
use crate::machine::direction::Direction;
use crate::numeric::lu::Lu;
use crate::numeric::{Matrix, symmetric};

/// Rounds of Newton's iteration for places: it starts where the last step ended.
const MAX_NEWTON: usize = 60;

/// Changes of this size, relative to the largest coordinate, are rounding.
const ROUNDING: f64 = 1e-15;

/// A last change beyond this, relative to the largest coordinate, is no place found.
const CONVERGED: f64 = 1e-9;

/// Halvings of a change that does not bring the forces nearer to balance.
const MAX_HALVINGS: u32 = 40;

/// Maximum number of contact-state updates while positions are solved.
const MAX_UPDATES: usize = 20;

/// An eigenvalue of a matrix with ones on its diagonal below this is zero: the rounding of sums of squares.
const ROUNDING_TOLERANCE: f64 = 1e-13;

/// Coordinates without inertia, by what their rows give.
struct MasslessCoordinates {
    /// Their rates.
    damped: Vec<usize>,
    /// Their places.
    fixed: Vec<usize>,
}

/// Why a method that divides by inertia cannot take a machine; absent where it can.
pub fn why_inertia_needed(model: &DynamicModel) -> Option<String> {
    let first = (0..model.coordinate_count()).find(|&i| model.is_massless(i))?;
    Some(format!(
        "{} has no inertia, and what acts there could not be taken out of the equations",
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
    let own = direction.entries().filter(|x| x.0 == coordinate);
    own.map(|x| x.1).sum()
}

impl DynamicModel {
    /// Whether a coordinate has no inertia.
    pub fn is_massless(&self, coordinate: usize) -> bool {
        self.mass.entry(coordinate, coordinate) == 0.0
    }

    /// Some coordinate has no inertia.
    pub fn has_massless(&self) -> bool {
        (0..self.coordinate_count()).any(|i| self.is_massless(i))
    }

    fn light(&self, states: &[ElementState]) -> MasslessCoordinates {
        let is_damped = |&i: &usize| {
            let mut acting = self.elements.iter().zip(states);
            acting.any(|(b, &stand)| damps(b, stand) && component(&b.direction, i) != 0.0)
        };
        let light = (0..self.coordinate_count()).filter(|&i| self.is_massless(i));
        let (damped, held) = light.partition(is_damped);
        MasslessCoordinates {
            damped,
            fixed: held,
        }
    }

    /// Which states an equation of motion moves; the rows of the others hold what must be zero.
    pub fn differential_states(&self, regime: &Regime) -> Vec<bool> {
        let n = self.coordinate_count();
        let MasslessCoordinates {
            damped,
            fixed: held,
        } = self.light(&regime.states);
        let mut moves = vec![true; 2 * n + self.internal_count()];
        for &i in damped.iter().chain(&held) {
            moves[n + i] = false;
        }
        for i in held {
            moves[i] = false;
        }
        moves
    }

    /// Puts the rows of coordinates without inertia in place of their equations of motion; `g` are the forces on all
    /// coordinates, and the rows of inner states are there.
    pub fn algebraic_rows(
        &self,
        regime: Option<&Regime>,
        (t, y): (f64, &[f64]),
        g: &[f64],
        dy: &mut [f64],
    ) {
        let n = self.coordinate_count();
        let regime = self.output_regime(regime, t, y);
        let MasslessCoordinates {
            damped,
            fixed: held,
        } = self.light(&regime.states);
        for i in damped {
            dy[n + i] = g[i];
        }
        for i in held {
            dy[n + i] = self.force_rate(i, &regime, (t, y), dy);
            dy[i] = g[i];
        }
    }

    /// ġ of a coordinate without inertia that no damper acts on.
    fn force_rate(
        &self,
        coordinate: usize,
        regime: &Regime,
        (t, y): (f64, &[f64]),
        dy: &[f64],
    ) -> f64 {
        let n = self.coordinate_count();
        let mut sum = 0.0;
        for (at, drive) in self.forces.iter().enumerate() {
            let own = component(&drive.direction, coordinate);
            if own != 0.0 {
                sum += own * drive.signal.slope(t, regime.pieces[at] as usize);
            }
        }
        let mut inner = 2 * n;
        for (at, b) in self.elements.iter().enumerate() {
            let own = component(&b.direction, coordinate);
            if own != 0.0 {
                let piece = self.error_pieces(Some(regime), at, t);
                let change = match b.law {
                    ForceLaw::Maxwell { .. } => dy[inner],
                    _ => {
                        let (_, rate) = b.deflection(t, &y[..n], &y[n..2 * n], piece);
                        self.element_force(at, Some(regime), t, y, 0.0).1 * rate
                    }
                };
                sum -= own * change;
            }
            inner += b.internal_count();
        }
        sum
    }

    /// `Σ x w wᵀ` over some coordinates, x of every branch.
    fn assemble_rows(&self, coordinates: &[usize], x: impl Fn(usize) -> f64) -> Matrix {
        let m = coordinates.len();
        let mut sum = Matrix::zeros(m, m);
        for (at, b) in self.elements.iter().enumerate() {
            let own: Vec<f64> = coordinates
                .iter()
                .map(|&i| component(&b.direction, i))
                .collect();
            if own.iter().all(|a| *a == 0.0) {
                continue;
            }
            let x = x(at);
            for i in 0..m {
                for j in 0..m {
                    sum[(i, j)] += x * own[i] * own[j];
                }
            }
        }
        sum
    }

    /// Checks that the equations are of index one in every contact state: with all contacts open, the remaining elements hold every
    /// coordinate without inertia.
    ///
    /// # Errors
    /// The first coordinate that nothing holds.
    pub fn check_index_one(&self) -> Result<(), usize> {
        let open = |b: &ForceElement| match &b.law {
            ForceLaw::Contact(contact) => ElementState::Contact(contact.state(0.0, 0.0, 1.0), 0),
            _ => ElementState::Smooth,
        };
        let states: Vec<ElementState> = self.elements.iter().map(open).collect();
        let MasslessCoordinates {
            damped,
            fixed: held,
        } = self.light(&states);
        let of_contact = |at: usize| match (&self.elements[at].law, states[at]) {
            (ForceLaw::Contact(contact), ElementState::Contact(state, _)) => {
                contact.force(state, 1.0)
            }
            _ => Default::default(),
        };
        let damper = |at: usize| match &self.elements[at].law {
            ForceLaw::Linear { damping, .. } | ForceLaw::Nonlinear { damping, .. } => *damping,
            _ => of_contact(at).rate,
        };
        let spring = |at: usize| match &self.elements[at].law {
            ForceLaw::Linear { stiffness, .. } => *stiffness,
            ForceLaw::Nonlinear { characteristic, .. } => characteristic.rated_secant(),
            _ => of_contact(at).deflection,
        };
        regular(&self.assemble_rows(&damped, damper), &damped)?;
        regular(&self.assemble_rows(&held, spring), &held)
    }

    /// The state with what has no equation of motion where it must be, the rest as it is.
    ///
    /// # Errors
    /// `NoConvergence` where nothing says where that is.
    pub fn consistent_state(&self, regime: &Regime, t: f64, y: &[f64]) -> Result<Vec<f64>, Error> {
        let n = self.coordinate_count();
        let MasslessCoordinates {
            damped,
            fixed: held,
        } = self.light(&regime.states);
        let mut y = y.to_vec();
        self.solve_positions(&held, regime, t, &mut y)?;
        let floats = |_: Error| self.undetermined_error(t);
        if !damped.is_empty() {
            let rates = self.assemble_rows(&damped, |at| {
                self.element_force(at, Some(regime), t, &y, 0.0).2
            });
            let rates = Lu::new(&rates).map_err(floats)?;
            // The second time takes off what rounding left.
            for _ in 0..2 {
                let g = self.applied_forces(Some(regime), t, &y);
                let mut change: Vec<f64> = damped.iter().map(|&i| g[i]).collect();
                rates.solve(&mut change);
                damped.iter().zip(change).for_each(|(&i, x)| y[n + i] += x);
            }
        }
        if !held.is_empty() {
            let stiffness = self.assemble_rows(&held, |at| match self.elements[at].law {
                ForceLaw::Maxwell { stiffness, .. } => stiffness,
                _ => self.element_force(at, Some(regime), t, &y, 0.0).1,
            });
            let stiffness = Lu::new(&stiffness).map_err(floats)?;
            for _ in 0..2 {
                let mut dy = vec![0.0; y.len()];
                self.derivative_in(Some(regime), t, &y, &mut dy);
                let mut change: Vec<f64> = held.iter().map(|&i| dy[n + i]).collect();
                stiffness.solve(&mut change);
                held.iter().zip(change).for_each(|(&i, x)| y[n + i] += x);
            }
        }
        Ok(y)
    }

    /// Newton's iteration for the places of coordinates that springs alone hold.
    fn solve_positions(
        &self,
        held: &[usize],
        regime: &Regime,
        t: f64,
        y: &mut [f64],
    ) -> Result<(), Error> {
        if held.is_empty() {
            return Ok(());
        }
        let n = self.coordinate_count();
        let forces = |y: &[f64]| -> Vec<f64> {
            let g = self.applied_forces(Some(regime), t, y);
            held.iter().map(|&i| g[i]).collect()
        };
        let size = |g: &[f64]| g.iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let mut now = forces(y);
        let mut last = f64::INFINITY;
        for _ in 0..MAX_NEWTON {
            let stiffness =
                self.assemble_rows(held, |at| self.element_force(at, Some(regime), t, y, 0.0).1);
            let lu = Lu::new(&stiffness).map_err(|_| self.undetermined_error(t))?;
            let mut change = now.clone();
            lu.solve(&mut change);
            let reach = y[..n].iter().fold(0.0f64, |m, x| m.max(x.abs()));
            last = size(&change) / reach.max(f64::MIN_POSITIVE);
            let from = y.to_vec();
            let nearer = (0..MAX_HALVINGS).any(|halving| {
                let share = f64::from(halving).exp2().recip();
                held.iter()
                    .zip(&change)
                    .for_each(|(&i, x)| y[i] = from[i] + share * x);
                let then = forces(y);
                let nearer = size(&then) < size(&now);
                if nearer {
                    now = then;
                }
                nearer
            });
            if !nearer {
                y.copy_from_slice(&from);
            }
            if !nearer || last <= ROUNDING {
                break;
            }
        }
        match last <= CONVERGED || size(&now) == 0.0 {
            true => Ok(()),
            false => Err(self.undetermined_error(t)),
        }
    }

    /// The regime at a state and the state that is consistent with it.
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
            let anew = self.regime(t, &y);
            if anew == regime {
                break;
            }
            regime = anew;
        }
        Ok((regime, y))
    }

    fn undetermined_error(&self, t: f64) -> Error {
        let light = (0..self.coordinate_count()).filter(|&i| self.is_massless(i));
        let names: Vec<&str> = light.map(|i| &self.coordinates[i][..]).collect();
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

/// Whether a sum of squares is regular.
fn regular(a: &Matrix, coordinates: &[usize]) -> Result<(), usize> {
    let Some(&first) = coordinates.first() else {
        return Ok(());
    };
    let floats = (0..coordinates.len()).find(|&i| a[(i, i)] <= 0.0);
    if let Some(at) = floats {
        return Err(coordinates[at]);
    }
    // In units of its own diagonal, so that soft next to stiff is no matter.
    let unit = |i: usize| a[(i, i)].sqrt().recip();
    let scaled = Matrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] * unit(i) * unit(j));
    let least = symmetric::symmetric_eigen(&scaled)
        .map(|found| found.values.into_iter().fold(f64::INFINITY, f64::min));
    match least.is_ok_and(|x| x > ROUNDING_TOLERANCE) {
        true => Ok(()),
        false => Err(first),
    }
}
