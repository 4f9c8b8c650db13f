//! Nodes without inertia that no condensation takes out: index one in the method for stiff machines.

use crate::support;
use crate::support::moving::{apart, branch, contact, inertias, push, run as by, run_with, spring};
use crate::support::{numbers, reference, verification, within};
use geardyn::internals::base::code::Code;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::machine::characteristic::Characteristic;
use geardyn::internals::motion::contact::ContactDamping;
use geardyn::internals::motion::dynamic_model::{DynamicModel, ForceLaw};
use geardyn::internals::motion::methods;
use geardyn::internals::motion::problem::StepSize;
use geardyn::internals::motion::signal::Signal;
use geardyn::internals::plan::motion::method_choice;
use geardyn::internals::plan::motion::run::{self, MotionResult};
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::scene;
use geardyn::internals::scene::study::SimulateStudy;

/// A disc x₀ on a spring k, behind it a node x₁ without inertia on a cubic spring and a damper to ground, pushed so that x₁ = cos t:
/// `x₀ = x₁ + (K x₁³ + c ẋ₁)/k`, `f = ẍ₀ + K x₁³ + c ẋ₁`, `cos³ t = (3 cos t + cos 3t)/4`.
fn cubic(c: f64) -> (DynamicModel, impl Fn(f64) -> [f64; 4]) {
    let (k, cube) = (2.0, 3.0);
    let mut model = inertias(&[1.0, 0.0]);
    let terms = [(0, -1.0), (1, 1.0)];
    model.elements.push(branch("k", &terms, spring(k, 0.0)));
    let characteristic = Characteristic::Power {
        factor: cube,
        exponent: 3.0,
        rated: 1.0,
    };
    let hard = ForceLaw::Nonlinear {
        characteristic,
        damping: c,
    };
    model.elements.push(branch("hard", &[(1, 1.0)], hard));
    let a = cube / k;
    let (first, third) = (0.75 * cube - 1.0 - 0.75 * a, 0.25 * cube - 2.25 * a);
    let cosines = Signal::harmonic(first, 1.0, 0.0).plus(&Signal::harmonic(third, 3.0, 0.0));
    // c/k sin t − c sin t.
    let sine = Signal::harmonic(c / k - c, 1.0, -0.5 * std::f64::consts::PI);
    model.forces.push(push(0, cosines.plus(&sine)));
    let exact = move |t: f64| {
        let x = t.cos() + a * t.cos().powi(3) - c / k * t.sin();
        let v = -t.sin() - 3.0 * a * t.cos().powi(2) * t.sin() - c / k * t.cos();
        [x, t.cos(), v, -t.sin()]
    };
    (model, exact)
}

/// Order 5 at the end of steps and 4 inside, for places and speeds of the disc and of the node, damped or not; what the
/// start says of the node gives way to what its neighbours say.
#[test]
fn order_is_kept() {
    for c in [0.0, 0.7] {
        let (model, exact) = cubic(c);
        let mut start = exact(0.0);
        start[3] = 17.0;
        if c == 0.0 {
            start[1] = -5.0;
        }
        let error = |step: f64, samples: usize| {
            let (times, states, _) = run_with(
                "radau5",
                &model,
                &start,
                4.0,
                samples,
                StepSize::Fixed(step),
            )
            .unwrap();
            let off = |(t, y): (&f64, &Vec<f64>)| {
                let gaps = y.iter().zip(exact(*t)).map(|(y, x)| (y - x).abs());
                gaps.fold(0.0, f64::max)
            };
            times.iter().zip(&states).map(off).fold(0.0, f64::max)
        };
        let order = |samples: usize| (error(0.1, samples) / error(0.05, samples)).log2();
        let (end, inner) = (order(1), order(37));
        eprintln!(
            "damper {c}: order {end:.2} at the end, {inner:.2} inside, {:.1e}",
            error(0.05, 1)
        );
        let damped = if c > 0.0 { "with" } else { "without" };
        let what = format!("radau5, node without inertia, {damped} damper");
        verification::order(&format!("{what}, at the end of steps"), 5.0, end);
        verification::order(&format!("{what}, between them"), 4.0, inner);
        let (times, states, _) =
            run_with("radau5", &model, &start, 4.0, 40, StepSize::Adaptive(1e-10)).unwrap();
        for (t, y) in times.iter().zip(&states) {
            for (y, x) in y.iter().zip(exact(*t)) {
                within("states", (y - x).abs(), 1e-9);
            }
        }
    }
}

