//! The equations of motion of a machine, as it stands or held in one regime.

use std::f64::consts::TAU;

use super::problem::Problem;
use super::train::{Law, Mass, Regime, Train};
use super::wave::Phase;
use crate::numeric::{Matrix, definite};

/// An acceleration below this, rad/s² or m/s², is none: ahead of a wave that runs along a chain stand numbers of any smallness, and
/// processors take a hundred times as long over those without all their digits.
const NOTHING: f64 = 1e-280;

impl Train {
    /// ẏ in a regime; without one every contact stands where the state puts it, and dry friction is spread over its creep speed.
    /// Rows of what has no equation of motion hold what must be zero ([`Train::moving_states`]).
    pub fn slope_in(&self, regime: Option<&Regime>, t: f64, y: &[f64], dy: &mut [f64]) {
        let n = self.n();
        let (q, v) = (&y[..n], &y[n..2 * n]);
        let mut g = self.pushed(regime, t, y);
        let mut inner = 2 * n;
        for (at, b) in self.branches.iter().enumerate() {
            match &b.law {
                Law::Lagged { curve, lag } => {
                    let (_, rate) = b.deflection(t, q, v, self.line(regime, at, t));
                    dy[inner] = (curve.torque(rate) - y[inner]) / lag;
                    inner += 1;
                }
                Law::Maxwell { stiffness, damping } => {
                    let (_, rate) = b.deflection(t, q, v, self.line(regime, at, t));
                    dy[inner] = stiffness * (rate - y[inner] / damping);
                    inner += 1;
                }
                _ => {}
            }
        }
        if let Some(regime) = regime {
            let sticking = regime.sticking();
            let held = self.holding(regime, t, &g, v);
            for (&at, &held) in sticking.iter().zip(&held) {
                self.branches[at]
                    .direction
                    .scaled()
                    .for_each(|(i, a)| g[i] -= a * held);
            }
        }
        let forces = self.has_light().then(|| g.clone());
        self.accelerate(&mut g);
        for i in 0..n {
            dy[i] = v[i];
            dy[n + i] = g[i] - self.drag * v[i];
        }
        if let Some(forces) = forces {
            self.light_rows(regime, (t, y), &forces, dy);
        }
    }

    /// M⁻¹ g, in place; what has no inertia is not accelerated.
    pub fn accelerate(&self, g: &mut [f64]) {
        match &self.mass {
            Mass::Diagonal(mass) => g.iter_mut().zip(mass).for_each(|(x, m)| {
                let own = *x / m;
                *x = if *m == 0.0 || own.abs() < NOTHING {
                    0.0
                } else {
                    own
                };
            }),
            Mass::Full { inverse, .. } => {
                let force = g.to_vec();
                for (i, x) in g.iter_mut().enumerate() {
                    *x = force
                        .iter()
                        .enumerate()
                        .map(|(j, f)| inverse[(i, j)] * f)
                        .sum();
                }
            }
        }
    }

    /// M v.
    pub fn momentum(&self, v: &[f64]) -> Vec<f64> {
        match &self.mass {
            Mass::Diagonal(mass) => v.iter().zip(mass).map(|(x, m)| x * m).collect(),
            Mass::Full { matrix, .. } => (0..v.len())
                .map(|i| (0..v.len()).map(|j| matrix[(i, j)] * v[j]).sum())
                .collect(),
        }
    }

    /// The forces with which the sticking pairs of a regime keep to their imposed motion against `g`.
    pub fn holding(&self, regime: &Regime, t: f64, g: &[f64], v: &[f64]) -> Vec<f64> {
        let acceleration = |branch: usize| {
            let piece = self.imposed_piece(regime, branch) as usize;
            let e = self.branches[branch].imposed.as_ref();
            e.map_or(0.0, |e| e.curvature(t, piece))
        };
        self.reactions(&regime.sticking(), g, v, acceleration)
    }

