//! Assembly of the linear part: M, C, K with linear substitutes of nonlinear elements.

use super::family::SpeedFamily;
use super::linear_part::{
    FirstOrderElement, FirstOrderLaw, HarmonicForce, LinearPart, NonlinearElement, ZERO,
};
use crate::machine::direction::Direction;
use crate::motion::curve::TorqueSpeedCurve;
use crate::motion::dynamic_model::{DynamicModel, ForceElement, ForceLaw};
use crate::motion::signal::Signal;
use crate::numeric::{Complex, Matrix};

/// Damping ratio of the linear law that replaces an undamped contact, so that it has no resonance.
const SUBSTITUTE_DAMPING: f64 = 0.05;

impl LinearPart {
    /// Linear part of a family.
    pub fn new(family: &SpeedFamily) -> LinearPart {
        let model = &family.relative.model;
        let n = model.coordinate_count();
        let dense = |b: &Direction| {
            let mut row = vec![0.0; n];
            b.entries().for_each(|(i, a)| row[i] += a);
            row
        };
        let active: Vec<NonlinearElement> = (0..model.elements.len())
            .filter_map(|branch| linear_substitute(model, branch))
            .collect();
        let (mut damping, mut stiffness) = match &model.global_matrices {
            Some((k, c)) => (c.clone(), k.clone()),
            None => (Matrix::zeros(n, n), Matrix::zeros(n, n)),
        };
        let mass = model.mass.matrix();
        let mut late = Vec::new();
        let mut terms: Vec<HarmonicForce> = Vec::new();
        let mut errors = vec![Vec::new(); active.len()];
        for drive in &model.forces {
            let column = dense(&drive.direction);
            for (order, value) in fourier_coefficients(&drive.signal, family.base) {
                terms.push(HarmonicForce {
                    order,
                    column: column.clone(),
                    constant: value,
                    rate: ZERO,
                });
            }
        }
        for (at, b) in model.elements.iter().enumerate() {
            let (acts, sees) = (dense(b.force_direction()), dense(&b.direction));
            let own = active.iter().position(|a| a.branch == at);
            let (k, c, steady) = match (&b.law, own) {
                (_, Some(own)) => (active[own].stiffness, active[own].damping, 0.0),
                (ForceLaw::Linear { stiffness, damping }, None) => (*stiffness, *damping, 0.0),
                (ForceLaw::Contact(contact), None) => (contact.stiffness, contact.damping, 0.0),
                (ForceLaw::TorqueSpeed(curve), None) => {
                    let rate = family.rates[at];
                    (0.0, -curve.slope(rate), -curve.torque(rate))
                }
                (ForceLaw::Maxwell { stiffness, damping }, None) => {
                    let kind = FirstOrderLaw::Maxwell {
                        stiffness: *stiffness,
                        damping: *damping,
                    };
                    late.push(FirstOrderElement {
                        force_columns: acts.clone(),
                        input_columns: sees.clone(),
                        kind,
                    });
                    (0.0, 0.0, damping * family.rates[at])
                }
                (ForceLaw::LaggedTorque { curve, lag }, None) => {
                    let rate = family.rates[at];
                    let kind = FirstOrderLaw::Lagged {
                        slope: curve.slope(rate),
                        lag: *lag,
                    };
                    late.push(FirstOrderElement {
                        force_columns: acts.clone(),
                        input_columns: sees.clone(),
                        kind,
                    });
                    (0.0, 0.0, -curve.torque(rate))
                }
                // What is no known force of one frequency is active or was refused.
                (
                    ForceLaw::Friction(_)
                    | ForceLaw::Nonlinear { .. }
                    | ForceLaw::Clutch { .. }
                    | ForceLaw::LoadFriction(_)
                    | ForceLaw::AngleLocked { .. },
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
                terms.push(HarmonicForce {
                    order: 0,
                    column: acts.clone(),
                    constant: Complex::new(-steady, 0.0),
                    rate: ZERO,
                });
            }
            if own.is_none() && family.rates[at] != 0.0 && matches!(b.law, ForceLaw::Linear { .. })
            {
                let rate = Complex::new(-c * family.rates[at] / family.base, 0.0);
                terms.push(HarmonicForce {
                    order: 0,
                    column: acts.clone(),
                    constant: ZERO,
                    rate,
                });
            }
            if let Some(e) = &b.imposed_displacement {
                let lines = fourier_coefficients(e, family.base);
                for &(order, value) in &lines {
                    let rate = if order == 0 { ZERO } else { value * c };
                    terms.push(HarmonicForce {
                        order,
                        column: acts.clone(),
                        constant: value * k,
                        rate,
                    });
                }
                if let Some(own) = own {
                    errors[own] = lines;
                }
            }
        }
        for i in 0..n {
            for j in 0..n {
                damping[(i, j)] += model.mass_damping * mass[(i, j)];
            }
        }
        let directions = |of: fn(&ForceElement) -> &Direction| {
            active
                .iter()
                .map(|a| dense(of(&model.elements[a.branch])))
                .collect()
        };
        LinearPart {
            input_columns: directions(|b| &b.direction),
            force_columns: directions(|b| b.force_direction()),
            active,
            mass,
            damping,
            stiffness,
            first_order: late,
            free: family.relative.free.clone(),
            terms,
            errors,
        }
    }
}

/// The straight law in the place of a branch that is not linear; `None` for those that are.
fn linear_substitute(model: &DynamicModel, branch: usize) -> Option<NonlinearElement> {
    let b = &model.elements[branch];
    if b.force_direction().terms.is_empty() {
        return None; // Between what is prescribed.
    }
    let (stiffness, damping) = match &b.law {
        ForceLaw::Contact(contact) if contact.can_open() || b.stiffness_wave.is_some() => {
            let mean = b.stiffness_wave.as_ref().map_or(1.0, |w| w.waveform.mean());
            let k = contact.stiffness * mean;
            let mut push = vec![0.0; model.coordinate_count()];
            b.force_direction()
                .entries()
                .for_each(|(i, a)| push[i] += a);
            model.apply_inverse_mass(&mut push);
            let mass = b.direction.dot(&push).abs().recip();
            (
                k,
                contact
                    .damping
                    .max(2.0 * SUBSTITUTE_DAMPING * (k * mass).sqrt()),
            )
        }
        ForceLaw::Friction(_) => (0.0, 0.0),
        ForceLaw::Nonlinear {
            characteristic,
            damping,
        } => {
            let load: f64 = model
                .forces
                .iter()
                .map(|d| d.signal.value(0.0, d.signal.knots.len()).abs())
                .sum();
            // Where nothing loads it a power has no tangent.
            let stiffness = match load {
                0.0 => characteristic.rated_secant(),
                load => characteristic.secant(load),
            };
            (stiffness, *damping)
        }
        ForceLaw::TorqueSpeed(curve) | ForceLaw::LaggedTorque { curve, .. }
            if !matches!(curve, TorqueSpeedCurve::Linear { .. }) =>
        {
            match &b.law {
                ForceLaw::TorqueSpeed(_) => (0.0, 0.0),
                _ => return None,
            }
        }
        _ => return None,
    };
    Some(NonlinearElement {
        branch,
        stiffness,
        damping,
    })
}

/// `x(t) = c_0 + 2 Re Σ c_k e^{ikωt}`.
fn fourier_coefficients(signal: &Signal, base: f64) -> Vec<(usize, Complex)> {
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
