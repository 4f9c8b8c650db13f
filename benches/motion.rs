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
use geardyn::base::stop::Stop;
use geardyn::machine::direction::Direction;
use geardyn::motion::combination::Combination;
use geardyn::motion::contact::{Contact, Flanks, Losses};
use geardyn::motion::methods::{self, Ladder, Method};
use geardyn::motion::outputs::{Output, Outputs, Quantity};
use geardyn::motion::problem::{Ask, Effort, Follower, Problem, Wanted};
use geardyn::motion::signal::Signal;
use geardyn::motion::train::{Branch, Drive, Law, Mass, Train};
use geardyn::motion::wave::{Phase, Shape, Wave};
use geardyn::plan::motion::choice;
use geardyn::plan::motion::scene::MotionScene;
use geardyn::plan::prepared::Prepared;
use geardyn::scene;
use geardyn::scene::laws::Curve;
use geardyn::scene::study::{SimulateStudy, StudyKind};
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
    train: Train,
    start: Vec<f64>,
    outputs: Outputs,
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
        until: Some(until),
        samples: Some(samples),
        outputs: match all.iter().find(|m| m.speed.is_some()) {
            Some(first) => first.outputs.clone(),
            None => all.last().expect("it moves").outputs.clone(),
        },
        speed: all[0].speed,
        ..SimulateStudy::default()
    };
    let prepared = Prepared::new(&scene.model).expect("the model is a machine");
    let ready = MotionScene::new(&prepared, &scene.start, &study).expect("it can move");
    Moved {
        train: ready.moving.train,
        start: ready.start,
        outputs: ready.outputs,
        from: 0.0,
        until,
        samples: samples as usize,
    }
}

/// The same from an instant on, from where it is then.
fn later(mut moved: Moved, from: f64) -> Moved {
    let (until, samples) = (moved.until, moved.samples);
    (moved.until, moved.samples) = (from, 1);
    let explicit = methods::find("dop853-events").expect("it is a method");
    let run = moved.run(explicit, Wanted::Tolerance(1e-10));
    let states = run.expect("it moves").0;
    moved.start = states[moved.start.len()..].to_vec();
    (moved.from, moved.until, moved.samples) = (from, until, samples);
    moved
}

/// A gear pair over its mesh cycles, seen at their ends.
fn cycles(name: &str) -> Moved {
    let mut moved = in_turning_frame(shipped(name, 1.0, 1));
    let mesh = moved
        .train
        .branches
        .iter()
        .find_map(|b| b.variation.as_ref());
    let Some(Phase::Imposed { omega, .. }) = mesh.map(|wave| &wave.phase) else {
        panic!("{name} has a mesh at a speed that is imposed");
    };
    moved.until = CYCLES * (TAU / omega);
    moved.samples = CYCLES as usize;
    moved
}

/// Where nothing resists the turning at the speeds of the start, they are taken off: motion is then that about the turning, whose
/// angle would hide it behind its digits.
fn in_turning_frame(mut moved: Moved) -> Moved {
    let n = moved.train.n();
    let speeds = moved.start[n..2 * n].to_vec();
    for b in &moved.train.branches {
        let size = b.direction.scaled().map(|(i, a)| (a * speeds[i]).abs());
        let size = size.fold(0.0, f64::max);
        assert!(
            b.direction.dot(&speeds).abs() <= 1e-12 * size,
            "{} resists the turning",
            b.name
        );
    }
    moved.start[n..2 * n].fill(0.0);
    moved
}

/// `x″ + 0.1 x′ + (1 + 0.2 cos Ωt) g(x) = 0.1 + 0.05 Ω² cos Ωt`, half-gap one, Ω = 0.85, from (1.4, 0).
fn one_freedom() -> Moved {
    let omega = 0.85;
    let shape = Shape::Fourier {
        mean: 1.0,
        terms: vec![(1, 0.2, 0.0)],
    };
    let phase = Phase::Imposed { omega, start: 0.0 };
    let mesh = Branch {
        name: "mesh".to_string(),
        direction: Direction::of(0),
        force: None,
        law: Law::Contact(Contact {
            stiffness: 1.0,
            damping: 0.1,
            half: 1.0,
            losses: Losses::Throughout,
            flanks: Flanks::Both,
        }),
        variation: Some(Wave { shape, phase }),
        imposed: None,
        followed: Vec::new(),
    };
    let load = Signal::constant(0.1).plus(&Signal::harmonic(0.05 * omega * omega, omega, 0.0));
    let output = |name: &str, quantity| Output {
        name: name.to_string(),
        quantity,
        unit: "",
    };
    let position = Combination::of(0);
    Moved {
        train: Train {
            coordinates: vec!["x".to_string()],
            mass: Mass::Diagonal(vec![1.0]),
            branches: vec![mesh],
            drives: vec![Drive {
                name: "load".to_string(),
                direction: Direction::of(0),
                signal: load,
            }],
            drag: 0.0,
            general: None,
        },
        start: vec![1.4, 0.0],
        outputs: Outputs {
            list: vec![
                output("x", Quantity::Position(0)),
                output("x.speed", Quantity::Speed(0)),
            ],
            rows: vec![position],
            ..Outputs::default()
        },
        from: 0.0,
        until: CYCLES * (TAU / omega),
        samples: CYCLES as usize,
    }
}

