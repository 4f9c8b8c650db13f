//! Errors of screws and of planetary sets: a table on a screw in µm, planets one by one against sums by hand, grades of pitches.

use std::f64::consts::{PI, TAU};

use crate::support::verification::within;
use geardyn::internals::base::code::Code;
use geardyn::internals::modes::modal_basis::{self, UndampedSolver as Decomposition};
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::plan::transmission::{result::TransmissionResult, run::run};
use geardyn::internals::response::frf::{ResponseMethod, ResponseSolver};
use geardyn::internals::response::ports::Ports;
use geardyn::internals::response::system::OperatingModel;
use geardyn::internals::scene::study::TransmissionStudy;

const HEAD: &str = "title = \"test\"\nsource = \"made for a test\"\nunits = \"SI\"\n";

fn refusal(text: &str) -> geardyn::internals::base::error::Error {
    match geardyn::internals::scene::read_text("test.toml", &format!("{HEAD}{text}")) {
        Err(errors) => errors.as_slice()[0].clone(),
        Ok(scene) => PreparedMachine::new(&scene.model)
            .err()
            .unwrap_or_else(|| panic!("this was taken:\n{text}")),
    }
}

fn written(text: &str) -> PreparedMachine {
    let scene = geardyn::internals::scene::read_text("test.toml", &format!("{HEAD}{text}"))
        .unwrap_or_else(|e| panic!("{e}\n{text}"));
    PreparedMachine::new(&scene.model).unwrap()
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

fn traced(machine: &PreparedMachine, window: Option<u32>) -> TransmissionResult {
    let study = TransmissionStudy {
        window_revs: window,
        record: window.is_some(),
        ..study_of("table")
    };
    run(machine, &study).unwrap()
}

/// A turning inertia and a sliding mass, free: `ω² = k (1/m + (p/2π)²/J)`, and one rigid motion.
#[test]
fn exact_axial_mode() {
    let machine = written(&feed("right", ""));
    let basis = modal_basis::solve(&machine.model, Decomposition::Factored).unwrap();
    let frequencies = &basis.omega;
    let polar = 0.03 + 0.01 * 2.5f64.powi(2);
    let exact = (2e8 * (1.0 / 300.0 + (0.012 / TAU).powi(2) / polar)).sqrt();
    assert_eq!(frequencies.len(), 2);
    assert_eq!(frequencies[0], 0.0);
    within("frequency", (frequencies[1] / exact - 1.0).abs(), 1e-14);
    assert!(!machine.machine.is_lateral());
}

/// From a torque at the shaft to the table, against the two equations solved by hand.
#[test]
fn exact_response_to_a_torque() {
    let prepared_machine = written(&feed("left", ""));
    let model = OperatingModel {
        machine: &prepared_machine.machine,
        operating: &prepared_machine.operating,
        model: &prepared_machine.model,
        speeds: None,
    };
    let names = |name: &str| [name.to_string()];
    let ports = Ports::parse(
        &prepared_machine.machine,
        &names("shaft"),
        &names("table"),
        &[],
    )
    .unwrap();
    let solver = ResponseSolver::new(&model, &ports, ResponseMethod::Direct).unwrap();
    for omega in [3.0, 500.0, 900.0, 4000.0] {
        let found = solver.response_at(omega).unwrap()[(0, 0)];
        // −m ω² z = F, −J ω² θ = τ + (p/2π) F, F = (k + icω)(−(p/2π) θ − z) with a left-hand thread.
        let arm = 0.012 / TAU;
        let i = geardyn::internals::numeric::Complex::new(0.0, 1.0);
        let spring = i * 5e3 * omega + 2e8;
        let [polar, mass] = [0.0925, 300.0].map(|m| -m * omega * omega);
        let a = spring * (arm * arm) + polar;
        let (b, d) = (spring * arm, spring + mass);
        let exact = -b / (a * d - b * b);
        within("response", (found - exact).norm() / exact.norm(), 1e-11);
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
        let prepared_machine = written(&feed(hand, errors));
        let result = traced(&prepared_machine, None);
        let machine = &prepared_machine.machine;
        assert_eq!(
            machine.dof_name(result.chain.order_reference),
            "shaft.theta"
        );
        let line = |of: &str, order: &str| {
            let row = result
                .lines
                .iter()
                .find(|r| r.cause(machine) == of && r.line.order.to_string() == order);
            let row = row.unwrap_or_else(|| panic!("{of} {order}"));
            result.quasi_static(row)
        };
        // A surplus along the screw takes the table where it goes; the pattern runs forward while the screw does. The pair turns the shaft
        // backward while the motor turns forward, so a right-hand thread takes the table backward, and its lead of e is a lag.
        let lead = line("lead", "1");
        assert!((lead.norm() - 3e-6).abs() < 1e-20);
        let towards = lead.arg();
        let expected = match sign > 0.0 {
            true => PI - 0.4,
            false => -0.4,
        };
        within("direction of travel", (towards - expected).abs(), 1e-12);
        assert!((line("lead", "2").norm() - 1e-6).abs() < 1e-20);
        assert!((line("lead", "5").norm() - 5e-7).abs() < 1e-20);
        // 8 µm on the pitch circle of radius 50 mm turn the shaft by 160 µrad, the table by 160 µrad · 12 mm/2π.
        let pitch = line("cumulative-pitch", "1").norm();
        within(
            "pitch error",
            (pitch / (8e-6 / 0.05 * 0.012 / TAU) - 1.0).abs(),
            1e-13,
        );
        let base = 0.05 * (PI / 9.0).cos();
        let mesh = line("profile", "50").norm();
        within(
            "mesh error",
            (mesh / (2e-6 / base * 0.012 / TAU) - 1.0).abs(),
            1e-13,
        );
        assert_eq!(result.lines[0].source(machine), "screw");
    }
}

/// Over one stroke the record goes through the table of the travel; there and back it closes.
#[test]
fn exact_table_over_a_travel() {
    let values = [0.0, 2e-6, 7e-6, 6e-6, 9e-6];
    let errors = "[[error]]\non = \"screw\"\ncause = \"lead\"\nvalues = [0.0, 2e-6, 7e-6, 6e-6, 9e-6]\ntravel = 0.48\n";
    let machine = written(&feed("left", errors));
    let result = traced(&machine, Some(80));
    let made = &result.record.as_ref().unwrap().record;
    assert_eq!(result.lines[0].line.order.to_string(), "1/80");
    assert_eq!(result.period.as_ref().unwrap().to_string(), "80");
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
    let machine = written(&feed("left", more));
    let study = TransmissionStudy {
        speed: Some(60.0),
        ..study_of("table")
    };
    let result = run(&machine, &study).unwrap();
    assert!(
        (result.wind_up + 2000.0 / 2e8).abs() < 1e-18,
        "{}",
        result.wind_up
    );
    assert_eq!(result.speed.unwrap().abs(), 24.0);
    let omega = 30.0 * 24.0;
    let spring = geardyn::internals::numeric::Complex::new(2e8, 5e3 * omega);
    let exact = (spring / (spring - 300.0 * omega * omega)).norm() * 1e-6;
    let found = result.lines[0].dynamic.unwrap().norm();
    within("amplification", (found / exact - 1.0).abs(), 1e-11);
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
    let prepared_machine = written(text);
    let study = TransmissionStudy {
        against: Some("right".to_string()),
        ..study_of("left")
    };
    let result = run(&prepared_machine, &study).unwrap();
    let orders: Vec<String> = result
        .lines
        .iter()
        .map(|r| r.line.order.to_string())
        .collect();
    assert_eq!(orders, ["1", "3", "3"]);
    let sizes: Vec<f64> = result
        .lines
        .iter()
        .map(|r| result.quasi_static(r).norm())
        .collect();
    assert!((sizes[0] - 3e-6).abs() < 1e-19, "{sizes:?}");
    let combination: Vec<f64> = result.chain.combination.iter().map(|t| t.1).collect();
    assert_eq!(combination, [1.0, -1.0]);
    // Both tables joined to one: a rigid loop that turns.
    let one = text
        .replace("[[slide]]\nname = \"right\"\nmass = 300.0\n", "")
        .replace("\"right\"]", "\"left\"]");
    let machine = &one[..one.find("[[error]]").unwrap()];
    assert_eq!(written(machine).model.rigid.len(), 1);
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
        (
            "[[shaft]]\nname = \"s\"\nbetween = [\"shaft\", \"table\"]\nk = 1e4\n",
            Code::Conflict,
            "does not turn",
        ),
        (
            "[[bearing]]\nname = \"b\"\nat = \"table\"\nk_x = 1e8\n",
            Code::Conflict,
            "no axis x",
        ),
        (
            "[[load]]\nat = \"shaft\"\nforce = 10.0\n",
            Code::Conflict,
            "turns",
        ),
        (
            "[[load]]\nat = \"table\"\ntorque = 10.0\n",
            Code::Conflict,
            "does not turn",
        ),
        (
            "[[load]]\nat = \"shaft\"\nforce = 10.0\ntorque = 1.0\n",
            Code::Conflict,
            "force",
        ),
        (
            "[[screw]]\nname = \"t\"\nbetween = [\"table\", \"shaft\"]\nlead = 0.01\n",
            Code::Conflict,
            "does not turn",
        ),
        (
            "[[screw]]\nname = \"t\"\nbetween = [\"motor\", \"shaft\"]\nlead = 0.01\n",
            Code::Conflict,
            "not a slide",
        ),
        (
            "[[screw]]\nname = \"t\"\nbetween = [\"motor\", \"table\"]\nlead = 0.0\n",
            Code::OutOfRange,
            "lead",
        ),
        (
            "[[screw]]\nname = \"t\"\nbetween = [\"motor\", \"table\"]\nlead = 1e-2\nk_wave = { kind = \"fourier\" }\n",
            Code::UnknownKey,
            "k_wave",
        ),
        (
            "[[error]]\non = \"pair\"\ncause = \"lead\"\namplitude = 1e-6\n",
            Code::UnknownNode,
            "no screw",
        ),
        (
            "[[error]]\non = \"screw\"\ncause = \"lead\"\nharmonic = 1\namplitude = 1e-6\n",
            Code::Conflict,
            "harmonic",
        ),
        (
            "[[error]]\non = \"shaft\"\ncause = \"form\"\nvalues = [0.0, 1e-6]\ntravel = 1.0\n",
            Code::Conflict,
            "travel",
        ),
        (
            "[[error]]\non = \"screw\"\ncause = \"lead\"\nvalues = [1e-6]\ntravel = 1.0\n",
            Code::OutOfRange,
            "two values",
        ),
        ("[[speed]]\n", Code::WrongType, "speed"),
    ];
    for (text, code, word) in cases {
        let error = refusal(&feed("right", text));
        assert_eq!(error.code, code, "{text}\n{error}");
        assert!(error.to_string().contains(word), "{text}\n{error}");
    }
    // Two screws of other leads between one shaft and one table cannot both be rigid.
    let second =
        "[[screw]]\nname = \"second\"\nbetween = [\"shaft\", \"table\"]\nlead = 0.0120001\n";
    let rigid = feed("right", second).replace("k = 2e8\nc = 5e3\n", "");
    assert_eq!(refusal(&rigid).code, Code::ContradictoryRatios);
}

