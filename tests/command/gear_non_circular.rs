//! Files of non-circular gears as `geardyn gear` computes them.

use std::f64::consts::PI;

use serde_json::Value;

use crate::support::command::{document, geardyn, put, refusal, said};
use crate::support::verification::within;
use crate::support::{number, numbers};

const ELLIPTIC: &str = "models/gears/elliptic.toml";

const PAIR: &str = "pair = { kind = \"non-circular\", centre_distance = \"100 mm\" }\n";

/// The document of a file with this text below `pair`.
fn answer(text: &str) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "pair.toml", &format!("{PAIR}{text}"));
    document(&["gear", path.to_str().unwrap(), "--json"])
}

/// Code and message of its refusal.
fn refused(text: &str) -> (String, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "pair.toml", &format!("{PAIR}{text}"));
    refusal(&["gear", path.to_str().unwrap()])
}

/// Two ellipses of semi-major axis A = a/2 about foci: `r₁ = A (1 − e²)/(1 − e cos φ₁ …)` at its apexes A (1 ± e), `i₁₂` from (1 − e)/(1 + e) to
/// its inverse, curvature A/b² at the apexes, `m = S/(π z)`.
#[test]
fn exact_elliptic_gears() {
    let found = document(&["gear", ELLIPTIC, "--json"]);
    let geometry = &found["geometry"];
    let (axis, e) = (50.0, 0.3_f64);
    let off = |key: &str, value: f64| (number(&geometry[key]) / value - 1.0).abs();
    within(
        "least ratio",
        off("least_ratio", (1.0 - e) / (1.0 + e)),
        1e-12,
    );
    within(
        "largest ratio",
        off("largest_ratio", (1.0 + e) / (1.0 - e)),
        1e-12,
    );
    let radii = numbers(&geometry["largest_centrode_radius_mm"]);
    within(
        "largest radius",
        (radii[0] / (axis * (1.0 + e)) - 1.0).abs(),
        1e-12,
    );
    let arcs = numbers(&geometry["arc_of_the_centrode_mm"]);
    within("both arcs", (arcs[0] / arcs[1] - 1.0).abs(), 1e-12);
    // Perimeter by Gauss and Kummer's series in h = ((A − b)/(A + b))².
    let b = axis * (1.0 - e * e).sqrt();
    let h = ((axis - b) / (axis + b)).powi(2);
    let perimeter = PI * (axis + b) * (1.0 + h / 4.0 + h * h / 64.0 + h.powi(3) / 256.0);
    within("perimeter", (arcs[0] / perimeter - 1.0).abs(), 1e-10);
    within("module", off("module_mm", arcs[0] / (31.0 * PI)), 1e-12);
    for k in 0..2 {
        let largest = 1e-3 * number(&found["curvature"][k]["largest_per_m"]);
        within(
            "largest curvature",
            (largest * b * b / axis - 1.0).abs(),
            1e-9,
        );
        assert_eq!(found["curvature"][k]["convex"], true);
    }
    let flank = &found["flank"];
    within(
        "law of gearing, arcsec",
        number(&flank["law_error_arcsec"]),
        1e-7,
    );
    within(
        "envelope against normals, µm",
        number(&flank["route_deviation_um"]),
        1e-7,
    );
}

/// A ratio that falls linearly from i₀ to i₁ over Φ: `φ₂ = ln(1 + K φ₁/i₀)/K`, `K = (i₁ − i₀)/Φ`, `r₁ = a/(i₁₂ + 1)`; its centrodes are open.
#[test]
fn exact_linear_ratio() {
    let text = "ratio = { kind = \"linear\", first = 2.0, last = 0.5, over = \"270 deg\" }\n";
    let found = answer(text);
    let centrodes = &found["centrodes"];
    let [first, second, radius] =
        ["angle_1_rad", "angle_2_rad", "radius_1_mm"].map(|key| numbers(&centrodes[key]));
    let slope = -1.5 / 1.5 / PI;
    for k in 0..first.len() {
        let exact = (slope * first[k] / 2.0).ln_1p() / slope;
        within("angle of gear 2, rad", (second[k] - exact).abs(), 1e-12);
        let exact = 100.0 / (3.0 + slope * first[k]);
        within("radius, mm", (radius[k] - exact).abs(), 1e-11);
    }
    assert!(found["flank"].is_null());
    let (code, message) = refused(&format!(
        "{text}pinion = {{ teeth = 20 }}\ngear = {{ teeth = 20 }}\n"
    ));
    assert!(
        code == "out-of-range" && message.contains("open"),
        "{message}"
    );
}

