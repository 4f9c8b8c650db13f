//! The shipped recordings hold what their sidecars say.

use std::path::{Path, PathBuf};

use geardyn::internals::base::flags::Flags;
use geardyn::internals::base::load;
use geardyn::internals::base::toml::{self, Value};
use geardyn::internals::plan::logs::frf_estimation::FrfStudy;
use geardyn::internals::plan::logs::identification::{IdentificationInput, identify};
use geardyn::internals::plan::logs::identification_result::IdentificationResult;
use geardyn::internals::plan::logs::identify_study::IdentifyStudy;
use geardyn::internals::recording::sidecar;
use geardyn::internals::recording::signals::Recording;
use geardyn::internals::recording::{open, preprocess};
use geardyn::internals::spectrum::impact::RejectReason;

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("data")
        .join(name)
}

/// A log with its sidecar.
fn read(name: &str) -> Recording {
    let path = shipped(name);
    let settings = sidecar::read_for_log(&path, &Flags::default()).unwrap().0;
    let log = open::open(path.to_str().unwrap(), &settings).unwrap();
    preprocess::preprocess(log, &settings).unwrap()
}

/// Numbers of `[truth]`.
fn truth(name: &str, key: &str) -> Vec<f64> {
    let document = toml::parse(&load::load(&sidecar::sidecar_path(&shipped(name))).unwrap());
    let Value::Table(table) = &document.root.get("truth").unwrap().item.value else {
        unreachable!("[truth] is a table");
    };
    let number = |value: &Value| match value {
        Value::Float(x) => *x,
        Value::Integer(n) => *n as f64,
        other => unreachable!("{other:?} is no number"),
    };
    match &table.get(key).unwrap().item.value {
        Value::List(list) => list.iter().map(|item| number(&item.value)).collect(),
        value => vec![number(value)],
    }
}

fn identified(resolution_hz: Option<f64>) -> IdentificationResult {
    let recording = read("spindle_impact.csv");
    let names = |all: &[&str]| all.iter().map(|n| n.to_string()).collect();
    let study = IdentifyStudy {
        inputs: names(&["force"]),
        outputs: names(&["ax", "ay"]),
        estimate: FrfStudy {
            frequency_resolution_hz: resolution_hz,
            ..FrfStudy::default()
        },
        ..IdentifyStudy::default()
    };
    identify(IdentificationInput::Signals(&recording), &study).unwrap()
}

/// Five hits, of which the second bounces and the fourth overloads; all six modes inside three standard deviations.
#[test]
fn exact_impact_test_of_a_spindle() {
    // Blocks as long as the distance of the hits allows: what is cut off the decays is then far below the noise.
    let found = identified(Some(1.6));
    let faults: Vec<Option<RejectReason>> = found.hits.iter().map(|h| h.fault).collect();
    assert_eq!(
        faults,
        [
            None,
            Some(RejectReason::Double),
            None,
            Some(RejectReason::Clipped(0)),
            None
        ]
    );
    let frequencies = truth("spindle_impact.csv", "frequency_hz");
    let ratios = truth("spindle_impact.csv", "damping_ratio");
    assert_eq!(found.modes.len(), frequencies.len());
    for ((found, frequency), ratio) in found.modes.iter().zip(frequencies).zip(ratios) {
        let mode = &found.mode;
        let (f, z) = (mode.frequency_hz(), mode.damping_ratio());
        let (f_std, z_std) = (
            mode.frequency_std_hz().unwrap(),
            mode.damping_std().unwrap(),
        );
        println!("{f:.4} ± {f_std:.4} Hz for {frequency}, {z:.5} ± {z_std:.5} for {ratio}");
        assert!(
            (f - frequency).abs() < 3.0 * f_std,
            "{f} Hz for {frequency}"
        );
        assert!((z - ratio).abs() < 3.0 * z_std, "{z} for {ratio}");
        // The intervals are not right by being wide.
        assert!(f_std < 2e-3 * frequency && z_std < 0.1 * ratio);
    }
}

/// What the other two hold: channels with units, the rate stated or by the stamps, nothing to repair.
#[test]
fn law_recordings_read_without_repair() {
    for (name, rate_hz, samples, channels) in [
        (
            "spindle_impact.csv",
            5000.0,
            17_750,
            &["force", "ax", "ay"][..],
        ),
        ("spindle_cutting.csv", 1280.0, 30_720, &["ax", "ay"]),
        ("run_up.csv", 2000.0, 16_000, &["tacho", "ax", "ay"]),
    ] {
        let recording = read(name);
        let names: Vec<&str> = recording.channels.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, channels, "{name}");
        assert!((recording.rate_hz / rate_hz - 1.0).abs() < 1e-9, "{name}");
        assert_eq!(recording.samples, samples, "{name}");
        assert_eq!(recording.segments, vec![0..samples], "{name}");
        assert!(
            recording.repairs.iter().all(|r| r.kind == "sidecar"),
            "{name}: {:?}",
            recording.repairs
        );
        assert!(
            recording.diagnostics.is_empty(),
            "{name}: {:?}",
            recording.diagnostics
        );
        assert_eq!(recording.channel("ax").unwrap().unit, "m/s²", "{name}");
        assert_eq!(truth(name, "frequency_hz").len(), 6, "{name}");
    }
}
