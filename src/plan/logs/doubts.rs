//! What the data cannot tell, said beside what they do.

use std::f64::consts::TAU;

use super::acquire::Acquired;
use crate::base::error::Warning;
use crate::identify::mode::IdentifiedMode;
use crate::recording::quantity::ResponseKind;
use crate::recording::responses::{FrequencyResponse, FrequencyResponses, Terminal};
use crate::spectrum::spectra::Spectra;

/// Coherence below which a mode's response is mostly noise.
const LOW_COHERENCE: f64 = 0.8;

/// A resonance narrower than so many lines is smeared by the block it was measured in.
const LEAST_LINES: f64 = 3.0;

/// Fewer independent averages than this leave the variance itself in doubt.
const FEW_AVERAGES: f64 = 5.0;

fn warning(code: &'static str, message: String, hint: &str) -> Warning {
    Warning {
        code,
        message,
        hint: (!hint.is_empty()).then(|| hint.to_string()),
    }
}

/// Coherence at a frequency: of the outputs, the best there.
pub fn coherence_at(responses: &FrequencyResponses, frequency_hz: f64) -> Option<f64> {
    let line = nearest(&responses.frequency_hz, frequency_hz)?;
    let about = |f: &FrequencyResponse| -> Option<f64> {
        let coherence = f.coherence.as_ref()?;
        let near = &coherence[line.saturating_sub(1)..(line + 2).min(coherence.len())];
        near.iter().copied().reduce(f64::max)
    };
    responses
        .functions
        .iter()
        .filter_map(about)
        .reduce(f64::max)
}

fn nearest(lines: &[f64], frequency_hz: f64) -> Option<usize> {
    let above = lines.partition_point(|&f| f < frequency_hz);
    let candidates = [above.checked_sub(1), (above < lines.len()).then_some(above)];
    let off = |&line: &usize| (lines[line] - frequency_hz).abs();
    candidates
        .into_iter()
        .flatten()
        .min_by(|a, b| off(a).total_cmp(&off(b)))
}

/// Doubts that the kind of each response raises.
pub fn of_kinds(responses: &FrequencyResponses) -> Vec<Warning> {
    fn kind(f: &FrequencyResponse) -> Option<(&Terminal, ResponseKind)> {
        let input = f.input.as_ref()?;
        Some((input, ResponseKind::of(&input.unit, &f.output.unit)))
    }
    let ratio = responses.functions.iter().find_map(|f| {
        kind(f)
            .filter(|k| k.1 == ResponseKind::Transmissibility)
            .map(|k| (k.0, f))
    });
    ratio
        .map(|(input, f)| {
            let message = format!(
                "{} over {} is a transmissibility ({} over {}): its poles are those of the structure held at {}, not its modes",
                f.output.name, input.name, f.output.unit, input.unit, input.name
            );
            warning("transmissibility", message, "name the channel of the force as --input, or leave --input out")
        })
        .into_iter()
        .collect()
}

/// Doubts about modes found in measured responses.
pub fn of_modes(
    responses: &FrequencyResponses,
    acquired: Option<&Acquired>,
    modes: &[IdentifiedMode],
) -> Vec<Warning> {
    let mut all = Vec::new();
    let names = |picked: Vec<String>| picked.join(", ");
    let hertz = |m: &IdentifiedMode| format!("{:.4} Hz", m.frequency_hz());
    let low: Vec<String> = modes
        .iter()
        .filter(|m| coherence_at(responses, m.frequency_hz()).is_some_and(|c| c < LOW_COHERENCE))
        .map(hertz)
        .collect();
    if !low.is_empty() {
        let message = format!("coherence is below {LOW_COHERENCE} at {}", names(low));
        all.push(warning(
            "low-coherence",
            message,
            "drive harder there, take more averages, or look for a second source",
        ));
    }
    let step = responses
        .frequency_hz
        .windows(2)
        .map(|w| w[1] - w[0])
        .reduce(f64::min)
        .unwrap_or(0.0);
    // A force window and a response that has decayed leave no leakage; blocks cut from steady vibration do.
    let cut_from_steady = acquired.is_some_and(|a| a.spectra.is_some());
    let narrow: Vec<String> = modes
        .iter()
        .filter(|m| 2.0 * m.damping_ratio() * m.frequency_hz() < LEAST_LINES * step)
        .map(hertz)
        .collect();
    if cut_from_steady && !narrow.is_empty() {
        let message = format!(
            "the half-power bandwidth is below {LEAST_LINES} lines at {}: leakage makes damping look larger there",
            names(narrow)
        );
        all.push(warning(
            "leakage",
            message,
            "take longer blocks: a smaller --resolution, from a longer record",
        ));
    }
    if let Some(n) = responses.averages.filter(|n| *n < FEW_AVERAGES && *n > 1.0) {
        let message = format!(
            "{n:.1} independent averages: the intervals rest on a variance known to a factor of two at best"
        );
        all.push(warning(
            "few-averages",
            message,
            "take a longer record or more hits",
        ));
    }
    if let Some(spectra) = acquired.and_then(|a| a.spectra.as_ref()) {
        all.extend(of_spectra(spectra, modes, &channels(responses)));
    }
    all
}

