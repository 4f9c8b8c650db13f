//! Evaluation of one flank: orders with intervals, long and short wave, shaft averages.

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
use crate::numeric::sorting::sort_rising;
use crate::numeric::symmetric::lu_solve;
use crate::numeric::{Complex, Matrix};
use crate::spectrum::rotation::angular_resampling::AngularSignal;

/// A line of a known order: `amplitude · cos(order · φ + phase)`, φ the angle of the output.
#[derive(Debug, Clone)]
pub struct OrderEstimate {
    /// Per turn of the output.
    pub order: CandidateOrder,
    /// Zero to peak, rad of the output; of all that has this order together.
    pub amplitude: f64,
    /// Rad.
    pub phase: f64,
    /// The phase over the angle from a mark, and the shaft of the mark: of orders that repeat with each of its turns.
    pub mark_phase: Option<(f64, &'static str)>,
    /// Standard deviation of the amplitude, rad; that of the phase is this over the amplitude.
    pub deviation: f64,
    /// Confidence interval of the true amplitude (95 %), widened by the error of the cells; absent where the record does not resolve the
    /// order from another.
    pub interval: Option<(f64, f64)>,
    /// Input motion at this order: its lead over uniform rotation, in rad of the output, and the deviation of either quadrature of that.
    pub input: Option<(Complex, f64)>,
    /// True where the order is significant above the noise, with 99.9 % over all lines examined.
    pub significant: bool,
}

/// A line that no shaft and no mesh makes.
#[derive(Debug, Clone, PartialEq)]
pub struct UnidentifiedLine {
    /// Per turn of the output.
    pub order: f64,
    /// Uncertainty of the order: half the distance of two lines.
    pub order_uncertainty: f64,
    /// Zero to peak, rad.
    pub amplitude: f64,
    /// The lowest multiple of a shaft or of a mesh within [`UnidentifiedLine::order_uncertainty`].
    pub nearest: Option<String>,
}

/// Everything about one flank.
#[derive(Debug, Clone)]
pub struct FlankEvaluation {
    /// The input turned up.
    pub forward: bool,
    /// The record about its mean, rad of the output, over the angle of the output.
    pub signal: AngularSignal,
    /// The mean that was taken off, rad.
    pub mean: f64,
    /// Turns of the output.
    pub turns: f64,
    /// Lines of known orders, ascending.
    pub lines: Vec<OrderEstimate>,
    /// Lines of no known order, the strongest first.
    pub unexplained: Vec<UnidentifiedLine>,
    /// Residual noise without all lines, rms, rad.
    pub noise: f64,
    /// Ranges.
    pub composite: CompositeDeviations,
    /// Ranges of what the fitted orders make, without steps of encoders and noise.
    pub fitted: FittedDeviations,
    /// Steps of lost or extra counts that the orders leave.
    pub steps: Vec<ResidualStep>,
    /// The mean turns of the shafts that turn twice or more, the output's first.
    pub shaft_averages: Vec<ShaftAverage>,
}

/// Options of the evaluation of a flank.
pub struct FlankOptions<'a> {
    /// The train.
    pub teeth: &'a GearTrain,
    /// Multiples of the meshes.
    pub multiples: usize,
    /// The highest order.
    pub band: f64,
    /// Orders that a model names.
    pub known_orders: &'a KnownOrders,
    /// Fits every multiple of the shafts, not only the significant ones.
    pub all_multiples: bool,
    /// Relative error of a line from the cells.
    pub error: f64,
    /// Origin of the input's own angle, turns of the output.
    pub input_mark: f64,
    /// The smallest step that a count makes, rad of the output; infinite where no encoder has steps.
    pub count_step: f64,
}

/// False-alarm rate of significance: one line in a thousand records is reported as significant and is not.
pub const FALSE_ALARM_RATE: f64 = 1e-3;

/// Lines of no known order that are listed.
const MAX_UNIDENTIFIED: usize = 20;

