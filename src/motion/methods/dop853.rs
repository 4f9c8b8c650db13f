//! Dormand and Prince's explicit method of order 8 with error control and a dense output of order 7.
//!
//! Source: Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, 2nd edition 1993, II.5 and II.10.

use super::dop853_table::{DENSE, FIFTH, NODES, STAGES, StageWeights, THIRD};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_instant;
use crate::motion::error_scale::{ErrorScale, error_norm};
use crate::motion::problem::{IntegrationStats, OdeProblem};
use crate::motion::progress::clamp_time;
use crate::motion::stepper::{StepSizeRule, Stepper, equal_step};

/// Stages of the step itself; the slope at its end and three more serve the dense output.
const STEP_STAGES: usize = 12;

/// The method between two steps.
pub struct Dop853 {
    control: StepSizeRule,
    scale: ErrorScale,
    /// The step to try next, s; zero where none is known.
    next: f64,
    /// Slopes of the last step.
    slopes: Vec<Vec<f64>>,
    /// The instant and state the first slope belongs to; absent after a restart.
    known: Option<(f64, Vec<f64>)>,
    /// The same of the slope at the end of the step.
    ended: Option<(f64, Vec<f64>)>,
    /// Coefficients of the dense output.
    inner: Vec<Vec<f64>>,
    /// Earliest instant at which f may be evaluated: between the restart and the end of its interval.
    since: f64,
}

impl Dop853 {
    /// Before the first step.
    pub fn new(control: StepSizeRule, scale: ErrorScale) -> Dop853 {
        Dop853 {
            control,
            scale,
            next: 0.0,
            slopes: vec![Vec::new(); 16],
            known: None,
            ended: None,
            inner: vec![Vec::new(); 8],
            since: f64::NEG_INFINITY,
        }
    }

    fn sum(&self, sum: StageWeights, i: usize) -> f64 {
        sum.iter().map(|&(j, a)| a * self.slopes[j][i]).sum()
    }

    /// The state at a stage.
    fn stage(&self, at: usize, y: &[f64], h: f64) -> Vec<f64> {
        (0..y.len())
            .map(|i| y[i] + h * self.sum(STAGES[at], i))
            .collect()
    }

    /// The error of the step to `end`, relative to the tolerance.
    fn error(&self, y: &[f64], end: &[f64], h: f64, tolerance: f64) -> f64 {
        let sizes = self.scale.sizes(y, end, h);
        let errors =
            |sum: StageWeights| -> Vec<f64> { (0..y.len()).map(|i| self.sum(sum, i)).collect() };
        let (fifth, third) = (
            error_norm(&errors(FIFTH), &sizes),
            error_norm(&errors(THIRD), &sizes),
        );
        if fifth == 0.0 && third == 0.0 {
            return 0.0;
        }
        h * fifth * fifth / (fifth * fifth + 0.01 * third * third).sqrt() / tolerance
    }

    /// A first step from the sizes of the state and its slope, s.
    fn first(&self, y: &[f64], left: f64) -> f64 {
        let sizes = self.scale.sizes(y, y, 1e-3 * left);
        let (state, slope) = (error_norm(y, &sizes), error_norm(&self.slopes[0], &sizes));
        let sensible = 0.01 * state / slope;
        match sensible > 0.0 && sensible.is_finite() {
            true => sensible.min(1e-2 * left),
            false => 1e-6 * left,
        }
        .max(1e-12 * left)
    }

    fn prepare_dense_output<P: OdeProblem>(
        &mut self,
        problem: &P,
        clock: impl Fn(f64) -> f64,
        (t, y): (f64, &[f64]),
        h: f64,
        end: &[f64],
    ) {
        for at in STEP_STAGES + 1..16 {
            let state = self.stage(at, y, h);
            problem.derivative(clock(t + NODES[at] * h), &state, &mut self.slopes[at]);
        }
        let n = y.len();
        let difference: Vec<f64> = (0..n).map(|i| end[i] - y[i]).collect();
        let rise: Vec<f64> = (0..n)
            .map(|i| h * self.slopes[0][i] - difference[i])
            .collect();
        let fall = (0..n)
            .map(|i| difference[i] - h * self.slopes[STEP_STAGES][i] - rise[i])
            .collect();
        for (at, &sum) in DENSE.iter().enumerate() {
            self.inner[4 + at] = (0..n).map(|i| h * self.sum(sum, i)).collect();
        }
        self.inner[0] = y.to_vec();
        self.inner[1] = difference;
        self.inner[2] = rise;
        self.inner[3] = fall;
    }
}

