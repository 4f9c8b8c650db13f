//! Reading logs as they are: rates that contradict each other, rounded stamps, tables without names, rows that break off.

use std::f64::consts::TAU;

use geardyn::internals::base::code::Code;
use geardyn::internals::base::error::Error;
use geardyn::internals::base::mat5;
use geardyn::internals::numeric::parallel;
use geardyn::internals::plan::logs::identification::{IdentificationInput, identify};
use geardyn::internals::plan::logs::identify_study::IdentifyStudy;
use geardyn::internals::recording::open;
use geardyn::internals::recording::preprocess::preprocess;
use geardyn::internals::recording::raw::RawLog;
use geardyn::internals::recording::read_options::{RateSource, ReadOptions};
use geardyn::internals::recording::signals::Recording;

fn settled(name: &str, bytes: &[u8], rate: Option<RateSource>) -> Result<Recording, Error> {
    let options = ReadOptions {
        rate,
        ..ReadOptions::default()
    };
    let log = open::from_bytes(name, bytes, &options).map_err(|e| e.as_slice()[0].clone())?;
    preprocess(log, &options)
}

fn warning<'r>(recording: &'r Recording, code: &str) -> Option<&'r str> {
    let found = recording.diagnostics.iter().find(|w| w.code == code);
    found.map(|w| w.message.as_str())
}

/// Two columns of numbers without a time below `head`.
fn bare(head: &str) -> String {
    let row = |k: u32| format!("{:.4},{:.4}\n", f64::from(k).sin(), f64::from(k).cos());
    format!("{head}a,b\n{}", (0..50).map(row).collect::<String>())
}

/// A log with stamps of `rate_hz` written by `stamp`.
fn stamped(rate_hz: f64, seconds: f64, stamp: impl Fn(f64) -> String) -> String {
    let row = |k: u32| {
        let t = f64::from(k) / rate_hz;
        format!("{},{:.5}\n", stamp(t), (TAU * 0.11 * rate_hz * t).sin())
    };
    let rows = (0..(rate_hz * seconds) as u32).map(row);
    format!("time [s],acc [g]\n{}", rows.collect::<String>())
}

/// A number as C's `%.ng` writes it.
fn significant(x: f64, digits: i32) -> String {
    let scientific = format!("{:.*e}", (digits - 1) as usize, x);
    let (mantissa, exponent) = scientific.split_once('e').unwrap();
    let exponent: i32 = exponent.parse().unwrap();
    let bare = |text: &str| match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_string(),
        false => text.to_string(),
    };
    match (-4..digits).contains(&exponent) {
        true => bare(&format!("{:.*}", (digits - 1 - exponent) as usize, x)),
        false => format!("{}e{exponent:+03}", bare(mantissa)),
    }
}

fn matlab(variables: &[(&str, &[f64])]) -> Vec<u8> {
    let mut bytes = mat5::write::header("test");
    for (name, values) in variables {
        let array = mat5::write::real(name, [values.len(), 1], values.iter().copied());
        bytes.extend(array.unwrap());
    }
    bytes
}

/// A bearing on a test rig: `rate` is the speed of its shaft, `sr` the sample rate; the first in the file had been taken.
#[test]
fn exact_rate_of_samples_before_that_of_a_shaft() {
    let x: Vec<f64> = (0..2000).map(|k| f64::from(k).sin()).collect();
    let file = matlab(&[("rate", &[25.0]), ("sr", &[48_828.0]), ("gs", &x)]);
    let found = settled("bearing.mat", &file, None).unwrap();
    assert_eq!(found.rate_hz, 48_828.0);
    let said = warning(&found, "rate-disagrees").unwrap();
    assert!(said.contains("`rate` states 25 Hz"), "{said}");
    let found = settled(
        "run.csv",
        bare("rate: 25\nsampling rate: 48828 Hz\n").as_bytes(),
        None,
    );
    assert_eq!(found.unwrap().rate_hz, 48_828.0);
}

/// A bare `rate` that a shaft may have is asked about, and taken by --rate-from header; no shaft turns 5 000 times a second.
#[test]
fn refuses_a_bare_rate_that_a_shaft_may_have() {
    let x: Vec<f64> = (0..2000).map(|k| f64::from(k).sin()).collect();
    for file in [
        matlab(&[("rate", &[25.0]), ("gs", &x)]),
        bare("rate: 25\n").into_bytes(),
    ] {
        let error = settled("log", &file, None).unwrap_err();
        assert_eq!(error.code, Code::RateUnknown);
        assert!(
            error.message.contains("speed of a shaft"),
            "{}",
            error.message
        );
        let found = settled("log", &file, Some(RateSource::Header)).unwrap();
        assert_eq!(found.rate_hz, 25.0);
    }
    for head in ["rate: 5000\n", "rate: 25 S/s\n"] {
        assert!(
            settled("log.csv", bare(head).as_bytes(), None).is_ok(),
            "{head}"
        );
    }
}

