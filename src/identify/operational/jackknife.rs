//! The uncertainty of a pole: how it moves when one part of the record after the other is left out, and from order to order.
//!
//! Of m estimates θ_k, each without one of m parts, the covariance of θ is `(m − 1)/m Σ (θ_k − θ̄)(θ_k − θ̄)ᵀ` (Efron & Stein, Ann.
//! Statist. 9 (1981), eq. (1.4)). The pole is found at four orders and taken as their mean, weighed by certainty; what the order
//! changes is added to the variance: that of one order alone covers the truth in 88–90 % of simulated records instead of 95 %.

use std::f64::consts::TAU;

use super::realisation::{Observability, Subspaces};
use super::selection::{PoleCluster, half_width};
use crate::identify::modal::candidates::{CandidatePole, OrderPoles};
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::Complex;
use crate::numeric::mac::mac;
use crate::numeric::statistics::{Z_95, student_t_quantile};

/// Places in a cluster, by rising order, at which its pole is tried.
const EVALUATED_ORDERS: [f64; 4] = [0.10, 0.35, 0.60, 0.85];

/// Without a part of the record a pole is the same with this MAC of the shapes.
const SAME_SHAPE: f64 = 0.7;

/// A pole that is lost without more than this share of the parts is none of the whole record.
const MAX_LOST_SHARE: f64 = 1.0 / 6.0;

/// Weight of the damping ratio's deviation against the relative deviation of frequency where an order is chosen.
const DAMPING_WEIGHT: f64 = 0.3;

/// An order at which a pole scatters by more than this many times the least says nothing of how well it is known.
const MAX_SCATTER_RATIO: f64 = 3.0;

/// A pole with its uncertainty.
#[derive(Debug, Clone)]
pub struct PoleEstimate {
    /// Order at which it scatters least, and its shape is from.
    pub order: usize,
    /// With the covariance over parts and orders, widened so that 1.96 standard deviations hold the quantile of Student's t for the
    /// number of parts.
    pub mode: ModalParameters,
    /// By which its standard deviations were widened.
    pub widening: f64,
    /// Standard deviation of the frequency over the parts alone, Hz.
    pub parts_std_hz: f64,
    /// Share of all orders with this pole.
    pub presence: f64,
}

/// Poles of each order, without each part; worked out when they are first needed.
pub(super) struct JackknifePoles<'a> {
    subspaces: &'a Subspaces,
    rate_hz: f64,
    /// By part, then order.
    poles: Vec<Vec<Option<OrderPoles>>>,
}

impl<'a> JackknifePoles<'a> {
    pub fn new(subspaces: &'a Subspaces, rate_hz: f64, highest: usize) -> JackknifePoles<'a> {
        JackknifePoles {
            subspaces,
            rate_hz,
            poles: vec![vec![None; highest + 1]; subspaces.without.len()],
        }
    }

    fn poles_without(&mut self, part: usize, order: usize) -> &OrderPoles {
        let subspace: &Observability = &self.subspaces.without[part];
        let rate_hz = self.rate_hz;
        self.poles[part][order].get_or_insert_with(|| subspace.poles(order, rate_hz))
    }

    /// The estimate of a cluster, from the order at which it scatters least; none where its pole is lost without a part of the record.
    pub fn estimate(&mut self, cluster: &PoleCluster) -> Option<PoleEstimate> {
        let last = cluster.members.len() - 1;
        let mut places = EVALUATED_ORDERS.map(|share| (share * last as f64).round() as usize);
        places.sort_unstable();
        let mut tried: Vec<(usize, &CandidatePole, [f64; 3])> = Vec::new();
        for (k, place) in places.iter().enumerate() {
            if places[..k].contains(place) {
                continue;
            }
            let (order, pole) = &cluster.members[*place];
            if let Some(covariance) = self.covariance(*order, pole) {
                tried.push((*order, pole, covariance));
            }
        }
        let mode_of = |pole: &CandidatePole, covariance: [f64; 3]| ModalParameters {
            pole: pole.pole,
            pole_covariance: Some(covariance),
            shape: pole.shape.clone(),
        };
        let size = |entry: &&(usize, &CandidatePole, [f64; 3])| {
            let mode = mode_of(entry.1, entry.2);
            mode.frequency_std_hz().unwrap_or(f64::INFINITY) / mode.frequency_hz()
                + DAMPING_WEIGHT * mode.damping_std().unwrap_or(f64::INFINITY)
        };
        let &(order, pole, covariance) =
            (tried.iter()).min_by(|a, b| size(a).total_cmp(&size(b)))?;
        let least = tried.iter().map(|t| size(&t)).fold(f64::INFINITY, f64::min);
        tried.retain(|t| size(&t) <= MAX_SCATTER_RATIO * least);
        let between = scatter(
            tried.iter().map(|t| t.1),
            1.0 / (tried.len() as f64 - 1.0).max(1.0),
        );
        let parts = self.poles.len() as f64;
        let widening = student_t_quantile(0.975, parts - 1.0) / Z_95;
        let all = [0, 1, 2].map(|k| widening.powi(2) * (covariance[k] + between[k]));
        // The mean over the orders, each by its certainty, scatters less than any of them.
        let weights: Vec<f64> = tried.iter().map(|t| size(&t).powi(-2)).collect();
        let sum: f64 = weights.iter().sum();
        let mean: Complex = (tried.iter().zip(&weights))
            .map(|(t, w)| t.1.pole * (w / sum))
            .sum();
        Some(PoleEstimate {
            order,
            widening,
            parts_std_hz: mode_of(pole, covariance).frequency_std_hz()?,
            mode: ModalParameters {
                pole: mean,
                ..mode_of(pole, all)
            },
            presence: cluster.presence,
        })
    }

    /// Covariance of a pole of one order over the parts.
    fn covariance(&mut self, order: usize, pole: &CandidatePole) -> Option<[f64; 3]> {
        let parts = self.poles.len();
        let reach = 2.0 * half_width(pole.damping_ratio()) * pole.pole.norm();
        let off = |p: &CandidatePole| (p.pole - pole.pole).norm();
        let mut found: Vec<CandidatePole> = Vec::with_capacity(parts);
        for part in 0..parts {
            let same = (self.poles_without(part, order).poles.iter())
                .filter(|p| off(p) < reach && mac(&p.shape, &pole.shape) > SAME_SHAPE)
                .min_by(|a, b| off(a).total_cmp(&off(b)));
            found.extend(same.cloned());
        }
        let lost = (parts - found.len()) as f64;
        if found.len() < 3 || lost > MAX_LOST_SHARE * parts as f64 {
            return None;
        }
        let m = found.len() as f64;
        let covariance = scatter(found.iter(), (m - 1.0) / m);
        covariance
            .iter()
            .all(|x| x.is_finite())
            .then_some(covariance)
    }
}

/// `factor · Σ (p − p̄)(p − p̄)ᵀ` of real and imaginary parts.
fn scatter<'a>(poles: impl Iterator<Item = &'a CandidatePole>, factor: f64) -> [f64; 3] {
    let all: Vec<_> = poles.map(|p| p.pole).collect();
    let mean = all.iter().sum::<Complex>() / all.len() as f64;
    let mut sums = [0.0; 3];
    for pole in &all {
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
