//! `identify` with several inputs: two forces at once on a machine of two modes whose responses are known exactly.

use std::f64::consts::TAU;
use std::path::Path;
use std::process::Command;

use geardyn::internals::numeric::Complex;
use serde_json::Value;

use crate::support::noise::normal;

const RATE: f64 = 1000.0;

/// Samples of a record.
const SAMPLES: usize = 24_000;

/// Standard deviation of the noise on each output, m.
const NOISE: f64 = 2e-6;

/// Frequency, Hz, damping ratio, shape over X1 and X2, participation of f1 and f2.
const MODES: [(f64, f64, [f64; 2], [f64; 2]); 2] = [
    (60.0, 0.02, [1.0, 0.6], [1.0, 0.5]),
    (140.0, 0.015, [0.7, -1.0], [-0.4, 1.0]),
];

fn geardyn(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_geardyn"))
        .args(arguments)
        .current_dir(folder)
        .env("NO_COLOR", "1")
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (
        output.status.code(),
        text(output.stdout),
        text(output.stderr),
    )
}

fn document(folder: &Path, arguments: &[&str]) -> Value {
    let (code, text, errors) = geardyn(folder, arguments);
    assert_eq!(code, Some(0), "{arguments:?}\n{text}{errors}");
    serde_json::from_str(&text).unwrap()
}

/// Pole, `z = exp(p/f)`, gain `(z − 1)/p` of a force held between samples, residue `1/(2i Im p)`.
fn mode(m: usize) -> [Complex; 4] {
    let (f, d, ..) = MODES[m];
    let omega = TAU * f;
    let p = Complex::new(-d * omega, omega * (1.0 - d * d).sqrt());
    let z = (p / RATE).exp();
    [p, z, (z - 1.0) / p, Complex::new(0.0, 2.0 * p.im).inv()]
}

/// The response of sampled output to sampled force at a frequency, Hz.
fn truth(output: usize, input: usize, frequency_hz: f64) -> Complex {
    let at = Complex::new(0.0, TAU * frequency_hz / RATE).exp();
    (0..MODES.len())
        .map(|m| {
            let [_, z, gain, residue] = mode(m);
            let pair = residue * gain / (at - z) + (residue * gain).conj() / (at - z.conj());
            pair * MODES[m].2[output] * MODES[m].3[input]
        })
        .sum()
}

/// Two forces, independent and white, and what they move; `together` is what the second has of the first.
fn log(folder: &Path, together: f64) {
    let mut rng = fastrand::Rng::with_seed(11);
    let mut states = [Complex::ZERO; MODES.len()];
    let mut text = String::from("time [s],f1 [N],f2 [N],X1 [m],X2 [m]\n");
    for t in 0..SAMPLES {
        let first = normal(&mut rng);
        let forces = [
            first,
            together * first + (1.0 - together) * normal(&mut rng),
        ];
        let mut moved = [NOISE * normal(&mut rng), NOISE * normal(&mut rng)];
        for (m, state) in states.iter_mut().enumerate() {
            let [_, z, gain, residue] = mode(m);
            let (.., shape, drives) = MODES[m];
            for (x, part) in moved.iter_mut().zip(shape) {
                *x += 2.0 * part * (residue * *state).re;
            }
            let force: f64 = forces.iter().zip(drives).map(|(u, part)| u * part).sum();
            *state = z * *state + gain * force;
        }
        text += &format!(
            "{:.3},{:.9e},{:.9e},{:.9e},{:.9e}\n",
            t as f64 / RATE,
            forces[0],
            forces[1],
            moved[0],
            moved[1]
        );
    }
    std::fs::write(folder.join("run.csv"), text).unwrap();
}

const DRIVEN: [&str; 9] = [
    "identify", "run.csv", "--input", "f1,f2", "--output", "X1,X2", "--band", "20:300", "--json",
];

fn numbers(value: &Value) -> Vec<f64> {
    let all = value.as_array().unwrap().iter();
    all.map(|x| x.as_f64().unwrap_or(f64::NAN)).collect()
}

