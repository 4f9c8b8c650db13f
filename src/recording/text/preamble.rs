//! Lines above the names: `key: value`, `key,value`, `key=value`, comments; the sample rate where one of them states it.

use super::cells::{self, Cells, Marks};
use crate::base::error::Warning;

/// What the preamble says.
#[derive(Debug, Default)]
pub struct Preamble {
    /// Keys and values as written.
    pub facts: Vec<(String, String)>,
    /// Sample rate, Hz, and the key that states it.
    pub rate: Option<(f64, String)>,
    /// Stated number of samples.
    pub samples: Option<usize>,
    /// Date and time of the start as written.
    pub start: Option<String>,
    /// Statements that contradict each other.
    pub warnings: Vec<Warning>,
}

/// Keys of a sample rate, folded.
const RATES: &[&str] = &[
    "sampling frequency",
    "sample frequency",
    "sampling rate",
    "sample rate",
    "samplerate",
    "samplingrate",
    "samplefrequency",
    "samplingfrequency",
    "sampling freq",
    "sample freq",
    "samplefreq",
    "scan rate",
    "scan frequency",
    "acquisition rate",
    "acquisition frequency",
    "data rate",
    "logging rate",
    "output data rate",
    "odr",
    "fs",
    "f s",
    "fs hz",
    "srate",
    "rate",
    "abtastrate",
    "abtastfrequenz",
    "messrate",
    "samples per second",
    "samples/s",
    "frequence d echantillonnage",
    "fréquence d échantillonnage",
    "frecuencia de muestreo",
    "frequenza di campionamento",
    "采样频率",
    "采样率",
    "采样速率",
    "частота дискретизации",
];

/// Keys of the time between samples, folded.
const INTERVALS: &[&str] = &[
    "sampling interval",
    "sample interval",
    "samplinginterval",
    "sampleinterval",
    "sampling time",
    "sample time",
    "sampling period",
    "sample period",
    "time step",
    "timestep",
    "time interval",
    "time increment",
    "dt",
    "delta t",
    "delta x",
    "deltax",
    "delta time",
    "x increment",
    "xincrement",
    "x incr",
    "xincr",
    "x inc",
    "increment",
    "interval",
    "scan interval",
    "ts",
    "abtastintervall",
    "abtastzeit",
    "schrittweite",
    "采样间隔",
    "采样周期",
    "采样时间",
    "шаг",
];

/// Keys of the number of samples, folded.
const COUNTS: &[&str] = &[
    "samples",
    "number of samples",
    "sample count",
    "no of samples",
    "num samples",
    "n samples",
    "record length",
    "points",
    "number of points",
    "num points",
    "npts",
    "n points",
    "rows",
    "number of rows",
    "anzahl werte",
    "anzahl messwerte",
    "采样点数",
    "点数",
];

/// Keys of the start, folded.
const STARTS: &[&str] = &[
    "start",
    "start time",
    "start date",
    "date time",
    "datetime",
    "date/time",
    "time stamp",
    "timestamp",
    "date",
    "time",
    "recorded",
    "recorded at",
    "recording time",
    "created",
    "startzeit",
    "beginn",
    "datum",
    "messbeginn",
    "日期",
    "开始时间",
    "采集时间",
    "测试时间",
];

/// A line without the sign that makes it a comment.
pub fn uncommented(line: &str) -> &str {
    let line = line.trim();
    let bare = line.trim_start_matches(['#', '%', '!']);
    let bare = bare.strip_prefix("//").unwrap_or(bare);
    bare.trim()
}

/// Whether a line is marked as a comment.
pub fn is_comment(line: &str) -> bool {
    let line = line.trim_start();
    line.starts_with(['#', '%', '!']) || line.starts_with("//")
}

/// What the lines, each with its number, say.
pub fn read(lines: &[(usize, &str)], marks: Marks) -> Preamble {
    let mut preamble = Preamble::default();
    for &(number, line) in lines {
        let bare = uncommented(line);
        if bare.is_empty() {
            continue;
        }
        let parts: Vec<&str> = if bare.matches('=').count() > 1 {
            bare.split([',', ';']).collect()
        } else {
            vec![bare]
        };
        for part in parts {
            let (key, value) = pair(part, marks)
                .unwrap_or_else(|| (format!("line {number}"), part.trim().to_string()));
            preamble.learn(&key, &value, marks.decimal);
            preamble.facts.push((key, value));
        }
    }
    preamble
}

