//! Single-flank composite deviations F_i′, f_i′, with long-wave and short-wave components.
//!
//! Between the cells the record is `e(φ) = Σ A cos(oφ + ψ) + r(φ)`: the fitted orders as they are, what they leave straight.
//!
//! Parted exactly where orders are known: those below z/2 are the long wave, the mean over a pitch passes `sinc(o/z)` of each. What the
//! orders leave alone is parted by filters, which know nothing of it beyond its ends. Read at steps h, an extreme is missed by no more
//! than `h² Σ A o²/8`.

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

/// Composite deviations read from whole turns.
#[derive(Debug, Clone)]
pub struct CompositeDeviations {
    /// Whole turns of the output: whole hunting cycles where the record holds one.
    pub turns: usize,
    /// They are whole hunting cycles.
    pub closed: bool,
    /// F_i′ over all of them.
    pub total: f64,
    /// F_i′ in one turn.
    pub per_rev: WindowedRanges,
    /// f_i′ of the raw record in one pitch, and tooth by tooth.
    pub per_pitch: WindowedRanges,
    /// f_l′ by orders below z/2, and by the mean over a pitch.
    pub long_wave_component: (f64, f64),
    /// f_k′ likewise.
    pub short_wave_component: (WindowedRanges, WindowedRanges),
    /// The long wave by orders in the cells of these turns.
    pub long_wave: Vec<f64>,
}

/// Composite deviations of the whole turns from the fitted orders.
#[derive(Debug, Clone, Copy)]
pub struct FittedDeviations {
    /// F_i′ over all of them, rad.
    pub total: f64,
    /// F_i′ in one turn, rad.
    pub per_rev: f64,
    /// f_i′, the pitch slid freely, rad.
    pub per_pitch: f64,
    /// Standard deviation of a range: of the difference of two angles, from those of all amplitudes, rad.
    pub deviation: f64,
    /// Bound on the additional error of F_i′ from the cells and from the steps of the search for extremes, rad.
    pub bound: f64,
    /// The same of f_i′, rad.
    pub bound_by_pitch: f64,
}

/// Extremes are missed by no more than this share of what the cells lose.
const MAX_EXTREME_ERROR: f64 = 0.1;

/// Maximum number of samples of a record between its cells; in longer records extremes between the cells may be missed.
const MAX_SAMPLES: usize = 1 << 21;

/// Ranges over the most whole hunting cycles of the flank, or over whole turns where it holds none; `error` is what the cells may lose of
/// an order, relative.
///
/// # Errors
/// Fewer than one turn, fewer than two cells a pitch.
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
    let last = teeth.output_teeth();
    let z = last as f64;
    let sizes = || (fitted.waves.iter().zip(orders)).map(|(w, o)| (w.norm(), o.value));
    let sum: f64 = sizes().map(|(a, _)| a).sum();
    // Of half the squared step of the cells.
    let bend = sizes().map(|(a, o)| a * (TAU * o).powi(2)).sum::<f64>()
        / (8.0 * (signal.samples_per_rev as f64).powi(2));
    let wanted = (bend / (MAX_EXTREME_ERROR * error * sum)).sqrt().ceil();
    let wanted = if wanted.is_finite() { wanted } else { 1.0 } as usize;
    // Samples a cell, as far as the room allows.
    let parts_of = |cells: usize| wanted.min(MAX_SAMPLES / cells.max(1)).max(1);
    let parts = parts_of(count);
    let waves = |weight: &dyn Fn(f64) -> f64, cells: usize, parts: usize| {
        let (orders, waves): (Vec<CandidateOrder>, Vec<Complex>) =
            (orders.iter().zip(&fitted.waves))
                .map(|(o, w)| (o.clone(), *w * weight(o.value)))
                .filter(|(_, w)| *w != Complex::ZERO)
                .unzip();
        let mut fine = AngularSignal {
            samples_per_rev: signal.samples_per_rev * parts,
            first: signal.first * parts as i64,
            values: vec![0.0; cells * parts],
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
    let rest = SingleFlankRecord::new(&fitted.residual[..count], turns, last, closed)?;

    // Of orders that repeat with the hunting cycle one cycle says all.
    let cycle = teeth.hunting_turns();
    let repeat = |o: &CandidateOrder| (&o.fraction * &cycle).is_integer();
    let turns_of_orders = match closed && orders.iter().all(repeat) {
        true => hunting.round() as usize,
        false => turns,
    };
    let cells = turns_of_orders * signal.samples_per_rev;
    let parts_of_orders = parts_of(cells);
    let missed = 2.0 * bend / (parts_of_orders as f64).powi(2);
    let values = waves(&|_| 1.0, cells, parts_of_orders);
    let record = SingleFlankRecord::new(&values, turns_of_orders, last, closed)?;
    let of_orders = FittedDeviations {
        total: record.total_deviation(),
        per_rev: record.ranges_per_rev().sliding,
        per_pitch: record.ranges_per_pitch().sliding,
        deviation: 0.0,
        bound: missed + 2.0 * error * sum,
        bound_by_pitch: missed
            + sizes()
                .map(|(a, o)| 2.0 * error * a * (PI * (o / z).min(0.5)).sin())
                .sum::<f64>(),
    };

    let mut values = waves(&|_| 1.0, count, parts);
    add_interpolated(&mut values, &fitted.residual[..count], next, parts);
    let record = SingleFlankRecord::new(&values, turns, last, closed)?;
    let (total, by_turn, by_pitch) = (
        record.total_deviation(),
        record.ranges_per_rev(),
        record.ranges_per_pitch(),
    );

    // The long wave in the cells, its range, and the ranges of the short one.
    let split = |weight: &dyn Fn(f64) -> f64, mut long: Vec<f64>| -> Result<_, Error> {
        let mut wave = waves(weight, count, parts);
        let end = if closed { long[0] } else { long[count - 1] };
        add_interpolated(&mut wave, &long, end, parts);
        (long.iter_mut().zip(wave.iter().step_by(parts))).for_each(|(l, w)| *l = *w);
        let range = peak_to_peak(&wave);
        (wave.iter_mut().zip(&values)).for_each(|(w, e)| *w = e - *w);
        let short = SingleFlankRecord::new(&wave, turns, last, closed)?.ranges_per_pitch();
        Ok((long, range, short))
    };
    let below = |order: f64| f64::from(u8::from(order < 0.5 * z));
    let (long_wave, long_range, short) = split(&below, rest.long_wave_by_order())?;
    let mean = |order: f64| sinc(order / z);
    let (_, long_by_mean, short_by_mean) = split(&mean, rest.long_wave_by_pitch_average())?;
    let composite = CompositeDeviations {
        turns,
        closed,
        total,
        per_rev: by_turn,
        per_pitch: by_pitch,
        long_wave_component: (long_range, long_by_mean),
        short_wave_component: (short, short_by_mean),
        long_wave,
    };
    Ok((composite, of_orders))
}

/// Adds the linear interpolation of cells to `parts` values a cell; `next` is the value after the last.
fn add_interpolated(to: &mut [f64], cells: &[f64], next: f64, parts: usize) {
    let after = cells.iter().skip(1).chain(std::iter::once(&next));
    for k in 0..parts {
        let share = k as f64 / parts as f64;
        let fine = to.iter_mut().skip(k).step_by(parts);
        let pairs = cells.iter().zip(after.clone());
        (fine.zip(pairs)).for_each(|(x, (a, b))| *x += a + (b - a) * share);
    }
}
