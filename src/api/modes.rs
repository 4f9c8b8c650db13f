//! Natural modes `(λ² M + λ C + K) φ = 0` with the names of what moves and of what is strained.

use std::ops::Index;

use super::reduction::Reduction;
use crate::base::error::Diagnostic;
use crate::modes::campbell::{CampbellBranch, CampbellDiagram, OrderCrossing};
use crate::modes::sensitivity::{FrequencySensitivity, SensitivityParameter};
use crate::modes::state_space::StateSpace;
use crate::numeric::sorting::sort_descending;
use crate::numeric::{Complex, to_rows};
use crate::plan::modes_run::ModesResult;
use crate::plan::prepared_machine::PreparedMachine;

/// The natural modes of a machine by rising frequency.
#[derive(Debug, Clone)]
pub struct Modes {
    /// Names of the degrees of freedom, in the order of the shapes.
    pub dofs: Vec<String>,
    /// The modes.
    pub modes: Vec<Mode>,
    /// Campbell diagram, if the study requests one.
    pub campbell: Option<Campbell>,
    /// State-space form, if the study requests one.
    pub state_space: Option<StateSpaceMatrices>,
    /// Reduced machine, if the study requests one.
    pub reduction: Option<Reduction>,
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
    /// Sensitivities of the frequency, the largest first; empty for rigid-body and complex modes.
    pub sensitivities: Vec<ModalSensitivity>,
}

/// Sensitivity of a natural frequency to the stiffness or the inertia of an element.
#[derive(Debug, Clone)]
pub struct ModalSensitivity {
    /// Name of the element.
    pub element: String,
    /// Parameter that is varied.
    pub parameter: SensitivityParameter,
    /// `(x/ω) ∂ω/∂x`: per cent of the frequency per per cent of the parameter.
    pub relative: f64,
}

/// Natural frequencies over the speed of a node, and where excitation orders cross them.
#[derive(Debug, Clone)]
pub struct Campbell {
    /// Name of the node whose speed is the abscissa.
    pub reference: String,
    /// Speeds of the node, rpm.
    pub speeds_rpm: Vec<f64>,
    /// Modes tracked over the speeds.
    pub branches: Vec<CampbellBranch>,
    /// Crossings by rising speed.
    pub crossings: Vec<CampbellCrossing>,
}

/// Crossing of an excitation order with a branch of a Campbell diagram.
#[derive(Debug, Clone)]
pub struct CampbellCrossing {
    /// Speed of the reference node, rpm.
    pub speed_rpm: f64,
    /// Natural frequency at this speed, Hz.
    pub frequency_hz: f64,
    /// Order per revolution of the reference node.
    pub order: f64,
    /// Names of the elements that excite the order.
    pub sources: Vec<String>,
    /// Index into [`Campbell::branches`].
    pub branch: usize,
    /// Participation of the mode in the order, 0 to 1.
    pub participation: f64,
}

/// Matrices of `ẋ = A x + B u`, `y = C x + D u`, or of the sampled form `x⁺ = A x + B u`, row by row.
#[derive(Debug, Clone)]
pub struct StateSpaceMatrices {
    /// A, states × states.
    pub a: Vec<Vec<f64>>,
    /// B, states × inputs.
    pub b: Vec<Vec<f64>>,
    /// C, outputs × states.
    pub c: Vec<Vec<f64>>,
    /// D, outputs × inputs.
    pub d: Vec<Vec<f64>>,
    /// Names of the states, rad or m, then their rates `node.axis.speed`, rad/s or m/s.
    pub states: Vec<String>,
    /// Names of the inputs: N·m or N along a degree of freedom.
    pub inputs: Vec<String>,
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// Sample time, s; `None` for the continuous form.
    pub sample_time_s: Option<f64>,
}

impl Modes {
    pub(super) fn new(prepared: &PreparedMachine, result: ModesResult) -> Modes {
        let machine = &prepared.machine;
        let named = |shares: &[(usize, f64)]| {
            let mut shares: Vec<(String, f64)> = shares
                .iter()
                .map(|(element, share)| (machine.elements[*element].name.clone(), *share))
                .collect();
            sort_descending(&mut shares, |a| a.1.abs());
            shares
        };
        let sensitivity = |s: &FrequencySensitivity| ModalSensitivity {
            element: machine.elements[s.element].name.clone(),
            parameter: s.parameter,
            relative: s.relative,
        };
        let sensitivities_of = |mode: usize| {
            let all = result.sensitivities.as_ref();
            all.map_or(Vec::new(), |all| {
                all[mode].iter().map(sensitivity).collect()
            })
        };
        let with_energies = result.modes.into_iter().zip(&result.energies).enumerate();
        let modes = with_energies.map(|(index, (mode, energies))| Mode {
            sensitivities: sensitivities_of(index),
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
            campbell: result.campbell.map(Campbell::new),
            state_space: (result.state_space).map(|(system, _)| StateSpaceMatrices::new(system)),
            reduction: (result.reduction)
                .map(|reduction| Reduction::new(&prepared.model, reduction)),
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

impl Campbell {
    fn new(diagram: CampbellDiagram) -> Campbell {
        let crossing = |c: &OrderCrossing| {
            let order = &diagram.orders[c.order];
            CampbellCrossing {
                speed_rpm: c.speed_rpm,
                frequency_hz: c.frequency_hz,
                order: order.value,
                sources: order.sources.iter().map(|s| s.element.clone()).collect(),
                branch: c.branch,
                participation: c.participation,
            }
        };
        Campbell {
            crossings: diagram.crossings.iter().map(crossing).collect(),
            reference: diagram.reference,
            speeds_rpm: diagram.speeds_rpm,
            branches: diagram.branches,
        }
    }
}

impl StateSpaceMatrices {
    fn new(system: StateSpace) -> StateSpaceMatrices {
        StateSpaceMatrices {
            a: to_rows(&system.a),
            b: to_rows(&system.b),
            c: to_rows(&system.c),
            d: to_rows(&system.d),
            states: system.states,
            inputs: system.inputs,
            outputs: system.outputs,
            sample_time_s: system.sample_time,
        }
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