/// Key and value of a line, where it has both.
fn pair(line: &str, marks: Marks) -> Option<(String, String)> {
    let delimiter = char::from(marks.delimiter);
    let splits = line.char_indices().find(|&(at, c)| match c {
        ':' => {
            let before = line[..at].chars().last();
            let path = line[at + 1..].starts_with(['\\', '/']);
            !path && !before.is_some_and(|b| b.is_ascii_digit())
        }
        '：' | '=' | '\t' => true,
        c => c == delimiter && c != ' ',
    });
    if let Some((at, c)) = splits {
        let key = unquoted(&line[..at]);
        let rest = &line[at + c.len_utf8()..];
        let named = key.chars().any(char::is_alphabetic);
        if named && (c == delimiter || c == '\t') {
            let cells = Cells::new(rest.as_bytes(), c as u8);
            let texts = cells.map(|(start, cell)| unquoted(&rest[start..start + cell.len()]));
            let values: Vec<&str> = texts.filter(|t| !t.is_empty()).collect();
            let key = key.trim_end_matches([':', '=']).trim().to_string();
            return (!values.is_empty()).then(|| (key, values.join(", ")));
        }
        let value = unquoted(rest.trim_end_matches(delimiter));
        return (named && !value.is_empty()).then(|| (key.to_string(), value.to_string()));
    }
    if let Some((key, value)) = line.split_once(" - ") {
        return Some((unquoted(key).to_string(), unquoted(value).to_string()));
    }
    // `fs 5000 Hz`: words, then a number.
    let digit = line.find(|c: char| c.is_ascii_digit() || c == '.')?;
    let key = line[..digit].trim();
    let known = stated(key, RATES).is_some() || stated(key, INTERVALS).is_some();
    known.then(|| (key.to_string(), line[digit..].trim().to_string()))
}

fn unquoted(text: &str) -> &str {
    text.trim().trim_matches('"').trim()
}

/// A key in lower case without signs between words; and the unit in its brackets or after it.
fn folded(key: &str) -> (String, String) {
    let (name, unit) = match key.find(['[', '(']) {
        Some(at) => (
            &key[..at],
            key[at..].trim_matches(['[', ']', '(', ')', ' ']),
        ),
        None => (key, ""),
    };
    let spaced: String = name
        .chars()
        .map(|c| {
            if matches!(c, '_' | '-' | '.' | '\'' | '’') {
                ' '
            } else {
                c
            }
        })
        .collect();
    let words: Vec<String> = spaced.split_whitespace().map(str::to_lowercase).collect();
    (words.join(" "), unit.to_lowercase())
}

/// The unit after a key of `table` (in the key's brackets, or its last word), where the key is one of them.
fn stated(key: &str, table: &[&str]) -> Option<String> {
    let (key, unit) = folded(key);
    if table.contains(&key.as_str()) {
        return Some(unit);
    }
    let (front, last) = key.rsplit_once(' ')?;
    let known = factor(last, true).is_some() || factor(last, false).is_some();
    (known && table.contains(&front)).then(|| last.to_string())
}

/// Hertz in one of a rate's units, or seconds in one of an interval's.
fn factor(unit: &str, rate: bool) -> Option<f64> {
    Some(match (unit, rate) {
        (
            "hz" | "s/s" | "sa/s" | "sps" | "samples/s" | "samples/sec" | "samples per second"
            | "1/s",
            true,
        ) => 1.0,
        ("khz" | "ks/s" | "ksa/s" | "ksps", true) => 1e3,
        ("mhz" | "ms/s" | "msa/s" | "msps", true) => 1e6,
        ("s" | "sec" | "secs" | "second" | "seconds", false) => 1.0,
        ("ms" | "msec" | "milliseconds", false) => 1e-3,
        ("us" | "µs" | "μs" | "usec" | "microseconds", false) => 1e-6,
        ("ns", false) => 1e-9,
        ("min" | "minutes", false) => 60.0,
        _ => return None,
    })
}

/// The number a value starts with, and the unit after it.
fn quantity(value: &str, decimal: u8) -> Option<(f64, String)> {
    let value = value.trim();
    let end = value
        .find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | ',' | '+' | '-' | 'e' | 'E')))
        .unwrap_or(value.len());
    let digits = value[..end].trim_end_matches(['e', 'E', ',', '+', '-']);
    let parsed = [decimal, b'.', b',']
        .into_iter()
        .find_map(|mark| cells::number(digits.as_bytes(), mark));
    let unit = value[digits.len()..].trim_matches([' ', '[', ']', '(', ')', ',', ';']);
    Some((parsed?, unit.to_lowercase()))
}

