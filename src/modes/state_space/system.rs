//! `ẋ = A x + B u`, `y = C x + D u`; discrete, where it has a sample time: `x⁺ = A x + B u`.

use super::first_order::{FirstOrder, first_order};
use super::signals::{self, OutputSignal};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::modes::system_matrices::{AnalysisContext, SystemMatrices, reference_dofs};
use crate::numeric::{Complex, ComplexMatrix, Matrix, symmetric};
use crate::scene::study::InputHold;

/// A state-space form with names.
#[derive(Debug, Clone)]
pub struct StateSpace {
    /// A.
    pub a: Matrix,
    /// B.
    pub b: Matrix,
    /// C.
    pub c: Matrix,
    /// D.
    pub d: Matrix,
    /// Names of the states: `motor.theta` (rad or m) and, after all of these, `motor.theta.speed` (per second); after these the
    /// combinations of massless coordinates that dampers brake.
    pub states: Vec<String>,
    /// Names of the inputs: N·m or N along a degree of freedom.
    pub inputs: Vec<String>,
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// Between samples, s; absent: continuous.
    pub sample_time: Option<f64>,
    /// Discretisation method (input between samples) of a discrete-time system.
    pub method: Option<InputHold>,
}

impl StateSpace {
    /// Over the degrees of freedom that stay behind rigid joints, `x = [p, ṗ]`. Without names every one of these is an input
    /// and an output.
    ///
    /// # Errors
    /// Names of [`signals`]; loss factors, which have no such form; a speed that would need the input's derivative.
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

    /// Over mass-normalised modal coordinates, `x = [η, η̇]`: small frequencies keep their digits next to large ones.
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

    /// State space of any equations of the machine: physical, modal or reduced.
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

    /// `C (s I − A)⁻¹ B + D`, outputs by inputs; of a discrete form s is z.
    ///
    /// # Errors
    /// `Indefinite` where s is a pole to working precision.
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
        let through = c * x;
        Ok(ComplexMatrix::from_fn(
            through.nrows(),
            through.ncols(),
            |i, j| through[(i, j)] + self.d[(i, j)],
        ))
    }
}

/// A signal in states and inputs.
struct SignalRow {
    x: Vec<f64>,
    u: Vec<f64>,
}

impl SignalRow {
    /// `wᵀ p`.
    fn apply(matrices: &SystemMatrices, first: &FirstOrder, w: &[(usize, f64)]) -> SignalRow {
        let along = matrices.project(w);
        let weigh = |m: &Matrix| {
            (0..m.ncols())
                .map(|j| (0..along.len()).map(|i| along[i] * m[(i, j)]).sum())
                .collect()
        };
        SignalRow {
            x: weigh(&first.r_from_x),
            u: weigh(&first.r_from_u),
        }
    }

    /// Rate of the signal, where that does not need the rate of an input.
    fn rate(&self, first: &FirstOrder, name: &str) -> Result<SignalRow, Error> {
        if self.u.iter().any(|&u| u != 0.0) {
            let message = format!(
                "`{name}` would need the rate of an input, which acts on a massless node that jumps with it"
            );
            let hint = "give that node an inertia, or measure one degree less: displacement for speed, speed for acceleration";
            return Err(Error::new(Code::Conflict, message).with_hint(hint));
        }
        let weigh = |m: &Matrix| {
            let along = |j: usize| {
                (0..self.x.len())
                    .filter(|&i| self.x[i] != 0.0)
                    .map(|i| self.x[i] * m[(i, j)])
                    .sum()
            };
            (0..m.ncols()).map(along).collect()
        };
        Ok(SignalRow {
            x: weigh(&first.a),
            u: weigh(&first.b),
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
        OutputSignal::Dof(dof, times) => {
            let mut row = SignalRow::apply(matrices, first, &context.model.transform[dof]);
            for _ in 0..times {
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

/// `Σ a F` of branches; what is open, or between what turns as one, carries nothing.
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
            let both = sum
                .x
                .iter_mut()
                .zip(&row.x)
                .chain(sum.u.iter_mut().zip(&row.u));
            both.for_each(|(s, x)| *s += share * factor * x);
        };
        add(branch.stiffness, &row);
        if branch.damping != 0.0 {
            add(branch.damping, &row.rate(first, name)?);
        }
    }
    Ok(sum)
}
