//! Transmission error of a chain: worked by hand, rigid against elastic joints, slow against at speed, loops that fit and do not.

use crate::support;
use crate::support::machines::Random;
use crate::support::within;
use geardyn::internals::base::code::Code;
use geardyn::internals::base::error::Error;
use geardyn::internals::numeric::Complex;
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::transmission::{
    result::{OrderLineResult, TransmissionResult},
    run::run,
};
use geardyn::internals::report::te_lines::ARCSEC;
use geardyn::internals::scene::study::{IndexingStudy, TransmissionStudy};
use geardyn::internals::transmission::coincidence::SeparationTest;
use geardyn::internals::transmission::indexing::IndexingEffect;

const HEAD: &str = "title = \"test\"\nsource = \"made for a test\"\nunits = \"SI\"\n";

fn written(text: &str) -> PreparedMachine {
    let scene = geardyn::internals::scene::read_text("test.toml", &format!("{HEAD}{text}"))
        .unwrap_or_else(|e| panic!("{e}\n{text}"));
    PreparedMachine::new(&scene.model).unwrap()
}

fn shipped(path: &str) -> PreparedMachine {
    let scene = geardyn::internals::scene::read(std::path::Path::new(path)).unwrap();
    PreparedMachine::new(&scene.model).unwrap()
}

fn study(driver: &str, output: &str) -> TransmissionStudy {
    TransmissionStudy {
        driver: Some(driver.to_string()),
        output: Some(output.to_string()),
        ..TransmissionStudy::default()
    }
}

fn traced(machine: &PreparedMachine, study: &TransmissionStudy) -> TransmissionResult {
    run(machine, study).unwrap()
}

fn refused(text: &str, study: &TransmissionStudy) -> Error {
    match geardyn::internals::scene::read_text("test.toml", &format!("{HEAD}{text}")) {
        Err(errors) => errors.as_slice()[0].clone(),
        Ok(scene) => match PreparedMachine::new(&scene.model).and_then(|p| run(&p, study)) {
            Err(error) => error,
            Ok(_) => panic!("this was answered:\n{text}"),
        },
    }
}

fn close(a: Complex, b: Complex, tolerance: f64) -> bool {
    (a - b).norm() <= tolerance * b.norm()
}

/// Orders and amplitude worked by hand (data/reference/chain_orders.json).
#[test]
fn exact_generator_chain() {
    let prepared_machine = shipped("models/three_stage_chain.toml");
    let result = traced(&prepared_machine, &study("shaft_1", "spindle"));
    let machine = &prepared_machine.machine;
    let reference = support::reference("chain_orders");
    let expected = [
        ("spindle", "cumulative-pitch", "spindle"),
        ("shaft_3 in second", "eccentricity", "shaft_3"),
        ("shaft_3 in worm_drive", "profile", "worm mesh"),
        ("shaft_2 in first", "eccentricity", "shaft_2"),
        ("shaft_2 in second", "profile", "mesh 30/75"),
        ("shaft_1", "eccentricity", "shaft_1"),
        ("shaft_1", "profile", "mesh 24/60"),
    ];
    for (on, of, key) in expected {
        let row = result
            .lines
            .iter()
            .find(|r| r.source(machine) == on && r.cause(machine) == of)
            .unwrap();
        assert_eq!(
            row.line.order.to_string(),
            reference["orders"][key].as_str().unwrap(),
            "{on} {of}"
        );
    }
    let eccentric = result
        .lines
        .iter()
        .find(|r| r.source(machine) == "shaft_3 in second" && r.cause(machine) == "eccentricity")
        .unwrap();
    let wanted = support::number(&reference["eccentricity"]["spindle_arcsec"]);
    let found = result.quasi_static(eccentric).norm() * ARCSEC;
    // By hand 206.265 and 105.715 were used; the exact values have more digits.
    let base = 75.0 * 3.0 * (std::f64::consts::PI / 9.0).cos() / 2.0;
    let by_hand = found * (206.265e3 / ARCSEC) * (base / 105.715);
    within(
        "eccentricity with the rounded constants of the hand, arcsec",
        (by_hand - wanted).abs(),
        1e-13,
    );
    within(
        "eccentricity, arcsec",
        (found - 1e-2 / base * ARCSEC / 45.0).abs(),
        1e-14,
    );
    // The pitch of the wheel, 12 µm at r = 270 mm; the worm's axis, 3 µm over the same.
    let pitch = result.quasi_static(&result.lines[0]).norm();
    within(
        "pitch error at the spindle",
        (pitch * 0.27 / 12e-6 - 1.0).abs(),
        1e-13,
    );
    let axial = result
        .lines
        .iter()
        .find(|r| r.cause(machine) == "axial")
        .unwrap();
    within(
        "axial error at the spindle",
        (result.quasi_static(axial).norm() * 0.27 / 3e-6 - 1.0).abs(),
        1e-13,
    );
    let total: f64 = result.lines.iter().map(|r| r.share).sum();
    assert!((total - 1.0).abs() < 1e-14);
    assert_eq!(result.period.unwrap().to_string(), "4");
}

/// A chain of pairs whose common period has more than twelve digits; nothing is rounded.
#[test]
fn survives_periods_beyond_count() {
    let mut text = String::new();
    let teeth = [997, 991, 983, 977, 971, 967, 953, 947];
    for k in 0..=teeth.len() / 2 {
        text += &format!(
            "[[inertia]]\nname = \"s{k}\"\nJ = 0.01\n[[error]]\non = \"s{k}\"\namplitude = 1e-6\nphase = \"unknown\"\n"
        );
    }
    for k in 0..teeth.len() / 2 {
        let (a, b) = (teeth[2 * k], teeth[2 * k + 1]);
        text += &format!(
            "[[gear_pair]]\nname = \"g{k}\"\nbetween = [\"s{k}\", \"s{}\"]\nteeth = [{a}, {b}]\nmodule = 0.002\nk = 1e8\n",
            k + 1
        );
    }
    let result = traced(&written(&text), &study("s0", "s4"));
    let period = result.period.unwrap();
    let product: u128 = [991u128, 977, 967, 947].iter().product();
    // Orders are b₁b₂…/a₁a₂… of primes: they come back together after the product of the first teeth.
    let wanted: u128 = [997u128, 983, 971, 953].iter().product();
    assert_eq!(period.to_string(), wanted.to_string(), "{product}");
    let fastest = result
        .lines
        .iter()
        .find(|r| r.line.order.to_string() == format!("{product}/{wanted}"));
    assert!(fastest.is_some());
}

