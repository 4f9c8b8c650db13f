//! Rational fit: common poles of many FRFs by maximum likelihood, no initial values needed.
//!
//! Poles are added for as long as the misfit, weighed with the variance of the lines, falls by more than noise would make it fall
//! anywhere in the band. The poles are then refined to the least weighted squares, where their covariance is the inverse of the
//! information in the data.

use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::numeric::Complex;

use super::modal_parameters::ModalParameters;

pub mod basis;

mod scan;

mod projection;

mod line_compression;

mod scaled_responses;

mod variance;

mod local_fit;

mod covariance;

mod model_error;

mod windowed;

mod scatter;

mod pole_significance;

mod random_effects;

mod groups;

mod stepwise;

mod term_selection;

mod delay;

mod model_error_search;

mod search;

mod mode_acceptance;

mod widening;

mod assemble_fit;

mod repeatability;

pub mod residual_delay;

pub use basis::ModelTerms;

use basis::ScaledPole;
use search::SearchResult;

/// Frequency responses over common lines.
#[derive(Debug, Clone, Copy)]
pub struct FrfData<'a> {
    /// Lines, Hz, rising; a line at zero is left out.
    pub frequency_hz: &'a [f64],
    /// Values by response and line, of any unit.
    pub responses: &'a [Vec<Complex>],
    /// `E|error|²` of each value, where known.
    pub variance: Option<&'a [Vec<f64>]>,
    /// Complex degrees of freedom of each variance, infinite where it is known: single lines are then trusted, and the covariance is scaled
    /// by the misfit only if the excess is significant. `None` where it is an estimate of unknown certainty.
    pub variance_dof: Option<f64>,
    /// Standard deviation of the frequencies that the window of averaged blocks of noise joins in a line, Hz: it makes damping appear
    /// larger. 0 without a window.
    pub smearing_hz: f64,
    /// Number of independent noise samples a line holds: 1 for independent lines, below where a window or overlap makes neighbours alike
    /// (two thirds with a Hann window). Above 0, at most 1.
    pub line_independence: f64,
    /// Power of s that makes a receptance this kind of response: 1 for mobilities, 2 for accelerances, 0 for anything else.
    pub derivative: u8,
    /// The responses are averages over these hits.
    pub hits: Option<ResponsesByHit<'a>>,
}

/// Responses hit by hit. Poles are then found from all of them, each with residues and noise of its own, and are the mean over the hits.
#[derive(Debug, Clone, Copy)]
pub struct ResponsesByHit<'a> {
    /// By hit, in the order of [`FrfData::responses`], over the same lines.
    pub responses: &'a [Vec<Vec<Complex>>],
    /// Hits that each of them joins, on average: 1 where it is of one hit.
    pub hits_per_group: f64,
    /// Power of a fourth difference of neighbouring lines over that of their noise: 70 for independent lines, less under a window.
    pub fourth_difference_gain: f64,
}

/// A pure delay of the measuring chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DelayModel {
    /// There is none.
    #[default]
    None,
    /// One for all responses.
    Common,
    /// One for each response.
    PerResponse,
}

/// Options of a rational fit.
#[derive(Debug, Clone, Copy)]
pub struct RationalOptions {
    /// Lines used, Hz; all where `None`.
    pub band_hz: Option<(f64, f64)>,
    /// Most pole pairs of responses that depart from the model by more than their noise.
    pub max_poles: usize,
    /// So many pole pairs, instead of as many as are significant.
    pub order: Option<usize>,
    /// Poles may lie in the right half plane.
    pub allow_unstable: bool,
    /// A delay to be estimated with the poles.
    pub delay: DelayModel,
}

impl Default for RationalOptions {
    fn default() -> RationalOptions {
        RationalOptions {
            band_hz: None,
            max_poles: 40,
            order: None,
            allow_unstable: false,
            delay: DelayModel::None,
        }
    }
}

/// A number of poles that was tried.
#[derive(Debug, Clone, PartialEq)]
pub struct SelectionStep {
    /// Pole pairs before.
    pub poles_before: usize,
    /// Pole pairs tried.
    pub poles_after: usize,
    /// Weighted misfit before.
    pub chi2_before: f64,
    /// Weighted misfit with them.
    pub chi2_after: f64,
    /// Probability that noise alone gives such a fall somewhere in the band.
    pub probability: f64,
    /// They were kept.
    pub accepted: bool,
    /// Why not; empty where accepted.
    pub reason: String,
}

