//! LVM, UFF 58, MATLAB and WAV files read; CSV, UFF 58 and JSON written: against scipy and pyuff
//! (`data/reference/log_formats.json`, by `tools/log_formats.py`), measured logs, round trips and damaged files.

use std::path::{Path, PathBuf};

use geardyn::internals::base::code::Code;
use geardyn::internals::base::error::Errors;
use geardyn::internals::base::mat5;
use geardyn::internals::numeric::Complex;
use geardyn::internals::recording::frequency_responses::{
    ChannelLabel, FrequencyResponse, FrequencyResponses,
};
use geardyn::internals::recording::geometry::Geometry;
use geardyn::internals::recording::raw::{ChannelGroup, RawLog};
use geardyn::internals::recording::read_options::ReadOptions;
use geardyn::internals::recording::sample_column::SampleColumn;
use geardyn::internals::recording::signals::{Channel, Recording};
use geardyn::internals::recording::stated_rates::StatedRate;
use geardyn::internals::recording::{lvm, mat, uff, wav, write};
use serde_json::Value;

type Reader = fn(&str, &[u8], &ReadOptions) -> Result<RawLog, Errors>;

fn read_with(reader: Reader, bytes: &[u8]) -> RawLog {
    reader("log", bytes, &ReadOptions::default()).unwrap_or_else(|e| panic!("{e}"))
}

fn refused(reader: Reader, bytes: &[u8]) -> (Code, String) {
    let errors = reader("log", bytes, &ReadOptions::default()).unwrap_err();
    let first = &errors.as_slice()[0];
    (first.code, errors.to_string())
}

fn numbers(column: &SampleColumn) -> Vec<f64> {
    let mut values = vec![0.0; column.len()];
    column.read(0, &mut values).unwrap();
    values
}

fn names(group: &ChannelGroup) -> Vec<&str> {
    group.channels.iter().map(|c| c.name.as_str()).collect()
}

fn seconds(group: &ChannelGroup) -> Vec<f64> {
    numbers(&group.timing.stamps.as_ref().unwrap().seconds)
}

fn reference() -> Value {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/reference/log_formats.json");
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn file(reference: &Value, key: &str) -> Vec<u8> {
    let hex = reference[key].as_str().unwrap().as_bytes();
    let byte = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).unwrap(), 16).unwrap();
    hex.chunks(2).map(byte).collect()
}

/// Numbers in text, apart by blanks.
fn list(value: &Value) -> Vec<f64> {
    let words = value.as_str().unwrap().split(' ');
    words.map(|word| word.parse().unwrap()).collect()
}

/// Numbers of a JSON list in the text of a document, after the `nth` time its key stands there.
fn listed(document: &str, key: &str, nth: usize) -> Vec<f64> {
    let after = document.split(&format!("\"{key}\":[")).nth(nth).unwrap();
    let inside = after.split(']').next().unwrap();
    inside
        .split(',')
        .map(|word| word.parse().unwrap())
        .collect()
}

/// What is read of a file is told as it goes, up to all of it.
#[test]
fn exact_progress_of_reading() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("long.csv");
    let mut text = String::from("t,a\n");
    (0..200_000).for_each(|k| text += &format!("{k},{}\n", k % 17));
    std::fs::write(&path, text).unwrap();
    let seen = std::cell::RefCell::new(Vec::new());
    let path = path.display().to_string();
    let raw = geardyn::internals::recording::open::open_with_progress(
        &path,
        &ReadOptions::default(),
        &|share| {
            seen.borrow_mut().push(share);
        },
    );
    assert_eq!(raw.unwrap().groups[0].channels[0].samples.len(), 200_000);
    let seen = seen.into_inner();
    assert!(seen.len() > 10 && seen.iter().all(|s| (0.0..=1.0).contains(s)));
    assert_eq!(seen.last(), Some(&1.0));
}

// MATLAB

/// Every class of numbers of a MATLAB file.
/// Source: SciPy 1.17.1 (tools/log_formats.py).
#[test]
fn ref_scipy_every_class_of_numbers() {
    let reference = reference();
    for key in ["mat_classes", "mat_classes_compressed"] {
        let log = read_with(mat::read, &file(&reference, key));
        let [group] = log.groups.as_slice() else {
            panic!("{}", log.groups.len())
        };
        assert_eq!(group.channels.len(), 10, "{key}");
        for channel in &group.channels {
            assert_eq!(
                numbers(&channel.samples),
                list(&reference["classes"]),
                "{key} {}",
                channel.name
            );
        }
        let t = seconds(group);
        assert_eq!((t[0], t[11]), (0.0, 11.0 / 400.0));
    }
}

/// Structures and cells of a MATLAB file.
/// Source: SciPy 1.17.1 (tools/log_formats.py).
#[test]
fn ref_scipy_structures_and_cells() {
    let reference = reference();
    let log = read_with(mat::read, &file(&reference, "mat_struct"));
    let [group] = log.groups.as_slice() else {
        panic!("{}", log.groups.len())
    };
    assert_eq!(names(group), ["run.data"]);
    assert_eq!(numbers(&group.channels[0].samples), list(&reference["run"]));
    assert_eq!(group.timing.stamps.as_ref().unwrap().name, "run.time");
    assert!(
        log.metadata
            .contains(&("run.note".to_string(), "second gear".to_string()))
    );
    assert!(
        log.diagnostics
            .iter()
            .any(|w| w.message.contains("`cells{2}`")),
        "{:?}",
        log.diagnostics
    );
}

