//! Is each pole needed next to its neighbours? Two poles in one resonance explain each other's departure from the model; so a pole is
//! judged in the variance of the fit without it, in a window about it.

use super::basis::Pole;
use super::departure::Departure;
use super::projection::Stop;
use super::scatter::{FEWEST_GROUPS, scatter};
use super::windowed::{Band, NUMERATORS, Window, WindowFit, half_window};

/// Share of its own value by which a mode is taken to be off its model while poles are sought and judged: a pole then has to explain
/// some 5 to 9 % of the response about it. With 0.01 all modes of a measured beam stayed double.
pub(super) const DEPARTURE: f64 = 0.02;

/// Of a neighbour this near, in half-widths or two lines, and of this ratio of widths, only a gross misfit proves that there are two.
const ONE: (f64, f64) = (0.5, 3.0);
const DEPARTURE_OF_ONE: f64 = 0.15;

/// A pole is judged if another lies within so many half-widths or two lines; hits may take its place within so many.
const NEAR: f64 = 4.0;
const NEAR_BY_HIT: f64 = 3.0;

/// A broad neighbour counts as no wider than so many times the pole.
const BROADER: f64 = 5.0;

/// Half-widths that the pole of a hit may be off the common one.
const SHIFT: f64 = 3.0;

const STOP: Stop = Stop {
    steps: 10,
    fall: 0.3,
    share: 1e-4,
};

/// A pole that is not needed.
pub(super) struct Needless {
    /// Which.
    pub pole: usize,
    /// What it gained.
    gain: f64,
    /// Where the poles of its window are without it.
    pub others: Vec<(usize, Pole)>,
}

/// What decides.
pub(super) struct Judge<'a> {
    /// Fall of χ² a pole must bring.
    pub threshold: f64,
    /// Responses by hit, or each alone; empty where there are too few.
    pub groups: &'a [Vec<usize>],
    /// Groups are hits.
    pub by_hit: bool,
}

/// How near two poles are, in half-widths of the first or two lines; of a broad second one a few of the first.
fn distance(q: &Pole, r: &Pole, step: f64) -> f64 {
    let unit = q.sigma.max(r.sigma.min(BROADER * q.sigma)).max(2.0 * step);
    (q.w - r.w).abs() / unit
}

/// A pole that moved little.
pub(super) fn is_same(a: &Pole, b: &Pole) -> bool {
    const SAME: f64 = 0.98;
    a.overlap(b) > SAME
}

impl Judge<'_> {
    /// Poles that are not needed, the least first, no two of one window; `needed` are those known to be, by place.
    pub fn needless(&self, band: &Band, needed: &mut Vec<Pole>) -> Vec<Needless> {
        let poles = &band.modes.poles;
        let mut all = Vec::new();
        for q in 0..poles.len() {
            if needed.iter().any(|p| is_same(p, &poles[q])) {
                continue;
            }
            match self.judged(band, q) {
                Some(needless) => all.push(needless),
                None => needed.push(poles[q]),
            }
        }
        all.sort_by(|a: &Needless, b| a.gain.total_cmp(&b.gain));
        let mut chosen: Vec<Needless> = Vec::new();
        for one in all {
            let touches = |other: &Needless| {
                let mut of = other.others.iter().map(|o| o.0).chain([other.pole]);
                of.any(|r| r == one.pole || one.others.iter().any(|o| o.0 == r))
            };
            if !chosen.iter().any(touches) {
                chosen.push(one);
            }
        }
        chosen
    }

    /// `None` where the pole is needed, or alone.
    fn judged(&self, band: &Band, q: usize) -> Option<Needless> {
        let (poles, lines) = (&band.modes.poles, band.lines);
        let (pole, step) = (poles[q], lines.step);
        let others = (0..poles.len()).filter(|&r| r != q);
        let nearest = others.min_by(|&a, &b| {
            let of = |r: usize| distance(&pole, &poles[r], step);
            of(a).total_cmp(&of(b))
        })?;
        let near = distance(&pole, &poles[nearest], step);
        if near > NEAR {
            return None;
        }
        let half = half_window(step, pole.sigma, poles[nearest].sigma);
        let share = |r: usize| {
            let other = &poles[r];
            let apart = (other.w - pole.w).abs();
            let ratio = other.sigma / pole.sigma;
            let is_one = apart < ONE.0 * other.sigma.max(pole.sigma).max(2.0 * step)
                && (1.0 / ONE.1..=ONE.1).contains(&ratio);
            if is_one { DEPARTURE_OF_ONE } else { DEPARTURE }
        };
        let departure = |r: usize| Departure {
            share: share(r),
            scatter: 0.0,
            width: pole.sigma,
        };
        let window = Window::new(band, pole.w, half, &departure);
        let others: Vec<usize> = window.near.iter().copied().filter(|&r| r != q).collect();
        let all: Vec<usize> = (0..lines.h.len()).collect();
        // The variance of the fit without it.
        let mut modes = band.modes.of(&others);
        let mut departures: Vec<Departure> = others.iter().map(|&r| departure(r)).collect();
        let mut weights = window.weights(&all, &window.variance(&modes, &departures));
        let mut without = window.fit(&all, &weights, &modes.poles, STOP);
        for _ in 0..2 {
            modes = without.modes(lines.h.len());
            let tau = self.scatter(&without);
            for (d, tau) in departures.iter_mut().zip(tau) {
                d.scatter = tau;
            }
            weights = window.weights(&all, &window.variance(&modes, &departures));
            without = window.fit(&all, &weights, &modes.poles, STOP);
        }
        let with: Vec<Pole> = window.near.iter().map(|&r| poles[r]).collect();
        let with = window.fit(&all, &weights, &with, STOP);
        let mut gain = without.fitted.chi2 - with.fitted.chi2;
        if self.by_hit && near < NEAR_BY_HIT && gain >= self.threshold {
            let start = &without.fitted.model.poles;
            let own: Vec<WindowFit> = (self.groups.iter())
                .map(|hit| window.fit(hit, &weights, start, STOP))
                .collect();
            let chi2: f64 = own.iter().map(|f| f.fitted.chi2).sum();
            let stays = |f: &WindowFit| {
                let mut pairs = f.fitted.model.poles.iter().zip(start);
                pairs.all(|(a, b)| (a.w - b.w).abs() < SHIFT * b.sigma)
            };
            if chi2 < with.fitted.chi2 + self.threshold && own.iter().all(stays) {
                gain = 0.5 * self.threshold;
            }
        }
        let moved = without.fitted.model.poles;
        (gain < self.threshold).then(|| Needless {
            pole: q,
            gain,
            others: others.into_iter().zip(moved).collect(),
        })
    }

    fn scatter(&self, fit: &WindowFit) -> Vec<f64> {
        if self.groups.len() < FEWEST_GROUPS {
            return vec![0.0; fit.fitted.model.poles.len()];
        }
        scatter(&fit.problem, &fit.fitted, NUMERATORS, self.groups)
    }
}
