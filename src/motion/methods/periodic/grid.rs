//! Common period of all waves and harmonics, divided at their jumps and corners.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::dynamic_model::{DynamicModel, ForceElement};
use crate::motion::wave::{PeriodicFunction, WavePhase, Waveform};

/// `2π − TAU`.
const TAU_LOW: f64 = 2.449_293_598_294_706_4e-16;

/// Two frequencies are in a ratio of whole numbers if they are so to this, relative: a few roundings of the products of ratios they come from.
const SAME_RATIO: f64 = 16.0 * f64::EPSILON;

/// Longest common period looked for, in periods of any one wave.
const MAX_PERIODS: f64 = 65_536.0;

/// Largest rate times half a piece: Taylor series of the motion then end after some twenty terms.
const MAX_RATE_STEP: f64 = 0.75;

/// A period in pieces.
#[derive(Debug, Clone)]
pub struct PeriodGrid {
    /// T, s; rounded.
    pub period: f64,
    /// Rounding remainder of the period.
    rest: f64,
    /// In order, from the start of the run.
    pub pieces: Vec<PeriodPiece>,
}

/// From `middle − half` to `middle + half`, s after the start of a period.
#[derive(Debug, Clone, Copy)]
pub struct PeriodPiece {
    /// s.
    pub middle: f64,
    /// s.
    pub half: f64,
}

/// More pieces than any table has room for.
const MAX_PIECES: f64 = 1e7;

/// An instant: whole periods since the start, and what is left of it, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeriodTime {
    /// Whole periods.
    pub periods: u64,
    /// From the start of that period, s.
    pub within: f64,
}

impl PeriodGrid {
    /// The pieces of a machine's period when its run starts at `from`, s; `fastest` is the largest rate of its motion, rad/s.
    ///
    /// # Errors
    /// `BudgetExceeded` where its frequencies share no period.
    pub fn new(model: &DynamicModel, from: f64, fastest: f64) -> Result<PeriodGrid, Error> {
        let (period, rest) = common_period(model, fastest)?;
        let mut ends = vec![0.0, period];
        for wave in waves(model) {
            ends.extend(jump_times(wave, from, period));
        }
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|later, earlier| *later - *earlier <= SAME_RATIO * period);
        if let Some(last) = ends.last_mut() {
            *last = period;
        }
        let half_at_most = MAX_RATE_STEP / fastest.max(highest_frequency(model));
        let mut pieces = Vec::new();
        for pair in ends.windows(2) {
            let length = pair[1] - pair[0];
            let count = (length / (2.0 * half_at_most)).ceil().max(1.0);
            if !(count <= MAX_PIECES) {
                let message = format!(
                    "the fastest motion, {fastest:.1e} rad/s, takes {count:.1e} pieces of a period of {period:.3e} s"
                );
                return Err(Error::new(Code::BudgetExceeded, message)
                    .with_hint("check the largest stiffness and the smallest inertia and their units; make what is so stiff rigid"));
            }
            pieces.extend((0..count as usize).map(|at| PeriodPiece {
                middle: pair[0] + length * (at as f64 + 0.5) / count,
                half: 0.5 * length / count,
            }));
        }
        Ok(PeriodGrid {
            period,
            rest,
            pieces,
        })
    }

    /// The instant `elapsed` seconds after the start.
    pub fn instant(&self, elapsed: f64) -> PeriodTime {
        let left = |periods: f64| (-periods).mul_add(self.period, elapsed) - periods * self.rest;
        let mut periods = (elapsed / self.period).floor().max(0.0);
        if left(periods) < 0.0 && periods > 0.0 {
            periods -= 1.0;
        }
        PeriodTime {
            periods: periods as u64,
            within: left(periods),
        }
    }

    /// Seconds from the start to the beginning of a period.
    pub fn elapsed(&self, periods: u64) -> f64 {
        let periods = periods as f64;
        periods.mul_add(self.period, periods * self.rest)
    }

    /// Position of an instant on a piece of a period: −1 at its start, 1 at its end.
    pub fn position_in_piece(&self, instant: PeriodTime, periods: u64, piece: usize) -> f64 {
        let PeriodPiece { middle, half } = self.pieces[piece];
        let ahead = instant.periods as f64 - periods as f64;
        (ahead * self.period + (instant.within - middle)) / half
    }
}

