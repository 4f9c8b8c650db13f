//! Common period of all waves and harmonics, divided at their jumps and kinks.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::dynamic_model::{DynamicModel, ForceElement};
use crate::motion::wave::{PeriodicFunction, WavePhase, Waveform};

/// Rounding remainder `2π − TAU`.
const TAU_LOW: f64 = 2.449_293_598_294_706_4e-16;

/// Relative tolerance of a rational ratio of two frequencies: a few rounding errors of the products that they are computed from.
const SAME_RATIO: f64 = 16.0 * f64::EPSILON;

/// Longest common period, in periods of a wave.
const MAX_PERIODS: f64 = 65_536.0;

/// Largest rate times half the length of a piece; Taylor series of the motion then converge within about twenty terms.
const MAX_RATE_STEP: f64 = 0.75;

/// Common period, divided into pieces.
#[derive(Debug, Clone)]
pub struct PeriodGrid {
    /// Period T, s, rounded.
    pub period: f64,
    /// Rounding remainder of the period, s.
    rest: f64,
    /// Pieces in order of time, from the start of the run.
    pub pieces: Vec<PeriodPiece>,
}

/// Piece of the period from `middle − half` to `middle + half`, s after its start.
#[derive(Debug, Clone, Copy)]
pub struct PeriodPiece {
    /// Midpoint, s.
    pub middle: f64,
    /// Half the length, s.
    pub half: f64,
}

/// Maximum number of pieces between two knots.
const MAX_PIECES: f64 = 1e7;

/// Time as a number of whole periods since the start and a remainder, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeriodTime {
    /// Whole periods since the start.
    pub periods: u64,
    /// Time from the start of that period, s.
    pub remainder: f64,
}

impl PeriodGrid {
    /// Grid of a model whose run starts at `from`, s; `fastest` is the largest rate of its motion, rad/s.
    ///
    /// # Errors
    /// `BudgetExceeded` if the frequencies have no common period or a piece is too short.
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
        let max_half = MAX_RATE_STEP / fastest.max(highest_frequency(model));
        let mut pieces = Vec::new();
        for pair in ends.windows(2) {
            let length = pair[1] - pair[0];
            let count = (length / (2.0 * max_half)).ceil().max(1.0);
            if !(count <= MAX_PIECES) {
                let message = format!(
                    "the fastest motion, {fastest:.1e} rad/s, takes {count:.1e} segments of a period of {period:.3e} s"
                );
                return Err(Error::new(Code::BudgetExceeded, message)
                    .with_hint("check the largest stiffness and the smallest inertia and their units; make the stiffest element rigid"));
            }
            pieces.extend((0..count as usize).map(|k| PeriodPiece {
                middle: pair[0] + length * (k as f64 + 0.5) / count,
                half: 0.5 * length / count,
            }));
        }
        Ok(PeriodGrid {
            period,
            rest,
            pieces,
        })
    }

    /// Time in periods from the time `elapsed` after the start, s.
    pub fn instant(&self, elapsed: f64) -> PeriodTime {
        let rest = |periods: f64| (-periods).mul_add(self.period, elapsed) - periods * self.rest;
        let mut periods = (elapsed / self.period).floor().max(0.0);
        if rest(periods) < 0.0 && periods > 0.0 {
            periods -= 1.0;
        }
        PeriodTime {
            periods: periods as u64,
            remainder: rest(periods),
        }
    }

    /// Time from the start of the run to the start of a period, s.
    pub fn elapsed(&self, periods: u64) -> f64 {
        let periods = periods as f64;
        periods.mul_add(self.period, periods * self.rest)
    }

    /// Position of a time on a piece of a period: −1 at its start, 1 at its end.
    pub fn position_in_piece(&self, instant: PeriodTime, periods: u64, piece: usize) -> f64 {
        let PeriodPiece { middle, half } = self.pieces[piece];
        let ahead = instant.periods as f64 - periods as f64;
        (ahead * self.period + (instant.remainder - middle)) / half
    }
}

/// Waves of stiffness and transmission error at an imposed, nonzero speed.
fn waves(model: &DynamicModel) -> impl Iterator<Item = &PeriodicFunction> {
    let waves = |branch| {
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
        .flat_map(waves)
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

/// Highest frequency of the smooth waves and the harmonic loads, rad/s.
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

/// Common period T and its rounding remainder, s; `2π/fastest` without periodic inputs.
///
/// # Errors
/// `BudgetExceeded` if the frequencies have no common period.
pub(crate) fn common_period(model: &DynamicModel, fastest: f64) -> Result<(f64, f64), Error> {
    let omegas: Vec<f64> = frequencies(model).chain(model.harmonics()).collect();
    let Some(&first) = omegas.first() else {
        return Ok((TAU / fastest, 0.0));
    };
    // The fundamental frequency is first/turns.
    let mut turns = 1.0;
    for &omega in &omegas {
        let ratio = omega * turns / first;
        let factor = (1..)
            .map(f64::from)
            .take_while(|factor| factor * turns <= MAX_PERIODS)
            .find(|factor| {
                let order = ratio * factor;
                order.round() >= 1.0 && (order - order.round()).abs() <= SAME_RATIO * order
            });
        let Some(factor) = factor else {
            let message = format!(
                "the frequencies {first} rad/s and {omega} rad/s have no common period of up to {MAX_PERIODS} turns"
            );
            return Err(Error::new(Code::BudgetExceeded, message)
                .with_hint("choose a time-stepping method: give --tolerance"));
        };
        turns *= factor;
    }
    let product = turns * TAU;
    let period = product / first;
    let rest = (-period).mul_add(first, product) + turns.mul_add(TAU, -product) + turns * TAU_LOW;
    Ok((period, rest / first))
}

/// Times of the jumps and kinks of a wave within a period, s after its start.
fn jump_times(wave: &PeriodicFunction, from: f64, period: f64) -> Vec<f64> {
    let WavePhase::Imposed { omega, start } = wave.phase else {
        return Vec::new();
    };
    let knots: Vec<f64> = match &wave.waveform {
        Waveform::Rectangular { duty, .. } => vec![0.0, *duty],
        Waveform::Fourier { .. } => Vec::new(),
        Waveform::Table(values) => (0..values.len())
            .map(|k| k as f64 / values.len() as f64)
            .collect(),
    };
    let begin = omega * from + start;
    let turns = (omega.abs() * period / TAU).round() as i64;
    let first_turn = (begin / TAU).floor() as i64;
    let (low, high) = match omega > 0.0 {
        true => (first_turn, first_turn + turns + 1),
        false => (first_turn - turns - 1, first_turn),
    };
    (low..=high)
        .flat_map(|turn| knots.iter().map(move |knot| turn as f64 + knot))
        .map(|psi| (psi * TAU - begin) / omega)
        .filter(|&t| t > 0.0 && t < period)
        .collect()
}