/// A random chain: pairs and shafts in a row, errors of every sort, some with loads.
fn chain(random: &mut Random, stiffness: f64) -> String {
    let mut text = String::new();
    let n = 2 + random.below(4);
    for k in 0..=n {
        for end in ["a", "b"] {
            text += &format!(
                "[[inertia]]\nname = \"{end}{k}\"\nJ = {}\n",
                random.between(1e-3, 1e-1)
            );
        }
        text += &format!(
            "[[shaft]]\nname = \"t{k}\"\nbetween = [\"a{k}\", \"b{k}\"]\nk = {}\nc = 0.5\n",
            stiffness * random.between(1e3, 1e5)
        );
    }
    for k in 0..n {
        let (a, b) = (17 + random.below(60), 17 + random.below(60));
        let helix = 0.4 * random.unit();
        text += &format!(
            "[[gear_pair]]\nname = \"g{k}\"\nbetween = [\"b{k}\", \"a{}\"]\nteeth = [{a}, {b}]\nmodule = 0.003\nhelix_angle = {helix}\nk = {}\nc = 200\n",
            k + 1,
            stiffness * random.between(1e7, 1e9)
        );
        let cause = [
            "eccentricity",
            "seat",
            "run-out",
            "cumulative-pitch",
            "profile",
            "form",
        ][random.below(6)];
        let on = [format!("b{k}"), format!("a{}", k + 1)][random.below(2)].clone();
        text += &format!(
            "[[error]]\non = \"{on}\"\ncause = \"{cause}\"\namplitude = {}\nphase = {}\n",
            random.between(1e-6, 2e-5),
            6.0 * random.unit()
        );
    }
    text += &format!(
        "[[load]]\nat = \"b{n}\"\ntorque = {}\n",
        random.between(10.0, 500.0)
    );
    text
}

/// On trees the elastic joints pass on what rigid ones do, and what the loads wind up goes with 1/k.
#[test]
fn law_loaded_becomes_kinematic_on_random_chains() {
    let mut random = Random::new(7);
    for _ in 0..40 {
        let text = chain(&mut random, 1.0);
        let n = text.matches("[[shaft]]").count() - 1;
        let machine = written(&text);
        let result = traced(&machine, &study("a0", &format!("b{n}")));
        assert!(result.wind_up != 0.0);
        for row in &result.lines {
            assert!(
                close(row.loaded, row.line.quasi_static, 1e-9),
                "{text}\n{:?} {:?}",
                row.loaded,
                row.line.quasi_static
            );
        }
    }
}

/// At ω → 0 the dynamic transmission is the static one, on chains and in a loop.
#[test]
fn law_dynamic_becomes_loaded_at_rest() {
    let mut random = Random::new(11);
    let mut machines: Vec<(String, String)> = (0..20)
        .map(|_| {
            let text = chain(&mut random, 1.0);
            let n = text.matches("[[shaft]]").count() - 1;
            ("a0".to_string(), format!("b{n}")).1.clone() + "\n" + &text
        })
        .map(|both| {
            both.split_once('\n')
                .map(|(out, text)| (out.to_string(), text.to_string()))
                .unwrap()
        })
        .collect();
    machines.push(("out".to_string(), looped(1.0, 1.3e-5)));
    for (output, text) in machines {
        let machine = written(&text);
        let driver = if output == "out" { "motor" } else { "a0" };
        let slow = TransmissionStudy {
            speed: Some(1e-8),
            ..study(driver, &output)
        };
        let fast = TransmissionStudy {
            speed: Some(300.0),
            ..study(driver, &output)
        };
        let mut differs = false;
        for row in traced(&machine, &slow).lines {
            // Damping makes the first difference, of the order of ω c/k.
            assert!(
                close(row.dynamic.unwrap(), row.loaded, 1e-9),
                "{text}\n{:?} {:?}",
                row.dynamic,
                row.loaded
            );
        }
        for row in traced(&machine, &fast).lines {
            differs |= !close(row.dynamic.unwrap(), row.loaded, 1e-3);
        }
        assert!(differs, "{text}");
    }
}

/// Two pairs of equal ratio side by side, and a pair behind them. `second` is the error of the second pinion: at 1e-5 · 32/24 · 4/4.5
/// it fits that of the first.
fn looped(stiffness: f64, second: f64) -> String {
    let k = |k: f64| k * stiffness;
    format!(
        "inertia = [{}]\n\
         shaft = [\n{{ name = \"ps\", between = [\"p1\", \"p2\"], k = {:e} }},\n{{ name = \"ws\", between = [\"w1\", \"w2\"], k = {:e} }},\n{{ name = \"ms\", between = [\"motor\", \"p1\"], k = {:e}, c = 0.01 }},\n]\n\
         gear_pair = [\n{{ name = \"one\", between = [\"p1\", \"w1\"], teeth = [24, 36], module = 0.0045, k = {:e}, k_wave = {{ kind = \"rectangular\", high = 1.2, low = 0.8, share = 0.5 }} }},\n\
         {{ name = \"two\", between = [\"p2\", \"w2\"], teeth = [32, 48], module = 0.004, k = {:e} }},\n\
         {{ name = \"three\", between = [\"w2\", \"out\"], teeth = [20, 61], module = 0.004, k = {:e} }},\n]\n\
         error = [\n{{ on = \"p1\", amplitude = 1e-5, phase = 0.7 }},\n{{ on = \"p2\", amplitude = {second}, phase = 0.7 }},\n{{ on = \"out\", amplitude = 1e-5, phase = \"unknown\" }},\n]\n\
         load = [{{ at = \"out\", torque = 300 }}]\n",
        ["motor", "p1", "w1", "p2", "w2", "out"]
            .map(|n| format!("{{ name = \"{n}\", J = 0.01 }}"))
            .join(", "),
        k(2e4),
        k(5e4),
        k(1e4),
        k(3e8),
        k(5e8),
        k(4e8),
    )
}

