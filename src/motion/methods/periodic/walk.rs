//! A walk from switch to switch over the tables: each leg is one set of polynomials, certified up to its end.

use std::rc::Rc;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::units::instant;
use crate::motion::bracket::{Border, first_root, value_and_slope};
use crate::motion::contact::Affine;
use crate::motion::problem::Effort;
use crate::motion::train::{BranchStand, Regime, Train};
use crate::numeric::in_place;

use super::grid::Instant;
use super::table::Limit;
use super::tables::{Cell, Tables};

/// Rounding of a border's value, relative to the terms it is summed from.
const NOISE: f64 = 16.0 * f64::EPSILON;

/// Switches at one instant, per contact, beyond which they are taken to go on for ever.
const MOST_AT_ONCE: usize = 64;

/// A machine on its way.
pub struct Walk<'a> {
    /// Its tables.
    pub tables: Tables<'a>,
    /// What it cost.
    pub effort: Effort,
    /// How everything stands; pieces of waves are left at zero.
    pub regime: Regime,
    loading: usize,
    periods: u64,
    piece: usize,
    place: f64,
    state: Vec<f64>,
    cell: Rc<Cell>,
    /// Borders just crossed, as seen from here.
    crossed: Vec<(usize, [Affine; 2])>,
    /// The next instant at which a line takes over from another, s and counted.
    knot: (f64, Instant),
    constants: Vec<f64>,
    scratch: Vec<f64>,
    there: Vec<f64>,
    polynomials: Vec<f64>,
    combined: bool,
}

/// A leg: to a place of the piece, and the border crossed there.
#[derive(Debug, Clone, Copy)]
pub struct Leg {
    /// Its end.
    pub to: f64,
    /// What ends it.
    pub limit: Option<Limit>,
    /// The rate of that border's value there, 1/s; zero where the border was already behind at the start, by a jump in time.
    pub rate: f64,
}

