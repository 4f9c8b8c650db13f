//! First switch of a segment by safe steps that skip no root of an event function.
//!
//! With p ≥ 0, ṗ and |p̈| ≤ M known, no root lies before the worst parabola's touch; once p falls so steeply that
//! `M p < ṗ²/4`, there is exactly one within `2p/|ṗ|`, and Newton finds it.

use super::propagator_cache::PropagatorCache;
use super::regime_system::RegimeSystem;
use super::segment_trajectory::{EventValue, SegmentTrajectory};
use crate::base::error::Error;
use crate::motion::problem::{IntegrationOptions, IntegrationStats};
use crate::motion::progress::check_budget;

/// A switching surface reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocatedEvent {
    /// Time of the event, from the start of the segment.
    pub tau: f64,
    /// Which switching surface of the machine.
    pub event: usize,
}

/// Result of an event search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SearchOutcome {
    /// Nothing is reached in time.
    NoEvent,
    /// A switching surface is.
    Reached(LocatedEvent),
    /// The run was ended.
    Cancelled,
}

/// Working space: what is known of every switching surface.
#[derive(Debug, Default)]
pub struct EventSearch {
    events: Vec<EventBracket>,
}

/// A switching surface on the way.
#[derive(Debug, Clone, Copy)]
struct EventBracket {
    /// A root known to be its next, else no number.
    root: f64,
    /// Until when it is known to have none.
    clear: f64,
    reading: EventValue,
    /// The safe step that follows from this.
    step: f64,
}

impl EventSearch {
    /// First switching surface reached within `span`, from the start of a segment at t, s.
    ///
    /// # Errors
    /// Those of [`check_budget`].
    pub fn next_event(
        &mut self,
        system: &RegimeSystem,
        cache: &mut PropagatorCache,
        flight: &mut SegmentTrajectory,
        (t, span): (f64, f64),
        (stats, options): (&mut IntegrationStats, &IntegrationOptions),
    ) -> Result<SearchOutcome, Error> {
        if system.events.is_empty() {
            return Ok(SearchOutcome::NoEvent);
        }
        let unknown = EventBracket {
            root: f64::NAN,
            clear: 0.0,
            reading: EventValue::default(),
            step: 0.0,
        };
        self.events.clear();
        self.events.resize(system.events.len(), unknown);
        let mut tau = 0.0;
        loop {
            stats.evaluations += 1;
            if stats.evaluations.is_multiple_of(CHECK_INTERVAL) {
                if options.cancel.should_stop() {
                    return Ok(SearchOutcome::Cancelled);
                }
                check_budget(options, stats, t + tau)?;
            }
            let horizon = (span - tau).min(flight.reach);
            flight.evaluate_events(system, horizon);
            for (at, own) in self.events.iter_mut().enumerate() {
                let mut reading = flight.event_value(system, at);
                if reading.value <= 0.0 {
                    // Just crossed, and falling by no more than rounding: a pair that breaks away does so without acceleration.
                    let noise = flight.noise(at);
                    let leaving = flight.is_zero_at_start(at)
                        && reading.value >= -noise
                        && reading.rate * reading.rate <= 4.0 * reading.bound * noise;
                    if reading.rate < 0.0 && !leaving {
                        return Ok(SearchOutcome::Reached(LocatedEvent { tau, event: at }));
                    }
                    reading.value = 0.0;
                    reading.rate = reading.rate.max(0.0);
                }
                own.reading = reading;
                own.step = safe_step(reading, horizon);
            }
            let (mut step, mut first) = self.shortest(tau, None);
            let EventBracket { root, reading, .. } = self.events[first];
            if root.is_nan() && step < horizon && is_monotone(reading) {
                let from = (tau, reading);
                match newton(system, flight, first, from, horizon, stats) {
                    Some(root) => self.events[first].root = root,
                    None => self.events[first].clear = tau + horizon,
                }
                (step, first) = self.shortest(tau, None);
            }
            let root = self.events[first].root;
            if !root.is_nan() {
                // A root is known, and no other switching surface can be reached before.
                return Ok(match root < span {
                    true => SearchOutcome::Reached(LocatedEvent {
                        tau: root,
                        event: first,
                    }),
                    false => SearchOutcome::NoEvent,
                });
            }
            // Touching without a certain crossing: go on by as much as rounding hides, but no other switching surface is passed.
            let hidden = match self.events[first].reading.bound {
                0.0 => 0.0,
                bound => (2.0 * flight.noise(first) / bound).sqrt(),
            };
            let ulps = 4.0 * f64::EPSILON * (tau + flight.epoch.abs());
            let ulps = ulps.max(f64::MIN_POSITIVE);
            let forced = step < hidden.max(ulps);
            if forced {
                if !flight.is_zero_at_start(first) {
                    stats.grazings += 1;
                }
                step = hidden.min(self.shortest(tau, Some(first)).0).max(ulps);
            }
            step = step.min(horizon);
            if tau + step >= span {
                return Ok(SearchOutcome::NoEvent);
            }
            let stays = flight.trajectory.tau == tau && !forced;
            let parts = &system.linear.parts;
            match cache.longest_within(parts, step).filter(|_| stays) {
                Some(stride) => flight.stride(system, stride),
                None => flight.move_to(system, tau + step),
            }
            tau = flight.trajectory.tau;
        }
    }

