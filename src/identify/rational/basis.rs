//! Basis functions of the rational fit over `s = jx`: `|p|/D` and `s/D` of each pole, `D = (s − p)(s − p*)`, the residuals `1/s²` and `1`.

use crate::numeric::{Complex, Matrix};

/// Pole pair `∓σ ± jw`, in units of the angular frequency of the highest line.
#[derive(Debug, Clone, Copy)]
pub(super) struct ScaledPole {
    /// Imaginary part, positive.
    pub w: f64,
    /// Magnitude of the real part, positive.
    pub sigma: f64,
    /// `true` if the real part is negative or zero.
    pub stable: bool,
}

/// Least magnitude of the real part of an initial estimate, in units of the highest line.
const MIN_REAL_PART: f64 = 1e-9;

impl ScaledPole {
    /// Scales a pole (rad/s) by the angular frequency of the highest line, `highest_omega` (rad/s).
    pub fn new(pole: Complex, highest_omega: f64) -> ScaledPole {
        ScaledPole {
            w: pole.im / highest_omega,
            sigma: (pole.re.abs() / highest_omega).max(MIN_REAL_PART),
            stable: pole.re <= 0.0,
        }
    }

    /// The pole of the upper half plane.
    pub fn value(&self) -> Complex {
        let sigma = if self.stable { -self.sigma } else { self.sigma };
        Complex::new(sigma, self.w)
    }

    /// Overlap `|⟨φ, φ′⟩|²` of the normalised Lorentzians of two poles on an infinite frequency axis, 0 to 1.
    pub fn overlap(&self, other: &ScaledPole) -> f64 {
        let (distance, width) = (self.w - other.w, self.sigma + other.sigma);
        4.0 * self.sigma * other.sigma / (distance * distance + width * width)
    }
}

/// Terms of a rational fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModelTerms {
    /// Residues are complex; else they are those of real modal constants.
    pub complex: bool,
    /// A term `1/s²` per response, for modes below the band.
    pub lower: bool,
    /// A constant per response, for modes above the band.
    pub upper: bool,
}

impl ModelTerms {
    /// Every term.
    pub const FULL: ModelTerms = ModelTerms {
        complex: true,
        lower: true,
        upper: true,
    };

    /// Number of real coefficients per response and pole pair.
    pub fn numerators(&self) -> usize {
        1 + usize::from(self.complex)
    }

    /// Number of real coefficients per response.
    pub fn columns(&self, poles: usize) -> usize {
        poles * self.numerators() + usize::from(self.lower) + usize::from(self.upper)
    }
}

/// Whitened least-squares problem: rows hold the real parts of the lines, then the imaginary parts, each with unit variance.
#[derive(Debug, Clone)]
pub(super) struct WhitenedProblem {
    /// Frequency of each line relative to the highest.
    pub x: Vec<f64>,
    /// Factor of the basis functions by line: the weight times the power of s of the response kind.
    pub factor: Vec<Complex>,
    /// Columns of the residual terms, which do not depend on the poles.
    pub pole_free_columns: Matrix,
    /// Whitened data, one column per response.
    pub y: Matrix,
    /// Index of the first column of `y` among the responses of the fit.
    pub first: usize,
    /// Median spacing of the measured lines, relative to the highest; the problem may use fewer lines.
    pub line_spacing: f64,
    /// `Σ y²` of the measured lines that the problem omits.
    pub omitted_energy: f64,
}

impl WhitenedProblem {
    /// Number of lines.
    pub fn lines(&self) -> usize {
        self.x.len()
    }

    /// Columns of the residual terms at relative frequencies `x`, with the factor of each line.
    pub fn residual_terms(x: &[f64], factor: &[Complex], structure: ModelTerms) -> Matrix {
        let n = x.len();
        let lower = |k: usize| -factor[k] / (x[k] * x[k]);
        let upper = |k: usize| factor[k];
        let terms: [(bool, &dyn Fn(usize) -> Complex); 2] =
            [(structure.lower, &lower), (structure.upper, &upper)];
        let included: Vec<_> = terms.iter().filter(|t| t.0).collect();
        let mut columns = Matrix::zeros(2 * n, included.len());
        for (j, (_, term)) in included.iter().enumerate() {
            let column = columns.col_as_slice_mut(j);
            for k in 0..n {
                set_complex(column, k, n, term(k));
            }
        }
        columns
    }

