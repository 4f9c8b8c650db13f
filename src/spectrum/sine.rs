//! Stepped sines: dwells are found in the input, and on each a sine is fitted to input and outputs alike, `x = Re(A e^{iωt}) + x₀`.
//!
//! IEEE Std 1057-2017, section 4.6 (sine fits of three and four parameters): four on the input, which gives the frequency, three at
//! that frequency on the outputs. `H = A_y/A_x`; white residuals of variance σ² over N samples give `E|ΔA|² = 4σ²/N`.

use std::f64::consts::TAU;
use std::ops::Range;

use super::hits::median;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::definite::solve;
use crate::numeric::{Complex, Matrix};
use crate::recording::responses::{FrequencyResponse, FrequencyResponses, Terminal};

/// A sine fitted by least squares.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SineFit {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Complex amplitude (0 to peak) with the time taken from the middle of the samples.
    pub amplitude: Complex,
    /// Level it swings about.
    pub offset: f64,
    /// `E|error|²` of the amplitude where what is left is white.
    pub variance: f64,
}

/// Samples over which the input holds one frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Dwell {
    /// Samples of it.
    pub range: Range<usize>,
    /// Its frequency by the crossings of zero, Hz.
    pub frequency_hz: f64,
}

/// Steps of Gauss and Newton that a fit from a start within half a line takes at most.
const MOST_STEPS: usize = 30;

/// The frequency stands still: turns over half the record, relative to rounding of a phase.
const STILL: f64 = 1e-12;

/// Fits amplitude and offset at a known frequency.
///
/// # Errors
/// `IllPosed`: fewer than five samples, or a frequency at which sine, cosine and level are not told apart.
pub fn fit_at(samples: &[f64], rate_hz: f64, frequency_hz: f64) -> Result<SineFit, Error> {
    Ok(step(samples, rate_hz, frequency_hz, None)?.0)
}

/// Fits amplitude, offset and frequency, from a start within about half of `rate/n` of it.
///
/// # Errors
/// As [`fit_at`]; `NoConvergence` where the frequency runs away.
pub fn fit(samples: &[f64], rate_hz: f64, start_hz: f64) -> Result<SineFit, Error> {
    let half = 0.5 * samples.len() as f64 / rate_hz;
    let mut frequency = start_hz;
    let (mut found, _) = step(samples, rate_hz, frequency, None)?;
    for _ in 0..MOST_STEPS {
        let change;
        (found, change) = step(samples, rate_hz, frequency, Some(found.amplitude))?;
        frequency += change;
        if change.abs() * half < STILL.max(f64::EPSILON * frequency * half) {
            return Ok(found);
        }
        if (frequency - start_hz).abs() * half > 1.0 || !frequency.is_finite() {
            break;
        }
    }
    Err(Error::new(
        Code::NoConvergence,
        format!("a sine near {start_hz} Hz does not fit: its frequency runs off to {frequency} Hz"),
    ))
}

/// One least-squares fit; with an amplitude also of the change of frequency, Hz.
fn step(
    samples: &[f64],
    rate_hz: f64,
    frequency_hz: f64,
    around: Option<Complex>,
) -> Result<(SineFit, f64), Error> {
    let unknowns = if around.is_some() { 4 } else { 3 };
    let n = samples.len();
    if n <= unknowns {
        return Err(Error::new(
            Code::IllPosed,
            format!("{n} samples do not determine a sine"),
        ));
    }
    let middle = 0.5 * (n as f64 - 1.0);
    let turn = TAU * frequency_hz / rate_hz;
    let rows = |j: usize| {
        let t = j as f64 - middle;
        let (s, c) = (turn * t).sin_cos();
        // a cos θ + b sin θ, A = a − ib; the last column by ω, over half the record.
        let slope = around.map_or(0.0, |a| (-a.re * s - a.im * c) * t / middle);
        [c, s, 1.0, slope]
    };
    let mut normal = Matrix::zeros(unknowns, unknowns);
    let mut right = Matrix::zeros(unknowns, 1);
    for (j, x) in samples.iter().enumerate() {
        let row = rows(j);
        for (p, a) in row[..unknowns].iter().enumerate() {
            right[(p, 0)] += a * x;
            for (q, b) in row[..unknowns].iter().enumerate() {
                normal[(p, q)] += a * b;
            }
        }
    }
    let found = solve(&normal, &right).map_err(|_| {
        Error::new(
            Code::IllPosed,
            format!("{n} samples do not determine a sine of {frequency_hz} Hz at {rate_hz} Hz"),
        )
    })?;
    let left = |(j, x): (usize, &f64)| {
        let row = rows(j);
        let model: f64 = (0..unknowns).map(|p| row[p] * found[(p, 0)]).sum();
        (x - model).powi(2)
    };
    let square: f64 = samples.iter().enumerate().map(left).sum();
    let fitted = SineFit {
        frequency_hz,
        amplitude: Complex::new(found[(0, 0)], -found[(1, 0)]),
        offset: found[(2, 0)],
        variance: 4.0 * square / (n - unknowns) as f64 / n as f64,
    };
    let change = if unknowns == 4 {
        found[(3, 0)] / middle * rate_hz / TAU
    } else {
        0.0
    };
    Ok((fitted, change))
}

