//! Linear assignment: one-to-one pairing of rows and columns with the highest total score.
//!
//! Shortest augmenting paths with potentials, O(rows² · columns): Jonker & Volgenant, Computing 38 (1987), 325–340,
//! without their initialisation.

use super::Matrix;

/// For every row of `score` its column, or nothing where there are more rows than columns.
///
/// Scores must be finite.
pub fn assign(score: &Matrix) -> Vec<Option<usize>> {
    let (rows, columns) = (score.nrows(), score.ncols());
    if rows > columns {
        let turned = assign(&score.transpose().to_owned());
        let mut column_of = vec![None; rows];
        for (column, row) in turned.into_iter().enumerate() {
            if let Some(row) = row {
                column_of[row] = Some(column);
            }
        }
        return column_of;
    }
    let mut pairing = Pairing {
        row_price: vec![0.0; rows],
        column_price: vec![0.0; columns],
        row_of: vec![None; columns],
    };
    (0..rows).for_each(|row| pairing.augment(score, row));
    let mut column_of = vec![None; rows];
    for (column, row) in pairing.row_of.iter().enumerate() {
        if let Some(row) = *row {
            column_of[row] = Some(column);
        }
    }
    column_of
}

struct Pairing {
    row_price: Vec<f64>,
    column_price: Vec<f64>,
    row_of: Vec<Option<usize>>,
}

impl Pairing {
    /// Pairs one more row, moving others along the cheapest path to a free column.
    fn augment(&mut self, score: &Matrix, start: usize) {
        let columns = self.row_of.len();
        let mut distance = vec![f64::INFINITY; columns];
        let mut came_from: Vec<Option<usize>> = vec![None; columns];
        let mut done = vec![false; columns];
        let (mut row, mut behind) = (start, None);
        let last = loop {
            for column in (0..columns).filter(|&c| !done[c]) {
                let slack = -score[(row, column)] - self.row_price[row] - self.column_price[column];
                if slack < distance[column] {
                    (distance[column], came_from[column]) = (slack, behind);
                }
            }
            let nearest = (0..columns)
                .filter(|&c| !done[c])
                .min_by(|&a, &b| distance[a].total_cmp(&distance[b]));
            let Some(nearest) = nearest else { return };
            let step = distance[nearest];
            self.row_price[start] += step;
            for column in 0..columns {
                match self.row_of[column] {
                    Some(paired) if done[column] => {
                        self.row_price[paired] += step;
                        self.column_price[column] -= step;
                    }
                    _ => distance[column] -= step,
                }
            }
            done[nearest] = true;
            let Some(paired) = self.row_of[nearest] else {
                break nearest;
            };
            (row, behind) = (paired, Some(nearest));
        };
        let mut column = last;
        while let Some(before) = came_from[column] {
            self.row_of[column] = self.row_of[before];
            column = before;
        }
        self.row_of[column] = Some(start);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total(score: &Matrix, pairs: &[Option<usize>]) -> f64 {
        pairs
            .iter()
            .enumerate()
            .filter_map(|(i, j)| j.map(|j| score[(i, j)]))
            .sum()
    }

    /// The best row by row (0.9 + 0.1) is worse than the best together (0.8 + 0.7).
    #[test]
    fn exact_greedy_is_not_best() {
        let score = Matrix::from_fn(2, 2, |i, j| [[0.9, 0.8], [0.7, 0.1]][i][j]);
        assert_eq!(assign(&score), [Some(1), Some(0)]);
    }

    /// As good as the best of all permutations, square or not.
    #[test]
    fn law_best_of_all_permutations() {
        fn best(score: &Matrix, row: usize, used: &mut Vec<usize>) -> f64 {
            if row == score.nrows() {
                return 0.0;
            }
            let mut most = f64::NEG_INFINITY;
            for j in 0..score.ncols() {
                if !used.contains(&j) {
                    used.push(j);
                    most = most.max(score[(row, j)] + best(score, row + 1, used));
                    used.pop();
                }
            }
            most
        }
        let mut seed = 1u64;
        let mut random = || {
            seed = seed
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (seed >> 40) as f64 / (1u64 << 24) as f64
        };
        for _ in 0..50 {
            let score = Matrix::from_fn(4, 6, |_, _| random());
            let most = best(&score, 0, &mut Vec::new());
            assert!((total(&score, &assign(&score)) - most).abs() < 1e-14);
            let turned = score.transpose().to_owned();
            assert!((total(&turned, &assign(&turned)) - most).abs() < 1e-14);
        }
    }

    #[test]
    fn survives_nothing_at_all() {
        assert!(assign(&Matrix::zeros(0, 3)).is_empty());
        assert_eq!(assign(&Matrix::zeros(2, 0)), [None, None]);
    }
}