/// A node between a spring and play: as if the springs in series were the contact, which the method exact between switches takes.
/// Source: the method that is exact between switches, on springs in series.
#[test]
fn ref_play_behind_a_spring() {
    let terms = [(0, -1.0), (1, 1.0)];
    let mut light = inertias(&[1.0, 0.0]);
    light.elements.push(branch("s", &terms, spring(300.0, 0.0)));
    light.elements.push(branch(
        "play",
        &[(1, 1.0)],
        contact(600.0, 0.0, 0.02, ContactDamping::Adhesive),
    ));
    light.forces.push(push(0, Signal::harmonic(4.0, 3.0, 0.3)));
    let mut one = inertias(&[1.0]);
    one.elements.push(branch(
        "play",
        &[(0, 1.0)],
        contact(200.0, 0.0, 0.02, ContactDamping::Adhesive),
    ));
    one.forces = light.forces.clone();
    let (_, exact, events) = by("switched", &one, &[0.0, 0.3], 3.0, 100).unwrap();
    let (_, found, effort) = run_with(
        "radau5",
        &light,
        &[0.0, 0.0, 0.3, 0.0],
        3.0,
        100,
        StepSize::Adaptive(1e-10),
    )
    .unwrap();
    assert!(
        effort.events > 10 && effort.events == events.events,
        "{effort:?} {events:?}"
    );
    for (y, x) in found.iter().zip(&exact) {
        // Beyond the gap the node stands between both springs.
        let beyond = (x[0].abs() - 0.02).max(0.0) * x[0].signum();
        let node = x[0] - 600.0 / 900.0 * beyond;
        within(
            "deflections",
            (y[0] - x[0]).abs().max((y[1] - node).abs()),
            1e-8,
        );
        let rate = if beyond == 0.0 { x[1] } else { x[1] / 3.0 };
        within("rates", (y[2] - x[1]).abs().max((y[3] - rate).abs()), 1e-7);
    }
}

/// A spring and a Maxwell element in series at the node are one Maxwell element, which the exact method takes.
/// Source: the method that is exact between switches, on one Maxwell element.
#[test]
fn ref_maxwell_behind_a_spring() {
    let maxwell = |stiffness: f64, damping: f64| ForceLaw::Maxwell { stiffness, damping };
    let terms = [(0, -1.0), (1, 1.0)];
    let mut light = inertias(&[1.0, 0.0]);
    light.elements.push(branch("s", &terms, spring(300.0, 0.0)));
    light
        .elements
        .push(branch("m", &[(1, 1.0)], maxwell(600.0, 20.0)));
    light
        .elements
        .push(branch("ground", &[(0, 1.0)], spring(50.0, 0.0)));
    light.forces.push(push(0, Signal::harmonic(4.0, 3.0, 0.3)));
    let mut one = inertias(&[1.0]);
    one.elements
        .push(branch("m", &[(0, 1.0)], maxwell(200.0, 20.0)));
    one.elements.push(light.elements[2].clone());
    one.forces = light.forces.clone();
    let (_, exact, _) = by("exact", &one, &[0.1, 0.3, 0.0], 2.0, 100).unwrap();
    let (_, found, _) = run_with(
        "radau5",
        &light,
        &[0.1, 0.1, 0.3, 0.0, 0.0],
        2.0,
        100,
        StepSize::Adaptive(1e-10),
    )
    .unwrap();
    let there: Vec<Vec<f64>> = found.iter().map(|y| vec![y[0], y[2], y[4]]).collect();
    within("states", apart(&there, &exact), 1e-9);
    for y in &found {
        assert!((300.0 * (y[0] - y[1]) - y[4]).abs() < 1e-9, "{y:?}");
    }
}

