//! Energy balance of a run: input and dissipated power by Gauss–Kronrod quadrature.
//!
//! Each stretch is gone through in panels of Gauss's three points with Kronrod's four between them (Kronrod 1965; Piessens et al.,
//! QUADPACK, 1983, sec. 2.2.1); where the two rules differ by more than is allowed the panel is halved. What their sums differ by
//! over the run bounds by far what the better one is off by, so the balance says how well it is known.

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

/// The balance over a run, J.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EnergyBalance {
    /// Stored at the start.
    pub before: f64,
    /// Stored at the end.
    pub after: f64,
    /// Put in.
    pub work_in: f64,
    /// Lost.
    pub dissipated: f64,
    /// The largest energy stored at any instant looked at.
    pub peak_stored: f64,
    /// Quadrature error: difference of the two rules over the run.
    pub quadrature_error: f64,
    /// Readings of the powers.
    pub evaluations: u64,
    /// Share of the run at which integration of the powers stopped; absent where it reached the end.
    pub stopped_at: Option<f64>,
}

impl EnergyBalance {
    /// Energy-balance error, as a share of the largest of all parts.
    pub fn relative_error(&self) -> f64 {
        self.share((self.after - self.before) - self.work_in + self.dissipated)
    }

    /// Error bound of the gap; absent where the powers were not integrated to the end.
    pub fn error_bound(&self) -> Option<f64> {
        match self.stopped_at {
            None => Some(self.share(self.quadrature_error)),
            Some(_) => None,
        }
    }

    /// The largest of all parts, J.
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

/// Kronrod's seven points from −1 to 1, with their weights and Gauss's.
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

/// Tolerated difference of the two rules in a panel, as a share of the work done to and fro in it.
const PANEL_TOLERANCE: f64 = 1e-6;

/// And of the largest part of the balance, shared out over the run.
const TOTAL_TOLERANCE: f64 = 1e-5;

/// A panel is not made shorter than this share of the first: a switch that the method stepped over lies in it.
const MIN_PANEL: f64 = 1e-6;

/// Readings of the powers after which adding up is given up: some seconds for twenty degrees of freedom.
pub const MAX_EVALUATIONS: u64 = 3_000_000;

/// Limit of the integration of the powers.
pub struct BalanceLimit {
    /// After so many readings.
    pub evaluations: u64,
    /// Or before, where it would take far more.
    pub predicts: bool,
    /// Or once this is due.
    pub cancel: CancelToken,
}

/// Adds up the powers of a run.
pub struct EnergyIntegrator {
    model: DynamicModel,
    /// Prescribed motions: with them the whole machine is balanced, with the power that keeps them up.
    known: Option<PrescribedReduction>,
    run: [f64; 2],
    limit: BalanceLimit,
    balance: EnergyBalance,
    /// Accumulated difference of the two rules, in input work and in dissipated energy.
    quadrature_error: [f64; 2],
    last: Option<IntervalEnd>,
}

/// The whole machine at an end of an interval.
struct IntervalEnd {
    /// Start of the interval, s.
    from: f64,
    t: f64,
    state: Vec<f64>,
    regime: Regime,
}

/// Results of the two rules in a panel.
#[derive(Default)]
struct QuadraturePanel {
    work_in: f64,
    dissipated: f64,
    /// Work from the absolute values of both.
    work: f64,
    /// Difference of the two rules.
    quadrature_error: [f64; 2],
}

impl EnergyIntegrator {
    /// An integrator that observes a run of a machine from one instant to another, s.
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
        let along = Rc::clone(&integrator);
        observer.add(move |interval: DenseOutput| {
            let mut integrator = along.borrow_mut();
            let before = integrator.balance.evaluations;
            integrator.add_interval(interval);
            integrator.balance.evaluations - before
        });
        integrator
    }

    /// The balance so far.
    pub fn balance(&self) -> EnergyBalance {
        EnergyBalance {
            quadrature_error: self.quadrature_error[0].abs() + self.quadrature_error[1].abs(),
            ..self.balance
        }
    }

