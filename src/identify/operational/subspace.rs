//! Modes from responses alone by stochastic subspace identification, rung by rung of a ladder of sample rates.
//!
//! On each rung: covariances of all responses with a few references, the observable subspace of their Hankel matrix, poles of rising
//! orders, clusters of those that come back, the estimate of each cluster with its uncertainty, and the test whether that is small
//! enough for a mode. Rungs overlap; of two estimates of one mode the more certain counts.

use super::channels::Channels;
use super::covariances::Covariances;
use super::harmonics::{Bands, HALF_BANDS, Harmonic, LINES, Running};
use super::jackknife::{Estimate, Replicates, half_band_hz};
use super::ladder::{Rung, ladder};
use super::realisation::{Subspaces, Weighting};
use super::references::references;
use super::rungs::{OperationalMode, Pair, is_shadow, is_twin, joined};
use super::selection::{Cluster, clusters};
use crate::base::error::{Error, Warning};
use crate::identify::compare::phase_collinearity;
use crate::identify::modal::candidates::{OrderPoles, unit_largest};
use crate::identify::mode::IdentifiedMode;
use crate::numeric::Complex;
use crate::numeric::collinearity::mac;
use crate::spectrum::decimate::{DecimationSettings, decimate};

/// Highest order: 30 modes on a rung.
pub const HIGHEST_ORDER: usize = 60;

/// Lowest order.
const LOWEST_ORDER: usize = 4;

/// Poles are clustered a little beyond the ends of a rung, so that no cluster is cut there.
const BEYOND: f64 = 0.05;

/// Modes on a rung above which its orders may not suffice for more.
const MANY: usize = 24;

/// What is asked.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Settings {
    /// Modes are sought from here to there, Hz; `None`: wherever the record shows any.
    pub band_hz: Option<(f64, f64)>,
    /// Right multiplier of the Hankel matrix.
    pub weighting: Weighting,
    /// What turns.
    pub running: Option<Running>,
}

/// A cluster of poles that is no mode, and why.
#[derive(Debug, Clone)]
pub struct Rejected {
    /// Pole, rad/s.
    pub pole: Complex,
    /// Why it is no mode.
    pub reason: &'static str,
}

/// Modes and how they were found.
#[derive(Debug, Clone)]
pub struct Subspace {
    /// By rising frequency.
    pub modes: Vec<OperationalMode>,
    /// Stable poles that are no modes, by rising frequency.
    pub rejected: Vec<Rejected>,
    /// Rungs by falling rate.
    pub rungs: Vec<Rung>,
    /// Poles of all orders by rung.
    pub orders: Vec<Vec<OrderPoles>>,
    /// Where one rung shows two modes, and another one.
    pub pairs: Vec<Pair>,
    /// Limits of the answer.
    pub warnings: Vec<Warning>,
}

impl Subspace {
    /// From the lowest to the highest frequency at which modes were sought, Hz.
    pub fn reach_hz(&self) -> (f64, f64) {
        let bands = self.rungs.iter().map(|r| r.band_hz);
        bands.fold((f64::INFINITY, 0.0), |a, b| (a.0.min(b.0), a.1.max(b.1)))
    }
}

/// Identifies modes.
///
/// # Errors
/// `TooShort`, `OutOfRange` of the ladder; those of the decompositions.
pub fn identify(channels: &Channels, settings: &Settings) -> Result<Subspace, Error> {
    let (rungs, mut warnings) = ladder(channels.rate_hz(), channels.length(), settings.band_hz)?;
    let mut own: Vec<Vec<f64>> = Vec::new();
    let mut factor = 1;
    let mut found: Vec<Vec<OperationalMode>> = Vec::new();
    let (mut rejected, mut orders) = (Vec::new(), Vec::new());
    for rung in &rungs {
        if rung.factor > factor {
            let by = rung.factor / factor;
            let halved = |s: &[f64]| decimate(s, by, DecimationSettings::default());
            own = match own.is_empty() {
                true => channels.samples().iter().map(|s| halved(s)).collect(),
                false => own.iter().map(|s| halved(s)).collect::<Result<_, Error>>(),
            }?;
            factor = rung.factor;
        }
        let views: Vec<&[f64]> = own.iter().map(Vec::as_slice).collect();
        let at_rate = match factor {
            1 => *channels,
            _ => Channels::new(&views, rung.rate_hz)?,
        };
        let step = of_rung(&at_rate, rung, settings)?;
        if step.modes.len() >= MANY {
            warnings.push(Warning {
                code: "many-modes",
                message: format!(
                    "{} modes from {:.4} to {:.4} Hz, of {} that the order {HIGHEST_ORDER} allows: others may be missing",
                    step.modes.len(),
                    rung.band_hz.0,
                    rung.band_hz.1,
                    HIGHEST_ORDER / 2
                ),
                hint: Some("compare with the peaks of --method fdd".to_string()),
            });
        }
        found.push(step.modes);
        rejected.extend(step.rejected);
        orders.push(step.orders);
    }
    let (modes, pairs) = joined(found);
    // What one rung rejects and another confirms is a mode.
    let is_known = |r: &Rejected| {
        let near = |m: &OperationalMode| (m.mode.pole - r.pole).norm() < 2.0 * m.mode.pole.re.abs();
        modes.iter().any(near)
    };
    rejected.retain(|r| !is_known(r));
    rejected.sort_by(|a: &Rejected, b| a.pole.norm().total_cmp(&b.pole.norm()));
    Ok(Subspace {
        modes,
        rejected,
        rungs,
        orders,
        pairs,
        warnings,
    })
}

