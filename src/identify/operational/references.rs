//! Reference channels for operational modal analysis, chosen by a pivoted Cholesky factorisation of the spectral matrices.
//!
//! With `G` the spectral matrix of a line, divided by its trace, the channel j with the largest `Σ_lines Σ_i |G_ij|²/G_jj` is chosen,
//! and its contribution is subtracted, `G − g_j g_jᴴ/G_jj`; the pivots are common to all lines.

use super::response_channels::ResponseChannels;
use super::spectral_matrix::SpectralMatrix;
use crate::base::error::Error;

/// Maximum number of references; more add noise to the covariances and time to the decomposition.
pub const MAX_REFERENCES: usize = 4;

/// Share of the spectra below which the unexplained part ends the choice.
const MAX_UNEXPLAINED_SHARE: f64 = 0.02;

/// Samples of a segment: short enough for dozens of averages, long enough to resolve the modes of a decimation level.
const SEGMENT_LEN: usize = 512;

/// Number of leading samples used for the choice: 512 averages.
const MAX_SAMPLES: usize = 1 << 17;

/// Indices of the references among the responses, chosen by the lines in `band_hz`; all channels if there are at most `MAX_REFERENCES`.
///
/// # Errors
/// Those of the spectral matrices.
pub fn references(channels: &ResponseChannels, band_hz: (f64, f64)) -> Result<Vec<usize>, Error> {
    let count = channels.samples().len();
    let segment = SEGMENT_LEN.min(channels.n_samples() / 4);
    if count <= MAX_REFERENCES || segment < 16 {
        return Ok((0..count).collect());
    }
    let samples: Vec<&[f64]> = (channels.samples().iter())
        .map(|s| &s[..s.len().min(MAX_SAMPLES)])
        .collect();
    let spectra = SpectralMatrix::new(
        &ResponseChannels::new(&samples, channels.rate_hz())?,
        Some(segment),
    )?;
    let in_band = |k: &usize| {
        let f = *k as f64 * spectra.line_spacing_hz;
        f >= band_hz.0 && f <= band_hz.1
    };
    let trace = |k: usize| -> f64 { (0..count).map(|c| spectra.lines[k][(c, c)].re).sum() };
    let mut lines: Vec<_> = (0..spectra.lines.len())
        .filter(in_band)
        .filter(|&k| trace(k) > 0.0)
        .map(|k| (1.0 / trace(k), spectra.lines[k].clone()))
        .collect();
    let total = lines.len() as f64;
    let mut unexplained = total;
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < MAX_REFERENCES && unexplained > MAX_UNEXPLAINED_SHARE * total {
        let explained_share = |j: usize| -> f64 {
            (lines.iter())
                .filter(|(_, g)| g[(j, j)].re > 0.0)
                .map(|(scale, g)| {
                    let column: f64 = (0..count).map(|i| g[(i, j)].norm_sqr()).sum();
                    column / g[(j, j)].re * scale
                })
                .sum()
        };
        let gains: Vec<(usize, f64)> = (0..count)
            .filter(|j| !chosen.contains(j))
            .map(|j| (j, explained_share(j)))
            .collect();
        let Some(&(best, gain)) = gains.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else {
            break;
        };
        chosen.push(best);
        unexplained -= gain;
        for (_, g) in &mut lines {
            let pivot = g[(best, best)].re;
            if pivot <= 0.0 {
                continue;
            }
            let column: Vec<_> = (0..count).map(|i| g[(i, best)]).collect();
            for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
                g[(i, j)] -= column[i] * column[j].conj() / pivot;
            }
            // The rounding error left in an eliminated channel must not become a pivot.
            (0..count).for_each(|i| g[(i, best)] = crate::numeric::Complex::ZERO);
        }
    }
    chosen.sort_unstable();
    Ok(chosen)
}
