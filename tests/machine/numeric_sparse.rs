//! Forests, their counts and Lanczos: closed forms, another program's digits, and dense answers.

use std::f64::consts::PI;
use std::time::Instant;

use crate::support::verification::within;
use faer::Side;
use geardyn::internals::numeric::Matrix;
use geardyn::internals::numeric::forest::{Forest, ForestSpring};
use geardyn::internals::numeric::forest_modes::lowest_modes;
use geardyn::internals::numeric::lanczos::{LanczosProblem, RitzPairs, nearest_modes};
use geardyn::internals::numeric::shift_invert::{EnergyCorrected, ShiftedForest};
use geardyn::internals::numeric::sparse::{LdlFactor, SparseSymmetric};
use serde_json::Value;

/// The lowest modes of springs and a diagonal mass.
pub(super) fn lowest(springs: &[ForestSpring], mass: &[f64], wanted: usize) -> RitzPairs {
    let forest = Forest::new(mass.len(), springs, mass).unwrap();
    if forest.n_loops() == 0 {
        return lowest_modes(&forest, mass, wanted).unwrap();
    }
    let rigid = forest.rigid_motions();
    let inverse = ShiftedForest::unshifted(&forest);
    let matrix = SparseSymmetric::diagonal(mass);
    let count = |sigma: f64| Ok(forest.count_below(mass, sigma));
    let search = LanczosProblem {
        inverse: &inverse,
        mass: &matrix,
        rigid: &rigid,
        count: Some(&count),
        n_modes: wanted,
    };
    nearest_modes(&search).unwrap()
}

pub(super) fn shaft(i: usize, j: usize, k: f64) -> ForestSpring {
    ForestSpring {
        i,
        a: -1.0,
        second: Some((j, 1.0)),
        k,
    }
}

pub(super) fn ground(i: usize, k: f64) -> ForestSpring {
    ForestSpring {
        i,
        a: 1.0,
        second: None,
        k,
    }
}

fn worst<'a>(found: &'a [f64], expected: impl Iterator<Item = f64> + 'a) -> f64 {
    found
        .iter()
        .zip(expected)
        .map(|(f, e)| ((f - e) / e).abs())
        .fold(0.0, f64::max)
}

/// K from its springs.
fn assembled(springs: &[ForestSpring]) -> Vec<(usize, usize, f64)> {
    let mut entries = Vec::new();
    for s in springs {
        entries.push((s.i, s.i, s.k * s.a * s.a));
        if let Some((j, c)) = s.second {
            entries.extend([(j, j, s.k * c * c), (s.i, j, s.k * s.a * c)]);
        }
    }
    entries
}

fn dense_values(springs: &[ForestSpring], mass: &[f64]) -> Vec<f64> {
    let mut k = Matrix::zeros(mass.len(), mass.len());
    for (i, j, v) in assembled(springs) {
        let v = v / (mass[i] * mass[j]).sqrt();
        k[(i, j)] += v;
        if i != j {
            k[(j, i)] += v;
        }
    }
    k.self_adjoint_eigenvalues(Side::Lower).unwrap()
}

/// Numbers in [0, 1), the same every time.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        (self.roll() * n as f64) as usize
    }
}

/// A tree with ratios of powers of two, loops that fit them, and springs to ground.
fn train(n: usize, loops: usize, grounds: usize, seed: u64) -> (Vec<ForestSpring>, Vec<f64>) {
    let mut dice = Dice(seed);
    let mut turning = vec![1.0_f64; n];
    let mut springs = Vec::new();
    for j in 1..n {
        let i = if dice.roll() < 0.7 {
            j - 1
        } else {
            dice.below(j)
        };
        let sized = if turning[i].abs() > 8.0 { -0.5 } else { -2.0 };
        turning[j] = if dice.roll() < 0.3 {
            turning[i] * sized
        } else {
            turning[i]
        };
        let a = 0.5 + dice.roll();
        springs.push(ForestSpring {
            i,
            a,
            second: Some((j, -a * turning[i] / turning[j])),
            k: 10_f64.powf(2.0 * dice.roll()),
        });
    }
    for _ in 0..loops {
        let (i, j) = (dice.below(n / 2), n / 2 + dice.below(n / 2));
        springs.push(ForestSpring {
            i,
            a: 1.0 / turning[i],
            second: Some((j, -1.0 / turning[j])),
            k: 10.0,
        });
    }
    (0..grounds).for_each(|g| springs.push(ground(g * n / grounds, 0.5 + dice.roll())));
    let mass = (0..n).map(|_| 10_f64.powf(dice.roll())).collect();
    (springs, mass)
}

