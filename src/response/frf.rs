//! Frequency response matrix by direct solution or by modal superposition, which is verified at check frequencies.

use std::time::Instant;

use super::direct::{DirectSolver, undamped_resonance_error};
use super::modal::ModalSum;
use super::ports::Ports;
use super::system::{InputOutputSystem, OperatingModel};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::modes::mode::modulus;
use crate::numeric::{Complex, ComplexMatrix};

/// Solution method of frequency responses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResponseMethod {
    /// Direct solution with the dynamic stiffness at every frequency line.
    Direct,
    /// Superposition of all modes.
    Modal,
}

/// Frequency response matrices over frequency.
#[derive(Debug, Clone)]
pub struct FrfMatrix {
    /// Frequencies, rad/s.
    pub omega: Vec<f64>,
    /// Frequency responses, outputs by inputs, one matrix per frequency.
    pub values: Vec<ComplexMatrix>,
    /// Solver used.
    pub solver: SolverKind,
    /// Size, checks and accuracy of the solution.
    pub stats: ResponseStats,
}

/// Solver of the frequency responses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SolverKind {
    /// Direct solution with dense matrices.
    Dense,
    /// Direct solution with sparse matrices.
    Sparse,
    /// Superposition of real modes.
    RealModes,
    /// Superposition of complex modes.
    ComplexModes,
}

/// Size of a frequency-response solution, its checks and its accuracy.
#[derive(Debug, Clone, Copy, Default)]
pub struct ResponseStats {
    /// Number of coordinates.
    pub coordinates: usize,
    /// Number of check frequencies with a direct solution.
    pub checked: usize,
    /// Largest error of the modal sum at the check frequencies, relative to the largest response of the same output and input; `None` for a
    /// direct solution.
    pub error: Option<f64>,
    /// Error for which the modal sum was rejected in favour of the direct solution.
    pub rejected_error: Option<f64>,
    /// Computing time, s.
    pub seconds: f64,
}

/// Number of frequencies at which the modal sum is compared with the direct solution.
const CHECK_LINES: usize = 5;

/// Largest accepted relative error of the modal sum.
const MAX_MODAL_ERROR: f64 = 1e-8;

/// Frequency-response solver of a machine between its inputs and outputs.
pub struct ResponseSolver {
    direct: DirectSolver,
    modes: Option<ModalSum>,
    /// Size, checks and accuracy of the solution.
    pub stats: ResponseStats,
}

impl ResponseSolver {
    /// Assembles the equations and, for the modal method, decouples them into modes if possible.
    ///
    /// # Errors
    /// Conflicting prescribed motions; a displacement imposed in a branch without stiffness; errors of the modes.
    pub fn new(
        model: &OperatingModel,
        ports: &Ports,
        method: ResponseMethod,
    ) -> Result<ResponseSolver, Error> {
        let direct = DirectSolver::new(model, ports)?;
        let modes = match method {
            ResponseMethod::Direct => None,
            ResponseMethod::Modal => {
                let (system, equations, basis) = InputOutputSystem::modal_system(model, ports)?;
                ModalSum::new(system, &equations, &basis)?
            }
        };
        let stats = ResponseStats {
            coordinates: direct.system().len(),
            ..ResponseStats::default()
        };
        Ok(ResponseSolver {
            direct,
            modes,
            stats,
        })
    }

    /// Solver in use.
    pub fn kind(&self) -> SolverKind {
        match &self.modes {
            Some(modes) if modes.is_complex() => SolverKind::ComplexModes,
            Some(_) => SolverKind::RealModes,
            None if self.direct.is_sparse() => SolverKind::Sparse,
            None => SolverKind::Dense,
        }
    }

    /// Frequency response, outputs by inputs, at ω, rad/s.
    ///
    /// # Errors
    /// Outputs of a free machine without a static value; undamped resonances.
    pub fn response_at(&self, omega: f64) -> Result<ComplexMatrix, Error> {
        match &self.modes {
            Some(modes) if omega > 0.0 || self.direct.system().n_rigid() == 0 => {
                finite(modes.response_at(omega), omega)
            }
            _ => self.direct.response_at(omega),
        }
    }

