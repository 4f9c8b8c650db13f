//! Trajectory of one segment: motion in a regime from a start state, with event functions.

use super::double_time::DoubleTime;
use super::event_evaluator::LANES;
use super::event_function::EventFunction;
use super::mass_normalised::dot;
use super::regime_system::RegimeSystem;
use super::run_context::RunContext;
use super::trajectory::{ModalTrajectory, Propagator};
use crate::numeric::Matrix;
use crate::numeric::vector_ops::axpy;

/// A motion; used again for the next, so that nothing is allocated on the way.
#[derive(Debug, Default)]
pub struct SegmentTrajectory {
    /// The motion of the parts.
    pub trajectory: ModalTrajectory,
    /// q and q̇ that sticking pairs keep.
    kept: [Vec<f64>; 2],
    events: Vec<EventStart>,
    /// When it started, s.
    pub epoch: f64,
    /// Longest horizon of the bounds in one evaluation, s.
    pub max_horizon: f64,
    push: [Vec<f64>; 2],
    given: Vec<f64>,
    carried: Vec<f64>,
    /// Sums of every event evaluator.
    sums: Vec<[f64; LANES]>,
    block: Option<StateBlock>,
}

/// A switching surface in a motion.
#[derive(Debug, Clone, Default)]
struct EventStart {
    /// Constant and slope of what is not σ.
    base: [f64; 2],
    /// Constant and slope of what ṗ has next to the row of σ.
    push: [f64; 2],
    /// Computed value of p at the start, where it is known to be zero.
    offset: f64,
    /// It is zero at the start.
    zero: bool,
    /// Rounding of p.
    noise: f64,
}

/// A switching surface at an instant.
#[derive(Debug, Clone, Copy, Default)]
pub struct EventValue {
    /// p.
    pub value: f64,
    /// ṗ.
    pub rate: f64,
    /// p̈; no number where only a bound is known.
    pub second_rate: f64,
    /// A bound on |p̈| from there on.
    pub bound: f64,
    /// A bound on the third derivative from there on; ∞ where none is known.
    pub jerk: f64,
}

/// States that are read off together.
#[derive(Debug)]
struct StateBlock {
    sigma: Matrix,
    states: Matrix,
}

/// Number of states evaluated together.
pub const BLOCK: usize = 64;

impl SegmentTrajectory {
    /// Starts at the state y; `span` is how long it is wanted for at most, `crossed` the switching surface that was crossed
    /// into the regime.
    #[allow(clippy::too_many_arguments)]
    pub fn start(
        &mut self,
        context: &RunContext,
        system: &RegimeSystem,
        (now, pieces): (DoubleTime, &[u32]),
        y: &[f64],
        span: f64,
        crossed: Option<&EventFunction>,
    ) {
        let n = context.model.coordinate_count();
        let growth = system.linear.parts.growth;
        self.epoch = now.high;
        self.max_horizon = match growth > 0.0 {
            true => span.min(std::f64::consts::LN_2 / growth),
            false => span,
        };
        self.given.clear();
        self.given.extend_from_slice(y);
        for &omega in &context.inputs.frequencies {
            let (angle, rest) = now.phase(omega);
            let (s, c) = angle.sin_cos();
            self.given.extend([c - s * rest, s + c * rest]);
        }
        let turns = &self.given[y.len()..];
        let sigma = &mut self.trajectory.sigma;
        sigma.clear();
        sigma.extend_from_slice(turns);
        sigma.resize(turns.len() + system.linear.to_parts.n_rows(), 0.0);
        let enter = &system.linear.to_parts;
        enter.mul_vec(&self.given, &mut sigma[turns.len()..]);

        let first = turns.len();
        let [b0, b1] = &mut self.push;
        b0.clone_from(&system.load.push);
        b1.clear();
        b1.resize(b0.len(), 0.0);
        for &input in &system.load.rising {
            let (line, slope) = context.inputs.list[input].line(pieces, now);
            let [value, rate] = &system.linear.pushes[input];
            axpy(b0, line, value);
            axpy(b0, slope, rate);
            axpy(b1, slope, value);
        }
        if let Some(hold) = &system.linear.stick {
            let [place, rate] = &mut self.kept;
            place.clear();
            place.extend_from_slice(&y[..n]);
            // What modes do not carry of it.
            self.carried.resize(y.len(), 0.0);
            system
                .linear
                .from_parts
                .mul_vec(&self.trajectory.sigma, &mut self.carried);
            axpy(place, -1.0, &self.carried[..n]);
            rate.resize(n, 0.0);
            let slope = |branch: usize| {
                let e = &context.model.elements[branch].imposed_displacement;
                let piece = pieces[context.model.forces.len() + branch];
                e.as_ref()
                    .map_or(0.0, |e| e.slope(now.high, piece as usize))
            };
            hold.imposed_velocity(slope, rate);
            let (b0, b1) = (&mut b0[first..], &mut b1[first..]);
            for k in 0..n {
                axpy(b0, place[k], hold.from_displacement.col_as_slice(k));
                axpy(b0, rate[k], hold.from_velocity.col_as_slice(k));
                axpy(b1, rate[k], hold.from_displacement.col_as_slice(k));
            }
        }
        let [b0, b1] = &self.push;
        self.trajectory.start(&system.linear.parts, (b0, b1), span);
        self.start_events(context, system, (now, pieces), span, crossed);
    }