/// A uniform chain, k = J = 1: ω = 2 sin((2k − 1) π / (2 (2N + 1))) fixed–free, 2 sin(k π / (2N)) free–free.
#[test]
fn exact_uniform_chains() {
    for n in [10, 1000, 100_000] {
        let mut springs: Vec<ForestSpring> = (1..n).map(|j| shaft(j - 1, j, 1.0)).collect();
        let mass = vec![1.0; n];
        for fixed in [false, true] {
            if fixed {
                springs.push(ground(0, 1.0));
            }
            let wanted = 20.min(n - 1);
            let begin = Instant::now();
            let ritz = lowest(&springs, &mass, wanted);
            let seconds = begin.elapsed().as_secs_f64();
            let size = n as f64;
            let angle = |k: f64| {
                if fixed {
                    (2.0 * k - 1.0) / (2.0 * (2.0 * size + 1.0))
                } else {
                    k / (2.0 * size)
                }
            };
            let omega = |k: usize| 2.0 * (PI * angle(k as f64)).sin();
            let found: Vec<f64> = ritz.values.iter().map(|v| v.sqrt()).collect();
            let error = worst(&found, (1..=wanted).map(omega));
            println!(
                "n {n} fixed {fixed}: worst {error:.1e}, {} solves, {} runs, {seconds:.3} s",
                ritz.solves, ritz.runs
            );
            let held = if fixed { "held" } else { "free" };
            within(&format!("{n} discs {held}, lowest {wanted}"), error, 1e-12);
            assert!(
                ritz.sturm_verified && found.len() == wanted,
                "n {n}, {held}"
            );
            let forest = Forest::new(n, &springs, &mass).unwrap();
            let rigid = usize::from(!fixed);
            for k in 1..=wanted {
                let (below, above) = (omega(k) * (1.0 - 1e-12), omega(k) * (1.0 + 1e-12));
                assert_eq!(forest.count_below(&mass, below * below), rigid + k - 1);
                assert_eq!(forest.count_below(&mass, above * above), rigid + k);
            }
        }
    }
}

/// Equal branches on a hub: all but one of each of their frequencies repeat, ω² = k/J.
#[test]
fn exact_repeated_frequencies() {
    let arms = 12;
    let mut springs: Vec<ForestSpring> = (1..=arms).map(|j| shaft(0, j, 3.0)).collect();
    let mut mass = vec![2.0; arms + 1];
    mass[0] = 5.0;
    let ritz = lowest(&springs, &mass, arms);
    let last = 3.0 * (1.0 / 2.0 + arms as f64 / 5.0);
    let exact = (1..=arms).map(|k| if k < arms { 1.5 } else { last });
    within("hub", worst(&ritz.values, exact), 1e-14);
    springs.push(ground(0, 7.0));
    let grounded = lowest(&springs, &mass, arms + 1);
    let dense = dense_values(&springs, &mass);
    within(
        "hub held",
        worst(&grounded.values, dense.into_iter()),
        1e-13,
    );
}

