//! Evaluation of one flank: order amplitudes with confidence intervals, long- and short-wave components, shaft averages.

use super::composite::{CompositeDeviations, FittedDeviations, composite_deviations};
use super::fit::fit_orders;
use super::gear_train::GearTrain;
use super::interval::amplitude_interval;
use super::noise::{NoiseLevel, ResidualSpectrum};
use super::orders::{
    CandidateOrder, KnownOrders, MIN_SEPARATION, OrderList, OrderRange, UnresolvedOrder,
};
use super::resampling::RESAMPLING_ERROR;
use super::residual_steps::{ResidualStep, find_residual_steps};
use super::shaft_average::{ShaftAverage, shaft_averages};
use crate::base::error::Error;
use crate::numeric::sorting::sort_ascending;
use crate::numeric::symmetric::lu_solve;
use crate::numeric::{Complex, Matrix};
use crate::spectrum::rotation::angular_resampling::AngularSignal;

/// Estimated spectral line of a known order: `amplitude · cos(order · φ + phase)`, φ the angle of the output.
#[derive(Debug, Clone)]
pub struct OrderEstimate {
    /// Order per output revolution.
    pub order: CandidateOrder,
    /// Amplitude (0 to peak) of all sources of this order, rad of the output.
    pub amplitude: f64,
    /// Phase, rad.
    pub phase: f64,
    /// Phase relative to an index mark, rad, and the shaft of the mark; for integer multiples of that shaft's rotation.
    pub mark_phase: Option<(f64, &'static str)>,
    /// Standard deviation of the amplitude, rad; that of the phase, rad: this over the amplitude.
    pub deviation: f64,
    /// Confidence interval of the amplitude (95 %), widened by the resampling error, rad; `None` for orders not resolved from another.
    pub interval: Option<(f64, f64)>,
    /// Deviation of the input from uniform rotation at this order, and the standard deviation of each quadrature, rad of the output.
    pub input: Option<(Complex, f64)>,
    /// True for an order significant above the noise, at 99.9 % over all orders examined.
    pub significant: bool,
}

/// Spectral line without a known source.
#[derive(Debug, Clone, PartialEq)]
pub struct UnidentifiedLine {
    /// Order per output revolution.
    pub order: f64,
    /// Uncertainty of the order: half the line spacing.
    pub order_uncertainty: f64,
    /// Amplitude (0 to peak), rad of the output.
    pub amplitude: f64,
    /// Lowest multiple of a shaft or mesh order within [`UnidentifiedLine::order_uncertainty`].
    pub nearest: Option<String>,
}

/// Transmission error of one flank: orders, deviations, noise, averages.
#[derive(Debug, Clone)]
pub struct FlankEvaluation {
    /// True for increasing input angle.
    pub forward: bool,
    /// Transmission error about its mean over the output angle, rad of the output.
    pub signal: AngularSignal,
    /// Mean of the transmission error, rad of the output.
    pub mean: f64,
    /// Length of the record, output revolutions.
    pub turns: f64,
    /// Lines of known orders, ascending.
    pub lines: Vec<OrderEstimate>,
    /// Lines of no known order, the strongest first.
    pub unexplained: Vec<UnidentifiedLine>,
    /// Residual noise without the fitted orders, rms, rad.
    pub noise: f64,
    /// Composite deviations of the record.
    pub composite: CompositeDeviations,
    /// Composite deviations of the fitted orders, without quantisation and noise.
    pub fitted: FittedDeviations,
    /// Steps of lost or extra counts in the residual of the fit.
    pub steps: Vec<ResidualStep>,
    /// Synchronous averages of the shafts with two revolutions or more, output first.
    pub shaft_averages: Vec<ShaftAverage>,
}

/// Options of the evaluation of a flank.
pub struct FlankOptions<'a> {
    /// Gear train between the encoders.
    pub teeth: &'a GearTrain,
    /// Number of mesh harmonics.
    pub multiples: usize,
    /// Highest order, per output revolution.
    pub band: f64,
    /// Orders known from a model.
    pub known_orders: &'a KnownOrders,
    /// Fits every multiple of the shafts, not only the significant ones.
    pub all_multiples: bool,
    /// Relative amplitude error by resampling.
    pub error: f64,
    /// Origin of the input angle, output revolutions.
    pub input_mark: f64,
    /// Smallest angle of an encoder count, rad of the output; infinite for encoders without counts.
    pub count_step: f64,
}

/// False-alarm rate of significance: one line in a thousand records is reported as significant and is not.
pub const FALSE_ALARM_RATE: f64 = 1e-3;

/// Maximum number of listed lines without a known order.
const MAX_UNIDENTIFIED: usize = 20;

