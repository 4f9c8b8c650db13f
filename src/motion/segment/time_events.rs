//! Time events: knots of signals and jumps of stiffness waves, merged within rounding.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::dynamic_model::DynamicModel;
use crate::motion::signal::Signal;
use crate::motion::wave::{WavePhase, Waveform};

/// Knots of the signals and jumps of the stiffness waves of a model.
#[derive(Debug)]
pub struct TimeEvents<'a> {
    signals: Vec<(usize, &'a Signal)>,
    waves: Vec<WaveJumps>,
}

/// Jumps of a rectangular wave: number 2m at the phase ψ = m, number 2m + 1 at m + duty, in revolutions.
#[derive(Debug)]
struct WaveJumps {
    branch: usize,
    duty: f64,
    omega: f64,
    start: f64,
    /// Number of the last jump in the direction of motion.
    last: i64,
}

/// Change of piece at a known time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeEvent {
    /// Index of an input in the pieces of a regime, and its new piece.
    Piece(usize, u32),
    /// Branch of a wave, and its new piece.
    Wave(usize, u32),
}

/// Relative tolerance for merging times: a few rounding errors.
const MERGE_TOLERANCE: f64 = 8.0 * f64::EPSILON;

impl<'a> TimeEvents<'a> {
    /// Time events of a model after the time `from`, s; events at that time are past.
    ///
    /// # Errors
    /// A wave that is not rectangular or follows an angle.
    pub fn new(model: &'a DynamicModel, from: f64) -> Result<TimeEvents<'a>, Error> {
        let drives = model.forces.iter().enumerate().map(|(i, d)| (i, &d.signal));
        let offset = model.forces.len();
        let imposed = model.elements.iter().enumerate();
        let imposed =
            imposed.filter_map(|(i, b)| Some((offset + i, b.imposed_displacement.as_ref()?)));
        let mut waves = Vec::new();
        for (branch, b) in model.elements.iter().enumerate() {
            let Some(wave) = &b.stiffness_wave else {
                continue;
            };
            let (Waveform::Rectangular { duty, .. }, &WavePhase::Imposed { omega, start }) =
                (&wave.waveform, &wave.phase)
            else {
                let message = format!(
                    "the stiffness of `{}` is not a rectangular wave at imposed speed",
                    b.name
                );
                return Err(Error::new(Code::OutOfRange, message)
                    .with_hint("take a method for smooth waves"));
            };
            let psi = wave.phase.phase_at(from, &[]);
            let turn = psi.floor();
            let last = turn as i64 * 2 + i64::from(psi - turn >= *duty);
            let mut jumps = WaveJumps {
                branch,
                duty: *duty,
                omega,
                start,
                last: if omega < 0.0 { last + 1 } else { last },
            };
            while omega != 0.0 && jumps.next_time() <= from + jumps.time_rounding() {
                jumps.step();
            }
            waves.push(jumps);
        }
        Ok(TimeEvents {
            signals: drives.chain(imposed).collect(),
            waves,
        })
    }

    /// Next time event after the pieces of a regime, s, with the waves of the branches selected by `is_active`; ∞ without one.
    pub fn next_time(&self, pieces: &[u32], is_active: impl Fn(usize) -> bool) -> f64 {
        let knots = self
            .signals
            .iter()
            .map(|(i, signal)| knot(signal, pieces[*i]));
        let active = self.waves.iter().filter(|jumps| is_active(jumps.branch));
        let jumps = active.map(WaveJumps::next_time);
        knots.chain(jumps).fold(f64::INFINITY, f64::min)
    }

    /// Advances to the time t, s, and lists the events in `events`.
    pub fn advance(&mut self, pieces: &[u32], t: f64, events: &mut Vec<TimeEvent>) {
        events.clear();
        for (i, signal) in &self.signals {
            let mut piece = pieces[*i];
            while knot(signal, piece) <= t + MERGE_TOLERANCE * t.abs() {
                piece += 1;
            }
            if piece != pieces[*i] {
                events.push(TimeEvent::Piece(*i, piece));
            }
        }
        for jumps in &mut self.waves {
            if jumps.advance_to(t) {
                events.push(TimeEvent::Wave(jumps.branch, jumps.piece()));
            }
        }
    }

    /// Piece of the wave of a branch at the time t, s, not earlier than the last advance; `None` without a wave.
    pub fn piece(&mut self, branch: usize, t: f64) -> Option<u32> {
        let jumps = self.waves.iter_mut().find(|jumps| jumps.branch == branch)?;
        jumps.advance_to(t);
        Some(jumps.piece())
    }

    /// Branch and present piece of every wave.
    pub fn pieces(&self) -> impl Iterator<Item = (usize, u32)> + '_ {
        self.waves.iter().map(|jumps| (jumps.branch, jumps.piece()))
    }
}

fn knot(signal: &Signal, piece: u32) -> f64 {
    signal
        .knots
        .get(piece as usize)
        .map_or(f64::INFINITY, |knot| knot.time)
}

impl WaveJumps {
    fn time(&self, number: i64) -> f64 {
        let turn = number.div_euclid(2) as f64;
        let psi = match number.rem_euclid(2) {
            0 => turn,
            _ => turn + self.duty,
        };
        (psi * TAU - self.start) / self.omega
    }

    fn next_time(&self) -> f64 {
        match self.omega {
            0.0 => f64::INFINITY,
            omega if omega > 0.0 => self.time(self.last + 1),
            _ => self.time(self.last - 1),
        }
    }

    /// Rounding error of the time of a jump, s.
    fn time_rounding(&self) -> f64 {
        let next = self.next_time();
        match next.is_finite() {
            true => MERGE_TOLERANCE * (next.abs() + (self.start / self.omega).abs()),
            false => 0.0,
        }
    }

    fn step(&mut self) {
        self.last += if self.omega > 0.0 { 1 } else { -1 };
    }

    /// Advances over all jumps up to the time t, s; false without a jump.
    fn advance_to(&mut self, t: f64) -> bool {
        let before = self.last;
        while self.next_time() <= t + self.time_rounding() {
            self.step();
        }
        self.last != before
    }

    fn piece(&self) -> u32 {
        let jump = if self.omega < 0.0 {
            self.last - 1
        } else {
            self.last
        };
        jump.rem_euclid(2) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jumps(omega: f64, start: f64, last: i64) -> WaveJumps {
        WaveJumps {
            branch: 0,
            duty: 0.25,
            omega,
            start,
            last,
        }
    }

    /// At positive speed the high piece ends at a quarter revolution, at negative speed the low one.
    #[test]
    fn exact_jumps_both_ways() {
        let mut forward = jumps(TAU, 0.0, 0);
        assert_eq!((forward.piece(), forward.next_time()), (0, 0.25));
        forward.step();
        assert_eq!((forward.piece(), forward.next_time()), (1, 1.0));
        let mut backward = jumps(-TAU, 0.0, 2);
        assert_eq!((backward.piece(), backward.next_time()), (1, -0.25));
        backward.step();
        assert_eq!((backward.piece(), backward.next_time()), (0, 0.0));
    }
}
