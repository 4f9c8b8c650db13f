//! Tests of many points with a few sensors: a file for each point of a roving sensor or a roving hammer.

use std::f64::consts::{PI, TAU};
use std::fs;
use std::path::Path;

use serde_json::Value;

use crate::support::command::{document, refusal};
use crate::support::noise::normal;

const RATE: f64 = 2000.0;

/// Natural frequencies, Hz, and damping ratios.
const MODES: [(f64, f64); 3] = [(60.0, 0.02), (140.0, 0.015), (230.0, 0.01)];

/// Points along a beam on two supports.
const POINTS: usize = 5;

fn shape(mode: usize, point: usize) -> f64 {
    ((mode + 1) as f64 * PI * (point + 1) as f64 / (POINTS + 1) as f64).sin()
}

/// A force over time, N over s, and the samples of its record.
type Excitation = (Box<dyn Fn(f64) -> f64>, usize);

/// The force in the middle of the steps of a simulation, so many for a sample.
const STEPS: usize = 8;

/// Samples of a force and of the displacements at points to it at another. In each step the force is that of its middle, and the motion
/// exact: each pole `x ← z x + (z − 1)/p · u`, `y = Σ φ_o φ_i Im x/ω_d`. What this leaves is below 1e-4 of the motion.
fn response(excitation: &Excitation, at: usize, points: &[usize]) -> Vec<Vec<f64>> {
    scaled_response(excitation, at, points, 1.0)
}

/// The same of a structure whose frequencies are all `scale` times as high.
fn scaled_response(
    (force, samples): &Excitation,
    at: usize,
    points: &[usize],
    scale: f64,
) -> Vec<Vec<f64>> {
    let step = 1.0 / RATE / STEPS as f64;
    let mut states = [(0.0, 0.0); MODES.len()];
    let mut all = vec![Vec::with_capacity(*samples); points.len() + 1];
    for n in 0..samples * STEPS {
        let t = n as f64 * step;
        if n % STEPS == 0 {
            all[0].push(force(t));
            for (all, &o) in all[1..].iter_mut().zip(points) {
                let modal = |(m, (_, im)): (usize, &(f64, f64))| {
                    let (f, d) = MODES[m];
                    let b = TAU * scale * f * (1.0 - d * d).sqrt();
                    shape(m, o) * shape(m, at) * im / b
                };
                all.push(states.iter().enumerate().map(modal).sum());
            }
        }
        let u = force(t + 0.5 * step);
        for (m, (re, im)) in states.iter_mut().enumerate() {
            let (f, d) = MODES[m];
            let omega = TAU * scale * f;
            let (a, b) = (-d * omega, omega * (1.0 - d * d).sqrt());
            let size = (a * step).exp();
            let (zr, zi) = (size * (b * step).cos(), size * (b * step).sin());
            let (nr, ni, power) = (zr - 1.0, zi, a * a + b * b);
            let (gr, gi) = ((nr * a + ni * b) / power, (ni * a - nr * b) / power);
            (*re, *im) = (zr * *re - zi * *im + gr * u, zr * *im + zi * *re + gi * u);
        }
    }
    all
}

/// Four hits of differing size, `sin²` over 5 ms, 1.2 s apart and a little more from file to file.
fn hits(rng: &mut fastrand::Rng, file: usize) -> Excitation {
    let sizes: Vec<f64> = (0..4).map(|_| 50.0 + 30.0 * rng.f64()).collect();
    let force = move |t: f64| -> f64 {
        let pulse = |(hit, size): (usize, &f64)| {
            let x = (t - 0.1 - hit as f64 * (1.2 + 0.02 * file as f64)) / 5e-3;
            if (0.0..1.0).contains(&x) {
                size * (PI * x).sin().powi(2)
            } else {
                0.0
            }
        };
        sizes.iter().enumerate().map(pulse).sum()
    };
    (Box::new(force), 5200 * RATE as usize / 1000)
}

