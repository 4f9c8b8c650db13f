//! Pairs from a blank by ISO 23509 to contact and correction: rough settings of both hands, hollow gears, small pinions, teeth that do not fit.

use serde_json::Value;

use crate::support::command::{document, put};

/// A pair of spiral angles of 35° and pressure angles of 20° on blanks of method 0.
struct Design {
    shaft_angle: f64,
    teeth: [u32; 2],
    hand: &'static str,
    gear: &'static str,
    spiral_angle: f64,
    thickness: f64,
}

const DESIGN: Design = Design {
    shaft_angle: 90.0,
    teeth: [14, 39],
    hand: "left",
    gear: "",
    spiral_angle: 35.0,
    thickness: 3.51,
};

impl Design {
    fn text(&self) -> String {
        let Design {
            shaft_angle,
            teeth: [z1, z2],
            hand,
            gear,
            spiral_angle,
            thickness,
        } = self;
        let angles = match *shaft_angle == 90.0 {
            true => "addendum_angle = \"2.1342 deg\", dedendum_angle = \"6.4934 deg\"",
            false => "addendum_angle = \"1.5 deg\", dedendum_angle = \"3 deg\"",
        };
        let flanks = |outer: f64, inner: f64| {
            let cutter = |radius: f64| {
                format!(
                    "{{ cutter = {{ point_radius = \"{radius} mm\", blade_angle = \"20 deg\", edge_radius = \"0.5 mm\" }} }}"
                )
            };
            format!("concave = {}\nconvex = {}\n", cutter(outer), cutter(inner))
        };
        format!(
            "pair = {{ kind = \"bevel\", shaft_angle = \"{shaft_angle} deg\" }}\n\
             [pinion]\nteeth = {z1}\nhand = \"{hand}\"\nspiral_angle = \"35 deg\"\nmean_normal_thickness = \"6.46 mm\"\n{}\
             [gear]\nteeth = {z2}\n{gear}spiral_angle = \"{spiral_angle} deg\"\nmean_normal_thickness = \"{thickness} mm\"\n\
             blank = {{ standard = \"ISO 23509\", method = 0, spiral_angle = \"35 deg\", outer_pitch_diameter = \"176.893 mm\", face_width = \"25.4 mm\", cutter_radius = \"114.3 mm\", pressure_angle = \"20 deg\", {angles}, addendum_factor = 0.24737, thickness_factor = 0.0915, limit_influence = 0, backlash = \"0.127 mm\" }}\n{}",
            flanks(115.8, 112.8),
            flanks(115.3, 113.3),
        )
    }

    fn answer(&self, command: &[&str]) -> Value {
        let folder = tempfile::tempdir().unwrap();
        let path = put(folder.path(), "pair.toml", &self.text());
        let [command, flags @ ..] = command else {
            panic!("no command");
        };
        let words = command.split(' ').chain([path.to_str().unwrap()]);
        let all: Vec<&str> = words
            .chain(flags.iter().copied())
            .chain(["--json"])
            .collect();
        document(&all)
    }
}

fn codes(found: &Value) -> Vec<&str> {
    let warnings = found["warnings"].as_array().unwrap();
    warnings
        .iter()
        .map(|w| w["code"].as_str().unwrap())
        .collect()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value}"))
}

/// The cutter passes the mean point of a nearly plane gear twice: the flank is where its blade reaches lowest, with the stated angles.
#[test]
fn exact_formate_flanks_of_flat_gears() {
    for shaft_angle in [130.0, 138.0, 140.0] {
        let design = Design {
            shaft_angle,
            teeth: [20, 31],
            gear: "process = \"formate\"\n",
            ..DESIGN
        };
        let found = design.answer(&["gear"]);
        for flank in found["members"][1]["flanks"].as_array().unwrap() {
            let of = &flank["structure"];
            for (key, stated) in [("pressure_angle_deg", 20.0), ("spiral_angle_deg", 35.0)] {
                let off = number(&of[key]).abs() - stated;
                assert!(off.abs() < 1e-9, "{shaft_angle} {key}: {of}");
            }
        }
        assert!(!codes(&found).contains(&"no-contact"), "{shaft_angle}");
    }
}

