//! FRF estimation from a recording: hammer hits, stepped sine, local polynomials or averaged blocks.

use super::fault_free::{CheckedRecording, SegmentUse};
use super::{excited_band, sample_blocks, stepped_sine};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::numeric::fft::prev_fast_len;
use crate::recording::frequency_responses::{ChannelLabel, FrequencyResponses};
use crate::recording::signals::{Channel, Moment, Recording};
use crate::spectrum::force_aliasing::PulseSampling;
use crate::spectrum::force_pulses;
use crate::spectrum::frf::{self, Estimator, FrfEstimate};
use crate::spectrum::impact::{self, Hit, HitResponses, ImpactOptions, RejectReason};
use crate::spectrum::local_polynomial::{
    LocalPolynomialEstimator, MAX_POLE_BLOCKS, min_half_width,
};
use crate::spectrum::spectra::Spectra;
use crate::spectrum::welch::{WelchEstimator, WelchOptions};
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

/// Default minimum number of blocks: enough for a variance.
const MIN_DEFAULT_BLOCKS: usize = 16;

/// The longest block taken unasked: 65 536 samples.
const MAX_DEFAULT_BLOCK: usize = 1 << 16;

/// The shortest block taken unasked.
const MIN_DEFAULT_BLOCK: usize = 256;

/// Samples that have a spectrum, at least.
const MIN_SAMPLES: usize = 4;

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

/// Responses to hits, or to `steps`: with every channel replaced by its differences a step is a hit, and the responses stay what they are.
fn estimate_from_hits(
    sound: &CheckedRecording,
    chosen: &[usize],
    study: &FrfStudy,
    steps: bool,
) -> Result<EstimatedResponses, Error> {
    let recording = &sound.recording;
    let channels: &[&Channel] = &(chosen.iter())
        .map(|&c| &recording.channels[c])
        .collect::<Vec<_>>();
    let (force_share, end) = match study.window {
        None => (None, None),
        Some(Window::Force(share)) => (Some(share), None),
        Some(Window::Exponential(end)) => (None, Some(end)),
        Some(Window::Rectangular) => (Some(1.0), Some(1.0)),
        Some(window) => {
            let message = format!(
                "an impact test takes no {} window: it would weigh the hit against its decay",
                window.name()
            );
            return Err(Error::new(Code::Usage, message).with_hint(
                "omit --window: force and exponential windows are chosen from the data; or give force:SHARE, exponential:END, rectangular, or --no-impact",
            ));
        }
    };
    if study.estimator != Estimator::H1 {
        let message = "an impact test is estimated by H1: its few hits are windowed until noise on the hammer is small";
        return Err(Error::new(Code::Usage, message)
            .with_hint("omit --estimator, or give --no-impact to average blocks"));
    }
    let mut all = sample_blocks::load_channels(recording, channels, "an impact test")?;
    if steps {
        for samples in &mut all {
            let segments = recording.segments.iter();
            let changes =
                segments.map(|s| (s.start, force_pulses::differences(&samples[s.clone()])));
            for (start, changes) in changes.collect::<Vec<_>>() {
                samples[start..start + changes.len()].copy_from_slice(&changes);
            }
        }
    }
    let responses: Vec<&[f64]> = all[1..].iter().map(Vec::as_slice).collect();
    let options = ImpactOptions {
        block: study
            .frequency_resolution_hz
            .map(|df| (recording.rate_hz / df).round() as usize),
        overload: match steps {
            // Levels of samples say nothing of their differences.
            true => Vec::new(),
            false => channels.iter().map(|c| c.overload_level).collect(),
        },
        clipped: match steps {
            true => Vec::new(),
            false => (chosen.iter())
                .map(|&c| sound.clipped_ranges_of(c))
                .collect(),
        },
        both_sides: steps,
        force_share,
        end,
        ..ImpactOptions::default()
    };
    let found = impact::estimate_from_hits(
        recording.rate_hz,
        &all[0],
        &responses,
        &recording.segments,
        &options,
    )?;
    let used = found.hits.iter().filter(|h| h.rejected.is_none()).count();
    let what = if steps { "step" } else { "hit" };
    let mut how = format!("{}: {used} used", pluralise(found.hits.len(), what));
    for fault in [
        RejectReason::Clipped(0),
        RejectReason::Double,
        RejectReason::CutShort,
        RejectReason::LateStart,
    ] {
        let labels = found.hits.iter().filter_map(|h| h.rejected);
        let count = labels.filter(|f| f.label() == fault.label()).count();
        if count > 0 {
            how += &format!(", {count} {}", fault.label());
        }
    }
    how += &format!(
        "; H1{}, blocks of {:.4} s, {:.4} Hz lines",
        if steps { " of the differences" } else { "" },
        found.block as f64 / recording.rate_hz,
        recording.rate_hz / found.block as f64
    );
    if let Some(window) = study.window {
        how += &format!(", {} window as requested", window.name());
    }
    let hit = |hit: &Hit| HitSummary {
        moment: recording.moment(hit.sample),
        peak: hit.peak,
        fault: hit.rejected,
        fault_text: (hit.rejected).map(|f| f.description(|at| channels[at].name.clone())),
    };
    let usable_hz = excited_band::of_hits(&found.force_power, &found.estimate);
    // What the exponential window falls to makes neighbouring lines go together.
    let end = (-found.estimate.window_decay * found.block as f64 / recording.rate_hz).exp();
    Ok(EstimatedResponses {
        responses: FrequencyResponses {
            usable_band_hz: usable_hz,
            independent_lines_per_line: (end < 1.0)
                .then(|| independent_lines_per_line(Window::Exponential(end))),
            ..found
                .estimate
                .to_frequency_responses(&channel_labels(channels))
        },
        method_text: how,
        hits: found.hits.iter().map(hit).collect(),
        by_hit: found.by_hit,
        has_unresolved_pulses: found.sampling == PulseSampling::Unresolved,
        spectra: None,
        finest_resolution_hz: None,
        smearing_limit_lines: 0.0,
        diagnostics: found.estimate.diagnostics,
    })
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
        diagnostics,
    })
}

