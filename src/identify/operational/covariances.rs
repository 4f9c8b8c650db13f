//! Covariances `R_τ = E y_{t+τ} y_{ref,t}ᵀ` of responses, gathered block by block, with their scatter from block to block.
//!
//! Products of whole segments are taken by transforms padded so far that no lag wraps: the sums are the exact ones, at a cost of a
//! few transforms instead of one multiplication per lag. Memory depends on lags and channels, not on the length of the record.

use super::channels::check_references;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::{RealFft, quick_length};

/// Blocks kept for the scatter: neighbours are merged at twice as many. Fewer leave the scatter itself uncertain by `1/√(2·blocks)`,
/// more make them short against the time a mode takes to die away.
const BLOCKS: usize = 32;

/// Sums of products, growing with each stretch of samples.
pub struct Gathering {
    channels: usize,
    references: Vec<usize>,
    lags: usize,
    segment: usize,
    /// Taken off every sample: the mean of the first stretch, so that offsets do not swallow digits.
    offset: Vec<f64>,
    /// Samples that no segment has used up, by channel.
    waiting: Vec<Vec<f64>>,
    transform: RealFft,
    padded: Vec<f64>,
    leading: Vec<Vec<Complex>>,
    trailing: Vec<Vec<Complex>>,
    product: Vec<Complex>,
    /// Segments of a block.
    block_segments: usize,
    open: Block,
    open_segments: usize,
    closed: Vec<Block>,
}

/// Sums over one block.
#[derive(Debug, Clone)]
struct Block {
    samples: usize,
    /// `Σ y_{t+τ,c} y_{t,r}` at `(τ·references + r)·channels + c`.
    products: Vec<f64>,
    /// `Σ y_{t,c}`.
    sums: Vec<f64>,
}

/// Covariances and how they scatter.
#[derive(Debug, Clone)]
pub struct Covariances {
    /// Number of responses.
    pub channels: usize,
    /// Channels that serve as reference.
    pub references: Vec<usize>,
    /// Highest lag, samples.
    pub lags: usize,
    /// Samples they were taken over.
    pub samples: usize,
    /// `R_τ(c, r)` at `(τ·references + r)·channels + c`.
    pub mean: Vec<f64>,
    /// What each block, in order of time, adds to the mean's deviation: `n_k/N (R_k − R)`; their sum is zero.
    pub deviations: Vec<Vec<f64>>,
}

impl Covariances {
    /// `R_τ(c, r)`, `r` counting references.
    pub fn at(&self, lag: usize, channel: usize, reference: usize) -> f64 {
        self.mean[(lag * self.references.len() + reference) * self.channels + channel]
    }
}

impl Gathering {
    /// Nothing yet, for lags 0 to `lags`.
    ///
    /// # Errors
    /// `NoChannel` for a reference that is not among the channels, or none.
    pub fn new(channels: usize, references: &[usize], lags: usize) -> Result<Gathering, Error> {
        check_references(references, channels)?;
        let segment = 2 * lags.max(32);
        let transform = RealFft::new(quick_length(segment + lags));
        let lines = vec![Complex::new(0.0, 0.0); transform.lines()];
        let mut gathering = Gathering {
            channels,
            references: references.to_vec(),
            lags,
            segment,
            offset: Vec::new(),
            waiting: vec![Vec::new(); channels],
            padded: vec![0.0; transform.samples()],
            leading: vec![lines.clone(); references.len()],
            trailing: vec![lines.clone(); channels],
            product: lines,
            transform,
            block_segments: 1,
            open: Block {
                samples: 0,
                products: Vec::new(),
                sums: Vec::new(),
            },
            open_segments: 0,
            closed: Vec::new(),
        };
        gathering.open = gathering.empty_block();
        Ok(gathering)
    }