impl SelectionStep {
    /// One sentence, without full stop: `stopped at 5 pole pairs: another would lower the misfit by 0.12 %, no more than noise gives
    /// somewhere in the band of one record in 3`.
    pub fn description(&self) -> String {
        /// Least probability reported as due to chance.
        const MIN_REPORTED_P_VALUE: f64 = 1e-3;
        let fall = 100.0 * (1.0 - self.chi2_after / self.chi2_before).max(0.0);
        let fall = match fall {
            fall if fall < 0.01 => "less than 0.01".to_string(),
            fall => format!("{fall:.2}"),
        };
        let before = pluralise(self.poles_before, "pole pair");
        let (another, lowers) = match self.poles_after.saturating_sub(self.poles_before) {
            1 => ("another".to_string(), "lowers"),
            n => (format!("{n} more"), "lower"),
        };
        if self.accepted {
            return format!("{another} next to {before} {lowers} the misfit by {fall} %: kept");
        }
        let chance = match self.probability {
            p if !(p > MIN_REPORTED_P_VALUE && self.reason == stepwise::REASON_NOISE) => {
                String::new()
            }
            p if p > 0.5 => " of most records".to_string(),
            p => format!(" of one record in {:.0}", 1.0 / p),
        };
        format!(
            "stopped at {before}: {another} would lower the misfit by {fall} %, {}{chance}",
            self.reason
        )
    }
}

/// A pole that is not reported as a mode.
#[derive(Debug, Clone, PartialEq)]
pub struct RejectedPole {
    /// The pole, rad/s.
    pub pole: Complex,
    /// Why.
    pub reason: &'static str,
}

/// Departure of a mode from the linear model with common poles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModelErrorShare {
    /// Residual at the mode beyond the noise, as a share of the mode's own value.
    pub model_error: f64,
    /// Hits that see it, or responses where no hits are known; zero for a single hit and for two responses.
    pub groups: usize,
    /// Standard deviation of their own frequencies beyond what their noise explains, Hz; zero where that is no more than their uncertainty.
    pub frequency_spread_hz: f64,
    /// That of their damping ratios.
    pub damping_spread: f64,
    /// The groups are hits.
    pub by_hit: bool,
    /// Ratio of Student's 97.5 % quantile to the normal one, by which the difference of two hits widens the interval; 1 for more hits,
    /// and where they do not differ.
    pub two_hit_factor: f64,
}

/// Computational effort of a fit.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FitEffort {
    /// Scans for places.
    pub scans: usize,
    /// Steps of all poles together.
    pub steps: usize,
    /// Estimates of the variance.
    pub rounds: usize,
    /// Operations of the growth, about, without those by sub-bands.
    pub work: f64,
    /// Wall time, s.
    pub seconds: f64,
}

/// Rational functions fitted to frequency responses: poles, residues and accepted modes.
#[derive(Debug, Clone)]
pub struct RationalFit {
    /// Accepted modes, by rising frequency; shapes over the responses.
    pub modes: Vec<ModalParameters>,
    /// Departure of each mode from the model; empty where noise alone explains the responses, and no hits are known.
    pub departures: Vec<ModelErrorShare>,
    /// Every pole of the upper half plane, rad/s, by rising frequency.
    pub poles: Vec<Complex>,
    /// Residues `R` by response and pole, in the unit of the response times rad/s over that of `s^q`.
    pub residues: Vec<Vec<Complex>>,
    /// `L` and `U` by response; zero where the structure has none.
    pub residual_terms: Vec<[f64; 2]>,
    /// Delays, s: none, one, or one per response.
    pub delay_s: Vec<f64>,
    /// Standard deviations of the delays, s.
    pub delay_std_s: Vec<Option<f64>>,
    /// The power q of s.
    pub derivative: u8,
    /// Root mean square misfit over that of the response, by response.
    pub fit_error: Vec<f64>,
    /// Weighted misfit.
    pub chi2: f64,
    /// Data less parameters, by independent lines.
    pub dof: f64,
    /// The negative logarithm of the likelihood, but for a constant of the data, with the variance that the fit ended with.
    pub negative_log_likelihood: f64,
    /// Selection steps tried.
    pub evidence: Vec<SelectionStep>,
    /// Terms of the fit.
    pub structure: ModelTerms,
    /// Poles that are not reported as modes.
    pub omitted: Vec<RejectedPole>,
    /// Noise alone does not explain the responses.
    pub departs: bool,
    /// Warnings.
    pub diagnostics: Vec<Diagnostic>,
    /// Computational effort.
    pub effort: FitEffort,
}

