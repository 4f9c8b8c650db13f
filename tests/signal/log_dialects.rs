//! Text logs as labs export them: what must come out of each dialect, what is refused and where, and that nothing panics.

use std::io::Write;
use std::path::PathBuf;

use fastrand::Rng;
use geardyn::internals::base::code::Code;
use geardyn::internals::base::error::Error;
use geardyn::internals::recording::open;
use geardyn::internals::recording::preprocess::preprocess;
use geardyn::internals::recording::raw::{RawChannel, RawLog};
use geardyn::internals::recording::read_options::{RateSource, ReadOptions};
use geardyn::internals::recording::sample_column::SampleColumn;
use geardyn::internals::recording::signals::Recording;
use geardyn::internals::recording::stated_rates::StatedRate;

fn read(bytes: &[u8]) -> RawLog {
    let text = String::from_utf8_lossy(bytes).into_owned();
    open::from_bytes("log.csv", bytes, &ReadOptions::default())
        .unwrap_or_else(|e| panic!("{text}\n{e}"))
}

fn refused(text: &str) -> Error {
    refused_with(text, &ReadOptions::default())
}

fn refused_with(text: &str, options: &ReadOptions) -> Error {
    match open::from_bytes("log.csv", text.as_bytes(), options) {
        Ok(raw_log) => panic!("{text}\nread as {raw_log:?}"),
        Err(errors) => errors.as_slice()[0].clone(),
    }
}

fn samples(column: &SampleColumn) -> Vec<f64> {
    let mut samples = vec![0.0; column.len()];
    column.read(0, &mut samples).unwrap();
    samples
}

/// Everything a test looks at, in one line of text: `name [unit]=samples` by channel, `|` before another clock, `t=stamps` first.
fn summary(log: &RawLog) -> String {
    let numbers = |column: &SampleColumn| {
        let texts: Vec<String> = samples(column)
            .iter()
            .map(|x| format!("{}", (x * 1e9).round() / 1e9))
            .collect();
        texts.join(",")
    };
    let channel = |c: &RawChannel| format!("{} [{}]={}", c.name, c.unit, numbers(&c.samples));
    let groups: Vec<String> = log
        .groups
        .iter()
        .map(|group| {
            let time = group
                .timing
                .stamps
                .iter()
                .map(|s| format!("t={}", numbers(&s.seconds)));
            let channels = group.channels.iter().map(channel);
            time.chain(channels).collect::<Vec<_>>().join(" ")
        })
        .collect();
    groups.join(" | ")
}

fn repairs(log: &RawLog) -> Vec<&str> {
    log.repairs.iter().map(|r| r.kind).collect()
}

