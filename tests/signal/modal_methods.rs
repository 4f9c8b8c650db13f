//! Modal parameters from frequency responses: closed forms, made-up machines with known modes, bad input, measured beams.

use crate::support::npy;
use std::f64::consts::TAU;

use geardyn::internals::identify::modal::candidates::OrderPoles;
use geardyn::internals::identify::modal::lsce::lsce;
use geardyn::internals::identify::modal::lsfd::fit_residues;
use geardyn::internals::identify::modal::measured_frf::MeasuredFrf;
use geardyn::internals::identify::modal::plscf::{PlscfOptions, plscf};
use geardyn::internals::identify::modal::rfp::rfp;
use geardyn::internals::identify::modal::sdof::{circle_fit, half_power, pick_peaks};
use geardyn::internals::identify::modal::selection::{SelectedMode, SelectionRule, select_modes};
use geardyn::internals::identify::modal::stabilisation::{
    PoleStability, StabilisationTolerances, stabilisation,
};
use geardyn::internals::numeric::Complex;
use geardyn::internals::numeric::mac::mac;
use geardyn::internals::spectrum::integrate::MotionQuantity;

const HZ: [f64; 5] = [60.0, 180.0, 330.0, 560.0, 820.0];
const ZETA: [f64; 5] = [0.01, 0.02, 0.005, 0.01, 0.015];

fn pole(hz: f64, zeta: f64) -> Complex {
    Complex::new(-zeta, (1.0 - zeta * zeta).sqrt()) * (TAU * hz)
}

/// Shape of mode r at place x of a string.
fn string(r: usize, x: f64) -> f64 {
    ((r + 1) as f64 * std::f64::consts::PI * x).sin()
}

/// Five modes of unit modal mass, six outputs, inputs at the places of the first outputs; noise relative to the whole's rms.
fn machine(inputs: usize, noise: f64, seed: u64) -> (Vec<f64>, Vec<Vec<Vec<Complex>>>) {
    let f: Vec<f64> = (1..=2000).map(|k| 0.5 * f64::from(k)).collect();
    let place = |o: usize| (o + 1) as f64 / 7.0;
    let value = |o: usize, i: usize, f: f64| {
        let s = Complex::new(0.0, TAU * f);
        (0..5).fold(Complex::ZERO, |sum, r| {
            let p = pole(HZ[r], ZETA[r]);
            let residue = Complex::new(
                0.0,
                -string(r, place(o)) * string(r, place(i)) / (2.0 * p.im),
            );
            sum + residue / (s - p) + residue.conj() / (s - p.conj())
        })
    };
    let mut h: Vec<Vec<Vec<Complex>>> = (0..6)
        .map(|o| {
            (0..inputs)
                .map(|i| f.iter().map(|&f| value(o, i, f)).collect())
                .collect()
        })
        .collect();
    let all = h.iter().flatten().flatten();
    let rms = (all.clone().map(Complex::norm_sqr).sum::<f64>() / all.count() as f64).sqrt();
    let mut random = fastrand::Rng::with_seed(seed);
    for z in h.iter_mut().flatten().flatten() {
        let size = noise * rms * (-(1.0 - random.f64()).ln()).sqrt(); // complex normal, E|z|² = 1
        *z += Complex::new(0.0, TAU * random.f64()).exp() * size;
    }
    (f, h)
}

fn chosen(orders: &[OrderPoles], spacing: f64) -> Vec<SelectedMode> {
    select_modes(orders, spacing, &SelectionRule::default())
}

/// Largest relative errors of frequency and damping; every mode must be there and no other.
fn errors(modes: &[SelectedMode]) -> (f64, f64) {
    let list: Vec<(f64, f64)> = modes
        .iter()
        .map(|m| (m.mode.frequency_hz(), m.mode.damping_ratio()))
        .collect();
    println!("{list:.5?}");
    assert_eq!(modes.len(), 5, "{list:?}");
    let worst = |values: Vec<f64>| values.into_iter().fold(0.0, f64::max);
    (
        worst((0..5).map(|r| (list[r].0 / HZ[r] - 1.0).abs()).collect()),
        worst((0..5).map(|r| (list[r].1 / ZETA[r] - 1.0).abs()).collect()),
    )
}

