//! Common-pole fit problem: `H_q(iω) ≈ Σ_k R_qk/(iω − p_k) + D_q + iω E_q`, weighted.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::identify::transfer::function::{DirectTerms, TransferFunction};
use crate::numeric::Complex;
use crate::numeric::sorting::sort_ascending;
use crate::recording::frequency_responses::ChannelLabel;

/// Terms of the fit in addition to the poles, and the limits of the iteration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommonPoleOptions {
    /// Fit the constant term D of each response.
    pub constant: bool,
    /// Fit the term E of each response, proportional to iω.
    pub slope: bool,
    /// Maximum number of iterations; the iteration ends earlier if the poles converge.
    pub iterations: usize,
    /// Mirror unstable poles (right half plane) into the left half plane.
    pub stable: bool,
}

impl Default for CommonPoleOptions {
    /// A constant, no slope, twenty iterations, poles mirrored.
    fn default() -> CommonPoleOptions {
        CommonPoleOptions {
            constant: true,
            slope: false,
            iterations: 20,
            stable: true,
        }
    }
}

/// Common poles with the residues and direct terms of every response.
#[derive(Debug, Clone)]
pub struct CommonPoleFit {
    /// Poles on and above the real axis, rad/s, by increasing modulus; those above the axis also represent their conjugates.
    pub poles: Vec<Complex>,
    /// Residues by response and pole; units of the response times rad/s.
    pub residues: Vec<Vec<Complex>>,
    /// Direct terms D and E, by response.
    pub direct: Vec<DirectTerms>,
    /// Relative rms error of each response over the lines, unweighted.
    pub errors: Vec<f64>,
    /// Number of iterations.
    pub iterations: usize,
}

impl CommonPoleFit {
    /// Model order: the number of poles, conjugates included.
    pub fn order(&self) -> usize {
        self.poles
            .iter()
            .map(|p| if p.im > 0.0 { 2 } else { 1 })
            .sum()
    }

    /// Transfer functions from the input to each output, one per response.
    ///
    /// # Errors
    /// `Conflict` if the number of outputs differs from the number of responses.
    pub fn transfer_functions(
        &self,
        input: Option<&ChannelLabel>,
        outputs: &[ChannelLabel],
    ) -> Result<Vec<TransferFunction>, Error> {
        if outputs.len() != self.residues.len() {
            let message = format!(
                "{} outputs are named for {} responses",
                outputs.len(),
                self.residues.len()
            );
            return Err(
                Error::new(Code::Conflict, message).with_hint("name one output for each response")
            );
        }
        let transfer_function = |(q, output): (usize, &ChannelLabel)| {
            let f = TransferFunction::new(
                self.poles.clone(),
                self.residues[q].clone(),
                self.direct[q],
            )?;
            let mut f = f.with_labels(input.cloned(), output.clone());
            f.fit_error = Some(self.errors[q]);
            Ok(f)
        };
        outputs.iter().enumerate().map(transfer_function).collect()
    }
}

/// Checked input of a common-pole fit; angular frequencies are relative to that of the highest line.
pub(super) struct CommonPoleProblem<'a> {
    /// Angular frequency of the highest line, rad/s.
    pub scale: f64,
    /// Angular frequencies of the lines relative to `scale`.
    pub omega: Vec<f64>,
    pub responses: &'a [Vec<Complex>],
    /// Weights by line: one list for all responses, or one for each response.
    pub weights: Vec<Vec<f64>>,
    /// Scale factor of each response, in addition to its weights: 1/rms if no weights are given, else 1; 0 for a zero response.
    pub factors: Vec<f64>,
    pub options: CommonPoleOptions,
}

