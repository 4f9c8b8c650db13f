//! Stochastic subspace identification (SSI): covariance-driven and data-driven.
//!
//! Each decimation level computes the covariances of all responses with a few references, the observable subspace of their Hankel
//! matrix, the poles of increasing model orders, clusters of recurring poles, and an estimate with its uncertainty for each cluster. A
//! cluster is a mode if its uncertainty is small enough. Levels overlap; of two estimates of a mode the more certain is used.

use super::covariances::Covariances;
use super::decimation_levels::{DecimationLevel, decimation_levels};
use super::harmonics::{
    BAND_LINES, BandSpectra, HarmonicIndicator, KURTOSIS_HALF_BANDWIDTHS, RunningSpeed,
};
use super::jackknife::{JackknifePoles, PoleEstimate, half_band_hz};
use super::merge_levels::{OperationalMode, UnresolvedPair, is_indistinct, is_same, merge_levels};
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
use crate::numeric::sorting::sort_descending;
use crate::spectrum::decimate::{DecimationOptions, decimate};

/// Highest model order: 30 modes on a decimation level.
pub const MAX_ORDER: usize = 60;

/// Lowest model order.
const MIN_ORDER: usize = 4;

/// Relative margin of the frequency range of clustering beyond a level, so that no cluster is truncated at the band limits.
const BAND_MARGIN: f64 = 0.05;

/// Number of modes on a level from which the highest order may be too low for all modes.
const MANY_MODES: usize = 24;

/// Options of stochastic subspace identification.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SsiOptions {
    /// Lower and upper limit of the analysis band, Hz; `None`: the whole band of the record.
    pub band_hz: Option<(f64, f64)>,
    /// Right multiplier of the Hankel matrix.
    pub weighting: Weighting,
    /// Running speed of the rotating shafts.
    pub running: Option<RunningSpeed>,
}

/// Rejected cluster of poles with the reason of rejection.
#[derive(Debug, Clone)]
pub struct RejectedCluster {
    /// Pole, rad/s.
    pub pole: Complex,
    /// Reason of the rejection.
    pub reason: &'static str,
}

/// Modes identified by SSI with the rejected clusters, the poles of all orders and the diagnostics.
#[derive(Debug, Clone)]
pub struct SsiEstimate {
    /// Modes sorted by frequency.
    pub modes: Vec<OperationalMode>,
    /// Stable poles rejected as modes, sorted by frequency.
    pub rejected: Vec<RejectedCluster>,
    /// Decimation levels in order of decreasing sample rate.
    pub levels: Vec<DecimationLevel>,
    /// Poles of all orders for each decimation level.
    pub orders: Vec<Vec<OrderPoles>>,
    /// Pairs resolved as two modes at one decimation level and as one mode at another.
    pub pairs: Vec<UnresolvedPair>,
    /// Warnings about limits of the estimate.
    pub diagnostics: Vec<Diagnostic>,
}

