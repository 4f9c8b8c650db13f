//! What every machine's modes obey, on machines from seeds, and closed forms of damped ones.

use std::collections::HashMap;

use crate::support::machines::{self, Description, Random, Unit};
use crate::support::{Solved, damped, model, plain, solve, solve_file, solve_model, within, worst};
use geardyn::internals::base::code::Code;
use geardyn::internals::machine::components::{BranchLaw, Machine};
use geardyn::internals::modes::mode::Mode;
use geardyn::internals::modes::sensitivity::SensitivityParameter;
use geardyn::internals::numeric::Complex;

const HEAD: &str = "units = \"SI\"\ntitle = \"small\"\nsource = \"a test\"\n";

fn real(mode: &Mode) -> Vec<f64> {
    mode.shape.iter().map(|x| x.re).collect()
}

/// Over all freedoms, those that rigid joints tie included.
fn kinetic(machine: &Machine, a: &[f64], b: &[f64]) -> f64 {
    let masses = machine.masses.iter();
    masses
        .map(|m| m.value * m.direction.dot(a) * m.direction.dot(b))
        .sum()
}

fn strain(machine: &Machine, a: &[f64], b: &[f64]) -> f64 {
    let branches = machine.branches.iter();
    branches
        .map(|branch| match branch.law {
            BranchLaw::Linear { stiffness, .. } => {
                stiffness * branch.direction.dot(a) * branch.direction.dot(b)
            }
            BranchLaw::Rigid => 0.0,
        })
        .sum()
}

fn every(check: impl Fn(&Description, &Solved) -> f64, what: &str, tolerance: f64) {
    for description in machines::all() {
        let solved = solve(&description.text(), &plain());
        let error = check(&description, &solved);
        within(&format!("{what}: {}", description.family), error, tolerance);
    }
}

/// `φᵢᵀ M φⱼ = δᵢⱼ` over all freedoms, rigid joints recovered.
#[test]
fn law_shapes_are_orthonormal_in_the_masses() {
    let check = |_: &Description, solved: &Solved| {
        let shapes: Vec<Vec<f64>> = solved.answer.modes.iter().map(real).collect();
        let mut worst: f64 = 0.0;
        for i in 0..shapes.len() {
            for j in 0..shapes.len() {
                let unit = f64::from(u8::from(i == j));
                let product = kinetic(&solved.prepared.machine, &shapes[i], &shapes[j]);
                worst = worst.max((product - unit).abs());
            }
        }
        worst
    };
    every(check, "M-orthonormal", 1e-12);
}

/// `φᵢᵀ K φⱼ = ωᵢ² δᵢⱼ`: Rayleigh's quotient, and as much strain energy as kinetic energy; relative to ωᵢωⱼ, rigid modes to the highest.
#[test]
fn law_strain_energy_is_rayleighs_quotient() {
    let check = |_: &Description, solved: &Solved| {
        let omega = solved.omega();
        let top = omega.last().copied().unwrap();
        let shapes: Vec<Vec<f64>> = solved.answer.modes.iter().map(real).collect();
        let size = |w: f64| if w == 0.0 { 1e-3 * top } else { w };
        let mut worst: f64 = 0.0;
        for i in 0..shapes.len() {
            for j in 0..shapes.len() {
                let exact = if i == j { omega[i] * omega[i] } else { 0.0 };
                let product = strain(&solved.prepared.machine, &shapes[i], &shapes[j]);
                worst = worst.max((product - exact).abs() / size(omega[i]) / size(omega[j]));
            }
        }
        worst
    };
    every(check, "Rayleigh", 1e-11);
}

/// Rigid joints do not strain, in no mode.
#[test]
fn law_rigid_joints_do_not_strain() {
    let check = |_: &Description, solved: &Solved| {
        let mut worst: f64 = 0.0;
        let machine = &solved.prepared.machine;
        for branch in machine
            .branches
            .iter()
            .filter(|b| b.law == BranchLaw::Rigid)
        {
            for shape in solved.answer.modes.iter().map(real) {
                let size: f64 = branch
                    .direction
                    .entries()
                    .map(|(i, a)| (a * shape[i]).abs())
                    .sum();
                if size > 0.0 {
                    worst = worst.max(branch.direction.dot(&shape).abs() / size);
                }
            }
        }
        worst
    };
    every(check, "rigid joints", 1e-15);
}

