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

/// Revolutions of a block times the distance of two separable orders: the Hann window then passes 0.1 % of the other order.
const RESOLVED: f64 = 4.0;

/// Number of blocks that start within one block length.
const OVERLAPS: usize = 4;

/// Order cut of one channel: complex amplitude of an order over a run.
#[derive(Debug, Clone)]
pub struct OrderCut {
    /// Name of the channel.
    pub channel: String,
    /// Unit of the channel.
    pub unit: String,
    /// Order, cycles per revolution.
    pub order: f64,
    /// Complex amplitude by block, zero to peak; phase at shaft angle zero.
    pub value: Vec<Complex>,
}

impl OrderCut {
    /// Index of the block with the largest amplitude.
    pub fn largest(&self) -> Option<usize> {
        let amplitude = |block: &usize| self.value[*block].norm();
        (0..self.value.len()).max_by(|a, b| amplitude(a).total_cmp(&amplitude(b)))
    }
}

/// Order cuts with the blocks they were estimated from.
#[derive(Debug)]
pub struct OrderCuts {
    /// Stages that ran, with their time, s.
    pub trace: Vec<(&'static str, f64)>,
    /// Description of the method.
    pub method_text: String,
    /// Revolutions in a block.
    pub turns: usize,
    /// Time at the middle of each block, s, from the first sample analysed.
    pub time_s: Vec<f64>,
    /// Speed at these times, rad/s.
    pub speed: Vec<f64>,
    /// Cuts by channel, then by order.
    pub cuts: Vec<OrderCut>,
    /// Data-quality warnings.
    pub diagnostics: Vec<Diagnostic>,
}

/// Computes the order cuts of a study.
///
/// # Errors
/// Neither tacho nor speed, a tacho without pulses, orders above half the sample rate, fewer revolutions than a block.
pub fn order_cuts(recording: &Recording, study: &SpectrumStudy) -> Result<OrderCuts, Error> {
    let start = Instant::now();
    check_flags(study)?;
    let channels = (study.channels.iter())
        .map(|name| channel(recording, name))
        .collect::<Result<Vec<&Channel>, Error>>()?;
    let AngularSignals {
        signals,
        curve,
        max_order,
        method_text,
        mut diagnostics,
    } = resample_to_angle(recording, &channels, study)?;
    let names: Vec<&str> = recording.channels.iter().map(|c| c.name.as_str()).collect();
    let index = |c: &&Channel| names.iter().position(|name| *name == c.name);
    let indices: Vec<usize> = channels.iter().filter_map(index).collect();
    diagnostics.splice(0..0, fault_free::spectrum_warnings(recording, &indices)?);
    if let Some(order) = study.cuts.iter().find(|order| **order > max_order) {
        let message = format!(
            "order {order} lies beyond {max_order:.2}, the highest that the rate of {} Hz resolves at the highest speed",
            recording.rate_hz
        );
        return Err(Error::new(Code::OutOfRange, message)
            .with_hint("choose lower orders, or exclude the highest speed: --before"));
    }
    let revolutions = signals
        .iter()
        .map(AngularSignal::revolutions)
        .min()
        .unwrap_or(0);
    let turns = study
        .revolutions
        .unwrap_or_else(|| block_revolutions(&study.cuts, revolutions));
    let step = (turns / OVERLAPS).max(1);
    let settings = OrderTrackOptions {
        revolutions: turns,
        step,
    };
    let (mut cuts, mut times, mut speeds) = (Vec::new(), Vec::new(), Vec::new());
    for (signal, channel) in signals.iter().zip(&channels) {
        let result = order_tracks(signal, &curve, &study.cuts, settings)?;
        (times, speeds) = (result.time_s, result.speed);
        cuts.extend(result.tracks.into_iter().map(|track| OrderCut {
            channel: channel.name.clone(),
            unit: channel.unit.clone(),
            order: track.order,
            value: track.values,
        }));
    }
    let method_text = format!(
        "{method_text}; {} of {}, {} apart: orders {} apart are separated, an amplitude is a mean over about {} turns",
        pluralise(times.len(), "block"),
        pluralise(turns, "turn"),
        pluralise(step, "turn"),
        RESOLVED / turns as f64,
        turns.div_ceil(2)
    );
    Ok(OrderCuts {
        trace: vec![("order cuts", start.elapsed().as_secs_f64())],
        method_text,
        turns,
        time_s: times,
        speed: speeds,
        cuts,
        diagnostics,
    })
}

/// Refuses options that order cuts do not use.
fn check_flags(study: &SpectrumStudy) -> Result<(), Error> {
    let supported = SpectrumStudy {
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
    match *study == supported {
        true => Ok(()),
        false => Err(
            Error::new(Code::Usage, "order cuts take no other flags of spectra").with_hint(
                "omit all but --channel, --orders, --tacho, --pulses, --speed and --turns",
            ),
        ),
    }
}

/// Revolutions of a block that separates the orders from each other, from the mean and from an integer order, at most 1/8 of the run.
fn block_revolutions(orders: &[f64], revolutions: usize) -> usize {
    const PARTS: usize = 8;
    let mut gap: f64 = 1.0;
    for (k, order) in orders.iter().enumerate() {
        let gaps = orders[..k].iter().map(|other| (order - other).abs());
        let positive = gaps.chain([*order]).filter(|d| *d > 0.0);
        gap = positive.fold(gap, f64::min);
    }
    ((RESOLVED / gap).ceil() as usize).clamp(1, (revolutions / PARTS).max(1))
}

/// Speed in rpm of a speed in rad/s.
pub fn rpm(speed: f64) -> f64 {
    60.0 * speed / TAU
}
