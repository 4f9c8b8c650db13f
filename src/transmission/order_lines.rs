//! Order lines at the output: order `n i`, amplitude `Σ_b T_b gain_b a`.
//!
//! `TE = Σ A cos(o φ + ψ)`, φ the angle of the output in its own sense, positive where the output leads.

use super::chain::TransmissionChain;
use crate::machine::components::{ErrorAction, FlankTransfer, GeometricError, Machine};
use crate::machine::operating_point::{ActiveFlank, OperatingPoint};
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;

/// Origin of an order line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineOrigin {
    /// A declared error, by its number in the machine.
    Declared(usize),
    /// The stiffness of a mesh changes over its cycle while it carries a torque; by its branch.
    Stiffness(usize),
}

/// One harmonic of one source.
#[derive(Debug, Clone)]
pub struct OrderLine {
    /// Cycles per turn of the output, or of the screw that moves it.
    pub order: Fraction,
    /// Origin of the line.
    pub origin: LineOrigin,
    /// Cycles per turn of the element, or of the belt; of a stiffness per tooth.
    pub harmonic: u32,
    /// Displacement in each branch: number, and complex displacement e.
    pub displacements: Vec<(usize, Complex)>,
    /// A and ψ at the output, rad, of a slide m: slowly, with rigid joints.
    pub quasi_static: Complex,
}

impl OrderLine {
    /// The declared error it comes from.
    pub fn declared<'a>(&self, machine: &'a Machine) -> Option<&'a GeometricError> {
        match self.origin {
            LineOrigin::Declared(number) => machine.errors.get(number),
            LineOrigin::Stiffness(_) => None,
        }
    }

    /// True where the phase of the line is known.
    pub fn phase_known(&self, machine: &Machine) -> bool {
        self.declared(machine).is_none_or(|error| error.phase_known)
    }
}

/// Action of the error on the loaded flank.
fn flank_action(operating: &OperatingPoint, act: &ErrorAction) -> FlankTransfer {
    act.flanks[usize::from(operating.state(act.branch) == ActiveFlank::Coast)]
}

/// Turns of an error's period per turn that orders are counted by, with sign; absent where its shaft does not turn with the output.
pub fn periods_per_turn(chain: &TransmissionChain, error: &GeometricError) -> Option<Fraction> {
    let own = chain.ratio(error.rotation_dof)?;
    let carried = match error.carrier {
        Some(carrier) => chain.ratio(carrier)?.clone(),
        None => Fraction::zero(),
    };
    Some(&(own - &carried) * &Fraction::new(error.periods_per_rev.0, error.periods_per_rev.1))
}

/// +1 where a pattern of that pace is run through forward while what orders are counted by turns in its own sense, −1 where backward.
pub fn angle_sense(chain: &TransmissionChain, pace: &Fraction) -> f64 {
    chain.reference_sense() * if pace.is_negative() { -1.0 } else { 1.0 }
}

/// Rounding of tables, m or rad: of pitches of micrometres added up.
const TABLE_ROUNDING: f64 = 1e-18;

/// Rounding of the harmonics of a table, of its largest value.
const RELATIVE_ROUNDING: f64 = 1e-14;

/// Every harmonic of every declared error, by rising order. Errors of shafts that stand still give no line.
pub fn order_lines(
    machine: &Machine,
    operating: &OperatingPoint,
    chain: &TransmissionChain,
) -> Vec<OrderLine> {
    let mut lines = Vec::new();
    for (number, error) in machine.errors.iter().enumerate() {
        let Some(pace) = periods_per_turn(chain, error).filter(|pace| !pace.is_zero()) else {
            continue;
        };
        let rising = angle_sense(chain, &pace);
        // Without loads nothing gives way over the cycle of a mesh, and its error is that under its torque.
        let waveform = match &error.averaged {
            Some(averaged) if machine.loads.is_empty() => averaged,
            _ => &error.waveform,
        };
        let size = waveform.max().abs().max(waveform.lower_bound().abs());
        for (harmonic, amplitude, phase) in waveform.harmonics() {
            if amplitude <= TABLE_ROUNDING.max(RELATIVE_ROUNDING * size) {
                continue;
            }
            let mut line = OrderLine {
                order: pace.abs().times(harmonic),
                origin: LineOrigin::Declared(number),
                harmonic,
                displacements: Vec::new(),
                quasi_static: Complex::ZERO,
            };
            for act in &error.acts {
                let FlankTransfer { gain, phase: turn } = flank_action(operating, act);
                let angle = phase + f64::from(harmonic) * turn;
                let e = Complex::new(angle.cos(), rising * angle.sin()) * (-gain * amplitude);
                line.quasi_static += e * chain.transmission(act.branch);
                line.displacements.push((act.branch, e));
            }
            lines.push(line);
        }
    }
    lines.sort_by(|a, b| a.order.cmp(&b.order));
    lines
}

/// Tolerance relative to the terms of a condition: a fit leaves the rounding of amplitudes and phases.
const COMPATIBILITY_TOLERANCE: f64 = 1e-9;

/// Rigid joints can turn with this line alone: it satisfies what their loops ask for.
pub fn is_compatible(chain: &TransmissionChain, line: &OrderLine) -> bool {
    chain.loop_conditions.iter().all(|condition| {
        let (mut sum, mut size) = (Complex::ZERO, 0.0);
        for &(branch, c) in condition {
            for (_, e) in line.displacements.iter().filter(|d| d.0 == branch) {
                sum += *e * c;
                size += c.abs() * e.norm();
            }
        }
        sum.norm() <= COMPATIBILITY_TOLERANCE * size
    })
}

/// First loop condition that the errors violate where joints are rigid, with the branches it ties together.
///
/// Each order must satisfy it by itself; unknown phases never do.
pub fn incompatible_loop(
    machine: &Machine,
    chain: &TransmissionChain,
    lines: &[OrderLine],
) -> Option<Vec<usize>> {
    for condition in &chain.loop_conditions {
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
            if sum.norm() > COMPATIBILITY_TOLERANCE * size || unknown > 1 {
                return Some(condition.iter().map(|c| c.0).collect());
            }
            at = end;
        }
    }
    None
}
