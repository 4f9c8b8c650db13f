//! Sensitivity of frequencies: `∂λ/∂k_b = (wᵀφ)²`, `∂λ/∂J_i = −λ φ_i²`, λ = ω².
//!
//! For a repeated frequency the derivative depends on where the change pulls: its values are the eigenvalues of
//! `Φᵀ (∂K − λ ∂M) Φ` over the whole set (Friswell 1996, J. Vib. Acoust. 118, 390, eq. (6)).

use super::mode::Mode;
use crate::base::error::Error;
use crate::machine::components::Machine;
use crate::machine::linear::LinearModel;
use crate::numeric::{Matrix, symmetric};

/// Element parameter that is varied.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SensitivityParameter {
    /// All its stiffnesses, by one factor.
    Stiffness,
    /// All its inertias, by one factor.
    Inertia,
}

/// The sensitivity of one mode to one element.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrequencySensitivity {
    /// The element.
    pub element: usize,
    /// Parameter that is varied.
    pub parameter: SensitivityParameter,
    /// `(x/ω) ∂ω/∂x`: per cent of frequency per per cent of the parameter.
    pub relative: f64,
    /// `∂ω/∂x`, rad/s per unit of the parameter, where the element has one value of it.
    pub absolute: Option<f64>,
}

/// Modes whose frequencies differ by less than this, relative, are one repeated frequency: 100 × what the dense solvers leave.
const SAME_FREQUENCY: f64 = 1e-9;

/// Sensitivities of every mode, each list by falling influence. Only for real modes; rigid ones have none.
///
/// # Errors
/// No convergence of the small eigenproblems of repeated frequencies.
pub fn sensitivities(
    machine: &Machine,
    model: &LinearModel,
    modes: &[Mode],
) -> Result<Vec<Vec<FrequencySensitivity>>, Error> {
    let mut all = vec![Vec::new(); modes.len()];
    let mut at = 0;
    while at < modes.len() {
        let omega = modes[at].omega();
        let mut end = at + 1;
        while end < modes.len() && (modes[end].omega() - omega).abs() <= SAME_FREQUENCY * omega {
            end += 1;
        }
        if !modes[at].rigid {
            let shapes: Vec<Vec<f64>> = modes[at..end]
                .iter()
                .map(|m| {
                    model
                        .select_independent(&m.shape)
                        .iter()
                        .map(|z| z.re)
                        .collect()
                })
                .collect();
            for (k, list) in repeated_frequency_set(machine, model, omega, &shapes)?
                .into_iter()
                .enumerate()
            {
                all[at + k] = list;
            }
        }
        at = end;
    }
    Ok(all)
}

/// Sensitivities of the modes of one frequency.
fn repeated_frequency_set(
    machine: &Machine,
    model: &LinearModel,
    omega: f64,
    shapes: &[Vec<f64>],
) -> Result<Vec<Vec<FrequencySensitivity>>, Error> {
    let m = shapes.len();
    let lambda = omega * omega;
    let mut terms = Terms {
        list: Vec::new(),
        by_element: vec![[None; 2]; machine.elements.len()],
        m,
    };
    for branch in model
        .branches
        .iter()
        .filter(|b| b.stiffness != 0.0 && b.force.is_none())
    {
        let seen: Vec<f64> = shapes.iter().map(|p| branch.direction.dot(p)).collect();
        let element = machine.branches[branch.index].element;
        terms
            .entry(element, SensitivityParameter::Stiffness)
            .add(branch.stiffness, 1.0, &seen);
    }
    for mass in &model.masses {
        let seen: Vec<f64> = shapes.iter().map(|p| mass.direction.dot(p)).collect();
        terms
            .entry(mass.element, SensitivityParameter::Inertia)
            .add(mass.value, -lambda, &seen);
    }
    let mut lists = vec![Vec::new(); m];
    for term in &terms.list {
        let values = symmetric::symmetric_eigen(&term.matrix)?.values;
        for (list, &change) in lists.iter_mut().zip(&values) {
            // ∂ω = ∂λ / 2ω, per relative change of the parameter.
            let relative = change / (2.0 * lambda);
            let absolute = term.value.map(|value| relative * omega / value);
            list.push(FrequencySensitivity {
                element: term.element,
                parameter: term.parameter,
                relative,
                absolute,
            });
        }
    }
    for list in &mut lists {
        list.sort_by(|a: &FrequencySensitivity, b| b.relative.abs().total_cmp(&a.relative.abs()));
    }
    Ok(lists)
}

/// `x Φᵀ (∂K/∂x − λ ∂M/∂x) Φ` of one element.
struct SensitivityTerm {
    element: usize,
    parameter: SensitivityParameter,
    matrix: Matrix,
    /// The one value its terms share.
    value: Option<f64>,
    any: bool,
}

/// Terms, found by element and parameter.
struct Terms {
    list: Vec<SensitivityTerm>,
    by_element: Vec<[Option<usize>; 2]>,
    m: usize,
}

impl Terms {
    fn entry(&mut self, element: usize, parameter: SensitivityParameter) -> &mut SensitivityTerm {
        let slot = &mut self.by_element[element][parameter as usize];
        let at = *slot.get_or_insert_with(|| {
            self.list.push(SensitivityTerm {
                element,
                parameter,
                matrix: Matrix::zeros(self.m, self.m),
                value: None,
                any: false,
            });
            self.list.len() - 1
        });
        &mut self.list[at]
    }
}

impl SensitivityTerm {
    fn add(&mut self, value: f64, factor: f64, seen: &[f64]) {
        self.value = if !self.any || self.value == Some(value) {
            Some(value)
        } else {
            None
        };
        self.any = true;
        for i in 0..seen.len() {
            for j in 0..seen.len() {
                self.matrix[(i, j)] += factor * value * seen[i] * seen[j];
            }
        }
    }
}
