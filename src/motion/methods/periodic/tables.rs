//! Every table of a machine, made when first asked for and kept: one for each piece of the period and each way the contacts stand.

use std::collections::HashMap;
use std::rc::Rc;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::units::seconds;
use crate::motion::series::{Held, Sources, add_harmonic, add_wave};
use crate::motion::signal::{Knot, Signal};
use crate::motion::train::{BranchStand, Regime, Train};

use super::free::{Free, KNOWN_TERMS, held, period};
use super::grid::{Grid, Piece};
use super::scale::Scale;
use super::table::Solutions;

/// All tables together may hold this much, bytes.
const MOST_BYTES: usize = 1 << 28;

/// Terms a series of the motion has, about, for an estimate of size.
const USUAL_TERMS: usize = 22;

/// A machine's tables.
pub struct Tables<'a> {
    /// The machine.
    pub train: &'a Train,
    /// The instant the period is counted from, s.
    pub from: f64,
    /// Its period.
    pub grid: Grid,
    /// Its units.
    pub scale: Scale,
    /// Ways the contacts stood.
    pub machines: usize,
    free: HashMap<(Vec<BranchStand>, usize), Rc<Free>>,
    numbers: Vec<Regime>,
    loaded: Vec<Vec<Option<Rc<Cell>>>>,
    bytes: usize,
}

/// What it does under its loads.
#[derive(Debug)]
pub struct Cell {
    /// Without them.
    pub free: Rc<Free>,
    /// The answer to loads as they are in the first period, then, where some rise steadily, what each second adds.
    pub forced: Solutions,
    /// The states of `forced` at the start of the piece, `[state][column]`.
    pub start: Vec<f64>,
    /// At its end.
    pub end: Vec<f64>,
}

impl<'a> Tables<'a> {
    /// Empty tables.
    ///
    /// # Errors
    /// Machines the method does not take; tables too large to make sense.
    pub fn new(train: &'a Train, from: f64) -> Result<Tables<'a>, Error> {
        let (scale, grid) = period(train, from)?;
        let n = scale.units.len();
        let estimate = grid.pieces.len() as f64 * ((n - train.n()) * n * USUAL_TERMS * 8) as f64;
        if estimate > MOST_BYTES as f64 {
            return Err(too_large(estimate, &grid));
        }
        Ok(Tables {
            train,
            from,
            grid,
            scale,
            machines: 0,
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
    pub fn loading(&mut self, regime: &Regime) -> usize {
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
    /// As [`Tables::new`].
    pub fn cell(
        &mut self,
        loading: usize,
        regime: &Regime,
        piece: usize,
    ) -> Result<Rc<Cell>, Error> {
        if let Some(cell) = &self.loaded[loading][piece] {
            return Ok(Rc::clone(cell));
        }
        let cell = Rc::new(self.build(regime, piece)?);
        self.loaded[loading][piece] = Some(Rc::clone(&cell));
        Ok(cell)
    }

    fn build(&mut self, regime: &Regime, piece: usize) -> Result<Cell, Error> {
        let held = self.held(&regime.stands, piece)?;
        let free = self.free(&held, &regime.stands, piece)?;
        let n = self.scale.units.len();
        let still = vec![0.0; n];
        let mut starts = vec![(still.clone(), self.sources(regime, piece))];
        starts.extend(self.rising(regime).map(|rising| (still, rising)));
        let forced = Solutions::new(&held, &self.scale, &free.limits, &starts)?;
        self.grow(&forced)?;
        let (coordinates, speed) = (self.train.n(), self.speed(piece));
        Ok(Cell {
            start: forced.states(-1.0, coordinates, speed),
            end: forced.states(1.0, coordinates, speed),
            free,
            forced,
        })
    }

    fn free(
        &mut self,
        held: &Held,
        stands: &[BranchStand],
        piece: usize,
    ) -> Result<Rc<Free>, Error> {
        let key = (stands.to_vec(), piece);
        if let Some(free) = self.free.get(&key) {
            return Ok(Rc::clone(free));
        }
        if !self.free.keys().any(|(known, _)| known == stands) {
            self.machines += 1;
        }
        let free = Rc::new(Free::new(held, &self.scale, stands)?);
        self.grow(&free.solutions)?;
        self.free.insert(key, Rc::clone(&free));
        Ok(free)
    }

    fn grow(&mut self, solutions: &Solutions) -> Result<(), Error> {
        self.bytes += 8 * (2 * solutions.terms.len() + solutions.borders.len());
        match self.bytes > MOST_BYTES {
            true => Err(too_large(self.bytes as f64, &self.grid)),
            false => Ok(()),
        }
    }

    /// The machine with its contacts held, over a piece.
    ///
    /// # Errors
    /// Branches that are not linear in their stand.
    pub fn held(&self, stands: &[BranchStand], piece: usize) -> Result<Held<'a>, Error> {
        held(self.train, self.from, stands, self.grid.pieces[piece])
    }

    /// What acts over a piece of the first period.
    fn sources(&self, regime: &Regime, piece: usize) -> Sources {
        let Piece { middle, half } = self.grid.pieces[piece];
        let at = self.from + middle;
        let series = |signal: Option<&Signal>, line: u32| {
            let mut series = vec![0.0; KNOWN_TERMS];
            if let Some(signal) = signal {
                if let Some(knot) = line_of(signal, line) {
                    series[0] = knot.line(self.from) + knot.slope * middle;
                    series[1] = knot.slope * half;
                }
                signal
                    .harmonics
                    .iter()
                    .for_each(|h| add_harmonic(&mut series, h, at, half));
            }
            series
        };
        let drives = self.train.drives.iter().zip(&regime.pieces);
        let lines = &regime.pieces[self.train.drives.len()..];
        let errors = self.train.branches.iter().zip(lines).map(|(b, &line)| {
            let mut error = series(b.imposed.as_ref(), line);
            for wave in &b.followed {
                add_wave(&mut error, wave, at, half);
            }
            error
        });
        Sources {
            drives: drives
                .map(|(d, &line)| series(Some(&d.signal), line))
                .collect(),
            errors: errors.collect(),
            steady: true,
        }
    }

    /// What a second adds to everything that acts; none where nothing rises.
    fn rising(&self, regime: &Regime) -> Option<Sources> {
        let slope = |signal: Option<&Signal>, line: u32| {
            vec![
                signal
                    .and_then(|s| line_of(s, line))
                    .map_or(0.0, |knot| knot.slope),
            ]
        };
        let drives = self.train.drives.iter().zip(&regime.pieces);
        let lines = &regime.pieces[self.train.drives.len()..];
        let errors = self.train.branches.iter().zip(lines);
        let sources = Sources {
            drives: drives
                .map(|(d, &line)| slope(Some(&d.signal), line))
                .collect(),
            errors: errors
                .map(|(b, &line)| slope(b.imposed.as_ref(), line))
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

fn too_large(bytes: f64, grid: &Grid) -> Error {
    let message = format!(
        "tables of {} pieces of the common period of {} would take {:.0} MB, more than {} MB",
        grid.pieces.len(),
        seconds(grid.period),
        bytes / 1e6,
        MOST_BYTES / 1_000_000
    );
    Error::new(Code::Hopeless, message)
        .hint("the fastest motion is far from the period; choose a method that steps through time")
}
