//! Integer least squares: the integers k that minimise `|Σ k_j c_j − t|` (closest vector of a lattice).
//!
//! A QR decomposition sorts the columns, the shortest first (Wübben et al., Electronics Letters 37 (2001), 1348). A branch-and-bound
//! search then tries integers from the last column on, by distance (Schnorr and Euchner, Math. Programming 66 (1994), 181).

use super::sorting::sort_ascending;
use super::vector_ops::dot;

/// Relative length of a column after projection below which it depends linearly on the earlier ones.
const DEPENDENT: f64 = 1e-12;

/// Maximum number of trial integers; the search then returns its best solution.
const MAX_TRIALS: usize = 200_000;

/// Integers k that minimise `|Σ k_j c_j − t|`; 0 for linearly dependent columns, and the best trial if the search reaches its limit.
pub fn integer_least_squares(columns: &[Vec<f64>], target: &[f64]) -> Vec<f64> {
    let triangle = Triangle::new(columns, target);
    let mut search = Search {
        triangle: &triangle,
        least: f64::INFINITY,
        solution: vec![0.0; columns.len()],
        trial: vec![0.0; columns.len()],
        trials: 0,
    };
    search.descend(columns.len(), 0.0);
    let mut integers = vec![0.0; columns.len()];
    for (column, k) in triangle.order.iter().zip(search.solution) {
        integers[*column] = k;
    }
    integers
}

/// Sorted QR decomposition of the columns, the shortest remaining one first, and the target `Qᵀt`.
struct Triangle {
    /// Index of the column at each position.
    order: Vec<usize>,
    /// Rows of R, from the diagonal to the right.
    rows: Vec<Vec<f64>>,
    target: Vec<f64>,
}

impl Triangle {
    fn new(columns: &[Vec<f64>], target: &[f64]) -> Triangle {
        let mut remaining: Vec<(usize, Vec<f64>)> = columns.iter().cloned().enumerate().collect();
        let lengths: Vec<f64> = columns.iter().map(|c| dot(c, c).sqrt()).collect();
        let mut target = target.to_vec();
        let (mut order, mut row_entries, mut projected) = (Vec::new(), Vec::new(), Vec::new());
        while !remaining.is_empty() {
            sort_ascending(&mut remaining, |(_, column)| dot(column, column));
            let (index, column) = remaining.remove(0);
            let length = dot(&column, &column).sqrt();
            // The remainder of a dependent column is rounding.
            let length = if length > DEPENDENT * lengths[index] {
                length
            } else {
                0.0
            };
            let scale = if length > 0.0 { 1.0 / length } else { 0.0 };
            let unit: Vec<f64> = column.iter().map(|x| scale * x).collect();
            let project_out = |x: &mut Vec<f64>| {
                let coefficient = dot(&unit, x);
                (x.iter_mut().zip(&unit)).for_each(|(x, u)| *x -= coefficient * u);
                coefficient
            };
            projected.push(project_out(&mut target));
            let mut row = vec![(index, length)];
            row.extend((remaining.iter_mut()).map(|(j, column)| (*j, project_out(column))));
            order.push(index);
            row_entries.push(row);
        }
        let row_from = |row: &Vec<(usize, f64)>, first: usize| {
            let entry = |j: &usize| row.iter().find(|p| p.0 == *j).map_or(0.0, |p| p.1);
            order[first..].iter().map(entry).collect()
        };
        Triangle {
            rows: row_entries
                .iter()
                .enumerate()
                .map(|(i, row)| row_from(row, i))
                .collect(),
            target: projected,
            order,
        }
    }
}

struct Search<'t> {
    triangle: &'t Triangle,
    /// Least squared distance.
    least: f64,
    solution: Vec<f64>,
    trial: Vec<f64>,
    trials: usize,
}

impl Search<'_> {
    /// Tries the integers of the positions before `place`; the later ones are set and contribute `sum` to the squared distance.
    fn descend(&mut self, place: usize, sum: f64) {
        let Some(row_index) = place.checked_sub(1) else {
            if sum < self.least {
                self.least = sum;
                self.solution.clone_from(&self.trial);
            }
            return;
        };
        let row = &self.triangle.rows[row_index];
        let fixed: f64 = row[1..]
            .iter()
            .zip(&self.trial[place..])
            .map(|(r, k)| r * k)
            .sum();
        let target = self.triangle.target[row_index] - fixed;
        if row[0] == 0.0 {
            self.trial[row_index] = 0.0;
            return self.descend(row_index, sum + target * target);
        }
        let centre = target / row[0];
        let nearest = centre.round();
        let side = if centre >= nearest { 1.0 } else { -1.0 };
        for step in 0u32.. {
            // 0, 1, −1, 2, −2, … on the nearer side first.
            let offset = f64::from(step.div_ceil(2)) * if step % 2 == 1 { side } else { -side };
            let error = target - row[0] * (nearest + offset);
            self.trials += 1;
            let is_closer = sum + error * error < self.least;
            if !is_closer || self.trials > MAX_TRIALS && self.least.is_finite() {
                return;
            }
            self.trial[row_index] = nearest + offset;
            self.descend(row_index, sum + error * error);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The minimum over all integers from −6 to 6 for three nearly dependent columns.
    #[test]
    fn exact_against_all_integers() {
        let mut random = fastrand::Rng::with_seed(3);
        for _ in 0..200 {
            let mut vector =
                |size: f64| -> Vec<f64> { (0..5).map(|_| size * (random.f64() - 0.5)).collect() };
            let (a, b, offset) = (vector(1.0), vector(1.0), vector(0.1));
            let c: Vec<f64> = (0..5).map(|i| a[i] - b[i] + offset[i]).collect();
            let (columns, target) = ([a, b, c], vector(6.0));
            let square = |k: &[f64]| -> f64 {
                let diff = |i: usize| (0..3).map(|j| k[j] * columns[j][i]).sum::<f64>() - target[i];
                (0..5).map(|i| diff(i).powi(2)).sum()
            };
            let trials = (0..13 * 13 * 13).map(|n| [n / 169, n / 13 % 13, n % 13]);
            let least = trials.map(|k| square(&k.map(|k| f64::from(k) - 6.0)));
            let least = least.fold(f64::INFINITY, f64::min);
            let value = square(&integer_least_squares(&columns, &target));
            assert!(value <= least * (1.0 + 1e-12), "{value} {least}");
        }
    }
}