    /// The forces with which sticking pairs hold the rate of change `a` against `g`: `W M⁻¹ Wᵀ λ = W M⁻¹ (g − α M v) − a`.
    pub fn reactions(
        &self,
        sticking: &[usize],
        g: &[f64],
        v: &[f64],
        a: impl Fn(usize) -> f64,
    ) -> Vec<f64> {
        if sticking.is_empty() {
            return Vec::new();
        }
        let mut free = g.to_vec();
        self.accelerate(&mut free);
        free.iter_mut()
            .zip(v)
            .for_each(|(a, v)| *a -= self.drag * v);
        let n = self.n();
        let columns: Vec<Vec<f64>> = sticking
            .iter()
            .map(|&at| {
                let mut w = vec![0.0; n];
                self.branches[at]
                    .direction
                    .scaled()
                    .for_each(|(i, a)| w[i] += a);
                self.accelerate(&mut w);
                w
            })
            .collect();
        let m = sticking.len();
        let row = |i: usize| &self.branches[sticking[i]].direction;
        let system = Matrix::from_fn(m, m, |i, j| row(i).dot(&columns[j]));
        let right: Vec<f64> = (0..m).map(|i| row(i).dot(&free) - a(sticking[i])).collect();
        // Pairs that hold the same motion share the force: the least one is taken.
        definite::solve_semidefinite(&system, &right).unwrap_or_else(|_| vec![f64::NAN; m])
    }
}

impl Problem for Train {
    fn len(&self) -> usize {
        2 * self.n() + self.inner()
    }

    fn slope(&self, t: f64, y: &[f64], dy: &mut [f64]) {
        self.slope_in(None, t, y, dy);
    }

    fn next_break(&self, t: f64) -> f64 {
        let drives = self.drives.iter().map(|d| d.signal.next_knot(t));
        let imposed = self
            .branches
            .iter()
            .filter_map(|b| b.imposed.as_ref())
            .map(|e| e.next_knot(t));
        let waves = self
            .branches
            .iter()
            .filter_map(|b| b.variation.as_ref())
            .map(|w| match w.phase {
                Phase::Imposed { omega, start } if omega != 0.0 => {
                    let next = w.shape.next_piece(w.phase.at(t, &[]));
                    let mut at = (next * TAU - start) / omega;
                    // The phase of an instant and the instant of a phase differ by rounding.
                    if at <= t {
                        at = (w.shape.next_piece(next) * TAU - start) / omega;
                    }
                    at
                }
                _ => f64::INFINITY,
            });
        let followed = self.branches.iter().flat_map(|b| {
            let waves = b.variation.iter().chain(&b.followed);
            let phases = waves.map(|w| &w.phase).chain(b.law.phase());
            phases.filter_map(|phase| match phase {
                Phase::Followed { known, .. } => known.as_ref().map(|x| x.next_knot(t)),
                Phase::Imposed { .. } => None,
            })
        });
        let grips = self.branches.iter().filter_map(|b| match &b.law {
            Law::Clutch { grip, .. } => Some(grip.next_knot(t)),
            _ => None,
        });
        let paths = self.branches.iter().filter_map(|b| match &b.law {
            Law::Pressed(pressed) => pressed.path.as_ref().map(|path| path.next_edge(t)),
            _ => None,
        });
        drives
            .chain(imposed)
            .chain(paths)
            .chain(waves)
            .chain(followed)
            .chain(grips)
            .fold(f64::INFINITY, f64::min)
    }
}

/// A machine held in one regime.
pub struct Frozen<'a> {
    /// The machine.
    pub train: &'a Train,
    /// How everything stands.
    pub regime: &'a Regime,
}

impl Problem for Frozen<'_> {
    fn len(&self) -> usize {
        self.train.len()
    }

    fn slope(&self, t: f64, y: &[f64], dy: &mut [f64]) {
        self.train.slope_in(Some(self.regime), t, y, dy);
    }
}
