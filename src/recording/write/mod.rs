//! Signals and frequency responses to files: CSV, UFF 58 in text and in bytes, JSON.
//!
//! Signals are read from their columns in blocks and written as they come, so that no channel is ever held whole. Numbers
//! are written so that reading them again gives the same bits, but for UFF 58 in text, which has 13 digits.

/// Comma-separated values.
pub mod csv;

/// JSON.
pub mod json;

/// UFF 58.
pub mod uff;

use std::io;

use super::signals::Channel;
use crate::base::code::Code;
use crate::base::error::Error;

/// Samples of a channel in memory at a time.
const BLOCK: usize = 1 << 13;

/// The writer failed.
fn failed(error: io::Error) -> Error {
    Error::new(
        Code::OutputFailed,
        format!("the output cannot be written: {error}"),
    )
}

/// Hands the samples of a channel on in blocks.
fn blocks(
    channel: &Channel,
    samples: usize,
    mut take: impl FnMut(&[f64]) -> io::Result<()>,
) -> Result<(), Error> {
    let mut block = vec![0.0; BLOCK.min(samples)];
    let mut start = 0;
    while start < samples {
        let length = BLOCK.min(samples - start);
        channel.samples.read(start, &mut block[..length])?;
        take(&block[..length]).map_err(failed)?;
        start += length;
    }
    Ok(())
}
