//! Export of transfer functions and state space: JSON, CSV, MATLAB level 5.
//!
//! In Python: `m = scipy.io.loadmat(file)`, then `control.ss(m["A"], m["B"], m["C"], m["D"])`, or for one function
//! `control.tf(m["num"][0], m["den"][0])`; in MATLAB `ss(A, B, C, D)`, with `Ts` for a discrete-time system.

use std::io::{self, Write};

use serde_json::{Value, json};

use super::function::TransferFunction;
use super::polynomials::TransferPolynomials;
use super::realisation::{DiscretisationMethod, Realisation};
use crate::base::code::Code;
use crate::base::error::Error;
use crate::base::mat5::write as mat5;
use crate::numeric::{Complex, Matrix, to_rows};
use crate::recording::frequency_responses::ChannelLabel;

fn complex(z: Complex) -> Value {
    json!({"re": z.re, "im": z.im})
}

fn channel_label(label: &ChannelLabel) -> Value {
    json!({"name": label.name, "unit": label.unit})
}

impl TransferFunction {
    /// JSON object with `input`, `output`, `poles_rad_s`, `residues` (each pole of a pair followed by its conjugate), `zeros_rad_s`, `gain`,
    /// `direct` by powers of s from −2 to 2, `delay_s`, `numerator`, `denominator` by decreasing powers of s, `polynomial_error`, `fit_error`.
    ///
    /// # Errors
    /// Those of [`TransferFunction::zeros`].
    pub fn to_json(&self) -> Result<Value, Error> {
        let (zeros, polynomials) = (self.zeros()?, self.polynomials()?);
        let [l2, l1, d, e, q] = self.direct.coefficients();
        let poles = self.poles_with_conjugates();
        let is_finite = |list: &[f64]| list.iter().all(|x| x.is_finite());
        let are_finite = is_finite(&polynomials.numerator) && is_finite(&polynomials.denominator);
        let coefficients = |list: &[f64]| are_finite.then(|| list.to_vec());
        Ok(json!({
            "input": self.input.as_ref().map(channel_label),
            "output": channel_label(&self.output),
            "poles_rad_s": poles.iter().map(|t| complex(t.0)).collect::<Vec<_>>(),
            "residues": poles.iter().map(|t| complex(t.1)).collect::<Vec<_>>(),
            "zeros_rad_s": zeros.zeros.iter().map(|&z| complex(z)).collect::<Vec<_>>(),
            "gain": zeros.gain,
            "direct": {"s^-2": l2, "s^-1": l1, "s^0": d, "s^1": e, "s^2": q},
            "delay_s": self.delay_s,
            "numerator": coefficients(&polynomials.numerator),
            "denominator": coefficients(&polynomials.denominator),
            "polynomial_error": polynomials.error.is_finite().then_some(polynomials.error),
            "fit_error": self.fit_error,
        }))
    }
}

impl Realisation {
    /// JSON object with `a`, `b`, `c`, `d` by rows, `inputs`, `outputs`, `delay_s`, `sample_time_s`, `map` and `prewarp_hz` (null if absent).
    pub fn to_json(&self) -> Value {
        json!({
            "a": to_rows(&self.a), "b": to_rows(&self.b), "c": to_rows(&self.c), "d": to_rows(&self.d),
            "inputs": self.inputs, "outputs": self.outputs, "delay_s": self.delay_s,
            "sample_time_s": self.sampling.map(|s| s.time_s),
            "map": self.sampling.map(|s| s.map.name()),
            "prewarp_hz": self.sampling.and_then(|s| match s.map {
                DiscretisationMethod::Prewarped(frequency) => Some(frequency),
                _ => None,
            }),
        })
    }
}

/// Writes a CSV table with one row for each pole (conjugates included) and direct term of every function; poles in rad/s.
///
/// # Errors
/// Errors of the writer.
pub fn write_csv(functions: &[TransferFunction], to: &mut impl Write) -> io::Result<()> {
    let mut table = csv::Writer::from_writer(to);
    table.write_record([
        "input", "output", "term", "pole_re", "pole_im", "value_re", "value_im",
    ])?;
    for f in functions {
        let input = f.input.as_ref().map_or("", |t| t.name.as_str());
        let mut row = |term: &str, pole: Option<Complex>, value: Complex| {
            let text = |x: f64| format!("{x:?}");
            let [re, im] =
                pole.map_or([String::new(), String::new()], |p| [text(p.re), text(p.im)]);
            let labels = [input, &f.output.name, term];
            let numbers = [re, im, text(value.re), text(value.im)];
            table.write_record(labels.into_iter().chain(numbers.iter().map(String::as_str)))
        };
        for (pole, residue) in f.poles_with_conjugates() {
            row("residue", Some(pole), residue)?;
        }
        for (coefficient, power) in f.direct.coefficients().into_iter().zip(-2..=2) {
            if coefficient != 0.0 {
                row(&format!("s^{power}"), None, Complex::new(coefficient, 0.0))?;
            }
        }
        if f.delay_s != 0.0 {
            row("delay_s", None, Complex::new(f.delay_s, 0.0))?;
        }
    }
    table.flush()
}

