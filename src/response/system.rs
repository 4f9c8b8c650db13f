//! Input–output system `D(s) x = b(s) u`, `y = c(s) x + d(s) u`.
//!
//! b, c and d are sums of real columns and rows with the factors 1, s, s² and i sgn(Im s): what is prescribed acts through
//! `−D_rh h`, a branch with an imposed displacement through `u (k + s c + iηk) e`.

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

/// A machine at its operating point, as frequency responses need it.
#[derive(Clone, Copy)]
pub struct OperatingModel<'a> {
    /// The machine.
    pub machine: &'a Machine,
    /// Operating point, with its contact states.
    pub operating: &'a OperatingPoint,
    /// The same, linear.
    pub model: &'a LinearModel,
    /// Mean speed of every degree of freedom, rad/s, for gyroscopic terms; absent: at rest.
    pub speeds: Option<&'a [f64]>,
}

/// Input and output matrices on both sides of `D(s)`.
pub struct InputOutputSystem {
    /// Number of coordinates solved for.
    n: usize,
    /// The first coordinates are so many motions that strain nothing.
    pub(super) rigid: usize,
    /// Number of rigid motions that no damper resists either.
    pub(super) undamped_rigid: usize,
    /// Columns b.
    pub(super) input_columns: Vec<SparseVector>,
    /// Rows c.
    pub(super) output_rows: Vec<SparseVector>,
    /// Factor terms of every input.
    pub(super) inputs: Vec<FactorTerms>,
    /// Factor terms of every output.
    pub(super) outputs: Vec<FactorTerms>,
    /// d of every output and input.
    pub(super) feedthrough: Vec<Vec<Vec<(LaplaceFactor, f64)>>>,
    /// Names of the outputs, for messages.
    pub(super) names: Vec<String>,
}

impl InputOutputSystem {
    /// Over single coordinates, with D entry by entry: what is solved line by line.
    ///
    /// # Errors
    /// Prescribed motions that exclude each other; a displacement imposed where nothing carries it; those of the modes where
    /// modal damping needs them.
    pub(super) fn direct_system(
        model: &OperatingModel,
        ports: &Ports,
    ) -> Result<(InputOutputSystem, DynamicStiffness), Error> {
        let coordinates = coordinates(model, ports)?;
        let transform =
            SparseTransform::from_columns(coordinates.model.n, &coordinates.sparse_basis());
        let rigid = (coordinates.rigid.len(), coordinates.fixed.n_undamped_rigid);
        let all = match damped_modes(model, &coordinates)? {
            Some(shapes) => {
                let context = case(model, &coordinates, &shapes);
                let full =
                    SystemMatrices::in_basis(&context, transform.matrix(), Vec::new(), rigid.0);
                DynamicStiffness::from_dense(&full)
            }
            None => {
                let none = ModalBasis::empty(coordinates.model.n);
                DynamicStiffness::assemble(&case(model, &coordinates, &none), &transform, rigid.0)
            }
        };
        let (own, beside) = all.split(transform.columns() - coordinates.prescribed.len());
        let system =
            InputOutputSystem::over_band(model, ports, &coordinates, (&transform, &beside), rigid)?;
        Ok((system, own))
    }

