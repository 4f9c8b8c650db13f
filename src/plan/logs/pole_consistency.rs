//! Consistency of poles over the files of a roving test: modes present in one file only, and poles shifted in a file.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::base::error::Diagnostic;
use crate::base::text::quoted_list;
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::pole_shift::shift_of_misfit;
use crate::identify::rational::RationalFit;
use crate::numeric::Complex;
use crate::recording::frequency_responses::FrequencyResponses;

/// Path of a file and the range of its responses.
pub type FileResponses<'a> = (&'a str, Range<usize>);

/// Minimum share of the squared mode shape in one file at which the mode is local to this file.
const LOCAL_SHARE: f64 = 0.95;

/// Maximum relative frequency distance, and maximum share relative to the mean, at which a mode of the other files replaces a local mode.
const NEIGHBOUR: f64 = 0.05;
const ABSENT: f64 = 0.1;

/// Maximum deviation of a pole shift from the median of the files, in standard deviations and in half-power half-bandwidths.
const SHIFT_SIGMA: f64 = 5.0;
const SHIFT_HALF_WIDTHS: f64 = 0.1;

/// Distance from a pole, in half-power half-bandwidths, of the lines that determine its shift, and their minimum number.
const REACH_HALF_WIDTHS: f64 = 3.0;
const MIN_LINES: usize = 8;

/// Warning that names the files whose poles differ from those of the others.
pub fn check_files(
    files: &[FileResponses],
    responses: &FrequencyResponses,
    fit: &RationalFit,
) -> Option<Diagnostic> {
    let mut names: Vec<&str> = Vec::new();
    let mut messages: Vec<String> = Vec::new();
    for (file, (path, _)) in files.iter().enumerate() {
        let replacements: Vec<String> = (fit.modes.iter())
            .filter_map(|mode| Some((mode, neighbour(files, file, mode, &fit.modes)?)))
            .map(|(mode, other)| {
                format!(
                    "{:.4} in place of {:.4} Hz",
                    mode.frequency_hz(),
                    other.frequency_hz()
                )
            })
            .collect();
        if !replacements.is_empty() {
            names.push(path);
            messages.push(format!("{path} alone shows {}", replacements.join(", ")));
        }
    }
    for mode in &fit.modes {
        for (path, relative) in shifted(files, responses, fit, mode) {
            names.push(path);
            messages.push(format!(
                "{path} places {:.4} Hz {:.3} % {}",
                mode.frequency_hz(),
                100.0 * relative.abs(),
                if relative < 0.0 { "lower" } else { "higher" }
            ));
        }
    }
    names.sort_unstable();
    names.dedup();
    (!messages.is_empty()).then(|| Diagnostic {
        code: "poles-differ",
        message: format!("the files do not share their poles: {}", messages.join("; ")),
        hint: Some(format!(
            "check the mass of the sensor, the mounting and the temperature of {}; repeat it, or omit it",
            quoted_list(names.into_iter())
        )),
    })
}

/// Share of the squared shape of a mode in each file.
fn shares(files: &[FileResponses], mode: &ModalParameters) -> Vec<f64> {
    let energy = |range: &Range<usize>| -> f64 {
        let shape = mode.shape.get(range.clone()).unwrap_or_default();
        shape.iter().map(Complex::norm_sqr).sum()
    };
    let total: f64 = files.iter().map(|f| energy(&f.1)).sum();
    files.iter().map(|f| energy(&f.1) / total).collect()
}

/// Mode of the other files that `local_mode` of `file` replaces; `None` if it is not local or has no counterpart.
fn neighbour<'m>(
    files: &[FileResponses],
    file: usize,
    local_mode: &ModalParameters,
    modes: &'m [ModalParameters],
) -> Option<&'m ModalParameters> {
    let f = local_mode.frequency_hz();
    let is_near = |m: &&ModalParameters| (m.frequency_hz() - f).abs() <= NEIGHBOUR * f;
    let is_absent = |m: &&ModalParameters| shares(files, m)[file] < ABSENT / files.len() as f64;
    let distance = |m: &ModalParameters| (m.frequency_hz() - f).abs();
    (shares(files, local_mode)[file] >= LOCAL_SHARE)
        .then(|| {
            let candidates = modes.iter().filter(is_near).filter(is_absent);
            candidates.min_by(|a, b| distance(a).total_cmp(&distance(b)))
        })
        .flatten()
}

