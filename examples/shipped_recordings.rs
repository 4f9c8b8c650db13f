//! Writes the recordings of the folder `data`: a work spindle struck, cutting and running up, computed from
//! `models/work_spindle.toml` in its sampled state space, and two encoders of the index branch of `examples/y2250_index_te.toml`, from
//! its transmission error at speed; with measuring noise by Box and Muller (1958) from fixed seeds.
//!
//! `cargo run --release --example shipped_recordings`, in the project's folder; the same program writes the same bytes.

use std::error::Error;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use geardyn::internals::plan::modes_run::{ModesResult, run};
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::stages::ModesPlan;
use geardyn::internals::plan::transmission;
use geardyn::internals::scene;
use geardyn::internals::scene::study::{InputHold, ModesStudy, StateSpaceStudy, StudyKind};

type Outcome<T> = Result<T, Box<dyn Error>>;

const MODEL: &str = "models/work_spindle.toml";

/// Forces along these, in this order.
const INPUTS: [&str; 2] = ["workpiece.x", "workpiece.y"];

/// Accelerations at the workpiece.
const OUTPUTS: [&str; 2] = ["workpiece.x.acceleration", "workpiece.y.acceleration"];

/// The hammer strikes, and the blades cut, so far from x.
const FORCE_ANGLE: f64 = 35.0 * TAU / 360.0;

fn main() -> Outcome<()> {
    struck()?;
    cutting()?;
    run_up()?;
    encoders()
}

/// The machine between its inputs and outputs, every `step` seconds.
fn sampled(step: f64, hold: InputHold) -> Outcome<(PreparedMachine, ModesResult)> {
    let scene = scene::read(Path::new(MODEL))?;
    let prepared = PreparedMachine::new(&scene.model)?;
    let names = |all: [&str; 2]| all.map(str::to_string).to_vec();
    let study = ModesStudy {
        damped: true,
        state_space: Some(StateSpaceStudy {
            inputs: names(INPUTS),
            outputs: names(OUTPUTS),
            sample_time: Some(step),
            method: hold,
        }),
        ..ModesStudy::default()
    };
    let plan = ModesPlan::plan_modes(&prepared, &study);
    let answer = run(&prepared, &study, &plan)?;
    Ok((prepared, answer))
}

/// Accelerations under forces, every `keep`-th sample of them: `x⁺ = A x + B u`, `y = C x + D u`.
fn simulate(answer: &ModesResult, forces: &[[f64; 2]], keep: usize) -> Outcome<Vec<[f64; 2]>> {
    let (space, _) = answer.state_space.as_ref().ok_or("no state space")?;
    let n = space.a.nrows();
    let (mut x, mut next) = (vec![0.0; n], vec![0.0; n]);
    let mut out = Vec::with_capacity(forces.len() / keep + 1);
    for (k, u) in forces.iter().enumerate() {
        if k % keep == 0 {
            out.push([0, 1].map(|i| {
                let state: f64 = (0..n).map(|j| space.c[(i, j)] * x[j]).sum();
                state + space.d[(i, 0)] * u[0] + space.d[(i, 1)] * u[1]
            }));
        }
        for (i, next) in next.iter_mut().enumerate() {
            let state: f64 = (0..n).map(|j| space.a[(i, j)] * x[j]).sum();
            *next = state + space.b[(i, 0)] * u[0] + space.b[(i, 1)] * u[1];
        }
        std::mem::swap(&mut x, &mut next);
    }
    Ok(out)
}

/// Normal numbers of unit variance (Box and Muller, A note on the generation of random normal deviates, Annals of Mathematical
/// Statistics 29 (1958), pp. 610–611).
struct Normal(fastrand::Rng);

impl Normal {
    fn with_seed(seed: u64) -> Normal {
        Normal(fastrand::Rng::with_seed(seed))
    }

    fn draw(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.0.f64()).ln()).sqrt();
        radius * (TAU * self.0.f64()).cos()
    }
}

