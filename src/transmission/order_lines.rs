//! Order lines at the output: order `n i`, amplitude `Σ_b T_b gain_b a`.
//!
//! `TE = Σ A cos(o φ + ψ)`, φ the angle of the output in its sense of rotation, positive where the output leads.

use super::chain::TransmissionChain;
use crate::machine::components::{ErrorAction, FlankTransfer, GeometricError, Machine};
use crate::machine::operating_point::{ActiveFlank, OperatingPoint};
use crate::numeric::Complex;
use crate::numeric::fraction::Fraction;

/// Origin of an order line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineOrigin {
    /// Declared error, by its index in the machine.
    Declared(usize),
    /// Varying stiffness of a loaded mesh, by its branch.
    Stiffness(usize),
}

/// Order line: one harmonic of one source.
#[derive(Debug, Clone)]
pub struct OrderLine {
    /// Cycles per revolution of the output, or of the screw that moves it.
    pub order: Fraction,
    /// Origin of the line.
    pub origin: LineOrigin,
    /// Cycles per revolution of the element or the belt; of a stiffness, per tooth.
    pub harmonic: u32,
    /// Index of each branch, and its complex displacement e.
    pub displacements: Vec<(usize, Complex)>,
    /// Quasi-static A and ψ at the output with rigid joints, rad, of a slide m.
    pub quasi_static: Complex,
}

impl OrderLine {
    /// Declared error that causes the line.
    pub fn declared<'a>(&self, machine: &'a Machine) -> Option<&'a GeometricError> {
        match self.origin {
            LineOrigin::Declared(number) => machine.errors.get(number),
            LineOrigin::Stiffness(_) => None,
        }
    }

    /// True if the phase of the line is known.
    pub fn phase_known(&self, machine: &Machine) -> bool {
        self.declared(machine).is_none_or(|error| error.phase_known)
    }
}

/// Action of the error on the loaded flank.
fn flank_action(operating: &OperatingPoint, action: &ErrorAction) -> FlankTransfer {
    action.flanks[usize::from(operating.state(action.branch) == ActiveFlank::Coast)]
}

/// Periods of an error per revolution of the order reference, with sign; absent if its shaft does not turn with the output.
pub fn periods_per_turn(chain: &TransmissionChain, error: &GeometricError) -> Option<Fraction> {
    let ratio = chain.ratio(error.rotation_dof)?;
    let carrier = match error.carrier {
        Some(carrier) => chain.ratio(carrier)?.clone(),
        None => Fraction::zero(),
    };
    Some(&(ratio - &carrier) * &Fraction::new(error.periods_per_rev.0, error.periods_per_rev.1))
}

/// +1 if a pattern of signed `order` advances while the order reference turns in its sense of rotation, −1 if it recedes.
pub fn angle_sense(chain: &TransmissionChain, order: &Fraction) -> f64 {
    chain.reference_sense() * if order.is_negative() { -1.0 } else { 1.0 }
}

/// Rounding of tabulated errors, m or rad: cumulative sums of pitch deviations of micrometres.
const TABLE_ROUNDING: f64 = 1e-18;

/// Rounding of the harmonics of a table, relative to its largest value.
const RELATIVE_ROUNDING: f64 = 1e-14;

/// Order lines of all harmonics of the declared errors, by rising order. Errors of shafts at rest give no line.
pub fn order_lines(
    machine: &Machine,
    operating: &OperatingPoint,
    chain: &TransmissionChain,
) -> Vec<OrderLine> {
    let mut lines = Vec::new();
    for (index, error) in machine.errors.iter().enumerate() {
        let Some(order) = periods_per_turn(chain, error).filter(|order| !order.is_zero()) else {
            continue;
        };
        let sense = angle_sense(chain, &order);
        // Without loads a mesh has no stiffness lines, so its error is that at the mean stiffness.
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
                order: order.abs().times(harmonic),
                origin: LineOrigin::Declared(index),
                harmonic,
                displacements: Vec::new(),
                quasi_static: Complex::ZERO,
            };
            for action in &error.acts {
                let FlankTransfer { gain, phase: shift } = flank_action(operating, action);
                let angle = phase + f64::from(harmonic) * shift;
                let e = Complex::new(angle.cos(), sense * angle.sin()) * (-gain * amplitude);
                line.quasi_static += e * chain.transmission(action.branch);
                line.displacements.push((action.branch, e));
            }
            lines.push(line);
        }
    }
    lines.sort_by(|a, b| a.order.cmp(&b.order));
    lines
}

/// Tolerance of a loop condition relative to its terms, for the rounding of amplitudes and phases.
const COMPATIBILITY_TOLERANCE: f64 = 1e-9;

/// True if the line satisfies the loop conditions, so that rigid joints can turn.
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

/// Branches of the first loop condition that the errors violate with rigid joints.
///
/// Each order must satisfy the condition separately; several lines of unknown phase violate it.
pub fn incompatible_loop(
    machine: &Machine,
    chain: &TransmissionChain,
    lines: &[OrderLine],
) -> Option<Vec<usize>> {
    for condition in &chain.loop_conditions {
        let mut start = 0;
        while start < lines.len() {
            let end = start
                + lines[start..]
                    .iter()
                    .take_while(|l| l.order == lines[start].order)
                    .count();
            let (mut sum, mut size) = (Complex::ZERO, 0.0);
            let mut unknown = 0;
            for line in &lines[start..end] {
                let mut is_involved = false;
                for &(branch, c) in condition {
                    for (_, e) in line.displacements.iter().filter(|d| d.0 == branch) {
                        sum += *e * c;
                        size += c.abs() * e.norm();
                        is_involved = true;
                    }
                }
                unknown += usize::from(is_involved && !line.phase_known(machine));
            }
            if sum.norm() > COMPATIBILITY_TOLERANCE * size || unknown > 1 {
                return Some(condition.iter().map(|c| c.0).collect());
            }
            start = end;
        }
    }
    None
}
