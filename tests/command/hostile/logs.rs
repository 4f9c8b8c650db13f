//! Wrong logs of every format, and wrong sidecars.

use std::fmt::Write as _;

use super::Row;

/// `time,force,a` at 1 kHz, with one row in place of row `at`.
fn table(count: usize, at: usize, wrong: &str) -> String {
    let mut text = String::from("time [s],force [N],a [m/s²]\n");
    for k in 0..count {
        let t = k as f64 * 1e-3;
        let (force, a) = ((91.0 * t).sin(), (77.0 * t).cos());
        match k == at {
            true => writeln!(text, "{wrong}").unwrap(),
            false => writeln!(text, "{t:.3},{force:.4},{a:.4}").unwrap(),
        }
    }
    text
}

/// A head and one line for each of `count` numbers.
fn lines(head: &str, count: usize, line: impl Fn(usize) -> String) -> String {
    (0..count).fold(head.to_string(), |text, k| text + &line(k) + "\n")
}

const HEAD: &str = "time [s],force [N],a [m/s²]\n";

/// The head, and 2000 rows of a force and noise.
fn driven(force: impl Fn(f64) -> String) -> String {
    let mut random = fastrand::Rng::with_seed(3);
    let mut noise = || random.f64() - 0.5;
    let rows = (0..2000).map(|k| {
        format!(
            "{:.3},{},{:.5}\n",
            f64::from(k) * 1e-3,
            force(noise()),
            noise()
        )
    });
    rows.fold(HEAD.to_string(), |text, row| text + &row)
}

/// A sample of noise as text.
fn noise(x: f64) -> String {
    format!("{x:.5}")
}

/// One response of three lines as UFF 58, with the abscissa of the second.
fn uff(abscissa: &str) -> String {
    format!(
        "    -1\n    58\nax / force\nNONE\nNONE\nNONE\nNONE\n    4         0    0         0 ax                 0   0 force              0   0\n         6         3         0 0.000000E+00 0.000000E+00 0.000000E+00\n        18    0    0    0 Frequency            Hz                  \n        12    0    0    0 ax                   m/s2                \n        13    0    0    0 force                N                   \n         0    0    0    0 NONE                 NONE                \n 1.000000E+00  1.000000000000E+00  0.000000000000E+00\n {abscissa}  1.000000000000E+00  0.000000000000E+00\n 3.000000E+00  1.000000000000E+00  0.000000000000E+00\n    -1\n"
    )
}

/// WAV: the format's tag, channels, rate and bits, a stated length of data, and the data.
fn wav(tag: u16, channels: u16, rate: u32, bits: u16, stated: u32, data: &[u8]) -> Vec<u8> {
    let frame = channels * bits / 8;
    let mut bytes = b"RIFF\x24\x00\x00\x00WAVEfmt \x10\x00\x00\x00".to_vec();
    bytes.extend(tag.to_le_bytes().iter().chain(&channels.to_le_bytes()));
    bytes.extend(rate.to_le_bytes());
    bytes.extend((rate.wrapping_mul(u32::from(frame))).to_le_bytes());
    bytes.extend(frame.to_le_bytes().iter().chain(&bits.to_le_bytes()));
    bytes.extend(b"data".iter().chain(&stated.to_le_bytes()).chain(data));
    bytes
}

/// The head of a MATLAB 5 file, then bytes.
fn mat(behind: &[u8]) -> Vec<u8> {
    let mut bytes = b"MATLAB 5.0 MAT-file".to_vec();
    bytes.resize(124, b' ');
    bytes.extend(b"\x00\x01IM".iter().chain(behind));
    bytes
}

const IDENTIFY: &str = "identify FILE --input force --output a";