/// `[truth]`: the modes that move the workpiece sideways.
fn truth(prepared: &PreparedMachine, answer: &ModesResult, more: &str) -> String {
    let at: Vec<usize> = INPUTS
        .iter()
        .filter_map(|name| prepared.machine.dof(name))
        .collect();
    // Torsional modes move it by rounding only.
    const SIDEWAYS: f64 = 1e-9;
    let seen = |shape: &[geardyn::internals::numeric::Complex]| {
        at.iter().any(|&f| shape[f].norm() > SIDEWAYS)
    };
    let modes: Vec<_> = answer.modes.iter().filter(|m| seen(&m.shape)).collect();
    let list = |values: Vec<f64>, digits: usize| {
        let texts: Vec<String> = values.iter().map(|v| format!("{v:.digits$}")).collect();
        texts.join(", ")
    };
    format!(
        "\n# What the model has, to compare with: the modes that move the workpiece sideways.\n[truth]\nmodel = \"{MODEL}\"\nfrequency_hz = [{}]\ndamping_ratio = [{}]\n{more}",
        list(modes.iter().map(|m| m.frequency_hz()).collect(), 4),
        list(
            modes
                .iter()
                .map(|m| m.damping_ratio.unwrap_or(0.0))
                .collect(),
            5
        ),
    )
}

/// Writes a log and its sidecar.
fn put(name: &str, csv: &str, sidecar: &str) -> Outcome<()> {
    fs::write(format!("data/{name}.csv"), csv)?;
    fs::write(format!("data/{name}.toml"), sidecar)?;
    println!("data/{name}.csv  {} kB", csv.len() / 1024);
    Ok(())
}

/// A blow as a hammer gives it: `F sin⁴`, whose spectrum falls by 30 dB an octave beyond three times the inverse of its length.
fn blow(time: f64, start: f64, peak: f64) -> f64 {
    const LENGTH: f64 = 2.4e-3;
    let phase = (time - start) / LENGTH;
    match (0.0..1.0).contains(&phase) {
        true => peak * (0.5 * TAU * phase).sin().powi(4),
        false => 0.0,
    }
}

/// Five hits: the second bounces, the fourth overloads the hammer.
fn struck() -> Outcome<()> {
    const SEED: u64 = 20_240_611;
    const RATE: f64 = 5000.0;
    const FINER: usize = 8;
    const LIMIT: f64 = 2000.0;
    const NOISE: [f64; 3] = [0.3, 0.01, 0.01]; // N, m/s², m/s²
    const SECONDS: f64 = 3.55;
    let hits = [
        (0.2513, 1420.0),
        (0.9024, 1260.0),
        (0.9294, 430.0),
        (1.5577, 1610.0),
        (2.2131, 4300.0),
        (2.8666, 1350.0),
    ];
    let step = 1.0 / (RATE * FINER as f64);
    let (prepared, answer) = sampled(step, InputHold::First)?;
    let count = (SECONDS * RATE) as usize * FINER;
    let force: Vec<f64> = (0..count)
        .map(|k| {
            hits.iter()
                .map(|&(start, peak)| blow(k as f64 * step, start, peak))
                .sum()
        })
        .collect();
    let along: Vec<[f64; 2]> = force
        .iter()
        .map(|f| [f * FORCE_ANGLE.cos(), f * FORCE_ANGLE.sin()])
        .collect();
    let motion = simulate(&answer, &along, FINER)?;
    let mut normal = Normal::with_seed(SEED);
    let mut csv = String::from("time [s],force [N],ax [m/s²],ay [m/s²]\n");
    for (k, a) in motion.iter().enumerate() {
        let noise = NOISE.map(|size| size * normal.draw());
        let measured = (force[k * FINER] + noise[0]).min(LIMIT);
        let (ax, ay) = (a[0] + noise[1], a[1] + noise[2]);
        writeln!(csv, "{:.4},{measured:.1},{ax:.3},{ay:.3}", k as f64 / RATE)?;
    }
    let sidecar = format!(
        "title = \"Impact test of a work spindle: five hits on the workpiece, 35 deg from x\"\nsource = \"simulated by examples/shipped_recordings.rs from {MODEL}; white noise of {} N and {} m/s² rms, seed {SEED}\"\n\n[log]\nrate_from = \"time\"\n\n[[channel]]\nname = \"force\"\noverload = {LIMIT:?}               # N, the range of the hammer\n{}",
        NOISE[0],
        NOISE[1],
        truth(
            &prepared,
            &answer,
            "hits = 5\nhits_double = 1\nhits_clipped = 1\n"
        )
    );
    put("spindle_impact", &csv, &sidecar)
}