    /// Takes the next stretch of samples, by channel, of equal lengths; they must be finite.
    ///
    /// # Errors
    /// `OutOfRange` for another number of channels, or lengths that differ.
    pub fn push(&mut self, stretch: &[&[f64]]) -> Result<(), Error> {
        let length = stretch.first().map_or(0, |s| s.len());
        if stretch.len() != self.channels || stretch.iter().any(|s| s.len() != length) {
            let lengths: Vec<usize> = stretch.iter().map(|s| s.len()).collect();
            return Err(Error::new(
                Code::OutOfRange,
                format!(
                    "a stretch of {lengths:?} samples for {} channels",
                    self.channels
                ),
            )
            .hint("give every channel the same number of samples"));
        }
        if self.offset.is_empty() && length > 0 {
            let mean = |s: &&[f64]| s.iter().sum::<f64>() / length as f64;
            self.offset = stretch.iter().map(mean).collect();
        }
        // Long stretches pass through in pieces, so that waiting samples stay few.
        for from in (0..length).step_by(self.segment) {
            let to = (from + self.segment).min(length);
            for (c, samples) in stretch.iter().enumerate() {
                let offset = self.offset[c];
                self.waiting[c].extend(samples[from..to].iter().map(|x| x - offset));
            }
            while self.waiting.first().map_or(0, Vec::len) >= self.segment + self.lags {
                self.take(self.segment);
            }
        }
        Ok(())
    }

    /// The covariances.
    ///
    /// # Errors
    /// `TooShort` where the samples do not exceed the lags.
    pub fn finish(mut self) -> Result<Covariances, Error> {
        let left = self.waiting.first().map_or(0, Vec::len);
        if left > self.lags {
            self.take((left - self.lags).min(self.segment));
        }
        if self.open.samples > 0 {
            // A block of fewer segments than the others still counts by its samples.
            self.close();
        }
        let samples: usize = self.closed.iter().map(|b| b.samples).sum();
        if samples == 0 {
            return Err(Error::new(
                Code::TooShort,
                format!("{left} samples for covariances over {} lags", self.lags),
            )
            .hint("take a longer record"));
        }
        let n = samples as f64;
        let total = |read: fn(&Block) -> &[f64]| -> Vec<f64> {
            let mut sum = vec![0.0; self.closed.first().map_or(0, |b| read(b).len())];
            for block in &self.closed {
                (sum.iter_mut().zip(read(block))).for_each(|(s, x)| *s += x / n);
            }
            sum
        };
        let level = total(|b| &b.sums);
        // Σ (y − m)(x − m′) from the sums; the ends that differ by τ samples are left out of account.
        let central = |block: &Block| -> Vec<f64> {
            let (nr, nc) = (self.references.len(), self.channels);
            let mut products = block.products.clone();
            for (at, p) in products.iter_mut().enumerate() {
                let (c, r) = (at % nc, self.references[at / nc % nr]);
                let count = block.samples as f64;
                *p += level[c] * level[r] * count
                    - level[c] * block.sums[r]
                    - level[r] * block.sums[c];
            }
            products
        };
        let central: Vec<Vec<f64>> = self.closed.iter().map(central).collect();
        let mut mean = vec![0.0; central.first().map_or(0, Vec::len)];
        for block in &central {
            (mean.iter_mut().zip(block)).for_each(|(m, x)| *m += x / n);
        }
        let deviations = (self.closed.iter().zip(central))
            .map(|(block, products)| {
                let count = block.samples as f64;
                (products.iter().zip(&mean))
                    .map(|(p, m)| (p - count * m) / n)
                    .collect()
            })
            .collect();
        Ok(Covariances {
            channels: self.channels,
            references: self.references,
            lags: self.lags,
            samples,
            mean,
            deviations,
        })
    }

    fn empty_block(&self) -> Block {
        Block {
            samples: 0,
            products: vec![0.0; (self.lags + 1) * self.references.len() * self.channels],
            sums: vec![0.0; self.channels],
        }
    }

