//! Steady answers, in one run: frequency responses against NumPy, harmonic balance against integration until steady.
//!
//! `cargo bench --bench response` (`-- responses` or `-- motions` for one half) prints times, errors and ratios: of responses the time
//! on the processor, of motions, which take less than that clock tells, the time that passed. The peer needs `python3` with NumPy and
//! SciPy, on one thread as ours is; where it is missing only our side is shown. Responses are those of a uniform chain of 200 discs held
//! at its start,
//! 10 000 lines, last disc by first; errors are against its modes in closed form, by the largest value. Periodic motions start
//! from nothing on both sides; errors are against the orbit by shooting with every switch located. An integration that is not near it in
//! half a minute is given up, and its row says so.

use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;
use std::time::Instant;

use beside::{Took, best, best_on_processor, peers, row};
use geardyn::internals::machine::direction::Direction;
use geardyn::internals::motion::contact::{ActiveFlanks, ContactDamping, ContactLaw};
use geardyn::internals::motion::dynamic_model::{
    AppliedForce, DynamicModel, ForceElement, ForceLaw, MassMatrix,
};
use geardyn::internals::motion::floquet::orbit::find_orbit;
use geardyn::internals::motion::methods;
use geardyn::internals::motion::outputs::MotionOutputs;
use geardyn::internals::motion::problem::{IntegrationOptions, Observer, StepSize};
use geardyn::internals::motion::regime::Regime;
use geardyn::internals::motion::signal::Signal;
use geardyn::internals::numeric::Complex;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::response::frf::{ResponseMethod, frf_matrix};
use geardyn::internals::response::harmonic_balance::curve::{ContinuationOptions, continue_curve};
use geardyn::internals::response::harmonic_balance::family::SpeedFamily;
use geardyn::internals::response::harmonic_balance::point::PointOptions;
use geardyn::internals::response::ports::Ports;
use geardyn::internals::response::system::OperatingModel;
use geardyn::internals::scene;

mod beside;

/// Of the first column.
const WIDTH: usize = 62;

const DISCS: usize = 200;
const LINES: usize = 10_000;

/// Of the stiffness.
const LOSS: f64 = 0.01;

fn main() {
    let asked: Vec<String> = std::env::args()
        .skip(1)
        .filter(|a| !a.starts_with("--"))
        .collect();
    let wanted = |name: &str| asked.is_empty() || asked.iter().any(|a| a == name);
    if wanted("responses") {
        frequency_responses();
    }
    if wanted("motions") {
        periodic_motions();
    }
}

fn frequency_responses() {
    beside::head(WIDTH, "NumPy");
    let text = format!(
        "title = \"chain\"\nsource = \"bench\"\nunits = \"SI\"\n[damping]\nrayleigh_stiffness = {LOSS}\n[[chain]]\nname = \"c\"\ncount = {DISCS}\nJ = 1.0\nk = 1.0\nheld = \"start\"\n"
    );
    let scene = scene::read_text("chain.toml", &text).expect("the bench's own model is right");
    let prepared_machine = PreparedMachine::new(&scene.model).expect("a chain is a machine");
    let names = |k: usize| vec![prepared_machine.machine.dof_name(k)];
    let ports = Ports::parse(&prepared_machine.machine, &names(0), &names(DISCS - 1), &[])
        .expect("both exist");
    let setting = OperatingModel {
        machine: &prepared_machine.machine,
        operating: &prepared_machine.operating,
        model: &prepared_machine.model,
        speeds: None,
    };
    let omega: Vec<f64> = (1..=LINES).map(|k| 2.2 * k as f64 / LINES as f64).collect();
    let truth: Vec<Complex> = omega.iter().map(|&w| exact(w)).collect();
    let largest = truth.iter().map(|z| z.norm()).fold(0.0, f64::max);
    let theirs = peers(
        "response_peer.py",
        &[&DISCS.to_string(), &LINES.to_string(), &LOSS.to_string()],
    );
    let peer = |name: &str| theirs.iter().find(|t| t.0 == name).map(|t| t.1);
    for (what, method, name, runs) in [
        (
            "200 discs, 10 000 lines, one by one (sparse)",
            ResponseMethod::Direct,
            "dense",
            3,
        ),
        (
            "the same, against LAPACK's banded solution",
            ResponseMethod::Direct,
            "banded",
            3,
        ),
        (
            "the same, sum over all modes, modes included",
            ResponseMethod::Modal,
            "modes",
            3,
        ),
    ] {
        let (seconds, found) = best_on_processor(runs, || {
            frf_matrix(&setting, &ports, &omega, method).expect("damped")
        });
        let off = found
            .values
            .iter()
            .zip(&truth)
            .map(|(h, t)| (h[(0, 0)] - t).norm());
        let error = Some(off.fold(0.0, f64::max) / largest);
        row(WIDTH, what, Took { seconds, error }, peer(name));
    }
}

