//! FRFs from stepped sines: dwells detected in the input, with sine fits of input and outputs.
//!
//! IEEE Std 1057-2017, section 4.6: four parameters on the input, which gives the frequency, three at that frequency on the outputs,
//! `H = A_y/A_x`. The residual near the frequency estimates the noise: with `R(f) = Σ r e^{−iωj}` over N samples,
//! `E|ΔA|² = 4 E|R|²/N²`, by the mean over lines about the sine, which excludes noise elsewhere and harmonics of the sine.

use std::ops::Range;

use super::force_pulses::median;
use super::settling::{Dwell, SteadyStateEstimate, settled_from};
use super::sine::{fit, fit_amplitude};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::fft::{RealFft, next_fast_len};
use crate::numeric::sorting::sort_ascending;
use crate::recording::frequency_responses::{ChannelLabel, FrequencyResponse, FrequencyResponses};

/// Minimum number of periods of a dwell.
const MIN_PERIODS: usize = 8;

/// Dwell of a given range, with the frequency of the highest spectral line.
///
/// # Errors
/// `NoSignal` for an input constant over the range; `TooShort` for a range of fewer than eight samples or beyond the input.
pub fn dwell_of_range(input: &[f64], rate_hz: f64, range: Range<usize>) -> Result<Dwell, Error> {
    let Some(samples) = input.get(range.clone()).filter(|s| s.len() >= 8) else {
        let message = format!(
            "a dwell of {} samples from {} on does not fit {} samples, or is too short (minimum 8)",
            range.len(),
            range.start,
            input.len()
        );
        return Err(Error::new(Code::TooShort, message));
    };
    // With zero padding the highest line is within a quarter of a line of the frequency.
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

/// Whether the frequency of dwells is constant: the drift between both halves is small relative to the step to the next dwell. In a sweep
/// it is half the step.
pub fn dwells_hold_frequency(input: &[f64], rate_hz: f64, dwells: &[Dwell]) -> bool {
    /// Largest drift relative to the frequency step.
    const MAX_DRIFT: f64 = 0.1;
    let mut drifts = Vec::with_capacity(dwells.len());
    for pair in dwells.windows(2) {
        let range = &pair[0].range;
        let middle = usize::midpoint(range.start, range.end);
        let f = |samples: Range<usize>| -> Result<f64, Error> {
            Ok(fit(&input[samples], rate_hz, pair[0].frequency_hz)?.frequency_hz)
        };
        let drift = match (f(range.start..middle), f(middle..range.end)) {
            (Ok(first), Ok(second)) => (second - first).abs(),
            _ => f64::INFINITY,
        };
        drifts.push(drift / (pair[1].frequency_hz - pair[0].frequency_hz).abs());
    }
    !drifts.is_empty() && median(&drifts) < MAX_DRIFT
}

/// Hysteresis of a crossing, relative to the present amplitude.
const HYSTERESIS: f64 = 0.1;

/// Dwells of a stepped-sine input: runs of regular upward crossings of its median.
pub fn find_dwells(input: &[f64], rate_hz: f64) -> Vec<Dwell> {
    let crossings = crossings(input);
    let mut dwells = Vec::new();
    let mut start = 0;
    while start + MIN_PERIODS < crossings.len() {
        let mut period_fit = PeriodFit::new(crossings[start], crossings[start + 1]);
        let later = crossings[start + 2..].iter();
        let run = 1 + later.take_while(|&&time| period_fit.try_push(time)).count();
        if run >= MIN_PERIODS {
            let (last, period) = trim_run(&crossings[start..=start + run]);
            // The first and the last period may contain the frequency step.
            let range = crossings[start + 1].ceil() as usize..crossings[start + last - 1] as usize;
            dwells.push(Dwell {
                range,
                frequency_hz: rate_hz / period,
            });
            start += run;
        } else {
            start += 1;
        }
    }
    dwells
}

/// Last crossing consistent with the first three quarters of a run, and their period, samples: a small frequency step is detected late.
fn trim_run(run: &[f64]) -> (usize, f64) {
    const OUTLIER_SIGMA: f64 = 2.0; // times their scatter
    let reference = (3 * run.len() / 4).max(3);
    let mut line = PeriodFit::new(run[0], run[1]);
    run[2..reference].iter().for_each(|&time| line.add(time));
    let (.., scatter) = line.line();
    let allowed = (OUTLIER_SIGMA * scatter).max(MIN_TOLERANCE * line.first);
    let mut last = run.len() - 1;
    while last > reference && line.deviation(run[last], last as f64).abs() > allowed {
        last -= 1;
    }
    (last, line.period())
}

/// Regression line of crossing times over their number, by the deviations from the first period: `r_i = t_i − t_0 − i p`, samples.
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

    /// Slope and mean of r, and its standard deviation about the line.
    fn line(&self) -> (f64, f64, f64) {
        let n = self.count;
        let [r, ir, rr] = self.sums;
        let variance = n * (n * n - 1.0) / 12.0;
        let (mean, covariance) = (r / n, ir - 0.5 * (n - 1.0) * r);
        let slope = covariance / variance;
        let residual = rr - n * mean * mean - slope * covariance;
        (slope, mean, (residual.max(0.0) / (n - 2.0).max(1.0)).sqrt())
    }

    fn period(&self) -> f64 {
        self.first + self.line().0
    }

    /// Deviation of a crossing of the given number from its expected time.
    fn deviation(&self, time: f64, number: f64) -> f64 {
        let (slope, mean, _) = self.line();
        let expected = mean + slope * (number - 0.5 * (self.count - 1.0));
        time - self.start - number * self.first - expected
    }

    /// Adds a crossing within the tolerance of its expected time; returns whether it was added.
    fn try_push(&mut self, time: f64) -> bool {
        let (.., scatter) = self.line();
        let max = MAX_TOLERANCE * self.first;
        let allowed = if self.count < MIN_PERIODS as f64 {
            max
        } else {
            (MAX_SCATTER_RATIO * scatter).clamp(MIN_TOLERANCE * self.first, max)
        };
        if self.deviation(time, self.count).abs() > allowed {
            return false;
        }
        self.add(time);
        true
    }

    fn add(&mut self, time: f64) {
        let r = time - self.start - self.count * self.first;
        self.sums[0] += r;
        self.sums[1] += self.count * r;
        self.sums[2] += r * r;
        self.count += 1.0;
    }
}