/// Long equal arms: ten copies of each arm's frequencies among the lowest 25, all counted.
#[test]
fn law_repeated_frequencies_of_long_arms_are_all_found() {
    let (arms, length) = (11, 300);
    let mut springs = Vec::new();
    for arm in 0..arms {
        let node = |s: usize| if s == 0 { 0 } else { arm * length + s };
        springs.extend((1..=length).map(|s| shaft(node(s - 1), node(s), 1.0)));
    }
    let mass = vec![1.0; arms * length + 1];
    let ritz = lowest(&springs, &mass, 25);
    let fixed =
        |k: f64| (2.0 * (PI * (2.0 * k - 1.0) / (2.0 * (2.0 * length as f64 + 1.0))).sin()).powi(2);
    let copies = |k: f64| {
        ritz.values
            .iter()
            .filter(|v| (**v / fixed(k) - 1.0).abs() < 1e-12)
            .count()
    };
    println!("long arms: {} solves in {} runs", ritz.solves, ritz.runs);
    assert_eq!(
        (copies(1.0), copies(2.0)),
        (arms - 1, arms - 1),
        "{:?}",
        ritz.values
    );
    assert!(ritz.sturm_verified);
}

#[test]
fn law_trains_agree_with_dense() {
    for (seed, loops, grounds) in [
        (1, 0, 0),
        (2, 0, 1),
        (3, 0, 9),
        (4, 1, 0),
        (5, 3, 1),
        (6, 6, 0),
        (7, 6, 5),
    ] {
        let (springs, mass) = train(500, loops, grounds, seed);
        let dense = dense_values(&springs, &mass);
        let rigid = usize::from(grounds == 0);
        let ritz = lowest(&springs, &mass, 20);
        let error = worst(&ritz.values, dense[rigid..].iter().copied());
        assert!(
            error < 1e-9 && ritz.sturm_verified,
            "seed {seed}: {error:e}"
        ); // ε λ_max / λ_1 of the dense answer
        let forest = Forest::new(500, &springs, &mass).unwrap();
        for k in (rigid..499)
            .step_by(7)
            .filter(|&k| dense[k + 1] > dense[k] * 1.0001)
        {
            assert_eq!(
                forest.count_below(&mass, 0.5 * (dense[k] + dense[k + 1])),
                k + 1,
                "seed {seed}, k {k}"
            );
        }
    }
}

#[test]
fn law_nearest_modes_agree_with_dense() {
    for (seed, loops) in [(11, 0), (12, 4), (13, 120)] {
        let (springs, mass) = train(400, loops, 1, seed);
        let mut dense = dense_values(&springs, &mass);
        let target = 0.999 * dense[200] + 0.001 * dense[201];
        dense.sort_by(|a, b| (a - target).abs().total_cmp(&(b - target).abs()));
        dense.truncate(12);
        dense.sort_by(f64::total_cmp);
        let (k, m) = (
            SparseSymmetric::from_entries(400, &assembled(&springs)),
            SparseSymmetric::diagonal(&mass),
        );
        let factor = LdlFactor::shifted(&k, &m, target).unwrap();
        let count = |sigma: f64| LdlFactor::shifted(&k, &m, sigma).map(|f| f.n_negative());
        let search = LanczosProblem {
            inverse: &factor,
            mass: &m,
            rigid: &[],
            count: Some(&count),
            n_modes: 12,
        };
        let found = nearest_modes(&search).unwrap();
        assert!(
            worst(&found.values, dense.iter().copied()) < 1e-11 && found.sturm_verified,
            "seed {seed}"
        );
        let Some(forest) = Forest::new(400, &springs, &mass) else {
            continue;
        };
        let inverse = ShiftedForest::shifted(&forest, &mass, target);
        let uncounted = nearest_modes(&LanczosProblem {
            inverse: &inverse,
            count: None,
            ..search
        })
        .unwrap();
        assert!(
            worst(&uncounted.values, dense.iter().copied()) < 1e-11 && !uncounted.sturm_verified,
            "seed {seed}, forest"
        );
        assert_eq!(forest.count_below(&mass, target), factor.n_negative());
    }
}

/// Two gear pairs that would turn one shaft at two speeds: nothing can turn, though no spring goes to ground.
#[test]
fn exact_contradicting_ratios_hold_the_train() {
    let springs = [
        ForestSpring {
            i: 0,
            a: 1.0,
            second: Some((1, 2.0)),
            k: 3.0,
        },
        ForestSpring {
            i: 0,
            a: 1.0,
            second: Some((1, 1.0)),
            k: 5.0,
        },
        shaft(1, 2, 7.0),
    ];
    let mass = [1.0, 2.0, 3.0];
    let forest = Forest::new(3, &springs, &mass).unwrap();
    assert!(forest.rigid_motions().is_empty());
    let found = lowest(&springs, &mass, 3);
    let dense = dense_values(&springs, &mass);
    within(
        "frequencies",
        worst(&found.values, dense.into_iter()),
        1e-14,
    );
}