    /// Adds one more interval.
    fn add_interval(&mut self, mut interval: DenseOutput) {
        if self.balance.stopped_at.is_some() {
            return;
        }
        let (from, to) = (interval.from, interval.to);
        let mut y = vec![0.0; 2 * self.model.coordinate_count() + self.model.internal_count()];
        let start = self.place(&mut interval, from, &mut y);
        let stored = self
            .whole()
            .mechanical_energy(&start.regime, start.t, &start.state);
        match &self.last {
            None => self.balance.before = stored,
            Some(last) => self.balance.work_in += self.jump_work(last, &start),
        }
        self.track_peak(stored);
        let first = interval.time_scale.min(to - from);
        // Nor is one shorter than its instants can be distinguished.
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
            let off = panel.quadrature_error[0].abs() + panel.quadrature_error[1].abs();
            if off > allowed && end - t > shortest {
                length = 0.5 * (end - t);
            } else {
                self.balance.work_in += panel.work_in;
                self.balance.dissipated += panel.dissipated;
                self.quadrature_error[0] += panel.quadrature_error[0];
                self.quadrature_error[1] += panel.quadrature_error[1];
                t = end;
                if off < 0.02 * allowed {
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
        let end = self.place(&mut interval, to, &mut y);
        // A method that locates nothing steps over jumps of stiffness.
        self.balance.work_in += self.stiffness_jump_work(&start.regime, &end);
        self.balance.after = self
            .whole()
            .mechanical_energy(&end.regime, end.t, &end.state);
        self.track_peak(self.balance.after);
        self.last = Some(end);
    }

    fn whole(&self) -> &DynamicModel {
        self.known.as_ref().map_or(&self.model, |k| &k.whole)
    }

    fn track_peak(&mut self, stored: f64) {
        self.balance.peak_stored = self.balance.peak_stored.max(stored.abs());
    }

    /// The whole machine at an instant of an interval, and what its prescribed motions put in, W.
    fn evaluate(&self, interval: &mut DenseOutput, at: f64, y: &mut [f64]) -> (IntervalEnd, f64) {
        // Nothing is looked up on the far sides of the kinks at its ends.
        let t = clamp_time(at, interval.from, interval.to);
        (interval.state)(at, y);
        let regime = self.model.output_regime(interval.regime, t, y);
        let place = |state, regime| IntervalEnd {
            from: interval.from,
            t,
            state,
            regime,
        };
        match &self.known {
            None => (place(y.to_vec(), regime.into_owned()), 0.0),
            Some(known) => {
                let state = known.state(t, y);
                let power = known.power(&self.model, &regime, t, y);
                let whole = known.regime(&regime, t, &state);
                (place(state, whole), power)
            }
        }
    }

    fn place(&self, interval: &mut DenseOutput, at: f64, y: &mut [f64]) -> IntervalEnd {
        self.evaluate(interval, at, y).0
    }

    fn panel(
        &mut self,
        interval: &mut DenseOutput,
        [from, to]: [f64; 2],
        y: &mut [f64],
    ) -> QuadraturePanel {
        let half = 0.5 * (to - from);
        let mut panel = QuadraturePanel::default();
        let (mut put_in, mut lost) = (0.0, 0.0);
        for (x, kronrod, gauss) in POINTS {
            let (span, driven) = self.evaluate(interval, from + half * (1.0 + x), y);
            let PowerBalance {
                input: given,
                dissipated: taken,
            } = self
                .whole()
                .power_balance(&span.regime, span.t, &span.state);
            let given = given + driven;
            panel.work_in += half * kronrod * given;
            panel.dissipated += half * kronrod * taken;
            panel.work += half * kronrod * (given.abs() + taken.abs());
            put_in += half * gauss * given;
            lost += half * gauss * taken;
            if x == 0.0 {
                let stored = self
                    .whole()
                    .mechanical_energy(&span.regime, span.t, &span.state);
                self.track_peak(stored);
            }
        }
        self.balance.evaluations += POINTS.len() as u64;
        panel.quadrature_error = [panel.work_in - put_in, panel.dissipated - lost];
        panel
    }

    /// Work put in by piecewise constant stiffness over an angle up to a place, J, since the regime `before`. Its jumps turn nothing, so
    /// that
    /// the energy they bring comes from outside.
    fn stiffness_jump_work(&self, before: &Regime, now: &IntervalEnd) -> f64 {
        let model = self.whole();
        let mut old = now.regime.clone();
        for (at, b) in model.elements.iter().enumerate() {
            let wave = b.stiffness_wave.as_ref();
            let over_an_angle = |w: &PeriodicFunction| {
                w.phase.angle().is_some() && w.waveform.is_piecewise_constant()
            };
            if let ElementState::Contact(_, piece) = &mut old.states[at]
                && let ElementState::Contact(_, former) = before.states[at]
                && wave.is_some_and(over_an_angle)
            {
                *piece = former;
            }
        }
        if old == now.regime {
            return 0.0;
        }
        model.mechanical_energy(&now.regime, now.t, &now.state)
            - model.mechanical_energy(&old, now.t, &now.state)
    }

    /// Input work at the instant between two intervals, J: by stiffness or imposed e that jump in time, by stiffness in steps over an
    /// angle, and by prescribed speeds that jump.
    fn jump_work(&self, last: &IntervalEnd, next: &IntervalEnd) -> f64 {
        let model = self.whole();
        let jolts = self.known.as_ref();
        let jolts = jolts.map_or(0.0, |known| known.impulse_work(last.from, next.from))
            + self.stiffness_jump_work(&last.regime, next);
        let mut regime = last.regime.clone();
        let imposed = model.forces.len()..model.forces.len() + model.elements.len();
        regime.pieces[imposed.clone()].copy_from_slice(&next.regime.pieces[imposed]);
        for (at, b) in model.elements.iter().enumerate() {
            let wave = b.stiffness_wave.as_ref();
            let of_itself = wave.is_some_and(|w| matches!(w.phase, WavePhase::Imposed { .. }));
            if let ElementState::Contact(..) = regime.states[at]
                && (of_itself || b.imposed_displacement.is_some())
            {
                regime.states[at] = next.regime.states[at];
            }
        }
        if regime == last.regime {
            return jolts;
        }
        let after = model.mechanical_energy(&regime, next.t, &last.state);
        jolts + after - model.mechanical_energy(&last.regime, last.t, &last.state)
    }
}
