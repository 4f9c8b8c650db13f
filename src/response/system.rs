//! Input–output system `D(s) x = b(s) u`, `y = c(s) x + d(s) u`.
//!
//! b, c and d are sums of real columns and rows with the factors 1, s, s² and i sgn(Im s): prescribed motions act by `−D_rh h`,
//! displacements e imposed in a branch by `u (k + s c + iηk) e`.

use super::constrained::{ConstrainedCoordinates, CoordinateInput};
use super::dynamic_stiffness::{DynamicStiffness, SparseTransform, SparseVector, StiffnessEntry};
use super::input_output::{FactorTerms, PortBuilder, VectorSet};
use super::laplace_factor::LaplaceFactor;
use super::ports::Ports;
use crate::base::error::Error;
use crate::machine::components::Machine;
use crate::machine::linear::LinearModel;
use crate::machine::operating_point::OperatingPoint;
use crate::modes::modal_basis::{self, ModalBasis, UndampedSolver};
use crate::modes::system_matrices::{AnalysisContext, SystemMatrices};
use crate::numeric::{Complex, ComplexMatrix, Matrix};

/// Machine with its operating point and linear model.
#[derive(Clone, Copy)]
pub struct OperatingModel<'a> {
    /// Machine.
    pub machine: &'a Machine,
    /// Operating point with its contact states.
    pub operating: &'a OperatingPoint,
    /// Linear model at the operating point.
    pub model: &'a LinearModel,
    /// Mean speed of every degree of freedom, rad/s, for gyroscopic terms; `None` at standstill.
    pub speeds: Option<&'a [f64]>,
}

/// Input and output matrices on both sides of `D(s)`.
pub struct InputOutputSystem {
    /// Number of coordinates.
    n: usize,
    /// Number of rigid-body motions, which are the first coordinates.
    pub(super) rigid: usize,
    /// Number of undamped rigid-body motions.
    pub(super) undamped_rigid: usize,
    /// Real columns of b.
    pub(super) input_columns: Vec<SparseVector>,
    /// Real rows of c.
    pub(super) output_rows: Vec<SparseVector>,
    /// Factor terms of every input.
    pub(super) inputs: Vec<FactorTerms>,
    /// Factor terms of every output.
    pub(super) outputs: Vec<FactorTerms>,
    /// Terms of d for every output and input.
    pub(super) feedthrough: Vec<Vec<Vec<(LaplaceFactor, f64)>>>,
    /// Names of the outputs, for messages.
    pub(super) names: Vec<String>,
}

impl InputOutputSystem {
    /// System over single coordinates with the entries of D, for the direct solution.
    ///
    /// # Errors
    /// Conflicting prescribed motions; a displacement imposed in a branch without stiffness; errors of the modes for modal
    /// damping.
    pub(super) fn direct_system(
        model: &OperatingModel,
        ports: &Ports,
    ) -> Result<(InputOutputSystem, DynamicStiffness), Error> {
        let coordinates = coordinates(model, ports)?;
        let transform =
            SparseTransform::from_columns(coordinates.model.n, &coordinates.sparse_basis());
        let rigid = (coordinates.rigid.len(), coordinates.fixed.n_undamped_rigid);
        let entries = match damped_modes(model, &coordinates)? {
            Some(shapes) => {
                let setup = setup(model, &coordinates, &shapes);
                let full =
                    SystemMatrices::in_basis(&setup, transform.matrix(), Vec::new(), rigid.0);
                DynamicStiffness::from_dense(&full)
            }
            None => {
                let empty = ModalBasis::empty(coordinates.model.n);
                DynamicStiffness::assemble(&setup(model, &coordinates, &empty), &transform, rigid.0)
            }
        };
        let (d_rr, d_rh) = entries.split(transform.columns() - coordinates.prescribed.len());
        let system =
            InputOutputSystem::build(model, ports, &coordinates, (&transform, &d_rh), rigid)?;
        Ok((system, d_rr))
    }

