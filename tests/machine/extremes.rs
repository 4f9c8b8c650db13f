//! The scene at its extremes: the energy is added up along the motion, and verdicts mean what they say.

use std::f64::consts::PI;
use std::path::Path;

use geardyn::internals::base::code::Code;
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::motion::energy_balance::EnergyBalance;
use geardyn::internals::motion::methods;
use geardyn::internals::numeric::Complex;
use geardyn::internals::plan::motion::method_choice;
use geardyn::internals::plan::motion::run::{self, MotionResult};
use geardyn::internals::plan::motion::simulation_setup::SimulationSetup;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::scene::laws::MeshPhase;
use geardyn::internals::scene::study::SimulateStudy;
use geardyn::internals::scene::{self, Scene};
use geardyn::internals::study::monitor::Monitor;
use geardyn::internals::study::stability::amplification::{
    AmplificationChart, EXPLICIT_METHODS, METHODS, amplification_factors, stability_boundary,
    step_amplification,
};
use geardyn::internals::study::stability::linear::linear_stability;
use geardyn::internals::study::stability::perturbations::{MAX_WORK, PerturbedScene};
use geardyn::internals::study::stability::stress_test::{
    CaseMethods, CaseVerdict, MAX_ENERGY_ERROR, RequestedAccuracy, judge_balance, run_case,
    stress_test,
};

fn scene_of(text: &str) -> Scene {
    let head = "title = \"t\"\nsource = \"t\"\nunits = \"SI\"\n";
    scene::read_text("test.toml", &format!("{head}{text}")).unwrap()
}

fn ready(scene: &Scene, study: &SimulateStudy) -> SimulationSetup {
    let machine = PreparedMachine::new(&scene.model).unwrap();
    SimulationSetup::new(&machine, &scene.start, study).unwrap()
}

fn moved(ready: &SimulationSetup, study: &SimulateStudy) -> MotionResult {
    let choice = method_choice::choose_method(&ready.model.model, study).unwrap();
    run::run(ready, &choice, true, &CancelToken::default()).unwrap()
}

fn by(method: &str, until: f64) -> SimulateStudy {
    SimulateStudy {
        end_time: Some(until),
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
        assert!(
            balance.work_in > 0.1 && balance.dissipated > 1e-4,
            "{balance:?}"
        );
        assert!(
            balance.relative_error().abs() < within,
            "{method}: {:e}",
            balance.relative_error()
        );
        assert!(
            balance.error_bound().unwrap() < 1e-4,
            "{method}: {balance:?}"
        );
    }
}

/// However much faster the motion settles than the samples, the losses are found: of what a step puts in, half stays in the spring and
/// half is lost, in ten thousand swings or in an overdamped creep of 0.1 ms.
#[test]
fn law_fast_settling_is_seen() {
    for (inertia, damping) in [(1.0, 60.0), (1e-3, 4e5)] {
        let scene = scene_of(&format!(
            r#"
inertia = [{{ name = "disc", J = {inertia} }}]
shaft = [{{ name = "bar", between = ["ground", "disc"], k = 4e9, c = {damping} }}]
load = [{{ at = "disc", kind = "step", torque = 4e6, time = 0.0 }}]
"#
        ));
        let study = by("exact", 1.0);
        let ready = ready(&scene, &study);
        let balance = moved(&ready, &study).balance.unwrap();
        assert!((balance.work_in / 4000.0 - 1.0).abs() < 1e-7, "{balance:?}");
        assert!(
            (balance.dissipated / 2000.0 - 1.0).abs() < 1e-7,
            "{balance:?}"
        );
    }
}

