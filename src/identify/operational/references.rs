//! Reference channels: those that together explain most of the spectra of all responses, chosen one after the other.
//!
//! With `G` the spectral matrix of a line, divided by its trace, the channel j with the largest `Σ_lines Σ_i |G_ij|²/G_jj` comes first;
//! what it explains is taken off, `G − g_j g_jᴴ/G_jj` (a Cholesky factorisation with pivots common to all lines), and so on.

use super::response_channels::ResponseChannels;
use super::spectral_matrix::SpectralMatrix;
use crate::base::error::Error;

/// More references only add noise to the covariances and time to the decomposition.
pub const MAX_REFERENCES: usize = 4;

/// Share of the spectra that may stay unexplained.
const MAX_UNEXPLAINED_SHARE: f64 = 0.02;

/// Samples of a segment: lines wide enough for dozens of averages, narrow enough that modes of a rung lie on different ones.
const SEGMENT_LEN: usize = 512;

/// Samples the choice is made by, from the first on: 512 averages.
const MAX_SAMPLES: usize = 1 << 17;

/// Chooses references among the responses, by the lines between `band_hz`; all channels where these are few.
///
/// # Errors
/// Those of the spectral matrices.
pub fn references(channels: &ResponseChannels, band_hz: (f64, f64)) -> Result<Vec<usize>, Error> {
    let count = channels.samples().len();
    let segment = SEGMENT_LEN.min(channels.n_samples() / 4);
    if count <= MAX_REFERENCES || segment < 16 {
        return Ok((0..count).collect());
    }
    let taken: Vec<&[f64]> = (channels.samples().iter())
        .map(|s| &s[..s.len().min(MAX_SAMPLES)])
        .collect();
    let spectra = SpectralMatrix::new(
        &ResponseChannels::new(&taken, channels.rate_hz())?,
        Some(segment),
    )?;
    let inside = |k: &usize| {
        let f = *k as f64 * spectra.line_spacing_hz;
        f >= band_hz.0 && f <= band_hz.1
    };
    let trace = |k: usize| -> f64 { (0..count).map(|c| spectra.lines[k][(c, c)].re).sum() };
    let mut lines: Vec<_> = (0..spectra.lines.len())
        .filter(inside)
        .filter(|&k| trace(k) > 0.0)
        .map(|k| (1.0 / trace(k), spectra.lines[k].clone()))
        .collect();
    let total = lines.len() as f64;
    let mut left = total;
    let mut chosen: Vec<usize> = Vec::new();
    while chosen.len() < MAX_REFERENCES && left > MAX_UNEXPLAINED_SHARE * total {
        let explains = |j: usize| -> f64 {
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
            .map(|j| (j, explains(j)))
            .collect();
        let Some(&(best, gain)) = gains.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else {
            break;
        };
        chosen.push(best);
        left -= gain;
        for (_, g) in &mut lines {
            let pivot = g[(best, best)].re;
            if pivot <= 0.0 {
                continue;
            }
            let column: Vec<_> = (0..count).map(|i| g[(i, best)]).collect();
            for (i, j) in (0..count).flat_map(|i| (0..count).map(move |j| (i, j))) {
                g[(i, j)] -= column[i] * column[j].conj() / pivot;
            }
            // What rounding leaves of a channel that is explained must not become a pivot.
            (0..count).for_each(|i| g[(i, best)] = crate::numeric::Complex::ZERO);
        }
    }
    chosen.sort_unstable();
    Ok(chosen)
}