/// Fewer periods are no dwell.
const LEAST_PERIODS: usize = 8;

/// A crossing counts once the signal was below this share of its present size.
const ARMED: f64 = 0.1;

/// The dwells of an input that steps from frequency to frequency: runs of regular upward crossings of its median.
pub fn dwells(input: &[f64], rate_hz: f64) -> Vec<Dwell> {
    let crossings = crossings(input);
    let mut found = Vec::new();
    let mut from = 0;
    while from + LEAST_PERIODS < crossings.len() {
        let mut beat = Beat::new(crossings[from], crossings[from + 1]);
        let later = crossings[from + 2..].iter();
        let run = 1 + later.take_while(|&&at| beat.takes(at)).count();
        if run >= LEAST_PERIODS {
            // The first and the last period may hold a part of the step.
            let range = crossings[from + 1].ceil() as usize..crossings[from + run - 1] as usize;
            found.push(Dwell {
                range,
                frequency_hz: rate_hz / beat.period(),
            });
            from += run;
        } else {
            from += 1;
        }
    }
    found
}

/// A straight line through crossings over their number, kept as what they stray from the first period: `r_i = t_i − t_0 − i p`.
struct Beat {
    start: f64,
    first: f64,
    count: f64,
    /// Sums of r, i r and r².
    sums: [f64; 3],
}

