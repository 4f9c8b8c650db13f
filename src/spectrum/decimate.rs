//! Decimation without delay by linear-phase FIR stages: `y_j = Σ_i h_i x_{jM+i}`, `|i| ≤ m`.
//!
//! Large factors are split into stages, each of which only keeps its aliases out of the final pass band (Crochiere & Rabiner,
//! Multirate Digital Signal Processing (1983), chapter 5), so that the first stages are short filters.

use super::kaiser_fir::low_pass;
use super::validation::check_count;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::vector_ops::dot;

/// Maximum factor of a stage, unless a prime factor is larger; above it one stage costs more than two.
const MAX_STAGE_FACTOR: usize = 8;

/// Pass band and attenuation of the decimation filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DecimationOptions {
    /// Pass-band edge relative to half the new sample rate, `0 < pass < 1`; the stop band begins at half the new rate.
    pub pass: f64,
    /// Stop-band attenuation, dB; the pass-band ripple over all stages is `10^(−attenuation/20)`.
    pub attenuation_db: f64,
}

impl Default for DecimationOptions {
    /// Ripple 10⁻⁴ up to 0.8 of half the new rate, aliases attenuated by 80 dB: below the noise of most recordings.
    fn default() -> Self {
        DecimationOptions {
            pass: 0.8,
            attenuation_db: 80.0,
        }
    }
}

/// FIR filter of one stage with its state.
#[derive(Debug, Clone)]
struct FilterStage {
    factor: usize,
    weights: Vec<f64>,
    /// Buffered inputs; the next output weights `weights.len()` of them from index `next`.
    history: Vec<f64>,
    next: usize,
    started: bool,
    last: f64,
}

impl FilterStage {
    fn half(&self) -> usize {
        self.weights.len() / 2
    }

    /// Filters samples; before the first sample the signal is extended by its value.
    fn push(&mut self, samples: &[f64], out: &mut Vec<f64>) {
        let (Some(&first), Some(&last)) = (samples.first(), samples.last()) else {
            return;
        };
        if !self.started {
            self.started = true;
            self.history.resize(self.half(), first);
        }
        self.last = last;
        self.history.extend_from_slice(samples);
        let n = self.weights.len();
        while self.next + n <= self.history.len() {
            out.push(dot(&self.weights, &self.history[self.next..self.next + n]));
            self.next += self.factor;
        }
        let consumed = self.next.min(self.history.len());
        self.history.drain(..consumed);
        self.next -= consumed;
    }

    /// Flushes the filter; after the last sample the signal is extended by its value.
    fn finish(&mut self, out: &mut Vec<f64>) {
        if self.started {
            self.push(&vec![self.last; self.half()], out);
        }
    }
}

/// Decimator of a signal that arrives in blocks.
#[derive(Debug, Clone)]
pub struct Decimator {
    factor: usize,
    stages: Vec<FilterStage>,
    stage_buffer: Vec<f64>,
    block_buffer: Vec<f64>,
}

impl Decimator {
    /// Creates a decimator by `factor ≥ 1`; 1 leaves the signal unchanged.
    ///
    /// # Errors
    /// A factor of zero, a pass band or an attenuation out of range.
    pub fn new(factor: usize, settings: DecimationOptions) -> Result<Decimator, Error> {
        check_count(factor, 1, "the decimation factor")?;
        if !(settings.pass > 0.0 && settings.pass < 1.0) {
            return Err(Error::new(
                Code::OutOfRange,
                format!(
                    "a pass band up to {} of half the new rate, where the edge must lie between 0 and 1",
                    settings.pass
                ),
            ));
        }
        let factors = stage_factors(factor);
        // In the worst case the ripples of the stages add up.
        let db = settings.attenuation_db + 20.0 * (factors.len().max(1) as f64).log10();
        let mut stages = Vec::new();
        let mut ratio = factor; // input rate of the stage over the final rate
        for factor in factors {
            let pass = 0.5 * settings.pass / ratio as f64;
            // Aliases of this stage must stay above the final band.
            let stop = (ratio / factor) as f64 / ratio as f64 - 0.5 / ratio as f64;
            stages.push(FilterStage {
                factor,
                weights: low_pass(pass, stop, db)?,
                history: Vec::new(),
                next: 0,
                started: false,
                last: 0.0,
            });
            ratio /= factor;
        }
        Ok(Decimator {
            factor,
            stages,
            stage_buffer: Vec::new(),
            block_buffer: Vec::new(),
        })
    }

