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

/// A system ready to be solved at any frequency.
pub struct DirectSolver {
    system: InputOutputSystem,
    entries: DynamicStiffness,
    pattern: Option<SymbolicFactor>,
}

/// Smaller systems are solved densely.
const DENSE_LIMIT: usize = 24;

/// So much of a matrix may differ from zero for it to be solved as a sparse one.
const MAX_FILL: f64 = 0.25;

impl DirectSolver {
    /// Sets up the equations and finds the order of elimination.
    ///
    /// # Errors
    /// Those of the machine's matrices; `Hopeless` where memory runs out.
    pub fn new(model: &OperatingModel, ports: &Ports) -> Result<DirectSolver, Error> {
        let (system, entries) = InputOutputSystem::direct_system(model, ports)?;
        let pattern = pattern(&entries)?;
        Ok(DirectSolver {
            system,
            entries,
            pattern,
        })
    }

    /// Input–output system that is solved.
    pub fn system(&self) -> &InputOutputSystem {
        &self.system
    }

    /// Solved as a sparse matrix.
    pub fn is_sparse(&self) -> bool {
        self.pattern.is_some()
    }

    /// Outputs by inputs at `s = iω`, ω in rad/s.
    ///
    /// # Errors
    /// At ω = 0: an output that a free machine does not have at rest. `NotPositiveDefinite` where nothing damps a resonance at ω.
    pub fn response_at(&self, omega: f64) -> Result<ComplexMatrix, Error> {
        let system = &self.system;
        let s = Complex::new(0.0, omega);
        if omega == 0.0 && system.rigid > 0 {
            return self.static_response();
        }
        let x = self.solve(s).map_err(|_| undamped_resonance_error(omega))?;
        let answer = system.combine(s, |read, load| {
            let of = |sum: Complex, &(j, c): &(usize, f64)| sum + x[(j, load)] * c;
            system.output_rows[read].iter().fold(Complex::ZERO, of)
        });
        let finite = (0..answer.ncols()).all(|j| {
            answer
                .col_as_slice(j)
                .iter()
                .all(|z| z.re.is_finite() && z.im.is_finite())
        });
        if finite {
            Ok(answer)
        } else {
            Err(undamped_resonance_error(omega))
        }
    }

    /// `D(s)⁻¹ B`.
    fn solve(&self, s: Complex) -> Result<ComplexMatrix, Error> {
        let b = self.system.load_columns();
        solve_scaled(&self.entries, self.pattern.as_ref(), s, &b)
    }

