//! Spectral matrices of outputs by Welch's method, zero-padded to twice the block length.

use super::response_channels::ResponseChannels;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::fft::{RealFft, next_fast_len};
use crate::numeric::{Complex, ComplexMatrix};

/// One-sided spectral densities between all channels, by line.
#[derive(Debug, Clone)]
pub struct SpectralMatrix {
    /// Distance of the lines, Hz; half of what the segments resolve.
    pub line_spacing_hz: f64,
    /// Samples of a segment.
    pub block: usize,
    /// Segments averaged; half overlapping, so that about 1.9 of them count as independent for each two.
    pub averages: usize,
    /// Autocovariance of the window over lags, 1 at lag 0: the covariances behind the spectra are multiplied by it.
    pub window_lags: Vec<f64>,
    /// `E y yᴴ` of each line, product of units per Hz.
    pub lines: Vec<ComplexMatrix>,
}

/// Samples of a segment unless stated, at most: more lines take more time than they tell, and a lower rate shows low modes better.
const MAX_SEGMENT_LEN: usize = 1 << 16;

/// Entries of all lines' matrices together unless stated, at most: 256 MB.
const MAX_ENTRIES: usize = 1 << 24;

/// Segments that the default leaves in a record, at least; up to twice as many, for lengths are powers of two.
const MIN_BLOCKS: usize = 10;

impl SpectralMatrix {
    /// With a Hann window over `block` samples; `None` takes the power of two below a tenth of the record, 65 536 at
    /// most.
    ///
    /// # Errors
    /// `TooShort` where fewer than two segments fit.
    pub fn new(
        channels: &ResponseChannels,
        segment: Option<usize>,
    ) -> Result<SpectralMatrix, Error> {
        let n = channels.n_samples();
        let segment = segment
            .unwrap_or_else(|| {
                let entries = channels.samples().len().pow(2);
                let longest = MAX_SEGMENT_LEN.min((MAX_ENTRIES / entries).max(256));
                1 << (n / MIN_BLOCKS).clamp(16, longest).ilog2()
            })
            .max(4);
        let hop = segment / 2;
        if n < segment + hop {
            return Err(Error::new(
                Code::TooShort,
                format!("{n} samples are too few for segments of {segment}"),
            )
            .with_hint(format!(
                "take at least {} samples, or shorter segments",
                segment + hop
            )));
        }
        let window: Vec<f64> = (0..segment)
            .map(|t| {
                (std::f64::consts::PI * t as f64 / segment as f64)
                    .sin()
                    .powi(2)
            })
            .collect();
        let power: f64 = window.iter().map(|w| w * w).sum();
        let nc = channels.samples().len();
        let mut transform = RealFft::new(next_fast_len(2 * segment));
        let zero = Complex::new(0.0, 0.0);
        let mut spectra = vec![vec![zero; transform.lines()]; nc];
        let mut padded = vec![0.0; transform.samples()];
        let mut lines = vec![ComplexMatrix::zeros(nc, nc); transform.lines()];
        let means: Vec<f64> = (channels.samples().iter())
            .map(|s| s.iter().sum::<f64>() / n as f64)
            .collect();
        let averages = (n - segment) / hop + 1;
        // One-sided: what stands at negative frequencies is added to the positive ones.
        let scale = 2.0 / (channels.rate_hz() * power * averages as f64);
        for k in 0..averages {
            for (c, samples) in channels.samples().iter().enumerate() {
                padded.fill(0.0);
                let stretch = &samples[k * hop..k * hop + segment];
                for (t, (x, w)) in stretch.iter().zip(&window).enumerate() {
                    padded[t] = (x - means[c]) * w;
                }
                transform.forward(&mut padded, &mut spectra[c]);
            }
            for (at, line) in lines.iter_mut().enumerate() {
                for (i, j) in (0..nc).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                    line[(i, j)] += spectra[i][at] * spectra[j][at].conj() * scale;
                }
            }
        }
        for line in &mut lines {
            for (i, j) in (0..nc).flat_map(|i| (0..i).map(move |j| (i, j))) {
                line[(j, i)] = line[(i, j)].conj();
            }
        }
        let window_lags = (0..segment)
            .map(|lag| {
                window
                    .iter()
                    .zip(&window[lag..])
                    .map(|(a, b)| a * b)
                    .sum::<f64>()
                    / power
            })
            .collect();
        Ok(SpectralMatrix {
            line_spacing_hz: channels.rate_hz() / transform.samples() as f64,
            block: segment,
            averages,
            window_lags,
            lines,
        })
    }
}
