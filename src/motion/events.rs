//! Event-driven integration: each step runs in one frozen regime and ends at its first event.
//!
//! The frozen regime makes the problem of a step smooth, so the step may pass a switching surface. The event function p is interpolated by
//! a polynomial over the step; if it crosses zero, the step is repeated with h ← h − p/ṗ until it ends on the surface.

use super::bernstein::{BernsteinBasis, Coefficients, ZeroCrossing, zero_crossing};
use super::diagnostics;
use super::dynamic_model::{DynamicModel, ElementState, ForceLaw, Regime};
use super::equations::RegimeProblem;
use super::friction::FrictionState;
use super::problem::{DenseOutput, IntegrationOptions, IntegrationStats, OdeProblem, SampleSink};
use super::progress::{SampleEmitter, check_budget, check_options, next_discontinuity_within};
use super::stepper::Stepper;
use super::switching_surface::{
    SwitchingSurface, WaveKind, WavePiece, error_wave_pieces, switching_surfaces, wave_pieces,
};
use super::wave::WavePhase;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_instant;

/// Rounding error of an event function and of its coefficients, relative to the size of its terms.
const ROUNDING_FACTOR: f64 = 256.0 * f64::EPSILON;

/// Value of an event function below which an event counts as located, relative to the size of its terms.
const LOCATED: f64 = 8.0 * f64::EPSILON;

/// Change of a massless position beyond which it has jumped, relative to the largest position; smaller changes are rounding.
const JUMP_TOLERANCE: f64 = 1e-9;

/// Maximum number of contact-state updates where positions jump.
const MAX_UPDATES: usize = 20;

/// Crossing of a switching surface.
struct EventCrossing {
    surface: SwitchingSurface,
    /// Fraction of the step, 0 to 1.
    at: f64,
    /// Descent rate of the event function there, per step.
    fall: f64,
}

/// State of an event-driven integration run.
struct EventRun<'a> {
    model: &'a DynamicModel,
    basis: BernsteinBasis,
    regime: Regime,
    waves: Vec<WavePiece>,
    /// Whether each element has switched at the present instant.
    entered: Vec<bool>,
    /// Number of events of each element.
    switches: Vec<u64>,
    stats: IntegrationStats,
    t: f64,
    y: Vec<f64>,
}

/// Integrates a model and locates its events.
///
/// # Errors
/// Those of the steps; `NoConvergence` if events repeat without an advance of time (chattering).
pub fn run<S>(
    model: &DynamicModel,
    options: &IntegrationOptions,
    sink: &mut SampleSink,
    stepper: &mut S,
) -> Result<IntegrationStats, Error>
where
    S: for<'f> Stepper<RegimeProblem<'f>>,
{
    check_options(options, model.len())?;
    let mut samples = SampleEmitter::new(options, sink);
    let (mut regime, y) = model.consistent_regime(options.from, &options.initial_state)?;
    regime.wave_pieces = error_wave_pieces(model, options.from, &y);
    let mut run = EventRun {
        model,
        basis: BernsteinBasis::new()?,
        waves: wave_pieces(model, options.from, &y),
        regime,
        entered: vec![false; model.elements.len()],
        switches: vec![0; model.elements.len()],
        stats: IntegrationStats::default(),
        t: options.from,
        y,
    };
    let mut sample = run.y.clone();
    while samples.due().is_some() && run.t < options.to {
        let stop = next_discontinuity_within(|t| model.next_discontinuity(t), run.t, options.to);
        run.enter_interval(stop)?;
        run.emit(&mut samples, &mut sample)?;
        stepper.restart();
        let mut stalled = 0;
        while run.t < stop && samples.due().is_some() {
            let (t, y) = (run.t, run.y.clone());
            let switched = run.step(stop, stepper)?;
            check_budget(options, &run.stats, run.t)
                .map_err(|e| diagnostics::with_most_switched(e, model, &run.switches))?;
            if run.t > t {
                let (end, span) = (run.t.next_down(), run.t - t);
                options.observer.observe(DenseOutput {
                    from: t,
                    to: run.t,
                    time_scale: span,
                    regime: Some(&run.regime),
                    state: &mut |at, out| match at == run.t {
                        true => out.copy_from_slice(&run.y),
                        false => stepper.interpolate((at - t) / span, out),
                    },
                });
                samples.emit_until(end, &mut sample, Some(&run.regime), |due, out| {
                    stepper.interpolate((due - t) / span, out);
                })?;
                run.entered.fill(false);
            }
            stalled = match run.t - t > 64.0 * f64::EPSILON * t.abs() {
                true => 0,
                false => stalled + 1,
            };
            if let Some(surface) = switched {
                if stalled > 20 + 4 * model.elements.len() {
                    return Err(run.chattering_error(surface, y));
                }
                run.apply_switch(surface)?;
                stepper.restart();
            }
            if run.t < stop {
                run.emit(&mut samples, &mut sample)?;
            }
        }
    }
    run.emit(&mut samples, &mut sample)?;
    Ok(run.stats)
}