/// Graded forests: lowest frequencies and static solutions.
/// Source: mpmath 1.3.0 with 120 digits (tools/reference_forest.py).
#[test]
fn ref_mpmath_graded_forests() {
    let text = std::fs::read_to_string("data/reference/forest.json").unwrap();
    let file: Value = serde_json::from_str(&text).unwrap();
    let numbers = |v: &Value| {
        v.as_array()
            .unwrap()
            .iter()
            .map(|x| x.as_f64().unwrap())
            .collect::<Vec<f64>>()
    };
    for case in file["cases"].as_array().unwrap() {
        let name = case["name"].as_str().unwrap();
        let mass = numbers(&case["mass"]);
        let springs: Vec<ForestSpring> = case["springs"]
            .as_array()
            .unwrap()
            .iter()
            .map(spring)
            .collect();
        let forest = Forest::new(mass.len(), &springs, &mass).unwrap();
        if let Some(x) = case.get("x") {
            let mut found = numbers(&case["f"]);
            forest.factorise().solve(&mut found);
            let error = worst(&found, numbers(x).into_iter());
            within("static solutions", error, 1e-12);
        }
        let rigid = forest.rigid_motions().len();
        let values = numbers(&case["values"]);
        let exact = |tolerance: f64| {
            values.iter().enumerate().all(|(k, v)| {
                forest.count_below(&mass, v * (1.0 - tolerance)) == rigid + k
                    && forest.count_below(&mass, v * (1.0 + tolerance)) == rigid + k + 1
            })
        };
        let good = (4..16)
            .rev()
            .map(|digits| 10_f64.powi(-digits))
            .find(|&t| exact(t));
        let ritz = lowest(&springs, &mass, values.len());
        println!("{name}: counts to {good:?}");
        within(
            "eigenvalues",
            worst(&ritz.values, values.iter().copied()),
            1e-9,
        );
        assert!(good.is_some_and(|t| t <= 1e-12), "{name}: {good:?}");
    }
}

fn spring(row: &Value) -> ForestSpring {
    let number = |i: usize| row[i].as_f64().unwrap();
    let other = row[2].as_u64().map(|j| (j as usize, number(3)));
    ForestSpring {
        i: row[0].as_u64().unwrap() as usize,
        a: number(1),
        second: other,
        k: number(4),
    }
}

/// Springs over 14 decades and inertias over 12: every value stands between two counts.
#[test]
fn survives_graded_trains() {
    for (seed, n, loops, grounds) in [
        (21, 40, 0, 0),
        (22, 200, 0, 1),
        (23, 300, 0, 4),
        (24, 40, 4, 1),
        (25, 200, 6, 0),
        (26, 2000, 2, 0),
        (27, 20000, 0, 0),
    ] {
        let (mut springs, mut mass) = train(n, loops, grounds, seed);
        let mut dice = Dice(seed + 1000);
        springs
            .iter_mut()
            .for_each(|s| s.k *= 10_f64.powf(14.0 * dice.roll() - 7.0));
        mass.iter_mut()
            .for_each(|m| *m *= 10_f64.powf(12.0 * dice.roll() - 6.0));
        let begin = Instant::now();
        let ritz = lowest(&springs, &mass, 20);
        let seconds = begin.elapsed().as_secs_f64();
        let forest = Forest::new(n, &springs, &mass).unwrap();
        let rigid = forest.rigid_motions().len();
        let good = |t: f64| {
            ritz.values.iter().enumerate().all(|(k, v)| {
                forest.count_below(&mass, v * (1.0 - t)) <= rigid + k
                    && forest.count_below(&mass, v * (1.0 + t)) > rigid + k
            })
        };
        let digits = (1..16).rev().find(|&d| good(10_f64.powi(-d)));
        let worst = ritz.residuals.iter().copied().fold(0.0, f64::max);
        println!(
            "graded n {n} loops {loops} grounds {grounds}: within counts to {digits:?} digits, residual {worst:.0e}, {} solves, {} runs, {seconds:.3} s, counted {}",
            ritz.solves, ritz.runs, ritz.sturm_verified
        );
        assert!(digits.is_some_and(|d| d >= 11), "seed {seed}");
    }
}

