//! Window functions `w_j` (periodic), their gains and correlations (Harris 1978).
//!
//! Harris, On the use of windows for harmonic analysis with the discrete Fourier transform, Proc. IEEE 66 (1978), pp. 51–83.

use std::f64::consts::{PI, TAU};

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;

/// Window applied to a block before it is transformed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Window {
    /// Unit weight: for transients inside the block, and signals periodic in it.
    Rectangular,
    /// `½ − ½ cos z`, `z = 2πj/n`: standard for random signals.
    Hann,
    /// `0.54 − 0.46 cos z`.
    Hamming,
    /// Five cosine terms, flat within 0.01 dB over one line spacing: for amplitudes of tones.
    FlatTop,
    /// Four cosine terms, side lobes below −92 dB: for weak tones next to strong ones.
    BlackmanHarris,
    /// `I₀(β √(1 − x²))/I₀(β)`, `x = 2j/n − 1`: side lobes fall as β rises.
    Kaiser(f64),
    /// Unit weight over this share of the block, then zero: for the force pulse of a hit at its beginning.
    Force(f64),
    /// Exponential `exp(−σt)` with this value at the end of the block: for responses that have not decayed there.
    Exponential(f64),
}

/// Terms of the Hamming window as its author rounded them, `a₀ − a₁ cos z`.
const HAMMING: [f64; 2] = [0.54, 0.46];

/// D'Antona & Ferrero, Digital Signal Processing for Measurement Systems (2006); ISO 18431-2 states them rounded and divided by `a₀`.
const FLAT_TOP: [f64; 5] = [
    0.21557895,
    0.41663158,
    0.277263158,
    0.083578947,
    0.006947368,
];

/// Harris (1978), table I, the four-term window of minimum side lobes.
const BLACKMAN_HARRIS: [f64; 4] = [0.35875, 0.48829, 0.14128, 0.01168];

/// Maximum β of a Kaiser window; beyond it the window is a spike, and `I₀(β)` approaches overflow.
const MAX_BETA: f64 = 500.0;

impl Window {
    /// Parses a window name: `rectangular`, `hann`, `hamming`, `flat-top`, `blackman-harris`, `kaiser:8.6` (β), `force:0.1`
    /// (share of the block), `exponential:0.01` (value at the end of the block).
    ///
    /// # Errors
    /// `Usage` for an unknown name; `OutOfRange` for an invalid parameter.
    pub fn parse(word: &str) -> Result<Window, Error> {
        let (name, number) = match word.split_once(':') {
            Some((name, text)) => (name, Some(text)),
            None => (word, None),
        };
        let parameter = |quantity: &str| {
            number
                .and_then(|text| text.parse::<f64>().ok())
                .ok_or_else(|| {
                    Error::new(
                        Code::Usage,
                        format!("window `{word}` lacks its {quantity}, a number after a colon"),
                    )
                    .with_hint(format!("for example `{name}:{}`", example(name)))
                })
        };
        let window = match name {
            "kaiser" => Window::Kaiser(parameter("β")?),
            "force" => Window::Force(parameter("share of the block")?),
            "exponential" => Window::Exponential(parameter("value at the end of the block")?),
            _ => {
                let plain = [
                    Window::Rectangular,
                    Window::Hann,
                    Window::Hamming,
                    Window::FlatTop,
                    Window::BlackmanHarris,
                ];
                let candidate = plain.into_iter().find(|w| w.name() == name);
                candidate.filter(|_| number.is_none()).ok_or_else(|| {
                    Error::new(Code::Usage, format!("`{word}` is not a window")).with_hint(
                        "rectangular, hann, hamming, flat-top, blackman-harris, kaiser:β, force:share or exponential:end",
                    )
                })?
            }
        };
        window.check()?;
        Ok(window)
    }

