//! Files of bevel pairs as `geardyn gear` computes them.

use std::collections::HashMap;

use serde_json::Value;

use crate::support::command::{document, geardyn, put, refusal, said, with_other_digits};
use crate::support::verification::within;
use crate::support::{number, numbers};

const NASA: &str = "models/gears/bevel_12_36.toml";

/// The shipped file with a text in place of another.
fn changed(from: &str, to: &str) -> (tempfile::TempDir, String) {
    let text = std::fs::read_to_string(NASA).unwrap();
    assert!(text.contains(from), "{from}");
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "pair.toml", &text.replacen(from, to, 1));
    let path = path.to_str().unwrap().to_string();
    (folder, path)
}

fn reference(name: &str) -> Value {
    let path = format!("data/reference/gear/{name}.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// The flank of a document.
fn flank<'a>(found: &'a Value, member: usize, side: &str) -> &'a Value {
    let flanks = found["members"][member]["flanks"].as_array().unwrap();
    flanks.iter().find(|f| f["side"] == side).unwrap()
}

/// Value at x between four equidistant neighbours, by Lagrange's formula.
fn between(xs: &[f64], ys: &[f64], x: f64) -> f64 {
    let k = xs.partition_point(|a| *a < x).clamp(2, xs.len() - 2) - 2;
    (k..k + 4)
        .map(|i| {
            let others = (k..k + 4).filter(|j| *j != i);
            ys[i]
                * others
                    .map(|j| (x - xs[j]) / (xs[i] - xs[j]))
                    .product::<f64>()
        })
        .sum()
}

/// Corner nodes of the flanks from the file's blank and settings.
/// Source: NASA CR-191009 (Bibel, Reddy and Kumar 1994); grids by two routes, data/reference/gear/c12_nasa_cr191009_flanks.json.
#[test]
fn ref_nasa_flanks_of_the_file() {
    let case = reference("c12_nasa_cr191009_flanks");
    let found = document(&["gear", NASA, "--json"]);
    for (name, member, side) in [
        ("pinion_concave", 0, "concave"),
        ("gear_convex", 1, "convex"),
    ] {
        let of = flank(&found, member, side);
        let count = |key: &str| of[key].as_u64().unwrap() as usize;
        let (rows, columns) = (count("rows"), count("columns"));
        let (mut places, mut normals, mut nodes) = (0f64, 0f64, 0);
        for node in case["grid_computed_here"][name].as_array().unwrap() {
            let (height, face) = (number(&node["height"]), number(&node["face"]));
            let row = height * (rows - 1) as f64;
            let column = face * (columns - 1) as f64;
            if row.fract() != 0.0 || column.fract() != 0.0 {
                continue;
            }
            let index = row as usize * columns + column as usize;
            let [xyz, n] = [&node["xyz"], &node["n"]].map(numbers);
            let point = numbers(&of["points_m"][index]);
            let normal = numbers(&of["normals"][index]);
            let sign = normal
                .iter()
                .zip(&n)
                .map(|(a, b)| a * b)
                .sum::<f64>()
                .signum();
            for k in 0..3 {
                places = places.max((point[k] / 0.0254 - xyz[k]).abs());
                normals = normals.max((sign * normal[k] - n[k]).abs());
            }
            nodes += 1;
        }
        assert!(nodes >= 9, "{nodes}");
        within(&format!("{name}: points, in"), places, 1e-12);
        within(&format!("{name}: normals"), normals, 1e-12);
    }
}

/// Angles, transmission error and ellipse of the file's pair.
/// Source: two computations, with and without normals, data/reference/gear/c14_tca_nasa_12_36.json and c31_te_with_edges_12_36.json.
#[test]
fn ref_contact_of_the_file() {
    let result = &reference("c14_tca_nasa_12_36")["result"][0];
    let found = document(&["gear", NASA, "--positions", "480", "--json"]);
    let tca = &found["tca"];
    let at = &tca["reference"];
    let phi = number(&result["reference"]["phi1"]);
    within(
        "reference angle φ₁, rad",
        (number(&at["pinion_angle_rad"]) - phi).abs(),
        1e-8,
    );
    let ellipse = &result["contact_ellipse_at_reference"];
    let axes = numbers(&at["ellipse_semi_axes_m"]);
    for (k, name) in ["longer", "shorter"].iter().enumerate() {
        let expected = 0.0254 * number(&ellipse["semi_axes"][1 - k]);
        // The file of the case has a coating of 0.00025 in, which is 6.35 µm.
        within(
            &format!("{name} semi-axis, relative"),
            (axes[k] / expected - 1.0).abs(),
            1e-8,
        );
    }
    let of = |key: &str| -> Vec<f64> {
        let points = tca["points"].as_array().unwrap();
        points.iter().map(|p| number(&p[key])).collect()
    };
    let [angles, gear, te] = ["pinion_angle_rad", "gear_angle_rad", "te_arcsec"].map(of);
    let pairs = of("pair");
    let (mut gear_off, mut te_off, mut rows) = (0f64, 0f64, 0);
    for row in result["rows"].as_array().unwrap() {
        let angle = number(&row["phi1"]);
        let k = angles
            .partition_point(|a| *a < angle)
            .clamp(2, angles.len() - 2);
        // Where pair 0 leads on its flanks: both heights within the teeth.
        let inside = |key: &str| (0.0..1.0).contains(&number(&row[key][1]));
        let leads = pairs[k - 2..k + 2].iter().all(|p| *p == 0.0);
        if !(leads && inside("pinion_face_height") && inside("gear_face_height")) {
            continue;
        }
        gear_off = gear_off.max((between(&angles, &gear, angle) - number(&row["phi2"])).abs());
        // The case counts te against the push and from its own reference.
        let expected = -number(&row["te_arcsec"]);
        te_off = te_off.max((between(&angles, &te, angle) - expected).abs());
        rows += 1;
    }
    assert!(rows > 8, "{rows}");
    within("φ₂, rad", gear_off, 1e-11);
    within("transmission error, arcsec", te_off, 1e-6);
    let edges = reference("c31_te_with_edges_12_36");
    let mut worst = 0f64;
    for row in edges["rows"].as_array().unwrap() {
        let found = between(&angles, &te, number(&row[0]));
        worst = worst.max((-found - number(&row[1])).abs());
    }
    within("transmission error with tip edges, arcsec", worst, 0.01);
    // The case lists the largest of its 48 positions; extremes are sought between them.
    let peak = number(&tca["peak_to_peak_arcsec"]);
    let listed = number(&edges["peak_to_peak_arcsec"]);
    assert!(peak >= listed && peak < listed + 0.1, "{peak}");
}

