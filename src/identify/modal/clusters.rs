//! Agglomerative clustering by average linkage with a distance cut (Müllner 2011).
//!
//! Müllner, Modern hierarchical, agglomerative clustering algorithms, arXiv:1109.2378 (2011): chains of nearest neighbours, O(n²).

/// Clusters of `0..n`, members rising, ordered by their first member; `distance` is symmetric and not negative.
pub fn cluster(n: usize, distance: impl Fn(usize, usize) -> f64, cut: f64) -> Vec<Vec<usize>> {
    let mut apart: Vec<Vec<f64>> = (0..n)
        .map(|i| (0..i).map(|j| distance(i, j)).collect())
        .collect();
    let between = |apart: &Vec<Vec<f64>>, i: usize, j: usize| apart[i.max(j)][i.min(j)];
    let mut members: Vec<Vec<usize>> = (0..n).map(|i| vec![i]).collect();
    let mut chain: Vec<usize> = Vec::new();
    let mut open: Vec<usize> = (0..n).collect();
    while let Some(tip) = chain.last().copied().or_else(|| open.first().copied()) {
        if chain.is_empty() {
            chain.push(tip);
        }
        let before = chain.len().checked_sub(2).map(|k| chain[k]);
        // the one before wins a tie, so that the chain ends
        let mut nearest = before.map(|b| (between(&apart, tip, b), b));
        for &other in open.iter().filter(|&&other| other != tip) {
            let d = between(&apart, tip, other);
            if nearest.is_none_or(|(least, _)| d < least) {
                nearest = Some((d, other));
            }
        }
        match nearest {
            Some((d, other)) if d <= cut => {
                if Some(other) != before {
                    chain.push(other);
                    continue;
                }
                chain.truncate(chain.len() - 2);
                let (keep, gone) = (tip.min(other), tip.max(other));
                let (a, b) = (members[keep].len() as f64, members[gone].len() as f64);
                open.retain(|&i| i != gone);
                for &i in open.iter().filter(|&&i| i != keep) {
                    let mean =
                        (a * between(&apart, i, keep) + b * between(&apart, i, gone)) / (a + b);
                    apart[i.max(keep)][i.min(keep)] = mean;
                }
                let moved = std::mem::take(&mut members[gone]);
                members[keep].extend(moved);
            }
            // nothing within the cut: this cluster is complete, and so cannot be the nearest of a later one within it
            _ => {
                open.retain(|&i| i != tip);
                chain.pop();
            }
        }
    }
    let mut clusters: Vec<Vec<usize>> = members.into_iter().filter(|m| !m.is_empty()).collect();
    clusters.iter_mut().for_each(|m| m.sort_unstable());
    clusters.sort();
    clusters
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exact_points_on_a_line() {
        let x: [f64; 6] = [0.0, 10.0, 0.4, 10.3, 0.1, 30.0];
        let found = cluster(6, |i, j| (x[i] - x[j]).abs(), 1.0);
        assert_eq!(found, vec![vec![0, 2, 4], vec![1, 3], vec![5]]);
        assert!(cluster(0, |_, _| 0.0, 1.0).is_empty());
    }
}
