//! Which poles come back order after order: the choice made for frequency responses, on the poles of responses alone.

use super::channels::Channels;
use super::harmonics::{Bands, Harmonic, Running};
use super::subspace::Subspace;
use crate::identify::modal::candidates::{CandidatePole, OrderPoles};
use crate::identify::modal::selection::{SelectionRule, select};
use crate::identify::mode::IdentifiedMode;

/// A mode chosen automatically.
#[derive(Debug, Clone)]
pub struct OperationalMode {
    /// The pole nearest the middle of its cluster, with its own covariance where the method gives one.
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

/// Physical modes by rising frequency; lines of running speed stand among them and are marked.
pub fn physical(
    found: &Subspace,
    channels: &Channels,
    rule: &SelectionRule,
    running: Option<&Running>,
) -> Vec<OperationalMode> {
    let orders: Vec<OrderPoles> = (found.orders.iter())
        .map(|o| {
            let poles = o.modes.iter().map(|m| CandidatePole {
                pole: m.pole,
                shape: m.shape.clone(),
                participation: Vec::new(),
            });
            OrderPoles::new(o.order, poles.collect())
        })
        .collect();
    let bands = Bands::new(channels);
    (select(&orders, found.spacing_hz, rule).into_iter())
        .map(|chosen| {
            let middle = chosen.mode.pole;
            let all = found
                .orders
                .iter()
                .flat_map(|o| o.modes.iter().map(move |m| (o.order, m)));
            let nearest = all.min_by(|a, b| {
                let apart = |m: &IdentifiedMode| (m.pole - middle).norm();
                apart(a.1).total_cmp(&apart(b.1))
            });
            let (order, mode) = nearest.map_or((0, chosen.mode.clone()), |(o, m)| (o, m.clone()));
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

/// Half width of the band about a mode whose distribution is looked at, in half-power half-bandwidths…
const HALF_BANDS: f64 = 3.0;

/// … and in lines of the whole record.
const LINES: f64 = 20.0;