    /// Compares the modal sum with the direct solution at check frequencies out of `omega`, rad/s, and drops it if they differ.
    ///
    /// # Errors
    /// Errors of [`ResponseSolver::response_at`].
    pub fn check(&mut self, omega: &[f64]) -> Result<(), Error> {
        if self.modes.is_none() {
            return Ok(());
        }
        let checked: Vec<f64> = check_lines(omega.len())
            .into_iter()
            .map(|k| omega[k])
            .collect();
        let responses = |solve: &dyn Fn(f64) -> Result<ComplexMatrix, Error>| {
            checked
                .iter()
                .map(|&w| solve(w))
                .collect::<Result<Vec<_>, Error>>()
        };
        let error = difference(
            &responses(&|w| self.response_at(w))?,
            &responses(&|w| self.direct.response_at(w))?,
        );
        self.stats.checked = checked.len();
        if error <= MAX_MODAL_ERROR {
            self.stats.error = Some(error);
        } else {
            self.stats.rejected_error = Some(error);
            self.modes = None;
        }
        Ok(())
    }
}

/// Frequency responses between all inputs and outputs at the frequencies `omega`, rad/s, zero or positive.
///
/// A modal sum is compared with the direct solution at check frequencies and dropped if they differ.
///
/// # Errors
/// Negative or infinite frequencies; a static response of a free machine; undamped resonances; conflicting prescribed motions. Unknown
/// names are rejected by [`Ports::parse`].
pub fn frf_matrix(
    model: &OperatingModel,
    ports: &Ports,
    omega: &[f64],
    method: ResponseMethod,
) -> Result<FrfMatrix, Error> {
    let start = Instant::now();
    if let Some(invalid) = omega.iter().find(|w| !(w.is_finite() && **w >= 0.0)) {
        let message = format!("a frequency of {invalid} rad/s is invalid");
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("give finite frequencies of zero or more"));
    }
    let mut solver = ResponseSolver::new(model, ports, method)?;
    solver.check(omega)?;
    let values = omega
        .iter()
        .map(|&w| solver.response_at(w))
        .collect::<Result<Vec<_>, Error>>()?;
    let kind = solver.kind();
    let stats = ResponseStats {
        seconds: start.elapsed().as_secs_f64(),
        ..solver.stats
    };
    Ok(FrfMatrix {
        omega: omega.to_vec(),
        values,
        solver: kind,
        stats,
    })
}

/// Indices of the check frequencies, evenly distributed.
fn check_lines(lines: usize) -> Vec<usize> {
    let count = CHECK_LINES.min(lines);
    (0..count)
        .map(|k| (2 * k + 1) * lines / (2 * count))
        .collect()
}

/// Largest error relative to the largest exact value of the same output and input.
pub fn difference(values: &[ComplexMatrix], exact: &[ComplexMatrix]) -> f64 {
    let Some(first) = exact.first() else {
        return 0.0;
    };
    let mut largest_error = 0.0f64;
    for o in 0..first.nrows() {
        for i in 0..first.ncols() {
            let largest = exact.iter().map(|e| modulus(e[(o, i)])).fold(0.0, f64::max);
            let error = |(v, e): (&ComplexMatrix, &ComplexMatrix)| modulus(v[(o, i)] - e[(o, i)]);
            let error_max = values.iter().zip(exact).map(error).fold(0.0, f64::max);
            if error_max > 0.0 {
                largest_error = largest_error.max(error_max / largest);
            }
        }
    }
    largest_error
}

fn finite(value: ComplexMatrix, omega: f64) -> Result<ComplexMatrix, Error> {
    let is_finite = |z: &Complex| z.re.is_finite() && z.im.is_finite();
    if (0..value.ncols()).all(|j| value.col_as_slice(j).iter().all(is_finite)) {
        return Ok(value);
    }
    Err(undamped_resonance_error(omega))
}
