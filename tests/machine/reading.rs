//! A whole model and a scene read into their types, and what random changes of it do.

use std::f64::consts::PI;
use std::fs;

use geardyn::internals::base::flags::{Flag, Flags};
use geardyn::internals::scene::model::{
    BarMass, BranchDamping, BranchEnd, PlanetaryGeometry, ShaftBody,
};
use geardyn::internals::scene::study::{ResponseQuantity, ResponseStudy, SpeedRange, StudyKind};
use geardyn::internals::scene::{read, read_text};

/// One element of every kind.
const EVERYTHING: &str = r#"
title = "One of each"
source = "invented for the test of the reader"

[[inertia]]
name = "motor"
J = "0.0095 kg·m²"

[[inertia]]
name = "pinion"
J = "95 kg·cm²"
mass = "3 kg"
J_diametral = "0.005 kg·m²"

[[inertia]]
name = "wheel"
diameter = "200 mm"
bore = "40 mm"
width = "30 mm"
material = "steel"

[[inertia]]
name = "sun"
J = "0 kg·m²"

[[inertia]]
name = "carrier"
J = "0.1 kg·m²"

[[shaft]]
name = "motor_shaft"
between = ["motor", "pinion"]
k = "8.5 kN·m/rad"
damping_ratio = 0.01

[[shaft]]
name = "long_shaft"
between = ["wheel", "sun"]
length = "400 mm"
diameter = "30 mm"
material = "steel"
segments = 4
mass = "consistent"
loss_factor = 0.02

[[chain]]
name = "row"
count = 5
J = "1 kg·m²"
k = "10 N·m/rad"
held = "start"

[[gear_pair]]
name = "first_pair"
between = ["pinion", "wheel"]
teeth = [21, 63]
module = "3 mm"
helix_angle = "15 deg"
hand = "left"
k = "420 N/µm"
c = "900 N·s/m"
backlash = "80 µm"

[[worm_pair]]
name = "worm"
between = ["row.5", "carrier"]
teeth = [1, 90]
lead_angle = "4 deg"
friction = 0.05

[[planetary]]
name = "stage"
sun = "sun"
ring = "ground"
carrier = "carrier"
planets = 3
teeth = [20, 40, 100]
module = "2 mm"
pressure_angle = ["20 deg", "21 deg"]
planet_J = "1e-3 kg·m²"
k_sun = "300 N/µm"
damping_ratio_sun = 0.03
k_ring = "400 N/µm"
c_ring = "1 N·s/mm"

[[belt]]
name = "belt"
between = ["motor", "row.1"]
diameters = ["100 mm", "250 mm"]
k = "100 N/mm"

[[coupling]]
name = "jaw"
between = ["long_shaft.2", "ground"]
k = "-5 N·m/rad"
backlash = "0.5 deg"

[[bearing]]
name = "front"
at = "pinion"
k_radial = "200 N/µm"
k_x_y = "5 N/µm"
k_ry_x = "3 kN·m/m"
c_x = "100 N·s/m"

[[damper]]
name = "brake"
at = "stage.planet_3"
c = "0.1 N·m·s/rad"

[[load]]
at = "motor"
torque = "12 N·m"

[speed]
motor = "1450 rpm"

[damping]
rayleigh_mass = "0.5 1/s"
modal = [0.01, 0.02]
"#;

fn close(got: f64, expected: f64) {
    assert!(
        (got - expected).abs() <= 1e-14 * expected.abs(),
        "{got} is not {expected}"
    );
}