    /// Adds the products of the first `base` waiting samples with all that follow them by up to the highest lag.
    fn take(&mut self, base: usize) {
        let reach = base + self.lags;
        for c in 0..self.channels {
            self.padded.fill(0.0);
            self.padded[..reach].copy_from_slice(&self.waiting[c][..reach]);
            self.transform
                .forward(&mut self.padded, &mut self.trailing[c]);
        }
        for (k, &r) in self.references.iter().enumerate() {
            self.padded.fill(0.0);
            self.padded[..base].copy_from_slice(&self.waiting[r][..base]);
            self.transform
                .forward(&mut self.padded, &mut self.leading[k]);
        }
        let (nr, nc) = (self.references.len(), self.channels);
        for (r, c) in (0..nr).flat_map(|r| (0..nc).map(move |c| (r, c))) {
            let pairs = self.trailing[c].iter().zip(&self.leading[r]);
            (self.product.iter_mut().zip(pairs)).for_each(|(p, (y, x))| *p = y * x.conj());
            self.transform.inverse(&mut self.product, &mut self.padded);
            for lag in 0..=self.lags {
                self.open.products[(lag * nr + r) * nc + c] += self.padded[lag];
            }
        }
        for c in 0..nc {
            self.open.sums[c] += self.waiting[c][..base].iter().sum::<f64>();
            self.waiting[c].drain(..base);
        }
        self.open.samples += base;
        self.open_segments += 1;
        if self.open_segments == self.block_segments {
            self.close();
        }
    }

    fn close(&mut self) {
        let empty = self.empty_block();
        self.closed.push(std::mem::replace(&mut self.open, empty));
        self.open_segments = 0;
        if self.closed.len() == 2 * BLOCKS {
            let mut merged: Vec<Block> = Vec::with_capacity(2 * BLOCKS);
            for (at, block) in std::mem::take(&mut self.closed).into_iter().enumerate() {
                match merged.last_mut() {
                    Some(last) if at % 2 == 1 => last.add(&block),
                    _ => merged.push(block),
                }
            }
            self.closed = merged;
            self.block_segments *= 2;
        }
    }
}

impl Block {
    fn add(&mut self, other: &Block) {
        self.samples += other.samples;
        (self.products.iter_mut().zip(&other.products)).for_each(|(a, b)| *a += b);
        (self.sums.iter_mut().zip(&other.sums)).for_each(|(a, b)| *a += b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the sums as written, pushed in stretches of odd lengths, with an offset.
    #[test]
    fn exact_sums_in_stretches() {
        let mut rng = fastrand::Rng::with_seed(1);
        let y: Vec<Vec<f64>> = (0..2)
            .map(|_| (0..5000).map(|_| rng.f64() + 3.0).collect())
            .collect();
        let mut gathering = Gathering::new(2, &[1], 20).unwrap();
        let mut from = 0;
        for length in [7, 1, 900, 0, 3000, 1092] {
            let stretch: Vec<&[f64]> = y.iter().map(|c| &c[from..from + length]).collect();
            gathering.push(&stretch).unwrap();
            from += length;
        }
        let found = gathering.finish().unwrap();
        assert_eq!(found.samples, 5000 - 20);
        let mean = |c: usize| y[c][..4980].iter().sum::<f64>() / 4980.0;
        let m = [mean(0), mean(1)];
        for (lag, c) in (0..=20).flat_map(|lag| (0..2).map(move |c| (lag, c))) {
            let sum: f64 = (0..4980)
                .map(|t| (y[c][t + lag] - m[c]) * (y[1][t] - m[1]))
                .sum();
            // the ends left out of account weigh like 20 of 5000 samples times the mean's own scatter
            assert!(
                (found.at(lag, c, 0) - sum / 4980.0).abs() < 2e-5,
                "lag {lag}"
            );
        }
        assert!(found.deviations.len() >= BLOCKS);
        let total: f64 = found.deviations.iter().map(|d| d[5]).sum();
        assert!(total.abs() < 1e-14);
    }

    #[test]
    fn refuses_references_that_are_not_there() {
        assert!(Gathering::new(2, &[2], 5).is_err());
        assert!(Gathering::new(2, &[], 5).is_err());
        assert!(Gathering::new(2, &[0], 5).unwrap().finish().is_err());
    }
}