/// Two rates of samples in one header: neither is taken.
#[test]
fn refuses_rates_of_a_header_that_differ() {
    let text = bare("sample rate: 1000 Hz\nfs: 2000 Hz\n");
    let error = settled("log.csv", text.as_bytes(), None).unwrap_err();
    assert_eq!(error.code, Code::RateDisagrees);
    assert!(error.message.contains("1000 Hz") && error.message.contains("2000 Hz"));
    let stated = settled("log.csv", text.as_bytes(), Some(RateSource::Hertz(2000.0))).unwrap();
    assert!(
        warning(&stated, "rate-disagrees")
            .unwrap()
            .contains("1000 Hz")
    );
}

/// A rate that is stated ten times off the stamps, or off the header, gets a warning; one that agrees does not.
#[test]
fn keeps_a_stated_rate_with_a_warning() {
    let text = stamped(1000.0, 1.0, |t| format!("{t:.4}"));
    let found =
        |hertz| settled("log.csv", text.as_bytes(), Some(RateSource::Hertz(hertz))).unwrap();
    let off = found(100.0);
    assert_eq!(off.rate_hz, 100.0);
    let said = warning(&off, "rate-disagrees").unwrap();
    assert!(said.contains("the time stamps say 1000 Hz"), "{said}");
    assert_eq!(warning(&found(1000.0), "rate-disagrees"), None);
}

/// One of two rates of the header agrees with the stamps: it is right, and the other is said.
#[test]
fn exact_rate_of_stamps_between_two_of_the_header() {
    let text = format!(
        "fs: 500\ndt: 0.001\n{}",
        stamped(1000.0, 1.0, |t| format!("{t:.4}"))
    );
    let found = settled("log.csv", text.as_bytes(), None).unwrap();
    assert_eq!(found.rate_hz, 1000.0);
    assert!(
        warning(&found, "rate-disagrees")
            .unwrap()
            .contains("`fs` states 500 Hz")
    );
}

/// Stamps with a fixed count of significant digits are rounded, not jittered: no row is resampled, and the rate is right.
#[test]
fn exact_rate_of_stamps_with_significant_digits() {
    let cases = [
        (2000.0, 12.0, 5),
        (5000.0, 25.0, 5),
        (1370.0, 30.0, 5),
        (200.0, 120.0, 5),
        (100.0, 300.0, 4),
        (5000.0, 25.0, 6),
    ];
    for (rate, seconds, digits) in cases {
        let case = format!("{rate} Hz, {seconds} s, {digits} digits");
        let text = stamped(rate, seconds, |t| significant(t, digits));
        let found =
            settled("log.csv", text.as_bytes(), None).unwrap_or_else(|e| panic!("{case}: {e}"));
        let off = found.rate_hz / rate - 1.0;
        // Roundings of the coarsest digit, a thousandth of the length, over many rows.
        assert!(off.abs() < 2e-6, "{case}: {off:e}");
        assert_eq!(found.samples as f64, rate * seconds, "{case}");
        assert_eq!(found.segments.len(), 1, "{case}: {:?}", found.repairs);
        assert!(
            found.repairs.iter().all(|r| r.kind != "resampled"),
            "{case}"
        );
    }
}

/// Stamps of five digits that jitter by more than their digits still are resampled, and lost samples still are a gap.
#[test]
fn exact_jitter_and_gaps_of_stamps_with_significant_digits() {
    let uneven = |t: f64| t + 0.8e-3 * (TAU * 77.7 * t).sin();
    let text = stamped(200.0, 20.0, |t| significant(uneven(t) + 1.0, 5));
    let found = settled("log.csv", text.as_bytes(), None).unwrap();
    assert!(found.repairs.iter().any(|r| r.kind == "resampled"));
    let text = stamped(200.0, 60.0, |t| {
        significant(if t < 30.0 { t } else { t + 0.05 }, 5)
    });
    let found = settled("log.csv", text.as_bytes(), None).unwrap();
    assert_eq!(found.segments.len(), 2);
    assert!(
        (found.segment_starts[1] - 6010.0).abs() < 0.2,
        "{:?}",
        found.segment_starts
    );
}

