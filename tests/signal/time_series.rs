//! Difference equations fitted to samples: known processes, another program's answers, and bad records.

use std::f64::consts::TAU;

use crate::support::verification::{coverage, within};
use geardyn::internals::base::code::Code;
use geardyn::internals::identify::series::autoregressive::{self, ArMethod};
use geardyn::internals::identify::series::io_data::InputOutputData;
use geardyn::internals::identify::series::model::{ModelStructure, PolynomialModel};
use geardyn::internals::identify::series::model_trajectory::{mode_tracks, track_model};
use geardyn::internals::identify::series::order::{self, OrderCriterion};
use geardyn::internals::identify::series::prediction_error;
use geardyn::internals::identify::series::recursive::{RecursiveLeastSquares, RecursiveOptions};
use geardyn::internals::identify::series::residuals;
use serde_json::Value;

/// Standard normal numbers (Box & Muller).
fn noise(rng: &mut fastrand::Rng, n: usize) -> Vec<f64> {
    let one =
        |rng: &mut fastrand::Rng| (-2.0 * (1.0 - rng.f64()).ln()).sqrt() * (TAU * rng.f64()).cos();
    (0..n).map(|_| one(rng)).collect()
}

/// `A y = B u + C e` from rest; the first 500 samples are thrown away by the caller where it matters.
fn simulate(a: &[f64], b: &[f64], delay: usize, u: &[f64], c: &[f64], e: &[f64]) -> Vec<f64> {
    let mut y = vec![0.0; e.len()];
    let past = |x: &[f64], t: usize, lag: usize| t.checked_sub(lag).map_or(0.0, |at| x[at]);
    for t in 0..e.len() {
        let mut sum = e[t];
        for (k, a) in a.iter().enumerate() {
            sum -= a * past(&y, t, k + 1);
        }
        for (j, b) in b.iter().enumerate() {
            sum += b * past(u, t, delay + j);
        }
        for (k, c) in c.iter().enumerate() {
            sum += c * past(e, t, k + 1);
        }
        y[t] = sum;
    }
    y
}

fn reference() -> Value {
    let path = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/data/reference/time_series.json"
    );
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn list(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|x| x.as_f64().unwrap())
        .collect()
}

fn assert_near(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    let gaps = found.iter().zip(expected).map(|(f, x)| (f - x).abs());
    within(
        "coefficients, absolute",
        gaps.fold(0.0, f64::max),
        tolerance,
    );
}

/// AR(4) by three methods: coefficients and variances to rounding of the recursions.
/// Source: statsmodels 0.15.0 (tools/reference_time_series.py).
#[test]
fn ref_statsmodels_autoregressive() {
    let reference = reference();
    let y = list(&reference["y"]);
    let record = InputOutputData::new(&y, 1.0).unwrap();
    let fit = |method| autoregressive::fit(&record, 4, method).unwrap();
    for (method, name) in [
        (ArMethod::Burg, "burg"),
        (ArMethod::YuleWalker, "yule_walker"),
    ] {
        let model = fit(method);
        assert_near(&model.a, &list(&reference[name]["a"]), 1e-9);
        let variance = reference[name]["variance"].as_f64().unwrap();
        // another program may divide by another count of samples
        assert!(
            (model.noise_variance / variance - 1.0).abs() < 0.02,
            "{name}"
        );
    }
    let model = fit(ArMethod::LeastSquares);
    assert_near(&model.a, &list(&reference["least_squares"]["a"]), 1e-9);
    for (std, expected) in model
        .std()
        .iter()
        .zip(list(&reference["least_squares"]["std"]))
    {
        assert!((std / expected - 1.0).abs() < 0.01);
    }
}

/// ARMA(2, 1): the same sum of squares minimised by another program agrees to its tolerance; exact likelihood, which knows more of the
/// first samples, is a quarter of a standard deviation away; deviations within 5 %.
/// Source: statsmodels 0.15.0 (tools/reference_time_series.py).
#[test]
fn ref_statsmodels_arma() {
    let reference = &reference();
    let y = list(&reference["y"]);
    let record = InputOutputData::new(&y, 1.0).unwrap();
    let model = prediction_error::fit(&record, ModelStructure::Arma { a: 2, c: 1 }).unwrap();
    let expected = [list(&reference["arma"]["a"]), list(&reference["arma"]["c"])].concat();
    let found = [model.a.clone(), model.c.clone()].concat();
    let std = list(&reference["arma"]["std"]);
    assert_near(&found, &list(&reference["arma_conditional"]["theta"]), 1e-6);
    for k in 0..3 {
        assert!(
            (found[k] - expected[k]).abs() < 0.3 * std[k],
            "{found:?} {expected:?}"
        );
        assert!(
            (model.std()[k] / std[k] - 1.0).abs() < 0.05,
            "{:?} {std:?}",
            model.std()
        );
    }
    assert!((model.noise_variance - reference["arma"]["variance"].as_f64().unwrap()).abs() < 0.01);
}