/// A table of the elliptic law gives the elliptic law; a row that falls, and a table that does not close, are refused at their line.
#[test]
fn exact_table_of_a_law() {
    let folder = tempfile::tempdir().unwrap();
    let write = |change: &dyn Fn(usize, f64) -> f64| {
        let mut text = "angle_1 [deg],angle_2 [deg]\n".to_string();
        for k in 0..=72 {
            let angle = f64::to_radians(5.0 * f64::from(k));
            let exact = angle + 2.0 * (0.3 * angle.sin() / (1.0 - 0.3 * angle.cos())).atan();
            let exact = exact.to_degrees();
            text += &format!("{},{:.9}\n", 5 * k, change(k as usize, exact));
        }
        put(folder.path(), "law.csv", &text);
        let text = "ratio = { kind = \"table\", file = \"law.csv\" }\npinion = { teeth = 31 }\ngear = { teeth = 31 }\n";
        let path = put(folder.path(), "table.toml", &format!("{PAIR}{text}"));
        path.to_str().unwrap().to_string()
    };
    let found = document(&["gear", &write(&|_, angle| angle), "--json"]);
    let elliptic = document(&["gear", ELLIPTIC, "--json"]);
    let module = |found: &Value| number(&found["geometry"]["module_mm"]);
    within(
        "module of the table",
        (module(&found) / module(&elliptic) - 1.0).abs(),
        1e-7,
    );
    let falls = |k: usize, angle: f64| if k == 7 { angle - 20.0 } else { angle };
    let (code, text, notes) = said(&["gear", &write(&falls)]);
    assert!(
        code == Some(2) && notes.contains("law.csv:9:1"),
        "{text}{notes}"
    );
    assert!(notes.contains("not monotonic"), "{notes}");
    let (code, text, notes) = said(&["gear", &write(&|_, angle| 0.9 * angle)]);
    assert!(
        code == Some(2) && notes.contains("does not close"),
        "{text}{notes}"
    );
    assert!(notes.contains("law.csv:74:1"), "{notes}");
}

/// A circle that rolls on the centrode, a cycloid, and an arc beside the pitch circle have conjugates that keep the law, by normals and by the
/// equation of meshing.
#[test]
fn law_profiles_keep_the_ratio() {
    let circle = "ratio = { kind = \"constant\", ratio = 2 }\n";
    let elliptic = "ratio = { kind = \"elliptic\", eccentricity = 0.3 }\n";
    let cases = [
        (
            elliptic,
            "kind = \"rolling\", radius = \"8 mm\", arcs = [\"0.5 mm\", \"9 mm\"]",
        ),
        (
            circle,
            "kind = \"cycloid\", rolling_radius = \"10 mm\", angles = [\"3 deg\", \"30 deg\"]",
        ),
        (
            circle,
            "kind = \"circular-arc\", radius = \"5 mm\", centre = [\"31 mm\", \"0 mm\"], directions = [\"30 deg\", \"60 deg\"]",
        ),
    ];
    for (ratio, profile) in cases {
        for route in ["normals", "envelope"] {
            let text = format!(
                "{ratio}pinion = {{ profile = {{ {profile} }} }}\ngear = {{ profile = {{ kind = \"conjugate\", by = \"{route}\" }} }}\n"
            );
            let flank = &answer(&text)["flank"];
            assert!(number(&flank["law_error_arcsec"]) < 1e-6, "{profile}");
            assert!(
                number(&flank["route_deviation_um"]) < 1e-5,
                "{profile} by {route}"
            );
        }
    }
}

/// Profiles without a conjugate, shapers, tooth numbers that do not fit and flags of a load are refused by name.
#[test]
fn refuses_gears_without_a_law() {
    let circle = "ratio = { kind = \"constant\", ratio = 2 }\n";
    let (code, message) = refused(&format!(
        "{circle}pinion = {{ profile = {{ kind = \"circular-arc\", radius = \"5 mm\", centre = [\"33.333333333333336 mm\", \"0 mm\"], directions = [\"30 deg\", \"60 deg\"] }} }}\n"
    ));
    assert!(
        code == "out-of-range" && message.contains("Wildhaber–Novikov"),
        "{message}"
    );
    let (_, message) = refused(&format!(
        "{circle}pinion = {{ profile = {{ kind = \"shaper\" }} }}\n"
    ));
    assert!(message.contains("shaper"), "{message}");
    let (_, message) = refused(&format!(
        "{circle}pinion = {{ teeth = 20 }}\ngear = {{ teeth = 41 }}\n"
    ));
    assert!(message.contains("different pitches"), "{message}");
    let waves = "ratio = { kind = \"sine\", mean = 1.25, amplitude = 0.75, cycles = 4 }\n";
    let (_, message) = refused(&format!(
        "{waves}pinion = {{ teeth = 40 }}\ngear = {{ teeth = 40 }}\n"
    ));
    assert!(message.contains("concave"), "{message}");
    let (_, message) = refusal(&["gear", ELLIPTIC, "--torque", "100"]);
    assert!(message.contains("--torque has no effect here"), "{message}");
}