impl SsiEstimate {
    /// Lowest and highest frequency of the analysis over all levels, Hz.
    pub fn reach_hz(&self) -> (f64, f64) {
        let bands = self.levels.iter().map(|r| r.band_hz);
        bands.fold((f64::INFINITY, 0.0), |a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}

/// Identifies modes of response records on all decimation levels.
///
/// # Errors
/// `TooShort`, `OutOfRange` of [`decimation_levels`]; errors of the matrix decompositions.
pub fn identify(channels: &ResponseChannels, options: &SsiOptions) -> Result<SsiEstimate, Error> {
    let (levels, mut diagnostics) =
        decimation_levels(channels.rate_hz(), channels.n_samples(), options.band_hz)?;
    let mut y: Vec<Vec<f64>> = Vec::new();
    let mut factor = 1;
    let mut modes_by_level: Vec<Vec<OperationalMode>> = Vec::new();
    let (mut rejected, mut orders) = (Vec::new(), Vec::new());
    for level in &levels {
        if level.factor > factor {
            let ratio = level.factor / factor;
            let resample = |s: &[f64]| decimate(s, ratio, DecimationOptions::default());
            y = match y.is_empty() {
                true => channels.samples().iter().map(|s| resample(s)).collect(),
                false => y.iter().map(|s| resample(s)).collect::<Result<_, Error>>(),
            }?;
            factor = level.factor;
        }
        let views: Vec<&[f64]> = y.iter().map(Vec::as_slice).collect();
        let level_channels = match factor {
            1 => *channels,
            _ => ResponseChannels::new(&views, level.rate_hz)?,
        };
        let estimate = modes_of_level(&level_channels, level, options)?;
        if estimate.modes.len() >= MANY_MODES {
            diagnostics.push(Diagnostic {
                code: "many-modes",
                message: format!(
                    "{} modes from {:.4} to {:.4} Hz (maximum {} at order {MAX_ORDER}): others may be missing",
                    estimate.modes.len(),
                    level.band_hz.0,
                    level.band_hz.1,
                    MAX_ORDER / 2
                ),
                hint: Some("compare with the peaks of --method fdd".to_string()),
            });
        }
        modes_by_level.push(estimate.modes);
        rejected.extend(estimate.rejected);
        orders.push(estimate.orders);
    }
    let (modes, pairs) = merge_levels(modes_by_level);
    // A cluster rejected on one level and confirmed on another is a mode.
    let is_confirmed = |r: &RejectedCluster| {
        let shift = |m: &OperationalMode| (m.mode.pole - r.pole).norm();
        modes.iter().any(|m| shift(m) < 2.0 * m.mode.pole.re.abs())
    };
    rejected.retain(|r| !is_confirmed(r));
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

struct LevelEstimate {
    modes: Vec<OperationalMode>,
    rejected: Vec<RejectedCluster>,
    orders: Vec<OrderPoles>,
}

fn modes_of_level(
    channels: &ResponseChannels,
    level: &DecimationLevel,
    options: &SsiOptions,
) -> Result<LevelEstimate, Error> {
    let stds = channel_stds(channels);
    let references = references(channels, level.band_hz)?;
    let covariances = Covariances::new(
        channels,
        &stds,
        &references,
        2 * level.block_rows,
        level.parts,
    )?;
    let subspaces = Subspaces::new(&covariances, options.weighting, MAX_ORDER)?;
    let highest = subspaces.full.highest();
    let orders: Vec<OrderPoles> = (MIN_ORDER.min(highest / 2 * 2)..=highest)
        .step_by(2)
        .filter(|n| *n > 0)
        .map(|n| subspaces.full.poles(n, level.rate_hz))
        .collect();
    let (low, high) = level.band_hz;
    let extended_band = (low * (1.0 - BAND_MARGIN), high * (1.0 + BAND_MARGIN));
    let mut replicates = JackknifePoles::new(&subspaces, level.rate_hz, highest);
    let mut estimates: Vec<(PoleEstimate, f64)> = Vec::new();
    let mut rejected = Vec::new();
    let is_in_band = |f: f64| f >= low && f <= high;
    for cluster in clusters(&orders, extended_band) {
        if !is_in_band(cluster.frequency()) {
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
    let candidates: Vec<ModalParameters> = estimates.iter().map(|e| e.0.mode.clone()).collect();
    let mut accepted = Vec::new();
    for candidate in estimates {
        match rejection_reason(&candidate.0, &candidates) {
            Some(reason) => rejected.push(RejectedCluster {
                pole: candidate.0.mode.pole,
                reason,
            }),
            None => accepted.push(candidate),
        }
    }
    let mut bands: Vec<Option<BandSpectra>> = vec![None; channels.samples().len()];
    let modes = remove_duplicates(accepted)
        .into_iter()
        .map(|(estimate, scatter_hz)| {
            let harmonic = harmonic(&estimate.mode, channels, &mut bands, options);
            let mut mode = estimate.mode;
            (mode.shape.iter_mut().zip(&stds)).for_each(|(x, s)| *x *= *s);
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
    Ok(LevelEstimate {
        modes,
        rejected,
        orders,
    })
}

/// Standard deviations of the responses (1 for a constant one), the scales that give all responses equal weight regardless of unit.
fn channel_stds(channels: &ResponseChannels) -> Vec<f64> {
    let std = |samples: &&[f64]| {
        let n = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / n;
        let power = samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
        if power > 0.0 { power.sqrt() } else { 1.0 }
    };
    channels.samples().iter().map(std).collect()
}

/// Reason to reject an estimate as a mode: noise also forms clusters, but their poles shift strongly when a part of the record is omitted.
fn rejection_reason(estimate: &PoleEstimate, others: &[ModalParameters]) -> Option<&'static str> {
    /// Accepted relative standard deviation of the frequency, rarely met by noise clusters, and at most the half-power half-bandwidth; …
    const CERTAIN_STD: f64 = 0.0025;
    /// … or the standard deviation over the parts in half-power half-bandwidths; …
    const RESOLVED: f64 = 0.4;
    /// … or (relative standard deviation over the parts, phase collinearity, share of orders) for a shape of three channels or more.
    const CERTAIN_STD_WITH_SHAPE: (f64, f64, f64) = (0.006, 0.95, 0.8);
    const MAX_STD: f64 = 0.02; // of the frequency
    /// (Relative standard deviation of the frequency, minimum share of the orders above it.)
    const UNCERTAIN_STD: (f64, f64) = (0.005, 0.5);
    const MIN_DAMPING_STD: f64 = 0.003; // smaller deviations cause no rejection
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
        && !others.iter().any(|m| is_noise_pole(mode, m));
    match () {
        () if !(total < CERTAIN_STD.min(zeta) || parts < RESOLVED * zeta || has_shape) => {
            Some("its frequency moves by its bandwidth when a part of the record is left out")
        }
        () if total >= MAX_STD => Some("standard deviation of its frequency above 2 %"),
        () if total > UNCERTAIN_STD.0 && estimate.presence < UNCERTAIN_STD.1 => {
            Some("few orders show it, and its frequency is uncertain")
        }
        () if damping >= zeta.max(MIN_DAMPING_STD) => {
            Some("its damping is not known to its own size")
        }
        () if collinearity <= COLLINEAR => Some("its channels move out of phase with each other"),
        () if zeta >= MAX_DAMPING => Some("damping as high as that of noise poles"),
        () => None,
    }
}

/// True if a pole has the shape of a more certain pole close to it: typical of noise poles around a strong mode.
fn is_noise_pole(mode: &ModalParameters, other: &ModalParameters) -> bool {
    const NEIGHBOUR_DISTANCE: f64 = 0.1; // of the frequency
    const SAME_SHAPE: f64 = 0.8;
    let std = |m: &ModalParameters| m.frequency_std_hz().unwrap_or(f64::INFINITY);
    let distance = (mode.frequency_hz() - other.frequency_hz()).abs();
    std(other) < std(mode)
        && distance < NEIGHBOUR_DISTANCE * other.frequency_hz()
        && mac(&mode.shape, &other.shape) > SAME_SHAPE
}

fn scatter_hz(cluster: &PoleCluster) -> f64 {
    let magnitudes = cluster.members.iter().map(|m| m.1.pole.norm());
    let n = cluster.members.len() as f64;
    let mean = magnitudes.clone().sum::<f64>() / n;
    let sum_of_squares = magnitudes.map(|x| (x - mean).powi(2)).sum::<f64>();
    (sum_of_squares / (n - 1.0).max(1.0)).sqrt() / std::f64::consts::TAU
}

/// Removes duplicate estimates, keeping the one present in more orders, and estimates too uncertain to be separated from a certain one.
fn remove_duplicates(mut estimates: Vec<(PoleEstimate, f64)>) -> Vec<(PoleEstimate, f64)> {
    let modes: Vec<ModalParameters> = estimates.iter().map(|e| e.0.mode.clone()).collect();
    estimates.retain(|e| !modes.iter().any(|m| is_indistinct(&e.0.mode, m)));
    sort_descending(&mut estimates, |a| a.0.presence);
    let mut unique: Vec<(PoleEstimate, f64)> = Vec::new();
    for estimate in estimates {
        if !unique.iter().any(|u| is_same(&u.0.mode, &estimate.0.mode)) {
            unique.push(estimate);
        }
    }
    unique
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
    let half_band = (KURTOSIS_HALF_BANDWIDTHS * half_band_hz(mode)).max(BAND_LINES * spacing);
    bands[strongest]
        .get_or_insert_with(|| BandSpectra::from_signals(&[samples], channels.rate_hz()))
        .examine_band(
            0,
            mode.damped_frequency_hz(),
            half_band,
            options.running.as_ref(),
        )
}
