//! One machine at every speed: waves, errors and harmonic loads keep their orders, `k ω`, and their amplitudes.

use std::f64::consts::TAU;

use super::relative::Relative;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::floquet::chart::at_speed;
use crate::motion::methods::periodic::grid::common_period;
use crate::motion::signal::Signal;
use crate::motion::train::{Branch, Law, Train};
use crate::motion::wave::Phase;

/// One machine at every speed.
pub struct Family {
    /// Against its free turning, at the speed it was given with.
    pub relative: Relative,
    /// As it was given.
    pub whole: Train,
    /// What everything repeats with at that speed, rad/s.
    pub base: f64,
    /// The mean rate of every branch at that speed.
    pub rates: Vec<f64>,
    /// The highest order that excites anything.
    pub highest: usize,
}

/// A branch between parts that turn together sees the difference of their speeds only as rounding of this.
const TOGETHER: f64 = 1e-9;

/// Excitation of higher orders of the common period is more than a harmonic balance can carry.
const HIGHEST: usize = 400;

impl Family {
    /// Of a machine whose waves follow time; `speeds` are the mean speeds of its coordinates.
    ///
    /// # Errors
    /// Loads that do not repeat, waves that follow an angle, contacts between parts that do not run at one speed; frequencies
    /// without a common period, or one too long.
    pub fn new(train: &Train, speeds: &[f64]) -> Result<Family, Error> {
        let rate = |b: &Branch| {
            let imposed = b
                .imposed
                .as_ref()
                .and_then(|e| e.knots.last())
                .map_or(0.0, |k| k.slope);
            let parts = b.direction.scaled().map(|(i, a)| a * speeds[i]);
            let size = parts.map(f64::abs).sum::<f64>() + imposed.abs();
            let rate = b.direction.dot(speeds) - imposed;
            if rate.abs() > TOGETHER * size {
                rate
            } else {
                0.0
            }
        };
        let rates: Vec<f64> = train.branches.iter().map(rate).collect();
        refuse(train, &rates)?;
        let (period, _) = common_period(train, f64::INFINITY)?;
        if period == 0.0 {
            let error = Error::new(
                Code::Conflict,
                "nothing excites this machine: no load, error or stiffness repeats in time",
            );
            return Err(error.hint("give a mesh `k_wave`, an [[error]], or a load with harmonics or orders; and a speed"));
        }
        let base = TAU / period;
        let highest = orders(train, base);
        if highest > HIGHEST {
            let message = format!(
                "all excitations repeat together only after {highest} periods of the fastest: a balance of harmonics would need more orders than that"
            );
            return Err(Error::new(Code::Hopeless, message)
                .hint("leave the slow excitations (orders of shafts) out of this scene, or integrate in time"));
        }
        Ok(Family {
            relative: Relative::new(train)?,
            whole: train.clone(),
            base,
            rates,
            highest,
        })
    }

    /// The machine against its free turning with everything repeating with `omega`, rad/s.
    pub fn at(&self, omega: f64) -> Train {
        at_speed(&self.relative.train, omega / self.base)
    }

    /// The machine as it was given with everything repeating with `omega`, rad/s.
    pub fn whole_at(&self, omega: f64) -> Train {
        at_speed(&self.whole, omega / self.base)
    }

    /// Nothing turns against anything else, and nothing turns freely: an orbit comes back to its state.
    pub fn comes_back(&self) -> bool {
        self.relative.free.is_empty() && self.rates.iter().all(|&rate| rate == 0.0)
    }
}

/// The highest order of any excitation.
fn orders(train: &Train, base: f64) -> usize {
    let waves = train
        .branches
        .iter()
        .filter_map(|b| match b.variation.as_ref()?.phase {
            Phase::Imposed { omega, .. } => Some(omega.abs()),
            Phase::Followed { .. } => None,
        });
    let highest = waves.chain(train.harmonics()).fold(0.0, f64::max);
    (highest / base).round() as usize
}

fn refuse(train: &Train, rates: &[f64]) -> Result<(), Error> {
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
    if let Some(drive) = train
        .drives
        .iter()
        .find(|d| !steady(&d.signal) && !resting(&d.signal))
    {
        let message = format!("{} changes in time and does not repeat", drive.name);
        return Err(Error::new(Code::Conflict, message)
            .hint("a steady answer needs constant loads, harmonics and orders"));
    }
    for (b, &rate) in train.branches.iter().zip(rates) {
        let followed = b
            .variation
            .as_ref()
            .is_some_and(|w| w.phase.angle().is_some());
        if !b.followed.is_empty() || followed {
            let message = format!("the wave of {} follows an angle, not time", b.name);
            return Err(
                Error::new(Code::Conflict, message).hint("write mesh_phase = \"speed\" in [start]")
            );
        }
        let hint = match b.law {
            Law::Clutch { .. } => Some("take its engagement as a motion in time"),
            Law::Pressed(_) => {
                Some("take it as a motion in time, or leave friction that goes by load out")
            }
            Law::Orders { .. } => Some(
                "write mesh_phase = \"speed\" in [start], so that its orders turn at the mean speed",
            ),
            _ => None,
        };
        if let Some(hint) = hint {
            let message = match b.law {
                Law::Pressed(_) => {
                    format!("{} goes by load, which the balance does not follow", b.name)
                }
                _ => format!("{} does not repeat with the excitation", b.name),
            };
            return Err(Error::new(Code::Conflict, message).hint(hint));
        }
        if rate != 0.0 && matches!(b.law, Law::Contact(_) | Law::Nonlinear { .. }) {
            let message = format!("the two sides of {} do not run at one speed", b.name);
            return Err(Error::new(Code::Conflict, message)
                .hint("state speeds in [speed] that fit the ratios of the gears"));
        }
    }
    Ok(())
}
