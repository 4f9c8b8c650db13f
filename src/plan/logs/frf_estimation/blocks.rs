//! FRFs by averages over blocks, or by local polynomials within the excited band.

use super::super::{excited_band, sample_blocks};
use super::local::{LocalEstimate, estimate_local};
use super::{EstimatedResponses, FrfStudy, MIN_DEFAULT_BLOCK, ResolutionRequest, channel_labels};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text::pluralise;
use crate::recording::frequency_responses::FrequencyResponses;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::frf::{self, Estimator};
use crate::spectrum::welch::{WelchEstimator, WelchOptions};
use crate::spectrum::window::{Window, line_correlation, smearing_lines};

/// Minimum number of blocks by default: enough for an estimate of the variance.
const MIN_DEFAULT_BLOCKS: usize = 16;

/// Longest default block, samples.
const MAX_DEFAULT_BLOCK: usize = 1 << 16;

/// Resonance width, lines, below which the window of averaged blocks smears a resonance.
const WINDOW_SMEARING_LINES: f64 = 3.0;

/// Samples of a window for quantities that do not depend on the block length.
const WINDOW_SAMPLES: usize = 256;

/// Minimum number of samples of a spectrum.
const MIN_SAMPLES: usize = 4;

pub(super) fn estimate_from_blocks(
    recording: &Recording,
    channels: &[&Channel],
    inputs: usize,
    study: &FrfStudy,
    request: ResolutionRequest,
) -> Result<EstimatedResponses, Error> {
    let options = welch_options(recording, study)?;
    let channel_indices: Vec<usize> = (0..channels.len()).collect();
    let (ins, outs) = channel_indices.split_at(inputs);
    let mut estimator = WelchEstimator::new(
        recording.rate_hz,
        channels.len(),
        &frf::required_pairs(ins, outs),
        &options,
    )?;
    sample_blocks::average(recording, channels, &mut estimator)?;
    let spectra = estimator.finish()?;
    // The main lobe of the window spreads the mean over the first lines; anti-aliasing filters distort the last ones.
    const BAND_EDGE_SHARE: f64 = 0.95;
    let (lines, top) = (
        &spectra.frequency_hz,
        BAND_EDGE_SHARE * recording.rate_hz / 2.0,
    );
    let full = lines.get(3).map(|&low| (low, top)).filter(|b| b.0 < b.1);
    let excited = excited_band::of_inputs(&spectra, ins).map(|(low, high)| match full {
        Some((lowest, highest)) => (low.max(lowest).min(highest), high.min(highest)),
        None => (low, high),
    });
    let usable_hz = excited.or(full);
    let mut how_driven = String::new();
    if let (None, Some((low, high))) = (request.band_hz, excited.filter(|_| excited != full)) {
        how_driven = format!(
            "; the input has power, within {:.0} dB of its plateau, from {low:.4} to {high:.4} Hz",
            -10.0 * excited_band::PLATEAU_POWER_SHARE.log10()
        );
    }
    let band = request.band_hz.or(usable_hz).filter(|_| study.is_default());
    let average = || frf::estimate(&spectra, ins, outs, study.estimator);
    // A local estimate only detects that inputs are coherent; averages show the lines on which they are not distinguished.
    let averaged = if inputs > 1 { Some(average()?) } else { None };
    let inputs_are_distinct = |band: &(f64, f64)| {
        let is_in_band = |&k: &usize| (band.0..=band.1).contains(&spectra.frequency_hz[k]);
        averaged
            .as_ref()
            .is_none_or(|averaged| !averaged.undetermined_lines.iter().any(is_in_band))
    };
    let local = match band.filter(inputs_are_distinct) {
        Some(band) => estimate_local(
            recording,
            channels,
            inputs,
            band,
            request.frequency_resolution_hz,
        )?,
        None => None,
    };
    if let Some(LocalEstimate {
        estimate,
        method_text,
        finest_resolution_hz: finest_hz,
        smearing_limit_lines: limit_lines,
    }) = local
    {
        return Ok(EstimatedResponses {
            responses: FrequencyResponses {
                usable_band_hz: usable_hz,
                independent_lines_per_line: Some(1.0),
                ..estimate.to_frequency_responses(&channel_labels(channels))
            },
            method_text: method_text + &how_driven,
            hits: Vec::new(),
            hit_responses: Vec::new(),
            has_unresolved_pulses: false,
            finest_resolution_hz: Some(finest_hz),
            smearing_limit_lines: limit_lines,
            smearing_hz: 0.0,
            diagnostics: estimate.diagnostics,
            spectra: Some(spectra),
        });
    }
    let estimate = averaged.map_or_else(average, Ok)?;
    let name = match study.estimator {
        Estimator::H1 => "H1",
        Estimator::H2 => "H2",
        Estimator::Hv => "Hv",
    };
    let method_text = format!(
        "{name}, {} blocks of {:.4} s ({} window, {:.0} % overlap): {:.1} independent averages, {:.4} Hz lines{how_driven}",
        spectra.blocks,
        options.block as f64 / recording.rate_hz,
        options.window.name(),
        100.0 * options.overlap,
        estimate.averages,
        recording.rate_hz / options.block as f64
    );
    Ok(EstimatedResponses {
        responses: FrequencyResponses {
            usable_band_hz: usable_hz,
            independent_lines_per_line: Some(independent_lines_per_line(options.window)),
            ..estimate.to_frequency_responses(&channel_labels(channels))
        },
        method_text,
        hits: Vec::new(),
        hit_responses: Vec::new(),
        has_unresolved_pulses: false,
        finest_resolution_hz: None,
        smearing_limit_lines: WINDOW_SMEARING_LINES,
        smearing_hz: smearing_lines(&options.window.samples(WINDOW_SAMPLES)) * recording.rate_hz
            / options.block as f64,
        diagnostics: estimate.diagnostics,
        spectra: Some(spectra),
    })
}

