//! Automatic mode selection from SSI poles over all orders.
//!
//! After Reynders, Houbrechts & De Roeck, Mech. Syst. Signal Process. 29 (2012), 228–250, with fixed thresholds instead of 2-means: poles
//! not repeated at an adjacent order are rejected; the others are clustered hierarchically by frequency and shape.

use std::f64::consts::TAU;

use crate::identify::modal::candidates::{CandidatePole, OrderPoles};
use crate::identify::modal::clusters::cluster;
use crate::numeric::mac::mac;
use crate::numeric::sorting::sort_ascending;

/// Damping ratio above which poles are noise poles.
pub const MAX_DAMPING: f64 = 0.2;

/// Relative frequency tolerance of a pole repeated at an adjacent order.
const SAME_FREQUENCY: f64 = 0.01;

/// Relative damping tolerance of a repeated pole.
const SAME_DAMPING: f64 = 0.5;

/// Minimum MAC of a repeated pole.
const SAME_SHAPE: f64 = 0.9;

/// Value of `1 − MAC` that counts as one cluster width in the pole distance.
const SHAPE_WIDTH: f64 = 0.25;

/// Limits of the half width of a cluster, relative to its frequency; between them it is half the damping ratio.
const CLUSTER_HALF_WIDTH: (f64, f64) = (0.004, 0.03);

/// Minimum share of orders with a second pole for splitting a cluster.
const SPLIT_SHARE: f64 = 0.25;

/// Minimum share of all orders in a cluster.
const MIN_PRESENCE: f64 = 0.35;

/// Minimum share of the orders from the first one of the cluster on.
const MIN_PRESENCE_SINCE_FIRST: f64 = 0.5;

/// Cluster of one pole per order, in ascending order.
#[derive(Debug, Clone)]
pub struct PoleCluster {
    /// Model order and pole.
    pub members: Vec<(usize, CandidatePole)>,
    /// Share of all orders in the cluster, 0 to 1.
    pub presence: f64,
}

/// Half width of a cluster at a damping ratio, relative to the frequency.
pub fn half_width(damping_ratio: f64) -> f64 {
    (damping_ratio / 2.0).clamp(CLUSTER_HALF_WIDTH.0, CLUSTER_HALF_WIDTH.1)
}

/// Clusters with poles of enough orders, in ascending order of frequency; poles outside `band_hz` are ignored.
pub fn clusters(orders: &[OrderPoles], band_hz: (f64, f64)) -> Vec<PoleCluster> {
    let is_candidate = |p: &&CandidatePole| {
        let f = p.pole.norm() / TAU;
        p.pole.re < 0.0 && p.damping_ratio() < MAX_DAMPING && f >= band_hz.0 && f <= band_hz.1
    };
    let mut repeated: Vec<(usize, &CandidatePole)> = Vec::new();
    for (k, order) in orders.iter().enumerate() {
        let neighbours = [k.checked_sub(1), Some(k + 1)];
        let adjacent: Vec<&CandidatePole> = (neighbours.into_iter().flatten())
            .filter_map(|j| orders.get(j))
            .flat_map(|o| &o.poles)
            .collect();
        let is_repeated = |p: &&CandidatePole| adjacent.iter().any(|other| repeats(p, other));
        let stable = order.poles.iter().filter(is_candidate).filter(is_repeated);
        repeated.extend(stable.map(|p| (k, p)));
    }
    let distance = |i: usize, j: usize| pole_distance(repeated[i].1, repeated[j].1);
    let mut clusters: Vec<PoleCluster> = cluster(repeated.len(), distance, 1.0)
        .into_iter()
        .map(|members| members.into_iter().map(|i| repeated[i]).collect())
        .flat_map(split_cluster)
        .filter_map(|members| representative(members, orders))
        .collect();
    sort_ascending(&mut clusters, |a| a.frequency());
    clusters
}

impl PoleCluster {
    /// Median frequency, Hz.
    pub fn frequency(&self) -> f64 {
        let mut values: Vec<f64> = (self.members.iter())
            .map(|m| m.1.pole.norm() / TAU)
            .collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or(0.0)
    }
}

/// Whether a pole `b` of another order repeats pole `a`.
fn repeats(a: &CandidatePole, b: &CandidatePole) -> bool {
    let is_close = |x: f64, y: f64, share: f64| (x - y).abs() <= share * x.abs();
    is_close(a.pole.norm(), b.pole.norm(), SAME_FREQUENCY)
        && is_close(a.damping_ratio(), b.damping_ratio(), SAME_DAMPING)
        && mac(&a.shape, &b.shape) > SAME_SHAPE
}

/// Distance of two poles in frequency and shape, normalised to the clustering threshold 1.
fn pole_distance(a: &CandidatePole, b: &CandidatePole) -> f64 {
    let (f, g) = (a.pole.norm(), b.pole.norm());
    let width = half_width(0.5 * (a.damping_ratio() + b.damping_ratio()));
    (f - g).abs() / (0.5 * (f + g)) / (2.0 * width) + (1.0 - mac(&a.shape, &b.shape)) / SHAPE_WIDTH
}

type ClusterMembers<'a> = Vec<(usize, &'a CandidatePole)>;

/// Splits a cluster recursively at its largest frequency gap while many of its orders have two poles.
fn split_cluster(mut members: ClusterMembers) -> Vec<ClusterMembers> {
    let mut orders: Vec<usize> = members.iter().map(|m| m.0).collect();
    orders.sort_unstable();
    orders.dedup();
    if ((members.len() - orders.len()) as f64) < SPLIT_SHARE * orders.len() as f64
        || members.len() < 4
    {
        return vec![members];
    }
    sort_ascending(&mut members, |a| a.1.pole.norm());
    let gap = |k: &usize| members[k + 1].1.pole.norm() - members[*k].1.pole.norm();
    let widest = (0..members.len() - 1).max_by(|a, b| gap(a).total_cmp(&gap(b)));
    let upper = members.split_off(widest.unwrap_or(0) + 1);
    [split_cluster(members), split_cluster(upper)].concat()
}

/// Reduces a cluster to the pole nearest the median frequency at each order; `None` with too few orders.
fn representative(mut members: ClusterMembers, orders: &[OrderPoles]) -> Option<PoleCluster> {
    let mut frequencies: Vec<f64> = members.iter().map(|m| m.1.pole.norm()).collect();
    frequencies.sort_by(f64::total_cmp);
    let median = frequencies[frequencies.len() / 2];
    let distance = |m: &(usize, &CandidatePole)| (m.1.pole.norm() - median).abs();
    members.sort_by(|a, b| a.0.cmp(&b.0).then(distance(a).total_cmp(&distance(b))));
    members.dedup_by_key(|m| m.0);
    let count = members.len() as f64;
    let since_first = (orders.len() - members.first()?.0) as f64;
    let presence = count / orders.len() as f64;
    (presence >= MIN_PRESENCE
        && count >= MIN_PRESENCE_SINCE_FIRST * since_first
        && members.len() >= 2)
        .then(|| PoleCluster {
            members: (members.into_iter())
                .map(|(k, p)| (orders[k].order, p.clone()))
                .collect(),
            presence,
        })
}
