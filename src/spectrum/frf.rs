//! FRF estimators H1, H2, Hv for `Y = Σ H_j X_j + N` from averaged spectra; coherence, random error.
//!
//! Bendat & Piersol, Random Data, 4th ed. (2010), chapters 6, 7 and 9; Hv: Rocklin, Crowley & Vold, A comparison of H1, H2, and Hv
//! frequency response functions, Proc. 3rd IMAC (1985), pp. 272–278.
//! With `S_ij = E[X_i* X_j]`, `C = S⁻¹`, `s_j = E[X_j* Y]` and q inputs over n independent averages:
//!
//! - H1 (noise on the output): `H = C s`. The residual `S_yy − sᴴ C s` estimates the noise with `n − q` degrees of freedom, so
//!   that `E|ΔH_j|² = C_jj (S_yy − sᴴ C s)/(n − q)`; with one input `|H|² (1 − γ²)/(γ² (n − 1))`.
//! - H2 (noise on the input, one input): `H = S_yy/S_yx`, the same relative variance.
//! - Hv (noise on both, in proportion to the powers): the direction of least power of `(X, Y)`; with one input
//!   `√(S_yy/S_xx) S_xy/|S_xy|`, whose magnitude has a smaller error than its phase: `|H|² (1 − γ²)(1 + 1/γ²)/(2 (n − 1))`.

use super::spectra::{Spectra, coherence};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::numeric::symmetric::{hermitian_eigen, lu_solve_complex};
use crate::numeric::{Complex, ComplexMatrix};
use crate::recording::frequency_responses::{ChannelLabel, FrequencyResponse, FrequencyResponses};

/// Estimator of the frequency response, by the assumed location of the noise.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Estimator {
    /// Noise on the outputs.
    #[default]
    H1,
    /// Noise on the input.
    H2,
    /// Noise on inputs and outputs.
    Hv,
}

/// Estimated frequency response with variance and coherence by line.
#[derive(Debug, Clone)]
pub struct EstimatedFrf {
    /// Excitation channel.
    pub input: usize,
    /// Response channel.
    pub output: usize,
    /// Frequency response, output unit per input unit; 0 on undetermined lines.
    pub values: Vec<Complex>,
    /// Variance `E|error|²`; infinite on undetermined lines; `None` for no more averages than inputs.
    pub variance: Option<Vec<f64>>,
    /// Ordinary coherence of input and output.
    pub ordinary_coherence: Vec<f64>,
    /// Partial coherence, conditioned on the other inputs; equal to the ordinary one for a single input.
    pub partial_coherence: Vec<f64>,
}