/// Centrodes as a table, figures, outlines of both gears with equal areas; `check` and `plan` take the file.
#[test]
fn keeps_files_of_elliptic_gears() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let [svg, csv, outline] = ["e.svg", "e.csv", "o.csv"].map(at);
    let done = geardyn(&[
        "gear",
        ELLIPTIC,
        "--svg",
        &svg,
        "--csv",
        &csv,
        "--outline",
        &outline,
        "--quiet",
    ]);
    assert!(done.status.success());
    for name in ["e.svg", "e-ratio.svg"] {
        let plot = std::fs::read_to_string(at(name)).unwrap();
        assert!(plot.contains("Elliptic gears"), "{name}");
    }
    let table = std::fs::read_to_string(csv).unwrap();
    assert!(table.starts_with("angle_1 [deg],angle_2 [deg],ratio,radius_1 [mm]"));
    let text = std::fs::read_to_string(outline).unwrap();
    let area = |name: &str| {
        let points: Vec<[f64; 2]> = (text.lines().filter(|line| line.starts_with(name)))
            .map(|line| {
                let cells: Vec<f64> = line
                    .split(',')
                    .skip(1)
                    .map(|x| x.parse().unwrap())
                    .collect();
                [cells[0], cells[1]]
            })
            .collect();
        let edge = |p: &[[f64; 2]]| p[0][0] * p[1][1] - p[1][0] * p[0][1];
        0.5 * points.windows(2).map(edge).sum::<f64>()
    };
    let (first, second) = (area("pinion"), area("gear"));
    assert!(
        first > 0.0 && (first / second - 1.0).abs() < 1e-9,
        "{first} {second}"
    );
    let (code, text, _) = said(&["check", ELLIPTIC]);
    assert!(
        code == Some(0) && text.contains("non-circular gears of 31 and 31 teeth"),
        "{text}"
    );
    let (code, text, _) = said(&["plan", ELLIPTIC]);
    assert!(code == Some(0) && text.contains("outlines"), "{text}");
}

/// Contact of rack-cut flanks ends where a point leaves the tip of either gear: circular gears have
/// `ε_α = Σ (√(r_a² − r_b²) − r sin α)/(π m cos α)` with r_a = r + m, as the same pair of cylindrical gears.
#[test]
fn exact_contact_ends_at_the_tips() {
    for [z1, z2] in [[20.0, 40.0], [24.0, 24.0], [30.0, 90.0]] {
        let ratio: f64 = z2 / z1;
        let text = format!(
            "ratio = {{ kind = \"constant\", ratio = {ratio} }}\npinion = {{ teeth = {z1} }}\ngear = {{ teeth = {z2} }}\n"
        );
        let module = 200.0 / (z1 + z2);
        let (sin, cos) = 20f64.to_radians().sin_cos();
        let part = |z: f64| {
            let (pitch, tip) = (0.5 * module * z, module * (0.5 * z + 1.0));
            (tip * tip - (pitch * cos).powi(2)).sqrt() - pitch * sin
        };
        let exact = (part(z1) + part(z2)) / (PI * module * cos);
        let found = number(&answer(&text)["geometry"]["contact_ratio_of_the_flank"]);
        within("contact ratio", (found - exact).abs(), 1e-9);
    }
    // Teeth differ along elliptic centrodes, and none reaches what the rack's addendum alone allows.
    let elliptic =
        number(&document(&["gear", ELLIPTIC, "--json"])["geometry"]["contact_ratio_of_the_flank"]);
    assert!((1.5..1.8).contains(&elliptic), "{elliptic}");
}

