//! Nodes without inertia that stay, since what acts on them is not linear: index one in the method for stiff machines.

mod support;

use geardyn::base::stop::Stop;
use geardyn::motion::signal::Signal;
use geardyn::plan::motion::choice;
use geardyn::plan::motion::run::{self, Motion};
use geardyn::plan::motion::scene::MotionScene;
use geardyn::plan::prepared::Prepared;
use geardyn::scene;
use geardyn::scene::study::SimulateStudy;
use support::moving::{branch, inertias, push, run as by, spring};

/// Two discs with a node of no inertia between linear springs: as if these were the one spring they are in series.
#[test]
fn law_linear_is_the_condensed_one() {
    for share in [0.0, 0.02] {
        let chain = |nodes: &[f64]| {
            let mut train = inertias(nodes);
            let last = nodes.len() - 1;
            train.branches.push(branch("ground", &[(0, 1.0)], spring(30.0, 0.1)));
            train.drives.push(push(0, Signal::harmonic(2.0, 3.0, 0.2)));
            train.drives.push(push(last, Signal::step(1.5, 0.7)));
            train
        };
        let mut whole = chain(&[1.0, 0.0, 2.0]);
        whole.branches.push(branch("a", &[(0, -1.0), (1, 1.0)], spring(200.0, share * 200.0)));
        whole.branches.push(branch("b", &[(1, -1.0), (2, 1.0)], spring(300.0, share * 300.0)));
        let mut one = chain(&[1.0, 2.0]);
        one.branches.push(branch("ab", &[(0, -1.0), (1, 1.0)], spring(120.0, share * 120.0)));
        let (_, exact, _) = by("exact", &one, &[0.1, -0.1, 0.0, 0.5], 3.0, 60).unwrap();
        let middle = |a: f64, b: f64| (200.0 * a + 300.0 * b) / 500.0;
        let start = [0.1, middle(0.1, -0.1), -0.1, 0.0, middle(0.0, 0.5), 0.5];
        let (_, found, _) = by("radau5", &whole, &start, 3.0, 60).unwrap();
        for (y, x) in found.iter().zip(&exact) {
            let there = [x[0], middle(x[0], x[1]), x[1], x[2], middle(x[2], x[3]), x[3]];
            for (a, b) in y.iter().zip(there) {
                assert!((a - b).abs() < 1e-10, "{share}: {y:?} {there:?}");
            }
        }
    }
}

fn moved(text: &str, until: f64, outputs: &[&str]) -> (&'static str, Motion) {
    let head = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n";
    let scene = scene::read_text("test.toml", &format!("{head}{text}")).unwrap();
    let study = SimulateStudy {
        until: Some(until),
        outputs: outputs.iter().map(|s| s.to_string()).collect(),
        samples: Some(100),
        tolerance: Some(1e-11),
        energy: true,
        ..SimulateStudy::default()
    };
    let ready = MotionScene::new(&Prepared::new(&scene.model).unwrap(), &scene.start, &study).unwrap();
    let choice = choice::choose(&ready.moving.train, &study).unwrap();
    let motion = run::run(&ready, &choice, true, &Stop::default()).unwrap();
    (choice.method.name, motion)
}

/// Two discs, between them a shaft and a coupling that hardens; the node where these meet has the inertia J.
fn coupled(inertia: f64, c: f64) -> Motion {
    let text = format!(
        r#"
inertia = [{{ name = "a", J = 1.0 }}, {{ name = "n", J = {inertia} }}, {{ name = "b", J = 0.5 }}]
shaft = [{{ name = "s", between = ["a", "n"], k = 400.0, c = {c} }}]
coupling = [{{ name = "hard", between = ["n", "b"], c = {c}, characteristic = {{ kind = "power", torque = 30.0, deflection = 0.1, exponent = 3.0 }} }}]
load = [{{ at = "a", kind = "harmonic", torque = 20.0, frequency = "0.8 Hz" }}, {{ at = "n", kind = "ramp", torque = 6.0, between = [0.3, 0.8] }}]
"#
    );
    let outputs = ["a", "n", "b", "n.theta.speed", "s.force", "hard.force"];
    let (method, motion) = moved(&text, 2.0, &outputs);
    assert_eq!(method, "radau5");
    motion
}

