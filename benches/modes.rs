//! Modes against SciPy, in one run: whole processes, all modes in process, the lowest 20 of a long chain.
//!
//! `cargo bench --bench modes` prints times, errors against the closed form and ratios. The peer needs `python3` with NumPy and
//! SciPy, on one thread as ours is; where it is missing only our side is shown.

use std::f64::consts::PI;
use std::process::Command;

use beside::{Took, best, python};
use geardyn::internals::modes::modal_basis::{self, LISTED_SHAPE_TOLERANCE, UndampedSolver};
use geardyn::internals::modes::mode_subset::{self, SubsetRequest};
use geardyn::internals::numeric::parallel;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::scene;

mod beside;

/// Of the first column.
const WIDTH: usize = 44;

fn model(n: usize) -> String {
    format!(
        "title = \"chain\"\nsource = \"bench\"\nunits = \"SI\"\n[[chain]]\nname = \"c\"\ncount = {n}\nJ = 1.0\nk = 1.0\nheld = \"start\"\n"
    )
}

/// A spring that closes the chain to a loop and is too soft to change a frequency.
fn closing_spring(n: usize) -> String {
    format!("[[shaft]]\nname = \"loop\"\nbetween = [\"c.1\", \"c.{n}\"]\nk = 1e-20\n")
}

fn prepared(model: &str) -> PreparedMachine {
    let scene = scene::read_text("chain.toml", model).expect("the bench's own model is right");
    PreparedMachine::new(&scene.model).expect("a chain is a machine")
}

/// `ω_j = 2 sin((2j − 1) π / (2(2n + 1)))` of a uniform chain held at its start.
fn exact(n: usize, j: usize) -> f64 {
    2.0 * ((2 * j - 1) as f64 * PI / (2.0 * (2 * n + 1) as f64)).sin()
}

fn worst(n: usize, omega: impl Iterator<Item = f64>) -> f64 {
    omega
        .enumerate()
        .map(|(at, w)| (w / exact(n, at + 1) - 1.0).abs())
        .fold(0.0, f64::max)
}

/// Seconds and worst error of the peer.
fn peer(kind: &str, n: usize) -> Option<Took> {
    beside::peer("peer.py", &[kind, &n.to_string()])
}

fn row(what: &str, (seconds, error): (f64, f64), peer: Option<Took>) {
    let error = Some(error);
    beside::row(WIDTH, what, Took { seconds, error }, peer);
}

fn main() {
    parallel::set_threads(1);
    beside::head(WIDTH, "SciPy");
    let energies = UndampedSolver::Symmetric(LISTED_SHAPE_TOLERANCE);
    for n in [20, 100, 200, 500, 1500] {
        let chain = prepared(&model(n));
        let looped = prepared(&(model(n) + &closing_spring(n)));
        let theirs = peer("dense", n);
        let cases = [
            ("chain, energies", &chain, energies),
            ("chain with a loop, energies", &looped, energies),
            ("chain, factored", &chain, UndampedSolver::Factored),
        ];
        for (name, machine, solver) in cases {
            if solver == UndampedSolver::Factored && n > 500 {
                continue; // an hour's worth of sweeps; large machines reach the digits by the routes above and below
            }
            let runs = (400 / n).clamp(2, 20);
            let (time, found) = best(runs, || {
                modal_basis::solve(&machine.model, solver).expect("it solves")
            });
            let error = worst(n, found.omega.into_iter());
            row(&format!("all, n = {n}, {name}"), (time, error), theirs);
        }
    }
    let n = 100_000;
    let machine = prepared(&model(n));
    let request = SubsetRequest {
        count: 20,
        near_omega: None,
    };
    let (time, found) = best(3, || {
        mode_subset::solve(&machine.model, machine.forest.as_ref(), request).expect("it solves")
    });
    row(
        "lowest 20 of 100 000",
        (time, worst(n, found.modes.iter().map(|m| m.omega()))),
        peer("lowest", n),
    );
    whole_process();
}

/// Start to end of `geardyn modes` on 50 freedoms beside a script that does the same.
fn whole_process() {
    let path = std::env::temp_dir().join(format!("geardyn-bench-{}.toml", std::process::id()));
    std::fs::write(&path, model(50)).expect("the temporary folder takes a file");
    let time = |mut command: Command| {
        let works = command.output().is_ok_and(|output| output.status.success());
        works.then(|| best(20, || command.output()).0)
    };
    let mut ours = Command::new(env!("CARGO_BIN_EXE_geardyn"));
    ours.arg("modes").arg(&path);
    let mut theirs = python();
    theirs
        .arg(concat!(env!("CARGO_MANIFEST_DIR"), "/benches/peer.py"))
        .arg("whole")
        .arg(&path);
    let took = |seconds| Took {
        seconds,
        error: None,
    };
    let theirs = time(theirs).map(took);
    if let Some(seconds) = time(ours) {
        beside::row(WIDTH, "whole process, n = 50", took(seconds), theirs);
    }
    let _ = std::fs::remove_file(path);
}
