//! Damped chains against mpmath: `data/reference/damped.json`, made by `tools/reference_graded.py`.

use crate::support::verification::within;
use geardyn::internals::numeric::quadratic::QuadraticEigenproblem;
use geardyn::internals::numeric::{Complex, Matrix, eigen, graded};
use serde_json::Value;

/// `λ² I + λ C + Ω²` in the modal coordinates of an undamped machine, and its exact eigenvalues.
struct Problem {
    name: String,
    omega: Vec<f64>,
    c: Matrix,
    values: Vec<Complex>,
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

fn problems() -> Vec<Problem> {
    let document: Value =
        serde_json::from_str(include_str!("../../data/reference/damped.json")).unwrap();
    document["problems"]
        .as_array()
        .unwrap()
        .iter()
        .map(read)
        .collect()
}

fn read(p: &Value) -> Problem {
    let inertia: Vec<f64> = p["inertia"]
        .as_array()
        .unwrap()
        .iter()
        .map(number)
        .collect();
    let branches = p["branches"].as_array().unwrap();
    let mut w = Matrix::zeros(branches.len(), inertia.len());
    for (row, branch) in branches.iter().enumerate() {
        for term in branch["terms"].as_array().unwrap() {
            let dof = term[0].as_u64().unwrap() as usize;
            w[(row, dof)] = number(&term[1]) / inertia[dof].sqrt();
        }
    }
    let weighted = |key: &str| {
        Matrix::from_fn(w.nrows(), w.ncols(), |i, j| {
            number(&branches[i][key]).sqrt() * w[(i, j)]
        })
    };
    let modes = graded::svd(&weighted("k"), None).unwrap();
    let dampers = weighted("c") * &modes.vectors;
    let values = p["lambda_rad_s"]
        .as_array()
        .unwrap()
        .iter()
        .map(|v| Complex::new(number(&v["re"]), number(&v["im"])));
    Problem {
        name: p["name"].as_str().unwrap().to_owned(),
        omega: modes.values,
        c: dampers.transpose() * &dampers,
        values: values.collect(),
    }
}

/// First-order form in (Ω x, ẋ).
fn companion(p: &Problem) -> Matrix {
    let n = p.omega.len();
    Matrix::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
        (true, true) => 0.0,
        (true, false) => {
            if j - n == i {
                p.omega[i]
            } else {
                0.0
            }
        }
        (false, true) => {
            if i - n == j {
                -p.omega[j]
            } else {
                0.0
            }
        }
        (false, false) => -p.c[(i - n, j - n)],
    })
}

/// Pairs each found value with the nearest reference, no reference twice.
fn matched(found: &[Complex], exact: &[Complex]) -> Vec<Complex> {
    let mut free = exact.to_vec();
    let nearest = |value: &Complex| {
        let at = (0..free.len())
            .min_by(|&i, &j| {
                (free[i] - value)
                    .norm()
                    .total_cmp(&(free[j] - value).norm())
            })
            .unwrap();
        free.remove(at)
    };
    found.iter().map(nearest).collect()
}

/// ε · norm · condition bounds the error of every value, with a margin for the QR iteration's constant.
/// Source: mpmath 1.3.0 with 140 digits (tools/reference_graded.py).
#[test]
fn ref_mpmath_conditions_bound_errors() {
    for p in problems() {
        let found = eigen::eigen(&companion(&p)).unwrap();
        let exact = matched(&found.values, &p.values);
        let mut worst_share: f64 = 0.0;
        for i in 0..exact.len() {
            let bound = f64::EPSILON * found.norm * found.condition[i];
            worst_share = worst_share.max((found.values[i] - exact[i]).norm() / bound);
        }
        println!(
            "{:12} worst error {worst_share:.1e} of ε norm condition",
            p.name
        );
        assert!(worst_share < 10.0, "{}", p.name);
    }
}

/// Roots polished on the quadratic.
/// Source: mpmath 1.3.0 with 140 digits (tools/reference_graded.py).
#[test]
fn ref_mpmath_polished() {
    for p in problems() {
        let n = p.omega.len();
        let found = eigen::eigen(&companion(&p)).unwrap();
        let start = |i: usize| (0..n).map(|j| found.right[(n + j, i)]).collect::<Vec<_>>();
        let square = |i: usize, j: usize| if i == j { p.omega[i] * p.omega[i] } else { 0.0 };
        let eigenproblem = QuadraticEigenproblem {
            n_inertial: n,
            damping: p.c.clone(),
            stiffness: Matrix::from_fn(n, n, square),
            hysteretic: None,
        };
        let polish = |i: usize| eigenproblem.polish(found.values[i], &start(i)).unwrap();
        let polished: Vec<_> = (0..2 * n).map(polish).collect();
        let values: Vec<Complex> = polished.iter().map(|m| m.value).collect();
        let worst = |found: &[Complex]| {
            let exact = matched(found, &p.values);
            found
                .iter()
                .zip(&exact)
                .map(|(f, e)| (f - e).norm() / e.norm())
                .fold(0.0, f64::max)
        };
        let residual = polished.iter().map(|m| m.residual).fold(0.0, f64::max);
        let steps = polished.iter().map(|m| m.steps).max().unwrap();
        println!(
            "{:12} before {:.1e}, after {:.1e}, residual {residual:.1e}, {steps} steps",
            p.name,
            worst(&found.values),
            worst(&values)
        );
        within("roots", worst(&values), 1e-13);
        assert!(residual < 1e-14, "{}", p.name);
    }
}