    /// Over the undamped modes of the machine with what is prescribed held still; the dense equations of these, and the modes.
    ///
    /// # Errors
    /// Those of [`InputOutputSystem::direct_system`] and of the modes.
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
        let context = case(model, &coordinates, &shapes);
        let all = SystemMatrices::in_basis(&context, matrix, Vec::new(), rigid.0);
        let n = all.len() - coordinates.prescribed.len();
        let beside = match coordinates.prescribed.is_empty() {
            true => Vec::new(),
            false => DynamicStiffness::from_dense(&all).split(n).1,
        };
        let system =
            InputOutputSystem::over_band(model, ports, &coordinates, (&transform, &beside), rigid)?;
        let cut = |a: &Matrix| Matrix::from_fn(n, n, |i, j| a[(i, j)]);
        let matrices = SystemMatrices {
            mass: cut(&all.mass),
            damping: cut(&all.damping),
            stiffness: cut(&all.stiffness),
            hysteretic: all.hysteretic.as_ref().map(cut),
            massless: all.massless.iter().copied().filter(|&j| j < n).collect(),
            names: (0..n).map(|j| format!("{}", j + 1)).collect(),
            transform: Matrix::from_fn(all.transform.nrows(), n, |i, j| all.transform[(i, j)]),
        };
        Ok((system, matrices, basis))
    }

    /// Number of coordinates solved for.
    pub fn len(&self) -> usize {
        self.n
    }

    /// Nothing is free to move.
    pub fn is_empty(&self) -> bool {
        self.n == 0
    }

    /// Motions that strain nothing while what is prescribed holds still.
    pub fn n_rigid(&self) -> usize {
        self.rigid
    }

    fn over_band(
        model: &OperatingModel,
        ports: &Ports,
        coordinates: &ConstrainedCoordinates,
        (transform, beside): (&SparseTransform, &[StiffnessEntry]),
        (rigid, undamped_rigid): (usize, usize),
    ) -> Result<InputOutputSystem, Error> {
        let n = transform.columns() - coordinates.prescribed.len();
        let builder = PortBuilder {
            machine: model.machine,
            coordinates,
            beta: model.machine.damping.stiffness,
            transform,
            prescribed_entries: beside,
            n,
        };
        let inputs = ports
            .inputs
            .iter()
            .map(|port| builder.input(port.kind))
            .collect::<Result<Vec<_>, _>>()?;
        let cut = |(factor, all): &(LaplaceFactor, SparseVector)| {
            let own = all.iter().copied().filter(|term| term.0 < n);
            (*factor, own.collect::<SparseVector>())
        };
        let (mut loads, mut reads) = (VectorSet::default(), VectorSet::default());
        let input_terms = inputs.iter().map(|input| {
            let own = input.force.iter().map(cut);
            loads.insert(own.chain(builder.prescribed(&input.prescribed)))
        });
        let input_terms = input_terms.collect();
        let (mut output_terms, mut through) = (Vec::new(), Vec::new());
        for port in &ports.outputs {
            let read = builder.output(&port.kind);
            let direct = inputs.iter().map(|input| builder.feedthrough(&read, input));
            through.push(direct.collect());
            output_terms.push(reads.insert(read.rows.iter().map(cut)));
        }
        Ok(InputOutputSystem {
            n,
            rigid,
            undamped_rigid,
            input_columns: loads.all,
            output_rows: reads.all,
            inputs: input_terms,
            outputs: output_terms,
            feedthrough: through,
            names: ports.outputs.iter().map(|port| port.name.clone()).collect(),
        })
    }

    /// Columns b.
    pub(super) fn load_columns(&self) -> Matrix {
        let mut all = Matrix::zeros(self.n, self.input_columns.len());
        for (j, load) in self.input_columns.iter().enumerate() {
            load.iter().for_each(|&(i, b)| all[(i, j)] = b);
        }
        all
    }

    /// Rows c.
    pub(super) fn read_rows(&self) -> Matrix {
        let mut all = Matrix::zeros(self.output_rows.len(), self.n);
        for (i, read) in self.output_rows.iter().enumerate() {
            read.iter().for_each(|&(j, c)| all[(i, j)] = c);
        }
        all
    }

    /// `Σ φ_c φ_b g(c, b) + d`, outputs by inputs, from `g = c D⁻¹ b` of every row and column.
    pub(super) fn combine(&self, s: Complex, g: impl Fn(usize, usize) -> Complex) -> ComplexMatrix {
        ComplexMatrix::from_fn(self.outputs.len(), self.inputs.len(), |o, i| {
            let mut sum = Complex::ZERO;
            for &(read, row) in &self.outputs[o] {
                for &(load, column) in &self.inputs[i] {
                    sum += read.value_at(s) * load.value_at(s) * g(row, column);
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

/// Tolerance of the shapes of a modal sum: a hundredth of the difference from the direct solution that is allowed.
const SHAPE_TOLERANCE: f64 = 1e-10;

/// Most degrees of freedom whose natural frequencies are sought ahead of a response.
const MAX_SEARCH_DOFS: usize = 400;

/// Undamped natural frequencies in a band, rad/s, with what is prescribed held still, or free where that fails: near enough for a search;
/// none of a large machine.
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
    let held = coordinates(model, ports).and_then(|coordinates| solve(&coordinates.fixed));
    let omega = held.or_else(|_| solve(model.model)).unwrap_or_default();
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

/// The equations that are to be summed; modal damping refers to `shapes`.
fn case<'a>(
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

/// The modes that modal damping refers to; nothing where there is none.
fn damped_modes(
    model: &OperatingModel,
    coordinates: &ConstrainedCoordinates,
) -> Result<Option<ModalBasis>, Error> {
    if !model.machine.damping.is_modal() {
        return Ok(None);
    }
    let own = modal_basis::solve(model.model, UndampedSolver::Factored)?;
    Ok(Some(coordinates.shapes(&own, model.model)))
}