fn within(what: &str, (frequency, damping): (f64, f64), allowed: (f64, f64)) {
    println!("{what}: frequency {frequency:.1e}, damping {damping:.1e}");
    assert!(
        frequency <= allowed.0 && damping <= allowed.1,
        "{what}: {frequency:.1e} {damping:.1e}"
    );
}

/// Five modes from responses without noise: frequency, damping, shape.
#[test]
fn exact_five_modes_without_noise() {
    for inputs in [1, 3] {
        let (f, h) = machine(inputs, 0.0, 1);
        let responses = MeasuredFrf::new(&f, &h).unwrap();
        let orders = plscf(
            &responses,
            &PlscfOptions {
                max_order: Some(60 / inputs),
            },
        )
        .unwrap();
        within("plscf", errors(&chosen(&orders, 0.5)), (1e-5, 1e-3));
    }
}

#[test]
fn survives_noise_of_40_db() {
    for (inputs, seed) in [(1, 2), (1, 3), (3, 4)] {
        let (f, h) = machine(inputs, 0.01, seed);
        let responses = MeasuredFrf::new(&f, &h).unwrap();
        let orders = plscf(&responses, &PlscfOptions::default()).unwrap();
        within("plscf, 40 dB", errors(&chosen(&orders, 0.5)), (1e-3, 0.15));
    }
}

/// In the middle band, where the impulse responses and the polynomials have room on both sides.
#[test]
fn exact_other_methods_without_noise() {
    let (f, h) = machine(1, 0.0, 1);
    let responses = MeasuredFrf::new(&f, &h).unwrap();
    within(
        "rfp",
        errors(&chosen(&rfp(&responses, 24).unwrap(), 0.5)),
        (1e-9, 1e-7),
    );
    within(
        "lsce",
        errors(&chosen(&lsce(&responses, 60).unwrap(), 0.5)),
        (1e-3, 0.1),
    );
}

/// Residues of the given poles come back with shapes, driving point and modal mass 1.
#[test]
fn exact_residues_and_modal_mass() {
    let (f, h) = machine(2, 0.0, 1);
    let responses = MeasuredFrf::new(&f, &h).unwrap();
    let poles: Vec<Complex> = (0..5).map(|r| pole(HZ[r], ZETA[r])).collect();
    let fit = fit_residues(&responses, &poles, MotionQuantity::Displacement).unwrap();
    for r in 0..5 {
        let exact: Vec<Complex> = (0..6)
            .map(|o| Complex::new(string(r, (o + 1) as f64 / 7.0), 0.0))
            .collect();
        let found = fit.mode_shape(r).unwrap();
        assert!(mac(&found.shape, &exact) > 1.0 - 1e-12 && found.rank_one_share > 1.0 - 1e-12);
        let largest = exact.iter().fold(0.0_f64, |m, z| m.max(z.norm()));
        let scaling = fit.modal_scaling(r, 1, 1).unwrap();
        // mode r has unit mass for the string's own shape, so largest² for the shape with largest component 1
        assert!(
            (scaling.modal_mass * largest * largest - 1.0).abs() < 1e-9,
            "{}",
            scaling.modal_mass
        );
    }
    let fitted = fit.synthesise(3, 1, f[700]);
    assert!((fitted - h[3][1][700]).norm() < 1e-10 * h[3][1][700].norm());
}