/// `Σ φ_j(1) φ_j(coordinate_count) / (ω_j² (1 + iωβ) − ω²)`, `φ_j(k) = 2 sin(k θ_j)/√(2coordinate_count + 1)`, `θ_j = (2j − 1) π/(2coordinate_count + 1)`, `ω_j = 2 sin(θ_j/2)`.
fn exact(omega: f64) -> Complex {
    let all = (2 * DISCS + 1) as f64;
    (1..=DISCS).fold(Complex::new(0.0, 0.0), |sum, j| {
        let theta = (2 * j - 1) as f64 * PI / all;
        let square = (2.0 * (0.5 * theta).sin()).powi(2);
        let shapes = 4.0 * theta.sin() * (DISCS as f64 * theta).sin() / all;
        sum + Complex::new(shapes, 0.0)
            / Complex::new(square - omega * omega, omega * LOSS * square)
    })
}

fn branch(name: String, terms: &[(usize, f64)], law: ForceLaw) -> ForceElement {
    ForceElement {
        name,
        direction: Direction::new(1.0, terms.iter().copied()),
        force_direction: None,
        law,
        stiffness_wave: None,
        imposed_displacement: None,
        angle_waves: Vec::new(),
    }
}

/// Two rows of `side` discs of 1/side, joined by a pair with play that is shaken by its error, driven and braked at the ends.
fn geared(side: usize, damping: f64) -> DynamicModel {
    let n = 2 * side;
    let mut branches = Vec::new();
    for at in (0..n - 1).filter(|at| at + 1 != side) {
        let law = ForceLaw::Linear {
            stiffness: 10.0,
            damping: 10.0 * damping,
        };
        branches.push(branch(
            format!("shaft {at}"),
            &[(at, 1.0), (at + 1, -1.0)],
            law,
        ));
    }
    let contact = ContactLaw {
        stiffness: 1.0,
        damping,
        half_play: 1.0,
        contact_damping: ContactDamping::ActsInGap,
        flanks: ActiveFlanks::Both,
    };
    let mut mesh = branch(
        "mesh".into(),
        &[(side - 1, 1.0), (side, -1.0)],
        ForceLaw::Contact(contact),
    );
    mesh.imposed_displacement = Some(Signal::harmonic(0.05, 1.0, 0.0));
    branches.push(mesh);
    let drive = |at: usize, torque: f64| AppliedForce {
        name: format!("torque {at}"),
        direction: Direction::unit(at),
        signal: Signal::constant(torque),
    };
    DynamicModel {
        coordinates: (0..n).map(|k| format!("x{k}")).collect(),
        mass: MassMatrix::Diagonal(vec![2.0 / side as f64; n]),
        elements: branches,
        forces: vec![drive(0, 0.1), drive(n - 1, -0.1)],
        mass_damping: 0.0,
        global_matrices: None,
    }
}

