//! Order cuts of a measured run-up: `x(θ) = Σ Re A_o e^{ioθ}`, amplitude and phase of single orders over the speed.

use std::f64::consts::TAU;
use std::time::Instant;

use super::fault_free;
use super::order_spectra::{AngularSignals, resample_to_angle};
use super::spectrum_study::{SpectrumStudy, channel};
use crate::base::code::Code;
use crate::base::error::{Diagnostic, Error};
use crate::base::text::pluralise;
use crate::numeric::Complex;
use crate::recording::signals::{Channel, Recording};
use crate::spectrum::rotation::angular_resampling::AngularSignal;
use crate::spectrum::rotation::orders::{OrderTrackOptions, order_tracks};

/// Turns of a block times the distance of two orders: Hann's window then passes a thousandth of the other.
const RESOLVED: f64 = 4.0;

/// Blocks to one length of a block.
const OVERLAPS: usize = 4;

/// One order of one channel over a run.
#[derive(Debug, Clone)]
pub struct OrderCut {
    /// The channel.
    pub channel: String,
    /// Unit.
    pub unit: String,
    /// Cycles a turn.
    pub order: f64,
    /// Complex amplitude, zero to peak, its phase at the zero of the shaft's angle, by point.
    pub value: Vec<Complex>,
}

impl OrderCut {
    /// The point of the largest amplitude.
    pub fn largest(&self) -> Option<usize> {
        let size = |at: &usize| self.value[*at].norm();
        (0..self.value.len()).max_by(|a, b| size(a).total_cmp(&size(b)))
    }
}

/// Order cuts and how they were made.
#[derive(Debug)]
pub struct OrderCuts {
    /// Stages that ran, with seconds.
    pub trace: Vec<(&'static str, f64)>,
    /// In words.
    pub method_text: String,
    /// Turns in a block.
    pub turns: usize,
    /// Middle of each block, s from the first sample analysed.
    pub time_s: Vec<f64>,
    /// Speed there, rad/s.
    pub speed: Vec<f64>,
    /// Channel by channel, order by order.
    pub cuts: Vec<OrderCut>,
    /// Data-quality warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Cuts the orders of a study.
///
/// # Errors
/// No tacho and no speed, a tacho without pulses, orders beyond half the rate, fewer turns than a block.
pub fn order_cuts(recording: &Recording, study: &SpectrumStudy) -> Result<OrderCuts, Error> {
    let start = Instant::now();
    check_flags(study)?;
    let channels = (study.channels.iter())
        .map(|name| channel(recording, name))
        .collect::<Result<Vec<&Channel>, Error>>()?;
    let AngularSignals {
        signals,
        curve,
        max_order: highest,
        method_text: how,
        mut diagnostics,
    } = resample_to_angle(recording, &channels, study)?;
    let known: Vec<&str> = recording.channels.iter().map(|c| c.name.as_str()).collect();
    let place = |c: &&Channel| known.iter().position(|name| *name == c.name);
    let places: Vec<usize> = channels.iter().filter_map(place).collect();
    diagnostics.splice(0..0, fault_free::spectrum_warnings(recording, &places)?);
    if let Some(order) = study.cuts.iter().find(|order| **order > highest) {
        let message = format!(
            "order {order} lies beyond {highest:.2}, the highest that the rate of {} Hz keeps at the highest speed",
            recording.rate_hz
        );
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("choose lower orders, or leave the highest speed out: --before"));
    }
    let whole = signals
        .iter()
        .map(AngularSignal::revolutions)
        .min()
        .unwrap_or(0);
    let turns = study
        .revolutions
        .unwrap_or_else(|| block(&study.cuts, whole));
    let step = (turns / OVERLAPS).max(1);
    let settings = OrderTrackOptions {
        revolutions: turns,
        step,
    };
    let (mut cuts, mut times, mut speeds) = (Vec::new(), Vec::new(), Vec::new());
    for (signal, channel) in signals.iter().zip(&channels) {
        let found = order_tracks(signal, &curve, &study.cuts, settings)?;
        (times, speeds) = (found.time_s, found.speed);
        cuts.extend(found.tracks.into_iter().map(|track| OrderCut {
            channel: channel.name.clone(),
            unit: channel.unit.clone(),
            order: track.order,
            value: track.values,
        }));
    }
    let how = format!(
        "{how}; {} of {}, {} apart: orders {} apart are separated, an amplitude is a mean over about {} turns",
        pluralise(times.len(), "block"),
        pluralise(turns, "turn"),
        pluralise(step, "turn"),
        RESOLVED / turns as f64,
        turns.div_ceil(2)
    );
    Ok(OrderCuts {
        trace: vec![("order cuts", start.elapsed().as_secs_f64())],
        method_text: how,
        turns,
        time_s: times,
        speed: speeds,
        cuts,
        diagnostics,
    })
}

/// Refuses what a cut would do nothing with.
fn check_flags(study: &SpectrumStudy) -> Result<(), Error> {
    let plain = SpectrumStudy {
        channels: study.channels.clone(),
        cuts: study.cuts.clone(),
        tacho: study.tacho.clone(),
        pulses_per_rev: study.pulses_per_rev,
        speed: study.speed,
        revolutions: study.revolutions,
        expected_lines: study.expected_lines.clone(),
        ..SpectrumStudy::default()
    };
    if study.cuts.is_empty() {
        return Err(Error::new(Code::Usage, "no order is named to cut")
            .with_hint("name the orders: --orders 1,2,21.5"));
    }
    match *study == plain {
        true => Ok(()),
        false => Err(
            Error::new(Code::Usage, "order cuts take no other flags of spectra").with_hint(
                "omit all but --channel, --orders, --tacho, --pulses, --speed and --turns",
            ),
        ),
    }
}

/// Turns of a block that separates the orders from each other, from the mean and from whole orders, within an eighth of the run.
fn block(orders: &[f64], whole: usize) -> usize {
    const PARTS: usize = 8;
    let mut gap: f64 = 1.0;
    for (k, order) in orders.iter().enumerate() {
        let others = orders[..k].iter().map(|other| (order - other).abs());
        let near = others.chain([*order]).filter(|d| *d > 0.0);
        gap = near.fold(gap, f64::min);
    }
    ((RESOLVED / gap).ceil() as usize).clamp(1, (whole / PARTS).max(1))
}

/// Speed in rpm.
pub fn rpm(speed: f64) -> f64 {
    60.0 * speed / TAU
}