/// Shares of kinetic and of strain energy each sum to one; rigid modes have no strain.
#[test]
fn law_energy_shares_sum_to_one() {
    let check = |_: &Description, solved: &Solved| {
        let mut worst: f64 = 0.0;
        for (mode, energies) in solved.answer.modes.iter().zip(&solved.answer.energies) {
            let sum = |shares: &[(usize, f64)]| shares.iter().map(|s| s.1).sum::<f64>();
            worst = worst.max((sum(&energies.kinetic) - 1.0).abs());
            assert_eq!(energies.strain.is_none(), mode.rigid);
            if let Some(strain) = &energies.strain {
                worst = worst.max((sum(strain) - 1.0).abs());
            }
        }
        worst
    };
    every(check, "shares", 1e-14);
}

/// Sensitivities of one mode sum to ½ over all stiffnesses and to −½ over all inertias, as ω ∝ √(k/J).
#[test]
fn law_sensitivities_sum_to_halves() {
    let check = |_: &Description, solved: &Solved| {
        let lists = solved.answer.sensitivities.as_ref().unwrap();
        let mut worst: f64 = 0.0;
        let mut group: Vec<usize> = Vec::new();
        for (at, mode) in solved.answer.modes.iter().enumerate() {
            assert_eq!(lists[at].is_empty(), mode.rigid);
            if mode.rigid {
                continue;
            }
            let first = group.first().map(|&g| solved.answer.modes[g].omega());
            if first.is_some_and(|w| (mode.omega() / w - 1.0).abs() > 1e-9) {
                group.clear();
            }
            group.push(at);
            let last = solved.answer.modes.get(at + 1);
            if last.is_some_and(|m| (m.omega() / mode.omega() - 1.0).abs() < 1e-9) {
                continue;
            }
            // Of a repeated frequency, the mean over its set: the trace.
            for (parameter, half) in [
                (SensitivityParameter::Stiffness, 0.5),
                (SensitivityParameter::Inertia, -0.5),
            ] {
                let sum: f64 = group
                    .iter()
                    .flat_map(|&g| &lists[g])
                    .filter(|s| s.parameter == parameter)
                    .map(|s| s.relative)
                    .sum();
                worst = worst.max((sum / group.len() as f64 - half).abs());
            }
        }
        worst
    };
    every(check, "sums of sensitivities", 1e-11);
}

/// The backward error of every mode is rounding.
#[test]
fn law_residuals_are_rounding() {
    let check = |_: &Description, solved: &Solved| {
        let residuals = solved.answer.modes.iter().map(|mode| mode.residual);
        residuals.fold(0.0, f64::max)
    };
    every(check, "residual", 1e-14);
}

/// As many zero frequencies as the machine has ways to move, each exactly zero.
#[test]
fn law_rigid_modes_are_exact_zeros() {
    let check = |description: &Description, solved: &Solved| {
        assert_eq!(
            solved.n_rigid(),
            description.n_rigid,
            "{}",
            description.family
        );
        let zeros = solved.omega().iter().filter(|&&w| w == 0.0).count();
        assert_eq!(zeros, description.n_rigid, "{}", description.family);
        0.0
    };
    every(check, "rigid modes", 0.0);
}

/// The same machine in grams, millimetres, newtons per micrometre.
#[test]
fn law_units_do_not_matter() {
    let check = |description: &Description, solved: &Solved| {
        let other = solve(&description.workshop_text(), &plain());
        worst(&other.omega(), &solved.omega())
    };
    every(check, "units", 1e-13);
}