/// The statistic of Ljung and Box.
/// Source: statsmodels 0.15.0 (tools/reference_time_series.py).
#[test]
fn ref_statsmodels_ljung_box() {
    let reference = &reference();
    let y = list(&reference["y"]);
    let found = residuals::ljung_box(&y, 10, 0).unwrap();
    let expected = reference["ljung_box_10"]["statistic"].as_f64().unwrap();
    within("statistic", (found.statistic / expected - 1.0).abs(), 1e-9);
}

/// Over 60 records each, the squared errors of AR, ARMA, ARX, ARMAX and output-error coefficients in units of their own standard
/// deviations average to one, and whiteness is not denied more often than chance.
#[test]
fn law_coefficients_lie_within_their_own_deviations() {
    let (a, b, c) = ([-1.5, 0.8], [1.0, 0.5], [0.5]);
    let families = [
        ModelStructure::Ar { a: 2 },
        ModelStructure::Arma { a: 2, c: 1 },
        ModelStructure::Arx {
            a: 2,
            b: 2,
            delay: 1,
        },
        ModelStructure::Armax {
            a: 2,
            b: 2,
            c: 1,
            delay: 1,
        },
        ModelStructure::OutputError {
            b: 2,
            f: 2,
            delay: 1,
        },
    ];
    for family in families {
        let (mut square, mut count, mut denied) = (0.0, 0.0, 0);
        for seed in 0..60 {
            let mut rng = fastrand::Rng::with_seed(seed);
            let (e, u) = (noise(&mut rng, 1000), noise(&mut rng, 1000));
            let quiet = vec![0.0; 1000];
            let (y, truth): (Vec<f64>, Vec<f64>) = match family {
                ModelStructure::Ar { .. } => (simulate(&a, &[], 0, &u, &[], &e), a.to_vec()),
                ModelStructure::Arma { .. } => {
                    (simulate(&a, &[], 0, &u, &c, &e), [&a[..], &c].concat())
                }
                ModelStructure::Arx { .. } => (simulate(&a, &b, 1, &u, &[], &e), [a, b].concat()),
                ModelStructure::Armax { .. } => {
                    (simulate(&a, &b, 1, &u, &c, &e), [&a[..], &b, &c].concat())
                }
                ModelStructure::OutputError { .. } => {
                    let clean = simulate(&a, &b, 1, &u, &[], &quiet);
                    (
                        clean.iter().zip(&e).map(|(y, e)| y + e).collect(),
                        [b, a].concat(),
                    )
                }
            };
            let record = InputOutputData::new(&y, 1.0)
                .unwrap()
                .with_input(&u)
                .unwrap();
            let model = prediction_error::fit(&record, family).unwrap();
            let found = [&model.a[..], &model.b, &model.c, &model.f].concat();
            for ((f, t), s) in found.iter().zip(&truth).zip(model.std()) {
                square += ((f - t) / s).powi(2);
                count += 1.0;
            }
            let left = model.residuals(&record).unwrap();
            let fitted = model.a.len() + model.c.len();
            denied +=
                usize::from(residuals::ljung_box(&left, 25, fitted).unwrap().probability < 0.05);
        }
        // The mean of some 200 correlated χ²₁ scatters by about 0.15; 5 % of 60 is 3, more than 9 is chance once in 300.
        let mean = square / count;
        assert!((0.6..1.5).contains(&mean), "{family:?}: {mean}");
        assert!(denied <= 9, "{family:?}: {denied} of 60");
    }
}

