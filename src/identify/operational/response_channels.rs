//! Response channels sampled together, validated.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::identify::validation::{check_rate, check_samples};

/// Responses sampled together.
#[derive(Debug, Clone, Copy)]
pub struct ResponseChannels<'a> {
    samples: &'a [&'a [f64]],
    rate_hz: f64,
}

impl<'a> ResponseChannels<'a> {
    /// Responses of equal length.
    ///
    /// # Errors
    /// `NoChannel` for none; `OutOfRange` for a rate that is not positive, or lengths that differ; `EmptyLog`, `NotANumber`, `NoSignal`
    /// for a channel that is empty, not finite or constant.
    pub fn new(samples: &'a [&'a [f64]], rate_hz: f64) -> Result<ResponseChannels<'a>, Error> {
        check_rate(rate_hz)?;
        let Some(first) = samples.first() else {
            return Err(Error::new(Code::NoChannel, "no response to analyse")
                .with_hint("name at least one channel"));
        };
        for (c, channel) in samples.iter().enumerate() {
            check_samples(channel, &format!("response {c}"))?;
            if channel.len() != first.len() {
                return Err(Error::new(
                    Code::OutOfRange,
                    format!(
                        "response {c} has {} samples and response 0 has {}",
                        channel.len(),
                        first.len()
                    ),
                )
                .with_hint("cut all channels from the same segment of the record"));
            }
        }
        Ok(ResponseChannels { samples, rate_hz })
    }

    /// Samples by channel.
    pub fn samples(&self) -> &'a [&'a [f64]] {
        self.samples
    }

    /// Sample rate, Hz.
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Samples of each channel.
    pub fn n_samples(&self) -> usize {
        self.samples.first().map_or(0, |s| s.len())
    }
}

/// Refuses references that are no channel, or none at all.
pub(super) fn check_references(references: &[usize], channels: usize) -> Result<(), Error> {
    match references.iter().find(|&&r| r >= channels) {
        None if !references.is_empty() => Ok(()),
        wrong => Err(Error::new(
            Code::NoChannel,
            match wrong {
                Some(r) => format!("reference {r} exceeds the {channels} channels, counted from 0"),
                None => String::from("no reference channel"),
            },
        )
        .with_hint("name references among the channels, or omit them to use all")),
    }
}
