//! Published machines, and closed forms, through the whole path from file to frequencies.

use std::f64::consts::{PI, TAU};

use crate::support::{
    Solved, damped, lowest, number, numbers, plain, reference, solve, solve_file,
    verification::printed, within, worst,
};
use geardyn::internals::numeric::Complex;
use geardyn::internals::scene::study::ModesStudy;
use serde_json::Value;

/// Frequencies of a file against what was printed and what was recomputed.
fn check(name: &str, solved: &Solved, reference: &Value) {
    let hertz = solved.hertz();
    let rtol = reference["rtol"].as_f64().unwrap_or(1e-9);
    let mut known = false;
    for (key, found) in [
        ("recomputed_hz", hertz.clone()),
        ("recomputed_rad_s", solved.omega()),
    ] {
        if let Some(list) = reference.get(key) {
            let list = numbers(list);
            let found = &found[..list.len().min(found.len())];
            within(&format!("{name}, recomputed"), worst(found, &list), rtol);
            known = true;
        }
    }
    for (key, found, tolerance) in [
        ("published_hz", hertz, "tolerance_hz"),
        ("published_rad_s", solved.omega(), "tolerance_rad_s"),
    ] {
        if let Some(list) = reference.get(key) {
            let tolerance = number(&reference[tolerance]);
            let unit = if key.ends_with("hz") { "Hz" } else { "rad/s" };
            for (i, (f, digits)) in found.iter().zip(list.as_array().unwrap()).enumerate() {
                if let Some(digits) = digits.as_f64() {
                    printed(
                        &format!("{name}, mode {}", i + 1),
                        unit,
                        digits,
                        *f,
                        tolerance,
                    );
                }
            }
            known = true;
        }
    }
    assert!(known, "{name} has no frequencies");
}

fn check_file(name: &str) -> Solved {
    let solved = solve_file(name, &plain());
    check(name, &solved, &reference(name));
    for mode in solved.answer.modes.iter().filter(|mode| mode.rigid) {
        assert_eq!(mode.omega(), 0.0, "{name}");
    }
    solved
}

/// Two discs on a shaft: closed form, and the digits printed.
/// Source: openTorsion (commit 88ab7893, tests/tests.py, test_shaft).
#[test]
fn ref_opentorsion_two_disc() {
    assert_eq!(check_file("two_disc").n_rigid(), 1);
}

/// Thomson's three discs.
/// Source: data of W. T. Thomson, Theory of Vibration with Applications; recomputed with 40 digits by mpmath.
#[test]
fn ref_thomson_three_disc() {
    let solved = check_file("holzer_three_disc");
    let shapes = &reference("holzer_three_disc")["shapes"];
    for (mode, shape) in solved.answer.modes[1..]
        .iter()
        .zip(shapes.as_array().unwrap())
    {
        let found: Vec<f64> = mode.shape.iter().map(|x| x.re / mode.shape[0].re).collect();
        within("shapes", worst(&found, &numbers(shape)), 1e-10);
    }
}

/// Five discs in a row, free.
/// Source: Friswell and others, Dynamics of Rotating Machines (2010), ch. 9, by way of openTorsion (commit 88ab7893); recomputed with 40 digits by mpmath.
#[test]
fn ref_friswell_five_disc_chain() {
    check_file("five_disc_chain");
}

