//! Transfer functions by poles and residues against closed forms and scipy; rational fits against systems they must recover.

use std::f64::consts::TAU;

use crate::support::verification::within;
use geardyn::internals::base::code::Code;
use geardyn::internals::identify::initial_estimates::aaa::aaa;
use geardyn::internals::identify::initial_estimates::levy::levy;
use geardyn::internals::identify::initial_estimates::problem::{CommonPoleFit, CommonPoleOptions};
use geardyn::internals::identify::initial_estimates::vector_fitting::{InitialPoles, vector_fit};
use geardyn::internals::identify::transfer::export;
use geardyn::internals::identify::transfer::function::{DirectTerms, TransferFunction};
use geardyn::internals::identify::transfer::realisation::{DiscretisationMethod, Realisation};
use geardyn::internals::numeric::{Complex, eigen};
use geardyn::internals::recording::frequency_responses::ChannelLabel;

fn c(re: f64, im: f64) -> Complex {
    Complex::new(re, im)
}

fn named(name: &str) -> ChannelLabel {
    ChannelLabel {
        name: name.into(),
        unit: String::new(),
    }
}

/// A lightly damped system of so many modes between 20 and 500 Hz, seen by so many sensors.
fn system(modes: usize, sensors: usize, seed: u64) -> (Vec<Complex>, Vec<Vec<Complex>>) {
    let mut rng = fastrand::Rng::with_seed(seed);
    let pole = |k: usize, rng: &mut fastrand::Rng| {
        let w = TAU * (20.0 + 480.0 * (k as f64 + 0.3 + 0.4 * rng.f64()) / modes as f64);
        c(-w * (0.003 + 0.01 * rng.f64()), w)
    };
    let poles: Vec<Complex> = (0..modes).map(|k| pole(k, &mut rng)).collect();
    let mut list = || {
        poles
            .iter()
            .map(|p| c(0.3 * (rng.f64() - 0.5), rng.f64() - 0.5) * (0.02 * p.im))
            .collect()
    };
    let residues = (0..sensors).map(|_| list()).collect();
    (poles, residues)
}

fn responses(
    poles: &[Complex],
    residues: &[Vec<Complex>],
    constant: f64,
    lines: &[f64],
) -> Vec<Vec<Complex>> {
    let direct = DirectTerms {
        constant,
        ..DirectTerms::default()
    };
    let one = |list: &Vec<Complex>| {
        TransferFunction::new(poles.to_vec(), list.clone(), direct)
            .unwrap()
            .response(lines)
    };
    residues.iter().map(one).collect()
}

fn lines(count: usize) -> Vec<f64> {
    (0..count)
        .map(|k| 10.0 + 500.0 * k as f64 / (count - 1) as f64)
        .collect()
}

/// The largest relative distance of a pole to the nearest found one.
fn worst(poles: &[Complex], found: &CommonPoleFit) -> f64 {
    let nearest = |p: &Complex| {
        found
            .poles
            .iter()
            .map(|f| (f - p).norm())
            .fold(f64::INFINITY, f64::min)
            / p.norm()
    };
    poles.iter().map(nearest).fold(0.0, f64::max)
}

fn reference() -> serde_json::Value {
    let text = std::fs::read_to_string(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/data/reference/transfer.json"
    ));
    serde_json::from_str(&text.unwrap()).unwrap()
}

fn unpack(list: &serde_json::Value) -> Vec<Complex> {
    let one = |z: &serde_json::Value| c(z[0].as_f64().unwrap(), z[1].as_f64().unwrap());
    list.as_array().unwrap().iter().map(one).collect()
}

/// The largest distance of entries paired nearest, as a share of the largest entry.
fn apart(a: &[Complex], b: &[Complex]) -> f64 {
    assert_eq!(a.len(), b.len(), "{a:?} {b:?}");
    let size = a.iter().map(|z| z.norm()).fold(f64::MIN_POSITIVE, f64::max);
    let nearest = |z: &Complex| {
        b.iter()
            .map(|x| (x - z).norm())
            .fold(f64::INFINITY, f64::min)
    };
    a.iter().map(nearest).fold(0.0, f64::max) / size
}

fn in_order(a: &[Complex], b: &[Complex]) -> f64 {
    let size = a.iter().map(|z| z.norm()).fold(f64::MIN_POSITIVE, f64::max);
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).norm())
        .fold(0.0, f64::max)
        / size
}