/// Tolerance of a crossing time in a dwell, in standard deviations of the preceding crossings …
const MAX_SCATTER_RATIO: f64 = 6.0;

/// … with this lower limit, relative to a period: the accuracy of interpolation between samples …
const MIN_TOLERANCE: f64 = 0.005;

/// … and this upper limit, relative to a period.
const MAX_TOLERANCE: f64 = 0.05;

/// Times of the upward crossings of the median, samples.
fn crossings(input: &[f64]) -> Vec<f64> {
    let level = median(input);
    let mut times: Vec<f64> = Vec::new();
    let (mut amplitude, mut is_armed, mut decay) = (0.0_f64, false, 1.0);
    for (j, pair) in input.windows(2).enumerate() {
        let (before, after) = (pair[0] - level, pair[1] - level);
        amplitude = after.abs().max(amplitude * decay);
        if after < -HYSTERESIS * amplitude {
            is_armed = true;
        }
        if is_armed && after >= 0.0 {
            is_armed = false;
            let time = j as f64
                + if after > before {
                    -before / (after - before)
                } else {
                    0.0
                };
            if let Some(last) = times.last() {
                decay = (-1.0_f64 / (time - last).max(1.0)).exp();
            }
            times.push(time);
        }
    }
    times
}

/// Frequency difference, lines, below which two dwells have the same frequency.
const SAME_FREQUENCY_LINES: f64 = 0.02;

/// Frequency responses of a stepped-sine test.
#[derive(Debug)]
pub struct SteppedSineEstimate {
    /// Frequency responses, one line per frequency in ascending order.
    pub responses: FrequencyResponses,
    /// Frequencies of dwells too short for a steady state of an output, Hz.
    pub unsettled_hz: Vec<f64>,
}

/// Frequency responses by the dwells; repeated frequencies are averaged with the inverse variances as weights. Each dwell is evaluated in
/// its steady state; without one by its end, the steady state is extrapolated from the decay of the transient.
///
/// # Errors
/// `NoSignal`: no dwell. As [`fit`].
///
/// # Panics
/// Outputs shorter than the dwells: a mistake of the caller.
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
    sort_ascending(&mut order, |a| a.frequency_hz);
    let mut estimate = FrequencyResponses {
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
        let full_fit = fit(&input.1[dwell.range.clone()], rate_hz, dwell.frequency_hz)?;
        let mut start = dwell.range.start;
        for (_, output) in outputs {
            start = start.max(settled_from(
                dwell,
                full_fit.frequency_hz,
                rate_hz,
                input.1,
                output,
            )?);
        }
        let range = start..dwell.range.end;
        let x = fit(&input.1[range.clone()], rate_hz, full_fit.frequency_hz)?;
        let variance_x = x.variance_near(&input.1[range.clone()], rate_hz);
        let tolerance = SAME_FREQUENCY_LINES * rate_hz / range.len() as f64;
        let last = estimate.frequency_hz.last().copied();
        let is_repeated = last.is_some_and(|last| x.frequency_hz - last < tolerance);
        if !is_repeated {
            estimate.frequency_hz.push(x.frequency_hz);
        }
        for ((_, output), function) in outputs.iter().zip(&mut estimate.responses) {
            let y = fit_amplitude(&output[range.clone()], rate_hz, x.frequency_hz)?;
            let mut h = y.amplitude / x.amplitude;
            let variance_y = y.variance_near(&output[range.clone()], rate_hz);
            let mut noise = (variance_y + h.norm_sqr() * variance_x) / x.amplitude.norm_sqr();
            if let Some(extrapolated) =
                SteadyStateEstimate::extrapolate(dwell, x.frequency_hz, rate_hz, input.1, output)?
            {
                (h, noise) = (extrapolated.steady_state, noise + extrapolated.variance);
                if unsettled_hz.last() != Some(&x.frequency_hz) {
                    unsettled_hz.push(x.frequency_hz);
                }
            }
            let variance = function.variance.get_or_insert_default();
            match (is_repeated, function.values.last_mut(), variance.last_mut()) {
                (true, Some(value), Some(variance)) => {
                    let min = (f64::EPSILON * h.norm()).powi(2).max(f64::MIN_POSITIVE);
                    let weights = (variance.max(min).recip(), noise.max(min).recip());
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
        responses: estimate,
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