/// A sine that sweeps from 20 to 350 Hz between 0.5 s and 6 s, and a record that is longer from file to file.
fn sweep(_: &mut fastrand::Rng, file: usize) -> Excitation {
    let force = |t: f64| -> f64 {
        let x = (t - 0.5) / 5.5;
        if !(0.0..1.0).contains(&x) {
            return 0.0;
        }
        let edge = (20.0 * x.min(1.0 - x)).min(1.0);
        let phase = TAU * 5.5 * (20.0 * x + 165.0 * x * x);
        10.0 * (0.5 * PI * edge).sin().powi(2) * phase.sin()
    };
    (Box::new(force), (7000 + 300 * file) * RATE as usize / 1000)
}

/// Random numbers, each held for a sample.
fn random(rng: &mut fastrand::Rng) -> Excitation {
    let numbers: Vec<f64> = (0..20_000).map(|_| 10.0 * normal(rng)).collect();
    let force = move |t: f64| numbers[((t * RATE + 1e-6) as usize).min(numbers.len() - 1)];
    (Box::new(force), 20_000)
}

fn write(folder: &Path, name: &str, heads: &str, columns: &[Vec<f64>]) -> String {
    let mut text = format!("{heads}\n");
    for t in 0..columns[0].len() {
        let cells: Vec<String> = columns.iter().map(|c| format!("{:.9e}", c[t])).collect();
        text += &format!("{:.4},{}\n", t as f64 / RATE, cells.join(","));
    }
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    path.display().to_string()
}

/// A file for each point; `heads` of a point; whether the hammer moves.
fn files(
    folder: &Path,
    excitation: fn(&mut fastrand::Rng, usize) -> Excitation,
    heads: impl Fn(usize) -> String,
    hammer_moves: bool,
) -> Vec<String> {
    let mut rng = fastrand::Rng::with_seed(11);
    let file = |p: usize| {
        let force = excitation(&mut rng, p);
        let (at, of) = if hammer_moves { (p, 0) } else { (0, p) };
        let mut columns = response(&force, at, &[of]);
        let y = &mut columns[1];
        let noise = 1e-3 * (y.iter().map(|y| y * y).sum::<f64>() / y.len() as f64).sqrt();
        y.iter_mut().for_each(|y| *y += noise * normal(&mut rng));
        write(folder, &format!("point_{}.csv", p + 1), &heads(p), &columns)
    };
    (0..POINTS).map(file).collect()
}

/// Frequencies within five deviations, shapes over the outputs named to 1 %.
fn assert_shapes(found: &Value, names: &[String]) {
    let modes = found["modes"].as_array().unwrap();
    assert_eq!(modes.len(), MODES.len(), "{modes:?}");
    for (m, (mode, (f, _))) in modes.iter().zip(MODES).enumerate() {
        let off = (mode["frequency_hz"].as_f64().unwrap() - f).abs();
        assert!(
            off < 5.0 * mode["frequency_std_hz"].as_f64().unwrap() + 1e-4 * f,
            "{mode}"
        );
        let own: Vec<f64> = (0..POINTS).map(|p| shape(m, p)).collect();
        let largest = own
            .iter()
            .fold(0.0f64, |a, b| if b.abs() > a.abs() { *b } else { a });
        let part = |p: usize, key: &str| mode["shape"][&names[p]][key].as_f64().unwrap();
        let sign = (0..POINTS)
            .map(|p| part(p, "re") * own[p] / largest)
            .sum::<f64>()
            .signum();
        for p in 0..POINTS {
            let (re, im) = (sign * part(p, "re") - own[p] / largest, part(p, "im"));
            assert!(re.hypot(im) < 0.01, "{}: {mode}", names[p]);
        }
    }
}

