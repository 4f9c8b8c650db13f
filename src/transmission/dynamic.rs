//! Transmission with elastic joints: `T_b(ω) = cᵀ (K + iω(C + G) − ω²M)⁻¹ w_b (k_b + iω c_b)`, the driver's angle prescribed.
//!
//! At ω = 0 it is the static transmission: on a tree that of rigid joints, in loops shared out by stiffness.

use super::chain::Chain;
use super::lines::Line;
use crate::base::error::Error;
use crate::machine::parts::Law;
use crate::numeric::Complex;
use crate::response::frequency::{Solver, Way};
use crate::response::ports::{Input, Output, Port, Ports};
use crate::response::system::Setting;

/// From the displacement of every branch that carries an error to the end of the chain.
pub struct Transfer {
    solver: Solver,
    ports: Ports,
    branches: Vec<usize>,
    sense: f64,
}

impl Transfer {
    /// Sets up the equations for all branches that `lines` displace.
    ///
    /// # Errors
    /// A joint of a rigid loop displaced; those of the equations.
    pub fn new(
        setting: &Setting,
        chain: &Chain,
        lines: &[Line],
        way: Way,
    ) -> Result<Transfer, Error> {
        let mut branches: Vec<usize> = Vec::new();
        for &(branch, _) in lines.iter().flat_map(|line| &line.displacements) {
            let moves = setting.machine.branches[branch].law == Law::Rigid
                || setting.linear.branches.iter().any(|b| b.index == branch);
            if moves && !branches.contains(&branch) {
                branches.push(branch);
            }
        }
        let input = |&branch: &usize| Port {
            name: setting.machine.branch_name(branch),
            unit: "",
            what: Input::Displacement(branch),
        };
        let ports = Ports {
            inputs: branches.iter().map(input).collect(),
            outputs: vec![Port {
                name: setting.machine.freedom_name(chain.ends.output),
                unit: "",
                what: Output::Sum(chain.combination.clone(), 0),
            }],
            held: chain.held.clone(),
        };
        Ok(Transfer {
            solver: Solver::new(setting, &ports, way)?,
            ports,
            branches,
            sense: chain.sense(),
        })
    }

    /// The displaced branches, the end, and what is held.
    pub fn ports(&self) -> &Ports {
        &self.ports
    }

    /// A and ψ of every line at the end, rad, where all lines stand at ω, rad/s.
    ///
    /// # Errors
    /// An undamped resonance.
    pub fn at(&self, omega: f64, lines: &[&Line]) -> Result<Vec<Complex>, Error> {
        if self.branches.is_empty() {
            return Ok(vec![Complex::ZERO; lines.len()]);
        }
        let t = self.solver.at(omega)?;
        let of = |line: &&Line| {
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
    /// Those of [`Transfer::at`].
    pub fn at_speed(&self, speed: f64, lines: &[Line]) -> Result<Vec<Complex>, Error> {
        let mut all = Vec::with_capacity(lines.len());
        let mut rest = lines;
        while let Some(first) = rest.first() {
            let count = rest
                .iter()
                .take_while(|line| line.order == first.order)
                .count();
            let (group, after) = rest.split_at(count);
            let group: Vec<&Line> = group.iter().collect();
            all.extend(self.at(first.order.value() * speed.abs(), &group)?);
            rest = after;
        }
        Ok(all)
    }
}

/// From the motion of the driver to the end of the chain: `G(ω) = θ_out/θ_driver`.
pub struct Passing {
    solver: Solver,
    slow: Complex,
}

impl Passing {
    /// Sets up the equations.
    ///
    /// # Errors
    /// Those of the equations.
    pub fn new(setting: &Setting, chain: &Chain) -> Result<Passing, Error> {
        let driver = chain.ends.driver;
        let ports = Ports {
            inputs: vec![Port {
                name: setting.machine.freedom_name(driver),
                unit: "",
                what: Input::Motion(driver),
            }],
            outputs: vec![Port {
                name: setting.machine.freedom_name(chain.ends.output),
                unit: "",
                what: Output::Sum(chain.combination.clone(), 0),
            }],
            held: (chain.held.iter().copied())
                .filter(|&freedom| freedom != driver)
                .collect(),
        };
        let solver = Solver::new(setting, &ports, Way::Direct)?;
        let slow = solver.at(0.0)?[(0, 0)];
        Ok(Passing { solver, slow })
    }

    /// `G(ω)/G(0) − 1`: what the end turns beyond what the ratio says, of what the driver runs ahead, both in angles of the end.
    ///
    /// # Errors
    /// An undamped resonance.
    pub fn beyond(&self, omega: f64) -> Result<Complex, Error> {
        Ok(self.solver.at(omega)?[(0, 0)] / self.slow - 1.0)
    }
}
