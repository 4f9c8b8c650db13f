//! Residues from hit to hit: those of a structure repeat, those of a resonance folded down from above half the sample rate do not.
//!
//! A hit at the time t turns the folded part of a response by `exp(jω_s t)` against the force, with ω_s the sample rate: its phase is where
//! in a sample the hit falls, and differs from hit to hit.

use crate::numeric::Complex;

use super::assemble_fit::coefficients;
use super::basis::residue;
use super::scaled_responses::ScaledResponses;
use super::search::SearchResult;

/// Fewer hits do not show whether a residue repeats.
const MIN_HITS: usize = 3;

/// Chance that normal residues without a common mean pass as repeating: of three hits, and of more. Of folded residues, equal in size and
/// turned at random, 7 % pass with three hits, 3 % with four, 2 % with eight; of modes whose residue has noise of a third of its size in
/// every hit 4 % are rejected with three hits, 1 % with four, none with eight. (At 1 % with three hits these were 4 and 21 %.)
const CHANCE: (f64, f64) = (0.03, 0.01);

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
        let outputs = hits.channels.iter().filter(|o| o.len() == count);
        let of_output = |output: &Vec<usize>| -> Vec<Complex> {
            let size = output.iter().map(|&at| hits.size[at]).sum::<f64>() / count as f64;
            let of_hit = |&at: &usize| {
                residue(&coefficients[at], &poles[r], r, numerators) * (hits.size[at] / size)
            };
            output.iter().map(of_hit).collect()
        };
        have_a_mean(&outputs.map(of_output).collect::<Vec<_>>(), count)
    };
    (0..poles.len()).map(repeats).collect()
}

/// The F-test of residues by output and hit.
fn have_a_mean(outputs: &[Vec<Complex>], count: usize) -> bool {
    let (mut means, mut scatter) = (0.0, 0.0);
    for residues in outputs {
        let mean = residues.iter().sum::<Complex>() / count as f64;
        let off = residues.iter().map(|z| (z - mean).norm_sqr()).sum::<f64>();
        means += count as f64 * mean.norm_sqr();
        scatter += off / (count - 1) as f64;
    }
    means >= critical_ratio(count) * scatter
}

/// Quantile of `F(2, 2k)`, `k ((1/α)^(1/k) − 1)`, with `k = hits − 1`.
fn critical_ratio(hits: usize) -> f64 {
    let k = (hits - 1) as f64;
    let chance = match hits {
        MIN_HITS => CHANCE.0,
        _ => CHANCE.1,
    };
    k * (chance.powf(-1.0 / k) - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::numeric::statistics::f_sf;

    /// The quantiles have the chance that the distribution function gives; tables of F at 1 % give 8.65 and 6.01 for 8 and 18 degrees of
    /// freedom.
    #[test]
    fn ref_quantiles_of_f() {
        for (hits, table) in [(5, 8.65), (10, 6.01)] {
            assert!((critical_ratio(hits) - table).abs() < 0.005);
        }
        assert!((f_sf(critical_ratio(3), 2.0, 4.0) - 0.03).abs() < 1e-9);
    }

    /// Shares, %, of modes with noise of a third of the residue in every hit that are rejected, and of folded resonances that pass, one
    /// output, 4000 draws each.
    #[test]
    fn law_weak_modes_stay_and_folded_ones_go() {
        let mut rng = fastrand::Rng::with_seed(11);
        for (hits, most) in [
            (3, (7.0, 9.0)),
            (4, (2.0, 4.5)),
            (5, (0.5, 3.5)),
            (8, (0.1, 3.0)),
        ] {
            let (mut rejected, mut passed) = (0, 0);
            for _ in 0..4000 {
                let mut turned =
                    |size: f64| Complex::from_polar(size, std::f64::consts::TAU * rng.f64());
                let folded: Vec<Complex> = (0..hits).map(|_| turned(1.0)).collect();
                let mode = |_| {
                    let size = (-(1.0 - rng.f64()).ln()).sqrt() / 3.0;
                    1.0 + Complex::from_polar(size, std::f64::consts::TAU * rng.f64())
                };
                let mode: Vec<Complex> = (0..hits).map(mode).collect();
                rejected += usize::from(!have_a_mean(&[mode], hits));
                passed += usize::from(have_a_mean(&[folded], hits));
            }
            let share = |n: usize| 100.0 * n as f64 / 4000.0;
            assert!(
                share(rejected) < most.0 && share(passed) < most.1,
                "{hits} hits"
            );
        }
    }
}
