//! Taylor series of motion and event functions, `x(σ) = Σ c_k σᵏ` with σ in [−1, 1], over one piece of the period.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::contact::{Affine, ContactState};
use crate::motion::dynamic_model::{ElementState, ForceLaw};
use crate::motion::taylor::{ForcingSeries, TimeVaryingModel};
use crate::numeric::small_dense;
use crate::numeric::vector_ops::gemv;

use super::scale::StateUnits;

/// Maximum number of Taylor terms; negligible terms are truncated.
const MAX_TERMS: usize = 40;

/// Relative size of a negligible term, in the scaled units of its state.
const NEGLIGIBLE: f64 = 1e-18;

/// Number of series evaluated simultaneously.
const LANES: usize = 4;

/// Fundamental solutions over a piece as Taylor series.
#[derive(Debug)]
pub struct SeriesSolutions {
    /// Number of solutions.
    pub columns: usize,
    /// Number of stored rows: coordinates and internal states.
    pub rows: usize,
    /// Taylor coefficients `[row][column][term]`.
    pub terms: Vec<f64>,
    /// Coefficients interleaved by [`LANES`] entries `[row][column]`, padded with zeros.
    interleaved: Vec<[f64; LANES]>,
    /// Taylor coefficients of every event function: `[event][column][term]`.
    pub events: Vec<f64>,
    /// First term of each event function and the sum of magnitudes of the other terms: `[event][column]`.
    ranges: Vec<[f64; 2]>,
    /// Number of terms of every series.
    pub length: usize,
}

/// Event function of a contact state of one branch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactEvent {
    /// Index of the branch.
    pub branch: usize,
    /// Value at stiffness factor zero, and its derivative by the factor.
    pub value: [Affine; 2],
    /// Contact state after the event.
    pub next: ContactState,
}

impl ContactEvent {
    /// Event function with reversed sign.
    pub fn reversed(&self) -> [Affine; 2] {
        self.value.map(|a| Affine {
            constant: -a.constant,
            deflection: -a.deflection,
            rate: -a.rate,
        })
    }
}

/// Event functions of a set of contact states.
pub fn contact_events(model: &TimeVaryingModel, states: &[ElementState]) -> Vec<ContactEvent> {
    let mut all = Vec::new();
    for (branch, (b, state)) in model.model.elements.iter().zip(states).enumerate() {
        let (ForceLaw::Contact(contact), ElementState::Contact(state, _)) = (&b.law, state) else {
            continue;
        };
        let f0 = contact.switching_functions(*state, 0.0);
        let f1 = contact.switching_functions(*state, 1.0);
        all.extend(
            f0.iter()
                .zip(&f1)
                .map(|(&(base, next), &(full, _))| ContactEvent {
                    branch,
                    value: [
                        base,
                        Affine {
                            constant: full.constant - base.constant,
                            deflection: full.deflection - base.deflection,
                            rate: full.rate - base.rate,
                        },
                    ],
                    next,
                }),
        );
    }
    all
}

impl SeriesSolutions {
    /// Series from states at the middle of the piece, each with its forcing.
    ///
    /// # Errors
    /// `NoConvergence` if the series do not converge.
    pub fn new(
        model: &TimeVaryingModel,
        scale: &StateUnits,
        limits: &[ContactEvent],
        starts: &[(Vec<f64>, ForcingSeries)],
    ) -> Result<SeriesSolutions, Error> {
        let motions: Vec<Vec<f64>> = starts
            .iter()
            .map(|(start, sources)| model.motion_series(start, sources, MAX_TERMS))
            .collect();
        let (n, columns) = (model.model.coordinate_count(), starts.len());
        let rows = scale.units.len() - n;
        let unit = |row: usize| match row < n {
            true => scale.units[row],
            false => scale.units[row + n],
        };
        let c = |k: usize, row: usize, column: usize| motions[column][k * rows + row] / unit(row);
        let size = |k: usize, column: usize| {
            (0..rows)
                .map(|row| c(k, row, column).abs())
                .fold(0.0, f64::max)
        };
        let length = (0..columns)
            .map(|column| significant_terms(|k| size(k, column) * (k.max(1) as f64)))
            .try_fold(2, |n, length| length.map(|length| n.max(length)))
            .ok_or_else(|| {
                let message = format!(
                    "the series of the motion over {} s do not converge in {MAX_TERMS} terms",
                    2.0 * model.half
                );
                Error::new(Code::NoConvergence, message)
                    .with_hint("choose a time-stepping method: give --tolerance")
            })?;
        let mut terms = Vec::with_capacity(length * rows * columns);
        for row in 0..rows {
            for column in 0..columns {
                terms.extend((0..length).map(|k| c(k, row, column)));
            }
        }
        let mut interleaved = vec![[0.0; LANES]; (rows * columns).div_ceil(LANES) * length];
        for (entry, series) in terms.chunks_exact(length).enumerate() {
            let slots = interleaved[entry / LANES * length..].iter_mut();
            slots
                .zip(series)
                .for_each(|(slot, a)| slot[entry % LANES] = *a);
        }
        let mut events = Vec::with_capacity(limits.len() * length * columns);
        for limit in limits {
            for ((_, sources), motion) in starts.iter().zip(&motions) {
                events.extend(event_series(model, limit, motion, sources, length));
            }
        }
        let range = |series: &[f64]| [series[0], series[1..].iter().map(|a| a.abs()).sum()];
        Ok(SeriesSolutions {
            columns,
            rows,
            terms,
            interleaved,
            ranges: events.chunks_exact(length).map(range).collect(),
            events,
            length,
        })
    }

