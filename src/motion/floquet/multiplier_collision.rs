//! Collisions of Floquet multipliers of two modes, near the speeds `(ω_i + ω_j)/n`.
//!
//! Parametric resonance of a varying stiffness is confined to these speeds: multipliers depart from the circle of damping in
//! pairs near `(ω_i + ω_j)/n` (Krein 1955; Yakubovich and Starzhinskii 1975, ch. III and V). Near differences of frequencies there
//! is no resonance with symmetric stiffness and inertia: the colliding multipliers are of one kind and pass each other. With
//! gyroscopic or circulatory terms only the speed steps of a stability chart detect resonance.
//!
//! The collision condition with m joint cycles of both modes per period T is `(ω_i + ω_j) T = 2π m`, ω being the frequencies under
//! varying stiffness. The phase deficit `d = arg μ_i + arg μ_j` at one speed gives the next speed, `(1 + d/2πm)` times as fast.
//! Near an instability tongue of half width w, at a distance x from its middle, `d ∝ √(x² − w²)`, so that the next speed lies
//! within the tongue: `x − √(x² − w²) < w`.

use std::f64::consts::{PI, TAU};

use super::Monodromy;
use crate::base::error::Error;
use crate::motion::dynamic_model::{DynamicModel, ForceElement};
use crate::motion::methods::periodic::grid::frequencies;
use crate::motion::methods::periodic::scale::closed_jacobian;
use crate::numeric::eigen::{GeneralEigen, eigen};
use crate::numeric::sorting::sort_ascending;
use crate::numeric::{Complex, ComplexMatrix};

/// Oscillatory modes of a machine with its mean stiffness.
pub struct OscillatoryModes {
    /// Eigenvalue λ, 1/s, and column of the oscillatory modes, in ascending order of frequency.
    oscillatory: Vec<(Complex, usize)>,
    all: GeneralEigen,
}

/// Expected collision of two multipliers, from the frequencies at mean stiffness.
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
    /// Upper bound of its distance from the middle of the instability tongue, as a factor on the speed.
    pub radius: f64,
}

/// Frequency relative to the highest, below which a mode is a rigid motion with rounding.
const RIGID_TOLERANCE: f64 = 1e-6;

/// Phase tolerance of a collision, rad: colliding multipliers are accurate to about the square root of rounding.
const PHASE_TOLERANCE: f64 = 1e-6;

/// Maximum number of speed iterations; they converge fast, since a varying stiffness shifts frequencies little.
const MAX_STEPS: usize = 12;

/// Smallest growth by coupling, relative to the decay by damping, of a relevant collision.
const MIN_GROWTH_SHARE: f64 = 0.2;

impl OscillatoryModes {
    /// Oscillatory modes of a machine.
    ///
    /// # Errors
    /// Branches that are not linear with all contacts closed; no convergence of eigenvalues.
    pub fn new(model: &DynamicModel) -> Result<OscillatoryModes, Error> {
        let all = eigen(&closed_jacobian(model, ForceElement::mean_factor)?)?;
        let fastest = all.values.last().map_or(0.0, |value| value.norm());
        let values = all.values.iter().copied().enumerate();
        let mut oscillatory: Vec<(Complex, usize)> = values
            .filter(|(_, value)| value.im > RIGID_TOLERANCE * fastest)
            .map(|(column, value)| (value, column))
            .collect();
        sort_ascending(&mut oscillatory, |a| a.0.im);
        Ok(OscillatoryModes { oscillatory, all })
    }