/// Estimated frequency responses of all inputs and outputs, with the averages and the data-quality warnings.
#[derive(Debug, Clone)]
pub struct FrfEstimate {
    /// Frequencies of the lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// Frequency responses, by output, then by input.
    pub functions: Vec<EstimatedFrf>,
    /// Multiple coherence by output and line: share of the output power coherent with all inputs.
    pub multiple_coherence: Vec<Vec<f64>>,
    /// Indices of lines with zero power or coherent inputs.
    pub undetermined_lines: Vec<usize>,
    /// Effective number of independent averages.
    pub averages: f64,
    /// Decay rate of the exponential window on the blocks, 1/s.
    pub window_decay: f64,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Largest multiple coherence of an input with the others; above it noise on the inputs, amplified a thousandfold, would determine
/// the difference between them.
const MAX_INPUT_COHERENCE: f64 = 0.999;

/// Least significant power of an input on a line, relative to its largest; below it is rounding of the transforms.
const MIN_RELATIVE_POWER: f64 = 1e-26;

/// Channel pairs of the cross spectra required by [`estimate`].
pub fn required_pairs(inputs: &[usize], outputs: &[usize]) -> Vec<(usize, usize)> {
    let among_inputs = inputs
        .iter()
        .enumerate()
        .flat_map(|(i, &x)| inputs[i + 1..].iter().map(move |&other| (x, other)));
    let input_output = inputs
        .iter()
        .flat_map(|&x| outputs.iter().map(move |&y| (x, y)));
    among_inputs.chain(input_output).collect()
}

/// Estimates the frequency responses from the channels `inputs` to the channels `outputs`.
///
/// # Errors
/// `Conflict`: H2 with several inputs, a channel on both sides or twice, peak-hold spectra. `NoSignal`: an input without power.
/// `TooShort`: fewer averages than inputs. `IllPosed`: inputs coherent with each other on every line. `NoChannel`: spectra without
/// the cross spectra of [`required_pairs`].
pub fn estimate(
    spectra: &Spectra,
    inputs: &[usize],
    outputs: &[usize],
    estimator: Estimator,
) -> Result<FrfEstimate, Error> {
    let averages = check(spectra, inputs, outputs, estimator)?;
    let sorted = InputOutputSpectra::new(spectra, inputs, outputs)?;
    let (lines, q) = (spectra.frequency_hz.len(), inputs.len());
    let has_error = averages > q as f64 * (1.0 + AVERAGES_TOLERANCE);
    let mut functions: Vec<EstimatedFrf> = outputs
        .iter()
        .flat_map(|&output| inputs.iter().map(move |&input| (input, output)))
        .map(|(input, output)| EstimatedFrf {
            input,
            output,
            values: vec![Complex::new(0.0, 0.0); lines],
            variance: has_error.then(|| vec![f64::INFINITY; lines]),
            ordinary_coherence: vec![0.0; lines],
            partial_coherence: vec![0.0; lines],
        })
        .collect();
    let mut coherences = vec![vec![0.0; lines]; outputs.len()];
    let mut undetermined = Vec::new();
    for line in 0..lines {
        let Some(inverse) = sorted.inverse(line) else {
            undetermined.push(line);
            continue;
        };
        for (y, coherences) in coherences.iter_mut().enumerate() {
            let solved = sorted.solve(line, y, &inverse, estimator)?;
            coherences[line] = solved.multiple_coherence;
            for x in 0..q {
                let function = &mut functions[y * q + x];
                function.values[line] = solved.values[x];
                function.ordinary_coherence[line] = coherence(
                    sorted.sxx[x][line],
                    sorted.sxy[y][x][line],
                    sorted.syy[y][line],
                );
                function.partial_coherence[line] = solved.partial_coherence[x];
                if let Some(variance) = &mut function.variance {
                    variance[line] = solved.variance_times_dof[x] / (averages - q as f64);
                }
            }
        }
    }
    let diagnostics = warnings(undetermined.len(), lines, q, has_error)?;
    Ok(FrfEstimate {
        frequency_hz: spectra.frequency_hz.clone(),
        functions,
        multiple_coherence: coherences,
        undetermined_lines: undetermined,
        averages,
        window_decay: spectra.window_decay,
        diagnostics,
    })
}

/// Relative tolerance of the number of averages against an integer, for rounding of the sum over blocks.
const AVERAGES_TOLERANCE: f64 = 1e-9;

impl FrfEstimate {
    /// Set of frequency responses; `channels`: labels of the channels of the spectra. The coherence is ordinary for one input, multiple for
    /// several.
    ///
    /// # Panics
    /// Fewer labels than channels: a mistake of the caller.
    pub fn to_frequency_responses(&self, channels: &[ChannelLabel]) -> FrequencyResponses {
        let inputs = self.functions.len() / self.multiple_coherence.len().max(1);
        let is_average = self.averages > inputs as f64 * (1.0 + AVERAGES_TOLERANCE);
        let function = |(index, f): (usize, &EstimatedFrf)| FrequencyResponse {
            input: Some(channels[f.input].clone()),
            output: channels[f.output].clone(),
            values: f.values.clone(),
            variance: f.variance.clone(),
            coherence: is_average.then(|| self.multiple_coherence[index / inputs].clone()),
            partial_coherence: (is_average && inputs > 1).then(|| f.partial_coherence.clone()),
        };
        FrequencyResponses {
            frequency_hz: self.frequency_hz.clone(),
            responses: self.functions.iter().enumerate().map(function).collect(),
            averages: Some(self.averages),
            window_decay: self.window_decay,
            usable_band_hz: None,
            independent_lines_per_line: None,
        }
    }
}

/// Auto and cross spectra of inputs (x) and outputs (y), by line.
struct InputOutputSpectra<'a> {
    sxx: Vec<&'a [f64]>,
    syy: Vec<&'a [f64]>,
    /// Cross spectra of inputs i and i + 1 + j, `[i][j]`.
    input_cross: Vec<Vec<Vec<Complex>>>,
    /// Cross spectra of inputs and outputs, `[output][input]`.
    sxy: Vec<Vec<Vec<Complex>>>,
    /// Least significant power of each input.
    floor: Vec<f64>,
}

/// Estimated responses of one output on one line.
struct LineEstimate {
    values: Vec<Complex>,
    /// Variance times the degrees of freedom of the residual.
    variance_times_dof: Vec<f64>,
    partial_coherence: Vec<f64>,
    multiple_coherence: f64,
}