/// Both ways of naming: the reciprocal ratio and the eccentric angle `S_r = 2 K sin(β_e/2)` give the same flank.
#[test]
fn exact_settings_by_both_names() {
    let plain = document(&["gear", NASA, "--json"]);
    let (_kept, path) = changed(
        "cradle_over_work = 0.9508646",
        &format!("work_over_cradle = {}", 1.0 / 0.9508646),
    );
    let ratio = document(&["gear", &path, "--json"]);
    let angle = 2.0 * (2.85995004691 / (2.0 * 4.0f64)).asin();
    let eccentric = format!("eccentric_angle = \"{angle} rad\"\nmachine_constant = \"4 in\"");
    let (_kept, path) = changed("radial_distance  = \"2.85995004691 in\"", &eccentric);
    let radial = document(&["gear", &path, "--json"]);
    let points = |found: &Value| -> Vec<f64> {
        let of = &flank(found, 1, "convex")["points_m"];
        of.as_array().unwrap().iter().flat_map(numbers).collect()
    };
    let (a, b, c) = (points(&plain), points(&ratio), points(&radial));
    let off = |x: &[f64]| {
        a.iter()
            .zip(x)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max)
    };
    within("flank by the other ratio, m", off(&b), 1e-15);
    within("flank by the eccentric angle, m", off(&c), 1e-15);
    let shown = number(&flank(&radial, 1, "convex")["settings"]["eccentric_angle_deg"]);
    within(
        "eccentric angle, deg",
        (shown - angle.to_degrees()).abs(),
        1e-12,
    );
}

/// A formate gear has the cutter's cone as its flank: every node keeps the blade angle to the cutter's axis.
#[test]
fn exact_formate_flank_is_the_cone() {
    let (_kept, path) = changed("cradle_over_work = 0.9508646", "process = \"formate\"");
    let found = document(&["gear", &path, "--json"]);
    let of = flank(&found, 1, "convex");
    let root = (71.5666666f64 - 3.8833333333).to_radians();
    // The machine's axis in the frame of the work.
    let axis = [-root.cos(), 0.0, root.sin()];
    let mut worst = 0f64;
    for normal in of["normals"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|n| !n.is_null())
    {
        let n = numbers(normal);
        let along: f64 = n.iter().zip(axis).map(|(a, b)| a * b).sum();
        worst = worst.max((along.abs() - 22f64.to_radians().sin()).abs());
    }
    within("sine of the blade angle in the normals", worst, 1e-12);
}

/// The mean normal thickness of the file is that of the tooth; the solid of both gears has every edge twice, once each way, and a positive
/// volume; the flank's points are on it.
#[test]
fn law_solids_are_watertight() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let [stl, csv] = ["pair.stl", "flanks.csv"].map(at);
    let done = geardyn(&["gear", NASA, "--flank", &stl, "--quiet"]);
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    let bytes = std::fs::read(&stl).unwrap();
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize;
    assert_eq!(bytes.len(), 84 + 50 * count);
    let corner = |triangle: usize, k: usize| -> [u32; 3] {
        let start = 84 + 50 * triangle + 12 + 12 * k;
        [0, 4, 8].map(|o| u32::from_le_bytes(bytes[start + o..start + o + 4].try_into().unwrap()))
    };
    let mut edges: HashMap<([u32; 3], [u32; 3]), i32> = HashMap::new();
    let mut volume = 0.0;
    for t in 0..count {
        let c = [0, 1, 2].map(|k| corner(t, k));
        for k in 0..3 {
            let (a, b) = (c[k], c[(k + 1) % 3]);
            assert_ne!(a, b, "triangle {t} has a side without length");
            *edges.entry((a, b)).or_default() += 1;
        }
        let [a, b, d] = c.map(|p| p.map(|x| f64::from(f32::from_bits(x))));
        volume += (a[0] * (b[1] * d[2] - b[2] * d[1])
            + a[1] * (b[2] * d[0] - b[0] * d[2])
            + a[2] * (b[0] * d[1] - b[1] * d[0]))
            / 6.0;
    }
    for ((a, b), n) in &edges {
        assert_eq!((*n, edges.get(&(*b, *a))), (1, Some(&1)));
    }
    assert!(volume > 1e5, "{volume} mm³");
    let done = geardyn(&["gear", NASA, "--flank", &csv, "--quiet"]);
    assert!(done.status.success());
    let table = std::fs::read_to_string(&csv).unwrap();
    assert!(
        table.starts_with("member,side,row,column,x [mm]"),
        "{}",
        &table[..60]
    );
    assert_eq!(table.lines().count(), 1 + 4 * 9 * 15);
    let geometry = &document(&["gear", NASA, "--json"])["geometry"];
    within(
        "mean normal thickness, mm",
        (number(&geometry["mean_normal_thickness_mm"][0]) - 5.92).abs(),
        1e-12,
    );
}

/// The V–H check: the file with the shifts it names touches at a quarter, at half and at three quarters of the gear's face at the ratio of
/// the tooth numbers, also where the file has no such contact, as on the coast side.
#[test]
fn law_vh_check() {
    let shifts = |side: &str| {
        let found = document(&["gear", NASA, "--vh", "--side", side, "--json"]);
        let all = found["vh"].as_array().unwrap().clone();
        assert_eq!(all.len(), 3);
        all.into_iter()
            .map(|shift| (side.to_string(), shift))
            .collect::<Vec<_>>()
    };
    for (side, shift) in ["drive", "coast"].into_iter().flat_map(shifts) {
        let [face, v, h] = ["face", "offset_mm", "pinion_axial_mm"].map(|key| number(&shift[key]));
        let text = format!(
            "assembly = {{ offset = \"{v} mm\", pinion_axial = \"{} mm\" }}",
            0.508 + h
        );
        let (_kept, path) = changed("assembly = { pinion_axial = \"0.02 in\" }", &text);
        let moved = document(&["gear", &path, "--side", &side, "--json"]);
        let reference = &moved["tca"]["reference"];
        // The coast flanks have the ratio at two places nearby, between the stations of the path: the answer is near both.
        let allowed = if side == "coast" {
            [1e-5, 0.02]
        } else {
            [1e-9, 1e-7]
        };
        let off = (number(&reference["ratio"]) + 1.0 / 3.0).abs();
        within("ratio", off, allowed[0]);
        let at = &reference["gear"];
        let off = (number(&at["face"]) - face).abs();
        within("share of the face", off, allowed[1]);
        if side == "drive" {
            let off = (number(&at["height"]) - 0.5).abs();
            within("share of the height", off, allowed[1]);
        }
    }
}

