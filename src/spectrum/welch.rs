//! Welch's method on a stream, in bounded memory: `S = 2/(f_s Σw²) · mean |X|²`.
//!
//! Welch, The use of fast Fourier transform for the estimation of power spectra, IEEE Trans. Audio Electroacoust. 15 (1967),
//! pp. 70–73. The random error counts the correlation of overlapping blocks exactly: an average `Σ a_i P_i` over blocks of white
//! noise has the relative variance `Σ_i Σ_j a_i a_j ρ(i − j)`, ρ by the window's overlap, 0 across gaps; its inverse is the number of
//! independent averages. The sum is updated block by block.
//!
//! Each channel is transformed separately: packing two real channels into one complex transform is no faster once they are
//! separated, and adds the rounding of a large channel to a small one.

use std::collections::VecDeque;

use super::spectra::{CrossSpectrum, Spectra};
use super::window::{Window, overlap_correlation, window_gains};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::fft::RealFft;
use crate::numeric::{Complex, parallel, vector_ops};

/// Trend removed from each block before the window.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Detrend {
    /// No trend.
    None,
    /// Mean of the block.
    #[default]
    Mean,
    /// Least-squares straight line.
    Linear,
}

/// Averaging of blocks into one spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Averaging {
    /// Equal weight of all blocks.
    #[default]
    Linear,
    /// Exponential weights that fall to 1/e over this many blocks; at least 1.
    Exponential(f64),
    /// Maximum of each line; auto spectra only.
    PeakHold,
}

/// Options for cutting, windowing and averaging blocks.
#[derive(Debug, Clone, PartialEq)]
pub struct WelchOptions {
    /// Block length, samples; the line spacing is `rate/block`.
    pub block: usize,
    /// Overlap of consecutive blocks relative to their length, 0 to below 1.
    pub overlap: f64,
    /// Window applied to each block.
    pub window: Window,
    /// Trend removed from each block.
    pub detrend: Detrend,
    /// Averaging over the blocks.
    pub averaging: Averaging,
}

impl Default for WelchOptions {
    /// 4096 samples, Hann window, 50 % overlap, mean removed, linear averaging.
    fn default() -> WelchOptions {
        WelchOptions {
            block: 4096,
            overlap: 0.5,
            window: Window::Hann,
            detrend: Detrend::Mean,
            averaging: Averaging::Linear,
        }
    }
}

/// Averages spectra of channels that arrive in chunks.
pub struct WelchEstimator {
    rate_hz: f64,
    options: WelchOptions,
    hop: usize,
    window: Vec<f64>,
    channels: Vec<ChannelAverage>,
    cross: Vec<CrossSpectrum>,
    weights: AverageWeights,
}

/// Minimum chunk length for which several threads are faster, samples.
const MIN_PARALLEL_SAMPLES: usize = 1 << 14;

/// Auto spectrum of one channel.
struct ChannelAverage {
    fft: RealFft,
    /// Samples still needed by later blocks.
    pending: Vec<f64>,
    work: Vec<f64>,
    /// Transform of the last block.
    transform: Vec<Complex>,
    psd: Vec<f64>,
}

impl WelchEstimator {
    /// Creates an empty average of the auto spectra of `channels` channels and the cross spectra of `pairs`; `rate_hz` is in Hz.
    ///
    /// # Errors
    /// `OutOfRange`: a block below 4 samples, an overlap outside 0 … 1, a rate that is not positive, an averaging constant below 1, an
    /// invalid window parameter. `Conflict`: cross spectra with peak hold.
    pub fn new(
        rate_hz: f64,
        channels: usize,
        pairs: &[(usize, usize)],
        options: &WelchOptions,
    ) -> Result<WelchEstimator, Error> {
        check(rate_hz, pairs, options)?;
        let n = options.block;
        let hop = (n as f64 * (1.0 - options.overlap)).round().max(1.0) as usize;
        let window = options.window.samples(n);
        let fft = RealFft::new(n);
        let lines = fft.lines();
        let zero = Complex::new(0.0, 0.0);
        let empty = |&pair: &(usize, usize)| CrossSpectrum {
            pair,
            values: vec![zero; lines],
        };
        let average = || ChannelAverage {
            fft: fft.clone(),
            pending: Vec::with_capacity(n),
            work: vec![0.0; n],
            transform: vec![zero; lines],
            psd: vec![0.0; lines],
        };
        Ok(WelchEstimator {
            rate_hz,
            hop,
            weights: AverageWeights::new(&window, hop, options.averaging),
            window,
            channels: (0..channels).map(|_| average()).collect(),
            cross: pairs.iter().map(empty).collect(),
            options: options.clone(),
        })
    }

