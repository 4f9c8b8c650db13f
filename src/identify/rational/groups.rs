//! Every mode by each hit, or each response, alone: where their poles differ by more than they are uncertain, the mode is the mean of the
//! population they come from, and as uncertain as their differences make it.

use super::basis::ScaledPole;
use super::covariance::covariance;
use super::model_error::ModeDeviation;
use super::projection::StopCriteria;
use super::random_effects::{PooledMean, differ, differ_together, heterogeneity, pooled_mean};
use super::scatter::MIN_GROUPS;
use super::windowed::{BandFit, NUMERATORS, PoleWindow, WindowFit, half_window};

/// Two hits have a mean with an interval of one degree of freedom; responses, which differ by where they are, need [`MIN_GROUPS`].
pub(super) const MIN_HITS: usize = 2;

/// Rounds of fit and departure of each group.
const MAX_ITERATIONS: usize = 3;

/// The mean response of hits whose poles scatter by δ, `1/z + ⟨δ²⟩/z³` to second order with `z = jω − p`, is fitted best by a pole that is
/// off by so many times `⟨δ²⟩/σ`: in a window of 8 half-widths to either side with a straight background (1 without either).
const BROADER: f64 = 1.27;

const CONVERGENCE: StopCriteria = StopCriteria {
    steps: 8,
    min_decrease: 0.0,
    min_relative_decrease: 1e-8,
};

/// A group has lost the mode where its pole is off by so many half-widths, so many times as wide or narrow, or less of its response.
const MAX_GROUP_SHIFT: (f64, f64, f64) = (2.0, 4.5, 0.02);

/// Mean of the groups' estimates of a mode.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct GroupMean {
    /// Groups that see it.
    pub count: usize,
    /// Mean frequency and real part, where the groups differ about either: with variances for intervals of 1.96 standard deviations.
    pub mean: Option<(PooledMean, PooledMean)>,
}

/// One group's pole with the variances of w and σ.
struct GroupPole {
    pole: ScaledPole,
    variance: (f64, f64),
}

/// Means over the groups for every pole; nothing of those that fewer than three groups see, or fewer than two hits.
pub(super) fn means(
    band: &BandFit,
    groups: &[Vec<usize>],
    by_hit: bool,
    departures: &[ModeDeviation],
    is_reported: &dyn Fn(&ScaledPole) -> bool,
) -> Vec<Option<GroupMean>> {
    let poles = &band.modes.poles;
    let least = if by_hit { MIN_HITS } else { MIN_GROUPS };
    let own: Vec<Vec<GroupPole>> = (0..poles.len())
        .map(|r| match is_reported(&poles[r]) && groups.len() >= least {
            true => own_poles(band, groups, departures, r),
            false => Vec::new(),
        })
        .collect();
    let column = |own: &[GroupPole],
                  pick: &dyn Fn(&GroupPole) -> (f64, f64)|
     -> (Vec<f64>, Vec<f64>) { own.iter().map(pick).unzip() };
    let frequency = |o: &GroupPole| (o.pole.w, o.variance.0);
    let width = |o: &GroupPole| (o.pole.sigma, o.variance.1);
    let statistic = |own: &[GroupPole]| {
        let of = |pick: &dyn Fn(&GroupPole) -> (f64, f64)| {
            let (y, v) = column(own, pick);
            heterogeneity(&y, &v)
        };
        [of(&frequency), of(&width)]
    };
    let seen = |own: &&Vec<GroupPole>| own.len() >= least;
    let (q, dof) = own.iter().filter(seen).fold((0.0, 0.0), |(q, dof), own| {
        let [a, b] = statistic(own);
        (q + a + b, dof + 2.0 * (own.len() as f64 - 1.0))
    });
    // Hits of one test share what makes them differ; responses need not.
    let together = by_hit && differ_together(q, dof);
    own.iter()
        .map(|own| {
            if own.len() < least {
                return None;
            }
            let free = own.len() as f64 - 1.0;
            let differs = together || statistic(own).into_iter().any(|q| differ(q, free));
            let of = |pick: &dyn Fn(&GroupPole) -> (f64, f64)| {
                let (y, v) = column(own, pick);
                let found = pooled_mean(&y, &v);
                let least = 1.0 / v.iter().map(|v| 1.0 / v).sum::<f64>();
                PooledMean {
                    variance: found.variance.max(least),
                    ..found
                }
            };
            Some(GroupMean {
                count: own.len(),
                mean: differs.then(|| {
                    let (w, sigma) = (of(&frequency), of(&width));
                    (w, narrowed(sigma, &w, band.lines.joined, free))
                }),
            })
        })
        .collect()
}

/// The mean width less what joining hits added to it: of `joined` hits to a group, whose variance between groups is the `joined`th part of
/// that between hits, `⟨δ²⟩ = (joined − 1)(s_σ² − s_w²)` with the deviations s between groups. These are known from `free` degrees of freedom.
fn narrowed(sigma: PooledMean, w: &PooledMean, joined: f64, free: f64) -> PooledMean {
    let between = w.between_std.powi(2) - sigma.between_std.powi(2);
    let excess = BROADER * (joined - 1.0) * between / sigma.mean;
    PooledMean {
        mean: sigma.mean - excess,
        variance: sigma.variance + 2.0 / free * excess * excess,
        ..sigma
    }
}

fn own_poles(
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
            let apart = |o: usize| (poles[o].w - pole.w).abs();
            apart(a).total_cmp(&apart(b))
        })
        .map_or(0.0, |o| poles[o].sigma);
    let half = half_window(lines.step, pole.sigma, neighbour);
    let window = PoleWindow::new(band, pole.w, half, &|o| departures[o]);
    let Some(at) = window.near.iter().position(|&o| o == r) else {
        return Vec::new();
    };
    let start: Vec<ScaledPole> = window.near.iter().map(|&o| poles[o]).collect();
    let common = band.modes.select(&window.near);
    let one = |group: &Vec<usize>| -> Option<GroupPole> {
        let mut departures: Vec<ModeDeviation> = (window.near.iter())
            .map(|&o| ModeDeviation {
                scatter: 0.0,
                ..departures[o]
            })
            .collect();
        let mut modes = common.clone();
        let mut fit: Option<WindowFit> = None;
        for _ in 0..MAX_ITERATIONS {
            let weights = window.weights(group, &window.variance(&modes, &departures));
            let from = fit.as_ref().map_or(&start, |f| &f.fit.model.poles);
            let next = window.fit(group, &weights, from, CONVERGENCE);
            modes = next.modes(lines.h.len());
            let residual = next.residual(lines.independence);
            for (k, d) in departures.iter_mut().enumerate() {
                d.share = window.misfit(group, &residual, &modes, k);
                d.width = modes.poles[k].sigma;
            }
            fit = Some(next);
        }
        let fit = fit?;
        let found = fit.fit.model.poles[at];
        let ratio = found.sigma / pole.sigma;
        let stays = (found.w - pole.w).abs() < MAX_GROUP_SHIFT.0 * pole.sigma
            && (1.0 / MAX_GROUP_SHIFT.1..=MAX_GROUP_SHIFT.1).contains(&ratio)
            && window.visibility(group, &modes, at) > MAX_GROUP_SHIFT.2;
        let certain = covariance(std::slice::from_ref(&fit.problem), &fit.fit, NUMERATORS);
        let [re, im, _] = certain.poles[at]?;
        (stays && re.is_finite() && im.is_finite() && re > 0.0 && im > 0.0).then_some(GroupPole {
            pole: found,
            variance: (im, re),
        })
    };
    groups.iter().filter_map(one).collect()
}
