//! Weights α_m, α_f, β, γ of the generalised-α family.

/// The spectral radius at infinity that the methods of the table are run with.
pub const SPECTRAL_RADIUS: f64 = 0.8;

/// Weights of a method of the family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeneralizedAlpha {
    /// α_m: the share of the old acceleration.
    pub alpha_m: f64,
    /// α_f: the share of the old state.
    pub alpha_f: f64,
    /// β.
    pub beta: f64,
    /// γ.
    pub gamma: f64,
}

impl GeneralizedAlpha {
    /// Newmark's average acceleration: β = ¼, γ = ½; no numerical damping.
    pub fn newmark() -> GeneralizedAlpha {
        GeneralizedAlpha {
            alpha_m: 0.0,
            alpha_f: 0.0,
            beta: 0.25,
            gamma: 0.5,
        }
    }

    /// Hilber, Hughes and Taylor's, by the spectral radius at infinity, from ½ to 1: α = (ρ − 1)/(ρ + 1).
    pub fn hht(radius: f64) -> GeneralizedAlpha {
        let force = (1.0 - radius) / (1.0 + radius);
        GeneralizedAlpha {
            alpha_m: 0.0,
            alpha_f: force,
            beta: 0.25 * (1.0 + force) * (1.0 + force),
            gamma: 0.5 + force,
        }
    }

    /// Chung and Hulbert's, by the spectral radius at infinity, from 0 to 1.
    pub fn generalized(radius: f64) -> GeneralizedAlpha {
        let (inertia, force) = (
            (2.0 * radius - 1.0) / (radius + 1.0),
            radius / (radius + 1.0),
        );
        let offset = inertia - force;
        GeneralizedAlpha {
            alpha_m: inertia,
            alpha_f: force,
            beta: 0.25 * (1.0 - offset) * (1.0 - offset),
            gamma: 0.5 - offset,
        }
    }

    /// The factor of `h² (a₁ − a₀)` in the local error of positions: ⅙ − β, less what a's offset in time makes up for.
    ///
    /// Source: Zienkiewicz and Xie 1991, equation 9, for Newmark's; with the offset `(α_m − α_f) h` of a after Arnold and
    /// Brüls 2007 for the others.
    pub fn local_error(&self) -> f64 {
        1.0 / 6.0 - self.beta - 0.5 * (self.alpha_m - self.alpha_f)
    }

    /// The factor of `h³ ä` in the local error of speeds, ä the second derivative of a: with `δ = α_m − α_f` and `γ = ½ − δ`
    /// it is `1/12 − δ²/2`, from Taylor's series of `v₁ = v₀ + h ((1 − γ) a(t₀ + δh) + γ a(t₁ + δh))`.
    pub fn local_error_of_speed(&self) -> f64 {
        let offset = self.alpha_m - self.alpha_f;
        1.0 / 12.0 - 0.5 * offset * offset
    }
}
