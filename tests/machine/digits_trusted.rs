//! Where a machine is no sum of squares, or its damping not proportional, an answer says how many of its digits hold. It must not lie,
//! and not be shy either: against roots by mpmath, `data/reference/digits.json` and `damped.json`.

use crate::support::{Solved, damped, number, numbers, reference, solve};
use geardyn::internals::modes::mode::Mode;
use geardyn::internals::numeric::Complex;
use geardyn::internals::scene::study::ModesStudy;
use serde_json::Value;

/// By how much an error may exceed the digits announced.
const MARGIN: f64 = 3.0;

/// Each found root with the nearest exact one, none twice: relative errors.
fn errors(name: &str, modes: &[&Mode], exact: &[Complex]) -> Vec<f64> {
    assert_eq!(
        modes.len(),
        exact.len(),
        "{name}: roots above or on the real axis"
    );
    let mut left = exact.to_vec();
    let error = |mode: &&Mode| {
        let apart = |z: &Complex| (z - mode.eigenvalue).norm();
        let at = (0..left.len())
            .min_by(|&i, &j| apart(&left[i]).total_cmp(&apart(&left[j])))
            .unwrap();
        let exact = left.swap_remove(at);
        (exact - mode.eigenvalue).norm() / exact.norm()
    };
    modes.iter().map(error).collect()
}

/// The worst error, the fewest digits, and by how many digits the shyest root is shy (to the twelfth).
fn check(name: &str, solved: &Solved, exact: &[Complex]) -> f64 {
    let modes: Vec<&Mode> = solved.answer.modes.iter().filter(|m| !m.rigid).collect();
    let (mut worst, mut fewest, mut shy): (f64, f64, f64) = (0.0, 16.0, 0.0);
    for (mode, error) in modes.iter().zip(errors(name, &modes, exact)) {
        let bound = MARGIN * 10f64.powf(-mode.trusted_digits);
        assert!(
            error <= bound,
            "{name}: {} is {error:.1e} off and claims {:.1} digits",
            mode.eigenvalue,
            mode.trusted_digits
        );
        let finite = |z: &Complex| z.re.is_finite() && z.im.is_finite();
        assert!(
            mode.shape.iter().all(finite),
            "{name}: a shape is no number"
        );
        worst = worst.max(error);
        fewest = fewest.min(mode.trusted_digits);
        shy = shy.max((-error.max(1e-12).log10() - mode.trusted_digits).max(0.0));
    }
    println!("{name:24} worst error {worst:8.1e}  fewest digits {fewest:4.1}  shy by {shy:4.1}");
    shy
}

fn of_pairs(list: &Value) -> Vec<Complex> {
    let pairs = list.as_array().unwrap().iter().map(numbers);
    pairs.map(|pair| Complex::new(pair[0], pair[1])).collect()
}

/// Oil films, negative springs, gyroscopic moments, over up to ten decades.
/// Source: mpmath 1.3.0 with 90 digits (tools/reference_digits.py).
#[test]
fn ref_mpmath_no_sums_of_squares() {
    for case in reference("digits")["cases"].as_array().unwrap() {
        let name = case["name"].as_str().unwrap();
        let speed = number(&case["speed_rad_s"]);
        let study = ModesStudy {
            speed: (speed != 0.0).then_some(speed),
            ..damped()
        };
        let solved = solve(case["model"].as_str().unwrap(), &study);
        let shy = check(name, &solved, &of_pairs(&case["roots_rad_s"]));
        assert!(shy < 4.0, "{name} is shy by {shy:.1} digits");
    }
}

/// A problem of data/reference/damped.json as a model.
fn text(problem: &Value) -> String {
    let mut text = String::from("units = \"SI\"\ntitle = \"damped\"\nsource = \"a test\"\n");
    for (i, j) in numbers(&problem["inertia"]).iter().enumerate() {
        text += &format!("[[inertia]]\nname = \"n{i}\"\nJ = {j:?}\n");
    }
    for (b, branch) in problem["branches"].as_array().unwrap().iter().enumerate() {
        let ends: Vec<String> = branch["terms"]
            .as_array()
            .unwrap()
            .iter()
            .map(|t| format!("\"n{}\"", t[0]))
            .chain(["\"ground\"".to_string()])
            .take(2)
            .collect();
        text += &format!(
            "[[shaft]]\nname = \"b{b}\"\nbetween = [{}]\nk = {:?}\nc = {:?}\n",
            ends.join(", "),
            number(&branch["k"]),
            number(&branch["c"])
        );
    }
    text
}

/// Graded chains with dampers from one in ten thousand to three times critical.
/// Source: mpmath 1.3.0 with 140 digits (tools/reference_graded.py).
#[test]
fn ref_mpmath_damped_chains() {
    for problem in reference("damped")["problems"].as_array().unwrap() {
        let exact: Vec<Complex> = problem["lambda_rad_s"]
            .as_array()
            .unwrap()
            .iter()
            .map(|z| Complex::new(number(&z["re"]), number(&z["im"])))
            .filter(|z| z.im >= 0.0)
            .collect();
        let solved = solve(&text(problem), &damped());
        let name = problem["name"].as_str().unwrap();
        let shy = check(name, &solved, &exact);
        assert!(shy < 4.0, "{name} is shy by {shy:.1} digits");
    }
}