/// The figure of the unchanged scene is the gap that `simulate --energy` prints, whatever the method.
#[test]
fn law_the_figure_is_that_of_the_simulation() {
    let scene = scene_of(PUSHED);
    for method in ["exact", "radau5", "dopri5", "generalized-alpha-controlled"] {
        let study = by(method, 0.2);
        let ready = ready(&scene, &study);
        let gap = moved(&ready, &study)
            .balance
            .unwrap()
            .relative_error()
            .abs();
        let as_it_is = PerturbedScene::new(&ready, method_choice::DEFAULT_TOLERANCE, 1e-3);
        let method = methods::method_by_name(method).unwrap();
        let case = run_case(
            "",
            method,
            (&as_it_is, ready.samples),
            &CancelToken::default(),
        )
        .unwrap();
        assert_eq!(case.energy_error, Some(gap), "{}", case.method);
        assert_eq!(case.verdict, CaseVerdict::Pass, "{}", case.method);
    }
}

/// With half of its energy missing no case passes: where that is known it has failed, where it is not it is refused.
#[test]
fn law_no_pass_without_knowing() {
    let lost = EnergyBalance {
        before: 1.0,
        peak_stored: 1.0,
        after: 0.5,
        evaluations: 700,
        ..EnergyBalance::default()
    };
    assert_eq!(
        judge_balance(&lost, RequestedAccuracy::Exact).0,
        CaseVerdict::Fail
    );
    let vague = EnergyBalance {
        quadrature_error: 0.6,
        ..lost
    };
    let (verdict, _, why) = judge_balance(&vague, RequestedAccuracy::Exact);
    assert_eq!(verdict, CaseVerdict::Refused);
    assert!(why.unwrap().contains("not conclusive"));
    let half = EnergyBalance {
        stopped_at: Some(0.5),
        ..lost
    };
    let (verdict, figure, why) = judge_balance(&half, RequestedAccuracy::Exact);
    assert_eq!((verdict, figure), (CaseVerdict::Refused, None));
    assert!(why.unwrap().contains("about 1400"));
    let fine = EnergyBalance {
        after: 1.0 - 0.5 * MAX_ENERGY_ERROR,
        ..lost
    };
    assert_eq!(
        judge_balance(&fine, RequestedAccuracy::Exact).0,
        CaseVerdict::Pass
    );
    let doubtful = EnergyBalance {
        quadrature_error: 0.6 * MAX_ENERGY_ERROR,
        ..fine
    };
    assert_eq!(
        judge_balance(&doubtful, RequestedAccuracy::Exact).0,
        CaseVerdict::Refused
    );
}

/// What a tolerance allows, added up over the steps, is no fault of the method: it is refused with the tolerance that would do.
/// More than that is.
#[test]
fn law_coarse_is_not_wrong() {
    let lost = EnergyBalance {
        before: 1.0,
        peak_stored: 1.0,
        after: 0.9,
        ..EnergyBalance::default()
    };
    let (verdict, _, why) = judge_balance(&lost, RequestedAccuracy::Tolerance(1e-2, 10));
    assert_eq!(verdict, CaseVerdict::Refused);
    assert!(why.unwrap().contains("about 1e-4"));
    assert_eq!(
        judge_balance(&lost, RequestedAccuracy::Tolerance(1e-8, 10)).0,
        CaseVerdict::Fail
    );
    let (verdict, _, why) = judge_balance(&lost, RequestedAccuracy::Step(0.1, 2));
    assert_eq!(verdict, CaseVerdict::Refused);
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
            end_time: Some(0.01),
            samples: Some(7),
            ..SimulateStudy::default()
        };
        let ready = ready(&scene, &study);
        let balance = moved(&ready, &study).balance.unwrap();
        let apart = balance.relative_error().abs() * balance.size();
        let turned = balance.work_in.abs().max(balance.dissipated);
        assert!(apart < 1e-6 * turned, "{name}: {apart} of {balance:?}");
    }
}

