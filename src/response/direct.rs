//! Direct solution of `D(iω) x = b` at each frequency line, dense or sparse.

use super::dynamic_stiffness::{DynamicStiffness, StiffnessEntry};
use super::laplace_factor::LaplaceFactor;
use super::ports::Ports;
use super::system::{InputOutputSystem, OperatingModel};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::quantity::format_number;
use crate::numeric::sparse_lu::SymbolicFactor;
use crate::numeric::{Complex, ComplexMatrix, Matrix, symmetric};

/// Direct solver of the input–output system at any frequency.
pub struct DirectSolver {
    system: InputOutputSystem,
    entries: DynamicStiffness,
    pattern: Option<SymbolicFactor>,
}

/// Largest system that is always solved with dense matrices.
const DENSE_LIMIT: usize = 24;

/// Largest share of nonzero entries for a sparse solution.
const MAX_FILL: f64 = 0.25;

impl DirectSolver {
    /// Assembles the equations and determines the order of elimination.
    ///
    /// # Errors
    /// Errors of the machine matrices; `Hopeless` if memory is insufficient.
    pub fn new(model: &OperatingModel, ports: &Ports) -> Result<DirectSolver, Error> {
        let (system, entries) = InputOutputSystem::direct_system(model, ports)?;
        let pattern = pattern(&entries)?;
        Ok(DirectSolver {
            system,
            entries,
            pattern,
        })
    }

    /// Input–output system.
    pub fn system(&self) -> &InputOutputSystem {
        &self.system
    }

    /// Whether the matrix is solved as sparse.
    pub fn is_sparse(&self) -> bool {
        self.pattern.is_some()
    }

    /// Frequency response, outputs by inputs, at `s = iω`, ω in rad/s.
    ///
    /// # Errors
    /// At ω = 0 an output that depends on a rigid-body motion of a free machine; `NotPositiveDefinite` at an undamped resonance.
    pub fn response_at(&self, omega: f64) -> Result<ComplexMatrix, Error> {
        let system = &self.system;
        let s = Complex::new(0.0, omega);
        if omega == 0.0 && system.rigid > 0 {
            return self.static_response();
        }
        let solution = self.solve(s).map_err(|_| undamped_resonance_error(omega))?;
        let response = system.combine(s, |read, load| {
            let add = |sum: Complex, &(j, c): &(usize, f64)| sum + solution[(j, load)] * c;
            system.output_rows[read].iter().fold(Complex::ZERO, add)
        });
        let finite = (0..response.ncols()).all(|j| {
            response
                .col_as_slice(j)
                .iter()
                .all(|z| z.re.is_finite() && z.im.is_finite())
        });
        if finite {
            Ok(response)
        } else {
            Err(undamped_resonance_error(omega))
        }
    }

    /// Solves `D(s) X = B`.
    fn solve(&self, s: Complex) -> Result<ComplexMatrix, Error> {
        let b = self.system.input_matrix();
        solve_scaled(&self.entries, self.pattern.as_ref(), s, &b)
    }

    /// Static response of a free machine: the resultant load accelerates it as a rigid body, the self-equilibrated rest deforms it.
    ///
    /// With the rigid-body motions R, `K x + M R a = b`, `Rᵀ M x = 0`; the response is `x + R a / s²`.
    fn static_response(&self) -> Result<ComplexMatrix, Error> {
        let system = &self.system;
        let (rigid, n) = (system.rigid, system.len());
        let b = system.input_matrix();
        if system.undamped_rigid < rigid {
            let message = "a machine supported by dampers only has no static response";
            return Err(Error::new(Code::Conflict, message)
                .with_hint("request frequencies above 0 Hz, or prescribe an angle: --hold NODE"));
        }
        let mut mass = Matrix::zeros(rigid, rigid);
        let is_rigid = |e: &&StiffnessEntry| e.row < rigid && e.column < rigid;
        for e in self.entries.list.iter().filter(is_rigid) {
            mass[(e.row, e.column)] = e.mass;
        }
        let load = Matrix::from_fn(rigid, b.ncols(), |i, j| b[(i, j)]);
        let a = symmetric::lu_solve(&mass, &load)?;
        // K is exactly zero in the rigid-body rows and columns; the trailing block gives the deformation.
        let elastic = n - rigid;
        let mut f = Matrix::from_fn(elastic, b.ncols(), |i, j| b[(rigid + i, j)]);
        let couples = |e: &&StiffnessEntry| e.row >= rigid && e.column < rigid;
        for e in self.entries.list.iter().filter(couples) {
            for j in 0..b.ncols() {
                f[(e.row - rigid, j)] -= e.mass * a[(e.column, j)];
            }
        }
        let k = self.entries.trailing_block(rigid);
        let deformation = solve_scaled(&k, pattern(&k)?.as_ref(), Complex::ZERO, &f)?;
        let mut response = ComplexMatrix::zeros(system.outputs.len(), system.inputs.len());
        for (o, terms) in system.outputs.iter().enumerate() {
            if self.depends_on_rigid(terms) {
                let message = format!(
                    "`{}` has no value at 0 Hz: the machine can turn freely",
                    system.names[o]
                );
                let hint = "request frequencies above 0 Hz, or a difference that no rigid motion changes, or prescribe an angle: --hold NODE";
                return Err(Error::new(Code::Conflict, message).with_hint(hint));
            }
            for (i, loads) in system.inputs.iter().enumerate() {
                let mut sum = 0.0;
                for &(_, load) in loads.iter().filter(|t| t.0 == LaplaceFactor::ONE) {
                    for &(factor, row) in terms.iter().filter(|t| !t.0.hysteretic) {
                        let value = match factor.power {
                            0 => (system.output_rows[row].iter())
                                .filter(|term| term.0 >= rigid)
                                .map(|&(j, c)| c * deformation[(j - rigid, load)].re)
                                .sum(),
                            2 => (system.output_rows[row].iter())
                                .filter(|term| term.0 < rigid)
                                .map(|&(r, c)| c * a[(r, load)])
                                .sum(),
                            _ => 0.0,
                        };
                        sum += value;
                    }
                }
                let direct = system.feedthrough[o][i]
                    .iter()
                    .filter(|t| t.0 == LaplaceFactor::ONE);
                response[(o, i)] = Complex::new(sum + direct.map(|t| t.1).sum::<f64>(), 0.0);
            }
        }
        Ok(response)
    }

