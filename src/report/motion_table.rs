//! Motion in time as tables for a terminal.

use super::number::{brief, held, percent};
use super::table::{finish, plain, right_but_first};
use crate::base::words::counted;
use crate::motion::meter::Balance;
use crate::plan::motion::reading::step;
use crate::plan::motion::run::Motion;
use crate::plan::motion::scene::MotionScene;
use crate::plan::motion::sensitivity::{Digits, Sensitivity};

/// Extremes and means of every output, with the digits that hold.
pub fn readings(scene: &MotionScene, motion: &Motion, sensitivity: Option<&Sensitivity>) -> String {
    let mut table = plain();
    table.set_header([
        "output",
        "unit",
        "end",
        "least",
        "at s",
        "greatest",
        "at s",
        "mean",
        "rms about it",
    ]);
    for (at, (output, reading)) in scene.outputs.list.iter().zip(&motion.readings).enumerate() {
        let Some(r) = reading else {
            continue;
        };
        let numbers = [
            r.end,
            r.least.0,
            r.least.1,
            r.greatest.0,
            r.greatest.1,
            r.mean,
            r.rms,
        ];
        let errors = sensitivity.map_or([Some(0.0); 7], |s| errors(&s.outputs[at]));
        // What differs from zero by less than a digit shown of the largest value is zero.
        let slight = SLIGHT * r.greatest.0.abs().max(r.least.0.abs());
        let cells = numbers.iter().zip(errors).map(|(x, error)| {
            let text = error.and_then(|error| held(*x, error));
            text.unwrap_or_else(|| match error {
                Some(error) if error <= slight => "0".to_string(),
                _ => "–".to_string(),
            })
        });
        table.add_row(
            [output.name.clone(), output.unit.to_string()]
                .into_iter()
                .chain(cells),
        );
    }
    right_but_first(&mut table);
    finish(&table)
}

/// Half a unit of the fourth digit of what is largest.
const SLIGHT: f64 = 5e-5;

/// What each number of a row may be off by.
fn errors(d: &Digits) -> [Option<f64>; 7] {
    [
        d.end,
        d.least,
        d.least_at,
        d.greatest,
        d.greatest_at,
        Some(d.mean),
        Some(d.rms),
    ]
}

/// Answers to a step at an instant.
pub fn steps(scene: &MotionScene, motion: &Motion, at: f64) -> String {
    let mut table = plain();
    table.set_header([
        "answer to the step",
        "before",
        "after",
        "overshoot %",
        "after s",
        "rise s",
        "settled s",
        "oscillations",
    ]);
    let mut restless = Vec::new();
    for (output, values) in scene.outputs.list.iter().zip(&motion.values) {
        match step(&motion.time, values, at) {
            None => restless.push(output.name.as_str()),
            Some(a) => {
                let numbers = [
                    brief(a.before),
                    brief(a.after),
                    percent(a.overshoot.0),
                    brief(a.overshoot.1),
                    brief(a.rise_s),
                    brief(a.settling_s),
                    brief(a.oscillations),
                ];
                table.add_row([output.name.clone()].into_iter().chain(numbers));
            }
        }
    }
    right_but_first(&mut table);
    let mut text = match table.row_count() {
        0 => String::new(),
        _ => format!("\n{}", finish(&table)),
    };
    if !restless.is_empty() {
        text += &format!(
            "\nnot settled within 2 % by the end, so no answer is read off: {}\n",
            restless.join(", ")
        );
    }
    text
}

/// What the run cost.
pub fn effort(motion: &Motion) -> String {
    let e = &motion.effort;
    let counts = [
        (e.steps, "step"),
        (e.evaluations, "evaluation"),
        (e.jacobians, "Jacobian"),
        (e.factorisations, "factorisation"),
        (e.machines, "linear machine"),
        (e.events, "event"),
    ];
    let things = counts.map(|(n, thing)| (n, counted(n as usize, thing)));
    let done = [(e.rejected, "rejected"), (e.grazed, "grazed")];
    let done = done.map(|(n, what)| (n, format!("{n} {what}")));
    let told: Vec<String> = things
        .into_iter()
        .chain(done)
        .filter(|c| c.0 > 0)
        .map(|c| c.1)
        .collect();
    let told = if told.is_empty() {
        String::new()
    } else {
        format!("{}, ", told.join(", "))
    };
    format!("effort: {told}{} s\n", brief(motion.seconds))
}

/// The energy balance, J.
pub fn balance(balance: &Balance) -> String {
    if let Some(share) = balance.given_up {
        return format!(
            "energy: not told, the powers change so fast that {} readings of them came through {} % of the time\n",
            balance.readings,
            brief(100.0 * share),
        );
    }
    format!(
        "energy: stored {} J, put in {} J, lost {} J, stored at the end {} J; it closes to {}, known to {}\n",
        brief(balance.before),
        brief(balance.put_in),
        brief(balance.lost),
        brief(balance.after),
        brief(balance.gap().abs()),
        brief(balance.doubt().unwrap_or(f64::INFINITY)),
    )
}
