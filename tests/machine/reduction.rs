//! Model reduction: what each method promises, on chains, trees, free and held machines.

use std::path::Path;

use crate::support::verification::within;
use geardyn::internals::base::code::Code;
use geardyn::internals::machine::{
    build::build, components::Machine, kinematics::Kinematics, linear::LinearModel,
    operating_point::OperatingPoint,
};
use geardyn::internals::modes::modal_basis::{self, ModalBasis, UndampedSolver};
use geardyn::internals::modes::reduction::{
    BandError, ComparisonBand, ModeSelection, ReducedModel, ReductionMethod, coordinate_by_name,
    find_condensable, natural_frequencies,
};
use geardyn::internals::modes::state_space::StateSpace;
use geardyn::internals::modes::system_matrices::{AnalysisContext, SystemMatrices};
use geardyn::internals::numeric::{Complex, ComplexMatrix, symmetric};

const TAU: f64 = std::f64::consts::TAU;

struct Ready {
    machine: Machine,
    linear: LinearModel,
    basis: ModalBasis,
}

impl Ready {
    fn case(&self) -> AnalysisContext<'_> {
        AnalysisContext {
            machine: &self.machine,
            model: &self.linear,
            basis: &self.basis,
            speeds: None,
        }
    }

    fn at(&self, names: &[&str]) -> Vec<usize> {
        names
            .iter()
            .map(|name| coordinate_by_name(&self.machine, &self.linear, name).unwrap())
            .collect()
    }

    fn hz(&self, mode: usize) -> f64 {
        self.basis.omega[mode] / TAU
    }

    fn reduce(&self, method: ReductionMethod) -> ReducedModel {
        ReducedModel::new(&self.case(), method).unwrap()
    }

    fn compare(&self, method: ReductionMethod, f_max_hz: f64, ports: &[&str]) -> BandError {
        let dofs: Vec<usize> = ports.iter().map(|p| self.machine.dof(p).unwrap()).collect();
        self.reduce(method)
            .compare(
                &self.case(),
                &ComparisonBand::new(f_max_hz, dofs.clone(), dofs),
            )
            .unwrap()
    }

    /// Receptance between coordinates: of the full machine, and of the reduced one.
    fn receptance(&self, reduced: &SystemMatrices, at: &[usize], s: Complex) -> ComplexMatrix {
        let n = reduced.len();
        let t = |j: usize, i: usize| Complex::new(reduced.transform[(at[i], j)], 0.0);
        let load = ComplexMatrix::from_fn(n, at.len(), t);
        load.transpose()
            * symmetric::lu_solve_complex(&reduced.dynamic_stiffness(s), &load).unwrap()
    }

    fn full(&self) -> SystemMatrices {
        SystemMatrices::in_basis(
            &self.case(),
            geardyn::internals::numeric::Matrix::identity(self.linear.n, self.linear.n),
            Vec::new(),
            0,
        )
    }
}

fn ready(model: &geardyn::internals::scene::model::Model) -> Ready {
    let machine = build(model).unwrap();
    let kinematics = Kinematics::new(&machine).unwrap();
    let operating = OperatingPoint::solve(&machine, &kinematics).unwrap();
    let linear_model = LinearModel::new(&machine, &kinematics, &operating).unwrap();
    let basis = modal_basis::solve(&linear_model, UndampedSolver::Factored).unwrap();
    Ready {
        machine,
        linear: linear_model,
        basis,
    }
}

fn written(text: &str) -> Ready {
    let head = "title = \"test\"\nsource = \"made for a test\"\nunits = \"SI\"\n";
    ready(
        &geardyn::internals::scene::read_text("test.toml", &format!("{head}{text}"))
            .unwrap()
            .model,
    )
}

fn shipped(name: &str) -> Ready {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("models")
        .join(name);
    ready(&geardyn::internals::scene::read(&path).unwrap().model)
}