/// Evaluates the transmission error of one flank.
///
/// # Errors
/// Fewer than one revolution; orders that cannot be fitted.
pub fn evaluate_flank(
    mut signal: AngularSignal,
    input: Option<&AngularSignal>,
    forward: bool,
    search: &FlankOptions,
) -> Result<FlankEvaluation, Error> {
    signal.check_revolutions(1)?;
    let turns = signal.values.len() as f64 / signal.samples_per_rev as f64;
    let range = OrderRange {
        band: search.band,
        turns,
    };
    let mut list = OrderList::default();
    for (order, name) in &search.known_orders.declared {
        list.insert(order.clone(), name.clone());
    }
    list.add_gear_train(search.teeth, search.multiples);
    let mut orders = list.resolve(range, &mut Vec::new());
    let mut extended = OrderList::default();
    for (order, name) in &search.known_orders.possible {
        // Orders of sources outside the encoders; a fitted order within the resolution takes precedence.
        let is_near =
            |o: &CandidateOrder| (o.value - order.to_f64()).abs() < MIN_SEPARATION / turns;
        if !orders.iter().any(is_near) {
            extended.insert(order.clone(), name.clone());
        }
    }
    extended.add_extended(search.teeth, search.multiples);
    let mut candidates = extended.resolve(range, &mut orders);
    if search.all_multiples {
        orders.append(&mut candidates);
    }
    let mut fit = fit_orders(&signal, &orders)?;
    let residual_spectrum = |values: &[f64], orders: &[CandidateOrder]| {
        ResidualSpectrum::new(values, signal.samples_per_rev, orders, search.band)
    };
    let mut spectrum = residual_spectrum(&fit.residual, &orders);
    // Significant orders among the candidates are fitted as well; twice, as strong orders mask weak ones.
    for _ in 0..2 {
        let threshold = (candidates.len().max(1) as f64 / FALSE_ALARM_RATE).ln();
        let (strong, weak): (Vec<CandidateOrder>, Vec<CandidateOrder>) = candidates
            .into_iter()
            .partition(|o| spectrum.noise_ratio(o.value) > threshold);
        candidates = weak;
        if strong.is_empty() {
            break;
        }
        orders.extend(strong);
        fit = fit_orders(&signal, &orders)?;
        spectrum = residual_spectrum(&fit.residual, &orders);
    }
    // The largest amplitude bounds the resampling error of all lines.
    let largest = fit.waves.iter().map(|z| z.norm()).fold(0.0, f64::max);
    let steps = find_residual_steps(
        &signal,
        &orders,
        &fit.residual,
        signal.samples_per_rev / search.teeth.output_teeth().max(1),
        search.count_step,
    )?;
    let mut unexplained = unidentified_lines(&mut spectrum, RESAMPLING_ERROR * largest);
    unexplained
        .iter_mut()
        .for_each(|u| u.nearest = nearest(search.teeth, u.order, u.order_uncertainty));
    let averages = shaft_averages(&signal, &fit, &orders, search.teeth, search.input_mark);
    let (composite, mut fitted) =
        composite_deviations(&signal, &fit, &orders, search.teeth, search.error)?;
    let input_fit = input.map(|i| input_waves(i, &orders, search)).transpose()?;
    let mut lines: Vec<OrderEstimate> = Vec::with_capacity(orders.len());
    let count = orders.len().max(1) as f64;
    let mut variance = 0.0;
    for (k, ((order, wave), factor)) in (orders.into_iter().zip(&fit.waves))
        .zip(&fit.variance_factor)
        .enumerate()
    {
        let level = spectrum.noise_level(order.value).unwrap_or(NoiseLevel {
            variance: 0.0,
            dof: 1.0,
        });
        let deviation = (level.variance * factor).sqrt();
        let amplitude = wave.norm();
        variance += deviation.powi(2);
        let resolved = order.unresolved.is_empty();
        let bound = search.error * amplitude;
        let interval = || {
            let (low, high) = amplitude_interval(amplitude, deviation, level.dof);
            ((low - bound).max(0.0), high + bound)
        };
        lines.push(OrderEstimate {
            amplitude,
            phase: wave.im.atan2(wave.re),
            mark_phase: None,
            deviation,
            interval: resolved.then(interval),
            input: input_fit.as_ref().map(|waves| waves[k]),
            significant: amplitude.powi(2)
                > 2.0 * deviation.powi(2) * (count / FALSE_ALARM_RATE).ln(),
            order,
        });
    }
    sort_ascending(&mut lines, |a| a.order.value);
    let squares: f64 = fit.residual.iter().map(|r| r * r).sum();
    signal.values.iter_mut().for_each(|e| *e -= fit.mean);
    // Each amplitude contributes its variance to the error at an angle; a range is the difference of two angles.
    fitted.deviation = (2.0 * variance).sqrt();
    Ok(FlankEvaluation {
        fitted,
        steps,
        forward,
        mean: fit.mean,
        turns,
        lines,
        unexplained,
        noise: (squares / fit.residual.len() as f64).sqrt(),
        composite,
        shaft_averages: averages,
        signal,
    })
}

