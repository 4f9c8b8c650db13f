//! Interface of integration methods: problem, options, sample sink, statistics.

use std::cell::{Cell, RefCell};
use std::fmt;
use std::ops::ControlFlow;
use std::rc::Rc;

use super::regime::Regime;
use crate::base::error::Error;
use crate::base::time_budget::CancelToken;
use crate::numeric::Matrix;

/// First-order initial value problem `ẏ = f(t, y)`.
pub trait OdeProblem {
    /// Number of states.
    fn len(&self) -> usize;

    /// Right-hand side f, written to `dy`.
    fn derivative(&self, t: f64, y: &[f64], dy: &mut [f64]);

    /// Jacobian ∂f/∂y; by default by forward differences of [`OdeProblem::derivative`].
    fn jacobian(&self, t: f64, y: &[f64], jacobian: &mut Matrix) {
        let n = self.len();
        let mut perturbed = y.to_vec();
        let (mut base, mut slope) = (vec![0.0; n], vec![0.0; n]);
        self.derivative(t, y, &mut base);
        for j in 0..n {
            let step = f64::EPSILON.sqrt() * y[j].abs().max(1e-5);
            perturbed[j] = y[j] + step;
            self.derivative(t, &perturbed, &mut slope);
            for i in 0..n {
                jacobian[(i, j)] = (slope[i] - base[i]) / (perturbed[j] - y[j]);
            }
            perturbed[j] = y[j];
        }
    }

    /// First known discontinuity of f or its derivative after `t`, s; ∞ by default.
    fn next_discontinuity(&self, _t: f64) -> f64 {
        f64::INFINITY
    }

    /// Whether the problem has no states.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Options of an integration run.
#[derive(Debug, Clone)]
pub struct IntegrationOptions {
    /// Start time, s.
    pub from: f64,
    /// End time, s.
    pub to: f64,
    /// State at the start time.
    pub initial_state: Vec<f64>,
    /// Number of sample intervals: samples + 1 states are delivered at equal spacing, both ends included.
    pub samples: usize,
    /// Tolerance or fixed step.
    pub step_size: StepSize,
    /// Work budget in evaluations of f, compared with [`IntegrationStats::work`] plus the work of the observers.
    pub max_work: u64,
    /// Cancellation token; it ends the run between two steps, and the delivered samples stay valid.
    pub cancel: CancelToken,
    /// Observer of the dense output.
    pub observer: Observer,
}

/// Dense output over an interval without located events and without jumps of known functions: one step, or a segment up to the next
/// event.
pub struct DenseOutput<'a> {
    /// Start of the interval, s.
    pub from: f64,
    /// End of the interval, s.
    pub to: f64,
    /// Time scale below which the motion does not reverse twice, s: the interval itself if it is one step.
    pub time_scale: f64,
    /// Regime of the interval, if the method uses regimes.
    pub regime: Option<&'a Regime>,
    /// Writes the state at an instant of the interval, s.
    pub state: &'a mut dyn FnMut(f64, &mut [f64]),
}

/// Function applied to every interval; it returns its work in evaluations of f.
type ObserverFn = dyn FnMut(DenseOutput) -> u64;

/// Observer of the intervals of a run in their order; none by default.
#[derive(Clone, Default)]
pub struct Observer {
    functions: Vec<Rc<RefCell<ObserverFn>>>,
    work: Rc<Cell<u64>>,
}

impl Observer {
    /// Registers a function that receives every interval and returns its work in evaluations of f.
    pub fn add(&mut self, function: impl FnMut(DenseOutput) -> u64 + 'static) {
        self.functions.push(Rc::new(RefCell::new(function)));
    }

    /// Whether a function is registered.
    pub fn is_set(&self) -> bool {
        !self.functions.is_empty()
    }

    /// Passes an interval of positive length to the registered functions.
    pub fn observe(&self, interval: DenseOutput) {
        if interval.to <= interval.from {
            return;
        }
        for function in &self.functions {
            let work = (function.borrow_mut())(DenseOutput {
                state: &mut *interval.state,
                ..interval
            });
            self.work.set(self.work.get() + work);
        }
    }

    /// Accumulated work in evaluations of f.
    pub fn work(&self) -> u64 {
        self.work.get()
    }
}

impl fmt::Debug for Observer {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(if self.is_set() { "Follower" } else { "unset" })
    }
}

impl IntegrationOptions {
    /// Time of a sample, s; the last one is exactly the end time.
    pub fn time(&self, sample: usize) -> f64 {
        match sample == self.samples {
            true => self.to,
            false => self.from + (self.to - self.from) * sample as f64 / self.samples as f64,
        }
    }
}

/// Step size: tolerance or fixed step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StepSize {
    /// Tolerance of the local error per step, relative to the scale of each state, for methods with step control.
    Adaptive(f64),
    /// Step size, s, for methods without step control.
    Fixed(f64),
}

/// Sink of the samples: time, s, state, and the regime if the method uses regimes; a break ends the run early.
pub type SampleSink<'a> = dyn FnMut(f64, &[f64], Option<&Regime>) -> ControlFlow<()> + 'a;

/// Counters of the effort of an integration run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct IntegrationStats {
    /// Number of accepted steps or segments.
    pub steps: u64,
    /// Number of rejected steps.
    pub rejected: u64,
    /// Number of evaluations of f or of event functions.
    pub evaluations: u64,
    /// Number of evaluations of ∂f/∂y.
    pub jacobians: u64,
    /// Number of matrix factorisations.
    pub factorisations: u64,
    /// Number of events: contacts opened or closed, transitions between stick and slip.
    pub events: u64,
    /// Number of switching surfaces touched without a definite crossing.
    pub grazings: u64,
    /// Number of linear systems built, one for each combination of contact states.
    pub regimes: u64,
}

impl IntegrationStats {
    /// Work in evaluations of f of a problem with `states` states, n = states/2. A step counts 1; a factorisation or Jacobian counts n,
    /// multiplied by ⌈n/64⌉; the modes of a linear system count n². At least 8 is used for n.
    pub fn work(&self, states: usize) -> u64 {
        // Below this size the call overhead dominates.
        const MIN_ROWS: u64 = 8;
        // Up to this size the cost of a factorisation is proportional to the rows, beyond to their square.
        const FEW_ROWS: u64 = 64;
        let rows = (states as u64 / 2).max(MIN_ROWS);
        let factors = rows * rows.div_ceil(FEW_ROWS);
        let modes = rows * rows;
        self.evaluations
            + self.steps
            + (self.factorisations + self.jacobians) * factors
            + self.regimes * modes
    }
}

/// Integration function of a method for problems of type P.
pub type IntegrateFn<P> =
    fn(&P, &IntegrationOptions, &mut SampleSink) -> Result<IntegrationStats, Error>;