/// Response, zeros, gain, coefficients and residues as scipy.signal has them; sampled responses as its cont2discrete.
/// Source: SciPy 1.17.1 (tools/transfer.py).
#[test]
fn ref_scipy() {
    for case in reference()["cases"].as_array().unwrap() {
        let name = case["name"].as_str().unwrap();
        let direct = DirectTerms {
            constant: case["constant"].as_f64().unwrap(),
            ..DirectTerms::default()
        };
        let h = TransferFunction::new(unpack(&case["poles"]), unpack(&case["residues"]), direct)
            .unwrap();
        let numbers = |v: &serde_json::Value| -> Vec<f64> {
            v.as_array()
                .unwrap()
                .iter()
                .map(|x| x.as_f64().unwrap())
                .collect()
        };
        let at = numbers(&case["lines_hz"]);
        let off = in_order(&unpack(&case["response"]), &h.response(&at));
        within("responses", off, 1e-12);
        let zeros = h.zeros().unwrap();
        within("zeros", apart(&unpack(&case["zeros"]), &zeros.zeros), 1e-11);
        let gain = zeros.gain / case["gain"].as_f64().unwrap();
        within("gain", (gain - 1.0).abs(), 1e-11);
        let polynomials = h.polynomials().unwrap();
        assert!(
            polynomials.error < 1e-12 && polynomials.warning().is_none(),
            "{name}"
        );
        for (own, theirs) in [
            (&polynomials.numerator, "numerator"),
            (&polynomials.denominator, "denominator"),
        ] {
            let theirs = numbers(&case[theirs]);
            assert_eq!(own.len(), theirs.len(), "{name}");
            for (a, b) in own.iter().zip(&theirs).filter(|(a, b)| a != b) {
                within("coefficients", (a - b).abs() / b.abs(), 1e-11);
            }
        }
        let own: Vec<Complex> = h.poles_with_conjugates().iter().map(|t| t.1).collect();
        within(
            "residues",
            apart(&unpack(&case["residue_residues"]), &own),
            1e-10,
        );
        let form = Realisation::from_transfer_functions(&[h]).unwrap();
        for (method, map) in [
            ("zoh", DiscretisationMethod::ZeroOrderHold),
            ("bilinear", DiscretisationMethod::Bilinear),
            ("impulse", DiscretisationMethod::ImpulseInvariant),
        ] {
            if case["sampled"][method].is_null() {
                assert_eq!(form.discretise(0.05, map).unwrap_err().code, Code::Conflict);
                continue;
            }
            let sampled = form
                .discretise(case["step_s"].as_f64().unwrap(), map)
                .unwrap();
            let own: Vec<Complex> = at
                .iter()
                .map(|&f| sampled.response(f).unwrap()[(0, 0)])
                .collect();
            let theirs = &case["sampled"][method];
            let off = in_order(&unpack(&theirs["response"]), &own);
            within(&format!("sampled responses, {method}"), off, 1e-11);
            let poles = eigen::eigen(&sampled.a).unwrap().values;
            let off = apart(&unpack(&theirs["poles"]), &poles);
            within(&format!("sampled poles, {method}"), off, 1e-10);
        }
    }
}

/// Two inputs, three outputs, shapes of rank one, rigid bodies, dead time: two states a mode, two an input; responses agree.
#[test]
fn law_state_space_is_poles_and_residues() {
    let (poles, shapes) = system(6, 5, 11);
    let mut functions = Vec::new();
    for (j, input) in ["hammer", "shaker"].into_iter().enumerate() {
        for (i, output) in ["a", "b", "c"].into_iter().enumerate() {
            let residues = (0..6).map(|k| shapes[i][k] * shapes[3 + j][k]).collect();
            let direct = DirectTerms {
                constant: 0.3,
                inverse: 2.0,
                inverse_square: 40.0 + i as f64,
                ..DirectTerms::default()
            };
            let h = TransferFunction::new(poles.clone(), residues, direct).unwrap();
            functions.push(
                h.with_labels(Some(named(input)), named(output))
                    .with_delay(1e-4)
                    .unwrap(),
            );
        }
    }
    let form = Realisation::from_transfer_functions(&functions).unwrap();
    assert_eq!(
        (form.a.nrows(), form.b.ncols(), form.c.nrows()),
        (2 * 6 + 2 * 2, 2, 3)
    );
    for f in [3.0, 33.3, 210.0, 480.0] {
        let response = form.response(f).unwrap();
        for (at, h) in functions.iter().enumerate() {
            let exact = h.response(&[f])[0];
            let found = response[(at % 3, at / 3)];
            assert!(
                (found - exact).norm() < 1e-12 * exact.norm().max(1.0),
                "{f} Hz: {found} {exact}"
            );
        }
    }
    let h = 5e-4;
    let sampled = form
        .discretise(h, DiscretisationMethod::ZeroOrderHold)
        .unwrap();
    let found = eigen::eigen(&sampled.a).unwrap().values;
    for p in &poles {
        let exact = (p * h).exp();
        assert!(
            found.iter().any(|z| (z - exact).norm() < 1e-12),
            "{exact} {found:?}"
        );
    }
    // Prewarped, the response is exact at its frequency.
    let warped = form
        .discretise(h, DiscretisationMethod::Prewarped(120.0))
        .unwrap();
    let exact = functions[0].response(&[120.0])[0];
    assert!((warped.response(120.0).unwrap()[(0, 0)] - exact).norm() < 1e-11 * exact.norm());
}