impl<'a> InputOutputSpectra<'a> {
    fn new(spectra: &'a Spectra, inputs: &[usize], outputs: &[usize]) -> Result<Self, Error> {
        let missing = |x: usize, y: usize| {
            Error::new(
                Code::NoChannel,
                format!("the cross spectrum of channels {x} and {y} was not estimated"),
            )
        };
        let cross = |x: usize, y: usize| spectra.cross(x, y).ok_or_else(|| missing(x, y));
        let psd = |&c: &usize| spectra.psd[c].as_slice();
        let sxx: Vec<&[f64]> = inputs.iter().map(psd).collect();
        let largest = |s: &&[f64]| s.iter().fold(0.0_f64, |a, &b| a.max(b));
        let among_inputs = (0..inputs.len()).map(|i| {
            let later = inputs[i + 1..].iter();
            later.map(|&x| cross(inputs[i], x)).collect()
        });
        let input_output = outputs
            .iter()
            .map(|&y| inputs.iter().map(|&x| cross(x, y)).collect());
        Ok(InputOutputSpectra {
            floor: sxx
                .iter()
                .map(|s| MIN_RELATIVE_POWER * largest(s))
                .collect(),
            syy: outputs.iter().map(psd).collect(),
            input_cross: among_inputs.collect::<Result<_, _>>()?,
            sxy: input_output.collect::<Result<_, _>>()?,
            sxx,
        })
    }

    /// Normalised input matrix of one line, `S_ij/√(S_ii S_jj)`.
    fn matrix(&self, line: usize) -> ComplexMatrix {
        let amplitude = |i: usize| self.sxx[i][line].sqrt();
        ComplexMatrix::from_fn(self.sxx.len(), self.sxx.len(), |i, j| {
            if i == j {
                return Complex::new(1.0, 0.0);
            }
            let (low, high) = (i.min(j), i.max(j));
            let s = self.input_cross[low][high - low - 1][line] / amplitude(i) / amplitude(j);
            if i < j { s } else { s.conj() }
        })
    }

    /// Inverse of [`InputOutputSpectra::matrix`], with the diagonal `1/(1 − γ²)`, γ² the multiple coherence of an input with the others.
    /// `None` for an input without power or coherent with the others.
    fn inverse(&self, line: usize) -> Option<ComplexMatrix> {
        let q = self.sxx.len();
        if (0..q).any(|i| self.sxx[i][line] <= self.floor[i]) {
            return None;
        }
        let identity = ComplexMatrix::identity(q, q);
        if q == 1 {
            return Some(identity);
        }
        let inverse = lu_solve_complex(&self.matrix(line), &identity).ok()?;
        let is_coherent = |i: usize| {
            let inflation = inverse[(i, i)].re;
            !(inflation > 0.0 && inflation * (1.0 - MAX_INPUT_COHERENCE) < 1.0)
        };
        (!(0..q).any(is_coherent)).then_some(inverse)
    }

    fn solve(
        &self,
        line: usize,
        y: usize,
        inverse: &ComplexMatrix,
        estimator: Estimator,
    ) -> Result<LineEstimate, Error> {
        let q = self.sxx.len();
        let syy = self.syy[y][line];
        if syy <= 0.0 {
            let zero = Complex::new(0.0, 0.0);
            return Ok(LineEstimate {
                values: vec![zero; q],
                variance_times_dof: vec![0.0; q],
                partial_coherence: vec![0.0; q],
                multiple_coherence: 0.0,
            });
        }
        // Normalised by the powers of the channels: γ_j = s_j/√(S_jj S_yy), H_j = h_j √(S_yy/S_jj).
        let ratio = |j: usize| (syy / self.sxx[j][line]).sqrt();
        let norm = |j: usize| self.sxx[j][line].sqrt() * syy.sqrt();
        let gamma: Vec<Complex> = (0..q).map(|j| self.sxy[y][j][line] / norm(j)).collect();
        let product = |i: usize| (0..q).map(|j| inverse[(i, j)] * gamma[j]).sum::<Complex>();
        let h: Vec<Complex> = (0..q).map(product).collect();
        let multiple: f64 = (0..q).map(|j| (gamma[j].conj() * h[j]).re).sum();
        let multiple = multiple.clamp(0.0, 1.0);
        let residual = 1.0 - multiple;
        let c = |j: usize| inverse[(j, j)].re;
        let explained = |j: usize| h[j].norm_sqr() / c(j);
        let mut solved = LineEstimate {
            partial_coherence: (0..q)
                .map(|j| explained(j) / (explained(j) + residual).max(f64::MIN_POSITIVE))
                .collect(),
            variance_times_dof: (0..q).map(|j| residual * c(j) * ratio(j).powi(2)).collect(),
            values: (0..q).map(|j| h[j] * ratio(j)).collect(),
            multiple_coherence: multiple,
        };
        match estimator {
            Estimator::H1 => {}
            Estimator::H2 => {
                solved.values[0] /= multiple;
                solved.variance_times_dof[0] /= multiple * multiple;
            }
            Estimator::Hv if q == 1 => {
                solved.values[0] /= multiple.sqrt();
                solved.variance_times_dof[0] =
                    ratio(0).powi(2) * residual * 0.5 * (1.0 + 1.0 / multiple);
            }
            Estimator::Hv => {
                let direction = self.min_power_direction(line, &gamma)?;
                solved.values = (0..q).map(|j| direction[j] * ratio(j)).collect();
            }
        }
        for j in 0..q {
            if !(solved.values[j].norm().is_finite() && solved.variance_times_dof[j].is_finite()) {
                solved.values[j] = Complex::new(0.0, 0.0);
                solved.variance_times_dof[j] = f64::INFINITY;
            }
        }
        Ok(solved)
    }

