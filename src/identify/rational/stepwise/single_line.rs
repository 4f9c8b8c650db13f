//! Falls of χ² that one bad line brings.

use super::{StepwiseSearch, parameters_per_pole};
use crate::numeric::Matrix;
use crate::numeric::statistics::chi_squared_quantile;

impl StepwiseSearch<'_> {
    /// More than half of the fall on one line, the others not significant, and the values of that line not in or out of phase as
    /// those of a mode with real constants are. For a random vector of m complex numbers with the second moments λ₁ ≥ λ₂ of its
    /// points, `4 λ₁λ₂/(λ₁+λ₂)²` is below u with probability `u^((m−1)/2)` (Mauchly 1940).
    pub(super) fn is_outlier(&self, before: &Matrix, after: &Matrix) -> bool {
        const OUTLIER_PROBABILITY: f64 = 1e-3;
        let n = before.nrows() / 2;
        let falls = falls(before, after);
        let total: f64 = falls.iter().sum();
        let Some((line, largest)) = falls
            .iter()
            .copied()
            .enumerate()
            .max_by(|a, b| a.1.total_cmp(&b.1))
        else {
            return false;
        };
        let dofs = parameters_per_pole(self.measured, self.numerators);
        if largest < 0.5 * total
            || total - largest > chi_squared_quantile(1.0 - OUTLIER_PROBABILITY, dofs)
        {
            return false;
        }
        let m = before.ncols();
        let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
        for i in 0..m {
            let (x, y) = (before[(line, i)], before[(n + line, i)]);
            xx += x * x;
            yy += y * y;
            xy += x * y;
        }
        let round = 4.0 * (xx * yy - xy * xy).max(0.0) / (xx + yy).powi(2);
        round.powf((m as f64 - 1.0) / 2.0) > OUTLIER_PROBABILITY
    }

    /// Without its best line the fall would not be half of what a pole must bring.
    pub(super) fn is_on_a_line(&self, before: &Matrix, after: &Matrix) -> bool {
        let falls = falls(before, after);
        let largest = falls.iter().copied().fold(0.0, f64::max);
        falls.iter().sum::<f64>() - largest < 0.5 * self.threshold
    }
}

/// Decrease of the squared residual from one fit to another, by line.
fn falls(before: &Matrix, after: &Matrix) -> Vec<f64> {
    let n = before.nrows() / 2;
    let power = |e: &Matrix, k: usize| -> f64 {
        (0..e.ncols())
            .map(|i| e[(k, i)].powi(2) + e[(n + k, i)].powi(2))
            .sum()
    };
    (0..n).map(|k| power(before, k) - power(after, k)).collect()
}
