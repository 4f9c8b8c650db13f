//! Geometry of tests: read from sidecars and UFF files, written as UFF, against pyuff.

use geardyn::internals::base::flags::Flags;
use geardyn::internals::base::load;
use geardyn::internals::numeric::Complex;
use geardyn::internals::recording::frequency_responses::{
    ChannelLabel, FrequencyResponse, FrequencyResponses,
};
use geardyn::internals::recording::geometry::{ChannelPlace, Geometry, GeometryPoint};
use geardyn::internals::recording::raw::RawLog;
use geardyn::internals::recording::read_options::ReadOptions;
use geardyn::internals::recording::{sidecar, uff, write};
use serde_json::Value;

fn stated(text: &str) -> Result<Geometry, String> {
    let source = load::source_from_text("hits.toml".into(), text);
    let read = sidecar::read(&source, &Flags::default());
    read.map(|options| options.geometry)
        .map_err(|errors| errors.to_string())
}

const BEAM: &str = r#"
[[point]]
name = "1"
at = ["0 m", "0 m", "0 m"]

[[point]]
name = "tip"
at = ["250 mm", "-1 in", "0.5 m"]

[[line]]
between = ["1", "tip"]

[[channel]]
name = "a1"
rename = "top"
point = "1"
direction = "-z"

[[channel]]
name = "a2"
point = "tip"
direction = [0.0, 3.0, 4.0]
"#;

/// Points with units, a line, and channels along an axis and along a vector.
#[test]
fn exact_sidecar() {
    let found = stated(BEAM).unwrap();
    assert_eq!(found.points[1].name, "tip");
    let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15);
    assert!(near(found.points[1].at, [0.25, -0.0254, 0.5]));
    assert_eq!(found.lines, [vec![0, 1]]);
    assert_eq!(found.place("top"), Some((0, [0.0, 0.0, -1.0])));
    let (point, direction) = found.place("a2").unwrap();
    assert!(point == 1 && near(direction, [0.0, 0.6, 0.8]));
    assert!(found.place("a1").is_none());
}

/// Each mistake is named with its line, its key and a remedy.
#[test]
fn refuses_broken_geometry() {
    for (from, to, words) in [
        (
            "name = \"tip\"",
            "name = \"1\"",
            &[
                "hits.toml:7:",
                "two [[point]] have the name \"1\"",
                "a name of its own",
            ][..],
        ),
        (
            "\"1\", \"tip\"",
            "\"1\", \"tipp\"",
            &["hits.toml:11:", "tipp", "did you mean \"tip\"?"],
        ),
        ("\"1\", \"tip\"", "\"1\"", &["hits.toml:11:", "one point"]),
        (
            "point = \"tip\"",
            "point = \"3\"",
            &["hits.toml:21:", "\"3\"", "the points are"],
        ),
        (
            "direction = \"-z\"\n",
            "",
            &["hits.toml:16:", "`point` needs `direction`"],
        ),
        (
            "\"-z\"",
            "\"up\"",
            &["hits.toml:17:", "`direction` cannot be \"up\"", "\"+x\""],
        ),
        (
            "[0.0, 3.0, 4.0]",
            "[0.0, 0.0, 0.0]",
            &["hits.toml:22:", "no length"],
        ),
        ("\"250 mm\"", "\"250 N\"", &["hits.toml:8:", "at"]),
        ("\"250 mm\", ", "", &["hits.toml:8:", "a list of 3"]),
    ] {
        assert!(BEAM.contains(from));
        let message = stated(&BEAM.replace(from, to)).unwrap_err();
        for word in words {
            assert!(message.contains(word), "{to}: {word} is not in\n{message}");
        }
    }
}

/// Channels of a roving test take the points of their files.
#[test]
fn exact_roving_places() {
    let mut found = stated(&BEAM.replace("point = \"tip\"\n", "")).unwrap();
    let pair = |channel: &str, name: &str| (channel.to_string(), name.to_string());
    found.place_roving(&[
        pair("a2", "a2@tip"),
        pair("a2", "1"),
        pair("a3", "tip"),
        pair("a2", "7"),
    ]);
    let point = |name| found.place(name).map(|p| p.0);
    assert_eq!(
        [point("a2@tip"), point("1"), point("tip"), point("7")],
        [Some(1), Some(0), None, None]
    );
}

fn read_uff(bytes: &[u8]) -> RawLog {
    uff::read("a.uff", bytes, &ReadOptions::default()).unwrap()
}

/// Responses to a force at `tip` of sensors at three points, one of which the geometry does not place.
fn responses() -> FrequencyResponses {
    let label = |name: &str, unit: &str| ChannelLabel {
        name: name.into(),
        unit: unit.into(),
    };
    let response = |output: &str| FrequencyResponse {
        input: Some(label("hammer", "N")),
        output: label(output, "m/s²"),
        values: vec![Complex::new(1.0, -0.5); 4],
        ..FrequencyResponse::default()
    };
    FrequencyResponses {
        frequency_hz: vec![1.0, 2.0, 3.0, 4.0],
        responses: ["a1", "a2", "mic"].map(response).to_vec(),
        ..FrequencyResponses::default()
    }
}

