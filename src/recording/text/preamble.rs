//! Preamble parser: `key: value`, `key,value`, `key=value` and comment lines, with sample rate, start and number of samples.

use super::cells::{CellIter, Separators};
use super::figure::{parse_number_with_unit, unit_factor};
use crate::base::error::Diagnostic;
use crate::recording::stated_rates::{BARE_RATE, StatedRate};

/// Metadata and timing stated by the preamble.
#[derive(Debug, Default)]
pub struct Preamble {
    /// Keys and values as written.
    pub metadata: Vec<(String, String)>,
    /// Sample rates, in the order of the lines.
    pub rates: Vec<StatedRate>,
    /// Stated sample rate that cannot be read, if there is no other.
    pub invalid_rate: Option<InvalidRate>,
    /// Stated number of samples.
    pub samples: Option<usize>,
    /// Date and time of the start as written.
    pub start: Option<String>,
    /// Warnings of ambiguous rates.
    pub diagnostics: Vec<Diagnostic>,
}

/// Stated sample rate that cannot be read.
#[derive(Debug, Clone, PartialEq)]
pub struct InvalidRate {
    /// Line of the file, from 1.
    pub line: usize,
    /// Reason why the rate is invalid.
    pub message: String,
}

/// Keys of a sample rate, folded.
const RATE_KEYS: &[&str] = &[
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
    "sr",
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

/// Keys of the sample interval, folded.
const INTERVAL_KEYS: &[&str] = &[
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
const COUNT_KEYS: &[&str] = &[
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

/// Keys of the start time, folded.
const START_KEYS: &[&str] = &[
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

/// Removes the comment mark of a line and surrounding blanks.
pub fn strip_comment(line: &str) -> &str {
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

/// Reads the preamble from numbered lines.
pub fn read(lines: &[(usize, &str)], marks: Separators) -> Preamble {
    let mut preamble = Preamble::default();
    for &(number, line) in lines {
        let bare = strip_comment(line);
        if bare.is_empty() {
            continue;
        }
        let parts: Vec<&str> = if bare.matches('=').count() > 1 {
            bare.split([',', ';']).collect()
        } else {
            vec![bare]
        };
        for part in parts {
            let (key, value) = split_key_value(part, marks)
                .unwrap_or_else(|| (format!("line {number}"), part.trim().to_string()));
            preamble.apply_key(number, &key, &value, marks.decimal);
            preamble.metadata.push((key, value));
        }
    }
    preamble
}

/// Splits a line into key and value; `None` without both.
fn split_key_value(line: &str, marks: Separators) -> Option<(String, String)> {
    let delimiter = char::from(marks.delimiter);
    let separator = line.char_indices().find(|&(at, c)| match c {
        ':' => {
            let before = line[..at].chars().last();
            let path = line[at + 1..].starts_with(['\\', '/']);
            !path && !before.is_some_and(|b| b.is_ascii_digit())
        }
        '：' | '=' | '\t' => true,
        c => c == delimiter && c != ' ',
    });
    if let Some((at, c)) = separator {
        let key = unquote(&line[..at]);
        let rest = &line[at + c.len_utf8()..];
        let has_letters = key.chars().any(char::is_alphabetic);
        if has_letters && (c == delimiter || c == '\t') {
            let cells = CellIter::new(rest.as_bytes(), c as u8);
            let texts = cells.map(|(start, cell)| unquote(&rest[start..start + cell.len()]));
            let values: Vec<&str> = texts.filter(|t| !t.is_empty()).collect();
            let key = key.trim_end_matches([':', '=']).trim().to_string();
            return (!values.is_empty()).then(|| (key, values.join(", ")));
        }
        let value = unquote(rest.trim_end_matches(delimiter));
        return (has_letters && !value.is_empty()).then(|| (key.to_string(), value.to_string()));
    }
    if let Some((key, value)) = line.split_once(" - ") {
        return Some((unquote(key).to_string(), unquote(value).to_string()));
    }
    // Format `fs 5000 Hz`: words, then a number.
    let digit = line.find(|c: char| c.is_ascii_digit() || c == '.')?;
    let key = line[..digit].trim();
    let is_known = unit_after(key, RATE_KEYS).is_some() || unit_after(key, INTERVAL_KEYS).is_some();
    is_known.then(|| (key.to_string(), line[digit..].trim().to_string()))
}

fn unquote(text: &str) -> &str {
    text.trim().trim_matches('"').trim()
}

/// Folds a key to words separated by single spaces, and returns the unit in its brackets.
fn fold_key(key: &str) -> (String, &str) {
    let (name, unit) = match key.find(['[', '(']) {
        Some(at) => (
            &key[..at],
            key[at..].trim_matches(['[', ']', '(', ')', ' ']),
        ),
        None => (key, ""),
    };
    let is_separator = |c: char| c.is_whitespace() || matches!(c, '_' | '-' | '.' | '\'' | '’');
    let words: Vec<&str> = name.split(is_separator).filter(|w| !w.is_empty()).collect();
    (words.join(" "), unit)
}

/// Unit of a key of `table`, in its brackets or as its last word; `None` for other keys.
fn unit_after(key: &str, table: &[&str]) -> Option<String> {
    let is_key = |key: &str| table.contains(&key.to_lowercase().as_str());
    let (key, unit) = fold_key(key);
    if is_key(&key) {
        return Some(unit.to_string());
    }
    let (stem, last) = key.rsplit_once(' ')?;
    let is_unit = unit_factor(last, true).is_some() || unit_factor(last, false).is_some();
    (is_unit && is_key(stem)).then(|| last.to_string())
}

impl Preamble {
    /// Stores the rate, number of samples or start time stated by a key.
    fn apply_key(&mut self, line: usize, key: &str, value: &str, decimal: u8) {
        match parse_rate(key, value, decimal) {
            Some(Ok(rate)) => self.push_rate(rate, key),
            Some(Err(message)) if self.rates.is_empty() && self.invalid_rate.is_none() => {
                self.invalid_rate = Some(InvalidRate { line, message });
            }
            _ => {}
        }
        if unit_after(key, COUNT_KEYS).is_some() && self.samples.is_none() {
            let count = parse_number_with_unit(value, decimal)
                .map(|f| f.number)
                .ok();
            self.samples = count
                .filter(|c| *c >= 1.0 && c.fract() == 0.0)
                .map(|c| c as usize);
        }
        if unit_after(key, START_KEYS).is_some() && value.chars().any(|c| c.is_ascii_digit()) {
            self.start = Some(match self.start.take() {
                Some(earlier) => format!("{earlier} {value}"),
                None => value.to_string(),
            });
        }
    }

    /// Stores a rate; warns if its mark may be a decimal mark instead of a thousands separator.
    fn push_rate(&mut self, rate: PreambleRate, key: &str) {
        let hertz = rate.hertz;
        if let (Some((digits, other)), true) = (rate.ambiguity, self.rates.is_empty()) {
            self.diagnostics.push(Diagnostic {
                code: "header-rate-mark",
                message: format!(
                    "`{key}` states {digits}: its mark is taken for that of thousands, since it is not the decimal mark of the file, and the rate for {hertz} Hz, not {other} Hz"
                ),
                hint: Some(format!("state it if it is not: --rate \"{other} Hz\"")),
            });
        }
        self.invalid_rate = None;
        self.rates.push(StatedRate {
            hertz,
            key: key.to_string(),
            is_bare: rate.is_bare,
        });
    }
}

/// Sample rate stated by a key, Hz.
struct PreambleRate {
    hertz: f64,
    /// Digits as written and the rate, Hz, if their mark is the decimal one instead.
    ambiguity: Option<(String, f64)>,
    /// Whether the key is [`BARE_RATE`] and the unit does not mention samples.
    is_bare: bool,
}

/// Sample rate stated by a key, or the reason why it cannot be read; `None` for other keys and for values without a number.
fn parse_rate(key: &str, value: &str, decimal: u8) -> Option<Result<PreambleRate, String>> {
    let rate_unit = unit_after(key, RATE_KEYS);
    let interval_unit = unit_after(key, INTERVAL_KEYS);
    let key_unit = rate_unit.as_ref().or(interval_unit.as_ref())?;
    let starts_number = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | ',');
    if !value.trim().starts_with(starts_number) || !value.contains(|c: char| c.is_ascii_digit()) {
        return None;
    }
    Some(read_rate(
        key,
        value,
        decimal,
        key_unit,
        rate_unit.is_some(),
    ))
}

fn read_rate(
    key: &str,
    value: &str,
    decimal: u8,
    key_unit: &str,
    is_rate: bool,
) -> Result<PreambleRate, String> {
    let stated = parse_number_with_unit(value, decimal)
        .map_err(|reason| format!("`{key}` states the sample rate, but {reason}"))?;
    let unit = match stated.unit {
        "" => key_unit,
        unit => unit,
    };
    // The unit takes precedence: a "rate" of 0.2 ms is an interval.
    let hertz = |number: f64| match (unit_factor(unit, true), unit_factor(unit, false)) {
        (Some(hertz), _) => Some(number * hertz),
        (None, Some(seconds)) => Some(1.0 / (number * seconds)),
        (None, None) if !unit.is_empty() => None,
        (None, None) if is_rate => Some(number),
        (None, None) => Some(1.0 / number),
    };
    let Some(rate) = hertz(stated.number) else {
        return Err(format!(
            "`{key}` states {value}, and \"{unit}\" is no unit of a sample rate"
        ));
    };
    if !(rate.is_finite() && rate > 0.0) {
        return Err(format!("`{key}` states {value}, which no sample rate is"));
    }
    let alternative = stated.alternative.and_then(hertz);
    let mentions_samples = !unit.is_empty() && !unit.to_lowercase().ends_with("hz");
    Ok(PreambleRate {
        hertz: rate,
        is_bare: fold_key(key).0.eq_ignore_ascii_case(BARE_RATE) && !mentions_samples,
        ambiguity: alternative.map(|rate| (stated.digits.to_string(), rate)),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const COMMA: Separators = Separators {
        delimiter: b',',
        decimal: b'.',
    };

    /// Sample rates in common notations.
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
            let rates = read(&[(1, line)], COMMA).rates;
            let close = |r: &StatedRate| (r.hertz - rate).abs() < 1e-9 * rate;
            assert!(
                rates.iter().all(close) && rates.len() == 1,
                "{line}: {rates:?}"
            );
        }
        for line in [
            "baud rate: 9600",
            "C:\\data\\fs\\5000.txt",
            "Rate: none",
            "heart rate: 60",
        ] {
            assert_eq!(read(&[(1, line)], COMMA).invalid_rate, None, "{line}");
            assert_eq!(read(&[(1, line)], COMMA).rates, [], "{line}");
        }
        let bare = |line| read(&[(1, line)], COMMA).rates[0].is_bare;
        assert!(bare("rate: 25") && bare("Rate (Hz): 25"));
        assert!(!bare("rate: 25 S/s") && !bare("sample rate: 25"));
    }

    /// Thousands separators by the decimal mark of the file; an ambiguous rate raises a warning.
    #[test]
    fn exact_thousands_of_rates() {
        let cases = [
            ("51,200 Hz", '.', 51200.0, true),
            ("51.200 Hz", '.', 51.2, false),
            ("51.200 Hz", ',', 51200.0, true),
            ("51,200 Hz", ',', 51.2, false),
            ("51 200 Hz", '.', 51200.0, false),
            ("51'200 Hz", '.', 51200.0, false),
            ("1,000,000 Hz", '.', 1e6, false),
            ("51.200,00 Hz", '.', 51200.0, false),
            ("51.200,00 Hz", ',', 51200.0, false),
            ("51,2 kHz", '.', 51200.0, false),
            ("5 mHz", '.', 5e-3, false),
            ("5 MHz", '.', 5e6, false),
            ("0.200 ms", ',', 5000.0, false),
            ("5000 Hz (nominal)", '.', 5000.0, false),
            ("5000, 5000", '.', 5000.0, false),
            ("100 samples per second", '.', 100.0, false),
        ];
        for (text, decimal, rate, warns) in cases {
            let marks = Separators {
                decimal: decimal as u8,
                ..COMMA
            };
            let line = format!("Sample rate: {text}");
            let header = read(&[(1, &line)], marks);
            let close = |r: f64| (r / rate - 1.0).abs() < 1e-12;
            let is_close = header.rates.first().is_some_and(|r| close(r.hertz));
            assert!(is_close, "{text} {decimal}: {:?}", header.rates);
            assert_eq!(!header.diagnostics.is_empty(), warns, "{text} {decimal}");
        }
    }

    /// A stated rate that cannot be read is reported.
    #[test]
    fn refuses_rates_that_cannot_be_read() {
        for text in [
            "5 kHz/ch",
            "5k",
            "5 N",
            "5 rpm",
            "10 m/s",
            "1/5000 s",
            "0 Hz",
            "-5 Hz",
            "1e400 Hz",
            "5000.0.1",
            "5 mhz",
            "51, 200, Hz",
            "12:30:00",
        ] {
            let line = format!("Sample rate: {text}");
            let header = read(&[(7, &line)], COMMA);
            assert_eq!(header.rates, [], "{text}");
            assert_eq!(header.invalid_rate.map(|u| u.line), Some(7), "{text}");
        }
    }
}