/// What a step makes of a mode, against what is known of each method: the limits of the explicit ones, none of the others; ρ at
/// infinity; and the method itself, which must multiply the energy of an undamped swing by the square of it in each step.
#[test]
fn law_amplification() {
    let at = |method: &str, re: f64, im: f64| {
        step_amplification(method, Complex::new(re, im), 1.0).unwrap()
    };
    // On the real axis Runge and Kutta's reaches 2.785, Dormand and Prince's 3.307 (Hairer and Wanner 1996, fig. 2.1).
    for (method, limit) in [("rk4", 2.785_293), ("dopri5", 3.306_6)] {
        assert!(at(method, -limit * 0.999, 0.0) < 1.0 && at(method, -limit * 1.001, 0.0) > 1.0);
    }
    for (method, last) in [
        ("radau5", 0.0),
        ("newmark", 1.0),
        ("hht", 0.8),
        ("generalized-alpha", 0.8),
    ] {
        assert!(
            (at(method, 0.0, 1e7) - last).abs() < 1e-4,
            "{method} {}",
            at(method, 0.0, 1e7)
        );
        for size in [1e-3, 0.1, 1.0, 3.0, 10.0, 1e3] {
            for angle in [0.5f64, 0.6, 0.8, 1.0] {
                let (im, re) = (PI * angle).sin_cos();
                let im = if angle == 1.0 { 0.0 } else { im };
                assert!(
                    at(method, size * re, size * im) <= 1.0 + 1e-7,
                    "{method} {size} {angle}"
                );
            }
        }
    }
    // To its order every one follows the mode.
    for method in METHODS {
        let off = (at(method, -0.01, 0.1) - (-0.01f64).exp()).abs();
        assert!(off < 1e-4, "{method} {off:e}");
    }
    let stiff = [Complex::new(-1.0, 1e6), Complex::new(-0.1, 10.0)];
    let all = amplification_factors(&stiff, 0.03).unwrap();
    assert!(all[0].fastest > 1e6 && all[3].fastest < 1e-3);
    assert!(all[5].added_damping > all[6].added_damping);
    // A radian a step of an undamped swing: Newmark's loses nothing, Chung and Hulbert's less than Hilber's of the same ρ.
    let [newmark, hht, generalized] =
        ["newmark", "hht", "generalized-alpha"].map(|m| at(m, 0.0, 1.0));
    assert!((newmark - 1.0).abs() < 1e-12 && hht < generalized && generalized < 0.9999);
}

/// A swing of 10 rad/s without damping.
const SWING: &str = r#"
inertia = [{ name = "disc", J = 2.0 }]
shaft = [{ name = "bar", between = ["ground", "disc"], k = 200.0 }]
"#;

/// An undamped swing by the method itself: after N steps its energy is what the factor of a step, squared, makes of it N times.
#[test]
fn law_amplification_is_what_the_method_does() {
    let scene = scene_of(SWING);
    for (method, h) in [
        ("rk4", 0.1),
        ("newmark", 0.1),
        ("hht", 0.1),
        ("generalized-alpha", 0.1),
    ] {
        let mut study = by(method, 20.0);
        study.step = Some(h);
        study.samples = Some(2);
        let mut ready = ready(&scene, &study);
        ready.initial_state[0] = 1e-3;
        let balance = moved(&ready, &study).balance.unwrap();
        let factor = step_amplification(method, Complex::new(0.0, 10.0), h).unwrap();
        let steps = 20.0 / h;
        let found = (balance.after / balance.before).ln() / (2.0 * steps);
        assert!(
            (found - factor.ln()).abs() < 2e-4,
            "{method} {found} {}",
            factor.ln()
        );
    }
}

