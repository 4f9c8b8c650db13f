//! Motion against SciPy and SUNDIALS, in one run: the scenes of examples/ by the method that geardyn chooses.
//!
//! `cargo bench --bench motion` prints times, errors and ratios; `-- stiff_chain` and so on print a part. The peers need `python3` with
//! NumPy, SciPy, Numba and scikit-sundae; where one is missing only our side is shown. Every peer integrates the same equations, which
//! are handed over as numbers, and runs at the loosest tolerance that brings its error to about 1e-8, or as near as it comes.
//!
//! An error is the worst output's largest difference from the reference over all samples, by that output's largest size. The
//! reference of linear machines is a matrix exponential in whole numbers of 500 bits; else it is our chosen method where it makes no
//! error of step, whose own error is then its distance from the method it is compared with at its tightest tolerance.

use std::f64::consts::TAU;
use std::fs;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use beside::{Took, best, best_on_processor, peers, row};
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::machine::direction::Direction;
use geardyn::internals::motion::combination::LinearCombination;
use geardyn::internals::motion::contact::{ActiveFlanks, ContactDamping, ContactLaw};
use geardyn::internals::motion::dynamic_model::{
    AppliedForce, DynamicModel, ForceElement, ForceLaw, MassMatrix,
};
use geardyn::internals::motion::methods::{self, IntegrationMethod, StepControl};
use geardyn::internals::motion::outputs::{MotionOutput, MotionOutputs, OutputQuantity};
use geardyn::internals::motion::problem::{
    IntegrationOptions, IntegrationStats, Observer, OdeProblem, StepSize,
};
use geardyn::internals::motion::signal::Signal;
use geardyn::internals::motion::wave::{PeriodicFunction, WavePhase, Waveform};
use geardyn::internals::plan::motion::method_choice;
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::scene;
use geardyn::internals::scene::laws::TorqueSpeedCurve;
use geardyn::internals::scene::study::{SimulateStudy, StudyKind};
use serde_json::{Value, json};

mod beside;

/// Of the first column.
const WIDTH: usize = 62;

/// The error that is asked for.
const WANTED: f64 = 1e-8;

/// Mesh cycles of the gear pairs.
const CYCLES: f64 = 1000.0;

/// Evaluations after which a run is given up.
const BUDGET: u64 = 400_000_000;

/// What the errors are against.
enum Truth {
    /// A matrix exponential.
    Exponential,
    /// Our methods, that of the name at its tightest beside the chosen one.
    Beside(&'static str),
}

/// One row of rows.
struct Part {
    name: &'static str,
    title: &'static str,
    make: fn() -> Moved,
    truth: Truth,
    /// Further methods of ours.
    also: &'static [&'static str],
    peers: &'static [&'static str],
}

