//! Screws and slides: closed forms of a table on a screw, its transmission error in µm, what cannot be.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::f64::consts::TAU;

use geardyn::base::code::Code;
use geardyn::modes::basis::{self, Solver as Decomposition};
use geardyn::plan::prepared::Prepared;
use geardyn::plan::transmission::run::{Answer, run};
use geardyn::report::transmission::{cause, source};
use geardyn::response::frequency::{Solver, Way};
use geardyn::response::ports::Ports;
use geardyn::response::system::Setting;
use geardyn::scene::study::TransmissionStudy;

const HEAD: &str = "title = \"test\"\nsource = \"made for a test\"\nunits = \"SI\"\n";

fn refusal(text: &str) -> geardyn::base::error::Error {
    match geardyn::scene::read_text("test.toml", &format!("{HEAD}{text}")) {
        Err(errors) => errors.list()[0].clone(),
        Ok(scene) => Prepared::new(&scene.model)
            .err()
            .unwrap_or_else(|| panic!("this was taken:\n{text}")),
    }
}

fn written(text: &str) -> Prepared {
    let scene = geardyn::scene::read_text("test.toml", &format!("{HEAD}{text}"))
        .unwrap_or_else(|e| panic!("{e}\n{text}"));
    Prepared::new(&scene.model).unwrap()
}

/// Motor, pair 20/50, screw of 12 mm lead, table.
fn feed(hand: &str, more: &str) -> String {
    format!(
        "[[inertia]]\nname = \"motor\"\nJ = 0.01\n[[inertia]]\nname = \"shaft\"\nJ = 0.03\n[[slide]]\nname = \"table\"\nmass = 300.0\n\
         [[gear_pair]]\nname = \"pair\"\nbetween = [\"motor\", \"shaft\"]\nteeth = [20, 50]\nmodule = 0.002\n\
         [[screw]]\nname = \"screw\"\nbetween = [\"shaft\", \"table\"]\nlead = 0.012\nhand = \"{hand}\"\nk = 2e8\nc = 5e3\n{more}"
    )
}

fn study_of(output: &str) -> TransmissionStudy {
    TransmissionStudy {
        driver: Some("motor".to_string()),
        output: Some(output.to_string()),
        ..TransmissionStudy::default()
    }
}

fn traced(prepared: &Prepared, window: Option<u32>) -> Answer {
    let study = TransmissionStudy {
        window,
        record: window.is_some(),
        ..study_of("table")
    };
    run(prepared, &study).unwrap()
}

/// A turning inertia and a sliding mass, free: `ω² = k (1/m + (p/2π)²/J)`, and one rigid motion.
#[test]
fn exact_axial_mode() {
    let prepared = written(&feed("right", ""));
    let basis = basis::solve(&prepared.linear, Decomposition::Factored).unwrap();
    let frequencies = &basis.omega;
    let polar = 0.03 + 0.01 * 2.5f64.powi(2);
    let exact = (2e8 * (1.0 / 300.0 + (0.012 / TAU).powi(2) / polar)).sqrt();
    assert_eq!(frequencies.len(), 2);
    assert_eq!(frequencies[0], 0.0);
    assert!((frequencies[1] / exact - 1.0).abs() < 1e-14, "{} {exact}", frequencies[1]);
    assert!(!prepared.machine.is_lateral());
}

/// From a torque at the shaft to the table, against the two equations solved by hand.
#[test]
fn exact_response_to_a_torque() {
    let prepared = written(&feed("left", ""));
    let setting = Setting {
        machine: &prepared.machine,
        operating: &prepared.operating,
        linear: &prepared.linear,
        speeds: None,
    };
    let names = |name: &str| [name.to_string()];
    let ports = Ports::read(&prepared.machine, &names("shaft"), &names("table"), &[]).unwrap();
    let solver = Solver::new(&setting, &ports, Way::Direct).unwrap();
    for omega in [3.0, 500.0, 900.0, 4000.0] {
        let found = solver.at(omega).unwrap()[(0, 0)];
        // −m ω² z = F, −J ω² θ = τ + (p/2π) F, F = (k + icω)(−(p/2π) θ − z) with a left-hand thread.
        let arm = 0.012 / TAU;
        let i = geardyn::numeric::Complex::new(0.0, 1.0);
        let spring = i * 5e3 * omega + 2e8;
        let [polar, mass] = [0.0925, 300.0].map(|m| -m * omega * omega);
        let a = spring * (arm * arm) + polar;
        let (b, d) = (spring * arm, spring + mass);
        let exact = -b / (a * d - b * b);
        assert!((found - exact).norm() < 1e-11 * exact.norm(), "{omega}: {found} {exact}");
    }
}

