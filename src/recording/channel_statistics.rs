//! Channel statistics: range, mean, standard deviation, noise, clipping.

use super::clipping::{self, ClippingDetector};
use super::signals::{Channel, Recording};
use crate::base::error::Error;
use crate::numeric::statistics::median;

/// Facts of one channel.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelStatistics {
    /// Smallest and largest sample.
    pub range: (f64, f64),
    /// Mean of all samples: the DC part.
    pub mean: f64,
    /// Root mean square about the mean.
    pub std: f64,
    /// All samples are equal.
    pub constant: bool,
    /// Root mean square of what changes from sample to sample without regularity, by the median of fourth differences: the white
    /// noise of the channel, an upper bound of it where the signal reaches near half the rate.
    pub noise: f64,
    /// Clipped tops: how many, and their level.
    pub clipped: Option<(usize, f64)>,
    /// Samples at or beyond the stated overload level, and overload words.
    pub overloads: usize,
    /// No sample is a number.
    pub empty: bool,
}

/// Surveys a channel over the segments of its recording.
///
/// # Errors
/// The samples cannot be read.
pub fn channel_statistics(
    recording: &Recording,
    channel: &Channel,
) -> Result<ChannelStatistics, Error> {
    let (mut low, mut high, mut resolution) = (f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY);
    let (mut count, mut mean, mut square, mut overloads) = (0.0, 0.0, 0.0, channel.overloads);
    let mut fourths = Vec::new();
    let level = channel.overload_level.unwrap_or(f64::INFINITY);
    recording.each_block(channel, |_, block, _| {
        for &x in block.iter().filter(|x| x.is_finite()) {
            (low, high) = (low.min(x), high.max(x));
            // Welford's running mean and sum of squares.
            count += 1.0;
            let before = x - mean;
            mean += before / count;
            square += before * (x - mean);
            overloads += usize::from(x.abs() >= level);
        }
        for pair in block.windows(2) {
            let step = (pair[1] - pair[0]).abs();
            if step > 0.0 {
                resolution = resolution.min(step);
            }
        }
        const MAX_NOISE_SAMPLES: usize = 200_000;
        if fourths.len() < MAX_NOISE_SAMPLES {
            fourths.extend(
                block
                    .windows(5)
                    .map(|w| (w[0] - 4.0 * w[1] + 6.0 * w[2] - 4.0 * w[3] + w[4]).abs()),
            );
        }
    })?;
    let empty = count == 0.0;
    let constant = !empty && low == high;
    let clipped = match constant || empty {
        true => None,
        false => {
            let mut extremes = ClippingDetector::new((low, high), resolution);
            recording.each_block(channel, |_, block, _| extremes.push(block))?;
            clipping::clipped_tops(&extremes)
        }
    };
    Ok(ChannelStatistics {
        range: (low, high),
        mean,
        std: if empty { 0.0 } else { (square / count).sqrt() },
        constant,
        noise: noise_std(&mut fourths),
        clipped,
        overloads,
        empty,
    })
}

/// Standard deviation of white noise whose fourth differences have this median size.
fn noise_std(fourths: &mut [f64]) -> f64 {
    // Σ(1,4,6,4,1)² = 70; a normal variable is above 0.6745 of its deviation half of the time.
    median(fourths).map_or(0.0, |median| median / 70f64.sqrt() / 0.674_489_75)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn statistics_of_segment(samples: &[f64]) -> ChannelStatistics {
        let recording = Recording::from_arrays(1000.0, &[("a", "g", samples)]).unwrap();
        channel_statistics(&recording, &recording.channels[0]).unwrap()
    }

    #[test]
    fn exact_mean_and_noise() {
        let mut random = fastrand::Rng::with_seed(5);
        // The sum of twelve uniform numbers is nearly normal with variance 1.
        let mut normal = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
        let x: Vec<f64> = (0..100_000)
            .map(|k| 3.0 + (0.01 * f64::from(k)).sin() + 0.1 * normal())
            .collect();
        let found = statistics_of_segment(&x);
        assert!((found.mean - 3.0).abs() < 0.01);
        assert!((found.noise / 0.1 - 1.0).abs() < 0.03, "{}", found.noise);
        assert!(statistics_of_segment(&[2.0; 50]).constant);
    }
}
