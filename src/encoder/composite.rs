//! Single-flank composite deviations F_i′, f_i′, with long-wave and short-wave components.
//!
//! Between the cells the record is `e(φ) = Σ A cos(oφ + ψ) + r(φ)`: the fitted orders, and the residual by linear interpolation.
//!
//! The separation of fitted orders is exact: orders below z/2 are the long wave; the mean over a pitch passes `sinc(o/z)` of each. The
//! residual is separated by filters, with end effects. With samples at spacing h the error of an extreme is at most `h² Σ A o²/8`.

use std::f64::consts::{PI, TAU};

use super::fit::{HarmonicFit, add};
use super::gear_train::GearTrain;
use super::orders::CandidateOrder;
use crate::base::error::Error;
use crate::numeric::Complex;
use crate::numeric::statistics::peak_to_peak;
use crate::spectrum::kaiser_fir::sinc;
use crate::spectrum::rotation::angular_resampling::AngularSignal;
use crate::te_record::single_flank::SingleFlankRecord;
use crate::te_record::windowed_ranges::WindowedRanges;

/// Single-flank composite deviations of a record of complete revolutions, rad of the output.
#[derive(Debug, Clone)]
pub struct CompositeDeviations {
    /// Number of output revolutions: complete hunting cycles if the record covers one.
    pub turns: usize,
    /// True for complete hunting cycles.
    pub closed: bool,
    /// F_i′ over all revolutions, rad.
    pub total: f64,
    /// F_i′ per revolution, rad.
    pub per_rev: WindowedRanges,
    /// f_i′ of the unfiltered record per pitch, and tooth by tooth, rad.
    pub per_pitch: WindowedRanges,
    /// f_l′ by orders below z/2, and by the mean over a pitch, rad.
    pub long_wave_component: (f64, f64),
    /// f_k′ by the same two separations, rad.
    pub short_wave_component: (WindowedRanges, WindowedRanges),
    /// Long-wave component by orders, per cell, rad.
    pub long_wave: Vec<f64>,
}

/// Single-flank composite deviations of the fitted orders alone.
#[derive(Debug, Clone, Copy)]
pub struct FittedDeviations {
    /// F_i′ over all revolutions, rad.
    pub total: f64,
    /// F_i′ per revolution, rad.
    pub per_rev: f64,
    /// f_i′ as the maximum over a sliding pitch, rad.
    pub per_pitch: f64,
    /// Standard deviation of a range as a difference of two values, from the deviations of all amplitudes, rad.
    pub deviation: f64,
    /// Bound of the additional error of F_i′ by resampling and by the sample spacing, rad.
    pub bound: f64,
    /// Bound of the additional error of f_i′, rad.
    pub bound_by_pitch: f64,
}

/// Largest error of an extreme by the sample spacing, relative to the resampling error.
const MAX_EXTREME_ERROR: f64 = 0.1;

/// Maximum number of samples of the refined record; longer records are refined less.
const MAX_SAMPLES: usize = 1 << 21;

