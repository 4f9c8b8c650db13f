//! Automatic mode selection from SSI poles over all orders.
//!
//! In the manner of Reynders, Houbrechts & De Roeck, Mech. Syst. Signal Process. 29 (2012), 228–250, with fixed rules instead of their
//! 2-means: a pole that no neighbouring order repeats is left out; the rest is clustered hierarchically by frequency and shape.

use std::f64::consts::TAU;

use crate::identify::modal::candidates::{CandidatePole, OrderPoles};
use crate::identify::modal::clusters::cluster;
use crate::numeric::mac::mac;
use crate::numeric::sorting::sort_rising;

/// Poles above this damping ratio model noise.
pub const MAX_DAMPING: f64 = 0.2;

/// A neighbouring order repeats a pole within this share of its frequency, …
const SAME_FREQUENCY: f64 = 0.01;

/// … this share of its damping ratio, …
const SAME_DAMPING: f64 = 0.5;

/// … and with this MAC of the shapes.
const SAME_SHAPE: f64 = 0.9;

/// Shapes as far apart as the width of a cluster allows differ by so much of `1 − MAC`.
const SHAPE_WIDTH: f64 = 0.25;

/// Least and largest half width of a cluster, relative to its frequency; between them half the damping ratio.
const CLUSTER_HALF_WIDTH: (f64, f64) = (0.004, 0.03);

/// Share of a cluster's orders with a second pole, from which on it is two clusters.
const SPLIT_SHARE: f64 = 0.25;

/// Least share of all orders in a cluster, …
const MIN_PRESENCE: f64 = 0.35;

/// … and of the orders from its first on.
const MIN_PRESENCE_SINCE_FIRST: f64 = 0.5;

/// One pole for each of the orders of a cluster, by rising order.
#[derive(Debug, Clone)]
pub struct PoleCluster {
    /// Order of the model and its pole.
    pub members: Vec<(usize, CandidatePole)>,
    /// Share of all orders.
    pub presence: f64,
}

/// Half width in which poles about this one are the same, relative to the frequency.
pub fn half_width(damping_ratio: f64) -> f64 {
    (damping_ratio / 2.0).clamp(CLUSTER_HALF_WIDTH.0, CLUSTER_HALF_WIDTH.1)
}

/// Clusters that enough orders share, by rising frequency; poles outside `band_hz` are not looked at.
pub fn clusters(orders: &[OrderPoles], band_hz: (f64, f64)) -> Vec<PoleCluster> {
    let inside = |p: &&CandidatePole| {
        let f = p.pole.norm() / TAU;
        p.pole.re < 0.0 && p.damping_ratio() < MAX_DAMPING && f >= band_hz.0 && f <= band_hz.1
    };
    let mut repeated: Vec<(usize, &CandidatePole)> = Vec::new();
    for (k, order) in orders.iter().enumerate() {
        let neighbours = [k.checked_sub(1), Some(k + 1)];
        let others: Vec<&CandidatePole> = (neighbours.into_iter().flatten())
            .filter_map(|j| orders.get(j))
            .flat_map(|o| &o.poles)
            .collect();
        let comes_back = |p: &&CandidatePole| others.iter().any(|other| repeats(p, other));
        let kept = order.poles.iter().filter(inside).filter(comes_back);
        repeated.extend(kept.map(|p| (k, p)));
    }
    let distance = |i: usize, j: usize| pole_distance(repeated[i].1, repeated[j].1);
    let mut found: Vec<PoleCluster> = cluster(repeated.len(), distance, 1.0)
        .into_iter()
        .map(|members| members.into_iter().map(|i| repeated[i]).collect())
        .flat_map(split_cluster)
        .filter_map(|members| common(members, orders))
        .collect();
    sort_rising(&mut found, |a| a.frequency());
    found
}

impl PoleCluster {
    /// Median frequency, Hz.
    pub fn frequency(&self) -> f64 {
        let mut all: Vec<f64> = (self.members.iter())
            .map(|m| m.1.pole.norm() / TAU)
            .collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).copied().unwrap_or(0.0)
    }
}

/// Whether a pole of another order is the same.
fn repeats(a: &CandidatePole, b: &CandidatePole) -> bool {
    let near = |x: f64, y: f64, share: f64| (x - y).abs() <= share * x.abs();
    near(a.pole.norm(), b.pole.norm(), SAME_FREQUENCY)
        && near(a.damping_ratio(), b.damping_ratio(), SAME_DAMPING)
        && mac(&a.shape, &b.shape) > SAME_SHAPE
}

/// Distance of two poles, 1 where they part.
fn pole_distance(a: &CandidatePole, b: &CandidatePole) -> f64 {
    let (f, g) = (a.pole.norm(), b.pole.norm());
    let width = half_width(0.5 * (a.damping_ratio() + b.damping_ratio()));
    (f - g).abs() / (0.5 * (f + g)) / (2.0 * width) + (1.0 - mac(&a.shape, &b.shape)) / SHAPE_WIDTH
}

type ClusterMembers<'a> = Vec<(usize, &'a CandidatePole)>;

/// A cluster with two poles in many orders, cut at the largest gap of frequency until none is left.
fn split_cluster(mut members: ClusterMembers) -> Vec<ClusterMembers> {
    let mut orders: Vec<usize> = members.iter().map(|m| m.0).collect();
    orders.sort_unstable();
    orders.dedup();
    if ((members.len() - orders.len()) as f64) < SPLIT_SHARE * orders.len() as f64
        || members.len() < 4
    {
        return vec![members];
    }
    sort_rising(&mut members, |a| a.1.pole.norm());
    let gap = |k: &usize| members[k + 1].1.pole.norm() - members[*k].1.pole.norm();
    let widest = (0..members.len() - 1).max_by(|a, b| gap(a).total_cmp(&gap(b)));
    let upper = members.split_off(widest.unwrap_or(0) + 1);
    [split_cluster(members), split_cluster(upper)].concat()
}

/// One pole for each order, that nearest to the median frequency, where enough orders have one.
fn common(mut members: ClusterMembers, orders: &[OrderPoles]) -> Option<PoleCluster> {
    let mut frequencies: Vec<f64> = members.iter().map(|m| m.1.pole.norm()).collect();
    frequencies.sort_by(f64::total_cmp);
    let middle = frequencies[frequencies.len() / 2];
    let off = |m: &(usize, &CandidatePole)| (m.1.pole.norm() - middle).abs();
    members.sort_by(|a, b| a.0.cmp(&b.0).then(off(a).total_cmp(&off(b))));
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