/// What inertia of 1e-12 does is not seen: dampers without a common share in a row, a load that changes beside dampers, play with the
/// dampers of every convention; the methods that are exact take the small inertia.
#[test]
fn order_limit_of_no_inertia() {
    let row = |small: f64| {
        let mut model = inertias(&[2.0, small, small, 1.0]);
        let between = |i: usize| [(i, -1.0), (i + 1, 1.0)];
        model
            .elements
            .push(branch("s", &between(0), spring(300.0, 1.0)));
        model
            .elements
            .push(branch("u", &between(1), spring(100.0, 0.0)));
        model
            .elements
            .push(branch("v", &between(2), spring(100.0, 2.0)));
        model.forces.push(push(1, Signal::harmonic(3.0, 2.0, 0.5)));
        model
    };
    let play = |small: f64, contact_damping: ContactDamping| {
        let mut model = inertias(&[1.0, small]);
        let terms = [(0, -1.0), (1, 1.0)];
        model.elements.push(branch("s", &terms, spring(300.0, 0.5)));
        model.elements.push(branch(
            "play",
            &[(1, 1.0)],
            contact(600.0, 0.8, 0.02, contact_damping),
        ));
        model.forces.push(push(0, Signal::harmonic(4.0, 3.0, 0.3)));
        model
    };
    let compare =
        |name: &str, light: &DynamicModel, small: &DynamicModel, start: &[f64], to: f64| {
            let (_, found, _) =
                run_with("radau5", light, start, to, 60, StepSize::Adaptive(1e-9)).unwrap();
            let (_, exact, _) = by(name, small, start, to, 60).unwrap();
            let n = light.coordinate_count();
            let places = |s: &[Vec<f64>]| s.iter().map(|y| y[..n].to_vec()).collect::<Vec<_>>();
            apart(&places(&found), &places(&exact))
        };
    let start = [0.0; 8];
    let gap = compare("exact", &row(0.0), &row(1e-12), &start, 1.0);
    within("dampers in a row", gap, 1e-8);
    // The last where the disc goes back, beyond which the exact method switches to and fro.
    for (contact_damping, to) in [
        (ContactDamping::ActsInGap, 1.0),
        (ContactDamping::Adhesive, 1.0),
        (ContactDamping::NoPull, 1.0),
        (ContactDamping::Continuous, 0.1),
    ] {
        let (light, small) = (play(0.0, contact_damping), play(1e-12, contact_damping));
        let gap = compare("switched", &light, &small, &[0.0, 0.0, 0.3, 0.3], to);
        within(&format!("play, {contact_damping:?}"), gap, 1e-8);
    }
}

fn asked(until: f64, outputs: &[&str]) -> SimulateStudy {
    SimulateStudy {
        end_time: Some(until),
        outputs: outputs.iter().map(|s| s.to_string()).collect(),
        samples: Some(50),
        tolerance: Some(1e-9),
        energy: true,
        ..SimulateStudy::default()
    }
}

fn ready(
    text: &str,
    study: &SimulateStudy,
) -> Result<SimulationSetup, geardyn::internals::base::error::Error> {
    let head = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n";
    let scene = scene::read_text("test.toml", &format!("{head}{text}")).unwrap();
    SimulationSetup::new(&PreparedMachine::new(&scene.model)?, &scene.start, study)
}

/// Two discs, between them a shaft and a coupling that hardens; the node where these meet has the inertia J.
fn coupled(inertia: f64, c: f64) -> MotionResult {
    let text = format!(
        r#"
inertia = [{{ name = "a", J = 1.0 }}, {{ name = "n", J = {inertia} }}, {{ name = "b", J = 0.5 }}]
shaft = [{{ name = "s", between = ["a", "n"], k = 400.0, c = {c} }}]
coupling = [{{ name = "hard", between = ["n", "b"], c = {c}, characteristic = {{ kind = "power", torque = 30.0, deflection = 0.1, exponent = 3.0 }} }}]
load = [{{ at = "a", kind = "harmonic", torque = 20.0, frequency = "0.8 Hz" }}, {{ at = "n", kind = "ramp", torque = 6.0, between = [0.3, 0.8] }}]
"#
    );
    let study = asked(1.0, &["a", "n", "b", "s.force", "hard.force"]);
    let ready = ready(&text, &study).unwrap();
    let choice = method_choice::choose_method(&ready.model.model, &study).unwrap();
    assert_eq!(choice.method.name, "radau5");
    run::run(&ready, &choice, true, &CancelToken::default()).unwrap()
}