/// One mode of 10 % damping by half power, and of any residue beside a constant by the circle.
#[test]
fn exact_single_mode() {
    let f: Vec<f64> = (1..4000).map(|k| 0.05 * f64::from(k)).collect();
    let p = pole(100.0, 0.1);
    for (quantity, n) in [
        (MotionQuantity::Displacement, 0),
        (MotionQuantity::Velocity, 1),
        (MotionQuantity::Acceleration, 2),
    ] {
        let h = |f: &f64| {
            let s = Complex::new(0.0, TAU * f);
            s.powi(n) / ((s - p) * (s - p.conj()))
        };
        let h: Vec<Complex> = f.iter().map(h).collect();
        let peak = pick_peaks(&h, 0.5)[0];
        let found = half_power(&f, &h, peak, quantity).unwrap();
        assert!(
            (found.frequency_hz() / 100.0 - 1.0).abs() < 1e-6,
            "{found:?}"
        );
        assert!(
            (found.damping_ratio() / 0.1 - 1.0).abs() < 1e-5,
            "{found:?}"
        );
        let arc = peak - 100..peak + 100;
        let found = circle_fit(&f[arc.clone()], &h[arc], quantity).unwrap();
        assert!((found.pole - p).norm() < 1e-8 * p.norm(), "{found:?}");
    }
    let turned: Vec<Complex> = f
        .iter()
        .map(|f| {
            let s = Complex::new(0.0, TAU * f);
            let mobility = s / ((s - p) * (s - p.conj()));
            mobility * Complex::new(0.0, 0.7).exp() + Complex::new(1e-4, -2e-4)
        })
        .collect();
    let found = circle_fit(
        &f[1800..2200],
        &turned[1800..2200],
        MotionQuantity::Velocity,
    )
    .unwrap();
    assert!((found.pole - p).norm() < 1e-8 * p.norm(), "{found:?}");
}

#[test]
fn law_diagram_marks_repeated_poles() {
    let (f, h) = machine(1, 0.0, 1);
    let responses = MeasuredFrf::new(&f, &h).unwrap();
    let orders = plscf(
        &responses,
        &PlscfOptions {
            max_order: Some(40),
        },
    )
    .unwrap();
    let points = stabilisation(&orders, &StabilisationTolerances::default());
    for hz in HZ {
        let stable = points.iter().filter(|p| {
            p.stability == PoleStability::Stable && (p.frequency_hz / hz - 1.0).abs() < 1e-3
        });
        assert!(stable.count() > 8, "{hz}");
    }
    assert!(
        points
            .iter()
            .filter(|p| p.order == 2)
            .all(|p| p.stability == PoleStability::New)
    );
}

#[test]
fn refuses_what_cannot_be_fitted() {
    let f: Vec<f64> = (1..=50).map(f64::from).collect();
    let good: Vec<Complex> = f.iter().map(|x| Complex::new(1.0, x * 0.1).inv()).collect();
    let word = |f: &[f64], h: &[Vec<Complex>]| {
        let error = MeasuredFrf::single_input(f, h).unwrap_err();
        assert!(error.hint.is_some(), "{error}");
        error.code.as_str()
    };
    let mut bad = good.clone();
    bad[7].im = f64::NAN;
    assert_eq!(word(&f, &[bad]), "not-a-number");
    assert_eq!(word(&f, &[vec![Complex::new(2.0, 1.0); 50]]), "no-signal");
    assert_eq!(word(&f, &[vec![Complex::ZERO; 50]]), "no-signal");
    assert_eq!(word(&f, &[]), "no-signal");
    assert_eq!(word(&f[..4], &[good[..4].to_vec()]), "too-short");
    assert_eq!(word(&f, &[good[..4].to_vec()]), "ill-posed");
    let repeated: Vec<f64> = f.iter().map(|f| (f / 2.0).floor()).collect();
    assert_eq!(word(&repeated, std::slice::from_ref(&good)), "bad-time");
    // one response without a mode: methods return, whatever they find
    let one = [good];
    let responses = MeasuredFrf::single_input(&f, &one).unwrap();
    let orders = plscf(&responses, &PlscfOptions::default()).unwrap();
    chosen(&orders, 1.0);
    assert_eq!(
        plscf(
            &responses,
            &PlscfOptions {
                max_order: Some(1000)
            }
        )
        .unwrap_err()
        .code
        .as_str(),
        "too-short"
    );
    assert_eq!(rfp(&responses, 0).unwrap_err().code.as_str(), "too-short");
    assert_eq!(
        lsce(&responses, 900).unwrap_err().code.as_str(),
        "too-short"
    );
    assert_eq!(
        fit_residues(&responses, &[], MotionQuantity::Displacement)
            .unwrap_err()
            .code
            .as_str(),
        "ill-posed"
    );
    assert!(responses.band(100.0, 90.0).is_err());
}

