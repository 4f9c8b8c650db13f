//! Machines at the edge of what is one: two trains, one body, numbers at the ends of what is taken.

use geardyn::internals::base::error::Error;
use geardyn::internals::plan::modes_run::{ModesResult, run};
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::stages::ModesPlan;
use geardyn::internals::scene;
use geardyn::internals::scene::study::ModesStudy;

const HEAD: &str = "title = \"t\"\nsource = \"test\"\nunits = \"SI\"\n";

fn body(name: &str, j: f64) -> String {
    format!("[[inertia]]\nname = \"{name}\"\nJ = {j:?}\n")
}

fn spring(name: &str, a: &str, b: &str, k: f64) -> String {
    format!("[[coupling]]\nname = \"{name}\"\nbetween = [\"{a}\", \"{b}\"]\nk = {k:?}\n")
}

fn solve(text: &str) -> Result<ModesResult, Error> {
    let scene =
        scene::read_text("test.toml", &(HEAD.to_string() + text)).unwrap_or_else(|e| panic!("{e}"));
    let machine = PreparedMachine::new(&scene.model)?;
    let study = ModesStudy::default();
    run(&machine, &study, &ModesPlan::plan_modes(&machine, &study))
}

/// Two trains in one file are two rigid-body modes, not an error.
#[test]
fn exact_two_trains() {
    let train = |p: &str| body(&format!("{p}1"), 1.0) + &body(&format!("{p}2"), 2.0);
    let text = train("a")
        + &train("b")
        + &spring("x", "a1", "a2", 300.0)
        + &spring("y", "b1", "b2", 600.0);
    let modes = solve(&text).unwrap().modes;
    assert_eq!(modes.iter().filter(|m| m.rigid).count(), 2);
    for (mode, k) in modes[2..].iter().zip([300.0, 600.0]) {
        assert!((mode.omega() / (k * 1.5f64).sqrt() - 1.0).abs() < 1e-14);
    }
}

/// A body alone turns freely; a body held rigidly has no mode left.
#[test]
fn survives_one_body() {
    let modes = solve(&body("a", 1.0)).unwrap().modes;
    assert!(modes.len() == 1 && modes[0].rigid);
    let held = body("a", 1.0) + "[[coupling]]\nname = \"s\"\nbetween = [\"a\", \"ground\"]\n";
    assert!(solve(&held).unwrap().modes.is_empty());
}

/// Numbers at the ends of what is taken give a frequency or an error, never a NaN.
#[test]
fn survives_absurd_scales() {
    for (j, k) in [(1e-50, 1e50), (1e50, 1e-50), (1e-50, 1e-50), (1e50, 1e50)] {
        let text = body("a", j) + &body("b", j) + &spring("s", "a", "b", k);
        match solve(&text) {
            Ok(result) => {
                let omega = result.modes[1].omega();
                assert!(omega.is_finite() && omega > 0.0, "{j:e} {k:e}: {omega}");
                assert!((omega / (2.0f64.sqrt() * k.sqrt() / j.sqrt()) - 1.0).abs() < 1e-9);
            }
            Err(error) => assert_eq!(error.code.exit_code(), 3, "{error}"),
        }
    }
}