    /// System over the undamped modes with fixed prescribed motions, with its dense matrices and the modes.
    ///
    /// # Errors
    /// Errors of [`InputOutputSystem::direct_system`] and of the modes.
    pub(super) fn modal_system(
        model: &OperatingModel,
        ports: &Ports,
    ) -> Result<(InputOutputSystem, SystemMatrices, ModalBasis), Error> {
        let coordinates = coordinates(model, ports)?;
        let basis = modal_basis::solve(
            &coordinates.fixed,
            UndampedSolver::Symmetric(SHAPE_TOLERANCE),
        )?;
        let matrix = coordinates.modal_basis(&basis);
        let transform = SparseTransform::from_matrix(&matrix);
        let rigid = (basis.n_rigid, coordinates.fixed.n_undamped_rigid);
        let shapes = damped_modes(model, &coordinates)?;
        let shapes = shapes.unwrap_or_else(|| ModalBasis::empty(coordinates.model.n));
        let setup = setup(model, &coordinates, &shapes);
        let full = SystemMatrices::in_basis(&setup, matrix, Vec::new(), rigid.0);
        let n = full.len() - coordinates.prescribed.len();
        let d_rh = match coordinates.prescribed.is_empty() {
            true => Vec::new(),
            false => DynamicStiffness::from_dense(&full).split(n).1,
        };
        let system =
            InputOutputSystem::build(model, ports, &coordinates, (&transform, &d_rh), rigid)?;
        let leading = |a: &Matrix| Matrix::from_fn(n, n, |i, j| a[(i, j)]);
        let matrices = SystemMatrices {
            mass: leading(&full.mass),
            damping: leading(&full.damping),
            stiffness: leading(&full.stiffness),
            hysteretic: full.hysteretic.as_ref().map(leading),
            massless: full.massless.iter().copied().filter(|&j| j < n).collect(),
            names: (0..n).map(|j| format!("{}", j + 1)).collect(),
            transform: Matrix::from_fn(full.transform.nrows(), n, |i, j| full.transform[(i, j)]),
        };
        Ok((system, matrices, basis))
    }

    /// Number of coordinates.
    pub fn len(&self) -> usize {
        self.n
    }

    /// Whether there are no coordinates.
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// Number of rigid-body motions with fixed prescribed motions.
    pub fn n_rigid(&self) -> usize {
        self.rigid
    }

    fn build(
        model: &OperatingModel,
        ports: &Ports,
        coordinates: &ConstrainedCoordinates,
        (transform, d_rh): (&SparseTransform, &[StiffnessEntry]),
        (rigid, undamped_rigid): (usize, usize),
    ) -> Result<InputOutputSystem, Error> {
        let n = transform.columns() - coordinates.prescribed.len();
        let builder = PortBuilder {
            machine: model.machine,
            coordinates,
            beta: model.machine.damping.stiffness,
            transform,
            prescribed_entries: d_rh,
            n,
        };
        let inputs = ports
            .inputs
            .iter()
            .map(|port| builder.input(port.kind))
            .collect::<Result<Vec<_>, _>>()?;
        let restrict = |(factor, vector): &(LaplaceFactor, SparseVector)| {
            let terms = vector.iter().copied().filter(|term| term.0 < n);
            (*factor, terms.collect::<SparseVector>())
        };
        let (mut columns, mut rows) = (VectorSet::default(), VectorSet::default());
        let input_terms = inputs.iter().map(|input| {
            let terms = input.force.iter().map(restrict);
            columns.insert(terms.chain(builder.prescribed(&input.prescribed)))
        });
        let input_terms = input_terms.collect();
        let (mut output_terms, mut feedthrough) = (Vec::new(), Vec::new());
        for port in &ports.outputs {
            let out = builder.output(&port.kind);
            let direct = inputs.iter().map(|input| builder.feedthrough(&out, input));
            feedthrough.push(direct.collect());
            output_terms.push(rows.insert(out.rows.iter().map(restrict)));
        }
        Ok(InputOutputSystem {
            n,
            rigid,
            undamped_rigid,
            input_columns: columns.all,
            output_rows: rows.all,
            inputs: input_terms,
            outputs: output_terms,
            feedthrough,
            names: ports.outputs.iter().map(|port| port.name.clone()).collect(),
        })
    }

