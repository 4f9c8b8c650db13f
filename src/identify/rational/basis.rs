//! Basis functions of the rational fit over `s = jx`: `|p|/D` and `s/D` of each pole, `D = (s − p)(s − p*)`, the residuals `1/s²` and `1`.

use crate::numeric::{Complex, Matrix};

/// A pole pair `∓σ ± jw`, in units of the highest line's angular frequency.
#[derive(Debug, Clone, Copy)]
pub(super) struct ScaledPole {
    /// Imaginary part, positive.
    pub w: f64,
    /// Size of the real part, positive.
    pub sigma: f64,
    /// The real part is negative.
    pub stable: bool,
}

/// A start needs a width; in units of the highest line.
const MIN_REAL_PART: f64 = 1e-9;

impl ScaledPole {
    /// From rad/s, `top` being the angular frequency of the highest line.
    pub fn new(pole: Complex, top: f64) -> ScaledPole {
        ScaledPole {
            w: pole.im / top,
            sigma: (pole.re.abs() / top).max(MIN_REAL_PART),
            stable: pole.re <= 0.0,
        }
    }

    /// The pole of the upper half plane.
    pub fn value(&self) -> Complex {
        let sigma = if self.stable { -self.sigma } else { self.sigma };
        Complex::new(sigma, self.w)
    }

    /// Share of the Lorentzian of `other` that this one holds, `|⟨φ, φ′⟩|²` of unit functions on an infinite axis.
    pub fn overlap(&self, other: &ScaledPole) -> f64 {
        let (apart, wide) = (self.w - other.w, self.sigma + other.sigma);
        4.0 * self.sigma * other.sigma / (apart * apart + wide * wide)
    }
}

/// Which terms a fit has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModelTerms {
    /// Residues are free complex numbers; else they are those of real modal constants.
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

    /// Real numbers per response and pole pair.
    pub fn numerators(&self) -> usize {
        1 + usize::from(self.complex)
    }

    /// Real numbers per response.
    pub fn columns(&self, poles: usize) -> usize {
        poles * self.numerators() + usize::from(self.lower) + usize::from(self.upper)
    }
}

/// Whitened lines and data: rows hold real parts, then imaginary parts, each with unit variance.
#[derive(Debug, Clone)]
pub(super) struct WhitenedProblem {
    /// Frequency over the highest line's.
    pub x: Vec<f64>,
    /// Factor of every basis function by line: the power of s of the kind of response, and the weight.
    pub factor: Vec<Complex>,
    /// Columns without poles.
    pub pole_free_columns: Matrix,
    /// Data by response.
    pub y: Matrix,
    /// Place of the first column of `y` among the responses of the fit.
    pub first: usize,
    /// Median spacing of the measured lines, of which these may be fewer.
    pub line_spacing: f64,
    /// `Σ y²` of the measured lines beyond that of these.
    pub omitted_energy: f64,
}

impl WhitenedProblem {
    /// Lines.
    pub fn lines(&self) -> usize {
        self.x.len()
    }

    /// The columns without poles of a structure.
    pub fn residual_terms(x: &[f64], factor: &[Complex], structure: ModelTerms) -> Matrix {
        let n = x.len();
        let lower = |k: usize| -factor[k] / (x[k] * x[k]);
        let upper = |k: usize| factor[k];
        let terms: [(bool, &dyn Fn(usize) -> Complex); 2] =
            [(structure.lower, &lower), (structure.upper, &upper)];
        let used: Vec<_> = terms.iter().filter(|t| t.0).collect();
        let mut fixed = Matrix::zeros(2 * n, used.len());
        for (j, (_, term)) in used.iter().enumerate() {
            let column = fixed.col_as_slice_mut(j);
            for k in 0..n {
                set_complex(column, k, n, term(k));
            }
        }
        fixed
    }

    /// Unscaled basis: numerators of every pole, then the fixed columns.
    pub fn basis(&self, poles: &[ScaledPole], numerators: usize) -> Matrix {
        let n = self.lines();
        let of_poles = poles.len() * numerators;
        let mut basis = Matrix::zeros(2 * n, of_poles + self.pole_free_columns.ncols());
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
                .col_as_slice_mut(of_poles + j)
                .copy_from_slice(self.pole_free_columns.col_as_slice(j));
        }
        basis
    }

    /// Derivatives of the poles' columns, each divided by that column's length: for every pole with respect to `w/σ`, then to
    /// `ln σ`; within each, by numerator.
    pub fn derivatives(&self, poles: &[ScaledPole], numerators: usize, length: &[f64]) -> Matrix {
        let n = self.lines();
        let mut all = Matrix::zeros(2 * n, poles.len() * 2 * numerators);
        let mut square = vec![Complex::new(0.0, 0.0); n];
        for (r, pole) in poles.iter().enumerate() {
            let size = pole.w.hypot(pole.sigma);
            let sign = if pole.stable { 1.0 } else { -1.0 };
            for k in 0..n {
                let inverse = inverse(pole, self.x[k]);
                square[k] = self.factor[k] * inverse * inverse * (-2.0 * pole.sigma);
            }
            // By w/σ, then by ln σ: times w, and times σ ± s.
            for (a, (fixed, turned)) in [(pole.w, 0.0), (pole.sigma, sign)].into_iter().enumerate()
            {
                let at = (r * 2 + a) * numerators;
                let of_size = size / length[r * numerators];
                let column = all.col_as_slice_mut(at);
                for k in 0..n {
                    let d = square[k] * Complex::new(fixed, turned * self.x[k]);
                    set_complex(column, k, n, d * of_size);
                }
                if numerators == 2 {
                    let of_s = 1.0 / length[r * numerators + 1];
                    let column = all.col_as_slice_mut(at + 1);
                    for k in 0..n {
                        let d = square[k] * Complex::new(fixed, turned * self.x[k]);
                        set_complex(column, k, n, d * Complex::new(0.0, self.x[k] * of_s));
                    }
                }
            }
        }
        all
    }
}

/// `1/D` at `s = jx`, with `D = w² − x² + σ² + 2jσx` written so that nothing cancels near the resonance.
fn inverse(pole: &ScaledPole, x: f64) -> Complex {
    let sigma = if pole.stable { pole.sigma } else { -pole.sigma };
    let re = (pole.w - x) * (pole.w + x) + pole.sigma * pole.sigma;
    let im = 2.0 * sigma * x;
    let square = re * re + im * im;
    Complex::new(re / square, -im / square)
}

/// `(a|p| + b p)/(2j Im p)` in units of the highest line.
pub(super) fn residue(c: &[f64], pole: &ScaledPole, r: usize, numerators: usize) -> Complex {
    let p = pole.value();
    let mut top = Complex::new(c[r * numerators] * p.norm(), 0.0);
    if numerators == 2 {
        top += p * c[r * numerators + 1];
    }
    top / Complex::new(0.0, 2.0 * p.im)
}

/// Real part to row `k`, imaginary part to row `n + k`.
pub(super) fn set_complex(column: &mut [f64], k: usize, n: usize, value: Complex) {
    column[k] = value.re;
    column[n + k] = value.im;
}