fn periodic_motions() {
    println!();
    println!("{:<WIDTH$} {:>13} {:>9}", "", "time", "error");
    for (side, damping, omega, what) in [
        (1, 0.1, 1.2, "pair with play, ζ = 5 %"),
        (1, 0.02, 1.2, "pair with play, ζ = 1 %"),
        (10, 0.1, 1.15, "the same between two shafts of ten discs"),
    ] {
        let family =
            SpeedFamily::new(&geared(side, damping), &vec![0.0; 2 * side]).expect("it repeats");
        let outputs = MotionOutputs::default();
        let mut first = None;
        for (name, events, tolerance) in [
            ("balance alone", false, 1e-7),
            ("balance and events", true, 1e-4),
        ] {
            let course = ContinuationOptions {
                from: omega,
                to: 1.1 * omega,
                step: 0.01,
                tolerance,
                orders: None,
                max_points: 1,
            };
            let options = PointOptions {
                outputs: &outputs,
                events,
            };
            let (seconds, curve) = best(3, || {
                continue_curve(&family, options, course, &mut |_| {}).expect("a motion")
            });
            let start = curve.points[0].start.clone();
            let exact = find_orbit(&family.relative_at(omega), &start, 1)
                .expect("an orbit")
                .start;
            let error = Some(apart(&start, &exact));
            row(
                WIDTH,
                &format!("{what}: {name}, {} orders", curve.points[0].orders),
                Took { seconds, error },
                None,
            );
            first = Some((exact, seconds));
        }
        let Some((exact, ours)) = first else { continue };
        let model = family.relative_at(omega);
        for (name, size) in [
            ("dop853-events", StepSize::Adaptive(1e-9)),
            ("radau5", StepSize::Adaptive(1e-8)),
            ("periodic", StepSize::Adaptive(1e-9)),
        ] {
            let (seconds, (error, periods)) =
                best(1, || settled(&model, name, size, omega, &exact));
            let ratio = seconds / ours;
            let text = match error < NEAR {
                true => format!("{what}: {name}, {periods} periods, ratio {ratio:.0}"),
                false => {
                    format!("{what}: {name}, given up after {periods} periods, ratio {ratio:.0}")
                }
            };
            row(
                WIDTH,
                &text,
                Took {
                    seconds,
                    error: Some(error),
                },
                None,
            );
        }
    }
}

/// A motion has settled where the state at the end of a period is so near the orbit.
const NEAR: f64 = 1e-6;

/// Integrates from nothing until the motion has settled, and gives up after 5 000 periods or half a minute.
fn settled(
    model: &DynamicModel,
    name: &str,
    effort: StepSize,
    omega: f64,
    exact: &[f64],
) -> (f64, u64) {
    const MOST: usize = 5000;
    const PATIENCE_S: f64 = 30.0;
    let begun = Instant::now();
    let mut start = vec![0.0; exact.len()];
    // On the driving flank, wound up.
    let mesh = model
        .elements
        .iter()
        .find(|b| b.name == "mesh")
        .expect("it has one");
    let along = mesh.direction.dot(&exact[..model.coordinate_count()]);
    start[..model.coordinate_count()]
        .iter_mut()
        .zip(exact)
        .for_each(|(s, e)| *s = e * (1.1 / along));
    let options = IntegrationOptions {
        from: 0.0,
        to: MOST as f64 * TAU / omega,
        initial_state: start,
        samples: MOST,
        step_size: effort,
        max_work: 2_000_000_000,
        cancel: Default::default(),
        observer: Observer::default(),
    };
    let (mut error, mut periods) = (f64::INFINITY, 0);
    let mut sink = |_: f64, y: &[f64], _: Option<&Regime>| {
        error = apart(y, exact);
        periods += 1;
        match error < NEAR || begun.elapsed().as_secs_f64() > PATIENCE_S {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    };
    let method = methods::method_by_name(name).expect("a method of that name");
    (method.run)(model, &options, &mut sink).expect("it runs");
    (error, periods)
}

/// The largest difference of two states, positions and speeds each by their largest.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    let n = b.len() / 2;
    [0..n, n..2 * n]
        .into_iter()
        .map(|part| {
            let size = b[part.clone()].iter().fold(0.0f64, |m, x| m.max(x.abs()));
            let off = part.map(|i| (a[i] - b[i]).abs()).fold(0.0, f64::max);
            off / size
        })
        .fold(0.0, f64::max)
}