/// The channels behind responses: the inputs, then the outputs.
fn channels(responses: &FrequencyResponses) -> Vec<&str> {
    let inputs = (responses.functions.iter()).filter_map(|f| Some(f.input.as_ref()?.name.as_str()));
    let outputs = responses.functions.iter().map(|f| f.output.name.as_str());
    let mut all: Vec<&str> = Vec::new();
    for name in inputs.chain(outputs) {
        if !all.contains(&name) {
            all.push(name);
        }
    }
    all
}

/// Doubts about the spectra behind the responses: channel 0 is the first input.
fn of_spectra(spectra: &Spectra, modes: &[IdentifiedMode], channels: &[&str]) -> Vec<Warning> {
    let mut all = Vec::new();
    let Some(input) = spectra.psd.first() else {
        return all;
    };
    // A force that swells at the modes is answered by the motion it drives: a shaker's force dips there.
    const SWELLS: f64 = 10.0;
    let swells = |m: &&IdentifiedMode| {
        let half_width = (m.damping_ratio() * m.frequency_hz()).max(2.0 * spectra.bandwidth_hz);
        let within = |low: f64, high: f64| -> Option<f64> {
            let from = spectra.frequency_hz.partition_point(|&f| f < low);
            let to = spectra.frequency_hz.partition_point(|&f| f < high);
            let part = input.get(from..to).filter(|p| !p.is_empty())?;
            Some(part.iter().sum::<f64>() / part.len() as f64)
        };
        let f = m.frequency_hz();
        let (here, below, above) = (
            within(f - half_width, f + half_width),
            within(f - 12.0 * half_width, f - 6.0 * half_width),
            within(f + 6.0 * half_width, f + 12.0 * half_width),
        );
        matches!((here, below, above), (Some(here), Some(below), Some(above)) if here > SWELLS * below.max(above))
    };
    let closed: Vec<String> = modes
        .iter()
        .filter(swells)
        .map(|m| format!("{:.4} Hz", m.frequency_hz()))
        .collect();
    if !closed.is_empty() {
        let message = format!(
            "the input itself peaks at {}: force and motion may feed each other (a cut with regeneration, a shaker without control), which biases H1",
            closed.join(", ")
        );
        all.push(warning(
            "closed-loop",
            message,
            "identify with an excitation that is independent of the motion, such as a hammer",
        ));
    }
    for (channel, psd) in spectra.psd.iter().enumerate() {
        let n = psd.len();
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len().max(1) as f64;
        let (top, all_lines) = (mean(&psd[n - n / 20 - 1..]), mean(&psd[1..]));
        // Without a filter in front of the converter the spectrum does not fall towards half the rate.
        const FOLDED: f64 = 1.0;
        if top > FOLDED * all_lines && n > 40 {
            let message = format!(
                "{} has as much power near half the sample rate as elsewhere: aliasing cannot be told from signal",
                channels.get(channel).unwrap_or(&"a channel")
            );
            all.push(warning(
                "aliasing",
                message,
                "measure with an anti-alias filter, or at a higher rate",
            ));
            break;
        }
    }
    all
}

/// The shift an exponential window puts on a damping ratio.
pub fn window_damping(decay: f64, frequency_hz: f64) -> f64 {
    decay / (TAU * frequency_hz)
}
