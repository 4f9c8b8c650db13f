//! Uncertainty of a pole by the jackknife over parts of the record, with its variation over model orders.
//!
//! From m estimates θ_k, each without one of m parts, the covariance of θ is `(m − 1)/m Σ (θ_k − θ̄)(θ_k − θ̄)ᵀ` (Efron & Stein, Ann.
//! Statist. 9 (1981), eq. (1.4)). The pole is the weighted mean over four orders. The variance between orders is added, because the
//! 95 % interval of a single order contains the true value in only 88–90 % of simulated records.

use std::f64::consts::TAU;

use super::realisation::{Observability, Subspaces};
use super::selection::{PoleCluster, half_width};
use crate::identify::modal::candidates::{CandidatePole, OrderPoles};
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::Complex;
use crate::numeric::mac::mac;
use crate::numeric::statistics::{Z_95, student_t_quantile};

/// Relative positions in a cluster, in ascending order of the model, at which its pole is evaluated.
const EVALUATED_ORDERS: [f64; 4] = [0.10, 0.35, 0.60, 0.85];

/// Minimum MAC between the pole of the full record and that without a part.
const MIN_MAC: f64 = 0.7;

/// Maximum share of parts without which the pole is not identified.
const MAX_LOST_SHARE: f64 = 1.0 / 6.0;

/// Weight of the standard deviation of the damping ratio against the relative one of the frequency in the scatter of an order.
const DAMPING_WEIGHT: f64 = 0.3;

/// Maximum scatter of an order relative to the smallest; other orders are excluded.
const MAX_SCATTER_RATIO: f64 = 3.0;

/// Identified pole with its uncertainty.
#[derive(Debug, Clone)]
pub struct PoleEstimate {
    /// Model order with the smallest scatter, which gives the shape.
    pub order: usize,
    /// Pole, shape and covariance over parts and orders; 1.96 standard deviations are the 95 % interval of Student's t for the number
    /// of parts.
    pub mode: ModalParameters,
    /// Factor of Student's t over the normal distribution in the standard deviations.
    pub widening: f64,
    /// Standard deviation of the frequency over the parts alone, Hz.
    pub parts_std_hz: f64,
    /// Share of all orders with this pole, 0 to 1.
    pub presence: f64,
}

/// Poles of each order without each part, computed on demand.
pub(super) struct JackknifePoles<'a> {
    subspaces: &'a Subspaces,
    rate_hz: f64,
    /// Cached poles by part and order.
    poles: Vec<Vec<Option<OrderPoles>>>,
}