/// A pitch curve without a centre distance gets that at which its mate closes: an eccentric circle of the polar equation
/// `r = R √(1 − e² sin²φ) + R e cos φ` with two lobes, against a quadrature of `∫ r/(a − r) dφ = π`.
#[test]
fn exact_centre_distance_of_closure() {
    let folder = tempfile::tempdir().unwrap();
    let radius = |phi: f64| 20.0 * ((1.0 - (0.2 * phi.sin()).powi(2)).sqrt() + 0.2 * phi.cos());
    let rows = (0..=720).map(|i| {
        let phi = 2.0 * PI * f64::from(i) / 720.0;
        format!("{},{}\n", phi.to_degrees(), radius(phi))
    });
    let table: String = std::iter::once("angle_1 [deg],radius_1 [mm]\n".to_string())
        .chain(rows)
        .collect();
    put(folder.path(), "curve.csv", &table);
    let text = "pair = { kind = \"non-circular\" }\nratio = { kind = \"pitch-curve\", file = \"curve.csv\", lobes = 2 }\npinion = { profile = { kind = \"rack\" } }\n";
    let path = put(folder.path(), "pair.toml", text);
    let found = document(&["gear", path.to_str().unwrap(), "--json"]);
    let distance = number(&found["geometry"]["centre_distance_mm"]);
    // Trapezia are exact for a periodic function.
    let turn: f64 = (0..720)
        .map(|i| radius(2.0 * PI * f64::from(i) / 720.0))
        .map(|r| r / (distance - r) * 2.0 * PI / 720.0)
        .sum();
    within("turn of the mate", (turn / PI - 1.0).abs(), 1e-9);
}

/// Conjugate flanks given as points keep the law. A circle in place of the conjugate breaks it, with the ratio of its normal.
#[test]
fn exact_given_pair_of_arcs() {
    let pinion = "{ kind = \"circular-arc\", radius = \"5 mm\", centre = [\"31 mm\", \"0 mm\"], directions = [\"30 deg\", \"60 deg\"] }";
    let text = format!(
        "ratio = {{ kind = \"constant\", ratio = 2 }}\npinion = {{ profile = {pinion} }}\n"
    );
    // The conjugate, as points of a file, keeps the law to the error of the spline.
    let flank = answer(&text);
    let points = flank["flank"]["gear_mm"].as_array().unwrap();
    let rows = points
        .iter()
        .map(|p| format!("{},{}\n", number(&p[0]), number(&p[1])));
    let table: String = std::iter::once("x [mm],y [mm]\n".to_string())
        .chain(rows)
        .collect();
    let folder = tempfile::tempdir().unwrap();
    put(folder.path(), "gear.csv", &table);
    let given = "gear = { profile = { kind = \"points\", file = \"gear.csv\" } }\n";
    let path = put(folder.path(), "pair.toml", &format!("{PAIR}{text}{given}"));
    let found = document(&["gear", path.to_str().unwrap(), "--json"]);
    let contacts = found["given"].as_array().unwrap();
    assert!(contacts.len() > 20, "{}", contacts.len());
    for contact in contacts {
        within(
            "ratio of conjugate points",
            (number(&contact["ratio"]) / 2.0 - 1.0).abs(),
            1e-4,
        );
        assert!(number(&contact["te_arcsec"]).abs() < 0.01, "{contact}");
    }
    // The circle through three points of the conjugate breaks the law: i₁₂ = O₂I/O₁I of its normal, and by the turn of the gear itself,
    // dψ₂/dφ₁ = 1/i₁₂ of the law plus the slope of the transmission error.
    let at = |k: usize| [number(&points[k][0]), number(&points[k][1])];
    let [[ax, ay], [bx, by], [cx, cy]] = [at(2), at(20), at(38)];
    let d = 2.0 * (ax * (by - cy) + bx * (cy - ay) + cx * (ay - by));
    let [a2, b2, c2] = [ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy];
    let x = (a2 * (by - cy) + b2 * (cy - ay) + c2 * (ay - by)) / d;
    let y = (a2 * (cx - bx) + b2 * (ax - cx) + c2 * (bx - ax)) / d;
    let ends = [at(0), at(40)].map(|[px, py]| {
        let turn = (py - y).atan2(px - x).to_degrees();
        if turn < 0.0 { turn + 360.0 } else { turn }
    });
    let arc = format!(
        "gear = {{ profile = {{ kind = \"circular-arc\", radius = \"{} mm\", centre = [\"{x} mm\", \"{y} mm\"], directions = [\"{} deg\", \"{} deg\"] }} }}\n",
        (ax - x).hypot(ay - y),
        ends[0].min(ends[1]),
        ends[0].max(ends[1])
    );
    let path = put(folder.path(), "arcs.toml", &format!("{PAIR}{text}{arc}"));
    let found = document(&["gear", path.to_str().unwrap(), "--json"]);
    assert_eq!(found["warnings"][0]["code"], "law-of-gearing");
    let contacts = found["given"].as_array().unwrap();
    assert!(contacts.len() > 20, "{}", contacts.len());
    for three in contacts.windows(3) {
        let of = |k: usize, key: &str| number(&three[k][key]);
        let crossing = 100.0 / 3.0 + of(1, "pitch_point_miss_mm");
        let ratio = of(1, "ratio");
        within(
            "ratio of the normal",
            (ratio * crossing / (100.0 - crossing) - 1.0).abs(),
            1e-9,
        );
        let slope = (of(2, "te_arcsec") - of(0, "te_arcsec")) * PI
            / 648_000.0
            / (of(2, "angle_1_rad") - of(0, "angle_1_rad"));
        within(
            "ratio of the turn",
            ((0.5 + slope) * ratio - 1.0).abs(),
            2e-3,
        );
    }
}