fn chain(held: &str, loss: &str) -> Ready {
    written(&format!(
        "[[chain]]\nname = \"row\"\ncount = 30\nJ = 0.02\nk = 5e4\nheld = \"{held}\"\n{loss}\n"
    ))
}

/// Two branches of five discs on a trunk of five, of uneven sizes; `loss` for every shaft.
fn tree(held: bool, loss: &str) -> Ready {
    let mut text = String::new();
    let size = |n: usize| 0.01 * (1.0 + ((7 * n) % 5) as f64);
    let stiffness = |n: usize| 1e4 * (1.0 + ((5 * n) % 7) as f64);
    for n in 0..15 {
        text += &format!("[[inertia]]\nname = \"d{n}\"\nJ = {:?}\n", size(n));
    }
    let mut shaft = |a: String, b: String, n: usize| {
        text += &format!(
            "[[shaft]]\nname = \"s{n}\"\nbetween = [\"{a}\", \"{b}\"]\nk = {:?}\n{loss}\n",
            stiffness(n)
        );
    };
    for n in 1..15 {
        let before = if n == 10 { 4 } else { n - 1 };
        shaft(format!("d{before}"), format!("d{n}"), n);
    }
    if held {
        shaft("ground".to_string(), "d0".to_string(), 15);
    }
    written(&text)
}

fn difference(a: &ComplexMatrix, b: &ComplexMatrix) -> f64 {
    (a - b).norm_max() / a.norm_max()
}

fn every(n: usize, step: usize) -> Vec<usize> {
    (0..n).step_by(step).collect()
}

/// Static reduction keeps what is at rest.
#[test]
fn exact_guyan_at_rest() {
    for ready in [chain("start", ""), tree(true, "")] {
        let masters = every(ready.linear.n, 4);
        let model = ready.reduce(ReductionMethod::Guyan {
            masters: masters.clone(),
        });
        let zero = Complex::new(0.0, 0.0);
        let error = difference(
            &ready.receptance(&ready.full(), &masters, zero),
            &ready.receptance(&model.matrices, &masters, zero),
        );
        within("receptances", error, 1e-12);
    }
}

/// Dynamic reduction is exact at its frequency.
#[test]
fn exact_dynamic_at_its_frequency() {
    for ready in [chain("none", ""), tree(true, "")] {
        let masters = every(ready.linear.n, 4);
        let at_hz = 0.5 * (ready.hz(3) + ready.hz(4));
        let model = ready.reduce(ReductionMethod::Dynamic {
            masters: masters.clone(),
            at_hz,
        });
        let error = |hz: f64| {
            let s = Complex::new(0.0, TAU * hz);
            difference(
                &ready.receptance(&ready.full(), &masters, s),
                &ready.receptance(&model.matrices, &masters, s),
            )
        };
        within("receptances", error(at_hz), 1e-10);
        assert!(error(1.3 * at_hz) > 1e-6, "{}", error(1.3 * at_hz));
    }
}

/// With all interior modes nothing is lost, damped or not, free or held, loaded anywhere.
#[test]
fn exact_craig_bampton_with_all_modes() {
    for ready in [
        chain("none", "damping_ratio = 0.01"),
        tree(true, "c = 2.0"),
        tree(false, "loss_factor = 0.02"),
        shipped("lin_parker_n3.toml"),
    ] {
        let model = ready.reduce(ReductionMethod::CraigBampton {
            boundary: vec![0, 1],
            selection: ModeSelection::Count(usize::MAX),
        });
        assert!(model.lowest_omitted.is_none());
        let all: Vec<usize> = (0..ready.linear.n).collect();
        let s = Complex::new(0.02, 1.0) * ready.basis.omega[ready.basis.n_rigid + 1] * 1.1;
        let error = difference(
            &ready.receptance(&ready.full(), &all, s),
            &ready.receptance(&model.matrices, &all, s),
        );
        within("receptances", error, 1e-9);
    }
}

