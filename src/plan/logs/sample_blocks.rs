//! Block-wise and whole access to the samples of a recording.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::welch::WelchEstimator;

/// Samples of each channel handed on at a time.
const BLOCK: usize = 1 << 16;

/// Samples over all channels that an analysis may hold at once: 320 MB.
const MAX_SAMPLES_IN_MEMORY: usize = 40_000_000;

/// Hands every channel's samples on, block by block; `see(blocks, ends)` also hears where a segment ends.
///
/// # Errors
/// The samples cannot be read.
pub fn for_each_block(
    recording: &Recording,
    channels: &[&Channel],
    mut see: impl FnMut(&[&[f64]], bool),
) -> Result<(), Error> {
    let mut blocks = vec![vec![0.0; BLOCK.min(recording.samples)]; channels.len()];
    for segment in &recording.segments {
        let mut at = segment.start;
        while at < segment.end {
            let count = BLOCK.min(segment.end - at);
            for (block, channel) in blocks.iter_mut().zip(channels) {
                channel.samples.read(at, &mut block[..count])?;
            }
            let views: Vec<&[f64]> = blocks.iter().map(|b| &b[..count]).collect();
            at += count;
            see(&views, at == segment.end);
        }
    }
    Ok(())
}

/// Averages the blocks of channels; none crosses the end of a segment.
///
/// # Errors
/// The samples cannot be read.
pub fn average(
    recording: &Recording,
    channels: &[&Channel],
    estimator: &mut WelchEstimator,
) -> Result<(), Error> {
    for_each_block(recording, channels, |block, ends| {
        estimator.push(block);
        if ends {
            estimator.end_segment();
        }
    })
}

/// Whole channels in memory.
///
/// # Errors
/// More samples than can be held at once.
pub fn load_channels(
    recording: &Recording,
    channels: &[&Channel],
    what: &str,
) -> Result<Vec<Vec<f64>>, Error> {
    let samples = recording.samples.saturating_mul(channels.len());
    if samples > MAX_SAMPLES_IN_MEMORY {
        let message = format!(
            "{what} needs all {samples} samples in memory, {} MB",
            samples >> 17
        );
        let hint = format!(
            "take a part of the log: --after, --before, up to {:.0} s",
            MAX_SAMPLES_IN_MEMORY as f64 / channels.len() as f64 / recording.rate_hz
        );
        return Err(Error::new(Code::BudgetExceeded, message).with_hint(hint));
    }
    channels
        .iter()
        .map(|channel| {
            let mut all = vec![0.0; recording.samples];
            channel.samples.read(0, &mut all).map(|()| all)
        })
        .collect()
}