/// Backlash of the teeth in their places: the same from both sides; a tooth thinner by Δs adds the turn Δs/(r cos β) of the pinion; the pinion
/// 1 mm nearer the apex jams. A contact begins at the tip of the driven gear.
#[test]
fn law_backlash_of_places() {
    let at = |from: &str, to: &str, side: &str| {
        let (_kept, path) = changed(from, to);
        let found = document(&["gear", &path, "--side", side, "--json"]);
        let backlash = &found["least_backlash"];
        let begins = found["tca"]["stopped_by"][0]["by"]
            .as_str()
            .unwrap_or("")
            .to_string();
        let codes = found["warnings"].as_array().unwrap().iter();
        let jams = codes.into_iter().any(|w| w["code"] == "no-backlash");
        (
            number(&backlash["gear_angle_arcsec"]),
            number(&backlash["normal_mm"]),
            begins,
            jams,
        )
    };
    let same = "assembly = { pinion_axial = \"0.02 in\" }";
    let [drive, coast] = ["drive", "coast"].map(|side| at(same, same, side));
    within(
        "turn from both sides, arcsec",
        (drive.0 - coast.0).abs(),
        1e-6,
    );
    assert!(
        drive.2 == "tip of the gear" && coast.2 == "tip of the gear",
        "{drive:?} {coast:?}"
    );
    assert!(drive.1 > 0.0 && !drive.3);
    let thinner = at("\"5.92 mm\"", "\"5.82 mm\"", "drive");
    let geometry = &document(&["gear", NASA, "--json"]);
    let radius = 0.5 * number(&geometry["geometry"]["mean_pitch_diameter_mm"][0]);
    let spiral = number(&geometry["members"][0]["flanks"][0]["structure"]["spiral_angle_deg"]);
    let turn = 0.1 / (radius * spiral.to_radians().cos()) / 3.0;
    let turn = turn.to_degrees() * 3600.0;
    // The phase between both sides moves as well: by the transmission error at most.
    within(
        "turn of a thinner tooth, arcsec",
        (thinner.0 - drive.0 - turn).abs(),
        5.0,
    );
    let near = at(same, "assembly = { pinion_axial = \"-0.5 mm\" }", "drive");
    assert!(near.1 < 0.0 && near.3, "{near:?}");
}

/// Where the other flanks do not touch, a warning says that the least backlash is unknown; displaced straight flanks are left out.
#[test]
fn keeps_the_reason_of_a_missing_backlash() {
    let (_kept, path) = changed(
        "assembly = { pinion_axial = \"0.02 in\" }",
        "assembly = { pinion_axial = \"0.02 in\", offset = \"-1.2 mm\" }",
    );
    let found = document(&["gear", &path, "--json"]);
    assert!(found["least_backlash"].is_null());
    let warnings = found["warnings"].as_array().unwrap().iter();
    let words = |w: &Value| {
        w["message"]
            .as_str()
            .unwrap()
            .contains("backlash is unknown")
    };
    assert!(warnings.into_iter().any(words), "{}", found["warnings"]);
    let straight = std::fs::read_to_string("models/gears/straight_20_40.toml").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let text = format!("assembly = {{ offset = \"0.5 mm\" }}\n{straight}");
    let path = put(folder.path(), "straight.toml", &text);
    let (_, _, notes) = said(&["gear", path.to_str().unwrap()]);
    assert!(notes.contains("left out assembly"), "{notes}");
}

/// Backlash of the shipped hypoid design: j_en of its blank carried to the mean point, less what its rounded thicknesses take.
/// Source: ISO 23509:2016, `j_mn = j_en R_m2 cos β_m2/(R_e2 cos β_e2)`.
#[test]
fn ref_backlash_of_a_design() {
    let found = document(&["gear", "models/gears/hypoid_13_42.toml", "--json"]);
    let of = |key: &str, k: usize| match &found["geometry"][key] {
        Value::Array(both) => number(&both[k]),
        pair => number(pair),
    };
    let cosine = |key: &str, k: usize| of(key, k).to_radians().cos();
    let at_mean = 0.1266 * of("mean_cone_distance_mm", 1) * cosine("mean_spiral_angle_deg", 1)
        / (of("outer_cone_distance_mm", 1) * cosine("outer_spiral_angle_deg", 1));
    let thicker = [0, 1]
        .map(|k| of("mean_normal_thickness_mm", k) - of("design_mean_normal_thickness_mm", k));
    let taken = (thicker[0] + thicker[1]) * cosine("generated_pressure_angle_drive_deg", 0);
    let apart = of("mean_normal_backlash_mm", 0) - (at_mean - taken);
    within("backlash of the design, mm", apart.abs(), 2e-4);
}

/// The coast flanks touch as well, with the pinion moved as for the drive flanks; te rises above its reference in the middle of the mesh.
#[test]
fn law_coast_flanks() {
    let found = document(&["gear", NASA, "--side", "coast", "--json"]);
    let tca = &found["tca"];
    let peak = number(&tca["peak_to_peak_arcsec"]);
    assert!((1.0..500.0).contains(&peak), "{peak}");
    for member in ["pinion", "gear"] {
        let face = number(&tca["reference"][member]["face"]);
        assert!((0.3..0.7).contains(&face), "{member} {face}");
    }
}