/// Friswell's nine discs, held by two springs to ground and free.
/// Source: Friswell and others, Dynamics of Rotating Machines (2010), ch. 9, by way of openTorsion (commit 88ab7893); recomputed with 40 digits by mpmath.
#[test]
fn ref_friswell_nine_disc_chain() {
    let nine = &reference("five_disc_chain")["nine_disc"];
    let (inertia, stiffness) = (numbers(&nine["J_kg_m2"]), numbers(&nine["k_Nm_per_rad"]));
    let mut text = String::from("units = \"SI\"\ntitle = \"nine discs\"\nsource = \"a test\"\n");
    for (i, j) in inertia.iter().enumerate() {
        text += &format!("[[inertia]]\nname = \"d{}\"\nJ = {j:?}\n", i + 1);
    }
    for (i, k) in stiffness.iter().enumerate() {
        let (a, b) = (i + 1, i + 2);
        text += &format!("[[shaft]]\nname = \"s{a}\"\nbetween = [\"d{a}\", \"d{b}\"]\nk = {k:?}\n");
    }
    let mut held = text.clone();
    for (disc, k) in nine["ground_k_Nm_per_rad"].as_object().unwrap() {
        held += &format!(
            "[[coupling]]\nname = \"g{disc}\"\nbetween = [\"d{disc}\", \"ground\"]\nk = {:?}\n",
            number(k)
        );
    }
    let rtol = number(&nine["rtol"]);
    for (what, text, key) in [
        ("held", held, "recomputed_hz"),
        ("free", text, "recomputed_free_hz"),
    ] {
        let error = worst(&solve(&text, &plain()).hertz(), &numbers(&nine[key]));
        within(&format!("nine discs {what}"), error, rtol);
    }
}

/// A rigid 1:1 pair: five bodies, four freedoms.
/// Source: Friswell and others, Dynamics of Rotating Machines (2010), ch. 9, by way of openTorsion (commit 88ab7893); recomputed with 40 digits by mpmath.
#[test]
fn ref_friswell_geared_motor_rolls() {
    assert_eq!(check_file("geared_motor_rolls").answer.modes.len(), 4);
}

/// Six masses of a turbine generator.
/// Source: IEEE SSR task force, IEEE Trans. PAS-96 (1977) 1565, as quoted in the literature; recomputed with 40 digits by mpmath.
#[test]
fn ref_ieee_first_benchmark() {
    check_file("ieee_first_benchmark");
}

/// Planetary stages with 3, 4 and 5 planets, planar.
/// Source: J. Lin and R. G. Parker, J. Vib. Acoust. 121 (1999) 316, tables 1 and 2, as transcribed with the public Drivetrain programs; recomputed with 40 digits by mpmath.
#[test]
fn ref_lin_parker_planetary_stages() {
    for name in ["lin_parker_n3", "lin_parker_n4", "lin_parker_n5"] {
        assert_eq!(check_file(name).n_rigid(), 1);
    }
}

/// Fifteen powers of ten, to the twelve digits of the reference.
/// Source: mpmath with 80 digits.
#[test]
fn ref_mpmath_extreme_chain() {
    let solved = check_file("extreme_chain");
    let list = numbers(&reference("extreme_chain")["recomputed_rad_s"]);
    within("frequencies", worst(&solved.omega(), &list), 1e-11);
    assert_eq!(solved.n_rigid(), 1);
}

/// Four discs with a rigid pair: complex modes, one zero root, one real one.
/// Source: openTorsion (commit 88ab7893, tests/tests.py, test_state_space); recomputed with 40 digits by mpmath.
#[test]
fn ref_opentorsion_geared_damped() {
    let reference = reference("geared_damped");
    let exact: Vec<Complex> = reference["recomputed_eigenvalues_rad_s"]
        .as_array()
        .unwrap()
        .iter()
        .map(|pair| Complex::new(number(&pair[0]), number(&pair[1])))
        .filter(|z| z.im >= 0.0)
        .collect();
    let solved = solve_file("geared_damped", &damped());
    let modes = &solved.answer.modes;
    assert_eq!(modes.len(), exact.len());
    assert!(modes[0].rigid && modes[0].eigenvalue == Complex::new(0.0, 0.0));
    assert_eq!(modes[1].eigenvalue.im, 0.0);
    let error = modes[1..]
        .iter()
        .zip(&exact[1..])
        .map(|(mode, exact)| (mode.eigenvalue - exact).norm() / exact.norm())
        .fold(0.0, f64::max);
    within("eigenvalues", error, number(&reference["rtol"]));
    let ratios = &reference["damping_ratio"];
    for (at, mode) in [(2, &modes[2]), (4, &modes[3])] {
        let error = mode.damping_ratio.unwrap() / number(&ratios[at]) - 1.0;
        within("damping ratios", error.abs(), 1e-9);
    }
}

