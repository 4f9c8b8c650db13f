//! Discrete/random separation (Antoni & Randall): prediction of a signal from its delayed past.
//!
//! J. Antoni, R. B. Randall, Unsupervised noise cancellation for vibration signals: part II – a novel frequency-domain algorithm,
//! Mech. Syst. Signal Process. 18 (2004), 103–117. Tones (gear meshes, shafts) are predictable over any delay; noise and bearing
//! faults, with random roller slip, are not predictable beyond their correlation length. Tones must be steady: use a signal over angle.
//!
//! Differences from the source: `H` is zero on lines below the coherence that noise alone exceeds with probability 0.001 (otherwise
//! noise leaks with few blocks); its impulse response is tapered by Hann's window, which smooths `H` over neighbouring lines and so
//! passes tones between two lines; and the signal is also predicted backward from the future, and the mean is used if both exist.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::{RealFft, next_fast_len};
use crate::spectrum::validation::{check_count, check_samples};
use crate::spectrum::window::Window;

/// Probability that noise alone is taken for a tone on a line.
const FALSE_ALARM: f64 = 1e-3;

/// Minimum number of blocks for the coherence test.
const MIN_BLOCKS: usize = 8;

/// Independent blocks per block, Hann's window and 50 % overlap: 1/(1 + 2/36), Welch, IEEE Trans. Audio Electroacoust. 15 (1967), 70–73.
const INDEPENDENT_BLOCK_SHARE: f64 = 36.0 / 38.0;

/// Options of the separation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeparationOptions {
    /// Block length, samples, even: components are separated from a tone at a distance of `2/block` of the rate or more. A tone of
    /// amplitude `a` in white noise of variance `σ²` loses the part `1/(1 + block a²/(6σ²))`.
    pub block: usize,
    /// Samples between a block and the block predicted from it: at least the correlation length of the random part.
    pub gap: usize,
}

/// Deterministic and random part of a signal; their sum is the signal.
#[derive(Debug, Clone)]
pub struct Separation {
    /// Periodic part.
    pub deterministic: Vec<f64>,
    /// Random part.
    pub random: Vec<f64>,
    /// Number of blocks from which the filter was estimated.
    pub blocks: usize,
}

/// Separates a signal into its deterministic and its random part.
///
/// # Errors
/// Samples that are not finite; a block that is odd or below four samples; a signal shorter than eight
/// half-overlapping blocks, one more block and the gap.
pub fn separate(samples: &[f64], settings: SeparationOptions) -> Result<Separation, Error> {
    let SeparationOptions { block, gap } = settings;
    check_count(block, 4, "the number of samples in a block")?;
    if !block.is_multiple_of(2) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("a block of {block} samples is odd; it must be even"),
        ));
    }
    let delay = block.saturating_add(gap);
    // Minimum number of blocks with their delay; every sample must have a past or a future for its prediction.
    let blocks = block.saturating_mul(MIN_BLOCKS + 1) / 2;
    let reach = delay.saturating_mul(2).saturating_add(block);
    check_samples(samples, blocks.saturating_add(delay).max(reach))?;
    let (past, future, blocks) = filters(samples, block, delay);
    let deterministic = predict(samples, delay, &past, &future);
    let random = samples
        .iter()
        .zip(&deterministic)
        .map(|(x, d)| x - d)
        .collect();
    Ok(Separation {
        deterministic,
        random,
        blocks,
    })
}

/// Impulse responses of the forward and the backward predictor, `block` samples each, centred at `block/2`, and the number of blocks.
fn filters(samples: &[f64], block: usize, delay: usize) -> (Vec<f64>, Vec<f64>, usize) {
    let weights = Window::Hann.samples(block);
    let mut fft = RealFft::new(block);
    let zero = Complex::new(0.0, 0.0);
    let mut work = vec![0.0; block];
    let (mut past, mut current) = (vec![zero; fft.lines()], vec![zero; fft.lines()]);
    let mut cross = past.clone();
    let mut power = vec![(0.0, 0.0); past.len()];
    let mut blocks = 0;
    for start in (0..=samples.len() - block - delay).step_by(block / 2) {
        for (at, lines) in [(start, &mut past), (start + delay, &mut current)] {
            let part = samples[at..at + block].iter().zip(&weights);
            work.iter_mut().zip(part).for_each(|(w, (x, h))| *w = x * h);
            fft.forward(&mut work, lines);
        }
        for (k, (p, y)) in past.iter().zip(&current).enumerate() {
            cross[k] += y * p.conj();
            power[k].0 += p.norm_sqr();
            power[k].1 += y.norm_sqr();
        }
        blocks += 1;
    }
    let threshold = 1.0 - FALSE_ALARM.powf(1.0 / (blocks as f64 * INDEPENDENT_BLOCK_SHARE - 1.0));
    let mut response = |ratio: &dyn Fn(usize) -> Complex| {
        let mut lines: Vec<Complex> = (0..cross.len())
            .map(|k| {
                let (a, b) = power[k];
                if cross[k].norm_sqr() > threshold * a * b {
                    ratio(k)
                } else {
                    zero
                }
            })
            .collect();
        let mut response = vec![0.0; block];
        fft.inverse(&mut lines, &mut response);
        response.rotate_right(block / 2);
        response.iter_mut().zip(&weights).for_each(|(h, w)| *h *= w);
        response
    };
    let past = response(&|k| cross[k] / power[k].0);
    let future = response(&|k| cross[k].conj() / power[k].1);
    (past, future, blocks)
}

/// Prediction `h_past * x(· − Δ)` or `h_future * x(· + Δ)`; their mean if both lie inside the signal.
fn predict(samples: &[f64], delay: usize, past: &[f64], future: &[f64]) -> Vec<f64> {
    let (n, block) = (samples.len(), past.len());
    let length = next_fast_len(n + block + delay);
    let mut fft = RealFft::new(length);
    let zero = Complex::new(0.0, 0.0);
    let mut spectrum = vec![zero; fft.lines()];
    let mut lines = spectrum.clone();
    let mut work = samples.to_vec();
    work.resize(length, 0.0);
    fft.forward(&mut work, &mut spectrum);
    let mut convolve = |response: &[f64], shift: usize| {
        work.fill(0.0);
        for (j, h) in response.iter().enumerate() {
            work[(shift + j + length - block / 2) % length] = *h;
        }
        fft.forward(&mut work, &mut lines);
        lines.iter_mut().zip(&spectrum).for_each(|(z, x)| *z *= x);
        fft.inverse(&mut lines, &mut work);
        work[..n].to_vec()
    };
    let mut forward = convolve(past, delay);
    let backward = convolve(future, length - delay);
    let reach = delay + block / 2;
    for (j, (f, b)) in forward.iter_mut().zip(&backward).enumerate() {
        *f = match (j >= reach, j + reach <= n) {
            (true, true) => 0.5 * (*f + b),
            (true, false) => *f,
            (false, _) => *b,
        };
    }
    forward
}
