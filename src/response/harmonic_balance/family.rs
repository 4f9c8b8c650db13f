//! Model family over speed: waves, errors and harmonic loads keep order and amplitude.

use std::f64::consts::TAU;

use super::relative::RelativeModel;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::dynamic_model::{DynamicModel, ForceElement, ForceLaw};
use crate::motion::floquet::stability_chart::scale_speed;
use crate::motion::methods::periodic::grid::common_period;
use crate::motion::signal::Signal;
use crate::motion::wave::WavePhase;

/// One machine at every speed.
pub struct SpeedFamily {
    /// Against its free turning, at the speed it was given with.
    pub relative: RelativeModel,
    /// As it was given.
    pub model: DynamicModel,
    /// Base frequency of the excitation at that speed, rad/s.
    pub base: f64,
    /// The mean rate of every branch at that speed.
    pub rates: Vec<f64>,
    /// The highest order that excites anything.
    pub max_order: usize,
}

/// Difference of two mean speeds that counts as rounding, relative to the speeds.
pub const SPEED_TOLERANCE: f64 = 1e-9;

/// Excitation of higher orders of the common period is more than a harmonic balance can carry.
const MAX_ORDER: usize = 400;

impl SpeedFamily {
    /// Speed family of a machine whose waves follow time; `speeds` are the mean speeds of its coordinates.
    ///
    /// # Errors
    /// Loads that do not repeat, waves that follow an angle, contacts between parts that do not run at one speed; frequencies
    /// without a common period, or one too long.
    pub fn new(model: &DynamicModel, speeds: &[f64]) -> Result<SpeedFamily, Error> {
        let rate = |b: &ForceElement| {
            let imposed = b
                .imposed_displacement
                .as_ref()
                .and_then(|e| e.knots.last())
                .map_or(0.0, |k| k.slope);
            let parts = b.direction.entries().map(|(i, a)| a * speeds[i]);
            let size = parts.map(f64::abs).sum::<f64>() + imposed.abs();
            let rate = b.direction.dot(speeds) - imposed;
            if rate.abs() > SPEED_TOLERANCE * size {
                rate
            } else {
                0.0
            }
        };
        let rates: Vec<f64> = model.elements.iter().map(rate).collect();
        refuse(model, &rates)?;
        let (period, _) = common_period(model, f64::INFINITY)?;
        if period == 0.0 {
            let error = Error::new(
                Code::Conflict,
                "this machine has no periodic excitation by a load, error or stiffness",
            );
            return Err(error.with_hint("give a mesh `k_wave`, an [[error]], or a load with harmonics or orders; and a speed"));
        }
        let base = TAU / period;
        let highest = orders(model, base);
        if highest > MAX_ORDER {
            let message = format!(
                "the common period of all excitations is {highest} periods of the fastest: harmonic balance needs more orders than that"
            );
            return Err(Error::new(Code::BudgetExceeded, message)
                .with_hint("omit the slow excitations of this scene (orders of shafts), or integrate the equations in time"));
        }
        Ok(SpeedFamily {
            relative: RelativeModel::new(model)?,
            model: model.clone(),
            base,
            rates,
            max_order: highest,
        })
    }

    /// The machine against its free turning with everything repeating with `omega`, rad/s.
    pub fn relative_at(&self, omega: f64) -> DynamicModel {
        scale_speed(&self.relative.model, omega / self.base)
    }

    /// The machine as it was given with everything repeating with `omega`, rad/s.
    pub fn model_at(&self, omega: f64) -> DynamicModel {
        scale_speed(&self.model, omega / self.base)
    }

    /// Nothing turns against anything else, and nothing turns freely: an orbit comes back to its state.
    pub fn is_periodic(&self) -> bool {
        self.relative.free.is_empty() && self.rates.iter().all(|&rate| rate == 0.0)
    }
}

/// The highest order of any excitation.
fn orders(model: &DynamicModel, base: f64) -> usize {
    let waves = model
        .elements
        .iter()
        .filter_map(|b| match b.stiffness_wave.as_ref()?.phase {
            WavePhase::Imposed { omega, .. } => Some(omega.abs()),
            WavePhase::FollowsAngle { .. } => None,
        });
    let highest = waves.chain(model.harmonics()).fold(0.0, f64::max);
    (highest / base).round() as usize
}

fn refuse(model: &DynamicModel, rates: &[f64]) -> Result<(), Error> {
    let steady = |signal: &Signal| {
        signal
            .knots
            .iter()
            .all(|k| k.slope == 0.0 && k.time == f64::NEG_INFINITY)
    };
    let resting = |signal: &Signal| {
        signal
            .knots
            .iter()
            .all(|k| k.slope == 0.0 && k.value == 0.0)
    };
    if let Some(drive) = model
        .forces
        .iter()
        .find(|d| !steady(&d.signal) && !resting(&d.signal))
    {
        let message = format!("{} is not periodic", drive.name);
        return Err(Error::new(Code::Conflict, message)
            .with_hint("a steady state takes constant loads, harmonics and orders only"));
    }
    for (b, &rate) in model.elements.iter().zip(rates) {
        let followed = b
            .stiffness_wave
            .as_ref()
            .is_some_and(|w| w.phase.angle().is_some());
        if !b.angle_waves.is_empty() || followed {
            let message = format!("the wave of {} depends on an angle, not on time", b.name);
            return Err(Error::new(Code::Conflict, message)
                .with_hint("write mesh_phase = \"speed\" in [start]"));
        }
        let hint = match b.law {
            ForceLaw::Clutch { .. } => Some("simulate its engagement in time"),
            ForceLaw::LoadFriction(_) => {
                Some("simulate it in time, or omit load-dependent friction")
            }
            ForceLaw::AngleLocked { .. } => Some(
                "write mesh_phase = \"speed\" in [start], so that its orders refer to the mean speed",
            ),
            _ => None,
        };
        if let Some(hint) = hint {
            let message = match b.law {
                ForceLaw::LoadFriction(_) => {
                    format!("{} depends on load, which the balance excludes", b.name)
                }
                _ => format!("{} does not have the period of the excitation", b.name),
            };
            return Err(Error::new(Code::Conflict, message).with_hint(hint));
        }
        if rate != 0.0 && matches!(b.law, ForceLaw::Contact(_) | ForceLaw::Nonlinear { .. }) {
            let message = format!("the two sides of {} have different speeds", b.name);
            return Err(Error::new(Code::Conflict, message)
                .with_hint("state speeds in [speed] that fit the ratios of the gears"));
        }
    }
    Ok(())
}
