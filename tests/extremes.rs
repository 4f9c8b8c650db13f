//! The scene at its extremes: the energy is added up along the motion, and verdicts mean what they say.

use std::path::Path;

use geardyn::base::stop::Stop;
use geardyn::motion::meter::Balance;
use geardyn::motion::methods;
use geardyn::plan::motion::choice;
use geardyn::plan::motion::run::{self, Motion};
use geardyn::plan::motion::scene::MotionScene;
use geardyn::plan::prepared::Prepared;
use geardyn::scene::study::SimulateStudy;
use geardyn::scene::{self, Scene};
use geardyn::study::stability::cases::Extreme;
use geardyn::study::stability::extremes::{ADDS_UP, Asked, Verdict, judged, rerun};

fn scene_of(text: &str) -> Scene {
    let head = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n";
    scene::read_text("test.toml", &format!("{head}{text}")).unwrap()
}

fn ready(scene: &Scene, study: &SimulateStudy) -> MotionScene {
    let prepared = Prepared::new(&scene.model).unwrap();
    MotionScene::new(&prepared, &scene.start, study).unwrap()
}

fn moved(ready: &MotionScene, study: &SimulateStudy) -> Motion {
    let choice = choice::choose(&ready.moving.train, study).unwrap();
    run::run(ready, &choice, true, &Stop::default()).unwrap()
}

fn by(method: &str, until: f64) -> SimulateStudy {
    SimulateStudy {
        until: Some(until),
        samples: Some(50),
        method: Some(method.to_string()),
        ..SimulateStudy::default()
    }
}

/// A free disc under a table whose kinks lie between the samples.
const PUSHED: &str = r#"
inertia = [{ name = "disc", J = 2.0 }, { name = "other", J = 3.0 }]
shaft = [{ name = "bar", between = ["disc", "other"], k = 200.0, c = 4.0 }]
[[load]]
at = "disc"
kind = "table"
times = [0.0, 0.0137, 0.1013, 0.1079, 0.7171]
torques = [0.0, 8.0, -3.0, 9.0, 0.0]
"#;

/// What is put in closes to rounding wherever the kinks lie; every method's balance is known to be so, and its doubt is said.
#[test]
fn law_kinks_off_the_samples_cost_nothing() {
    let scene = scene_of(PUSHED);
    for (method, within) in [
        ("exact", 1e-11),
        ("dop853-events", 1e-8),
        ("radau5", 1e-7),
        ("dopri5", 1e-8),
    ] {
        let study = by(method, 1.0);
        let ready = ready(&scene, &study);
        let balance = moved(&ready, &study).balance.unwrap();
        assert!(balance.put_in > 0.1 && balance.lost > 1e-4, "{balance:?}");
        assert!(
            balance.gap().abs() < within,
            "{method}: {:e}",
            balance.gap()
        );
        assert!(balance.doubt().unwrap() < 1e-4, "{method}: {balance:?}");
    }
}

/// However much faster the swings are than the samples, the losses are found: of what a step puts in, half stays in the spring and
/// half is lost in ten thousand swings.
#[test]
fn law_fast_swings_are_seen() {
    let scene = scene_of(
        r#"
inertia = [{ name = "disc", J = 1.0 }]
shaft = [{ name = "bar", between = ["ground", "disc"], k = 4e9, c = 60.0 }]
load = [{ at = "disc", kind = "step", torque = 4e6, time = 0.0 }]
"#,
    );
    let study = by("exact", 1.0);
    let ready = ready(&scene, &study);
    let balance = moved(&ready, &study).balance.unwrap();
    assert!((balance.put_in / 4000.0 - 1.0).abs() < 1e-7, "{balance:?}");
    assert!((balance.lost / 2000.0 - 1.0).abs() < 1e-9, "{balance:?}");
}

/// The figure of the unchanged scene is the gap that `simulate --energy` prints, whatever the method.
#[test]
fn law_the_figure_is_that_of_the_simulation() {
    let scene = scene_of(PUSHED);
    for method in ["exact", "radau5", "dopri5", "generalized-alpha-controlled"] {
        let study = by(method, 0.2);
        let ready = ready(&scene, &study);
        let gap = moved(&ready, &study).balance.unwrap().gap().abs();
        let as_it_is = Extreme::of(&ready, choice::TOLERANCE, 1e-3);
        let method = methods::find(method).unwrap();
        let case = rerun("", method, (&as_it_is, ready.samples), &Stop::default()).unwrap();
        assert_eq!(case.figure, Some(gap), "{}", case.method);
        assert_eq!(case.verdict, Verdict::Pass, "{}", case.method);
    }
}

/// With half of its energy missing no case passes: where that is known it has failed, where it is not it is refused.
#[test]
fn law_no_pass_without_knowing() {
    let lost = Balance {
        before: 1.0,
        largest: 1.0,
        after: 0.5,
        readings: 700,
        ..Balance::default()
    };
    assert_eq!(judged(&lost, Asked::Exact).0, Verdict::Fail);
    let vague = Balance { off: 0.6, ..lost };
    let (verdict, _, why) = judged(&vague, Asked::Exact);
    assert_eq!(verdict, Verdict::Refused);
    assert!(why.unwrap().contains("cannot be told"));
    let half = Balance {
        given_up: Some(0.5),
        ..lost
    };
    let (verdict, figure, why) = judged(&half, Asked::Exact);
    assert_eq!((verdict, figure), (Verdict::Refused, None));
    assert!(why.unwrap().contains("about 1.4e3"));
    let fine = Balance {
        after: 1.0 - 0.5 * ADDS_UP,
        ..lost
    };
    assert_eq!(judged(&fine, Asked::Exact).0, Verdict::Pass);
    let doubtful = Balance {
        off: 0.6 * ADDS_UP,
        ..fine
    };
    assert_eq!(judged(&doubtful, Asked::Exact).0, Verdict::Refused);
}

/// What a tolerance allows, added up over the steps, is no fault of the method: it is refused with the tolerance that would do.
/// More than that is.
#[test]
fn law_coarse_is_not_wrong() {
    let lost = Balance {
        before: 1.0,
        largest: 1.0,
        after: 0.9,
        ..Balance::default()
    };
    let (verdict, _, why) = judged(&lost, Asked::Tolerance(1e-2, 10));
    assert_eq!(verdict, Verdict::Refused);
    assert!(why.unwrap().contains("about 1e-4"));
    assert_eq!(judged(&lost, Asked::Tolerance(1e-8, 10)).0, Verdict::Fail);
    let (verdict, _, why) = judged(&lost, Asked::Step(0.1, 2));
    assert_eq!(verdict, Verdict::Refused);
    assert!(why.unwrap().contains("steps of about 10.0 ms"));
}

/// A table of stiffness in steps at imposed speed, and a prescribed motion: what both put in is booked at the instant it is put in.
#[test]
fn law_jumps_are_booked() {
    for name in ["geared_chain.toml", "backlash_pair.toml"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("examples")
            .join(name);
        let scene = scene::read(&path).unwrap();
        let study = SimulateStudy {
            until: Some(0.01),
            samples: Some(7),
            ..SimulateStudy::default()
        };
        let ready = ready(&scene, &study);
        let balance = moved(&ready, &study).balance.unwrap();
        let apart = balance.gap().abs() * balance.size();
        let turned = balance.put_in.abs().max(balance.lost);
        assert!(apart < 1e-6 * turned, "{name}: {apart} of {balance:?}");
    }
}