/// The fitting error of the second pinion, m.
const FITS: f64 = 1e-5 * (32.0 * 0.004) / (24.0 * 0.0045);

/// A loop whose errors fit: loaded becomes kinematic as k → ∞, mesh stiffness and wind-up under torque included.
#[test]
fn law_loaded_becomes_kinematic_in_a_loop_that_fits() {
    let mut last = f64::INFINITY;
    for stiffness in [1.0, 1e4, 1e8, 1e12] {
        let result = traced(&written(&looped(stiffness, FITS)), &study("motor", "out"));
        assert!(result.inconsistent_loop.is_none());
        let size = result
            .lines
            .iter()
            .map(|r| r.line.quasi_static.norm())
            .fold(0.0, f64::max);
        // A rigid loop says what its errors do together, not what each does.
        let of_order = |order: &str, of: fn(&OrderLineResult) -> Complex| {
            let rows = result
                .lines
                .iter()
                .filter(|r| r.line.order.to_string() == order);
            rows.map(of).fold(Complex::ZERO, |s, z| s + z)
        };
        let orders: Vec<String> = result
            .lines
            .iter()
            .map(|r| r.line.order.to_string())
            .collect();
        let apart = orders
            .iter()
            .map(|o| (of_order(o, |r| r.loaded) - of_order(o, |r| r.line.quasi_static)).norm());
        let off = apart.fold(result.wind_up.abs(), f64::max);
        assert!(
            off < 1e-3 * last || off < 1e-9 * size,
            "{stiffness}: {off} of {size}, before {last}"
        );
        last = off;
        let at_mesh = result
            .lines
            .iter()
            .any(|r| r.line.quasi_static.norm() == 0.0 && r.loaded.norm() > 0.0);
        assert!(at_mesh, "the stiffness wave of the loaded mesh has lines");
    }
    assert!(last < 1e-9 * 1e-4);
}

/// The same in loops of random teeth, modules, stiffnesses, errors that fit and load: at ω → 0, and as k → ∞.
#[test]
fn law_loaded_becomes_kinematic_in_random_loops() {
    let mut random = Random::new(23);
    for _ in 0..12 {
        let (a, b) = (17 + random.below(20), 30 + random.below(40));
        let m = [random.between(2e-3, 4e-3), random.between(2e-3, 4e-3)];
        let more = 1 + random.below(3);
        let (error, torque) = (random.between(2e-6, 2e-5), random.between(50.0, 500.0));
        let fits = error * (a * more) as f64 * m[1] / (a as f64 * m[0]);
        let k: Vec<f64> = (0..5).map(|_| random.between(1.0, 10.0)).collect();
        let machine = |stiffness: f64| {
            let k = |i: usize, base: f64| stiffness * base * k[i];
            let bodies = ["motor", "p1", "w1", "p2", "w2"]
                .map(|n| format!("{{ name = \"{n}\", J = 0.01 }}"))
                .join(", ");
            format!(
                "inertia = [{bodies}]\nshaft = [\n{{ name = \"ps\", between = [\"p1\", \"p2\"], k = {:e} }},\n{{ name = \"ws\", between = [\"w1\", \"w2\"], k = {:e} }},\n{{ name = \"ms\", between = [\"motor\", \"p1\"], k = {:e}, c = 0.01 }},\n]\n\
                 gear_pair = [\n{{ name = \"one\", between = [\"p1\", \"w1\"], teeth = [{a}, {b}], module = {}, k = {:e} }},\n{{ name = \"two\", between = [\"p2\", \"w2\"], teeth = [{}, {}], module = {}, k = {:e} }},\n]\n\
                 error = [\n{{ on = \"p1\", amplitude = {error:e}, phase = 0.7 }},\n{{ on = \"p2\", amplitude = {fits:e}, phase = 0.7 }},\n]\nload = [{{ at = \"w2\", torque = {torque} }}]\n",
                k(0, 1e4),
                k(1, 1e4),
                k(2, 1e4),
                m[0],
                k(3, 1e8),
                a * more,
                b * more,
                m[1],
                k(4, 1e8),
            )
        };
        let sum = |rows: &[OrderLineResult], of: &dyn Fn(&OrderLineResult) -> Complex| {
            rows.iter().map(of).fold(Complex::ZERO, |s, z| s + z)
        };
        let stiff = traced(&written(&machine(1e12)), &study("motor", "w2"));
        let kinematic = sum(&stiff.lines, &|r| r.line.quasi_static);
        let loaded = sum(&stiff.lines, &|r| r.loaded);
        assert!(close(loaded, kinematic, 1e-9), "{loaded} {kinematic}");
        assert!(stiff.wind_up.abs() < 1e-9 && stiff.wind_up != 0.0);
        let slow = TransmissionStudy {
            speed: Some(1e-8),
            ..study("motor", "w2")
        };
        for row in traced(&written(&machine(1.0)), &slow).lines {
            assert!(close(row.dynamic.unwrap(), row.loaded, 1e-9));
        }
    }
}