fn call<'a>(files: &'a [String], more: &[&'a str]) -> Vec<&'a str> {
    let files = files.iter().map(String::as_str);
    std::iter::once("identify")
        .chain(files)
        .chain(more.iter().copied())
        .collect()
}

/// Frequencies and shapes of three known modes over five points, a file each: a roving sensor and a roving hammer, hits and sweeps, named
/// by the flag, by a list, and by channels of different names.
#[test]
fn exact_shapes_of_points_in_files() {
    let stems: Vec<String> = (1..=POINTS).map(|p| format!("point_{p}")).collect();
    let equal = |_: usize| "time [s],force [N],acc [m]".to_string();
    let what = ["--input", "force", "--output", "acc", "--json", "--roving"];
    for excitation in [hits, sweep] {
        for (moves, side) in [(false, "output"), (true, "input")] {
            let folder = tempfile::tempdir().unwrap();
            let files = files(folder.path(), excitation, equal, moves);
            let found = document(&[&call(&files, &what)[..], &[side]].concat());
            assert_shapes(&found, &stems);
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let own = |p: usize| format!("time [s],force [N],a{} [m]", p + 1);
    let names: Vec<String> = (1..=POINTS).map(|p| format!("a{p}")).collect();
    let all = files(folder.path(), hits, own, false);
    let what = ["--input", "force", "--output", "a1,a2,a3,a4,a5", "--json"];
    assert_shapes(&document(&call(&all, &what)), &names);
    let own = |p: usize| format!("time [s],f{} [N],acc [m]", p + 1);
    let names: Vec<String> = (1..=POINTS).map(|p| format!("f{p}")).collect();
    let all = files(folder.path(), hits, own, true);
    let what = ["--input", "f1,f2,f3,f4,f5", "--output", "acc", "--json"];
    assert_shapes(&document(&call(&all, &what)), &names);
    let _ = files(folder.path(), hits, equal, true);
    let quoted: Vec<String> = stems.iter().map(|s| format!("\"{s}.csv\"")).collect();
    let list = folder.path().join("test.toml");
    let text = format!(
        "[log]\nroving = \"input\"\nfiles = [{}]\n",
        quoted.join(", ")
    );
    fs::write(&list, text).unwrap();
    let what = ["--input", "force", "--output", "acc", "--json"];
    let list = [list.display().to_string()];
    assert_shapes(&document(&call(&list, &what)), &stems);
}

/// What is neither hits nor points is refused with the file.
#[test]
fn refuses_files_of_no_test_of_points() {
    let folder = tempfile::tempdir().unwrap();
    let mut rng = fastrand::Rng::with_seed(3);
    let force = hits(&mut rng, 0);
    let columns = response(&force, 0, &[0, 1]);
    let both = write(
        folder.path(),
        "both.csv",
        "time [s],f [N],a [m],b [m]",
        &columns,
    );
    let single = write(
        folder.path(),
        "single.csv",
        "time [s],f [N],a [m]",
        &columns[..2],
    );
    let (code, message) = refusal(&[
        "identify", &both, &single, "--input", "f", "--output", "a,b",
    ]);
    assert_eq!(code, "conflict");
    assert!(
        message.contains("a over f") && message.contains("both.csv"),
        "{message}"
    );
    let (code, message) = refusal(&[
        "identify", &single, "--input", "f", "--output", "a", "--roving", "output",
    ]);
    assert_eq!(code, "usage");
    assert!(message.contains("several files"), "{message}");
}

/// Two points driven at once by two forces: equal responses differ by no more than their noise; of a sensor whose sensitivity is 10 % off
/// by `0.1/√((1 + 1.1²)/2)`, 9.513 %, which is warned of.
#[test]
fn exact_reciprocity_of_two_points() {
    let mut rng = fastrand::Rng::with_seed(5);
    let forces: Vec<Excitation> = (0..2).map(|_| random(&mut rng)).collect();
    let parts: Vec<Vec<Vec<f64>>> = (forces.iter().zip([0, 3]))
        .map(|(force, at)| response(force, at, &[0, 3]))
        .collect();
    let sum = |o: usize, size: f64, rng: &mut fastrand::Rng| -> Vec<f64> {
        (parts[0][o + 1].iter().zip(&parts[1][o + 1]))
            .map(|(a, b)| size * (a + b) + 1e-6 * normal(rng))
            .collect()
    };
    let folder = tempfile::tempdir().unwrap();
    for (name, size, known) in [("right.csv", 1.0, 0.0), ("off.csv", 1.1, 0.09513)] {
        let columns = [
            parts[0][0].clone(),
            parts[1][0].clone(),
            sum(0, 1.0, &mut rng),
            sum(1, size, &mut rng),
        ];
        let path = write(
            folder.path(),
            name,
            "time [s],f1 [N],f2 [N],x1 [m],x2 [m]",
            &columns,
        );
        let what = [
            "identify", &path, "--input", "f1,f2", "--output", "x1,x2", "--json",
        ];
        let found = document(&[&what[..], &["--driving-point", "f1=x1,f2=x2"]].concat());
        let pair = &found["reciprocity"][0];
        let difference = pair["difference"].as_f64().unwrap();
        let noise = pair["explained"].as_f64().unwrap();
        assert!(
            (difference - known).abs() < 2e-3 + 1.5 * noise,
            "{name}: {pair}"
        );
        let warned = found["warnings"].as_array().unwrap();
        let warned = warned.iter().any(|w| w["code"] == "not-reciprocal");
        assert_eq!(warned, known > 0.0, "{name}: {pair}");
    }
}

/// One file of five whose structure has all its modes 1.5 or 0.5 % lower, as the mass of a sensor makes them: the file is named; of equal
/// structures none is.
#[test]
fn law_a_file_with_poles_of_its_own_is_named() {
    let heads = "time [s],force [N],acc [m]";
    for scale in [0.985, 0.995, 1.0] {
        let folder = tempfile::tempdir().unwrap();
        let mut rng = fastrand::Rng::with_seed(29);
        let file = |p: usize| {
            let force = hits(&mut rng, p);
            let own = if p == 3 { scale } else { 1.0 };
            let mut columns = scaled_response(&force, 0, &[p], own);
            let y = &mut columns[1];
            let noise = 1e-3 * (y.iter().map(|y| y * y).sum::<f64>() / y.len() as f64).sqrt();
            y.iter_mut().for_each(|y| *y += noise * normal(&mut rng));
            write(
                folder.path(),
                &format!("point_{}.csv", p + 1),
                heads,
                &columns,
            )
        };
        let files: Vec<String> = (0..POINTS).map(file).collect();
        let what = [
            "--input", "force", "--output", "acc", "--roving", "output", "--json",
        ];
        let found = document(&call(&files, &what));
        let warned = found["warnings"].as_array().unwrap();
        let warned = warned.iter().find(|w| w["code"] == "poles-differ");
        assert_eq!(warned.is_some(), scale < 1.0, "{scale}: {found}");
        if let Some(warned) = warned {
            let hint = warned["hint"].as_str().unwrap();
            assert!(
                hint.contains("point_4.csv") && !hint.contains("point_2.csv"),
                "{warned}"
            );
        }
    }
}

/// Hits of differing size whose response is cut at a limit that two of them reach, for a few samples: these are left out, and no mode
/// comes of them. Where all reach it nothing is identified.
#[test]
fn law_hits_at_a_common_limit_are_clipped() {
    let mut rng = fastrand::Rng::with_seed(31);
    let columns = response(&hits(&mut rng, 0), 0, &[0, 3]);
    let tops: Vec<f64> = (columns[1].chunks(2400).take(4))
        .map(|hit| hit.iter().copied().fold(0.0, f64::max))
        .collect();
    let mut sorted = tops.clone();
    sorted.sort_by(f64::total_cmp);
    let folder = tempfile::tempdir().unwrap();
    let heads = "time [s],force [N],a [m],b [m]";
    for (limit, left) in [(0.5 * (sorted[1] + sorted[2]), 2), (0.95 * sorted[0], 0)] {
        let mut cut = columns.clone();
        cut[1].iter_mut().for_each(|y| *y = y.min(limit));
        let path = write(folder.path(), "cut.csv", heads, &cut);
        let what = ["identify", &path, "--input", "force", "--output", "a,b"];
        if left == 0 {
            let (_, message) = refusal(&what);
            assert!(message.contains("a response clipped"), "{message}");
            continue;
        }
        let found = document(&[&what[..], &["--json"]].concat());
        let hits = found["hits"].as_array().unwrap();
        let used = hits.iter().filter(|h| h["used"] == true).count();
        assert_eq!(used, left, "{hits:?}");
        assert_eq!(found["modes"].as_array().unwrap().len(), MODES.len());
    }
}
