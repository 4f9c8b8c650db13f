//! Integration run of a piecewise linear model: regimes, switches, time events, samples.

use super::double_time::DoubleTime;
use super::event_search::{EventSearch, LocatedEvent, SearchOutcome};
use super::regime_cache::{RegimeCache, check_phase};
use super::regime_system::RegimeSystem;
use super::run_context::RunContext;
use super::segment_trajectory::{BLOCK, SegmentTrajectory};
use super::time_events::{TimeEvent, TimeEvents};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_instant;
use crate::motion::contact::ContactState;
use crate::motion::diagnostics;
use crate::motion::dynamic_model::{DynamicModel, ElementState, ForceLaw, Regime};
use crate::motion::friction::FrictionState;
use crate::motion::problem::{DenseOutput, IntegrationOptions, IntegrationStats, SampleSink};
use crate::motion::progress::check_budget;

/// Switches within a few rounding errors of one instant beyond which they will not end.
const MAX_SIMULTANEOUS: u32 = 200;

/// Samples in one segment from which on they are reached by equal strides.
const BATCH_SAMPLES: f64 = 8.0;

/// Segments between two looks at whether the run is to end.
const CHECK_INTERVAL: u64 = 16;

/// Runs a machine that is linear between switches; the machines of the regimes it meets are kept while they fill `room`, in bytes.
///
/// # Errors
/// A machine that is not; no convergence; a budget spent; switches that pile up at an instant.
pub fn run(
    model: &DynamicModel,
    options: &IntegrationOptions,
    room: usize,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    let span = options.to - options.from;
    let driven = model.harmonics().fold(0.0, f64::max);
    check_phase("the fastest that acts", driven * span, span)?;
    let context = RunContext::new(model, span)?;
    let mut timing = TimeEvents::new(model, options.from)?;
    let mut regime = model.regime(options.from, &options.initial_state);
    for (branch, piece) in timing.pieces() {
        if let ElementState::Contact(stand, _) = regime.states[branch] {
            regime.states[branch] = ElementState::Contact(stand, piece);
        }
    }
    model.release_overloaded(&mut regime, options.from, &options.initial_state);
    let mut journey = IntegrationRun {
        context: &context,
        options,
        now: DoubleTime::new(options.from),
        y: options.initial_state.clone(),
        regime,
        stats: IntegrationStats::default(),
        sample: 0,
        due: options.from,
        event_counts: vec![0; model.elements.len()],
        simultaneous: (options.from, 0),
    };
    let mut cache = RegimeCache::new(model, room);
    let mut flight = SegmentTrajectory::default();
    let mut search = EventSearch::default();
    let mut next = vec![0.0; options.initial_state.len()];
    let mut ticks = Vec::new();
    let mut crossed: Option<(usize, usize)> = None;
    loop {
        if journey.stats.steps.is_multiple_of(CHECK_INTERVAL) {
            if options.cancel.should_stop() {
                return Ok(journey.stats);
            }
            check_budget(options, &journey.stats, journey.now.high)
                .map_err(|e| diagnostics::with_most_switched(e, model, &journey.event_counts))?;
        }
        crossed = cache.evict(crossed);
        let place = cache.index_of(&context, &journey.regime.states)?;
        journey.stats.regimes = cache.built_count();
        journey.stats.steps += 1;
        cache
            .system_mut(place)
            .set_pieces(&context.inputs, &journey.regime.pieces);
        let system = cache.system(place);
        let known = timing.next_time(&journey.regime.pieces, |branch| {
            journey.wave_matters(branch)
        });
        let end = known.min(options.to);
        let span = journey.now.until(end).max(0.0);
        let from = crossed.map(|(system, event)| &cache.system(system).events[event]);
        flight.start(
            &context,
            system,
            (journey.now, &journey.regime.pieces),
            &journey.y,
            span,
            from,
        );
        let (system, ladder) = cache.with_propagators(place);
        let effort = (&mut journey.stats, options);
        let ahead = (journey.now.high, span);
        let found = search
            .next_event(system, ladder, &mut flight, ahead, effort)
            .map_err(|e| diagnostics::with_most_switched(e, model, &journey.event_counts))?;
        let reached = match found {
            SearchOutcome::NoEvent => None,
            SearchOutcome::Reached(reached) => Some(reached),
            SearchOutcome::Cancelled => return Ok(journey.stats),
        };
        let tau = reached.map_or(span, |reached| reached.tau);
        let last = reached.is_none() && end >= options.to;
        if !last {
            flight.move_to(system, tau);
            flight.state(system, &mut next);
        }
        if options.observer.is_set() {
            let now = journey.now;
            options.observer.observe(DenseOutput {
                from: now.high,
                to: now.high + tau,
                time_scale: system.linear.parts.time_scale(),
                regime: Some(&journey.regime),
                state: &mut |t, y| match now.until(t) {
                    ahead if ahead > 0.0 => {
                        flight.move_to(system, ahead.min(tau));
                        flight.state(system, y);
                    }
                    _ => y.copy_from_slice(&journey.y),
                },
            });
        }
        if journey.emit_samples(system, &mut flight, (tau, last), sink) || last {
            return Ok(journey.stats);
        }
        if tau > 0.0 {
            std::mem::swap(&mut journey.y, &mut next);
        }
        match reached {
            Some(reached) => {
                journey.now = journey.now.after(tau);
                journey.apply_switch(system, reached, &mut timing)?;
                crossed = Some((place, reached.event));
            }
            None => {
                journey.now = DoubleTime::new(end);
                timing.advance(&journey.regime.pieces, end, &mut ticks);
                journey.apply_time_events(&ticks);
                crossed = None;
            }
        }
        if journey.y.iter().any(|y| !y.is_finite()) {
            let message = format!(
                "the motion leaves the range of numbers at t = {}",
                format_instant(end)
            );
            return Err(Error::new(Code::Overflow, message)
                .with_hint("check whether the machine is unstable"));
        }
    }
}