/// A case beyond its budget is refused by what is counted, so alike every time, with the estimate of the whole; long before the budget
/// is spent where far more would be needed.
#[test]
fn law_refusals_are_counted() {
    let scene = scene_of(SWING);
    let study = by("dopri5", 1.0);
    let mut ready = ready(&scene, &study);
    ready.initial_state[0] = 1e-3;
    let mut long = PerturbedScene::new(&ready, 1e-8, 1e-3);
    long.end_time *= 1e7;
    for name in ["dopri5", "radau5", "generalized-alpha-controlled"] {
        let method = methods::method_by_name(name).unwrap();
        let case = || {
            run_case(
                "long",
                method,
                (&long, ready.samples),
                &CancelToken::default(),
            )
            .unwrap()
        };
        let (first, second) = (case(), case());
        assert_eq!(first.verdict, CaseVerdict::Refused, "{name}");
        assert_eq!(first.reason, second.reason);
        let why = first.reason.unwrap();
        let (spent, rest) = why
            .strip_prefix("the work of ")
            .unwrap()
            .split_once(' ')
            .unwrap();
        let spent: f64 = spent.parse().unwrap();
        assert!(spent < 0.2 * MAX_WORK as f64, "{why}");
        let (_, whole) = rest.split_once("the estimated total is about ").unwrap();
        let whole: f64 = whole.split_once(' ').unwrap().0.parse().unwrap();
        assert!(whole > 10.0 * MAX_WORK as f64, "{why}");
    }
}

/// A slow swing of the whole and a fast one within it, as quick but ten thousand times as small: what the controlled method takes from
/// their energy falls as a method of order 2 lets it with local errors of order 3, with the tolerance to the power 2/3, and is no more
/// than errors of the tolerance in each step allow.
#[test]
fn law_controlled_alpha_holds_small_fast_swings() {
    let scene = scene_of(
        r#"
inertia = [{ name = "near", J = 1.0 }, { name = "far", J = 1.0 }]
shaft = [
    { name = "soft", between = ["ground", "near"], k = 200.0 },
    { name = "stiff", between = ["near", "far"], k = 5e7 },
]
"#,
    );
    let mut gaps = Vec::new();
    for tolerance in [1e-2, 1e-5, 1e-8] {
        let mut study = by("generalized-alpha-controlled", 0.05);
        study.tolerance = Some(tolerance);
        let mut ready = ready(&scene, &study);
        ready.initial_state = vec![1.0, 1.0, 5.0, -5.0];
        let found = moved(&ready, &study);
        let gap = found.balance.unwrap().relative_error().abs();
        let allowed = 2.0 * tolerance * found.stats.steps as f64;
        assert!(gap < allowed, "{tolerance:e}: {gap:e} of {allowed:e}");
        gaps.push(gap);
    }
    // Steps are powers of two of a part of the time, so that the error of one is up to eight times below the tolerance.
    let slope = (gaps[0] / gaps[2]).log10() / 6.0;
    assert!((slope - 2.0 / 3.0).abs() < 0.15, "{gaps:?}");
}

/// Teeth that strike and let go with more than critical damping: a jump of the force behind the point at which a step looks is an error
/// of the step that it ends, so what is missing of the energy falls as in the swing above; left to the next step it would fall with
/// their length, by the tolerance to the power of a third.
#[test]
fn law_controlled_alpha_meets_switches_in_time() {
    let scene = scene_of(
        r#"
inertia = [{ name = "near", J = 1.0 }, { name = "far", J = 0.5 }]
shaft = [{ name = "spring", between = ["ground", "near"], k = 500.0, c = 1.0 }]
coupling = [{ name = "dogs", between = ["near", "far"], k = 4e4, c = 600.0, backlash = 0.04, contact_damping = "no-pull" }]
load = [{ at = "far", kind = "harmonic", torque = 40.0, frequency = 3.0 }]
"#,
    );
    let gaps = [1e-4, 1e-9].map(|tolerance| {
        let mut study = by("generalized-alpha-controlled", 2.0);
        study.tolerance = Some(tolerance);
        let ready = ready(&scene, &study);
        let balance = moved(&ready, &study).balance.unwrap();
        assert!(
            balance.error_bound().unwrap() < 0.1 * balance.relative_error().abs(),
            "{balance:?}"
        );
        balance.relative_error().abs()
    });
    let slope = (gaps[0] / gaps[1]).log10() / 5.0;
    assert!(slope > 0.55, "{gaps:?}: {slope}");
}

