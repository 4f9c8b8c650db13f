//! FRF estimation from a recording: hammer hits, stepped sine, local polynomials or averaged blocks.

mod local;

mod blocks;

mod hits;

use self::blocks::estimate_from_blocks;
pub use self::blocks::welch_options;
use self::hits::estimate_from_hits;
use super::fault_free::{CheckedRecording, SegmentUse};
use super::stepped_sine;
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::recording::frequency_responses::{ChannelLabel, FrequencyResponses};
use crate::recording::signals::{Channel, Recording, SampleTime};
use crate::spectrum::force_pulses;
use crate::spectrum::frf::Estimator;
use crate::spectrum::impact::{HitResponses, RejectReason};
use crate::spectrum::spectra::Spectra;
use crate::spectrum::window::Window;

/// Options for the estimation of frequency responses; `None` selects a value from the data.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrfStudy {
    /// Estimator, by the assumed location of the noise.
    pub estimator: Estimator,
    /// Window of each block.
    pub window: Option<Window>,
    /// Frequency resolution, Hz.
    pub frequency_resolution_hz: Option<f64>,
    /// Overlap of successive blocks, as a share of the block length.
    pub overlap: Option<f64>,
    /// True if the input is a hammer.
    pub impact: Option<bool>,
    /// True if the input is a stepped sine.
    pub stepped: Option<bool>,
    /// Start and end of each dwell, s; detected in the input if empty.
    pub dwells_s: Vec<(f64, f64)>,
}

impl FrfStudy {
    /// True if the study sets no option of the averaging.
    fn is_default(&self) -> bool {
        let kind_only = FrfStudy {
            impact: self.impact,
            stepped: self.stepped,
            dwells_s: self.dwells_s.clone(),
            ..FrfStudy::default()
        };
        *self == kind_only
    }
}

/// Hammer hit of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct HitSummary {
    /// Time of the hit.
    pub moment: SampleTime,
    /// Peak force above the level between hits, in the unit of the input.
    pub peak: f64,
    /// Reason for the rejection; `None` for a used hit.
    pub fault: Option<RejectReason>,
    /// Text of the reason, with the name of a clipped channel.
    pub fault_text: Option<String>,
}

