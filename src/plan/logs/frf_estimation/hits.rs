//! FRFs of an impact test with hammer hits, or of a test with force steps.

use super::super::{excited_band, fault_free::CheckedRecording, sample_blocks};
use super::blocks::independent_lines_per_line;
use super::{EstimatedResponses, FrfStudy, HitSummary, channel_labels};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::text::pluralise;
use crate::recording::frequency_responses::FrequencyResponses;
use crate::recording::signals::Channel;
use crate::spectrum::force_aliasing::PulseSampling;
use crate::spectrum::force_pulses;
use crate::spectrum::frf::Estimator;
use crate::spectrum::impact::{self, Hit, ImpactOptions, RejectReason};
use crate::spectrum::window::Window;

/// FRFs from hits, or from `steps`: differencing every channel turns a step into a pulse and leaves the FRFs unchanged.
pub(super) fn estimate_from_hits(
    checked: &CheckedRecording,
    channel_indices: &[usize],
    study: &FrfStudy,
    steps: bool,
) -> Result<EstimatedResponses, Error> {
    let recording = &checked.recording;
    let channels: &[&Channel] = &(channel_indices.iter())
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
        let message = "an impact test uses H1: the force window suppresses noise on the hammer";
        return Err(Error::new(Code::Usage, message)
            .with_hint("omit --estimator, or give --no-impact to average blocks"));
    }
    let mut channel_samples = sample_blocks::load_channels(recording, channels, "an impact test")?;
    if steps {
        for samples in &mut channel_samples {
            let segments = recording.segments.iter();
            let changes =
                segments.map(|s| (s.start, force_pulses::differences(&samples[s.clone()])));
            for (start, changes) in changes.collect::<Vec<_>>() {
                samples[start..start + changes.len()].copy_from_slice(&changes);
            }
        }
    }
    let responses: Vec<&[f64]> = channel_samples[1..].iter().map(Vec::as_slice).collect();
    let options = ImpactOptions {
        block: study
            .frequency_resolution_hz
            .map(|df| (recording.rate_hz / df).round() as usize),
        overload: match steps {
            // Overload levels do not apply to differences of samples.
            true => Vec::new(),
            false => channels.iter().map(|c| c.overload_level).collect(),
        },
        clipped: match steps {
            true => Vec::new(),
            false => (channel_indices.iter())
                .map(|&c| checked.clipped_ranges_of(c))
                .collect(),
        },
        both_signs: steps,
        force_share,
        end,
        ..ImpactOptions::default()
    };
    let impact = impact::estimate_from_hits(
        recording.rate_hz,
        &channel_samples[0],
        &responses,
        &recording.segments,
        &options,
    )?;
    let used = impact.hits.iter().filter(|h| h.rejected.is_none()).count();
    let event = if steps { "step" } else { "hit" };
    let mut method_text = format!("{}: {used} used", pluralise(impact.hits.len(), event));
    for reason in [
        RejectReason::Clipped(0),
        RejectReason::Double,
        RejectReason::CutShort,
        RejectReason::LateStart,
    ] {
        let labels = impact.hits.iter().filter_map(|h| h.rejected);
        let count = labels.filter(|f| f.label() == reason.label()).count();
        if count > 0 {
            method_text += &format!(", {count} {}", reason.label());
        }
    }
    method_text += &format!(
        "; H1{}, blocks of {:.4} s, {:.4} Hz lines",
        if steps { " of the differences" } else { "" },
        impact.block as f64 / recording.rate_hz,
        recording.rate_hz / impact.block as f64
    );
    if let Some(window) = study.window {
        method_text += &format!(", {} window as requested", window.name());
    }
    let summarise = |hit: &Hit| HitSummary {
        moment: recording.sample_time(hit.sample),
        peak: hit.peak,
        fault: hit.rejected,
        fault_text: (hit.rejected).map(|f| f.description(|at| channels[at].name.clone())),
    };
    let usable_hz = excited_band::of_hits(&impact.force_power, &impact.estimate);
    // The exponential window correlates neighbouring lines according to its value at the end of the block.
    let end = (-impact.estimate.window_decay * impact.block as f64 / recording.rate_hz).exp();
    Ok(EstimatedResponses {
        responses: FrequencyResponses {
            usable_band_hz: usable_hz,
            independent_lines_per_line: (end < 1.0)
                .then(|| independent_lines_per_line(Window::Exponential(end))),
            ..impact
                .estimate
                .to_frequency_responses(&channel_labels(channels))
        },
        method_text,
        hits: impact.hits.iter().map(summarise).collect(),
        hit_responses: impact.hit_responses,
        has_unresolved_pulses: impact.sampling == PulseSampling::Unresolved,
        spectra: None,
        finest_resolution_hz: None,
        smearing_limit_lines: 0.0,
        smearing_hz: 0.0,
        diagnostics: impact.estimate.diagnostics,
    })
}
