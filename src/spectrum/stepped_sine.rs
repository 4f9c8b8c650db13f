//! FRFs from stepped sines: dwells found in the input, a sine fitted to input and outputs on each.
//!
//! IEEE Std 1057-2017, section 4.6: four parameters on the input, which gives the frequency, three at that frequency on the outputs,
//! `H = A_y/A_x`. What the fit leaves near the frequency is the noise on it: with `R(f) = Σ r e^{−iωj}` over N samples,
//! `E|ΔA|² = 4 E|R|²/N²`, by the mean over lines about the sine, so that neither noise elsewhere nor multiples of the sine count.

use std::ops::Range;

use super::force_pulses::median;
use super::settling::{Dwell, SteadyStateEstimate, settled_from};
use super::sine::{fit, fit_amplitude};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::{RealFft, next_fast_len};
use crate::numeric::sorting::sort_rising;
use crate::recording::frequency_responses::{ChannelLabel, FrequencyResponse, FrequencyResponses};

/// Fewer periods are no dwell.
const MIN_PERIODS: usize = 8;

/// The dwell of a given range: its frequency is that of the highest line.
///
/// # Errors
/// `NoSignal` for an input that is constant there; `TooShort` for a range of fewer than eight samples or beyond the input.
pub fn dwell_of_range(input: &[f64], rate_hz: f64, range: Range<usize>) -> Result<Dwell, Error> {
    let Some(samples) = input.get(range.clone()).filter(|s| s.len() >= 8) else {
        let message = format!(
            "a dwell of {} samples from {} on is none of {} samples",
            range.len(),
            range.start,
            input.len()
        );
        return Err(Error::new(Code::TooShort, message));
    };
    // Padded, so that the highest line is within a quarter of a line of the frequency.
    let mut fft = RealFft::new(next_fast_len(2 * samples.len()));
    let mean = samples.iter().sum::<f64>() / samples.len() as f64;
    let mut padded = vec![0.0; fft.samples()];
    (padded.iter_mut().zip(samples)).for_each(|(p, x)| *p = x - mean);
    let mut lines = vec![Complex::new(0.0, 0.0); fft.lines()];
    fft.forward(&mut padded, &mut lines);
    let power = |k: &usize| lines[*k].norm_sqr();
    let highest = (1..lines.len() - 1).max_by(|a, b| power(a).total_cmp(&power(b)));
    match highest.filter(|k| power(k) > 0.0) {
        Some(k) => Ok(Dwell {
            frequency_hz: k as f64 * rate_hz / fft.samples() as f64,
            range,
        }),
        None => Err(Error::new(
            Code::NoSignal,
            format!("the input is constant over {} samples", range.len()),
        )),
    }
}

/// Whether dwells hold their frequency: what they drift from one half to the other is small against the step to the next. A sweep drifts
/// by half of it.
pub fn dwells_hold_frequency(input: &[f64], rate_hz: f64, dwells: &[Dwell]) -> bool {
    /// Largest drift as a share of the step.
    const MAX_DRIFT: f64 = 0.1;
    let mut shares = Vec::with_capacity(dwells.len());
    for pair in dwells.windows(2) {
        let range = &pair[0].range;
        let middle = usize::midpoint(range.start, range.end);
        let of = |part: Range<usize>| -> Result<f64, Error> {
            Ok(fit(&input[part], rate_hz, pair[0].frequency_hz)?.frequency_hz)
        };
        let drift = match (of(range.start..middle), of(middle..range.end)) {
            (Ok(first), Ok(second)) => (second - first).abs(),
            _ => f64::INFINITY,
        };
        shares.push(drift / (pair[1].frequency_hz - pair[0].frequency_hz).abs());
    }
    !shares.is_empty() && median(&shares) < MAX_DRIFT
}

/// A crossing counts once the signal was below this share of its present size.
const HYSTERESIS: f64 = 0.1;

/// The dwells of an input that steps from frequency to frequency: runs of regular upward crossings of its median.
pub fn find_dwells(input: &[f64], rate_hz: f64) -> Vec<Dwell> {
    let crossings = crossings(input);
    let mut found = Vec::new();
    let mut from = 0;
    while from + MIN_PERIODS < crossings.len() {
        let mut beat = PeriodFit::new(crossings[from], crossings[from + 1]);
        let later = crossings[from + 2..].iter();
        let run = 1 + later.take_while(|&&at| beat.try_push(at)).count();
        if run >= MIN_PERIODS {
            let (last, period) = trim_run(&crossings[from..=from + run]);
            // The first and the last period may hold a part of the step.
            let range = crossings[from + 1].ceil() as usize..crossings[from + last - 1] as usize;
            found.push(Dwell {
                range,
                frequency_hz: rate_hz / period,
            });
            from += run;
        } else {
            from += 1;
        }
    }
    found
}