/// A thicker tooth than the blank carries is pointed, and the place is named; a pinion whose blades reach too deep is undercut.
#[test]
fn law_limits_are_located() {
    let (_kept, path) = changed("\"5.92 mm\"", "\"5 mm\"");
    let found = document(&["gear", &path, "--json"]);
    let limit = &found["limits"][0];
    assert_eq!(
        (&limit["kind"], &limit["member"]),
        (&"pointed".into(), &"pinion".into())
    );
    let depth = number(&limit["nearest"]["depth_less_mm"]);
    assert!((0.2..2.0).contains(&depth), "{depth}");
    // A blank that reaches 3.5 mm deeper, and a cutter that follows it.
    let text = std::fs::read_to_string(NASA).unwrap();
    let roots = ["\"16.86666664 deg\", mean", "\"14 deg\", mean"];
    let bases = ["\"0.011672732029611077 in\"", "\"-0.1 in\""];
    assert!(text.contains(roots[0]) && text.contains(bases[0]));
    let deeper = text.replacen(roots[0], roots[1], 1);
    let deeper = deeper.replacen(bases[0], bases[1], 1);
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "deep.toml", &deeper);
    let path = path.to_str().unwrap();
    let found = document(&["gear", path, "--json"]);
    let kinds: Vec<&str> = (found["limits"].as_array().unwrap().iter())
        .filter(|l| l["member"] == "pinion")
        .map(|l| l["kind"].as_str().unwrap())
        .collect();
    assert!(kinds.contains(&"undercut"), "{kinds:?}");
}

/// Face hobbing, equal hands, both ratios, a missing setting, a ratio of formate work, crossing cones, a load: each refused by name.
#[test]
fn refuses_wrong_bevel_files() {
    let of = |from: &str, to: &str| {
        let (_kept, path) = changed(from, to);
        refusal(&["gear", &path]).1
    };
    let cases = [
        (
            "teeth = 36",
            "teeth = 36\nprocess = \"face-hobbed\"",
            "face hobbing is not supported",
        ),
        ("hand  = \"right\"", "hand = \"left\"", "same hand"),
        (
            "cradle_over_work = 0.9508646",
            "cradle_over_work = 0.95\nwork_over_cradle = 1.05",
            "exclude each other",
        ),
        ("cradle_over_work = 0.9508646", "", "no `cradle_over_work`"),
        (
            "cradle_over_work = 0.9508646",
            "cradle_over_work = 0.95\nprocess = \"formate\"",
            "has no roll",
        ),
        (
            "face_angle = \"73.1333332 deg\"",
            "face_angle = \"60 deg\"",
            "no depth at the toe",
        ),
        (
            "cradle_angle     = \"59.2342023 deg\"",
            "cradle_angle = \"180 deg\"",
            "does not reach",
        ),
        (
            "[pinion]",
            "[mesh]\ntorque = \"10 N·m\"\nstations = 4\n[pinion]",
            "stations",
        ),
        (
            "teeth = 36",
            "teeth = 36\nmean_normal_thickness = \"5 mm\"",
            "cut at one setting",
        ),
        (
            "cradle_over_work = 0.9508646",
            "cradle_over_work = 1e9",
            "between 1e-4 and 1e4",
        ),
    ];
    for (from, to, words) in cases {
        let message = of(from, to);
        assert!(message.contains(words), "{words}: {message}");
    }
    let message = of(
        "blade_angle = \"18.045669752 deg\"",
        "blade_angle = \"90 deg\"",
    );
    assert!(
        message.contains("below 68°") && !message.contains("has no"),
        "{message}"
    );
    let blade = "blade_angle = \"18.045669752 deg\"";
    for (keys, words) in [
        ("profile_radius = \"400 mm\"", "no `profile_height`"),
        ("toprem_depth = \"2 mm\"", "no `toprem_angle`"),
        (
            "profile_radius = \"0 mm\", profile_height = \"3 mm\"",
            "must not be 0",
        ),
        (
            "profile_radius = \"-8 mm\", profile_height = \"3 mm\"",
            "`profile_radius` -8.000 mm turns the blade",
        ),
        (
            "toprem_angle = \"2 deg\", toprem_depth = \"20 mm\"",
            "exceeds the tooth depth",
        ),
        (
            "toprem_angle = \"19 deg\", toprem_depth = \"2 mm\"",
            "not below the angle of the blade at `toprem_depth`, 18.046°",
        ),
        (
            "toprem_angle = \"2 deg\", toprem_depth = \"0.5 mm\", edge_radius = \"1 mm\"",
            "the edge radius ends 0.724 mm above the tip plane, not below the end of the Toprem at 0.500 mm",
        ),
    ] {
        let message = of(blade, &format!("{blade}, {keys}"));
        assert!(message.contains(words), "{words}: {message}");
    }
    for (flags, words) in [
        (["--slices", "9"], "--slices has no effect here"),
        (
            ["--stations", "40"],
            "--stations has no effect without a torque",
        ),
        (["--torque", "3000"], "N·m"),
        (["--torques", "400:100:4"], "not a range of torques"),
    ] {
        let (_, message) = refusal(&["gear", NASA, flags[0], flags[1]]);
        assert!(message.contains(words), "{words}: {message}");
    }
    let (_, message) = refusal(&["gear", "models/gears/fzg_c.toml", "--vh"]);
    assert!(message.contains("--vh has no effect here"), "{message}");
}

/// `check` and `plan` take the file; a flank that is not described leaves the contact out; tables and figures are written.
#[test]
fn keeps_outputs_of_a_bevel_file() {
    let (code, text, _) = said(&["check", NASA]);
    assert!(
        code == Some(0) && text.contains("bevel gears of 12 and 36 teeth"),
        "{text}"
    );
    let (code, text, _) = said(&["plan", NASA]);
    assert!(
        code == Some(0) && text.contains("60 positions in a pitch"),
        "{text}"
    );
    let text = std::fs::read_to_string(NASA).unwrap();
    let without: String = (text
        .lines()
        .filter(|l| !l.starts_with("convex  = { cutter")))
    .map(|l| format!("{l}\n"))
    .collect();
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "one.toml", &without);
    let found = document(&["gear", path.to_str().unwrap(), "--json"]);
    assert!(found["tca"].is_null() && found["ease_off"].is_null());
    let at = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let [svg, csv] = ["b.svg", "b.csv"].map(at);
    let done = geardyn(&["gear", NASA, "--svg", &svg, "--csv", &csv, "--quiet"]);
    assert!(done.status.success());
    for name in ["b.svg", "b-te.svg", "b-pattern.svg", "b-ease-off.svg"] {
        let plot = std::fs::read_to_string(at(name)).unwrap();
        assert!(plot.contains("Spiral bevel pair 12/36"), "{name}");
    }
    let table = std::fs::read_to_string(csv).unwrap();
    assert!(table.starts_with("pinion_angle [rad],gear_angle [rad],te [arcsec],pair,x [mm]"));
    assert_eq!(table.lines().count(), 1 + 181);
}