/// Composite deviations over all complete hunting cycles of the flank, or over complete revolutions of a shorter record; `error`:
/// relative amplitude error by resampling.
///
/// # Errors
/// Fewer than one revolution, fewer than two cells per pitch.
pub fn composite_deviations(
    signal: &AngularSignal,
    fitted: &HarmonicFit,
    orders: &[CandidateOrder],
    teeth: &GearTrain,
    error: f64,
) -> Result<(CompositeDeviations, FittedDeviations), Error> {
    let hunting = teeth.hunting_turns().to_f64();
    let cycles = (signal.revolutions() as f64 / hunting).floor();
    let closed = cycles >= 1.0;
    let turns = match closed {
        true => (cycles * hunting).round() as usize,
        false => signal.revolutions(),
    };
    let count = turns * signal.samples_per_rev;
    let n_teeth = teeth.output_teeth();
    let z = n_teeth as f64;
    let terms = || (fitted.waves.iter().zip(orders)).map(|(w, o)| (w.norm(), o.value));
    let sum: f64 = terms().map(|(a, _)| a).sum();
    // Largest error of an extreme between the cells.
    let sagitta = terms().map(|(a, o)| a * (TAU * o).powi(2)).sum::<f64>()
        / (8.0 * (signal.samples_per_rev as f64).powi(2));
    let required = (sagitta / (MAX_EXTREME_ERROR * error * sum)).sqrt().ceil();
    let required = if required.is_finite() { required } else { 1.0 } as usize;
    // Samples per cell within the limit of memory.
    let factor_for = |cells: usize| required.min(MAX_SAMPLES / cells.max(1)).max(1);
    let factor = factor_for(count);
    let waves = |weight: &dyn Fn(f64) -> f64, cells: usize, factor: usize| {
        let (orders, waves): (Vec<CandidateOrder>, Vec<Complex>) =
            (orders.iter().zip(&fitted.waves))
                .map(|(o, w)| (o.clone(), *w * weight(o.value)))
                .filter(|(_, w)| *w != Complex::ZERO)
                .unzip();
        let mut fine = AngularSignal {
            samples_per_rev: signal.samples_per_rev * factor,
            first: signal.first * factor as i64,
            values: vec![0.0; cells * factor],
        };
        add(&mut fine, &orders, &waves);
        fine.values
    };
    let next = match closed {
        true => fitted.residual[0],
        false => *fitted
            .residual
            .get(count)
            .unwrap_or(&fitted.residual[count - 1]),
    };
    let residual = SingleFlankRecord::new(&fitted.residual[..count], turns, n_teeth, closed)?;

    // Orders periodic in the hunting cycle need one cycle only.
    let cycle = teeth.hunting_turns();
    let is_periodic = |o: &CandidateOrder| (&o.fraction * &cycle).is_integer();
    let order_turns = match closed && orders.iter().all(is_periodic) {
        true => hunting.round() as usize,
        false => turns,
    };
    let cells = order_turns * signal.samples_per_rev;
    let order_factor = factor_for(cells);
    let sampling_error = 2.0 * sagitta / (order_factor as f64).powi(2);
    let values = waves(&|_| 1.0, cells, order_factor);
    let record = SingleFlankRecord::new(&values, order_turns, n_teeth, closed)?;
    let from_orders = FittedDeviations {
        total: record.total_deviation(),
        per_rev: record.ranges_per_rev().sliding,
        per_pitch: record.ranges_per_pitch().sliding,
        deviation: 0.0,
        bound: sampling_error + 2.0 * error * sum,
        bound_by_pitch: sampling_error
            + terms()
                .map(|(a, o)| 2.0 * error * a * (PI * (o / z).min(0.5)).sin())
                .sum::<f64>(),
    };

    let mut values = waves(&|_| 1.0, count, factor);
    add_interpolated(&mut values, &fitted.residual[..count], next, factor);
    let record = SingleFlankRecord::new(&values, turns, n_teeth, closed)?;
    let (total, per_rev, per_pitch) = (
        record.total_deviation(),
        record.ranges_per_rev(),
        record.ranges_per_pitch(),
    );

    // Long wave per cell, its range, and the ranges of the short wave.
    let split = |weight: &dyn Fn(f64) -> f64, mut long: Vec<f64>| -> Result<_, Error> {
        let mut wave = waves(weight, count, factor);
        let end = if closed { long[0] } else { long[count - 1] };
        add_interpolated(&mut wave, &long, end, factor);
        (long.iter_mut().zip(wave.iter().step_by(factor))).for_each(|(l, w)| *l = *w);
        let range = peak_to_peak(&wave);
        (wave.iter_mut().zip(&values)).for_each(|(w, e)| *w = e - *w);
        let short = SingleFlankRecord::new(&wave, turns, n_teeth, closed)?.ranges_per_pitch();
        Ok((long, range, short))
    };
    let below = |order: f64| f64::from(u8::from(order < 0.5 * z));
    let (long_wave, long_range, short) = split(&below, residual.long_wave_by_order())?;
    let mean = |order: f64| sinc(order / z);
    let (_, long_by_mean, short_by_mean) = split(&mean, residual.long_wave_by_pitch_average())?;
    let composite = CompositeDeviations {
        turns,
        closed,
        total,
        per_rev,
        per_pitch,
        long_wave_component: (long_range, long_by_mean),
        short_wave_component: (short, short_by_mean),
        long_wave,
    };
    Ok((composite, from_orders))
}

/// Adds cell values linearly interpolated to `factor` values per cell; `next` is the value after the last cell.
fn add_interpolated(values: &mut [f64], cells: &[f64], next: f64, factor: usize) {
    let after = cells.iter().skip(1).chain(std::iter::once(&next));
    for k in 0..factor {
        let weight = k as f64 / factor as f64;
        let fine = values.iter_mut().skip(k).step_by(factor);
        let pairs = cells.iter().zip(after.clone());
        (fine.zip(pairs)).for_each(|(x, (a, b))| *x += a + (b - a) * weight);
    }
}