/// Frequency responses with coherence in a MATLAB file.
/// Source: SciPy 1.17.1 (tools/log_formats.py).
#[test]
fn ref_scipy_responses_with_coherence() {
    let reference = reference();
    let responses = read_with(mat::read, &file(&reference, "mat_frf"))
        .responses
        .unwrap();
    assert_eq!(
        responses.frequency_hz,
        (1..=10).map(|k| 2.5 * f64::from(k)).collect::<Vec<_>>()
    );
    assert_eq!(responses.responses.len(), 2);
    for (at, function) in responses.responses.iter().enumerate() {
        assert_eq!(function.output.name, format!("H {}", at + 1));
        assert_eq!(
            function.values.iter().map(|v| v.re).collect::<Vec<_>>(),
            list(&reference["h_re"][at])
        );
        assert_eq!(
            function.values.iter().map(|v| v.im).collect::<Vec<_>>(),
            list(&reference["h_im"][at])
        );
        assert_eq!(
            function.coherence.as_ref().unwrap(),
            &list(&reference["coherence"][at])
        );
    }
}

/// A MATLAB file of the other byte order.
#[test]
fn exact_other_byte_order() {
    let reference = reference();
    let log = read_with(mat::read, &file(&reference, "mat_big_endian"));
    assert_eq!(
        numbers(&log.groups[0].channels[0].samples),
        list(&reference["big_x"])
    );
    assert_eq!(
        log.groups[0].timing.stated_rates,
        [StatedRate::is_sample_rate(250.0, "dt")]
    );
}

#[test]
fn law_what_is_written_for_matlab_reads_back() {
    let names = ["wheel".to_string(), "größe".to_string()];
    let bytes = [
        mat5::write::header("test"),
        mat5::write::real("a", [2, 3], [1.0, 2.0, 3.0, 4.0, 5.0, -0.1]).unwrap(),
        mat5::write::complex("long_name", [1, 2], [1.0, 2.0], [0.5, f64::NAN]).unwrap(),
        mat5::write::text("hold", "zero order").unwrap(),
        mat5::write::cell_strings("names", &names).unwrap(),
    ]
    .concat();
    use mat5::read::Contents;
    let (description, arrays) = mat5::read::read(&bytes).unwrap();
    assert!(
        description.ends_with("written by geardyn: test"),
        "{description}"
    );
    let [a, z, hold, cells] = arrays.as_slice() else {
        panic!("{}", arrays.len())
    };
    assert!(
        matches!(&a.contents, Contents::Real { values, .. } if values[..] == [1.0, 2.0, 3.0, 4.0, 5.0, -0.1])
    );
    assert_eq!(
        (a.name.as_str(), a.dimensions.as_slice()),
        ("a", &[2, 3][..])
    );
    assert!(
        matches!(&z.contents, Contents::Complex { re, im } if re[..] == [1.0, 2.0] && im[0] == 0.5 && im[1].is_nan())
    );
    assert!(matches!(&hold.contents, Contents::Text(rows) if rows[..] == ["zero order"]));
    let Contents::Cells(cells) = &cells.contents else {
        panic!()
    };
    assert!(matches!(&cells[1].contents, Contents::Text(rows) if rows[..] == ["größe"]));
}

#[test]
fn survives_a_variable_twice() {
    let x: Vec<f64> = (0..9).map(f64::from).map(f64::sqrt).collect();
    let one =
        |name, values: &[f64]| mat5::write::real(name, [values.len(), 1], values.to_vec()).unwrap();
    let twice: Vec<f64> = x.iter().map(|x| 2.0 * x).collect();
    let bytes = [
        mat5::write::header(""),
        one("x", &x),
        one("x", &twice),
        one("fs", &[50.0]),
    ]
    .concat();
    let log = read_with(mat::read, &bytes);
    assert_eq!(names(&log.groups[0]), ["x", "x #2"]);
    assert_eq!(numbers(&log.groups[0].channels[1].samples), twice);
    assert!(log.diagnostics.iter().any(|w| w.code == "name-twice"));
}

#[test]
fn refuses_other_levels_of_matlab_by_name() {
    let reference = reference();
    let (code, message) = refused(mat::read, &file(&reference, "mat_level_4"));
    assert!(
        code == Code::UnknownFormat && message.contains("level 4"),
        "{message}"
    );
    let (code, message) = refused(mat::read, b"MATLAB 7.3 MAT-file, Platform: GLNXA64");
    assert!(
        code == Code::UnknownFormat && message.contains("HDF5") && message.contains("-v7"),
        "{message}"
    );
    let (code, message) = refused(mat::read, &file(&reference, "mat_object"));
    assert!(
        code == Code::EmptyLog && message.contains("object of class gearbox"),
        "{message}"
    );
    let whole = file(&reference, "mat_classes");
    let (code, message) = refused(mat::read, &whole[..whole.len() - 20]);
    assert!(
        code == Code::CorruptFile && message.contains("cut off"),
        "{message}"
    );
}

// LVM

const LVM: &str = "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t.\nMulti_Headings\tYes\n";

fn lvm_segment(start: &str, x_columns: bool, values: &[f64]) -> String {
    let mut text = format!(
        "\t\nChannels\t2\t\t\nSamples\t{n}\t{n}\t\nDate\t2024/02/28\t2024/02/28\t\nTime\t{start}\t{start}\t\nY_Unit_Label\tg\tNewtons\t\n\
         X_Dimension\tTime\tTime\t\nX0\t0.0\t0.0\t\nDelta_X\t0.25\t0.25\t\n***End_of_Header***\t\t\t\nX_Value\tacc\tforce\tComment\n",
        n = values.len()
    );
    for (row, value) in values.iter().enumerate() {
        let x = if x_columns {
            format!("{}", row as f64 * 0.25)
        } else {
            String::new()
        };
        text += &format!("{x}\t{value}\t{}\n", 10.0 * value);
    }
    text
}