/// Files with a pole shifted from the median of the files, and the relative shift.
fn shifted<'f>(
    files: &[FileResponses<'f>],
    responses: &FrequencyResponses,
    fit: &RationalFit,
    mode: &ModalParameters,
) -> Vec<(&'f str, f64)> {
    let pole = mode.pole;
    let reach = REACH_HALF_WIDTHS * pole.re.abs();
    let is_close = |other: &&Complex| (**other - pole).norm() <= 2.0 * reach;
    if files.len() < 3 || fit.poles.iter().filter(is_close).count() > 1 {
        return Vec::new();
    }
    let lines: Vec<usize> = (0..responses.frequency_hz.len())
        .filter(|&k| (TAU * responses.frequency_hz[k] - pole.im).abs() <= reach)
        .collect();
    if lines.len() < MIN_LINES {
        return Vec::new();
    }
    let lines_hz: Vec<f64> = lines.iter().map(|&k| responses.frequency_hz[k]).collect();
    let fitted: Vec<Vec<Complex>> = lines_hz.iter().map(|&f| fit.synthesise(f)).collect();
    let shift = |range: &Range<usize>| {
        let fit_of = |i: usize| fitted.iter().map(|f| f[i]).collect();
        let fitted: Vec<Vec<Complex>> = range.clone().map(fit_of).collect();
        let measured = |i: usize| {
            lines
                .iter()
                .map(|&k| responses.responses[i].values[k])
                .collect()
        };
        let measured: Vec<Vec<Complex>> = range.clone().map(measured).collect();
        shift_of_misfit(&lines_hz, &measured, &fitted, pole)
    };
    let shifts: Vec<Option<(f64, f64)>> = files.iter().map(|(_, range)| shift(range)).collect();
    let mut sorted: Vec<f64> = shifts.iter().flatten().map(|s| s.0).collect();
    sorted.sort_by(f64::total_cmp);
    if sorted.len() < 3 {
        return Vec::new();
    }
    let median = sorted[sorted.len() / 2];
    let limit = SHIFT_HALF_WIDTHS * pole.re.abs();
    (files.iter().zip(&shifts))
        .filter_map(|(file, shift)| Some((file.0, shift.as_ref()?)))
        .filter(|(_, (shift, std))| (shift - median).abs() > limit.max(SHIFT_SIGMA * std))
        .map(|(path, (shift, _))| (path, (shift - median) / pole.im))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PATHS: [&str; 4] = ["a.csv", "b.csv", "c.csv", "d.csv"];

    fn mode(frequency_hz: f64, shape: [f64; 4]) -> ModalParameters {
        let omega = TAU * frequency_hz;
        ModalParameters {
            pole: Complex::new(-0.01 * omega, omega),
            pole_covariance: None,
            shape: shape.map(|x| Complex::new(x, 0.0)).to_vec(),
        }
    }

    /// A mode at 39.4 Hz local to the fourth file replaces one at 40 Hz of the other files, but not one at 60 Hz, nor one that the
    /// fourth file shows as well.
    #[test]
    fn law_modes_of_one_file() {
        let files: Vec<FileResponses> = (0..4).map(|k| (PATHS[k], k..k + 1)).collect();
        let local = mode(39.4, [0.01, 0.0, 0.02, 1.0]);
        let has_neighbour =
            |m: ModalParameters| neighbour(&files, 3, &local, &[local.clone(), m]).is_some();
        assert!(has_neighbour(mode(40.0, [1.0, 0.5, 0.8, 0.02])));
        assert!(!has_neighbour(mode(60.0, [1.0, 0.5, 0.8, 0.02])));
        assert!(!has_neighbour(mode(40.0, [1.0, 0.5, 0.8, 0.5])));
    }
}