/// Two masses of a wind turbine: frequency, damping ratio, damped frequency.
/// Source: data of J. Jonkman and others, NREL/TP-500-38060 (2009); closed form of two masses.
#[test]
fn ref_nrel_5mw_damping() {
    check_file("nrel_5mw");
    let reference = reference("nrel_5mw");
    let solved = solve_file("nrel_5mw", &damped());
    let [rigid, elastic] = &solved.answer.modes[..] else {
        unreachable!("two masses have two modes");
    };
    assert!(rigid.rigid && rigid.eigenvalue == Complex::new(0.0, 0.0));
    let rtol = number(&reference["rtol"]);
    let zeta = number(&reference["damping_ratio"][1]);
    within(
        "damping ratio",
        (elastic.damping_ratio.unwrap() / zeta - 1.0).abs(),
        rtol,
    );
    let damped = number(&reference["damped_rad_s"][1]);
    within(
        "damped frequency",
        (elastic.eigenvalue.im / damped - 1.0).abs(),
        rtol,
    );
}

/// A drill string in 5, 8 and 50 lengths with consistent mass.
/// Source: Friswell and others, Dynamics of Rotating Machines (2010), ch. 9, by way of openTorsion (commit 88ab7893); recomputed with 40 digits by mpmath.
#[test]
fn ref_friswell_drill_string() {
    check_file("drill_string");
    let reference = reference("drill_string");
    for (segments, modes) in [(5, 6), (8, 9)] {
        let text =
            format!("model = \"drill_string.toml\"\n[set]\n\"string.segments\" = {segments}\n");
        let solved = solve(&text, &plain());
        assert_eq!(solved.answer.modes.len(), modes);
        let case = &reference[format!("segments_{segments}")];
        let exact = numbers(&case["recomputed_hz"]);
        let error = worst(&solved.hertz()[..exact.len()], &exact);
        within(&format!("drill string, {segments} lengths"), error, 1e-10);
        let tolerance = number(&reference["tolerance_hz"]);
        for (i, (f, digits)) in solved
            .hertz()
            .iter()
            .zip(numbers(&case["published_hz"]))
            .enumerate()
        {
            let what = format!("{segments} lengths, mode {}", i + 1);
            printed(&what, "Hz", digits, *f, tolerance);
        }
    }
}

/// A pipe held at its top with a collar below, `β tan β = J_pipe/J_collar`: linear elements converge with h², extrapolated twice.
#[test]
fn exact_drill_pipe_with_collar() {
    let pipe = &reference("drill_string")["pipe_with_collar"];
    let of = |key: &str| number(&pipe[key]);
    let lengths = |segments: usize| {
        let text = format!(
            "title = \"pipe and collar\"\nsource = \"a test\"\n\
             [[inertia]]\nname = \"collar\"\ndiameter = \"{} in\"\nbore = \"{} in\"\nwidth = \"{} ft\"\ndensity = \"{} kg/m³\"\n\
             [[shaft]]\nname = \"pipe\"\nbetween = [\"ground\", \"collar\"]\nlength = \"{} ft\"\ndiameter = \"{} in\"\nbore = \"{} in\"\n\
             shear_modulus = \"{} Pa\"\ndensity = \"{} kg/m³\"\nsegments = {segments}\nmass = \"consistent\"\n",
            of("collar_od_in"),
            of("collar_id_in"),
            of("collar_L_ft"),
            of("rho"),
            of("pipe_L_ft"),
            of("pipe_od_in"),
            of("pipe_id_in"),
            of("G_Pa"),
            of("rho"),
        );
        solve(&text, &plain()).omega()[..3].to_vec()
    };
    let levels = [25, 50, 100].map(lengths);
    let exact = numbers(&pipe["continuum_rad_s"]);
    for (k, exact) in exact.iter().enumerate() {
        let once = |a: f64, b: f64| b + (b - a) / 3.0;
        let [a, b, c] = [levels[0][k], levels[1][k], levels[2][k]];
        assert!(a > b && b > c && c > *exact, "Rayleigh–Ritz stands above");
        let (first, second) = (once(a, b), once(b, c));
        let twice = second + (second - first) / 15.0;
        within(
            "three frequencies, extrapolated",
            (twice / exact - 1.0).abs(),
            1e-8,
        );
    }
}

