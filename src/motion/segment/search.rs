//! The next switch: the first root of any border, never skipping one.
//!
//! With p ≥ 0, ṗ and |p̈| ≤ M known, no root lies before the worst parabola's touch; once p falls so steeply that
//! `M p < ṗ²/4`, there is exactly one within `2p/|ṗ|`, and Newton finds it.

use super::flight::{Flight, Reading};
use super::machine::Machine;
use super::shared::Shared;
use crate::motion::problem::{Ask, Effort};

/// A border reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reached {
    /// When, from the start of the flight.
    pub tau: f64,
    /// Which border of the machine.
    pub border: usize,
}

/// What a search came to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Outcome {
    /// Nothing is reached in time.
    Clear,
    /// A border is.
    Reached(Reached),
    /// The budget went first, or the run is to end, at this τ.
    Spent(f64),
}

/// Working space: roots known to be the next of their border.
#[derive(Debug, Default)]
pub struct Search {
    known: Vec<f64>,
    /// Until when a border is known to have none.
    clear: Vec<f64>,
    readings: Vec<(Reading, f64)>,
}

impl Search {
    /// The first border reached within `span`.
    pub fn next(
        &mut self,
        shared: &Shared,
        machine: &Machine,
        flight: &mut Flight,
        span: f64,
        (effort, ask): (&mut Effort, &Ask),
    ) -> Outcome {
        let borders = machine.borders.len();
        self.known.clear();
        self.known.resize(borders, f64::NAN);
        self.clear.clear();
        self.clear.resize(borders, 0.0);
        if borders == 0 {
            return Outcome::Clear;
        }
        let mut tau = 0.0;
        loop {
            effort.evaluations += 1;
            if effort.evaluations + effort.steps > ask.budget
                || effort.evaluations.is_multiple_of(LOOK) && ask.stop.is_due()
            {
                return Outcome::Spent(tau);
            }
            let horizon = (span - tau).min(flight.reach);
            flight.move_to(shared, machine, tau);
            flight.fade(machine, tau, horizon);
            self.readings.clear();
            for at in 0..borders {
                let mut reading = flight.read(machine, at, tau);
                let bound = flight.bound(machine, at, tau + horizon);
                if reading.value <= 0.0 {
                    // Just crossed, and falling by no more than rounding: a pair that breaks away does so without acceleration.
                    let noise = flight.noise(at);
                    let leaving = flight.starts_on(at)
                        && reading.value >= -noise
                        && reading.rate * reading.rate <= 4.0 * bound * noise;
                    if reading.rate < 0.0 && !leaving {
                        return Outcome::Reached(Reached { tau, border: at });
                    }
                    reading.value = 0.0;
                    reading.rate = reading.rate.max(0.0);
                }
                self.readings.push((reading, bound));
            }
            let (mut step, mut first) = self.shortest(tau, None);
            let (reading, bound) = self.readings[first];
            let steep =
                reading.rate < 0.0 && bound * reading.value < 0.25 * reading.rate * reading.rate;
            if steep && self.known[first].is_nan() && step < horizon {
                let from = (tau, reading, bound);
                match newton(shared, machine, flight, first, from, horizon, effort) {
                    Some(root) => self.known[first] = root,
                    None => self.clear[first] = tau + horizon,
                }
                (step, first) = self.shortest(tau, None);
            }
            let root = self.known[first];
            if !root.is_nan() {
                // A root is known, and no other border can be reached before.
                return match root < span {
                    true => Outcome::Reached(Reached {
                        tau: root,
                        border: first,
                    }),
                    false => Outcome::Clear,
                };
            }
            // Touching without a certain crossing: go on by as much as rounding hides, but no other border is passed.
            let hidden = match self.readings[first].1 {
                0.0 => 0.0,
                bound => (2.0 * flight.noise(first) / bound).sqrt(),
            };
            let ulps = 4.0 * f64::EPSILON * (tau + flight.epoch.abs());
            let ulps = ulps.max(f64::MIN_POSITIVE);
            if step < hidden.max(ulps) {
                if !flight.starts_on(first) {
                    effort.grazed += 1;
                }
                step = hidden.min(self.shortest(tau, Some(first)).0).max(ulps);
            }
            tau += step.min(horizon);
            if tau >= span {
                return Outcome::Clear;
            }
        }
    }

    /// The shortest safe step of all borders but one, and whose it is.
    fn shortest(&self, tau: f64, but: Option<usize>) -> (f64, usize) {
        let mut best = (f64::INFINITY, 0);
        for (at, &(reading, bound)) in self.readings.iter().enumerate() {
            if but == Some(at) {
                continue;
            }
            let known = self.known[at];
            let step = match known.is_nan() {
                true => safe(reading, bound).max(self.clear[at] - tau),
                false => known - tau,
            };
            if step < best.0 {
                best = (step, at);
            }
        }
        best
    }
}

/// No root before this: where `p + ṗ h − M h²/2` touches zero.
fn safe(Reading { value, rate }: Reading, bound: f64) -> f64 {
    let root = (rate * rate + 2.0 * bound * value).sqrt();
    match rate > 0.0 {
        true if bound > 0.0 => (rate + root) / bound,
        true => f64::INFINITY,
        false if value > 0.0 => match root - rate {
            0.0 => f64::INFINITY,
            sum => 2.0 * value / sum,
        },
        // At rest on the border: as far as the caller dares.
        false if bound == 0.0 => f64::INFINITY,
        false => 0.0,
    }
}

/// Evaluations between two looks at whether the run is to end.
const LOOK: u64 = 256;

/// The one root after τ, where p falls ever faster than half its rate there; nothing where that is beyond the horizon.
fn newton(
    shared: &Shared,
    machine: &Machine,
    flight: &mut Flight,
    border: usize,
    (tau, start, bound): (f64, Reading, f64),
    horizon: f64,
    effort: &mut Effort,
) -> Option<f64> {
    let (mut low, mut high) = (tau, tau - 2.0 * start.value / start.rate);
    if high > tau + horizon {
        high = tau + horizon;
        effort.evaluations += 1;
        flight.move_to(shared, machine, high);
        if flight.read(machine, border, high).value > 0.0 {
            return None;
        }
    }
    let mut at = tau;
    let mut reading = start;
    const MOST: usize = 60; // of which a handful happen
    for _ in 0..MOST {
        let mut next = at - reading.value / reading.rate;
        if !(next >= low && next <= high) {
            next = 0.5 * (low + high);
        }
        let moved = (next - at).abs();
        at = next;
        // What is left is quadratic in what was moved.
        let left = 0.5 * bound * moved * moved / start.rate.abs();
        if left <= 0.25 * f64::EPSILON * at || moved <= f64::EPSILON * at {
            break;
        }
        effort.evaluations += 1;
        flight.move_to(shared, machine, at);
        reading = flight.read(machine, border, at);
        if reading.value > 0.0 {
            low = at;
        } else {
            high = at;
        }
        if reading.value == 0.0 {
            break;
        }
    }
    Some(at)
}
