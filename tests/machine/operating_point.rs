//! Which contacts carry under the mean loads, on which flank, and what follows for the modes.

use crate::support::verification::{printed, within};
use geardyn::internals::machine::operating_point::ActiveFlank;
use geardyn::internals::plan::modes_run::{ModesResult, run};
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::stages::ModesPlan;
use geardyn::internals::scene;
use geardyn::internals::scene::study::ModesStudy;

fn prepared(text: &str) -> PreparedMachine {
    let scene = scene::read_text("test.toml", text).unwrap_or_else(|e| panic!("{e}"));
    PreparedMachine::new(&scene.model).unwrap_or_else(|e| panic!("{e}"))
}

fn modes(machine: &PreparedMachine) -> ModesResult {
    let study = ModesStudy::default();
    run(machine, &study, &ModesPlan::plan_modes(machine, &study)).unwrap()
}

/// Motor, pinion, wheel, roll; `loads` as (node, N·m).
fn drive(loads: &[(&str, f64)]) -> PreparedMachine {
    let body = |name: &str, j: f64| format!("[[inertia]]\nname = \"{name}\"\nJ = {j}\n");
    let mut text = "title = \"t\"\nsource = \"test\"\nunits = \"SI\"\n".to_string();
    text += &[
        body("motor", 0.01),
        body("pinion", 0.001),
        body("wheel", 0.04),
        body("roll", 1.5),
    ]
    .concat();
    text += "[[shaft]]\nname = \"s1\"\nbetween = [\"motor\", \"pinion\"]\nk = 8000.0\n";
    text += "[[shaft]]\nname = \"s2\"\nbetween = [\"wheel\", \"roll\"]\nk = 50000.0\n";
    text += "[[gear_pair]]\nname = \"pair\"\nbetween = [\"pinion\", \"wheel\"]\nteeth = [21, 63]\nmodule = 0.003\nk = 4e8\nbacklash = 8e-5\n";
    for (node, torque) in loads {
        text += &format!("[[load]]\nat = \"{node}\"\ntorque = {torque:?}\n");
    }
    prepared(&text)
}

/// The mesh carries the motor's torque over the base radius; turned round, the coast flank does.
#[test]
fn exact_flank_and_force_of_a_pair() {
    let base = 21.0 * 0.003 * 20f64.to_radians().cos() / 2.0;
    for (torque, state) in [(30.0, ActiveFlank::Drive), (-30.0, ActiveFlank::Coast)] {
        let found = drive(&[("motor", torque), ("roll", 3.0 * torque)]).operating;
        let (_, found_state, force) = found.contacts[0];
        assert_eq!(found_state, state);
        let exact = torque / base;
        within("force", (force.unwrap() / exact - 1.0).abs(), 1e-9);
    }
}

/// Loads that do not balance accelerate the train: the mesh carries what the roll's side of the inertia takes.
#[test]
fn exact_inertia_relief() {
    let found = drive(&[("motor", 30.0)]).operating;
    let (upper, lower) = (0.01 + 0.001, (0.04 + 1.5) / 9.0);
    let base = 21.0 * 0.003 * 20f64.to_radians().cos() / 2.0;
    let exact = 30.0 * lower / (upper + lower) / base;
    let force = found.contacts[0].2.unwrap();
    within("force", (force / exact - 1.0).abs(), 1e-9);
}

/// A contact that carries nothing is open: it has no stiffness, the train falls in two, and the answer says so.
#[test]
fn exact_open_contact() {
    // Torque and inertia in the same ratio on both sides of the mesh: nothing passes through it.
    let lower = 3.0 * (0.04 + 1.5) / 9.0 / (0.01 + 0.001);
    let machine = drive(&[("motor", 1.0), ("roll", -lower)]);
    assert_eq!(machine.operating.contacts[0].1, ActiveFlank::Open);
    let result = modes(&machine);
    assert_eq!(result.modes.iter().filter(|m| m.rigid).count(), 2);
    assert!(result.diagnostics.iter().any(|w| w.code == "contact-open"));
    // The two halves are two discs on a spring each.
    let two = |k: f64, a: f64, b: f64| (k * (1.0 / a + 1.0 / b)).sqrt();
    let mut exact = [two(8000.0, 0.01, 0.001), two(50000.0, 0.04, 1.5)];
    exact.sort_by(f64::total_cmp);
    for (mode, exact) in result.modes[2..].iter().zip(exact) {
        within("frequencies", (mode.omega() / exact - 1.0).abs(), 1e-12);
    }
}

