//! Output covariances `R_τ = E y_{t+τ} y_{ref,t}ᵀ` of a record and of its consecutive parts.
//!
//! Lag products are computed by FFT with zero padding against circular wrap-around, so the sums are exact; the cost is one transform per
//! channel and reference in each piece of the record. Memory depends on lags, channels and parts, not on the length of the record.

use super::response_channels::{ResponseChannels, check_references};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::{RealFft, next_fast_len};

/// Minimum transform length, samples; longer pieces cost less per sample while they fit the cache.
const MIN_TRANSFORM_LENGTH: usize = 512;

/// Covariances of a record and of its consecutive parts.
#[derive(Debug, Clone)]
pub struct Covariances {
    /// Number of response channels.
    pub channels: usize,
    /// Indices of the reference channels.
    pub references: Vec<usize>,
    /// Highest lag, samples.
    pub lags: usize,
    /// Number of products per lag, by part.
    pub counts: Vec<usize>,
    /// `R_τ(c, r)` of the record at `(τ·references + r)·channels + c`; each response divided by its scale.
    pub mean: Vec<f64>,
    /// Covariances of each part about the mean of the record.
    pub parts: Vec<Vec<f64>>,
}

impl Covariances {
    /// Covariances of responses divided by `scale`, for lags 0 to `lags`, in the given number of parts of equal length.
    ///
    /// # Errors
    /// `NoChannel` without references or for one that is not a channel; `TooShort` where a part has fewer samples than lags.
    pub fn new(
        channels: &ResponseChannels,
        scale: &[f64],
        references: &[usize],
        lags: usize,
        parts: usize,
    ) -> Result<Covariances, Error> {
        let samples = channels.samples();
        check_references(references, samples.len())?;
        let n = channels.n_samples();
        let needed = parts * (lags + 1) + lags;
        if n < needed {
            let message =
                format!("{n} samples for {parts} parts with covariances over {lags} lags");
            return Err(Error::new(Code::TooShort, message)
                .with_hint(format!("take a longer record: {needed} samples or more")));
        }
        let mut products = LagProducts::new(channels, scale, references, lags);
        let total = n - lags;
        let bounds: Vec<usize> = (0..=parts).map(|k| k * total / parts).collect();
        let counts: Vec<usize> = bounds.windows(2).map(|b| b[1] - b[0]).collect();
        let parts: Vec<Vec<f64>> = (bounds.windows(2))
            .map(|b| products.mean_products(b[0], b[1]))
            .collect();
        let mut mean = vec![0.0; parts.first().map_or(0, Vec::len)];
        for (part, count) in parts.iter().zip(&counts) {
            let weight = *count as f64 / total as f64;
            (mean.iter_mut().zip(part)).for_each(|(m, x)| *m += weight * x);
        }
        Ok(Covariances {
            channels: samples.len(),
            references: references.to_vec(),
            lags,
            counts,
            mean,
            parts,
        })
    }

    /// `R_τ(c, r)` of the record; `reference` is an index into `references`.
    pub fn value(&self, lag: usize, channel: usize, reference: usize) -> f64 {
        self.mean[(lag * self.references.len() + reference) * self.channels + channel]
    }

    /// Covariances of the record without one part.
    pub fn leave_out(&self, part: usize) -> Vec<f64> {
        let total: usize = self.counts.iter().sum();
        let count = self.counts[part] as f64;
        let remaining = total as f64 - count;
        (self.mean.iter().zip(&self.parts[part]))
            .map(|(m, x)| (total as f64 * m - count * x) / remaining)
            .collect()
    }
}

/// Lag products of consecutive samples, with workspace.
struct LagProducts<'a> {
    samples: &'a [&'a [f64]],
    means: Vec<f64>,
    scale: &'a [f64],
    references: &'a [usize],
    lags: usize,
    piece: usize,
    transform: RealFft,
    padded: Vec<f64>,
    leading: Vec<Vec<Complex>>,
    trailing: Vec<Vec<Complex>>,
}