/// Estimated frequency responses with the method, the hits, the resolution limits and the data-quality warnings.
#[derive(Debug)]
pub struct EstimatedResponses {
    /// Estimated responses.
    pub responses: FrequencyResponses,
    /// Description such as `5 hits: 3 used, 1 clipped; H1, 3 averages, 0.25 Hz lines`.
    pub method_text: String,
    /// Hits of a hammer; empty for other inputs.
    pub hits: Vec<HitSummary>,
    /// Responses by hit, if there are several; outputs in the order of `responses`.
    pub hit_responses: Vec<HitResponses>,
    /// True if force pulses last one sample: any mode may be an alias from above half the sample rate.
    pub has_unresolved_pulses: bool,
    /// Power spectral density of the first input by line, and of every channel, where blocks were averaged.
    pub spectra: Option<Spectra>,
    /// Finest available frequency resolution, Hz, for a new request with [`ResolutionRequest::frequency_resolution_hz`]; `None` if the
    /// estimate has the requested one.
    pub finest_resolution_hz: Option<f64>,
    /// Half-power bandwidth in line spacings below which a resonance is smeared; 0 for dwells and for hits with fully decayed response.
    pub smearing_limit_lines: f64,
    /// Standard deviation of frequency within a line due to the window of averaged blocks, Hz; 0 without a window.
    pub smearing_hz: f64,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Requested band and frequency resolution.
#[derive(Debug, Clone, Copy, Default)]
pub struct ResolutionRequest {
    /// Requested band, Hz; `None` for the excited band of the input.
    pub band_hz: Option<(f64, f64)>,
    /// Requested frequency resolution, Hz, as far as the record allows; `None` for that of a first estimate.
    pub frequency_resolution_hz: Option<f64>,
}

/// Minimum block length without a request, samples.
const MIN_DEFAULT_BLOCK: usize = 256;

/// Estimates the responses of `outputs` to `inputs`, channel indices of the recording.
///
/// # Errors
/// Channels without signal, identical channels, a record too short.
pub fn estimate_responses(
    checked: &CheckedRecording,
    inputs: &[usize],
    outputs: &[usize],
    study: &FrfStudy,
    request: ResolutionRequest,
) -> Result<EstimatedResponses, Error> {
    let recording = &checked.recording;
    let indices: Vec<usize> = inputs.iter().chain(outputs).copied().collect();
    let channels: Vec<&Channel> = indices.iter().map(|&c| &recording.channels[c]).collect();
    let is_stepped = study
        .stepped
        .or((!study.dwells_s.is_empty()).then_some(true));
    if is_stepped == Some(true) && inputs.len() > 1 {
        let message =
            "a stepped sine has one input: simultaneous sines of several inputs are not separated";
        return Err(Error::new(Code::Usage, message));
    }
    let beginning = match (study.impact, is_stepped, inputs.len()) {
        (None, _, 1) | (_, None, 1) => first_samples(recording, channels[0])?,
        _ => Vec::new(),
    };
    let is_hammer = match (study.impact, is_stepped, inputs.len()) {
        (Some(stated), ..) => stated,
        (None, None | Some(false), 1) => force_pulses::is_impact(&beginning),
        _ => false,
    };
    let is_step = study.impact.is_none()
        && study.is_default()
        && !is_hammer
        && inputs.len() == 1
        && is_stepped != Some(true)
        && force_pulses::is_stepwise(&beginning);
    let is_stepped = match (is_stepped, inputs.len()) {
        (Some(stated), _) => stated,
        (None, 1) if !is_hammer && !is_step && study.is_default() => {
            stepped_sine::is_stepped_sine(&beginning, recording.rate_hz)
        }
        _ => false,
    };
    let prepend = |mut result: EstimatedResponses, diagnostics: Vec<Diagnostic>| {
        result.diagnostics.splice(0..0, diagnostics);
        result
    };
    if is_stepped {
        let estimated = estimate_from_dwells(recording, &channels, study)?;
        let diagnostics = [checked.stuck.clone(), checked.clipped_warnings()].concat();
        return Ok(prepend(estimated, diagnostics));
    }
    match is_hammer {
        true if inputs.len() > 1 => {
            let message = "an impact test has one input, the force of the hammer";
            Err(Error::new(Code::Usage, message))
        }
        true => Ok(prepend(
            estimate_from_hits(checked, &indices, study, false)?,
            checked.stuck.clone(),
        )),
        false if is_step => {
            let diagnostics = [checked.stuck.clone(), checked.clipped_warnings()].concat();
            Ok(prepend(
                estimate_from_hits(checked, &indices, study, true)?,
                diagnostics,
            ))
        }
        false => {
            let (recording, diagnostics) = checked.unclipped(SegmentUse::Blocks);
            let frf = estimate_from_blocks(&recording, &channels, inputs.len(), study, request)?;
            Ok(prepend(frf, diagnostics))
        }
    }
}

fn channel_labels(channels: &[&Channel]) -> Vec<ChannelLabel> {
    let label = |c: &&Channel| ChannelLabel {
        name: c.name.clone(),
        unit: c.unit.clone(),
    };
    channels.iter().map(label).collect()
}

/// First samples of a channel, from which the kind of excitation is detected.
fn first_samples(recording: &Recording, channel: &Channel) -> Result<Vec<f64>, Error> {
    const MAX_DETECTION_SAMPLES: usize = 4_000_000;
    let mut samples = vec![0.0; recording.samples.min(MAX_DETECTION_SAMPLES)];
    channel.samples.read(0, &mut samples)?;
    Ok(samples)
}

fn estimate_from_dwells(
    recording: &Recording,
    channels: &[&Channel],
    study: &FrfStudy,
) -> Result<EstimatedResponses, Error> {
    if !study.is_default() {
        let message =
            "a stepped sine is fitted dwell by dwell: there are no blocks, windows or averages";
        return Err(Error::new(Code::Usage, message).with_hint(
            "omit --window, --resolution, --overlap and --estimator, or give --no-stepped",
        ));
    }
    let (responses, method_text, diagnostics) =
        stepped_sine::estimate_responses(recording, channels, &study.dwells_s)?;
    Ok(EstimatedResponses {
        responses,
        method_text,
        hits: Vec::new(),
        hit_responses: Vec::new(),
        has_unresolved_pulses: false,
        spectra: None,
        finest_resolution_hz: None,
        smearing_limit_lines: 0.0,
        smearing_hz: 0.0,
        diagnostics,
    })
}
