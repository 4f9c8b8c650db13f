//! Energy balance of a run: input and dissipated power by Gauss–Kronrod quadrature.
//!
//! Each step interval is divided into panels with the Gauss–Kronrod pair of three and seven points (Kronrod 1965; Piessens et al.,
//! QUADPACK, 1983, sec. 2.2.1); a panel is halved if the difference of the two rules exceeds its tolerance. The difference
//! summed over the run is a conservative error bound of the balance.

use std::cell::RefCell;
use std::rc::Rc;

use super::dynamic_model::DynamicModel;
use super::energy::PowerBalance;
use super::prescribed::PrescribedReduction;
use super::problem::{DenseOutput, Observer};
use super::progress::{clamp_time, will_exceed_budget};
use super::regime::{ElementState, Regime};
use super::wave::{PeriodicFunction, WavePhase};
use crate::base::time_budget::CancelToken;

/// Energy balance over a run, J: `ΔE = work_in − dissipated`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EnergyBalance {
    /// Stored energy at the start.
    pub before: f64,
    /// Stored energy at the end.
    pub after: f64,
    /// Input work.
    pub work_in: f64,
    /// Dissipated energy.
    pub dissipated: f64,
    /// Largest stored energy at any evaluated instant.
    pub peak_stored: f64,
    /// Quadrature error: difference of the two rules over the run.
    pub quadrature_error: f64,
    /// Number of power evaluations.
    pub evaluations: u64,
    /// Fraction of the run at which integration of the powers stopped; absent if it reached the end.
    pub stopped_at: Option<f64>,
}

impl EnergyBalance {
    /// Energy-balance error relative to the largest term.
    pub fn relative_error(&self) -> f64 {
        self.share((self.after - self.before) - self.work_in + self.dissipated)
    }

    /// Quadrature error bound relative to the largest term; absent if integration stopped early.
    pub fn error_bound(&self) -> Option<f64> {
        match self.stopped_at {
            None => Some(self.share(self.quadrature_error)),
            Some(_) => None,
        }
    }

    /// Largest term of the balance, J.
    pub fn size(&self) -> f64 {
        self.peak_stored
            .max(self.work_in.abs())
            .max(self.dissipated.abs())
    }

    fn share(&self, energy: f64) -> f64 {
        match self.size() {
            0.0 => 0.0,
            size => energy / size,
        }
    }
}

/// Abscissae on [−1, 1], Kronrod weights and Gauss weights.
const POINTS: [(f64, f64, f64); 7] = [
    (-0.960_491_268_708_020_3, 0.104_656_226_026_467_27, 0.0),
    (
        -0.774_596_669_241_483_4,
        0.268_488_089_868_333_44,
        5.0 / 9.0,
    ),
    (-0.434_243_749_346_802_6, 0.401_397_414_775_962_2, 0.0),
    (0.0, 0.450_916_538_658_474_1, 8.0 / 9.0),
    (0.434_243_749_346_802_6, 0.401_397_414_775_962_2, 0.0),
    (0.774_596_669_241_483_4, 0.268_488_089_868_333_44, 5.0 / 9.0),
    (0.960_491_268_708_020_3, 0.104_656_226_026_467_27, 0.0),
];

/// Tolerance of a panel relative to the absolute work in it.
const PANEL_TOLERANCE: f64 = 1e-6;

/// Tolerance of the run relative to the largest term, distributed over time.
const TOTAL_TOLERANCE: f64 = 1e-5;

/// Smallest panel relative to the first: an event that the method did not locate lies in it.
const MIN_PANEL: f64 = 1e-6;

/// Maximum number of power evaluations: some seconds for twenty degrees of freedom.
pub const MAX_EVALUATIONS: u64 = 3_000_000;

/// Limit of the integration of the powers.
pub struct BalanceLimit {
    /// Maximum number of power evaluations.
    pub evaluations: u64,
    /// Stop early if the predicted number is far larger.
    pub predicts: bool,
    /// Cancellation token.
    pub cancel: CancelToken,
}

/// Integrator of input and dissipated power over a run.
pub struct EnergyIntegrator {
    model: DynamicModel,
    /// Prescribed motions: the balance is that of the full model, including their input power.
    known: Option<PrescribedReduction>,
    run: [f64; 2],
    limit: BalanceLimit,
    balance: EnergyBalance,
    /// Accumulated difference of the two rules, in input work and in dissipated energy.
    quadrature_error: [f64; 2],
    last: Option<IntervalEnd>,
}