/// `(s − z)…/(s − p)…` with known zeros, also more of them than poles: E s and Q s².
#[test]
fn exact_zeros() {
    // s² (s + 5)/((s + 1)(s + 2)) = s + 2 + 4/(s + 1) − 12/(s + 2).
    let (r1, r2) = (4.0, -12.0);
    let direct = DirectTerms {
        slope: 1.0,
        constant: 2.0,
        ..DirectTerms::default()
    };
    let h = TransferFunction::new(
        vec![c(-1.0, 0.0), c(-2.0, 0.0)],
        vec![c(r1, 0.0), c(r2, 0.0)],
        direct,
    )
    .unwrap();
    let found = h.zeros().unwrap();
    assert_eq!((found.zeros.len(), found.gain), (3, 1.0));
    assert!((found.zeros[2] - c(-5.0, 0.0)).norm() < 1e-13, "{found:?}");
    assert!(
        found.zeros[1].norm() < 1e-7,
        "a double zero at 0 keeps half the digits: {found:?}"
    );
    let cases = h.polynomials().unwrap();
    assert!(cases.error < 1e-13, "{cases:?}");
    // Two free masses: 1/s² and a mode; the antiresonance is known. L = 1/3, R/(s² + w²) with R = 1/6: zero at s² = −L w²/(L + R).
    let w = 50.0;
    let direct = DirectTerms {
        inverse_square: 1.0 / 3.0,
        ..DirectTerms::default()
    };
    let h = TransferFunction::new(vec![c(0.0, w)], vec![c(0.0, -1.0 / 12.0 / w)], direct).unwrap();
    let found = h.zeros().unwrap();
    assert!(
        (found.gain - 0.5).abs() < 1e-14 && found.zeros.len() == 2,
        "{found:?}"
    );
    assert!(
        (found.zeros[0] - c(0.0, w * (2.0_f64 / 3.0).sqrt())).norm() < 1e-12 * w,
        "{found:?}"
    );
}

/// Forty modes: the polynomials say that they have lost the function.
#[test]
fn survives_high_degree() {
    let (poles, residues) = system(40, 1, 3);
    let h = TransferFunction::new(poles, residues[0].clone(), DirectTerms::default()).unwrap();
    let zeros = h.zeros().unwrap();
    assert_eq!(zeros.zeros.len(), 79);
    for s in [c(0.0, 700.0), c(10.0, 2500.0)] {
        // Logarithms, since the products leave the range.
        let log = |list: &[Complex]| {
            list.iter()
                .map(|z| (s - z).ln())
                .fold(Complex::ZERO, |a, b| a + b)
        };
        let complete: Vec<Complex> = h.poles_with_conjugates().iter().map(|t| t.0).collect();
        let product = (log(&zeros.zeros) - log(&complete)).exp() * zeros.gain;
        assert!(
            (product / h.value(s) - 1.0).norm() < 1e-9,
            "{}",
            (product / h.value(s) - 1.0).norm()
        );
    }
    let polynomials = h.polynomials().unwrap();
    assert!(polynomials.warning().is_some(), "{}", polynomials.error);
    assert!(h.to_json().unwrap()["numerator"].is_array());
}

