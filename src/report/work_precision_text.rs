//! Sentences about work–precision results: norm, recommendation, method labels.

use super::number_format::four_digits;
use crate::motion::problem::StepSize;
use crate::study::work_precision::{Recommendation, WorkPrecisionResult, WorkPrecisionRun};

/// The norm of errors, as text.
pub const NORM_TEXT: &str =
    "largest difference over all samples, by the largest size of the reference, worst output";

/// Recommended method for the requested error.
pub fn recommendation_text(accuracy: &WorkPrecisionResult, wanted: f64) -> String {
    let of = |run: &WorkPrecisionRun| {
        let time = run.seconds().map_or(String::new(), format_time_short);
        format!("{} ({time})", method_label(run.method, run.step_size))
    };
    let ratio =
        |best: &WorkPrecisionRun, next: &WorkPrecisionRun| match (best.seconds(), next.seconds()) {
            (Some(best), Some(next)) => brief_ratio(next / best),
            _ => String::new(),
        };
    match accuracy.recommend(wanted) {
        Recommendation::Cheapest(best, Some(next)) => format!(
            "for {wanted:e} the cheapest is {}, {} × before {}",
            of(best),
            ratio(best, next),
            method_label(next.method, next.step_size)
        ),
        Recommendation::Cheapest(best, None) => {
            format!("for {wanted:e} only {} is sufficient", of(best))
        }
        Recommendation::Nearest(run) => {
            let mut text = format!(
                "no run reaches {wanted:e}; nearest is {} with {}",
                of(run),
                run.error().map_or(String::new(), format_error)
            );
            if let Some(known) = accuracy.reference.agreement().filter(|x| *x > wanted) {
                text += &format!(
                    ", and the reference has an error of {}",
                    format_error(known)
                );
            }
            text
        }
        Recommendation::Unavailable => {
            "no run completed, so that none can be recommended".to_string()
        }
    }
}

/// Label of a method with its requested setting.
pub fn method_label(method: &str, size: Option<StepSize>) -> String {
    match size {
        None => method.to_string(),
        Some(_) => format!("{method} at {}", setting_text(size)),
    }
}

/// Requested setting of a run.
pub fn setting_text(size: Option<StepSize>) -> String {
    match size {
        Some(StepSize::Adaptive(x)) => format!("{x:.0e}"),
        Some(StepSize::Fixed(h)) => format_time_short(h),
        None => "–".to_string(),
    }
}

/// Tolerance and step: the requested one.
pub fn tolerance_and_step(size: Option<StepSize>) -> (Option<f64>, Option<f64>) {
    match size {
        Some(StepSize::Adaptive(x)) => (Some(x), None),
        Some(StepSize::Fixed(h)) => (None, Some(h)),
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
pub fn format_time_short(seconds: f64) -> String {
    match seconds {
        s if s >= 1.0 => format!("{} s", four_digits(s)),
        s if s >= 1e-3 => format!("{} ms", four_digits(1e3 * s)),
        s => format!("{} µs", four_digits(1e6 * s)),
    }
}

/// A relative error, to two digits.
pub fn format_error(error: f64) -> String {
    format!("{error:.1e}")
}