#[test]
fn exact_one_of_each_element() {
    let scene = read_text("one.toml", EVERYTHING).unwrap_or_else(|e| panic!("{e}"));
    let m = &scene.model;
    assert_eq!(m.title, "One of each");
    close(m.inertias[1].polar, 0.0095);
    let mass = 7850.0 * PI / 4.0 * (0.2 * 0.2 - 0.04 * 0.04) * 0.03;
    close(m.inertias[2].mass.unwrap(), mass);
    close(m.inertias[2].polar, mass * (0.2 * 0.2 + 0.04 * 0.04) / 8.0);
    assert!(matches!(m.shafts[0].body, Some(ShaftBody::Stiffness(k)) if k == 8500.0));
    assert_eq!(m.shafts[0].loss, BranchDamping::Ratio(0.01));
    let Some(ShaftBody::Bar {
        shear_modulus,
        segments,
        mass,
        ..
    }) = m.shafts[1].body
    else {
        panic!("{:?}", m.shafts[1]);
    };
    assert_eq!((segments, mass), (4, BarMass::Consistent));
    close(shear_modulus, 79.3e9);
    assert!(m.chains[0].start_fixed && !m.chains[0].end_fixed);
    let pair = &m.gear_pairs[0];
    close(pair.contact.stiffness.unwrap(), 420e6);
    close(pair.contact.backlash, 80e-6);
    close(pair.spiral_angles[1], PI / 12.0);
    close(pair.pressure_angle, PI / 9.0);
    assert_eq!(pair.mesh_angles, [0.0, PI]);
    assert_eq!(m.worm_pairs[0].module, None);
    let stage = &m.planetaries[0];
    assert_eq!(stage.positions.len(), 3);
    assert!(matches!(stage.ring, BranchEnd::Ground));
    assert!(matches!(
        stage.size,
        PlanetaryGeometry::Teeth {
            teeth: [20, 40, 100],
            ..
        }
    ));
    assert_eq!(stage.ring_contact.loss, BranchDamping::Viscous(1000.0));
    close(stage.pressure_angles[1], 21.0 * PI / 180.0);
    assert_eq!(m.belts[0].ratio_integers, [50_000_000, 125_000_000]);
    assert_eq!(m.couplings[0].contact.stiffness, Some(-5.0));
    assert_eq!(m.bearings[0].stiffness.len(), 4);
    assert_eq!(m.bearings[0].damping.len(), 1);
    close(m.speeds[0].speed, 1450.0 * PI / 30.0);
    assert_eq!(m.damping.modal, [0.01, 0.02]);
}

#[test]
fn exact_si_mode_takes_bare_numbers() {
    let text = "units = \"SI\"\n[[inertia]]\nname = \"a\"\nJ = 2\n[[inertia]]\nname = \"b\"\nJ = \"3\"\n\
                [[shaft]]\nname = \"s\"\nbetween = [\"a\", \"b\"]\nk = 1.2e3\n[speed]\na = \"60 rpm\"\n";
    let model = read_text("si.toml", text)
        .unwrap_or_else(|e| panic!("{e}"))
        .model;
    assert_eq!(
        (model.inertias[0].polar, model.inertias[1].polar),
        (2.0, 3.0)
    );
    close(model.speeds[0].speed, 2.0 * PI);
}

#[test]
fn exact_scene_changes_its_model() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("one.toml"), EVERYTHING).unwrap();
    let path = folder.path().join("scene.toml");
    fs::write(
        &path,
        "model = \"one.toml\"\n[set]\n\"motor_shaft.k\" = \"60 kN·m/rad\"\nspeed.motor = \"60 rpm\"\nrow.count = 7\n\
         [[load]]\nat = \"wheel\"\ntorque = \"-3 N·m\"\n\
         [[study]]\nkind = \"modes\"\ndamped = true\nlowest = 5\ncampbell = \"0:3000:31\"\n\
         [[study]]\nkind = \"modes\"\nnear = \"10 Hz\"\n",
    )
    .unwrap();
    let scene = read(&path).unwrap_or_else(|e| panic!("{e}"));
    assert!(matches!(scene.model.shafts[0].body, Some(ShaftBody::Stiffness(k)) if k == 60e3));
    assert_eq!(scene.model.chains[0].count, 7);
    assert_eq!(scene.model.loads.len(), 2);
    assert_eq!(scene.sources.len(), 2);
    close(scene.model.speeds[0].speed, 2.0 * PI);
    let StudyKind::Modes(modes) = &scene.studies[0].kind else {
        panic!("the first study is of modes");
    };
    assert!(modes.damped && modes.lowest == Some(5));
    let expected = SpeedRange {
        from: 0.0,
        to: 100.0 * PI,
        count: 31,
    };
    let range = modes.campbell.unwrap();
    assert_eq!((range.from, range.count), (expected.from, expected.count));
    close(range.to, expected.to);
    let StudyKind::Modes(modes) = &scene.studies[1].kind else {
        panic!("the second study is of modes");
    };
    close(modes.near.unwrap(), 20.0 * PI);
}