/// From a file: the motion is that of a program that takes the node out by hand (tools/reference_light.py); the shaft carries what the
/// coupling and the load leave it; the energy adds up.
/// Source: SciPy 1.17.1 (tools/reference_light.py).
#[test]
fn ref_hardening_coupling_behind_a_shaft() {
    let expected = reference("light");
    for c in [0.0, 0.4] {
        let history = coupled(0.0, c);
        for ((t, a), b) in history
            .time
            .iter()
            .zip(&history.values[3])
            .zip(&history.values[4])
        {
            let load = 6.0 * ((t - 0.3) / 0.5).clamp(0.0, 1.0);
            assert!((a - b - load).abs() < 1e-7, "{t}: {a} {b} {load}");
        }
        let gap = history.balance.unwrap().relative_error().abs();
        assert!(gap < 1e-6, "{gap:e}");
        if c > 0.0 {
            for (at, key) in ["a_rad", "n_rad", "b_rad"].into_iter().enumerate() {
                let exact = numbers(&expected[key]);
                assert_eq!(exact.len(), history.time.len());
                for (found, exact) in history.values[at].iter().zip(exact) {
                    within("angles, rad", (found - exact).abs(), 1e-8);
                }
            }
        }
    }
}

/// A load on a node of next to no inertia would throw it far in the time of a step: what it can do against its spring and damper
/// counts, else the tolerance would be one on motions that never come (23 steps and 0.03 rad wrong, at 1e-7).
#[test]
fn law_small_inertia_takes_no_tolerance_away() {
    let expected = reference("light");
    let history = coupled(1e-12, 0.4);
    for (at, key) in ["a_rad", "n_rad", "b_rad"].into_iter().enumerate() {
        let exact = numbers(&expected[key]);
        for (found, exact) in history.values[at].iter().zip(exact) {
            assert!((found - exact).abs() < 1e-7, "{key}: {found} {exact}");
        }
    }
}

/// A node that nothing holds, that Maxwell elements alone hold, that floats in its play; methods that divide by inertia.
#[test]
fn refuses_what_is_of_higher_index() {
    let refused = |text: &str| {
        let error = ready(text, &asked(1.0, &[])).err().unwrap();
        assert_eq!(error.code, Code::Conflict, "{error}");
        format!("{error} {}", error.hint.clone().unwrap_or_default())
    };
    let bodies = "inertia = [{ name = \"a\", J = 1.0 }, { name = \"n\", J = 0.0 }, { name = \"b\", J = 1.0 }]\n";
    let floats = refused(&format!(
        "{bodies}coupling = [{{ name = \"p\", between = [\"a\", \"n\"], k = 600.0, backlash = 0.02 }}, {{ name = \"r\", between = [\"n\", \"b\"], k = 600.0, backlash = 0.02 }}]"
    ));
    assert!(
        floats.contains("n.theta has no inertia") && floats.contains("higher index"),
        "{floats}"
    );
    assert!(floats.contains("a (small) inertia"), "{floats}");

    let mut model = inertias(&[1.0, 0.0]);
    let maxwell = ForceLaw::Maxwell {
        stiffness: 3.0,
        damping: 1.0,
    };
    model
        .elements
        .push(branch("m", &[(0, -1.0), (1, 1.0)], maxwell.clone()));
    model.elements.push(branch("g", &[(1, 1.0)], maxwell));
    assert_eq!(model.check_index_one(), Err(1));
    let error = by("radau5", &model, &[0.0; 6], 1.0, 4).unwrap_err();
    assert!(
        error.message.contains("x1") && error.hint.is_some(),
        "{error}"
    );

    let (model, _) = cubic(0.0);
    for method in methods::METHODS.iter().filter(|m| m.name != "radau5") {
        assert!(
            (method.unsupported_reason)(&model).is_some(),
            "{}",
            method.name
        );
    }
    let study = asked(1.0, &["n.theta.acceleration"]);
    let spring = "shaft = [{ name = \"s\", between = [\"a\", \"n\"], k = 300.0 }]\ncoupling = [{ name = \"p\", between = [\"n\", \"b\"], k = 600.0, backlash = 0.02 }]";
    let error = ready(&format!("{bodies}{spring}"), &study).err().unwrap();
    assert!(error.message.contains("no acceleration"), "{error}");
}

