//! Integration run from switch to switch with the cached series solutions.

use std::rc::Rc;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_instant;
use crate::motion::contact::Affine;
use crate::motion::dynamic_model::{DynamicModel, ElementState, Regime};
use crate::motion::first_root::{BoundedPolynomial, first_root, value_and_slope};
use crate::motion::problem::IntegrationStats;
use crate::numeric::small_dense;

use super::grid::PeriodTime;
use super::series_solution::ContactEvent;
use super::solution_cache::{ForcedSolution, SolutionCache};

/// Rounding of a switching surface's value, relative to the terms it is summed from.
const NOISE: f64 = 16.0 * f64::EPSILON;

/// Switches at one instant, per contact, beyond which they are taken to go on for ever.
const MAX_SIMULTANEOUS: usize = 64;

/// A machine on its way.
pub struct PeriodicRun<'a> {
    /// Cache of solutions.
    pub cache: SolutionCache<'a>,
    /// Cost of the run.
    pub stats: IntegrationStats,
    /// Present regime; pieces of waves are left at zero.
    pub regime: Regime,
    loading: usize,
    periods: u64,
    piece: usize,
    place: f64,
    state: Vec<f64>,
    cell: Rc<ForcedSolution>,
    /// Switching surfaces just crossed, as seen from here.
    crossed: Vec<(usize, [Affine; 2])>,
    /// The next instant at which a line takes over from another, s and counted.
    knot: (f64, PeriodTime),
    constants: Vec<f64>,
    scratch: Vec<f64>,
    there: Vec<f64>,
    polynomials: Vec<f64>,
    combined: bool,
}

/// A leg: to a place of the piece, and the switching surface crossed there.
#[derive(Debug, Clone, Copy)]
pub struct RunSegment {
    /// End of the segment.
    pub to: f64,
    /// Event that ends the segment.
    pub limit: Option<ContactEvent>,
    /// The rate of that switching surface's value there, 1/s; zero where the switching surface was already behind at the start,
    /// by a jump in time.
    pub rate: f64,
}