#[test]
fn survives_nothing_and_too_much() {
    assert!(lowest(&[], &[], 3).values.is_empty());
    assert!(lowest(&[], &[1.0, 2.0], 3).values.is_empty());
    assert!(
        lowest(&[shaft(0, 1, 2.0)], &[1.0, 1.0], 0)
            .values
            .is_empty()
    );
    assert_eq!(
        lowest(&[shaft(0, 1, 2.0), shaft(2, 3, 2.0)], &[1.0; 5], 9)
            .values
            .len(),
        2
    );
    assert!(lowest(&[ground(0, 1.0)], &[0.0], 1).values.is_empty());
    assert!(lowest(&[shaft(0, 1, 2.0)], &[1.0, 1.0], 5).sturm_verified);
    assert_eq!(
        LdlFactor::new(&SparseSymmetric::diagonal(&[]))
            .unwrap()
            .n_negative(),
        0
    );
    assert!(Forest::new(2, &[shaft(0, 1, f64::NAN)], &[1.0; 2]).is_none());
    assert!(Forest::new(2, &[shaft(0, 5, 1.0)], &[1.0; 2]).is_none());
    assert!(
        Forest::new(
            2,
            &[shaft(0, 1, 1e300), ground(0, f64::INFINITY)],
            &[1.0; 2]
        )
        .is_none()
    );
    let many: Vec<ForestSpring> = (0..60).map(|k| shaft(0, 1, 1.0 + k as f64)).collect();
    assert!(Forest::new(2, &many, &[1.0; 2]).is_none());
}

#[test]
fn refuses_a_singular_matrix() {
    let k = SparseSymmetric::from_entries(2, &assembled(&[shaft(0, 1, 1.0)]));
    let error = LdlFactor::new(&k).err().unwrap();
    assert_eq!(
        error.code,
        geardyn::internals::base::code::Code::NoConvergence
    );
    let m = SparseSymmetric::diagonal(&[1.0, 1.0]);
    let moved = LdlFactor::shifted(&k, &m, 2.0).unwrap();
    assert!(
        (moved.shift() / 2.0 - 1.0).abs() < 1e-4 && moved.shift() != 2.0 && moved.n_negative() == 2
    );
    let broken = SparseSymmetric::diagonal(&[1.0, f64::NAN]);
    assert_eq!(
        LdlFactor::new(&broken).err().unwrap().code,
        geardyn::internals::base::code::Code::Overflow
    );
}

/// A shift on an eigenvalue moves off it and still finds it: discs 1 and 1 on a spring of 2, λ = 4.
#[test]
fn survives_a_shift_on_an_eigenvalue() {
    let (springs, mass) = (
        [shaft(0, 1, 2.0), shaft(1, 2, 2.0), shaft(2, 3, 2.0)],
        [1.0, 1.0, 1.0, 1.0],
    );
    let forest = Forest::new(4, &springs, &mass).unwrap();
    let m = SparseSymmetric::diagonal(&mass);
    let inverse = ShiftedForest::shifted(&forest, &mass, 4.0);
    let count = |sigma: f64| Ok(forest.count_below(&mass, sigma));
    let search = LanczosProblem {
        inverse: &inverse,
        mass: &m,
        rigid: &forest.rigid_motions(),
        count: Some(&count),
        n_modes: 1,
    };
    assert!((nearest_modes(&search).unwrap().values[0] / 4.0 - 1.0).abs() < 1e-14);
}