    /// States of all columns at σ, `[state][column]`; `speed` is dσ/dt, 1/s.
    pub fn states(&self, sigma: f64, n: usize, speed: f64) -> Vec<f64> {
        let mut states = Vec::new();
        self.states_into(sigma, n, speed, &mut states);
        states
    }

    /// States of all columns at σ, written into a buffer.
    pub fn states_into(&self, sigma: f64, n: usize, speed: f64, states: &mut Vec<f64>) {
        let (entries, n_moving) = (self.rows * self.columns, n * self.columns);
        states.clear();
        states.resize(entries + n_moving, 0.0);
        for (block, terms) in self.interleaved.chunks_exact(self.length).enumerate() {
            let first = block * LANES;
            let (mut value, mut slope) = ([0.0; LANES], [0.0; LANES]);
            for term in terms.iter().rev() {
                for lane in 0..LANES {
                    slope[lane] = slope[lane] * sigma + value[lane];
                    value[lane] = value[lane] * sigma + term[lane];
                }
            }
            for (entry, lane) in (first..entries.min(first + LANES)).zip(0..) {
                if entry < n_moving {
                    states[entry] = value[lane];
                    states[entry + n_moving] = slope[lane] * speed;
                } else {
                    states[entry + n_moving] = value[lane];
                }
            }
        }
    }

    /// Range of a combination of the series of an event function: middle value, bound of the deviation on the piece, and magnitude of the
    /// terms of the middle value.
    pub fn value_range(&self, event: usize, weights: &[f64]) -> [f64; 3] {
        let ranges = &self.ranges[event * self.columns..(event + 1) * self.columns];
        let pairs = ranges.iter().zip(weights);
        pairs.fold([0.0; 3], |[middle, dev, size], ([a, spread], x)| {
            let term = a * x;
            [middle + term, dev + spread * x.abs(), size + term.abs()]
        })
    }

    /// Adds the weighted combination of the series of a row to `sum`.
    pub fn add_row(&self, row: usize, weights: &[f64], sum: &mut [f64]) {
        let size = self.columns * self.length;
        self.add(&self.terms[row * size..(row + 1) * size], weights, sum);
    }

    /// Adds the weighted combination of the series of an event function to `sum`.
    pub fn add_event(&self, event: usize, weights: &[f64], sum: &mut [f64]) {
        let size = self.columns * self.length;
        let all = &self.events[event * size..(event + 1) * size];
        self.add(all, weights, sum);
    }

    fn add(&self, all: &[f64], weights: &[f64], sum: &mut [f64]) {
        let weights = &weights[..self.columns];
        gemv(sum, weights, |j| {
            &all[j * self.length..(j + 1) * self.length]
        });
    }
}

/// Number of significant terms, followed by four negligible ones; none without convergence.
fn significant_terms(size: impl Fn(usize) -> f64) -> Option<usize> {
    let mut largest: f64 = 0.0;
    let mut negligible = 0;
    for k in 0..MAX_TERMS {
        let current = size(k);
        largest = largest.max(current);
        negligible = if current <= NEGLIGIBLE * largest {
            negligible + 1
        } else {
            0
        };
        // Load harmonics and waves can have zero terms alternately or at first: the first terms always count.
        if negligible >= 4 && k > 6 {
            return Some(k - 3);
        }
    }
    None
}

/// Taylor series of an event function along a motion.
fn event_series(
    model: &TimeVaryingModel,
    limit: &ContactEvent,
    motion: &[f64],
    sources: &ForcingSeries,
    length: usize,
) -> Vec<f64> {
    let n = model.model.coordinate_count();
    let rows = motion.len() / MAX_TERMS;
    let direction = &model.model.elements[limit.branch].direction;
    let delta =
        |k: usize| direction.dot(&motion[k * rows..k * rows + n]) - sources.error(limit.branch, k);
    let term = |a: Affine, k: usize| {
        let constant = if sources.steady && k == 0 {
            a.constant
        } else {
            0.0
        };
        let rate = match a.rate {
            0.0 => 0.0,
            rate => rate * (k + 1) as f64 / model.half * delta(k + 1),
        };
        constant + a.deflection * delta(k) + rate
    };
    let [base, with_factor] = limit.value;
    let branch = &model.branches[limit.branch];
    let modulated: Vec<f64> = (0..length).map(|k| term(with_factor, k)).collect();
    (0..length)
        .map(|k| term(base, k) + branch.times_stiffness(&modulated, k))
        .collect()
}

/// Inverse state matrix at the start of the piece, and state matrix at its end.
pub fn end_states(solutions: &SeriesSolutions, n: usize, speed: f64) -> (Vec<f64>, Vec<f64>) {
    let start = solutions.states(-1.0, n, speed);
    let end = solutions.states(1.0, n, speed);
    (small_dense::inverse(&start, n + solutions.rows), end)
}
