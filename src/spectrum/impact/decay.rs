//! Levels of a decay, and the time until it is in the noise.

/// A response has decayed at this share of its beginning, or in the noise, whichever is larger.
const DECAY_LEVEL: f64 = 1e-3;

/// Segments of a decay whose levels are compared.
const DECAY_SEGMENTS: usize = 64;

/// The noise's level times this is still noise: of the root mean square of 20 samples or more, three times never happens.
pub(super) const NOISE_FACTOR: f64 = 3.0;

/// Root mean square of up to 64 segments of equal length.
pub fn levels(samples: &[f64]) -> Vec<f64> {
    let segment = samples.len().div_ceil(DECAY_SEGMENTS).max(1);
    samples.chunks(segment).map(rms).collect()
}

/// Samples until a response stays in the noise, or below a thousandth of its largest level; all where it never does.
pub fn decay_length(samples: &[f64], noise: f64) -> usize {
    let levels = levels(samples);
    let largest = levels.iter().copied().fold(0.0, f64::max);
    let limit = (DECAY_LEVEL * largest).max(NOISE_FACTOR * noise);
    let segment = samples.len().div_ceil(DECAY_SEGMENTS).max(1);
    let last = levels.iter().rposition(|&level| level > limit);
    last.map_or(0, |at| ((at + 1) * segment).min(samples.len()))
}

pub(super) fn rms(samples: &[f64]) -> f64 {
    (samples.iter().map(|x| x * x).sum::<f64>() / samples.len().max(1) as f64).sqrt()
}