/// Evaluates a record.
///
/// # Errors
/// Fewer than one turn; orders that cannot be fitted.
pub fn evaluate_flank(
    mut signal: AngularSignal,
    input: Option<&AngularSignal>,
    forward: bool,
    search: &FlankOptions,
) -> Result<FlankEvaluation, Error> {
    signal.check_revolutions(1)?;
    let turns = signal.values.len() as f64 / signal.samples_per_rev as f64;
    let reach = OrderRange {
        band: search.band,
        turns,
    };
    let mut list = OrderList::default();
    for (order, name) in &search.known_orders.declared {
        list.insert(order.clone(), name.clone());
    }
    list.add_gear_train(search.teeth, search.multiples);
    let mut orders = list.resolve(reach, &mut Vec::new());
    let mut more = OrderList::default();
    for (order, name) in &search.known_orders.possible {
        // It names what nothing between the encoders makes, and takes nothing from what is fitted.
        let is_near =
            |o: &CandidateOrder| (o.value - order.to_f64()).abs() < MIN_SEPARATION / turns;
        if !orders.iter().any(is_near) {
            more.insert(order.clone(), name.clone());
        }
    }
    more.add_extended(search.teeth, search.multiples);
    let mut candidates = more.resolve(reach, &mut orders);
    if search.all_multiples {
        orders.append(&mut candidates);
    }
    let mut found = fit_orders(&signal, &orders)?;
    let residual = |values: &[f64], orders: &[CandidateOrder]| {
        ResidualSpectrum::new(values, signal.samples_per_rev, orders, search.band)
    };
    let mut left = residual(&found.residual, &orders);
    // What stands out among the further orders is fitted as well; strong ones hide weaker ones, so twice.
    for _ in 0..2 {
        let least = (candidates.len().max(1) as f64 / FALSE_ALARM_RATE).ln();
        let (strong, weak): (Vec<CandidateOrder>, Vec<CandidateOrder>) = candidates
            .into_iter()
            .partition(|o| left.noise_ratio(o.value) > least);
        candidates = weak;
        if strong.is_empty() {
            break;
        }
        orders.extend(strong);
        found = fit_orders(&signal, &orders)?;
        left = residual(&found.residual, &orders);
    }
    // What the cells add to a line lies below this.
    let largest = found.waves.iter().map(|z| z.norm()).fold(0.0, f64::max);
    let steps = find_residual_steps(
        &signal,
        &orders,
        &found.residual,
        signal.samples_per_rev / search.teeth.output_teeth().max(1),
        search.count_step,
    )?;
    let mut unexplained = unidentified_lines(&mut left, RESAMPLING_ERROR * largest);
    unexplained
        .iter_mut()
        .for_each(|u| u.nearest = nearest(search.teeth, u.order, u.order_uncertainty));
    let mean_turns = shaft_averages(&signal, &found, &orders, search.teeth, search.input_mark);
    let (composite, mut of_orders) =
        composite_deviations(&signal, &found, &orders, search.teeth, search.error)?;
    let of_input = input.map(|i| input_waves(i, &orders, search)).transpose()?;
    let mut lines: Vec<OrderEstimate> = Vec::with_capacity(orders.len());
    let count = orders.len().max(1) as f64;
    let mut variance = 0.0;
    for (k, ((order, wave), spread)) in (orders.into_iter().zip(&found.waves))
        .zip(&found.variance_factor)
        .enumerate()
    {
        let level = left.noise_level(order.value).unwrap_or(NoiseLevel {
            variance: 0.0,
            dof: 1.0,
        });
        let deviation = (level.variance * spread).sqrt();
        let amplitude = wave.norm();
        variance += deviation.powi(2);
        let alone = order.unresolved.is_empty();
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
            interval: alone.then(interval),
            input: of_input.as_ref().map(|all| all[k]),
            significant: amplitude.powi(2)
                > 2.0 * deviation.powi(2) * (count / FALSE_ALARM_RATE).ln(),
            order,
        });
    }
    sort_rising(&mut lines, |a| a.order.value);
    let square: f64 = found.residual.iter().map(|r| r * r).sum();
    signal.values.iter_mut().for_each(|e| *e -= found.mean);
    // Each quadrature has the deviation of its wave: either angle has its variance, and a range is a difference of two.
    of_orders.deviation = (2.0 * variance).sqrt();
    Ok(FlankEvaluation {
        fitted: of_orders,
        steps,
        forward,
        mean: found.mean,
        turns,
        lines,
        unexplained,
        noise: (square / found.residual.len() as f64).sqrt(),
        composite,
        shaft_averages: mean_turns,
        signal,
    })
}

