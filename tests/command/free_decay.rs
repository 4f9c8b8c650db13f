//! Modes of free decays: sums of damped sinusoids with known poles, and records that ring down after a release.

use std::f64::consts::TAU;

use geardyn::internals::identify::free_decay::fit;
use geardyn::internals::identify::rational::{RationalFit, RationalOptions};

use crate::support::command::{document, put, refusal, said};
use crate::support::noise::normal;

const RATE: f64 = 100.0;

/// Component of a shape at a channel.
fn shape(mode: usize, channel: usize) -> f64 {
    ((mode + 1) as f64 * (channel + 1) as f64 * 0.7).sin()
}

/// Displacements by channel, t seconds after the release of decay `d`: `Σ φ exp(−ζωt) cos(ω_d t + phase)`.
fn decay(modes: &[(f64, f64)], channels: usize, samples: usize, d: usize) -> Vec<Vec<f64>> {
    let sample = |t: f64, c: usize| -> f64 {
        let one = |(m, (f, zeta)): (usize, &(f64, f64))| {
            let w = TAU * f;
            let phase = w * (1.0 - zeta * zeta).sqrt() * t + 1.3 * (d + m) as f64;
            shape(m, c) * (-zeta * w * t).exp() * phase.cos()
        };
        modes.iter().enumerate().map(one).sum()
    };
    (0..channels)
        .map(|c| (0..samples).map(|n| sample(n as f64 / RATE, c)).collect())
        .collect()
}

fn fitted(decays: &[Vec<Vec<f64>>]) -> RationalFit {
    let views: Vec<Vec<&[f64]>> = (decays.iter())
        .map(|d| d.iter().map(Vec::as_slice).collect())
        .collect();
    fit(RATE, &views, &RationalOptions::default()).unwrap()
}

/// Two modes at three channels in two decays, cut off long before they have decayed, one of them at a third of the rate: poles and
/// shapes to rounding.
#[test]
fn exact_damped_sinusoids() {
    let modes = [(4.0, 0.01), (33.0, 0.004)];
    let found = fitted(&[decay(&modes, 3, 480, 0), decay(&modes, 3, 480, 1)]);
    assert_eq!(found.modes.len(), 2);
    for (m, (mode, (f, zeta))) in found.modes.iter().zip(modes).enumerate() {
        assert!((mode.frequency_hz() / f - 1.0).abs() < 1e-9, "{mode:?}");
        assert!((mode.damping_ratio() - zeta).abs() < 1e-9, "{mode:?}");
        for (d, c) in (0..2).flat_map(|d| (1..3).map(move |c| (d, c))) {
            let ratio = mode.shape[2 * c + d] / mode.shape[d];
            assert!((ratio - shape(m, c) / shape(m, 0)).norm() < 1e-6);
        }
    }
}