/// States at the samples, one after another.
type States = Vec<f64>;

impl Moved {
    fn run(&self, method: &Method, wanted: Wanted) -> Result<(States, Effort), String> {
        let ask = Ask {
            from: self.from,
            to: self.until,
            start: self.start.clone(),
            samples: self.samples,
            effort: wanted,
            budget: BUDGET,
            stop: Stop::default(),
            follower: Follower::default(),
        };
        let mut states = Vec::with_capacity((self.samples + 1) * self.start.len());
        let run = (method.run)(&self.train, &ask, &mut |_, y, _| {
            states.extend_from_slice(y);
            ControlFlow::Continue(())
        });
        run.map(|effort| (states, effort)).map_err(|e| e.message)
    }

    /// Every output as a row over the states; what is imposed in time adds to it.
    fn rows(&self) -> Vec<Vec<f64>> {
        let n = self.train.n();
        let along = |terms: &[(usize, f64)], offset: usize| {
            let mut row = vec![0.0; self.train.len()];
            terms.iter().for_each(|&(i, a)| row[offset + i] += a);
            row
        };
        let deflection = |at: usize, offset: usize| {
            let terms: Vec<_> = self.train.branches[at].direction.scaled().collect();
            along(&terms, offset)
        };
        let rows = self
            .outputs
            .list
            .iter()
            .map(|output| match output.quantity {
                Quantity::Position(at) => along(&self.outputs.rows[at].terms, 0),
                Quantity::Speed(at) => along(&self.outputs.rows[at].terms, n),
                Quantity::Deflection(at) => deflection(at, 0),
                Quantity::Force(at) => match &self.train.branches[at].law {
                    Law::Linear { stiffness, damping } => deflection(at, 0)
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
            let values = self.outputs.at(&self.train, None, t, y);
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
    let moved = (part.make)();
    let study = SimulateStudy::default();
    let method = choice::choose(&moved.train, &study)
        .expect("some method takes it")
        .method;
    let tightest = Wanted::Tolerance(1e-13);
    let folder = Temporary::new(part.name);
    let machine = folder.path("machine.json");
    fs::write(&machine, moved.numbers(part.peers).to_string()).expect("there is room");
    // The reference, and what our own error is measured by.
    let own = || moved.run(method, tightest).expect("it moves").0;
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
            let beside = methods::find(name).expect("it is a method");
            let other = moved.run(beside, tightest).expect("it moves").0;
            match method.ladder {
                Ladder::Exact => (own(), other, name),
                _ => (other.clone(), other, name),
            }
        }
    };
    println!("{}, errors of ours against {by}", part.title);
    let mut ours = None;
    for (at, name) in std::iter::once(&method.name).chain(part.also).enumerate() {
        let against = if at == 0 { &other } else { &reference };
        let found = cheapest(
            &moved,
            methods::find(name).expect("it is a method"),
            against,
        );
        let Some((label, took)) = found else { continue };
        row(WIDTH, &format!("  {label}"), took, None);
        ours = ours.or(Some(took));
    }
    let Some(ours) = ours else { return };
    let bytes: Vec<u8> = reference.iter().flat_map(|x| x.to_le_bytes()).collect();
    fs::write(folder.path("reference.bin"), bytes).expect("there is room");
    let sizes = json!({ "rows": moved.rows(), "sizes": moved.sizes(&reference), "wanted": WANTED });
    fs::write(folder.path("outputs.json"), sizes.to_string()).expect("there is room");
    for (name, took) in peers("motion_peer.py", &["race", text(&machine)]) {
        row(WIDTH, &format!("    {name}"), ours, Some(took));
    }
}

/// The cheapest run of a method that reaches the wanted error, else its best.
fn cheapest(moved: &Moved, method: &Method, against: &States) -> Option<(String, Took)> {
    let rungs: &[f64] = match method.ladder {
        Ladder::Exact => &[1e-13],
        _ => &[1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13],
    };
    let mut found: Option<(f64, f64, Effort)> = None;
    for &tolerance in rungs {
        let Ok((states, effort)) = moved.run(method, Wanted::Tolerance(tolerance)) else {
            continue;
        };
        let error = moved.distance(&states, against);
        if found.is_none_or(|f| error < f.1) {
            found = Some((tolerance, error, effort));
        }
        if error <= WANTED {
            break;
        }
    }
    let (tolerance, error, effort) = found?;
    let work = || moved.run(method, Wanted::Tolerance(tolerance)).map(|r| r.1);
    let once = best_on_processor(1, work).0;
    let seconds = match once {
        once if once < 0.02 => best((0.5 / once.max(1e-4)) as usize + 3, work).0,
        once if once < 0.5 => best_on_processor(5, work).0,
        once => once,
    };
    let asked = match method.ladder {
        Ladder::Exact => String::new(),
        _ => format!(" at {tolerance:.0e}"),
    };
    let events = match effort.events {
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
        let train = &self.train;
        let n = train.n();
        let mass = match &train.mass {
            Mass::Diagonal(mass) => mass.clone(),
            Mass::Full { .. } => panic!("the peer takes inertias that are not coupled"),
        };
        let rows = |m: &geardyn::numeric::Matrix| -> Vec<Vec<f64>> {
            let row = |i: usize| (0..n).map(|j| m[(i, j)]).collect();
            (0..n).map(row).collect()
        };
        let general = train
            .general
            .as_ref()
            .map(|(k, c)| json!([rows(k), rows(c)]));
        let drives = train.drives.iter().map(|d| {
            let mut known = signal(&d.signal);
            known["d"] = terms(&d.direction);
            known
        });
        json!({
            "mass": mass,
            "drag": train.drag,
            "general": general,
            "branches": train.branches.iter().map(branch).collect::<Vec<_>>(),
            "drives": drives.collect::<Vec<_>>(),
            "start": self.start,
            "from": self.from,
            "until": self.until,
            "samples": self.samples,
            "is_linear": train.is_linear(),
            "peers": peers,
        })
    }
}

fn terms(direction: &Direction) -> Value {
    json!(direction.scaled().collect::<Vec<_>>())
}

/// Knots as time, value, slope; harmonics as amplitude, ω, phase.
fn signal(signal: &Signal) -> Value {
    // JSON has no infinity: what always was so began long ago, with the value its line has at zero.
    const LONG_AGO: f64 = -1e300;
    let knot = |k: &geardyn::motion::signal::Knot| match k.time.is_finite() {
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

fn branch(b: &Branch) -> Value {
    assert!(
        b.followed.is_empty(),
        "{} has an error that follows an angle",
        b.name
    );
    let (kind, numbers) = match &b.law {
        Law::Linear { stiffness, damping } => ("linear", vec![*stiffness, *damping]),
        Law::Contact(contact) => {
            assert!(
                contact.flanks == Flanks::Both,
                "{} has two branches",
                b.name
            );
            let losses = match contact.losses {
                Losses::Throughout => 0.0,
                Losses::Adhesive => 1.0,
                Losses::NoPull => 2.0,
                Losses::Continuous => 3.0,
            };
            let (k, c) = (contact.stiffness, contact.damping);
            ("contact", vec![k, c, contact.half, losses])
        }
        Law::Friction(f) => (
            "friction",
            vec![f.sliding, f.breakaway, f.stribeck, f.creep],
        ),
        Law::Lagged {
            curve:
                Curve::Induction {
                    pull_out,
                    slip,
                    synchronous,
                },
            lag,
        } => ("induction", vec![*pull_out, *slip, *synchronous, *lag]),
        other => panic!("the peer does not take {other:?}"),
    };
    let wave = b.variation.as_ref().map(|wave| {
        let Phase::Imposed { omega, start } = wave.phase else {
            panic!("{} has a wave that follows an angle", b.name);
        };
        match &wave.shape {
            Shape::Rectangular { high, low, duty } => {
                json!({ "omega": omega, "start": start, "steps": [high, low, duty] })
            }
            Shape::Fourier { mean, terms } => {
                json!({ "omega": omega, "start": start, "mean": mean, "terms": terms })
            }
            Shape::Table(_) => panic!("{} has a wave from a table", b.name),
        }
    });
    json!({
        "w": terms(&b.direction),
        "u": terms(b.acts()),
        "law": kind,
        "numbers": numbers,
        "wave": wave,
        "imposed": b.imposed.as_ref().map(signal),
    })
}
