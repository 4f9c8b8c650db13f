//! Identified shapes on the points of a test: document, drawing, page, and the geometry through UFF.

use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::support::command::{document, put, refusal, said};

/// Natural frequencies, Hz, and damping ratios.
const MODES: [(f64, f64); 3] = [(60.0, 0.02), (140.0, 0.015), (230.0, 0.01)];

/// Points along x, where the first moves along −z and the others along +z, the last one also along y with −0.4 times its z.
const POINTS: usize = 4;

fn shape(mode: usize, point: usize) -> f64 {
    ((mode + 1) as f64 * PI * (point + 1) as f64 / (POINTS + 1) as f64).sin()
}

/// A table of receptances of the channels z1 to z4 and y4 to a force at z1, and its sidecar.
pub fn test_in(folder: &Path) -> String {
    let mut text = String::from("frequency [Hz]");
    let channels: Vec<(String, [f64; 3])> = (0..POINTS)
        .map(|p| {
            (
                format!("z{}", p + 1),
                [0, 1, 2].map(|m| shape(m, p) * if p == 0 { -1.0 } else { 1.0 }),
            )
        })
        .chain([("y4".to_string(), [0, 1, 2].map(|m| -0.4 * shape(m, 3)))])
        .collect();
    for (name, _) in &channels {
        text += &format!(",re {name} [m/N],im {name} [m/N]");
    }
    for line in 0..200 {
        let f = 20.0 + 1.2 * f64::from(line);
        text += &format!("\n{f}");
        for (_, shape) in &channels {
            let mut value = (0.0, 0.0);
            for (m, (f0, damping)) in MODES.into_iter().enumerate() {
                let (re, im) = (
                    (f0 * f0 - f * f) * TAU * TAU,
                    2.0 * damping * f0 * f * TAU * TAU,
                );
                let factor = shape[m] * channels[0].1[m] / (re * re + im * im);
                value = (value.0 + factor * re, value.1 - factor * im);
            }
            text += &format!(",{:e},{:e}", value.0, value.1);
        }
    }
    let mut sidecar = String::new();
    for p in 1..=POINTS {
        let direction = if p == 1 { "-z" } else { "+z" };
        sidecar += &format!(
            "[[point]]\nname = \"{p}\"\nat = [\"{p}00 mm\", \"0 m\", \"0 m\"]\n\n[[channel]]\nname = \"z{p}\"\npoint = \"{p}\"\ndirection = \"{direction}\"\n\n"
        );
    }
    sidecar += "[[point]]\nname = \"foot\"\nat = [\"0 m\", \"0 m\", \"-50 mm\"]\n\n[[channel]]\nname = \"y4\"\npoint = \"4\"\ndirection = \"y\"\n\n[[line]]\nbetween = [\"foot\", \"1\", \"2\", \"3\", \"4\"]\n";
    put(folder, "beam.toml", &sidecar);
    put(folder, "beam.csv", &text).display().to_string()
}

/// Components over the largest: the real parts of a shape that is real.
fn assert_shapes(found: &Value) {
    assert_eq!(found["modes"].as_array().unwrap().len(), MODES.len());
    for (m, mode) in found["modes"].as_array().unwrap().iter().enumerate() {
        let on_points = &mode["shape_on_points"];
        let part = |point: usize, axis: usize, part: &str| {
            on_points[(point + 1).to_string()][axis][part]
                .as_f64()
                .unwrap()
        };
        assert!(on_points["foot"].is_null(), "{on_points}");
        let scale = part(1, 2, "re") / shape(m, 1);
        for p in 0..POINTS {
            let known = [
                0.0,
                if p == 3 { -0.4 * shape(m, p) } else { 0.0 },
                shape(m, p),
            ];
            for (axis, known) in known.into_iter().enumerate() {
                let (re, im) = (part(p, axis, "re"), part(p, axis, "im"));
                assert!(
                    (re / scale - known).abs() < 1e-6 && (im / scale).abs() < 1e-6,
                    "{m} {p} {axis}: {re} {im}"
                );
            }
        }
    }
}

