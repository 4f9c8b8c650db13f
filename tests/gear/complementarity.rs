//! Contact as a complementarity problem: conditions, brute force over all active sets, transitions, diagonal closed forms, refusals.

use geardyn::internals::numeric::complementarity::{ContactProblem, ContactSolution};
use geardyn::internals::numeric::profile_matrix::ProfileMatrix;

use crate::verification::within;

/// A random problem of `n` points with a compliance `B Bᵀ + shift`.
fn random(rng: &mut fastrand::Rng, n: usize, shift: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let b: Vec<f64> = (0..n * n).map(|_| 2.0 * rng.f64() - 1.0).collect();
    let entry = |i: usize, j: usize| {
        let product: f64 = (0..n).map(|k| b[i * n + k] * b[j * n + k]).sum();
        product + if i == j { shift } else { 0.0 }
    };
    let compliance = (0..n * n).map(|k| entry(k / n, k % n)).collect();
    let arms = (0..n).map(|_| 0.2 + rng.f64()).collect();
    let gaps = (0..n).map(|_| 3.0 * rng.f64()).collect();
    (compliance, arms, gaps)
}

/// `C F − a δ + g`.
fn loaded_gaps(c: &[f64], a: &[f64], g: &[f64], forces: &[f64], approach: f64) -> Vec<f64> {
    let row = |i: usize| {
        let deflection: f64 = (0..a.len()).map(|j| c[i * a.len() + j] * forces[j]).sum();
        deflection - a[i] * approach + g[i]
    };
    (0..a.len()).map(row).collect()
}