/// Significant lines of no known order; noise is no longer read from them.
fn unidentified_lines(left: &mut ResidualSpectrum, floor: f64) -> Vec<UnidentifiedLine> {
    let mut all = Vec::new();
    let least = (left.line_count().max(1) as f64 / FALSE_ALARM_RATE).ln();
    while all.len() < MAX_UNIDENTIFIED {
        let Some((order, amplitude, out)) = left.strongest_line() else {
            break;
        };
        if !(out > least && amplitude > floor) {
            break;
        }
        left.exclude(order);
        all.push(UnidentifiedLine {
            order,
            order_uncertainty: 0.5 * left.spacing(),
            amplitude,
            nearest: None,
        });
    }
    all
}

/// Deviation of the input from uniform rotation, at every order. Slow changes of speed, a polynomial of the angle, are fitted with
/// the waves at once: taken off before, they would take a part of the slow waves, and what is left of that shows at every order.
fn input_waves(
    input: &AngularSignal,
    orders: &[CandidateOrder],
    search: &FlankOptions,
) -> Result<Vec<(Complex, f64)>, Error> {
    let mut signal = input.clone();
    remove_drift(&mut signal, orders)?;
    let found = fit_orders(&signal, orders)?;
    let left = ResidualSpectrum::new(&found.residual, signal.samples_per_rev, orders, search.band);
    let one = |((order, wave), spread): ((&CandidateOrder, &Complex), &f64)| {
        let variance = left.noise_level(order.value).map_or(0.0, |l| l.variance);
        (*wave, (variance * spread).sqrt())
    };
    let both = orders.iter().zip(&found.waves);
    Ok(both.zip(&found.variance_factor).map(one).collect())
}

/// Takes off the cubic that fits together with waves: with p⊥ what the waves leave of Legendre's polynomials, `a = G⁻¹ ⟨p⊥, x⟩`,
/// `G = ⟨p⊥, p⊥⟩`.
fn remove_drift(signal: &mut AngularSignal, orders: &[CandidateOrder]) -> Result<(), Error> {
    let shapes: [fn(f64) -> f64; 3] = [|x| x, |x| 1.5 * x * x - 0.5, |x| 2.5 * x * x * x - 1.5 * x];
    let n = signal.values.len();
    let at = |i: usize| 2.0 * i as f64 / (n.max(2) as f64 - 1.0) - 1.0;
    let apart = |shape: &fn(f64) -> f64| {
        let course = AngularSignal {
            values: (0..n).map(|i| shape(at(i))).collect(),
            ..*signal
        };
        fit_orders(&course, orders).map(|found| found.residual)
    };
    let apart: Vec<Vec<f64>> = shapes.iter().map(apart).collect::<Result<_, _>>()?;
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let gram = Matrix::from_fn(3, 3, |i, j| product(&apart[i], &apart[j]));
    let right = Matrix::from_fn(3, 1, |i, _| product(&apart[i], &signal.values));
    let sizes = lu_solve(&gram, &right)?;
    for (i, v) in signal.values.iter_mut().enumerate() {
        let course = shapes
            .iter()
            .enumerate()
            .map(|(k, s)| sizes[(k, 0)] * s(at(i)));
        *v -= course.sum::<f64>();
    }
    Ok(())
}

/// The lowest multiple of a shaft or of a mesh within `order_uncertainty` of an order.
fn nearest(teeth: &GearTrain, order: f64, known_to: f64) -> Option<String> {
    let (shafts, meshes) = (teeth.shafts(), teeth.meshes());
    let one = |member: &super::gear_train::OrderSource| {
        let unit = member.order.to_f64();
        let n = (order / unit).round();
        let near = n >= 1.0 && (n * unit - order).abs() <= known_to;
        // A fine order is near some multiple of any slow shaft: that says nothing.
        let tells = unit > 4.0 * known_to;
        (near && tells).then(|| (n, member.name.clone()))
    };
    let found = shafts.iter().chain(&meshes).filter_map(one);
    let least = found.min_by(|a, b| a.0.total_cmp(&b.0))?;
    Some(match least.0 {
        1.0 => least.1,
        n => format!("{n} × {}", least.1),
    })
}

impl OrderEstimate {
    /// Sources of this order next to the first: they have no amplitude of their own.
    pub fn is_shared(&self) -> bool {
        self.order.names.len() > 1
    }

    /// Orders that the record does not resolve from this one.
    pub fn unresolved(&self) -> &[UnresolvedOrder] {
        &self.order.unresolved
    }
}