/// Segments of a file follow each other by their time.
#[test]
fn exact_segments_follow_each_other_by_their_time() {
    for x_columns in [true, false] {
        let columns = if x_columns { "One" } else { "No" };
        let text = format!(
            "{LVM}X_Columns\t{columns}\n***End_of_Header***\t\n{}{}{}",
            lvm_segment("10:00:00.0", x_columns, &[1.0, 2.0]),
            lvm_segment("10:00:00.52", x_columns, &[3.0, 4.0]), // its clock strays by 20 ms
            lvm_segment("10:00:05.0", x_columns, &[5.0]),
        );
        let log = read_with(lvm::read, text.as_bytes());
        let [group] = log.groups.as_slice() else {
            panic!("{}", log.groups.len())
        };
        assert_eq!(
            numbers(&group.channels[1].samples),
            [10.0, 20.0, 30.0, 40.0, 50.0]
        );
        assert_eq!(seconds(group), [0.0, 0.25, 0.5, 0.75, 5.0]);
        assert_eq!(
            group.timing.stated_rates,
            [StatedRate::is_sample_rate(4.0, "Delta_X")]
        );
        assert_eq!(
            group.timing.lines.line_of_row(2),
            Some(text.lines().position(|l| l.contains("\t3\t30")).unwrap() + 1)
        );
        assert_eq!(
            (names(group), group.channels[1].unit.as_str()),
            (vec!["acc", "force"], "Newtons")
        );
    }
}

/// Segments that begin at one time stay apart.
#[test]
fn exact_segments_at_one_time_stay_apart() {
    let text = format!(
        "{LVM}X_Columns\tOne\n***End_of_Header***\t\n{}{}",
        lvm_segment("10:00:00.0", true, &[1.0, 2.0]),
        lvm_segment("10:00:00.0", true, &[3.0, 4.0]),
    );
    let log = read_with(lvm::read, text.as_bytes());
    assert_eq!(log.groups.len(), 2);
    assert_eq!(
        names(&log.groups[1]),
        ["acc (segment 2)", "force (segment 2)"]
    );
}

/// Commas between cells and two-byte line ends.
#[test]
fn exact_commas_between_cells_and_windows_lines() {
    let text = format!(
        "{LVM}X_Columns\tOne\n***End_of_Header***\t\n{}",
        lvm_segment("10:00:00.0", true, &[1.5, 2.0])
    );
    let text = text
        .replace("Separator\tTab", "Separator\tComma")
        .replace('\t', ",")
        .replace('\n', "\r\n");
    let log = read_with(lvm::read, text.as_bytes());
    assert_eq!(numbers(&log.groups[0].channels[0].samples), [1.5, 2.0]);
    assert!(
        log.dialect.contains("comma, decimal point"),
        "{}",
        log.dialect
    );
}

/// A shorter channel has a time base of its own.
#[test]
fn exact_shorter_channel_has_a_clock_of_its_own() {
    let text = format!(
        "{LVM}X_Columns\tOne\n***End_of_Header***\t\n{}",
        lvm_segment("10:00:00.0", true, &[1.0, 2.0, 3.0])
    );
    let text = text
        .replace("Samples\t3\t3", "Samples\t3\t2")
        .replace("\t3\t30\n", "\t3\t\n");
    let log = read_with(lvm::read, text.as_bytes());
    assert_eq!(log.groups.len(), 2);
    assert_eq!(numbers(&log.groups[1].channels[0].samples), [10.0, 20.0]);
    // A blank where the header states a sample is a missing one.
    let text = text.replace("Samples\t3\t2", "Samples\t3\t3");
    let log = read_with(lvm::read, text.as_bytes());
    assert_eq!(log.groups.len(), 1);
    assert!(numbers(&log.groups[0].channels[1].samples)[2].is_nan());
}

#[test]
fn refuses_words_among_numbers_and_short_rows() {
    let text = format!(
        "{LVM}X_Columns\tOne\n***End_of_Header***\t\n{}",
        lvm_segment("10:00:00.0", true, &[1.0, 2.0, 3.0])
    );
    let line = text.lines().position(|l| l.starts_with("0.25\t2")).unwrap() + 1;
    for (wrong, expected) in [
        ("0.25\tbad\t20", Code::NotANumber),
        ("0.25\t2", Code::RaggedRow),
    ] {
        let text = text.replace("0.25\t2\t20", wrong);
        let errors = lvm::read("beam.lvm", text.as_bytes(), &ReadOptions::default()).unwrap_err();
        let first = &errors.as_slice()[0];
        assert_eq!(first.code, expected);
        assert_eq!(first.span.as_ref().unwrap().line(), line, "{errors}");
    }
}

/// A last row that breaks off, in a number or between two, is left out and listed as in text files.
#[test]
fn law_incomplete_last_row_of_lvm_is_a_repair() {
    let text = format!(
        "{LVM}X_Columns\tOne\n***End_of_Header***\t\n{}",
        lvm_segment("10:00:00.0", true, &[1.0, 2.0, 3.0, 4.0])
    );
    let text = text.strip_suffix("0.75\t4\t40\n").unwrap();
    for cut in ["0.75\t4", "0.75", "0.75\t", "0.75\t4\t-", "0.75\t4e\t40"] {
        let log = read_with(lvm::read, format!("{text}{cut}").as_bytes());
        assert_eq!(log.groups[0].channels[1].samples.len(), 3, "{cut}");
        let words: Vec<&str> = log.repairs.iter().map(|r| r.kind).collect();
        assert_eq!(words, ["row-incomplete"], "{cut}");
        let line = text.lines().count() + 1;
        assert!(log.repairs[0].message.contains(&format!("line {line},")));
    }
}

// UFF 58

/// A time response in a universal file, data set 58.
/// Source: pyuff 2.5.8 (tools/log_formats.py).
#[test]
fn ref_pyuff_time_response() {
    let reference = reference();
    let expected = list(&reference["signal"]);
    for (key, tolerance) in [("uff_time_text", 5e-12), ("uff_time_binary", 0.0)] {
        let log = read_with(uff::read, &file(&reference, key));
        let [group] = log.groups.as_slice() else {
            panic!("{}", log.groups.len())
        };
        let channel = &group.channels[0];
        assert_eq!(
            (channel.name.as_str(), channel.unit.as_str()),
            ("3-Y", "m/s^2")
        );
        for (a, b) in numbers(&channel.samples).iter().zip(&expected) {
            assert!((a - b).abs() <= tolerance, "{key}: {a} {b}");
        }
        assert_eq!(channel.samples.len(), expected.len());
        assert_eq!(group.timing.stated_rates[0].hertz, 400.0);
        assert_eq!(group.timing.start.as_deref(), Some("01-Jan-24 12:00:00"));
    }
}

