//! Collisions of Floquet multipliers of two modes, near the speeds `(ω_i + ω_j)/n`.
//!
//! A stiffness that varies feeds a motion only there: multipliers leave the circle on which damping keeps them in pairs, at
//! speeds near `(ω_i + ω_j)/n` (Krein 1955; Yakubovich and Starzhinskii 1975, ch. III and V). At speeds near differences nothing
//! is fed as long as stiffness and inertia are symmetric: multipliers that meet there are of one kind and pass each other. Where
//! they are not (gyroscopic or circulating terms), the steps of a chart alone tell.
//!
//! With m turns of both modes together in a period T, `(ω_i + ω_j) T = 2π m`, and ω as the varying stiffness leaves them: the phase
//! `d = arg μ_i + arg μ_j` that is missing at one speed gives the next, `(1 + d/2πm)` times as fast. Next to a tongue of half
//! width w, at a distance x from its middle, `d ∝ √(x² − w²)`, so that the next speed lies `x − √(x² − w²) < w` from the
//! middle: within it.

use std::f64::consts::{PI, TAU};

use super::Monodromy;
use crate::base::error::Error;
use crate::motion::dynamic_model::{DynamicModel, ForceElement};
use crate::motion::methods::periodic::grid::frequencies;
use crate::motion::methods::periodic::scale::closed_jacobian;
use crate::numeric::eigen::{GeneralEigen, eigen};
use crate::numeric::sorting::sort_rising;
use crate::numeric::{Complex, ComplexMatrix};

/// Oscillatory modes of a machine with its mean stiffness.
pub struct OscillatoryModes {
    /// `(λ, which column)` of the oscillatory modes, by rising frequency.
    swinging: Vec<(Complex, usize)>,
    all: GeneralEigen,
}

/// Two modes, and the speed at which they would meet if their frequencies were those of the mean stiffness.
#[derive(Debug, Clone, Copy)]
pub struct CollisionCandidate {
    /// As a factor on the speed of the machine.
    pub factor: f64,
    pair: [usize; 2],
    joint_cycles: f64,
}

/// Collision point of two multipliers.
#[derive(Debug, Clone, Copy)]
pub struct MultiplierCollision {
    /// As a factor on the speed of the machine.
    pub factor: f64,
    /// The middle of what is fed lies no further from it than this.
    pub radius: f64,
}

/// Slower motions than this share of the fastest are free turning and its rounding.
const RIGID_TOLERANCE: f64 = 1e-6;

/// Phases that agree to this have met, rad; multipliers that meet are known to about the square root of rounding.
const PHASE_TOLERANCE: f64 = 1e-6;

/// Steps to a meeting: each leaves a small share of the way, since a varying stiffness shifts frequencies by little.
const MAX_STEPS: usize = 12;

/// A multiplier moved outwards by less than this share of what damping takes is not looked at closer.
const MIN_GROWTH_SHARE: f64 = 0.2;

impl OscillatoryModes {
    /// Oscillatory modes of a machine.
    ///
    /// # Errors
    /// Branches that are not linear with all contacts closed; eigenvalues that are not found.
    pub fn new(model: &DynamicModel) -> Result<OscillatoryModes, Error> {
        let all = eigen(&closed_jacobian(model, ForceElement::mean_factor)?)?;
        let fastest = all.values.last().map_or(0.0, |value| value.norm());
        let values = all.values.iter().copied().enumerate();
        let mut swinging: Vec<(Complex, usize)> = values
            .filter(|(_, value)| value.im > RIGID_TOLERANCE * fastest)
            .map(|(at, value)| (value, at))
            .collect();
        sort_rising(&mut swinging, |a| a.0.im);
        Ok(OscillatoryModes { swinging, all })
    }