/// The last crossing of a run that keeps the beat of its first three quarters, and the period of these: a small step is noticed late.
fn trim_run(run: &[f64]) -> (usize, f64) {
    const OUTLIER_SIGMA: f64 = 2.0; // times their scatter
    let kept = (3 * run.len() / 4).max(3);
    let mut beat = PeriodFit::new(run[0], run[1]);
    run[2..kept].iter().for_each(|&at| beat.add(at));
    let (.., scatter) = beat.line();
    let allowed = (OUTLIER_SIGMA * scatter).max(MIN_TOLERANCE * beat.first);
    let mut last = run.len() - 1;
    while last > kept && beat.deviation(run[last], last as f64).abs() > allowed {
        last -= 1;
    }
    (last, beat.period())
}

/// A straight line through crossings over their number, kept as what they stray from the first period: `r_i = t_i − t_0 − i p`.
struct PeriodFit {
    start: f64,
    first: f64,
    count: f64,
    /// Sums of r, i r and r².
    sums: [f64; 3],
}

impl PeriodFit {
    fn new(start: f64, next: f64) -> PeriodFit {
        PeriodFit {
            start,
            first: next - start,
            count: 2.0,
            sums: [0.0; 3],
        }
    }

    /// Slope of r, r in the middle, and their scatter about the line.
    fn line(&self) -> (f64, f64, f64) {
        let n = self.count;
        let [r, ir, rr] = self.sums;
        let spread = n * (n * n - 1.0) / 12.0;
        let (mean, lean) = (r / n, ir - 0.5 * (n - 1.0) * r);
        let slope = lean / spread;
        let left = rr - n * mean * mean - slope * lean;
        (slope, mean, (left.max(0.0) / (n - 2.0).max(1.0)).sqrt())
    }

    fn period(&self) -> f64 {
        self.first + self.line().0
    }

    /// Deviation of a crossing of the given number from its expected time.
    fn deviation(&self, at: f64, number: f64) -> f64 {
        let (slope, mean, _) = self.line();
        let expected = mean + slope * (number - 0.5 * (self.count - 1.0));
        at - self.start - number * self.first - expected
    }

    /// Adds a crossing, if it comes when the ones before let expect it.
    fn try_push(&mut self, at: f64) -> bool {
        let (.., scatter) = self.line();
        let most = MAX_TOLERANCE * self.first;
        let allowed = if self.count < MIN_PERIODS as f64 {
            most
        } else {
            (MAX_SCATTER_RATIO * scatter).clamp(MIN_TOLERANCE * self.first, most)
        };
        if self.deviation(at, self.count).abs() > allowed {
            return false;
        }
        self.add(at);
        true
    }

    fn add(&mut self, at: f64) {
        let r = at - self.start - self.count * self.first;
        self.sums[0] += r;
        self.sums[1] += self.count * r;
        self.sums[2] += r * r;
        self.count += 1.0;
    }
}

/// A crossing ends a dwell when it is off by so many times the scatter of those before …
const MAX_SCATTER_RATIO: f64 = 6.0;

/// … but by this share of a period at least: interpolation between samples is no better …
const MIN_TOLERANCE: f64 = 0.005;

/// … and always by this share.
const MAX_TOLERANCE: f64 = 0.05;

/// Times, in samples, at which a signal rises through its median.
fn crossings(input: &[f64]) -> Vec<f64> {
    let level = median(input);
    let mut found: Vec<f64> = Vec::new();
    let (mut size, mut is_armed, mut fade) = (0.0_f64, false, 1.0);
    for (j, pair) in input.windows(2).enumerate() {
        let (before, now) = (pair[0] - level, pair[1] - level);
        size = now.abs().max(size * fade);
        if now < -HYSTERESIS * size {
            is_armed = true;
        }
        if is_armed && now >= 0.0 {
            is_armed = false;
            let at = j as f64
                + if now > before {
                    -before / (now - before)
                } else {
                    0.0
                };
            if let Some(last) = found.last() {
                fade = (-1.0_f64 / (at - last).max(1.0)).exp();
            }
            found.push(at);
        }
    }
    found
}

/// Frequencies nearer than this share of a line are the same again.
const SAME_FREQUENCY_LINES: f64 = 0.02;

