//! What a machine does by itself over a piece of its period, its contacts held.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::series::{Held, HeldBranch, Sources, add_wave};
use crate::motion::train::{Branch, BranchStand, Train};

use super::foreign::foreign;
use super::grid::{Grid, Piece};
use super::scale::Scale;
use super::table::{Limit, Solutions, ends, limits};

/// Known functions are given this many terms, as many as a motion can have.
pub const KNOWN_TERMS: usize = 42;

/// Fundamental solutions over a piece, and the borders of the stands.
#[derive(Debug)]
pub struct Free {
    /// Fundamental solutions, each from one state at the middle.
    pub solutions: Solutions,
    /// Their states at the start of the piece, inverted, row by row.
    pub from_start: Vec<f64>,
    /// Their states at its end, row by row.
    pub to_end: Vec<f64>,
    /// The borders of its stands.
    pub limits: Vec<Limit>,
}

impl Free {
    /// Of a machine held in some stands.
    ///
    /// # Errors
    /// Series that do not come to an end.
    pub fn new(held: &Held, scale: &Scale, stands: &[BranchStand]) -> Result<Free, Error> {
        let limits = limits(held, stands);
        let n = scale.units.len();
        let unit = |j: usize| {
            let mut start = vec![0.0; n];
            start[j] = scale.units[j];
            (start, Sources::default())
        };
        let starts: Vec<_> = (0..n).map(unit).collect();
        let solutions = Solutions::new(held, scale, &limits, &starts)?;
        let speed = 1.0 / (held.half * scale.rate);
        let (from_start, to_end) = ends(&solutions, held.train.n(), speed);
        Ok(Free {
            solutions,
            from_start,
            to_end,
            limits,
        })
    }
}

/// The units of a machine and the pieces of its period, counted from an instant, s.
///
/// # Errors
/// Machines that are not linear between switches or do not repeat in time.
pub fn period(train: &Train, from: f64) -> Result<(Scale, Grid), Error> {
    if let Some(reason) = foreign(train) {
        return Err(Error::new(Code::Usage, reason)
            .hint("choose a method that steps through time, such as one asked by a tolerance"));
    }
    let scale = Scale::new(train)?;
    let grid = Grid::new(train, from, scale.fastest)?;
    Ok((scale, grid))
}

/// A machine with its contacts held, over a piece of the period that is counted from an instant, s.
///
/// # Errors
/// Branches that are not linear in their stand.
pub fn held<'a>(
    train: &'a Train,
    from: f64,
    stands: &[BranchStand],
    Piece { middle, half }: Piece,
) -> Result<Held<'a>, Error> {
    let middle = from + middle;
    let branch = |(b, stand): (&Branch, &BranchStand)| {
        let stand = match stand {
            BranchStand::Contact(stand, _) => Some(*stand),
            _ => None,
        };
        let held = HeldBranch::new(b, stand).ok_or_else(|| {
            let message = format!("branch {} is not linear between switches", b.name);
            Error::new(Code::Usage, message)
        })?;
        let mut factor = Vec::new();
        if let (Some(wave), Some(_)) = (&b.variation, stand) {
            factor = vec![0.0; KNOWN_TERMS];
            add_wave(&mut factor, wave, middle, half);
        }
        Ok(held.with_factor(factor))
    };
    let branches: Result<Vec<HeldBranch>, Error> =
        train.branches.iter().zip(stands).map(branch).collect();
    Ok(Held {
        train,
        branches: branches?,
        half,
    })
}
