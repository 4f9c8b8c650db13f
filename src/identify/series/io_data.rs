//! Output and optional input a model is fitted to, validated.

use crate::base::code::Code;
use crate::base::error::Error;
use crate::identify::validation::{check_rate, check_samples};

/// One output and, where there is one, the input that drives it, sampled together.
#[derive(Debug, Clone, Copy)]
pub struct InputOutputData<'a> {
    output: &'a [f64],
    input: Option<&'a [f64]>,
    rate_hz: f64,
}

impl<'a> InputOutputData<'a> {
    /// An output alone.
    ///
    /// # Errors
    /// `OutOfRange` for a rate that is not positive; `EmptyLog`, `NotANumber`, `NoSignal` for samples that are absent, not finite or
    /// constant.
    pub fn new(output: &'a [f64], rate_hz: f64) -> Result<InputOutputData<'a>, Error> {
        check_rate(rate_hz)?;
        check_samples(output, "the output")?;
        Ok(InputOutputData {
            output,
            input: None,
            rate_hz,
        })
    }

    /// The same with the input that drives it.
    ///
    /// # Errors
    /// As [`InputOutputData::new`]; `OutOfRange` where the lengths differ.
    pub fn with_input(self, input: &'a [f64]) -> Result<InputOutputData<'a>, Error> {
        check_samples(input, "the input")?;
        if input.len() != self.output.len() {
            let (u, y) = (input.len(), self.output.len());
            return Err(Error::new(
                Code::OutOfRange,
                format!("the input has {u} samples and the output {y}"),
            )
            .with_hint("cut both from the same segment of the record"));
        }
        Ok(InputOutputData {
            input: Some(input),
            ..self
        })
    }

    /// Samples of the output.
    pub fn output(&self) -> &'a [f64] {
        self.output
    }

    /// Samples of the input.
    pub fn input(&self) -> Option<&'a [f64]> {
        self.input
    }

    /// Sample rate, Hz.
    pub fn rate_hz(&self) -> f64 {
        self.rate_hz
    }

    /// Number of samples.
    pub(super) fn samples(&self) -> usize {
        self.output.len()
    }
}

/// The samples without their mean, and the mean.
pub(super) fn remove_mean(samples: &[f64]) -> (Vec<f64>, f64) {
    let level = samples.iter().sum::<f64>() / samples.len() as f64;
    (samples.iter().map(|x| x - level).collect(), level)
}

/// Refuses an order of zero, and fewer samples than fit `unknowns` with `lost` samples needed to start.
pub(super) fn check_order(samples: usize, unknowns: usize, lost: usize) -> Result<(), Error> {
    if unknowns == 0 {
        return Err(Error::new(
            Code::OutOfRange,
            "a model of order 0 has no coefficient to fit",
        )
        .with_hint("give an order of 1 or more; two per mode is the least"));
    }
    if samples <= lost + unknowns {
        return Err(Error::new(
            Code::TooShort,
            format!("{samples} samples, {lost} of them only to start the recursion, are too few for {unknowns} unknowns"),
        )
        .with_hint(format!(
            "take more than {} samples (ten times as many for useful intervals), or lower the order",
            lost + unknowns
        )));
    }
    Ok(())
}