/// Lines of a first look inside the band, at most: enough for a hundred modes of twenty lines each.
const MAX_FIRST_LINES: f64 = 2048.0;

/// Samples over all channels that are transformed at once.
const MAX_FFT_SAMPLES: usize = 1 << 23;

/// Degrees of freedom of the variance of a line, at least: of a first look, and where modes are narrow.
const MIN_VARIANCE_DOF: (usize, usize) = (8, 5);

/// The longest block of a transform without a window.
const MAX_UNWINDOWED_BLOCK: usize = 1 << 20;

/// Inputs whose power lies on a smaller share of neighbouring lines repeat: four times or more inside a block.
const MAX_PERIODIC_FLATNESS: f64 = 0.27;

/// Blocks without a window that leave out more than this share of a record with gaps are none.
const MAX_UNUSED_SHARE: f64 = 0.5;

/// A resonance narrower than so many lines is smeared by the window of averaged blocks.
const WINDOW_SMEARING_LINES: f64 = 3.0;

/// The same of parabolas over several blocks. Of 1/(1 + jx) over windows that reach to x = ±a, a parabola misses (3/35) a⁴ in the middle;
/// with so many windows in the half-power width, a = 2/3, that is 2 %.
const POLYNOMIAL_SMEARING_LINES: f64 = 1.5;

fn estimate_from_blocks(
    recording: &Recording,
    channels: &[&Channel],
    inputs: usize,
    study: &FrfStudy,
    request: ResolutionRequest,
) -> Result<EstimatedResponses, Error> {
    let options = welch_options(recording, study)?;
    let places: Vec<usize> = (0..channels.len()).collect();
    let (ins, outs) = places.split_at(inputs);
    let mut estimator = WelchEstimator::new(
        recording.rate_hz,
        channels.len(),
        &frf::required_pairs(ins, outs),
        &options,
    )?;
    sample_blocks::for_each_block(recording, channels, |block, ends| {
        estimator.push(block);
        if ends {
            estimator.end_segment();
        }
    })?;
    let spectra = estimator.finish()?;
    // The window's main lobe spreads the mean over the first lines; filters bend the last ones.
    const BAND_EDGE_SHARE: f64 = 0.95;
    let (lines, top) = (
        &spectra.frequency_hz,
        BAND_EDGE_SHARE * recording.rate_hz / 2.0,
    );
    let whole = lines.get(3).map(|&low| (low, top)).filter(|b| b.0 < b.1);
    let driven = excited_band::of_inputs(&spectra, ins).map(|(low, high)| match whole {
        Some((least, most)) => (low.max(least).min(most), high.min(most)),
        None => (low, high),
    });
    let usable_hz = driven.or(whole);
    let mut how_driven = String::new();
    if let (None, Some((low, high))) = (request.band_hz, driven.filter(|_| driven != whole)) {
        how_driven = format!(
            "; the input has power, within {:.0} dB of its plateau, from {low:.4} to {high:.4} Hz",
            -10.0 * excited_band::PLATEAU_POWER_SHARE.log10()
        );
    }
    let band = request.band_hz.or(usable_hz).filter(|_| study.is_default());
    let average = || frf::estimate(&spectra, ins, outs, study.estimator);
    // Few neighbouring lines tell no more than that coherent inputs are not distinguished; an average says on which lines they
    // are.
    let known = if inputs > 1 { Some(average()?) } else { None };
    let are_apart = |band: &(f64, f64)| {
        let inside = |&k: &usize| (band.0..=band.1).contains(&spectra.frequency_hz[k]);
        known
            .as_ref()
            .is_none_or(|known| !known.undetermined_lines.iter().any(inside))
    };
    let local = match band.filter(are_apart) {
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
        method_text: how,
        finest_resolution_hz: nearest_hz,
        smearing_limit_lines: smeared_lines,
    }) = local
    {
        return Ok(EstimatedResponses {
            responses: FrequencyResponses {
                usable_band_hz: usable_hz,
                independent_lines_per_line: Some(1.0),
                ..estimate.to_frequency_responses(&channel_labels(channels))
            },
            method_text: how + &how_driven,
            hits: Vec::new(),
            by_hit: Vec::new(),
            has_unresolved_pulses: false,
            finest_resolution_hz: Some(nearest_hz),
            smearing_limit_lines: smeared_lines,
            diagnostics: estimate.diagnostics,
            spectra: Some(spectra),
        });
    }
    let estimate = known.map_or_else(average, Ok)?;
    let name = match study.estimator {
        Estimator::H1 => "H1",
        Estimator::H2 => "H2",
        Estimator::Hv => "Hv",
    };
    let how = format!(
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
        method_text: how,
        hits: Vec::new(),
        by_hit: Vec::new(),
        has_unresolved_pulses: false,
        finest_resolution_hz: None,
        smearing_limit_lines: WINDOW_SMEARING_LINES,
        diagnostics: estimate.diagnostics,
        spectra: Some(spectra),
    })
}