/// Waves whose phase is imposed and moves: of stiffness and of transmission error.
fn waves(model: &DynamicModel) -> impl Iterator<Item = &PeriodicFunction> {
    let both = |branch| {
        let ForceElement {
            stiffness_wave: variation,
            angle_waves: followed,
            ..
        }: &ForceElement = branch;
        variation.iter().chain(followed)
    };
    model
        .elements
        .iter()
        .flat_map(both)
        .filter(|wave| omega(wave) != 0.0)
}

fn omega(wave: &PeriodicFunction) -> f64 {
    match wave.phase {
        WavePhase::Imposed { omega, .. } => omega.abs(),
        WavePhase::FollowsAngle { .. } => 0.0,
    }
}

/// Frequencies of all waves, rad/s.
pub fn frequencies(model: &DynamicModel) -> impl Iterator<Item = f64> {
    waves(model).map(omega)
}

/// The highest frequency of any smooth wave or load, rad/s.
fn highest_frequency(model: &DynamicModel) -> f64 {
    let highest = |wave: &PeriodicFunction| match &wave.waveform {
        Waveform::Fourier { terms, .. } => {
            omega(wave) * terms.iter().map(|t| f64::from(t.0)).fold(0.0, f64::max)
        }
        _ => 0.0,
    };
    waves(model)
        .map(highest)
        .chain(model.harmonics())
        .fold(0.0, f64::max)
}

/// T in two parts, s; `2π/fastest` where nothing repeats.
///
/// # Errors
/// `BudgetExceeded` where the frequencies share no period.
pub(crate) fn common_period(model: &DynamicModel, fastest: f64) -> Result<(f64, f64), Error> {
    let all: Vec<f64> = frequencies(model).chain(model.harmonics()).collect();
    let Some(&first) = all.first() else {
        return Ok((TAU / fastest, 0.0));
    };
    // The base frequency is first/turns.
    let mut turns = 1.0;
    for &omega in &all {
        let ratio = omega * turns / first;
        let more = (1..)
            .map(f64::from)
            .take_while(|more| more * turns <= MAX_PERIODS)
            .find(|more| {
                let times = ratio * more;
                times.round() >= 1.0 && (times - times.round()).abs() <= SAME_RATIO * times
            });
        let Some(more) = more else {
            let message = format!(
                "the frequencies {first} rad/s and {omega} rad/s share no period of up to {MAX_PERIODS} turns"
            );
            return Err(Error::new(Code::BudgetExceeded, message)
                .with_hint("choose a time-stepping method: give --tolerance"));
        };
        turns *= more;
    }
    let product = turns * TAU;
    let period = product / first;
    let rest = (-period).mul_add(first, product) + turns.mul_add(TAU, -product) + turns * TAU_LOW;
    Ok((period, rest / first))
}

/// Times in a period, s after its start, at which a wave jumps or bends.
fn jump_times(wave: &PeriodicFunction, from: f64, period: f64) -> Vec<f64> {
    let WavePhase::Imposed { omega, start } = wave.phase else {
        return Vec::new();
    };
    let ends: Vec<f64> = match &wave.waveform {
        Waveform::Rectangular { duty, .. } => vec![0.0, *duty],
        Waveform::Fourier { .. } => Vec::new(),
        Waveform::Table(values) => (0..values.len())
            .map(|at| at as f64 / values.len() as f64)
            .collect(),
    };
    let begin = omega * from + start;
    let turns = (omega.abs() * period / TAU).round() as i64;
    let whole = (begin / TAU).floor() as i64;
    let (low, high) = match omega > 0.0 {
        true => (whole, whole + turns + 1),
        false => (whole - turns - 1, whole),
    };
    (low..=high)
        .flat_map(|turn| ends.iter().map(move |end| turn as f64 + end))
        .map(|psi| (psi * TAU - begin) / omega)
        .filter(|&at| at > 0.0 && at < period)
        .collect()
}
