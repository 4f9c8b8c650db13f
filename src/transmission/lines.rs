//! Lines at the end of the chain: an error with n cycles a turn of a shaft appears at the order `n |i|`, i turns of the shaft a turn
//! of the output, with the amplitude `|Σ_b T_b gain_b a|`; of a slide, i a turn of the screw that moves it.
//!
//! `TE = Σ A cos(o φ + ψ)`, φ the angle of the output in its own sense, positive where the output leads.

use super::chain::Chain;
use crate::machine::operating::{ContactState, Operating};
use crate::machine::parts::{Acting, FormError, Machine, Reach};
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;

/// Where a line comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Origin {
    /// A declared error, by its number in the machine.
    Declared(usize),
    /// The stiffness of a mesh changes over its cycle while it carries a torque; by its branch.
    Stiffness(usize),
}

/// One harmonic of one source.
#[derive(Debug, Clone)]
pub struct Line {
    /// Cycles per turn of the output, or of the screw that moves it.
    pub order: Fraction,
    /// Where it comes from.
    pub origin: Origin,
    /// Cycles per turn of the element, or of the belt; of a stiffness per tooth.
    pub harmonic: u32,
    /// What it does in each branch: number, and complex displacement e.
    pub displacements: Vec<(usize, Complex)>,
    /// A and ψ at the output, rad, of a slide m: slowly, with rigid joints.
    pub kinematic: Complex,
}

impl Line {
    /// The declared error it comes from.
    pub fn declared<'a>(&self, machine: &'a Machine) -> Option<&'a FormError> {
        match self.origin {
            Origin::Declared(number) => machine.errors.get(number),
            Origin::Stiffness(_) => None,
        }
    }

    /// Its phase is known.
    pub fn phase_known(&self, machine: &Machine) -> bool {
        self.declared(machine).is_none_or(|error| error.phase_known)
    }
}

/// How the error acts on the flank that carries.
fn on_flank(operating: &Operating, act: &Acting) -> Reach {
    act.flanks[usize::from(operating.state(act.branch) == ContactState::Coast)]
}

/// Turns of an error's period per turn that orders are counted by, with sign; absent where its shaft does not turn with the output.
pub fn pace(chain: &Chain, error: &FormError) -> Option<Fraction> {
    let own = chain.turns(error.turning)?;
    let carried = match error.carrier {
        Some(carrier) => chain.turns(carrier)?.clone(),
        None => Fraction::zero(),
    };
    Some(&(own - &carried) * &Fraction::new(error.pace.0, error.pace.1))
}

/// +1 where a pattern of that pace is run through forward while what orders are counted by turns in its own sense, −1 where backward.
pub fn rising(chain: &Chain, pace: &Fraction) -> f64 {
    chain.forward() * if pace.is_negative() { -1.0 } else { 1.0 }
}

/// Rounding of tables, m or rad: of pitches of micrometres added up.
const ROUNDING: f64 = 1e-18;

/// Rounding of the harmonics of a table, of its largest value.
const RELATIVE: f64 = 1e-14;

/// Every harmonic of every declared error, by rising order. Errors of shafts that stand still give no line.
pub fn lines(machine: &Machine, operating: &Operating, chain: &Chain) -> Vec<Line> {
    let mut lines = Vec::new();
    for (number, error) in machine.errors.iter().enumerate() {
        let Some(pace) = pace(chain, error).filter(|pace| !pace.is_zero()) else {
            continue;
        };
        let rising = rising(chain, &pace);
        let size = error.shape.greatest().abs().max(error.shape.least().abs());
        for (harmonic, amplitude, phase) in error.shape.harmonics() {
            if amplitude <= ROUNDING.max(RELATIVE * size) {
                continue;
            }
            let mut line = Line {
                order: pace.abs().times(harmonic),
                origin: Origin::Declared(number),
                harmonic,
                displacements: Vec::new(),
                kinematic: Complex::ZERO,
            };
            for act in &error.acts {
                let Reach { gain, turn } = on_flank(operating, act);
                let angle = phase + f64::from(harmonic) * turn;
                let e = Complex::new(angle.cos(), rising * angle.sin()) * (-gain * amplitude);
                line.kinematic += e * chain.transmission(act.branch);
                line.displacements.push((act.branch, e));
            }
            lines.push(line);
        }
    }
    lines.sort_by(|a, b| a.order.cmp(&b.order));
    lines
}

/// Of the terms of a condition: what is left of a fit is rounding of amplitudes and phases.
const FITS: f64 = 1e-9;

/// Rigid joints can turn with this line alone: it satisfies what their loops ask for.
pub fn fits(chain: &Chain, line: &Line) -> bool {
    chain.conditions.iter().all(|condition| {
        let (mut sum, mut size) = (Complex::ZERO, 0.0);
        for &(branch, c) in condition {
            for (_, e) in line.displacements.iter().filter(|d| d.0 == branch) {
                sum += *e * c;
                size += c.abs() * e.norm();
            }
        }
        sum.norm() <= FITS * size
    })
}

/// Where rigid loops stand against the errors: the first condition that these break, with the branches it ties together.
///
/// Each order must satisfy it by itself; unknown phases never do.
pub fn misfit(machine: &Machine, chain: &Chain, lines: &[Line]) -> Option<Vec<usize>> {
    for condition in &chain.conditions {
        let mut at = 0;
        while at < lines.len() {
            let end = at
                + lines[at..]
                    .iter()
                    .take_while(|l| l.order == lines[at].order)
                    .count();
            let (mut sum, mut size) = (Complex::ZERO, 0.0);
            let mut unknown = 0;
            for line in &lines[at..end] {
                let mut touched = false;
                for &(branch, c) in condition {
                    for (_, e) in line.displacements.iter().filter(|d| d.0 == branch) {
                        sum += *e * c;
                        size += c.abs() * e.norm();
                        touched = true;
                    }
                }
                unknown += usize::from(touched && !line.phase_known(machine));
            }
            if sum.norm() > FITS * size || unknown > 1 {
                return Some(condition.iter().map(|c| c.0).collect());
            }
            at = end;
        }
    }
    None
}