/// Frequency responses in a universal file, data set 58.
/// Source: pyuff 2.5.8 (tools/log_formats.py).
#[test]
fn ref_pyuff_frequency_responses() {
    let reference = reference();
    for (key, tolerance) in [("uff_frf_text", 5e-12), ("uff_frf_binary", 0.0)] {
        let responses = read_with(uff::read, &file(&reference, key))
            .responses
            .unwrap();
        assert_eq!(responses.frequency_hz[9], 25.0);
        for (at, function) in responses.responses.iter().enumerate() {
            assert_eq!(function.output.name, format!("{}+Z", 7 + at));
            let input = function.input.as_ref().unwrap();
            assert_eq!((input.name.as_str(), input.unit.as_str()), ("1+Z", "N"));
            let (re, im) = (list(&reference["h_re"][at]), list(&reference["h_im"][at]));
            for (k, value) in function.values.iter().enumerate() {
                assert!(
                    (value.re - re[k]).abs() <= tolerance && (value.im - im[k]).abs() <= tolerance
                );
            }
        }
        assert_eq!(responses.responses.len(), 2);
    }
}

/// The binary set of pyuff with every number turned around and the byte order of its first line changed.
#[test]
fn exact_other_byte_order_of_58b() {
    let reference = reference();
    let mut bytes = file(&reference, "uff_time_binary");
    let mut ends = bytes
        .iter()
        .enumerate()
        .filter(|(_, b)| **b == b'\n')
        .map(|(at, _)| at);
    let data = ends.nth(12).unwrap() + 1;
    let count = list(&reference["signal"]).len();
    bytes[data..data + 8 * count]
        .chunks_mut(8)
        .for_each(<[u8]>::reverse);
    let order = bytes.windows(4).position(|w| w == b"58b ").unwrap() + 8;
    assert_eq!(bytes[order], b'1');
    bytes[order] = b'2';
    let log = read_with(uff::read, &bytes);
    assert_eq!(
        numbers(&log.groups[0].channels[0].samples),
        list(&reference["signal"])
    );
}

#[test]
fn refuses_cut_and_foreign_uff() {
    let reference = reference();
    let text = file(&reference, "uff_time_text");
    let (code, message) = refused(uff::read, &text[..text.len() - 60]);
    assert!(
        code == Code::CorruptFile && message.contains("13 values"),
        "{message}"
    );
    let (code, message) = refused(uff::read, b"    -1\n   151\nmodel\n    -1\n");
    assert!(
        code == Code::EmptyLog && message.contains("151"),
        "{message}"
    );
    let vax = String::from_utf8_lossy(&text).replace("    58 ", "    58b     1     1 ");
    let (code, message) = refused(uff::read, vax.as_bytes());
    assert!(
        code == Code::UnknownFormat && message.contains("DEC VMS"),
        "{message}"
    );
}

/// Columns that touch, exponents of three digits without `E`, exponents with `D`, overflow stars, zeros that fill up.
#[test]
fn survives_fortran_numbers() {
    let text = String::from_utf8(file(&reference(), "uff_time_text")).unwrap();
    let start = text.find("   1.26128190653e+00").unwrap();
    let end = text.rfind("    -1").unwrap();
    let rows = " 1.00000E+000-2.00000E+000 3.00000-101 4.0D+02 ************* -6.0\n 7 8 9 10 11 12\n 13 0.00000E+00 0.00000E+00\n";
    let log = read_with(
        uff::read,
        format!("{}{rows}{}", &text[..start], &text[end..]).as_bytes(),
    );
    let channel = &log.groups[0].channels[0];
    let values = numbers(&channel.samples);
    assert_eq!(values[..4], [1.0, -2.0, 3e-101, 400.0]);
    assert!(values[4].is_nan() && channel.overloads == 1);
    assert_eq!(values[5..], [-6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0]);
}

// WAV

/// Sound files of every width of sample.
#[test]
fn exact_wav_of_every_width() {
    let integers = [0, 1, -1, 100, -128, 127];
    for bits in [8_u16, 16, 24, 32] {
        let samples = integers.map(|i: i32| i << (bits - 8));
        let full_scale = 2.0_f64.powi(i32::from(bits) - 1);
        let bytes = wav_of(2, bits, hound::SampleFormat::Int, |w| {
            samples.iter().for_each(|&s| w.write_sample(s).unwrap())
        });
        let log = read_with(wav::read, &bytes);
        let group = &log.groups[0];
        assert_eq!(
            group.timing.stated_rates,
            [StatedRate::is_sample_rate(48_000.0, "WAV header")]
        );
        let expected = |at: usize| -> Vec<f64> {
            samples
                .iter()
                .skip(at)
                .step_by(2)
                .map(|&s| f64::from(s) / full_scale)
                .collect()
        };
        assert_eq!(numbers(&group.channels[0].samples), expected(0), "{bits}");
        assert_eq!(numbers(&group.channels[1].samples), expected(1), "{bits}");
    }
    let floats = [0.5_f32, -1.25, f32::MIN_POSITIVE];
    let bytes = wav_of(1, 32, hound::SampleFormat::Float, |w| {
        floats.iter().for_each(|&s| w.write_sample(s).unwrap())
    });
    assert_eq!(
        numbers(&read_with(wav::read, &bytes).groups[0].channels[0].samples),
        floats.map(f64::from)
    );
}