/// The same machine told in another order: the same frequencies, and shapes up to sign where no frequency is repeated.
#[test]
fn law_order_of_the_file_does_not_matter() {
    let check = |description: &Description, solved: &Solved| {
        let other = solve(&description.shuffled(&mut Random::new(7)).text(), &plain());
        let omega = solved.omega();
        let mut error = worst(&other.omega(), &omega);
        let (here, there) = (&solved.prepared.machine, &other.prepared.machine);
        for (at, mode) in solved.answer.modes.iter().enumerate() {
            let apart = |i: usize| {
                omega
                    .get(i)
                    .is_none_or(|w| (w - omega[at]).abs() > 1e-3 * omega[at])
            };
            if at == 0 || !apart(at - 1) || !apart(at + 1) {
                continue;
            }
            let shape = &other.answer.modes[at].shape;
            let named = |i: usize| shape[there.dof(&here.dof_name(i)).unwrap()].re;
            let largest = mode.shape.iter().fold(0.0f64, |m, x| m.max(x.re.abs()));
            let lead = mode
                .shape
                .iter()
                .position(|x| x.re.abs() == largest)
                .unwrap();
            let sign = (named(lead) * mode.shape[lead].re).signum();
            for (i, x) in mode.shape.iter().enumerate() {
                error = error.max((x.re - sign * named(i)).abs() / largest * 1e-1);
            }
        }
        error
    };
    every(check, "order", 1e-12);
}

/// `ω ∝ √(k/J)`.
#[test]
fn law_scaling() {
    let check = |description: &Description, solved: &Solved| {
        let scaled = description.changed(None, Unit::is_stiffness, 64.0).changed(
            None,
            Unit::is_inertia,
            9.0,
        );
        let exact: Vec<f64> = solved.omega().iter().map(|w| w * 8.0 / 3.0).collect();
        worst(&solve(&scaled.text(), &plain()).omega(), &exact)
    };
    every(check, "scaling", 1e-13);
}

/// Slopes of all frequencies for one change, from both sides; the branches of a repeated frequency by their order.
fn slopes(solved: &Solved, changed: impl Fn(f64) -> Vec<f64>) -> Vec<f64> {
    const H: f64 = 1e-5;
    let (up, down, omega) = (changed(1.0 + H), changed(1.0 - H), solved.omega());
    let same = |i: usize, j: usize| (omega[i] - omega[j]).abs() <= 1e-9 * omega[i];
    (0..omega.len())
        .map(|i| {
            let first = (0..=i).rev().take_while(|&j| same(i, j)).last().unwrap();
            let last = (i..omega.len()).take_while(|&j| same(i, j)).last().unwrap();
            (up[i] - down[first + last - i]) / (2.0 * H * omega[i])
        })
        .collect()
}

/// Compares every sensitivity with central differences of the whole computation.
fn compare(solved: &Solved, change: impl Fn(&str, SensitivityParameter, f64) -> Vec<f64>) -> f64 {
    let machine = &solved.prepared.machine;
    let lists = solved.answer.sensitivities.as_ref().unwrap();
    let mut measured: HashMap<(usize, usize), Vec<f64>> = HashMap::new();
    let mut worst: f64 = 0.0;
    for (at, list) in lists.iter().enumerate() {
        for s in list {
            let name = &machine.elements[s.element].name;
            let slope = measured
                .entry((s.element, s.parameter as usize))
                .or_insert_with(|| slopes(solved, |factor| change(name, s.parameter, factor)));
            worst = worst.max((slope[at] - s.relative).abs());
        }
    }
    worst
}

/// Every sensitivity of every machine against ±1e-5 of the parameter.
#[test]
fn law_sensitivities_are_slopes() {
    let check = |description: &Description, solved: &Solved| {
        compare(solved, |name, parameter, factor| {
            let which = match parameter {
                SensitivityParameter::Stiffness => Unit::is_stiffness,
                SensitivityParameter::Inertia => Unit::is_inertia,
            };
            let changed = description.changed(Some(name), which, factor);
            solve(&changed.text(), &plain()).omega()
        })
    };
    every(check, "sensitivities", 1e-7);
}

