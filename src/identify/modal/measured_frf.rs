//! FRF matrix `H[output][input]` over common spectral lines, validated.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::numeric::Complex;

/// Fewest lines any method fits: a single mode has four real unknowns, and a half-power band needs a few lines.
const MIN_LINES: usize = 10;

/// Relative spread below which an FRF counts as constant: rounding of a file with eight digits.
const CONSTANT_TOLERANCE: f64 = 1e-7;

/// Frequency responses `H[output][input]` over rising lines, all finite, none without information.
#[derive(Debug, Clone)]
pub struct MeasuredFrf<'a> {
    frequency_hz: &'a [f64],
    rows: Vec<Vec<&'a [Complex]>>,
}

impl<'a> MeasuredFrf<'a> {
    /// One input: `responses[output][line]`.
    ///
    /// # Errors
    /// As [`MeasuredFrf::new`].
    pub fn single_input(
        frequency_hz: &'a [f64],
        responses: &'a [Vec<Complex>],
    ) -> Result<Self, Error> {
        let rows = responses.iter().map(|h| vec![h.as_slice()]).collect();
        MeasuredFrf::checked(frequency_hz, rows)
    }

    /// Several inputs: `responses[output][input][line]`.
    ///
    /// # Errors
    /// `TooShort` with too few lines, `InvalidTimeStamps` where lines do not rise, `NotANumber` where a value is not finite, `NoSignal` where a
    /// response is zero or constant or there is none, `IllPosed` where lengths differ.
    pub fn new(frequency_hz: &'a [f64], responses: &'a [Vec<Vec<Complex>>]) -> Result<Self, Error> {
        let rows = responses
            .iter()
            .map(|row| row.iter().map(Vec::as_slice).collect())
            .collect();
        MeasuredFrf::checked(frequency_hz, rows)
    }

    fn checked(frequency_hz: &'a [f64], rows: Vec<Vec<&'a [Complex]>>) -> Result<Self, Error> {
        check_lines(frequency_hz)?;
        let n_inputs = rows.first().map_or(0, Vec::len);
        if n_inputs == 0 {
            return Err(
                Error::new(Code::NoSignal, "there is no frequency response to fit")
                    .with_hint("name at least one output channel"),
            );
        }
        for (output, row) in rows.iter().enumerate() {
            if row.len() != n_inputs {
                return Err(Error::new(
                    Code::IllPosed,
                    format!(
                        "output {} has responses to {} inputs, output 1 to {n_inputs}",
                        output + 1,
                        row.len()
                    ),
                )
                .with_hint("give every output a response to every input"));
            }
            for (input, h) in row.iter().enumerate() {
                check_response(frequency_hz, h, output, input)?;
            }
        }
        Ok(MeasuredFrf { frequency_hz, rows })
    }

    /// The lines from `low_hz` to `high_hz`, both included.
    ///
    /// # Errors
    /// `TooShort` where the band holds too few lines.
    pub fn band(&self, low_hz: f64, high_hz: f64) -> Result<MeasuredFrf<'a>, Error> {
        let from = self.frequency_hz.partition_point(|&f| f < low_hz);
        let to = self.frequency_hz.partition_point(|&f| f <= high_hz);
        let range = from..to.max(from);
        check_lines(&self.frequency_hz[range.clone()]).map_err(|error| {
            error.with_hint(format!(
                "widen the band: the lines reach from {} to {} Hz",
                self.frequency_hz[0],
                self.frequency_hz[self.frequency_hz.len() - 1]
            ))
        })?;
        let cut = |row: &Vec<&'a [Complex]>| row.iter().map(|h| &h[range.clone()]).collect();
        Ok(MeasuredFrf {
            frequency_hz: &self.frequency_hz[range.clone()],
            rows: self.rows.iter().map(cut).collect(),
        })
    }

    /// Lines, Hz.
    pub fn frequency_hz(&self) -> &'a [f64] {
        self.frequency_hz
    }

    /// Number of lines.
    pub fn n_lines(&self) -> usize {
        self.frequency_hz.len()
    }

    /// Number of outputs.
    pub fn n_outputs(&self) -> usize {
        self.rows.len()
    }

    /// Number of inputs.
    pub fn n_inputs(&self) -> usize {
        self.rows[0].len()
    }

    /// The response of an output to an input, by line.
    pub fn response(&self, output: usize, input: usize) -> &'a [Complex] {
        self.rows[output][input]
    }

    /// First and last line, Hz.
    pub fn band_limits_hz(&self) -> (f64, f64) {
        (self.frequency_hz[0], self.frequency_hz[self.n_lines() - 1])
    }

    /// Mean distance of the lines, Hz.
    pub fn frequency_resolution_hz(&self) -> f64 {
        let (low, high) = self.band_limits_hz();
        (high - low) / (self.n_lines() - 1) as f64
    }
}

fn check_lines(frequency_hz: &[f64]) -> Result<(), Error> {
    let n = frequency_hz.len();
    if n < MIN_LINES {
        return Err(Error::new(
            Code::TooShort,
            format!("{n} lines are too few to find a mode in; {MIN_LINES} are the least"),
        )
        .with_hint("take a longer record or a wider band"));
    }
    if let Some(i) = frequency_hz
        .iter()
        .position(|f| !(f.is_finite() && *f >= 0.0))
    {
        return Err(Error::new(
            Code::NotANumber,
            format!("line {} is at {} Hz", i + 1, frequency_hz[i]),
        )
        .with_hint("frequencies must be finite and not negative"));
    }
    match frequency_hz.windows(2).position(|w| w[1] <= w[0]) {
        None => Ok(()),
        Some(i) => Err(Error::new(
            Code::InvalidTimeStamps,
            format!(
                "line {} at {} Hz does not lie above the one before it, at {} Hz",
                i + 2,
                frequency_hz[i + 1],
                frequency_hz[i]
            ),
        )
        .with_hint("sort the lines by frequency and drop repeated ones")),
    }
}

fn check_response(
    frequency_hz: &[f64],
    h: &[Complex],
    output: usize,
    input: usize,
) -> Result<(), Error> {
    let name = format!(
        "the response of output {} to input {}",
        output + 1,
        input + 1
    );
    if h.len() != frequency_hz.len() {
        return Err(Error::new(
            Code::IllPosed,
            format!(
                "{name} has {} values for {} lines",
                h.len(),
                frequency_hz.len()
            ),
        )
        .with_hint("give every response one value a line"));
    }
    if let Some(i) = h
        .iter()
        .position(|z| !(z.re.is_finite() && z.im.is_finite() && z.norm_sqr().is_finite()))
    {
        return Err(Error::new(
            Code::NotANumber,
            format!(
                "{name} is {} + {} i at {} Hz",
                h[i].re, h[i].im, frequency_hz[i]
            ),
        )
        .with_hint("remove this line from every response, or measure it again"));
    }
    let mean = h.iter().fold(Complex::ZERO, |s, z| s + z) / h.len() as f64;
    let (largest, spread) = h.iter().fold((0.0_f64, 0.0_f64), |(a, b), z| {
        (a.max(z.norm()), b.max((z - mean).norm()))
    });
    if spread <= CONSTANT_TOLERANCE * largest {
        let what = if largest == 0.0 { "zero" } else { "constant" };
        return Err(
            Error::new(Code::NoSignal, format!("{name} is {what} over all lines"))
                .with_hint("omit this output"),
        );
    }
    Ok(())
}
