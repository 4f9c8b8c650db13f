//! Hits whose pulse is short against the distance of samples, without a filter: resonances above half the sample rate appear below it.

use std::f64::consts::{PI, TAU};

use geardyn::internals::numeric::Complex;
use geardyn::prelude::*;

use crate::support::noise::normal;

const RATE: f64 = 3000.0;

/// Frequency, Hz, and damping ratio: the last two fold to 1070 and 300 Hz.
const MODES: [(f64, f64); 5] = [
    (112.0, 0.04),
    (183.0, 0.03),
    (460.0, 0.02),
    (1930.0, 0.006),
    (2700.0, 0.004),
];

/// A mode's `∫ exp(p (t − s)) sin(πs/τ) ds` over a pulse of length τ that began t ago.
fn driven(pole: Complex, t: f64, length: f64) -> Complex {
    let u = t.clamp(0.0, length);
    let part =
        |rate: Complex| ((pole * (t - u) + rate * u).exp() - (pole * t).exp()) / (rate - pole);
    let turn = Complex::new(0.0, PI / length);
    match t > 0.0 {
        true => (part(turn) - part(-turn)) / Complex::new(0.0, 2.0),
        false => Complex::new(0.0, 0.0),
    }
}

/// Force and acceleration of five hits of half a sine, `samples` long, each at its place between two samples: anywhere, or the same.
fn struck(samples: f64, place: Option<f64>, seed: u64) -> (Vec<f64>, Vec<f64>) {
    let mut rng = fastrand::Rng::with_seed(seed * 7919 + 13);
    let (mut force, mut motion) = (Vec::new(), Vec::new());
    let length = samples / RATE;
    for _ in 0..5 {
        let size = 1000.0 * (0.7 + 0.6 * rng.f64());
        let start = 0.05 + place.unwrap_or_else(|| rng.f64()) / RATE;
        for j in 0..750 {
            let t = f64::from(j) / RATE - start;
            let own = match (0.0..length).contains(&t) {
                true => size * (PI * t / length).sin(),
                false => 0.0,
            };
            let mut value = 0.0;
            for (f, d) in MODES {
                let w = TAU * f;
                let pole = Complex::new(-d * w, w * (1.0 - d * d).sqrt());
                let state = driven(pole, t, length) * size;
                value += (state * pole * pole / Complex::new(0.0, pole.im)).re + own;
            }
            force.push(own + 0.1 * normal(&mut rng));
            motion.push(value + 3.0 * normal(&mut rng));
        }
    }
    (force, motion)
}

fn identified(samples: f64, place: Option<f64>, seed: u64) -> geardyn::IdentificationResult {
    let (force, motion) = struck(samples, place, seed);
    let channels: [(&str, &str, &[f64]); 2] = [("f", "N", &force), ("a", "m/s²", &motion)];
    let recording = Recording::from_arrays(RATE, &channels).unwrap();
    let study = IdentifyStudy::default();
    recording.identify(&["f"], &["a"], &study).unwrap()
}

/// Two samples of force drive modes at 1930 and 2700 Hz, and 1070 and 300 Hz were listed to a hundredth of a hertz. From hit to hit their
/// residues turn; those of the modes below stay.
#[test]
fn law_folded_resonances_are_no_modes() {
    let found = identified(2.0, None, 1);
    let all: Vec<f64> = found.modes.iter().map(|m| m.frequency_hz()).collect();
    assert_eq!(all.len(), 3, "{all:?}");
    for (f, (truth, _)) in all.iter().zip(MODES) {
        assert!((f / truth - 1.0).abs() < 0.01, "{all:?}");
    }
    let apart = found.rejected_poles();
    let is_folded = |p: &&(Complex, &str)| p.1.contains("folded");
    let near = |p: &(Complex, &str)| (p.0.norm() / TAU / 1070.0 - 1.0).abs() < 0.01;
    assert!(apart.iter().filter(is_folded).any(near), "{apart:?}");
    assert!(found.diagnostics.iter().any(|d| d.code == "aliasing"));
}

/// A pulse of one sample does not say what it drives, and where all hits lie alike between the samples residues repeat: every mode is weak.
#[test]
fn law_modes_from_hits_of_one_sample_are_weak() {
    let found = identified(0.9, Some(0.4), 1);
    assert!(found.modes.is_empty(), "{:?}", found.modes);
    let of_pulse = found.weak.iter().filter_map(|m| m.weak);
    assert!(of_pulse.filter(|why| why.contains("one sample")).count() >= 3);
    assert!(found.diagnostics.iter().any(|d| d.code == "aliasing"));
}