    /// Takes the next samples of every channel, any number of them.
    ///
    /// # Panics
    /// If the number of channels is not that of the constructor, or channels differ in length.
    pub fn push(&mut self, channels: &[&[f64]]) {
        assert_eq!(channels.len(), self.channels.len());
        let samples = channels.first().map_or(0, |c| c.len());
        assert!(channels.iter().all(|c| c.len() == samples));
        let mut from = 0;
        while from < samples {
            let pending = self.channels[0].pending.len();
            // Cross spectra need the transforms of all channels at each block.
            let take = match self.cross.is_empty() {
                true => samples - from,
                false => (self.options.block - pending).min(samples - from),
            };
            let blocks = match (pending + take).checked_sub(self.options.block) {
                None => 0,
                Some(excess) => 1 + excess / self.hop,
            };
            let weights: Vec<f64> = (0..blocks).map(|_| self.weights.block()).collect();
            let chunks = channels.iter().map(|channel| &channel[from..from + take]);
            let mut work: Vec<_> = self.channels.iter_mut().zip(chunks).collect();
            let (options, hop, window) = (&self.options, self.hop, &self.window[..]);
            let push = |(channel, chunk): &mut (&mut ChannelAverage, &[f64])| {
                channel.push(chunk, &weights, options, (hop, window));
            };
            match take < MIN_PARALLEL_SAMPLES {
                true => work.iter_mut().for_each(push),
                false => parallel::for_each(&mut work, push),
            }
            if let [weight] = weights[..] {
                self.average_cross(weight);
            }
            from += take;
        }
    }

    /// Adds the last block to the cross spectra with a weight.
    fn average_cross(&mut self, weight: f64) {
        for CrossSpectrum {
            pair,
            values: value,
        } in &mut self.cross
        {
            let [x, y] = [pair.0, pair.1].map(|c| &self.channels[c].transform);
            for ((s, x), y) in value.iter_mut().zip(x).zip(y) {
                *s += (x.conj() * y - *s) * weight;
            }
        }
    }

    /// Ends a segment at a gap: pending samples are dropped, and no block spans the gap.
    pub fn end_segment(&mut self) {
        self.channels.iter_mut().for_each(|c| c.pending.clear());
        self.weights.end_segment();
    }

    /// Number of blocks averaged so far.
    pub fn blocks(&self) -> usize {
        self.weights.blocks
    }

    /// Scales the averages to spectral densities.
    ///
    /// # Errors
    /// `TooShort` if no block was filled; `Overflow` if a sample was not a number or too large to be squared.
    pub fn finish(mut self) -> Result<Spectra, Error> {
        let n = self.options.block;
        if self.weights.blocks == 0 {
            return Err(Error::new(
                Code::TooShort,
                format!("no segment of the record fills one block of {n} samples"),
            )
            .with_hint("choose a shorter block"));
        }
        let gain = window_gains(&self.window);
        let full = 2.0 / (self.rate_hz * gain.energy * n as f64);
        let is_edge = |line: usize| line == 0 || 2 * line == n;
        let scale = |line: usize| if is_edge(line) { 0.5 * full } else { full };
        let mut psd: Vec<Vec<f64>> = self.channels.into_iter().map(|c| c.psd).collect();
        for psd in &mut psd {
            psd.iter_mut().enumerate().for_each(|(k, s)| *s *= scale(k));
        }
        for cross in &mut self.cross {
            let lines = cross.values.iter_mut().enumerate();
            lines.for_each(|(k, s)| *s *= scale(k));
        }
        if let Some(channel) = psd
            .iter()
            .position(|psd| psd.iter().any(|s| !s.is_finite()))
        {
            return Err(Error::new(
                Code::Overflow,
                format!(
                    "channel {} of {} holds a sample that is not a number, or too large to be squared",
                    channel + 1,
                    psd.len()
                ),
            ));
        }
        let df = self.rate_hz / n as f64;
        let line_hz = |k: usize| {
            if 2 * k == n {
                0.5 * self.rate_hz
            } else {
                k as f64 * df
            }
        };
        Ok(Spectra {
            rate_hz: self.rate_hz,
            frequency_hz: (0..=n / 2).map(line_hz).collect(),
            psd,
            cross: self.cross,
            bandwidth_hz: gain.bandwidth_lines * df,
            blocks: self.weights.blocks,
            averages: match self.options.averaging {
                Averaging::PeakHold => None,
                _ => Some(self.weights.averages()),
            },
            window_decay: self.options.window.decay_rate(n as f64 / self.rate_hz),
            window: Some(self.options.window),
        })
    }
}

impl ChannelAverage {
    /// Takes samples and averages each completed block with its weight.
    fn push(
        &mut self,
        samples: &[f64],
        weights: &[f64],
        options: &WelchOptions,
        (hop, window): (usize, &[f64]),
    ) {
        let (mut remaining, mut weights) = (samples, weights.iter());
        while !remaining.is_empty() {
            let take = (options.block - self.pending.len()).min(remaining.len());
            self.pending.extend_from_slice(&remaining[..take]);
            remaining = &remaining[take..];
            if self.pending.len() < options.block {
                return;
            }
            load_block(&mut self.work, &self.pending, window, options.detrend);
            self.fft.forward(&mut self.work, &mut self.transform);
            let overlap = self.pending.len() - hop;
            self.pending.copy_within(hop.., 0);
            self.pending.truncate(overlap);
            let weight = weights.next().copied().unwrap_or_default();
            self.average(weight, options.averaging);
        }
    }