/// A table of a mode without names, its lines from `first` on, each written by `cells(Re, Im)`.
fn table(first: u32, cells: impl Fn(f64, f64) -> String) -> String {
    let line = |k: u32| {
        let r = f64::from(k) / 300.0;
        let (a, b) = (1.0 - r * r, 0.02 * r);
        let size = a * a + b * b;
        format!("{k},{}\n", cells(a / size, -b / size))
    };
    (first..first + 1500).map(line).collect()
}

/// Tables f, Re, Im and f, magnitude, phase without names had been taken for signals over time; two signals still are.
#[test]
fn exact_responses_without_names() {
    let cartesian = table(1, |re, im| format!("{re:e},{im:e}"));
    let degrees = table(1, |re, im| {
        format!("{:e},{:.6}", re.hypot(im), im.atan2(re).to_degrees())
    });
    let radians = table(0, |re, im| {
        format!("{:e},{:.6}", re.hypot(im), im.atan2(re))
    });
    let two = table(1, |re, im| format!("{re:e},{im:e},{:e},{im:e}", re + 0.1));
    let level = |re: f64, im: f64| 20.0 * re.hypot(im).log10();
    let decibel = table(1, |re, im| {
        format!("{:.8},{:.6}", level(re, im), im.atan2(re).to_degrees())
    });
    let decibel_radians = table(1, |re, im| {
        format!("{:.8},{:.8}", level(re, im), im.atan2(re))
    });
    let coherence = table(1, |re, im| {
        format!("{:.8},{:.6},0.97", level(re, im), im.atan2(re).to_degrees())
    });
    let texts = [
        (cartesian, 1),
        (degrees, 1),
        (radians, 1),
        (two, 2),
        (decibel, 1),
        (decibel_radians, 1),
        (coherence, 1),
    ];
    for (text, count) in texts {
        let log = open::from_bytes("frf.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
        let found = log.responses.unwrap();
        assert_eq!(found.responses.len(), count);
        assert!(
            log.diagnostics
                .iter()
                .any(|w| w.code == "frequency-guessed")
        );
        let line = found.frequency_hz.iter().position(|f| *f == 300.0).unwrap();
        let peak = found.responses[0].values[line];
        assert!(
            (peak.im + 50.0).abs() < 1e-3 && peak.re.abs() < 1e-3,
            "{peak}"
        );
    }
    let text: String = (0..1500)
        .map(f64::from)
        .map(|k| format!("{k},{:.5},{:.5}\n", (0.7 * k).sin(), (0.31 * k).cos()))
        .collect();
    let log = open::from_bytes("two.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
    assert!(log.responses.is_none());
    let options = ReadOptions {
        time_column: Some("column 1".into()),
        ..ReadOptions::default()
    };
    let asked = open::from_bytes(
        "frf.csv",
        table(1, |re, im| format!("{re},{im}")).as_bytes(),
        &options,
    );
    assert!(asked.unwrap().responses.is_none());
}

/// A table whose first line is 0 Hz, where a phase or a measured force may be nothing, gives the mode and no NaN.
#[test]
fn law_line_at_zero_hertz_gives_no_nan() {
    let kinds: [&dyn Fn(f64, f64) -> String; 2] =
        [&|re, im| format!("{re:e},{im:e}"), &|re, im| {
            format!("{:e},{:.6}", re.hypot(im), im.atan2(re))
        }];
    for (kind, at_zero) in kinds.iter().zip(["0,0,0\n", "0,0,3.141593\n"]) {
        for first in [table(0, kind), at_zero.to_string() + &table(1, kind)] {
            let log =
                open::from_bytes("frf.csv", first.as_bytes(), &ReadOptions::default()).unwrap();
            let responses = log.responses.unwrap();
            assert_eq!(responses.frequency_hz[0], 0.0);
            let study = IdentifyStudy {
                order: Some(1),
                ..IdentifyStudy::default()
            };
            let found = identify(IdentificationInput::Responses(responses), &study).unwrap();
            assert_eq!(found.modes.len(), 1);
            let mode = &found.modes[0];
            assert!((mode.frequency_hz() / 300.0 - 1.0).abs() < 1e-4);
            assert!(mode.mode.frequency_std_hz().unwrap().is_finite());
            assert!(found.fit_error.iter().all(|x| x.is_finite()));
        }
    }
}

/// What is no log is named, with the way to convert it.
#[test]
fn refuses_other_files_by_name() {
    let mut level_4 = Vec::new();
    for number in [0_u32, 100, 1, 0, 2] {
        level_4.extend(number.to_le_bytes());
    }
    level_4.extend(b"x\0");
    level_4.extend([0; 800]);
    let ide = [&b"\x1a\x45\xdf\xa3\x93\x42\x82\x84mide"[..], &[7; 100]].concat();
    let nodes =
        b"    -1\n  1858\n         1         1\n   0.0000E+00   0.0000E+00\n    -1\n".to_vec();
    let shapes = b"    -1\n   757\n         1         1\n         2         1\n    -1\n".to_vec();
    for (file, named, way) in [
        (level_4, "MATLAB file of level 4", "-v7"),
        (ide, "enDAQ .ide", "CSV"),
        (nodes, "no data set 58", "export"),
        (shapes, "no data set 58", "export"),
    ] {
        let errors = open::from_bytes("file", &file, &ReadOptions::default()).unwrap_err();
        let error = &errors.as_slice()[0];
        assert!(error.message.contains(named), "{}", error.message);
        assert!(
            error.hint.as_ref().is_some_and(|h| h.contains(way)),
            "{error:?}"
        );
    }
}

fn repair<'r>(log: &'r RawLog, kind: &str) -> Option<&'r str> {
    let found = log.repairs.iter().find(|r| r.kind == kind);
    found.map(|r| r.message.as_str())
}