/// A loop whose errors do not fit has no rigid answer: refused where its joints are rigid, shared out where they give way.
#[test]
fn refuses_loops_that_do_not_fit() {
    let result = traced(&written(&looped(1.0, 1.1 * FITS)), &study("motor", "out"));
    let names = result.inconsistent_loop.clone().unwrap();
    assert!(
        names.contains(&"one".to_string()) && names.contains(&"two".to_string()),
        "{names:?}"
    );
    assert!(result.diagnostics.iter().any(|w| w.code == "loop-misfit"));
    assert!(result.budget.rss > 0.0);
    let mut rigid: String = looped(1.0, 1.1 * FITS);
    for k in ["2e4", "5e4", "3e8", "5e8"] {
        rigid = rigid.replace(&format!(", k = {k}"), "");
    }
    let rigid = rigid.replace(
        ", k_wave = { kind = \"rectangular\", high = 1.2, low = 0.8, share = 0.5 }",
        "",
    );
    let error = refused(&rigid, &study("motor", "out"));
    assert_eq!(error.code, Code::ContradictoryRatios, "{error}");
    assert!(error.message.contains("do not fit"), "{error}");
}

/// A loop whose ratios differ does not turn, however its meshes yield: the loop and both ratios are named.
#[test]
fn refuses_elastic_loops_of_other_ratios() {
    let body = |name: &str| format!("[[inertia]]\nname = \"{name}\"\nJ = 0.1\n");
    let pair = |name: &str, ends: &str, teeth: &str| {
        format!(
            "[[gear_pair]]\nname = \"{name}\"\nbetween = {ends}\nteeth = {teeth}\nmodule = 0.003\nk = 1e8\n"
        )
    };
    let ends = "[\"a\", \"b\"]";
    let two = format!(
        "{}{}{}{}",
        body("a"),
        body("b"),
        pair("first", ends, "[20, 40]"),
        pair("second", ends, "[21, 40]")
    );
    let yielding =
        format!("{two}[[error]]\non = \"b\"\ncause = \"eccentricity\"\namplitude = 1e-5\n");
    let error = refused(&yielding, &study("a", "b"));
    assert_eq!(error.code, Code::ContradictoryRatios, "{error}");
    for word in ["`first`", "`second`", "-1/2", "-21/40"] {
        assert!(error.message.contains(word), "{error}");
    }
    let error = geardyn::internals::machine::kinematics::mean_speeds(
        &written(&two).machine,
        &written(&two).kinematics,
        Some(1.0),
    );
    assert_eq!(error.unwrap_err().code, Code::ContradictoryRatios);
}

/// An idler between two gears passes its eccentricity on twice, by where its meshes stand. By hand: the driver turns forward and pushes the
/// idler's left side up, by n₁ = (sin α, cos α); the idler turns back and pushes the third gear at ψ by n₂ = (sin α cos ψ + cos α sin ψ,
/// sin α sin ψ − cos α cos ψ). Off its axis by d it carries the third gear on by (n₂ − n₁)·d along the line of action: in a straight row by
/// twice d cos α, the force on the idler's bearing. Without play nothing says that the second mesh carries on its other flank, and its own
/// n₂ = (sin α cos ψ − cos α sin ψ, sin α sin ψ + cos α cos ψ) of the drive flank pushes back: (n₂ + n₁)·d.
#[test]
fn exact_eccentric_idler() {
    let text = |angle: f64, play: &str| {
        format!(
            "inertia = [{{ name = \"a\", J = 0.1 }}, {{ name = \"i\", J = 0.1 }}, {{ name = \"c\", J = 0.1 }}]\n\
         gear_pair = [\n{{ name = \"one\", between = [\"a\", \"i\"], teeth = [20, 30], module = 0.002, k = 1e8, mesh_angles = [0, {}]{play} }},\n\
         {{ name = \"two\", between = [\"i\", \"c\"], teeth = [30, 40], module = 0.002, k = 1e8, mesh_angles = [{angle}, 0]{play} }}]\n\
         error = [{{ on = \"i\", cause = \"eccentricity\", amplitude = 1e-5, phase = 0 }}]\n\
         load = [{{ at = \"a\", torque = 25 }}, {{ at = \"c\", torque = -50 }}]\n",
            std::f64::consts::PI
        )
    };
    let base = 0.02 * (std::f64::consts::PI / 9.0).cos() * 2.0;
    let (sin, cos) = (std::f64::consts::PI / 9.0).sin_cos();
    for angle in [0.0f64, 0.5, 2.0, -1.2] {
        let (s, c) = angle.sin_cos();
        let first = Complex::new(sin, cos);
        let other = Complex::new(sin * c + cos * s, sin * s - cos * c);
        let drive = Complex::new(sin * c - cos * s, sin * s + cos * c);
        for (play, wanted) in [(", backlash = 1e-5", other - first), ("", drive + first)] {
            let result = traced(&written(&text(angle, play)), &study("a", "c"));
            let found = result.lines[0].line.quasi_static.norm() * base / 1e-5;
            within(
                "amplitude of the idler",
                (found - wanted.norm()).abs(),
                1e-12,
            );
        }
    }
}

/// Sources of one order are found by arithmetic, and the test named tells them apart.
#[test]
fn exact_coincidences() {
    let machine = shipped("models/three_stage_chain.toml");
    let result = traced(&machine, &study("shaft_1", "spindle"));
    let orders: Vec<String> = result
        .coincidences
        .iter()
        .map(|c| result.lines[c.lines[0]].line.order.to_string())
        .collect();
    assert_eq!(orders, ["45", "225/2"]);
    // On one shaft only the other flanks part them; across a mesh re-meshing does.
    let text = "inertia = [{ name = \"a\", J = 0.1 }, { name = \"b\", J = 0.1 }]\n\
        gear_pair = [{ name = \"pair\", between = [\"a\", \"b\"], teeth = [26, 26], module = 0.002, k = 1e8 }]\n\
        error = [{ on = \"a\", amplitude = 1e-5 }, { on = \"b\", amplitude = 1e-5, phase = \"unknown\" }]\n";
    let result = traced(&written(text), &study("a", "b"));
    let [SeparationTest::Remesh { teeth, shift, .. }] = &result.coincidences[0].tests[..] else {
        panic!("{:?}", result.coincidences);
    };
    assert_eq!((*teeth, *shift), (13, 0.5));
}

