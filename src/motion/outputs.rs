//! Requested outputs: angles, speeds, accelerations, deflections and forces of a state.

use std::cell::OnceCell;

use super::combination::LinearCombination;
use super::dynamic_model::{DynamicModel, Regime};
use super::prescribed::PrescribedReduction;
use super::problem::OdeProblem;
use super::signal::Signal;

/// Output quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OutputQuantity {
    /// Position: value of a combination, by its index in [`MotionOutputs::rows`].
    Position(usize),
    /// Speed: rate of a row.
    Speed(usize),
    /// Acceleration: second time derivative of a row.
    Acceleration(usize),
    /// Deflection δ of an element.
    Deflection(usize),
    /// Force or torque F of an element.
    Force(usize),
    /// Weighted sum `Σ a F` over elements, by its index in [`MotionOutputs::sums`].
    Forces(usize),
    /// Torque −F that a motor element applies to the machine.
    MotorTorque(usize),
    /// Dry-friction power loss, W, of the elements from the first index on, by their number, in the model with its prescribed coordinates.
    FrictionPower(usize, usize),
    /// Force `k δ + c δ̇` of a condensed spring and damper.
    Spring {
        /// Row of the deflection δ.
        row: usize,
        /// Stiffness k, N·m/rad or N/m.
        stiffness: f64,
        /// Damping c, N·m·s/rad or N·s/m.
        damping: f64,
    },
    /// Torque that enforces a prescribed motion, by its index.
    PrescribedTorque(usize),
    /// Load on a degree of freedom, by its index in [`MotionOutputs::loads`].
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

/// Requested outputs of a model with the combinations that they refer to.
#[derive(Debug, Clone, Default)]
pub struct MotionOutputs {
    /// Named outputs, in the order requested.
    pub list: Vec<MotionOutput>,
    /// Combinations of coordinates and imposed motions, each for one degree of freedom or deflection.
    pub rows: Vec<LinearCombination>,
    /// Weighted sums of element forces: pairs of element index and weight.
    pub sums: Vec<Vec<(usize, f64)>>,
    /// Prescribed motions, if their torque or the friction power is requested.
    pub prescribed: Option<PrescribedReduction>,
    /// Loads on degrees of freedom: a signal over time, and the elements of loads over an angle.
    pub loads: Vec<(Signal, Vec<usize>)>,
}

impl MotionOutputs {
    /// Values of all outputs at time `t`, s, and state `y`; without a regime the state determines it.
    pub fn evaluate(
        &self,
        model: &DynamicModel,
        regime: Option<&Regime>,
        t: f64,
        y: &[f64],
    ) -> Vec<f64> {
        let n = model.coordinate_count();
        let cell = OnceCell::new();
        let current_regime =
            || -> &Regime { cell.get_or_init(|| model.output_regime(regime, t, y)) };
        let derivative = self
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
                OutputQuantity::Acceleration(row) => match &derivative {
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
                    .map(|&(branch, weight)| weight * force(model, current_regime(), branch, t, y))
                    .sum(),
                OutputQuantity::MotorTorque(branch) => {
                    -force(model, current_regime(), branch, t, y)
                }
                OutputQuantity::FrictionPower(first, count) => {
                    let range = first..first + count;
                    let power = |model: &DynamicModel, regime: &Regime, y: &[f64]| {
                        range.map(|at| model.friction_power(regime, t, y, at)).sum()
                    };
                    match &self.prescribed {
                        Some(prescribed) => {
                            let state = prescribed.state(t, y);
                            power(
                                &prescribed.full_model,
                                &prescribed.regime(current_regime(), t, &state),
                                &state,
                            )
                        }
                        None => power(model, current_regime(), y),
                    }
                }
                OutputQuantity::Load(at) => {
                    let (signal, over_angle) = &self.loads[at];
                    let torques = over_angle
                        .iter()
                        .map(|&b| force(model, current_regime(), b, t, y));
                    signal.value(t, signal.piece(t)) - torques.sum::<f64>()
                }
                OutputQuantity::PrescribedTorque(at) => {
                    let prescribed = self.prescribed.as_ref();
                    prescribed.map_or(0.0, |prescribed| {
                        prescribed.torques(model, current_regime(), t, y)[at]
                    })
                }
            })
            .collect()
    }
}

/// Force or torque F of an element.
fn force(model: &DynamicModel, regime: &Regime, branch: usize, t: f64, y: &[f64]) -> f64 {
    let offset: usize = model.elements[..branch]
        .iter()
        .map(|b| b.internal_count())
        .sum();
    let z = y
        .get(2 * model.coordinate_count() + offset)
        .copied()
        .unwrap_or(0.0);
    match model.elements[branch].law.is_dry_friction() {
        true => model.friction_force(regime, t, y, branch),
        false => model.element_force(branch, Some(regime), t, y, z).0,
    }
}