impl<'a> CommonPoleProblem<'a> {
    /// Checks the data; returns an error if they do not determine a fit. `order` is the number of poles, conjugates included.
    pub fn new(
        frequency_hz: &[f64],
        responses: &'a [Vec<Complex>],
        weights: Option<&[Vec<f64>]>,
        order: usize,
        options: CommonPoleOptions,
    ) -> Result<CommonPoleProblem<'a>, Error> {
        let lines = check_lines(frequency_hz)?;
        let rms = check_responses(frequency_hz, responses)?;
        if order == 0 {
            return Err(
                Error::new(Code::OutOfRange, "a model of order 0 has no poles")
                    .with_hint("give the number of poles, two for each mode"),
            );
        }
        let direct = usize::from(options.constant) + usize::from(options.slope);
        let (equations, unknowns) = (
            2 * lines * responses.len(),
            (order + direct) * responses.len() + order,
        );
        if equations < unknowns {
            let message = format!(
                "{lines} lines of {} responses give {equations} real values for {unknowns} unknowns of order {order}",
                responses.len()
            );
            return Err(
                Error::new(Code::IllPosed, message).with_hint("lower the order, or widen the band")
            );
        }
        let scale = TAU * frequency_hz[lines - 1];
        let (weights, factors) = match weights {
            None => {
                let factor = |&x: &f64| if x > 0.0 { 1.0 / x } else { 0.0 };
                (vec![vec![1.0; lines]], rms.iter().map(factor).collect())
            }
            Some(lists) => {
                check_weights(lists, responses)?;
                let all_equal = lists.iter().all(|w| *w == lists[0]);
                let factor = |&x: &f64| f64::from(u8::from(x > 0.0));
                let distinct = if all_equal { &lists[..1] } else { lists };
                (distinct.to_vec(), rms.iter().map(factor).collect())
            }
        };
        let omega = frequency_hz.iter().map(|f| TAU * f / scale).collect();
        Ok(CommonPoleProblem {
            scale,
            omega,
            responses,
            weights,
            factors,
            options,
        })
    }

    /// Weights of a response by line.
    pub fn weight(&self, response: usize) -> &[f64] {
        &self.weights[if self.weights.len() == 1 { 0 } else { response }]
    }

    /// Removes poles of the lower half plane and sorts the others by modulus; mirrors unstable poles if the options require it.
    pub fn rescale_poles(&self, poles: &mut Vec<Complex>) {
        poles.retain(|p| p.re.is_finite() && p.im.is_finite() && p.im >= 0.0);
        if self.options.stable {
            poles
                .iter_mut()
                .filter(|p| p.re > 0.0)
                .for_each(|p| p.re = -p.re);
        }
        sort_ascending(poles, |a| a.norm());
    }
}

fn check_lines(frequency_hz: &[f64]) -> Result<usize, Error> {
    if let Some((k, f)) = frequency_hz
        .iter()
        .enumerate()
        .find(|(_, f)| !(f.is_finite() && **f >= 0.0))
    {
        let message = format!("line {k} of the responses is at {f} Hz");
        return Err(
            Error::new(Code::OutOfRange, message).with_hint("lines are finite and not negative")
        );
    }
    if let Some(k) = frequency_hz.windows(2).position(|w| w[1] <= w[0]) {
        let message = format!(
            "line {} at {} Hz is not above {} Hz",
            k + 1,
            frequency_hz[k + 1],
            frequency_hz[k]
        );
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("sort the lines and merge repeated ones"));
    }
    match frequency_hz.last() {
        Some(&last) if last > 0.0 => Ok(frequency_hz.len()),
        _ => Err(
            Error::new(Code::TooShort, "the responses have no line above 0 Hz")
                .with_hint("widen the band"),
        ),
    }
}

/// Rms value of each response over the lines.
fn check_responses(frequency_hz: &[f64], responses: &[Vec<Complex>]) -> Result<Vec<f64>, Error> {
    let mut rms = Vec::with_capacity(responses.len());
    for (q, response) in responses.iter().enumerate() {
        if response.len() != frequency_hz.len() {
            let message = format!(
                "response {q} has {} values at {} lines",
                response.len(),
                frequency_hz.len()
            );
            return Err(
                Error::new(Code::Conflict, message).with_hint("give one value for each line")
            );
        }
        if let Some(k) = response
            .iter()
            .position(|z| !(z.re.is_finite() && z.im.is_finite()))
        {
            let message = format!("response {q} is {} at {} Hz", response[k], frequency_hz[k]);
            return Err(Error::new(Code::NotANumber, message)
                .with_hint("remove that line from every response"));
        }
        let largest = response.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let share = |z: &Complex| (z.norm() / largest).powi(2);
        let mean = response.iter().map(share).sum::<f64>() / response.len() as f64;
        rms.push(if largest > 0.0 {
            largest * mean.sqrt()
        } else {
            0.0
        });
    }
    if rms.iter().all(|&x| x == 0.0) {
        let message = match responses.len() {
            0 => "there is no response to fit".to_string(),
            n => format!("all {n} responses are zero at every line"),
        };
        return Err(Error::new(Code::NoSignal, message)
            .with_hint("choose a channel that responds to the input"));
    }
    Ok(rms)
}

fn check_weights(weights: &[Vec<f64>], responses: &[Vec<Complex>]) -> Result<(), Error> {
    let lengths_match = weights.len() == responses.len()
        && weights
            .iter()
            .zip(responses)
            .all(|(w, r)| w.len() == r.len());
    if !lengths_match {
        let message = format!(
            "weights of {} responses do not match {} responses",
            weights.len(),
            responses.len()
        );
        return Err(Error::new(Code::Conflict, message)
            .with_hint("give one weight for each value, 1 over its standard deviation"));
    }
    for (q, list) in weights.iter().enumerate() {
        if let Some(w) = list.iter().find(|w| !(w.is_finite() && **w >= 0.0)) {
            let message = format!("a weight of response {q} is {w}");
            return Err(Error::new(Code::OutOfRange, message)
                .with_hint("weights must be finite and not negative"));
        }
    }
    Ok(())
}