/// Responses by local polynomials, and how they were had.
struct LocalEstimate {
    estimate: FrfEstimate,
    method_text: String,
    finest_resolution_hz: f64,
    smearing_limit_lines: f64,
}

/// A length of block for a record of segments without gaps, and how many of them it has: that of the best product of the
/// length, which tells neighbouring lines apart, and the samples used. Lengths are those of segments and of their equal parts,
/// quick to transform.
fn common_block_len(segments: &[usize], most: usize) -> Option<(usize, usize)> {
    let mut lengths: Vec<usize> = segments
        .iter()
        .flat_map(|&s| {
            (s.div_ceil(most.max(1)).max(1)..=s / MIN_DEFAULT_BLOCK).map(move |parts| s / parts)
        })
        .map(prev_fast_len)
        .filter(|&length| length >= MIN_DEFAULT_BLOCK)
        .collect();
    lengths.sort_unstable_by(|a, b| b.cmp(a));
    lengths.dedup();
    let whole = segments.iter().sum::<usize>() as f64;
    let mut best: Option<(f64, usize, usize)> = None;
    for length in lengths {
        if best.is_some_and(|b| length as f64 * whole <= b.0) {
            break;
        }
        let count: usize = segments.iter().map(|s| s / length).sum();
        let used = (count * length) as f64;
        let worth = length as f64 * used;
        if used >= (1.0 - MAX_UNUSED_SHARE) * whole && best.is_none_or(|b| worth > b.0) {
            best = Some((worth, length, count));
        }
    }
    best.map(|(_, length, count)| (length, count))
}