impl Beat {
    fn new(start: f64, next: f64) -> Beat {
        Beat {
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

    /// Adds a crossing, if it comes when the ones before let expect it.
    fn takes(&mut self, at: f64) -> bool {
        let (slope, mean, scatter) = self.line();
        let i = self.count;
        let r = at - self.start - i * self.first;
        let expected = mean + slope * (i - 0.5 * (i - 1.0));
        let most = LOOSEST * self.first;
        let allowed = if self.count < LEAST_PERIODS as f64 {
            most
        } else {
            (SCATTERED * scatter).clamp(TIGHTEST * self.first, most)
        };
        if (r - expected).abs() > allowed {
            return false;
        }
        self.count += 1.0;
        self.sums[0] += r;
        self.sums[1] += i * r;
        self.sums[2] += r * r;
        true
    }
}

/// A crossing ends a dwell when it is off by so many times the scatter of those before …
const SCATTERED: f64 = 6.0;

/// … but by this share of a period at least: interpolation between samples is no better …
const TIGHTEST: f64 = 0.005;

/// … and always by this share.
const LOOSEST: f64 = 0.05;

/// Times, in samples, at which a signal rises through its median.
fn crossings(input: &[f64]) -> Vec<f64> {
    let level = median(input);
    let mut found: Vec<f64> = Vec::new();
    let (mut size, mut is_armed, mut fade) = (0.0_f64, false, 1.0);
    for (j, pair) in input.windows(2).enumerate() {
        let (before, now) = (pair[0] - level, pair[1] - level);
        size = now.abs().max(size * fade);
        if now < -ARMED * size {
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

/// Parts of a dwell whose responses are compared.
const PARTS: usize = 8;

/// A part is settled within this share of the response that the last half shows.
const SETTLED: f64 = 2e-3;

/// Or within so many times their scatter.
const SCATTERS: f64 = 4.0;

/// Frequency responses over the dwells, lines by rising frequency; a frequency dwelt on twice stands there twice. Of each dwell the
/// part counts over which the responses have settled.
///
/// # Errors
/// `NoSignal`: no dwell. As [`fit`].
///
/// # Panics
/// Outputs shorter than the dwells reach: a mistake of the caller.
pub fn stepped(
    rate_hz: f64,
    input: (&Terminal, &[f64]),
    outputs: &[(&Terminal, &[f64])],
    dwells: &[Dwell],
) -> Result<FrequencyResponses, Error> {
    if dwells.is_empty() {
        return Err(Error::new(
            Code::NoSignal,
            format!("the input dwells on no frequency for {LEAST_PERIODS} periods"),
        )
        .hint("estimate with averaged blocks instead"));
    }
    let mut order: Vec<&Dwell> = dwells.iter().collect();
    order.sort_by(|a, b| a.frequency_hz.total_cmp(&b.frequency_hz));
    let mut found = FrequencyResponses {
        frequency_hz: Vec::with_capacity(dwells.len()),
        functions: outputs
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
        usable_hz: None,
        line_independence: None,
    };
    for dwell in order {
        let whole = fit(&input.1[dwell.range.clone()], rate_hz, dwell.frequency_hz)?;
        let mut start = dwell.range.start;
        for (_, output) in outputs {
            start = start.max(settled(
                dwell,
                whole.frequency_hz,
                rate_hz,
                input.1,
                output,
            )?);
        }
        let range = start..dwell.range.end;
        let x = fit(&input.1[range.clone()], rate_hz, whole.frequency_hz)?;
        found.frequency_hz.push(x.frequency_hz);
        for ((_, output), function) in outputs.iter().zip(&mut found.functions) {
            let y = fit_at(&output[range.clone()], rate_hz, x.frequency_hz)?;
            let h = y.amplitude / x.amplitude;
            function.value.push(h);
            if let Some(variance) = &mut function.variance {
                let noise = y.variance + h.norm_sqr() * x.variance;
                variance.push(noise / x.amplitude.norm_sqr());
            }
        }
    }
    Ok(found)
}

/// The sample from which the response of a dwell stays where its last half is.
fn settled(
    dwell: &Dwell,
    frequency_hz: f64,
    rate_hz: f64,
    input: &[f64],
    output: &[f64],
) -> Result<usize, Error> {
    let length = dwell.range.len() / PARTS;
    let mut parts = Vec::with_capacity(PARTS);
    for part in 0..PARTS {
        let start = dwell.range.start + part * length;
        let range = start..start + length;
        let x = fit_at(&input[range.clone()], rate_hz, frequency_hz)?;
        let y = fit_at(&output[range], rate_hz, frequency_hz)?;
        parts.push(y.amplitude / x.amplitude);
    }
    let last = &parts[PARTS / 2..];
    let mean = last.iter().sum::<Complex>() / last.len() as f64;
    let square: f64 = last.iter().map(|h| (h - mean).norm_sqr()).sum();
    let scatter = (square / (last.len() - 1) as f64).sqrt();
    let limit = (SETTLED * mean.norm()).max(SCATTERS * scatter);
    let off = parts.iter().rposition(|h| (h - mean).norm() > limit);
    Ok(dwell.range.start + off.map_or(0, |at| at + 1) * length)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize, f: f64, a: f64, phase: f64) -> Vec<f64> {
        let at = |j: usize| 0.7 + a * (TAU * f * j as f64 + phase).cos();
        (0..n).map(at).collect()
    }

    #[test]
    fn exact_fit_of_four() {
        for f in [0.0123, 0.1, 0.37] {
            let found = fit(&wave(700, f, 2.0, 0.5), 1.0, f + 0.4 / 700.0).unwrap();
            assert!((found.frequency_hz - f).abs() < 1e-14, "{found:?}");
            let phase = TAU * f * 349.5 + 0.5;
            let exact = Complex::new(phase.cos(), phase.sin()) * 2.0;
            assert!((found.amplitude - exact).norm() < 1e-11, "{found:?}");
            assert!((found.offset - 0.7).abs() < 1e-12 && found.variance < 1e-24);
        }
    }

    /// In noise the stated variance of the amplitude is its scatter.
    #[test]
    fn law_variance_of_the_amplitude() {
        let mut rng = fastrand::Rng::with_seed(2);
        let (mut scatter, mut stated) = (0.0, 0.0);
        let exact = Complex::new((TAU * 0.11 * 99.5).cos(), (TAU * 0.11 * 99.5).sin());
        for _ in 0..2000 {
            let noisy: Vec<f64> = wave(200, 0.11, 1.0, 0.0)
                .iter()
                .map(|x| x + rng.f64() - 0.5)
                .collect();
            let found = fit_at(&noisy, 1.0, 0.11).unwrap();
            scatter += (found.amplitude - exact).norm_sqr();
            stated += found.variance;
        }
        assert!((stated / scatter - 1.0).abs() < 0.08, "{stated} {scatter}");
    }

    #[test]
    fn refuses_too_little() {
        assert_eq!(
            fit_at(&[1.0; 3], 1.0, 0.1).unwrap_err().code,
            Code::IllPosed
        );
        assert_eq!(
            fit_at(&[1.0; 30], 1.0, 0.0).unwrap_err().code,
            Code::IllPosed
        );
        assert!(dwells(&[], 1.0).is_empty() && dwells(&[0.0; 100], 1.0).is_empty());
    }
}