impl<'a> Walk<'a> {
    /// A machine at `from`, s, in a state.
    ///
    /// # Errors
    /// Machines the method does not take.
    pub fn new(train: &'a Train, from: f64, start: &[f64]) -> Result<Walk<'a>, Error> {
        let mut tables = Tables::new(train, from)?;
        let regime = without_wave_pieces(train.regime(from, start));
        let loading = tables.loading(&regime);
        let cell = tables.cell(loading, &regime, 0)?;
        let state = start
            .iter()
            .zip(&tables.scale.units)
            .map(|(y, unit)| y / unit);
        let n = start.len();
        let mut walk = Walk {
            state: state.collect(),
            effort: Effort::default(),
            regime,
            loading,
            periods: 0,
            piece: 0,
            place: -1.0,
            cell,
            crossed: Vec::new(),
            knot: (from, tables.grid.instant(0.0)),
            constants: vec![0.0; n],
            scratch: Vec::new(),
            there: Vec::new(),
            polynomials: Vec::new(),
            combined: false,
            tables,
        };
        walk.next_knot();
        Ok(walk)
    }

    /// Where it is on the present piece.
    pub fn place(&self) -> f64 {
        self.place
    }

    /// Where an instant lies on the present piece.
    pub fn place_of(&self, instant: Instant) -> f64 {
        self.tables.grid.place(instant, self.periods, self.piece)
    }

    /// Seconds since the start at a place of the present piece.
    pub fn elapsed(&self, place: f64) -> f64 {
        let piece = self.tables.grid.pieces[self.piece];
        self.tables.grid.elapsed(self.periods) + (piece.middle + piece.half * place)
    }

    /// The next leg: up to `end`, a switch, a knot or the end of the piece.
    pub fn leg(&mut self, end: Instant) -> Leg {
        let last = self.place_of(end).min(self.place_of(self.knot.1)).min(1.0);
        let mut leg = Leg {
            to: last.max(self.place),
            limit: None,
            rate: 0.0,
        };
        self.solve();
        self.combined = false;
        self.effort.steps += 1;
        let free = Rc::clone(&self.cell.free);
        let length = free.solutions.length.max(self.cell.forced.length);
        for (border, limit) in free.limits.iter().enumerate() {
            let fresh = self.crossed.contains(&(limit.branch, limit.value));
            let [middle, reach, size] = self.reach(border);
            // It cannot be reached on this piece, whatever its polynomial.
            if !fresh && middle > reach {
                continue;
            }
            self.border(border, length);
            let noise = NOISE * size;
            let candidate = Border {
                coefficients: &self.scratch,
                noise,
                fresh,
            };
            if let Some(root) = first_root(candidate, [self.place, leg.to], &mut self.effort) {
                let (_, slope) = value_and_slope(&self.scratch, root);
                let half = self.tables.grid.pieces[self.piece].half;
                let smooth = f64::from(root > self.place);
                leg = Leg {
                    to: root,
                    limit: Some(*limit),
                    rate: smooth * slope / half,
                };
            }
        }
        leg
    }

    /// Goes to the end of a leg, and beyond it into the next stand, lines or piece.
    ///
    /// # Errors
    /// Tables too large; contacts that switch for ever at one instant.
    pub fn pass(&mut self, leg: Leg) -> Result<(), Error> {
        let mut state = std::mem::take(&mut self.state);
        self.state_at(leg.to, &mut state);
        self.state = state;
        if leg.to > self.place {
            self.crossed.clear();
        }
        self.place = leg.to;
        if let Some(limit) = leg.limit {
            self.crossed.push((limit.branch, limit.reversed()));
            if self.crossed.len() > MOST_AT_ONCE * self.cell.free.limits.len() {
                return Err(self.endless());
            }
            self.regime.stands[limit.branch] = BranchStand::Contact(limit.next, 0);
            self.loading = self.tables.loading(&self.regime);
            self.effort.events += 1;
        } else if self.place_of(self.knot.1) <= self.place {
            self.regime.pieces = self.lines();
            self.loading = self.tables.loading(&self.regime);
            self.next_knot();
        } else if leg.to >= 1.0 {
            self.place = -1.0;
            self.piece += 1;
            if self.piece == self.tables.grid.pieces.len() {
                self.piece = 0;
                self.periods += 1;
            }
        } else {
            return Ok(());
        }
        self.cell = self.tables.cell(self.loading, &self.regime, self.piece)?;
        Ok(())
    }

    /// How everything stands, with the pieces of the waves.
    pub fn whole_regime(&self) -> Regime {
        let middle = self.tables.from + self.tables.grid.pieces[self.piece].middle;
        let mut regime = self.regime.clone();
        for (b, stand) in self.tables.train.branches.iter().zip(&mut regime.stands) {
            if let (Some(wave), BranchStand::Contact(_, piece)) = (&b.variation, stand) {
                *piece = wave.shape.piece(wave.phase.at(middle, &[])) as u32;
            }
        }
        regime
    }

    /// The state at a place of the present leg, in the machine's units.
    pub fn value(&mut self, place: f64, y: &mut [f64]) {
        self.state_at(place, y);
        y.iter_mut()
            .zip(&self.tables.scale.units)
            .for_each(|(y, unit)| *y *= unit);
    }

    /// How solutions of the free machine that lie `[state][column]` in `columns`, in units, get from the present place to another.
    pub fn carry(&self, columns: &mut [f64], to: f64) {
        let (n, speed) = (self.state.len(), self.tables.speed(self.piece));
        let solutions = &self.cell.free.solutions;
        let start = solutions.states(self.place, self.tables.train.n(), speed);
        let end = solutions.states(to, self.tables.train.n(), speed);
        let count = columns.len() / n;
        let (mut column, mut carried) = (vec![0.0; n], vec![0.0; n]);
        for j in 0..count {
            (0..n).for_each(|i| column[i] = columns[i * count + j]);
            in_place::solve(&mut start.clone(), &mut column);
            in_place::times(&end, &column, &mut carried);
            (0..n).for_each(|i| columns[i * count + j] = carried[i]);
        }
    }

    /// The constants of the combination that passes through the present state.
    fn solve(&mut self) {
        let rising = self.tables.grid.elapsed(self.periods);
        let (n, speed) = (self.state.len(), self.tables.speed(self.piece));
        let cell = Rc::clone(&self.cell);
        let at_start = self.place == -1.0;
        let coordinates = self.tables.train.n();
        let mut there = std::mem::take(&mut self.there);
        let forced = match at_start {
            true => &cell.start,
            false => {
                cell.forced
                    .states_into(self.place, coordinates, speed, &mut there);
                &there
            }
        };
        self.scratch.clear();
        self.scratch.extend(
            (0..n).map(|i| self.state[i] - forced_value(forced, cell.forced.columns, i, rising)),
        );
        if at_start {
            in_place::times(&cell.free.from_start, &self.scratch, &mut self.constants);
        } else {
            let solutions = &cell.free.solutions;
            solutions.states_into(self.place, coordinates, speed, &mut there);
            self.constants.copy_from_slice(&self.scratch);
            in_place::solve(&mut there, &mut self.constants);
            self.effort.factorisations += 1;
        }
        self.there = there;
    }

    /// Of a border: its middle, how far it gets from that on the piece at most, and the size of what the middle is summed from.
    fn reach(&self, border: usize) -> [f64; 3] {
        let rising = [1.0, self.tables.grid.elapsed(self.periods)];
        let own = self.cell.free.solutions.reach(border, &self.constants);
        let forced = self.cell.forced.reach(border, &rising);
        std::array::from_fn(|at| own[at] + forced[at])
    }

    /// The polynomial of a border, into the scratch.
    fn border(&mut self, border: usize, length: usize) {
        let rising = [1.0, self.tables.grid.elapsed(self.periods)];
        self.scratch.clear();
        self.scratch.resize(length, 0.0);
        let Cell { free, forced, .. } = &*self.cell;
        let free = &free.solutions;
        free.add_border(border, &self.constants, &mut self.scratch);
        forced.add_border(border, &rising, &mut self.scratch);
    }

    /// The state at a place, in units.
    fn state_at(&mut self, place: f64, state: &mut [f64]) {
        let cell = Rc::clone(&self.cell);
        if place == 1.0 {
            let rising = self.tables.grid.elapsed(self.periods);
            in_place::times(&cell.free.to_end, &self.constants, state);
            for (i, x) in state.iter_mut().enumerate() {
                *x += forced_value(&cell.end, cell.forced.columns, i, rising);
            }
            return;
        }
        if !self.combined {
            self.combine(&cell);
        }
        let n = self.tables.train.n();
        let (rows, speed) = (cell.forced.rows, self.tables.speed(self.piece));
        let length = self.polynomials.len() / rows;
        for (row, series) in self.polynomials.chunks_exact(length).enumerate() {
            let (value, slope) = value_and_slope(series, place);
            if row < n {
                state[row] = value;
                state[n + row] = slope * speed;
            } else {
                state[n + row] = value;
            }
        }
    }

    /// The polynomials of all rows, `[row][term]`.
    fn combine(&mut self, cell: &Cell) {
        let rising = [1.0, self.tables.grid.elapsed(self.periods)];
        let (free, forced) = (&cell.free.solutions, &cell.forced);
        let length = free.length.max(forced.length);
        self.polynomials.clear();
        self.polynomials.resize(free.rows * length, 0.0);
        for (row, series) in self.polynomials.chunks_exact_mut(length).enumerate() {
            free.add_row(row, &self.constants, series);
            forced.add_row(row, &rising, series);
        }
        self.combined = true;
    }

    /// Which lines carry all loads at the knot.
    fn lines(&self) -> Vec<u32> {
        let train = self.tables.train;
        let at = self.knot.0;
        let drives = train.drives.iter().map(|d| d.signal.piece(at) as u32);
        let imposed = train
            .branches
            .iter()
            .map(|b| b.imposed.as_ref().map_or(0, |e| e.piece(at) as u32));
        drives.chain(imposed).collect()
    }

    fn next_knot(&mut self) {
        let train = self.tables.train;
        let drives = train.drives.iter().map(|d| &d.signal);
        let imposed = train.branches.iter().filter_map(|b| b.imposed.as_ref());
        let next = drives
            .chain(imposed)
            .map(|signal| signal.next_knot(self.knot.0))
            .fold(f64::INFINITY, f64::min);
        let instant = match next.is_finite() {
            true => self.tables.grid.instant(next - self.tables.from),
            false => Instant {
                periods: u64::MAX,
                within: 0.0,
            },
        };
        self.knot = (next, instant);
    }

    fn endless(&self) -> Error {
        let at = self.tables.from + self.elapsed(self.place);
        let names = &self.tables.train.branches;
        let (branch, _) = self.crossed[self.crossed.len() - 1];
        let message = format!(
            "the contact {} opens and closes without end at t = {}",
            names[branch].name,
            instant(at)
        );
        Error::new(Code::NoConvergence, message)
            .hint("give the contact damping, or another convention of losses")
    }
}

/// A row of a table of forced solutions: the first, and what has risen since.
fn forced_value(table: &[f64], columns: usize, row: usize, rising: f64) -> f64 {
    let steady = table[row * columns];
    match columns {
        1 => steady,
        _ => steady + rising * table[row * columns + 1],
    }
}

/// A regime by its stands and lines alone: waves have the piece of the period for theirs.
pub fn without_wave_pieces(mut regime: Regime) -> Regime {
    for stand in &mut regime.stands {
        if let BranchStand::Contact(_, piece) = stand {
            *piece = 0;
        }
    }
    regime
}
