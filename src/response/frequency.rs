//! Frequency responses over lists of frequencies, one way or another, and how far the ways agree.

use std::time::Instant;

use super::direct::{Direct, resonance};
use super::modal::Modes;
use super::ports::Ports;
use super::system::{Setting, System};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::modes::mode::modulus;
use crate::numeric::{Complex, ComplexMatrix};

/// How responses are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Way {
    /// The dynamic stiffness solved at every line.
    Direct,
    /// A sum over all modes.
    Modal,
}

/// Frequency responses.
#[derive(Debug, Clone)]
pub struct Responses {
    /// rad/s.
    pub omega: Vec<f64>,
    /// Outputs by inputs, line by line.
    pub values: Vec<ComplexMatrix>,
    /// What was done.
    pub how: How,
    /// What it took.
    pub effort: Effort,
}

/// What was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum How {
    /// Dense matrices, line by line.
    Dense,
    /// Sparse matrices, line by line.
    Sparse,
    /// Real modes.
    RealModes,
    /// Complex modes.
    ComplexModes,
}

/// What an answer took, and what it is worth.
#[derive(Debug, Clone, Copy, Default)]
pub struct Effort {
    /// Coordinates solved for.
    pub coordinates: usize,
    /// Lines that were solved directly as well.
    pub checked: usize,
    /// Largest difference there, of the largest value of the same output and input at those lines; absent where lines were
    /// solved directly in the first place.
    pub error: Option<f64>,
    /// The modes were given up for the direct solution, since they differed by so much.
    pub given_up: Option<f64>,
    /// s.
    pub seconds: f64,
}

/// Lines at which a sum over modes is compared with the direct solution.
const CHECKS: usize = 5;

/// Differences from the direct solution beyond this give the modes up.
const TRUSTED: f64 = 1e-8;

/// A machine between its inputs and outputs, ready to be asked at any frequency.
pub struct Solver {
    direct: Direct,
    modes: Option<Modes>,
    /// What it takes, and what it is worth.
    pub effort: Effort,
}

impl Solver {
    /// Sets up the equations, and takes them apart into modes where these are wanted and come apart.
    ///
    /// # Errors
    /// Prescribed motions that exclude each other; a displacement imposed where nothing carries it; those of the modes.
    pub fn new(setting: &Setting, ports: &Ports, way: Way) -> Result<Solver, Error> {
        let direct = Direct::new(setting, ports)?;
        let modes = match way {
            Way::Direct => None,
            Way::Modal => {
                let (system, equations, basis) = System::modal(setting, ports)?;
                Modes::new(system, &equations, &basis)?
            }
        };
        let effort = Effort {
            coordinates: direct.system().len(),
            ..Effort::default()
        };
        Ok(Solver {
            direct,
            modes,
            effort,
        })
    }

    /// How it answers.
    pub fn how(&self) -> How {
        match &self.modes {
            Some(modes) if modes.is_complex() => How::ComplexModes,
            Some(_) => How::RealModes,
            None if self.direct.is_sparse() => How::Sparse,
            None => How::Dense,
        }
    }

    /// Outputs by inputs at ω, rad/s.
    ///
    /// # Errors
    /// At rest what a free machine does not have; undamped resonances.
    pub fn at(&self, omega: f64) -> Result<ComplexMatrix, Error> {
        match &self.modes {
            Some(modes) if omega > 0.0 || self.direct.system().n_rigid() == 0 => {
                finite(modes.at(omega), omega)
            }
            _ => self.direct.at(omega),
        }
    }

    /// Compares the sum over modes with direct solutions at a few of the lines, and gives it up where they differ.
    ///
    /// # Errors
    /// Those of [`Solver::at`].
    pub fn check(&mut self, omega: &[f64]) -> Result<(), Error> {
        if self.modes.is_none() {
            return Ok(());
        }
        let checked: Vec<f64> = some(omega.len()).into_iter().map(|k| omega[k]).collect();
        let of = |at: &dyn Fn(f64) -> Result<ComplexMatrix, Error>| {
            checked
                .iter()
                .map(|&w| at(w))
                .collect::<Result<Vec<_>, Error>>()
        };
        let error = difference(&of(&|w| self.at(w))?, &of(&|w| self.direct.at(w))?);
        self.effort.checked = checked.len();
        if error <= TRUSTED {
            self.effort.error = Some(error);
        } else {
            self.effort.given_up = Some(error);
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
/// Names of nothing are found earlier, by [`Ports::read`]; here: frequencies that cannot be; lines at rest of a free machine;
/// undamped resonances; prescribed motions that exclude each other.
pub fn responses(
    setting: &Setting,
    ports: &Ports,
    omega: &[f64],
    way: Way,
) -> Result<Responses, Error> {
    let start = Instant::now();
    if let Some(bad) = omega.iter().find(|w| !(w.is_finite() && **w >= 0.0)) {
        let message = format!("a frequency of {bad} rad/s cannot be");
        return Err(
            Error::new(Code::OutOfRange, message).hint("frequencies are finite, and zero or above")
        );
    }
    let mut solver = Solver::new(setting, ports, way)?;
    solver.check(omega)?;
    let values = omega
        .iter()
        .map(|&w| solver.at(w))
        .collect::<Result<Vec<_>, Error>>()?;
    let how = solver.how();
    let effort = Effort {
        seconds: start.elapsed().as_secs_f64(),
        ..solver.effort
    };
    Ok(Responses {
        omega: omega.to_vec(),
        values,
        how,
        effort,
    })
}

/// A few lines, spread evenly.
fn some(lines: usize) -> Vec<usize> {
    let count = CHECKS.min(lines);
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
    Err(resonance(omega))
}
