//! Coordinates without inertia that stay: `0 = g(t, q, v)` in place of `m v̇ = g`.
//!
//! Where a damper acts on one, its row is solved for the rate: `q̇ = v`, `0 = g`. Else for the place, and for the rate by what that asks:
//! `0 = g`, `0 = ġ`. Both are of index one (Hairer and Wanner, Solving Ordinary Differential Equations II, 2nd edition 1996, VI.1).

use super::train::{Branch, Law, Mass, Regime, Train};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::{Matrix, definite};

/// Rounds of Newton's iteration: it starts near and converges in a few.
const ROUNDS: usize = 50;

/// Changes of this size, relative to the largest of their kind, are rounding.
const STAYS: f64 = 1e-14;

/// Looks at how everything stands while places are found.
const LOOKS: usize = 20;

/// A coordinate without inertia.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Light {
    /// Which.
    pub coordinate: usize,
    /// A damper that never lets go acts on it.
    pub damped: bool,
}

/// Why a method that divides by inertia cannot take a machine; absent where it can.
pub fn refused(train: &Train) -> Option<String> {
    let light = train.light();
    let first = light.first()?;
    Some(format!(
        "{} has no inertia, and what acts there is not linear",
        train.coordinates[first.coordinate]
    ))
}

/// What may act on a coordinate without inertia that stays.
pub fn may_stay(b: &Branch) -> bool {
    let law = match &b.law {
        Law::Linear { .. } | Law::Nonlinear { .. } => true,
        Law::Contact(contact) => !contact.opens() || contact.damping == 0.0,
        _ => false,
    };
    law && b.force.is_none() && b.variation.is_none() && b.followed.is_empty()
}

impl Train {
    /// Some coordinate has no inertia.
    pub fn has_light(&self) -> bool {
        match &self.mass {
            Mass::Diagonal(mass) => mass.contains(&0.0),
            Mass::Full { matrix, .. } => (0..self.n()).any(|i| matrix[(i, i)] == 0.0),
        }
    }

    /// Coordinates without inertia.
    pub fn light(&self) -> Vec<Light> {
        let is_light = |i: &usize| match &self.mass {
            Mass::Diagonal(mass) => mass[*i] == 0.0,
            Mass::Full { matrix, .. } => matrix[(*i, *i)] == 0.0,
        };
        let damps = |b: &Branch| match &b.law {
            Law::Linear { damping, .. } | Law::Nonlinear { damping, .. } => *damping > 0.0,
            Law::Contact(contact) => contact.damping > 0.0,
            _ => false,
        };
        let light = |coordinate: usize| Light {
            coordinate,
            damped: self.branches.iter().any(|b| {
                damps(b) && b.direction.terms.iter().any(|t| t.0 == coordinate)
            }),
        };
        (0..self.n()).filter(is_light).map(light).collect()
    }

    /// States without an equation of motion; the rows in their places hold what must be zero.
    pub fn algebraic(&self) -> Vec<usize> {
        let n = self.n();
        let states = |l: Light| {
            let place = (!l.damped).then_some(l.coordinate);
            place.into_iter().chain([n + l.coordinate])
        };
        self.light().into_iter().flat_map(states).collect()
    }

    /// The rows of coordinates without inertia; `g` are the forces on all coordinates.
    pub fn light_rows(
        &self,
        regime: Option<&Regime>,
        (t, y): (f64, &[f64]),
        g: &[f64],
        dy: &mut [f64],
    ) {
        let n = self.n();
        for Light { coordinate, damped } in self.light() {
            if damped {
                dy[n + coordinate] = g[coordinate];
                continue;
            }
            let own = |d: &crate::machine::direction::Direction| -> f64 {
                d.scaled().filter(|x| x.0 == coordinate).map(|x| x.1).sum()
            };
            let mut rate = 0.0;
            for drive in &self.drives {
                let signal = &drive.signal;
                rate += own(&drive.direction) * signal.slope(t, signal.piece(t));
            }
            for (at, b) in self.branches.iter().enumerate() {
                let along = own(&b.direction);
                if along != 0.0 {
                    let piece = b.imposed.as_ref().map_or(0, |e| e.piece(t) as u32);
                    let deflects = b.deflection(t, &y[..n], &y[n..2 * n], piece).1;
                    rate -= along * self.force(at, regime, t, y, 0.0).1 * deflects;
                }
            }
            dy[coordinate] = g[coordinate];
            dy[n + coordinate] = rate;
        }
    }

    /// The state with its coordinates without inertia where they must be, the others as they are.
    ///
    /// # Errors
    /// `NoConvergence` where nothing holds such a coordinate.
    pub fn consistent(&self, regime: &Regime, t: f64, y: &[f64]) -> Result<Vec<f64>, Error> {
        let (n, rows) = (self.n(), self.algebraic());
        let m = rows.len();
        let mut y = y.to_vec();
        let residual = |y: &[f64]| -> Vec<f64> {
            let mut dy = vec![0.0; y.len()];
            self.slope_in(Some(regime), t, y, &mut dy);
            rows.iter().map(|&r| dy[r]).collect()
        };
        for _ in 0..ROUNDS {
            let largest = |from: usize| {
                let part = y[from..from + n].iter();
                part.fold(1e-9, |m: f64, x| m.max(x.abs()))
            };
            let sizes = [largest(0), largest(n)];
            let size = |row: usize| sizes[usize::from(row >= n)];
            let now = residual(&y);
            let mut slopes = Matrix::zeros(m, m);
            for (j, &row) in rows.iter().enumerate() {
                let mut moved = y.clone();
                moved[row] += f64::EPSILON.sqrt() * size(row);
                let step = moved[row] - y[row];
                for (i, value) in residual(&moved).into_iter().enumerate() {
                    slopes[(i, j)] = (value - now[i]) / step;
                }
            }
            let right = Matrix::from_fn(m, 1, |i, _| now[i]);
            let change = definite::solve(&slopes, &right).map_err(|_| self.floats(t))?;
            let mut still = true;
            for (j, &row) in rows.iter().enumerate() {
                y[row] -= change[(j, 0)];
                still &= change[(j, 0)].abs() <= STAYS * size(row);
            }
            if still {
                return Ok(y);
            }
        }
        Ok(y)
    }

    /// The same where nothing says how contacts stand.
    ///
    /// # Errors
    /// As [`Train::consistent`].
    pub fn settled(&self, t: f64, y: &[f64]) -> Result<Vec<f64>, Error> {
        let mut y = y.to_vec();
        for _ in 0..LOOKS {
            let regime = self.regime(t, &y);
            y = self.consistent(&regime, t, &y)?;
            if self.regime(t, &y) == regime {
                break;
            }
        }
        Ok(y)
    }

    fn floats(&self, t: f64) -> Error {
        let names: Vec<&str> = self.light().iter().map(|l| &self.coordinates[l.coordinate][..]).collect();
        Error::new(
            Code::NoConvergence,
            format!("nothing says at t = {t:?} s where {} is, which has no inertia", names.join(", ")),
        )
        .hint("give the node its inertia, or a spring that holds it")
    }
}
