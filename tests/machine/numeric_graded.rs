//! Graded machines against mpmath: `data/reference/graded.json`, made by `tools/reference_graded.py`.

use crate::support::verification::within;
use geardyn::internals::numeric::{Matrix, graded};
use serde_json::Value;

struct Problem {
    name: String,
    class: String,
    lapack: f64,
    inertia: Vec<f64>,
    omega: Vec<f64>,
    /// √k w, a row per branch, not yet scaled by inertia.
    a: Matrix,
    recovery: Vec<Vec<f64>>,
}

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .collect()
}

fn problems() -> Vec<Problem> {
    let document: Value =
        serde_json::from_str(include_str!("../../data/reference/graded.json")).unwrap();
    document["problems"]
        .as_array()
        .unwrap()
        .iter()
        .map(read)
        .collect()
}

fn read(p: &Value) -> Problem {
    let inertia = numbers(&p["inertia"]);
    let branches = p["branches"].as_array().unwrap();
    let mut a = Matrix::zeros(branches.len(), inertia.len());
    for (row, branch) in branches.iter().enumerate() {
        for term in branch["terms"].as_array().unwrap() {
            a[(row, term[0].as_u64().unwrap() as usize)] =
                branch["k"].as_f64().unwrap().sqrt() * term[1].as_f64().unwrap();
        }
    }
    Problem {
        name: p["name"].as_str().unwrap().to_owned(),
        class: p["class"].as_str().unwrap().to_owned(),
        lapack: p["lapack_rel_error"].as_f64().unwrap(),
        inertia,
        omega: numbers(&p["omega_rad_s"]),
        a,
        recovery: p["recovery"]
            .as_array()
            .map_or(vec![], |rows| rows.iter().map(numbers).collect()),
    }
}

/// Columns scaled by 1/√J.
fn scaled(a: &Matrix, inertia: &[f64]) -> Matrix {
    Matrix::from_fn(a.nrows(), a.ncols(), |i, j| a[(i, j)] / inertia[j].sqrt())
}

/// Largest relative error of the nonzero frequencies; zeros must be exact.
fn worst_error(a: &Matrix, omega: &[f64]) -> f64 {
    let rank = omega.iter().filter(|&&w| w > 0.0).count();
    let found = graded::svd(a, Some(rank)).unwrap();
    assert_eq!(found.values.len(), omega.len());
    let error = |(value, omega): (&f64, &f64)| {
        if *omega == 0.0 {
            value.abs()
        } else {
            (value / omega - 1.0).abs()
        }
    };
    found
        .values
        .iter()
        .zip(omega)
        .map(error)
        .fold(0.0, f64::max)
}

fn assert_class(class: &str, tolerance: f64) {
    let mut worst: f64 = 0.0;
    for p in problems().iter().filter(|p| p.class == class) {
        let error = worst_error(&scaled(&p.a, &p.inertia), &p.omega);
        println!(
            "{:16} {error:8.1e}   definite pencil (LAPACK) {:8.1e}",
            p.name, p.lapack
        );
        worst = worst.max(error);
    }
    assert!(worst > 0.0, "{class}: no problem");
    within(class, worst, tolerance);
}

/// Chains by the factored form: frequencies.
/// Source: mpmath 1.3.0 with 140 digits (tools/reference_graded.py).
#[test]
fn ref_mpmath_chains() {
    assert_class("chain", 1e-14);
}

/// Trees by the factored form: frequencies.
/// Source: mpmath 1.3.0 with 140 digits (tools/reference_graded.py).
#[test]
fn ref_mpmath_trees() {
    assert_class("tree", 1e-14);
}

/// Loops by the factored form: frequencies.
/// Source: mpmath 1.3.0 with 140 digits (tools/reference_graded.py).
#[test]
fn ref_mpmath_loops() {
    assert_class("loops", 1e-14);
}

/// Massless freedoms first, condensed, then as the others; their motion against the exact Schur complement.
/// Source: mpmath 1.3.0 with 140 digits (tools/reference_graded.py).
#[test]
fn ref_mpmath_massless() {
    for p in problems().iter().filter(|p| p.class == "massless") {
        let n = p.inertia.len();
        let (massless, heavy): (Vec<usize>, Vec<usize>) =
            (0..n).partition(|&i| p.inertia[i] == 0.0);
        let order = [massless.clone(), heavy.clone()].concat();
        let sorted = Matrix::from_fn(p.a.nrows(), n, |i, j| p.a[(i, order[j])]);
        let out = graded::condense(&sorted, massless.len()).unwrap();
        assert_eq!(out.singular, None, "{}", p.name);
        let inertia: Vec<f64> = heavy.iter().map(|&i| p.inertia[i]).collect();
        let error = worst_error(&scaled(&out.condensed, &inertia), &p.omega);
        let mut motion: f64 = 0.0;
        for (i, row) in p.recovery.iter().enumerate() {
            let size = row.iter().fold(0.0, |big: f64, x| big.max(x.abs()));
            let off = |j: usize| (out.recovery[(i, j)] - row[j]).abs() / size;
            motion = (0..row.len()).map(off).fold(motion, f64::max);
        }
        println!(
            "{:16} {error:8.1e}   recovered motion {motion:8.1e}   LAPACK {:8.1e}",
            p.name, p.lapack
        );
        within("frequencies", error, 1e-14);
        within("motion of massless nodes", motion, 1e-14);
    }
}