/// A cycloidal pair and a gerotor by Camus' theorem keep their ratio. The ring of a gerotor is the arc itself: its points lie 10 mm from
/// (42 mm, 0) turned with the ring.
#[test]
fn exact_rolling_curves_of_shipped_pairs() {
    let cycloidal = document(&["gear", "models/gears/cycloidal.toml", "--json"]);
    assert!(number(&cycloidal["flank"]["law_error_arcsec"]) < 1e-7);
    let gerotor = document(&["gear", "models/gears/gerotor.toml", "--json"]);
    assert!(number(&gerotor["flank"]["law_error_arcsec"]) < 1e-7);
    for point in gerotor["flank"]["gear_mm"].as_array().unwrap() {
        let off = (number(&point[0]) - 42.0).hypot(number(&point[1])) - 10.0;
        within("arc of the ring", off.abs(), 1e-9);
    }
}

/// A flank that folds back, as a cycloid drawn over its cusp, is warned of.
#[test]
fn law_folded_flanks_are_named() {
    let text = "ratio = { kind = \"constant\", ratio = 2 }\npinion = { profile = { kind = \"rolling\", radius = \"8 mm\", arcs = [\"-5 mm\", \"5 mm\"] } }\n";
    let found = answer(text);
    let codes = found["warnings"].to_string();
    assert!(codes.contains("folded"), "{codes}");
}

/// Elliptic gears of few teeth are undercut by the rack; the tooth numbers and the dedendum of the remedy leave none.
#[test]
fn law_remedy_of_undercut_by_the_rack() {
    let text = |teeth: u32, rack: &str| {
        format!(
            "ratio = {{ kind = \"elliptic\", eccentricity = 0.3 }}\n{rack}\npinion = {{ teeth = {teeth} }}\ngear = {{ teeth = {teeth} }}\n"
        )
    };
    let hints = answer(&text(13, ""))["warnings"].to_string();
    assert!(hints.contains("undercut"), "{hints}");
    let after = hints
        .split("teeth = ")
        .nth(1)
        .unwrap_or_else(|| panic!("{hints}"));
    let teeth = after.split(' ').next().unwrap().parse().unwrap();
    let free = answer(&text(teeth, ""))["warnings"].to_string();
    assert!(!free.contains("undercut"), "{free}");
    if let Some(rest) = hints.split("dedendum = ").nth(1) {
        let dedendum = rest.split(' ').next().unwrap();
        let free = answer(&text(13, &format!("rack = {{ dedendum = {dedendum} }}")))["warnings"]
            .to_string();
        assert!(!free.contains("undercut"), "{free}");
    }
}

/// A table that is not there and a ratio that does not close are refused at `ratio`.
#[test]
fn refuses_ratios_at_their_place() {
    for (ratio, words) in [
        (
            "ratio = { kind = \"table\", file = \"none.csv\" }",
            "there is no file",
        ),
        (
            "ratio = { kind = \"sine\", mean = 1.3, amplitude = 0.3, cycles = 2 }",
            "does not close",
        ),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let text = format!("{PAIR}{ratio}\npinion = {{ teeth = 31 }}\ngear = {{ teeth = 31 }}\n");
        let path = put(folder.path(), "pair.toml", &text);
        let (_, _, notes) = said(&["gear", path.to_str().unwrap()]);
        assert!(
            notes.contains(words) && notes.contains("pair.toml:2:"),
            "{notes}"
        );
    }
}
