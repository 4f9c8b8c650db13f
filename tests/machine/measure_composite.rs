//! One transmission error e(φ): what is read from it against closed forms.

use std::f64::consts::{PI, TAU};

use crate::support::verification::within;
use geardyn::internals::base::code::Code;
use geardyn::internals::numeric::statistics::peak_to_peak;
use geardyn::internals::te_record::single_flank::SingleFlankRecord;
use geardyn::internals::te_record::windowed_ranges::windowed_ranges;

/// `n` samples over `turns` turns of Σ a cos(order φ + phase).
fn waves(n: usize, turns: usize, lines: &[(f64, f64, f64)]) -> Vec<f64> {
    let at = |i: usize| {
        let angle = TAU * turns as f64 * i as f64 / n as f64;
        let wave = |&(order, a, phase): &(f64, f64, f64)| a * (order * angle + phase).cos();
        lines.iter().map(wave).sum()
    };
    (0..n).map(at).collect()
}

fn near(found: f64, expected: f64, tolerance: f64) {
    within("values, absolute", (found - expected).abs(), tolerance);
}

/// An eccentricity a alone: F_i′ = 2a, f_i′ = 2a sin(π/z) wherever the pitch lies, nothing in the short wave.
#[test]
fn exact_eccentricity() {
    let (z, a) = (24, 10.0);
    // 300 samples a pitch, even in number, so that the steepest pitch begins on a sample.
    let values = waves(24 * 300, 1, &[(1.0, a, 0.0)]);
    let record = SingleFlankRecord::new(&values, 1, z, true).unwrap();
    near(record.total_deviation(), 2.0 * a, 1e-12);
    near(
        record.ranges_per_pitch().sliding,
        2.0 * a * (PI / 24.0).sin(),
        1e-12,
    );
    let split = record.split_by_order();
    near(split.long_range, 2.0 * a, 1e-12);
    assert!(peak_to_peak(&split.short) < 1e-12);
    // The mean over a pitch passes order 1 by sin(π/z)/(π/z), less what straight lines between samples cut off: h²/12 of it.
    let passed = (PI / 24.0).sin() / (PI / 24.0);
    near(
        record.split_by_pitch_average().long_range,
        2.0 * a * passed,
        2.0 * a * (TAU / 7200.0f64).powi(2) / 6.0,
    );
}

/// Mesh orders alone: f_i′ is their range in every window, the long wave is nothing, by both ways; open and closed.
#[test]
fn exact_mesh_orders() {
    let values = waves(3 * 17 * 40, 3, &[(17.0, 2.0, 0.3), (34.0, 0.5, 1.0)]);
    for closed in [true, false] {
        let record = SingleFlankRecord::new(&values, 3, 17, closed).unwrap();
        let pitch = record.ranges_per_pitch();
        near(pitch.sliding, record.total_deviation(), 1e-12);
        // A fixed window of a closed record misses nothing; of an open one only the last lacks its end.
        near(pitch.fixed, record.total_deviation(), 1e-12);
        assert_eq!(pitch.each.len(), 51);
        let averaged = record.split_by_pitch_average();
        assert!(averaged.long_range < 1e-11, "{}", averaged.long_range);
        near(
            averaged.short_ranges.sliding,
            record.total_deviation(),
            1e-11,
        );
        if closed {
            assert!(record.split_by_order().long_range < 1e-12);
        }
    }
}

/// Orders just below z/2 are long, at z/2 and above short; amplitudes and phases of every line come back.
#[test]
fn exact_split_and_harmonics() {
    let z = 10;
    let (below, at, sub) = ((4.5, 3.0, 0.7), (5.0, 2.0, -1.1), (1.5, 1.0, 2.9));
    let values = waves(2 * z * 31, 2, &[below, at, sub, (0.0, 6.0, 0.0)]);
    let record = SingleFlankRecord::new(&values, 2, z, true).unwrap();
    let split = record.split_by_order();
    let expected = waves(values.len(), 2, &[below, sub, (0.0, 6.0, 0.0)]);
    for (found, expected) in split.long.iter().zip(&expected) {
        near(*found, *expected, 1e-12);
    }
    for ((long, short), whole) in split.long.iter().zip(&split.short).zip(&values) {
        near(long + short, *whole, 1e-14);
    }
    let harmonics = record.harmonics(20.0);
    assert_eq!(harmonics.len(), 41);
    near(harmonics[0].amplitude, 6.0, 1e-13);
    for (order, amplitude, phase) in [below, at, sub] {
        let line = (2.0 * order) as usize;
        near(harmonics[line].order(), order, 0.0);
        near(harmonics[line].amplitude, amplitude, 1e-13);
        near(harmonics[line].phase, phase, 1e-12);
    }
    let others = harmonics
        .iter()
        .filter(|h| ![0, 3, 9, 10].contains(&h.line));
    assert!(others.clone().count() == 37 && others.into_iter().all(|h| h.amplitude < 1e-13));
}

/// The line at half the sampling stands alone, and counts once.
#[test]
fn exact_line_at_half_the_sampling() {
    let values: Vec<f64> = (0..8)
        .map(|i| if i % 2 == 0 { 3.0 } else { -3.0 })
        .collect();
    let lines = SingleFlankRecord::new(&values, 1, 4, true)
        .unwrap()
        .harmonics(9.0);
    assert_eq!(lines.len(), 5);
    near(lines[4].amplitude, 3.0, 1e-15);
}