/// A mesh whose stiffness jumps over an angle brings energy in, ½ Δk δ² at each jump, whether a method ends a step there or not: with that
/// booked nothing is missing, and it is what makes the difference.
#[test]
fn law_steps_of_stiffness_over_an_angle_are_booked() {
    let mut scene = scene_of(
        r#"
inertia = [{ name = "p", J = 0.1 }, { name = "w", J = 0.2 }]
load = [{ at = "p", kind = "harmonic", torque = 3.0, frequency = 2.0 }]
[speed]
p = "40 rad/s"
[[gear_pair]]
name = "g"
between = ["p", "w"]
teeth = [20, 30]
module = 0.004
k = 1e6
c = 30.0
k_wave = { kind = "rectangular", high = 1.3, low = 0.7, share = 0.4 }
"#,
    );
    scene.start.phase = MeshPhase::Angle;
    for (method, within) in [
        ("radau5", 1e-7),
        ("dop853-events", 1e-7),
        ("dopri5", 1e-5),
        ("generalized-alpha-controlled", 1e-4),
    ] {
        let study = by(method, 0.5);
        let ready = ready(&scene, &study);
        let balance = moved(&ready, &study).balance.unwrap();
        assert!(
            balance.relative_error().abs() < within,
            "{method}: {balance:?}"
        );
    }
}

/// Linear facts are of all modes or of none; what neither swings nor decays has no growth.
#[test]
fn refused_facts_of_some_modes() {
    let discs = |n: usize| {
        let disc = |i: usize| format!("{{ name = \"d{i}\", J = 1.0 }}");
        let bar = |i: usize| {
            format!(
                "{{ name = \"s{i}\", between = [\"d{}\", \"d{i}\"], k = 1.0 }}",
                i - 1
            )
        };
        let discs: Vec<String> = (0..n).map(disc).collect();
        let bars: Vec<String> = (1..n).map(bar).collect();
        let scene = scene_of(&format!(
            "inertia = [{}]\nshaft = [{}]\nload = [{{ at = \"d0\", torque = 1.0 }}]\n",
            discs.join(", "),
            bars.join(", ")
        ));
        linear_stability(&PreparedMachine::new(&scene.model).unwrap(), None)
    };
    let Err(error) = discs(2001) else {
        panic!("facts of the lowest modes alone")
    };
    assert_eq!(error.code, Code::BudgetExceeded);
    assert!(error.message.contains("2001"), "{}", error.message);
    let rigid = discs(1).unwrap();
    assert!(rigid.spectral_abscissa == 0.0 && rigid.eigenvalues.is_empty());
}

/// A load that turns more often than double precision has phases is refused, as a swing of the machine is.
#[test]
fn refused_phases_of_loads() {
    let load = "load = [{ at = \"disc\", kind = \"harmonic\", torque = 1.0, frequency = 2.0 }]";
    let scene = scene_of(&format!(
        "inertia = [{{ name = \"disc\", J = 1.0 }}]\n{load}\n"
    ));
    for (until, taken) in [(1e10, true), (1e14, false)] {
        let study = by("exact", until);
        let ready = ready(&scene, &study);
        let choice = method_choice::choose_method(&ready.model.model, &study).unwrap();
        let ran = run::run(&ready, &choice, false, &CancelToken::default());
        assert_eq!(ran.is_ok(), taken, "{until}");
        if let Err(error) = ran {
            assert_eq!(error.code, Code::BudgetExceeded, "{}", error.message);
        }
    }
}

