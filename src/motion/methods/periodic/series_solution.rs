//! Taylor series of motion and event functions over one piece of the period.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::contact::{Affine, ContactState};
use crate::motion::dynamic_model::{ElementState, ForceLaw};
use crate::motion::taylor::{ForcingSeries, TimeVaryingModel};
use crate::numeric::small_dense;
use crate::numeric::vector_ops::gemv;

use super::scale::StateUnits;

/// Terms computed; the ones that do not count are left out.
const MAX_TERMS: usize = 40;

/// A term of a series is left out where it changes a state, in its own units, by less than this share of its size.
const NEGLIGIBLE: f64 = 1e-18;

/// Entries evaluated at once.
const LANES: usize = 4;

/// Solutions over a piece.
#[derive(Debug)]
pub struct SeriesSolutions {
    /// Number of solutions.
    pub columns: usize,
    /// Rows of the state kept: coordinates and inner states.
    pub rows: usize,
    /// Coefficients, series after series: `[row][column][term]`.
    pub terms: Vec<f64>,
    /// The same with so many entries `[row][column]` next to each other, term after term; what is beyond the last entry is zero.
    interleaved: Vec<[f64; LANES]>,
    /// Coefficients of every switching function: `[event][column][term]`.
    pub events: Vec<f64>,
    /// First term of each of these, and the sum of the sizes of the others: `[event][column]`.
    ranges: Vec<[f64; 2]>,
    /// Terms of every series.
    pub length: usize,
}

/// A switching surface of one branch's contact state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactEvent {
    /// The branch.
    pub branch: usize,
    /// The value at factor zero, and what a factor of one adds.
    pub value: [Affine; 2],
    /// Contact state beyond the switching surface.
    pub next: ContactState,
}

impl ContactEvent {
    /// The same switching surface seen from beyond.
    pub fn reversed(&self) -> [Affine; 2] {
        self.value.map(|a| Affine {
            constant: -a.constant,
            deflection: -a.deflection,
            rate: -a.rate,
        })
    }
}

/// Every switching surface of a set of contact states.
pub fn contact_events(model: &TimeVaryingModel, states: &[ElementState]) -> Vec<ContactEvent> {
    let mut all = Vec::new();
    for (branch, (b, state)) in model.model.elements.iter().zip(states).enumerate() {
        let (ForceLaw::Contact(contact), ElementState::Contact(state, _)) = (&b.law, state) else {
            continue;
        };
        let zero = contact.switching_functions(*state, 0.0);
        let one = contact.switching_functions(*state, 1.0);
        all.extend(
            zero.iter()
                .zip(&one)
                .map(|(&(at, next), &(with, _))| ContactEvent {
                    branch,
                    value: [
                        at,
                        Affine {
                            constant: with.constant - at.constant,
                            deflection: with.deflection - at.deflection,
                            rate: with.rate - at.rate,
                        },
                    ],
                    next,
                }),
        );
    }
    all
}