const BEAM_HZ: [f64; 7] = [177.05, 477.37, 933.10, 1535.48, 2286.86, 3162.52, 4181.87];
const BEAM_ZETA: [f64; 7] = [0.0080, 0.0017, 0.0015, 0.0020, 0.0028, 0.0018, 0.0015];

fn check_beam(responses: &MeasuredFrf) {
    let start = std::time::Instant::now();
    let orders = plscf(responses, &PlscfOptions::default()).unwrap();
    let poles = start.elapsed();
    let modes = chosen(&orders, responses.frequency_resolution_hz());
    println!(
        "poles {poles:.2?}, selection {:.2?}",
        start.elapsed() - poles
    );
    for m in &modes {
        println!(
            "{:9.2} Hz {:.5} ± {:.5}, presence {:.2}",
            m.mode.frequency_hz(),
            m.mode.damping_ratio(),
            m.scatter_damping,
            m.presence
        );
    }
    for (hz, zeta) in BEAM_HZ.iter().zip(BEAM_ZETA) {
        let found = modes.iter().any(|m| {
            (m.mode.frequency_hz() / hz - 1.0).abs() < 0.005
                && (m.mode.damping_ratio() / zeta - 1.0).abs() < 0.15
        });
        assert!(found, "{hz} Hz");
    }
}

/// Seven bending modes of a beam measured with a hammer, by six responses and by 42.
/// Source: measured beam of sdypy-EMA; modes published with it.
#[test]
#[ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"]
fn ref_beam_recordings() {
    let folder = std::env::var("GEARDYN_RECORDINGS").unwrap() + "/sdypy_ema_beam/";
    let text = std::fs::read_to_string(folder.clone() + "sdypy_beam_frf_resp1.csv").unwrap();
    let rows: Vec<Vec<f64>> = text
        .lines()
        .skip(1)
        .map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect();
    let f: Vec<f64> = rows.iter().map(|row| row[0]).collect();
    let six: Vec<Vec<Complex>> = (0..6)
        .map(|o| {
            rows.iter()
                .map(|row| Complex::new(row[1 + 2 * o], row[2 + 2 * o]))
                .collect()
        })
        .collect();
    check_beam(
        &MeasuredFrf::single_input(&f, &six)
            .unwrap()
            .band(10.0, 5000.0)
            .unwrap(),
    );

    let arrays = npy::arrays(&std::fs::read(folder + "acc_data.npy").unwrap(), 1000);
    let n = arrays[0].len();
    let value = |at: usize| -> Vec<Complex> {
        (at * n..(at + 1) * n)
            .map(|k| Complex::new(arrays[1][2 * k], arrays[1][2 * k + 1]))
            .collect()
    };
    let all: Vec<Vec<Complex>> = (0..42).map(value).collect();
    check_beam(
        &MeasuredFrf::single_input(&arrays[0], &all)
            .unwrap()
            .band(10.0, 5000.0)
            .unwrap(),
    );
    let by_input: Vec<Vec<Vec<Complex>>> = (0..7)
        .map(|o| (0..6).map(|i| value(i * 7 + o)).collect())
        .collect();
    check_beam(
        &MeasuredFrf::new(&arrays[0], &by_input)
            .unwrap()
            .band(10.0, 5000.0)
            .unwrap(),
    );
}
