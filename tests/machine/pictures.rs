//! Pictures: whole, finite, the same every time, and with the lines and labels they should have.
//!
//! `GEARDYN_PICTURES=DIR cargo test --test machine pictures` also writes them to DIR.

use std::path::Path;

use geardyn::internals::plan::modes_run::{ModesResult, run};
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::stages::ModesPlan;
use geardyn::internals::report::campbell_plot::{
    CampbellPlot, PlottedBranch, PlottedCrossing, PlottedOrder, PlottedWhirl, campbell_figure,
};
use geardyn::internals::report::energy_matrix_plot::draw_energy_matrix;
use geardyn::internals::report::figure::Figure;
use geardyn::internals::report::mode_shape_plot::draw_mode_shapes;
use geardyn::internals::scene::study::ModesStudy;
use geardyn::internals::scene::{read, read_text};

fn answer(model: &str, study: &ModesStudy) -> (PreparedMachine, ModesResult) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("models")
        .join(format!("{model}.toml"));
    prepared(&read(&path).unwrap().model, study)
}

fn prepared(
    model: &geardyn::internals::scene::model::Model,
    study: &ModesStudy,
) -> (PreparedMachine, ModesResult) {
    let machine = PreparedMachine::new(model).unwrap_or_else(|e| panic!("{}", e.message));
    let plan = ModesPlan::plan_modes(&machine, study);
    let result = run(&machine, study, &plan).unwrap_or_else(|e| panic!("{}", e.message));
    (machine, result)
}

/// A Campbell diagram as SVG.
fn draw_campbell(diagram: &CampbellPlot) -> String {
    Figure::first(campbell_figure(diagram)).svg()
}

fn keep(name: &str, svg: &str) {
    if let Some(folder) = std::env::var_os("GEARDYN_PICTURES") {
        std::fs::write(Path::new(&folder).join(format!("{name}.svg")), svg).unwrap();
    }
}

fn count(svg: &str, what: &str) -> usize {
    svg.matches(what).count()
}

/// The texts of a picture, in the order drawn.
fn texts(svg: &str) -> Vec<&str> {
    let ends = svg.split("</text>");
    ends.filter_map(|part| {
        part.rsplit_once("<text ")
            .and_then(|(_, t)| t.split_once('>'))
    })
    .map(|(_, text)| text.trim())
    .collect()
}

/// One root, every tag closed, every number a number and on the picture.
fn assert_whole(svg: &str) {
    assert!(
        svg.starts_with("<svg width=\"900\""),
        "{}",
        &svg[..svg.len().min(80)]
    );
    assert_eq!(count(svg, "<svg"), 1);
    assert!(svg.trim_end().ends_with("</svg>"));
    assert_eq!(count(svg, "<text "), count(svg, "</text>"));
    assert!(
        !svg.contains("NaN") && !svg.contains("inf\""),
        "a number is none"
    );
    let mut rest = svg;
    while let Some(start) = rest.find('<') {
        let end = start + rest[start..].find('>').expect("every tag ends");
        assert_eq!(count(&rest[start + 1..end], "<"), 0);
        rest = &rest[end..];
    }
    let height: f64 = attribute(svg, "height").next().unwrap();
    for (name, most) in [("x", 900.0), ("x1", 900.0), ("x2", 900.0), ("cx", 900.0)] {
        let inside = attribute(svg, name).all(|x| (0.0..=8.0 * most).contains(&x));
        assert!(inside, "{name} off the picture");
    }
    for name in ["y", "y1", "y2", "cy"] {
        let inside = attribute(svg, name).all(|y| (0.0..=8.0 * height).contains(&y));
        assert!(inside, "{name} off the picture");
    }
}

fn attribute<'a>(svg: &'a str, name: &str) -> impl Iterator<Item = f64> + 'a {
    let key = format!(" {name}=\"");
    let starts: Vec<usize> = svg.match_indices(&key).map(|(i, k)| i + k.len()).collect();
    starts
        .into_iter()
        .map(|i| svg[i..].split('"').next().unwrap().parse().unwrap())
}

const MODELS: [&str; 17] = [
    "drill_string",
    "extreme_chain",
    "five_disc_chain",
    "four_square",
    "geared_damped",
    "geared_motor_rolls",
    "helical_lateral",
    "holzer_three_disc",
    "ieee_first_benchmark",
    "lin_parker_n3",
    "lin_parker_n4",
    "lin_parker_n5",
    "nrel_5mw",
    "overhung_rotor",
    "two_disc",
    "uniform_chain",
    "y2250",
];