/// Significant lines without a known order; they are excluded from the noise estimate.
fn unidentified_lines(spectrum: &mut ResidualSpectrum, floor: f64) -> Vec<UnidentifiedLine> {
    let mut lines = Vec::new();
    let threshold = (spectrum.line_count().max(1) as f64 / FALSE_ALARM_RATE).ln();
    while lines.len() < MAX_UNIDENTIFIED {
        let Some((order, amplitude, noise_ratio)) = spectrum.strongest_line() else {
            break;
        };
        if !(noise_ratio > threshold && amplitude > floor) {
            break;
        }
        spectrum.exclude(order);
        lines.push(UnidentifiedLine {
            order,
            order_uncertainty: 0.5 * spectrum.spacing(),
            amplitude,
            nearest: None,
        });
    }
    lines
}

/// Deviation of the input from uniform rotation at every order. The drift of speed, a cubic of the angle, is fitted jointly with the
/// waves: removed before, it would absorb a share of the slow waves, and the remainder would leak into every order.
fn input_waves(
    input: &AngularSignal,
    orders: &[CandidateOrder],
    search: &FlankOptions,
) -> Result<Vec<(Complex, f64)>, Error> {
    let mut signal = input.clone();
    remove_drift(&mut signal, orders)?;
    let fit = fit_orders(&signal, orders)?;
    let noise = ResidualSpectrum::new(&fit.residual, signal.samples_per_rev, orders, search.band);
    let estimate = |((order, wave), factor): ((&CandidateOrder, &Complex), &f64)| {
        let variance = noise.noise_level(order.value).map_or(0.0, |l| l.variance);
        (*wave, (variance * factor).sqrt())
    };
    let waves = orders.iter().zip(&fit.waves);
    Ok(waves.zip(&fit.variance_factor).map(estimate).collect())
}

/// Subtracts the cubic of a joint fit with the waves: `a = G⁻¹ ⟨p⊥, x⟩`, `G = ⟨p⊥, p⊥⟩`, p⊥ the residuals of the Legendre
/// polynomials after a fit of the waves.
fn remove_drift(signal: &mut AngularSignal, orders: &[CandidateOrder]) -> Result<(), Error> {
    let shapes: [fn(f64) -> f64; 3] = [|x| x, |x| 1.5 * x * x - 0.5, |x| 2.5 * x * x * x - 1.5 * x];
    let n = signal.values.len();
    let x = |i: usize| 2.0 * i as f64 / (n.max(2) as f64 - 1.0) - 1.0;
    let residual = |shape: &fn(f64) -> f64| {
        let polynomial = AngularSignal {
            values: (0..n).map(|i| shape(x(i))).collect(),
            ..*signal
        };
        fit_orders(&polynomial, orders).map(|fit| fit.residual)
    };
    let residuals: Vec<Vec<f64>> = shapes.iter().map(residual).collect::<Result<_, _>>()?;
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let gram = Matrix::from_fn(3, 3, |i, j| dot(&residuals[i], &residuals[j]));
    let right = Matrix::from_fn(3, 1, |i, _| dot(&residuals[i], &signal.values));
    let coefficients = lu_solve(&gram, &right)?;
    for (i, v) in signal.values.iter_mut().enumerate() {
        let polynomial = shapes
            .iter()
            .enumerate()
            .map(|(k, s)| coefficients[(k, 0)] * s(x(i)));
        *v -= polynomial.sum::<f64>();
    }
    Ok(())
}

/// Lowest multiple of a shaft or mesh order within `tolerance` of an order.
fn nearest(teeth: &GearTrain, order: f64, tolerance: f64) -> Option<String> {
    let (shafts, meshes) = (teeth.shafts(), teeth.meshes());
    let nearest_multiple = |member: &super::gear_train::OrderSource| {
        let unit = member.order.to_f64();
        let n = (order / unit).round();
        let near = n >= 1.0 && (n * unit - order).abs() <= tolerance;
        // Multiples of a slow shaft are so dense that a coincidence has no significance.
        let is_sparse = unit > 4.0 * tolerance;
        (near && is_sparse).then(|| (n, member.name.clone()))
    };
    let multiples = shafts.iter().chain(&meshes).filter_map(nearest_multiple);
    let lowest = multiples.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(match lowest.0 {
        1.0 => lowest.1,
        n => format!("{n} × {}", lowest.1),
    })
}

impl OrderEstimate {
    /// True for an order of several sources; their amplitudes cannot be separated.
    pub fn is_shared(&self) -> bool {
        self.order.names.len() > 1
    }

    /// Orders that the record does not resolve from this one.
    pub fn unresolved(&self) -> &[UnresolvedOrder] {
        &self.order.unresolved
    }
}