    /// Expected collisions between two speed factors, up to an order of every wave; `base` is the fundamental frequency, rad/s.
    pub fn candidates(
        &self,
        model: &DynamicModel,
        base: f64,
        [from, to]: [f64; 2],
        highest_order: u32,
    ) -> Vec<CollisionCandidate> {
        let mut orders: Vec<f64> = frequencies(model)
            .flat_map(|wave| (1..=highest_order).map(move |n| f64::from(n) * (wave / base).round()))
            .collect();
        orders.sort_by(f64::total_cmp);
        orders.dedup();
        let mut candidates = Vec::new();
        for i in 0..self.oscillatory.len() {
            for j in i..self.oscillatory.len() {
                let sum = self.oscillatory[i].0.im + self.oscillatory[j].0.im;
                let candidate = |cycles: f64| CollisionCandidate {
                    factor: sum / (cycles * base),
                    pair: [i, j],
                    joint_cycles: cycles,
                };
                let all = orders.iter().map(|&cycles| candidate(cycles));
                candidates.extend(all.filter(|e| (from..=to).contains(&e.factor)));
            }
        }
        candidates
    }

    /// Locates the collision of two modes near the expected speed, if their coupling is strong enough against damping.
    ///
    /// # Errors
    /// Errors of `monodromy_at`, the monodromy matrix at a speed factor; no convergence of eigenvalues.
    pub fn locate_collision(
        &self,
        expected: CollisionCandidate,
        monodromy_at: impl Fn(f64) -> Result<Monodromy, Error>,
    ) -> Result<Option<MultiplierCollision>, Error> {
        let CollisionCandidate {
            factor: first,
            pair,
            joint_cycles: cycles,
        } = expected;
        let decays = pair.map(|mode| self.oscillatory[mode].0.re);
        let mut factor = first;
        for _ in 0..MAX_STEPS {
            let monodromy = monodromy_at(factor)?;
            let period = eigen(&monodromy.matrix)?;
            let multipliers = pair.map(|mode| self.multiplier(mode, &period));
            let deficit = wrap_angle(multipliers.iter().map(|value| value.arg()).sum());
            let loss = -0.5 * monodromy.period * (decays[0] + decays[1]);
            let growth = multipliers.map(|value| (value.norm().ln() + loss).abs());
            let gain = growth[0].max(growth[1]);
            // Phases converge slowly under uneven damping: a phase error below the gain suffices.
            if deficit.abs() < gain.max(PHASE_TOLERANCE) {
                let unstable = gain > (MIN_GROWTH_SHARE * loss).max(PHASE_TOLERANCE);
                let radius = factor * 2.0 * gain.max(loss.abs()) / (TAU * cycles);
                return Ok(unstable.then_some(MultiplierCollision { factor, radius }));
            }
            factor *= 1.0 + deficit / (TAU * cycles);
            // Farther off the phase belongs to another number of joint cycles.
            if (factor / first - 1.0).abs() > 0.5 / cycles {
                break;
            }
        }
        Ok(None)
    }

    /// Multiplier of a mode: the largest participation `tr(P_μ P_λ) = (y_λᴴ x_μ)(y_μᴴ x_λ)` of both spectral projectors.
    fn multiplier(&self, mode: usize, period: &GeneralEigen) -> Complex {
        let column = self.oscillatory[mode].1;
        let participation = |index: usize| {
            hermitian_product(&self.all.left_vectors, column, &period.right, index)
                * hermitian_product(&period.left_vectors, index, &self.all.right, column)
        };
        let participations =
            (0..period.values.len()).map(|index| (participation(index).norm(), index));
        let largest = participations
            .filter(|(participation, _)| participation.is_finite())
            .max_by(|a, b| a.0.total_cmp(&b.0));
        largest.map_or(Complex::new(1.0, 0.0), |(_, index)| period.values[index])
    }
}

/// Hermitian product `xᴴ y` of column i of x and column j of y.
fn hermitian_product(x: &ComplexMatrix, i: usize, y: &ComplexMatrix, j: usize) -> Complex {
    (0..x.nrows()).map(|k| x[(k, i)].conj() * y[(k, j)]).sum()
}

/// Angle wrapped to [−π, π), rad.
fn wrap_angle(angle: f64) -> f64 {
    (angle + PI).rem_euclid(TAU) - PI
}
