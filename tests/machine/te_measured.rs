//! Transmission error from two encoders: known errors come back, wrong records are refused.

use std::collections::HashMap;
use std::f64::consts::TAU;

use geardyn::internals::base::code::Code;
use geardyn::internals::base::error::Error;
use geardyn::internals::encoder::eccentricity::split_eccentricity;
use geardyn::internals::encoder::evaluate::{EvaluationOptions, TeEvaluation, evaluate};
use geardyn::internals::encoder::gear_train::GearTrain;
use geardyn::internals::encoder::index_pulses::{IndexSignal, PulseEdge};
use geardyn::internals::encoder::orders::KnownOrders;
use geardyn::internals::encoder::readings::{EncoderScale, EncoderScales, MemoryReadings};

use crate::support::noise::normal;
use crate::support::verification::{coverage as enter_coverage, within};

/// One arc second, rad.
const ARCSEC: f64 = TAU / 1_296_000.0;

/// A rig that is turned: what its train does wrong, and how it is read.
struct Rig {
    teeth: &'static str,
    /// Order per turn of the output, amplitude and phase, rad.
    errors: Vec<(f64, f64, f64)>,
    /// Counts a turn of either encoder; 0: angles in rad.
    counts: [f64; 2],
    /// Noise of a reading before it is rounded, in counts.
    noise: f64,
    rows_per_tooth: f64,
    turns: f64,
    /// Change of speed: share, and cycles in a turn of the output.
    uneven: (f64, f64),
    seed: u64,
}

impl Default for Rig {
    fn default() -> Self {
        Rig {
            teeth: "21:64",
            errors: vec![(1.0, 12.0 * ARCSEC, 0.3), (64.0, 4.0 * ARCSEC, -1.0)],
            counts: [0.0, 0.0],
            noise: 0.0,
            rows_per_tooth: 40.0,
            turns: 3.3,
            uneven: (0.05, 0.37),
            seed: 1,
        }
    }
}

/// Normal numbers.
struct Normal(fastrand::Rng);

impl Normal {
    fn draw(&mut self) -> f64 {
        normal(&mut self.0)
    }
}

impl Rig {
    /// The error at an angle of the output in turns.
    fn error(&self, turns: f64) -> f64 {
        let wave = |&(o, a, p): &(f64, f64, f64)| a * (TAU * o * turns + p).cos();
        self.errors.iter().map(wave).sum()
    }

    fn ask(&self) -> EvaluationOptions {
        let scale = |counts: f64| match counts > 0.0 {
            true => EncoderScale {
                unit: TAU / counts,
                wrap: None,
                step: TAU / counts,
            },
            false => EncoderScale::RAD,
        };
        EvaluationOptions {
            teeth: GearTrain::parse(self.teeth).unwrap(),
            scales: EncoderScales {
                input: scale(self.counts[0]),
                output: scale(self.counts[1]),
            },
            rate_hz: Some(1000.0),
            multiples: None,
            repair: false,
            known_orders: KnownOrders::default(),
            all_multiples: false,
            input: false,
            index: [None, None],
        }
    }

    /// Readings of both encoders.
    fn readings(&self) -> (Vec<f64>, Vec<f64>) {
        let teeth = GearTrain::parse(self.teeth).unwrap();
        let ratio = teeth.ratio().to_f64();
        let per_turn = self.rows_per_tooth * teeth.output_teeth() as f64;
        let mut normal = Normal(fastrand::Rng::with_seed(self.seed));
        let rows = (self.turns * per_turn) as usize;
        let mut read = |angle: f64, counts: f64| match counts > 0.0 {
            true => (angle / TAU * counts + self.noise * normal.draw()).floor(),
            false => angle,
        };
        let one = |i: usize| {
            let t = i as f64 / per_turn;
            let wave = self.uneven.0 / (TAU * self.uneven.1) * (TAU * self.uneven.1 * t).sin();
            let turns = t + wave; // of the output, ideally
            (
                read(TAU * turns / ratio, self.counts[0]),
                read(TAU * turns + self.error(turns), self.counts[1]),
            )
        };
        (0..rows).map(one).unzip()
    }

    fn measured(&self) -> Result<TeEvaluation, Error> {
        let (a, b) = self.readings();
        evaluate(&MemoryReadings(&a, &b), &self.ask())
    }
}

