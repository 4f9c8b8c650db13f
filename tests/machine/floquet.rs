//! Parametric stability and periodic orbits: Mathieu's and Meissner's equations, gear pairs with play, invariants.

use std::f64::consts::TAU;

use crate::support::machines::Random;
use crate::support::moving::{branch, contact, cosine, gear_pair, inertias, run, spring, wave};
use crate::support::verification::printed;
use crate::support::{number, numbers, reference, within};
use geardyn::internals::base::time_budget::CancelToken;
use geardyn::internals::motion::contact::ContactDamping;
use geardyn::internals::motion::dynamic_model::DynamicModel;
use geardyn::internals::motion::floquet::fold::{FoldOptions, find_fold};
use geardyn::internals::motion::floquet::orbit::{find_orbit, return_map};
use geardyn::internals::motion::floquet::stability_chart::instability_tongues;
use geardyn::internals::motion::floquet::{Monodromy, monodromy};
use geardyn::internals::motion::wave::Waveform;

/// `x″ + 2ζ x′ + shape(ωt) x = 0`.
fn oscillator(waveform: Waveform, omega: f64, zeta: f64) -> DynamicModel {
    let mut model = inertias(&[1.0]);
    let law = contact(1.0, 2.0 * zeta, 0.0, ContactDamping::Adhesive);
    let mut mesh = branch("mesh", &[(0, 1.0)], law);
    mesh.stiffness_wave = wave(waveform, omega, 0.0);
    model.elements.push(mesh);
    model
}

fn trace(phi: &Monodromy) -> f64 {
    phi.matrix[(0, 0)] + phi.matrix[(1, 1)]
}

fn determinant(phi: &Monodromy) -> f64 {
    phi.matrix[(0, 0)] * phi.matrix[(1, 1)] - phi.matrix[(0, 1)] * phi.matrix[(1, 0)]
}

