//! Lowest modes of forests where bisection and inverse iteration have least to go by: equal, nearly equal and separate branches.

use std::f64::consts::PI;

use geardyn::internals::numeric::forest::{Forest, ForestSpring};
use geardyn::internals::numeric::lanczos::RitzPairs;

use super::numeric_sparse::{ground, lowest, shaft};

/// Arms of `length` discs on a hub; arm j is stiffer by the factor `stiffer(j)`.
fn arms(
    count: usize,
    length: usize,
    stiffer: impl Fn(usize) -> f64,
) -> (Vec<ForestSpring>, Vec<f64>) {
    let mut springs = Vec::new();
    for arm in 0..count {
        let node = |s: usize| if s == 0 { 0 } else { arm * length + s };
        springs.extend((1..=length).map(|s| shaft(node(s - 1), node(s), stiffer(arm))));
    }
    (springs, vec![1.0; count * length + 1])
}

/// Eigenvalue k of a uniform chain of n discs held at one end, k = J = 1.
fn held_chain(n: usize, k: usize) -> f64 {
    let angle = PI * (2 * k - 1) as f64 / (2.0 * (2 * n + 1) as f64);
    (2.0 * angle.sin()).powi(2)
}

/// Shapes are M-orthonormal, and every value stands between its counts.
fn check(what: &str, springs: &[ForestSpring], mass: &[f64], found: &RitzPairs) {
    let forest = Forest::new(mass.len(), springs, mass).unwrap();
    let rigid = forest.rigid_motions().len();
    assert!(found.sturm_verified, "{what}");
    for (i, v) in found.vectors.iter().enumerate() {
        for (j, w) in found.vectors[..=i].iter().enumerate() {
            let product: f64 = v.iter().zip(w).zip(mass).map(|((v, w), m)| v * w * m).sum();
            let expected = f64::from(u8::from(i == j));
            assert!((product - expected).abs() < 1e-12, "{what}: {i}, {j}");
        }
    }
    for (k, (value, shape)) in found.values.iter().zip(&found.vectors).enumerate() {
        let below = |side: f64| forest.count_below(mass, value * (1.0 + side * 1e-12));
        let (under, over) = (below(-1.0), below(1.0));
        assert!(
            under <= rigid + k && rigid + k < over,
            "{what}: {under}, mode {k}, {over}"
        );
        let mut residual: Vec<f64> = (shape.iter().zip(mass))
            .map(|(x, m)| -value * m * x)
            .collect();
        let mut size = 0.0_f64;
        for s in springs {
            let (j, c) = s.second.unwrap_or((s.i, 0.0));
            let force = s.k * (s.a * shape[s.i] + c * shape[j]);
            residual[s.i] += s.a * force;
            residual[j] += c * force;
            size = size.max(s.k * (s.a * shape[s.i]).abs());
        }
        let worst = residual.iter().fold(0.0_f64, |m, r| m.max(r.abs()));
        assert!(
            worst < 1e-12 * size,
            "{what}: mode {k}, {worst:e} of {size:e}"
        );
    }
}

/// Five equal arms on a free hub: four copies of each frequency of an arm held at the hub, whichever of them is the last requested.
#[test]
fn law_a_cluster_may_end_at_the_last_mode() {
    let (springs, mass) = arms(5, 40, |_| 1.0);
    let all = lowest(&springs, &mass, 12);
    let copies = |k: usize| {
        let close = |v: &&f64| (**v / held_chain(40, k) - 1.0).abs() < 1e-13;
        all.values.iter().filter(close).count()
    };
    assert_eq!((copies(1), copies(2)), (4, 4), "{:?}", all.values);
    for wanted in 1..=12 {
        let found = lowest(&springs, &mass, wanted);
        check(&format!("lowest {wanted}"), &springs, &mass, &found);
        assert_eq!(found.values.len(), wanted);
        for (v, w) in found.values.iter().zip(&all.values) {
            assert!((v / w - 1.0).abs() < 1e-14, "lowest {wanted}");
        }
    }
}

/// Arms that differ in a late digit: neither bisection nor inverse iteration may lose one or find one twice.
#[test]
fn survives_nearly_equal_arms() {
    for digits in [3, 6, 8, 9, 10, 11, 12, 13, 14, 15] {
        let step = 10_f64.powi(-digits);
        let (springs, mass) = arms(5, 40, |arm| 1.0 + step * arm as f64);
        check(
            &format!("1e-{digits}"),
            &springs,
            &mass,
            &lowest(&springs, &mass, 9),
        );
    }
}

/// Separate equal bodies with massless nodes between their discs: every value of one comes as often as there are bodies.
#[test]
fn law_equal_bodies_with_massless_nodes() {
    let (bodies, n) = (9, 30);
    let (mut springs, mut mass) = (Vec::new(), Vec::new());
    for body in 0..bodies {
        let first = body * (2 * n - 1);
        springs.extend((1..2 * n - 1).map(|s| shaft(first + s - 1, first + s, 2.0)));
        mass.extend((0..2 * n - 1).map(|s| if s % 2 == 0 { 1.0 } else { 0.0 }));
    }
    let free = |k: usize| (2.0 * (PI * k as f64 / (2 * n) as f64).sin()).powi(2);
    let found = lowest(&springs, &mass, 2 * bodies + 1);
    check("bodies", &springs, &mass, &found);
    for (at, value) in found.values.iter().enumerate() {
        assert!((value / free(1 + at / bodies) - 1.0).abs() < 1e-13, "{at}");
    }
    springs.extend((0..bodies).map(|body| ground(body * (2 * n - 1), 1e-9)));
    let held = lowest(&springs, &mass, 2 * bodies);
    check("held by soft springs", &springs, &mass, &held);
    assert!(held.values[bodies - 1] < 1e-9 && held.values[bodies] > 1e-3);
    assert_eq!(lowest(&springs, &mass, 10_000).values.len(), bodies * n);
}