/// A machine whose pair names the file: the order of the mesh at the gear is the Fourier amplitude of its transmission error; keys that the
/// file determines are refused with both places, `k` is the model's.
#[test]
fn law_pair_of_a_machine() {
    let folder = tempfile::tempdir().unwrap();
    let text = std::fs::read_to_string(NASA).unwrap();
    put(folder.path(), "bevel.toml", &text);
    let model = |keys: &str| {
        format!(
            "inertia = [{{ name = \"pinion\", J = \"0.01 kg·m²\" }}, {{ name = \"gear\", J = \"0.2 kg·m²\" }}]\n\
             [[gear_pair]]\nname = \"bevel\"\nbetween = [\"pinion\", \"gear\"]\ngear = \"bevel.toml\"\n{keys}\n\
             [speed]\npinion = \"1000 rpm\"\n"
        )
    };
    let path = put(folder.path(), "machine.toml", &model("k = \"300 N/µm\""));
    let path = path.to_str().unwrap();
    let (code, plan, notes) = said(&["plan", path]);
    assert!(
        code == Some(0) && plan.contains("µm peak to peak; stiffness of the model"),
        "{plan}{notes}"
    );
    let orders = document(&["te", path, "--output", "gear", "--json"]);
    let found = document(&["gear", NASA, "--json"]);
    let te: Vec<f64> = (found["tca"]["points"].as_array().unwrap().iter())
        .map(|p| number(&p["te_arcsec"]))
        .collect();
    // The positions of one pitch, from the reference in the middle on.
    let one = &te[90..150];
    let amplitude = |harmonic: usize| {
        let sum = one.iter().enumerate().fold([0.0, 0.0], |[c, s], (i, e)| {
            let angle = std::f64::consts::TAU * (harmonic * i) as f64 / 60.0;
            [c + e * angle.cos(), s + e * angle.sin()]
        });
        2.0 * f64::hypot(sum[0], sum[1]) / 60.0
    };
    for harmonic in 1..=3 {
        let order = (36 * harmonic) as f64;
        let rows = orders["orders"].as_array().unwrap();
        let row = rows
            .iter()
            .find(|r| number(&r["order_value"]) == order)
            .unwrap();
        let kinematic = number(&row["kinematic_arcsec"]);
        let line = amplitude(harmonic);
        within(
            &format!("order {order}, relative"),
            (kinematic / line - 1.0).abs(),
            1e-6,
        );
    }
    let path = put(
        folder.path(),
        "twice.toml",
        &model("teeth = [12, 36]\ncone_angles = [\"18 deg\", \"72 deg\"]"),
    );
    let (_, message) = refusal(&["check", path.to_str().unwrap()]);
    assert!(
        message.contains("is determined by the gear file") && message.contains("bevel.toml"),
        "{message}"
    );
}

/// Some hundred mutations of the file: an answer without NaN or a refusal, never a panic.
#[test]
fn survives_mutated_bevel_files() {
    let text = std::fs::read_to_string(NASA).unwrap();
    fastrand::seed(83);
    let folder = tempfile::tempdir().unwrap();
    for _ in 0..150 {
        let mutated = with_other_digits(&text);
        let path = put(folder.path(), "pair.toml", &mutated);
        let (code, text, notes) = said(&["gear", path.to_str().unwrap(), "--vh"]);
        assert!(
            matches!(code, Some(0 | 2 | 3)),
            "{code:?} {notes}\n{mutated}"
        );
        let bad = ["NaN", " inf", "panicked"]
            .iter()
            .any(|word| text.contains(word) || notes.contains(word));
        assert!(!bad, "{text}{notes}\n{mutated}");
    }
}

/// Blanks by ISO 23509 alone, both methods; the pinion's blank follows from the gear's, and wrong inputs are refused by name.
/// Source: ISO 23509:2016, Annex F, samples 1 and 2.
#[test]
fn ref_blanks_alone() {
    let folder = tempfile::tempdir().unwrap();
    let file = |offset: &str, teeth: [u32; 2], blank: &str| {
        let text = format!(
            "pair = {{ kind = \"bevel\", offset = \"{offset}\" }}\npinion = {{ teeth = {}, hand = \"left\" }}\n\
             gear = {{ teeth = {}, blank = {{ standard = \"ISO 23509\", {blank} }} }}\n",
            teeth[0], teeth[1]
        );
        let path = put(folder.path(), "blank.toml", &text);
        path.to_str().unwrap().to_string()
    };
    let first = "method = 0, outer_pitch_diameter = \"176.893 mm\", face_width = \"25.4 mm\", spiral_angle = \"35 deg\", cutter_radius = \"114.3 mm\", addendum_factor = 0.24737, thickness_factor = 0.0915, backlash = \"0.127 mm\", addendum_angle = \"2.1342 deg\", dedendum_angle = \"6.4934 deg\"";
    let second = "method = 1, outer_pitch_diameter = \"170 mm\", face_width = \"30 mm\", pinion_spiral_angle = \"50 deg\", cutter_radius = \"63.5 mm\", limit_influence = 1, addendum_factor = 0.35, thickness_factor = 0.1, addendum_angle = \"1 deg\", dedendum_angle = \"4 deg\"";
    let found = document(&["gear", &file("0 mm", [14, 39], first), "--json"]);
    let value = |found: &Value, key: &str, k: usize| number(&found["geometry"][key][k]);
    for (key, k, printed) in [
        ("face_angle_deg", 0, 26.24),
        ("root_angle_deg", 0, 17.613),
        ("crown_to_crossing_point_mm", 1, 29.808),
        ("outer_tip_diameter_mm", 1, 178.288),
        ("mean_addendum_mm", 0, 4.836),
    ] {
        within(key, (value(&found, key, k) - printed).abs(), 0.003);
    }
    assert!(found["tca"].is_null() && found["members"][0]["flanks"].as_array().unwrap().is_empty());
    let found = document(&["gear", &file("15 mm", [13, 42], second), "--json"]);
    for (key, k, printed) in [
        ("mean_spiral_angle_deg", 1, 38.609),
        ("face_width_mm", 0, 31.91),
        ("pitch_apex_beyond_crossing_point_mm", 0, -1.225),
        ("outer_tip_diameter_mm", 0, 73.528),
    ] {
        within(key, (value(&found, key, k) - printed).abs(), 0.01);
    }
    let of = |offset: &str, blank: &str| refusal(&["gear", &file(offset, [14, 39], blank)]).1;
    for (offset, blank, words) in [
        ("15 mm", first.to_string(), "without offset"),
        ("0 mm", second.to_string(), "needs an offset"),
        (
            "0 mm",
            first.replace("method = 0", "method = 3"),
            "and an offset",
        ),
        (
            "15 mm",
            first.replace("method = 0", "method = 2"),
            "blade groups",
        ),
        (
            "0 mm",
            first.replace("176.893 mm", "17.6 mm"),
            "reaches its pitch apex",
        ),
        ("0 mm", first.replace("0.24737", "2.5"), "no thickness"),
    ] {
        let message = of(offset, &blank);
        assert!(message.contains(words), "{words}: {message}");
    }
}