struct Step {
    modes: Vec<OperationalMode>,
    rejected: Vec<Rejected>,
    orders: Vec<OrderPoles>,
}

fn of_rung(channels: &Channels, rung: &Rung, settings: &Settings) -> Result<Step, Error> {
    let scale = deviations(channels);
    let references = references(channels, rung.band_hz)?;
    let covariances = Covariances::new(
        channels,
        &scale,
        &references,
        2 * rung.block_rows,
        rung.parts,
    )?;
    let subspaces = Subspaces::new(&covariances, settings.weighting, HIGHEST_ORDER)?;
    let highest = subspaces.whole.highest();
    let orders: Vec<OrderPoles> = (LOWEST_ORDER.min(highest / 2 * 2)..=highest)
        .step_by(2)
        .filter(|n| *n > 0)
        .map(|n| subspaces.whole.poles(n, rung.rate_hz))
        .collect();
    let (low, high) = rung.band_hz;
    let wider = (low * (1.0 - BEYOND), high * (1.0 + BEYOND));
    let mut replicates = Replicates::new(&subspaces, rung.rate_hz, highest);
    let mut estimates: Vec<(Estimate, f64)> = Vec::new();
    let mut rejected = Vec::new();
    let inside = |f: f64| f >= low && f <= high;
    for cluster in clusters(&orders, wider) {
        if !inside(cluster.frequency()) {
            continue;
        }
        let Some(estimate) = replicates.estimate(&cluster) else {
            rejected.push(Rejected {
                pole: cluster.members[cluster.members.len() / 2].1.pole,
                reason: "lost when a part of the record is left out",
            });
            continue;
        };
        estimates.push((estimate, scatter_hz(&cluster)));
    }
    let all: Vec<IdentifiedMode> = estimates.iter().map(|e| e.0.mode.clone()).collect();
    let mut accepted = Vec::new();
    for one in estimates {
        match refusal(&one.0, &all) {
            Some(reason) => rejected.push(Rejected {
                pole: one.0.mode.pole,
                reason,
            }),
            None => accepted.push(one),
        }
    }
    let mut bands: Vec<Option<Bands>> = vec![None; channels.samples().len()];
    let modes = without_twins(accepted)
        .into_iter()
        .map(|(estimate, scatter_hz)| {
            let harmonic = harmonic(&estimate.mode, channels, &mut bands, settings);
            let mut mode = estimate.mode;
            (mode.shape.iter_mut().zip(&scale)).for_each(|(x, s)| *x *= *s);
            mode.shape = unit_largest(mode.shape);
            OperationalMode {
                mode,
                order: estimate.order,
                presence: estimate.presence,
                scatter_hz,
                harmonic,
            }
        })
        .collect();
    Ok(Step {
        modes,
        rejected,
        orders,
    })
}

/// Standard deviations of the responses, by which they are divided: each counts alike, whatever its unit.
fn deviations(channels: &Channels) -> Vec<f64> {
    let of = |samples: &&[f64]| {
        let n = samples.len() as f64;
        let mean = samples.iter().sum::<f64>() / n;
        let power = samples.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / n;
        if power > 0.0 { power.sqrt() } else { 1.0 }
    };
    channels.samples().iter().map(of).collect()
}