/// One of two equal supports at right angles splits the repeated frequencies of a planetary stage: slopes of the set.
#[test]
fn law_sensitivities_of_repeated_frequencies() {
    let file = std::fs::read_to_string("models/lin_parker_n4.toml").unwrap();
    let text = |factor: f64| {
        let one = "name = \"sun_support\"\nat = \"sun\"\nk_radial = \"1e8 N/m\"";
        assert!(file.contains(one));
        let two = format!(
            "name = \"sun_x\"\nat = \"sun\"\nk_x = \"{:e} N/m\"\n\n[[bearing]]\nname = \"sun_y\"\nat = \"sun\"\nk_y = \"1e8 N/m\"",
            1e8 * factor
        );
        file.replace(one, &two)
    };
    let solved = solve(&text(1.0), &plain());
    let machine = &solved.prepared.machine;
    let lists = solved.answer.sensitivities.as_ref().unwrap();
    let slope = slopes(&solved, |factor| solve(&text(factor), &plain()).omega());
    let (mut error, mut largest): (f64, f64) = (0.0, 0.0);
    for (at, list) in lists.iter().enumerate() {
        let found = list
            .iter()
            .find(|s| machine.elements[s.element].name == "sun_x")
            .map_or(0.0, |s| s.relative);
        error = error.max((found - slope[at]).abs());
        largest = largest.max(found);
    }
    assert!(largest > 0.1, "the support matters to some pair: {largest}");
    within("repeated frequencies", error, 1e-7);
}

/// `Σλ = −trace(M⁻¹C)` over all roots, pairs twice.
#[test]
fn law_roots_sum_to_the_trace_of_damping() {
    for description in machines::all() {
        let lossy = description.with_losses(&mut Random::new(11));
        let solved = solve(&lossy.text(), &damped());
        let linear = &solved.prepared.model;
        if !linear.massless.is_empty() {
            continue; // a massless coordinate brings a root of its own
        }
        let mass = linear.mass_diagonal();
        let Some(mass) = mass else { continue };
        let trace: f64 = linear
            .branches
            .iter()
            .flat_map(|b| {
                b.direction
                    .entries()
                    .map(|(i, a)| b.damping * a * a / mass[i])
            })
            .sum();
        let sum: f64 = solved
            .answer
            .modes
            .iter()
            .map(|m| m.eigenvalue.re * if m.is_oscillatory() { 2.0 } else { 1.0 })
            .sum();
        assert!(trace > 0.0);
        within(
            &format!("trace: {}", description.family),
            (sum / trace + 1.0).abs(),
            1e-12,
        );
    }
}

fn of_complex(machine: &Machine, shape: &[Complex], lambda: Complex) -> Complex {
    let mut sum = Complex::new(0.0, 0.0);
    for mass in &machine.masses {
        let along = mass.direction.dot_complex(shape);
        sum += lambda * along * along * (2.0 * mass.value);
    }
    sum
}

/// `φᵀ (2λM + C) φ = 1`, and `(λ²M + λC + K) φ = 0` has φᵀ times it nil.
#[test]
fn law_complex_shapes_are_normalised() {
    for description in machines::all() {
        let lossy = description.with_losses(&mut Random::new(12));
        let solved = solve(&lossy.text(), &damped());
        let Solved {
            prepared: machine,
            answer,
            ..
        } = &solved;
        assert_eq!(solved.n_rigid(), description.n_rigid);
        let (mut norm, mut quotient): (f64, f64) = (0.0, 0.0);
        for mode in answer.modes.iter().filter(|mode| !mode.rigid) {
            let lambda = mode.eigenvalue;
            let p = machine.model.select_independent(&mode.shape);
            let mut product = of_complex(&machine.machine, &mode.shape, lambda);
            let mut energy = product * lambda / 2.0;
            let mut size = energy.norm();
            for branch in &machine.model.branches {
                let along = branch.direction.dot_complex(&p);
                product += along * along * branch.damping;
                let force = lambda * branch.damping + branch.stiffness;
                energy += along * along * force;
                size += along.norm().powi(2) * (lambda.norm() * branch.damping + branch.stiffness);
            }
            norm = norm.max((product - Complex::new(1.0, 0.0)).norm());
            quotient = quotient.max(energy.norm() / size);
            assert!(mode.residual < 1e-13, "{}", mode.residual);
            assert!(
                lambda.re <= 1e-15 * lambda.norm(),
                "{}: {lambda}",
                description.family
            );
        }
        within(&format!("normalised: {}", description.family), norm, 1e-10);
        within(
            &format!("quotient: {}", description.family),
            quotient,
            1e-11,
        );
    }
}

