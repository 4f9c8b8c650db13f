//! Error against run time as a table for a terminal.

use super::accuracy_words::{NORM, advice, at, named, off, time};
use super::number::brief;
use super::table::{finish, plain, right_but_first};
use crate::study::accuracy::{Accuracy, Outcome, Run};
use crate::study::reference::{Reference, Witness};

/// The table, the reference, the recommendation.
pub fn table(outputs: &[String], accuracy: &Accuracy, wanted: f64) -> String {
    let mut text = format!(
        "error in {} ({NORM}) against run time\n{}\n",
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
        let Outcome::Ended {
            error,
            seconds,
            effort: e,
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
            at(run.wanted),
            format!("{sign}{}", off(*error)),
            time(*seconds),
            count(e.steps),
            count(e.rejected),
            count(e.evaluations),
            count(e.events),
        ]);
    }
    right_but_first(&mut table);
    text += &finish(&table);
    text += &without_error(&accuracy.runs);
    text += &format!("\n{}\n", advice(accuracy, wanted));
    text
}

/// What the errors are against, and how well that is known.
fn reference(reference: &Reference) -> String {
    let own = named(reference.method, reference.wanted);
    let other = |w: &Witness| named(w.method, w.wanted);
    let mut text = match &reference.witnesses[..] {
        [] => format!("reference: {own} alone; nothing could check it\n"),
        [near, ..] if near.related => format!(
            "reference: {own}, {} from itself at {}; no unrelated method could check it\n",
            off(near.distance),
            at(near.wanted),
        ),
        [near, rest @ ..] => {
            let mut text = format!(
                "reference: {own}; {}, an unrelated method, agrees to {}, below which no error can be told\n",
                other(near),
                off(near.distance)
            );
            for far in rest {
                text += &format!(
                    "           {} agrees to {}\n",
                    other(far),
                    off(far.distance)
                );
            }
            text
        }
    };
    for (method, why) in &reference.silent {
        text += &format!("           {method}: {why}\n");
    }
    text + &match reference.amplification {
        Some(growth) => format!(
            "a change of the start shows {} times as much over the whole time as over its first tenth\n",
            brief(growth)
        ),
        None => "how a change of the start grows is not known: nothing moves, or it ended early\n"
            .to_string(),
    }
}

/// Rungs without an error, those of one method with one reason in a line.
fn without_error(runs: &[Run]) -> String {
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
            0 => at(run.wanted),
            _ => format!("{} and finer", at(run.wanted)),
        };
        table.add_row([run.method.to_string(), rungs, why.to_string()]);
    }
    match table.row_count() {
        0 => String::new(),
        _ => format!("\nleft out or failed\n{}", finish(&table)),
    }
}