/// One text for each dialect, with what must come out.
const DIALECTS: &[(&str, &str, &str)] = &[
    // delimiters, decimal marks, units
    (
        "comma, unit after _",
        "time_s,accel_x_g\r\n0.003,1\r\n0.006,2\r\n",
        "t=0,0.003 accel_x_g [g]=1,2",
    ),
    (
        "trailing comma, brackets",
        "Time (s),X (m/s2),Y [g]\n0.0,1,2,\n0.5,3,4E-1,\n",
        "t=0,0.5 X [m/s2]=1,3 Y [g]=2,0.4",
    ),
    (
        "trailing comma in both",
        "t,a,\n0,1,\n1,2,\n",
        "t=0,1 a []=1,2",
    ),
    (
        "semicolon, decimal comma",
        "Zeit [ms];Kraft / N\n0,0;1,5\n0,5;-2,5e1\n",
        "t=0,0.0005 Kraft [N]=1.5,-25",
    ),
    (
        "semicolon, point, no time",
        "L1;L2\n-0.5;0.25\n0.5;1\n",
        "L1 []=-0.5,0.5 L2 []=0.25,1",
    ),
    (
        "tab, units row, micro sign",
        "t\tx\ts\nms\tµm\tV\n0\t1\t2\n1\t2\t3\n",
        "t=0,0.001 x [µm]=1,2 s [V]=2,3",
    ),
    (
        "units row in brackets",
        "Time;Acc\n[s];[m/s²]\n0;1\n1;2\n",
        "t=0,1 Acc [m/s²]=1,2",
    ),
    (
        "bars",
        "time|a|b\n0|1|2\n1|3|4\n",
        "t=0,1 a []=1,3 b []=2,4",
    ),
    (
        "blanks, aligned",
        "  time      a\n   0.0    1.0\n   0.5   -2.0  \n",
        "t=0,0.5 a []=1,-2",
    ),
    (
        "comma and blank",
        "time, a [g], b\n0, 1, 2\n1, 3, 4\n",
        "t=0,1 a [g]=1,3 b []=2,4",
    ),
    (
        "one column, decimal comma",
        "0,123\n-0,5\n0,045\n",
        "column 1 []=0.123,-0.5,0.045",
    ),
    ("one column, name", "acc [g]\n1\n2\n3\n", "acc [g]=1,2,3"),
    (
        "thousands and comma",
        "t;x\n0;1.234,5\n1;12.345.678\n",
        "t=0,1 x []=1234.5,12345678",
    ),
    (
        "thousands and point",
        "t;x\n0;1,234.5\n1;-2,000.25\n",
        "t=0,1 x []=1234.5,-2000.25",
    ),
    (
        "thousands by apostrophe",
        "t;x\n0;1'234.5\n1;2'000.5\n",
        "t=0,1 x []=1234.5,2000.5",
    ),
    (
        "quoted decimal comma",
        "\"t\",\"x\"\n\"0,0\",\"1,5\"\n\"0,5\",\"2,5\"\n",
        "t=0,0.5 x []=1.5,2.5",
    ),
    (
        "quoted names with delimiters",
        "\"time\",\"force, left (N)\",\"a \"\"b\"\"\"\n0,1,2\n1,2,3\n",
        "t=0,1 force, left [N]=1,2 a \"b\" []=2,3",
    ),
    // header
    (
        "no header",
        "-0.5,0.25,1\n0.5,0.75,-1\n",
        "column 1 []=-0.5,0.5 column 2 []=0.25,0.75 column 3 []=1,-1",
    ),
    (
        "key,value",
        "Sample rate,5000,Hz\nDate,2022\n\ntime,a\n0,1\n1,2\n",
        "t=0,1 a []=1,2",
    ),
    (
        "key: value",
        "Operator: N. N.\nfs: 100\nNotes: a, b, c\na,b\n1,2\n3,4\n",
        "a []=1,3 b []=2,4",
    ),
    (
        "comments",
        "# made by hand\n# fs = 10 Hz\n# a\tb\n1\t2\n3\t4\n",
        "a []=1,3 b []=2,4",
    ),
    (
        "slashes and per cent",
        "// note\n% note\nt,a\n0,1\n1,2\n",
        "t=0,1 a []=1,2",
    ),
    (
        "channel numbers above names",
        "1,2,3\nt,a,b\n0,5,6\n1,7,8\n",
        "t=0,1 a []=5,7 b []=6,8",
    ),
    (
        "offsets row, time last",
        "C:\\x\\y.txt\nSampling Frequency - 5000\nTue, Jul 19, 2022 11:02 PM\nAccel\tPin\tTime\nVoltage (unscaled)\tVoltage (unscaled)\tSec\n0.0 0.0 0\t\t0.0 0.0\t\n\n1E-3\t2\t0.00000E+0\n2E-3\t3\t2.00000E-4\n",
        "t=0,0.0002 Accel [Voltage (unscaled)]=0.001,0.002 Pin [Voltage (unscaled)]=2,3",
    ),
    ("a single row", "t,a\n0,1\n", "t=0 a []=1"),
    (
        "names repeat",
        "t,a,a\n0,1,2\n1,3,4\n",
        "t=0,1 a []=1,3 a 2 []=2,4",
    ),
    // line ends
    ("CR alone", "t,a\r0,1\r1,2\r", "t=0,1 a []=1,2"),
    (
        "mixed line ends, no last one",
        "t,a\r\n0,1\n1,2\r2,3",
        "t=0,1,2 a []=1,2,3",
    ),
    (
        "blank lines",
        "\n\nt,a\n\n0,1\n\n\n1,2\n\n",
        "t=0,1 a []=1,2",
    ),
    // cells
    (
        "missing and overloads",
        "t,a\n0,NaN\n1,\n2,-1.#IND\n3,***\n4,∞\n5,OVERLOAD\n6,7\n",
        "t=0,1,2,3,4,5,6 a []=NaN,NaN,NaN,NaN,NaN,NaN,7",
    ),
    (
        "over and under",
        "t;a\n0;Over\n1;-OVL\n2;5\n",
        "t=0,1,2 a []=NaN,NaN,5",
    ),
    (
        "three-digit exponents",
        "t,a\n0,1.5E+003\n1,-2.5e-001\n2,1.5-100\n",
        "t=0,1,2 a []=1500,-0.25,0",
    ),
    (
        "rows with only a time",
        "t,a,b\n0,1,2\n1\n2,3,4\n",
        "t=0,1,2 a []=1,NaN,3 b []=2,NaN,4",
    ),
    (
        "empty columns at the end",
        "t,a,,\n0,1,,\n1,2,,\n",
        "t=0,1 a []=1,2",
    ),
    (
        "a column of words",
        "t,a,state\n0,1,ok\n1,2,bad one\n",
        "t=0,1 a []=1,2",
    ),
    (
        "footer",
        "t,a\n0,1\n1,2\n2,3\nEnd of record\nmean,2\n",
        "t=0,1,2 a []=1,2,3",
    ),
    (
        "blank rows at the end",
        "t,a\n0,1\n1,2\n,\n,\n",
        "t=0,1 a []=1,2",
    ),
    // stamps
    ("µs", "Time [µs],a\n0,1\n250,2\n", "t=0,0.00025 a []=1,2"),
    (
        "ISO with T and Z",
        "timestamp,a\n2022-11-04T08:36:24.897Z,1\n2022-11-04T08:36:24.907Z,2\n",
        "t=0,0.01 a []=1,2",
    ),
    (
        "ISO without fraction",
        "Time (-),a [g]\n2022-12-31 23:59:59,1\n2023-01-01 00:00:00,2\n",
        "t=0,1 a [g]=1,2",
    ),
    (
        "clock over midnight",
        "clock;a\n23:59:59.5;1\n00:00:00.5;2\n",
        "t=0,1 a []=1,2",
    ),
    (
        "local date, decimal comma",
        "Datum;a\n01.02.2023 12:00:00,5;1,5\n02.02.2023 12:00:00,5;2,5\n",
        "t=0,86400 a []=1.5,2.5",
    ),
    (
        "date and clock apart",
        "Date;Time;a\n01.02.2023;12:00:00,005;1,5\n01.02.2023;12:00:00,010;2,5\n",
        "t=0,0.005 a []=1.5,2.5",
    ),
    (
        "month first by the data",
        "date,a\n1/31/2023 23:00:00,1\n2/1/2023 01:00:00,2\n",
        "t=0,7200 a []=1,2",
    ),
    (
        "epoch in ms",
        "timestamp,a\n1657065123000,1\n1657065123005,2\n",
        "t=0,0.005 a []=1,2",
    ),
    (
        "several clocks",
        "time1,a,time2,b\n0,1,0,5\n1,2,0.5,6\n2,3,,\n",
        "t=0,1,2 a []=1,2,3 | t=0,0.5 b []=5,6",
    ),
    (
        "a counter and the rate",
        "fs: 100\nsample,a\n0,5\n1,6\n2,7\n",
        "t=0,0.01,0.02 a []=5,6,7",
    ),
    (
        "a counter without rate",
        "n,a\n1,5\n2,6\n3,7\n",
        "a []=5,6,7",
    ),
    (
        "Chinese",
        "时间(s),加速度(g)\n0,1\n0.1,2\n",
        "t=0,0.1 加速度 [g]=1,2",
    ),
];