impl EventRun<'_> {
    /// Emits the samples due at the present instant, with the regime that applies afterwards.
    fn emit(&self, samples: &mut SampleEmitter, sample: &mut [f64]) -> Result<(), Error> {
        samples.emit_until(self.t, sample, Some(&self.regime), |_, out| {
            out.copy_from_slice(&self.y);
        })
    }

    /// Sets the pieces of known time functions for the interval up to the next discontinuity `stop`, s.
    fn enter_interval(&mut self, stop: f64) -> Result<(), Error> {
        let middle = self.t + 0.5 * (stop - self.t);
        let model = self.model;
        let n_forces = model.forces.len();
        for (at, force) in model.forces.iter().enumerate() {
            self.regime.pieces[at] = force.signal.piece(middle) as u32;
        }
        for (at, branch) in model.elements.iter().enumerate() {
            let mut jumps = false;
            if let Some(e) = &branch.imposed_displacement {
                let piece = e.piece(middle) as u32;
                jumps |= piece != self.regime.pieces[n_forces + at];
                self.regime.pieces[n_forces + at] = piece;
            }
            if let (Some(wave), ElementState::Contact(state, previous)) =
                (&branch.stiffness_wave, self.regime.states[at])
                && let WavePhase::Imposed { .. } = wave.phase
            {
                let piece = wave.waveform.piece(wave.phase.phase_at(middle, &[])) as u32;
                jumps |= piece != previous;
                self.regime.states[at] = ElementState::Contact(state, piece);
            }
            if let Some(WavePhase::Imposed { .. }) = branch.law.phase() {
                let piece = model.path_piece(at, middle, &[]);
                self.regime.pieces[model.path_at(at)] = piece;
            }
            if jumps {
                self.update_contact_state(at);
            }
        }
        self.settle_friction()
    }

    /// Takes one step, at most to `stop`, and returns the switching surface that it ends on.
    fn step<S>(&mut self, stop: f64, stepper: &mut S) -> Result<Option<SwitchingSurface>, Error>
    where
        S: for<'f> Stepper<RegimeProblem<'f>>,
    {
        let problem = RegimeProblem {
            model: self.model,
            regime: &self.regime,
        };
        let (t, y) = (self.t, &self.y);
        let stop = stop.min(self.beyond_next_end());
        let mut stats = self.stats;
        let (mut end, mut state) = stepper.step(&problem, (t, y), stop, &mut stats)?;
        stats.steps += 1;
        let h = end - t;
        let mut switched = None;
        if let Some(crossing) = self.locate_event(t, h, stepper, &mut stats) {
            let rounding = 4.0 * f64::EPSILON * t.abs().max(end.abs());
            let mut target = t + crossing.at * h;
            if target - t <= rounding {
                self.stats = stats;
                return Ok(Some(crossing.surface));
            }
            let rate = crossing.fall / h;
            for _ in 0..4 {
                (end, state) = stepper.step(&problem, (t, y), target, &mut stats)?;
                switched = (end == target).then_some(crossing.surface);
                let (value, size) =
                    crossing
                        .surface
                        .value(self.model, &self.regime, &self.waves, end, &state);
                stats.evaluations += 1;
                let change = value / rate;
                let next = (target + change).min(stop);
                let exact = value.abs() <= LOCATED * size || change.abs() <= rounding;
                if switched.is_none() || exact || !(next > t + rounding && change.abs() < 0.1 * h) {
                    break;
                }
                target = next;
            }
        }
        self.stats = stats;
        (self.t, self.y) = (end, state);
        Ok(switched)
    }

    /// First switching surface that the last step crosses.
    fn locate_event<S>(
        &self,
        t: f64,
        h: f64,
        stepper: &S,
        stats: &mut IntegrationStats,
    ) -> Option<EventCrossing>
    where
        S: for<'f> Stepper<RegimeProblem<'f>>,
    {
        let surfaces = switching_surfaces(self.model, &self.regime, &self.waves);
        if surfaces.is_empty() {
            return None;
        }
        let mut first: Option<EventCrossing> = None;
        let states: Vec<Vec<f64>> = self
            .basis
            .points
            .iter()
            .map(|&theta| {
                let mut y = self.y.clone();
                if theta > 0.0 {
                    stepper.interpolate(theta, &mut y);
                }
                y
            })
            .collect();
        stats.evaluations += surfaces.len() as u64;
        for surface in surfaces {
            let mut size: f64 = 0.0;
            let values: Coefficients = std::array::from_fn(|j| {
                let u = t + self.basis.points[j] * h;
                let (value, terms) =
                    surface.value(self.model, &self.regime, &self.waves, u, &states[j]);
                size = size.max(terms);
                value
            });
            let b = self.basis.coefficients(&values);
            let steepest = b
                .windows(2)
                .map(|p| (p[1] - p[0]).abs())
                .fold(0.0, f64::max)
                * 8.0
                / h;
            let noise = ROUNDING_FACTOR * size + 8.0 * f64::EPSILON * t.abs() * steepest;
            match zero_crossing(&b, noise, self.entered[surface.branch(&self.waves)]) {
                ZeroCrossing::NoCrossing => {}
                ZeroCrossing::Grazing => stats.grazings += 1,
                ZeroCrossing::Crossed(at, fall) => {
                    if first.as_ref().is_none_or(|f| at < f.at) {
                        first = Some(EventCrossing { surface, at, fall });
                    }
                }
            }
        }
        first
    }

    /// Changes the regime to that beyond a switching surface.
    fn apply_switch(&mut self, surface: SwitchingSurface) -> Result<(), Error> {
        let branch = surface.branch(&self.waves);
        self.entered[branch] = true;
        self.switches[branch] += 1;
        self.stats.events += 1;
        match surface {
            SwitchingSurface::Contact(_, which) => {
                let b = &self.model.elements[branch];
                if let (ForceLaw::Contact(contact), ElementState::Contact(state, piece)) =
                    (&b.law, self.regime.states[branch])
                    && let Some((_, state)) = contact.switching_functions(state, 1.0).get(which)
                {
                    let state = *state;
                    self.regime.states[branch] = ElementState::Contact(state, piece);
                }
            }
            SwitchingSurface::SlipReversal(_) => {
                self.regime.states[branch] = ElementState::Friction(FrictionState::Stick);
                self.project_stick_velocity();
            }
            SwitchingSurface::Breakaway(_, slip) => {
                self.regime.states[branch] = ElementState::Friction(slip);
            }
            SwitchingSurface::PieceEnd(span, up) => {
                self.stats.events -= 1;
                self.switches[branch] -= 1;
                for (span, up) in self.coincident_ends(span, up) {
                    self.enter_piece(span, up);
                }
            }
        }
        self.settle_friction()
    }

    /// Instant slightly beyond the next end of a wave piece at the present rates, s; a step of this length locates the end directly.
    fn beyond_next_end(&self) -> f64 {
        const BEYOND: f64 = 1.02;
        let left = (0..self.waves.len()).filter_map(|at| {
            let rate = self.waves[at].rate(self.model, self.t, &self.y);
            let end = SwitchingSurface::PieceEnd(at, rate > 0.0);
            let (left, size) = end.value(self.model, &self.regime, &self.waves, self.t, &self.y);
            (rate != 0.0 && left > LOCATED * size).then(|| left / rate.abs())
        });
        self.t + BEYOND * left.fold(f64::INFINITY, f64::min)
    }

    /// Ends of wave pieces reached at the present instant to rounding; the waves of one mesh have common edges.
    fn coincident_ends(&self, span: usize, up: bool) -> Vec<(usize, bool)> {
        let others = (0..self.waves.len()).filter(|at| *at != span);
        let reached = others.filter_map(|at| {
            let up = self.waves[at].rate(self.model, self.t, &self.y) > 0.0;
            let end = SwitchingSurface::PieceEnd(at, up);
            let (left, size) = end.value(self.model, &self.regime, &self.waves, self.t, &self.y);
            (left <= LOCATED * size).then_some((at, up))
        });
        std::iter::once((span, up)).chain(reached).collect()
    }

    /// Advances a wave to its next piece.
    fn enter_piece(&mut self, span: usize, up: bool) {
        self.waves[span].advance(self.model, up);
        let span = self.waves[span];
        let branch = span.branch;
        self.entered[branch] = true;
        match (span.kind, self.regime.states[branch]) {
            (WaveKind::Stiffness, ElementState::Contact(state, _)) => {
                self.regime.states[branch] = ElementState::Contact(state, span.piece());
                self.update_contact_state(branch);
            }
            (WaveKind::Path, _) => {
                let at = self.model.path_at(branch);
                self.regime.pieces[at] = span.piece();
            }
            (WaveKind::Error(wave), _) => {
                self.regime.wave_pieces[branch][wave] = span.piece();
                self.update_contact_state(branch);
            }
            _ => {}
        }
    }

    /// Updates a contact state after a jump of its stiffness or of its geometric error e.
    fn update_contact_state(&mut self, branch: usize) {
        let n = self.model.coordinate_count();
        let b = &self.model.elements[branch];
        let (q, v) = (&self.y[..n], &self.y[n..2 * n]);
        if let (ForceLaw::Contact(contact), ElementState::Contact(state, piece)) =
            (&b.law, self.regime.states[branch])
        {
            let pieces = self.model.error_pieces(Some(&self.regime), branch, self.t);
            let deflection = b.deflection(self.t, q, v, pieces);
            let next = b.contact_state(contact, (self.t, q), deflection, piece);
            self.stats.events += u64::from(next != state);
            self.regime.states[branch] = ElementState::Contact(next, piece);
        }
    }

    /// Releases overloaded stick constraints and solves the massless positions.
    fn settle_friction(&mut self) -> Result<(), Error> {
        let before = self.regime.sticking_pairs().len();
        self.model
            .release_overloaded(&mut self.regime, self.t, &self.y);
        let after = self.regime.sticking_pairs().len();
        self.stats.events += (before - after) as u64;
        if self.model.has_massless() {
            self.solve_massless()?;
        }
        Ok(())
    }

    /// Solves the massless positions; a jump may change contact states.
    fn solve_massless(&mut self) -> Result<(), Error> {
        let n = self.model.coordinate_count();
        for _ in 0..MAX_UPDATES {
            let y = self.model.consistent_state(&self.regime, self.t, &self.y)?;
            let size = y[..n].iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let pairs = y[..n].iter().zip(&self.y[..n]);
            let jumps =
                pairs.fold(0.0f64, |m, (a, b)| m.max((a - b).abs())) > JUMP_TOLERANCE * size;
            self.y = y;
            if !jumps {
                break;
            }
            for branch in 0..self.model.elements.len() {
                self.update_contact_state(branch);
            }
        }
        Ok(())
    }

    /// Projects the velocity on the stick constraints: `v ← v − M⁻¹Wᵀ(W M⁻¹Wᵀ)⁻¹ (W v − ė)`.
    fn project_stick_velocity(&mut self) {
        let n = self.model.coordinate_count();
        let v = self.y[n..2 * n].to_vec();
        let sticking = self.regime.sticking_pairs();
        let momentum: Vec<f64> = self
            .model
            .momentum(&v)
            .iter()
            .map(|p| p * (1.0 + self.model.mass_damping))
            .collect();
        let imposed = |branch: usize| {
            let piece = self.model.imposed_piece(&self.regime, branch) as usize;
            let e = self.model.elements[branch].imposed_displacement.as_ref();
            e.map_or(0.0, |e| e.slope(self.t, piece))
        };
        let impulses = self
            .model
            .constraint_forces(&sticking, &momentum, &v, imposed);
        let mut change = vec![0.0; n];
        for (&at, p) in sticking.iter().zip(impulses) {
            let direction = &self.model.elements[at].direction;
            direction.entries().for_each(|(i, a)| change[i] += a * p);
        }
        self.model.apply_inverse_mass(&mut change);
        for (v, change) in self.y[n..2 * n].iter_mut().zip(change) {
            *v -= change;
        }
    }

    fn chattering_error(&self, surface: SwitchingSurface, y: Vec<f64>) -> Error {
        let name = &self.model.elements[surface.branch(&self.waves)].name;
        let (_, size) = surface.value(self.model, &self.regime, &self.waves, self.t, &y);
        Error::new(
            Code::NoConvergence,
            format!(
                "branch {name} switches back and forth at t = {} without advancing in time (values of size {size:.1e})",
                format_instant(self.t)
            ),
        )
        .with_hint("give it damping, or take a method without events")
    }
}
