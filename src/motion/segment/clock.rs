//! Known times: knots of signals and jumps of stiffness waves, those a few rounding errors apart taken as one.

use std::f64::consts::TAU;

use crate::base::code::Code;
use crate::base::error::Error;
use crate::motion::signal::Signal;
use crate::motion::train::Train;
use crate::motion::wave::{Phase, Shape};

/// What will jump, and when.
#[derive(Debug)]
pub struct Clock<'a> {
    signals: Vec<(usize, &'a Signal)>,
    waves: Vec<Jumps>,
}

/// The jumps of a rectangular wave: number 2m at ψ = m, number 2m + 1 at m + duty.
#[derive(Debug)]
struct Jumps {
    branch: usize,
    duty: f64,
    omega: f64,
    start: f64,
    /// The jump last passed in the sense of the motion.
    last: i64,
}

/// What the jump of a known time was about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Tick {
    /// A line of the input at this place of a regime's pieces gave way to the next.
    Piece(usize, u32),
    /// The wave of a branch came to another piece.
    Wave(usize, u32),
}

/// Times closer than this, relative to what they are computed from, are one.
const MERGED: f64 = 8.0 * f64::EPSILON;

impl<'a> Clock<'a> {
    /// At the start of a run; what happens at that very time has happened.
    ///
    /// # Errors
    /// A wave that is not rectangular or follows an angle.
    pub fn new(train: &'a Train, from: f64) -> Result<Clock<'a>, Error> {
        let drives = train
            .drives
            .iter()
            .enumerate()
            .map(|(at, d)| (at, &d.signal));
        let offset = train.drives.len();
        let imposed = train.branches.iter().enumerate();
        let imposed = imposed.filter_map(|(at, b)| Some((offset + at, b.imposed.as_ref()?)));
        let mut waves = Vec::new();
        for (branch, b) in train.branches.iter().enumerate() {
            let Some(wave) = &b.variation else { continue };
            let (Shape::Rectangular { duty, .. }, &Phase::Imposed { omega, start }) =
                (&wave.shape, &wave.phase)
            else {
                let message = format!(
                    "the stiffness of `{}` is not a rectangular wave at imposed speed",
                    b.name
                );
                return Err(
                    Error::new(Code::OutOfRange, message).hint("take a method for smooth waves")
                );
            };
            let psi = wave.phase.at(from, &[]);
            let whole = psi.floor();
            let passed = whole as i64 * 2 + i64::from(psi - whole >= *duty);
            let mut jumps = Jumps {
                branch,
                duty: *duty,
                omega,
                start,
                last: if omega < 0.0 { passed + 1 } else { passed },
            };
            while omega != 0.0 && jumps.next() <= from + jumps.blur() {
                jumps.pass();
            }
            waves.push(jumps);
        }
        Ok(Clock {
            signals: drives.chain(imposed).collect(),
            waves,
        })
    }

    /// The next known time after the pieces of a regime, of waves only those of branches that heed theirs; ∞ where none comes.
    pub fn next(&self, pieces: &[u32], heeds: impl Fn(usize) -> bool) -> f64 {
        let knots = self
            .signals
            .iter()
            .map(|(at, signal)| knot(signal, pieces[*at]));
        let heeded = self.waves.iter().filter(|jumps| heeds(jumps.branch));
        let jumps = heeded.map(Jumps::next);
        knots.chain(jumps).fold(f64::INFINITY, f64::min)
    }

    /// Passes all that happens at `t`.
    pub fn tick(&mut self, pieces: &[u32], t: f64, ticks: &mut Vec<Tick>) {
        ticks.clear();
        for (at, signal) in &self.signals {
            let mut piece = pieces[*at];
            while knot(signal, piece) <= t + MERGED * t.abs() {
                piece += 1;
            }
            if piece != pieces[*at] {
                ticks.push(Tick::Piece(*at, piece));
            }
        }
        for jumps in &mut self.waves {
            if jumps.pass_until(t) {
                ticks.push(Tick::Wave(jumps.branch, jumps.piece()));
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

impl Jumps {
    fn time(&self, number: i64) -> f64 {
        let whole = number.div_euclid(2) as f64;
        let psi = match number.rem_euclid(2) {
            0 => whole,
            _ => whole + self.duty,
        };
        (psi * TAU - self.start) / self.omega
    }

    fn next(&self) -> f64 {
        match self.omega {
            0.0 => f64::INFINITY,
            omega if omega > 0.0 => self.time(self.last + 1),
            _ => self.time(self.last - 1),
        }
    }

    /// Rounding of a jump's time.
    fn blur(&self) -> f64 {
        let next = self.next();
        match next.is_finite() {
            true => MERGED * (next.abs() + (self.start / self.omega).abs()),
            false => 0.0,
        }
    }

    fn pass(&mut self) {
        self.last += if self.omega > 0.0 { 1 } else { -1 };
    }

    /// Passes all jumps up to `t`; false where there is none.
    fn pass_until(&mut self, t: f64) -> bool {
        let before = self.last;
        while self.next() <= t + self.blur() {
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

    fn jumps(omega: f64, start: f64, last: i64) -> Jumps {
        Jumps {
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
        assert_eq!((ahead.piece(), ahead.next()), (0, 0.25));
        ahead.pass();
        assert_eq!((ahead.piece(), ahead.next()), (1, 1.0));
        let mut back = jumps(-TAU, 0.0, 2);
        assert_eq!((back.piece(), back.next()), (1, -0.25));
        back.pass();
        assert_eq!((back.piece(), back.next()), (0, 0.0));
    }
}