/// A gear generator with forty bodies, belts, bevels, worms, sleeves; a helical pair in bearings; a rotor at rest: another assembly,
/// `tools/assembly.py`, in 60 digits.
/// Source: own assembly in mpmath with 60 digits (tools/assembly.py, tools/reference_y2250.py).
#[test]
fn ref_mpmath_shipped_machines() {
    for name in ["y2250", "helical_lateral", "overhung_rotor"] {
        assert_eq!(check_file(name).n_rigid(), 1, "{name}");
    }
}

/// The rotor at 3000 rpm, gyroscopic moments from the same assembly.
/// Source: own assembly in mpmath with 60 digits (tools/assembly.py, tools/reference_y2250.py).
#[test]
fn ref_mpmath_rotor_at_3000_rpm() {
    let study = ModesStudy {
        speed: Some(3000.0 * TAU / 60.0),
        ..plain()
    };
    let solved = solve_file("overhung_rotor", &study);
    assert!(solved.answer.complex && solved.n_rigid() == 1);
    let exact = numbers(&reference("overhung_rotor")["at_3000_rpm_hz"]);
    within("frequencies", worst(&solved.hertz(), &exact), 1e-10);
    for mode in &solved.answer.modes {
        assert!(mode.eigenvalue.re.abs() <= 1e-12 * mode.omega());
    }
}

/// Gyroscopic moments lose no energy: a spinning rotor without dampers once had damping ratios of rounding size.
#[test]
fn exact_spinning_rotor_without_dampers_has_no_damping_ratio() {
    let study = ModesStudy {
        speed: Some(100.0),
        damped: true,
        ..plain()
    };
    let solved = solve_file("overhung_rotor", &study);
    assert!(solved.answer.complex);
    for mode in &solved.answer.modes {
        assert_eq!(mode.damping_ratio, None);
    }
}

#[derive(Clone, Copy)]
enum Ends {
    Start,
    Both,
    Free,
}

impl Ends {
    fn words(self) -> &'static str {
        match self {
            Ends::Start => "held at one end",
            Ends::Both => "held at both ends",
            Ends::Free => "free",
        }
    }
}

/// `J = 1`, `k = 1`: frequencies of n discs in rising order, and the shape of each at disc i (from 1), not normalised.
fn uniform(n: usize, ends: Ends, k: usize) -> (f64, impl Fn(usize) -> f64) {
    let (count, order) = (n as f64, k as f64);
    let half = match ends {
        Ends::Start => (2.0 * order - 1.0) * PI / (4.0 * count + 2.0),
        Ends::Both => order * PI / (2.0 * count + 2.0),
        Ends::Free => (order - 1.0) * PI / (2.0 * count),
    };
    let shape = move |i: usize| match ends {
        Ends::Free => ((2.0 * i as f64 - 1.0) * half).cos(),
        _ => (2.0 * i as f64 * half).sin(),
    };
    (2.0 * half.sin(), shape)
}

fn chain(n: usize, ends: Ends) -> String {
    let held = match ends {
        Ends::Start => "start",
        Ends::Both => "both",
        Ends::Free => "none",
    };
    format!(
        "units = \"SI\"\ntitle = \"equal discs\"\nsource = \"a test\"\n\
         [[chain]]\nname = \"disc\"\ncount = {n}\nJ = 1.0\nk = 1.0\nheld = \"{held}\"\n"
    )
}

