//! Diagnostics on data quality: coherence, spectral lines per mode, averages, aliasing.

use std::f64::consts::TAU;

use super::frf_estimation::EstimatedResponses;
use crate::base::error::Diagnostic;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::Complex;
use crate::recording::channel_unit::ResponseKind;
use crate::recording::frequency_responses::{FrequencyResponse, FrequencyResponses};
use crate::spectrum::spectra::Spectra;

/// Coherence below which noise dominates a mode's response.
const MIN_COHERENCE: f64 = 0.8;

/// Fewest spectral lines per resonance not smeared by a block: two or three define a pole, a few more confirm it.
const MIN_LINES_PER_MODE: f64 = 4.0;

/// Number of independent averages below which the variance itself is uncertain.
const MIN_AVERAGES: f64 = 5.0;

fn warning(code: &'static str, message: String, hint: &str) -> Diagnostic {
    Diagnostic {
        code,
        message,
        hint: (!hint.is_empty()).then(|| hint.to_string()),
    }
}

/// Highest coherence of the outputs at a frequency, Hz; `None` without coherence.
pub fn coherence_at(responses: &FrequencyResponses, frequency_hz: f64) -> Option<f64> {
    let line = nearest(&responses.frequency_hz, frequency_hz)?;
    let best = |f: &FrequencyResponse| -> Option<f64> {
        let coherence = f.coherence.as_ref()?;
        let adjacent = &coherence[line.saturating_sub(1)..(line + 2).min(coherence.len())];
        adjacent.iter().copied().reduce(f64::max)
    };
    responses.responses.iter().filter_map(best).reduce(f64::max)
}

fn nearest(lines: &[f64], frequency_hz: f64) -> Option<usize> {
    let above = lines.partition_point(|&f| f < frequency_hz);
    let candidates = [above.checked_sub(1), (above < lines.len()).then_some(above)];
    let distance = |&line: &usize| (lines[line] - frequency_hz).abs();
    candidates
        .into_iter()
        .flatten()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
}

/// Warnings about transmissibilities and inverse responses, whose poles are not those of the modes.
pub fn check_response_kinds(responses: &FrequencyResponses) -> Vec<Diagnostic> {
    let kind_warning = |f: &FrequencyResponse| {
        let (input, output) = (f.input.as_ref()?, &f.output);
        let quotient = format!("{} over {}", output.name, input.name);
        let units = format!("{} over {}", output.unit, input.unit);
        match ResponseKind::from_units(&input.unit, &output.unit) {
            ResponseKind::Transmissibility => {
                let message = format!(
                    "{quotient} is a transmissibility ({units}): its poles are those of the structure held at {}, not its modes",
                    input.name
                );
                let hint = "name the channel of the force as --input, or omit --input";
                Some(warning("transmissibility", message, hint))
            }
            ResponseKind::ForceOverMotion(_) => {
                let message = format!(
                    "{quotient} is a force over a motion ({units}): its poles are the zeros of the structure's responses, not its modes"
                );
                let hint = "swap --input and --output: the force is the excitation";
                Some(warning("inverse-response", message, hint))
            }
            _ => None,
        }
    };
    responses
        .responses
        .iter()
        .find_map(kind_warning)
        .into_iter()
        .collect()
}

/// Warning about a stated motion quantity that contradicts the units of the responses.
pub fn check_stated_kind(responses: &FrequencyResponses, stated: Option<u8>) -> Option<Diagnostic> {
    const KINDS: [&str; 3] = ["a receptance", "a mobility", "an accelerance"];
    let stated = stated?;
    let f = responses.responses.first()?;
    let input = f.input.as_ref()?;
    match ResponseKind::from_units(&input.unit, &f.output.unit) {
        ResponseKind::MotionOverForce(times) if times != stated => {
            let message = format!(
                "{} over {} is {} by its units, {} over {}; taken as {} by --kind",
                f.output.name,
                input.name,
                KINDS[usize::from(times.min(2))],
                f.output.unit,
                input.unit,
                KINDS[usize::from(stated.min(2))]
            );
            Some(warning(
                "kind-differs",
                message,
                "omit --kind, or state the units: --unit",
            ))
        }
        _ => None,
    }
}