/// Without steps and noise amplitudes and phases come back to the stated error of the cells, whole turns or not.
#[test]
fn exact_lines_without_noise() {
    let errors = vec![
        (1.0, 12.0 * ARCSEC, 0.3),
        (64.0 / 21.0, 5.0 * ARCSEC, 2.0),
        (64.0, 4.0 * ARCSEC, -1.0),
        (128.0, 1.0 * ARCSEC, 0.5),
        (63.0, 0.7 * ARCSEC, 1.5),
    ];
    for (turns, rows_per_tooth) in [(2.4, 40.0), (21.5, 30.0)] {
        let rig = Rig {
            errors: errors.clone(),
            turns,
            rows_per_tooth,
            ..Rig::default()
        };
        let found = rig.measured().unwrap();
        assert!(found.order_error <= 5.005e-4);
        let flank = &found.flanks[0];
        for (order, amplitude, phase) in &errors {
            let line = flank
                .lines
                .iter()
                .find(|l| (l.order.value - order).abs() < 1e-9);
            let line = line.unwrap_or_else(|| panic!("order {order} is not listed"));
            let off = (line.amplitude / amplitude - 1.0).abs();
            assert!(off < 3.0 * found.order_error, "{order}: {off:e}");
            let turned = (line.phase - phase + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
            assert!(turned.abs() < 1e-3, "{order}: {turned}");
            assert!(line.significant);
        }
        assert!(flank.unexplained.is_empty(), "{:?}", flank.unexplained);
        let speed = found.speed.unwrap();
        let (mean, least, most) = speed.range();
        assert!((mean / (1000.0 * TAU / (rows_per_tooth * 64.0)) - 1.0).abs() < 0.03);
        assert!(least < 0.96 * mean && most > 1.03 * mean);
    }
}

/// What is counted of 200 or fewer rigs: lines looked at, and those whose interval holds the truth; of lines that are there and of
/// those that are not.
fn coverage(rigs: u64) -> [(usize, usize); 2] {
    const PAIRS: [&str; 8] = [
        "21:63", "21:64", "17:40", "31:30", "18:45", "23:71", "40:40", "20:47",
    ];
    let mut counted = [(0, 0); 2];
    for seed in 0..rigs {
        let mut rng = fastrand::Rng::with_seed(1000 + seed);
        let teeth = PAIRS[rng.usize(0..PAIRS.len())];
        let train = GearTrain::parse(teeth).unwrap();
        let (shafts, meshes) = (train.shafts(), train.meshes());
        let mesh = meshes[0].order.to_f64();
        let input = shafts[0].order.to_f64();
        let mut errors = Vec::new();
        for order in [
            1.0,
            2.0,
            input,
            2.0 * input,
            mesh,
            2.0 * mesh,
            mesh - 1.0,
            mesh + input,
        ] {
            if rng.f64() < 0.7 {
                let size = 10f64.powf(-1.0 + 2.3 * rng.f64());
                errors.push((order, size * ARCSEC, TAU * rng.f64()));
            }
        }
        let rig = Rig {
            teeth,
            errors,
            counts: [
                4.0 * (600.0 + 6000.0 * rng.f64()).round(),
                4.0 * (1000.0 + 8000.0 * rng.f64()).round(),
            ],
            noise: 0.1 + 0.6 * rng.f64(),
            rows_per_tooth: 22.0 + 20.0 * rng.f64(),
            turns: 2.2 + 3.0 * rng.f64(),
            uneven: (0.05 * rng.f64(), 0.2 + 3.0 * rng.f64()),
            seed,
        };
        let found = rig.measured().unwrap_or_else(|e| panic!("rig {seed}: {e}"));
        // Errors of one order add up as pointers.
        let mut truth: HashMap<i64, (f64, f64)> = HashMap::new();
        let key = |order: f64| (order * 1e6).round() as i64;
        for (order, a, p) in &rig.errors {
            let sum = truth.entry(key(*order)).or_default();
            *sum = (sum.0 + a * p.cos(), sum.1 + a * p.sin());
        }
        for line in &found.flanks[0].lines {
            let Some((low, high)) = line.interval else {
                continue;
            };
            let truth = truth
                .get(&key(line.order.value))
                .map_or(0.0, |z| z.0.hypot(z.1));
            let at = usize::from(truth == 0.0);
            counted[at].0 += 1;
            counted[at].1 += usize::from(low <= truth && truth <= high);
        }
    }
    counted
}

fn hold(counted: [(usize, usize); 2], least: usize) {
    let share = |(all, inside): (usize, usize)| inside as f64 / all as f64;
    println!(
        "there: {:?} {:.4}; not there: {:?} {:.4}",
        counted[0],
        share(counted[0]),
        counted[1],
        share(counted[1])
    );
    assert!(counted[0].0 >= least);
    let (all, inside) = counted[0];
    enter_coverage("amplitudes of transmission error", 0.95, inside, all);
    assert!((0.90..=0.99).contains(&share(counted[0])), "{counted:?}");
    // Where nothing is, an interval that begins at zero misses on one side only.
    assert!((0.90..=1.0).contains(&share(counted[1])), "{counted:?}");
}

/// Of random rigs the true amplitudes lie inside the 95 % intervals in 90 to 99 %.
#[test]
fn law_intervals_hold_the_truth() {
    hold(coverage(40), 120);
}

/// The same of 200 rigs.
#[test]
#[ignore = "slow: 200 rigs"]
fn law_intervals_hold_the_truth_of_200_rigs() {
    hold(coverage(200), 800);
}

/// Both ways: two flanks, the play between them, nothing of the reversal in either.
#[test]
fn exact_play_between_flanks() {
    let rig = Rig::default();
    let (a, b) = Rig {
        turns: 2.5,
        uneven: (0.0, 1.0),
        ..rig
    }
    .readings();
    let play = 300.0 * ARCSEC;
    let ratio = 21.0 / 64.0;
    // Back: the input turns through the play before the output follows.
    let (mut input, mut output) = (a.clone(), b.clone());
    let step = a[1] - a[0];
    let (end_a, end_b) = (a[a.len() - 1], b[b.len() - 1]);
    let idle = (play / ratio / step).ceil() as usize;
    for k in 1..a.len() + idle - 1 {
        let back = end_a - k as f64 * step;
        input.push(back);
        let free = (k as f64 * step * ratio).min(play);
        let turns = (ratio * back + play) / TAU;
        output.push(if free < play {
            end_b
        } else {
            TAU * turns + Rig::default().error(turns)
        });
    }
    let found = evaluate(&MemoryReadings(&input, &output), &Rig::default().ask()).unwrap();
    assert_eq!(found.runs.len(), 2);
    assert_eq!(found.flanks.len(), 2);
    let shown = found.backlash.unwrap();
    let course = shown.variation.unwrap();
    let size = 20.0 * ARCSEC; // the error itself at an angle shifted by the play
    within("play, arcsec", (shown.mean - play).abs() / ARCSEC, 0.1);
    assert!(course.range.1 - course.range.0 < size);
    for flank in &found.flanks {
        let one = flank
            .lines
            .iter()
            .find(|l| l.order.names[0] == "output")
            .unwrap();
        within(
            "amplitude, arcsec",
            (one.amplitude / ARCSEC - 12.0).abs(),
            0.01,
        );
        assert!(flank.noise < 0.05 * ARCSEC, "{}", flank.noise / ARCSEC);
    }
}

fn refused(found: Result<TeEvaluation, Error>, code: Code, words: &[&str]) {
    let error = match found {
        Ok(_) => panic!("not refused: {words:?}"),
        Err(error) => error,
    };
    assert_eq!(error.code, code, "{error}");
    assert!(error.hint.is_some());
    for word in words {
        assert!(error.to_string().contains(word), "{word}: {error}");
    }
}

/// Other teeth than stated: the measured ratio and the teeth it would be.
#[test]
fn refuses_wrong_teeth() {
    let rig = Rig {
        counts: [20_000.0, 20_000.0],
        ..Rig::default()
    };
    let (a, b) = rig.readings();
    for (said, _) in [("21:63", 0), ("63:21", 0), ("22:64", 0)] {
        let options = EvaluationOptions {
            teeth: GearTrain::parse(said).unwrap(),
            ..rig.ask()
        };
        let found = evaluate(&MemoryReadings(&a, &b), &options);
        refused(found, Code::RatioMismatch, &["0.328", "21:64"]);
    }
    // A shaft that counts the other way round is no other ratio.
    let back: Vec<f64> = b.iter().map(|x| -x).collect();
    evaluate(&MemoryReadings(&a, &back), &rig.ask()).unwrap();
}

#[test]
fn refuses_slip() {
    let rig = Rig {
        counts: [20_000.0, 20_000.0],
        ..Rig::default()
    };
    let (a, mut b) = rig.readings();
    let n = b.len();
    for (i, x) in b[n / 2..].iter_mut().enumerate() {
        *x -= (0.05 * i as f64).min(150.0).floor();
    }
    refused(
        evaluate(&MemoryReadings(&a, &b), &rig.ask()),
        Code::Slip,
        &["slip", "s"],
    );
}

/// Lost counts are found where they are, and taken out where that is asked for.
#[test]
fn refuses_lost_counts_or_mends_them() {
    let rig = Rig {
        counts: [20_000.0, 20_000.0],
        noise: 0.2,
        ..Rig::default()
    };
    let (mut a, mut b) = rig.readings();
    assert!(evaluate(&MemoryReadings(&a, &b), &rig.ask()).is_ok());
    b[3000..].iter_mut().for_each(|x| *x -= 2.0);
    a[6000..].iter_mut().for_each(|x| *x += 7.0);
    let found = evaluate(&MemoryReadings(&a, &b), &rig.ask());
    refused(
        found,
        Code::LostCounts,
        &[
            "2 counts lost on the output or 6 too many on the input at 3.0",
            "7 counts too many on the input at 6.0",
            "--repair",
        ],
    );
    let options = EvaluationOptions {
        repair: true,
        ..rig.ask()
    };
    let found = evaluate(&MemoryReadings(&a, &b), &options).unwrap();
    assert_eq!(found.removed_steps.len(), 2);
    let one = &found.flanks[0].lines[0];
    assert!(
        (one.amplitude / ARCSEC - 12.0).abs() < 1.0,
        "{}",
        one.amplitude / ARCSEC
    );
}

/// One to five counts lost on either encoder, hidden in 90 arcsec of eccentricity, are found; five of the output make the step of three
/// of the input to 2.5 %, and both are said.
#[test]
fn refuses_single_lost_counts_of_unlike_encoders() {
    let rig = Rig {
        teeth: "13:40",
        errors: vec![
            (1.0, 33.0 * ARCSEC, 0.7),
            (40.0 / 13.0, 22.0 * ARCSEC, -1.3),
            (40.0, 1.5 * ARCSEC, 1.7),
            (2.0, 0.7 * ARCSEC, 0.2),
        ],
        counts: [14_400.0, 72_000.0],
        noise: 0.15,
        turns: 8.4,
        rows_per_tooth: 77.0,
        ..Rig::default()
    };
    let (a, b) = rig.readings();
    assert!(evaluate(&MemoryReadings(&a, &b), &rig.ask()).is_ok());
    let third = a.len() / 3;
    for lost in 1..=5 {
        for whose in ["input", "output"] {
            let (mut a, mut b) = (a.clone(), b.clone());
            let side = if whose == "input" { &mut a } else { &mut b };
            side[third..].iter_mut().for_each(|x| *x -= f64::from(lost));
            let words = format!("{lost} ");
            let on = format!("on the {whose}");
            let found = evaluate(&MemoryReadings(&a, &b), &rig.ask());
            refused(found, Code::LostCounts, &["lost", &words, &on]);
            let options = EvaluationOptions {
                repair: true,
                ..rig.ask()
            };
            let mended = evaluate(&MemoryReadings(&a, &b), &options).unwrap();
            let total = mended.flanks[0].fitted.total / ARCSEC;
            let clean = rig.measured().unwrap().flanks[0].fitted.total / ARCSEC;
            assert!(
                (total - clean).abs() < 1.5,
                "{whose} {lost}: {total} {clean}"
            );
        }
    }
    let mut b = b;
    b[third..].iter_mut().for_each(|x| *x -= 5.0);
    let error = evaluate(&MemoryReadings(&a, &b), &rig.ask()).unwrap_err();
    assert!(
        error.message.contains("5 lost on the output")
            || error.message.contains("5 counts lost on the output"),
        "{error}"
    );
    assert!(
        error.message.contains("3 too many on the input")
            || error.message.contains("3 counts too many on the input"),
        "{error}"
    );
}

/// What the cells may lose of a line is part of its interval: without noise the truth lies inside.
#[test]
fn law_intervals_hold_the_bound_of_the_cells() {
    let rig = Rig {
        turns: 5.3,
        ..Rig::default()
    };
    let found = rig.measured().unwrap();
    for (order, amplitude, _) in &rig.errors {
        let lines = &found.flanks[0].lines;
        let line = lines.iter().find(|l| (l.order.value - order).abs() < 1e-9);
        let (low, high) = line.unwrap().interval.unwrap();
        assert!(
            low < *amplitude && *amplitude < high,
            "{order}: {low} {high}"
        );
        assert!(high - low >= 2.0 * found.order_error * 0.99 * amplitude);
    }
}

/// Coarse encoders add their steps to the ranges of the readings; those of the fitted orders are the truth within their deviation.
#[test]
fn exact_ranges_of_the_orders() {
    let fine = Rig {
        turns: 6.3,
        ..Rig::default()
    };
    let coarse = Rig {
        counts: [20_000.0, 20_000.0],
        noise: 0.3,
        ..Rig {
            turns: 6.3,
            ..Rig::default()
        }
    };
    let (truth, found) = (fine.measured().unwrap(), coarse.measured().unwrap());
    let (truth, found) = (&truth.flanks[0], &found.flanks[0]);
    for (exact, raw, orders) in [
        (
            truth.composite.total,
            found.composite.total,
            found.fitted.total,
        ),
        (
            truth.composite.per_pitch.sliding,
            found.composite.per_pitch.sliding,
            found.fitted.per_pitch,
        ),
    ] {
        assert!(raw > 1.1 * exact, "{raw} {exact}");
        let deviation = found.fitted.deviation;
        assert!(
            (orders - exact).abs() < 4.0 * deviation,
            "{orders} {exact} {deviation}"
        );
        assert!(deviation < 0.4 * exact, "{deviation} {exact}");
    }
}

/// The largest change of `order_error` within `window` of `revolutions` turns from `start` on, by brute force.
fn range_of(error: impl Fn(f64) -> f64, start: f64, turns: f64, window: f64, steps: usize) -> f64 {
    let at = |i: usize| error(start + turns * i as f64 / steps as f64);
    let values: Vec<f64> = (0..=steps).map(at).collect();
    let wide = (window / turns * steps as f64).round() as usize;
    let mut largest = 0.0f64;
    // The window slides by a fiftieth of itself and is a tenth of that wider at most.
    for from in (0..=steps - wide).step_by((wide / 50).max(1)) {
        let part = &values[from..=from + wide];
        let (low, high) = part
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), &x| {
                (l.min(x), h.max(x))
            });
        largest = largest.max(high - low);
    }
    largest
}

