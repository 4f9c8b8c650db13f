//! Integration run of a piecewise linear model: regimes, state events, time events, samples.

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

/// Number of events within rounding of one instant above which the run is rejected.
const MAX_SIMULTANEOUS: u32 = 200;

/// Number of samples in a segment from which on a propagator over the sample interval is used.
const BATCH_SAMPLES: f64 = 8.0;

/// Number of segments between two checks of the budget and of cancellation.
const CHECK_INTERVAL: u64 = 16;

/// Integrates a model that is linear between events; the regime cache holds at most `max_bytes`.
///
/// # Errors
/// Errors for a model that is not piecewise linear, no convergence, an exceeded budget, an accumulation of events, and overflow.
pub fn run(
    model: &DynamicModel,
    options: &IntegrationOptions,
    max_bytes: usize,
    sink: &mut SampleSink,
) -> Result<IntegrationStats, Error> {
    let span = options.to - options.from;
    let omega_max = model.harmonics().fold(0.0, f64::max);
    check_phase("the fastest excitation", omega_max * span, span)?;
    let context = RunContext::new(model, span)?;
    let mut time_events = TimeEvents::new(model, options.from)?;
    let mut regime = model.regime(options.from, &options.initial_state);
    for (branch, piece) in time_events.pieces() {
        if let ElementState::Contact(state, _) = regime.states[branch] {
            regime.states[branch] = ElementState::Contact(state, piece);
        }
    }
    model.release_overloaded(&mut regime, options.from, &options.initial_state);
    let mut run = IntegrationRun {
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
    let mut cache = RegimeCache::new(model, max_bytes);
    let mut trajectory = SegmentTrajectory::default();
    let mut search = EventSearch::default();
    let mut next = vec![0.0; options.initial_state.len()];
    let mut due_events = Vec::new();
    let mut crossed: Option<(usize, usize)> = None;
    loop {
        if run.stats.steps.is_multiple_of(CHECK_INTERVAL) {
            if options.cancel.should_stop() {
                return Ok(run.stats);
            }
            check_budget(options, &run.stats, run.now.high)
                .map_err(|e| diagnostics::with_most_switched(e, model, &run.event_counts))?;
        }
        crossed = cache.evict(crossed);
        let index = cache.index_of(&context, &run.regime.states)?;
        run.stats.regimes = cache.built_count();
        run.stats.steps += 1;
        cache
            .system_mut(index)
            .set_pieces(&context.inputs, &run.regime.pieces);
        let system = cache.system(index);
        let next_event =
            time_events.next_time(&run.regime.pieces, |branch| run.wave_matters(branch));
        let end = next_event.min(options.to);
        let span = run.now.until(end).max(0.0);
        let from = crossed.map(|(system, event)| &cache.system(system).events[event]);
        trajectory.start(
            &context,
            system,
            (run.now, &run.regime.pieces),
            &run.y,
            span,
            from,
        );
        let (system, propagators) = cache.with_propagators(index);
        let budget = (&mut run.stats, options);
        let ahead = (run.now.high, span);
        let outcome = search
            .next_event(system, propagators, &mut trajectory, ahead, budget)
            .map_err(|e| diagnostics::with_most_switched(e, model, &run.event_counts))?;
        let reached = match outcome {
            SearchOutcome::NoEvent => None,
            SearchOutcome::Reached(reached) => Some(reached),
            SearchOutcome::Cancelled => return Ok(run.stats),
        };
        let tau = reached.map_or(span, |reached| reached.tau);
        let last = reached.is_none() && end >= options.to;
        if !last {
            trajectory.move_to(system, tau);
            trajectory.state(system, &mut next);
        }
        if options.observer.is_set() {
            let now = run.now;
            options.observer.observe(DenseOutput {
                from: now.high,
                to: now.high + tau,
                time_scale: system.linear.parts.time_scale(),
                regime: Some(&run.regime),
                state: &mut |t, y| match now.until(t) {
                    ahead if ahead > 0.0 => {
                        trajectory.move_to(system, ahead.min(tau));
                        trajectory.state(system, y);
                    }
                    _ => y.copy_from_slice(&run.y),
                },
            });
        }
        if run.emit_samples(system, &mut trajectory, (tau, last), sink) || last {
            return Ok(run.stats);
        }
        if tau > 0.0 {
            std::mem::swap(&mut run.y, &mut next);
        }
        match reached {
            Some(reached) => {
                run.now = run.now.after(tau);
                run.apply_switch(system, reached, &mut time_events)?;
                crossed = Some((index, reached.event));
            }
            None => {
                run.now = DoubleTime::new(end);
                time_events.advance(&run.regime.pieces, end, &mut due_events);
                run.apply_time_events(&due_events);
                crossed = None;
            }
        }
        if run.y.iter().any(|y| !y.is_finite()) {
            let message = format!(
                "the solution diverged (overflow) at t = {}",
                format_instant(end)
            );
            return Err(
                Error::new(Code::Overflow, message).with_hint("check the stability of the machine")
            );
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
    /// Index of the next sample, and a time, s, before which it is not due.
    sample: usize,
    due: f64,
    /// Number of events of each element.
    event_counts: Vec<u64>,
    /// Instant, s, and the number of events within rounding of it.
    simultaneous: (f64, u32),
}

impl IntegrationRun<'_> {
    /// Whether the stiffness wave of an element has an effect in its present state.
    fn wave_matters(&self, branch: usize) -> bool {
        let state = self.regime.states[branch];
        !matches!(state, ElementState::Contact(ContactState::Open, _))
    }

    /// Emits the samples of the segment up to its length `tau`, s; `true` ends the run early.
    fn emit_samples(
        &mut self,
        system: &RegimeSystem,
        trajectory: &mut SegmentTrajectory,
        (tau, last): (f64, bool),
        sink: &mut SampleSink,
    ) -> bool {
        if self.now.until(self.due) >= tau && !last {
            return false;
        }
        let interval = (self.options.to - self.options.from) / self.options.samples.max(1) as f64;
        let propagator =
            (tau > BATCH_SAMPLES * interval).then(|| system.linear.parts.propagator(interval));
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
            let mut emit =
                |at: usize, y: &[f64]| sink(options.time(first + at), y, regime).is_break();
            if trajectory.states(system, propagator.as_ref(), &times[..count], &mut emit) {
                return true;
            }
        }
        false
    }

    /// Sets the state beyond the switching surface of a located event.
    fn apply_switch(
        &mut self,
        system: &RegimeSystem,
        reached: LocatedEvent,
        time_events: &mut TimeEvents,
    ) -> Result<(), Error> {
        let event = &system.events[reached.event];
        self.stats.events += 1;
        self.event_counts[event.branch] += 1;
        // The piece of the stiffness wave was not updated while the contact was open.
        let piece = time_events.piece(event.branch, self.now.high);
        self.regime.states[event.branch] = match (event.to, piece) {
            (ElementState::Contact(state, _), Some(piece)) => ElementState::Contact(state, piece),
            (to, _) => to,
        };
        let rounding = 64.0 * f64::EPSILON * self.now.high.abs().max(self.context.span);
        self.simultaneous = match (self.now.high - self.simultaneous.0).abs() <= rounding {
            true => (self.simultaneous.0, self.simultaneous.1 + 1),
            false => (self.now.high, 0),
        };
        if self.simultaneous.1 > MAX_SIMULTANEOUS {
            let name = &self.context.model.elements[event.branch].name;
            let message = format!("`{name}` chatters at t = {}", format_instant(self.now.high));
            return Err(Error::new(Code::NoConvergence, message).with_hint(
                "give it some damping, or take a method that does not locate switches",
            ));
        }
        self.context
            .model
            .release_overloaded(&mut self.regime, self.now.high, &self.y);
        Ok(())
    }

    /// Applies time events: new pieces of signals and waves, and the element states that change with them.
    fn apply_time_events(&mut self, events: &[TimeEvent]) {
        let model = self.context.model;
        let is_piece = |event: &TimeEvent| matches!(event, TimeEvent::Piece(..));
        let before = match events.iter().any(is_piece) {
            true => self.regime.pieces.clone(),
            false => Vec::new(),
        };
        for event in events {
            match *event {
                TimeEvent::Piece(at, piece) => self.regime.pieces[at] = piece,
                TimeEvent::Wave(branch, piece) => {
                    if let ElementState::Contact(state, _) = self.regime.states[branch] {
                        self.regime.states[branch] = ElementState::Contact(state, piece);
                    }
                }
            }
        }
        for event in events {
            let branch = match *event {
                TimeEvent::Piece(at, _) => at.checked_sub(model.forces.len()),
                TimeEvent::Wave(branch, _) => Some(branch),
            };
            if let Some(branch) = branch {
                self.update_state(branch, &before);
            }
        }
        model.release_overloaded(&mut self.regime, self.now.high, &self.y);
    }

    /// Updates the state of an element after a jump of its wave or imposed displacement.
    fn update_state(&mut self, branch: usize, before: &[u32]) {
        let model = self.context.model;
        let (n, t) = (model.coordinate_count(), self.now.high);
        let b = &model.elements[branch];
        let (q, v) = (&self.y[..n], &self.y[n..2 * n]);
        let piece = model.error_pieces(Some(&self.regime), branch, t);
        let (delta, rate) = b.deflection(t, q, v, piece);
        const ROUNDING_TOLERANCE: f64 = 64.0 * f64::EPSILON;
        let next = match (&b.law, self.regime.states[branch]) {
            (ForceLaw::Contact(contact), ElementState::Contact(state, wave_piece)) => {
                let factor = b.factor(t, q, wave_piece).0;
                let valid = contact
                    .switching_functions(state, factor)
                    .iter()
                    .all(|(event, _)| {
                        let size = event.constant.abs()
                            + (event.deflection * delta).abs()
                            + (event.rate * rate).abs();
                        event.value_at(delta, rate) >= -ROUNDING_TOLERANCE * size
                    });
                match valid {
                    true => return,
                    false => ElementState::Contact(contact.state(delta, rate, factor), wave_piece),
                }
            }
            (ForceLaw::Friction(_), ElementState::Friction(_)) => {
                let previous = before[model.forces.len() + branch];
                let slope = |piece: u32| {
                    b.imposed_displacement
                        .as_ref()
                        .map_or(0.0, |e| e.slope(t, piece as usize))
                };
                if slope(previous) == slope(piece.imposed) {
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