/// scipy loads the file; its responses of A, B, C, D and of num, den are ours.
/// Source: SciPy, loadmat and signal.
#[test]
fn ref_scipy_loads_the_mat_file() {
    let (poles, residues) = system(3, 2, 9);
    let direct = DirectTerms {
        constant: 0.1,
        ..DirectTerms::default()
    };
    let one = |(name, list): (&str, &Vec<Complex>)| {
        let h = TransferFunction::new(poles.clone(), list.clone(), direct).unwrap();
        h.with_labels(Some(named("hammer")), named(name))
    };
    let functions: Vec<TransferFunction> = ["left", "right"]
        .into_iter()
        .zip(&residues)
        .map(one)
        .collect();
    let form = Realisation::from_transfer_functions(&functions).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.mat");
    std::fs::write(&path, export::to_mat(&functions, &form).unwrap()).unwrap();
    let script = r#"
import sys, json
try:
    import numpy as np
    from scipy import io, signal
except ImportError:
    sys.exit(77)
m = io.loadmat(sys.argv[1])
w = 2 * np.pi * np.array([30.0, 200.0, 410.0])
out = []
for q in range(2):
    state = [(m["C"][q] @ np.linalg.solve(1j * x * np.eye(len(m["A"])) - m["A"], m["B"][:, 0]) + m["D"][q, 0]) for x in w]
    ratio = signal.freqs(m["num"][q], m["den"][0], w)[1]
    parts = [(m["residues"][:, q] / (1j * x - m["poles"][:, 0])).sum() + m["D"][q, 0] for x in w]
    out += [[[z.real, z.imag] for z in v] for v in (state, ratio, parts)]
assert m["outputs"][1][0][0] == "right" and m["Ts"][0][0] == 0
print(json.dumps(out))
"#;
    let Ok(run) = std::process::Command::new("python3")
        .arg("-c")
        .arg(script)
        .arg(&path)
        .output()
    else {
        return; // no Python on this computer
    };
    if run.status.code() == Some(77) {
        return;
    }
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    let out: serde_json::Value = serde_json::from_slice(&run.stdout).unwrap();
    for q in 0..2 {
        let own = functions[q].response(&[30.0, 200.0, 410.0]);
        for kind in 0..3 {
            let theirs = unpack(&out[3 * q + kind]);
            assert!(
                in_order(&own, &theirs) < 1e-11,
                "{q} {kind}: {}",
                in_order(&own, &theirs)
            );
        }
    }
    let mut table = Vec::new();
    export::write_csv(&functions, &mut table).unwrap();
    assert_eq!(
        String::from_utf8(table).unwrap().lines().count(),
        1 + 2 * (6 + 1)
    );
}

/// Every method gives back a system of 10 and of 40 poles from its own noise-free responses.
#[test]
fn exact_recovery() {
    for (modes, sensors, count) in [(5, 2, 201), (20, 4, 601)] {
        let (poles, residues) = system(modes, sensors, 21);
        let at = lines(count);
        let data = responses(&poles, &residues, 0.2, &at);
        let options = CommonPoleOptions::default();
        let fits = [
            (
                "vector fitting",
                vector_fit(&at, &data, None, InitialPoles::Order(2 * modes), options).unwrap(),
            ),
            ("levy", levy(&at, &data, None, 2 * modes, options).unwrap()),
            ("aaa", aaa(&at, &data, 2 * modes, options).unwrap()),
        ];
        for (name, found) in fits {
            let error = worst(&poles, &found);
            println!(
                "{name}, {} poles: {error:.1e}, fit {:.1e}, {} iterations",
                2 * modes,
                found.errors[0],
                found.iterations
            );
            within(&format!("poles by {name}"), error, 1e-10);
            assert!(
                found.errors.iter().all(|&e| e < 1e-10),
                "{name} {:?}",
                found.errors
            );
            assert_eq!(found.order(), 2 * modes, "{name}");
        }
    }
}