/// Long record: all four methods agree to a part of the standard deviation; so do their standard deviations.
#[test]
fn law_methods_agree_on_long_records() {
    let mut rng = fastrand::Rng::with_seed(5);
    let e = noise(&mut rng, 50_000);
    let y = simulate(&[-1.5, 0.8, -0.1], &[], 0, &[], &[], &e);
    let record = InputOutputData::new(&y, 1.0).unwrap();
    let fit = |method| autoregressive::fit(&record, 3, method).unwrap();
    let burg = fit(ArMethod::Burg);
    for method in [
        ArMethod::YuleWalker,
        ArMethod::LeastSquares,
        ArMethod::ForwardBackward,
    ] {
        let other = fit(method);
        for k in 0..3 {
            assert!(
                (burg.a[k] - other.a[k]).abs() < 0.1 * burg.std()[k],
                "{method:?}"
            );
            assert!(
                (burg.std()[k] / other.std()[k] - 1.0).abs() < 0.01,
                "{method:?}"
            );
        }
    }
}

/// Coloured noise: ARX is wrong by many standard deviations where ARMAX is right; the residuals say so.
#[test]
fn law_armax_is_unbiased_where_arx_is_not() {
    let mut rng = fastrand::Rng::with_seed(11);
    let (e, u) = (noise(&mut rng, 5000), noise(&mut rng, 5000));
    let y = simulate(&[-1.5, 0.8], &[1.0, 0.5], 1, &u, &[0.9], &e);
    let record = InputOutputData::new(&y, 1.0)
        .unwrap()
        .with_input(&u)
        .unwrap();
    let arx = prediction_error::fit(
        &record,
        ModelStructure::Arx {
            a: 2,
            b: 2,
            delay: 1,
        },
    )
    .unwrap();
    let armax = prediction_error::fit(
        &record,
        ModelStructure::Armax {
            a: 2,
            b: 2,
            c: 1,
            delay: 1,
        },
    )
    .unwrap();
    let far = |m: &PolynomialModel| (m.a[0] + 1.5).abs() / m.std()[0];
    assert!(
        far(&arx) > 8.0 && far(&armax) < 3.5,
        "{} {}",
        far(&arx),
        far(&armax)
    );
    let white = |m: &PolynomialModel| {
        let left = m.residuals(&record).unwrap();
        residuals::ljung_box(&left, 25, m.a.len() + m.c.len())
            .unwrap()
            .probability
    };
    assert!(white(&arx) < 1e-6 && white(&armax) > 0.001);
    let left = armax.residuals(&record).unwrap();
    assert!(
        residuals::cross_correlation(&left, &u, 20)
            .unwrap()
            .probability
            > 0.001
    );
    // A delay too long leaves the input's first action unexplained.
    let late = prediction_error::fit(
        &record,
        ModelStructure::Armax {
            a: 2,
            b: 1,
            c: 1,
            delay: 2,
        },
    )
    .unwrap();
    let left = late.residuals(&record).unwrap();
    assert!(
        residuals::cross_correlation(&left, &u, 20)
            .unwrap()
            .probability
            < 1e-6
    );
}

/// The response of the fitted model is that of the true one, and predictions leave the residuals.
#[test]
fn law_response_and_predictions() {
    let mut rng = fastrand::Rng::with_seed(2);
    let u = noise(&mut rng, 2000);
    let y = simulate(&[-1.5, 0.8], &[1.0, 0.5], 1, &u, &[], &vec![0.0; 2000]);
    let offset: Vec<f64> = y.iter().map(|y| y + 7.0).collect();
    let record = InputOutputData::new(&offset, 100.0)
        .unwrap()
        .with_input(&u)
        .unwrap();
    for family in [
        ModelStructure::Arx {
            a: 2,
            b: 2,
            delay: 1,
        },
        ModelStructure::OutputError {
            b: 2,
            f: 2,
            delay: 1,
        },
    ] {
        let model = prediction_error::fit(&record, family).unwrap();
        for f in [0.0, 3.0, 9.0, 40.0] {
            let q = geardyn::internals::numeric::Complex::new(
                (TAU * f / 100.0).cos(),
                -(TAU * f / 100.0).sin(),
            );
            let exact = (q + q * q * 0.5) / (q * -1.5 + q * q * 0.8 + 1.0);
            // the mean of a finite record is not quite that of a process from rest
            assert!(
                (model.response(f) - exact).norm() < 0.02 * exact.norm(),
                "{family:?} at {f} Hz"
            );
        }
        let predicted = model.predictions(&record).unwrap();
        let left = model.residuals(&record).unwrap();
        assert!((0..2000).all(|t| (predicted[t] + left[t] - offset[t]).abs() < 1e-12));
    }
}

