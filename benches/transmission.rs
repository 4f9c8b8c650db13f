//! Transmission error from encoder counts against NumPy and against the memory, in one run.
//!
//! `cargo bench --bench transmission` prints times on the processor, errors against the truth and ratios. The peer needs `python3` with
//! NumPy, on one thread as ours is. The error is the worst relative one of an amplitude.

use std::f64::consts::TAU;
use std::fs::File;
use std::hint::black_box;
use std::io::{BufWriter, Write};

use beside::{Took, best_on_processor as best};
use geardyn::internals::encoder::evaluate::{EvaluationOptions, evaluate};
use geardyn::internals::encoder::gear_train::GearTrain;
use geardyn::internals::encoder::orders::KnownOrders;
use geardyn::internals::encoder::readings::{EncoderScale, EncoderScales, MemoryReadings};
use geardyn::internals::encoder::resampling::AngularResampler;
use geardyn::internals::numeric::Complex;
use geardyn::internals::numeric::fft::RealFft;

mod beside;

/// Of the first column.
const WIDTH: usize = 72;

/// Rows of both encoders.
const ROWS: usize = 10_000_000;

/// Rows in a turn of the output.
const PER_TURN: f64 = 3200.0;

/// Counts a turn of input and output.
const COUNTS: [f64; 2] = [40_000.0, 72_000.0];

/// Orders per turn of the output and amplitudes, rad; phases are 1, 2, 3, ….
const ERRORS: [(f64, f64); 4] = [
    (1.0, 5e-5),
    (64.0 / 21.0, 2e-5),
    (64.0, 1.5e-5),
    (128.0, 4e-6),
];

/// Counts of both encoders at an even clock, the speed uneven by 2 %.
fn readings() -> (Vec<f64>, Vec<f64>) {
    let mut rng = fastrand::Rng::with_seed(3);
    let one = |k: usize| {
        let even = k as f64 / PER_TURN;
        let turns = even + 0.02 / (TAU * 1.7) * (TAU * 1.7 * even).sin();
        let wave = |(n, (o, a)): (usize, &(f64, f64))| a * (TAU * o * turns + n as f64 + 1.0).cos();
        let error: f64 = ERRORS.iter().enumerate().map(wave).sum();
        let noise = [rng.f64(), rng.f64()];
        (
            (turns * 64.0 / 21.0 * COUNTS[0] + noise[0]).floor(),
            ((turns + error / TAU) * COUNTS[1] + noise[1]).floor(),
        )
    };
    (0..ROWS).map(one).unzip()
}

/// Transmission error over even cells of the angle and its transform, without any check; the worst relative error of an amplitude.
fn spectrum_alone(input: &[f64], output: &[f64], per_turn: usize) -> f64 {
    let ratio = 21.0 / 64.0;
    let turns = |counts: f64| counts / COUNTS[0] * ratio;
    let ends = (turns(input[0]), turns(input[ROWS - 1]));
    let mut cells = AngularResampler::new(per_turn, ends.0, ends.1).expect("there are turns");
    let (mut angles, mut errors) = (Vec::new(), Vec::new());
    for (a, b) in input.chunks(4096).zip(output.chunks(4096)) {
        angles.clear();
        angles.extend(a.iter().map(|a| turns(*a)));
        errors.clear();
        let error = |(b, turns): (&f64, &f64)| TAU * (b / COUNTS[1] - turns);
        errors.extend(b.iter().zip(&angles).map(error));
        cells.push(&angles, &errors);
    }
    let mut signal = cells.finish().expect("every cell has rows");
    // Whole hunting cycles of 21 turns.
    let cycle = 21 * per_turn;
    signal.values.truncate(signal.values.len() / cycle * cycle);
    let turns = signal.revolutions() as f64;
    let mut fft = RealFft::new(signal.values.len());
    let mut lines = vec![Complex::new(0.0, 0.0); fft.lines()];
    fft.forward(&mut signal.values, &mut lines);
    let scale = 2.0 / (turns * per_turn as f64);
    let off = |(order, a): &(f64, f64)| {
        let line = lines[(order * turns).round() as usize];
        (scale * line.norm() / a - 1.0).abs()
    };
    ERRORS.iter().map(off).fold(0.0, f64::max)
}

fn main() {
    beside::head(WIDTH, "numpy");
    let (input, output) = readings();
    let scale = |counts: f64| EncoderScale {
        unit: TAU / counts,
        wrap: None,
        step: TAU / counts,
    };
    let options = EvaluationOptions {
        teeth: GearTrain::parse("21:64").expect("teeth"),
        scales: EncoderScales {
            input: scale(COUNTS[0]),
            output: scale(COUNTS[1]),
        },
        rate_hz: Some(10_000.0),
        multiples: Some(2),
        repair: false,
        all_multiples: false,
        input: false,
        index: [None, None],
        known_orders: KnownOrders::default(),
    };
    let rows = MemoryReadings(&input, &output);
    let (seconds, found) = best(3, || {
        evaluate(&rows, &options).expect("the record is sound")
    });
    let off = |(order, a): &(f64, f64)| {
        let lines = &found.flanks[0].lines;
        let line = lines.iter().find(|l| (l.order.value - order).abs() < 1e-9);
        line.map_or(f64::NAN, |l| (l.amplitude / a - 1.0).abs())
    };
    let error = ERRORS.iter().map(off).fold(0.0, f64::max);
    let path = std::env::temp_dir().join(format!("geardyn-bench-te-{}.f64", std::process::id()));
    let mut to = BufWriter::new(File::create(&path).expect("the temporary folder takes a file"));
    for x in input.iter().chain(&output) {
        to.write_all(&x.to_le_bytes()).expect("there is room");
    }
    to.flush().expect("there is room");
    let name = path.to_str().expect("the name is plain");
    let ours = Took {
        seconds,
        error: Some(error),
    };
    let per_turn = found.flanks[0].signal.samples_per_rev;
    let (seconds, error) = best(3, || spectrum_alone(&input, &output, per_turn));
    let alone = Took {
        seconds,
        error: Some(error),
    };
    let peer = |script: &str| beside::peer("transmission_peer.py", &[script, name]);
    let interpolated = peer("interpolate");
    let what = "TE of 10 000 000 rows, all checks and intervals; numpy.interp and rfft";
    beside::row(WIDTH, what, ours, interpolated);
    let what = "its part: error at even angles and its transform alone; the same script";
    beside::row(WIDTH, what, alone, interpolated);
    let what = "all checks and intervals; numpy, least squares of 4 orders alone";
    beside::row(WIDTH, what, ours, peer("fit"));
    std::fs::remove_file(&path).expect("the file is ours");
    let (seconds, _) = best(3, || {
        black_box(&input).iter().sum::<f64>() + black_box(&output).iter().sum::<f64>()
    });
    let took = |seconds| Took {
        seconds,
        error: None,
    };
    beside::row(
        WIDTH,
        "  limit: summing both columns in memory",
        took(seconds),
        None,
    );
    let (seconds, _) = best(3, || {
        let e: Vec<f64> = (black_box(&input).iter().zip(black_box(&output)))
            .map(|(a, b)| b / COUNTS[1] - a / COUNTS[0] * 21.0 / 64.0)
            .collect();
        e
    });
    beside::row(
        WIDTH,
        "  limit: θ₂ − θ₁ z₁/z₂ into memory",
        took(seconds),
        None,
    );
}