/// Components of known shapes along x, y and z, the drawing and the page, and the same from the UFF file that was written.
#[test]
fn exact_shapes_on_points() {
    let folder = tempfile::tempdir().unwrap();
    let log = test_in(folder.path());
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (svg, html, uff) = (at("a.svg"), at("a.html"), at("a.uff"));
    let found = document(&[
        "identify", &log, "--method", "plscf", "--json", "--svg", &svg, "--html", &html, "--frf",
        &uff,
    ]);
    assert_shapes(&found);
    let geometry = &found["geometry"];
    assert_eq!(geometry["points"][1]["at_m"][0], 0.2);
    assert_eq!(geometry["lines"][0][0], "foot");
    assert_eq!(geometry["channels"][0]["direction"][2], -1.0);
    let drawing = fs::read_to_string(at("a-shapes.svg")).unwrap();
    assert!(drawing.contains("mode 2 · 140.0 Hz"), "{drawing}");
    assert!(
        fs::read_to_string(&html)
            .unwrap()
            .contains("G.kind(\"points\"")
    );
    // The points have numbers in UFF, and the coordinates stay.
    let text = fs::read_to_string(&uff).unwrap();
    assert!(
        text.contains("  2411\n") && text.contains("    82\n"),
        "{}",
        &text[..400]
    );
    let again = document(&["identify", &uff, "--method", "plscf", "--json"]);
    let points = again["geometry"]["points"].as_array().unwrap();
    assert_eq!(points.len(), POINTS + 1);
    assert_eq!(points[3]["at_m"], geometry["points"][3]["at_m"]);
    assert_eq!(again["geometry"]["lines"][0].as_array().unwrap().len(), 5);
    let part = |found: &Value, point: &str| {
        found["modes"][0]["shape_on_points"][point][1]["re"]
            .as_f64()
            .unwrap()
    };
    assert!((part(&again, "4") - part(&found, "4")).abs() < 1e-6);
}

/// Channels without a place are named; without geometry there is none in the document.
#[test]
fn exact_unplaced_channels() {
    let folder = tempfile::tempdir().unwrap();
    let log = test_in(folder.path());
    let sidecar = folder.path().join("beam.toml");
    let text = fs::read_to_string(&sidecar).unwrap();
    fs::write(
        &sidecar,
        text.replace(
            "name = \"z3\"\npoint = \"3\"\ndirection = \"+z\"",
            "name = \"z3\"",
        ),
    )
    .unwrap();
    let found = document(&["identify", &log, "--method", "plscf", "--json"]);
    let warnings = found["warnings"].as_array().unwrap();
    let unplaced = warnings
        .iter()
        .find(|w| w["code"] == "channel-unplaced")
        .unwrap();
    assert!(unplaced["message"].as_str().unwrap().contains("z3"));
    assert!(found["modes"][0]["shape_on_points"]["3"].is_null());
    let plain = document(&[
        "identify",
        &log,
        "--method",
        "plscf",
        "--json",
        "--no-sidecar",
    ]);
    assert!(plain["geometry"].is_null() && plain["modes"][0]["shape_on_points"].is_null());
    fs::write(&sidecar, text.replace("point = \"3\"", "point = \"5\"")).unwrap();
    let (code, message) = refusal(&["identify", &log, "--method", "plscf"]);
    assert_eq!(code, "unknown-point");
    assert!(message.contains("\"5\""));
    let (_, _, shown) = said(&["identify", &log, "--method", "plscf"]);
    assert!(shown.contains("beam.toml:"), "{shown}");
}

