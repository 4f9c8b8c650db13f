//! Which poles come back order after order: the choice made for frequency responses, on the poles of responses alone.

use super::channels::Channels;
use super::harmonics::{Bands, Harmonic, Running};
use super::subspace::Subspace;
use crate::identify::modal::candidates::{CandidatePole, OrderPoles};
use crate::identify::modal::selection::{SelectedMode, SelectionRule, select};
use crate::identify::mode::IdentifiedMode;

/// A mode chosen automatically.
#[derive(Debug, Clone)]
pub struct OperationalMode {
    /// A pole near the middle of its cluster, with its own covariance where the method gives one.
    pub mode: IdentifiedMode,
    /// Order of the model that pole is from.
    pub order: usize,
    /// Share of all orders with a pole in the cluster.
    pub presence: f64,
    /// Standard deviation of the frequency over the cluster, Hz; an indication only, for orders share their data.
    pub scatter_hz: f64,
    /// What it shows of being a line of running speed.
    pub harmonic: Harmonic,
}

/// Physical modes by rising frequency. Poles whose uncertainty exceeds their own half bandwidth are left out before clusters are made;
/// lines of running speed stand among them and are marked.
pub fn physical(
    found: &Subspace,
    channels: &Channels,
    rule: &SelectionRule,
    running: Option<&Running>,
) -> Vec<OperationalMode> {
    let orders: Vec<OrderPoles> = (found.orders.iter())
        .map(|o| {
            let certain = o.modes.iter().filter(|m| is_certain(m, found.spacing_hz));
            let poles = certain.map(|m| CandidatePole {
                pole: m.pole,
                shape: m.shape.clone(),
                participation: Vec::new(),
            });
            OrderPoles::new(o.order, poles.collect())
        })
        .collect();
    let bands = Bands::new(channels);
    // Two clusters may meet in one pole, and a pole near the middle of a cluster may be damped more than the middle.
    let mut members: Vec<(SelectedMode, usize, IdentifiedMode)> = Vec::new();
    for chosen in select(&orders, found.spacing_hz, rule) {
        let (order, mode) = member(found, &chosen.mode);
        let is_same =
            |known: &&mut (SelectedMode, usize, IdentifiedMode)| known.2.pole == mode.pole;
        match members.iter_mut().find(is_same) {
            Some(known) if known.0.presence < chosen.presence => known.0 = chosen,
            Some(_) => {}
            None if mode.damping_ratio() > rule.most_damping => {}
            None => members.push((chosen, order, mode)),
        }
    }
    (members.into_iter())
        .map(|(chosen, order, mode)| {
            let strongest = (0..mode.shape.len())
                .max_by(|&a, &b| {
                    mode.shape[a]
                        .norm_sqr()
                        .total_cmp(&mode.shape[b].norm_sqr())
                })
                .unwrap_or(0);
            // Wide enough to hold the resonance, and enough lines of the record to tell a distribution.
            let half_band = (HALF_BANDS * mode.pole.re.abs() / std::f64::consts::TAU)
                .max(LINES * found.spacing_hz);
            let frequency = mode.damped_frequency_hz();
            OperationalMode {
                harmonic: bands.look(strongest, frequency, half_band, running),
                mode,
                order,
                presence: chosen.presence,
                scatter_hz: chosen.scatter_hz,
            }
        })
        .collect()
}

/// The rule for responses alone. Where poles come with their uncertainty, a lower share of the orders is asked for: noise poles crowd the
/// high orders, where they split modes, but few of them are certain (see [`physical`]).
pub fn default_rule(found: &Subspace) -> SelectionRule {
    const CERTAIN: f64 = 0.15; // share of the orders
    let mut modes = found.orders.iter().flat_map(|o| &o.modes);
    if modes.all(|m| m.pole_covariance.is_none()) {
        return SelectionRule::default();
    }
    SelectionRule {
        presence: CERTAIN,
        ..SelectionRule::default()
    }
}

/// The pole near the middle of a cluster that is nearest to it among those about as certain as the most certain, and its order.
fn member(found: &Subspace, middle: &IdentifiedMode) -> (usize, IdentifiedMode) {
    const AS_CERTAIN: f64 = 2.0; // times the least standard deviation
    const NEAR: f64 = 0.5; // half-bandwidths, as in the rule of the clusters
    let all = found
        .orders
        .iter()
        .flat_map(|o| o.modes.iter().map(move |m| (o.order, m)));
    let apart = |m: &IdentifiedMode| (m.pole - middle.pole).norm();
    let reach = NEAR * middle.pole.re.abs() + found.spacing_hz * std::f64::consts::TAU;
    let near: Vec<(usize, &IdentifiedMode)> = all
        .filter(|(_, m)| is_certain(m, found.spacing_hz) && apart(m) <= reach)
        .collect();
    let std = |m: &IdentifiedMode| m.frequency_std_hz().unwrap_or(0.0);
    let least = near
        .iter()
        .map(|(_, m)| std(m))
        .fold(f64::INFINITY, f64::min);
    (near.iter())
        .filter(|(_, m)| std(m) <= AS_CERTAIN * least)
        .min_by(|a, b| apart(a.1).total_cmp(&apart(b.1)))
        .map_or((0, middle.clone()), |&(order, m)| (order, m.clone()))
}

/// Whether a pole is known better than to half its bandwidth, or than a record of this length can resolve. A pole of noise is not: it
/// moves as far as the next one with every other stretch of the record.
fn is_certain(mode: &IdentifiedMode, spacing_hz: f64) -> bool {
    let half_bandwidth = mode.damping_ratio() * mode.frequency_hz();
    (mode.frequency_std_hz()).is_none_or(|std| std <= half_bandwidth.max(spacing_hz))
}

/// Half width of the band about a mode whose distribution is looked at, in half-power half-bandwidths…
pub const HALF_BANDS: f64 = 3.0;

/// … and in lines of the whole record.
pub const LINES: f64 = 20.0;