impl<P: OdeProblem> Stepper<P> for Dop853 {
    fn restart(&mut self) {
        self.known = None;
        self.ended = None;
    }

    fn step(
        &mut self,
        problem: &P,
        (t, y): (f64, &[f64]),
        end: f64,
        stats: &mut IntegrationStats,
    ) -> Result<(f64, Vec<f64>), Error> {
        let n = y.len();
        self.slopes.iter_mut().for_each(|s| s.resize(n, 0.0));
        if self.known.is_none() {
            self.since = t;
        }
        let since = self.since;
        let clock = move |t: f64| clamp_time(t, since, end);
        let here = |known: &Option<(f64, Vec<f64>)>| {
            known.as_ref().is_some_and(|(u, x)| *u == t && x == y)
        };
        if here(&self.ended) {
            self.slopes.swap(0, STEP_STAGES);
            self.known = self.ended.take();
        } else if !here(&self.known) {
            problem.derivative(clock(t), y, &mut self.slopes[0]);
            stats.evaluations += 1;
            self.known = Some((t, y.to_vec()));
            self.scale.update(y);
        }
        let left = end - t;
        let wanted = match self.control {
            StepSizeRule::Fixed(h) => equal_step(left, h),
            StepSizeRule::Tolerance(_) if self.next > 0.0 => self.next,
            StepSizeRule::Tolerance(_) => self.first(y, left),
        };
        let mut h = wanted.min(left);
        let mut refused = false;
        loop {
            if !(h > 4.0 * f64::EPSILON * t.abs() && h > 0.0) && h < left {
                return Err(Error::new(
                    Code::NoConvergence,
                    format!("no step from t = {} keeps the error within the tolerance", format_instant(t)),
                )
                .with_hint("the motion is too stiff or jumps there: take a method for stiff machines, or a coarser tolerance"));
            }
            for at in 1..STEP_STAGES {
                let state = self.stage(at, y, h);
                problem.derivative(clock(t + NODES[at] * h), &state, &mut self.slopes[at]);
            }
            stats.evaluations += STEP_STAGES as u64 - 1;
            let reached = self.stage(STEP_STAGES, y, h);
            let error = match self.control {
                StepSizeRule::Fixed(_) => 0.0,
                StepSizeRule::Tolerance(tolerance) => self.error(y, &reached, h, tolerance),
            };
            let factor = 0.9 * error.powf(-0.125);
            if error < 1.0 {
                let u = if h == left { end } else { t + h };
                problem.derivative(clock(u), &reached, &mut self.slopes[STEP_STAGES]);
                self.prepare_dense_output(problem, clock, (t, y), h, &reached);
                stats.evaluations += 4;
                let grown = h * factor.clamp(0.3, if refused { 1.0 } else { 6.0 });
                // A step cut short by the end says nothing against a longer one.
                self.next = match h == left {
                    true => grown.max(self.next),
                    false => grown,
                };
                self.scale.update(&reached);
                self.ended = Some((u, reached.clone()));
                return Ok((u, reached));
            }
            stats.rejected += 1;
            refused = true;
            h *= match error.is_finite() {
                true => factor.clamp(0.2, 0.95),
                false => 0.1,
            };
            self.next = h;
        }
    }

    fn interpolate(&self, theta: f64, y: &mut [f64]) {
        let rest = 1.0 - theta;
        let c = &self.inner;
        for i in 0..y.len() {
            let tail = c[4][i] + (c[5][i] + (c[6][i] + c[7][i] * theta) * rest) * theta;
            y[i] = c[0][i] + (c[1][i] + (c[2][i] + (c[3][i] + tail * rest) * theta) * rest) * theta;
        }
    }
}