const STRAIGHT: &str = "models/gears/straight_20_40.toml";

/// Blanks of a hypoid pair alone: its theory at the pitch point.
/// Source: ISO 23509:2016, Annex F, sample 2 (limit pressure angle, offset angle), data/reference/gear/c06_iso23509_s2_hypoid_13_42_gleason.json.
#[test]
fn ref_theory_of_a_hypoid_blank() {
    let folder = tempfile::tempdir().unwrap();
    let text = r#"
pair = { kind = "bevel", shaft_angle = "90 deg", offset = "15 mm" }
pinion = { teeth = 13, hand = "left" }
[gear]
teeth = 42
blank = { standard = "ISO 23509", method = 1, pinion_spiral_angle = "50 deg", outer_pitch_diameter = "170 mm", face_width = "30 mm", cutter_radius = "63.5 mm", addendum_angle = "1 deg", dedendum_angle = "4 deg", addendum_factor = 0.35, limit_influence = 1, thickness_factor = 0.1 }
"#;
    let read = |text: &str| {
        let path = put(folder.path(), "blank.toml", text);
        document(&["gear", path.to_str().unwrap(), "--json"])["geometry"].clone()
    };
    let found = read(text);
    let get = |key: &str| number(&found[key]);
    within(
        "limit pressure angle, deg",
        (get("limit_pressure_angle_deg") + 2.253).abs(),
        1e-3,
    );
    within(
        "offset angle in the pitch plane, deg",
        (get("offset_angle_in_the_pitch_plane_deg") - 11.39).abs(),
        1e-3,
    );
    let curvature = get("limit_curvature_of_the_tooth_line_per_mm");
    within("limit radius, mm", (1.0 / curvature - 63.5).abs(), 1e-6);
    for side in ["drive", "coast"] {
        assert!(get(&format!("contact_line_to_tooth_line_{side}_deg")).abs() < 60.0);
        assert!(
            get(&format!(
                "induced_curvature_in_the_normal_section_{side}_per_mm"
            )) < 0.0
        );
    }
    assert_eq!(
        found["throat_radius_of_the_axode_mm"]
            .as_array()
            .unwrap()
            .len(),
        2
    );
    // A negative offset: the wheel has the larger spiral angle.
    let opposite = read(
        &text
            .replace("\"15 mm\"", "\"-15 mm\"")
            .replace("63.5 mm", "160 mm"),
    );
    let spiral = numbers(&opposite["spiral_angle_at_the_pitch_point_deg"]);
    assert!(spiral[0] < spiral[1], "{spiral:?}");
}

/// A straight pair is answered without settings: whole teeth, no contact since the flanks are conjugate; both profiles.
#[test]
fn law_straight_pairs_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let octoid = std::fs::read_to_string(STRAIGHT).unwrap();
    for text in [
        octoid.clone(),
        octoid.replace("octoid", "spherical-involute"),
    ] {
        let path = put(folder.path(), "straight.toml", &text);
        let path = path.to_str().unwrap();
        let found = document(&["gear", path, "--json"]);
        assert!(found["tca"].is_null());
        assert_eq!(found["limits"].as_array().unwrap().len(), 0);
        let of = flank(&found, 0, "concave");
        let structure = &of["structure"];
        assert!((number(&structure["pressure_angle_deg"]).abs() - 20.0).abs() < 1e-5);
        assert!(number(&structure["spiral_angle_deg"]).abs() < 1e-9);
        let distance = numbers(&found["geometry"]["outer_cone_distance_mm"]);
        assert!((distance[0] - 67.08204).abs() < 1e-5);
        let tip = numbers(&found["geometry"]["outer_tip_diameter_mm"]);
        assert!(
            (tip[0] - 67.2180).abs() < 1e-3 && (tip[1] - 121.7575).abs() < 1e-3,
            "{tip:?}"
        );
        let stl = folder.path().join("gears.stl");
        let output = geardyn(&["gear", path, "--flank", stl.to_str().unwrap(), "--quiet"]);
        assert_eq!(output.status.code(), Some(0));
        assert!(std::fs::metadata(&stl).unwrap().len() > 10_000);
    }
    let path = put(
        folder.path(),
        "mixed.toml",
        &octoid.replacen("\"octoid\"", "\"spherical-involute\"", 1),
    );
    let (_, message) = refusal(&["gear", path.to_str().unwrap()]);
    assert!(message.contains("different profiles"), "{message}");
}