/// With noise of known variance, the scatter of the poles against the Cramér–Rao bound of the same experiment.
#[test]
fn law_scatter_near_the_bound() {
    let (poles, residues) = system(3, 3, 5);
    let at = lines(301);
    let clean = responses(&poles, &residues, 0.2, &at);
    let size = clean.iter().flatten().map(|z| z.norm()).fold(0.0, f64::max);
    let sigma = 0.002 * size; // of the real and of the imaginary part
    let bound = bound(&poles, &residues, &at, sigma);
    let weights = vec![vec![1.0 / sigma; at.len()]; 3];
    let mut rng = fastrand::Rng::with_seed(77);
    let runs = 40;
    let mut squares = [[0.0; 3]; 2];
    for _ in 0..runs {
        let mut noisy = |z: &Complex| {
            let (r, phase) = (
                (-2.0 * (1.0 - rng.f64()).ln()).sqrt() * sigma,
                TAU * rng.f64(),
            );
            z + c(r * phase.cos(), r * phase.sin())
        };
        let data: Vec<Vec<Complex>> = clean
            .iter()
            .map(|list| list.iter().map(&mut noisy).collect())
            .collect();
        let fits = [
            vector_fit(
                &at,
                &data,
                Some(&weights),
                InitialPoles::Order(6),
                CommonPoleOptions::default(),
            )
            .unwrap(),
            levy(&at, &data, Some(&weights), 6, CommonPoleOptions::default()).unwrap(),
        ];
        for (own, fit) in squares.iter_mut().zip(&fits) {
            for (sum, p) in own.iter_mut().zip(&poles) {
                let nearest = fit
                    .poles
                    .iter()
                    .map(|f| (f - p).norm_sqr())
                    .fold(f64::INFINITY, f64::min);
                *sum += nearest / f64::from(runs);
            }
        }
    }
    for (name, own) in ["vector fitting", "levy"].into_iter().zip(squares) {
        for (k, square) in own.into_iter().enumerate() {
            let ratio = square.sqrt() / bound[k];
            println!("{name}, pole {k}: rms error {ratio:.2} × bound");
            assert!(ratio > 0.6 && ratio < 4.0, "{name} {k}: {ratio}");
        }
    }
}

/// `√(E|p̂ − p|²)` at least, from the inverse of the information matrix over all real unknowns.
fn bound(poles: &[Complex], residues: &[Vec<Complex>], at: &[f64], sigma: f64) -> Vec<f64> {
    let (n, sensors) = (poles.len(), residues.len());
    let unknowns = 2 * n + sensors * (2 * n + 1);
    let mut information = geardyn::internals::numeric::Matrix::zeros(unknowns, unknowns);
    let size = poles[0].norm();
    for (q, list) in residues.iter().enumerate() {
        for &f in at {
            let s = c(0.0, TAU * f);
            let mut row = vec![Complex::ZERO; unknowns];
            for (k, (&p, &r)) in poles.iter().zip(list).enumerate() {
                let (own, twin) = ((s - p).inv(), (s - p.conj()).inv());
                let (a, b) = (r * own * own * size, r.conj() * twin * twin * size);
                (row[2 * k], row[2 * k + 1]) = (a + b, c(0.0, 1.0) * (a - b));
                let at = 2 * n + q * (2 * n + 1) + 2 * k;
                (row[at], row[at + 1]) = ((own + twin) * size, c(0.0, 1.0) * (own - twin) * size);
            }
            row[2 * n + q * (2 * n + 1) + 2 * n] = Complex::ONE;
            for i in 0..unknowns {
                for j in 0..unknowns {
                    information[(i, j)] += (row[i].conj() * row[j]).re / (sigma * sigma);
                }
            }
        }
    }
    let identity = geardyn::internals::numeric::Matrix::identity(unknowns, unknowns);
    let covariance =
        geardyn::internals::numeric::symmetric::lu_solve(&information, &identity).unwrap();
    (0..n)
        .map(|k| size * (covariance[(2 * k, 2 * k)] + covariance[(2 * k + 1, 2 * k + 1)]).sqrt())
        .collect()
}

/// What cannot be fitted is refused by name.
#[test]
fn refuses_bad_input() {
    let (poles, residues) = system(2, 1, 1);
    let at = lines(50);
    let data = responses(&poles, &residues, 0.0, &at);
    let options = CommonPoleOptions::default();
    let codes = |at: &[f64], data: &[Vec<Complex>], order: usize| {
        [
            vector_fit(at, data, None, InitialPoles::Order(order), options).unwrap_err(),
            levy(at, data, None, order, options).unwrap_err(),
            aaa(at, data, order, options).unwrap_err(),
        ]
        .map(|e| {
            assert!(e.hint.is_some(), "{e}");
            e.code
        })
    };
    assert_eq!(codes(&at, &data, 0), [Code::OutOfRange; 3]);
    assert_eq!(codes(&at, &[], 4), [Code::NoSignal; 3]);
    assert_eq!(
        codes(&at, &[vec![Complex::ZERO; 50]], 4),
        [Code::NoSignal; 3]
    );
    assert_eq!(
        codes(&at[..3], &[data[0][..3].to_vec()], 4),
        [Code::IllPosed; 3]
    );
    assert_eq!(codes(&[], &[vec![]], 4), [Code::TooShort; 3]);
    assert_eq!(codes(&at[..3], &data, 4), [Code::Conflict; 3]);
    let mut broken = data.clone();
    broken[0][7].im = f64::NAN;
    assert_eq!(codes(&at, &broken, 4), [Code::NotANumber; 3]);
    let mut back = at.clone();
    back[3] = back[2];
    assert_eq!(codes(&back, &data, 4), [Code::OutOfRange; 3]);
    let weights = vec![vec![-1.0; 50]];
    let wrong =
        vector_fit(&at, &data, Some(&weights), InitialPoles::Order(4), options).unwrap_err();
    assert_eq!(wrong.code, Code::OutOfRange);
    let wrong = vector_fit(
        &at,
        &data,
        None,
        InitialPoles::Poles(&[c(-1.0, -3.0)]),
        options,
    )
    .unwrap_err();
    assert_eq!(wrong.code, Code::OutOfRange);
}