fn complex(value: &Value) -> Complex {
    Complex::new(value["re"].as_f64().unwrap(), value["im"].as_f64().unwrap())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Responses lie as far from the truth as their variance says; multiple and partial coherence are those of the noise that was added:
/// by local polynomials, and by averaged blocks.
#[test]
fn law_responses_and_coherence_of_two_forces() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    log(folder, 0.0);
    // One pole pair is asked for: nothing but the responses is looked at.
    let quick = ["--frf", "frf.json", "--order", "1"];
    let found = document(folder, &[&DRIVEN[..], &quick].concat());
    let how = found["method_text"].as_str().unwrap();
    assert!(how.contains("local parabolas"), "{how}");
    check_responses(folder, 1.0);
    let averaged = ["--resolution", "0.5"];
    document(folder, &[&DRIVEN[..], &quick, &averaged].concat());
    check_responses(folder, 0.7);
}

/// `farthest` is how far a single coherence may lie from its expectation.
fn check_responses(folder: &Path, farthest: f64) {
    let text = std::fs::read_to_string(folder.join("frf.json")).unwrap();
    let found: Value = serde_json::from_str(&text).unwrap();
    let lines = numbers(&found["frequency_hz"]);
    let inside: Vec<usize> = (0..lines.len())
        .filter(|&k| (20.0..300.0).contains(&lines[k]))
        .collect();
    let functions = found["functions"].as_array().unwrap();
    assert_eq!(functions.len(), 4);
    for (at, function) in functions.iter().enumerate() {
        let (output, input) = (at / 2, at % 2);
        assert_eq!(function["output"]["name"], ["X1", "X2"][output]);
        assert_eq!(function["input"]["name"], ["f1", "f2"][input]);
        let variance = numbers(&function["variance"]);
        let value = function["value"].as_array().unwrap();
        let off: Vec<f64> = inside
            .iter()
            .map(|&k| {
                let error = complex(&value[k]) - truth(output, input, lines[k]);
                error.norm_sqr() / variance[k]
            })
            .collect();
        // An F distribution of 2 and 2n freedoms: its mean is n/(n − 1), and (1 + x/n)^−n is beyond x.
        let n = found["averages"].as_f64().unwrap() - 2.0;
        assert!(
            (mean(&off) - n / (n - 1.0)).abs() < 0.25,
            "{at}: {}",
            mean(&off)
        );
        let beyond = |x: &f64| (1.0 + x / n).powf(-n) * off.len() as f64;
        assert!(off.iter().all(|x| beyond(x) > 1e-5), "{at}: {off:?}");
        let (multiple, partial) = (
            numbers(&function["coherence"]),
            numbers(&function["partial_coherence"]),
        );
        let bias = 2.0 / found["averages"].as_f64().unwrap();
        let mut apart = (Vec::new(), Vec::new());
        for &k in &inside {
            let power = |i: usize| truth(output, i, lines[k]).norm_sqr();
            let noise = NOISE * NOISE;
            let explained = power(0) + power(1);
            apart.0.push(multiple[k] - explained / (explained + noise));
            apart
                .1
                .push(partial[k] - power(input) / (power(input) + noise));
        }
        for apart in [apart.0, apart.1] {
            assert!(mean(&apart).abs() < bias, "{at}: {}", mean(&apart));
            assert!(apart.iter().all(|x| x.abs() < farthest), "{at}");
        }
    }
}

