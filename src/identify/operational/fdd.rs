//! Frequency-domain decomposition (FDD, EFDD): singular values of the spectral matrix `S(f) = U Σ Uᴴ`, damping from the SDOF bell.
//!
//! The spectral matrix of the responses is decomposed line by line (Brincker, Zhang & Andersen, Smart Mater. Struct. 10 (2001)); damping
//! follows from the decay of the autocovariance of the SDOF bell at each peak (Brincker, Ventura & Andersen, IMAC 19 (2001)).
//!
//! The inverse transform of the bell `φᴴ S(f) φ` is a complex autocovariance `R(τ) ∝ exp(−ζωτ + iω_d τ)`; linear regression of its
//! logarithmic modulus and phase gives damping and frequency. R is divided by the autocovariance of the window, so that short segments
//! do not bias the damping.

use std::f64::consts::TAU;

use super::harmonics::{BandSpectra, HarmonicIndicator, RunningSpeed};
use super::response_channels::ResponseChannels;
use super::significant_peaks::{ProminentPeak, significant_peaks};
use super::spectral_matrix::SpectralMatrix;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::parabola::log_vertex;
use crate::numeric::{Complex, symmetric};

/// Options of frequency-domain decomposition.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FddOptions {
    /// Segment length, samples; `None`: the power of two below a tenth of the record.
    pub segment: Option<usize>,
    /// Frequency band of the peak search, Hz; `None`: all lines.
    pub band_hz: Option<(f64, f64)>,
    /// Running speed of the rotating shafts.
    pub running_speed: Option<RunningSpeed>,
}

/// Peak of the largest singular value.
#[derive(Debug, Clone)]
pub struct FddPeak {
    /// Peak frequency, Hz: vertex of a parabola through the logarithms of three lines.
    pub frequency_hz: f64,
    /// Ratio of the peak density to that of the higher adjacent valley, both averaged over the width of the peak.
    pub prominence: f64,
    /// Mode shape over the channels, normalised to a largest component of 1.
    pub shape: Vec<Complex>,
    /// SDOF bell of lines with the shape of the peak; `None` with fewer than five lines.
    pub bell: Option<SdofBell>,
    /// Mode with the pole of the bell and the same shape, without covariance; `None` without a decaying bell.
    pub mode: Option<ModalParameters>,
    /// Evidence that the peak is a harmonic of the running speed.
    pub harmonic: HarmonicIndicator,
}

/// SDOF bell with the decay of its autocovariance.
#[derive(Debug, Clone, PartialEq)]
pub struct SdofBell {
    /// Frequencies of the lines, Hz, in ascending order, with `φᴴ S φ`.
    pub lines: Vec<(f64, f64)>,
    /// Lags, s, with the modulus of the autocovariance relative to lag 0, corrected for the window.
    pub decay: Vec<(f64, f64)>,
    /// Pole, rad/s, from the regression of logarithm and phase, and the regressed logarithm at lag 0.
    pub pole: Option<(Complex, f64)>,
}

/// Singular values of the spectral matrix with their peaks.
#[derive(Debug, Clone)]
pub struct FddEstimate {
    /// Frequencies of the lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// Singular values of each line in descending order, product of the response units per Hz.
    pub singular_values: Vec<Vec<f64>>,
    /// Peaks in ascending order of frequency.
    pub peaks: Vec<FddPeak>,
}

impl FddEstimate {
    /// Frequencies of the lines, Hz, with the largest singular value of each.
    pub fn largest_values(self) -> (Vec<f64>, Vec<f64>) {
        let first = self.singular_values.iter().map(|v| v[0]).collect();
        (self.frequency_hz, first)
    }
}

/// Minimum MAC of the singular vectors of the bell with that of the peak (Brincker et al.).
const MIN_MAC: f64 = 0.8;

/// Lower limit of the bell relative to its peak; below it neighbouring modes dominate.
const BELL_FLOOR: f64 = 1e-2;

/// Upper and lower limit of the normalised autocovariance in the regression.
pub const DECAY_RANGE: (f64, f64) = (0.95, 0.3);

/// Normalised autocovariance at which the decay ends.
const DECAY_END: f64 = 0.1;

/// Half width of the band of the envelope kurtosis, in units of the frequency resolution.
const KURTOSIS_HALF_BAND_LINES: f64 = 2.0;

