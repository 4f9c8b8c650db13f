//! First event of a segment by safe steps that skip no root of an event function.
//!
//! With p ≥ 0, ṗ and |p̈| ≤ M known, no root lies before that of the lower parabola. If p falls so steeply that
//! `M p < ṗ²/4`, exactly one root lies within `2p/|ṗ|`; Newton's iteration locates it.

use super::propagator_cache::PropagatorCache;
use super::regime_system::RegimeSystem;
use super::segment_trajectory::{EventValue, SegmentTrajectory};
use crate::base::error::Error;
use crate::motion::problem::{IntegrationOptions, IntegrationStats};
use crate::motion::progress::check_budget;

/// Zero crossing of an event function.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocatedEvent {
    /// Time of the event since the start of the segment, s.
    pub tau: f64,
    /// Index of the event function.
    pub event: usize,
}

/// Result of an event search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SearchOutcome {
    /// No event within the span.
    NoEvent,
    /// Event located.
    Reached(LocatedEvent),
    /// Cancellation requested.
    Cancelled,
}

/// Workspace of the event search: the bracket of every event function.
#[derive(Debug, Default)]
pub struct EventSearch {
    events: Vec<EventBracket>,
}

/// Bracket of the next root of an event function, in seconds since the start of the segment.
#[derive(Debug, Clone, Copy)]
struct EventBracket {
    /// Next root, s; NaN if not located.
    root: f64,
    /// Time up to which no root exists, s.
    clear: f64,
    reading: EventValue,
    /// Safe step from the reading, s.
    step: f64,
}

impl EventSearch {
    /// First event within `span` of the start of a segment at t, s.
    ///
    /// # Errors
    /// Those of [`check_budget`].
    pub fn next_event(
        &mut self,
        system: &RegimeSystem,
        cache: &mut PropagatorCache,
        trajectory: &mut SegmentTrajectory,
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
            let horizon = (span - tau).min(trajectory.max_horizon);
            trajectory.evaluate_events(system, horizon);
            for (event, bracket) in self.events.iter_mut().enumerate() {
                let mut reading = trajectory.event_value(system, event);
                if reading.value <= 0.0 {
                    // Just crossed, with a decrease within rounding: a pair breaks away without acceleration.
                    let noise = trajectory.noise(event);
                    let departs = trajectory.is_zero_at_start(event)
                        && reading.value >= -noise
                        && reading.rate * reading.rate <= 4.0 * reading.bound * noise;
                    if reading.rate < 0.0 && !departs {
                        return Ok(SearchOutcome::Reached(LocatedEvent { tau, event }));
                    }
                    reading.value = 0.0;
                    reading.rate = reading.rate.max(0.0);
                }
                bracket.reading = reading;
                bracket.step = safe_step(reading, horizon);
            }
            let (mut step, mut first) = self.shortest(tau, None);
            let EventBracket { root, reading, .. } = self.events[first];
            if root.is_nan() && step < horizon && is_monotone(reading) {
                let start = (tau, reading);
                match newton(system, trajectory, first, start, horizon, stats) {
                    Some(root) => self.events[first].root = root,
                    None => self.events[first].clear = tau + horizon,
                }
                (step, first) = self.shortest(tau, None);
            }
            let root = self.events[first].root;
            if !root.is_nan() {
                // No other event can precede this root.
                return Ok(match root < span {
                    true => SearchOutcome::Reached(LocatedEvent {
                        tau: root,
                        event: first,
                    }),
                    false => SearchOutcome::NoEvent,
                });
            }
            // Grazing without a certain crossing: advance by the resolution of rounding, but past no other event.
            let resolution = match self.events[first].reading.bound {
                0.0 => 0.0,
                bound => (2.0 * trajectory.noise(first) / bound).sqrt(),
            };
            let ulps = 4.0 * f64::EPSILON * (tau + trajectory.epoch.abs());
            let ulps = ulps.max(f64::MIN_POSITIVE);
            let forced = step < resolution.max(ulps);
            if forced {
                if !trajectory.is_zero_at_start(first) {
                    stats.grazings += 1;
                }
                step = resolution.min(self.shortest(tau, Some(first)).0).max(ulps);
            }
            step = step.min(horizon);
            if tau + step >= span {
                return Ok(SearchOutcome::NoEvent);
            }
            let continues = trajectory.trajectory.tau == tau && !forced;
            let parts = &system.linear.parts;
            match cache.longest_within(parts, step).filter(|_| continues) {
                Some(stride) => trajectory.stride(system, stride),
                None => trajectory.move_to(system, tau + step),
            }
            tau = trajectory.trajectory.tau;
        }
    }

    /// Shortest safe step, s, of all event functions but one, and its event function.
    fn shortest(&self, tau: f64, except: Option<usize>) -> (f64, usize) {
        let mut best = (f64::INFINITY, 0);
        for (event, bracket) in self.events.iter().enumerate() {
            if except == Some(event) {
                continue;
            }
            let step = match bracket.root.is_nan() {
                true => bracket.step.max(bracket.clear - tau),
                false => bracket.root - tau,
            };
            if step < best.0 {
                best = (step, event);
            }
        }
        best
    }
}