/// A free square net of springs, k = J = 1, too many loops for a forest: λ = 4 sin²(pπ/2N) + 4 sin²(qπ/2N), most of them twice.
#[test]
fn exact_net() {
    let side = 60;
    let at = |row: usize, col: usize| row * side + col;
    let mut springs = Vec::new();
    for row in 0..side {
        for col in 1..side {
            springs.extend([
                shaft(at(row, col - 1), at(row, col), 1.0),
                shaft(at(col - 1, row), at(col, row), 1.0),
            ]);
        }
    }
    let n = side * side;
    assert!(Forest::new(n, &springs, &vec![1.0; n]).is_none());
    let (k, m) = (
        SparseSymmetric::from_entries(n, &assembled(&springs)),
        SparseSymmetric::diagonal(&vec![1.0; n]),
    );
    let factor = LdlFactor::shifted(&k, &m, -1e-4).unwrap();
    let energy = |y: &[f64]| {
        springs
            .iter()
            .map(|s| s.k * (s.second.map_or(0.0, |(j, c)| c * y[j]) + s.a * y[s.i]).powi(2))
            .sum()
    };
    let count = |sigma: f64| LdlFactor::shifted(&k, &m, sigma).map(|f| f.n_negative());
    let rigid = [vec![1.0; n]];
    let inverse = EnergyCorrected {
        factor: &factor,
        energy: &energy,
    };
    let begin = Instant::now();
    let search = LanczosProblem {
        inverse: &inverse,
        mass: &m,
        rigid: &rigid,
        count: Some(&count),
        n_modes: 20,
    };
    let found = nearest_modes(&search).unwrap();
    println!(
        "net: {} solves, {} runs, {:.3} s",
        found.solves,
        found.runs,
        begin.elapsed().as_secs_f64()
    );
    let part = |p: usize| 4.0 * (PI * p as f64 / (2.0 * side as f64)).sin().powi(2);
    let mut exact: Vec<f64> = (1..n).map(|i| part(i / side) + part(i % side)).collect();
    exact.sort_by(f64::total_cmp);
    let error = worst(&found.values, exact.into_iter());
    within("lowest 20", error, 1e-12);
    assert!(found.sturm_verified);
}

/// A free bar of linear elements with consistent mass: λ = 12 sin²(θ/2) / (2 + cos θ), θ = kπ/(n − 1).
#[test]
fn exact_consistent_mass() {
    let n = 2000;
    let springs: Vec<ForestSpring> = (1..n).map(|j| shaft(j - 1, j, 1.0)).collect();
    let elements = (1..n).flat_map(|j| {
        [
            (j - 1, j - 1, 1.0 / 3.0),
            (j, j, 1.0 / 3.0),
            (j, j - 1, 1.0 / 6.0),
        ]
    });
    let m = SparseSymmetric::from_entries(n, &elements.collect::<Vec<_>>());
    let k = SparseSymmetric::from_entries(n, &assembled(&springs));
    let forest = Forest::new(n, &springs, &vec![1.0; n]).unwrap();
    let inverse = ShiftedForest::unshifted(&forest);
    let count = |sigma: f64| LdlFactor::shifted(&k, &m, sigma).map(|f| f.n_negative());
    let search = LanczosProblem {
        inverse: &inverse,
        mass: &m,
        rigid: &forest.rigid_motions(),
        count: Some(&count),
        n_modes: 20,
    };
    let found = nearest_modes(&search).unwrap();
    let angle = |k: usize| k as f64 * PI / (n as f64 - 1.0);
    let error = worst(
        &found.values,
        (1..=20).map(|k| 12.0 * (angle(k) / 2.0).sin().powi(2) / (2.0 + angle(k).cos())),
    );
    within("lowest 20", error, 1e-12);
    assert!(found.sturm_verified);
    for (i, v) in found.vectors.iter().enumerate() {
        let mut mv = vec![0.0; n];
        m.mul_vec(v, &mut mv);
        for (j, w) in found.vectors.iter().enumerate() {
            let product: f64 = w.iter().zip(&mv).map(|(w, v)| w * v).sum();
            assert!((product - f64::from(u8::from(i == j))).abs() < 1e-12);
        }
    }
}
