//! Strain energy of the elements of a machine under harmonic inputs.

use super::direct::DirectSolver;
use super::ports::{Port, Ports, ResponseOutput};
use super::system::OperatingModel;
use crate::base::error::Error;
use crate::numeric::Complex;

/// Twice the strain energy of every element, J.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementEnergies(Vec<f64>);

impl ElementEnergies {
    /// The sum over all elements, J.
    pub fn total(&self) -> f64 {
        self.0.iter().sum()
    }

    /// The element with most of the strain energy, and its share; absent where nothing is strained.
    pub fn largest_share(&self) -> Option<(usize, f64)> {
        let total = self.total();
        let largest = (0..self.0.len()).max_by(|&a, &b| self.0[a].total_cmp(&self.0[b]));
        let element = largest.filter(|_| total > 0.0)?;
        Some((element, self.0[element] / total))
    }
}

/// Strain of every spring by each input.
pub struct StrainEnergy<'a> {
    direct: DirectSolver,
    /// Element and stiffness of every output.
    springs: Vec<(usize, f64)>,
    model: OperatingModel<'a>,
}

impl<'a> StrainEnergy<'a> {
    /// For the inputs of `ports`.
    ///
    /// # Errors
    /// Those of [`DirectSolver::new`].
    pub fn new(model: &OperatingModel<'a>, ports: &Ports) -> Result<StrainEnergy<'a>, Error> {
        let all = model.model.branches.iter();
        let springs: Vec<_> = all.filter(|b| b.stiffness > 0.0).collect();
        let outputs = springs.iter().map(|b| Port {
            name: model.machine.branch_name(b.index),
            unit: "",
            kind: ResponseOutput::Deflection(b.index),
        });
        let ports = Ports {
            outputs: outputs.collect(),
            ..ports.clone()
        };
        let element = |branch: usize| model.machine.branches[branch].element;
        let of_element = springs.iter().map(|b| (element(b.index), b.stiffness));
        Ok(StrainEnergy {
            direct: DirectSolver::new(model, &ports)?,
            springs: of_element.collect(),
            model: *model,
        })
    }

    /// Energies at ω, rad/s, under inputs of these amplitudes.
    ///
    /// # Errors
    /// Those of the solution at ω.
    pub fn energies(
        &self,
        omega: f64,
        inputs: &[(usize, Complex)],
    ) -> Result<ElementEnergies, Error> {
        let deflections = self.direct.response_at(omega)?;
        let mut energies = vec![0.0; self.model.machine.elements.len()];
        for (row, &(element, stiffness)) in self.springs.iter().enumerate() {
            let each = inputs.iter().map(|&(i, size)| deflections[(row, i)] * size);
            energies[element] += stiffness * each.sum::<Complex>().norm_sqr();
        }
        Ok(ElementEnergies(energies))
    }
}
