//! The common period of all waves and harmonics, and its pieces, which end wherever a wave jumps or bends.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::train::{Branch, Train};
use crate::motion::wave::{Phase, Shape, Wave};

/// `2π − TAU`.
const TAU_REST: f64 = 2.449_293_598_294_706_4e-16;

/// Two frequencies are in a ratio of whole numbers if they are so to this, relative: a few roundings of the products of ratios they come from.
const SAME_RATIO: f64 = 16.0 * f64::EPSILON;

/// Longest common period looked for, in periods of any one wave.
const LONGEST: f64 = 65_536.0;

/// Largest rate times half a piece: Taylor series of the motion then end after some twenty terms.
const REACH: f64 = 0.75;

/// A period in pieces.
#[derive(Debug, Clone)]
pub struct Grid {
    /// T, s; rounded.
    pub period: f64,
    /// What rounding left of it.
    rest: f64,
    /// In order, from the start of the run.
    pub pieces: Vec<Piece>,
}

/// From `middle − half` to `middle + half`, s after the start of a period.
#[derive(Debug, Clone, Copy)]
pub struct Piece {
    /// s.
    pub middle: f64,
    /// s.
    pub half: f64,
}

/// More pieces than any table has room for.
const MOST_PIECES: f64 = 1e7;

/// An instant: whole periods since the start, and what is left of it, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instant {
    /// Whole periods.
    pub periods: u64,
    /// From the start of that period, s.
    pub within: f64,
}

impl Grid {
    /// The pieces of a machine's period when its run starts at `from`, s; `fastest` is the largest rate of its motion, rad/s.
    ///
    /// # Errors
    /// `Hopeless` where its frequencies share no period.
    pub fn new(train: &Train, from: f64, fastest: f64) -> Result<Grid, Error> {
        let (period, rest) = common_period(train, fastest)?;
        let mut ends = vec![0.0, period];
        for wave in waves(train) {
            ends.extend(jumps(wave, from, period));
        }
        ends.sort_by(f64::total_cmp);
        ends.dedup_by(|later, earlier| *later - *earlier <= SAME_RATIO * period);
        if let Some(last) = ends.last_mut() {
            *last = period;
        }
        let half_at_most = REACH / fastest.max(spectrum(train));
        let mut pieces = Vec::new();
        for pair in ends.windows(2) {
            let length = pair[1] - pair[0];
            let count = (length / (2.0 * half_at_most)).ceil().max(1.0);
            if !(count <= MOST_PIECES) {
                let message = format!(
                    "the fastest motion, {fastest:.1e} rad/s, takes {count:.1e} pieces of a period of {period:.3e} s"
                );
                return Err(Error::new(Code::Hopeless, message)
                    .hint("look at the largest stiffness and the smallest inertia and their units; make what is so stiff rigid"));
            }
            pieces.extend((0..count as usize).map(|at| Piece {
                middle: pair[0] + length * (at as f64 + 0.5) / count,
                half: 0.5 * length / count,
            }));
        }
        Ok(Grid {
            period,
            rest,
            pieces,
        })
    }

    /// The instant `elapsed` seconds after the start.
    pub fn instant(&self, elapsed: f64) -> Instant {
        let left = |periods: f64| (-periods).mul_add(self.period, elapsed) - periods * self.rest;
        let mut periods = (elapsed / self.period).floor().max(0.0);
        if left(periods) < 0.0 && periods > 0.0 {
            periods -= 1.0;
        }
        Instant {
            periods: periods as u64,
            within: left(periods),
        }
    }

    /// Seconds from the start to the beginning of a period.
    pub fn elapsed(&self, periods: u64) -> f64 {
        let periods = periods as f64;
        periods.mul_add(self.period, periods * self.rest)
    }

    /// Where an instant lies on a piece of a period: −1 at its start, 1 at its end.
    pub fn place(&self, instant: Instant, periods: u64, piece: usize) -> f64 {
        let Piece { middle, half } = self.pieces[piece];
        let ahead = instant.periods as f64 - periods as f64;
        (ahead * self.period + (instant.within - middle)) / half
    }
}

/// Waves whose phase is imposed and moves: of stiffness and of transmission error.
fn waves(train: &Train) -> impl Iterator<Item = &Wave> {
    let both = |branch| {
        let Branch {
            variation,
            followed,
            ..
        }: &Branch = branch;
        variation.iter().chain(followed)
    };
    train
        .branches
        .iter()
        .flat_map(both)
        .filter(|wave| omega(wave) != 0.0)
}

fn omega(wave: &Wave) -> f64 {
    match wave.phase {
        Phase::Imposed { omega, .. } => omega.abs(),
        Phase::Followed { .. } => 0.0,
    }
}

/// Frequencies of all waves, rad/s.
pub fn frequencies(train: &Train) -> impl Iterator<Item = f64> {
    waves(train).map(omega)
}

/// The highest frequency of any smooth wave or load, rad/s.
fn spectrum(train: &Train) -> f64 {
    let highest = |wave: &Wave| match &wave.shape {
        Shape::Fourier { terms, .. } => {
            omega(wave) * terms.iter().map(|t| f64::from(t.0)).fold(0.0, f64::max)
        }
        _ => 0.0,
    };
    waves(train)
        .map(highest)
        .chain(train.harmonics())
        .fold(0.0, f64::max)
}

/// T in two parts, s; `2π/fastest` where nothing repeats.
///
/// # Errors
/// `Hopeless` where the frequencies share no period.
pub(crate) fn common_period(train: &Train, fastest: f64) -> Result<(f64, f64), Error> {
    let all: Vec<f64> = frequencies(train).chain(train.harmonics()).collect();
    let Some(&first) = all.first() else {
        return Ok((TAU / fastest, 0.0));
    };
    // The base frequency is first/turns.
    let mut turns = 1.0;
    for &omega in &all {
        let ratio = omega * turns / first;
        let more = (1..)
            .map(f64::from)
            .take_while(|more| more * turns <= LONGEST)
            .find(|more| {
                let times = ratio * more;
                times.round() >= 1.0 && (times - times.round()).abs() <= SAME_RATIO * times
            });
        let Some(more) = more else {
            let message = format!(
                "the frequencies {first} rad/s and {omega} rad/s share no period of up to {LONGEST} turns"
            );
            return Err(Error::new(Code::Hopeless, message).hint(
                "choose a method that steps through time, such as one asked by a tolerance",
            ));
        };
        turns *= more;
    }
    let product = turns * TAU;
    let period = product / first;
    let rest = (-period).mul_add(first, product) + turns.mul_add(TAU, -product) + turns * TAU_REST;
    Ok((period, rest / first))
}

/// Where in a period, s after its start, a wave jumps or bends.
fn jumps(wave: &Wave, from: f64, period: f64) -> Vec<f64> {
    let Phase::Imposed { omega, start } = wave.phase else {
        return Vec::new();
    };
    let ends: Vec<f64> = match &wave.shape {
        Shape::Rectangular { duty, .. } => vec![0.0, *duty],
        Shape::Fourier { .. } => Vec::new(),
        Shape::Table(values) => (0..values.len())
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
