//! Discrete/random separation (Antoni & Randall): prediction from the signal a delay ago.
//!
//! J. Antoni, R. B. Randall, Unsupervised noise cancellation for vibration signals: part II – a novel frequency-domain algorithm,
//! Mech. Syst. Signal Process. 18 (2004), 103–117. Tones (gear meshes, shafts) can be predicted over any delay, noise and bearing
//! faults, whose rollers slip at random, cannot over one longer than their memory. Tones must be steady: take a signal over angle.
//!
//! Where this leaves the source: `H` is set to zero on lines whose coherence noise alone would reach once in a thousand (fewer blocks would
//! otherwise leak as noise); its impulse response is tapered by Hann's window, which smooths `H` over neighbouring lines so
//! that a tone between two of them is kept too; and the prediction is also made backward from the future, the mean of both being taken where
//! both reach.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::{RealFft, next_fast_len};
use crate::spectrum::validation::{check_count, check_samples};
use crate::spectrum::window::Window;

/// Probability that noise alone passes for a tone on a line.
const FALSE_ALARM: f64 = 1e-3;

/// Fewer blocks do not tell coherence from chance.
const MIN_BLOCKS: usize = 8;

/// Independent blocks to one of Hann's that overlap by half: 1/(1 + 2/36), Welch, IEEE Trans. Audio Electroacoust. 15 (1967), 70–73.
const INDEPENDENT_BLOCK_SHARE: f64 = 36.0 / 38.0;

/// Options of the separation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SeparationOptions {
    /// Samples in a block, even: what is distinguished from a tone lies `2/block` of the rate or more next to it. A tone of
    /// amplitude `a` in white noise of variance `σ²` loses the part `1/(1 + block a²/(6σ²))`.
    pub block: usize,
    /// Samples between the end of a block and the begin of the one it predicts: at least the memory of the random part.
    pub gap: usize,
}

/// The two parts; their sum is the signal.
#[derive(Debug, Clone)]
pub struct Separation {
    /// Periodic part.
    pub deterministic: Vec<f64>,
    /// Random part.
    pub random: Vec<f64>,
    /// Blocks that the filter was estimated from.
    pub blocks: usize,
}

/// Separates a signal.
///
/// # Errors
/// Samples not finite, a block that is odd or below four samples, a signal shorter than eight
/// half-overlapping blocks, one more and the gap.
pub fn separate(samples: &[f64], settings: SeparationOptions) -> Result<Separation, Error> {
    let SeparationOptions { block, gap } = settings;
    check_count(block, 4, "the number of samples in a block")?;
    if !block.is_multiple_of(2) {
        return Err(Error::new(
            Code::OutOfRange,
            format!("a block of {block} samples, where an even number is needed"),
        ));
    }
    let delay = block.saturating_add(gap);
    // so many blocks and their delay, and everywhere either the past or the future within reach
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

/// Impulse responses from the past and from the future, each `block` long with its middle at `block/2`.
fn filters(samples: &[f64], block: usize, delay: usize) -> (Vec<f64>, Vec<f64>, usize) {
    let weights = Window::Hann.samples(block);
    let mut fft = RealFft::new(block);
    let zero = Complex::new(0.0, 0.0);
    let mut work = vec![0.0; block];
    let (mut past, mut now) = (vec![zero; fft.lines()], vec![zero; fft.lines()]);
    let mut cross = past.clone();
    let mut power = vec![(0.0, 0.0); past.len()];
    let mut blocks = 0;
    for start in (0..=samples.len() - block - delay).step_by(block / 2) {
        for (at, lines) in [(start, &mut past), (start + delay, &mut now)] {
            let part = samples[at..at + block].iter().zip(&weights);
            work.iter_mut().zip(part).for_each(|(w, (x, h))| *w = x * h);
            fft.forward(&mut work, lines);
        }
        for (k, (p, y)) in past.iter().zip(&now).enumerate() {
            cross[k] += y * p.conj();
            power[k].0 += p.norm_sqr();
            power[k].1 += y.norm_sqr();
        }
        blocks += 1;
    }
    let chance = 1.0 - FALSE_ALARM.powf(1.0 / (blocks as f64 * INDEPENDENT_BLOCK_SHARE - 1.0));
    let mut response = |of: &dyn Fn(usize) -> Complex| {
        let mut lines: Vec<Complex> = (0..cross.len())
            .map(|k| {
                let (a, b) = power[k];
                if cross[k].norm_sqr() > chance * a * b {
                    of(k)
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

/// `h_past * x(· − Δ)`, `h_future * x(· + Δ)`, or their mean where both lie inside the signal.
fn predict(samples: &[f64], delay: usize, past: &[f64], future: &[f64]) -> Vec<f64> {
    let (n, block) = (samples.len(), past.len());
    let long = next_fast_len(n + block + delay);
    let mut fft = RealFft::new(long);
    let zero = Complex::new(0.0, 0.0);
    let mut spectrum = vec![zero; fft.lines()];
    let mut lines = spectrum.clone();
    let mut work = samples.to_vec();
    work.resize(long, 0.0);
    fft.forward(&mut work, &mut spectrum);
    let mut convolve = |response: &[f64], shift: usize| {
        work.fill(0.0);
        for (j, h) in response.iter().enumerate() {
            work[(shift + j + long - block / 2) % long] = *h;
        }
        fft.forward(&mut work, &mut lines);
        lines.iter_mut().zip(&spectrum).for_each(|(z, x)| *z *= x);
        fft.inverse(&mut lines, &mut work);
        work[..n].to_vec()
    };
    let mut forward = convolve(past, delay);
    let backward = convolve(future, long - delay);
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
