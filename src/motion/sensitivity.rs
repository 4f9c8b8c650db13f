//! Sensitivity of a motion to its start: how many times as large a difference of two motions becomes as it was at the start,
//! `S = max |Δδ| / (ε D)`, δ the deflection of a branch, D the largest it reaches, ε the share of D by which the start is changed.
//!
//! Angles that turn are no measure: a shaft that has turned a thousand radians is wound up by microradians, and a change by a
//! share of the turned angle is larger than every deflection.

use super::dynamic_model::{DynamicModel, ForceLaw};

/// Numbers kept of a run, at most: deflections times instants.
const MAX_KEPT: usize = 4_000_000;

/// Instants at which deflections are compared, at most.
const MAX_INSTANTS: usize = 2000;

/// Share of the deflections by which the start is changed: far above rounding, far below what is known of any machine.
pub const PERTURBATION_SHARE: f64 = 1e-9;

/// The largest share where the errors of the method are larger than [`PERTURBATION_SHARE`].
const MAX_PERTURBATION_SHARE: f64 = 1e-4;

/// The change is so many times the errors of the method.
const PERTURBATION_PER_ERROR: f64 = 10.0;

/// The share of the time after which two runs differ by the errors of the method, not yet by their growth.
const EARLY_SHARE: f64 = 1.0 / 200.0;

/// Two runs have parted where deflections differ by this share of their size: the growth ends there.
const DIVERGED_SHARE: f64 = 0.1;

/// Amplification of a small change of the start.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Amplification {
    /// The largest difference of a deflection over the change, both by the size that the deflection reaches.
    pub factor: f64,
    /// Both runs parted: the difference no longer grows.
    pub is_lower_bound: bool,
    /// Share of the deflections by which the start was changed.
    pub change: f64,
}

/// Deflections of all elastic branches along a run.
#[derive(Debug, Clone)]
pub struct Deflections {
    /// Branches with a stiffness.
    branches: Vec<usize>,
    /// One sample in so many is kept.
    stride: usize,
    seen: usize,
    /// Instants, s.
    time: Vec<f64>,
    /// Instant by instant, the deflection of each branch, rad or m.
    values: Vec<f64>,
    /// The largest deflection and rate of each branch.
    largest: Vec<(f64, f64)>,
}

impl Deflections {
    /// For a run of so many samples.
    pub fn new(model: &DynamicModel, samples: usize) -> Deflections {
        let all = model.elements.iter().enumerate();
        let elastic = all.filter(|(_, b)| is_elastic(&b.law));
        let branches: Vec<usize> = elastic.map(|(at, _)| at).collect();
        let instants = (MAX_KEPT / branches.len().max(1)).clamp(1, MAX_INSTANTS);
        Deflections {
            largest: vec![(0.0, 0.0); branches.len()],
            branches,
            stride: samples / instants + 1,
            seen: 0,
            time: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Takes the next sample.
    pub fn see(&mut self, model: &DynamicModel, t: f64, y: &[f64]) {
        let due = self.seen.is_multiple_of(self.stride);
        self.seen += 1;
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

    /// A start changed by the share `by` of the size that deflections and their rates reach; coordinates that no elastic branch
    /// joins, those without inertia and inner states keep their start.
    ///
    /// Every coordinate goes its own way, so that no branch is left out because its ends move alike.
    pub fn perturbed_start(&self, model: &DynamicModel, start: &[f64], by: f64) -> Vec<f64> {
        let n = model.coordinate_count();
        let mut room = vec![f64::INFINITY; 2 * n];
        for (&at, largest) in self.branches.iter().zip(&self.largest) {
            for (i, a) in model.elements[at].direction.entries() {
                for (j, size) in [(i, largest.0), (n + i, largest.1)] {
                    let own = size / a.abs();
                    if own > 0.0 {
                        room[j] = room[j].min(own);
                    }
                }
            }
        }
        let mut moved = start.to_vec();
        for (j, room) in room.into_iter().enumerate() {
            if room.is_finite() && !model.is_massless(j % n) {
                moved[j] += by * room * way(j);
            }
        }
        moved
    }

    /// The change of the start that shows growth above the errors of the method, which `other`, by a coarser tolerance or step, shows early.
    pub fn change_above_errors(&self, other: &Deflections) -> f64 {
        let end = self.time.last().map_or(0.0, |t| EARLY_SHARE * t);
        let errors = self.max_difference(other, end);
        (PERTURBATION_PER_ERROR * errors).clamp(PERTURBATION_SHARE, MAX_PERTURBATION_SHARE)
    }

    /// Amplification of a change of the start that led to another run; absent where nothing deforms.
    pub fn amplification(&self, other: &Deflections, change: f64) -> Option<Amplification> {
        let deforms = self.largest.iter().any(|size| size.0 > 0.0);
        let most = self.max_difference(other, f64::INFINITY);
        deforms.then_some(Amplification {
            factor: most / change,
            is_lower_bound: most > DIVERGED_SHARE,
            change,
        })
    }

    /// The largest difference from another run up to an instant, by the size that each deflection reaches here.
    fn max_difference(&self, other: &Deflections, until: f64) -> f64 {
        let count = self.branches.len().max(1);
        let rows = self.values.chunks(count).zip(other.values.chunks(count));
        let rows = rows.zip(&self.time).filter(|(_, t)| **t <= until);
        let of = |(a, b): (&[f64], &[f64])| {
            let each = a.iter().zip(b).zip(&self.largest);
            let shares = each.filter(|(_, size)| size.0 > 0.0);
            shares.fold(0.0f64, |most, ((a, b), size)| {
                most.max((a - b).abs() / size.0)
            })
        };
        rows.map(|(pair, _)| of(pair)).fold(0.0, f64::max)
    }
}

/// Whether the deflection has a size: it does not turn or slip away.
fn is_elastic(law: &ForceLaw) -> bool {
    match law {
        ForceLaw::Linear { stiffness, .. } => *stiffness != 0.0,
        ForceLaw::Contact(_) | ForceLaw::Nonlinear { .. } => true,
        _ => false,
    }
}

/// A number in ±[½, 1] for each state, the same in every run: multiples of the golden ratio modulo one fill the interval evenly
/// (Weyl's sequence).
fn way(state: usize) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let x = (GOLDEN * (state + 1) as f64).fract();
    if x < 0.5 { -0.5 - x } else { x }
}

#[cfg(test)]
mod tests {
    use super::way;

    /// Every state is perturbed, no further than requested, and in both directions.
    #[test]
    fn law_every_state_is_moved() {
        let all: Vec<f64> = (0..1000).map(way).collect();
        assert!(all.iter().all(|x| (0.5..=1.0).contains(&x.abs())));
        let forward = all.iter().filter(|x| **x > 0.0).count();
        assert!((450..550).contains(&forward));
    }
}
