//! Frequency responses by local polynomials over the longest available blocks.

use super::super::sample_blocks;
use super::MIN_DEFAULT_BLOCK;
use crate::base::error::Error;
use crate::numeric::fft::prev_fast_len;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::frf::FrfEstimate;
use crate::spectrum::local_polynomial::{
    LocalPolynomialEstimator, MAX_POLE_BLOCKS, min_half_width,
};

/// Maximum number of lines of a first estimate in the band: a hundred modes of twenty lines each.
const MAX_FIRST_LINES: f64 = 2048.0;

/// Maximum number of samples over all channels in one transform.
const MAX_FFT_SAMPLES: usize = 1 << 23;

/// Minimum statistical degrees of freedom of the variance of a line: for a first estimate, and for narrow modes.
const MIN_VARIANCE_DOF: (usize, usize) = (8, 5);

/// Maximum block length of a transform without window, samples.
const MAX_UNWINDOWED_BLOCK: usize = 1 << 20;

/// Spectral flatness over neighbouring lines below which an input is periodic, with four or more periods in a block.
const MAX_PERIODIC_FLATNESS: f64 = 0.27;

/// Maximum share of a record with gaps that blocks without window leave unused.
const MAX_UNUSED_SHARE: f64 = 0.5;

/// Half-power bandwidth in line spacings below which parabolas over several blocks smear a resonance: the error of a parabola fitted to
/// 1/(1 + jx) on |x| ≤ a is (3/35) a⁴ at x = 0, which is 2 % at a = 2/3.
const POLYNOMIAL_SMEARING_LINES: f64 = 1.5;

/// Responses by local polynomials, with a description of the method and the resolution limits.
pub(super) struct LocalEstimate {
    pub(super) estimate: FrfEstimate,
    pub(super) method_text: String,
    pub(super) finest_resolution_hz: f64,
    pub(super) smearing_limit_lines: f64,
}

/// Block length for gap-free segments and the number of blocks; it maximises the product of the length, which sets the frequency
/// resolution, and the number of samples used. Candidates are the lengths of segments and of their equal parts, rounded down to
/// fast transform lengths; `max_len` is their limit.
fn common_block_len(segments: &[usize], max_len: usize) -> Option<(usize, usize)> {
    let mut lengths: Vec<usize> = segments
        .iter()
        .flat_map(|&s| {
            (s.div_ceil(max_len.max(1)).max(1)..=s / MIN_DEFAULT_BLOCK).map(move |parts| s / parts)
        })
        .map(prev_fast_len)
        .filter(|&length| length >= MIN_DEFAULT_BLOCK)
        .collect();
    lengths.sort_unstable_by(|a, b| b.cmp(a));
    lengths.dedup();
    let total = segments.iter().sum::<usize>() as f64;
    let mut best: Option<(f64, usize, usize)> = None;
    for length in lengths {
        if best.is_some_and(|b| length as f64 * total <= b.0) {
            break;
        }
        let count: usize = segments.iter().map(|s| s / length).sum();
        let used = (count * length) as f64;
        let merit = length as f64 * used;
        if used >= (1.0 - MAX_UNUSED_SHARE) * total && best.is_none_or(|b| merit > b.0) {
            best = Some((merit, length, count));
        }
    }
    best.map(|(_, length, count)| (length, count))
}