    /// Real columns of b as a matrix.
    pub(super) fn input_matrix(&self) -> Matrix {
        let mut matrix = Matrix::zeros(self.n, self.input_columns.len());
        for (j, column) in self.input_columns.iter().enumerate() {
            column.iter().for_each(|&(i, b)| matrix[(i, j)] = b);
        }
        matrix
    }

    /// Real rows of c as a matrix.
    pub(super) fn output_matrix(&self) -> Matrix {
        let mut matrix = Matrix::zeros(self.output_rows.len(), self.n);
        for (i, row) in self.output_rows.iter().enumerate() {
            row.iter().for_each(|&(j, c)| matrix[(i, j)] = c);
        }
        matrix
    }

    /// Frequency response `Σ φ_c φ_b g(c, b) + d`, outputs by inputs, from `g = c D⁻¹ b` of every row and column.
    pub(super) fn combine(&self, s: Complex, g: impl Fn(usize, usize) -> Complex) -> ComplexMatrix {
        ComplexMatrix::from_fn(self.outputs.len(), self.inputs.len(), |o, i| {
            let mut sum = Complex::ZERO;
            for &(output, row) in &self.outputs[o] {
                for &(input, column) in &self.inputs[i] {
                    sum += output.value_at(s) * input.value_at(s) * g(row, column);
                }
            }
            self.feedthrough[o][i]
                .iter()
                .fold(sum, |sum, &(factor, value)| {
                    sum + factor.value_at(s) * value
                })
        })
    }
}

/// Tolerance of the mode shapes, a hundredth of the allowed error of the modal sum.
const SHAPE_TOLERANCE: f64 = 1e-10;

/// Largest number of coordinates for which natural frequencies are computed before a response.
const MAX_SEARCH_DOFS: usize = 400;

/// Undamped natural frequencies in a band, rad/s, as initial estimates: with fixed prescribed motions, or with free ones if that fails;
/// empty for a large machine.
pub fn natural_frequencies(
    model: &OperatingModel,
    ports: &Ports,
    (from, to): (f64, f64),
) -> Vec<f64> {
    if model.model.n > MAX_SEARCH_DOFS {
        return Vec::new();
    }
    let solve = |model: &LinearModel| {
        modal_basis::solve(model, UndampedSolver::Symmetric(1.0)).map(|b| b.omega)
    };
    let fixed = coordinates(model, ports).and_then(|coordinates| solve(&coordinates.fixed));
    let omega = fixed.or_else(|_| solve(model.model)).unwrap_or_default();
    omega.into_iter().filter(|w| *w > from && *w < to).collect()
}

fn coordinates(model: &OperatingModel, ports: &Ports) -> Result<ConstrainedCoordinates, Error> {
    let origin = CoordinateInput {
        machine: model.machine,
        operating: model.operating,
        model: model.model,
    };
    ConstrainedCoordinates::new(&origin, ports)
}

/// Context of the assembly; modal damping refers to `shapes`.
fn setup<'a>(
    model: &OperatingModel<'a>,
    coordinates: &'a ConstrainedCoordinates,
    shapes: &'a ModalBasis,
) -> AnalysisContext<'a> {
    AnalysisContext {
        machine: &coordinates.machine,
        model: &coordinates.model,
        basis: shapes,
        speeds: model.speeds,
    }
}

/// Modes for modal damping; `None` without modal damping.
fn damped_modes(
    model: &OperatingModel,
    coordinates: &ConstrainedCoordinates,
) -> Result<Option<ModalBasis>, Error> {
    if !model.machine.damping.is_modal() {
        return Ok(None);
    }
    let basis = modal_basis::solve(model.model, UndampedSolver::Factored)?;
    Ok(Some(coordinates.shapes(&basis, model.model)))
}