/// Why an estimate is no mode: noise makes clusters too, whose poles move as far as the next one when a part of the record is left out.
fn refusal(estimate: &Estimate, others: &[IdentifiedMode]) -> Option<&'static str> {
    /// Relative deviation of the frequency that clusters of noise hardly reach, and no more than the half-power half-bandwidth, …
    const SURE: f64 = 0.0025;
    /// … or this many half-power half-bandwidths, …
    const RESOLVED: f64 = 0.4;
    /// … or this relative deviation over the parts with a collinear shape over three channels or more in most of the orders.
    const WITH_SHAPE: (f64, f64, f64) = (0.006, 0.95, 0.8);
    const MOST_STD: f64 = 0.02; // of the frequency
    /// Above this deviation so many of the orders are asked for.
    const VAGUE: (f64, f64) = (0.005, 0.5);
    const LEAST_DAMPING_STD: f64 = 0.003; // a deviation below it is no reason
    const COLLINEAR: f64 = 0.5;
    const MOST_DAMPING: f64 = 0.15;
    let mode = &estimate.mode;
    let (f, zeta) = (mode.frequency_hz(), mode.damping_ratio());
    let parts = estimate.parts_std_hz / f;
    let total = mode.frequency_std_hz().unwrap_or(f64::INFINITY) / estimate.widening / f;
    let damping = mode.damping_std().unwrap_or(f64::INFINITY) / estimate.widening;
    let collinearity = phase_collinearity(&mode.shape);
    let has_shape = mode.shape.len() >= 3
        && estimate.presence >= WITH_SHAPE.2
        && collinearity > WITH_SHAPE.1
        && parts < WITH_SHAPE.0
        && !others.iter().any(|m| is_echo(mode, m));
    match () {
        () if !(total < SURE.min(zeta) || parts < RESOLVED * zeta || has_shape) => {
            Some("its frequency moves by its bandwidth when a part of the record is left out")
        }
        () if total >= MOST_STD => Some("its frequency is not known to 2 %"),
        () if total > VAGUE.0 && estimate.presence < VAGUE.1 => {
            Some("few orders show it, and its frequency is uncertain")
        }
        () if damping >= zeta.max(LEAST_DAMPING_STD) => {
            Some("its damping is not known to its own size")
        }
        () if collinearity <= COLLINEAR => Some("its channels move out of phase with each other"),
        () if zeta >= MOST_DAMPING => Some("damped as noise is"),
        () => None,
    }
}

/// Whether a pole has the shape of a surer one near it, as poles of noise about a strong mode have.
fn is_echo(mode: &IdentifiedMode, other: &IdentifiedMode) -> bool {
    const NEAR: f64 = 0.1; // of the frequency
    const SAME_SHAPE: f64 = 0.8;
    let std = |m: &IdentifiedMode| m.frequency_std_hz().unwrap_or(f64::INFINITY);
    let off = (mode.frequency_hz() - other.frequency_hz()).abs();
    std(other) < std(mode)
        && off < NEAR * other.frequency_hz()
        && mac(&mode.shape, &other.shape) > SAME_SHAPE
}

fn scatter_hz(cluster: &Cluster) -> f64 {
    let all = cluster.members.iter().map(|m| m.1.pole.norm());
    let n = cluster.members.len() as f64;
    let mean = all.clone().sum::<f64>() / n;
    let square = all.map(|x| (x - mean).powi(2)).sum::<f64>();
    (square / (n - 1.0).max(1.0)).sqrt() / std::f64::consts::TAU
}

/// Of two estimates of one mode the one that more orders share; none that is too uncertain to be parted from a sure one.
fn without_twins(mut all: Vec<(Estimate, f64)>) -> Vec<(Estimate, f64)> {
    let modes: Vec<IdentifiedMode> = all.iter().map(|e| e.0.mode.clone()).collect();
    all.retain(|e| !modes.iter().any(|m| is_shadow(&e.0.mode, m)));
    all.sort_by(|a, b| b.0.presence.total_cmp(&a.0.presence));
    let mut kept: Vec<(Estimate, f64)> = Vec::new();
    for one in all {
        if !kept.iter().any(|k| is_twin(&k.0.mode, &one.0.mode)) {
            kept.push(one);
        }
    }
    kept
}

/// What the strongest channel shows about a mode.
fn harmonic(
    mode: &IdentifiedMode,
    channels: &Channels,
    bands: &mut [Option<Bands>],
    settings: &Settings,
) -> Harmonic {
    let strongest = (0..mode.shape.len())
        .max_by(|&a, &b| {
            mode.shape[a]
                .norm_sqr()
                .total_cmp(&mode.shape[b].norm_sqr())
        })
        .unwrap_or(0);
    let samples = channels.samples()[strongest];
    let spacing = channels.rate_hz() / samples.len() as f64;
    let half_band = (HALF_BANDS * half_band_hz(mode)).max(LINES * spacing);
    bands[strongest]
        .get_or_insert_with(|| Bands::of(&[samples], channels.rate_hz()))
        .look(
            0,
            mode.damped_frequency_hz(),
            half_band,
            settings.running.as_ref(),
        )
}