/// Cutting: a broad-band force along both directions and the harmonics of the blade groups; nobody measures the force.
fn cutting() -> Outcome<()> {
    const SEED: u64 = 20_240_612;
    const RATE: f64 = 1280.0;
    const SECONDS: f64 = 24.0;
    const GROUPS_HZ: f64 = 21.5; // 15 blade groups at 86 rpm
    const HARMONICS: u32 = 6;
    const BROAD: f64 = 120.0; // N rms
    const FIRST: f64 = 60.0; // N; the harmonics fall with their number
    const NOISE: f64 = 0.01; // m/s²
    let (prepared, answer) = sampled(1.0 / RATE, InputHold::Zero)?;
    let mut normal = Normal::with_seed(SEED);
    let forces: Vec<[f64; 2]> = (0..(SECONDS * RATE) as usize)
        .map(|k| {
            let phase = TAU * GROUPS_HZ * k as f64 / RATE;
            let groups: f64 = (1..=HARMONICS)
                .map(|h| FIRST / f64::from(h) * (f64::from(h) * phase + f64::from(h * h)).cos())
                .sum();
            let broad = [BROAD * normal.draw(), BROAD * normal.draw()];
            [
                broad[0] + groups * FORCE_ANGLE.cos(),
                broad[1] + groups * FORCE_ANGLE.sin(),
            ]
        })
        .collect();
    let motion = simulate(&answer, &forces, 1)?;
    let mut csv = String::from("ax [m/s²],ay [m/s²]\n");
    for a in &motion {
        let [ax, ay] = a.map(|a| a + NOISE * normal.draw());
        writeln!(csv, "{ax:.3},{ay:.3}")?;
    }
    let sidecar = format!(
        "title = \"Vibration of a work spindle while cutting, at the workpiece\"\nsource = \"simulated by examples/shipped_recordings.rs from {MODEL}; broad-band force of {BROAD} N rms each way, harmonics of the blade groups, white noise of {NOISE} m/s² rms, seed {SEED}\"\n\n[log]\nrate = \"{RATE} Hz\"                 # the log has no time stamps\n{}",
        truth(
            &prepared,
            &answer,
            &format!("blade_groups_hz = {GROUPS_HZ}\nharmonics = {HARMONICS}\n")
        )
    );
    put("spindle_cutting", &csv, &sidecar)
}

/// A run-up: the worm turns 30 times with each turn of the spindle and its two threads mesh 60 times.
fn run_up() -> Outcome<()> {
    const SEED: u64 = 20_240_613;
    const RATE: f64 = 2000.0;
    const FINER: usize = 4;
    const SECONDS: f64 = 8.0;
    const RPM: [f64; 2] = [100.0, 400.0];
    const WORM: f64 = 30.0;
    const MESH: f64 = 60.0;
    const WORM_FORCE: f64 = 60.0; // N, from the worm's eccentricity
    const MESH_FORCE: f64 = 25.0; // N
    const NOISE: f64 = 0.01; // m/s²
    const PULSE: f64 = 0.1; // share of a turn
    let (prepared, answer) = sampled(1.0 / (RATE * FINER as f64), InputHold::First)?;
    let turns = |k: usize| {
        let t = k as f64 / (RATE * FINER as f64);
        (RPM[0] * t + (RPM[1] - RPM[0]) * t * t / (2.0 * SECONDS)) / 60.0
    };
    let count = (SECONDS * RATE) as usize * FINER;
    let forces: Vec<[f64; 2]> = (0..count)
        .map(|k| {
            let (worm, mesh) = (TAU * WORM * turns(k), TAU * MESH * turns(k));
            let f = WORM_FORCE * worm.cos() + MESH_FORCE * (mesh + 1.0).cos();
            [f * FORCE_ANGLE.cos(), f * FORCE_ANGLE.sin()]
        })
        .collect();
    let motion = simulate(&answer, &forces, FINER)?;
    let mut normal = Normal::with_seed(SEED);
    let mut csv = String::from("time [s],tacho [V],ax [m/s²],ay [m/s²]\n");
    for (k, a) in motion.iter().enumerate() {
        let [ax, ay] = a.map(|a| a + NOISE * normal.draw());
        let tacho = if turns(k * FINER).fract() < PULSE {
            5
        } else {
            0
        };
        writeln!(csv, "{:.4},{tacho},{ax:.3},{ay:.3}", k as f64 / RATE)?;
    }
    let sidecar = format!(
        "title = \"Run-up of a work spindle from 100 to 400 rpm, with one tacho pulse a turn\"\nsource = \"simulated by examples/shipped_recordings.rs from {MODEL}; order 30 of the worm's eccentricity with {WORM_FORCE} N, order 60 of its mesh with {MESH_FORCE} N, white noise of {NOISE} m/s² rms, seed {SEED}\"\n\n[log]\nrate_from = \"time\"\n{}",
        truth(
            &prepared,
            &answer,
            &format!(
                "pulses_per_turn = 1\nspeed_rpm = [{:?}, {:?}]         # rises evenly in time\norders = [{WORM:?}, {MESH:?}]\n",
                RPM[0], RPM[1]
            )
        )
    );
    put("run_up", &csv, &sidecar)
}

