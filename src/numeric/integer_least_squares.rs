//! Integer least squares: the integers k of least `|Σ k_j c_j − t|`, the closest vector of a lattice.
//!
//! Columns are made triangular with the shortest first (Wübben et al., Electronics Letters 37 (2001), 1348), and integers are tried from
//! the last on in the order of their distance, branches beyond the best being left (Schnorr and Euchner, Math. Programming 66 (1994), 181).

use super::sorting::sort_rising;
use super::vector_ops::dot;

/// A column of which the others leave less than this share depends on them.
const DEPENDENT: f64 = 1e-12;

/// Integers tried before the best found is taken.
const MOST_TRIALS: usize = 200_000;

/// Integers k of least `|Σ k_j c_j − t|`; of columns that depend on others, and where the search is given up, the best found.
pub fn integer_least_squares(columns: &[Vec<f64>], target: &[f64]) -> Vec<f64> {
    let triangle = Triangle::new(columns, target);
    let mut search = Search {
        triangle: &triangle,
        best: f64::INFINITY,
        nearest: vec![0.0; columns.len()],
        trial: vec![0.0; columns.len()],
        trials: 0,
    };
    search.descend(columns.len(), 0.0);
    let mut integers = vec![0.0; columns.len()];
    for (place, k) in triangle.order.iter().zip(search.nearest) {
        integers[*place] = k;
    }
    integers
}

/// Columns as `Q R`, the shortest remaining one first, and the target in Q.
struct Triangle {
    /// The column at each place.
    order: Vec<usize>,
    /// Rows of R, from the diagonal on.
    rows: Vec<Vec<f64>>,
    target: Vec<f64>,
}

impl Triangle {
    fn new(columns: &[Vec<f64>], target: &[f64]) -> Triangle {
        let mut left: Vec<(usize, Vec<f64>)> = columns.iter().cloned().enumerate().collect();
        let lengths: Vec<f64> = columns.iter().map(|c| dot(c, c).sqrt()).collect();
        let mut target = target.to_vec();
        let (mut order, mut parts, mut in_q) = (Vec::new(), Vec::new(), Vec::new());
        while !left.is_empty() {
            sort_rising(&mut left, |(_, column)| dot(column, column));
            let (place, column) = left.remove(0);
            let size = dot(&column, &column).sqrt();
            // What is left of a column that depends on others is rounding.
            let size = if size > DEPENDENT * lengths[place] {
                size
            } else {
                0.0
            };
            let scale = if size > 0.0 { 1.0 / size } else { 0.0 };
            let unit: Vec<f64> = column.iter().map(|x| scale * x).collect();
            let take_off = |x: &mut Vec<f64>| {
                let part = dot(&unit, x);
                (x.iter_mut().zip(&unit)).for_each(|(x, u)| *x -= part * u);
                part
            };
            in_q.push(take_off(&mut target));
            let mut row = vec![(place, size)];
            row.extend(left.iter_mut().map(|(at, column)| (*at, take_off(column))));
            order.push(place);
            parts.push(row);
        }
        let along = |row: &Vec<(usize, f64)>, first: usize| {
            let part = |at: &usize| row.iter().find(|p| p.0 == *at).map_or(0.0, |p| p.1);
            order[first..].iter().map(part).collect()
        };
        Triangle {
            rows: parts
                .iter()
                .enumerate()
                .map(|(i, row)| along(row, i))
                .collect(),
            target: in_q,
            order,
        }
    }
}

struct Search<'t> {
    triangle: &'t Triangle,
    /// Least square found.
    best: f64,
    nearest: Vec<f64>,
    trial: Vec<f64>,
    trials: usize,
}

impl Search<'_> {
    /// Tries the integers of all places before `place`, those from it on being set with a square of `sum`.
    fn descend(&mut self, place: usize, sum: f64) {
        let Some(at) = place.checked_sub(1) else {
            if sum < self.best {
                self.best = sum;
                self.nearest.clone_from(&self.trial);
            }
            return;
        };
        let row = &self.triangle.rows[at];
        let set: f64 = row[1..]
            .iter()
            .zip(&self.trial[place..])
            .map(|(r, k)| r * k)
            .sum();
        let rest = self.triangle.target[at] - set;
        if row[0] == 0.0 {
            self.trial[at] = 0.0;
            return self.descend(at, sum + rest * rest);
        }
        let centre = rest / row[0];
        let middle = centre.round();
        let side = if centre >= middle { 1.0 } else { -1.0 };
        for step in 0u32.. {
            // 0, 1, −1, 2, −2, … on the nearer side first.
            let by = f64::from(step.div_ceil(2)) * if step % 2 == 1 { side } else { -side };
            let off = rest - row[0] * (middle + by);
            self.trials += 1;
            let is_nearer = sum + off * off < self.best;
            if !is_nearer || self.trials > MOST_TRIALS && self.best.is_finite() {
                return;
            }
            self.trial[at] = middle + by;
            self.descend(at, sum + off * off);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against all integers from −6 to 6, of three columns that nearly depend on each other.
    #[test]
    fn exact_against_all_integers() {
        let mut random = fastrand::Rng::with_seed(3);
        for _ in 0..200 {
            let mut vector =
                |size: f64| -> Vec<f64> { (0..5).map(|_| size * (random.f64() - 0.5)).collect() };
            let (a, b, near) = (vector(1.0), vector(1.0), vector(0.1));
            let c: Vec<f64> = (0..5).map(|i| a[i] - b[i] + near[i]).collect();
            let (columns, target) = ([a, b, c], vector(6.0));
            let square = |k: &[f64]| -> f64 {
                let miss = |i: usize| (0..3).map(|j| k[j] * columns[j][i]).sum::<f64>() - target[i];
                (0..5).map(|i| miss(i).powi(2)).sum()
            };
            let all = (0..13 * 13 * 13).map(|n| [n / 169, n / 13 % 13, n % 13]);
            let least = all.map(|k| square(&k.map(|k| f64::from(k) - 6.0)));
            let least = least.fold(f64::INFINITY, f64::min);
            let found = square(&integer_least_squares(&columns, &target));
            assert!(found <= least * (1.0 + 1e-12), "{found} {least}");
        }
    }
}
