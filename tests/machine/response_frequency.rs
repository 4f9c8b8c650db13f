//! Frequency responses: closed forms, numpy's solution of the same machine, reciprocity, one way against the other.

use crate::support;
use std::f64::consts::TAU;
use std::path::Path;

use crate::support::within;
use geardyn::internals::base::code::Code;
use geardyn::internals::base::error::Error;
use geardyn::internals::machine::kinematics::mean_speeds;
use geardyn::internals::motion::assemble::assemble;
use geardyn::internals::numeric::{Complex, ComplexMatrix, Matrix};
use geardyn::internals::plan::prepared_machine::PreparedMachine;
use geardyn::internals::response::frf::{FrfMatrix, ResponseMethod, SolverKind, frf_matrix};
use geardyn::internals::response::ports::Ports;
use geardyn::internals::response::system::OperatingModel;
use geardyn::internals::scene::initial_conditions::InitialConditions;
use geardyn::internals::scene::laws::MeshPhase;
use serde_json::Value;

const HEAD: &str = "title = \"test\"\nsource = \"made for a test\"\nunits = \"SI\"\n";

fn written(text: &str) -> PreparedMachine {
    PreparedMachine::new(
        &geardyn::internals::scene::read_text("test.toml", &format!("{HEAD}{text}"))
            .unwrap()
            .model,
    )
    .unwrap()
}

fn shipped(name: &str) -> PreparedMachine {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("models")
        .join(name);
    PreparedMachine::new(&geardyn::internals::scene::read(&path).unwrap().model).unwrap()
}

struct Ask<'a> {
    inputs: &'a [&'a str],
    outputs: &'a [&'a str],
    held: &'a [&'a str],
    way: ResponseMethod,
    turning: bool,
}

impl Default for Ask<'_> {
    fn default() -> Self {
        Ask {
            inputs: &[],
            outputs: &[],
            held: &[],
            way: ResponseMethod::Direct,
            turning: false,
        }
    }
}

fn names(words: &[&str]) -> Vec<String> {
    words.iter().map(|w| w.to_string()).collect()
}

fn answer(
    prepared_machine: &PreparedMachine,
    ask: &Ask,
    omega: &[f64],
) -> Result<FrfMatrix, Error> {
    let PreparedMachine {
        machine,
        kinematics,
        operating,
        model: linear,
        ..
    } = prepared_machine;
    let speeds = ask
        .turning
        .then(|| mean_speeds(machine, kinematics, None).unwrap());
    let model = OperatingModel {
        machine,
        operating,
        model: linear,
        speeds: speeds.as_deref(),
    };
    let ports = Ports::parse(
        machine,
        &names(ask.inputs),
        &names(ask.outputs),
        &names(ask.held),
    )?;
    frf_matrix(&model, &ports, omega, ask.way)
}

fn close(found: Complex, exact: Complex, tolerance: f64) {
    let off = (found - exact).norm();
    // Where the closed form is zero, so is the response.
    within(
        "responses",
        off / exact.norm().max(f64::MIN_POSITIVE),
        tolerance,
    );
}

fn apart(a: &ComplexMatrix, b: &ComplexMatrix) -> f64 {
    (a - b).norm_max() / a.norm_max()
}

const I: Complex = Complex::new(0.0, 1.0);
const WAYS: [ResponseMethod; 2] = [ResponseMethod::Direct, ResponseMethod::Modal];

/// What a bearing exerts along an axis is all of it: spring, dashpot, cross terms of either kind. The body's balance closes,
/// `F = f − m a`, driven by a force or by the base.
#[test]
fn law_bearing_forces_are_whole() {
    let own = "inertia = [{ name = \"s\", J = 0.01, mass = 10.0 }]";
    let diagonal = "k_x = 1e6, k_y = 2e6";
    for terms in [
        format!("{diagonal}, c_x = 5e3, c_y = 3e3"),
        format!(
            "{diagonal}, k_x_y = 5e5, k_y_x = 5e5, c_x = 700.0, c_y = 900.0, c_x_y = 300.0, c_y_x = 300.0"
        ),
        format!("{diagonal}, k_x_y = 4e5, k_y_x = -4e5, c_x = 700.0, c_y = 900.0"),
    ] {
        let body = written(&format!(
            "{own}\nbearing = [{{ name = \"b\", at = \"s\", k_theta = 10.0, {terms} }}]"
        ));
        for method in WAYS {
            let ask = Ask {
                inputs: &["s.x", "ground.x", "ground.y"],
                outputs: &[
                    "b x.force",
                    "b y.force",
                    "s.x.acceleration",
                    "s.y.acceleration",
                ],
                way: method,
                ..Ask::default()
            };
            let found = match answer(&body, &ask, &[20.0, 60.0, 300.0, 2000.0]) {
                Ok(found) => found,
                // Without symmetry there are no real modes to sum over.
                Err(_) if method == ResponseMethod::Modal && terms.contains("-4e5") => continue,
                Err(error) => panic!("{error:?}"),
            };
            for h in &found.values {
                for drive in 0..3 {
                    let column = (0..4).fold(0.0, |m: f64, i| m.max(h[(i, drive)].norm()));
                    for axis in 0..2 {
                        let load = if (drive, axis) == (0, 0) { 1.0 } else { 0.0 };
                        let off = h[(axis, drive)] + 10.0 * h[(2 + axis, drive)] - load;
                        assert!(off.norm() <= 1e-12 * column.max(load), "{terms}: {off}");
                    }
                }
            }
        }
    }
}