    /// Name as accepted by [`Window::parse`].
    pub fn name(self) -> String {
        match self {
            Window::Rectangular => "rectangular".into(),
            Window::Hann => "hann".into(),
            Window::Hamming => "hamming".into(),
            Window::FlatTop => "flat-top".into(),
            Window::BlackmanHarris => "blackman-harris".into(),
            Window::Kaiser(beta) => format!("kaiser:{beta}"),
            Window::Force(share) => format!("force:{share}"),
            Window::Exponential(end) => format!("exponential:{end}"),
        }
    }

    /// Checks the parameter of the window.
    ///
    /// # Errors
    /// `OutOfRange` for an invalid parameter.
    pub fn check(self) -> Result<(), Error> {
        let (is_valid, range) = match self {
            Window::Kaiser(beta) => ((0.0..=MAX_BETA).contains(&beta), "choose β from 0 to 500"),
            Window::Force(share) => (
                share > 0.0 && share <= 1.0,
                "choose a share above 0 and at most 1",
            ),
            Window::Exponential(end) => (
                end > 0.0 && end <= 1.0,
                "choose an end value above 0 and at most 1",
            ),
            _ => (true, ""),
        };
        if is_valid {
            return Ok(());
        }
        Err(Error::new(
            Code::OutOfRange,
            format!("invalid parameter of window `{}`", self.name()),
        )
        .with_hint(range))
    }

    /// Samples of the window, `n` of them.
    pub fn samples(self, n: usize) -> Vec<f64> {
        let sample = |f: &dyn Fn(f64) -> f64| (0..n).map(|j| f(j as f64 / n as f64)).collect();
        match self {
            Window::Rectangular => vec![1.0; n],
            Window::Hann => sample(&|x| (PI * x).sin().powi(2)),
            Window::Hamming => sample(&|x| cosines(&HAMMING, x)),
            Window::FlatTop => sample(&|x| cosines(&FLAT_TOP, x)),
            Window::BlackmanHarris => sample(&|x| cosines(&BLACKMAN_HARRIS, x)),
            // 1 − (2x − 1)² = 4x (1 − x)
            Window::Kaiser(beta) => {
                sample(&|x| bessel_i0(2.0 * beta * (x * (1.0 - x)).sqrt()) / bessel_i0(beta))
            }
            Window::Force(share) => sample(&|x| f64::from(u8::from(x < share))),
            Window::Exponential(end) => sample(&|x| (x * end.ln()).exp()),
        }
    }

    /// Decay rate σ, 1/s, of the `exp(−σt)` by which the window multiplies a response in blocks of `duration_s`, s: the real part of an
    /// identified pole is biased by `−σ`, its damping ratio by `σ/ω`.
    pub fn decay_rate(self, duration_s: f64) -> f64 {
        match self {
            Window::Exponential(end) => -end.ln() / duration_s,
            _ => 0.0,
        }
    }
}

/// Example of a window parameter.
fn example(name: &str) -> &'static str {
    match name {
        "kaiser" => "8.6",
        "force" => "0.1",
        _ => "0.01",
    }
}

/// Cosine sum `Σ (−1)^m a_m cos(2πmx)`.
fn cosines(a: &[f64], x: f64) -> f64 {
    let term = |(m, a): (usize, &f64)| {
        let sign = if m % 2 == 0 { 1.0 } else { -1.0 };
        sign * a * (TAU * m as f64 * x).cos()
    };
    a.iter().enumerate().map(term).sum()
}

/// Modified Bessel function `I₀(x) = Σ ((x/2)^m/m!)²`; all terms are positive, so no digits cancel.
pub fn bessel_i0(x: f64) -> f64 {
    let (mut sum, mut term, mut m) = (1.0, 1.0, 1.0);
    while term > f64::EPSILON * sum {
        term *= (0.5 * x / m).powi(2);
        sum += term;
        m += 1.0;
    }
    sum
}

