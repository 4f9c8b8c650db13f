//! `geardyn gear reverse` as it is called.

use serde_json::Value;

use crate::support::command::{document, geardyn, put, refusal, said};
use crate::support::number;
use crate::support::verification::within;

const UNKNOWN: &str = "data/unknown_gear.toml";

/// Spans, diameters and mate of a spur gear of m 3 mm, 20°, x 0.2 in closed form give it back.
#[test]
fn exact_gear_from_its_readings() {
    let (m, z, x, alpha) = (3.0, 30.0, 0.2, 20f64.to_radians());
    let inv = alpha.tan() - alpha;
    let span = |k: f64| {
        let plain = m * alpha.cos() * (std::f64::consts::PI * (k - 0.5) + z * inv);
        plain + 2.0 * x * m * alpha.sin()
    };
    let text = format!(
        "[measured_gear]\nteeth = 30\nspans = [{{ teeth = 4, size = \"{:.9} mm\" }}, {{ teeth = 6, size = \"{:.9} mm\" }}]\ntip_diameter = \"{} mm\"\nroot_diameter = \"{} mm\"\nuncertainty = {{ span = \"2 µm\", diameter = \"10 µm\" }}\n",
        span(4.0),
        span(6.0),
        m * (z + 2.0 * x + 2.0),
        m * (z + 2.0 * x - 2.5)
    );
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "gear.toml", &text);
    let found = document(&["gear", "reverse", path.to_str().unwrap(), "--json"]);
    let best = &found["reverse"]["candidates"][0];
    assert_eq!(best["size"], "m 3 mm");
    let at = |key: &str| number(&best[key]);
    within(
        "pressure angle, deg",
        (at("pressure_angle_deg") - 20.0).abs(),
        1e-12,
    );
    within("x_E", (at("generating_profile_shift") - x).abs(), 1e-8);
    within(
        "h_aP",
        (number(&best["addendum"]["value"]) - 1.0).abs(),
        1e-8,
    );
    within(
        "h_fP",
        (number(&best["dedendum"]["value"]) - 1.25).abs(),
        1e-8,
    );
    within("misfit", at("misfit"), 1e-6);
    assert_eq!(found["reverse"]["not_separated"], serde_json::json!([]));
    assert_eq!(found["warnings"], serde_json::json!([]));
}

/// An entry of `spans`, its size in mm.
fn one_span(teeth: f64, size: f64) -> String {
    format!("{{ teeth = {teeth}, size = \"{size:.6} mm\" }}")
}

/// Spans leave a metric gear next to one by diametral pitch; the reading that the answer names separates them.
#[test]
fn law_named_reading_separates() {
    let found = document(&["gear", "reverse", UNKNOWN, "--json"]);
    let sizes = |found: &Value| -> Vec<Value> {
        let all = found["reverse"]["candidates"].as_array().unwrap();
        all.iter().map(|c| c["size"].clone()).collect()
    };
    assert_eq!(sizes(&found)[..2], ["P 10 1/in", "m 2.5 mm"]);
    assert_eq!(found["warnings"][0]["code"], "not-separated");
    let open = &found["reverse"]["not_separated"][0];
    assert_eq!(open["candidates"], serde_json::json!([0, 1]));
    // Without the thickness deviation either gear may have any usual tip; spans far apart separate their base pitches.
    let named = &open["separated_by"][0];
    assert_eq!(named["reading"], "spans");
    let (_, text, _) = said(&["gear", "reverse", UNKNOWN]);
    assert!(text.contains("7.94 µm apart"), "{text}");
    // W_k = m cos α (π (k − 1/2) + z inv α) + 2 x m sin α of the gear that the file states.
    let (m, alpha) = (2.54, 20f64.to_radians());
    let span = |k: f64| {
        let involute = 32.0 * (alpha.tan() - alpha);
        let plain = m * alpha.cos() * (std::f64::consts::PI * (k - 0.5) + involute);
        plain + 0.24 * m * alpha.sin()
    };
    let [fewest, most] = [0, 1].map(|i| number(&named["teeth"][i]));
    let std = 0.9 * number(&named["standard_uncertainty_um"]);
    let plain = std::fs::read_to_string(UNKNOWN).unwrap();
    let read = plain
        .replace(
            "{ teeth = 4, size = \"27.590 mm\" }",
            &one_span(fewest, span(fewest)),
        )
        .replace(
            "{ teeth = 5, size = \"35.090 mm\" }",
            &one_span(most, span(most)),
        )
        .replace("span = \"4 µm\"", &format!("span = \"{std} µm\""));
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "read.toml", &read);
    let found = document(&["gear", "reverse", path.to_str().unwrap(), "--json"]);
    let sizes = sizes(&found);
    assert_eq!(sizes[0], "P 10 1/in");
    let other = sizes.iter().position(|size| size == "m 2.5 mm");
    let open = found["reverse"]["not_separated"].as_array().unwrap();
    let is_other = |c: &Value| other.is_some_and(|i| c["candidates"][1] == i);
    assert!(!open.iter().any(is_other), "{open:?}");
    let csv = folder.path().join("candidates.csv");
    let csv = csv.to_str().unwrap();
    let done = geardyn(&["gear", "reverse", UNKNOWN, "--csv", csv, "--quiet"]);
    assert!(done.status.success());
    let table = std::fs::read_to_string(csv).unwrap();
    assert!(
        table.starts_with("size,m_n [mm]") && table.lines().count() == 4,
        "{table}"
    );
    let (code, text, _) = said(&["check", UNKNOWN]);
    assert!(code == Some(0) && text.contains("3 candidates"), "{text}");
}

