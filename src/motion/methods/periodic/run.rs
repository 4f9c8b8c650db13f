//! Integration run from switch to switch with cached series solutions.

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

/// Rounding error of an event function, relative to the sum of its absolute terms.
const NOISE: f64 = 16.0 * f64::EPSILON;

/// Maximum number of switches per contact at one instant; more are reported as chattering.
const MAX_SIMULTANEOUS: usize = 64;

/// Integration run of a model by periodic series solutions.
pub struct PeriodicRun<'a> {
    /// Cache of solutions.
    pub cache: SolutionCache<'a>,
    /// Cost of the run.
    pub stats: IntegrationStats,
    /// Present regime; the pieces of waves are zero.
    pub regime: Regime,
    regime_id: usize,
    periods: u64,
    piece: usize,
    x: f64,
    state: Vec<f64>,
    sol: Rc<ForcedSolution>,
    /// Event functions just crossed, with the sign of the present side.
    crossed: Vec<(usize, [Affine; 2])>,
    /// Next knot of a signal, s and in periods.
    knot: (f64, PeriodTime),
    constants: Vec<f64>,
    scratch: Vec<f64>,
    buffer: Vec<f64>,
    polynomials: Vec<f64>,
    combined: bool,
}

/// Segment of the run: its end on the present piece and the event that ends it.
#[derive(Debug, Clone, Copy)]
pub struct RunSegment {
    /// End of the segment on the piece, −1 to 1.
    pub to: f64,
    /// Event that ends the segment.
    pub limit: Option<ContactEvent>,
    /// Rate of that event function there, in its unit per second; zero if a jump in time had crossed it before the start of
    /// the segment.
    pub rate: f64,
}

