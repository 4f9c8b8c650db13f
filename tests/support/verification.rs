//! Figures of the verification manual, asserted where they are measured.
//!
//! `tests/verification/<file>.txt` holds one line for each figure that `docs/verification.md` prints. A run compares each figure with
//! its line; `GEARDYN_RENEW=1` writes the lines of the tests that run. `tests/house/verification.rs` makes the page of them.
#![allow(dead_code, reason = "each test file uses its part")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::{LazyLock, Mutex};

/// Below this a difference is rounding, whose size depends on the machine: the page prints this bound.
const ROUNDING: f64 = 1e-14;
/// Differences below this are rounding times a condition number: their bound is a power of ten.
const BY_DECADE: f64 = 1e-7;
/// By how much rounding may differ on another machine.
const OTHER_MACHINE: f64 = 3.0;
/// Room above a difference that rounding does not make.
const ROOM: f64 = 1.05;
/// How far a measured order may lie below theory.
const ORDER_SHORT: f64 = 0.2;
/// How far a coverage may move, percentage points: a few estimates at the edges of their intervals.
const COVERAGE_MOVES: f64 = 1.0;

/// One line of the manual.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// `difference`, `printed`, `order` or `coverage`.
    pub kind: String,
    pub what: String,
    /// What the source prints, theory says or an interval promises; empty for a difference.
    pub reference: String,
    /// What geardyn gives; empty for a difference.
    pub computed: String,
    /// Relative difference, as a bound; empty for orders and coverage.
    pub difference: String,
}

/// Figures by test.
pub type Figures = BTreeMap<String, Vec<Figure>>;

/// The figures of a test file.
pub fn read(test_file: &str) -> Figures {
    let mut figures = Figures::new();
    let text = std::fs::read_to_string(file(test_file)).unwrap_or_default();
    for line in text.lines() {
        let [test, kind, what, reference, computed, difference] =
            line.split('\t').collect::<Vec<_>>()[..]
        else {
            panic!("{}: {line}", file(test_file).display());
        };
        figures.entry(test.into()).or_default().push(Figure {
            kind: kind.into(),
            what: what.into(),
            reference: reference.into(),
            computed: computed.into(),
            difference: difference.into(),
        });
    }
    figures
}

pub fn write(test_file: &str, figures: &Figures) {
    let lines = figures.iter().flat_map(|(test, list)| {
        list.iter().map(move |f| {
            let columns = [test, &f.kind, &f.what, &f.reference, &f.computed];
            columns.map(String::as_str).join("\t") + "\t" + &f.difference + "\n"
        })
    });
    std::fs::write(file(test_file), lines.collect::<String>()).unwrap();
}

fn file(test_file: &str) -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/verification");
    folder.join(format!("{test_file}.txt"))
}

pub fn renewing() -> bool {
    std::env::var_os("GEARDYN_RENEW").is_some()
}

/// The figures of the files whose tests run.
#[derive(Default)]
struct Book {
    figures: BTreeMap<String, Figures>,
    /// Tests whose lines this run has written, as `file::test`.
    renewed: BTreeSet<String>,
}

static BOOK: LazyLock<Mutex<Book>> = LazyLock::new(Mutex::default);

/// A bound that holds on other machines too.
fn bound(error: f64, tolerance: f64) -> f64 {
    let size = if error < BY_DECADE {
        10f64.powf((error * OTHER_MACHINE).max(ROUNDING).log10().ceil())
    } else {
        let decade = 10f64.powf((error * ROOM).log10().floor());
        (error * ROOM / decade).ceil() * decade
    };
    size.min(tolerance)
}

fn bound_text(error: f64, tolerance: f64) -> String {
    match bound(error, tolerance) {
        0.0 => "0".into(),
        size => format!("≤ {}", short(size)),
    }
}

/// One significant digit: 0.04, 3e-5.
fn short(size: f64) -> String {
    let digits = format!("{size:.0e}");
    match size {
        0.001..1000.0 => digits.parse::<f64>().unwrap().to_string(),
        _ => digits,
    }
}

/// Compares a figure with its line, or writes the line. `holds` says whether the line is still true; `larger` whether this figure replaces
/// one of the same name.
fn record(figure: Figure, holds: impl Fn(&Figure) -> bool, larger: impl Fn(&Figure) -> bool) {
    let thread = std::thread::current();
    // A test thread is named `file::test`.
    let path = thread.name().unwrap_or("main").to_string();
    let (file, test) = path.split_once("::").unwrap_or(("", &path));
    let evidence = ["ref_", "exact_", "order_"];
    let is_case = evidence.iter().any(|prefix| test.starts_with(prefix));
    if file.is_empty() || (figure.kind == "difference" && !is_case) {
        return;
    }
    let mut book = BOOK.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    let is_first = renewing() && book.renewed.insert(path.clone());
    let figures = book.figures.entry(file.into());
    let figures = figures.or_insert_with(|| read(file));
    if renewing() {
        if is_first {
            figures.remove(test);
        }
        let list = figures.entry(test.into()).or_default();
        match list.iter_mut().find(|f| f.what == figure.what) {
            Some(line) if larger(line) => *line = figure,
            Some(_) => return,
            None => list.push(figure),
        }
        write(file, figures);
        return;
    }
    let line = figures.get(test).and_then(|list| {
        let mut same = list.iter().filter(|f| f.what == figure.what);
        same.next().cloned()
    });
    drop(book);
    let renew = format!(
        "run: GEARDYN_RENEW=1 cargo test {file} && GEARDYN_RENEW=1 cargo test --test house"
    );
    match line {
        None => panic!(
            "the verification manual lacks \"{}\" of {test}; {renew}",
            figure.what
        ),
        Some(line) => assert!(
            holds(&line),
            "\"{}\" of {test} no longer holds: the manual prints {line:?}, found {figure:?}; if that is meant, {renew}",
            figure.what
        ),
    }
}