/// Weights of nil, an order above what the data hold, a response that is zero beside one that is not: an answer or an error, no panic.
#[test]
fn survives_odd_requests() {
    let (poles, residues) = system(2, 2, 1);
    let at = lines(60);
    let mut data = responses(&poles, &residues, 0.0, &at);
    data[1].fill(Complex::ZERO);
    let options = CommonPoleOptions::default();
    for order in [1, 3, 4, 7, 20] {
        let all = [
            vector_fit(&at, &data, None, InitialPoles::Order(order), options),
            levy(&at, &data, None, order, options),
            aaa(&at, &data, order, options),
        ];
        for found in all.into_iter().flatten() {
            assert!(
                found.order() <= order + 1 && found.poles.iter().all(|p| p.re <= 0.0),
                "{order} {:?}",
                found.poles
            );
        }
    }
    let nil = vec![vec![0.0; 60]; 2];
    assert!(vector_fit(&at, &data, Some(&nil), InitialPoles::Order(4), options).is_err());
    assert!(levy(&at, &data, Some(&nil), 4, options).is_err());
}

/// 50 responses, 40 poles, 1001 lines with noise: seconds of ten iterations.
#[test]
#[ignore = "study: speed of vector fitting, printed"]
fn law_speed() {
    let (poles, residues) = system(20, 50, 4);
    let at = lines(1001);
    let mut data = responses(&poles, &residues, 0.1, &at);
    let mut rng = fastrand::Rng::with_seed(8);
    let size = data.iter().flatten().map(|z| z.norm()).fold(0.0, f64::max);
    let mut noise = || 1e-4 * size * (rng.f64() - 0.5);
    data.iter_mut()
        .flatten()
        .for_each(|z| *z += c(noise(), noise()));
    let options = CommonPoleOptions {
        iterations: 10,
        ..CommonPoleOptions::default()
    };
    let start = std::time::Instant::now();
    let found = vector_fit(&at, &data, None, InitialPoles::Order(40), options).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "{seconds:.3} s, {} iterations, poles off by {:.1e}",
        found.iterations,
        worst(&poles, &found)
    );
}

/// An accelerance with a stiff residual, integrated twice: the receptance at every frequency, and a state space that holds it.
#[test]
fn exact_integrated_accelerance() {
    let poles = vec![c(-3.0, 120.0), c(-8.0, 410.0)];
    let r = [c(0.02, -0.7), c(-0.01, 0.3)];
    let (lower, upper) = (0.4, 2e-6);
    let both = |f: &dyn Fn(usize) -> Complex| (0..2).map(|k| 2.0 * f(k).re).sum::<f64>();
    let direct = DirectTerms {
        constant: lower + both(&|k| poles[k] * r[k]),
        slope: both(&|k| r[k]),
        square: upper,
        ..DirectTerms::default()
    };
    let residues = (0..2).map(|k| poles[k] * poles[k] * r[k]).collect();
    let accelerance = TransferFunction::new(poles.clone(), residues, direct).unwrap();
    assert!(
        accelerance.is_improper()
            && Realisation::from_transfer_functions(std::slice::from_ref(&accelerance)).is_err()
    );
    let receptance = accelerance.integrated().unwrap().integrated().unwrap();
    assert!(!receptance.is_improper());
    let model = Realisation::from_transfer_functions(std::slice::from_ref(&receptance)).unwrap();
    for f in [3.0, 19.0, 66.0, 400.0] {
        let s = c(0.0, TAU * f);
        let expected = accelerance.value(s) / (s * s);
        assert!((receptance.value(s) - expected).norm() < 1e-9 * expected.norm());
        let held = model.response(f).unwrap()[(0, 0)];
        assert!((held - expected).norm() < 1e-9 * expected.norm());
    }
}