    fn start_events(
        &mut self,
        context: &RunContext,
        system: &RegimeSystem,
        (now, pieces): (DoubleTime, &[u32]),
        span: f64,
        crossed: Option<&EventFunction>,
    ) {
        let [b0, b1] = &self.push;
        self.events.clear();
        let load = &system.load;
        let steady = load.rising.is_empty() && system.linear.stick.is_none();
        for (event, still) in system.events.iter().zip(&load.events) {
            let (mut base, mut slope, mut size) = (still.base, 0.0, still.size);
            let rises = |direct: &&(usize, [f64; 2])| load.rising.contains(&direct.0);
            for &(input, [value, rate]) in event.direct.iter().filter(rises) {
                let (line, change) = context.inputs.list[input].line(pieces, now);
                base += value * line + rate * change;
                slope += value * change;
                size += (value * line).abs() + (rate * change).abs();
            }
            if let Some([place, rate]) = &event.dense {
                let (by_place, by_rate) = (dot(place, &self.kept[0]), dot(rate, &self.kept[1]));
                base += by_place + by_rate;
                slope += dot(place, &self.kept[1]);
                size += by_place.abs() + by_rate.abs();
            }
            let parts = dot(&event.sizes, &self.trajectory.sizes);
            const ROUNDING_TOLERANCE: f64 = 4.0 * f64::EPSILON;
            let zero = crossed.is_some_and(|crossed| event.is_reverse_of(crossed));
            self.events.push(EventStart {
                base: [base, slope],
                push: match steady {
                    true => [still.push, 0.0],
                    false => [slope + dot(&event.row, b0), dot(&event.row, b1)],
                },
                offset: match zero {
                    true => base + dot(&event.row, &self.trajectory.sigma),
                    false => 0.0,
                },
                zero,
                noise: ROUNDING_TOLERANCE * (size + (slope * span).abs() + parts),
            });
        }
    }

    /// Goes to τ, exactly.
    pub fn move_to(&mut self, system: &RegimeSystem, tau: f64) {
        if tau != self.trajectory.tau || !self.trajectory.is_exact() {
            self.trajectory
                .move_to(&system.linear.parts, &system.unused_parts, tau);
        }
    }

    /// Goes on by a stride.
    pub fn stride(&mut self, system: &RegimeSystem, stride: &Propagator) {
        let tau = self.trajectory.tau + stride.span;
        let parts = &system.linear.parts;
        self.trajectory
            .advance(parts, &system.unused_parts, stride, tau);
    }

    /// The same from a τ nearby, where the way is short.
    pub fn shift_to(&mut self, system: &RegimeSystem, tau: f64) {
        if !self
            .trajectory
            .shift_to(&system.linear.parts, &system.unused_parts, tau)
        {
            self.move_to(system, tau);
        }
    }

    /// Reads all evaluators where the motion is; bounds hold from there on for `horizon` seconds at most.
    pub fn evaluate_events(&mut self, system: &RegimeSystem, horizon: f64) {
        self.sums.resize(system.evaluators.len(), [0.0; LANES]);
        for evaluator in 0..system.evaluators.len() {
            self.evaluate(system, evaluator, horizon);
        }
    }