impl RationalFit {
    /// The fitted responses at a frequency, Hz, in the unit measured.
    pub fn synthesise(&self, frequency_hz: f64) -> Vec<Complex> {
        let s = Complex::new(0.0, std::f64::consts::TAU * frequency_hz);
        let power = (0..self.derivative).fold(Complex::new(1.0, 0.0), |z, _| z * s);
        (0..self.residues.len())
            .map(|i| {
                let [lower, upper] = self.residual_terms[i];
                let mut sum = Complex::new(upper, 0.0);
                if lower != 0.0 {
                    sum += lower / (s * s);
                }
                for (p, r) in self.poles.iter().zip(&self.residues[i]) {
                    sum += r / (s - p) + r.conj() / (s - p.conj());
                }
                let delay = match self.delay_s.len() {
                    0 => 0.0,
                    n => self.delay_s[i.min(n - 1)],
                };
                power * sum * (-s * delay).exp()
            })
            .collect()
    }
}

/// Fits common poles to responses.
///
/// # Errors
/// `OutOfRange` where a frequency, a value or a variance is not finite, frequencies do not rise, or more poles are asked for than the lines determine; `Conflict` where lengths differ;
/// `TooShort` for fewer than eight lines in the band; `NoSignal` where every response is zero.
pub fn fit(measured: &FrfData, options: &RationalOptions) -> Result<RationalFit, Error> {
    fit_with(measured, options, None)
}

/// The same from poles at hand (rad/s, of the upper half plane, say of vector fitting), none added: they are refined together, and the
/// weakest is taken out for as long as what it explains is no more than noise gives. Poles that damp so much or lie so far off that
/// the residual terms stand for them are left aside.
///
/// # Errors
/// As [`fit`].
pub fn fit_from_poles(
    measured: &FrfData,
    options: &RationalOptions,
    poles: &[Complex],
) -> Result<RationalFit, Error> {
    fit_with(measured, options, Some(poles))
}

fn fit_with(
    measured: &FrfData,
    options: &RationalOptions,
    from: Option<&[Complex]>,
) -> Result<RationalFit, Error> {
    let started = std::time::Instant::now();
    let lines = scaled_responses::ScaledResponses::new(measured, options)?;
    let determined = search::max_determined_poles(&lines, usize::MAX);
    if let Some(order) = options.order
        && order > determined
    {
        let message = format!(
            "{order} pole pairs are requested, but {} determine at most {determined}",
            pluralise(lines.x.len(), "line")
        );
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("request fewer, widen the band, or measure with finer lines"));
    }
    let from: Option<Vec<ScaledPole>> = from.map(|poles| {
        let near = |p: &&Complex| p.im > p.re.abs() && p.norm() < lines.max_omega;
        let inside = poles.iter().filter(near);
        let starts = inside.map(|p| ScaledPole::new(*p, lines.max_omega));
        starts.take(determined).collect()
    });
    // A delay turns every line of the average alike.
    let by_hit = match options.delay {
        DelayModel::None => scaled_responses::ScaledResponses::split_by_hit(measured, options)?,
        _ => None,
    };
    let (searched, average) = match &by_hit {
        Some(each) => (each, Some(lines.average_of(each))),
        None => (&lines, None),
    };
    let trusted = measured.variance_dof == Some(f64::INFINITY) && by_hit.is_none();
    let mut found = search::search(
        searched,
        average.as_ref(),
        options,
        trusted,
        from.as_deref(),
    );
    let (evidence, at_limit, mut effort) = (found.evidence.clone(), found.at_limit, found.effort);
    let mut fit = loop {
        if average.is_some() {
            found.repeats = repeatability::repeating_residues(&found, searched);
            found = found.fit_responses(&lines);
        }
        let (fit, needless) = assemble_fit::assemble_fit(measured, &lines, found);
        if needless.is_empty() || options.order.is_some() {
            break fit;
        }
        let left = (0..fit.poles.len()).filter(|place| !needless.contains(place));
        let poles: Vec<ScaledPole> = left
            .map(|place| ScaledPole::new(fit.poles[place], lines.max_omega))
            .collect();
        found = SearchResult {
            evidence: evidence.clone(),
            at_limit,
            ..search::refit_with_model_error(searched, options, trusted, &poles, &mut effort)
        };
        found.effort = effort;
    };
    fit.effort.seconds = started.elapsed().as_secs_f64();
    Ok(fit)
}
