//! What of a state is wanted: angles, speeds, accelerations, deflections and forces.

use std::cell::OnceCell;

use super::combination::Combination;
use super::prescribed::Prescribed;
use super::problem::Problem;
use super::signal::Signal;
use super::train::{Regime, Train};

/// One wanted quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    /// `Σ a F` of branches, by its number in [`Outputs::sums`].
    Forces(usize),
    /// −F of a branch: what a motor gives the machine.
    Given(usize),
    /// What dry friction of branches loses, W: from this one on, so many of them; of the machine with its prescribed coordinates.
    Loss(usize, usize),
    /// `k δ + c δ̇` of a row δ: what a spring carries that became part of others.
    Spring {
        /// δ.
        row: usize,
        /// k.
        stiffness: f64,
        /// c.
        damping: f64,
    },
    /// The torque that keeps up a prescribed motion, by its number.
    Drive(usize),
    /// What loads exert on a freedom, by its number in [`Outputs::loads`].
    Load(usize),
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
    /// Sums of the forces of branches.
    pub sums: Vec<Vec<(usize, f64)>>,
    /// What moves as prescribed, where its torque is wanted.
    pub prescribed: Option<Prescribed>,
    /// Loads on freedoms: over time, and branches of the motion where they follow an angle.
    pub loads: Vec<(Signal, Vec<usize>)>,
}

impl Outputs {
    /// Every output at a state, in its regime where there is one.
    pub fn at(&self, train: &Train, regime: Option<&Regime>, t: f64, y: &[f64]) -> Vec<f64> {
        let n = train.n();
        let found = OnceCell::new();
        let stands = || -> &Regime { found.get_or_init(|| train.stands(regime, t, y)) };
        let slope = self
            .list
            .iter()
            .any(|o| matches!(o.quantity, Quantity::Acceleration(_)))
            .then(|| {
                let mut dy = vec![0.0; train.len()];
                train.slope_in(Some(stands()), t, y, &mut dy);
                dy
            });
        self.list
            .iter()
            .map(|output| match output.quantity {
                Quantity::Position(row) => self.rows[row].value(t, &y[..n]),
                Quantity::Speed(row) => self.rows[row].rate(t, &y[n..2 * n]),
                Quantity::Acceleration(row) => match &slope {
                    Some(dy) => self.rows[row].bend(t, &dy[n..2 * n]),
                    None => 0.0,
                },
                Quantity::Spring {
                    row,
                    stiffness,
                    damping,
                } => {
                    let row = &self.rows[row];
                    stiffness * row.value(t, &y[..n]) + damping * row.rate(t, &y[n..2 * n])
                }
                Quantity::Deflection(branch) => {
                    let b = &train.branches[branch];
                    let piece = b.imposed.as_ref().map_or(0, |e| e.piece(t) as u32);
                    b.deflection(t, &y[..n], &y[n..2 * n], piece).0
                }
                Quantity::Force(branch) => force(train, stands(), branch, t, y),
                Quantity::Forces(sum) => (self.sums[sum].iter())
                    .map(|&(branch, share)| share * force(train, stands(), branch, t, y))
                    .sum(),
                Quantity::Given(branch) => -force(train, stands(), branch, t, y),
                Quantity::Loss(first, count) => {
                    let all = first..first + count;
                    let lost = |train: &Train, regime: &Regime, y: &[f64]| {
                        all.map(|at| train.rubbed_away(regime, t, y, at)).sum()
                    };
                    match &self.prescribed {
                        Some(known) => {
                            let state = known.state(t, y);
                            lost(&known.whole, &known.regime(stands(), t, &state), &state)
                        }
                        None => lost(train, stands(), y),
                    }
                }
                Quantity::Load(at) => {
                    let (signal, followed) = &self.loads[at];
                    let given = followed.iter().map(|&b| force(train, stands(), b, t, y));
                    signal.value(t, signal.piece(t)) - given.sum::<f64>()
                }
                Quantity::Drive(at) => {
                    let known = self.prescribed.as_ref();
                    known.map_or(0.0, |known| known.torques(train, stands(), t, y)[at])
                }
            })
            .collect()
    }
}

/// F of a branch.
fn force(train: &Train, regime: &Regime, branch: usize, t: f64, y: &[f64]) -> f64 {
    let before: usize = train.branches[..branch].iter().map(|b| b.inner()).sum();
    let z = y.get(2 * train.n() + before).copied().unwrap_or(0.0);
    match train.branches[branch].law.is_dry() {
        true => train.held(regime, t, y, branch),
        false => train.force(branch, Some(regime), t, y, z).0,
    }
}