/// The number a text of the manual starts with or bounds.
fn number(text: &str) -> f64 {
    let digits = text.trim_start_matches("≤ ");
    let digits = digits.split(' ').next().unwrap_or_default();
    digits.parse().unwrap_or(f64::NAN)
}

/// Asserts that an error is at most `tolerance`, prints it, and enters it in the manual where the test is a case of it.
pub fn within(what: &str, error: f64, tolerance: f64) {
    println!("{what:44} {error:8.1e}  (allowed {tolerance:.0e})");
    assert!(error <= tolerance, "{what}: {error:.2e} > {tolerance:.0e}");
    let figure = Figure {
        kind: "difference".into(),
        what: what.into(),
        reference: String::new(),
        computed: String::new(),
        difference: bound_text(error, tolerance),
    };
    record(
        figure,
        |line| error <= number(&line.difference),
        |line| bound(error, tolerance) > number(&line.difference),
    );
}

/// Asserts that a value agrees to `tolerance` with one printed in a source, and enters both in the manual. For a value that is right,
/// the tolerance is half a unit of the last digit printed.
pub fn printed(what: &str, unit: &str, reference: f64, value: f64, tolerance: f64) {
    let apart = (value - reference).abs();
    assert!(
        apart <= tolerance,
        "{what}: {value}, printed {reference} {unit}, allowed {tolerance:.0e}"
    );
    let shown = format!("{reference}");
    let written = shown.split_once('.').map_or(0, |(_, digits)| digits.len());
    let allowed = (-(2.0 * tolerance).log10()).ceil().max(0.0) as usize;
    // A tolerance far below the digits written says that the number is exact.
    let decimals = if allowed > written + 2 {
        written
    } else {
        written.max(allowed)
    };
    let difference = match reference {
        0.0 if value == 0.0 => "0".into(),
        0.0 => bound_text(apart, tolerance),
        _ => bound_text(apart / reference.abs(), f64::INFINITY),
    };
    let unit = if unit.is_empty() {
        String::new()
    } else {
        format!(" {unit}")
    };
    let figure = Figure {
        kind: "printed".into(),
        what: what.into(),
        reference: format!("{reference:.decimals$}{unit}"),
        computed: format!("{value:.0$}{unit}", decimals + 2),
        difference,
    };
    let last = 10f64.powi(-(decimals as i32) - 2);
    let same = |line: &Figure| (number(&line.computed) - value).abs() <= 1.01 * last;
    let is_reference = figure.reference.clone();
    record(
        figure,
        |line| same(line) && line.reference == is_reference,
        |_| panic!("{what} is printed twice: give each value a name"),
    );
}

/// `printed` for modes counted from 1.
pub fn printed_modes(unit: &str, references: &[f64], values: &[f64], tolerance: f64) {
    for (i, (reference, value)) in references.iter().zip(values).enumerate() {
        printed(
            &format!("mode {}", i + 1),
            unit,
            *reference,
            *value,
            tolerance,
        );
    }
}

/// Asserts that a measured order of convergence reaches the order of theory, and enters both in the manual.
pub fn order(what: &str, theory: f64, measured: f64) {
    println!("{what:44} order {measured:.2} (theory {theory})");
    assert!(
        measured >= theory - ORDER_SHORT,
        "{what}: order {measured:.2}, theory {theory}"
    );
    let figure = Figure {
        kind: "order".into(),
        what: what.into(),
        reference: format!("{theory}"),
        computed: format!("{measured:.1}"),
        difference: String::new(),
    };
    record(
        figure,
        |line| (number(&line.computed) - measured).abs() <= ORDER_SHORT,
        |line| measured < number(&line.computed),
    );
}

/// Enters in the manual how many of `count` intervals hold the truth. The test asserts the range that is allowed.
pub fn coverage(what: &str, promised: f64, held: usize, count: usize) {
    let share = 100.0 * held as f64 / count as f64;
    println!(
        "{what:44} {share:.1} % of {count} (promised {:.0} %)",
        100.0 * promised
    );
    let figure = Figure {
        kind: "coverage".into(),
        what: what.into(),
        reference: format!("{:.0} %", 100.0 * promised),
        computed: format!("{share:.0} % of {count}"),
        difference: String::new(),
    };
    record(
        figure,
        |line| (number(&line.computed) - share).abs() <= COVERAGE_MOVES,
        |_| panic!("{what} is counted twice: give each count a name"),
    );
}
