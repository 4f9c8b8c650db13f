//! Frequency responses from a recording: hits where the input is a hammer, averaged blocks where it is not.

use super::blocks;
use crate::base::code::Code;
use crate::base::error::{Error, Warning};
use crate::recording::responses::{FrequencyResponses, Terminal};
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::frf::{self, Estimator};
use crate::spectrum::hits;
use crate::spectrum::impact::{self, Hit, ImpactOptions};
use crate::spectrum::spectra::Spectra;
use crate::spectrum::welch::{Welch, WelchOptions};
use crate::spectrum::window::Window;

/// How frequency responses are estimated; what is `None` is chosen from the data.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EstimateStudy {
    /// Where the noise is taken to be.
    pub estimator: Estimator,
    /// On each block.
    pub window: Option<Window>,
    /// Between lines, Hz.
    pub resolution_hz: Option<f64>,
    /// Share of a block that the next has in common with it.
    pub overlap: Option<f64>,
    /// The input is a hammer.
    pub impact: Option<bool>,
}

/// Frequency responses and how they were had.
#[derive(Debug)]
pub struct Acquired {
    /// The responses.
    pub responses: FrequencyResponses,
    /// In words: `5 hits: 3 used, 1 clipped; H1, 3 averages, 0.25 Hz lines`.
    pub how: String,
    /// Hits, where the input is a hammer.
    pub hits: Vec<Hit>,
    /// Power spectral density of the first input by line, and of every channel, where blocks were averaged.
    pub spectra: Option<Spectra>,
    /// Doubts.
    pub warnings: Vec<Warning>,
}

/// Blocks that a record is cut into at least, where nobody says how: enough for a variance.
const LEAST_BLOCKS: usize = 16;

/// The longest block taken unasked: 65 536 samples.
const LONGEST: usize = 1 << 16;

/// The shortest block taken unasked.
const SHORTEST: usize = 256;

/// Estimates the responses of `outputs` to `inputs`, channels of the recording by place.
///
/// # Errors
/// Channels without signal or alike, a record too short.
pub fn acquire(
    recording: &Recording,
    inputs: &[usize],
    outputs: &[usize],
    study: &EstimateStudy,
) -> Result<Acquired, Error> {
    let chosen: Vec<usize> = inputs.iter().chain(outputs).copied().collect();
    let channels: Vec<&Channel> = chosen.iter().map(|&c| &recording.channels[c]).collect();
    let is_hammer = match (study.impact, inputs.len()) {
        (Some(said), _) => said,
        (None, 1) => looks_struck(recording, channels[0])?,
        _ => false,
    };
    match is_hammer {
        true if inputs.len() > 1 => {
            let message = "an impact test has one input, the force of the hammer";
            Err(Error::new(Code::Usage, message))
        }
        true => struck(recording, &channels, study),
        false => averaged(recording, &channels, inputs.len(), study),
    }
}

fn terminals(channels: &[&Channel]) -> Vec<Terminal> {
    let terminal = |c: &&Channel| Terminal {
        name: c.name.clone(),
        unit: c.unit.clone(),
    };
    channels.iter().map(terminal).collect()
}

/// Whether the channel is a few short pulses, by its beginning.
fn looks_struck(recording: &Recording, channel: &Channel) -> Result<bool, Error> {
    const LOOKED_AT: usize = 4_000_000;
    let mut beginning = vec![0.0; recording.samples.min(LOOKED_AT)];
    channel.samples.read(0, &mut beginning)?;
    Ok(hits::is_impact(&beginning))
}

fn struck(
    recording: &Recording,
    channels: &[&Channel],
    study: &EstimateStudy,
) -> Result<Acquired, Error> {
    if let Some(window) = study.window {
        let message = format!(
            "an impact test takes no {} window: force and exponential windows are chosen from the data",
            window.name()
        );
        return Err(Error::new(Code::Usage, message).hint("leave --window out, or say --no-impact"));
    }
    let all = blocks::whole(recording, channels, "an impact test")?;
    let responses: Vec<&[f64]> = all[1..].iter().map(Vec::as_slice).collect();
    let options = ImpactOptions {
        block: study
            .resolution_hz
            .map(|df| (recording.rate_hz / df).round() as usize),
        overload: channels.iter().map(|c| c.overload_level).collect(),
        ..ImpactOptions::default()
    };
    let found = impact::analyse(
        recording.rate_hz,
        &all[0],
        &responses,
        &recording.stretches,
        &options,
    )?;
    let used = found.hits.iter().filter(|h| h.fault.is_none()).count();
    let mut how = format!(
        "{} {}: {used} used",
        found.hits.len(),
        if found.hits.len() == 1 { "hit" } else { "hits" }
    );
    for fault in [
        impact::Fault::Overload,
        impact::Fault::Double,
        impact::Fault::CutShort,
        impact::Fault::LateStart,
    ] {
        let count = found.hits.iter().filter(|h| h.fault == Some(fault)).count();
        if count > 0 {
            how += &format!(", {count} {}", fault.word());
        }
    }
    how += &format!(
        "; H1, blocks of {:.4} s, {:.4} Hz lines",
        found.block as f64 / recording.rate_hz,
        recording.rate_hz / found.block as f64
    );
    let usable_hz = driven_band(&found.force_power, &found.estimate.frequency_hz);
    Ok(Acquired {
        responses: FrequencyResponses {
            usable_hz,
            ..found.estimate.responses(&terminals(channels))
        },
        how,
        hits: found.hits,
        spectra: None,
        warnings: found.estimate.warnings,
    })
}

