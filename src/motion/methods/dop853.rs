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

/// Stages of the step; the slope at its end and three further stages serve the dense output.
const STEP_STAGES: usize = 12;

/// State of the method between two steps.
pub struct Dop853 {
    control: StepSizeRule,
    scale: ErrorScale,
    /// Next trial step, s; zero before the first step.
    next: f64,
    /// Stage slopes of the last step.
    slopes: Vec<Vec<f64>>,
    /// Time, s, and state of the first slope; absent after a restart.
    start: Option<(f64, Vec<f64>)>,
    /// Time, s, and state of the slope at the end of the step.
    end: Option<(f64, Vec<f64>)>,
    /// Coefficients of the dense output.
    dense: Vec<Vec<f64>>,
    /// Earliest time at which f may be evaluated, s: that of the last restart.
    t_min: f64,
}

impl Dop853 {
    /// Method before the first step.
    pub fn new(control: StepSizeRule, scale: ErrorScale) -> Dop853 {
        Dop853 {
            control,
            scale,
            next: 0.0,
            slopes: vec![Vec::new(); 16],
            start: None,
            end: None,
            dense: vec![Vec::new(); 8],
            t_min: f64::NEG_INFINITY,
        }
    }

    fn sum(&self, sum: StageWeights, i: usize) -> f64 {
        sum.iter().map(|&(j, a)| a * self.slopes[j][i]).sum()
    }

    /// State at a stage.
    fn stage(&self, index: usize, y: &[f64], h: f64) -> Vec<f64> {
        (0..y.len())
            .map(|i| y[i] + h * self.sum(STAGES[index], i))
            .collect()
    }

    /// Error estimate of the step from `y` to `end`, relative to the tolerance.
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

    /// Initial step from the norms of the state and its slope, s.
    fn initial_step(&self, y: &[f64], span: f64) -> f64 {
        let sizes = self.scale.sizes(y, y, 1e-3 * span);
        let (state, slope) = (error_norm(y, &sizes), error_norm(&self.slopes[0], &sizes));
        let guess = 0.01 * state / slope;
        match guess > 0.0 && guess.is_finite() {
            true => guess.min(1e-2 * span),
            false => 1e-6 * span,
        }
        .max(1e-12 * span)
    }

    fn prepare_dense_output<P: OdeProblem>(
        &mut self,
        problem: &P,
        clock: impl Fn(f64) -> f64,
        (t, y): (f64, &[f64]),
        h: f64,
        end: &[f64],
    ) {
        for index in STEP_STAGES + 1..16 {
            let state = self.stage(index, y, h);
            problem.derivative(clock(t + NODES[index] * h), &state, &mut self.slopes[index]);
        }
        let n = y.len();
        let difference: Vec<f64> = (0..n).map(|i| end[i] - y[i]).collect();
        let rise: Vec<f64> = (0..n)
            .map(|i| h * self.slopes[0][i] - difference[i])
            .collect();
        let fall = (0..n)
            .map(|i| difference[i] - h * self.slopes[STEP_STAGES][i] - rise[i])
            .collect();
        for (index, &sum) in DENSE.iter().enumerate() {
            self.dense[4 + index] = (0..n).map(|i| h * self.sum(sum, i)).collect();
        }
        self.dense[0] = y.to_vec();
        self.dense[1] = difference;
        self.dense[2] = rise;
        self.dense[3] = fall;
    }
}

impl<P: OdeProblem> Stepper<P> for Dop853 {
    fn restart(&mut self) {
        self.start = None;
        self.end = None;
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
        if self.start.is_none() {
            self.t_min = t;
        }
        let t_min = self.t_min;
        let clock = move |t: f64| clamp_time(t, t_min, end);
        let is_at = |point: &Option<(f64, Vec<f64>)>| {
            point.as_ref().is_some_and(|(u, x)| *u == t && x == y)
        };
        if is_at(&self.end) {
            self.slopes.swap(0, STEP_STAGES);
            self.start = self.end.take();
        } else if !is_at(&self.start) {
            problem.derivative(clock(t), y, &mut self.slopes[0]);
            stats.evaluations += 1;
            self.start = Some((t, y.to_vec()));
            self.scale.update(y);
        }
        let span = end - t;
        let proposed = match self.control {
            StepSizeRule::Fixed(h) => equal_step(span, h),
            StepSizeRule::Tolerance(_) if self.next > 0.0 => self.next,
            StepSizeRule::Tolerance(_) => self.initial_step(y, span),
        };
        let mut h = proposed.min(span);
        let mut rejected = false;
        loop {
            if !(h > 4.0 * f64::EPSILON * t.abs() && h > 0.0) && h < span {
                return Err(Error::new(
                    Code::NoConvergence,
                    format!("no step from t = {} keeps the error within the tolerance", format_instant(t)),
                )
                .with_hint("the motion is stiff or jumps there: take a method for stiff machines, or a coarser tolerance"));
            }
            for index in 1..STEP_STAGES {
                let state = self.stage(index, y, h);
                problem.derivative(clock(t + NODES[index] * h), &state, &mut self.slopes[index]);
            }
            stats.evaluations += STEP_STAGES as u64 - 1;
            let reached = self.stage(STEP_STAGES, y, h);
            let error = match self.control {
                StepSizeRule::Fixed(_) => 0.0,
                StepSizeRule::Tolerance(tolerance) => self.error(y, &reached, h, tolerance),
            };
            let factor = 0.9 * error.powf(-0.125);
            if error < 1.0 {
                let u = if h == span { end } else { t + h };
                problem.derivative(clock(u), &reached, &mut self.slopes[STEP_STAGES]);
                self.prepare_dense_output(problem, clock, (t, y), h, &reached);
                stats.evaluations += 4;
                let next = h * factor.clamp(0.3, if rejected { 1.0 } else { 6.0 });
                // A step shortened to the end of the interval does not limit the next one.
                self.next = match h == span {
                    true => next.max(self.next),
                    false => next,
                };
                self.scale.update(&reached);
                self.end = Some((u, reached.clone()));
                return Ok((u, reached));
            }
            stats.rejected += 1;
            rejected = true;
            h *= match error.is_finite() {
                true => factor.clamp(0.2, 0.95),
                false => 0.1,
            };
            self.next = h;
        }
    }

    fn interpolate(&self, theta: f64, y: &mut [f64]) {
        let eta = 1.0 - theta;
        let c = &self.dense;
        for i in 0..y.len() {
            let tail = c[4][i] + (c[5][i] + (c[6][i] + c[7][i] * theta) * eta) * theta;
            y[i] = c[0][i] + (c[1][i] + (c[2][i] + (c[3][i] + tail * eta) * theta) * eta) * theta;
        }
    }
}
