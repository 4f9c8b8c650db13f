//! One flank: its record over even cells, split into orders with intervals, into long and short waves, and averaged over turns.

use super::cells::ERROR;
use super::fit::fit;
use super::interval::of_amplitude;
use super::noise::{Level, Residual};
use super::orders::{APART, Named, Near, Order, OrderList, Reach};
use super::teeth::Teeth;
use crate::base::error::Error;
use crate::gear::measurement::composite::Record;
use crate::gear::measurement::ranges::Ranges;
use crate::spectrum::rotation::angular::AngularSignal;
use crate::spectrum::rotation::averaging::TurnAverage;

/// A line of a known order: `amplitude · cos(order · φ + phase)`, φ the angle of the output.
#[derive(Debug, Clone)]
pub struct Line {
    /// Per turn of the output.
    pub order: Order,
    /// Zero to peak, rad of the output; of all that has this order together.
    pub amplitude: f64,
    /// Rad.
    pub phase: f64,
    /// Standard deviation of the amplitude, rad; that of the phase is this over the amplitude.
    pub deviation: f64,
    /// Where the true amplitude lies with 95 %; nothing where the record does not tell the order from another.
    pub interval: Option<(f64, f64)>,
    /// It stands out of the noise, with 99.9 % over all lines looked at.
    pub significant: bool,
}

/// A line that no shaft and no mesh makes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unexplained {
    /// Per turn of the output.
    pub order: f64,
    /// How exactly: half the distance of two lines.
    pub known_to: f64,
    /// Zero to peak, rad.
    pub amplitude: f64,
}

/// What is read from whole turns.
#[derive(Debug, Clone)]
pub struct Composite {
    /// Whole turns of the output.
    pub turns: usize,
    /// They are whole hunting cycles.
    pub closed: bool,
    /// F_i′ over all of them.
    pub total: f64,
    /// F_i′ in one turn.
    pub by_turn: Ranges,
    /// f_i′ of the raw record in one pitch, and tooth by tooth.
    pub by_pitch: Ranges,
    /// f_l′ by orders below z/2, and by the mean over a pitch.
    pub long: (f64, f64),
    /// f_k′ likewise.
    pub short: (Ranges, Ranges),
    /// The long wave by orders, over these turns.
    pub long_wave: Vec<f64>,
}

/// Everything about one flank.
#[derive(Debug, Clone)]
pub struct Flank {
    /// The input turned up.
    pub forward: bool,
    /// The record about its mean, rad of the output, over the angle of the output.
    pub signal: AngularSignal,
    /// The mean that was taken off, rad.
    pub mean: f64,
    /// Turns of the output.
    pub turns: f64,
    /// Lines of known orders, ascending.
    pub lines: Vec<Line>,
    /// Lines of no known order, the strongest first.
    pub unexplained: Vec<Unexplained>,
    /// What is left beside all lines, rms, rad.
    pub noise: f64,
    /// Ranges.
    pub composite: Composite,
    /// The mean over turns of the output, where there are two or more.
    pub average: Option<TurnAverage>,
}

/// What is looked for.
pub struct Search<'a> {
    /// The train.
    pub teeth: &'a Teeth,
    /// Multiples of the meshes.
    pub multiples: usize,
    /// The highest order.
    pub band: f64,
    /// Orders that a model names.
    pub named: &'a Named,
}

/// Of one line in a thousand records it is said that it stands out, and does not.
const FALSE_ALARM: f64 = 1e-3;

/// Lines of no known order that are listed.
const LISTED: usize = 20;