/// Pitch tables: the right count, the mean taken off, once round.
#[test]
fn refuses_what_cannot_be() {
    let pair = |error: &str| {
        format!(
            "inertia = [{{ name = \"a\", J = 0.1 }}, {{ name = \"b\", J = 0.1 }}]\n\
         gear_pair = [{{ name = \"pair\", between = [\"a\", \"b\"], teeth = [4, 8], module = 0.002, k = 1e8 }}]\n\
         coupling = [{{ name = \"c\", between = [\"a\", \"ground\"], k = 0 }}]\n\
         error = [{error}]\n"
        )
    };
    let ask = study("a", "b");
    for (error, code, word) in [
        (
            "{ on = \"a\", cause = \"single-pitch\", values = [1e-6, 2e-6, 1e-6] }",
            Code::OutOfRange,
            "4 teeth",
        ),
        (
            "{ on = \"a\", cause = \"eccentricity\", amplitude = 1e-6, order = 3 }",
            Code::Conflict,
            "eccentricity",
        ),
        (
            "{ on = \"a\", cause = \"eccentric\", amplitude = 1e-6 }",
            Code::OutOfRange,
            "cause",
        ),
        (
            "{ on = \"a\", amplitude = nan }",
            Code::OutOfRange,
            "amplitude",
        ),
        ("{ on = \"a\" }", Code::MissingKey, "amplitude"),
        (
            "{ on = \"a\", amplitude = 1e-6, values = [1, 2] }",
            Code::Conflict,
            "values",
        ),
        (
            "{ on = \"a\", cause = \"axial\", amplitude = 1e-6 }",
            Code::Conflict,
            "worm",
        ),
        (
            "{ on = \"pair\", cause = \"misalignment\", tilt = 0.02 }",
            Code::UnknownNode,
            "coupling",
        ),
        (
            "{ on = \"a\", file = \"no_such_file.csv\", file_unit = \"µm\" }",
            Code::FileMissing,
            "no_such_file",
        ),
        (
            "{ on = \"nobody\", amplitude = 1e-6 }",
            Code::UnknownNode,
            "nobody",
        ),
    ] {
        let found = refused(&pair(error), &ask);
        assert!(found.code == code, "{error}: {found}");
        assert!(found.to_string().contains(word), "{error}: {found}");
    }
    assert_eq!(refused(&pair(""), &ask).code, Code::MissingKey);
    let on_a = "{ on = \"a\", amplitude = 1e-6 }";
    assert_eq!(
        refused(&pair(on_a), &study("a", "nowhere")).code,
        Code::UnknownNode
    );
    assert_eq!(
        refused(&pair(on_a), &TransmissionStudy::default()).code,
        Code::Usage
    );
    assert_eq!(refused(&pair(on_a), &study("a", "a")).code, Code::Conflict);
    let apart = pair(on_a).replace("inertia = [", "shaft = [{ name = \"s\", between = [\"x\", \"y\"], k = 1 }]\ninertia = [{ name = \"x\", J = 1 }, { name = \"y\", J = 1 }, ");
    assert_eq!(
        refused(&apart, &study("a", "x")).code,
        Code::UndeterminedSpeed
    );
}

/// A joint at an angle turns unevenly by atan(tan φ / cos β) − φ: the two terms kept are right to the sixth power of the angle.
#[test]
fn exact_misaligned_joint() {
    let beta = 0.1f64;
    let text = format!(
        "inertia = [{{ name = \"a\", J = 0.1 }}, {{ name = \"b\", J = 0.1 }}]\n\
         coupling = [{{ name = \"joint\", between = [\"a\", \"b\"], k = 1e5 }}]\n\
         error = [{{ on = \"joint\", cause = \"misalignment\", tilt = {beta} }}]\n"
    );
    let result = traced(&written(&text), &study("a", "b"));
    assert_eq!(
        result
            .lines
            .iter()
            .map(|r| r.line.order.to_string())
            .collect::<Vec<_>>(),
        ["2", "4"]
    );
    for k in 0..50 {
        let phi = 0.13 * f64::from(k);
        let exact = (phi.sin() / beta.cos()).atan2(phi.cos()) - phi;
        let exact = (exact + std::f64::consts::PI).rem_euclid(2.0 * std::f64::consts::PI)
            - std::f64::consts::PI;
        let found: f64 = result
            .lines
            .iter()
            .map(|r| {
                let z = r.line.quasi_static * Complex::from_polar(1.0, r.line.order.to_f64() * phi);
                z.re
            })
            .sum();
        within(
            "angle, over (β/2)⁶",
            (found - exact).abs() / (beta / 2.0).powi(6),
            2.0,
        );
    }
}

/// Two ends of a branched chain: what lies before the fork is left out, and either way round the arithmetic is one.
#[test]
fn law_relative_error_forgets_what_is_common() {
    let text = "inertia = [{ name = \"m\", J = 0.1 }, { name = \"f\", J = 0.1 }, { name = \"a\", J = 0.1 }, { name = \"b\", J = 0.1 }]\n\
        gear_pair = [\n{ name = \"common\", between = [\"m\", \"f\"], teeth = [20, 41], module = 0.002, k = 1e8 },\n\
        { name = \"left\", between = [\"f\", \"a\"], teeth = [20, 30], module = 0.002, k = 1e8 },\n\
        { name = \"right\", between = [\"f\", \"b\"], teeth = [20, 50], module = 0.002, k = 1e8 }]\n\
        error = [{ on = \"m\", amplitude = 1e-5, phase = 0.3 }, { on = \"a\", amplitude = 1e-5, phase = 0.4 }, { on = \"b\", amplitude = 2e-5, phase = 0.5 }]\n";
    let machine = written(text);
    let ask = TransmissionStudy {
        against: Some("b".to_string()),
        ..study("m", "a")
    };
    let result = traced(&machine, &ask);
    for row in &result.lines {
        assert!(close(row.loaded, row.line.quasi_static, 1e-9) || row.loaded.norm() < 1e-15);
        match row.source(&machine.machine).as_str() {
            "m" => assert!(row.line.quasi_static.norm() == 0.0),
            _ => assert!(row.line.quasi_static.norm() > 0.0),
        }
    }
    let alone = traced(&machine, &study("m", "a"));
    assert!(
        alone
            .lines
            .iter()
            .all(|r| r.source(&machine.machine) == "b" || r.line.quasi_static.norm() > 0.0)
    );
}