const PARTS: &[Part] = &[
    Part {
        name: "linear_chain",
        title: "linear chain, 20 freedoms, harmonic torque, 1 s",
        make: || shipped("linear_chain", 1.0, 400),
        truth: Truth::Exponential,
        also: &["dop853-events"],
        peers: &["DOP853", "LSODA", "CVODE-BDF", "CVODE-Adams"],
    },
    Part {
        name: "stiff_chain",
        title: "stiff chain, 20 freedoms, stiffness over 1e10, 1 s",
        make: || shipped("stiff_chain", 1.0, 400),
        truth: Truth::Exponential,
        also: &["radau5"],
        peers: &["Radau", "BDF", "LSODA", "CVODE-BDF"],
    },
    Part {
        name: "backlash_pair",
        title: "gear pair, play, stiffness in steps, 1 000 cycles",
        make: || cycles("backlash_pair"),
        truth: Truth::Beside("dop853-events"),
        also: &["dop853-events"],
        peers: GAPPED,
    },
    Part {
        name: "smooth_mesh",
        title: "gear pair, play, smooth stiffness, 1 000 cycles",
        make: || cycles("smooth_mesh"),
        truth: Truth::Beside("dop853-events"),
        also: &["dop853-events"],
        peers: GAPPED,
    },
    Part {
        name: "one_freedom",
        title: "the same in one freedom, without dimensions",
        make: one_freedom,
        truth: Truth::Beside("dop853-events"),
        also: &["dop853-events"],
        peers: GAPPED,
    },
    Part {
        name: "geared_chain",
        // It rattles, and multiplies every rounding: by a second no two methods agree, until here all do.
        title: "geared chain, 20 freedoms, two meshes with play, 0.3 s",
        make: || in_turning_frame(shipped("geared_chain", 0.3, 120)),
        truth: Truth::Beside("dop853-events"),
        also: &["dop853-events"],
        peers: &[
            "DOP853",
            "LSODA",
            "CVODE-BDF",
            "CVODE-Adams",
            "CVODE-Adams-roots",
        ],
    },
    Part {
        name: "y2250_cutting",
        // Without a load the train rattles and forgets how it began; the row begins where the cutter enters, from one state for all.
        title: "Y2250 cutting, the first 10 ms in the slot",
        make: || later(shipped("y2250_cutting", 0.21, 100), 0.2),
        truth: Truth::Beside("dop853-events"),
        also: &["dop853-events"],
        peers: &["Radau", "LSODA", "CVODE-BDF", "CVODE-Adams"],
    },
];

/// Peers of machines with few freedoms whose contacts open.
const GAPPED: &[&str] = &[
    "DOP853",
    "LSODA",
    "CVODE-BDF",
    "CVODE-Adams",
    "CVODE-Adams-roots",
];

fn main() {
    beside::head(WIDTH, "peer");
    let asked: Vec<String> = std::env::args().collect();
    let is_asked = |name: &str| asked.iter().any(|word| word == name);
    let any = PARTS.iter().any(|part| is_asked(part.name));
    for part in PARTS {
        if !any || is_asked(part.name) {
            show(part);
        }
    }
}

/// A machine in motion and what is wanted of it.
struct Moved {
    train: DynamicModel,
    start: Vec<f64>,
    outputs: MotionOutputs,
    from: f64,
    until: f64,
    samples: usize,
}

