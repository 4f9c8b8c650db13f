//! Responses by local polynomials over blocks as long as the record has them.

use super::super::sample_blocks;
use super::MIN_DEFAULT_BLOCK;
use crate::base::error::Error;
use crate::numeric::fft::prev_fast_len;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::frf::FrfEstimate;
use crate::spectrum::local_polynomial::{
    LocalPolynomialEstimator, MAX_POLE_BLOCKS, min_half_width,
};

/// Lines of a first look inside the band, at most: enough for a hundred modes of twenty lines each.
const MAX_FIRST_LINES: f64 = 2048.0;

/// Samples over all channels that are transformed at once.
const MAX_FFT_SAMPLES: usize = 1 << 23;

/// Degrees of freedom of the variance of a line, at least: of a first look, and where modes are narrow.
const MIN_VARIANCE_DOF: (usize, usize) = (8, 5);

/// The longest block of a transform without a window.
const MAX_UNWINDOWED_BLOCK: usize = 1 << 20;

/// Inputs whose power lies on a smaller share of neighbouring lines repeat: four times or more inside a block.
const MAX_PERIODIC_FLATNESS: f64 = 0.27;

/// Blocks without a window that leave out more than this share of a record with gaps are none.
const MAX_UNUSED_SHARE: f64 = 0.5;

/// The same of parabolas over several blocks. Of 1/(1 + jx) over windows that reach to x = ±a, a parabola misses (3/35) a⁴ in the middle;
/// with so many windows in the half-power width, a = 2/3, that is 2 %.
const POLYNOMIAL_SMEARING_LINES: f64 = 1.5;

/// Responses by local polynomials, and how they were had.
pub(super) struct LocalEstimate {
    pub(super) estimate: FrfEstimate,
    pub(super) method_text: String,
    pub(super) finest_resolution_hz: f64,
    pub(super) smearing_limit_lines: f64,
}

/// A length of block for a record of segments without gaps, and how many of them it has: that of the best product of the
/// length, which tells neighbouring lines apart, and the samples used. Lengths are those of segments and of their equal parts,
/// quick to transform.
fn common_block_len(segments: &[usize], most: usize) -> Option<(usize, usize)> {
    let mut lengths: Vec<usize> = segments
        .iter()
        .flat_map(|&s| {
            (s.div_ceil(most.max(1)).max(1)..=s / MIN_DEFAULT_BLOCK).map(move |parts| s / parts)
        })
        .map(prev_fast_len)
        .filter(|&length| length >= MIN_DEFAULT_BLOCK)
        .collect();
    lengths.sort_unstable_by(|a, b| b.cmp(a));
    lengths.dedup();
    let whole = segments.iter().sum::<usize>() as f64;
    let mut best: Option<(f64, usize, usize)> = None;
    for length in lengths {
        if best.is_some_and(|b| length as f64 * whole <= b.0) {
            break;
        }
        let count: usize = segments.iter().map(|s| s / length).sum();
        let used = (count * length) as f64;
        let worth = length as f64 * used;
        if used >= (1.0 - MAX_UNUSED_SHARE) * whole && best.is_none_or(|b| worth > b.0) {
            best = Some((worth, length, count));
        }
    }
    best.map(|(_, length, count)| (length, count))
}

/// Responses by local polynomials over blocks as long as the record has them; nothing where an input repeats or gaps leave too little.
pub(super) fn estimate_local(
    recording: &Recording,
    channels: &[&Channel],
    inputs: usize,
    band: (f64, f64),
    apart_hz: Option<f64>,
) -> Result<Option<LocalEstimate>, Error> {
    let segments: Vec<usize> = recording.segments.iter().map(|s| s.len()).collect();
    let most = MAX_UNWINDOWED_BLOCK.min(MAX_FFT_SAMPLES / channels.len().max(1));
    let Some((block, count)) = common_block_len(&segments, most) else {
        return Ok(None);
    };
    let df = recording.rate_hz / block as f64;
    let first = min_half_width(inputs, count, MIN_VARIANCE_DOF.0);
    let last = min_half_width(inputs, count, MIN_VARIANCE_DOF.1);
    let least = if apart_hz.is_some() { last } else { first };
    let width = |half: usize| (2 * half + 1) as f64 * df;
    let wanted = apart_hz.unwrap_or((band.1 - band.0) / MAX_FIRST_LINES);
    let half = (((wanted / df - 1.0) / 2.0).floor().max(0.0) as usize).max(least);
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
    sample_blocks::for_each_block(recording, channels, |samples, ends| {
        let mut from = 0;
        let count = samples.first().map_or(0, |s| s.len());
        while from < count {
            let take = (block - pending[0].len()).min(count - from);
            for (pending, samples) in pending.iter_mut().zip(samples) {
                pending.extend_from_slice(&samples[from..from + take]);
            }
            from += take;
            if pending[0].len() == block {
                let views: Vec<&[f64]> = pending.iter().map(Vec::as_slice).collect();
                local.push(&views);
                pending.iter_mut().for_each(Vec::clear);
            }
        }
        if ends {
            pending.iter_mut().for_each(Vec::clear);
        }
    })?;
    if local.input_flatness(band) < MAX_PERIODIC_FLATNESS {
        return Ok(None);
    }
    let Ok(estimate) = local.finish() else {
        return Ok(None);
    };
    let left_out = segments.iter().sum::<usize>() - count * block;
    let how = format!(
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
                left_out as f64 / recording.rate_hz,
                recording.samples as f64 / recording.rate_hz
            ),
        }
    );
    Ok(Some(LocalEstimate {
        estimate,
        method_text: how,
        finest_resolution_hz: width(last),
        smearing_limit_lines: match count {
            // Parabolas stand over poles.
            1..=MAX_POLE_BLOCKS => 0.0,
            _ => POLYNOMIAL_SMEARING_LINES,
        },
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One sample missing: blocks of the shorter segment where it is nearly a half, the longer segment alone where it is far longer.
    #[test]
    fn exact_common_block() {
        let most = MAX_UNWINDOWED_BLOCK;
        assert_eq!(common_block_len(&[60_000], most), Some((60_000, 1)));
        assert_eq!(common_block_len(&[30_000, 30_000], most), Some((30_000, 2)));
        assert_eq!(common_block_len(&[32_000, 27_000], most), Some((27_000, 2)));
        assert_eq!(common_block_len(&[54_000, 5_999], most), Some((54_000, 1)));
        // Three blocks of the shorter one, 20 000 × 60 000, are worth less than 40 000 × 40 000.
        assert_eq!(common_block_len(&[40_000, 20_000], most), Some((40_000, 1)));
        // Transforms no longer than allowed; segments too short for any block.
        assert_eq!(common_block_len(&[60_000], 20_000), Some((20_000, 3)));
        assert_eq!(common_block_len(&[255; 100], most), None);
        assert_eq!(common_block_len(&[], most), None);
    }
}