/// Three modes, a pair 5 % apart among them, at two channels with noise of 5 % of the motion: the 95 % intervals of frequency and
/// damping hold the truth in 91 to 99 % of 150 records (450 estimates each), and no other mode is found.
#[test]
fn law_intervals_of_free_decays() {
    let modes = [(5.0, 0.012), (12.0, 0.008), (12.6, 0.01)];
    let clean = decay(&modes, 2, 1024, 0);
    let (mut frequencies, mut dampings, mut all, mut other) = (0, 0, 0, 0);
    for seed in 0..150u64 {
        let mut rng = fastrand::Rng::with_seed(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
        let noisy = |y: &Vec<f64>| y.iter().map(|y| y + 0.02 * normal(&mut rng)).collect();
        let found = fitted(&[clean.iter().map(noisy).collect()]);
        other += found.modes.len().abs_diff(modes.len());
        for (f, zeta) in modes {
            let off = |m: &f64| (m - f).abs();
            let near = (found.modes.iter())
                .min_by(|a, b| off(&a.frequency_hz()).total_cmp(&off(&b.frequency_hz())));
            let mode = near.unwrap();
            let within = |x: f64, std: Option<f64>| x.abs() < 1.96 * std.unwrap();
            all += 1;
            frequencies += usize::from(within(mode.frequency_hz() - f, mode.frequency_std_hz()));
            dampings += usize::from(within(mode.damping_ratio() - zeta, mode.damping_std()));
        }
    }
    let share = |n: usize| n as f64 / f64::from(all);
    println!("{} {} {other}", share(frequencies), share(dampings));
    assert!(
        (0.91..=0.99).contains(&share(frequencies)),
        "{frequencies} of {all}"
    );
    assert!(
        (0.91..=0.99).contains(&share(dampings)),
        "{dampings} of {all}"
    );
    assert!(other <= 3, "{other} modes too many or too few");
}

/// A beam that is held, released after 2 s and rings down: taken as a free decay without a flag, in two files as two decays, with the
/// modes within five standard deviations; noise is not.
#[test]
fn exact_release_of_a_beam() {
    let modes = [(5.0, 0.012), (12.0, 0.008)];
    let folder = tempfile::tempdir().unwrap();
    let mut rng = fastrand::Rng::with_seed(9);
    let mut write = |name: &str, d: usize| {
        let motion = decay(&modes, 2, 4000, d);
        let mut text = String::from("time [s],a [mm],b [mm]\n");
        for n in 0..4200 {
            // Held where it is released, with the noise of the sensor.
            let y = motion
                .iter()
                .map(|y| y[n.max(200) - 200] + 0.3 + 1e-3 * normal(&mut rng));
            let [a, b] = y.collect::<Vec<f64>>()[..] else {
                unreachable!()
            };
            text += &format!("{:.2},{a:.7},{b:.7}\n", n as f64 / RATE);
        }
        put(folder.path(), name, &text).display().to_string()
    };
    let (one, two) = (write("one.csv", 0), write("two.csv", 1));
    let what = ["--output", "a,b", "--json"];
    for files in [vec!["identify", &one], vec!["identify", &one, &two]] {
        let found = document(&[&files[..], &what].concat());
        assert_eq!(found["method"], "free-decay");
        let all = found["modes"].as_array().unwrap();
        assert_eq!(all.len(), 2, "{all:?}");
        for (mode, (f, zeta)) in all.iter().zip(modes) {
            let value = |key: &str| mode[key].as_f64().unwrap();
            assert!(
                (value("frequency_hz") - f).abs() < 5.0 * value("frequency_std_hz"),
                "{mode}"
            );
            assert!(
                (value("damping_ratio") - zeta).abs() < 5.0 * value("damping_std"),
                "{mode}"
            );
            assert!(value("frequency_std_hz") < 1e-3 * f, "{mode}");
        }
    }
    let mut text = String::from("time [s],a [mm],b [mm]\n");
    for n in 0..4200 {
        text += &format!(
            "{:.2},{:.7},{:.7}\n",
            n as f64 / RATE,
            normal(&mut rng),
            normal(&mut rng)
        );
    }
    let path = put(folder.path(), "noise.csv", &text).display().to_string();
    let found = document(&["identify", &path, "--output", "a,b", "--json"]);
    assert_eq!(found["method"], "ssi-cov");
}

/// Two releases and a record of noise, in any order: the file that does not ring down is named and nothing is identified; with the method
/// stated as well, and another method names the file that it takes.
#[test]
fn refuses_a_file_that_does_not_ring_down() {
    let modes = [(5.0, 0.012), (12.0, 0.008)];
    let folder = tempfile::tempdir().unwrap();
    let mut rng = fastrand::Rng::with_seed(19);
    let mut write = |name: &str, d: Option<usize>| {
        let motion = decay(&modes, 2, 4000, d.unwrap_or(0));
        let mut text = String::from("time [s],a [mm],b [mm]\n");
        for n in 0..4200 {
            let mut y = |c: usize| match d {
                Some(_) => motion[c][n.max(200) - 200] + 0.3 + 1e-3 * normal(&mut rng),
                None => 0.3 * normal(&mut rng),
            };
            text += &format!("{:.2},{:.7},{:.7}\n", n as f64 / RATE, y(0), y(1));
        }
        put(folder.path(), name, &text).display().to_string()
    };
    let (one, two) = (write("one.csv", Some(0)), write("two.csv", Some(1)));
    let noise = write("noise.csv", None);
    for files in [[&one, &noise, &two], [&one, &two, &noise]] {
        let files = files.map(String::as_str);
        let call = [&["identify"], &files[..], &["--output", "a,b"]].concat();
        let (code, message) = refusal(&call);
        assert_eq!(code, "conflict", "{message}");
        assert!(
            message.contains("noise.csv` does not ring down"),
            "{message}"
        );
        let stated = [&call[..], &["--method", "free-decay"]].concat();
        let (code, _, message) = said(&stated);
        assert_eq!(code, Some(2), "{message}");
        assert!(
            message.contains("noise.csv") && message.contains("no free decay"),
            "{message}"
        );
        let ambient = [&call[..], &["--method", "ssi-cov", "--json"]].concat();
        let found = document(&ambient);
        let all = found["warnings"].as_array().unwrap();
        let one = all.iter().find(|w| w["code"] == "one-segment").unwrap();
        assert!(one["message"].as_str().unwrap().contains(".csv"), "{one}");
    }
}