impl<'a> PeriodicRun<'a> {
    /// A machine at `from`, s, in a state.
    ///
    /// # Errors
    /// Machines the method does not take.
    pub fn new(
        model: &'a DynamicModel,
        from: f64,
        start: &[f64],
    ) -> Result<PeriodicRun<'a>, Error> {
        let mut cache = SolutionCache::new(model, from)?;
        let regime = without_wave_pieces(model.regime(from, start));
        let loading = cache.regime_index(&regime);
        let cell = cache.forced_solution(loading, &regime, 0)?;
        let state = start
            .iter()
            .zip(&cache.scale.units)
            .map(|(y, unit)| y / unit);
        let n = start.len();
        let mut walk = PeriodicRun {
            state: state.collect(),
            stats: IntegrationStats::default(),
            regime,
            loading,
            periods: 0,
            piece: 0,
            place: -1.0,
            cell,
            crossed: Vec::new(),
            knot: (from, cache.grid.instant(0.0)),
            constants: vec![0.0; n],
            scratch: Vec::new(),
            there: Vec::new(),
            polynomials: Vec::new(),
            combined: false,
            cache,
        };
        walk.next_knot();
        Ok(walk)
    }

    /// Position on the present piece.
    pub fn position(&self) -> f64 {
        self.place
    }

    /// Position of an instant on the present piece.
    pub fn position_of(&self, instant: PeriodTime) -> f64 {
        self.cache
            .grid
            .position_in_piece(instant, self.periods, self.piece)
    }

    /// Seconds since the start at a place of the present piece.
    pub fn elapsed(&self, place: f64) -> f64 {
        let piece = self.cache.grid.pieces[self.piece];
        self.cache.grid.elapsed(self.periods) + (piece.middle + piece.half * place)
    }

    /// The next leg: up to `end`, a switch, a knot or the end of the piece.
    pub fn next_segment(&mut self, end: PeriodTime) -> RunSegment {
        let last = self
            .position_of(end)
            .min(self.position_of(self.knot.1))
            .min(1.0);
        let mut segment = RunSegment {
            to: last.max(self.place),
            limit: None,
            rate: 0.0,
        };
        self.solve();
        self.combined = false;
        self.stats.steps += 1;
        let free = Rc::clone(&self.cell.free);
        let length = free.solutions.length.max(self.cell.forced.length);
        for (event, limit) in free.contact_events.iter().enumerate() {
            let fresh = self.crossed.contains(&(limit.branch, limit.value));
            let [middle, reach, size] = self.reach(event);
            // It cannot be reached on this piece, whatever its polynomial.
            if !fresh && middle > reach {
                continue;
            }
            self.event(event, length);
            let noise = NOISE * size;
            let candidate = BoundedPolynomial {
                coefficients: &self.scratch,
                noise,
                starts_at_root: fresh,
            };
            if let Some(root) = first_root(candidate, [self.place, segment.to], &mut self.stats) {
                let (_, slope) = value_and_slope(&self.scratch, root);
                let half = self.cache.grid.pieces[self.piece].half;
                let smooth = f64::from(root > self.place);
                segment = RunSegment {
                    to: root,
                    limit: Some(*limit),
                    rate: smooth * slope / half,
                };
            }
        }
        segment
    }

    /// Advances to the end of a segment, and beyond it into the next contact state, lines or piece.
    ///
    /// # Errors
    /// Tables too large; contacts that switch for ever at one instant.
    pub fn advance(&mut self, segment: RunSegment) -> Result<(), Error> {
        let mut state = std::mem::take(&mut self.state);
        self.state_at(segment.to, &mut state);
        self.state = state;
        if segment.to > self.place {
            self.crossed.clear();
        }
        self.place = segment.to;
        if let Some(limit) = segment.limit {
            self.crossed.push((limit.branch, limit.reversed()));
            if self.crossed.len() > MAX_SIMULTANEOUS * self.cell.free.contact_events.len() {
                return Err(self.chattering_error());
            }
            self.regime.states[limit.branch] = ElementState::Contact(limit.next, 0);
            self.loading = self.cache.regime_index(&self.regime);
            self.stats.events += 1;
        } else if self.position_of(self.knot.1) <= self.place {
            self.regime.pieces = self.lines();
            self.loading = self.cache.regime_index(&self.regime);
            self.next_knot();
        } else if segment.to >= 1.0 {
            self.place = -1.0;
            self.piece += 1;
            if self.piece == self.cache.grid.pieces.len() {
                self.piece = 0;
                self.periods += 1;
            }
        } else {
            return Ok(());
        }
        self.cell = self
            .cache
            .forced_solution(self.loading, &self.regime, self.piece)?;
        Ok(())
    }

    /// Present regime with the pieces of the waves.
    pub fn whole_regime(&self) -> Regime {
        let middle = self.cache.from + self.cache.grid.pieces[self.piece].middle;
        let mut regime = self.regime.clone();
        for (b, stand) in self.cache.model.elements.iter().zip(&mut regime.states) {
            if let (Some(wave), ElementState::Contact(_, piece)) = (&b.stiffness_wave, stand) {
                *piece = wave.waveform.piece(wave.phase.phase_at(middle, &[])) as u32;
            }
        }
        regime
    }

    /// The state at a place of the present leg, in the machine's units.
    pub fn value(&mut self, place: f64, y: &mut [f64]) {
        self.state_at(place, y);
        y.iter_mut()
            .zip(&self.cache.scale.units)
            .for_each(|(y, unit)| *y *= unit);
    }

    /// Propagates solutions of the free machine that lie `[state][column]` in `columns`, in units, from the present place to another.
    pub fn propagate(&self, columns: &mut [f64], to: f64) {
        let (n, speed) = (self.state.len(), self.cache.speed(self.piece));
        let solutions = &self.cell.free.solutions;
        let start = solutions.states(self.place, self.cache.model.coordinate_count(), speed);
        let end = solutions.states(to, self.cache.model.coordinate_count(), speed);
        let count = columns.len() / n;
        let (mut column, mut carried) = (vec![0.0; n], vec![0.0; n]);
        for j in 0..count {
            (0..n).for_each(|i| column[i] = columns[i * count + j]);
            small_dense::solve(&mut start.clone(), &mut column);
            small_dense::mul_vec(&end, &column, &mut carried);
            (0..n).for_each(|i| columns[i * count + j] = carried[i]);
        }
    }

    /// The constants of the combination that passes through the present state.
    fn solve(&mut self) {
        let rising = self.cache.grid.elapsed(self.periods);
        let (n, speed) = (self.state.len(), self.cache.speed(self.piece));
        let cell = Rc::clone(&self.cell);
        let at_start = self.place == -1.0;
        let coordinates = self.cache.model.coordinate_count();
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
            small_dense::mul_vec(&cell.free.from_start, &self.scratch, &mut self.constants);
        } else {
            let solutions = &cell.free.solutions;
            solutions.states_into(self.place, coordinates, speed, &mut there);
            self.constants.copy_from_slice(&self.scratch);
            small_dense::solve(&mut there, &mut self.constants);
            self.stats.factorisations += 1;
        }
        self.there = there;
    }

    /// Range of a switching function: its middle, its largest deviation from that on the piece, and the size of the terms that the middle
    /// is summed from.
    fn reach(&self, event: usize) -> [f64; 3] {
        let rising = [1.0, self.cache.grid.elapsed(self.periods)];
        let own = self.cell.free.solutions.value_range(event, &self.constants);
        let forced = self.cell.forced.value_range(event, &rising);
        std::array::from_fn(|at| own[at] + forced[at])
    }

    /// The polynomial of a switching surface, into the scratch.
    fn event(&mut self, event: usize, length: usize) {
        let rising = [1.0, self.cache.grid.elapsed(self.periods)];
        self.scratch.clear();
        self.scratch.resize(length, 0.0);
        let ForcedSolution { free, forced, .. } = &*self.cell;
        let free = &free.solutions;
        free.add_event(event, &self.constants, &mut self.scratch);
        forced.add_event(event, &rising, &mut self.scratch);
    }

    /// The state at a place, in units.
    fn state_at(&mut self, place: f64, state: &mut [f64]) {
        let cell = Rc::clone(&self.cell);
        if place == 1.0 {
            let rising = self.cache.grid.elapsed(self.periods);
            small_dense::mul_vec(&cell.free.to_end, &self.constants, state);
            for (i, x) in state.iter_mut().enumerate() {
                *x += forced_value(&cell.end, cell.forced.columns, i, rising);
            }
            return;
        }
        if !self.combined {
            self.combine(&cell);
        }
        let n = self.cache.model.coordinate_count();
        let (rows, speed) = (cell.forced.rows, self.cache.speed(self.piece));
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
    fn combine(&mut self, cell: &ForcedSolution) {
        let rising = [1.0, self.cache.grid.elapsed(self.periods)];
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
        let model = self.cache.model;
        let at = self.knot.0;
        let drives = model.forces.iter().map(|d| d.signal.piece(at) as u32);
        let imposed = model.elements.iter().map(|b| {
            b.imposed_displacement
                .as_ref()
                .map_or(0, |e| e.piece(at) as u32)
        });
        drives.chain(imposed).collect()
    }

    fn next_knot(&mut self) {
        let model = self.cache.model;
        let drives = model.forces.iter().map(|d| &d.signal);
        let imposed = model
            .elements
            .iter()
            .filter_map(|b| b.imposed_displacement.as_ref());
        let next = drives
            .chain(imposed)
            .map(|signal| signal.next_knot(self.knot.0))
            .fold(f64::INFINITY, f64::min);
        let instant = match next.is_finite() {
            true => self.cache.grid.instant(next - self.cache.from),
            false => PeriodTime {
                periods: u64::MAX,
                within: 0.0,
            },
        };
        self.knot = (next, instant);
    }

    fn chattering_error(&self) -> Error {
        let at = self.cache.from + self.elapsed(self.place);
        let names = &self.cache.model.elements;
        let (branch, _) = self.crossed[self.crossed.len() - 1];
        let message = format!(
            "the contact {} opens and closes without end at t = {}",
            names[branch].name,
            format_instant(at)
        );
        Error::new(Code::NoConvergence, message)
            .with_hint("give the contact damping, or another convention of losses")
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

/// Regime by its contact states and lines alone: waves have the piece of the period for theirs.
pub fn without_wave_pieces(mut regime: Regime) -> Regime {
    for stand in &mut regime.states {
        if let ElementState::Contact(_, piece) = stand {
            *piece = 0;
        }
    }
    regime
}
