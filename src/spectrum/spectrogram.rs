//! Short-time Fourier transform and spectrogram of streamed samples, in the memory of one block.
//!
//! One-sided power spectral density `2 |X|²/(f_s Σw²)` (factor 1 at zero and at half the rate), P. D. Welch, IEEE Trans. Audio
//! Electroacoust. 15 (1967), 70–73, with Hann's window.

use super::validation::{check_count, check_positive, mean};
use super::window::Window;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::RealFft;

/// Streaming short-time Fourier transform with Hann's window.
pub struct ShortTimeFft {
    fft: RealFft,
    weights: Vec<f64>,
    step: usize,
    remove_mean: bool,
    pending: Vec<f64>,
    /// Number of samples to skip before the next block.
    skip: usize,
    start: usize,
    block: Vec<f64>,
    lines: Vec<Complex>,
}

impl ShortTimeFft {
    /// Transform of blocks of `block ≥ 2` samples, with starts `step ≥ 1` samples apart.
    ///
    /// # Errors
    /// A block or a step that is too small.
    pub fn new(block: usize, step: usize) -> Result<ShortTimeFft, Error> {
        check_count(block, 2, "the number of samples in a block")?;
        check_count(step, 1, "the number of samples between blocks")?;
        let fft = RealFft::new(block);
        Ok(ShortTimeFft {
            weights: Window::Hann.samples(block),
            step,
            remove_mean: false,
            pending: Vec::with_capacity(block),
            skip: 0,
            start: 0,
            block: vec![0.0; block],
            lines: vec![Complex::new(0.0, 0.0); fft.lines()],
            fft,
        })
    }

    /// Adds samples; passes to `sink` the index of the first sample and the `block/2 + 1` lines `X/Σw` of every completed block. A
    /// tone `a cos(2πf_k t + φ)` inside the band gives `a/2 e^{iφ}`, with the phase at the first sample of the block.
    pub fn push(&mut self, mut samples: &[f64], sink: &mut impl FnMut(usize, &[Complex])) {
        let n = self.weights.len();
        while !samples.is_empty() {
            let n_skipped = self.skip.min(samples.len());
            self.skip -= n_skipped;
            samples = &samples[n_skipped..];
            let n_added = (n - self.pending.len()).min(samples.len());
            self.pending.extend_from_slice(&samples[..n_added]);
            samples = &samples[n_added..];
            if self.pending.len() == n {
                self.transform();
                sink(self.start, &self.lines);
                self.start += self.step;
                self.pending.drain(..self.step.min(n));
                self.skip = self.step.saturating_sub(n);
            }
        }
    }

    fn transform(&mut self) {
        let mean = if self.remove_mean {
            mean(&self.pending)
        } else {
            0.0
        };
        let weighted = self
            .pending
            .iter()
            .zip(&self.weights)
            .map(|(x, w)| (x - mean) * w);
        self.block
            .iter_mut()
            .zip(weighted)
            .for_each(|(b, x)| *b = x);
        self.fft.forward(&mut self.block, &mut self.lines);
        let scale = 1.0 / self.weights.iter().sum::<f64>();
        self.lines.iter_mut().for_each(|z| *z *= scale);
    }
}

/// Block lengths of a spectrogram.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpectrogramOptions {
    /// Block length, samples: the line spacing is `rate/block`.
    pub block: usize,
    /// Samples from one block to the next; with Hann's window, half a block (50 % overlap) uses nearly all information.
    pub step: usize,
    /// Number of blocks averaged into one row.
    pub averages: usize,
}

/// Streaming spectrogram: mean of each block removed, power spectral densities averaged over the blocks of a row.
pub struct Spectrogram {
    transform: ShortTimeFft,
    rate_hz: f64,
    settings: SpectrogramOptions,
    sum: Vec<f64>,
    blocks: usize,
}

/// Spectral density of one time interval.
#[derive(Debug, Clone, PartialEq)]
pub struct SpectrogramRow {
    /// Middle of the interval, s from the first sample.
    pub time_s: f64,
    /// One-sided power spectral density by line, unit²/Hz.
    pub density: Vec<f64>,
}

impl Spectrogram {
    /// # Errors
    /// A rate that is not positive, a block of fewer than two samples, a step or a number of averages of zero.
    pub fn new(rate_hz: f64, settings: SpectrogramOptions) -> Result<Spectrogram, Error> {
        check_positive(rate_hz, "the sample rate, Hz,")?;
        check_count(settings.averages, 1, "the number of blocks in a row")?;
        let mut transform = ShortTimeFft::new(settings.block, settings.step)?;
        transform.remove_mean = true;
        Ok(Spectrogram {
            sum: vec![0.0; transform.lines.len()],
            transform,
            rate_hz,
            settings,
            blocks: 0,
        })
    }

