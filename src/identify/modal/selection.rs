//! Automatic selection of physical poles by clustering over all orders (Reynders et al. 2012).
//!
//! In three stages, after Reynders, Houbrechts & De Roeck, Mech. Syst. Signal Process. 29 (2012), 228–250, with fixed rules instead of their
//! 2-means: poles that the order before does not repeat are left out; the rest is clustered hierarchically; large clusters are modes.

use std::f64::consts::{PI, TAU};

use super::candidates::{CandidatePole, OrderPoles};
use super::clusters::cluster;
use super::stabilisation::min_mac;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::Complex;
use crate::numeric::mac::mac;
use crate::numeric::sorting::sort_rising;

/// When poles are one mode, and when a mode is physical.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelectionRule {
    /// Cut of the clustering: distance of two poles in half-power half-bandwidths, plus `1 − MAC`.
    pub cluster_cut: f64,
    /// Least share of all orders in which a physical mode appears.
    pub presence: f64,
    /// Largest damping ratio of a physical mode.
    pub max_damping_ratio: f64,
}

impl Default for SelectionRule {
    /// 0.5 half-bandwidths, a third of the orders, damping ratio 0.3.
    fn default() -> Self {
        SelectionRule {
            cluster_cut: 0.5,
            presence: 1.0 / 3.0,
            max_damping_ratio: 0.3,
        }
    }
}

impl SelectionRule {
    /// The rule as a sentence for a report.
    pub fn rule_text(&self) -> String {
        format!(
            "poles with a damping ratio up to {} that the order before repeats are clustered by average linkage, cut at {} half-bandwidths \
             (MAC counted), and a cluster with poles of at least {:.0} % of the orders is a mode, given by its median pole",
            self.max_damping_ratio,
            self.cluster_cut,
            100.0 * self.presence
        )
    }
}

/// A physical mode with what its cluster tells.
#[derive(Debug, Clone)]
pub struct SelectedMode {
    /// Median pole of the cluster, with shape of the member next to it; no covariance.
    pub mode: ModalParameters,
    /// Participation over the inputs, of the same member.
    pub participation: Vec<Complex>,
    /// Standard deviation of the frequency over the cluster, Hz. An indication only: orders share their data, so it is no uncertainty.
    pub scatter_hz: f64,
    /// Standard deviation of the damping ratio over the cluster; an indication only.
    pub scatter_damping: f64,
    /// Share of all orders with a pole in the cluster.
    pub presence: f64,
}

/// Physical modes by rising frequency. `spacing_hz` is the distance of the lines, below which bandwidths are not distinguished.
pub fn select_modes(
    orders: &[OrderPoles],
    spacing_hz: f64,
    rule: &SelectionRule,
) -> Vec<SelectedMode> {
    let apart = |a: &CandidatePole, b: &CandidatePole| {
        let half_band = (a.pole.re.abs() + b.pole.re.abs()) / 2.0 + PI * spacing_hz;
        (a.pole - b.pole).norm() / half_band + 1.0 - min_mac(a, b)
    };
    let mut repeated: Vec<(usize, &CandidatePole)> = Vec::new();
    for pair in orders.windows(2) {
        for pole in &pair[1].poles {
            let is_damped = pole.pole.re < 0.0 && pole.damping_ratio() <= rule.max_damping_ratio;
            if is_damped
                && pair[0]
                    .poles
                    .iter()
                    .any(|b| apart(pole, b) <= rule.cluster_cut)
            {
                repeated.push((pair[1].order, pole));
            }
        }
    }
    let distance = |i: usize, j: usize| apart(repeated[i].1, repeated[j].1);
    let least = (rule.presence * orders.len() as f64).max(2.0);
    let mut modes: Vec<SelectedMode> = cluster(repeated.len(), distance, rule.cluster_cut)
        .into_iter()
        .filter_map(|members| {
            let members: Vec<_> = members.into_iter().map(|i| repeated[i]).collect();
            let mut present: Vec<usize> = members.iter().map(|m| m.0).collect();
            present.dedup();
            let poles: Vec<&CandidatePole> = members.into_iter().map(|m| m.1).collect();
            let share = present.len() as f64 / orders.len().max(1) as f64;
            (present.len() as f64 >= least).then(|| cluster_mode(&poles, share))
        })
        .collect();
    sort_rising(&mut modes, |a| a.mode.pole.norm());
    merge_duplicates(modes)
}

/// Merges two modes of one shape within their own bandwidth, which result where responses disagree about a pole; keeps the more present
/// one.
fn merge_duplicates(modes: Vec<SelectedMode>) -> Vec<SelectedMode> {
    const DUPLICATE_MAC: f64 = 0.8;
    const DUPLICATE_DISTANCE: f64 = 0.2; // of half the bandwidth: no two modes are told apart there
    let double = |a: &SelectedMode, b: &SelectedMode| {
        let (p, q) = (a.mode.pole, b.mode.pole);
        let (distance, half_band) = ((p.im - q.im).abs(), p.re.abs().max(q.re.abs()));
        if distance < DUPLICATE_DISTANCE * half_band {
            return b.presence > a.presence;
        }
        let near = distance < half_band;
        let alike = a.mode.shape.is_empty() || mac(&a.mode.shape, &b.mode.shape) > DUPLICATE_MAC;
        near && alike && (b.presence > a.presence)
    };
    let kept: Vec<bool> = (modes.iter())
        .map(|a| !modes.iter().any(|b| double(a, b)))
        .collect();
    let both = modes.into_iter().zip(kept);
    both.filter(|m| m.1).map(|m| m.0).collect()
}

fn cluster_mode(poles: &[&CandidatePole], presence: f64) -> SelectedMode {
    let pole = Complex::new(
        median(poles.iter().map(|p| p.pole.re).collect()),
        median(poles.iter().map(|p| p.pole.im).collect()),
    );
    let mut nearest = poles[0];
    for candidate in poles {
        if (candidate.pole - pole).norm() < (nearest.pole - pole).norm() {
            nearest = candidate;
        }
    }
    SelectedMode {
        mode: ModalParameters {
            pole,
            pole_covariance: None,
            shape: nearest.shape.clone(),
        },
        participation: nearest.participation.clone(),
        scatter_hz: deviation(poles.iter().map(|p| p.pole.norm() / TAU)),
        scatter_damping: deviation(poles.iter().map(|p| p.damping_ratio())),
        presence,
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len();
    (values[(n - 1) / 2] + values[n / 2]) / 2.0
}

fn deviation(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    (values.map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0)).sqrt()
}
