//! Modal masses from the driving-point residue.

use super::transfer::function::TransferFunction;
use crate::numeric::Complex;

/// The modal mass of a mode by the residue of a driving point, `R = φ_d²/(2i ω_d m)`, force over acceleration in the units of the function;
/// complex for complex shapes, real where damping is proportional. None where the function has no pole above the real axis near the mode.
///
/// `shape` is the component of the mode at the point; `derivative` counts how often the motion was differentiated. Source: Ewins, Modal
/// Testing, 2nd ed. (2000), §2.8 and §4.6.
pub fn modal_mass(
    pole: Complex,
    shape: Complex,
    function: &TransferFunction,
    derivative: u8,
) -> Option<Complex> {
    let poles = function.poles().iter().zip(function.residues());
    let apart = |p: &Complex| (p - pole).norm();
    let (own, residue) = poles.min_by(|a, b| apart(a.0).total_cmp(&apart(b.0)))?;
    let receptance = residue / own.powi(i32::from(derivative));
    let mass = shape * shape / (Complex::new(0.0, 2.0 * own.im) * receptance);
    (own.im > 0.0 && mass.norm().is_finite()).then_some(mass)
}