    /// Frequencies of the lines, Hz.
    pub fn frequency_hz(&self) -> Vec<f64> {
        let step = self.rate_hz / self.settings.block as f64;
        (0..self.sum.len()).map(|k| k as f64 * step).collect()
    }

    /// Adds samples and passes every completed row to `sink`.
    pub fn push(&mut self, samples: &[f64], mut sink: impl FnMut(SpectrogramRow)) {
        let SpectrogramOptions {
            block,
            step,
            averages,
        } = self.settings;
        let weights = &self.transform.weights;
        let (sum_w, sum_w2) = weights
            .iter()
            .fold((0.0, 0.0), |(s, q), w| (s + w, q + w * w));
        let scale = 2.0 * sum_w * sum_w / (self.rate_hz * sum_w2 * averages as f64);
        let (sum, blocks, rate) = (&mut self.sum, &mut self.blocks, self.rate_hz);
        self.transform.push(samples, &mut |start, lines| {
            sum.iter_mut()
                .zip(lines)
                .for_each(|(s, z)| *s += z.norm_sqr());
            *blocks += 1;
            if *blocks < averages {
                return;
            }
            let mut density: Vec<f64> = sum.iter().map(|s| s * scale).collect();
            density[0] *= 0.5;
            if block.is_multiple_of(2) {
                density[block / 2] *= 0.5;
            }
            let middle =
                start as f64 - (averages - 1) as f64 * step as f64 / 2.0 + block as f64 / 2.0;
            sink(SpectrogramRow {
                time_s: middle / rate,
                density,
            });
            sum.fill(0.0);
            *blocks = 0;
        });
    }
}

/// Spectrogram of a slice of samples.
///
/// # Errors
/// Those of [`Spectrogram::new`]; a slice shorter than the first row.
pub fn spectrogram(
    samples: &[f64],
    rate_hz: f64,
    settings: SpectrogramOptions,
) -> Result<Vec<SpectrogramRow>, Error> {
    let mut rows = Vec::new();
    Spectrogram::new(rate_hz, settings)?.push(samples, |row| rows.push(row));
    if rows.is_empty() {
        return Err(Error::new(
            Code::TooShort,
            format!(
                "{} samples are too few for one row of {} blocks of {}",
                samples.len(),
                settings.averages,
                settings.block
            ),
        )
        .with_hint("use shorter blocks, or fewer per row"));
    }
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A tone on a line has its amplitude, its phase at the start of each block, and power a²/2 in the density.
    #[test]
    fn exact_tone() {
        let (rate, n, f, a, phase) = (1024.0, 128, 64.0, 3.0, 0.7);
        let x: Vec<f64> = (0..1000)
            .map(|j| a * (TAU * f * j as f64 / rate + phase).cos())
            .collect();
        let mut blocks = 0;
        ShortTimeFft::new(n, 200)
            .unwrap()
            .push(&x, &mut |start, lines| {
                let expected = Complex::from_polar(a / 2.0, TAU * f * start as f64 / rate + phase);
                assert!((lines[8] - expected).norm() < 1e-12);
                blocks += 1;
            });
        assert_eq!(blocks, 5);
        let settings = SpectrogramOptions {
            block: n,
            step: 64,
            averages: 3,
        };
        let rows = spectrogram(&x, rate, settings).unwrap();
        assert_eq!(rows.len(), 4);
        for (at, row) in rows.iter().enumerate() {
            let power: f64 = row.density.iter().sum::<f64>() * rate / n as f64;
            assert!((power - a * a / 2.0).abs() < 1e-12);
            assert!((row.time_s - (128.0 + 192.0 * at as f64) / rate).abs() < 1e-15);
        }
    }

    /// Rows do not depend on the division of the samples into chunks.
    #[test]
    fn law_blocks_join_exactly() {
        let mut rng = fastrand::Rng::with_seed(9);
        let x: Vec<f64> = (0..3000).map(|_| rng.f64()).collect();
        for step in [1, 17, 64, 150] {
            let settings = SpectrogramOptions {
                block: 64,
                step,
                averages: 2,
            };
            let expected = spectrogram(&x, 10.0, settings).unwrap();
            let mut rows = Vec::new();
            let mut stream = Spectrogram::new(10.0, settings).unwrap();
            x.chunks(29)
                .for_each(|chunk| stream.push(chunk, |row| rows.push(row)));
            assert_eq!(expected, rows);
        }
    }

    #[test]
    fn refuses_nonsense() {
        assert!(ShortTimeFft::new(1, 1).is_err() && ShortTimeFft::new(8, 0).is_err());
        let settings = SpectrogramOptions {
            block: 64,
            step: 32,
            averages: 1,
        };
        assert_eq!(
            spectrogram(&[0.0; 63], 1.0, settings).unwrap_err().code,
            Code::TooShort
        );
        assert!(Spectrogram::new(f64::INFINITY, settings).is_err());
    }
}
