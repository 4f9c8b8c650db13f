//! What is known in time: the torques of drives and the motions imposed on branches, as lines and harmonics.

use super::instant::Instant;
use crate::motion::signal::Signal;
use crate::motion::train::Train;
use crate::numeric::Complex;

/// Where an input enters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Entry {
    /// A drive, by its number.
    Drive(usize),
    /// The imposed e of a branch, by its number.
    Imposed(usize),
}

/// One known function of time.
#[derive(Debug)]
pub struct Input<'a> {
    /// Where it enters.
    pub entry: Entry,
    /// What it is.
    pub signal: &'a Signal,
    /// Its place among the pieces of a regime.
    pub piece: usize,
    /// Its harmonics: place in the list of frequencies, phasor.
    pub harmonics: Vec<(usize, Complex)>,
    /// What harmonics of no frequency add.
    constant: f64,
}

/// All of them.
#[derive(Debug)]
pub struct Inputs<'a> {
    /// Drives first, then branches.
    pub list: Vec<Input<'a>>,
    /// Every ω once, rad/s.
    pub frequencies: Vec<f64>,
}

impl<'a> Inputs<'a> {
    /// Of a machine.
    pub fn new(train: &'a Train) -> Inputs<'a> {
        let drives = train.drives.iter().enumerate();
        let drives = drives.map(|(at, d)| (Entry::Drive(at), &d.signal, at));
        let branches = train.branches.iter().enumerate();
        let imposed = branches.filter_map(|(at, b)| {
            let signal = b.imposed.as_ref()?;
            Some((Entry::Imposed(at), signal, train.drives.len() + at))
        });
        let mut frequencies: Vec<f64> = Vec::new();
        let list = drives.chain(imposed).map(|(entry, signal, piece)| {
            let mut harmonics: Vec<(usize, Complex)> = Vec::new();
            let mut constant = 0.0;
            for h in &signal.harmonics {
                let phasor = Complex::from_polar(h.amplitude, h.phase);
                if h.omega == 0.0 {
                    constant += phasor.re;
                    continue;
                }
                // cos(−x) = cos x: one sign of ω is enough.
                let (omega, phasor) = match h.omega < 0.0 {
                    true => (-h.omega, phasor.conj()),
                    false => (h.omega, phasor),
                };
                let at = frequencies.iter().position(|&w| w == omega);
                let at = at.unwrap_or_else(|| {
                    frequencies.push(omega);
                    frequencies.len() - 1
                });
                match harmonics.iter_mut().find(|(f, _)| *f == at) {
                    Some((_, sum)) => *sum += phasor,
                    None => harmonics.push((at, phasor)),
                }
            }
            Input {
                entry,
                signal,
                piece,
                harmonics,
                constant,
            }
        });
        let list = list.collect();
        Inputs { list, frequencies }
    }
}

impl Input<'_> {
    /// The line that carries it: value at an instant, change per second.
    pub fn line(&self, pieces: &[u32], now: Instant) -> (f64, f64) {
        match pieces[self.piece] {
            0 => (self.constant, 0.0),
            at => {
                let knot = &self.signal.knots[at as usize - 1];
                let value = knot.line(now.high) + knot.slope * now.low;
                (value + self.constant, knot.slope)
            }
        }
    }
}