/// Orders per turn of the screw, amplitudes in m of travel, signs with the thread's hand.
#[test]
fn exact_lines_of_a_table() {
    for (hand, sign) in [("right", 1.0), ("left", -1.0)] {
        let errors = "[[error]]\non = \"screw\"\ncause = \"lead\"\namplitude = 3e-6\nphase = 0.4\n\
            [[error]]\non = \"screw\"\ncause = \"lead\"\norders = [2, 5]\namplitudes = [1e-6, 5e-7]\n\
            [[error]]\non = \"shaft\"\ncause = \"cumulative-pitch\"\namplitude = 8e-6\nphase = 0.2\n\
            [[error]]\non = \"motor\"\ncause = \"profile\"\namplitude = 2e-6\n";
        let prepared = written(&feed(hand, errors));
        let answer = traced(&prepared, None);
        let machine = &prepared.machine;
        assert_eq!(machine.freedom_name(answer.chain.per), "shaft.theta");
        let line = |of: &str, order: &str| {
            let row = answer.rows.iter().find(|r| {
                cause(machine, r) == of && r.line.order.to_string() == order
            });
            let row = row.unwrap_or_else(|| panic!("{of} {order}"));
            answer.slow(row)
        };
        // A surplus along the screw takes the table where it goes; the pattern runs forward while the screw does. The pair turns the shaft
        // backward while the motor turns forward, so a right-hand thread takes the table backward, and its lead of e is a lag.
        let lead = line("lead", "1");
        assert!((lead.norm() - 3e-6).abs() < 1e-20);
        let towards = lead.arg();
        let expected = match sign > 0.0 {
            true => std::f64::consts::PI - 0.4,
            false => -0.4,
        };
        assert!((towards - expected).abs() < 1e-12, "{hand}: {towards}");
        assert!((line("lead", "2").norm() - 1e-6).abs() < 1e-20);
        assert!((line("lead", "5").norm() - 5e-7).abs() < 1e-20);
        // 8 µm on the pitch circle of radius 50 mm turn the shaft by 160 µrad, the table by 160 µrad · 12 mm/2π.
        let pitch = line("cumulative-pitch", "1").norm();
        assert!((pitch / (8e-6 / 0.05 * 0.012 / TAU) - 1.0).abs() < 1e-13, "{pitch}");
        let base = 0.05 * (std::f64::consts::PI / 9.0).cos();
        let mesh = line("profile", "50").norm();
        assert!((mesh / (2e-6 / base * 0.012 / TAU) - 1.0).abs() < 1e-13, "{mesh}");
        assert_eq!(source(machine, &answer.rows[0]), "screw");
    }
}

/// Over one stroke the record goes through the table of the travel; there and back it closes.
#[test]
fn exact_table_over_a_travel() {
    let values = [0.0, 2e-6, 7e-6, 6e-6, 9e-6];
    let errors = "[[error]]\non = \"screw\"\ncause = \"lead\"\nvalues = [0.0, 2e-6, 7e-6, 6e-6, 9e-6]\ntravel = 0.48\n";
    let prepared = written(&feed("left", errors));
    let answer = traced(&prepared, Some(80));
    let made = &answer.record.as_ref().unwrap().record;
    assert_eq!(answer.rows[0].line.order.to_string(), "1/80");
    assert_eq!(answer.period.as_ref().unwrap().to_string(), "80");
    assert!(made.closed);
    let mean = (0.5 * (values[0] + values[4]) + values[1..4].iter().sum::<f64>()) / 4.0;
    for (at, value) in values.iter().enumerate() {
        for turns in [10 * at, 80 - 10 * at] {
            let sample = made.values[(turns % 80) * made.values.len() / 80];
            assert!((sample - (value - mean)).abs() < 1e-19, "{at}: {sample}");
        }
    }
}

/// A force on the table presses the screw together by F/k; what speed makes of a lead error with the motor's angle held is
/// `(k + icω)/(k + icω − mω²)`.
#[test]
fn exact_table_under_load_and_at_speed() {
    let more = "[[load]]\nat = \"table\"\nforce = -2000.0\n[[error]]\non = \"screw\"\ncause = \"lead\"\norder = 30\namplitude = 1e-6\n";
    let prepared = written(&feed("left", more));
    let study = TransmissionStudy {
        speed: Some(60.0),
        ..study_of("table")
    };
    let answer = run(&prepared, &study).unwrap();
    assert!((answer.wind_up + 2000.0 / 2e8).abs() < 1e-18, "{}", answer.wind_up);
    assert_eq!(answer.speed.unwrap().abs(), 24.0);
    let omega = 30.0 * 24.0;
    let spring = geardyn::numeric::Complex::new(2e8, 5e3 * omega);
    let exact = (spring / (spring - 300.0 * omega * omega)).norm() * 1e-6;
    let found = answer.rows[0].dynamic.unwrap().norm();
    assert!((found / exact - 1.0).abs() < 1e-11, "{found} {exact}");
}