/// A damped oscillator driven by noise: frequency and damping within intervals that hold what they promise.
#[test]
fn law_intervals_of_frequency_and_damping_cover() {
    let (rate, f, zeta) = (100.0, 7.0, 0.02);
    let w = TAU * f;
    let radius = (-zeta * w / rate).exp();
    let angle = w * f64::sqrt(1.0 - zeta * zeta) / rate;
    let a = [-2.0 * radius * angle.cos(), radius * radius];
    let (mut hits_f, mut hits_z) = (0, 0);
    for seed in 0..2000 {
        let mut rng = fastrand::Rng::with_seed(1000 + seed);
        let e = noise(&mut rng, 4500);
        let y = &simulate(&a, &[], 0, &[], &[], &e)[500..];
        let record = InputOutputData::new(y, rate).unwrap();
        let model = autoregressive::fit(&record, 2, ArMethod::Burg).unwrap();
        let modes = model.modes().unwrap();
        assert_eq!(modes.len(), 1);
        let mode = &modes[0];
        let (sf, sz) = (
            mode.frequency_std_hz().unwrap(),
            mode.damping_std().unwrap(),
        );
        hits_f += usize::from((mode.frequency_hz() - f).abs() < 1.96 * sf);
        hits_z += usize::from((mode.damping_ratio() - zeta).abs() < 1.96 * sz);
    }
    // 1900 of 2000 expected, with a standard deviation of 10
    assert!(hits_f >= 1860 && hits_z >= 1860, "{hits_f} {hits_z}");
    coverage("frequency by an autoregressive model", 0.95, hits_f, 2000);
    coverage(
        "damping ratio by an autoregressive model",
        0.95,
        hits_z,
        2000,
    );
}

/// The density of a model integrates to the variance of the signal.
#[test]
fn law_density_integrates_to_variance() {
    let mut rng = fastrand::Rng::with_seed(3);
    let e = noise(&mut rng, 20_000);
    let y = simulate(&[-1.2, 0.6], &[], 0, &[], &[0.3], &e);
    let record = InputOutputData::new(&y, 50.0).unwrap();
    let model = prediction_error::fit(&record, ModelStructure::Arma { a: 2, c: 1 }).unwrap();
    let lines = 5000;
    let step = 25.0 / f64::from(lines);
    let integral: f64 = (0..lines)
        .map(|k| model.noise_density((f64::from(k) + 0.5) * step) * step)
        .sum();
    let variance = y.iter().map(|y| y * y).sum::<f64>() / 20_000.0;
    assert!(
        (integral / variance - 1.0).abs() < 0.03,
        "{integral} {variance}"
    );
}

/// BIC finds the order; AIC takes it or a little more; every candidate is in the evidence.
#[test]
fn law_order_is_found() {
    let mut rng = fastrand::Rng::with_seed(8);
    let (e, u) = (noise(&mut rng, 4000), noise(&mut rng, 4000));
    let y = simulate(&[-1.5, 1.2, -0.5, 0.3], &[], 0, &[], &[], &e);
    let record = InputOutputData::new(&y, 1.0).unwrap();
    let choice = order::select_ar_order(&record, 20, OrderCriterion::Bic).unwrap();
    assert_eq!(choice.family, ModelStructure::Ar { a: 4 });
    assert_eq!(choice.candidates.len(), 20);
    let y = simulate(&[-1.5, 0.8], &[1.0, 0.5], 3, &u, &[], &e);
    let record = InputOutputData::new(&y, 1.0)
        .unwrap()
        .with_input(&u)
        .unwrap();
    let mut families = Vec::new();
    for (n, delay) in (1..=3).flat_map(|n| (0..=5).map(move |d| (n, d))) {
        families.push(ModelStructure::Arx { a: n, b: n, delay });
    }
    let (model, choice) = order::select_structure(&record, &families, OrderCriterion::Bic).unwrap();
    assert_eq!(
        choice.family,
        ModelStructure::Arx {
            a: 2,
            b: 2,
            delay: 3
        }
    );
    assert_eq!(model.family, choice.family);
    assert!(choice.candidates.iter().all(|c| c.mdl == c.bic / 2.0));
}