/// Estimates responses by local polynomials over the longest available blocks; `None` if an input is periodic or gaps leave too little.
pub(super) fn estimate_local(
    recording: &Recording,
    channels: &[&Channel],
    inputs: usize,
    band: (f64, f64),
    resolution_hz: Option<f64>,
) -> Result<Option<LocalEstimate>, Error> {
    let segments: Vec<usize> = recording.segments.iter().map(|s| s.len()).collect();
    let max_len = MAX_UNWINDOWED_BLOCK.min(MAX_FFT_SAMPLES / channels.len().max(1));
    let Some((block, count)) = common_block_len(&segments, max_len) else {
        return Ok(None);
    };
    let df = recording.rate_hz / block as f64;
    let coarse = min_half_width(inputs, count, MIN_VARIANCE_DOF.0);
    let finest = min_half_width(inputs, count, MIN_VARIANCE_DOF.1);
    let min_half = resolution_hz.map_or(coarse, |_| finest);
    let width = |half: usize| (2 * half + 1) as f64 * df;
    let spacing_hz = resolution_hz.unwrap_or((band.1 - band.0) / MAX_FIRST_LINES);
    let half = (((spacing_hz / df - 1.0) / 2.0).floor().max(0.0) as usize).max(min_half);
    let top = recording.rate_hz / 2.0;
    let Ok(mut local) = LocalPolynomialEstimator::new(
        recording.rate_hz,
        inputs,
        channels.len() - inputs,
        block,
        half,
        (0.0, top),
    ) else {
        return Ok(None);
    };
    let mut pending = vec![Vec::with_capacity(block); channels.len()];
    sample_blocks::for_each_block(recording, channels, |samples, is_segment_end| {
        let mut from = 0;
        let count = samples.first().map_or(0, |s| s.len());
        while from < count {
            let n = (block - pending[0].len()).min(count - from);
            for (pending, samples) in pending.iter_mut().zip(samples) {
                pending.extend_from_slice(&samples[from..from + n]);
            }
            from += n;
            if pending[0].len() == block {
                let views: Vec<&[f64]> = pending.iter().map(Vec::as_slice).collect();
                local.push(&views);
                pending.iter_mut().for_each(Vec::clear);
            }
        }
        if is_segment_end {
            pending.iter_mut().for_each(Vec::clear);
        }
    })?;
    if local.input_flatness(band) < MAX_PERIODIC_FLATNESS {
        return Ok(None);
    }
    let Ok(estimate) = local.finish() else {
        return Ok(None);
    };
    let unused = segments.iter().sum::<usize>() - count * block;
    let method_text = format!(
        "local parabolas through {} neighbouring lines of {}, no window and no leakage: lines {:.4} Hz apart{}",
        2 * half + 1,
        match count {
            1 => format!("one block of {:.4} s", block as f64 / recording.rate_hz),
            n => format!("{n} blocks of {:.4} s", block as f64 / recording.rate_hz),
        },
        width(half),
        match segments.len() {
            0 | 1 => String::new(),
            n => format!(
                "; {:.4} s of {:.4} s not used, at the ends of the {n} segments between gaps",
                unused as f64 / recording.rate_hz,
                recording.samples as f64 / recording.rate_hz
            ),
        }
    );
    Ok(Some(LocalEstimate {
        estimate,
        method_text,
        finest_resolution_hz: width(finest),
        smearing_limit_lines: match count {
            // With so few blocks the windows are fitted with poles, which do not smear.
            1..=MAX_POLE_BLOCKS => 0.0,
            _ => POLYNOMIAL_SMEARING_LINES,
        },
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two segments: blocks of the shorter length if it is nearly half of the record, the longer segment only if the other is much shorter.
    #[test]
    fn exact_common_block() {
        let max = MAX_UNWINDOWED_BLOCK;
        assert_eq!(common_block_len(&[60_000], max), Some((60_000, 1)));
        assert_eq!(common_block_len(&[30_000, 30_000], max), Some((30_000, 2)));
        assert_eq!(common_block_len(&[32_000, 27_000], max), Some((27_000, 2)));
        assert_eq!(common_block_len(&[54_000, 5_999], max), Some((54_000, 1)));
        // Three blocks of the shorter length, 20 000 × 60 000, have a smaller product than 40 000 × 40 000.
        assert_eq!(common_block_len(&[40_000, 20_000], max), Some((40_000, 1)));
        // Limited transform length; segments too short for any block.
        assert_eq!(common_block_len(&[60_000], 20_000), Some((20_000, 3)));
        assert_eq!(common_block_len(&[255; 100], max), None);
        assert_eq!(common_block_len(&[], max), None);
    }
}