/// Ranges of the orders, of the readings, of the long and of the short wave are those of the waves themselves, not of seventeen cells a
/// tooth, whatever turns the record holds beside whole hunting cycles.
#[test]
fn exact_waves_between_cells() {
    for (errors, turns) in [
        (vec![(1.0, 12.0, 0.5), (64.0, 4.0, -1.05)], 4.3),
        (
            vec![
                (1.0, 12.0, 0.5),
                (64.0 / 21.0, 30.0, 0.17),
                (64.0, 4.0, -1.05),
            ],
            4.3,
        ),
        (
            vec![(1.0, 5.0, 2.0), (64.0 / 21.0, 3.0, 0.2), (128.0, 4.0, 1.0)],
            22.4,
        ),
    ] {
        let scaled = |&(o, a, p): &(f64, f64, f64)| (o, a * ARCSEC, p);
        let rig = Rig {
            errors: errors.iter().map(scaled).collect(),
            turns,
            ..Rig::default()
        };
        let flank = &rig.measured().unwrap().flanks[0];
        let composite = &flank.composite;
        assert_eq!(composite.closed, turns > 21.0);
        assert_eq!(composite.turns, if turns > 21.0 { 21 } else { 4 });
        let start = flank.signal.first as f64 / flank.signal.samples_per_rev as f64;
        let whole = composite.turns as f64;
        // No step beyond 1/512 of a tooth's second multiple.
        let steps = composite.turns * 64 * 1024;
        let near = |name: &str, found: f64, truth: f64, within: f64| {
            assert!(
                (found - truth).abs() < within,
                "{name} of {turns} turns: {} {} ± {}",
                found / ARCSEC,
                truth / ARCSEC,
                within / ARCSEC
            );
        };
        let total = range_of(|x| rig.error(x), start, whole, whole, steps);
        let pitch = range_of(|x| rig.error(x), start, whole, 1.0 / 64.0, steps);
        let orders = &flank.fitted;
        near("F_i′ of the orders", orders.total, total, orders.bound);
        near(
            "f_i′ of the orders",
            orders.per_pitch,
            pitch,
            orders.bound_by_pitch,
        );
        assert!(orders.bound < 2e-3 * total && orders.bound_by_pitch < 2e-3 * pitch);
        near("F_i′", composite.total, total, 1e-3 * total);
        near("f_i′", composite.per_pitch.sliding, pitch, 1e-3 * pitch);
        let part = |long: bool| {
            let kept: Vec<_> = (rig.errors.iter().copied())
                .filter(|e| (e.0 < 32.0) == long)
                .collect();
            let waves = Rig {
                errors: kept,
                ..Rig::default()
            };
            move |x: f64| waves.error(x)
        };
        let long = range_of(part(true), start, whole, whole, steps);
        near(
            "long wave",
            composite.long_wave_component.0,
            long,
            1e-3 * long,
        );
        let short = 8.0 * ARCSEC;
        near(
            "short wave",
            composite.short_wave_component.0.sliding,
            short,
            1e-3 * short,
        );
    }
}