/// Estimates modes from output-only responses by frequency-domain decomposition.
///
/// # Errors
/// `TooShort` where fewer than two segments fit; `OutOfRange` for a band with fewer than three lines; errors of the eigenproblems.
pub fn fdd(channels: &ResponseChannels, options: &FddOptions) -> Result<FddEstimate, Error> {
    let spectra = SpectralMatrix::new(channels, options.segment)?;
    let mut values = Vec::with_capacity(spectra.lines.len());
    let mut vectors = Vec::with_capacity(spectra.lines.len());
    for line in &spectra.lines {
        let (mut result, columns) = symmetric::hermitian_eigen(line)?;
        vectors.push(columns.col_as_slice(result.len() - 1).to_vec());
        result.reverse();
        values.push(result);
    }
    let first: Vec<f64> = values.iter().map(|v| v[0].max(f64::MIN_POSITIVE)).collect();
    let bells = BellSearch {
        spectra: &spectra,
        first: &first,
        vectors: &vectors,
        rate_hz: channels.rate_hz(),
    };
    let result = bells.peaks(options.band_hz)?;
    let bands = BandSpectra::new(channels);
    let peaks = (0..result.len())
        .map(|k| bells.describe_peak(&result, k, &bands, options))
        .collect();
    Ok(FddEstimate {
        frequency_hz: (0..first.len())
            .map(|k| k as f64 * spectra.line_spacing_hz)
            .collect(),
        singular_values: values,
        peaks,
    })
}

struct BellSearch<'a> {
    spectra: &'a SpectralMatrix,
    first: &'a [f64],
    vectors: &'a [Vec<Complex>],
    rate_hz: f64,
}