/// Former names of keys mean what today's names mean, and a flag lies over either; of a listed study all else is kept.
#[test]
fn exact_former_keys_and_flags() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("one.toml"), EVERYTHING).unwrap();
    let study = |keys: &str, flags: &Flags| -> ResponseStudy {
        let path = folder.path().join("scene.toml");
        let study = format!("[[study]]\nkind = \"response\"\nspeed = \"60 rpm\"\n{keys}");
        fs::write(&path, format!("model = \"one.toml\"\n{study}")).unwrap();
        let scene = read(&path).unwrap_or_else(|e| panic!("{e}"));
        scene.study(flags).unwrap_or_else(|e| panic!("{e}"))
    };
    let none = Flags::default();
    let former =
        "inputs = [\"motor\"]\noutputs = [\"wheel\"]\nshown = \"mobility\"\nband = \"1:9\"\n";
    let today = "input = \"motor\"\noutput = [\"wheel\"]\nas = \"mobility\"\nband = \"1:9\"\n";
    let listed = study(former, &none);
    assert_eq!(listed, study(today, &none));
    assert_eq!(listed.motion_quantity, Some(ResponseQuantity::Mobility));
    let flag = |key: &str, values: &[&str], is_list: bool| Flag {
        name: format!("--{key}"),
        key: key.to_string(),
        values: values.iter().map(|value| value.to_string()).collect(),
        is_list,
        is_switch: false,
    };
    let flags = Flags::new(&[
        flag("output", &["pinion", "sun"], true),
        flag("speed", &["120"], false),
    ]);
    let expected = ResponseStudy {
        outputs: vec!["pinion".into(), "sun".into()],
        speed: Some(4.0 * PI),
        ..listed
    };
    assert_eq!(study(former, &flags), expected);
    assert_eq!(study(today, &flags), expected);
}

/// A linear congruential generator with Knuth's MMIX constants.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as usize % n
    }
}

#[test]
fn survives_random_mutations() {
    const PIECES: &[&str] = &[
        "\"",
        "'",
        "\"\"\"",
        "[",
        "]",
        "[[",
        "]]",
        "{",
        "}",
        ".",
        ",",
        "=",
        "#",
        "\n",
        "\r",
        "-",
        "0",
        "1e999",
        "nan",
        "\u{feff}",
        "µ",
        "²",
        "\\",
        "\0",
        " ",
        "[[load]]\n",
        "name = ",
        "1 N/m",
        "²²",
        "(",
        "/",
        "^-",
        "🦀",
    ];
    let mut random = Random(1);
    for _ in 0..4000 {
        let mut text: Vec<char> = EVERYTHING.chars().collect();
        for _ in 0..=random.below(4) {
            let at = random.below(text.len());
            match random.below(4) {
                0 => drop(text.remove(at)),
                1 => {
                    let end = (at + random.below(30)).min(text.len());
                    text.drain(at..end);
                }
                2 => {
                    let piece = PIECES[random.below(PIECES.len())];
                    text.splice(at..at, piece.chars());
                }
                _ => {
                    let other = random.below(text.len());
                    text.swap(at, other);
                }
            }
        }
        let text: String = text.into_iter().collect();
        if let Err(errors) = read_text("m.toml", &text) {
            assert!(!errors.as_slice().is_empty());
            assert!(errors.to_string().len() < 20_000);
            #[cfg(feature = "cli")]
            assert!(!geardyn::internals::cli::render::render_errors(&errors, false).is_empty());
        }
    }
}

/// Time grows with the file, not with its square.
#[test]
fn survives_a_hundred_thousand_tables() {
    use std::fmt::Write;
    let mut text = String::new();
    for i in 0..50_000 {
        writeln!(text, "[[inertia]]\nname = \"b{i}\"\nJ = \"1 kg·m²\"").unwrap();
        writeln!(
            text,
            "[[shaft]]\nname = \"s{i}\"\nbetween = [\"b{i}\", \"b{}\"]",
            (i + 1) % 50_000
        )
        .unwrap();
        writeln!(text, "k = \"1 N·m/rad\"").unwrap();
    }
    assert_eq!(
        read_text("m.toml", &text)
            .unwrap_or_else(|e| panic!("{e}"))
            .model
            .shafts
            .len(),
        50_000
    );
    let wrong = text.replace("name = \"b", "nam = \"b");
    let errors = read_text("m.toml", &wrong).unwrap_err();
    assert_eq!(errors.as_slice().len(), 1000);
}
