//! Cache of series solutions, one for each piece of the period and set of contact states.

use std::collections::HashMap;
use std::rc::Rc;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_time;
use crate::motion::dynamic_model::{DynamicModel, ElementState, Regime};
use crate::motion::signal::{Knot, Signal};
use crate::motion::taylor::{ForcingSeries, TimeVaryingModel, add_harmonic, add_wave};

use super::fundamental::{FORCING_TERMS, FundamentalSolutions, freeze_states, period_grid};
use super::grid::{PeriodGrid, PeriodPiece};
use super::scale::StateUnits;
use super::series_solution::SeriesSolutions;

/// All tables together may hold this much, bytes.
const MAX_BYTES: usize = 1 << 28;

/// Terms a series of the motion has, about, for an estimate of size.
const TYPICAL_TERMS: usize = 22;

/// A machine's tables.
pub struct SolutionCache<'a> {
    /// The machine.
    pub model: &'a DynamicModel,
    /// The instant the period is counted from, s.
    pub from: f64,
    /// Period grid of the machine.
    pub grid: PeriodGrid,
    /// State units of the machine.
    pub scale: StateUnits,
    /// Ways the contacts stood.
    pub regimes: usize,
    free: HashMap<(Vec<ElementState>, usize), Rc<FundamentalSolutions>>,
    numbers: Vec<Regime>,
    loaded: Vec<Vec<Option<Rc<ForcedSolution>>>>,
    bytes: usize,
}

/// Solution of the machine under its loads.
#[derive(Debug)]
pub struct ForcedSolution {
    /// Without them.
    pub free: Rc<FundamentalSolutions>,
    /// Response to the loads of the first period, then, where some rise steadily, the increment per second.
    pub forced: SeriesSolutions,
    /// The states of `forced` at the start of the piece, `[state][column]`.
    pub start: Vec<f64>,
    /// At its end.
    pub end: Vec<f64>,
}

impl<'a> SolutionCache<'a> {
    /// Empty tables.
    ///
    /// # Errors
    /// Machines the method does not take; tables too large to make sense.
    pub fn new(model: &'a DynamicModel, from: f64) -> Result<SolutionCache<'a>, Error> {
        let (scale, grid) = period_grid(model, from)?;
        let n = scale.units.len();
        let estimate = grid.pieces.len() as f64
            * ((n - model.coordinate_count()) * n * TYPICAL_TERMS * 8) as f64;
        if estimate > MAX_BYTES as f64 {
            return Err(too_large(estimate, &grid));
        }
        Ok(SolutionCache {
            model,
            from,
            grid,
            scale,
            regimes: 0,
            free: HashMap::new(),
            numbers: Vec::new(),
            loaded: Vec::new(),
            bytes: 0,
        })
    }

    /// `d/dσ` of a piece to a speed in units.
    pub fn speed(&self, piece: usize) -> f64 {
        1.0 / (self.grid.pieces[piece].half * self.scale.rate)
    }

    /// The number a regime goes by.
    pub fn regime_index(&mut self, regime: &Regime) -> usize {
        if let Some(number) = self.numbers.iter().position(|known| known == regime) {
            return number;
        }
        self.loaded.push(vec![None; self.grid.pieces.len()]);
        self.numbers.push(regime.clone());
        self.numbers.len() - 1
    }

    /// The table of a regime, and its number, on a piece.
    ///
    /// # Errors
    /// As [`SolutionCache::new`].
    pub fn forced_solution(
        &mut self,
        loading: usize,
        regime: &Regime,
        piece: usize,
    ) -> Result<Rc<ForcedSolution>, Error> {
        if let Some(cell) = &self.loaded[loading][piece] {
            return Ok(Rc::clone(cell));
        }
        let cell = Rc::new(self.build(regime, piece)?);
        self.loaded[loading][piece] = Some(Rc::clone(&cell));
        Ok(cell)
    }

    fn build(&mut self, regime: &Regime, piece: usize) -> Result<ForcedSolution, Error> {
        let model = self.frozen_model(&regime.states, piece)?;
        let free = self.free(&model, &regime.states, piece)?;
        let n = self.scale.units.len();
        let still = vec![0.0; n];
        let mut starts = vec![(still.clone(), self.sources(regime, piece))];
        starts.extend(self.ramp_sources(regime).map(|rising| (still, rising)));
        let forced = SeriesSolutions::new(&model, &self.scale, &free.contact_events, &starts)?;
        self.reserve_memory(&forced)?;
        let (coordinates, speed) = (self.model.coordinate_count(), self.speed(piece));
        Ok(ForcedSolution {
            start: forced.states(-1.0, coordinates, speed),
            end: forced.states(1.0, coordinates, speed),
            free,
            forced,
        })
    }

    fn free(
        &mut self,
        model: &TimeVaryingModel,
        states: &[ElementState],
        piece: usize,
    ) -> Result<Rc<FundamentalSolutions>, Error> {
        let key = (states.to_vec(), piece);
        if let Some(free) = self.free.get(&key) {
            return Ok(Rc::clone(free));
        }
        if !self.free.keys().any(|(known, _)| known == states) {
            self.regimes += 1;
        }
        let free = Rc::new(FundamentalSolutions::new(model, &self.scale, states)?);
        self.reserve_memory(&free.solutions)?;
        self.free.insert(key, Rc::clone(&free));
        Ok(free)
    }

    fn reserve_memory(&mut self, solutions: &SeriesSolutions) -> Result<(), Error> {
        self.bytes += 8 * (2 * solutions.terms.len() + solutions.events.len());
        match self.bytes > MAX_BYTES {
            true => Err(too_large(self.bytes as f64, &self.grid)),
            false => Ok(()),
        }
    }

    /// The machine with its contacts held, over a piece.
    ///
    /// # Errors
    /// Branches that are not linear in their stand.
    pub fn frozen_model(
        &self,
        states: &[ElementState],
        piece: usize,
    ) -> Result<TimeVaryingModel<'a>, Error> {
        freeze_states(self.model, self.from, states, self.grid.pieces[piece])
    }

