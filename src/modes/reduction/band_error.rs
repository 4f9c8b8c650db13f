//! Error of a reduced model over [0, f_max]: a-priori estimate and measured error.
//!
//! Estimate: with the primal and dual residuals `r = f − D T x` and r_d, the error of the response is to first order `r_dᵀ D_w⁻¹ r` over
//! the omitted modes. Below their lowest frequency ω_c it is bounded by `√(r_dᴴ G r_d) √(rᴴ G r) / (1 − ω²/ω_c²)`, with G their static
//! flexibility; it is infinite if the band reaches ω_c. Near resonances the first-order estimate is too large.

use super::method::{ReducedModel, ReductionMethod, natural_frequencies};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::modes::system_matrices::{AnalysisContext, SystemMatrices};
use crate::numeric::{Complex, ComplexMatrix, Matrix, symmetric};

/// Frequency band in which the responses are compared.
#[derive(Debug, Clone)]
pub struct ComparisonBand {
    /// Highest frequency of the band, Hz.
    pub f_max_hz: f64,
    /// Loaded degrees of freedom, as indices in the machine.
    pub inputs: Vec<usize>,
    /// Measured degrees of freedom, as indices in the machine.
    pub outputs: Vec<usize>,
    /// Number of logarithmically spaced frequencies over three decades, in addition to the natural frequencies.
    pub points: usize,
    /// Damping ratio ζ for an undamped machine, whose resonances are infinite: both responses are evaluated at `s = ω (i + ζ)`.
    pub damping_ratio: f64,
    /// Least denominator of the pointwise error, relative to the largest response.
    pub floor: f64,
}

impl ComparisonBand {
    /// Band up to `f_max_hz` (Hz) with 200 points, ζ = 0.01 and floor 1e-3.
    pub fn new(f_max_hz: f64, inputs: Vec<usize>, outputs: Vec<usize>) -> ComparisonBand {
        ComparisonBand {
            f_max_hz,
            inputs,
            outputs,
            points: 200,
            damping_ratio: 0.01,
            floor: 1e-3,
        }
    }
}

/// Largest relative error `max |H − H_r| / max |H|` of the transfer functions over a band.
///
/// H is the receptance; for free machines the accelerance, which is finite at zero frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandError {
    /// A-priori estimate; infinite if the band reaches the omitted modes.
    pub estimate: f64,
    /// Error measured on the frequency grid.
    pub measured: f64,
    /// Frequency of the largest measured error, Hz.
    pub worst_at_hz: f64,
    /// Largest pointwise error `|H − H_r| / max(|H|, floor · max |H|)`.
    pub pointwise: f64,
}

/// Largest number of coordinates of a full machine that is solved at every frequency.
const MAX_COORDINATES: usize = 1000;

impl ReducedModel {
    /// Estimated and measured error of the reduced model over a band.
    ///
    /// # Errors
    /// `OutOfRange` for an empty band; `BudgetExceeded` for a machine too large to be solved in full at every frequency.
    pub fn compare(
        &self,
        context: &AnalysisContext,
        band: &ComparisonBand,
    ) -> Result<BandError, Error> {
        if !(band.f_max_hz > 0.0 && band.f_max_hz.is_finite())
            || band.inputs.is_empty()
            || band.outputs.is_empty()
        {
            let message = format!(
                "a band up to {} Hz with {} inputs and {} outputs is empty",
                band.f_max_hz,
                band.inputs.len(),
                band.outputs.len()
            );
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("name at least one input and output, and a frequency above zero"));
        }
        if context.model.n > MAX_COORDINATES {
            let message = format!(
                "{} coordinates at {} frequencies exceed the limit",
                context.model.n, band.points
            );
            return Err(Error::new(Code::BudgetExceeded, message)
                .with_hint("measure the error on a part of the machine"));
        }
        let full = SystemMatrices::in_basis(
            context,
            Matrix::identity(context.model.n, context.model.n),
            Vec::new(),
            0,
        );
        let rows = |dofs: &[usize]| -> Vec<Vec<f64>> {
            dofs.iter()
                .map(|&f| full.project(&context.model.transform[f]))
                .collect()
        };
        let comparison = Comparison {
            full: &full,
            model: self,
            inputs: rows(&band.inputs),
            outputs: rows(&band.outputs),
        };
        let is_free = !context.model.rigid.is_empty();
        let grid = self.grid(context, band)?;
        let measure = |zeta: f64| -> Result<BandError, Error> {
            let point = |&omega: &f64| {
                let s = Complex::new(zeta * omega, omega);
                let scale = if is_free { s.norm().powi(2) } else { 1.0 };
                Ok((omega, comparison.evaluate(s, omega, scale)?))
            };
            let points = grid.iter().map(point).collect::<Result<Vec<_>, Error>>()?;
            Ok(summary(&points, band.floor))
        };
        if !full.is_dissipative() {
            return measure(band.damping_ratio);
        }
        // An undamped mode is infinite at its natural frequency; the comparison then uses s off the imaginary axis.
        match measure(0.0) {
            Err(error) if error.code == Code::NotPositiveDefinite => measure(band.damping_ratio),
            measured => measured,
        }
    }

    /// Logarithmically spaced frequencies and the natural frequencies of both models in the band, rad/s, increasing.
    fn grid(&self, context: &AnalysisContext, band: &ComparisonBand) -> Result<Vec<f64>, Error> {
        let max = band.f_max_hz * std::f64::consts::TAU;
        let n = band.points.max(2);
        let mut grid: Vec<f64> = (0..n)
            .map(|k| max * 10f64.powf(-3.0 * (1.0 - k as f64 / (n - 1) as f64)))
            .collect();
        grid.extend(context.basis.omega.iter().filter(|&&w| w > 0.0 && w < max));
        // Natural frequencies are not defined for a reduced model with massless coordinates; the grid then omits them.
        if let Ok(omega) = natural_frequencies(context.model, &self.matrices) {
            grid.extend(omega.iter().filter(|&&w| w > 0.0 && w < max));
        }
        if let ReductionMethod::Dynamic { at_hz, .. } = self.method {
            grid.extend(
                [at_hz * std::f64::consts::TAU]
                    .iter()
                    .filter(|&&w| w > 0.0 && w < max),
            );
        }
        grid.sort_by(f64::total_cmp);
        Ok(grid)
    }
}