/// Sun driving, ring standing, carrier out, meshes of one stiffness: planets are free, so `F_n = k/2 (δ_s + δ_r)` of each and `Σ F_n = 0`:
/// the carrier errs by `−mean(e_s,n + e_r,n) / (r_bs + r_br)`.
fn stage(teeth: [u32; 3], planets: u32, errors: &str) -> PreparedMachine {
    written(&format!(
        "inertia = [{{ name = \"sun\", J = 0.01 }}, {{ name = \"carrier\", J = 0.1 }}]\n\
         planetary = [{{ name = \"set\", sun = \"sun\", ring = \"ground\", carrier = \"carrier\", planets = {planets}, teeth = [{}, {}, {}], \
         module = 0.003, planet_J = 1e-3, k_sun = 2e8, k_ring = 2e8 }}]\n{errors}",
        teeth[0], teeth[1], teeth[2]
    ))
}

fn carried(machine: &PreparedMachine) -> TransmissionResult {
    let study = TransmissionStudy {
        driver: Some("sun".to_string()),
        output: Some("carrier".to_string()),
        ..TransmissionStudy::default()
    };
    run(machine, &study).unwrap()
}

/// Size of a line by its order, rad; zero where there is none.
fn line(result: &TransmissionResult, order: &str) -> f64 {
    let rows = result
        .lines
        .iter()
        .filter(|r| r.line.order.to_string() == order);
    rows.map(|r| result.quasi_static(r).norm()).sum()
}