/// Twelve nodes in a row without inertia, two shafts between neighbours, made 8 192 springs of one: `1/k = Σ 1/(k₁ + k₂)`. The star of every
/// node keeps to as many branches as it has arms.
#[test]
fn survives_rows_of_parallel_shafts() {
    let names: Vec<String> = (0..14).map(|i| format!("n{i}")).collect();
    let body = |(i, name): (usize, &String)| {
        let inertia = if i == 0 || i == 13 { 0.5 } else { 0.0 };
        format!("{{ name = \"{name}\", J = {inertia:?} }}")
    };
    let bodies: Vec<String> = names.iter().enumerate().map(body).collect();
    let shafts: Vec<String> = (0..13)
        .flat_map(|i| {
            [3.0, 5.0].map(|k| {
                format!(
                    "{{ name = \"s{i}_{k}\", between = [\"n{i}\", \"n{}\"], k = {k:?} }}",
                    i + 1
                )
            })
        })
        .collect();
    let text = format!(
        "inertia = [{}]\nshaft = [{}]\n",
        bodies.join(", "),
        shafts.join(", ")
    );
    let ready = ready(&text, &asked(1.0, &["n0"])).unwrap();
    let model = &ready.model.model;
    assert_eq!((model.coordinate_count(), model.elements.len()), (2, 1));
    let ForceLaw::Linear { stiffness, .. } = model.elements[0].law else {
        panic!("{:?}", model.elements[0].law)
    };
    let a = model.elements[0]
        .direction
        .entries()
        .map(|t| t.1.abs())
        .fold(0.0, f64::max);
    assert!((stiffness * a * a * 13.0 / 8.0 - 1.0).abs() < 1e-13);
}

/// A lateral stage whose ring and planets have no inertia: springs between sun and carrier as `modes` has them, in bounded memory.
#[test]
fn law_stage_with_massless_ring_and_planets() {
    let text = std::fs::read_to_string("models/lin_parker_n4.toml").unwrap();
    let light: Vec<String> = text
        .split("\n\n")
        .map(|part| match part {
            p if p.contains("name = \"ring\"") => p
                .lines()
                .map(|l| match l.split(' ').next() {
                    Some("J") => "J = \"0 kg·m²\"".to_string(),
                    Some("mass") => "mass = \"0 kg\"".to_string(),
                    _ => l.to_string(),
                })
                .collect::<Vec<_>>()
                .join("\n"),
            p => p
                .lines()
                .map(|l| match l.split(' ').next() {
                    Some("planet_J") => "planet_J = \"0 kg·m²\"".to_string(),
                    Some("planet_mass") => "planet_mass = \"0 kg\"".to_string(),
                    _ => l.to_string(),
                })
                .collect::<Vec<_>>()
                .join("\n"),
        })
        .collect();
    let scene =
        scene::read_text("test.toml", &light.join("\n\n")).unwrap_or_else(|e| panic!("{e}"));
    let machine = PreparedMachine::new(&scene.model).unwrap();
    let study = asked(1e-3, &["sun"]);
    let ready = SimulationSetup::new(&machine, &scene.start, &study).unwrap();
    let model = &ready.model.model;
    // Sun and carrier, x, y and theta each.
    assert_eq!(model.coordinate_count(), 6);
    assert!(model.elements.len() < 60, "{}", model.elements.len());
    let mut k = geardyn::internals::numeric::Matrix::zeros(6, 6);
    for b in &model.elements {
        let ForceLaw::Linear { stiffness, .. } = b.law else {
            panic!("{:?}", b.law)
        };
        for (i, x) in b.direction.entries() {
            for (j, y) in b.direction.entries() {
                k[(i, j)] += stiffness * x * y;
            }
        }
    }
    let found = support::solve_model(&scene.model, &support::plain()).unwrap();
    let root = |i: usize| model.mass.entry(i, i).sqrt();
    let scaled =
        geardyn::internals::numeric::Matrix::from_fn(6, 6, |i, j| k[(i, j)] / (root(i) * root(j)));
    let mut own = geardyn::internals::numeric::symmetric::symmetric_eigen(&scaled)
        .unwrap()
        .values;
    own.sort_by(f64::total_cmp);
    for (k, mode) in found
        .answer
        .modes
        .iter()
        .enumerate()
        .filter(|(_, m)| !m.rigid)
    {
        let off = own[k].sqrt() / mode.omega() - 1.0;
        assert!(off.abs() < 1e-9, "mode {}: {off}", k + 1);
    }
}
