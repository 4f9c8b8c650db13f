//! Stochastic subspace identification (SSI): covariance-driven and data-driven.
//!
//! On each rung: covariances of all responses with a few references, the observable subspace of their Hankel matrix, poles of rising
//! orders, clusters of those that come back, the estimate of each cluster with its uncertainty, and the test whether that is small
//! enough for a mode. Rungs overlap; of two estimates of one mode the more certain counts.

use super::covariances::Covariances;
use super::decimation_levels::{DecimationLevel, decimation_levels};
use super::harmonics::{
    BandSpectra, HarmonicIndicator, KURTOSIS_HALF_BANDWIDTHS, LINES, RunningSpeed,
};
use super::jackknife::{JackknifePoles, PoleEstimate, half_band_hz};
use super::merge_levels::{OperationalMode, UnresolvedPair, is_shadow, is_twin, merge_levels};
use super::realisation::{Subspaces, Weighting};
use super::references::references;
use super::response_channels::ResponseChannels;
use super::selection::{PoleCluster, clusters};
use crate::base::error::{Diagnostic, Error};
use crate::identify::compare::phase_collinearity;
use crate::identify::modal::candidates::{OrderPoles, normalize_to_largest};
use crate::identify::modal_parameters::ModalParameters;
use crate::numeric::Complex;
use crate::numeric::mac::mac;
use crate::numeric::sorting::sort_falling;
use crate::spectrum::decimate::{DecimationOptions, decimate};

/// Highest order: 30 modes on a rung.
pub const MAX_ORDER: usize = 60;

/// Lowest order.
const MIN_ORDER: usize = 4;

/// Poles are clustered a little beyond the ends of a rung, so that no cluster is cut there.
const BAND_MARGIN: f64 = 0.05;

/// Modes on a rung above which its orders may not suffice for more.
const MANY_MODES: usize = 24;

/// Options of stochastic subspace identification.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SsiOptions {
    /// Modes are sought from here to there, Hz; `None`: wherever the record shows any.
    pub band_hz: Option<(f64, f64)>,
    /// Right multiplier of the Hankel matrix.
    pub weighting: Weighting,
    /// Running speed of the rotating shafts.
    pub running: Option<RunningSpeed>,
}

/// A cluster of poles that is no mode, and why.
#[derive(Debug, Clone)]
pub struct RejectedCluster {
    /// Pole, rad/s.
    pub pole: Complex,
    /// Why it is no mode.
    pub reason: &'static str,
}

/// Modes and how they were found.
#[derive(Debug, Clone)]
pub struct SsiEstimate {
    /// By rising frequency.
    pub modes: Vec<OperationalMode>,
    /// Stable poles that are no modes, by rising frequency.
    pub rejected: Vec<RejectedCluster>,
    /// Rungs by falling rate.
    pub levels: Vec<DecimationLevel>,
    /// Poles of all orders by rung.
    pub orders: Vec<Vec<OrderPoles>>,
    /// Pairs that are two modes at one decimation level and one mode at another.
    pub pairs: Vec<UnresolvedPair>,
    /// Limits of the estimate.
    pub diagnostics: Vec<Diagnostic>,
}

