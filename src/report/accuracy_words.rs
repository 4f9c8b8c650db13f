//! What is said of error against run time.

use super::number::brief;
use crate::motion::problem::Wanted;
use crate::study::accuracy::{Accuracy, Advice, Run};

/// The norm of errors, in words.
pub const NORM: &str =
    "largest difference over all samples, by the largest size of the reference, worst output";

/// What is to be taken for the error wanted.
pub fn advice(accuracy: &Accuracy, wanted: f64) -> String {
    let of = |run: &Run| {
        let time = run.seconds().map_or(String::new(), time);
        format!("{} ({time})", named(run.method, run.wanted))
    };
    let ratio = |best: &Run, next: &Run| match (best.seconds(), next.seconds()) {
        (Some(best), Some(next)) => brief_ratio(next / best),
        _ => String::new(),
    };
    match accuracy.advice(wanted) {
        Advice::Cheapest(best, Some(next)) => format!(
            "for {wanted:e} the cheapest is {}, {} × before {}",
            of(best),
            ratio(best, next),
            named(next.method, next.wanted)
        ),
        Advice::Cheapest(best, None) => format!("for {wanted:e} only {} suffices", of(best)),
        Advice::Nearest(run) => {
            let mut text = format!(
                "no run reaches {wanted:e}; nearest is {} with {}",
                of(run),
                run.error().map_or(String::new(), off)
            );
            if let Some(known) = accuracy.reference.agreement().filter(|x| *x > wanted) {
                text += &format!(", and the reference itself is known to {} only", off(known));
            }
            text
        }
        Advice::Nothing => "no run came to its end, so that none can be recommended".to_string(),
    }
}

/// A method with what it was asked.
pub fn named(method: &str, wanted: Option<Wanted>) -> String {
    match wanted {
        None => method.to_string(),
        Some(_) => format!("{method} at {}", at(wanted)),
    }
}

/// What a rung was asked.
pub fn at(wanted: Option<Wanted>) -> String {
    match wanted {
        Some(Wanted::Tolerance(x)) => format!("{x:.0e}"),
        Some(Wanted::Step(h)) => time(h),
        None => "–".to_string(),
    }
}

/// Tolerance and step: the one that was asked.
pub fn asked(wanted: Option<Wanted>) -> (Option<f64>, Option<f64>) {
    match wanted {
        Some(Wanted::Tolerance(x)) => (Some(x), None),
        Some(Wanted::Step(h)) => (None, Some(h)),
        None => (None, None),
    }
}

fn brief_ratio(x: f64) -> String {
    match x {
        x if x >= 10.0 => format!("{x:.0}"),
        x => format!("{x:.1}"),
    }
}

/// A time with a unit that keeps it short.
pub fn time(seconds: f64) -> String {
    match seconds {
        s if s >= 1.0 => format!("{} s", brief(s)),
        s if s >= 1e-3 => format!("{} ms", brief(1e3 * s)),
        s => format!("{} µs", brief(1e6 * s)),
    }
}

/// A relative error, to two digits.
pub fn off(error: f64) -> String {
    format!("{error:.1e}")
}
