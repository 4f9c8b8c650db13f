//! FRFs from hammer hits: clipped, double and truncated hits rejected, the others averaged by H1.
//!
//! Halvorsen & Brown, Impulse technique for structural frequency response testing, Sound and Vibration 11 (1977), pp. 8–21. The
//! force is zeroed behind its pulse. Where a response has not decayed at the end of the block, `exp(−σt)` lies on force and
//! response alike: the response found is the structure's with every pole moved left by σ, exactly.

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
    /// Samples of a block; `None`: until the responses have decayed, or the next hit.
    pub block: Option<usize>,
    /// Pulses closer than this are one stroke that bounced, s.
    pub double_within_s: f64,
    /// Share of the block over which the force is kept; `None`: the pulse and some widths behind it.
    pub force_share: Option<f64>,
    /// Final value of an exponential window on force and responses at the end of the block, 1 for none; `None`: as the responses need it.
    pub end: Option<f64>,
    /// Pulses to both sides count, as of the differences of a force that steps.
    pub both_sides: bool,
    /// Levels at which channels overload, force first; where `None` or missing, flat tops are looked for, and levels that hits share.
    pub overload: Vec<Option<f64>>,
    /// Samples known to be clipped, by channel, force first.
    pub clipped: Vec<Vec<Range<usize>>>,
}

impl Default for ImpactOptions {
    /// Blocks as the data want them; bounces within 0.1 s, sooner than a hand strikes again.
    fn default() -> ImpactOptions {
        ImpactOptions {
            block: None,
            double_within_s: 0.1,
            force_share: None,
            end: None,
            both_sides: false,
            overload: Vec::new(),
            clipped: Vec::new(),
        }
    }
}

/// Why a hit was set aside.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RejectReason {
    /// The hammer struck twice.
    Double,
    /// A channel clipped: 0 is the force, 1, 2, … are the responses.
    Clipped(usize),
    /// The next hit, or the end of the segment, comes before the block is full.
    CutShort,
    /// The segment begins within the pulse.
    LateStart,
}

impl RejectReason {
    /// In one word or two.
    pub fn label(self) -> &'static str {
        match self {
            RejectReason::Double => "double",
            RejectReason::Clipped(_) => "clipped",
            RejectReason::CutShort => "cut short",
            RejectReason::LateStart => "begun late",
        }
    }

    /// In words, with the name of the channel that clipped.
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

/// A hit of the hammer in the force channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Hit {
    /// Sample of its largest force.
    pub sample: usize,
    /// Largest force over the level between hits.
    pub peak: f64,
    /// Why it was set aside; `None` where it was used.
    pub rejected: Option<RejectReason>,
}

/// Frequency responses from hits.
#[derive(Debug, Clone)]
pub struct ImpactEstimate {
    /// Every hit, used or not.
    pub hits: Vec<Hit>,
    /// Samples of a block.
    pub block: usize,
    /// Power of the force by line, averaged over the hits used.
    pub force_power: Vec<f64>,
    /// Sampling of the pulses; a step is known between its samples as well, and counts as resolved.
    pub sampling: PulseSampling,
    /// The responses hit by hit, where there are several.
    pub by_hit: Vec<HitResponses>,
    /// Channel 0 is the force, 1, 2, … are the responses. With a single hit the variance is that of the noise before it, and there
    /// is no coherence. `window_decay` is σ.
    pub estimate: FrfEstimate,
}

/// Fewer samples before a hit do not tell its noise.
const MIN_NOISE_SAMPLES: usize = 32;

/// Frequency responses to the hits of `force`, over the segments of a record.
///
/// # Errors
/// `NoSignal`: no pulse in the force. `TooShort`: no hit fit for use, with the reason of each. `OutOfRange`: options that cannot be.
///
/// # Panics
/// Channels of unequal length, stretches beyond them: mistakes of the caller.
pub fn estimate_from_hits(
    rate_hz: f64,
    force: &[f64],
    responses: &[&[f64]],
    segments: &[Range<usize>],
    options: &ImpactOptions,
) -> Result<ImpactEstimate, Error> {
    if options.block.is_some_and(|n| n < 16) || options.double_within_s.is_nan() {
        return Err(Error::new(
            Code::OutOfRange,
            "a block of a hit needs 16 samples or more, and bounces a time",
        ));
    }
    let mut record = ImpactRecord {
        rate_hz,
        channels: std::iter::once(force)
            .chain(responses.iter().copied())
            .collect(),
        force_share: options.force_share,
        cuts: Vec::new(),
    };
    for segment in segments {
        record.cut(segment, options);
    }
    if record.cuts.is_empty() {
        return Err(
            Error::new(Code::NoSignal, "the force holds no hit").with_hint(
                "name the channel of the hammer's force, or estimate with a steady input instead",
            ),
        );
    }
    record.reject_overloads(options);
    let (block, sigma) = record.choose_block(options)?;
    let HitSums {
        mut estimate,
        force_power,
        by_hit,
    } = record.estimate(block, sigma)?;
    let sampling = match options.both_sides {
        true => PulseSampling::Resolved,
        false => PulseSampling::new(&force_power),
    };
    estimate.diagnostics.extend(sampling.warning(rate_hz));
    let hit = |cut: &HitBlock| Hit {
        sample: cut.pulse.peak,
        peak: cut.pulse.height,
        rejected: cut.rejected,
    };
    Ok(ImpactEstimate {
        hits: record.cuts.iter().map(hit).collect(),
        block,
        force_power,
        sampling,
        by_hit,
        estimate,
    })
}

/// Frequency responses to one hit, or to a few that follow each other where there are many.
#[derive(Debug, Clone, PartialEq)]
pub struct HitResponses {
    /// Places of the hits among all.
    pub hits: Vec<usize>,
    /// `Σ X* Y / Σ |X|²` over these hits, by response and line; zero where the force has no power.
    pub value: Vec<Vec<Complex>>,
}
