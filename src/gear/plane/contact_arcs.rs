//! Arcs at which a profile's point touches: the roots s of `f = (z − c(s))·t = 0`, in closed form on lines and circles.

use super::profile::ProfileJet;
use super::rolling::Centrode;
use crate::numeric::Complex;

/// Arcs of a general centrode at which roots are bracketed.
const ARC_SAMPLES: usize = 720;

/// `f` and `f_s` at an arc.
fn residual(centrode: &Centrode, jet: &ProfileJet, arc: f64) -> Option<[f64; 2]> {
    let state = centrode.at(arc)?;
    let dot = |a: Complex, b: Complex| (a * b.conj()).re;
    Some([
        dot(jet.point - state.point, jet.tangent),
        -dot(state.tangent, jet.tangent),
    ])
}

/// The arc nearest to a given one at which the normal of a profile's point passes through the pitch point.
pub(super) fn nearest_arc(centrode: &Centrode, jet: &ProfileJet, near: f64) -> Option<f64> {
    match centrode {
        Centrode::Line => line_root(jet),
        Centrode::Circle { radius } => {
            let roots = circle_roots(*radius, jet)?;
            let turn = std::f64::consts::TAU * radius.abs();
            let [a, b] = roots.map(|s| s + ((near - s) / turn).round() * turn);
            Some(if (a - near).abs() <= (b - near).abs() {
                a
            } else {
                b
            })
        }
        Centrode::Member { .. } => newton(centrode, jet, near),
    }
}

/// The normal passes through (0, s): `s = z·t / t_y`.
fn line_root(jet: &ProfileJet) -> Option<f64> {
    let arc = (jet.point * jet.tangent.conj()).re / jet.tangent.im;
    arc.is_finite().then_some(arc)
}

/// `R cos(s/R − μ) = z·t`, μ the angle of the tangent.
fn circle_roots(radius: f64, jet: &ProfileJet) -> Option<[f64; 2]> {
    let along = (jet.point * jet.tangent.conj()).re;
    let across = (radius - along) * (radius + along);
    if !(across >= 0.0) {
        return None;
    }
    let (angle, reach) = (
        jet.tangent.arg(),
        across.sqrt().atan2(along * radius.signum()),
    );
    Some([radius * (angle - reach), radius * (angle + reach)])
}

fn newton(centrode: &Centrode, jet: &ProfileJet, near: f64) -> Option<f64> {
    let scale = jet.point.norm().max(near.abs());
    let mut arc = near;
    for _ in 0..30 {
        let [f, slope] = residual(centrode, jet, arc)?;
        let step = (-f / slope).clamp(-0.1 * scale, 0.1 * scale);
        if !step.is_finite() {
            return None;
        }
        arc += step;
        if step.abs() <= 4.0 * f64::EPSILON * scale {
            return Some(arc);
        }
    }
    let [f, _] = residual(centrode, jet, arc)?;
    (f.abs() <= 1e-13 * scale).then_some(arc)
}

/// Points of a centrode at equal arcs, where roots are bracketed; empty for lines and circles, whose roots are closed forms.
pub(super) struct ArcGrid(Vec<(f64, Complex)>);

impl ArcGrid {
    pub(super) fn new(centrode: &Centrode) -> ArcGrid {
        let Centrode::Member { pair, .. } = centrode else {
            return ArcGrid(vec![]);
        };
        let (first, total) = match centrode.arc_of_turn() {
            Some(turn) => (-0.5 * turn, turn),
            None => (pair.arc(pair.period()[0]), pair.arc_of_period()),
        };
        let arc = |i: usize| first + total * i as f64 / ARC_SAMPLES as f64;
        let point = |i: usize| centrode.at(arc(i)).map(|at| (arc(i), at.point));
        ArcGrid((0..=ARC_SAMPLES).filter_map(point).collect())
    }

    /// Every arc of a turn at which a profile's point touches.
    pub(super) fn contact_arcs(&self, centrode: &Centrode, jet: &ProfileJet) -> Vec<f64> {
        match centrode {
            Centrode::Line => line_root(jet).into_iter().collect(),
            Centrode::Circle { radius } => {
                let turn = std::f64::consts::TAU * radius.abs();
                let roots = circle_roots(*radius, jet).into_iter().flatten();
                roots.map(|s| s - (s / turn).round() * turn).collect()
            }
            Centrode::Member { .. } => {
                let f = |c: Complex| ((jet.point - c) * jet.tangent.conj()).re;
                let brackets = self.0.windows(2).filter_map(|pair| {
                    let (f0, f1) = (f(pair[0].1), f(pair[1].1));
                    let share = f0 / (f0 - f1);
                    (f0 * f1 <= 0.0).then(|| pair[0].0 + share * (pair[1].0 - pair[0].0))
                });
                brackets
                    .filter_map(|arc| newton(centrode, jet, arc))
                    .collect()
            }
        }
    }
}
