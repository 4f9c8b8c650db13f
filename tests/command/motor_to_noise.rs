//! From the chain of a generator to the noise of the box that runs its work: each link of one run against the command of that link.

use std::path::Path;

use serde_json::Value;

use crate::support::command::{document, refusal};
use crate::support::verification::within;

/// Generator, box and scene of the shipped example on a coarse mesh, in a folder of their own.
fn example(folder: &Path) {
    let read = |path: &str| std::fs::read_to_string(path).unwrap();
    let write = |name: &str, text: String| std::fs::write(folder.join(name), text).unwrap();
    let mesh = "[mesh]\ntorque = \"40 N·m\"\npositions = 12\nstations = 10\n\n[gear]\n";
    let pair = read("models/gears/bevel_12_36.toml").replace("[gear]\n", mesh);
    write("pair.toml", pair);
    write("y2250.toml", read("models/y2250.toml"));
    let generator = read("examples/y2250_pinion.toml")
        .replace("../models/gears/bevel_12_36.toml", "pair.toml")
        .replace("../models/", "");
    write("generator.toml", generator);
    write(
        "box.toml",
        read("models/bevel_box.toml").replace("gears/bevel_12_36.toml", "pair.toml"),
    );
    let scene = read("examples/motor_to_noise.toml")
        .replace("../models/bevel_box.toml", "box.toml")
        .replace("../examples/y2250_pinion.toml", "generator.toml");
    write("run.toml", scene);
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

fn rows<'a>(value: &'a Value, key: &str) -> &'a Vec<Value> {
    value[key].as_array().unwrap()
}

