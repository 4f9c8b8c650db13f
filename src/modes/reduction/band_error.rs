//! Error of a reduced model over [0, f_max]: a-priori estimate and measured error.
//!
//! Estimate: with residuals `r = f − D T x` of load and measurement, the error of the response is to first order `r_dᵀ D_w⁻¹ r`
//! over what was left out, which below its lowest frequency ω_c is no larger than `√(r_dᴴ G r_d) √(rᴴ G r) / (1 − ω²/ω_c²)`,
//! G its static flexibility. Infinite where the band reaches ω_c. Near resonances the first order exaggerates.

use super::method::{ReducedModel, ReductionMethod, natural_frequencies};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::modes::system_matrices::{AnalysisContext, SystemMatrices};
use crate::numeric::{Complex, ComplexMatrix, Matrix, symmetric};

/// Frequency band in which the responses are compared.
#[derive(Debug, Clone)]
pub struct ComparisonBand {
    /// Up to here, Hz.
    pub f_max_hz: f64,
    /// Degrees of freedom that are loaded, by number in the machine.
    pub inputs: Vec<usize>,
    /// Degrees of freedom that are measured.
    pub outputs: Vec<usize>,
    /// Frequencies next to the natural ones, evenly over three decades by logarithm.
    pub points: usize,
    /// ζ that an undamped machine is compared with, by `s = ω (i + ζ)` in both responses; its own resonances are infinite.
    pub damping_ratio: f64,
    /// Responses below this share of the largest are compared with this share.
    pub floor: f64,
}

impl ComparisonBand {
    /// Between degrees of freedom, with 200 points, ζ = 0.01, floor 1e-3.
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

/// Relative error of the transfer functions over a band: of each, `max |H − H_r| / max |H|`; the worst of them.
///
/// H is displacement by force; for free machines acceleration by force, which is finite at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BandError {
    /// Estimated beforehand; infinite where the band reaches what was left out.
    pub estimate: f64,
    /// Measured on the grid.
    pub measured: f64,
    /// Frequency of the largest measured error, Hz.
    pub worst_at_hz: f64,
    /// The largest `|H − H_r| / max(|H|, floor · max |H|)` at one frequency.
    pub pointwise: f64,
}

/// Full machines beyond this many coordinates are not solved at hundreds of frequencies.
const MAX_COUNT: usize = 1000;

impl ReducedModel {
    /// Estimates and measures the error over a band.
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
                "a band to {} Hz with {} inputs and {} outputs is empty",
                band.f_max_hz,
                band.inputs.len(),
                band.outputs.len()
            );
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("name at least one input and output, and a frequency above zero"));
        }
        if context.model.n > MAX_COUNT {
            let message = format!(
                "{} coordinates would have to be solved at {} frequencies",
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
        let free = !context.model.rigid.is_empty();
        let grid = self.grid(context, band)?;
        let measure = |zeta: f64| -> Result<BandError, Error> {
            let at = |&omega: &f64| {
                let s = Complex::new(zeta * omega, omega);
                let scale = if free { s.norm().powi(2) } else { 1.0 };
                Ok((omega, comparison.evaluate(s, omega, scale)?))
            };
            let points = grid.iter().map(at).collect::<Result<Vec<_>, Error>>()?;
            Ok(summary(&points, band.floor))
        };
        if !full.is_dissipative() {
            return measure(band.damping_ratio);
        }
        // A mode that no damper sees is infinite at its own frequency; then all is compared next to the axis.
        match measure(0.0) {
            Err(error) if error.code == Code::NotPositiveDefinite => measure(band.damping_ratio),
            measured => measured,
        }
    }

    /// Frequencies by logarithm, and every natural one of both machines in the band, rad/s, rising.
    fn grid(&self, context: &AnalysisContext, band: &ComparisonBand) -> Result<Vec<f64>, Error> {
        let top = band.f_max_hz * std::f64::consts::TAU;
        let n = band.points.max(2);
        let mut grid: Vec<f64> = (0..n)
            .map(|k| top * 10f64.powf(-3.0 * (1.0 - k as f64 / (n - 1) as f64)))
            .collect();
        grid.extend(context.basis.omega.iter().filter(|&&w| w > 0.0 && w < top));
        // A reduced machine with massless coordinates left has no such list; the grid then goes without.
        if let Ok(own) = natural_frequencies(context.model, &self.matrices) {
            grid.extend(own.iter().filter(|&&w| w > 0.0 && w < top));
        }
        if let ReductionMethod::Dynamic { at_hz, .. } = self.method {
            grid.extend(
                [at_hz * std::f64::consts::TAU]
                    .iter()
                    .filter(|&&w| w > 0.0 && w < top),
            );
        }
        grid.sort_by(f64::total_cmp);
        Ok(grid)
    }
}

/// Both responses at one frequency, and the estimate of their difference: outputs by inputs.
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
        let expanded = |d_r: &ComplexMatrix, rows: &[Vec<f64>]| -> Result<ComplexMatrix, Error> {
            Ok(&t_c
                * symmetric::lu_solve_complex(d_r, &(t_c.transpose() * columns(rows, t.nrows())))?)
        };
        let x_r = expanded(&d_r, &self.inputs)?;
        let y_r = expanded(&d_r.transpose().to_owned(), &self.outputs)?;
        let primal = self.residual_norm(&(&loads - &d * &x_r));
        let dual = self.residual_norm(&(columns(&self.outputs, t.nrows()) - d.transpose() * &y_r));
        let beyond = self.amplification(omega);
        let mut point = ComparisonPoint {
            full: Vec::new(),
            error: Vec::new(),
            estimate: Vec::new(),
        };
        for (o, row) in self.outputs.iter().enumerate() {
            for i in 0..self.inputs.len() {
                let along = |x: &ComplexMatrix| -> Complex {
                    row.iter().enumerate().map(|(k, &a)| x[(k, i)] * a).sum()
                };
                let (h, h_r) = (along(&x), along(&x_r));
                point.full.push(weight * h.norm());
                point.error.push(weight * (h - h_r).norm());
                point.estimate.push(weight * beyond * primal[i] * dual[o]);
            }
        }
        Ok(point)
    }

    /// `√(rᴴ G r)` of each column.
    fn residual_norm(&self, r: &ComplexMatrix) -> Vec<f64> {
        let g = &self.model.flexibility;
        let of = |j: usize| {
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
        (0..r.ncols()).map(of).collect()
    }

    /// Dynamic amplification of the omitted modes at ω (relative to static).
    fn amplification(&self, omega: f64) -> f64 {
        match self.model.dropped.first() {
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
    let mut worst = BandError {
        estimate: 0.0,
        measured: 0.0,
        worst_at_hz: 0.0,
        pointwise: 0.0,
    };
    for pair in 0..pairs {
        let largest = points.iter().map(|p| p.1.full[pair]).fold(0.0, f64::max);
        if largest == 0.0 {
            continue; // nothing goes from this input to this output
        }
        for (omega, point) in points {
            let relative = point.error[pair] / largest;
            if relative > worst.measured {
                worst.measured = relative;
                worst.worst_at_hz = omega / std::f64::consts::TAU;
            }
            worst.estimate = worst.estimate.max(point.estimate[pair] / largest);
            worst.pointwise = worst
                .pointwise
                .max(point.error[pair] / point.full[pair].max(floor * largest));
        }
    }
    worst
}
