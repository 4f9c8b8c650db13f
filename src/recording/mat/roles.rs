//! Role of a MATLAB variable (time, rate, frequency, channel, response) from its name and values.

use super::variables::Variable;
use crate::recording::raw::rate_from_interval;
use crate::recording::stated_rates::{BARE_RATE, StatedRate};

/// Names of vectors of time.
const TIME_NAMES: &[&str] = &[
    "t",
    "time",
    "times",
    "tt",
    "tvec",
    "timevec",
    "timevector",
    "timedomain",
    "timeaxis",
    "timestamp",
    "timestamps",
    "timesec",
];

/// Names of the sample rate, Hz.
const RATE_NAMES: &[&str] = &[
    "fs",
    "sr",
    "srate",
    "fsamp",
    "fsample",
    "samplefreq",
    "samplefrequency",
];

/// Endings of names of the sample rate, Hz.
const RATE_SUFFIXES: &[&str] = &[
    "samplerate",
    "samplingrate",
    "samplingfrequency",
    "samplingfreq",
    "sampfreq",
];

/// Names of the time from sample to sample, s.
const INTERVAL_NAMES: &[&str] = &["dt", "deltat", "ts", "tsample", "deltax"];

/// Endings of names of the time from sample to sample, s.
const INTERVAL_SUFFIXES: &[&str] = &[
    "sampletime",
    "samplingtime",
    "samplinginterval",
    "sampleinterval",
    "samplingperiod",
    "timestep",
];

/// Names of vectors of frequency, Hz.
const FREQUENCY_NAMES: &[&str] = &["f", "ff", "fhz", "fvec", "hz", "faxis"];

/// Names of vectors of circular frequency, rad/s.
const ANGULAR_FREQUENCY_NAMES: &[&str] = &["w", "omega", "wrad"];

/// Largest deviation of a uniform vector from a straight line, in steps: single precision over 10⁴ samples deviates 10⁻³.
const MAX_NONUNIFORMITY: f64 = 0.01;

fn is_named(word: &str, names: &[&str], ends: &[&str]) -> bool {
    names.contains(&word) || ends.iter().any(|end| word.ends_with(end))
}

/// The sample rate a scalar states.
pub(super) fn stated_rate_hz(variable: &Variable) -> Option<StatedRate> {
    let (&[value], None) = (variable.re.as_slice(), &variable.im) else {
        return None;
    };
    let word = variable.normalized_name();
    let is_bare = word == BARE_RATE;
    let hertz = if is_bare || is_named(&word, RATE_NAMES, RATE_SUFFIXES) {
        value
    } else if is_named(&word, INTERVAL_NAMES, INTERVAL_SUFFIXES) {
        rate_from_interval(value)
    } else {
        return None;
    };
    (hertz.is_finite() && hertz > 0.0).then(|| StatedRate {
        hertz,
        key: variable.name.clone(),
        is_bare,
    })
}

/// A real vector with a name of time.
pub(super) fn is_time(variable: &Variable) -> bool {
    is_real_vector(variable) && TIME_NAMES.contains(&variable.normalized_name().as_str())
}

/// A real vector that rises by equal steps from zero or near it, and does not merely count the samples.
pub(super) fn is_uniform(variable: &Variable) -> bool {
    let x = &variable.re;
    let (true, [first, .., last]) = (is_real_vector(variable), x.as_slice()) else {
        return false;
    };
    let step = (last - first) / (x.len() - 1) as f64;
    let straight =
        |(i, &x): (usize, &f64)| (x - (first + i as f64 * step)).abs() <= MAX_NONUNIFORMITY * step;
    step > 0.0
        && step != 1.0
        && *first >= 0.0
        && *first <= 2.0 * step
        && x.iter().enumerate().all(straight)
}

/// Frequencies of a rising vector named so, Hz.
pub(super) fn frequencies_hz(variable: &Variable) -> Option<Vec<f64>> {
    let word = variable.normalized_name();
    let is_hertz = FREQUENCY_NAMES.contains(&word.as_str()) || word.starts_with("freq");
    let is_circular = ANGULAR_FREQUENCY_NAMES.contains(&word.as_str());
    let rises = variable.re.windows(2).all(|pair| pair[0] < pair[1]);
    let starts = variable.re.first().is_some_and(|&first| first >= 0.0);
    if !(is_hertz || is_circular) || !is_real_vector(variable) || !rises || !starts {
        return None;
    }
    let scale = if is_circular {
        std::f64::consts::TAU
    } else {
        1.0
    };
    Some(variable.re.iter().map(|w| w / scale).collect())
}

fn is_real_vector(variable: &Variable) -> bool {
    variable.im.is_none() && variable.is_vector() && variable.length() > 1
}

/// Kind of data over the lines of a frequency vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FrequencyData {
    Response,
    Coherence,
    /// A spectrum, by the word that is used of it.
    Spectrum(&'static str),
}

/// Kind of numbers over frequency, by name; complex ones are responses unless the name speaks of a spectrum.
pub(super) fn frequency_data(variable: &Variable) -> FrequencyData {
    let word = variable.normalized_name();
    let has = |parts: &[&str]| parts.iter().any(|part| word.contains(part));
    if has(&["coh"]) && variable.im.is_none() {
        FrequencyData::Coherence
    } else if has(&["cross", "csd", "gxy", "sxy"]) {
        FrequencyData::Spectrum("cross spectrum")
    } else if has(&["psd", "density"]) {
        FrequencyData::Spectrum("power spectral density")
    } else if has(&["spec", "auto", "fft"]) || variable.im.is_none() {
        FrequencyData::Spectrum("spectrum")
    } else {
        FrequencyData::Response
    }
}