/// MATLAB level 5 file with `A`, `B`, `C`, `D`, `Ts` (0 if continuous), `map`, `delay_s`, cells `inputs` and `outputs` of the state space;
/// for the continuous functions `poles` (a column, conjugates included, rad/s), `residues` (a column for each function), `num` (a row for
/// each function, decreasing powers of s, zeros in front) and `den`, cells `function_inputs`, `function_outputs`.
///
/// Functions with terms in s or s², or with different poles, have no common state space; write each to its own file.
///
/// # Errors
/// Those of [`Realisation::from_transfer_functions`] and [`TransferFunction::zeros`]; `OutputFailed` beyond 4 GB.
pub fn to_mat(functions: &[TransferFunction], model: &Realisation) -> Result<Vec<u8>, Error> {
    let forms: Vec<TransferPolynomials> = functions
        .iter()
        .map(TransferFunction::polynomials)
        .collect::<Result<_, Error>>()?;
    let denominator = forms.iter().map(|p| &p.denominator).max_by_key(|d| d.len());
    let denominator = denominator.cloned().unwrap_or_default();
    // A function with fewer integrators than others has both polynomials multiplied by s.
    let extended_numerator = |mut p: TransferPolynomials| {
        let missing = denominator.len() - p.denominator.len();
        p.numerator.extend(std::iter::repeat_n(0.0, missing));
        p.numerator
    };
    let numerators: Vec<Vec<f64>> = forms.into_iter().map(extended_numerator).collect();
    mat_file(functions, model, &numerators, &denominator).map_err(|e| {
        Error::new(Code::OutputFailed, e.to_string()).with_hint("export fewer functions to a file")
    })
}

fn mat_file(
    functions: &[TransferFunction],
    model: &Realisation,
    numerators: &[Vec<f64>],
    denominator: &[f64],
) -> io::Result<Vec<u8>> {
    let mut file = mat5::header("identified transfer functions, SI units");
    for (name, matrix) in [
        ("A", &model.a),
        ("B", &model.b),
        ("C", &model.c),
        ("D", &model.d),
    ] {
        file.extend(real(name, matrix)?);
    }
    let (time, map) = model
        .sampling
        .map_or((0.0, "continuous"), |s| (s.time_s, s.map.name()));
    file.extend(mat5::real("Ts", [1, 1], [time])?);
    file.extend(mat5::text("map", map)?);
    file.extend(mat5::real("delay_s", [1, 1], [model.delay_s])?);
    file.extend(mat5::cell_strings("inputs", &model.inputs)?);
    file.extend(mat5::cell_strings("outputs", &model.outputs)?);

    let pole_lists: Vec<Vec<(Complex, Complex)>> = functions
        .iter()
        .map(TransferFunction::poles_with_conjugates)
        .collect();
    let rows = pole_lists.first().map_or(0, Vec::len);
    let poles = || pole_lists.iter().take(1).flatten().map(|t| t.0);
    let residues = || pole_lists.iter().flatten().map(|t| t.1);
    file.extend(mat5::complex(
        "poles",
        [rows, 1],
        poles().map(|z| z.re),
        poles().map(|z| z.im),
    )?);
    let size = [rows, functions.len()];
    file.extend(mat5::complex(
        "residues",
        size,
        residues().map(|z| z.re),
        residues().map(|z| z.im),
    )?);
    let max_len = numerators.iter().map(Vec::len).max().unwrap_or(0);
    let at = |i: usize, j: usize| {
        let n_leading_zeros = max_len - numerators[i].len();
        if j < n_leading_zeros {
            0.0
        } else {
            numerators[i][j - n_leading_zeros]
        }
    };
    file.extend(real(
        "num",
        &Matrix::from_fn(numerators.len(), max_len, at),
    )?);
    file.extend(mat5::real(
        "den",
        [1, denominator.len()],
        denominator.iter().copied(),
    )?);
    let inputs: Vec<String> = functions
        .iter()
        .map(|f| f.input.as_ref().map_or(String::new(), |t| t.name.clone()))
        .collect();
    let outputs: Vec<String> = functions.iter().map(|f| f.output.name.clone()).collect();
    file.extend(mat5::cell_strings("function_inputs", &inputs)?);
    file.extend(mat5::cell_strings("function_outputs", &outputs)?);
    Ok(file)
}

fn real(name: &str, matrix: &Matrix) -> io::Result<Vec<u8>> {
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    let by_column = (0..columns).flat_map(|j| (0..rows).map(move |i| matrix[(i, j)]));
    mat5::real(name, [rows, columns], by_column)
}