fn rows(count: u32) -> String {
    let row = |k: u32| format!("{:.3},{:.4},{k}\n", f64::from(k) / 1e3, f64::from(k).sin());
    (0..count).map(row).collect()
}

/// A logger that was switched off leaves a row that breaks off, or storage that was never written: the rows before it are read.
#[test]
fn survives_a_last_row_that_breaks_off() {
    let text = format!("time,a,b\n{}", rows(300));
    for end in [
        "0.300,0.1",
        "0.300",
        "0.2",
        "0.300,0.1\n",
        "0.300,0.1,1.2e-",
        "0.300,0.1\0\0\0\0",
        "\0\0\0\0",
    ] {
        let file = format!("{text}{end}");
        let raw_log =
            open::from_bytes("log.csv", file.as_bytes(), &ReadOptions::default()).unwrap();
        let count = raw_log.groups[0].channels[0].samples.len();
        assert_eq!(count, 300, "{end:?}");
        let said = repair(&raw_log, "row-incomplete");
        assert!(
            said.is_some_and(|s| s.contains("line 302")),
            "{end:?}: {:?}",
            raw_log.repairs
        );
    }
    // Within the log the same is an error, and so is a word in the last row.
    let within = format!("{text}0.300,0.1\n0.301,1,2\n");
    let word = format!("{text}0.300,0.1,broken\n");
    for file in [within, word] {
        assert!(open::from_bytes("log.csv", file.as_bytes(), &ReadOptions::default()).is_err());
    }
}

/// NUL bytes within the rows are named with their line.
#[test]
fn refuses_nul_bytes_with_their_line() {
    let text = format!("time,a,b\n{}0.300,\0\0.5,2\n0.301,1,2\n", rows(300));
    let errors = open::from_bytes("log.csv", text.as_bytes(), &ReadOptions::default()).unwrap_err();
    let error = &errors.as_slice()[0];
    assert_eq!(error.message, "line 302 contains 2 NUL bytes");
}

/// A header that stands again between the rows is passed over; its notes may have changed.
#[test]
fn survives_a_header_repeated_between_the_rows() {
    let head = |time: &str| format!("# logger 7\n# start {time}\ntime,a,b\ns,g,g\n");
    let all = rows(400);
    let cut = all.match_indices('\n').nth(199).unwrap().0 + 1;
    let text = format!(
        "{}{}{}{}",
        head("10:00"),
        &all[..cut],
        head("10:05"),
        &all[cut..]
    );
    let raw_log = open::from_bytes("log.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!(raw_log.groups[0].channels[0].samples.len(), 400);
    let said = repair(&raw_log, "header-repeated").unwrap();
    assert!(said.contains("line 205"), "{said}");
    let other = format!(
        "{}{}{}{}",
        head("10:00"),
        &all[..cut],
        "other,names,here\n",
        &all[cut..]
    );
    assert!(open::from_bytes("log.csv", other.as_bytes(), &ReadOptions::default()).is_err());
}

/// The six responses of a measured beam without their line of names are the same responses.
/// Source: measured beam of sdypy-EMA, the same file with its names.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_beam_responses_without_names() {
    let folder = std::env::var("GEARDYN_RECORDINGS").unwrap();
    let path = std::path::Path::new(&folder).join("sdypy_ema_beam/sdypy_beam_frf_resp1.csv");
    let text = std::fs::read_to_string(path).unwrap();
    let read = |text: &str| {
        let log = open::from_bytes("beam.csv", text.as_bytes(), &ReadOptions::default()).unwrap();
        log.responses.unwrap()
    };
    let named = read(&text);
    let bare = read(text.split_once('\n').unwrap().1);
    assert_eq!(named.frequency_hz, bare.frequency_hz);
    let values =
        |f: &geardyn::internals::recording::frequency_responses::FrequencyResponses| -> Vec<_> {
            f.responses.iter().map(|f| f.values.clone()).collect()
        };
    assert_eq!(values(&named), values(&bare));
    assert_eq!(named.responses.len(), 6);
}