/// The chain of numbers of the example: lines of the generator, flank, pair without and with load, orders of the box, bearing forces.
#[test]
fn law_motor_to_noise() {
    let folder = tempfile::tempdir().unwrap();
    example(folder.path());
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let run = document(&["run", &path("run.toml"), "--json"]);
    let studies = rows(&run, "studies");
    let (te, run_up) = (&studies[0]["result"], &studies[1]["result"]);
    let work = &te["works"][0];

    // The generator alone: the same lines, flank and pair.
    let generator = document(&["te", &path("generator.toml"), "--json"]);
    let own = &generator["works"][0];
    assert_eq!(rows(own, "lines").len(), rows(work, "lines").len());
    for (a, b) in rows(own, "lines").iter().zip(rows(work, "lines")) {
        let apart = number(&a["flank_um"]) / number(&b["flank_um"]) - 1.0;
        assert!(apart.abs() < 1e-9, "{a} {b}");
    }
    let cut = number(&own["te_peak_to_peak_arcsec"]["cut"]);
    within(
        "pair without load, by the box and by the generator",
        (number(&work["te_peak_to_peak_arcsec"]["cut"]) / cut - 1.0).abs(),
        1e-9,
    );
    // Every line of the table of the chain has the amplitude that goes to the flank.
    for line in rows(own, "lines") {
        let same = |row: &&Value| {
            ["order", "source", "cause", "harmonic"]
                .iter()
                .all(|key| row[key] == line[key])
        };
        let row = rows(&generator, "orders").iter().find(same).unwrap();
        let apart = number(&row["amplitude_arcsec"]) / number(&line["roll_arcsec"]) - 1.0;
        assert!(apart.abs() < 1e-9, "{line}");
    }

    // Blades at the feed of the chain: scallops grow with its square from those of `geardyn gear cut` at 0.5°.
    let blades = &own["blades"];
    let step = number(&blades["cradle_deg_per_blade"]);
    let few = "[cut]\nmember = \"pinion\"\nrows = 3\ncolumns = 3\n";
    let pair = std::fs::read_to_string(path("pair.toml")).unwrap();
    std::fs::write(path("few.toml"), pair.replacen("[cut]\n", few, 1)).unwrap();
    let cut = document(&["gear", "cut", &path("few.toml"), "--json"]);
    let concave = rows(&cut["cut"], "flanks")
        .iter()
        .find(|f| f["side"] == "concave")
        .unwrap();
    let highest = number(&concave["scallops_by_law"]["highest_um"]) * (step / 0.5).powi(2);
    within(
        "scallops at the feed of the generator, of `gear cut`",
        (number(&blades["scallop_um"]) / highest - 1.0).abs(),
        1e-9,
    );
    // Run-out within ±1.6 µm; what it turns the gear by is at most its depth over the lever of 59 mm.
    let depth = number(&blades["flank_um"]);
    assert!(depth > 1.0 && depth < 3.2, "{depth}");
    let bound = (1e-6 * depth / 0.058_f64).to_degrees() * 3600.0;
    let te = number(&blades["te_peak_to_peak_arcsec"]);
    assert!(te > 0.2 * bound && te < bound, "{te} {bound}");

    // The pair as designed: `geardyn gear` at the torque.
    let gear = document(&["gear", &path("pair.toml"), "--json"]);
    let te_of: Vec<f64> = gear["mesh"]["te_arcsec"][0]
        .as_array()
        .unwrap()
        .iter()
        .map(number)
        .collect();
    let range = te_of.iter().fold(f64::MIN, |m, x| m.max(*x))
        - te_of.iter().fold(f64::MAX, |m, x| m.min(*x));
    within(
        "pair at 40 N·m as designed, of `gear`",
        (number(&own["loaded_te_peak_to_peak_arcsec"]["ideal"]) / range - 1.0).abs(),
        1e-9,
    );

    // Orders of the gear of the box against its pinion: the loaded error of the cut pair.
    let args = [
        "te",
        &path("run.toml"),
        "--output",
        "gear",
        "--driver",
        "pinion",
        "--json",
    ];
    let orders = document(&args);
    let record = number(&orders["budget"]["percentiles"][0]["range_arcsec"]);
    let loaded = &own["loaded_te_peak_to_peak_arcsec"];
    for key in ["ideal", "cut"] {
        let in_box = number(&work["loaded_te_peak_to_peak_arcsec"][key]);
        within(
            &format!("loaded pair in the box, {key}"),
            (in_box / number(&loaded[key]) - 1.0).abs(),
            1e-6,
        );
    }
    within(
        "range of the box at rest, of the loaded pair as cut",
        (record / number(&own["loaded_te_peak_to_peak_arcsec"]["cut"]) - 1.0).abs(),
        0.1,
    );

    // The run-up of the run is that of the command.
    let alone = document(&[
        "response",
        &path("run.toml"),
        "--run-up=-6000:-300:58",
        "--output",
        "pinion_bearings x.force",
        "--output",
        "gear_bearings x.force",
        "--json",
    ]);
    assert_eq!(alone["critical"], run_up["critical"]);
    assert!(rows(work, "left_out").len() >= 4, "{work}");
}

/// Other change gears than those of the settings: both ratios, the file and the nodes are named.
#[test]
fn refuses_change_gears_of_another_work() {
    let folder = tempfile::tempdir().unwrap();
    example(folder.path());
    let path = folder.path().join("generator.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("[47, 77]", "[48, 77]")).unwrap();
    for name in ["generator.toml", "run.toml"] {
        let (_, message) = refusal(&["te", folder.path().join(name).to_str().unwrap()]);
        assert!(
            message.contains("cradle_over_work is 0.30838513 by the settings of")
                && message.contains("pair.toml")
                && message.contains("from `cradle` to `workpiece`"),
            "{message}"
        );
    }
}

/// A node named as the cutter that is none: the cradle itself, and a node that is not there.
#[test]
fn refuses_other_nodes_as_the_cutter() {
    let folder = tempfile::tempdir().unwrap();
    example(folder.path());
    let path = folder.path().join("generator.toml");
    let text = std::fs::read_to_string(&path).unwrap();
    for (node, expected) in [
        (
            "cradle",
            "the cradle turns by 6.283 rad in a turn of `cradle` (limit 1 rad)",
        ),
        ("head", "no node `head`"),
    ] {
        let named = text.replace("cutter = \"cutter_head\"", &format!("cutter = \"{node}\""));
        std::fs::write(&path, named).unwrap();
        let (_, message) = refusal(&["te", path.to_str().unwrap()]);
        assert_eq!(message, expected);
    }
}