/// The rows of this table.
#[rustfmt::skip]
pub fn rows() -> Vec<Row> {
    let constant = |text: &str| driven(|_| text.to_string());
    let check = |name, text: String, says| Row::new(name, text, "check FILE", 2, says);
    let rate = |text: &str| check("log.csv", lines(&format!("Device: x\nSample rate: {text}\na,b\n"), 50, |k| format!("{}.5,{}", k % 7, k % 5)), "[rate-unknown] | log.csv:2: | Sample rate");
    vec![
        // Nothing, or no log.
        Row::new("log.csv", "", "check FILE", 2, "[empty-log]"),
        Row::new("log.csv", "\n\n\n", "check FILE", 2, "[empty-log]"),
        Row::new("log.csv", "time,force,a\n", "check FILE", 2, "[empty-log]"),
        Row::new("log.csv", b"\x00\x01\x02\xff\xfe\xfd junk \x00\x00", "check FILE", 2, "[unknown-format]"),
        Row::new("log.csv.gz", "", "check FILE", 2, "[empty-log]"),
        Row::new("log.csv.gz", b"\x1f\x8b\x08\x00", "check FILE", 2, "[broken-file]"),
        Row::new("log.zip", b"PK\x03\x04\x00\x00", "check FILE", 2, "[broken-file]"),
        Row::new("log.csv", "\u{feff}", "check FILE", 2, "[empty-log]"),
        Row::new("log.csv", ",,,,,\n,,,,,\n", "check FILE", 2, "[empty-log]"),
        Row::new("log.csv", "a\"b\"c\n\"\"\"\n", "check FILE", 2, "[empty-log]"),
        Row::new("back.csv", "{\"rate_hz\": 5}\n", "check FILE", 2, "[unknown-format]"),
        Row::new("log.json", "{", "check FILE", 2, "[unknown-format] | log.json"),
        Row::new("log.json", "[1, 2", "check FILE", 2, "[empty-log] | log.json:1:"),
        Row::new("log.hdf5", b"\x89HDF\r\n\x1a\n", "check FILE", 2, "[unknown-format]"),
        Row::new("log.xlsx", "no zip", "check FILE", 2, "[empty-log]"),
        Row::new("log.tdms", "TDSm\u{e}", "check FILE", 2, "[unknown-format] | TDMS"),
        // Rows that do not fit.
        check("log.csv", table(60, 30, "0.030,1.0"), "[ragged-row] | log.csv:32:"),
        check("log.csv", table(60, 30, "0.030,1.0,2.0,3.0"), "[ragged-row] | log.csv:32:"),
        check("log.csv", table(60, 30, "0.030,twelve,2.0"), "[not-a-number] | log.csv:32:"),
        check("log.csv", table(60, 30, "0.030,\"1.0,2.0"), "[not-a-number] | log.csv:32: | force"),
        check("log.csv", table(100, 999, "") + &lines("", 50, |k| format!("x,{k},{k}")), "[not-a-number]"),
        check("cc.csv", lines("Zeit [s],Kraft [N],a [g]\n", 40, |k| format!("0,{k:03},12,{k},3,{k}")), "[ragged-row]"),
        // Time that does not run on.
        check("log.csv", table(60, 30, "0.029,1.0,2.0"), "[bad-time] | line 32"),
        check("log.csv", table(60, 30, "0.010,1.0,2.0"), "[bad-time] | line 32"),
        check("eq.csv", lines("t [s],a\n", 40, |k| format!("1.5,{k}")), "[bad-time]"),
        check("log.csv", lines("t [s],a\n", 300, |k| format!("{:.6},{}", 10f64.powf(0.05 * k as f64), k % 7)), "[bad-time]"),
        check("log.csv", lines("t [s],a\n", 200, |k| format!("{k}.5,{}", k % 7)) + "1e300,3\n", "[bad-time]"),
        check("log.csv", lines("t [s],a\n", 200, |k| format!("{k}e-300,{}", k % 7)), "[out-of-range]"),
        check("log.csv", lines("t [s],a\n", 200, |k| format!("-{k},{}", k % 7)), "[rate-unknown]"),
        check("log.csv", lines("t [s],a\n", 200, |k| format!("{k}e305,{}", k % 7)), "[out-of-range] | sample rate"),
        rate("5 kHz/ch"), rate("-5 Hz"), rate("5 rpm"), rate("1/5000 s"),
        Row::new("log.csv", "1.0\n2.0\n3.0\n1.5\n", "check FILE", 2, "[rate-unknown]"),
        // Too little, or nothing in it.
        Row::new("log.csv", HEAD, "check FILE", 2, "[empty-log]"),
        check("log.csv", table(1, 9, ""), "[too-short] | --rate"),
        Row::new("log.csv", table(5, 9, ""), IDENTIFY, 2, "[too-short]"),
        Row::new("log.csv", table(5, 9, ""), "spectrum FILE --channel a", 0, "[no-line]"),
        Row::new("log.csv", constant("0"), IDENTIFY, 2, "[no-signal] | force"),
        Row::new("log.csv", constant("2.5"), IDENTIFY, 2, "[no-signal] | force"),
        Row::new("log.csv", constant("NaN"), IDENTIFY, 2, "[no-signal] | force | holds no number"),
        Row::new("log.csv", constant(""), IDENTIFY, 2, "[no-signal] | force"),
        Row::new("log.csv", constant("inf"), IDENTIFY, 2, "[no-signal] | force"),
        Row::new("log.csv", driven(|x| format!("{x:.5}e290")), IDENTIFY, 2, "[out-of-range] | force | e28"),
        Row::new("log.csv", lines(HEAD, 4000, |k| { let x = (k * k % 997) as f64; format!("{:.3},{x},{x}", k as f64 * 1e-3) }), IDENTIFY, 2, "[conflict]"),
        // What the flags ask for cannot be done, or would do nothing.
        Row::new("log.csv", driven(noise), "identify FILE --input force --output a --order 9999", 2, "[out-of-range] | 500"),
        Row::new("log.csv", driven(noise), "identify FILE --input force --output a --method plscf --delay common", 2, "[usage] | --delay"),
        Row::new("log.csv", driven(noise), "identify FILE --input force --output a --method lsce --allow-unstable", 2, "[usage] | --allow-unstable"),
        Row::new("log.csv", driven(noise), "identify FILE --output a --kind mobility", 2, "[usage] | --kind"),
        Row::new("log.csv", driven(noise), "identify FILE --input force --output a --rate 1e300", 2, "[out-of-range] | --rate 1e300"),
        Row::new("log.csv", driven(noise), "identify FILE --input force --output a --rate 0", 2, "[out-of-range] | --rate 0"),
        Row::new("log.csv", driven(noise), "identify FILE --input force --output a --band 600:900", 2, "[out-of-range] | 500 Hz"),
        Row::new("log.csv", driven(noise), "identify FILE --input forse --output a", 2, "[no-channel] | forse"),
        Row::new("log.csv", driven(noise), "identify FILE --input force --output force", 2, "[conflict] | force"),
        Row::new("log.csv", driven(noise), "identify FILE --input force --output a --frf r.csv --method ar", 2, "[usage] | ar takes no input"),
        Row::new("log.csv", driven(noise), "spectrum FILE --channel a --resolution 1e300", 2, "[out-of-range] | --resolution 1e300"),
        Row::new("log.csv", driven(noise), "spectrum FILE --channel a --kind order --tacho force --pulses 0", 2, "[out-of-range] | --pulses"),
        Row::new("log.csv", driven(noise), "check FILE --delimiter nonsense", 2, "delimiter"),
        Row::new("log.csv", driven(noise), "check FILE --encoding nonsense", 2, "encoding"),
        Row::new("log.csv", driven(noise), "check FILE --header-lines 99999999", 2, "[out-of-range] | --header-lines 99999999"),
        Row::new("log.csv", driven(noise), "check FILE --time nowhere", 2, "[no-channel] | nowhere"),
        Row::new("log.csv", driven(noise), "convert FILE --to log.csv", 2, "[usage] | log.csv"),
        Row::new("log.csv", driven(noise), "convert FILE --to /dev/full.csv", 0, "wrote"),
        Row::new("t.csv", lines("time [s],tacho [V],a [g]\n", 4000, |k| format!("{:.3},{},{}", k as f64 * 1e-3, if k % 200 < 20 { 5.0 } else { 0.0 }, k % 7)), "spectrum FILE --channel a --kind order --tacho tacho --pulses 60", 2, "[too-short] | less than one turn"),
        // Universal files.
        check("log.uff", uff("NaN"), "[broken-file] | log.uff:15:"),
        check("log.uff", uff("inf"), "[broken-file] | log.uff:15:"),
        Row::new("log.uff", uff("0.5"), "check FILE", 0, "1 … 3 Hz"),
        Row::new("log.uff", uff("2.0").replace("         6         3", "         6 999999999"), "check FILE", 0, "[values-missing] | 999999999"),
        check("log.uff", uff("2.0").replace("         6         3", "         6        -3"), "[broken-file]"),
        check("log.uff", uff("2.0").replace("         6         3", "        99         3"), "[broken-file]"),
        check("log.uff", uff("2.0")[..400].to_string(), "[empty-log]"),
        check("log.uff", uff("2.0").trim_end_matches("0E+00\n    -1\n").to_string(), "[broken-file] | cut short"),
        check("log.uff", "    -1\n    58\n".into(), "[broken-file]"),
        check("log.uff", "    -1\n   151\n    -1\n".into(), "[empty-log] | 151"),
        check("log.uff", "    -1\n    58b     1     2          11   999999999     0     0           0           0\nx\n".into(), "[broken-file]"),
        // Sound.
        Row::new("hall.wav", wav(1, 1, 8000, 16, 255, b"\x01"), "check FILE", 2, "[broken-file] | --> hall.wav"),
        Row::new("hall.wav", wav(1, 1, 8000, 16, 255, b"\x01"), "check FILE --json", 2, "\"file\": \"hall.wav\""),
        Row::new("hall.wav", wav(1, 0, 8000, 16, 4, b"\x01\x02\x03\x04"), "check FILE", 2, "[broken-file]"),
        Row::new("hall.wav", wav(1, 1, 0, 16, 4, b"\x01\x02\x03\x04"), "check FILE", 2, "[broken-file] | 0 Hz"),
        Row::new("hall.wav", wav(1, 1, 8000, 0, 4, b"\x01\x02\x03\x04"), "check FILE", 2, "[broken-file]"),
        Row::new("hall.wav", wav(77, 1, 8000, 16, 4, b"\x01\x02\x03\x04"), "check FILE", 2, "[unknown-format]"),
        Row::new("hall.wav", wav(1, 1, 8000, 16, 0, b""), "check FILE", 2, "[empty-log]"),
        Row::new("hall.wav", wav(3, 1, 8000, 32, 8, b"\x00\x00\xc0\x7f\x00\x00\xc0\x7f"), "check FILE", 0, "no numbers"),
        Row::new("hall.wav", b"RIFF", "check FILE", 2, "[empty-log] | hall.wav"),
        Row::new("hall.wav", b"RIFF\xff\xff\xff\xffWAVE", "check FILE", 2, "[broken-file]"),
        // MATLAB files.
        Row::new("rig.mat", b"MATLAB 5.0 MAT-file", "check FILE", 2, "[broken-file] | rig.mat"),
        Row::new("rig.mat", mat(b""), "check FILE", 2, "[empty-log]"),
        Row::new("rig.mat", mat(b"\x0e\x00\x00\x00\xff\xff\xff\xff"), "check FILE", 2, "[broken-file] | --> rig.mat"),
        Row::new("rig.mat", mat(b"\x0f\x00\x00\x00\x08\x00\x00\x00notdeflt"), "check FILE", 2, "[broken-file]"),
        Row::new("rig.mat", mat(b"\x0e\x00\x00\x00\x00\x00\x00\x00"), "check FILE", 2, "[empty-log] | rig.mat"),
        // LabVIEW.
        check("a.lvm", "LabVIEW Measurement\t\n".into(), "[broken-file] | a.lvm"),
        check("a.lvm", "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\n".into(), "[empty-log] | a.lvm"),
        check("a.lvm", "LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\nChannels\t99999999999\nSamples\t1\nDelta_X\t0\n***End_of_Header***\nX_Value\ta\n0\t1\n".into(), "[broken-file] | a.lvm:4 | 99999999999"),
        // Sidecars.
        check("log.toml", "[log]\nrate = \"fast\"\n".into(), "log.toml:2:"),
        check("log.toml", "[log]\nrate = -5\n".into(), "log.toml:2:"),
        check("log.toml", "[log]\nrate = nan\n".into(), "log.toml:2:"),
        check("log.toml", "[log]\nratte = 5\n".into(), "[unknown-key] | log.toml:2: | ratte | `rate`"),
        check("log.toml", "[log\n".into(), "[syntax] | log.toml:1:"),
        check("log.toml", "log = 1\n".into(), "log.toml:1:"),
        check("log.toml", "[log]\ndelimiter = \"abc\"\n".into(), "log.toml:2:"),
        check("log.toml", "[log]\nheader_lines = -1\n".into(), "log.toml:2:"),
        check("log.toml", "[log]\n[[channel]]\n".into(), "log.toml:2:"),
        Row::new("log.toml", "[log]\n[[channel]]\nname = \"a\"\nunit = \"furlong\"\n", "check FILE", 0, "1 channels"),
    ]
}