/// Frequencies come from above, and nearer with every interior mode; free motions stay exactly free.
#[test]
fn law_craig_bampton_converges_from_above() {
    for (name, ready) in [
        ("chain", chain("none", "")),
        ("tree", tree(true, "")),
        ("ieee", shipped("ieee_first_benchmark.toml")),
    ] {
        let rigid = ready.basis.n_rigid;
        let mut before = f64::INFINITY;
        for n in 0..5 {
            let model = ready.reduce(ReductionMethod::CraigBampton {
                boundary: vec![0, ready.linear.n - 1],
                selection: ModeSelection::Count(n),
            });
            let found = natural_frequencies(&ready.linear, &model.matrices).unwrap();
            assert!(found[..rigid].iter().all(|&w| w == 0.0));
            let error = found[rigid] / ready.basis.omega[rigid] - 1.0;
            println!("{name} {n} {error:.2e}");
            assert!(
                error >= -1e-12 && error <= before + 1e-12,
                "{name} {n} {error}"
            );
            before = error;
        }
        assert!(before < 1e-2, "{name} {before}");
    }
}

/// What a rigid motion of all coordinates is to the reduced machine: the same kinetic energy, and no force.
#[test]
fn law_rigid_motions_survive() {
    for ready in [
        chain("none", ""),
        tree(false, ""),
        shipped("geared_motor_rolls.toml"),
        shipped("five_disc_chain.toml"),
    ] {
        let n = ready.linear.n;
        let methods = [
            ReductionMethod::Guyan {
                masters: vec![0, n - 1],
            },
            ReductionMethod::CraigBampton {
                boundary: vec![0, n - 1],
                selection: ModeSelection::Count(2),
            },
            ReductionMethod::Modal {
                selection: ModeSelection::Count(1),
                ports: vec![0],
            },
        ];
        for method in methods {
            let model = ready.reduce(method.clone());
            for motion in modal_basis::rigid_modes(&ready.linear) {
                let e = &model.matrices;
                // The coordinates of the motion: kept ones, modes at rest; or the rigid mode itself.
                let r: Vec<f64> = match &method {
                    ReductionMethod::Modal { .. } => {
                        (0..e.len()).map(|j| f64::from(u8::from(j == 0))).collect()
                    }
                    _ => (0..e.len())
                        .map(|j| [0, n - 1].get(j).map_or(0.0, |&i| motion[i]))
                        .collect(),
                };
                let product = |m: &geardyn::internals::numeric::Matrix| -> f64 {
                    (0..r.len())
                        .map(|i| (0..r.len()).map(|j| r[i] * m[(i, j)] * r[j]).sum::<f64>())
                        .sum()
                };
                assert!((product(&e.mass) - 1.0).abs() < 1e-12, "{method:?}");
                let force = (0..r.len())
                    .map(|i| {
                        (0..r.len())
                            .map(|j| e.stiffness[(i, j)] * r[j])
                            .sum::<f64>()
                            .abs()
                    })
                    .fold(0.0, f64::max);
                let size = e.stiffness.norm_max() * r.iter().fold(0.0f64, |a, x| a.max(x.abs()));
                assert!(force <= 1e-12 * size, "{method:?}: {force} of {size}");
            }
            if ready.basis.n_rigid > 0 {
                assert_eq!(
                    natural_frequencies(&ready.linear, &model.matrices).unwrap()[0],
                    0.0
                );
            }
        }
    }
}

/// `H_ab = H_ba` of the reduced machine too.
#[test]
fn law_reciprocity() {
    for ready in [
        chain("none", "damping_ratio = 0.02"),
        tree(true, "c = 3.0"),
        tree(false, "loss_factor = 0.05"),
    ] {
        let n = ready.linear.n;
        for method in [
            ReductionMethod::Guyan {
                masters: vec![0, 7, n - 1],
            },
            ReductionMethod::Dynamic {
                masters: vec![0, 7, n - 1],
                at_hz: 0.8 * ready.hz(1),
            },
            ReductionMethod::CraigBampton {
                boundary: vec![0, 7],
                selection: ModeSelection::Count(4),
            },
            ReductionMethod::Modal {
                selection: ModeSelection::Count(4),
                ports: vec![0, n - 1],
            },
        ] {
            let model = ready.reduce(method);
            let h = ready.receptance(
                &model.matrices,
                &[0, 3, n - 1],
                Complex::new(0.0, 0.7 * ready.basis.omega[2]),
            );
            assert!(difference(&h, &h.transpose().to_owned()) < 1e-12);
        }
    }
}