/// The Y2250: slow and rigid, slow and elastic, and at ω → 0 agree; what happens before the fork is common; the percentiles lie between
/// what cannot be less and what cannot be more.
#[test]
fn law_y2250() {
    let prepared_machine = shipped("examples/y2250_te.toml");
    let machine = &prepared_machine.machine;
    let ask = TransmissionStudy {
        against: Some("cradle".to_string()),
        speed: Some(1e-8),
        index: Some(IndexingStudy {
            element: "differential".to_string(),
            teeth: 37,
        }),
        ..study("motor", "workpiece")
    };
    let result = traced(&prepared_machine, &ask);
    let largest = result
        .lines
        .iter()
        .map(|r| r.line.quasi_static.norm())
        .fold(0.0, f64::max);
    for row in &result.lines {
        let off = |z: Complex| (z - row.line.quasi_static).norm();
        assert!(off(row.loaded) < 1e-9 * largest && off(row.dynamic.unwrap()) < 1e-9 * largest);
        if row.line.quasi_static.norm() > 0.0 {
            assert!(
                off(row.loaded) < 1e-9 * row.line.quasi_static.norm(),
                "{}",
                row.source(machine)
            );
        }
        let common = [
            "belt",
            "feed_gear_1",
            "reverse_2",
            "generating_2",
            "speed_gear_1",
            "cutter_ring",
        ];
        if common.contains(&row.source(machine).as_str()) {
            assert_eq!(row.line.quasi_static.norm(), 0.0, "{}", row.source(machine));
        }
    }
    let of = |on: &str, word: &str| {
        let k = (0..result.lines.len()).find(|&k| {
            result.lines[k].source(machine) == on && result.lines[k].cause(machine) == word
        });
        k.map(|k| {
            (
                &result.lines[k],
                &result.indexing_effects.as_ref().unwrap()[k],
            )
        })
        .unwrap()
    };
    // Half of F_p over the radius, 206.265 · 9.5 / 270 arcsec; a 37th of a turn on, 2 sin(π/37) of it from tooth to tooth.
    let (wheel, mark) = of("index_wheel", "cumulative-pitch");
    assert!((result.quasi_static(wheel).norm() * 0.27 / 9.5e-6 - 1.0).abs() < 1e-12);
    let IndexingEffect::Pitch { advance, adjacent } = mark else {
        panic!("{mark:?}")
    };
    assert_eq!(advance.to_string(), "1/37");
    assert!((adjacent - 2.0 * (std::f64::consts::PI / 37.0).sin()).abs() < 1e-14);
    assert_eq!(
        of("cradle_wheel", "cumulative-pitch").1,
        &IndexingEffect::Form
    );
    assert_eq!(of("roll_gear_1", "eccentricity").1, &IndexingEffect::Form);
    // Two turns of the first index gear are one pitch of the work: it comes back.
    assert_eq!(of("index_gear_1", "eccentricity").1, &IndexingEffect::Form);
    let range = &result.budget.range;
    assert!(range.percentiles.windows(2).all(|w| w[0].1 < w[1].1));
    assert!(
        range.percentiles[0].1 > largest && range.percentiles[2].1 < 2.0 * result.budget.worst_case
    );
    assert!(range.percentiles.iter().all(|p| p.2 < 0.1 * p.1));
    assert!(result.second_order > 0.0 && result.second_order < 1e-3 * largest);
}

/// A record is the sum of its lines: its harmonics are theirs, its ranges those of gear measurement, and the same at every call.
#[test]
fn law_record_holds_its_lines() {
    let machine = shipped("models/three_stage_chain.toml");
    let ask = TransmissionStudy {
        record: true,
        window_revs: Some(4),
        ..study("shaft_1", "spindle")
    };
    let result = traced(&machine, &ask);
    let made = result.record.as_ref().unwrap();
    assert!(made.record.closed && made.teeth == Some(90));
    let samples = &made.record.values;
    for order in ["1", "45", "225/2", "6750"] {
        let rows =
            (0..result.lines.len()).filter(|&k| result.lines[k].line.order.to_string() == order);
        let wanted = rows.fold(Complex::ZERO, |sum, k| sum + made.lines[k]);
        let cycles = 4.0
            * result
                .lines
                .iter()
                .find(|r| r.line.order.to_string() == order)
                .unwrap()
                .line
                .order
                .to_f64();
        let n = samples.len() as f64;
        let found = samples
            .iter()
            .enumerate()
            .fold(Complex::ZERO, |sum, (i, e)| {
                sum + Complex::from_polar(
                    *e,
                    -std::f64::consts::TAU * (cycles * i as f64 / n).fract(),
                )
            })
            * (2.0 / n);
        assert!(
            (found - wanted).norm() < 1e-9 * wanted.norm(),
            "{order}: {found:?} {wanted:?}"
        );
    }
    assert!(made.total <= 2.0 * result.budget.worst_case && made.per_revolution <= made.total);
    // Its samples miss crests, its ranges do not.
    let ends = (samples.iter()).fold((f64::MAX, f64::MIN), |(l, h), e| (l.min(*e), h.max(*e)));
    let fine = &result.lines[result.lines.len() - 1].line;
    assert!(made.total > ends.1 - ends.0 && fine.order.to_f64() > 1000.0);
    let known = TransmissionStudy {
        record: true,
        window_revs: Some(1),
        ..study("a", "b")
    };
    let one = written(
        "inertia = [{ name = \"a\", J = 0.01 }, { name = \"b\", J = 0.02 }]\n\
         gear_pair = [{ name = \"g\", between = [\"a\", \"b\"], teeth = [20, 40], module = 0.002, k = 1e8 }]\n\
         error = [{ on = \"b\", cause = \"profile\", amplitude = 1e-5, phase = 0.3 }]\n",
    );
    let result = traced(&one, &known);
    let twice = 2.0 * result.quasi_static(&result.lines[0]).norm();
    let made = result.record.as_ref().unwrap();
    let ranges = made.per_tooth.unwrap();
    for found in [made.total, made.per_revolution, ranges[0], ranges[2]] {
        assert!((found / twice - 1.0).abs() < 1.3e-3, "{}", found / twice);
    }
    assert!((result.budget.range.percentiles[1].1 / twice - 1.0).abs() < 1e-12);
    let again = traced(&machine, &ask);
    assert_eq!(&again.record.unwrap().record.values, samples);
}