/// `C = αM + βK`: `ζ = α/2ω + βω/2`, the undamped shapes.
#[test]
fn exact_rayleigh_damping() {
    for description in machines::all() {
        let undamped = solve(&description.text(), &plain());
        let (alpha, beta) = (3.0, 2e-6);
        let text = format!(
            "{}[damping]\nrayleigh_mass = {alpha:?}\nrayleigh_stiffness = {beta:?}\n",
            description.text()
        );
        let solved = solve(&text, &damped());
        let mut error: f64 = 0.0;
        let omega: Vec<f64> = undamped.omega().into_iter().filter(|w| *w > 0.0).collect();
        let pairs: Vec<&Mode> = solved
            .answer
            .modes
            .iter()
            .filter(|m| m.is_oscillatory())
            .collect();
        assert_eq!(pairs.len(), omega.len(), "{}", description.family);
        for (mode, omega) in pairs.iter().zip(&omega) {
            let zeta = alpha / (2.0 * omega) + beta * omega / 2.0;
            error = error
                .max((mode.damping_ratio.unwrap() / zeta - 1.0).abs())
                .max((mode.omega() / omega - 1.0).abs());
        }
        within(&format!("Rayleigh: {}", description.family), error, 1e-11);
        // Braked all alike, every rigid motion decays with α; a massless node, k (1 + βλ) = 0, with 1/β.
        let decays: Vec<f64> = solved
            .answer
            .modes
            .iter()
            .filter(|m| !m.rigid && !m.is_oscillatory())
            .map(|m| m.eigenvalue.re)
            .collect();
        let light = solved.prepared.model.massless.len();
        let exact: Vec<f64> = std::iter::repeat_n(-alpha, description.n_rigid)
            .chain(std::iter::repeat_n(-1.0 / beta, light))
            .collect();
        within("decays", worst(&decays, &exact), 1e-12);
    }
}

/// Ratios stated mode by mode come out as stated, the last for all above.
#[test]
fn exact_modal_damping() {
    for description in machines::all() {
        let text = format!(
            "{}[damping]\nmodal = [0.01, 0.05, 0.002]\n",
            description.text()
        );
        let solved = solve(&text, &damped());
        assert_eq!(
            solved.n_rigid(),
            description.n_rigid,
            "{}",
            description.family
        );
        let ratios = solved.answer.modes.iter().filter_map(|m| m.damping_ratio);
        let error = ratios
            .zip([0.01, 0.05].into_iter().chain(std::iter::repeat(0.002)))
            .map(|(found, stated)| (found / stated - 1.0).abs())
            .fold(0.0, f64::max);
        within(&format!("modal: {}", description.family), error, 1e-11);
    }
}

/// A disc on a spring whose other end is a massless node with a damper and a second spring to ground:
/// `J c λ³ + J (k₁ + k₂) λ² + k₁ c λ + k₁ k₂ = 0`.
#[test]
fn exact_massless_node_braked_by_a_damper() {
    for (j, k1, k2, c) in [
        (2.0, 300.0, 500.0, 7.0),
        (0.1, 1e6, 40.0, 3.0),
        (5.0, 20.0, 1e5, 0.01),
        (1.0, 1e3, 1e3, 1e4),
    ] {
        let text = format!(
            "{HEAD}[[inertia]]\nname = \"disc\"\nJ = {j:?}\n[[inertia]]\nname = \"node\"\nJ = 0.0\n\
             [[shaft]]\nname = \"one\"\nbetween = [\"disc\", \"node\"]\nk = {k1:?}\n\
             [[coupling]]\nname = \"two\"\nbetween = [\"node\", \"ground\"]\nk = {k2:?}\n\
             [[damper]]\nname = \"brake\"\nat = \"node\"\nc = {c:?}\n"
        );
        let solved = solve(&text, &damped());
        let mut roots = Vec::new();
        let mut error: f64 = 0.0;
        for mode in &solved.answer.modes {
            let z = mode.eigenvalue;
            roots.push(z);
            if z.im != 0.0 {
                roots.push(z.conj());
            }
            let terms = [z * z * z * j * c, z * z * j * (k1 + k2), z * k1 * c];
            let sum = terms[0] + terms[1] + terms[2] + k1 * k2;
            // One step of Newton's method says how far the root is.
            let slope = z * z * 3.0 * j * c + z * 2.0 * j * (k1 + k2) + k1 * c;
            error = error.max((sum / slope).norm() / z.norm());
        }
        assert_eq!(roots.len(), 3, "{roots:?}");
        within("massless and braked", error, 1e-12);
    }
}