/// State of the full model at an end of an interval.
struct IntervalEnd {
    /// Start of the interval, s.
    from: f64,
    t: f64,
    state: Vec<f64>,
    regime: Regime,
}

/// Quadrature of one panel by both rules, J.
#[derive(Default)]
struct QuadraturePanel {
    work_in: f64,
    dissipated: f64,
    /// Integral of the absolute powers.
    work: f64,
    /// Difference of the two rules.
    quadrature_error: [f64; 2],
}

impl EnergyIntegrator {
    /// Integrator attached to the observer of a run; `run` is its start and end, s.
    pub fn observe(
        model: &DynamicModel,
        known: Option<&PrescribedReduction>,
        run: [f64; 2],
        limit: BalanceLimit,
        observer: &mut Observer,
    ) -> Rc<RefCell<EnergyIntegrator>> {
        let integrator = EnergyIntegrator {
            model: model.clone(),
            known: known.cloned(),
            run,
            limit,
            balance: EnergyBalance::default(),
            quadrature_error: [0.0; 2],
            last: None,
        };
        let integrator = Rc::new(RefCell::new(integrator));
        let observed = Rc::clone(&integrator);
        observer.add(move |interval: DenseOutput| {
            let mut integrator = observed.borrow_mut();
            let before = integrator.balance.evaluations;
            integrator.add_interval(interval);
            integrator.balance.evaluations - before
        });
        integrator
    }

    /// Present energy balance.
    pub fn balance(&self) -> EnergyBalance {
        EnergyBalance {
            quadrature_error: self.quadrature_error[0].abs() + self.quadrature_error[1].abs(),
            ..self.balance
        }
    }

    /// Integrates the powers over one step interval.
    fn add_interval(&mut self, mut interval: DenseOutput) {
        if self.balance.stopped_at.is_some() {
            return;
        }
        let (from, to) = (interval.from, interval.to);
        let mut y = vec![0.0; 2 * self.model.coordinate_count() + self.model.internal_count()];
        let start = self.end_state(&mut interval, from, &mut y);
        let stored = self
            .full_model()
            .mechanical_energy(&start.regime, start.t, &start.state);
        match &self.last {
            None => self.balance.before = stored,
            Some(last) => self.balance.work_in += self.jump_work(last, &start),
        }
        self.track_peak(stored);
        let first = interval.time_scale.min(to - from);
        // Panels also exceed the spacing of floating-point instants.
        let shortest = (MIN_PANEL * first).max(16.0 * f64::EPSILON * to.abs());
        let mut t = from;
        let mut length = first.max(shortest);
        while t < to {
            let end = if t + 1.25 * length < to {
                t + length
            } else {
                to
            };
            let panel = self.panel(&mut interval, [t, end], &mut y);
            let share = (end - t) / (self.run[1] - self.run[0]);
            let allowed =
                PANEL_TOLERANCE * panel.work + TOTAL_TOLERANCE * share * self.balance.size();
            let error = panel.quadrature_error[0].abs() + panel.quadrature_error[1].abs();
            if error > allowed && end - t > shortest {
                length = 0.5 * (end - t);
            } else {
                self.balance.work_in += panel.work_in;
                self.balance.dissipated += panel.dissipated;
                self.quadrature_error[0] += panel.quadrature_error[0];
                self.quadrature_error[1] += panel.quadrature_error[1];
                t = end;
                if error < 0.02 * allowed {
                    length *= 2.0;
                }
            }
            let share = (t - self.run[0]) / (self.run[1] - self.run[0]);
            let (spent, allowed) = (self.balance.evaluations, self.limit.evaluations);
            if spent > allowed
                || self.limit.predicts && will_exceed_budget(spent, allowed, share)
                || self.limit.cancel.should_stop()
            {
                self.balance.stopped_at = Some(share);
                return;
            }
        }
        let end = self.end_state(&mut interval, to, &mut y);
        // A method without event location steps over jumps of stiffness.
        self.balance.work_in += self.stiffness_jump_work(&start.regime, &end);
        self.balance.after = self
            .full_model()
            .mechanical_energy(&end.regime, end.t, &end.state);
        self.track_peak(self.balance.after);
        self.last = Some(end);
    }

    fn full_model(&self) -> &DynamicModel {
        self.known.as_ref().map_or(&self.model, |k| &k.full_model)
    }

    fn track_peak(&mut self, stored: f64) {
        self.balance.peak_stored = self.balance.peak_stored.max(stored.abs());
    }