fn geometry(names: [&str; 3]) -> Geometry {
    let place = |channel: &str, point: usize, direction: [f64; 3]| ChannelPlace {
        channel: channel.into(),
        point: Some(point),
        direction,
    };
    let at = [
        [0.1, 1.0 / 3.0, -7e-11],
        [1e9, -0.0254, 2.0 / 7.0],
        [0.0; 3],
    ];
    Geometry {
        points: (names.iter().zip(at))
            .map(|(name, at)| GeometryPoint {
                name: name.to_string(),
                at,
            })
            .collect(),
        lines: vec![vec![0, 1, 2, 0, 1, 2, 0, 1, 2, 0], vec![2, 1]],
        channels: vec![
            place("a1", 0, [0.0, -1.0, 0.0]),
            place("a2", 2, [0.0, 0.0, 1.0]),
            place("hammer", 1, [1.0, 0.0, 0.0]),
        ],
    }
}

/// Points, lines, channels and directions of a written file are those read, to the last bit; names that are no numbers become numbers.
#[test]
fn law_uff_geometry_reads_back() {
    for (names, numbers) in [
        (["12", "7", "4000"], ["12", "7", "4000"]),
        (["a", "b", "7"], ["1", "2", "3"]),
    ] {
        for format in [write::uff::UffFormat::Text, write::uff::UffFormat::Binary] {
            let mut bytes = Vec::new();
            write::uff::write_responses(&responses(), &geometry(names), format, &mut bytes)
                .unwrap();
            let read = read_uff(&bytes).geometry;
            let known = geometry(numbers);
            let bits = |g: &Geometry| {
                g.points
                    .iter()
                    .map(|p| p.at.map(f64::to_bits))
                    .collect::<Vec<_>>()
            };
            assert_eq!(bits(&read), bits(&known));
            assert_eq!((&read.points, &read.lines), (&known.points, &known.lines));
            for channel in ["a1", "a2", "hammer", "mic"] {
                assert_eq!(read.place(channel), known.place(channel), "{channel}");
            }
        }
    }
}

#[test]
fn refuses_a_skew_direction_in_uff() {
    let mut skew = geometry(["1", "2", "3"]);
    skew.channels[0].direction = [0.6, 0.8, 0.0];
    let format = write::uff::UffFormat::Text;
    let error = write::uff::write_responses(&responses(), &skew, format, &mut Vec::new());
    assert!(
        error
            .unwrap_err()
            .message
            .contains("a1 points between the axes")
    );
}

/// Nodes and trace lines of data sets 15, 2411 and 82.
/// Source: pyuff 2.5.8 (tools/log_formats.py).
#[test]
fn ref_pyuff_geometry() {
    let document = std::fs::read_to_string("data/reference/log_formats.json").unwrap();
    let document: Value = serde_json::from_str(&document).unwrap();
    let at = [[0.0; 3], [0.1, -2.5e-3, 1e-7], [1.0 / 3.0, 0.0, -4.0]];
    for (key, digits) in [("uff_geometry_15", 1e-5), ("uff_geometry_2411", 0.0)] {
        let text = document[key].as_str().unwrap();
        let bytes: Vec<u8> = (0..text.len() / 2)
            .map(|k| u8::from_str_radix(&text[2 * k..2 * k + 2], 16).unwrap())
            .collect();
        let found = read_uff(&bytes).geometry;
        let names: Vec<&str> = found.points.iter().map(|p| p.name.as_str()).collect();
        assert_eq!(names, ["1", "7", "8"]);
        for (point, at) in found.points.iter().zip(at) {
            for (a, b) in point.at.iter().zip(at) {
                assert!((a - b).abs() <= digits * b.abs(), "{a} {b}");
            }
        }
        assert_eq!(found.lines, [vec![0, 1, 2], vec![2, 0]]);
        assert_eq!(found.place("7+Z"), Some((1, [0.0, 0.0, 1.0])));
    }
}

/// Coordinates in mm by data set 164; nodes in systems of their own are named; a line through a node that is not there is refused.
#[test]
fn survives_other_units_and_systems() {
    let mut bytes = Vec::new();
    let format = write::uff::UffFormat::Text;
    write::uff::write_responses(&responses(), &Geometry::default(), format, &mut bytes).unwrap();
    let written = String::from_utf8(bytes).unwrap();
    let units = "    -1\n   164\n         5mm (milli-newton)            2\n  1.00000000000000000D+03  1.00000000000000000D+03  1.00000000000000000D+00\n  2.73149999999999977D+02\n    -1\n";
    let nodes = |system: i64| {
        format!(
            "    -1\n    15\n         1         0{system:10}         8 2.50000D+02 0.0 -1.0E+03\n    -1\n"
        )
    };
    let trace = |node: i64| {
        format!(
            "    -1\n    82\n         1         2         0\nNONE\n         1{node:10}\n    -1\n"
        )
    };
    let read = |text: String| uff::read("a.uff", text.as_bytes(), &ReadOptions::default());
    let found = read(format!("{}{units}{written}", nodes(0))).unwrap();
    assert_eq!(found.geometry.points[0].at, [0.25, 0.0, -1.0]);
    assert!(found.diagnostics.iter().all(|d| d.code != "local-axes"));
    let local = read(format!("{}{written}", nodes(5))).unwrap();
    assert!(local.diagnostics.iter().any(|d| d.code == "local-axes"));
    let message = read(format!("{}{}{written}", nodes(0), trace(9)))
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("node 9") && message.contains("a.uff:7:"),
        "{message}"
    );
    let message = read(nodes(0).replace("-1.0E+03", "x"))
        .unwrap_err()
        .to_string();
    assert!(message.contains("a.uff:3:"), "{message}");
    let message = read(nodes(0)).unwrap_err().to_string();
    assert!(message.contains("only geometry"), "{message}");
}
