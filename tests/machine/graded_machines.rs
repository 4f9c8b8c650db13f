//! Whole machines graded over many powers of ten, against mpmath and against exactly eliminated limits.

use crate::support::{number, numbers, plain, reference, solve, within, worst};
use serde_json::Value;

const HEAD: &str = "units = \"SI\"\ntitle = \"graded\"\nsource = \"a test\"\n";

/// A problem of data/reference/graded.json as a model: ratios become internal pairs whose moment arms are the coefficients, m.
fn text(problem: &Value) -> String {
    let module = 2.0 / (std::f64::consts::PI / 9.0).cos();
    let mut text = HEAD.to_string();
    for (i, j) in numbers(&problem["inertia"]).iter().enumerate() {
        text += &format!("[[inertia]]\nname = \"n{i}\"\nJ = {j:?}\n");
    }
    for (b, branch) in problem["branches"].as_array().unwrap().iter().enumerate() {
        let k = number(&branch["k"]);
        let terms: Vec<(u64, i64)> = branch["terms"]
            .as_array()
            .unwrap()
            .iter()
            .map(|t| (t[0].as_u64().unwrap(), t[1].as_i64().unwrap()))
            .collect();
        text += &match terms[..] {
            [(i, _)] => format!(
                "[[coupling]]\nname = \"b{b}\"\nbetween = [\"n{i}\", \"ground\"]\nk = {k:?}\n"
            ),
            [(i, a), (j, c)] if a.abs() == 1 && c.abs() == 1 => {
                format!("[[shaft]]\nname = \"b{b}\"\nbetween = [\"n{i}\", \"n{j}\"]\nk = {k:?}\n")
            }
            [(i, a), (j, c)] => {
                let ((i, a), (j, c)) = if a.abs() < c.abs() {
                    ((i, a), (j, c))
                } else {
                    ((j, c), (i, a))
                };
                let (a, c) = (a.abs(), c.abs());
                format!(
                    "[[gear_pair]]\nname = \"b{b}\"\nbetween = [\"n{i}\", \"n{j}\"]\nteeth = [{a}, {c}]\ninternal = true\nmodule = {module:?}\nk = {k:?}\n"
                )
            }
            _ => unreachable!("two terms at most"),
        };
    }
    text
}

fn check(class: &str, tolerance: f64) {
    let mut largest: f64 = 0.0;
    let document = reference("graded");
    let problems = document["problems"].as_array().unwrap();
    for problem in problems.iter().filter(|p| p["class"] == class) {
        let exact = numbers(&problem["omega_rad_s"]);
        let solved = solve(&text(problem), &plain());
        let error = worst(&solved.omega(), &exact);
        println!("{:16} {error:8.1e}", problem["name"].as_str().unwrap());
        largest = largest.max(error);
    }
    within(class, largest, tolerance);
}

/// Chains as models, stiffness and inertia spread over up to 26 decades.
/// Source: mpmath 1.3.0 with 140 digits (tools/reference_graded.py).
#[test]
fn ref_mpmath_chains() {
    check("chain", 1e-13);
}

/// Trees with gear ratios as models.
/// Source: mpmath 1.3.0 with 140 digits (tools/reference_graded.py).
#[test]
fn ref_mpmath_geared_trees() {
    check("tree", 1e-13);
}

/// Loops with gear ratios as models.
/// Source: mpmath 1.3.0 with 140 digits (tools/reference_graded.py).
#[test]
fn ref_mpmath_geared_loops() {
    check("loops", 1e-13);
}

/// Machines with nodes without inertia.
/// Source: mpmath 1.3.0 with 140 digits (tools/reference_graded.py).
#[test]
fn ref_mpmath_massless_nodes() {
    check("massless", 1e-13);
}

/// Motor, pair, roll with a ring and a second pair closing a loop; `mesh` is the line of each pair's stiffness, `light` an inertia.
fn geared(mesh: &str, light: &str) -> String {
    format!(
        "{HEAD}\
         [[inertia]]\nname = \"motor\"\nJ = 0.02\n[[inertia]]\nname = \"pinion\"\nJ = 0.001\n\
         [[inertia]]\nname = \"wheel\"\nJ = 0.05\n[[inertia]]\nname = \"sleeve\"\nJ = {light}\n\
         [[inertia]]\nname = \"roll\"\nJ = 3.0\n[[inertia]]\nname = \"ring\"\nJ = 0.4\n\
         [[shaft]]\nname = \"a\"\nbetween = [\"motor\", \"pinion\"]\nk = 9e3\n\
         [[gear_pair]]\nname = \"first\"\nbetween = [\"pinion\", \"wheel\"]\nteeth = [21, 64]\nmodule = 0.003\n{mesh}\
         [[gear_pair]]\nname = \"second\"\nbetween = [\"pinion\", \"ring\"]\nteeth = [21, 83]\nmodule = 0.003\n{mesh}\
         [[shaft]]\nname = \"b\"\nbetween = [\"wheel\", \"sleeve\"]\nk = 4e4\n\
         [[shaft]]\nname = \"c\"\nbetween = [\"sleeve\", \"roll\"]\nk = 7e4\n\
         [[shaft]]\nname = \"d\"\nbetween = [\"ring\", \"ground\"]\nk = 5e3\n"
    )
}

/// What is left of `found` beside `limit`: the largest relative error of the lowest.
fn distance(found: &[f64], limit: &[f64]) -> f64 {
    worst(&found[..limit.len()], limit)
}

/// Stiffer and stiffer meshes tend to the rigid pairs that are eliminated exactly: the error falls with 1/k down to rounding.
#[test]
fn law_stiff_meshes_tend_to_rigid_ones() {
    let rigid = solve(&geared("", "0.002"), &plain());
    assert_eq!(rigid.answer.modes.len(), 4);
    let mut last = f64::INFINITY;
    for power in 8..=23 {
        let solved = solve(&geared(&format!("k = 1e{power}\n"), "0.002"), &plain());
        let error = distance(&solved.omega(), &rigid.omega());
        println!("k = 1e{power} N/m: {error:.1e}");
        assert!(
            error < 0.5 * last || error < 1e-12,
            "{error:.1e} after {last:.1e}"
        );
        last = error;
    }
    within("rigid limit", last, 1e-13);
}

/// A vanishing inertia tends to the massless node that is condensed: the error falls with J down to rounding.
#[test]
fn law_light_nodes_tend_to_massless_ones() {
    let massless = solve(&geared("k = 3e8\n", "0.0"), &plain());
    assert_eq!(massless.answer.modes.len(), 5);
    let mut last = f64::INFINITY;
    for power in 3..=24 {
        let solved = solve(&geared("k = 3e8\n", &format!("1e-{power}")), &plain());
        assert_eq!(solved.answer.modes.len(), 6);
        let error = distance(&solved.omega(), &massless.omega());
        println!("J = 1e-{power} kg·m²: {error:.1e}");
        assert!(
            error < 0.5 * last || error < 1e-12,
            "{error:.1e} after {last:.1e}"
        );
        last = error;
    }
    within("massless limit", last, 1e-13);
    let rigid_and_massless = solve(&geared("", "0.0"), &plain());
    let near = solve(&geared("k = 1e22\n", "1e-18"), &plain());
    let error = distance(&near.omega(), &rigid_and_massless.omega());
    within("rigid and massless limit", error, 1e-12);
}