/// A natural frequency that jumps from 5 to 8 Hz is followed within the memory; before and after, the interval holds it.
#[test]
fn law_recursion_follows_a_jump() {
    let rate = 100.0;
    let options = RecursiveOptions {
        a: 2,
        b: 0,
        delay: 0,
        forgetting: 0.995,
        rate_hz: rate,
    };
    let mut following = RecursiveLeastSquares::new(options).unwrap();
    assert_eq!(following.model().unwrap_err().code, Code::TooShort);
    let mut rng = fastrand::Rng::with_seed(4);
    let e = noise(&mut rng, 6000);
    let (mut y1, mut y2) = (0.0, 0.0);
    let mut at = Vec::new();
    for (t, e) in e.iter().enumerate() {
        let w = TAU * if t < 3000 { 5.0 } else { 8.0 } / rate;
        let r: f64 = 0.98;
        let y = 2.0 * r * w.cos() * y1 - r * r * y2 + e;
        following.push(0.0, y).unwrap();
        (y1, y2) = (y, y1);
        if [2999, 4500, 5999].contains(&t) {
            at.push(following.model().unwrap().modes().unwrap()[0].clone());
        }
    }
    for (mode, f) in at.iter().zip([5.0, 8.0, 8.0]) {
        let std = mode.frequency_std_hz().unwrap();
        assert!(
            (mode.damped_frequency_hz() - f).abs() < 3.5 * std && std < 0.3,
            "{mode:?}"
        );
    }
    assert!(following.push(0.0, f64::NAN).is_err());
}

/// A natural frequency that falls from 12 to 9 Hz, with a second that stays: both are one track each, near the truth all along, and the
/// memory taken is neither all of the record nor the shortest.
#[test]
fn law_course_of_a_process_that_changes() {
    let rate = 100.0;
    let mut rng = fastrand::Rng::with_seed(11);
    let e = noise(&mut rng, 20_000);
    let truth = |t: usize| 12.0 - 3.0 * t as f64 / 20_000.0;
    let mut past = [[0.0; 2]; 2];
    let y: Vec<f64> = (e.iter().enumerate())
        .map(|(t, e)| {
            let mut x = *e;
            // One after the other, an autoregression of order four.
            for (past, f) in past.iter_mut().zip([truth(t), 31.0]) {
                let r: f64 = 0.98;
                x += 2.0 * r * (TAU * f / rate).cos() * past[0] - r * r * past[1];
                *past = [x, past[0]];
            }
            x
        })
        .collect();
    let record = InputOutputData::new(&y, rate).unwrap();
    let course = track_model(&record, &[2, 4, 6, 8, 10], None).unwrap();
    assert_eq!(
        course.selected.family,
        ModelStructure::Ar { a: 4 },
        "{:?}",
        course.trials
    );
    assert!(
        course.selected.memory > 100.0 && course.selected.memory < 10_000.0,
        "{:?}",
        course.trials
    );
    let modes: Vec<_> = (course.instants.iter())
        .map(|i| i.1.modes().unwrap())
        .collect();
    let tracks = mode_tracks(&modes, 10);
    assert_eq!(tracks.len(), 2);
    let lag = course.selected.memory / rate;
    let mut within = 0;
    for (at, mode) in &tracks[0].points {
        // The mean over the memory is what is seen.
        let time = course.instants[*at].0;
        let seen = truth(((time - lag).max(0.0) * rate) as usize);
        let std = mode.frequency_std_hz().unwrap();
        assert!(
            (mode.damped_frequency_hz() - seen).abs() < 6.0 * std,
            "{time} {mode:?} {seen}"
        );
        within += usize::from((mode.damped_frequency_hz() - seen).abs() < 2.0 * std);
    }
    assert!(within as f64 > 0.8 * tracks[0].points.len() as f64);
    let steady = tracks[1].points.iter();
    assert!(
        steady
            .into_iter()
            .all(|(_, m)| (m.damped_frequency_hz() - 31.0).abs() < 0.5)
    );
    let short = track_model(&record, &[4], Some(30.0)).unwrap_err();
    assert_eq!(short.code, Code::TooShort, "{short}");
}

/// Nothing forgotten: the recursion ends at least squares of the whole record.
#[test]
fn exact_recursion_without_forgetting() {
    let mut rng = fastrand::Rng::with_seed(6);
    let (e, u) = (noise(&mut rng, 800), noise(&mut rng, 800));
    let y = simulate(&[-1.5, 0.8], &[1.0, 0.5], 1, &u, &[], &e);
    let options = RecursiveOptions {
        a: 2,
        b: 2,
        delay: 1,
        forgetting: 1.0,
        rate_hz: 1.0,
    };
    let mut following = RecursiveLeastSquares::new(options).unwrap();
    for (u, y) in u.iter().zip(&y) {
        following.push(*u, *y).unwrap();
    }
    assert_near(following.a(), &[-1.5, 0.8], 0.1);
    assert_near(following.b(), &[1.0, 0.5], 0.15);
    // the whole-record fit takes the means off first, which moves it by far less than a standard deviation (about 0.02)
    let record = InputOutputData::new(&y, 1.0)
        .unwrap()
        .with_input(&u)
        .unwrap();
    let whole = prediction_error::fit(
        &record,
        ModelStructure::Arx {
            a: 2,
            b: 2,
            delay: 1,
        },
    )
    .unwrap();
    assert_near(following.a(), &whole.a, 2e-3);
    assert_near(following.b(), &whole.b, 5e-3);
}

