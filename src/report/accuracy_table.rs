//! Error against run time as a table for a terminal.

use super::number::brief;
use super::table::{finish, plain, right_but_first};
use crate::motion::problem::Wanted;
use crate::study::accuracy::{Accuracy, Run};

/// The table, the reference, the recommendation.
pub fn table(outputs: &[String], accuracy: &Accuracy, wanted: f64) -> String {
    let reference = &accuracy.reference;
    let beside = match reference.beside {
        Some(other) => format!(
            "{} and {other} agree to {}, below which no error can be told",
            reference.method,
            brief(reference.agreement)
        ),
        None => format!(
            "{} alone; no second method could check it",
            reference.method
        ),
    };
    let mut text = format!(
        "error in {} (largest difference, by the largest size, worst output) against run time\nreference: {beside}; an error of the start grows {} times\n\n",
        outputs.join(", "),
        brief(reference.amplification),
    );
    let mut table = plain();
    table.set_header([
        "method",
        "at",
        "error",
        "time",
        "steps",
        "rejected",
        "evaluations",
        "events",
    ]);
    for run in accuracy.runs.iter().filter(|r| r.error.is_some()) {
        let e = &run.effort;
        let count = |n: u64| {
            if n == 0 {
                "–".to_string()
            } else {
                n.to_string()
            }
        };
        let error = run.error.map_or(String::new(), |e| format!("{e:.1e}"));
        table.add_row([
            run.method.to_string(),
            at(run),
            error,
            time(run.seconds),
            count(e.steps),
            count(e.rejected),
            count(e.evaluations),
            count(e.events),
        ]);
    }
    right_but_first(&mut table);
    text += &finish(&table);
    let failed: Vec<&Run> = accuracy
        .runs
        .iter()
        .filter(|r| r.failed.is_some())
        .collect();
    if !failed.is_empty() {
        let mut table = plain();
        for run in failed {
            table.add_row([
                run.method.to_string(),
                at(run),
                run.failed.clone().unwrap_or_default(),
            ]);
        }
        text += &format!("\nleft out or failed\n{}", finish(&table));
    }
    text += &match (accuracy.cheapest(wanted), accuracy.runner_up(wanted)) {
        (Some(best), Some(next)) => format!(
            "\nfor {wanted:e} the cheapest is {} ({}), {} × before {}\n",
            named(best),
            time(best.seconds),
            brief_ratio(next.seconds / best.seconds),
            named(next)
        ),
        (Some(best), None) => format!(
            "\nfor {wanted:e} only {} ({}) suffices\n",
            named(best),
            time(best.seconds)
        ),
        (None, _) => format!("\nno run reaches {wanted:e}\n"),
    };
    text
}

fn named(run: &Run) -> String {
    match run.wanted {
        None => run.method.to_string(),
        Some(_) => format!("{} at {}", run.method, at(run)),
    }
}

fn at(run: &Run) -> String {
    match run.wanted {
        Some(Wanted::Tolerance(x)) => format!("{x:.0e}"),
        Some(Wanted::Step(h)) => time(h),
        None => "–".to_string(),
    }
}

pub(super) fn brief_ratio(x: f64) -> String {
    match x {
        x if x >= 10.0 => format!("{x:.0}"),
        x => format!("{x:.1}"),
    }
}

/// A time with a unit that keeps it short.
pub(super) fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 1.0 => format!("{} s", brief(s)),
        s if s >= 1e-3 => format!("{} ms", brief(1e3 * s)),
        s => format!("{} µs", brief(1e6 * s)),
    }
}