struct IntegrationRun<'a> {
    context: &'a RunContext<'a>,
    options: &'a IntegrationOptions,
    now: DoubleTime,
    y: Vec<f64>,
    regime: Regime,
    stats: IntegrationStats,
    /// The next sample, and a time before which it is not due.
    sample: usize,
    due: f64,
    /// Events of every branch.
    event_counts: Vec<u64>,
    /// An instant, and how many events came within rounding of it.
    simultaneous: (f64, u32),
}

impl IntegrationRun<'_> {
    /// Whether the wave of a branch has an effect in its present state.
    fn wave_matters(&self, branch: usize) -> bool {
        let stand = self.regime.states[branch];
        !matches!(stand, ElementState::Contact(ContactState::Open, _))
    }

    /// Delivers the samples up to τ; true where the run is to end early.
    fn emit_samples(
        &mut self,
        system: &RegimeSystem,
        flight: &mut SegmentTrajectory,
        (tau, last): (f64, bool),
        sink: &mut SampleSink,
    ) -> bool {
        if self.now.until(self.due) >= tau && !last {
            return false;
        }
        let usual = (self.options.to - self.options.from) / self.options.samples.max(1) as f64;
        let stride = (tau > BATCH_SAMPLES * usual).then(|| system.linear.parts.propagator(usual));
        let mut times = [0.0; BLOCK];
        while self.sample <= self.options.samples {
            if self.options.cancel.should_stop() {
                return true;
            }
            let t = self.options.time(self.sample);
            let ahead = self.now.until(t).max(0.0);
            if ahead >= tau && !last {
                self.due = t;
                return false;
            }
            if ahead == 0.0 {
                self.sample += 1;
                if sink(t, &self.y, Some(&self.regime)).is_break() {
                    return true;
                }
                continue;
            }
            let mut count = 0;
            while count < BLOCK && self.sample + count <= self.options.samples {
                let ahead = self.now.until(self.options.time(self.sample + count));
                if ahead >= tau && !last {
                    break;
                }
                times[count] = ahead;
                count += 1;
            }
            let (options, first) = (self.options, self.sample);
            self.sample += count;
            let regime = Some(&self.regime);
            let mut give =
                |at: usize, y: &[f64]| sink(options.time(first + at), y, regime).is_break();
            if flight.states(system, stride.as_ref(), &times[..count], &mut give) {
                return true;
            }
        }
        false
    }

    /// Applies the state beyond a switching surface that was reached.
    fn apply_switch(
        &mut self,
        system: &RegimeSystem,
        reached: LocatedEvent,
        timing: &mut TimeEvents,
    ) -> Result<(), Error> {
        let event = &system.events[reached.event];
        self.stats.events += 1;
        self.event_counts[event.branch] += 1;
        // While it stood open its wave went on unheeded.
        let piece = timing.piece(event.branch, self.now.high);
        self.regime.states[event.branch] = match (event.to, piece) {
            (ElementState::Contact(state, _), Some(piece)) => ElementState::Contact(state, piece),
            (to, _) => to,
        };
        let near = 64.0 * f64::EPSILON * self.now.high.abs().max(self.context.span);
        self.simultaneous = match (self.now.high - self.simultaneous.0).abs() <= near {
            true => (self.simultaneous.0, self.simultaneous.1 + 1),
            false => (self.now.high, 0),
        };
        if self.simultaneous.1 > MAX_SIMULTANEOUS {
            let name = &self.context.model.elements[event.branch].name;
            let message = format!(
                "`{name}` switches without end at t = {}",
                format_instant(self.now.high)
            );
            return Err(Error::new(Code::NoConvergence, message).with_hint(
                "give it some damping, or take a method that does not locate switches",
            ));
        }
        self.context
            .model
            .release_overloaded(&mut self.regime, self.now.high, &self.y);
        Ok(())
    }

    /// Applies events at known times: lines, waves, and the states that changed with them.
    fn apply_time_events(&mut self, ticks: &[TimeEvent]) {
        let model = self.context.model;
        let turned = |tick: &TimeEvent| matches!(tick, TimeEvent::Piece(..));
        let before = match ticks.iter().any(turned) {
            true => self.regime.pieces.clone(),
            false => Vec::new(),
        };
        for tick in ticks {
            match *tick {
                TimeEvent::Piece(at, piece) => self.regime.pieces[at] = piece,
                TimeEvent::Wave(branch, piece) => {
                    if let ElementState::Contact(state, _) = self.regime.states[branch] {
                        self.regime.states[branch] = ElementState::Contact(state, piece);
                    }
                }
            }
        }
        for tick in ticks {
            let branch = match *tick {
                TimeEvent::Piece(at, _) => at.checked_sub(model.forces.len()),
                TimeEvent::Wave(branch, _) => Some(branch),
            };
            if let Some(branch) = branch {
                self.update_state(branch, &before);
            }
        }
        model.release_overloaded(&mut self.regime, self.now.high, &self.y);
    }

    /// Updates the state of a branch whose wave or imposed motion jumped.
    fn update_state(&mut self, branch: usize, before: &[u32]) {
        let model = self.context.model;
        let (n, t) = (model.coordinate_count(), self.now.high);
        let b = &model.elements[branch];
        let (q, v) = (&self.y[..n], &self.y[n..2 * n]);
        let piece = model.error_pieces(Some(&self.regime), branch, t);
        let (delta, rate) = b.deflection(t, q, v, piece);
        const ROUNDING_TOLERANCE: f64 = 64.0 * f64::EPSILON;
        let next = match (&b.law, self.regime.states[branch]) {
            (ForceLaw::Contact(contact), ElementState::Contact(state, of_wave)) => {
                let factor = b.factor(t, q, of_wave).0;
                let holds = contact
                    .switching_functions(state, factor)
                    .iter()
                    .all(|(event, _)| {
                        let size = event.constant.abs()
                            + (event.deflection * delta).abs()
                            + (event.rate * rate).abs();
                        event.value_at(delta, rate) >= -ROUNDING_TOLERANCE * size
                    });
                match holds {
                    true => return,
                    false => ElementState::Contact(contact.state(delta, rate, factor), of_wave),
                }
            }
            (ForceLaw::Friction(_), ElementState::Friction(_)) => {
                let was = before[model.forces.len() + branch];
                let slope = |piece: u32| {
                    b.imposed_displacement
                        .as_ref()
                        .map_or(0.0, |e| e.slope(t, piece as usize))
                };
                if slope(was) == slope(piece.imposed) {
                    return;
                }
                ElementState::Friction(match rate {
                    rate if rate > 0.0 => FrictionState::Forward,
                    rate if rate < 0.0 => FrictionState::Backward,
                    _ => FrictionState::Stick,
                })
            }
            _ => return,
        };
        self.stats.events += 1;
        self.event_counts[branch] += 1;
        self.regime.states[branch] = next;
    }
}