/// Without settings a flank is cut from its spiral angle: the spiral angle of the answer is the stated one within 2°.
#[test]
fn law_rough_settings_of_the_file() {
    let text = r#"
pair = { kind = "bevel" }
[pinion]
teeth = 14
hand = "left"
blank = { pitch_angle = "19.747 deg", face_angle = "22.3 deg", root_angle = "18.1 deg", mean_cone_distance = "81.3 mm", face_width = "25.4 mm" }
spiral_angle = "35 deg"
concave = { cutter = { point_radius = "115.5 mm", blade_angle = "20 deg" } }
convex = { cutter = { point_radius = "112.8 mm", blade_angle = "20 deg" } }
[gear]
teeth = 39
blank = { pitch_angle = "70.253 deg", face_angle = "71.9 deg", root_angle = "67.7 deg", mean_cone_distance = "81.3 mm", face_width = "25.4 mm" }
spiral_angle = "35 deg"
cutter = { blade_angle = "20 deg" }
concave = { cutter = { point_radius = "115.4 mm" } }
convex = { cutter = { point_radius = "113.2 mm" } }
"#;
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "rough.toml", text);
    let found = document(&["gear", path.to_str().unwrap(), "--json"]);
    for member in 0..2 {
        for side in ["concave", "convex"] {
            let of = flank(&found, member, side);
            let spiral = number(&of["structure"]["spiral_angle_deg"]).abs();
            assert!((spiral - 35.0).abs() < 2.0, "{member} {side} {spiral}");
            assert!(number(&of["settings"]["radial_distance_mm"]) > 50.0);
        }
    }
    let path = put(
        folder.path(),
        "both.toml",
        &text.replacen("spiral_angle", "cradle_angle = \"60 deg\"\nspiral_angle", 1),
    );
    let (_, message) = refusal(&["gear", path.to_str().unwrap()]);
    assert!(message.contains("`spiral_angle` and settings"), "{message}");
}

/// The shipped hypoid: each flank has its stated angles at the mean point, the flanks of both sides touch there, and the loaded contact at
/// rest agrees with the path of contact on the drive side, where no edge touches.
#[test]
fn law_hypoid_of_the_file() {
    const HYPOID: &str = "models/gears/hypoid_13_42.toml";
    for side in ["drive", "coast"] {
        let found = document(&["gear", HYPOID, "--side", side, "--torque", "50", "--json"]);
        for (member, flank_name, pressure, spiral) in [
            (0, "concave", 17.7465, 50.0),
            (0, "convex", 22.2535, 50.0),
            (1, "concave", 22.2535, 38.6104),
            (1, "convex", 17.7465, 38.6104),
        ] {
            let of = &flank(&found, member, flank_name)["structure"];
            let off = |key: &str, value: f64| (number(&of[key]).abs() - value).abs();
            assert!(off("pressure_angle_deg", pressure) < 1e-9, "{of}");
            assert!(off("spiral_angle_deg", spiral) < 1e-9, "{of}");
        }
        let codes = found["warnings"].to_string();
        assert!(
            !codes.contains("no-reference") && !codes.contains("rigid-teeth"),
            "{codes}"
        );
        if side == "drive" {
            assert!(!codes.contains("overlap"), "{codes}");
            let path = number(&found["tca"]["peak_to_peak_arcsec"]);
            let ridges = number(&found["mesh"]["unloaded_peak_to_peak_arcsec"]);
            assert!((ridges / path - 1.0).abs() < 0.03, "{ridges} {path}");
        }
    }
}

/// A generating cutter cuts like a crown gear, which no hollow gear of a pitch angle above 90° takes in: both its flanks are cut away, the
/// warning says so, and no contact is computed.
#[test]
fn keeps_the_reason_of_flanks_cut_away() {
    let text = r#"
pair = { kind = "bevel", shaft_angle = "130 deg" }
[pinion]
teeth = 12
hand = "left"
blank = { pitch_angle = "20 deg", face_angle = "23 deg", root_angle = "18 deg", mean_cone_distance = "100 mm", face_width = "25 mm" }
spiral_angle = "30 deg"
concave = { cutter = { point_radius = "101 mm", blade_angle = "20 deg" } }
[gear]
teeth = 33
blank = { pitch_angle = "110 deg", face_angle = "112 deg", root_angle = "107 deg", mean_cone_distance = "100 mm", face_width = "25 mm" }
spiral_angle = "30 deg"
convex = { cutter = { point_radius = "99 mm", blade_angle = "20 deg" } }
"#;
    let folder = tempfile::tempdir().unwrap();
    let path = put(folder.path(), "hollow.toml", text);
    let found = document(&["gear", path.to_str().unwrap(), "--json"]);
    let limits = found["limits"].as_array().unwrap();
    let hollow = limits.iter().find(|l| l["member"] == "gear").unwrap();
    assert_eq!(hollow["kind"], "cut-away");
    let warnings = found["warnings"].as_array().unwrap();
    let undercut = warnings.iter().find(|w| w["code"] == "undercut").unwrap();
    let message = undercut["message"].as_str().unwrap();
    assert!(
        message.contains("the convex flank of the gear is completely undercut"),
        "{message}"
    );
    assert!(found["contact"].is_null());
}