/// The mirror image of a pair touches at the mirrored place, also where two places have the ratio of the tooth numbers.
#[test]
fn exact_mirrored_hypoid() {
    let text = "pair = { kind = \"bevel\", shaft_angle = \"90 deg\", offset = \"15 mm\" }\n\
        [pinion]\nteeth = 13\nhand = \"left\"\nspiral_angle = \"50 deg\"\n\
        concave = { cutter = { point_radius = \"65 mm\", blade_angle = \"18.088495 deg\" } }\n\
        [gear]\nteeth = 42\nspiral_angle = \"38.969849 deg\"\n\
        blank = { standard = \"ISO 23509\", method = 1, pinion_spiral_angle = \"50 deg\", outer_pitch_diameter = \"170 mm\", face_width = \"25 mm\", cutter_radius = \"63.5 mm\", pressure_angle = \"20 deg\", addendum_angle = \"1 deg\", dedendum_angle = \"4 deg\", addendum_factor = 0.35, thickness_factor = 0.1, limit_influence = 1, backlash = \"0.1266 mm\" }\n\
        convex = { cutter = { point_radius = \"62.5 mm\", blade_angle = \"18.088495 deg\" } }\n";
    let folder = tempfile::tempdir().unwrap();
    let places = ["left", "right"].map(|hand| {
        let path = put(
            folder.path(),
            "pair.toml",
            &text.replace("\"left\"", &format!("\"{hand}\"")),
        );
        let found = document(&["gear", path.to_str().unwrap(), "--json"]);
        let place = &found["tca"]["reference"]["gear"];
        ["face", "height"].map(|key| number(&place[key]))
    });
    for k in 0..2 {
        assert!((places[0][k] - places[1][k]).abs() < 1e-9, "{places:?}");
    }
    let off = f64::hypot(places[0][0] - 0.5, places[0][1] - 0.5);
    assert!(off < 0.2, "the place nearest the middle: {places:?}");
}

/// A wanted ease-off keeps the depth of the slot of a pinion of few teeth, whose flank ends above its root.
#[test]
fn law_depth_of_small_pinions_is_held() {
    for z in [13, 15, 16] {
        let design = Design {
            teeth: [z, 39],
            ..DESIGN
        };
        let target = ["--target", "data/bevel_12_36_target.toml"];
        let found = design.answer(&[&["gear correct"], &target[..]].concat());
        let deeper = &found["correct"]["flanks"][0]["deeper_um"];
        for k in 0..3 {
            assert!(number(&deeper[k]).abs() < 200.0, "{z}: {found}");
        }
        assert!(!codes(&found).contains(&"interference"), "{z}: {found}");
    }
}

/// Flanks that undercut removes have no contact.
#[test]
fn survives_removed_flanks_without_a_contact() {
    let design = Design {
        shaft_angle: 140.0,
        teeth: [20, 31],
        ..DESIGN
    };
    let found = design.answer(&["gear"]);
    assert!(found["tca"].is_null());
    assert!(
        found.to_string().contains("removes the whole flank"),
        "{found}"
    );
}

/// Teeth thicker than their pitch, and a flank of another spiral angle than its blank's, are named.
#[test]
fn keeps_warnings_of_teeth_that_do_not_fit() {
    assert!(!codes(&DESIGN.answer(&["gear"])).contains(&"no-backlash"));
    let thick = Design {
        thickness: 5.51,
        ..DESIGN
    };
    assert!(codes(&thick.answer(&["gear"])).contains(&"no-backlash"));
    let other = Design {
        spiral_angle: 30.0,
        ..DESIGN
    };
    let found = other.answer(&["gear"]);
    assert_eq!(
        codes(&found)
            .iter()
            .filter(|c| **c == "other-spiral")
            .count(),
        2
    );
}