    /// Adds the last transform to the auto spectrum with a weight.
    fn average(&mut self, weight: f64, averaging: Averaging) {
        let lines = self.psd.iter_mut().zip(&self.transform);
        if averaging == Averaging::PeakHold {
            lines.for_each(|(s, x)| {
                let power = x.norm_sqr();
                if power > *s || power.is_nan() {
                    *s = power;
                }
            });
        } else {
            lines.for_each(|(s, x)| *s += weight * (x.norm_sqr() - *s));
        }
    }
}

fn check(rate_hz: f64, pairs: &[(usize, usize)], options: &WelchOptions) -> Result<(), Error> {
    let refuse = |message: String| Err(Error::new(Code::OutOfRange, message));
    if !(rate_hz > 0.0 && rate_hz.is_finite()) {
        return refuse(format!("invalid sample rate {rate_hz} Hz"));
    }
    if options.block < 4 {
        return refuse(format!(
            "a block of {} samples has no spectrum; 4 or more",
            options.block
        ));
    }
    if !(0.0..1.0).contains(&options.overlap) {
        return refuse(format!(
            "an overlap of {} blocks is out of range (0 to below 1)",
            options.overlap
        ));
    }
    match options.averaging {
        Averaging::Exponential(constant) if constant.is_nan() || constant < 1.0 => {
            return refuse(format!(
                "exponential averaging over {constant} blocks is out of range (minimum 1)"
            ));
        }
        Averaging::PeakHold if !pairs.is_empty() => {
            return Err(Error::new(
                Code::Conflict,
                "peak hold applies to auto spectra only, not to cross spectra",
            ));
        }
        _ => {}
    }
    options.window.check()
}

/// Writes the block to `work`, detrended and windowed.
fn load_block(work: &mut [f64], block: &[f64], window: &[f64], detrend: Detrend) {
    let n = block.len() as f64;
    let middle = 0.5 * (n - 1.0);
    let mean = match detrend {
        Detrend::None => 0.0,
        _ => vector_ops::sum(block) / n,
    };
    let slope = match detrend {
        Detrend::Linear => {
            let moment = |(j, x): (usize, &f64)| (j as f64 - middle) * (x - mean);
            block.iter().enumerate().map(moment).sum::<f64>() * 12.0 / (n * (n * n - 1.0))
        }
        _ => 0.0,
    };
    let samples = work.iter_mut().zip(block).zip(window);
    if slope == 0.0 {
        samples.for_each(|((z, x), w)| *z = w * (x - mean));
    } else {
        for (j, ((z, x), w)) in samples.enumerate() {
            *z = w * (x - mean - slope * (j as f64 - middle));
        }
    }
}

/// Weights of blocks, and variance of their weighted mean.
struct AverageWeights {
    averaging: Averaging,
    blocks: usize,
    /// Correlations `ρ(1), ρ(2), …` of overlapping blocks.
    correlation: Vec<f64>,
    /// Weights of the blocks of this segment that overlap with the next one, the latest first.
    recent: VecDeque<f64>,
    /// Variance `Σ_i Σ_j a_i a_j ρ(i − j)`.
    variance: f64,
}

impl AverageWeights {
    fn new(window: &[f64], hop: usize, averaging: Averaging) -> AverageWeights {
        let lags = (1..).map(|j| j * hop).take_while(|&lag| lag < window.len());
        let correlation: Vec<f64> = lags.map(|lag| overlap_correlation(window, lag)).collect();
        AverageWeights {
            averaging,
            blocks: 0,
            recent: VecDeque::with_capacity(correlation.len() + 1),
            correlation,
            variance: 0.0,
        }
    }

    /// Weight of the next block in the average.
    fn block(&mut self) -> f64 {
        self.blocks += 1;
        let equal = 1.0 / self.blocks as f64;
        let a = match self.averaging {
            Averaging::Exponential(constant) => equal.max(-(-1.0 / constant).exp_m1()),
            _ => equal,
        };
        let pairs = self.recent.iter_mut().zip(&self.correlation);
        let covariance: f64 = pairs
            .map(|(weight, rho)| {
                *weight *= 1.0 - a;
                *weight * rho
            })
            .sum();
        self.variance = (1.0 - a).powi(2) * self.variance + a * a + 2.0 * a * covariance;
        self.recent.push_front(a);
        self.recent.truncate(self.correlation.len());
        a
    }

    fn end_segment(&mut self) {
        self.recent.clear();
    }

    fn averages(&self) -> f64 {
        1.0 / self.variance
    }
}