/// Where nothing else acts on the node the shaft carries what the coupling carries, and the load; the energy adds up.
#[test]
fn exact_balance_at_the_node() {
    for c in [0.0, 0.4] {
        let motion = coupled(0.0, c);
        let [_, _, _, _, shaft, hard] = &motion.values[..] else {
            panic!()
        };
        for ((t, a), b) in motion.time.iter().zip(shaft).zip(hard) {
            let load = 6.0 * ((t - 0.3) / 0.5).clamp(0.0, 1.0);
            assert!((a - b - load).abs() < 1e-7, "{t}: {a} {b} {load}");
        }
        // Its speed is the rate of its angle.
        let (angle, speed) = (&motion.values[1], &motion.values[3]);
        for k in 60..90 {
            let h = motion.time[1];
            let rate = (angle[k + 1] - angle[k - 1]) / (2.0 * h);
            assert!((rate - speed[k]).abs() < 0.1, "{k}: {rate} {}", speed[k]);
        }
        let gap = motion.balance.unwrap()[0].gap().abs();
        assert!(gap < 1e-6, "{gap:e}");
    }
}

/// A node of next to no inertia moves as one of none, apart by what is proportional to it.
#[test]
fn order_limit_of_small_inertia() {
    let none = coupled(0.0, 0.4);
    let apart = |inertia: f64| {
        let some = coupled(inertia, 0.4);
        let gaps = some.values[2].iter().zip(&none.values[2]);
        gaps.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
    };
    let (two, one) = (apart(2e-4), apart(1e-4));
    assert!(one > 1e-9, "seen above the tolerance: {one:e}");
    assert!((two / one - 2.0).abs() < 0.1, "{two:e} {one:e}");
}

/// Play on one side, a spring on the other: in the gap the node goes with the spring, beyond it stands between both.
#[test]
fn law_play_at_the_node() {
    let text = r#"
inertia = [{ name = "a", J = 1.0 }, { name = "n", J = 0.0 }]
shaft = [{ name = "s", between = ["a", "n"], k = 300.0 }]
coupling = [{ name = "play", between = ["ground", "n"], k = 600.0, backlash = 0.02 }]
load = [{ at = "a", kind = "harmonic", torque = 4.0, frequency = "0.5 Hz" }]
"#;
    let (method, motion) = moved(text, 4.0, &["a", "n", "s.force", "play.force"]);
    assert_eq!(method, "radau5");
    assert!(motion.effort.events > 4);
    for k in 0..=100 {
        let [a, n, shaft, play] = [0, 1, 2, 3].map(|at| motion.values[at][k]);
        assert!((shaft + play).abs() < 1e-7, "{shaft} {play}");
        // Springs in series beyond the gap: 600·300/900.
        let beyond = (a.abs() - 0.01).max(0.0) * a.signum();
        assert!((play - 200.0 * beyond).abs() < 1e-6, "{k}: {a} {n} {play}");
    }
}

/// A node that nothing holds has no place.
#[test]
fn refuses_what_floats() {
    let head = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n";
    let text = format!("{head}inertia = [{{ name = \"a\", J = 1.0 }}, {{ name = \"n\", J = 0.0 }}]\ncoupling = [{{ name = \"play\", between = [\"a\", \"n\"], k = 600.0, backlash = 0.02 }}]");
    let scene = scene::read_text("test.toml", &text).unwrap();
    let study = SimulateStudy {
        until: Some(1.0),
        ..SimulateStudy::default()
    };
    let ready = Prepared::new(&scene.model).and_then(|p| MotionScene::new(&p, &scene.start, &study).map(|_| ()));
    let error = ready.err().unwrap();
    assert!(error.hint.is_some(), "{error:?}");
}
