//! Responses to the hits of a hammer, or to steps.

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

/// Responses to hits, or to `steps`: with every channel replaced by its differences a step is a hit, and the responses stay what they are.
pub(super) fn estimate_from_hits(
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
        smearing_hz: 0.0,
        diagnostics: found.estimate.diagnostics,
    })
}
