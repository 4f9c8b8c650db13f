//! Export of recordings and frequency responses: CSV, UFF 58 (text, binary), JSON.
//!
//! Signals are read from their columns in blocks and written as they come, so that no channel is ever held whole. Numbers
//! are written so that reading them again gives the same bits, but for UFF 58 in text, which has 13 digits.

pub mod csv;

pub mod json;

mod uff_geometry;

pub mod uff;

use std::io;

use super::signals::Channel;
use crate::base::code::Code;
use crate::base::error::Error;

/// Samples of a channel in memory at a time.
const BUFFER_LEN: usize = 1 << 13;

/// The writer failed.
fn output_error(error: io::Error) -> Error {
    Error::new(
        Code::OutputFailed,
        format!("the output cannot be written: {error}"),
    )
}

/// Hands the samples of a channel on in blocks.
fn for_each_block(
    channel: &Channel,
    samples: usize,
    mut take: impl FnMut(&[f64]) -> io::Result<()>,
) -> Result<(), Error> {
    let mut block = vec![0.0; BUFFER_LEN.min(samples)];
    let mut start = 0;
    while start < samples {
        let length = BUFFER_LEN.min(samples - start);
        channel.samples.read(start, &mut block[..length])?;
        take(&block[..length]).map_err(output_error)?;
        start += length;
    }
    Ok(())
}
