//! Estimates of each mode by single hits or single responses. If their poles differ by more than their uncertainty, the mode is the mean
//! of their population, and its uncertainty includes their scatter.

use super::basis::ScaledPole;
use super::covariance::covariance;
use super::model_error::ModeDeviation;
use super::projection::StopCriteria;
use super::random_effects::{PooledMean, differ, differ_jointly, heterogeneity, pooled_mean};
use super::scatter::MIN_GROUPS;
use super::windowed::{BandFit, NUMERATORS, PoleWindow, WindowFit, half_window};

/// Minimum number of hits for a mean, with an interval of one degree of freedom. Responses at different positions need [`MIN_GROUPS`].
pub(super) const MIN_HITS: usize = 2;

/// Iterations of fit and model error of each group.
const MAX_ITERATIONS: usize = 3;

/// Bias of the width in units of `⟨δ²⟩/σ` for the mean response `1/z + ⟨δ²⟩/z³` (to second order, `z = jω − p`) of hits whose poles scatter
/// by δ: in a window of 8 half-widths to either side with a straight background (1 without window and background).
const WIDTH_BIAS: f64 = 1.27;

const CONVERGENCE: StopCriteria = StopCriteria {
    steps: 8,
    min_decrease: 0.0,
    min_relative_decrease: 1e-8,
};

/// Limits for the pole of a group: maximum shift in half-widths, maximum ratio of the widths, minimum share of the response power.
const MAX_GROUP_SHIFT: (f64, f64, f64) = (2.0, 4.5, 0.02);

/// Mean of the group estimates of a mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GroupMean {
    /// Number of groups with an estimate of the mode.
    pub count: usize,
    /// Mean frequency and decay rate, if the groups differ in either; variances for intervals of ±1.96 standard deviations.
    pub mean: Option<(PooledMean, PooledMean)>,
}

/// Pole of one group with the variances of w and σ.
struct GroupPole {
    pole: ScaledPole,
    variance: (f64, f64),
}

/// Means over the groups for each pole; `None` if fewer than [`MIN_GROUPS`] responses or [`MIN_HITS`] hits have an estimate.
pub(super) fn means(
    band: &BandFit,
    groups: &[Vec<usize>],
    by_hit: bool,
    departures: &[ModeDeviation],
    is_reported: &dyn Fn(&ScaledPole) -> bool,
) -> Vec<Option<GroupMean>> {
    let poles = &band.modes.poles;
    let n_min = if by_hit { MIN_HITS } else { MIN_GROUPS };
    let fits: Vec<Vec<GroupPole>> = (0..poles.len())
        .map(|r| match is_reported(&poles[r]) && groups.len() >= n_min {
            true => group_poles(band, groups, departures, r),
            false => Vec::new(),
        })
        .collect();
    let column = |p: &[GroupPole],
                  pick: &dyn Fn(&GroupPole) -> (f64, f64)|
     -> (Vec<f64>, Vec<f64>) { p.iter().map(pick).unzip() };
    let frequency = |o: &GroupPole| (o.pole.w, o.variance.0);
    let width = |o: &GroupPole| (o.pole.sigma, o.variance.1);
    let statistic = |p: &[GroupPole]| {
        let test = |pick: &dyn Fn(&GroupPole) -> (f64, f64)| {
            let (y, v) = column(p, pick);
            heterogeneity(&y, &v)
        };
        [test(&frequency), test(&width)]
    };
    let valid = |p: &&Vec<GroupPole>| p.len() >= n_min;
    let (q, dof) = fits.iter().filter(valid).fold((0.0, 0.0), |(q, dof), p| {
        let [a, b] = statistic(p);
        (q + a + b, dof + 2.0 * (p.len() as f64 - 1.0))
    });
    // Hits of one test share the cause of their scatter; responses need not.
    let common = by_hit && differ_jointly(q, dof);
    fits.iter()
        .map(|p| {
            if p.len() < n_min {
                return None;
            }
            let df = p.len() as f64 - 1.0;
            let differs = common || statistic(p).into_iter().any(|q| differ(q, df));
            let pool = |pick: &dyn Fn(&GroupPole) -> (f64, f64)| {
                let (y, v) = column(p, pick);
                let pooled = pooled_mean(&y, &v);
                let min_variance = 1.0 / v.iter().map(|v| 1.0 / v).sum::<f64>();
                PooledMean {
                    variance: pooled.variance.max(min_variance),
                    ..pooled
                }
            };
            Some(GroupMean {
                count: p.len(),
                mean: differs.then(|| {
                    let (w, sigma) = (pool(&frequency), pool(&width));
                    (w, unbiased_width(sigma, &w, band.lines.hits_per_group, df))
                }),
            })
        })
        .collect()
}