/// Where a hammer's force has power: up to where it falls 40 dB below its largest for good.
fn driven_band(power: &[f64], frequency_hz: &[f64]) -> Option<(f64, f64)> {
    const FALL: f64 = 1e-4;
    let largest = power.iter().copied().fold(0.0, f64::max);
    let last = power
        .iter()
        .position(|&p| p < FALL * largest)
        .unwrap_or(power.len());
    Some((
        *frequency_hz.get(1)?,
        *frequency_hz.get(last.checked_sub(1)?)?,
    ))
}

fn averaged(
    recording: &Recording,
    channels: &[&Channel],
    inputs: usize,
    study: &EstimateStudy,
) -> Result<Acquired, Error> {
    let options = welch_options(recording, study)?;
    let places: Vec<usize> = (0..channels.len()).collect();
    let (ins, outs) = places.split_at(inputs);
    let mut welch = Welch::new(
        recording.rate_hz,
        channels.len(),
        &frf::pairs(ins, outs),
        &options,
    )?;
    blocks::each(recording, channels, |block, ends| {
        welch.push(block);
        if ends {
            welch.end_stretch();
        }
    })?;
    let spectra = welch.finish()?;
    let estimate = frf::estimate(&spectra, ins, outs, study.estimator)?;
    let name = match study.estimator {
        Estimator::H1 => "H1",
        Estimator::H2 => "H2",
        Estimator::Hv => "Hv",
    };
    let how = format!(
        "{name}, {} blocks of {:.4} s ({} window, {:.0} % overlap): {:.1} independent averages, {:.4} Hz lines",
        spectra.blocks,
        options.block as f64 / recording.rate_hz,
        options.window.name(),
        100.0 * options.overlap,
        estimate.averages,
        recording.rate_hz / options.block as f64
    );
    // The window's main lobe spreads the mean over the first lines; filters bend the last ones.
    const EDGE: f64 = 0.95;
    let lines = &estimate.frequency_hz;
    Ok(Acquired {
        responses: FrequencyResponses {
            usable_hz: (lines.get(3).zip(lines.last())).map(|(&low, &last)| (low, EDGE * last)),
            line_independence: Some(independence(options.window)),
            ..estimate.responses(&terminals(channels))
        },
        how,
        hits: Vec::new(),
        warnings: estimate.warnings,
        spectra: Some(spectra),
    })
}

/// Blocks, window and overlap: as asked, else from the length of the record.
///
/// # Errors
/// A resolution that no stretch can give, an overlap without sense.
pub fn welch_options(recording: &Recording, study: &EstimateStudy) -> Result<WelchOptions, Error> {
    let longest = recording
        .stretches
        .iter()
        .map(|s| s.len())
        .max()
        .unwrap_or(0);
    let block = match study.resolution_hz {
        Some(df) => {
            let block = (recording.rate_hz / df).round();
            if !(block >= 8.0 && block <= longest as f64) {
                let message = format!(
                    "lines of {df} Hz need blocks of {block:.0} samples; the longest stretch has {longest}"
                );
                let hint = format!(
                    "ask for at least {:.6} Hz",
                    recording.rate_hz / longest.max(1) as f64
                );
                return Err(Error::new(Code::OutOfRange, message).hint(hint));
            }
            block as usize
        }
        None => {
            let blocks = |block: usize| -> usize {
                recording.stretches.iter().map(|s| s.len() / block).sum()
            };
            let mut block = LONGEST;
            while block > SHORTEST && blocks(block) < LEAST_BLOCKS {
                block /= 2;
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

/// How many independent lines' worth of noise a line holds under a window: 1/Σ|ρ_m|² over the correlations of neighbours.
fn independence(window: Window) -> f64 {
    const SAMPLES: usize = 256;
    const REACH: usize = 12;
    let w = window.samples(SAMPLES);
    let own = crate::spectrum::window::line_correlation(&w, 0).norm();
    let sum: f64 = (1..=REACH)
        .map(|m| (crate::spectrum::window::line_correlation(&w, m).norm() / own).powi(2))
        .sum();
    1.0 / (1.0 + 2.0 * sum)
}
