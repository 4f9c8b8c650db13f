//! Weights of the family.

/// The spectral radius at infinity that the methods of the table are run with.
pub const RADIUS: f64 = 0.8;

/// Weights of a method of the family.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Alpha {
    /// α_m: the share of the old acceleration.
    pub inertia: f64,
    /// α_f: the share of the old state.
    pub force: f64,
    /// β.
    pub beta: f64,
    /// γ.
    pub gamma: f64,
}

impl Alpha {
    /// Newmark's average acceleration: β = ¼, γ = ½; no numerical damping.
    pub fn newmark() -> Alpha {
        Alpha {
            inertia: 0.0,
            force: 0.0,
            beta: 0.25,
            gamma: 0.5,
        }
    }

    /// Hilber, Hughes and Taylor's, by the spectral radius at infinity, from ½ to 1: α = (ρ − 1)/(ρ + 1).
    pub fn hht(radius: f64) -> Alpha {
        let force = (1.0 - radius) / (1.0 + radius);
        Alpha {
            inertia: 0.0,
            force,
            beta: 0.25 * (1.0 + force) * (1.0 + force),
            gamma: 0.5 + force,
        }
    }

    /// Chung and Hulbert's, by the spectral radius at infinity, from 0 to 1.
    pub fn generalized(radius: f64) -> Alpha {
        let (inertia, force) = (
            (2.0 * radius - 1.0) / (radius + 1.0),
            radius / (radius + 1.0),
        );
        let offset = inertia - force;
        Alpha {
            inertia,
            force,
            beta: 0.25 * (1.0 - offset) * (1.0 - offset),
            gamma: 0.5 - offset,
        }
    }

    /// The factor of `h² (a₁ − a₀)` in the local error of positions: ⅙ − β, less what a's offset in time makes up for.
    ///
    /// Source: Zienkiewicz and Xie 1991, equation 9, for Newmark's; with the offset `(α_m − α_f) h` of a after Arnold and
    /// Brüls 2007 for the others.
    pub fn local_error(&self) -> f64 {
        1.0 / 6.0 - self.beta - 0.5 * (self.inertia - self.force)
    }

    /// The factor of `h³ ä` in the local error of speeds, ä the second derivative of a: with `δ = α_m − α_f` and `γ = ½ − δ`
    /// it is `1/12 − δ²/2`, from Taylor's series of `v₁ = v₀ + h ((1 − γ) a(t₀ + δh) + γ a(t₁ + δh))`.
    pub fn local_error_of_speed(&self) -> f64 {
        let offset = self.inertia - self.force;
        1.0 / 12.0 - 0.5 * offset * offset
    }
}
