//! Frequency responses over lists of frequencies, one way or another, and how far the ways agree.

use std::time::Instant;

use super::direct::Direct;
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
    let plain = System::plain(setting, ports)?;
    let direct = Direct::new(&plain)?;
    let mut effort = Effort {
        coordinates: plain.len(),
        ..Effort::default()
    };
    if way == Way::Modal {
        let (modal, basis) = System::modal(setting, ports)?;
        if let Some(modes) = Modes::new(&modal, &basis)? {
            let lines = |&w: &f64| {
                if w == 0.0 && plain.n_rigid() > 0 {
                    direct.at(w)
                } else {
                    finite(modes.at(w), w)
                }
            };
            let values = omega.iter().map(lines).collect::<Result<Vec<_>, Error>>()?;
            let checked = some(omega.len());
            let error = difference(&direct, omega, &values, &checked)?;
            effort.checked = checked.len();
            effort.seconds = start.elapsed().as_secs_f64();
            if error <= TRUSTED {
                effort.error = Some(error);
                let how = if modes.is_complex() {
                    How::ComplexModes
                } else {
                    How::RealModes
                };
                return Ok(Responses {
                    omega: omega.to_vec(),
                    values,
                    how,
                    effort,
                });
            }
            effort.given_up = Some(error);
        }
    }
    let values = omega
        .iter()
        .map(|&w| direct.at(w))
        .collect::<Result<Vec<_>, Error>>()?;
    effort.seconds = start.elapsed().as_secs_f64();
    let how = if direct.is_sparse() {
        How::Sparse
    } else {
        How::Dense
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

fn difference(
    direct: &Direct,
    omega: &[f64],
    values: &[ComplexMatrix],
    at: &[usize],
) -> Result<f64, Error> {
    let exact = at
        .iter()
        .map(|&line| direct.at(omega[line]))
        .collect::<Result<Vec<_>, Error>>()?;
    let Some(first) = exact.first() else {
        return Ok(0.0);
    };
    let mut worst = 0.0f64;
    for o in 0..first.nrows() {
        for i in 0..first.ncols() {
            let largest = exact.iter().map(|e| modulus(e[(o, i)])).fold(0.0, f64::max);
            let off = at
                .iter()
                .zip(&exact)
                .map(|(&line, e)| modulus(values[line][(o, i)] - e[(o, i)]))
                .fold(0.0, f64::max);
            if off > 0.0 {
                worst = worst.max(off / largest);
            }
        }
    }
    Ok(worst)
}

fn finite(value: ComplexMatrix, omega: f64) -> Result<ComplexMatrix, Error> {
    let is = |z: &Complex| z.re.is_finite() && z.im.is_finite();
    if (0..value.ncols()).all(|j| value.col_as_slice(j).iter().all(is)) {
        return Ok(value);
    }
    let message = format!(
        "at {} Hz the machine is at a resonance that nothing damps",
        omega / std::f64::consts::TAU
    );
    Err(Error::new(Code::Indefinite, message)
        .hint("give the machine its damping, or ask beside this frequency"))
}
