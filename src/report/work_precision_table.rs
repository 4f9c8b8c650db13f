//! Work–precision results as a terminal table.

use super::modes_table::{finish, plain, right_but_first};
use super::number_format::four_digits;
use super::work_precision_text::{
    NORM_TEXT, format_error, format_time_short, method_label, recommendation_text, setting_text,
};
use crate::study::reference::{CrossCheck, ReferenceSolution};
use crate::study::work_precision::{RunOutcome, WorkPrecisionResult, WorkPrecisionRun};

/// The table, the reference, the recommendation.
pub fn table(outputs: &[String], accuracy: &WorkPrecisionResult, wanted: f64) -> String {
    let mut text = format!(
        "error in {} ({NORM_TEXT}) against run time\n{}\n",
        outputs.join(", "),
        reference(&accuracy.reference)
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
    let known = accuracy.reference.agreement();
    for run in &accuracy.runs {
        let RunOutcome::Completed {
            error,
            seconds,
            stats: e,
        } = &run.outcome
        else {
            continue;
        };
        let count = |n: u64| match n {
            0 => "–".to_string(),
            n => n.to_string(),
        };
        let sign = match known.is_some_and(|known| *error <= known) {
            true => "≤ ",
            false => "",
        };
        table.add_row([
            run.method.to_string(),
            setting_text(run.step_size),
            format!("{sign}{}", format_error(*error)),
            format_time_short(*seconds),
            count(e.steps),
            count(e.rejected),
            count(e.evaluations),
            count(e.events),
        ]);
    }
    right_but_first(&mut table);
    text += &finish(&table);
    text += &failed_runs_text(&accuracy.runs);
    text += &format!("\n{}\n", recommendation_text(accuracy, wanted));
    text
}

/// Reference of the errors, and its own accuracy.
fn reference(reference: &ReferenceSolution) -> String {
    let own = method_label(reference.method, reference.step_size);
    let other = |w: &CrossCheck| method_label(w.method, w.step_size);
    let mut text = match &reference.cross_checks[..] {
        [] => format!("reference: {own} alone; nothing could check it\n"),
        [near, ..] if near.related => format!(
            "reference: {own}, {} from itself at {}; no unrelated method could check it\n",
            format_error(near.distance),
            setting_text(near.step_size),
        ),
        [near, rest @ ..] => {
            let mut text = format!(
                "reference: {own}; {}, an unrelated method, agrees to {}, below which no error can be told\n",
                other(near),
                format_error(near.distance)
            );
            for far in rest {
                text += &format!(
                    "           {} agrees to {}\n",
                    other(far),
                    format_error(far.distance)
                );
            }
            text
        }
    };
    for (method, why) in &reference.unavailable {
        text += &format!("           {method}: {why}\n");
    }
    text + &match reference.sensitivity {
        Some(growth) => format!(
            "a change of the start shows {} times as much over the whole time as over its first tenth\n",
            four_digits(growth)
        ),
        None => "how a change of the start grows is not known: nothing moves, or it ended early\n"
            .to_string(),
    }
}

/// Rungs without an error, those of one method with one reason in a line.
fn failed_runs_text(runs: &[WorkPrecisionRun]) -> String {
    let mut table = plain();
    let mut before = None;
    let rows = runs.iter().filter_map(|r| Some((r, r.reason()?)));
    for (place, (run, why)) in rows.clone().enumerate() {
        if before == Some((run.method, why)) {
            continue;
        }
        before = Some((run.method, why));
        let alike = rows.clone().skip(place + 1);
        let more = alike
            .take_while(|(r, other)| (r.method, *other) == (run.method, why))
            .count();
        let rungs = match more {
            0 => setting_text(run.step_size),
            _ => format!("{} and finer", setting_text(run.step_size)),
        };
        table.add_row([run.method.to_string(), rungs, why.to_string()]);
    }
    match table.row_count() {
        0 => String::new(),
        _ => format!("\nleft out or failed\n{}", finish(&table)),
    }
}
