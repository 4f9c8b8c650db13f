//! Frequency response functions (FRFs), read from a file or estimated, with variance and coherence.

use crate::numeric::Complex;

/// Channel and its unit at the input or output of a frequency response.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ChannelLabel {
    /// Name of the channel.
    pub name: String,
    /// Unit as text, such as `m/s²`; empty if unknown.
    pub unit: String,
}

/// One frequency response function over the lines of [`FrequencyResponses`].
#[derive(Debug, Clone, Default)]
pub struct FrequencyResponse {
    /// Excitation channel; `None` if the file does not state it.
    pub input: Option<ChannelLabel>,
    /// Response channel.
    pub output: ChannelLabel,
    /// Output over input at each line, in the unit of the output over that of the input.
    pub values: Vec<Complex>,
    /// Variance `E|error|²` of each value, if estimated.
    pub variance: Option<Vec<f64>>,
    /// Ordinary coherence (multiple coherence with several inputs), 0 to 1, if estimated.
    pub coherence: Option<Vec<f64>>,
    /// Partial coherence of input and output, conditioned on the other inputs, 0 to 1, if there are several inputs.
    pub partial_coherence: Option<Vec<f64>>,
}

/// Frequency responses over common lines.
#[derive(Debug, Clone, Default)]
pub struct FrequencyResponses {
    /// Spectral lines, Hz, ascending.
    pub frequency_hz: Vec<f64>,
    /// Frequency response functions.
    pub responses: Vec<FrequencyResponse>,
    /// Effective number of independent averages of each value, if known.
    pub averages: Option<f64>,
    /// Decay `σ` of the exponential window `exp(−σt)`, which shifts every pole to the left by `σ`, 1/s; 0 without a window.
    pub window_decay: f64,
    /// Usable band, Hz: the lines with input power, away from the ends of the estimate.
    pub usable_band_hz: Option<(f64, f64)>,
    /// Number of independent lines per line, in (0, 1], if known; below 1 under a window.
    pub independent_lines_per_line: Option<f64>,
}

impl FrequencyResponses {
    /// Sets missing variances from the coherence γ² and n averages, `|H|² (1 − γ²)/γ²/(n − 1)`, for a single input (Bendat and Piersol
    /// 2010, section 9.1).
    pub fn variances_from_coherence(&mut self) {
        /// Rounding of a written coherence.
        const ROUNDING: f64 = 1e-12;
        let has_one_input = self
            .index_matrix()
            .first()
            .is_some_and(|row| row.len() == 1);
        let Some(averages) = self.averages.filter(|n| *n > 1.0 && has_one_input) else {
            return;
        };
        for function in &mut self.responses {
            let (Some(coherence), None) = (&function.coherence, &function.variance) else {
                continue;
            };
            let error = |(h, c): (&Complex, &f64)| match *c > 0.0 {
                true => h.norm_sqr() * (1.0 - c).max(ROUNDING) / c / (averages - 1.0),
                false => f64::INFINITY,
            };
            function.variance = Some(function.values.iter().zip(coherence).map(error).collect());
        }
    }

    /// Whether every response was estimated at a line; false if inputs are linearly dependent or one has no power.
    pub fn is_determined(&self, line: usize) -> bool {
        let is_undetermined =
            |f: &FrequencyResponse| (f.variance.as_ref()).is_some_and(|v| v[line] == f64::INFINITY);
        !self.responses.iter().any(is_undetermined)
    }

    /// Indices of the functions as a matrix of outputs (rows) by inputs (columns). If the matrix is incomplete or ambiguous,
    /// every function has its own row.
    pub fn index_matrix(&self) -> Vec<Vec<usize>> {
        let index = |key: &dyn Fn(&FrequencyResponse) -> Option<&ChannelLabel>| -> Vec<usize> {
            let find = |f: &FrequencyResponse| self.responses.iter().position(|g| key(g) == key(f));
            self.responses.iter().filter_map(find).collect()
        };
        let distinct = |indices: &[usize]| {
            let mut sorted = indices.to_vec();
            sorted.sort_unstable();
            sorted.dedup();
            sorted
        };
        let (rows, columns) = (index(&|f| Some(&f.output)), index(&|f| f.input.as_ref()));
        let (outputs, inputs) = (distinct(&rows), distinct(&columns));
        let unique_index = |o: usize, i: usize| {
            let mut cells = (0..self.responses.len()).filter(|&f| (rows[f], columns[f]) == (o, i));
            cells.next().filter(|_| cells.next().is_none())
        };
        let row = |&o: &usize| inputs.iter().map(|&i| unique_index(o, i)).collect();
        let matrix: Option<Vec<Vec<usize>>> = outputs.iter().map(row).collect();
        matrix.unwrap_or_else(|| (0..self.responses.len()).map(|f| vec![f]).collect())
    }
}

/// Spacing of the first two lines, Hz; 0 for fewer lines.
pub fn line_spacing_hz(frequency_hz: &[f64]) -> f64 {
    match frequency_hz {
        [first, second, ..] => second - first,
        _ => 0.0,
    }
}

/// Spectrum read from a file, with values as written.
#[derive(Debug, Clone, Default)]
pub struct StoredSpectrum {
    /// Name of the channel.
    pub name: String,
    /// Unit of the values as written; empty if unknown.
    pub unit: String,
    /// Kind of spectrum, as text: `power spectral density`, `cross spectrum`.
    pub kind: &'static str,
    /// Whether the values are levels in dB.
    pub is_decibel: bool,
    /// Spectral lines, Hz, ascending.
    pub frequency_hz: Vec<f64>,
    /// Value at each line; real if the file has no phase.
    pub values: Vec<Complex>,
}

impl StoredSpectrum {
    /// Whether the values are proportional to the square of the signal.
    pub fn is_power(&self) -> bool {
        const POWER_KINDS: &[&str] = &[
            "auto spectrum",
            "cross spectrum",
            "power spectral density",
            "energy spectral density",
        ];
        POWER_KINDS.contains(&self.kind)
    }

    /// Converts a value to a power, proportional to the square of the signal.
    pub fn to_power(&self, value: Complex) -> f64 {
        match (self.is_decibel, self.is_power()) {
            (true, _) => 10f64.powf(value.re / 10.0),
            (false, true) => value.norm(),
            (false, false) => value.norm_sqr(),
        }
    }
}