fn wav_of(
    channels: u16,
    bits_per_sample: u16,
    sample_format: hound::SampleFormat,
    fill: impl Fn(&mut hound::WavWriter<&mut std::io::Cursor<Vec<u8>>>),
) -> Vec<u8> {
    let spec = hound::WavSpec {
        channels,
        sample_rate: 48_000,
        bits_per_sample,
        sample_format,
    };
    let mut bytes = std::io::Cursor::new(Vec::new());
    let mut writer = hound::WavWriter::new(&mut bytes, spec).unwrap();
    fill(&mut writer);
    writer.finalize().unwrap();
    bytes.into_inner()
}

#[test]
fn refuses_a_cut_wav() {
    let bytes = wav_of(2, 16, hound::SampleFormat::Int, |w| {
        (0..40).for_each(|s| w.write_sample(s).unwrap())
    });
    let (code, message) = refused(wav::read, &bytes[..bytes.len() - 7]);
    assert!(
        code == Code::CorruptFile && message.contains("cut off"),
        "{message}"
    );
}

// writers

fn recording(samples: usize) -> Recording {
    let mut rng = fastrand::Rng::with_seed(58);
    let channel = |name: &str, unit: &str, samples: Vec<f64>| Channel {
        name: name.to_string(),
        unit: unit.to_string(),
        samples: SampleColumn::from_slice(&samples).into(),
        overload_level: None,
        overloads: 0,
    };
    let mut wild = || f64::from_bits(rng.u64(..));
    let finite = |x: f64| if x.is_finite() { x } else { 0.1 };
    let wild: Vec<f64> = (0..samples).map(|_| finite(wild())).collect();
    let tame: Vec<f64> = (0..samples).map(|k| (0.1 * k as f64).sin()).collect();
    Recording {
        path: "made".into(),
        dialect: String::new(),
        metadata: Vec::new(),
        rate_hz: 1000.0 / 3.0,
        rate_std: 0.0,
        rate_source: String::new(),
        samples,
        segments: std::iter::once(0..samples).collect(),
        segment_starts: vec![0.0],
        start: None,
        files: Vec::new(),
        channels: vec![
            channel("acceleration of housing, x", "m/s²", wild),
            channel("force", "N", tame),
        ],
        repairs: Vec::new(),
        diagnostics: Vec::new(),
    }
}

#[test]
fn law_csv_of_signals_reads_back_to_the_bit() {
    let recording = recording(20_000);
    let mut bytes = Vec::new();
    write::csv::write_recording(&recording, &mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some("time [s],\"acceleration of housing, x [m/s²]\",force [N]")
    );
    let columns: Vec<Vec<f64>> = recording
        .channels
        .iter()
        .map(|c| numbers(&c.samples))
        .collect();
    let mut rows = 0;
    for (k, line) in lines.enumerate() {
        let cells: Vec<f64> = line.split(',').map(|cell| cell.parse().unwrap()).collect();
        assert_eq!(
            cells,
            [k as f64 / recording.rate_hz, columns[0][k], columns[1][k]]
        );
        rows += 1;
    }
    assert_eq!(rows, 20_000);
}

#[test]
fn law_uff_of_signals_reads_back() {
    let recording = recording(20_000);
    for format in [write::uff::UffFormat::Binary, write::uff::UffFormat::Text] {
        let mut bytes = Vec::new();
        write::uff::write_recording(&recording, &Geometry::default(), format, &mut bytes).unwrap();
        let log = read_with(uff::read, &bytes);
        let [group] = log.groups.as_slice() else {
            panic!("{}", log.groups.len())
        };
        assert_eq!(group.timing.stated_rates[0].hertz, recording.rate_hz);
        for (read, written) in group.channels.iter().zip(&recording.channels) {
            assert_eq!((&read.name, &read.unit), (&written.name, &written.unit));
            for (a, b) in numbers(&read.samples)
                .iter()
                .zip(&numbers(&written.samples))
            {
                match format {
                    write::uff::UffFormat::Binary => assert_eq!(a.to_bits(), b.to_bits()),
                    // Twelve digits after the point.
                    write::uff::UffFormat::Text => {
                        assert!((a - b).abs() <= 5.1e-13 * b.abs(), "{a} {b}")
                    }
                }
            }
        }
        assert_eq!(group.channels.len(), 2);
    }
}

/// Signals as JSON come back.
#[test]
fn exact_json_of_signals() {
    let mut recording = recording(3);
    recording.channels[1].samples = SampleColumn::from_slice(&[0.1, f64::NAN, -2.0]).into();
    let mut bytes = Vec::new();
    write::json::write_recording(&recording, &serde_json::json!({"version": "0"}), &mut bytes)
        .unwrap();
    let document: Value = serde_json::from_slice(&bytes).unwrap();
    assert!((document["rate_hz"].as_f64().unwrap() - 1000.0 / 3.0).abs() < 1e-12);
    assert_eq!(document["samples"], 3);
    let written = numbers(&recording.channels[0].samples);
    assert_eq!(
        listed(std::str::from_utf8(&bytes).unwrap(), "value", 1),
        written
    );
    assert_eq!(
        document["channels"][1]["value"],
        serde_json::json!([0.1, null, -2.0])
    );
    assert_eq!(document["channels"][0]["unit"], "m/s²");
}

/// Responses on lines that are or are not those of a start and an increment.
fn responses(lines: impl Fn(f64) -> f64) -> FrequencyResponses {
    let mut rng = fastrand::Rng::with_seed(4);
    let terminal = |name: &str, unit: &str| ChannelLabel {
        name: name.into(),
        unit: unit.into(),
    };
    let mut function = |output: &str, with_coherence: bool| FrequencyResponse {
        input: Some(terminal("hammer", "N")),
        output: terminal(output, "m/s²"),
        values: (0..50)
            .map(|_| Complex::new(rng.f64() - 0.5, rng.f64()))
            .collect(),
        coherence: with_coherence.then(|| (0..50).map(|_| rng.f64()).collect()),
        ..FrequencyResponse::default()
    };
    FrequencyResponses {
        responses: vec![
            function("bearing of the pinion", true),
            function("wheel", false),
        ],
        frequency_hz: (0..50).map(|k| lines(f64::from(k))).collect(),
        averages: Some(10.0),
        window_decay: 3.25,
        usable_band_hz: Some((1.5, 20.0 / 3.0)),
        independent_lines_per_line: Some(0.625),
    }
}