/// Play that changes over the angle is told by the orders of both flanks, not by the steps of the encoders.
#[test]
fn exact_course_of_play() {
    let rig = Rig {
        counts: [20_000.0, 36_000.0],
        noise: 0.3,
        turns: 3.2,
        uneven: (0.0, 1.0),
        ..Rig::default()
    };
    let exact = Rig {
        counts: [0.0, 0.0],
        ..Rig {
            turns: 3.2,
            uneven: (0.0, 1.0),
            ..Rig::default()
        }
    };
    let (a, b) = exact.readings();
    let play = |turns: f64| (60.0 + 9.0 * (TAU * turns + 1.0).cos()) * ARCSEC;
    let ratio = 21.0 / 64.0;
    let (mut input, mut output) = (a.clone(), b.clone());
    for (x, y) in a.iter().zip(&b).rev() {
        input.push(*x);
        output.push(y + play(x * ratio / TAU));
    }
    let mut normal = Normal(fastrand::Rng::with_seed(3));
    let mut read = |angle: f64, counts: f64| (angle / TAU * counts + 0.3 * normal.draw()).floor();
    let input: Vec<f64> = input.iter().map(|x| read(*x, rig.counts[0])).collect();
    let output: Vec<f64> = output.iter().map(|x| read(*x, rig.counts[1])).collect();
    let found = evaluate(&MemoryReadings(&input, &output), &rig.ask()).unwrap();
    let shown = found.backlash.unwrap();
    within("mean play, arcsec", (shown.mean / ARCSEC - 60.0).abs(), 1.5);
    let course = shown.variation.unwrap();
    assert!(course.deviation < 2.0 * ARCSEC);
    for (i, p) in course.signal.values.iter().enumerate() {
        let truth = play(course.signal.angle(i) / TAU);
        assert!(
            (p - truth).abs() < 5.0 * course.deviation,
            "{} {} ± {}",
            p / ARCSEC,
            truth / ARCSEC,
            course.deviation / ARCSEC
        );
    }
    let wide = course.range.1 - course.range.0;
    within("range of play, arcsec", (wide / ARCSEC - 18.0).abs(), 1.5);
}

