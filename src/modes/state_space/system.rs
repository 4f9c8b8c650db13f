//! `ẋ = A x + B u`, `y = C x + D u`; discrete, where it has a sample time: `x⁺ = A x + B u`.

use super::first_order::{FirstOrder, first_order};
use super::signals::{self, Output};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::modes::equations::{Case, Equations, independent};
use crate::numeric::{Complex, ComplexMatrix, Matrix, definite};
use crate::scene::study::Hold;

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
    /// What each state is: `motor.theta` (rad or m) and, after all of these, `motor.theta.speed` (per second); after these
    /// the combinations of massless coordinates that dampers brake.
    pub states: Vec<String>,
    /// What each input is: N·m or N along a freedom.
    pub inputs: Vec<String>,
    /// What each output is.
    pub outputs: Vec<String>,
    /// Between samples, s; absent: continuous.
    pub sample_time: Option<f64>,
    /// What the input does between samples, where there are any.
    pub hold: Option<Hold>,
}

impl StateSpace {
    /// Over the freedoms that stay behind rigid joints, `x = [p, ṗ]`. Without names every one of these is an input and an output.
    ///
    /// # Errors
    /// Names of [`signals`]; loss factors, which have no such form; a speed that would need the input's derivative.
    pub fn physical(
        case: &Case,
        inputs: &[String],
        outputs: &[String],
    ) -> Result<StateSpace, Error> {
        let equations = Equations::physical(case);
        let or_all = |names: &[String]| {
            if names.is_empty() {
                equations.names.clone()
            } else {
                names.to_vec()
            }
        };
        StateSpace::of(case, &equations, &or_all(inputs), &or_all(outputs))
    }

    /// Over mass-normalised modal coordinates, `x = [η, η̇]`: small frequencies keep their digits beside large ones.
    ///
    /// # Errors
    /// Those of [`StateSpace::physical`].
    pub fn modal(case: &Case, inputs: &[String], outputs: &[String]) -> Result<StateSpace, Error> {
        let physical = || {
            independent(case.linear)
                .iter()
                .map(|&(f, _)| case.machine.freedom_name(f))
                .collect()
        };
        let or_all = |names: &[String]| {
            if names.is_empty() {
                physical()
            } else {
                names.to_vec()
            }
        };
        StateSpace::of(
            case,
            &Equations::modal(case),
            &or_all(inputs),
            &or_all(outputs),
        )
    }

    /// Of any equations of the machine: physical, modal or reduced.
    ///
    /// # Errors
    /// Those of [`StateSpace::physical`].
    pub fn of(
        case: &Case,
        equations: &Equations,
        inputs: &[String],
        outputs: &[String],
    ) -> Result<StateSpace, Error> {
        let columns = inputs
            .iter()
            .map(|name| {
                Ok(equations.sees(&case.linear.transform[signals::input(case.machine, name)?]))
            })
            .collect::<Result<Vec<Vec<f64>>, Error>>()?;
        let forces = Matrix::from_fn(equations.len(), inputs.len(), |i, j| columns[j][i]);
        let first = first_order(equations, &forces)?;
        let rows = outputs
            .iter()
            .map(|name| {
                output_row(
                    case,
                    equations,
                    &first,
                    name,
                    signals::output(case.machine, name)?,
                )
            })
            .collect::<Result<Vec<Row>, Error>>()?;
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
            hold: None,
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
        let x = definite::solve_complex(
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
struct Row {
    x: Vec<f64>,
    u: Vec<f64>,
}

impl Row {
    /// `wᵀ p`.
    fn of(equations: &Equations, first: &FirstOrder, w: &[(usize, f64)]) -> Row {
        let along = equations.sees(w);
        let weigh = |m: &Matrix| {
            (0..m.ncols())
                .map(|j| (0..along.len()).map(|i| along[i] * m[(i, j)]).sum())
                .collect()
        };
        Row {
            x: weigh(&first.at_x),
            u: weigh(&first.at_u),
        }
    }

    /// Its rate, where that does not need the rate of an input.
    fn rate(&self, first: &FirstOrder, name: &str) -> Result<Row, Error> {
        if self.u.iter().any(|&u| u != 0.0) {
            let message = format!(
                "`{name}` would need the rate of an input, which acts on a massless node that jumps with it"
            );
            let hint = "give that node an inertia, or measure one degree less: displacement for speed, speed for acceleration";
            return Err(Error::new(Code::Conflict, message).hint(hint));
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
        Ok(Row {
            x: weigh(&first.a),
            u: weigh(&first.b),
        })
    }
}

fn output_row(
    case: &Case,
    equations: &Equations,
    first: &FirstOrder,
    name: &str,
    output: Output,
) -> Result<Row, Error> {
    match output {
        Output::Freedom(freedom, times) => {
            let mut row = Row::of(equations, first, &case.linear.transform[freedom]);
            for _ in 0..times {
                row = row.rate(first, name)?;
            }
            Ok(row)
        }
        Output::Force(index) => force_row(case, equations, first, name, &[(index, 1.0)]),
        Output::Support(at) => force_row(
            case,
            equations,
            first,
            name,
            &case.machine.supports[at].forces,
        ),
    }
}

/// `Σ a F` of branches; what is open, or between what turns as one, carries nothing.
fn force_row(
    case: &Case,
    equations: &Equations,
    first: &FirstOrder,
    name: &str,
    forces: &[(usize, f64)],
) -> Result<Row, Error> {
    let mut sum = Row {
        x: vec![0.0; first.a.ncols()],
        u: vec![0.0; first.b.ncols()],
    };
    for &(index, share) in forces {
        let Some(branch) = case.linear.branches.iter().find(|b| b.index == index) else {
            continue;
        };
        let w: Vec<(usize, f64)> = branch.direction.scaled().collect();
        let row = Row::of(equations, first, &w);
        let mut add = |factor: f64, row: &Row| {
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