    /// Total least squares: `h` with `(h, −1)` along the direction of least power of inputs and output.
    fn min_power_direction(&self, line: usize, gamma: &[Complex]) -> Result<Vec<Complex>, Error> {
        let q = gamma.len();
        let inputs = self.matrix(line);
        let joint = ComplexMatrix::from_fn(q + 1, q + 1, |i, j| match (i == q, j == q) {
            (false, false) => inputs[(i, j)],
            (false, true) => gamma[i],
            (true, false) => gamma[j].conj(),
            (true, true) => Complex::new(1.0, 0.0),
        });
        let (_, vectors) = hermitian_eigen(&joint)?;
        Ok((0..q).map(|j| -vectors[(j, 0)] / vectors[(q, 0)]).collect())
    }
}

fn check(
    spectra: &Spectra,
    inputs: &[usize],
    outputs: &[usize],
    estimator: Estimator,
) -> Result<f64, Error> {
    let conflict = |message: &str| Error::new(Code::Conflict, message);
    let mut all: Vec<usize> = inputs.iter().chain(outputs).copied().collect();
    all.sort_unstable();
    all.dedup();
    if inputs.is_empty() || outputs.is_empty() {
        return Err(conflict(
            "a frequency response needs an input and an output",
        ));
    }
    if all.len() < inputs.len() + outputs.len() {
        return Err(conflict(
            "a channel occurs twice among the inputs and outputs",
        ));
    }
    if estimator == Estimator::H2 && inputs.len() > 1 {
        return Err(
            conflict("H2 takes one input: with several, noise on the inputs alone does not determine the responses")
                .with_hint("use H1, or Hv for noise on both sides"),
        );
    }
    if let Some(&channel) = all.iter().find(|&&c| c >= spectra.psd.len()) {
        return Err(Error::new(
            Code::NoChannel,
            format!(
                "channel {channel} of {} is requested, counted from 0",
                spectra.psd.len()
            ),
        ));
    }
    if let Some(input) = inputs
        .iter()
        .find(|&&c| !spectra.psd[c].iter().any(|&s| s > 0.0))
    {
        return Err(Error::new(
            Code::NoSignal,
            format!("input channel {input}, counted from 0, has no power"),
        ));
    }
    let averages = spectra
        .averages
        .ok_or_else(|| conflict("spectra that hold the largest of each line are no means"))?;
    if inputs.len() > 1 && averages <= inputs.len() as f64 * (1.0 + AVERAGES_TOLERANCE) {
        return Err(Error::new(
            Code::TooShort,
            format!(
                "{averages:.1} independent averages do not separate {} inputs",
                inputs.len()
            ),
        )
        .with_hint("shorter blocks, or a longer record"));
    }
    Ok(averages)
}

fn warnings(
    undetermined: usize,
    lines: usize,
    inputs: usize,
    has_error: bool,
) -> Result<Vec<Diagnostic>, Error> {
    if undetermined == lines {
        return Err(Error::new(
            Code::IllPosed,
            format!(
                "the {inputs} inputs are coherent with each other on every line, above {MAX_INPUT_COHERENCE}: their effects cannot be separated"
            ),
        )
        .with_hint("excite them with independent signals, or name one of them as the only input"));
    }
    let mut diagnostics = Vec::new();
    if inputs > 1 && undetermined > 0 {
        diagnostics.push(Diagnostic {
            code: "coherent-inputs",
            message: format!(
                "on {undetermined} of {lines} lines the inputs are coherent with each other above {MAX_INPUT_COHERENCE}, or one has no power; nothing is estimated there"
            ),
            hint: Some("excite the inputs with independent signals".into()),
        });
    }
    if !has_error {
        diagnostics.push(Diagnostic {
            code: "one-average",
            message: "a single average has neither coherence nor random error".into(),
            hint: Some(
                "average over more blocks: shorter blocks, a longer record, or more hits".into(),
            ),
        });
    }
    Ok(diagnostics)
}
