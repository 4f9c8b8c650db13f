//! Interface of integration methods: problem, options, sample sink, statistics.

use std::cell::{Cell, RefCell};
use std::fmt;
use std::ops::ControlFlow;
use std::rc::Rc;

use super::regime::Regime;
use crate::base::error::Error;
use crate::base::time_budget::CancelToken;
use crate::numeric::Matrix;

/// A first-order problem `ẏ = f(t, y)`. Machines are one; plain stiff problems too.
pub trait OdeProblem {
    /// Number of states.
    fn len(&self) -> usize;

    /// f.
    fn derivative(&self, t: f64, y: &[f64], dy: &mut [f64]);

    /// ∂f/∂y; by differences of [`OdeProblem::derivative`] unless the problem knows better.
    fn jacobian(&self, t: f64, y: &[f64], jacobian: &mut Matrix) {
        let n = self.len();
        let mut moved = y.to_vec();
        let (mut base, mut slope) = (vec![0.0; n], vec![0.0; n]);
        self.derivative(t, y, &mut base);
        for j in 0..n {
            let step = f64::EPSILON.sqrt() * y[j].abs().max(1e-5);
            moved[j] = y[j] + step;
            self.derivative(t, &moved, &mut slope);
            for i in 0..n {
                jacobian[(i, j)] = (slope[i] - base[i]) / (moved[j] - y[j]);
            }
            moved[j] = y[j];
        }
    }

    /// The first known instant after `t` at which f jumps or has a corner; ∞ where none comes.
    fn next_discontinuity(&self, _t: f64) -> f64 {
        f64::INFINITY
    }

    /// Whether there is nothing to solve.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Options of an integration run.
#[derive(Debug, Clone)]
pub struct IntegrationOptions {
    /// From this instant, s.
    pub from: f64,
    /// To this one, s.
    pub to: f64,
    /// The state then.
    pub initial_state: Vec<f64>,
    /// Number of equal steps between samples: samples + 1 states are delivered, both ends included.
    pub samples: usize,
    /// Tolerance or fixed step.
    pub step_size: StepSize,
    /// The run is refused once it has cost so much, counted as [`IntegrationStats::work`] with what the follower did.
    pub max_work: u64,
    /// The run ends between two steps once this is due; what was delivered is whole.
    pub cancel: CancelToken,
    /// Who goes along next to the samples.
    pub observer: Observer,
}

/// A part of a run in which nothing switches that the method locates, and no known function jumps: a step, or all up to the next
/// switch.
pub struct DenseOutput<'a> {
    /// From this instant, s.
    pub from: f64,
    /// To this one, s.
    pub to: f64,
    /// A time in which the motion cannot turn round and back, s: the whole interval where it is one step.
    pub time_scale: f64,
    /// Regime of the interval, where the method uses regimes.
    pub regime: Option<&'a Regime>,
    /// The state at an instant of it.
    pub state: &'a mut dyn FnMut(f64, &mut [f64]),
}

/// Function applied to every interval, returning its work, in evaluations.
type ObserverFn = dyn FnMut(DenseOutput) -> u64;

/// Observer of the intervals of a run in their order; none by default.
#[derive(Clone, Default)]
pub struct Observer {
    functions: Vec<Rc<RefCell<ObserverFn>>>,
    spent: Rc<Cell<u64>>,
}

impl Observer {
    /// Adds a function that is handed every interval and returns its work, in evaluations.
    pub fn add(&mut self, function: impl FnMut(DenseOutput) -> u64 + 'static) {
        self.functions.push(Rc::new(RefCell::new(function)));
    }

    /// Whether a function is registered.
    pub fn is_set(&self) -> bool {
        !self.functions.is_empty()
    }

    /// Hands over an interval, if time passes in it.
    pub fn observe(&self, interval: DenseOutput) {
        if interval.to <= interval.from {
            return;
        }
        for follow in &self.functions {
            let work = (follow.borrow_mut())(DenseOutput {
                state: &mut *interval.state,
                ..interval
            });
            self.spent.set(self.spent.get() + work);
        }
    }

    /// The work so far, in evaluations.
    pub fn work(&self) -> u64 {
        self.spent.get()
    }
}

impl fmt::Debug for Observer {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(if self.is_set() { "Follower" } else { "unset" })
    }
}

impl IntegrationOptions {
    /// The instant of a sample; the last is exactly the end.
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
    /// Local error per step, relative to the scale of each state: for methods that choose their steps.
    Adaptive(f64),
    /// Fixed step, s: for methods that do not.
    Fixed(f64),
}

/// Sink of the samples: time, state, and the regime where the method uses regimes. A break ends the run early, whole.
pub type SampleSink<'a> = dyn FnMut(f64, &[f64], Option<&Regime>) -> ControlFlow<()> + 'a;

/// Cost of a run.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct IntegrationStats {
    /// Steps or segments.
    pub steps: u64,
    /// Steps done again smaller.
    pub rejected: u64,
    /// Evaluations of f, or of switch functions.
    pub evaluations: u64,
    /// Evaluations of ∂f/∂y.
    pub jacobians: u64,
    /// Matrices factored.
    pub factorisations: u64,
    /// Contacts opened or closed, pairs that stuck or slipped.
    pub events: u64,
    /// Switching surfaces touched without a certain crossing.
    pub grazings: u64,
    /// Linear machines built, one for each way the contacts stood.
    pub regimes: u64,
}

impl IntegrationStats {
    /// The work, in evaluations of f of a problem with so many states: a step is one; what factors a matrix or finds its entries as many
    /// as half the states, of more than 64 coordinates as many times more as they are times 64; the modes of a linear machine as many as the
    /// square of half the states.
    pub fn work(&self, states: usize) -> u64 {
        // Below this the calls cost, not the rows.
        const MIN_ROWS: u64 = 8;
        // Up to here a factorisation goes by its rows, beyond by their square.
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

/// A method's run on a problem of kind P.
pub type IntegrateFn<P> =
    fn(&P, &IntegrationOptions, &mut SampleSink) -> Result<IntegrationStats, Error>;