/// Torques of change rise from zero, at every position with a strip that begins; the moment in the root of the pinion is that of its share;
/// the pattern lies on the face; stated departures of the axes have their table and picture.
#[test]
fn keeps_changes_root_moments_and_stability() {
    let load = "[mesh]\ntorque = \"80 N·m\"\npositions = 4\nstations = 12\nchanges = true\n\n[tolerance]\npinion_axial = \"50 µm\"\n\n[housing]\ntorque = \"100 N·m\"\noffset = \"20 µm\"\n\n[gear]\n";
    let (folder, path) = changed("[gear]\n", load);
    let picture = folder.path().join("pair.svg");
    let found = document(&["gear", &path, "--json", "--svg", picture.to_str().unwrap()]);
    let mesh = &found["mesh"];
    for k in 0..4 {
        let path = mesh["changes"][k].as_array().unwrap();
        let torques: Vec<f64> = path.iter().map(|c| number(&c["torque_nm"])).collect();
        assert!(torques.is_sorted() && torques[0] > 0.0 && torques[torques.len() - 1] <= 80.0);
        assert!(path.iter().any(|c| c["begins"] == true));
        let moments = mesh["root_moment_nm"][0][k].as_array().unwrap();
        let carried: f64 = moments
            .iter()
            .filter(|m| !m.is_null())
            .map(|m| number(&m[0]))
            .sum();
        // Some 1.4 to 4 kN normal force at some 2 to 9 mm above the root.
        assert!((2.0..40.0).contains(&carried), "{carried} N·m");
    }
    let face = numbers(&mesh["lengthwise"][0]["face"]);
    assert!(face.is_sorted() && face[0] > 0.0 && face[face.len() - 1] < 1.0);
    let axes: Vec<&str> = (mesh["stability"].as_array().unwrap().iter())
        .map(|case| case["axes"].as_str().unwrap())
        .collect();
    assert_eq!(axes, ["as in the file", "P +50 µm", "P −50 µm", "housing"]);
    within(
        "offset under the housing",
        (number(&mesh["stability"][3]["offset_m"]) - 16e-6).abs(),
        1e-12,
    );
    for suffix in ["-lengthwise", "-stability"] {
        let drawn = std::fs::read_to_string(folder.path().join(format!("pair{suffix}.svg")));
        assert!(drawn.unwrap().contains("12/36"), "{suffix}");
    }
}

/// Error against run time without a load: lines between positions lose a quarter of their error at least where positions double, and
/// ridges, which match no normals, agree within the crests between their stations.
#[test]
fn law_accuracy_of_the_unloaded_contact() {
    let found = document(&["accuracy", NASA, "--json"]);
    assert!(found["stiffness"].is_null());
    let rows = found["te"]["runs"].as_array().unwrap();
    let error = |method: &str, positions: i64, stations: Option<i64>| {
        let row = (rows.iter()).find(|r| {
            r["method"] == method
                && r["positions"] == positions
                && r["stations"].as_i64() == stations
        });
        number(&row.unwrap_or_else(|| panic!("{rows:?}"))["error"])
    };
    let path = [15, 30, 60, 120, 240].map(|n| error("path of contact", n, None));
    assert!(path.windows(2).all(|p| p[1] < 0.75 * p[0]), "{path:?}");
    let ridges = error("ridges of least gap", 240, Some(65));
    assert!(path[4] < 1e-3 && ridges < 1e-2, "{path:?} {ridges}");
    assert!(error("ridges of least gap", 240, Some(17)) > ridges);
}

/// Loaded contact of the shipped pair: document, table, plan, figures; shares sum to one, pressure and deflection grow with the torque.
#[test]
fn keeps_loaded_contact_of_a_bevel_file() {
    let found = document(&[
        "gear",
        NASA,
        "--torques",
        "20:80:2",
        "--positions",
        "8",
        "--stations",
        "16",
        "--json",
    ]);
    let mesh = &found["mesh"];
    assert_eq!(numbers(&mesh["torques_nm"]), [20.0, 80.0]);
    let [light, heavy] = [0, 1].map(|k| numbers(&mesh["te_arcsec"][k]));
    for k in 0..8 {
        assert!(heavy[k] < light[k], "te at position {k}");
        let shares = numbers(&mesh["shares"][1][k]);
        within(
            "sum of shares",
            (shares.iter().sum::<f64>() - 1.0).abs(),
            1e-9,
        );
        let [secant, tangent] = ["stiffness_secant_n_per_m", "stiffness_tangent_n_per_m"]
            .map(|key| number(&mesh[key][1][k]));
        assert!(tangent > secant, "{tangent} {secant}");
    }
    // Of two torques the first is left out and found by the power of the second: its exponent is secant over tangent stiffness.
    let unloaded = numbers(&mesh["unloaded_te_arcsec"]);
    let off = (0..8).map(|k| {
        let [secant, tangent] = ["stiffness_secant_n_per_m", "stiffness_tangent_n_per_m"]
            .map(|key| number(&mesh[key][1][k]));
        let power = 0.25f64.powf(secant / tangent);
        (power * (unloaded[k] - heavy[k]) - (unloaded[k] - light[k])).abs()
    });
    let stated = number(&mesh["between_torques"]["te_arcsec"]);
    let apart = off.fold(0.0, f64::max) / stated - 1.0;
    within("error of te between two torques", apart.abs(), 1e-9);
    let (code, text, _) = said(&[
        "gear",
        NASA,
        "--torque",
        "50",
        "--positions",
        "8",
        "--stations",
        "16",
    ]);
    assert!(
        code == Some(0) && text.contains("effective contact ratio"),
        "{text}"
    );
    assert!(text.contains("left out: shafts"), "{text}");
    let (_folder, path) = changed("mean_normal_thickness = \"5.92 mm\"\n", "");
    let (code, text, said) = said(&[
        "gear",
        &path,
        "--torque",
        "50",
        "--positions",
        "8",
        "--stations",
        "16",
    ]);
    assert!(code == Some(0) && text.contains("rigid teeth"), "{text}");
    assert!(said.contains("the teeth do not bend"), "{said}");
    let (_folder, path) = changed(
        "[gear]\n",
        "[mesh]\ntorque = \"40 N·m\"\nstations = 24\n\n[gear]\n",
    );
    let (code, text, _) = crate::support::command::said(&["plan", &path]);
    assert!(
        code == Some(0) && text.contains("1 torque × 60 positions × 24 stations"),
        "{text}"
    );
}

/// The stated error of e(φ, T) from the stations holds against half as many stations again, and is no more than four times it.
#[test]
fn law_error_of_stations() {
    let mesh = |stations: &str| {
        document(&[
            "gear",
            "models/gears/bevel_12_36.toml",
            "--torques",
            "100:300:2",
            "--positions",
            "30",
            "--stations",
            stations,
            "--json",
        ])["mesh"]
            .clone()
    };
    let (found, finer) = (mesh("32"), mesh("48"));
    for (k, stated) in numbers(&found["te_error_arcsec"]).iter().enumerate() {
        let te = |mesh: &Value| numbers(&mesh["te_arcsec"][k]);
        let apart = te(&found)
            .iter()
            .zip(te(&finer))
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f64::max);
        assert!(
            apart <= *stated && *stated <= 4.0 * apart,
            "{apart} {stated}"
        );
    }
}
