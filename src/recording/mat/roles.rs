//! What a variable of a MATLAB file is, by its name and its numbers.

use super::variables::Variable;
use crate::recording::raw::rate_of_step;
use crate::recording::stated_rates::{BARE_RATE, StatedRate};

/// Names of vectors of time.
const TIME: &[&str] = &[
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
const RATE: &[&str] = &[
    "fs",
    "sr",
    "srate",
    "fsamp",
    "fsample",
    "samplefreq",
    "samplefrequency",
];

/// What names of the sample rate end in, Hz.
const RATE_ENDS: &[&str] = &[
    "samplerate",
    "samplingrate",
    "samplingfrequency",
    "samplingfreq",
    "sampfreq",
];

/// Names of the time from sample to sample, s.
const STEP: &[&str] = &["dt", "deltat", "ts", "tsample", "deltax"];

/// What names of the time from sample to sample end in, s.
const STEP_ENDS: &[&str] = &[
    "sampletime",
    "samplingtime",
    "samplinginterval",
    "sampleinterval",
    "samplingperiod",
    "timestep",
];

/// Names of vectors of frequency, Hz.
const FREQUENCY: &[&str] = &["f", "ff", "fhz", "fvec", "hz", "faxis"];

/// Names of vectors of circular frequency, rad/s.
const CIRCULAR: &[&str] = &["w", "omega", "wrad"];

/// How far a uniform vector may stray from a straight line, in steps: single precision over 10⁴ samples strays 10⁻³.
const STRAIGHT: f64 = 0.01;

fn is_named(word: &str, names: &[&str], ends: &[&str]) -> bool {
    names.contains(&word) || ends.iter().any(|end| word.ends_with(end))
}

/// The sample rate a scalar states.
pub(super) fn rate(variable: &Variable) -> Option<StatedRate> {
    let (&[value], None) = (variable.re.as_slice(), &variable.im) else {
        return None;
    };
    let word = variable.word();
    let is_bare = word == BARE_RATE;
    let hertz = if is_bare || is_named(&word, RATE, RATE_ENDS) {
        value
    } else if is_named(&word, STEP, STEP_ENDS) {
        rate_of_step(value)
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
    is_real_vector(variable) && TIME.contains(&variable.word().as_str())
}

/// A real vector that rises by equal steps from zero or near it, and does not merely count the samples.
pub(super) fn is_uniform(variable: &Variable) -> bool {
    let x = &variable.re;
    let (true, [first, .., last]) = (is_real_vector(variable), x.as_slice()) else {
        return false;
    };
    let step = (last - first) / (x.len() - 1) as f64;
    let straight =
        |(i, &x): (usize, &f64)| (x - (first + i as f64 * step)).abs() <= STRAIGHT * step;
    step > 0.0
        && step != 1.0
        && *first >= 0.0
        && *first <= 2.0 * step
        && x.iter().enumerate().all(straight)
}

/// Frequencies of a rising vector named so, Hz.
pub(super) fn frequencies(variable: &Variable) -> Option<Vec<f64>> {
    let word = variable.word();
    let is_hertz = FREQUENCY.contains(&word.as_str()) || word.starts_with("freq");
    let is_circular = CIRCULAR.contains(&word.as_str());
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

/// What lies over the lines of a frequency vector.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Over {
    Response,
    Coherence,
    /// A spectrum, by the word that is used of it.
    Spectrum(&'static str),
}

/// What numbers over frequency are, by name; complex ones are responses unless the name speaks of a spectrum.
pub(super) fn over_frequency(variable: &Variable) -> Over {
    let word = variable.word();
    let has = |parts: &[&str]| parts.iter().any(|part| word.contains(part));
    if has(&["coh"]) && variable.im.is_none() {
        Over::Coherence
    } else if has(&["cross", "csd", "gxy", "sxy"]) {
        Over::Spectrum("cross spectrum")
    } else if has(&["psd", "density"]) {
        Over::Spectrum("power spectral density")
    } else if has(&["spec", "auto", "fft"]) || variable.im.is_none() {
        Over::Spectrum("spectrum")
    } else {
        Over::Response
    }
}
