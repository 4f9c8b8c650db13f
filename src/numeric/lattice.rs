//! Rank-1 lattice points for quasi-Monte-Carlo integration with random shifts.
//!
//! The shifts use a fixed seed, so that the points are reproducible on every computer.

/// Lattice sizes N with a primitive root each, so that the generators of up to N − 1 dimensions differ.
const SIZES: [(u64, u64); 4] = [(61, 2), (251, 6), (1021, 10), (8191, 17)];

/// Rank-1 lattice with its random shifts.
#[derive(Debug, Clone)]
pub struct RankOneLattice {
    size: u64,
    generator: Vec<u64>,
    shifts: Vec<Vec<f64>>,
}

impl RankOneLattice {
    /// Lattice of at least `points` points per shift (at most 8191) in `dimensions` dimensions with `shifts` shifts.
    pub fn new(dimensions: usize, points: usize, shifts: usize) -> RankOneLattice {
        let min_size = (points as u64).max(dimensions as u64 + 1);
        let (size, root) = (SIZES.into_iter())
            .find(|(n, _)| *n >= min_size)
            .unwrap_or(SIZES[3]);
        let mut generator = Vec::with_capacity(dimensions);
        let mut z = 1;
        for _ in 0..dimensions {
            generator.push(z);
            z = z * root % size;
        }
        let mut state = 0x5eed;
        let shifts = (0..shifts)
            .map(|_| (0..dimensions).map(|_| unit(&mut state)).collect())
            .collect();
        RankOneLattice {
            size,
            generator,
            shifts,
        }
    }

    /// Number of points per shift.
    pub fn points(&self) -> usize {
        self.size as usize
    }

    /// Number of shifts.
    pub fn shifts(&self) -> usize {
        self.shifts.len()
    }

    /// Coordinates of the point i of a shift, each in [0, 1).
    pub fn point(&self, shift: usize, i: usize) -> Vec<f64> {
        let coordinate = |(z, delta): (&u64, &f64)| {
            let x = (i as u64 * z % self.size) as f64 / self.size as f64;
            (x + delta).fract()
        };
        self.generator
            .iter()
            .zip(&self.shifts[shift])
            .map(coordinate)
            .collect()
    }
}

/// Uniform random number in [0, 1) by Vigna's splitmix64.
fn unit(state: &mut u64) -> f64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every coordinate takes every multiple of 1/N once, so that the mean of a wave of one cycle is zero; all dimensions differ.
    #[test]
    fn exact_means_of_waves() {
        for (n, _) in SIZES.into_iter().take(3) {
            let dimensions = (n - 1) as usize;
            let lattice = RankOneLattice::new(dimensions, n as usize, 2);
            assert_eq!(lattice.points(), n as usize);
            let mut sums = vec![0.0; dimensions];
            for i in 0..lattice.points() {
                for (sum, x) in sums.iter_mut().zip(lattice.point(1, i)) {
                    *sum += (std::f64::consts::TAU * x).cos();
                }
            }
            assert!(sums.iter().all(|s| s.abs() < 1e-9));
            let mut generator = lattice.generator.clone();
            generator.sort_unstable();
            generator.dedup();
            assert_eq!(generator.len(), dimensions);
        }
    }
}