/// `A x = b` by elimination with pivoting.
fn eliminate(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Vec<f64> {
    let n = b.len();
    for j in 0..n {
        let pivot = (j..n)
            .max_by(|&p, &q| a[p][j].abs().total_cmp(&a[q][j].abs()))
            .unwrap();
        a.swap(j, pivot);
        b.swap(j, pivot);
        for i in j + 1..n {
            let factor = a[i][j] / a[j][j];
            for k in j..n {
                a[i][k] -= factor * a[j][k];
            }
            b[i] -= factor * b[j];
        }
    }
    for j in (0..n).rev() {
        let known: f64 = (j + 1..n).map(|k| a[j][k] * b[k]).sum();
        b[j] = (b[j] - known) / a[j][j];
    }
    b
}

/// Forces and approach by trying every active set.
fn by_all_sets(c: &[f64], a: &[f64], g: &[f64], load: f64) -> (Vec<f64>, f64) {
    let n = a.len();
    for mask in 1..1u32 << n {
        let set: Vec<usize> = (0..n).filter(|i| mask >> i & 1 == 1).collect();
        let mut matrix: Vec<Vec<f64>> = Vec::new();
        for &i in &set {
            let mut row: Vec<f64> = set.iter().map(|&j| c[i * n + j]).collect();
            row.push(-a[i]);
            matrix.push(row);
        }
        matrix.push(set.iter().map(|&i| a[i]).chain([0.0]).collect());
        let right = set.iter().map(|&i| -g[i]).chain([load]).collect();
        let x = eliminate(matrix, right);
        let mut forces = vec![0.0; n];
        set.iter().zip(&x).for_each(|(&i, f)| forces[i] = *f);
        let approach = x[set.len()];
        let gaps = loaded_gaps(c, a, g, &forces, approach);
        if forces.iter().all(|f| *f >= -1e-12) && gaps.iter().all(|w| *w >= -1e-11) {
            return (forces, approach);
        }
    }
    panic!("no active set of {n} points is a solution");
}

fn conditions(c: &[f64], a: &[f64], g: &[f64], load: f64, solution: &ContactSolution) -> f64 {
    let gaps = loaded_gaps(c, a, g, &solution.forces, solution.approach);
    let size = 1.0 + g.iter().fold(0.0, |most: f64, g| most.max(*g)) + solution.approach.abs();
    let total: f64 = solution.forces.iter().zip(a).map(|(f, a)| f * a).sum();
    let mut worst = (total - load).abs() / load;
    for ((f, w), active) in solution.forces.iter().zip(&gaps).zip(&solution.active) {
        assert!(*f >= 0.0 && (*active || *f == 0.0));
        worst = worst.max(if *active { w.abs() } else { -w } / size);
    }
    worst
}

/// Random problems of up to 8 points: the forces are those of the one active set among all that satisfies the conditions.
#[test]
fn exact_active_sets() {
    let mut rng = fastrand::Rng::with_seed(21);
    let mut worst = 0.0f64;
    for _ in 0..1500 {
        let n = rng.usize(1..=8);
        let (c, a, g) = random(&mut rng, n, 0.05);
        let load = 10f64.powf(3.0 * rng.f64() - 2.0);
        let problem =
            ContactProblem::new(ProfileMatrix::from_rows(&c, n), a.clone(), g.clone()).unwrap();
        let solution = problem.solve(load, None).unwrap();
        let (forces, approach) = by_all_sets(&c, &a, &g, load);
        let size = forces.iter().fold(load, |most, f| most.max(*f));
        for (f, exact) in solution.forces.iter().zip(&forces) {
            worst = worst.max((f - exact).abs() / size);
        }
        worst = worst.max((solution.approach - approach).abs() / (1.0 + approach.abs()));
    }
    within("forces and approach against all active sets", worst, 1e-9);
}

/// Random problems of up to 60 points, many stiffly coupled: no force pulls, no gap is negative, the load is carried; the same from any
/// active set, in few solves.
#[test]
fn law_complementarity() {
    let mut rng = fastrand::Rng::with_seed(4);
    let (mut worst, mut most) = (0.0f64, 0.0f64);
    for _ in 0..2000 {
        let n = rng.usize(1..=60);
        let shift = 10f64.powf(-4.0 * rng.f64());
        let (c, a, g) = random(&mut rng, n, shift);
        let load = 10f64.powf(4.0 * rng.f64() - 2.0);
        let problem =
            ContactProblem::new(ProfileMatrix::from_rows(&c, n), a.clone(), g.clone()).unwrap();
        let solution = problem.solve(load, None).unwrap();
        worst = worst.max(conditions(&c, &a, &g, load, &solution));
        most = most.max(solution.solves as f64 / n as f64);
        let start: Vec<bool> = (0..n).map(|_| rng.bool()).collect();
        let again = problem.solve(load, Some(&start)).unwrap();
        assert_eq!(again.active, solution.active);
        assert!(
            solution.solves <= 2 * n + 5,
            "{} solves of {n}",
            solution.solves
        );
    }
    within("complementarity", worst, 1e-10);
    println!("most solves a point {most:.2}");
}

/// A compliance of blocks on the diagonal, or of a diagonal, is kept within its profile: forces and approach are those of the same matrix
/// with coupling too small to matter, which fills the profile.
#[test]
fn law_profile_changes_nothing() {
    let mut rng = fastrand::Rng::with_seed(12);
    let mut worst = 0.0f64;
    for _ in 0..200 {
        let n = rng.usize(2..=24);
        let (c, a, g) = random(&mut rng, n, 0.05);
        let size = rng.usize(1..=4);
        let kept = |fill: f64| {
            let entry = |(q, c): (usize, &f64)| match (q / n) / size == (q % n) / size {
                true => *c,
                false => fill,
            };
            let rows: Vec<f64> = c.iter().enumerate().map(entry).collect();
            let matrix = ProfileMatrix::from_rows(&rows, n);
            ContactProblem::new(matrix, a.clone(), g.clone())
                .unwrap()
                .solve(2.0, None)
                .unwrap()
        };
        let (blocks, full) = (kept(0.0), kept(1e-14));
        let apart = blocks.forces.iter().zip(&full.forces);
        worst = apart.fold(worst, |most, (f, e)| most.max((f - e).abs() / 2.0));
        worst = worst.max((blocks.approach - full.approach).abs());
    }
    within("forces and approach", worst, 1e-9);
}

/// A compliance on which exchanging all violators together returns to a set it has had: single exchanges end it.
#[test]
fn exact_cycling_blocks() {
    let c = [
        24.01, 26.0, 0.0, -10.0, 26.0, 34.01, -8.0, -20.0, 0.0, -8.0, 36.01, 40.0, -10.0, -20.0,
        40.0, 49.01,
    ];
    let (a, g) = ([1.0; 4], [2.0, 4.0, 1.0, 5.0]);
    let problem =
        ContactProblem::new(ProfileMatrix::from_rows(&c, 4), a.to_vec(), g.to_vec()).unwrap();
    let solution = problem.solve(0.1, None).unwrap();
    let (forces, approach) = by_all_sets(&c, &a, &g, 0.1);
    assert!(solution.solves > 6, "{} solves: no cycle", solution.solves);
    let apart = solution
        .forces
        .iter()
        .zip(&forces)
        .map(|(f, e)| (f - e).abs());
    within("forces", apart.fold(0.0, f64::max), 1e-12);
    within("approach", (solution.approach - approach).abs(), 1e-12);
}

/// Springs of stiffness k behind gaps, uncoupled: each carries from the load Σ k (g − g_i) over the springs of smaller gap, and between
/// those loads δ is affine with slope 1/(m k).
#[test]
fn exact_transitions_of_springs() {
    let (k, gaps) = (2.0e8, [3e-6, 0.0, 1e-6, 7e-6, 0.0]);
    let n = gaps.len();
    let diagonal = ProfileMatrix::diagonal(vec![1.0 / k; n]);
    let problem = ContactProblem::new(diagonal, vec![1.0; n], gaps.to_vec()).unwrap();
    assert_eq!(problem.unloaded_approach(), 0.0);
    let transitions = problem.transitions(1e-3, 1e6).unwrap();
    let loads: Vec<f64> = transitions.iter().map(|t| t.load).collect();
    let expected = [
        2.0 * k * 1e-6,
        k * (2.0 * 3e-6 + 2e-6),
        k * (2.0 * 7e-6 + 6e-6 + 4e-6),
    ];
    assert_eq!(loads.len(), expected.len());
    let apart = loads.iter().zip(expected).map(|(l, e)| (l / e - 1.0).abs());
    within("loads of transition", apart.fold(0.0, f64::max), 1e-14);
    let at = |load: f64| problem.solve(load, None).unwrap();
    let line = at(500.0).approach + (1000.0 - 500.0) / (3.0 * k);
    within(
        "affine between transitions",
        (at(1000.0).approach / line - 1.0).abs(),
        1e-14,
    );
    within(
        "stiffness of four springs",
        (at(1700.0).stiffness / (4.0 * k) - 1.0).abs(),
        1e-14,
    );
}

/// Between the transitions of coupled problems the forces lie on straight lines, and at each transition the set changes.
#[test]
fn law_transitions() {
    let mut rng = fastrand::Rng::with_seed(8);
    let mut worst = 0.0f64;
    for _ in 0..200 {
        let n = rng.usize(2..=12);
        let (c, a, g) = random(&mut rng, n, 0.1);
        let problem = ContactProblem::new(ProfileMatrix::from_rows(&c, n), a, g).unwrap();
        let transitions = problem.transitions(0.01, 50.0).unwrap();
        let loads: Vec<f64> = [0.01]
            .into_iter()
            .chain(transitions.iter().map(|t| t.load))
            .chain([50.0])
            .collect();
        for (i, pair) in loads.windows(2).enumerate() {
            if pair[1] / pair[0] < 1.0 + 1e-6 {
                continue;
            }
            let along = |x: f64| {
                problem
                    .solve(pair[0] + x * (pair[1] - pair[0]), None)
                    .unwrap()
            };
            let [one, two, three] = [0.25, 0.5, 0.75].map(along);
            assert!(one.active == two.active && two.active == three.active);
            assert!(i == 0 || transitions[i - 1].active == one.active);
            for (j, f) in two.forces.iter().enumerate() {
                worst = worst.max((one.forces[j] - 2.0 * f + three.forces[j]).abs() / pair[1]);
            }
        }
    }
    within("forces are affine in the load", worst, 1e-11);
}

/// Sizes that differ, arms and loads that are not positive, numbers that are none, and a compliance that is not definite are refused.
#[test]
fn refuses_contacts() {
    let code = |c: &[f64], a: &[f64], g: &[f64], load: f64| {
        let rows = ProfileMatrix::from_rows(c, a.len().max(1));
        let problem = ContactProblem::new(rows, a.to_vec(), g.to_vec());
        problem
            .and_then(|p| p.solve(load, None))
            .unwrap_err()
            .code
            .as_str()
    };
    assert_eq!(code(&[], &[], &[], 1.0), "out-of-range");
    assert_eq!(code(&[1.0], &[1.0, 1.0], &[0.0, 0.0], 1.0), "out-of-range");
    assert_eq!(code(&[1.0], &[0.0], &[0.0], 1.0), "out-of-range");
    assert_eq!(code(&[1.0], &[1.0], &[f64::NAN], 1.0), "out-of-range");
    assert_eq!(code(&[1.0], &[1.0], &[0.0], 0.0), "out-of-range");
    assert_eq!(code(&[1.0], &[1.0], &[0.0], f64::NAN), "out-of-range");
    assert_eq!(code(&[-1.0], &[1.0], &[0.0], 1.0), "ill-posed");
    assert_eq!(
        code(&[1.0, 1.0, 1.0, 1.0], &[1.0, 1.0], &[0.0, 0.0], 1.0),
        "ill-posed"
    );
}

/// Gaps of 14 decades, one point, points that all touch together: a solution.
#[test]
fn survives_extreme_gaps() {
    let n = 20;
    let diagonal = ProfileMatrix::diagonal(vec![1e-9; n]);
    let solve = |gaps: Vec<f64>| {
        let problem = ContactProblem::new(diagonal.clone(), vec![1.0; n], gaps).unwrap();
        problem.solve(1.0, None).unwrap()
    };
    let spread = solve((0..n).map(|i| 10f64.powi(i as i32 - 14)).collect());
    assert!((spread.forces.iter().sum::<f64>() - 1.0).abs() < 1e-14);
    let level = solve(vec![1.0; n]);
    assert!(level.forces.iter().all(|f| (f - 0.05).abs() < 1e-7));
    let one =
        ContactProblem::new(ProfileMatrix::diagonal(vec![1e-9]), vec![1.0], vec![-5.0]).unwrap();
    assert_eq!(one.solve(1e-150, None).unwrap().forces, [1e-150]);
}
