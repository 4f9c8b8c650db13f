//! Lines of running speed and of the mains in records without an input, on a structure of four modes driven by noise.

use std::f64::consts::TAU;

use serde_json::Value;

use crate::support::command::{document, put};
use crate::support::noise::normal;

const RATE: f64 = 512.0;

const SAMPLES: usize = 92_160;

/// Natural frequencies, Hz, and damping ratios.
const MODES: [(f64, f64); 4] = [(22.0, 0.008), (35.0, 0.009), (61.0, 0.01), (110.0, 0.012)];

/// The identified document of four channels: noise through the modes, noise of the sensors, and a line common to them.
fn identified(line: impl Fn(f64) -> f64) -> Value {
    let mut rng = fastrand::Rng::with_seed(23);
    let mut states = [(0.0, 0.0); MODES.len()];
    let mut text = String::from("time [s],a [m/s²],b [m/s²],c [m/s²],d [m/s²]\n");
    for n in 0..SAMPLES {
        let t = n as f64 / RATE;
        for (state, (f, damping)) in states.iter_mut().zip(MODES) {
            let size = (-damping * TAU * f / RATE).exp();
            let (sin, cos) = (TAU * f * (1.0 - damping * damping).sqrt() / RATE).sin_cos();
            *state = (
                size * (cos * state.0 - sin * state.1) + 0.02 * normal(&mut rng),
                size * (sin * state.0 + cos * state.1),
            );
        }
        let common = line(t);
        let channel = |c: usize| -> f64 {
            let part = |(m, state): (usize, &(f64, f64))| {
                ((m + 1) as f64 * (c + 1) as f64 * 0.63).sin() * state.1
            };
            states.iter().enumerate().map(part).sum::<f64>() + [0.5, 0.8, -0.7, 1.0][c] * common
        };
        let cells: Vec<String> = (0..4)
            .map(|c| format!("{:.6}", channel(c) + 0.02 * normal(&mut rng)))
            .collect();
        text += &format!("{t:.9},{}\n", cells.join(","));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "machine.csv", &text);
    document(&[
        "identify",
        &path.display().to_string(),
        "--output",
        "a,b,c,d",
        "--json",
    ])
}

fn frequencies(found: &Value) -> Vec<f64> {
    let modes = found["modes"].as_array().unwrap();
    modes
        .iter()
        .map(|m| m["frequency_hz"].as_f64().unwrap())
        .collect()
}

/// Mains that wander by 0.02 Hz about 50 Hz: no mode, and labelled.
#[test]
fn law_wandering_mains_are_no_mode() {
    let found = identified(|t| {
        // The integral of 50 + 0.02 sin(2πt/37).
        let phase = 50.0 * t - 0.02 * 37.0 / TAU * (TAU * t / 37.0).cos();
        0.5 * (TAU * phase).sin()
    });
    let modes = frequencies(&found);
    assert_eq!(modes.len(), MODES.len(), "{modes:?}");
    let warnings = found["warnings"].as_array().unwrap();
    assert!(
        warnings.iter().any(|w| w["code"] == "mains"),
        "{warnings:?}"
    );
    let lines = found["harmonics"].as_array().unwrap();
    assert!(
        !lines.is_empty() && lines.iter().all(|l| l["reason"] == "mains"),
        "{lines:?}"
    );
}

/// A sum of slow sines within ±1, and its integral over time, for what wanders.
fn wandering(t: f64) -> f64 {
    [(37.0, 0.5), (11.0, 0.3), (4.3, 0.2)]
        .map(|(period, size)| -size * period / TAU * (TAU * t / period).cos())
        .iter()
        .sum()
}

/// Mains with their third and fifth multiples that wander by 0.04 Hz at 50 Hz: the modes and no other.
#[test]
fn law_wandering_multiples_of_the_mains_are_no_modes() {
    let found = identified(|t| {
        let phase = 50.0 * t + 0.04 * wandering(t);
        let one = |k: f64| 0.5 / k * (TAU * k * phase).sin();
        [1.0, 3.0, 5.0].map(one).iter().sum()
    });
    check_modes(&found);
    let warnings = found["warnings"].as_array().unwrap();
    assert!(
        warnings.iter().any(|w| w["code"] == "mains"),
        "{warnings:?}"
    );
}

/// A machine whose speed wanders by 0.4 %, eight harmonics of 13.7 Hz, each many lines wide: the modes and no other. Such a record took
/// minutes, each harmonic taken for many sines near each other.
#[test]
fn law_harmonics_of_a_wandering_speed_are_no_modes() {
    let found = identified(|t| {
        let phase = 13.7 * (t + 0.004 * wandering(t));
        let one = |k: i32| 0.4 / f64::from(k).sqrt() * (TAU * f64::from(k) * phase).sin();
        (1..=8).map(one).sum()
    });
    check_modes(&found);
}

/// Every mode once, within 0.5 %, and no other.
fn check_modes(found: &Value) {
    let modes = frequencies(found);
    assert_eq!(modes.len(), MODES.len(), "{modes:?}");
    for (f, (known, _)) in modes.iter().zip(MODES) {
        assert!((f / known - 1.0).abs() < 0.005, "{modes:?}");
    }
}

/// Five harmonics of 17.5 Hz, the second of them on the mode at 35 Hz: the sine is taken out, and the mode stays.
#[test]
fn law_a_mode_on_a_harmonic_stays() {
    let found = identified(|t| {
        let one = |(k, a): (usize, f64)| a * (TAU * 17.5 * k as f64 * t + k as f64).sin();
        [(1, 0.6), (2, 0.4), (3, 0.3), (4, 0.2), (5, 0.3)]
            .map(one)
            .iter()
            .sum()
    });
    let modes = frequencies(&found);
    assert!(modes.iter().any(|f| (f - 35.0).abs() < 0.2), "{modes:?}");
    let lines = found["harmonics"].as_array().unwrap();
    assert!(
        lines.iter().all(|l| l["envelope_kurtosis"].is_null()),
        "{lines:?}"
    );
}