impl<'a> PeriodicRun<'a> {
    /// Run of a model from the time `from`, s, and the state `start`.
    ///
    /// # Errors
    /// A model that the method does not support.
    pub fn new(
        model: &'a DynamicModel,
        from: f64,
        start: &[f64],
    ) -> Result<PeriodicRun<'a>, Error> {
        let mut cache = SolutionCache::new(model, from)?;
        let regime = without_wave_pieces(model.regime(from, start));
        let regime_id = cache.regime_index(&regime);
        let sol = cache.forced_solution(regime_id, &regime, 0)?;
        let state = start
            .iter()
            .zip(&cache.scale.units)
            .map(|(y, unit)| y / unit);
        let n = start.len();
        let mut run = PeriodicRun {
            state: state.collect(),
            stats: IntegrationStats::default(),
            regime,
            regime_id,
            periods: 0,
            piece: 0,
            x: -1.0,
            sol,
            crossed: Vec::new(),
            knot: (from, cache.grid.instant(0.0)),
            constants: vec![0.0; n],
            scratch: Vec::new(),
            buffer: Vec::new(),
            polynomials: Vec::new(),
            combined: false,
            cache,
        };
        run.next_knot();
        Ok(run)
    }

    /// Position on the present piece, −1 to 1.
    pub fn position(&self) -> f64 {
        self.x
    }

    /// Position of a time on the present piece, −1 to 1 within it.
    pub fn position_of(&self, instant: PeriodTime) -> f64 {
        self.cache
            .grid
            .position_in_piece(instant, self.periods, self.piece)
    }

    /// Time since the start of the run at a position on the present piece, s.
    pub fn elapsed(&self, x: f64) -> f64 {
        let piece = self.cache.grid.pieces[self.piece];
        self.cache.grid.elapsed(self.periods) + (piece.middle + piece.half * x)
    }

    /// Next segment, up to the first of `end`, a switch, a knot and the end of the piece.
    pub fn next_segment(&mut self, end: PeriodTime) -> RunSegment {
        let last = self
            .position_of(end)
            .min(self.position_of(self.knot.1))
            .min(1.0);
        let mut segment = RunSegment {
            to: last.max(self.x),
            limit: None,
            rate: 0.0,
        };
        self.solve();
        self.combined = false;
        self.stats.steps += 1;
        let free = Rc::clone(&self.sol.free);
        let length = free.solutions.length.max(self.sol.forced.length);
        for (event, limit) in free.contact_events.iter().enumerate() {
            let crossed = self.crossed.contains(&(limit.branch, limit.value));
            let [middle, deviation, size] = self.event_range(event);
            // The function has no root on this piece.
            if !crossed && middle > deviation {
                continue;
            }
            self.combine_event(event, length);
            let noise = NOISE * size;
            let candidate = BoundedPolynomial {
                coefficients: &self.scratch,
                noise,
                starts_at_root: crossed,
            };
            if let Some(root) = first_root(candidate, [self.x, segment.to], &mut self.stats) {
                let (_, slope) = value_and_slope(&self.scratch, root);
                let half = self.cache.grid.pieces[self.piece].half;
                let smooth = f64::from(root > self.x);
                segment = RunSegment {
                    to: root,
                    limit: Some(*limit),
                    rate: smooth * slope / half,
                };
            }
        }
        segment
    }

    /// Advances to the end of a segment and switches to the next contact state, signal pieces or piece of the period.
    ///
    /// # Errors
    /// Tables too large; contacts that chatter at one instant.
    pub fn advance(&mut self, segment: RunSegment) -> Result<(), Error> {
        let mut state = std::mem::take(&mut self.state);
        self.state_at(segment.to, &mut state);
        self.state = state;
        if segment.to > self.x {
            self.crossed.clear();
        }
        self.x = segment.to;
        if let Some(limit) = segment.limit {
            self.crossed.push((limit.branch, limit.reversed()));
            if self.crossed.len() > MAX_SIMULTANEOUS * self.sol.free.contact_events.len() {
                return Err(self.chattering_error());
            }
            self.regime.states[limit.branch] = ElementState::Contact(limit.next, 0);
            self.regime_id = self.cache.regime_index(&self.regime);
            self.stats.events += 1;
        } else if self.position_of(self.knot.1) <= self.x {
            self.regime.pieces = self.signal_pieces();
            self.regime_id = self.cache.regime_index(&self.regime);
            self.next_knot();
        } else if segment.to >= 1.0 {
            self.x = -1.0;
            self.piece += 1;
            if self.piece == self.cache.grid.pieces.len() {
                self.piece = 0;
                self.periods += 1;
            }
        } else {
            return Ok(());
        }
        self.sol = self
            .cache
            .forced_solution(self.regime_id, &self.regime, self.piece)?;
        Ok(())
    }

    /// Present regime with the pieces of the waves.
    pub fn full_regime(&self) -> Regime {
        let middle = self.cache.from + self.cache.grid.pieces[self.piece].middle;
        let mut regime = self.regime.clone();
        for (b, state) in self.cache.model.elements.iter().zip(&mut regime.states) {
            if let (Some(wave), ElementState::Contact(_, piece)) = (&b.stiffness_wave, state) {
                *piece = wave.waveform.piece(wave.phase.phase_at(middle, &[])) as u32;
            }
        }
        regime
    }

    /// State at a position of the present segment, in the units of the model.
    pub fn value(&mut self, x: f64, y: &mut [f64]) {
        self.state_at(x, y);
        y.iter_mut()
            .zip(&self.cache.scale.units)
            .for_each(|(y, unit)| *y *= unit);
    }

    /// Propagates homogeneous solutions, scaled, stored `[state][column]` in `columns`, from the present position to `to`.
    pub fn propagate(&self, columns: &mut [f64], to: f64) {
        let (n, speed) = (self.state.len(), self.cache.speed(self.piece));
        let solutions = &self.sol.free.solutions;
        let start = solutions.states(self.x, self.cache.model.coordinate_count(), speed);
        let end = solutions.states(to, self.cache.model.coordinate_count(), speed);
        let count = columns.len() / n;
        let (mut column, mut end_column) = (vec![0.0; n], vec![0.0; n]);
        for j in 0..count {
            (0..n).for_each(|i| column[i] = columns[i * count + j]);
            small_dense::solve(&mut start.clone(), &mut column);
            small_dense::mul_vec(&end, &column, &mut end_column);
            (0..n).for_each(|i| columns[i * count + j] = end_column[i]);
        }
    }

    /// Solves for the constants of the solution through the present state.
    fn solve(&mut self) {
        let elapsed = self.cache.grid.elapsed(self.periods);
        let (n, speed) = (self.state.len(), self.cache.speed(self.piece));
        let sol = Rc::clone(&self.sol);
        let at_start = self.x == -1.0;
        let coordinates = self.cache.model.coordinate_count();
        let mut buffer = std::mem::take(&mut self.buffer);
        let forced = match at_start {
            true => &sol.start,
            false => {
                sol.forced
                    .states_into(self.x, coordinates, speed, &mut buffer);
                &buffer
            }
        };
        self.scratch.clear();
        self.scratch.extend(
            (0..n).map(|i| self.state[i] - forced_value(forced, sol.forced.columns, i, elapsed)),
        );
        if at_start {
            small_dense::mul_vec(&sol.free.from_start, &self.scratch, &mut self.constants);
        } else {
            let solutions = &sol.free.solutions;
            solutions.states_into(self.x, coordinates, speed, &mut buffer);
            self.constants.copy_from_slice(&self.scratch);
            small_dense::solve(&mut buffer, &mut self.constants);
            self.stats.factorisations += 1;
        }
        self.buffer = buffer;
    }

    /// Range of an event function on the piece: its value at the middle, its largest deviation from it, and the sum of the absolute
    /// terms of the middle value.
    fn event_range(&self, event: usize) -> [f64; 3] {
        let factors = [1.0, self.cache.grid.elapsed(self.periods)];
        let free = self.sol.free.solutions.value_range(event, &self.constants);
        let forced = self.sol.forced.value_range(event, &factors);
        std::array::from_fn(|k| free[k] + forced[k])
    }

    /// Writes the polynomial of an event function to the scratch.
    fn combine_event(&mut self, event: usize, length: usize) {
        let factors = [1.0, self.cache.grid.elapsed(self.periods)];
        self.scratch.clear();
        self.scratch.resize(length, 0.0);
        let ForcedSolution { free, forced, .. } = &*self.sol;
        let free = &free.solutions;
        free.add_event(event, &self.constants, &mut self.scratch);
        forced.add_event(event, &factors, &mut self.scratch);
    }

    /// Scaled state at a position of the piece.
    fn state_at(&mut self, x: f64, state: &mut [f64]) {
        let sol = Rc::clone(&self.sol);
        if x == 1.0 {
            let elapsed = self.cache.grid.elapsed(self.periods);
            small_dense::mul_vec(&sol.free.to_end, &self.constants, state);
            for (i, x) in state.iter_mut().enumerate() {
                *x += forced_value(&sol.end, sol.forced.columns, i, elapsed);
            }
            return;
        }
        if !self.combined {
            self.combine(&sol);
        }
        let n = self.cache.model.coordinate_count();
        let (rows, speed) = (sol.forced.rows, self.cache.speed(self.piece));
        let length = self.polynomials.len() / rows;
        for (row, series) in self.polynomials.chunks_exact(length).enumerate() {
            let (value, slope) = value_and_slope(series, x);
            if row < n {
                state[row] = value;
                state[n + row] = slope * speed;
            } else {
                state[n + row] = value;
            }
        }
    }

    /// Computes the polynomials of all rows, `[row][term]`.
    fn combine(&mut self, sol: &ForcedSolution) {
        let factors = [1.0, self.cache.grid.elapsed(self.periods)];
        let (free, forced) = (&sol.free.solutions, &sol.forced);
        let length = free.length.max(forced.length);
        self.polynomials.clear();
        self.polynomials.resize(free.rows * length, 0.0);
        for (row, series) in self.polynomials.chunks_exact_mut(length).enumerate() {
            free.add_row(row, &self.constants, series);
            forced.add_row(row, &factors, series);
        }
        self.combined = true;
    }

    /// Active pieces of all signals at the knot.
    fn signal_pieces(&self) -> Vec<u32> {
        let model = self.cache.model;
        let t = self.knot.0;
        let drives = model.forces.iter().map(|d| d.signal.piece(t) as u32);
        let imposed = model.elements.iter().map(|b| {
            b.imposed_displacement
                .as_ref()
                .map_or(0, |e| e.piece(t) as u32)
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
                remainder: 0.0,
            },
        };
        self.knot = (next, instant);
    }

    fn chattering_error(&self) -> Error {
        let t = self.cache.from + self.elapsed(self.x);
        let names = &self.cache.model.elements;
        let (branch, _) = self.crossed[self.crossed.len() - 1];
        let message = format!(
            "the contact {} chatters at t = {}",
            names[branch].name,
            format_instant(t)
        );
        Error::new(Code::NoConvergence, message)
            .with_hint("give the contact damping, or another `contact_damping`")
    }
}

/// Row of a table of forced solutions: the steady part plus the part linear in the elapsed time.
fn forced_value(table: &[f64], columns: usize, row: usize, elapsed: f64) -> f64 {
    let steady = table[row * columns];
    match columns {
        1 => steady,
        _ => steady + elapsed * table[row * columns + 1],
    }
}

/// Regime with the pieces of all waves set to zero; the piece of the period determines them.
pub fn without_wave_pieces(mut regime: Regime) -> Regime {
    for state in &mut regime.states {
        if let ElementState::Contact(_, piece) = state {
            *piece = 0;
        }
    }
    regime
}
