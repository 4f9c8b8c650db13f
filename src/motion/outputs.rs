//! Requested outputs: angles, speeds, accelerations, deflections and forces of a state.

use std::cell::OnceCell;

use super::combination::LinearCombination;
use super::dynamic_model::{DynamicModel, Regime};
use super::prescribed::PrescribedReduction;
use super::problem::OdeProblem;
use super::signal::Signal;

/// One wanted quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OutputQuantity {
    /// A direction of the coordinates, by its number in [`MotionOutputs::rows`].
    Position(usize),
    /// Rate of a row.
    Speed(usize),
    /// Second rate of a row.
    Acceleration(usize),
    /// δ of a branch.
    Deflection(usize),
    /// F of a branch.
    Force(usize),
    /// `Σ a F` of branches, by its number in [`MotionOutputs::sums`].
    Forces(usize),
    /// −F of a branch: what a motor gives the machine.
    MotorTorque(usize),
    /// Power lost by dry friction of branches, W: first branch, and number of branches; of the machine with its prescribed coordinates.
    FrictionPower(usize, usize),
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
    PrescribedTorque(usize),
    /// Load on a degree of freedom, by its number in [`MotionOutputs::loads`].
    Load(usize),
}

/// A named output.
#[derive(Debug, Clone)]
pub struct MotionOutput {
    /// Name as requested.
    pub name: String,
    /// Quantity of the output.
    pub quantity: OutputQuantity,
    /// Unit of the output: rad, rad/s, rad/s², N·m and so on.
    pub unit: &'static str,
}

/// Outputs of a machine, with the rows that give degrees of freedom in the independent coordinates.
#[derive(Debug, Clone, Default)]
pub struct MotionOutputs {
    /// Named outputs, in the order requested.
    pub list: Vec<MotionOutput>,
    /// Combinations of coordinates, each a constant, a rate in time and terms: what rigid joints and imposed motions make of a
    /// degree of freedom.
    pub rows: Vec<LinearCombination>,
    /// Sums of the forces of branches.
    pub sums: Vec<Vec<(usize, f64)>>,
    /// Prescribed motions, where their torque is requested.
    pub prescribed: Option<PrescribedReduction>,
    /// Loads on degrees of freedom: over time, and branches of the motion where they follow an angle.
    pub loads: Vec<(Signal, Vec<usize>)>,
}

impl MotionOutputs {
    /// Every output at a state, in its regime where there is one.
    pub fn evaluate(
        &self,
        model: &DynamicModel,
        regime: Option<&Regime>,
        t: f64,
        y: &[f64],
    ) -> Vec<f64> {
        let n = model.coordinate_count();
        let found = OnceCell::new();
        let current_regime =
            || -> &Regime { found.get_or_init(|| model.output_regime(regime, t, y)) };
        let slope = self
            .list
            .iter()
            .any(|o| matches!(o.quantity, OutputQuantity::Acceleration(_)))
            .then(|| {
                let mut dy = vec![0.0; model.len()];
                model.derivative_in(Some(current_regime()), t, y, &mut dy);
                dy
            });
        self.list
            .iter()
            .map(|output| match output.quantity {
                OutputQuantity::Position(row) => self.rows[row].value(t, &y[..n]),
                OutputQuantity::Speed(row) => self.rows[row].rate(t, &y[n..2 * n]),
                OutputQuantity::Acceleration(row) => match &slope {
                    Some(dy) => self.rows[row].second_rate(t, &dy[n..2 * n]),
                    None => 0.0,
                },
                OutputQuantity::Spring {
                    row,
                    stiffness,
                    damping,
                } => {
                    let row = &self.rows[row];
                    stiffness * row.value(t, &y[..n]) + damping * row.rate(t, &y[n..2 * n])
                }
                OutputQuantity::Deflection(branch) => {
                    let b = &model.elements[branch];
                    let piece = b.pieces_at(t);
                    b.deflection(t, &y[..n], &y[n..2 * n], piece).0
                }
                OutputQuantity::Force(branch) => force(model, current_regime(), branch, t, y),
                OutputQuantity::Forces(sum) => (self.sums[sum].iter())
                    .map(|&(branch, share)| share * force(model, current_regime(), branch, t, y))
                    .sum(),
                OutputQuantity::MotorTorque(branch) => {
                    -force(model, current_regime(), branch, t, y)
                }
                OutputQuantity::FrictionPower(first, count) => {
                    let all = first..first + count;
                    let lost = |model: &DynamicModel, regime: &Regime, y: &[f64]| {
                        all.map(|at| model.friction_power(regime, t, y, at)).sum()
                    };
                    match &self.prescribed {
                        Some(known) => {
                            let state = known.state(t, y);
                            lost(
                                &known.whole,
                                &known.regime(current_regime(), t, &state),
                                &state,
                            )
                        }
                        None => lost(model, current_regime(), y),
                    }
                }
                OutputQuantity::Load(at) => {
                    let (signal, followed) = &self.loads[at];
                    let given = followed
                        .iter()
                        .map(|&b| force(model, current_regime(), b, t, y));
                    signal.value(t, signal.piece(t)) - given.sum::<f64>()
                }
                OutputQuantity::PrescribedTorque(at) => {
                    let known = self.prescribed.as_ref();
                    known.map_or(0.0, |known| {
                        known.torques(model, current_regime(), t, y)[at]
                    })
                }
            })
            .collect()
    }
}

/// F of a branch.
fn force(model: &DynamicModel, regime: &Regime, branch: usize, t: f64, y: &[f64]) -> f64 {
    let before: usize = model.elements[..branch]
        .iter()
        .map(|b| b.internal_count())
        .sum();
    let z = y
        .get(2 * model.coordinate_count() + before)
        .copied()
        .unwrap_or(0.0);
    match model.elements[branch].law.is_dry() {
        true => model.friction_force(regime, t, y, branch),
        false => model.element_force(branch, Some(regime), t, y, z).0,
    }
}
