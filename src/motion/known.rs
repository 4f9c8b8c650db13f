//! Functions of time alone, from the file to signals.

use super::product::product;
use super::signal::Signal;
use crate::base::error::Error;
use crate::scene::laws::LoadHistory;

/// A history as a signal; nothing for one that goes by angles.
///
/// # Errors
/// Tables whose times fall; products beyond what signals hold.
pub fn signal(history: &LoadHistory) -> Result<Signal, Error> {
    Ok(match history {
        LoadHistory::Constant(value) => Signal::constant(*value),
        LoadHistory::Step { torque, time } => Signal::step(*torque, *time),
        LoadHistory::Ramp { from, to, between } => Signal::ramp(*from, *to, *between),
        LoadHistory::Harmonic {
            mean,
            amplitude,
            omega,
            phase,
        } => Signal::constant(*mean).plus(&Signal::harmonic(*amplitude, *omega, *phase)),
        LoadHistory::Table(points) => Signal::table(points)?,
        LoadHistory::Product { torque, factors } => {
            let mut made = Signal::constant(*torque);
            for factor in factors {
                made = product(&made, &signal(factor)?)?;
            }
            made
        }
        LoadHistory::Orders { .. } | LoadHistory::FaceMill(_) => Signal::default(),
    })
}