#[test]
fn refuses_what_cannot_be_fitted() {
    let code = |r: Result<PolynomialModel, geardyn::internals::base::error::Error>| {
        let error = r.unwrap_err();
        assert!(error.hint.is_some(), "{error}");
        error.code
    };
    assert_eq!(
        InputOutputData::new(&[], 1.0).unwrap_err().code,
        Code::EmptyLog
    );
    assert_eq!(
        InputOutputData::new(&[1.0, f64::NAN], 1.0)
            .unwrap_err()
            .code,
        Code::NotANumber
    );
    assert_eq!(
        InputOutputData::new(&[2.0; 50], 1.0).unwrap_err().code,
        Code::NoSignal
    );
    assert_eq!(
        InputOutputData::new(&[1.0, 2.0], 0.0).unwrap_err().code,
        Code::OutOfRange
    );
    let y: Vec<f64> = (0..30).map(|t| f64::from(t * t % 11)).collect();
    let record = InputOutputData::new(&y, 1.0).unwrap();
    assert!(record.with_input(&y[1..]).is_err());
    for method in [
        ArMethod::Burg,
        ArMethod::YuleWalker,
        ArMethod::LeastSquares,
        ArMethod::ForwardBackward,
    ] {
        assert_eq!(
            code(autoregressive::fit(&record, 0, method)),
            Code::OutOfRange
        );
        assert_eq!(
            code(autoregressive::fit(&record, 15, method)),
            Code::TooShort
        );
    }
    let fit = |family| code(prediction_error::fit(&record, family));
    assert_eq!(fit(ModelStructure::Arma { a: 0, c: 0 }), Code::OutOfRange);
    assert_eq!(
        fit(ModelStructure::Arx {
            a: 1,
            b: 1,
            delay: 0
        }),
        Code::NoSignal
    );
    assert_eq!(fit(ModelStructure::Arma { a: 14, c: 14 }), Code::TooShort);
    // an input that is one sine cannot tell six coefficients
    let u: Vec<f64> = (0..400).map(|t| (0.3 * f64::from(t)).sin()).collect();
    let y: Vec<f64> = (0..400).map(|t| (0.3 * f64::from(t) - 1.0).sin()).collect();
    let record = InputOutputData::new(&y, 1.0)
        .unwrap()
        .with_input(&u)
        .unwrap();
    assert_eq!(
        code(prediction_error::fit(
            &record,
            ModelStructure::Arx {
                a: 4,
                b: 4,
                delay: 0
            }
        )),
        Code::IllPosed
    );
    assert!(
        prediction_error::fit(
            &record,
            ModelStructure::OutputError {
                b: 4,
                f: 4,
                delay: 0
            }
        )
        .is_err()
    );
    assert!(residuals::ljung_box(&y, 3, 3).is_err());
    assert!(order::select_ar_order(&record, 0, OrderCriterion::Aic).is_err());
    assert!(order::select_structure(&record, &[], OrderCriterion::Aic).is_err());
}

/// Orders far above the process: an answer or an error, never a panic.
#[test]
fn survives_orders_too_high() {
    let mut rng = fastrand::Rng::with_seed(9);
    let (e, u) = (noise(&mut rng, 300), noise(&mut rng, 300));
    let y = simulate(&[-0.5], &[1.0], 1, &u, &[], &e);
    let record = InputOutputData::new(&y, 1.0)
        .unwrap()
        .with_input(&u)
        .unwrap();
    for family in [
        ModelStructure::Arma { a: 6, c: 6 },
        ModelStructure::Armax {
            a: 5,
            b: 5,
            c: 5,
            delay: 1,
        },
        ModelStructure::OutputError {
            b: 6,
            f: 6,
            delay: 0,
        },
    ] {
        if let Ok(model) = prediction_error::fit(&record, family) {
            assert!(model.modes().is_ok());
            assert!(model.noise_variance.is_finite());
        }
    }
}
