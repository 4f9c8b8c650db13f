//! The same bytes for any number of threads.

use serde_json::Value;

use crate::support::command::{document, said};

/// A document without times and what follows from them.
fn without_times(mut document: Value) -> String {
    if let Some(keys) = document.as_object_mut() {
        keys.remove("effort");
    }
    format!("{document:#}")
}

/// Commands whose work is shared among threads, one of each kind.
const COMMANDS: &[&[&str]] = &[
    &[
        "modes",
        "models/overhung_rotor.toml",
        "--damped",
        "--campbell",
        "0:12000:61",
    ],
    &["response", "models/y2250.toml", "--run-up", "50:3000:12"],
    &["spectrum", "data/spindle_impact.csv", "--channel", "ax,ay"],
    &[
        "spectrum",
        "data/spindle_impact.csv",
        "--channel",
        "ax,ay",
        "--kind",
        "multitaper",
        "--separate",
    ],
    &[
        "spectrum",
        "data/spindle_impact.csv",
        "--channel",
        "ax,ay",
        "--kind",
        "envelope",
    ],
    &[
        "spectrum",
        "data/spindle_impact.csv",
        "--channel",
        "ax,ay",
        "--kind",
        "spectrogram",
    ],
    &["check", "data/spindle_impact.csv"],
    &[
        "te",
        "data/y2250_te.csv",
        "--input",
        "index_gear_1",
        "--output",
        "work_spindle",
        "--teeth",
        "30:37,54:36,1:90",
        "--lines",
        "10000,36000",
    ],
];

/// Every command prints the same bytes on one thread and on two.
#[test]
fn law_results_do_not_depend_on_the_number_of_threads() {
    for command in COMMANDS {
        let by = |threads: &str| {
            without_times(document(
                &[*command, &["--json", "--threads", threads]].concat(),
            ))
        };
        let one = by("1");
        assert!(one.len() > 100);
        assert_eq!(one, by("2"), "{command:?}");
    }
}

/// Charts and extremes too, verdicts and energy errors by counted work.
#[test]
fn law_stability_does_not_depend_on_the_number_of_threads() {
    let command = "stability examples/smooth_mesh.toml --until 0.0002 --speeds 3000:9000:20 --over depth=0.5:1:2 --methods radau5,dop853-events --json --threads";
    let by = |threads: &'static str| {
        let arguments: Vec<&str> = command.split(' ').chain([threads]).collect();
        let (exit, text, _) = said(&arguments);
        let document: Value = serde_json::from_str(&text).unwrap();
        (exit, without_times(document))
    };
    let one = by("1");
    assert!(one.1.contains("tongues") && one.1.contains("verdict"));
    assert_eq!(one, by("2"));
}

/// No threads at all are refused.
#[test]
fn refuses_no_threads() {
    let (exit, _, notes) = said(&["modes", "models/two_disc.toml", "--threads", "0"]);
    assert_eq!(exit, Some(2));
    assert!(notes.contains("--threads"), "{notes}");
}
