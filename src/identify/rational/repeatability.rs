//! Residues from hit to hit: those of a structure repeat, those of a resonance folded down from above half the sample rate do not.
//!
//! A hit at the time t turns the folded part of a response by `exp(jω_s t)` against the force, with ω_s the sample rate: its phase is where
//! in a sample the hit falls, and differs from hit to hit.

use crate::numeric::Complex;

use super::assemble_fit::{coefficients, residue};
use super::scaled_responses::ScaledResponses;
use super::search::SearchResult;

/// Fewer hits do not show whether a residue repeats.
const MIN_HITS: usize = 3;

/// Chance that residues without a common mean pass as repeating.
const CHANCE: f64 = 0.01;

/// Whether the residues of each pole repeat from hit to hit: their mean is other than zero by an F-test, `m |R̄|²/s²` over the outputs
/// together against `F(2, 2(m − 1))`. Of fewer hits than three all do.
pub(super) fn repeating_residues(result: &SearchResult, hits: &ScaledResponses) -> Vec<bool> {
    let poles = &result.fit.model.poles;
    let count = hits.hits.len();
    if count < MIN_HITS {
        return vec![true; poles.len()];
    }
    let numerators = result.structure.numerators();
    let coefficients = coefficients(result, hits.h.len());
    let repeats = |r: usize| {
        let (mut means, mut scatter) = (0.0, 0.0);
        for output in hits.channels.iter().filter(|o| o.len() == count) {
            let size = output.iter().map(|&at| hits.size[at]).sum::<f64>() / count as f64;
            let of_hit = |&at: &usize| {
                residue(&coefficients[at], &poles[r], r, numerators) * (hits.size[at] / size)
            };
            let residues: Vec<Complex> = output.iter().map(of_hit).collect();
            let mean = residues.iter().sum::<Complex>() / count as f64;
            let off = residues.iter().map(|z| (z - mean).norm_sqr()).sum::<f64>();
            means += count as f64 * mean.norm_sqr();
            scatter += off / (count - 1) as f64;
        }
        means >= critical_ratio(count) * scatter
    };
    (0..poles.len()).map(repeats).collect()
}

/// Quantile of `F(2, 2k)`, `k ((1/α)^(1/k) − 1)`, with `k = hits − 1`.
fn critical_ratio(hits: usize) -> f64 {
    let k = (hits - 1) as f64;
    k * (CHANCE.powf(-1.0 / k) - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tables of F at 1 % give 18.00, 8.65 and 6.01 for 2 and 4, 8 and 18 degrees of freedom.
    #[test]
    fn ref_quantiles_of_f() {
        for (hits, table) in [(3, 18.00), (5, 8.65), (10, 6.01)] {
            assert!((critical_ratio(hits) - table).abs() < 0.005);
        }
    }
}