    /// Meetings expected between two speeds, up to an order of every wave; `base` is the frequency the machine repeats with, rad/s.
    pub fn candidates(
        &self,
        model: &DynamicModel,
        base: f64,
        [from, to]: [f64; 2],
        highest_order: u32,
    ) -> Vec<CollisionCandidate> {
        let mut turns: Vec<f64> = frequencies(model)
            .flat_map(|wave| (1..=highest_order).map(move |n| f64::from(n) * (wave / base).round()))
            .collect();
        turns.sort_by(f64::total_cmp);
        turns.dedup();
        let mut found = Vec::new();
        for i in 0..self.swinging.len() {
            for j in i..self.swinging.len() {
                let sum = self.swinging[i].0.im + self.swinging[j].0.im;
                let at = |turns: f64| CollisionCandidate {
                    factor: sum / (turns * base),
                    pair: [i, j],
                    joint_cycles: turns,
                };
                let all = turns.iter().map(|&turns| at(turns));
                found.extend(all.filter(|e| (from..=to).contains(&e.factor)));
            }
        }
        found
    }

    /// Locates the collision of two modes near the expected speed, if their coupling there is strong enough to outdo damping.
    ///
    /// # Errors
    /// Those of `at`, which gives what a period does at a speed; eigenvalues that are not found.
    pub fn locate_collision(
        &self,
        expected_lines: CollisionCandidate,
        at: impl Fn(f64) -> Result<Monodromy, Error>,
    ) -> Result<Option<MultiplierCollision>, Error> {
        let CollisionCandidate {
            factor: first,
            pair,
            joint_cycles: turns,
        } = expected_lines;
        let decays = pair.map(|mode| self.swinging[mode].0.re);
        let mut factor = first;
        for _ in 0..MAX_STEPS {
            let monodromy = at(factor)?;
            let period = eigen(&monodromy.matrix)?;
            let multipliers = pair.map(|mode| self.multiplier(mode, &period));
            let missing = wrap_angle(multipliers.iter().map(|value| value.arg()).sum());
            let loss = -0.5 * monodromy.period * (decays[0] + decays[1]);
            let moved = multipliers.map(|value| (value.norm().ln() + loss).abs());
            let gain = moved[0].max(moved[1]);
            // Where damping is uneven phases come together slowly: as near as the gain is wide is near enough.
            if missing.abs() < gain.max(PHASE_TOLERANCE) {
                let fed = gain > (MIN_GROWTH_SHARE * loss).max(PHASE_TOLERANCE);
                let within = factor * 2.0 * gain.max(loss.abs()) / (TAU * turns);
                return Ok(fed.then_some(MultiplierCollision {
                    factor,
                    radius: within,
                }));
            }
            factor *= 1.0 + missing / (TAU * turns);
            // Further away the phase belongs to another number of turns.
            if (factor / first - 1.0).abs() > 0.5 / turns {
                break;
            }
        }
        Ok(None)
    }

    /// The multiplier that takes most part in a mode: the largest `tr(P_μ P_λ) = (y_λᴴ x_μ)(y_μᴴ x_λ)` of projections on both.
    fn multiplier(&self, mode: usize, period: &GeneralEigen) -> Complex {
        let column = self.swinging[mode].1;
        let part = |at: usize| {
            hermitian_product(&self.all.left_vectors, column, &period.right, at)
                * hermitian_product(&period.left_vectors, at, &self.all.right, column)
        };
        let parts = (0..period.values.len()).map(|at| (part(at).norm(), at));
        let most = parts
            .filter(|(part, _)| part.is_finite())
            .max_by(|a, b| a.0.total_cmp(&b.0));
        most.map_or(Complex::new(1.0, 0.0), |(_, at)| period.values[at])
    }
}

/// `xᴴ y` of a column of each.
fn hermitian_product(x: &ComplexMatrix, i: usize, y: &ComplexMatrix, j: usize) -> Complex {
    (0..x.nrows()).map(|k| x[(k, i)].conj() * y[(k, j)]).sum()
}

/// The same angle within half a turn of zero.
fn wrap_angle(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}