/// Attachment modes make truncated modes exact at rest, where that is finite.
#[test]
fn exact_modal_at_rest() {
    let ready = tree(true, "");
    let zero = Complex::new(0.0, 0.0);
    let ports = [0, 9, 14];
    let model = ready.reduce(ReductionMethod::Modal {
        selection: ModeSelection::Count(2),
        ports: ports.to_vec(),
    });
    let error = difference(
        &ready.receptance(&ready.full(), &ports, zero),
        &ready.receptance(&model.matrices, &ports, zero),
    );
    within("receptances", error, 1e-12);
}

/// The estimate is no less than half the measured error wherever it is finite, and not wildly more.
#[test]
fn law_estimates_hold() {
    let machines = [
        ("chain free", chain("none", ""), ["row.1", "row.30"]),
        ("chain held", chain("start", ""), ["row.1", "row.30"]),
        (
            "chain damped",
            chain("both", "damping_ratio = 0.03"),
            ["row.10", "row.25"],
        ),
        (
            "chain lossy",
            chain("none", "loss_factor = 0.02"),
            ["row.1", "row.20"],
        ),
        ("tree free", tree(false, ""), ["d0", "d9"]),
        (
            "tree held",
            tree(true, "damping_ratio = 0.01"),
            ["d9", "d14"],
        ),
        ("tree viscous", tree(true, "c = 1.0"), ["d0", "d14"]),
    ];
    let (mut least, mut finite) = (f64::INFINITY, 0);
    for (name, ready, ports) in &machines {
        let at = ready.at(ports);
        let n = ready.linear.n;
        let rigid = ready.basis.n_rigid;
        let mut masters = every(n, 3);
        masters.extend(at.iter().filter(|j| *j % 3 != 0));
        let methods = [
            (
                "guyan",
                ReductionMethod::Guyan {
                    masters: masters.clone(),
                },
            ),
            (
                "dynamic",
                ReductionMethod::Dynamic {
                    masters,
                    at_hz: ready.hz(rigid + 1) * 1.1,
                },
            ),
            (
                "craig-bampton",
                ReductionMethod::CraigBampton {
                    boundary: at.clone(),
                    selection: ModeSelection::Count(6),
                },
            ),
            (
                "modal",
                ReductionMethod::Modal {
                    selection: ModeSelection::Count(6),
                    ports: at.clone(),
                },
            ),
        ];
        for (word, method) in methods {
            for top in [1, 3, 5] {
                let found = ready.compare(method.clone(), ready.hz(rigid + top) * 1.05, ports);
                let ratio = found.estimate / found.measured;
                println!(
                    "{name:13} {word:14} {top} estimate {:.1e} measured {:.1e} ratio {ratio:9.2} pointwise {:.1e} at {:.1} Hz",
                    found.estimate, found.measured, found.pointwise, found.worst_at_hz
                );
                assert!(
                    found.measured.is_finite() && found.pointwise + 1e-12 >= found.measured,
                    "{name} {word} {top}"
                );
                if found.estimate.is_finite() && found.measured > 1e-9 {
                    least = least.min(ratio);
                    finite += 1;
                }
            }
        }
    }
    println!("least estimate / measured {least:.2} of {finite}");
    assert!(least > 0.5 && finite > 40, "{least} {finite}");
}