    /// Unscaled basis: the numerators of every pole, then the residual terms.
    pub fn basis(&self, poles: &[ScaledPole], numerators: usize) -> Matrix {
        let n = self.lines();
        let n_pole_columns = poles.len() * numerators;
        let mut basis = Matrix::zeros(2 * n, n_pole_columns + self.pole_free_columns.ncols());
        for (r, pole) in poles.iter().enumerate() {
            let size = pole.w.hypot(pole.sigma);
            for k in 0..n {
                let inverse = self.factor[k] * inverse(pole, self.x[k]);
                set_complex(basis.col_as_slice_mut(r * numerators), k, n, inverse * size);
                if numerators == 2 {
                    let s = Complex::new(0.0, self.x[k]);
                    set_complex(
                        basis.col_as_slice_mut(r * numerators + 1),
                        k,
                        n,
                        inverse * s,
                    );
                }
            }
        }
        for j in 0..self.pole_free_columns.ncols() {
            basis
                .col_as_slice_mut(n_pole_columns + j)
                .copy_from_slice(self.pole_free_columns.col_as_slice(j));
        }
        basis
    }

    /// Derivatives of the columns of each pole, divided by the column norms `length`: for every pole with respect to `w/σ`, then to
    /// `ln σ`; within each, by numerator.
    pub fn derivatives(&self, poles: &[ScaledPole], numerators: usize, length: &[f64]) -> Matrix {
        let n = self.lines();
        let mut derivatives = Matrix::zeros(2 * n, poles.len() * 2 * numerators);
        let mut square = vec![Complex::new(0.0, 0.0); n];
        for (r, pole) in poles.iter().enumerate() {
            let size = pole.w.hypot(pole.sigma);
            let sign = if pole.stable { 1.0 } else { -1.0 };
            for k in 0..n {
                let inverse = inverse(pole, self.x[k]);
                square[k] = self.factor[k] * inverse * inverse * (-2.0 * pole.sigma);
            }
            // The derivative by w/σ has the factor w, that by ln σ the factor σ ± s.
            for (a, (real, slope)) in [(pole.w, 0.0), (pole.sigma, sign)].into_iter().enumerate() {
                let at = (r * 2 + a) * numerators;
                let size_scale = size / length[r * numerators];
                let column = derivatives.col_as_slice_mut(at);
                for k in 0..n {
                    let d = square[k] * Complex::new(real, slope * self.x[k]);
                    set_complex(column, k, n, d * size_scale);
                }
                if numerators == 2 {
                    let s_scale = 1.0 / length[r * numerators + 1];
                    let column = derivatives.col_as_slice_mut(at + 1);
                    for k in 0..n {
                        let d = square[k] * Complex::new(real, slope * self.x[k]);
                        set_complex(column, k, n, d * Complex::new(0.0, self.x[k] * s_scale));
                    }
                }
            }
        }
        derivatives
    }
}

/// `1/D` at `s = jx`, with `D = w² − x² + σ² + 2jσx` factored to avoid cancellation near the resonance.
fn inverse(pole: &ScaledPole, x: f64) -> Complex {
    let sigma = if pole.stable { pole.sigma } else { -pole.sigma };
    let re = (pole.w - x) * (pole.w + x) + pole.sigma * pole.sigma;
    let im = 2.0 * sigma * x;
    let square = re * re + im * im;
    Complex::new(re / square, -im / square)
}

/// Residue `(a|p| + b p)/(2j Im p)` of pole `r`, in units of the highest line; `c` holds the coefficients of a response.
pub(super) fn residue(c: &[f64], pole: &ScaledPole, r: usize, numerators: usize) -> Complex {
    let p = pole.value();
    let mut numerator = Complex::new(c[r * numerators] * p.norm(), 0.0);
    if numerators == 2 {
        numerator += p * c[r * numerators + 1];
    }
    numerator / Complex::new(0.0, 2.0 * p.im)
}

/// Writes the real part to row `k` and the imaginary part to row `n + k`.
pub(super) fn set_complex(column: &mut [f64], k: usize, n: usize, value: Complex) {
    column[k] = value.re;
    column[n + k] = value.im;
}
