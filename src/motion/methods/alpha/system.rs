//! Effective matrix S of a step, factored once per step size, with Woodbury's correction.

use super::weights::GeneralizedAlpha;
use crate::base::error::Error;
use crate::motion::dynamic_model::{DynamicModel, ForceLaw};
use crate::motion::pencil::add_outer_product;
use crate::motion::problem::IntegrationStats;
use crate::numeric::Matrix;
use crate::numeric::lu::Lu;

/// The constant parts of a machine.
pub struct ConstantPart<'a> {
    pub weights: &'a GeneralizedAlpha,
    pub model: &'a DynamicModel,
    mass: Matrix,
    stiffness: Matrix,
    damping: Matrix,
    /// Branches that are not constant.
    pub varying: Vec<usize>,
    /// Those among them that are contacts.
    pub contacts: Vec<usize>,
    /// By step length.
    pub systems: Vec<StepMatrix>,
}

/// `S = (1 − α_m)/(β h²) M + (1 − α_f) (γ/(β h) C + K)` with the other branches' directions solved for.
pub struct StepMatrix {
    h: f64,
    lu: Lu,
    /// S⁻¹ U.
    columns: Matrix,
    /// Wᵀ S⁻¹ U.
    capacitance: Matrix,
}

impl<'a> ConstantPart<'a> {
    /// Constant part of a machine's system.
    pub fn new(weights: &'a GeneralizedAlpha, model: &'a DynamicModel) -> ConstantPart<'a> {
        let n = model.coordinate_count();
        let (mut stiffness, mut damping) = (Matrix::zeros(n, n), Matrix::zeros(n, n));
        let mut others = Vec::new();
        for (at, branch) in model.elements.iter().enumerate() {
            match (&branch.law, &branch.angle_waves[..]) {
                (
                    ForceLaw::Linear {
                        stiffness: k,
                        damping: c,
                    },
                    [],
                ) => {
                    add_outer_product(
                        &mut stiffness,
                        branch.force_direction(),
                        &branch.direction,
                        *k,
                    );
                    add_outer_product(
                        &mut damping,
                        branch.force_direction(),
                        &branch.direction,
                        *c,
                    );
                }
                _ => others.push(at),
            }
        }
        let is_contact = |&&b: &&usize| matches!(model.elements[b].law, ForceLaw::Contact(_));
        let contacts = others.iter().filter(is_contact).copied().collect();
        if let Some((k, c)) = &model.global_matrices {
            stiffness += k;
            damping += c;
        }
        let mass = model.mass.matrix();
        for j in 0..n {
            for i in 0..n {
                damping[(i, j)] += model.mass_damping * mass[(i, j)];
            }
        }
        ConstantPart {
            weights,
            model,
            mass,
            stiffness,
            damping,
            contacts,
            varying: others,
            systems: Vec::new(),
        }
    }

    /// The number of the system of a step length.
    pub fn system(&mut self, h: f64, stats: &mut IntegrationStats) -> Result<usize, Error> {
        if let Some(at) = self.systems.iter().position(|s| s.h == h) {
            return Ok(at);
        }
        let (n, w) = (self.model.coordinate_count(), self.weights);
        let inertia = (1.0 - w.alpha_m) / (w.beta * h * h);
        let rate = w.gamma / (w.beta * h);
        let lu = Lu::new(&Matrix::from_fn(n, n, |i, j| {
            inertia * self.mass[(i, j)]
                + (1.0 - w.alpha_f) * (rate * self.damping[(i, j)] + self.stiffness[(i, j)])
        }))?;
        stats.factorisations += 1;
        let mut forces = Matrix::zeros(n, self.varying.len());
        for (j, &at) in self.varying.iter().enumerate() {
            for (i, a) in self.model.elements[at].force_direction().entries() {
                forces[(i, j)] = a;
            }
        }
        let columns = match self.varying.is_empty() {
            true => forces,
            false => lu.solve_matrix(&forces),
        };
        let m = self.varying.len();
        let small = Matrix::from_fn(m, m, |i, j| {
            self.model.elements[self.varying[i]]
                .direction
                .dot(columns.col_as_slice(j))
        });
        if self.systems.len() == 16 {
            self.systems.remove(0);
        }
        self.systems.push(StepMatrix {
            h,
            lu,
            columns,
            capacitance: small,
        });
        Ok(self.systems.len() - 1)
    }

    /// `(S + U D Wᵀ)⁻¹ r`, D the slopes of the other branches' forces (Woodbury's formula), in place.
    pub fn correct(&self, system: &StepMatrix, slopes: &[f64], r: &mut [f64]) -> Result<(), Error> {
        system.lu.solve(r);
        let m = slopes.len();
        if slopes.iter().all(|&d| d == 0.0) {
            return Ok(());
        }
        let direction = |i: usize| &self.model.elements[self.varying[i]].direction;
        let matrix = Matrix::from_fn(m, m, |i, j| {
            f64::from(u8::from(i == j)) + slopes[i] * system.capacitance[(i, j)]
        });
        let mut right: Vec<f64> = (0..m).map(|i| slopes[i] * direction(i).dot(r)).collect();
        Lu::new(&matrix)?.solve(&mut right);
        for (j, x) in right.iter().enumerate() {
            for (r, a) in r.iter_mut().zip(system.columns.col_as_slice(j)) {
                *r -= a * x;
            }
        }
        Ok(())
    }
}