/// One planet's errors by hand. Off its axis by ε it moves its carrier pin to and fro: the carrier by `ε / (N r_c)`. An arc of its pitch
/// circle is passed on by the tooth at the sun and, half a turn round, taken back by the tooth at the ring: odd orders add up to
/// `F / (N r_c)`, even ones are gone. A profile reaches both meshes half a turn apart.
#[test]
fn exact_errors_of_one_planet() {
    // 21 + 2·30 = 81; N = 3 of (21 + 81)/3 = 34.
    let radius = 0.003 * (21.0 + 30.0) / 2.0;
    let of = |error: &str| {
        let errors = format!("error = [{{ on = \"set.planet_2\", {error} }}]\n");
        carried(&stage([21, 30, 81], 3, &errors))
    };
    // Turns of a planet against the carrier for one of the carrier: 81/30 = 27/10.
    let eccentric = of("cause = \"eccentricity\", amplitude = 1e-5, phase = 0.3");
    let found = line(&eccentric, "27/10");
    within(
        "pin off its axis",
        (found / (1e-5 / 3.0 / radius) - 1.0).abs(),
        1e-11,
    );
    let pitch =
        of("cause = \"cumulative-pitch\", amplitudes = [1e-5, 1e-5, 1e-5], orders = [1, 2, 3]");
    for (order, share) in [("27/10", 1.0), ("27/5", 0.0), ("81/10", 1.0)] {
        let found = line(&pitch, order) * 3.0 * radius / 1e-5;
        within("one tooth at two meshes", (found - share).abs(), 1e-11);
    }
    // 30 teeth: half a turn is 15 pitches, so both meshes see the profile alike; 2 A / (N (r_bs + r_br)).
    let base = 2.0 * radius * (PI / 9.0).cos();
    let profile = of("cause = \"profile\", amplitude = 2e-6");
    let found = line(&profile, "81");
    within(
        "both flanks at once",
        (found / (2.0 * 2e-6 / 3.0 / base) - 1.0).abs(),
        1e-11,
    );
    // An odd number of teeth: a tooth at the sun, a space at the ring.
    let errors = "error = [{ on = \"set.planet_1\", cause = \"profile\", amplitude = 2e-6 }]\n";
    let odd = carried(&stage([21, 33, 87], 3, errors));
    assert!(line(&odd, "87") < 1e-16);
}