/// A test compared with itself has a MAC of one on the diagonal, with a document of other names it is refused, and with a model by the
/// names of its degrees of freedom.
#[test]
fn exact_comparison() {
    let folder = tempfile::tempdir().unwrap();
    let log = test_in(folder.path());
    let first = document(&["identify", &log, "--method", "plscf", "--json"]);
    let own = put(folder.path(), "own.json", &first.to_string())
        .display()
        .to_string();
    let svg = folder.path().join("c.svg").display().to_string();
    let found = document(&[
        "identify",
        &log,
        "--method",
        "plscf",
        "--json",
        "--compare",
        &own,
        "--svg",
        &svg,
    ]);
    let comparison = &found["comparison"];
    assert_eq!(comparison["common"].as_array().unwrap().len(), POINTS + 1);
    let mac = |i: usize, j: usize| comparison["mac"][i][j].as_f64().unwrap();
    // (φ₁·φ₂)² / (φ₁² φ₂²) of the components, y4 among them.
    let dot = |a: usize, b: usize| -> f64 {
        let z: f64 = (0..POINTS).map(|p| shape(a, p) * shape(b, p)).sum();
        z + 0.16 * shape(a, 3) * shape(b, 3)
    };
    let other = dot(0, 1).powi(2) / (dot(0, 0) * dot(1, 1));
    assert!((mac(0, 0) - 1.0).abs() < 1e-12 && (mac(1, 1) - 1.0).abs() < 1e-12);
    assert!((mac(0, 1) - other).abs() < 1e-6, "{} {other}", mac(0, 1));
    assert_eq!(comparison["pairs"].as_array().unwrap().len(), MODES.len());
    assert_eq!(comparison["pairs"][1]["other"], 2);
    assert!(
        fs::read_to_string(folder.path().join("c-mac.svg"))
            .unwrap()
            .contains("1.00")
    );
    let (_, text, _) = said(&["identify", &log, "--method", "plscf", "--compare", &own]);
    assert!(text.contains("MAC above 0.8"), "{text}");
    // A model: real shapes, a rigid mode without a frequency. At two points the modes 1 and 3 are alike.
    let model = r#"{"modes": [{"mode": 1, "frequency_hz": 0.0, "shape": {"z2": 1.0, "z3": 1.0}}, {"mode": 2, "frequency_hz": 61.0, "shape": {"z2": 0.9510565162951536, "z3": 0.9510565162951536, "q": 3.0}}]}"#;
    let model = put(folder.path(), "model.json", model)
        .display()
        .to_string();
    let found = document(&[
        "identify",
        &log,
        "--method",
        "plscf",
        "--json",
        "--compare",
        &model,
    ]);
    let pair = &found["comparison"]["pairs"];
    assert_eq!(
        (
            pair.as_array().unwrap().len(),
            &pair[0]["mode"],
            &pair[0]["other"]
        ),
        (2, &Value::from(1), &Value::from(2))
    );
    let apart = pair[0]["frequency_difference"].as_f64().unwrap();
    assert!((apart - (60.0 / 61.0 - 1.0)).abs() < 1e-6);
    let strange = put(
        folder.path(),
        "strange.json",
        &first.to_string().replace("\"z", "\"w"),
    )
    .display()
    .to_string();
    let (code, message) = refusal(&["identify", &log, "--method", "plscf", "--compare", &strange]);
    assert_eq!(code, "conflict");
    assert!(message.contains("in common"), "{message}");
    let (code, _) = refusal(&["identify", &log, "--method", "plscf", "--compare", &log]);
    assert_eq!(code, "unknown-format");
}

/// `--log` changes the axis of the figure, and is refused where that holds zero or nothing is drawn.
#[test]
fn exact_log_axis() {
    let folder = tempfile::tempdir().unwrap();
    let log = test_in(folder.path());
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (plain, log_x) = (at("plain.svg"), at("log.svg"));
    said(&["identify", &log, "--method", "plscf", "--svg", &plain]);
    let (code, _, message) = said(&[
        "identify", &log, "--method", "plscf", "--svg", &log_x, "--log", "x",
    ]);
    assert_eq!(code, Some(0), "{message}");
    let axis = |path: &str| {
        let text = fs::read_to_string(path).unwrap();
        [">\n20\n<", ">\n150\n<"].map(|number| text.contains(number))
    };
    assert_eq!((axis(&plain), axis(&log_x)), ([false, true], [true, false]));
    let (code, message) = refusal(&[
        "simulate",
        "examples/linear_chain.toml",
        "--svg",
        &at("s.svg"),
        "--log",
        "x",
    ]);
    assert_eq!(code, "conflict");
    assert!(
        message.contains("time, s") && message.contains("has the value 0"),
        "{message}"
    );
    assert!(!folder.path().join("s.svg").exists());
    let (code, _) = refusal(&["identify", &log, "--method", "plscf", "--log", "x"]);
    assert_eq!(code, "usage");
}