/// Every shipped model, real and complex, gives whole pictures.
#[test]
fn law_every_model_can_be_drawn() {
    for model in MODELS {
        for damped in [false, true] {
            let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("models/{model}.toml"));
            if std::fs::read_to_string(path).unwrap().trim().is_empty() {
                continue; // a model yet to be written
            }
            let study = ModesStudy {
                damped,
                lowest: Some(20),
                ..ModesStudy::default()
            };
            if damped && model == "uniform_chain" {
                continue; // a thousand discs
            }
            let (machine, result) = answer(model, &study);
            if damped && !result.complex {
                continue;
            }
            let suffix = if damped { "_damped" } else { "" };
            let shapes = draw_mode_shapes("", &machine, &result, 8);
            assert_whole(&shapes);
            keep(&format!("{model}{suffix}_shapes"), &shapes);
            let energies = draw_energy_matrix("", &machine, &result, 20);
            assert_whole(&energies);
            keep(&format!("{model}{suffix}_energies"), &energies);
        }
    }
}

const TWO_DISCS: &str = r#"
title = "Two discs & a <shaft>"
source = "invented"
[[inertia]]
name = "motor"
J = "2 kg·m²"
[[inertia]]
name = "roll"
J = "3 kg·m²"
[[shaft]]
name = "shaft"
between = ["motor", "roll"]
k = "1200 N·m/rad"
"#;

fn two_discs() -> (PreparedMachine, ModesResult) {
    let scene = read_text("two.toml", TWO_DISCS).unwrap();
    prepared(&scene.model, &ModesStudy::default())
}

/// Two modes, one shaft: two panels with their titles, and a line in each.
#[test]
fn exact_panels_of_two_discs() {
    let (machine, result) = two_discs();
    let svg = draw_mode_shapes("", &machine, &result, 8);
    assert_whole(&svg);
    assert_eq!(count(&svg, "<polyline"), 2);
    let texts = texts(&svg);
    assert!(texts.contains(&"mode 1 · 0 Hz · rigid body"), "{texts:?}");
    assert!(
        texts.contains(&"mode 2 · 5.033 Hz · shaft 100 %"),
        "{texts:?}"
    );
    assert_eq!(texts.iter().filter(|t| **t == "motor").count(), 2);
}

/// Shapes and energies carry the title of the scene above all else.
#[test]
fn law_modes_carry_the_title() {
    let (machine, result) = two_discs();
    for svg in [
        draw_mode_shapes("Two discs", &machine, &result, 8),
        draw_energy_matrix("Two discs", &machine, &result, 8),
    ] {
        assert_whole(&svg);
        assert_eq!(texts(&svg)[0], "Two discs");
    }
}

/// The rigid mode of a geared train is a flat line.
#[test]
fn exact_rigid_mode_is_flat() {
    let (machine, result) = answer("geared_damped", &ModesStudy::default());
    assert!(result.modes[0].rigid);
    let svg = draw_mode_shapes("", &machine, &result, 1);
    for line in svg.split("<polyline").skip(1) {
        let points = line
            .split("points=\"")
            .nth(1)
            .and_then(|p| p.split('"').next())
            .unwrap();
        let mut heights = points
            .split_whitespace()
            .map(|p| p.split_once(',').unwrap().1);
        let first = heights.next().unwrap();
        assert!(heights.all(|y| y == first), "{points}");
    }
}

/// Same machine, same bytes.
#[test]
fn law_same_bytes() {
    let draw = || {
        let (machine, result) = two_discs();
        let (shapes, energies) = (
            draw_mode_shapes("", &machine, &result, 8),
            draw_energy_matrix("", &machine, &result, 8),
        );
        (shapes, energies, draw_campbell(&turbine(25)))
    };
    assert_eq!(draw(), draw());
}

/// Nothing to show is said, not a panic.
#[test]
fn survives_nothing_to_show() {
    let (machine, mut result) = two_discs();
    for count in [0, 1] {
        assert_whole(&draw_mode_shapes("", &machine, &result, count));
        assert_whole(&draw_energy_matrix("", &machine, &result, count));
    }
    result.modes.clear();
    result.energies.clear();
    assert_eq!(
        texts(&draw_mode_shapes("", &machine, &result, 8)),
        ["no modes"]
    );
    assert_eq!(
        texts(&draw_energy_matrix("", &machine, &result, 8)),
        ["no modes"]
    );
    assert_eq!(
        texts(&draw_campbell(&CampbellPlot::default())),
        ["no modes"]
    );
}

