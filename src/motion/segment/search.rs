//! The next switch: the first root of any border, never skipping one.
//!
//! With p ≥ 0, ṗ and |p̈| ≤ M known, no root lies before the worst parabola's touch; once p falls so steeply that
//! `M p < ṗ²/4`, there is exactly one within `2p/|ṗ|`, and Newton finds it.

use super::flight::{Flight, Reading};
use super::ladder::Ladder;
use super::machine::Machine;
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
    /// Readings, and the safe steps that follow.
    readings: Vec<Reading>,
    steps: Vec<f64>,
}

impl Search {
    /// The first border reached within `span`, from the start of a flight.
    pub fn next(
        &mut self,
        machine: &Machine,
        ladder: &mut Ladder,
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
            flight.look(machine, horizon);
            self.readings.clear();
            self.steps.clear();
            for at in 0..borders {
                let mut reading = flight.read(machine, at);
                if reading.value <= 0.0 {
                    // Just crossed, and falling by no more than rounding: a pair that breaks away does so without acceleration.
                    let noise = flight.noise(at);
                    let leaving = flight.starts_on(at)
                        && reading.value >= -noise
                        && reading.rate * reading.rate <= 4.0 * reading.bound * noise;
                    if reading.rate < 0.0 && !leaving {
                        return Outcome::Reached(Reached { tau, border: at });
                    }
                    reading.value = 0.0;
                    reading.rate = reading.rate.max(0.0);
                }
                self.readings.push(reading);
                let step = safe(reading);
                self.steps.push(match step < horizon {
                    true => further(step, reading).min(horizon),
                    false => step,
                });
            }
            let (mut step, mut first) = self.shortest(tau, None);
            let reading = self.readings[first];
            let square = reading.rate * reading.rate;
            let steep = reading.rate < 0.0 && reading.bound * reading.value < 0.25 * square;
            if steep && self.known[first].is_nan() && step < horizon {
                let from = (tau, reading);
                match newton(machine, flight, first, from, horizon, effort) {
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
            let hidden = match self.readings[first].bound {
                0.0 => 0.0,
                bound => (2.0 * flight.noise(first) / bound).sqrt(),
            };
            let ulps = 4.0 * f64::EPSILON * (tau + flight.epoch.abs());
            let ulps = ulps.max(f64::MIN_POSITIVE);
            let forced = step < hidden.max(ulps);
            if forced {
                if !flight.starts_on(first) {
                    effort.grazed += 1;
                }
                step = hidden.min(self.shortest(tau, Some(first)).0).max(ulps);
            }
            step = step.min(horizon);
            if tau + step >= span {
                return Outcome::Clear;
            }
            let stays = flight.course.tau == tau && !forced;
            match ladder.below(&machine.linear.parts, step).filter(|_| stays) {
                Some(stride) => {
                    flight
                        .course
                        .stride(&machine.linear.parts, stride, tau + stride.span)
                }
                None => flight.go(machine, tau + step),
            }
            tau = flight.course.tau;
        }
    }

    /// The shortest safe step of all borders but one, and whose it is.
    fn shortest(&self, tau: f64, but: Option<usize>) -> (f64, usize) {
        let mut best = (f64::INFINITY, 0);
        for at in 0..self.readings.len() {
            if but == Some(at) {
                continue;
            }
            let known = self.known[at];
            let step = match known.is_nan() {
                true => self.steps[at].max(self.clear[at] - tau),
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
fn safe(reading: Reading) -> f64 {
    let Reading {
        value, rate, bound, ..
    } = reading;
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

/// A longer safe step where one is seen: p̈ is known now and changes by no more than `jerk` a second, so that p stays above
/// `p + ṗ h + p̈ h²/2 − jerk H³/6` for all h up to H.
fn further(step: f64, reading: Reading) -> f64 {
    let Reading {
        value,
        rate,
        bend,
        jerk,
        ..
    } = reading;
    for times in [8.0, 4.0, 2.0, 1.5] {
        let reach = times * step;
        let lost = jerk * reach * reach * reach / 6.0;
        let at = |h: f64| value + h * (rate + 0.5 * bend * h);
        let least = match rate < 0.0 && bend * reach > -rate {
            true => value - 0.5 * rate * rate / bend,
            false => at(reach).min(value),
        };
        // At the start p may be zero; there it rises by more than is lost while it is small.
        let rises = value == 0.0 && rate > 0.0;
        let early = match rises {
            true => {
                at(reach) > lost
                    && rate + (0.5 * bend * reach).min(0.0) > jerk * reach * reach / 6.0
            }
            false => least > lost,
        };
        if early {
            return reach;
        }
    }
    step
}

/// Evaluations between two looks at whether the run is to end.
const LOOK: u64 = 256;

/// The one root after τ, where p falls ever faster than half its rate there; nothing where that is beyond the horizon. The flight
/// is there then.
fn newton(
    machine: &Machine,
    flight: &mut Flight,
    border: usize,
    (tau, start): (f64, Reading),
    horizon: f64,
    effort: &mut Effort,
) -> Option<f64> {
    let steep = start.rate.abs();
    let (mut low, mut high) = (tau, tau - 2.0 * start.value / start.rate);
    if high > tau + horizon {
        high = tau + horizon;
        effort.evaluations += 1;
        flight.go(machine, high);
        flight.look(machine, 0.0);
        if flight.read(machine, border).value > 0.0 {
            return None;
        }
    }
    let mut at = tau;
    let mut reading = start;
    const MOST: usize = 60; // of which two or three happen
    for _ in 0..MOST {
        let Reading {
            value, rate, bend, ..
        } = reading;
        // Where the parabola through value, rate and acceleration is zero.
        let root = (rate * rate - 2.0 * value * bend).sqrt();
        let parabola = 2.0 * value / (root - rate);
        let mut next = at
            + if parabola.is_nan() {
                -value / rate
            } else {
                parabola
            };
        if !(next >= low && next <= high) {
            next = 0.5 * (low + high);
        }
        let moved = (next - at).abs();
        at = next;
        // What is left is quadratic in what was moved, or cubic.
        let left = match parabola.is_nan() {
            true => start.bound * moved * moved / steep,
            false => moved * moved * start.bound.min(start.jerk * moved) / steep,
        };
        if left <= 0.25 * f64::EPSILON * at || moved <= f64::EPSILON * at {
            break;
        }
        effort.evaluations += 1;
        flight.go(machine, at);
        flight.look(machine, horizon);
        reading = flight.read(machine, border);
        if reading.value > 0.0 {
            low = at;
        } else {
            high = at;
        }
        if reading.value == 0.0 {
            break;
        }
    }
    if !flight.course.nudge(&machine.linear.parts, at) {
        flight.go(machine, at);
    }
    Some(at)
}
