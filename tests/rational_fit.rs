//! Hint-free fits of frequency responses: five known modes in noise, real recordings, and what no fit should stumble over.

use std::f64::consts::TAU;

use geardyn::identify::rational::{Delay, Measured, RationalFit, RationalOptions, fit};
use geardyn::numeric::Complex;

/// A known set of modes with real constants.
#[derive(Clone)]
struct Case {
    name: &'static str,
    frequency_hz: [f64; 5],
    damping: [f64; 5],
}

const WELL: Case = Case {
    name: "well separated",
    frequency_hz: [80.0, 190.0, 330.0, 520.0, 800.0],
    damping: [0.01; 5],
};
const PAIR: Case = Case {
    name: "pair 2 % apart",
    frequency_hz: [80.0, 190.0, 330.0, 336.6, 800.0],
    damping: [0.01; 5],
};
const LIGHT: Case = Case {
    name: "damping 1e-4",
    frequency_hz: [80.13, 190.21, 330.17, 520.37, 800.29],
    damping: [1e-4; 5],
};
const HEAVY: Case = Case {
    name: "damping 0.15",
    frequency_hz: [80.0, 190.0, 330.0, 520.0, 800.0],
    damping: [0.15; 5],
};
const CASES: [Case; 4] = [WELL, PAIR, LIGHT, HEAVY];

const RESPONSES: usize = 6;

/// Components of mode `r` at response `i`: those of a bench's beam, none of them zero.
fn constant(r: usize, i: usize) -> f64 {
    let at = 0.11 + 0.15 * i as f64;
    (((r + 1) as f64) * std::f64::consts::PI * at).cos() + 0.25
}

fn lines() -> Vec<f64> {
    (1..=2000).map(|k| 0.5 * k as f64).collect()
}

impl Case {
    fn pole(&self, r: usize) -> Complex {
        let w = TAU * self.frequency_hz[r];
        Complex::new(-self.damping[r] * w, w * (1.0 - self.damping[r].powi(2)).sqrt())
    }

    /// Receptances, each mode as high at its resonance as the others.
    fn responses(&self, f: &[f64], constants: &dyn Fn(usize, usize) -> f64) -> Vec<Vec<Complex>> {
        (0..RESPONSES)
            .map(|i| {
                f.iter()
                    .map(|&f| {
                        let s = Complex::new(0.0, TAU * f);
                        (0..5)
                            .map(|r| {
                                let p = self.pole(r);
                                let top = p.norm_sqr() * 2.0 * self.damping[r];
                                Complex::new(constants(r, i) * top, 0.0)
                                    / ((s - p) * (s - p.conj()))
                            })
                            .sum()
                    })
                    .collect()
            })
            .collect()
    }
}

/// A normal number by Box and Muller.
fn normal(rng: &mut fastrand::Rng) -> f64 {
    (-2.0 * (1.0 - rng.f64()).ln()).sqrt() * (TAU * rng.f64()).cos()
}

/// Noise `snr_db` below the root mean square of each response, and its variance.
fn noisy(clean: &[Vec<Complex>], snr_db: f64, seed: u64) -> (Vec<Vec<Complex>>, Vec<Vec<f64>>) {
    let mut rng = fastrand::Rng::with_seed(seed);
    let mut variance = Vec::new();
    let noisy = clean
        .iter()
        .map(|h| {
            let power = h.iter().map(|z| z.norm_sqr()).sum::<f64>() / h.len() as f64;
            let v = power * 10f64.powf(-snr_db / 10.0);
            variance.push(vec![v; h.len()]);
            let sd = (v / 2.0).sqrt();
            h.iter()
                .map(|z| z + Complex::new(normal(&mut rng), normal(&mut rng)) * sd)
                .collect()
        })
        .collect();
    (noisy, variance)
}

fn measured<'a>(
    f: &'a [f64],
    h: &'a [Vec<Complex>],
    variance: Option<&'a [Vec<f64>]>,
) -> Measured<'a> {
    Measured {
        frequency_hz: f,
        responses: h,
        variance,
        variance_trusted: variance.is_some(),
        line_independence: 1.0,
        derivative: 0,
    }
}

fn describe(fit: &RationalFit) -> String {
    let mut text = format!(
        "{:?} chi2/dof {:.3} {:?}\n",
        fit.structure,
        fit.chi2 / fit.dof,
        fit.effort
    );
    for m in &fit.modes {
        text += &format!(
            "  mode {:10.4} Hz {:.6} ± {:.2e} {:.2e}\n",
            m.frequency_hz(),
            m.damping_ratio(),
            m.frequency_std_hz().unwrap_or(f64::NAN),
            m.damping_std().unwrap_or(f64::NAN)
        );
    }
    for o in &fit.omitted {
        let (f, z) = (o.pole.norm() / TAU, -o.pole.re / o.pole.norm());
        text += &format!("  omitted {f:10.4} Hz {z:.6}: {}\n", o.reason);
    }
    for s in &fit.spread {
        text += &format!("  {s:?}\n");
    }
    for s in &fit.evidence {
        text += &format!("  {}\n", s.words());
    }
    for w in &fit.warnings {
        text += &format!("  warning: {}\n", w.message);
    }
    text
}

/// Largest relative errors of frequency and damping; the right number of modes is required.
fn errors(fit: &RationalFit, case: &Case) -> Option<(f64, f64)> {
    if fit.modes.len() != 5 {
        return None;
    }
    let mut worst = (0.0_f64, 0.0_f64);
    for r in 0..5 {
        let m = &fit.modes[r];
        worst.0 = worst.0.max((m.frequency_hz() / case.frequency_hz[r] - 1.0).abs());
        worst.1 = worst.1.max((m.damping_ratio() / case.damping[r] - 1.0).abs());
    }
    Some(worst)
}

/// All five modes of every case, none besides, whether the variance is known or not.
#[test]
fn law_five_modes_in_noise() {
    let f = lines();
    let mut missed = Vec::new();
    for case in &CASES {
        let clean = case.responses(&f, &constant);
        for (seed, snr) in [(1, 60.0), (2, 40.0), (3, 20.0)] {
            let (h, v) = noisy(&clean, snr, seed);
            for given in [true, false] {
                if !given && snr < 40.0 {
                    continue;
                }
                let variance = given.then_some(v.as_slice());
                let fit = fit(&measured(&f, &h, variance), &RationalOptions::default()).unwrap();
                let worst = errors(&fit, case);
                println!("{} {snr} dB given {given}: {worst:?} {}", case.name, describe(&fit));
                if worst.is_none() {
                    missed.push(format!("{} {snr} dB given {given}", case.name));
                }
            }
        }
    }
    assert!(missed.is_empty(), "{missed:?}");
}

/// Without noise the poles come back to rounding.
#[test]
fn exact_five_modes() {
    let f = lines();
    let mut missed = Vec::new();
    for case in &CASES {
        let h = case.responses(&f, &constant);
        let fit = fit(&measured(&f, &h, None), &RationalOptions::default()).unwrap();
        println!("{}: {}", case.name, describe(&fit));
        let Some((df, dz)) = errors(&fit, case) else {
            missed.push(case.name);
            continue;
        };
        println!("{}: {df:.1e} {dz:.1e}", case.name);
        assert!(df < 1e-13 && dz < 1e-12, "{}: {df:.1e} {dz:.1e}", case.name);
        let back = fit.synthesise(123.5);
        for i in 0..RESPONSES {
            assert!((back[i] - h[i][246]).norm() < 1e-11 * h[i][246].norm().max(0.01));
        }
    }
    assert!(missed.is_empty(), "{missed:?}");
}
