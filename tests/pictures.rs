//! Pictures: whole, finite, the same every time, and with the lines and labels they should have.
//!
//! `GEARDYN_PICTURES=DIR cargo test --test pictures` also writes them to DIR.

use std::path::Path;

use geardyn::plan::prepared::Prepared;
use geardyn::plan::run::{Answer, run};
use geardyn::plan::stages::Plan;
use geardyn::report::campbell_picture::{
    BranchLine, Crossing, Diagram, OrderLine, Whirl, campbell,
};
use geardyn::report::energy_bars::energy_matrix;
use geardyn::report::shapes::mode_shapes;
use geardyn::scene::study::ModesStudy;
use geardyn::scene::{read, read_text};

fn answer(model: &str, study: &ModesStudy) -> (Prepared, Answer) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("models")
        .join(format!("{model}.toml"));
    prepared(&read(&path).unwrap().model, study)
}

fn prepared(model: &geardyn::scene::model::Model, study: &ModesStudy) -> (Prepared, Answer) {
    let prepared = Prepared::new(model).unwrap_or_else(|e| panic!("{}", e.message));
    let plan = Plan::modes(&prepared, study);
    let answer = run(&prepared, study, &plan).unwrap_or_else(|e| panic!("{}", e.message));
    (prepared, answer)
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
            let (prepared, answer) = answer(model, &study);
            if damped && !answer.complex {
                continue;
            }
            let suffix = if damped { "_damped" } else { "" };
            let shapes = mode_shapes(&prepared, &answer, 8);
            assert_whole(&shapes);
            keep(&format!("{model}{suffix}_shapes"), &shapes);
            let energies = energy_matrix(&prepared, &answer, 20);
            assert_whole(&energies);
            keep(&format!("{model}{suffix}_energies"), &energies);
        }
    }
}