impl Preamble {
    /// Takes what a key says of the clock.
    fn learn(&mut self, key: &str, value: &str, decimal: u8) {
        if let Some(hertz) = rate_of(key, value, decimal) {
            self.note_rate(hertz, key);
        }
        if stated(key, COUNTS).is_some() && self.samples.is_none() {
            let count = quantity(value, decimal).map(|q| q.0);
            self.samples = count
                .filter(|c| *c >= 1.0 && c.fract() == 0.0)
                .map(|c| c as usize);
        }
        if stated(key, STARTS).is_some() && value.chars().any(|c| c.is_ascii_digit()) {
            self.start = Some(match self.start.take() {
                Some(earlier) => format!("{earlier} {value}"),
                None => value.to_string(),
            });
        }
    }

    /// Keeps the first rate; another one that differs is a doubt.
    fn note_rate(&mut self, hertz: f64, key: &str) {
        // The same tolerance by which stamps and header are compared.
        const SAME: f64 = 1e-3;
        match &self.rate {
            None => self.rate = Some((hertz, key.to_string())),
            Some((first, name)) if (first - hertz).abs() > SAME * first => {
                self.warnings.push(Warning {
                    code: "header-rates-differ",
                    message: format!(
                        "`{name}` states {first} Hz and `{key}` {hertz} Hz; `{name}` is taken"
                    ),
                    hint: Some("state the rate: --rate".into()),
                });
            }
            Some(_) => {}
        }
    }
}

/// The sample rate a key states, Hz.
fn rate_of(key: &str, value: &str, decimal: u8) -> Option<f64> {
    let by_rate = stated(key, RATES);
    let by_interval = stated(key, INTERVALS);
    let unit_of_key = by_rate.as_ref().or(by_interval.as_ref())?;
    let (number, unit) = quantity(value, decimal)?;
    let first_word = unit.split([' ', ',', ';']).next().unwrap_or("").to_string();
    let units = [unit.as_str(), first_word.as_str(), unit_of_key.as_str()];
    let find = |rate| units.iter().find_map(|u| factor(u, rate));
    // The unit decides: a "rate" of 0.2 ms is an interval.
    let hertz = match (find(true), find(false)) {
        (Some(hertz), _) => number * hertz,
        (None, Some(seconds)) => 1.0 / (number * seconds),
        (None, None) if by_rate.is_some() => number,
        (None, None) => 1.0 / number,
    };
    (hertz.is_finite() && hertz > 0.0).then_some(hertz)
}

#[cfg(test)]
mod tests {
    use super::*;

    const COMMA: Marks = Marks {
        delimiter: b',',
        decimal: b'.',
    };

    /// The rate in the ways labs state it.
    #[test]
    fn exact_rates_of_preambles() {
        let cases = [
            ("Sampling Frequency - 5000", 5000.0),
            ("Sample rate,51200,Hz", 51200.0),
            ("fs=1.28 kHz", 1280.0),
            ("# dt: 0.2 ms", 5000.0),
            ("Delta_X,0.0005,0.0005", 2000.0),
            ("Sampling interval [us],100", 1e4),
            ("Abtastrate: 2000 Hz", 2000.0),
            ("sampling_frequency_hz: 400", 400.0),
            ("采样频率：1000Hz", 1000.0),
            ("\"Sample Rate\",\"2500\"", 2500.0),
            ("% fs = 100, channels = 3", 100.0),
            ("Rate: 10 kS/s", 1e4),
            ("Sample interval: 1.0E-3", 1000.0),
            ("fs 5000 Hz", 5000.0),
        ];
        for (line, rate) in cases {
            let found = read(&[(1, line)], COMMA).rate;
            let close = |r: f64| (r - rate).abs() < 1e-9 * rate;
            assert!(
                found.clone().is_some_and(|f| close(f.0)),
                "{line}: {found:?}"
            );
        }
        for line in [
            "baud rate: 9600",
            "C:\\data\\fs\\5000.txt",
            "Rate: none",
            "heart rate: 60",
            "fs: 0",
        ] {
            assert_eq!(read(&[(1, line)], COMMA).rate, None, "{line}");
        }
        assert_eq!(
            read(&[(1, "fs: 100"), (2, "dt: 0.02")], COMMA)
                .warnings
                .len(),
            1
        );
    }
}