/// Warning about a poor fit: a misfit above half the response, on the lines where the response exceeds its variance. `fitted` gives
/// the synthesised responses at a line, Hz.
pub fn check_fit(
    responses: &FrequencyResponses,
    band_hz: (f64, f64),
    fitted: impl Fn(f64) -> Vec<Complex>,
) -> Option<Diagnostic> {
    const MAX_MISFIT: f64 = 0.5;
    /// |H|² over its variance.
    const MIN_SIGNAL_TO_NOISE: f64 = 3.0;
    let mut sums = vec![(0.0, 0.0); responses.responses.len()];
    for (k, &f) in responses.frequency_hz.iter().enumerate() {
        // A residual term of modes below the band has no value at 0 Hz.
        if !(band_hz.0..=band_hz.1).contains(&f) || f <= 0.0 || !responses.is_determined(k) {
            continue;
        }
        let fitted = fitted(f);
        for ((sum, function), fitted) in sums.iter_mut().zip(&responses.responses).zip(&fitted) {
            let (h, variance) = (function.values[k], function.variance.as_ref().map(|v| v[k]));
            if variance.is_none_or(|v| h.norm_sqr() > MIN_SIGNAL_TO_NOISE * v) {
                *sum = (sum.0 + (h - fitted).norm_sqr(), sum.1 + h.norm_sqr());
            }
        }
    }
    let misfits: Vec<String> = (responses.responses.iter().zip(sums))
        .map(|(f, (sum, size))| (f, if size > 0.0 { (sum / size).sqrt() } else { 0.0 }))
        .filter(|(_, error)| !(*error <= MAX_MISFIT))
        .map(|(f, error)| format!("{} by {:.0} %", f.output.name, 100.0 * error))
        .collect();
    (!misfits.is_empty()).then(|| {
        let message = format!(
            "the fit differs from {} of its size: the residual may bias modes and intervals",
            misfits.join(", ")
        );
        warning("poor-fit", message, "use another --method or a narrower --band; check whether input and output are the right channels")
    })
}

/// True if a response exceeds its variance on more lines of a band than by chance.
pub fn has_significant_response(responses: &FrequencyResponses, band_hz: (f64, f64)) -> bool {
    // |H|² over its variance exceeds this by chance on one line in a hundred, and on one in thirty if the variance is from few averages;
    // a window correlates neighbouring lines.
    const LINE_SIGNIFICANCE: f64 = 12.0;
    const CHANCE_SHARE: f64 = 0.03;
    const GROUP_SIGNIFICANCE: f64 = 3.0;
    let in_band: Vec<usize> = (0..responses.frequency_hz.len())
        .filter(|&k| (band_hz.0..=band_hz.1).contains(&responses.frequency_hz[k]))
        .collect();
    let is_significant = |f: &FrequencyResponse| {
        let Some(variance) = &f.variance else {
            return true;
        };
        let exceeds = |&&k: &&usize| f.values[k].norm_sqr() > LINE_SIGNIFICANCE * variance[k];
        let count = in_band.iter().filter(exceeds).count() as f64;
        let expected = CHANCE_SHARE * in_band.len() as f64;
        count > expected + GROUP_SIGNIFICANCE * (GROUP_SIGNIFICANCE * expected).sqrt()
    };
    in_band.is_empty() || responses.responses.iter().any(is_significant)
}

/// Warnings about modes identified from measured responses.
pub fn check_modes(
    responses: &FrequencyResponses,
    estimated_responses: Option<&EstimatedResponses>,
    modes: &[ModalParameters],
) -> Vec<Diagnostic> {
    let mut warnings = Vec::new();
    let list = |frequencies: Vec<String>| frequencies.join(", ");
    let hertz = |m: &ModalParameters| format!("{:.4} Hz", m.frequency_hz());
    let incoherent: Vec<String> = modes
        .iter()
        .filter(|m| coherence_at(responses, m.frequency_hz()).is_some_and(|c| c < MIN_COHERENCE))
        .map(hertz)
        .collect();
    if !incoherent.is_empty() {
        let message = format!("coherence is below {MIN_COHERENCE} at {}", list(incoherent));
        warnings.push(warning(
            "low-coherence",
            message,
            "excite more strongly there, take more averages, or check for a second source",
        ));
    }
    let step = responses
        .frequency_hz
        .windows(2)
        .map(|w| w[1] - w[0])
        .reduce(f64::min)
        .unwrap_or(0.0);
    let min_lines = estimated_responses.map_or(0.0, |a| a.smearing_limit_lines);
    let narrow: Vec<String> = modes
        .iter()
        .filter(|m| 2.0 * m.damping_ratio() * m.frequency_hz() < min_lines * step)
        .map(hertz)
        .collect();
    if !narrow.is_empty() {
        let (effect, hint) = match estimated_responses.and_then(|a| a.finest_resolution_hz) {
            Some(_) => (
                "the length of the record limits it, and damping may be wrong by a few per cent",
                "take a longer record",
            ),
            None => (
                "leakage biases damping upwards there",
                "take longer blocks: a smaller --resolution, from a longer record",
            ),
        };
        let message = format!(
            "the half-power bandwidth is below {min_lines} lines at {}: {effect}",
            list(narrow)
        );
        warnings.push(warning("leakage", message, hint));
    }
    warnings.extend(check_line_count(responses, estimated_responses, modes));
    if let Some(n) = responses.averages.filter(|n| *n < MIN_AVERAGES && *n > 1.0) {
        let has_intervals = modes.iter().any(|m| m.pole_covariance.is_some());
        let message = match has_intervals || modes.is_empty() {
            true => format!(
                "{n:.1} independent averages: the variance behind the intervals is known within a factor of two at best"
            ),
            false => format!(
                "{n:.1} independent averages: too few for intervals of the modes; none are given"
            ),
        };
        warnings.push(warning(
            "few-averages",
            message,
            "take a longer record or more hits",
        ));
    }
    if let Some(spectra) = estimated_responses.and_then(|a| a.spectra.as_ref()) {
        warnings.extend(check_spectra(responses, spectra, modes));
    }
    warnings
}