/// Without loads every contact stands on its drive flank, and that is said.
#[test]
fn law_no_load_is_said() {
    let machine = drive(&[]);
    assert_eq!(machine.operating.contacts[0].1, ActiveFlank::Drive);
    assert!(machine.warnings().iter().any(|w| w.code == "no-load"));
}

/// The four-square rig against a static solution by another program (NumPy, its own assembly of the same file, without play):
/// test mesh −6 273.6 N, slave mesh +5 293.4 N, so that the pairs stand on opposite flanks. With its play less is locked in.
/// Source: NumPy, its own assembly of the same file.
#[test]
fn ref_numpy_four_square() {
    let text = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/models/four_square.toml"
    ))
    .unwrap();
    let forces = |text: &str| {
        let machine = prepared(text);
        ["test_pair", "slave_pair"].map(|name| {
            let of_pair =
                |c: &&(usize, ActiveFlank, Option<f64>)| machine.machine.branch_name(c.0) == name;
            machine
                .operating
                .contacts
                .iter()
                .find(of_pair)
                .unwrap()
                .2
                .unwrap()
        })
    };
    let [test, slave] = forces(&text.replace("120 µm", "1e-9 µm"));
    printed("test mesh", "N", -6273.6, test, 0.06);
    printed("slave mesh", "N", 5293.4, slave, 0.06);
    let [test_with_play, slave_with_play] = forces(&text);
    assert!(test < test_with_play && test_with_play < 0.0 && slave_with_play > 0.0);
    // Equilibrium of the wheel shaft, which both meshes turn and nothing else does.
    let arm = |teeth: f64, module: f64| teeth * module * 20f64.to_radians().cos() / 2.0;
    let (one, other) = (
        test_with_play * arm(36.0, 4.5e-3),
        slave_with_play * arm(48.0, 4e-3),
    );
    assert!((one + other).abs() < 1e-9 * one.abs(), "{one} {other}");
}

/// A contact behind which nothing is loaded stands open, however large a load acts elsewhere.
#[test]
fn exact_contact_that_carries_nothing() {
    for torque in [10.0, 1e-3] {
        let machine = prepared(&format!(
            "title = \"t\"\nsource = \"test\"\nunits = \"SI\"\n\
             [[inertia]]\nname = \"a\"\nJ = 1.0\n[[inertia]]\nname = \"b\"\nJ = 1.0\n\
             [[coupling]]\nname = \"held\"\nbetween = [\"a\", \"ground\"]\nk = 1000.0\n\
             [[coupling]]\nname = \"loose\"\nbetween = [\"a\", \"b\"]\nk = 1000.0\nbacklash = 0.001\n\
             [[load]]\nat = \"a\"\ntorque = {torque:?}\n"
        ));
        assert_eq!(
            machine.operating.contacts[0].1,
            ActiveFlank::Open,
            "{torque} N·m"
        );
    }
}

/// Loads that do not balance are said to accelerate the train.
#[test]
fn law_unbalanced_loads_are_said() {
    let codes = |machine: &PreparedMachine| {
        machine
            .warnings()
            .iter()
            .map(|w| w.code)
            .collect::<Vec<_>>()
    };
    assert!(codes(&drive(&[("motor", 30.0)])).contains(&"loads-accelerate"));
    assert!(!codes(&drive(&[("motor", 30.0), ("roll", 90.0)])).contains(&"loads-accelerate"));
}