/// A method that cannot take the machine is left out once, with the reason, and is tried in no case.
#[test]
fn law_methods_that_cannot_are_left_out() {
    let scene = scene_of(
        r#"
inertia = [{ name = "disc", J = 1.0 }]
coupling = [{ name = "rubber", between = ["ground", "disc"], k = 100.0, maxwell = [{ k = 50.0, c = 5.0 }] }]
load = [{ at = "disc", kind = "step", torque = 1.0, time = 0.0 }]
"#,
    );
    let study = by("radau5", 0.1);
    let ready = ready(&scene, &study);
    let names = ["newmark", "radau5"].map(String::from);
    let methods = CaseMethods::new(&ready, &study, &names).unwrap();
    let [(name, why)] = &methods.unsupported[..] else {
        panic!("{:?}", methods.unsupported);
    };
    assert!(*name == "newmark" && why.contains("inner state"), "{why}");
    let cancel = CancelToken::default();
    let mut monitor = Monitor {
        cancel: &cancel,
        on_progress: &mut |_| (),
    };
    let cases = stress_test(&ready, &study, &methods, &mut monitor);
    assert!(cases.len() > 5 && cases.iter().all(|c| c.method == "radau5"));
    assert_eq!(cases[0].verdict, CaseVerdict::Pass);
}

/// On the curve around a region a step neither grows nor shrinks a mode; Radau's keeps clear of the left half-plane. The spectrum
/// holds what a step makes of each mode.
#[test]
fn law_regions_are_bounded_by_one() {
    for (method, leftmost) in [("rk4", -2.785_3), ("dopri5", -3.306_6), ("radau5", 0.0)] {
        let curve = stability_boundary(method);
        let least = curve.iter().map(|z| z.re).fold(0.0, f64::min);
        assert!((least - leftmost).abs() < 1e-4, "{method}: {least}");
        assert!(curve.last().unwrap().im < 0.0 && curve.len() > 300);
        for z in &curve {
            let factor = step_amplification(method, *z, 1.0).unwrap();
            assert!((factor - 1.0).abs() < 1e-9, "{method} at {z}: {factor}");
        }
    }
    assert!(stability_boundary("newmark").is_empty());
    let modes = [Complex::new(0.0, 0.0), Complex::new(-1.0, 200.0)];
    let found = AmplificationChart::new(&modes, 0.01).unwrap();
    for course in &found.methods {
        let expected = step_amplification(course.method, modes[1], 0.01).unwrap();
        assert_eq!(course.eigenvalues.len(), 1);
        assert!((course.eigenvalues[0].1 / expected - 1.0).abs() < 1e-12);
        assert_eq!(
            course.conditionally_stable,
            EXPLICIT_METHODS.contains(&course.method)
        );
    }
}

/// A step of 1 N·m on two discs twists the shaft between them by `(T/J₁ω²)(1 − cos ωt)`, `ω² = k (1/J₁ + 1/J₂)`, 2T/(J₁ω²) at most. With
/// nine samples a period the largest of them is 1.3 % less.
#[test]
fn exact_extremes_between_samples() {
    let text = "inertia = [{ name = \"a\", J = 2.0 }, { name = \"b\", J = 3.0 }]\n\
                shaft = [{ name = \"bar\", between = [\"a\", \"b\"], k = 200.0 }]\n\
                load = [{ at = \"a\", torque = 1.0 }]";
    let (omega, size) = ((200.0f64 * 5.0 / 6.0).sqrt(), 6.0 / (200.0 * 5.0));
    for method in ["exact", "dop853", "radau5", "newmark"] {
        let mut study = by(method, 0.45);
        study.samples = Some(8);
        study.step = (method == "newmark").then_some(1e-4);
        study.outputs = vec!["bar.deflection".to_string()];
        let found = moved(&ready(&scene_of(text), &study), &study).statistics[0].unwrap();
        let (value, at) = match found.max.0 > -found.min.0 {
            true => found.max,
            false => (-found.min.0, found.min.1),
        };
        assert!(
            (value / size - 1.0).abs() < 2e-5,
            "{method}: {value} {size}"
        );
        assert!((at * omega / PI - 1.0).abs() < 1e-4, "{method}: {at}");
    }
}