/// `λ² = −ω² (1 + iη)`: ζ from a loss factor.
#[test]
fn exact_loss_factor() {
    for eta in [1e-3, 0.02, 0.3] {
        let text = format!(
            "{HEAD}[[inertia]]\nname = \"disc\"\nJ = 2.0\n\
             [[shaft]]\nname = \"rubber\"\nbetween = [\"disc\", \"ground\"]\nk = 800.0\nloss_factor = {eta:?}\n"
        );
        let solved = solve(&text, &damped());
        let [mode] = &solved.answer.modes[..] else {
            unreachable!("one degree of freedom has one mode");
        };
        let exact = (Complex::new(-1.0, -eta) * 400.0).sqrt();
        let exact = if exact.im < 0.0 { -exact } else { exact };
        let error = (mode.eigenvalue - exact).norm() / exact.norm();
        within(&format!("loss factor {eta}"), error, 1e-14);
        assert!(mode.eigenvalue.re < 0.0);
    }
}

/// Two pairs between the same shafts with different ratios.
fn loop_of(second: [u32; 2], mesh: &str) -> String {
    format!(
        "{HEAD}[[inertia]]\nname = \"a\"\nJ = 0.1\n[[inertia]]\nname = \"b\"\nJ = 0.5\n\
         [[gear_pair]]\nname = \"first\"\nbetween = [\"a\", \"b\"]\nteeth = [20, 40]\nmodule = 0.003\n\
         [[gear_pair]]\nname = \"second\"\nbetween = [\"a\", \"b\"]\nteeth = [{}, {}]\nmodule = 0.003\n{mesh}",
        second[0], second[1]
    )
}

/// Rigid pairs whose ratios contradict each other are refused by name; a mesh that yields then holds the machine; equal ratios turn.
#[test]
fn refuses_contradictory_ratios() {
    let wrong = solve_model(&model(&loop_of([21, 40], "")), &plain());
    let error = wrong.map(|_| ()).unwrap_err();
    assert_eq!(error.code, Code::ContradictoryRatios);
    for name in ["`first`", "`second`", "by -1/2", "by -21/40"] {
        assert!(error.message.contains(name), "{}", error.message);
    }
    let held = solve(&loop_of([21, 40], "k = 1e8\n"), &plain());
    assert_eq!(held.n_rigid(), 0);
    // θ_b = −θ_a/2 exactly; the second mesh strains by s (21 − 20) θ_a, s = m cos α / 2.
    let lever = 0.0015 * (std::f64::consts::PI / 9.0).cos();
    let exact = (1e8 * lever * lever / (0.1 + 0.5 / 4.0)).sqrt();
    within("held loop", worst(&held.omega(), &[exact]), 1e-14);
    let turns = solve(&loop_of([30, 60], ""), &plain());
    assert_eq!((turns.answer.modes.len(), turns.n_rigid()), (1, 1));
}

/// The machine of the files: every law of energies holds there too.
#[test]
fn law_energies_of_shipped_models() {
    for name in [
        "y2250",
        "helical_lateral",
        "lin_parker_n5",
        "overhung_rotor",
        "four_square",
    ] {
        let solved = solve_file(name, &plain());
        let mut error: f64 = 0.0;
        for (i, mode) in solved.answer.modes.iter().enumerate() {
            let shape = real(mode);
            for (j, other) in solved.answer.modes.iter().enumerate() {
                let unit = f64::from(u8::from(i == j));
                let product = kinetic(&solved.prepared.machine, &shape, &real(other));
                error = error.max((product - unit).abs());
            }
            error = error.max(mode.residual);
        }
        within(&format!("orthonormal: {name}"), error, 1e-11);
    }
}