    /// Number of outputs at each end affected by the assumption that the signal is constant beyond its ends.
    pub fn transient_len(&self) -> usize {
        let mut spacing = 1;
        let mut reach = 0;
        for stage in &self.stages {
            reach += stage.half() * spacing;
            spacing *= stage.factor;
        }
        reach.div_ceil(self.factor)
    }

    /// Takes the next samples and appends the completed outputs to `out`. The result does not depend on the block lengths, to the bit.
    pub fn push(&mut self, samples: &[f64], out: &mut Vec<f64>) {
        self.run(0, samples, out);
    }

    /// Passes samples through the stages from `first` on.
    fn run(&mut self, first: usize, samples: &[f64], out: &mut Vec<f64>) {
        self.stage_buffer.clear();
        self.stage_buffer.extend_from_slice(samples);
        for stage in &mut self.stages[first..] {
            self.block_buffer.clear();
            stage.push(&self.stage_buffer, &mut self.block_buffer);
            std::mem::swap(&mut self.stage_buffer, &mut self.block_buffer);
        }
        out.extend_from_slice(&self.stage_buffer);
    }

    /// Appends the outputs at the end of the signal: `n` samples give `⌈n/factor⌉`, the first at the first sample.
    pub fn finish(mut self, out: &mut Vec<f64>) {
        for index in 0..self.stages.len() {
            let mut tail = Vec::new();
            self.stages[index].finish(&mut tail);
            self.run(index + 1, &tail, out);
        }
    }
}

/// Decimates a slice by `factor`.
///
/// # Errors
/// As [`Decimator::new`].
pub fn decimate(
    samples: &[f64],
    factor: usize,
    settings: DecimationOptions,
) -> Result<Vec<f64>, Error> {
    const BLOCK: usize = 1 << 14; // stays in the cache between the stages
    let mut decimator = Decimator::new(factor, settings)?;
    let mut out = Vec::with_capacity(samples.len() / factor + 1);
    samples
        .chunks(BLOCK)
        .for_each(|block| decimator.push(block, &mut out));
    decimator.finish(&mut out);
    Ok(out)
}

/// Factors of the stages, the largest first: prime factors, multiplied up to `MAX_STAGE_FACTOR`.
fn stage_factors(factor: usize) -> Vec<usize> {
    let mut primes = Vec::new();
    let mut remainder = factor;
    let mut prime = 2;
    while prime * prime <= remainder {
        while remainder.is_multiple_of(prime) {
            primes.push(prime);
            remainder /= prime;
        }
        prime += 1;
    }
    if remainder > 1 {
        primes.push(remainder);
    }
    let mut stages: Vec<usize> = Vec::new();
    for prime in primes.into_iter().rev() {
        match stages.iter_mut().find(|s| **s * prime <= MAX_STAGE_FACTOR) {
            Some(stage) => *stage *= prime,
            None => stages.push(prime),
        }
    }
    stages.sort_unstable_by(|a, b| b.cmp(a));
    stages
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_stages() {
        assert_eq!(stage_factors(1), Vec::<usize>::new());
        assert_eq!(stage_factors(8), [8]);
        assert_eq!(stage_factors(13), [13]);
        for factor in 1..2000 {
            assert_eq!(stage_factors(factor).iter().product::<usize>(), factor);
        }
    }

    /// The result does not depend on the block lengths, to the bit; n samples give ⌈n/factor⌉.
    #[test]
    fn law_blocks_join_exactly() {
        let mut rng = fastrand::Rng::with_seed(4);
        let x: Vec<f64> = (0..5003).map(|_| rng.f64() - 0.5).collect();
        for factor in [1, 2, 7, 10, 60, 128] {
            let expected = decimate(&x, factor, DecimationOptions::default()).unwrap();
            assert_eq!(expected.len(), x.len().div_ceil(factor));
            let mut output = Vec::new();
            let mut decimator = Decimator::new(factor, DecimationOptions::default()).unwrap();
            let mut start = 0;
            while start < x.len() {
                let end = (start + rng.usize(0..300)).min(x.len());
                decimator.push(&x[start..end], &mut output);
                start = end;
            }
            decimator.finish(&mut output);
            assert!(
                expected
                    .iter()
                    .zip(&output)
                    .all(|(a, b)| a.to_bits() == b.to_bits())
            );
        }
    }

    #[test]
    fn refuses_nonsense() {
        assert!(Decimator::new(0, DecimationOptions::default()).is_err());
        let wide = DecimationOptions {
            pass: 1.0,
            ..DecimationOptions::default()
        };
        assert_eq!(Decimator::new(4, wide).unwrap_err().code, Code::OutOfRange);
        assert!(
            decimate(&[], 3, DecimationOptions::default())
                .unwrap()
                .is_empty()
        );
    }
}