/// A line that is not explained says which multiple of a shaft or mesh lies there; fitted with the others it has its name.
#[test]
fn keeps_names_near_unexplained_lines() {
    let mut rig = Rig {
        teeth: "1:90",
        turns: 4.0,
        ..Rig::default()
    };
    rig.errors = vec![(1.0, 12.0 * ARCSEC, 0.3), (53.0, 4.0 * ARCSEC, 1.0)];
    let found = rig.measured().unwrap();
    let line = &found.flanks[0].unexplained[0];
    assert_eq!(line.nearest.as_deref(), Some("53 × output"), "{line:?}");
    let mut rig = Rig {
        teeth: "21:64",
        turns: 3.3,
        ..Rig::default()
    };
    rig.errors.push((8.0, 0.2 * ARCSEC, 1.0));
    let (a, b) = rig.readings();
    let options = EvaluationOptions {
        all_multiples: true,
        ..rig.ask()
    };
    let found = evaluate(&MemoryReadings(&a, &b), &options).unwrap();
    let lines = &found.flanks[0].lines;
    let eight = lines.iter().find(|l| l.order.value == 8.0).unwrap();
    assert_eq!(eight.order.names, ["8 × output"]);
    assert!((eight.amplitude / ARCSEC - 0.2).abs() < 0.02);
}

#[test]
fn refuses_too_little() {
    let few = Rig {
        rows_per_tooth: 6.0,
        ..Rig::default()
    };
    refused(few.measured(), Code::TooShort, &["rows a tooth"]);
    let short = Rig {
        turns: 0.9,
        ..Rig::default()
    };
    refused(short.measured(), Code::TooShort, &["turns of the output"]);
    let rig = Rig::default();
    let (a, b) = rig.readings();
    let options = EvaluationOptions {
        multiples: Some(9),
        ..rig.ask()
    };
    refused(
        evaluate(&MemoryReadings(&a, &b), &options),
        Code::OutOfRange,
        &["order 576", "--harmonics"],
    );
    let still = vec![0.5; a.len()];
    refused(
        evaluate(&MemoryReadings(&still, &b), &rig.ask()),
        Code::NoSignal,
        &["input"],
    );
    refused(
        evaluate(&MemoryReadings(&a, &still), &rig.ask()),
        Code::NoSignal,
        &["output"],
    );
    let mut broken = b.clone();
    broken[77] = f64::NAN;
    refused(
        evaluate(&MemoryReadings(&a, &broken), &rig.ask()),
        Code::NotANumber,
        &["row 78", "output"],
    );
    refused(
        evaluate(&MemoryReadings(&[], &[]), &rig.ask()),
        Code::NoSignal,
        &[],
    );
}

