//! FRFs from hammer hits, averaged by H1; clipped, double and truncated hits are rejected.
//!
//! Halvorsen & Brown, Impulse technique for structural frequency response testing, Sound and Vibration 11 (1977), pp. 8–21. The
//! force is set to zero after its pulse. If a response has not decayed at the end of the block, force and response are weighted
//! by `exp(−σt)`: the estimate is the response of the structure with every pole shifted by exactly −σ.

mod decay;

mod blocks;

mod responses;

use std::ops::Range;

use self::blocks::{HitBlock, ImpactRecord};
pub use self::decay::{decay_length, levels};
use self::responses::HitSums;
use super::force_aliasing::PulseSampling;
use super::frf::FrfEstimate;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;

/// Options for extracting and accepting hits.
#[derive(Debug, Clone, PartialEq)]
pub struct ImpactOptions {
    /// Block length, samples; `None`: until the responses have decayed or the next hit begins.
    pub block: Option<usize>,
    /// Pulses closer than this are bounces of one hit, s.
    pub bounce_time_s: f64,
    /// Length of the force window as a share of the block; `None`: the pulse and some pulse widths after it.
    pub force_share: Option<f64>,
    /// Value of the exponential window on force and responses at the end of the block, 1 for none; `None`: by the decay of the responses.
    pub end: Option<f64>,
    /// Whether pulses of both signs are hits, as in the differences of a stepped force.
    pub both_signs: bool,
    /// Overload levels by channel, force first; if `None` or missing, clipping is detected by flat tops and by levels common to hits.
    pub overload: Vec<Option<f64>>,
    /// Ranges of samples known to be clipped, by channel, force first.
    pub clipped: Vec<Vec<Range<usize>>>,
}

impl Default for ImpactOptions {
    /// Automatic block and windows; bounces within 0.1 s, shorter than the interval between two manual hits.
    fn default() -> ImpactOptions {
        ImpactOptions {
            block: None,
            bounce_time_s: 0.1,
            force_share: None,
            end: None,
            both_signs: false,
            overload: Vec::new(),
            clipped: Vec::new(),
        }
    }
}

/// Reason for which a hit was rejected.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RejectReason {
    /// Double hit.
    Double,
    /// Channel with this index clipped: 0 is the force, 1, 2, … are the responses.
    Clipped(usize),
    /// The next hit, or the end of the segment, comes before the block is full.
    CutShort,
    /// The segment begins within the pulse.
    LateStart,
}

impl RejectReason {
    /// Short label, one or two words.
    pub fn label(self) -> &'static str {
        match self {
            RejectReason::Double => "double",
            RejectReason::Clipped(_) => "clipped",
            RejectReason::CutShort => "cut short",
            RejectReason::LateStart => "begun late",
        }
    }

    /// Description with the name of the clipped channel.
    pub fn description(self, channel: impl Fn(usize) -> String) -> String {
        match self {
            RejectReason::Double => "the hammer struck twice".to_string(),
            RejectReason::Clipped(at) => format!("{} clipped", channel(at)),
            RejectReason::CutShort => {
                "the next hit or the end comes before the block is full".to_string()
            }
            RejectReason::LateStart => "the record begins within the pulse".to_string(),
        }
    }
}

/// Hammer hit in the force channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Hit {
    /// Index of the sample of maximum force.
    pub sample: usize,
    /// Maximum force above the level between hits, in the unit of the channel.
    pub peak: f64,
    /// Reason of rejection; `None` if the hit was used.
    pub rejected: Option<RejectReason>,
}

/// Frequency responses estimated from hits.
#[derive(Debug, Clone)]
pub struct ImpactEstimate {
    /// Every hit, used or not.
    pub hits: Vec<Hit>,
    /// Block length, samples.
    pub block: usize,
    /// Power of the force by spectral line, averaged over the hits used.
    pub force_power: Vec<f64>,
    /// Sampling of the pulses; a stepped force is known between the samples and counts as resolved.
    pub sampling: PulseSampling,
    /// Frequency responses of single hits, if there are several.
    pub hit_responses: Vec<HitResponses>,
    /// Averaged estimate: channel 0 is the force, 1, 2, … are the responses, `window_decay` is σ. With a single hit the variance
    /// is that of the noise before it, and there is no coherence.
    pub estimate: FrfEstimate,
}

/// Minimum number of samples before a hit to estimate its noise.
const MIN_NOISE_SAMPLES: usize = 32;

/// Estimates frequency responses from the hits of `force` in the segments of a record.
///
/// # Errors
/// `NoSignal`: no pulse in the force. `TooShort`: every hit was rejected, with the reasons. `OutOfRange`: invalid options.
///
/// # Panics
/// If channels differ in length or segments exceed them.
pub fn estimate_from_hits(
    rate_hz: f64,
    force: &[f64],
    responses: &[&[f64]],
    segments: &[Range<usize>],
    options: &ImpactOptions,
) -> Result<ImpactEstimate, Error> {
    if options.block.is_some_and(|n| n < 16) || options.bounce_time_s.is_nan() {
        return Err(Error::new(
            Code::OutOfRange,
            "a block of a hit needs 16 samples or more, and the time for double hits must be a number",
        ));
    }
    let mut record = ImpactRecord {
        rate_hz,
        channels: std::iter::once(force)
            .chain(responses.iter().copied())
            .collect(),
        force_share: options.force_share,
        hits: Vec::new(),
    };
    for segment in segments {
        record.add_hits(segment, options);
    }
    if record.hits.is_empty() {
        return Err(
            Error::new(Code::NoSignal, "the force contains no hit").with_hint(
                "name the channel of the hammer's force, or estimate with a steady input instead",
            ),
        );
    }
    record.reject_overloads(options);
    let (block, sigma) = record.choose_block(options)?;
    let HitSums {
        mut estimate,
        force_power,
        hit_responses: by_hit,
    } = record.estimate(block, sigma)?;
    let sampling = match options.both_signs {
        true => PulseSampling::Resolved,
        false => PulseSampling::new(&force_power),
    };
    estimate.diagnostics.extend(sampling.warning(rate_hz));
    let hit = |hit: &HitBlock| Hit {
        sample: hit.pulse.peak,
        peak: hit.pulse.height,
        rejected: hit.rejected,
    };
    Ok(ImpactEstimate {
        hits: record.hits.iter().map(hit).collect(),
        block,
        force_power,
        sampling,
        hit_responses: by_hit,
        estimate,
    })
}

/// Frequency responses to one hit, or to a few successive hits if there are many.
#[derive(Debug, Clone, PartialEq)]
pub struct HitResponses {
    /// Indices of the hits.
    pub hits: Vec<usize>,
    /// `Σ X* Y / Σ |X|²` over these hits, by response and spectral line; zero if the force has no power.
    pub value: Vec<Vec<Complex>>,
}
