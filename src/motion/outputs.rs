//! What of a state is wanted: angles, speeds, accelerations, deflections and forces.

use super::prescribed::Prescribed;
use super::problem::Problem;
use super::train::{Law, Train};

/// One wanted quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// A direction of the coordinates, by its number in [`Outputs::rows`].
    Position(usize),
    /// Its rate.
    Speed(usize),
    /// Its second rate.
    Acceleration(usize),
    /// δ of a branch.
    Deflection(usize),
    /// F of a branch.
    Force(usize),
    /// −F of a branch: what a motor gives the machine.
    Given(usize),
    /// The torque that keeps up a prescribed motion, by its number.
    Drive(usize),
}

/// A named output.
#[derive(Debug, Clone)]
pub struct Output {
    /// As asked for.
    pub name: String,
    /// What it is.
    pub quantity: Quantity,
    /// Its unit: rad, rad/s, rad/s², N·m and so on.
    pub unit: &'static str,
}

/// Outputs of a machine, with the rows that give freedoms in the coordinates that stay.
#[derive(Debug, Clone, Default)]
pub struct Outputs {
    /// Named outputs, in the order asked.
    pub list: Vec<Output>,
    /// Combinations of coordinates, each a constant, a rate in time and terms: what rigid joints and imposed motions make of a freedom.
    pub rows: Vec<Combination>,
    /// What moves as prescribed, where its torque is wanted.
    pub prescribed: Option<Prescribed>,
}

/// A freedom in the coordinates that stay: `terms · q`, and what is imposed on it in time.
#[derive(Debug, Clone, Default)]
pub struct Combination {
    /// Coordinate and factor.
    pub terms: Vec<(usize, f64)>,
    /// Motion imposed in time.
    pub imposed: Option<super::signal::Signal>,
}

impl Combination {
    fn of(&self, x: &[f64]) -> f64 {
        self.terms.iter().map(|&(j, a)| a * x[j]).sum()
    }
}

impl Outputs {
    /// Every output at a state.
    pub fn at(&self, train: &Train, t: f64, y: &[f64]) -> Vec<f64> {
        let n = train.n();
        let slope = self
            .list
            .iter()
            .any(|o| matches!(o.quantity, Quantity::Acceleration(_)))
            .then(|| {
                let mut dy = vec![0.0; train.len()];
                let regime = train.regime(t, y);
                train.slope_in(Some(&regime), t, y, &mut dy);
                dy
            });
        self.list
            .iter()
            .map(|output| match output.quantity {
                Quantity::Position(row) => {
                    let row = &self.rows[row];
                    row.of(&y[..n]) + row.imposed.as_ref().map_or(0.0, |s| s.value(t, s.piece(t)))
                }
                Quantity::Speed(row) => {
                    let row = &self.rows[row];
                    row.of(&y[n..2 * n])
                        + row.imposed.as_ref().map_or(0.0, |s| s.slope(t, s.piece(t)))
                }
                Quantity::Acceleration(row) => {
                    let row = &self.rows[row];
                    let free = slope.as_ref().map_or(0.0, |dy| row.of(&dy[n..2 * n]));
                    free + row
                        .imposed
                        .as_ref()
                        .map_or(0.0, |s| s.curvature(t, s.piece(t)))
                }
                Quantity::Deflection(branch) => {
                    let b = &train.branches[branch];
                    let piece = b.imposed.as_ref().map_or(0, |e| e.piece(t) as u32);
                    b.deflection(t, &y[..n], &y[n..2 * n], piece).0
                }
                Quantity::Force(branch) => force(train, branch, t, y),
                Quantity::Given(branch) => -force(train, branch, t, y),
                Quantity::Drive(at) => {
                    let known = self.prescribed.as_ref();
                    known.map_or(0.0, |known| known.torques(train, t, y)[at])
                }
            })
            .collect()
    }
}

/// F of a branch.
fn force(train: &Train, branch: usize, t: f64, y: &[f64]) -> f64 {
    let before: usize = train.branches[..branch].iter().map(|b| b.inner()).sum();
    let z = y.get(2 * train.n() + before).copied().unwrap_or(0.0);
    let regime = train.regime(t, y);
    match train.branches[branch].law {
        Law::Friction(_) => train.held(&regime, t, y, branch),
        _ => train.force(branch, Some(&regime), t, y, z).0,
    }
}
