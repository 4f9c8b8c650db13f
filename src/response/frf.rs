//! Frequency response matrix by direct solution or by modal sum, with a check of the sum.

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
    /// The dynamic stiffness solved at every line.
    Direct,
    /// A sum over all modes.
    Modal,
}

/// Frequency response matrices, outputs by inputs, line by line.
#[derive(Debug, Clone)]
pub struct FrfMatrix {
    /// rad/s.
    pub omega: Vec<f64>,
    /// Outputs by inputs, line by line.
    pub values: Vec<ComplexMatrix>,
    /// Solver that was used.
    pub solver: SolverKind,
    /// Size, checks and accuracy of the solution.
    pub stats: ResponseStats,
}

/// Solver of the frequency responses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SolverKind {
    /// Dense matrices, line by line.
    Dense,
    /// Sparse matrices, line by line.
    Sparse,
    /// Real modes.
    RealModes,
    /// Complex modes.
    ComplexModes,
}

/// Size of a frequency-response solution, its checks and its accuracy.
#[derive(Debug, Clone, Copy, Default)]
pub struct ResponseStats {
    /// Coordinates solved for.
    pub coordinates: usize,
    /// Lines that were solved directly as well.
    pub checked: usize,
    /// Largest difference there, of the largest value of the same output and input at those lines; absent where lines were
    /// solved directly in the first place.
    pub error: Option<f64>,
    /// The modes were given up for the direct solution, since they differed by so much.
    pub rejected_error: Option<f64>,
    /// s.
    pub seconds: f64,
}

/// Lines at which a sum over modes is compared with the direct solution.
const CHECK_LINES: usize = 5;

/// Differences from the direct solution beyond this give the modes up.
const MAX_MODAL_ERROR: f64 = 1e-8;

/// A machine between its inputs and outputs, ready to be evaluated at any frequency.
pub struct ResponseSolver {
    direct: DirectSolver,
    modes: Option<ModalSum>,
    /// Size, checks and accuracy of the solution.
    pub stats: ResponseStats,
}

impl ResponseSolver {
    /// Sets up the equations, and takes them apart into modes where these are wanted and come apart.
    ///
    /// # Errors
    /// Prescribed motions that exclude each other; a displacement imposed where nothing carries it; those of the modes.
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

    /// Kind of solver in use.
    pub fn kind(&self) -> SolverKind {
        match &self.modes {
            Some(modes) if modes.is_complex() => SolverKind::ComplexModes,
            Some(_) => SolverKind::RealModes,
            None if self.direct.is_sparse() => SolverKind::Sparse,
            None => SolverKind::Dense,
        }
    }

    /// Outputs by inputs at ω, rad/s.
    ///
    /// # Errors
    /// At rest what a free machine does not have; undamped resonances.
    pub fn response_at(&self, omega: f64) -> Result<ComplexMatrix, Error> {
        match &self.modes {
            Some(modes) if omega > 0.0 || self.direct.system().n_rigid() == 0 => {
                finite(modes.response_at(omega), omega)
            }
            _ => self.direct.response_at(omega),
        }
    }

    /// Compares the sum over modes with direct solutions at a few of the lines, and gives it up where they differ.
    ///
    /// # Errors
    /// Those of [`ResponseSolver::response_at`].
    pub fn check(&mut self, omega: &[f64]) -> Result<(), Error> {
        if self.modes.is_none() {
            return Ok(());
        }
        let checked: Vec<f64> = check_lines(omega.len())
            .into_iter()
            .map(|k| omega[k])
            .collect();
        let of = |at: &dyn Fn(f64) -> Result<ComplexMatrix, Error>| {
            checked
                .iter()
                .map(|&w| at(w))
                .collect::<Result<Vec<_>, Error>>()
        };
        let error = difference(
            &of(&|w| self.response_at(w))?,
            &of(&|w| self.direct.response_at(w))?,
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

/// Responses between all inputs and outputs at the frequencies `omega`, rad/s, none negative.
///
/// A sum over modes is compared with direct solutions at a few lines, and given up where they differ.
///
/// # Errors
/// Names of nothing are found earlier, by [`Ports::parse`]; here: frequencies that cannot be; lines at rest of a free machine;
/// undamped resonances; prescribed motions that exclude each other.
pub fn frf_matrix(
    model: &OperatingModel,
    ports: &Ports,
    omega: &[f64],
    method: ResponseMethod,
) -> Result<FrfMatrix, Error> {
    let start = Instant::now();
    if let Some(bad) = omega.iter().find(|w| !(w.is_finite() && **w >= 0.0)) {
        let message = format!("a frequency of {bad} rad/s cannot be");
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("frequencies are finite, and zero or above"));
    }
    let mut solver = ResponseSolver::new(model, ports, method)?;
    solver.check(omega)?;
    let values = omega
        .iter()
        .map(|&w| solver.response_at(w))
        .collect::<Result<Vec<_>, Error>>()?;
    let how = solver.kind();
    let stats = ResponseStats {
        seconds: start.elapsed().as_secs_f64(),
        ..solver.stats
    };
    Ok(FrfMatrix {
        omega: omega.to_vec(),
        values,
        solver: how,
        stats,
    })
}

/// A few lines, spread evenly.
fn check_lines(lines: usize) -> Vec<usize> {
    let count = CHECK_LINES.min(lines);
    (0..count)
        .map(|k| (2 * k + 1) * lines / (2 * count))
        .collect()
}

/// The largest difference, of the largest exact value of the same output and input.
pub fn difference(values: &[ComplexMatrix], exact: &[ComplexMatrix]) -> f64 {
    let Some(first) = exact.first() else {
        return 0.0;
    };
    let mut worst = 0.0f64;
    for o in 0..first.nrows() {
        for i in 0..first.ncols() {
            let largest = exact.iter().map(|e| modulus(e[(o, i)])).fold(0.0, f64::max);
            let apart = |(v, e): (&ComplexMatrix, &ComplexMatrix)| modulus(v[(o, i)] - e[(o, i)]);
            let off = values.iter().zip(exact).map(apart).fold(0.0, f64::max);
            if off > 0.0 {
                worst = worst.max(off / largest);
            }
        }
    }
    worst
}

fn finite(value: ComplexMatrix, omega: f64) -> Result<ComplexMatrix, Error> {
    let is = |z: &Complex| z.re.is_finite() && z.im.is_finite();
    if (0..value.ncols()).all(|j| value.col_as_slice(j).iter().all(is)) {
        return Ok(value);
    }
    Err(undamped_resonance_error(omega))
}
