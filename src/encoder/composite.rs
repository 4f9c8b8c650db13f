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

/// Maximum number of samples of a record between its cells; in longer records extremes are missed by more, which is reported.
const MAX_SAMPLES: usize = 1 << 22;

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
    let parts = (if wanted.is_finite() { wanted } else { 1.0 } as usize)
        .min(MAX_SAMPLES / count.max(1))
        .max(1);
    let missed = 2.0 * bend / (parts as f64).powi(2);
    let waves = |weight: &dyn Fn(f64) -> f64| {
        let (orders, waves): (Vec<CandidateOrder>, Vec<Complex>) =
            (orders.iter().zip(&fitted.waves))
                .map(|(o, w)| (o.clone(), *w * weight(o.value)))
                .filter(|(_, w)| *w != Complex::ZERO)
                .unzip();
        let mut fine = AngularSignal {
            samples_per_rev: signal.samples_per_rev * parts,
            first: signal.first * parts as i64,
            values: vec![0.0; count * parts],
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
    let of = |values: &[f64]| -> Result<(f64, WindowedRanges), Error> {
        let record = SingleFlankRecord::new(values, turns, last, closed)?;
        Ok((record.total_deviation(), record.ranges_per_pitch()))
    };
    let rest = SingleFlankRecord::new(&fitted.residual[..count], turns, last, closed)?;

    let mut values = waves(&|_| 1.0);
    let record = SingleFlankRecord::new(&values, turns, last, closed)?;
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
    add_interpolated(&mut values, &fitted.residual[..count], next, parts);
    let record = SingleFlankRecord::new(&values, turns, last, closed)?;
    let (total, by_turn, by_pitch) = (
        record.total_deviation(),
        record.ranges_per_rev(),
        record.ranges_per_pitch(),
    );

    let split = |weight: &dyn Fn(f64) -> f64, rest: &[f64]| -> Result<_, Error> {
        let mut long = waves(weight);
        let end = if closed { rest[0] } else { rest[count - 1] };
        add_interpolated(&mut long, rest, end, parts);
        let short: Vec<f64> = values.iter().zip(&long).map(|(e, l)| e - l).collect();
        let (range, short) = (of(&long)?.0, of(&short)?.1);
        Ok((long, range, short))
    };
    let below = |order: f64| f64::from(u8::from(order < 0.5 * z));
    let (long, long_range, short) = split(&below, &rest.split_by_order().long)?;
    let mean = |order: f64| sinc(order / z);
    let (_, long_by_mean, short_by_mean) = split(&mean, &rest.split_by_pitch_average().long)?;
    let composite = CompositeDeviations {
        turns,
        closed,
        total,
        per_rev: by_turn,
        per_pitch: by_pitch,
        long_wave_component: (long_range, long_by_mean),
        short_wave_component: (short, short_by_mean),
        long_wave: long.into_iter().step_by(parts).collect(),
    };
    Ok((composite, of_orders))
}

/// Adds the linear interpolation of cells to `parts` values a cell; `next` is the value after the last.
fn add_interpolated(to: &mut [f64], cells: &[f64], next: f64, parts: usize) {
    let after = cells.iter().skip(1).chain(std::iter::once(&next));
    for ((fine, a), b) in to.chunks_mut(parts).zip(cells).zip(after) {
        for (k, x) in fine.iter_mut().enumerate() {
            *x += a + (b - a) * (k as f64 / parts as f64);
        }
    }
}
