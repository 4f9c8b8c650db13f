//! State-space system `ẋ = A x + B u`, `y = C x + D u`; with a sample time `x⁺ = A x + B u`.

use super::first_order::{FirstOrder, first_order};
use super::signals::{self, OutputSignal};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::modes::system_matrices::{AnalysisContext, SystemMatrices, reference_dofs};
use crate::numeric::{Complex, ComplexMatrix, Matrix, symmetric};
use crate::scene::study::InputHold;

/// State-space system with named states, inputs and outputs.
#[derive(Debug, Clone)]
pub struct StateSpace {
    /// System matrix A.
    pub a: Matrix,
    /// Input matrix B.
    pub b: Matrix,
    /// Output matrix C.
    pub c: Matrix,
    /// Feedthrough matrix D.
    pub d: Matrix,
    /// Names of the states: first the displacements such as `motor.theta` (rad or m), then the speeds `motor.theta.speed` (per second), then
    /// the damped combinations of massless coordinates.
    pub states: Vec<String>,
    /// Names of the inputs: torque (N·m) or force (N) along a degree of freedom.
    pub inputs: Vec<String>,
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// Sample time, s; `None` for a continuous-time system.
    pub sample_time: Option<f64>,
    /// Discretisation method (input between samples) of a discrete-time system.
    pub method: Option<InputHold>,
}

impl StateSpace {
    /// State space over the degrees of freedom independent of rigid joints, `x = [p, ṗ]`. Without names each of these is an input and an
    /// output.
    ///
    /// # Errors
    /// Those of [`signals`]; `Conflict` for loss factors, which have no state-space form, and for a speed that needs the derivative of an input.
    pub fn physical(
        context: &AnalysisContext,
        inputs: &[String],
        outputs: &[String],
    ) -> Result<StateSpace, Error> {
        let matrices = SystemMatrices::physical(context);
        let or_all = |names: &[String]| {
            if names.is_empty() {
                matrices.names.clone()
            } else {
                names.to_vec()
            }
        };
        StateSpace::from_matrices(context, &matrices, &or_all(inputs), &or_all(outputs))
    }

    /// State space over mass-normalised modal coordinates, `x = [η, η̇]`, which resolves low frequencies accurately next to high ones.
    ///
    /// # Errors
    /// Those of [`StateSpace::physical`].
    pub fn modal(
        context: &AnalysisContext,
        inputs: &[String],
        outputs: &[String],
    ) -> Result<StateSpace, Error> {
        let physical = || {
            reference_dofs(context.model)
                .iter()
                .map(|&(f, _)| context.machine.dof_name(f))
                .collect()
        };
        let or_all = |names: &[String]| {
            if names.is_empty() {
                physical()
            } else {
                names.to_vec()
            }
        };
        StateSpace::from_matrices(
            context,
            &SystemMatrices::modal(context),
            &or_all(inputs),
            &or_all(outputs),
        )
    }

    /// State space of physical, modal or reduced equations of the machine.
    ///
    /// # Errors
    /// Those of [`StateSpace::physical`].
    pub fn from_matrices(
        context: &AnalysisContext,
        matrices: &SystemMatrices,
        inputs: &[String],
        outputs: &[String],
    ) -> Result<StateSpace, Error> {
        let columns = inputs
            .iter()
            .map(|name| {
                Ok(matrices.project(
                    &context.model.transform[signals::parse_input(context.machine, name)?],
                ))
            })
            .collect::<Result<Vec<Vec<f64>>, Error>>()?;
        let forces = Matrix::from_fn(matrices.len(), inputs.len(), |i, j| columns[j][i]);
        let first = first_order(matrices, &forces)?;
        let rows = outputs
            .iter()
            .map(|name| {
                output_row(
                    context,
                    matrices,
                    &first,
                    name,
                    signals::parse_output(context.machine, name)?,
                )
            })
            .collect::<Result<Vec<SignalRow>, Error>>()?;
        let c = Matrix::from_fn(outputs.len(), first.a.ncols(), |i, j| rows[i].x[j]);
        let d = Matrix::from_fn(outputs.len(), inputs.len(), |i, j| rows[i].u[j]);
        let FirstOrder { a, b, states, .. } = first;
        let (inputs, outputs) = (inputs.to_vec(), outputs.to_vec());
        Ok(StateSpace {
            a,
            b,
            c,
            d,
            states,
            inputs,
            outputs,
            sample_time: None,
            method: None,
        })
    }

