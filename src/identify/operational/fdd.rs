//! Frequency-domain decomposition (FDD, EFDD): peaks of the largest singular value, damping by decay.
//!
//! The spectral matrix of the responses is decomposed line by line (Brincker, Zhang & Andersen, Smart Mater. Struct. 10 (2001));
//! damping from the decay of the autocovariance of the bell about each peak (Brincker, Ventura & Andersen,
//! IMAC 19 (2001)).
//!
//! The bell `φᴴ S(f) φ` alone is transformed back: a complex autocovariance `R(τ) ∝ exp(−ζωτ + iω_d τ)`, whose modulus and phase give
//! damping and frequency by straight lines. The window's own autocovariance, which multiplies R, is divided out, so that short
//! segments do not add damping.

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
    /// Samples of a segment; `None`: the power of two below a tenth of the record.
    pub segment: Option<usize>,
    /// Peaks are looked for from here to there, Hz; `None`: everywhere.
    pub band_hz: Option<(f64, f64)>,
    /// Running speed of the rotating shafts.
    pub running_speed: Option<RunningSpeed>,
}

/// A peak of the largest singular value.
#[derive(Debug, Clone)]
pub struct FddPeak {
    /// Peak frequency, Hz: vertex of a parabola through the logarithms of three lines.
    pub frequency_hz: f64,
    /// Density over that of the higher of the adjacent valleys, both averaged over the width of the peak.
    pub prominence: f64,
    /// Shape over the channels, the largest component 1.
    pub shape: Vec<Complex>,
    /// The lines about it with its shape; `None` where there are fewer than five.
    pub bell: Option<SdofBell>,
    /// Pole from the decay of its bell, where that decays; with the same shape, without covariance.
    pub mode: Option<ModalParameters>,
    /// Evidence that the peak is a line of running speed.
    pub harmonic: HarmonicIndicator,
}

/// A bell and how its autocovariance decays.
#[derive(Debug, Clone, PartialEq)]
pub struct SdofBell {
    /// Spectral lines of the bell, Hz, rising, and `φᴴ S φ` on them.
    pub lines: Vec<(f64, f64)>,
    /// Lags, s, and the modulus of the autocovariance over that at no lag, the window's divided out.
    pub decay: Vec<(f64, f64)>,
    /// Pole estimated by the straight lines through logarithm and phase, and that logarithm at no lag.
    pub pole: Option<(Complex, f64)>,
}

/// Singular values of the spectral matrix by line, and their peaks.
#[derive(Debug, Clone)]
pub struct FddEstimate {
    /// Lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// Singular values of each line, largest first, product of units per Hz.
    pub singular_values: Vec<Vec<f64>>,
    /// Peaks by rising frequency.
    pub peaks: Vec<FddPeak>,
}

impl FddEstimate {
    /// Lines, Hz, and the largest singular value of each.
    pub fn largest_values(self) -> (Vec<f64>, Vec<f64>) {
        let first = self.singular_values.iter().map(|v| v[0]).collect();
        (self.frequency_hz, first)
    }
}

/// Vectors of the bell agree with that of the peak by this MAC (Brincker et al.'s rule).
const SAME_SHAPE: f64 = 0.8;

/// The bell ends where it has fallen to this share of its peak: what is further down is the neighbours'.
const BELL_FLOOR: f64 = 1e-2;

/// The part of the decay the lines are laid through: below the first share, above the second.
pub const DECAY_RANGE: (f64, f64) = (0.95, 0.3);

/// The decay is followed to this share.
const DECAY_END: f64 = 0.1;

/// Half width of the band in which the distribution is looked at, in resolved lines.
const KURTOSIS_HALF_BAND_LINES: f64 = 2.0;