/// Both modes with shape and participation, by the method of several references and by the one with intervals.
#[test]
fn exact_modes_of_two_forces() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    log(folder, 0.0);
    for method in ["plscf", "rational"] {
        let found = document(
            folder,
            &[
                &DRIVEN[..],
                &[
                    "--method",
                    method,
                    "--export",
                    "model.json",
                    "--svg",
                    "a.svg",
                ],
            ]
            .concat(),
        );
        let modes = found["modes"].as_array().unwrap();
        assert_eq!(modes.len(), MODES.len(), "{method}: {modes:#?}");
        for (mode, (f, d, shape, drives)) in modes.iter().zip(MODES) {
            let near = |key: &str, expected: f64, share: f64| {
                let apart = mode[key].as_f64().unwrap() / expected - 1.0;
                assert!(apart.abs() < share, "{method}: {key} {mode:#}");
            };
            near("frequency_hz", f, 1e-3);
            near("damping_ratio", d, 0.05);
            if method == "rational" {
                let off = (mode["frequency_hz"].as_f64().unwrap() - f).abs();
                assert!(
                    off < 5.0 * mode["frequency_std_hz"].as_f64().unwrap() + 1e-4 * f,
                    "{mode:#}"
                );
            }
            let largest = |v: [f64; 2]| if v[0].abs() >= v[1].abs() { v[0] } else { v[1] };
            for (key, names, parts) in [
                ("shape", ["X1", "X2"], shape),
                ("participation", ["f1", "f2"], drives),
            ] {
                for (name, part) in names.iter().zip(parts) {
                    let apart = complex(&mode[key][name]) - part / largest(parts);
                    assert!(apart.norm() < 0.03, "{method}: {key} of {name}: {mode:#}");
                }
            }
        }
        assert_eq!(found["transfer_functions"].as_array().unwrap().len(), 4);
        let text = std::fs::read_to_string(folder.join("model.json")).unwrap();
        let model: Value = serde_json::from_str(&text).unwrap();
        let space = &model["state_space"];
        assert_eq!(space["inputs"], serde_json::json!(["f1", "f2"]), "{method}");
        assert_eq!(
            space["outputs"],
            serde_json::json!(["X1", "X2"]),
            "{method}"
        );
    }
}

/// Inputs that are one signal cannot be told apart, and that is said.
#[test]
fn refuses_coherent_inputs() {
    let folder = tempfile::tempdir().unwrap();
    log(folder.path(), 0.99999);
    let (code, text, _) = geardyn(folder.path(), &DRIVEN);
    assert_eq!(code, Some(3), "{text}");
    assert!(text.contains("cannot be separated"), "{text}");
}

/// Where the second force is the first one but for low frequencies, the responses above are left out, by every method, and it is said.
#[test]
fn survives_inputs_coherent_on_some_lines() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = fastrand::Rng::with_seed(3);
    let (mut slow, mut slower) = (0.0, 0.0);
    let mut state = Complex::ZERO;
    let mut text = String::from("time [s],f1 [N],f2 [N],X1 [m],X2 [m]\n");
    let [_, z, gain, residue] = mode(0);
    for t in 0..40_000 {
        let first = normal(&mut rng);
        slow += 0.2 * (normal(&mut rng) - slow);
        slower += 0.2 * (slow - slower);
        let second = first + slower;
        let x = 2.0 * (residue * state).re;
        state = z * state + gain * (first + 0.5 * second);
        let noise = [0; 2].map(|_| NOISE * normal(&mut rng));
        text += &format!(
            "{:.3},{first:.9e},{second:.9e},{:.9e},{:.9e}\n",
            t as f64 / RATE,
            x + noise[0],
            0.6 * x + noise[1]
        );
    }
    std::fs::write(folder.path().join("run.csv"), text).unwrap();
    for method in ["rational", "plscf"] {
        let arguments = [
            "identify", "run.csv", "--input", "f1,f2", "--output", "X1,X2", "--json", "--method",
            method,
        ];
        let found = document(folder.path(), &arguments);
        let warned = found["warnings"].to_string();
        assert!(warned.contains("coherent-inputs"), "{method}: {warned}");
        let modes = found["modes"].as_array().unwrap();
        let off = |m: &Value| (m["frequency_hz"].as_f64().unwrap() / MODES[0].0 - 1.0).abs();
        assert!(modes.iter().any(|m| off(m) < 0.01), "{method}: {modes:#?}");
    }
}
