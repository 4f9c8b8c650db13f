//! Logs against Python, in one run: text to columns, samples to a frequency response, responses to poles.
//!
//! `cargo bench --bench logs` prints times, errors against the truth and ratios. The peers need `python3` with pandas, Polars, SciPy,
//! scikit-rf and sdypy-EMA, on one thread as ours are; where one is missing only our side is shown. Rows without a peer are limits:
//! what the machine needs for the least that has to be done. Times are those on the processor. `-- text`, `-- averages`, `-- poles` and
//! `-- fits` print a part.

use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;
use std::fs::File;
use std::hint::black_box;
use std::io::{BufWriter, Read, Write};
use std::path::{Path, PathBuf};

use beside::{Took, best_on_processor as best};
use geardyn::internals::identify::initial_estimates::problem::CommonPoleOptions;
use geardyn::internals::identify::initial_estimates::vector_fitting::{InitialPoles, vector_fit};
use geardyn::internals::identify::modal::measured_frf::MeasuredFrf;
use geardyn::internals::identify::modal::plscf::{PlscfOptions, plscf};
use geardyn::internals::identify::modal::selection::{SelectionRule, select_modes};
use geardyn::internals::identify::rational::{self, FrfData, RationalOptions};
use geardyn::internals::numeric::fft::RealFft;
use geardyn::internals::numeric::{Complex, Matrix};
use geardyn::internals::recording::raw::RawLog;
use geardyn::internals::recording::read_options::ReadOptions;
use geardyn::internals::recording::sample_column::SampleColumn;
use geardyn::internals::recording::{open, preprocess};
use geardyn::internals::spectrum::frf::{Estimator, estimate, required_pairs};
use geardyn::internals::spectrum::welch::{WelchEstimator, WelchOptions};

mod beside;

/// Of the first column.
const WIDTH: usize = 44;

fn main() {
    beside::head(WIDTH, "peer");
    let parts: [(&str, fn()); 4] = [
        ("text", text),
        ("averages", averages),
        ("poles", poles),
        ("fits", fits),
    ];
    let asked: Vec<String> = std::env::args().collect();
    let is_asked = |name: &str| asked.iter().any(|word| word == name);
    let any = parts.iter().any(|(name, _)| is_asked(name));
    for (name, part) in parts {
        if !any || is_asked(name) {
            part();
        }
    }
}

fn row(what: &str, seconds: f64, error: Option<f64>, peer: Option<Took>) {
    beside::row(WIDTH, what, Took { seconds, error }, peer);
}

fn limit(what: &str, seconds: f64) {
    row(&format!("  limit: {what}"), seconds, None, None);
}

/// A file that goes with its owner.
struct Temporary(PathBuf);

impl Temporary {
    fn new(ending: &str) -> Temporary {
        let name = format!("geardyn-bench-{}.{ending}", std::process::id());
        Temporary(std::env::temp_dir().join(name))
    }

    fn of_numbers(ending: &str, numbers: impl Iterator<Item = f64>) -> Temporary {
        let file = Temporary::new(ending);
        let mut to =
            BufWriter::new(File::create(&file.0).expect("the temporary folder takes a file"));
        for x in numbers {
            to.write_all(&x.to_le_bytes()).expect("there is room");
        }
        to.flush().expect("there is room");
        file
    }