    /// Transfer matrix `C (s I − A)⁻¹ B + D`, outputs by inputs; `s` is z for a discrete-time system.
    ///
    /// # Errors
    /// `Indefinite` if s is a pole to working precision.
    pub fn transfer(&self, s: Complex) -> Result<ComplexMatrix, Error> {
        let n = self.a.nrows();
        let real = |x: f64| Complex::new(x, 0.0);
        let left = ComplexMatrix::from_fn(n, n, |i, j| {
            if i == j {
                s - self.a[(i, j)]
            } else {
                real(-self.a[(i, j)])
            }
        });
        let x = symmetric::lu_solve_complex(
            &left,
            &ComplexMatrix::from_fn(n, self.b.ncols(), |i, j| real(self.b[(i, j)])),
        )?;
        let c = ComplexMatrix::from_fn(self.c.nrows(), n, |i, j| real(self.c[(i, j)]));
        let product = c * x;
        Ok(ComplexMatrix::from_fn(
            product.nrows(),
            product.ncols(),
            |i, j| product[(i, j)] + self.d[(i, j)],
        ))
    }
}

/// Row of C and D for one signal.
struct SignalRow {
    x: Vec<f64>,
    u: Vec<f64>,
}

impl SignalRow {
    /// Signal `wᵀ p` of the coordinates p.
    fn apply(matrices: &SystemMatrices, first: &FirstOrder, w: &[(usize, f64)]) -> SignalRow {
        let weights = matrices.project(w);
        let combine = |m: &Matrix| {
            (0..m.ncols())
                .map(|j| (0..weights.len()).map(|i| weights[i] * m[(i, j)]).sum())
                .collect()
        };
        SignalRow {
            x: combine(&first.r_from_x),
            u: combine(&first.r_from_u),
        }
    }

    /// Time derivative of the signal; `Conflict` if it needs the derivative of an input.
    fn rate(&self, first: &FirstOrder, name: &str) -> Result<SignalRow, Error> {
        if self.u.iter().any(|&u| u != 0.0) {
            let message =
                format!("`{name}` needs the derivative of an input, which acts on a massless node");
            let hint = "give that node an inertia, or request one derivative less: displacement for speed, speed for acceleration";
            return Err(Error::new(Code::Conflict, message).with_hint(hint));
        }
        let combine = |m: &Matrix| {
            let entry = |j: usize| {
                (0..self.x.len())
                    .filter(|&i| self.x[i] != 0.0)
                    .map(|i| self.x[i] * m[(i, j)])
                    .sum()
            };
            (0..m.ncols()).map(entry).collect()
        };
        Ok(SignalRow {
            x: combine(&first.a),
            u: combine(&first.b),
        })
    }
}

fn output_row(
    context: &AnalysisContext,
    matrices: &SystemMatrices,
    first: &FirstOrder,
    name: &str,
    output: OutputSignal,
) -> Result<SignalRow, Error> {
    match output {
        OutputSignal::Dof(dof, n_derivatives) => {
            let mut row = SignalRow::apply(matrices, first, &context.model.transform[dof]);
            for _ in 0..n_derivatives {
                row = row.rate(first, name)?;
            }
            Ok(row)
        }
        OutputSignal::Force(index) => force_row(context, matrices, first, name, &[(index, 1.0)]),
        OutputSignal::Support(at) => force_row(
            context,
            matrices,
            first,
            name,
            &context.machine.supports[at].forces,
        ),
    }
}

/// Signal `Σ a F` of branch forces; open branches and branches between rigidly joined nodes carry no force.
fn force_row(
    context: &AnalysisContext,
    matrices: &SystemMatrices,
    first: &FirstOrder,
    name: &str,
    forces: &[(usize, f64)],
) -> Result<SignalRow, Error> {
    let mut sum = SignalRow {
        x: vec![0.0; first.a.ncols()],
        u: vec![0.0; first.b.ncols()],
    };
    for &(index, share) in forces {
        let Some(branch) = context.model.branches.iter().find(|b| b.index == index) else {
            continue;
        };
        let w: Vec<(usize, f64)> = branch.direction.entries().collect();
        let row = SignalRow::apply(matrices, first, &w);
        let mut add = |factor: f64, row: &SignalRow| {
            let entries = sum
                .x
                .iter_mut()
                .zip(&row.x)
                .chain(sum.u.iter_mut().zip(&row.u));
            entries.for_each(|(s, x)| *s += share * factor * x);
        };
        add(branch.stiffness, &row);
        if branch.damping != 0.0 {
            add(branch.damping, &row.rate(first, name)?);
        }
    }
    Ok(sum)
}