#[test]
fn law_uff_of_responses_reads_back() {
    for lines in [|k| 10.0 + 0.5 * k, |k: f64| 1.0 + k.sqrt(), |k| k / 3.0] {
        let written = responses(lines);
        for format in [write::uff::UffFormat::Binary, write::uff::UffFormat::Text] {
            let mut bytes = Vec::new();
            write::uff::write_responses(&written, &Geometry::default(), format, &mut bytes)
                .unwrap();
            let read = read_with(uff::read, &bytes).responses.unwrap();
            let behind = |r: &FrequencyResponses| {
                (
                    r.averages,
                    r.window_decay,
                    r.usable_band_hz,
                    r.independent_lines_per_line,
                )
            };
            assert_eq!(behind(&read), behind(&written));
            // Thirteen digits in text, seven of uneven lines.
            let (digits, line_digits) = match format {
                write::uff::UffFormat::Binary => (0.0, 0.0),
                write::uff::UffFormat::Text => (6e-13, 6e-7),
            };
            for (a, b) in read.frequency_hz.iter().zip(&written.frequency_hz) {
                assert!((a - b).abs() <= line_digits * b.abs(), "{a} {b}");
            }
            for (a, b) in read.responses.iter().zip(&written.responses) {
                assert_eq!((&a.input, &a.output), (&b.input, &b.output));
                assert_eq!(a.coherence.is_some(), b.coherence.is_some());
                for (x, y) in a.values.iter().zip(&b.values) {
                    assert!(
                        (x.re - y.re).abs() <= digits && (x.im - y.im).abs() <= digits,
                        "{x} {y}"
                    );
                }
                for (x, y) in a
                    .coherence
                    .iter()
                    .flatten()
                    .zip(b.coherence.iter().flatten())
                {
                    assert!((x - y).abs() <= digits);
                }
            }
            assert_eq!((read.responses.len(), read.frequency_hz.len()), (2, 50));
        }
    }
}

