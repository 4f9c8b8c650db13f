//! Harmonics of running speed distinguished from modes by shaft orders and by envelope kurtosis.
//!
//! Noise through a resonance is normally distributed, a sine is not (Brincker, Andersen & Møller, IMAC 18 (2000)). Of the envelope
//! `|z|` of the analytic signal, `E|z|⁴/(E|z|²)²` is 2 for the one and 1 for the other; over N independent values it scatters by `2/√N`.

use super::response_channels::ResponseChannels;
use crate::numeric::Complex;
use crate::numeric::fft::{ComplexFft, next_fast_len};

/// Speeds of the rotating shafts and their orders that may be excited.
#[derive(Debug, Clone, PartialEq)]
pub struct RunningSpeed {
    /// Speed of the shaft, Hz.
    pub speed_hz: f64,
    /// Orders of it, such as 1, 2 and a tooth number.
    pub orders: Vec<f64>,
    /// Half width about each order within which a frequency is taken for it, relative: how far the speed strays.
    pub tolerance: f64,
}

impl RunningSpeed {
    /// The order that a frequency, Hz, lies on.
    pub fn order(&self, frequency_hz: f64) -> Option<f64> {
        let is_near = |order: &&f64| {
            let line = *order * self.speed_hz;
            (frequency_hz - line).abs() <= self.tolerance * line
        };
        self.orders.iter().find(is_near).copied()
    }
}

/// Evidence that a frequency is a line of running speed.
#[derive(Debug, Clone, PartialEq)]
pub struct HarmonicIndicator {
    /// `E|z|⁴/(E|z|²)²` of the envelope: 2 for noise through a resonance, 1 for a sine.
    pub envelope_kurtosis: f64,
    /// Standard deviation the kurtosis would have were it noise.
    pub scatter: f64,
    /// The order of the running speed it lies on.
    pub order: Option<f64>,
}

impl HarmonicIndicator {
    /// On a known order, or nearer to a sine than to noise by more than chance.
    pub fn is_harmonic(&self) -> bool {
        self.order.is_some() || self.is_sine()
    }

    /// Nearer to a sine than to noise by more than chance. A resonance that the record hardly resolves keeps its amplitude for most of
    /// it: of so few independent values nothing is said.
    pub fn is_sine(&self) -> bool {
        const MAX_SINE_KURTOSIS: f64 = 1.5; // half way
        const SIGNIFICANCE_SIGMA: f64 = 3.0; // standard deviations
        const UNDECIDED: f64 = 0.6; // the scatter of eleven independent values
        // What is above 1 scatters by a factor: of few values it can be small, never below nothing.
        let noise = 1.0 + (-SIGNIFICANCE_SIGMA * self.scatter).exp();
        self.scatter < UNDECIDED && self.envelope_kurtosis < noise.min(MAX_SINE_KURTOSIS)
    }
}

/// Half width of the band about a mode whose distribution is looked at, in half-power half-bandwidths…
pub const KURTOSIS_HALF_BANDWIDTHS: f64 = 3.0;

/// … and in lines of the whole record.
pub const LINES: f64 = 20.0;

/// Samples looked at, from the first on: more tell no distribution better.
const MAX_SAMPLES: usize = 1 << 21;

/// Spectra of whole responses, from which bands are cut.
#[derive(Debug, Clone)]
pub struct BandSpectra {
    spectra: Vec<Vec<Complex>>,
    spacing_hz: f64,
    samples: usize,
}

impl BandSpectra {
    /// One transform of each whole channel.
    pub fn new(channels: &ResponseChannels) -> BandSpectra {
        BandSpectra::from_signals(channels.samples(), channels.rate_hz())
    }

    /// One transform of each signal; they are of one length.
    pub fn from_signals(channels: &[&[f64]], rate_hz: f64) -> BandSpectra {
        let n = channels.first().map_or(0, |s| s.len()).min(MAX_SAMPLES);
        let length = next_fast_len(n);
        let mut transform = ComplexFft::new(length);
        let spectra = (channels.iter())
            .map(|samples| {
                let mean = samples[..n].iter().sum::<f64>() / n as f64;
                let mut values = vec![Complex::new(0.0, 0.0); length];
                for (z, x) in values.iter_mut().zip(&samples[..n]) {
                    z.re = x - mean;
                }
                transform.forward(&mut values);
                values.truncate(length / 2 + 1);
                values
            })
            .collect();
        BandSpectra {
            spectra,
            spacing_hz: rate_hz / length as f64,
            samples: n,
        }
    }

    /// Looks at the band `frequency_hz ± half_band_hz` of one channel, and at the orders of what turns.
    pub fn examine_band(
        &self,
        channel: usize,
        frequency_hz: f64,
        half_band_hz: f64,
        running: Option<&RunningSpeed>,
    ) -> HarmonicIndicator {
        let envelope = self.envelope_kurtosis(channel, frequency_hz, half_band_hz);
        let (envelope_kurtosis, scatter) = envelope.unwrap_or((2.0, f64::INFINITY));
        HarmonicIndicator {
            envelope_kurtosis,
            scatter,
            order: running.and_then(|r| r.order(frequency_hz)),
        }
    }

    /// Kurtosis and the scatter chance gives it; nothing for a band without lines.
    fn envelope_kurtosis(&self, channel: usize, centre: f64, half: f64) -> Option<(f64, f64)> {
        let spectrum = self.spectra.get(channel)?;
        let first = ((centre - half) / self.spacing_hz).ceil().max(1.0) as usize;
        let last = ((centre + half) / self.spacing_hz).floor() as usize;
        let band = spectrum.get(first..(last + 1).min(spectrum.len()))?;
        // The band moved to zero frequency; twice as many values as lines hold |z|² without aliasing.
        let mut values = vec![Complex::new(0.0, 0.0); next_fast_len(2 * band.len().max(2))];
        values[..band.len()].copy_from_slice(band);
        let length = values.len();
        ComplexFft::new(length).inverse(&mut values);
        // Padding behind the record holds no signal.
        let kept = length * self.samples / next_fast_len(self.samples);
        let powers: Vec<f64> = values[..kept.clamp(1, length)]
            .iter()
            .map(|z| z.norm_sqr())
            .collect();
        let n = powers.len() as f64;
        let mean = powers.iter().sum::<f64>() / n;
        let square = powers.iter().map(|p| p * p).sum::<f64>() / n;
        // Values independent of each other: n/2 by bandwidth, fewer where the power within the band is bunched.
        let mut related = 0.0;
        for lag in 1..powers.len() / 2 {
            let product: f64 = powers
                .iter()
                .zip(&powers[lag..])
                .map(|(a, b)| (a - mean) * (b - mean))
                .sum();
            let correlation = product / n / (square - mean * mean).max(f64::MIN_POSITIVE);
            if correlation < 0.05 {
                break;
            }
            related += correlation;
        }
        let independent = n / (1.0 + 2.0 * related);
        (mean > 0.0).then(|| (square / (mean * mean), 2.0 / independent.sqrt()))
    }
}