    fn path(&self) -> &str {
        self.0.to_str().expect("the name is plain")
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// A normal number by Box and Muller.
fn normal(rng: &mut fastrand::Rng) -> f64 {
    (-2.0 * (1.0 - rng.f64()).ln()).sqrt() * (TAU * rng.f64()).cos()
}

// Text.

/// Samples of the log; with three channels of six decimals some 200 MB.
const ROWS: usize = 5_000_000;

/// Numbers are written to this decimal.
const DECIMALS: f64 = 1e6;

/// A log of time and three channels, its numbers in millionths evenly within ±20.
fn write_log(path: &Path) -> std::io::Result<()> {
    let mut rng = fastrand::Rng::with_seed(1);
    let mut to = BufWriter::new(File::create(path)?);
    to.write_all(b"time [s],force [N],acc1 [m/s^2],acc2 [m/s^2]\n")?;
    let mut line = String::new();
    for row in 0..ROWS {
        line.clear();
        let micros = 20 * row;
        let _ = write!(line, "{}.{:06}", micros / 1_000_000, micros % 1_000_000);
        for _ in 0..3 {
            let k = rng.i32(-20_000_000..=20_000_000);
            let sign = if k < 0 { "-" } else { "" };
            let k = k.unsigned_abs();
            let _ = write!(line, ",{sign}{}.{:06}", k / 1_000_000, k % 1_000_000);
        }
        line.push('\n');
        to.write_all(line.as_bytes())?;
    }
    to.flush()
}

/// The largest relative distance of a value from the number nearest to what was written.
fn misread(log: &RawLog) -> f64 {
    let group = &log.groups[0];
    let stamps = group.timing.stamps.as_ref().expect("a column of time");
    let columns = group.channels.iter().map(|c| &c.samples);
    std::iter::once(&stamps.seconds)
        .chain(columns)
        .map(|column: &SampleColumn| {
            let mut values = vec![0.0; column.len()];
            column.read(0, &mut values).expect("it is there");
            assert_eq!(values.len(), ROWS);
            let of = |x: &f64| {
                let written = (x * DECIMALS).round() / DECIMALS;
                (x - written).abs() / written.abs().max(1.0 / DECIMALS)
            };
            values.iter().map(of).fold(0.0, f64::max)
        })
        .fold(0.0, f64::max)
}

fn text() {
    let log = Temporary::new("csv");
    write_log(&log.0).expect("the temporary folder takes a log");
    let options = ReadOptions::default();
    let read = || open::open(log.path(), &options).expect("the bench's own log is right");
    let (time, raw_log) = best(3, read);
    let error = misread(&raw_log);
    drop(raw_log);
    let bytes = std::fs::read(&log.0).expect("the log is there");
    let megabytes = bytes.len() as f64 / 1e6;
    for name in ["pandas", "polars"] {
        let theirs = beside::peer("logs_peer.py", &[name, log.path()]);
        let what = format!("CSV of {megabytes:.0} MB, {name}.read_csv");
        row(&what, time, Some(error), theirs);
    }
    let (time, _) = best(3, || {
        preprocess::preprocess(read(), &options).expect("its time is even")
    });
    row("the same, time base settled", time, None, None);
    let (time, _) = best(3, || drain(&log.0));
    limit("reading the file by 1 MB", time);
    let (time, _) = best(3, || memchr::memchr_iter(b'\n', black_box(&bytes)).count());
    limit("counting its lines in memory", time);
    let (time, _) = best(3, || {
        let word = |w: &[u8]| w.try_into().map_or(0, u64::from_le_bytes);
        let words = black_box(&bytes).chunks_exact(8).map(word);
        black_box(words.fold(0_u64, u64::wrapping_add))
    });
    limit("summing its bytes by words in memory", time);
}

fn drain(path: &Path) -> usize {
    let mut file = File::open(path).expect("the log is there");
    let mut block = vec![0; 1 << 20];
    std::iter::from_fn(|| file.read(&mut block).ok().filter(|&n| n > 0)).sum()
}

// Averages.

const SAMPLES: usize = 10_000_000;
const RATE_HZ: f64 = 51_200.0;
const BLOCK: usize = 4096;

/// Radius and angle of the two poles of the system measured, some 25 lines wide.
const RADIUS: f64 = 0.98;
const ANGLE: f64 = 0.9;

/// White noise, and what `y = x + 2 r cos a y₋₁ − r² y₋₂` makes of it, with noise besides.
fn signals() -> (Vec<f64>, Vec<f64>) {
    let mut rng = fastrand::Rng::with_seed(2);
    let x: Vec<f64> = (0..SAMPLES).map(|_| normal(&mut rng)).collect();
    let (mut y1, mut y2) = (0.0, 0.0);
    let answer = |&x: &f64| {
        let y = x + 2.0 * RADIUS * ANGLE.cos() * y1 - RADIUS * RADIUS * y2;
        (y2, y1) = (y1, y);
        y
    };
    let clean: Vec<f64> = x.iter().map(answer).collect();
    let y = clean.iter().map(|y| y + 0.1 * normal(&mut rng)).collect();
    (x, y)
}

fn averages() {
    let (x, y) = signals();
    let options = WelchOptions {
        block: BLOCK,
        ..WelchOptions::default()
    };
    let (time, found) = best(3, || {
        let mut estimator = WelchEstimator::new(RATE_HZ, 2, &required_pairs(&[0], &[1]), &options)
            .expect("right options");
        estimator.push(&[&x, &y]);
        let spectra = estimator.finish().expect("there are blocks");
        estimate(&spectra, &[0], &[1], Estimator::H1).expect("the input has power")
    });
    let value = &found.functions[0].values;
    let off = |k: usize| {
        let back = Complex::new(0.0, -TAU * k as f64 / BLOCK as f64).exp();
        let below = 1.0 - back * (2.0 * RADIUS * ANGLE.cos()) + back * back * (RADIUS * RADIUS);
        (value[k] * below - 1.0).norm_sqr()
    };
    let inner = 1..BLOCK / 2;
    let error = (inner.clone().map(off).sum::<f64>() / inner.len() as f64).sqrt();
    let file = Temporary::of_numbers("signals", x.iter().chain(&y).copied());
    let numbers = [BLOCK as f64, RADIUS, ANGLE].map(|x| x.to_string());
    let arguments = [file.path(), &numbers[0], &numbers[1], &numbers[2]];
    for (kind, name) in [
        ("h1", "scipy csd, welch"),
        ("h1_by_hand", "numpy rfft of blocks"),
    ] {
        let theirs = beside::peer("logs_peer.py", &[&[kind][..], &arguments[..]].concat());
        row(
            &format!("H1 of 2 × 10 000 000, {name}"),
            time,
            Some(error),
            theirs,
        );
    }
    let mut fft = RealFft::new(BLOCK);
    let mut work = vec![0.0; BLOCK];
    let mut lines = vec![Complex::new(0.0, 0.0); fft.lines()];
    let (time, _) = best(3, || {
        for channel in [&x, &y] {
            for start in (0..=SAMPLES - BLOCK).step_by(BLOCK / 2) {
                work.copy_from_slice(&channel[start..start + BLOCK]);
                fft.forward(&mut work, &mut lines);
                black_box(&lines);
            }
        }
    });
    limit("its transforms alone", time);
}

// Poles.

const MODES: usize = 20;

/// A square, as scikit-rf takes only matrices.
const RESPONSES: usize = 49;
const LINES: usize = 2000;
const LINE_HZ: f64 = 0.5;

/// Poles of the upper half plane, rad/s: 30 to 960 Hz at uneven steps, damping ratios 0.5 to 2 %.
fn truth() -> Vec<Complex> {
    let mut rng = fastrand::Rng::with_seed(3);
    let step = 930.0 / (MODES - 1) as f64;
    let pole = |r: usize| {
        let w = TAU * (30.0 + step * (r as f64 + 0.3 * (rng.f64() - 0.5)));
        let damping = 0.005 + 0.015 * rng.f64();
        Complex::new(-damping * w, w * (1.0 - damping * damping).sqrt())
    };
    (0..MODES).map(pole).collect()
}

/// Receptances of modes as high as each other, with noise of a share of each one's root mean square.
fn answers(
    poles: &[Complex],
    responses: usize,
    lines: usize,
    step_hz: f64,
    noise: f64,
) -> (Vec<f64>, Vec<Vec<Complex>>) {
    let mut rng = fastrand::Rng::with_seed(4);
    let f: Vec<f64> = (1..=lines).map(|k| step_hz * k as f64).collect();
    let shape = |r: usize, q: usize| {
        ((r + 1) as f64 * PI * (0.11 + 0.83 * q as f64 / responses as f64)).cos() + 0.25
    };
    let clean = |q: usize, f: f64| -> Complex {
        let s = Complex::new(0.0, TAU * f);
        let term = |(r, p): (usize, &Complex)| {
            let top = -2.0 * p.re * p.norm() * shape(r, q);
            Complex::new(top, 0.0) / ((s - p) * (s - p.conj()))
        };
        poles.iter().enumerate().map(term).sum()
    };
    let mut h: Vec<Vec<Complex>> = (0..responses)
        .map(|q| f.iter().map(|&f| clean(q, f)).collect())
        .collect();
    for h in &mut h {
        let power = h.iter().map(Complex::norm_sqr).sum::<f64>() / h.len() as f64;
        let size = noise * (0.5 * power).sqrt();
        h.iter_mut()
            .for_each(|z| *z += Complex::new(normal(&mut rng), normal(&mut rng)) * size);
    }
    (f, h)
}

/// The worst relative distance of a true pole from the nearest one found.
fn worst(truth: &[Complex], found: &[Complex]) -> f64 {
    let nearest = |p: &Complex| {
        let near = found.iter().map(|q| (q - p).norm() / p.norm());
        near.fold(f64::INFINITY, f64::min)
    };
    truth.iter().map(nearest).fold(0.0, f64::max)
}

fn poles() {
    let truth = truth();
    for (noise, name) in [(0.0, "no noise"), (1e-3, "60 dB")] {
        let (f, h) = answers(&truth, RESPONSES, LINES, LINE_HZ, noise);
        // True poles, lines, then responses: the whole problem in one file of numbers.
        let complex = |z: &Complex| [z.re, z.im];
        let numbers = (truth.iter().flat_map(complex))
            .chain(f.iter().copied())
            .chain(h.iter().flatten().flat_map(complex));
        let file = Temporary::of_numbers("responses", numbers);
        let counts = [MODES, LINES].map(|n| n.to_string());
        let peer =
            |kind: &str| beside::peer("logs_peer.py", &[kind, file.path(), &counts[0], &counts[1]]);

        let (time, fitted) = best(2, || {
            vector_fit(
                &f,
                &h,
                None,
                InitialPoles::Order(2 * MODES),
                CommonPoleOptions::default(),
            )
            .expect("it is well posed")
        });
        let what = format!(
            "vector fitting, order 40, {name} ({} steps)",
            fitted.iterations
        );
        row(
            &what,
            time,
            Some(worst(&truth, &fitted.poles)),
            peer("vector_fit"),
        );
        // Of each response and step: its columns made orthogonal to the numerator's, then brought to a triangle.
        let n = (2 * MODES + 1) as f64;
        let flops = 6.0 * (2 * LINES) as f64 * n * n * RESPONSES as f64;
        println!(
            "  {:.1} Gflop/s in its orthogonalisations",
            1e-9 * flops * fitted.iterations as f64 / time
        );

        if noise > 0.0 {
            let measured = alone(&f, &h);
            let (time, fit) = best(1, || {
                rational::fit(&measured, &RationalOptions::default()).expect("it fits")
            });
            let what = format!("rational fit without order ({} modes)", fit.modes.len());
            row(&what, time, Some(worst(&truth, &fit.poles)), None);
        }

        let given = MeasuredFrf::single_input(&f, &h).expect("right responses");
        let options = PlscfOptions {
            max_order: Some(4 * MODES),
        };
        let (time, orders) = best(3, || plscf(&given, &options).expect("it is well posed"));
        let chosen = select_modes(&orders, LINE_HZ, &SelectionRule::default());
        let found: Vec<Complex> = chosen.iter().map(|m| m.mode.pole).collect();
        let what = format!("pLSCF, orders 2 to 80, {name} ({} modes)", found.len());
        row(&what, time, Some(worst(&truth, &found)), peer("lscf"));
    }
    let a = Matrix::from_fn(1000, 1000, |i, j| ((i * 7 + j * 3) % 11) as f64);
    let (time, _) = best(3, || black_box(&a) * black_box(&a));
    limit(&format!("a product, {:.0} Gflop/s", 2.0 / time), time);
}

/// Responses with nothing said of their variance.
fn alone<'a>(f: &'a [f64], h: &'a [Vec<Complex>]) -> FrfData<'a> {
    FrfData {
        frequency_hz: f,
        responses: h,
        variance: None,
        variance_dof: None,
        smearing_hz: 0.0,
        line_independence: 1.0,
        derivative: 0,
        hits: None,
    }
}

/// Fits without a hint: of five modes in six responses of 2 000 lines and of ten in 42 of 10 000, damping 1 %; of a hundred in six of 4 000,
/// damping 0.3 %. Noise 40 dB below, its variance unknown.
fn fits() {
    let five = [80.0, 190.0, 330.0, 520.0, 800.0];
    let ten: Vec<f64> = (0..10).map(|r| 30.0 + 103.0 * f64::from(r)).collect();
    let hundred: Vec<f64> = (0..100).map(|r| 14.0 + 9.8 * f64::from(r)).collect();
    for (frequencies_hz, damping, responses, lines) in [
        (&five[..], 0.01, 6, 2000),
        (&ten[..], 0.01, 42, 10_000),
        (&hundred[..], 0.003, 6, 4000),
    ] {
        let truth: Vec<Complex> = frequencies_hz
            .iter()
            .map(|f| TAU * f * Complex::new(-damping, (1.0_f64 - damping * damping).sqrt()))
            .collect();
        let step = 1000.0 / lines as f64;
        let (f, h) = answers(&truth, responses, lines, step, 1e-2);
        let measured = alone(&f, &h);
        let (time, fit) = best(if truth.len() > 10 { 1 } else { 5 }, || {
            rational::fit(&measured, &RationalOptions::default()).expect("it fits")
        });
        let what = format!(
            "rational fit, {responses} × {lines}, {} of {} modes",
            fit.modes.len(),
            truth.len()
        );
        row(&what, time, Some(worst(&truth, &fit.poles)), None);
    }
}