    /// The shortest safe step of all switching surfaces but one, and whose it is.
    fn shortest(&self, tau: f64, but: Option<usize>) -> (f64, usize) {
        let mut best = (f64::INFINITY, 0);
        for (at, own) in self.events.iter().enumerate() {
            if but == Some(at) {
                continue;
            }
            let step = match own.root.is_nan() {
                true => own.step.max(own.clear - tau),
                false => own.root - tau,
            };
            if step < best.0 {
                best = (step, at);
            }
        }
        best
    }
}

/// No root before this, or none before the horizon: p̈ stays above −M, and where it is known now also above `p̈ − jerk h`; the
/// integral of the larger of these is followed until it touches zero.
fn safe_step(reading: EventValue, horizon: f64) -> f64 {
    let EventValue {
        value,
        rate,
        second_rate: bend,
        bound,
        jerk,
    } = reading;
    let mut step = parabola_step(value, rate, bound);
    // Where p̈ can have fallen to −M.
    let down = bend + bound;
    for _ in 0..MAX_PARABOLA_STEPS {
        // Also where one of them is no number.
        if !(step < horizon && jerk * step < down) {
            break;
        }
        let slope = rate + step * (bend - 0.5 * jerk * step);
        let left = value + step * (rate + step * (0.5 * bend - jerk * step / 6.0));
        let more = parabola_step(left.max(0.0), slope, bound);
        step += more;
        if more < MIN_GAIN * step {
            break;
        }
    }
    step
}

/// Touches of parabolas that follow a cubic, at most.
const MAX_PARABOLA_STEPS: u32 = 3;

/// Smallest gain of a further touch, as a share; below it a new evaluation of the motion gains more.
const MIN_GAIN: f64 = 0.1;

/// No root before this: where `p + ṗ h − M h²/2` touches zero.
fn parabola_step(value: f64, rate: f64, bound: f64) -> f64 {
    let root = (rate * rate + 2.0 * bound * value).sqrt();
    match rate > 0.0 {
        true if bound > 0.0 => (rate + root) / bound,
        true => f64::INFINITY,
        false if value > 0.0 => match root - rate {
            0.0 => f64::INFINITY,
            sum => 2.0 * value / sum,
        },
        // At rest on the switching surface: as far as the caller dares.
        false if bound == 0.0 => f64::INFINITY,
        false => 0.0,
    }
}

/// Whether p falls by half its rate at least until it has certainly crossed: there is one root then within `2p/|ṗ|`.
fn is_monotone(reading: EventValue) -> bool {
    let EventValue {
        value, rate, bound, ..
    } = reading;
    let reach = -2.0 * value / rate;
    let bent = bound.min(reading.second_rate.max(0.0) + 0.5 * reading.jerk * reach);
    rate < 0.0 && bent * reach < -0.5 * rate
}

/// Evaluations between two looks at whether the run is to end.
const CHECK_INTERVAL: u64 = 256;

/// The one root after τ, where p falls ever faster than half its rate there; nothing where that is beyond the horizon. The flight
/// is there then.
fn newton(
    system: &RegimeSystem,
    flight: &mut SegmentTrajectory,
    event: usize,
    (tau, start): (f64, EventValue),
    horizon: f64,
    stats: &mut IntegrationStats,
) -> Option<f64> {
    let steep = start.rate.abs();
    let (mut low, mut high) = (tau, tau - 2.0 * start.value / start.rate);
    if high > tau + horizon {
        high = tau + horizon;
        stats.evaluations += 1;
        flight.move_to(system, high);
        if flight.evaluate_event(system, event, 0.0).value > 0.0 {
            return None;
        }
    }
    let mut at = tau;
    let mut reading = start;
    const MAX_NEWTON: usize = 60; // of which two or three happen
    for _ in 0..MAX_NEWTON {
        let EventValue {
            value,
            rate,
            second_rate: bend,
            ..
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
        stats.evaluations += 1;
        flight.shift_to(system, at);
        reading = flight.evaluate_event(system, event, 0.0);
        if reading.value > 0.0 {
            low = at;
        } else {
            high = at;
        }
        if reading.value == 0.0 {
            break;
        }
    }
    flight.shift_to(system, at);
    Some(at)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The motion that falls soonest of all that a reading allows: its first root is not before the safe step, and, where it
    /// falls ever faster, before eight steps.
    #[test]
    fn law_steps_are_safe_and_lead_on() {
        let mut seed: u32 = 1;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(seed >> 8) / f64::from(1 << 24)
        };
        for case in 0..2000 {
            let bound = 10f64.powf(4.0 * random() - 2.0);
            let rate = 2.0 * random() - 1.0;
            let fresh = case % 4 == 0;
            let reading = EventValue {
                value: if fresh { 0.0 } else { random() },
                rate: if fresh { rate.abs() } else { rate },
                second_rate: bound * (2.0 * random() - 1.0),
                bound,
                jerk: bound * 10f64.powf(4.0 * random() - 2.0),
            };
            let step = safe_step(reading, f64::INFINITY);
            let (mut value, mut slope) = (reading.value, reading.rate);
            let small = step / 2000.0;
            for at in 0..16_000 {
                let h = small * (f64::from(at) + 0.5);
                let bent = (reading.second_rate - reading.jerk * h).max(-bound);
                value += small * (slope + 0.5 * small * bent);
                slope += small * bent;
                if value < 0.0 {
                    assert!(h > 0.999 * step, "{h} before {step}: {reading:?}");
                    break;
                }
            }
            assert!(
                value < 0.0 || reading.second_rate > 0.0,
                "{step} is far too short: {reading:?}"
            );
        }
    }
}