/// Responses of a stepped sine.
#[derive(Debug)]
pub struct SteppedSineEstimate {
    /// One line for each frequency, rising.
    pub responses: FrequencyResponses,
    /// Frequencies of dwells that were too short for an output to settle, Hz.
    pub unsettled_hz: Vec<f64>,
}

/// Frequency responses over the dwells; of one frequency dwelt on twice the mean, by weights. Of each dwell the part counts over which
/// the responses have settled; where they have not by its end, what the rest of it would have brought is taken from how it rings out.
///
/// # Errors
/// `NoSignal`: no dwell. As [`fit`].
///
/// # Panics
/// Outputs shorter than the dwells reach: a mistake of the caller.
pub fn estimate_from_dwells(
    rate_hz: f64,
    input: (&ChannelLabel, &[f64]),
    outputs: &[(&ChannelLabel, &[f64])],
    dwells: &[Dwell],
) -> Result<SteppedSineEstimate, Error> {
    if dwells.is_empty() {
        return Err(Error::new(
            Code::NoSignal,
            format!("the input dwells on no frequency for {MIN_PERIODS} periods"),
        )
        .with_hint("estimate with averaged blocks instead"));
    }
    let mut order: Vec<&Dwell> = dwells.iter().collect();
    sort_rising(&mut order, |a| a.frequency_hz);
    let mut found = FrequencyResponses {
        frequency_hz: Vec::with_capacity(dwells.len()),
        responses: outputs
            .iter()
            .map(|(terminal, _)| FrequencyResponse {
                input: Some(input.0.clone()),
                output: (*terminal).clone(),
                variance: Some(Vec::with_capacity(dwells.len())),
                ..FrequencyResponse::default()
            })
            .collect(),
        averages: None,
        window_decay: 0.0,
        usable_band_hz: None,
        independent_lines_per_line: None,
    };
    let mut unsettled_hz = Vec::new();
    for dwell in order {
        let whole = fit(&input.1[dwell.range.clone()], rate_hz, dwell.frequency_hz)?;
        let mut start = dwell.range.start;
        for (_, output) in outputs {
            start = start.max(settled_from(
                dwell,
                whole.frequency_hz,
                rate_hz,
                input.1,
                output,
            )?);
        }
        let range = start..dwell.range.end;
        let x = fit(&input.1[range.clone()], rate_hz, whole.frequency_hz)?;
        let of_x = x.variance_near(&input.1[range.clone()], rate_hz);
        let again = SAME_FREQUENCY_LINES * rate_hz / range.len() as f64;
        let last = found.frequency_hz.last().copied();
        let is_again = last.is_some_and(|last| x.frequency_hz - last < again);
        if !is_again {
            found.frequency_hz.push(x.frequency_hz);
        }
        for ((_, output), function) in outputs.iter().zip(&mut found.responses) {
            let y = fit_amplitude(&output[range.clone()], rate_hz, x.frequency_hz)?;
            let mut h = y.amplitude / x.amplitude;
            let of_y = y.variance_near(&output[range.clone()], rate_hz);
            let mut noise = (of_y + h.norm_sqr() * of_x) / x.amplitude.norm_sqr();
            if let Some(ringing) =
                SteadyStateEstimate::extrapolate(dwell, x.frequency_hz, rate_hz, input.1, output)?
            {
                (h, noise) = (ringing.steady_state, noise + ringing.variance);
                if unsettled_hz.last() != Some(&x.frequency_hz) {
                    unsettled_hz.push(x.frequency_hz);
                }
            }
            let variance = function.variance.get_or_insert_default();
            match (is_again, function.values.last_mut(), variance.last_mut()) {
                (true, Some(value), Some(variance)) => {
                    let least = (f64::EPSILON * h.norm()).powi(2).max(f64::MIN_POSITIVE);
                    let weights = (variance.max(least).recip(), noise.max(least).recip());
                    let sum = weights.0 + weights.1;
                    *value = (*value * weights.0 + h * weights.1) / sum;
                    *variance = sum.recip();
                }
                _ => {
                    function.values.push(h);
                    variance.push(noise);
                }
            }
        }
    }
    Ok(SteppedSineEstimate {
        responses: found,
        unsettled_hz,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refuses_what_dwells_nowhere() {
        assert!(find_dwells(&[], 1.0).is_empty() && find_dwells(&[0.0; 100], 1.0).is_empty());
        assert!(dwell_of_range(&[1.0; 50], 1.0, 0..50).is_err());
        assert!(dwell_of_range(&[1.0, 2.0], 1.0, 0..2).is_err());
    }
}