/// Gains of a window for tones and for noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WindowGains {
    /// Coherent gain `Σw/n`, the factor on the amplitude of a tone.
    pub coherent: f64,
    /// Energy gain `Σw²/n`, the factor on the mean square of noise.
    pub energy: f64,
    /// Equivalent noise bandwidth `n Σw²/(Σw)²`, in lines of `rate/n`.
    pub bandwidth_lines: f64,
}

/// Gains of a window from its samples.
pub fn window_gains(w: &[f64]) -> WindowGains {
    let n = w.len() as f64;
    let coherent = w.iter().sum::<f64>() / n;
    let energy = w.iter().map(|w| w * w).sum::<f64>() / n;
    WindowGains {
        coherent,
        energy,
        bandwidth_lines: energy / (coherent * coherent),
    }
}

/// Leakage `|W(d)|²/|W(0)|²`: power of a tone at a distance of `d` lines relative to that on the line; independent of long lengths.
pub fn leakage(w: &[f64], d: f64) -> f64 {
    let n = w.len() as f64;
    let term = |(j, w): (usize, &f64)| {
        let (s, c) = (TAU * d * j as f64 / n).sin_cos();
        Complex::new(c, -s) * w
    };
    let transform: Complex = w.iter().enumerate().map(term).sum();
    transform.norm_sqr() / w.iter().sum::<f64>().powi(2)
}

/// Correlation of the powers of two blocks of white noise offset by `lag` samples: `(Σ w_j w_{j+lag} / Σ w²)²`.
///
/// Welch, The use of fast Fourier transform for the estimation of power spectra, IEEE Trans. Audio Electroacoust. 15 (1967), pp. 70–73.
pub fn overlap_correlation(w: &[f64], lag: usize) -> f64 {
    let covariance: f64 = w.iter().zip(w.iter().skip(lag)).map(|(a, b)| a * b).sum();
    (covariance / w.iter().map(|w| w * w).sum::<f64>()).powi(2)
}

/// Standard deviation δ of the spectral smearing by a window, weighted by `|W|²`, in lines.
///
/// The autocorrelation r of the window, the transform of `|W|²`, falls as `1 − (2πδτ)²/2`. δ is computed from r at a lag of an eighth of the
/// block, about where a resonance of several lines has decayed, since r of a window with steps at its ends falls linearly in τ at first.
/// The Hann window has 0.56, and `1/√3` in the limit of τ = 0.
pub fn smearing_lines(w: &[f64]) -> f64 {
    const LAG_SHARE: usize = 8;
    let fall = 1.0 - overlap_correlation(w, w.len() / LAG_SHARE).sqrt();
    (2.0 * fall).sqrt() * LAG_SHARE as f64 / TAU
}