/// Evaluates a record.
///
/// # Errors
/// Fewer than one turn; orders that cannot be fitted.
pub fn flank(mut signal: AngularSignal, forward: bool, search: &Search) -> Result<Flank, Error> {
    signal.check_turns(1)?;
    let turns = signal.values.len() as f64 / signal.per_turn as f64;
    let reach = Reach {
        band: search.band,
        turns,
    };
    let mut list = OrderList::default();
    for (order, name) in &search.named.declared {
        list.put(order.clone(), name.clone());
    }
    list.with_train(search.teeth, search.multiples);
    let mut orders = list.resolved(reach, &mut Vec::new());
    let mut more = OrderList::default();
    for (order, name) in &search.named.possible {
        // It names what nothing between the encoders makes, and takes nothing from what is fitted.
        let is_near = |o: &Order| (o.value - order.value()).abs() < APART / turns;
        if !orders.iter().any(is_near) {
            more.put(order.clone(), name.clone());
        }
    }
    more.with_more(search.teeth, search.multiples);
    let mut candidates = more.resolved(reach, &mut orders);
    let mut found = fit(&signal, &orders)?;
    let residual = |values: &[f64], orders: &[Order]| {
        Residual::new(values, signal.per_turn, orders, search.band)
    };
    let mut left = residual(&found.residual, &orders);
    // What stands out among the further orders is fitted as well; strong ones hide weaker ones, so twice.
    for _ in 0..2 {
        let least = (candidates.len().max(1) as f64 / FALSE_ALARM).ln();
        let (strong, weak): (Vec<Order>, Vec<Order>) = candidates
            .into_iter()
            .partition(|o| left.stands_out(o.value) > least);
        candidates = weak;
        if strong.is_empty() {
            break;
        }
        orders.extend(strong);
        found = fit(&signal, &orders)?;
        left = residual(&found.residual, &orders);
    }
    // What the cells add to a line lies below this.
    let largest = found.waves.iter().map(|z| z.norm()).fold(0.0, f64::max);
    let unexplained = unexplained(&mut left, ERROR * largest);
    let mut lines: Vec<Line> = Vec::with_capacity(orders.len());
    let count = orders.len().max(1) as f64;
    for ((order, wave), spread) in orders.into_iter().zip(&found.waves).zip(&found.spread) {
        let level = left.level(order.value).unwrap_or(Level {
            variance: 0.0,
            freedoms: 1.0,
        });
        let deviation = (level.variance * spread).sqrt();
        let amplitude = wave.norm();
        let alone = order.near.is_empty();
        lines.push(Line {
            amplitude,
            phase: wave.im.atan2(wave.re),
            deviation,
            interval: alone.then(|| of_amplitude(amplitude, deviation, level.freedoms)),
            significant: amplitude.powi(2) > 2.0 * deviation.powi(2) * (count / FALSE_ALARM).ln(),
            order,
        });
    }
    lines.sort_by(|a, b| a.order.value.total_cmp(&b.order.value));
    let square: f64 = found.residual.iter().map(|r| r * r).sum();
    signal.values.iter_mut().for_each(|e| *e -= found.mean);
    Ok(Flank {
        forward,
        mean: found.mean,
        turns,
        lines,
        unexplained,
        noise: (square / found.residual.len() as f64).sqrt(),
        composite: composite(&signal, search.teeth)?,
        average: (signal.turns() >= 2)
            .then(|| TurnAverage::new(&signal))
            .transpose()?,
        signal,
    })
}

/// Lines that stand out and have no known order; noise is no longer read from them.
fn unexplained(left: &mut Residual, floor: f64) -> Vec<Unexplained> {
    let mut all = Vec::new();
    let least = (left.lines().max(1) as f64 / FALSE_ALARM).ln();
    while all.len() < LISTED {
        let Some((order, amplitude, out)) = left.strongest() else {
            break;
        };
        if !(out > least && amplitude > floor) {
            break;
        }
        left.not_quiet(order);
        all.push(Unexplained {
            order,
            known_to: 0.5 * left.spacing(),
            amplitude,
        });
    }
    all
}

fn composite(signal: &AngularSignal, teeth: &Teeth) -> Result<Composite, Error> {
    let turns = signal.turns();
    let hunting = teeth.hunting_turns().value();
    let closed = (turns as f64 / hunting).fract() == 0.0;
    let values = &signal.values[..turns * signal.per_turn];
    let record = Record::new(values, turns, teeth.last(), closed)?;
    let by_order = record.split_by_order();
    let by_mean = record.split_by_pitch_average();
    Ok(Composite {
        turns,
        closed,
        total: record.total(),
        by_turn: record.by_turn(),
        by_pitch: record.by_pitch(),
        long: (by_order.long_range, by_mean.long_range),
        short: (by_order.short_ranges, by_mean.short_ranges),
        long_wave: by_order.long,
    })
}

impl Line {
    /// Sources of this order beside the first: they have no amplitude of their own.
    pub fn is_shared(&self) -> bool {
        self.order.names.len() > 1
    }

    /// What the record does not tell from it.
    pub fn near(&self) -> &[Near] {
        &self.order.near
    }
}
