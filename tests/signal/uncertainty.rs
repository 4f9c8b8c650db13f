//! Intervals of identified modes against the bootstrap over averages: Efron & Tibshirani, An Introduction to the Bootstrap (1993), §6.

use std::f64::consts::TAU;

use geardyn::internals::identify::rational::{FrfData, RationalFit, RationalOptions, fit};
use geardyn::internals::numeric::Complex;
use geardyn::internals::spectrum::frf::{Estimator, estimate, required_pairs};
use geardyn::internals::spectrum::spectra::{CrossSpectrum, Spectra};

/// Natural frequencies, Hz, and damping ratios.
const TRUTH: [(f64, f64); 2] = [(60.0, 0.02), (75.0, 0.015)];

const RESPONSES: usize = 3;

/// Averages of the measurement.
const BLOCKS: usize = 40;

/// Measurements drawn from it: their deviation is known to a share of 1/√(2n), 6 %.
const DRAWN: usize = 150;

fn normal(rng: &mut fastrand::Rng) -> Complex {
    let size = (-(1.0 - rng.f64()).ln()).sqrt();
    Complex::new(0.0, TAU * rng.f64()).exp() * size
}

fn response(i: usize, f: f64) -> Complex {
    let s = Complex::new(0.0, TAU * f);
    let shapes = [[1.0, 0.5], [0.3, -1.0], [-0.6, 0.4]];
    (TRUTH.iter().zip(shapes[i]))
        .map(|(&(f0, d), a)| {
            let w = TAU * f0;
            a * w * w / (s * s + s * 2.0 * d * w + w * w)
        })
        .sum()
}

/// Averaged spectra of the blocks drawn.
fn averaged(lines: &[f64], blocks: &[Vec<Vec<Complex>>], drawn: &[usize]) -> Spectra {
    let share = 1.0 / drawn.len() as f64;
    let mean = |x: usize, y: usize| -> Vec<Complex> {
        (0..lines.len())
            .map(|k| {
                let sum: Complex = (drawn.iter())
                    .map(|&b| blocks[b][x][k].conj() * blocks[b][y][k])
                    .sum();
                sum * share
            })
            .collect()
    };
    let outputs: Vec<usize> = (1..=RESPONSES).collect();
    Spectra {
        rate_hz: 400.0,
        frequency_hz: lines.to_vec(),
        psd: (0..=RESPONSES)
            .map(|c| mean(c, c).iter().map(|z| z.re).collect())
            .collect(),
        cross: (required_pairs(&[0], &outputs).into_iter())
            .map(|pair| CrossSpectrum {
                pair,
                values: mean(pair.0, pair.1),
            })
            .collect(),
        bandwidth_hz: lines[1] - lines[0],
        blocks: drawn.len(),
        averages: Some(drawn.len() as f64),
        window_decay: 0.0,
        window: None,
    }
}

fn fitted(spectra: &Spectra) -> RationalFit {
    let outputs: Vec<usize> = (1..=RESPONSES).collect();
    let found = estimate(spectra, &[0], &outputs, Estimator::H1).unwrap();
    let values: Vec<Vec<Complex>> = found.functions.iter().map(|f| f.values.clone()).collect();
    let variance: Vec<Vec<f64>> = (found.functions.iter())
        .map(|f| f.variance.clone().unwrap())
        .collect();
    let measured = FrfData {
        frequency_hz: &found.frequency_hz,
        responses: &values,
        variance: Some(&variance),
        variance_dof: None,
        smearing_hz: 0.0,
        line_independence: 1.0,
        derivative: 0,
        hits: None,
    };
    let options = RationalOptions {
        order: Some(TRUTH.len()),
        ..RationalOptions::default()
    };
    fit(&measured, &options).unwrap()
}

/// Frequency and damping of each mode spread over measurements drawn from the averages by as much as one measurement's covariance says.
#[test]
fn law_covariance_is_that_of_the_bootstrap() {
    let lines: Vec<f64> = (0..240).map(|k| 40.0 + 0.25 * f64::from(k)).collect();
    let mut rng = fastrand::Rng::with_seed(0x5eed);
    let blocks: Vec<Vec<Vec<Complex>>> = (0..BLOCKS)
        .map(|_| {
            let force: Vec<Complex> = lines.iter().map(|_| normal(&mut rng)).collect();
            let answers = (0..RESPONSES).map(|i| {
                let noisy = |(&f, x): (&f64, &Complex)| response(i, f) * x + normal(&mut rng) * 0.5;
                lines
                    .iter()
                    .zip(&force)
                    .map(noisy)
                    .collect::<Vec<Complex>>()
            });
            let answers: Vec<_> = answers.collect();
            std::iter::once(force).chain(answers).collect()
        })
        .collect();
    let all: Vec<usize> = (0..BLOCKS).collect();
    let once = fitted(&averaged(&lines, &blocks, &all));
    assert_eq!(once.modes.len(), TRUTH.len());
    let drawn: Vec<RationalFit> = (0..DRAWN)
        .map(|_| {
            let drawn: Vec<usize> = all.iter().map(|_| rng.usize(0..BLOCKS)).collect();
            fitted(&averaged(&lines, &blocks, &drawn))
        })
        .collect();
    for (k, (mode, (f, d))) in once.modes.iter().zip(TRUTH).enumerate() {
        let stated = [
            mode.frequency_std_hz().unwrap(),
            mode.damping_std().unwrap(),
        ];
        let off = [mode.frequency_hz() - f, mode.damping_ratio() - d];
        let picks: [fn(&RationalFit, usize) -> f64; 2] = [
            |fit, k| fit.modes[k].frequency_hz(),
            |fit, k| fit.modes[k].damping_ratio(),
        ];
        for ((pick, stated), off) in picks.iter().zip(stated).zip(off) {
            let values: Vec<f64> = (drawn.iter().filter(|f| f.modes.len() == TRUTH.len()))
                .map(|f| pick(f, k))
                .collect();
            assert!(values.len() > DRAWN * 9 / 10, "{} of {DRAWN}", values.len());
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            let square: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
            let spread = (square / (values.len() - 1) as f64).sqrt();
            println!("mode {k}: stated {stated:.3e}, bootstrap {spread:.3e}, off {off:.3e}");
            assert!(
                (0.75..1.33).contains(&(spread / stated)),
                "{spread:e} {stated:e}"
            );
            assert!(off.abs() < 3.5 * stated, "{off:e} {stated:e}");
        }
    }
}
