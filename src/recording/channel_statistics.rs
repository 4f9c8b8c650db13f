//! Channel statistics: range, mean, standard deviation, noise, clipping.

use super::clipping::{self, ClippingDetector};
use super::signals::{Channel, Recording};
use crate::base::error::Error;
use crate::numeric::statistics::median;

/// Statistics of the samples of one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelStatistics {
    /// Smallest and largest sample.
    pub range: (f64, f64),
    /// Mean of all samples.
    pub mean: f64,
    /// Standard deviation.
    pub std: f64,
    /// True if all samples are equal.
    pub constant: bool,
    /// Standard deviation of the white noise, by the median of fourth differences; an upper bound for signals with components near the
    /// Nyquist frequency.
    pub noise: f64,
    /// Number of clipped extremes, and their level; `None` without clipping.
    pub clipped: Option<(usize, f64)>,
    /// Number of samples at or beyond the stated overload level, plus overload words of the file.
    pub overloads: usize,
    /// True if no sample is finite.
    pub empty: bool,
}

/// Computes the statistics of a channel over the segments of its recording.
///
/// # Errors
/// The samples cannot be read.
pub fn channel_statistics(
    recording: &Recording,
    channel: &Channel,
) -> Result<ChannelStatistics, Error> {
    let (mut low, mut high, mut resolution) = (f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY);
    let (mut moments, mut overloads) = (Moments::default(), channel.overloads);
    let (mut fourths, mut finite) = (Vec::new(), Vec::new());
    recording.each_block(channel, |_, block, _| {
        for part in block.chunks(PART_LEN) {
            finite.clear();
            finite.extend(part.iter().copied().filter(|x| x.is_finite()));
            low = finite.iter().fold(low, |a, &x| if x < a { x } else { a });
            high = finite.iter().fold(high, |a, &x| if x > a { x } else { a });
            moments.add(&finite);
            if let Some(level) = channel.overload_level {
                overloads += finite.iter().filter(|x| x.abs() >= level).count();
            }
        }
        resolution = block.windows(2).fold(resolution, |least, pair| {
            let step = (pair[1] - pair[0]).abs();
            if step > 0.0 && step < least {
                step
            } else {
                least
            }
        });
        const MAX_NOISE_SAMPLES: usize = 200_000;
        if fourths.len() < MAX_NOISE_SAMPLES {
            fourths.extend(
                block
                    .windows(5)
                    .map(|w| (w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs()),
            );
        }
    })?;
    let empty = moments.count == 0.0;
    let constant = !empty && low == high;
    let clipped = match constant || empty {
        true => None,
        false => {
            let mut detector = ClippingDetector::new((low, high), resolution);
            recording.each_block(channel, |_, block, _| detector.push(block))?;
            clipping::clipped_tops(&detector)
        }
    };
    Ok(ChannelStatistics {
        range: (low, high),
        mean: moments.mean,
        std: moments.standard_deviation(),
        constant,
        noise: noise_std(&mut fourths),
        clipped,
        overloads,
        empty,
    })
}

/// Standard deviation of a channel in a single pass over its samples; 0 if no sample is finite.
///
/// # Errors
/// The samples cannot be read.
pub fn standard_deviation(recording: &Recording, channel: &Channel) -> Result<f64, Error> {
    let (mut moments, mut finite) = (Moments::default(), Vec::new());
    recording.each_block(channel, |_, block, _| {
        for part in block.chunks(PART_LEN) {
            finite.clear();
            finite.extend(part.iter().copied().filter(|x| x.is_finite()));
            moments.add(&finite);
        }
    })?;
    Ok(moments.standard_deviation())
}

/// Number of samples per partial sum: they fit the first-level cache.
const PART_LEN: usize = 2048;

/// Count, mean and sum of squares about the mean, combined over parts (Chan, Golub and LeVeque 1983, The American Statistician 37,
/// 242–247, eq. 2.1).
#[derive(Default)]
struct Moments {
    count: f64,
    mean: f64,
    square: f64,
}

impl Moments {
    fn add(&mut self, part: &[f64]) {
        let Some(&shift) = part.first() else { return };
        let count = part.len() as f64;
        let mean = shift + sum(part, |x| x - shift) / count;
        let square = sum(part, |x| (x - mean) * (x - mean));
        let (total, step) = (self.count + count, mean - self.mean);
        self.square += square + step * step * self.count * count / total;
        self.mean += step * count / total;
        self.count = total;
    }

    fn standard_deviation(&self) -> f64 {
        match self.count {
            0.0 => 0.0,
            count => (self.square / count).sqrt(),
        }
    }
}

/// Sum of a term over samples, in eight interleaved partial sums.
fn sum(samples: &[f64], term: impl Fn(f64) -> f64) -> f64 {
    let (eights, rest) = samples.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for eight in eights {
        for (sum, &x) in sums.iter_mut().zip(eight) {
            *sum += term(x);
        }
    }
    sums.iter().sum::<f64>() + rest.iter().map(|&x| term(x)).sum::<f64>()
}

/// Standard deviation of white noise from the absolute values of its fourth differences.
fn noise_std(fourths: &mut [f64]) -> f64 {
    // Σ(1,4,6,4,1)² = 70; the median of |x| of a normal variable is 0.6745 of its standard deviation.
    median(fourths).map_or(0.0, |median| median / 70f64.sqrt() / 0.674_489_75)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn statistics_of_segment(samples: &[f64]) -> ChannelStatistics {
        let recording = Recording::from_arrays(1000.0, &[("a", "g", samples)]).unwrap();
        channel_statistics(&recording, &recording.channels[0]).unwrap()
    }

    /// Moments of parts far from zero and from each other; plain sums of squares would lose all digits.
    #[test]
    fn exact_moments_of_parts() {
        let x: Vec<f64> = (0..10_000)
            .map(|k| 1e9 + f64::from(k % 7) + if k < 3000 { 0.0 } else { 50.0 })
            .collect();
        let stats = statistics_of_segment(&x);
        let n = x.len() as f64;
        let mean = x.iter().map(|x| x - 1e9).sum::<f64>() / n;
        let square = x.iter().map(|x| (x - 1e9 - mean).powi(2)).sum::<f64>();
        assert!((stats.mean - 1e9 - mean).abs() < 1e-6, "{}", stats.mean);
        assert!(
            (stats.std / (square / n).sqrt() - 1.0).abs() < 1e-9,
            "{}",
            stats.std
        );
    }

    #[test]
    fn exact_mean_and_noise() {
        let mut random = fastrand::Rng::with_seed(5);
        // The sum of twelve uniform numbers is nearly normal with variance 1.
        let mut normal = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
        let x: Vec<f64> = (0..100_000)
            .map(|k| 3.0 + (0.01 * f64::from(k)).sin() + 0.1 * normal())
            .collect();
        let stats = statistics_of_segment(&x);
        assert!((stats.mean - 3.0).abs() < 0.01);
        assert!((stats.noise / 0.1 - 1.0).abs() < 0.03, "{}", stats.noise);
        assert!(statistics_of_segment(&[2.0; 50]).constant);
    }
}