/// Block length, window and overlap: as requested, else from the length of the record.
///
/// # Errors
/// No segment is long enough for the requested resolution, or for a spectrum.
pub fn welch_options(recording: &Recording, study: &FrfStudy) -> Result<WelchOptions, Error> {
    let longest = recording
        .segments
        .iter()
        .map(|s| s.len())
        .max()
        .unwrap_or(0);
    let block = match study.frequency_resolution_hz {
        Some(df) => {
            let block = (recording.rate_hz / df).round();
            if !(block >= 8.0 && block <= longest as f64) {
                let message = format!(
                    "a resolution of {df} Hz needs blocks of {block:.0} samples; the longest segment has {longest}"
                );
                let hint = format!(
                    "request at least {:.6} Hz",
                    recording.rate_hz / longest.max(1) as f64
                );
                return Err(Error::new(Code::OutOfRange, message).with_hint(hint));
            }
            block as usize
        }
        None => {
            let count_blocks = |block: usize| -> usize {
                recording.segments.iter().map(|s| s.len() / block).sum()
            };
            let mut block = MAX_DEFAULT_BLOCK;
            while block > MIN_DEFAULT_BLOCK && count_blocks(block) < MIN_DEFAULT_BLOCKS {
                block /= 2;
            }
            if longest < MIN_SAMPLES {
                let message = format!(
                    "the longest segment of {} has {}: too few for a block",
                    recording.path,
                    pluralise(longest, "sample")
                );
                return Err(Error::new(Code::TooShort, message)
                    .with_hint("take a longer record, or interpolate short gaps: --fill-gaps"));
            }
            block.min(longest)
        }
    };
    Ok(WelchOptions {
        block,
        overlap: study.overlap.unwrap_or(0.5),
        window: study.window.unwrap_or(Window::Hann),
        ..WelchOptions::default()
    })
}

/// Number of independent lines per line under a window: `1/Σ|ρ_m|²` over the correlations ρ_m of neighbouring lines.
pub(super) fn independent_lines_per_line(window: Window) -> f64 {
    const REACH: usize = 12;
    let w = window.samples(WINDOW_SAMPLES);
    let variance = line_correlation(&w, 0).norm();
    let sum: f64 = (1..=REACH)
        .map(|m| (line_correlation(&w, m).norm() / variance).powi(2))
        .sum();
    1.0 / (1.0 + 2.0 * sum)
}