/// Sun and ring meet every planet: orders survive where the planets see them in step, `Σ cos(n (φ − ψ_j))/N` by hand.
#[test]
fn exact_orders_that_planets_cancel() {
    for (teeth, planets) in [
        ([21, 30, 81], 3),
        ([20, 31, 82], 3),
        ([24, 24, 72], 4),
        ([22, 25, 72], 4),
    ] {
        let [sun, planet, ring] = teeth.map(f64::from);
        let radius = 0.003 * (sun + planet) / 2.0;
        let base = 2.0 * radius * (PI / 9.0).cos();
        let in_step = |n: f64| {
            let sums =
                (0..planets).map(|j| (n * TAU * f64::from(j) / f64::from(planets)).sin_cos());
            let (s, c) = sums.fold((0.0, 0.0), |(s, c), x| (s + x.0, c + x.1));
            s.hypot(c) / f64::from(planets)
        };
        for (on, z, turns) in [("sun", sun, ring / sun), ("set.ring", ring, 1.0)] {
            let errors = format!(
                "error = [{{ on = \"{on}\", cause = \"form\", amplitudes = [1e-6, 1e-6, 1e-6, 1e-6, 1e-6], orders = [1, 2, 3, 4, {z}] }}]\n"
            );
            let result = carried(&stage(teeth, planets as u32, &errors));
            for n in [1.0, 2.0, 3.0, 4.0, z] {
                let row = result
                    .lines
                    .iter()
                    .find(|r| (r.line.order.to_f64() - n * turns).abs() < 1e-9)
                    .unwrap();
                let found = result.quasi_static(row).norm() * base / 1e-6;
                within("orders that survive", (found - in_step(n)).abs(), 1e-11);
            }
        }
        // Off its axis, a sun among equal planets turns nothing.
        let errors = "error = [{ on = \"sun\", cause = \"eccentricity\", amplitude = 1e-5 }]\n";
        let result = carried(&stage(teeth, planets as u32, errors));
        assert!(
            result
                .lines
                .iter()
                .all(|r| result.quasi_static(r).norm() < 1e-15)
        );
    }
}