/// Two screws of one gantry beside each other: the error of one side against the other forgets what is common.
#[test]
fn law_gantry_forgets_what_is_common() {
    let text = "[[inertia]]\nname = \"motor\"\nJ = 0.01\n[[inertia]]\nname = \"one\"\nJ = 0.03\n[[inertia]]\nname = \"two\"\nJ = 0.03\n\
        [[slide]]\nname = \"left\"\nmass = 300.0\n[[slide]]\nname = \"right\"\nmass = 300.0\n\
        [[gear_pair]]\nname = \"a\"\nbetween = [\"motor\", \"one\"]\nteeth = [20, 60]\nmodule = 0.002\n\
        [[gear_pair]]\nname = \"b\"\nbetween = [\"motor\", \"two\"]\nteeth = [20, 20]\nmodule = 0.002\n\
        [[screw]]\nname = \"screw_a\"\nbetween = [\"one\", \"left\"]\nlead = 0.03\n\
        [[screw]]\nname = \"screw_b\"\nbetween = [\"two\", \"right\"]\nlead = 0.01\n\
        [[error]]\non = \"motor\"\nmesh = \"a\"\ncause = \"form\"\namplitude = 1e-6\n\
        [[error]]\non = \"screw_a\"\ncause = \"lead\"\namplitude = 3e-6\n[[error]]\non = \"screw_b\"\ncause = \"lead\"\namplitude = 1e-6\n";
    let prepared = written(text);
    let study = TransmissionStudy {
        against: Some("right".to_string()),
        ..study_of("left")
    };
    let answer = run(&prepared, &study).unwrap();
    let orders: Vec<String> = answer.rows.iter().map(|r| r.line.order.to_string()).collect();
    assert_eq!(orders, ["1", "3", "3"]);
    let sizes: Vec<f64> = answer.rows.iter().map(|r| answer.slow(r).norm()).collect();
    assert!((sizes[0] - 3e-6).abs() < 1e-19, "{sizes:?}");
    let combination: Vec<f64> = answer.chain.combination.iter().map(|t| t.1).collect();
    assert_eq!(combination, [1.0, -1.0]);
    // Both tables joined to one: a rigid loop that turns.
    let one = text
        .replace("[[slide]]\nname = \"right\"\nmass = 300.0\n", "")
        .replace("\"right\"]", "\"left\"]");
    let machine = &one[..one.find("[[error]]").unwrap()];
    assert_eq!(written(machine).linear.rigid.len(), 1);
    // Their errors differ, and nothing gives way.
    assert_eq!(
        run(&written(&one), &study_of("left")).err().unwrap().code,
        Code::ContradictoryRatios
    );
}

/// What slides does not turn, what turns is not pushed, and a lead belongs to a screw.
#[test]
fn refuses_what_cannot_be() {
    let cases = [
        ("[[shaft]]\nname = \"s\"\nbetween = [\"shaft\", \"table\"]\nk = 1e4\n", Code::Conflict, "does not turn"),
        ("[[bearing]]\nname = \"b\"\nat = \"table\"\nk_x = 1e8\n", Code::Conflict, "no axis x"),
        ("[[load]]\nat = \"shaft\"\nforce = 10.0\n", Code::Conflict, "turns"),
        ("[[load]]\nat = \"table\"\ntorque = 10.0\n", Code::Conflict, "does not turn"),
        ("[[load]]\nat = \"shaft\"\nforce = 10.0\ntorque = 1.0\n", Code::Conflict, "force"),
        ("[[screw]]\nname = \"t\"\nbetween = [\"table\", \"shaft\"]\nlead = 0.01\n", Code::Conflict, "does not turn"),
        ("[[screw]]\nname = \"t\"\nbetween = [\"motor\", \"shaft\"]\nlead = 0.01\n", Code::Conflict, "no slide"),
        ("[[screw]]\nname = \"t\"\nbetween = [\"motor\", \"table\"]\nlead = 0.0\n", Code::OutOfRange, "lead"),
        ("[[screw]]\nname = \"t\"\nbetween = [\"motor\", \"table\"]\nlead = 1e-2\nk_wave = { kind = \"fourier\" }\n", Code::UnknownKey, "k_wave"),
        ("[[error]]\non = \"pair\"\ncause = \"lead\"\namplitude = 1e-6\n", Code::UnknownNode, "no screw"),
        ("[[error]]\non = \"screw\"\ncause = \"lead\"\nharmonic = 1\namplitude = 1e-6\n", Code::Conflict, "harmonic"),
        ("[[error]]\non = \"shaft\"\ncause = \"form\"\nvalues = [0.0, 1e-6]\ntravel = 1.0\n", Code::Conflict, "travel"),
        ("[[error]]\non = \"screw\"\ncause = \"lead\"\nvalues = [1e-6]\ntravel = 1.0\n", Code::OutOfRange, "two values"),
        ("[[speed]]\n", Code::WrongType, "speed"),
    ];
    for (text, code, word) in cases {
        let error = refusal(&feed("right", text));
        assert_eq!(error.code, code, "{text}\n{error}");
        assert!(error.to_string().contains(word), "{text}\n{error}");
    }
    // Two screws of other leads between one shaft and one table cannot both be rigid.
    let second = "[[screw]]\nname = \"second\"\nbetween = [\"shaft\", \"table\"]\nlead = 0.0120001\n";
    let rigid = feed("right", second).replace("k = 2e8\nc = 5e3\n", "");
    assert_eq!(refusal(&rigid).code, Code::ContradictoryRatios);
}
