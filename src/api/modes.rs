//! Natural modes `(λ² M + λ C + K) φ = 0` with the names of what moves and of what is strained.

use std::ops::Index;

use crate::base::error::Diagnostic;
use crate::machine::components;
use crate::numeric::Complex;
use crate::numeric::sorting::sort_falling;
use crate::plan::modes_run::ModesResult;

/// The natural modes of a machine by rising frequency.
#[derive(Debug, Clone)]
pub struct Modes {
    /// Names of the degrees of freedom, in the order of the shapes.
    pub dofs: Vec<String>,
    /// The modes.
    pub modes: Vec<Mode>,
    /// Warnings about the machine and the solution.
    pub diagnostics: Vec<Diagnostic>,
}

/// One natural mode.
#[derive(Debug, Clone)]
pub struct Mode {
    /// Natural frequency `|λ|/2π`, Hz; zero for a rigid-body mode.
    pub frequency_hz: f64,
    /// Damping ratio ζ; `None` without damping, or where the root does not oscillate.
    pub damping_ratio: Option<f64>,
    /// Eigenvalue λ, rad/s.
    pub eigenvalue: Complex,
    /// The mode strains nothing.
    pub is_rigid: bool,
    /// Shape over [`Modes::dofs`]: mass-normalised where real, `φᵀ(2λM + C)φ = 1` where complex.
    pub shape: Vec<Complex>,
    /// Decimal digits of λ that can be trusted; infinite for the exact zeros.
    pub digits: f64,
    /// Shares of the kinetic energy by element, the largest first.
    pub kinetic_energy: Vec<(String, f64)>,
    /// Shares of the strain energy by element, the largest first; empty for a rigid-body mode.
    pub strain_energy: Vec<(String, f64)>,
}

impl Modes {
    pub(super) fn new(machine: &components::Machine, result: ModesResult) -> Modes {
        let named = |shares: &[(usize, f64)]| {
            let mut shares: Vec<(String, f64)> = shares
                .iter()
                .map(|(element, share)| (machine.elements[*element].name.clone(), *share))
                .collect();
            sort_falling(&mut shares, |a| a.1.abs());
            shares
        };
        let with_energies = result.modes.into_iter().zip(&result.energies);
        let modes = with_energies.map(|(mode, energies)| Mode {
            frequency_hz: mode.frequency_hz(),
            damping_ratio: mode.damping_ratio,
            eigenvalue: mode.eigenvalue,
            is_rigid: mode.rigid,
            digits: mode.trusted_digits,
            kinetic_energy: named(&energies.kinetic),
            strain_energy: energies.strain.as_deref().map_or(Vec::new(), named),
            shape: mode.shape,
        });
        Modes {
            dofs: machine.dof_names(),
            modes: modes.collect(),
            diagnostics: result.diagnostics,
        }
    }

    /// Number of modes.
    pub fn len(&self) -> usize {
        self.modes.len()
    }

    /// Whether there is no mode.
    pub fn is_empty(&self) -> bool {
        self.modes.is_empty()
    }

    /// The modes by rising frequency.
    pub fn iter(&self) -> std::slice::Iter<'_, Mode> {
        self.modes.iter()
    }

    /// Component of a mode at a degree of freedom, `node.axis`; `None` where there is no such mode or name.
    pub fn component(&self, mode: usize, dof: &str) -> Option<Complex> {
        let at = self.dofs.iter().position(|name| name == dof)?;
        self.modes.get(mode).map(|mode| mode.shape[at])
    }
}

impl Mode {
    /// Damped natural frequency `Im λ/2π`, Hz.
    pub fn damped_frequency_hz(&self) -> f64 {
        self.eigenvalue.im / std::f64::consts::TAU
    }

    /// The element with the largest share of the strain energy.
    pub fn dominant_element(&self) -> Option<&str> {
        self.strain_energy.first().map(|(name, _)| name.as_str())
    }
}

/// Mode number `index`, from 0.
impl Index<usize> for Modes {
    type Output = Mode;

    fn index(&self, index: usize) -> &Mode {
        &self.modes[index]
    }
}

impl<'a> IntoIterator for &'a Modes {
    type Item = &'a Mode;
    type IntoIter = std::slice::Iter<'a, Mode>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}
