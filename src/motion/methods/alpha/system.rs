//! The linear system of a step, factored once per step length, and its correction of low rank.

use super::weights::Alpha;
use crate::base::error::Error;
use crate::motion::pencil::add;
use crate::motion::problem::Effort;
use crate::motion::train::{Law, Train};
use crate::numeric::Matrix;
use crate::numeric::lu::Lu;

/// The constant parts of a machine.
pub struct Constant<'a> {
    pub weights: &'a Alpha,
    pub train: &'a Train,
    mass: Matrix,
    stiffness: Matrix,
    damping: Matrix,
    /// Branches that are not constant.
    pub others: Vec<usize>,
    /// Those among them that are contacts.
    pub contacts: Vec<usize>,
    /// By step length.
    pub systems: Vec<System>,
}

/// `S = (1 − α_m)/(β h²) M + (1 − α_f) (γ/(β h) C + K)` with the other branches' directions solved for.
pub struct System {
    h: f64,
    lu: Lu,
    /// S⁻¹ U.
    columns: Matrix,
    /// Wᵀ S⁻¹ U.
    small: Matrix,
}

impl<'a> Constant<'a> {
    /// Of a machine.
    pub fn new(weights: &'a Alpha, train: &'a Train) -> Constant<'a> {
        let n = train.n();
        let (mut stiffness, mut damping) = (Matrix::zeros(n, n), Matrix::zeros(n, n));
        let mut others = Vec::new();
        for (at, branch) in train.branches.iter().enumerate() {
            match (&branch.law, &branch.followed[..]) {
                (
                    Law::Linear {
                        stiffness: k,
                        damping: c,
                    },
                    [],
                ) => {
                    add(&mut stiffness, branch.acts(), &branch.direction, *k);
                    add(&mut damping, branch.acts(), &branch.direction, *c);
                }
                _ => others.push(at),
            }
        }
        let is_contact = |&&b: &&usize| matches!(train.branches[b].law, Law::Contact(_));
        let contacts = others.iter().filter(is_contact).copied().collect();
        if let Some((k, c)) = &train.general {
            stiffness += k;
            damping += c;
        }
        let mass = train.mass.matrix();
        for j in 0..n {
            for i in 0..n {
                damping[(i, j)] += train.drag * mass[(i, j)];
            }
        }
        Constant {
            weights,
            train,
            mass,
            stiffness,
            damping,
            contacts,
            others,
            systems: Vec::new(),
        }
    }

    /// The number of the system of a step length.
    pub fn system(&mut self, h: f64, effort: &mut Effort) -> Result<usize, Error> {
        if let Some(at) = self.systems.iter().position(|s| s.h == h) {
            return Ok(at);
        }
        let (n, w) = (self.train.n(), self.weights);
        let inertia = (1.0 - w.inertia) / (w.beta * h * h);
        let rate = w.gamma / (w.beta * h);
        let lu = Lu::new(&Matrix::from_fn(n, n, |i, j| {
            inertia * self.mass[(i, j)]
                + (1.0 - w.force) * (rate * self.damping[(i, j)] + self.stiffness[(i, j)])
        }))?;
        effort.factorisations += 1;
        let mut forces = Matrix::zeros(n, self.others.len());
        for (j, &at) in self.others.iter().enumerate() {
            for (i, a) in self.train.branches[at].acts().scaled() {
                forces[(i, j)] = a;
            }
        }
        let columns = match self.others.is_empty() {
            true => forces,
            false => lu.solve_all(&forces),
        };
        let m = self.others.len();
        let small = Matrix::from_fn(m, m, |i, j| {
            self.train.branches[self.others[i]]
                .direction
                .dot(columns.col_as_slice(j))
        });
        if self.systems.len() == 16 {
            self.systems.remove(0);
        }
        self.systems.push(System {
            h,
            lu,
            columns,
            small,
        });
        Ok(self.systems.len() - 1)
    }

    /// `(S + U D Wᵀ)⁻¹ r`, D the slopes of the other branches' forces (Woodbury's formula), in place.
    pub fn correct(&self, system: &System, slopes: &[f64], r: &mut [f64]) -> Result<(), Error> {
        system.lu.solve(r);
        let m = slopes.len();
        if slopes.iter().all(|&d| d == 0.0) {
            return Ok(());
        }
        let direction = |i: usize| &self.train.branches[self.others[i]].direction;
        let matrix = Matrix::from_fn(m, m, |i, j| {
            f64::from(u8::from(i == j)) + slopes[i] * system.small[(i, j)]
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
