//! State-space realisation `ẋ = A x + B u`, `y = C x + D u` in real modal blocks.
//!
//! A pair `p = σ ± iω` with the residues `R = l rᵀ` of outputs by inputs: `ż = p z + rᵀu`, `y = 2 Re l z`, in real and
//! imaginary part `A = [σ −ω; ω σ]`, `B = [Re rᵀ; Im rᵀ]`, `C = [2 Re l, −2 Im l]`. Residues of rank ρ need ρ such blocks
//! and no fewer: Gilbert, J. SIAM Control 1 (1963), pp. 128–151.

use std::f64::consts::TAU;

use super::function::{DirectTerms, TransferFunction};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::{Complex, ComplexMatrix, Matrix, least_squares, symmetric};

/// Assumed input between samples, or equivalent mapping from s to z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum DiscretisationMethod {
    /// It is held: exact for inputs in steps.
    ZeroOrderHold,
    /// `s = (2/h) (z − 1)/(z + 1)`.
    Bilinear,
    /// Bilinear with a step that makes the response exact at this frequency, Hz.
    Prewarped(f64),
    /// The impulse response is sampled, times h.
    ImpulseInvariant,
}

/// A sample time and the rule it was reached by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sampling {
    /// Between samples, s.
    pub time_s: f64,
    /// The rule.
    pub map: DiscretisationMethod,
}

/// State space of identified functions; inputs and outputs by name.
#[derive(Debug, Clone)]
pub struct Realisation {
    /// A.
    pub a: Matrix,
    /// B.
    pub b: Matrix,
    /// C.
    pub c: Matrix,
    /// D.
    pub d: Matrix,
    /// Names of the inputs; an unnamed one is empty.
    pub inputs: Vec<String>,
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// Dead time before every input, s; not part of the matrices.
    pub delay_s: f64,
    /// Present where `x⁺ = A x + B u`.
    pub sampling: Option<Sampling>,
}

/// Residues whose singular values fall below this share of the largest have a lower rank: rounding of their product.
const RANK_TOLERANCE: f64 = 1e-13;

impl Realisation {
    /// Realisation of functions with the same poles, one for each pair of their inputs and outputs.
    ///
    /// Minimal in the poles; integrators of lower residual terms are one or two states for each input that has them.
    ///
    /// # Errors
    /// `Conflict` where poles or dead times differ or a pair is missing or twice; `OutOfRange` for terms in s or s², which
    /// no state space holds.
    pub fn from_transfer_functions(functions: &[TransferFunction]) -> Result<Realisation, Error> {
        let first = common(functions)?;
        let input =
            |f: &TransferFunction| f.input.as_ref().map_or(String::new(), |t| t.name.clone());
        let mut inputs: Vec<String> = Vec::new();
        let mut outputs: Vec<String> = Vec::new();
        for f in functions {
            push_name(&mut inputs, input(f));
            push_name(&mut outputs, f.output.name.clone());
        }
        let mut table = Vec::with_capacity(outputs.len());
        for output in &outputs {
            let mut row = Vec::with_capacity(inputs.len());
            for name in &inputs {
                let mut of = functions
                    .iter()
                    .filter(|f| f.output.name == *output && input(f) == *name);
                match (of.next(), of.next()) {
                    (Some(f), None) => row.push(f),
                    (f, _) => {
                        let count = if f.is_some() {
                            "there are several functions"
                        } else {
                            "there is no function"
                        };
                        let message = format!("{count} from `{name}` to `{output}`");
                        return Err(Error::new(Code::Conflict, message).with_hint(
                            "give one function for each pair of an input and an output",
                        ));
                    }
                }
            }
            table.push(row);
        }
        let (m, p) = (inputs.len(), outputs.len());
        let mut blocks = BlockBuilder::new(m, p);
        for (k, &pole) in first.poles.iter().enumerate() {
            let residues = ComplexMatrix::from_fn(p, m, |i, j| table[i][j].residues[k]);
            blocks.pole(pole, &residues)?;
        }
        for j in 0..m {
            let terms: Vec<DirectTerms> = table.iter().map(|row| row[j].direct).collect();
            blocks.integrators(j, &terms);
        }
        let d = Matrix::from_fn(p, m, |i, j| table[i][j].direct.constant);
        let (a, b, c) = blocks.matrices();
        let delay_s = first.delay_s;
        Ok(Realisation {
            a,
            b,
            c,
            d,
            inputs,
            outputs,
            delay_s,
            sampling: None,
        })
    }