    /// The limit at rest of a free machine: it accelerates as one under what does not balance, and deforms under the rest.
    ///
    /// With R its rigid motions, `K x + M R a = b`, `Rᵀ M x = 0`: `x → x + R a / s²`.
    fn static_response(&self) -> Result<ComplexMatrix, Error> {
        let system = &self.system;
        let (rigid, n) = (system.rigid, system.len());
        let b = system.load_columns();
        if system.undamped_rigid < rigid {
            let message = "a machine held only by dampers has no static response";
            return Err(Error::new(Code::Conflict, message)
                .with_hint("request frequencies above 0 Hz, or prescribe an angle: --hold NODE"));
        }
        let mut own = Matrix::zeros(rigid, rigid);
        let among = |e: &&StiffnessEntry| e.row < rigid && e.column < rigid;
        for e in self.entries.list.iter().filter(among) {
            own[(e.row, e.column)] = e.mass;
        }
        let push = Matrix::from_fn(rigid, b.ncols(), |i, j| b[(i, j)]);
        let a = symmetric::lu_solve(&own, &push)?;
        // The rest deforms: rows and columns of K beyond the rigid motions, which are exactly zero there.
        let rest = n - rigid;
        let mut f = Matrix::from_fn(rest, b.ncols(), |i, j| b[(rigid + i, j)]);
        let across = |e: &&StiffnessEntry| e.row >= rigid && e.column < rigid;
        for e in self.entries.list.iter().filter(across) {
            for j in 0..b.ncols() {
                f[(e.row - rigid, j)] -= e.mass * a[(e.column, j)];
            }
        }
        let k = self.entries.trailing_block(rigid);
        let bent = solve_scaled(&k, pattern(&k)?.as_ref(), Complex::ZERO, &f)?;
        let mut answer = ComplexMatrix::zeros(system.outputs.len(), system.inputs.len());
        for (o, terms) in system.outputs.iter().enumerate() {
            if self.sees_rigid_motion(terms) {
                let message = format!(
                    "`{}` has no value at 0 Hz: the machine is free to turn away",
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
                                .map(|&(j, c)| c * bent[(j - rigid, load)].re)
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
                answer[(o, i)] = Complex::new(sum + direct.map(|t| t.1).sum::<f64>(), 0.0);
            }
        }
        Ok(answer)
    }

    /// Whether rows for a displacement or a speed see a motion that strains nothing.
    fn sees_rigid_motion(&self, terms: &[(LaplaceFactor, usize)]) -> bool {
        let rigid = self.system.rigid;
        let turns = |row: usize| {
            let read = &self.system.output_rows[row];
            let largest = |count: usize| {
                let own = read.iter().filter(|term| term.0 < count);
                own.map(|term| term.1.abs()).fold(0.0, f64::max)
            };
            largest(rigid) > RIGID_TOLERANCE * largest(usize::MAX)
        };
        let mut terms = terms.iter().filter(|t| t.0.power < 2);
        terms.any(|&(_, row)| turns(row))
    }
}

/// The order in which a matrix is eliminated as a sparse one; nothing where it is small or full.
fn pattern(entries: &DynamicStiffness) -> Result<Option<SymbolicFactor>, Error> {
    let (n, list) = (entries.n, &entries.list);
    let sparse = n > DENSE_LIMIT && (list.len() as f64) < MAX_FILL * (n * n) as f64;
    let places = list.iter().map(|e| (e.row, e.column));
    sparse.then(|| SymbolicFactor::new(n, places)).transpose()
}

/// `D(s)⁻¹ B`, with D scaled to unit diagonal.
fn solve_scaled(
    entries: &DynamicStiffness,
    pattern: Option<&SymbolicFactor>,
    s: Complex,
    b: &Matrix,
) -> Result<ComplexMatrix, Error> {
    let n = entries.n;
    let mut scale = vec![1.0; n];
    for own in entries.list.iter().filter(|e| e.row == e.column) {
        let size = own.size(s);
        // A power of two, so that scaling rounds nothing.
        if size > 0.0 {
            scale[own.row] = (-0.5 * size.log2()).round().exp2();
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
            let mut full = ComplexMatrix::zeros(n, n);
            for e in &entries.list {
                full[(e.row, e.column)] = scaled(e);
            }
            symmetric::lu_solve_complex(&full, &right)?
        }
    };
    for j in 0..x.ncols() {
        let column = x.col_as_slice_mut(j).iter_mut();
        column.zip(&scale).for_each(|(x, scale)| *x *= *scale);
    }
    Ok(x)
}

/// Tolerance for rigid motions relative to the largest entry of a row: smaller entries are rounding of ratios that are fractions.
const RIGID_TOLERANCE: f64 = 1e-12;

/// Frequencies whose square times an inertia may leave the range of numbers, rad/s.
const MAX_OMEGA: f64 = 1e100;

/// Error of a system that is singular at a frequency, rad/s.
pub(super) fn undamped_resonance_error(omega: f64) -> Error {
    let at = format!("at {} Hz", format_number(omega / std::f64::consts::TAU));
    if omega > MAX_OMEGA {
        let message = format!("{at} the forces of inertia leave the range of numbers");
        return Error::new(Code::Overflow, message).with_hint("request lower frequencies");
    }
    let message = format!("{at} the machine is at a resonance that nothing damps");
    Error::new(Code::NotPositiveDefinite, message)
        .with_hint("give the machine its damping, or request another frequency")
}