/// A ring that stands is passed by the carrier: its table comes out tooth after tooth, against the one planet of a stage with two.
#[test]
fn exact_standing_ring_is_run_through_by_its_planets() {
    let values: Vec<f64> = (0..81).map(|k| 1e-6 * f64::from((7 * k) % 13)).collect();
    let mean = values.iter().sum::<f64>() / 81.0;
    let errors = format!(
        "error = [{{ on = \"set.ring\", cause = \"cumulative-pitch\", values = {values:?} }}]\n"
    );
    let machine = stage([21, 30, 81], 1, &errors);
    let result = run(
        &machine,
        &TransmissionStudy {
            driver: Some("sun".to_string()),
            output: Some("carrier".to_string()),
            record: true,
            ..TransmissionStudy::default()
        },
    )
    .unwrap();
    let made = &result.record.as_ref().unwrap().record;
    // One planet alone rolls in the ring: where the ring's teeth are ahead by F, on the pitch circle, the planet finds them early, and the
    // carrier goes with them, by F over twice its arm.
    let radius = 0.003 * 51.0 / 2.0;
    for (k, value) in values.iter().enumerate() {
        // Samples lie beside the teeth: the record's own lines say what is there.
        let phi = TAU * k as f64 / 81.0;
        let sum: f64 = (result.lines.iter())
            .map(|r| {
                let z = result.quasi_static(r);
                z.norm() * (r.line.order.to_f64() * phi + z.arg()).cos()
            })
            .sum();
        let exact = (value - mean) / (2.0 * radius);
        assert!((sum - exact).abs() < 1e-6 * 1e-5, "{k}: {sum} {exact}");
    }
    assert_eq!(made.turns, 1);
}

/// Pitches by chance within ± f_pt: the amplitudes that added up random tables show, 4 000 of them.
#[test]
fn exact_grade_of_single_pitches() {
    let text = "inertia = [{ name = \"a\", J = 0.1 }, { name = \"b\", J = 0.1 }]\n\
         gear_pair = [{ name = \"pair\", between = [\"a\", \"b\"], teeth = [30, 60], module = 0.003, k = 1e8 }]\n\
         error = [{ on = \"b\", cause = \"single-pitch\", grade = 5, phase = \"unknown\" }]\n";
    let machine = written(text);
    let error = &machine.machine.errors[0];
    assert!(error.assumed.as_ref().unwrap().contains("f_pt"));
    let terms = error.waveform.harmonics();
    assert_eq!(terms.len(), 10);
    // f_pt = 0.3 (m + 0.4 √d) + 4 µm, sizes as the standard rounds them: d = 180 mm lies between 125 and 280, m = 3 mm between 2 and 3.5.
    let (m, d) = (7f64.sqrt(), (125f64 * 280.0).sqrt());
    let limit = 1e-6 * (0.3 * (m + 0.4 * d.sqrt()) + 4.0);
    let mut rng = fastrand::Rng::with_seed(7);
    let mut squares = [0.0; 10];
    const TABLES: usize = 4000;
    for _ in 0..TABLES {
        let single: Vec<f64> = (0..60).map(|_| limit * (2.0 * rng.f64() - 1.0)).collect();
        let mean = single.iter().sum::<f64>() / 60.0;
        let mut sum = 0.0;
        let added: Vec<f64> = single
            .iter()
            .map(|f| {
                sum += f - mean;
                sum
            })
            .collect();
        for (n, square) in squares.iter_mut().enumerate() {
            let angle = |k: usize| TAU * (n as f64 + 1.0) * k as f64 / 60.0;
            let re: f64 = (0..60).map(|k| added[k] * angle(k).cos()).sum();
            let im: f64 = (0..60).map(|k| added[k] * angle(k).sin()).sum();
            *square += (re * re + im * im) / 900.0;
        }
    }
    for ((_, amplitude, _), square) in terms.iter().zip(squares) {
        let rms = (square / TABLES as f64).sqrt();
        within("amplitudes", (amplitude / rms - 1.0).abs(), 0.05);
    }
}