    /// State of the full model at an instant of an interval, and the input power of prescribed motions, W.
    fn evaluate(&self, interval: &mut DenseOutput, time: f64, y: &mut [f64]) -> (IntervalEnd, f64) {
        // Signals are evaluated inside the interval, not beyond the kinks at its ends.
        let t = clamp_time(time, interval.from, interval.to);
        (interval.state)(time, y);
        let regime = self.model.output_regime(interval.regime, t, y);
        let end_at = |state, regime| IntervalEnd {
            from: interval.from,
            t,
            state,
            regime,
        };
        match &self.known {
            None => (end_at(y.to_vec(), regime.into_owned()), 0.0),
            Some(known) => {
                let state = known.state(t, y);
                let power = known.power(&self.model, &regime, t, y);
                let full = known.regime(&regime, t, &state);
                (end_at(state, full), power)
            }
        }
    }

    fn end_state(&self, interval: &mut DenseOutput, time: f64, y: &mut [f64]) -> IntervalEnd {
        self.evaluate(interval, time, y).0
    }

    fn panel(
        &mut self,
        interval: &mut DenseOutput,
        [from, to]: [f64; 2],
        y: &mut [f64],
    ) -> QuadraturePanel {
        let half = 0.5 * (to - from);
        let mut panel = QuadraturePanel::default();
        let (mut gauss_input, mut gauss_loss) = (0.0, 0.0);
        for (x, kronrod, gauss) in POINTS {
            let (point, imposed) = self.evaluate(interval, from + half * (1.0 + x), y);
            let PowerBalance {
                input,
                dissipated: loss,
            } = self
                .full_model()
                .power_balance(&point.regime, point.t, &point.state);
            let input = input + imposed;
            panel.work_in += half * kronrod * input;
            panel.dissipated += half * kronrod * loss;
            panel.work += half * kronrod * (input.abs() + loss.abs());
            gauss_input += half * gauss * input;
            gauss_loss += half * gauss * loss;
            if x == 0.0 {
                let stored =
                    self.full_model()
                        .mechanical_energy(&point.regime, point.t, &point.state);
                self.track_peak(stored);
            }
        }
        self.balance.evaluations += POINTS.len() as u64;
        panel.quadrature_error = [panel.work_in - gauss_input, panel.dissipated - gauss_loss];
        panel
    }

    /// Input work of piecewise constant stiffness over an angle since the regime `before`, J. The jumps exert no torque, so that
    /// their energy is supplied from outside.
    fn stiffness_jump_work(&self, before: &Regime, end: &IntervalEnd) -> f64 {
        let model = self.full_model();
        let mut old = end.regime.clone();
        for (index, b) in model.elements.iter().enumerate() {
            let wave = b.stiffness_wave.as_ref();
            let is_stepped = |w: &PeriodicFunction| {
                w.phase.angle().is_some() && w.waveform.is_piecewise_constant()
            };
            if let ElementState::Contact(_, piece) = &mut old.states[index]
                && let ElementState::Contact(_, former) = before.states[index]
                && wave.is_some_and(is_stepped)
            {
                *piece = former;
            }
        }
        if old == end.regime {
            return 0.0;
        }
        model.mechanical_energy(&end.regime, end.t, &end.state)
            - model.mechanical_energy(&old, end.t, &end.state)
    }

    /// Input work at the instant between two intervals, J: jumps in time of stiffness, of imposed displacement and of prescribed
    /// speeds, and of stepped stiffness over an angle.
    fn jump_work(&self, last: &IntervalEnd, next: &IntervalEnd) -> f64 {
        let model = self.full_model();
        let impulses = self.known.as_ref();
        let impulses = impulses.map_or(0.0, |known| known.impulse_work(last.from, next.from))
            + self.stiffness_jump_work(&last.regime, next);
        let mut regime = last.regime.clone();
        let imposed = model.forces.len()..model.forces.len() + model.elements.len();
        regime.pieces[imposed.clone()].copy_from_slice(&next.regime.pieces[imposed]);
        for (index, b) in model.elements.iter().enumerate() {
            let wave = b.stiffness_wave.as_ref();
            let imposed_phase = wave.is_some_and(|w| matches!(w.phase, WavePhase::Imposed { .. }));
            if let ElementState::Contact(..) = regime.states[index]
                && (imposed_phase || b.imposed_displacement.is_some())
            {
                regime.states[index] = next.regime.states[index];
            }
        }
        if regime == last.regime {
            return impulses;
        }
        let after = model.mechanical_energy(&regime, next.t, &last.state);
        impulses + after - model.mechanical_energy(&last.regime, last.t, &last.state)
    }
}
