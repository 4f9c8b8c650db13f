//! Machines in motion, written by hand.

use std::ops::ControlFlow;

use geardyn::base::error::Error;
use geardyn::base::stop::Stop;
use geardyn::machine::direction::Direction;
use geardyn::motion::contact::{Contact, Flanks, Losses};
use geardyn::motion::methods;
use geardyn::motion::problem::{Ask, Effort, Follower, Problem, Wanted};
use geardyn::motion::regime::Regime;
use geardyn::motion::signal::Signal;
use geardyn::motion::train::{Branch, Drive, Law, Mass, Train};
use geardyn::motion::wave::{Phase, Shape, Wave};

/// Inertias without anything between them.
pub fn inertias(masses: &[f64]) -> Train {
    Train {
        coordinates: (0..masses.len()).map(|i| format!("x{i}")).collect(),
        mass: Mass::Diagonal(masses.to_vec()),
        branches: Vec::new(),
        drives: Vec::new(),
        drag: 0.0,
        general: None,
    }
}

/// A branch along freedoms.
pub fn branch(name: &str, terms: &[(usize, f64)], law: Law) -> Branch {
    Branch {
        name: name.into(),
        direction: Direction::new(1.0, terms.iter().copied()),
        force: None,
        law,
        variation: None,
        imposed: None,
        followed: Vec::new(),
    }
}

pub fn spring(stiffness: f64, damping: f64) -> Law {
    Law::Linear { stiffness, damping }
}

pub fn contact(stiffness: f64, damping: f64, half: f64, losses: Losses) -> Law {
    Law::Contact(Contact {
        stiffness,
        damping,
        half,
        losses,
        flanks: Flanks::Both,
    })
}

pub fn push(at: usize, signal: Signal) -> Drive {
    Drive {
        name: format!("push{at}"),
        direction: Direction::of(at),
        signal,
    }
}

pub fn wave(shape: Shape, omega: f64, start: f64) -> Option<Wave> {
    let phase = Phase::Imposed { omega, start };
    Some(Wave { shape, phase })
}

/// `1 + amplitude cos ψ`.
pub fn cosine(amplitude: f64) -> Shape {
    Shape::Fourier {
        mean: 1.0,
        terms: vec![(1, amplitude, 0.0)],
    }
}

/// Samples of a run: times, states, what it cost.
pub type Run = (Vec<f64>, Vec<Vec<f64>>, Effort);

/// Runs a method from t = 0.
pub fn run(
    method: &str,
    train: &Train,
    start: &[f64],
    to: f64,
    samples: usize,
) -> Result<Run, Error> {
    run_with(method, train, start, to, samples, Wanted::Tolerance(1e-12))
}

/// The same, as exactly or as finely as said.
pub fn run_with(
    method: &str,
    train: &Train,
    start: &[f64],
    to: f64,
    samples: usize,
    effort: Wanted,
) -> Result<Run, Error> {
    let ask = Ask {
        from: 0.0,
        to,
        start: start.to_vec(),
        samples,
        effort,
        budget: u64::MAX,
        stop: Stop::default(),
        follower: Follower::default(),
    };
    let (mut times, mut states) = (Vec::new(), Vec::new());
    let mut sink = |t: f64, y: &[f64], _: Option<&Regime>| {
        times.push(t);
        states.push(y.to_vec());
        ControlFlow::Continue(())
    };
    let effort = (methods::find(method).unwrap().run)(train, &ask, &mut sink)?;
    Ok((times, states, effort))
}

/// Runge and Kutta's classical method on the whole law, no event located: right to the square of the step.
pub fn brute(train: &Train, start: &[f64], to: f64, samples: usize, steps: usize) -> Vec<Vec<f64>> {
    let h = to / (samples * steps) as f64;
    let n = start.len();
    let mut y = start.to_vec();
    let mut states = vec![y.clone()];
    let slope = |t: f64, y: &[f64]| {
        let mut dy = vec![0.0; n];
        train.slope(t, y, &mut dy);
        dy
    };
    let moved = |y: &[f64], k: &[f64], h: f64| -> Vec<f64> {
        y.iter().zip(k).map(|(y, k)| y + h * k).collect()
    };
    for step in 0..samples * steps {
        let t = h * step as f64;
        let a = slope(t, &y);
        let b = slope(t + 0.5 * h, &moved(&y, &a, 0.5 * h));
        let c = slope(t + 0.5 * h, &moved(&y, &b, 0.5 * h));
        let d = slope(t + h, &moved(&y, &c, h));
        for i in 0..n {
            y[i] += h / 6.0 * (a[i] + 2.0 * (b[i] + c[i]) + d[i]);
        }
        if (step + 1) % steps == 0 {
            states.push(y.clone());
        }
    }
    states
}

/// The largest difference of two histories, each state by its own largest value.
pub fn apart(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    assert_eq!(a.len(), b.len(), "samples");
    (0..a[0].len())
        .map(|i| {
            let scale = b.iter().map(|y| y[i].abs()).fold(1e-300, f64::max);
            let off = a.iter().zip(b).map(|(a, b)| (a[i] - b[i]).abs());
            off.fold(0.0, f64::max) / scale
        })
        .fold(0.0, f64::max)
}

/// The gear pair `x″ + 2ζ x′ + (1 + ε cos Ωt) g(x) = F_m + F_a Ω² cos Ωt`, half-gap one, damper in the gap too (Kahraman and Singh 1990).
pub fn gear_pair(omega: f64, zeta: f64, eps: f64, mean: f64, alternating: f64) -> Train {
    let mut train = inertias(&[1.0]);
    let law = contact(1.0, 2.0 * zeta, 1.0, Losses::Throughout);
    let mut mesh = branch("mesh", &[(0, 1.0)], law);
    mesh.variation = wave(cosine(eps), omega, 0.0);
    train.branches.push(mesh);
    let load = Signal::constant(mean);
    let shaking = Signal::harmonic(alternating * omega * omega, omega, 0.0);
    train.drives.push(push(0, load.plus(&shaking)));
    train
}