/// Decomposes the responses.
///
/// # Errors
/// `TooShort` where fewer than two segments fit; `OutOfRange` for a band that holds no line; those of the eigenproblems.
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
        // The lines next to zero hold what is left of the mean.
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
                    "no lines to look for peaks in: the band is lines {from} to {to} of {}, {spacing} Hz apart",
                    s.len()
                ),
            )
            .with_hint("widen the band, or take longer segments"));
        }
        let scatter = self.scatter(from, to);
        let result = significant_peaks(s, from..to + 1, 2.0 / (scatter * scatter));
        Ok(result)
    }

    /// Standard deviation of the logarithm of a density: `1/√averages` by count, more by the median difference of lines that are two
    /// resolved lines apart where the responses are not stationary, such as after knocks.
    fn scatter(&self, from: usize, to: usize) -> f64 {
        const INDEPENDENT_LINES: usize = 4; // padded lines lie at half the resolution
        const MEDIAN_DIFFERENCE_TO_STD: f64 = 0.6745 * std::f64::consts::SQRT_2; // median of |difference| over the standard deviation
        // Of half-overlapping Hann segments about 0.95 in two hops count as independent (Welch 1967).
        let counted = 1.0 / (self.spectra.averages as f64 * 0.95).max(1.0).sqrt();
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
        counted.max(median / MEDIAN_DIFFERENCE_TO_STD)
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
        let told = bell.as_ref().and_then(|bell| bell.pole);
        let mode = told.map(|(pole, _)| ModalParameters {
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
        let three = [line - 1, line, line + 1].map(|k| self.first[k]);
        log_vertex(three).0.clamp(-0.5, 0.5)
    }

    /// Lines about the peak with its shape, and `φᴴ S φ` on them.
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
            product.norm_sqr() >= SAME_SHAPE
        };
        let floor = self.first[line] * BELL_FLOOR;
        let walk = |lines: &mut dyn Iterator<Item = usize>| {
            let mut bell = Vec::new();
            let mut lowest = f64::INFINITY;
            for k in lines {
                let value = density(k);
                // On its way down the bell may rise by chance, not double: there a neighbour begins.
                if !is_alike(k) || value < floor || value > 2.0 * lowest {
                    break;
                }
                lowest = lowest.min(value);
                bell.push((k, value));
            }
            bell
        };
        let mut bell = walk(&mut (1..line).rev());
        bell.reverse();
        bell.push((line, density(line)));
        bell.extend(walk(&mut (line + 1..self.first.len() - 1)));
        (bell.len() >= 5).then_some(bell)
    }

    /// A bell with the decay of its autocovariance, and the pole that tells; none where it does not fall far enough within the segment.
    fn decay(&self, bell: &[(usize, f64)]) -> SdofBell {
        let step = TAU * self.spectra.line_spacing_hz / self.rate_hz;
        let total: f64 = bell.iter().map(|(_, s)| s).sum();
        let centre = bell.iter().map(|&(k, s)| k as f64 * s).sum::<f64>() / total;
        // The bell is narrow: its envelope about the centre changes slowly, and every few samples are enough.
        let width = bell.len() as f64;
        let stride = ((TAU / (step * width)) as usize / 8).max(1);
        let at = |&(k, s): &(usize, f64)| (k as f64 * self.spectra.line_spacing_hz, s);
        let mut found = SdofBell {
            lines: bell.iter().map(at).collect(),
            decay: Vec::new(),
            pole: None,
        };
        let mut points: Vec<[f64; 3]> = Vec::new();
        let (mut turns, mut last, mut is_above) = (0.0, 0.0, true);
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
            found.decay.push((time, amplitude));
            let phase = sum.im.atan2(sum.re);
            turns -= ((phase - last) / TAU).round();
            last = phase;
            is_above &= amplitude >= DECAY_RANGE.1;
            if is_above && amplitude < DECAY_RANGE.0 {
                points.push([time, amplitude.ln(), phase + TAU * turns]);
            }
        }
        if points.len() < 3 {
            return found;
        }
        let mean = |k: usize| points.iter().map(|p| p[k]).sum::<f64>() / points.len() as f64;
        let slope = |value: usize| {
            let (t, y) = (mean(0), mean(value));
            let top: f64 = points.iter().map(|p| (p[0] - t) * (p[value] - y)).sum();
            top / points.iter().map(|p| (p[0] - t).powi(2)).sum::<f64>()
        };
        let pole = Complex::new(slope(1), centre * step * self.rate_hz + slope(2));
        if pole.re < 0.0 && pole.im > 0.0 {
            found.pole = Some((pole, mean(1) - pole.re * mean(0)));
        }
        found
    }
}