impl SeriesSolutions {
    /// Motions from states at the middle, each with what acts on it.
    ///
    /// # Errors
    /// `NoConvergence` where the series do not end.
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
        let at = |k: usize, row: usize, column: usize| motions[column][k * rows + row] / unit(row);
        let size = |k: usize, column: usize| {
            (0..rows)
                .map(|row| at(k, row, column).abs())
                .fold(0.0, f64::max)
        };
        let length = (0..columns)
            .map(|column| significant_terms(|k| size(k, column) * (k.max(1) as f64)))
            .try_fold(2, |most, length| length.map(|length| most.max(length)))
            .ok_or_else(|| {
                let message = format!(
                    "the series of the motion over {} s do not end after {MAX_TERMS} terms",
                    2.0 * model.half
                );
                Error::new(Code::NoConvergence, message)
                    .with_hint("choose a time-stepping method: give --tolerance")
            })?;
        let mut terms = Vec::with_capacity(length * rows * columns);
        for row in 0..rows {
            for column in 0..columns {
                terms.extend((0..length).map(|k| at(k, row, column)));
            }
        }
        let mut beside = vec![[0.0; LANES]; (rows * columns).div_ceil(LANES) * length];
        for (entry, series) in terms.chunks_exact(length).enumerate() {
            let places = beside[entry / LANES * length..].iter_mut();
            places
                .zip(series)
                .for_each(|(place, a)| place[entry % LANES] = *a);
        }
        let mut events = Vec::with_capacity(limits.len() * length * columns);
        for limit in limits {
            for ((_, sources), motion) in starts.iter().zip(&motions) {
                events.extend(event_series(model, limit, motion, sources, length));
            }
        }
        let reach = |series: &[f64]| [series[0], series[1..].iter().map(|a| a.abs()).sum()];
        Ok(SeriesSolutions {
            columns,
            rows,
            terms,
            interleaved: beside,
            ranges: events.chunks_exact(length).map(reach).collect(),
            events,
            length,
        })
    }

    /// The states of all columns at a place, `[state][column]`; `speed` makes speeds of d/dσ.
    pub fn states(&self, place: f64, n: usize, speed: f64) -> Vec<f64> {
        let mut states = Vec::new();
        self.states_into(place, n, speed, &mut states);
        states
    }

    /// The same into room that is there.
    pub fn states_into(&self, place: f64, n: usize, speed: f64, states: &mut Vec<f64>) {
        let (entries, moved) = (self.rows * self.columns, n * self.columns);
        states.clear();
        states.resize(entries + moved, 0.0);
        for (at, terms) in self.interleaved.chunks_exact(self.length).enumerate() {
            let first = at * LANES;
            let (mut value, mut slope) = ([0.0; LANES], [0.0; LANES]);
            for term in terms.iter().rev() {
                for lane in 0..LANES {
                    slope[lane] = slope[lane] * place + value[lane];
                    value[lane] = value[lane] * place + term[lane];
                }
            }
            for (entry, lane) in (first..entries.min(first + LANES)).zip(0..) {
                if entry < moved {
                    states[entry] = value[lane];
                    states[entry + moved] = slope[lane] * speed;
                } else {
                    states[entry + moved] = value[lane];
                }
            }
        }
    }

    /// Range of a combination of the series of a switching function: its middle, its largest deviation from that on the piece, and the size
    /// of the terms that the middle is summed from.
    pub fn value_range(&self, event: usize, weights: &[f64]) -> [f64; 3] {
        let own = &self.ranges[event * self.columns..(event + 1) * self.columns];
        let pairs = own.iter().zip(weights);
        pairs.fold([0.0; 3], |[middle, reach, size], ([a, more], x)| {
            let part = a * x;
            [middle + part, reach + more * x.abs(), size + part.abs()]
        })
    }

    /// The combination of the series of a row by weights, added to `sum`.
    pub fn add_row(&self, row: usize, weights: &[f64], sum: &mut [f64]) {
        let size = self.columns * self.length;
        self.add(&self.terms[row * size..(row + 1) * size], weights, sum);
    }

    /// The combination of the series of a switching surface by weights, added to `sum`.
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

/// Terms after which two in a row no longer count.
fn significant_terms(size: impl Fn(usize) -> f64) -> Option<usize> {
    let mut largest: f64 = 0.0;
    let mut quiet = 0;
    for k in 0..MAX_TERMS {
        let now = size(k);
        largest = largest.max(now);
        quiet = if now <= NEGLIGIBLE * largest {
            quiet + 1
        } else {
            0
        };
        // Load harmonics and waves can leave out every second term, or start late: the first ones count always.
        if quiet >= 4 && k > 6 {
            return Some(k - 3);
        }
    }
    None
}

/// The value of a switching surface along a motion.
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
    let part = |a: Affine, k: usize| {
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
    let [plain, with_factor] = limit.value;
    let branch = &model.branches[limit.branch];
    let turning: Vec<f64> = (0..length).map(|k| part(with_factor, k)).collect();
    (0..length)
        .map(|k| part(plain, k) + branch.times_stiffness(&turning, k))
        .collect()
}

/// All columns' states at the start of the piece inverted, and at its end.
pub fn end_states(solutions: &SeriesSolutions, n: usize, speed: f64) -> (Vec<f64>, Vec<f64>) {
    let start = solutions.states(-1.0, n, speed);
    let end = solutions.states(1.0, n, speed);
    (small_dense::inverse(&start, n + solutions.rows), end)
}