/// Removes the bias due to joined hits from the mean width. With `joined` hits per group the variance between groups is the `joined`th part
/// of that between hits, so `⟨δ²⟩ = (joined − 1)(s_σ² − s_w²)` with the standard deviations s between groups (`dof` degrees of freedom).
fn unbiased_width(sigma: PooledMean, w: &PooledMean, joined: f64, dof: f64) -> PooledMean {
    let between = w.between_std.powi(2) - sigma.between_std.powi(2);
    let excess = WIDTH_BIAS * (joined - 1.0) * between / sigma.mean;
    PooledMean {
        mean: sigma.mean - excess,
        variance: sigma.variance + 2.0 / dof * excess * excess,
        ..sigma
    }
}

fn group_poles(
    band: &BandFit,
    groups: &[Vec<usize>],
    departures: &[ModeDeviation],
    r: usize,
) -> Vec<GroupPole> {
    let (lines, poles) = (band.lines, &band.modes.poles);
    let pole = poles[r];
    let others = (0..poles.len()).filter(|&o| o != r);
    let neighbour = others
        .min_by(|&a, &b| {
            let distance = |o: usize| (poles[o].w - pole.w).abs();
            distance(a).total_cmp(&distance(b))
        })
        .map_or(0.0, |o| poles[o].sigma);
    let half = half_window(lines.step, pole.sigma, neighbour);
    let window = PoleWindow::new(band, pole.w, half, &|o| departures[o]);
    let Some(position) = window.indices.iter().position(|&o| o == r) else {
        return Vec::new();
    };
    let start: Vec<ScaledPole> = window.indices.iter().map(|&o| poles[o]).collect();
    let common = band.modes.select(&window.indices);
    let estimate = |group: &Vec<usize>| -> Option<GroupPole> {
        let mut departures: Vec<ModeDeviation> = (window.indices.iter())
            .map(|&o| ModeDeviation {
                scatter: 0.0,
                ..departures[o]
            })
            .collect();
        let mut modes = common.clone();
        let mut fit: Option<WindowFit> = None;
        for _ in 0..MAX_ITERATIONS {
            let weights = window.weights(group, &window.variance(&modes, &departures));
            let initial = fit.as_ref().map_or(&start, |f| &f.fit.model.poles);
            let next = window.fit(group, &weights, initial, CONVERGENCE);
            modes = next.modes(lines.h.len());
            let residual = next.residual(lines.independence);
            for (k, d) in departures.iter_mut().enumerate() {
                d.share = window.misfit(group, &residual, &modes, k);
                d.width = modes.poles[k].sigma;
            }
            fit = Some(next);
        }
        let fit = fit?;
        let estimated = fit.fit.model.poles[position];
        let ratio = estimated.sigma / pole.sigma;
        let valid = (estimated.w - pole.w).abs() < MAX_GROUP_SHIFT.0 * pole.sigma
            && (1.0 / MAX_GROUP_SHIFT.1..=MAX_GROUP_SHIFT.1).contains(&ratio)
            && window.visibility(group, &modes, position) > MAX_GROUP_SHIFT.2;
        let uncertainty = covariance(std::slice::from_ref(&fit.problem), &fit.fit, NUMERATORS);
        let [re, im, _] = uncertainty.poles[position]?;
        (valid && re.is_finite() && im.is_finite() && re > 0.0 && im > 0.0).then_some(GroupPole {
            pole: estimated,
            variance: (im, re),
        })
    };
    groups.iter().filter_map(estimate).collect()
}