/// One disc on a spring and a damper to ground: `1 / (k − ω² J + iω c)`; and moved by its ground.
#[test]
fn exact_one_freedom() {
    let (j, k, c) = (0.3_f64, 1200.0_f64, 0.9_f64);
    let one = written(&format!(
        "inertia = [{{ name = \"disc\", J = {j} }}]\nshaft = [{{ name = \"shaft\", between = [\"ground\", \"disc\"], k = {k}, c = {c} }}]"
    ));
    for method in WAYS {
        let ask = Ask {
            inputs: &["disc", "ground.theta", "shaft.displacement"],
            outputs: &[
                "disc.theta",
                "disc.speed",
                "disc.acceleration",
                "shaft.force",
                "shaft.deflection",
            ],
            way: method,
            ..Ask::default()
        };
        let omega = [0.0, 3.0, (k / j).sqrt(), 500.0];
        let found = answer(&one, &ask, &omega).unwrap();
        for (h, w) in found.values.iter().zip(omega) {
            let d = Complex::new(k - w * w * j, w * c);
            let law = Complex::new(k, w * c);
            let x = 1.0 / d;
            close(h[(0, 0)], x, 1e-14);
            close(h[(1, 0)], I * w * x, 1e-14);
            close(h[(2, 0)], -w * w * x, 1e-14);
            close(h[(3, 0)], law * x, 1e-14);
            close(h[(4, 0)], x, 1e-14);
            for moved in [1, 2] {
                close(h[(0, moved)], law / d, 1e-13);
                // The force in the spring is what turns the disc; at rest it is the rounding of k.
                let turns = w * w * j * law / d;
                assert!(
                    (h[(3, moved)] - turns).norm() <= 1e-14 * law.norm() * (1.0 + (law / d).norm())
                );
            }
        }
    }
}

/// Two free discs: `H₁₁ = −1/(ω²(J₁+J₂)) + …`, `H₁₂ = k / (ω² (ω² J₁J₂ − k(J₁+J₂)))`; at rest only what is relative.
#[test]
fn exact_two_discs() {
    let two = shipped("two_disc.toml");
    let (j1, j2, k) = (211.4, 8.3, 9.775e6);
    let outputs = [
        "disc_1",
        "disc_2",
        "disc_2 - disc_1",
        "shaft.force",
        "disc_2.acceleration",
    ];
    let omega = [1e-6, 0.1, 100.0, 1000.0, 1200.0, 1e5];
    for method in WAYS {
        let ask = Ask {
            inputs: &["disc_1"],
            outputs: &outputs,
            way: method,
            ..Ask::default()
        };
        for (h, w) in answer(&two, &ask, &omega).unwrap().values.iter().zip(omega) {
            let (w2, below) = (w * w, w * w * j1 * j2 - k * (j1 + j2));
            let real = |x: f64| Complex::new(x, 0.0);
            close(h[(0, 0)], real((k - w2 * j2) / (w2 * below)), 1e-12);
            close(h[(1, 0)], real(k / (w2 * below)), 1e-12);
            // The difference keeps its digits where both discs move alike.
            close(h[(2, 0)], real(j2 / below), 1e-12);
            close(h[(3, 0)], real(k * j2 / below), 1e-12);
        }
        let still = Ask {
            inputs: &["disc_1"],
            outputs: &outputs[2..],
            way: method,
            ..Ask::default()
        };
        let h = &answer(&two, &still, &[0.0]).unwrap().values[0];
        close(h[(0, 0)], Complex::new(-j2 / (k * (j1 + j2)), 0.0), 1e-13);
        close(h[(1, 0)], Complex::new(-j2 / (j1 + j2), 0.0), 1e-13);
        close(h[(2, 0)], Complex::new(1.0 / (j1 + j2), 0.0), 1e-13);
    }
}