    /// Forcing over a piece of the first period.
    fn sources(&self, regime: &Regime, piece: usize) -> ForcingSeries {
        let PeriodPiece { middle, half } = self.grid.pieces[piece];
        let at = self.from + middle;
        let series = |signal: Option<&Signal>, line: u32| {
            let mut series = vec![0.0; FORCING_TERMS];
            if let Some(signal) = signal {
                if let Some(knot) = line_of(signal, line) {
                    series[0] = knot.value_at(self.from) + knot.slope * middle;
                    series[1] = knot.slope * half;
                }
                signal
                    .harmonics
                    .iter()
                    .for_each(|h| add_harmonic(&mut series, h, at, half));
            }
            series
        };
        let drives = self.model.forces.iter().zip(&regime.pieces);
        let lines = &regime.pieces[self.model.forces.len()..];
        let errors = self.model.elements.iter().zip(lines).map(|(b, &line)| {
            let mut error = series(b.imposed_displacement.as_ref(), line);
            for wave in &b.angle_waves {
                add_wave(&mut error, wave, at, half);
            }
            error
        });
        ForcingSeries {
            drives: drives
                .map(|(d, &line)| series(Some(&d.signal), line))
                .collect(),
            errors: errors.collect(),
            steady: true,
        }
    }

    /// Increment of the forcing per second; none where nothing rises.
    fn ramp_sources(&self, regime: &Regime) -> Option<ForcingSeries> {
        let slope = |signal: Option<&Signal>, line: u32| {
            vec![
                signal
                    .and_then(|s| line_of(s, line))
                    .map_or(0.0, |knot| knot.slope),
            ]
        };
        let drives = self.model.forces.iter().zip(&regime.pieces);
        let lines = &regime.pieces[self.model.forces.len()..];
        let errors = self.model.elements.iter().zip(lines);
        let sources = ForcingSeries {
            drives: drives
                .map(|(d, &line)| slope(Some(&d.signal), line))
                .collect(),
            errors: errors
                .map(|(b, &line)| slope(b.imposed_displacement.as_ref(), line))
                .collect(),
            steady: false,
        };
        let all = sources.drives.iter().chain(&sources.errors);
        all.flatten().any(|&slope| slope != 0.0).then_some(sources)
    }
}

fn line_of(signal: &Signal, line: u32) -> Option<Knot> {
    (line as usize).checked_sub(1).map(|at| signal.knots[at])
}

fn too_large(bytes: f64, grid: &PeriodGrid) -> Error {
    let message = format!(
        "tables of {} pieces of the common period of {} would take {:.0} MB, more than {} MB",
        grid.pieces.len(),
        format_time(grid.period),
        bytes / 1e6,
        MAX_BYTES / 1_000_000
    );
    Error::new(Code::BudgetExceeded, message).with_hint(
        "the fastest oscillation is far shorter than the period; choose a time-stepping method",
    )
}
