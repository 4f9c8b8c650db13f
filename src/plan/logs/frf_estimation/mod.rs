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
use crate::recording::signals::{Channel, Moment, Recording};
use crate::spectrum::force_pulses;
use crate::spectrum::frf::Estimator;
use crate::spectrum::impact::{HitResponses, RejectReason};
use crate::spectrum::spectra::Spectra;
use crate::spectrum::window::Window;

/// Options for the estimation of frequency responses; `None` is chosen from the data.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrfStudy {
    /// Estimator, by the assumed location of the noise.
    pub estimator: Estimator,
    /// On each block.
    pub window: Option<Window>,
    /// Between lines, Hz.
    pub frequency_resolution_hz: Option<f64>,
    /// Share of a block that the next has in common with it.
    pub overlap: Option<f64>,
    /// The input is a hammer.
    pub impact: Option<bool>,
    /// The input dwells on one frequency after another.
    pub stepped: Option<bool>,
    /// From when to when it dwells, s; found in the input where empty.
    pub dwells_s: Vec<(f64, f64)>,
}

impl FrfStudy {
    /// True if the study requests no particular averaging.
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

/// A hit of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct HitSummary {
    /// When it struck.
    pub moment: Moment,
    /// Peak force over the level between hits.
    pub peak: f64,
    /// Why it was rejected; `None` where it was used.
    pub fault: Option<RejectReason>,
    /// The same in words, with the name of the channel that clipped.
    pub fault_text: Option<String>,
}

/// Frequency responses and how they were had.
#[derive(Debug)]
pub struct EstimatedResponses {
    /// The responses.
    pub responses: FrequencyResponses,
    /// In words: `5 hits: 3 used, 1 clipped; H1, 3 averages, 0.25 Hz lines`.
    pub method_text: String,
    /// Hits, where the input is a hammer.
    pub hits: Vec<HitSummary>,
    /// The responses hit by hit, where there are several hits: outputs in the order of `responses`.
    pub by_hit: Vec<HitResponses>,
    /// The pulses of the force last one sample: any mode may be folded down from above half the sample rate.
    pub has_unresolved_pulses: bool,
    /// Power spectral density of the first input by line, and of every channel, where blocks were averaged.
    pub spectra: Option<Spectra>,
    /// Finest available frequency resolution, Hz, by a new request with [`ResolutionRequest::frequency_resolution_hz`]; `None` where it is
    /// as requested.
    pub finest_resolution_hz: Option<f64>,
    /// Resonances narrower than so many lines are smeared: none by a hit whose response has decayed, nor by a dwell.
    pub smearing_limit_lines: f64,
    /// Standard deviation of the frequencies that the window of averaged blocks joins in a line, Hz; 0 without a window.
    pub smearing_hz: f64,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Requested band and frequency resolution.
#[derive(Debug, Clone, Copy, Default)]
pub struct ResolutionRequest {
    /// Requested band, Hz; in `None` the excited band of the input.
    pub band_hz: Option<(f64, f64)>,
    /// Requested frequency resolution, Hz, as far as the record allows; in `None` enough for a first estimate.
    pub frequency_resolution_hz: Option<f64>,
}

/// The shortest block taken unasked.
const MIN_DEFAULT_BLOCK: usize = 256;

/// Estimates the responses of `outputs` to `inputs`, channels of the recording by place.
///
/// # Errors
/// Channels without signal or alike, a record too short.
pub fn estimate_responses(
    sound: &CheckedRecording,
    inputs: &[usize],
    outputs: &[usize],
    study: &FrfStudy,
    request: ResolutionRequest,
) -> Result<EstimatedResponses, Error> {
    let recording = &sound.recording;
    let chosen: Vec<usize> = inputs.iter().chain(outputs).copied().collect();
    let channels: Vec<&Channel> = chosen.iter().map(|&c| &recording.channels[c]).collect();
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
        (Some(said), ..) => said,
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
        (Some(said), _) => said,
        (None, 1) if !is_hammer && !is_step && study.is_default() => {
            stepped_sine::is_stepped_sine(&beginning, recording.rate_hz)
        }
        _ => false,
    };
    let with = |mut estimated_responses: EstimatedResponses, diagnostics: Vec<Diagnostic>| {
        estimated_responses.diagnostics.splice(0..0, diagnostics);
        estimated_responses
    };
    if is_stepped {
        let found = estimate_from_dwells(recording, &channels, study)?;
        let diagnostics = [sound.stuck.clone(), sound.clipped_warnings()].concat();
        return Ok(with(found, diagnostics));
    }
    match is_hammer {
        true if inputs.len() > 1 => {
            let message = "an impact test has one input, the force of the hammer";
            Err(Error::new(Code::Usage, message))
        }
        true => Ok(with(
            estimate_from_hits(sound, &chosen, study, false)?,
            sound.stuck.clone(),
        )),
        false if is_step => {
            let diagnostics = [sound.stuck.clone(), sound.clipped_warnings()].concat();
            Ok(with(
                estimate_from_hits(sound, &chosen, study, true)?,
                diagnostics,
            ))
        }
        false => {
            let (recording, diagnostics) = sound.unclipped(SegmentUse::Blocks);
            let found = estimate_from_blocks(&recording, &channels, inputs.len(), study, request)?;
            Ok(with(found, diagnostics))
        }
    }
}

fn channel_labels(channels: &[&Channel]) -> Vec<ChannelLabel> {
    let terminal = |c: &&Channel| ChannelLabel {
        name: c.name.clone(),
        unit: c.unit.clone(),
    };
    channels.iter().map(terminal).collect()
}

/// First samples of a channel, by which its kind is detected.
fn first_samples(recording: &Recording, channel: &Channel) -> Result<Vec<f64>, Error> {
    const MAX_DETECTION_SAMPLES: usize = 4_000_000;
    let mut beginning = vec![0.0; recording.samples.min(MAX_DETECTION_SAMPLES)];
    channel.samples.read(0, &mut beginning)?;
    Ok(beginning)
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
    let (responses, how, diagnostics) =
        stepped_sine::estimate_responses(recording, channels, &study.dwells_s)?;
    Ok(EstimatedResponses {
        responses,
        method_text: how,
        hits: Vec::new(),
        by_hit: Vec::new(),
        has_unresolved_pulses: false,
        spectra: None,
        finest_resolution_hz: None,
        smearing_limit_lines: 0.0,
        smearing_hz: 0.0,
        diagnostics,
    })
}
