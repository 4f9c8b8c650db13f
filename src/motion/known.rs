//! Functions of time alone, from the file to signals.

use super::product::product;
use super::signal::Signal;
use crate::base::error::Error;
use crate::scene::laws::History;

/// A history as a signal; nothing for one that goes by angles.
///
/// # Errors
/// Tables whose times fall; products beyond what signals hold.
pub fn signal(history: &History) -> Result<Signal, Error> {
    Ok(match history {
        History::Constant(value) => Signal::constant(*value),
        History::Step { torque, time } => Signal::step(*torque, *time),
        History::Ramp { from, to, between } => Signal::ramp(*from, *to, *between),
        History::Harmonic {
            mean,
            amplitude,
            omega,
            phase,
        } => Signal::constant(*mean).plus(&Signal::harmonic(*amplitude, *omega, *phase)),
        History::Table(points) => Signal::table(points)?,
        History::Product { torque, factors } => {
            let mut made = Signal::constant(*torque);
            for factor in factors {
                made = product(&made, &signal(factor)?)?;
            }
            made
        }
        History::Orders { .. } | History::FaceMill(_) => Signal::default(),
    })
}
