//! Common-pole fit problem: `H_q(iω) ≈ Σ_k R_qk/(iω − p_k) + D_q + iω E_q`, weighted.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::identify::transfer::function::{DirectTerms, TransferFunction};
use crate::numeric::Complex;
use crate::numeric::sorting::sort_rising;
use crate::recording::frequency_responses::ChannelLabel;

/// Which terms next to the poles are fitted, and how long.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CommonPoleOptions {
    /// D.
    pub constant: bool,
    /// E.
    pub slope: bool,
    /// Maximum number of iterations; they end earlier once the poles have converged.
    pub iterations: usize,
    /// Mirror poles of the right half plane to the left.
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

/// Common poles, and every response's residues.
#[derive(Debug, Clone)]
pub struct CommonPoleFit {
    /// Poles on and above the real axis, rad/s, by rising size; those above represent their conjugates too.
    pub poles: Vec<Complex>,
    /// One list for each response, in the order of the poles; units of the response times rad/s.
    pub residues: Vec<Vec<Complex>>,
    /// Terms next to the poles, one for each response.
    pub direct: Vec<DirectTerms>,
    /// Root of the mean square misfit of each response, as a share of its root mean square over the lines (unweighted).
    pub errors: Vec<f64>,
    /// Iterations used.
    pub iterations: usize,
}

impl CommonPoleFit {
    /// The number of poles with conjugates.
    pub fn order(&self) -> usize {
        self.poles
            .iter()
            .map(|p| if p.im > 0.0 { 2 } else { 1 })
            .sum()
    }

    /// Every response as a transfer function to its output.
    ///
    /// # Errors
    /// `Conflict` where there are not as many outputs as responses.
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
        let one = |(q, output): (usize, &ChannelLabel)| {
            let f = TransferFunction::new(
                self.poles.clone(),
                self.residues[q].clone(),
                self.direct[q],
            )?;
            let mut f = f.with_labels(input.cloned(), output.clone());
            f.fit_error = Some(self.errors[q]);
            Ok(f)
        };
        outputs.iter().enumerate().map(one).collect()
    }
}

/// Checked data; frequencies as shares of the highest line.
pub(super) struct CommonPoleProblem<'a> {
    /// The highest line, rad/s.
    pub scale: f64,
    /// Lines, shares of the highest.
    pub omega: Vec<f64>,
    pub responses: &'a [Vec<Complex>],
    /// One list for all responses, or one for each.
    pub weights: Vec<Vec<f64>>,
    /// Scale factor of each response, in addition to its weights: 1 over its rms where no weights are given, else 1; 0 where it is nil.
    pub factors: Vec<f64>,
    pub options: CommonPoleOptions,
}

impl<'a> CommonPoleProblem<'a> {
    /// Refuses what cannot be fitted. `order` is the number of poles, conjugates included.
    pub fn new(
        frequency_hz: &[f64],
        responses: &'a [Vec<Complex>],
        weights: Option<&[Vec<f64>]>,
        order: usize,
        options: CommonPoleOptions,
    ) -> Result<CommonPoleProblem<'a>, Error> {
        let lines = check_lines(frequency_hz)?;
        let sizes = check_responses(frequency_hz, responses)?;
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
                let factor = |&size: &f64| if size > 0.0 { 1.0 / size } else { 0.0 };
                (vec![vec![1.0; lines]], sizes.iter().map(factor).collect())
            }
            Some(given) => {
                check_weights(given, responses)?;
                let alike = given.iter().all(|w| *w == given[0]);
                let factor = |&size: &f64| f64::from(u8::from(size > 0.0));
                let kept = if alike { &given[..1] } else { given };
                (kept.to_vec(), sizes.iter().map(factor).collect())
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

    /// The weights of a response.
    pub fn weight(&self, response: usize) -> &[f64] {
        &self.weights[if self.weights.len() == 1 { 0 } else { response }]
    }

    /// Poles as shares of the highest line, back to rad/s, by rising size; mirrored if the options require it.
    pub fn rescale_poles(&self, poles: &mut Vec<Complex>) {
        poles.retain(|p| p.re.is_finite() && p.im.is_finite() && p.im >= 0.0);
        if self.options.stable {
            poles
                .iter_mut()
                .filter(|p| p.re > 0.0)
                .for_each(|p| p.re = -p.re);
        }
        sort_rising(poles, |a| a.norm());
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
            "line {} at {} Hz does not lie above {} Hz",
            k + 1,
            frequency_hz[k + 1],
            frequency_hz[k]
        );
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("sort the lines, and join those that repeat"));
    }
    match frequency_hz.last() {
        Some(&last) if last > 0.0 => Ok(frequency_hz.len()),
        _ => Err(
            Error::new(Code::TooShort, "the responses have no line above 0 Hz")
                .with_hint("widen the band"),
        ),
    }
}

/// The root mean square of each.
fn check_responses(frequency_hz: &[f64], responses: &[Vec<Complex>]) -> Result<Vec<f64>, Error> {
    let mut sizes = Vec::with_capacity(responses.len());
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
                .with_hint("leave that line out of every response"));
        }
        let largest = response.iter().map(|z| z.norm()).fold(0.0, f64::max);
        let share = |z: &Complex| (z.norm() / largest).powi(2);
        let mean = response.iter().map(share).sum::<f64>() / response.len() as f64;
        sizes.push(if largest > 0.0 {
            largest * mean.sqrt()
        } else {
            0.0
        });
    }
    if sizes.iter().all(|&size| size == 0.0) {
        let message = match responses.len() {
            0 => "there is no response to fit".to_string(),
            n => format!("all {n} responses are zero at every line"),
        };
        return Err(Error::new(Code::NoSignal, message)
            .with_hint("choose a channel that responds to the input"));
    }
    Ok(sizes)
}

fn check_weights(weights: &[Vec<f64>], responses: &[Vec<Complex>]) -> Result<(), Error> {
    let fits = weights.len() == responses.len()
        && weights
            .iter()
            .zip(responses)
            .all(|(w, r)| w.len() == r.len());
    if !fits {
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
                .with_hint("weights are finite and not negative"));
        }
    }
    Ok(())
}
