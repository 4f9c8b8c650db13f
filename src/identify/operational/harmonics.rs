//! Harmonic indicators: distinction of running-speed harmonics from modes by shaft order and envelope kurtosis `E|z|⁴/(E|z|²)²`.
//!
//! The random response of a mode is normally distributed, a sine is not (Brincker, Andersen & Møller, IMAC 18 (2000)). The kurtosis of the
//! envelope `|z|` of the analytic signal is 2 for a mode and 1 for a sine, with standard deviation `2/√N` over N independent values.

use super::response_channels::ResponseChannels;
use crate::numeric::Complex;
use crate::numeric::fft::{ComplexFft, next_fast_len};

/// Running speed of a shaft with the orders that may be excited.
#[derive(Debug, Clone, PartialEq)]
pub struct RunningSpeed {
    /// Speed of the shaft, Hz.
    pub speed_hz: f64,
    /// Shaft orders, such as 1, 2 and a tooth number.
    pub orders: Vec<f64>,
    /// Relative half width of the band of each order: the speed variation.
    pub tolerance: f64,
}

impl RunningSpeed {
    /// Order whose band contains a frequency, Hz; `None` if there is none.
    pub fn order(&self, frequency_hz: f64) -> Option<f64> {
        let is_near = |order: &&f64| {
            let line = *order * self.speed_hz;
            (frequency_hz - line).abs() <= self.tolerance * line
        };
        self.orders.iter().find(is_near).copied()
    }
}

/// Evidence that a frequency is a harmonic of the running speed.
#[derive(Debug, Clone, PartialEq)]
pub struct HarmonicIndicator {
    /// Envelope kurtosis `E|z|⁴/(E|z|²)²`: 2 for the random response of a mode, 1 for a sine.
    pub envelope_kurtosis: f64,
    /// Standard deviation of the kurtosis for a random response.
    pub scatter: f64,
    /// Order of the running speed at the frequency.
    pub order: Option<f64>,
}

impl HarmonicIndicator {
    /// Whether the frequency is at a known order or the response is significantly sinusoidal.
    pub fn is_harmonic(&self) -> bool {
        self.order.is_some() || self.is_sine()
    }

    /// Whether the kurtosis is significantly below that of a random response. False with too few independent values: a mode barely
    /// resolved by the record has an almost constant amplitude.
    pub fn is_sine(&self) -> bool {
        const MAX_SINE_KURTOSIS: f64 = 1.5; // midway between sine and random response
        const SIGNIFICANCE_SIGMA: f64 = 3.0; // standard deviations
        const MAX_SCATTER: f64 = 0.6; // standard deviation with eleven independent values
        // The excess over 1 is positive, so its confidence limit is multiplicative.
        let random_limit = 1.0 + (-SIGNIFICANCE_SIGMA * self.scatter).exp();
        self.scatter < MAX_SCATTER && self.envelope_kurtosis < random_limit.min(MAX_SINE_KURTOSIS)
    }
}

/// Half width of the band of the envelope kurtosis about a mode, in half-power half-bandwidths.
pub const KURTOSIS_HALF_BANDWIDTHS: f64 = 3.0;

/// Minimum half width of this band, in spectral lines of the full record.
pub const BAND_LINES: f64 = 20.0;

/// Maximum number of samples evaluated, from the first on; more do not improve the decision.
const MAX_SAMPLES: usize = 1 << 21;

/// Spectra of full-length responses, from which bands are extracted.
#[derive(Debug, Clone)]
pub struct BandSpectra {
    spectra: Vec<Vec<Complex>>,
    spacing_hz: f64,
    samples: usize,
}

impl BandSpectra {
    /// Spectra of the full length of each channel.
    pub fn new(channels: &ResponseChannels) -> BandSpectra {
        BandSpectra::from_signals(channels.samples(), channels.rate_hz())
    }

    /// Spectra of signals of equal length, sampled at `rate_hz`, Hz.
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

    /// Harmonic indicator of the band `frequency_hz ± half_band_hz` of one channel.
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

    /// Envelope kurtosis of a band and its standard deviation; `None` for a band without lines.
    fn envelope_kurtosis(&self, channel: usize, centre: f64, half: f64) -> Option<(f64, f64)> {
        let spectrum = self.spectra.get(channel)?;
        let first = ((centre - half) / self.spacing_hz).ceil().max(1.0) as usize;
        let last = ((centre + half) / self.spacing_hz).floor() as usize;
        let band = spectrum.get(first..(last + 1).min(spectrum.len()))?;
        // The band is shifted to zero frequency; twice as many values as lines represent |z|² without aliasing.
        let mut values = vec![Complex::new(0.0, 0.0); next_fast_len(2 * band.len().max(2))];
        values[..band.len()].copy_from_slice(band);
        let length = values.len();
        ComplexFft::new(length).inverse(&mut values);
        // Values of the zero padding after the record are discarded.
        let n_valid = length * self.samples / next_fast_len(self.samples);
        let powers: Vec<f64> = values[..n_valid.clamp(1, length)]
            .iter()
            .map(|z| z.norm_sqr())
            .collect();
        let n = powers.len() as f64;
        let mean = powers.iter().sum::<f64>() / n;
        let square = powers.iter().map(|p| p * p).sum::<f64>() / n;
        // Effective number of independent values: n/2 by bandwidth, fewer with power concentrated within the band.
        let mut correlations = 0.0;
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
            correlations += correlation;
        }
        let independent = n / (1.0 + 2.0 * correlations);
        (mean > 0.0).then(|| (square / (mean * mean), 2.0 / independent.sqrt()))
    }
}
