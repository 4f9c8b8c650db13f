//! What every method of integration takes and gives: a problem, what is asked of it, where samples go, what it cost.

use std::cell::{Cell, RefCell};
use std::fmt;
use std::ops::ControlFlow;
use std::rc::Rc;

use super::regime::Regime;
use crate::base::error::Error;
use crate::base::stop::Stop;
use crate::numeric::Matrix;

/// A first-order problem `ẏ = f(t, y)`. Machines are one; plain stiff problems too.
pub trait Problem {
    /// How many states there are.
    fn len(&self) -> usize;

    /// f.
    fn slope(&self, t: f64, y: &[f64], dy: &mut [f64]);

    /// ∂f/∂y; by differences of [`Problem::slope`] unless the problem knows better.
    fn jacobian(&self, t: f64, y: &[f64], jacobian: &mut Matrix) {
        let n = self.len();
        let mut moved = y.to_vec();
        let (mut base, mut slope) = (vec![0.0; n], vec![0.0; n]);
        self.slope(t, y, &mut base);
        for j in 0..n {
            let step = f64::EPSILON.sqrt() * y[j].abs().max(1e-5);
            moved[j] = y[j] + step;
            self.slope(t, &moved, &mut slope);
            for i in 0..n {
                jacobian[(i, j)] = (slope[i] - base[i]) / (moved[j] - y[j]);
            }
            moved[j] = y[j];
        }
    }

    /// The first known instant after `t` at which f jumps or has a corner; ∞ where none comes.
    fn next_break(&self, _t: f64) -> f64 {
        f64::INFINITY
    }

    /// Whether there is nothing to solve.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// What is asked of a method.
#[derive(Debug, Clone)]
pub struct Ask {
    /// From this instant, s.
    pub from: f64,
    /// To this one, s.
    pub to: f64,
    /// The state then.
    pub start: Vec<f64>,
    /// How many equal steps the samples divide the time into: samples + 1 states are delivered, both ends included.
    pub samples: usize,
    /// How exact, or how fine.
    pub effort: Wanted,
    /// The run is refused once it has cost so much, counted as [`Effort::work`] with what the follower did.
    pub budget: u64,
    /// The run ends between two steps once this is due; what was delivered is whole.
    pub stop: Stop,
    /// Who goes along beside the samples.
    pub follower: Follower,
}

/// A part of a run in which nothing switches that the method locates, and no known function jumps: a step, or all up to the next
/// switch.
pub struct Stretch<'a> {
    /// From this instant, s.
    pub from: f64,
    /// To this one, s.
    pub to: f64,
    /// A time in which the motion cannot turn round and back, s: the whole stretch where it is one step.
    pub grain: f64,
    /// How everything stands, where the method holds to regimes.
    pub regime: Option<&'a Regime>,
    /// The state at an instant of it.
    pub state: &'a mut dyn FnMut(f64, &mut [f64]),
}

/// What is done with every stretch, and the work it was, in evaluations.
type Follow = dyn FnMut(Stretch) -> u64;

/// Goes along with a run, stretch by stretch in their order; nobody unless made.
#[derive(Clone, Default)]
pub struct Follower {
    follow: Option<Rc<RefCell<Follow>>>,
    spent: Rc<Cell<u64>>,
}

impl Follower {
    /// One that is handed every stretch, and says what work it made of it, in evaluations.
    pub fn new(follow: impl FnMut(Stretch) -> u64 + 'static) -> Follower {
        Follower {
            follow: Some(Rc::new(RefCell::new(follow))),
            spent: Rc::default(),
        }
    }

    /// Somebody goes along.
    pub fn is_there(&self) -> bool {
        self.follow.is_some()
    }

    /// Hands over a stretch, if time passes in it.
    pub fn follow(&self, stretch: Stretch) {
        if let Some(follow) = &self.follow
            && stretch.to > stretch.from
        {
            let work = (follow.borrow_mut())(stretch);
            self.spent.set(self.spent.get() + work);
        }
    }

    /// The work so far, in evaluations.
    pub fn spent(&self) -> u64 {
        self.spent.get()
    }
}

impl fmt::Debug for Follower {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(if self.is_there() {
            "Follower"
        } else {
            "nobody"
        })
    }
}

impl Ask {
    /// The instant of a sample; the last is exactly the end.
    pub fn time(&self, sample: usize) -> f64 {
        match sample == self.samples {
            true => self.to,
            false => self.from + (self.to - self.from) * sample as f64 / self.samples as f64,
        }
    }
}

/// How exact, or how fine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wanted {
    /// Local error per step, relative to the scale of each state: for methods that choose their steps.
    Tolerance(f64),
    /// Fixed step, s: for methods that do not.
    Step(f64),
}

/// Where samples go: time, state, and how everything stands where the method holds to regimes. A break ends the run early, whole.
pub type Sink<'a> = dyn FnMut(f64, &[f64], Option<&Regime>) -> ControlFlow<()> + 'a;

/// What a run cost.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Effort {
    /// Steps or segments.
    pub steps: u64,
    /// Steps done again smaller.
    pub rejected: u64,
    /// Evaluations of f, or of switch functions.
    pub evaluations: u64,
    /// Of ∂f/∂y.
    pub jacobians: u64,
    /// Matrices factored.
    pub factorisations: u64,
    /// Contacts opened or closed, pairs that stuck or slipped.
    pub events: u64,
    /// Borders touched without a certain crossing.
    pub grazed: u64,
    /// Linear machines built, one for each way the contacts stood.
    pub machines: u64,
}

impl Effort {
    /// The work, in evaluations of f of a problem with so many states: a step is one; what factors a matrix or finds its entries as many
    /// as half the states, of more than 64 coordinates as many times more as they are times 64; the modes of a linear machine as many as the
    /// square of half the states.
    pub fn work(&self, states: usize) -> u64 {
        // Below this the calls cost, not the rows.
        const LEAST_ROWS: u64 = 8;
        // Up to here a factorisation goes by its rows, beyond by their square.
        const FEW_ROWS: u64 = 64;
        let rows = (states as u64 / 2).max(LEAST_ROWS);
        let factors = rows * rows.div_ceil(FEW_ROWS);
        let modes = rows * rows;
        self.evaluations
            + self.steps
            + (self.factorisations + self.jacobians) * factors
            + self.machines * modes
    }
}

/// A method's run on a problem of kind P.
pub type Run<P> = fn(&P, &Ask, &mut Sink) -> Result<Effort, Error>;
