//! Sensitivity to initial conditions, `S = max |Δδ| / (ε D)`: the amplification of an initial perturbation, with δ the deflection of
//! a branch, D its largest magnitude and ε D the perturbation.
//!
//! Rotation angles are no measure: a shaft that has rotated by a thousand radians is wound up by microradians, and a change
//! relative to the rotation angle exceeds every deflection.

use super::dynamic_model::{DynamicModel, ForceLaw};

/// Maximum number of stored deflections times instants.
const MAX_STORED: usize = 4_000_000;

/// Maximum number of instants at which deflections are compared.
const MAX_INSTANTS: usize = 2000;

/// Initial perturbation relative to the deflections: far above rounding, far below any measurement uncertainty.
pub const PERTURBATION_SHARE: f64 = 1e-9;

/// Largest perturbation if the integration errors exceed [`PERTURBATION_SHARE`].
const MAX_PERTURBATION_SHARE: f64 = 1e-4;

/// Ratio of the perturbation to the integration errors.
const PERTURBATION_PER_ERROR: f64 = 10.0;

/// Initial fraction of the run in which two runs differ by integration errors, not by their growth.
const EARLY_SHARE: f64 = 1.0 / 200.0;

/// Relative difference of deflections at which two runs have diverged and growth ends.
const DIVERGED_SHARE: f64 = 0.1;

/// Amplification of a small initial perturbation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplification {
    /// Largest difference of a deflection over the perturbation, both relative to the largest deflection.
    pub factor: f64,
    /// The runs diverged: the difference no longer grows.
    pub is_lower_bound: bool,
    /// Initial perturbation relative to the deflections.
    pub change: f64,
}

/// Deflection histories of all elastic branches of a run.
#[derive(Debug, Clone)]
pub struct Deflections {
    /// Indices of the elastic branches.
    branches: Vec<usize>,
    /// Number of samples per stored sample.
    stride: usize,
    n_samples: usize,
    /// Instants, s.
    time: Vec<f64>,
    /// Deflection of each branch at each instant, rad or m.
    values: Vec<f64>,
    /// Largest deflection, rad or m, and rate, rad/s or m/s, of each branch.
    largest: Vec<(f64, f64)>,
}

impl Deflections {
    /// Empty histories for a run of a number of samples.
    pub fn new(model: &DynamicModel, samples: usize) -> Deflections {
        let all = model.elements.iter().enumerate();
        let elastic = all.filter(|(_, b)| is_elastic(&b.law));
        let branches: Vec<usize> = elastic.map(|(index, _)| index).collect();
        let instants = (MAX_STORED / branches.len().max(1)).clamp(1, MAX_INSTANTS);
        Deflections {
            largest: vec![(0.0, 0.0); branches.len()],
            branches,
            stride: samples / instants + 1,
            n_samples: 0,
            time: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Records the next sample.
    pub fn see(&mut self, model: &DynamicModel, t: f64, y: &[f64]) {
        let due = self.n_samples.is_multiple_of(self.stride);
        self.n_samples += 1;
        if !due {
            return;
        }
        let n = model.coordinate_count();
        self.time.push(t);
        for (&at, largest) in self.branches.iter().zip(&mut self.largest) {
            let branch = &model.elements[at];
            let pieces = branch.pieces_at(t);
            let (delta, rate) = branch.deflection(t, &y[..n], &y[n..2 * n], pieces);
            largest.0 = largest.0.max(delta.abs());
            largest.1 = largest.1.max(rate.abs());
            self.values.push(delta);
        }
    }

    /// Perturbed initial state: coordinates change by `by` times the largest deflection and speeds by `by` times the largest rate.
    /// Coordinates without elastic branch or inertia and internal states are unchanged.
    ///
    /// Perturbations differ between coordinates, so that every branch deflects.
    pub fn perturbed_start(&self, model: &DynamicModel, start: &[f64], by: f64) -> Vec<f64> {
        let n = model.coordinate_count();
        let mut limits = vec![f64::INFINITY; 2 * n];
        for (&index, largest) in self.branches.iter().zip(&self.largest) {
            for (i, a) in model.elements[index].direction.entries() {
                for (j, size) in [(i, largest.0), (n + i, largest.1)] {
                    let limit = size / a.abs();
                    if limit > 0.0 {
                        limits[j] = limits[j].min(limit);
                    }
                }
            }
        }
        let mut moved = start.to_vec();
        for (j, limit) in limits.into_iter().enumerate() {
            if limit.is_finite() && !model.is_massless(j % n) {
                moved[j] += by * limit * weyl(j);
            }
        }
        moved
    }

    /// Perturbation that exceeds the integration errors, estimated by the early difference from `other` at a coarser tolerance or step.
    pub fn change_above_errors(&self, other: &Deflections) -> f64 {
        let end = self.time.last().map_or(0.0, |t| EARLY_SHARE * t);
        let errors = self.max_difference(other, end);
        (PERTURBATION_PER_ERROR * errors).clamp(PERTURBATION_SHARE, MAX_PERTURBATION_SHARE)
    }

    /// Amplification of an initial perturbation that led to the other run; absent without deflection.
    pub fn amplification(&self, other: &Deflections, change: f64) -> Option<Amplification> {
        let deforms = self.largest.iter().any(|size| size.0 > 0.0);
        let largest = self.max_difference(other, f64::INFINITY);
        deforms.then_some(Amplification {
            factor: largest / change,
            is_lower_bound: largest > DIVERGED_SHARE,
            change,
        })
    }

    /// Largest difference from another run up to an instant, relative to the largest deflection of each branch.
    fn max_difference(&self, other: &Deflections, until: f64) -> f64 {
        let count = self.branches.len().max(1);
        let rows = self.values.chunks(count).zip(other.values.chunks(count));
        let rows = rows.zip(&self.time).filter(|(_, t)| **t <= until);
        let norm = |(a, b): (&[f64], &[f64])| {
            let branches = a.iter().zip(b).zip(&self.largest);
            let shares = branches.filter(|(_, size)| size.0 > 0.0);
            shares.fold(0.0f64, |largest, ((a, b), size)| {
                largest.max((a - b).abs() / size.0)
            })
        };
        rows.map(|(pair, _)| norm(pair)).fold(0.0, f64::max)
    }
}

/// Whether a branch is elastic: its deflection is bounded, without rotation or slip.
fn is_elastic(law: &ForceLaw) -> bool {
    match law {
        ForceLaw::Linear { stiffness, .. } => *stiffness != 0.0,
        ForceLaw::Contact(_) | ForceLaw::Nonlinear { .. } => true,
        _ => false,
    }
}

/// Perturbation factor in ±[½, 1] of each state, reproducible: multiples of the golden ratio modulo one are equidistributed
/// (Weyl's sequence).
fn weyl(state: usize) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let x = (GOLDEN * (state + 1) as f64).fract();
    if x < 0.5 { -0.5 - x } else { x }
}

#[cfg(test)]
mod tests {
    use super::weyl;

    /// Every state is perturbed, no further than requested, and in both directions.
    #[test]
    fn law_every_state_is_moved() {
        let all: Vec<f64> = (0..1000).map(weyl).collect();
        assert!(all.iter().all(|x| (0.5..=1.0).contains(&x.abs())));
        let forward = all.iter().filter(|x| **x > 0.0).count();
        assert!((450..550).contains(&forward));
    }
}