/// A scene of examples/, its outputs those of its study of accuracy, else of its first study.
fn shipped(name: &str, until: f64, samples: u32) -> Moved {
    let path = format!("{}/examples/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let scene = scene::read(Path::new(&path)).unwrap_or_else(|_| panic!("{path} is right"));
    let motions = scene.studies.iter().filter_map(|study| match &study.kind {
        StudyKind::Simulate(motion) => Some(motion),
        StudyKind::Accuracy(study) => Some(&study.motion),
        _ => None,
    });
    let all: Vec<&SimulateStudy> = motions.collect();
    let study = SimulateStudy {
        end_time: Some(until),
        samples: Some(samples),
        outputs: match all.iter().find(|m| m.speed.is_some()) {
            Some(first) => first.outputs.clone(),
            None => all.last().expect("it moves").outputs.clone(),
        },
        speed: all[0].speed,
        ..SimulateStudy::default()
    };
    let prepared_machine = PreparedMachine::new(&scene.model).expect("the model is a machine");
    let ready = SimulationSetup::new(&prepared_machine, &scene.start, &study).expect("it can move");
    Moved {
        train: ready.model.model,
        start: ready.initial_state,
        outputs: ready.outputs,
        from: 0.0,
        until,
        samples: samples as usize,
    }
}

/// The same from an instant on, from where it is then.
fn later(mut result: Moved, from: f64) -> Moved {
    let (until, samples) = (result.until, result.samples);
    (result.until, result.samples) = (from, 1);
    let explicit = methods::method_by_name("dop853-events").expect("it is a method");
    let run = result.run(explicit, StepSize::Adaptive(1e-10));
    let states = run.expect("it moves").0;
    result.start = states[result.start.len()..].to_vec();
    (result.from, result.until, result.samples) = (from, until, samples);
    result
}

/// A gear pair over its mesh cycles, seen at their ends.
fn cycles(name: &str) -> Moved {
    let mut result = in_turning_frame(shipped(name, 1.0, 1));
    let mesh = result
        .train
        .elements
        .iter()
        .find_map(|b| b.stiffness_wave.as_ref());
    let Some(WavePhase::Imposed { omega, .. }) = mesh.map(|wave| &wave.phase) else {
        panic!("{name} has a mesh at a speed that is imposed");
    };
    result.until = CYCLES * (TAU / omega);
    result.samples = CYCLES as usize;
    result
}

/// Where nothing resists the turning at the speeds of the start, they are taken off: motion is then that about the turning, whose
/// angle would hide it behind its digits.
fn in_turning_frame(mut result: Moved) -> Moved {
    let n = result.train.coordinate_count();
    let speeds = result.start[n..2 * n].to_vec();
    for b in &result.train.elements {
        let size = b.direction.entries().map(|(i, a)| (a * speeds[i]).abs());
        let size = size.fold(0.0, f64::max);
        assert!(
            b.direction.dot(&speeds).abs() <= 1e-12 * size,
            "{} resists the turning",
            b.name
        );
    }
    result.start[n..2 * n].fill(0.0);
    result
}

/// `x″ + 0.1 x′ + (1 + 0.2 cos Ωt) g(x) = 0.1 + 0.05 Ω² cos Ωt`, half-gap one, Ω = 0.85, from (1.4, 0).
fn one_freedom() -> Moved {
    let omega = 0.85;
    let waveform = Waveform::Fourier {
        mean: 1.0,
        terms: vec![(1, 0.2, 0.0)],
    };
    let phase = WavePhase::Imposed { omega, start: 0.0 };
    let mesh = ForceElement {
        name: "mesh".to_string(),
        direction: Direction::unit(0),
        force_direction: None,
        law: ForceLaw::Contact(ContactLaw {
            stiffness: 1.0,
            damping: 0.1,
            half_play: 1.0,
            contact_damping: ContactDamping::ActsInGap,
            flanks: ActiveFlanks::Both,
        }),
        stiffness_wave: Some(PeriodicFunction {
            waveform,
            load_table: None,
            phase,
        }),
        imposed_displacement: None,
        angle_waves: Vec::new(),
    };
    let load = Signal::constant(0.1).plus(&Signal::harmonic(0.05 * omega * omega, omega, 0.0));
    let output = |name: &str, quantity| MotionOutput {
        name: name.to_string(),
        quantity,
        unit: "",
    };
    let position = LinearCombination::coordinate(0);
    Moved {
        train: DynamicModel {
            coordinates: vec!["x".to_string()],
            mass: MassMatrix::Diagonal(vec![1.0]),
            elements: vec![mesh],
            forces: vec![AppliedForce {
                name: "load".to_string(),
                direction: Direction::unit(0),
                signal: load,
            }],
            mass_damping: 0.0,
            global_matrices: None,
        },
        start: vec![1.4, 0.0],
        outputs: MotionOutputs {
            list: vec![
                output("x", OutputQuantity::Position(0)),
                output("x.speed", OutputQuantity::Speed(0)),
            ],
            rows: vec![position],
            ..MotionOutputs::default()
        },
        from: 0.0,
        until: CYCLES * (TAU / omega),
        samples: CYCLES as usize,
    }
}

/// States at the samples, one after another.
type States = Vec<f64>;

impl Moved {
    fn run(
        &self,
        method: &IntegrationMethod,
        size: StepSize,
    ) -> Result<(States, IntegrationStats), String> {
        let options = IntegrationOptions {
            from: self.from,
            to: self.until,
            initial_state: self.start.clone(),
            samples: self.samples,
            step_size: size,
            max_work: BUDGET,
            cancel: CancelToken::default(),
            observer: Observer::default(),
        };
        let mut states = Vec::with_capacity((self.samples + 1) * self.start.len());
        let run = (method.run)(&self.train, &options, &mut |_, y, _| {
            states.extend_from_slice(y);
            ControlFlow::Continue(())
        });
        run.map(|stats| (states, stats)).map_err(|e| e.message)
    }

    /// Every output as a row over the states; what is imposed in time adds to it.
    fn rows(&self) -> Vec<Vec<f64>> {
        let n = self.train.coordinate_count();
        let along = |terms: &[(usize, f64)], offset: usize| {
            let mut row = vec![0.0; self.train.len()];
            terms.iter().for_each(|&(i, a)| row[offset + i] += a);
            row
        };
        let deflection = |at: usize, offset: usize| {
            let terms: Vec<_> = self.train.elements[at].direction.entries().collect();
            along(&terms, offset)
        };
        let rows = self
            .outputs
            .list
            .iter()
            .map(|output| match output.quantity {
                OutputQuantity::Position(at) => along(&self.outputs.rows[at].terms, 0),
                OutputQuantity::Speed(at) => along(&self.outputs.rows[at].terms, n),
                OutputQuantity::Deflection(at) => deflection(at, 0),
                OutputQuantity::Force(at) => match &self.train.elements[at].law {
                    ForceLaw::Linear { stiffness, damping } => deflection(at, 0)
                        .iter()
                        .zip(deflection(at, n))
                        .map(|(x, v)| stiffness * x + damping * v)
                        .collect(),
                    _ => panic!("{} is not linear in the states", output.name),
                },
                _ => panic!("{} is not linear in the states", output.name),
            });
        rows.collect()
    }

    /// The largest size of every output.
    fn sizes(&self, states: &States) -> Vec<f64> {
        let mut sizes = vec![0.0f64; self.outputs.list.len()];
        for (at, y) in states.chunks(self.train.len()).enumerate() {
            let t = self.from + (self.until - self.from) * at as f64 / self.samples as f64;
            let values = self.outputs.evaluate(&self.train, None, t, y);
            sizes
                .iter_mut()
                .zip(values)
                .for_each(|(s, x)| *s = s.max(x.abs()));
        }
        sizes
    }

    fn distance(&self, states: &States, reference: &States) -> f64 {
        let sizes = self.sizes(reference);
        let mut worst: f64 = 0.0;
        for (row, size) in self.rows().iter().zip(sizes) {
            let pairs = states.chunks(row.len()).zip(reference.chunks(row.len()));
            for (y, r) in pairs {
                let off: f64 = (0..row.len()).map(|i| row[i] * (y[i] - r[i])).sum();
                worst = worst.max(off.abs() / size);
            }
        }
        worst
    }
}

/// Ours, then every peer.
fn show(part: &Part) {
    let result = (part.make)();
    let study = SimulateStudy::default();
    let method = method_choice::choose_method(&result.train, &study)
        .expect("some method takes it")
        .method;
    let tightest = StepSize::Adaptive(1e-13);
    let folder = Temporary::new(part.name);
    let machine = folder.path("machine.json");
    fs::write(&machine, result.numbers(part.peers).to_string()).expect("there is room");
    // The reference, and what our own error is measured by.
    let own = || result.run(method, tightest).expect("it moves").0;
    let (reference, other, by) = match part.truth {
        Truth::Exponential => {
            let file = folder.path("truth.bin");
            peers("motion_peer.py", &["truth", text(&machine), text(&file)]);
            match fs::read(&file) {
                Ok(bytes) => (doubles(&bytes), doubles(&bytes), "a matrix exponential"),
                Err(_) => (own(), own(), "itself, for want of Python"),
            }
        }
        Truth::Beside(name) => {
            let beside = methods::method_by_name(name).expect("it is a method");
            let other = result.run(beside, tightest).expect("it moves").0;
            match method.step_control {
                StepControl::Exact => (own(), other, name),
                _ => (other.clone(), other, name),
            }
        }
    };
    println!("{}, errors of ours against {by}", part.title);
    let mut ours = None;
    for (at, name) in std::iter::once(&method.name).chain(part.also).enumerate() {
        let against = if at == 0 { &other } else { &reference };
        let found = cheapest(
            &result,
            methods::method_by_name(name).expect("it is a method"),
            against,
        );
        let Some((label, took)) = found else { continue };
        row(WIDTH, &format!("  {label}"), took, None);
        ours = ours.or(Some(took));
    }
    let Some(ours) = ours else { return };
    let bytes: Vec<u8> = reference.iter().flat_map(|x| x.to_le_bytes()).collect();
    fs::write(folder.path("reference.bin"), bytes).expect("there is room");
    let sizes =
        json!({ "rows": result.rows(), "sizes": result.sizes(&reference), "wanted": WANTED });
    fs::write(folder.path("outputs.json"), sizes.to_string()).expect("there is room");
    for (name, took) in peers("motion_peer.py", &["race", text(&machine)]) {
        row(WIDTH, &format!("    {name}"), ours, Some(took));
    }
}

/// The cheapest run of a method that reaches the wanted error, else its best.
fn cheapest(
    result: &Moved,
    method: &IntegrationMethod,
    against: &States,
) -> Option<(String, Took)> {
    let rungs: &[f64] = match method.step_control {
        StepControl::Exact => &[1e-13],
        _ => &[1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13],
    };
    let mut found: Option<(f64, f64, IntegrationStats)> = None;
    for &tolerance in rungs {
        let Ok((states, stats)) = result.run(method, StepSize::Adaptive(tolerance)) else {
            continue;
        };
        let error = result.distance(&states, against);
        if found.is_none_or(|f| error < f.1) {
            found = Some((tolerance, error, stats));
        }
        if error <= WANTED {
            break;
        }
    }
    let (tolerance, error, stats) = found?;
    let work = || {
        result
            .run(method, StepSize::Adaptive(tolerance))
            .map(|r| r.1)
    };
    let once = best_on_processor(1, work).0;
    let seconds = match once {
        once if once < 0.02 => best((0.5 / once.max(1e-4)) as usize + 3, work).0,
        once if once < 0.5 => best_on_processor(5, work).0,
        once => once,
    };
    let asked = match method.step_control {
        StepControl::Exact => String::new(),
        _ => format!(" at {tolerance:.0e}"),
    };
    let events = match stats.events {
        0 => String::new(),
        events => format!(", {events} events"),
    };
    let error = Some(error);
    Some((
        format!("{}{asked}{events}", method.name),
        Took { seconds, error },
    ))
}

fn doubles(bytes: &[u8]) -> States {
    bytes
        .chunks_exact(8)
        .map(|b| f64::from_le_bytes(b.try_into().expect("eight bytes")))
        .collect()
}

fn text(path: &Path) -> &str {
    path.to_str().expect("the name is plain")
}

/// A folder that goes with its owner.
struct Temporary(PathBuf);

impl Temporary {
    fn new(name: &str) -> Temporary {
        let name = format!("geardyn-bench-{}-{name}", std::process::id());
        let path = std::env::temp_dir().join(name);
        fs::create_dir_all(&path).expect("the temporary folder takes a folder");
        Temporary(path)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

// The machine as numbers.

impl Moved {
    fn numbers(&self, peers: &[&str]) -> Value {
        let model = &self.train;
        let n = model.coordinate_count();
        let mass = match &model.mass {
            MassMatrix::Diagonal(mass) => mass.clone(),
            MassMatrix::Full { .. } => panic!("the peer takes inertias that are not coupled"),
        };
        let rows = |m: &geardyn::internals::numeric::Matrix| -> Vec<Vec<f64>> {
            let row = |i: usize| (0..n).map(|j| m[(i, j)]).collect();
            (0..n).map(row).collect()
        };
        let general = model
            .global_matrices
            .as_ref()
            .map(|(k, c)| json!([rows(k), rows(c)]));
        let drives = model.forces.iter().map(|d| {
            let mut known = signal(&d.signal);
            known["d"] = terms(&d.direction);
            known
        });
        json!({
            "mass": mass,
            "drag": model.mass_damping,
            "general": general,
            "branches": model.elements.iter().map(branch).collect::<Vec<_>>(),
            "drives": drives.collect::<Vec<_>>(),
            "start": self.start,
            "from": self.from,
            "until": self.until,
            "samples": self.samples,
            "is_linear": model.is_linear(),
            "peers": peers,
        })
    }
}

fn terms(direction: &Direction) -> Value {
    json!(direction.entries().collect::<Vec<_>>())
}

/// Knots as time, value, slope; harmonics as amplitude, ω, phase.
fn signal(signal: &Signal) -> Value {
    // JSON has no infinity: what always was so began long ago, with the value its line has at zero.
    const LONG_AGO: f64 = -1e300;
    let knot = |k: &geardyn::internals::motion::signal::Knot| match k.time.is_finite() {
        true => [k.time, k.value, k.slope],
        false => [LONG_AGO, k.value, k.slope],
    };
    let harmonics = signal
        .harmonics
        .iter()
        .map(|h| [h.amplitude, h.omega, h.phase]);
    json!({
        "knots": signal.knots.iter().map(knot).collect::<Vec<_>>(),
        "harmonics": harmonics.collect::<Vec<_>>(),
    })
}

fn branch(b: &ForceElement) -> Value {
    assert!(
        b.angle_waves.is_empty(),
        "{} has an angle-dependent error",
        b.name
    );
    let (kind, numbers) = match &b.law {
        ForceLaw::Linear { stiffness, damping } => ("linear", vec![*stiffness, *damping]),
        ForceLaw::Contact(contact) => {
            assert!(
                contact.flanks == ActiveFlanks::Both,
                "{} has two branches",
                b.name
            );
            let losses = match contact.contact_damping {
                ContactDamping::ActsInGap => 0.0,
                ContactDamping::Adhesive => 1.0,
                ContactDamping::NoPull => 2.0,
                ContactDamping::Continuous => 3.0,
            };
            let (k, c) = (contact.stiffness, contact.damping);
            ("contact", vec![k, c, contact.half_play, losses])
        }
        ForceLaw::Friction(f) => (
            "friction",
            vec![
                f.sliding,
                f.breakaway,
                f.stribeck_velocity,
                f.regularisation_velocity,
            ],
        ),
        ForceLaw::LaggedTorque {
            curve:
                TorqueSpeedCurve::Induction {
                    pull_out,
                    slip,
                    synchronous,
                },
            lag,
        } => ("induction", vec![*pull_out, *slip, *synchronous, *lag]),
        other => panic!("the peer does not take {other:?}"),
    };
    let wave = b.stiffness_wave.as_ref().map(|wave| {
        let WavePhase::Imposed { omega, start } = wave.phase else {
            panic!("{} has a wave that follows an angle", b.name);
        };
        match &wave.waveform {
            Waveform::Rectangular { high, low, duty } => {
                json!({ "omega": omega, "start": start, "steps": [high, low, duty] })
            }
            Waveform::Fourier { mean, terms } => {
                json!({ "omega": omega, "start": start, "mean": mean, "terms": terms })
            }
            Waveform::Table(_) => panic!("{} has a wave from a table", b.name),
        }
    });
    json!({
        "w": terms(&b.direction),
        "u": terms(b.force_direction()),
        "law": kind,
        "numbers": numbers,
        "wave": wave,
        "imposed": b.imposed_displacement.as_ref().map(signal),
    })
}
