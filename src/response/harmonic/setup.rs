//! The linear part of a machine, put together: M, C and K with a straight law in the place of every branch that is not linear,
//! and what drives, order by order.

use super::family::Family;
use super::lines::{Active, Late, LateKind, Lines, Term, ZERO};
use crate::machine::direction::Direction;
use crate::motion::curve::Curve;
use crate::motion::signal::Signal;
use crate::motion::train::{Branch, Law, Train};
use crate::numeric::{Complex, Matrix};

/// Of critical: what the straight law in the place of an undamped contact is damped by, so that it has no resonance.
const STRAIGHT: f64 = 0.05;

impl Lines {
    /// Of a family.
    pub fn new(family: &Family) -> Lines {
        let train = &family.relative.train;
        let n = train.n();
        let dense = |b: &Direction| {
            let mut row = vec![0.0; n];
            b.scaled().for_each(|(i, a)| row[i] += a);
            row
        };
        let active: Vec<Active> = (0..train.branches.len())
            .filter_map(|branch| straight(train, branch))
            .collect();
        let (mut damping, mut stiffness) = match &train.general {
            Some((k, c)) => (c.clone(), k.clone()),
            None => (Matrix::zeros(n, n), Matrix::zeros(n, n)),
        };
        let mass = train.mass.matrix();
        let mut late = Vec::new();
        let mut terms: Vec<Term> = Vec::new();
        let mut errors = vec![Vec::new(); active.len()];
        for drive in &train.drives {
            let column = dense(&drive.direction);
            for (order, value) in spectrum(&drive.signal, family.base) {
                terms.push(Term {
                    order,
                    column: column.clone(),
                    plain: value,
                    by_rate: ZERO,
                });
            }
        }
        for (at, b) in train.branches.iter().enumerate() {
            let (acts, sees) = (dense(b.acts()), dense(&b.direction));
            let own = active.iter().position(|a| a.branch == at);
            let (k, c, steady) = match (&b.law, own) {
                (_, Some(own)) => (active[own].stiffness, active[own].damping, 0.0),
                (Law::Linear { stiffness, damping }, None) => (*stiffness, *damping, 0.0),
                (Law::Contact(contact), None) => (contact.stiffness, contact.damping, 0.0),
                (Law::Curve(curve), None) => {
                    let rate = family.rates[at];
                    (0.0, -curve.slope(rate), -curve.torque(rate))
                }
                (Law::Maxwell { stiffness, damping }, None) => {
                    let kind = LateKind::Maxwell {
                        stiffness: *stiffness,
                        damping: *damping,
                    };
                    late.push(Late {
                        acts: acts.clone(),
                        sees: sees.clone(),
                        kind,
                    });
                    (0.0, 0.0, damping * family.rates[at])
                }
                (Law::Lagged { curve, lag }, None) => {
                    let rate = family.rates[at];
                    let kind = LateKind::Lagged {
                        slope: curve.slope(rate),
                        lag: *lag,
                    };
                    late.push(Late {
                        acts: acts.clone(),
                        sees: sees.clone(),
                        kind,
                    });
                    (0.0, 0.0, -curve.torque(rate))
                }
                // What is no known force of one frequency is active or was refused.
                (
                    Law::Friction(_)
                    | Law::Nonlinear { .. }
                    | Law::Clutch { .. }
                    | Law::Pressed(_)
                    | Law::Orders { .. },
                    None,
                ) => (0.0, 0.0, 0.0),
            };
            for (i, u) in acts.iter().enumerate() {
                for (j, w) in sees.iter().enumerate() {
                    stiffness[(i, j)] += k * u * w;
                    damping[(i, j)] += c * u * w;
                }
            }
            if steady != 0.0 {
                terms.push(Term {
                    order: 0,
                    column: acts.clone(),
                    plain: Complex::new(-steady, 0.0),
                    by_rate: ZERO,
                });
            }
            if own.is_none() && family.rates[at] != 0.0 && matches!(b.law, Law::Linear { .. }) {
                let by_rate = Complex::new(-c * family.rates[at] / family.base, 0.0);
                terms.push(Term {
                    order: 0,
                    column: acts.clone(),
                    plain: ZERO,
                    by_rate,
                });
            }
            if let Some(e) = &b.imposed {
                let lines = spectrum(e, family.base);
                for &(order, value) in &lines {
                    let by_rate = if order == 0 { ZERO } else { value * c };
                    terms.push(Term {
                        order,
                        column: acts.clone(),
                        plain: value * k,
                        by_rate,
                    });
                }
                if let Some(own) = own {
                    errors[own] = lines;
                }
            }
        }
        for i in 0..n {
            for j in 0..n {
                damping[(i, j)] += train.drag * mass[(i, j)];
            }
        }
        let directions = |of: fn(&Branch) -> &Direction| {
            active
                .iter()
                .map(|a| dense(of(&train.branches[a.branch])))
                .collect()
        };
        Lines {
            sees: directions(|b| &b.direction),
            acts: directions(|b| b.acts()),
            active,
            mass,
            damping,
            stiffness,
            late,
            free: family.relative.free.clone(),
            terms,
            errors,
        }
    }
}

/// The straight law in the place of a branch that is not linear; `None` for those that are.
fn straight(train: &Train, branch: usize) -> Option<Active> {
    let b = &train.branches[branch];
    if b.acts().terms.is_empty() {
        return None; // Between what is prescribed.
    }
    let (stiffness, damping) = match &b.law {
        Law::Contact(contact) if contact.opens() || b.variation.is_some() => {
            let mean = b.variation.as_ref().map_or(1.0, |w| w.shape.mean());
            let k = contact.stiffness * mean;
            let mut push = vec![0.0; train.n()];
            b.acts().scaled().for_each(|(i, a)| push[i] += a);
            train.accelerate(&mut push);
            let mass = b.direction.dot(&push).abs().recip();
            (k, contact.damping.max(2.0 * STRAIGHT * (k * mass).sqrt()))
        }
        Law::Friction(_) => (0.0, 0.0),
        Law::Nonlinear {
            characteristic,
            damping,
        } => {
            let load: f64 = train
                .drives
                .iter()
                .map(|d| d.signal.value(0.0, d.signal.knots.len()).abs())
                .sum();
            // Where nothing loads it a power has no tangent.
            let stiffness = match load {
                0.0 => characteristic.rated(),
                load => characteristic.secant(load),
            };
            (stiffness, *damping)
        }
        Law::Curve(curve) | Law::Lagged { curve, .. }
            if !matches!(curve, Curve::Straight { .. }) =>
        {
            match &b.law {
                Law::Curve(_) => (0.0, 0.0),
                _ => return None,
            }
        }
        _ => return None,
    };
    Some(Active {
        branch,
        stiffness,
        damping,
    })
}

/// `x(t) = c_0 + 2 Re Σ c_k e^{ikωt}`.
fn spectrum(signal: &Signal, base: f64) -> Vec<(usize, Complex)> {
    let constant = signal.value(0.0, signal.knots.len())
        - signal
            .harmonics
            .iter()
            .map(|h| h.amplitude * h.phase.cos())
            .sum::<f64>();
    let mut lines = vec![(0, Complex::new(constant, 0.0))];
    for h in &signal.harmonics {
        let order = (h.omega.abs() / base).round() as usize;
        let phase = if h.omega < 0.0 { -h.phase } else { h.phase };
        let value = Complex::new(phase.cos(), phase.sin()) * h.amplitude;
        match order {
            0 => lines[0].1 += value.re,
            _ => lines.push((order, value * 0.5)),
        }
    }
    lines.retain(|l| l.1 != ZERO);
    lines
}
