//! Poles that differ between the files of a roving test: modes of one file in place of those of the others, or poles that a file shifts.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::base::error::Diagnostic;
use crate::base::text::quoted_list;
use crate::identify::modal_parameters::ModalParameters;
use crate::identify::pole_shift::shift_of_misfit;
use crate::identify::rational::RationalFit;
use crate::numeric::Complex;
use crate::recording::frequency_responses::FrequencyResponses;

/// A file and its responses among all.
pub type FileResponses<'a> = (&'a str, Range<usize>);

/// A mode with this share of its squared shape in one file lives there alone …
const LOCAL_SHARE: f64 = 0.95;

/// … where another mode no further away, relative, has less than this part of a file's mean share there: it is the same mode elsewhere.
const NEIGHBOUR: f64 = 0.05;
const ABSENT: f64 = 0.1;

/// A file shifts a pole where its shift is off the median of the files by so many standard deviations, and half-power half-bandwidths.
const SHIFT_SIGMA: f64 = 5.0;
const SHIFT_HALF_WIDTHS: f64 = 0.1;

/// Lines within so many half-power half-bandwidths of a pole tell its shift; fewer than this tell none.
const REACH_HALF_WIDTHS: f64 = 3.0;
const MIN_LINES: usize = 8;

/// Names the files whose poles are not those of the others.
pub fn check_files(
    files: &[FileResponses],
    responses: &FrequencyResponses,
    fit: &RationalFit,
) -> Option<Diagnostic> {
    let mut names: Vec<&str> = Vec::new();
    let mut messages: Vec<String> = Vec::new();
    for (at, (path, _)) in files.iter().enumerate() {
        let local: Vec<String> = (fit.modes.iter())
            .filter_map(|own| Some((own, neighbour(files, at, own, &fit.modes)?)))
            .map(|(own, other)| {
                format!(
                    "{:.4} in place of {:.4} Hz",
                    own.frequency_hz(),
                    other.frequency_hz()
                )
            })
            .collect();
        if !local.is_empty() {
            names.push(path);
            messages.push(format!("{path} alone shows {}", local.join(", ")));
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
    let of = |range: &Range<usize>| -> f64 {
        let own = mode.shape.get(range.clone()).unwrap_or_default();
        own.iter().map(Complex::norm_sqr).sum()
    };
    let total: f64 = files.iter().map(|f| of(&f.1)).sum();
    files.iter().map(|f| of(&f.1) / total).collect()
}

/// The mode of all other files in whose place file `at` has a mode of its own.
fn neighbour<'m>(
    files: &[FileResponses],
    at: usize,
    own: &ModalParameters,
    modes: &'m [ModalParameters],
) -> Option<&'m ModalParameters> {
    let f = own.frequency_hz();
    let is_near = |m: &&ModalParameters| (m.frequency_hz() - f).abs() <= NEIGHBOUR * f;
    let is_absent = |m: &&ModalParameters| shares(files, m)[at] < ABSENT / files.len() as f64;
    let off = |m: &ModalParameters| (m.frequency_hz() - f).abs();
    (shares(files, own)[at] >= LOCAL_SHARE)
        .then(|| {
            let others = modes.iter().filter(is_near).filter(is_absent);
            others.min_by(|a, b| off(a).total_cmp(&off(b)))
        })
        .flatten()
}

/// The files that place a pole elsewhere than the median file, and by how much, relative.
fn shifted<'f>(
    files: &[FileResponses<'f>],
    responses: &FrequencyResponses,
    fit: &RationalFit,
    mode: &ModalParameters,
) -> Vec<(&'f str, f64)> {
    let pole = mode.pole;
    let reach = REACH_HALF_WIDTHS * pole.re.abs();
    let is_near = |other: &&Complex| (**other - pole).norm() <= 2.0 * reach;
    if files.len() < 3 || fit.poles.iter().filter(is_near).count() > 1 {
        return Vec::new();
    }
    let lines: Vec<usize> = (0..responses.frequency_hz.len())
        .filter(|&k| (TAU * responses.frequency_hz[k] - pole.im).abs() <= reach)
        .collect();
    if lines.len() < MIN_LINES {
        return Vec::new();
    }
    let near_hz: Vec<f64> = lines.iter().map(|&k| responses.frequency_hz[k]).collect();
    let fitted: Vec<Vec<Complex>> = near_hz.iter().map(|&f| fit.synthesise(f)).collect();
    let shift = |range: &Range<usize>| {
        let of_fit = |i: usize| fitted.iter().map(|f| f[i]).collect();
        let fitted: Vec<Vec<Complex>> = range.clone().map(of_fit).collect();
        let measured = |i: usize| {
            lines
                .iter()
                .map(|&k| responses.responses[i].values[k])
                .collect()
        };
        let measured: Vec<Vec<Complex>> = range.clone().map(measured).collect();
        shift_of_misfit(&near_hz, &measured, &fitted, pole)
    };
    let found: Vec<Option<(f64, f64)>> = files.iter().map(|(_, range)| shift(range)).collect();
    let mut known: Vec<f64> = found.iter().flatten().map(|s| s.0).collect();
    known.sort_by(f64::total_cmp);
    if known.len() < 3 {
        return Vec::new();
    }
    let median = known[known.len() / 2];
    let limit = SHIFT_HALF_WIDTHS * pole.re.abs();
    (files.iter().zip(&found))
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

    /// A mode at 39.4 Hz in the fourth file alone, where the others have one at 40 Hz; none in its place at 60 Hz, nor where the other
    /// mode is seen there too.
    #[test]
    fn law_modes_of_one_file() {
        let files: Vec<FileResponses> = (0..4).map(|k| (PATHS[k], k..k + 1)).collect();
        let own = mode(39.4, [0.01, 0.0, 0.02, 1.0]);
        let of =
            |other: ModalParameters| neighbour(&files, 3, &own, &[own.clone(), other]).is_some();
        assert!(of(mode(40.0, [1.0, 0.5, 0.8, 0.02])));
        assert!(!of(mode(60.0, [1.0, 0.5, 0.8, 0.02])));
        assert!(!of(mode(40.0, [1.0, 0.5, 0.8, 0.5])));
    }
}