/// The same machine by numpy, with multipliers for the rigid pair and the prescribed angle.
/// Source: NumPy 2.4.6, rigid pairs as rows of Lagrange multipliers.
#[test]
fn ref_numpy_multipliers() {
    let reference: Value =
        serde_json::from_str(include_str!("../../data/reference/response.json")).unwrap();
    let machine = written(reference["model"].as_str().unwrap());
    let list = |v: &Value| -> Vec<String> {
        v.as_array()
            .unwrap()
            .iter()
            .map(|x| x.as_str().unwrap().to_string())
            .collect()
    };
    let outputs = list(&reference["outputs"]);
    let outputs: Vec<&str> = outputs.iter().map(String::as_str).collect();
    for case in ["free", "driven"] {
        let inputs = list(&reference[case]["inputs"]);
        let inputs: Vec<&str> = inputs.iter().map(String::as_str).collect();
        for method in WAYS {
            let ask = Ask {
                inputs: &inputs,
                outputs: &outputs,
                way: method,
                ..Ask::default()
            };
            for (line, rows) in reference[case]["values"]
                .as_array()
                .unwrap()
                .iter()
                .enumerate()
            {
                let omega = TAU * reference["frequency_hz"][line].as_f64().unwrap();
                let Some(rows) = rows.as_array() else {
                    continue;
                };
                let h = &answer(&machine, &ask, &[omega]).unwrap().values[0];
                for (i, row) in rows.iter().enumerate() {
                    for o in 0..outputs.len() {
                        let exact =
                            Complex::new(row[o][0].as_f64().unwrap(), row[o][1].as_f64().unwrap());
                        // Forces that cancel to zero are left with the rounding of 2e8 N/m.
                        let floor = [1e-19, 1e-7, 1e-7, 1e-7, 1e-19, 1e-14][o];
                        let off = (h[(o, i)] - exact).norm();
                        let size = exact.norm() + floor / 1e-10;
                        within("responses", off / size, 1e-10);
                    }
                }
            }
        }
    }
}

/// Reciprocity, and a sum over modes against direct solutions, on shipped machines.
#[test]
fn law_reciprocity_and_modal_sum() {
    let cases: [(&str, [&str; 3], SolverKind); 4] = [
        (
            "y2250.toml",
            ["motor", "workpiece", "cutter_head"],
            SolverKind::ComplexModes,
        ),
        (
            "five_disc_chain.toml",
            ["disc_1", "disc_3", "disc_5"],
            SolverKind::RealModes,
        ),
        (
            "helical_lateral.toml",
            ["motor", "pinion.x", "machine"],
            SolverKind::ComplexModes,
        ),
        ("drill_string.toml", ["", "", ""], SolverKind::RealModes),
    ];
    for (file, ports, how) in cases {
        let machine = shipped(file);
        let all: Vec<String> = (0..machine.machine.dofs.len())
            .map(|f| machine.machine.dof_name(f))
            .collect();
        let ports: Vec<&str> = match ports[0] {
            "" => vec![&all[0], &all[all.len() / 2], &all[all.len() - 1]],
            _ => ports.to_vec(),
        };
        let omega: Vec<f64> = (0..40)
            .map(|k| TAU * 10f64.powf(-1.0 + 0.1 * f64::from(k)))
            .collect();
        let ask = |method| Ask {
            inputs: &ports,
            outputs: &ports,
            way: method,
            ..Ask::default()
        };
        let direct = answer(&machine, &ask(ResponseMethod::Direct), &omega).unwrap();
        let modal = answer(&machine, &ask(ResponseMethod::Modal), &omega).unwrap();
        assert_eq!(modal.solver, how, "{file}: {:?}", modal.stats);
        for (line, (d, m)) in direct.values.iter().zip(&modal.values).enumerate() {
            let symmetric = apart(d, &d.transpose().to_owned());
            assert!(
                symmetric <= 1e-10,
                "{file} line {line}: reciprocity {symmetric:.1e}"
            );
            assert!(
                apart(d, m) <= 1e-10,
                "{file} line {line}: modes {:.1e}",
                apart(d, m)
            );
        }
    }
}