/// Teeth far apart in number, a record of exactly one turn and little more, coarse encoders: an answer without numbers that are none.
#[test]
fn survives_extremes() {
    for (teeth, counts, turns) in [
        ("1:90", [400.0, 400_000.0], 1.4),
        ("60:7", [40_000.0, 40_000.0], 10.0),
        ("21:63", [20_000.0, 400.0], 1.8),
        ("24:60,30:75", [40_000.0, 400_000.0], 1.5),
    ] {
        let rig = Rig {
            teeth,
            counts,
            turns,
            errors: vec![(1.0, 50.0 * ARCSEC, 0.0)],
            noise: 0.3,
            rows_per_tooth: 160.0,
            ..Rig::default()
        };
        let found = rig.measured().unwrap_or_else(|e| panic!("{teeth}: {e}"));
        let flank = &found.flanks[0];
        assert!(
            flank
                .lines
                .iter()
                .all(|l| l.amplitude.is_finite() && l.deviation.is_finite())
        );
        assert!(flank.composite.total.is_finite());
    }
}

/// Both flanks and the pressure angle tell the eccentricity of each encoder from that of the gear on its shaft.
#[test]
fn exact_eccentricity_of_encoder_and_gear() {
    let alpha = 20f64.to_radians();
    let (input, output) = (47.0 / 20.0, 1.0);
    // encoder and gear of either shaft: amplitude in arcsec, phase
    let (e1, g1, e2, g2) = ((3.0, 0.4), (5.0, 2.0), (4.0, -1.0), (9.0, 0.7));
    let wave = |order: f64, (a, p): (f64, f64), turn: f64| (order, a * ARCSEC, p + turn);
    // on the driving gear the drive flank turns the gear's part by +α, on the driven one by −α; the coast flank the other way round
    let errors = |sign: f64| {
        vec![
            wave(input, e1, 0.0),
            wave(input, g1, sign * alpha),
            wave(output, e2, 0.0),
            wave(output, g2, -sign * alpha),
        ]
    };
    let rig = |sign: f64| Rig {
        teeth: "20:47",
        errors: errors(sign),
        turns: 4.0,
        uneven: (0.0, 1.0),
        ..Rig::default()
    };
    let (mut a, mut b) = rig(1.0).readings();
    let (play, ratio) = (100.0 * ARCSEC, 20.0 / 47.0);
    let (end, step) = (a.len() - 1, a[1] - a[0]);
    let (last, stands) = (a[end], b[end]);
    for k in 1..end {
        let back = last - k as f64 * step;
        let turns = ratio * back / TAU;
        let free = k as f64 * step * ratio < play;
        a.push(back);
        b.push(if free {
            stands
        } else {
            ratio * back + play + rig(-1.0).error(turns)
        });
    }
    let found = evaluate(&MemoryReadings(&a, &b), &rig(1.0).ask()).unwrap();
    let parts = split_eccentricity(&found, &GearTrain::parse("20:47").unwrap(), alpha);
    assert_eq!(parts.len(), 2);
    for (part, (shaft, encoder, gear)) in parts
        .iter()
        .zip([("input", e1.0, g1.0), ("output", e2.0, g2.0)])
    {
        assert_eq!(part.shaft, shaft);
        within(
            "encoder, arcsec",
            (part.encoder / ARCSEC - encoder).abs(),
            0.02,
        );
        within("gear, arcsec", (part.gear / ARCSEC - gear).abs(), 0.02);
    }
    // of one flank nothing is parted
    let one = rig(1.0).measured().unwrap();
    assert!(split_eccentricity(&one, &GearTrain::parse("20:47").unwrap(), alpha).is_empty());
}

/// The edges of a mark that stands at `mark_angle` turns of a shaft, a twentieth of a turn wide: as a level read row by row shows them, or timed
/// between rows. `revolutions` is where the shaft stands at each row.
fn edges(turns: &[f64], at: f64, timed: bool) -> Vec<PulseEdge> {
    let high = |x: f64| (x - at).rem_euclid(1.0) < 0.05;
    let changes = (1..turns.len()).filter(|&i| high(turns[i - 1]) != high(turns[i]));
    let edge = |i: usize| {
        let (before, here) = (turns[i - 1] - at, turns[i] - at);
        let border = if high(turns[i]) { 0.0 } else { 0.05 };
        let after = (here - border).rem_euclid(1.0) / (here - before);
        PulseEdge {
            row: i as f64 - if timed { after } else { 0.5 },
            rising: high(turns[i]),
        }
    };
    changes.map(edge).collect()
}

/// Marks of both shafts of a rig, by the angles it really has.
fn marked(rig: &Rig, at: [f64; 2], timed: bool) -> [Option<IndexSignal>; 2] {
    let exact = Rig {
        counts: [0.0; 2],
        errors: rig.errors.clone(),
        ..*rig
    };
    let (a, b) = exact.readings();
    let turns = |list: Vec<f64>| -> Vec<f64> { list.iter().map(|x| x / TAU).collect() };
    let signal = |k: usize, list: Vec<f64>| {
        Some(IndexSignal {
            edges: edges(&turns(list), at[k], timed),
            edge_uncertainty: if timed { 0.0 } else { 0.5 },
            counts: Some(rig.counts[k]).filter(|c| *c > 0.0),
        })
    };
    [signal(0, a), signal(1, b)]
}

