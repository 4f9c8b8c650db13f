//! Least-squares frequency domain (LSFD): residues, mode shapes and modal scaling for known poles.
//!
//! Ewins, Modal Testing, 2nd ed. (2000), §4.5; L (inertia line) and U (residual flexibility), both real, stand for the modes below and above.

use std::f64::consts::TAU;

use super::candidates::normalize_to_largest;
use super::measured_frf::MeasuredFrf;
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::symmetric::hermitian_eigen;
use crate::numeric::{Complex, ComplexMatrix, Matrix, lstsq};
use crate::spectrum::integrate::MotionQuantity;

/// Residues of every mode and the residual terms of the modes outside the band.
#[derive(Debug, Clone)]
pub struct ResidueFit {
    /// Poles of the upper half plane, rad/s, as given.
    pub poles: Vec<Complex>,
    /// `fit_residues[mode][(output, input)]`, of the receptance.
    pub residues: Vec<ComplexMatrix>,
    /// L, of the receptance, by output and input.
    pub lower_residual: Matrix,
    /// U, of the receptance, by output and input.
    pub upper_residual: Matrix,
    /// Measured motion quantity.
    pub motion: MotionQuantity,
}

/// Fits residues; all lines weigh the same.
///
/// # Errors
/// `IllPosed` without a pole, with one that is no pole of the upper half plane, or more unknowns than lines; those of the solver.
pub fn fit_residues(
    responses: &MeasuredFrf,
    poles: &[Complex],
    quantity: MotionQuantity,
) -> Result<ResidueFit, Error> {
    let is_pole = |p: &Complex| p.re.is_finite() && p.im.is_finite() && p.im > 0.0;
    if poles.is_empty() || !poles.iter().all(is_pole) {
        return Err(Error::new(
            Code::IllPosed,
            "residues need finite poles of the upper half plane, and at least one",
        )
        .with_hint("select poles first"));
    }
    let lines: Vec<usize> = (0..responses.n_lines())
        .filter(|&k| responses.frequency_hz()[k] > 0.0) // L/s² has no value at rest
        .collect();
    let n = lines.len();
    let scale = TAU * responses.band_limits_hz().1; // s and the poles in units of the last line, so that L and U stay in range
    let unknowns = 2 * poles.len() + 2;
    let mut basis = Matrix::zeros(2 * n, unknowns);
    for (row, &k) in lines.iter().enumerate() {
        let s = Complex::new(0.0, TAU * responses.frequency_hz()[k] / scale);
        for (column, value) in terms(s, poles, scale, quantity).into_iter().enumerate() {
            basis[(row, column)] = value.re;
            basis[(n + row, column)] = value.im;
        }
    }
    let (outputs, inputs) = (responses.n_outputs(), responses.n_inputs());
    let measured = Matrix::from_fn(2 * n, outputs * inputs, |i, column| {
        let h = responses.response(column / inputs, column % inputs);
        if i < n {
            h[lines[i]].re
        } else {
            h[lines[i - n]].im
        }
    });
    let x = lstsq::lstsq(&basis, &measured)?;
    // Units come back: H in s/scale has scale⁻ⁿ in it, residues another factor of scale, L its square.
    let unit = scale.powi(-quantity.derivative_order());
    let at = |row: usize, o: usize, i: usize| x[(row, o * inputs + i)] * unit;
    let residue = |r: usize| {
        ComplexMatrix::from_fn(outputs, inputs, |o, i| {
            Complex::new(at(2 * r, o, i), at(2 * r + 1, o, i)) * scale
        })
    };
    Ok(ResidueFit {
        poles: poles.to_vec(),
        residues: (0..poles.len()).map(residue).collect(),
        lower_residual: Matrix::from_fn(outputs, inputs, |o, i| {
            at(unknowns - 2, o, i) * scale * scale
        }),
        upper_residual: Matrix::from_fn(outputs, inputs, |o, i| at(unknowns - 1, o, i)),
        motion: quantity,
    })
}

/// Factors of Re R, Im R of every mode, of L and of U.
fn terms(s: Complex, poles: &[Complex], scale: f64, quantity: MotionQuantity) -> Vec<Complex> {
    let factor = s.powi(quantity.derivative_order());
    let mut terms = Vec::with_capacity(2 * poles.len() + 2);
    for &p in poles {
        let (above, below) = ((s - p / scale).inv(), (s - p.conj() / scale).inv());
        terms.push(factor * (above + below));
        terms.push(factor * Complex::I * (above - below));
    }
    terms.push(factor / (s * s));
    terms.push(factor);
    terms
}