#[test]
fn refuses_what_has_no_answer() {
    let two = shipped("two_disc.toml");
    let code = |ask: &Ask, omega: f64| answer(&two, ask, &[omega]).unwrap_err().code;
    let absolute = Ask {
        inputs: &["disc_1"],
        outputs: &["disc_2"],
        ..Ask::default()
    };
    assert_eq!(code(&absolute, 0.0), Code::Conflict);
    assert_eq!(code(&absolute, f64::NAN), Code::OutOfRange);
    assert_eq!(code(&absolute, -1.0), Code::OutOfRange);
    let nothing = Ask {
        inputs: &["ground.x"],
        outputs: &["disc_2"],
        ..Ask::default()
    };
    assert_eq!(code(&nothing, 1.0), Code::Conflict);
    let twice = Ask {
        inputs: &["disc_1"],
        outputs: &["disc_2"],
        held: &["disc_1", "disc_1.theta"],
        ..Ask::default()
    };
    assert!(answer(&two, &twice, &[1.0]).is_ok());
    let sums = Ask {
        inputs: &["disc_1"],
        outputs: &["disc_2 - disc_1.speed"],
        ..Ask::default()
    };
    assert_eq!(code(&sums, 1.0), Code::Conflict);
    let unknown = Ask {
        inputs: &["disc_9"],
        outputs: &["disc_2"],
        ..Ask::default()
    };
    assert_eq!(code(&unknown, 1.0), Code::UnknownNode);
    let held = Ask {
        inputs: &["disc_1"],
        outputs: &["disc_2"],
        held: &["disc_1"],
        ..Ask::default()
    };
    // A held driver leaves the torque on it nothing to move.
    assert_eq!(
        answer(&two, &held, &[3.0]).unwrap().values[0][(0, 0)],
        Complex::ZERO
    );
}

/// An eccentric wheel, its driver turning evenly: the steady motion integrated from its periodic start, against T(ω).
#[test]
fn law_error_against_integration() {
    let text = r#"
inertia = [{ name = "a", J = 0.02 }, { name = "b", J = 0.004 }, { name = "c", J = 0.03 }, { name = "d", J = 0.006 }, { name = "e", J = 0.05 }]
shaft = [{ name = "s1", between = ["a", "b"], k = 9000, c = 8.0 }, { name = "s2", between = ["c", "d"], k = 20000, c = 9.0 }]
gear_pair = [
  { name = "p1", between = ["b", "c"], teeth = [20, 50], module = 0.003, k = 3e8, c = 9000 },
  { name = "p2", between = ["d", "e"], teeth = [18, 45], module = 0.004, k = 2e8, c = 9000 },
]
damper = [{ name = "brake", at = "e", c = 2.5 }]
motor = [{ name = "m", at = "a", kind = "speed", speed = "900 rad/s" }]
error = [{ on = "c", mesh = "p1", cause = "eccentricity", amplitude = 1e-2, phase = 0.4 }]
[speed]
a = "900 rad/s"
"#;
    let scene =
        geardyn::internals::scene::read_text("test.toml", &format!("{HEAD}{text}")).unwrap();
    let machine = PreparedMachine::new(&scene.model).unwrap();
    let speeds = mean_speeds(&machine.machine, &machine.kinematics, None).unwrap();
    let model = assemble(
        &machine.machine,
        &machine.kinematics,
        &machine.operating,
        &InitialConditions {
            phase: MeshPhase::Speed,
            ..InitialConditions::default()
        },
        Some(&speeds),
    )
    .unwrap();
    let error = model
        .model
        .elements
        .iter()
        .find_map(|b| b.imposed_displacement.clone())
        .unwrap()
        .harmonics[0];
    let period = TAU / error.omega.abs();

    // The map over a period is affine; its fixed point is the periodic start. What is prescribed is taken out, even turning with it.
    let n = 4;
    let samples = 32;
    let run = |start: &[f64]| {
        support::moving::run("dop853", &model.model, start, period, samples)
            .unwrap()
            .1
    };
    let base = vec![0.0; 2 * n];
    let end = run(&base)[samples].clone();
    let mut system = Matrix::zeros(8, 8);
    for j in 0..2 * n {
        let mut start = base.clone();
        start[j] += 1.0;
        let moved = run(&start)[samples].clone();
        for i in 0..2 * n {
            system[(i, j)] = moved[i] - end[i] - f64::from(u8::from(i == j));
        }
    }
    let right = Matrix::from_fn(2 * n, 1, |i, _| -end[i]);
    let start = geardyn::internals::numeric::symmetric::lu_solve(&system, &right).unwrap();
    let periodic: Vec<f64> = (0..2 * n).map(|i| start[(i, 0)]).collect();
    let states = run(&periodic);

    let ask = Ask {
        inputs: &["p1.te"],
        outputs: &["b", "e", "e.speed"],
        held: &["a"],
        ..Ask::default()
    };
    let h = &answer(&machine, &ask, &[error.omega.abs()]).unwrap().values[0];
    let drive = Complex::new(
        error.amplitude * error.phase.cos(),
        error.amplitude * error.phase.sin(),
    );
    let drive = if error.omega < 0.0 {
        drive.conj()
    } else {
        drive
    };
    for (o, state) in [0, 3, n + 3].into_iter().enumerate() {
        let mut line = Complex::ZERO;
        for (k, y) in states[..samples].iter().enumerate() {
            let turn = TAU * k as f64 / samples as f64;
            line += Complex::new(turn.cos(), -turn.sin()) * y[state] * (2.0 / samples as f64);
        }
        close(line, h[(o, 0)] * drive, 1e-8);
    }
}
