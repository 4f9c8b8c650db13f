//! Time events: knots of signals and jumps of stiffness waves, merged within rounding.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::dynamic_model::DynamicModel;
use crate::motion::signal::Signal;
use crate::motion::wave::{WavePhase, Waveform};

/// Jumps known in time, and their instants.
#[derive(Debug)]
pub struct TimeEvents<'a> {
    signals: Vec<(usize, &'a Signal)>,
    waves: Vec<WaveJumps>,
}

/// The jumps of a rectangular wave: number 2m at ψ = m, number 2m + 1 at m + duty.
#[derive(Debug)]
struct WaveJumps {
    branch: usize,
    duty: f64,
    omega: f64,
    start: f64,
    /// The jump last passed in the sense of the motion.
    last: i64,
}

/// Cause of a jump at a known time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TimeEvent {
    /// A line of the input at this place of a regime's pieces gave way to the next.
    Piece(usize, u32),
    /// The wave of a branch came to another piece.
    Wave(usize, u32),
}

/// Times closer than this, relative to what they are computed from, are one.
const MERGE_TOLERANCE: f64 = 8.0 * f64::EPSILON;

impl<'a> TimeEvents<'a> {
    /// At the start of a run; what happens at that very time has happened.
    ///
    /// # Errors
    /// A wave that is not rectangular or follows an angle.
    pub fn new(model: &'a DynamicModel, from: f64) -> Result<TimeEvents<'a>, Error> {
        let drives = model
            .forces
            .iter()
            .enumerate()
            .map(|(at, d)| (at, &d.signal));
        let offset = model.forces.len();
        let imposed = model.elements.iter().enumerate();
        let imposed =
            imposed.filter_map(|(at, b)| Some((offset + at, b.imposed_displacement.as_ref()?)));
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
            let whole = psi.floor();
            let passed = whole as i64 * 2 + i64::from(psi - whole >= *duty);
            let mut jumps = WaveJumps {
                branch,
                duty: *duty,
                omega,
                start,
                last: if omega < 0.0 { passed + 1 } else { passed },
            };
            while omega != 0.0 && jumps.next_time() <= from + jumps.time_rounding() {
                jumps.pass();
            }
            waves.push(jumps);
        }
        Ok(TimeEvents {
            signals: drives.chain(imposed).collect(),
            waves,
        })
    }

    /// The next known time after the pieces of a regime, of waves only those of branches that heed theirs; ∞ where none comes.
    pub fn next_time(&self, pieces: &[u32], heeds: impl Fn(usize) -> bool) -> f64 {
        let knots = self
            .signals
            .iter()
            .map(|(at, signal)| knot(signal, pieces[*at]));
        let heeded = self.waves.iter().filter(|jumps| heeds(jumps.branch));
        let jumps = heeded.map(WaveJumps::next_time);
        knots.chain(jumps).fold(f64::INFINITY, f64::min)
    }

    /// Passes all that happens at `t`.
    pub fn advance(&mut self, pieces: &[u32], t: f64, ticks: &mut Vec<TimeEvent>) {
        ticks.clear();
        for (at, signal) in &self.signals {
            let mut piece = pieces[*at];
            while knot(signal, piece) <= t + MERGE_TOLERANCE * t.abs() {
                piece += 1;
            }
            if piece != pieces[*at] {
                ticks.push(TimeEvent::Piece(*at, piece));
            }
        }
        for jumps in &mut self.waves {
            if jumps.pass_until(t) {
                ticks.push(TimeEvent::Wave(jumps.branch, jumps.piece()));
            }
        }
    }

    /// Which piece carries the wave of a branch at `t`, when all before has been passed; nothing where it has none.
    pub fn piece(&mut self, branch: usize, t: f64) -> Option<u32> {
        let jumps = self.waves.iter_mut().find(|jumps| jumps.branch == branch)?;
        jumps.pass_until(t);
        Some(jumps.piece())
    }

    /// Which piece carries the wave of every branch that has one.
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
        let whole = number.div_euclid(2) as f64;
        let psi = match number.rem_euclid(2) {
            0 => whole,
            _ => whole + self.duty,
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

    /// Rounding of a jump's time.
    fn time_rounding(&self) -> f64 {
        let next = self.next_time();
        match next.is_finite() {
            true => MERGE_TOLERANCE * (next.abs() + (self.start / self.omega).abs()),
            false => 0.0,
        }
    }

    fn pass(&mut self) {
        self.last += if self.omega > 0.0 { 1 } else { -1 };
    }

    /// Passes all jumps up to `t`; false where there is none.
    fn pass_until(&mut self, t: f64) -> bool {
        let before = self.last;
        while self.next_time() <= t + self.time_rounding() {
            self.pass();
        }
        self.last != before
    }

    fn piece(&self) -> u32 {
        let begun = if self.omega < 0.0 {
            self.last - 1
        } else {
            self.last
        };
        begun.rem_euclid(2) as u32
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

    /// Forward the high piece ends at a quarter, backward the low one ends there.
    #[test]
    fn exact_jumps_both_ways() {
        let mut ahead = jumps(TAU, 0.0, 0);
        assert_eq!((ahead.piece(), ahead.next_time()), (0, 0.25));
        ahead.pass();
        assert_eq!((ahead.piece(), ahead.next_time()), (1, 1.0));
        let mut back = jumps(-TAU, 0.0, 2);
        assert_eq!((back.piece(), back.next_time()), (1, -0.25));
        back.pass();
        assert_eq!((back.piece(), back.next_time()), (0, 0.0));
    }
}
