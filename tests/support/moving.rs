//! Machines in motion, written by hand.

use std::ops::ControlFlow;

use geardyn::internals::base::error::Error;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::machine::direction::Direction;
use geardyn::internals::motion::contact::{ActiveFlanks, ContactDamping, ContactLaw};
use geardyn::internals::motion::dynamic_model::{
    AppliedForce, DynamicModel, ForceElement, ForceLaw, MassMatrix,
};
use geardyn::internals::motion::methods;
use geardyn::internals::motion::problem::{
    IntegrationOptions, IntegrationStats, Observer, OdeProblem, StepSize,
};
use geardyn::internals::motion::regime::Regime;
use geardyn::internals::motion::signal::Signal;
use geardyn::internals::motion::wave::{PeriodicFunction, WavePhase, Waveform};

/// Inertias without anything between them.
pub fn inertias(masses: &[f64]) -> DynamicModel {
    DynamicModel {
        coordinates: (0..masses.len()).map(|i| format!("x{i}")).collect(),
        mass: MassMatrix::Diagonal(masses.to_vec()),
        elements: Vec::new(),
        forces: Vec::new(),
        mass_damping: 0.0,
        global_matrices: None,
    }
}

/// A branch along freedoms.
pub fn branch(name: &str, terms: &[(usize, f64)], law: ForceLaw) -> ForceElement {
    ForceElement {
        name: name.into(),
        direction: Direction::new(1.0, terms.iter().copied()),
        force_direction: None,
        law,
        stiffness_wave: None,
        imposed_displacement: None,
        angle_waves: Vec::new(),
    }
}

pub fn spring(stiffness: f64, damping: f64) -> ForceLaw {
    ForceLaw::Linear { stiffness, damping }
}

pub fn contact(
    stiffness: f64,
    damping: f64,
    half: f64,
    contact_damping: ContactDamping,
) -> ForceLaw {
    ForceLaw::Contact(ContactLaw {
        stiffness,
        damping,
        half_play: half,
        contact_damping,
        flanks: ActiveFlanks::Both,
    })
}

pub fn push(at: usize, signal: Signal) -> AppliedForce {
    AppliedForce {
        name: format!("push{at}"),
        direction: Direction::unit(at),
        signal,
    }
}

pub fn wave(waveform: Waveform, omega: f64, start: f64) -> Option<PeriodicFunction> {
    let phase = WavePhase::Imposed { omega, start };
    Some(PeriodicFunction {
        waveform,
        load_table: None,
        phase,
    })
}

/// `1 + amplitude cos ψ`.
pub fn cosine(amplitude: f64) -> Waveform {
    Waveform::Fourier {
        mean: 1.0,
        terms: vec![(1, amplitude, 0.0)],
    }
}

/// Samples of a run: times, states, what it cost.
pub type Run = (Vec<f64>, Vec<Vec<f64>>, IntegrationStats);

/// Runs a method from t = 0.
pub fn run(
    method: &str,
    model: &DynamicModel,
    start: &[f64],
    to: f64,
    samples: usize,
) -> Result<Run, Error> {
    run_with(method, model, start, to, samples, StepSize::Adaptive(1e-12))
}

/// The same, as exactly or as finely as said.
pub fn run_with(
    method: &str,
    model: &DynamicModel,
    start: &[f64],
    to: f64,
    samples: usize,
    stats: StepSize,
) -> Result<Run, Error> {
    let options = IntegrationOptions {
        from: 0.0,
        to,
        initial_state: start.to_vec(),
        samples,
        step_size: stats,
        max_work: u64::MAX,
        cancel: CancelToken::default(),
        observer: Observer::default(),
    };
    let (mut times, mut states) = (Vec::new(), Vec::new());
    let mut sink = |t: f64, y: &[f64], _: Option<&Regime>| {
        times.push(t);
        states.push(y.to_vec());
        ControlFlow::Continue(())
    };
    let stats = (methods::method_by_name(method).unwrap().run)(model, &options, &mut sink)?;
    Ok((times, states, stats))
}

/// Runge and Kutta's classical method on the whole law, no event located: right to the square of the step.
pub fn brute(
    model: &DynamicModel,
    start: &[f64],
    to: f64,
    samples: usize,
    steps: usize,
) -> Vec<Vec<f64>> {
    let h = to / (samples * steps) as f64;
    let n = start.len();
    let mut y = start.to_vec();
    let mut states = vec![y.clone()];
    let slope = |t: f64, y: &[f64]| {
        let mut dy = vec![0.0; n];
        model.derivative(t, y, &mut dy);
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
pub fn gear_pair(omega: f64, zeta: f64, eps: f64, mean: f64, alternating: f64) -> DynamicModel {
    let mut model = inertias(&[1.0]);
    let law = contact(1.0, 2.0 * zeta, 1.0, ContactDamping::ActsInGap);
    let mut mesh = branch("mesh", &[(0, 1.0)], law);
    mesh.stiffness_wave = wave(cosine(eps), omega, 0.0);
    model.elements.push(mesh);
    let load = Signal::constant(mean);
    let shaking = Signal::harmonic(alternating * omega * omega, omega, 0.0);
    model.forces.push(push(0, load.plus(&shaking)));
    model
}