    /// The same of one switching surface's evaluator alone.
    pub fn evaluate_event(
        &mut self,
        system: &RegimeSystem,
        event: usize,
        horizon: f64,
    ) -> EventValue {
        self.evaluate(system, system.events[event].evaluator, horizon);
        self.event_value(system, event)
    }

    fn evaluate(&mut self, system: &RegimeSystem, evaluator: usize, horizon: f64) {
        let (parts, own) = (&system.linear.parts, &system.evaluators[evaluator]);
        self.sums[evaluator] = self
            .trajectory
            .evaluate(parts, &system.unused_parts, horizon, own);
    }

    /// A switching surface where the motion was looked at.
    pub fn event_value(&self, system: &RegimeSystem, at: usize) -> EventValue {
        let (event, state) = (&system.events[at], &self.events[at]);
        let tau = self.trajectory.tau;
        let [p, v, q, w, a, b, bound, jerk] = self.sums[event.evaluator];
        let sign = event.sign;
        let (bend, jerk) = match system.linear.parts.has_exact_accelerations() {
            true => (sign * (a + b), jerk),
            false => (f64::NAN, f64::INFINITY),
        };
        EventValue {
            value: match state.zero && tau == 0.0 {
                true => 0.0,
                false => state.base[0] + state.base[1] * tau - state.offset + sign * (p + q),
            },
            rate: state.push[0] + state.push[1] * tau + sign * (v + w),
            second_rate: bend,
            bound,
            jerk,
        }
    }

    /// Rounding of p.
    pub fn noise(&self, at: usize) -> f64 {
        self.events[at].noise
    }

    /// Whether a switching surface is zero at the start.
    pub fn is_zero_at_start(&self, at: usize) -> bool {
        self.events[at].zero
    }

    /// The state y where the motion is.
    pub fn state(&mut self, system: &RegimeSystem, y: &mut [f64]) {
        self.trajectory
            .update_unused(&system.linear.parts, &system.unused_parts);
        system.linear.from_parts.mul_vec(&self.trajectory.sigma, y);
        self.keep(system, self.trajectory.tau, y);
    }

    /// The states at some times, at most [`BLOCK`], where equal ones by strides; `give` may end it early.
    pub fn states(
        &mut self,
        system: &RegimeSystem,
        stride: Option<&Propagator>,
        times: &[f64],
        mut give: impl FnMut(usize, &[f64]) -> bool,
    ) -> bool {
        if let ([tau], None) = (times, stride) {
            self.move_to(system, *tau);
            let mut y = std::mem::take(&mut self.carried);
            y.resize(system.linear.from_parts.n_rows(), 0.0);
            self.state(system, &mut y);
            let ended = give(0, &y);
            self.carried = y;
            return ended;
        }
        let (rows, states) = (
            system.linear.from_parts.n_columns(),
            system.linear.from_parts.n_rows(),
        );
        let mut block = match self.block.take() {
            Some(block) if block.sigma.nrows() == rows => block,
            _ => StateBlock {
                sigma: Matrix::zeros(rows, BLOCK),
                states: Matrix::zeros(states, BLOCK),
            },
        };
        let (parts, unseen) = (&system.linear.parts, &system.unused_parts);
        for (at, &tau) in times.iter().enumerate() {
            match stride {
                Some(stride) if at > 0 => self.trajectory.advance(parts, unseen, stride, tau),
                _ => self.trajectory.move_to(parts, unseen, tau),
            }
            self.trajectory.update_unused(parts, unseen);
            let column = block.sigma.col_as_slice_mut(at);
            column.copy_from_slice(&self.trajectory.sigma);
        }
        let leave = &system.linear.from_parts;
        leave.mul_leading_columns(&block.sigma, times.len(), &mut block.states);
        let ended = times.iter().enumerate().any(|(at, &tau)| {
            let y = block.states.col_as_slice_mut(at);
            self.keep(system, tau, y);
            give(at, y)
        });
        self.block = Some(block);
        ended
    }

    /// Adds what sticking pairs keep.
    fn keep(&self, system: &RegimeSystem, tau: f64, y: &mut [f64]) {
        if system.linear.stick.is_none() {
            return;
        }
        let n = self.kept[0].len();
        let (q, v) = y.split_at_mut(n);
        axpy(q, 1.0, &self.kept[0]);
        axpy(q, tau, &self.kept[1]);
        axpy(v, 1.0, &self.kept[1]);
    }
}