/// Under torque a mesh whose stiffness changes gives way by the mean of 1/k over its cycle, as its lines do, not by one over the mean;
/// even harmonics of a square wave of half and half are not there.
#[test]
fn exact_wind_up_of_a_changing_stiffness() {
    let text = "inertia = [{ name = \"a\", J = 0.01 }, { name = \"b\", J = 0.02 }]\n\
         gear_pair = [{ name = \"g\", between = [\"a\", \"b\"], teeth = [20, 40], module = 0.002, k = 1e8, k_wave = WAVE }]\n\
         error = [{ on = \"b\", cause = \"eccentricity\", amplitude = 1e-5, phase = 0 }]\n\
         load = [{ at = \"b\", torque = 100 }]\n";
    let base = 0.04 * 20f64.to_radians().cos();
    let rigid_k = 100.0 / (1e8 * base * base);
    let fourier = "{ kind = \"fourier\", amplitudes = [0.2], mean = 1.1 }";
    for (wave, mean) in [
        (
            "{ kind = \"rectangular\", high = 1.2, low = 0.8, share = 0.5 }",
            0.5 / 1.2 + 0.5 / 0.8,
        ),
        (
            "{ kind = \"rectangular\", high = 1.0, low = 0.5, share = 0.25 }",
            0.25 + 0.75 / 0.5,
        ),
        // ∫ dψ/(m + a cos 2πψ) = 1/√(m² − a²).
        (fourier, 1.0 / (1.1f64 * 1.1 - 0.2 * 0.2).sqrt()),
    ] {
        let machine = written(&text.replace("WAVE", wave));
        let result = traced(&machine, &study("a", "b"));
        let wanted = rigid_k * mean;
        within(
            "wind-up",
            (result.wind_up.abs() / wanted - 1.0).abs(),
            1e-12,
        );
        let meshing: Vec<u32> = (result.lines.iter())
            .filter(|row| row.line.quasi_static.norm() == 0.0)
            .map(|row| row.line.harmonic)
            .collect();
        if mean < 1.1 && wave != fourier {
            assert_eq!(meshing, [1, 3, 5, 7, 9, 11, 13, 15]);
        }
        // What gives way has no grade; the declared error has.
        let of = |name: &str| {
            let at = result.elements.iter().position(|e| e == name).unwrap();
            result.budget.elements[at].one_grade_finer
        };
        assert!(of("g").is_none() && of("b").is_some());
        assert!(result.load_changes_lines());
    }
}

/// Equal pitches are no error, whatever rounding their sums leave; a half turn has one name.
#[test]
fn exact_nothing_and_half_turns() {
    let text = format!(
        "inertia = [{{ name = \"a\", J = 0.01 }}, {{ name = \"b\", J = 0.02 }}]\n\
         gear_pair = [{{ name = \"g\", between = [\"a\", \"b\"], teeth = [20, 40], module = 0.002, k = 1e8 }}]\n\
         error = [{{ on = \"b\", cause = \"single-pitch\", values = [{}] }},\n\
         {{ on = \"a\", cause = \"eccentricity\", amplitude = 1e-5, phase = {:?} }}]\n",
        ["7.3e-6"; 40].join(", "),
        std::f64::consts::PI,
    );
    let machine = written(&text);
    let result = traced(&machine, &study("a", "b"));
    assert_eq!(result.lines.len(), 1);
    assert!(!result.load_changes_lines());
    for turned in [
        Complex::new(-1.0, 0.0),
        Complex::new(-1.0, -0.0),
        Complex::new(-1.0, -1e-14),
    ] {
        let found = result.lines[0].phase(&machine.machine, turned);
        assert!((found.unwrap() - 180.0).abs() < 1e-9);
    }
}

/// With rigid joints a line alone locks the loop it does not fit; what lies behind the loop has its kinematic size.
#[test]
fn keeps_kinematic_and_loaded_apart() {
    let machine = written(&looped(1.0, FITS));
    let result = traced(&machine, &study("motor", "out"));
    assert!(result.load_changes_lines());
    for row in &result.lines {
        let name = row.source(&machine.machine);
        match name.as_str() {
            "p1" | "p2" => assert!(row.kinematic.is_none(), "{name}"),
            "out" => assert!(close(row.kinematic.unwrap(), row.loaded, 1e-9)),
            _ => assert!(row.kinematic.unwrap() == Complex::ZERO && row.loaded.norm() > 0.0),
        }
    }
}