/// A first candidate that misses a reading by five standard uncertainties is answered with a warning.
#[test]
fn survives_readings_of_no_standard_gear() {
    let plain = std::fs::read_to_string(UNKNOWN).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let text = plain.replace("27.590 mm", "27.560 mm");
    let path = put(folder.path(), "readings.toml", &text);
    let found = document(&["gear", "reverse", path.to_str().unwrap(), "--json"]);
    let largest = number(&found["reverse"]["candidates"][0]["largest_deviation"]);
    assert!(largest > 3.0, "{largest}");
    assert_eq!(found["warnings"][0]["code"], "readings-misfit");
}

/// Readings that determine no gear are refused with what is missing.
#[test]
fn refuses_readings_without_an_answer() {
    let plain = std::fs::read_to_string(UNKNOWN).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let changed = |from: &str, to: &str| {
        assert!(plain.contains(from), "{from}");
        let path = put(folder.path(), "readings.toml", &plain.replace(from, to));
        path.to_str().unwrap().to_string()
    };
    let refused = |from: &str, to: &str| refusal(&["gear", "reverse", &changed(from, to)]);
    let (code, message) = refused("span = \"4 µm\", ", "");
    assert!(
        code == "missing-key" && message.contains("`span`"),
        "{message}"
    );
    let diameters = "teeth = 32\ntip_diameter = \"86.96 mm\"\nroot_diameter = \"75 mm\"\n";
    let (_, _, notes) = said(&["gear", "reverse", &changed("teeth = 32\n", diameters)]);
    assert_eq!(
        notes.matches("of `diameter` is not given").count(),
        1,
        "{notes}"
    );
    let (code, _) = refused("teeth = 32\n", "teeth = 32\nmodule = \"3 mm\"\n");
    assert_eq!(code, "conflict");
    let (code, _) = refused("teeth = 4, size", "teeth = 40, size");
    assert_eq!(code, "out-of-range");
    let (code, message) = refusal(&["measure", UNKNOWN]);
    assert!(
        code == "missing-key" && message.contains("without `module`"),
        "{message}"
    );
    // Readings that are well formed, from which no gear follows.
    let unanswered = |from: &str, to: &str| {
        let (code, _, notes) = said(&["gear", "reverse", &changed(from, to)]);
        assert_eq!(code, Some(3), "{notes}");
        notes
    };
    let notes = unanswered("{ teeth = 5, size = \"35.090 mm\" }", "");
    assert!(notes.contains("over one number of teeth"), "{notes}");
    let notes = unanswered("35.090", "36.010");
    assert!(notes.contains("no standard gear agrees"), "{notes}");
}

/// A reading that is wrong is not missing too; a file without spans is told the key as it is written; other commands name this one.
#[test]
fn refuses_readings_once_and_in_place() {
    let folder = tempfile::tempdir().unwrap();
    let readings = "[measured_gear]\nteeth = 32\nspans = [{ teeth = 4, size = \"27.590 mm\" }, { teeth = 5, size = \"35.090 mm\" }]\n";
    let wrong = put(
        folder.path(),
        "a.toml",
        &format!("{readings}uncertainty = {{ span = \"0 µm\" }}\n"),
    );
    let (code, _, notes) = said(&["gear", "reverse", wrong.to_str().unwrap()]);
    assert_eq!(
        (code, notes.matches("error").count()),
        (Some(2), 1),
        "{notes}"
    );
    let none = put(folder.path(), "b.toml", "[measured_gear]\nteeth = 32\n");
    let (_, _, notes) = said(&["gear", "reverse", none.to_str().unwrap()]);
    assert!(
        notes.contains("spans = [{ teeth") && !notes.contains("[[spans]]"),
        "{notes}"
    );
    let (_, _, notes) = said(&["plan", UNKNOWN]);
    assert!(notes.contains("geardyn gear reverse"), "{notes}");
}