/// Each element is named once, its share shown where it takes part.
#[test]
fn exact_energies_of_two_discs() {
    let (machine, result) = two_discs();
    let svg = draw_energy_matrix("", &machine, &result, 8);
    assert_whole(&svg);
    for name in ["motor", "roll", "shaft"] {
        assert_eq!(
            texts(&svg).iter().filter(|t| **t == name).count(),
            1,
            "{name}"
        );
    }
    // The shaft strains in mode 2 alone; the key has four discs.
    assert_eq!(count(&svg, "<circle"), 1 + 4);
}

/// Two torsional modes, two whirling pairs and four orders.
fn turbine(n: usize) -> CampbellPlot {
    let speeds: Vec<f64> = (0..n)
        .map(|i| 3000.0 * i as f64 / (n - 1).max(1) as f64)
        .collect();
    let branch = |label: &str, whirl, start: f64, slope: f64| PlottedBranch {
        label: label.to_string(),
        whirl,
        frequencies_hz: speeds.iter().map(|n| Some(start + slope * n)).collect(),
    };
    let order = |order, label: &str| PlottedOrder {
        order,
        label: label.to_string(),
    };
    let crossing = |speed_rpm, frequency_hz, participation| PlottedCrossing {
        speed_rpm,
        frequency_hz,
        participation,
    };
    let mut branches = vec![
        branch("mode 2 · centre_shaft", PlottedWhirl::None, 95.0, 0.0),
        branch("mode 3 · cradle", PlottedWhirl::None, 99.0, 0.0),
        branch("forward 1", PlottedWhirl::Forward, 60.0, 0.011),
        branch("backward 1", PlottedWhirl::Backward, 60.0, -0.009),
        branch("forward 2", PlottedWhirl::Forward, 140.0, 0.02),
        branch("backward 2", PlottedWhirl::Backward, 140.0, -0.015),
    ];
    let hole = n / 3..n / 2;
    branches[4].frequencies_hz[hole].fill(None);
    CampbellPlot {
        shaft: "motor".to_string(),
        operating_rpm: None,
        branches,
        orders: vec![
            order(1.0, "motor, unbalance"),
            order(2.0, "motor, misalignment"),
            order(13.5, "pinion mesh"),
            order(27.0, "pinion mesh, second harmonic"),
        ],
        crossings: vec![
            crossing(95.0 * 60.0 / 13.5, 95.0, 0.8),
            crossing(99.0 * 60.0 / 13.5, 99.0, 0.1),
            crossing(2850.0, 95.0, 0.4),
        ],
        speeds_rpm: speeds,
    }
}

/// Every mode and order is named, and every crossing ringed.
#[test]
fn exact_labels_of_a_campbell_diagram() {
    let svg = draw_campbell(&turbine(61));
    keep("campbell", &svg);
    assert_whole(&svg);
    let texts = texts(&svg);
    for label in [
        "forward 1",
        "backward 2",
        "mode 3 · cradle",
        "1×  motor, unbalance",
        "13.5×  pinion mesh",
    ] {
        assert!(texts.contains(&label), "{label}: {texts:?}");
    }
    // Two torsional lines and one forward one are whole, the other has a hole.
    let solid = svg
        .split("<polyline")
        .skip(1)
        .filter(|line| count(line, ",") > 10);
    assert_eq!(solid.count(), 2 + 1 + 2);
    assert_eq!(count(&svg, "<circle"), 3);
}

/// One speed, no frequency, a wild number: still a picture.
#[test]
fn survives_poor_campbell_diagrams() {
    assert_whole(&draw_campbell(&turbine(1)));
    assert_whole(&draw_campbell(&turbine(2)));
    let mut lost = turbine(20);
    lost.branches[0].frequencies_hz.fill(None);
    lost.branches[1].frequencies_hz[3] = Some(f64::NAN);
    lost.crossings[0].participation = f64::NAN;
    lost.orders[0].order = 0.0;
    lost.orders[1].order = -1.0;
    assert_whole(&draw_campbell(&lost));
    lost.branches
        .iter_mut()
        .for_each(|b| b.frequencies_hz.fill(None));
    assert_whole(&draw_campbell(&lost));
}