impl SsiEstimate {
    /// From the lowest to the highest frequency at which modes were sought, Hz.
    pub fn reach_hz(&self) -> (f64, f64) {
        let bands = self.levels.iter().map(|r| r.band_hz);
        bands.fold((f64::INFINITY, 0.0), |a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}

/// Identifies modes.
///
/// # Errors
/// `TooShort`, `OutOfRange` of the ladder; those of the decompositions.
pub fn identify(channels: &ResponseChannels, options: &SsiOptions) -> Result<SsiEstimate, Error> {
    let (levels, mut diagnostics) =
        decimation_levels(channels.rate_hz(), channels.n_samples(), options.band_hz)?;
    let mut own: Vec<Vec<f64>> = Vec::new();
    let mut factor = 1;
    let mut found: Vec<Vec<OperationalMode>> = Vec::new();
    let (mut rejected, mut orders) = (Vec::new(), Vec::new());
    for level in &levels {
        if level.factor > factor {
            let by = level.factor / factor;
            let halved = |s: &[f64]| decimate(s, by, DecimationOptions::default());
            own = match own.is_empty() {
                true => channels.samples().iter().map(|s| halved(s)).collect(),
                false => own.iter().map(|s| halved(s)).collect::<Result<_, Error>>(),
            }?;
            factor = level.factor;
        }
        let views: Vec<&[f64]> = own.iter().map(Vec::as_slice).collect();
        let at_rate = match factor {
            1 => *channels,
            _ => ResponseChannels::new(&views, level.rate_hz)?,
        };
        let step = modes_of_level(&at_rate, level, options)?;
        if step.modes.len() >= MANY_MODES {
            diagnostics.push(Diagnostic {
                code: "many-modes",
                message: format!(
                    "{} modes from {:.4} to {:.4} Hz, of {} that the order {MAX_ORDER} allows: others may be missing",
                    step.modes.len(),
                    level.band_hz.0,
                    level.band_hz.1,
                    MAX_ORDER / 2
                ),
                hint: Some("compare with the peaks of --method fdd".to_string()),
            });
        }
        found.push(step.modes);
        rejected.extend(step.rejected);
        orders.push(step.orders);
    }
    let (modes, pairs) = merge_levels(found);
    // What one rung rejects and another confirms is a mode.
    let is_known = |r: &RejectedCluster| {
        let near = |m: &OperationalMode| (m.mode.pole - r.pole).norm() < 2.0 * m.mode.pole.re.abs();
        modes.iter().any(near)
    };
    rejected.retain(|r| !is_known(r));
    rejected.sort_by(|a: &RejectedCluster, b| a.pole.norm().total_cmp(&b.pole.norm()));
    Ok(SsiEstimate {
        modes,
        rejected,
        levels,
        orders,
        pairs,
        diagnostics,
    })
}

struct StageTime {
    modes: Vec<OperationalMode>,
    rejected: Vec<RejectedCluster>,
    orders: Vec<OrderPoles>,
}

fn modes_of_level(
    channels: &ResponseChannels,
    level: &DecimationLevel,
    options: &SsiOptions,
) -> Result<StageTime, Error> {
    let scale = channel_stds(channels);
    let references = references(channels, level.band_hz)?;
    let covariances = Covariances::new(
        channels,
        &scale,
        &references,
        2 * level.block_rows,
        level.parts,
    )?;
    let subspaces = Subspaces::new(&covariances, options.weighting, MAX_ORDER)?;
    let highest = subspaces.whole.highest();
    let orders: Vec<OrderPoles> = (MIN_ORDER.min(highest / 2 * 2)..=highest)
        .step_by(2)
        .filter(|n| *n > 0)
        .map(|n| subspaces.whole.poles(n, level.rate_hz))
        .collect();
    let (low, high) = level.band_hz;
    let wider = (low * (1.0 - BAND_MARGIN), high * (1.0 + BAND_MARGIN));
    let mut replicates = JackknifePoles::new(&subspaces, level.rate_hz, highest);
    let mut estimates: Vec<(PoleEstimate, f64)> = Vec::new();
    let mut rejected = Vec::new();
    let inside = |f: f64| f >= low && f <= high;
    for cluster in clusters(&orders, wider) {
        if !inside(cluster.frequency()) {
            continue;
        }
        let Some(estimate) = replicates.estimate(&cluster) else {
            rejected.push(RejectedCluster {
                pole: cluster.members[cluster.members.len() / 2].1.pole,
                reason: "lost when a part of the record is left out",
            });
            continue;
        };
        estimates.push((estimate, scatter_hz(&cluster)));
    }
    let all: Vec<ModalParameters> = estimates.iter().map(|e| e.0.mode.clone()).collect();
    let mut accepted = Vec::new();
    for one in estimates {
        match refusal(&one.0, &all) {
            Some(reason) => rejected.push(RejectedCluster {
                pole: one.0.mode.pole,
                reason,
            }),
            None => accepted.push(one),
        }
    }
    let mut bands: Vec<Option<BandSpectra>> = vec![None; channels.samples().len()];
    let modes = without_twins(accepted)
        .into_iter()
        .map(|(estimate, scatter_hz)| {
            let harmonic = harmonic(&estimate.mode, channels, &mut bands, options);
            let mut mode = estimate.mode;
            (mode.shape.iter_mut().zip(&scale)).for_each(|(x, s)| *x *= *s);
            mode.shape = normalize_to_largest(mode.shape);
            OperationalMode {
                mode,
                order: estimate.order,
                presence: estimate.presence,
                scatter_hz,
                harmonic,
            }
        })
        .collect();
    Ok(StageTime {
        modes,
        rejected,
        orders,
    })
}

/// Standard deviations of the responses, by which they are divided: each counts alike, whatever its unit.
fn channel_stds(channels: &ResponseChannels) -> Vec<f64> {
    let of = |samples: &&[f64]| {
        let n = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / n;
        let power = samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
        if power > 0.0 { power.sqrt() } else { 1.0 }
    };
    channels.samples().iter().map(of).collect()
}

/// Why an estimate is no mode: noise makes clusters too, whose poles move as far as the next one when a part of the record is left out.
fn refusal(estimate: &PoleEstimate, others: &[ModalParameters]) -> Option<&'static str> {
    /// Relative deviation of the frequency that clusters of noise hardly reach, and no more than the half-power half-bandwidth, …
    const CERTAIN_STD: f64 = 0.0025;
    /// … or this many half-power half-bandwidths, …
    const RESOLVED: f64 = 0.4;
    /// … or this relative deviation over the parts with a collinear shape over three channels or more in most of the orders.
    const CERTAIN_STD_WITH_SHAPE: (f64, f64, f64) = (0.006, 0.95, 0.8);
    const MAX_STD: f64 = 0.02; // of the frequency
    /// Above this deviation a pole must appear in so many of the orders.
    const UNCERTAIN_STD: (f64, f64) = (0.005, 0.5);
    const MIN_DAMPING_STD: f64 = 0.003; // a deviation below it is no reason
    const COLLINEAR: f64 = 0.5;
    const MAX_DAMPING: f64 = 0.15;
    let mode = &estimate.mode;
    let (f, zeta) = (mode.frequency_hz(), mode.damping_ratio());
    let parts = estimate.parts_std_hz / f;
    let total = mode.frequency_std_hz().unwrap_or(f64::INFINITY) / estimate.widening / f;
    let damping = mode.damping_std().unwrap_or(f64::INFINITY) / estimate.widening;
    let collinearity = phase_collinearity(&mode.shape);
    let has_shape = mode.shape.len() >= 3
        && estimate.presence >= CERTAIN_STD_WITH_SHAPE.2
        && collinearity > CERTAIN_STD_WITH_SHAPE.1
        && parts < CERTAIN_STD_WITH_SHAPE.0
        && !others.iter().any(|m| is_echo(mode, m));
    match () {
        () if !(total < CERTAIN_STD.min(zeta) || parts < RESOLVED * zeta || has_shape) => {
            Some("its frequency moves by its bandwidth when a part of the record is left out")
        }
        () if total >= MAX_STD => Some("its frequency is not known to 2 %"),
        () if total > UNCERTAIN_STD.0 && estimate.presence < UNCERTAIN_STD.1 => {
            Some("few orders show it, and its frequency is uncertain")
        }
        () if damping >= zeta.max(MIN_DAMPING_STD) => {
            Some("its damping is not known to its own size")
        }
        () if collinearity <= COLLINEAR => Some("its channels move out of phase with each other"),
        () if zeta >= MAX_DAMPING => Some("damped as noise is"),
        () => None,
    }
}

/// Whether a pole has the shape of a surer one near it, as poles of noise about a strong mode have.
fn is_echo(mode: &ModalParameters, other: &ModalParameters) -> bool {
    const NEIGHBOUR_DISTANCE: f64 = 0.1; // of the frequency
    const SAME_SHAPE: f64 = 0.8;
    let std = |m: &ModalParameters| m.frequency_std_hz().unwrap_or(f64::INFINITY);
    let off = (mode.frequency_hz() - other.frequency_hz()).abs();
    std(other) < std(mode)
        && off < NEIGHBOUR_DISTANCE * other.frequency_hz()
        && mac(&mode.shape, &other.shape) > SAME_SHAPE
}

fn scatter_hz(cluster: &PoleCluster) -> f64 {
    let all = cluster.members.iter().map(|m| m.1.pole.norm());
    let n = cluster.members.len() as f64;
    let mean = all.clone().sum::<f64>() / n;
    let square = all.map(|x| (x - mean).powi(2)).sum::<f64>();
    (square / (n - 1.0).max(1.0)).sqrt() / std::f64::consts::TAU
}

/// Keeps the one of two estimates of one mode that more orders share, and none too uncertain to be separated from a certain one.
fn without_twins(mut all: Vec<(PoleEstimate, f64)>) -> Vec<(PoleEstimate, f64)> {
    let modes: Vec<ModalParameters> = all.iter().map(|e| e.0.mode.clone()).collect();
    all.retain(|e| !modes.iter().any(|m| is_shadow(&e.0.mode, m)));
    sort_falling(&mut all, |a| a.0.presence);
    let mut kept: Vec<(PoleEstimate, f64)> = Vec::new();
    for one in all {
        if !kept.iter().any(|k| is_twin(&k.0.mode, &one.0.mode)) {
            kept.push(one);
        }
    }
    kept
}

/// Harmonic indicator of a mode in its strongest channel.
fn harmonic(
    mode: &ModalParameters,
    channels: &ResponseChannels,
    bands: &mut [Option<BandSpectra>],
    options: &SsiOptions,
) -> HarmonicIndicator {
    let strongest = (0..mode.shape.len())
        .max_by(|&a, &b| {
            mode.shape[a]
                .norm_sqr()
                .total_cmp(&mode.shape[b].norm_sqr())
        })
        .unwrap_or(0);
    let samples = channels.samples()[strongest];
    let spacing = channels.rate_hz() / samples.len() as f64;
    let half_band = (KURTOSIS_HALF_BANDWIDTHS * half_band_hz(mode)).max(LINES * spacing);
    bands[strongest]
        .get_or_insert_with(|| BandSpectra::from_signals(&[samples], channels.rate_hz()))
        .examine_band(
            0,
            mode.damped_frequency_hz(),
            half_band,
            options.running.as_ref(),
        )
}