    /// Whether a displacement or speed output depends on a rigid-body motion.
    fn depends_on_rigid(&self, terms: &[(LaplaceFactor, usize)]) -> bool {
        let rigid = self.system.rigid;
        let is_rigid = |row: usize| {
            let row_terms = &self.system.output_rows[row];
            let largest = |count: usize| {
                let leading = row_terms.iter().filter(|term| term.0 < count);
                leading.map(|term| term.1.abs()).fold(0.0, f64::max)
            };
            largest(rigid) > RIGID_TOLERANCE * largest(usize::MAX)
        };
        let mut terms = terms.iter().filter(|t| t.0.power < 2);
        terms.any(|&(_, row)| is_rigid(row))
    }
}

/// Symbolic sparse factorisation; `None` for a small or dense matrix.
fn pattern(entries: &DynamicStiffness) -> Result<Option<SymbolicFactor>, Error> {
    let (n, list) = (entries.n, &entries.list);
    let sparse = n > DENSE_LIMIT && (list.len() as f64) < MAX_FILL * (n * n) as f64;
    let indices = list.iter().map(|e| (e.row, e.column));
    sparse.then(|| SymbolicFactor::new(n, indices)).transpose()
}

/// Solves `D(s) X = B` with D scaled to unit diagonal.
fn solve_scaled(
    entries: &DynamicStiffness,
    pattern: Option<&SymbolicFactor>,
    s: Complex,
    b: &Matrix,
) -> Result<ComplexMatrix, Error> {
    let n = entries.n;
    let mut scale = vec![1.0; n];
    for diagonal in entries.list.iter().filter(|e| e.row == e.column) {
        let size = diagonal.size(s);
        // Powers of two scale without rounding.
        if size > 0.0 {
            scale[diagonal.row] = (-0.5 * size.log2()).round().exp2();
        }
    }
    let scaled = |e: &StiffnessEntry| e.value_at(s) * (scale[e.row] * scale[e.column]);
    let right =
        ComplexMatrix::from_fn(n, b.ncols(), |i, j| Complex::new(b[(i, j)] * scale[i], 0.0));
    let mut x = match pattern {
        _ if n == 0 => right,
        Some(pattern) => {
            let values: Vec<Complex> = entries.list.iter().map(scaled).collect();
            pattern.solve(&values, &right)?
        }
        None => {
            let mut dense = ComplexMatrix::zeros(n, n);
            for e in &entries.list {
                dense[(e.row, e.column)] = scaled(e);
            }
            symmetric::lu_solve_complex(&dense, &right)?
        }
    };
    for j in 0..x.ncols() {
        let column = x.col_as_slice_mut(j).iter_mut();
        column.zip(&scale).for_each(|(x, scale)| *x *= *scale);
    }
    Ok(x)
}

/// Tolerance of rigid-body entries relative to the largest entry of an output row, above the rounding of speed ratios.
const RIGID_TOLERANCE: f64 = 1e-12;

/// Frequency above which inertia forces may overflow, rad/s.
const MAX_OMEGA: f64 = 1e100;

/// Error of a system that is singular at ω, rad/s.
pub(super) fn undamped_resonance_error(omega: f64) -> Error {
    let at = format!("at {} Hz", format_number(omega / std::f64::consts::TAU));
    if omega > MAX_OMEGA {
        let message = format!("{at} the inertia forces overflow");
        return Error::new(Code::Overflow, message).with_hint("request lower frequencies");
    }
    let message = format!("{at} the machine is at an undamped resonance");
    Error::new(Code::NotPositiveDefinite, message)
        .with_hint("give the machine damping, or request another frequency")
}