/// Magnitude of the full response, of the error and of its estimate at one frequency, for every pair of output and input.
struct ComparisonPoint {
    full: Vec<f64>,
    error: Vec<f64>,
    estimate: Vec<f64>,
}

struct Comparison<'a> {
    full: &'a SystemMatrices,
    model: &'a ReducedModel,
    inputs: Vec<Vec<f64>>,
    outputs: Vec<Vec<f64>>,
}

impl Comparison<'_> {
    fn evaluate(&self, s: Complex, omega: f64, weight: f64) -> Result<ComparisonPoint, Error> {
        let d = self.full.dynamic_stiffness(s);
        let t = &self.model.matrices.transform;
        let loads = columns(&self.inputs, t.nrows());
        let x = symmetric::lu_solve_complex(&d, &loads)?;
        let d_r = self.model.matrices.dynamic_stiffness(s);
        let t_c = ComplexMatrix::from_fn(t.nrows(), t.ncols(), |i, j| Complex::new(t[(i, j)], 0.0));
        let expand = |d_r: &ComplexMatrix, rows: &[Vec<f64>]| -> Result<ComplexMatrix, Error> {
            Ok(&t_c
                * symmetric::lu_solve_complex(d_r, &(t_c.transpose() * columns(rows, t.nrows())))?)
        };
        let x_r = expand(&d_r, &self.inputs)?;
        let y_r = expand(&d_r.transpose().to_owned(), &self.outputs)?;
        let primal = self.residual_norm(&(&loads - &d * &x_r));
        let dual = self.residual_norm(&(columns(&self.outputs, t.nrows()) - d.transpose() * &y_r));
        let factor = self.amplification(omega);
        let mut point = ComparisonPoint {
            full: Vec::new(),
            error: Vec::new(),
            estimate: Vec::new(),
        };
        for (o, row) in self.outputs.iter().enumerate() {
            for i in 0..self.inputs.len() {
                let project = |x: &ComplexMatrix| -> Complex {
                    row.iter().enumerate().map(|(k, &a)| x[(k, i)] * a).sum()
                };
                let (h, h_r) = (project(&x), project(&x_r));
                point.full.push(weight * h.norm());
                point.error.push(weight * (h - h_r).norm());
                point.estimate.push(weight * factor * primal[i] * dual[o]);
            }
        }
        Ok(point)
    }

    /// Energy norm `√(rᴴ G r)` of each column.
    fn residual_norm(&self, r: &ComplexMatrix) -> Vec<f64> {
        let g = &self.model.flexibility;
        let norm = |j: usize| {
            let energy: Complex = (0..r.nrows())
                .map(|i| {
                    r[(i, j)].conj()
                        * (0..r.nrows())
                            .map(|k| r[(k, j)] * g[(i, k)])
                            .sum::<Complex>()
                })
                .sum();
            energy.re.max(0.0).sqrt()
        };
        (0..r.ncols()).map(norm).collect()
    }

    /// Dynamic amplification of the omitted modes at ω (relative to static).
    fn amplification(&self, omega: f64) -> f64 {
        match self.model.omitted.first() {
            None => 1.0,
            Some(&lowest) if omega >= lowest => f64::INFINITY,
            Some(&lowest) => 1.0 / (1.0 - (omega / lowest).powi(2)),
        }
    }
}

fn columns(rows: &[Vec<f64>], n: usize) -> ComplexMatrix {
    ComplexMatrix::from_fn(n, rows.len(), |i, j| Complex::new(rows[j][i], 0.0))
}

fn summary(points: &[(f64, ComparisonPoint)], floor: f64) -> BandError {
    let pairs = points.first().map_or(0, |p| p.1.full.len());
    let mut result = BandError {
        estimate: 0.0,
        measured: 0.0,
        worst_at_hz: 0.0,
        pointwise: 0.0,
    };
    for pair in 0..pairs {
        let largest = points.iter().map(|p| p.1.full[pair]).fold(0.0, f64::max);
        if largest == 0.0 {
            continue; // zero transfer function
        }
        for (omega, point) in points {
            let relative = point.error[pair] / largest;
            if relative > result.measured {
                result.measured = relative;
                result.worst_at_hz = omega / std::f64::consts::TAU;
            }
            result.estimate = result.estimate.max(point.estimate[pair] / largest);
            result.pointwise = result
                .pointwise
                .max(point.error[pair] / point.full[pair].max(floor * largest));
        }
    }
    result
}