/// A reduced machine in state space answers as its equations do.
#[test]
fn exact_reduced_state_space() {
    let ready = tree(true, "c = 1.0");
    let model = ready.reduce(ReductionMethod::CraigBampton {
        boundary: vec![0, 14],
        selection: ModeSelection::Below(ready.hz(5)),
    });
    let names = ["d0".to_string(), "d14".to_string()];
    let space = StateSpace::from_matrices(&ready.case(), &model.matrices, &names, &names).unwrap();
    let s = Complex::new(0.0, 0.9 * ready.basis.omega[2]);
    let error = difference(
        &ready.receptance(&model.matrices, &[0, 14], s),
        &space.transfer(s).unwrap(),
    );
    within("receptances", error, 1e-10);
}

/// A light disc on a stiff shaft and a massless joint can go; what matters in the band stays.
#[test]
fn exact_advice_names_light_ends() {
    let ready = written(
        "
[[inertia]]
name = \"motor\"
J = 1.0
[[inertia]]
name = \"hub\"
J = 1e-6
[[inertia]]
name = \"joint\"
J = 0.0
[[inertia]]
name = \"roll\"
J = 2.0
[[shaft]]
name = \"one\"
between = [\"motor\", \"hub\"]
k = 1e4
[[shaft]]
name = \"two\"
between = [\"hub\", \"joint\"]
k = 1e4
[[shaft]]
name = \"three\"
between = [\"joint\", \"roll\"]
k = 1e4
",
    );
    let advice = find_condensable(&ready.case(), 100.0, 1e-3).unwrap();
    let names: Vec<String> = advice
        .coordinates
        .iter()
        .map(|c| ready.machine.dof_name(c.dof))
        .collect();
    assert_eq!(names, ["joint.theta", "hub.theta"]);
    assert!(
        advice.coordinates[0].fixed_frequency_hz.is_infinite()
            && (advice.coordinates[1].fixed_frequency_hz - (2e10f64).sqrt() / TAU).abs() < 1e-6
    );
    assert_eq!(advice.n_compared, 1);
    assert!(advice.max_change < 1e-6, "{}", advice.max_change);
    // Nothing can go from a chain whose whole band is asked for.
    let uniform = chain("start", "");
    assert!(
        find_condensable(&uniform.case(), uniform.hz(29), 1e-6)
            .unwrap()
            .coordinates
            .is_empty()
    );
}

/// Every shipped model takes advice, whatever it is.
#[test]
fn survives_shipped_models() {
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join("models")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if !name.ends_with(".toml") {
            continue;
        }
        let ready = shipped(&name);
        if ready.linear.n > 60 || ready.basis.omega.len() <= ready.basis.n_rigid {
            continue;
        }
        let f_max = ready.hz(ready.basis.n_rigid) * 1.5;
        let advice = find_condensable(&ready.case(), f_max, 0.01).unwrap();
        println!(
            "{name}: {} of {} can go below {f_max:.1} Hz, change {:.1e}",
            advice.coordinates.len(),
            ready.linear.n,
            advice.max_change
        );
        assert!(advice.max_change <= 0.01 && advice.coordinates.len() < ready.linear.n);
    }
}

#[test]
fn refuses_what_cannot_be_kept() {
    let ready = tree(false, "");
    let refused =
        |method: ReductionMethod| ReducedModel::new(&ready.case(), method).unwrap_err().code;
    assert_eq!(
        refused(ReductionMethod::Guyan { masters: vec![] }),
        Code::Disconnected
    );
    assert_eq!(
        refused(ReductionMethod::Guyan { masters: vec![99] }),
        Code::OutOfRange
    );
    assert_eq!(
        refused(ReductionMethod::Modal {
            selection: ModeSelection::Count(1),
            ports: vec![3, 3]
        }),
        Code::OutOfRange
    );
    let model = ready.reduce(ReductionMethod::Guyan { masters: vec![0] });
    let error = model
        .compare(&ready.case(), &ComparisonBand::new(0.0, vec![0], vec![0]))
        .unwrap_err();
    assert_eq!(error.code, Code::OutOfRange);
    assert_eq!(
        find_condensable(&ready.case(), 10.0, 0.0).unwrap_err().code,
        Code::OutOfRange
    );
}