/// Each dialect gives its channels, units, stamps and samples.
#[test]
fn exact_each_dialect_of_the_table() {
    let mut wrong = String::new();
    for (name, text, right) in DIALECTS {
        let got = match open::from_bytes("log.csv", text.as_bytes(), &ReadOptions::default()) {
            Ok(raw_log) => format!("{}   <{}>", summary(&raw_log), raw_log.dialect),
            Err(errors) => errors.to_string(),
        };
        if got.split("   <").next() != Some(right) {
            wrong.push_str(&format!("{name}\n  got   {got}\n  right {right}\n"));
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// Byte-order marks, UTF-16 of both kinds, GBK and Latin-1 give the same names as UTF-8.
#[test]
fn exact_encodings_give_the_same_names() {
    let text = "Zeit [s];Größe [µm]\n0;1,5\n1;2,5\n";
    let right = "t=0,1 Größe [µm]=1.5,2.5";
    let wide = |bytes: fn(u16) -> [u8; 2]| text.encode_utf16().flat_map(bytes).collect::<Vec<u8>>();
    let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
    let marked = |mark: &[u8], bytes: &[u8]| [mark, bytes].concat();
    let cases = [
        (text.as_bytes().to_vec(), "UTF-8"),
        (marked(b"\xef\xbb\xbf", text.as_bytes()), "byte-order mark"),
        (latin, "Latin-1"),
        (wide(u16::to_le_bytes), "UTF-16LE"),
        (wide(u16::to_be_bytes), "UTF-16BE"),
        (marked(b"\xff\xfe", &wide(u16::to_le_bytes)), "UTF-16LE"),
        (marked(b"\xfe\xff", &wide(u16::to_be_bytes)), "UTF-16BE"),
    ];
    for (bytes, word) in cases {
        let log = read(&bytes);
        assert_eq!(summary(&log), right, "{word}");
        assert!(log.dialect.contains(word), "{word}: {}", log.dialect);
    }
    // 时间,加速度 in GBK.
    let gbk = b"\xca\xb1\xbc\xe4,\xbc\xd3\xcb\xd9\xb6\xc8\n0,1\n1,2\n";
    assert_eq!(summary(&read(gbk)), "t=0,1 加速度 []=1,2");
}

/// Rows with other marks above those that were read are told, with their lines.
#[test]
fn exact_rows_of_another_dialect_are_reported() {
    let rows = |from: usize, form: &dyn Fn(usize) -> String| -> String {
        (from..from + 40).map(form).collect()
    };
    let commas = rows(0, &|k| format!("{}.000,{}.5\n", k, k + 1));
    let semicolons = rows(40, &|k| format!("{}.000;{}.5\n", k, k + 1));
    let log = read(format!("t,a\n{commas}{semicolons}{semicolons}").as_bytes());
    assert_eq!(repairs(&log), ["rows-of-another-dialect"]);
    let message = &log.repairs[0].message;
    assert!(
        message.starts_with("40 rows") && message.contains("lines 2 to 41"),
        "{message}"
    );
    let alone = read(format!("t;a\n{semicolons}").as_bytes());
    assert!(repairs(&alone).is_empty());
}

/// What was passed over is said, and overloads are counted.
#[test]
fn exact_repairs_are_reported() {
    let log = read(b"t,a\n0,Over\n1,\n2,5\nEnd\n");
    assert_eq!(repairs(&log), ["footer-skipped", "cells-missing"]);
    let message = &log.repairs[1].message;
    assert!(
        message.contains("2 cells of `a`")
            && message.contains("1 of them overloads")
            && message.contains("lines 2, 3"),
        "{message}"
    );
    assert_eq!(log.groups[0].channels[0].overloads, 1);
    assert!(
        log.repairs[0].message.contains("line 5"),
        "{:?}",
        log.repairs[0]
    );
    let log = read(b"fs: 100\n\nt,a\n0,1\n\n1,2\n");
    let clock = &log.groups[0].timing;
    assert_eq!(
        clock.stated_rates,
        [StatedRate::is_sample_rate(100.0, "fs")]
    );
    for head in ["sr: 100", "# sr = 100 Hz"] {
        let log = read(format!("{head}\nt,a\n0,1\n1,2\n").as_bytes());
        assert_eq!(
            log.groups[0].timing.stated_rates,
            [StatedRate::is_sample_rate(100.0, "sr")]
        );
    }
    assert_eq!(
        (clock.lines.line_of_row(0), clock.lines.line_of_row(1)),
        (Some(4), Some(6))
    );
    assert_eq!(log.dialect, "CSV, comma, 3 header lines");
    let log = read(b"Samples: 12\nDate: 2022-01-02\nt,a\n0.001,1\n0.002,2\n0.003,1\n");
    let clock = &log.groups[0].timing;
    assert_eq!(
        (clock.header_samples, clock.start.as_deref()),
        (Some(12), Some("2022-01-02"))
    );
    assert_eq!(
        clock.stamps.as_ref().map(|s| s.resolution.finest_s),
        Some(1e-3)
    );
}

/// Complex cells, real and imaginary parts, magnitude and phase are frequency responses.
#[test]
fn exact_tables_over_frequency() {
    let texts = [
        "frequency_Hz,H1_re,H1_im,H2_re,H2_im\n1,0.5,-0.5,3,4\n2,1,2,5,6\n",
        "Frequency [Hz];Re(H1);Im(H1);Re(H2);Im(H2)\n1;0,5;-0,5;3;4\n2;1;2;5;6\n",
        "f\tH1\tH2\n1\t0.5-0.5i\t3+4i\n2\t1+2i\t(5+6j)\n",
        "f,H1_real,H2_real,H1_imag,H2_imag\n1,0.5,3,-0.5,4\n2,1,5,2,6\n",
    ];
    for text in texts {
        let found = read(text.as_bytes()).responses.unwrap();
        assert_eq!(found.frequency_hz, [1.0, 2.0], "{text}");
        let value = |i: usize, k: usize| {
            (
                found.responses[i].values[k].re,
                found.responses[i].values[k].im,
            )
        };
        assert_eq!(
            (value(0, 0), value(0, 1)),
            ((0.5, -0.5), (1.0, 2.0)),
            "{text}"
        );
        assert_eq!(
            (value(1, 0), value(1, 1)),
            ((3.0, 4.0), (5.0, 6.0)),
            "{text}"
        );
        assert_eq!(found.responses[1].output.name, "H2", "{text}");
    }
    let found = read(b"freq (Hz),Mag (dB),Phase (deg),Coherence\n1,20,90,0.5\n2,0,180,1\n")
        .responses
        .unwrap();
    let value = found.responses[0].values[0];
    assert!(
        value.re.abs() < 1e-14 && (value.im - 10.0).abs() < 1e-14,
        "{value}"
    );
    assert_eq!(found.responses[0].coherence, Some(vec![0.5, 1.0]));
}

/// What is wrong is refused by its code, at its line and cell.
#[test]
fn refuses_what_is_wrong_at_its_place() {
    let cases: &[(&str, Code, usize, &str)] = &[
        ("t,a\n0,1\n1,abc\n2,3\n", Code::NotANumber, 3, "abc"),
        ("t,a\n0,1\n1,2\n2,abc\n", Code::NotANumber, 4, "abc"),
        ("t,a\n0,1\n1,2,9\n2,3\n", Code::RaggedRow, 3, "9"),
        ("t,a,b\n0,1,1\n1,2\n2,3,4\n", Code::RaggedRow, 3, "1,2"),
        ("t,a,b\n0,1,1\n1,2,3\n2,3,4,5\n", Code::RaggedRow, 4, "5"),
        ("t,a\n0,1\nx,2\n2,3\n3,4\n", Code::NotANumber, 3, "x"),
        ("1,2\n1,2,3\n2,3,4\n3,4,5\n", Code::RaggedRow, 1, "1,2"),
        ("a,b\n1,x\n1,2\n1,2\n1,2\n", Code::NotANumber, 2, "x"),
        ("größe;b\n1;2\n1;ä ö\n3;4\n", Code::NotANumber, 3, "ä ö"),
        ("t,a\n0,1\n1,1e400\n2,1\n", Code::NotANumber, 3, "1e400"),
        (
            "date,a\n03/04/2023 1:00,1\n05/07/2023 1:00,2\n",
            Code::InvalidTimeStamps,
            3,
            "05/07/2023 1:00",
        ),
    ];
    for (text, code, line, cell) in cases {
        let error = refused(text);
        assert_eq!(error.code, *code, "{text}{error}");
        let place = error
            .span
            .clone()
            .unwrap_or_else(|| panic!("{text}{error}"));
        assert_eq!(
            (place.line(), place.text()),
            (*line, *cell),
            "{text}{error}"
        );
    }
    for text in [
        "",
        "\n \n",
        "t,a\n",
        "t,a\n,\n,\n",
        "# only a note\n",
        "time\n0\n1\n2\n",
    ] {
        assert_eq!(refused(text).code, Code::EmptyLog, "{text:?}");
    }
    assert_eq!(
        refused("\u{0}\u{1}\u{2}PNG\u{3}\u{4}").code,
        Code::UnknownFormat
    );
    assert_eq!(refused("(1+2j)\n(2+3j)\n(3-4j)\n").code, Code::NotANumber);
    assert_eq!(
        refused("f,H_re,H_im\n2,1,1\n2,1,1\n").code,
        Code::CorruptFile
    );
}

/// Settings are followed, and a name that is not there is refused with what was meant.
#[test]
fn exact_settings_are_followed() {
    let text = "time;acc_x;acc_y;force\n0;1,234;2;5\n1;2,345;3;6\n";
    let with = |change: fn(&mut ReadOptions)| {
        let mut options = ReadOptions::default();
        change(&mut options);
        open::from_bytes("log.csv", text.as_bytes(), &options)
    };
    let only = with(|s| s.keep_channels = vec!["force".into(), "acc_x".into()]).unwrap();
    assert_eq!(summary(&only), "t=0,1 force []=5,6 acc_x []=1.234,2.345");
    let point = with(|s| s.dialect.decimal = Some('.')).unwrap();
    assert_eq!(
        summary(&point),
        "t=0,1 acc_x []=1234,2345 acc_y []=2,3 force []=5,6"
    );
    let none = with(|s| s.time_column = Some("none".into())).unwrap();
    assert!(none.groups[0].timing.stamps.is_none() && none.groups[0].channels.len() == 4);
    let other =
        with(|s| (s.time_column, s.time_unit) = (Some("force".into()), Some("ms".into()))).unwrap();
    assert!(
        summary(&other).starts_with("t=0,0.001 time []=0,1"),
        "{}",
        summary(&other)
    );
    let later = with(|s| s.dialect.header_lines = Some(2)).unwrap();
    assert_eq!(later.groups[0].channels[0].samples.len(), 1);
    let error = with(|s| s.keep_channels = vec!["acc_z".into()])
        .unwrap_err()
        .as_slice()[0]
        .clone();
    assert_eq!(error.code, Code::NoChannel);
    assert!(
        error.hint.clone().unwrap_or_default().contains("acc_"),
        "{error}"
    );
    assert!(with(|s| s.dialect.encoding = Some("klingon".into())).is_err());
    let options = ReadOptions {
        rate: Some(RateSource::Hertz(10.0)),
        ..ReadOptions::default()
    };
    let counted = open::from_bytes("log.csv", b"n,a\n1,5\n2,6\n", &options).unwrap();
    assert_eq!(summary(&counted), "t=0,0.1 a []=5,6");
}

/// Two columns of time: channels of equal stamps are taken together; of others the second is left aside, told, and not mixed with the first.
#[test]
fn keeps_clocks_apart() {
    let log = |late_s: f64| {
        let row = |k: i32| {
            let t = f64::from(k) * 1e-3;
            format!("{t:.6},{},{:.6},{}\n", k % 7, t + late_s, k % 5)
        };
        let rows: String = (0..200).map(row).collect();
        format!("t1 [s],F [N],t2 [s],a [g]\n{rows}")
    };
    let both = ReadOptions {
        keep_channels: vec!["F".into(), "a".into()],
        ..ReadOptions::default()
    };
    let settled = |text: &str, options: &ReadOptions| preprocess(read(text.as_bytes()), options);
    let names = |recording: &Recording| -> Vec<String> {
        recording.channels.iter().map(|c| c.name.clone()).collect()
    };
    let together = settled(&log(0.0), &ReadOptions::default()).unwrap();
    assert_eq!(names(&together), ["F", "a"]);
    assert!(together.diagnostics.is_empty());
    let apart = settled(&log(2.5e-4), &ReadOptions::default()).unwrap();
    assert_eq!(names(&apart), ["F"]);
    assert_eq!(apart.diagnostics[0].code, "another-clock");
    assert!(
        apart.diagnostics[0]
            .message
            .contains("200 samples by another clock")
    );
    let error = settled(&log(2.5e-4), &both).unwrap_err();
    assert_eq!(error.code, Code::Conflict);
    assert!(error.message.contains("begin or end apart"), "{error}");
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut writer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    writer.write_all(bytes).unwrap();
    writer.finish().unwrap()
}

fn zipped(members: &[(&str, &[u8])]) -> Vec<u8> {
    let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
    for (name, bytes) in members {
        archive
            .start_file(*name, zip::write::SimpleFileOptions::default())
            .unwrap();
        archive.write_all(bytes).unwrap();
    }
    archive.finish().unwrap().into_inner()
}

/// gzip and zip, also in each other and under any name.
#[test]
fn exact_containers() {
    let text = b"t,a\n0,1\n1,2\n";
    let right = "t=0,1 a []=1,2";
    assert_eq!(summary(&read(&gzip(text))), right);
    assert_eq!(summary(&read(&zipped(&[("a/b.csv.zip", text)]))), right);
    assert_eq!(
        summary(&read(&zipped(&[("readme.md", b"words"), ("b.csv", text)]))),
        right
    );
    assert_eq!(summary(&read(&zipped(&[("b.csv.gz", &gzip(text))]))), right);
    assert_eq!(summary(&read(&gzip(&zipped(&[("b", text)])))), right);
    let code = |bytes: &[u8]| {
        open::from_bytes("log", bytes, &ReadOptions::default())
            .unwrap_err()
            .as_slice()[0]
            .code
    };
    assert_eq!(
        code(&zipped(&[("a.csv", text), ("b.csv", text)])),
        Code::UnknownFormat
    );
    assert_eq!(code(&zipped(&[])[..]), Code::UnknownFormat);
    let long = text.repeat(1000);
    let packed = gzip(&long);
    assert_eq!(code(&packed[..packed.len() - 9]), Code::CorruptFile);
    assert_eq!(code(&packed[..5]), Code::CorruptFile);
    assert_eq!(code(&gzip(b"")), Code::EmptyLog);
    let archive = zipped(&[("a.csv", &long)]);
    assert_eq!(code(&archive[..archive.len() / 2]), Code::CorruptFile);
}

/// A log longer than several blocks: every sample is there and on its line, whatever the line ends.
#[test]
fn exact_long_logs_over_block_boundaries() {
    for end in ["\n", "\r\n", "\r"] {
        let mut text = format!("time,a,b{end}");
        let n = 150_000;
        for i in 0..n {
            text.push_str(&format!(
                "{:.4},{},{}{end}",
                i as f64 * 1e-4,
                i,
                -0.5 * i as f64
            ));
        }
        let log = read(text.as_bytes());
        let group = &log.groups[0];
        assert_eq!(group.timing.stamps.as_ref().unwrap().seconds.len(), n);
        let a = samples(&group.channels[0].samples);
        assert!(a.len() == n && a.iter().enumerate().all(|(i, x)| *x == i as f64));
        assert_eq!(group.timing.lines.line_of_row(n - 1), Some(n + 1));
        text.truncate(text.len() - end.len());
        text.push_str(",7");
        let error = refused(&text);
        assert_eq!(
            (error.code, error.span.unwrap().line()),
            (Code::RaggedRow, n + 1)
        );
    }
}

/// Inputs made from the table by cutting, doubling, swapping and overwriting; every one ends in an answer or an error.
fn mutate(rng: &mut Rng, seeds: &[Vec<u8>]) -> Vec<u8> {
    const PIECES: &[&[u8]] = &[
        b",",
        b";",
        b"\t",
        b"\n",
        b"\r\n",
        b"\r",
        b"\"",
        b"'",
        b"\0",
        b"\xff\xfe",
        b"\xef\xbb\xbf",
        b"NaN",
        b"1e999",
        b"-",
        b".",
        b"0",
        b"9999999999999999999",
        b"1/2/2023",
        b"12:00:00",
        b"i",
        b"(",
        b")",
        b"time",
        b"[s]",
        b"Hz",
        b"#",
        b" ",
        b"\xb0C",
        b"fs: 1e-300",
        b"2022-02-30",
        b"Over",
        b"\xe2\x88\x92",
        b"1,234.5",
    ];
    let mut bytes = rng.choice(seeds).cloned().unwrap_or_default();
    for _ in 0..rng.usize(1..6) {
        let at = rng.usize(0..=bytes.len());
        let to = rng.usize(at..=bytes.len().min(at + 12));
        match rng.u8(0..6) {
            0 => drop(bytes.drain(at..to)),
            1 => {
                let piece = rng.choice(PIECES).copied().unwrap_or_default();
                drop(bytes.splice(at..at, piece.iter().copied()));
            }
            2 => bytes
                .iter_mut()
                .skip(at)
                .take(1)
                .for_each(|b| *b = rng.u8(..)),
            3 => {
                let part = bytes[at..to].to_vec();
                let to = rng.usize(0..=bytes.len());
                drop(bytes.splice(to..to, part));
            }
            4 => bytes.truncate(at),
            _ => {
                let other = rng.choice(seeds).cloned().unwrap_or_default();
                let from = rng.usize(0..=other.len());
                bytes.truncate(at);
                bytes.extend_from_slice(&other[from..]);
            }
        }
    }
    bytes
}

fn fuzz(seed: u64, count: usize) {
    let mut seeds: Vec<Vec<u8>> = DIALECTS.iter().map(|d| d.1.as_bytes().to_vec()).collect();
    seeds.push(b"f,H_re,H_im\n1,2,3\n2,3,4\n".to_vec());
    seeds.push(b"f;Mag (dB);Phase;coh\n1;2;3;1\n2;3;4;1\n".to_vec());
    seeds.push(b"f,H\n1,2+3i\n2,3-4i\n".to_vec());
    seeds.push(gzip(b"t,a\n0,1\n1,2\n"));
    seeds.push(zipped(&[("a.csv", b"t,a\n0,1\n1,2\n")]));
    seeds.push(
        "t;a\n0;1,5\n"
            .encode_utf16()
            .flat_map(u16::to_le_bytes)
            .collect(),
    );
    let mut rng = Rng::with_seed(seed);
    for at in 0..count {
        let bytes = mutate(&mut rng, &seeds);
        let mut options = ReadOptions::default();
        if rng.u8(0..8) == 0 {
            options.dialect.delimiter = rng.choice([',', ';', ' ', '\t', 'x', 'é']);
            options.dialect.decimal = rng.choice(['.', ',', 'é']);
            options.dialect.header_lines = Some(rng.usize(0..5));
            options.time_column = rng.choice(["none", "a", "time"]).map(str::to_string);
            options.keep_channels = rng
                .choice(["a", "b", "time"])
                .map(|c| vec![c.to_string()])
                .unwrap_or_default();
        }
        let outcome = std::panic::catch_unwind(|| open::from_bytes("log", &bytes, &options));
        let result = outcome.unwrap_or_else(|_| {
            panic!(
                "seed {seed}, input {at}: {:?}",
                String::from_utf8_lossy(&bytes)
            )
        });
        if let Ok(raw_log) = result {
            for group in &raw_log.groups {
                let n = group.channels[0].samples.len();
                assert!(
                    group.channels.iter().all(|c| c.samples.len() == n),
                    "seed {seed}, input {at}"
                );
            }
        }
    }
}

#[test]
fn survives_mutated_logs() {
    fuzz(1, 20_000);
}

#[test]
#[ignore = "study: millions of mutated logs"]
fn survives_millions_of_mutated_logs() {
    let count = std::env::var("GEARDYN_FUZZ")
        .ok()
        .and_then(|n| n.parse().ok());
    fuzz(fastrand::u64(..), count.unwrap_or(3_000_000));
}

/// The folder of measured logs.
fn recordings() -> PathBuf {
    PathBuf::from(std::env::var("GEARDYN_RECORDINGS").expect("set GEARDYN_RECORDINGS"))
}

/// File, rows, channels, rate in the header, whether there are stamps.
const RECORDINGS: &[(&str, usize, usize, Option<f64>, bool)] = &[
    (
        "pimodal_cnc_tap/tap_20260622_163222.csv",
        2652,
        3,
        None,
        true,
    ),
    (
        "cessipy_smartphone/Example02_Smartphone_Data.csv",
        25_291,
        3,
        None,
        true,
    ),
    (
        "dropbear/slow_10steps_test8.txt",
        70_000,
        3,
        Some(5000.0),
        true,
    ),
    (
        "dropbear/slow_10steps_test1.txt",
        70_000,
        3,
        Some(5000.0),
        true,
    ),
    (
        "dropbear/random_set0_test0.txt",
        60_000,
        5,
        Some(5000.0),
        true,
    ),
    (
        "koma_shearframe/koma_shearframe.csv",
        14_400,
        5,
        None,
        false,
    ),
    ("f16_vibration/f-16.txt", 32_768, 3, None, false),
    ("munich_bridge/AllM100Hz.csv.zip", 72_000, 4, None, true),
    (
        "munich_bridge/ReferenceStateINCAt100Hz.csv.zip",
        60_000,
        2,
        None,
        true,
    ),
];

/// Measured text logs: rows, channels and rates.
/// Source: measured files, their rows and rates as published.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_recordings_are_read_whole() {
    let folder = recordings();
    for (file, rows, channels, rate, stamped) in RECORDINGS {
        let path = folder.join(file);
        let log = open::open(&path.display().to_string(), &ReadOptions::default())
            .unwrap_or_else(|e| panic!("{e}"));
        let group = &log.groups[0];
        let lengths: Vec<usize> = group.channels.iter().map(|c| c.samples.len()).collect();
        assert_eq!(lengths, vec![*rows; *channels], "{file}: {}", log.dialect);
        assert_eq!(
            group.timing.stated_rates.first().map(|r| r.hertz),
            *rate,
            "{file}"
        );
        assert_eq!(group.timing.stamps.is_some(), *stamped, "{file}");
        assert!(
            log.repairs.is_empty() && log.diagnostics.is_empty(),
            "{file}: {:?} {:?}",
            log.repairs,
            log.diagnostics
        );
    }
    let table = open::open(
        &folder
            .join("sdypy_ema_beam/sdypy_beam_frf_resp1.csv")
            .display()
            .to_string(),
        &ReadOptions::default(),
    );
    let table = table.unwrap_or_else(|e| panic!("{e}")).responses.unwrap();
    assert_eq!(
        (
            table.responses.len(),
            table.responses[5].output.name.as_str()
        ),
        (6, "H6")
    );
    assert!(table.frequency_hz.len() > 9000);
    for (file, code) in [
        ("pyuff_samples/meas_point_1.txt", Code::NotANumber),
        ("pimodal_cnc_tap/tap_20260622_163222.txt", Code::EmptyLog),
    ] {
        let errors = open::open(
            &folder.join(file).display().to_string(),
            &ReadOptions::default(),
        )
        .unwrap_err();
        assert_eq!(errors.as_slice()[0].code, code, "{errors}");
    }
}

#[test]
#[ignore = "study: megabytes a second"]
fn survives_a_large_log_in_bounded_memory() {
    let mut text = String::from("time_s,a_g,b_g,c_g,d_g\n");
    let mut rng = Rng::with_seed(7);
    for i in 0..2_000_000 {
        let mut x = || rng.f64() * 20.0 - 10.0;
        text.push_str(&format!(
            "{:.5},{:.6},{:.6},{:.6},{:.6}\n",
            f64::from(i) * 2e-5,
            x(),
            x(),
            x(),
            x()
        ));
    }
    for (what, only) in [
        ("all channels", vec![]),
        ("one channel", vec!["c_g".to_string()]),
    ] {
        let options = ReadOptions {
            keep_channels: only,
            ..ReadOptions::default()
        };
        let start = std::time::Instant::now();
        let raw_log = open::from_bytes("log.csv", text.as_bytes(), &options).unwrap();
        let seconds = start.elapsed().as_secs_f64();
        let megabytes = text.len() as f64 / 1e6;
        eprintln!(
            "{what}: {:.0} MB in {seconds:.3} s: {:.0} MB/s",
            megabytes,
            megabytes / seconds
        );
        assert_eq!(raw_log.groups[0].channels[0].samples.len(), 2_000_000);
    }
}

fn channel_names(text: &str, only: &[&str]) -> Vec<String> {
    let options = ReadOptions {
        keep_channels: only.iter().map(ToString::to_string).collect(),
        ..ReadOptions::default()
    };
    let raw_log = open::from_bytes("log.csv", text.as_bytes(), &options).unwrap();
    let channels = raw_log.groups.iter().flat_map(|g| &g.channels);
    channels.map(|c| c.name.clone()).collect()
}

/// The name that `check` gives to the second of two columns finds it.
#[test]
fn exact_second_column_of_a_name() {
    let text = "t [s],a,a,b\n0,1,2,3\n1,4,5,6\n2,7,8,9\n";
    assert_eq!(channel_names(text, &[]), ["a", "a 2", "b"]);
    let options = ReadOptions {
        keep_channels: vec!["a 2".into()],
        ..ReadOptions::default()
    };
    let raw_log = open::from_bytes("log.csv", text.as_bytes(), &options).unwrap();
    let channel = &raw_log.groups[0].channels[0];
    assert_eq!(channel.name, "a 2");
    assert_eq!(samples(&channel.samples), [2.0, 5.0, 8.0]);
}

/// Line ends inside quoted names; one name with a unit over columns without names; the lines of rows stay those of the file.
#[test]
fn exact_names_over_several_lines() {
    let text = "\"t [s]\";\"a\nforce\";b\n0;1;2\n1;3;4\n2;5;6\n";
    assert_eq!(channel_names(text, &[]), ["a force", "b"]);
    let error = refused(&text.replace("3;4", "3;x"));
    assert_eq!(error.span.map(|p| p.line()), Some(4));
    let log = read(b"t [s],,,\n0,1,2,3\n0.1,4,5,6\n0.2,4,5,6\n");
    assert!(log.groups[0].timing.stamps.is_some());
    assert_eq!(log.groups[0].channels.len(), 3);
}

/// Dates of no calendar, hours of no day, and dates against what was stated.
#[test]
fn refuses_dates_that_cannot_be() {
    let log = |second: &str| format!("time,a\n2023-02-28 10:00:00,1\n{second},2\n");
    assert!(
        open::from_bytes(
            "log.csv",
            log("2023-02-28 10:00:01").as_bytes(),
            &ReadOptions::default()
        )
        .is_ok()
    );
    for wrong in [
        "2023-02-30 10:00:01",
        "2023-02-28T25:00:00",
        "2023-13-01 10:00:00",
    ] {
        assert_eq!(refused(&log(wrong)).code, Code::NotANumber, "{wrong}");
    }
    let text = "time,a\n13/04/2023 10:00:00,1\n13/04/2023 10:00:01,2\n13/04/2023 10:00:02,2\n";
    let mut options = ReadOptions::default();
    options.dialect.day_first = Some(false);
    assert_eq!(refused_with(text, &options).code, Code::InvalidTimeStamps);
    let raw_log = read(text.replace("13/", "03/").as_bytes());
    assert!(raw_log.diagnostics.iter().any(|w| w.code == "date-order"));
}

/// A number too large is no footer.
#[test]
fn refuses_a_last_row_beyond_all_numbers() {
    let text = "frequency_Hz,H_re,H_im\n1,1,0\n2,1,0\n3,1,0\n1e400,1,0\n";
    assert_eq!(refused(text).code, Code::NotANumber);
}
