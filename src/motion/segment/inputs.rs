//! Known inputs: torques and imposed displacements as piecewise lines and harmonics.

use super::double_time::DoubleTime;
use crate::motion::dynamic_model::DynamicModel;
use crate::motion::signal::Signal;
use crate::numeric::Complex;

/// Target of an input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InputTarget {
    /// A drive, by its number.
    Drive(usize),
    /// The imposed e of a branch, by its number.
    Imposed(usize),
}

/// One known function of time.
#[derive(Debug)]
pub struct KnownInput<'a> {
    /// Target of the input.
    pub entry: InputTarget,
    /// Signal of the input.
    pub signal: &'a Signal,
    /// Index among the pieces of a regime.
    pub piece: usize,
    /// Harmonics of the input: place in the list of frequencies, phasor.
    pub harmonics: Vec<(usize, Complex)>,
    /// Constant from harmonics of zero frequency.
    constant: f64,
}

/// All of them.
#[derive(Debug)]
pub struct KnownInputs<'a> {
    /// Drives first, then branches.
    pub list: Vec<KnownInput<'a>>,
    /// Every ω once, rad/s.
    pub frequencies: Vec<f64>,
}

impl<'a> KnownInputs<'a> {
    /// Known inputs of a machine.
    pub fn new(model: &'a DynamicModel) -> KnownInputs<'a> {
        let drives = model.forces.iter().enumerate();
        let drives = drives.map(|(at, d)| (InputTarget::Drive(at), &d.signal, at));
        let branches = model.elements.iter().enumerate();
        let imposed = branches.filter_map(|(at, b)| {
            let signal = b.imposed_displacement.as_ref()?;
            Some((InputTarget::Imposed(at), signal, model.forces.len() + at))
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
            KnownInput {
                entry,
                signal,
                piece,
                harmonics,
                constant,
            }
        });
        let list = list.collect();
        KnownInputs { list, frequencies }
    }
}

impl KnownInput<'_> {
    /// The line that carries it: value at an instant, change per second.
    pub fn line(&self, pieces: &[u32], now: DoubleTime) -> (f64, f64) {
        match pieces[self.piece] {
            0 => (self.constant, 0.0),
            at => {
                let knot = &self.signal.knots[at as usize - 1];
                let value = knot.value_at(now.high) + knot.slope * now.low;
                (value + self.constant, knot.slope)
            }
        }
    }
}
