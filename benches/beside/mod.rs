//! Ours beside a peer's: best times, the peer's answer, rows of a table.
#![allow(dead_code, reason = "each bench takes what it needs")]

use std::process::{Command, Stdio};
use std::time::Instant;

/// Best time of some runs, s, and the error of the answer where there is a truth.
#[derive(Clone, Copy)]
pub struct Took {
    /// Best time, s.
    pub seconds: f64,
    /// Relative error.
    pub error: Option<f64>,
}

/// The least time of some runs, s, and the last answer.
pub fn best<T>(runs: usize, work: impl FnMut() -> T) -> (f64, T) {
    let start = Instant::now();
    best_by(|| start.elapsed().as_secs_f64(), runs, work)
}

/// The least time on the processor of some runs, s, and the last answer: that of all threads; what others run meanwhile does not count.
/// To some milliseconds; where the system does not say, the least time that passed.
pub fn best_on_processor<T>(runs: usize, work: impl FnMut() -> T) -> (f64, T) {
    let on_processor = || -> Option<f64> {
        let mut seconds = 0.0;
        for thread in std::fs::read_dir("/proc/self/task").ok()? {
            let text = std::fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
            let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
            seconds += 1e-9 * nanoseconds;
        }
        Some(seconds)
    };
    match on_processor() {
        Some(_) => best_by(|| on_processor().unwrap_or(f64::NAN), runs, work),
        None => best(runs, work),
    }
}

fn best_by<T>(clock: impl Fn() -> f64, runs: usize, mut work: impl FnMut() -> T) -> (f64, T) {
    let mut found = None;
    let mut least = f64::INFINITY;
    for _ in 0..runs {
        let start = clock();
        let answer = work();
        least = least.min(clock() - start);
        found = Some(answer);
    }
    (least, found.expect("at least one run"))
}

/// Python on one thread.
pub fn python() -> Command {
    let mut command = Command::new("python3");
    for variable in [
        "OPENBLAS_NUM_THREADS",
        "OMP_NUM_THREADS",
        "MKL_NUM_THREADS",
        "POLARS_MAX_THREADS",
    ] {
        command.env(variable, "1");
    }
    command
}

/// What a script of this folder prints as `seconds error`; `None` where Python or a package is missing.
pub fn peer(script: &str, arguments: &[&str]) -> Option<Took> {
    Some(took(&printed(script, arguments)?)?.0)
}

/// What a script of this folder prints as lines of `seconds error name`; none where Python or a package is missing.
pub fn peers(script: &str, arguments: &[&str]) -> Vec<(String, Took)> {
    let text = printed(script, arguments).unwrap_or_default();
    let line = |line: &str| took(line).map(|(took, name)| (name, took));
    text.lines().filter_map(line).collect()
}

fn printed(script: &str, arguments: &[&str]) -> Option<String> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/benches/");
    let script = format!("{folder}{script}");
    // What a script says of its failure is shown.
    let mut command = python();
    command.arg(script).args(arguments).stderr(Stdio::inherit());
    let output = command.output().ok()?;
    String::from_utf8(output.stdout).ok()
}

fn took(line: &str) -> Option<(Took, String)> {
    let mut words = line.split_whitespace();
    let took = Took {
        seconds: words.next()?.parse().ok()?,
        error: words.next()?.parse().ok(),
    };
    Some((took, words.collect::<Vec<_>>().join(" ")))
}

/// The names of the columns, the first `width` wide.
pub fn head(width: usize, peer: &str) {
    println!(
        "{:<width$} {:>13} {:>9} {:>13} {:>9} {:>8}",
        "", "geardyn", "error", peer, "error", "ratio"
    );
}

/// One row; what is not there is a dash.
pub fn row(width: usize, what: &str, ours: Took, peer: Option<Took>) {
    let shown = |took: Took| {
        let error = took.error.map_or("–".to_string(), |e| format!("{e:.1e}"));
        format!("{:>10.3} ms {error:>9}", 1e3 * took.seconds)
    };
    // A peer that was given up has no time.
    let peer = peer.filter(|p| p.seconds.is_finite());
    let theirs = peer.map_or(format!("{:>13} {:>9}", "–", "–"), shown);
    let ratio = peer.map_or("–".to_string(), |p| {
        format!("{:.2}", p.seconds / ours.seconds)
    });
    println!("{what:<width$} {} {theirs} {ratio:>8}", shown(ours));
}