fn counting() -> Rig {
    Rig {
        teeth: "13:40",
        errors: vec![
            (1.0, 33.0 * ARCSEC, 0.7),
            (40.0 / 13.0, 22.0 * ARCSEC, -1.3),
            (40.0, 1.5 * ARCSEC, 1.7),
        ],
        counts: [14_400.0, 72_000.0],
        noise: 0.15,
        turns: 8.4,
        rows_per_tooth: 77.0,
        ..Rig::default()
    }
}

/// Counters that start anywhere: phases count from the marks, of orders of the output from its own, of those of the input from its own.
#[test]
fn exact_phases_from_marks() {
    let rig = counting();
    let (a, b) = rig.readings();
    let start = |list: Vec<f64>, by: f64| -> Vec<f64> { list.iter().map(|x| x + by).collect() };
    let (a, b) = (start(a, 5_123.0), start(b, -31_777.0));
    let at = [0.31, 0.72];
    let options = EvaluationOptions {
        index: marked(&rig, at, false),
        ..rig.ask()
    };
    let found = evaluate(&MemoryReadings(&a, &b), &options).unwrap();
    assert!(found.diagnostics.is_empty(), "{:?}", found.diagnostics);
    let lines = &found.flanks[0].lines;
    for (order, _, phase) in &rig.errors {
        let line = lines.iter().find(|l| (l.order.value - order).abs() < 1e-9);
        let line = line.unwrap();
        let (shown, mark) = line.mark_phase.unwrap();
        let (expected, whose) = match order.fract() == 0.0 {
            true => (phase + order * TAU * at[1], "output"),
            false => (phase + TAU * at[0], "input"),
        };
        assert_eq!(mark, whose);
        let off = (shown - expected + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
        // A mark is known to a row or so, and a row is the 1/3080 of a turn.
        let known = 4.0 * line.deviation / line.amplitude + order * TAU / 3080.0;
        assert!(off.abs() < known, "{order}: {off} {known}");
    }
    for (index, at) in found.index.iter().flatten().zip(at) {
        assert!(index.passages >= 8 && index.missing + index.extra == 0);
        let counts = index.counts_between_passages.unwrap();
        let a_turn = rig.counts[usize::from(index.shaft == "output")];
        assert!((counts - a_turn).abs() < 8.0, "{counts}");
        let by = if index.shaft == "input" {
            5_123.0
        } else {
            -31_777.0
        };
        let off = (index.mark_angle - at - by / a_turn + 0.5).rem_euclid(1.0) - 0.5;
        assert!(off.abs() < 2e-3, "{off}");
    }
    // The mean turn of the input begins at its mark: what it shows there is the wave of the input.
    let means = &found.flanks[0].shaft_averages;
    let input = means.iter().find(|m| m.shaft == "input").unwrap();
    assert!(input.revolutions >= 20);
    let n = input.values.len() as f64;
    for (i, e) in input.values.iter().enumerate() {
        let turns = i as f64 / n + at[0];
        let wave = |k: f64, a: f64, p: f64| a * ARCSEC * (TAU * k * turns + p).cos();
        // The mesh repeats with the input as well.
        let expected = wave(1.0, 22.0, -1.3) + wave(13.0, 1.5, 1.7);
        let off = (e - expected).abs();
        assert!(off < 4.5 * input.standard_error, "{i}: {}", off / ARCSEC);
    }
    assert!(input.standard_error < ARCSEC);
}

/// In 2.4 turns the wave of the input hardly moves against the output: the mean turn of the output does not hold it all the same.
#[test]
fn exact_mean_turns_of_a_short_record() {
    let rig = Rig {
        errors: vec![(1.0, 12.0 * ARCSEC, 0.3), (64.0 / 21.0, 5.0 * ARCSEC, 2.0)],
        turns: 2.4,
        ..Rig::default()
    };
    let found = rig.measured().unwrap();
    let means = &found.flanks[0].shaft_averages;
    let range = |name: &str| {
        let mean = means.iter().find(|m| m.shaft == name).unwrap();
        let ends = (mean.values.iter()).fold((0.0f64, 0.0f64), |e, x| (e.0.min(*x), e.1.max(*x)));
        (ends.1 - ends.0) / ARCSEC
    };
    within(
        "range of the output, arcsec",
        (range("output") - 24.0).abs(),
        0.05,
    );
    within(
        "range of the input, arcsec",
        (range("input") - 10.0).abs(),
        0.05,
    );
}

/// Where so many counts of one encoder look like so many of the other, the marks say whose they are; what the error hides they find.
#[test]
fn refuses_lost_counts_by_marks() {
    let rig = counting();
    let (a, b) = rig.readings();
    let third = a.len() / 3;
    let ask = |repair: bool| EvaluationOptions {
        index: marked(&rig, [0.31, 0.72], true),
        repair,
        ..rig.ask()
    };
    let mut short = b.clone();
    short[third..].iter_mut().for_each(|x| *x -= 5.0);
    let error = evaluate(&MemoryReadings(&a, &short), &ask(false)).unwrap_err();
    assert_eq!(error.code, Code::LostCounts);
    assert!(
        error.message.contains("5 counts lost on the output at"),
        "{error}"
    );
    let mended = evaluate(&MemoryReadings(&a, &short), &ask(true)).unwrap();
    let total = |m: &TeEvaluation| m.flanks[0].fitted.total / ARCSEC;
    let clean = total(&rig.measured().unwrap());
    assert!((total(&mended) - clean).abs() < 1.5);
    // Both encoders lose what makes one step: the error shows nothing.
    let (mut a2, mut b2) = (a.clone(), b.clone());
    a2[third..].iter_mut().for_each(|x| *x -= 8.0 * 40.0);
    b2[third..].iter_mut().for_each(|x| *x -= 8.0 * 13.0 * 5.0);
    let blind = EvaluationOptions {
        index: [None, None],
        ..ask(false)
    };
    assert!(evaluate(&MemoryReadings(&a2, &b2), &blind).is_ok());
    let error = evaluate(&MemoryReadings(&a2, &b2), &ask(false)).unwrap_err();
    assert!(
        error.message.contains("320 counts lost on the input")
            && error.message.contains("520 counts lost on the output"),
        "{error}"
    );
}

/// Lines that are wrong by one factor on both shafts leave the ratio as it is: the marks tell.
#[test]
fn refuses_wrong_lines_by_marks() {
    let rig = counting();
    let (a, b) = rig.readings();
    let wrong = Rig {
        counts: rig.counts.map(|c| 2.0 * c),
        errors: rig.errors.clone(),
        ..rig
    };
    let options = EvaluationOptions {
        index: marked(&rig, [0.1, 0.2], false).map(|s| {
            s.map(|s| IndexSignal {
                counts: s.counts.map(|c| 2.0 * c),
                ..s
            })
        }),
        ..wrong.ask()
    };
    let found = evaluate(&MemoryReadings(&a, &b), &options);
    refused(
        found,
        Code::RatioMismatch,
        &["14400 counts apart", "28800", "--lines"],
    );
    // Forty counts a turn missing, every turn alike.
    let dirty = |x: &f64| (x * (1.0 - 40.0 / 14_400.0)).floor();
    let dirty: Vec<f64> = a.iter().map(dirty).collect();
    let mut options = EvaluationOptions {
        index: marked(&rig, [0.1, 0.2], false),
        ..rig.ask()
    };
    options.index[1] = None;
    let found = evaluate(&MemoryReadings(&dirty, &b), &options);
    refused(found, Code::LostCounts, &["turn by turn", "14400"]);
}

/// Pulses that are missing and pulses of noise are counted and passed over; no pulse at all, or none twice, is refused.
#[test]
fn survives_bad_index_pulses() {
    let rig = counting();
    let (a, b) = rig.readings();
    let mut index = marked(&rig, [0.31, 0.72], false);
    let output = index[1].as_mut().unwrap();
    output.edges.remove(6);
    output.edges.remove(6);
    let from = output.edges[3].row;
    output.edges.extend(
        [(700.0, true), (703.0, false)].map(|(more, rising)| PulseEdge {
            row: from + more,
            rising,
        }),
    );
    output.edges.sort_by(|a, b| a.row.total_cmp(&b.row));
    let options = EvaluationOptions { index, ..rig.ask() };
    let found = evaluate(&MemoryReadings(&a, &b), &options).unwrap();
    let said: Vec<&str> = found.diagnostics.iter().map(|w| w.code).collect();
    assert_eq!(said, ["index-pulses"]);
    let output = found.index[1].as_ref().unwrap();
    assert_eq!((output.missing, output.extra), (1, 1));
    for edges in [
        Vec::new(),
        vec![PulseEdge {
            row: 5e3,
            rising: true,
        }],
    ] {
        let mut options = options.clone();
        options.index[1].as_mut().unwrap().edges = edges;
        let found = evaluate(&MemoryReadings(&a, &b), &options);
        refused(found, Code::NoSignal, &["output", "fewer than two"]);
    }
}

/// A step that is no loss of counts, by the marks of both shafts, is left in and told.
#[test]
fn keeps_steps_that_are_no_counts() {
    let rig = counting();
    let third = rig.readings().0.len() / 3;
    // The encoder of the output slips on its shaft: counts and mark stay together.
    let (a, mut b) = rig.readings();
    b[third..].iter_mut().for_each(|x| *x += 60.0);
    let mut index = marked(&rig, [0.31, 0.72], true);
    let exact = Rig {
        counts: [0.0; 2],
        errors: rig.errors.clone(),
        ..rig
    };
    let mut turns: Vec<f64> = exact.readings().1.iter().map(|x| x / TAU).collect();
    turns[third..]
        .iter_mut()
        .for_each(|x| *x += 60.0 / 72_000.0);
    index[1].as_mut().unwrap().edges = edges(&turns, 0.72, true);
    let options = EvaluationOptions { index, ..rig.ask() };
    let found = evaluate(&MemoryReadings(&a, &b), &options).unwrap();
    let said: Vec<&str> = found.diagnostics.iter().map(|w| w.code).collect();
    assert!(said.contains(&"step-without-counts"), "{said:?}");
    assert!(found.removed_steps.is_empty());
}

/// A direction that turns too little is said to be left out.
#[test]
fn keeps_word_of_a_short_way_back() {
    let rig = Rig {
        turns: 2.5,
        uneven: (0.0, 1.0),
        ..Rig::default()
    };
    let (mut a, mut b) = rig.readings();
    let back: Vec<(f64, f64)> = a
        .iter()
        .copied()
        .zip(b.iter().copied())
        .rev()
        .take(1500)
        .collect();
    a.extend(back.iter().map(|x| x.0));
    b.extend(back.iter().map(|x| x.1));
    let found = evaluate(&MemoryReadings(&a, &b), &rig.ask()).unwrap();
    assert_eq!(found.flanks.len(), 1);
    let said: Vec<&str> = found.diagnostics.iter().map(|w| w.code).collect();
    assert_eq!(said, ["direction-too-short"]);
}