/// The window needs no whole number of samples: ranges of straight ramps are exact whatever the sampling.
#[test]
fn exact_ranges_between_samples() {
    // A triangle over 10 samples, 3 windows of 10/3 samples: slope 1 per sample, so one window holds 10/3.
    let triangle: Vec<f64> = (0..10).map(|i: i32| f64::from((i - 5).abs())).collect();
    let found = windowed_ranges(&triangle, 3, true);
    near(found.sliding, 10.0 / 3.0, 1e-15);
    near(found.each[0], 10.0 / 3.0, 1e-15);
    near(found.each[1], 5.0 - 10.0 / 3.0, 1e-15);
    near(found.each[2], 10.0 / 3.0, 1e-15);
    // An open record does not go on at its start.
    let ramp: Vec<f64> = (0..10).map(f64::from).collect();
    near(windowed_ranges(&ramp, 3, false).sliding, 10.0 / 3.0, 1e-15);
    near(windowed_ranges(&ramp, 3, true).sliding, 9.0, 1e-15);
}

/// Sliding windows against every pair of places looked at one by one.
#[test]
fn law_sliding_range_is_the_largest_of_all_pairs() {
    let mut seed = 7u64;
    let mut random = || {
        seed = seed
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (seed >> 40) as f64 / 1e6
    };
    for (n, count, closed) in [
        (60, 7, true),
        (60, 7, false),
        (48, 8, true),
        (31, 2, true),
        (40, 8, false),
    ] {
        let values: Vec<f64> = (0..n).map(|_| random()).collect();
        let width = n as f64 / count as f64;
        let at = |t: f64| {
            let (i, part) = (t.floor() as usize, t - t.floor());
            let (a, b) = (values[i % n], values[(i + 1) % n]);
            a + part * (b - a)
        };
        let end = if closed { n as f64 } else { (n - 1) as f64 };
        let mut largest = 0.0f64;
        for i in 0..n {
            let from = i as f64;
            let reach: Vec<f64> = (0..=width as usize)
                .map(|k| k as f64)
                .chain([width])
                .collect();
            for sign in [1.0, -1.0] {
                for step in &reach {
                    let t = from + sign * step;
                    if closed || (0.0..=end).contains(&t) {
                        largest = largest.max((at(t.rem_euclid(n as f64)) - at(from)).abs());
                    }
                }
            }
        }
        near(
            windowed_ranges(&values, count, closed).sliding,
            largest,
            1e-12,
        );
    }
}

/// A full hunting cycle of 21 and 63: the pinion turns 3 times. Of 20 and 21: 21 times.
#[test]
fn exact_hunting_cycle() {
    assert_eq!(SingleFlankRecord::hunting_turns(21, 63), 3);
    assert_eq!(SingleFlankRecord::hunting_turns(63, 21), 1);
    assert_eq!(SingleFlankRecord::hunting_turns(20, 21), 21);
    // Both gears eccentric: over the cycle both add up, over one turn of the wheel less may show.
    let (pinion, wheel) = (20, 21);
    let turns = SingleFlankRecord::hunting_turns(wheel, pinion);
    let values = waves(
        turns * wheel * 24,
        turns,
        &[(1.0, 5.0, 0.0), (wheel as f64 / pinion as f64, 5.0, 0.0)],
    );
    let record = SingleFlankRecord::new(&values, turns, wheel, true).unwrap();
    near(record.total_deviation(), 20.0, 0.2);
    let by_turn = record.ranges_per_rev();
    assert_eq!(by_turn.each.len(), 20);
    let least = by_turn.each.iter().fold(f64::INFINITY, |m, &r| m.min(r));
    assert!(least < 4.0, "the two nearly cancel in one turn: {least}");
    assert!(by_turn.sliding >= by_turn.fixed);
}

/// A straight drift in an open record belongs to the long wave and leaves the short one clean away from the ends.
#[test]
fn law_open_record_does_not_leak() {
    let (turns, z, per_pitch) = (2, 12, 50);
    let n = turns * z * per_pitch;
    let mesh = waves(n, turns, &[(z as f64, 1.0, 0.0)]);
    let values: Vec<f64> = (0..n)
        .map(|i| mesh[i] + 40.0 * i as f64 / n as f64)
        .collect();
    let open = SingleFlankRecord::new(&values, turns, z, false)
        .unwrap()
        .split_by_order();
    let closed = SingleFlankRecord::new(&values, turns, z, true)
        .unwrap()
        .split_by_order();
    let inside = |split: &[f64]| peak_to_peak(&split[3 * per_pitch..n - 3 * per_pitch]);
    near(inside(&open.short), 2.0, 0.05);
    assert!(
        inside(&closed.short) > 2.3,
        "the jump at the ends rings through"
    );
}

#[test]
fn refuses_records_without_sense() {
    let code = |values: &[f64], turns, teeth| {
        SingleFlankRecord::new(values, turns, teeth, true)
            .unwrap_err()
            .code
    };
    assert_eq!(code(&[0.0; 8], 0, 4), Code::OutOfRange);
    assert_eq!(code(&[0.0; 8], 1, 0), Code::OutOfRange);
    assert_eq!(code(&[0.0; 8], usize::MAX, 2), Code::OutOfRange);
    assert_eq!(code(&[0.0, f64::NAN, 1.0, 1.0], 1, 2), Code::NotANumber);
    assert_eq!(code(&[0.0; 7], 1, 4), Code::TooShort);
    assert_eq!(code(&[], 1, 1), Code::TooShort);
}