impl<'a> JackknifePoles<'a> {
    pub fn new(subspaces: &'a Subspaces, rate_hz: f64, highest: usize) -> JackknifePoles<'a> {
        JackknifePoles {
            subspaces,
            rate_hz,
            poles: vec![vec![None; highest + 1]; subspaces.leave_one_out.len()],
        }
    }

    fn poles_without(&mut self, part: usize, order: usize) -> &OrderPoles {
        let subspace: &Observability = &self.subspaces.leave_one_out[part];
        let rate_hz = self.rate_hz;
        self.poles[part][order].get_or_insert_with(|| subspace.poles(order, rate_hz))
    }

    /// Pole estimate of a cluster; `None` where the pole is not identified without some parts of the record.
    pub fn estimate(&mut self, cluster: &PoleCluster) -> Option<PoleEstimate> {
        let last = cluster.members.len() - 1;
        let mut positions = EVALUATED_ORDERS.map(|share| (share * last as f64).round() as usize);
        positions.sort_unstable();
        let mut poles: Vec<(usize, &CandidatePole, [f64; 3])> = Vec::new();
        for (k, position) in positions.iter().enumerate() {
            if positions[..k].contains(position) {
                continue;
            }
            let (order, pole) = &cluster.members[*position];
            if let Some(covariance) = self.covariance(*order, pole) {
                poles.push((*order, pole, covariance));
            }
        }
        let mode_of = |pole: &CandidatePole, covariance: [f64; 3]| ModalParameters {
            pole: pole.pole,
            pole_covariance: Some(covariance),
            shape: pole.shape.clone(),
        };
        let norm = |entry: &&(usize, &CandidatePole, [f64; 3])| {
            let mode = mode_of(entry.1, entry.2);
            mode.frequency_std_hz().unwrap_or(f64::INFINITY) / mode.frequency_hz()
                + DAMPING_WEIGHT * mode.damping_std().unwrap_or(f64::INFINITY)
        };
        let &(order, pole, covariance) =
            (poles.iter()).min_by(|a, b| norm(a).total_cmp(&norm(b)))?;
        let least = poles.iter().map(|t| norm(&t)).fold(f64::INFINITY, f64::min);
        poles.retain(|t| norm(&t) <= MAX_SCATTER_RATIO * least);
        let between = scatter(
            poles.iter().map(|t| t.1),
            1.0 / (poles.len() as f64 - 1.0).max(1.0),
        );
        let parts = self.poles.len() as f64;
        let widening = student_t_quantile(0.975, parts - 1.0) / Z_95;
        let total = [0, 1, 2].map(|k| widening.powi(2) * (covariance[k] + between[k]));
        // The mean over the orders, weighted by inverse squared scatter, has a smaller variance than any of them.
        let weights: Vec<f64> = poles.iter().map(|t| norm(&t).powi(-2)).collect();
        let sum: f64 = weights.iter().sum();
        let mean: Complex = (poles.iter().zip(&weights))
            .map(|(t, w)| t.1.pole * (w / sum))
            .sum();
        Some(PoleEstimate {
            order,
            widening,
            parts_std_hz: mode_of(pole, covariance).frequency_std_hz()?,
            mode: ModalParameters {
                pole: mean,
                ..mode_of(pole, total)
            },
            presence: cluster.presence,
        })
    }

    /// Jackknife covariance of a pole of one order over the parts, (rad/s)²; `None` where too many parts lack it.
    fn covariance(&mut self, order: usize, pole: &CandidatePole) -> Option<[f64; 3]> {
        let parts = self.poles.len();
        let radius = 2.0 * half_width(pole.damping_ratio()) * pole.pole.norm();
        let distance = |p: &CandidatePole| (p.pole - pole.pole).norm();
        let mut replicates: Vec<CandidatePole> = Vec::with_capacity(parts);
        for part in 0..parts {
            let replicate = (self.poles_without(part, order).poles.iter())
                .filter(|p| distance(p) < radius && mac(&p.shape, &pole.shape) > MIN_MAC)
                .min_by(|a, b| distance(a).total_cmp(&distance(b)));
            replicates.extend(replicate.cloned());
        }
        let missing = (parts - replicates.len()) as f64;
        if replicates.len() < 3 || missing > MAX_LOST_SHARE * parts as f64 {
            return None;
        }
        let m = replicates.len() as f64;
        let covariance = scatter(replicates.iter(), (m - 1.0) / m);
        covariance
            .iter()
            .all(|x| x.is_finite())
            .then_some(covariance)
    }
}

/// Variances and covariance `factor · Σ (p − p̄)(p − p̄)ᵀ` of real and imaginary parts.
fn scatter<'a>(poles: impl Iterator<Item = &'a CandidatePole>, factor: f64) -> [f64; 3] {
    let poles: Vec<_> = poles.map(|p| p.pole).collect();
    let mean = poles.iter().sum::<Complex>() / poles.len() as f64;
    let mut sums = [0.0; 3];
    for pole in &poles {
        let d = pole - mean;
        sums[0] += factor * d.re * d.re;
        sums[1] += factor * d.im * d.im;
        sums[2] += factor * d.re * d.im;
    }
    sums
}

/// Half-power half-bandwidth of a mode, Hz.
pub fn half_band_hz(mode: &ModalParameters) -> f64 {
    mode.pole.re.abs() / TAU
}