/// Responses as CSV and JSON come back.
#[test]
fn exact_csv_and_json_of_responses() {
    let written = responses(|k| k / 3.0);
    let mut bytes = Vec::new();
    write::csv::write_responses(&written, &mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let head = "frequency [Hz],Re bearing of the pinion / hammer [m/s²/N],Im bearing of the pinion / hammer [m/s²/N],\
                coherence bearing of the pinion / hammer,Re wheel / hammer [m/s²/N],Im wheel / hammer [m/s²/N]";
    assert_eq!(text.lines().next(), Some(head));
    let row: Vec<f64> = text
        .lines()
        .nth(8)
        .unwrap()
        .split(',')
        .map(|cell| cell.parse().unwrap())
        .collect();
    let (first, second) = (&written.responses[0], &written.responses[1]);
    let coherence = first.coherence.as_ref().unwrap()[7];
    let expected = [
        7.0 / 3.0,
        first.values[7].re,
        first.values[7].im,
        coherence,
        second.values[7].re,
        second.values[7].im,
    ];
    assert_eq!(row, expected);

    let mut bytes = Vec::new();
    write::json::write_responses(&written, &Value::Null, &mut bytes).unwrap();
    let document: Value = serde_json::from_slice(&bytes).unwrap();
    let text = std::str::from_utf8(&bytes).unwrap();
    assert_eq!(listed(text, "frequency_hz", 1), written.frequency_hz);
    assert_eq!(
        listed(text, "coherence", 1),
        *first.coherence.as_ref().unwrap()
    );
    let function = &document["functions"][1];
    assert!((function["value"][7]["im"].as_f64().unwrap() - second.values[7].im).abs() < 1e-15);
    assert_eq!(function["coherence"], Value::Null);
    assert_eq!(function["input"]["name"], "hammer");
}

// damaged files

/// A whole file of each format.
fn seeds() -> Vec<(&'static str, Reader, Vec<u8>)> {
    let reference = reference();
    let lvm_text = format!(
        "{LVM}X_Columns\tOne\n***End_of_Header***\t\n{}{}",
        lvm_segment("10:00:00.0", true, &[1.0, 2.0, 3.0]),
        lvm_segment("10:00:09,5", true, &[4.0, 5.0]),
    );
    let int = wav_of(2, 24, hound::SampleFormat::Int, |w| {
        (0..40).for_each(|s| w.write_sample(s).unwrap())
    });
    let float = wav_of(1, 32, hound::SampleFormat::Float, |w| {
        (0..40).for_each(|s| w.write_sample(s as f32).unwrap())
    });
    let mut uneven = Vec::new();
    write::uff::write_responses(
        &responses(f64::sqrt),
        &Geometry::default(),
        write::uff::UffFormat::Text,
        &mut uneven,
    )
    .unwrap();
    let keyed = |reader: Reader, key: &'static str| (key, reader, file(&reference, key));
    vec![
        keyed(mat::read, "mat_classes"),
        keyed(mat::read, "mat_classes_compressed"),
        keyed(mat::read, "mat_struct"),
        keyed(mat::read, "mat_frf"),
        keyed(mat::read, "mat_big_endian"),
        keyed(mat::read, "mat_object"),
        keyed(uff::read, "uff_time_text"),
        keyed(uff::read, "uff_time_binary"),
        keyed(uff::read, "uff_frf_text"),
        keyed(uff::read, "uff_frf_binary"),
        ("uff uneven", uff::read, uneven),
        ("lvm", lvm::read, lvm_text.into_bytes()),
        ("wav of integers", wav::read, int),
        ("wav of floats", wav::read, float),
    ]
}

/// Changes a few bytes, digits more often than others, or cuts, doubles or removes a piece.
fn damage(bytes: &mut Vec<u8>, rng: &mut fastrand::Rng) {
    for _ in 0..rng.usize(1..6) {
        if bytes.is_empty() {
            return;
        }
        let at = rng.usize(..bytes.len());
        let end = (at + rng.usize(..40)).min(bytes.len());
        match rng.u8(..10) {
            0 => bytes.truncate(at),
            1 => drop(bytes.drain(at..end)),
            2 => {
                let piece = bytes[at..end].to_vec();
                bytes.splice(at..at, piece);
            }
            3 => bytes[at] = [0, 0xFF, 0x7F, 0x80][rng.usize(..4)],
            4..=6 => bytes[at] = b"0123456789-+.,Ee\t\n "[rng.usize(..19)],
            7 => bytes[at..end].fill(0xFF),
            _ => bytes[at] ^= 1 << rng.u8(..8),
        }
    }
}

fn fuzz(rounds: usize, seed: u64) -> (usize, usize) {
    let mut rng = fastrand::Rng::with_seed(seed);
    let (mut read, mut refused) = (0, 0);
    for (name, reader, whole) in seeds() {
        for round in 0..rounds {
            let mut bytes = whole.clone();
            damage(&mut bytes, &mut rng);
            match reader("log", &bytes, &ReadOptions::default()) {
                Ok(raw_log) => {
                    read += 1;
                    let values: usize = raw_log
                        .groups
                        .iter()
                        .flat_map(|g| &g.channels)
                        .map(|c| c.samples.len())
                        .sum();
                    // A byte of a compressed file may unpack to a thousand.
                    assert!(
                        values <= 1100 * bytes.len(),
                        "{name} round {round}: {values} samples"
                    );
                    for group in &raw_log.groups {
                        let length = group.channels[0].samples.len();
                        assert!(
                            group.channels.iter().all(|c| c.samples.len() == length),
                            "{name} round {round}"
                        );
                        let stamps = group.timing.stamps.as_ref().map(|s| s.seconds.len());
                        assert!(stamps.is_none_or(|n| n == length), "{name} round {round}");
                    }
                    for function in raw_log.responses.iter().flat_map(|r| &r.responses) {
                        let lines = raw_log.responses.as_ref().map(|r| r.frequency_hz.len());
                        assert_eq!(Some(function.values.len()), lines, "{name} round {round}");
                    }
                }
                Err(errors) => {
                    refused += 1;
                    assert!(!errors.as_slice().is_empty());
                }
            }
        }
    }
    (read, refused)
}

#[test]
fn survives_damaged_files() {
    let (read, refused) = fuzz(400, 1);
    assert!(
        read > 100 && refused > 100,
        "{read} read, {refused} refused"
    );
}

#[test]
#[ignore = "study: millions of damaged files, five minutes"]
fn survives_many_damaged_files() {
    let start = std::time::Instant::now();
    let (mut rounds, mut read, mut refused) = (0, 0, 0);
    while start.elapsed().as_secs() < 300 {
        let (r, e) = fuzz(1000, 100 + rounds);
        (rounds, read, refused) = (rounds + 1, read + r, refused + e);
    }
    println!("{read} read, {refused} refused");
}

/// A file of some size is read at some speed.
#[test]
#[ignore = "study: speed on files of 100 MB"]
fn survives_large_files() {
    let recording = recording(4_000_000);
    for form in [write::uff::UffFormat::Binary, write::uff::UffFormat::Text] {
        let mut bytes = Vec::new();
        let start = std::time::Instant::now();
        write::uff::write_recording(&recording, &Geometry::default(), form, &mut bytes).unwrap();
        let written = start.elapsed().as_secs_f64();
        let start = std::time::Instant::now();
        let log = read_with(uff::read, &bytes);
        let read = start.elapsed().as_secs_f64();
        let size = bytes.len() as f64 / 1e6;
        println!(
            "UFF {form:?}: {size:.0} MB written in {written:.2} s, read in {read:.2} s ({})",
            log.dialect
        );
    }
    let mut text = format!(
        "{LVM}X_Columns\tOne\n***End_of_Header***\t\n{}",
        lvm_segment("10:00:00.0", true, &[1.0])
    );
    text = text.replace("Samples\t1\t1", "Samples\t4000001\t4000001");
    for k in 0..4_000_000 {
        text += &format!(
            "{:.6}\t{:.6}\t{:.6}\n",
            0.25 * f64::from(k + 1),
            f64::from(k).sin(),
            f64::from(k).cos()
        );
    }
    let start = std::time::Instant::now();
    let log = read_with(lvm::read, text.as_bytes());
    let read = start.elapsed().as_secs_f64();
    println!(
        "LVM: {:.0} MB read in {read:.2} s ({})",
        text.len() as f64 / 1e6,
        log.dialect
    );
    let bytes = wav_of(2, 16, hound::SampleFormat::Int, |w| {
        (0..25_000_000).for_each(|s| w.write_sample((s % 30_000) as i16).unwrap())
    });
    let start = std::time::Instant::now();
    read_with(wav::read, &bytes);
    println!(
        "WAV: {:.0} MB read in {:.2} s",
        bytes.len() as f64 / 1e6,
        start.elapsed().as_secs_f64()
    );
}

// measured logs

fn recorded(reader: Reader, path: &str) -> RawLog {
    let folder = PathBuf::from(std::env::var("GEARDYN_RECORDINGS").unwrap());
    read_with(reader, &std::fs::read(folder.join(path)).unwrap())
}

/// Measured LVM files: channels, samples, rates.
/// Source: measured files, read by the program that published them.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_recordings_lvm() {
    let beam = recorded(lvm::read, "ladisk_beam_camera/acceleration.lvm");
    let group = &beam.groups[0];
    assert_eq!(group.channels[0].samples.len(), 50_030);
    assert_eq!(
        group.timing.stated_rates,
        [StatedRate::is_sample_rate(50_000.0, "Delta_X")]
    );
    let force = numbers(&group.channels[1].samples);
    assert_eq!(
        force.iter().fold(0.0_f64, |most, f| most.max(*f)),
        195.605522
    );

    // A header from before the samples were thinned out: both rates are handed on.
    let arts = recorded(lvm::read, "arts_beam_lvm/data_set_1_downsampled_by_16.lvm");
    let clock = &arts.groups[0].timing;
    assert_eq!(clock.stated_rates[0].hertz, 51_200.0);
    assert_eq!(clock.header_samples, Some(1_050_000));
    let t = seconds(&arts.groups[0]);
    assert_eq!((t.len(), t[63_040]), (63_041, 19.7));
    assert_eq!(names(&arts.groups[0]), ["Voltage", "Force", "Acceleratio"]);

    let spectrum = &recorded(lvm::read, "arts_beam_lvm/FFT_data.lvm").spectra[0];
    assert!(spectrum.is_decibel && spectrum.values.len() == 150_000);

    let samples = [
        ("long_single_header_multi_ch", 3, 16_384),
        ("multi_time_column", 2, 3),
        ("no_decimal_separator", 3, 4),
        ("short", 2, 10),
        ("short_new_line_end", 2, 10),
        ("with_comments", 3, 9),
        ("with_empty_fields", 3, 7),
    ];
    for (name, channels, length) in samples {
        let log = recorded(lvm::read, &format!("lvm_read_samples/{name}.lvm"));
        let [group] = log.groups.as_slice() else {
            panic!("{name}")
        };
        assert_eq!(
            (group.channels.len(), group.channels[0].samples.len()),
            (channels, length),
            "{name}"
        );
    }
    let comments = recorded(lvm::read, "lvm_read_samples/with_comments.lvm");
    assert_eq!(comments.groups[0].channels[1].unit, "°C");
}