/// Counters of two encoders: on the shaft of the first index change gear and on the work spindle, while the machine rolls.
fn encoders() -> Outcome<()> {
    const SCENE: &str = "examples/y2250_index_te.toml";
    const SEED: u64 = 20_240_614;
    const LINES: [f64; 2] = [10_000.0, 36_000.0];
    const COUNTS_PER_LINE: f64 = 4.0;
    const ROWS_PER_TURN: f64 = 2700.0; // of the spindle, at even speed
    const TURNS: f64 = 3.4;
    const UNEVEN: f64 = 0.01; // of the speed, 7 times a turn
    const NOISE: f64 = 0.4; // counts
    const ARCSEC: f64 = 648_000.0 / std::f64::consts::PI;
    let scene = scene::read(Path::new(SCENE))?;
    let study = scene.studies.iter().find_map(|s| match &s.kind {
        StudyKind::Transmission(study) => Some(study.clone()),
        _ => None,
    });
    let prepared = PreparedMachine::new(&scene.model)?;
    let study = study.ok_or("no study of transmission errors")?;
    let answer = transmission::run::run(&prepared, &study)?;
    let spindle = prepared.machine.dof("work_spindle").ok_or("no spindle")?;
    let first = prepared.machine.dof("index_gear_1").ok_or("no gear")?;
    let ratio = answer.chain.ratio(first).ok_or("no ratio")?.to_f64().abs();
    let lines: Vec<_> = answer
        .lines
        .iter()
        .map(|row| {
            (
                row.line.order.to_f64(),
                row.dynamic.unwrap_or(answer.quasi_static(row)),
            )
        })
        .collect();
    let error = |turns: f64| -> f64 {
        let wave = |(order, z): &(f64, geardyn::internals::numeric::Complex)| {
            z.re * (TAU * order * turns).cos() - z.im * (TAU * order * turns).sin()
        };
        lines.iter().map(wave).sum()
    };
    let speeds = geardyn::internals::machine::kinematics::mean_speeds(
        &prepared.machine,
        &prepared.kinematics,
        study.speed,
    )?;
    let rate = speeds[spindle].abs() / TAU * ROWS_PER_TURN;
    let mut normal = Normal::with_seed(SEED);
    let mut csv = String::from("time [s],index_gear_1 [counts],work_spindle [counts]\n");
    for k in 0..(TURNS * ROWS_PER_TURN) as usize {
        let even = k as f64 / ROWS_PER_TURN;
        let turns = even + UNEVEN / (TAU * 7.0) * (TAU * 7.0 * even).sin();
        let angles = [turns * ratio, turns + error(turns) / TAU];
        let counts: Vec<i64> = angles
            .iter()
            .zip(LINES)
            .map(|(x, n)| (x * n * COUNTS_PER_LINE + NOISE * normal.draw()).floor() as i64)
            .collect();
        writeln!(csv, "{:.5},{},{}", k as f64 / rate, counts[0], counts[1])?;
    }
    let list = |value: &dyn Fn(&(f64, geardyn::internals::numeric::Complex)) -> f64,
                digits: usize| {
        let texts: Vec<String> = lines
            .iter()
            .map(|l| format!("{:.digits$}", value(l)))
            .collect();
        texts.join(", ")
    };
    let sidecar = format!(
        "title = \"Index branch of a Y2250 while it rolls: encoders on the first index change gear and on the work spindle\"\nsource = \"simulated by examples/shipped_recordings.rs from {SCENE}, at its speed; counters of every edge of {} and {} lines, noise of {NOISE} counts rms, speed uneven by {} %, seed {SEED}\"\n\n[log]\nrate_from = \"time\"\n\n# What the scene declares, as it arrives at the spindle at this speed.\n[truth]\nmodel = \"{SCENE}\"\nteeth = \"30:37,54:36,1:90\"\nlines_per_turn = [{}, {}]\norder = [{}]\namplitude_arcsec = [{}]\n",
        LINES[0],
        LINES[1],
        100.0 * UNEVEN,
        LINES[0],
        LINES[1],
        list(&|l| l.0, 0),
        list(&|l| ARCSEC * l.1.norm(), 4),
    );
    put("y2250_te", &csv, &sidecar)
}
