//! Frequency responses `H(ω) = c (K + iωC − ω²M)⁻¹ b` with the names of their inputs and outputs.

use std::f64::consts::TAU;

use crate::base::error::Diagnostic;
use crate::machine::components::Machine;
use crate::numeric::Complex;
use crate::plan::response::run::ResponseResult;

/// Frequency responses of every output to every input.
#[derive(Debug, Clone)]
pub struct Response {
    /// Spectral lines, Hz.
    pub frequency_hz: Vec<f64>,
    /// One function for each input and output.
    pub functions: Vec<ResponseFunction>,
    /// Warnings about the machine and the solution.
    pub diagnostics: Vec<Diagnostic>,
}

/// The response of one output to one input.
#[derive(Debug, Clone)]
pub struct ResponseFunction {
    /// Name of the input.
    pub input: String,
    /// Name of the output.
    pub output: String,
    /// Unit of the values, `rad/(N·m)`.
    pub unit: String,
    /// One value for each line of [`Response::frequency_hz`].
    pub values: Vec<Complex>,
    /// Peaks by rising frequency; they may lie between two lines.
    pub peaks: Vec<ResponsePeak>,
}

/// A peak of a frequency response.
#[derive(Debug, Clone)]
pub struct ResponsePeak {
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Magnitude, in the unit of the function.
    pub magnitude: f64,
    /// Damping ratio by the half-power points; `None` where a neighbour covers them.
    pub damping_ratio: Option<f64>,
    /// The element with the largest share of the strain energy.
    pub dominant_element: Option<String>,
}

impl Response {
    pub(super) fn new(machine: &Machine, result: ResponseResult) -> Response {
        let functions = result.pairs.into_iter().map(|pair| ResponseFunction {
            peaks: (pair.peaks.iter())
                .map(|strained| ResponsePeak {
                    frequency_hz: strained.peak.omega / TAU,
                    magnitude: strained.peak.height,
                    damping_ratio: strained.peak.damping(),
                    dominant_element: strained
                        .dominant_element
                        .map(|(element, _)| machine.elements[element].name.clone()),
                })
                .collect(),
            input: pair.input,
            output: pair.output,
            unit: pair.unit,
            values: pair.values,
        });
        Response {
            functions: functions.collect(),
            frequency_hz: result.frequency_hz,
            diagnostics: result.diagnostics,
        }
    }

    /// The response of `output` to `input`.
    pub fn function(&self, input: &str, output: &str) -> Option<&ResponseFunction> {
        let is_pair = |f: &&ResponseFunction| f.input == input && f.output == output;
        self.functions.iter().find(is_pair)
    }
}
