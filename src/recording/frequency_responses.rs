//! Frequency response functions (FRFs), read from a file or estimated, with variance and coherence.

use crate::numeric::Complex;

/// Channel and its unit at the input or output of a frequency response.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ChannelLabel {
    /// Name of the channel.
    pub name: String,
    /// Unit as text, such as `m/s²`; empty where unknown.
    pub unit: String,
}

/// One frequency response function over the lines of its table.
#[derive(Debug, Clone, Default)]
pub struct FrequencyResponse {
    /// Excitation channel; `None` where the file does not state it.
    pub input: Option<ChannelLabel>,
    /// Response channel.
    pub output: ChannelLabel,
    /// Output over input by line, in the unit of the output over that of the input.
    pub values: Vec<Complex>,
    /// `E|error|²` of each value, where it was measured.
    pub variance: Option<Vec<f64>>,
    /// Ordinary coherence (multiple coherence with several inputs), where it was measured.
    pub coherence: Option<Vec<f64>>,
    /// Coherence of the two with what the other inputs explain taken off both, where there are several.
    pub partial_coherence: Option<Vec<f64>>,
}

/// Frequency responses over common lines.
#[derive(Debug, Clone, Default)]
pub struct FrequencyResponses {
    /// Lines, Hz, rising.
    pub frequency_hz: Vec<f64>,
    /// The functions.
    pub responses: Vec<FrequencyResponse>,
    /// Effective number of independent averages behind each value, where known.
    pub averages: Option<f64>,
    /// An exponential window `exp(−σt)` lies on the responses and shifts every pole to the left by `σ`, 1/s; 0 without one.
    pub window_decay: f64,
    /// The lines that are worth fitting, Hz: where the input has power, away from the ends of the estimate.
    pub usable_band_hz: Option<(f64, f64)>,
    /// Number of independent lines a line holds, where it is known: below 1 under a window.
    pub independent_lines_per_line: Option<f64>,
}

impl FrequencyResponses {
    /// Gives every response that lacks a variance that of its coherence γ² and n averages, `|H|² (1 − γ²)/γ²/(n − 1)` (Bendat and Piersol
    /// 2010, section 9.1), where it has one input.
    pub fn variances_from_coherence(&mut self) {
        /// Digits of a coherence as written.
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
            let of = |(h, c): (&Complex, &f64)| match *c > 0.0 {
                true => h.norm_sqr() * (1.0 - c).max(ROUNDING) / c / (averages - 1.0),
                false => f64::INFINITY,
            };
            function.variance = Some(function.values.iter().zip(coherence).map(of).collect());
        }
    }

    /// Whether every response was estimated on a line: where inputs cannot be distinguished, or one has no power, none is.
    pub fn is_determined(&self, line: usize) -> bool {
        let unknown =
            |f: &FrequencyResponse| (f.variance.as_ref()).is_some_and(|v| v[line] == f64::INFINITY);
        !self.responses.iter().any(unknown)
    }

    /// The places of the functions, a row for each output with a column for each input. Where not every input leads to every output
    /// once, every function stands in a row of its own.
    pub fn index_matrix(&self) -> Vec<Vec<usize>> {
        let place = |of: &dyn Fn(&FrequencyResponse) -> Option<&ChannelLabel>| -> Vec<usize> {
            let first = |f: &FrequencyResponse| self.responses.iter().position(|g| of(g) == of(f));
            self.responses.iter().filter_map(first).collect()
        };
        let distinct = |places: &[usize]| {
            let mut all = places.to_vec();
            all.sort_unstable();
            all.dedup();
            all
        };
        let (rows, columns) = (place(&|f| Some(&f.output)), place(&|f| f.input.as_ref()));
        let (outputs, inputs) = (distinct(&rows), distinct(&columns));
        let at = |o: usize, i: usize| {
            let mut found = (0..self.responses.len()).filter(|&f| (rows[f], columns[f]) == (o, i));
            found.next().filter(|_| found.next().is_none())
        };
        let row = |&o: &usize| inputs.iter().map(|&i| at(o, i)).collect();
        let whole: Option<Vec<Vec<usize>>> = outputs.iter().map(row).collect();
        whole.unwrap_or_else(|| (0..self.responses.len()).map(|f| vec![f]).collect())
    }
}

/// Distance of the first two lines, Hz; 0 where there are fewer.
pub fn line_spacing_hz(frequency_hz: &[f64]) -> f64 {
    match frequency_hz {
        [first, second, ..] => second - first,
        _ => 0.0,
    }
}

/// A spectrum as read from a file, which is neither a signal nor a response; values as written.
#[derive(Debug, Clone, Default)]
pub struct StoredSpectrum {
    /// Name of the channel.
    pub name: String,
    /// Unit of the values as written; empty where unknown.
    pub unit: String,
    /// Kind of spectrum, as text: `power spectral density`, `cross spectrum`.
    pub kind: &'static str,
    /// The values are decibels of that unit.
    pub is_decibel: bool,
    /// Lines, Hz, rising.
    pub frequency_hz: Vec<f64>,
    /// A value for each line; real where the file has no phase.
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

    /// Power, proportional to the square of the signal, of one of the values.
    pub fn to_power(&self, value: Complex) -> f64 {
        match (self.is_decibel, self.is_power()) {
            (true, _) => 10f64.powf(value.re / 10.0),
            (false, true) => value.norm(),
            (false, false) => value.norm_sqr(),
        }
    }
}