/// Responses by local polynomials over blocks as long as the record has them; nothing where an input repeats or gaps leave too little.
fn estimate_local(
    recording: &Recording,
    channels: &[&Channel],
    inputs: usize,
    band: (f64, f64),
    apart_hz: Option<f64>,
) -> Result<Option<LocalEstimate>, Error> {
    let segments: Vec<usize> = recording.segments.iter().map(|s| s.len()).collect();
    let most = MAX_UNWINDOWED_BLOCK.min(MAX_FFT_SAMPLES / channels.len().max(1));
    let Some((block, count)) = common_block_len(&segments, most) else {
        return Ok(None);
    };
    let df = recording.rate_hz / block as f64;
    let first = min_half_width(inputs, count, MIN_VARIANCE_DOF.0);
    let last = min_half_width(inputs, count, MIN_VARIANCE_DOF.1);
    let least = if apart_hz.is_some() { last } else { first };
    let width = |half: usize| (2 * half + 1) as f64 * df;
    let wanted = apart_hz.unwrap_or((band.1 - band.0) / MAX_FIRST_LINES);
    let half = (((wanted / df - 1.0) / 2.0).floor().max(0.0) as usize).max(least);
    let top = recording.rate_hz / 2.0;
    let Ok(mut local) = LocalPolynomialEstimator::new(
        recording.rate_hz,
        inputs,
        channels.len() - inputs,
        block,
        half,
        (0.0, top),
    ) else {
        return Ok(None);
    };
    let mut pending = vec![Vec::with_capacity(block); channels.len()];
    sample_blocks::for_each_block(recording, channels, |samples, ends| {
        let mut from = 0;
        let count = samples.first().map_or(0, |s| s.len());
        while from < count {
            let take = (block - pending[0].len()).min(count - from);
            for (pending, samples) in pending.iter_mut().zip(samples) {
                pending.extend_from_slice(&samples[from..from + take]);
            }
            from += take;
            if pending[0].len() == block {
                let views: Vec<&[f64]> = pending.iter().map(Vec::as_slice).collect();
                local.push(&views);
                pending.iter_mut().for_each(Vec::clear);
            }
        }
        if ends {
            pending.iter_mut().for_each(Vec::clear);
        }
    })?;
    if local.input_flatness(band) < MAX_PERIODIC_FLATNESS {
        return Ok(None);
    }
    let Ok(estimate) = local.finish() else {
        return Ok(None);
    };
    let left_out = segments.iter().sum::<usize>() - count * block;
    let how = format!(
        "local parabolas through {} neighbouring lines of {}, no window and no leakage: lines {:.4} Hz apart{}",
        2 * half + 1,
        match count {
            1 => format!("one block of {:.4} s", block as f64 / recording.rate_hz),
            n => format!("{n} blocks of {:.4} s", block as f64 / recording.rate_hz),
        },
        width(half),
        match segments.len() {
            0 | 1 => String::new(),
            n => format!(
                "; {:.4} s of {:.4} s not used, at the ends of the {n} segments between gaps",
                left_out as f64 / recording.rate_hz,
                recording.samples as f64 / recording.rate_hz
            ),
        }
    );
    Ok(Some(LocalEstimate {
        estimate,
        method_text: how,
        finest_resolution_hz: width(last),
        smearing_limit_lines: match count {
            // Parabolas stand over poles.
            1..=MAX_POLE_BLOCKS => 0.0,
            _ => POLYNOMIAL_SMEARING_LINES,
        },
    }))
}

/// Blocks, window and overlap: as requested, else from the length of the record.
///
/// # Errors
/// A resolution that no stretch can give, an overlap without sense.
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
                    "lines of {df} Hz need blocks of {block:.0} samples; the longest segment has {longest}"
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
            let blocks = |block: usize| -> usize {
                recording.segments.iter().map(|s| s.len() / block).sum()
            };
            let mut block = MAX_DEFAULT_BLOCK;
            while block > MIN_DEFAULT_BLOCK && blocks(block) < MIN_DEFAULT_BLOCKS {
                block /= 2;
            }
            if longest < MIN_SAMPLES {
                let message = format!(
                    "the longest segment of {} has {}: no block of them has a spectrum",
                    recording.path,
                    pluralise(longest, "sample")
                );
                return Err(Error::new(Code::TooShort, message)
                    .with_hint("take a longer record, or bridge short gaps: --fill-gaps"));
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

/// Independent lines' worth of noise in a line under a window: 1/Σ|ρ_m|² over the correlations of neighbours.
fn independent_lines_per_line(window: Window) -> f64 {
    const SAMPLES: usize = 256;
    const REACH: usize = 12;
    let w = window.samples(SAMPLES);
    let own = crate::spectrum::window::line_correlation(&w, 0).norm();
    let sum: f64 = (1..=REACH)
        .map(|m| (crate::spectrum::window::line_correlation(&w, m).norm() / own).powi(2))
        .sum();
    1.0 / (1.0 + 2.0 * sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One sample missing: blocks of the shorter segment where it is nearly a half, the longer segment alone where it is far longer.
    #[test]
    fn exact_common_block() {
        let most = MAX_UNWINDOWED_BLOCK;
        assert_eq!(common_block_len(&[60_000], most), Some((60_000, 1)));
        assert_eq!(common_block_len(&[30_000, 30_000], most), Some((30_000, 2)));
        assert_eq!(common_block_len(&[32_000, 27_000], most), Some((27_000, 2)));
        assert_eq!(common_block_len(&[54_000, 5_999], most), Some((54_000, 1)));
        // Three blocks of the shorter one, 20 000 × 60 000, are worth less than 40 000 × 40 000.
        assert_eq!(common_block_len(&[40_000, 20_000], most), Some((40_000, 1)));
        // Transforms no longer than allowed; segments too short for any block.
        assert_eq!(common_block_len(&[60_000], 20_000), Some((20_000, 3)));
        assert_eq!(common_block_len(&[255; 100], most), None);
        assert_eq!(common_block_len(&[], most), None);
    }
}
