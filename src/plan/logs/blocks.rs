//! Blocks of samples from a recording: whole where an analysis needs them whole, one after the other where it does not.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::recording::signals::{Channel, Recording};

/// Samples of each channel handed on at a time.
const BLOCK: usize = 1 << 16;

/// Samples over all channels that an analysis may hold at once: 320 MB.
const MOST: usize = 40_000_000;

/// Hands every channel's samples on, block by block; `see(blocks, ends)` also hears where a stretch ends.
///
/// # Errors
/// The samples cannot be read.
pub fn each(
    recording: &Recording,
    channels: &[&Channel],
    mut see: impl FnMut(&[&[f64]], bool),
) -> Result<(), Error> {
    let mut blocks = vec![vec![0.0; BLOCK.min(recording.samples)]; channels.len()];
    for stretch in &recording.stretches {
        let mut at = stretch.start;
        while at < stretch.end {
            let count = BLOCK.min(stretch.end - at);
            for (block, channel) in blocks.iter_mut().zip(channels) {
                channel.samples.read(at, &mut block[..count])?;
            }
            let views: Vec<&[f64]> = blocks.iter().map(|b| &b[..count]).collect();
            at += count;
            see(&views, at == stretch.end);
        }
    }
    Ok(())
}

/// Whole channels in memory.
///
/// # Errors
/// More samples than can be held at once.
pub fn whole(
    recording: &Recording,
    channels: &[&Channel],
    what: &str,
) -> Result<Vec<Vec<f64>>, Error> {
    let samples = recording.samples.saturating_mul(channels.len());
    if samples > MOST {
        let message = format!(
            "{what} needs all {samples} samples at once, {} MB",
            samples >> 17
        );
        let hint = format!(
            "take a part of the log: --after, --before, up to {:.0} s",
            MOST as f64 / channels.len() as f64 / recording.rate_hz
        );
        return Err(Error::new(Code::Hopeless, message).hint(hint));
    }
    channels
        .iter()
        .map(|channel| {
            let mut all = vec![0.0; recording.samples];
            channel.samples.read(0, &mut all).map(|()| all)
        })
        .collect()
}