/// Correlation `E[X_k* X_{k+m}]/E|X_k|²` of the transform of windowed white noise between lines `m` apart: `Σ w² exp(−2πi mj/n)/Σ w²`.
pub fn line_correlation(w: &[f64], m: usize) -> Complex {
    let n = w.len();
    let term = |(j, w): (usize, &f64)| {
        let (s, c) = (TAU * (j * m % n) as f64 / n as f64).sin_cos();
        Complex::new(c, -s) * (w * w)
    };
    w.iter().enumerate().map(term).sum::<Complex>() / w.iter().map(|w| w * w).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hann: `r(τ) = (1 − τ)(2 + cos 2πτ)/3 + sin(2πτ)/2π` at an eighth of the block.
    #[test]
    fn exact_smearing_of_hann() {
        let w = Window::Hann.samples(4096);
        let r = 7.0 / 8.0 * (2.0 + 0.5_f64.sqrt()) / 3.0 + 0.5_f64.sqrt() / TAU;
        let expected = (2.0 * (1.0 - r)).sqrt() * 8.0 / TAU;
        assert_close(smearing_lines(&w), expected, 1e-6);
    }

    fn assert_close(a: f64, b: f64, tolerance: f64) {
        assert!((a - b).abs() <= tolerance * b.abs(), "{a} is not {b}");
    }

    /// Sums of cosines: mean a₀, mean square a₀² + ½ Σ a_m², any n above twice the number of terms.
    #[test]
    fn exact_gains_of_cosine_sums() {
        let cases: [(Window, &[f64]); 4] = [
            (Window::Hann, &[0.5, 0.5]),
            (Window::Hamming, &HAMMING),
            (Window::FlatTop, &FLAT_TOP),
            (Window::BlackmanHarris, &BLACKMAN_HARRIS),
        ];
        for (window, a) in cases {
            for n in [16, 17, 1000] {
                let gains = window_gains(&window.samples(n));
                let energy = a[0] * a[0] + 0.5 * a[1..].iter().map(|a| a * a).sum::<f64>();
                assert_close(gains.coherent, a[0], 1e-14);
                assert_close(gains.energy, energy, 1e-14);
                assert_close(gains.bandwidth_lines, energy / (a[0] * a[0]), 1e-14);
            }
        }
        assert_close(
            window_gains(&Window::Hann.samples(64)).bandwidth_lines,
            1.5,
            1e-14,
        );
    }

    /// Kaiser: the mean tends to sinh β/(β I₀(β)), with the error of a trapezium rule, O(n⁻²).
    #[test]
    fn exact_gain_of_kaiser() {
        for beta in [2.0_f64, 8.6, 20.0] {
            let exact = beta.sinh() / beta / bessel_i0(beta);
            assert_close(
                window_gains(&Window::Kaiser(beta).samples(100_000)).coherent,
                exact,
                1e-8,
            );
        }
        assert_eq!(Window::Kaiser(0.0).samples(5), [1.0; 5]);
    }

    /// Gains by geometric sums, and the decay rate of the exponential window.
    #[test]
    fn exact_force_and_exponential() {
        let (n, end) = (500, 0.01_f64);
        let gains = window_gains(&Window::Exponential(end).samples(n));
        let sum = |q: f64| (1.0 - q.powi(n as i32)) / (1.0 - q) / n as f64;
        let q = end.powf(1.0 / n as f64);
        assert_close(gains.coherent, sum(q), 1e-12);
        assert_close(gains.energy, sum(q * q), 1e-12);
        assert_close(
            Window::Exponential(end).decay_rate(0.5),
            9.210340371976184,
            1e-15,
        );
        let gains = window_gains(&Window::Force(0.1).samples(n));
        assert_close(gains.coherent, 0.1, 1e-14);
        assert_close(gains.bandwidth_lines, 10.0, 1e-14);
    }

    /// Hann window at half overlap: (1/6)²; lines one apart −2/3, two apart 1/6.
    #[test]
    fn exact_correlations_of_hann() {
        let w = Window::Hann.samples(64);
        assert_close(overlap_correlation(&w, 32), 1.0 / 36.0, 1e-13);
        assert_eq!(overlap_correlation(&w, 64), 0.0);
        assert!((line_correlation(&w, 1) + 2.0 / 3.0).norm() < 1e-14);
        assert!((line_correlation(&w, 2) - 1.0 / 6.0).norm() < 1e-14);
        assert!(line_correlation(&w, 3).norm() < 1e-14);
    }

    #[test]
    fn exact_words_there_and_back() {
        for word in [
            "rectangular",
            "hann",
            "hamming",
            "flat-top",
            "blackman-harris",
            "kaiser:8.6",
            "force:0.1",
            "exponential:0.01",
        ] {
            assert_eq!(Window::parse(word).unwrap().name(), word);
        }
    }

    #[test]
    fn refuses_words_and_numbers() {
        for (word, code) in [
            ("hanning", Code::Usage),
            ("hann:3", Code::Usage),
            ("kaiser", Code::Usage),
            ("kaiser:-1", Code::OutOfRange),
            ("kaiser:nan", Code::OutOfRange),
            ("force:0", Code::OutOfRange),
            ("exponential:1.5", Code::OutOfRange),
        ] {
            assert_eq!(Window::parse(word).unwrap_err().code, code, "{word}");
        }
    }
}