/// A log of three megabytes, whose rows several threads read, gives the samples, repairs, line numbers and errors that one thread gives:
/// with line ends of two bytes, blank lines, missing cells, joined thousands, a repeated header, text in a row, a footer, a last row that
/// breaks off.
#[test]
fn law_threads_read_the_same_log() {
    const ROWS: usize = 120_000;
    let row = |k: usize| {
        let x = k as f64;
        format!("{:.4},{:.6},{:.3}", 1e-4 * x, x.sin(), (0.1 * x).cos())
    };
    let plain: Vec<String> = (0..ROWS).map(row).collect();
    let changed = |changes: &[(usize, &str)]| {
        let mut rows = plain.clone();
        for (at, text) in changes {
            rows[*at] = (*text).to_string();
        }
        rows
    };
    let logs = [
        (changed(&[]), "\n", ""),
        (changed(&[]), "\r\n", "end of test\r\n"),
        (
            changed(&[
                (70_000, ""),
                (70_001, "7.0001,,0.5"),
                (100_000, "10.00,nan,0.5"),
            ]),
            "\n",
            "12.0,1.5",
        ),
        (
            changed(&[
                (90_000, "9.0,\"1,234.5\",2"),
                (90_001, "t [s],a,b"),
                (110_000, "11.0"),
            ]),
            "\n",
            "",
        ),
        (
            changed(&[(80_000, "8.0,x,1"), (100_000, "10.0,y,1")]),
            "\n",
            "",
        ),
        (changed(&[(80_000, "8.0,1,2,3")]), "\r\n", ""),
    ];
    let mut errors = 0;
    for (rows, end, last) in logs {
        let text = format!("t [s],a,b{end}{}{end}{last}", rows.join(end));
        let by = |threads: usize| {
            parallel::set_threads(threads);
            open::from_bytes("log.csv", text.as_bytes(), &ReadOptions::default())
                .map(|log| format!("{log:?}"))
                .map_err(|e| format!("{e:?}"))
        };
        let one = by(1);
        errors += usize::from(one.is_err());
        assert!(one == by(2), "{end:?} {last}");
    }
    assert_eq!(errors, 2);
}

/// A phase on lines too few or too uneven in their evidence had been read as a signal over time.
#[test]
fn refuses_tables_that_may_be_responses() {
    let levels = table(1, |re, im| {
        format!(
            "{:.4},{:.3}",
            20.0 * re.hypot(im).log10(),
            im.atan2(re).to_degrees()
        )
    });
    let few: String = levels
        .lines()
        .step_by(15)
        .map(|line| format!("{line}\n"))
        .collect();
    let wrapped: String = (0..400)
        .map(f64::from)
        .map(|k| {
            let phase = (37.0 * k + 40.0 * (0.9 * k * k).sin()).rem_euclid(360.0) - 180.0;
            format!("{k},{:.3},{phase:.2}\n", -20.0 + 3.0 * (1.7 * k).cos())
        })
        .collect();
    for text in [few, wrapped] {
        let read = open::from_bytes("frf.csv", text.as_bytes(), &ReadOptions::default());
        let errors = read.unwrap_err();
        let error = &errors.as_slice()[0];
        assert_eq!(error.code, Code::UnknownFormat);
        assert!(error.hint.as_ref().unwrap().contains("H1_phase_deg"));
    }
}

/// Two records in one file: the message names the line of the second header and the column that restarts.
#[test]
fn refuses_records_below_each_other() {
    let record: String = (0..200)
        .map(|k| format!("{:.3},{}\n", f64::from(k) * 1e-3, k % 7))
        .collect();
    let text = format!("time_s,a\n{record}time_s,a\n{record}");
    let error = settled("log.csv", text.as_bytes(), None).unwrap_err();
    let said = error.to_string();
    assert!(said.contains("line 202 repeats the header"), "{said}");
    assert!(
        said.contains("restarts: it goes back by 0.199000 s"),
        "{said}"
    );
}