fn uniform_omega(n: usize, ends: Ends, count: usize) -> Vec<f64> {
    (1..=count).map(|k| uniform(n, ends, k).0).collect()
}

/// Ten equal discs: all frequencies and all shapes.
#[test]
fn exact_uniform_chain_of_10() {
    for ends in [Ends::Start, Ends::Both, Ends::Free] {
        let solved = solve(&chain(10, ends), &plain());
        let error = worst(&solved.omega(), &uniform_omega(10, ends, 10));
        within(&format!("10 discs {}", ends.words()), error, 2e-15);
        let mut shapes: f64 = 0.0;
        for (k, mode) in solved.answer.modes.iter().enumerate() {
            let (_, shape) = uniform(10, ends, k + 1);
            let exact: Vec<f64> = (1..=10).map(shape).collect();
            let norm = exact.iter().map(|x| x * x).sum::<f64>().sqrt();
            let sign = (mode.shape[0].re * exact[0]).signum();
            for (found, exact) in mode.shape.iter().zip(&exact) {
                shapes = shapes.max((found.re - sign * exact / norm).abs());
            }
        }
        within(&format!("10 discs {}, shapes", ends.words()), shapes, 1e-14);
    }
}

/// A thousand equal discs, the lowest forty.
#[test]
fn exact_uniform_chain_of_1000() {
    for ends in [Ends::Start, Ends::Both, Ends::Free] {
        let solved = solve(&chain(1000, ends), &lowest(40));
        let error = worst(&solved.omega(), &uniform_omega(1000, ends, 40));
        within(
            &format!("1000 discs {}, lowest 40", ends.words()),
            error,
            1e-12,
        );
    }
}

/// A hundred thousand equal discs, the lowest twenty.
#[test]
fn exact_uniform_chain_of_100_000() {
    for ends in [Ends::Start, Ends::Free] {
        let solved = solve(&chain(100_000, ends), &lowest(20));
        let error = worst(&solved.omega(), &uniform_omega(100_000, ends, 20));
        within(
            &format!("100 000 discs {}, lowest 20", ends.words()),
            error,
            1e-12,
        );
    }
}

/// All modes of chains that the factored form takes whole, and of longer ones; each to the digits announced.
#[test]
fn exact_uniform_chains_all_modes() {
    for n in [100, 400] {
        for ends in [Ends::Start, Ends::Both, Ends::Free] {
            let solved = solve(&chain(n, ends), &plain());
            let exact = uniform_omega(n, ends, n);
            let error = worst(&solved.omega(), &exact);
            within(
                &format!("{n} discs {}, all", ends.words()),
                error,
                if n == 100 { 1e-14 } else { 1e-12 },
            );
            for (mode, exact) in solved
                .answer
                .modes
                .iter()
                .zip(exact)
                .filter(|(_, w)| *w > 0.0)
            {
                let error = (mode.omega() / exact - 1.0).abs();
                assert!(
                    error <= 3.0 * 10f64.powf(-mode.trusted_digits),
                    "{error:.1e}, {} digits",
                    mode.trusted_digits
                );
            }
        }
    }
}

/// The file of a thousand discs against its reference, the lowest forty.
#[test]
fn exact_uniform_chain_file() {
    let solved = solve_file("uniform_chain", &lowest(40));
    let error = worst(&solved.omega(), &uniform_omega(1000, Ends::Start, 40));
    within("lowest 40", error, 1e-12);
    let list = &reference("uniform_chain")["start_held_rad_s"]["1000"];
    for (k, omega) in list.as_object().unwrap() {
        if let Some(found) = solved.omega().get(k.parse::<usize>().unwrap() - 1) {
            assert!((found / number(omega) - 1.0).abs() < 1e-9);
        }
    }
    assert!((solved.hertz()[0] * TAU / solved.omega()[0] - 1.0).abs() < 1e-15);
}