/// Warning about modes with few lines in the half-power band, for a stepped sine or imported responses. A decay within the block of a hit
/// needs no more lines.
fn check_line_count(
    responses: &FrequencyResponses,
    estimated_responses: Option<&EstimatedResponses>,
    modes: &[ModalParameters],
) -> Option<Diagnostic> {
    if estimated_responses.is_some_and(|a| a.spectra.is_some() || !a.hits.is_empty()) {
        return None;
    }
    let lines = &responses.frequency_hz;
    let n_lines = |m: &ModalParameters| {
        let f = m.frequency_hz();
        let above = lines
            .partition_point(|&line| line < f)
            .clamp(1, lines.len().max(2) - 1);
        let spacing = lines.get(above)? - lines[above - 1];
        Some(2.0 * m.damping_ratio() * f / spacing)
    };
    let few: Vec<String> = (modes.iter())
        .filter_map(|m| n_lines(m).map(|n| (m, n)))
        .filter(|(_, n)| *n < MIN_LINES_PER_MODE)
        .map(|(m, n)| format!("{:.4} Hz ({n:.1})", m.frequency_hz()))
        .collect();
    (!few.is_empty()).then(|| {
        let message = format!(
            "fewer than {MIN_LINES_PER_MODE} lines lie within the half-power width at {}: the fit interpolates between them, and a second mode there, leakage or a wrong line would not be detected",
            few.join(", ")
        );
        warning(
            "coarse-lines",
            message,
            "use a finer frequency resolution there: smaller steps, or a longer record",
        )
    })
}

/// Warnings about feedback to the inputs and aliasing, from the spectra of the responses: inputs first, then outputs.
fn check_spectra(
    responses: &FrequencyResponses,
    spectra: &Spectra,
    modes: &[ModalParameters],
) -> Vec<Diagnostic> {
    let mut warnings = Vec::new();
    let table = responses.index_matrix();
    let inputs = table.first().map_or(&[][..], Vec::as_slice);
    let names: Vec<&str> = (inputs.iter().map(|&f| &responses.responses[f]))
        .filter_map(|f| f.input.as_ref())
        .chain(table.iter().map(|row| &responses.responses[row[0]].output))
        .map(|t| t.name.as_str())
        .collect();
    // A force that peaks at the modes indicates feedback of the motion: the force of a shaker dips there.
    const MAX_POWER_RISE: f64 = 10.0;
    let is_peaked = |input: &[f64], m: &ModalParameters| {
        let half_width = (m.damping_ratio() * m.frequency_hz()).max(2.0 * spectra.bandwidth_hz);
        let mean_power = |low: f64, high: f64| -> Option<f64> {
            let first = spectra.frequency_hz.partition_point(|&f| f < low);
            let end = spectra.frequency_hz.partition_point(|&f| f < high);
            let lines = input.get(first..end).filter(|p| !p.is_empty())?;
            Some(lines.iter().sum::<f64>() / lines.len() as f64)
        };
        let f = m.frequency_hz();
        let (at_mode, below, above) = (
            mean_power(f - half_width, f + half_width),
            mean_power(f - 12.0 * half_width, f - 6.0 * half_width),
            mean_power(f + 6.0 * half_width, f + 12.0 * half_width),
        );
        matches!((at_mode, below, above), (Some(at_mode), Some(below), Some(above)) if at_mode > MAX_POWER_RISE * below.max(above))
    };
    let fed_back: Vec<String> = modes
        .iter()
        .filter(|m| {
            spectra
                .psd
                .iter()
                .take(inputs.len())
                .any(|input| is_peaked(input, m))
        })
        .map(|m| format!("{:.4} Hz", m.frequency_hz()))
        .collect();
    if !fed_back.is_empty() {
        let message = format!(
            "the input spectrum peaks at {}: feedback from motion to force (a cut with regeneration, a shaker without control) biases H1",
            fed_back.join(", ")
        );
        warnings.push(warning(
            "closed-loop",
            message,
            "identify with an excitation that is independent of the motion, such as a hammer",
        ));
    }
    for (channel, psd) in spectra.psd.iter().enumerate() {
        let n = psd.len();
        let mean = |lines: &[f64]| lines.iter().sum::<f64>() / lines.len().max(1) as f64;
        let (top, mean_all) = (mean(&psd[n - n / 20 - 1..]), mean(&psd[1..]));
        // Without an anti-alias filter the spectrum does not fall towards half the sample rate.
        const ALIASING_RATIO: f64 = 1.0;
        if top > ALIASING_RATIO * mean_all && n > 40 {
            let message = format!(
                "{} has as much power near half the sample rate as elsewhere: aliasing cannot be distinguished from signal",
                names.get(channel).unwrap_or(&"a channel")
            );
            warnings.push(warning(
                "aliasing",
                message,
                "measure with an anti-alias filter, or at a higher rate",
            ));
            break;
        }
    }
    warnings
}

/// Increase of a damping ratio by an exponential window of decay rate `decay`, 1/s.
pub fn window_damping_ratio(decay: f64, frequency_hz: f64) -> f64 {
    decay / (TAU * frequency_hz)
}
