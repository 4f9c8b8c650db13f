//! Fundamental solutions of the homogeneous equations over one piece of the period.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::dynamic_model::{DynamicModel, ElementState, ForceElement};
use crate::motion::taylor::{ForcingSeries, TimeVaryingElement, TimeVaryingModel, add_wave};

use super::applicability::unsupported_reason;
use super::grid::{PeriodGrid, PeriodPiece};
use super::scale::StateUnits;
use super::series_solution::{ContactEvent, SeriesSolutions, contact_events, end_states};

/// Known functions are given this many terms, as many as a motion can have.
pub const FORCING_TERMS: usize = 42;

/// Fundamental solutions over a piece, and the switching surfaces of the contact states.
#[derive(Debug)]
pub struct FundamentalSolutions {
    /// Fundamental solutions, each from one state at the middle.
    pub solutions: SeriesSolutions,
    /// Their states at the start of the piece, inverted, row by row.
    pub from_start: Vec<f64>,
    /// Their states at its end, row by row.
    pub to_end: Vec<f64>,
    /// Switching surfaces of the contact states.
    pub contact_events: Vec<ContactEvent>,
}

impl FundamentalSolutions {
    /// Fundamental solutions of a machine with its contacts held in some states.
    ///
    /// # Errors
    /// Series that do not come to an end.
    pub fn new(
        model: &TimeVaryingModel,
        scale: &StateUnits,
        states: &[ElementState],
    ) -> Result<FundamentalSolutions, Error> {
        let limits = contact_events(model, states);
        let n = scale.units.len();
        let unit = |j: usize| {
            let mut start = vec![0.0; n];
            start[j] = scale.units[j];
            (start, ForcingSeries::default())
        };
        let starts: Vec<_> = (0..n).map(unit).collect();
        let solutions = SeriesSolutions::new(model, scale, &limits, &starts)?;
        let speed = 1.0 / (model.half * scale.rate);
        let (from_start, to_end) = end_states(&solutions, model.model.coordinate_count(), speed);
        Ok(FundamentalSolutions {
            solutions,
            from_start,
            to_end,
            contact_events: limits,
        })
    }
}

/// The units of a machine and the pieces of its period, counted from an instant, s.
///
/// # Errors
/// Machines that are not linear between switches or do not repeat in time.
pub fn period_grid(model: &DynamicModel, from: f64) -> Result<(StateUnits, PeriodGrid), Error> {
    if let Some(reason) = unsupported_reason(model) {
        return Err(Error::new(Code::Usage, reason)
            .with_hint("choose a time-stepping method: give --tolerance"));
    }
    let scale = StateUnits::new(model)?;
    let grid = PeriodGrid::new(model, from, scale.fastest)?;
    Ok((scale, grid))
}

/// A machine with its contacts held, over a piece of the period that is counted from an instant, s.
///
/// # Errors
/// Branches that are not linear in their stand.
pub fn freeze_states<'a>(
    model: &'a DynamicModel,
    from: f64,
    states: &[ElementState],
    PeriodPiece { middle, half }: PeriodPiece,
) -> Result<TimeVaryingModel<'a>, Error> {
    let middle = from + middle;
    let branch = |(b, state): (&ForceElement, &ElementState)| {
        let state = match state {
            ElementState::Contact(state, _) => Some(*state),
            _ => None,
        };
        let held = TimeVaryingElement::new(b, state).ok_or_else(|| {
            let message = format!("branch {} is not linear between switches", b.name);
            Error::new(Code::Usage, message)
        })?;
        let mut factor = Vec::new();
        if let (Some(wave), Some(_)) = (&b.stiffness_wave, state) {
            factor = vec![0.0; FORCING_TERMS];
            add_wave(&mut factor, wave, middle, half);
        }
        Ok(held.with_factor(factor))
    };
    let branches: Result<Vec<TimeVaryingElement>, Error> =
        model.elements.iter().zip(states).map(branch).collect();
    Ok(TimeVaryingModel {
        model,
        branches: branches?,
        half,
    })
}