/// A grade of ISO 1328-1:1995 by its formulas: F_p = 0.3 m + 1.25 √d + 7 µm at grade 5, F_r = 0.8 F_p, f_fα = 2.5 √m + 0.17 √d + 0.5,
/// times √2 a grade; sizes as the standard rounds them.
#[test]
fn exact_grades() {
    let text = |error: &str| {
        format!(
            "inertia = [{{ name = \"a\", J = 0.1 }}, {{ name = \"b\", J = 0.1 }}]\n\
         gear_pair = [{{ name = \"pair\", between = [\"a\", \"b\"], teeth = [30, 60], module = 0.003, k = 1e8 }}]\n\
         error = [{error}]\n"
        )
    };
    let amplitude = |cause: &str, grade: u32| {
        let error =
            format!("{{ on = \"a\", cause = \"{cause}\", grade = {grade}, phase = \"unknown\" }}");
        let machine = written(&text(&error));
        let error = &machine.machine.errors[0];
        assert!(
            error
                .assumed
                .as_ref()
                .unwrap()
                .contains(&format!("grade {grade}"))
        );
        error.waveform.harmonics()[0]
    };
    // d = 90 mm is taken as √(50 · 125) mm, m = 3 mm as √(2 · 3.5) mm.
    let (m, d) = (7f64.sqrt(), (50f64 * 125.0).sqrt());
    let total = 1e-6 * (0.3 * m + 1.25 * d.sqrt() + 7.0);
    let form = 1e-6 * (2.5 * m.sqrt() + 0.17 * d.sqrt() + 0.5);
    for (cause, order, wanted) in [
        ("eccentricity", 1, 0.4 * total),
        ("cumulative-pitch", 1, 0.5 * total),
        ("profile", 30, 0.25 * form),
    ] {
        let (n, a, _) = amplitude(cause, 5);
        assert!(
            n == order && (a - wanted).abs() < 1e-12 * wanted,
            "{cause}: {n} {a} {wanted}"
        );
        let (_, b, _) = amplitude(cause, 6);
        within("one grade coarser", (b / a - 2f64.sqrt()).abs(), 1e-12);
    }
    // What a grade allows stands anywhere, unless it is said where.
    let known = |phase: &str| {
        let error = format!("{{ on = \"a\", cause = \"eccentricity\", grade = 6{phase} }}");
        written(&text(&error)).machine.errors[0].phase_known
    };
    assert!(!known("") && known(", phase = 0.3") && !known(", phase = \"unknown\""));
    for wrong in [
        "{ on = \"a\", cause = \"form\", grade = 6 }",
        "{ on = \"a\", cause = \"eccentricity\", grade = 13 }",
    ] {
        let found = refused(&text(wrong), &study("a", "b"));
        assert!(found.to_string().contains("grade"), "{wrong}: {found}");
    }
}

/// Between the speeds asked for lines are told at their resonances: speeds closely about the peak find no more.
#[test]
fn exact_largest_between_speeds() {
    use geardyn::internals::scene::study::SpeedRange;
    let machine = shipped("examples/y2250_te.toml");
    let scene =
        geardyn::internals::scene::read(std::path::Path::new("examples/y2250_te.toml")).unwrap();
    let listed = scene.studies.iter().find_map(|s| match &s.kind {
        geardyn::internals::scene::study::StudyKind::Transmission(study) => Some(study.clone()),
        _ => None,
    });
    let over = |text: &str| {
        let study = TransmissionStudy {
            speeds: Some(SpeedRange::parse(text, "--speeds").unwrap()),
            ..listed.clone().unwrap()
        };
        traced(&machine, &study).map.unwrap()
    };
    let coarse = over("200:1400:4");
    let grid = |row: usize| coarse.amplitudes[row].iter().copied().fold(0.0, f64::max);
    let rise = |row: usize| coarse.largest[row].1 / grid(row);
    let row = (0..coarse.largest.len())
        .filter(|&row| grid(row) > 0.0)
        .max_by(|&a, &b| rise(a).total_cmp(&rise(b)))
        .unwrap();
    let (speed, amplitude) = coarse.largest[row];
    assert!(rise(row) > 1.5, "{}", rise(row));
    let rpm = speed * 30.0 / std::f64::consts::PI;
    let fine = over(&format!("{}:{}:5", 0.998 * rpm, 1.002 * rpm));
    let near = fine.amplitudes[row].iter().copied().fold(0.0, f64::max);
    within("largest amplitude", (amplitude / near - 1.0).abs(), 1e-3);
}

/// At speed another line leads: it is shown, counted in the budget there, and not among what could be left out there.
#[test]
fn keeps_what_is_large_at_speed() {
    let prepared_machine = shipped("examples/y2250_te.toml");
    let scene =
        geardyn::internals::scene::read(std::path::Path::new("examples/y2250_te.toml")).unwrap();
    let listed = scene.studies.iter().find_map(|s| match &s.kind {
        geardyn::internals::scene::study::StudyKind::Transmission(study) => Some(study.clone()),
        _ => None,
    });
    let study = TransmissionStudy {
        speed: Some(1242.0 * std::f64::consts::TAU / 60.0),
        ..listed.unwrap()
    };
    let result = traced(&prepared_machine, &study);
    let all = result.lines.iter();
    let largest = all
        .max_by(|a, b| {
            a.dynamic
                .unwrap()
                .norm()
                .total_cmp(&b.dynamic.unwrap().norm())
        })
        .unwrap();
    let machine = &prepared_machine.machine;
    let name = largest.source(machine);
    assert_eq!(name, "roll_gear_1");
    let text = geardyn::internals::report::transmission_table::text(machine, &result, false);
    let order = largest.line.order.to_string();
    let shown = |line: &str| line.trim_start().starts_with(&order) && line.contains(&name);
    assert!(text.lines().any(shown), "{text}");
    let fast = result.dynamic_budget.as_ref().unwrap();
    assert!(fast.budget.rss > largest.dynamic.unwrap().norm());
    let out = |list: &[usize]| list.iter().any(|&e| result.elements[e] == name);
    assert!(out(&result.negligible.0) && !out(&fast.negligible.0));
    assert!(text.contains("at speed: worst case"), "{text}");
}