/// The root near a number, by bisection.
fn root(f: impl Fn(f64) -> f64, near: f64, width: f64) -> f64 {
    let (mut low, mut high) = (near - width, near + 1.1 * width);
    let sign = f(low).signum();
    assert!(f(high).signum() != sign, "no root near {near}");
    while high - low > 4.0 * f64::EPSILON * near.abs().max(1.0) {
        let middle = 0.5 * (low + high);
        if f(middle).signum() == sign {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// `a_n(q)` are the zeros of Φ₂₁ and `b_n(q)` those of Φ₁₂, the wave being even (Abramowitz and Stegun 1964, sec. 20.3).
/// Source: M. Abramowitz and I. A. Stegun, Handbook of Mathematical Functions (1964), table 20.1; truncated Hill matrices with 40 digits by mpmath.
#[test]
fn ref_mathieu_boundaries() {
    let all = reference("floquet");
    for table in ["mathieu", "mathieu_published"] {
        for (q, boundaries) in all[table].as_object().unwrap() {
            let q: f64 = q.strip_prefix("q=").unwrap().parse().unwrap();
            for (name, value) in boundaries.as_object().unwrap() {
                let entry = if name.starts_with('a') {
                    (1, 0)
                } else {
                    (0, 1)
                };
                let phi = |a: f64| {
                    let waveform = Waveform::Fourier {
                        mean: a,
                        terms: vec![(1, -2.0 * q, 0.0)],
                    };
                    monodromy(&oscillator(waveform, 2.0, 0.0), None)
                        .unwrap()
                        .matrix[entry]
                };
                let off = (root(phi, number(value), 1e-3) - number(value)).abs();
                if table == "mathieu" {
                    within("a₀ to b₄ for q from 0.1 to 20", off, 1e-10);
                } else {
                    let what = format!("{name} at q = {q}");
                    printed(
                        &what,
                        "",
                        number(value),
                        root(phi, number(value), 1e-3),
                        1e-8,
                    );
                }
            }
        }
    }
}

/// A damped edge: a multiplier of −1, `tr Φ + 1 + det Φ = 0`.
fn check_edges(table: &str, shape: impl Fn(f64) -> Waveform) {
    let all = reference("floquet");
    for (key, edges) in all[table].as_object().unwrap() {
        let (e, zeta) = key.split_once(',').unwrap();
        let e: f64 = e.strip_prefix("e=").unwrap().parse().unwrap();
        let zeta: f64 = zeta.strip_prefix("zeta=").unwrap().parse().unwrap();
        for edge in numbers(edges) {
            let beyond = |omega: f64| {
                let phi = monodromy(&oscillator(shape(e), omega, zeta), None).unwrap();
                trace(&phi) + 1.0 + determinant(&phi)
            };
            let off = (root(beyond, edge, 1e-3) - edge).abs();
            within("edges", off, 1e-9);
        }
    }
}

/// The edges of the principal region of Mathieu's damped equation.
/// Source: monodromy by DOP853 of SciPy, rtol 1e-13.
#[test]
fn ref_damped_edges() {
    check_edges("damped_edges", cosine);
    check_edges("square_edges", |e| Waveform::Rectangular {
        high: 1.0 + e,
        low: 1.0 - e,
        duty: 0.5,
    });
}

/// Traces of the monodromy of Meissner's equation, stiffness in two steps.
/// Source: product of two propagators with 30 digits by mpmath.
#[test]
fn ref_meissner_traces() {
    let all = reference("floquet");
    let mut worst: f64 = 0.0;
    for row in all["square"].as_array().unwrap() {
        let [omega, e, duty, zeta, expected, radius] = [0, 1, 2, 3, 4, 5].map(|i| number(&row[i]));
        let waveform = Waveform::Rectangular {
            high: 1.0 + e,
            low: 1.0 - e * duty / (1.0 - duty),
            duty,
        };
        let phi = monodromy(&oscillator(waveform, omega, zeta), None).unwrap();
        let multipliers = phi.multipliers().unwrap();
        worst = worst.max((trace(&phi) - expected).abs());
        worst = worst.max((multipliers.largest - radius).abs());
        assert_eq!(multipliers.is_stable(), row[6].as_bool().unwrap(), "{row}");
    }
    println!("largest error {worst:.1e}");
    within("traces and spectral radii", worst, 1e-10);
}

/// Orbits of the gear pair with play, found from a state beside them.
/// Source: Newton shooting on DOP853 of SciPy with located events; equation of A. Kahraman and R. Singh, J. Sound Vib. 142 (1990) 49.
#[test]
fn ref_gear_pair_orbits() {
    let all = reference("floquet");
    let (mut state, mut multiplier, mut shape): (f64, f64, f64) = (0.0, 0.0, 0.0);
    for row in all["orbits"].as_array().unwrap() {
        let set = &all["sets"][row[0].as_str().unwrap()];
        let of = |key: &str| number(&set[key]);
        let [omega, x, v, largest] = [1, 2, 3, 4].map(|i| number(&row[i]));
        let model = gear_pair(omega, of("zeta"), of("eps"), of("Fm"), of("Fah"));
        let found = find_orbit(&model, &[x + 1e-4, v - 1e-4], 1).unwrap();
        state = state
            .max((found.start[0] - x).abs())
            .max((found.start[1] - v).abs());
        multiplier = multiplier.max((found.multipliers[0].norm() - largest).abs());
        assert_eq!(found.events, row[9].as_u64().unwrap(), "{row}");
        let (_, states, _) = run("periodic", &model, &found.start, TAU / omega, 4000).unwrap();
        let x: Vec<f64> = states[1..].iter().map(|y| y[0]).collect();
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        let square = x.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / x.len() as f64;
        let high = x.iter().copied().fold(f64::MIN, f64::max);
        let low = x.iter().copied().fold(f64::MAX, f64::min);
        for (ours, column) in [(high, 5), (low, 6), (mean, 7), (square.sqrt(), 8)] {
            shape = shape.max((ours - number(&row[column])).abs());
        }
    }
    println!("states {state:.1e}, multipliers {multiplier:.1e}, shapes {shape:.1e}");
    within("states", state, 1e-8);
    within("multipliers", multiplier, 1e-6);
    within("largest, least, mean and rms of orbits", shape, 1e-6);
}

/// The ends of the range with two orbits; the reference is good to 5e-6.
/// Source: Newton shooting on DOP853 of SciPy with located events; equation of A. Kahraman and R. Singh, J. Sound Vib. 142 (1990) 49.
#[test]
fn ref_gear_pair_folds() {
    let folds = numbers(&reference("floquet")["folds_S1"]);
    let family = |omega: f64| gear_pair(omega, 0.05, 0.0, 0.1, 0.05);
    let starts = [
        ([1.19657449782, 0.0198219451562], 0.82, 1e-3),
        ([0.83384301254, 0.164078751799], 0.75, -5e-3),
    ];
    for (expected, (near, from, step)) in folds.into_iter().zip(starts) {
        let course = FoldOptions {
            from,
            step,
            max_steps: 200,
        };
        let (omega, orbit) = find_fold(&family, &near, 1, course).unwrap();
        println!(
            "{omega} for {expected}, multipliers {:?}",
            orbit.multipliers
        );
        within("speeds of folds", (omega - expected).abs(), 2e-5);
        assert!((orbit.multipliers[0].re - 1.0).abs() < 1e-2);
    }
}

/// P′ against differences of P, where the force jumps at touch and release.
#[test]
fn law_saltation_agrees_with_differences() {
    for contact_damping in [
        ContactDamping::ActsInGap,
        ContactDamping::Adhesive,
        ContactDamping::NoPull,
        ContactDamping::Continuous,
    ] {
        let mut model = gear_pair(0.85, 0.1, 0.2, 0.1, 0.05);
        let waveform = cosine(0.2);
        let mut mesh = branch("mesh", &[(0, 1.0)], contact(1.0, 0.2, 1.0, contact_damping));
        mesh.stiffness_wave = wave(waveform, 0.85, 0.0);
        model.elements[0] = mesh;
        let start = [1.4, 0.1];
        let map = return_map(&model, &start, 2).unwrap();
        let moved = |i: usize, by: f64| {
            let mut start = start;
            start[i] += by;
            return_map(&model, &start, 2).unwrap().end
        };
        let h = 1e-6;
        for j in 0..2 {
            let (up, down) = (moved(j, h), moved(j, -h));
            for i in 0..2 {
                let difference = (up[i] - down[i]) / (2.0 * h) * map.units[j];
                let off = (map.jacobian[i * 2 + j] - difference).abs();
                assert!(off < 1e-7, "{contact_damping:?} ({i}, {j}): {off:.1e}");
            }
        }
        assert!(map.events > 1, "{contact_damping:?}");
    }
}

/// Three inertias in a row, two meshes of varying stiffness.
fn chain(damping: f64, ground: f64) -> DynamicModel {
    let mut model = inertias(&[1.0, 0.5, 2.0]);
    for (at, waveform) in [cosine(0.25), Waveform::Table(vec![0.9, 1.2, 0.95, 0.95])]
        .into_iter()
        .enumerate()
    {
        let law = contact([40.0, 25.0][at], damping, 0.0, ContactDamping::Adhesive);
        let mut mesh = branch("mesh", &[(at, 1.0), (at + 1, -1.0)], law);
        mesh.stiffness_wave = wave(waveform, [3.0, 6.0][at], [0.3, 1.1][at]);
        model.elements.push(mesh);
    }
    if ground > 0.0 {
        model
            .elements
            .push(branch("ground", &[(2, 1.0)], spring(ground, damping)));
    }
    model
}

/// `det Φ = exp(∫ tr A dt)` (Liouville 1838).
#[test]
fn law_determinant_is_what_damping_takes() {
    let phi = monodromy(&chain(0.3, 3.0), None).unwrap();
    let multipliers = phi.multipliers().unwrap();
    let product = multipliers.values.iter().fold(1.0, |p, z| p * z.norm());
    let lost = 0.3 * ((1.0 + 2.0) + (2.0 + 0.5) + 0.5) * phi.period;
    let off = (product.ln() + lost).abs();
    assert!(off < 1e-11, "{off:.1e}");
}

/// Without damping the multipliers are μ and 1/μ.
#[test]
fn law_multipliers_are_reciprocal() {
    let multipliers = monodromy(&chain(0.0, 3.0), None)
        .unwrap()
        .multipliers()
        .unwrap();
    assert_eq!(multipliers.rigid, 0);
    for z in &multipliers.values {
        let partner = z.conj() / z.norm_sqr();
        let off = multipliers.values.iter().map(|w| (w - partner).norm());
        let off = off.fold(f64::INFINITY, f64::min);
        assert!(off < 1e-10, "{z}: {off:.1e}");
    }
}

/// A machine that turns freely is not unstable for it.
#[test]
fn law_free_turning_stands_apart() {
    let multipliers = monodromy(&chain(0.3, 0.0), None)
        .unwrap()
        .multipliers()
        .unwrap();
    assert_eq!(multipliers.rigid, 2);
    assert!((multipliers.values[0].re - 1.0).abs() == 0.0);
    assert!((multipliers.values[1].re - 1.0).abs() < 1e-12);
    assert!(multipliers.is_stable() && multipliers.largest < 0.9);
}

/// The chart of Mathieu's equation: the principal tongue between its edges.
/// Source: M. Abramowitz and I. A. Stegun, Handbook of Mathematical Functions (1964), sec. 20.3.
#[test]
fn ref_chart_of_one_freedom() {
    let found = instability_tongues(
        &oscillator(cosine(0.2), 1.0, 0.0),
        [0.9, 2.5],
        160,
        &CancelToken::default(),
    )
    .unwrap();
    let names: Vec<&str> = found.iter().map(|t| t.name.as_str()).collect();
    println!("{found:?}");
    assert_eq!(names, ["ω1", "2 ω1"]);
    let edges = numbers(&reference("floquet")["damped_edges"]["e=0.2,zeta=0.0"]);
    assert!((found[1].from - edges[0]).abs() < 4e-6 && (found[1].to - edges[1]).abs() < 4e-6);
    assert!(
        found[1].growth > 1.15
            && found[1].most_unstable > found[1].from
            && found[1].most_unstable < found[1].to
    );
    let damped = instability_tongues(
        &oscillator(cosine(0.2), 1.0, 0.02),
        [0.9, 2.5],
        160,
        &CancelToken::default(),
    )
    .unwrap();
    assert_eq!(damped.len(), 1);
}

/// Deep waves feed high orders, each near its own share of twice the natural frequency.
#[test]
fn law_chart_names_high_orders() {
    let deep = oscillator(cosine(0.8), 1.0, 0.0);
    let found = instability_tongues(&deep, [0.37, 0.85], 500, &CancelToken::default()).unwrap();
    let names: Vec<&str> = found.iter().map(|t| t.name.as_str()).collect();
    println!("{found:?}");
    assert_eq!(names, ["2 ω1/5", "2 ω1/4", "2 ω1/3"]);
}

/// Two freedoms joined by one mesh: a combination resonance where they are.
#[test]
fn law_chart_names_sums() {
    let mut model = inertias(&[1.0, 1.0]);
    let mut mesh = branch(
        "mesh",
        &[(0, 1.0), (1, 1.0)],
        contact(1.0, 0.0, 0.0, ContactDamping::Adhesive),
    );
    mesh.stiffness_wave = wave(cosine(0.6), 1.0, 0.0);
    model.elements.push(mesh);
    model
        .elements
        .push(branch("a", &[(0, 1.0)], spring(1.0, 0.01)));
    model
        .elements
        .push(branch("b", &[(1, 1.0)], spring(8.0, 0.01)));
    let found = instability_tongues(&model, [2.0, 7.0], 250, &CancelToken::default()).unwrap();
    println!("{found:#?}");
    assert!(found.iter().any(|t| t.name == "ω1 + ω2"));
    assert!(found.iter().any(|t| t.name == "2 ω2"));
}

/// Tongues narrower than the steps: where modes meet between them, each with the edges of Mathieu's equation, at which a
/// multiplier is ±1 and so `|tr Φ| = 2` (Abramowitz and Stegun 1964, sec. 20.3).
/// Source: M. Abramowitz and I. A. Stegun, Handbook of Mathematical Functions (1964), sec. 20.3.
#[test]
fn ref_chart_finds_narrow_tongues() {
    let at = |omega: f64| oscillator(cosine(0.3), omega, 0.0);
    let found = instability_tongues(&at(1.0), [0.42, 2.6], 7, &CancelToken::default()).unwrap();
    let names: Vec<&str> = found.iter().map(|t| t.name.as_str()).collect();
    println!("{found:#?}");
    assert_eq!(names, ["2 ω1/4", "2 ω1/3", "ω1", "2 ω1"]);
    for tongue in found {
        for (edge, outwards) in [(tongue.from, -1.0), (tongue.to, 1.0)] {
            let beyond = |omega: f64| trace(&monodromy(&at(omega), None).unwrap()).abs() - 2.0;
            let apart = 4e-6 * edge;
            let (inside, outside) = (edge - outwards * apart, edge + outwards * apart);
            assert!(beyond(inside) > 0.0 && beyond(outside) < 0.0, "{edge}");
        }
    }
}

/// A coarse chart and a fine one find the same tongues of a machine of two modes, damped or not.
#[test]
fn law_chart_does_not_hang_on_its_steps() {
    for damping in [0.0, 0.004] {
        let mut model = inertias(&[1.0, 1.0]);
        let mut mesh = branch(
            "mesh",
            &[(0, 1.0), (1, 1.0)],
            contact(1.0, damping, 0.0, ContactDamping::Adhesive),
        );
        mesh.stiffness_wave = wave(cosine(0.5), 1.0, 0.0);
        model.elements.push(mesh);
        for (at, stiffness) in [(0, 1.0), (1, 8.0)] {
            let law = spring(stiffness, damping);
            model.elements.push(branch("ground", &[(at, 1.0)], law));
        }
        let chart = |points| {
            instability_tongues(&model, [1.2, 7.0], points, &CancelToken::default()).unwrap()
        };
        let (coarse, fine) = (chart(5), chart(4000));
        println!("{coarse:#?}");
        assert!(fine.len() > 3 || damping > 0.0, "{fine:?}");
        for tongue in &fine {
            let same = coarse.iter().find(|t| t.name == tongue.name);
            let same = same.unwrap_or_else(|| panic!("{} is missing", tongue.name));
            for (one, other) in [(same.from, tongue.from), (same.to, tongue.to)] {
                assert!((one / other - 1.0).abs() < 4e-6, "{same:?} {tongue:?}");
            }
            assert!((same.growth - tongue.growth).abs() < 1e-4 * tongue.growth);
        }
        assert!(coarse.len() >= fine.len());
    }
}

/// Chains of four inertias and two meshes, rectangular and smooth, of two periods and any depth and damping: tongues that a fine
/// chart sees are in a coarse one as well.
#[test]
#[ignore = "a study: minutes"]
fn law_coarse_charts_of_random_chains() {
    let mut random = Random::new(11);
    let (mut missing, mut all) = (0, 0);
    for _ in 0..12 {
        let mut model = inertias(&[(); 4].map(|()| random.between(0.3, 1.3)));
        let damping = [0.0, 0.002, 0.02][random.below(3)] * random.unit();
        let depth = 0.6 * random.unit();
        let rectangular = Waveform::Rectangular {
            high: 1.0 + depth,
            low: 1.0 - depth,
            duty: 0.5,
        };
        let waves = [Some((cosine(depth), 1.0)), Some((rectangular, 2.0)), None];
        for (at, varying) in waves.into_iter().enumerate() {
            let stiffness = random.between(3.0, 13.0);
            let law = contact(
                stiffness,
                damping * stiffness,
                0.0,
                ContactDamping::Adhesive,
            );
            let mut mesh = branch("mesh", &[(at, 1.0), (at + 1, -1.0)], law);
            mesh.stiffness_wave =
                varying.and_then(|(waveform, omega)| wave(waveform, omega, random.unit()));
            model.elements.push(mesh);
        }
        let ground = spring(random.between(0.3, 3.0), damping);
        model.elements.push(branch("ground", &[(0, 1.0)], ground));
        let chart = |points| {
            instability_tongues(&model, [1.0, 6.0], points, &CancelToken::default()).unwrap()
        };
        let (coarse, fine) = (chart(12), chart(400));
        let found = |at: f64| coarse.iter().any(|t| t.from <= at && at <= t.to);
        for tongue in &fine {
            all += 1;
            if !found(tongue.most_unstable) {
                missing += 1;
                println!("{tongue:?}");
            }
        }
        let (coarse, fine) = (coarse.len(), fine.len());
        println!("damping {damping:.1e}, depth {depth:.2}: {coarse} of {fine}");
    }
    println!("{missing} of {all} missing");
    assert!(50 * missing <= all, "{missing} of {all}");
}
