//! Automatic selection of physical poles by clustering over all orders (Reynders et al. 2012).
//!
//! Three stages after Reynders, Houbrechts & De Roeck, Mech. Syst. Signal Process. 29 (2012), 228–250, with fixed thresholds instead of
//! 2-means: poles not repeated from the preceding order are rejected, the others are clustered hierarchically, large clusters are modes.

use std::f64::consts::{PI, TAU};

use super::candidates::{CandidatePole, OrderPoles};
use super::clusters::cluster;
use super::stabilisation::min_mac;
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::Complex;
use crate::numeric::mac::mac;
use crate::numeric::sorting::sort_ascending;

/// Thresholds of the clustering and of the selection of physical modes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SelectionRule {
    /// Cluster threshold: distance of two poles in half-power half-bandwidths plus `1 − MAC`.
    pub cluster_cut: f64,
    /// Minimum share of all orders with a pole of a physical mode, 0 to 1.
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
    /// Description of the rule as a sentence for a report.
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

/// Physical mode with the statistics of its cluster.
#[derive(Debug, Clone)]
pub struct SelectedMode {
    /// Median pole of the cluster with the shape of the nearest member; no covariance.
    pub mode: ModalParameters,
    /// Participation factors over the inputs, of the same member.
    pub participation: Vec<Complex>,
    /// Standard deviation of the frequency over the cluster, Hz; not an uncertainty, because all orders use the same data.
    pub scatter_hz: f64,
    /// Standard deviation of the damping ratio over the cluster; not an uncertainty either.
    pub scatter_damping: f64,
    /// Share of all orders with a pole in the cluster, 0 to 1.
    pub presence: f64,
}

/// Physical modes in ascending order of frequency. `spacing_hz` is the line spacing, which is added to the bandwidths in the pole distance.
pub fn select_modes(
    orders: &[OrderPoles],
    spacing_hz: f64,
    rule: &SelectionRule,
) -> Vec<SelectedMode> {
    let pole_distance = |a: &CandidatePole, b: &CandidatePole| {
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
                    .any(|b| pole_distance(pole, b) <= rule.cluster_cut)
            {
                repeated.push((pair[1].order, pole));
            }
        }
    }
    let distance = |i: usize, j: usize| pole_distance(repeated[i].1, repeated[j].1);
    let min_orders = (rule.presence * orders.len() as f64).max(2.0);
    let mut modes: Vec<SelectedMode> = cluster(repeated.len(), distance, rule.cluster_cut)
        .into_iter()
        .filter_map(|members| {
            let members: Vec<_> = members.into_iter().map(|i| repeated[i]).collect();
            let mut orders_present: Vec<usize> = members.iter().map(|m| m.0).collect();
            orders_present.dedup();
            let poles: Vec<&CandidatePole> = members.into_iter().map(|m| m.1).collect();
            let share = orders_present.len() as f64 / orders.len().max(1) as f64;
            (orders_present.len() as f64 >= min_orders).then(|| cluster_mode(&poles, share))
        })
        .collect();
    sort_ascending(&mut modes, |a| a.mode.pole.norm());
    merge_duplicates(modes)
}

/// Merges two modes of similar shape within their bandwidth, which result from inconsistent poles of the responses; the mode of larger
/// presence remains.
fn merge_duplicates(modes: Vec<SelectedMode>) -> Vec<SelectedMode> {
    const DUPLICATE_MAC: f64 = 0.8;
    const DUPLICATE_DISTANCE: f64 = 0.2; // of half the bandwidth: closer modes cannot be distinguished
    let is_duplicate = |a: &SelectedMode, b: &SelectedMode| {
        let (p, q) = (a.mode.pole, b.mode.pole);
        let (distance, half_band) = ((p.im - q.im).abs(), p.re.abs().max(q.re.abs()));
        if distance < DUPLICATE_DISTANCE * half_band {
            return b.presence > a.presence;
        }
        let is_near = distance < half_band;
        let is_same = a.mode.shape.is_empty() || mac(&a.mode.shape, &b.mode.shape) > DUPLICATE_MAC;
        is_near && is_same && (b.presence > a.presence)
    };
    let keep: Vec<bool> = (modes.iter())
        .map(|a| !modes.iter().any(|b| is_duplicate(a, b)))
        .collect();
    let pairs = modes.into_iter().zip(keep);
    pairs.filter(|m| m.1).map(|m| m.0).collect()
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