/// Safe step, s: no root precedes it or the horizon. p̈ stays above −M and above `p̈ − jerk h`; the step is the root of the
/// twice integrated larger bound.
fn safe_step(reading: EventValue, horizon: f64) -> f64 {
    let EventValue {
        value,
        rate,
        second_rate: accel,
        bound,
        jerk,
    } = reading;
    let mut step = parabola_step(value, rate, bound);
    // Earliest time at which p̈ reaches −M, times the jerk.
    let drop = accel + bound;
    for _ in 0..MAX_PARABOLA_STEPS {
        // NaN ends the loop as well.
        if !(step < horizon && jerk * step < drop) {
            break;
        }
        let slope = rate + step * (accel - 0.5 * jerk * step);
        let remaining = value + step * (rate + step * (0.5 * accel - jerk * step / 6.0));
        let gain = parabola_step(remaining.max(0.0), slope, bound);
        step += gain;
        if gain < MIN_GAIN * step {
            break;
        }
    }
    step
}

/// Maximum number of parabolas after the cubic segment.
const MAX_PARABOLA_STEPS: u32 = 3;

/// Smallest relative gain of a further parabola; below it a new evaluation of the motion gains more.
const MIN_GAIN: f64 = 0.1;

/// Root of the lower parabola `p + ṗ h − M h²/2`, s.
fn parabola_step(value: f64, rate: f64, bound: f64) -> f64 {
    let root = (rate * rate + 2.0 * bound * value).sqrt();
    match rate > 0.0 {
        true if bound > 0.0 => (rate + root) / bound,
        true => f64::INFINITY,
        false if value > 0.0 => match root - rate {
            0.0 => f64::INFINITY,
            sum => 2.0 * value / sum,
        },
        // At rest on the switching surface: no bound.
        false if bound == 0.0 => f64::INFINITY,
        false => 0.0,
    }
}

/// Whether p falls at half its rate or faster until it crosses zero: one root lies within `2p/|ṗ|`.
fn is_monotone(reading: EventValue) -> bool {
    let EventValue {
        value, rate, bound, ..
    } = reading;
    let time = -2.0 * value / rate;
    let accel = bound.min(reading.second_rate.max(0.0) + 0.5 * reading.jerk * time);
    rate < 0.0 && accel * time < -0.5 * rate
}

/// Number of evaluations between two checks for cancellation and budget.
const CHECK_INTERVAL: u64 = 256;

/// Newton's iteration for the single root after τ of a monotonic p; none if it lies beyond the horizon. The trajectory
/// is moved to the root.
fn newton(
    system: &RegimeSystem,
    trajectory: &mut SegmentTrajectory,
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
        trajectory.move_to(system, high);
        if trajectory.evaluate_event(system, event, 0.0).value > 0.0 {
            return None;
        }
    }
    let mut now = tau;
    let mut reading = start;
    const MAX_NEWTON: usize = 60; // of which two or three happen
    for _ in 0..MAX_NEWTON {
        let EventValue {
            value,
            rate,
            second_rate: accel,
            ..
        } = reading;
        // Root of the parabola through value, rate and acceleration.
        let root = (rate * rate - 2.0 * value * accel).sqrt();
        let parabola = 2.0 * value / (root - rate);
        let mut next = now
            + if parabola.is_nan() {
                -value / rate
            } else {
                parabola
            };
        if !(next >= low && next <= high) {
            next = 0.5 * (low + high);
        }
        let change = (next - now).abs();
        now = next;
        // The error is quadratic in the last change, or cubic.
        let error = match parabola.is_nan() {
            true => start.bound * change * change / steep,
            false => change * change * start.bound.min(start.jerk * change) / steep,
        };
        if error <= 0.25 * f64::EPSILON * now || change <= f64::EPSILON * now {
            break;
        }
        stats.evaluations += 1;
        trajectory.shift_to(system, now);
        reading = trajectory.evaluate_event(system, event, 0.0);
        if reading.value > 0.0 {
            low = now;
        } else {
            high = now;
        }
        if reading.value == 0.0 {
            break;
        }
    }
    trajectory.shift_to(system, now);
    Some(now)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The fastest decrease that a reading allows: its first root is not before the safe step and, for a monotonic decrease,
    /// before eight steps.
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