impl<'a> LagProducts<'a> {
    fn new(
        channels: &ResponseChannels<'a>,
        scale: &'a [f64],
        references: &'a [usize],
        lags: usize,
    ) -> LagProducts<'a> {
        let samples = channels.samples();
        let transform = RealFft::new(next_fast_len((4 * lags).max(MIN_TRANSFORM_LENGTH)));
        let lines = vec![Complex::ZERO; transform.lines()];
        LagProducts {
            means: (samples.iter())
                .map(|s| s.iter().sum::<f64>() / s.len() as f64)
                .collect(),
            samples,
            scale,
            references,
            lags,
            piece: transform.samples() - lags,
            padded: vec![0.0; transform.samples()],
            leading: vec![lines.clone(); references.len()],
            trailing: vec![lines; samples.len()],
            transform,
        }
    }

    /// Mean products of the samples `from..to` with those up to the highest lag later.
    fn mean_products(&mut self, from: usize, to: usize) -> Vec<f64> {
        let (nr, nc) = (self.references.len(), self.samples.len());
        let mut products = vec![vec![Complex::ZERO; self.transform.lines()]; nr * nc];
        for start in (from..to).step_by(self.piece) {
            let end = (start + self.piece).min(to);
            for c in 0..nc {
                self.load(c, start, end + self.lags);
                self.transform
                    .forward(&mut self.padded, &mut self.trailing[c]);
            }
            for k in 0..nr {
                self.load(self.references[k], start, end);
                self.transform
                    .forward(&mut self.padded, &mut self.leading[k]);
            }
            for (i, product) in products.iter_mut().enumerate() {
                let pairs = self.trailing[i % nc].iter().zip(&self.leading[i / nc]);
                (product.iter_mut().zip(pairs)).for_each(|(p, (y, x))| *p += y * x.conj());
            }
        }
        let mut means = vec![0.0; (self.lags + 1) * nr * nc];
        let count = (to - from) as f64;
        for (i, product) in products.iter_mut().enumerate() {
            self.transform.inverse(product, &mut self.padded);
            let scale = self.scale[i % nc] * self.scale[self.references[i / nc]] * count;
            for lag in 0..=self.lags {
                means[lag * nr * nc + i] = self.padded[lag] / scale;
            }
        }
        means
    }

    /// Loads samples of a channel minus its mean, zero padded.
    fn load(&mut self, channel: usize, from: usize, to: usize) {
        let mean = self.means[channel];
        self.padded.fill(0.0);
        let samples = &self.samples[channel][from..to];
        (self.padded.iter_mut().zip(samples)).for_each(|(p, x)| *p = x - mean);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Covariances of three parts agree with direct sums, for signals with an offset; those without a part with the sums over the others.
    #[test]
    fn exact_sums_in_parts() {
        const LAGS: usize = 20;
        let mut rng = fastrand::Rng::with_seed(1);
        let y: Vec<Vec<f64>> = (0..2)
            .map(|_| (0..5000).map(|_| rng.f64() + 3.0).collect())
            .collect();
        let views: Vec<&[f64]> = y.iter().map(Vec::as_slice).collect();
        let channels = ResponseChannels::new(&views, 1.0).unwrap();
        let covariances = Covariances::new(&channels, &[1.0, 2.0], &[1], LAGS, 3).unwrap();
        let m: Vec<f64> = y
            .iter()
            .map(|c| c.iter().sum::<f64>() / c.len() as f64)
            .collect();
        let direct = |lag: usize, c: usize, times: std::ops::Range<usize>| {
            let count = times.len() as f64;
            let product = |t: usize| (y[c][t + lag] - m[c]) * (y[1][t] - m[1]);
            times.map(product).sum::<f64>() / count / (2.0 * [1.0, 2.0][c])
        };
        let ends = [0, 1660, 3320, 4980];
        for (lag, c) in (0..=LAGS).flat_map(|lag| (0..2).map(move |c| (lag, c))) {
            assert!((covariances.value(lag, c, 0) - direct(lag, c, 0..4980)).abs() < 1e-12);
            for k in 0..3 {
                let part = covariances.parts[k][lag * 2 + c];
                assert!((part - direct(lag, c, ends[k]..ends[k + 1])).abs() < 1e-12);
            }
            let remaining = covariances.leave_out(0)[lag * 2 + c];
            assert!((remaining - direct(lag, c, 1660..4980)).abs() < 1e-12);
        }
    }
}