impl ResidueFit {
    /// The fitted response of an output to an input at a frequency above 0, Hz.
    pub fn synthesise(&self, output: usize, input: usize, frequency_hz: f64) -> Complex {
        let s = Complex::new(0.0, TAU * frequency_hz);
        let mut sum =
            self.lower_residual[(output, input)] / (s * s) + self.upper_residual[(output, input)];
        for (p, r) in self.poles.iter().zip(&self.residues) {
            let r = r[(output, input)];
            sum += r / (s - p) + r.conj() / (s - p.conj());
        }
        sum * s.powi(self.motion.derivative_order())
    }

    /// Root mean square of what the fit misses of a measured response, over that of the response.
    pub fn misfit(&self, measured: &MeasuredFrf, output: usize, input: usize) -> f64 {
        let response = measured.response(output, input);
        let off: f64 = (response.iter().zip(measured.frequency_hz()))
            .map(|(h, &f)| (h - self.synthesise(output, input, f)).norm_sqr())
            .sum();
        let size: f64 = response.iter().map(Complex::norm_sqr).sum();
        (off / size).sqrt()
    }

    /// Shape and participation of a mode.
    ///
    /// # Errors
    /// As [`ModeShape::from_residues`].
    pub fn mode_shape(&self, mode: usize) -> Result<ModeShape, Error> {
        ModeShape::from_residues(&self.residues[mode])
    }

    /// Scale of a mode by a driving point, where output and input are the same degree of freedom with the same sign.
    ///
    /// # Errors
    /// As [`ResidueFit::mode_shape`]; `IllPosed` where the mode does not move the driving point.
    pub fn modal_scaling(
        &self,
        mode: usize,
        output: usize,
        input: usize,
    ) -> Result<ModalScaling, Error> {
        let ModeShape {
            shape,
            participation,
            ..
        } = self.mode_shape(mode)?;
        let residue = shape[output] * participation[input];
        let modal_a = shape[output] * shape[output] / residue;
        if !(modal_a.re.is_finite() && modal_a.im.is_finite()) {
            return Err(Error::new(
                Code::IllPosed,
                format!("mode {} has a node at its driving point", mode + 1),
            )
            .with_hint("choose another driving point"));
        }
        let modal_mass = (modal_a / Complex::new(0.0, 2.0 * self.poles[mode].im)).re;
        let root = modal_a.sqrt();
        Ok(ModalScaling {
            modal_a,
            modal_mass,
            unit_a_shape: shape.iter().map(|x| x / root).collect(),
        })
    }
}

/// A mode over outputs and inputs.
#[derive(Debug, Clone)]
pub struct ModeShape {
    /// Over the outputs, the largest component 1.
    pub shape: Vec<Complex>,
    /// Over the inputs, so that `residue ≈ shape · participationᵀ`.
    pub participation: Vec<Complex>,
    /// Share of the residues' sum of squares that rank one explains; 1 for a single mode or one input.
    pub rank_one_share: f64,
}

impl ModeShape {
    /// The matrix of rank one nearest the residues of a mode, by output and input.
    ///
    /// # Errors
    /// Those of the eigenproblem behind it.
    pub fn from_residues(residues: &ComplexMatrix) -> Result<ModeShape, Error> {
        let r = residues;
        let (values, vectors) = hermitian_eigen(&(r.adjoint() * r))?;
        let last = values.len() - 1;
        let v: Vec<Complex> = (0..=last).map(|i| vectors[(i, last)]).collect();
        let image = (0..r.nrows())
            .map(|o| (0..=last).fold(Complex::ZERO, |s, i| s + r[(o, i)] * v[i]))
            .collect::<Vec<_>>();
        let shape = normalize_to_largest(image.clone());
        let lead = (0..shape.len()).fold(0, |best, o| {
            if image[o].norm_sqr() > image[best].norm_sqr() {
                o
            } else {
                best
            }
        });
        let total: f64 = values.iter().map(|x| x.max(0.0)).sum();
        Ok(ModeShape {
            participation: v.iter().map(|v| v.conj() * image[lead]).collect(),
            rank_one_share: if total > 0.0 {
                values[last] / total
            } else {
                0.0
            },
            shape,
        })
    }
}

/// Absolute size of a mode.
#[derive(Debug, Clone)]
pub struct ModalScaling {
    /// `a` of `R = ψψᵀ/a` for the shape with largest component 1.
    pub modal_a: Complex,
    /// Modal mass of that shape, `Re[a/(2iω_d)]`, exact for proportional damping; in the unit of force over acceleration.
    pub modal_mass: f64,
    /// The shape with `a = 1`, that is `φᵀ(2λM + C)φ = 1`, as damped modes of a model are scaled.
    pub unit_a_shape: Vec<Complex>,
}