    /// Outputs by inputs at a frequency, Hz; of a sampled form at `z = e^{i2πfh}`.
    ///
    /// # Errors
    /// `Indefinite` at a pole.
    pub fn response(&self, frequency_hz: f64) -> Result<ComplexMatrix, Error> {
        let s = Complex::new(0.0, TAU * frequency_hz);
        let at = self
            .sampling
            .map_or(s, |sampling| (s * sampling.time_s).exp());
        let n = self.a.nrows();
        let real = |x: f64| Complex::new(x, 0.0);
        let left = ComplexMatrix::from_fn(n, n, |i, j| {
            let own = if i == j { at } else { Complex::ZERO };
            own - self.a[(i, j)]
        });
        let right = ComplexMatrix::from_fn(n, self.b.ncols(), |i, j| real(self.b[(i, j)]));
        let x = if n == 0 {
            right
        } else {
            symmetric::lu_solve_complex(&left, &right)?
        };
        let c = ComplexMatrix::from_fn(self.c.nrows(), n, |i, j| real(self.c[(i, j)]));
        let (through, delay) = (c * x, (-s * self.delay_s).exp());
        Ok(ComplexMatrix::from_fn(
            through.nrows(),
            through.ncols(),
            |i, j| delay * (through[(i, j)] + self.d[(i, j)]),
        ))
    }
}

fn push_name(names: &mut Vec<String>, name: String) {
    if !names.contains(&name) {
        names.push(name);
    }
}

/// The first function, whose poles and dead time all share.
fn common(functions: &[TransferFunction]) -> Result<&TransferFunction, Error> {
    let Some(first) = functions.first() else {
        return Err(
            Error::new(Code::NoSignal, "there is no transfer function to realise")
                .with_hint("identify one first"),
        );
    };
    for f in functions {
        if f.poles != first.poles || f.delay_s != first.delay_s {
            let message = format!(
                "the functions to `{}` and `{}` differ in their poles or dead times",
                first.output.name, f.output.name
            );
            return Err(Error::new(Code::Conflict, message)
                .with_hint("realise each separately, or fit them together with common poles"));
        }
        if f.direct.polynomial_degree() > 0 {
            let message = format!(
                "the function to `{}` grows with s (E = {:e}, Q = {:e}), which no state space holds",
                f.output.name, f.direct.slope, f.direct.square
            );
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("integrate the response once or twice, or fit it without terms in s"));
        }
    }
    Ok(first)
}

/// A column of states: its pole, its row of B and its column of C.
#[derive(Default)]
struct BlockBuilder {
    inputs: usize,
    outputs: usize,
    entries: Vec<(usize, usize, f64)>,
    rows: Vec<Vec<f64>>,
    columns: Vec<Vec<f64>>,
}

impl BlockBuilder {
    fn new(inputs: usize, outputs: usize) -> BlockBuilder {
        BlockBuilder {
            inputs,
            outputs,
            ..BlockBuilder::default()
        }
    }

    fn pole(&mut self, pole: Complex, residues: &ComplexMatrix) -> Result<(), Error> {
        let (left, right) = least_squares::rank_factorisation(residues, RANK_TOLERANCE)?;
        for q in 0..left.ncols() {
            let (l, r) = (|i: usize| left[(i, q)], |j: usize| right[(q, j)]);
            let at = self.rows.len();
            self.entries.push((at, at, pole.re));
            if pole.im == 0.0 {
                self.state(|j| r(j).re, |i| l(i).re);
                continue;
            }
            self.entries.extend([
                (at, at + 1, -pole.im),
                (at + 1, at, pole.im),
                (at + 1, at + 1, pole.re),
            ]);
            self.state(|j| r(j).re, |i| 2.0 * l(i).re);
            self.state(|j| r(j).im, |i| -2.0 * l(i).im);
        }
        Ok(())
    }

    /// `ẋ₁ = u_j`, `ẋ₂ = x₁`, as far as the terms want.
    fn integrators(&mut self, input: usize, terms: &[DirectTerms]) {
        let count = terms
            .iter()
            .map(DirectTerms::integrators)
            .max()
            .unwrap_or(0);
        let at = self.rows.len();
        if count > 0 {
            self.state(|j| f64::from(u8::from(j == input)), |i| terms[i].inverse);
        }
        if count > 1 {
            self.entries.push((at + 1, at, 1.0));
            self.state(|_| 0.0, |i| terms[i].inverse_square);
        }
    }

    fn state(&mut self, b: impl Fn(usize) -> f64, c: impl Fn(usize) -> f64) {
        self.rows.push((0..self.inputs).map(b).collect());
        self.columns.push((0..self.outputs).map(c).collect());
    }

    fn matrices(&self) -> (Matrix, Matrix, Matrix) {
        let n = self.rows.len();
        let mut a = Matrix::zeros(n, n);
        self.entries.iter().for_each(|&(i, j, x)| a[(i, j)] = x);
        let b = Matrix::from_fn(n, self.inputs, |i, j| self.rows[i][j]);
        let c = Matrix::from_fn(self.outputs, n, |i, j| self.columns[j][i]);
        (a, b, c)
    }
}
