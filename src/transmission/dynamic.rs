//! Dynamic transmission with elastic joints, `T_b(ω) = cᵀ D(ω)⁻¹ w_b (k_b + iω c_b)`.
//!
//! At ω = 0 it is the static transmission: on a tree that of rigid joints, in loops shared out by stiffness.

use super::chain::TransmissionChain;
use super::order_lines::OrderLine;
use crate::base::error::Error;
use crate::machine::components::BranchLaw;
use crate::numeric::Complex;
use crate::response::frf::{ResponseMethod, ResponseSolver};
use crate::response::ports::{Port, Ports, ResponseInput, ResponseOutput};
use crate::response::system::OperatingModel;

/// From the displacement of every branch that carries an error to the end of the chain.
pub struct ErrorTransfer {
    solver: ResponseSolver,
    ports: Ports,
    branches: Vec<usize>,
    sense: f64,
}

impl ErrorTransfer {
    /// Sets up the equations for all branches that `lines` displace.
    ///
    /// # Errors
    /// A joint of a rigid loop displaced; those of the equations.
    pub fn new(
        model: &OperatingModel,
        chain: &TransmissionChain,
        lines: &[OrderLine],
        method: ResponseMethod,
    ) -> Result<ErrorTransfer, Error> {
        let mut branches: Vec<usize> = Vec::new();
        for &(branch, _) in lines.iter().flat_map(|line| &line.displacements) {
            let moves = model.machine.branches[branch].law == BranchLaw::Rigid
                || model.model.branches.iter().any(|b| b.index == branch);
            if moves && !branches.contains(&branch) {
                branches.push(branch);
            }
        }
        let input = |&branch: &usize| Port {
            name: model.machine.branch_name(branch),
            unit: "",
            kind: ResponseInput::Displacement(branch),
        };
        let ports = Ports {
            inputs: branches.iter().map(input).collect(),
            outputs: vec![Port {
                name: model.machine.dof_name(chain.ends.output),
                unit: "",
                kind: ResponseOutput::Sum(chain.combination.clone(), 0),
            }],
            fixed: chain.fixed.clone(),
        };
        Ok(ErrorTransfer {
            solver: ResponseSolver::new(model, &ports, method)?,
            ports,
            branches,
            sense: chain.output_sense(),
        })
    }

    /// The displaced branches, the end, and what is held.
    pub fn ports(&self) -> &Ports {
        &self.ports
    }

    /// A and ψ of every line at the end, rad, where all lines are at ω, rad/s.
    ///
    /// # Errors
    /// An undamped resonance.
    pub fn response_at(&self, omega: f64, lines: &[&OrderLine]) -> Result<Vec<Complex>, Error> {
        if self.branches.is_empty() {
            return Ok(vec![Complex::ZERO; lines.len()]);
        }
        let t = self.solver.response_at(omega)?;
        let of = |line: &&OrderLine| {
            let parts = line.displacements.iter().filter_map(|&(branch, e)| {
                let at = self.branches.iter().position(|&b| b == branch)?;
                Some(t[(0, at)] * e)
            });
            parts.fold(Complex::ZERO, |sum, z| sum + z) * self.sense
        };
        Ok(lines.iter().map(of).collect())
    }

    /// Every line at its own frequency, the output turning at `speed`, rad/s: equal orders are solved once.
    ///
    /// # Errors
    /// Those of [`ErrorTransfer::response_at`].
    pub fn at_speed(&self, speed: f64, lines: &[OrderLine]) -> Result<Vec<Complex>, Error> {
        let mut all = Vec::with_capacity(lines.len());
        let mut rest = lines;
        while let Some(first) = rest.first() {
            let count = rest
                .iter()
                .take_while(|line| line.order == first.order)
                .count();
            let (group, after) = rest.split_at(count);
            let group: Vec<&OrderLine> = group.iter().collect();
            all.extend(self.response_at(first.order.to_f64() * speed.abs(), &group)?);
            rest = after;
        }
        Ok(all)
    }
}

/// From the motion of the driver to the end of the chain: `G(ω) = θ_out/θ_driver`.
pub struct DriverTransfer {
    solver: ResponseSolver,
    static_gain: Complex,
}

impl DriverTransfer {
    /// Sets up the equations.
    ///
    /// # Errors
    /// Those of the equations.
    pub fn new(model: &OperatingModel, chain: &TransmissionChain) -> Result<DriverTransfer, Error> {
        let driver = chain.ends.driver;
        let ports = Ports {
            inputs: vec![Port {
                name: model.machine.dof_name(driver),
                unit: "",
                kind: ResponseInput::Motion(driver),
            }],
            outputs: vec![Port {
                name: model.machine.dof_name(chain.ends.output),
                unit: "",
                kind: ResponseOutput::Sum(chain.combination.clone(), 0),
            }],
            fixed: (chain.fixed.iter().copied())
                .filter(|&dof| dof != driver)
                .collect(),
        };
        let solver = ResponseSolver::new(model, &ports, ResponseMethod::Direct)?;
        let slow = solver.response_at(0.0)?[(0, 0)];
        Ok(DriverTransfer {
            solver,
            static_gain: slow,
        })
    }

    /// `G(ω)/G(0) − 1`: what the end turns beyond what the ratio says, of what the driver runs ahead, both in angles of the end.
    ///
    /// # Errors
    /// An undamped resonance.
    pub fn dynamic_deviation(&self, omega: f64) -> Result<Complex, Error> {
        Ok(self.solver.response_at(omega)?[(0, 0)] / self.static_gain - 1.0)
    }
}