impl BellSearch<'_> {
    fn peaks(&self, band_hz: Option<(f64, f64)>) -> Result<Vec<ProminentPeak>, Error> {
        let s = self.first;
        let spacing = self.spectra.line_spacing_hz;
        // Lines next to zero frequency contain the residual of the mean.
        let lowest = 4;
        let (from, to) = match band_hz {
            None => (lowest, s.len().saturating_sub(1)),
            Some((a, b)) => {
                let to = (b / spacing).floor().min(s.len() as f64 - 1.0) as usize;
                (((a / spacing).ceil() as usize).max(lowest), to)
            }
        };
        if from + 2 > to {
            return Err(Error::new(
                Code::OutOfRange,
                format!(
                    "the band has too few lines for peaks: lines {from} to {to} of {}, {spacing} Hz apart",
                    s.len()
                ),
            )
            .with_hint("widen the band, or take longer segments"));
        }
        let scatter = self.scatter(from, to);
        let result = significant_peaks(s, from..to + 1, 2.0 / (scatter * scatter));
        Ok(result)
    }

    /// Standard deviation of the log density: `1/√averages`, or the larger value from the median difference of lines two resolution widths
    /// apart if the responses are not stationary, such as after impacts.
    fn scatter(&self, from: usize, to: usize) -> f64 {
        const INDEPENDENT_LINES: usize = 4; // padded lines lie at half the resolution
        const MEDIAN_DIFFERENCE_TO_STD: f64 = 0.6745 * std::f64::consts::SQRT_2; // median of |difference| over the standard deviation
        // The effective number of averages of half-overlapping Hann segments is 0.95 of their number (Welch 1967).
        let by_averages = 1.0 / (self.spectra.averages as f64 * 0.95).max(1.0).sqrt();
        let mut differences: Vec<f64> = (from..=to.saturating_sub(INDEPENDENT_LINES))
            .map(|k| {
                (self.first[k + INDEPENDENT_LINES] / self.first[k])
                    .ln()
                    .abs()
            })
            .collect();
        differences.sort_by(f64::total_cmp);
        let median = differences
            .get(differences.len() / 2)
            .copied()
            .unwrap_or(0.0);
        by_averages.max(median / MEDIAN_DIFFERENCE_TO_STD)
    }

    fn describe_peak(
        &self,
        result: &[ProminentPeak],
        k: usize,
        bands: &BandSpectra,
        options: &FddOptions,
    ) -> FddPeak {
        let ProminentPeak { line, prominence } = result[k];
        let spacing = self.spectra.line_spacing_hz;
        let frequency_hz = (line as f64 + self.peak_offset(line)) * spacing;
        let (mut shape, mut strongest) = (self.vectors[line].clone(), 0);
        for (c, x) in shape.iter().enumerate() {
            if x.norm_sqr() > shape[strongest].norm_sqr() {
                strongest = c;
            }
        }
        let largest = shape[strongest];
        shape.iter_mut().for_each(|x| *x /= largest);
        let bell = self.bell(line).map(|lines| self.decay(&lines));
        let estimate = bell.as_ref().and_then(|bell| bell.pole);
        let mode = estimate.map(|(pole, _)| ModalParameters {
            pole,
            pole_covariance: None,
            shape: shape.clone(),
        });
        let half_band = KURTOSIS_HALF_BAND_LINES * 2.0 * spacing; // lines lie at half the resolution
        FddPeak {
            frequency_hz,
            prominence,
            bell,
            mode,
            harmonic: bands.examine_band(
                strongest,
                frequency_hz,
                half_band,
                options.running_speed.as_ref(),
            ),
            shape,
        }
    }

    /// Offset of a peak from its line, from −½ to ½ of the line spacing.
    fn peak_offset(&self, line: usize) -> f64 {
        let values = [line - 1, line, line + 1].map(|k| self.first[k]);
        log_vertex(values).0.clamp(-0.5, 0.5)
    }

    /// Lines about the peak with its shape, with `φᴴ S φ`; `None` with fewer than five.
    fn bell(&self, line: usize) -> Option<Vec<(usize, f64)>> {
        let shape = &self.vectors[line];
        let density = |k: usize| -> f64 {
            let s = &self.spectra.lines[k];
            (0..shape.len())
                .flat_map(|i| (0..shape.len()).map(move |j| (i, j)))
                .map(|(i, j)| (shape[i].conj() * s[(i, j)] * shape[j]).re)
                .sum()
        };
        let is_alike = |k: usize| {
            let product: Complex = shape
                .iter()
                .zip(&self.vectors[k])
                .map(|(a, b)| a.conj() * b)
                .sum();
            product.norm_sqr() >= MIN_MAC
        };
        let floor = self.first[line] * BELL_FLOOR;
        let flank = |lines: &mut dyn Iterator<Item = usize>| {
            let mut bell = Vec::new();
            let mut lowest = f64::INFINITY;
            for k in lines {
                let value = density(k);
                // Random fluctuation may raise the falling flank, but not double it: that is the next mode.
                if !is_alike(k) || value < floor || value > 2.0 * lowest {
                    break;
                }
                lowest = lowest.min(value);
                bell.push((k, value));
            }
            bell
        };
        let mut bell = flank(&mut (1..line).rev());
        bell.reverse();
        bell.push((line, density(line)));
        bell.extend(flank(&mut (line + 1..self.first.len() - 1)));
        (bell.len() >= 5).then_some(bell)
    }

    /// Bell with the decay of its autocovariance and its pole; without pole if the decay is too short within half a segment.
    fn decay(&self, bell: &[(usize, f64)]) -> SdofBell {
        let step = TAU * self.spectra.line_spacing_hz / self.rate_hz;
        let total: f64 = bell.iter().map(|(_, s)| s).sum();
        let centre = bell.iter().map(|&(k, s)| k as f64 * s).sum::<f64>() / total;
        // The bell is narrow, so its envelope about the centre frequency varies slowly: a subset of lags suffices.
        let width = bell.len() as f64;
        let stride = ((TAU / (step * width)) as usize / 8).max(1);
        let line = |&(k, s): &(usize, f64)| (k as f64 * self.spectra.line_spacing_hz, s);
        let mut result = SdofBell {
            lines: bell.iter().map(line).collect(),
            decay: Vec::new(),
            pole: None,
        };
        let mut points: Vec<[f64; 3]> = Vec::new();
        let (mut revolutions, mut previous, mut is_above) = (0.0, 0.0, true);
        for lag in (0..self.spectra.block / 2).step_by(stride) {
            let sum: Complex = (bell.iter())
                .map(|&(k, s)| {
                    let angle = (k as f64 - centre) * step * lag as f64;
                    Complex::new(angle.cos(), angle.sin()) * s
                })
                .sum();
            let time = lag as f64 / self.rate_hz;
            let amplitude = sum.norm() / total / self.spectra.window_lags[lag];
            if amplitude < DECAY_END {
                break;
            }
            result.decay.push((time, amplitude));
            let phase = sum.im.atan2(sum.re);
            revolutions -= ((phase - previous) / TAU).round();
            previous = phase;
            is_above &= amplitude >= DECAY_RANGE.1;
            if is_above && amplitude < DECAY_RANGE.0 {
                points.push([time, amplitude.ln(), phase + TAU * revolutions]);
            }
        }
        if points.len() < 3 {
            return result;
        }
        let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64;
        let slope = |value: usize| {
            let (t, y) = (mean(0), mean(value));
            let covariance: f64 = points.iter().map(|p| (p[0] - t) * (p[value] - y)).sum();
            covariance / points.iter().map(|p| (p[0] - t).powi(2)).sum::<f64>()
        };
        let pole = Complex::new(slope(1), centre * step * self.rate_hz + slope(2));
        if pole.re < 0.0 && pole.im > 0.0 {
            result.pole = Some((pole, mean(1) - pole.re * mean(0)));
        }
        result
    }
}