/// Universal files of several programs: functions and their values.
/// Source: measured files, read by pyuff.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_recordings_uff() {
    let sample = |name: &str| recorded(uff::read, &format!("pyuff_samples/{name}"));
    for name in ["Sample_UFF58_ascii.uff", "Sample_UFF58b_bin.uff"] {
        let log = sample(name);
        let channel = &log.groups[0].channels[0];
        let values = numbers(&channel.samples);
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        let rms = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
        assert_eq!((values.len(), channel.unit.as_str()), (79_292, "Pa"));
        assert!((rms - 0.014_344_380_8).abs() < 3e-10, "{rms}"); // without the mean
    }
    let mpstd = sample("MPSTD#Set001_2024_10_08_10_27_07.uff");
    let [group] = mpstd.groups.as_slice() else {
        panic!("{}", mpstd.groups.len())
    };
    assert_eq!(group.channels.len(), 4);
    assert!(
        group
            .channels
            .iter()
            .all(|c| c.samples.len() == 222_400 && c.unit == "m/s2")
    );
    assert_eq!(group.timing.stated_rates[0].hertz, 3200.0);

    let psd = &sample("sample_dataset58_psd.uff").spectra[0];
    assert_eq!(
        (psd.values.len(), psd.unit.as_str(), psd.frequency_hz[3200]),
        (3201, "g²/Hz", 3200.0)
    );
    let function = &sample("non_ascii_header.uff").responses.unwrap().responses[0];
    assert_eq!(
        (function.output.unit.as_str(), function.values.len()),
        ("(1/N)*(m/s²)", 6)
    );
    let short = sample("dataset_milestone_in_header.uff");
    assert_eq!(short.groups[0].channels[0].samples.len(), 42);
    assert!(short.diagnostics.iter().any(|w| w.code == "values-missing"));
    assert_eq!(
        sample("time-history-not-all-columns-filled.uff").groups[0].channels[0]
            .samples
            .len(),
        13
    );
    assert_eq!(
        sample("binary8byte.uff").groups[0].channels[0]
            .samples
            .len(),
        250
    );
}

/// Measured MATLAB files: channels, times, responses.
/// Source: measured files, read by SciPy.
#[test]
#[cfg_attr(
    not(recordings),
    ignore = "set GEARDYN_RECORDINGS to the folder of measured logs"
)]
fn ref_recordings_matlab() {
    let bridge = recorded(mat::read, "echeynet_bridge/BridgeData.mat");
    let [group] = bridge.groups.as_slice() else {
        panic!("{}", bridge.groups.len())
    };
    assert_eq!(names(group), ["rz 1", "rz 2", "rz 3", "rz 4", "rz 5"]);
    assert!((seconds(group)[15] - 1.0).abs() < 1e-12);

    let case = recorded(mat::read, "vibration_toolbox_frf/case1.mat");
    assert_eq!(names(&case.groups[0]), ["Time_chan_1", "Time_chan_2"]);
    assert_eq!(case.groups[0].timing.stated_rates[0].hertz, 1280.0);
    let responses = case.responses.unwrap();
    let [function] = responses.responses.as_slice() else {
        panic!()
    };
    assert_eq!(
        (responses.frequency_hz.len(), responses.frequency_hz[1600]),
        (1601, 500.0)
    );
    let peak = (0..1601)
        .max_by(|&a, &b| {
            function.values[a]
                .norm()
                .total_cmp(&function.values[b].norm())
        })
        .unwrap();
    assert!(
        (responses.frequency_hz[peak] - 212.09).abs() < 0.3,
        "{}",
        responses.frequency_hz[peak]
    );
    assert!((function.coherence.as_ref().unwrap()[peak] - 0.333).abs() < 1e-3);

    let old = recorded(mat::read, "vibration_toolbox_frf/frf_data1.mat");
    assert_eq!(
        (
            names(&old.groups[0]),
            old.groups[0].timing.stated_rates[0].hertz
        ),
        (vec!["x", "f"], 10.0)
    );
}
