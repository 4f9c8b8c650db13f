//! Time bases of synthetic stamps.

use super::*;

fn stamps(times: &[f64], resolution_s: f64) -> TimeStamps {
    TimeStamps {
        name: "t".into(),
        unit: "s".into(),
        first: String::new(),
        first_s: 0.0,
        seconds: SampleColumn::from_slice(times),
        resolution: Resolution::constant(resolution_s),
    }
}

#[test]
fn exact_rate_with_gaps() {
    let mut t: Vec<f64> = (0..1000).map(|i| f64::from(i) * 1e-3).collect();
    t[600..].iter_mut().for_each(|t| *t += 0.0503);
    let base = fit(&RawTiming::default(), &stamps(&t, 1e-9)).unwrap();
    assert!((base.rate_hz / 1000.0 - 1.0).abs() < 1e-12);
    assert_eq!(base.segments, vec![0..600, 600..1000]);
    assert_eq!((base.gaps[0].missing, base.gaps[0].row), (50, 600));
    assert_eq!(base.spacing, Spacing::Uniform);
}

#[test]
fn exact_rate_of_rounded_stamps() {
    // 300 Hz in whole milliseconds: the median step would give 333.3 Hz; at 3 kHz stamps repeat.
    for rate in [300.0, 3000.0] {
        let t: Vec<f64> = (0..3000)
            .map(|i| (f64::from(i) / rate * 1e3).round() * 1e-3)
            .collect();
        let base = fit(&RawTiming::default(), &stamps(&t, 1e-3)).unwrap();
        assert!((base.rate_hz / rate - 1.0).abs() < 1e-4, "{}", base.rate_hz);
        assert!(matches!(base.spacing, Spacing::Rounded { .. }));
        assert_eq!(base.segments.len(), 1);
    }
}

/// 1000 Hz in whole milliseconds: a step of 2 ms is a lost sample; at 999 Hz it is rounding once in a thousand rows.
#[test]
fn exact_lost_samples_of_whole_steps() {
    for lost in [&[700][..], &[700, 2100, 2200, 2250]] {
        let rows = (0..4000).filter(|i| !lost.contains(i));
        let t: Vec<f64> = rows.map(|i| f64::from(i) * 1e-3).collect();
        let base = fit(&RawTiming::default(), &stamps(&t, 1e-3)).unwrap();
        assert!((base.rate_hz / 1000.0 - 1.0).abs() < 1e-12);
        let missing: Vec<usize> = base.gaps.iter().map(|g| g.missing).collect();
        assert_eq!(missing, vec![1; lost.len()]);
        assert_eq!(base.spacing, Spacing::Uniform);
    }
    let t: Vec<f64> = (0..6000)
        .map(|i| (f64::from(i) / 0.999).floor() * 1e-3)
        .collect();
    let base = fit(&RawTiming::default(), &stamps(&t, 1e-3)).unwrap();
    assert_eq!(base.gaps, []);
    assert!((base.rate_hz / 999.0 - 1.0).abs() < 1e-4);
}

#[test]
fn refuses_stamps_that_are_all_equal() {
    let error = fit(&RawTiming::default(), &stamps(&[0.0; 50], 1.0)).unwrap_err();
    assert_eq!(error.code, Code::InvalidTimeStamps);
}

#[test]
fn refuses_stamps_that_repeat_or_run_back() {
    for time in [0.002, 0.0019] {
        let mut t: Vec<f64> = (0..10).map(|i| f64::from(i) * 1e-3).collect();
        t[3] = time;
        let mut timing = RawTiming::default();
        timing.lines.push(0, 5);
        let error = fit(&timing, &stamps(&t, 1e-6)).unwrap_err();
        assert_eq!(error.code, Code::InvalidTimeStamps);
        assert!(error.message.starts_with("line 8"), "{}", error.message);
    }
}

/// Stamps uneven by up to half a step have no gap without loss; with a lost sample they are rejected or the gap is certain.
#[test]
fn law_uneven_stamps_lose_nothing() {
    for (seed, jitter) in [(1, 0.2), (2, 0.3), (3, 0.4), (4, 0.49), (5, 0.45)] {
        let mut random = fastrand::Rng::with_seed(seed);
        let mut t: Vec<f64> = (0..4000)
            .map(|i| (f64::from(i) + jitter * (2.0 * random.f64() - 1.0)) * 1e-3)
            .collect();
        let base = fit(&RawTiming::default(), &stamps(&t, 1e-8)).unwrap();
        assert_eq!(base.gaps, [], "{jitter}");
        assert!(
            (base.rate_hz / 1000.0 - 1.0).abs() < 3e-4,
            "{}",
            base.rate_hz
        );
        if jitter < 0.3 {
            continue;
        }
        t[2000..].iter_mut().for_each(|t| *t += 1e-3);
        let error = fit(&RawTiming::default(), &stamps(&t, 1e-8)).unwrap_err();
        assert_eq!(error.code, Code::InvalidTimeStamps);
        t[2000..].iter_mut().for_each(|t| *t += 6e-3);
        let base = fit(&RawTiming::default(), &stamps(&t, 1e-8)).unwrap();
        let rows: Vec<usize> = base.gaps.iter().map(|g| g.row).collect();
        assert_eq!(rows, [2000]);
    }
}

#[test]
fn law_jitter_is_measured() {
    let mut random = fastrand::Rng::with_seed(3);
    let t: Vec<f64> = (0..20_000)
        .map(|i| f64::from(i) * 3e-3 + 3e-4 * (random.f64() - 0.5))
        .collect();
    let base = fit(&RawTiming::default(), &stamps(&t, 1e-6)).unwrap();
    assert!((base.rate_hz * 3e-3 - 1.0).abs() < 5.0 * base.rate_std);
    let Spacing::Jittered { rms_s, .. } = base.spacing else {
        panic!("{:?}", base.spacing)
    };
    assert!((rms_s / (3e-4 / 12f64.sqrt()) - 1.0).abs() < 0.02);
    // Random jitter is not drift; a clock that slows down by a fiftieth drifts in spite of jitter.
    let short = fit(&RawTiming::default(), &stamps(&t[..1000], 1e-6)).unwrap();
    assert_eq!(short.drift_hz, (short.rate_hz, short.rate_hz));
    let slower: Vec<f64> = t[..1000].iter().map(|t| t + 0.003 * t * t).collect();
    let (low, high) = fit(&RawTiming::default(), &stamps(&slower, 1e-6))
        .unwrap()
        .drift_hz;
    assert!((high / low - 1.0 - 0.0164).abs() < 0.002, "{low} {high}");
}
